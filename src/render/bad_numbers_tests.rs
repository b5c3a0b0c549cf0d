//! Bad numbers never reach a shader: every numeric field of a scene, found by walking its serialised form, is set to each
//! of them in a scene file and in a scene that goes straight to the renderer.

use glam::DVec3;
use toml::Value;

use super::air::AirUniform;
use super::clouds::ShadowPlace;
use super::cube::clip_corners;
use super::frame::FrameUniform;
use super::ground::Ground;
use super::materials::MaterialsUniform;
use super::sky_map::AirLight;
use super::terrain::TerrainUniform;
use super::{PreparedTerrain, RenderError, Renderer, clouds, flare, occluder, terrain};
use crate::camera::{Camera, NamedView};
use crate::gpu::{Gpu, Target};
use crate::heightfield::bounds::Rule;
use crate::heightfield::generate::{Kind, generate};
use crate::heightfield::{Crater, EditedTerrain, HeightField};
use crate::scene::air::Kilometres;
use crate::scene::light::{Clock, Shadows, SkyModel};
use crate::scene::{
    AirSettings, CloudLayer, CloudSettings, CloudSource, ColourSource, CompareSettings, CraterMode, CraterSettings,
    DebugSettings, DebugView, DetailSettings, DiffuseSettings, FlareSettings, GroundColour, HeightFilter, Hillshade,
    LandSettings, LevelUnit, LightingSettings, MarchSettings, MaterialSettings, OccluderSettings, Ramp, SavedSettings,
    Scene, SkyboxSettings, Technique, TerrainSettings, Water,
};
use crate::scene_file;

/// A scene with every optional number there. Without `..`, so that a new field does not compile before it is here.
fn full_scene() -> Scene {
    Scene {
        terrain: TerrainSettings { file: None, height_scale: Some(0.2), recipe: None },
        camera: Some(Camera { eye: DVec3::new(0.4, 0.5, 1.5), yaw: 10.0, pitch: -20.0, fov: 50.0 }),
        march: MarchSettings {
            technique: Technique::MaxMipmap,
            samples_min: 20,
            samples_max: 40,
            steps_by_angle: true,
            binary_steps: 8,
            filter: HeightFilter::Exact,
            lower_start: true,
            discard_misses: true,
        },
        detail: DetailSettings { strength: 0.5 },
        compare: CompareSettings { enabled: false, technique: Technique::Linear, share: 0.5 },
        diffuse: DiffuseSettings { enabled: true, source: ColourSource::Texture, file: None, repeats: 2.0 },
        land: LandSettings {
            colour: GroundColour::Ramp,
            ramp: Ramp::Batlow,
            low: Some(-1.0),
            high: Some(9.0),
            slope_max: 50.0,
            hillshade: Hillshade::Off,
            hillshade_strength: 0.5,
            contours: true,
            contour_interval: Some(0.1),
            contour_width: 1.5,
            imagery: None,
            imagery_opacity: 0.5,
        },
        materials: MaterialSettings {
            scale: 1.5,
            aridity: 0.5,
            scree_slope: 27.0,
            rock_slope: 35.0,
            snow_slope: 52.0,
            softness: 1.0,
            levels: LevelUnit::Share,
            snow_line: 0.7,
            tree_line: 0.5,
            sand_line: 0.02,
            sea_level: 0.01,
            relief: 1.0,
            coverage: Vec::new(),
        },
        lighting: LightingSettings {
            enabled: true,
            sun_azimuth: 300.0,
            sun_elevation: 32.0,
            ambient: 0.3,
            diffuse: 1.0,
            specular: 0.1,
            shininess: 24.0,
            shadows: Shadows::Soft,
            baked: false,
            occlusion: true,
            clock: Clock {
                enabled: true,
                year: 2026,
                month: 6,
                day: 21,
                hour: 20.0,
                latitude: Some(36.0),
                longitude: Some(-112.0),
                speed: 1.0,
            },
        },
        skybox: SkyboxSettings {
            enabled: true,
            faces: None,
            flattening: 2.0,
            model: SkyModel::Physical,
            turbidity: 3.0,
        },
        air: AirSettings {
            perspective: true,
            visibility: 40.0,
            fog: true,
            fog_density: 0.8,
            fog_base: 100.0,
            fog_scale: 300.0,
            fog_glow: 0.5,
        },
        clouds: CloudSettings {
            enabled: true,
            source: CloudSource::Noise,
            cover: 0.5,
            shadows: true,
            shadow_strength: 0.8,
            time: 5.0,
            moving: true,
            rate: 30.0,
            layers: vec![CloudLayer {
                height: 3000.0,
                cover: 0.5,
                thickness: 3.0,
                scale: 12.0,
                speed: 10.0,
                direction: 90.0,
            }],
        },
        flare: FlareSettings { enabled: true, strength: 1.0 },
        occluder: OccluderSettings {
            enabled: true,
            position: Some(DVec3::new(0.5, 0.2, 0.5)),
            size: 0.1,
            rotation: DVec3::new(30.0, 20.0, 10.0),
            spin: 5.0,
        },
        debug: DebugSettings { view: DebugView::None, wireframe: true, heat_map_max: 64 },
        craters: CraterSettings {
            mode: CraterMode::Baked,
            layer_resolution: 64,
            radius: 0.03,
            depth: 0.35,
            rim: 0.08,
            list: vec![Crater { x: 0.4, z: 0.6, radius: 0.1, depth: 0.3, rim: 0.1 }],
        },
        water: Water {
            enabled: true,
            level: Some(0.4),
            levels: LevelUnit::Share,
            reflection: true,
            refraction: true,
            clarity: 0.05,
            tint: 0.3,
            waves: 0.3,
            wave_length: 0.02,
            foam: 0.5,
            bubbles: true,
            moving: true,
            time: 3.0,
        },
        saved: SavedSettings { legend: true },
    }
}

