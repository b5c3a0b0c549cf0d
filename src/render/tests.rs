//! The renderer without a driver: layouts against the WGSL, and every pipeline variant.

use std::collections::BTreeMap;
use std::mem::offset_of;

use glam::{DVec2, DVec3, DVec4};
use rayon::prelude::*;

use super::air::{AirKey, AirUniform};
use super::anchor::AnchorUniform;
use super::clouds::{CloudsUniform, LayerUniform};
use super::cube::{clip_corners, in_view};
use super::flare::{FlareUniform, GhostUniform};
use super::frame::FrameUniform;
use super::light::{LightKey, LightUniform};
use super::light_map::LightMapKey;
use super::materials::MaterialsUniform;
use super::occluder::{CubeUniform, OccluderKey};
use super::pipelines::sources;
use super::terrain::{TerrainKey, TerrainUniform};
use super::water::{WaterBuffer, WaterKey};
use super::*;
use crate::camera::{Camera, NamedView};
use crate::gpu::COLOR_FORMAT;
use crate::scene::light::Shadows;
use crate::scene::{ColourSource, CraterMode, HeightFilter, Technique};

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
            texel_size,
            pyramid_stack,
            repeats_per_cell,
            pyramid_texel,
            layer_cells,
            samples,
            top_size,
            layer_rise,
            farthest,
            texel_density,
            binary_steps,
            step_cap,
            heat_map_max,
            repeats,
            diffuse,
            specular,
            shininess,
            height_unit,
            sun,
            ambient,
        ]
    );
    let lines = land::LandKey { contours: true, ..Default::default() };
    let pass = terrain::describe(TerrainKey { land: lines, ..key });
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Land",
        land::LandUniform,
        [
            ramp_low,
            ramp_middle,
            ramp_high,
            height_unit,
            contours_per_share,
            contour_offset,
            contour_width,
            slope_factor,
            slope_max,
            hillshade_strength,
            imagery_opacity,
            imagery_density,
            imagery_u,
            padding,
            imagery_v,
            imagery_texels,
        ]
    );
    let pass = terrain::describe(key.in_a_deep_zoom(true));
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Anchor",
        AnchorUniform,
        [
            origin,
            depth,
            origin_right,
            beam_shift,
            origin_down,
            begin,
            direction,
            height,
            direction_right,
            units,
            direction_down,
            relief,
            low,
            shares_per_unit,
            high,
            end,
            cell,
            fraction,
            grounds,
        ]
    );
    let mut scene = Scene::default();
    scene.diffuse.source = ColourSource::Materials;
    let pass = terrain::describe(TerrainKey::of(&scene, false));
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Materials", MaterialsUniform, [dark, light, levels, slopes, repeats, relief]);
    let pass = terrain::describe(TerrainKey { light: LightKey::all()[2], ..key });
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Light", LightUniform, [columns, shares, cube, sky, sun, cells_per_texel]);
    let pass = water::describe(WaterKey::some()[0]);
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Water",
        WaterBuffer,
        [
            cube,
            cube_sun,
            absorption_and_level,
            deep_and_submerged,
            sun_and_flattening,
            background_and_foam,
            foam_light_and_bubbles,
            drift,
            waves,
        ]
    );
    let pass = terrain::describe(TerrainKey { air: AirKey::all()[0], ..key });
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Air",
        AirUniform,
        [
            kilometres,
            molecules,
            haze,
            fog,
            fog_light,
            sun,
            sun_light,
            sky_light,
            mean,
            shadow_place,
            shadow_shear,
            shadow_levels,
            horizon
        ]
    );
    let pass = clouds::describe_shadow();
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Clouds", CloudsUniform, [layers, count, shadow, order, sun]);
    assert_layout!(&module, "CloudLayer", LayerUniform, [shape, first, second, offsets]);
    let pass = flare::describe();
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Flare", FlareUniform, [ghosts]);
    assert_layout!(&module, "Ghost", GhostUniform, [place, light]);
    let pass = occluder::describe(OccluderKey::default());
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Cube", CubeUniform, [clip, sun, ambient]);
}

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

