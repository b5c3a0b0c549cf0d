//! The eye: where it stands, where it looks, and the rays through the pixels.

use glam::{DMat4, DVec3, DVec4};
use serde::{Deserialize, Serialize};

use crate::heightfield::HeightField;

/// Distance of the near plane in world units. The projection has no far plane and its depth is reversed
/// (near 1, far 0), so that a small value costs no precision: depth is `NEAR` / view depth.
pub const NEAR: f64 = 1.0 / (1 << 20) as f64;

/// Largest pitch the controls reach, degrees. The basis is well defined beyond it, too.
pub const MAX_PITCH: f64 = 89.9;

/// A perspective camera without roll. Angles instead of a target: they stay well defined looking straight down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// World position.
    pub eye: DVec3,
    /// Compass direction in degrees, clockwise from north (−z).
    #[serde(default)]
    pub yaw: f64,
    /// Degrees above the horizon, −180 to 180; beyond ±90 the picture is upside down.
    #[serde(default)]
    pub pitch: f64,
    /// Vertical field of view in degrees.
    #[serde(default = "Camera::default_fov")]
    pub fov: f64,
}

/// The camera's orthonormal basis, world space, f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Where the camera looks.
    pub forward: DVec3,
    /// To the right of the picture.
    pub right: DVec3,
    /// To the top of the picture.
    pub up: DVec3,
}

/// A ray in world space, f64. `direction` has a view depth of 1, so a parameter along it is a view depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: DVec3,
    /// Direction, not normalised.
    pub direction: DVec3,
}

impl Camera {
    /// Vertical field of view where none is given, degrees.
    pub const DEFAULT_FOV: f64 = 60.0;

    fn default_fov() -> f64 {
        Self::DEFAULT_FOV
    }

    /// The camera at `eye` that looks at `target`. Looking straight down, north is up; `eye` = `target` looks north.
    pub fn look_at(eye: DVec3, target: DVec3, fov: f64) -> Self {
        let d = target - eye;
        let horizontal = d.x.hypot(d.z);
        let yaw = if horizontal > 0.0 { d.x.atan2(-d.z).to_degrees() } else { 0.0 };
        let pitch = if d == DVec3::ZERO { 0.0 } else { d.y.atan2(horizontal).to_degrees() };
        Self { eye, yaw, pitch, fov }
    }

    /// The basis vectors.
    pub fn basis(&self) -> Basis {
        let (sin_yaw, cos_yaw) = self.yaw.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.to_radians().sin_cos();
        let forward = DVec3::new(sin_yaw * cos_pitch, sin_pitch, -cos_yaw * cos_pitch);
        let right = DVec3::new(cos_yaw, 0.0, sin_yaw);
        Basis { forward, right, up: right.cross(forward) }
    }

    /// Half the picture's height at view depth 1.
    pub fn half_height(&self) -> f64 {
        (self.fov.to_radians() * 0.5).tan()
    }

    /// The size of a pixel at view depth 1, for a picture `height` pixels high.
    pub fn pixel_size(&self, height: u32) -> f64 {
        2.0 * self.half_height() / f64::from(height.max(1))
    }

    /// The ray through the picture's point (`x`, `y`) in pixels from its upper left corner; pixel centres are at +0.5.
    pub fn ray(&self, x: f64, y: f64, size: [u32; 2]) -> Ray {
        let basis = self.basis();
        let pixel = self.pixel_size(size[1]);
        let direction = basis.forward + basis.right * ((x - f64::from(size[0]) * 0.5) * pixel)
            - basis.up * ((y - f64::from(size[1]) * 0.5) * pixel);
        Ray { origin: self.eye, direction }
    }

    /// Projection times view: reversed depth, infinite far plane.
    pub fn clip_from_world(&self, size: [u32; 2]) -> DMat4 {
        let Basis { forward, right, up } = self.basis();
        let y_scale = 1.0 / self.half_height();
        let x_scale = y_scale * f64::from(size[1].max(1)) / f64::from(size[0].max(1));
        let row = |axis: DVec3, scale: f64| DVec4::new(axis.x, axis.y, axis.z, -axis.dot(self.eye)) * scale;
        DMat4::from_cols(row(right, x_scale), row(up, y_scale), DVec4::new(0.0, 0.0, 0.0, NEAR), row(forward, 1.0))
            .transpose()
    }
}

