//! The sea: where it stands, what light does in it, what moves on it.

use serde::{Deserialize, Serialize};

use super::LevelUnit;
use crate::scene_file::{OutOfRange, SMALLEST, check};

/// A sea over the map, as a block of water in the terrain's box from the floor to its level.
///
/// It is no part of any deep zoom, whose pixels are finer than single precision counts, and of no debug view. Over a hole it
/// has no bed. What is measured of techniques, and `--depth`, is the ground's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Water {
    /// Whether there is a sea.
    pub enabled: bool,
    /// Its height, as `levels` counts. Absent: 0 m where that lies within the heights of a map whose metres are known, else a
    /// third of the way from the map's lowest sample to its highest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f32>,
    /// What the level counts in.
    pub levels: LevelUnit,
    /// Hills and the occluder are mirrored; otherwise the sky alone, without a walk.
    pub reflection: bool,
    /// Rays bend where they go through the surface; otherwise they go straight on, and see out of the water in every
    /// direction.
    pub refraction: bool,
    /// How far green light gets through the water until 37 % of it are left, world units (the map's longer side is 1). Red
    /// gets a quarter as far.
    pub clarity: f32,
    /// 0: a blue sea; 1: a green lake.
    pub tint: f32,
    /// Steepness of the waves: 0 is a mirror, 1 a stiff breeze.
    pub waves: f32,
    /// Length of the longest waves, world units.
    pub wave_length: f32,
    /// Width of the foam along the shore: 0 is none, 1 as wide as the water is a thirtieth of the map's height deep.
    pub foam: f32,
    /// Bubbles rise around an eye under water.
    pub bubbles: bool,
    /// Waves, foam and bubbles move in films and in the viewer. While they do there, frames are drawn all the time.
    pub moving: bool,
    /// Where they are: seconds of their clock.
    pub time: f64,
}

impl Default for Water {
    fn default() -> Self {
        Self {
            enabled: false,
            level: None,
            levels: LevelUnit::Share,
            reflection: true,
            refraction: true,
            clarity: 0.05,
            tint: 0.35,
            waves: 0.25,
            wave_length: 0.015,
            foam: 0.3,
            bubbles: true,
            moving: false,
            time: 0.0,
        }
    }
}

/// Where the sea stands by default, of a map whose heights do not include 0 m.
const THIRD: f64 = 1.0 / 3.0;

/// The highest sea: twice as high as the map.
const HIGHEST_SHARE: f64 = 2.0;

/// Levels beyond any height in metres.
const HIGHEST_LEVEL: f64 = 1e6;

/// After so many seconds the clock of what moves begins anew. Waves, foam and bubbles all repeat after it, so that nothing jumps
/// (`render/water.rs`).
pub(crate) const WATER_PERIOD: f64 = 3600.0;

impl Water {
    /// Checks that every number is in its range.
    ///
    /// # Errors
    /// The first field that is not, as a path of keys.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        if let Some(level) = self.level {
            check("water.level", level, -HIGHEST_LEVEL..=HIGHEST_LEVEL)?;
        }
        check("water.clarity", self.clarity, 1e-4..=1e4)?;
        check("water.tint", self.tint, 0.0..=1.0)?;
        check("water.waves", self.waves, 0.0..=1.0)?;
        check("water.wave_length", self.wave_length, 1e-4..=10.0)?;
        check("water.foam", self.foam, 0.0..=1.0)?;
        check("water.time", self.time, 0.0..=WATER_PERIOD)
    }

    /// Height of the sea as a share of the map's, whose lowest and highest sample are `range` in metres where they are known: 0
    /// where it lies below the map, 2 at most. `None` where the level is in metres and the map has none.
    pub fn level_share(&self, range: Option<[f64; 2]>) -> Option<f64> {
        let of_metres = |metres: f64, [low, high]: [f64; 2]| (metres - low) / (high - low).max(SMALLEST);
        let share = match (self.level, self.levels) {
            (None, _) => {
                range.filter(|&[low, high]| low < 0.0 && high > 0.0).map_or(THIRD, |range| of_metres(0.0, range))
            }
            (Some(level), LevelUnit::Share) => f64::from(level),
            (Some(level), LevelUnit::Metres) => of_metres(f64::from(level), range?),
        };
        Some(share.clamp(0.0, HIGHEST_SHARE))
    }

    /// Whether anything of it moves.
    pub fn runs(&self) -> bool {
        self.enabled && self.moving && (self.waves > 0.0 || self.foam > 0.0 || self.bubbles)
    }

    /// Lets `seconds` pass in the viewer.
    pub fn run(&mut self, seconds: f64) {
        self.time = (self.time + seconds).rem_euclid(WATER_PERIOD);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_counts_as_the_map_can() {
        let share = |level, levels, range| Water { level, levels, ..Water::default() }.level_share(range);
        let close = |found: Option<f64>, wanted: f64| assert!((found.unwrap() - wanted).abs() < 1e-6, "{found:?}");
        close(share(None, LevelUnit::Share, None), 1.0 / 3.0);
        // Sea level, where there is one.
        close(share(None, LevelUnit::Share, Some([-1000.0, 3000.0])), 0.25);
        close(share(None, LevelUnit::Share, Some([479.0, 2347.0])), 1.0 / 3.0);
        close(share(Some(0.5), LevelUnit::Share, Some([-1000.0, 3000.0])), 0.5);
        close(share(Some(1000.0), LevelUnit::Metres, Some([-1000.0, 3000.0])), 0.5);
        close(share(Some(-5000.0), LevelUnit::Metres, Some([-1000.0, 3000.0])), 0.0);
        close(share(Some(1e6), LevelUnit::Metres, Some([5.0, 5.0])), 2.0);
        assert_eq!(share(Some(1.0), LevelUnit::Metres, None), None);
    }

    #[test]
    fn absurd_values_are_named() {
        assert_eq!(Water::default().validate(), Ok(()));
        for (change, field) in [
            (Water { level: Some(f32::NAN), ..Water::default() }, "water.level"),
            (Water { clarity: 0.0, ..Water::default() }, "water.clarity"),
            (Water { waves: 1.5, ..Water::default() }, "water.waves"),
            (Water { wave_length: -1.0, ..Water::default() }, "water.wave_length"),
            (Water { time: f64::INFINITY, ..Water::default() }, "water.time"),
        ] {
            assert_eq!(change.validate().unwrap_err().field, field);
        }
    }

    #[test]
    fn only_what_moves_runs() {
        let moving = Water { enabled: true, moving: true, ..Water::default() };
        assert!(moving.runs() && !Water { moving: false, ..moving.clone() }.runs());
        assert!(!Water { waves: 0.0, foam: 0.0, bubbles: false, ..moving.clone() }.runs());
        let mut late = Water { time: 3599.5, ..moving };
        late.run(1.0);
        assert!((late.time - 0.5).abs() < 1e-9);
    }
}
