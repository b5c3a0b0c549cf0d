//! C makes craters where the cursor points, and they can be taken back.

use glam::{DVec2, DVec3};
use image::RgbaImage;
use relief::camera::Camera;
use relief::heightfield::reference::Surface;
use serde_json::Value;

use crate::harness::{Window, camera, canyon, differing, has, list, number};

const SIZE: [u32; 2] = [800, 560];

fn craters(status: &Value) -> &[Value] {
    list(&status["scene"]["craters"]["list"])
}

/// Fails unless the newest crater lies where the f64 reference meets the ground through the pixel.
#[track_caller]
pub(crate) fn assert_under(status: &Value, pixel: DVec2) {
    let (map, camera) = (canyon(), camera(status));
    let size = map.box_size(None);
    let window = [0, 1].map(|side| number(&status["size"][side]) as u32);
    let hit = Surface::new(&map, size).intersect(&camera.ray(pixel.x, pixel.y, window)).expect("ground at the pixel");
    let crater = craters(status).last().expect("a crater");
    let place = DVec3::new(number(&crater["x"]), hit.position.y, number(&crater["z"]));
    let seen = project(&camera, place, window);
    assert!((seen - pixel).length() < 1.0, "the crater is at {seen} in the picture, the cursor at {pixel}");
}

/// Where a place is in the picture of a window.
fn project(camera: &Camera, place: DVec3, window: [u32; 2]) -> DVec2 {
    let clip = camera.clip_from_world(window) * place.extend(1.0);
    let [width, height] = window.map(f64::from);
    DVec2::new((clip.x / clip.w + 1.0) * 0.5 * width, (1.0 - clip.y / clip.w) * 0.5 * height)
}

/// Fails unless the pictures differ around the pixel, and only in a part of the picture.
#[track_caller]
fn assert_changed_near(before: &RgbaImage, after: &RgbaImage, pixel: DVec2) {
    let corner = (pixel - DVec2::splat(20.0)).as_uvec2();
    let part = |picture: &RgbaImage| image::imageops::crop_imm(picture, corner.x, corner.y, 40, 40).to_image();
    let near = differing(&part(before), &part(after), 8);
    assert!(near > 300, "{near} of 1600 pixels around the cursor changed");
    let everywhere = differing(before, after, 0);
    assert!(everywhere < before.pixels().len() / 2, "{everywhere} pixels changed");
}

#[test]
fn c_digs_where_the_cursor_points_and_undo_restores_every_byte() {
    let mut window = Window::open(&format!("--size {}x{} --view over", SIZE[0], SIZE[1]));
    let pixel = DVec2::new(560.0, 330.0);
    window.point(pixel.x, pixel.y);
    let (first, before) = window.shot();
    window.key("c");
    let one = window.settled("a crater", |status| craters(status).len() == 1);
    assert_under(&one, pixel);
    assert!(number(&one["ledger"]["uploaded_bytes"]) > 0.0, "heights changed");
    let (_, dug) = window.shot();
    assert_changed_near(&before, &dug, pixel);

    window.key("ctrl+z");
    window.settled("no crater", |status| craters(status).is_empty());
    let (again, _) = window.shot();
    assert_eq!(std::fs::read(first).unwrap(), std::fs::read(again).unwrap(), "undone to the byte");

    nothing_is_dug_without_ground(&mut window);
    window.point(pixel.x, pixel.y);
    // With the mouse captured, the middle of the window counts.
    window.key("f");
    window.settled("a captured mouse", |status| status["mouse_captured"] == true);
    window.key("c");
    let centred = window.settled("a crater", |status| craters(status).len() == 1);
    assert_under(&centred, DVec2::new(f64::from(SIZE[0]) * 0.5, f64::from(SIZE[1]) * 0.5));
    window.key("Escape");
    window.settled("a free mouse", |status| status["mouse_captured"] == false);
    for (index, x) in [480.0, 620.0].into_iter().enumerate() {
        window.point(x, 300.0);
        window.key("c");
        window.settled("another crater", |status| craters(status).len() == index + 2);
    }
    window.key("ctrl+shift+BackSpace");
    window.settled("no craters", |status| craters(status).is_empty());

    modes(&mut window, pixel, &before);
    window.close();
}

/// Over the panel and over the sky nothing is dug, and the user is told why.
fn nothing_is_dug_without_ground(window: &mut Window) {
    let hint = |status: &Value| status["hint"].as_str().unwrap_or_default().to_owned();
    window.point(100.0, 300.0);
    window.key("c");
    let panel = window.wait("why not", |status| hint(status).contains("not over the picture"));
    assert!(craters(&panel).is_empty());
    // The view is from above; the sky is above its upper end.
    let before = camera(&panel);
    window.point(700.0, 400.0);
    window.xdo("mousedown 3");
    for y in [300.0, 150.0, 20.0] {
        window.point(700.0, y);
    }
    window.xdo("mouseup 3");
    window.wait("a look up", |status| camera(status).pitch > before.pitch + 10.0);
    window.point(700.0, 12.0);
    window.key("c");
    let sky = window.wait("why not", |status| hint(status).contains("only sky under the cursor"));
    assert!(craters(&sky).is_empty());
    window.section("Terrain", false);
    window.section("Camera", true);
    window.click("Over view");
    window.settled("the view from above", |status| camera(status) == before);
    window.section("Camera", false);
    window.section("Terrain", true);
}

/// Both ways to deform the ground, chosen in the panel.
fn modes(window: &mut Window, pixel: DVec2, before: &RgbaImage) {
    window.point(pixel.x, pixel.y);
    window.key("c");
    let baked = window.settled("a crater", |status| craters(status).len() == 1);
    let textures = |status: &Value| list(&status["ledger"]["textures"]).iter().map(|t| t["name"].clone()).collect();
    let names: Vec<Value> = textures(&baked);
    assert!(!names.contains(&Value::from("crater layer")) && !has(&baked["ledger"]["shader_defs"], "CRATERS_LAYERED"));

    window.section("Terrain", false);
    window.section("March", false);
    window.section("Craters", true);
    window.click("Crater mode");
    window.click("layered");
    let layered = window.settled("layered craters", |status| has(&status["ledger"]["shader_defs"], "CRATERS_LAYERED"));
    let names: Vec<Value> = textures(&layered);
    assert!(names.contains(&Value::from("crater layer")), "{names:?}");
    assert_eq!(craters(&layered), craters(&baked), "the craters stay");
    let (_, picture) = window.shot();
    assert_changed_near(before, &picture, pixel);

    window.click("Crater mode");
    window.click("baked");
    let baked = window.settled("baked craters", |status| !has(&status["ledger"]["shader_defs"], "CRATERS_LAYERED"));
    let names: Vec<Value> = textures(&baked);
    assert!(!names.contains(&Value::from("crater layer")), "the layer is gone: {names:?}");
    window.click("Undo crater");
    window.settled("no crater", |status| craters(status).is_empty());
    let (_, picture) = window.shot();
    assert_eq!(differing(before, &picture, 0), 0, "the ground is what it was");
}
