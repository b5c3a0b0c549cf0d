//! A scene pays only for what it shows: what is off, out of view or unchanged is not in the ledger.
//!
//! `cargo test --test ledger -- --nocapture` prints the ledgers.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::sync::Arc;

use common::pictures::{Difference, Tolerance};
use common::{SIZE, canyon, craters, gpu, picture, renderer, scene_at, scene_from};
use glam::DVec3;
use relief::camera::{Camera, NamedView};
use relief::gpu::{Gpu, Target};
use relief::heightfield::{Crater, HeightField};
use relief::render::{Ledger, Renderer};
use relief::scene::{CraterMode, DebugView, Scene, Technique};

/// Draws a frame; what it cost.
fn frame(renderer: &mut Renderer, scene: &Scene) -> Ledger {
    let target = Target::new(&gpu(), SIZE);
    renderer.draw(scene, &target).unwrap();
    renderer.ledger().clone()
}

/// What a first frame of the canyon costs.
fn first_frame(scene: &Scene) -> Ledger {
    frame(&mut renderer(&canyon()), scene)
}

fn textures(ledger: &Ledger) -> Vec<&str> {
    ledger.textures.iter().map(|texture| texture.name.as_str()).collect()
}

fn has_def(ledger: &Ledger, def: &str) -> bool {
    ledger.shader_defs.iter().any(|name| name == def)
}

fn has_texture(ledger: &Ledger, name: &str) -> bool {
    textures(ledger).contains(&name)
}

fn start() -> Scene {
    scene_at(NamedView::Start, &canyon())
}

/// Looking straight down from where the ground fills the picture.
fn close_down() -> Scene {
    let extent = canyon().box_size(None);
    let eye = DVec3::new(0.5 * extent.x, extent.y + 0.2, 0.5 * extent.z);
    Scene { camera: Some(Camera { eye, yaw: 0.0, pitch: -90.0, fov: 60.0 }), ..Scene::default() }
}

fn everything_off() -> Scene {
    let mut scene = start();
    scene.lighting.enabled = false;
    scene.diffuse.enabled = false;
    scene.skybox.enabled = false;
    scene.march.technique = Technique::Linear;
    scene.march.steps_by_angle = false;
    scene.march.lower_start = false;
    scene.march.discard_misses = false;
    scene
}

fn print(name: &str, ledger: &Ledger) {
    println!("\n{name}\n  passes     {}\n  draws      {}", ledger.passes.join(", "), ledger.draws);
    println!("  defs       {}\n  uploaded   {} bytes", ledger.shader_defs.join(" "), ledger.uploaded_bytes);
    for texture in &ledger.textures {
        println!(
            "  texture    {:12} {}×{}×{}, {} mips, {}, {} bytes",
            texture.name, texture.width, texture.height, texture.layers, texture.mips, texture.format, texture.bytes
        );
    }
    println!("  all        {} bytes\n  pipelines  {}", ledger.texture_bytes, ledger.pipelines.join(", "));
    if let Some(pixels) = ledger.sky_pixels {
        println!("  sky        {pixels} pixels shaded");
    }
}

#[test]
fn everything_off_costs_one_draw_and_one_texture() {
    let ledger = first_frame(&everything_off());
    print("everything off", &ledger);
    assert_eq!(ledger.passes, ["terrain"]);
    assert_eq!(ledger.draws, 1);
    assert_eq!(textures(&ledger), ["heights", "picture", "depth"]);
    // How constants reach the shader is the adapter's affair.
    let defs: Vec<_> = ledger.shader_defs.iter().filter(|def| *def != "FLAT_CONSTANTS").collect();
    assert_eq!(defs, ["SHADED"]);
    assert_eq!(ledger.pipelines.len(), 1);
    let sum: u64 = ledger.textures.iter().map(|texture| texture.bytes).sum();
    assert_eq!(ledger.texture_bytes, sum);
    let bytes = 512 * 512 * if gpu().capabilities.unorm16 { 2 } else { 4 };
    assert_eq!(ledger.textures[0].bytes, bytes);
    assert_eq!(ledger.uploaded_bytes, bytes, "the heights, and nothing else");
}

