//! The renderer without a driver: layouts against the WGSL, and every pipeline variant.

use std::collections::BTreeMap;
use std::mem::offset_of;

use super::frame::FrameUniform;
use super::occluder::CubeUniform;
use super::terrain::{TerrainKey, TerrainUniform};
use super::*;
use crate::gpu::{COLOR_FORMAT, ShaderSources};
use crate::scene::{CraterMode, HeightFilter, Technique};

fn sources() -> ShaderSources {
    ShaderSources::embedded(vec![("heat_map", heat_map::wgsl())])
}

/// Offsets and size of a WGSL struct, as naga laid it out. naga_oil decorates names, so the struct is found by its stem.
fn wgsl_layout(module: &naga::Module, name: &str) -> (BTreeMap<String, u32>, u32) {
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref().is_some_and(|full| full == name || full.starts_with(&format!("{name}X_"))))
        .unwrap_or_else(|| panic!("no struct {name} in the shader"));
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is no struct") };
    (members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect(), *span)
}

macro_rules! assert_layout {
    ($module:expr, $wgsl:literal, $rust:ty, [$($field:ident),* $(,)?]) => {
        let (offsets, span) = wgsl_layout($module, $wgsl);
        let expected: BTreeMap<String, u32> =
            [$((stringify!($field).to_owned(), offset_of!($rust, $field) as u32)),*].into();
        assert_eq!(offsets, expected, "offsets of {}", $wgsl);
        assert_eq!(span as usize, size_of::<$rust>(), "size of {}", $wgsl);
    };
}

#[test]
fn rust_and_wgsl_agree_on_every_uniform() {
    let key = TerrainKey::of(&Scene::default(), false);
    let pass = terrain::describe(key);
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Frame",
        FrameUniform,
        [
            clip_from_world,
            ray_origin,
            ray_start,
            ray_origin_right,
            pixel_size,
            ray_origin_down,
            padding,
            ray_direction,
            flattening,
            ray_direction_right,
            centre_x,
            ray_direction_down,
            centre_y,
        ]
    );
    assert_layout!(
        &module,
        "Terrain",
        TerrainUniform,
        [
            box_clip,
            size,
            highest,
            cells,
            cells_per_unit,
            samples,
            binary_steps,
            top_level,
            step_cap,
            layer_rise,
            layer_cells,
            sun,
            ambient,
            diffuse,
            specular,
            shininess,
            repeats,
            texel_density,
            heat_map_max,
            padding,
        ]
    );
    let pass = occluder::describe(false);
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Cube", CubeUniform, [clip, sun, ambient]);
}

/// wgpu validates bindings, interfaces and formats of each pipeline on a device that does nothing.
#[test]
fn every_reachable_pipeline_builds_and_binds_just_what_its_shader_uses() {
    let gpu = Gpu::noop();
    let frame = FrameBindings::new(&gpu);
    let keys = TerrainKey::all();
    assert!(keys.len() > 100, "the list of variants has shrunk to {}", keys.len());
    let mut all: Vec<_> = keys.into_iter().map(PipelineKey::Terrain).collect();
    all.extend([
        PipelineKey::Wireframe,
        PipelineKey::Occluder { probe: false },
        PipelineKey::Occluder { probe: true },
        PipelineKey::Skybox,
        PipelineKey::Present(wgpu::TextureFormat::Bgra8Unorm),
        PipelineKey::Present(COLOR_FORMAT),
    ]);
    for key in all {
        let mut pipelines = Pipelines::new();
        if let Err(error) = pipelines.get(&gpu, &frame.layout, key) {
            panic!("{key:?}: {error}");
        }
    }
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
    for absent in ["ground_normal", "diffuse_texture", "pyramid", "intersect_patch", "height_sampler", "crater_layer"] {
        assert!(!bare.contains(absent), "{absent} is in {bare}");
    }
    let mut layered = Scene::default();
    layered.craters.mode = CraterMode::Layered;
    assert!(!names(&layered).contains("crater_layer"), "without craters there is no layer");
    layered.craters.list.push(layered.craters.brush_at(0.5, 0.5));
    assert!(names(&layered).contains("crater_layer"));
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
