//! What stands between a place and the sun, in f64, on the CPU: the twin of `shaders/shadow.wgsl`.
//!
//! A walk over all cells along a compass direction, without a pyramid. Of the ground in each cell the steepest place as
//! seen from the start is found: along a straight way a bilinear patch is a parabola, so that this has a closed form.

use glam::{DVec2, DVec3};

use super::HeightField;
use super::reference::Surface;

/// Steepest slope that is told from upright.
const STEEPEST: f64 = 1e15;

/// Ground along a way: its height over where the way begins, its slope there, and how that changes.
struct Profile {
    rise: f64,
    grade: f64,
    bend: f64,
}

impl Profile {
    fn after(&self, way: f64) -> f64 {
        self.rise + way * (self.grade + self.bend * way)
    }

    /// The greatest slope to the ground between `begin` and `end` of the way.
    fn steepest(&self, begin: f64, end: f64) -> f64 {
        let entry = match begin > 0.0 {
            true => self.rise / begin,
            false if self.rise == 0.0 => self.grade,
            false => STEEPEST * self.rise.signum(),
        };
        let exit = if end > begin { self.after(end - begin) / end } else { entry };
        let constant = self.rise - begin * (self.grade - self.bend * begin);
        let summit = (constant / self.bend).sqrt();
        let on_summit = constant < 0.0 && self.bend < 0.0 && summit > begin && summit < end;
        let summit = if on_summit { self.after(summit - begin) / summit } else { entry };
        entry.max(exit).max(summit)
    }
}

impl Surface<'_> {
    /// Tangent of the elevation of the horizon that the ground makes for a place of the box, along the compass direction
    /// `azimuth` (radians, clockwise from north). −∞ where there is no ground in that direction. A place less than `near`
    /// above or below the ground counts as on it: its own patch then hides nothing by a rounding.
    pub fn horizon(&self, place: DVec3, azimuth: f64, near: f64) -> f64 {
        let (field, size) = (self.field(), self.size());
        let cells = field.cells();
        let scale = DVec2::new(f64::from(cells[0]) / size.x, f64::from(cells[1]) / size.z);
        let direction = DVec2::new(azimuth.sin(), -azimuth.cos()) * scale;
        let start = (DVec2::new(place.x, place.z) * scale).clamp(DVec2::ZERO, DVec2::from(cells.map(f64::from)));
        let mut cell = std::array::from_fn::<_, 2, _>(|axis| {
            // On a wall, the cell that the way goes into.
            let first = if direction[axis] < 0.0 { start[axis].ceil() - 1.0 } else { start[axis].floor() };
            (first.max(0.0) as u32).min(cells[axis] - 1)
        });
        let mut height = place.y;
        if field.has_ground(cell[0], cell[1]) {
            let ground = ground_at(field, size.y, cell, start);
            height = if (ground - height).abs() <= near { ground } else { height };
        }
        let (mut begin, mut slope) = (0.0, f64::NEG_INFINITY);
        loop {
            let wall = |axis: usize| match direction[axis] {
                0.0 => f64::INFINITY,
                along => (f64::from(cell[axis]) + f64::from(u8::from(along > 0.0)) - start[axis]) / along,
            };
            let (through_x, end) = (wall(0) <= wall(1), wall(0).min(wall(1)).max(begin));
            if field.has_ground(cell[0], cell[1]) {
                let rise = ground_at(field, size.y, cell, start + direction * begin) - height;
                let ground = along(field, size.y, cell, start + direction * begin, direction, rise);
                slope = slope.max(ground.steepest(begin, end));
            }
            let axis = usize::from(!through_x);
            let up = direction[axis] > 0.0;
            if !end.is_finite() || if up { cell[axis] + 1 == cells[axis] } else { cell[axis] == 0 } {
                return slope;
            }
            cell[axis] = if up { cell[axis] + 1 } else { cell[axis] - 1 };
            begin = end;
        }
    }
}

fn corners(field: &HeightField, relief: f64, [x, z]: [u32; 2]) -> [f64; 4] {
    let height = |i: u32, j: u32| f64::from(field.sample(i, j)) * relief;
    [height(x, z), height(x + 1, z), height(x, z + 1), height(x + 1, z + 1)]
}

fn within(cell: [u32; 2], at: DVec2) -> DVec2 {
    (at - DVec2::from(cell.map(f64::from))).clamp(DVec2::ZERO, DVec2::ONE)
}

/// Height of the patch of `cell` at a place of the grid.
fn ground_at(field: &HeightField, relief: f64, cell: [u32; 2], at: DVec2) -> f64 {
    let [h00, h10, h01, h11] = corners(field, relief, cell);
    let p = within(cell, at);
    (h00 * (1.0 - p.x) + h10 * p.x) * (1.0 - p.y) + (h01 * (1.0 - p.x) + h11 * p.x) * p.y
}

/// The patch of `cell` along `direction` from a place of the grid.
fn along(field: &HeightField, relief: f64, cell: [u32; 2], at: DVec2, direction: DVec2, rise: f64) -> Profile {
    let [h00, h10, h01, h11] = corners(field, relief, cell);
    let p = within(cell, at);
    let k = h00 - h10 - h01 + h11;
    let grade = (h10 - h00 + k * p.y) * direction.x + (h01 - h00 + k * p.x) * direction.y;
    Profile { rise, grade, bend: k * direction.x * direction.y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Ray;
    use crate::heightfield::generate::{Kind, generate};

    /// The horizon against rays that are cast one by one: just above it nothing is met, just below it something is.
    #[test]
    fn rays_pass_over_the_horizon_and_not_under_it() {
        let random = |index: u32| f64::from(index.wrapping_mul(0x9e37_79b1) >> 8) / f64::from(1u32 << 24);
        let mut high = 0;
        for (kind, seed) in [(Kind::Ridged, 3), (Kind::DiamondSquare, 5)] {
            let map = generate(kind, 65, seed);
            let size = map.box_size(Some(0.3));
            let surface = Surface::new(&map, size);
            for index in 0..500 {
                let (u, v) = (random(5 * index), random(5 * index + 1));
                let azimuth = random(5 * index + 2) * std::f64::consts::TAU;
                // On the ground, and in the air above it.
                let lift = if index % 2 == 0 { 0.0 } else { 0.02 };
                let place = DVec3::new(u * size.x, map.surface_height(u, v) * size.y + lift, v * size.z);
                let slope = surface.horizon(place, azimuth, 1e-12);
                let meets = |slope: f64| {
                    let direction = DVec3::new(azimuth.sin(), slope, -azimuth.cos());
                    // A little above: in the ground every ray begins with a hit.
                    surface.intersect(&Ray { origin: place + DVec3::Y * 1e-9, direction }).is_some()
                };
                assert!(!meets(slope + 1e-4), "{index}: {slope}");
                if slope > -0.2 {
                    high += 1;
                    // From the ground itself a ray along it may leave it again before it meets it.
                    let less = if lift == 0.0 { 1e-2 } else { 1e-4 };
                    assert!(meets(slope - less), "{index}: {slope}");
                }
            }
        }
        assert!(high > 500, "{high}");
    }
}
