//! Beams, and the box that rays are cast in: none of them may hide ground.

use glam::{DVec2, DVec3, DVec4};

use super::cube::{clip_corners, in_view};
use super::*;
use crate::camera::{Camera, NamedView};

/// Heights between 0 and 1 that look nowhere alike.
fn noise(x: u32, z: u32) -> f32 {
    let mut bits = (x.wrapping_mul(0x9e37_79b9)) ^ z.wrapping_mul(0x85eb_ca6b);
    for _ in 0..3 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    (bits >> 8) as f32 / (1u32 << 24) as f32
}

fn map_of(width: u32, height: u32, at: impl Fn(u32, u32) -> f32) -> Arc<HeightField> {
    let raw: Vec<f32> = (0..height).flat_map(|z| (0..width).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
    Arc::new(HeightField::from_raw(width, height, &raw).unwrap())
}

/// Eyes above, beside, in, below and far from a box of the size `extent`, looking along and across it.
fn hard_views(extent: DVec3) -> Vec<Camera> {
    let look = |eye: [f64; 3], target: [f64; 3], fov| {
        Camera::look_at(DVec3::from(eye) * extent, DVec3::from(target) * extent, fov)
    };
    vec![
        look([0.5, 1.4, 1.9], [0.5, 0.3, 0.4], 60.0),
        look([-0.4, 1.02, -0.3], [0.6, 0.9, 0.7], 50.0),
        look([-0.3, 0.5, 0.02], [1.0, 0.45, 0.05], 70.0),
        look([1.6, 0.3, 0.5], [0.0, 0.3, 0.5], 40.0),
        look([0.5, 0.98, 0.5], [0.1, 0.7, 0.9], 100.0),
        look([0.02, 0.6, 0.98], [0.9, 0.5, 0.1], 80.0),
        look([0.5, 2.5, 0.5001], [0.5, 0.0, 0.5], 60.0),
        look([0.4, -0.8, 0.6], [0.6, 0.4, 0.4], 60.0),
        look([0.5, 0.05, 0.5], [0.9, 0.4, 0.6], 70.0),
        look([300.0, 200.0, 500.0], [0.5, 0.5, 0.5], 0.15),
        look([0.5, 60.0, 30.0], [0.5, 0.5, 0.5], 12.0),
        look([1.3, 1.2, 1.5], [0.45, 0.2, 0.4], 0.01),
        look([-0.5, 0.9, 0.5], [0.7, 0.45, 0.5], 0.001),
    ]
}

/// A beam must stop before every ray of its tile does: with and without beams, every pixel shows the same.
#[test]
fn beams_hide_nothing() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let needles = |every: u32| move |x: u32, z: u32| if x % every == 3 && z % every == 5 { 1.0 } else { 0.0 };
    let maps = [
        ("2×2", map_of(2, 2, noise)),
        ("3×2", map_of(3, 2, noise)),
        ("5×9", map_of(5, 9, noise)),
        ("33×17", map_of(33, 17, noise)),
        ("65×130", map_of(65, 130, noise)),
        ("3×400", map_of(3, 400, noise)),
        ("needles", map_of(130, 130, needles(8))),
        ("few needles", map_of(257, 257, needles(64))),
        ("walls", map_of(129, 65, |x, z| if x == 40 || z == 64 || x == 128 { 1.0 } else { 0.01 * noise(x, z) })),
        ("rim", map_of(100, 100, |x, z| if x % 99 == 0 || z % 99 == 0 { 1.0 } else { 0.0 })),
    ];
    let (mut hits, mut saved) = (0, 0i64);
    for (name, map) in maps {
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        for scale in [0.05, 0.3, 2.0] {
            let extent = map.box_size(Some(scale));
            for (index, camera) in hard_views(extent).into_iter().enumerate() {
                let size = [[33, 17], [160, 100], [101, 64]][index % 3];
                let mut scene = Scene { camera: Some(camera), ..Scene::default() };
                scene.terrain.height_scale = Some(scale);
                let mut probe = |whole_rays| {
                    renderer.whole_rays = whole_rays;
                    renderer.probe(&scene, size).unwrap()
                };
                let (whole, beams) = (probe(true), probe(false));
                assert_eq!((whole.cap_hits, beams.cap_hits), (0, 0));
                // The distance is an f32; where the eye is far off its last bit is what may differ.
                let cell = extent.x.max(extent.z) / f64::from(map.width().max(map.height()));
                for (pixel, (&expected, &actual)) in whole.distance.iter().zip(&beams.distance).enumerate() {
                    let tolerance = (1e-4 * cell) as f32 + 4.0 * f32::EPSILON * expected.min(1e6);
                    let same = expected == actual || (expected - actual).abs() <= tolerance;
                    assert!(same, "{name}, {scale} high, view {index}, pixel {pixel}: {actual}, not {expected}");
                }
                hits += whole.distance.iter().filter(|distance| distance.is_finite()).count();
                let sum = |probe: &Probe| probe.steps.iter().map(|&steps| i64::from(steps)).sum::<i64>();
                saved += sum(&whole) - sum(&beams);
            }
        }
    }
    assert!(hits > 300_000, "only {hits} pixels show ground");
    assert!(saved > hits as i64, "beams save only {saved} steps for {hits} hits");
}

