//! Nothing changes: no frame. Only the panel changes: no scene.

use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::harness::{Window, number, widget};

fn counts(status: &Value) -> (f64, f64) {
    (number(&status["frame"]), number(&status["scene_frames"]))
}

#[test]
fn frames_are_drawn_only_for_a_reason() {
    let mut window = Window::open("--size 640x480 --view over");
    window.point(600.0, 300.0);
    window.section("Terrain", false);
    window.section("March", false);
    window.point(600.0, 300.0);
    // The graph of frame times moves once more after the last picture.
    sleep(Duration::from_millis(700));
    let before = window.settled("rest", |_| true);
    sleep(Duration::from_secs(2));
    let after = window.status();
    assert_eq!(counts(&before), counts(&after), "nothing changed, so nothing is drawn");

    window.section("Occluder", true);
    let opened = window.settled("an open section", |status| widget(status, "Enable occluder").is_some());
    assert!(number(&opened["frame"]) > number(&after["frame"]));
    assert_eq!(opened["scene_frames"], after["scene_frames"], "the panel alone draws no terrain");

    window.click("Enable occluder");
    window.settled("an occluder", |status| status["scene"]["occluder"]["enabled"] == true);
    window.fill_number("Spin value", "90");
    let spinning = window.wait("a spin", |status| status["scene"]["occluder"]["spin"] == 90.0);
    assert_eq!(spinning["idle"], false);
    let yaw = |status: &Value| number(&status["scene"]["occluder"]["rotation"][0]);
    let start = counts(&spinning).1;
    let later = window.wait("ten pictures of the turning cube", |status| counts(status).1 >= start + 10.0);
    assert!(yaw(&later) != yaw(&spinning));
    window.fill_number("Spin value", "0");
    window.settled("a still occluder", |status| status["scene"]["occluder"]["spin"] == 0.0);
    window.point(600.0, 300.0);
    sleep(Duration::from_millis(700));
    let stopped = window.settled("rest", |_| true);
    sleep(Duration::from_secs(1));
    assert_eq!(counts(&stopped), counts(&window.status()), "a stopped cube costs no frame");
    window.close();
}
