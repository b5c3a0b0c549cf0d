//! The smooth surface against its f64 reference, pixel by pixel.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::pictures::{Difference, Tolerance, changed, share};
use common::{canyon, craters, fractal, picture, renderer, scene_at};
use glam::DVec3;
use relief::camera::{Camera, NamedView};
use relief::heightfield::reference::Surface;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField, HoleMask};
use relief::render::Renderer;
use relief::scene::{CraterMode, Scene, Technique};

/// Size of the pictures.
const SIZE: [u32; 2] = [160, 120];
/// What 99% of the pixels' distances may be off, and each, in cells.
const MOST_ERROR_CELLS: f64 = 2e-3;
/// Pictures of the same ground whose distances are rounded otherwise.
const ROUNDING: Tolerance = Tolerance { channel: 4, pixels: 0.002 };
/// A pixel whose ray passes the ground within this share of a pixel may be told either way.
const BAND_PIXELS: f64 = 1e-2;

fn smooth(scene: Scene) -> Scene {
    let mut scene = scene;
    scene.march.technique = Technique::Smooth;
    scene
}

/// Compares a probe of `scene` with the smooth surface of `field`: nothing missed or invented but in the band. Returns how
/// many pixels show ground, and how many are excused.
fn assert_met(name: &str, renderer: &mut Renderer, scene: &Scene, field: &HeightField) -> [usize; 2] {
    let probe = renderer.probe(scene, SIZE).unwrap();
    let extent = field.box_size(scene.terrain.height_scale);
    let surface = Surface::smooth(field, extent);
    let camera = scene.camera.unwrap();
    let expected = surface.distances(&camera, SIZE, &|_| {});
    let cell = extent.x / f64::from(field.cells()[0]);
    let (mut errors, mut wrong, mut excused) = (Vec::new(), Vec::new(), 0);
    for (pixel, (&found, &expected)) in probe.distance.iter().zip(&expected).enumerate() {
        let (x, y) = (pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]);
        let error = (f64::from(found) - expected).abs() / cell;
        let same = found.is_infinite() && expected.is_infinite() || error < 0.25;
        if !same {
            let silhouette = |by: f64| surface.is_tangent(&camera, x, y, SIZE, by);
            // A ray that grazes a hill meets it or what is behind: its neighbours do not agree either.
            let near = |dx: f64, dy: f64| {
                let ray = camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE);
                surface.intersect(&ray).map_or(f64::INFINITY, |hit| hit.depth * ray.direction.length())
            };
            let b = BAND_PIXELS;
            let around = [near(-b, 0.0), near(b, 0.0), near(0.0, -b), near(0.0, b)];
            let grazes = around.iter().any(|&other| (other - f64::from(found)).abs() < 0.25 * cell);
            if silhouette(b) || grazes { excused += 1 } else { wrong.push((x, y, found, expected)) }
        } else if found.is_finite() {
            errors.push(error);
        }
    }
    errors.sort_by(f64::total_cmp);
    let at =
        |share: f64| errors.get(((errors.len() as f64 * share) as usize).min(errors.len().saturating_sub(1))).copied();
    let (p50, p99, most) = (at(0.5).unwrap_or(0.0), at(0.99).unwrap_or(0.0), at(1.0).unwrap_or(0.0));
    println!(
        "{name:34} {:6} hits, {} wrong, {excused} excused, error in cells: p50 {p50:.1e}, p99 {p99:.1e}, max {most:.1e}, steps {:?}",
        errors.len(),
        wrong.len(),
        probe.step_stats(),
    );
    assert_eq!((wrong.len(), probe.cap_hits), (0, 0), "{name}: {:?}", &wrong[..wrong.len().min(5)]);
    assert!(p99 < MOST_ERROR_CELLS, "{name}: p99 {p99}");
    [errors.len(), excused]
}