/// One cell has one patch, four texels; the beams' few are shared by their tiles.
#[test]
fn texel_reads_are_those_of_nodes_cells_and_beams() {
    let mut renderer = Renderer::new(Gpu::headless().unwrap()).unwrap();
    let size = [64, 48];
    let mut scene = Scene::default();
    let mut count = |map: Arc<HeightField>| {
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        scene.camera = Some(NamedView::Down.camera(&map, map.box_size(None)));
        let probe = renderer.probe(&scene, size).unwrap();
        let reads = renderer.texel_reads(&scene, size).unwrap();
        assert_eq!(renderer.probe(&scene, size).unwrap().steps, probe.steps, "counting leaves nothing behind");
        let hits = probe.distance.iter().map(|distance| distance.is_finite());
        let hits: Vec<_> =
            hits.zip(probe.steps).zip(reads).filter(|((hit, _), _)| *hit).map(|(pair, r)| (pair.1, r)).collect();
        assert!(hits.len() > 1000, "{}", hits.len());
        hits
    };
    for (steps, reads) in count(map_of(2, 2, |x, _| x as f32)) {
        // A cell, and the node above it where the ray starts there; the beam's texel and at most three of its own.
        assert!(steps <= 2, "{steps}");
        assert!((steps + 4..steps + 8).contains(&reads), "{steps} steps, {reads} texels");
    }
    for (steps, reads) in count(map_of(65, 65, noise)) {
        assert!(reads >= steps + 3 && reads <= 4 * steps + 40, "{steps} steps, {reads} texels");
    }
}

/// A rasteriser may move a corner by a sixteenth of a pixel, from however far the box is seen; what then lies outside of
/// it is not drawn, though its ray may meet the terrain.
#[test]
fn the_drawn_box_is_an_eighth_of_a_pixel_wider_than_the_terrains() {
    let size = [64, 48];
    let in_pixels = |corner: &DVec4| DVec2::new(corner.x / corner.w * 32.0, corner.y / corner.w * 24.0);
    let farthest = |corners: &[DVec4; 8], along: DVec2| {
        corners.iter().map(|corner| in_pixels(corner).dot(along)).fold(f64::NEG_INFINITY, f64::max)
    };
    let mut seen = 0;
    for index in 0..3000u32 {
        let number =
            |stream: u32| f64::from((index * 8 + stream).wrapping_mul(0x9e37_79b1) >> 8) / f64::from(1u32 << 24);
        let extent = DVec3::new(1.0, 0.01 + number(0), 0.05 + 0.95 * number(1));
        let away = DVec3::new(number(2) - 0.5, number(3) - 0.5, number(4) - 0.5).normalize_or(DVec3::X);
        let distance = 2.0 * 10f64.powf(5.0 * number(5));
        let camera = Camera::look_at(extent * 0.5 + away * distance, extent * 0.5, 1.0 + 99.0 * number(6));
        let world_from_cube = glam::DMat4::from_scale(extent);
        let (plain, drawn) =
            (clip_corners(camera.clip_from_world(size), world_from_cube), terrain::drawn_box(&camera, size, extent));
        assert!(in_view(&plain) && in_view(&drawn));
        for angle in 0..64 {
            let along = DVec2::from_angle(f64::from(angle) * std::f64::consts::TAU / 64.0);
            let wider = farthest(&drawn, along) - farthest(&plain, along);
            assert!(wider >= 0.125, "{wider} pixels at {along}, {camera:?}, {extent}");
            seen += 1;
        }
    }
    assert_eq!(seen, 3000 * 64);
}
