//! Shadows against the reference in f64, pixel by pixel, and by what they must not change.
//!
//! `cargo test --test shadows -- --nocapture` prints the figures.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::{canyon, craters, gpu, renderer};
use glam::{DMat4, DQuat, DVec3, EulerRot};
use image::RgbaImage;
use rayon::prelude::*;
use relief::camera::{Camera, NamedView};
use relief::gpu::Target;
use relief::heightfield::reference::Surface;
use relief::heightfield::{CraterLayer, EditedTerrain, HeightField, HoleMask};
use relief::render::{Baking, Renderer};
use relief::scene::light::Shadows;
use relief::scene::{CraterMode, Scene, Technique};

/// Size of the pictures.
const SIZE: [u32; 2] = [112, 70];

/// How far the place that a pixel shows may be from the true one, in sides of the map: what single precision makes of a
/// ray (2.6e-6 at most, see the bound of the rays' displacement), and of a place on the map.
const PLACE: f64 = 4e-6;

/// How far the slope of a ray to the sun may be off: the rounding of heights over the ways that they count over.
const SLOPE: f64 = 4e-6;

/// Rays of a pixel's own width in this many parts may see another side of an edge.
const PART_OF_PIXEL: f64 = 0.01;

fn map_of(width: u32, height: u32, at: impl Fn(u32, u32) -> f64) -> HeightField {
    let raw: Vec<f64> = (0..height).flat_map(|z| (0..width).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
    HeightField::from_raw(width, height, &raw).unwrap()
}

fn noise(x: u32, z: u32) -> f64 {
    let mut bits = x.wrapping_mul(0x9e37_79b9) ^ z.wrapping_mul(0x85eb_ca6b);
    for _ in 0..3 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    f64::from(bits >> 8) / f64::from(1u32 << 24)
}

/// The Grand Canyon, and maps whose cells are as stiff as can be.
fn maps() -> Vec<(&'static str, Arc<HeightField>, Option<f64>)> {
    let flag = |on: bool| f64::from(u8::from(on));
    let side = 65;
    let unit = |i: u32| f64::from(i) / f64::from(side - 1);
    vec![
        ("canyon", canyon(), None),
        ("needles", Arc::new(map_of(side, side, |x, z| flag(x % 7 == 3 && z % 7 == 3))), Some(0.2)),
        ("tall needles", Arc::new(map_of(side, side, |x, z| flag(x % 7 == 3 && z % 7 == 3))), Some(3.0)),
        ("wall", Arc::new(map_of(side, side, |x, z| flag(x == 21 && !(33..37).contains(&z)))), Some(0.2)),
        (
            "cliff",
            Arc::new(map_of(side, side, |x, z| if x < 32 { 0.04 * unit(z) } else { 1.0 - 0.04 * unit(z) })),
            Some(0.3),
        ),
        ("checkerboard", Arc::new(map_of(33, 33, |x, z| f64::from((x + z) % 2))), Some(0.02)),
        ("staircase", Arc::new(map_of(side, side, |x, _| f64::from(x / 8))), Some(0.3)),
        ("noise", Arc::new(map_of(side, side, noise)), Some(0.1)),
    ]
}

/// White ground in sunlight and nothing else: a pixel is black where the sun is hidden or behind the slope.
fn sunlit(camera: Camera, height_scale: Option<f64>, [azimuth, elevation]: [f32; 2]) -> Scene {
    let mut scene = Scene { camera: Some(camera), ..Scene::default() };
    scene.terrain.height_scale = height_scale;
    (scene.diffuse.enabled, scene.skybox.enabled) = (false, false);
    let light = &mut scene.lighting;
    (light.ambient, light.diffuse, light.specular) = (0.0, 2.0, 0.0);
    (light.sun_azimuth, light.sun_elevation) = (azimuth, elevation);
    scene
}

fn draw(renderer: &mut Renderer, scene: &Scene, shadows: Shadows) -> RgbaImage {
    let mut scene = scene.clone();
    scene.lighting.shadows = shadows;
    let target = Target::new(&gpu(), SIZE);
    renderer.draw(&scene, &target).unwrap();
    target.read_color(&gpu()).unwrap()
}

/// Least sRGB value whose pixel is taken to face the sun: darker ones hide what they lose.
const FACING: u8 = 12;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Judged {
    compared: u32,
    dark: u32,
    /// The reference itself is of two minds.
    excused: u32,
    wrong: u32,
}

/// Compares hard shadows with the reference.
fn judge(map: &HeightField, scene: &Scene, off: &RgbaImage, hard: &RgbaImage) -> Judged {
    let extent = map.box_size(scene.terrain.height_scale);
    let surface = Surface::new(map, extent);
    let camera = scene.camera.unwrap();
    let azimuth = f64::from(scene.lighting.sun_azimuth).to_radians();
    let tangent = scene.lighting.sun_place().elevation.to_radians().tan();
    let near = 1e-9 * extent.max_element();
    let side = extent.x.max(extent.z);
    let pixels: Vec<u32> = (0..SIZE[0] * SIZE[1]).collect();
    let judge = |&index: &u32| {
        let (x, y) = (index % SIZE[0], index / SIZE[0]);
        let facing = off.get_pixel(x, y).0[0];
        let mut judged = Judged::default();
        let ray = |dx: f64, dy: f64| camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE);
        let Some(hit) = surface.intersect(&ray(0.0, 0.0)).filter(|hit| !hit.wall && facing >= FACING) else {
            return judged;
        };
        judged.compared = 1;
        let shown = hard.get_pixel(x, y).0[0];
        assert!(shown == 0 || shown == facing, "pixel {x},{y} is neither lit nor dark: {shown} of {facing}");
        let dark = |place: DVec3, slope: f64| surface.horizon(place, azimuth, near) > slope;
        judged.dark = u32::from(dark(hit.position, tangent));
        if (shown == 0) == (judged.dark == 1) {
            return judged;
        }
        let on_ground = |place: DVec3| {
            let [u, v] = [place.x / extent.x, place.z / extent.z].map(|share| share.clamp(0.0, 1.0));
            DVec3::new(u * extent.x, map.surface_height(u, v) * extent.y, v * extent.z)
        };
        let around = (0..8).map(|turn| f64::from(turn) * std::f64::consts::FRAC_PI_4);
        let moved = around.map(|turn| on_ground(hit.position + DVec3::new(turn.cos(), 0.0, turn.sin()) * PLACE * side));
        let beside = [(PART_OF_PIXEL, 0.0), (-PART_OF_PIXEL, 0.0), (0.0, PART_OF_PIXEL), (0.0, -PART_OF_PIXEL)];
        let beside = beside.into_iter().filter_map(|(dx, dy)| Some(surface.intersect(&ray(dx, dy))?.position));
        let slopes = [tangent - SLOPE * (1.0 + tangent * tangent), tangent + SLOPE * (1.0 + tangent * tangent)];
        let mut places = std::iter::once(hit.position).chain(moved).chain(beside);
        let doubtful = places.any(|place| slopes.iter().any(|&slope| dark(place, slope) != (judged.dark == 1)));
        if doubtful {
            judged.excused = 1;
        } else {
            judged.wrong = 1;
        }
        judged
    };
    let add = |a: Judged, b: Judged| Judged {
        compared: a.compared + b.compared,
        dark: a.dark + b.dark,
        excused: a.excused + b.excused,
        wrong: a.wrong + b.wrong,
    };
    pixels.par_iter().map(judge).reduce(Judged::default, add)
}

