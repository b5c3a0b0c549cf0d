//! The sea: where its light goes, against the reference in f64, pixel by pixel, and what each of its switches changes.
//!
//! `cargo test --test water -- --nocapture` prints the figures.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::{canyon, gpu, renderer};
use glam::DVec3;
use image::RgbaImage;
use rayon::prelude::*;
use relief::camera::{Camera, NamedView, Ray};
use relief::gpu::Target;
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::reference::Surface;
use relief::heightfield::sea::{Leg, Path, Sea};
use relief::heightfield::{HeightField, HoleMask};
use relief::render::{LegEnd, RenderError, Renderer, WaterPath};
use relief::scene::{CraterMode, LevelUnit, Scene, Technique};

/// Size of the pictures.
const SIZE: [u32; 2] = [112, 70];

/// How far a length may be off, in sides of the map: a hundredth of a cell of the canyon.
const LENGTH: f64 = 2e-5;

/// Rays of a pixel's own width in this many parts may see another side of an edge.
const PART_OF_PIXEL: f64 = 0.01;

/// Light that counts for less is not followed by the shader, and so not compared.
const LEAST: f64 = 0.003;

fn map_of(side: u32, at: impl Fn(u32, u32) -> f64) -> Arc<HeightField> {
    let raw: Vec<f64> = (0..side * side).map(|index| at(index % side, index / side)).collect();
    Arc::new(HeightField::from_raw(side, side, &raw).unwrap())
}

/// A map with islands and bays.
fn islands() -> Arc<HeightField> {
    Arc::new(generate(Kind::Perlin, 257, 5))
}

/// `scene` with a still sea up to a share of the height.
fn sea(camera: Camera, level: f32) -> Scene {
    let mut scene = Scene { camera: Some(camera), ..Scene::default() };
    scene.water.enabled = true;
    scene.water.level = Some(level);
    (scene.water.waves, scene.water.foam, scene.water.bubbles) = (0.0, 0.0, false);
    scene
}

fn draw(renderer: &mut Renderer, scene: &Scene) -> RgbaImage {
    let target = Target::new(&gpu(), SIZE);
    renderer.draw(scene, &target).unwrap();
    target.read_color(&gpu()).unwrap()
}

fn shows_water(renderer: &Renderer) -> bool {
    renderer.ledger().passes.iter().any(|pass| pass == "water")
}

/// Cameras over and around the map, and in its water `depth` shares of the height under a sea at `level`.
fn views(map: &HeightField, extent: DVec3, level: f64) -> Vec<(&'static str, Camera)> {
    let at = |eye: [f64; 3], target: [f64; 3]| {
        Camera::look_at(DVec3::from(eye) * extent, DVec3::from(target) * extent, 60.0)
    };
    let (u, v) = map.lowest_interior();
    let under = level - 0.3 * (level - map.surface_height(u, v));
    vec![
        ("over", NamedView::Over.camera(map, extent)),
        ("graze", NamedView::Graze.camera(map, extent)),
        ("beside", at([0.5, 1.2, 1.8], [0.5, 0.3, 0.5])),
        ("low", at([0.5, level + 0.02, 1.3], [0.5, level, 0.5])),
        ("under, level", at([u, under, v], [u + 0.3, under, v - 0.2])),
        ("under, up", at([u, under, v], [u + 0.1, under + 1.0, v - 0.1])),
        ("under, down", at([u, under, v], [u + 0.2, under - 0.5, v + 0.2])),
    ]
}

#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    /// Pixels whose ray meets water before ground.
    compared: u32,
    split: u32,
    /// The reference itself is of two minds a hundredth of a pixel aside.
    excused: u32,
    wrong: u32,
}

fn agrees(found: LegEnd, wanted: Leg, side: f64) -> bool {
    match (found, wanted) {
        (LegEnd::None, Leg::None) | (LegEnd::Nothing, Leg::Nothing) => true,
        (LegEnd::At(found), Leg::At(wanted)) => (f64::from(found) - wanted).abs() <= LENGTH * side,
        _ => false,
    }
}