/// Heights between 0 and 1 that look nowhere alike.
fn noise(x: u32, z: u32) -> f32 {
    let mut bits = (x.wrapping_mul(0x9e37_79b9)) ^ z.wrapping_mul(0x85eb_ca6b);
    for _ in 0..3 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    (bits >> 8) as f32 / (1u32 << 24) as f32
}

fn map_of(width: u32, height: u32, at: impl Fn(u32, u32) -> f32) -> Arc<HeightField> {
    let raw: Vec<f32> = (0..height).flat_map(|z| (0..width).map(move |x| (x, z))).map(|(x, z)| at(x, z)).collect();
    Arc::new(HeightField::from_raw(width, height, &raw).unwrap())
}

/// Eyes above, beside, in, below and far from a box of the size `extent`, looking along and across it.
fn hard_views(extent: DVec3) -> Vec<Camera> {
    let look = |eye: [f64; 3], target: [f64; 3], fov| {
        Camera::look_at(DVec3::from(eye) * extent, DVec3::from(target) * extent, fov)
    };
    vec![
        look([0.5, 1.4, 1.9], [0.5, 0.3, 0.4], 60.0),
        look([-0.4, 1.02, -0.3], [0.6, 0.9, 0.7], 50.0),
        look([-0.3, 0.5, 0.02], [1.0, 0.45, 0.05], 70.0),
        look([1.6, 0.3, 0.5], [0.0, 0.3, 0.5], 40.0),
        look([0.5, 0.98, 0.5], [0.1, 0.7, 0.9], 100.0),
        look([0.02, 0.6, 0.98], [0.9, 0.5, 0.1], 80.0),
        look([0.5, 2.5, 0.5001], [0.5, 0.0, 0.5], 60.0),
        look([0.4, -0.8, 0.6], [0.6, 0.4, 0.4], 60.0),
        look([0.5, 0.05, 0.5], [0.9, 0.4, 0.6], 70.0),
        look([300.0, 200.0, 500.0], [0.5, 0.5, 0.5], 0.15),
        look([0.5, 60.0, 30.0], [0.5, 0.5, 0.5], 12.0),
        look([1.3, 1.2, 1.5], [0.45, 0.2, 0.4], 0.01),
        look([-0.5, 0.9, 0.5], [0.7, 0.45, 0.5], 0.001),
    ]
}

/// A beam must stop before every ray of its tile does: with and without beams, every pixel shows the same.
#[test]
fn beams_hide_nothing() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
    let needles = |every: u32| move |x: u32, z: u32| if x % every == 3 && z % every == 5 { 1.0 } else { 0.0 };
    let maps = [
        ("2×2", map_of(2, 2, noise)),
        ("3×2", map_of(3, 2, noise)),
        ("5×9", map_of(5, 9, noise)),
        ("33×17", map_of(33, 17, noise)),
        ("65×130", map_of(65, 130, noise)),
        ("3×400", map_of(3, 400, noise)),
        ("needles", map_of(130, 130, needles(8))),
        ("few needles", map_of(257, 257, needles(64))),
        ("walls", map_of(129, 65, |x, z| if x == 40 || z == 64 || x == 128 { 1.0 } else { 0.01 * noise(x, z) })),
        ("rim", map_of(100, 100, |x, z| if x % 99 == 0 || z % 99 == 0 { 1.0 } else { 0.0 })),
    ];
    let (mut hits, mut saved) = (0, 0i64);
    for (name, map) in maps {
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        for scale in [0.05, 0.3, 2.0] {
            let extent = map.box_size(Some(scale));
            for (index, camera) in hard_views(extent).into_iter().enumerate() {
                let size = [[33, 17], [160, 100], [101, 64]][index % 3];
                let mut scene = Scene { camera: Some(camera), ..Scene::default() };
                scene.terrain.height_scale = Some(scale);
                let mut probe = |whole_rays| {
                    renderer.whole_rays = whole_rays;
                    renderer.probe(&scene, size).unwrap()
                };
                let (whole, beams) = (probe(true), probe(false));
                assert_eq!((whole.cap_hits, beams.cap_hits), (0, 0));
                // The distance is an f32; where the eye is far off its last bit is what may differ.
                let cell = extent.x.max(extent.z) / f64::from(map.width().max(map.height()));
                for (pixel, (&expected, &actual)) in whole.distance.iter().zip(&beams.distance).enumerate() {
                    let tolerance = (1e-4 * cell) as f32 + 4.0 * f32::EPSILON * expected.min(1e6);
                    let same = expected == actual || (expected - actual).abs() <= tolerance;
                    assert!(same, "{name}, {scale} high, view {index}, pixel {pixel}: {actual}, not {expected}");
                }
                hits += whole.distance.iter().filter(|distance| distance.is_finite()).count();
                let sum = |probe: &Probe| probe.steps.iter().map(|&steps| i64::from(steps)).sum::<i64>();
                saved += sum(&whole) - sum(&beams);
            }
        }
    }
    assert!(hits > 300_000, "only {hits} pixels show ground");
    assert!(saved > hits as i64, "beams save only {saved} steps for {hits} hits");
}

