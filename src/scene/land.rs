//! Reading the land: colours by height, slope or direction, contour lines, hillshade, and pictures of the ground put where
//! they belong.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::ramp::Ramp;
use crate::heightfield::HeightField;
use crate::scene_file::{OutOfRange, check};

/// What the ground is coloured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum GroundColour {
    /// Its texture, or grey without one ([`super::DiffuseSettings`]).
    #[default]
    Texture,
    /// Its height, by a ramp.
    Ramp,
    /// Its steepness, in degrees as they are in nature: an exaggerated height changes none.
    Slope,
    /// The compass direction in which it falls.
    Aspect,
}

impl GroundColour {
    /// All of them, in the order of the panel.
    pub const ALL: [Self; 4] = [Self::Texture, Self::Ramp, Self::Slope, Self::Aspect];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Texture => "texture",
            Self::Ramp => "ramp",
            Self::Slope => "slope",
            Self::Aspect => "aspect",
        }
    }
}

/// Shades by which a map shows relief, in place of the lighting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Hillshade {
    /// None: the ground is lit as the lighting says.
    #[default]
    Off,
    /// From the sun's direction.
    Sun,
    /// From four directions, 225° to 360°, each weighted by how much it grazes the slope (Mark 1992, USGS OFR 92-422).
    Multidirectional,
}

impl Hillshade {
    /// All of them, in the order of the panel.
    pub const ALL: [Self; 3] = [Self::Off, Self::Sun, Self::Multidirectional];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Sun => "sun",
            Self::Multidirectional => "multidirectional",
        }
    }
}

/// How the land is shown as on a map. Heights are in metres where the map's are known in metres, else in its own numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandSettings {
    /// What the ground is coloured by.
    pub colour: GroundColour,
    /// The ramp of [`GroundColour::Ramp`].
    pub ramp: Ramp,
    /// Height of the ramp's lower end. Absent: the map's lowest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Height of the ramp's upper end. Absent: the map's highest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Degrees that the last colour of [`GroundColour::Slope`] stands for; steeper ground has it, too.
    pub slope_max: f64,
    /// Shades of relief.
    pub hillshade: Hillshade,
    /// How much of the shades shows, 0 to 1.
    pub hillshade_strength: f64,
    /// Draw lines of equal height.
    pub contours: bool,
    /// Height from line to line. Absent: chosen by the map's range. Every fifth line is heavier.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contour_interval: Option<f64>,
    /// Width of a line in pixels.
    pub contour_width: f64,
    /// A picture of the ground that says where it lies, by GeoTIFF tags or a world file; beside it the ground keeps its
    /// colour. One that does not is [`super::DiffuseSettings::file`]'s, over the whole map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imagery: Option<PathBuf>,
    /// How much of the picture shows, 0 to 1.
    pub imagery_opacity: f64,
}

impl Default for LandSettings {
    fn default() -> Self {
        Self {
            colour: GroundColour::default(),
            ramp: Ramp::default(),
            low: None,
            high: None,
            slope_max: 60.0,
            hillshade: Hillshade::default(),
            hillshade_strength: 0.7,
            contours: false,
            contour_interval: None,
            contour_width: 1.0,
            imagery: None,
            imagery_opacity: 1.0,
        }
    }
}

/// Farthest from 0 that an end of a ramp may be.
const FARTHEST_HEIGHT: f64 = 1e12;

/// The least and the greatest height from contour to contour.
pub const INTERVALS: std::ops::RangeInclusive<f64> = 1e-9..=1e12;

/// Checks that a picture can be made.
///
/// # Errors
/// The first field outside its range.
pub(crate) fn validate(land: &LandSettings) -> Result<(), OutOfRange> {
    for (name, end) in [("land.low", land.low), ("land.high", land.high)] {
        check(name, end.unwrap_or(0.0), -FARTHEST_HEIGHT..=FARTHEST_HEIGHT)?;
    }
    check("land.slope_max", land.slope_max, 1.0..=90.0)?;
    check("land.hillshade_strength", land.hillshade_strength, 0.0..=1.0)?;
    check("land.contour_interval", land.contour_interval.unwrap_or(1.0), INTERVALS)?;
    check("land.contour_width", land.contour_width, 0.1..=20.0)?;
    check("land.imagery_opacity", land.imagery_opacity, 0.0..=1.0)
}

/// About as many contour lines as an interval by range makes.
const LINES: f64 = 20.0;

/// Where sea level is taken to be in a map whose numbers are no metres, as a share of the ramp.
const SEA_SHARE: f64 = 0.35;

/// The heights that the colours and lines of a map stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandScale {
    /// Height of the ramp's lower end.
    pub low: f64,
    /// Height of the ramp's middle: sea level where it breaks there.
    pub middle: f64,
    /// Height of its upper end.
    pub high: f64,
    /// Height from contour to contour.
    pub interval: f64,
    /// Heights are metres.
    pub metric: bool,
}

impl LandSettings {
    /// What the colours and lines over `map` stand for. Sea level is 0 m where heights are metres.
    pub fn scale(&self, map: &HeightField) -> LandScale {
        let [lowest, highest] = map.range();
        let (low, high) = (self.low.unwrap_or(lowest), self.high.unwrap_or(highest));
        // An end that is pushed past the other takes it along.
        let (low, high) = (low.min(high), high.max(low));
        let metric = map.has_metres();
        let middle = match (self.ramp.is_marine(), metric) {
            (true, true) => 0f64.clamp(low, high),
            (true, false) => low + (high - low) * SEA_SHARE,
            (false, _) => low * 0.5 + high * 0.5,
        };
        let interval = self.contour_interval.unwrap_or_else(|| round_interval((highest - lowest) / LINES));
        LandScale { low, middle, high, interval, metric }
    }