/// Whether a path found by the GPU is that of the reference. Light of a weight below [`LEAST`] does not count.
fn is_path(found: Option<WaterPath>, wanted: Option<Path>, side: f64) -> bool {
    let (Some(found), Some(wanted)) = (found, wanted) else { return found.is_none() && wanted.is_none() };
    let [over, under] =
        if wanted.begins_in_water { [1.0 - wanted.share, wanted.share] } else { [wanted.share, 1.0 - wanted.share] };
    found.begins_in_water == wanted.begins_in_water
        && agrees(found.first, wanted.first, side)
        && (over < LEAST || agrees(found.air, wanted.air, side))
        && (under < LEAST || agrees(found.water, wanted.water, side))
}

/// Whether `found` lies between the lengths of `around`.
fn is_between(found: LegEnd, around: &[Leg], side: f64) -> bool {
    let lengths = || around.iter().filter_map(|leg| if let Leg::At(length) = leg { Some(*length) } else { None });
    let (low, high) = (lengths().fold(f64::MAX, f64::min), lengths().fold(f64::MIN, f64::max));
    match found {
        LegEnd::At(length) => (low - LENGTH * side..=high + LENGTH * side).contains(&f64::from(length)),
        LegEnd::Nothing => around.contains(&Leg::Nothing),
        LegEnd::None => true,
    }
}

fn judge(sea: &Sea<'_>, surface: &Surface<'_>, camera: &Camera, side: f64, found: &[Option<WaterPath>]) -> Judged {
    let judge = |(index, found): (usize, &Option<WaterPath>)| {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let ray = |dx: f64, dy: f64| camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE);
        let unit = |ray: Ray| Ray { direction: ray.direction.normalize(), ..ray };
        let wanted = sea.path(&ray(0.0, 0.0));
        let mut judged = Judged::default();
        // Ground before the water hides it, and is not the sea's matter.
        let first = wanted.map_or(Leg::None, |path| path.first);
        let ground = surface.intersect(&unit(ray(0.0, 0.0))).map_or(f64::INFINITY, |hit| hit.depth);
        if let (Leg::At(first), false) = (first, wanted.is_some_and(|path| path.begins_in_water))
            && ground < first
        {
            return judged;
        }
        judged.compared = u32::from(wanted.is_some());
        judged.split = u32::from(wanted.is_some_and(|path| path.share > 0.0));
        if is_path(*found, wanted, side) {
            return judged;
        }
        let beside = [(PART_OF_PIXEL, 0.0), (-PART_OF_PIXEL, 0.0), (0.0, PART_OF_PIXEL), (0.0, -PART_OF_PIXEL)];
        let around: Vec<_> = beside.iter().map(|&(dx, dy)| sea.path(&ray(dx, dy))).chain([wanted]).collect();
        let doubtful = match found {
            None => around.contains(&None),
            Some(found) => {
                let legs = |of: fn(&Path) -> Leg| around.iter().flatten().map(of).collect::<Vec<_>>();
                is_between(found.first, &legs(|path| path.first), side)
                    && is_between(found.air, &legs(|path| path.air), side)
                    && is_between(found.water, &legs(|path| path.water), side)
            }
        };
        if doubtful {
            judged.excused = 1;
        } else {
            println!("pixel {x},{y}: {found:?}, not {wanted:?}, around {around:?}");
            judged.wrong = 1;
        }
        judged
    };
    let add = |a: Judged, b: Judged| Judged {
        compared: a.compared + b.compared,
        split: a.split + b.split,
        excused: a.excused + b.excused,
        wrong: a.wrong + b.wrong,
    };
    found.par_iter().enumerate().map(judge).reduce(Judged::default, add)
}

#[test]
fn light_goes_where_the_reference_says() {
    let flag = |on: bool| f64::from(u8::from(on));
    let maps = [
        ("canyon", canyon(), None, 0.35),
        ("islands", islands(), Some(0.2), 0.5),
        ("needles", map_of(65, |x, z| flag(x % 7 == 3 && z % 7 == 3)), Some(0.2), 0.4),
        ("staircase", map_of(65, |x, _| f64::from(x / 8)), Some(0.3), 0.6),
        ("drowned", islands(), Some(0.1), 1.3),
    ];
    let mut all = Judged::default();
    for (name, map, scale, level) in maps {
        let extent = map.box_size(scale);
        let mut renderer = renderer(&map);
        let surface = Surface::new(&map, extent);
        let reference = Sea::new(surface, f64::from(level as f32) * extent.y);
        for (view, camera) in views(&map, extent, level) {
            let mut scene = sea(camera, level as f32);
            scene.terrain.height_scale = scale;
            let found = renderer.probe_water(&scene, SIZE).unwrap();
            let judged = judge(&reference, &surface, &camera, extent.max_element(), &found);
            println!("{name:10} {view:13} {judged:?}");
            assert!(judged.excused <= 8, "{name}, {view}: {} excused", judged.excused);
            all.wrong += judged.wrong;
            all.compared += judged.compared;
            all.split += judged.split;
            all.excused += judged.excused;
        }
    }
    println!("{} pixels of water, {} of them split, {} excused", all.compared, all.split, all.excused);
    assert_eq!(all.wrong, 0);
    assert!(all.compared > 60_000 && all.split > 30_000);
}

