//! The terrain with its craters: heights and pyramid kept up to date where they change.

use std::sync::Arc;

use rayon::prelude::*;

use super::crater::Grid;
use super::{Crater, HeightField, MaxPyramid, NodeRect};

/// A rectangle of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SampleRect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl SampleRect {
    /// The smallest rectangle that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let right = (self.x + self.width).max(other.x + other.width);
        let bottom = (self.y + self.height).max(other.y + other.height);
        Self { x, y, width: right - x, height: bottom - y }
    }
}

/// What a change of the craters has changed, for whoever keeps a copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The samples that may differ.
    pub samples: SampleRect,
    /// The pyramid's nodes that may differ: at most one rectangle per level, finest first.
    pub nodes: Vec<NodeRect>,
}

/// A height map with craters written into it. The map itself stays as it is.
#[derive(Clone, Debug)]
pub struct EditedTerrain {
    base: Arc<HeightField>,
    /// The map with craters; absent while none displaces a sample.
    edited: Option<HeightField>,
    pyramid: MaxPyramid,
    craters: Vec<Crater>,
}

impl EditedTerrain {
    /// The map without craters.
    pub fn new(base: Arc<HeightField>) -> Self {
        let pyramid = MaxPyramid::build(&base);
        Self { base, edited: None, pyramid, craters: Vec::new() }
    }

    /// The map without craters.
    pub fn base(&self) -> &Arc<HeightField> {
        &self.base
    }

    /// The map with craters; the base itself while there are none.
    pub fn field(&self) -> &HeightField {
        self.edited.as_ref().unwrap_or(&self.base)
    }

    /// The maximum pyramid of [`Self::field`].
    pub fn pyramid(&self) -> &MaxPyramid {
        &self.pyramid
    }

    /// The samples that craters may have displaced; `None` while there are none.
    pub fn displaced(&self) -> Option<SampleRect> {
        let grid = Grid::of(&self.base);
        self.craters.iter().filter_map(|crater| crater.rect(&grid)).reduce(SampleRect::union)
    }

    /// The craters, oldest first.
    pub fn craters(&self) -> &[Crater] {
        &self.craters
    }

    /// Makes these the craters, oldest first: each displaces the ground that the ones before it left, and heights are
    /// clamped to 0..1 after each. Only the samples around craters that are new, gone or moved in the order are
    /// computed again, and the result does not depend on the way there. `None`: no sample was touched. A crater that
    /// is not valid stays in the list but displaces nothing.
    pub fn set_craters(&mut self, craters: &[Crater]) -> Option<Edit> {
        // Two that are not valid do the same, nothing, even where NaN makes them differ from themselves.
        let same = |(a, b): &(&Crater, &Crater)| a == b || !(a.is_valid() || b.is_valid());
        let common = self.craters.iter().zip(craters).take_while(same).count();
        let grid = Grid::of(&self.base);
        let touched = self.craters[common..].iter().chain(&craters[common..]);
        let dirty = touched.filter_map(|crater| crater.rect(&grid)).reduce(SampleRect::union);
        let only_added = common == self.craters.len();
        self.craters.splice(common.., craters[common..].iter().copied());
        let dirty = dirty?;

        if self.craters.iter().all(|crater| crater.rect(&grid).is_none()) {
            self.edited = None;
        } else if only_added {
            self.recompute(&grid, dirty, common, false);
        } else {
            self.recompute(&grid, dirty, 0, true);
        }
        let field = self.edited.as_ref().unwrap_or(&self.base);
        let nodes = self.pyramid.update(field, dirty);
        Some(Edit { samples: dirty, nodes })
    }

