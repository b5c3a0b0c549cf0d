//! Ground with invented detail against its f64 reference, pixel by pixel.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::pictures::{changed, share};
use common::{canyon, craters, fractal, picture, renderer, scene_at};
use glam::DVec3;
use relief::camera::{Camera, NamedView};
use relief::heightfield::fractal::Detail;
use relief::heightfield::reference::Surface;
use relief::heightfield::{EditedTerrain, HeightField, HoleMask};
use relief::render::Renderer;
use relief::scene::{CraterMode, Scene, Technique};

/// Size of the pictures.
const SIZE: [u32; 2] = [112, 84];
/// What 99% of the pixels' distances may be off, in widths of a pixel where they are. A ray has met the ground a hundredth of
/// a pixel above it, which along a grazing ray is more.
const MOST_ERROR_PIXELS: f64 = 0.25;
/// A pixel whose ray passes the ground within this share of a pixel may be told either way.
const BAND_PIXELS: f64 = 0.05;

fn detailed(scene: Scene) -> Scene {
    let mut scene = scene;
    scene.march.technique = Technique::Fractal;
    scene
}

/// An eye so many cells over the ground, where a cell is many pixels wide, looking over it.
fn near(map: &HeightField, [x, z]: [f64; 2], over: f64, pitch: f64) -> Scene {
    let extent = map.box_size(None);
    let ground = map.surface_height(x, z) * extent.y;
    let eye = DVec3::new(x * extent.x, ground + over * extent.x / f64::from(map.cells()[0]), z * extent.z);
    Scene { camera: Some(Camera { eye, yaw: 35.0, pitch, fov: 60.0 }), ..Scene::default() }
}

/// Compares a probe of `scene` with the detailed ground of `field`, whose detail is that of `base`: nothing missed or invented
/// but in the band. Returns how many pixels show ground, and how many are excused.
fn assert_met(name: &str, renderer: &mut Renderer, scene: &Scene, [base, field]: [&HeightField; 2]) -> [usize; 2] {
    let probe = renderer.probe(scene, SIZE).unwrap();
    let extent = field.box_size(scene.terrain.height_scale);
    let camera = scene.camera.unwrap();
    let pixel = camera.pixel_size(SIZE[1]);
    let surface = Surface::detailed(field, extent, Detail::of(base, scene.detail.strength), pixel);
    let expected = surface.distances(&camera, SIZE, &|_| {});
    let plain = Surface::new(field, extent).distances(&camera, SIZE, &|_| {});
    let (mut errors, mut wrong, mut excused, mut moved) = (Vec::new(), Vec::new(), 0, 0);
    for (index, (&found, &expected)) in probe.distance.iter().zip(&expected).enumerate() {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let width = pixel * f64::from(found).min(expected);
        let error = (f64::from(found) - expected).abs() / width;
        moved += usize::from((expected - plain[index]).abs() > 0.5 * width);
        let same = found.is_infinite() && expected.is_infinite() || error < 1.0;
        if same {
            errors.extend(found.is_finite().then_some(error));
            continue;
        }
        // A ray that grazes a hill meets it or what is behind: its neighbours do not agree either.
        let at = |dx: f64, dy: f64| {
            let ray = camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE);
            surface.intersect(&ray).map_or(f64::INFINITY, |hit| hit.depth * ray.direction.length())
        };
        let b = BAND_PIXELS;
        let around = [at(-b, 0.0), at(b, 0.0), at(0.0, -b), at(0.0, b)];
        // It lies among what is seen through the band: what a ray in it shows.
        let (low, high) = around.iter().fold((expected, expected), |(low, high), &at| (low.min(at), high.max(at)));
        let found = f64::from(found);
        if found >= low - width && found <= high + width { excused += 1 } else { wrong.push((x, y, found, expected)) }
    }
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() as f64 * share) as usize).min(errors.len() - 1)];
    println!(
        "{name:24} {:6} hits, {moved} moved by the detail, {} wrong, {excused} excused, error in pixels: p50 {:.1e}, p99 {:.1e}, max {:.1e}, steps {:?}",
        errors.len(),
        wrong.len(),
        at(0.5),
        at(0.99),
        at(1.0),
        probe.step_stats(),
    );
    assert_eq!((wrong.len(), probe.cap_hits), (0, 0), "{name}: {:?}", &wrong[..wrong.len().min(5)]);
    assert!(at(0.99) < MOST_ERROR_PIXELS, "{name}: p99 {}", at(0.99));
    [errors.len(), excused]
}

