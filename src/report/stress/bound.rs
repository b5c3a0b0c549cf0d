//! How far the exact technique may be from the reference: a bound, derived from what its shader computes.
//!
//! # The derivation
//!
//! u = 2⁻²⁴ is the rounding of one f32 operation, relative to its result. What the shader computes in f32 is, operation by
//! operation, exact for a ray that is a little displaced over a ground that is a little displaced (backward analysis
//! after Wilkinson). Displacements are counted per axis, in world units; |·| of a vector is taken per component.
//!
//! 1. **The ray's origin** (`pixel_ray`, `render/frame.rs`). C is the point of the central ray at the view depth
//!    `ray_start`, made in f64 and rounded; the pixel's is C + x·R + y·D, with R and D rounded, too. Rounding of the
//!    terms, two products and two sums: 4u·(|C| + |x·R| + |y·D|) =: **4u·A**. The CPU chooses `ray_start` so that C is near
//!    the box, or A would be the eye's distance.
//! 2. **Its direction**, the same with the camera's axes instead of C, R, D: 4u·(|f| + |x·r| + |y·d|) =: 4u·a, and at the
//!    parameter t, counted from the origin, **4u·t·a**.
//! 3. **Into the box and into cells** (`terrain.wgsl`). Where the ray enters is a parameter: its error does not displace
//!    the ray, because the same number is used for the position and for the distance. The product with the direction, the
//!    sum, and the scaling to cells cost u·t·a + 2u·S, with S the size of the box; the scaling of the direction u·t·a. The
//!    rounded scale is the same for both and for the walls between cells, so that it displaces nothing.
//! 4. **In the cell** (`max-mipmap.wgsl`). `origin − cell` costs u·S, the product with the node's parameter u·t·a, the sums
//!    less than u·S more; the error of that parameter itself moves the point along the ray only. Up: the product and two
//!    sums u·t·a + 2u·S.
//! 5. **The patch.** Four corners times the box's rounded height, 2u·h, and two rounds of `mix`, 6u·h, with h the highest
//!    of the corners; the difference to the ray, u·h. Where 16 bits hold the corners, a sampler makes floats of them by a
//!    rounded reciprocal of 65535, 2u·h, and the map's own samples, which the reference reads, are rounded, too: u·h. Coefficients a, b, k are differences of corners: with r the relief of
//!    the cell they are off by at most u·r, 2u·r and 5u·r, and the products and sums of `linear` by 5u·(|B·t|), at most
//!    30u·r over the cell. The discriminant's rounding is that of a C off by 4u·C, which is at most 4u·r above the ground
//!    that is to be met, and of a B off by 2u·B. The root is taken in the form without cancellation: 3u of t, along the
//!    ray. Together **12u·h + 45u·r** up.
//! 6. **Along the ray** (`terrain.wgsl`): with the parameter at which the ray enters the box, that of the node and the root
//!    two sums, and 3u of the root: 6u·t, times the direction's length **6u·l** for a hit l world units beyond the ray's
//!    origin.
//!
//! The sum: across, 4u·A + 7u·t·a + 4u·S; up, 4u·A + 8u·t·a + 4u·S + 12u·h + 45u·r; along, 6u·l. The reference is f64, whose
//! rounding counts from the eye: 16 · 2⁻⁵³ · (|eye| + d) each way. It matters from 10⁸ box lengths on.
//!
//! None of these grows with the number of cells, and none with the eye's distance. What does is the *distance* that a
//! picture or a file holds: `ray_start`, rounded, and the hit beyond it, two sums, times the length of the direction with
//! three products, two sums and a root, **9u·d**. At d = 10⁶ that is half a world unit. It blurs no picture, because
//! shading, silhouettes and craters do not use it; a probe hands out the part beyond `ray_start` for the judge, who also
//! holds the distance against it.
//!
//! # What follows for a distance
//!
//! Let g be the ground's slope and B = dy − g·dx the rate, per world unit, at which the ray nears the ground. A displaced
//! ray meets the ground elsewhere by (up + |g|·across)/|B|, to first order: where |B| is small the *distance* error has no
//! bound, at a tangent it jumps to the hill behind, and still the ray was displaced by no more than above. So it is the
//! displacement that is bounded and checked: [`Tolerance::ratio`] divides how far the point found lies off the ground by
//! how far it may, and the judge (`judge.rs`) asks that no ground before it was deeper than that.
//!
//! # Deep zooms
//!
//! A pixel smaller than `across` could not be told from its neighbours. Such views, by `render/anchor.rs` those whose pixels
//! are narrower than 2⁻¹⁸ of the box, are cast in coordinates that count from an anchor G on the central ray, at the ground
//! that is seen, and the sizes in the sum become distances from there. Let l be the hit's distance from G, ρ the distance
//! of the pixel's ray from the central one at G, c the side of a cell, and e = 2⁻²³·c across, 2⁻²⁴·h up, what is
//! left of G where it is split into a cell, a fraction and an f32 height.
//!
//! 1. Origin and direction as above, with e + ρ for C and no scaling of their own: 4u·(e + ρ) + 5u·t·a.
//! 2. In the cell: beside the anchor's and in it the patch is expanded about G, whose place there is exact; elsewhere the
//!    entry's place is rounded, u·(t·a + 2c), and l is more than c: 3u·min(l, c) covers the rest.
//! 3. The patch. The corners' heights over G are differences of f32 numbers, which the shader has as the map has
//!    them (also where 16 bits hold them): u·H, with H the largest, at most the cell's relief r and the hit's height over G.
//!    Beside the anchor the patch's height at G is made in f64, and its slopes and products are multiplied by the
//!    distance from G: with all their terms less than **100u·(r + H)·min(1, (l + ρ)/c)** up. Elsewhere l is more than c.
//! 4. Up: the product and two sums, 8u·t·a. Along the ray: **6u·l**.
//!
//! The sum: across, 4u·(e + ρ) + 6u·t·a + 3u·min(l, c); up, 4u·(e + ρ) + 8u·t·a + 100u·(r + H)·min(1, (l + ρ)/c). Of a picture n
//! pixels high whose ground is not seen at a grazing angle l and ρ are at most n pixels, and all of it is below 10⁻⁵·n pixels:
//! **a hundredth of a pixel**, at any field of view down to what f64 knows of the camera. Ground that is seen
//! far behind, over a silhouette, has an anchor of its own, of up to four, and the ray is cast in pieces that count from the
//! nearest. Where depths are spread more than that they are rounded by u of the distance to it, as in any other view.
//!
//! With layered craters the corners are sums in f32, and the 12u·h of the ordinary sum come back, again as an offset.

