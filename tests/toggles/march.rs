//! What the march is told: steps, halvings, where it starts, and what it does with misses.

use relief::camera::NamedView;
use relief::heightfield::EditedTerrain;
use relief::render::Probe;
use relief::scene::Technique;

use crate::change::{Change, error, sampled, start};
use crate::common::pictures::{count, share, sky};
use crate::common::{canyon, crater_on_the_summit, picture, scene_at};

/// Halvings find the place within the step that uniform samples found.
#[test]
fn halvings_make_the_hit_exact_and_lose_none() {
    let map = canyon();
    let scene = sampled(Technique::LinearBinary);
    let without = Change::of(&scene, |scene| scene.march.binary_steps = 0);
    let exact = error(&without.probe_before, &scene, &map);
    let coarse = error(&without.probe_after, &scene, &map);
    println!("mean error in cells: 8 halvings {exact:.4}, none {coarse:.4}");
    assert!(exact < 0.5 * coarse, "{exact} against {coarse}");
    assert_eq!(sky(&without.probe_before), sky(&without.probe_after), "the same rays hit");
    assert!(
        without.probe_before.distance.iter().zip(&without.probe_after.distance).all(|(fine, coarse)| fine <= coarse)
    );
    let mut renderer = without.renderer;
    let linear = picture(&mut renderer, &sampled(Technique::Linear));
    assert!(linear == without.after, "without halvings `linear-binary` is `linear`, byte for byte");
}

#[test]
fn more_samples_are_more_exact() {
    let scene = sampled(Technique::Linear);
    let change = Change::of(&scene, |scene| scene.march.samples_max = 512);
    let (few, many) = (error(&change.probe_before, &scene, &canyon()), error(&change.probe_after, &scene, &canyon()));
    println!("linear, mean error in cells: 64 samples {few:.3}, 512 samples {many:.3}");
    assert!(many < 0.5 * few, "{many} against {few}");
    assert!(change.probe_after.step_stats().0 > 2.0 * change.probe_before.step_stats().0);
}

/// With steps by angle a steep ray takes fewer; fixed, all rays that meet nothing take as many.
#[test]
fn steps_by_angle_spare_steep_rays() {
    let mut scene = scene_at(NamedView::Down, &canyon());
    scene.march.technique = Technique::Linear;
    (scene.march.samples_min, scene.march.samples_max) = (32, 256);
    let fixed = Change::of(&scene, |scene| scene.march.steps_by_angle = false);
    let (by_angle, all) = (fixed.probe_before.step_stats(), fixed.probe_after.step_stats());
    assert!(by_angle.0 < 0.6 * all.0, "{by_angle:?} against {all:?}");
    assert!(all.1 <= 257 && by_angle.1 < all.1);
    let coarse = error(&fixed.probe_before, &scene, &canyon());
    let fine = error(&fixed.probe_after, &scene, &canyon());
    assert!(fine < coarse, "more steps, less error: {fine} against {coarse}");
    let minimum = Change::of(&scene, |scene| scene.march.samples_min = 200);
    assert!(minimum.probe_after.step_stats().0 > 1.5 * by_angle.0);
}

#[test]
fn kept_misses_fill_the_box_and_leave_the_ground() {
    for technique in Technique::ALL {
        let mut scene = start();
        scene.march.technique = technique;
        let change = Change::of(&scene, |scene| scene.march.discard_misses = false);
        let sky_after = sky(&change.probe_after);
        assert!(count(&sky_after) < count(&change.sky), "some of the sky becomes ground");
        for (index, &was_sky) in change.sky.iter().enumerate() {
            if !was_sky {
                assert!(!change.changed[index] && !sky_after[index], "ground stays as it is");
            } else if sky_after[index] {
                assert!(!change.changed[index], "sky beside the box stays sky");
            }
        }
    }
}

/// After the summit is gone the lowered start spends no sample above the highest ground.
#[test]
fn the_lowered_start_spends_its_samples_where_the_ground_is() {
    let map = canyon();
    let mut scene = scene_at(NamedView::Over, &map);
    scene.march.technique = Technique::Linear;
    scene.march.samples_max = 128;
    scene.march.steps_by_angle = false;
    scene.craters.list = vec![crater_on_the_summit(&map)];
    let mut cut = EditedTerrain::new(canyon());
    cut.set_craters(&scene.craters.list);
    let change = Change::of(&scene, |scene| scene.march.lower_start = false);
    let lowered = error(&change.probe_before, &scene, cut.field());
    let full = error(&change.probe_after, &scene, cut.field());
    println!("mean error in cells: lowered {lowered:.3}, from the lid {full:.3}");
    assert!(lowered < 0.98 * full, "{lowered} against {full}");
    // The exact technique sees the same from either start.
    scene.march.technique = Technique::MaxMipmap;
    let exact = Change::of(&scene, |scene| scene.march.lower_start = false);
    assert_eq!(sky(&exact.probe_before), sky(&exact.probe_after));
    let steps = |probe: &Probe| probe.steps.iter().map(|&steps| u64::from(steps)).sum::<u64>();
    assert!(steps(&exact.probe_before) <= steps(&exact.probe_after));
}

#[test]
fn the_height_scale_flattens_the_silhouette() {
    let mut scene = scene_at(NamedView::Graze, &canyon());
    let natural = canyon().natural_height_scale();
    scene.skybox.enabled = false;
    let change = Change::of(&scene, |scene| scene.terrain.height_scale = Some(0.5 * natural));
    let after = sky(&change.probe_after);
    assert!(count(&after) > count(&change.sky) + 500, "more sky over lower ground");
    let filled = change.sky.iter().zip(&after).filter(|&(&before, &after)| before && !after).count();
    assert!(filled * 100 < count(&change.sky), "{filled} pixels of sky became ground");
    assert!(share(&change.changed) > 0.3);
}
