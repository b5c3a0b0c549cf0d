//! Deep zooms: pixels finer than f32 counts the box in, against the twin.

use std::sync::Arc;

use relief::camera::Camera;
use relief::heightfield::reference::Surface;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField};
use relief::render::{Probe, Renderer};
use relief::report::stress::{self, Judgement};
use relief::scene::{CraterMode, Scene, Technique};

use super::DVec3;
use super::common::{canyon, craters, fractal, picture, renderer};

/// Size of the pictures.
const SIZE: [u32; 2] = [96, 72];

/// Most pixels of one that the tangency band may excuse.
const MOST_EXCUSED: u64 = 10;

/// Eyes as seen from the ground: directions, and distances in box lengths.
const FROM: [DVec3; 3] = [DVec3::new(0.5, 0.45, 1.0), DVec3::new(-1.0, 0.7, 0.3), DVec3::new(0.05, 1.0, -0.1)];

/// A camera `distance` away from the ground at the share (u, v) of `map`, with a field of view of so many degrees.
fn camera_at(map: &HeightField, extent: DVec3, [u, v]: [f64; 2], from: DVec3, distance: f64, fov: f64) -> Camera {
    let target = DVec3::new(u * extent.x, map.surface_height(u, v) * extent.y, v * extent.z);
    let camera = Camera::look_at(target + from.normalize() * distance, target, fov);
    // Degrees of an angle are coarser than such a picture: the eye is moved until it looks at the target exactly.
    Camera { eye: target - camera.basis().forward * distance, ..camera }
}

/// A picture of a deep zoom beside the twin's.
struct Zoom {
    judged: Judgement,
    /// Errors of the view depths in widths of a pixel at that depth, sorted.
    errors: Vec<f64>,
    /// Share of the pixels that have the same depth as their right neighbour, although the twin's differ.
    stairs: f64,
    /// Bound of the displacement in widths of a pixel.
    bound: f64,
}

impl Zoom {
    fn of(renderer: &mut Renderer, scene: &Scene, map: &HeightField) -> Self {
        let camera = scene.camera.unwrap();
        let extent = map.box_size(scene.terrain.height_scale);
        let probe = renderer.probe(scene, SIZE).unwrap();
        assert_eq!(probe.cap_hits, 0);
        let judged = stress::judge(map, extent, &camera, &probe);
        let exact = Surface::new(map, extent).distances(&camera, SIZE, &|_| {});
        let exact: Vec<f64> = exact
            .iter()
            .enumerate()
            .map(|(index, distance)| {
                let [x, y] = [index as u32 % SIZE[0], index as u32 / SIZE[0]].map(|at| f64::from(at) + 0.5);
                distance / camera.ray(x, y, SIZE).direction.length()
            })
            .collect();
        let pixel = camera.pixel_size(SIZE[1]);
        let mut errors: Vec<f64> = (0..exact.len())
            .filter(|&index| exact[index].is_finite())
            .filter_map(|index| Some((probe.view_depth(index)? - exact[index]).abs() / (pixel * exact[index])))
            .collect();
        errors.sort_by(f64::total_cmp);
        let middle = exact[exact.len() / 2 + SIZE[0] as usize / 2];
        let bound = judged.bound * extent.max_element() / (pixel * middle);
        Self { judged, errors, stairs: stairs(&probe, &exact, pixel), bound }
    }

    fn quantile(&self, share: f64) -> f64 {
        self.errors[((self.errors.len() - 1) as f64 * share) as usize]
    }

    fn assert_exact(&self, name: &str) {
        let Judgement { pixels, hits, missed, invented, astray, nan, tangent, ratio, .. } = self.judged;
        println!(
            "{name:40} {hits:6} of {pixels} hits  missed {missed} invented {invented} astray {astray} tangent {tangent}  \
             error in pixels: p50 {:.1e} p99 {:.1e} max {:.1e}  stairs {:.4}  bound {:.1e} pixels, {ratio:.3} of it",
            self.quantile(0.5),
            self.quantile(0.99),
            self.quantile(1.0),
            self.stairs,
            self.bound,
        );
        assert_eq!([missed, invented, astray, nan], [0; 4], "{name}: missed, invented, astray, NaN");
        assert!(tangent <= MOST_EXCUSED, "{name}: {tangent} pixels are excused");
        assert!(self.stairs < 0.01, "{name}: {} of the pixels are stairs", self.stairs);
        assert!(hits > pixels / 4, "{name} shows little ground");
    }
}

