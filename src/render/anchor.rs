//! Deep zooms: where the rays of a view count from whose pixels are finer than f32 resolves the box.
//!
//! f32 counts in steps of u = 2⁻²⁴ of a number's size. Coordinates that count from the map's corner, and parameters that
//! count from where a ray enters the box, are as large as the box: neighbouring pixels less than some u apart share them,
//! and the picture shows stairs. Counted from an **anchor**, a point at the ground that is seen, they are as small as what
//! is seen, and as fine. The CPU knows the anchor in f64 and splits its place into whole cells, which nodes and walls are
//! counted in, exactly, and a fraction of a cell; what is left of it goes into the rays' origin. `anchor.wgsl` and
//! `march/max-mipmap-deep.wgsl` cast the rays.
//!
//! # What is exact
//!
//! The fraction is a multiple of 2⁻²², so that a wall's number less the anchor's cell and less the fraction is exact for
//! the walls of the anchor's cell and three beyond them, and rounded by u of its distance for the others. Heights
//! are shares of the box's, of which the map's are f32 numbers; the anchor's is one, too, and the difference of two f32
//! numbers is rounded by u of itself at most. The heights at the anchor of the patches around it, less the anchor's, are
//! f32 numbers made in f64. So all that is known of a ray and of the ground is rounded by a few u of its distance from the anchor, down to
//! what f64 knows of the camera: `report/stress/bound.rs` has the sum.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3};

use crate::camera::Camera;
use crate::heightfield::HeightField;
use crate::heightfield::reference::Surface;

use super::frame::{ray_start, without_subnormals};
use super::ground::Ground;

/// A zoom is deep where a pixel's width is a smaller share of the box than this, sixty-four roundings of an f32: by the
/// largest of the ordinary path's roundings, about four, a ray is then off by a sixteenth of a pixel.
const DEEP: f64 = 1.0 / (1u32 << 18) as f64;

/// Parts of a cell that the anchor's fraction counts in.
const FRACTIONS: f64 = (1u32 << 22) as f64;

/// Most anchors of a view.
pub(super) const MOST_ANCHORS: usize = 4;

/// Roundings of a distance from an anchor, as a share of it.
const ROUNDINGS: f64 = 8.0 / (1u32 << 24) as f64;

/// Share of a pixel's width that these may be without another anchor.
const WELL_RESOLVED: f64 = 0.01;

/// Where in the picture the ground is looked for: the centre first, then a grid of so many points each way.
const GRID: u32 = 5;

/// Whether pixels of this view are finer than the ordinary path's f32 resolves.
///
/// The ordinary path's rays begin at the view depth `ray_start`, at the eye if that is in the box. There the origin is
/// the same for all rays and rounding grows with the distance from the eye, just as a pixel's width: its angle counts.
/// From farther away it is the width where the box ends.
pub(super) fn is_deep_zoom(camera: &Camera, size: [u32; 2], extent: DVec3) -> bool {
    let side = extent.max_element();
    let angle = camera.pixel_size(size[1]);
    angle * (ray_start(camera, extent) + side) < DEEP * side
}

/// What the rays of a deep zoom count from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Anchor {
    /// View depth of the anchor: parameters along rays are view depths less this one.
    pub(crate) depth: f64,
    /// The cell that it is in, column and row.
    pub(crate) cell: [u32; 2],
    /// Cells of the map along x and z.
    pub(crate) cells: [u32; 2],
    /// Where in the cell it is, 0 to 1.
    fraction: DVec2,
    /// Its height as a share of the box's; an f32 number.
    height: f64,
    /// Heights of the patches of its cell and those around it, by row and column, continued to the anchor's place, less
    /// the anchor's height.
    grounds: [[f64; 3]; 3],
    /// World position of the central ray at the anchor's depth.
    pub(crate) central: DVec3,
}

