//! `relief info`: what a height map holds.

use std::path::Path;

use serde::Serialize;

use super::args::InfoArgs;
use super::failure::{Exit, Failure};
use super::print;
use super::terrain::Source;
use crate::heightfield::Loaded;

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let loaded = Source::File { path: args.file.clone(), scene: None }.load()?;
    let info = Info::of(&loaded);
    if args.json {
        let json = serde_json::to_string_pretty(&info).map_err(|error| {
            Failure::new(Exit::Failed, "cannot write the description as JSON").line(error.to_string())
        })?;
        print(&format!("{json}\n"))
    } else {
        print(&info.text(&args.file, loaded.title.as_deref()))
    }
}

/// What `--json` prints; the names are a contract.
#[derive(Debug, Serialize)]
struct Info<'a> {
    width: u32,
    height: u32,
    sample_type: &'a str,
    /// Lowest and highest height in metres where the map has a unit, else in the source's own numbers.
    min: f64,
    max: f64,
    /// Share of the samples that hold no height; a PNG cannot say.
    nodata_fraction: f64,
    crs: Option<&'a str>,
    /// Where columns and rows differ, the geometric mean.
    metres_per_sample: Option<f64>,
    /// West–east and north–south.
    extent_metres: Option<[f64; 2]>,
}

impl<'a> Info<'a> {
    fn of(loaded: &'a Loaded) -> Self {
        let field = &loaded.field;
        let (width, height) = (field.width(), field.height());
        let [min, max] = field.range();
        let extent_metres = field.extent_metres();
        let cells = f64::from(width.max(2) - 1) * f64::from(height.max(2) - 1);
        Self {
            width,
            height,
            sample_type: loaded.sample_type,
            min,
            max,
            nodata_fraction: 0.0,
            crs: loaded.sidecar.as_ref().and_then(|sidecar| sidecar.crs.as_deref()),
            metres_per_sample: extent_metres.map(|[east, south]| (east * south / cells).sqrt()),
            extent_metres,
        }
    }

    fn text(&self, file: &Path, title: Option<&str>) -> String {
        let unknown = || String::from("unknown");
        let rows = [
            ("file", file.display().to_string()),
            ("title", title.map_or_else(unknown, str::to_owned)),
            ("samples", format!("{} × {}, {}", self.width, self.height, self.sample_type)),
            (
                "heights",
                format!("{} to {}{}", self.min, self.max, if self.extent_metres.is_some() { " m" } else { "" }),
            ),
            (
                "extent",
                self.extent_metres.map_or_else(unknown, |[x, z]| format!("{x:.0} m west–east, {z:.0} m north–south")),
            ),
            ("per sample", self.metres_per_sample.map_or_else(unknown, |metres| format!("{metres:.3} m"))),
            ("crs", self.crs.map_or_else(unknown, str::to_owned)),
            ("nodata", format!("{} %", self.nodata_fraction * 100.0)),
        ];
        rows.iter().map(|(name, value)| format!("{name:<11}{value}\n")).collect()
    }
}
