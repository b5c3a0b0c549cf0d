//! The exact technique against the study's and against a ray-tracing kernel, at any size of map.
//!
//! Everything that is compared is measured in one run, in turn: two frames of each, the second counts, so that each finds
//! its own map in the caches as it does while somebody flies, and not its rival's. Medians are printed and written to
//! `target/exact/`: a table, a plot of time and memory over the map's size, and the figures as JSON. Ratios are compared with
//! `benches/baseline.json`; `RELIEF_UPDATE_BASELINE=1` renews it. `--quick` takes few rounds over small maps.
//! `RELIEF_ADAPTER` chooses the adapter.
#![expect(clippy::unwrap_used, reason = "a benchmark may fail loudly")]

mod baseline;
mod embree;
mod growth;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use relief::camera::NamedView;
use relief::gpu::{Gpu, Target};
use relief::heightfield::HeightField;
use relief::heightfield::generate::{Kind, generate};
use relief::render::Renderer;
use relief::scene::{Scene, Technique};

use embree::Embree;

/// Turns of each variant before the first that counts: pipelines compile, textures are uploaded.
const WARM_UP: usize = 2;

/// How many times as fast as the study's technique and as the peer `max-mipmap` aims to be, by the map's side.
const AIM: f64 = 20.0;
const PEER_AIMS: [(u32, f64); 2] = [(1024, 2.0), (8192, 4.0)];

/// What is measured how often.
struct Plan {
    rounds: usize,
    sides: Vec<u32>,
    grown: Vec<u32>,
    sizes: Vec<[u32; 2]>,
}

impl Plan {
    fn of_arguments() -> Self {
        if std::env::args().any(|argument| argument == "--quick") {
            Self { rounds: 5, sides: vec![1024], grown: vec![512, 1024, 2048], sizes: vec![[640, 400]] }
        } else {
            let grown = (9..=14).map(|power| 1 << power).collect();
            Self { rounds: 21, sides: vec![1024, 8192], grown, sizes: vec![[640, 400], [1920, 1080]] }
        }
    }
}

/// Ratios by name, for the baseline.
type Ratios = BTreeMap<String, f64>;

fn main() {
    let plan = Plan::of_arguments();
    let gpu = Gpu::headless().unwrap();
    let (adapter, driver) = gpu.adapter_name();
    let mut table = format!("# The exact technique at any size\n\n{adapter}, {driver}; fractal maps, seed 1\n");
    let mut ratios = Ratios::new();
    let most = gpu.capabilities.max_texture;
    for &side in plan.sides.iter().filter(|&&side| side <= most) {
        against_others(&gpu, side, &plan, &mut table, &mut ratios);
    }
    let grown: Vec<_> = plan.grown.iter().copied().filter(|&side| side <= most).collect();
    let panels = growth::measure(&gpu, &grown, plan.rounds, &mut table, &mut ratios);
    baseline::compare(&adapter, &ratios, &mut table);

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().join("exact");
    std::fs::create_dir_all(&folder).unwrap();
    let svg = relief::report::growth::svg(&format!("max-mipmap on {adapter}"), &panels);
    std::fs::write(folder.join("exact.md"), &table).unwrap();
    std::fs::write(folder.join("exact.json"), serde_json::to_string_pretty(&ratios).unwrap()).unwrap();
    std::fs::write(folder.join("growth.png"), relief::report::growth::png(&svg).unwrap()).unwrap();
    std::fs::write(folder.join("growth.svg"), svg).unwrap();
    println!("wrote {}", folder.display());
}

/// Adds to the table, and shows it at once: a run takes minutes.
fn say(table: &mut String, line: &str) {
    println!("{line}");
    writeln!(table, "{line}").unwrap();
}

