//! What everything costs, as ratios: techniques and craters on the GPU, and the CPU's part.
//!
//! All variants of a view are measured in one run, in turn, so that whatever else the machine does falls on all of them.
//! A turn is five frames, of which the last three count: who flies over a terrain sees frames that follow their like, with
//! the map in the caches, not one that fetches anew what the textures of five other renderers have just displaced (that
//! costs a frame of the exact technique some 15 %, one of `linear-binary` 2 %). `cargo bench` prints the medians;
//! `cargo bench -- --quick` takes few rounds. `RELIEF_ADAPTER` chooses the adapter.
#![expect(clippy::unwrap_used, reason = "a benchmark may fail loudly")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use relief::camera::NamedView;
use relief::gpu::{Gpu, Target};
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::reference::Surface;
use relief::heightfield::{ConeKind, ConeMap, Crater, EditedTerrain, HeightField, MaxPyramid};
use relief::render::Renderer;
use relief::scene::{CraterMode, Scene, Technique};

/// Size of the frames.
const SIZE: [u32; 2] = [640, 400];

/// Turns of each variant before the first that counts: pipelines compile, textures are uploaded.
const WARM_UP: usize = 1;

/// Frames of a turn that do not count, and those that do.
const TURN: (usize, usize) = (2, 3);

/// The speed-up over the study's technique that `max-mipmap` is held to.
const GOAL: f64 = 4.0;

fn main() {
    // Cargo passes `--bench`; whatever else it may pass is no concern of a harness without filters.
    let rounds = if std::env::args().any(|argument| argument == "--quick") { 5 } else { 21 };
    let map = Arc::new(generate(Kind::DiamondSquare, 1024, 1));
    let gpu = Gpu::headless().unwrap();
    let (adapter, driver) = gpu.adapter_name();
    println!(
        "{adapter}, {driver}\n1024×1024 fractal, {} × {}, median of {rounds} interleaved rounds of {} frames",
        SIZE[0], SIZE[1], TURN.1
    );
    for dressed in [true, false] {
        techniques(&gpu, &map, rounds, dressed);
    }
    crater_modes(&gpu, &map, rounds);
    cpu(&map, rounds);
}

/// A renderer with one scene, so that a round switches between variants without an upload.
struct Variant {
    renderer: Renderer,
    scene: Scene,
    times: Vec<f64>,
}

impl Variant {
    fn new(gpu: &Arc<Gpu>, map: &Arc<HeightField>, scene: Scene) -> Self {
        let mut renderer = Renderer::new(Arc::clone(gpu)).unwrap();
        renderer.set_terrain(Arc::clone(map)).unwrap();
        Self { renderer, scene, times: Vec::new() }
    }
}

