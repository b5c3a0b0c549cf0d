//! Every pipeline variant without a driver, what is in its shader, and what both ways of its constants draw.

use rayon::prelude::*;

use super::air::AirKey;
use super::light::LightKey;
use super::light_map::LightMapKey;
use super::occluder::OccluderKey;
use super::pipelines::sources;
use super::terrain::TerrainKey;
use super::water::WaterKey;
use super::*;
use crate::gpu::COLOR_FORMAT;
use crate::scene::light::Shadows;
use crate::scene::{ColourSource, CraterMode, HeightFilter, Technique};

/// wgpu validates bindings, interfaces and formats of each pipeline on a device that does nothing.
#[test]
fn every_reachable_pipeline_builds_and_binds_just_what_its_shader_uses() {
    let keys = TerrainKey::all();
    assert!(keys.len() > 100, "the list of variants has shrunk to {}", keys.len());
    let mut all: Vec<_> = keys.into_iter().map(PipelineKey::Terrain).collect();
    all.extend(WaterKey::some().into_iter().map(PipelineKey::Water));
    all.sort_by_cached_key(|key| format!("{key:?}"));
    let terrains = all.len();
    all.extend([
        PipelineKey::Beam(Tiles::Coarse, false),
        PipelineKey::Beam(Tiles::Fine, false),
        PipelineKey::Beam(Tiles::Coarse, true),
        PipelineKey::Beam(Tiles::Fine, true),
        PipelineKey::Wireframe,
        PipelineKey::Occluder(OccluderKey::default()),
        PipelineKey::Occluder(OccluderKey { probe: true, ..OccluderKey::default() }),
        PipelineKey::Skybox(false),
        PipelineKey::Skybox(true),
        PipelineKey::CloudShadow,
        PipelineKey::Flare,
        PipelineKey::Clouds(AirKey::default()),
        PipelineKey::Present(wgpu::TextureFormat::Bgra8Unorm),
        PipelineKey::Present(COLOR_FORMAT),
    ]);
    for shadows in [Shadows::Hard, Shadows::Soft] {
        for (holes, layered) in [(false, false), (true, false), (true, true)] {
            all.push(PipelineKey::Occluder(OccluderKey { shadows, holes, layered, ..OccluderKey::default() }));
        }
    }
    for air in AirKey::all() {
        all.push(PipelineKey::Clouds(air.unlit()));
        for shadows in [Shadows::Off, Shadows::Soft] {
            all.push(PipelineKey::Occluder(OccluderKey { air, shadows, ..OccluderKey::default() }));
        }
    }
    let baking = LightKey::all().into_iter().filter(|light| light.needs_map());
    all.extend(
        baking
            .flat_map(|light| {
                let ground = [(false, false), (true, false), (true, true)];
                ground.into_iter().flat_map(move |(holes, layered)| LightMapKey::all_of(light, holes, layered))
            })
            .map(PipelineKey::LightMap),
    );
    for software in [false, true] {
        let mut gpu = Gpu::noop();
        Arc::get_mut(&mut gpu).unwrap().capabilities.software = software;
        let frame = FrameBindings::new(&gpu);
        all.par_iter().enumerate().for_each(|(index, &key)| {
            // In software only the constants arrive another way, and all tests that draw are drawn in software: of the
            // terrain's variants every fourth is enough there.
            if software && index < terrains && index % 4 != 0 {
                return;
            }
            let mut pipelines = Pipelines::new();
            if let Err(error) = pipelines.get(&gpu, &frame.layout, key) {
                panic!("{key:?}, software {software}: {error}");
            }
        });
    }
    // Each was looked at on the way: no loop without a bound, no load beyond its texture.
    let [loops, loads] = loops_tests::bounded();
    println!("{} variants: {loops} loops and {loads} loads are bounded", all.len());
    assert!(loops > all.len() && loads > all.len() / 2, "{loops} loops, {loads} loads in {} variants", all.len());
    needs_tests::assert_all_is_needed();
}