/// Compares a view of `scene` with the reference on `ground`; prints and checks.
fn check(name: &str, renderer: &mut Renderer, ground: &HeightField, scene: &Scene) -> Judged {
    let off = draw(renderer, scene, Shadows::Off);
    let hard = draw(renderer, scene, Shadows::Hard);
    assert!(renderer.ledger().shader_defs.iter().any(|def| def == "SHADOWS"));
    let judged = judge(ground, scene, &off, &hard);
    println!("{name:32} {judged:?}");
    assert_eq!(judged.wrong, 0, "{name}");
    assert!(judged.excused <= 4, "{name}: {} excused", judged.excused);
    judged
}

#[test]
fn hard_shadows_are_those_of_the_reference() {
    let [mut compared, mut dark, mut excused] = [0; 3];
    for (name, map, scale) in maps() {
        let extent = map.box_size(scale);
        let mut renderer = renderer(&map);
        for elevation in [1.0, 10.0, 45.0, 89.0] {
            for (view, azimuth) in [(NamedView::Over, 250.0), (NamedView::Graze, 90.0)] {
                let scene = sunlit(view.camera(&map, extent), scale, [azimuth, elevation]);
                let judged = check(&format!("{name} {} {elevation}°", view.name()), &mut renderer, &map, &scene);
                (compared, dark, excused) = (compared + judged.compared, dark + judged.dark, excused + judged.excused);
            }
        }
    }
    println!("{compared} pixels that face the sun, {dark} dark, {excused} excused");
    assert!(compared > 100_000 && dark > 25_000);
}

