//! The height map itself: loading, generating, the maximum pyramid, craters, and the f64 reference. No GPU, no window.

pub mod bounds;
pub mod colour;
pub mod companions;
pub mod cone;
mod crater;
mod edited;
pub mod export;
mod field;
pub mod fractal;
pub mod gallery;
pub mod generate;
mod holes;
pub mod import;
pub mod load;
mod patch;
#[cfg(test)]
mod property_tests;
mod provenance;
mod pyramid;
pub mod reference;
pub mod save;
pub mod sea;
mod shadow;
mod sidecar;
pub mod smooth;
pub mod survey;
#[cfg(test)]
mod testing;

pub use cone::{ConeKind, ConeMap};
pub use crater::{Crater, CraterLayer};
pub use edited::{Edit, EditedTerrain, SampleRect};
pub(crate) use field::{EXAGGERATIONS, HEIGHT_SCALES};
pub use field::{HeightField, HeightFieldError};
pub use holes::{HoleMask, Holes};
pub use load::{LoadError, Loaded};
pub use provenance::Provenance;
pub use pyramid::{MaxPyramid, NodeRect, PyramidLevel};
pub use sidecar::Sidecar;
