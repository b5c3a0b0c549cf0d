//! What the other commands tell: `info`, `generate`, `completions`.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use crate::bench::{Bench, json, run};

#[test]
fn info_knows_the_size_and_the_type() {
    let bench = Bench::new();
    bench.map("map.png", 12, 7);
    let run = bench.relief("info map.png --json");
    run.expect(0, &[]);
    let info = json(&run.stdout);
    for key in ["width", "height", "sample_type", "min", "max", "nodata_fraction", "crs", "metres_per_sample"] {
        assert!(info.get(key).is_some(), "{key}");
    }
    assert_eq!((&info["width"], &info["height"]), (&12.into(), &7.into()));
    assert_eq!((&info["sample_type"], info["nodata_fraction"].as_f64()), (&"u16".into(), Some(0.0)));
    assert!(info["crs"].is_null() && info["metres_per_sample"].is_null());
    assert!(bench.relief("info map.png").stdout.contains("12 × 7"));
}

#[test]
fn info_tells_the_grand_canyons_place() {
    let bench = Bench::new();
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
    let run = run(&mut bench.command([OsStr::new("info"), map.as_os_str(), OsStr::new("--json")]));
    run.expect(0, &[]);
    let info = json(&run.stdout);
    assert_eq!((info["min"].as_f64(), info["max"].as_f64()), (Some(479.0), Some(2347.0)));
    assert_eq!(info["crs"], "EPSG:3857");
    assert!((info["metres_per_sample"].as_f64().unwrap() - 61.7).abs() < 0.2, "{info}");
}

#[test]
fn what_is_generated_depends_on_the_seed_and_can_be_opened() {
    let bench = Bench::new();
    for (name, seed) in [("a", 1), ("b", 1), ("c", 2)] {
        bench.relief(&format!("generate diamond-square --size 33 --seed {seed} -o {name}.png")).expect(0, &[]);
    }
    let read = |name: &str| fs::read(bench.path(name)).unwrap();
    assert!(read("a.png") == read("b.png") && read("a.png") != read("c.png"));
    let info = bench.relief("info a.png --json");
    assert_eq!(json(&info.expect(0, &[]).stdout)["width"], 33);
}

#[test]
fn completions_name_the_commands() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish"] {
        let run = bench.relief(&format!("completions {shell}"));
        run.expect(0, &[]);
        assert!(run.stdout.contains("render") && run.stdout.contains("generate"), "{shell}");
    }
}
