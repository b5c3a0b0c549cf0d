//! Craters: their shape, and the second texture of the layered mode.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::field::{bilinear, normalised};
use super::{HeightField, SampleRect};

/// A crater.
///
/// With s = distance / radius, the ground is displaced by
/// - −depth + (depth + rim)·s² for s ≤ 1: a parabolic bowl that rises from −depth to the crest of the rim;
/// - rim·(1 − t)²·(1 + 2t) with t = (s − 1) / (REACH − 1) for 1 ≤ s ≤ REACH: the rim's smooth outer slope;
/// - 0 beyond.
///
/// The slope is continuous everywhere except on the crest, which is the edge that a crater has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crater {
    /// West–east position of its centre in world units (the longer horizontal side of the box is 1).
    pub x: f64,
    /// North–south position of its centre in world units.
    pub z: f64,
    /// Distance from the centre to the crest of the rim in world units.
    pub radius: f64,
    /// Depth at the centre as a share of the box's height.
    pub depth: f64,
    /// Height of the crest as a share of the box's height.
    pub rim: f64,
}

impl Crater {
    /// Where the ground is untouched again, in radii.
    pub const REACH: f64 = 1.6;

    /// Most that depth and rim can be: far more than clears the box, and so little that the sum of a layer's craters
    /// stays finite in single precision.
    pub const MOST_SHARE: f64 = 1e6;

    /// Whether the numbers make a crater: all finite, radius above 0, depth and rim 0 to [`Self::MOST_SHARE`].
    pub fn is_valid(&self) -> bool {
        let Self { x, z, radius, depth, rim } = *self;
        let shares = 0.0..=Self::MOST_SHARE;
        [x, z, radius].into_iter().all(f64::is_finite)
            && radius > 0.0
            && shares.contains(&depth)
            && shares.contains(&rim)
    }

    /// Displacement of the ground at a horizontal distance (world units) from the centre, as a share of the box's
    /// height.
    pub fn displacement(&self, distance: f64) -> f64 {
        let s = distance / self.radius;
        if s <= 1.0 {
            -self.depth + (self.depth + self.rim) * s * s
        } else if s < Self::REACH {
            let t = (s - 1.0) / (Self::REACH - 1.0);
            self.rim * (1.0 - t) * (1.0 - t) * (1.0 + 2.0 * t)
        } else {
            0.0
        }
    }

    /// The samples of `grid` that the crater can displace; `None` where it lies beside the map or is not valid.
    pub(super) fn rect(&self, grid: &Grid) -> Option<SampleRect> {
        if !self.is_valid() {
            return None;
        }
        let reach = self.radius * Self::REACH;
        let span = |centre: f64, side: f64, count: u32| {
            let scale = f64::from(count - 1) / side;
            let (first, last) = (((centre - reach) * scale).ceil(), ((centre + reach) * scale).floor());
            let highest = f64::from(count - 1);
            // Converted last: both are finite and within the grid then.
            (first <= last && first <= highest && last >= 0.0).then(|| {
                let (first, last) = (first.max(0.0) as u32, last.min(highest) as u32);
                (first, last - first + 1)
            })
        };
        let (x, width) = span(self.x, grid.sides[0], grid.width)?;
        let (y, height) = span(self.z, grid.sides[1], grid.height)?;
        Some(SampleRect { x, y, width, height })
    }
}

/// Samples on grid corners over the whole map, and the sides of the map in world units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) sides: [f64; 2],
}

impl Grid {
    /// The grid of the map's own samples.
    pub(super) fn of(field: &HeightField) -> Self {
        let size = field.box_size(None);
        Self { width: field.width(), height: field.height(), sides: [size.x, size.z] }
    }

    /// Calls `edit(sample, displacement)` for the samples of `row` that `crater` can displace, given `rect`, the
    /// crater's samples. `columns` holds the row's samples from column `first` on.
    pub(super) fn displace_row(
        &self,
        crater: &Crater,
        rect: SampleRect,
        row: u32,
        first: u32,
        columns: &mut [f32],
        edit: impl Fn(&mut f32, f64),
    ) {
        if !(rect.y..rect.y + rect.height).contains(&row) {
            return;
        }
        let position = |index: u32, count: u32, side: f64| f64::from(index) / f64::from(count - 1) * side;
        let dz = position(row, self.height, self.sides[1]) - crater.z;
        let (start, end) = (rect.x.max(first), (rect.x + rect.width).min(first + columns.len() as u32));
        for column in start..end {
            let dx = position(column, self.width, self.sides[0]) - crater.x;
            let displacement = crater.displacement((dx * dx + dz * dz).sqrt());
            edit(&mut columns[(column - first) as usize], displacement);
        }
    }
}

/// The second texture of the layered mode: the sum of all craters' displacements on a grid of its own resolution.
#[derive(Clone, Debug, PartialEq)]
pub struct CraterLayer {
    /// Columns, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
    /// Displacements as shares of the box's height, row by row; column i stands at u = i / (width − 1).
    pub data: Vec<f32>,
    /// The largest positive displacement, or 0: how far the ground can rise above the map's own heights.
    pub rise: f32,
}

