//! The GPU against its twin on the CPU, pixel by pixel.
//!
//! `max-mipmap` is measured against the f64 reference of the library; `linear`, `linear-binary` and `secant`, which are
//! wrong on purpose, against the same sampling written down here in f64; `cone` and `relaxed-cone` by how their errors
//! against the reference fall. `cargo test --test twin -- --nocapture` prints the
//! figures.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;
#[path = "twin/cones.rs"]
mod cones;
#[path = "twin/crest.rs"]
mod crest;
#[path = "twin/deep.rs"]
mod deep;
#[path = "twin/random.rs"]
mod random;
#[path = "twin/sampling.rs"]
mod sampling;

use std::sync::Arc;

use common::{canyon, craters, fractal, renderer, scene_at};
use glam::DVec3;
use relief::camera::{Camera, NamedView};
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::reference::Surface;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField};
use relief::render::Renderer;
use relief::report::comparison::{self, BAND_PIXELS};
use relief::scene::{CraterMode, Scene};

/// At most one pixel in this many may be excused by the band.
const PIXELS_PER_EXCUSE: usize = 100_000;

/// Largest error of all but 1 % of the hits, in cells.
const MOST_ERROR_CELLS: f64 = 1e-3;

/// Size of the measured pictures.
const SIZE: [u32; 2] = [640, 400];

/// One picture against the reference, and how many of its walks were cut off.
#[derive(Debug)]
struct Comparison {
    figures: comparison::Comparison,
    cap_hits: u32,
}

impl std::ops::Deref for Comparison {
    type Target = comparison::Comparison;

    fn deref(&self) -> &comparison::Comparison {
        &self.figures
    }
}

impl Comparison {
    /// Compares the probe of `scene` with the first hits of `field`'s surface.
    fn of(renderer: &mut Renderer, scene: &Scene, field: &HeightField, size: [u32; 2]) -> Self {
        let extent = field.box_size(scene.terrain.height_scale);
        let probe = renderer.probe(scene, size).unwrap();
        let cell = extent.x / f64::from(field.cells()[0]);
        let surface = Surface::new(field, extent);
        let figures = comparison::Comparison::of(&surface, &scene.camera.unwrap(), size, &probe.distance, cell);
        Self { figures, cap_hits: probe.cap_hits }
    }

    fn print(&self, name: &str) {
        println!(
            "{name:34} {:7} pixels {:7} hits  missed {} invented {} astray {} tangent {}  error in cells: p50 {:.1e} p99 {:.1e} \
             max {:.1e}  cap hits {}",
            self.pixels,
            self.hits,
            self.missed,
            self.invented,
            self.astray,
            self.tangent,
            self.quantile(0.5),
            self.quantile(0.99),
            self.quantile(1.0),
            self.cap_hits,
        );
    }

    /// Nothing missed, nothing invented, no walk cut off.
    fn assert_hits(&self, name: &str) {
        self.print(name);
        let wrong = (self.missed, self.invented, self.astray, self.cap_hits);
        assert_eq!(wrong, (0, 0, 0, 0), "{name}: missed, invented, astray, cap hits");
    }

    /// All hits, and the error in cells.
    fn assert_exact(&self, name: &str) {
        self.assert_hits(name);
        assert!(self.hits > 0, "{name} shows no ground: nothing was compared");
        assert!(self.quantile(0.99) < MOST_ERROR_CELLS, "{name}: p99 {} cells", self.quantile(0.99));
    }
}

/// Asserts that the band excuses few enough pixels of all comparisons together.
fn assert_few_excuses(comparisons: &[Comparison]) {
    let pixels: usize = comparisons.iter().map(|comparison| comparison.pixels).sum();
    let excused: usize = comparisons.iter().map(|comparison| comparison.tangent).sum();
    println!("{excused} of {pixels} pixels differ inside the tangency band of {BAND_PIXELS} pixels");
    assert!(excused * PIXELS_PER_EXCUSE <= pixels, "{excused} of {pixels} pixels are excused by the tangency band");
}

/// The maps of the suite.
fn maps() -> [(&'static str, Arc<HeightField>); 2] {
    [("canyon", canyon()), ("fractal", fractal())]
}

#[test]
fn the_exact_technique_meets_the_reference_in_every_pixel() {
    let mut all = Vec::new();
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        for view in NamedView::MEASURED {
            let comparison = Comparison::of(&mut renderer, &scene_at(view, &map), &map, SIZE);
            comparison.assert_exact(&format!("{map_name} {}", view.name()));
            all.push(comparison);
        }
    }
    assert_few_excuses(&all);
}

