//! Random midpoint displacement (Fournier, Fussell, Carpenter 1982), on a square lattice turned by 45° and back.

use super::plane::{Plane, neighbours};
use super::recipe::{MOST_START_CELLS, Recipe};
use super::work::Work;
use super::{MakeError, hash, signed};

/// Heights of no particular range. Coarse grid to fine; a displacement is a hash of its place, so rows can be computed
/// apart.
///
/// # Errors
/// [`MakeError::Cancelled`].
pub(super) fn make(recipe: &Recipe, plane: &Plane, work: Work<'_>) -> Result<Vec<f32>, MakeError> {
    let planes = coarser(plane);
    let [displacing, smoothing] = work.split([planes.len() as f32, recipe.midpoint.smoothing as f32]);
    let mut amplitudes = Amplitudes::of(recipe);
    let mut grid = start(planes.last().unwrap_or(plane), recipe.seed);
    let total: f32 = planes.iter().map(|plane| (plane.width * plane.height) as f32).sum();
    let mut done = 0.0;
    for (level, &plane) in planes.iter().rev().enumerate().skip(1) {
        let amplitude = amplitudes.next();
        let finer = Finer { coarse: &grid, plane, seed: recipe.seed, level: level as u32, amplitude };
        let share = (plane.width * plane.height) as f32 / total;
        let [_, this, _] = displacing.split([done, share, (1.0 - done - share).max(0.0)]);
        let heights = plane.rows(this, |y, row| {
            for (x, height) in row.iter_mut().enumerate() {
                *height = finer.height(x, y) as f32;
            }
        })?;
        grid = Grid { plane, heights };
        done += share;
    }
    smooth(grid.heights, plane, recipe.midpoint.smoothing, smoothing)
}

/// The plane and those that it comes from, fine to coarse.
fn coarser(plane: &Plane) -> Vec<Plane> {
    let mut planes = vec![*plane];
    let mut last = *plane;
    if plane.wraps {
        while last.width.is_multiple_of(2) && last.height.is_multiple_of(2) {
            last = Plane { width: last.width / 2, height: last.height / 2, ..last };
            planes.push(last);
        }
    } else {
        // Each grid needs every second point of the next one, and one beyond the border.
        while last.width.max(last.height) > 2 {
            last = Plane { width: last.width / 2 + 1, height: last.height / 2 + 1, ..last };
            planes.push(last);
        }
    }
    planes
}

/// Cells of the coarsest grid of a tileable landscape with such a period, and how often they are halved.
pub(super) fn start_cells(period: [u32; 2]) -> ([u32; 2], u32) {
    let halvings = period[0].trailing_zeros().min(period[1].trailing_zeros());
    (period.map(|side| side >> halvings), halvings)
}

/// The size nearest to `size` that tiles.
pub(super) fn nearest_tileable(size: [u32; 2]) -> [u32; 2] {
    let longer = size[0].max(size[1]).saturating_sub(1).max(2);
    let halvings = longer.ilog2().saturating_sub(MOST_START_CELLS.ilog2() - 1).max(1);
    size.map(|side| ((f64::from(side) - 1.0) / f64::from(1 << halvings)).round().max(1.0) as u32 * (1 << halvings) + 1)
}

/// The coarsest grid: independent heights.
fn start(plane: &Plane, seed: u64) -> Grid {
    let count = plane.width * plane.height;
    let heights = (0..count as u32).map(|place| signed(hash(seed, 0, place, 0)) as f32).collect();
    Grid { plane: *plane, heights }
}

/// How far each level displaces at most, coarse to fine.
struct Amplitudes<'a> {
    schedule: std::slice::Iter<'a, f64>,
    next: f64,
    roughness: f64,
}

impl<'a> Amplitudes<'a> {
    fn of(recipe: &'a Recipe) -> Self {
        Self { schedule: recipe.midpoint.schedule.iter(), next: 1.0, roughness: recipe.roughness }
    }

    /// The schedule, and from its end on a share of the one before.
    fn next(&mut self) -> f64 {
        let amplitude = self.schedule.next().copied().unwrap_or(self.next);
        self.next = amplitude * self.roughness;
        amplitude
    }
}

/// One level of midpoint displacement.
struct Grid {
    plane: Plane,
    heights: Vec<f32>,
}

/// The next level: every second point is a point of the coarse one.
struct Finer<'a> {
    coarse: &'a Grid,
    plane: Plane,
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
        f64::from(self.coarse.heights[y / 2 * self.coarse.plane.width + x / 2])
    }

    fn displacement(&self, x: usize, y: usize, amplitude: f64) -> f64 {
        amplitude * signed(hash(self.seed, self.level, x as u32, y as u32))
    }

    /// The place after `place`; one beyond an even side there is still a point of the coarse grid.
    fn after(&self, place: usize, count: usize) -> usize {
        if self.plane.wraps && place + 1 == count { 0 } else { place + 1 }
    }

    /// The middle of four old points. The place is odd both ways, so there is one before it.
    fn diamond(&self, x: usize, y: usize) -> f64 {
        let (right, below) = (self.after(x, self.plane.width), self.after(y, self.plane.height));
        let corners = [(x - 1, y - 1), (right, y - 1), (x - 1, below), (right, below)];
        let mean = corners.into_iter().map(|(x, y)| self.old(x, y)).sum::<f64>() * 0.25;
        mean + self.displacement(x, y, self.amplitude)
    }

    /// The middle of two old points and the diamonds on both sides, or the one that is in the map.
    fn square(&self, x: usize, y: usize) -> f64 {
        let Plane { width, height, wraps } = self.plane;
        let before = |place: usize, count: usize| {
            if wraps && place == 0 { count - 1 } else { place.wrapping_sub(1) }
        };
        let mut sum = 0.0;
        let mut count = 0.0;
        let neighbours =
            [(before(x, width), y), (self.after(x, width), y), (x, before(y, height)), (x, self.after(y, height))];
        for (nx, ny) in neighbours {
            let is_old = nx % 2 == 0 && ny % 2 == 0;
            // The coarse grid reaches one point beyond an even side, the diamonds do not.
            let beyond = usize::from(is_old && !wraps);
            if nx < width + beyond && ny < height + beyond {
                sum += if is_old { self.old(nx, ny) } else { self.diamond(nx, ny) };
                count += 1.0;
            }
        }
        sum / count + self.displacement(x, y, self.amplitude * std::f64::consts::FRAC_1_SQRT_2)
    }
}

/// Means of each sample and its neighbours with weights 1, 2, 1 both ways, as often as asked for: blunts the creases
/// that midpoint displacement leaves along the lines of its coarse grids.
fn smooth(mut heights: Vec<f32>, plane: &Plane, passes: u32, work: Work<'_>) -> Result<Vec<f32>, MakeError> {
    for pass in 0..passes {
        let [_, this, _] = work.split([pass as f32, 1.0, (passes - pass - 1) as f32]);
        let smoothed = plane.rows(this, |y, row| {
            let [above, below] = plane.beside(y).map(|y| &heights[y * plane.width..][..plane.width]);
            let middle = &heights[y * plane.width..][..plane.width];
            let down = |x: usize| f64::from(above[x]) + 2.0 * f64::from(middle[x]) + f64::from(below[x]);
            for (x, height) in row.iter_mut().enumerate() {
                let [left, right] = neighbours(x, plane.width, plane.wraps);
                *height = ((down(left) + 2.0 * down(x) + down(right)) * (1.0 / 16.0)) as f32;
            }
        })?;
        heights = smoothed;
    }
    Ok(heights)
}
