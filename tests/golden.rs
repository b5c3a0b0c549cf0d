//! A golden picture for every technique, toggle and debug view: 320×240 of the Grand Canyon, in `tests/golden`.
//!
//! `RELIEF_UPDATE_GOLDEN=1 cargo test --test golden` renews them. A failure leaves `NAME.actual.png` and
//! `NAME.diff.png` beside the golden picture.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::path::{Path, PathBuf};

use common::pictures::{Difference, Tolerance, compare_with_golden};
use common::{canyon, crater_on_the_summit, picture, renderer, scene_at, scene_from, scratch_file};
use glam::DVec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ImageEncoder, Rgb, RgbImage, Rgba, RgbaImage};
use relief::camera::{Camera, NamedView};
use relief::heightfield::{Crater, HeightField};
use relief::scene::light::{Shadows, SkyModel};
use relief::scene::{
    CloudSource, ColourSource, CraterMode, DebugView, GroundColour, HeightFilter, Hillshade, Ramp, Scene, Technique,
};

/// Another version of the driver may round another way; more than this is another picture.
const TOLERANCE: Tolerance = Tolerance { channel: 8, pixels: 0.002 };

/// Makes the goldens instead of comparing with them.
const UPDATE_VARIABLE: &str = "RELIEF_UPDATE_GOLDEN";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// A picture of a test, and the golden it must equal.
struct Case {
    golden: &'static str,
    scene: Scene,
}

fn case(golden: &'static str, base: &Scene, change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = base.clone();
    change(&mut scene);
    Case { golden, scene }
}

/// A 64×64 picture: a checker of 8 squares in two colours, with a mark in its upper left corner.
fn checker(light: [u8; 3], dark: [u8; 3]) -> RgbImage {
    RgbImage::from_fn(64, 64, |x, y| match (x / 8, y / 8) {
        (0, 0) => Rgb([255, 255, 255]),
        (column, row) => Rgb(if (column + row) % 2 == 0 { light } else { dark }),
    })
}

/// Six faces with a colour each.
fn sky_faces() -> [PathBuf; 6] {
    let colours = [[220, 60, 50], [60, 200, 210], [90, 140, 240], [120, 90, 50], [70, 190, 80], [200, 70, 190]];
    std::array::from_fn(|index| {
        let path = scratch_file(&format!("golden-sky-{index}.png"));
        checker(colours[index], colours[index].map(|channel| channel / 2)).save(&path).unwrap();
        path
    })
}