/// Median frame times in milliseconds, of all variants in turn.
fn measure(gpu: &Arc<Gpu>, variants: &mut [Variant], rounds: usize) -> Vec<f64> {
    let target = Target::new(gpu, SIZE);
    for variant in &mut *variants {
        variant.times.clear();
    }
    for round in 0..WARM_UP + rounds {
        for Variant { renderer, scene, times } in &mut *variants {
            for frame in 0..TURN.0 + TURN.1 {
                renderer.draw(scene, &target).unwrap();
                let time = renderer.wait_frame_time().unwrap();
                if round >= WARM_UP && frame >= TURN.0 {
                    times.push(time);
                }
            }
        }
    }
    variants.iter_mut().map(|variant| median(&mut variant.times)).collect()
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A frame of every technique: `dressed` in light, colours and sky, which cost all of them the same, or without, so that
/// little but rays is left.
fn techniques(gpu: &Arc<Gpu>, map: &Arc<HeightField>, rounds: usize, dressed: bool) {
    let what = if dressed { "whole frames" } else { "unlit, without colours and sky" };
    println!("\ntechnique against linear-binary 128–512 with 8 halvings, {what}: ms, and how many times as fast");
    let order = [
        Technique::LinearBinary,
        Technique::Linear,
        Technique::Secant,
        Technique::Cone,
        Technique::RelaxedCone,
        Technique::MaxMipmap,
    ];
    print!("{:10} {:>14}", "view", order[0].name());
    order[1..].iter().for_each(|technique| print!(" {:>18}", technique.name()));
    println!("   max-mipmap at least {GOAL}×");
    let scenes = order.map(|technique| {
        let mut scene = Scene::default();
        scene.march.technique = technique;
        (scene.lighting.enabled, scene.diffuse.enabled, scene.skybox.enabled) = (dressed, dressed, dressed);
        scene
    });
    let mut variants = scenes.map(|scene| Variant::new(gpu, map, scene));
    for view in NamedView::MEASURED {
        for variant in &mut variants {
            variant.scene.camera = Some(view.camera(map, map.box_size(None)));
        }
        let ms = measure(gpu, &mut variants, rounds);
        print!("{:10} {:14.2}", view.name(), ms[0]);
        ms[1..].iter().for_each(|other| print!(" {other:9.2} {:7.2}×", ms[0] / other));
        let reached = ms.last().is_some_and(|exact| ms[0] / exact >= GOAL);
        println!("   {}", if reached { "yes" } else { "NO" });
    }
}

/// Ten craters in two rows.
fn craters(map: &HeightField) -> Vec<Crater> {
    let extent = map.box_size(None);
    let place = |index: u32| (f64::from(index % 5) * 0.18 + 0.14, f64::from(index / 5) * 0.4 + 0.3);
    let crater = |(u, v): (f64, f64)| Crater { x: u * extent.x, z: v * extent.z, radius: 0.05, depth: 0.3, rim: 0.08 };
    (0..10).map(|index| crater(place(index))).collect()
}

fn crater_modes(gpu: &Arc<Gpu>, map: &Arc<HeightField>, rounds: usize) {
    for technique in [Technique::LinearBinary, Technique::MaxMipmap] {
        println!("\nten craters, {}: ms, and how many times the frame without", technique.name());
        println!("{:10} {:>8} {:>18} {:>18}   layered / baked", "view", "none", "baked", "layered");
        let scene = |mode: Option<CraterMode>| {
            let mut scene = Scene::default();
            scene.march.technique = technique;
            if let Some(mode) = mode {
                scene.craters.mode = mode;
                scene.craters.list = craters(map);
            }
            scene
        };
        let mut variants =
            [None, Some(CraterMode::Baked), Some(CraterMode::Layered)].map(|mode| Variant::new(gpu, map, scene(mode)));
        for view in NamedView::MEASURED {
            for variant in &mut variants {
                variant.scene.camera = Some(view.camera(map, map.box_size(None)));
            }
            let ms = measure(gpu, &mut variants, rounds);
            println!(
                "{:10} {:8.2} {:9.2} {:7.2}× {:9.2} {:7.2}×   {:.2}×",
                view.name(),
                ms[0],
                ms[1],
                ms[1] / ms[0],
                ms[2],
                ms[2] / ms[0],
                ms[2] / ms[1],
            );
        }
    }
}

/// A part of the CPU's work, by name.
type Work<'a> = (&'static str, Box<dyn FnMut() + 'a>);

/// The parts that the CPU does, in turn like the frames.
fn cpu(map: &Arc<HeightField>, rounds: usize) {
    println!("\non the CPU: ms");
    let extent = map.box_size(None);
    let camera = NamedView::Graze.camera(map, extent);
    let list = craters(map);
    let mut edited = EditedTerrain::new(Arc::clone(map));
    edited.set_craters(&list[..9]);
    let mut whole = edited.clone();
    let mut last = false;
    let small = generate(Kind::DiamondSquare, 512, 1);
    let cones = |kind| drop(black_box(ConeMap::build(&small, kind, &|_| {})));
    let work: [Work<'_>; 6] = [
        (
            "reference, 160 × 100 rays, graze",
            Box::new(|| drop(black_box(Surface::new(map, extent).distances(&camera, [160, 100], &|_| {})))),
        ),
        ("pyramid, built", Box::new(|| drop(black_box(MaxPyramid::build(map))))),
        ("map of cones, 512²", Box::new(|| cones(ConeKind::Cone))),
        ("map of relaxed cones, 512²", Box::new(|| cones(ConeKind::Relaxed))),
        // Added and taken back in turn: both are edits.
        (
            "a crater's edit of heights and pyramid",
            Box::new(|| {
                last = !last;
                black_box(edited.set_craters(&list[..if last { 10 } else { 9 }]));
            }),
        ),
        (
            "ten craters from scratch",
            Box::new(|| {
                whole = EditedTerrain::new(Arc::clone(map));
                black_box(whole.set_craters(&list));
            }),
        ),
    ];
    let mut work: Vec<_> = work.into_iter().map(|(name, run)| (name, run, Vec::new())).collect();
    for round in 0..WARM_UP + rounds {
        for (_, run, times) in &mut work {
            let start = Instant::now();
            run();
            if round >= WARM_UP {
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    let medians: Vec<_> = work.iter_mut().map(|(name, _, times)| (*name, median(times))).collect();
    for (name, ms) in &medians {
        println!("{name:40} {ms:9.3}");
    }
    println!("an edit is {:.0} times as fast as building anew", medians[5].1 / medians[4].1);
}
