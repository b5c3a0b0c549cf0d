//! Files in and out of the command line: the edited map, what is asked before something is replaced, messages that name a
//! way on, the manual.

use std::fs;
use std::path::Path;
use std::process::Command;

use relief::heightfield::load;

use crate::bench::{Bench, json};

const FORMATS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/formats/");

fn copy(bench: &Bench, name: &str) {
    fs::copy(format!("{FORMATS}{name}"), bench.path(name.rsplit('/').next().unwrap())).unwrap();
}

#[test]
fn convert_writes_the_map_of_a_scene_with_its_craters() {
    let bench = Bench::new();
    copy(&bench, "special/nan.tif");
    bench.write(
        "scene.toml",
        "[terrain]\nfile = \"nan.tif\"\n[craters]\nlist = [{ x = 0.5, z = 0.4, radius = 0.2, depth = 0.4, rim = 0.1 }]\n",
    );
    bench.relief("convert --scene scene.toml -o edited.tif").expect(0, &[]);
    let (before, after) = (load::load(&bench.path("nan.tif")).unwrap(), load::load(&bench.path("edited.tif")).unwrap());
    assert_eq!(after.georeference, before.georeference);
    assert_eq!(after.field.holes(), before.field.holes());
    assert_ne!(after.field, before.field, "there is a crater");
    // The same crater in another map, which is named; the built-in one, which is not.
    bench.map("plain.png", 40, 30);
    bench.relief("convert plain.png --scene scene.toml -o plain-edited.png").expect(0, &[]);
    let height = |name: &str, x, z| load::load(&bench.path(name)).unwrap().field.sample(x, z);
    assert_ne!(height("plain.png", 20, 16), height("plain-edited.png", 20, 16));
    bench.write("none.toml", "[march]\ntechnique = \"linear\"\n");
    bench.relief("convert --scene none.toml -o canyon.tif").expect(0, &["has no craters"]);
    let canyon = load::load(&bench.path("canyon.tif")).unwrap();
    assert_eq!((canyon.field.width(), canyon.field.range()), (512, [479.0, 2347.0]));
    assert_eq!(canyon.field.extent_metres(), Some([31566.9, 31428.8]), "in the sidecar");
    bench.relief("convert --scene scene.toml -o nan.tif --force").expect(2, &["nan.tif", "would replace the map"]);
    bench.relief("convert -o a.tif").expect(2, &["<FILE>"]);
}

#[test]
fn nothing_is_replaced_without_being_asked_to() {
    let bench = Bench::new();
    bench.map("map.png", 16, 16);
    bench.relief("convert map.png -o out.tif").expect(0, &[]);
    let first = fs::read(bench.path("out.tif")).unwrap();
    bench.map("map.png", 17, 17);
    bench
        .relief("convert map.png -o out.tif")
        .expect(1, &["out.tif", "exists", "--force"])
        .says_what_why_and_what_to_do();
    assert_eq!(fs::read(bench.path("out.tif")).unwrap(), first);
    bench.relief("convert map.png -o out.tif --force").expect(0, &[]);
    assert_ne!(fs::read(bench.path("out.tif")).unwrap(), first);

    bench.relief("generate perlin --size 17 -o hills.png").expect(0, &[]);
    let recipe = fs::read(bench.path("hills.toml")).unwrap();
    bench.relief("generate perlin --size 17 -o hills.png").expect(0, &[]);
    let refused = bench.relief("generate perlin --size 17 --seed 2 -o hills.png");
    refused.expect(1, &["hills.png", "exists", "--force"]).says_what_why_and_what_to_do();
    assert_eq!(fs::read(bench.path("hills.toml")).unwrap(), recipe);
    bench.relief("generate perlin --size 17 --seed 2 -o hills.png --force").expect(0, &[]);
    assert_ne!(fs::read(bench.path("hills.toml")).unwrap(), recipe);
    fs::remove_file(bench.path("hills.png")).unwrap();
    bench.relief("generate perlin --size 17 -o hills.png").expect(1, &["hills.toml holds another recipe"]);
    assert!(!bench.path("hills.png").exists());
}

