//! Tests of opening height maps.

use std::cell::Cell;
use std::fs;

use image::{DynamicImage, ImageBuffer, Luma, Rgb};
use tempfile::TempDir;

use super::super::save;
use super::*;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// Writes a 16-bit map of noise, so that it does not compress to nothing.
fn write_map(folder: &TempDir, width: u32, height: u32) -> PathBuf {
    let path = folder.path().join("map.png");
    let raw: Vec<u16> = (0..width * height).map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as u16).collect();
    save::save_raw_png16(width, height, &raw, &path).unwrap();
    path
}

fn message(path: &Path) -> String {
    load(path).unwrap_err().to_string()
}

#[test]
fn the_shipped_grand_canyon_opens_at_its_true_proportion() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.warnings, Vec::<String>::new());
    assert_eq!(loaded.title.as_deref(), Some("Grand Canyon"));
    assert_eq!(loaded.sample_type, "u16");
    let field = loaded.field;
    assert_eq!((field.width(), field.height()), (512, 512));
    assert_eq!(field.range(), [479.0, 2347.0]);
    let size = field.box_size(None);
    assert!((size.y - 1868.0 / 31566.9).abs() < 1e-12, "{size}");
    assert!(size.x == 1.0 && (size.z - 31428.8 / 31566.9).abs() < 1e-12, "{size}");
    let metre = |h: f32| 479.0 + f64::from(h) * 1868.0;
    let worst = field.samples().iter().map(|&h| (metre(h) - metre(h).round()).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3, "every sample is a whole metre, but one is {worst} off");
    assert!(loaded.sidecar.unwrap().licence.is_some());
}

#[test]
fn eight_and_sixteen_bits_square_or_not_open_with_their_heights() {
    let folder = folder();
    let path = folder.path().join("small.png");
    ImageBuffer::<Luma<u8>, _>::from_raw(3, 2, vec![10u8, 20, 30, 40, 50, 60]).unwrap().save(&path).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!((loaded.sample_type, loaded.field.range()), ("u8", [10.0, 60.0]));
    assert_eq!(loaded.field.samples()[1], 0.2);
    assert!(loaded.warnings.is_empty() && loaded.sidecar.is_none());

    save::save_raw_png16(2, 2, &[0, 65535, 1, 2], &path).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!((loaded.sample_type, loaded.field.range()), ("u16", [0.0, 65535.0]));
    assert_eq!(loaded.field.samples(), [0.0, 1.0, (1.0 / 65535.0) as f32, (2.0 / 65535.0) as f32]);
}

/// Another program may cut a file off, write into it or delete it while it is being read.
#[test]
fn a_file_that_changes_while_it_is_read_is_a_map_or_a_message() {
    let folder = folder();
    let overwrite = |path: &Path| {
        let mut bytes = fs::read(path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle..].fill(0x55);
        // Into the same file: the reader's handle sees it.
        let mut file = fs::OpenOptions::new().write(true).open(path).unwrap();
        io::Write::write_all(&mut file, &bytes).unwrap();
    };
    let truncate = |path: &Path| fs::OpenOptions::new().write(true).open(path).unwrap().set_len(5000).unwrap();
    let delete = |path: &Path| fs::remove_file(path).unwrap();
    for name in ["overwritten", "cut", "deleted"] {
        // Larger than the reader's buffer, so that most of it is still unread at the first report.
        let path = write_map(&folder, 900, 800);
        let changed = Cell::new(false);
        let change = |_| {
            if !changed.replace(true) {
                match name {
                    "overwritten" => overwrite(&path),
                    "cut" => truncate(&path),
                    _ => delete(&path),
                }
            }
        };
        let listener = Listener { progress: &change, ..Listener::none() };
        let result = load_with(&path, &ImportOptions::default(), listener);
        assert!(changed.get(), "{name}: progress was reported");
        match result {
            // An open file can be read although its name is gone.
            Ok(loaded) => assert_eq!((name, loaded.field.width()), ("deleted", 900)),
            Err(error) => assert_eq!(error.to_string().lines().count(), 3, "{name}: {error}"),
        }
    }
}

#[test]
fn a_saved_map_comes_back() {
    let folder = folder();
    let field = load(&write_map(&folder, 37, 20)).unwrap().field;
    let path = folder.path().join("copy.png");
    save::save_png16(&field, &path).unwrap();
    let copy = load(&path).unwrap().field;
    let worst = field.samples().iter().zip(copy.samples()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst <= 0.51 / 65535.0, "{worst}");
    let missing = save::save_png16(&field, &folder.path().join("none/copy.png")).unwrap_err().to_string();
    assert!(missing.contains("copy.png") && missing.contains("folder"), "{missing}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing half-written is left");
}

