//! Terrain from recipes: the same bytes everywhere, exact tiles, statistics against theory, and the command.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

#[path = "generate/spectrum.rs"]
mod spectrum;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use relief::heightfield::HeightField;
use relief::heightfield::generate::{Kind, MakeError, Recipe};
use relief::heightfield::load::load;

fn make(recipe: &Recipe, size: [u32; 2]) -> HeightField {
    recipe.make(size, &|_| {}, &AtomicBool::new(false)).unwrap()
}

/// A recipe of every kind, and of every step that follows.
fn recipes() -> Vec<(&'static str, Recipe)> {
    let mut list: Vec<_> = Kind::ALL.map(|kind| (kind.name(), Recipe::new(kind, 11))).into();
    let mut scheduled = Recipe { roughness: 0.4, ..Recipe::new(Kind::DiamondSquare, 11) };
    (scheduled.midpoint.schedule, scheduled.midpoint.smoothing) = (vec![0.7, 0.9, 0.2], 2);
    list.push(("scheduled and smoothed", scheduled));
    let mut uneven = Recipe { lacunarity: 2.3, scale: 4.5, octaves: Some(6), ..Recipe::new(Kind::Perlin, 11) };
    uneven.roughness = 0.6;
    list.push(("uneven octaves", uneven));
    let mut rained = Recipe::new(Kind::Ridged, 11);
    rained.hydraulic.drops = 0.5;
    list.push(("rained on", rained));
    let mut slid = Recipe::new(Kind::Warped, 11);
    slid.thermal.iterations = 10;
    list.push(("slid", slid));
    let mut both = Recipe::new(Kind::DiamondSquare, 11);
    (both.hydraulic.drops, both.thermal.iterations) = (0.5, 5);
    list.push(("rained on and slid", both));
    list
}

