//! What the README promises.

use std::fs;
use std::path::Path;

use crate::bench::Bench;

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

/// Every preset that ships is a scene, and the README tells of it.
#[test]
fn the_presets_are_scenes_that_the_readme_lists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let presets: Vec<_> =
        fs::read_dir(root.join("assets/presets")).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(presets.len() >= 6, "{presets:?}");
    for preset in presets {
        let scene = relief::scene_file::read(&preset).unwrap();
        assert!(scene != relief::scene::Scene::default(), "{} shows nothing of its own", preset.display());
        let name = preset.file_name().unwrap().to_string_lossy().into_owned();
        assert!(readme.contains(&format!("`{name}`")), "{name} is missing in the README");
    }
}

/// Text and code are no wider than a page of code, but for the rows of tables, which cannot be broken.
#[test]
fn no_line_of_the_documentation_is_too_long() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in ["README.md", "src/guide/formats.md", "src/guide/technique.md", "src/guide/tour.md"] {
        for (line, number) in fs::read_to_string(root.join(name)).unwrap().lines().zip(1..) {
            let length = line.chars().count();
            assert!(length <= 128 || line.starts_with('|'), "{name}:{number} has {length} characters");
        }
    }
}
