//! Ground with invented detail: the bilinear surface, and octaves of gradient noise (Perlin 2002) finer than its samples.
//!
//! The lattices of all octaves include the samples, where the noise is 0: what was measured stays as it is. Between them the
//! noise goes on as the map leaves off. The distance of a sample from the middle between two others is what midpoint
//! displacement (Fournier, Fussell, Carpenter 1982) draws at random; from a span of two samples to a span of one it falls as
//! from four to two, which [`Detail::of`] measures over the whole map (log₂ of it is the Hurst exponent H, and 2H + 1 the
//! slope of the map's spectrum). How large it is at a place follows from the sample's own distance from its neighbours. So
//! the coarsest octave, whose root mean square at the middle of two samples is a quarter of its height, is four times the
//! expected deviation high.
//!
//! Its octaves fade where they would be finer than the eye's pixels: the surface depends on where it is seen from.

use rayon::prelude::*;

use super::HeightField;

/// Octaves at most; the cells of the last are 1/128 of the map's.
pub const OCTAVES: u32 = 8;
/// The most that the noise can be: its gradients are unit vectors.
const MOST_NOISE: f64 = std::f64::consts::FRAC_1_SQRT_2 + 1e-6;
/// The steepest that it can be along any direction, a little more than a search over places, directions and gradients finds.
const MOST_SLOPE: f64 = 2.08;
/// Mean of the lesser of two normal variables' absolute values over their standard deviation, 2 (√2 − 1) / √π.
const MEAN_OVER_DEVIATION: f64 = 0.467_391;
/// The noise's root mean square at the middle between two samples.
const MIDDLE: f64 = 0.25;
/// Heights of an octave over the one before that detail can have: from H = 1, where terrain is smooth, to H = 0.3.
const GAINS: [f64; 2] = [0.5, 0.812];

/// How high the detail is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Height of the coarsest octave over how much the ground bends at a place.
    pub amplitude: f64,
    /// Height of an octave over the one before.
    pub gain: f64,
}

impl Detail {
    /// The detail that goes on as `field` leaves off, its heights multiplied by `strength`.
    pub fn of(field: &HeightField, strength: f64) -> Self {
        let gain = (mean_bend(field, 1) / mean_bend(field, 2).max(f64::MIN_POSITIVE)).clamp(GAINS[0], GAINS[1]);
        Self { amplitude: strength * gain / (MIDDLE * MEAN_OVER_DEVIATION), gain }
    }

    /// Heights of all octaves together over that of the coarsest.
    fn total(&self) -> f64 {
        (0..OCTAVES).map(|octave| self.gain.powi(octave as i32)).sum()
    }

    /// The highest that the ground with its detail can be at a sample's share of a cell, normalised.
    pub(super) fn bound(&self, field: &HeightField, x: u32, y: u32) -> f64 {
        let height = f64::from(field.sample(x, y));
        (height + bend(field, x, y) * self.amplitude * MOST_NOISE * self.total() + 1e-7).min(1.0)
    }
}

