//! A camera path drawn without a window.

use std::fs;

use crate::bench::Bench;

const PATH: &str = "seconds = 1.0\n[[frames]]\neye = [0.2, 0.4, 1.2]\nyaw = 10.0\npitch = -20.0\n\
                    [[frames]]\neye = [0.8, 0.4, 1.2]\nyaw = 350.0\npitch = -20.0\n";

#[test]
fn a_path_becomes_a_folder_or_an_animation_and_the_same_gives_the_same_bytes() {
    let bench = Bench::new();
    bench.map("map.png", 48, 33);
    bench.write("path.toml", PATH);
    for output in ["a.png", "b.png", "folder"] {
        let line = format!("render map.png --path path.toml --frames-per-second 2 --size 48x30 -o {output}");
        bench.relief(&line).expect(0, &["3 pictures"]);
    }
    assert!(fs::read(bench.path("a.png")).unwrap() == fs::read(bench.path("b.png")).unwrap(), "the same bytes");
    let picture = |number: usize| image::open(bench.path(&format!("folder/frame-0000{number}.png"))).unwrap().to_rgb8();
    // The first is that of its key frame.
    let line = "render map.png -o one.png --size 48x30 --scene scene.toml";
    bench.write("scene.toml", "[camera]\neye = [0.2, 0.4, 1.2]\nyaw = 10.0\npitch = -20.0\n");
    bench.relief(line).expect(0, &[]);
    assert!(image::open(bench.path("one.png")).unwrap().to_rgb8() == picture(1));
    assert!(picture(1) != picture(2) && picture(2) != picture(3));
    assert_eq!(fs::read_dir(bench.path("folder")).unwrap().count(), 3);
    assert_eq!(bench.names(), ["a.png", "b.png", "folder", "map.png", "one.png", "path.toml", "scene.toml"]);
}

#[test]
fn a_path_that_is_none_and_an_output_that_is_taken_are_refused_at_once() {
    let bench = Bench::new();
    bench.write("path.toml", PATH);
    bench.write("short.toml", PATH.split("[[frames]]\neye = [0.8").next().unwrap());
    bench.write("typo.toml", PATH.replace("seconds", "secs"));
    bench.write("full/file", []);
    for (line, code, words) in [
        ("render --path short.toml -o a.png", 3, "at least two different key frames"),
        ("render --path typo.toml -o a.png", 3, "Valid here: seconds"),
        ("render --path none.toml -o a.png", 3, "none.toml"),
        ("render --path path.toml -o a.mp4", 2, "a.mp4"),
        ("render --path path.toml -o full", 2, "not empty"),
        ("render --path path.toml -o none/a.png", 1, "none/a.png"),
    ] {
        let run = bench.relief(line);
        run.expect(code, &[words]).says_what_why_and_what_to_do();
    }
    bench.relief("render --path path.toml --view over -o a.png").expect(2, &["--view"]);
    bench.relief("render --frames-per-second 3 -o a.png").expect(2, &["--path"]);
    assert!(!bench.path("a.png").exists());
}

/// Water and clouds that move in the viewer move in a film, by its own time; what stands in the scene stands.
#[test]
fn waves_and_clouds_move_with_the_film() {
    let bench = Bench::new();
    bench.map("map.png", 17, 17);
    // An eye that as good as rests.
    let frame = |yaw: f64| format!("[[frames]]\neye = [0.5, 0.6, 1.3]\nyaw = {yaw}\npitch = -20.0\n");
    bench.write("path.toml", format!("seconds = 1.0\n{}{}", frame(0.0), frame(1e-9)));
    let scene = |moving: bool| {
        format!(
            "[water]\nenabled = true\nlevel = 0.8\nwaves = 0.8\nwave_length = 0.2\nmoving = {moving}\n\
             [clouds]\nenabled = true\nmoving = {moving}\nrate = 200.0\n"
        )
    };
    bench.write("moves.toml", scene(true));
    bench.write("stands.toml", scene(false));
    bench.write("later.toml", format!("{}time = 100.0\n", scene(false).replace("[clouds]", "time = 0.5\n[clouds]")));
    for (name, output) in [("moves", "a"), ("moves", "b"), ("stands", "c")] {
        let line = format!(
            "render map.png --scene {name}.toml --path path.toml --frames-per-second 2 --size 48x30 -o {output}"
        );
        bench.relief(&line).expect(0, &["3 pictures"]);
    }
    let picture = |folder: &str, number: usize| {
        image::open(bench.path(&format!("{folder}/frame-0000{number}.png"))).unwrap().to_rgb8()
    };
    assert!((1..3).all(|number| picture("a", number) != picture("a", number + 1)), "each is another moment");
    assert!((1..4).all(|number| picture("a", number) == picture("b", number)), "the same film twice");
    assert!((2..4).all(|number| picture("c", number) == picture("c", 1)), "clocks that stand");
    assert!(picture("a", 1) == picture("c", 1), "it begins where the scene is");
    // The second picture is half a second later, and the sky a hundred.
    bench
        .relief("render map.png --scene later.toml --path path.toml --frames-per-second 2 --size 48x30 -o d")
        .expect(0, &[]);
    assert!(picture("a", 2) == picture("d", 2));
}
