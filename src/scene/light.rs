//! What lights a scene beyond the sun's direction and the reflection model: shadows.

use serde::{Deserialize, Serialize};

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
    /// exact, so a level horizon gives the exact share but for the quadrature over the columns, 0.6 % of the disc; an
    /// upright edge shows in steps of a column, at most a third of the disc.
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