#[test]
fn every_pixel_shows_the_smooth_surface() {
    let (mut hits, mut excused) = (0, 0);
    for (map_name, map) in [("canyon", canyon()), ("fractal", fractal())] {
        let mut renderer = renderer(&map);
        for view in [NamedView::Over, NamedView::Graze, NamedView::Horizon] {
            let scene = smooth(scene_at(view, &map));
            let [own, band] = assert_met(&format!("{map_name} {}", view.name()), &mut renderer, &scene, &map);
            (hits, excused) = (hits + own, excused + band);
        }
    }
    println!("{excused} of {hits} pixels are excused by the band of {BAND_PIXELS} pixels");
    assert!(excused * 4000 <= hits, "{excused} of {hits} pixels are excused");
}

/// Steep and thin ground, from near, from far, and along the samples' rows.
#[test]
fn stiff_ground_is_met_as_well() {
    let needles = |x: u32, z: u32| if x % 8 == 3 && z % 8 == 5 { 1.0f32 } else { 0.0 };
    let stairs = |x: u32, z: u32| ((x / 5 + z / 7) % 4) as f32;
    let of = |at: &dyn Fn(u32, u32) -> f32, w: u32, h: u32| {
        let raw: Vec<f32> = (0..h).flat_map(|z| (0..w).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
        Arc::new(HeightField::from_raw(w, h, &raw).unwrap())
    };
    for (name, map) in [("needles", of(&needles, 65, 65)), ("stairs", of(&stairs, 40, 33)), ("2×2", of(&stairs, 8, 8))]
    {
        let mut renderer = renderer(&map);
        let extent = map.box_size(Some(0.3));
        for (view, eye, target) in [
            ("above", [0.5, 3.0, 1.6], [0.5, 0.2, 0.5]),
            ("beside", [-0.3, 0.5, 0.2], [1.0, 0.4, 0.6]),
            ("inside", [0.5, 1.3, 0.5], [0.9, 0.2, 0.8]),
        ] {
            let camera = Camera::look_at(DVec3::from(eye) * extent, DVec3::from(target) * extent, 60.0);
            let mut scene = smooth(Scene { camera: Some(camera), ..Scene::default() });
            scene.terrain.height_scale = Some(0.3);
            assert_met(&format!("{name} {view}"), &mut renderer, &scene, &map);
        }
    }
}

#[test]
fn craters_and_a_compared_half_are_bounded_too() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let list = craters(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    // Made one after the other, so that the bounds are updated.
    for count in [2, list.len()] {
        edited.set_craters(&list[..count]);
        let mut scene = smooth(scene_at(NamedView::Over, &map));
        scene.craters.list = list[..count].to_vec();
        assert_met(&format!("{count} craters"), &mut renderer, &scene, edited.field());
    }
    let mut layered = smooth(scene_at(NamedView::Graze, &map));
    layered.craters.mode = CraterMode::Layered;
    layered.craters.layer_resolution = map.width();
    layered.craters.list = list.clone();
    let displaced = CraterLayer::rasterise(&list, &map, map.width()).apply_to(&map);
    assert_met("layered craters", &mut renderer, &layered, &displaced);
    // Beside the smooth half the exact one must stay what it is.
    let exact = scene_at(NamedView::Over, &map);
    let whole = picture(&mut renderer, &exact);
    let mut split = smooth(exact);
    split.compare.enabled = true;
    split.compare.technique = Technique::MaxMipmap;
    let halves = picture(&mut renderer, &split);
    // Its walk takes other steps over the higher pyramid, and rounds otherwise.
    let right = |picture: &image::RgbaImage| image::imageops::crop_imm(picture, 163, 0, 157, 240).to_image();
    assert!(
        Difference::of(&right(&whole), &right(&halves), ROUNDING).unwrap().is_within(ROUNDING),
        "the exact half is another"
    );
    let differs = changed(&whole, &halves);
    assert!(share(&differs) > 0.1, "the smooth half is another picture: {}", share(&differs));
}

#[test]
fn holes_are_refused() {
    let mut holes = HoleMask::new(5, 5);
    holes.insert(12);
    let map = Arc::new(HeightField::from_raw_with_holes(5, 5, &[0.0f64; 25], Some(holes)).unwrap());
    let scene = smooth(scene_at(NamedView::Over, &map));
    let error = renderer(&map).probe(&scene, [8, 8]).unwrap_err().to_string();
    assert!(error.contains("holes") && error.contains("--holes fill"), "{error}");
}