impl Anchor {
    /// The anchors of `camera`'s view of `field`, in a box of the size `extent`, the nearest first: one where the central ray
    /// meets the ground, or else the nearest of some rays across the picture, and others where those meet ground so far
    /// from it that its pixels are finer than a rounding there. Where none of them meets any there is one beside the
    /// middle of the box.
    pub(super) fn find(camera: &Camera, size: [u32; 2], extent: DVec3, field: &HeightField) -> Vec<Self> {
        let surface = Surface::new(field, extent);
        let hit = |(x, y): (f64, f64)| {
            let [width, height] = size.map(f64::from);
            surface.intersect(&camera.ray(x * width, y * height, size)).map(|hit| hit.depth)
        };
        let share = |index: u32| (f64::from(index) + 0.5) / f64::from(GRID);
        let grid = (0..GRID).flat_map(|row| (0..GRID).map(move |column| (share(column), share(row))));
        let seen: Vec<f64> = grid.filter_map(hit).collect();
        let first = hit((0.5, 0.5))
            .or_else(|| seen.iter().copied().min_by(f64::total_cmp))
            .unwrap_or_else(|| camera.basis().forward.dot(extent * 0.5 - camera.eye).max(0.0));
        let pixel = camera.pixel_size(size[1]);
        let mut depths = vec![first];
        while depths.len() < MOST_ANCHORS {
            // How far a depth is from the nearest anchor, over how far it may.
            let need = |at: f64| {
                let away = depths.iter().map(|depth| (at - depth).abs()).fold(f64::INFINITY, f64::min);
                away * ROUNDINGS / (WELL_RESOLVED * pixel * at)
            };
            let Some(&worst) = seen.iter().max_by(|a, b| need(**a).total_cmp(&need(**b))) else { break };
            // Of an eye on the ground, 0 over 0, there is no need.
            if need(worst) > 1.0 {
                depths.push(worst);
            } else {
                break;
            }
        }
        depths.sort_by(f64::total_cmp);
        depths.into_iter().map(|depth| Self::at(camera, extent, field, depth)).collect()
    }

    /// The anchor on the central ray at a view depth, or the nearest place over the map.
    fn at(camera: &Camera, extent: DVec3, field: &HeightField, depth: f64) -> Self {
        let central = camera.eye + camera.basis().forward * depth;
        let scale = GridScale::new(field, extent);
        let place = central * scale.per_unit;
        let along = |axis: usize, at: f64| {
            let cells = f64::from(field.cells()[axis]);
            let cell = at.clamp(0.0, cells - 1.0).floor();
            (cell, ((at - cell).clamp(0.0, 1.0) * FRACTIONS).round() / FRACTIONS)
        };
        let ((column, u), (row, v)) = (along(0, place.x), along(1, place.z));
        let height = f64::from(place.y.clamp(0.0, 1.0) as f32);
        let cell = [column, row].map(|cell| cell as u32);
        let fraction = DVec2::new(u, v);
        let patch = |i: u32, j: u32| patch_over(field, cell, [i, j], fraction, scale.relief, height);
        let grounds = [0, 1, 2].map(|j| [0, 1, 2].map(|i| patch(i, j)));
        Self { depth, cell, cells: field.cells(), fraction, height, grounds, central }
    }
}

/// Height over `height` of the patch of a cell around `cell` (`beside`: 0, 1 and 2 along each axis, itself the 1), continued
/// to the place `fraction` of `cell`. Cells beyond the map's border are of no interest; theirs is that of the nearest one.
fn patch_over(field: &HeightField, cell: [u32; 2], beside: [u32; 2], fraction: DVec2, relief: f64, height: f64) -> f64 {
    let [i, j] = [0, 1].map(|axis: usize| (cell[axis] + beside[axis]).saturating_sub(1).min(field.cells()[axis] - 1));
    let corner = |x: u32, y: u32| f64::from(field.sample(i + x, j + y)) * relief - height;
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let x = fraction.x + f64::from(cell[0]) - f64::from(i);
    let y = fraction.y + f64::from(cell[1]) - f64::from(j);
    mix(mix(corner(0, 0), corner(1, 0), x), mix(corner(0, 1), corner(1, 1), x), y)
}

/// A box lower than this counts its heights in shares of this, so that no f32 overflows.
const LEAST_HEIGHT: f64 = 1e-12;

/// From world units to those of the anchored rays: cells along x and z, shares of the box's height up.
struct GridScale {
    per_unit: DVec3,
    /// What a height of 1 is then: 1 for all but the lowest boxes.
    relief: f64,
}

impl GridScale {
    fn new(field: &HeightField, extent: DVec3) -> Self {
        let [columns, rows] = field.cells().map(f64::from);
        let per_unit = DVec3::new(columns / extent.x, 1.0 / extent.y.max(LEAST_HEIGHT), rows / extent.z);
        Self { per_unit, relief: (extent.y / LEAST_HEIGHT).min(1.0) }
    }
}

