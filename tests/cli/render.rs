//! Pictures, distances and statistics.

use std::fs;

use image::{ImageBuffer, Luma};

use crate::bench::{Bench, json, keys};

#[test]
fn the_same_arguments_give_the_same_bytes() {
    let bench = Bench::new();
    bench.map("map.png", 48, 33);
    for name in ["a", "b"] {
        let line =
            format!("render map.png -o {name}.png --depth {name}.exr --size 96x60 --view graze --crater 0.5,0.4");
        bench.relief(&line).expect(0, &[]);
    }
    for ending in ["png", "exr"] {
        let read = |name: &str| fs::read(bench.path(&format!("{name}.{ending}"))).unwrap();
        assert!(read("a") == read("b"), "{ending} differs");
    }
    assert_eq!(image::open(bench.path("a.png")).unwrap().to_rgb8().dimensions(), (96, 60));
}

#[test]
fn the_distances_are_one_float_channel_with_sky_at_infinity() {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
    let bench = Bench::new();
    // Level and from outside: ground below the horizon, sky above it.
    bench.relief("render -o out.png --depth out.exr --size 60x40 --eye 0.5,0.3,2 --target 0.5,0.3,0").expect(0, &[]);
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(bench.path("out.exr"))
        .unwrap();
    assert_eq!((image.layer_data.size.x(), image.layer_data.size.y()), (60, 40));
    let channels = &image.layer_data.channel_data.list;
    assert_eq!(channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>(), ["Y"]);
    let FlatSamples::F32(distance) = &channels[0].sample_data else { unreachable!("not 32-bit float") };
    assert!(distance[..60].iter().all(|&sky| sky == f32::INFINITY), "the first row is the top, and sky");
    let ground: Vec<f32> = distance.iter().copied().filter(|distance| distance.is_finite()).collect();
    assert!(!ground.is_empty());
    // The near side of the box is at z = 1 or less, its far corner less than 2.2 away.
    assert!(ground.iter().all(|distance| (1.0..2.3).contains(distance)), "{ground:?}");
}