/// Off, or below the lowest ground, it is nowhere: not in the picture, and not in the ledger.
#[test]
fn no_sea_is_the_picture_without_one() {
    let map = islands();
    let mut renderer = renderer(&map);
    let base = Scene { camera: Some(NamedView::Over.camera(&map, map.box_size(None))), ..Scene::default() };
    let without = draw(&mut renderer, &base);
    let ledger = renderer.ledger().clone();
    let mut off = base.clone();
    (off.water.level, off.water.waves, off.water.moving) = (Some(0.6), 0.9, true);
    let mut below = off.clone();
    (below.water.enabled, below.water.level) = (true, Some(0.0));
    for scene in [&off, &below] {
        assert_eq!(draw(&mut renderer, scene), without);
        assert_eq!(renderer.ledger().passes, ledger.passes);
        assert_eq!((renderer.ledger().draws, renderer.ledger().texture_bytes), (ledger.draws, ledger.texture_bytes));
        assert_eq!(renderer.ledger().pipelines, ledger.pipelines, "no pipeline of the sea is built");
    }
    off.water.enabled = true;
    assert!(draw(&mut renderer, &off) != without && shows_water(&renderer));
    assert_eq!(renderer.ledger().draws, ledger.draws + 1);
    assert_eq!(renderer.ledger().texture_bytes, ledger.texture_bytes, "it needs no texture of its own");
    // What is measured is the ground.
    assert_eq!(renderer.probe(&off, SIZE).unwrap().distance, renderer.probe(&base, SIZE).unwrap().distance);
    off.debug.view = relief::scene::DebugView::Steps;
    draw(&mut renderer, &off);
    assert!(!shows_water(&renderer));
}

/// Pixels of two pictures that differ.
fn changed(a: &RgbaImage, b: &RgbaImage) -> Vec<usize> {
    a.pixels().zip(b.pixels()).enumerate().filter(|(_, (a, b))| a != b).map(|(index, _)| index).collect()
}

/// Each switch shows in the water, and nowhere else.
#[test]
fn every_switch_changes_the_water_alone() {
    let map = islands();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let (u, v) = map.lowest_interior();
    let middle = DVec3::new(u, 0.5, v) * extent;
    let mut base = sea(Camera::look_at(middle + DVec3::new(0.1, 0.15, 0.25), middle, 60.0), 0.55);
    base.occluder.enabled = true;
    base.occluder.position = Some(middle + DVec3::new(0.0, 0.1, -0.1));
    (base.water.waves, base.water.foam) = (0.4, 0.5);
    let eye = DVec3::new(u, 0.3, v) * extent;
    let under = Camera::look_at(eye, eye + DVec3::new(0.3, 0.03, -0.2), 60.0);
    type Change<'a> = (&'a str, &'a dyn Fn(&mut Scene));
    let changes: [Change<'_>; 11] = [
        ("WATER_REFLECTION", &|scene| scene.water.reflection = false),
        ("WATER_REFRACTION", &|scene| scene.water.refraction = false),
        ("WATER_WAVES", &|scene| scene.water.waves = 0.0),
        ("WATER_FOAM", &|scene| scene.water.foam = 0.0),
        ("WATER_BUBBLES", &|scene| (scene.water.bubbles, scene.camera) = (true, Some(under))),
        ("", &|scene| scene.water.level = Some(0.5)),
        ("", &|scene| scene.water.clarity = 0.3),
        ("", &|scene| scene.water.tint = 1.0),
        ("", &|scene| scene.water.wave_length = 0.03),
        ("", &|scene| scene.water.time = 1.5),
        ("", &|scene| scene.water.waves = 0.1),
    ];
    for (def, change) in changes {
        let mut scene = base.clone();
        change(&mut scene);
        let mut before = base.clone();
        before.camera = scene.camera;
        let with = draw(&mut renderer, &before);
        let find = |renderer: &mut Renderer, scene: &Scene| renderer.probe_water(scene, SIZE).unwrap();
        let (old, new) = (find(&mut renderer, &before), find(&mut renderer, &scene));
        let without = draw(&mut renderer, &scene);
        let differing = changed(&with, &without);
        assert!(differing.len() > 20, "{def}: {} pixels differ", differing.len());
        assert!(differing.iter().all(|&index| old[index].is_some() || new[index].is_some()), "{def}: water alone");
        if !def.is_empty() {
            let pipelines = renderer.ledger().pipelines.clone();
            let has = |name: &String| name.split([' ', '[', ']']).any(|own| own == def);
            let seas: Vec<_> = pipelines.iter().filter(|name| name.starts_with("water")).collect();
            assert!(seas.iter().any(|name| has(name)) && !seas.iter().all(|name| has(name)), "{def}: {seas:?}");
        }
    }
}

