//! `relief info`: what an elevation file holds.

use std::path::Path;

use serde::Serialize;

use super::args::InfoArgs;
use super::failure::{Exit, Failure};
use super::print;
use super::rounded::{degrees, metres, number, place};
use super::terrain::Source;
use crate::heightfield::Loaded;
use crate::heightfield::import::{PixelIs, VerticalUnit};

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let loaded = Source::File { path: args.file.clone(), scene: None }.load(&args.open.options())?;
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
    /// Share of the samples that hold no height.
    nodata_fraction: f64,
    crs: Option<&'a str>,
    /// Where columns and rows differ, the geometric mean.
    metres_per_sample: Option<f64>,
    /// West–east and north–south.
    extent_metres: Option<[f64; 2]>,
    format: &'a str,
    compression: Option<&'a str>,
    /// Columns and rows of the file, of which a part or means may have been taken.
    file_size: [u32; 2],
    /// What the file measures heights in.
    vertical_unit: Option<&'a str>,
    /// West, south, east, north of the outermost samples, in the units of `crs`.
    bounds: Option<[f64; 4]>,
    /// The same in degrees, where it is known how to find them.
    geographic_bounds: Option<[f64; 4]>,
    pixel_is: Option<PixelIs>,
    warnings: &'a [String],
}

impl<'a> Info<'a> {
    fn of(loaded: &'a Loaded) -> Self {
        let field = &loaded.field;
        let (width, height) = (field.width(), field.height());
        let [min, max] = field.range();
        let extent_metres = field.extent_metres();
        let cells = f64::from(width.max(2) - 1) * f64::from(height.max(2) - 1);
        let place = loaded.georeference.as_ref();
        let sidecar = loaded.sidecar.as_ref();
        Self {
            width,
            height,
            sample_type: loaded.sample_type,
            min,
            max,
            nodata_fraction: loaded.nodata_fraction,
            crs: place.and_then(|place| place.crs.as_deref()).or(sidecar.and_then(|sidecar| sidecar.crs.as_deref())),
            metres_per_sample: extent_metres.map(|[east, south]| (east * south / cells).sqrt()),
            extent_metres,
            format: loaded.format.name(),
            compression: loaded.compression.as_deref(),
            file_size: loaded.taken.full,
            vertical_unit: loaded.vertical_unit.map(VerticalUnit::name),
            bounds: place.map(|place| place.bounds([width, height])),
            geographic_bounds: place.and_then(|place| place.geographic_bounds([width, height])),
            pixel_is: place.map(|place| place.pixel),
            warnings: &loaded.warnings,
        }
    }

    fn text(&self, file: &Path, title: Option<&str>) -> String {
        let unknown = || String::from("unknown");
        let has_metres = self.vertical_unit.is_some() || self.extent_metres.is_some();
        let compression = self.compression.map_or_else(String::new, |packed| format!(", {packed}"));
        let mut rows = vec![
            ("file", file.display().to_string()),
            ("title", title.map_or_else(unknown, str::to_owned)),
            ("format", format!("{}{compression}", self.format)),
            ("samples", format!("{} × {}, {}", self.width, self.height, self.sample_type)),
            ("heights", format!("{} to {}{}", number(self.min), number(self.max), if has_metres { " m" } else { "" })),
            (
                "extent",
                self.extent_metres
                    .map_or_else(unknown, |[x, z]| format!("{} west–east, {} north–south", metres(x), metres(z))),
            ),
            ("per sample", self.metres_per_sample.map_or_else(unknown, metres)),
            ("crs", self.crs.map_or_else(unknown, str::to_owned)),
            ("nodata", percent(self.nodata_fraction)),
        ];
        if self.file_size != [self.width, self.height] {
            rows.push(("of", format!("{} × {} samples in the file", self.file_size[0], self.file_size[1])));
        }
        if let Some([west, south, east, north]) = self.bounds {
            let [west, east, south, north] = [(west, east), (east, west), (south, north), (north, south)].map(place);
            let unit = if has_degrees(self.crs, self.bounds, self.geographic_bounds) { "°" } else { "" };
            rows.push(("x, y", format!("{west}{unit} to {east}{unit}, {south}{unit} to {north}{unit}")));
        }
        if let Some([west, south, east, north]) = self.geographic_bounds {
            let [west, east, south, north] = [west, east, south, north].map(degrees);
            rows.push(("degrees", format!("{west} to {east} east, {south} to {north} north")));
        }
        rows.iter().map(|(name, value)| format!("{name:<11}{value}\n")).collect()
    }
}

/// A share as percent; what is little but not nothing does not become 0.
fn percent(share: f64) -> String {
    match share * 100.0 {
        0.0 => "none".to_owned(),
        little if little < 0.001 => "less than 0.001 %".to_owned(),
        percent => format!("{percent:.3} %"),
    }
}

/// Whether the coordinates are degrees themselves.
fn has_degrees(crs: Option<&str>, bounds: Option<[f64; 4]>, geographic: Option<[f64; 4]>) -> bool {
    crs.is_some() && bounds.is_some() && bounds == geographic
}
