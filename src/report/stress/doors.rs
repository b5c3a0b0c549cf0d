//! Bad numbers: refused or repaired at the door, so that none reaches a shader.

use super::edits::Check;
use crate::camera::Camera;
use crate::heightfield::{Crater, HeightField};
use crate::scene::Scene;
use crate::scene_file::validate;

/// Numbers that nothing can be drawn with, as TOML writes them.
const BAD: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e38, -1e38];
/// Numbers that are odd but mean something.
const ODD: [f64; 3] = [-0.0, 1e-310, -1e-310];

/// What must hold of bad numbers in heights and in every value of a scene.
pub(super) fn checks() -> Vec<Check> {
    vec![
        Check::new("heights that are NaN or infinite are refused", bad_heights()),
        Check::new("heights of any other size are normalised to 0..1", odd_heights()),
        Check::new("NaN, infinities and ±1e38 are refused in every value of a scene", bad_values()),
        Check::new("what is accepted of -0 and subnormal values keeps a camera's rays finite", odd_values()),
    ]
}

fn bad_heights() -> Result<(), String> {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for index in 0..9 {
            let mut raw = [0.5; 9];
            raw[index] = bad;
            match HeightField::from_raw(3, 3, &raw) {
                Ok(_) => return Err(format!("{bad} as sample {index} is accepted")),
                Err(error) if error.to_string().lines().count() < 3 => return Err(format!("too short: {error}")),
                Err(_) => {}
            }
        }
    }
    Ok(())
}

fn odd_heights() -> Result<(), String> {
    let lists = [
        [0.0, 1e38, -1e38, 0.0],
        [f64::MAX, f64::MIN, 0.0, 1.0],
        [1e-310, 0.0, -0.0, 3e-310],
        [-0.0, 0.0, -0.0, 0.0],
        [f64::from(f32::MIN_POSITIVE), 1.0, 0.0, 1.0],
    ];
    for raw in lists {
        let field = HeightField::from_raw(2, 2, &raw).map_err(|error| format!("{raw:?}: {error}"))?;
        let fine = |sample: &f32| (0.0..=1.0).contains(sample) && sample.is_sign_positive();
        if !field.samples().iter().all(fine) || !field.natural_height_scale().is_finite() {
            return Err(format!("{raw:?} becomes {:?}", field.samples()));
        }
    }
    Ok(())
}

/// A scene in which every optional number is there.
fn scene() -> Scene {
    let mut scene =
        Scene { camera: Some(Camera { eye: glam::DVec3::ONE, yaw: 1.0, pitch: 1.0, fov: 60.0 }), ..Scene::default() };
    scene.terrain.height_scale = Some(0.25);
    scene.occluder.position = Some(glam::DVec3::ONE);
    scene.craters.list.push(Crater { x: 0.5, z: 0.5, radius: 0.1, depth: 0.1, rim: 0.1 });
    scene
}

/// Replaces the number at the place `index` among all numbers of `value`; its path, if there are so many.
fn replace(value: &mut toml::Value, index: &mut usize, by: f64) -> Option<String> {
    match value {
        toml::Value::Float(_) | toml::Value::Integer(_) => {
            if *index == 0 {
                *value = toml::Value::Float(by);
                return Some(String::new());
            }
            *index -= 1;
            None
        }
        toml::Value::Array(list) => {
            list.iter_mut().enumerate().find_map(|(at, value)| Some(format!("[{at}]{}", replace(value, index, by)?)))
        }
        toml::Value::Table(table) => {
            table.iter_mut().find_map(|(key, value)| Some(format!(".{key}{}", replace(value, index, by)?)))
        }
        _ => None,
    }
}

/// Says what is wrong with a scene, if the one with a number at this path was accepted.
type Test<'a> = dyn Fn(&str, Option<Scene>) -> Result<(), String> + 'a;

/// Calls `check` with the scene in which one number is `by`, for each number in turn, where it is a scene at all.
fn with_each(by: f64, check: &Test<'_>) -> Result<usize, String> {
    let whole = toml::Value::try_from(scene()).map_err(|error| error.to_string())?;
    let mut count = 0;
    loop {
        let (mut changed, mut index) = (whole.clone(), count);
        let Some(path) = replace(&mut changed, &mut index, by) else { return Ok(count) };
        check(&path, changed.try_into::<Scene>().ok().filter(|scene| validate(scene).is_ok()))?;
        count += 1;
    }
}

fn bad_values() -> Result<(), String> {
    for bad in BAD {
        let refused = |path: &str, scene: Option<Scene>| match scene {
            Some(_) => Err(format!("{path} = {bad:e} is accepted")),
            None => Ok(()),
        };
        if with_each(bad, &refused)? < 30 {
            return Err(String::from("a scene has more numbers than were tried"));
        }
    }
    Ok(())
}

fn odd_values() -> Result<(), String> {
    for odd in ODD {
        let finite = |path: &str, scene: Option<Scene>| {
            let Some(camera) = scene.and_then(|scene| scene.camera) else { return Ok(()) };
            let pixel = camera.pixel_size(400) as f32;
            let matrix = camera.clip_from_world([640, 400]).as_mat4();
            if pixel > 0.0 && pixel.is_finite() && matrix.is_finite() {
                Ok(())
            } else {
                Err(format!("{path} = {odd:e} is accepted, and no ray has a direction"))
            }
        };
        with_each(odd, &finite)?;
    }
    Ok(())
}
