//! Random small maps and cameras: the GPU against the twin, case by case. `PROPTEST_CASES` asks for more of them.

use std::cell::RefCell;
use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use relief::camera::Camera;
use relief::heightfield::HeightField;
use relief::scene::Scene;

use super::Comparison;
use super::common::gpu;
use super::{DVec3, Renderer};

/// Largest error of any hit, as a share of the box or of the distance.
const MOST_ERROR: f64 = 1e-5;

/// Usual number of cases.
const CASES: u32 = 150;

#[derive(Clone, Debug)]
struct Case {
    size: (u32, u32),
    kind: u32,
    seed: u32,
    scale: f64,
    eye: [f64; 3],
    target: [f64; 3],
    fov: f64,
}

impl Case {
    fn map(&self) -> HeightField {
        let noise = |x: u32, z: u32| {
            let mut bits = x.wrapping_mul(0x9e37_79b9) ^ z.wrapping_mul(0x85eb_ca6b) ^ self.seed;
            for _ in 0..3 {
                bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
            }
            f64::from(bits >> 8) / f64::from(1u32 << 24)
        };
        let height = |x: u32, z: u32| match self.kind {
            0 => noise(x, z),
            1 => f64::from(u8::from(noise(x, z) > 0.95)),
            2 => (noise(x / 4, z / 4) * 3.0).floor(),
            3 => f64::from((x + z) % 2),
            4 => f64::from(u8::from(x == self.size.0 / 2 || z == 1)),
            _ => f64::from(x) + 1e-6 * noise(x, z),
        };
        let (width, rows) = self.size;
        let raw: Vec<f64> =
            (0..rows).flat_map(|z| (0..width).map(move |x| (x, z))).map(|(x, z)| height(x, z)).collect();
        HeightField::from_raw(width, rows, &raw).unwrap()
    }

    /// Whether the eye is as near to the ground as the rounding of a height.
    fn eye_is_on_the_ground(&self) -> bool {
        let [x, y, z] = self.eye;
        let over_map = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&z);
        over_map && (y - self.map().surface_height(x, z)).abs() < 1e-5
    }
}

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -0.5f64..1.5, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5), 1 => -20.0f64..20.0]
}

fn case() -> impl Strategy<Value = Case> {
    let scale = prop_oneof![5 => 0.02f64..1.5, 1 => Just(0.0), 1 => Just(1e-6), 1 => 10.0f64..1000.0];
    let size = (2u32..=65, 2u32..=65);
    let eye = [share(), share(), share()];
    let target = [0.1f64..0.9, 0.1f64..0.9, 0.1f64..0.9];
    (size, 0u32..6, any::<u32>(), scale, eye, target, prop_oneof![4 => 20.0f64..100.0, 1 => 0.05f64..5.0])
        .prop_map(|(size, kind, seed, scale, eye, target, fov)| Case { size, kind, seed, scale, eye, target, fov })
}

/// What is wrong with a case, and its hits.
fn wrong(renderer: &mut Renderer, case: &Case) -> Result<usize, String> {
    let map = Arc::new(case.map());
    renderer.set_terrain(Arc::clone(&map)).unwrap();
    let extent = map.box_size(Some(case.scale));
    let (eye, target) = (DVec3::from(case.eye) * extent, DVec3::from(case.target) * extent);
    let mut scene = Scene { camera: Some(Camera::look_at(eye, target, case.fov)), ..Scene::default() };
    scene.terrain.height_scale = Some(case.scale);
    let comparison = Comparison::of(renderer, &scene, &map, [64, 48]);
    let counts = (comparison.missed, comparison.invented, comparison.astray, comparison.cap_hits);
    if counts != (0, 0, 0, 0) {
        return Err(format!("missed, invented, astray, cap hits: {counts:?}"));
    }
    let size = extent.max_element().max(eye.length());
    let error = comparison.quantile(0.99) * comparison.cell / size;
    if error > MOST_ERROR {
        return Err(format!("p99 {error:e} of the scene's size"));
    }
    Ok(comparison.hits)
}

/// Rounded to a little above the floor on their way in, these rays rose over ground that lies on it.
#[test]
fn from_below_ground_on_the_floor_is_met() {
    let (eye, target) = ([0.0, -0.461_133_115_037_282_44, 0.0], [0.1; 3]);
    let case =
        Case { size: (12, 2), kind: 1, seed: 209_756_095, scale: 0.066_893_264_036_376_91, eye, target, fov: 20.0 };
    let hits = wrong(&mut Renderer::new(gpu()).unwrap(), &case).unwrap();
    assert!(hits > 0);
}

#[test]
fn random_maps_and_cameras_are_met_as_by_the_twin() {
    let asked = std::env::var_os("PROPTEST_CASES").is_some();
    let seeded = std::env::var_os("PROPTEST_RNG_SEED").is_some();
    let default = ProptestConfig::default();
    let config = ProptestConfig {
        failure_persistence: None,
        cases: if asked { default.cases } else { CASES },
        rng_seed: if seeded { default.rng_seed } else { RngSeed::Fixed(4) },
        ..default
    };
    let cases = config.cases;
    let renderer = RefCell::new(Renderer::new(gpu()).unwrap());
    let hits = RefCell::new(0);
    let result = TestRunner::new(config).run(&case(), |case| {
        if case.eye_is_on_the_ground() {
            return Err(TestCaseError::reject("whether it is above or below is a matter of rounding"));
        }
        *hits.borrow_mut() += wrong(&mut renderer.borrow_mut(), &case).map_err(TestCaseError::fail)?;
        Ok(())
    });
    if let Err(error) = result {
        panic!("{error}");
    }
    println!("{cases} random maps and cameras, {} hits", hits.borrow());
    assert!(*hits.borrow() > 200 * cases as usize, "only {} hits", hits.borrow());
}