/// The five views of every table, and the start view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum NamedView {
    /// The view a terrain opens with: from above its southern edge over all of it. One that is much longer than wide, or
    /// higher than that, is seen whole from outside.
    Start,
    /// From above a corner, down over the middle.
    Over,
    /// From outside and low, along the surface.
    Graze,
    /// From just above the ground of the lowest place, along the valley.
    Valley,
    /// Straight down.
    Down,
    /// From the rim, level, the horizon in the middle of the picture.
    Horizon,
}

impl NamedView {
    /// The five views that every table reports.
    pub const MEASURED: [Self; 5] = [Self::Over, Self::Graze, Self::Valley, Self::Down, Self::Horizon];

    /// The name used on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Over => "over",
            Self::Graze => "graze",
            Self::Valley => "valley",
            Self::Down => "down",
            Self::Horizon => "horizon",
        }
    }

    /// The camera of this view over `map` in a box of the size `extent` (world units).
    pub fn camera(self, map: &HeightField, extent: DVec3) -> Camera {
        let DVec3 { x: sx, y: sy, z: sz } = extent;
        let fov = Camera::DEFAULT_FOV;
        let middle = DVec3::new(sx * 0.5, sy * 0.5, sz * 0.5);
        let over_ground =
            |x: f64, z: f64, clearance: f64| DVec3::new(x, sy * map.surface_height(x / sx, z / sz) + clearance, z);
        match self {
            Self::Start if is_slender(extent) => frame_all(map, extent, fov),
            Self::Start => {
                let eye = DVec3::new(sx * 0.66, sy * 1.1 + 0.17 * sz, sz * 1.0);
                Camera::look_at(eye, DVec3::new(sx * 0.42, sy * 0.3, sz * 0.36), fov)
            }
            Self::Over => Camera::look_at(DVec3::new(-0.15 * sx, sy + 0.45, -0.15 * sz), middle, fov),
            Self::Graze => {
                let eye = DVec3::new(-0.06, sy * 1.08 + 0.01, sz * 0.42);
                Camera::look_at(eye, DVec3::new(sx * 0.8, sy * 0.35, sz * 0.55), fov)
            }
            Self::Valley => {
                let (u, v) = map.lowest_interior();
                let eye = over_ground(u * sx, v * sz, 0.04 * sy + 0.002);
                Camera { eye, yaw: open_direction(map, extent, eye), pitch: 0.0, fov }
            }
            Self::Down => {
                Camera { eye: DVec3::new(middle.x, sy + 0.75 * sx.max(sz), middle.z), yaw: 0.0, pitch: -90.0, fov }
            }
            Self::Horizon => {
                let eye = over_ground(sx * 0.03, sz * 0.04, 0.12 * sy + 0.002);
                Camera::look_at(eye, DVec3::new(sx, eye.y, sz * 0.95), fov)
            }
        }
    }
}

/// Sides of a box beyond which the usual start view would cut it off or look past it: the longer horizontal one against the
/// shorter, and the height against the longer.
const SLENDER: [f64; 2] = [1.5, 0.6];

fn is_slender(extent: DVec3) -> bool {
    let (long, short) = (extent.x.max(extent.z), extent.x.min(extent.z));
    long > SLENDER[0] * short || extent.y > SLENDER[1] * long
}

