//! What the sun does in a lens.

use serde::{Deserialize, Serialize};

use crate::scene_file::{OutOfRange, check};

/// A lens flare: reflections of the sun between the lenses of a camera. Only where a sky is drawn and the sun stands in the
/// picture; hills, the occluder, clouds and fog dim it by what they hide of the sun's disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlareSettings {
    /// Whether there is one.
    pub enabled: bool,
    /// How bright it is, 0 to 4.
    pub strength: f64,
}

impl Default for FlareSettings {
    fn default() -> Self {
        Self { enabled: false, strength: 1.0 }
    }
}

impl FlareSettings {
    /// Checks that a picture can be made.
    ///
    /// # Errors
    /// The first field outside its range.
    pub(crate) fn validate(&self) -> Result<(), OutOfRange> {
        check("flare.strength", self.strength, 0.0..=4.0)
    }
}