/// A place in a serialised scene: keys and indices.
type Place = Vec<String>;

fn numbers_in(value: &Value, place: &mut Place, found: &mut Vec<Place>) {
    let mut inside = |key: String, value: &Value| {
        place.push(key);
        numbers_in(value, place, found);
        place.pop();
    };
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| inside(key.clone(), value)),
        Value::Array(list) => list.iter().enumerate().for_each(|(index, value)| inside(index.to_string(), value)),
        Value::Integer(_) | Value::Float(_) => found.push(place.clone()),
        _ => {}
    }
}

/// The value at `place`.
fn at<'a>(mut value: &'a mut Value, place: &Place) -> &'a mut Value {
    for key in place {
        value = match value {
            Value::Array(list) => &mut list[key.parse::<usize>().unwrap()],
            table => table.get_mut(key.as_str()).unwrap(),
        };
    }
    value
}

fn bad_numbers() -> Vec<Value> {
    let floats = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::from_bits(1),
        -f64::from_bits(1),
        f64::MIN_POSITIVE,
        1e-40,
        -1e-40,
        f64::from(f32::MIN_POSITIVE),
        -0.0,
        0.0,
        1e9,
        1e38,
        -1e38,
        1e39,
        f64::MAX,
        f64::MIN,
    ];
    let integers = [0, -1, 1, i64::from(u32::MAX), i64::from(u32::MAX) + 1, i64::MAX, i64::MIN];
    floats.into_iter().map(Value::Float).chain(integers.into_iter().map(Value::Integer)).collect()
}

/// Whether every float of a uniform is 0 or normal. Its few whole numbers are small, and look like subnormals.
fn assert_sound(what: &str, uniform: &[u8], whole_numbers: &[usize]) {
    for (index, word) in uniform.chunks_exact(4).enumerate() {
        let float = f32::from_le_bytes(word.try_into().unwrap());
        let sound = float.is_normal() || float.to_bits() == 0 || whole_numbers.contains(&(index * 4));
        assert!(sound, "{what}: float {index} is {float:e}");
    }
}

