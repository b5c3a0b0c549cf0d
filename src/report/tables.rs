//! The report as CSV, JSON and Markdown.

use std::fmt::Write;

use super::settings::Setting;
use super::sweep::{Row, ViewReport};
use super::{Feature, Figures, Report};
use crate::scene::Technique;

/// The columns of `report.csv`; their names are a contract.
pub const COLUMNS: &str = "view,technique,samples_min,samples_max,by_angle,halvings,see_through,covers_sky,p50,p95,p99,\
    max,incoherent,flip,ms,ms_p95,ratio,steps_mean,steps_max,cap_hits,prepare_ms,bytes";

/// One line per view and setting. What a technique does not have, or what was not measured, is empty.
pub fn csv(report: &Report) -> String {
    let mut text = format!("{COLUMNS}\n");
    for view in &report.views {
        for row in &view.rows {
            text += &csv_row(&view.name, row);
        }
    }
    text
}

fn csv_row(view: &str, row: &Row) -> String {
    let Row { setting, figures, times, .. } = row;
    let number = |value: Option<f64>| value.map(digits).unwrap_or_default();
    let mut cells = vec![csv_text(view)];
    cells.extend(csv_errors(setting, figures));
    cells.extend([row.flip, times.map(|times| times.ms), times.map(|times| times.ms_p95), row.ratio].map(number));
    cells.extend([digits(row.steps_mean), row.steps_max.to_string(), row.cap_hits.to_string()]);
    cells.extend([digits(row.prepare_ms), row.bytes.to_string()]);
    cells.join(",") + "\n"
}

/// The cells from `technique` to `incoherent`.
pub(super) fn csv_errors(setting: &Setting, figures: &Figures) -> Vec<String> {
    let whole = |value: Option<u32>| value.map(|value| value.to_string()).unwrap_or_default();
    let errors = [figures.see_through, figures.covers_sky, figures.p50, figures.p95, figures.p99, figures.max];
    let mut cells = vec![
        setting.technique.name().to_owned(),
        whole(setting.samples.map(|samples| samples[0])),
        whole(setting.samples.map(|samples| samples[1])),
        setting.by_angle.map(|on| on.to_string()).unwrap_or_default(),
        whole(setting.halvings),
    ];
    cells.extend(errors.into_iter().chain([figures.incoherent]).map(digits));
    cells
}

