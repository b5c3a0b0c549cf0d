//! Whether a picture of the exact technique keeps the promise: every pixel explained by a displacement within the
//! [bound](super::bound).

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::bound::{Ground, Tolerance};
use crate::camera::{Camera, Ray};
use crate::heightfield::HeightField;
use crate::heightfield::reference::{Hit, Surface};
use crate::render::Anchor;
use crate::report::comparison::BAND_PIXELS;

/// What a picture is judged by.
pub(super) struct Judge<'a> {
    pub(super) field: &'a HeightField,
    pub(super) extent: DVec3,
    pub(super) camera: &'a Camera,
    pub(super) size: [u32; 2],
    /// Side of a cell, world units.
    pub(super) cell: f64,
    /// What the rays count from, in a deep zoom.
    pub(super) anchors: &'a [Anchor],
}

/// One pixel to be judged.
pub(super) struct Pixel {
    /// Its number, row by row.
    pub(super) index: usize,
    /// The reference's distance.
    pub(super) expected: f64,
    /// The technique's, and what the probe says of it beyond the start of the rays.
    pub(super) distance: f32,
    pub(super) beyond_start: f32,
    /// View depth of that start.
    pub(super) start: f64,
}

/// How far a point lies off what it should be on.
struct Off {
    /// World units: vertically off the ground, or square off a side of the box.
    off: f64,
    /// How far it may.
    may: f64,
    /// What both are to be divided by for a distance square to the ground.
    steepness: f64,
    /// It is a side of the box.
    on_side: bool,
}

/// What became of a picture's pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Judgement {
    /// Pixels that were compared.
    pub pixels: u64,
    /// Pixels where the reference hits.
    pub hits: u64,
    /// The reference hits and the picture shows sky, outside the tangency band.
    pub missed: u64,
    /// The reverse.
    pub invented: u64,
    /// Both hit, and no displacement within the bound explains by how much they differ.
    pub astray: u64,
    /// Disagreements inside the tangency band.
    pub tangent: u64,
    /// Distances that are NaN.
    pub nan: u64,
    /// Largest displacement of a hit over its bound, outside the tangency band.
    pub ratio: f64,
    /// Largest displacement of a hit, square to the ground, as a share of the box's longest side.
    pub displacement: f64,
    /// The bound of that displacement: its largest value over the pixels.
    pub bound: f64,
    /// Largest difference of distances outside the band, cells.
    pub error: f64,
}

impl Judgement {
    pub(super) fn merge(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            hits: self.hits + other.hits,
            missed: self.missed + other.missed,
            invented: self.invented + other.invented,
            astray: self.astray + other.astray,
            tangent: self.tangent + other.tangent,
            nan: self.nan + other.nan,
            ratio: self.ratio.max(other.ratio),
            displacement: self.displacement.max(other.displacement),
            bound: self.bound.max(other.bound),
            error: self.error.max(other.error),
        }
    }
}