#[test]
fn colour_is_converted_with_a_warning() {
    let folder = folder();
    let path = folder.path().join("colour.png");
    let picture = ImageBuffer::from_fn(4, 3, |x, _| Rgb([x as u8 * 60, 0, 200]));
    DynamicImage::ImageRgb8(picture).save(&path).unwrap();
    let loaded = load(&path).unwrap();
    assert!(loaded.warnings.len() == 1 && loaded.warnings[0].contains("luminance"), "{:?}", loaded.warnings);
    assert!(loaded.field.sample(3, 0) > loaded.field.sample(1, 0));
}

#[test]
fn each_bad_file_says_what_is_wrong_with_it() {
    let folder = folder();
    let good = fs::read(write_map(&folder, 64, 64)).unwrap();
    let path = folder.path().join("bad.png");
    let with = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        message(&path)
    };
    let cases = [
        (with(b""), "is empty"),
        (with(&good[..good.len() / 2]), "truncated"),
        (with(&good[..20]), "truncated"),
        (with(&good[..5]), "truncated"),
        (with(b"\xff\xd8\xff\xe0rest"), "the JPEG is"),
        (with(b"II*\0rest"), "the TIFF is"),
        (with(b"GIF89a"), "looks like a GIF"),
        (with(b"\x89HDF\r\n\x1a\n"), "looks like a netCDF-4"),
        (with(b"hello"), "looks like a text file"),
        (message(&folder.path().join("absent.png")), "no such file"),
        (message(folder.path()), "is a directory"),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{message}");
    }
    let mut damaged = good.clone();
    damaged[80..120].fill(0xa5);
    assert!(with(&damaged).contains("damaged"), "{}", with(&damaged));

    ImageBuffer::<Luma<u8>, _>::from_raw(1, 5, vec![0u8; 5]).unwrap().save(&path).unwrap();
    assert!(message(&path).contains("1×5 samples has no surface"), "{}", message(&path));
}

#[test]
fn absurd_dimensions_are_refused_before_anything_is_allocated() {
    let folder = folder();
    let mut bytes = fs::read(write_map(&folder, 4, 4)).unwrap();
    let path = folder.path().join("absurd.png");
    bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    fs::write(&path, &bytes).unwrap();
    assert!(message(&path).contains("2147483647×2147483647"), "{}", message(&path));
    bytes[16..24].copy_from_slice(&[0, 0, 0x80, 0, 0, 0, 0x80, 0]);
    fs::write(&path, &bytes).unwrap();
    assert!(message(&path).contains("truncated"), "a hundred bytes cannot hold 2 GiB: {}", message(&path));
}

#[cfg(unix)]
#[test]
fn a_file_that_may_not_be_read_says_so() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let path = write_map(&folder, 4, 4);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if File::open(&path).is_err() {
        assert!(message(&path).contains("permission denied"), "{}", message(&path));
    }
}

#[test]
fn a_sidecar_places_the_map_and_its_faults_are_only_warnings() {
    let folder = folder();
    let map = write_map(&folder, 11, 6);
    let open = |text: &str| {
        fs::write(folder.path().join("map.toml"), text).unwrap();
        load(&map).unwrap()
    };
    let placed = open("metres_per_sample = 10.0\nlowest_metre = 100\nhighest_metre = 150\nvertical_exaggeration = 2.0");
    assert!(placed.warnings.is_empty(), "{:?}", placed.warnings);
    assert_eq!(placed.field.extent_metres(), Some([100.0, 50.0]));
    assert_eq!(placed.field.box_size(None), glam::DVec3::new(1.0, 1.0, 0.5));

    let misspelt = open("titel = \"A\"\nextent_metres = [30.0, 60.0]\nlowest_metre = 0\nhighest_metre = 6");
    assert!(misspelt.warnings.len() == 1, "{:?}", misspelt.warnings);
    assert!(misspelt.warnings[0].contains("titel") && misspelt.warnings[0].contains("\"title\""));
    assert_eq!(misspelt.field.natural_height_scale(), 0.1, "the other keys hold");

    for broken in ["title = ", "extent_metres = \"wide\""] {
        let broken = open(broken);
        assert!(broken.warnings.len() == 1 && broken.warnings[0].contains("map.toml"), "{:?}", broken.warnings);
        assert!(broken.sidecar.is_none() && broken.field.extent_metres().is_none());
    }
    for nonsense in ["extent_metres = [0.0, 1.0]", "lowest_metre = 3", "lowest_metre = 3\nhighest_metre = 1"] {
        let nonsense = open(nonsense);
        assert!(nonsense.warnings.len() == 1 && nonsense.warnings[0].contains("ignored"), "{:?}", nonsense.warnings);
    }
}

