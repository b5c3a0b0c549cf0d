//! A window system may take a window's surface away. A debug build can lose its own on demand.

use image::RgbaImage;
use serde_json::Value;

use crate::harness::{Window, differing, list, told, widget};

fn craters(status: &Value) -> usize {
    list(&status["scene"]["craters"]["list"]).len()
}

/// What the user sees afterwards is what was there before, drawn on a new surface: craters, camera and settings.
#[test]
fn a_lost_surface_is_made_anew_and_nothing_is_lost() {
    let mut window = Window::open_with("--size 700x500 --view over", &[("RUST_LOG", "relief=info,wgpu=warn")]);
    window.click("Discard misses");
    window.settled("a setting", |status| status["scene"]["march"]["discard_misses"] == false);
    let start = window.status();
    window.point(520.0, 300.0);
    window.xdo("mousedown 3 mousemove_relative 24 8 mouseup 3");
    window.settled("a turn", |status| status["scene"]["camera"] != start["scene"]["camera"]);
    window.key("c");
    window.settled("a crater", |status| craters(status) == 1);
    // Nothing but the picture, so that pixels can be compared.
    window.key("F2");
    window.key("F3");
    let before = window.settled("a bare picture", |status| status["panel"] == false && status["overlay"] == false);
    let (_, picture) = window.shot();
    // The message about the screenshot passes.
    let same = |screen: &RgbaImage| differing(&picture, screen, 0) == 0;
    window.screen_until("the picture alone", same);

    for loss in 1..=2 {
        window.key("ctrl+shift+F10");
        // What the screen still shows of the old surface proves nothing: only a new one shows what changes.
        window.key("ctrl+z");
        window.settled("no crater", |status| craters(status) == 0);
        window.screen_until("ground without a crater", |screen| differing(&near(&picture), &near(screen), 8) > 300);
        window.key("c");
        let after = window.settled("a crater", |status| craters(status) == 1);
        window.screen_until("the picture of before", same);
        assert_eq!(after["scene"], before["scene"]);
        assert!(!told(&after, "GPU device"), "the surface is lost, and not the device: {}", after["toasts"]);
        assert_eq!(window.log().matches("surface was lost").count(), loss, "{}", window.log());
    }

    // A surface can be lost while the window changes.
    window.key("ctrl+shift+F10");
    window.xdo("windowsize WINDOW 640 420");
    window.settled("another size", |status| status["size"] == serde_json::json!([640, 420]));
    let (_, shot) = window.shot();
    assert_eq!(shot.dimensions(), (640, 420));
    window.key("F2");
    window.settled("the panel", |status| widget(status, "Technique").is_some());
    for trouble in ["alidation", "panicked", "the GPU reported"] {
        assert!(!window.log().contains(trouble), "{}", window.log());
    }
    window.close();
}

/// The part of a picture around the crater.
fn near(picture: &RgbaImage) -> RgbaImage {
    image::imageops::crop_imm(picture, 520, 280, 60, 60).to_image()
}
