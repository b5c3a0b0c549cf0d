//! Random small maps and cameras: the GPU against the twin, case by case. `PROPTEST_CASES` asks for more of them.

use std::cell::RefCell;
use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use relief::camera::Camera;
use relief::heightfield::HeightField;
use relief::scene::Scene;

use relief::report::stress::{self, Judgement};

use super::common::gpu;
use super::{DVec3, Renderer};

/// Size of the pictures.
const SIZE: [u32; 2] = [64, 48];

/// Most pixels of one that the tangency band may excuse: about one in six hundred.
const MOST_EXCUSED: u64 = 5;

/// Usual number of cases.
const CASES: u32 = 600;

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
}

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -0.5f64..1.5, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5), 1 => -20.0f64..20.0]
}

fn case() -> impl Strategy<Value = Case> {
    let scale = prop_oneof![5 => 0.02f64..1.5, 1 => Just(0.0), 1 => Just(1e-6), 1 => 10.0f64..1000.0];
    let size = (2u32..=65, 2u32..=65);
    let eye = [share(), share(), share()];
    let target = [0.1f64..0.9, 0.1f64..0.9, 0.1f64..0.9];
    let deep = (-6.0f64..-1.0).prop_map(|power| 10f64.powf(power));
    let fov = prop_oneof![4 => 20.0f64..100.0, 1 => 0.05f64..5.0, 1 => deep];
    (size, 0u32..6, any::<u32>(), scale, eye, target, fov)
        .prop_map(|(size, kind, seed, scale, eye, target, fov)| Case { size, kind, seed, scale, eye, target, fov })
}

impl Case {
    /// Draws the case and judges it by the bound: every pixel must be that of a ray displaced by less.
    fn judge(&self, renderer: &mut Renderer) -> Result<Judgement, String> {
        let map = Arc::new(self.map());
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        let extent = map.box_size(Some(self.scale));
        // Flat ground is to be seen from above and from below, too.
        let reach = DVec3 { y: if self.scale == 0.0 { 1.0 } else { extent.y }, ..extent };
        let (eye, target) = (DVec3::from(self.eye) * reach, DVec3::from(self.target) * extent);
        let camera = Camera::look_at(eye, target, self.fov);
        let mut scene = Scene { camera: Some(camera), ..Scene::default() };
        scene.terrain.height_scale = Some(self.scale);
        let probe = renderer.probe(&scene, SIZE).unwrap();
        let judged = stress::judge(&map, extent, &camera, &probe);
        if [judged.missed, judged.invented, judged.astray, judged.nan, u64::from(probe.cap_hits)] != [0; 5] {
            return Err(format!("{} cap hits, {judged:?}", probe.cap_hits));
        }
        if judged.tangent > MOST_EXCUSED && !self.eye_is_on_the_ground() {
            return Err(format!("{} pixels in the tangency band: {judged:?}", judged.tangent));
        }
        Ok(judged)
    }

    /// Whether the eye is as near to the ground as the rounding of a height: all its rays are in the band.
    fn eye_is_on_the_ground(&self) -> bool {
        let [x, y, z] = self.eye;
        let over_map = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&z);
        let ground = if self.scale == 0.0 { 0.0 } else { self.map().surface_height(x, z) };
        over_map && (y - ground).abs() < 1e-6
    }
}

/// Rounded to a little above the floor on their way in, these rays rose over ground that lies on it.
#[test]
fn from_below_ground_on_the_floor_is_met() {
    let (eye, target) = ([0.0, -0.461_133_115_037_282_44, 0.0], [0.1; 3]);
    let case =
        Case { size: (12, 2), kind: 1, seed: 209_756_095, scale: 0.066_893_264_036_376_91, eye, target, fov: 20.0 };
    let judged = case.judge(&mut Renderer::new(gpu()).unwrap()).unwrap();
    assert!(judged.hits > 0);
}

/// A box without height has no unit of height either, and a ray from below must still meet its ground.
#[test]
fn flat_ground_is_met_from_below() {
    let (eye, target) = ([0.3, -0.5, 0.3], [0.5, 0.0, 0.5]);
    let case = Case { size: (9, 9), kind: 0, seed: 1, scale: 0.0, eye, target, fov: 60.0 };
    let judged = case.judge(&mut Renderer::new(gpu()).unwrap()).unwrap();
    assert!(judged.hits > 1000, "{judged:?}");
}

/// Seen from afar the outline of the drawn box was within a sixteenth of a pixel of the terrain's, and a rasteriser that
/// keeps corners no finer cut these rays off.
#[test]
fn an_outline_that_a_pixel_barely_meets_is_drawn() {
    let (eye, target) = ([9.723701088955297, 0.0, 0.9230538273285612], [0.42428742249912893, 0.1, 0.30016039554117885]);
    let case = Case {
        size: (58, 25),
        kind: 2,
        seed: 907_709_544,
        scale: 1.197_491_444_484_973_6,
        eye,
        target,
        fov: 73.902_824_025_497_5,
    };
    assert_eq!(case.judge(&mut Renderer::new(gpu()).unwrap()).map(|judged| judged.hits), Ok(8));
}

/// An eye a rounding above a ramp, on the box's corner: f32 puts it into the ground, which every ray then meets at once.
/// Where the reference goes on to the sky that looks like invented ground, and is within the bound.
#[test]
fn an_eye_a_rounding_above_the_ground_is_within_the_bound() {
    let target = [0.837_254_901_960_784_3, 0.350_980_392_156_862_7, 0.708_627_450_980_392_1];
    let (eye, seed) = ([1.0, 1.0, 0.0], 740_460_382);
    let case = Case { size: (9, 10), kind: 5, seed, scale: 1.3983, eye, target, fov: 60.0 };
    assert!(case.eye_is_on_the_ground());
    let judged = case.judge(&mut Renderer::new(gpu()).unwrap()).unwrap();
    assert!(judged.hits > 1000, "{judged:?}");
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
    let seen = RefCell::new((0, 0));
    let result = TestRunner::new(config).run(&case(), |case| {
        let judged = case.judge(&mut renderer.borrow_mut()).map_err(TestCaseError::fail)?;
        let (hits, tangent) = *seen.borrow();
        *seen.borrow_mut() = (hits + judged.hits, tangent + judged.tangent);
        Ok(())
    });
    if let Err(error) = result {
        panic!("{error}");
    }
    let (hits, tangent) = *seen.borrow();
    println!("{cases} random maps and cameras, {hits} hits, {tangent} pixels within rounding of another");
    assert!(hits > 200 * u64::from(cases), "only {hits} hits");
}