#[test]
fn a_sidecar_whose_numbers_give_no_box_is_dropped_with_the_range_that_does() {
    let folder = folder();
    let map = write_map(&folder, 11, 6);
    let open = |text: &str| {
        fs::write(folder.path().join("map.toml"), text).unwrap();
        load(&map).unwrap()
    };
    for (text, range) in [
        ("extent_metres = [1e3, 1e3]\nlowest_metre = -1e308\nhighest_metre = 1e308", "0 to 1000"),
        ("extent_metres = [1e-300, 1e-300]\nlowest_metre = 0\nhighest_metre = 1", "0 to 1000"),
        ("vertical_exaggeration = 1e300", "0 to 1000"),
        ("extent_metres = [1e-300, 1.0]\nlowest_metre = 0\nhighest_metre = 1", "0.00001 to 100000"),
        ("metres_per_sample = 1e308\nlowest_metre = 0\nhighest_metre = 1", "0.00001 to 100000"),
    ] {
        let Loaded { field, warnings, .. } = open(text);
        assert!(warnings.len() == 1 && warnings[0].contains("map.toml"), "{text}: {warnings:?}");
        assert!(warnings[0].contains("ignored") && warnings[0].contains(range), "{text}: {warnings:?}");
        assert_eq!(field.box_size(None), glam::DVec3::new(1.0, 0.25, 0.5), "{text}: a plain image");
    }
    let steep = open("extent_metres = [2.0, 1.0]\nlowest_metre = 0\nhighest_metre = 1\nvertical_exaggeration = 1e4");
    assert!(steep.warnings.len() == 1 && steep.warnings[0].contains("vertical_exaggeration was"));
    assert_eq!(steep.field.natural_height_scale(), 0.5, "extent and heights hold");
}

#[test]
fn a_screenshots_scene_is_no_sidecar() {
    let folder = folder();
    let map = write_map(&folder, 4, 4);
    let open = |text: &str| {
        fs::write(folder.path().join("map.toml"), text).unwrap();
        load(&map).unwrap()
    };
    let scene = crate::scene_file::to_toml(&crate::scene::Scene::default()).unwrap();
    for text in [scene.as_str(), "[camera]\neye = [0.0, 1.0, 0.0]", "terrain.file = \"a.png\""] {
        let loaded = open(text);
        assert!(loaded.warnings.is_empty() && loaded.sidecar.is_none(), "{text}: {:?}", loaded.warnings);
    }
    assert_eq!(open("title = \"A\"\n[march]").warnings.len(), 1, "a sidecar with a stray table");
}

/// A scene gets a new table sooner or later; its file must not become a sidecar by that.
#[test]
fn every_table_of_a_scene_tells_it_from_a_sidecar() {
    let scene = crate::scene::Scene {
        camera: Some(crate::camera::Camera { eye: glam::DVec3::ONE, yaw: 0.0, pitch: 0.0, fov: 60.0 }),
        ..Default::default()
    };
    let text = crate::scene_file::to_toml(&scene).unwrap();
    for (name, value) in text.parse::<toml::Table>().unwrap() {
        let mut warnings = Vec::new();
        let alone = toml::Table::from_iter([(name.clone(), value)]).to_string();
        assert_eq!(Sidecar::parse(&alone, Path::new("map.toml"), &mut warnings), None, "{name}");
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
    }
}

#[test]
fn the_first_bytes_beat_the_ending() {
    let folder = folder();
    let path = write_map(&folder, 37, 20);
    let renamed = folder.path().join("map.hgt");
    fs::rename(&path, &renamed).unwrap();
    let loaded = load(&renamed).unwrap();
    assert_eq!((loaded.format, loaded.field.width()), (Format::Png, 37));
}