/// A name as a cell: names of views come from names of files.
pub(super) fn csv_text(text: &str) -> String {
    if text.contains(['"', ',', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// Six significant digits, written out.
pub(super) fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// Everything, as JSON.
///
/// # Errors
/// None that a report can cause.
pub fn json(report: &Report) -> serde_json::Result<Vec<u8>> {
    let mut json = serde_json::to_vec_pretty(report)?;
    json.push(b'\n');
    Ok(json)
}

/// The report as it is read.
pub fn markdown(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_markdown(&mut text, report);
    text
}

fn write_markdown(out: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(out, "# Error against run time: {}\n", report.map)?;
    if let Some(reason) = &report.stopped {
        writeln!(out, "**Not finished:** {}. What was measured until then is here.\n", reason.replace('\n', " "))?;
    }
    write_setup(out, report)?;
    writeln!(out, "\n![Error against time](error-vs-time.svg)\n")?;
    write_standing(out, report)?;
    write_legend(out, report)?;
    for view in &report.views {
        write_view(out, view)?;
    }
    write_features(out, report)?;
    write_edits(out, report)?;
    writeln!(out, "\n## Left out\n")?;
    for what in &report.left_out {
        writeln!(out, "- {what}")?;
    }
    if report.quick {
        writeln!(out, "- `--quick`: steps other than 32, 128 and 512, and rounds beyond the fifth")?;
    }
    Ok(())
}

fn write_setup(out: &mut String, report: &Report) -> std::fmt::Result {
    let [x, y, z] = report.map_box;
    let clock = if report.timestamps {
        "the GPU's clock: end of the last pass less begin of the first"
    } else {
        "wall time from submitting to the end: there are no timestamps"
    };
    let rows = [
        ("machine", report.machine.clone()),
        ("adapter", report.adapter.clone()),
        ("driver", report.driver.clone()),
        ("map", format!("{}, {}×{} samples", report.map, report.map_samples[0], report.map_samples[1])),
        ("box", format!("{x:.4} × {y:.4} × {z:.4} world units (east, up, south); a cell is {:.3e}", report.cell)),
        ("pictures", format!("{}×{} pixels", report.size[0], report.size[1])),
        ("times", clock.to_owned()),
    ];
    writeln!(out, "| | |\n|---|---|")?;
    rows.iter().try_for_each(|(name, value)| writeln!(out, "| {name} | {} |", escape(value)))
}

/// Where the exact technique stands, in words.
fn write_standing(out: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(out, "## Where `max-mipmap` stands\n")?;
    for view in &report.views {
        let exact = view.rows.iter().find(|row| row.setting.technique == Technique::MaxMipmap);
        let Some((row, times)) = exact.and_then(|row| row.times.map(|times| (row, times))) else { continue };
        let others = || view.rows.iter().filter(|other| other.setting.technique != Technique::MaxMipmap);
        let faster = others().filter(|other| other.times.is_some_and(|theirs| theirs.ms <= times.ms));
        let best = |error: fn(&Row) -> f64| faster.clone().min_by(|a, b| error(a).total_cmp(&error(b)));
        let bests = best(|row| row.figures.p99).zip(best(|row| row.figures.wrong));
        let place = match (row.on_p99_front, row.on_wrong_front) {
            (true, true) => "on both fronts",
            (true, false) => "on the front of p99, not on that of wrong pixels",
            (false, true) => "on the front of wrong pixels, not on that of p99",
            (false, false) => "on neither front",
        };
        write!(
            out,
            "- **{}**: {place}, {} ms, p99 {} cells, {} % wrong pixels ({} % seen through, {} % covering sky). ",
            escape(&view.name),
            short(times.ms),
            short(row.figures.p99),
            short(row.figures.wrong),
            short(row.figures.see_through),
            short(row.figures.covers_sky)
        )?;
        let named = |row: &Row| {
            let (p99, wrong) = (short(row.figures.p99), short(row.figures.wrong));
            format!("`{}` {} (p99 {p99} cells, {wrong} % wrong)", row.setting.technique.name(), row.setting.words())
        };
        match bests {
            None => writeln!(out, "Nothing is as fast.")?,
            Some((p99, wrong)) if p99.setting == wrong.setting => writeln!(
                out,
                "{} settings are as fast or faster; the best of them is {}.",
                faster.clone().count(),
                named(p99)
            )?,
            Some((p99, wrong)) => writeln!(
                out,
                "{} settings are as fast or faster; of them {} has the smallest p99 and {} the fewest wrong pixels.",
                faster.clone().count(),
                named(p99),
                named(wrong)
            )?,
        }
    }
    writeln!(out)
}

fn write_legend(out: &mut String, report: &Report) -> std::fmt::Result {
    let base = format!("`{}` {}", Setting::BASE.technique.name(), Setting::BASE.words());
    writeln!(out, "## Views\n")?;
    writeln!(
        out,
        "Errors are against the f64 reference on the CPU, along the ray, over the pixels where both hit; percentiles by \
         nearest rank. *see-through*: the reference hits, the technique shows sky; *covers sky*: the reverse; \
         *incoherent*: specks that the reference has not (1 % off the median of 3×3); *wrong*: seen through, covering sky, \
         or off by more than a cell; all in % of all pixels. (A ray that touches a crest within the rounding of a pixel may \
         meet it or the ground behind, and either is right: that is what is *wrong* about `max-mipmap` now and then, as \
         `relief stress` shows.) *FLIP*: mean, against the same shading fed with the \
         reference's distances. *ratio*: to {base}. All settings of a view are timed in turn, one frame each, after a \
         warm-up; *rounds* is how many frames each had. *prepare*: from a new map to a first frame of one pixel, finding \
         cones included. **●** on \
         the Pareto front of (ms, p99), **◆** on that of (ms, wrong).{}",
        if report.quick { " This is a quick report: few settings, few rounds." } else { "" }
    )
}

fn write_view(out: &mut String, view: &ViewReport) -> std::fmt::Result {
    writeln!(out, "\n### {}\n", escape(&view.name))?;
    let [x, y, z] = view.camera.eye.to_array();
    let (yaw, pitch, fov) = (view.camera.yaw, view.camera.pitch, view.camera.fov);
    writeln!(out, "Eye {x:.4}, {y:.4}, {z:.4}; yaw {yaw:.2}°, pitch {pitch:.2}°, field of view {fov}°.\n")?;
    writeln!(
        out,
        "| front | technique | setting | see-through % | covers sky % | p50 | p95 | p99 | max (cells) | incoherent % | \
         wrong % | FLIP | ms | p95 | ratio | rounds | steps mean | max | cap hits | prepare ms | MiB |"
    )?;
    writeln!(out, "|---|---|---|{}", "---:|".repeat(18))?;
    for row in &view.rows {
        let Row { setting, figures, times, .. } = row;
        let marks = [(row.on_p99_front, "●"), (row.on_wrong_front, "◆")];
        let marks: String = marks.iter().filter_map(|&(on, mark)| on.then_some(mark)).collect();
        let mut cells = vec![marks, format!("`{}`", setting.technique.name()), setting.words()];
        cells.extend([figures.see_through, figures.covers_sky, figures.p50, figures.p95, figures.p99].map(short));
        cells.extend([figures.max, figures.incoherent, figures.wrong].map(short));
        let optional = |value: Option<f64>| value.map_or_else(|| String::from("—"), short);
        cells.extend([row.flip, times.map(|times| times.ms), times.map(|times| times.ms_p95), row.ratio].map(optional));
        cells.push(times.map_or(0, |times| times.rounds).to_string());
        cells.extend([short(row.steps_mean), row.steps_max.to_string(), row.cap_hits.to_string()]);
        cells.extend([short(row.prepare_ms), short(row.bytes as f64 / f64::from(1 << 20))]);
        writeln!(out, "| {} |", cells.join(" | "))?;
    }
    Ok(())
}

fn write_features(out: &mut String, report: &Report) -> std::fmt::Result {
    if !report.features.is_empty() {
        writeln!(out, "\n## The study's Table 1, remade\n")?;
        writeln!(
            out,
            "Time of a frame over that of one base frame: `{}` {}, exact heights, lit, no craters. The study of 2009 drew \
             1440×900 pixels on a GTX 275 at 40 to 300 frames a second; its craters, which are the layered ones here, took \
             40 % of the frames away. Its other ratios are not known to us.\n",
            Setting::BASE.technique.name(),
            Setting::BASE.words()
        )?;
        write_costs(out, &report.features, Some("3.3–25 ms"))?;
    }
    if !report.exact_features.is_empty() {
        writeln!(out, "\n## The same over a frame of the exact technique\n")?;
        writeln!(
            out,
            "Where a ray finds the ground soon, all else weighs the more: the same ratios over a frame of `{}`.\n",
            Technique::MaxMipmap.name()
        )?;
        write_costs(out, &report.exact_features, None)?;
    }
    Ok(())
}

/// A row per feature, the base frame's first; `base_in_2009` where there is a column for the study's figures.
fn write_costs(out: &mut String, features: &[Feature], base_in_2009: Option<&str>) -> std::fmt::Result {
    let Some((base, others)) = features.split_first() else { return Ok(()) };
    let row = |out: &mut String, name: &str, mut cells: Vec<String>, in_2009: &str| {
        cells.extend(base_in_2009.map(|_| in_2009.to_owned()));
        writeln!(out, "| {name} | {} |", cells.join(" | "))
    };
    row(out, "", base.views.iter().map(|cost| escape(&cost.view)).collect(), "2009")?;
    writeln!(out, "|---|{}", "---:|".repeat(base.views.len() + usize::from(base_in_2009.is_some())))?;
    let milliseconds = base.views.iter().map(|cost| format!("{} ms", short(cost.times.ms)));
    row(out, &base.name, milliseconds.collect(), base_in_2009.unwrap_or_default())?;
    for feature in others {
        let cell = |view: &str| {
            let cost = feature.views.iter().find(|cost| cost.view == view);
            cost.map_or_else(|| String::from("—"), |cost| format!("{:.2}×", cost.ratio))
        };
        let known = feature.in_2009.map_or_else(|| String::from("—"), |ratio| format!("{ratio:.2}×"));
        row(out, &feature.name, base.views.iter().map(|cost| cell(&cost.view)).collect(), &known)?;
    }
    Ok(())
}

fn write_edits(out: &mut String, report: &Report) -> std::fmt::Result {
    if report.edits.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n## After an edit\n")?;
    writeln!(
        out,
        "{} craters are dug, one after the other, two frames apart, or fewer where the frames after them take long. Wall \
         times; a first frame has the edit on the CPU, the search for new cones and the upload in it. The frame after the last crater against a scene that was built with all of them:\n",
        super::edit::CRATERS
    )?;
    writeln!(
        out,
        "| technique | craters | first frame ms | ordinary frame ms | ratio | largest difference of distance | pixels that differ |"
    )?;
    writeln!(out, "|---|---:|---:|---:|---:|---:|---:|")?;
    for edit in &report.edits {
        writeln!(
            out,
            "| `{}` | {} | {} | {} | {:.2}× | {} | {} |",
            edit.technique.name(),
            edit.craters,
            short(edit.first_frame.ms),
            short(edit.ordinary_frame.ms),
            edit.ratio,
            edit.distance_difference.map_or_else(|| String::from("ground against sky"), short),
            edit.differing_pixels
        )?;
    }
    Ok(())
}

/// Three significant digits.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if size == 0.0 => String::from("0"),
        _ if size < 1e-3 => format!("{value:.1e}"),
        _ if size < 1.0 => format!("{value:.3}"),
        _ if size < 10.0 => format!("{value:.2}"),
        _ if size < 100.0 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}

/// Text that a table's cell can hold.
pub(super) fn escape(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_what_matters() {
        assert_eq!(
            [0.0, 1.24e-7, 0.0125, 1.234, 12.34, 1234.6].map(short),
            ["0", "1.2e-7", "0.013", "1.23", "12.3", "1235"]
        );
        assert_eq!(
            [0.0, 1.2345678, 1.0 / 3.0e5, 123_456_789.0].map(digits),
            ["0", "1.23457", "0.00000333333", "123457000"]
        );
    }

    #[test]
    fn there_are_as_many_cells_as_columns() {
        let row = Row {
            setting: Setting::BASE,
            figures: Figures::default(),
            flip: None,
            times: None,
            ratio: None,
            steps_mean: 1.5,
            steps_max: 3,
            cap_hits: 0,
            prepare_ms: 2.0,
            bytes: 7,
            on_p99_front: false,
            on_wrong_front: false,
        };
        assert_eq!(csv_row("over", &row), "over,linear-binary,128,512,true,8,0,0,0,0,0,0,0,,,,,1.5,3,0,2,7\n");
        assert_eq!(csv_row("over", &row).split(',').count(), COLUMNS.split(',').count());
        assert!(csv_row("a,\"b", &row).starts_with("\"a,\"\"b\",linear"));
    }
}