#[test]
fn generate_says_what_it_cannot_do() {
    let bench = Bench::new();
    for name in ["out.tif", "out.jpg", "out"] {
        let run = bench.relief(&format!("generate perlin --size 9 -o {name}"));
        run.expect(2, &[name, ".png", "relief convert"]).says_what_why_and_what_to_do();
    }
    assert!(bench.names().is_empty(), "{:?}", bench.names());
    let run = bench.relief("generate perlin --size 9 --schedule 1,0.5 --warp 2 --talus 3 -o a.png");
    run.expect(0, &["--schedule changes nothing", "--warp changes nothing", "--talus changes nothing: nothing slides"]);
    let run = bench.relief("generate diamond-square --size 9 --octaves 3 --scale 2 --hydraulic 0.1 -o b.png");
    run.expect(0, &["--octaves changes nothing", "--scale changes nothing"]);
    assert!(!run.stderr.contains("hydraulic"), "{}", run.stderr);
}

#[test]
fn a_recipe_says_how_it_is_used() {
    let bench = Bench::new();
    bench.relief("generate perlin --size 9 -o hills.png").expect(0, &[]);
    for line in ["info hills.toml", "render hills.toml -o out.png --size 8x8", "convert hills.toml -o out.tif"] {
        let run = bench.relief(line);
        run.expect(3, &["no map but a recipe", "hills.png", "relief generate --recipe hills.toml"]);
        run.says_what_why_and_what_to_do();
    }
}

/// A plain picture has no lengths, and an ESRI grid cannot but say some.
#[test]
fn a_plain_picture_keeps_its_proportion_through_an_esri_grid() {
    let bench = Bench::new();
    bench.map("plain.png", 30, 20);
    let scale = |name: &str| load::load(&bench.path(name)).unwrap().field.natural_height_scale();
    for ending in ["asc", "flt"] {
        let out = format!("out-{ending}.{ending}");
        bench
            .relief(&format!("convert plain.png -o {out}"))
            .expect(0, &["says what the file itself cannot", "sidecar"]);
        assert_eq!(scale(&out), scale("plain.png"), "{ending}");
        let info = bench.relief(&format!("info --json {out}"));
        assert_eq!(json(&info.stdout)["extent_metres"], serde_json::Value::Null, "{ending}");
        bench.relief(&format!("convert {out} -o back-{ending}.png")).expect(0, &[]);
        assert_eq!(scale(&format!("back-{ending}.png")), scale("plain.png"), "{ending}");
    }
}