/// Down through the surface and up again leads to the same picture, and on the way nothing shows but ground, water and sky.
#[test]
fn the_surface_has_no_seam() {
    let map = islands();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let (u, v) = map.lowest_interior();
    let level = 0.6;
    // Eyes at a height over the surface, which look a little down.
    let at = |over: f64| {
        let eye = DVec3::new(u * extent.x, f64::from(level) * extent.y + over, v * extent.z);
        Camera::look_at(eye, eye + DVec3::new(0.3, -0.02, -0.2), 60.0)
    };
    let mut scene = sea(at(0.0), level);
    scene.skybox.enabled = false;
    scene.water.refraction = false;
    let heights = [0.05, 1e-3, 1e-6, 1e-9, 0.0, -1e-9, -1e-6, -1e-3, -0.05];
    let way: Vec<f64> = heights.iter().chain(heights.iter().rev()).copied().collect();
    let pictures: Vec<_> = way
        .iter()
        .map(|&over| {
            scene.camera = Some(at(over));
            draw(&mut renderer, &scene)
        })
        .collect();
    for (index, &over) in heights.iter().enumerate() {
        assert_eq!(pictures[index], pictures[way.len() - 1 - index], "the way back at {over}");
    }
    for over in [1e-6, 1e-9, 0.0, -1e-9, -1e-6] {
        scene.camera = Some(at(over));
        let found = renderer.probe_water(&scene, SIZE).unwrap();
        // Every ray that looks down meets water at once; of those that look up, from below all do, and from above none.
        for (index, path) in found.iter().enumerate() {
            let ray = scene.camera.unwrap().ray(
                (index as u32 % SIZE[0]) as f64 + 0.5,
                (index as u32 / SIZE[0]) as f64 + 0.5,
                SIZE,
            );
            if ray.direction.y.abs() > 1e-3 {
                let wanted = ray.direction.y < 0.0 || over < 0.0;
                assert_eq!(path.is_some(), wanted, "{over}: pixel {index}, {:?}", ray.direction);
            }
        }
    }
    // Straight down the surface mirrors 2 %: from right above and right below, the same sea bed.
    let down = |over: f64| Camera { pitch: -89.0, ..at(over) };
    let mut seen = |over: f64| {
        scene.camera = Some(down(over));
        draw(&mut renderer, &scene)
    };
    let (above, below) = (seen(1e-7), seen(-1e-7));
    let furthest = above.pixels().zip(below.pixels()).flat_map(|(a, b)| (0..3).map(|c| a.0[c].abs_diff(b.0[c]))).max();
    println!("straight down: {furthest:?} of 255 at most");
    assert!(furthest.unwrap() <= 24);
}

