//! The command line as a user meets it: the binary is run, and its exit code, messages and files are looked at.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use image::{ImageBuffer, Luma, Rgb};
use tempfile::TempDir;

/// What a run left behind.
struct Run {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Run {
    /// Fails unless the run ended with `code` and stderr has every one of `words`.
    #[track_caller]
    fn expect(&self, code: i32, words: &[&str]) -> &Self {
        assert_eq!(self.code, code, "stderr: {}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "`{word}` is missing in: {}", self.stderr);
        }
        self
    }

    /// Fails unless the message has its three parts: what, and below it, indented, why and what to do.
    #[track_caller]
    fn says_what_why_and_what_to_do(&self) {
        let mut lines = self.stderr.lines().skip_while(|line| !line.starts_with("relief: error: "));
        assert!(lines.next().is_some(), "no error: {}", self.stderr);
        let indented: Vec<&str> = lines.collect();
        assert!(indented.len() >= 2, "what, why and what to do: {}", self.stderr);
        assert!(indented.iter().all(|line| line.starts_with("  ") && line.len() > 6), "indented: {}", self.stderr);
    }
}

/// A folder of its own for each test.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// A map with some relief.
    fn map(&self, name: &str, width: u32, height: u32) {
        let height_at = |x: u32, z: u32| Luma([(x * 977 + z * 3571 + (x * z) % 97 * 500) as u16]);
        ImageBuffer::from_fn(width, height, height_at).save(self.path(name)).unwrap();
    }

    /// The names of the files here, sorted; also those that begin with a dot.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn command<S: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relief"));
        command.current_dir(self.0.path()).args(arguments);
        for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(display);
        }
        if std::env::var_os("RELIEF_ADAPTER").is_none() {
            command.env("RELIEF_ADAPTER", "cpu");
        }
        command
    }

    /// Runs `relief` with the words of `line`.
    fn relief(&self, line: &str) -> Run {
        run(&mut self.command(line.split_whitespace()))
    }
}

fn run(command: &mut Command) -> Run {
    let output = command.output().unwrap();
    Run {
        code: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

fn keys(value: &serde_json::Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

// Height maps that cannot be used: exit 3.

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

// Scene files: exit 3.

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
    run.expect(3, &["map.png", "no such file"]);
    bench.map("deep/map.png", 16, 16);
    bench.relief("render -o out.png --size 8x8 --scene deep/scene.toml").expect(0, &[]);
}

// Adapters: exit 4.

#[test]
fn without_an_adapter_the_driver_to_install_is_named() {
    let bench = Bench::new();
    for line in ["render -o out.png --size 8x8", ""] {
        let mut command = bench.command(line.split_whitespace());
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, "/nonexistent/driver.json");
        }
        let run = run(command.env_remove("VK_ADD_DRIVER_FILES"));
        run.expect(4, &["no usable GPU adapter", "mesa-vulkan-drivers", "apt-get"]).says_what_why_and_what_to_do();
    }
    assert!(bench.names().is_empty());
}

// Outputs that cannot be written: exit 1, and nothing is left behind.

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

// Usage: exit 2.

#[test]
fn arguments_that_make_no_sense() {
    let bench = Bench::new();
    for (arguments, words) in [
        ("--size 0x100", "--size"),
        ("--size 100", "--size"),
        ("--size 4000000x8", "--size"),
        ("--samples 9..8", "--samples"),
        ("--samples 0..8", "--samples"),
        ("--binary-steps 99", "--binary-steps"),
        ("--eye 0,nan,0", "not finite"),
        ("--eye 0,0", "three numbers"),
        ("--eye 1,1,1 --target 1,1,1", "same point"),
        ("--view over --eye 1,1,1", "cannot be used with"),
        ("--view sideways", "valley"),
        ("--fov 180", "--fov"),
        ("--fov 0", "--fov"),
        ("--height-scale -0.1", "--height-scale"),
        ("--height-scale 1000.1", "--height-scale"),
        ("--height-scale inf", "not finite"),
        ("--technique maxmipmap", "max-mipmap"),
        ("--crater 0.5", "--crater"),
        ("--crater 0.5,0.5,-1", "radius"),
        ("--frames 0 --stats out.json", "--frames"),
        ("--frames 9", "--stats"),
        ("--repeats 0", "--repeats"),
        ("-", "standard input"),
        ("--no-such-option", "--no-such-option"),
    ] {
        let run = bench.relief(&format!("render -o out.png {arguments}"));
        run.expect(2, &["relief: error: ", words]);
        assert!(bench.names().is_empty(), "{arguments} left {:?}", bench.names());
    }
    bench.relief("render").expect(2, &["--output"]);
    bench.relief("generate ocean -o a.png").expect(2, &["diamond-square"]);
    bench.relief("generate perlin --size 1 -o a.png").expect(2, &["--size"]);
}

