//! Stiff terrain: maps on which sampling fails, and where roundings matter.

use std::sync::Arc;

use crate::heightfield::generate::{Kind, generate};
use crate::heightfield::{Crater, EditedTerrain, HeightField, HeightFieldError};

/// A stiff map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Terrain {
    /// Single samples of full height on flat ground, seven apart.
    Needles,
    /// A wall one sample thick across the map, off the middle, with a gap.
    Wall,
    /// Low on one side, high on the other, one cell between.
    Cliff,
    /// 0 and 1 in turn at every sample: every cell is a saddle of full relief.
    Checkerboard,
    /// Hills cut into eight flat steps.
    Terraces,
    /// Steps of eight samples up to the east.
    Staircase,
    /// x·z about the middle: saddle cells, the worst case of the patch's root.
    Saddle,
    /// A slope with a last-bit unevenness: cells that are planes but for rounding.
    NearlyPlanar,
    /// Flat, at the lowest height.
    FlatLow,
    /// Flat, at the highest height.
    FlatHigh,
    /// Flat but for a single sample of full height.
    OneHigh,
    /// High but for a single sample at the bottom.
    OneLow,
    /// White noise: every slope is one of a full relief a cell.
    Noise,
    /// A fractal with this many samples along a side.
    Fractal(u32),
    /// Ridges with these columns and rows.
    Shape(u32, u32),
}

impl Terrain {
    /// What the tables call it.
    pub(super) fn name(self) -> String {
        match self {
            Self::Needles => "needles".into(),
            Self::Wall => "wall".into(),
            Self::Cliff => "cliff".into(),
            Self::Checkerboard => "checkerboard".into(),
            Self::Terraces => "terraces".into(),
            Self::Staircase => "staircase".into(),
            Self::Saddle => "saddle".into(),
            Self::NearlyPlanar => "nearly-planar".into(),
            Self::FlatLow => "flat-low".into(),
            Self::FlatHigh => "flat-high".into(),
            Self::OneHigh => "one-high-sample".into(),
            Self::OneLow => "one-low-sample".into(),
            Self::Noise => "noise".into(),
            Self::Fractal(size) => format!("fractal-{size}"),
            Self::Shape(width, height) => format!("{width}x{height}"),
        }
    }

    /// The map, with `side` samples each way where the terrain has no size of its own.
    ///
    /// # Errors
    /// None that a terrain of this list can cause.
    pub(super) fn map(self, side: u32) -> Result<Arc<HeightField>, HeightFieldError> {
        let last = f64::from(side - 1);
        let unit = |i: u32| f64::from(i) / last;
        let hills = |x: f64, z: f64| 0.5 + 0.25 * ((9.0 * x).sin() + (7.0 * z + 2.0 * x).cos());
        let square = |height: &dyn Fn(u32, u32) -> f64| of(side, side, height);
        let map = match self {
            Self::Needles => square(&|x, z| f64::from(u8::from(x % 7 == 3 && z % 7 == 3)))?,
            Self::Wall => square(&|x, z| f64::from(u8::from(x == side / 3 && !(z > side / 2 && z < side / 2 + 4))))?,
            Self::Cliff => square(&|x, z| if x < side / 2 { 0.04 * unit(z) } else { 1.0 - 0.04 * unit(z) })?,
            Self::Checkerboard => square(&|x, z| f64::from((x + z) % 2))?,
            Self::Terraces => square(&|x, z| (hills(unit(x), unit(z)) * 8.0).floor())?,
            Self::Staircase => square(&|x, _| f64::from(x / 8))?,
            Self::Saddle => square(&|x, z| (unit(x) - 0.5) * (unit(z) - 0.5))?,
            Self::NearlyPlanar => {
                square(&|x, z| unit(x) + 0.5 * unit(z) + f64::from((x * 7 + z * 13) % 3) * f64::from(f32::EPSILON))?
            }
            Self::FlatLow => square(&|_, _| 0.0)?,
            // A map that is flat is all 0; the rim of a crater far outside lifts it to the top.
            Self::FlatHigh => {
                let mut edited = EditedTerrain::new(Arc::new(square(&|_, _| 0.0)?));
                edited.set_craters(&[Crater { x: -9.0, z: 0.5, radius: 10.0, depth: 0.0, rim: 10.0 }]);
                edited.field().clone()
            }
            Self::OneHigh => square(&|x, z| f64::from(u8::from([x, z] == [side / 2, side / 2 + 1])))?,
            Self::OneLow => square(&|x, z| f64::from(u8::from([x, z] != [side / 2, side / 2 + 1])))?,
            Self::Noise => square(&|x, z| hash(x, z))?,
            Self::Fractal(size) => return Ok(Arc::new(generate(Kind::DiamondSquare, size, 1))),
            Self::Shape(width, height) => {
                let noise = generate(Kind::Ridged, 256, 5);
                // Longer than the noise, the map goes there and back.
                let mirrored = |t: u32| if (t / 256).is_multiple_of(2) { t % 256 } else { 255 - t % 256 };
                of(width, height, &|x, z| f64::from(noise.sample(mirrored(x), mirrored(z))))?
            }
        };
        Ok(Arc::new(map))
    }
}

fn of(width: u32, height: u32, at: &dyn Fn(u32, u32) -> f64) -> Result<HeightField, HeightFieldError> {
    let raw: Vec<f64> = (0..height).flat_map(|z| (0..width).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
    HeightField::from_raw(width, height, &raw)
}

/// White noise, 0..1 (the finaliser of SplitMix64; Steele, Lea, Flood 2014).
pub(super) fn hash(x: u32, z: u32) -> f64 {
    let mut bits = (u64::from(x) << 32 | u64::from(z)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ bits >> 31) >> 11) as f64 / (1u64 << 53) as f64
}