use glam::DVec3;

use crate::camera::Camera;
use crate::heightfield::HeightField;
use crate::render::{Anchor, ray_start};

/// Rounding of an f32 operation, relative to its result.
pub const ROUNDING: f64 = 1.0 / (1u32 << 24) as f64;
/// That of the reference.
const ROUNDING_OF_REFERENCE: f64 = 16.0 * f64::EPSILON / 2.0;

/// How far the ray of one pixel may be displaced, and its distance be off, world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Displacement along each axis; `y` is that of the ray and of the ground's height together.
    pub displacement: DVec3,
    /// Along the ray.
    pub along: f64,
}

/// The ground around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ground {
    /// Height of the surface, world units.
    pub(super) height: f64,
    /// Steepest |slope| along x and z of the point's cell and those around it.
    pub(super) slope: [f64; 2],
    /// Highest corner of these cells.
    pub(super) highest: f64,
    /// Largest relief of one of these cells.
    pub(super) relief: f64,
}

impl Ground {
    /// The ground of `field`, in a box of the size `extent`, under or above `point`; beside the map that of its border.
    pub(super) fn around(field: &HeightField, extent: DVec3, point: DVec3) -> Self {
        let cells = field.cells();
        let share = [point.x / extent.x, point.z / extent.z];
        let cell = |axis: usize| (share[axis].clamp(0.0, 1.0) * f64::from(cells[axis])) as u32;
        let range = |axis: usize| cell(axis).saturating_sub(1)..=(cell(axis) + 1).min(cells[axis] - 1);
        let side = [extent.x / f64::from(cells[0]), extent.z / f64::from(cells[1])];
        let mut ground = Self {
            height: field.surface_height(share[0], share[1]) * extent.y,
            slope: [0.0; 2],
            highest: 0.0,
            relief: 0.0,
        };
        for (row, column) in range(1).flat_map(|row| range(0).map(move |column| (row, column))) {
            let at = |i: u32, j: u32| f64::from(field.sample(column + i, row + j)) * extent.y;
            let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            let [h00, h10, h01, h11] = corners;
            let steepest = |a: f64, b: f64| a.abs().max(b.abs());
            ground.slope[0] = ground.slope[0].max(steepest(h10 - h00, h11 - h01) / side[0]);
            ground.slope[1] = ground.slope[1].max(steepest(h01 - h00, h11 - h10) / side[1]);
            let (low, high) = corners
                .into_iter()
                .fold((f64::INFINITY, 0.0f64), |(low, high), corner| (low.min(corner), high.max(corner)));
            ground.highest = ground.highest.max(high);
            ground.relief = ground.relief.max(high - low);
        }
        ground
    }
}