/// Heights that 16 bits hold take no more; where the adapter has no such textures, or the map needs floats, all is as
/// exact with floats.
#[test]
fn sixteen_bits_are_used_where_they_suffice_and_floats_show_the_same() {
    let bare = Gpu::headless_with(wgpu::Features::empty()).unwrap();
    bare.device.on_uncaptured_error(Arc::new(|error| panic!("the GPU reported: {error}")));
    let without = bare.capabilities;
    assert!(!(without.unorm16 || without.timestamps || without.filterable_float32));
    let mut floats = Renderer::new(Arc::clone(&bare)).unwrap();
    floats.set_terrain(canyon()).unwrap();
    let mut scene = start();
    scene.craters.list = craters(&canyon());
    let target = Target::new(&bare, SIZE);
    floats.draw(&scene, &target).unwrap();
    let expected = target.read_color(&bare).unwrap();
    let formats = |ledger: &Ledger| -> Vec<String> {
        let ground = ledger.textures.iter().filter(|texture| texture.name == "heights" || texture.name == "pyramid");
        ground.map(|texture| texture.format.clone()).collect()
    };
    assert_eq!(formats(floats.ledger()), ["R32Float", "R32Float"]);
    if !gpu().capabilities.unorm16 {
        println!("this adapter has no 16-bit textures");
        return;
    }
    let mut renderer = renderer(&canyon());
    assert_eq!(formats(&frame(&mut renderer, &scene)), ["R16Unorm", "R16Unorm"]);
    // The two differ by rounding alone: on edges by a pixel now and then.
    let tolerance = Tolerance { channel: 2, pixels: 1e-4 };
    let difference = Difference::of(&expected, &picture(&mut renderer, &scene), tolerance).unwrap();
    assert!(difference.is_within(tolerance), "{} pixels", difference.pixels);

    let raw: Vec<f32> = canyon().samples().iter().map(|height| height + 0.1 * height * height).collect();
    renderer.set_terrain(Arc::new(HeightField::from_raw(512, 512, &raw).unwrap())).unwrap();
    assert_eq!(formats(&frame(&mut renderer, &scene)), ["R32Float", "R32Float"]);
}

#[test]
fn the_defaults_cost_what_they_show() {
    let mut renderer = renderer(&canyon());
    let ledger = frame(&mut renderer, &start());
    print("defaults", &ledger);
    assert_eq!(ledger.passes, ["coarse beam", "beam", "terrain", "skybox"]);
    assert_eq!(ledger.draws, 4);
    assert_eq!(textures(&ledger), ["heights", "pyramid", "diffuse", "sky", "coarse beam", "beam", "picture", "depth"]);
    for def in ["SHADED", "LIGHTING", "SURFACE_NORMAL", "DIFFUSE_TEXTURE", "LOWER_START", "DISCARD_MISSES"] {
        assert!(has_def(&ledger, def), "{def}");
    }
    let again = frame(&mut renderer, &start());
    assert_eq!(again.uploaded_bytes, 0, "a frame of the same scene uploads nothing");
    assert_eq!((again.scene_frames, again.pipelines), (2, ledger.pipelines));
}

