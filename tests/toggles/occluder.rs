//! The cube that floats over the terrain.

use glam::DVec3;

use crate::change::{Change, start, with_cube};
use crate::common::pictures::{count, share};

#[test]
fn the_occluder_changes_its_own_pixels_only() {
    let change = Change::of(&start(), |scene| {
        scene.occluder.enabled = true;
        scene.occluder.size = 0.2;
    });
    let cube: Vec<bool> =
        change.probe_before.distance.iter().zip(&change.probe_after.distance).map(|(a, b)| b < a).collect();
    assert!(count(&cube) > 500);
    assert_eq!(change.changed, cube, "just the pixels where the cube is nearer than what was there");
    let elsewhere = change.probe_before.distance.iter().zip(&change.probe_after.distance).zip(&cube);
    assert!(elsewhere.clone().all(|((a, b), &cube)| cube || a == b));
    let moved = Change::of(&with_cube(), |scene| scene.occluder.rotation = DVec3::new(75.0, 10.0, 20.0));
    assert!(count(&moved.changed) > 200 && share(&moved.changed) < 0.3);
}