#[test]
fn baked_craters_are_met_as_exactly() {
    let mut all = Vec::new();
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        let list = craters(&map);
        let mut edited = EditedTerrain::new(Arc::clone(&map));
        // One after the other, as they are made: each upload must leave the textures right.
        for count in [1, 4, list.len()] {
            edited.set_craters(&list[..count]);
            let views = if count == list.len() { &NamedView::MEASURED[..] } else { &[NamedView::Over][..] };
            for &view in views {
                let mut scene = scene_at(view, &map);
                scene.craters.list = list[..count].to_vec();
                let comparison = Comparison::of(&mut renderer, &scene, edited.field(), SIZE);
                comparison.assert_exact(&format!("{map_name} {} {count} craters", view.name()));
                all.push(comparison);
            }
        }
    }
    assert_few_excuses(&all);
}

#[test]
fn layered_craters_are_met_as_exactly() {
    let mut all = Vec::new();
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        for resolution in [map.width(), 300] {
            let list = craters(&map);
            let displaced = CraterLayer::rasterise(&list, &map, resolution).apply_to(&map);
            for view in [NamedView::Over, NamedView::Graze, NamedView::Horizon] {
                let mut scene = scene_at(view, &map);
                scene.craters.mode = CraterMode::Layered;
                scene.craters.layer_resolution = resolution;
                scene.craters.list.clone_from(&list);
                let comparison = Comparison::of(&mut renderer, &scene, &displaced, common::SIZE);
                comparison.assert_exact(&format!("{map_name} {} layer {resolution}", view.name()));
                all.push(comparison);
            }
        }
    }
    assert_few_excuses(&all);
}

/// The ground must not depend on how much of the box the march leaves out above it.
#[test]
fn the_whole_box_gives_the_same_ground() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let mut scene = scene_at(NamedView::Graze, &map);
    scene.march.lower_start = false;
    Comparison::of(&mut renderer, &scene, &map, common::SIZE).assert_exact("canyon graze, start at the lid");
}

#[test]
fn a_far_eye_sees_the_same_ground() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let extent = map.box_size(None);
    let middle = extent * DVec3::new(0.5, 0.3, 0.5);
    for (distance, direction) in [(1e3, DVec3::new(0.3, 0.4, 1.0)), (1e5, DVec3::new(-1.0, 0.1, 0.4)), (1e5, DVec3::Y)]
    {
        let fov = 2.0 * (0.55_f64 / distance).atan().to_degrees();
        let camera = Camera::look_at(middle + direction.normalize() * distance, middle, fov);
        let scene = Scene { camera: Some(camera), ..Scene::default() };
        let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
        comparison.assert_hits(&format!("canyon from {distance:e}"));
        assert!(comparison.hits > 1000, "the terrain is in the picture");
        // The distance itself is an f32: at 1e5 its last bit is 0.008.
        let last_bit = distance * f64::from(f32::EPSILON);
        let most = comparison.errors.last().unwrap();
        assert!(*most <= 2.0 * last_bit, "{most} is more than rounding ({last_bit})");
    }
}

#[test]
fn an_eye_in_the_ground_sees_ground_at_distance_zero() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let extent = map.box_size(None);
    let ground = map.surface_height(0.5, 0.5) * extent.y;
    let eye = DVec3::new(0.5 * extent.x, 0.5 * ground, 0.5 * extent.z);
    for (yaw, pitch) in [(0.0, 0.0), (123.0, 50.0), (0.0, -90.0)] {
        let scene = Scene { camera: Some(Camera { eye, yaw, pitch, fov: 70.0 }), ..Scene::default() };
        let probe = renderer.probe(&scene, common::SIZE).unwrap();
        assert!(probe.distance.iter().all(|&distance| distance == 0.0), "yaw {yaw}, pitch {pitch}");
        assert_eq!(probe.cap_hits, 0);
    }
}

