//! Holes of a map are holes in the picture: the GPU against the f64 reference, pixel by pixel, and what they cost.
//!
//! `cargo test --test holes -- --nocapture` prints the figures.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::{SIZE, craters, fractal, gpu, picture, renderer, scene_at, scene_from};
use glam::DVec3;
use relief::camera::{Camera, NamedView};
use relief::heightfield::reference::Surface;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField, HoleMask, Holes};
use relief::render::{Ledger, RenderError, Renderer};
use relief::report::comparison::Comparison;
use relief::scene::{CraterMode, HeightFilter, Scene, Technique};

/// Largest error of all but 1 % of the hits, in cells.
const MOST_ERROR_CELLS: f64 = 1e-3;

/// Most pixels of a picture that rounding may decide: a cut is as sharp as a silhouette.
const MOST_EXCUSED: usize = 12;

/// The same where cuts are seen edge-on: whole columns and rows of pixels look along them.
const MOST_EXCUSED_EDGE_ON: usize = (SIZE[0] + SIZE[1]) as usize;

fn noise(x: u32, z: u32, seed: u32) -> f64 {
    let mut bits = x.wrapping_mul(0x9e37_79b9) ^ z.wrapping_mul(0x85eb_ca6b) ^ seed;
    for _ in 0..3 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    f64::from(bits >> 8) / f64::from(1u32 << 24)
}

/// A map of heights and holes by column and row. What stands in holes is to be looked at by nobody.
fn map_of(
    [width, height]: [u32; 2],
    at: impl Fn(u32, u32) -> f64,
    hole: impl Fn(u32, u32) -> bool,
) -> Arc<HeightField> {
    let mut mask = HoleMask::new(width, height);
    let mut raw = Vec::new();
    for (index, (x, z)) in (0..height).flat_map(|z| (0..width).map(move |x| (x, z))).enumerate() {
        raw.push(if hole(x, z) { f64::NAN } else { at(x, z) });
        if hole(x, z) {
            mask.insert(index);
        }
    }
    Arc::new(HeightField::from_raw_with_holes(width, height, &raw, Some(mask)).unwrap())
}

/// Rolling hills with a little noise.
fn hills(x: u32, z: u32) -> f64 {
    let (u, v) = (f64::from(x) * 0.21, f64::from(z) * 0.17);
    u.sin() * v.cos() + 0.5 * (0.4 * u + v).sin() + 0.1 * noise(x, z, 3)
}

/// Holes of every shape.
fn maps() -> Vec<(&'static str, Arc<HeightField>)> {
    let (size, far) = ([65, 49], |x: u32, z: u32, i: f64, j: f64| (f64::from(x) - i).hypot(f64::from(z) - j));
    vec![
        ("some samples", map_of(size, hills, |x, z| noise(x, z, 7) < 0.03)),
        ("half of the samples", map_of(size, |x, z| noise(x, z, 5), |x, z| noise(x, z, 11) < 0.5)),
        ("whole numbers", map_of(size, |x, z| (noise(x, z, 5) * 9.0).floor(), |x, z| noise(x, z, 12) < 0.1)),
        ("all of 16 bits", map_of(size, |x, z| f64::from(x * 1023 + z % 48), |x, z| noise(x, z, 13) < 0.1)),
        ("round holes", map_of(size, hills, |x, z| far(x, z, 20.0, 20.0) < 9.5 || far(x, z, 45.0, 30.0) < 6.0)),
        ("a border", map_of(size, hills, |x, z| x < 9 || z > 44 || x == 64)),
        ("a row", map_of(size, hills, |_, z| z == 24)),
        ("a column", map_of(size, hills, |x, _| x == 33)),
        ("a frame", map_of(size, hills, |x, z| x.abs_diff(32).max(z.abs_diff(24)) == 12)),
        ("all but one cell", map_of(size, hills, |x, z| !(31..33).contains(&x) || !(20..22).contains(&z))),
        ("no cell", map_of(size, hills, |x, z| (x + z) % 2 == 0)),
        ("flat with holes", map_of([17, 17], |_, _| 3.0, |x, z| noise(x, z, 9) < 0.1)),
        ("one of four", map_of([2, 2], |x, z| f64::from(x + z), |x, z| x + z == 0)),
    ]
}