/// A change of the panel alone shows the kept picture again, and draws, uploads and builds nothing else.
#[test]
fn the_kept_picture_is_shown_without_drawing_the_scene() {
    let (gpu, mut renderer) = (gpu(), renderer(&canyon()));
    let target = Target::new(&gpu, SIZE);
    renderer.draw(&start(), &target).unwrap();
    let drawn = renderer.ledger().clone();
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let window = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("window"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = window.create_view(&wgpu::TextureViewDescriptor::default());
    for panel in [7, 5, 5] {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::RED), store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        renderer.present(&mut pass, format, &target).unwrap();
        drop(pass);
        renderer.note_pass("egui", panel);
        gpu.queue.submit([encoder.finish()]);
        let ledger = renderer.ledger();
        let passes: Vec<_> = drawn.passes.iter().map(String::as_str).chain(["present", "egui"]).collect();
        assert_eq!(ledger.passes, passes, "each is listed once, however often it is shown");
        assert_eq!(ledger.draws, drawn.draws + 1 + panel);
        assert_eq!((ledger.scene_frames, ledger.uploaded_bytes), (drawn.scene_frames, drawn.uploaded_bytes));
        assert_eq!((&ledger.textures, &ledger.pipelines), (&drawn.textures, &drawn.pipelines));
    }
    let shown = relief::gpu::read_texture(&gpu, &window).unwrap();
    assert_eq!(shown, target.read_color(&gpu).unwrap().into_raw(), "and it is that picture");
}

#[test]
fn baked_craters_cost_their_own_samples_once() {
    let mut renderer = renderer(&canyon());
    let without = frame(&mut renderer, &start());
    let mut scene = start();
    scene.craters.list = vec![scene.craters.brush_at(0.5, 0.5)];
    let edit = frame(&mut renderer, &scene);
    print("craters baked, the crater's frame", &edit);
    assert!(edit.uploaded_bytes > 0);
    let of_the_ground = |name: &str| ["heights", "pyramid", "diffuse"].contains(&name);
    let ground = without.textures.iter().filter(|texture| of_the_ground(&texture.name));
    let all: u64 = ground.map(|texture| texture.bytes).sum();
    assert!(edit.uploaded_bytes * 100 < all * 3, "{} of the ground's {all} bytes", edit.uploaded_bytes);
    let after = frame(&mut renderer, &scene);
    print("craters baked, after it", &after);
    assert_eq!(after.uploaded_bytes, 0);
    let cost = |ledger: &Ledger| Ledger { uploaded_bytes: 0, scene_frames: 0, ..ledger.clone() };
    assert_eq!(cost(&after), cost(&without), "the same passes, draws, defs, textures and pipelines as without craters");
}

#[test]
fn layered_craters_cost_a_texture_and_its_pipeline() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    scene.craters.mode = CraterMode::Layered;
    let none = frame(&mut renderer, &scene);
    assert!(!has_texture(&none, "crater layer") && !has_def(&none, "CRATERS_LAYERED"), "layered, but no crater");
    scene.craters.list = craters(&canyon());
    let layered = frame(&mut renderer, &scene);
    print("craters layered", &layered);
    assert!(has_texture(&layered, "crater layer") && has_def(&layered, "CRATERS_LAYERED"));
    assert_eq!(layered.draws, none.draws);
    let layer = layered.textures.iter().find(|texture| texture.name == "crater layer").unwrap();
    assert_eq!(layer.width.max(layer.height), scene.craters.layer_resolution);
    assert_eq!(layered.texture_bytes, none.texture_bytes + layer.bytes);
    assert_eq!(layered.pipelines.len(), none.pipelines.len() + 1);
    assert_eq!(frame(&mut renderer, &scene).uploaded_bytes, 0);
    scene.craters.mode = CraterMode::Baked;
    let baked = frame(&mut renderer, &scene);
    assert!(!has_texture(&baked, "crater layer") && !has_def(&baked, "CRATERS_LAYERED"));
    assert_eq!(baked.texture_bytes, none.texture_bytes);
}

