//! What a landscape is made from: plain data that can be saved and edited.

use serde::{Deserialize, Serialize};

use super::diamond_square::{nearest_tileable, start_cells};
use super::{Kind, MakeError};
use crate::heightfield::load::MAX_SIDE;

/// Changes when the same recipe no longer makes the same bytes.
const VERSION: u32 = 1;

/// Octaves of a small map at least, where the recipe leaves them to the size.
const LEAST_OCTAVES: u32 = 8;
/// Octaves at most.
const MOST_OCTAVES: u32 = 32;
/// Cells of the finest octave along a side at most: their numbers fit a hash of 32 bits with room for warping.
const MOST_CELLS: f64 = (1u32 << 30) as f64;
/// Samples at most: 16385² and twice as many.
const MOST_SAMPLES: u64 = 1 << 29;
/// Cells along a side at most that the first grid of a tileable diamond-square landscape has.
pub(super) const MOST_START_CELLS: u32 = 16;
/// Cells of the coarsest octave along the longer side, where a recipe does not say.
const SCALE: f64 = 3.0;

/// A landscape's recipe. The same recipe makes the same bytes on every machine, with any number of threads; see
/// [`Recipe::make`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recipe {
    /// Version of the generator that it was written for.
    pub version: u32,
    /// What is made.
    pub kind: Kind,
    /// Columns and rows of the saved map.
    pub size: [u32; 2],
    /// The same seed makes the same landscape.
    #[serde(with = "seed_as_number_or_text")]
    pub seed: u64,
    /// Opposite borders are equal, and the landscape goes on smoothly over them.
    pub tileable: bool,
    /// Amplitude of an octave, or of a level of halving, over the one before; 0 (smooth) to 1.
    pub roughness: f64,
    /// Octaves of noise; absent: down to the distance of two samples, but at least eight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub octaves: Option<u32>,
    /// Frequency of an octave over the one before; 1.1 to 8. A tileable landscape rounds each octave to whole cells.
    pub lacunarity: f64,
    /// Cells of the coarsest octave along the longer side; 0.1 to 1024.
    pub scale: f64,
    /// For [`Kind::DiamondSquare`].
    pub midpoint: Midpoint,
    /// For [`Kind::Ridged`].
    pub ridges: Ridges,
    /// For [`Kind::Warped`].
    pub warp: Warp,
    /// Rain, before slopes slide.
    pub hydraulic: Hydraulic,
    /// Slopes that slide, the last step.
    pub thermal: Thermal,
}

/// Midpoint displacement's own settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Midpoint {
    /// How far each halving displaces at most, coarse to fine, 0 to 1000; the corners of the first grid are within −1 and 1.
    /// From its end on (or from 1, where it is empty) each level has the roughness's share of the one before.
    pub schedule: Vec<f64>,
    /// Passes of smoothing at the end, 0 to 64.
    pub smoothing: u32,
}

/// The ridged multifractal's own settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ridges {
    /// What the noise's absolute value is subtracted from, 0.5 to 2: 1 makes the sharpest crests.
    pub offset: f64,
    /// How much detail gathers on the crests of the octave before, 0 to 16.
    pub gain: f64,
}

/// Domain warping's own settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Warp {
    /// How far places are displaced, in cells of the coarsest octave, 0 to 8.
    pub strength: f64,
}

/// Erosion by rain. Slopes count as in a box a quarter as high as it is long, which is how a map without metres is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hydraulic {
    /// Drops for each sample, 0 (no rain) to 64.
    pub drops: f64,
    /// Of what a drop could still carry, the share that it takes up in a step, 0 to 1.
    pub strength: f64,
    /// Radius around the drop, in samples, that soil is taken from, 1 to 8.
    pub radius: u32,
    /// Steps of one sample's distance that a drop runs at most, 1 to 1000.
    pub lifetime: u32,
}

/// Erosion by sliding. Slopes count as for [`Hydraulic`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Thermal {
    /// Steps, 0 (nothing slides) to 10000.
    pub iterations: u32,
    /// Share of what can slide in a step that does, 0 to 1.
    pub strength: f64,
    /// Rise over run at which material rests, 0 to 100; 0.7 is 35°.
    pub talus: f64,
}

impl Default for Recipe {
    fn default() -> Self {
        Self::new(Kind::DiamondSquare, 1)
    }
}

