//! Fractal landscapes from a [`Recipe`].
//!
//! # The same bytes everywhere
//!
//! The same recipe gives the same samples on every platform and with any number of threads:
//! - randomness is an integer hash of a place, never a state that is passed on;
//! - heights are made by f64 and f32 sums, products, quotients and square roots, which IEEE 754 rounds in one way only, and
//!   which Rust neither reorders nor fuses. No function of a mathematical library, whose last bits differ. (A 32-bit x86
//!   processor without SSE2 rounds in another way; Rust does not support it fully either.)
//! - threads share rows or bands whose samples depend on nothing that another thread writes, and sums over them are taken
//!   in the order of the bands.

mod diamond_square;
mod hydraulic;
mod lattice;
mod perlin;
mod plane;
mod recipe;
pub mod recipe_file;
mod ridged;
pub mod saving;
mod thermal;
mod warped;
mod work;

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::plane::Plane;
pub use self::recipe::{Hydraulic, Midpoint, Recipe, RecipeError, Ridges, Thermal, Warp};
use self::work::Work;
use super::HeightField;
use super::field::PLAIN_HEIGHT_SCALE;

/// Kinds of landscapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Random midpoint displacement (Fournier, Fussell, Carpenter 1982).
    DiamondSquare,
    /// A sum of octaves of gradient noise (Perlin 2002): rolling hills.
    Perlin,
    /// A ridged multifractal (Musgrave 1994): mountain crests over smooth valleys.
    Ridged,
    /// Gradient noise at places that gradient noise displaces (Quílez 2002): folded land.
    Warped,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::DiamondSquare, Self::Perlin, Self::Ridged, Self::Warped];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::DiamondSquare => "diamond-square",
            Self::Perlin => "perlin",
            Self::Ridged => "ridged",
            Self::Warped => "warped",
        }
    }
}

/// Why no landscape was made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MakeError {
    /// A setting that no landscape can be made with.
    #[error(transparent)]
    Recipe(RecipeError),
    /// Nobody wants it any more.
    #[error("the landscape was not finished\n  making it was cancelled\n  start again")]
    Cancelled,
}

/// A landscape of `size` × `size` samples that 16 bits hold, so that a saved one is the same; a size below 2 becomes 2.
pub fn generate(kind: Kind, size: u32, seed: u64) -> HeightField {
    #[expect(clippy::expect_used, reason = "a kind's own recipe is valid, and nobody cancels it")]
    Recipe::new(kind, seed).make([size.max(2); 2], &|_| {}, &AtomicBool::new(false)).expect("a valid recipe")
}

impl Recipe {
    /// Makes the landscape with `size` (columns, rows) in place of [`Recipe::size`]; each of its samples is one that 16 bits
    /// hold, so that a saved map is the same. `progress` hears the share done, 0..1, from several threads and not always in
    /// order; once `cancel` is set, rows and rounds that have not begun are left out.
    ///
    /// # Errors
    /// A setting outside its range, and [`MakeError::Cancelled`].
    pub fn make(
        &self,
        size: [u32; 2],
        progress: &(dyn Fn(f32) + Sync),
        cancel: &AtomicBool,
    ) -> Result<HeightField, MakeError> {
        let recipe = Self { size, ..self.clone() };
        recipe.validate()?;
        let plane = Plane::of(size, recipe.tileable);
        // Costs of a sample, roughly: an octave or a level, and a drop's step with its brush.
        let rain = recipe.hydraulic.drops * f64::from(recipe.hydraulic.lifetime.min(64));
        let weights = [1.0, rain as f32, recipe.thermal.iterations as f32 * 0.1];
        let [making, raining, sliding] = Work::new(progress, cancel).split(weights);
        making.check()?;
        let mut samples = match recipe.kind {
            Kind::DiamondSquare => diamond_square::make(&recipe, &plane, making),
            Kind::Perlin => perlin::make(&recipe, &plane, making),
            Kind::Ridged => ridged::make(&recipe, &plane, making),
            Kind::Warped => warped::make(&recipe, &plane, making),
        }?;
        if recipe.hydraulic.drops > 0.0 || recipe.thermal.iterations > 0 {
            in_distances_of_samples(&mut samples, &plane);
            let account = hydraulic::erode(&mut samples, &plane, &recipe.hydraulic, recipe.seed, raining)?;
            log::debug!("rain, in heights of a sample: {account:?}");
            thermal::erode(&mut samples, &plane, &recipe.thermal, sliding)?;
        }
        #[expect(clippy::expect_used, reason = "a valid recipe has a size, and all its steps keep samples finite")]
        let field = HeightField::from_raw(size[0], size[1], &plane.close(samples)).expect("samples of a landscape");
        progress(1.0);
        Ok(field.rounded_to_16_bits())
    }
}

/// Scales heights so that one between two samples that are one apart is a slope of 1, as in the box of a map without metres.
fn in_distances_of_samples(samples: &mut [f32], plane: &Plane) {
    let range = || (f32::INFINITY, f32::NEG_INFINITY);
    let widen = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
    let (low, high) = samples.par_iter().map(|&sample| (sample, sample)).reduce(range, widen);
    let span = f64::from(high) - f64::from(low);
    let factor = if span > 0.0 { PLAIN_HEIGHT_SCALE * plane.longer_side() / span } else { 0.0 };
    samples.par_iter_mut().for_each(|sample| *sample = ((f64::from(*sample) - f64::from(low)) * factor) as f32);
}

/// A well mixed 64-bit hash of a lattice point (the finaliser of SplitMix64 over each part).
pub(super) fn hash(seed: u64, stream: u32, x: u32, y: u32) -> u64 {
    let mix = |value: u64| {
        let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ (value >> 31)
    };
    let point = (u64::from(x) << 32) | u64::from(y);
    let stream = u64::from(stream).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mix(mix(seed.wrapping_add(stream)) ^ mix(point.wrapping_add(0x9e37_79b9_7f4a_7c15)))
}

/// −1 to 1, from the hash's upper 53 bits.
fn signed(hash: u64) -> f64 {
    (hash >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