/// Everything of a scene that a shader gets in numbers.
fn assert_uniforms_are_sound(what: &str, scene: &Scene, ground: &Ground) {
    let map = ground.terrain().base();
    let extent = map.box_size(scene.terrain.height_scale);
    let camera = scene.camera.unwrap_or_else(|| NamedView::Start.camera(map, extent));
    let size = [320, 200];
    let frame = FrameUniform::new(&camera, size, extent, scene.skybox.flattening);
    assert_sound(&format!("{what}: frame"), bytemuck::bytes_of(&frame), &[]);
    let clip = terrain::drawn_box(&camera, size, extent);
    let uniform = TerrainUniform::new(scene, ground, None, extent, &clip);
    let whole = [std::mem::offset_of!(TerrainUniform, binary_steps), std::mem::offset_of!(TerrainUniform, step_cap)];
    assert_sound(&format!("{what}: terrain"), bytemuck::bytes_of(&uniform), &whole);
    if let Some(materials) = MaterialsUniform::new(scene, ground, extent) {
        assert_sound(&format!("{what}: materials"), bytemuck::bytes_of(&materials), &[]);
    }
    let (km, light) = (Kilometres::of(map, extent.y), AirLight::flat(glam::Vec3::splat(0.5)));
    let mut air = AirUniform::new(scene, km, camera.eye.y, &light);
    let place = ShadowPlace::new(scene, DVec3::ZERO, extent);
    let layers = clouds::uniforms(scene, km, camera.eye.y, false, place, &mut air);
    assert_sound(&format!("{what}: air"), bytemuck::bytes_of(&air), &[]);
    assert_sound(&format!("{what}: clouds"), bytemuck::bytes_of(&layers), &[]);
    let flare = flare::uniform(glam::DVec2::new(0.3, 0.4), size, glam::Vec3::ONE * scene.flare.strength as f32);
    assert_sound(&format!("{what}: flare"), bytemuck::bytes_of(&flare), &[]);
    let world_from_cube = occluder::world_from_cube(&scene.occluder, map, extent);
    let clip = clip_corners(camera.clip_from_world(size), world_from_cube);
    let cube = occluder::uniform(&clip, world_from_cube, &scene.lighting);
    assert_sound(&format!("{what}: occluder"), bytemuck::bytes_of(&cube), &[]);
}

#[test]
fn a_bad_number_in_any_field_of_a_scene_is_refused_or_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let gpu = Gpu::noop();
    let map = std::sync::Arc::new(generate(Kind::Ridged, 33, 1));
    let mut whole = Value::try_from(full_scene()).unwrap();
    let mut places = Vec::new();
    numbers_in(&whole, &mut Vec::new(), &mut places);
    assert!(places.len() >= 37, "the walk finds only {} numbers: {places:?}", places.len());
    let (mut refused, mut taken) = (0, 0);
    for place in &places {
        let name = place.join(".");
        let key = place.iter().rev().find(|key| key.parse::<usize>().is_err()).unwrap();
        for bad in bad_numbers() {
            let good = std::mem::replace(at(&mut whole, place), bad.clone());
            std::fs::write(&path, toml::to_string(&whole).unwrap()).unwrap();
            *at(&mut whole, place) = good;
            match scene_file::read(&path) {
                Err(error) => {
                    refused += 1;
                    let message = error.to_string();
                    assert_eq!(message.lines().count(), 3, "what, why, what to do: {message}");
                    // A value of the wrong type is named by its line, any other by its key.
                    let after_file = message.split("scene.toml:").nth(1).unwrap_or_default();
                    let by_line = after_file.starts_with(|character: char| character.is_ascii_digit());
                    assert!(by_line || message.contains(key.as_str()), "{name} = {bad}: {message}");
                    let finite = bad.as_float().is_none_or(f64::is_finite);
                    let number = bad.to_string().to_lowercase();
                    assert!(finite || by_line || message.to_lowercase().contains(&number), "{message}");
                }
                Ok(scene) => {
                    taken += 1;
                    let mut ground = Ground::new(&gpu, EditedTerrain::new(std::sync::Arc::clone(&map)));
                    ground.prepare(&gpu, &scene.craters, true, Rule::default());
                    assert_uniforms_are_sound(&format!("{name} = {bad}"), &scene, &ground);
                    let samples = ground.terrain().field().samples();
                    let sound = |height: f32| height.to_bits() == 0 || height.is_normal() && height <= 1.0;
                    assert!(samples.iter().all(|&height| sound(height)), "{name} = {bad}: a height");
                    // What is written is read again.
                    std::fs::write(&path, scene_file::to_toml(&scene).unwrap()).unwrap();
                    assert_eq!(scene_file::read(&path).unwrap(), scene, "{name} = {bad}");
                }
            }
        }
    }
    println!("{} fields: {refused} numbers refused, {taken} taken", places.len());
    assert!(refused > 300 && taken > 100, "{refused} refused, {taken} taken");
}

