//! Air and cloud shadows against the same in f64, from exact distances, pixel by pixel.

use std::sync::Arc;

use glam::DVec3;

use super::air::{AirKey, extinction};
use super::clouds::{ShadowPlace, shadow_twin};
use super::*;
use crate::camera::{Camera, NamedView};
use crate::heightfield::generate::{Kind, generate};
use crate::heightfield::load;
use crate::heightfield::reference::Surface;
use crate::scene::air::Kilometres;
use crate::scene::light::SkyModel;
use crate::scene::{CloudSource, LevelUnit};

const SIZE: [u32; 2] = [96, 60];

fn canyon() -> Arc<HeightField> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
    Arc::new(load::load(&path).unwrap().field)
}

/// The byte of linear light.
fn encode(light: f64) -> f64 {
    let light = light.clamp(0.0, 1.0);
    255.0 * if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

fn decode(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Optical depths from `from` to `to`, kilometres, `to.y` and `from.y` heights over the floor, by summing up small steps.
fn depths(scene: &Scene, km: Kilometres, from: DVec3, to: DVec3) -> ([f64; 3], f64) {
    const STEPS: u32 = 1000;
    let [molecules, haze] = extinction(scene.air.visibility);
    let step = from.distance(to) / f64::from(STEPS);
    let (mut aerial, mut fogged) = ([0.0; 3], 0.0);
    let base = scene.air.fog_base / 1000.0 - km.floor;
    for index in 0..STEPS {
        let height = from.y + (to.y - from.y) * (f64::from(index) + 0.5) / f64::from(STEPS);
        let falls = |base: f64, scale: f64| (-(height - base).max(0.0) / scale).exp() * step;
        for channel in 0..3 {
            aerial[channel] += molecules[channel] * falls(0.0, 8.8) + haze[channel] * falls(0.0, 1.2);
        }
        fogged += scene.air.fog_density * falls(base, scene.air.fog_scale / 1000.0);
    }
    let key = AirKey::of(scene);
    (if key.perspective { aerial } else { [0.0; 3] }, if key.fog { fogged } else { 0.0 })
}

/// What the sky lights the air with in a direction (a unit vector): of the horizon, and of the fog.
fn lights(renderer: &Renderer, scene: &Scene, direction: DVec3) -> [DVec3; 2] {
    let light = renderer.skybox.as_ref().unwrap().light();
    let count = light.horizon.len();
    let mean = light.horizon.iter().map(|light| light.as_dvec3()).sum::<DVec3>() / count as f64;
    let along = direction.x / (direction.x.abs() + direction.z.abs());
    let turn = if direction.z < 0.0 { 3.0 + along } else { 1.0 - along } * 0.25 * count as f64;
    let at = |index: usize| light.horizon[index % count].as_dvec3();
    let around = at(turn as usize).lerp(at(turn as usize + 1), turn.fract());
    let level = direction.x.hypot(direction.z);
    let horizon = mean.lerp(around, level);
    let grey = mean.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    let spread =
        (0.35f64.powi(2) / (1.0 + 0.65 * 0.65 - 1.3 * direction.dot(scene.lighting.sun_direction()))).powf(1.5);
    let sun = if light.exposed { DVec3::ONE - (-1.6 * light.sun.as_dvec3()).exp() } else { light.sun.as_dvec3() };
    let fog = 0.5 * (horizon + mean.lerp(DVec3::splat(grey), 0.7)) + sun * (0.9 * scene.air.fog_glow * spread);
    [horizon, fog]
}

/// Both kinds of air, alone and together, under both skies, from above and along the ground, with and without a known scale,
/// and exaggerated.
#[test]
fn light_through_the_air_is_that_of_f64_from_exact_distances() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let target = Target::new(&gpu, SIZE);
    let known = canyon();
    let plain = Arc::new((*known).clone().with_extent_metres(None).with_metres(false));
    let (mut compared, mut worst) = (0, 0.0f64);
    let cases = [(&known, None, true, false), (&known, Some(0.15), true, true), (&plain, None, false, true)];
    for (map, height_scale, perspective, fog) in cases {
        renderer.set_terrain(Arc::clone(map)).unwrap();
        for (view, model) in [(NamedView::Start, SkyModel::Painted), (NamedView::Valley, SkyModel::Physical)] {
            let extent = map.box_size(height_scale);
            let camera = view.camera(map, extent);
            let mut scene = Scene { camera: Some(camera), ..Scene::default() };
            scene.terrain.height_scale = height_scale;
            (scene.diffuse.enabled, scene.lighting.enabled, scene.skybox.model) = (false, false, model);
            (scene.air.perspective, scene.air.visibility, scene.air.fog) = (perspective, 25.0, fog);
            let [low, high] = map.range();
            scene.air.fog_base = if map.has_metres() { low + 0.3 * (high - low) } else { 400.0 };
            renderer.draw(&scene, &target).unwrap();
            let picture = target.read_color(&gpu).unwrap();
            let km = Kilometres::of(map, extent.y);
            let surface = Surface::new(map, extent);
            let scaled = |place: DVec3| place * DVec3::new(km.along, km.up, km.along);
            let mut wrong = 0;
            for (x, y, pixel) in picture.enumerate_pixels() {
                let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
                let Some(hit) = surface.intersect(&ray).filter(|hit| !hit.wall) else { continue };
                let (aerial, fogged) = depths(&scene, km, scaled(camera.eye), scaled(hit.position));
                let [horizon, foggy] = lights(&renderer, &scene, ray.direction.normalize());
                let off = (0..3).map(|c| {
                    let all = aerial[c] + fogged;
                    let share = if all > 1e-9 { (1.0 - (-all).exp()) / all } else { 1.0 };
                    let light = 0.5 * (-all).exp() + share * (aerial[c] * horizon[c] + fogged * foggy[c]);
                    (encode(light) - f64::from(pixel.0[c])).abs()
                });
                let off = off.fold(0.0, f64::max);
                compared += 1;
                // The byte's rounding, and the noise against bands.
                if off > 1.6 {
                    wrong += 1;
                } else {
                    worst = worst.max(off);
                }
            }
            assert!(wrong <= 4, "{view:?}, {model:?}, exaggerated {height_scale:?}: {wrong} pixels");
        }
    }
    println!("{compared} pixels, at most {worst:.2} of a byte's step off");
    assert!(compared > 15_000);
}

/// The shadow of a cloud lies where the cloud is along the sun's rays, and lets as much light through.
#[test]
fn cloud_shadows_lie_along_the_suns_rays() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let target = Target::new(&gpu, SIZE);
    let map = canyon();
    renderer.set_terrain(Arc::clone(&map)).unwrap();
    let extent = map.box_size(None);
    let km = Kilometres::of(&map, extent.y);
    for (azimuth, elevation) in [(300.0, 32.0), (80.0, 12.0), (200.0, 85.0)] {
        let camera = Camera::look_at(DVec3::new(0.5, 0.9, 1.1), DVec3::new(0.5, 0.0, 0.45), 55.0);
        let mut scene = Scene { camera: Some(camera), ..Scene::default() };
        scene.diffuse.enabled = false;
        (scene.lighting.ambient, scene.lighting.diffuse, scene.lighting.specular) = (0.0, 1.6, 0.0);
        (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (azimuth, elevation);
        (scene.clouds.enabled, scene.clouds.time, scene.clouds.shadow_strength) = (true, 500.0, 1.0);
        // Above the eye, so that only shadows show; one among the hills.
        scene.clouds.layers.truncate(3);
        for (layer, height) in scene.clouds.layers.iter_mut().zip([1500.0, 90_000.0, 120_000.0]) {
            (layer.height, layer.scale, layer.thickness) = (height, 90.0, 2.0);
        }
        scene.clouds.layers[0].thickness = 0.004;
        renderer.draw(&scene, &target).unwrap();
        let sunny = target.read_color(&gpu).unwrap();
        scene.clouds.shadows = true;
        renderer.draw(&scene, &target).unwrap();
        let shaded = target.read_color(&gpu).unwrap();
        let bounds = ShadowPlace::new(&scene, DVec3::ZERO, extent);
        let pattern = Arc::clone(&renderer.atmosphere.clouds.as_ref().unwrap().pattern);
        let surface = Surface::new(&map, extent);
        let (mut off, mut dark) = (Vec::new(), 0);
        for (x, y, pixel) in sunny.enumerate_pixels() {
            let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
            let Some(hit) = surface.intersect(&ray).filter(|hit| !hit.wall && pixel.0[1] > 60) else { continue };
            let shown = decode(shaded.get_pixel(x, y).0[1]) / decode(pixel.0[1]);
            let wanted = shadow_twin(&pattern, &scene, km, hit.position, bounds);
            dark += u32::from(wanted < 0.6);
            off.push((shown - wanted).abs());
        }
        off.sort_by(f64::total_cmp);
        let (median, p99) = (off[off.len() / 2], off[off.len() * 99 / 100]);
        println!(
            "sun {elevation}° high: {} pixels, {dark} dark, off by {median:.4} (median), {p99:.4} (p99)",
            off.len()
        );
        assert!(off.len() > 1000 && dark > 50, "{} pixels, {dark} dark", off.len());
        assert!(median < 0.01 && p99 < 0.06, "off by {median} in the median, {p99} at p99");
    }
}

/// What a frame has not drawn because it failed the next one draws.
#[test]
fn a_frame_that_fails_leaves_its_cloud_shadows_to_the_next() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    renderer.set_terrain(Arc::new(generate(Kind::Ridged, 33, 3))).unwrap();
    let target = Target::new(&gpu, [16, 10]);
    let mut scene = Scene::default();
    (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
    // The map has no metres: this is found out after the clouds were made ready.
    (scene.water.enabled, scene.water.level, scene.water.levels) = (true, Some(10.0), LevelUnit::Metres);
    renderer.draw(&scene, &target).unwrap_err();
    scene.water.enabled = false;
    let mut draws_shadows = || {
        renderer.draw(&scene, &target).unwrap();
        renderer.ledger().passes.iter().any(|pass| pass == "cloud shadows")
    };
    assert!(draws_shadows());
    assert!(!draws_shadows(), "once");
}

/// Only a look that could see something else walks towards the sun again.
#[test]
fn the_sun_is_looked_for_when_eye_sun_or_ground_have_changed() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let map = Arc::new(generate(Kind::Ridged, 33, 3));
    renderer.set_terrain(Arc::clone(&map)).unwrap();
    let target = Target::new(&gpu, [16, 10]);
    let mut scene = Scene::default();
    (scene.flare.enabled, scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (true, 0.0, 30.0);
    scene.camera = Some(Camera { eye: DVec3::new(0.5, 2.0, 0.5), yaw: 0.0, pitch: 25.0, fov: 60.0 });
    let mut flares = |scene: &Scene| {
        renderer.draw(scene, &target).unwrap();
        let flares = renderer.ledger().passes.iter().any(|pass| pass == "flare");
        // What is kept is wrong from now on: who believes it shows no flare.
        renderer.atmosphere.sun_look.as_mut().unwrap().pretend(0.0);
        flares
    };
    assert!(flares(&scene));
    assert!(!flares(&scene), "kept");
    scene.air.perspective = true;
    assert!(!flares(&scene), "the air does not matter");
    scene.camera.as_mut().unwrap().yaw = 5.0;
    assert!(!flares(&scene), "nor does where the eye looks");
    scene.camera.as_mut().unwrap().eye.x = 0.51;
    assert!(flares(&scene), "the eye has moved");
    scene.lighting.sun_elevation = 31.0;
    assert!(flares(&scene), "the sun has moved");
    scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
    assert!(flares(&scene), "the ground has changed");
    scene.occluder.enabled = true;
    assert!(flares(&scene), "the occluder might be before it");
}

/// The pattern that a frame would have to find in the map is found beside it, once.
#[test]
fn the_pattern_of_a_map_is_found_beside_the_frames() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let target = Target::new(&gpu, [16, 10]);
    let mut scene = Scene::default();
    (scene.clouds.enabled, scene.clouds.source) = (true, CloudSource::Map);
    // What was found in a map that is gone by then is of no use.
    let [gone, next] = [5, 6].map(|seed| Arc::new(generate(Kind::Ridged, 33, seed)));
    renderer.set_terrain(gone).unwrap();
    let late = renderer.missing_pipelines(&scene, target.size(), false).expect("its pattern").build(&|| true).unwrap();
    renderer.set_terrain(next).unwrap();
    renderer.set_compiled(late);
    assert!(renderer.missing_pipelines(&scene, target.size(), false).is_some(), "that of another map");
    let mut pictures = Vec::new();
    for seed in [3, 4] {
        let map = Arc::new(generate(Kind::Ridged, 33, seed));
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        let missing = renderer.missing_pipelines(&scene, target.size(), false).expect("its pattern");
        renderer.set_compiled(missing.build(&|| true).unwrap());
        assert!(renderer.missing_pipelines(&scene, target.size(), false).is_none());
        renderer.draw(&scene, &target).unwrap();
        assert!(renderer.missing_pipelines(&scene, target.size(), false).is_none(), "on the GPU");
        pictures.push(target.read_color(&gpu).unwrap());
        let mut alone = Renderer::new(Arc::clone(&gpu)).unwrap();
        alone.set_terrain(map).unwrap();
        alone.draw(&scene, &target).unwrap();
        assert!(target.read_color(&gpu).unwrap() == pictures[pictures.len() - 1], "as a frame finds it itself");
    }
    assert!(pictures[0] != pictures[1]);
}