    /// Whether anything is shown that has a legend.
    pub fn has_legend(&self) -> bool {
        self.colour != GroundColour::Texture || self.contours
    }
}

impl LandScale {
    /// Where a height stands in the ramp, 0 to 1; the middle is 0.5.
    pub fn share(&self, height: f64) -> f64 {
        let part = |from: f64, to: f64| ((height - from) / (to - from).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        if height < self.middle { 0.5 * part(self.low, self.middle) } else { 0.5 + 0.5 * part(self.middle, self.high) }
    }

    /// What stands behind heights: " m", or nothing where their unit is not known.
    pub fn unit(&self) -> &'static str {
        if self.metric { " m" } else { "" }
    }

    /// The interval of the lines in words.
    pub fn contours_in_words(&self) -> String {
        let (step, unit) = (number(self.interval), self.unit());
        format!("contours every {step}{unit}, heavier every {}{unit}", number(self.interval * 5.0))
    }
}

/// 1, 2 or 5 times a power of ten that is next to `about`, upwards; 1 for what is no distance.
pub fn round_interval(about: f64) -> f64 {
    if !(about.is_finite() && about > *INTERVALS.start()) {
        return 1.0;
    }
    let power = 10f64.powf(about.log10().floor());
    let digits = [1.0, 2.0, 5.0, 10.0];
    let digit = digits.into_iter().find(|digit| digit * power >= about * 0.999).unwrap_or(10.0);
    (digit * power).min(*INTERVALS.end())
}

/// A height for people: as many digits as it takes to tell it apart, and no more than five behind the point.
pub fn number(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e7).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.5}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(low: f64, high: f64, metric: bool) -> HeightField {
        let extent = metric.then_some([1000.0, 1000.0]);
        HeightField::from_raw(2, 2, &[low, high, low, high]).unwrap().with_extent_metres(extent)
    }

    #[test]
    fn sea_level_is_where_the_ramp_breaks() {
        let mut land = LandSettings::default();
        let scale = land.scale(&map(-4000.0, 1000.0, true));
        assert_eq!((scale.low, scale.middle, scale.high), (-4000.0, 0.0, 1000.0));
        assert_eq!([-4000.0, -2000.0, 0.0, 500.0, 9e9].map(|at| scale.share(at)), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert!(scale.share(-0.001) < 0.5, "just below it is the sea's");
        // All land: nothing is blue.
        let canyon = land.scale(&map(479.0, 2347.0, true));
        assert_eq!((canyon.middle, canyon.share(479.0)), (479.0, 0.5));
        // Handles move the ends and not the sea.
        (land.low, land.high) = (Some(-100.0), Some(50.0));
        let near = land.scale(&map(-4000.0, 1000.0, true));
        assert_eq!([-200.0, -50.0, 0.0, 25.0].map(|at| near.share(at)), [0.0, 0.25, 0.5, 0.75]);
        land.ramp = Ramp::Viridis;
        assert_eq!(land.scale(&map(-4000.0, 1000.0, true)).middle, -25.0, "others do not break");
        // Ends that have crossed, and a map without relief, are no division by nothing.
        (land.low, land.high) = (Some(10.0), Some(-10.0));
        assert_eq!(land.scale(&map(0.0, 1.0, true)).low, -10.0);
        let flat = LandSettings::default().scale(&map(7.0, 7.0, true));
        assert!(flat.share(7.0).is_finite() && flat.interval > 0.0);
    }

    #[test]
    fn intervals_are_round() {
        assert_eq!([93.4, 100.0, 100.05, 0.013, 3e5].map(round_interval), [100.0, 100.0, 100.0, 0.02, 5e5]);
        assert_eq!([0.0, f64::NAN, f64::INFINITY, -3.0].map(round_interval), [1.0; 4]);
        let land = LandSettings::default();
        assert_eq!(land.scale(&map(479.0, 2347.0, true)).interval, 100.0);
        let words = land.scale(&map(479.0, 2347.0, true)).contours_in_words();
        assert_eq!(words, "contours every 100 m, heavier every 500 m");
        assert_eq!([1.5, 2347.0, -0.25, 1e-7, 3e9].map(number), ["1.5", "2347", "-0.25", "1.00e-7", "3.00e9"]);
    }

    #[test]
    fn absurd_values_are_named() {
        let refused = |change: &dyn Fn(&mut LandSettings)| {
            let mut land = LandSettings::default();
            change(&mut land);
            validate(&land).map_err(|error| error.field)
        };
        assert_eq!(refused(&|_| {}), Ok(()));
        assert_eq!(refused(&|land| land.low = Some(f64::NAN)), Err("land.low".into()));
        assert_eq!(refused(&|land| land.contour_interval = Some(0.0)), Err("land.contour_interval".into()));
        assert_eq!(refused(&|land| land.contour_width = 1e9), Err("land.contour_width".into()));
        assert_eq!(refused(&|land| land.imagery_opacity = 1.5), Err("land.imagery_opacity".into()));
    }
}