/// Views that a hole is hard in: from above, along the ground, from outside through the sides, from below through the
/// floor, from within a hole, and along rows and columns of samples.
fn views(map: &HeightField) -> Vec<(String, Camera)> {
    let extent = map.box_size(None);
    // Off the lattice: a ray through the very corner of four cells may take any of them.
    let aside = DVec3::new(0.003, 0.0, 0.0047) * extent;
    let measured = NamedView::MEASURED.map(|view| (view.name().to_owned(), view.camera(map, extent)));
    let mut views = measured.map(|(name, camera)| (name, Camera { eye: camera.eye + aside, ..camera })).to_vec();
    let shares = [
        ("through a side", [-0.4, 0.45, 0.3], [0.6, 0.3, 0.6]),
        ("low through a corner", [1.3, 0.2, 1.35], [0.3, 0.1, 0.3]),
        ("from below", [0.3, -1.5, 0.35], [0.55, 0.9, 0.6]),
        ("from below at a slant", [-0.3, -0.5, -0.3], [0.7, 0.9, 0.7]),
        ("straight up", [0.4, -3.0, 0.6], [0.4, 1.0, 0.6]),
        ("straight down", [0.4, 4.0, 0.6], [0.4, 0.0, 0.6]),
        ("out of a hole", [0.31, 0.12, 0.41], [0.9, 0.5, 0.7]),
        ("in a hole below the ground", [0.7, 0.02, 0.62], [0.1, 0.6, 0.1]),
        ("along a row", [-0.5, 0.5, 0.5], [1.0, 0.5, 0.5]),
        ("along a column", [0.5, 0.4, 1.6], [0.5, 0.4, 0.0]),
    ];
    let at = |share: [f64; 3]| DVec3::from(share) * extent;
    views.extend(shares.map(|(name, eye, target)| (name.to_owned(), Camera::look_at(at(eye), at(target), 60.0))));
    views
}

/// Compares a picture of `scene` with the first hits of `field`'s surface and asserts that nothing is missed or invented.
fn compare(renderer: &mut Renderer, scene: &Scene, field: &HeightField, name: &str) -> Comparison {
    let extent = field.box_size(scene.terrain.height_scale);
    let probe = renderer.probe(scene, SIZE).unwrap();
    let cell = extent.x / f64::from(field.cells()[0]);
    let compared = Comparison::of(&Surface::new(field, extent), &scene.camera.unwrap(), SIZE, &probe.distance, cell);
    println!(
        "{name:60} {:6} hits  missed {} invented {} astray {} tangent {}  p99 {:.1e} max {:.1e}  cap hits {}",
        compared.hits,
        compared.missed,
        compared.invented,
        compared.astray,
        compared.tangent,
        compared.quantile(0.99),
        compared.quantile(1.0),
        probe.cap_hits,
    );
    let wrong = (compared.missed, compared.invented, compared.astray, probe.cap_hits);
    assert_eq!(wrong, (0, 0, 0, 0), "{name}: missed, invented, astray, cap hits");
    let edge_on = ["down", "straight", "along"].iter().any(|word| name.contains(word));
    let most = if edge_on { MOST_EXCUSED_EDGE_ON } else { MOST_EXCUSED };
    assert!(compared.tangent <= most, "{name}: {} pixels are excused", compared.tangent);
    // f32 counts in steps of the box's size.
    let most = MOST_ERROR_CELLS * extent.y.max(1.0);
    assert!(compared.quantile(0.99) < most, "{name}: p99 {} cells", compared.quantile(0.99));
    compared
}

#[test]
fn the_exact_technique_sees_through_holes_as_the_reference_does() {
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        let (mut hits, mut pixels) = (0, 0);
        for (view, camera) in views(&map) {
            let scene = Scene { camera: Some(camera), ..Scene::default() };
            let compared = compare(&mut renderer, &scene, &map, &format!("{map_name}, {view}"));
            (hits, pixels) = (hits + compared.hits, pixels + compared.pixels);
        }
        // A map of nothing but holes is all sky; what has ground shows some, and not only that.
        assert_eq!(hits == 0, ["no cell", "one of four"].contains(&map_name), "{map_name}: {hits} hits");
        assert!(hits < pixels);
    }
}

