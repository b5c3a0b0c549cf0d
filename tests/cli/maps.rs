//! Height maps that cannot be used, or only with a warning: exit 3.

use std::fs;

use image::{ImageBuffer, Rgb};

use crate::bench::{Bench, json, run};

#[test]
fn a_file_that_does_not_exist() {
    let bench = Bench::new();
    for line in ["info none.png", "render none.png -o out.png --size 8x8", "none.png", "view none.png"] {
        bench.relief(line).expect(3, &["none.png", "no such file", "check the path"]).says_what_why_and_what_to_do();
    }
    assert!(bench.names().is_empty(), "{:?}", bench.names());
}

#[test]
fn a_directory() {
    let bench = Bench::new();
    fs::create_dir(bench.path("maps")).unwrap();
    bench.relief("info maps").expect(3, &["maps", "directory"]).says_what_why_and_what_to_do();
    bench.relief("render maps -o out.png").expect(3, &["maps", "directory"]);
}

#[test]
fn an_empty_file() {
    let bench = Bench::new();
    bench.write("empty.png", b"");
    bench.relief("info empty.png").expect(3, &["empty.png", "empty", "again"]).says_what_why_and_what_to_do();
}

#[test]
fn the_name_of_a_file_does_not_garble_its_message() {
    let bench = Bench::new();
    bench.write("a: c; d.png", b"");
    let run = run(&mut bench.command(["info", "a: c; d.png"]));
    run.expect(3, &["error: cannot open a: c; d.png\n  the file is empty\n  "]).says_what_why_and_what_to_do();
}

#[test]
fn a_truncated_file() {
    let bench = Bench::new();
    bench.map("whole.png", 64, 64);
    let whole = fs::read(bench.path("whole.png")).unwrap();
    bench.write("half.png", &whole[..whole.len() / 2]);
    bench.relief("info half.png").expect(3, &["half.png", "truncated", "again"]).says_what_why_and_what_to_do();
    bench.relief("render half.png -o out.png --size 8x8").expect(3, &["half.png", "truncated"]);
    assert!(!bench.path("out.png").exists());
}

#[test]
fn not_a_png() {
    let bench = Bench::new();
    bench.write("notes.png", "these are only words, a good deal of them, and no picture at all\n");
    let run = bench.relief("info notes.png");
    run.expect(3, &["notes.png", "looks like a text file", "convert"]).says_what_why_and_what_to_do();
}

#[test]
fn a_coloured_png_works_with_a_warning() {
    let bench = Bench::new();
    let colour = |x: u32, z: u32| Rgb([x as u8 * 9, z as u8 * 7, 30]);
    ImageBuffer::from_fn(16, 16, colour).save(bench.path("colour.png")).unwrap();
    let run = bench.relief("info colour.png --json");
    run.expect(0, &["relief: warning: ", "colour.png", "luminance", "greyscale"]);
    assert_eq!(json(&run.stdout)["width"], 16);
    bench.relief("render colour.png -o out.png --size 32x20").expect(0, &["relief: warning: "]);
    assert!(bench.path("out.png").exists());
}

#[test]
fn a_single_row_or_column() {
    let bench = Bench::new();
    bench.map("row.png", 9, 1);
    bench.map("column.png", 1, 9);
    bench.relief("info row.png").expect(3, &["row.png", "9×1"]).says_what_why_and_what_to_do();
    bench.relief("info column.png").expect(3, &["column.png", "1×9"]).says_what_why_and_what_to_do();
}

#[test]
fn larger_than_the_adapter_allows() {
    let bench = Bench::new();
    bench.map("wide.png", 32768, 2);
    let run = bench.relief("render wide.png -o out.png --size 8x8");
    run.expect(3, &["relief: error: ", "32768×2", "adapter", "reduce"]);
    assert_eq!(bench.names(), ["wide.png"]);
    bench.map("fits.png", 32768, 8);
    let run = bench.relief("render fits.png -o out.png --size 8x8");
    run.expect(0, &["relief: warning: fits.png: its 32768×8 samples are more than", "mean of", "--window"]);
}

#[test]
fn a_png_that_promises_more_than_it_holds_is_refused_before_it_is_decoded() {
    let bench = Bench::new();
    bench.map("small.png", 8, 8);
    let mut bytes = fs::read(bench.path("small.png")).unwrap();
    bytes[16..24].copy_from_slice(&[0, 0, 0x75, 0x30, 0, 0, 0x75, 0x30]);
    bench.write("bomb.png", bytes);
    bench.relief("info bomb.png").expect(3, &["bomb.png"]).says_what_why_and_what_to_do();
}

#[test]
fn a_sidecar_with_absurd_numbers_is_ignored_with_a_warning() {
    let bench = Bench::new();
    bench.map("map.png", 16, 16);
    bench.write("map.toml", "extent_metres = [1e3, 1e3]\nlowest_metre = -1e308\nhighest_metre = 1e308\n");
    bench.relief("render map.png -o out.png --size 8x8").expect(0, &["relief: warning: map.toml", "0 to 1000"]);
    assert!(bench.path("out.png").exists());
}
