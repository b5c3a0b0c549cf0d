//! Time, preparation and memory of the exact technique over the size of the map.

use std::sync::Arc;
use std::time::Instant;

use relief::camera::NamedView;
use relief::gpu::{Gpu, Target};
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::{Crater, HeightField};
use relief::render::Renderer;
use relief::report::growth::{Curve, Panel};
use relief::scene::{CraterMode, Scene, Technique};

use super::{Ratios, WARM_UP, bare, frame, median, next_frame, say};

const SIZE: [u32; 2] = [640, 400];

/// Radius of the crater, as a share of the map: it is a twentieth of the map wide.
const RADIUS: f64 = 0.025;

/// What a map costs besides its frames.
struct Cost {
    /// From the map in memory to its first picture, milliseconds.
    first_ms: f64,
    /// Bytes on the GPU, heights and pyramid.
    bytes: u64,
    /// The first frame after a crater as a multiple of the frame without.
    crater: f64,
}

/// Measures maps of all `sides` in turn and plots what it finds.
pub(super) fn measure(
    gpu: &Arc<Gpu>,
    sides: &[u32],
    rounds: usize,
    table: &mut String,
    ratios: &mut Ratios,
) -> Vec<Panel> {
    let target = Target::new(gpu, SIZE);
    let mut costs = Vec::new();
    let mut grounds: Vec<(Arc<HeightField>, Renderer)> = Vec::new();
    for &side in sides {
        let map = Arc::new(generate(Kind::DiamondSquare, side, 1));
        let (renderer, cost) = first_frames(gpu, &map, &target, rounds);
        costs.push(cost);
        grounds.push((map, renderer));
    }
    let frames = frames(&mut grounds, &target, rounds);

    say(table, &format!("\n## Growth with the map, {} × {}, median of {rounds} rounds\n", SIZE[0], SIZE[1]));
    let views = NamedView::MEASURED.map(|view| format!(" {} ms (of 1024²) |", view.name())).concat();
    say(
        table,
        &format!(
            "| side |{views} map to first frame, ms per million samples | bytes per sample | first frame after a crater, frames |"
        ),
    );
    say(table, &format!("|{}", "---|".repeat(1 + NamedView::MEASURED.len() + 3)));
    let unit = sides.iter().position(|&side| side == 1024).unwrap_or(0);
    for (index, (&side, cost)) in sides.iter().zip(&costs).enumerate() {
        let samples = f64::from(side) * f64::from(side);
        let mut line = format!("| {side} |");
        for (view, ms) in NamedView::MEASURED.iter().zip(&frames) {
            line += &format!(" {:.2} ({:.2}) |", ms[index], ms[index] / ms[unit]);
            if index != unit {
                ratios.insert(format!("{side} {} growth", view.name()), ms[unit] / ms[index]);
            }
        }
        let (first, bytes) = (cost.first_ms / samples * 1e6, cost.bytes as f64 / samples);
        // Upside down: less is worse, as with all ratios that are compared.
        ratios.insert(format!("{side} crater"), 1.0 / cost.crater);
        ratios.insert(format!("{side} samples per byte"), 1.0 / bytes);
        say(table, &format!("{line} {first:.2} | {bytes:.2} | {:.2} |", cost.crater));
    }
    let curve = |name: &str, values: Vec<f64>| Curve {
        name: name.to_owned(),
        points: sides.iter().copied().zip(values).collect(),
    };
    let times = NamedView::MEASURED.iter().zip(frames).map(|(view, ms)| curve(view.name(), ms)).collect();
    let of = |value: fn(&Cost) -> f64| costs.iter().map(value).collect::<Vec<_>>();
    let panels = vec![
        Panel { title: "a frame, ms".into(), curves: times },
        Panel {
            title: "what a map needs".into(),
            curves: vec![
                curve("map to first frame, ms", of(|cost| cost.first_ms)),
                curve("on the GPU, MB", of(|cost| cost.bytes as f64 * 1e-6)),
            ],
        },
    ];
    for panel in &panels {
        for curve in &panel.curves {
            let power = curve.power().unwrap_or(f64::NAN);
            say(table, &format!("- {}, {}: grows with the power {power:.2} of the side", panel.title, curve.name));
        }
    }
    panels
}

/// Milliseconds of a frame, by view and by map; the maps in turn.
fn frames(grounds: &mut [(Arc<HeightField>, Renderer)], target: &Target, rounds: usize) -> Vec<Vec<f64>> {
    let of_view = |view: NamedView| {
        let scenes: Vec<Scene> = grounds.iter().map(|(map, _)| scene(map, view)).collect();
        let mut times = vec![Vec::new(); grounds.len()];
        for round in 0..WARM_UP + rounds {
            for (((_, renderer), scene), times) in grounds.iter_mut().zip(&scenes).zip(&mut times) {
                let ms = next_frame(renderer, scene, target);
                if round >= WARM_UP {
                    times.push(ms);
                }
            }
        }
        times.iter_mut().map(|times| median(times)).collect()
    };
    NamedView::MEASURED.map(of_view).to_vec()
}

fn scene(map: &HeightField, view: NamedView) -> Scene {
    let mut scene = bare(Technique::MaxMipmap);
    scene.camera = Some(view.camera(map, map.box_size(None)));
    scene.craters.mode = CraterMode::Baked;
    scene
}

/// The way to the first picture of `map`, with pipelines that were built for another map, and a crater's first frame.
fn first_frames(gpu: &Arc<Gpu>, map: &Arc<HeightField>, target: &Target, rounds: usize) -> (Renderer, Cost) {
    let mut scene = scene(map, NamedView::Over);
    let small = Arc::new(generate(Kind::DiamondSquare, 64, 1));
    let mut renderer = Renderer::new(Arc::clone(gpu)).unwrap();
    let mut first = Vec::new();
    // The way there takes seconds for the largest maps.
    for _ in 0..3 {
        renderer.set_terrain(Arc::clone(&small)).unwrap();
        frame(&mut renderer, &scene, target);
        let start = Instant::now();
        renderer.set_terrain(Arc::clone(map)).unwrap();
        frame(&mut renderer, &scene, target);
        first.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let bytes = renderer.ledger().textures.iter().filter(|texture| ["heights", "pyramid"].contains(&&*texture.name));
    let bytes = bytes.map(|texture| texture.bytes).sum();

    let extent = map.box_size(None);
    let crater = |round: usize| {
        let (u, v) = (0.3 + 0.02 * (round % 20) as f64, 0.3 + 0.4 * (round % 3) as f64 / 3.0);
        Crater { x: u * extent.x, z: v * extent.z, radius: RADIUS, depth: 0.3, rim: 0.08 }
    };
    let whole = |renderer: &mut Renderer, scene: &Scene| {
        let start = Instant::now();
        frame(renderer, scene, target);
        start.elapsed().as_secs_f64() * 1e3
    };
    let (mut without, mut with) = (Vec::new(), Vec::new());
    for round in 0..WARM_UP + rounds {
        let still = whole(&mut renderer, &scene);
        scene.craters.list.push(crater(round));
        let edited = whole(&mut renderer, &scene);
        if round >= WARM_UP {
            without.push(still);
            with.push(edited);
        }
    }
    let cost = Cost { first_ms: median(&mut first), bytes, crater: median(&mut with) / median(&mut without) };
    // The next measurements are of the bare map.
    scene.craters.list.clear();
    frame(&mut renderer, &scene, target);
    (renderer, cost)
}
