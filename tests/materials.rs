//! Materials on the ground: what their switches change, and that they change nothing else.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use common::pictures::{Tolerance, changed, count, share, sky};
use common::{canyon, gpu, picture, probe, renderer, scene_at, scratch_file};
use image::{Rgba, RgbaImage};
use relief::camera::NamedView;
use relief::gpu::Target;
use relief::render::{RenderError, Renderer};
use relief::scene::light::{Shadows, SkyModel};
use relief::scene::{ColourSource, LevelUnit, Scene, Technique};

/// Enough for a mean colour.
const SMALL: [u32; 2] = [120, 75];

fn painted(view: NamedView) -> Scene {
    let mut scene = scene_at(view, &canyon());
    scene.diffuse.source = ColourSource::Materials;
    scene
}

fn draw(scene: &Scene) -> RgbaImage {
    picture(&mut renderer(&canyon()), scene)
}

/// Mean colour of the pixels in a mask.
fn mean(picture: &RgbaImage, mask: impl Iterator<Item = bool>) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut pixels = 0.0;
    for (pixel, _) in picture.pixels().zip(mask).filter(|(_, set)| *set) {
        pixels += 1.0;
        sum.iter_mut().zip(pixel.0).for_each(|(sum, channel)| *sum += f64::from(channel));
    }
    sum.map(|sum| sum / f64::max(pixels, 1.0))
}

/// Only the ground's colour is another, and flipped back it is what it was, in the ledger, too.
#[test]
fn materials_paint_the_ground_and_nothing_else() {
    let mut renderer = renderer(&canyon());
    let plain = scene_at(NamedView::Start, &canyon());
    let scene = painted(NamedView::Start);
    let before = picture(&mut renderer, &plain);
    let ledger = renderer.ledger().clone();
    let distances = probe(&mut renderer, &plain);
    let after = picture(&mut renderer, &scene);
    let textures: Vec<_> = renderer.ledger().textures.iter().map(|texture| texture.name.clone()).collect();
    assert!(
        textures.iter().any(|name| name == "materials") && !textures.iter().any(|name| name == "diffuse"),
        "{textures:?}"
    );
    assert!(renderer.ledger().shader_defs.iter().any(|def| def == "MATERIALS"));
    let sky = sky(&distances);
    let differs = changed(&before, &after);
    assert!(!differs.iter().zip(&sky).any(|(&differs, &sky)| differs && sky), "the sky is another");
    assert!(count(&differs) as f64 > 0.9 * (sky.len() - count(&sky)) as f64);
    assert_eq!(probe(&mut renderer, &scene).distance, distances.distance);
    let again = picture(&mut renderer, &plain);
    assert!(again == before, "the picture is what it was");
    let back = renderer.ledger();
    assert_eq!((&back.textures, &back.shader_defs, back.draws), (&ledger.textures, &ledger.shader_defs, ledger.draws));
}

