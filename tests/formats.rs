//! Elevation files that other programs wrote (tests/data/formats/make.py), sample by sample against the formulas that
//! they were written from.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

use std::path::{Path, PathBuf};

use relief::heightfield::import::{
    Elevation, Encoding, Endian, GroundUnit, ImportOptions, Listener, NoData, PixelIs, RawType, VerticalUnit,
};
use relief::heightfield::load::{self, LoadError};

const WIDTH: u32 = 21;
const HEIGHT: u32 = 18;

/// The same as `value` in make.py.
fn value(kind: &str, column: u32, row: u32) -> f64 {
    let n = f64::from(7 * column + 5 * row * row + column * row);
    match kind {
        "uint8" => n % 251.0,
        "int8" => n % 251.0 - 125.0,
        "uint16" => 200.0 + 31.0 * n,
        "int16" => 17.0 * n - 9000.0,
        "uint32" => 3_000_000_000.0 + 70_001.0 * n,
        "int32" => 70_001.0 * n - 60_000_000.0,
        "float32" => n * 0.25 - 100.5,
        "float64" => n / 3.0 - 100.0,
        other => panic!("no formula for {other}"),
    }
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats").join(name)
}

fn open_with(name: &str, options: &ImportOptions) -> Elevation {
    load::decode(&file(name), options, Listener::none()).unwrap_or_else(|error| panic!("{name}: {error}")).0
}

fn open(name: &str) -> Elevation {
    open_with(name, &ImportOptions::default())
}

fn refusal(name: &str, options: &ImportOptions) -> String {
    match load::decode(&file(name), options, Listener::none()) {
        Ok(_) => panic!("{name} opens"),
        Err(error) => error.to_string(),
    }
}

/// Every sample as `expected` has it, to within `tolerance`; `None` is a hole.
fn assert_heights(name: &str, elevation: &Elevation, tolerance: f64, expected: impl Fn(u32, u32) -> Option<f64>) {
    for (column, row) in (0..elevation.height).flat_map(|row| (0..elevation.width).map(move |column| (column, row))) {
        let (found, expected) = (elevation.height_at(column, row), expected(column, row));
        let same = match (found, expected) {
            (Some(found), Some(expected)) => (found - expected).abs() <= tolerance,
            (None, None) => true,
            _ => false,
        };
        assert!(same, "{name}, column {column}, row {row}: {found:?} instead of {expected:?}");
    }
}

fn assert_grid(name: &str, elevation: &Elevation, kind: &str) {
    assert_eq!((elevation.width, elevation.height), (WIDTH, HEIGHT), "{name}");
    assert_heights(name, elevation, 0.0, |column, row| Some(value(kind, column, row)));
}

#[test]
fn every_type_compression_predictor_and_layout_of_tiff() {
    let mut names: Vec<String> = std::fs::read_dir(file("tiff"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".tif"))
        .collect();
    names.sort();
    println!("{:<9}{:<10}{:<11}{:<8}result", "type", "packed", "predictor", "layout");
    for name in &names {
        let parts: Vec<&str> = name.trim_end_matches(".tif").split('-').collect();
        let [kind, compression, predictor, layout] = parts[..] else { panic!("{name}") };
        let name = format!("tiff/{name}");
        let elevation = open(&name);
        assert_grid(&name, &elevation, kind);
        let short = kind.replace("uint", "u").replace("int", "i").replace("float", "f");
        assert_eq!(elevation.sample_type, short, "{name}");
        assert_eq!(elevation.samples.type_name(), short, "{name}");
        let packed = elevation.compression.unwrap_or_default();
        assert_eq!(packed.to_lowercase(), compression, "{name}");
        println!("{kind:<9}{packed:<10}{predictor:<11}{layout:<8}pass");
    }
    // Eight types; none and PackBits have no predictor, the others 1 and 2, and for floats 3; strips and tiles.
    assert_eq!(names.len(), (8 * (2 + 3 * 2) + 2 * 3) * 2);
}