/// Mean distance of samples from the middle between two `step` beside them, along both axes; normalised.
fn mean_bend(field: &HeightField, step: u32) -> f64 {
    let (width, height) = (field.width(), field.height());
    let off = |a: f32, b: f32, c: f32| f64::from(b) - 0.5 * (f64::from(a) + f64::from(c));
    // Rows, then their sums in order: the same on any number of threads.
    let rows: Vec<(f64, u64)> = (0..height)
        .into_par_iter()
        .map(|y| {
            let along = (step..width.saturating_sub(step))
                .map(|x| off(field.sample(x - step, y), field.sample(x, y), field.sample(x + step, y)).abs());
            let (mut sum, mut count) = along.fold((0.0, 0), |(sum, count), off| (sum + off, count + 1));
            if y >= step && y + step < height {
                for x in 0..width {
                    sum += off(field.sample(x, y - step), field.sample(x, y), field.sample(x, y + step)).abs();
                    count += 1;
                }
            }
            (sum, count)
        })
        .collect();
    let (sum, count) = rows.into_iter().fold((0.0, 0), |(a, b), (sum, count)| (a + sum, b + count));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// How much the ground bends at a sample: its distance from the middle between its neighbours, along that axis where it is
/// less; an axis along which it has not two counts as straight. A ridge or a rim bends along one axis alone, and is no
/// roughness. Normalised.
fn bend(field: &HeightField, x: u32, y: u32) -> f64 {
    let at = |x: u32, y: u32| f64::from(field.sample(x, y));
    let inner = |at: u32, side: u32| at > 0 && at + 1 < side;
    let across = if inner(x, field.width()) { at(x, y) - 0.5 * (at(x - 1, y) + at(x + 1, y)) } else { 0.0 };
    let down = if inner(y, field.height()) { at(x, y) - 0.5 * (at(x, y - 1) + at(x, y + 1)) } else { 0.0 };
    across.abs().min(down.abs())
}

/// Share of an octave with cells `spacing` wide that shows where a pixel is `pixel` wide, in cells of the map.
fn shown(spacing: f64, pixel: f64) -> f64 {
    (0.5 * spacing / pixel - 1.0).clamp(0.0, 1.0)
}

/// A well mixed hash of a lattice point (`lowbias32`, Wellons 2018).
fn hash(x: u32, z: u32, octave: u32) -> u32 {
    let mut v = x
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add(z.wrapping_mul(0x85eb_ca77))
        .wrapping_add(octave.wrapping_mul(0xc2b2_ae3d));
    v = (v ^ (v >> 16)).wrapping_mul(0x7feb_352d);
    v = (v ^ (v >> 15)).wrapping_mul(0x846c_a68b);
    v ^ (v >> 16)
}

/// An octave's noise at a place within a cell of the map.
fn octave_at(cell: [u32; 2], place: [f64; 2], octave: u32) -> f64 {
    let side = f64::from(1u32 << octave);
    let base = place.map(|at| (at * side).floor().clamp(0.0, side - 1.0));
    let f = [place[0] * side - base[0], place[1] * side - base[1]];
    let fade = f.map(|f| f * f * f * (f * (f * 6.0 - 15.0) + 10.0));
    let mut value = 0.0;
    for (dx, dz) in [(0u32, 0u32), (1, 0), (0, 1), (1, 1)] {
        let lattice = |axis: usize, by: u32| (cell[axis] << octave).wrapping_add(base[axis] as u32).wrapping_add(by);
        let v = hash(lattice(0, dx), lattice(1, dz), octave);
        let a = f64::from(v & 0xffff) / 32768.0 - 1.0;
        let b = (1.0 - a.abs()) * if v & 0x1_0000 != 0 { 1.0 } else { -1.0 };
        let weight = |fade: f64, by: u32| if by == 1 { fade } else { 1.0 - fade };
        let ramp = (a * (f[0] - f64::from(dx)) + b * (f[1] - f64::from(dz))) / a.hypot(b);
        value += weight(fade[0], dx) * weight(fade[1], dz) * ramp;
    }
    value
}

/// A cell of the map with what its detail is made of; heights in world units.
struct Patch {
    cell: [u32; 2],
    corners: [f64; 4],
    /// Heights of the coarsest octave at the corners.
    heights: [f64; 4],
    gain: f64,
}

fn bilinear(corners: [f64; 4], [x, z]: [f64; 2]) -> f64 {
    let mix = |a: f64, b: f64, f: f64| a + (b - a) * f;
    mix(mix(corners[0], corners[1], x), mix(corners[2], corners[3], x), z)
}

impl Patch {
    fn new(field: &HeightField, detail: &Detail, scale: f64, cell: [u32; 2]) -> Self {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, z)| (cell[0] + x, cell[1] + z));
        Self {
            cell,
            corners: corners.map(|(x, z)| f64::from(field.sample(x, z)) * scale),
            heights: corners.map(|(x, z)| detail.amplitude * bend(field, x, z) * scale),
            gain: detail.gain,
        }
    }

    /// Height of the ground at a place within the cell, where a pixel is `pixel` cells wide.
    fn height(&self, place: [f64; 2], pixel: f64) -> f64 {
        let place = place.map(|at| at.clamp(0.0, 1.0));
        let (mut sum, mut gain, mut spacing) = (0.0, 1.0, 1.0);
        for octave in 0..OCTAVES {
            let share = shown(spacing, pixel);
            if share <= 0.0 {
                break;
            }
            sum += gain * share * octave_at(self.cell, place, octave);
            (gain, spacing) = (gain * self.gain, spacing * 0.5);
        }
        bilinear(self.corners, place) + bilinear(self.heights, place) * sum
    }
}

