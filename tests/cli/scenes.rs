//! Scene files: exit 3.

use std::fs;

use crate::bench::Bench;

#[test]
fn a_scene_with_an_unknown_key_names_the_nearest_valid_one() {
    let bench = Bench::new();
    bench.write("scene.toml", "[march]\ntechnique = \"linear\"\nsample_max = 300\n");
    let run = bench.relief("render -o out.png --size 8x8 --scene scene.toml");
    run.expect(3, &["scene.toml:3", "`sample_max`", "nearest valid key is `samples_max`"])
        .says_what_why_and_what_to_do();
    assert_eq!(bench.names(), ["scene.toml"]);
}

#[test]
fn a_scene_with_a_value_out_of_range_names_field_and_range() {
    let bench = Bench::new();
    bench.write("scene.toml", "[camera]\neye = [0.5, 0.5, 1.5]\nfov = 200\n");
    let run = bench.relief("render -o out.png --size 8x8 --scene scene.toml");
    run.expect(3, &["scene.toml", "camera.fov cannot be 200", "at most 179.9"]).says_what_why_and_what_to_do();
}

#[test]
fn a_scene_that_is_missing_or_no_toml() {
    let bench = Bench::new();
    bench.relief("render -o out.png --scene none.toml").expect(3, &["none.toml"]).says_what_why_and_what_to_do();
    bench.write("scene.toml", "[march\n");
    let run = bench.relief("render -o out.png --scene scene.toml");
    run.expect(3, &["scene.toml:1"]).says_what_why_and_what_to_do();
}

#[test]
fn the_files_of_a_scene_are_found_beside_it() {
    let bench = Bench::new();
    fs::create_dir(bench.path("deep")).unwrap();
    bench.write("deep/scene.toml", "terrain.file = \"map.png\"\n");
    let run = bench.relief("render -o out.png --size 8x8 --scene deep/scene.toml");
    run.expect(3, &["map.png", "no such file", "The scene deep/scene.toml names it"]).says_what_why_and_what_to_do();
    // Named by the user it is not the scene's fault.
    let run = bench.relief("render other.png -o out.png --size 8x8 --scene deep/scene.toml");
    assert!(!run.expect(3, &["other.png", "no such file"]).stderr.contains("names it"), "{}", run.stderr);
    bench.relief("report -o out --size 8x8 --scene deep/scene.toml").expect(3, &["no camera"]);
    bench.map("deep/map.png", 16, 16);
    bench.relief("render -o out.png --size 8x8 --scene deep/scene.toml").expect(0, &[]);
}

/// A picture without its crater looks right; only a message tells that the crater is missing.
#[test]
fn a_crater_off_the_map_is_told() {
    let bench = Bench::new();
    bench.map("map.png", 16, 9);
    let list = "[{ x = 0.5, z = 0.9, radius = 0.1, depth = 0.1, rim = 0.1 }]";
    bench.write("scene.toml", format!("terrain.file = \"map.png\"\ncraters.list = {list}\n"));
    let run = bench.relief("render -o out.png --size 8x8 --scene scene.toml");
    run.expect(0, &["relief: warning: the crater at x 0.5, z 0.9", "lies off the map", "to 0.53"]);
    let run = bench.relief("render map.png -o out.png --size 8x8 --crater=-2,0.1");
    run.expect(0, &["relief: warning: the crater at x -2, z 0.1", "lies off the map"]);
    let run = bench.relief("--scene scene.toml --size 8x8 -o view.png");
    run.expect(0, &["warning: the crater at x 0.5, z 0.9"]);
    let run = bench.relief("render map.png -o out.png --size 8x8 --crater 0.5,0.56");
    assert_eq!(run.expect(0, &[]).stderr.matches("crater").count(), 0, "its rim is on the map: {}", run.stderr);
}
