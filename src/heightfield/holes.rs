//! Places of a height map that hold no height: the mask, and the surface that can be drawn over them.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// What becomes of samples that hold no height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Holes {
    /// The ground is missing there: rays pass
    #[default]
    CutOut,
    /// A smooth surface spans them, from their border inward
    Fill,
    /// They are as low as the lowest sample
    Floor,
}

/// Which samples hold no height: one bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HoleMask {
    width: u32,
    height: u32,
    /// Bits of one sample after the other, row by row.
    bits: Vec<u64>,
    count: u64,
}

impl HoleMask {
    /// A mask of `width` × `height` samples without a hole.
    pub fn new(width: u32, height: u32) -> Self {
        let samples = width as usize * height as usize;
        Self { width, height, bits: vec![0; samples.div_ceil(64)], count: 0 }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How many samples are holes.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Whether the sample with this index, row by row, is a hole; none is beyond the last.
    pub fn contains(&self, index: usize) -> bool {
        self.bits.get(index / 64).is_some_and(|bits| bits >> (index % 64) & 1 == 1)
    }

    /// Makes the sample with this index a hole; beyond the last there is none to make.
    pub fn insert(&mut self, index: usize) {
        if index >= self.width as usize * self.height as usize {
            return;
        }
        if let Some(bits) = self.bits.get_mut(index / 64) {
            self.count += u64::from(*bits >> (index % 64) & 1 == 0);
            *bits |= 1 << (index % 64);
        }
    }

    /// The indices of all holes, ascending.
    pub fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        self.bits.iter().enumerate().flat_map(|(word, &bits)| {
            let mut left = bits;
            std::iter::from_fn(move || {
                let bit = left.trailing_zeros();
                left &= left.wrapping_sub(1);
                (bit < 64).then(|| word * 64 + bit as usize)
            })
        })
    }
}

/// Passes over the holes of each level. From a start that the coarser level has already smoothed, so few bring what is
/// left of the error below what can be seen.
const SWEEPS: usize = 24;

/// Spans the holes with a smooth surface: the solution of Laplace's equation (each sample the mean of its neighbours)
/// with the heights around the holes as its border, found from coarse to fine. A plane with holes becomes nearly the
/// plane. The result depends on nothing but the samples.
///
/// `samples` are those of the mask's size, row by row; what stands in holes does not matter.
/// (Cascadic multigrid: Bornemann, Deuflhard 1996. The start on each level is the pull-push of Gortler et al. 1996.)
pub(super) fn fill(samples: &mut [f32], mask: &HoleMask) {
    let size = [mask.width as usize, mask.height as usize];
    let holes: Vec<usize> = mask.indices().collect();
    if holes.is_empty() || samples.len() != size[0] * size[1] {
        return;
    }
    let (coarse_size, mut coarse, coarse_mask) = halved(size, samples, mask);
    if size[0].max(size[1]) > 1 && coarse_mask.count < coarse_mask.bits.len() as u64 * 64 {
        fill(&mut coarse, &coarse_mask);
    }
    for &index in &holes {
        samples[index] = interpolated(&coarse, coarse_size, [index % size[0], index / size[0]]);
    }
    // There and back, so that no direction is preferred.
    for sweep in 0..SWEEPS {
        if sweep % 2 == 0 {
            holes.iter().for_each(|&index| relax(samples, size, index));
        } else {
            holes.iter().rev().for_each(|&index| relax(samples, size, index));
        }
    }
}

/// Makes a sample the mean of its neighbours. At the map's border those beyond are missing: the slope across it is 0.
fn relax(samples: &mut [f32], [width, height]: [usize; 2], index: usize) {
    let (x, y) = (index % width, index / width);
    let neighbours = [
        (x > 0).then(|| index - 1),
        (x + 1 < width).then(|| index + 1),
        (y > 0).then(|| index - width),
        (y + 1 < height).then(|| index + width),
    ];
    let (sum, count) =
        neighbours.into_iter().flatten().fold((0.0, 0.0), |(sum, count), at| (sum + samples[at], count + 1.0));
    if count > 0.0 {
        samples[index] = sum / count;
    }
}