// What works.

#[test]
fn the_same_arguments_give_the_same_bytes() {
    let bench = Bench::new();
    bench.map("map.png", 48, 33);
    for name in ["a", "b"] {
        let line =
            format!("render map.png -o {name}.png --depth {name}.exr --size 96x60 --view graze --crater 0.5,0.4");
        bench.relief(&line).expect(0, &[]);
    }
    for ending in ["png", "exr"] {
        let read = |name: &str| fs::read(bench.path(&format!("{name}.{ending}"))).unwrap();
        assert!(read("a") == read("b"), "{ending} differs");
    }
    assert_eq!(image::open(bench.path("a.png")).unwrap().to_rgb8().dimensions(), (96, 60));
}

#[test]
fn the_distances_are_one_float_channel_with_sky_at_infinity() {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
    let bench = Bench::new();
    // Level and from outside: ground below the horizon, sky above it.
    bench.relief("render -o out.png --depth out.exr --size 60x40 --eye 0.5,0.3,2 --target 0.5,0.3,0").expect(0, &[]);
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(bench.path("out.exr"))
        .unwrap();
    assert_eq!((image.layer_data.size.x(), image.layer_data.size.y()), (60, 40));
    let channels = &image.layer_data.channel_data.list;
    assert_eq!(channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>(), ["Y"]);
    let FlatSamples::F32(distance) = &channels[0].sample_data else { unreachable!("not 32-bit float") };
    assert!(distance[..60].iter().all(|&sky| sky == f32::INFINITY), "the first row is the top, and sky");
    let ground: Vec<f32> = distance.iter().copied().filter(|distance| distance.is_finite()).collect();
    assert!(!ground.is_empty());
    // The near side of the box is at z = 1 or less, its far corner less than 2.2 away.
    assert!(ground.iter().all(|distance| (1.0..2.3).contains(distance)), "{ground:?}");
}

