//! Fractal landscapes. The same kind, size and seed give the same samples on every platform: an integer hash, and
//! f64 sums, products and no function that platforms compute differently.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::HeightField;

/// Smallest number of octaves, also for small maps.
const MIN_OCTAVES: u32 = 8;

/// Amplitude of an octave over the one before it.
const ROUGHNESS: f64 = 0.5;

/// Cells of the coarsest octave of the noise along a side.
const BASE_FREQUENCY: f64 = 3.0;

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
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::DiamondSquare, Self::Perlin, Self::Ridged];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::DiamondSquare => "diamond-square",
            Self::Perlin => "perlin",
            Self::Ridged => "ridged",
        }
    }
}

/// A landscape of `size` × `size` samples that 16 bits hold, so that a saved one is the same; a size below 2 becomes 2.
pub fn generate(kind: Kind, size: u32, seed: u64) -> HeightField {
    generate_with_progress(kind, size, seed, &|_| {})
}

/// Like [`generate`]; `progress` hears the share done, 0..1, from several threads.
pub fn generate_with_progress(kind: Kind, size: u32, seed: u64, progress: &(dyn Fn(f32) + Sync)) -> HeightField {
    let size = size.max(2);
    let raw = match kind {
        Kind::DiamondSquare => diamond_square(size, seed, progress),
        Kind::Perlin => noise(size, progress, |x, y, octaves| perlin(seed, x, y, octaves)),
        Kind::Ridged => noise(size, progress, |x, y, octaves| ridged(seed, x, y, octaves)),
    };
    progress(1.0);
    #[expect(clippy::expect_used, reason = "the size is at least 2 and the noise is bounded; no input can change that")]
    let field = HeightField::from_raw(size, size, &raw).expect("noise is a height map");
    field.rounded_to_16_bits()
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

/// Octaves down to the distance of two samples, but at least [`MIN_OCTAVES`].
fn octaves(size: u32) -> u32 {
    size.ilog2().max(MIN_OCTAVES)
}

/// Evaluates `height(x, y, octaves)` over the map, with x and y in cells of the coarsest octave.
fn noise(size: u32, progress: &(dyn Fn(f32) + Sync), height: impl Fn(f64, f64, u32) -> f64 + Sync) -> Vec<f32> {
    let side = size as usize;
    let (octaves, step, done) = (octaves(size), BASE_FREQUENCY / f64::from(size - 1), AtomicUsize::new(0));
    let mut raw = vec![0.0; side * side];
    raw.par_chunks_mut(side).enumerate().for_each(|(row, samples)| {
        for (column, sample) in samples.iter_mut().enumerate() {
            *sample = height(column as f64 * step, row as f64 * step, octaves) as f32;
        }
        progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f32 / size as f32);
    });
    raw
}

/// Gradient noise, about −1 to 1, zero on the lattice, with 16 directions of equal length.
fn gradient_noise(seed: u64, octave: u32, x: f64, y: f64) -> f64 {
    // Cosine and sine of 22.5° × 0, 1, 2 and 3, as constants: a library's sine may differ between platforms.
    const TURNS: [(f64, f64); 4] = [
        (1.0, 0.0),
        (0.923_879_532_511_286_7, 0.382_683_432_365_089_8),
        (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2),
        (0.382_683_432_365_089_8, 0.923_879_532_511_286_7),
    ];
    let (cell_x, cell_y) = (x.floor(), y.floor());
    let (fx, fy) = (x - cell_x, y - cell_y);
    let corner = |i: u32, j: u32| {
        let random = hash(seed, octave, (cell_x as u32).wrapping_add(i), (cell_y as u32).wrapping_add(j));
        let (cos, sin) = TURNS[(random & 3) as usize];
        let (gx, gy) = match (random >> 2) & 3 {
            0 => (cos, sin),
            1 => (-sin, cos),
            2 => (-cos, -sin),
            _ => (sin, -cos),
        };
        gx * (fx - f64::from(i)) + gy * (fy - f64::from(j))
    };
    // Perlin's quintic: slope and curvature vanish on the lattice.
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let (u, v) = (fade(fx), fade(fy));
    mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v) * std::f64::consts::SQRT_2
}

/// Position in an octave, displaced so that the lattices of the octaves do not lie on each other.
fn octave_position(x: f64, y: f64, octave: u32) -> (f64, f64) {
    let (frequency, shift) = ((1u64 << octave) as f64, f64::from(octave));
    (x * frequency + 0.37 * shift + 0.5, y * frequency + 0.61 * shift + 0.25)
}

fn perlin(seed: u64, x: f64, y: f64, octaves: u32) -> f64 {
    let mut amplitude = 1.0;
    let mut sum = 0.0;
    for octave in 0..octaves {
        let (x, y) = octave_position(x, y, octave);
        sum += amplitude * gradient_noise(seed, octave, x, y);
        amplitude *= ROUGHNESS;
    }
    sum
}

fn ridged(seed: u64, x: f64, y: f64, octaves: u32) -> f64 {
    let mut amplitude = 1.0;
    let mut weight = 1.0;
    let mut sum = 0.0;
    for octave in 0..octaves {
        let (x, y) = octave_position(x, y, octave);
        let crest = 1.0 - gradient_noise(seed, octave, x, y).abs().min(1.0);
        // Detail gathers on the crests of the octave before, and valleys stay smooth.
        let signal = crest * crest * weight;
        weight = (signal * 2.0).min(1.0);
        sum += amplitude * signal;
        amplitude *= ROUGHNESS;
    }
    sum
}

