//! The occluder hides hills and is hidden by them, to the pixel: what each pixel shows, and how far away it is, against
//! terrain and cube intersected on the CPU in f64.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use common::{SIZE, canyon, picture, renderer, scene_at};
use glam::{DMat3, DVec3};
use image::RgbaImage;
use rayon::prelude::*;
use relief::camera::{Camera, NamedView, Ray};
use relief::heightfield::reference::Surface;
use relief::render::Renderer;
use relief::scene::{OccluderSettings, Scene};

/// A pixel whose ray passes an edge of the cube or the terrain's silhouette this close, in pixels, may show either side.
const BAND_PIXELS: f64 = 0.01;

/// Distances nearer to each other than this, in world units, may be told apart either way: three units in the last
/// place of an f32 depth.
const SAME_DISTANCE: f64 = 1e-6;

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seen {
    Sky,
    Ground,
    /// The cube's face: its axis, and whether it is the positive one.
    Cube(usize, bool),
}

/// A cube that is turned in the world.
struct Cube {
    centre: DVec3,
    /// The cube's own axes in the world.
    axes: DMat3,
    half: f64,
}

impl Cube {
    /// Yaw around y, then pitch around x, then roll around z, each turning what the ones after it have turned.
    fn new(settings: &OccluderSettings) -> Self {
        let turn = settings.rotation.to_array().map(f64::to_radians);
        let axes = DMat3::from_rotation_y(turn[0]) * DMat3::from_rotation_x(turn[1]) * DMat3::from_rotation_z(turn[2]);
        Self { centre: settings.position.unwrap(), axes, half: 0.5 * settings.size }
    }

    /// Where the ray enters the cube, as a parameter of the ray, and through which face. An eye inside sees none.
    fn enter(&self, ray: &Ray) -> Option<(f64, Seen)> {
        let to_cube = self.axes.transpose();
        let (origin, direction) = (to_cube * (ray.origin - self.centre), to_cube * ray.direction);
        let (mut enter, mut leave, mut face) = (f64::NEG_INFINITY, f64::INFINITY, Seen::Sky);
        for axis in 0..3 {
            let a = (-self.half - origin[axis]) / direction[axis];
            let b = (self.half - origin[axis]) / direction[axis];
            if a.min(b) > enter {
                (enter, face) = (a.min(b), Seen::Cube(axis, direction[axis] < 0.0));
            }
            leave = leave.min(a.max(b));
        }
        (enter <= leave && enter > 0.0).then_some((enter, face))
    }
}

/// Ground and cube along a ray: distance in world units, infinite where there is none.
struct Along {
    ground: f64,
    cube: f64,
    face: Seen,
}

fn along(surface: &Surface<'_>, cube: &Cube, ray: &Ray) -> Along {
    let unit = ray.direction.length();
    let ground = surface.intersect(ray).map_or(f64::INFINITY, |hit| hit.depth * unit);
    let (cube, face) = cube.enter(ray).map_or((f64::INFINITY, Seen::Sky), |(depth, face)| (depth * unit, face));
    Along { ground, cube, face }
}

impl Along {
    fn seen(&self) -> (Seen, f64) {
        if self.cube < self.ground {
            (self.face, self.cube)
        } else if self.ground.is_finite() {
            (Seen::Ground, self.ground)
        } else {
            (Seen::Sky, f64::INFINITY)
        }
    }
}

/// The colours of the six faces without light, sRGB, from the shader's linear ones: +x, −x, +y, −y, +z, −z.
const FACES: [(Seen, [f64; 3]); 6] = [
    (Seen::Cube(0, true), [1.0, 0.18, 0.05]),
    (Seen::Cube(0, false), [0.05, 0.25, 0.9]),
    (Seen::Cube(1, true), [1.0, 0.75, 0.05]),
    (Seen::Cube(1, false), [0.6, 0.05, 0.75]),
    (Seen::Cube(2, true), [0.2, 0.85, 0.15]),
    (Seen::Cube(2, false), [0.05, 0.75, 0.75]),
];

/// The picture's background where there is no skybox, linear.
const BACKGROUND: [f64; 3] = [0.35, 0.42, 0.5];

fn srgb(linear: f64) -> f64 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    255.0 * encoded
}

/// What the picture shows at a pixel, told by its colour.
fn shown(picture: &RgbaImage, x: u32, y: u32) -> Seen {
    let pixel = picture.get_pixel(x, y).0;
    let is = |colour: [f64; 3]| (0..3).all(|channel| (f64::from(pixel[channel]) - srgb(colour[channel])).abs() < 1.5);
    if is(BACKGROUND) {
        return Seen::Sky;
    }
    FACES.iter().find(|(_, colour)| is(*colour)).map_or(Seen::Ground, |&(face, _)| face)
}

/// How many pixels show what.
#[derive(Debug, Default)]
struct Count {
    sky: usize,
    ground: usize,
    cube: usize,
    /// Pixels of the ground that the cube is behind.
    cube_hidden: usize,
    /// Pixels that differ inside the bands.
    excused: usize,
}

