//! The figures on pictures whose figures are known, and on techniques that are broken on purpose.

use std::sync::Arc;

use image::{Rgb, RgbImage};

use super::*;
use crate::camera::{Camera, NamedView};
use crate::heightfield::HeightField;
use crate::heightfield::generate::{Kind, generate};
use crate::heightfield::reference::Surface;

const SKY: f64 = f64::INFINITY;

#[test]
fn a_plane_seen_right_has_no_error() {
    // Ground that recedes by a tenth a row: a ramp is in line with itself, however steep.
    let plane: Vec<f64> = (0..100).map(|at| 1.0 + f64::from(10 - at / 10) * 0.1).collect();
    assert_eq!(Figures::of(&plane, &plane, [10, 10], 0.01), Figures::default());
}

#[test]
fn a_plane_that_is_off_by_half_a_cell_is_off_everywhere_and_wrong_nowhere() {
    let plane = [2.0; 100];
    let found = Figures::of(&plane, &[2.005f32; 100], [10, 10], 0.01);
    for error in [found.p50, found.p95, found.p99, found.max] {
        assert!((error - 0.5).abs() < 1e-4, "{found:?}");
    }
    assert_eq!((found.see_through, found.covers_sky, found.incoherent, found.wrong), (0.0, 0.0, 0.0, 0.0));
}

#[test]
fn percentiles_are_errors_that_occurred() {
    // Errors of 1 to 200 cells, one each.
    let reference = vec![1.0; 200];
    let picture: Vec<f64> = (1..=200).rev().map(|cells| 1.0 + f64::from(cells) * 0.25).collect();
    let found = Figures::of(&reference, &picture, [20, 10], 0.25);
    assert_eq!((found.p50, found.p95, found.p99, found.max), (100.0, 190.0, 198.0, 200.0));
    assert_eq!(found.wrong, 99.5, "all but the one that is off by just one cell");
    assert_eq!(nearest_rank(&[], 50), None);
    assert_eq!(nearest_rank(&[7.0], 1), Some(7.0));
}

#[test]
fn a_step_seen_one_column_too_far_left_is_wrong_in_that_column() {
    let step = |edge: usize| (0..100).map(|at| if at % 10 < edge { 1.0 } else { 3.0 }).collect::<Vec<f64>>();
    let found = Figures::of(&step(5), &step(4), [10, 10], 0.5);
    assert_eq!((found.p50, found.p95, found.max), (0.0, 4.0, 4.0), "a tenth of the pixels, by 2 / 0.5 cells");
    assert_eq!(found.wrong, 10.0);
    assert_eq!(found.incoherent, 0.0, "a step in the wrong place is as coherent as one in the right place");
}

#[test]
fn a_single_wrong_pixel_is_a_speck() {
    let ground = [1.0; 100];
    let mut speck = ground;
    speck[44] = 1.02;
    let found = Figures::of(&ground, &speck, [10, 10], 0.01);
    assert_eq!((found.incoherent, found.wrong), (1.0, 1.0));
    assert_eq!((found.p99, found.max > 1.9), (0.0, true));
    assert_eq!(incoherent(&speck, &speck, [10, 10]), 0.0, "the reference has it, too");
    let mut hole = ground;
    hole[0] = SKY;
    let found = Figures::of(&ground, &hole, [10, 10], 0.01);
    assert_eq!((found.see_through, found.covers_sky, found.incoherent), (1.0, 0.0, 1.0), "a hole in a corner");
    assert_eq!((found.max, found.wrong), (0.0, 1.0), "a hole has no distance");
}

#[test]
fn a_shifted_sky_is_counted_row_by_row() {
    let horizon = |row: usize| (0..100).map(|at| if at / 10 < row { SKY } else { 2.0 }).collect::<Vec<f64>>();
    let lower = Figures::of(&horizon(3), &horizon(5), [10, 10], 0.1);
    assert_eq!((lower.see_through, lower.covers_sky, lower.wrong, lower.incoherent), (20.0, 0.0, 20.0, 0.0));
    let higher = Figures::of(&horizon(3), &horizon(2), [10, 10], 0.1);
    assert_eq!((higher.see_through, higher.covers_sky, higher.wrong), (0.0, 10.0, 10.0));
    let all_sky = Figures::of(&[SKY; 100], &[SKY; 100], [10, 10], 0.1);
    assert_eq!(all_sky, Figures::default());
    assert_eq!(Figures::of::<f64>(&[], &[], [0, 0], 1.0), Figures::default());
}