#[test]
fn geotiffs_say_where_they_are() {
    let size = [WIDTH, HEIGHT];
    for name in ["bigtiff", "big-endian", "cog", "point", "south-up"] {
        let name = format!("special/{name}.tif");
        let elevation = open(&name);
        assert_grid(&name, &elevation, "int16");
        let place = elevation.georeference.clone().unwrap();
        assert_eq!((place.epsg, place.unit), (Some(32611), Some(GroundUnit::Metres(1.0))), "{name}");
        let is_point = name.contains("point");
        assert_eq!(place.pixel == PixelIs::Point, is_point, "{name}");
        // A point stands where GDAL has the middle of the cell, too.
        assert_eq!(place.at(0.0, 0.0), [400_015.0, 3_999_985.0], "{name}");
        assert_eq!(place.at(1.0, 1.0), [400_045.0, 3_999_955.0], "{name}");
        assert_eq!(elevation.extent_metres(), Some([600.0, 510.0]), "{name}");
        assert_eq!(elevation.vertical_unit, Some(VerticalUnit::Metre), "{name}");
    }
    let degrees = open("special/degrees.tif");
    let place = degrees.georeference.clone().unwrap();
    assert_eq!((place.crs.as_deref(), place.unit), (Some("EPSG:4326"), Some(GroundUnit::Degrees(1.0))));
    // 35.91° north: a hundredth of a degree is 903 m by 1110 m.
    let [east, north] = place.metres_per_sample(size).unwrap();
    assert!((east - 902.6).abs() < 1.0 && (north - 1109.6).abs() < 1.0, "{east} {north}");

    let mercator = open("special/mercator.tif");
    let place = mercator.georeference.clone().unwrap();
    assert_eq!((place.epsg, place.unit), (Some(3857), Some(GroundUnit::WebMercator)));
    let [east, north] = place.metres_per_sample(size).unwrap();
    assert!((east - 809.0).abs() < 3.0 && (north - 806.0).abs() < 3.0, "{east} {north}: shorter by the latitude");

    let feet = open("special/feet.tif");
    assert!((feet.extent_metres().unwrap()[0] - 20.0 * 100.0 * 1200.0 / 3937.0).abs() < 1e-6, "{feet:?}");

    let rotated = open("special/rotated.tif");
    assert_grid("rotated", &rotated, "int16");
    assert!(rotated.warnings.iter().any(|warning| warning.contains("rotated")), "{:?}", rotated.warnings);
    let [east, south] = rotated.extent_metres().unwrap();
    assert!((east - 600.0).abs() < 1e-6 && (south - 510.0).abs() < 1e-6, "{east} {south}");
}

#[test]
fn holes_are_a_mask_and_never_heights() {
    let name = "special/nodata.tif";
    let nodata = open(name);
    let int16 = |column, row| value("int16", column, row);
    assert_heights(name, &nodata, 0.0, |c, r| ((c, r) != (3, 4)).then(|| int16(c, r)));
    assert_eq!(nodata.samples.get(4 * 21 + 3), 0.0, "what stood there is gone");
    let kept = open_with(name, &ImportOptions { nodata: Some(NoData::Never), ..Default::default() });
    assert_heights(name, &kept, 0.0, |c, r| Some(if (c, r) == (3, 4) { -9999.0 } else { int16(c, r) }));
    let other = ImportOptions { nodata: Some(NoData::Value(int16(0, 0))), ..Default::default() };
    assert_eq!(open_with(name, &other).height_at(0, 0), None);

    let name = "special/nan.tif";
    let nan = load::load(&file(name)).unwrap();
    let hole = |c: u32, r: u32| (6..10).contains(&c) && (5..9).contains(&r);
    assert_heights(name, &open(name), 0.0, |c, r| (!hole(c, r)).then(|| value("float32", c, r)));
    assert_eq!(nan.nodata_fraction, 16.0 / f64::from(WIDTH * HEIGHT));
    assert_eq!(nan.field.range(), [value("float32", 0, 0), value("float32", 20, 17)]);
    assert!(nan.field.is_hole(6, 5) && !nan.field.has_ground(5, 4) && nan.field.has_ground(4, 4));

    // Three of four tiles and a part of the fourth were never written; the decoder must not be asked for them.
    let name = "special/sparse.tif";
    let sparse = open(name);
    let tile = |c: u32, r: u32| (16..32).contains(&c) && (16..32).contains(&r);
    assert_heights(name, &sparse, 0.0, |c, r| tile(c, r).then(|| int16(c - 16, r - 16)));
}

