//! The stress report as CSV, JSON and Markdown.

use std::fmt::Write;

use super::{CaseReport, StressReport, StressRow};
use crate::report::tables::{self, csv_errors, csv_text, digits, escape, short};
use crate::scene::Technique;

/// The columns of `stress.csv`: those of the report with the case in front. Pictures, times and memory are not measured
/// here; their cells are empty.
pub fn columns() -> String {
    format!("case,{}", tables::COLUMNS)
}

/// One line per case and technique.
pub fn csv(report: &StressReport) -> String {
    let mut text = columns() + "\n";
    for (case, row) in report.cases.iter().flat_map(|case| case.rows.iter().map(move |row| (case, row))) {
        let mut cells = vec![csv_text(&case.name), csv_text(&case.view)];
        cells.extend(csv_errors(&row.setting, &row.figures));
        cells.extend([const { String::new() }; 4]);
        cells.extend([digits(row.steps_mean), row.steps_max.to_string(), row.cap_hits.to_string()]);
        cells.extend([const { String::new() }; 2]);
        text += &(cells.join(",") + "\n");
    }
    text
}

/// Everything but the pictures, as JSON.
///
/// # Errors
/// None that a report can cause.
pub fn json(report: &StressReport) -> serde_json::Result<Vec<u8>> {
    let mut json = serde_json::to_vec_pretty(report)?;
    json.push(b'\n');
    Ok(json)
}

/// The report as it is read.
pub fn markdown(report: &StressReport) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_markdown(&mut text, report);
    text
}

fn write_markdown(out: &mut String, report: &StressReport) -> std::fmt::Result {
    writeln!(out, "# Stiff and extreme cases\n")?;
    if let Some(reason) = &report.stopped {
        writeln!(out, "**Not finished:** {}. What was measured until then is here.\n", reason.replace('\n', " "))?;
    }
    let [width, height] = report.size;
    writeln!(
        out,
        "{}, {}; {}. Pictures of {width}×{height} pixels where a case has no size of its own.{}\n",
        escape(&report.adapter),
        escape(&report.driver),
        escape(&report.machine),
        if report.quick { " This is the quick form: smaller maps, fewer views." } else { "" }
    )?;
    write_promise(out, report)?;
    write_bound(out, report)?;
    write_others(out, report)?;
    write_cases(out, report)?;
    write_checks(out, report)?;
    if !report.left_out.is_empty() {
        writeln!(out, "\n## Left out\n")?;
        report.left_out.iter().try_for_each(|what| writeln!(out, "- {what}"))?;
    }
    Ok(())
}

/// Whether the exact technique kept its promise.
fn write_promise(out: &mut String, report: &StressReport) -> std::fmt::Result {
    let sum = |of: fn(&CaseReport) -> u64| report.cases.iter().map(of).sum::<u64>();
    let (pixels, hits) = (sum(|case| case.judgement.pixels), sum(|case| case.judgement.hits));
    writeln!(out, "## What `max-mipmap` promises\n")?;
    writeln!(
        out,
        "Over {} cases with {pixels} pixels, {hits} of them ground: **{} missed, {} invented, {} astray, {} without a \
         number, {} cut off by the step cap**; {} pixels differ inside the tangency band.",
        report.cases.len(),
        sum(|case| case.judgement.missed),
        sum(|case| case.judgement.invented),
        sum(|case| case.judgement.astray),
        sum(|case| case.judgement.nan),
        sum(|case| case.rows.iter().filter(|row| exact(row)).map(|row| u64::from(row.cap_hits)).sum()),
        sum(|case| case.judgement.tangent),
    )?;
    let worst = report.cases.iter().max_by(|a, b| a.judgement.ratio.total_cmp(&b.judgement.ratio));
    if let Some(worst) = worst {
        writeln!(
            out,
            "The largest displacement is {} of its bound, in `{}`.",
            short(worst.judgement.ratio),
            escape(&worst.name)
        )?;
    }
    writeln!(
        out,
        "\n*Missed*: the reference hits, the technique shows sky; *invented*: the reverse; *astray*: the distance differs \
         by more than a ray explains that is displaced within the bound derived in `src/report/stress/bound.rs`. A pixel is \
         in the *tangency band* where a ray displaced within that bound, or by a thousandth of a pixel, meets what the \
         technique found: along a silhouette, or in a side of the box, either is right. On `contact-sheet.png` an amber frame \
         marks where all wrong pixels of `max-mipmap` lie inside that band, with their number, and a red one where the promise \
         is broken."
    )?;
    let failures = report.failures();
    if failures.is_empty() {
        writeln!(out, "\nThe promise is kept in all that was measured.")
    } else {
        writeln!(out, "\n**Broken:**\n")?;
        failures.iter().try_for_each(|failure| writeln!(out, "- {}", escape(failure)))
    }
}

fn exact(row: &StressRow) -> bool {
    row.setting.technique == Technique::MaxMipmap
}

