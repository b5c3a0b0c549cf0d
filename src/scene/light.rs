//! What lights a scene beyond the reflection model: shadows, the clock that moves the sun, the sky.

use serde::{Deserialize, Serialize};

use super::sun::{self, SunPlace};

/// What the terrain and the occluder keep the sun from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shadows {
    /// Every surface that is turned towards the sun is lit.
    #[default]
    Off,
    /// One exact ray to the centre of the sun: a place is lit or it is not.
    Hard,
    /// The share of the sun's disc, 0.53° wide, that stands over the horizon, in five columns of the disc. Each column is
    /// exact; the sum over them is off by at most 0.8 % of the disc over a horizon that is straight there, level or at 45°.
    /// Against 400 rays to the disc, over the Grand Canyon: 0.5 % in the mean of the penumbra, 1.5 % at most. An upright
    /// edge shows in steps of a column, at most a third of the disc.
    Soft,
}

impl Shadows {
    /// All kinds, in the order of the panel.
    pub const ALL: [Self; 3] = [Self::Off, Self::Hard, Self::Soft];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Hard => "hard",
            Self::Soft => "soft",
        }
    }

    /// The one after this, for a key that goes through them.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Off => Self::Hard,
            Self::Hard => Self::Soft,
            Self::Soft => Self::Off,
        }
    }
}

/// Where the sun is taken from: a date, a time and a place on Earth, in place of azimuth and elevation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Clock {
    /// Whether the sun follows the clock.
    pub enabled: bool,
    /// Year, 1900 to 2100.
    pub year: i32,
    /// Month, 1 to 12.
    pub month: u32,
    /// Day of the month, 1 to 31; one beyond the month's end is of the next.
    pub day: u32,
    /// Hours UTC since the day began, 0 to 24.
    pub hour: f64,
    /// Degrees north. Absent: the middle of the map, or where that is not known, of the Grand Canyon.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latitude: Option<f64>,
    /// Degrees east, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longitude: Option<f64>,
    /// Hours of the clock per minute in the viewer; 0 stands still.
    pub speed: f64,
}

/// The Grand Canyon: degrees north and east.
const CANYON: [f64; 2] = [36.1, -112.1];

impl Default for Clock {
    fn default() -> Self {
        // A summer afternoon over the Grand Canyon.
        Self { enabled: false, year: 2026, month: 6, day: 21, hour: 24.0, latitude: None, longitude: None, speed: 0.0 }
    }
}

impl Clock {
    /// Where on Earth the clock stands, degrees north and east.
    pub fn place(&self) -> [f64; 2] {
        [self.latitude.unwrap_or(CANYON[0]), self.longitude.unwrap_or(CANYON[1])]
    }

    /// Where the sun is then and there.
    pub fn sun(&self) -> SunPlace {
        let [latitude, longitude] = self.place();
        sun::place(sun::julian_day(self.year, self.month, self.day, self.hour), latitude, longitude)
    }

    /// Lets `seconds` pass in the viewer. The day stays the same: days that follow one another look alike.
    pub fn run(&mut self, seconds: f64) {
        self.hour = (self.hour + self.speed / 60.0 * seconds).rem_euclid(24.0);
    }

    /// Whether the picture changes with time.
    pub fn runs(&self) -> bool {
        self.enabled && self.speed != 0.0
    }

    /// Puts the clock in the middle of a map, where the scene does not say where it is; `bounds` are west, south, east and
    /// north in degrees.
    pub fn stand_on(&mut self, bounds: Option<[f64; 4]>) {
        if let Some([west, south, east, north]) = bounds {
            self.latitude.get_or_insert((0.5 * (south + north)).clamp(-90.0, 90.0));
            self.longitude.get_or_insert((0.5 * (west + east)).clamp(-180.0, 180.0));
        }
    }
}

/// What the procedural sky is made by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SkyModel {
    /// Painted: a gradient, the sun, distant hills.
    #[default]
    Painted,
    /// The analytic daylight of Preetham, Shirley and Smits 1999; the ground is lit by it, too.
    Physical,
}

impl SkyModel {
    /// All models, in the order of the panel.
    pub const ALL: [Self; 2] = [Self::Painted, Self::Physical];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Painted => "painted",
            Self::Physical => "physical",
        }
    }
}
