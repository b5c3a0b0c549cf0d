//! The GPU against its twin on the CPU, pixel by pixel.
//!
//! `max-mipmap` is measured against the f64 reference of the library; `linear`, `linear-binary` and `secant`, which are
//! wrong on purpose, against the same sampling written down here in f64; `cone` and `relaxed-cone` by how their errors
//! against the reference fall. `cargo test --test twin -- --nocapture` prints the
//! figures.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;
#[path = "twin/crest.rs"]
mod crest;
#[path = "twin/deep.rs"]
mod deep;
#[path = "twin/random.rs"]
mod random;

use std::sync::Arc;

use common::{canyon, crater_on_the_summit, craters, fractal, renderer, scene_at};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use relief::camera::{Camera, NamedView};
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::reference::Surface;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField};
use relief::render::Renderer;
use relief::report::comparison::{self, BAND_PIXELS};
use relief::scene::{CraterMode, HeightFilter, MarchSettings, Scene, Technique};

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

/// The uniform sampling of the three classic techniques, as their papers describe it, in f64.
struct Sampling<'a> {
    field: &'a HeightField,
    extent: DVec3,
    /// The highest ground, normalised.
    highest: f32,
    march: &'a MarchSettings,
}

/// What sampling finds along one ray.
struct Sampled {
    /// Distance to the hit in world units.
    distance: Option<f64>,
    /// Distance between two samples, world units.
    step: f64,
    count: u32,
}

impl Sampling<'_> {
    fn height(&self, position: DVec3) -> f64 {
        let (u, v) = (position.x / self.extent.x, position.z / self.extent.z);
        let height = match self.march.filter {
            HeightFilter::Nearest => {
                let [columns, rows] = self.field.cells().map(f64::from);
                let nearest = |t: f64, cells: f64| (t.clamp(0.0, 1.0) * cells + 0.5).floor() as u32;
                f64::from(self.field.sample(nearest(u, columns), nearest(v, rows)))
            }
            HeightFilter::Exact | HeightFilter::HardwareLinear => self.field.surface_height(u, v),
        };
        height * self.extent.y
    }

    /// Where the ray is inside the box whose lid is at `top`.
    fn span(&self, origin: DVec3, direction: DVec3, top: f64) -> Option<DVec2> {
        let high = DVec3::new(self.extent.x, top, self.extent.z);
        let (a, b) = (-origin / direction, (high - origin) / direction);
        let (begin, end) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (begin <= end).then_some(DVec2::new(begin, end))
    }

    fn cast(&self, camera: &Camera, x: u32, y: u32, size: [u32; 2]) -> Option<Sampled> {
        let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, size);
        let direction = ray.direction.normalize();
        let top = if self.march.lower_start { f64::from(self.highest) } else { 1.0 } * self.extent.y;
        let span = self.span(ray.origin, direction, top)?;
        let [fewest, most] = [self.march.samples_min, self.march.samples_max].map(f64::from);
        let count = if self.march.steps_by_angle {
            (most + (fewest - most) * direction.y.abs()).round().max(1.0) as u32
        } else {
            self.march.samples_max.max(1)
        };
        let step = (span.y - span.x) / f64::from(count);
        let height_at = |distance: f64| {
            let position = ray.origin + direction * distance;
            position.y - self.height(position)
        };
        let below = |distance: f64| height_at(distance) <= 0.0;
        let first = (0..=count).find(|&index| below(span.x + step * f64::from(index)));
        let distance = first.map(|index| {
            let mut under = span.x + step * f64::from(index);
            let mut over = under - step;
            let halvings = if self.march.technique == Technique::LinearBinary { self.march.binary_steps } else { 0 };
            for _ in 0..if index > 0 { halvings } else { 0 } {
                let middle = 0.5 * (over + under);
                if below(middle) {
                    under = middle;
                } else {
                    over = middle;
                }
            }
            if self.march.technique == Technique::Secant && index > 0 {
                let (above, here) = (height_at(over), height_at(under));
                return over + step * above / (above - here);
            }
            under
        });
        Some(Sampled { distance, step, count })
    }
}