/// Shadows are those of the true ground, whichever technique has found it, and of craters and holes in it.
#[test]
fn shadows_know_craters_holes_and_every_technique() {
    let map = canyon();
    let extent = map.box_size(None);
    let view = NamedView::Over.camera(&map, extent);
    let mut scene = sunlit(view, None, [250.0, 12.0]);
    let mut renderer = renderer(&map);
    for technique in [Technique::LinearBinary, Technique::RelaxedCone] {
        scene.march.technique = technique;
        (scene.march.samples_min, scene.march.samples_max) = (2000, 4000);
        let off = draw(&mut renderer, &scene, Shadows::Off);
        let hard = draw(&mut renderer, &scene, Shadows::Hard);
        let judged = judge(&map, &scene, &off, &hard);
        println!("{technique:?} {judged:?}");
        // They do not find quite the same places.
        assert!(
            judged.dark > 300 && judged.wrong + judged.excused < judged.compared / 100,
            "{technique:?}: {judged:?}"
        );
    }
    scene.march.technique = Technique::MaxMipmap;
    scene.craters.list = craters(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    edited.set_craters(&scene.craters.list);
    check("craters, baked", &mut renderer, edited.field(), &scene);
    scene.craters.mode = CraterMode::Layered;
    scene.craters.layer_resolution = map.width();
    let layered = CraterLayer::rasterise(&scene.craters.list, &map, map.width()).apply_to(&map);
    check("craters, layered", &mut renderer, &layered, &scene);

    // A hole casts no shadow: a wall with a gap of no ground.
    let side = 65;
    let raw: Vec<f64> = (0..side * side).map(|index| f64::from(u8::from(index % side == 30))).collect();
    let mut holes = HoleMask::new(side, side);
    (24..40).for_each(|row| holes.insert((row * side + 30) as usize));
    let holed = Arc::new(HeightField::from_raw_with_holes(side, side, &raw, Some(holes)).unwrap());
    let whole = Arc::new(HeightField::from_raw(side, side, &raw).unwrap());
    let mut dark = Vec::new();
    for map in [&whole, &holed] {
        renderer.set_terrain(Arc::clone(map)).unwrap();
        let camera = NamedView::Over.camera(map, map.box_size(Some(0.2)));
        dark.push(check("holes", &mut renderer, map, &sunlit(camera, Some(0.2), [270.0, 20.0])).dark);
    }
    assert!(dark[1] + 15 < dark[0], "light comes through the hole: {dark:?}");
}

/// Where a ray enters the unit cube, if it does.
fn enters_cube(origin: DVec3, direction: DVec3) -> Option<f64> {
    let (a, b) = (-origin / direction, (DVec3::ONE - origin) / direction);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    (enter <= leave && leave > 0.0).then_some(enter)
}

/// The occluder's shadow on the ground and the ground's on the occluder, ray by ray.
#[test]
fn the_occluder_casts_and_takes_shadows() {
    let map = canyon();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let (mut on_ground, mut on_cube, mut lit_cube) = (0, 0, 0);
    for (lift, elevation, size) in [(0.10, 35.0, 0.12), (0.0, 9.0, 0.12), (0.0, 2.0, 0.05), (0.0, 4.0, 0.05)] {
        let mut scene = sunlit(NamedView::Over.camera(&map, extent), None, [250.0, elevation]);
        scene.occluder.enabled = true;
        (scene.occluder.size, scene.occluder.rotation) = (size, DVec3::new(30.0, 20.0, 10.0));
        let centre = scene.occluder.centre(&map, extent) + DVec3::new(0.1, lift, 0.1);
        scene.occluder.position = Some(centre);
        if size < 0.1 {
            // From where the sun is, and near: its sunny faces.
            scene.camera = Some(Camera::look_at(centre + DVec3::new(-0.11, 0.05, 0.06), centre, 50.0));
        }
        let off = draw(&mut renderer, &scene, Shadows::Off);
        let hard = draw(&mut renderer, &scene, Shadows::Hard);

        let turn = scene.occluder.rotation * (std::f64::consts::PI / 180.0);
        let rotation = DQuat::from_euler(EulerRot::YXZ, turn.x, turn.y, turn.z);
        let world_from_cube = DMat4::from_scale_rotation_translation(DVec3::splat(size), rotation, centre)
            * DMat4::from_translation(DVec3::splat(-0.5));
        let cube = world_from_cube.inverse();
        let sun = scene.lighting.sun_direction();
        let surface = Surface::new(&map, extent);
        let place = scene.lighting.sun_place();
        let (azimuth, tangent) = (place.azimuth.to_radians(), place.elevation.to_radians().tan());
        let camera = scene.camera.unwrap();
        let (mut wrong, mut compared) = (0, 0);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let [before, after] = [&off, &hard].map(|picture| picture.get_pixel(x, y).0);
                // All that may be seen a hundredth of a pixel around: dark or not.
                let verdict = |dx: f64, dy: f64| {
                    let ray = camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, SIZE);
                    let ground = surface.intersect(&ray);
                    let entry = enters_cube(cube.transform_point3(ray.origin), cube.transform_vector3(ray.direction));
                    let depth = ground.map_or(f64::INFINITY, |hit| hit.depth);
                    if let Some(entry) = entry.filter(|&entry| entry < depth) {
                        let at = ray.origin + ray.direction * entry;
                        return Some((true, surface.horizon(at, azimuth, 0.0) > tangent));
                    }
                    let hit = ground.filter(|hit| !hit.wall)?;
                    let shaded =
                        enters_cube(cube.transform_point3(hit.position), cube.transform_vector3(sun)).is_some();
                    Some((false, shaded || surface.horizon(hit.position, azimuth, 1e-9) > tangent))
                };
                let all =
                    [(0.0, 0.0), (0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)].map(|(dx, dy)| verdict(dx, dy));
                let Some((is_cube, dark)) = all[0].filter(|_| all.iter().all(|other| *other == all[0])) else {
                    continue;
                };
                // What is turned away from the sun shows no difference.
                let brightest = |colour: [u8; 4]| colour[..3].iter().copied().max().unwrap();
                if !is_cube && before[0] < FACING {
                    continue;
                }
                let changed = brightest(after) < brightest(before);
                compared += 1;
                if is_cube {
                    // A face that the sun does not reach has nothing to lose.
                    wrong += u32::from(changed && !dark);
                    on_cube += u32::from(changed && dark);
                    lit_cube += u32::from(!changed);
                } else {
                    wrong += u32::from(changed != dark);
                    on_ground += u32::from(changed && dark);
                }
            }
        }
        println!("sun at {elevation}°: {compared} pixels, {wrong} wrong");
        assert_eq!(wrong, 0);
    }
    println!("{on_ground} dark pixels of ground, {on_cube} of the cube, {lit_cube} lit ones");
    assert!(on_ground > 500 && on_cube > 20 && lit_cube > 100);
}