    /// Applies the craters from index `first` on to the samples of `dirty`, on top of the base or of what is there.
    fn recompute(&mut self, grid: &Grid, dirty: SampleRect, first: usize, from_base: bool) {
        let placed: Vec<_> =
            self.craters[first..].iter().filter_map(|crater| Some((crater, crater.rect(grid)?))).collect();
        let base = &self.base;
        let units = base.units();
        let edited = self.edited.get_or_insert_with(|| (**base).clone());
        let width = grid.width as usize;
        let columns = dirty.x as usize..(dirty.x + dirty.width) as usize;
        let rows = dirty.y as usize * width..(dirty.y + dirty.height) as usize * width;
        edited.samples_mut()[rows].par_chunks_mut(width).enumerate().for_each(|(offset, row)| {
            let y = dirty.y + offset as u32;
            let samples = &mut row[columns.clone()];
            if from_base {
                let start = y as usize * width;
                samples.copy_from_slice(&base.samples()[start + columns.start..start + columns.end]);
            }
            for &(crater, rect) in &placed {
                grid.displace_row(crater, rect, y, dirty.x, samples, |sample, by| {
                    *sample = HeightField::nearest_height(units, f64::from(*sample) + by);
                });
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Numbers, random_field};
    use super::*;

    fn random_crater(numbers: &mut Numbers) -> Crater {
        let radius = if numbers.below(12) == 0 { -1.0 } else { numbers.between(0.01, 0.15) };
        Crater {
            x: numbers.between(-0.1, 1.1),
            z: numbers.between(-0.1, 0.8),
            radius,
            depth: numbers.between(0.0, 0.6),
            rim: numbers.between(0.0, 0.2),
        }
    }

    #[test]
    fn whatever_the_way_the_result_is_a_fresh_build_bit_for_bit() {
        let base = Arc::new(random_field(83, 57, 4));
        let mut numbers = Numbers::new(6);
        let mut terrain = EditedTerrain::new(base.clone());
        let mut list: Vec<Crater> = Vec::new();
        for step in 0..200 {
            match numbers.below(8) {
                0..4 => list.push(random_crater(&mut numbers)),
                4 | 5 => drop(list.pop()),
                6 if !list.is_empty() => drop(list.remove(numbers.below(list.len() as u32) as usize)),
                7 if numbers.below(4) == 0 => list.clear(),
                _ => list.reverse(),
            }
            let (before, pyramid_before) = (terrain.field().clone(), terrain.pyramid().clone());
            let edit = terrain.set_craters(&list);
            let mut fresh = EditedTerrain::new(base.clone());
            fresh.set_craters(&list);
            assert!(terrain.field() == fresh.field(), "step {step}");
            assert_eq!(terrain.pyramid(), &MaxPyramid::build(terrain.field()), "step {step}");
            assert_eq!(terrain.craters(), list);

            // What is not named as dirty has not changed.
            let dirty = edit.map(|edit| edit.samples);
            for (x, y) in (0..57).flat_map(|y| (0..83).map(move |x| (x, y))) {
                let inside =
                    dirty.is_some_and(|r| (r.x..r.x + r.width).contains(&x) && (r.y..r.y + r.height).contains(&y));
                assert!(inside || before.sample(x, y) == terrain.field().sample(x, y), "step {step}: {x}, {y}");
            }
            assert!(dirty.is_some() || pyramid_before == *terrain.pyramid());
        }
    }

    /// The GPU holds such a map in 16 bits: what an edit puts between two of their steps, it would not show.
    #[test]
    fn craters_in_a_map_of_16_bits_are_such_heights_too() {
        let raw: Vec<u16> = (0..65 * 65u32).map(|i| (i.wrapping_mul(40_503) >> 8) as u16 % 1868).collect();
        let base = Arc::new(HeightField::from_raw(65, 65, &raw).unwrap());
        let units = f32::from(base.units().unwrap());
        let mut terrain = EditedTerrain::new(base);
        terrain.set_craters(&[Crater { x: 0.5, z: 0.5, radius: 0.2, depth: 0.21, rim: 0.07 }]);
        assert_eq!(terrain.field().units().map(f32::from), Some(units));
        for &height in terrain.field().samples() {
            assert_eq!(height, ((height * units).round() as f64 / f64::from(units)) as f32);
        }
    }

    #[test]
    fn craters_displace_the_ground_and_stay_inside_the_box() {
        let base = Arc::new(random_field(65, 65, 2));
        let mut terrain = EditedTerrain::new(base.clone());
        let crater = Crater { x: 0.5, z: 0.5, radius: 0.1, depth: 0.2, rim: 0.0 };
        let edit = terrain.set_craters(&[crater]).unwrap();
        let expected = (f64::from(base.sample(32, 32)) - 0.2).max(0.0) as f32;
        assert_eq!(terrain.field().sample(32, 32), expected);
        assert!(edit.samples.width < 24 && edit.samples.x > 20, "only its surroundings: {edit:?}");
        terrain.set_craters(&[Crater { depth: 50.0, rim: 50.0, ..crater }]);
        assert!(terrain.field().samples().iter().all(|height| (0.0..=1.0).contains(height)));
    }

    #[test]
    fn without_craters_the_map_is_not_copied() {
        let base = Arc::new(random_field(20, 20, 2));
        let mut terrain = EditedTerrain::new(base.clone());
        let crater = Crater { x: 0.5, z: 0.5, radius: 0.1, depth: 0.2, rim: 0.1 };
        assert!(std::ptr::eq(terrain.field(), Arc::as_ptr(&base)));
        assert_eq!(terrain.set_craters(&[]), None);
        assert_eq!(terrain.set_craters(&[Crater { x: 9.0, ..crater }]), None, "beside the map");
        assert!(std::ptr::eq(terrain.field(), Arc::as_ptr(&base)));
        assert!(terrain.set_craters(&[crater]).is_some());
        assert_eq!(terrain.set_craters(&[crater]), None, "the same again");
        assert!(terrain.set_craters(&[]).is_some());
        assert!(std::ptr::eq(terrain.field(), Arc::as_ptr(&base)), "all taken back: the base itself");
        assert_eq!(*terrain.pyramid(), MaxPyramid::build(&base));
    }
}
