//! Fields that are typed in, and files opened by them.

use image::{GrayImage, Luma};

use crate::harness::{Window, camera, differing, list, told, widget};

#[test]
fn typing_flies_nowhere_and_bad_files_change_nothing() {
    let mut window = Window::open("--size 900x640 --view over");
    let start = window.settled("rest", |_| true);
    // The cursor stays over the field, the craters' key goes to the field as well.
    window.fill("Terrain file", "wasdeqc");
    let typed = window.settled("a field with letters", |_| true);
    assert_eq!(camera(&typed), camera(&start), "typing does not fly");
    assert!(list(&typed["scene"]["craters"]["list"]).is_empty(), "typing digs nothing");
    assert_eq!(typed["mouse_captured"], false);

    let (_, before) = window.shot();
    let missing = window.path("none.png").display().to_string();
    window.fill("Terrain file", &missing);
    window.key("Return");
    let failed = window.settled("a message", |status| told(status, "none.png"));
    assert!(told(&failed, "no such file"), "{:?}", failed["toasts"]);
    assert_eq!(failed["scene"], start["scene"], "the old terrain stays");
    let (_, after) = window.shot();
    assert_eq!(differing(&before, &after, 0), 0, "the old picture stays");
    assert!(window.title().contains("Grand Canyon"), "{}", window.title());

    diffuse(&mut window);
    good_map(&mut window);
    window.close();
}

/// An image that is none: the setting is put back.
fn diffuse(window: &mut Window) {
    let scene = window.status()["scene"].clone();
    std::fs::write(window.path("broken.png"), "not a picture").unwrap();
    let broken = window.path("broken.png").display().to_string();
    window.section("March", false);
    window.section("Diffuse", true);
    window.fill("Diffuse image", &broken);
    window.click("Apply diffuse image");
    let failed = window.settled("a message", |status| told(status, "broken.png"));
    assert_eq!(failed["scene"], scene, "the setting is put back");
    window.section("Diffuse", false);
}

fn good_map(window: &mut Window) {
    let map = GrayImage::from_fn(64, 48, |x, y| Luma([((x * 3 + y * 2) % 256) as u8]));
    map.save(window.path("ramp.png")).unwrap();
    let good = window.path("ramp.png");
    assert_eq!(widget(&window.status(), "True proportion").unwrap()["disabled"], false, "the canyon has an extent");
    window.fill("Terrain file", &good.display().to_string());
    window.click("Open terrain");
    let opened = window.settled("the new map", |status| told(status, "Opened"));
    assert_eq!(widget(&opened, "True proportion").unwrap()["disabled"], true, "a plain image has no proportion");
    assert_eq!(opened["scene"]["terrain"]["file"], good.display().to_string());
    let heights = list(&opened["ledger"]["textures"]).iter().find(|texture| texture["name"] == "heights").unwrap();
    assert_eq!((&heights["width"], &heights["height"]), (&64.into(), &48.into()));
    assert!(window.title().contains("ramp"), "{}", window.title());
    assert_eq!(widget(&opened, "Terrain file").unwrap()["value"], good.display().to_string());
}