#[test]
fn bands_scales_and_rarer_samples() {
    let int16 = |column, row| value("int16", column, row);
    for (name, band) in [("special/bands.tif", 1), ("special/bands.tif", 3), ("special/planes.tif", 2)] {
        let elevation = open_with(name, &ImportOptions { band: Some(band), ..Default::default() });
        assert_heights(name, &elevation, 0.0, |c, r| Some(int16(c, r) + 1000.0 * f64::from(band - 1)));
        assert!(elevation.warnings.is_empty(), "{:?}", elevation.warnings);
    }
    let guessed = open("special/bands.tif");
    assert!(guessed.warnings.iter().any(|warning| warning.contains("--band")), "{:?}", guessed.warnings);
    let beyond = refusal("special/bands.tif", &ImportOptions { band: Some(4), ..Default::default() });
    assert!(beyond.contains("no band 4") && beyond.contains("1 to 3"), "{beyond}");

    assert_heights("scaled", &open("special/scaled.tif"), 0.0, |c, r| Some(int16(c, r) * 0.5 + 100.0));
    let half = open("special/sixteen-bit-floats.tif");
    assert_eq!(half.sample_type, "f16");
    assert_heights("half", &half, 0.07, |c, r| Some(value("float32", c, r) / 4.0));
    let jpeg = open("special/jpeg.tif");
    assert_heights("jpeg", &jpeg, 64.0, |c, r| Some(value("uint8", c, r)));
}

#[test]
fn what_is_not_supported_has_its_name_in_the_message() {
    let plain = ImportOptions::default();
    for (name, words) in [
        ("special/complex.tif", "complex"),
        ("special/palette.tif", "has a palette"),
        ("special/lerc.tif", "LERC compression"),
        ("other/hdf.nc", "netCDF-4 or HDF5"),
        ("other/oblong.raw", "--raw-size"),
    ] {
        let message = refusal(name, &plain);
        assert!(message.contains(words), "{name}: {message}");
        assert!(message.lines().count() >= 3, "what, why and what to do: {message}");
    }
}

#[test]
fn esri_grids() {
    let plain = ImportOptions::default();
    for (name, kind, tolerance) in [
        ("other/grid.asc", "int16", 0.0),
        ("other/floats.asc", "float32", 0.0),
        ("other/grid.bil", "int16", 0.0),
        ("other/floats.flt", "float32", 0.0),
        ("other/bands.bil", "uint8", 0.0),
    ] {
        let elevation = open_with(name, &plain);
        assert_heights(name, &elevation, tolerance, |c, r| Some(value(kind, c, r)));
        let place = elevation.georeference.clone().unwrap();
        let [x, y] = place.at(0.0, 0.0);
        assert!((x - 400_015.0).abs() < 1e-6 && (y - 3_999_985.0).abs() < 1e-6, "{name}: {x} {y}");
        assert_eq!(elevation.extent_metres(), Some([600.0, 510.0]), "{name}");
    }
    assert_eq!(open("other/grid.asc").sample_type, "i32", "whole numbers");
    let second = open_with("other/bands.bil", &ImportOptions { band: Some(2), ..plain });
    assert_heights("the second band", &second, 0.0, |c, r| Some(value("uint8", c, HEIGHT - 1 - r)));
}

#[test]
fn terragen_and_usgs() {
    let terragen = open("other/terrain.ter");
    // It holds heights as steps of the range that was said when it was written.
    assert_heights("terrain.ter", &terragen, 0.2, |c, r| Some(((value("int16", c, r) + 9000.0) / 4.0).floor()));
    let extent = terragen.extent_metres().unwrap();
    assert!((extent[0] - 600.0).abs() < 0.1 && (extent[1] - 510.0).abs() < 0.1, "{extent:?}");

    let dem = open("other/profile.dem");
    assert_eq!((dem.width, dem.height, dem.sample_type), (WIDTH, HEIGHT, "i32"));
    assert_heights("profile.dem", &dem, 0.0, |c, r| Some(value("int16", c, r)));
    let place = dem.georeference.clone().unwrap();
    assert_eq!((place.epsg, place.at(0.0, 0.0)), (Some(26911), [400_000.0, 4_000_000.0]));
    assert_eq!(dem.extent_metres(), Some([600.0, 510.0]));
}