impl Default for Ridges {
    fn default() -> Self {
        Self { offset: 1.0, gain: 2.0 }
    }
}

impl Default for Warp {
    fn default() -> Self {
        Self { strength: 0.8 }
    }
}

impl Default for Hydraulic {
    fn default() -> Self {
        Self { drops: 0.0, strength: 0.3, radius: 3, lifetime: 64 }
    }
}

impl Default for Thermal {
    fn default() -> Self {
        Self { iterations: 0, strength: 1.0, talus: 0.7 }
    }
}

/// A setting that no landscape can be made with: what, why, and what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} is {value}\n  {why}\n  give {instead}")]
pub struct RecipeError {
    /// The setting, as a path of keys such as `thermal.talus`.
    pub field: &'static str,
    /// Its value.
    pub value: String,
    /// Why it cannot be.
    pub why: String,
    /// What can be.
    pub instead: String,
}

impl RecipeError {
    pub(super) fn new(field: &'static str, value: String, why: &str, instead: String) -> Self {
        Self { field, value, why: why.to_owned(), instead }
    }
}

impl Recipe {
    /// The recipe of a kind with its defaults: 1024×1024, no erosion.
    pub fn new(kind: Kind, seed: u64) -> Self {
        Self {
            version: VERSION,
            kind,
            size: [1024; 2],
            seed,
            tileable: false,
            roughness: 0.5,
            octaves: None,
            lacunarity: 2.0,
            scale: SCALE,
            midpoint: Midpoint::default(),
            ridges: Ridges::default(),
            warp: Warp::default(),
            hydraulic: Hydraulic::default(),
            thermal: Thermal::default(),
        }
    }

    /// What to call the landscape: its kind, its seed, and whether it was eroded.
    pub fn title(&self) -> String {
        let eroded = self.hydraulic.drops > 0.0 || self.thermal.iterations > 0;
        format!("{} {}{}", self.kind.name(), self.seed, if eroded { ", eroded" } else { "" })
    }

    /// Checks that a landscape can be made: every number finite and inside its range.
    ///
    /// # Errors
    /// The first setting that is not.
    pub fn validate(&self) -> Result<(), RecipeError> {
        if self.version != VERSION {
            let why = "another version of the generator makes other bytes of the same settings";
            return Err(RecipeError::new(
                "version",
                self.version.to_string(),
                why,
                format!("{VERSION}, or take the program that wrote it"),
            ));
        }
        self.validate_size()?;
        let noise = "it is the height of each octave over the one before: above 1 the finest would be the highest";
        check("roughness", self.roughness, [0.0, 1.0], noise)?;
        let finest = "each octave costs as much as the first, and those finer than a sample cannot be seen";
        check("octaves", self.octaves.unwrap_or(1), [1.0, f64::from(MOST_OCTAVES)], finest)?;
        check("lacunarity", self.lacunarity, [1.1, 8.0], "octaves have to differ, and to leave no gap between them")?;
        check("scale", self.scale, [0.1, 1024.0], "it counts the hills along the longer side")?;
        self.validate_cells()?;
        for &amplitude in &self.midpoint.schedule {
            check("midpoint.schedule", amplitude, [0.0, 1000.0], "each number is how far a halving displaces")?;
        }
        let count = self.midpoint.schedule.len();
        check("midpoint.schedule", count as u32, [0.0, 32.0], "no map is halved more often than 15 times")
            .map_err(|error| RecipeError { value: format!("{count} numbers long"), ..error })?;
        check("midpoint.smoothing", self.midpoint.smoothing, [0.0, 64.0], "more passes leave nothing but slopes")?;
        check(
            "ridges.offset",
            self.ridges.offset,
            [0.5, 2.0],
            "crests are where noise between −1 and 1 is far from it",
        )?;
        check("ridges.gain", self.ridges.gain, [0.0, 16.0], "it steers where detail gathers")?;
        check("warp.strength", self.warp.strength, [0.0, 8.0], "it counts in cells of the coarsest octave")?;
        let hydraulic = &self.hydraulic;
        check("hydraulic.drops", hydraulic.drops, [0.0, 64.0], "it counts the drops for each sample; 0 is no rain")?;
        check("hydraulic.strength", hydraulic.strength, [0.0, 1.0], "it is a share")?;
        check("hydraulic.radius", hydraulic.radius, [1.0, 8.0], "it counts samples around a drop")?;
        check("hydraulic.lifetime", hydraulic.lifetime, [1.0, 1000.0], "it counts the steps of a drop")?;
        let steps = "it counts steps over the whole map; 0 is none";
        check("thermal.iterations", self.thermal.iterations, [0.0, 10_000.0], steps)?;
        check("thermal.strength", self.thermal.strength, [0.0, 1.0], "it is a share; above 1 slopes would swing")?;
        check("thermal.talus", self.thermal.talus, [0.0, 100.0], "it is a slope, rise over run; 1 is 45°")
    }

