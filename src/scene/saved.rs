//! What saved pictures get that the view itself does not show.

use serde::{Deserialize, Serialize};

/// What is added to a picture when it is saved: screenshots, `relief render`, animations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SavedSettings {
    /// Draw what the colours and lines mean into the lower left corner, where they mean something.
    pub legend: bool,
}