/// A sun that hills can hide, and shadows that show.
fn low_sun(scene: &mut Scene, shadows: Shadows) {
    (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (250.0, 7.0);
    (scene.lighting.ambient, scene.lighting.diffuse) = (0.18, 1.6);
    scene.lighting.shadows = shadows;
}

/// From so near to the ground that a cell is many pixels wide.
fn near(map: &HeightField) -> Scene {
    let extent = map.box_size(None);
    let eye = DVec3::new(0.42, (map.surface_height(0.42, 0.57) + 0.08) * extent.y, 0.57 * extent.z);
    Scene { camera: Some(Camera { eye, yaw: 35.0, pitch: -20.0, fov: 60.0 }), ..Scene::default() }
}

fn march_cases(map: &HeightField, start: &Scene) -> Vec<Case> {
    let (graze, over) = (scene_at(NamedView::Graze, map), scene_at(NamedView::Over, map));
    let valley = scene_at(NamedView::Valley, map);
    let mut summit = graze.clone();
    summit.march.technique = Technique::Linear;
    summit.march.samples_max = 48;
    summit.march.steps_by_angle = false;
    let mut cut = summit.clone();
    cut.craters.list = vec![crater_on_the_summit(map)];
    let few = |scene: &mut Scene, technique, halvings| {
        scene.march.technique = technique;
        (scene.march.samples_min, scene.march.samples_max) = (4, 12);
        scene.march.binary_steps = halvings;
    };
    vec![
        case("max-mipmap", start, |_| {}),
        case("max-mipmap-graze", &graze, |_| {}),
        case("linear-binary", start, |scene| scene.march.technique = Technique::LinearBinary),
        case("linear-few-samples", &over, |scene| few(scene, Technique::Linear, 8)),
        case("linear-binary-few-samples", &over, |scene| few(scene, Technique::LinearBinary, 8)),
        // Without halvings it is `linear`.
        case("linear-few-samples", &over, |scene| few(scene, Technique::LinearBinary, 0)),
        case("secant-few-samples", &over, |scene| few(scene, Technique::Secant, 8)),
        // Few enough to show how they err: rims of the canyon fray.
        case("cone-few-samples", &graze, |scene| few(scene, Technique::Cone, 8)),
        case("relaxed-cone-few-samples", &graze, |scene| few(scene, Technique::RelaxedCone, 4)),
        case("linear-fixed-steps", &over, |scene| {
            few(scene, Technique::Linear, 0);
            scene.march.steps_by_angle = false;
        }),
        case("filter-hardware-linear", &valley, |scene| {
            scene.march.technique = Technique::LinearBinary;
            scene.march.filter = HeightFilter::HardwareLinear;
        }),
        case("filter-nearest", &valley, |scene| {
            scene.march.technique = Technique::LinearBinary;
            scene.march.filter = HeightFilter::Nearest;
        }),
        case("summit-cut-lower-start", &cut, |_| {}),
        case("summit-cut-full-box", &cut, |scene| scene.march.lower_start = false),
        case("compare", &graze, |scene| {
            few(scene, Technique::MaxMipmap, 8);
            scene.compare.enabled = true;
            scene.compare.technique = Technique::Linear;
            scene.compare.share = 0.4;
        }),
        case("debug-error", &graze, |scene| {
            few(scene, Technique::LinearBinary, 8);
            scene.march.samples_max = 64;
            scene.debug.view = DebugView::Error;
        }),
        case("smooth", &valley, |scene| scene.march.technique = Technique::Smooth),
        case("fractal", &near(map), |scene| scene.march.technique = Technique::Fractal),
        case("misses-kept", start, |scene| scene.march.discard_misses = false),
        case("height-scale", start, |scene| scene.terrain.height_scale = Some(0.25)),
    ]
}

fn colour_cases(map: &HeightField, start: &Scene) -> Vec<Case> {
    let texture = scratch_file("golden-checker.png");
    checker([230, 190, 60], [40, 70, 140]).save(&texture).unwrap();
    vec![
        case("diffuse-off", start, |scene| scene.diffuse.enabled = false),
        case("diffuse-image", start, |scene| scene.diffuse.file = Some(texture.clone())),
        case("diffuse-repeats", start, |scene| {
            scene.diffuse.file = Some(texture.clone());
            scene.diffuse.repeats = 4.0;
        }),
        case("lighting-off", start, |scene| scene.lighting.enabled = false),
        case("sun-low-in-the-east", start, |scene| {
            scene.lighting.sun_azimuth = 90.0;
            scene.lighting.sun_elevation = 12.0;
        }),
        case("specular-only", start, |scene| {
            (scene.lighting.ambient, scene.lighting.diffuse, scene.lighting.specular) = (0.0, 0.0, 1.0);
            scene.lighting.sun_azimuth = 0.0;
        }),
        case("shadows-hard", start, |scene| low_sun(scene, Shadows::Hard)),
        case("shadows-soft", start, |scene| low_sun(scene, Shadows::Soft)),
        case("shadows-baked", start, |scene| {
            low_sun(scene, Shadows::Soft);
            scene.lighting.baked = true;
        }),
        case("ambient-occlusion", start, |scene| scene.lighting.occlusion = true),
        case("sky-physical", start, |scene| scene.skybox.model = SkyModel::Physical),
        case("sky-physical-evening", start, |scene| {
            low_sun(scene, Shadows::Soft);
            (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (350.0, 4.0);
            scene.skybox.model = SkyModel::Physical;
        }),
        case("materials", start, |scene| {
            scene.diffuse.source = ColourSource::Materials;
            scene.materials.aridity = 0.8;
        }),
        case("materials-lush-and-cold", start, |scene| {
            scene.diffuse.source = ColourSource::Materials;
            (scene.terrain.height_scale, scene.materials.aridity) = (Some(0.15), 0.1499);
        }),
        case("materials-chosen-by-the-map", start, |scene| {
            scene.diffuse.source = ColourSource::Materials;
            scene.terrain.height_scale = Some(0.15);
        }),
        case("materials-cliff", &scene_at(NamedView::Valley, map), |scene| {
            scene.diffuse.source = ColourSource::Materials;
            scene.materials.aridity = 0.8;
        }),
        case("skybox-off", start, |scene| scene.skybox.enabled = false),
        case("skybox-images", start, |scene| scene.skybox.faces = Some(sky_faces())),
        case("skybox-not-flattened", start, |scene| scene.skybox.flattening = 1.0),
    ]
}

/// Fog, clouds, their shadows, and a flare.
fn air_cases(map: &HeightField, start: &Scene) -> Vec<Case> {
    // Below the lowest clouds, where the ground shows their shadows.
    let below = |target| scene_from(map, [0.5, 1.25, 1.0], target, 75.0);
    let cloudy = |scene: &mut Scene| (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
    let sky = |yaw: f64, pitch: f64| {
        move |scene: &mut Scene| {
            let camera = scene.camera.as_mut().unwrap();
            (camera.yaw, camera.pitch) = (yaw, pitch);
        }
    };
    vec![
        case("air-perspective", start, |scene| {
            (scene.air.perspective, scene.air.visibility) = (true, 40.0);
            scene.skybox.model = SkyModel::Physical;
        }),
        case("air-fog", start, |scene| {
            scene.air.fog = true;
            (scene.air.fog_density, scene.air.fog_base, scene.air.fog_scale) = (1.5, 900.0, 150.0);
            scene.occluder.enabled = true;
        }),
        case("clouds", &below([0.45, 1.2, 0.2]), cloudy),
        case("clouds-from-above", start, |scene| {
            cloudy(scene);
            (scene.clouds.cover, scene.air.perspective) = (0.4, true);
        }),
        case("clouds-of-the-map", &below([0.9, 1.5, 0.5]), |scene| {
            cloudy(scene);
            (scene.clouds.source, scene.skybox.model) = (CloudSource::Map, SkyModel::Physical);
        }),
        case("flare", start, |scene| {
            scene.flare.enabled = true;
            (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (350.0, 9.0);
            sky(0.0, -6.0)(scene);
        }),
    ]
}

fn land_cases(map: &HeightField, start: &Scene) -> Vec<Case> {
    let (valley, down) = (scene_at(NamedView::Valley, map), scene_at(NamedView::Down, map));
    let ramp = |ramp| move |scene: &mut Scene| (scene.land.colour, scene.land.ramp) = (GroundColour::Ramp, ramp);
    let coloured = |colour| {
        move |scene: &mut Scene| {
            scene.land.colour = colour;
            scene.lighting.enabled = false;
        }
    };
    vec![
        case("land-ramp", start, ramp(Ramp::Oleron)),
        case("land-ramp-2003", start, |scene| {
            ramp(Ramp::Riaboy2003)(scene);
            (scene.land.low, scene.land.high) = (Some(0.0), Some(2347.0));
        }),
        case("land-ramp-range", &down, |scene| {
            ramp(Ramp::Viridis)(scene);
            (scene.land.low, scene.land.high) = (Some(700.0), Some(1600.0));
        }),
        case("land-slope", &down, coloured(GroundColour::Slope)),
        case("land-aspect", &down, coloured(GroundColour::Aspect)),
        case("land-contours", start, |scene| scene.land.contours = true),
        case("land-contours-near", &valley, |scene| {
            (scene.land.contours, scene.land.contour_interval) = (true, Some(20.0));
            scene.diffuse.enabled = false;
        }),
        case("land-hillshade", start, |scene| scene.land.hillshade = Hillshade::Sun),
        case("land-hillshade-multidirectional", start, |scene| {
            ramp(Ramp::Batlow)(scene);
            scene.land.hillshade = Hillshade::Multidirectional;
            (scene.land.hillshade_strength, scene.land.contours) = (1.0, true);
        }),
    ]
}

fn thing_cases(map: &HeightField, start: &Scene) -> Vec<Case> {
    let mut cratered = start.clone();
    let mut crater = |u: f64, v: f64, radius| {
        let extent = map.box_size(None);
        let crater = Crater { x: u * extent.x, z: v * extent.z, radius, depth: 0.5, rim: 0.15 };
        cratered.craters.list.push(crater);
    };
    crater(0.4, 0.6, 0.12);
    crater(0.55, 0.65, 0.08);
    crater(0.75, 0.3, 0.1);
    crater(0.2, 1.0, 0.06);
    let debug = |view| move |scene: &mut Scene| scene.debug.view = view;
    vec![
        case("craters-baked", &cratered, |_| {}),
        case("craters-layered", &cratered, |scene| {
            scene.craters.mode = CraterMode::Layered;
            scene.craters.layer_resolution = 48;
        }),
        case("occluder", start, |scene| {
            scene.occluder.enabled = true;
            scene.occluder.size = 0.2;
        }),
        case("occluder-shadow", start, |scene| {
            scene.occluder.enabled = true;
            scene.occluder.size = 0.12;
            scene.occluder.position = Some(DVec3::new(0.5, 0.16, 0.6));
            scene.lighting.shadows = Shadows::Soft;
        }),
        case("wireframe", &scene_at(NamedView::Over, map), |scene| scene.debug.wireframe = true),
        case("debug-position", start, debug(DebugView::Position)),
        case("debug-steps", start, debug(DebugView::Steps)),
        case("debug-normals", start, debug(DebugView::Normals)),
        case("debug-distance", start, debug(DebugView::Distance)),
        case("from-inside-the-box", &scene_at(NamedView::Valley, map), |_| {}),
        case("from-below", &scene_from(map, [0.3, -4.0, 1.6], [0.5, 0.5, 0.5], 50.0), |_| {}),
    ]
}

fn water_cases(map: &HeightField, start: &Scene) -> Vec<Case> {
    let shore = scene_from(map, [0.29, 0.68, 0.53], [0.25, 0.34, 0.43], 45.0);
    let under = scene_from(map, [0.27, 0.30, 0.45], [0.22, 0.36, 0.36], 70.0);
    let sea = |scene: &mut Scene| {
        scene.water.enabled = true;
        scene.water.level = Some(0.45);
    };
    vec![
        case("water", start, sea),
        case("water-shore", &shore, |scene| {
            sea(scene);
            (scene.water.foam, scene.water.wave_length) = (0.8, 0.006);
        }),
        case("water-mirror", &shore, |scene| {
            sea(scene);
            (scene.water.foam, scene.water.waves) = (0.0, 0.0);
            scene.occluder.enabled = true;
            scene.occluder.size = 0.02;
            scene.occluder.position = Some(DVec3::new(0.266, 0.036, 0.468));
        }),
        case("water-under", &under, sea),
    ]
}

fn cases(map: &HeightField) -> Vec<Case> {
    let start = scene_at(NamedView::Start, map);
    march_cases(map, &start)
        .into_iter()
        .chain(colour_cases(map, &start))
        .chain(thing_cases(map, &start))
        .chain(land_cases(map, &start))
        .chain(water_cases(map, &start))
        .chain(air_cases(map, &start))
        .collect()
}

/// As small as PNG gets: opaque, so without alpha.
fn write_golden(path: &Path, picture: &RgbaImage) {
    let rgb = image::DynamicImage::ImageRgba8(picture.clone()).to_rgb8();
    let file = std::fs::File::create(path).unwrap();
    PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::Adaptive)
        .write_image(rgb.as_raw(), rgb.width(), rgb.height(), image::ExtendedColorType::Rgb8)
        .unwrap();
}

#[test]
fn every_picture_is_its_golden_one() {
    let map = canyon();
    let cases = cases(&map);
    let update = std::env::var_os(UPDATE_VARIABLE).is_some();
    let mut renderer = renderer(&map);
    let mut failures = Vec::new();
    let mut written = Vec::new();
    for Case { golden, scene } in &cases {
        let actual = picture(&mut renderer, scene);
        if update && !written.contains(golden) {
            write_golden(&folder().join(format!("{golden}.png")), &actual);
            written.push(*golden);
        }
        match compare_with_golden(&folder(), golden, &actual, TOLERANCE) {
            Ok(difference) => println!("{golden:28} {} pixels differ", difference.pixels),
            Err(reason) => failures.push(format!("{golden}: {reason}")),
        }
    }
    assert!(
        failures.is_empty(),
        "{} of {} pictures differ; look at NAME.actual.png and NAME.diff.png in tests/golden, and if they are right, \
         renew the goldens with {UPDATE_VARIABLE}=1 cargo test --test golden\n{}",
        failures.len(),
        cases.len(),
        failures.join("\n")
    );
}

/// A golden picture that no test draws any more proves nothing.
#[test]
fn every_golden_is_drawn() {
    let map = canyon();
    let cases = cases(&map);
    for entry in std::fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(stem) = name.strip_suffix(".png") else { continue };
        let left_by_a_failure = stem.ends_with(".actual") || stem.ends_with(".diff");
        assert!(left_by_a_failure || cases.iter().any(|case| case.golden == stem), "nothing draws {name}");
    }
}

/// The comparison itself must be able to fail.
#[test]
fn a_difference_is_found_and_shown() {
    let folder = scratch_file("golden-comparison");
    std::fs::create_dir_all(&folder).unwrap();
    let golden = RgbaImage::from_pixel(10, 10, Rgba([100, 100, 100, 255]));
    golden.save(folder.join("grey.png")).unwrap();
    let tolerance = Tolerance { channel: 4, pixels: 0.02 };
    let mut actual = golden.clone();
    let change = |picture: &mut RgbaImage, index: u32, by: u8| {
        picture.put_pixel(index % 10, index / 10, Rgba([100, 100 + by, 100, 255]));
    };
    let left = |suffix: &str| folder.join(format!("grey.{suffix}.png")).exists();

    (0..100).for_each(|index| change(&mut actual, index, 4));
    assert!(compare_with_golden(&folder, "grey", &actual, tolerance).is_ok(), "all within the channel's tolerance");
    (0..2).for_each(|index| change(&mut actual, index, 90));
    assert!(compare_with_golden(&folder, "grey", &actual, tolerance).is_ok(), "two of a hundred may differ");
    change(&mut actual, 2, 5);
    let message = compare_with_golden(&folder, "grey", &actual, tolerance).unwrap_err();
    assert!(message.starts_with("3 of 100 pixels"), "{message}");
    assert!(left("actual") && left("diff"));
    compare_with_golden(&folder, "grey", &golden, tolerance).unwrap();
    assert!(!left("actual") && !left("diff"), "what a failure left goes when the pictures agree");

    assert!(compare_with_golden(&folder, "missing", &actual, tolerance).is_err(), "a golden that is missing");
    assert!(Difference::of(&golden, &RgbaImage::new(10, 11), tolerance).is_err(), "another size");
    assert!(Difference::of(&RgbaImage::new(0, 0), &RgbaImage::new(0, 0), tolerance).is_err(), "nothing compared");
}
