//! `relief info` and `relief convert`, and the options that say how a file is to be opened.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A folder of its own, into which files of tests/data/formats are copied.
struct Bench(TempDir);

impl Bench {
    fn with(names: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats");
        for name in names {
            std::fs::copy(data.join(name), folder.path().join(name.rsplit('/').next().unwrap())).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Exit code, stdout, stderr.
    fn relief(&self, line: &str) -> (i32, String, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_relief"))
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .output()
            .unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
    }

    fn info(&self, line: &str) -> serde_json::Value {
        let (code, stdout, stderr) = self.relief(&format!("info --json {line}"));
        assert_eq!(code, 0, "{line}: {stderr}");
        serde_json::from_str(&stdout).unwrap()
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

#[test]
fn info_tells_all_that_is_known() {
    let bench = Bench::with(&["special/nan.tif", "special/degrees.tif", "special/bands.tif"]);
    let info = bench.info("nan.tif");
    assert_eq!((&info["format"], &info["compression"]), (&"TIFF".into(), &"none".into()));
    assert_eq!((&info["crs"], &info["vertical_unit"]), (&"EPSG:32611".into(), &"metre".into()));
    assert_eq!(info["metres_per_sample"].as_f64(), Some(30.0));
    assert!((info["nodata_fraction"].as_f64().unwrap() - 16.0 / 378.0).abs() < 1e-12, "{info}");
    let bounds = info["geographic_bounds"].as_array().unwrap();
    assert!((bounds[0].as_f64().unwrap() + 118.109).abs() < 0.01, "{info}");
    assert_eq!(bench.info("degrees.tif")["pixel_is"], "area");
    assert!(bench.info("bands.tif")["warnings"][0].as_str().unwrap().contains("bands.tif: it has 3 bands"));
    let (_, text, _) = bench.relief("info nan.tif");
    assert!(text.contains("EPSG:32611") && text.contains("4.233 %") && text.contains("600 m west–east"), "{text}");
}

#[test]
fn convert_keeps_what_a_format_cannot_say_in_a_sidecar() {
    let bench = Bench::with(&["special/nan.tif"]);
    let before = bench.info("nan.tif");
    for ending in ["png", "asc", "flt", "r16", "r32", "tif"] {
        let (code, _, stderr) = bench.relief(&format!("convert nan.tif -o out-{ending}.{ending}"));
        assert_eq!(code, 0, "{stderr}");
        let after = bench.info(&format!("out-{ending}.{ending}"));
        for key in ["width", "height", "nodata_fraction", "crs", "metres_per_sample", "bounds", "vertical_unit"] {
            assert_eq!(after[key], before[key], "{key} as {ending}");
        }
        for key in ["min", "max"] {
            let off = (after[key].as_f64().unwrap() - before[key].as_f64().unwrap()).abs();
            assert!(off < 0.01, "{key} as {ending}: {off}");
        }
        assert_eq!(after["warnings"].as_array().unwrap().len(), 0, "{after}");
    }
    assert!(stderr_of(&bench, "convert nan.tif -o again.png").contains("16 bits hold its heights to within"));
    let (code, _, _) = bench.relief("convert nan.tif -o filled.tif --holes fill");
    assert_eq!((code, bench.info("filled.tif")["nodata_fraction"].as_f64()), (0, Some(0.0)));
}

fn stderr_of(bench: &Bench, line: &str) -> String {
    bench.relief(line).2
}

#[test]
fn convert_writes_whole_files_or_none() {
    let bench = Bench::with(&["special/nan.tif", "other/hdf.nc"]);
    std::fs::write(bench.path("scene.toml"), "[camera]\neye = [0.0, 1.0, 0.0]\n").unwrap();
    assert_eq!(bench.relief("convert nan.tif -o taken.png").0, 0);
    let names = bench.names();
    for (line, expected, words) in [
        // Its sidecar says how the PNG is read.
        ("convert nan.tif -o taken.r16", 1, "taken.png"),
        ("convert nan.tif -o out.jpg", 2, ".png, .tif"),
        ("convert nan.tif -o nan.tif", 2, "would replace"),
        ("convert nan.tif -o none/out.tif", 1, "folder"),
        ("convert nan.tif -o scene.png", 1, "is no sidecar"),
        ("convert hdf.nc -o out.tif", 3, "HDF5"),
        ("convert nan.tif -o out.tif --window 0,0,99,99", 3, "not inside"),
        ("convert nan.tif -o out.tif --window 1,2,3", 2, "four numbers"),
    ] {
        let (code, _, stderr) = bench.relief(line);
        assert_eq!(code, expected, "{line}: {stderr}");
        assert!(stderr.contains(words), "{line}: {stderr}");
        assert_eq!(bench.names(), names, "{line} leaves nothing behind");
    }
}

#[test]
fn options_say_what_a_file_does_not() {
    let bench = Bench::with(&["other/oblong.raw", "other/terrarium.png", "special/nan.tif"]);
    let (code, _, stderr) = bench.relief("info oblong.raw");
    assert!(code == 3 && stderr.contains("--raw-size") && stderr.lines().count() >= 3, "{stderr}");
    let raw = bench.info("oblong.raw --raw-size 21x18 --raw-type i16 --raw-endian big");
    assert_eq!((raw["min"].as_f64(), raw["max"].as_f64()), (Some(-9000.0), Some(23725.0)));
    let tile = bench.info("terrarium.png --encoding terrarium");
    assert_eq!((tile["min"].as_f64(), tile["max"].as_f64()), (Some(-100.5), Some(380.75)));
    let part = bench.info("nan.tif --window 2,3,8,9 --nodata none");
    assert_eq!((&part["width"], &part["file_size"][0]), (&8.into(), &21.into()));
    assert_eq!(bench.info("nan.tif --reduce 3")["metres_per_sample"].as_f64(), Some(90.0));
    let feet = bench.info("nan.tif --vertical-unit foot");
    assert!((feet["max"].as_f64().unwrap() - 380.75 * 0.3048).abs() < 1e-9, "{feet}");
}