/// The whole box from above, its longer side across the picture: from the south, or from the east where it is longer from
/// north to south. Where the ground would turn its back on that view, from the side that it falls towards most.
///
/// The box keeps to the middle of the picture, where it is whole at any usual size of the picture and beside the panel.
fn frame_all(map: &HeightField, extent: DVec3, fov: f64) -> Camera {
    /// Degrees aside and down.
    const TURN: f64 = 25.0;
    const PITCH: f64 = -30.0;
    /// Shares of half the picture's height that the box may reach to, across and up.
    const ROOM: [f64; 2] = [0.75, 0.8];
    /// How steeply the ground may fall away from the usual side: half of the view's own slope.
    const BACK: f64 = 0.3;
    let usual = if extent.z > extent.x { -90.0 + TURN } else { -TURN };
    let (long, short) = (extent.x.max(extent.z), extent.x.min(extent.z));
    let slope = |yaw: f64| slope(map, extent, yaw);
    let others: &[f64] = if long > SLENDER[0] * short { &[180.0] } else { &[90.0, 180.0, 270.0] };
    let others = others.iter().map(|turn| usual + turn).filter(|_| slope(usual) < -BACK);
    let yaw = others.fold(usual, |best, yaw| if slope(yaw) > slope(best) { yaw } else { best });
    let camera = Camera { eye: extent * 0.5, yaw, pitch: PITCH, fov };
    let (Basis { forward, right, up }, half) = (camera.basis(), camera.half_height());
    let corners = (0..8).map(|corner| {
        let side = |bit: u32| if corner >> bit & 1 == 1 { 0.5 } else { -0.5 };
        extent * DVec3::new(side(0), side(1), side(2))
    });
    let needed = corners.map(|corner| {
        let beside = (corner.dot(right).abs() / ROOM[0]).max(corner.dot(up).abs() / ROOM[1]);
        beside / half - corner.dot(forward)
    });
    Camera { eye: camera.eye - forward * needed.fold(0.0, f64::max), ..camera }
}

/// How steeply the ground rises in the compass direction `yaw`, degrees: that of the plane that fits it best in a box of the
/// size `extent`, rise over run.
fn slope(map: &HeightField, extent: DVec3, yaw: f64) -> f64 {
    const PLACES: u32 = 16;
    let (sin, cos) = yaw.to_radians().sin_cos();
    let place = |index: u32| (f64::from(index) + 0.5) / f64::from(PLACES);
    let places = (0..PLACES * PLACES).map(|index| (place(index % PLACES), place(index / PLACES)));
    // Of a ramp that rises by 1 along u or v the mean of the height times that of the middle's distance is a twelfth.
    let per_side = |along: f64, side: f64| if side > 0.0 { 12.0 * along * extent.y / side } else { 0.0 };
    let (east, north) = (per_side(sin, extent.x), per_side(cos, extent.z));
    let shares = places.map(|(u, v)| map.surface_height(u, v) * ((u - 0.5) * east - (v - 0.5) * north));
    shares.filter(|share| share.is_finite()).sum::<f64>() / f64::from(PLACES * PLACES)
}