/// Midpoint displacement, coarse grid to fine. A displacement is a hash of its place, so rows can be computed apart.
fn diamond_square(size: u32, seed: u64, progress: &(dyn Fn(f32) + Sync)) -> Vec<f32> {
    // Each grid needs every second point of the next one, and one beyond the border.
    let mut sizes = vec![size];
    let mut side = size;
    while side > 2 {
        side = side / 2 + 1;
        sizes.push(side);
    }
    let mut grid = Grid { side: side as usize, heights: (0..4).map(|i| signed(hash(seed, 0, i, 0)) as f32).collect() };
    let mut amplitude = 1.0;
    let total: f32 = sizes.iter().map(|&side| (side as f32).powi(2)).sum();
    let mut done = 0.0;
    for (level, &side) in sizes.iter().rev().enumerate().skip(1) {
        let side = side as usize;
        let finer = Finer { coarse: &grid, side, seed, level: level as u32, amplitude };
        let mut heights = vec![0.0; side * side];
        heights.par_chunks_mut(side).enumerate().for_each(|(y, row)| {
            for (x, height) in row.iter_mut().enumerate() {
                *height = finer.height(x, y) as f32;
            }
        });
        grid = Grid { side, heights };
        amplitude *= ROUGHNESS;
        done += (side * side) as f32;
        progress(done / total);
    }
    grid.heights
}

/// One level of midpoint displacement.
struct Grid {
    side: usize,
    heights: Vec<f32>,
}

/// The next level: every second point is a point of the coarse one.
struct Finer<'a> {
    coarse: &'a Grid,
    side: usize,
    seed: u64,
    level: u32,
    amplitude: f64,
}

impl Finer<'_> {
    fn height(&self, x: usize, y: usize) -> f64 {
        match (x % 2, y % 2) {
            (0, 0) => self.old(x, y),
            (1, 1) => self.diamond(x, y),
            _ => self.square(x, y),
        }
    }

    fn old(&self, x: usize, y: usize) -> f64 {
        f64::from(self.coarse.heights[y / 2 * self.coarse.side + x / 2])
    }

    fn displacement(&self, x: usize, y: usize, amplitude: f64) -> f64 {
        amplitude * signed(hash(self.seed, self.level, x as u32, y as u32))
    }

    /// The middle of four old points.
    fn diamond(&self, x: usize, y: usize) -> f64 {
        let corners = [(x - 1, y - 1), (x + 1, y - 1), (x - 1, y + 1), (x + 1, y + 1)];
        let mean = corners.into_iter().map(|(x, y)| self.old(x, y)).sum::<f64>() * 0.25;
        mean + self.displacement(x, y, self.amplitude)
    }

    /// The middle of two old points and the diamonds on both sides, or the one that is in the map.
    fn square(&self, x: usize, y: usize) -> f64 {
        let mut sum = 0.0;
        let mut count = 0.0;
        let neighbours = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        for (nx, ny) in neighbours {
            let is_old = nx % 2 == 0 && ny % 2 == 0;
            // The coarse grid reaches one point beyond an even side, the diamonds do not.
            let limit = if is_old { self.side + 1 } else { self.side };
            if nx < limit && ny < limit {
                sum += if is_old { self.old(nx, ny) } else { self.diamond(nx, ny) };
                count += 1.0;
            }
        }
        sum / count + self.displacement(x, y, self.amplitude * std::f64::consts::FRAC_1_SQRT_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of the samples' bits; another sum means that saved scenes and golden images show another landscape.
    #[test]
    fn a_seed_gives_the_same_landscape_everywhere() {
        let fingerprint = |kind, seed| {
            let field = generate(kind, 65, seed);
            field.samples().iter().fold(0u32, |sum, h| sum.rotate_left(5) ^ h.to_bits())
        };
        let expected = [0x2777_f4c9, 0xae58_089a, 0xc939_6d3d];
        assert_eq!(Kind::ALL.map(|kind| fingerprint(kind, 7)), expected);
        for kind in Kind::ALL {
            assert_ne!(fingerprint(kind, 7), fingerprint(kind, 8), "{kind:?}");
        }
    }

    #[test]
    fn every_size_is_filled_and_uses_the_whole_range() {
        for kind in Kind::ALL {
            for size in [2, 3, 4, 5, 6, 17, 33, 50, 100] {
                let field = generate(kind, size, 1);
                assert_eq!((field.width(), field.height()), (size, size));
                let (low, high) = field.samples().iter().fold((1f32, 0f32), |(a, b), &h| (a.min(h), b.max(h)));
                assert_eq!((low, high), (0.0, 1.0), "{kind:?} {size}");
            }
        }
        assert_eq!(generate(Kind::Perlin, 0, 1).width(), 2);
    }

    /// A landscape is rough on all scales, but smooth from sample to sample compared with its whole relief.
    #[test]
    fn landscapes_are_fractal() {
        for kind in Kind::ALL {
            let field = generate(kind, 513, 3);
            let roughness = |step: u32| {
                let pairs = (0..512 - step).step_by(7).flat_map(|x| (0..513).step_by(5).map(move |y| (x, y)));
                let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), (x, y)| {
                    (sum + (field.sample(x + step, y) - field.sample(x, y)).abs(), count + 1.0)
                });
                sum / count
            };
            let by_scale = [1, 4, 16, 64].map(roughness);
            assert!(by_scale[0] > 5e-4 && by_scale[0] < 0.02, "{kind:?} {by_scale:?}");
            for pair in by_scale.windows(2) {
                assert!((1.5..4.1).contains(&(pair[1] / pair[0])), "{kind:?} {by_scale:?}");
            }
        }
    }

    #[test]
    fn progress_ends_at_one() {
        for kind in Kind::ALL {
            let last = std::sync::Mutex::new(0.0);
            generate_with_progress(kind, 40, 1, &|share| *last.lock().unwrap() = share);
            assert_eq!(*last.lock().unwrap(), 1.0);
        }
    }
}
