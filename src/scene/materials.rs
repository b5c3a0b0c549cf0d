//! What the ground is made of: which material lies where, and how it looks.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::scene_file::{OutOfRange, SMALLEST, check};

/// Where the ground's colour comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ColourSource {
    /// A texture over the whole map: the image that `diffuse.file` names, else one painted by height and slope.
    #[default]
    Texture,
    /// Grass, rock, scree, snow, sand and sea bed ([`MaterialSettings`]).
    Materials,
}

impl ColourSource {
    /// All sources, in the order of the panel.
    pub const ALL: [Self; 2] = [Self::Texture, Self::Materials];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Texture => "texture",
            Self::Materials => "materials",
        }
    }
}

/// A material of the ground, in the order of textures, uniforms and coverage maps' channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Material {
    /// Meadow and woods.
    Grass,
    /// Bare rock; its steep sides show strata.
    Rock,
    /// Loose stones.
    Scree,
    /// Snow.
    Snow,
    /// Sand.
    Sand,
    /// What lies under water.
    SeaBed,
}

impl Material {
    /// All of them, in their order.
    pub const ALL: [Self; 6] = [Self::Grass, Self::Rock, Self::Scree, Self::Snow, Self::Sand, Self::SeaBed];
}

/// What the levels of [`MaterialSettings`] count in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelUnit {
    /// Shares of the map's height: 0 is its lowest sample, 1 its highest.
    #[default]
    Share,
    /// Metres, as the map has them. It must be one whose metres are known.
    Metres,
}

/// Most images of a set of coverage maps: four materials each.
pub const MOST_COVERAGE_MAPS: usize = 2;

/// Materials by slope and height, or by coverage maps. In use where `diffuse.source` is `materials`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaterialSettings {
    /// Cells of the map that one repeat of the finest texture covers; the two coarser ones repeat 7 and 53 times as far.
    pub scale: f32,
    /// 0: meadows and grey rock; 1: dry grass and red sandstone.
    pub aridity: f32,
    /// Slope in degrees from which the ground is scree.
    pub scree_slope: f32,
    /// Slope in degrees from which it is rock.
    pub rock_slope: f32,
    /// Slope in degrees from which no snow stays.
    pub snow_slope: f32,
    /// Width of the transitions: 0 is a sharp edge, 1 the usual one.
    pub softness: f32,
    /// What the four levels below count in.
    pub levels: LevelUnit,
    /// Height from which snow lies.
    pub snow_line: f32,
    /// Height from which nothing grows.
    pub tree_line: f32,
    /// Height up to which flat ground is sand.
    pub sand_line: f32,
    /// Height of the sea; the ground below it is sea bed.
    pub sea_level: f32,
    /// How strongly the textures' relief bends the light; 0 leaves it out of the shader. Needs lighting.
    pub relief: f32,
    /// Images that say where the materials are in place of slopes and heights, stretched over the map, north up. Red,
    /// green, blue and alpha of the first weigh grass, rock, scree and snow, red and green of a second one sand and sea bed.
    /// Both have the same size. Where all weights are 0, slope and height decide.
    pub coverage: Vec<PathBuf>,
}

impl Default for MaterialSettings {
    fn default() -> Self {
        Self {
            scale: 1.5,
            aridity: 0.15,
            scree_slope: 27.0,
            rock_slope: 35.0,
            snow_slope: 52.0,
            softness: 1.0,
            levels: LevelUnit::Share,
            snow_line: 0.74,
            tree_line: 0.56,
            sand_line: 0.02,
            sea_level: 0.0,
            relief: 1.0,
            coverage: Vec::new(),
        }
    }
}

