//! Craters, baked and layered, and how they are taken back.

use relief::heightfield::Crater;
use relief::render::Probe;
use relief::scene::{CraterMode, Scene, Technique};

use crate::change::{Change, start};
use crate::common::pictures::count;
use crate::common::{SIZE, canyon, craters, picture, renderer};

/// Whether the rays that see differently meet the ground within the reach of a crater, before or after.
fn assert_changes_within_reach(change: &Change, scene: &Scene, list: &[Crater]) {
    let camera = scene.camera.unwrap();
    for (index, _) in change.changed.iter().enumerate().filter(|&(_, &changed)| changed) {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let direction = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE).direction.normalize();
        let near_one = |probe: &Probe| {
            let distance = f64::from(probe.distance[index]);
            let hit = camera.eye + direction * distance;
            // The normals and the generated colours look at neighbouring samples, and mips spread a colour further.
            let margin = 0.02;
            distance.is_finite()
                && list.iter().any(|c| (hit.x - c.x).hypot(hit.z - c.z) <= c.radius * Crater::REACH + margin)
        };
        assert!(near_one(&change.probe_before) || near_one(&change.probe_after), "pixel {x}, {y} changed");
    }
}

#[test]
fn craters_change_only_what_sees_them() {
    let extent = canyon().box_size(None);
    let crater = |u: f64, v: f64| Crater { x: u * extent.x, z: v * extent.z, radius: 0.06, depth: 0.4, rim: 0.1 };
    let list = [crater(0.5, 0.6), crater(0.3, 0.4)];
    for mode in [CraterMode::Baked, CraterMode::Layered] {
        let mut scene = start();
        scene.craters.mode = mode;
        let change = Change::of(&scene, |scene| scene.craters.list = list.to_vec());
        assert!(count(&change.changed) > 500, "{mode:?}");
        assert_changes_within_reach(&change, &scene, &list);
    }
}

#[test]
fn an_edit_is_a_fresh_build_byte_for_byte_and_can_be_taken_back() {
    let map = canyon();
    for technique in [Technique::MaxMipmap, Technique::LinearBinary] {
        let mut scene = start();
        scene.march.technique = technique;
        let mut edited = renderer(&map);
        let untouched = picture(&mut edited, &scene);
        let list = craters(&map);
        let mut with = Vec::new();
        for count in 1..=list.len() {
            scene.craters.list = list[..count].to_vec();
            with.push(picture(&mut edited, &scene));
        }
        assert!(picture(&mut renderer(&map), &scene) == with[list.len() - 1], "{technique:?}: not as freshly built");
        // Colours that are first painted when the craters are there already are the same, too.
        let mut late = renderer(&map);
        let mut plain = scene.clone();
        plain.diffuse.enabled = false;
        picture(&mut late, &plain);
        assert!(picture(&mut late, &scene) == with[list.len() - 1], "{technique:?}: painted late");
        for count in (1..list.len()).rev() {
            scene.craters.list.pop();
            assert!(picture(&mut edited, &scene) == with[count - 1], "{technique:?}: undo to {count}");
        }
        scene.craters.list = list;
        picture(&mut edited, &scene);
        scene.craters.list.clear();
        assert!(picture(&mut edited, &scene) == untouched, "{technique:?}: clear all");
    }
}

#[test]
fn layered_craters_look_like_baked_ones() {
    let map = canyon();
    let mut scene = start();
    let extent = map.box_size(None);
    scene.craters.layer_resolution = map.width();
    scene.craters.list = vec![Crater { x: 0.5 * extent.x, z: 0.6 * extent.z, radius: 0.1, depth: 0.4, rim: 0.1 }];
    let change = Change::of(&scene, |scene| scene.craters.mode = CraterMode::Layered);
    let far = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-3 || a.is_finite() != b.is_finite();
    let apart = change.probe_before.distance.iter().zip(&change.probe_after.distance).filter(|&pair| far(pair)).count();
    assert!(apart < 80, "{apart} distances differ by more than 0.001");
    // And back: the baked heights are all there again.
    let mut renderer = change.renderer;
    assert!(picture(&mut renderer, &scene) == change.before);
    // A coarser layer is a coarser crater.
    scene.craters.mode = CraterMode::Layered;
    let coarse = Change::of(&scene, |scene| scene.craters.layer_resolution = 24);
    assert!(count(&coarse.changed) > 500);
}
