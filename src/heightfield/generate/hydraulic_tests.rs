use super::*;
use crate::heightfield::testing::Numbers;
use std::sync::atomic::AtomicBool;

fn rain(heights: &[f32], plane: &Plane, hydraulic: &Hydraulic) -> (Vec<f32>, Account) {
    let mut heights = heights.to_vec();
    let (cancel, progress) = (AtomicBool::new(false), |_| {});
    let account = erode(&mut heights, plane, hydraulic, 7, Work::new(&progress, &cancel)).unwrap();
    (heights, account)
}

fn sum(heights: &[f32]) -> f64 {
    heights.iter().map(|&height| f64::from(height)).sum()
}

fn map(plane: &Plane, mut of: impl FnMut(usize, usize) -> f32) -> Vec<f32> {
    (0..plane.width * plane.height).map(|place| of(place % plane.width, place / plane.width)).collect()
}

/// Flat, one needle, a cliff, a pit that all drops run into, noise.
fn hard_maps(plane: &Plane) -> [(&'static str, Vec<f32>); 5] {
    let (width, height) = (plane.width, plane.height);
    let mut numbers = Numbers::new(3);
    [
        ("flat", map(plane, |_, _| 5.0)),
        ("needle", map(plane, |x, y| if (x, y) == (width / 2, height / 3) { 200.0 } else { 0.0 })),
        ("cliff", map(plane, |x, _| if x < width / 2 { 0.0 } else { 60.0 })),
        ("pit", map(plane, |x, y| x.abs_diff(width / 2).max(y.abs_diff(height / 2)) as f32)),
        ("noise", map(plane, |_, _| numbers.between(0.0, 20.0) as f32)),
    ]
}

/// Sizes with one band, with several, and with bands too thin to run in.
fn planes() -> impl Iterator<Item = Plane> {
    let sizes = [(2, 2), (3, 50), (40, 30), (33, 130), (20, 300)];
    sizes.into_iter().flat_map(|(width, height)| [false, true].map(|wraps| Plane { width, height, wraps }))
}

#[test]
fn soil_is_neither_made_nor_lost() {
    for plane in planes() {
        for (name, before) in hard_maps(&plane) {
            for radius in [1, 8] {
                let hydraulic = Hydraulic { drops: 2.0, radius, ..Hydraulic::default() };
                let (after, account) = rain(&before, &plane, &hydraulic);
                let what = format!("{name}, {plane:?}, radius {radius}: {account:?}");
                assert!(after.iter().all(|height| height.is_finite()), "{what}");
                let Account { eroded, deposited, carried_off } = account;
                assert!((eroded - deposited - carried_off).abs() <= 1e-9 * eroded.max(1.0), "all is settled: {what}");
                let difference = sum(&after) - sum(&before) - (deposited - eroded);
                // Each write rounds to single precision, and a wide brush on a small map writes the same sample often.
                assert!(difference.abs() <= 1e-4 * (sum(&before).abs() + eroded), "{difference}: {what}");
                assert!(!plane.wraps || carried_off == 0.0, "nowhere to carry it to: {what}");
            }
        }
    }
}

#[test]
fn flat_ground_stays_and_hills_lose_to_valleys() {
    let plane = Plane { width: 200, height: 200, wraps: false };
    let hydraulic = Hydraulic { drops: 1.0, ..Hydraulic::default() };
    let flat = map(&plane, |_, _| 5.0);
    assert_eq!(rain(&flat, &plane, &hydraulic), (flat, Account::default()));
    let hill = map(&plane, |x, y| 40.0 - 0.4 * (x as f32 - 100.0).hypot(y as f32 - 100.0).min(100.0));
    let (after, account) = rain(&hill, &plane, &hydraulic);
    let highest = |heights: &[f32]| heights.iter().copied().fold(0.0, f32::max);
    assert!(account.eroded > 100.0 && highest(&after) < highest(&hill) - 0.1, "{account:?}");
}

/// Every drop is run, and the border that a landscape wraps over is no border: moved by any number of rows, the same
/// landscape erodes as much.
#[test]
fn no_seam_is_left_where_bands_meet() {
    let plane = Plane { width: 64, height: 320, wraps: true };
    let waves = map(&plane, |x, y| {
        let wave = |place: usize, count: usize| (place as f32 / count as f32 * std::f32::consts::TAU).sin();
        5.0 * wave(x, 32) + 5.0 * wave(y, 32)
    });
    let (after, _) = rain(&waves, &plane, &Hydraulic { drops: 4.0, ..Hydraulic::default() });
    let lost = |row: usize| {
        let range = row * 64..(row + 1) * 64;
        after[range.clone()].iter().zip(&waves[range]).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>()
    };
    // Ten equal stripes of 32 rows: none is worn much less or more than the others.
    let stripes: Vec<f64> = (0..10).map(|stripe| (0..32).map(|row| lost(stripe * 32 + row)).sum()).collect();
    let mean = stripes.iter().sum::<f64>() / 10.0;
    assert!(stripes.iter().all(|stripe| (stripe / mean - 1.0).abs() < 0.25), "{stripes:?}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let plane = Plane { width: 100, height: 400, wraps: false };
    let [.., (_, noise)] = hard_maps(&plane);
    let hydraulic = Hydraulic { drops: 1.0, ..Hydraulic::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| rain(&noise, &plane, &hydraulic))
    };
    let one = on(1);
    assert!(one.1.eroded > 0.0);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn cancelled_rain_says_so() {
    let plane = Plane { width: 10, height: 10, wraps: false };
    let (cancel, progress) = (AtomicBool::new(true), |_| {});
    let hydraulic = Hydraulic { drops: 1.0, ..Hydraulic::default() };
    let result = erode(&mut [1.0; 100], &plane, &hydraulic, 1, Work::new(&progress, &cancel));
    assert_eq!(result, Err(MakeError::Cancelled));
}