impl Tolerance {
    /// The tolerance of the pixel (column, row) of a picture of `size` pixels that meets `ground` at `distance`, in a box
    /// of the size `extent`.
    pub(super) fn of(
        camera: &Camera,
        extent: DVec3,
        size: [u32; 2],
        pixel: [u32; 2],
        distance: f64,
        ground: &Ground,
        anchors: &[Anchor],
    ) -> Self {
        let basis = camera.basis();
        let offset = |axis: usize| (f64::from(pixel[axis]) + 0.5 - f64::from(size[axis]) * 0.5).abs();
        let width = camera.pixel_size(size[1]);
        let beside = (basis.right.abs() * offset(0) + basis.up.abs() * offset(1)) * width;
        let reference = ROUNDING_OF_REFERENCE * (camera.eye.abs().max_element() + distance);
        let ray = camera.ray(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5, size);
        let length = ray.direction.length();
        let away = |anchor: &&Anchor| (anchor.depth - distance / length).abs();
        if let Some(anchor) = anchors.iter().min_by(|a, b| away(a).total_cmp(&away(b))) {
            let hit = ray.origin + ray.direction * (distance / length);
            let own =
                Self::anchored(anchor, extent, beside, basis.forward.abs() + beside, hit, distance / length, ground);
            let displacement = own.displacement + DVec3::splat(reference);
            return Self { displacement, along: own.along + reference };
        }
        let start = ray_start(camera, extent);
        let origin = (camera.eye + basis.forward * start).abs() + beside * start;
        let direction = (basis.forward.abs() + beside) * (distance / length - start).abs();
        let patch = DVec3::Y * (12.0 * ground.highest + 45.0 * ground.relief);
        let counted = origin * 4.0 + direction * DVec3::new(7.0, 8.0, 7.0) + extent * 4.0 + patch;
        let beyond = (distance - start * length).abs();
        Self { displacement: counted * ROUNDING + DVec3::splat(reference), along: 6.0 * ROUNDING * beyond + reference }
    }

    /// That of a deep zoom, without the reference's: a ray `beside` the central one per view depth, of the `direction`, meets
    /// `ground` at `hit`, at a view depth.
    fn anchored(
        anchor: &Anchor,
        extent: DVec3,
        beside: DVec3,
        direction: DVec3,
        hit: DVec3,
        depth: f64,
        ground: &Ground,
    ) -> Self {
        let [columns, rows] = anchor.cells.map(f64::from);
        let cell = DVec3::new(extent.x / columns, extent.y, extent.z / rows);
        let left = cell * DVec3::new(2.0, 1.0, 2.0) * ROUNDING;
        let (beside, beyond) = (beside * anchor.depth, (depth - anchor.depth).abs());
        let away = (hit - anchor.central).length();
        let side = cell.x.min(cell.z);
        let from_anchor = (away + beside.length()) / side;
        let over = (hit.y - anchor.central.y).abs() + ground.relief;
        let patch = 100.0 * (ground.relief + over) * from_anchor.min(1.0);
        let counted = (left + beside) * 4.0
            + direction * beyond * DVec3::new(6.0, 8.0, 6.0)
            + DVec3::new(3.0, 0.0, 3.0) * away.min(side)
            + DVec3::Y * patch;
        Self { displacement: counted * ROUNDING, along: 6.0 * ROUNDING * away }
    }

    /// How far the f32 of a distance may be from what the ray's parameter says, world units.
    pub(super) fn of_distance(distance: f64) -> f64 {
        9.0 * ROUNDING * distance + ROUNDING_OF_REFERENCE * distance
    }

    /// How far over or under the ground a point found may lie, vertically, for a ray along the unit vector `direction`.
    pub(super) fn height(&self, ground: &Ground, direction: DVec3) -> f64 {
        let [gx, gz] = ground.slope;
        let nearing = direction.y.abs() + gx * direction.x.abs() + gz * direction.z.abs();
        self.lift(ground) + self.along * nearing
    }

    /// How far over or under the ground a ray may pass.
    pub(super) fn lift(&self, ground: &Ground) -> f64 {
        self.displacement.y + ground.slope[0] * self.displacement.x + ground.slope[1] * self.displacement.z
    }

    /// What lies `off` the ground vertically, over what may; 1 is the bound.
    pub fn ratio(&self, off: f64, may: f64) -> f64 {
        if off == 0.0 { 0.0 } else { off / may }
    }
}