/// One cell has one patch, four texels; the beams' few are shared by their tiles.
#[test]
fn texel_reads_are_those_of_nodes_cells_and_beams() {
    let mut renderer = Renderer::new(Gpu::headless().unwrap()).unwrap();
    let size = [64, 48];
    let mut scene = Scene::default();
    let mut count = |map: Arc<HeightField>| {
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        scene.camera = Some(NamedView::Down.camera(&map, map.box_size(None)));
        let probe = renderer.probe(&scene, size).unwrap();
        let reads = renderer.texel_reads(&scene, size).unwrap();
        assert_eq!(renderer.probe(&scene, size).unwrap().steps, probe.steps, "counting leaves nothing behind");
        let hits = probe.distance.iter().map(|distance| distance.is_finite());
        let hits: Vec<_> =
            hits.zip(probe.steps).zip(reads).filter(|((hit, _), _)| *hit).map(|(pair, r)| (pair.1, r)).collect();
        assert!(hits.len() > 1000, "{}", hits.len());
        hits
    };
    for (steps, reads) in count(map_of(2, 2, |x, _| x as f32)) {
        // A cell, and the node above it where the ray starts there; the beam's texel and at most three of its own.
        assert!(steps <= 2, "{steps}");
        assert!((steps + 4..steps + 8).contains(&reads), "{steps} steps, {reads} texels");
    }
    for (steps, reads) in count(map_of(65, 65, noise)) {
        assert!(reads >= steps + 3 && reads <= 4 * steps + 40, "{steps} steps, {reads} texels");
    }
}

/// A rasteriser may move a corner by a sixteenth of a pixel, from however far the box is seen; what then lies outside of
/// it is not drawn, though its ray may meet the terrain.
#[test]
fn the_drawn_box_is_an_eighth_of_a_pixel_wider_than_the_terrains() {
    let size = [64, 48];
    let in_pixels = |corner: &DVec4| DVec2::new(corner.x / corner.w * 32.0, corner.y / corner.w * 24.0);
    let farthest = |corners: &[DVec4; 8], along: DVec2| {
        corners.iter().map(|corner| in_pixels(corner).dot(along)).fold(f64::NEG_INFINITY, f64::max)
    };
    let mut seen = 0;
    for index in 0..3000u32 {
        let number =
            |stream: u32| f64::from((index * 8 + stream).wrapping_mul(0x9e37_79b1) >> 8) / f64::from(1u32 << 24);
        let extent = DVec3::new(1.0, 0.01 + number(0), 0.05 + 0.95 * number(1));
        let away = DVec3::new(number(2) - 0.5, number(3) - 0.5, number(4) - 0.5).normalize_or(DVec3::X);
        let distance = 2.0 * 10f64.powf(5.0 * number(5));
        let camera = Camera::look_at(extent * 0.5 + away * distance, extent * 0.5, 1.0 + 99.0 * number(6));
        let world_from_cube = glam::DMat4::from_scale(extent);
        let (plain, drawn) =
            (clip_corners(camera.clip_from_world(size), world_from_cube), terrain::drawn_box(&camera, size, extent));
        assert!(in_view(&plain) && in_view(&drawn));
        for angle in 0..64 {
            let along = DVec2::from_angle(f64::from(angle) * std::f64::consts::TAU / 64.0);
            let wider = farthest(&drawn, along) - farthest(&plain, along);
            assert!(wider >= 0.125, "{wider} pixels at {along}, {camera:?}, {extent}");
            seen += 1;
        }
    }
    assert_eq!(seen, 3000 * 64);
}