#[test]
fn the_sampling_techniques_sample_as_described() {
    let map = canyon();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let [linear, binary, secant] = [Technique::Linear, Technique::LinearBinary, Technique::Secant]
        .map(|technique| MarchSettings { technique, ..MarchSettings::default() });
    // Without its summit the map does not fill its box, and the lowered start shows.
    let summit = crater_on_the_summit(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    edited.set_craters(&[summit]);
    let highest = edited.field().samples().iter().copied().fold(0.0, f32::max);
    assert!(highest < 0.98, "the crater must lower the highest ground, not to {highest}");
    let cases = [
        ("linear", linear.clone()),
        ("linear-binary", binary.clone()),
        ("linear, few", MarchSettings { samples_min: 8, samples_max: 24, ..linear.clone() }),
        ("linear, fixed", MarchSettings { steps_by_angle: false, ..linear.clone() }),
        ("linear, from the lid", MarchSettings { lower_start: false, ..linear.clone() }),
        ("linear, nearest", MarchSettings { filter: HeightFilter::Nearest, ..linear.clone() }),
        ("linear, hardware", MarchSettings { filter: HeightFilter::HardwareLinear, ..linear }),
        ("linear-binary, 3 halvings", MarchSettings { binary_steps: 3, ..binary.clone() }),
        ("linear-binary, nearest", MarchSettings { filter: HeightFilter::Nearest, ..binary.clone() }),
        ("linear-binary, hardware", MarchSettings { filter: HeightFilter::HardwareLinear, ..binary }),
        ("secant", secant.clone()),
        ("secant, few", MarchSettings { samples_min: 8, samples_max: 24, ..secant.clone() }),
        ("secant, fixed", MarchSettings { steps_by_angle: false, ..secant.clone() }),
        ("secant, nearest", MarchSettings { filter: HeightFilter::Nearest, ..secant }),
    ];
    for (name, march) in cases {
        // The sampler's weights have 8 bits: near the surface it may decide for the sample before or after.
        let agreeing = if march.filter == HeightFilter::HardwareLinear { 0.98 } else { 0.998 };
        for view in [NamedView::Over, NamedView::Horizon] {
            let mut scene = scene_at(view, &map);
            scene.march = march.clone();
            scene.craters.list = vec![summit];
            let probe = renderer.probe(&scene, common::SIZE).unwrap();
            let sampling = Sampling { field: edited.field(), extent, highest, march: &scene.march };
            let camera = scene.camera.unwrap();
            let agrees = |index: usize| {
                let (x, y) = (index as u32 % common::SIZE[0], index as u32 / common::SIZE[0]);
                let actual = f64::from(probe.distance[index]);
                let Some(cast) = sampling.cast(&camera, x, y, common::SIZE) else {
                    return actual.is_infinite() && probe.steps[index] <= 1;
                };
                // Half a step apart would be another sample.
                match cast.distance {
                    Some(expected) => (actual - expected).abs() < 0.02 * cast.step + 2e-6,
                    None => actual.is_infinite() && probe.steps[index].abs_diff(cast.count + 1) <= 1,
                }
            };
            let pixels = probe.distance.len();
            let same = (0..pixels).into_par_iter().filter(|&index| agrees(index)).count();
            println!(
                "{name:26} {:8} {:.4} % of pixels as on the CPU",
                view.name(),
                100.0 * same as f64 / pixels as f64
            );
            assert!(same as f64 >= agreeing * pixels as f64, "{name} {}: only {same} of {pixels}", view.name());
        }
    }
}

const ALONG_CONES: [Technique; 2] = [Technique::Cone, Technique::RelaxedCone];

/// `scene` with a technique and a fixed number of samples.
fn sampled(technique: Technique, samples: u32, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.march.technique = technique;
    (scene.march.samples_min, scene.march.samples_max) = (samples, samples);
    scene
}

#[test]
fn techniques_along_cones_err_less_the_more_steps_they_may_take() {
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        for technique in ALONG_CONES {
            for view in NamedView::MEASURED {
                let scene = scene_at(view, &map);
                let mut measured = |technique: Technique, samples: u32| {
                    let scene = sampled(technique, samples, &scene);
                    let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
                    comparison.print(&format!("{map_name} {} {} {samples}", view.name(), technique.name()));
                    comparison
                };
                let [few, some, many] = [16, 128, 1024].map(|samples| measured(technique, samples));
                let name = format!("{map_name} {} {}", view.name(), technique.name());
                assert!(many.hits > 0, "{name}: nothing was compared");
                for comparison in [&few, &some, &many] {
                    // Only a step into the ground ends a ray.
                    assert_eq!((comparison.invented, comparison.cap_hits), (0, 0), "{name}");
                }
                assert!(few.missed >= some.missed && some.missed >= many.missed, "{name}: ground missed");
                assert!(1000 * many.missed <= many.hits, "{name}: {} of {} missed", many.missed, many.hits);
                for share in [0.5, 0.99] {
                    let [few, some, many] = [&few, &some, &many].map(|comparison| comparison.quantile(share));
                    assert!(few > some && some >= many, "{name}: {few}, {some}, {many} cells at {share}");
                }
                assert!(many.quantile(0.99) < 0.05, "{name}: p99 {} cells", many.quantile(0.99));
                // What the cones are for: steps are saved where nothing is.
                let mut steps = |technique| {
                    let probe = renderer.probe(&sampled(technique, 1024, &scene), common::SIZE).unwrap();
                    probe.steps.iter().map(|&steps| u64::from(steps)).sum::<u64>()
                };
                let (along, uniform) = (steps(technique), steps(Technique::LinearBinary));
                assert!(4 * along < uniform, "{name}: {along} steps, uniformly {uniform}");
            }
        }
    }
}

