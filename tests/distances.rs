//! Pictures of given distances: the shading of a scene, with the hits found elsewhere.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use common::pictures::{Difference, Tolerance};
use common::{SIZE, canyon, craters, gpu, picture, probe, renderer, scene_at, scene_from};
use image::RgbaImage;
use relief::camera::NamedView;
use relief::gpu::Target;
use relief::heightfield::reference::Surface;
use relief::render::{RenderError, Renderer};
use relief::scene::{CraterMode, DebugView, Scene, Technique};

fn given(renderer: &mut Renderer, scene: &Scene, distances: &[f32]) -> RgbaImage {
    let target = Target::new(&gpu(), SIZE);
    renderer.draw_with_distances(scene, &target, distances).unwrap();
    target.read_color(&gpu()).unwrap()
}

/// Scenes with walls, from inside, below and above, of every technique and way of shading.
fn scenes() -> Vec<(&'static str, Scene)> {
    let map = canyon();
    let changed = |base: Scene, change: fn(&mut Scene)| {
        let mut scene = base;
        change(&mut scene);
        scene
    };
    let start = || scene_at(NamedView::Start, &map);
    let mut layered = start();
    layered.craters.mode = CraterMode::Layered;
    layered.craters.list = craters(&map);
    vec![
        ("start", start()),
        ("graze", scene_at(NamedView::Graze, &map)),
        ("valley", scene_at(NamedView::Valley, &map)),
        ("down", scene_at(NamedView::Down, &map)),
        ("from a side", scene_from(&map, [-0.4, 0.6, 0.5], [0.5, 0.4, 0.5], 60.0)),
        ("from below", scene_from(&map, [0.5, -1.0, -0.6], [0.5, 0.2, 0.5], 60.0)),
        ("linear", changed(start(), |scene| scene.march.technique = Technique::Linear)),
        ("misses kept", changed(start(), |scene| scene.march.discard_misses = false)),
        ("from the lid", changed(start(), |scene| scene.march.lower_start = false)),
        ("unlit", changed(start(), |scene| scene.lighting.enabled = false)),
        ("normals", changed(start(), |scene| scene.debug.view = DebugView::Normals)),
        ("distance", changed(start(), |scene| scene.debug.view = DebugView::Distance)),
        ("layered craters", layered),
    ]
}

#[test]
fn a_probes_own_distances_give_the_ordinary_picture() {
    let mut renderer = renderer(&canyon());
    for (name, scene) in scenes() {
        let ordinary = picture(&mut renderer, &scene);
        let distances = probe(&mut renderer, &scene).distance;
        let given = given(&mut renderer, &scene, &distances);
        let ledger = renderer.ledger();
        assert!(!ledger.passes.iter().any(|pass| pass == "beam"), "{name}: {:?}", ledger.passes);
        assert!(!ledger.textures.iter().any(|texture| texture.name == "pyramid" || texture.name == "beam"), "{name}");
        // A distance is rounded twice more on its way through the texture: by one step of a channel at most.
        let tolerance = Tolerance { channel: 1, pixels: 0.0005 };
        let difference = Difference::of(&ordinary, &given, tolerance).unwrap();
        println!("{name}: {} pixels differ, largest {}", difference.pixels, difference.largest);
        assert!(difference.is_within(tolerance), "{name}: {} pixels, {}", difference.pixels, difference.largest);
    }
}

/// An occluder hides and is hidden as in the ordinary picture: the depth is that of the given distances.
#[test]
fn an_occluder_meets_the_given_ground() {
    let mut renderer = renderer(&canyon());
    let mut scene = scene_at(NamedView::Start, &canyon());
    let distances = probe(&mut renderer, &scene).distance;
    scene.occluder.enabled = true;
    scene.occluder.size = 0.2;
    let (ordinary, given) = (picture(&mut renderer, &scene), given(&mut renderer, &scene, &distances));
    let tolerance = Tolerance { channel: 1, pixels: 0.0005 };
    let difference = Difference::of(&ordinary, &given, tolerance).unwrap();
    assert!(difference.is_within(tolerance), "{} pixels, {}", difference.pixels, difference.largest);
}

/// The f64 reference is fed in the same way.
#[test]
fn the_references_distances_give_the_exact_techniques_picture() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let scene = scene_at(NamedView::Valley, &map);
    let exact = picture(&mut renderer, &scene);
    let camera = scene.camera.unwrap();
    let reference = Surface::new(&map, map.box_size(None)).distances(&camera, SIZE, &|_| ());
    let reference: Vec<f32> = reference.into_iter().map(|distance| distance as f32).collect();
    let given = given(&mut renderer, &scene, &reference);
    let tolerance = Tolerance { channel: 2, pixels: 0.002 };
    let difference = Difference::of(&exact, &given, tolerance).unwrap();
    println!("{} pixels differ, largest {}", difference.pixels, difference.largest);
    assert!(difference.is_within(tolerance), "{} pixels, {}", difference.pixels, difference.largest);
}

#[test]
fn nothing_but_infinity_shows_the_sky_alone() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let scene = scene_at(NamedView::Start, &map);
    let nothing = given(&mut renderer, &scene, &vec![f32::INFINITY; (SIZE[0] * SIZE[1]) as usize]);
    let mut without_terrain = Renderer::new(gpu()).unwrap();
    assert!(nothing == picture(&mut without_terrain, &scene), "more than the sky is there");
}

#[test]
fn a_wrong_number_of_distances_is_refused() {
    let mut renderer = renderer(&canyon());
    let target = Target::new(&gpu(), SIZE);
    let scene = scene_at(NamedView::Start, &canyon());
    let error = renderer.draw_with_distances(&scene, &target, &[1.0; 7]).unwrap_err();
    assert!(matches!(error, RenderError::Distances { given: 7, width: 320, height: 240 }), "{error}");
    assert!(error.to_string().contains("76800"), "{error}");
}