/// Each threshold puts its own material where it says.
#[test]
fn thresholds_move_their_materials() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let mut scene = painted(NamedView::Over);
    scene.lighting.enabled = false;
    scene.materials.snow_line = 2.0;
    let ground: Vec<bool> = sky(&renderer.probe(&scene, SMALL).unwrap()).iter().map(|sky| !sky).collect();
    let target = Target::new(&gpu(), SMALL);
    let small = |renderer: &mut Renderer, scene: &Scene| {
        renderer.draw(scene, &target).unwrap();
        target.read_color(&gpu()).unwrap()
    };
    let base = small(&mut renderer, &scene);
    let base_mean = mean(&base, ground.iter().copied());
    let mut with = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        let after = small(&mut renderer, &scene);
        let differs = share(&changed(&base, &after));
        (mean(&after, ground.iter().copied()), differs)
    };
    let (snow, _) = with(&|scene| scene.materials.snow_line = -1.0);
    assert!(snow.iter().all(|&channel| channel > 180.0), "snow everywhere is white: {snow:?}");
    let green = |[r, g, b]: [f64; 3]| 2.0 * g - r - b;
    let (bare, differs) = with(&|scene| scene.materials.tree_line = -1.0);
    assert!(green(bare) < green(base_mean) - 2.0 && differs > 0.1, "less green: {bare:?}, {base_mean:?}");
    let (rock, differs) = with(&|scene| scene.materials.rock_slope = 0.0);
    assert!(differs > 0.1 && rock != base_mean, "{rock:?}");
    let (sea, differs) = with(&|scene| scene.materials.sea_level = 2.0);
    assert!(differs > 0.1 && sea.iter().sum::<f64>() < snow.iter().sum(), "{sea:?}");
    let (sand, _) = with(&|scene| scene.materials.sand_line = 2.0);
    assert!(sand[0] > base_mean[0] && sand[0] > sand[2] + 25.0, "sand is yellow: {sand:?}");
    let (dry, differs) = with(&|scene| scene.materials.aridity = 1.0);
    assert!(differs > 0.1 && dry[0] > base_mean[0], "{dry:?}");
    // The canyon's metres are known: 1413 m are half of its height.
    let halves = [LevelUnit::Share, LevelUnit::Metres].map(|levels| {
        let [low, high] = map.range();
        let metres = |share: f64| (low + share * (high - low)) as f32;
        with(&|scene| {
            scene.materials.levels = levels;
            let level = |share: f64| if levels == LevelUnit::Share { share as f32 } else { metres(share) };
            scene.materials.snow_line = level(0.5);
            scene.materials.tree_line = level(0.4);
            scene.materials.sand_line = level(0.02);
            scene.materials.sea_level = level(0.0);
        })
        .0
    });
    assert!(halves[0].iter().zip(halves[1]).all(|(share, metres)| (share - metres).abs() < 0.3), "{halves:?}");
}

/// The relief bends the light, is gone without it, and leaves the shader at 0.
#[test]
fn relief_needs_light() {
    let mut scene = painted(NamedView::Valley);
    let shown = draw(&scene);
    scene.materials.relief = 0.0;
    let mut bare = renderer(&canyon());
    let without = picture(&mut bare, &scene);
    assert!(!bare.ledger().shader_defs.iter().any(|def| def == "MATERIALS_RELIEF"));
    assert!(share(&changed(&shown, &without)) > 0.3);
    scene.lighting.enabled = false;
    let unlit = draw(&scene);
    scene.materials.relief = 1.0;
    assert!(draw(&scene) == unlit, "without light there is nothing to bend");
}

/// Coverage maps decide where their weights are not 0.
#[test]
fn coverage_maps_say_where_materials_are() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let mut scene = painted(NamedView::Down);
    scene.lighting.enabled = false;
    let by_slope = picture(&mut renderer, &scene);
    // Snow in the west; nothing said in the east.
    let west = scratch_file("coverage-west.png");
    RgbaImage::from_fn(64, 8, |x, _| if x < 32 { Rgba([0, 0, 0, 255]) } else { Rgba([0; 4]) }).save(&west).unwrap();
    scene.materials.coverage = vec![west.clone()];
    let covered = picture(&mut renderer, &scene);
    assert!(renderer.ledger().textures.iter().any(|texture| texture.name == "coverage"));
    let differs = changed(&by_slope, &covered);
    let differing = |columns: std::ops::Range<usize>| {
        let width = common::SIZE[0] as usize;
        differs.iter().enumerate().filter(|(index, differs)| **differs && columns.contains(&(index % width))).count()
    };
    let (west_share, east_share) = (differing(0..150), differing(170..320));
    assert!(west_share > 5000 && east_share == 0, "{west_share} pixels in the west, {east_share} in the east");
    let sand = scratch_file("coverage-sand.png");
    RgbaImage::from_pixel(64, 8, Rgba([255, 0, 0, 0])).save(&sand).unwrap();
    scene.materials.coverage.push(sand);
    let both = picture(&mut renderer, &scene);
    assert!(share(&changed(&covered, &both)) > 0.2, "the second map counts, too");
    // A set that does not fit is refused with the file's name, and the picture stays.
    let larger = scratch_file("coverage-larger.png");
    RgbaImage::from_pixel(9, 9, Rgba([1; 4])).save(&larger).unwrap();
    scene.materials.coverage = vec![west, larger];
    let target = Target::new(&gpu(), common::SIZE);
    match renderer.draw(&scene, &target) {
        Err(error @ RenderError::Image { .. }) => {
            let message = error.to_string();
            assert!(message.contains("coverage-larger.png") && message.contains("64×8"), "{message}");
        }
        other => panic!("{other:?}"),
    }
}

