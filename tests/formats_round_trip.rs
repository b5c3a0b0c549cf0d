//! What is written opens again as it was: samples, holes, and place.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use relief::heightfield::export::{self, ExportFormat};
use relief::heightfield::import::{Elevation, ImportOptions, Listener, PixelIs, Samples, VerticalUnit};
use relief::heightfield::{Crater, EditedTerrain, Sidecar, load};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats").join(name)
}

fn decode(path: &Path) -> (Elevation, Option<Sidecar>) {
    let decoded = load::decode(path, &ImportOptions::default(), Listener::none());
    let (elevation, sidecar, warnings) = decoded.unwrap_or_else(|error| panic!("{error}"));
    assert!(warnings.iter().all(|warning| !warning.contains("ignored")), "{warnings:?}");
    (elevation, sidecar)
}

/// Writes and opens again.
fn again(folder: &Path, elevation: &Elevation, sidecar: Option<&Sidecar>, ending: &str) -> (Elevation, f64) {
    let path = folder.join(format!("out.{ending}"));
    let written = export::write(elevation, sidecar, ExportFormat::of(&path).unwrap(), &path).unwrap();
    (decode(&path).0, written.rounded_by)
}

fn assert_same(what: &str, a: &Elevation, b: &Elevation, tolerance: f64) {
    assert_eq!((a.width, a.height), (b.width, b.height), "{what}");
    let metres = |elevation: &Elevation| elevation.vertical_unit.map_or(1.0, VerticalUnit::metres);
    for (column, row) in (0..a.height).flat_map(|row| (0..a.width).map(move |column| (column, row))) {
        match (a.height_at(column, row), b.height_at(column, row)) {
            (Some(x), Some(y)) => {
                let off = (x * metres(a) - y * metres(b)).abs();
                assert!(off <= tolerance * metres(a), "{what}, column {column}, row {row}: {x} became {y}");
            }
            (None, None) => {}
            other => panic!("{what}, column {column}, row {row}: {other:?}"),
        }
    }
    let (Some(x), Some(y)) = (&a.georeference, &b.georeference) else {
        // ESRI's headers cannot leave the place out.
        if what.ends_with("asc") || what.ends_with("flt") {
            return;
        }
        assert_eq!(a.georeference, b.georeference, "{what}");
        return;
    };
    assert_eq!((&x.crs, x.epsg, x.unit, x.pixel), (&y.crs, y.epsg, y.unit, y.pixel), "{what}");
    let size = [a.width, a.height];
    let corners = x.bounds(size).into_iter().zip(y.bounds(size));
    assert!(corners.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) < 1e-6, "{what}: {x:?} became {y:?}");
}

#[test]
fn every_format_keeps_samples_holes_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let sources = [
        "special/nodata.tif",
        "special/nan.tif",
        "special/degrees.tif",
        "special/mercator.tif",
        "special/feet.tif",
        "special/point.tif",
        "special/scaled.tif",
        "other/classic.nc",
        "other/profile.dem",
        "other/terrain.ter",
        "other/grid.asc",
        "other/grey16.png",
        "other/square.r32",
    ];
    for (source, ending) in
        sources.into_iter().flat_map(|source| ["tif", "png", "asc", "flt", "r16", "r32"].map(|e| (source, e)))
    {
        let (elevation, sidecar) = decode(&file(source));
        let (copy, rounded_by) = again(folder.path(), &elevation, sidecar.as_ref(), ending);
        // 32-bit floats hold whole numbers and halves of this size exactly; what Terragen steps by is neither.
        let finest = if source.ends_with(".ter") { 1e-3 } else { 1e-9 };
        assert_same(&format!("{source} as {ending}"), &elevation, &copy, (rounded_by * 1.01).max(finest));
        std::fs::remove_file(folder.path().join("out.toml")).ok();
    }
}

#[test]
fn a_geotiff_keeps_the_type_of_its_samples() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"] {
        let (elevation, _) = decode(&file(&format!("tiff/{kind}-lzw-p1-tiles.tif")));
        let (copy, _) = again(folder.path(), &elevation, None, "tif");
        assert_eq!(copy.samples, elevation.samples, "{kind}");
    }
    // With a hole, and every number taken: a larger type has others.
    let (elevation, _) = decode(&file("tiff/uint8-none-p1-strips.tif"));
    let mut full =
        Elevation { width: 16, height: 17, samples: Samples::U8((0..=255).chain(0..16).collect()), ..elevation };
    let mut holes = relief::heightfield::HoleMask::new(16, 17);
    holes.insert(260);
    full.holes = Some(holes);
    full.taken.full = [16, 17];
    full.taken.window = [0, 0, 16, 17];
    let (copy, _) = again(folder.path(), &full, None, "tif");
    assert_eq!(copy.sample_type, "f64");
    assert_same("every number", &full, &copy, 0.0);
}

#[test]
fn an_edited_map_keeps_its_craters_its_holes_and_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = load::load(&file("special/nan.tif")).unwrap();
    let mut edited = EditedTerrain::new(Arc::new(loaded.field));
    edited.set_craters(&[Crater { x: 0.3, z: 0.6, radius: 0.2, depth: 0.3, rim: 0.1 }]);
    let elevation = Elevation::of_field(edited.field(), loaded.georeference.clone());
    for ending in ["tif", "png", "r32"] {
        let path = folder.path().join(format!("edited.{ending}"));
        export::write(&elevation, loaded.sidecar.as_ref(), ExportFormat::of(&path).unwrap(), &path).unwrap();
        let copy = load::load(&path).unwrap();
        assert_eq!(copy.field.holes(), edited.field().holes(), "{ending}");
        assert_eq!(copy.georeference, loaded.georeference, "{ending}");
        assert_eq!(copy.field.extent_metres(), edited.field().extent_metres(), "{ending}");
        let scale = |range: [f64; 2], sample: f32| range[0] + f64::from(sample) * (range[1] - range[0]);
        let holes = edited.field().holes().unwrap();
        let both = copy.field.samples().iter().zip(edited.field().samples()).enumerate();
        for (_, (a, b)) in both.filter(|(index, _)| !holes.contains(*index)) {
            let off = (scale(copy.field.range(), *a) - scale(edited.field().range(), *b)).abs();
            assert!(off < 0.02, "{ending}: {off} m");
        }
        std::fs::remove_file(folder.path().join("edited.toml")).ok();
    }
}

#[test]
fn a_point_stays_a_point() {
    let (point, _) = decode(&file("special/point.tif"));
    assert_eq!(point.georeference.unwrap().pixel, PixelIs::Point);
}