/// The heights that a sidecar gives are those of the whole file, whatever part of it is shown.
#[test]
fn a_part_has_the_heights_and_the_extent_of_the_part() {
    let folder = folder();
    let path = folder.path().join("map.png");
    // 0 to 100 by column.
    let raw: Vec<u16> = (0..11 * 6).map(|i| i % 11 * 10).collect();
    save::save_raw_png16(11, 6, &raw, &path).unwrap();
    let sidecar = "lowest_metre = 1000\nhighest_metre = 2000\nextent_metres = [500.0, 250.0]";
    fs::write(folder.path().join("map.toml"), sidecar).unwrap();
    let open = |options: &ImportOptions| load_with(&path, options, Listener::none()).unwrap();
    let part = open(&ImportOptions { window: Some([2, 0, 5, 6]), ..Default::default() });
    assert_eq!((part.field.range(), part.field.extent_metres()), ([1200.0, 1600.0], Some([200.0, 250.0])));
    let means = open(&ImportOptions { reduce: Some(2), ..Default::default() });
    assert_eq!((means.field.width(), means.field.height()), (5, 3));
    assert_eq!((means.field.range(), means.field.extent_metres()), ([1050.0, 1850.0], Some([400.0, 200.0])));
}

#[test]
fn what_a_file_does_not_say_the_sidecar_can() {
    let folder = folder();
    let path = folder.path().join("map.raw");
    let samples: Vec<u8> = (0..12i16).flat_map(|i| (i * 100 - 500).to_be_bytes()).collect();
    fs::write(&path, samples).unwrap();
    let sidecar = "raw_size = [4, 3]\nraw_type = \"i16\"\nraw_endian = \"big\"\nnodata = -500\nholes = \"floor\"\n\
        crs = \"EPSG:32611\"\norigin = [400000.0, 4000000.0]\nstep = [30.0, -30.0]\nvertical_unit = \"foot\"";
    fs::write(folder.path().join("map.toml"), sidecar).unwrap();
    let loaded = load(&path).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!((loaded.field.width(), loaded.sample_type, loaded.nodata_fraction), (4, "i16", 1.0 / 12.0));
    assert!(loaded.field.holes().is_none() && loaded.field.sample(0, 0) == 0.0, "floored");
    assert_eq!(loaded.field.range(), [-400.0 * 0.3048, 600.0 * 0.3048], "in metres");
    assert_eq!(loaded.field.extent_metres(), Some([90.0, 60.0]));

    let text = loaded.sidecar.unwrap().to_toml().unwrap();
    let mut warnings = Vec::new();
    let again = Sidecar::parse(&text, Path::new("map.toml"), &mut warnings).unwrap();
    assert!(warnings.is_empty() && again.to_toml().unwrap() == text, "{text}\n{warnings:?}");
    let options = ImportOptions { holes: Some(super::super::Holes::CutOut), ..Default::default() };
    assert!(load_with(&path, &options, Listener::none()).unwrap().field.is_hole(0, 0), "an option beats the sidecar");
}

/// One of its keys beside others is a sidecar; none may be missing from the list.
#[test]
fn every_key_of_a_sidecar_is_known() {
    for key in Sidecar::KEYS {
        let mut warnings = Vec::new();
        let unlikely = format!("{key} = [[[]]]");
        Sidecar::parse(&unlikely, Path::new("map.toml"), &mut warnings);
        assert!(
            warnings.len() == 1 && warnings[0].contains("ignored") && !warnings[0].contains("unknown"),
            "{warnings:?}"
        );
    }
    let all = [ImportOptions::KEYS.as_slice(), &Sidecar::KEYS].concat();
    assert!(all.iter().all(|key| Sidecar::KEYS.contains(key)));
}

#[test]
fn progress_grows_to_one() {
    let folder = folder();
    let path = write_map(&folder, 600, 500);
    let (last, calls) = (Cell::new(0.0), Cell::new(0));
    let hear = |share| {
        assert!(share >= last.get());
        last.set(share);
        calls.set(calls.get() + 1);
    };
    let listener = Listener { progress: &hear, ..Listener::none() };
    load_with(&path, &ImportOptions::default(), listener).unwrap();
    assert!(last.get() == 1.0 && calls.get() > 2, "{} after {}", last.get(), calls.get());
}

/// The page on formats shows every key of a sidecar, and each as it is read.
#[test]
fn the_guides_sidecar_is_one() {
    let page = include_str!("../guide/formats.md");
    let example = page.split("```toml").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let mut warnings = Vec::new();
    Sidecar::parse(example, Path::new("map.toml"), &mut warnings).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let table: toml::Table = example.parse().unwrap();
    let shown = |key: &&str| table.contains_key(*key) || ["extent_metres", "recipe"].contains(key);
    assert!(Sidecar::KEYS.iter().all(shown), "{table}");
}