impl MaterialSettings {
    /// Checks that every number is in its range, and that there are not too many coverage maps.
    ///
    /// # Errors
    /// The first field that is not, as a path of keys.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        check("materials.scale", self.scale, 0.001..=10_000.0)?;
        check("materials.aridity", self.aridity, 0.0..=1.0)?;
        for (name, slope) in [
            ("materials.scree_slope", self.scree_slope),
            ("materials.rock_slope", self.rock_slope),
            ("materials.snow_slope", self.snow_slope),
        ] {
            check(name, slope, 0.0..=90.0)?;
        }
        check("materials.softness", self.softness, 0.0..=10.0)?;
        for (name, level) in [
            ("materials.snow_line", self.snow_line),
            ("materials.tree_line", self.tree_line),
            ("materials.sand_line", self.sand_line),
            ("materials.sea_level", self.sea_level),
        ] {
            check(name, level, -HIGHEST_LEVEL..=HIGHEST_LEVEL)?;
        }
        check("materials.relief", self.relief, 0.0..=10.0)?;
        if self.coverage.len() > MOST_COVERAGE_MAPS {
            return Err(OutOfRange {
                field: "materials.coverage".into(),
                value: format!("{} images", self.coverage.len()),
                range: format!("at most {MOST_COVERAGE_MAPS} images: four materials in the first, two in the second"),
            });
        }
        Ok(())
    }

    /// The settings with the thresholds that count over a map whose lowest and highest sample are `range` in metres, where
    /// they are known. While aridity, slopes and levels are all as at first, the map chooses them: one in metres is taken for
    /// dry land of the middle latitudes, with snow from 3500 m; on any other its heights count for less than they are drawn,
    /// because nobody knows them, and snow lies on its highest third.
    #[must_use]
    pub fn for_map(&self, range: Option<[f64; 2]>) -> Self {
        let chosen = |of: &Self| {
            (
                [of.aridity, of.scree_slope, of.rock_slope, of.snow_slope],
                of.levels,
                [of.snow_line, of.tree_line, of.sand_line, of.sea_level],
            )
        };
        if chosen(self) != chosen(&Self::default()) {
            return self.clone();
        }
        match range {
            Some([low, high]) => {
                let metres = |share: f32| (low + f64::from(share) * (high - low)) as f32;
                let (sand_line, sea_level) = (metres(self.sand_line), metres(self.sea_level));
                let levels = LevelUnit::Metres;
                Self {
                    aridity: 0.75,
                    levels,
                    snow_line: 3500.0,
                    tree_line: 3000.0,
                    sand_line,
                    sea_level,
                    ..self.clone()
                }
            }
            None => Self {
                scree_slope: 48.0,
                rock_slope: 56.0,
                snow_slope: 70.0,
                snow_line: 0.66,
                tree_line: 0.5,
                ..self.clone()
            },
        }
    }

    /// The levels of snow, trees, sand and sea as shares of the map's height, whose lowest and highest sample are `range` in
    /// metres where they are known.
    pub fn level_shares(&self, range: Option<[f64; 2]>) -> Option<[f32; 4]> {
        let levels = [self.snow_line, self.tree_line, self.sand_line, self.sea_level];
        match self.levels {
            LevelUnit::Share => Some(levels),
            LevelUnit::Metres => {
                let [low, high] = range?;
                let relief = (high - low).max(SMALLEST);
                Some(levels.map(|metres| ((f64::from(metres) - low) / relief).clamp(-1e6, 1e6) as f32))
            }
        }
    }
}

/// The highest and, negative, lowest level: beyond any height in metres.
const HIGHEST_LEVEL: f64 = 1e6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_in_metres_need_a_map_in_metres() {
        let settings = MaterialSettings {
            levels: LevelUnit::Metres,
            snow_line: 3000.0,
            tree_line: 2000.0,
            sand_line: 1010.0,
            sea_level: 1000.0,
            ..MaterialSettings::default()
        };
        assert_eq!(settings.level_shares(None), None);
        assert_eq!(settings.level_shares(Some([1000.0, 3000.0])), Some([1.0, 0.5, 0.005, 0.0]));
        assert!(settings.level_shares(Some([5.0, 5.0])).unwrap().iter().all(|share| share.is_finite()), "a flat map");
        assert!(MaterialSettings::default().level_shares(None).is_some());
    }

    #[test]
    fn the_map_chooses_what_nobody_has() {
        let usual = MaterialSettings { scale: 3.0, ..Default::default() };
        let canyon = usual.for_map(Some([600.0, 2700.0]));
        assert_eq!((canyon.levels, canyon.scale, canyon.sea_level), (LevelUnit::Metres, 3.0, 600.0));
        assert!(canyon.snow_line > 2700.0 && canyon.aridity > usual.aridity, "no snow on the canyon");
        let made = usual.for_map(None);
        assert!(made.snow_line < 0.74 && made.rock_slope > usual.rock_slope, "peaks have snow, and not all is rock");
        assert_eq!(made.for_map(None), made, "what is chosen stays");
        let own = MaterialSettings { snow_line: 0.9, ..Default::default() };
        assert_eq!(own.for_map(Some([0.0, 9.0])), own);
    }

    #[test]
    fn absurd_values_are_named() {
        assert_eq!(MaterialSettings::default().validate(), Ok(()));
        for (change, field) in [
            (MaterialSettings { scale: 0.0, ..Default::default() }, "materials.scale"),
            (MaterialSettings { rock_slope: f32::NAN, ..Default::default() }, "materials.rock_slope"),
            (MaterialSettings { snow_line: 1e9, ..Default::default() }, "materials.snow_line"),
            (MaterialSettings { coverage: vec![PathBuf::new(); 3], ..Default::default() }, "materials.coverage"),
        ] {
            assert_eq!(change.validate().unwrap_err().field, field);
        }
    }
}
