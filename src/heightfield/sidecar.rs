//! The sidecar: a TOML file beside a height map that says what it shows.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::field::EXTENT_RATIOS;
use super::import::{Georeference, ImportOptions, PixelIs, Taken, UnitText};
use super::{HEIGHT_SCALES, HeightField};

/// The tables of a scene file. A screenshot's scene has the stem of its picture, just as a sidecar would.
const SCENE_TABLES: [&str; 18] = [
    "terrain",
    "camera",
    "march",
    "compare",
    "diffuse",
    "land",
    "materials",
    "lighting",
    "skybox",
    "occluder",
    "craters",
    "detail",
    "debug",
    "air",
    "clouds",
    "flare",
    "water",
    "saved",
];

/// What a height map shows: the file with the map's stem and the ending `.toml`. Every key may be left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Sidecar {
    /// Name of the terrain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Metres on the ground between the outermost samples, west–east and north–south.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extent_metres: Option<[f64; 2]>,
    /// What the map's lowest sample stands for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lowest_metre: Option<f64>,
    /// What the map's highest sample stands for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_metre: Option<f64>,
    /// Coordinate reference system, as in "EPSG:3857".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crs: Option<String>,
    /// Metres on the ground from one sample to the next; gives the extent where `extent_metres` is absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metres_per_sample: Option<f64>,
    /// Where the elevation comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Under which terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub licence: Option<String>,
    /// Factor on the true proportion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical_exaggeration: Option<f64>,
    /// Coordinates of the first, north-western sample: x (east) and y (north), in the units of `crs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<[f64; 2]>,
    /// From column to column and from row to row in the units of `crs`; the second is below 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<[f64; 2]>,
    /// What the coordinates of `crs` are counted in, where its number does not say: "degree", "web-mercator", so many
    /// metres each, or "none" where they are no lengths, so that the map has no proportion of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) crs_unit: Option<UnitText>,
    /// What a sample stands for: the mean of an "area" around it, or the "point" it was measured at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel_is: Option<PixelIs>,
    /// How to open the map.
    #[serde(flatten)]
    pub import: ImportOptions,
    /// What the map was made from, where this program made it; read by [`super::generate::recipe_file::read`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recipe: Option<toml::Table>,
}

impl Sidecar {
    /// The keys that a sidecar may have.
    pub const KEYS: [&'static str; 27] = [
        "title",
        "extent_metres",
        "lowest_metre",
        "highest_metre",
        "crs",
        "metres_per_sample",
        "source",
        "licence",
        "vertical_exaggeration",
        "origin",
        "step",
        "crs_unit",
        "pixel_is",
        "raw_size",
        "raw_type",
        "raw_endian",
        "flip",
        "encoding",
        "nodata",
        "vertical_unit",
        "band",
        "variable",
        "holes",
        "reduce",
        "window",
        "too_large",
        "recipe",
    ];

    /// Where the sidecar of `map` is, if it has one.
    pub fn path_of(map: &Path) -> PathBuf {
        map.with_extension("toml")
    }