impl Judge<'_> {
    /// Judges the pixels; an index counts row by row.
    pub(super) fn judge(&self, pixels: &[Pixel]) -> Judgement {
        let surface = Surface::new(self.field, self.extent);
        let each = |of: &Pixel| {
            let (index, width) = (of.index as u64, u64::from(self.size[0]));
            let pixel = [(index % width) as u32, (index / width) as u32];
            let distance = f64::from(of.distance);
            if !distance.is_finite() {
                return self.pixel(&surface, pixel, of.expected, distance);
            }
            let precise = (of.start + f64::from(of.beyond_start)) * self.ray(pixel, 0.0, 0.0).direction.length();
            let mut judged = self.pixel(&surface, pixel, of.expected, precise);
            let rounded = (distance - precise).abs() / Tolerance::of_distance(precise.abs());
            if rounded > 1.0 {
                (judged.astray, judged.ratio) = (1, judged.ratio.max(rounded));
            }
            judged
        };
        pixels.par_iter().map(each).reduce(Judgement::default, Judgement::merge)
    }

    fn pixel(&self, surface: &Surface<'_>, pixel: [u32; 2], expected: f64, actual: f64) -> Judgement {
        let mut result = Judgement { pixels: 1, hits: u64::from(expected.is_finite()), ..Judgement::default() };
        let ray = self.ray(pixel, 0.0, 0.0);
        match (expected.is_finite(), actual.is_finite()) {
            _ if actual.is_nan() => result.nan = 1,
            (false, false) => {}
            (true, true) => self.both(surface, pixel, &ray, expected, actual, &mut result),
            (hits, _) => {
                let at = if hits { expected } else { actual };
                let ground = self.ground(&ray, at);
                let tolerance = self.tolerance(pixel, at, &ground);
                let agree = |ray: &Ray| surface.intersect(ray).is_some() == hits;
                if self.displaced(pixel, &tolerance, 1.0, true).iter().all(agree) {
                    *(if hits { &mut result.missed } else { &mut result.invented }) = 1;
                } else {
                    result.tangent = 1;
                }
            }
        }
        result
    }

    /// Both hit.
    fn both(
        &self,
        surface: &Surface<'_>,
        pixel: [u32; 2],
        ray: &Ray,
        expected: f64,
        actual: f64,
        result: &mut Judgement,
    ) {
        let ground = self.ground(ray, actual);
        let tolerance = self.tolerance(pixel, expected.max(actual), &ground);
        let Off { off, may, steepness, on_side } = self.off(surface, ray, actual, &tolerance, &ground);
        let ratio = tolerance.ratio(off, may);
        let error = (actual - expected).abs();
        // What lies before a point that is on the ground must not be deeper in it than a ray may be displaced.
        let unseen = || {
            let before = self.ground(ray, expected);
            let lift = tolerance.lift(&ground).max(tolerance.lift(&before));
            let lifted = Ray { origin: ray.origin + DVec3::Y * lift, direction: ray.direction };
            distance(&lifted, surface.intersect(&lifted)) >= actual - tolerance.along
        };
        if ratio <= 1.0 && (on_side || actual <= expected + tolerance.along || unseen()) {
            if error > self.cell + tolerance.along {
                // It passes what the reference meets, by less than a ray may be displaced.
                result.tangent = 1;
                return;
            }
            result.ratio = ratio;
            result.displacement = off / steepness / self.extent.max_element();
            result.bound = may / steepness / self.extent.max_element();
            result.error = error / self.cell;
            return;
        }
        if error <= self.cell {
            // A crease of the ground, an edge of the box: the displaced rays must lie on both sides of it.
            let between = |share: f64| {
                let reached = self.displaced(pixel, &tolerance, share, false);
                let reached = reached.iter().map(|ray| distance(ray, surface.intersect(ray)));
                let (low, high) = reached.fold((expected, expected), |(low, high), at| (low.min(at), high.max(at)));
                (low - share * tolerance.along..=high + share * tolerance.along).contains(&actual)
            };
            if let Some(share) = [0.125, 0.25, 0.5, 1.0].into_iter().find(|&share| between(share)) {
                (result.ratio, result.error) = (share, error / self.cell);
                return;
            }
        } else {
            let slack = self.cell + tolerance.along;
            let near = |ray: &Ray| (distance(ray, surface.intersect(ray)) - actual).abs() <= slack;
            if self.displaced(pixel, &tolerance, 1.0, true).iter().any(near) {
                result.tangent = 1;
                return;
            }
        }
        result.astray = 1;
        (result.ratio, result.error) = (ratio, error / self.cell);
    }

    /// How far off the ground, or off the side of the box that the reference meets, the point at `actual` lies.
    fn off(&self, surface: &Surface<'_>, ray: &Ray, actual: f64, tolerance: &Tolerance, ground: &Ground) -> Off {
        let direction = ray.direction.normalize();
        let point = ray.origin + direction * actual;
        let steepness = 1f64.hypot(ground.slope[0].hypot(ground.slope[1]));
        let off = (point.y - ground.height).abs();
        let over = Off { off, may: tolerance.height(ground, direction), steepness, on_side: false };
        if actual == 0.0 && point.y <= ground.height {
            // In the ground.
            return Off { off: 0.0, ..over };
        }
        let side = surface.intersect(ray).filter(|hit| hit.wall).map(|hit| {
            let axis = (0..3).find(|&axis| hit.position[axis] == 0.0 || hit.position[axis] == self.extent[axis]);
            let axis = axis.unwrap_or(1);
            let may = tolerance.displacement[axis] + tolerance.along * direction[axis].abs();
            Off { off: (point[axis] - hit.position[axis]).abs(), may, steepness: 1.0, on_side: true }
        });
        side.filter(|side| side.off * over.may <= over.off * side.may || side.off <= side.may).unwrap_or(over)
    }

    fn ray(&self, [x, y]: [u32; 2], dx: f64, dy: f64) -> Ray {
        self.camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, self.size)
    }

    fn ground(&self, ray: &Ray, distance: f64) -> Ground {
        Ground::around(self.field, self.extent, ray.origin + ray.direction.normalize() * distance)
    }

    fn tolerance(&self, pixel: [u32; 2], distance: f64, ground: &Ground) -> Tolerance {
        Tolerance::of(self.camera, self.extent, self.size, pixel, distance, ground, self.anchors)
    }

    /// Rays displaced by a share of the tolerance, along the axes and to the corners; with `band` also those of the tangency band.
    fn displaced(&self, pixel: [u32; 2], tolerance: &Tolerance, share: f64, band: bool) -> Vec<Ray> {
        let own = self.ray(pixel, 0.0, 0.0);
        let signs = [-1.0, 0.0, 1.0];
        let moves =
            signs.into_iter().flat_map(|x| signs.into_iter().flat_map(move |y| signs.map(|z| DVec3::new(x, y, z))));
        let moved =
            |by: DVec3| Ray { origin: own.origin + by * tolerance.displacement * share, direction: own.direction };
        let mut rays: Vec<Ray> = moves.filter(|&by| by != DVec3::ZERO).map(moved).collect();
        if band {
            let beside = [(-BAND_PIXELS, 0.0), (BAND_PIXELS, 0.0), (0.0, -BAND_PIXELS), (0.0, BAND_PIXELS)];
            rays.extend(beside.map(|(dx, dy)| self.ray(pixel, dx, dy)));
        }
        rays
    }
}

fn distance(ray: &Ray, hit: Option<Hit>) -> f64 {
    hit.map_or(f64::INFINITY, |hit| hit.depth * ray.direction.length())
}

#[cfg(test)]
#[path = "judge_tests.rs"]
mod tests;
