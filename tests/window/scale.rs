//! The monitor's scale changes while the viewer is open: the user chose another one, or moved the window to a monitor with
//! more pixels.

use glam::DVec2;
use image::RgbaImage;
use serde_json::{Value, json};

use crate::craters::assert_under;
use crate::desktop::Settings;
use crate::harness::{Window, differing, list, number, widget};

/// Height of a row of the panel, physical pixels.
fn row(status: &Value) -> f64 {
    let rect = &widget(status, "Terrain").unwrap()["rect"];
    number(&rect[3]) - number(&rect[1])
}

/// Fails unless a key digs where the cursor points, and a click hits what it points at.
#[track_caller]
fn assert_the_pointer_hits(window: &mut Window, pixel: DVec2) {
    window.point(pixel.x, pixel.y);
    let before = list(&window.status()["scene"]["craters"]["list"]).len();
    window.key("c");
    let answer = window.wait("an answer", |status| {
        status["hint"].is_string() || list(&status["scene"]["craters"]["list"]).len() == before + 1
    });
    assert!(answer["hint"].is_null(), "{}", answer["hint"]);
    let dug = window.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == before + 1);
    assert_under(&dug, pixel);
    let misses = dug["scene"]["march"]["discard_misses"] == true;
    window.click("Discard misses");
    window.settled("the toggle", |status| status["scene"]["march"]["discard_misses"] == !misses);
}

/// Fails unless the screen's pixels are the picture's own where nothing is above it: it is not stretched.
#[track_caller]
fn assert_full_resolution(window: &mut Window, size: [u32; 2]) {
    window.key("F3");
    window.settled("no overlay", |status| status["overlay"] == false);
    let (_, picture) = window.shot();
    // Right of the panel, below messages and the line about the crater.
    let part = |picture: &RgbaImage| {
        assert_eq!([picture.width(), picture.height()], size);
        image::imageops::crop_imm(picture, size[0] * 3 / 4, size[1] / 2, size[0] / 4, size[1] * 3 / 8).to_image()
    };
    window.screen_until("the picture's own pixels", |screen| differing(&part(screen), &part(&picture), 0) == 0);
}

#[test]
fn another_scale_of_the_monitor_makes_the_panel_larger_and_the_picture_no_coarser() {
    let environment = [("RUST_LOG", "relief=info,wgpu=warn")];
    let (mut window, desktop) = Window::open_on("--size 700x500 --view over", &environment, Settings::new);
    let small = window.settled("rest", |status| status["scale_factor"] == 1.0);

    desktop.set_scale(2.0);
    // By its window system's custom the window keeps its size in points.
    let doubled = json!([1400, 1000]);
    let large = window.settled("twice the scale", |status| {
        status["scale_factor"] == 2.0 && status["size"] == doubled && row(status) > 1.8 * row(&small)
    });
    assert!(row(&large) < 2.2 * row(&small), "{} and {}", row(&large), row(&small));
    assert_the_pointer_hits(&mut window, DVec2::new(1101.0, 651.0));

    // A window manager speaks up after that. The scale is known, so nothing grows again.
    desktop.tell_place(window.number());
    window.key("F1");
    window.settled("the help", |status| status["help"] == true);
    window.key("F1");
    let same = window.settled("no help", |status| status["help"] == false);
    assert_eq!((&same["size"], &same["scale_factor"]), (&doubled, &json!(2.0)));
    assert!((row(&same) - row(&large)).abs() <= 1.0, "{} and {}", row(&same), row(&large));
    assert_the_pointer_hits(&mut window, DVec2::new(903.0, 602.0));
    assert_full_resolution(&mut window, [1400, 1000]);

    // And back, to a window that knew of twice the scale.
    desktop.set_scale(1.0);
    let again = window.settled("the first scale", |status| {
        status["scale_factor"] == 1.0 && status["size"] == json!([700, 500]) && row(status) < 1.2 * row(&small)
    });
    assert!((row(&again) - row(&small)).abs() <= 1.0, "{} and {}", row(&again), row(&small));
    assert_the_pointer_hits(&mut window, DVec2::new(561.0, 262.0));
    let log = window.log();
    assert!(!log.contains("panicked") && !log.contains("alidation"), "{log}");
    window.close();
}