#[test]
fn netcdf() {
    let int16 = |column, row| value("int16", column, row);
    for name in ["other/classic.nc", "other/offset64.nc"] {
        let elevation = open(name);
        assert_heights(name, &elevation, 0.0, |c, r| ((c, r) != (3, 2)).then(|| int16(c, r)));
        let place = elevation.georeference.clone().unwrap();
        let north_west = place.at(0.0, 0.0);
        assert!((north_west[0] + 120.0).abs() < 1e-9 && (north_west[1] - 37.7).abs() < 1e-9, "{north_west:?}");
        let [east, north] = place.metres_per_sample([WIDTH, HEIGHT]).unwrap();
        assert!((8900.0..9000.0).contains(&east) && (11_000.0..11_200.0).contains(&north), "{east} {north}");
    }
    // Two records of depths in a packed type, beside another variable.
    let packed = open("other/packed.nc");
    assert_heights("packed", &packed, 0.0, |c, r| Some(-(int16(c, r) * 0.5 + 10.0)));
    assert_eq!(packed.extent_metres(), Some([1800.0, 1530.0]));
    assert!(packed.warnings.iter().any(|warning| warning.contains("\"depth\"")), "{:?}", packed.warnings);
    assert!(packed.warnings.iter().any(|warning| warning.contains("depths")), "{:?}", packed.warnings);
    let slope = open_with("other/packed.nc", &ImportOptions { variable: Some("slope".into()), ..Default::default() });
    assert_heights("slope", &slope, 0.0, |_, _| Some(0.0));
    let missing = refusal("other/packed.nc", &ImportOptions { variable: Some("a".into()), ..Default::default() });
    assert!(missing.contains("slope, depth"), "{missing}");
    assert_grid("cdf5", &open("other/cdf5.nc"), "uint32");
}

#[test]
fn pictures_and_tiles() {
    assert_grid("grey8", &open("other/grey8.png"), "uint8");
    assert_grid("grey16", &open("other/grey16.png"), "uint16");
    assert_grid("webp", &open("other/grey.webp"), "uint8");
    assert_heights("jpeg", &open("other/grey.jpg"), 40.0, |c, r| Some(value("uint8", c, r)));
    for name in ["other/grey.jpg", "other/grey.webp"] {
        assert!(open(name).warnings.iter().any(|warning| warning.contains("256 heights")), "{name}");
    }
    for (name, encoding, tolerance) in
        [("other/terrarium.png", Encoding::Terrarium, 0.0), ("other/mapbox.png", Encoding::Mapbox, 0.0501)]
    {
        let asked = ImportOptions { encoding: Some(encoding), ..Default::default() };
        let elevation = open_with(name, &asked);
        assert_heights(name, &elevation, tolerance, |c, r| Some(value("float32", c, r)));
        assert_eq!(elevation.vertical_unit, Some(VerticalUnit::Metre));
        let unasked = open(name);
        assert!(unasked.sample_type == "u8" && !unasked.warnings.is_empty(), "never silently: {unasked:?}");
    }
    let jpeg = refusal("other/grey.jpg", &ImportOptions { encoding: Some(Encoding::Mapbox), ..Default::default() });
    assert!(jpeg.contains("losses"), "{jpeg}");
}

#[test]
fn openexr() {
    for (name, kind, sample_type, tolerance) in [
        ("other/single.exr", "float32", "f32", 0.0),
        ("other/half.exr", "float32", "f16", 0.13),
        ("other/whole.exr", "uint32", "u32", 0.0),
        ("other/two.exr", "float32", "f32", 0.0),
    ] {
        let elevation = open(name);
        assert_eq!(elevation.sample_type, sample_type, "{name}");
        assert_heights(name, &elevation, tolerance, |c, r| Some(value(kind, c, r)));
    }
    let other = open_with("other/two.exr", &ImportOptions { variable: Some("other".into()), ..Default::default() });
    assert_heights("other", &other, 0.0, |_, _| Some(0.0));
}

#[test]
fn raw_files_say_nothing_so_it_is_guessed_or_asked() {
    assert_heights("r16", &open("other/square.r16"), 0.0, |c, r| Some(value("uint16", c, r)));
    assert_heights("r32", &open("other/square.r32"), 0.0, |c, r| Some(value("float32", c, r)));
    let said = ImportOptions {
        raw_size: Some([WIDTH, HEIGHT]),
        raw_type: Some(RawType::I16),
        raw_endian: Some(Endian::Big),
        ..Default::default()
    };
    assert_grid("oblong", &open_with("other/oblong.raw", &said), "int16");
    let flipped = open_with("other/oblong.raw", &ImportOptions { flip: Some(true), ..said.clone() });
    assert_heights("flipped", &flipped, 0.0, |c, r| Some(value("int16", c, HEIGHT - 1 - r)));
    let too_large = refusal("other/oblong.raw", &ImportOptions { raw_size: Some([WIDTH, HEIGHT + 1]), ..said });
    assert!(too_large.contains("too few for 21×19 samples"), "{too_large}");
}