#[test]
fn flat_and_steep_boxes_have_holes_too() {
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        for scale in [0.0, 1e-6, 30.0] {
            let extent = map.box_size(Some(scale));
            let eye = extent * DVec3::new(0.4, 1.0, 0.5) + DVec3::new(0.1, 0.9, 0.3);
            let below = extent * DVec3::new(0.4, 0.0, 0.5) + DVec3::new(0.1, -0.9, 0.3);
            for eye in [eye, below] {
                let mut scene = Scene { camera: Some(Camera::look_at(eye, extent * 0.5, 60.0)), ..Scene::default() };
                scene.terrain.height_scale = Some(scale);
                scene.march.lower_start = eye.y > 0.0;
                compare(&mut renderer, &scene, &map, &format!("{map_name}, {scale} high, from {}", eye.y));
            }
        }
    }
}

/// Round holes in a fractal, which a picture of a real map with lakes or clouds resembles.
fn cratered_fractal() -> Arc<HeightField> {
    let whole = fractal();
    let lakes = [(200.0, 300.0, 90.0), (520.0, 500.0, 140.0), (800.0, 760.0, 60.0), (40.0, 900.0, 120.0)];
    let hole = |x: u32, z: u32| lakes.iter().any(|&(i, j, r)| (f64::from(x) - i).hypot(f64::from(z) - j) < r);
    map_of([1024; 2], |x, z| f64::from(whole.sample(x, z)), hole)
}