/// Share of the sun's disc over the horizon, by many rays to it.
fn seen_share(surface: &Surface<'_>, place: DVec3, sun: DVec3) -> f64 {
    const RAYS: u32 = 400;
    let right = sun.cross(DVec3::Y).normalize();
    let up = right.cross(sun);
    let radius = 0.2665f64.to_radians().tan();
    // A sunflower's seeds: equal areas.
    let seen = (0..RAYS).filter(|&index| {
        let (from_centre, turn) = ((f64::from(index) + 0.5) / f64::from(RAYS), f64::from(index) * 2.399_963);
        let direction = sun + (right * turn.cos() + up * turn.sin()) * radius * from_centre.sqrt();
        let slope = direction.y / direction.x.hypot(direction.z);
        surface.horizon(place, direction.x.atan2(-direction.z), 1e-9) <= slope
    });
    seen.count() as f64 / f64::from(RAYS)
}

#[test]
fn soft_shadows_are_the_share_of_the_suns_disc() {
    let linear = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    let (mut penumbra, mut sum, mut worst) = (0, 0.0, 0.0f64);
    for elevation in [3.0, 20.0] {
        let map = canyon();
        let extent = map.box_size(None);
        let mut renderer = renderer(&map);
        // From above a rim and the plain that its shadow falls on: a wide penumbra.
        let camera = Camera { eye: DVec3::new(0.17, 0.22, 0.18), yaw: 20.0, pitch: -60.0, fov: 34.0 };
        let scene = sunlit(camera, None, [100.0, elevation]);
        let off = draw(&mut renderer, &scene, Shadows::Off);
        let hard = draw(&mut renderer, &scene, Shadows::Hard);
        let soft = draw(&mut renderer, &scene, Shadows::Soft);
        let surface = Surface::new(&map, extent);
        let sun = scene.lighting.sun_direction();
        for index in 0..SIZE[0] * SIZE[1] {
            let (x, y) = (index % SIZE[0], index / SIZE[0]);
            let [all, _, some] = [&off, &hard, &soft].map(|picture| picture.get_pixel(x, y).0[0]);
            let is_penumbra = some > 0 && some < all;
            if all < 100 || !(is_penumbra || index % 97 == 0) || is_penumbra && index % 2 != 0 {
                continue;
            }
            let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
            let Some(hit) = surface.intersect(&ray).filter(|hit| !hit.wall) else { continue };
            let error = (linear(some) / linear(all) - seen_share(&surface, hit.position, sun)).abs();
            if is_penumbra {
                penumbra += 1;
                sum += error;
            } else {
                assert!(error < 0.02, "{error} off where it is {some} of {all}");
            }
            worst = worst.max(error);
        }
    }
    let mean = sum / f64::from(penumbra);
    println!("{penumbra} pixels of penumbra: share of the disc {mean:.4} off in the mean, {worst:.4} at most");
    assert!(penumbra > 60 && mean < 0.03 && worst < 0.35);
}