/// Whatever finds the ground, and whatever is done to it, the sea lies over it.
#[test]
fn every_technique_holes_and_craters_have_the_sea() {
    let map = islands();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let mut scene = sea(NamedView::Over.camera(&map, extent), 0.55);
    let exact = draw(&mut renderer, &scene);
    for technique in Technique::CHOICES {
        scene.march.technique = technique;
        (scene.march.samples_min, scene.march.samples_max) = (1000, 2000);
        let picture = draw(&mut renderer, &scene);
        assert!(shows_water(&renderer), "{technique:?}");
        let other = changed(&exact, &picture).len() as f64 / f64::from(SIZE[0] * SIZE[1]);
        println!("{technique:?}: {:.1} % other pixels", other * 100.0);
        assert!(technique == Technique::Smooth || other < 0.25, "{technique:?}");
    }
    scene.march.technique = Technique::MaxMipmap;
    // A crater on dry land that reaches below the sea is full of water, baked or layered.
    let (x, z) = (0..100)
        .map(|index| (f64::from(index % 10) / 10.0 + 0.05, f64::from(index / 10) / 10.0 + 0.05))
        .find(|&(u, v)| (0.58..0.7).contains(&map.surface_height(u, v)))
        .unwrap();
    let crater = relief::heightfield::Crater { x: x * extent.x, z: z * extent.z, radius: 0.05, depth: 0.5, rim: 0.0 };
    let eye = DVec3::new(crater.x, extent.y * 2.0, crater.z);
    scene.camera = Some(Camera::look_at(eye, eye + DVec3::new(0.0, -1.0, -0.01), 30.0));
    let middle = (SIZE[0] * (SIZE[1] / 2) + SIZE[0] / 2) as usize;
    let is_wet = |renderer: &mut Renderer, scene: &Scene| renderer.probe_water(scene, SIZE).unwrap()[middle].is_some();
    assert!(!is_wet(&mut renderer, &scene));
    scene.craters.list = vec![crater];
    for mode in [CraterMode::Baked, CraterMode::Layered] {
        scene.craters.mode = mode;
        draw(&mut renderer, &scene);
        assert!(is_wet(&mut renderer, &scene), "{mode:?}");
    }
    // Over a hole the sea has no bed.
    let side = 33;
    let mut holes = HoleMask::new(side, side);
    (12..20).for_each(|row| (12..20).for_each(|column| holes.insert((row * side + column) as usize)));
    let raw: Vec<f64> = (0..side * side).map(|index| f64::from(u8::from(index % side == 0))).collect();
    let holed = Arc::new(HeightField::from_raw_with_holes(side, side, &raw, Some(holes)).unwrap());
    renderer.set_terrain(holed).unwrap();
    let mut scene = sea(Camera::look_at(DVec3::new(0.5, 1.5, 0.51), DVec3::new(0.5, 0.0, 0.5), 60.0), 0.4);
    scene.terrain.height_scale = Some(0.2);
    let found = renderer.probe_water(&scene, SIZE).unwrap();
    let ends = |end: LegEnd| found.iter().flatten().filter(|path| path.water == end).count();
    assert!(ends(LegEnd::Nothing) > 50 && found[middle].is_some_and(|path| path.water == LegEnd::Nothing));
    assert!(found.iter().flatten().any(|path| matches!(path.water, LegEnd::At(_))));
    draw(&mut renderer, &scene);
}

/// What cannot be drawn is refused or left out, as documented.
#[test]
fn metres_deep_zooms_and_the_cube() {
    let map = islands();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let mut scene = sea(NamedView::Over.camera(&map, extent), 0.55);
    scene.water.levels = LevelUnit::Metres;
    let error = renderer.draw(&scene, &Target::new(&gpu(), SIZE)).unwrap_err();
    assert!(matches!(error, RenderError::Impossible { .. }), "{error}");
    assert!(error.to_string().contains("water.levels"), "{error}");
    scene.water.levels = LevelUnit::Share;
    scene.camera.as_mut().unwrap().fov = 1e-4;
    draw(&mut renderer, &scene);
    assert!(!shows_water(&renderer), "not in a deep zoom");
    scene.camera.as_mut().unwrap().fov = 60.0;
    scene.water.waves = f32::NAN;
    assert!(renderer.draw(&scene, &Target::new(&gpu(), SIZE)).is_err());
    scene.water.waves = 0.0;

    // A cube that floats over the middle of a flat sea: seen in the mirror below it, and from under water.
    let flat = map_of(9, |x, z| f64::from(u8::from(x == 0 && z == 0)));
    renderer.set_terrain(flat).unwrap();
    scene.terrain.height_scale = Some(0.2);
    scene.water.level = Some(0.5);
    scene.occluder.rotation = DVec3::ZERO;
    scene.occluder.position = Some(DVec3::new(0.5, 0.16, 0.5));
    for (eye, target) in [([0.5, 0.2, 0.9], [0.5, 0.05, 0.5]), ([0.5, 0.02, 0.56], [0.5, 0.1, 0.53])] {
        scene.camera = Some(Camera::look_at(DVec3::from(eye), DVec3::from(target), 60.0));
        scene.occluder.enabled = true;
        let with = draw(&mut renderer, &scene);
        let water = renderer.probe_water(&scene, SIZE).unwrap();
        scene.occluder.enabled = false;
        let without = draw(&mut renderer, &scene);
        let seen = changed(&with, &without).into_iter().filter(|&index| water[index].is_some()).count();
        println!("from {eye:?}: {seen} pixels of water show the cube");
        assert!(seen > 100);
    }
}