/// The panel and the library's callers do not go through a file.
#[test]
fn the_renderer_refuses_what_a_scene_file_would() {
    let gpu = Gpu::noop();
    let mut renderer = Renderer::new(std::sync::Arc::clone(&gpu)).unwrap();
    let map = std::sync::Arc::new(generate(Kind::Ridged, 33, 1));
    renderer.set_prepared_terrain(PreparedTerrain::new(map)).unwrap();
    let target = Target::new(&gpu, [32, 20]);
    let refuses = |renderer: &mut Renderer, change: &dyn Fn(&mut Scene)| {
        let mut scene = full_scene();
        change(&mut scene);
        match renderer.draw(&scene, &target) {
            Err(error @ RenderError::Scene(_)) => {
                assert_eq!(error.to_string().lines().count(), 3, "what, why, what to do: {error}");
                true
            }
            _ => false,
        }
    };
    assert!(!refuses(&mut renderer, &|_| {}));
    let bad = [f64::NAN, f64::INFINITY, 1e38];
    for number in bad {
        assert!(refuses(&mut renderer, &|scene| scene.terrain.height_scale = Some(number)));
        assert!(refuses(&mut renderer, &|scene| scene.lighting.specular = number as f32));
        assert!(refuses(&mut renderer, &|scene| scene.camera.as_mut().unwrap().eye.y = number));
        assert!(refuses(&mut renderer, &|scene| scene.craters.list[0].radius = number));
    }
    assert!(refuses(&mut renderer, &|scene| scene.march.samples_max = u32::MAX));
    assert!(!refuses(&mut renderer, &|_| {}), "and draws what is sound again");
}

/// A library's map may be said to show anything.
#[test]
fn a_map_said_to_show_anything_makes_sound_uniforms() {
    let gpu = Gpu::noop();
    for extent in [[1.0, 1e-5], [1e-320, 1e-320], [f64::NAN, 1.0], [1e308, 1e308], [1e-310, 1e-306]] {
        for (range, factor) in [([0.0, 1e300], 1.0), ([f64::MIN, f64::MAX], 1e300), ([-1e-310, 1e-310], 1e-300)] {
            let raw: Vec<f64> = (0..12).map(f64::from).collect();
            let map = HeightField::from_raw(4, 3, &raw).unwrap();
            let map = map.with_extent_metres(Some(extent)).with_range(range).with_exaggeration(factor);
            let ground = Ground::new(&gpu, EditedTerrain::new(std::sync::Arc::new(map)));
            let scene = Scene { terrain: TerrainSettings::default(), camera: None, ..full_scene() };
            assert_uniforms_are_sound(&format!("{extent:?}, {range:?}, {factor}"), &scene, &ground);
        }
    }
}