#[test]
fn every_pixel_shows_the_ground_with_its_detail() {
    let (mut hits, mut excused) = (0, 0);
    for (map_name, map) in [("canyon", canyon()), ("fractal", fractal())] {
        let mut renderer = renderer(&map);
        let scenes = [
            ("over", scene_at(NamedView::Over, &map)),
            ("graze", scene_at(NamedView::Graze, &map)),
            ("near", near(&map, [0.42, 0.57], 2.0, -20.0)),
            ("nearer", near(&map, [0.61, 0.33], 1.2, -8.0)),
            ("down", near(&map, [0.5, 0.5], 1.0, -89.0)),
        ];
        for (view, scene) in scenes {
            let name = format!("{map_name} {view}");
            let [own, band] = assert_met(&name, &mut renderer, &detailed(scene), [&map, &map]);
            (hits, excused) = (hits + own, excused + band);
        }
    }
    println!("{excused} of {hits} pixels are excused by the band of {BAND_PIXELS} pixels");
    assert!(excused * 200 <= hits, "{excused} of {hits} pixels are excused");
}

#[test]
fn craters_are_bounded_too_and_strength_counts() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let list = craters(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    // Made one after the other, so that the bounds are updated.
    for count in [2, list.len()] {
        edited.set_craters(&list[..count]);
        let mut scene = detailed(near(&map, [0.42, 0.57], 10.0, -30.0));
        scene.craters.list = list[..count].to_vec();
        assert_met(&format!("{count} craters"), &mut renderer, &scene, [&map, edited.field()]);
    }
    let mut scene = detailed(near(&map, [0.42, 0.57], 2.0, -20.0));
    scene.detail.strength = 2.5;
    assert_met("stronger", &mut renderer, &scene, [&map, &map]);
    let strong = picture(&mut renderer, &scene);
    scene.detail.strength = 1.0;
    let usual = picture(&mut renderer, &scene);
    scene.march.technique = Technique::MaxMipmap;
    let none = picture(&mut renderer, &scene);
    assert!(share(&changed(&usual, &none)) > 0.3 && share(&changed(&usual, &strong)) > 0.3);
    // Beside it the exact half stays what it is, and so does the strength's setting where nothing is invented.
    scene.detail.strength = 3.0;
    assert_eq!(share(&changed(&none, &picture(&mut renderer, &scene))), 0.0);
    // All that is far has none.
    let far = scene_at(NamedView::Over, &map);
    let exact = picture(&mut renderer, &far);
    let same = changed(&exact, &picture(&mut renderer, &detailed(far)));
    assert!(share(&same) < 0.35, "{}", share(&same));
}

#[test]
fn holes_and_layered_craters_are_refused() {
    let mut holes = HoleMask::new(5, 5);
    holes.insert(12);
    let map = Arc::new(HeightField::from_raw_with_holes(5, 5, &[0.0f64; 25], Some(holes)).unwrap());
    let scene = detailed(scene_at(NamedView::Over, &map));
    let error = renderer(&map).probe(&scene, [8, 8]).unwrap_err().to_string();
    assert!(error.contains("holes") && error.contains("--holes fill"), "{error}");
    let map = canyon();
    let mut scene = detailed(scene_at(NamedView::Over, &map));
    scene.craters.mode = CraterMode::Layered;
    scene.craters.list = craters(&map);
    let error = renderer(&map).probe(&scene, [8, 8]).unwrap_err().to_string();
    assert!(error.contains("layered") && error.contains("bake"), "{error}");
}