impl CraterLayer {
    /// Samples the craters over the map of `field`. The longer side gets `resolution` samples (at least 2), the other
    /// side as many as its length asks for.
    pub fn rasterise(craters: &[Crater], field: &HeightField, resolution: u32) -> Self {
        let size = field.box_size(None);
        let samples = |side: f64| (f64::from(resolution) * side).round().max(2.0) as u32;
        let grid = Grid { width: samples(size.x), height: samples(size.z), sides: [size.x, size.z] };
        let placed: Vec<_> = craters.iter().filter_map(|crater| Some((crater, crater.rect(&grid)?))).collect();
        let mut data = vec![0f32; grid.width as usize * grid.height as usize];
        data.par_chunks_mut(grid.width as usize).enumerate().for_each(|(row, columns)| {
            for &(crater, rect) in &placed {
                grid.displace_row(crater, rect, row as u32, 0, columns, |sample, by| {
                    *sample = (f64::from(*sample) + by) as f32;
                });
            }
        });
        let rise = data.par_iter().copied().reduce(|| 0.0, f32::max);
        Self { width: grid.width, height: grid.height, data, rise }
    }

    /// Displacement at `u` west–east and `v` north–south, each 0..1 over the map: bilinear between the samples.
    pub fn sample(&self, u: f64, v: f64) -> f64 {
        bilinear(&self.data, self.width, self.height, u, v)
    }

    /// The map with the layer added at its samples and clamped to 0..1.
    pub fn apply_to(&self, field: &HeightField) -> HeightField {
        let mut displaced = field.clone().without_units();
        let [columns, rows] = field.cells().map(f64::from);
        displaced.samples_mut().par_chunks_mut(field.width() as usize).enumerate().for_each(|(row, samples)| {
            for (column, sample) in samples.iter_mut().enumerate() {
                let by = self.sample(column as f64 / columns, row as f64 / rows);
                *sample = normalised(f64::from(*sample) + by);
            }
        });
        displaced
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::random_field;
    use super::*;

    const CRATER: Crater = Crater { x: 0.5, z: 0.25, radius: 0.1, depth: 0.3, rim: 0.05 };

    #[test]
    fn the_profile_is_a_bowl_with_a_rim_and_no_steps() {
        assert_eq!(CRATER.displacement(0.0), -0.3);
        assert!((CRATER.displacement(0.1) - 0.05).abs() < 1e-15);
        assert_eq!(CRATER.displacement(0.1 * Crater::REACH), 0.0);
        let at = |i: u32| CRATER.displacement(f64::from(i) * 1e-5);
        let steps: Vec<f64> = (0..20_000).map(|i| at(i + 1) - at(i)).collect();
        assert!(steps.iter().all(|step| step.abs() < 1e-4), "continuous");
        let bends = (1..steps.len()).filter(|&i| (steps[i] - steps[i - 1]).abs() > 1e-6).count();
        assert!(bends <= 2, "smooth except on the crest, but bends {bends} times");
        assert!((0..20_000).all(|i| at(i) <= 0.05 + 1e-15), "nothing is higher than the rim");
    }

    #[test]
    fn what_is_no_crater_displaces_nothing() {
        let grid = Grid { width: 9, height: 9, sides: [1.0, 1.0] };
        for bad in [
            Crater { radius: 0.0, ..CRATER },
            Crater { radius: f64::NAN, ..CRATER },
            Crater { depth: -1.0, ..CRATER },
            Crater { depth: f64::MAX, rim: f64::MAX, ..CRATER },
            Crater { rim: f64::NAN, ..CRATER },
            Crater { x: f64::INFINITY, ..CRATER },
        ] {
            assert!(!bad.is_valid() && bad.rect(&grid).is_none(), "{bad:?}");
        }
        assert_eq!(Crater { x: 5.0, ..CRATER }.rect(&grid), None, "beside the map");
        let huge = Crater { radius: 1e300, ..CRATER };
        assert_eq!(huge.rect(&grid), Some(SampleRect { x: 0, y: 0, width: 9, height: 9 }));
    }

    #[test]
    fn a_layer_has_the_maps_proportion_and_the_craters_shape() {
        let field = random_field(65, 33, 1);
        let other = Crater { x: 0.55, ..CRATER };
        let layer = CraterLayer::rasterise(&[CRATER, other], &field, 257);
        assert_eq!((layer.width, layer.height), (257, 129));
        for (x, z) in [(0.5, 0.25), (0.57, 0.3), (0.41, 0.22), (0.9, 0.1)] {
            let exact = [CRATER, other].iter().map(|c| c.displacement((x - c.x).hypot(z - c.z))).sum::<f64>();
            assert!((layer.sample(x, z / 0.5) - exact).abs() < 0.02, "at {x}, {z}");
        }
        assert_eq!(layer.rise, layer.data.iter().copied().fold(0.0, f32::max));
        let applied = layer.apply_to(&field);
        let expected = (f64::from(field.sample(32, 16)) + layer.sample(0.5, 0.5)).clamp(0.0, 1.0) as f32;
        assert_eq!(applied.sample(32, 16), expected);
        assert_eq!(CraterLayer::rasterise(&[], &field, 0).data, [0.0; 4]);
    }
}