/// The compass direction in which the ground stays below `eye` the longest, degrees.
fn open_direction(map: &HeightField, extent: DVec3, eye: DVec3) -> f64 {
    const STEP: f64 = 1.0 / 256.0;
    let reach = |yaw: f64| {
        let (sin, cos) = yaw.to_radians().sin_cos();
        let blocked = |steps: u32| {
            let (x, z) = (eye.x + sin * STEP * f64::from(steps), eye.z - cos * STEP * f64::from(steps));
            let outside = x < 0.0 || z < 0.0 || x > extent.x || z > extent.z;
            outside || map.surface_height(x / extent.x, z / extent.z) * extent.y > eye.y
        };
        (1..512).find(|&steps| blocked(steps)).unwrap_or(512)
    };
    let directions = (0..32).map(|index| f64::from(index) * 11.25);
    directions.fold((0, 0.0), |best, yaw| if reach(yaw) > best.0 { (reach(yaw), yaw) } else { best }).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix and the pixel rays are derived apart; a picture is only right when they agree.
    #[test]
    fn a_point_on_a_pixels_ray_projects_onto_that_pixel() {
        let size = [640, 400];
        for (yaw, pitch) in [(0.0, 0.0), (137.0, -35.0), (270.0, -90.0), (-20.0, 60.0)] {
            let camera = Camera { eye: DVec3::new(3.0, -1.0, 0.5), yaw, pitch, fov: 47.0 };
            for (x, y) in [(0.5, 0.5), (320.0, 200.0), (639.5, 17.0)] {
                let ray = camera.ray(x, y, size);
                let depth = 7.0;
                let clip = camera.clip_from_world(size) * (ray.origin + ray.direction * depth).extend(1.0);
                let ndc = clip / clip.w;
                assert!((clip.w - depth).abs() < 1e-9);
                assert!(((ndc.x + 1.0) * 0.5 * 640.0 - x).abs() < 1e-6, "x of {camera:?}");
                assert!(((1.0 - ndc.y) * 0.5 * 400.0 - y).abs() < 1e-6, "y of {camera:?}");
                assert!((ndc.z - NEAR / depth).abs() < 1e-12);
            }
        }
    }

    /// Strips, towers and what exaggeration makes of them: the view that a map opens with shows all of it.
    #[test]
    fn the_start_view_of_a_slender_map_shows_all_of_it() {
        let map = HeightField::from_raw(2, 2, &[0.0f64, 1.0, 0.0, 1.0]).unwrap();
        let whole = |extent: DVec3, size: [u32; 2]| {
            let matrix = NamedView::Start.camera(&map, extent).clip_from_world(size);
            (0..8).all(|corner| {
                let side = |bit: u32| f64::from(corner >> bit & 1);
                let clip = matrix * (extent * DVec3::new(side(0), side(1), side(2))).extend(1.0);
                clip.w > NEAR && clip.x.abs() < clip.w && clip.y.abs() < clip.w
            })
        };
        for extent in [
            [0.02, 0.25, 1.0],  // 40 × 2000 samples
            [1.0, 0.25, 0.02],  // 2000 × 40
            [1.0, 0.05, 0.56],  // carrizo.tif
            [0.56, 0.05, 1.0],  // the same, turned
            [1.0, 6.0, 1.0],    // the canyon, 100 times as high
            [1.0, 1000.0, 1.0], // as high as it can be
            [0.001, 2.0, 1.0],
            [1.0, 0.0, 0.3],
        ] {
            for size in [[1280, 800], [800, 800], [2560, 1080]] {
                assert!(whole(DVec3::from(extent), size), "{extent:?} at {size:?}");
            }
        }
        // Others keep the view from above their southern edge.
        let usual = NamedView::Start.camera(&map, DVec3::new(1.0, 0.25, 0.8));
        assert!(usual.eye.abs_diff_eq(DVec3::new(0.66, 0.25 * 1.1 + 0.17 * 0.8, 0.8), 1e-12), "{usual:?}");
    }

    /// A tower whose southern side is the high one is not shown from behind. North stays up where that shows the ground.
    #[test]
    fn the_start_view_of_a_slender_map_faces_its_ground() {
        let square = DVec3::new(1.0, 0.8, 1.0);
        // So narrow that what is a gentle rise along it is steep across it.
        let (across, along) = (DVec3::new(1.0, 0.2, 0.2), DVec3::new(0.2, 0.2, 1.0));
        for (extent, side, heights, forward) in [
            (square, 2, &[0.0, 0.0, 1.0, 1.0][..], DVec3::Z), // high in the south: from the north
            (square, 2, &[1.0, 1.0, 0.0, 0.0], -DVec3::Z),    // high in the north
            (square, 2, &[1.0, 0.0, 1.0, 0.0], -DVec3::Z),    // high in the west
            (square, 3, &[0.4, 0.4, 0.4, 0.0, 1.0, 0.0, 0.6, 0.6, 0.6], -DVec3::Z), // a little higher in the south
            (square, 2, &[0.5, 0.5, 0.5, 0.5], -DVec3::Z),    // level: from the south, as ever
            (across, 2, &[0.0, 0.0, 1.0, 1.0], DVec3::Z),
            (across, 2, &[1.0, 1.0, 0.0, 0.0], -DVec3::Z),
            (along, 2, &[0.0, 1.0, 0.0, 1.0], DVec3::X), // high in the east: from the west
            (along, 2, &[1.0, 0.0, 1.0, 0.0], -DVec3::X),
        ] {
            let map = HeightField::from_raw(side, side, heights).unwrap();
            let camera = NamedView::Start.camera(&map, extent);
            assert!(camera.basis().forward.dot(forward) > 0.5, "{heights:?}: {camera:?}");
        }
    }

    #[test]
    fn look_at_looks_at_the_target() {
        for target in [DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, -5.0, 0.0), DVec3::new(-4.0, 0.0, -0.1)] {
            let eye = DVec3::new(0.0, 1.0, 0.0);
            let forward = Camera::look_at(eye, target, 60.0).basis().forward;
            assert!((forward - (target - eye).normalize()).length() < 1e-12, "{target}");
        }
        let down = Camera::look_at(DVec3::Y, DVec3::ZERO, 60.0).basis();
        assert!((down.up - DVec3::NEG_Z).length() < 1e-12, "north is up when looking straight down");
    }
}