#[test]
fn a_view_filled_by_terrain_shades_no_sky() {
    let mut renderer = renderer(&canyon());
    let target = Target::new(&gpu(), SIZE);
    assert_eq!(renderer.count_sky_pixels(&close_down(), &target).unwrap(), 0);
    print("looking straight down", renderer.ledger());
    assert_eq!(renderer.ledger().sky_pixels, Some(0));
    let scene = start();
    let shaded = renderer.count_sky_pixels(&scene, &target).unwrap();
    let probe = renderer.probe(&scene, SIZE).unwrap();
    let sky = probe.distance.iter().filter(|distance| distance.is_infinite()).count();
    assert!(sky > 1000);
    assert_eq!(shaded, sky as u64, "the skybox shades just the pixels that nothing else covers");
    let mut off = scene;
    off.skybox.enabled = false;
    assert_eq!(renderer.count_sky_pixels(&off, &target).unwrap(), 0);
}

#[test]
fn an_occluder_costs_only_while_it_is_in_view() {
    let mut renderer = renderer(&canyon());
    let off = frame(&mut renderer, &start());
    let mut scene = start();
    scene.occluder.enabled = true;
    scene.occluder.position = Some(DVec3::new(0.5, 0.1, 9.0));
    let behind = frame(&mut renderer, &scene);
    print("occluder out of view", &behind);
    assert_eq!((&behind.passes, behind.draws, &behind.pipelines), (&off.passes, off.draws, &off.pipelines));
    scene.occluder.position = None;
    let seen = frame(&mut renderer, &scene);
    assert_eq!(seen.passes, ["coarse beam", "beam", "terrain", "occluder", "skybox"]);
    assert_eq!(seen.texture_bytes, off.texture_bytes);
}

#[test]
fn terrain_out_of_view_is_not_drawn() {
    let map = canyon();
    let scene = scene_from(&map, [0.5, 3.0, 2.0], [0.5, 3.0, 9.0], 60.0);
    let ledger = first_frame(&scene);
    print("terrain out of view", &ledger);
    assert_eq!(ledger.passes, ["skybox"]);
    assert_eq!(ledger.draws, 1);
    assert!(ledger.shader_defs.is_empty());
    assert_eq!(ledger.pipelines.len(), 1, "not even its pipeline is built");
}

/// One toggle at a time, off from the defaults.
#[test]
fn what_is_off_has_no_def_and_no_texture() {
    let cheaper = |change: &dyn Fn(&mut Scene)| {
        let mut scene = start();
        change(&mut scene);
        first_frame(&scene)
    };
    let dark = cheaper(&|scene| scene.lighting.enabled = false);
    assert!(!has_def(&dark, "LIGHTING") && !has_def(&dark, "SURFACE_NORMAL"), "{:?}", dark.shader_defs);
    let plain = cheaper(&|scene| scene.diffuse.enabled = false);
    assert!(!has_def(&plain, "DIFFUSE_TEXTURE") && !has_texture(&plain, "diffuse"));
    let bare = cheaper(&|scene| scene.skybox.enabled = false);
    assert!(!has_texture(&bare, "sky") && bare.passes == ["coarse beam", "beam", "terrain"]);
    for technique in [Technique::Linear, Technique::LinearBinary, Technique::Secant] {
        let sampled = cheaper(&|scene| scene.march.technique = technique);
        let built = ["pyramid", "beam", "cones"].map(|name| has_texture(&sampled, name));
        assert_eq!(built, [false; 3], "{technique:?}");
        assert_eq!(sampled.passes, ["terrain", "skybox"], "{technique:?}");
    }
    let position = cheaper(&|scene| scene.debug.view = DebugView::Position);
    assert_eq!(position.shader_defs, ["VIEW_POSITION"], "no ray, no light, no colour");
    assert!(
        !has_texture(&position, "beam") && !has_texture(&position, "pyramid") && !has_texture(&position, "diffuse")
    );
    let steps = cheaper(&|scene| scene.debug.view = DebugView::Steps);
    assert!(!has_def(&steps, "LIGHTING") && !has_texture(&steps, "diffuse"));
}

