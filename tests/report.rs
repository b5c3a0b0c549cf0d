//! `relief report` as a user meets it: the files, their columns, and what is wrong with the arguments.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

use std::fs;
use std::path::Path;
use std::process::Command;

use image::{ImageBuffer, Luma};

const COLUMNS: &str = "view,technique,samples_min,samples_max,by_angle,halvings,see_through,covers_sky,p50,p95,p99,max,\
    incoherent,flip,ms,ms_p95,ratio,steps_mean,steps_max,cap_hits,prepare_ms,bytes";

/// Runs `relief` in `folder`; its exit code and stderr.
fn relief(folder: &Path, line: &str) -> (i32, String) {
    relief_with(folder, line, &[])
}

/// The same with further environment variables.
fn relief_with(folder: &Path, line: &str, environment: &[(&str, &str)]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_relief"));
    command.current_dir(folder).args(line.split_whitespace()).envs(environment.iter().copied());
    if std::env::var_os("RELIEF_ADAPTER").is_none() {
        command.env("RELIEF_ADAPTER", "cpu");
    }
    // Without this folder, which a bare container lacks, the Wayland library that Mesa loads complains on stderr.
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", folder);
    }
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// A folder with a map of 17×17 samples.
fn folder_with_map() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let height = |x: u32, z: u32| Luma([(x * 977 + z * 1571 + (x * z) % 17 * 1500) as u16]);
    ImageBuffer::from_fn(17, 17, height).save(folder.path().join("map.png")).unwrap();
    folder
}