#[test]
fn the_statistics_have_their_keys() {
    let bench = Bench::new();
    bench.relief("render -o out.png --stats out.json --size 60x40 --frames 3").expect(0, &[]);
    let stats = json(&fs::read_to_string(bench.path("out.json")).unwrap());
    assert_eq!(keys(&stats), ["adapter", "cap_hits", "driver", "frame_ms", "ledger", "steps"]);
    assert_eq!(keys(&stats["frame_ms"]), ["median", "p95"]);
    assert_eq!(keys(&stats["steps"]), ["max", "mean"]);
    for key in ["passes", "pipelines", "draws", "textures", "texture_bytes", "shader_defs"] {
        assert!(!stats["ledger"][key].is_null(), "{key}");
    }
    assert!(stats["frame_ms"]["median"].as_f64().unwrap() <= stats["frame_ms"]["p95"].as_f64().unwrap());
    assert!(stats["steps"]["max"].as_f64().unwrap() >= stats["steps"]["mean"].as_f64().unwrap());
    assert!(stats["steps"]["mean"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_position_view_takes_no_steps() {
    let bench = Bench::new();
    let line = "render -o out.png --debug position --size 60x40 --stats out.json --depth out.exr";
    bench.relief(line).expect(0, &[]);
    let stats = json(&fs::read_to_string(bench.path("out.json")).unwrap());
    assert_eq!(stats["steps"], serde_json::json!({ "mean": 0.0, "max": 0 }));
    assert_eq!(stats["cap_hits"], 0);
    assert!(bench.path("out.exr").exists());
}

#[test]
fn a_flat_map_is_drawn_with_or_without_an_extent() {
    let bench = Bench::new();
    ImageBuffer::from_pixel(16, 16, Luma([700u16])).save(bench.path("flat.png")).unwrap();
    let ground = |options: &str| {
        bench
            .relief(&format!("render flat.png -o out.png --stats out.json --size 32x20 --view down {options}"))
            .expect(0, &[]);
        json(&fs::read_to_string(bench.path("out.json")).unwrap())["steps"]["mean"].as_f64().unwrap()
    };
    assert!(ground("") > 0.0 && ground("--height-scale 0") > 0.0);
    bench.write("flat.toml", "extent_metres = [1e3, 1e3]\nlowest_metre = 7\nhighest_metre = 7\n");
    for view in ["start", "over", "graze", "valley", "horizon"] {
        bench.relief(&format!("render flat.png -o out.png --size 32x20 --view {view}")).expect(0, &[]);
    }
    bench.relief("render flat.png -o sky.png --size 32x20 --eye 0.5,1,0.5 --target 0.5,2,0.5").expect(0, &[]);
    for technique in ["linear", "linear-binary", "secant", "cone", "relaxed-cone", "max-mipmap"] {
        assert!(ground(&format!("--technique {technique}")) > 0.0, "{technique}");
        let picture = |name: &str| image::open(bench.path(name)).unwrap().to_rgb8();
        assert!(picture("out.png") != picture("sky.png"), "{technique} shows the ground");
    }
}

#[test]
fn options_change_the_picture() {
    let bench = Bench::new();
    let picture = |name: &str, options: &str| {
        bench.relief(&format!("render -o {name}.png --size 80x50 {options}")).expect(0, &[]);
        image::open(bench.path(&format!("{name}.png"))).unwrap().to_rgb8()
    };
    let plain = picture("plain", "");
    assert!(picture("again", "--view start") == plain, "start is the default view");
    for (index, options) in [
        "--view down",
        "--fov 30",
        "--no-lighting",
        "--no-skybox",
        "--occluder",
        "--crater 0.5,0.5,0.2",
        "--debug steps",
    ]
    .iter()
    .enumerate()
    {
        assert!(picture(&format!("changed{index}"), options) != plain, "{options} changes nothing");
    }
}

#[test]
fn without_a_display_the_viewer_draws_its_start_view() {
    let bench = Bench::new();
    bench.relief("--size 64x40").expect(0, &["no display", "relief-view.png"]);
    assert_eq!(bench.names(), ["relief-view.png"]);
    bench.relief("render -o start.png --size 64x40").expect(0, &[]);
    let read = |name: &str| fs::read(bench.path(name)).unwrap();
    assert!(read("relief-view.png") == read("start.png"), "the same picture as `render` makes");
    bench.relief("view --size 64x40 -o other.png").expect(0, &["other.png"]);
    assert!(bench.path("other.png").exists());
}

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

#[test]
fn every_command_and_option_of_the_readme_is_in_the_help() {
    let bench = Bench::new();
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let section = readme.split("\n## ").find(|section| section.starts_with("Command line")).unwrap();
    let commands = ["view", "render", "report", "stress", "info", "convert", "generate", "completions"];
    let mut help = bench.relief("--help").stdout;
    for command in commands {
        assert!(help.contains(command), "{command} is missing in --help");
        assert!(section.contains(&format!("relief {command}")), "{command} is missing in the README");
        let run = bench.relief(&format!("{command} --help"));
        help += &run.expect(0, &[]).stdout;
    }
    let is_end = |c: char| !c.is_ascii_alphanumeric() && c != '-';
    let options = section.split("--").skip(1).map(|rest| rest.split(is_end).next().unwrap());
    let options: Vec<&str> = options.filter(|option| option.starts_with(|c: char| c.is_ascii_alphabetic())).collect();
    assert!(options.len() > 10, "the README shows options");
    for option in options {
        assert!(help.contains(&format!("--{option}")), "the README's --{option} is missing in --help");
    }
}

#[test]
fn the_readmes_scene_is_valid() {
    let bench = Bench::new();
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let example = readme.split("```toml").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    bench.write("scene.toml", example);
    let scene = relief::scene_file::read(&bench.path("scene.toml")).unwrap();
    assert_eq!(scene.terrain.file, Some(bench.path("ridged.png")));
    assert_eq!(scene.craters.list.len(), 1);
}