/// Metres of a map that has none are asked for in vain, and it is said why.
#[test]
fn levels_in_metres_without_metres_are_refused() {
    let map = common::fractal();
    let mut scene = scene_at(NamedView::Start, &map);
    scene.diffuse.source = ColourSource::Materials;
    scene.materials.levels = LevelUnit::Metres;
    let target = Target::new(&gpu(), [32, 24]);
    let error = renderer(&map).draw(&scene, &target).unwrap_err().to_string();
    assert!(error.contains("metres of this map are not known") && error.contains("share"), "{error}");
}

/// A texture that is filtered by distance does not shimmer: a step of the eye by a fifth of a pixel changes little.
#[test]
fn distance_does_not_shimmer() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let mut at = |source: ColourSource, turn: f64| {
        let mut scene = scene_at(NamedView::Start, &map);
        scene.diffuse.source = source;
        scene.lighting.enabled = false;
        if let Some(camera) = &mut scene.camera {
            camera.yaw += turn;
        }
        picture(&mut renderer, &scene)
    };
    let pixel = 60.0 / f64::from(common::SIZE[1]);
    let tolerance = Tolerance { channel: 24, pixels: 0.02 };
    let (here, beside) = (at(ColourSource::Materials, 0.0), at(ColourSource::Materials, 0.2 * pixel));
    let difference = common::pictures::Difference::of(&here, &beside, tolerance).unwrap();
    println!("{} of {} pixels change by more than {}", difference.pixels, difference.compared, tolerance.channel);
    assert!(difference.is_within(tolerance), "{} pixels", difference.pixels);
}

/// Features that each have a buffer of constants: lavapipe writes beyond an array of its own where the fragments of a pass can
/// read more than three, and takes the program down with it.
#[test]
fn everything_together_is_drawn() {
    let map = canyon();
    let (mut renderer, target) = (renderer(&map), Target::new(&gpu(), [32, 24]));
    let techniques = [(false, Technique::MaxMipmap), (true, Technique::MaxMipmap), (false, Technique::Fractal)];
    for (deep, technique) in techniques {
        let mut scene = painted(NamedView::Start);
        scene.march.technique = technique;
        scene.lighting.shadows = Shadows::Hard;
        scene.skybox.model = SkyModel::Physical;
        (scene.land.contours, scene.occluder.enabled) = (true, true);
        scene.water.enabled = true;
        (scene.air.perspective, scene.air.fog, scene.flare.enabled) = (true, true, true);
        (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
        if let Some(camera) = scene.camera.as_mut().filter(|_| deep) {
            camera.fov = 1e-4;
        }
        renderer.draw(&scene, &target).unwrap();
        let defs = &renderer.ledger().shader_defs;
        for def in ["MATERIALS", "SHADOWS", "SKY_LIGHT", "LAND_CONTOURS", "AERIAL", "FOG", "CLOUD_SHADOWS"] {
            assert!(defs.iter().any(|own| own == def), "{def} is not in {defs:?}");
        }
        assert_eq!(defs.iter().any(|def| def == "DEEP_ZOOM"), deep);
        assert_eq!(renderer.ledger().passes.iter().any(|pass| pass == "water"), !deep);
        let picture = target.read_color(&gpu()).unwrap();
        // A deep zoom may show a single colour.
        assert!(deep || picture.pixels().any(|pixel| pixel != picture.get_pixel(0, 0)), "it shows something");
    }
}