#[test]
fn on_a_smooth_map_few_pixels_are_wrong_along_cones() {
    let wave = |index: u32| (f64::from(index % 256) * 0.05).sin() * (f64::from(index / 256) * 0.04).cos();
    let raw: Vec<f64> = (0..256 * 256).map(wave).collect();
    let map = Arc::new(HeightField::from_raw(256, 256, &raw).unwrap());
    let mut renderer = renderer(&map);
    for (technique, view) in ALONG_CONES.into_iter().flat_map(|technique| NamedView::MEASURED.map(|v| (technique, v))) {
        let scene = sampled(technique, 256, &scene_at(view, &map));
        let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
        let name = format!("smooth {} {}", view.name(), technique.name());
        comparison.print(&name);
        assert!(comparison.hits > 0 && comparison.invented == 0, "{name}");
        assert!(2000 * comparison.missed <= comparison.hits, "{name}: {} missed", comparison.missed);
        // The last step along relaxed cones is as long as the cone, here up to a third of the map; 8 halvings of it are left.
        let most = if technique == Technique::Cone { 0.01 } else { 0.3 };
        assert!(comparison.quantile(0.99) < most, "{name}: p99 {} cells", comparison.quantile(0.99));
    }
}

/// A crater changes cones everywhere: with those of the ground before it rays would fly through its rim, or creep.
#[test]
fn cones_follow_the_craters() {
    let map = canyon();
    let list = craters(&map);
    for (technique, mode) in
        ALONG_CONES.into_iter().flat_map(|technique| [CraterMode::Baked, CraterMode::Layered].map(|m| (technique, m)))
    {
        let mut renderer = renderer(&map);
        let mut scene = sampled(technique, 512, &scene_at(NamedView::Graze, &map));
        scene.craters.mode = mode;
        renderer.probe(&scene, common::SIZE).unwrap();
        for count in [1, list.len(), 0, 2] {
            scene.craters.list = list[..count].to_vec();
            let edited = renderer.probe(&scene, common::SIZE).unwrap();
            let mut fresh = Renderer::new(common::gpu()).unwrap();
            fresh.set_terrain(Arc::clone(&map)).unwrap();
            let fresh = fresh.probe(&scene, common::SIZE).unwrap();
            assert!(
                edited.distance == fresh.distance && edited.steps == fresh.steps,
                "{technique:?}, {mode:?}, {count}"
            );
        }
        let displaced = match mode {
            CraterMode::Layered => {
                CraterLayer::rasterise(&scene.craters.list, &map, scene.craters.layer_resolution).apply_to(&map)
            }
            CraterMode::Baked => {
                let mut edited = EditedTerrain::new(Arc::clone(&map));
                edited.set_craters(&scene.craters.list);
                edited.field().clone()
            }
        };
        let comparison = Comparison::of(&mut renderer, &scene, &displaced, common::SIZE);
        comparison.print(&format!("{technique:?} {mode:?}"));
        assert!(comparison.invented == 0 && 1000 * comparison.missed <= comparison.hits);
        assert!(comparison.quantile(0.95) < 0.05, "{technique:?} {mode:?}: {}", comparison.quantile(0.95));
    }
}