#[test]
fn the_statistics_have_their_keys() {
    let bench = Bench::new();
    bench.relief("render -o out.png --stats out.json --size 60x40 --frames 3").expect(0, &[]);
    let stats = json(&fs::read_to_string(bench.path("out.json")).unwrap());
    assert_eq!(keys(&stats), ["adapter", "cap_hits", "driver", "frame_ms", "ledger", "steps"]);
    assert_eq!(keys(&stats["frame_ms"]), ["median", "p95"]);
    assert_eq!(keys(&stats["steps"]), ["max", "mean"]);
    for key in ["passes", "pipelines", "draws", "textures", "texture_bytes", "shader_defs"] {
        assert!(!stats["ledger"][key].is_null(), "{key}");
    }
    assert!(stats["frame_ms"]["median"].as_f64().unwrap() <= stats["frame_ms"]["p95"].as_f64().unwrap());
    assert!(stats["steps"]["max"].as_f64().unwrap() >= stats["steps"]["mean"].as_f64().unwrap());
    assert!(stats["steps"]["mean"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_position_view_takes_no_steps() {
    let bench = Bench::new();
    let line = "render -o out.png --debug position --size 60x40 --stats out.json --depth out.exr";
    bench.relief(line).expect(0, &[]);
    let stats = json(&fs::read_to_string(bench.path("out.json")).unwrap());
    assert_eq!(stats["steps"], serde_json::json!({ "mean": 0.0, "max": 0 }));
    assert_eq!(stats["cap_hits"], 0);
    assert!(bench.path("out.exr").exists());
}

#[test]
fn a_flat_map_is_drawn_with_or_without_an_extent() {
    let bench = Bench::new();
    ImageBuffer::from_pixel(16, 16, Luma([700u16])).save(bench.path("flat.png")).unwrap();
    let ground = |options: &str| {
        bench
            .relief(&format!("render flat.png -o out.png --stats out.json --size 32x20 --view down {options}"))
            .expect(0, &[]);
        json(&fs::read_to_string(bench.path("out.json")).unwrap())["steps"]["mean"].as_f64().unwrap()
    };
    assert!(ground("") > 0.0 && ground("--height-scale 0") > 0.0);
    bench.write("flat.toml", "extent_metres = [1e3, 1e3]\nlowest_metre = 7\nhighest_metre = 7\n");
    for view in ["start", "over", "graze", "valley", "horizon"] {
        bench.relief(&format!("render flat.png -o out.png --size 32x20 --view {view}")).expect(0, &[]);
    }
    bench.relief("render flat.png -o sky.png --size 32x20 --eye 0.5,1,0.5 --target 0.5,2,0.5").expect(0, &[]);
    for technique in ["linear", "linear-binary", "secant", "cone", "relaxed-cone", "max-mipmap"] {
        assert!(ground(&format!("--technique {technique}")) > 0.0, "{technique}");
        let picture = |name: &str| image::open(bench.path(name)).unwrap().to_rgb8();
        assert!(picture("out.png") != picture("sky.png"), "{technique} shows the ground");
    }
}

#[test]
fn options_change_the_picture() {
    let bench = Bench::new();
    let picture = |name: &str, options: &str| {
        bench.relief(&format!("render -o {name}.png --size 80x50 {options}")).expect(0, &[]);
        image::open(bench.path(&format!("{name}.png"))).unwrap().to_rgb8()
    };
    let plain = picture("plain", "");
    assert!(picture("again", "--view start") == plain, "start is the default view");
    for (index, options) in [
        "--view down",
        "--fov 30",
        "--no-lighting",
        "--no-skybox",
        "--occluder",
        "--crater 0.5,0.5,0.2",
        "--debug steps",
    ]
    .iter()
    .enumerate()
    {
        assert!(picture(&format!("changed{index}"), options) != plain, "{options} changes nothing");
    }
}

#[test]
fn without_a_display_the_viewer_draws_its_start_view() {
    let bench = Bench::new();
    bench.relief("--size 64x40").expect(0, &["no display", "relief-view.png"]);
    assert_eq!(bench.names(), ["relief-view.png"]);
    bench.relief("render -o start.png --size 64x40").expect(0, &[]);
    let read = |name: &str| fs::read(bench.path(name)).unwrap();
    assert!(read("relief-view.png") == read("start.png"), "the same picture as `render` makes");
    bench.relief("view --size 64x40 -o other.png").expect(0, &["other.png"]);
    assert!(bench.path("other.png").exists());
}

/// A legend in its corner and nothing else; none without the switch, and none where nothing has one.
#[test]
fn a_legend_stands_in_the_corner_of_a_saved_picture() {
    let bench = Bench::new();
    let line = "--ramp batlow --contours --size 400x300 --no-skybox";
    let colours = |name: &str| image::open(bench.path(name)).unwrap().to_rgb8();
    bench.relief(&format!("render -o plain.png {line}")).expect(0, &[]);
    bench.relief(&format!("render -o legend.png {line} --legend")).expect(0, &[]);
    let (plain, legend) = (colours("plain.png"), colours("legend.png"));
    let changed: Vec<_> = legend.enumerate_pixels().filter(|(x, y, pixel)| plain.get_pixel(*x, *y) != *pixel).collect();
    assert!(changed.len() > 8000, "a box of that many pixels: {}", changed.len());
    assert!(changed.iter().all(|(_, y, _)| *y > 190), "it is low");
    // The bar has the ramp's own colours, from its first to its last.
    for end in [relief::scene::Ramp::Batlow.colour(0.0), relief::scene::Ramp::Batlow.colour(1.0)] {
        let near = |pixel: &image::Rgb<u8>| pixel.0.iter().zip(end).all(|(a, b)| a.abs_diff(b) < 6);
        assert!(changed.iter().filter(|(_, _, pixel)| near(pixel)).count() >= 8, "{end:?} is not there");
    }
    // A scene that asks for it gets it as well, and the heat map has one of its own.
    bench.write("scene.toml", "[saved]\nlegend = true\n");
    bench.relief(&format!("render -o scene.png {line} --scene scene.toml")).expect(0, &[]);
    assert!(colours("scene.png") == legend, "by the scene or by the switch");
    bench.relief("render -o steps.png --size 400x300 --debug steps --scene scene.toml").expect(0, &[]);
    bench.relief("render -o bare.png --size 400x300 --debug steps").expect(0, &[]);
    let differ = colours("steps.png").pixels().zip(colours("bare.png").pixels()).filter(|(a, b)| a != b).count();
    assert!(differ > 5000, "{differ}");
    bench.relief("render -o none.png --size 64x48 --legend").expect(0, &["no legend"]);
}