/// "A feature that is off is absent from the compiled shader": names of globals and functions tell.
#[test]
fn what_is_off_is_not_in_the_shader() {
    let names = |scene: &Scene| {
        let pass = terrain::describe(TerrainKey::of(scene, false));
        let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
        let functions = module.functions.iter().filter_map(|(_, function)| function.name.clone());
        let globals = module.global_variables.iter().filter_map(|(_, global)| global.name.clone());
        functions.chain(globals).collect::<Vec<_>>().join(" ")
    };
    let full = names(&Scene::default());
    for present in ["ground_normal", "lit", "diffuse_texture", "pyramid", "intersect_patch"] {
        assert!(full.contains(present), "{present} is missing from {full}");
    }
    let mut bare = Scene::default();
    bare.lighting.enabled = false;
    bare.diffuse.enabled = false;
    bare.march.technique = Technique::Linear;
    bare.march.filter = HeightFilter::Nearest;
    let bare = names(&bare);
    for absent in [
        "meet_smooth",
        "materials",
        "ground_normal",
        "diffuse_texture",
        "pyramid",
        "intersect_patch",
        "height_sampler",
        "crater_layer",
    ] {
        assert!(!bare.contains(absent), "{absent} is in {bare}");
    }
    assert!(!full.contains("meet_smooth") && !full.contains("material"), "{full}");
    let mut smooth = Scene::default();
    smooth.march.technique = Technique::Smooth;
    smooth.diffuse.source = ColourSource::Materials;
    let smooth = names(&smooth);
    for present in ["meet_smooth", "smooth_normal", "material_textures"] {
        assert!(smooth.contains(present), "{present} is missing from {smooth}");
    }
    for absent in ["intersect_patch", "difference_weights", "diffuse_texture", "coverage_maps"] {
        assert!(!smooth.contains(absent), "{absent} is in {smooth}");
    }
    let mut layered = Scene::default();
    layered.craters.mode = CraterMode::Layered;
    assert!(!names(&layered).contains("crater_layer"), "without craters there is no layer");
    layered.craters.list.push(layered.craters.brush_at(0.5, 0.5));
    assert!(names(&layered).contains("crater_layer"));
}

/// Constants reach the fragments as uniforms on a GPU and as varyings in software. This adapter can do both.
#[test]
fn constants_arrive_either_way() {
    let map = crate::heightfield::generate::generate(crate::heightfield::generate::Kind::Ridged, 129, 3);
    let map = Arc::new(map);
    let draw = |software| {
        let mut gpu = Gpu::headless().unwrap();
        Arc::get_mut(&mut gpu).unwrap().capabilities.software = software;
        let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        let target = Target::new(&gpu, [120, 80]);
        let mut pictures = Vec::new();
        for technique in Technique::ALL {
            for layered in [false, true] {
                let mut scene = Scene::default();
                scene.march.technique = technique;
                if layered {
                    scene.craters.mode = CraterMode::Layered;
                    scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
                }
                renderer.draw(&scene, &target).unwrap();
                let flat = renderer.ledger().shader_defs.iter().any(|def| def == "FLAT_CONSTANTS");
                assert_eq!(flat, software);
                pictures.push((target.read_color(&gpu).unwrap(), renderer.probe(&scene, [120, 80]).unwrap().steps));
            }
        }
        pictures
    };
    let (uniforms, varyings) = (draw(false), draw(true));
    for (index, (one, other)) in uniforms.iter().zip(&varyings).enumerate() {
        assert!(one == other, "variant {index} differs");
    }
}

/// A device that goes away ends in an error that the window can act on: never in a panic.
#[test]
fn a_lost_device_is_an_error() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let map = crate::heightfield::generate::generate(crate::heightfield::generate::Kind::Ridged, 33, 1);
    renderer.set_terrain(Arc::new(map)).unwrap();
    let target = Target::new(&gpu, [16, 16]);
    renderer.draw(&Scene::default(), &target).unwrap();
    gpu.device.destroy();
    // The loss is reported once the work in flight has ended.
    let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
    renderer.take_frame_time();
    assert!(gpu.lost().is_some(), "nobody noticed");
    assert!(matches!(renderer.draw(&Scene::default(), &target), Err(RenderError::DeviceLost(_))));
    assert!(matches!(renderer.probe(&Scene::default(), [8, 8]), Err(RenderError::DeviceLost(_))));
    assert!(target.read_color(&gpu).is_err(), "there is no picture any more");
    // A frame in flight may or may not have arrived; waiting for it must end.
    let _ = renderer.wait_frame_time();
}