/// FNV-1a over the samples as the 16 bits that are saved.
fn checksum(field: &HeightField) -> u32 {
    let bytes = field.samples().iter().flat_map(|height| ((height * 65535.0).round() as u16).to_le_bytes());
    bytes.fold(0x811c_9dc5, |sum, byte| (sum ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// What a recipe made once it makes for ever and everywhere: these sums change with [`Recipe::version`] alone.
#[test]
fn a_recipe_makes_the_same_bytes_everywhere() {
    const EXPECTED: [(&str, [u32; 2]); 9] = [
        ("diamond-square", [0xe4a5_8838, 0x517a_6a7c]),
        ("perlin", [0x00b4_6b9b, 0x7644_8a6d]),
        ("ridged", [0xc93b_cfd4, 0x5059_65a4]),
        ("warped", [0x6d2d_37f8, 0xcd41_1f05]),
        ("scheduled and smoothed", [0xf4df_f4d6, 0xc19f_c57e]),
        ("uneven octaves", [0x37ec_c557, 0xa0e0_eb23]),
        ("rained on", [0xe49e_89db, 0xeb53_1eee]),
        ("slid", [0x7504_05c4, 0xbcf6_c38f]),
        ("rained on and slid", [0x03e9_5ee9, 0xcd76_e4df]),
    ];
    let sums = recipes().into_iter().map(|(name, recipe)| {
        let open = make(&recipe, [65, 65]);
        let tileable = make(&Recipe { tileable: true, ..recipe }, [257, 129]);
        (name, [checksum(&open), checksum(&tileable)])
    });
    assert_eq!(sums.collect::<Vec<_>>(), EXPECTED);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    for (name, recipe) in recipes() {
        for tileable in [false, true] {
            let recipe = Recipe { tileable, ..recipe.clone() };
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| make(&recipe, [257, 321]))
            };
            let one = on(1);
            assert!(one == on(2) && one == on(3), "{name}, tileable {tileable}");
        }
    }
}

#[test]
fn another_seed_or_setting_makes_another_landscape() {
    for (name, recipe) in recipes() {
        let field = make(&recipe, [33, 33]);
        assert_ne!(field, make(&Recipe { seed: 12, ..recipe.clone() }, [33, 33]), "{name}");
        assert_ne!(field, make(&Recipe { roughness: 0.35, ..recipe.clone() }, [33, 33]), "{name}");
        assert_ne!(field, make(&Recipe { tileable: true, ..recipe }, [33, 33]), "{name}");
    }
}

/// Opposite borders are equal to the bit, and the slope over them is like any other: no crease at the seam.
#[test]
fn tileable_landscapes_tile() {
    for (name, recipe) in recipes() {
        for [width, height] in [[257, 257], [129, 257], [257, 65]] {
            let field = make(&Recipe { tileable: true, ..recipe.clone() }, [width, height]);
            let at = |x: u32, y: u32| f64::from(field.sample(x, y));
            assert!((0..height).all(|y| at(0, y) == at(width - 1, y)), "{name} {width}×{height}");
            assert!((0..width).all(|x| at(x, 0) == at(x, height - 1)), "{name} {width}×{height}");
            // Second differences: large where two unlike slopes meet.
            let bend = |x: u32| {
                let before = if x == 0 { width - 2 } else { x - 1 };
                (0..height - 1).map(|y| (at(before, y) - 2.0 * at(x, y) + at(x + 1, y)).abs()).sum::<f64>()
            };
            let bends: Vec<f64> = (0..width - 1).map(bend).collect();
            let most = bends[1..].iter().copied().fold(0.0, f64::max);
            assert!(bends[0] <= 1.2 * most, "{name} {width}×{height}: {} at the seam, {most} elsewhere", bends[0]);
        }
    }
}

#[test]
fn sizes_need_be_neither_square_nor_round() {
    for (name, recipe) in recipes() {
        for size in [[2, 2], [2, 9], [3, 300], [100, 37], [64, 65]] {
            let field = make(&recipe, size);
            assert_eq!([field.width(), field.height()], size);
            let (low, high) = field.samples().iter().fold((1f32, 0f32), |(a, b), &h| (a.min(h), b.max(h)));
            assert_eq!((low, high), (0.0, 1.0), "{name} {size:?}");
        }
    }
    for size in [[3, 3], [3, 17], [129, 65]] {
        let tileable = recipes().into_iter().map(|(_, recipe)| Recipe { tileable: true, ..recipe });
        tileable.for_each(|recipe| assert_eq!(make(&recipe, size).width(), size[0]));
    }
}

/// Coarse features stay where they are, so that a small preview shows what the large map will be.
#[test]
fn a_preview_looks_like_the_map() {
    for kind in Kind::ALL {
        let recipe = Recipe::new(kind, 5);
        let (small, large) = (make(&recipe, [65, 65]), make(&recipe, [513, 513]));
        let pairs = (0..65).flat_map(|y| (0..65).map(move |x| (x, y)));
        let pairs: Vec<_> =
            pairs.map(|(x, y)| (small.sample(x, y).into(), large.sample(8 * x, 8 * y).into())).collect();
        let correlation = spectrum::correlation(&pairs);
        assert!(correlation > 0.97, "{kind:?}: {correlation}");
    }
}

#[test]
fn progress_ends_at_one_and_cancelling_ends_the_work() {
    for (name, recipe) in recipes() {
        let (heard, cancel) = (Mutex::new((0f32, 0f32)), AtomicBool::new(false));
        let listen = |share: f32| {
            let mut heard = heard.lock().unwrap();
            *heard = (heard.0.max(share), share);
        };
        recipe.make([129, 129], &listen, &cancel).unwrap();
        assert_eq!(*heard.lock().unwrap(), (1.0, 1.0), "{name}");

        // Cancelled by whoever hears that a third is done.
        let stop = |share: f32| {
            cancel.fetch_or(share > 0.33, Ordering::Relaxed);
        };
        assert_eq!(recipe.make([129, 129], &stop, &cancel), Err(MakeError::Cancelled), "{name}");
    }
}

#[test]
fn a_recipe_that_makes_no_sense_is_refused_before_any_work() {
    let recipe = Recipe { roughness: f64::NAN, ..Recipe::default() };
    let worked = AtomicBool::new(false);
    let made = recipe.make([33, 33], &|_| worked.store(true, Ordering::Relaxed), &AtomicBool::new(false));
    assert!(matches!(made, Err(MakeError::Recipe(error)) if error.field == "roughness"));
    assert!(!worked.into_inner());
    let made = Recipe::default().make([0, 1_000_000_000], &|_| {}, &AtomicBool::new(false));
    assert!(matches!(made, Err(MakeError::Recipe(error)) if error.field == "size"));
}

/// Slopes that slide are gentler.
#[test]
fn erosion_does_to_slopes_what_its_name_says() {
    let slopes = |recipe: &Recipe| {
        let field = make(recipe, [257, 257]);
        let rise = |x: u32, y: u32| f64::from((field.sample(x + 1, y) - field.sample(x, y)).abs()) * 0.25 * 256.0;
        let mut slopes: Vec<f64> =
            (0..257).flat_map(|y| (0..256).map(move |x| (x, y))).map(|(x, y)| rise(x, y)).collect();
        slopes.sort_by(f64::total_cmp);
        slopes
    };
    let rough = Recipe { roughness: 0.65, ..Recipe::new(Kind::Perlin, 4) };
    let mut slid = rough.clone();
    (slid.thermal.iterations, slid.thermal.talus) = (200, 0.5);
    let (before, after) = (slopes(&rough), slopes(&slid));
    let share_above = |slopes: &[f64]| slopes.iter().filter(|&&slope| slope > 0.7).count() as f64 / slopes.len() as f64;
    let (before, after) = (share_above(&before), share_above(&after));
    assert!(before > 0.5 && after < 0.5 * before, "above 35°: {before}, then {after}");
}

// The command.

fn relief(folder: &Path, line: &str) -> (i32, String) {
    let output: Output =
        Command::new(env!("CARGO_BIN_EXE_relief")).current_dir(folder).args(line.split_whitespace()).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn the_recipe_beside_a_map_makes_its_bytes_again() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| assert_eq!(relief(folder.path(), line), (0, String::new()), "{line}");
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    run(
        "generate warped --size 65x33 --seed 18446744073709551615 --tileable --hydraulic 0.5 --thermal 3 --warp 0.7 -o a.png",
    );
    run("generate --recipe a.toml -o b.png");
    assert!(bytes("a.png") == bytes("b.png") && bytes("a.toml") == bytes("b.toml"));
    // Options beat the file, in the map and in its recipe.
    run("generate --recipe a.toml --seed 4 -o c.png");
    run("generate --recipe c.toml -o d.png");
    assert!(bytes("c.png") != bytes("a.png") && bytes("c.png") == bytes("d.png"));
    // The map opens without a word, and is what was made.
    let loaded = load(&folder.path().join("a.png")).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!((loaded.field.width(), loaded.field.height()), (65, 33));
    // What the sidecar says beside the recipe is kept.
    fs::write(folder.path().join("e.toml"), "title = \"Mine\"\n").unwrap();
    run("generate ridged --size 17 -o e.png");
    let loaded = load(&folder.path().join("e.png")).unwrap();
    assert_eq!((loaded.title.as_deref(), loaded.warnings.len()), (Some("Mine"), 0));
}

#[test]
fn absurd_settings_end_with_a_message() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |line: &str, code: i32, words: &str| {
        let (found, message) = relief(folder.path(), line);
        assert_eq!(found, code, "{line}: {message}");
        assert!(message.contains(words), "{line}: {message}");
        assert!(!folder.path().join("a.png").exists(), "{line}");
    };
    for (options, words) in [
        ("--size 0", "--size 0"),
        ("--size 1000000000", "--size 1000000000"),
        ("--size 99999999999", "--size"),
        ("--size -5", "--size"),
        ("--octaves 1000", "--octaves 1000 is not possible\n  each octave"),
        ("--octaves -1", "--octaves"),
        ("--roughness nan", "--roughness NaN is not possible"),
        ("--roughness -1", "--roughness -1"),
        ("--lacunarity 0", "--lacunarity 0"),
        ("--scale inf", "--scale inf"),
        ("--thermal -3", "--thermal"),
        ("--thermal 10000000", "--thermal 10000000"),
        ("--talus nan", "--talus NaN"),
        ("--hydraulic 1e300", "--hydraulic"),
        ("--schedule 1,-2", "--schedule -2"),
        ("--tileable", "1025×1025"),
        ("--seed -1", "--seed"),
    ] {
        refused(&format!("generate diamond-square {options} -o a.png"), 2, words);
    }
    refused("generate -o a.png", 2, "<KIND>");
    refused("generate perlin --size 9 -o a.toml", 2, "a.toml");
    for (text, words) in [
        ("[recipe]\noctaves = 1000\n", "recipe.octaves is 1000"),
        ("[recipe]\nroughness = nan\n", "recipe.roughness is NaN"),
        ("[recipe]\nsize = [0, 1000000000]\n", "recipe.size is 0×1000000000"),
        ("[recipe]\nthermal.iterations = -1\n", "bad.toml:2"),
        ("title = \"no recipe\"\n", "has no [recipe]"),
        ("{", "bad.toml:1"),
    ] {
        fs::write(folder.path().join("bad.toml"), text).unwrap();
        refused("generate --recipe bad.toml -o a.png", 3, words);
    }
    refused("generate --recipe none.toml -o a.png", 3, "none.toml");
    // A scene where the recipe would go is not overwritten.
    fs::write(folder.path().join("a.toml"), "[march]\ntechnique = \"linear\"\n").unwrap();
    refused("generate perlin --size 9 -o a.png", 1, "a.toml");
    assert!(fs::read_to_string(folder.path().join("a.toml")).unwrap().starts_with("[march]"));
}