/// Mirror of `Anchor` in `anchor.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct AnchorUniform {
    pub(super) origin: Vec3,
    pub(super) depth: f32,
    pub(super) origin_right: Vec3,
    pub(super) beam_shift: f32,
    pub(super) origin_down: Vec3,
    pub(super) begin: f32,
    pub(super) direction: Vec3,
    pub(super) height: f32,
    pub(super) direction_right: Vec3,
    pub(super) units: f32,
    pub(super) direction_down: Vec3,
    pub(super) relief: f32,
    pub(super) low: Vec3,
    pub(super) shares_per_unit: f32,
    pub(super) high: Vec3,
    pub(super) end: f32,
    pub(super) cell: [f32; 2],
    pub(super) fraction: [f32; 2],
    pub(super) grounds: [[f32; 4]; 3],
}

/// Parameter that no ray reaches.
const FOR_EVER: f64 = 1e29;

impl AnchorUniform {
    /// The rays of `camera` through a picture of `size` pixels, each piece counted from the nearest of `anchors`, of which
    /// there is at least one. `extent` is the size of the box, and `lid` the share of its height in which the rays are of
    /// interest.
    pub(super) fn all(
        anchors: &[Anchor],
        camera: &Camera,
        size: [u32; 2],
        extent: DVec3,
        ground: &Ground,
        lid: f64,
    ) -> [Self; MOST_ANCHORS] {
        // Without a length, where there is no such anchor.
        let mut all = [Self { begin: 1.0, ..Self::zeroed() }; MOST_ANCHORS];
        for (index, (uniform, anchor)) in all.iter_mut().zip(anchors).enumerate() {
            let middle = |other: Option<&Anchor>| other.map(|other| 0.5 * (anchor.depth + other.depth));
            let begin = middle(index.checked_sub(1).and_then(|before| anchors.get(before)));
            let end = middle(anchors.get(index + 1));
            let piece = [begin.unwrap_or(f64::NEG_INFINITY), end.unwrap_or(f64::INFINITY)];
            *uniform = Self::new(anchor, camera, size, extent, ground, lid, piece);
        }
        all
    }

    fn new(
        anchor: &Anchor,
        camera: &Camera,
        size: [u32; 2],
        extent: DVec3,
        ground: &Ground,
        lid: f64,
        [begin, end]: [f64; 2],
    ) -> Self {
        let field = ground.terrain().field();
        let GridScale { per_unit, relief } = GridScale::new(field, extent);
        let basis = camera.basis();
        let pixel = camera.pixel_size(size[1]);
        let [right, down] = [basis.right, -basis.up].map(|axis| axis * pixel * per_unit);
        let [columns, rows] = field.cells().map(f64::from);
        let [column, row] = anchor.cell.map(f64::from);
        // Whole cells first: the differences are exact.
        let from_anchor = |point: DVec3| {
            DVec3::new(point.x - column - anchor.fraction.x, point.y - anchor.height, point.z - row - anchor.fraction.y)
        };
        let vector = |vector: DVec3| vector.as_vec3();
        // A little more on either side, so that rounding leaves no gap between pieces.
        let parameter = |depth: f64, sign: f64| {
            let counted = depth - anchor.depth;
            (counted + sign * counted.abs() * 1e-6).clamp(-FOR_EVER, FOR_EVER) as f32
        };
        without_subnormals(Self {
            origin: vector(from_anchor(anchor.central * per_unit)),
            depth: anchor.depth as f32,
            origin_right: vector(right * anchor.depth),
            beam_shift: (anchor.depth - ray_start(camera, extent)) as f32,
            origin_down: vector(down * anchor.depth),
            begin: parameter(begin, -1.0),
            direction: vector(basis.forward * per_unit),
            height: anchor.height as f32,
            direction_right: vector(right),
            units: ground.units().map_or(0.0, f32::from),
            direction_down: vector(down),
            relief: relief as f32,
            low: vector(from_anchor(DVec3::ZERO)),
            shares_per_unit: per_unit.y as f32,
            high: vector(from_anchor(DVec3::new(columns, lid * relief, rows))),
            end: parameter(end, 1.0),
            cell: anchor.cell.map(|cell| cell as f32),
            fraction: anchor.fraction.as_vec2().to_array(),
            grounds: anchor.grounds.map(|[west, own, east]| [west as f32, own as f32, east as f32, 0.0]),
        })
    }
}