/// The cells of a CSV whose columns are [`COLUMNS`], one map-like row each.
fn rows(folder: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(folder.join("report.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(COLUMNS));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn column(name: &str) -> usize {
    COLUMNS.split(',').position(|column| column == name).unwrap()
}

#[test]
fn the_same_map_gives_the_same_errors_and_the_exact_technique_has_none() {
    let folder = folder_with_map();
    for name in ["a", "deep/b"] {
        let (code, stderr) = relief(folder.path(), &format!("report map.png -o {name} --quick --size 48x30"));
        let end = format!("relief: the report is in {name}; begin with report.md\n");
        assert!(code == 0 && stderr.ends_with(&end), "{stderr}");
    }
    let (a, b) = (folder.path().join("a"), folder.path().join("deep/b"));
    let mut names: Vec<_> = fs::read_dir(&a).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["error-vs-time.png", "error-vs-time.svg", "report.csv", "report.json", "report.md"]);

    let (first, second) = (rows(&a), rows(&b));
    let views: Vec<_> = first.iter().map(|row| row[0].as_str()).collect();
    for view in ["over", "graze", "valley", "down", "horizon"] {
        assert!(views.contains(&view), "{view}");
    }
    // Everything but times is the same to the digit.
    let timed = ["ms", "ms_p95", "ratio", "prepare_ms"].map(column);
    assert_eq!(first.len(), second.len());
    for (left, right) in first.iter().zip(&second) {
        assert_eq!(left.len(), COLUMNS.split(',').count());
        for (index, (left, right)) in left.iter().zip(right).enumerate() {
            assert!(timed.contains(&index) || left == right, "column {index}: {left} and {right}");
        }
        assert!(timed.iter().all(|&index| left[index].parse::<f64>().is_ok_and(|ms| ms > 0.0)), "{left:?}");
    }
    let exact: Vec<_> = first.iter().filter(|row| row[1] == "max-mipmap").collect();
    assert_eq!(exact.len(), 5);
    for row in exact {
        assert_eq!((row[column("see_through")].as_str(), row[column("covers_sky")].as_str()), ("0", "0"));
        assert!(row[column("max")].parse::<f64>().unwrap() < 0.01, "cells: {row:?}");
        assert!(row[column("flip")].parse::<f64>().is_ok_and(|flip| flip < 1e-3), "{row:?}");
    }
    let base = first.iter().find(|row| row[1..6] == ["linear-binary", "128", "512", "true", "8"]).unwrap();
    assert_eq!(base[column("ratio")], "1");

    let json: serde_json::Value = serde_json::from_slice(&fs::read(a.join("report.json")).unwrap()).unwrap();
    assert_eq!(json["views"].as_array().unwrap().len(), 5);
    assert!(json["stopped"].is_null());
    let markdown = fs::read_to_string(a.join("report.md")).unwrap();
    for word in ["map.png, 17×17", "Table 1", "After an edit", "Left out", "### graze", "●"] {
        assert!(markdown.contains(word), "{word} is missing in {markdown}");
    }
    // What is made upon the ground costs the exact technique's frame, too; how the study's rays walk does not concern it.
    for (table, walks) in [("features", true), ("exact_features", false)] {
        let names: Vec<_> =
            json[table].as_array().unwrap().iter().map(|feature| feature["name"].as_str().unwrap()).collect();
        for feature in ["materials by a coverage map", "a placed picture over all the ground", "soft shadows, baked"] {
            assert!(names.contains(&feature), "{feature} is missing in {table}: {names:?}");
        }
        assert_eq!(names.contains(&"without halvings"), walks, "{table}");
        assert_eq!(names.contains(&"`cone`"), walks, "{table}");
    }
    let picture = image::open(a.join("error-vs-time.png")).unwrap().into_rgb8();
    assert!(picture.pixels().any(|pixel| pixel.0 == [0xD5, 0x5E, 0x00]), "the exact technique is in the plot");
    assert!(fs::read_to_string(a.join("error-vs-time.svg")).unwrap().starts_with("<svg"));
}

#[test]
fn the_cameras_of_scene_files_are_the_views() {
    let folder = folder_with_map();
    let scene = "terrain.file = \"map.png\"\n[camera]\neye = [0.5, 0.6, 1.5]\npitch = -30.0\n\
        [craters]\nlist = [{ x = 0.5, z = 0.5, radius = 0.2, depth = 0.5, rim = 0.1 }]\n";
    fs::write(folder.path().join("mine.toml"), scene).unwrap();
    let (code, stderr) = relief(folder.path(), "report -o out --quick --size 20x16 --scene mine.toml");
    assert!(code == 0 && stderr.ends_with("relief: the report is in out; begin with report.md\n"), "{stderr}");
    let rows = rows(&folder.path().join("out"));
    assert!(rows.iter().all(|row| row[0] == "mine"));
    let exact = rows.iter().find(|row| row[1] == "max-mipmap").unwrap();
    assert_eq!((exact[column("see_through")].as_str(), exact[column("covers_sky")].as_str()), ("0", "0"));
    assert!(exact[column("max")].parse::<f64>().unwrap() < 0.01, "the reference has the crater, too: {exact:?}");
}

#[test]
fn bad_input_is_a_message_and_an_exit_code() {
    let folder = folder_with_map();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::write(folder.path().join("bare.toml"), "terrain.file = \"map.png\"\n").unwrap();
    let cases = [
        ("report map.png", 2, "--output"),
        ("report map.png -o file", 1, "cannot write file"),
        ("report map.png -o file/below", 1, "cannot write file/below"),
        ("report map.png -o out --size 0x10", 2, "the width is 0"),
        ("report map.png -o out --size 999999x10", 2, "too large"),
        ("report -o out --scene bare.toml", 3, "bare.toml has no camera"),
        ("report -o out --scene none.toml", 3, "cannot read the scene file none.toml"),
        ("report none.png -o out", 3, "no such file"),
    ];
    for (line, expected, words) in cases {
        let (code, stderr) = relief(folder.path(), line);
        assert_eq!(code, expected, "{line}: {stderr}");
        assert!(stderr.contains(words), "{line}: {stderr}");
        assert!(stderr.lines().count() >= 3, "what, why and what to do: {stderr}");
    }
}

/// Without timestamps the wall's clock is read, and both who waits and who reads the report learn of it.
#[test]
fn an_adapter_without_timestamps_is_measured_with_the_walls_clock() {
    let folder = folder_with_map();
    let scene = "terrain.file = \"map.png\"\n[camera]\neye = [0.5, 0.6, 1.5]\npitch = -30.0\n";
    fs::write(folder.path().join("mine.toml"), scene).unwrap();
    let line = "report -o out --quick --size 20x16 --scene mine.toml";
    let (code, stderr) = relief_with(folder.path(), line, &[("RELIEF_TIMESTAMPS", "0")]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("no timestamps") && stderr.contains("wall times"), "{stderr}");
    let out = folder.path().join("out");
    let ms = column("ms");
    assert!(rows(&out).iter().all(|row| row[ms].parse::<f64>().is_ok_and(|ms| ms > 0.0)));
    let markdown = fs::read_to_string(out.join("report.md")).unwrap();
    assert!(markdown.contains("wall time from submitting to the end"), "{markdown}");
    let json: serde_json::Value = serde_json::from_slice(&fs::read(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(json["timestamps"], false);
}

#[cfg(unix)]
#[test]
fn ctrl_c_and_sigterm_keep_what_was_measured() {
    let folder = folder_with_map();
    let children = ["INT", "TERM"].map(|signal| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relief"));
        if std::env::var_os("RELIEF_ADAPTER").is_none() {
            command.env("RELIEF_ADAPTER", "cpu");
        }
        let child = command
            .current_dir(folder.path())
            .args(["report", "map.png", "-o", signal, "--size", "640x400"])
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        (signal, child)
    });
    // Long enough for the first pictures on a slow machine; all of it takes minutes.
    std::thread::sleep(std::time::Duration::from_secs(8));
    for (signal, child) in &children {
        let kill = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status();
        assert!(kill.unwrap().success(), "{signal}");
    }
    for (signal, child) in children {
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{signal}: {stderr}");
        let out = folder.path().join(signal);
        if stderr.contains("nothing was measured") {
            assert!(!out.join("report.md").exists());
            continue;
        }
        assert!(stderr.contains("not finished") && stderr.contains(signal), "{stderr}");
        assert!(!rows(&out).is_empty());
        let markdown = fs::read_to_string(out.join("report.md")).unwrap();
        assert!(markdown.contains("**Not finished:**"), "{markdown}");
    }
}