    fn validate_size(&self) -> Result<(), RecipeError> {
        let [width, height] = self.size;
        let shown = if width == height { width.to_string() } else { format!("{width}×{height}") };
        let least = if self.tileable { 3 } else { 2 };
        if width.min(height) < least || width.max(height) > MAX_SIDE {
            let why =
                "a surface needs two samples each way, three to repeat, and textures end far below the largest size";
            return Err(RecipeError::new("size", shown, why, format!("{least} to {MAX_SIDE} a side")));
        }
        if u64::from(width) * u64::from(height) > MOST_SAMPLES {
            let why = "making it would take more than eight gigabytes";
            return Err(RecipeError::new(
                "size",
                shown,
                why,
                format!("at most {MOST_SAMPLES} samples, such as 16385×16385"),
            ));
        }
        let (cells, halvings) = start_cells(self.size.map(|side| side - 1));
        if self.kind == Kind::DiamondSquare && self.tileable && cells[0].max(cells[1]) > MOST_START_CELLS {
            let why = format!(
                "diamond-square halves whole cells: {halvings} times here, from a first grid of {}×{} cells, which is noise",
                cells[0], cells[1]
            );
            let [width, height] = nearest_tileable(self.size);
            let instead = format!("{width}×{height}, or make one that is not tileable");
            return Err(RecipeError::new("size", shown, &why, instead));
        }
        Ok(())
    }

    /// The finest octave's cells can be numbered.
    fn validate_cells(&self) -> Result<(), RecipeError> {
        let count = self.octave_count(self.size[0].max(self.size[1]));
        let cells = (1..count).fold(self.scale, |cells, _| cells * self.lacunarity);
        if cells <= MOST_CELLS {
            return Ok(());
        }
        let why = format!(
            "with lacunarity {} and scale {} the finest has {cells:.1e} cells along a side",
            self.lacunarity, self.scale
        );
        let most = format!("fewer, so that there are at most {MOST_CELLS:.1e} cells; there are never as many samples");
        Err(RecipeError::new("octaves", count.to_string(), &why, most))
    }

    /// Octaves of noise on a map whose longer side has `samples`.
    pub(super) fn octave_count(&self, samples: u32) -> u32 {
        self.octaves.unwrap_or_else(|| {
            let (mut octaves, mut cells) = (0, self.scale / SCALE * self.lacunarity);
            while cells <= f64::from(samples) && octaves < MOST_OCTAVES {
                cells *= self.lacunarity;
                octaves += 1;
            }
            octaves.max(LEAST_OCTAVES)
        })
    }
}

/// NaN is inside no range.
fn check(field: &'static str, value: impl Into<f64>, [least, most]: [f64; 2], why: &str) -> Result<(), RecipeError> {
    let value = value.into();
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(RecipeError::new(field, value.to_string(), why, format!("{least} to {most}")))
}

impl From<RecipeError> for MakeError {
    fn from(error: RecipeError) -> Self {
        Self::Recipe(error)
    }
}

/// TOML's integers end at 63 bits; larger seeds are text.
mod seed_as_number_or_text {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Seed {
        Number(i64),
        Text(String),
    }

    pub(super) fn serialize<S: Serializer>(seed: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        match i64::try_from(*seed) {
            Ok(number) => serializer.serialize_i64(number),
            Err(_) => serializer.serialize_str(&seed.to_string()),
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let expected =
            || D::Error::custom("a seed is a whole number, 0 to 18446744073709551615 (in quotes above 2^63)");
        match Seed::deserialize(deserializer).map_err(|_| expected())? {
            Seed::Number(number) => u64::try_from(number).map_err(|_| expected()),
            Seed::Text(text) => text.parse().map_err(|_| expected()),
        }
    }
}

#[cfg(test)]
#[path = "recipe_tests.rs"]
mod tests;