/// No sun, no walk: below the horizon, without light, in other views.
#[test]
fn without_a_sun_there_are_no_shadows_to_pay_for() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let camera = NamedView::Over.camera(&map, map.box_size(None));
    let scene = sunlit(camera, None, [250.0, 20.0]);
    let mut walks = |change: &dyn Fn(&mut Scene), shadows| {
        let mut scene = scene.clone();
        scene.march.technique = Technique::Linear;
        change(&mut scene);
        let picture = draw(&mut renderer, &scene, shadows);
        let ledger = renderer.ledger();
        let walks = ledger.shader_defs.iter().any(|def| def == "SHADOWS");
        assert_eq!(walks, ledger.textures.iter().any(|texture| texture.name == "pyramid"), "bound where it is walked");
        (walks, picture)
    };
    assert!(walks(&|_| {}, Shadows::Hard).0 && walks(&|_| {}, Shadows::Soft).0);
    assert!(!walks(&|_| {}, Shadows::Off).0);
    assert!(!walks(&|scene| scene.lighting.enabled = false, Shadows::Soft).0);
    assert!(!walks(&|scene| scene.debug.view = relief::scene::DebugView::Normals, Shadows::Soft).0);
    let low = |elevation: f32| move |scene: &mut Scene| scene.lighting.sun_elevation = elevation;
    // The upper half of the disc is still there.
    assert!(walks(&low(-0.2), Shadows::Soft).0 && !walks(&low(-0.2), Shadows::Hard).0);
    let (walked, night) = walks(&low(-1.0), Shadows::Soft);
    assert!(!walked);
    let ground = night.get_pixel(SIZE[0] / 2, SIZE[1] * 3 / 4).0;
    assert_eq!(ground, [0, 0, 0, 255], "the horizon hides the sun, too");
}

