use super::*;
use crate::heightfield::testing::Numbers;
use std::sync::atomic::AtomicBool;

/// Maps that erosion finds hard: flat, one needle, a cliff, noise.
pub(super) fn hard_maps(width: usize, height: usize) -> [(&'static str, Vec<f32>); 4] {
    let map = |of: &mut dyn FnMut(usize, usize) -> f32| {
        (0..width * height).map(|place| of(place % width, place / width)).collect::<Vec<f32>>()
    };
    let mut numbers = Numbers::new(3);
    [
        ("flat", map(&mut |_, _| 5.0)),
        ("needle", map(&mut |x, y| if (x, y) == (width / 2, height / 3) { 200.0 } else { 0.0 })),
        ("cliff", map(&mut |x, _| if x < width / 2 { 0.0 } else { 60.0 })),
        ("noise", map(&mut |_, _| numbers.between(0.0, 20.0) as f32)),
    ]
}

fn step(heights: &[f32], plane: &Plane, thermal: &Thermal) -> Vec<f32> {
    let mut heights = heights.to_vec();
    let (cancel, progress) = (AtomicBool::new(false), |_| {});
    erode(&mut heights, plane, thermal, Work::new(&progress, &cancel)).unwrap();
    heights
}

/// The sum, the steepest slope between neighbours beside and above each other, and what all exceed the talus by.
fn measure(heights: &[f32], plane: &Plane, talus: f64) -> (f64, f64, f64) {
    let at = |x: usize, y: usize| f64::from(heights[y * plane.width + x]);
    let (mut steepest, mut excess) = (0f64, 0f64);
    for y in 0..plane.height {
        for x in 0..plane.width {
            let [_, right] = super::super::plane::neighbours(x, plane.width, plane.wraps);
            let [_, below] = plane.beside(y);
            let rises = [at(right, y) - at(x, y), at(x, below) - at(x, y)];
            for rise in rises {
                steepest = steepest.max(rise.abs());
                excess += (rise.abs() - talus).max(0.0).powi(2);
            }
        }
    }
    (heights.iter().map(|&height| f64::from(height)).sum(), steepest, excess)
}

#[test]
fn material_is_kept_and_steep_slopes_decline_step_by_step() {
    for wraps in [false, true] {
        let plane = Plane { width: 40, height: 30, wraps };
        for (name, map) in hard_maps(40, 30) {
            for strength in [1.0, 0.4] {
                let thermal = Thermal { iterations: 1, strength, talus: 0.7 };
                let mut heights = map.clone();
                let before = measure(&heights, &plane, 0.7);
                let mut last = before;
                for iteration in 0..300 {
                    heights = step(&heights, &plane, &thermal);
                    let now = measure(&heights, &plane, 0.7);
                    let what = format!("{name}, wraps {wraps}, {strength}, {iteration}: {now:?} after {last:?}");
                    assert!(heights.iter().all(|height| height.is_finite()), "{what}");
                    assert!((now.0 - before.0).abs() <= 1e-5 * before.0.abs(), "material: {what}");
                    assert!(now.1 <= last.1.max(0.7) + 1e-4, "steepest: {what}");
                    last = now;
                }
                assert!(last.1 < 0.2 * before.1.max(10.0) && last.2 <= before.2, "{name}: {last:?} of {before:?}");
            }
        }
    }
}

#[test]
fn what_rests_does_not_move() {
    let plane = Plane { width: 20, height: 20, wraps: false };
    let ramp: Vec<f32> = (0..400).map(|place| (place % 20) as f32 * 0.6875).collect();
    assert_eq!(step(&ramp, &plane, &Thermal { iterations: 50, ..Thermal::default() }), ramp);
    let nothing = Thermal { iterations: 50, strength: 0.0, talus: 0.0 };
    let [.., (_, noise)] = hard_maps(20, 20);
    assert_eq!(step(&noise, &plane, &nothing), noise);
}

#[test]
fn a_map_of_two_columns_slides_too() {
    let plane = Plane { width: 2, height: 2, wraps: false };
    let after = step(&[0.0, 10.0, 0.0, 10.0], &plane, &Thermal { iterations: 200, ..Thermal::default() });
    assert!(after[1] - after[0] < 1.0 && (after.iter().sum::<f32>() - 20.0).abs() < 1e-4, "{after:?}");
}

#[test]
fn a_cancelled_slide_says_so() {
    let plane = Plane { width: 4, height: 4, wraps: false };
    let (cancel, progress) = (AtomicBool::new(true), |_| {});
    let thermal = Thermal { iterations: 1, ..Thermal::default() };
    let result = erode(&mut vec![0.0; 16], &plane, &thermal, Work::new(&progress, &cancel));
    assert_eq!(result, Err(MakeError::Cancelled));
}
