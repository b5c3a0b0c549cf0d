//! Detail that no sample has, for the technique that invents it.

use serde::{Deserialize, Serialize};

use crate::scene_file::{OutOfRange, check};

/// Ground with invented detail ([`crate::heightfield::fractal`]); for the technique `fractal` alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetailSettings {
    /// Heights of the detail over those that go on as the map leaves off, 0 to 4.
    pub strength: f64,
}

impl Default for DetailSettings {
    fn default() -> Self {
        Self { strength: 1.0 }
    }
}

impl DetailSettings {
    pub(crate) fn validate(&self) -> Result<(), OutOfRange> {
        check("detail.strength", self.strength, 0.0..=4.0)
    }
}
