//! The split view and the error view in the real window: the line is dragged, the reference arrives by itself, and the
//! techniques are measured with one button.

use crate::harness::{Window, differing, has, number, text, widget};

/// Where the line is, as a share of the width.
fn share(status: &serde_json::Value) -> f64 {
    number(&status["scene"]["compare"]["share"])
}

#[test]
fn the_split_line_is_dragged_with_the_mouse() {
    let mut window = Window::open("--size 800x500 --compare linear@0.6 --samples 16");
    let before = window.settled("two techniques", |status| has(&status["ledger"]["passes"], "compare"));
    assert_eq!(share(&before), 0.6);
    let (_, first) = window.shot();
    window.point(480.0, 300.0);
    window.xdo("mousedown 1");
    for x in [500.0, 560.0, 640.0] {
        window.point(x, 320.0);
    }
    window.wait("the line to follow", |status| (share(status) - 0.8).abs() < 0.02);
    window.xdo("mouseup 1");
    let after = window.settled("the line at rest", |status| (share(status) - 0.8).abs() < 0.02);
    assert_eq!(before["scene"]["camera"], after["scene"]["camera"], "the eye stays where it is");
    let (_, second) = window.shot();
    assert!(differing(&first, &second, 8) > 100, "another part shows linear");
    let columns = |from: u32, to: u32| {
        let part = |picture: &image::RgbaImage| image::imageops::crop_imm(picture, from, 0, to - from, 500).to_image();
        differing(&part(&first), &part(&second), 0)
    };
    assert_eq!((columns(0, 478), columns(656, 800)), (0, 0), "beside the line's way nothing changes");
    // It cannot be dragged below the panel, where it could not be taken hold of again.
    window.point(640.0, 320.0);
    window.xdo("mousedown 1");
    for x in [500.0, 300.0, 40.0] {
        window.point(x, 320.0);
    }
    window.wait("the line at the panel", |status| share(status) < 0.55);
    window.xdo("mouseup 1");
    let edge = share(&window.settled("rest", |_| true)) * 800.0;
    assert!(edge > 100.0, "the line is at {edge}");
    window.point(edge + 2.0, 320.0);
    window.xdo("mousedown 1");
    window.point(640.0, 320.0);
    window.wait("the line where it was", |status| (share(status) - 0.8).abs() < 0.02);
    window.xdo("mouseup 1");
    let after = window.settled("rest", |_| true);
    // Beside the line the mouse drags nothing.
    window.point(500.0, 300.0);
    window.xdo("mousedown 1");
    window.point(560.0, 300.0);
    window.xdo("mouseup 1");
    window.key("F3");
    let still = window.settled("no overlay", |status| status["overlay"] == false);
    assert_eq!(share(&still), share(&after));
    window.close();
}

#[test]
fn an_eye_at_rest_is_compared_with_the_reference() {
    let mut window = Window::open("--size 640x400 --technique linear-binary --samples 64..256 --debug error");
    let shown = window.settled("the reference", |status| status["reference"] == true);
    assert!(!has(&shown["ledger"]["passes"], "exact"), "{}", shown["ledger"]);
    window.point(500.0, 200.0);
    window.xdo("mousedown 3 mousemove_relative 30 10");
    let moved = window.wait("the exact technique instead", |status| status["reference"] == false);
    assert!(has(&moved["ledger"]["passes"], "exact"), "{}", moved["ledger"]);
    window.xdo("mouseup 3");
    window.settled("the reference of the new view", |status| status["reference"] == true);
    window.close();
}

#[test]
fn one_button_measures_the_techniques() {
    let mut window = Window::open("--size 640x420");
    for section in ["Terrain", "March"] {
        window.section(section, false);
    }
    window.section("Tradeoff", true);
    let before = window.settled("rest", |_| true);
    window.click("Measure techniques");
    window.wait("a way out", |status| widget(status, "Cancel measurement").is_some());
    window.click("Cancel measurement");
    window.settled("no measurement", |status| widget(status, "Cancel measurement").is_none());
    window.click("Measure techniques");
    let busy = window.wait("a measurement", |status| status["idle"] == false);
    let button = widget(&busy, "Measure techniques");
    assert!(button.is_some(), "the panel goes on: {}", text(&busy["widgets"][0]["label"]));
    let done = window.settled("all techniques", |status| number(&status["tradeoff"]) >= 3.0);
    assert_eq!(done["scene"], before["scene"], "measuring changes nothing");
    assert_eq!(done["ledger"]["passes"], before["ledger"]["passes"]);
    assert!(number(&done["frame"]) > number(&before["frame"]) + 20.0, "frames were shown meanwhile");
    // The section below the plot begins in the window, or just below it.
    let below = widget(&done, "Frame").unwrap();
    assert!(number(&below["rect"][1]) < 430.0, "the plot was scrolled to: {below}");
    window.click("Reset tradeoff");
    window.settled("no plot", |status| status["tradeoff"] == 0);
    window.close();
}