/// A sea without a bed to be seen, over which the eye looks towards low ground.
fn dark_sea(map: &HeightField) -> Scene {
    let extent = map.box_size(Some(0.3));
    let eye = DVec3::new(0.5, 0.5, 0.9) * extent + DVec3::new(0.0, 0.02, 0.0);
    let mut scene = sea(Camera { eye, yaw: 0.0, pitch: -25.0, fov: 40.0 }, 0.5);
    (scene.terrain.height_scale, scene.water.clarity) = (Some(0.3), 2e-4);
    scene
}

fn mean_difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let sum: u64 = a.pixels().zip(b.pixels()).map(|(a, b)| u64::from(a.0[1].abs_diff(b.0[1]))).sum();
    sum as f64 / f64::from(a.width() * a.height())
}

/// What lies before the sky is seen in the water, too, and through its surface from below.
#[test]
fn the_water_mirrors_clouds_and_fog() {
    let map = map_of(17, |x, z| f64::from(u8::from(x == 0 && z == 0)));
    let mut renderer = renderer(&map);
    let base = dark_sea(&map);
    let mut under = base.clone();
    under.water.clarity = 10.0;
    let eye = DVec3::new(0.5, 0.1, 0.5);
    under.camera = Some(Camera { eye, yaw: 0.0, pitch: 85.0, fov: 60.0 });
    for (name, scene, least) in [("above", &base, 2.0), ("below", &under, 4.0)] {
        let plain = draw(&mut renderer, scene);
        let has_def =
            |renderer: &Renderer| renderer.ledger().pipelines.iter().any(|name| name.contains("WATER_CLOUDS"));
        assert!(name == "below" || !has_def(&renderer), "{name}: absent where there are no clouds");
        let mut cloudy = scene.clone();
        (cloudy.clouds.enabled, cloudy.clouds.cover) = (true, 0.9);
        let clouds = draw(&mut renderer, &cloudy);
        assert!(has_def(&renderer), "{name}");
        let by_clouds = mean_difference(&plain, &clouds);
        println!("{name}: clouds change bytes by {by_clouds:.1} in the mean");
        assert!(by_clouds > least, "{name}: {by_clouds}");
        cloudy.clouds.time = 900.0;
        assert!(changed(&clouds, &draw(&mut renderer, &cloudy)).len() > 100, "{name}: they move");
    }
    // Nearly upwards the surface lets nearly all light through: from below clouds look as they do where there is no sea.
    (under.clouds.enabled, under.clouds.cover, under.water.refraction) = (true, 0.9, false);
    let through = draw(&mut renderer, &under);
    under.water.enabled = false;
    let by_water = mean_difference(&through, &draw(&mut renderer, &under));
    println!("the surface changes clouds by {by_water:.1} bytes in the mean");
    assert!(by_water < 8.0, "{by_water}");
    // Right over the surface there is no fog between it and the eye: what changes is the mirror.
    let mut low = base.clone();
    let camera = low.camera.as_mut().unwrap();
    (camera.eye.y, camera.pitch) = (0.15 + 1e-5, -20.0);
    let clear = draw(&mut renderer, &low);
    low.air.fog = true;
    (low.air.fog_density, low.air.fog_base, low.air.fog_scale) = (2.0, 1600.0, 100.0);
    let by_fog = mean_difference(&clear, &draw(&mut renderer, &low));
    println!("fog changes bytes by {by_fog:.1} in the mean");
    assert!(by_fog > 2.0);
}

