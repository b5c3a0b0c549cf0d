//! `relief stress`: stiff and extreme cases.

use std::path::Path;

use super::args::StressArgs;
use super::failure::{Exit, Failure};
use super::output::{Output, make_folder};
use super::terrain;
use super::watch::Watch;
use crate::gpu::Gpu;
use crate::report::stress::{self, Job, StressReport, bound_plot, sheet, tables};
use crate::scene::Technique;

/// Size of the pictures, full and quick.
const SIZES: [[u32; 2]; 2] = [[320, 200], [64, 40]];
/// Broken promises that the message names.
const NAMED: usize = 5;

pub(crate) fn run(args: &StressArgs) -> Result<(), Failure> {
    let size = args.size.unwrap_or(SIZES[usize::from(args.quick)]);
    let job = Job { size, quick: args.quick, only: args.cases.clone(), exact: Technique::MaxMipmap };
    let names = stress::names(&job);
    for part in &args.cases {
        if !names.iter().any(|name| name.contains(part)) {
            return Err(Failure::usage(format!("there is no case with `{part}` in its name"))
                .line("--case takes a part of a name, as it is written there.")
                .line("`relief stress --list` prints the names; with --quick there are fewer."));
        }
    }
    if args.list {
        return super::print(&(names.join("\n") + "\n"));
    }
    let Some(folder) = &args.output else {
        return Err(Failure::usage("there is no folder to write to")
            .line("The cases leave tables and pictures.")
            .line("Name one with -o DIR."));
    };
    let gpu = Gpu::headless()?;
    terrain::check_size(size, gpu.capabilities.max_texture)?;
    let outputs = Outputs::prepare(folder, args.cases.is_empty())?;
    let report = {
        let watch = Watch::start();
        stress::measure(&gpu, &job, &watch)?
    };
    if report.cases.is_empty() {
        return Err(Failure::new(Exit::Failed, "nothing was measured")
            .line("It was stopped before the first case was compared.")
            .line("No file was written; let it run longer, or use --quick."));
    }
    outputs.write(&report)?;
    verdict(&report, folder)
}

/// The exit code and its message.
fn verdict(report: &StressReport, folder: &Path) -> Result<(), Failure> {
    let failures = report.failures();
    if !failures.is_empty() {
        let what = format!("max-mipmap broke its promise {} times", failures.len());
        let named = failures.iter().take(NAMED).fold(Failure::new(Exit::Failed, what), Failure::line);
        return Err(named.line(format!("All of them are in {}.", folder.join("stress.md").display())));
    }
    match &report.stopped {
        None => {
            let (cases, folder) = (report.cases.len(), folder.display());
            super::tell(&format!("max-mipmap kept its promise in all {cases} cases; see stress.md in {folder}"));
            Ok(())
        }
        Some(reason) => Err(Failure::new(Exit::Failed, "the cases are not finished")
            .line(reason.clone())
            .line(format!("What was measured until then is in {}.", folder.display()))),
    }
}

/// The files of a stress report.
struct Outputs {
    markdown: Output,
    csv: Output,
    json: Output,
    sheet: Output,
    /// The plot of the bound, as SVG and PNG; absent where the bound is not measured.
    bound: Option<[Output; 2]>,
}

impl Outputs {
    /// Makes the folder and checks that every file can be written.
    fn prepare(folder: &Path, bound: bool) -> Result<Self, Failure> {
        make_folder(folder)?;
        let output = |name: &str| Output::prepare(&folder.join(name));
        Ok(Self {
            markdown: output("stress.md")?,
            csv: output("stress.csv")?,
            json: output("stress.json")?,
            sheet: output("contact-sheet.png")?,
            bound: if bound { Some([output("stress-bound.svg")?, output("stress-bound.png")?]) } else { None },
        })
    }

    fn write(&self, report: &StressReport) -> Result<(), Failure> {
        let failed = |error: &dyn std::error::Error| {
            Failure::new(Exit::Failed, "cannot encode the stress report").line(error.to_string())
        };
        let sheet = sheet::png(report).map_err(|error| failed(&error))?;
        let json = tables::json(report).map_err(|error| failed(&error))?;
        let svg = bound_plot::svg(report);
        let png = bound_plot::png(&svg).map_err(|error| failed(&error))?;
        self.csv.write(tables::csv(report).as_bytes())?;
        self.json.write(&json)?;
        self.sheet.write(&sheet)?;
        if let Some([drawing, picture]) = self.bound.as_ref().filter(|_| !report.bound.is_empty()) {
            drawing.write(svg.as_bytes())?;
            picture.write(&png)?;
        }
        self.markdown.write(tables::markdown(report).as_bytes())
    }
}