/// Rays along a row or column of samples run in the walls between cells.
#[test]
fn rays_along_an_axis_on_an_exact_sample_row() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let extent = map.box_size(None);
    let [columns, rows] = map.cells().map(f64::from);
    // Odd, so that the middle pixel's ray is the camera's own direction.
    let size = [161, 121];
    for yaw in [0.0, 90.0, 180.0, 270.0] {
        for (height, pitch) in [(0.55, 0.0), (0.8, 0.0), (1.0, 0.0), (2.0, -90.0)] {
            let eye = DVec3::new(256.0 / columns, height, 256.0 / rows) * extent;
            let scene = Scene { camera: Some(Camera { eye, yaw, pitch, fov: 60.0 }), ..Scene::default() };
            let comparison = Comparison::of(&mut renderer, &scene, &map, size);
            comparison.assert_hits(&format!("canyon axis {yaw} from height {height}"));
            assert!(comparison.quantile(0.99) < MOST_ERROR_CELLS);
            assert_eq!(comparison.tangent, 0);
        }
        // From outside, in the plane of a side of the box and in that of a row of samples.
        let back = DVec3::new(-f64::sin(yaw.to_radians()), 0.0, f64::cos(yaw.to_radians()));
        for row in [0.0, 100.0, columns] {
            let eye = DVec3::new(row / columns, 0.6, row / rows) * extent + back * 1.5;
            let scene = Scene { camera: Some(Camera { eye, yaw, pitch: 0.0, fov: 60.0 }), ..Scene::default() };
            let comparison = Comparison::of(&mut renderer, &scene, &map, size);
            comparison.assert_hits(&format!("canyon axis {yaw} from outside, row {row}"));
            assert!(comparison.quantile(0.99) < MOST_ERROR_CELLS);
            // The rays of the middle column run in the box's own side: either answer is right for them.
            let in_a_side = if row == 100.0 { 0 } else { size[1] as usize };
            assert!(comparison.tangent <= in_a_side, "{} pixels are excused", comparison.tangent);
        }
    }
}

#[test]
fn maps_of_every_shape() {
    // Longer than the noise, the map goes there and back.
    let noise = generate(Kind::Ridged, 256, 5);
    let mirrored = |t: u32| if (t / 256).is_multiple_of(2) { t % 256 } else { 255 - t % 256 };
    for (width, height) in [(2, 2), (3, 2000), (2000, 3), (7, 5), (129, 65)] {
        let positions = (0..height).flat_map(|z| (0..width).map(move |x| (x, z)));
        let raw: Vec<f32> = positions.map(|(x, z)| noise.sample(mirrored(x), mirrored(z))).collect();
        let map = Arc::new(HeightField::from_raw(width, height, &raw).unwrap());
        let mut renderer = renderer(&map);
        for view in NamedView::MEASURED {
            let name = format!("{width}×{height} {}", view.name());
            let scene = scene_at(view, &map);
            let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
            comparison.assert_hits(&name);
            let most = comparison.quantile(0.99) * comparison.cell;
            assert!(most < 1e-5, "{name}: p99 is {most} of the box");
        }
    }
}

#[test]
fn height_scales_from_flat_to_a_thousand() {
    let map = canyon();
    let mut renderer = renderer(&map);
    for scale in [0.0, 1e-6, 1e3] {
        let extent = map.box_size(Some(scale));
        let middle = extent * 0.5;
        let from = |direction: DVec3, distance: f64| Camera::look_at(middle + direction * distance, middle, 60.0);
        let cameras = [
            from(DVec3::new(0.3, 0.8, 1.0), 1.2),
            from(DVec3::Y, 0.5 * scale + 1.0),
            from(DVec3::new(1.0, 0.05, 0.2), 2.0),
        ];
        for (index, camera) in cameras.into_iter().enumerate() {
            let mut scene = Scene { camera: Some(camera), ..Scene::default() };
            scene.terrain.height_scale = Some(scale);
            let name = format!("canyon {scale} high, camera {index}");
            let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
            comparison.assert_hits(&name);
            assert!(comparison.hits > 0, "{name} shows no ground");
            // f32 counts in steps of 6e-5 near 1000; relative to the box's size it is as exact as ever.
            let most = comparison.quantile(0.99) * comparison.cell / extent.max_element();
            assert!(most < 1e-6, "{name}: p99 is {most} of the box");
        }
    }
}

/// A flat map has no relief but still a ground.
#[test]
fn a_flat_map_is_a_floor() {
    let map = Arc::new(HeightField::from_raw(17, 17, &[3.0f32; 289]).unwrap());
    let mut renderer = renderer(&map);
    for view in [NamedView::Over, NamedView::Down] {
        let comparison = Comparison::of(&mut renderer, &scene_at(view, &map), &map, common::SIZE);
        comparison.assert_hits(&format!("flat {}", view.name()));
        assert!(comparison.hits > 0);
    }
}