#[test]
fn an_srtm_tile_knows_its_place_by_its_name() {
    let mut plain = Vec::new();
    let packed = std::fs::File::open(file("other/N36W113.hgt.gz")).unwrap();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(packed), &mut plain).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("N36W113.hgt");
    std::fs::write(&path, &plain).unwrap();
    let decode = |path: &Path| load::decode(path, &ImportOptions::default(), Listener::none()).unwrap().0;
    let tile = decode(&path);
    assert_heights("tile", &tile, 0.0, |c, r| {
        let corner = c < WIDTH && r < HEIGHT;
        ((c, r) != (600, 600)).then(|| if corner { value("int16", c, r) } else { 100.0 })
    });
    let place = tile.georeference.clone().unwrap();
    assert_eq!(place.bounds([1201, 1201]), [-113.0, 36.0, -112.0, 37.0]);
    let [east, south] = tile.extent_metres().unwrap();
    assert!((east - 89_500.0).abs() < 300.0 && (south - 110_970.0).abs() < 100.0, "{east} {south}");

    let nameless = folder.path().join("somewhere.hgt");
    std::fs::rename(&path, &nameless).unwrap();
    let tile = decode(&nameless);
    assert!(tile.warnings[0].contains("name"), "{:?}", tile.warnings);
    std::fs::write(&nameless, &plain[..plain.len() - 2]).unwrap();
    let error = load::load(&nameless).unwrap_err();
    assert!(error.to_string().contains("1201×1201"), "{error}");
}

#[test]
fn a_large_map_is_reduced_or_cut_and_that_is_told() {
    let name = "special/planes.tif";
    let int16 = |column, row| value("int16", column, row);
    let small = open_with(name, &ImportOptions { limit: Some(9), band: Some(1), ..Default::default() });
    assert_eq!((small.width, small.height), (7, 6));
    assert!(small.warnings[0].contains("21×18") && small.warnings[0].contains("--window"), "{:?}", small.warnings);
    assert_heights(name, &small, 1e-3, |c, r| {
        let block = (0..9).map(|i| int16(3 * c + i % 3, 3 * r + i / 3));
        Some(block.sum::<f64>() / 9.0)
    });
    let place = small.georeference.clone().unwrap();
    assert_eq!(place.at(0.0, 0.0), [400_045.0, 3_999_955.0], "the middle of its block");
    assert_eq!(small.extent_metres(), Some([540.0, 450.0]));

    let part = ImportOptions { window: Some([5, 9, 7, 8]), limit: Some(10), band: Some(1), ..Default::default() };
    let part = open_with(name, &part);
    assert_heights(name, &part, 0.0, |c, r| Some(int16(c + 5, r + 9)));
    assert!(part.warnings.is_empty(), "{:?}", part.warnings);
    assert_eq!(part.georeference.unwrap().at(0.0, 0.0), [400_165.0, 3_999_715.0]);

    let refused = ImportOptions { limit: Some(10), refuse_larger: true, ..Default::default() };
    let error = load::load_with(&file(name), &refused, Listener::none()).unwrap_err();
    assert!(matches!(error, LoadError::Beyond { width: 21, height: 18, .. }), "{error}");
}

#[test]
fn reading_tells_how_far_it_is_and_can_be_ended() {
    use std::cell::Cell;
    use std::sync::atomic::{AtomicBool, Ordering};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.r32");
    std::fs::write(&path, vec![7u8; 4 << 20]).unwrap();
    let (last, cancel) = (Cell::new(0.0), AtomicBool::new(false));
    let hear = |share: f32| {
        assert!(share >= last.get(), "never back");
        last.set(share);
    };
    let options = ImportOptions::default();
    load::load_with(&path, &options, Listener { progress: &hear, cancel: &cancel }).unwrap();
    assert_eq!(last.get(), 1.0);
    let stop = |share: f32| {
        if share > 0.3 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let error = load::load_with(&path, &options, Listener { progress: &stop, cancel: &cancel }).unwrap_err();
    assert!(matches!(error, LoadError::Cancelled { .. }), "{error}");
}