/// Cones are in memory while a technique steps along them, and found once for a ground.
#[test]
fn cones_are_there_while_they_are_stepped_along() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    let heights = canyon();
    let cells = u64::from(heights.cells()[0]) * u64::from(heights.cells()[1]);
    for (technique, bytes) in [(Technique::Cone, 4 * cells), (Technique::RelaxedCone, 8 * cells)] {
        scene.march.technique = technique;
        let first = frame(&mut renderer, &scene);
        let cones = first.textures.iter().find(|texture| texture.name == "cones").unwrap();
        assert_eq!(cones.bytes, bytes, "{technique:?}");
        assert!(!has_texture(&first, "pyramid") && !has_texture(&first, "beam"), "{technique:?}");
        assert!(first.uploaded_bytes >= bytes);
        assert_eq!(frame(&mut renderer, &scene).uploaded_bytes, 0, "{technique:?}: they are kept");
    }
    scene.march.technique = Technique::Linear;
    assert!(!has_texture(&frame(&mut renderer, &scene), "cones"));
    // Prepared before a frame, they are not sought in it.
    scene.march.technique = Technique::Cone;
    scene.craters.list = craters(&canyon());
    let heard = std::sync::atomic::AtomicU32::new(0);
    let count = |_: f32| {
        heard.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    };
    renderer.prepare_cones(&scene, &count);
    let rows = heard.load(std::sync::atomic::Ordering::Relaxed);
    assert_eq!(rows, heights.cells()[1], "a report for each row");
    renderer.prepare_cones(&scene, &count);
    assert_eq!(heard.load(std::sync::atomic::Ordering::Relaxed), rows, "they are there already");
    assert!(has_texture(&frame(&mut renderer, &scene), "cones"));
}

/// What bounds invented detail is costly to make: what is asked between two pictures must leave it, and the pyramid over it,
/// where they are.
#[test]
fn questions_between_pictures_leave_the_bounds_alone() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    scene.water.enabled = true;
    scene.compare.enabled = true;
    (scene.march.technique, scene.compare.technique) = (Technique::Fractal, Technique::Smooth);
    assert!(frame(&mut renderer, &scene).uploaded_bytes > 0);
    let found = renderer.probe_water(&scene, SIZE).unwrap();
    assert!(found.iter().any(Option::is_some), "there is water to ask for");
    assert_eq!(frame(&mut renderer, &scene).uploaded_bytes, 0, "probe_water");
    scene.compare.technique = Technique::Cone;
    frame(&mut renderer, &scene);
    // The other way round it is the cones that are found before the next picture.
    std::mem::swap(&mut scene.march.technique, &mut scene.compare.technique);
    renderer.prepare_cones(&scene, &|_| {});
    assert_eq!(frame(&mut renderer, &scene).uploaded_bytes, 0, "prepare_cones");
}

/// What was on and is off again leaves no texture behind.
#[test]
fn what_is_switched_off_is_given_back() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    frame(&mut renderer, &scene);
    scene.craters.mode = CraterMode::Layered;
    scene.craters.list = craters(&canyon());
    frame(&mut renderer, &scene);
    let off = frame(&mut renderer, &everything_off());
    assert_eq!(textures(&off), ["heights", "picture", "depth"]);
    assert_eq!(off.passes, ["terrain"]);
}

#[test]
fn pipelines_are_built_on_first_use_and_kept() {
    let mut renderer = Renderer::new(gpu()).unwrap();
    assert!(renderer.ledger().pipelines.is_empty());
    renderer.set_terrain(canyon()).unwrap();
    let mut lit = start();
    let mut dark = start();
    dark.lighting.enabled = false;
    assert_eq!(frame(&mut renderer, &lit).pipelines.len(), 4, "two beams, terrain and skybox");
    assert_eq!(frame(&mut renderer, &dark).pipelines.len(), 5, "another terrain");
    assert_eq!(frame(&mut renderer, &lit).pipelines.len(), 5, "back to one that is there");
    // Numbers are not compiled in, and neither is what the technique does not use.
    lit.lighting.ambient = 0.5;
    lit.march.samples_max = 100;
    lit.march.steps_by_angle = false;
    lit.terrain.height_scale = Some(0.3);
    lit.craters.list = vec![Crater { x: 0.5, z: 0.5, radius: 0.1, depth: 0.1, rim: 0.0 }];
    assert_eq!(frame(&mut renderer, &lit).pipelines.len(), 5);
}