/// The first distance in `begin..=end` along the ray at which it is on or below the ground with its detail, within a cell.
/// `origin` and `direction` are in cells horizontally; `pixel` is how wide a pixel is at the distance 0 and its growth, in
/// cells.
///
/// Halves the way as long as the steepest that the ground can be leaves a crossing possible.
pub(super) fn first_meeting(
    (field, detail): (&HeightField, &Detail),
    scale: f64,
    (origin, direction): ([f64; 3], [f64; 3]),
    [begin, end]: [f64; 2],
    cell: [u32; 2],
    pixel: [f64; 2],
) -> Option<f64> {
    let patch = Patch::new(field, detail, scale, cell);
    let width = |at: f64| (pixel[0] + pixel[1] * at).max(1e-9);
    let most = patch.heights.into_iter().fold(0.0, f64::max);
    let highest = patch.corners.into_iter().fold(0.0, f64::max) + most * MOST_NOISE * detail.total();
    if (origin[1] + direction[1] * begin).min(origin[1] + direction[1] * end) > highest {
        return None;
    }
    let across = direction[0].hypot(direction[2]);
    let steepest = |corners: [f64; 4]| {
        let [a, b, c, d] = corners;
        (b - a).abs().max((d - c).abs()).hypot((c - a).abs().max((d - b).abs())) * across
    };
    let (mut rate, mut gain, mut spacing) = (direction[1].abs() + steepest(patch.corners), 1.0, 1.0);
    for _ in 0..OCTAVES {
        let share = gain * shown(spacing, width(begin));
        let full = width(begin).max(0.25 * spacing);
        let fading = MOST_NOISE * 0.5 * spacing * pixel[1] / (full * full);
        rate += share * (most * (MOST_SLOPE * across / spacing + fading) + MOST_NOISE * steepest(patch.heights));
        (gain, spacing) = (gain * detail.gain, spacing * 0.5);
    }
    let above = |at: f64| {
        let place =
            [origin[0] + direction[0] * at - f64::from(cell[0]), origin[2] + direction[2] * at - f64::from(cell[1])];
        origin[1] + direction[1] * at - patch.height(place, width(at))
    };
    if above(begin) <= 0.0 {
        return Some(begin);
    }
    let finest = (end - begin) * 2f64.powi(-22);
    // What is still to be looked at, the nearest last.
    let mut parts = vec![[begin, end]];
    while let Some([from, to]) = parts.pop() {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let height = above(middle);
        if height > rate * half {
            continue;
        }
        if half <= finest {
            if height <= 0.0 || above(to) <= 0.0 {
                return Some(middle);
            }
            continue;
        }
        parts.extend([[middle, to], [from, middle]]);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::bounds::{Rule, SurfaceBounds};
    use super::super::generate::{Kind, Recipe};
    use super::super::testing::{Numbers, random_field};
    use super::*;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn the_samples_stay_as_they_are_and_so_does_what_is_far() {
        let field = random_field(9, 7, 3);
        let detail = Detail::of(&field, 1.0);
        let patch = Patch::new(&field, &detail, 1.0, [3, 2]);
        for (corner, place) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].into_iter().enumerate() {
            assert!((patch.height(place, 1e-4) - patch.corners[corner]).abs() < 1e-12);
        }
        let place = [0.3, 0.6];
        assert_ne!(patch.height(place, 1e-4), bilinear(patch.corners, place));
        assert_eq!(patch.height(place, 0.5), bilinear(patch.corners, place), "no detail where two pixels cover a cell");
        // Nothing pops: a little nearer is a little more.
        for pixel in [0.45, 0.2, 0.1, 0.011] {
            let by = patch.height(place, pixel) - patch.height(place, pixel * 1.001);
            assert!(by.abs() < 0.01, "{pixel}: {by}");
        }
    }

    #[test]
    fn neighbouring_cells_meet() {
        let field = random_field(12, 12, 5);
        let detail = Detail::of(&field, 1.0);
        let mut numbers = Numbers::new(3);
        for _ in 0..200 {
            let (x, z, at) = (numbers.below(10), numbers.below(10), numbers.unit());
            let pixel = numbers.between(1e-4, 0.4);
            let own = Patch::new(&field, &detail, 1.0, [x, z]);
            let east = Patch::new(&field, &detail, 1.0, [x + 1, z]);
            let south = Patch::new(&field, &detail, 1.0, [x, z + 1]);
            assert!((own.height([1.0, at], pixel) - east.height([0.0, at], pixel)).abs() < 1e-12);
            assert!((own.height([at, 1.0], pixel) - south.height([at, 0.0], pixel)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_noise_is_nowhere_higher_or_steeper_than_is_said() {
        let (mut numbers, step) = (Numbers::new(7), 1e-6);
        for _ in 0..40_000 {
            let cell = [numbers.below(4000), numbers.below(4000)];
            let place = [numbers.between(0.001, 0.999), numbers.between(0.001, 0.999)];
            let angle = numbers.between(0.0, std::f64::consts::TAU);
            let ahead = [place[0] + angle.cos() * step, place[1] + angle.sin() * step];
            let (here, there) = (octave_at(cell, place, 0), octave_at(cell, ahead, 0));
            assert!(here.abs() <= MOST_NOISE && (there - here).abs() / step < MOST_SLOPE + 1e-3, "{here} {there}");
        }
    }

    #[test]
    fn bounds_lie_above_the_ground_with_its_detail() {
        let mut numbers = Numbers::new(8);
        for field in [random_field(17, 12, 5), random_field(17, 12, 6).rounded_to_16_bits()] {
            let detail = Detail::of(&field, 1.0);
            let bounds = SurfaceBounds::new(&field, Rule { smooth: false, detail: Some(detail) });
            for _ in 0..5_000 {
                let cell = [numbers.below(16), numbers.below(11)];
                let place = [numbers.unit(), numbers.unit()];
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let bound =
                    corners.map(|(i, j)| bounds.bound(cell[0] + i, cell[1] + j)).into_iter().fold(0.0, f32::max);
                let ground = Patch::new(&field, &detail, 1.0, cell).height(place, 1e-4).min(1.0);
                assert!(ground <= f64::from(bound), "{ground} above {bound}");
            }
        }
    }

    /// The fall from span to span is the map's own.
    #[test]
    fn rougher_land_gets_rougher_detail() {
        let gain = |roughness| {
            let recipe = Recipe { roughness, ..Recipe::new(Kind::DiamondSquare, 3) };
            let field = recipe.make([257; 2], &|_| {}, &AtomicBool::new(false)).unwrap();
            Detail::of(&field, 1.0).gain
        };
        let gains = [0.5, 0.6, 0.7].map(gain);
        assert!(gains[0] < gains[1] && gains[1] < gains[2], "{gains:?}");
        let flat = HeightField::from_raw(5, 5, &[0.0f32; 25]).unwrap();
        assert!(Detail::of(&flat, 1.0).amplitude.is_finite());
        assert_eq!(Detail::of(&random_field(9, 9, 2), 0.0).amplitude, 0.0);
    }
}