/// A light map that is drawn by rows over several frames ends up the same, and a sun that moves leaves the sky's share.
#[test]
fn a_light_map_drawn_by_parts_is_the_same() {
    let map = canyon();
    let mut scene = sunlit(NamedView::Over.camera(&map, map.box_size(None)), None, [250.0, 12.0]);
    scene.lighting.ambient = 0.5;
    scene.lighting.shadows = Shadows::Hard;
    (scene.lighting.baked, scene.lighting.occlusion) = (true, true);
    let rows = map.cells()[1];
    let mut whole = renderer(&map);
    let mut parts = renderer(&map);
    parts.set_bake_budget(Some(map.cells()[0] * rows.div_ceil(4)));
    let target = Target::new(&gpu(), SIZE);
    let picture = |renderer: &mut Renderer, scene: &Scene| {
        let mut frames = 0;
        while frames == 0 || renderer.baking().is_some() {
            frames += 1;
            assert!(frames < 20, "it never ends");
            renderer.draw(scene, &target).unwrap();
        }
        (frames, target.read_color(&gpu()).unwrap())
    };
    let (all, wanted) = picture(&mut whole, &scene);
    let (some, found) = picture(&mut parts, &scene);
    assert_eq!((all, some), (1, 8), "two channels of four parts each");
    assert!(wanted == found);
    scene.lighting.sun_azimuth += 30.0;
    let (all, moved) = picture(&mut whole, &scene);
    let (some, found) = picture(&mut parts, &scene);
    assert_eq!((all, some), (1, 4), "the sky's share stays");
    assert!(moved == found && moved != wanted);

    // Where the sun moves on while its shadows are drawn, these are finished first, and drawn anew after that.
    for _ in 0..3 {
        scene.lighting.sun_azimuth += 1.0;
        parts.draw(&scene, &target).unwrap();
    }
    assert!(parts.baking().is_some_and(|drawn| (drawn - 0.75).abs() < 0.01), "three of four parts");
    assert_eq!(picture(&mut parts, &scene).0, 1 + 4);
    assert!(picture(&mut parts, &scene).1 == picture(&mut whole, &scene).1);
    // Off screen nothing is baked.
    scene.lighting.sun_azimuth += 1.0;
    let away = scene.camera.as_mut().unwrap();
    (away.eye.z, away.yaw, away.pitch) = (-5.0, 0.0, 0.0);
    parts.draw(&scene, &target).unwrap();
    assert_eq!(parts.baking(), None);
}

