//! Reading the land in the window: the probe, the way between two clicks, exaggerated heights, the legend's settings.

use glam::DVec2;
use relief::heightfield::reference::Surface;
use relief::heightfield::survey::Survey;
use serde_json::Value;

use crate::harness::{Window, camera, canyon, differing, has, list, number, told, widget};

/// Shares of the canyon under a pixel, by the f64 reference.
fn shares(status: &Value, pixel: DVec2) -> [f64; 2] {
    let map = canyon();
    let size = map.box_size(status["scene"]["terrain"]["height_scale"].as_f64());
    let window = [0, 1].map(|side| number(&status["size"][side]) as u32);
    let ray = camera(status).ray(pixel.x, pixel.y, window);
    let hit = Surface::new(&map, size).intersect(&ray).expect("ground at the pixel");
    [hit.position.x / size.x, hit.position.z / size.z]
}

#[test]
fn the_cursor_reads_heights_and_two_clicks_measure_the_way() {
    let mut window = Window::open("--size 800x560 --eye 0.5,0.35,0.9 --target 0.45,0,0.3");
    let map = canyon();
    let survey = Survey::new(&map, 1.0);
    window.settled("rest", |_| true);
    let (one, other) = (DVec2::new(520.0, 330.0), DVec2::new(640.0, 380.0));

    window.point(one.x, one.y);
    window.key("p");
    let probed = window.settled("a height", |status| status["reading"]["height"].is_number());
    let [u, v] = shares(&probed, one);
    let expected = survey.place(u, v);
    assert!((number(&probed["reading"]["height"]) - expected.height).abs() < 0.01, "{expected:?}");
    assert!((number(&probed["reading"]["slope"]) - expected.slope).abs() < 0.01, "{expected:?}");
    let scenes = probed["scene_frames"].clone();
    window.point(other.x, other.y);
    let moved = window.settled("another height", |status| status["reading"]["height"] != probed["reading"]["height"]);
    assert_eq!(moved["scene_frames"], scenes, "the terrain is not drawn anew for it");
    window.key("p");
    window.settled("no probe", |status| status["reading"]["height"].is_null());

    window.key("m");
    window.settled("measuring", |status| status["reading"]["measuring"] == true);
    for (ends, pixel) in [(1, one), (2, other)] {
        window.point(pixel.x, pixel.y);
        window.xdo("click 1");
        window.settled("an end", |status| status["reading"]["ends"] == ends);
    }
    let measured = window.settled("a way", |status| status["reading"]["lengths"].is_array());
    let way = survey.profile(shares(&measured, one), shares(&measured, other));
    let lengths = &measured["reading"]["lengths"];
    assert!((number(&lengths[0]) - way.level).abs() < 0.1, "{lengths}, not {}", way.level);
    assert!((number(&lengths[1]) - way.along_ground).abs() < 0.1, "{lengths}, not {}", way.along_ground);
    assert!((number(&measured["reading"]["rise"]) - way.rise).abs() < 0.1);
    window.click("Export profile");
    window.settled("a file", |status| told(status, "relief-profile-0001.csv"));
    window.key("Escape");
    let ended = window.settled("an end", |status| status["reading"]["measuring"] == false);
    assert!(ended["reading"]["lengths"].is_null() && widget(&ended, "End measuring").is_none());
    // A way over a crater is measured anew once the crater is taken back.
    window.point(one.x, one.y);
    window.key("c");
    window.settled("a crater", |status| !list(&status["scene"]["craters"]["list"]).is_empty());
    window.key("m");
    for (ends, pixel) in [(1, one), (2, other)] {
        window.point(pixel.x, pixel.y);
        window.xdo("click 1");
        window.settled("an end", |status| status["reading"]["ends"] == ends);
    }
    let over = window.settled("a way", |status| status["reading"]["lengths"].is_array());
    window.key("ctrl+z");
    window.settled("another way", |status| status["reading"]["lengths"][1] != over["reading"]["lengths"][1]);
    window.key("Escape");
    exaggerated(&mut window);
    window.close();
}

/// `[` and `]`, and the panel's own number; the eye stays as high above the ground.
fn exaggerated(window: &mut Window) {
    let map = canyon();
    let above = |status: &Value| {
        let scale = status["scene"]["terrain"]["height_scale"].as_f64();
        let (size, eye) = (map.box_size(scale), camera(status).eye);
        let inside = eye.x > 0.0 && eye.z > 0.0 && eye.x < size.x && eye.z < size.z;
        eye.y - if inside { map.surface_height(eye.x / size.x, eye.z / size.z) * size.y } else { 0.0 }
    };
    let before = window.settled("rest", |status| status["reading"]["exaggeration"] == 1.0);
    for (key, times) in [("bracketright", 1.5), ("bracketright", 2.0), ("bracketleft", 1.5)] {
        window.key(key);
        let after = window
            .settled("another height", |status| (number(&status["reading"]["exaggeration"]) - times).abs() < 1e-9);
        assert!((above(&after) - above(&before)).abs() < 1e-6, "{} is not {}", above(&after), above(&before));
    }
    window.fill_number("Vertical exaggeration value", "20");
    let high = window.settled("20 times", |status| (number(&status["reading"]["exaggeration"]) - 20.0).abs() < 1e-6);
    assert!((above(&high) - above(&before)).abs() < 1e-6);
    window.click("True proportion");
    window.settled("once", |status| number(&status["reading"]["exaggeration"]) == 1.0);
    window.section("Terrain", false);
    window.section("March", false);
    window.section("Land", true);
    window.click("Ground colour");
    window.settled("an open list", |status| widget(status, "ramp").is_some());
    window.click("ramp");
    let ramp = window.settled("a ramp", |status| has(&status["ledger"]["shader_defs"], "LAND_RAMP"));
    assert!(!list(&ramp["ledger"]["textures"]).iter().any(|texture| texture["name"] == "diffuse"));
    let (_, plain) = window.shot();
    window.section("Land", false);
    window.section("Frame", true);
    window.click("Legend in pictures");
    window.settled("legends", |status| status["scene"]["saved"]["legend"] == true);
    let (path, legend) = window.shot();
    let size = plain.dimensions();
    let corner = |picture: &image::RgbaImage| image::imageops::crop_imm(picture, 0, size.1 - 100, 400, 100).to_image();
    let changed = differing(&plain, &legend, 0);
    assert!(changed > 5000, "{changed}");
    assert_eq!(changed, differing(&corner(&plain), &corner(&legend), 0), "all of it in the corner");
    let scene = relief::scene_file::read(&path.with_extension("toml")).unwrap();
    assert!(scene.saved.legend, "its scene makes it again");
}