#[test]
fn craters_beside_holes_are_met_as_exactly() {
    let map = cratered_fractal();
    let list = craters(&map);
    let mut renderer = renderer(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    for count in [0, 1, list.len(), 2, 0] {
        edited.set_craters(&list[..count]);
        for (mode, view) in [(CraterMode::Baked, NamedView::Over), (CraterMode::Layered, NamedView::Graze)] {
            let mut scene = scene_at(view, &map);
            (scene.craters.mode, scene.craters.list) = (mode, list[..count].to_vec());
            let name = format!("{count} craters, {mode:?}, {}", view.name());
            if mode == CraterMode::Layered && count > 0 {
                let layer = CraterLayer::rasterise(&list[..count], &map, scene.craters.layer_resolution);
                compare(&mut renderer, &scene, &layer.apply_to(&map), &name);
            } else {
                compare(&mut renderer, &scene, edited.field(), &name);
            }
        }
    }
}

/// Pixels far finer than f32 resolves the map, at the edge of a hole.
#[test]
fn deep_zooms_at_the_edge_of_a_hole_are_exact() {
    let map = map_of([65, 49], hills, |x, z| (24..40).contains(&x) && (20..30).contains(&z));
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let at = |column: f64, row: f64, height: f64| {
        DVec3::new(column / 64.0 * extent.x, height * extent.y, row / 48.0 * extent.z)
    };
    let rim = map.surface_height(23.0 / 64.0, 25.4 / 48.0);
    for (name, target) in [
        ("its rim", at(23.0, 25.4, rim)),
        ("its cut side", at(40.0, 25.4, 0.5 * map.surface_height(40.0 / 64.0, 25.4 / 48.0))),
        ("the floor's edge", at(40.0, 25.4, 0.0)),
        ("its corner", at(40.0, 30.0, 0.2)),
        ("the middle", at(31.0, 25.0, 0.3)),
    ] {
        for (number, from) in [DVec3::new(-0.6, 0.7, 0.1), DVec3::new(-0.4, 1.0, -0.5), DVec3::new(-0.3, -0.8, 0.2)]
            .into_iter()
            .enumerate()
        {
            for (distance, fov) in [(1.0, 1e-3), (2.0, 1e-6)] {
                let camera = Camera::look_at(target + from.normalize() * distance, target, fov);
                let eye = target - camera.basis().forward * distance;
                let scene = Scene { camera: Some(Camera { eye, ..camera }), ..Scene::default() };
                let probe = renderer.probe(&scene, SIZE).unwrap();
                let judged = relief::report::stress::judge(&map, extent, &scene.camera.unwrap(), &probe);
                println!("{name} {number} {fov:e}: {judged:?}");
                let wrong = [judged.missed, judged.invented, judged.astray, judged.nan, u64::from(probe.cap_hits)];
                assert_eq!(wrong, [0; 5], "{name} {number} {fov:e}: missed, invented, astray, NaN, cap hits");
                assert!(judged.tangent <= MOST_EXCUSED as u64, "{name} {number} {fov:e}: {judged:?}");
                picture(&mut renderer, &scene);
                assert!(["DEEP_ZOOM", "HOLES"].iter().all(|def| has_def(renderer.ledger(), def)));
            }
        }
    }
}

/// With many small steps each technique sees what the exact one does, but for thin slivers.
#[test]
fn every_technique_sees_through_holes() {
    let map = cratered_fractal();
    let mut renderer = renderer(&map);
    let exact_filters = [HeightFilter::Exact];
    let all_filters = [HeightFilter::Exact, HeightFilter::HardwareLinear, HeightFilter::Nearest];
    for view in [NamedView::Over, NamedView::Graze, NamedView::Down] {
        let scene = scene_at(view, &map);
        let exact = renderer.probe(&scene, SIZE).unwrap().distance;
        assert!(exact.iter().any(|distance| distance.is_infinite()) || view != NamedView::Down, "no hole is in view");
        for technique in Technique::ALL {
            for &filter in if technique.samples_uniformly() { &all_filters[..] } else { &exact_filters[..] } {
                let mut scene = scene.clone();
                (scene.march.technique, scene.march.filter) = (technique, filter);
                (scene.march.samples_min, scene.march.samples_max) = (2048, 2048);
                let probe = match renderer.probe(&scene, SIZE) {
                    Ok(probe) => probe,
                    // An adapter need not filter 32-bit floats.
                    Err(RenderError::Unsupported { .. }) if filter == HeightFilter::HardwareLinear => continue,
                    Err(error) => panic!("{} {technique:?} {filter:?}: {error}", view.name()),
                };
                let agrees = |(&a, &b): (&f32, &f32)| a == b || (a - b).abs() < 0.005;
                let agreeing = exact.iter().zip(&probe.distance).filter(|pair| agrees(*pair)).count();
                println!("{} {technique:?} {filter:?}: {agreeing} of {}", view.name(), exact.len());
                assert!(
                    1000 * agreeing >= 985 * exact.len(),
                    "{} {technique:?} {filter:?}: only {agreeing} of {} pixels agree",
                    view.name(),
                    exact.len()
                );
            }
        }
    }
}

fn has_def(ledger: &Ledger, def: &str) -> bool {
    ledger.shader_defs.iter().any(|name| name == def)
}

fn bytes(ledger: &Ledger, name: &str) -> (String, u64) {
    let texture = ledger.textures.iter().find(|texture| texture.name == name).unwrap();
    (texture.format.clone(), texture.bytes)
}

/// A map of whole numbers, whose heights fit 16 bits.
fn whole_numbers(hole: impl Fn(u32, u32) -> bool) -> Arc<HeightField> {
    map_of([64; 2], |x, z| (noise(x / 4, z / 4, 1) * 900.0).floor(), hole)
}

#[test]
fn only_a_map_with_holes_pays_for_them() {
    let whole = whole_numbers(|_, _| false);
    let holed = whole_numbers(|x, z| x.abs_diff(30).max(z.abs_diff(30)) < 8);
    let mut renderer = renderer(&whole);
    let mut ledger_of = |map: &Arc<HeightField>| {
        renderer.set_terrain(Arc::clone(map)).unwrap();
        picture(&mut renderer, &scene_at(NamedView::Over, map));
        renderer.ledger().clone()
    };
    let before = ledger_of(&whole);
    assert!(!has_def(&before, "HOLES"));
    let with = ledger_of(&holed);
    assert!(has_def(&with, "HOLES"));
    if gpu().capabilities.unorm16 {
        assert_eq!(bytes(&before, "heights").1, 2 * 64 * 64);
    }
    assert_eq!(bytes(&with, "heights").1, 4 * 64 * 64);
    // Filled, or let down to the floor, it is a map like any other.
    for policy in [Holes::Fill, Holes::Floor] {
        let solid = Arc::new((*holed).clone().with_hole_policy(policy));
        let ledger = ledger_of(&solid);
        assert!(!has_def(&ledger, "HOLES"), "{policy:?}");
        assert_eq!(bytes(&ledger, "heights"), bytes(&before, "heights"), "{policy:?}");
        assert_eq!(ledger.texture_bytes, before.texture_bytes, "{policy:?}");
    }
    // There and back: nothing of the holes stays.
    assert_eq!(ledger_of(&holed).textures, with.textures);
    assert_eq!(ledger_of(&whole).textures, before.textures);
}

/// Each policy shows something else in the hole, and the same ground around it.
#[test]
fn the_ground_around_a_hole_looks_the_same_whatever_becomes_of_it() {
    let holed = map_of([129; 2], hills, |x, z| (f64::from(x) - 60.0).hypot(f64::from(z) - 66.0) < 22.3);
    let filled = Arc::new((*holed).clone().with_hole_policy(Holes::Fill));
    let floored = Arc::new((*holed).clone().with_hole_policy(Holes::Floor));
    let mut renderer = renderer(&holed);
    let mut scene = scene_at(NamedView::Down, &holed);
    scene.lighting.enabled = false;
    scene.occluder.enabled = false;
    let mut shown = |map: &Arc<HeightField>| {
        renderer.set_terrain(Arc::clone(map)).unwrap();
        (renderer.probe(&scene, SIZE).unwrap().distance, picture(&mut renderer, &scene))
    };
    let [(cut, cut_picture), (full, full_picture), (low, _)] = [&holed, &filled, &floored].map(&mut shown);
    let sky = cut.iter().filter(|distance| distance.is_infinite()).count();
    let sky_of_filled = full.iter().filter(|distance| distance.is_infinite()).count();
    assert!(sky > sky_of_filled + 1000, "{sky} pixels of sky, {sky_of_filled} where the hole is filled");
    assert!(low.iter().zip(&cut).filter(|(low, cut)| low.is_finite() && cut.is_infinite()).count() > 1000);
    // Where both show the ground's surface it has the same colour, up to the very edge.
    let mut same = 0;
    for (index, (a, b)) in cut_picture.pixels().zip(full_picture.pixels()).enumerate() {
        if cut[index].is_finite() && (cut[index] - full[index]).abs() < 1e-5 {
            let most = (0..3).map(|channel| a.0[channel].abs_diff(b.0[channel])).max().unwrap();
            assert!(most <= 1, "pixel {index}: {a:?} and {b:?}");
            same += 1;
        }
    }
    assert!(same > 5000, "only {same} pixels were compared");
}

/// A hole in the middle of the picture, seen from an eye in front of it: sky is seen in it, and the cut side of the ground.
#[test]
fn the_cut_side_of_the_ground_is_lit_as_a_wall() {
    let map = map_of(
        [65; 2],
        |x, z| if x + z == 0 { 0.0 } else { 1.0 },
        |x, z| (20..45).contains(&x) && (20..45).contains(&z),
    );
    let mut renderer = renderer(&map);
    // Southwards down into the hole: at its southern side.
    let mut scene = scene_from(&map, [0.5, 1.6, 0.3], [0.5, 0.5, 45.0 / 64.0], 20.0);
    scene.debug.view = relief::scene::DebugView::Normals;
    let shown = picture(&mut renderer, &scene);
    let middle = shown.get_pixel(SIZE[0] / 2, SIZE[1] / 2).0;
    // The normal (0, 0, −1), as a colour: ½, ½, 0.
    assert!(middle[0].abs_diff(128) <= 2 && middle[1].abs_diff(128) <= 2 && middle[2] <= 2, "{middle:?}");
}