/// The light map: drawn once, again when what it shows changes, and gone with its switch.
#[test]
fn a_light_map_is_drawn_only_when_it_changes() {
    let map = canyon();
    let mut renderer = renderer(&map);
    let mut scene = sunlit(NamedView::Over.camera(&map, map.box_size(None)), None, [250.0, 12.0]);
    scene.lighting.ambient = 0.5;
    scene.march.technique = Technique::Linear;
    let mut frame = |scene: &Scene| {
        let target = Target::new(&gpu(), SIZE);
        renderer.draw(scene, &target).unwrap();
        let ledger = renderer.ledger();
        let drawn = ledger.passes.iter().any(|pass| pass == "light map");
        let there = ledger.textures.iter().any(|texture| texture.name == "light map");
        let walks = ledger.shader_defs.iter().any(|def| def == "SHADOWS");
        (drawn, there, walks, target.read_color(&gpu()).unwrap())
    };
    let plain = frame(&scene);
    assert_eq!((plain.0, plain.1), (false, false));
    scene.lighting.shadows = Shadows::Soft;
    let live = frame(&scene);
    assert_eq!((live.0, live.1, live.2), (false, false, true));
    scene.lighting.baked = true;
    let baked = frame(&scene);
    assert_eq!((baked.0, baked.1, baked.2), (true, true, false));
    // The same shadows, as finely as the map has cells.
    let far = |a: &RgbaImage, b: &RgbaImage| {
        a.pixels().zip(b.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 24).count() as f64
            / a.pixels().len() as f64
    };
    println!("{} of the pixels differ by baking, {} by shadows", far(&live.3, &baked.3), far(&live.3, &plain.3));
    assert!(far(&live.3, &baked.3) < 0.01 && far(&live.3, &plain.3) > 0.02);

    let mut moved = scene.clone();
    moved.camera = Some(NamedView::Graze.camera(&map, map.box_size(None)));
    moved.craters.radius = 0.2;
    assert!(!frame(&moved).0, "neither the eye nor the brush casts a shadow");
    moved.lighting.sun_azimuth += 1.0;
    assert!(frame(&moved).0 && !frame(&moved).0);
    moved.craters.list.push(moved.craters.brush_at(0.5, 0.5));
    assert!(frame(&moved).0 && !frame(&moved).0);

    // Ambient occlusion darkens valleys, brightens nothing, and does not care for the sun.
    scene.lighting.shadows = Shadows::Off;
    scene.lighting.occlusion = true;
    let dimmed = frame(&scene);
    assert!(dimmed.0 && dimmed.1 && !dimmed.2);
    assert!(dimmed.3.pixels().zip(plain.3.pixels()).all(|(dim, plain)| dim.0[0] <= plain.0[0]));
    let dimmer =
        dimmed.3.pixels().zip(plain.3.pixels()).filter(|(dim, plain)| plain.0[0].saturating_sub(dim.0[0]) > 2).count();
    println!("ambient occlusion dims {dimmer} pixels");
    assert!(dimmer > 200);
    scene.lighting.sun_azimuth += 40.0;
    assert!(!frame(&scene).0);
    scene.lighting.occlusion = false;
    assert!(!frame(&scene).1);
}

/// A film is written while the window goes on with a sun of its own: each keeps its light map.
#[test]
fn two_series_of_pictures_keep_a_light_map_each() {
    // Without its metres, as the other one below: boxes of one size.
    let canyon = canyon();
    let map = Arc::new(map_of(canyon.width(), canyon.height(), |x, z| f64::from(canyon.sample(x, z))));
    let mut renderer = renderer(&map);
    let mut window = sunlit(NamedView::Over.camera(&map, map.box_size(None)), None, [250.0, 12.0]);
    (window.lighting.shadows, window.lighting.baked) = (Shadows::Hard, true);
    let mut film = window.clone();
    film.lighting.sun_azimuth += 40.0;
    let mut of_film = Baking::default();
    let targets = [Target::new(&gpu(), SIZE), Target::new(&gpu(), [SIZE[0] / 2, SIZE[1] / 2])];
    let draw = |renderer: &mut Renderer, scene: &Scene, target: &Target| {
        renderer.draw(scene, target).unwrap();
        (renderer.ledger().passes.iter().any(|pass| pass == "light map"), target.read_color(&gpu()).unwrap())
    };
    let turn = |renderer: &mut Renderer, of_film: &mut Baking| {
        let seen = draw(renderer, &window, &targets[0]);
        renderer.swap_baking(of_film);
        let filmed = draw(renderer, &film, &targets[1]);
        renderer.swap_baking(of_film);
        [seen, filmed]
    };
    let first = turn(&mut renderer, &mut of_film);
    assert!(first.iter().all(|(baked, _)| *baked));
    for ((baked, picture), (_, before)) in turn(&mut renderer, &mut of_film).into_iter().zip(&first) {
        assert!(!baked && picture == *before, "its map is still there, and its own");
    }
    // Another height map of as many samples has other shadows.
    let upside_down = map_of(map.width(), map.height(), |x, z| 1.0 - f64::from(map.sample(x, z)));
    assert_eq!(upside_down.box_size(None), map.box_size(None));
    renderer.set_terrain(Arc::new(upside_down)).unwrap();
    assert!(turn(&mut renderer, &mut of_film).iter().all(|(baked, _)| *baked));
}
