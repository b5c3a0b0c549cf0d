//! The lens flare: where its parts are and how bright. Its shader is `flare.wgsl`.
//!
//! The sun's disc is looked for in f64 on the CPU, by exact walks from the eye to points that are spread evenly over it: a
//! flare costs no pass where the sun is hidden or beside the picture.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec2, DVec3, Vec3};

use crate::camera::{Camera, Ray};
use crate::gpu::{COLOR_FORMAT, Gpu};
use crate::heightfield::reference::Surface;
use crate::heightfield::{Crater, EditedTerrain, HeightField};
use crate::scene::Scene;

use super::frame::{storage_buffer, storage_entry, without_subnormals};
use super::occluder;
use super::pipelines::PassDescription;

/// Parts of a flare.
const GHOSTS: usize = 8;

/// Constants of `flare.wgsl`.
pub(super) fn wgsl() -> String {
    format!("#define_import_path relief::flare_constants\nconst GHOSTS: u32 = {GHOSTS}u;\n")
}

/// Points of the disc that are looked for.
const POINTS: u32 = 31;

/// Angular radius of the sun's disc, radians.
const SUN_RADIUS: f64 = 0.2665 * std::f64::consts::PI / 180.0;

/// Share of the picture's half width and height beside the border within which a flare fades.
const BORDER: f64 = 0.08;

pub(super) fn describe() -> PassDescription {
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let keep = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    PassDescription {
        modules: Vec::new(),
        bindings: vec![storage_entry::<FlareUniform>(0)],
        frame: false,
        // Its pass has the picture's depth for the clouds.
        depth: Some((wgpu::CompareFunction::Always, false)),
        blend: Some(wgpu::BlendState { color: add, alpha: keep }),
        format: COLOR_FORMAT,
        ..PassDescription::scene("flare", "flare.wgsl", false)
    }
}

/// Mirror of `Ghost` in `flare.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct GhostUniform {
    pub(super) place: [f32; 4],
    pub(super) light: [f32; 4],
}

/// Mirror of `Flare` in `flare.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct FlareUniform {
    pub(super) ghosts: [GhostUniform; GHOSTS],
}

/// Where the sun stands in the picture, −1 to 1 each way, up and to the right; `None` beside it.
pub(super) fn sun_in_picture(camera: &Camera, size: [u32; 2], sun: DVec3) -> Option<DVec2> {
    let basis = camera.basis();
    let ahead = basis.forward.dot(sun);
    if ahead <= 0.0 {
        return None;
    }
    let half = DVec2::new(f64::from(size[0]), f64::from(size[1])) * (0.5 * camera.pixel_size(size[1]));
    let at = DVec2::new(basis.right.dot(sun), basis.up.dot(sun)) / ahead / half;
    (at.abs().max_element() < 1.0).then_some(at)
}

/// Share of the sun's disc that neither `field`, in a box of the size `extent`, nor the occluder hides from `eye`.
fn visible_share(scene: &Scene, field: &HeightField, extent: DVec3, eye: DVec3) -> f64 {
    let sun = scene.lighting.sun_direction();
    let surface = Surface::new(field, extent);
    let cube_from_world =
        scene.occluder.enabled.then(|| occluder::world_from_cube(&scene.occluder, field, extent).inverse());
    let across = sun.any_orthonormal_vector();
    let up = sun.cross(across);
    let is_seen = |index: &u32| {
        // Vogel's spiral: even over the disc.
        let (radius, turn) = (((f64::from(*index) + 0.5) / f64::from(POINTS)).sqrt(), 2.399_963_23 * f64::from(*index));
        let direction = sun + SUN_RADIUS * radius * (across * turn.cos() + up * turn.sin());
        let hidden_by_cube = cube_from_world.is_some_and(|to_cube| meets_unit_cube(to_cube, eye, direction));
        // The horizon hides it, too.
        direction.y > 0.0 && !hidden_by_cube && surface.intersect(&Ray { origin: eye, direction }).is_none()
    };
    f64::from((0..POINTS).filter(is_seen).count() as u32) / f64::from(POINTS)
}

/// How much of the sun was seen, and of what that was found. The walks of a look on a large map take milliseconds: while neither
/// eye, sun, ground nor occluder moves, clouds and fog may, and need no other look.
#[derive(Debug)]
pub(super) struct SunLook {
    eye: DVec3,
    sun: DVec3,
    extent: DVec3,
    map: Arc<HeightField>,
    craters: Vec<Crater>,
    cube: Option<DMat4>,
    share: f64,
}

impl SunLook {
    /// Looks for the sun of `scene` from `eye`, unless `last` has seen the same.
    pub(super) fn of(scene: &Scene, terrain: &EditedTerrain, extent: DVec3, eye: DVec3, last: Option<Self>) -> Self {
        let (sun, map) = (scene.lighting.sun_direction(), terrain.base());
        let cube = scene.occluder.enabled.then(|| occluder::world_from_cube(&scene.occluder, map, extent));
        let same = |last: &Self| {
            Arc::ptr_eq(&last.map, map)
                && (last.eye, last.sun, last.extent, last.cube) == (eye, sun, extent, cube)
                && last.craters == terrain.craters()
        };
        last.filter(same).unwrap_or_else(|| Self {
            eye,
            sun,
            extent,
            map: Arc::clone(map),
            craters: terrain.craters().to_vec(),
            cube,
            share: visible_share(scene, terrain.field(), extent, eye),
        })
    }

