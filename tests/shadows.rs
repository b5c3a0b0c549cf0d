//! Shadows against the reference in f64, pixel by pixel, and by what they must not change.
//!
//! `cargo test --test shadows -- --nocapture` prints the figures.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::{canyon, gpu, renderer};
use glam::DVec3;
use image::RgbaImage;
use rayon::prelude::*;
use relief::camera::{Camera, NamedView};
use relief::gpu::Target;
use relief::heightfield::HeightField;
use relief::heightfield::reference::Surface;
use relief::render::Renderer;
use relief::scene::Scene;
use relief::scene::light::Shadows;

/// Size of the pictures.
const SIZE: [u32; 2] = [160, 100];

/// How far the place that a pixel shows may be from the true one, in sides of the map: what single precision makes of a
/// ray (2.6e-6 at most, see the bound of the rays' displacement), and of a place on the map.
const PLACE: f64 = 4e-6;

/// How far the slope of a ray to the sun may be off: the rounding of heights over the ways that they count over.
const SLOPE: f64 = 4e-6;

/// Rays of a pixel's own width in this many parts may see another side of an edge.
const PART_OF_PIXEL: f64 = 0.01;

fn map_of(width: u32, height: u32, at: impl Fn(u32, u32) -> f64) -> HeightField {
    let raw: Vec<f64> = (0..height).flat_map(|z| (0..width).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
    HeightField::from_raw(width, height, &raw).unwrap()
}

fn noise(x: u32, z: u32) -> f64 {
    let mut bits = x.wrapping_mul(0x9e37_79b9) ^ z.wrapping_mul(0x85eb_ca6b);
    for _ in 0..3 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    f64::from(bits >> 8) / f64::from(1u32 << 24)
}

/// The Grand Canyon, and maps whose cells are as stiff as can be.
fn maps() -> Vec<(&'static str, Arc<HeightField>, Option<f64>)> {
    let flag = |on: bool| f64::from(u8::from(on));
    let side = 65;
    let unit = |i: u32| f64::from(i) / f64::from(side - 1);
    vec![
        ("canyon", canyon(), None),
        ("needles", Arc::new(map_of(side, side, |x, z| flag(x % 7 == 3 && z % 7 == 3))), Some(0.2)),
        ("wall", Arc::new(map_of(side, side, |x, z| flag(x == 21 && !(33..37).contains(&z)))), Some(0.2)),
        (
            "cliff",
            Arc::new(map_of(side, side, |x, z| if x < 32 { 0.04 * unit(z) } else { 1.0 - 0.04 * unit(z) })),
            Some(0.3),
        ),
        ("checkerboard", Arc::new(map_of(33, 33, |x, z| f64::from((x + z) % 2))), Some(0.02)),
        ("staircase", Arc::new(map_of(side, side, |x, _| f64::from(x / 8))), Some(0.3)),
        ("noise", Arc::new(map_of(side, side, noise)), Some(0.1)),
    ]
}

/// White ground in sunlight and nothing else: a pixel is black where the sun is hidden or behind the slope.
fn sunlit(camera: Camera, height_scale: Option<f64>, [azimuth, elevation]: [f32; 2]) -> Scene {
    let mut scene = Scene { camera: Some(camera), ..Scene::default() };
    scene.terrain.height_scale = height_scale;
    (scene.diffuse.enabled, scene.skybox.enabled) = (false, false);
    let light = &mut scene.lighting;
    (light.ambient, light.diffuse, light.specular) = (0.0, 2.0, 0.0);
    (light.sun_azimuth, light.sun_elevation) = (azimuth, elevation);
    scene
}

fn draw(renderer: &mut Renderer, scene: &Scene, shadows: Shadows) -> RgbaImage {
    let mut scene = scene.clone();
    scene.lighting.shadows = shadows;
    if std::env::var_os("DEV").is_some() {
        renderer.reload_shaders().unwrap();
    }
    let target = Target::new(&gpu(), SIZE);
    renderer.draw(&scene, &target).unwrap();
    target.read_color(&gpu()).unwrap()
}

/// Least sRGB value whose pixel is taken to face the sun: darker ones hide what they lose.
const FACING: u8 = 12;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Judged {
    compared: u32,
    dark: u32,
    /// The reference itself is of two minds.
    excused: u32,
    wrong: u32,
}

/// Compares hard shadows with the reference.
fn judge(map: &HeightField, scene: &Scene, off: &RgbaImage, hard: &RgbaImage) -> Judged {
    let extent = map.box_size(scene.terrain.height_scale);
    let surface = Surface::new(map, extent);
    let camera = scene.camera.unwrap();
    let azimuth = f64::from(scene.lighting.sun_azimuth).to_radians();
    let tangent = f64::from(scene.lighting.sun_elevation).to_radians().tan();
    let near = 1e-9 * extent.max_element();
    let side = extent.x.max(extent.z);
    let pixels: Vec<u32> = (0..SIZE[0] * SIZE[1]).collect();
    let judge = |&index: &u32| {
        let (x, y) = (index % SIZE[0], index / SIZE[0]);
        let facing = off.get_pixel(x, y).0[0];
        let mut judged = Judged::default();
        let ray = |dx: f64, dy: f64| camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE);
        let Some(hit) = surface.intersect(&ray(0.0, 0.0)).filter(|hit| !hit.wall && facing >= FACING) else {
            return judged;
        };
        judged.compared = 1;
        let shown = hard.get_pixel(x, y).0[0];
        assert!(shown == 0 || shown == facing, "pixel {x},{y} is neither lit nor dark: {shown} of {facing}");
        let dark = |place: DVec3, slope: f64| surface.horizon(place, azimuth, near) > slope;
        judged.dark = u32::from(dark(hit.position, tangent));
        if (shown == 0) == (judged.dark == 1) {
            return judged;
        }
        let on_ground = |place: DVec3| {
            let [u, v] = [place.x / extent.x, place.z / extent.z].map(|share| share.clamp(0.0, 1.0));
            DVec3::new(u * extent.x, map.surface_height(u, v) * extent.y, v * extent.z)
        };
        let around = (0..8).map(|turn| f64::from(turn) * std::f64::consts::FRAC_PI_4);
        let moved = around.map(|turn| on_ground(hit.position + DVec3::new(turn.cos(), 0.0, turn.sin()) * PLACE * side));
        let beside = [(PART_OF_PIXEL, 0.0), (-PART_OF_PIXEL, 0.0), (0.0, PART_OF_PIXEL), (0.0, -PART_OF_PIXEL)];
        let beside = beside.into_iter().filter_map(|(dx, dy)| Some(surface.intersect(&ray(dx, dy))?.position));
        let slopes = [tangent - SLOPE * (1.0 + tangent * tangent), tangent + SLOPE * (1.0 + tangent * tangent)];
        let mut places = std::iter::once(hit.position).chain(moved).chain(beside);
        let doubtful = places.any(|place| slopes.iter().any(|&slope| dark(place, slope) != (judged.dark == 1)));
        if doubtful {
            judged.excused = 1
        } else {
            judged.wrong = 1
        }
        judged
    };
    let add = |a: Judged, b: Judged| Judged {
        compared: a.compared + b.compared,
        dark: a.dark + b.dark,
        excused: a.excused + b.excused,
        wrong: a.wrong + b.wrong,
    };
    pixels.par_iter().map(judge).reduce(Judged::default, add)
}

#[test]
fn hard_shadows_are_those_of_the_reference() {
    let mut all = Judged::default();
    for (name, map, scale) in maps() {
        let extent = map.box_size(scale);
        let mut renderer = renderer(&map);
        for elevation in [1.0, 10.0, 45.0, 89.0] {
            for (view, azimuth) in [(NamedView::Over, 250.0), (NamedView::Graze, 90.0)] {
                let scene = sunlit(view.camera(&map, extent), scale, [azimuth, elevation]);
                let off = draw(&mut renderer, &scene, Shadows::Off);
                let hard = draw(&mut renderer, &scene, Shadows::Hard);
                let judged = judge(&map, &scene, &off, &hard);
                println!("{name:14} {elevation:3}° {:6} {judged:?}", view.name());
                assert_eq!(judged.wrong, 0, "{name} at {elevation}°");
                assert!(judged.excused <= 8, "{name} at {elevation}°: {} excused", judged.excused);
                all.compared += judged.compared;
                all.dark += judged.dark;
                all.excused += judged.excused;
            }
        }
    }
    println!("all: {all:?}");
    assert!(all.compared > 200_000 && all.dark > 40_000, "{all:?}");
}