fn write_bound(out: &mut String, report: &StressReport) -> std::fmt::Result {
    if report.bound.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n## The bound\n\n![Largest displacement beside the bound](stress-bound.svg)\n")?;
    writeln!(
        out,
        "How far the found point lies off the ground, square to it, as a share of the map, at most over the pixels, beside \
         the largest bound of a pixel. It is taken from where the ray enters the neighbourhood of the box: the distance itself is \
         an f32, which from far away says less.\n"
    )?;
    writeln!(
        out,
        "| map | eye | displacement | bound | largest ratio | largest error (cells) | missed | invented | tangent |"
    )?;
    writeln!(out, "|---:|---:|---:|---:|---:|---:|---:|---:|---:|")?;
    for point in &report.bound {
        let judged = &point.judgement;
        writeln!(
            out,
            "| {0}×{0} | {1:e} | {2} | {3} | {4} | {5} | {6} | {7} | {8} |",
            point.side,
            point.distance,
            short(judged.displacement),
            short(judged.bound),
            short(judged.ratio),
            short(judged.error),
            judged.missed,
            judged.invented,
            judged.tangent
        )?;
    }
    Ok(())
}

/// A technique is broken by a case where more of the pixels are wrong than a picture hides, in %.
const BROKEN: f64 = 0.1;
/// Cases that are named for each technique.
const WORST: usize = 8;

/// Which cases break which of the other techniques.
fn write_others(out: &mut String, report: &StressReport) -> std::fmt::Result {
    writeln!(out, "\n## What breaks the others\n")?;
    writeln!(
        out,
        "A case breaks a technique where it has {BROKEN} % more wrong pixels than `max-mipmap`: seen through, covering sky, \
         or off by more than a cell, which from a million box lengths away is the rounding of any distance. Each has the \
         setting of the 2009 study: 128–512 steps by angle, 8 halvings where it halves. \
         `contact-sheet.png` shows it.\n"
    )?;
    for technique in Technique::ALL.into_iter().filter(|&technique| technique != Technique::MaxMipmap) {
        let rows = report.cases.iter().flat_map(|case| case.rows.iter().map(move |row| (case, row)));
        let own = rows.filter(|(_, row)| row.setting.technique == technique);
        let exacts = |case: &CaseReport| case.rows.iter().find(|row| exact(row)).map_or(0.0, |row| row.figures.wrong);
        let mut worse: Vec<_> = own.map(|(case, row)| (row.figures.wrong - exacts(case), case, &row.figures)).collect();
        let measured = worse.len();
        if measured == 0 {
            continue;
        }
        worse.retain(|(by, ..)| *by > BROKEN);
        worse.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
        writeln!(out, "- **`{}`**: {} of {measured} cases break it.", technique.name(), worse.len())?;
        for (by, case, figures) in worse.iter().take(WORST) {
            writeln!(
                out,
                "  - {}: {} % more wrong pixels ({} % seen through, {} % covering sky), p99 {} cells, at most {}",
                escape(&case.name),
                short(*by),
                short(figures.see_through),
                short(figures.covers_sky),
                short(figures.p99),
                short(figures.max)
            )?;
        }
    }
    Ok(())
}

fn write_cases(out: &mut String, report: &StressReport) -> std::fmt::Result {
    let others: Vec<_> = Technique::ALL.into_iter().filter(|&technique| technique != Technique::MaxMipmap).collect();
    writeln!(out, "\n## Cases\n")?;
    writeln!(
        out,
        "*ratio*: the largest displacement of `max-mipmap` over its bound; *error*: its largest distance error outside the \
         band, cells; then its pixels missed / invented / astray / in the band, its most steps, and the wrong pixels of the \
         others in %.\n"
    )?;
    let names: Vec<_> = others.iter().map(|technique| format!("`{}`", technique.name())).collect();
    writeln!(
        out,
        "| case | map | ratio | error | missed / invented / astray / band | steps | {} |",
        names.join(" | ")
    )?;
    writeln!(out, "|---|---|---:|---:|---:|---:|{}", "---:|".repeat(others.len()))?;
    for case in &report.cases {
        let judged = &case.judgement;
        let wrong = |technique: Technique| {
            let row = case.rows.iter().find(|row| row.setting.technique == technique);
            row.map_or_else(|| String::from("—"), |row| short(row.figures.wrong))
        };
        let wrong: Vec<_> = others.iter().map(|&technique| wrong(technique)).collect();
        writeln!(
            out,
            "| {} | {}×{} | {} | {} | {} / {} / {} / {} | {} | {} |",
            escape(&case.name),
            case.map_samples[0],
            case.map_samples[1],
            short(judged.ratio),
            short(judged.error),
            judged.missed,
            judged.invented,
            judged.astray,
            judged.tangent,
            case.rows.iter().find(|row| exact(row)).map_or(0, |row| row.steps_max),
            wrong.join(" | ")
        )?;
    }
    Ok(())
}

fn write_checks(out: &mut String, report: &StressReport) -> std::fmt::Result {
    if report.checks.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n## Without a picture\n")?;
    report.checks.iter().try_for_each(|check| match &check.failure {
        None => writeln!(out, "- {}: holds", check.name),
        Some(why) => writeln!(out, "- **{}: {}**", check.name, escape(why)),
    })
}