#[test]
fn files_that_do_not_open_name_a_way_on() {
    let bench = Bench::new();
    let tiff = |tag: u16, value: u16| {
        let mut bytes = fs::read(format!("{FORMATS}tiff/uint8-none-p1-strips.tif")).unwrap();
        let entry = [tag.to_le_bytes(), 3u16.to_le_bytes()].concat();
        let at = bytes.windows(4).position(|window| window == entry).unwrap();
        bytes[at + 8..at + 10].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    bench.write("palette.tif", tiff(262, 3));
    bench.write("lerc.tif", tiff(259, 34887));
    bench.write("N36W113.hgt.gz", b"\x1f\x8b\x08\0\0\0\0\0");
    bench.write("four.nc", b"\x89HDF\r\n\x1a\n\0\0\0\0");
    copy(&bench, "other/oblong.raw");
    for (line, words) in [
        ("info palette.tif", ["palette", "expand"]),
        ("info lerc.tif", ["LERC", "COMPRESS=DEFLATE"]),
        ("info N36W113.hgt.gz", ["gzip archive", "gunzip"]),
        ("info four.nc", ["netCDF-4 or HDF5", "nccopy"]),
        ("info oblong.raw --raw-size 500x400 --raw-type i16", ["too few for 500×400", "--raw-size"]),
    ] {
        let run = bench.relief(line);
        run.expect(3, &words).says_what_why_and_what_to_do();
        assert!(!run.stderr.contains("is truncated,"), "{}", run.stderr);
    }
    copy(&bench, "other/terrarium.png");
    let run = bench.relief("info terrarium.png");
    run.expect(0, &["looks like a terrain-RGB tile", "--encoding terrarium"]);
}

/// What one file's sidecar says can mean nothing for another of its name; that is no news.
#[test]
fn a_sidecar_with_more_than_a_file_needs_is_quiet() {
    let bench = Bench::new();
    bench.map("map.png", 16, 16);
    bench.write("map.toml", "raw_size = [16, 16]\nraw_type = \"u16\"\nband = 1\nvariable = \"z\"\n");
    let run = bench.relief("info map.png");
    assert_eq!(run.expect(0, &[]).stderr, "");
    bench.relief("info map.png --band 1").expect(0, &["--band means nothing for a PNG"]);
}

#[test]
fn info_rounds_for_people_and_json_is_exact() {
    let bench = Bench::new();
    copy(&bench, "special/degrees.tif");
    let run = bench.relief("info degrees.tif");
    let exact = json(&bench.relief("info --json degrees.tif").stdout);
    let (min, extent) = (exact["min"].as_f64().unwrap(), exact["extent_metres"][0].as_f64().unwrap());
    assert!(extent.to_string().len() > 9, "the test needs a number with many digits: {extent}");
    assert!(!run.stdout.contains(&extent.to_string()) && run.stdout.contains("west–east"), "{}", run.stdout);
    for line in run.stdout.lines().filter(|line| !line.starts_with("file")) {
        let digits = line.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or_default();
        assert!(digits <= 6, "{line}");
    }
    assert!(run.stdout.contains('m') && min.is_finite());
}

#[test]
fn a_mistyped_command_is_answered_with_the_commands() {
    let bench = Bench::new();
    let run = bench.relief("rendr map.png -o out.png");
    run.expect(3, &["relief render", "The commands are view, render, report"]);
    // The value of an option that takes it with = or not at all.
    for value in ["100", "multidirectional"] {
        let run = bench.relief(&format!("render --contours {value} -o out.png"));
        assert!(!run.expect(3, &["--contours=100"]).stderr.contains("The commands"), "{}", run.stderr);
    }
    // With options that only the command knows, the arguments make no sense.
    bench.relief("genrate ridged --seed 3 -o out.png").expect(2, &["--seed", "relief generate", "The commands are"]);
    bench.map("map.png", 8, 8);
    let run = bench.relief("map.png --no-such-option");
    assert!(!run.expect(2, &[]).stderr.contains("The commands"), "{}", run.stderr);
}

#[test]
fn verbose_is_an_option_of_every_command() {
    let bench = Bench::new();
    bench.map("map.png", 16, 16);
    for line in ["info map.png --verbose", "info -v map.png", "convert map.png -o out.tif -v", "completions bash -v"] {
        bench.relief(line).expect(0, &[]);
    }
    let quiet = bench.relief("render map.png -o a.png --size 8x8");
    let verbose = bench.relief("render map.png -o a.png --size 8x8 -v");
    assert!(quiet.stderr.is_empty() && verbose.stderr.contains("map.png: PNG, u16, 16×16"), "{}", verbose.stderr);
    assert!(verbose.stderr.contains("drawn by"), "{}", verbose.stderr);
    assert!(!verbose.stderr.contains('\u{1b}'), "no colours in a pipe");
}

#[test]
fn install_puts_binary_manual_and_completions_in_place() {
    let bench = Bench::new();
    let make = |target: &str| {
        let output = Command::new("make")
            .args(["--no-print-directory", target, &format!("BIN={}", env!("CARGO_BIN_EXE_relief"))])
            .arg(format!("PREFIX={}", bench.path("usr").display()))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    make("install-files");
    let file = |name: &str| fs::read_to_string(bench.path("usr").join(name)).unwrap();
    let page = file("share/man/man1/relief.1");
    assert!(page.contains(".TH RELIEF 1") && page.contains("\\fB\\-\\-technique\\fR"), "{page}");
    for command in ["view", "render", "report", "stress", "info", "convert", "generate", "completions"] {
        let page = file(&format!("share/man/man1/relief-{command}.1"));
        assert!(page.contains(&format!("RELIEF-{}", command.to_uppercase())), "{page}");
    }
    assert!(!bench.path("usr/share/man/man1/relief-man.1").exists(), "a hidden command");
    assert!(file("share/bash-completion/completions/relief").contains("_relief()"));
    assert!(file("share/zsh/site-functions/_relief").starts_with("#compdef relief"));
    assert!(file("share/fish/vendor_completions.d/relief.fish").contains("complete -c relief"));
    assert!(bench.path("usr/bin/relief").is_file());
    make("uninstall");
    let left = files_below(&bench.path("usr"));
    assert!(left.is_empty(), "{left:?}");
}

fn files_below(folder: &Path) -> Vec<std::path::PathBuf> {
    let paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.into_iter().flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect()
}

#[test]
fn a_map_too_large_for_the_adapter_is_cut_where_that_is_wanted() {
    let bench = Bench::new();
    bench.map("wide.png", 32768, 8);
    let run = bench.relief("render wide.png -o out.png --size 8x8 --too-large window");
    run.expect(0, &["wide.png: its 32768×8 samples are more than", "only its middle", "--too-large reduce"]);
    assert!(bench.path("out.png").exists());
}