/// A clock asks for frames only where what it moves is in view.
#[test]
fn only_what_is_in_view_moves() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let map = Arc::new(generate(Kind::Perlin, 33, 5));
    renderer.set_terrain(Arc::clone(&map)).unwrap();
    let target = Target::new(&gpu, [16, 10]);
    let extent = map.box_size(None);
    let mut motion = |scene: &Scene| {
        renderer.draw(scene, &target).unwrap();
        renderer.motion()
    };
    let (u, v) = map.lowest_interior();
    let over = Camera { eye: DVec3::new(u, 0.8, v) * extent, yaw: 0.0, pitch: -60.0, fov: 50.0 };
    let under = Camera { eye: DVec3::new(u, 0.3, v) * extent, pitch: 0.0, ..over };
    let mut sea = Scene { camera: Some(over), ..Scene::default() };
    (sea.water.enabled, sea.water.level, sea.water.foam, sea.water.waves) = (true, Some(0.6), 0.0, 0.0);
    let with = |change: &dyn Fn(&mut Scene), camera| {
        let mut scene = Scene { camera: Some(camera), ..sea.clone() };
        change(&mut scene);
        scene
    };
    assert!(!motion(&with(&|_| {}, over)).water, "bubbles are not seen from above");
    assert!(motion(&with(&|_| {}, under)).water);
    assert!(!motion(&with(&|scene| scene.water.bubbles = false, under)).water, "nothing is left to move");
    assert!(motion(&with(&|scene| scene.water.foam = 0.5, over)).water);
    let foam = |scene: &mut Scene| (scene.water.foam, scene.water.bubbles) = (0.5, false);
    assert!(!motion(&with(&foam, under)).water, "foam is not seen from below");
    assert!(motion(&with(&|scene| scene.water.waves = 0.5, over)).water);
    let away = Camera { eye: DVec3::new(0.5, 0.3, 3.0), yaw: 180.0, pitch: 0.0, fov: 50.0 };
    assert!(!motion(&with(&|scene| scene.water.waves = 0.5, away)).water, "out of view");

    let cloudy = |change: &dyn Fn(&mut Scene), pitch| {
        let mut scene = Scene { camera: Some(Camera { pitch, ..over }), ..Scene::default() };
        scene.clouds.enabled = true;
        change(&mut scene);
        scene
    };
    assert!(motion(&cloudy(&|_| {}, 40.0)).clouds);
    assert!(!motion(&cloudy(&|_| {}, -60.0)).clouds, "above, and the eye looks down");
    assert!(motion(&cloudy(&|scene| scene.clouds.shadows = true, -60.0)).clouds, "their shadows");
    let late = |scene: &mut Scene| (scene.clouds.shadows, scene.lighting.sun_elevation) = (true, -5.0);
    assert!(!motion(&cloudy(&late, -60.0)).clouds, "no sun, no shadows");
    assert!(motion(&cloudy(&|scene| scene.water.enabled = true, -60.0)).clouds, "in the water");
    let still = |scene: &mut Scene| scene.clouds.layers.iter_mut().for_each(|layer| layer.speed = 0.0);
    assert!(!motion(&cloudy(&still, 40.0)).clouds);
    let low = |scene: &mut Scene| scene.clouds.layers.iter_mut().for_each(|layer| layer.height = -500.0);
    assert!(!motion(&cloudy(&low, 40.0)).clouds && motion(&cloudy(&low, -60.0)).clouds, "below");
}
