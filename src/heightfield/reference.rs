//! The reference: the first hit of a ray with the surface, in f64, on the CPU.
//!
//! A grid walk (Amanatides, Woo 1987) over the cells with integer steps, and in each cell the exact intersection with
//! the bilinear patch of its corners. It shares no acceleration structure with what is measured against it.
//!
//! A cell with a hole at a corner has no ground, and neither sides nor floor: rays pass. The ground beside it is solid,
//! so a ray that comes out of such a cell below the ground hits at the cell's wall.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::fractal::{self, Detail};
use super::{HeightField, patch, smooth};
use crate::camera::{Camera, Ray};

/// Where a ray meets the terrain first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Parameter along the ray's direction: the view depth for a camera's ray.
    pub depth: f64,
    /// World position.
    pub position: DVec3,
    /// Whether it is a solid side or the floor of the box, entered from outside, rather than the surface.
    pub wall: bool,
}

/// A height map's surface in its box.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    field: &'a HeightField,
    /// Size of the box in world units.
    size: DVec3,
    shape: Shape,
}

/// What stands between the samples.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Bilinear,
    Smooth,
    /// With the width of a pixel at a unit's distance from the eye, world units.
    Detailed(Detail, f64),
}

impl<'a> Surface<'a> {
    /// The surface of `field` in the box from the origin to `size`. The height may be 0; the sides are above 0.
    pub fn new(field: &'a HeightField, size: DVec3) -> Self {
        Self { field, size, shape: Shape::Bilinear }
    }

    /// The smooth surface of `field` ([`super::smooth`]), which has no holes, in the same box.
    pub fn smooth(field: &'a HeightField, size: DVec3) -> Self {
        Self { field, size, shape: Shape::Smooth }
    }

    /// The ground of `field` with invented detail ([`super::fractal`]), which has no holes, in the same box, as an eye sees
    /// it for which a pixel at a unit's distance is `pixel` wide: what is farther away has less of it.
    pub fn detailed(field: &'a HeightField, size: DVec3, detail: Detail, pixel: f64) -> Self {
        Self { field, size, shape: Shape::Detailed(detail, pixel) }
    }

    pub(super) fn field(&self) -> &'a HeightField {
        self.field
    }

    pub(super) fn size(&self) -> DVec3 {
        self.size
    }

    /// The first point of the ray, from its origin on, that is on or below the surface and in the box. An eye below
    /// the surface hits at depth 0. `None` is the sky, also for a ray that is not finite, has no direction, or one so
    /// short that no finite multiple of it reaches the ends of the box.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        if !ray.origin.is_finite() || !ray.direction.is_finite() || ray.direction == DVec3::ZERO {
            return None;
        }
        let span = clip(ray, self.size)?;
        let length = span.exit - span.enter;
        if !span.enter.is_finite() || !length.is_finite() {
            return None;
        }
        // From here on, distances count from where the ray enters the box: a far eye costs no precision.
        let mut origin = ray.origin + ray.direction * span.enter;
        if let Some((axis, bound)) = span.face {
            origin[axis] = bound;
        }
        let origin = origin.clamp(DVec3::ZERO, self.size);
        let found = self.walk(origin, ray.direction, length, span.enter);
        let distance = match found {
            Some(distance) => distance,
            // The floor is nowhere above the surface; only rounding can bring a ray to it.
            None if span.leaves_through_floor && self.is_ground(origin + ray.direction * length) => length,
            None => return None,
        };
        let wall =
            distance == 0.0 && span.face.is_some_and(|(axis, bound)| axis != 1 || bound == 0.0 && self.size.y > 0.0);
        Some(Hit { depth: span.enter + distance, position: origin + ray.direction * distance, wall })
    }

    /// Whether the cell at a place of the box has ground.
    fn is_ground(&self, place: DVec3) -> bool {
        let cell = |at: f64, side: f64, cells: u32| ((at / side * f64::from(cells)).max(0.0) as u32).min(cells - 1);
        let cells = self.field.cells();
        self.field.has_ground(cell(place.x, self.size.x, cells[0]), cell(place.z, self.size.z, cells[1]))
    }

    /// Walks the cells from `origin` in the box, at most `length` of `direction` far; the eye is `enter` before.
    fn walk(&self, origin: DVec3, direction: DVec3, length: f64, enter: f64) -> Option<f64> {
        let cells = self.field.cells();
        let unit = direction.length();
        let scale = DVec2::new(f64::from(cells[0]) / self.size.x, f64::from(cells[1]) / self.size.z);
        let origin = DVec3::new(origin.x * scale.x, origin.y, origin.z * scale.y);
        let direction = DVec3::new(direction.x * scale.x, direction.y, direction.z * scale.y);
        let growth = match self.shape {
            Shape::Detailed(_, pixel) => unit * pixel * scale.max_element(),
            _ => 0.0,
        };
        let pixel = [enter * growth, growth];
        let mut x = Axis::new(origin.x, direction.x, cells[0]);
        let mut z = Axis::new(origin.z, direction.z, cells[1]);
        let mut start = 0.0;
        loop {
            let (next_x, next_z) = (x.next_wall(), z.next_wall());
            let end = next_x.min(next_z).clamp(start, length);
            if let Some(distance) = self.cell([x.cell, z.cell], (origin, direction), [start, end], pixel) {
                return Some(distance);
            }
            let inside = if next_x <= next_z { x.step() } else { z.step() };
            if end >= length || !inside {
                return None;
            }
            start = end;
        }
    }

    /// The first hit in one cell between two distances. `origin` and `direction` are in cells horizontally; `pixel` is the
    /// width of a pixel at the distance 0 and its growth, in cells.
    fn cell(
        &self,
        [x, z]: [u32; 2],
        (origin, direction): (DVec3, DVec3),
        [start, end]: [f64; 2],
        pixel: [f64; 2],
    ) -> Option<f64> {
        if !self.field.has_ground(x, z) {
            return None;
        }
        let arrays = (origin.to_array(), direction.to_array());
        match self.shape {
            Shape::Bilinear => {}
            Shape::Smooth => {
                return smooth::first_meeting(self.field, self.size.y, arrays.0, arrays.1, [start, end], [x, z]);
            }
            Shape::Detailed(detail, _) => {
                let ground = (self.field, &detail);
                return fractal::first_meeting(ground, self.size.y, arrays, [start, end], [x, z], pixel);
            }
        }
        let height = |i: u32, j: u32| f64::from(self.field.sample(i, j)) * self.size.y;
        let corners = [height(x, z), height(x + 1, z), height(x, z + 1), height(x + 1, z + 1)];
        let entry = origin + direction * start;
        let lowest = entry.y.min(origin.y + direction.y * end);
        if lowest > corners.into_iter().fold(0.0, f64::max) {
            return None;
        }
        let local =
            DVec3::new((entry.x - f64::from(x)).clamp(0.0, 1.0), entry.y, (entry.z - f64::from(z)).clamp(0.0, 1.0));
        let distance = patch::first_meeting(corners, local.to_array(), direction.to_array())?;
        (distance <= end - start).then_some(start + distance)
    }

    /// Distance from the eye to the hit in world units for every pixel's centre, row 0 at the top; +inf is sky.
    /// `progress` hears the share of rows done, 0..1, from several threads.
    pub fn distances(&self, camera: &Camera, size: [u32; 2], progress: &(dyn Fn(f32) + Sync)) -> Vec<f64> {
        let [width, height] = size.map(|side| side as usize);
        let done = std::sync::atomic::AtomicUsize::new(0);
        let mut distances = vec![f64::INFINITY; width * height];
        distances.par_chunks_mut(width.max(1)).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let ray = camera.ray(column as f64 + 0.5, row as f64 + 0.5, size);
                if let Some(hit) = self.intersect(&ray) {
                    *pixel = hit.depth * ray.direction.length();
                }
            }
            let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
            progress(done as f32 / height as f32);
        });
        distances
    }

    /// Whether the pixel in column `x`, row `y` is in the tangency band: its ray and those `pixels` of a pixel to the
    /// left, right, above and below do not all agree on whether there is a hit.
    pub fn is_tangent(&self, camera: &Camera, x: u32, y: u32, size: [u32; 2], pixels: f64) -> bool {
        let hits = |dx: f64, dy: f64| {
            self.intersect(&camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, size)).is_some()
        };
        let verdict = hits(0.0, 0.0);
        [(-pixels, 0.0), (pixels, 0.0), (0.0, -pixels), (0.0, pixels)]
            .into_iter()
            .any(|(dx, dy)| hits(dx, dy) != verdict)
    }
}