    /// Reads the sidecar of `map`. Whatever is wrong with it becomes a warning: the map opens all the same, and what
    /// is right in the sidecar holds. A scene file in its place is no sidecar, and not worth a word.
    pub(crate) fn read_for(map: &Path, warnings: &mut Vec<String>) -> Option<Self> {
        let path = Self::path_of(map);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
            Err(error) => {
                warnings.push(format!("{} was ignored: {error}; make it a readable text file", path.display()));
                return None;
            }
        };
        Self::parse(&text, &path, warnings)
    }

    /// The sidecar in `text`, which came from `path`; what is wrong with it becomes a warning.
    pub(super) fn parse(text: &str, path: &Path, warnings: &mut Vec<String>) -> Option<Self> {
        let table = text.parse::<toml::Table>();
        if table.as_ref().is_ok_and(is_scene) {
            return None;
        }
        let parsed = table.and_then(|mut table| {
            table.retain(|key, _| Self::is_known(key, path, warnings));
            Self::deserialize(table)
        });
        match parsed {
            Ok(mut sidecar) => {
                sidecar.drop_what_cannot_be(path, warnings);
                Some(sidecar)
            }
            Err(error) => {
                let reason = error.to_string().trim_end().replace('\n', " ");
                warnings.push(format!(
                    "{} was ignored: {reason}; correct it, or delete it to open the map as a plain image",
                    path.display()
                ));
                None
            }
        }
    }

    /// The text of the file that says this.
    ///
    /// # Errors
    /// The words of the encoder; no sidecar that was read or made here has any.
    pub fn to_toml(&self) -> Result<String, String> {
        toml::to_string(self).map_err(|error| error.to_string())
    }

    fn is_known(key: &str, path: &Path, warnings: &mut Vec<String>) -> bool {
        if Self::KEYS.contains(&key) {
            return true;
        }
        let nearest =
            Self::KEYS.into_iter().max_by(|a, b| strsim::jaro_winkler(key, a).total_cmp(&strsim::jaro_winkler(key, b)));
        let hint = nearest.map_or_else(String::new, |nearest| format!("; did you mean \"{nearest}\"?"));
        warnings.push(format!("{}: the key \"{key}\" is unknown and was ignored{hint}", path.display()));
        false
    }

    /// Drops numbers that no terrain can have, each with a warning.
    pub(super) fn drop_what_cannot_be(&mut self, path: &Path, warnings: &mut Vec<String>) {
        let mut warn = |what: &str| warnings.push(format!("{}: {what}", path.display()));
        let positive = |value: f64| value.is_finite() && value > 0.0;
        if self.extent_metres.is_some_and(|sides| !sides.into_iter().all(positive)) {
            warn("extent_metres was ignored: both sides must be finite and above 0");
            self.extent_metres = None;
        }
        if self.metres_per_sample.is_some_and(|value| !positive(value)) {
            warn("metres_per_sample was ignored: it must be finite and above 0");
            self.metres_per_sample = None;
        }
        if self.vertical_exaggeration.is_some_and(|value| !positive(value)) {
            warn("vertical_exaggeration was ignored: it must be finite and above 0; 1 is the true proportion");
            self.vertical_exaggeration = None;
        }
        let place = [self.origin, self.step].into_iter().flatten().flatten().all(f64::is_finite);
        if !place || self.step.is_some_and(|step| step.contains(&0.0)) || self.origin.is_some() != self.step.is_some() {
            warn("origin and step were ignored: give both, finite, and steps other than 0");
            (self.origin, self.step) = (None, None);
        }
        if matches!(self.crs_unit, Some(UnitText::Metres(metres)) if !positive(metres)) {
            warn("crs_unit was ignored: it must be finite and above 0");
            self.crs_unit = None;
        }
        if self.import.reduce == Some(0) {
            warn("reduce was ignored: it must be at least 1");
            self.import.reduce = None;
        }
        let range_is_sound = match (self.lowest_metre, self.highest_metre) {
            (Some(low), Some(high)) => low.is_finite() && high.is_finite() && low <= high,
            (None, None) => true,
            _ => false,
        };
        if !range_is_sound {
            warn("lowest_metre and highest_metre were ignored: give both, finite, the lowest first");
            (self.lowest_metre, self.highest_metre) = (None, None);
        }
    }

    /// Drops what would give the box of `field` a shape that cannot be drawn, each with a warning. `place` is the extent
    /// that the map has without the sidecar, `path` is the sidecar's.
    pub(super) fn drop_what_does_not_fit(
        &mut self,
        field: &HeightField,
        place: Option<[f64; 2]>,
        path: &Path,
        warnings: &mut Vec<String>,
    ) {
        let mut warn = |what: String| warnings.push(format!("{}: {what}", path.display()));
        if self.extent_of(field.cells()).is_some_and(|extent| !HeightField::is_extent(extent)) {
            let (least, most) = (EXTENT_RATIOS.start(), EXTENT_RATIOS.end());
            warn(format!(
                "extent_metres and metres_per_sample were ignored: west–east over north–south must be {least} to {most}"
            ));
            (self.extent_metres, self.metres_per_sample) = (None, None);
        }
        let extent = self.extent_of(field.cells()).or(place);
        if extent.is_none() && self.range().is_some_and(|[low, high]| !(high - low).is_finite()) {
            warn(format!("lowest_metre and highest_metre were ignored: they must be less than {:e} apart", f64::MAX));
            (self.lowest_metre, self.highest_metre) = (None, None);
        }
        let placed = |range: Option<[f64; 2]>, exaggeration: Option<f64>| {
            let (range, exaggeration) = (range.unwrap_or(field.range()), exaggeration.unwrap_or(1.0));
            HeightField::proportion(extent, range) * exaggeration
        };
        let fits = |scale: f64| HEIGHT_SCALES.contains(&scale);
        let scale = placed(self.range(), self.vertical_exaggeration);
        if fits(scale) {
            return;
        }
        let allowed = format!(
            "the terrain's height over its longer side would be {scale:e}, but must be {} to {}",
            HEIGHT_SCALES.start(),
            HEIGHT_SCALES.end()
        );
        if self.vertical_exaggeration.take().is_some() && fits(placed(self.range(), None)) {
            warn(format!("vertical_exaggeration was ignored: {allowed}"));
            return;
        }
        warn(format!("the extent, the heights and vertical_exaggeration were ignored: {allowed}"));
        (self.extent_metres, self.metres_per_sample) = (None, None);
        (self.lowest_metre, self.highest_metre) = (None, None);
    }

    /// Makes the extent and the step, which are those of the whole file, those of the part that was taken.
    pub(super) fn of_part(&mut self, taken: &Taken) {
        let factor = f64::from(taken.factor);
        let size = taken.size();
        self.metres_per_sample = self.metres_per_sample.map(|step| step * factor);
        self.extent_metres = self.extent_metres.map(|extent| {
            [0, 1].map(|axis| {
                let cells = |count: u32| f64::from(count.max(2) - 1);
                extent[axis] * factor * cells(size[axis]) / cells(taken.full[axis])
            })
        });
    }

    /// Where the map lies, as far as `origin`, `step` and `crs` say.
    pub(super) fn georeference(&self) -> Option<Georeference> {
        let place = Georeference::new(self.origin?, self.step?);
        let place = Georeference { pixel: self.pixel_is.unwrap_or_default(), ..place };
        Some(self.with_system(place))
    }

    /// The place in the reference system that `crs` and `crs_unit` say.
    pub(super) fn with_system(&self, place: Georeference) -> Georeference {
        let unit = self.crs_unit.map(UnitText::unit);
        let place = Georeference { unit: unit.unwrap_or(place.unit), ..place };
        let place = match &self.crs {
            Some(crs) => place.with_crs(crs),
            None => place,
        };
        Georeference { unit: unit.unwrap_or(place.unit), ..place }
    }

    /// The heights that the lowest and highest sample stand for, metres.
    pub fn range(&self) -> Option<[f64; 2]> {
        Some([self.lowest_metre?, self.highest_metre?])
    }

    /// The extent in metres of a map with these numbers of cells.
    pub fn extent_of(&self, cells: [u32; 2]) -> Option<[f64; 2]> {
        self.extent_metres.or_else(|| self.metres_per_sample.map(|step| cells.map(|count| f64::from(count) * step)))
    }
}

/// Whether this is a scene file: it has a table of one, and no key of a sidecar.
fn is_scene(table: &toml::Table) -> bool {
    let has_table = |name: &str| table.get(name).is_some_and(toml::Value::is_table);
    SCENE_TABLES.into_iter().any(has_table) && !Sidecar::KEYS.into_iter().any(|key| table.contains_key(key))
}
