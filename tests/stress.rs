//! `relief stress`: the exact technique keeps its promise in the quick form, a broken one is found out, and a user who
//! errs or interrupts is told.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use relief::report::Monitor;
use relief::report::stress::{self, Job};
use relief::scene::Technique;

/// A command that runs `relief` in `folder`.
fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_relief"));
    command.current_dir(folder).args(line.split_whitespace());
    if std::env::var_os("RELIEF_ADAPTER").is_none() {
        command.env("RELIEF_ADAPTER", "cpu");
    }
    // Without this folder, which a bare container lacks, the Wayland library that Mesa loads complains on stderr.
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", folder);
    }
    command
}

/// Runs `relief` in `folder`; its exit code, stdout and stderr.
fn relief(folder: &Path, line: &str) -> (i32, String, String) {
    let output = command(folder, line).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn the_quick_form_finds_the_exact_technique_exact() {
    let folder = tempfile::tempdir().unwrap();
    let (code, _, stderr) = relief(folder.path(), "stress -o deep/out --quick");
    // Lines of progress may come before it.
    assert!(code == 0 && stderr.contains("relief: max-mipmap kept its promise in all "), "{stderr}");
    let out = folder.path().join("deep/out");
    let expected =
        ["contact-sheet.png", "stress-bound.png", "stress-bound.svg", "stress.csv", "stress.json", "stress.md"];
    assert_eq!(files(&out), expected);

    let json: serde_json::Value = serde_json::from_slice(&fs::read(out.join("stress.json")).unwrap()).unwrap();
    let cases = json["cases"].as_array().unwrap();
    let sum = |key: &str| cases.iter().map(|case| case["judgement"][key].as_u64().unwrap()).sum::<u64>();
    assert_eq!(["missed", "invented", "astray", "nan"].map(sum), [0; 4]);
    assert!(cases.len() > 70 && sum("hits") > 50_000, "{} cases, {} hits", cases.len(), sum("hits"));
    let ratio = cases.iter().map(|case| case["judgement"]["ratio"].as_f64().unwrap()).fold(0.0, f64::max);
    // A bound that nothing comes near would prove nothing.
    assert!((0.02..=1.0).contains(&ratio), "the largest displacement is {ratio} of its bound");
    for case in cases {
        let seen = case["judgement"]["hits"].as_u64().unwrap();
        let view = case["view"].as_str().unwrap();
        let may_miss = view == "straight-up-inside" || view.starts_with("random");
        assert!(seen > 0 || may_miss, "{} shows no ground", case["name"]);
    }

    let csv = fs::read_to_string(out.join("stress.csv")).unwrap();
    let mut lines = csv.lines();
    let columns = lines.next().unwrap();
    assert!(columns.starts_with("case,view,technique,samples_min,") && columns.ends_with(",prepare_ms,bytes"));
    assert!(lines.all(|line| line.split(',').count() == columns.split(',').count()));
    assert!(Technique::ALL.iter().all(|technique| csv.contains(&format!(",{},", technique.name()))));
    let markdown = fs::read_to_string(out.join("stress.md")).unwrap();
    for words in ["The promise is kept", "What breaks the others", "**`linear-binary`**", "fresh build: holds"] {
        assert!(markdown.contains(words), "{words} is missing in {markdown}");
    }
    let sheet = image::open(out.join("contact-sheet.png")).unwrap().into_rgb8();
    // A technique that sees through the ground does so on the sheet.
    let seen_through = relief::render::SEE_THROUGH;
    assert!(sheet.height() > 40 * 70 && sheet.pixels().filter(|pixel| pixel.0 == seen_through).count() > 300);
}

/// Never stops.
struct Patient;

impl Monitor for Patient {
    fn tell(&self, _: &str, _: f64) {}

    fn stop(&self) -> bool {
        false
    }
}

/// What judges the exact technique must not let the others pass, or it judges nothing.
#[test]
fn a_technique_that_is_not_exact_is_found_out() {
    let gpu = common::gpu();
    let only = ["needles", "wall/graze", "checkerboard/graze", "noise/graze"].map(str::to_owned).to_vec();
    for technique in Technique::ALL {
        let job = Job { size: [64, 40], quick: true, only: only.clone(), exact: technique };
        let report = stress::measure(&gpu, &job, &Patient).unwrap();
        assert!(report.cases.len() > 3);
        assert_eq!(report.holds(), technique == Technique::MaxMipmap, "{technique:?}: {:?}", report.failures());
        assert_eq!(report.holds(), report.failures().is_empty());
    }
}

#[test]
fn cases_are_chosen_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let (code, stdout, stderr) = relief(folder.path(), "stress --list --quick --case needles --case fov-0.001");
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert!(
        stdout.lines().count() > 2 && stdout.lines().all(|name| name.contains("needles") || name.contains("fov-0.001"))
    );
    let (code, _, stderr) = relief(folder.path(), "stress -o out --quick --case needles/graze --size 32x20");
    assert!(
        code == 0 && stderr.ends_with("relief: max-mipmap kept its promise in all 1 cases; see stress.md in out\n"),
        "{stderr}"
    );
    let out = folder.path().join("out");
    assert_eq!(files(&out), ["contact-sheet.png", "stress.csv", "stress.json", "stress.md"]);
    let csv = fs::read_to_string(out.join("stress.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + Technique::ALL.len());
    assert!(csv.lines().skip(1).all(|line| line.starts_with("needles/graze,graze,")));
}

#[test]
fn bad_input_is_a_message_and_an_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let cases = [
        ("stress", 2, "--output"),
        ("stress -o file", 1, "cannot write file"),
        ("stress -o file/below", 1, "cannot write file/below"),
        ("stress -o out --size 0x10", 2, "the width is 0"),
        ("stress -o out --size 999999x10", 2, "too large"),
        ("stress -o out --case nonsense", 2, "there is no case with `nonsense`"),
    ];
    for (line, expected, words) in cases {
        let (code, _, stderr) = relief(folder.path(), line);
        assert_eq!(code, expected, "{line}: {stderr}");
        assert!(stderr.contains(words), "{line}: {stderr}");
        assert!(stderr.lines().count() >= 3, "what, why and what to do: {stderr}");
    }
}

#[cfg(unix)]
#[test]
fn a_signal_keeps_what_was_measured() {
    for signal in ["-INT", "-TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let child = command(folder.path(), "stress -o out --size 640x400")
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        // Long enough for the first cases on a slow machine; all of them take minutes.
        std::thread::sleep(std::time::Duration::from_secs(6));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{signal}: {stderr}");
        if stderr.contains("nothing was measured") {
            assert!(files(&folder.path().join("out")).is_empty());
            continue;
        }
        assert!(stderr.contains("not finished") && stderr.contains("out"), "{stderr}");
        let markdown = fs::read_to_string(folder.path().join("out/stress.md")).unwrap();
        assert!(markdown.contains("**Not finished:**"), "{markdown}");
        assert_eq!(files(&folder.path().join("out")), ["contact-sheet.png", "stress.csv", "stress.json", "stress.md"]);
    }
}