/// The sun glitters where it is seen from the water, and only there.
#[test]
fn hills_hide_the_suns_glint() {
    // A wall in the north of the western half.
    let map = map_of(33, |x, z| f64::from(u8::from(x < 16 && (4..6).contains(&z))));
    let extent = map.box_size(Some(0.3));
    let mut renderer = renderer(&map);
    let mut scene = dark_sea(&map);
    (scene.water.reflection, scene.water.waves, scene.skybox.enabled) = (false, 1.0, false);
    (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (0.0, 30.0);
    (scene.lighting.diffuse, scene.lighting.ambient) = (1.5, 0.1);
    let eye = DVec3::new(0.5, 0.4, 0.9);
    scene.camera = Some(Camera::look_at(eye, DVec3::new(0.5, 0.15, 0.35), 50.0));
    let free = draw(&mut renderer, &scene);
    scene.lighting.shadows = relief::scene::light::Shadows::Hard;
    let shaded = draw(&mut renderer, &scene);
    let paths = renderer.probe_water(&scene, SIZE).unwrap();
    let (surface, sun) = (Surface::new(&map, extent), scene.lighting.sun_direction());
    let (mut dark, mut lit, mut wrong) = (0, 0, 0);
    for (index, path) in paths.iter().enumerate() {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let Some(WaterPath { begins_in_water: false, first: LegEnd::At(first), .. }) = path else { continue };
        let ray = scene.camera.unwrap().ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
        let direction = ray.direction.normalize();
        if surface.intersect(&Ray { direction, ..ray }).is_some_and(|hit| hit.depth < f64::from(*first)) {
            continue;
        }
        let origin = ray.origin + direction * (f64::from(*first) - 1e-5);
        let hidden = surface.intersect(&Ray { origin, direction: sun }).is_some();
        let (free, shaded) = (free.get_pixel(x, y).0[1], shaded.get_pixel(x, y).0[1]);
        // A glitter that shows.
        dark += u32::from(hidden && free > shaded + 10);
        lit += u32::from(!hidden && shaded > 100);
        wrong += u32::from(!hidden && free.abs_diff(shaded) > 1);
    }
    println!("{dark} pixels without the glint that they had, {lit} with it, {wrong} wrong");
    assert!(dark > 100 && lit > 100 && wrong <= 4, "{dark}, {lit}, {wrong}");
}

/// Where nothing casts a shadow, it makes no difference that shadows are looked for: not from under water either, up through
/// its surface, nor through a cut side of it.
#[test]
fn light_in_the_water_is_not_counted_again_for_shadows() {
    let map = map_of(17, |x, z| f64::from(u8::from(x == 0 && z == 0)));
    let mut renderer = renderer(&map);
    let mut scene = dark_sea(&map);
    (scene.water.clarity, scene.water.tint, scene.skybox.enabled) = (0.5, 1.0, false);
    (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (180.0, 50.0);
    let inside = Camera { eye: DVec3::new(0.5, 0.05, 0.5), yaw: 180.0, pitch: 80.0, fov: 70.0 };
    let beside = Camera { eye: DVec3::new(0.5, 0.05, 1.3), yaw: 0.0, pitch: 12.0, fov: 40.0 };
    for (name, camera) in [("inside", inside), ("beside", beside)] {
        scene.camera = Some(camera);
        scene.lighting.shadows = relief::scene::light::Shadows::Off;
        let free = draw(&mut renderer, &scene);
        let paths = renderer.probe_water(&scene, SIZE).unwrap();
        let meets_surface = |path: &&WaterPath| path.air != LegEnd::None || path.water != LegEnd::None;
        let up = paths.iter().flatten().filter(|path| path.begins_in_water).filter(meets_surface).count();
        assert!(up > 200, "{name}: {up} rays meet the surface from below");
        scene.lighting.shadows = relief::scene::light::Shadows::Hard;
        let looked_for = draw(&mut renderer, &scene);
        let furthest =
            free.pixels().zip(looked_for.pixels()).flat_map(|(a, b)| (0..3).map(|c| a.0[c].abs_diff(b.0[c])));
        assert!(furthest.max() <= Some(1), "{name}: {} pixels differ", changed(&free, &looked_for).len());
    }
}