/// The exact distances that the error view compares with cost a pass and a texture, and only that view has them.
#[test]
fn the_error_view_pays_for_its_exact_distances_and_nothing_else_does() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    scene.march.technique = Technique::LinearBinary;
    let off = frame(&mut renderer, &scene);
    assert_eq!(off.passes, ["terrain", "skybox"]);
    scene.debug.view = DebugView::Error;
    let on = frame(&mut renderer, &scene);
    print("error view", &on);
    assert_eq!(on.passes, ["coarse beam", "beam", "exact", "terrain"]);
    assert_eq!(on.draws, 4);
    assert_eq!(textures(&on), ["heights", "pyramid", "coarse beam", "beam", "exact", "picture", "depth"]);
    assert!(has_def(&on, "VIEW_ERROR") && !has_def(&on, "BEAM"));
    let size = (SIZE[0] * SIZE[1]) as usize;
    renderer.set_reference(SIZE, Some(&vec![f32::INFINITY; size])).unwrap();
    let given = frame(&mut renderer, &scene);
    print("error view against given distances", &given);
    assert_eq!(given.passes, ["terrain"], "given distances need not be found");
    assert_eq!(textures(&given), ["heights", "reference", "picture", "depth"]);
    assert!(renderer.shows_reference());
    renderer.set_reference(SIZE, None).unwrap();
    assert_eq!(frame(&mut renderer, &scene).passes, on.passes);
    renderer.set_reference(SIZE, Some(&vec![1.0; size])).unwrap();
    scene.debug.view = DebugView::None;
    let again = frame(&mut renderer, &scene);
    assert_eq!((again.passes, textures(&off)), (off.passes.clone(), again.textures.iter().map(|t| &*t.name).collect()));
    assert!(renderer.set_reference(SIZE, Some(&[1.0])).is_err(), "one distance per pixel");
}

/// Two techniques cost two draws; beams are cast only where a side starts from them.
#[test]
fn a_comparison_costs_a_draw_and_only_while_it_shows() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    let off = frame(&mut renderer, &scene);
    assert!(!off.passes.contains(&"compare".to_owned()));
    scene.compare.enabled = true;
    scene.compare.technique = Technique::Linear;
    let on = frame(&mut renderer, &scene);
    print("compared", &on);
    assert_eq!(on.passes, ["coarse beam", "beam", "terrain", "compare", "skybox"]);
    assert_eq!((on.draws, textures(&on)), (off.draws + 1, textures(&off)), "no texture of its own");
    scene.march.technique = Technique::LinearBinary;
    let sampled = frame(&mut renderer, &scene);
    assert_eq!(sampled.passes, ["terrain", "compare", "skybox"], "neither side starts from beams");
    assert!(!has_texture(&sampled, "pyramid") && !has_texture(&sampled, "beam"));
    scene.march.technique = Technique::MaxMipmap;
    scene.compare.share = 0.0;
    let right = frame(&mut renderer, &scene);
    assert_eq!(right.passes, ["compare", "skybox"], "a side without pixels is not drawn");
    assert!(!has_texture(&right, "pyramid"));
    scene.compare.share = 1.0;
    assert_eq!(frame(&mut renderer, &scene).passes, off.passes);
    scene.compare.share = 0.5;
    scene.compare.technique = scene.march.technique;
    assert_eq!(frame(&mut renderer, &scene).passes, off.passes, "a technique is not compared with itself");
}