/// A scene of distances and steps alone: without light, colours and sky.
fn bare(technique: Technique) -> Scene {
    let mut scene = Scene::default();
    scene.march.technique = technique;
    (scene.lighting.enabled, scene.diffuse.enabled, scene.skybox.enabled) = (false, false, false);
    scene
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Mean and 99th percentile over the rays that were cast.
fn mean_and_p99(counts: Vec<u32>) -> (f64, u32) {
    let mut cast: Vec<u32> = counts.into_iter().filter(|&count| count > 0).collect();
    cast.sort_unstable();
    let sum: f64 = cast.iter().map(|&count| f64::from(count)).sum();
    (sum / cast.len().max(1) as f64, cast.get(cast.len() * 99 / 100).copied().unwrap_or(0))
}

/// A renderer that holds `map`.
fn renderer(gpu: &Arc<Gpu>, map: &Arc<HeightField>) -> Renderer {
    let mut renderer = Renderer::new(Arc::clone(gpu)).unwrap();
    renderer.set_terrain(Arc::clone(map)).unwrap();
    renderer
}

/// The time of one frame, milliseconds.
fn frame(renderer: &mut Renderer, scene: &Scene, target: &Target) -> f64 {
    renderer.draw(scene, target).unwrap();
    renderer.wait_frame_time().unwrap()
}

/// The time of a frame that follows its like, milliseconds.
fn next_frame(renderer: &mut Renderer, scene: &Scene, target: &Target) -> f64 {
    frame(renderer, scene, target);
    frame(renderer, scene, target)
}

/// The exact technique, `linear-binary` and Embree over one map, every view at every size.
fn against_others(gpu: &Arc<Gpu>, side: u32, plan: &Plan, table: &mut String, ratios: &mut Ratios) {
    let map = Arc::new(generate(Kind::DiamondSquare, side, 1));
    let mut peer = Embree::start(&map);
    let peer_aim = PEER_AIMS.iter().find(|aim| aim.0 == side).map_or(2.0, |aim| aim.1);
    let mut renderers = [renderer(gpu, &map), renderer(gpu, &map)];
    for &size in &plan.sizes {
        let [width, height] = size;
        say(table, &format!("\n## {side}² at {width} × {height}, median of {} rounds\n", plan.rounds));
        match &peer {
            Ok(peer) => say(table, &format!("Peer: {}.\n", peer.description())),
            Err(why) => say(table, &format!("Peer: none. {why}\n")),
        }
        say(
            table,
            &format!(
                "| view | max-mipmap ms | linear-binary ms | × (aim {AIM}) | Embree ms | × (aim {peer_aim}) | steps mean | p99 | texel reads mean | p99 | rays that hit: ours, Embree's |"
            ),
        );
        say(table, "|---|---|---|---|---|---|---|---|---|---|---|");
        let target = Target::new(gpu, size);
        let mut over_peer = Vec::new();
        for view in NamedView::MEASURED {
            let camera = view.camera(&map, map.box_size(None));
            let scenes = [Technique::MaxMipmap, Technique::LinearBinary].map(|technique| {
                let mut scene = bare(technique);
                scene.camera = Some(camera);
                scene
            });
            let mut times: [Vec<f64>; 3] = Default::default();
            let mut peer_hits = 0;
            if let Ok(peer) = &mut peer {
                peer.look(&camera, size);
            }
            for round in 0..WARM_UP + plan.rounds {
                let mut ms = [0.0; 3];
                for ((renderer, scene), ms) in renderers.iter_mut().zip(&scenes).zip(&mut ms) {
                    *ms = next_frame(renderer, scene, &target);
                }
                if let Ok(peer) = &mut peer {
                    peer.frame();
                    (ms[2], peer_hits) = peer.frame();
                }
                if round >= WARM_UP {
                    times.iter_mut().zip(ms).for_each(|(times, ms)| times.push(ms));
                }
            }
            let [exact, sampled, traced] = times.each_mut().map(|times| median(times));
            let probe = renderers[0].probe(&scenes[0], size).unwrap();
            let [(steps, steps_p99), (reads, reads_p99)] =
                [probe.steps, renderers[0].texel_reads(&scenes[0], size).unwrap()].map(mean_and_p99);
            let hits = probe.distance.iter().filter(|distance| distance.is_finite()).count();
            let name = |peer: &str| format!("{side} {width}x{height} {} {peer}", view.name());
            ratios.insert(name("linear-binary"), sampled / exact);
            let (peer_ms, peer_ratio, peer_hits) = if peer.is_ok() {
                over_peer.push(traced / exact);
                ratios.insert(name("embree"), traced / exact);
                (format!("{traced:.2}"), format!("{:.2}", traced / exact), peer_hits.to_string())
            } else {
                ("–".into(), "–".into(), "–".into())
            };
            say(
                table,
                &format!(
                    "| {} | {exact:.2} | {sampled:.2} | {:.2} | {peer_ms} | {peer_ratio} | {steps:.1} | {steps_p99} | {reads:.1} | {reads_p99} | {hits}, {peer_hits} |",
                    view.name(),
                    sampled / exact,
                ),
            );
        }
        if !over_peer.is_empty() {
            let mean = over_peer.iter().sum::<f64>() / over_peer.len() as f64;
            say(table, &format!("\nMean over the views against Embree: {mean:.2}×"));
        }
    }
}