#[test]
fn flip_is_0_for_the_same_picture_and_greatest_for_black_on_white() {
    let plain = |value: u8| RgbImage::from_pixel(64, 48, Rgb([value; 3]));
    assert_eq!(flip(&plain(90), &plain(90)), Some(0.0));
    let greatest = flip(&plain(0), &plain(255)).unwrap();
    assert!(greatest > 0.9 && greatest <= 1.0, "{greatest}");
    let little = flip(&plain(90), &plain(96)).unwrap();
    assert!(little > 0.0 && little < 0.3, "{little}");
    assert_eq!(flip(&plain(0), &RgbImage::new(8, 8)), None);
    assert_eq!(flip(&RgbImage::new(0, 0), &RgbImage::new(0, 0)), None);
}

/// How the marching below is broken.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    None,
    /// The middle is computed and thrown away.
    HalvingsNeverNarrow,
    /// The sampling strides sixteen steps at a time.
    StepsTooLong,
}

/// Uniform steps and halvings in f64, as `march/linear-binary.wgsl` does them.
fn march(map: &HeightField, camera: &Camera, size: [u32; 2], fault: Fault) -> Vec<f64> {
    const STEPS: u32 = 2048;
    let extent = map.box_size(None);
    let stride = if fault == Fault::StepsTooLong { 16 } else { 1 };
    let pixel = |at: u32| {
        let ray = camera.ray(f64::from(at % size[0]) + 0.5, f64::from(at / size[0]) + 0.5, size);
        let length = 3.0 / ray.direction.length();
        let at = |t: f64| ray.origin + ray.direction * t;
        let inside = |t: f64| {
            let p = at(t);
            (0.0..=extent.x).contains(&p.x) && (0.0..=extent.z).contains(&p.z) && p.y >= 0.0
        };
        let below = |t: f64| {
            let p = at(t);
            p.y <= map.surface_height(p.x / extent.x, p.z / extent.z) * extent.y
        };
        let step = length / f64::from(STEPS);
        let Some(first) = (0..=STEPS).step_by(stride).map(|i| f64::from(i) * step).find(|&t| inside(t) && below(t))
        else {
            return SKY;
        };
        let (mut high, mut low) = ((first - step * stride as f64).max(0.0), first);
        for _ in 0..8 {
            let middle = 0.5 * (high + low);
            if fault != Fault::HalvingsNeverNarrow {
                if below(middle) { low = middle } else { high = middle }
            }
        }
        low * ray.direction.length()
    };
    (0..size[0] * size[1]).map(pixel).collect()
}

#[test]
fn a_technique_broken_on_purpose_is_caught() {
    let map = Arc::new(generate(Kind::DiamondSquare, 64, 3));
    let (extent, size) = (map.box_size(None), [64, 40]);
    let camera = NamedView::Over.camera(&map, extent);
    let reference = Surface::new(&map, extent).distances(&camera, size, &|_| {});
    let cell = extent.x / f64::from(map.cells()[0]);
    let figures = |fault| Figures::of(&reference, &march(&map, &camera, size, fault), size, cell);
    let (sound, idle, long) = (figures(Fault::None), figures(Fault::HalvingsNeverNarrow), figures(Fault::StepsTooLong));
    assert!(sound.p50 < 1e-3 && sound.wrong < 1.0, "{sound:?}");
    // A step is 3 / 2048 of the world, a tenth of a cell; halved eight times it is 1/256 of that.
    assert!(idle.p50 > 20.0 * sound.p50, "halvings that never narrow: {idle:?} against {sound:?}");
    assert!(long.wrong > sound.wrong + 1.0 && long.see_through >= sound.see_through, "{long:?}");
}