/// Share of the pixels that have the same depth as their right neighbour, although the twin's differ.
fn stairs(probe: &Probe, exact: &[f64], pixel: f64) -> f64 {
    let least = (1e-3 * pixel).max(1e-14);
    let neighbours = (0..exact.len() - 1).filter(|index| (index + 1) % SIZE[0] as usize != 0);
    let differing: Vec<usize> = neighbours
        .filter(|&index| exact[index].is_finite() && exact[index + 1].is_finite())
        // As far apart as a thousandth of a pixel, and as f64 is sure of.
        .filter(|&index| (exact[index] - exact[index + 1]).abs() > least * exact[index])
        .collect();
    let same = differing.iter().filter(|&&index| probe.view_depth(index) == probe.view_depth(index + 1)).count();
    same as f64 / differing.len().max(1) as f64
}

fn noise() -> Arc<HeightField> {
    let hash = |index: u32| {
        let mut bits = index.wrapping_mul(0x9e37_79b9) ^ 0x51ed_270b;
        for _ in 0..3 {
            bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
        }
        f64::from(bits >> 8)
    };
    let raw: Vec<f64> = (0..257 * 257).map(hash).collect();
    Arc::new(HeightField::from_raw(257, 257, &raw).unwrap())
}

/// Maps of floats and of 16 bits, smooth and stiff.
fn maps() -> [(&'static str, Arc<HeightField>); 4] {
    let checkerboard: Vec<f64> = (0..129 * 129).map(|index| f64::from((index / 129 + index % 129) % 2)).collect();
    [
        ("fractal", fractal()),
        ("canyon", canyon()),
        ("noise", noise()),
        ("checkerboard", Arc::new(HeightField::from_raw(129, 129, &checkerboard).unwrap())),
    ]
}

/// Near and far, from the first field of view that is deep to the smallest whose pixels f64 still tells apart.
const ZOOMS: [(f64, f64); 5] = [(1.0, 1e-2), (1.0, 1e-3), (0.3, 1e-6), (3.0, 1e-6), (1e6, 1e-9)];

#[test]
fn deep_zooms_have_no_stairs() {
    for (name, map) in maps() {
        let extent = map.box_size(None);
        let mut renderer = renderer(&map);
        for (distance, fov) in ZOOMS {
            for (number, from) in FROM.into_iter().enumerate() {
                let camera = camera_at(&map, extent, [0.4137, 0.5731], from, distance, fov);
                let scene = Scene { camera: Some(camera), ..Scene::default() };
                let zoom = Zoom::of(&mut renderer, &scene, &map);
                zoom.assert_exact(&format!("{name} {fov:e}° from {distance:e}, {number}"));
            }
        }
    }
}

/// Where a deep zoom may look, and what is special there.
fn places(map: &HeightField, extent: DVec3) -> Vec<(&'static str, DVec3)> {
    let [columns, rows] = map.cells();
    let (i, j) = (columns / 3, rows / 2);
    let place = |u: f64, v: f64| DVec3::new(u * extent.x, map.surface_height(u, v) * extent.y, v * extent.z);
    let share = |at: f64, of: u32| at / f64::from(of);
    let highest = map.samples().iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0 as u32;
    let (column, row) = (highest % map.width(), highest / map.width());
    vec![
        ("a sample", place(share(f64::from(i), columns), share(f64::from(j), rows))),
        ("a wall between cells", place(share(f64::from(i), columns), share(f64::from(j) + 0.3, rows))),
        ("the highest sample", place(share(f64::from(column), columns), share(f64::from(row), rows))),
        ("the border", place(0.5, 1.0)),
        ("a side of the box", place(0.4, 1.0) * DVec3::new(1.0, 0.4, 1.0)),
        ("a corner of the map", place(1.0, 0.0)),
        ("the floor's edge", DVec3::new(0.3 * extent.x, 0.0, extent.z)),
    ]
}

/// Silhouettes, creases and the box's own edges in the middle of the picture.
#[test]
fn deep_zooms_at_edges_are_exact() {
    let directions = [DVec3::new(0.3, 0.35, 1.0), DVec3::new(0.45, 0.02, 1.0), DVec3::new(0.0, 0.3, 1.0), DVec3::Y];
    for (name, map) in maps() {
        let extent = map.box_size(None);
        let mut renderer = renderer(&map);
        let (mut hits, mut largest) = (0, 0.0f64);
        for (what, target) in places(&map, extent) {
            for (number, from) in directions.into_iter().enumerate() {
                for (distance, fov) in [(1.0, 1e-3), (2.0, 1e-6), (1e6, 1e-9)] {
                    let camera = Camera::look_at(target + from.normalize() * distance, target, fov);
                    let eye = target - camera.basis().forward * distance;
                    let scene = Scene { camera: Some(Camera { eye, ..camera }), ..Scene::default() };
                    let zoom = Zoom::of(&mut renderer, &scene, &map);
                    let Judgement { missed, invented, astray, nan, tangent, ratio, .. } = zoom.judged;
                    let name = format!("{name}, {what}, {fov:e}° from {distance:e}, {number}");
                    assert_eq!([missed, invented, astray, nan], [0; 4], "{name}: missed, invented, astray, NaN");
                    assert!(zoom.stairs < 0.01, "{name}: {} of the pixels are stairs", zoom.stairs);
                    assert!(tangent <= MOST_EXCUSED, "{name}: {tangent} pixels are excused");
                    (hits, largest) = (hits + zoom.judged.hits, largest.max(ratio));
                }
            }
        }
        println!("{name}: {hits} hits at edges, at most {largest:.3} of the bound off");
        assert!(hits > 30_000);
    }
}

/// Craters, baked and layered, are as smooth: what is layered keeps the rounding of its corners' heights, the same for all
/// of the picture.
#[test]
fn craters_in_a_deep_zoom_have_no_stairs() {
    let map = canyon();
    let extent = map.box_size(None);
    let list = craters(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    edited.set_craters(&list);
    let mut renderer = renderer(&map);
    for (mode, ground) in [
        (CraterMode::Baked, edited.field().clone()),
        (CraterMode::Layered, CraterLayer::rasterise(&list, &map, map.width()).apply_to(&map)),
    ] {
        for (distance, fov) in [(1.0, 1e-3), (2.0, 1e-6)] {
            let camera = camera_at(&ground, extent, [0.45, 0.41], FROM[0], distance, fov);
            let mut scene = Scene { camera: Some(camera), ..Scene::default() };
            (scene.craters.mode, scene.craters.list) = (mode, list.clone());
            scene.craters.layer_resolution = map.width();
            let zoom = Zoom::of(&mut renderer, &scene, &ground);
            println!("{mode:?} {fov:e}: {:?}, stairs {}, errors {:e}", zoom.judged, zoom.stairs, zoom.quantile(1.0));
            assert_eq!(zoom.judged.hits, zoom.judged.pixels);
            assert_eq!(zoom.errors.len() as u64, zoom.judged.pixels, "{mode:?} {fov:e}: pixels without ground");
            assert!(zoom.stairs < 0.01, "{mode:?} {fov:e}: {} of the pixels are stairs", zoom.stairs);
            if mode == CraterMode::Baked {
                zoom.assert_exact(&format!("baked craters {fov:e}° from {distance:e}"));
            } else {
                // An offset: all pixels are off by the same.
                let error = zoom.quantile(1.0) * camera.pixel_size(SIZE[1]) * distance;
                assert!(error < 1e-6, "layered craters {fov:e}°: {error} off");
            }
        }
    }
}

/// Only a deep zoom by the exact technique has the shader of one; an ordinary view has nothing of it.
#[test]
fn only_deep_zooms_pay_for_depth() {
    let map = canyon();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    for (fov, technique, deep) in [
        (60.0, Technique::MaxMipmap, false),
        (1.0, Technique::MaxMipmap, false),
        (1e-3, Technique::LinearBinary, false),
        (1e-3, Technique::MaxMipmap, true),
    ] {
        let camera = camera_at(&map, extent, [0.4, 0.6], FROM[0], 1.0, fov);
        let mut scene = Scene { camera: Some(camera), ..Scene::default() };
        scene.march.technique = technique;
        picture(&mut renderer, &scene);
        let defs = &renderer.ledger().shader_defs;
        assert_eq!(defs.iter().any(|def| def == "DEEP_ZOOM"), deep, "{fov}°, {technique:?}: {defs:?}");
    }
}