/// Half the resolution: each sample the mean of those of its four that hold a height; a hole where none does.
fn halved([width, height]: [usize; 2], samples: &[f32], mask: &HoleMask) -> ([usize; 2], Vec<f32>, HoleMask) {
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let mut coarse = vec![0.0; size[0] * size[1]];
    let mut holes = HoleMask::new(size[0] as u32, size[1] as u32);
    for (index, value) in coarse.iter_mut().enumerate() {
        let (x, y) = (2 * (index % size[0]), 2 * (index / size[0]));
        let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].into_iter();
        let inside = four.filter(|&(x, y)| x < width && y < height).map(|(x, y)| y * width + x);
        let (sum, count) = inside
            .filter(|&index| !mask.contains(index))
            .fold((0.0, 0.0), |(sum, count), index| (sum + samples[index], count + 1.0));
        if count > 0.0 {
            *value = sum / count;
        } else {
            holes.insert(index);
        }
    }
    (size, coarse, holes)
}

/// The coarser level at a fine sample: its samples stand between four fine ones.
fn interpolated(coarse: &[f32], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> f32 {
    let split = |at: usize, count: usize| {
        let position = (at as f32 * 0.5 - 0.25).clamp(0.0, (count - 1) as f32);
        let first = (position as usize).min(count.saturating_sub(2));
        (first, (first + 1).min(count - 1), position - first as f32)
    };
    let ((x0, x1, fx), (y0, y1, fy)) = (split(x, width), split(y, height));
    let row = |y: usize| coarse[y * width + x0] * (1.0 - fx) + coarse[y * width + x1] * fx;
    row(y0) * (1.0 - fy) + row(y1) * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask_of(width: u32, height: u32, hole: impl Fn(u32, u32) -> bool) -> HoleMask {
        let mut mask = HoleMask::new(width, height);
        for index in 0..width * height {
            if hole(index % width, index / width) {
                mask.insert(index as usize);
            }
        }
        mask
    }

    #[test]
    fn a_mask_knows_its_holes() {
        let mut mask = mask_of(13, 11, |x, y| (x * y) % 3 == 1);
        let expected: Vec<usize> = (0..13 * 11).filter(|i| ((i % 13) * (i / 13)) % 3 == 1).collect();
        assert_eq!(mask.indices().collect::<Vec<_>>(), expected);
        assert_eq!(mask.count(), expected.len() as u64);
        mask.insert(expected[0]);
        mask.insert(13 * 11);
        assert_eq!(mask.count(), expected.len() as u64, "twice is once, and beyond the end is nowhere");
        assert!(!mask.contains(0) && !mask.contains(100_000));
    }

    /// The plane solves the equation exactly.
    #[test]
    fn a_hole_in_a_slope_is_filled_with_the_slope() {
        let plane = |x: u32, y: u32| 0.1 + 0.004 * x as f32 + 0.002 * y as f32;
        let at = |index: u32| plane(index % 120, index / 120);
        for hole in [40.0f32, 15.0, 2.0] {
            let mask = mask_of(120, 90, |x, y| (x as f32 - 60.0).hypot(y as f32 - 45.0) < hole);
            let mut samples: Vec<f32> =
                (0..120 * 90).map(|i| if mask.contains(i as usize) { 7.0 } else { at(i) }).collect();
            fill(&mut samples, &mask);
            let worst = (0..120 * 90u32).map(|i| (samples[i as usize] - at(i)).abs()).fold(0.0, f32::max);
            assert!(worst < 0.01, "a hole of radius {hole} in a plane of 0.6 height: {worst}");
        }
    }

    #[test]
    fn what_is_filled_lies_between_what_surrounds_it() {
        let mask = mask_of(64, 33, |x, y| x < 20 || (30..50).contains(&x) && y > 10);
        let mut samples: Vec<f32> = (0..64 * 33).map(|i| 0.2 + (i * 37 % 60) as f32 / 100.0).collect();
        let before = samples.clone();
        fill(&mut samples, &mask);
        for (index, (&now, &then)) in samples.iter().zip(&before).enumerate() {
            assert!(mask.contains(index) || now == then, "what holds a height keeps it");
            assert!((0.199..0.8).contains(&now), "{now}");
        }
        let mut again = before.clone();
        mask.indices().for_each(|index| again[index] = f32::MAX);
        fill(&mut again, &mask);
        assert_eq!(again, samples, "what stands in the holes does not matter");
    }
}