    /// Share of the sun's disc that neither ground nor occluder hides.
    pub(super) fn share(&self) -> f64 {
        self.share
    }

    /// Pretends to have seen another share.
    #[cfg(test)]
    pub(super) fn pretend(&mut self, share: f64) {
        self.share = share;
    }
}

fn meets_unit_cube(to_cube: DMat4, eye: DVec3, direction: DVec3) -> bool {
    let (from, along) = (to_cube.transform_point3(eye), to_cube.transform_vector3(direction));
    let (first, second) = ((DVec3::ZERO - from) / along, (DVec3::ONE - from) / along);
    let (enter, leave) = (first.min(second).max_element(), first.max(second).min_element());
    enter <= leave && leave > 0.0
}

/// The parts of a flare of the sun at `sun` in the picture. `light` is the sun's, dimmed by what hides it.
pub(super) fn uniform(sun: DVec2, size: [u32; 2], light: Vec3) -> FlareUniform {
    let border = ((1.0 - sun.abs().max_element()) / BORDER).clamp(0.0, 1.0) as f32;
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    // Place along the line from the sun (1) through the middle (0), radius over the picture's half height, colour, kind.
    let parts: [(f64, f64, [f32; 3], f32); GHOSTS] = [
        (1.0, 0.8, [0.20, 0.17, 0.13], 2.0),
        (1.0, 0.62, [0.036, 0.031, 0.027], 1.0),
        (0.52, 0.055, [0.06, 0.04, 0.016], 0.0),
        (0.26, 0.13, [0.018, 0.032, 0.018], 0.0),
        (-0.22, 0.04, [0.055, 0.046, 0.03], 0.0),
        (-0.48, 0.2, [0.013, 0.021, 0.035], 0.0),
        (-0.8, 0.09, [0.04, 0.022, 0.03], 0.0),
        (-1.15, 0.34, [0.011, 0.018, 0.015], 0.0),
    ];
    let ghosts = parts.map(|(along, radius, colour, kind)| {
        let centre = sun * along;
        let light = Vec3::from(colour) * light * border;
        GhostUniform {
            place: [centre.x as f32, centre.y as f32, (radius / aspect) as f32, radius as f32],
            light: light.extend(kind).to_array(),
        }
    });
    without_subnormals(FlareUniform { ghosts })
}

/// The constants' buffer.
#[derive(Debug)]
pub(super) struct FlareBindings {
    buffer: wgpu::Buffer,
}

impl FlareBindings {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { buffer: storage_buffer(gpu, "flare", size_of::<FlareUniform>()) }
    }

    pub(super) fn write(&self, gpu: &Gpu, uniform: &FlareUniform) {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
    }

    pub(super) fn entry(&self) -> (u32, wgpu::BindingResource<'_>) {
        (0, self.buffer.as_entire_binding())
    }
}

/// Vertices of a part, and how many there are.
pub(super) const DRAWN: (u32, u32) = (6, GHOSTS as u32);

#[cfg(test)]
mod tests {
    use super::*;

    /// A sun half behind a level horizon of hills shows half of its disc, and one beside the picture has no flare.
    #[test]
    fn the_share_of_the_disc_is_what_hills_leave() {
        let field = HeightField::from_raw(2, 2, &[0.0, 1.0, 0.0, 1.0f64]).unwrap();
        let extent = DVec3::new(1.0, 0.5, 1.0);
        let mut scene = Scene::default();
        scene.lighting.sun_azimuth = 90.0;
        // From over the middle, in height of the eastern rim's upper edge by so many degrees.
        let eye = DVec3::new(0.0, 0.3, 0.5);
        let edge = 0.2f64.atan().to_degrees();
        let mut share = |over: f64| {
            scene.lighting.sun_elevation = (edge + over) as f32;
            visible_share(&scene, &field, extent, eye)
        };
        assert_eq!((share(-1.0), share(1.0)), (0.0, 1.0));
        assert!((share(0.0) - 0.5).abs() < 0.1);
        let shares: Vec<f64> = (-30..=30).map(|step| share(f64::from(step) * 0.01)).collect();
        assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]), "{shares:?}");
        let mut cubed = scene.clone();
        cubed.lighting.sun_elevation = 45.0;
        (cubed.occluder.enabled, cubed.occluder.position) = (true, Some(eye + cubed.lighting.sun_direction()));
        assert_eq!(visible_share(&cubed, &field, extent, eye), 0.0, "behind the cube");

        let camera = Camera { eye, yaw: 90.0, pitch: 0.0, fov: 60.0 };
        let at = |azimuth: f64, elevation: f64| {
            let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
            let sun = DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos());
            sun_in_picture(&camera, [200, 100], sun)
        };
        assert!(at(90.0, 0.0).unwrap().length() < 1e-12);
        assert!((at(90.0, 29.9).unwrap().y - 1.0).abs() < 0.01);
        assert_eq!([at(90.0, 30.1), at(270.0, 0.0), at(141.0, 0.0)], [None; 3]);
    }
}
