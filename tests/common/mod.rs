//! What the tests with a driver share: the device, the maps, the scenes.
//!
//! `make test` sets `RELIEF_ADAPTER=cpu`, so that pictures come from Mesa's software driver on every machine.
#![expect(dead_code, reason = "every test binary uses its own part of this")]

pub(crate) mod pictures;

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use image::RgbaImage;
use relief::camera::{Camera, NamedView};
use relief::gpu::{Gpu, Target};
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::{Crater, HeightField, load};
use relief::render::{Probe, Renderer};
use relief::scene::Scene;

/// Size of the tests' pictures.
pub(crate) const SIZE: [u32; 2] = [320, 240];

/// The device of this test binary. Without a driver the test fails with the message that names the package.
pub(crate) fn gpu() -> Arc<Gpu> {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| {
        let gpu = Gpu::headless().unwrap_or_else(|error| panic!("these tests need a GPU driver: {error}"));
        // The library logs what the driver complains about; a test must not pass over it.
        gpu.device.on_uncaptured_error(Arc::new(|error| panic!("the GPU reported: {error}")));
        gpu
    });
    Arc::clone(gpu)
}

/// A renderer that has drawn nothing yet, over `map`.
pub(crate) fn renderer(map: &Arc<HeightField>) -> Renderer {
    let mut renderer = Renderer::new(gpu()).unwrap();
    renderer.set_terrain(Arc::clone(map)).unwrap();
    renderer
}

/// The Grand Canyon, 512×512.
pub(crate) fn canyon() -> Arc<HeightField> {
    static MAP: OnceLock<Arc<HeightField>> = OnceLock::new();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
    Arc::clone(MAP.get_or_init(|| Arc::new(load::load(&path).unwrap().field)))
}

/// A rough fractal, 1024×1024.
pub(crate) fn fractal() -> Arc<HeightField> {
    static MAP: OnceLock<Arc<HeightField>> = OnceLock::new();
    Arc::clone(MAP.get_or_init(|| Arc::new(generate(Kind::DiamondSquare, 1024, 1))))
}

/// The default scene from a named view, at the map's own proportion.
pub(crate) fn scene_at(view: NamedView, map: &HeightField) -> Scene {
    Scene { camera: Some(view.camera(map, map.box_size(None))), ..Scene::default() }
}

/// The default scene from `eye` to `target`, both as shares of the map's box.
pub(crate) fn scene_from(map: &HeightField, eye: [f64; 3], target: [f64; 3], fov: f64) -> Scene {
    let extent = map.box_size(None);
    let camera = Camera::look_at(DVec3::from(eye) * extent, DVec3::from(target) * extent, fov);
    Scene { camera: Some(camera), ..Scene::default() }
}

/// Draws a frame of [`SIZE`] and reads it back.
pub(crate) fn picture(renderer: &mut Renderer, scene: &Scene) -> RgbaImage {
    let gpu = gpu();
    let target = Target::new(&gpu, SIZE);
    renderer.draw(scene, &target).unwrap();
    target.read_color(&gpu).unwrap()
}

/// Probes at [`SIZE`].
pub(crate) fn probe(renderer: &mut Renderer, scene: &Scene) -> Probe {
    renderer.probe(scene, SIZE).unwrap()
}

/// Craters that overlap, reach over the map's edge, stand on a corner, and one of a single sample.
pub(crate) fn craters(map: &HeightField) -> Vec<Crater> {
    let extent = map.box_size(None);
    let crater = |u: f64, v: f64, radius, depth, rim| Crater { x: u * extent.x, z: v * extent.z, radius, depth, rim };
    vec![
        crater(0.45, 0.5, 0.12, 0.4, 0.1),
        crater(0.55, 0.55, 0.1, 0.5, 0.15),
        crater(0.5, 0.62, 0.03, 0.3, 0.05),
        crater(0.0, 0.4, 0.08, 0.6, 0.1),
        crater(1.0, 1.0, 0.15, 0.3, 0.2),
        crater(0.7, 0.2, 0.05, 2.0, 0.0),
        crater(0.25, 0.75, 0.7 / f64::from(map.cells()[0]), 0.2, 0.2),
    ]
}

/// A crater that takes the map's highest peak away.
pub(crate) fn crater_on_the_summit(map: &HeightField) -> Crater {
    let highest = map.samples().iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0 as u32;
    let extent = map.box_size(None);
    let [columns, rows] = map.cells().map(f64::from);
    let (column, row) = (highest % map.width(), highest / map.width());
    let (x, z) = (f64::from(column) / columns * extent.x, f64::from(row) / rows * extent.z);
    Crater { x, z, radius: 0.25, depth: 0.5, rim: 0.0 }
}

/// A file among the test's own, deleted with the folder that Cargo keeps for it.
pub(crate) fn scratch_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}
