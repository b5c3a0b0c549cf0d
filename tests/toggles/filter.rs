//! How heights between samples are found.

use relief::camera::NamedView;
use relief::scene::{HeightFilter, Technique};

use crate::change::{Change, error, errors, start};
use crate::common::pictures::count;
use crate::common::{SIZE, canyon, scene_at};

#[test]
fn the_nearest_filter_makes_a_field_of_boxes() {
    let mut scene = scene_at(NamedView::Down, &canyon());
    scene.march.technique = Technique::LinearBinary;
    scene.march.binary_steps = 16;
    let change = Change::of(&scene, |scene| scene.march.filter = HeightFilter::Nearest);
    // Looking straight down from far, a hit's height is that of the sample below it.
    let (map, camera) = (canyon(), scene.camera.unwrap());
    let extent = map.box_size(None);
    let [columns, rows] = map.cells().map(f64::from);
    let (mut on_a_top, mut hits) = (0, 0);
    for (index, &distance) in
        change.probe_after.distance.iter().enumerate().filter(|(_, distance)| distance.is_finite())
    {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
        let hit = ray.origin + ray.direction.normalize() * f64::from(distance);
        let nearest = |share: f64, cells: f64| (share.clamp(0.0, 1.0) * cells + 0.5).floor() as u32;
        let sample = map.sample(nearest(hit.x / extent.x, columns), nearest(hit.z / extent.z, rows));
        on_a_top += usize::from((f64::from(sample) * extent.y - hit.y).abs() < 1e-5);
        hits += 1;
    }
    assert!(on_a_top as f64 > 0.85 * f64::from(hits), "{on_a_top} of {hits} hits lie on a box's top");
    let (smooth, stepped) = (error(&change.probe_before, &scene, &map), error(&change.probe_after, &scene, &map));
    assert!(stepped > 10.0 * smooth, "{stepped} against {smooth}");
}

#[test]
fn the_hardware_filter_is_close_to_exact_but_not_exact() {
    // Near the ground a step of a 256th of a cell is wide.
    let mut scene = scene_at(NamedView::Valley, &canyon());
    scene.march.technique = Technique::LinearBinary;
    (scene.march.samples_max, scene.march.binary_steps) = (512, 20);
    let change = Change::of(&scene, |scene| scene.march.filter = HeightFilter::HardwareLinear);
    let differ = change
        .probe_before
        .distance
        .iter()
        .zip(&change.probe_after.distance)
        .filter(|(exact, by_hardware)| exact != by_hardware);
    assert!(differ.count() > 1000, "the sampler rounds its own way");
    let [exact, by_hardware] = [&change.probe_before, &change.probe_after]
        .map(|probe| errors(probe, &scene, &canyon()))
        .map(|errors| errors[errors.len() / 2]);
    println!("median error in cells: exact {exact:.2e}, hardware {by_hardware:.2e}");
    // Weights of 8 bits, as GPUs have them, cost up to some hundredths of a cell; a software driver's cost nothing.
    assert!(by_hardware < exact + 0.05, "{by_hardware} against {exact}");
}

#[test]
fn the_filter_is_nothing_to_the_exact_technique() {
    let change = Change::of(&start(), |scene| scene.march.filter = HeightFilter::Nearest);
    change.assert_distances_kept();
    assert_eq!(count(&change.changed), 0);
}