/// The part of a ray in the box.
pub(super) struct Span {
    /// Where it begins; 0 for an origin inside.
    pub(super) enter: f64,
    exit: f64,
    /// Axis and coordinate of the face it enters through; absent for an origin inside.
    pub(super) face: Option<(usize, f64)>,
    leaves_through_floor: bool,
}

/// Clips a ray to the box from the origin to `size`.
pub(super) fn clip(ray: &Ray, size: DVec3) -> Option<Span> {
    let mut span = Span { enter: 0.0, exit: f64::INFINITY, face: None, leaves_through_floor: false };
    for axis in 0..3 {
        let (origin, direction, side) = (ray.origin[axis], ray.direction[axis], size[axis]);
        if direction == 0.0 {
            if !(0.0..=side).contains(&origin) {
                return None;
            }
            continue;
        }
        let (near, far) = if direction > 0.0 { (0.0, side) } else { (side, 0.0) };
        let (enter, exit) = ((near - origin) / direction, (far - origin) / direction);
        if enter > span.enter || (enter == 0.0 && span.face.is_none()) {
            (span.enter, span.face) = (enter.max(0.0), Some((axis, near)));
        }
        if exit < span.exit {
            span.exit = exit;
            span.leaves_through_floor = axis == 1 && direction < 0.0;
        }
    }
    (span.enter <= span.exit).then_some(span)
}

/// One horizontal direction of the grid walk, in cells.
struct Axis {
    origin: f64,
    direction: f64,
    cell: u32,
    cells: u32,
}

impl Axis {
    fn new(origin: f64, direction: f64, cells: u32) -> Self {
        // On a wall, the cell that the ray is going into.
        let cell = if direction < 0.0 { origin.ceil() - 1.0 } else { origin.floor() };
        Self { origin, direction, cell: (cell.max(0.0) as u32).min(cells - 1), cells }
    }

    /// Distance to the wall through which the ray leaves the cell; infinite for a ray parallel to it.
    fn next_wall(&self) -> f64 {
        if self.direction == 0.0 {
            return f64::INFINITY;
        }
        let wall = f64::from(self.cell) + f64::from(u8::from(self.direction > 0.0));
        (wall - self.origin) / self.direction
    }

    /// Goes to the next cell; false at the border.
    fn step(&mut self) -> bool {
        if self.direction > 0.0 {
            self.cell += 1;
            self.cell < self.cells
        } else {
            let inside = self.cell > 0;
            self.cell = self.cell.saturating_sub(1);
            inside
        }
    }
}

#[cfg(test)]
#[path = "reference_tests.rs"]
mod tests;