/// Asserts every pixel of the scene: its kind by colour, its distance by the probe.
fn check(renderer: &mut Renderer, scene: &Scene, name: &str) -> Count {
    let mut plain = scene.clone();
    plain.lighting.enabled = false;
    plain.diffuse.enabled = false;
    plain.skybox.enabled = false;
    let picture = picture(renderer, &plain);
    let probe = renderer.probe(&plain, SIZE).unwrap();
    let map = canyon();
    let surface = Surface::new(&map, map.box_size(None));
    let (cube, camera) = (Cube::new(&scene.occluder), scene.camera.unwrap());
    let pixels = SIZE[0] * SIZE[1];
    let verdicts: Vec<_> = (0..pixels)
        .into_par_iter()
        .map(|index| {
            let (x, y) = (index % SIZE[0], index / SIZE[0]);
            let at = |dx: f64, dy: f64| {
                along(&surface, &cube, &camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE))
            };
            let expected = at(0.0, 0.0);
            let (seen, distance) = expected.seen();
            let (actual, measured) = (shown(&picture, x, y), f64::from(probe.distance[index as usize]));
            let same_distance = distance == measured || (distance - measured).abs() < 1e-5;
            let right = seen == actual && same_distance;
            let beside = [(-BAND_PIXELS, 0.0), (BAND_PIXELS, 0.0), (0.0, -BAND_PIXELS), (0.0, BAND_PIXELS)];
            let excused = || {
                (expected.cube - expected.ground).abs() < SAME_DISTANCE
                    || beside.into_iter().any(|(dx, dy)| {
                        let (near, there) = at(dx, dy).seen();
                        near != seen || (there - distance).abs() > 0.01
                    })
            };
            (seen, expected.cube.is_finite(), right, right || excused(), actual, distance, measured)
        })
        .collect();
    let mut count = Count::default();
    for (index, (seen, cube_there, right, allowed, actual, distance, measured)) in verdicts.into_iter().enumerate() {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        assert!(allowed, "{name}: pixel {x}, {y} shows {actual:?} at {measured}, not {seen:?} at {distance}");
        count.excused += usize::from(!right);
        match seen {
            Seen::Sky => count.sky += 1,
            Seen::Ground => {
                count.ground += 1;
                count.cube_hidden += usize::from(cube_there);
            }
            Seen::Cube(..) => count.cube += 1,
        }
    }
    println!("{name:28} {count:?}");
    assert!(count.excused * 10_000 <= pixels as usize, "{name}: {} pixels are excused", count.excused);
    count
}

fn scene_with(camera: Camera, position: DVec3, size: f64, rotation: DVec3) -> Scene {
    let occluder = OccluderSettings { enabled: true, position: Some(position), size, rotation, spin: 0.0 };
    Scene { camera: Some(camera), occluder, ..Scene::default() }
}

/// A point over the ground at a share of the map, `above` world units high.
fn over_ground(u: f64, v: f64, above: f64) -> DVec3 {
    let map = canyon();
    let extent = map.box_size(None);
    DVec3::new(u * extent.x, map.surface_height(u, v) * extent.y + above, v * extent.z)
}

#[test]
fn half_behind_a_hill() {
    let map = canyon();
    let mut renderer = renderer(&map);
    for view in [NamedView::Start, NamedView::Graze, NamedView::Horizon, NamedView::Over] {
        let camera = scene_at(view, &map).camera.unwrap();
        let mut half_hidden = 0;
        for (u, v, rotation) in [
            (0.5, 0.5, DVec3::new(30.0, 20.0, 0.0)),
            (0.35, 0.3, DVec3::new(-70.0, 5.0, 45.0)),
            (0.7, 0.45, DVec3::ZERO),
        ] {
            let scene = scene_with(camera, over_ground(u, v, 0.0), 0.1, rotation);
            let count = check(&mut renderer, &scene, &format!("{} {u} {v}", view.name()));
            half_hidden += usize::from(count.cube > 20 && count.cube_hidden > 20);
        }
        assert!(half_hidden > 0, "{}: no cube is half behind a hill", view.name());
    }
}

#[test]
fn hidden_completely_and_in_front_completely() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let camera = scene_at(NamedView::Start, &map).camera.unwrap();
    let rotation = DVec3::new(12.0, 34.0, 56.0);
    let buried = check(&mut renderer, &scene_with(camera, over_ground(0.5, 0.5, -0.03), 0.02, rotation), "buried");
    assert!(buried.cube == 0 && buried.cube_hidden > 20);
    let near = camera.eye + camera.basis().forward * 0.1;
    let in_front = check(&mut renderer, &scene_with(camera, near, 0.03, rotation), "in front");
    assert!(in_front.cube > 1000 && in_front.cube_hidden == 0);
    let up = check(&mut renderer, &scene_with(camera, over_ground(0.4, 0.2, 0.3), 0.1, rotation), "before the sky");
    assert!(up.cube > 100 && up.cube_hidden == 0);
}

#[test]
fn from_inside_the_terrains_box_and_from_inside_the_cube() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let camera = scene_at(NamedView::Valley, &map).camera.unwrap();
    let ahead = camera.eye + camera.basis().forward * 0.06;
    let inside = check(&mut renderer, &scene_with(camera, ahead, 0.03, DVec3::new(40.0, 10.0, 5.0)), "in the box");
    assert!(inside.cube > 100);
    // Only outer faces are drawn: from inside the cube there is nothing of it.
    let within =
        check(&mut renderer, &scene_with(camera, camera.eye, 0.02, DVec3::new(40.0, 10.0, 5.0)), "in the cube");
    assert_eq!(within.cube, 0);
}
