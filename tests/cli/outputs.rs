//! Outputs that cannot be written: exit 1, and nothing is left behind.

use std::fs;

use crate::bench::Bench;

#[test]
fn an_output_in_a_folder_that_does_not_exist() {
    let bench = Bench::new();
    for line in [
        "render -o none/out.png",
        "render -o out.png --depth none/out.exr",
        "render -o out.png --stats none/out.json",
        "generate perlin --size 16 -o none/out.png",
        "-o none/out.png",
    ] {
        bench.relief(line).expect(1, &["cannot write", "none/out."]).says_what_why_and_what_to_do();
        assert!(bench.names().is_empty(), "{line} left {:?}", bench.names());
    }
}

#[test]
fn an_output_that_is_a_directory() {
    let bench = Bench::new();
    fs::create_dir(bench.path("out.png")).unwrap();
    for line in ["render -o out.png", "render -o a.png --depth out.png", "generate perlin --size 16 -o out.png"] {
        bench.relief(line).expect(1, &["cannot write", "out.png", "directory"]).says_what_why_and_what_to_do();
    }
    assert_eq!(bench.names(), ["out.png"]);
    assert_eq!(fs::read_dir(bench.path("out.png")).unwrap().count(), 0);
}

#[test]
fn a_failed_run_keeps_the_file_that_was_there() {
    let bench = Bench::new();
    bench.write("out.png", b"precious");
    bench.relief("render none.png -o out.png").expect(3, &[]);
    assert_eq!(fs::read(bench.path("out.png")).unwrap(), b"precious");
    assert_eq!(bench.names(), ["out.png"]);
}

#[test]
fn an_input_is_not_replaced_by_an_output() {
    let bench = Bench::new();
    bench.map("map.png", 16, 16);
    let before = fs::read(bench.path("map.png")).unwrap();
    bench.relief("render map.png -o ./map.png").expect(2, &["input and an output", "another name"]);
    bench.relief("render map.png -o a.png --depth ./a.png").expect(2, &["two outputs"]);
    bench.relief("render map.png -o a.jpg").expect(2, &["a.jpg would be a PNG file", "Name it a.png"]);
    assert_eq!(fs::read(bench.path("map.png")).unwrap(), before);
}
