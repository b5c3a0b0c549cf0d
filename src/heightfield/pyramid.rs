//! The maximum pyramid: for every node of a quadtree over the cells, the highest sample under it.
//!
//! Level 0 is the cells themselves; it is not stored, since its nodes are the maximum of four samples that are read
//! anyway. Level `l` has ⌈cells / 2^l⌉ nodes each way, so the last column or row of an odd level has fewer children.
//! A cell with a hole at a corner has no ground and counts as 0; its other corners still count in the cells beside it.
//! (Tevs, Ihrke, Seidel 2008: "Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering".)

use rayon::prelude::*;

use super::{HeightField, SampleRect};

/// One level of the pyramid.
#[derive(Clone, Debug, PartialEq)]
pub struct PyramidLevel {
    /// Columns of nodes.
    pub width: u32,
    /// Rows of nodes.
    pub height: u32,
    /// Normalised maxima, row by row.
    pub data: Vec<f32>,
}

impl PyramidLevel {
    /// The node in a column and row; beyond the border, the nearest one.
    pub fn node(&self, column: u32, row: u32) -> f32 {
        let (column, row) = (column.min(self.width - 1), row.min(self.height - 1));
        self.data[row as usize * self.width as usize + column as usize]
    }
}

/// A rectangle of nodes of one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NodeRect {
    /// The level; 1 is the finest that is stored.
    pub level: u32,
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// All stored levels over one height map.
#[derive(Clone, Debug, PartialEq)]
pub struct MaxPyramid {
    levels: Vec<PyramidLevel>,
}

impl MaxPyramid {
    /// Computes every level.
    pub fn build(field: &HeightField) -> Self {
        let mut size = field.cells();
        let mut levels = Vec::new();
        loop {
            size = size.map(|side| side.div_ceil(2));
            let [width, height] = size;
            levels.push(PyramidLevel { width, height, data: vec![0.0; width as usize * height as usize] });
            if size == [1, 1] {
                break;
            }
        }
        let mut pyramid = Self { levels };
        for index in 0..pyramid.levels.len() {
            let PyramidLevel { width, height, .. } = pyramid.levels[index];
            pyramid.recompute(field, index, [0, 0], [width - 1, height - 1]);
        }
        pyramid
    }

    /// Recomputes the nodes above the samples of `dirty`, level by level until nothing changes any more. Returns the
    /// rectangles that changed, at most one per level, finest first.
    pub fn update(&mut self, field: &HeightField, dirty: SampleRect) -> Vec<NodeRect> {
        if dirty.width == 0 || dirty.height == 0 {
            return Vec::new();
        }
        // A sample is a corner of the cells on both its sides.
        let cells = field.cells();
        let mut first = [dirty.x.saturating_sub(1), dirty.y.saturating_sub(1)];
        let mut last = [(dirty.x + dirty.width - 1).min(cells[0] - 1), (dirty.y + dirty.height - 1).min(cells[1] - 1)];
        let mut changed = Vec::new();
        for index in 0..self.levels.len() {
            first = first.map(|node| node / 2);
            last = last.map(|node| node / 2);
            if !self.recompute(field, index, first, last) {
                break;
            }
            let ([x, y], [width, height]) = (first, [last[0] - first[0] + 1, last[1] - first[1] + 1]);
            changed.push(NodeRect { level: index as u32 + 1, x, y, width, height });
        }
        changed
    }

    /// Recomputes the nodes from `first` to `last` of the level with this index, and says whether one changed.
    fn recompute(&mut self, field: &HeightField, index: usize, first: [u32; 2], last: [u32; 2]) -> bool {
        let (finer, rest) = self.levels.split_at_mut(index);
        let level = &mut rest[0];
        let width = level.width as usize;
        let rows = level.data[first[1] as usize * width..(last[1] as usize + 1) * width].par_chunks_mut(width);
        rows.enumerate()
            .map(|(offset, row)| {
                let y = first[1] + offset as u32;
                let mut changed = false;
                for x in first[0]..=last[0] {
                    let highest = match finer.last() {
                        Some(finer) => highest_child(finer, x, y),
                        None => highest_sample(field, x, y),
                    };
                    let node = &mut row[x as usize];
                    changed |= *node != highest;
                    *node = highest;
                }
                changed
            })
            .reduce(|| false, |a, b| a | b)
    }

    /// The stored levels: element 0 is level 1, the last has a single node. There is at least one, even over a single
    /// cell.
    pub fn levels(&self) -> &[PyramidLevel] {
        &self.levels
    }

    /// The highest sample of the map.
    pub fn top(&self) -> f32 {
        self.levels.last().map_or(0.0, |level| level.node(0, 0))
    }
}

