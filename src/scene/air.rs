//! What the air does to light: aerial perspective and height fog.
//!
//! Distances and heights are metres of the map itself: where its scale is known they are true, whatever the vertical
//! exaggeration, which stretches the air together with the ground. Where it is not, its longer side counts as 10 km.

use serde::{Deserialize, Serialize};

use crate::heightfield::HeightField;
use crate::scene_file::{OutOfRange, check};

/// Air between the eye and what it sees. Slope and aspect colours and hillshades are shown without it, because their colours
/// are to be read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AirSettings {
    /// Whether distance fades the ground into the sky.
    pub perspective: bool,
    /// Meteorological visibility in kilometres at the map's lowest ground, 0.05 (thick fog) to 320 (air without any haze):
    /// where a black object keeps 2 % of its contrast (Koschmieder 1924).
    pub visibility: f64,
    /// Whether there is fog in the valleys.
    pub fog: bool,
    /// Extinction of the fog up to its base height, per kilometre: 3.9 is a visibility of 1 km.
    pub fog_density: f64,
    /// Height up to which the fog is as dense as that, in metres: above sea level where the map's heights are metres, else
    /// above its lowest place.
    pub fog_base: f64,
    /// Metres above the base height in which the density falls to 1/e.
    pub fog_scale: f64,
    /// How much of the sun's light the fog scatters forward, 0 to 2.
    pub fog_glow: f64,
}

impl Default for AirSettings {
    fn default() -> Self {
        Self {
            perspective: false,
            visibility: 60.0,
            fog: false,
            fog_density: 0.8,
            fog_base: 0.0,
            fog_scale: 300.0,
            fog_glow: 0.5,
        }
    }
}

impl AirSettings {
    /// Checks that a picture can be made.
    ///
    /// # Errors
    /// The first field outside its range.
    pub(crate) fn validate(&self) -> Result<(), OutOfRange> {
        check("air.visibility", self.visibility, 0.05..=320.0)?;
        check("air.fog_density", self.fog_density, 0.0..=1000.0)?;
        check("air.fog_base", self.fog_base, -20_000.0..=100_000.0)?;
        check("air.fog_scale", self.fog_scale, 0.1..=100_000.0)?;
        check("air.fog_glow", self.fog_glow, 0.0..=2.0)
    }
}

/// Kilometres that the longer side of a map counts as whose scale is not known.
pub const UNKNOWN_SIDE: f64 = 10.0;

/// What lengths in the world are in kilometres of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kilometres {
    /// Per world unit along the ground.
    pub along: f64,
    /// Per world unit up: vertical exaggeration makes it smaller.
    pub up: f64,
    /// Height of the box's floor, the map's lowest place.
    pub floor: f64,
}

impl Kilometres {
    /// Those of `map` in a box that is `height` world units high.
    pub fn of(map: &HeightField, height: f64) -> Self {
        let along = map.extent_metres().map_or(UNKNOWN_SIDE, |[x, z]| x.max(z) / 1000.0);
        let [low, high] = map.range();
        let span = if map.has_metres() { high / 1000.0 - low / 1000.0 } else { along * map.true_height_scale() };
        // Maps may say anything; what no planet has is cut off, so that single precision holds all that follows.
        let along = along.clamp(1e-6, 1e6);
        let up = span / height;
        let floor = if map.has_metres() { low / 1000.0 } else { 0.0 };
        Self {
            along,
            up: if up.is_finite() && up > 0.0 { up.clamp(1e-6, 1e6) } else { along },
            floor: floor.clamp(-1e6, 1e6),
        }
    }

    /// World height of what is so many metres high.
    pub fn height_of(self, metres: f64) -> f64 {
        (metres / 1000.0 - self.floor) / self.up
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exaggeration changes what a world unit of height is, not what a metre is.
    #[test]
    fn exaggeration_stretches_the_air_with_the_ground() {
        let map = HeightField::from_raw(3, 2, &[400.0, 500.0, 600.0, 1400.0, 900.0, 800.0f64]).unwrap();
        let plain = Kilometres::of(&map, map.box_size(None).y);
        assert_eq!((plain.along, plain.floor), (UNKNOWN_SIDE, 0.0));
        assert!((plain.up - plain.along).abs() < 1e-12, "nothing is exaggerated");
        let known = map.with_extent_metres(Some([20_000.0, 10_000.0]));
        for exaggeration in [0.5, 1.0, 7.0] {
            let height = 0.05 * exaggeration;
            let km = Kilometres::of(&known, height);
            assert_eq!((km.along, km.floor), (20.0, 0.4));
            assert!((km.height_of(1400.0) - height).abs() < 1e-12 && km.height_of(400.0) == 0.0);
        }
        assert_eq!(Kilometres::of(&known, 0.0).up, 20.0, "a box without height is no division by nothing");
    }

    #[test]
    fn absurd_values_are_named() {
        let refused = |change: &dyn Fn(&mut AirSettings)| {
            let mut air = AirSettings::default();
            change(&mut air);
            air.validate().map_err(|error| error.field)
        };
        assert_eq!(refused(&|_| {}), Ok(()));
        assert_eq!(refused(&|air| air.visibility = 0.0), Err("air.visibility".into()));
        assert_eq!(refused(&|air| air.fog_density = f64::NAN), Err("air.fog_density".into()));
        assert_eq!(refused(&|air| air.fog_scale = 0.0), Err("air.fog_scale".into()));
        assert_eq!(refused(&|air| air.fog_base = 1e9), Err("air.fog_base".into()));
    }
}
