//! The techniques along cones, by how their errors against the reference fall.

use std::sync::Arc;

use relief::camera::NamedView;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField};
use relief::render::Renderer;
use relief::scene::{CraterMode, Scene, Technique};

use super::common::{self, canyon, craters, renderer, scene_at};
use super::{Comparison, maps};

const ALONG_CONES: [Technique; 2] = [Technique::Cone, Technique::RelaxedCone];

/// `scene` with a technique and a fixed number of samples.
fn sampled(technique: Technique, samples: u32, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.march.technique = technique;
    (scene.march.samples_min, scene.march.samples_max) = (samples, samples);
    scene
}

#[test]
fn techniques_along_cones_err_less_the_more_steps_they_may_take() {
    for (map_name, map) in maps() {
        let mut renderer = renderer(&map);
        for technique in ALONG_CONES {
            for view in NamedView::MEASURED {
                let scene = scene_at(view, &map);
                let mut measured = |technique: Technique, samples: u32| {
                    let scene = sampled(technique, samples, &scene);
                    let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
                    comparison.print(&format!("{map_name} {} {} {samples}", view.name(), technique.name()));
                    comparison
                };
                let [few, some, many] = [16, 128, 1024].map(|samples| measured(technique, samples));
                let name = format!("{map_name} {} {}", view.name(), technique.name());
                assert!(many.hits > 0, "{name}: nothing was compared");
                for comparison in [&few, &some, &many] {
                    // Only a step into the ground ends a ray.
                    assert_eq!((comparison.invented, comparison.cap_hits), (0, 0), "{name}");
                }
                assert!(few.missed >= some.missed && some.missed >= many.missed, "{name}: ground missed");
                assert!(1000 * many.missed <= many.hits, "{name}: {} of {} missed", many.missed, many.hits);
                for share in [0.5, 0.99] {
                    let [few, some, many] = [&few, &some, &many].map(|comparison| comparison.quantile(share));
                    assert!(few > some && some >= many, "{name}: {few}, {some}, {many} cells at {share}");
                }
                assert!(many.quantile(0.99) < 0.05, "{name}: p99 {} cells", many.quantile(0.99));
                // What the cones are for: steps are saved where nothing is.
                let mut steps = |technique| {
                    let probe = renderer.probe(&sampled(technique, 1024, &scene), common::SIZE).unwrap();
                    probe.steps.iter().map(|&steps| u64::from(steps)).sum::<u64>()
                };
                let (along, uniform) = (steps(technique), steps(Technique::LinearBinary));
                assert!(4 * along < uniform, "{name}: {along} steps, uniformly {uniform}");
            }
        }
    }
}

#[test]
fn on_a_smooth_map_few_pixels_are_wrong_along_cones() {
    let wave = |index: u32| (f64::from(index % 256) * 0.05).sin() * (f64::from(index / 256) * 0.04).cos();
    let raw: Vec<f64> = (0..256 * 256).map(wave).collect();
    let map = Arc::new(HeightField::from_raw(256, 256, &raw).unwrap());
    let mut renderer = renderer(&map);
    for (technique, view) in ALONG_CONES.into_iter().flat_map(|technique| NamedView::MEASURED.map(|v| (technique, v))) {
        let scene = sampled(technique, 256, &scene_at(view, &map));
        let comparison = Comparison::of(&mut renderer, &scene, &map, common::SIZE);
        let name = format!("smooth {} {}", view.name(), technique.name());
        comparison.print(&name);
        assert!(comparison.hits > 0 && comparison.invented == 0, "{name}");
        assert!(2000 * comparison.missed <= comparison.hits, "{name}: {} missed", comparison.missed);
        // The last step along relaxed cones is as long as the cone, here up to a third of the map; 8 halvings of it are left.
        let most = if technique == Technique::Cone { 0.01 } else { 0.3 };
        assert!(comparison.quantile(0.99) < most, "{name}: p99 {} cells", comparison.quantile(0.99));
    }
}

/// A crater changes cones everywhere: with those of the ground before it rays would fly through its rim, or creep.
#[test]
fn cones_follow_the_craters() {
    let map = canyon();
    let list = craters(&map);
    for (technique, mode) in
        ALONG_CONES.into_iter().flat_map(|technique| [CraterMode::Baked, CraterMode::Layered].map(|m| (technique, m)))
    {
        let mut renderer = renderer(&map);
        let mut scene = sampled(technique, 512, &scene_at(NamedView::Graze, &map));
        scene.craters.mode = mode;
        renderer.probe(&scene, common::SIZE).unwrap();
        for count in [1, list.len(), 0, 2] {
            scene.craters.list = list[..count].to_vec();
            let edited = renderer.probe(&scene, common::SIZE).unwrap();
            let mut fresh = Renderer::new(common::gpu()).unwrap();
            fresh.set_terrain(Arc::clone(&map)).unwrap();
            let fresh = fresh.probe(&scene, common::SIZE).unwrap();
            assert!(
                edited.distance == fresh.distance && edited.steps == fresh.steps,
                "{technique:?}, {mode:?}, {count}"
            );
        }
        let displaced = match mode {
            CraterMode::Layered => {
                CraterLayer::rasterise(&scene.craters.list, &map, scene.craters.layer_resolution).apply_to(&map)
            }
            CraterMode::Baked => {
                let mut edited = EditedTerrain::new(Arc::clone(&map));
                edited.set_craters(&scene.craters.list);
                edited.field().clone()
            }
        };
        let comparison = Comparison::of(&mut renderer, &scene, &displaced, common::SIZE);
        comparison.print(&format!("{technique:?} {mode:?}"));
        assert!(comparison.invented == 0 && 1000 * comparison.missed <= comparison.hits);
        assert!(comparison.quantile(0.95) < 0.05, "{technique:?} {mode:?}: {}", comparison.quantile(0.95));
    }
}
