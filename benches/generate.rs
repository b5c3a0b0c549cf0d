//! What making terrain costs: ms at 513² (a slider's preview) and ns per sample at 1025², for each kind and each erosion.
//!
//! All are made in turn, so that whatever else the machine does falls on all of them. `cargo bench --bench generate`
//! prints the medians; `-- --quick` takes few rounds.
#![expect(clippy::unwrap_used, reason = "a benchmark may fail loudly")]

use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use relief::heightfield::generate::{Kind, Recipe};

/// Milliseconds in which eight octaves at 513² are to be there, so that the picture follows a slider.
const GOAL: f64 = 50.0;

fn main() {
    // Cargo passes `--bench`; whatever else it may pass is no concern of a harness without filters.
    let rounds = if std::env::args().any(|argument| argument == "--quick") { 3 } else { 9 };
    println!("making terrain on {} threads, median of {rounds} interleaved rounds", rayon::current_num_threads());
    println!("{:34} {:>12} {:>14} {:>16}", "", "513², ms", "1025², ms", "ms per million");
    let recipes = recipes();
    let mut times = vec![[const { Vec::new() }; 2]; recipes.len()];
    for _ in 0..rounds {
        for ((_, recipe), times) in recipes.iter().zip(&mut times) {
            for (side, times) in [513, 1025].into_iter().zip(times) {
                let start = Instant::now();
                black_box(recipe.make([side; 2], &|_| {}, &AtomicBool::new(false)).unwrap());
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    for (index, ((name, _), mut times)) in recipes.iter().zip(times).enumerate() {
        let [small, large] = times.each_mut().map(|times| median(times));
        let verdict = match (index, small <= GOAL) {
            (0, true) => "   fast enough to drag",
            (0, false) => "   TOO SLOW to drag",
            _ => "",
        };
        println!("{name:34} {small:12.1} {large:14.1} {:16.1}{verdict}", large / (1025.0 * 1025.0 / 1e6));
    }
}

/// What is measured; the first is what sliders are judged by.
fn recipes() -> Vec<(&'static str, Recipe)> {
    let kind = |kind| Recipe::new(kind, 1);
    let mut eight = kind(Kind::Perlin);
    eight.octaves = Some(8);
    let mut smoothed = kind(Kind::DiamondSquare);
    smoothed.midpoint.smoothing = 2;
    let mut tileable = kind(Kind::Ridged);
    tileable.tileable = true;
    let mut rained = kind(Kind::Ridged);
    rained.hydraulic.drops = 0.5;
    let mut slid = kind(Kind::Ridged);
    slid.thermal.iterations = 20;
    vec![
        ("perlin, 8 octaves", eight),
        ("perlin", kind(Kind::Perlin)),
        ("ridged", kind(Kind::Ridged)),
        ("ridged, tileable", tileable),
        ("warped", kind(Kind::Warped)),
        ("diamond-square", kind(Kind::DiamondSquare)),
        ("diamond-square, smoothed twice", smoothed),
        ("ridged, half a drop per sample", rained),
        ("ridged, 20 thermal steps", slid),
    ]
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