/// The highest of the 3×3 samples on the corners of a level 1 node's 2×2 cells, less the cells without ground.
fn highest_sample(field: &HeightField, x: u32, y: u32) -> f32 {
    if field.holes().is_some() {
        let cells = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(column, row)| (2 * x + column, 2 * y + row));
        let [columns, rows] = field.cells();
        let grounds = cells.into_iter().filter(|&(x, y)| x < columns && y < rows && field.has_ground(x, y));
        let corners = grounds.flat_map(|(x, y)| [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]);
        return corners.map(|(x, y)| field.sample(x, y)).fold(0.0, f32::max);
    }
    let highest_of_row = |row: u32| (0..3).map(move |column| field.sample(2 * x + column, row)).fold(0.0, f32::max);
    (0..3).map(|row| highest_of_row(2 * y + row)).fold(0.0, f32::max)
}

fn highest_child(finer: &PyramidLevel, x: u32, y: u32) -> f32 {
    let pair = |row: u32| finer.node(2 * x, row).max(finer.node(2 * x + 1, row));
    pair(2 * y).max(pair(2 * y + 1))
}

#[cfg(test)]
mod tests {
    use super::super::HoleMask;
    use super::super::testing::{Numbers, random_field};
    use super::*;

    const SIZES: [(u32, u32); 8] = [(2, 2), (2, 9), (3, 3), (5, 4), (17, 17), (33, 12), (41, 23), (64, 65)];

    #[test]
    fn every_node_is_the_highest_sample_under_it() {
        for (width, height) in SIZES {
            let field = random_field(width, height, 3);
            let pyramid = MaxPyramid::build(&field);
            for (index, level) in pyramid.levels().iter().enumerate() {
                let span = 2u32 << index;
                assert_eq!([level.width, level.height], field.cells().map(|cells| cells.div_ceil(span)));
                for (x, y) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y))) {
                    let highest = (0..=span)
                        .flat_map(|j| (0..=span).map(move |i| (i, j)))
                        .filter(|(i, j)| x * span + i < width && y * span + j < height)
                        .map(|(i, j)| field.sample(x * span + i, y * span + j))
                        .fold(f32::NEG_INFINITY, f32::max);
                    assert_eq!(level.node(x, y), highest, "{width}×{height}, level {}, node {x}, {y}", index + 1);
                }
            }
            assert_eq!(pyramid.top(), 1.0);
        }
    }

    #[test]
    fn cells_without_ground_count_as_nothing() {
        let mut numbers = Numbers::new(9);
        for (width, height) in SIZES {
            let field = random_field(width, height, 4);
            let mut holes = HoleMask::new(width, height);
            for _ in 0..=width * height / 20 {
                holes.insert(numbers.below(width * height) as usize);
            }
            let raw: Vec<f64> = field.samples().iter().map(|&sample| f64::from(sample)).collect();
            let Ok(field) = HeightField::from_raw_with_holes(width, height, &raw, Some(holes)) else { continue };
            let pyramid = MaxPyramid::build(&field);
            for (index, level) in pyramid.levels().iter().enumerate() {
                let span = 2u32 << index;
                for (x, y) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y))) {
                    let highest = (y * span..((y + 1) * span).min(height - 1))
                        .flat_map(|row| (x * span..((x + 1) * span).min(width - 1)).map(move |column| (column, row)))
                        .filter(|&(column, row)| field.has_ground(column, row))
                        .flat_map(|(x, y)| [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)])
                        .map(|(x, y)| field.sample(x, y))
                        .fold(0.0, f32::max);
                    assert_eq!(level.node(x, y), highest, "{width}×{height}, level {}, node {x}, {y}", index + 1);
                }
            }
        }
    }

    #[test]
    fn an_update_equals_a_fresh_build_and_names_every_changed_node() {
        let mut numbers = Numbers::new(5);
        for (width, height) in SIZES {
            let mut field = random_field(width, height, 8);
            let mut pyramid = MaxPyramid::build(&field);
            for _ in 0..40 {
                let (x, y) = (numbers.below(width), numbers.below(height));
                let rect =
                    SampleRect { x, y, width: 1 + numbers.below(width - x), height: 1 + numbers.below(height - y) };
                for row in rect.y..rect.y + rect.height {
                    for column in rect.x..rect.x + rect.width {
                        field.samples_mut()[(row * width + column) as usize] = numbers.unit() as f32;
                    }
                }
                let before = pyramid.clone();
                let changed = pyramid.update(&field, rect);
                assert_eq!(pyramid, MaxPyramid::build(&field), "{width}×{height}, {rect:?}");
                for (index, (old, new)) in before.levels().iter().zip(pyramid.levels()).enumerate() {
                    let inside = |x: u32, y: u32| {
                        changed.iter().any(|r| {
                            r.level as usize == index + 1
                                && (r.x..r.x + r.width).contains(&x)
                                && (r.y..r.y + r.height).contains(&y)
                        })
                    };
                    for (x, y) in (0..new.height).flat_map(|y| (0..new.width).map(move |x| (x, y))) {
                        assert!(old.node(x, y) == new.node(x, y) || inside(x, y), "level {}, {x}, {y}", index + 1);
                    }
                }
            }
        }
    }
}
