//! Nothing changes: no frame. Only the panel changes: no scene. Nobody looks: neither.

use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::desktop::{Cover, minimise};
use crate::harness::{Window, camera, has, number, widget};

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

    window.section("Occluder", false);
    window.section("Sun", true);
    window.click("Follow the clock");
    window.settled("a clock", |status| status["scene"]["lighting"]["clock"]["enabled"] == true);
    window.fill_number("Clock speed value", "30");
    let runs = window.wait("a running clock", |status| status["scene"]["lighting"]["clock"]["speed"] == 30.0);
    let hour = |status: &Value| number(&status["scene"]["lighting"]["clock"]["hour"]);
    let later = window.wait("five pictures of it", |status| counts(status).1 >= counts(&runs).1 + 5.0);
    assert!(hour(&later) != hour(&runs));
    window.fill_number("Clock speed value", "0");
    window.settled("a sun that stands", |status| status["scene"]["lighting"]["clock"]["speed"] == 0.0);
    window.point(600.0, 300.0);
    sleep(Duration::from_millis(700));
    let stopped = window.settled("rest", |_| true);
    sleep(Duration::from_secs(1));
    assert_eq!(counts(&stopped), counts(&window.status()), "a sun that stands costs no frame");

    window.section("Sun", false);
    window.section("Water", true);
    window.point(600.0, 300.0);
    window.key("o");
    window.settled("a sea", |status| has(&status["ledger"]["passes"], "water"));
    window.click("Moving water");
    let flows = window.wait("waves", |status| status["scene"]["water"]["moving"] == true);
    let time = |status: &Value| number(&status["scene"]["water"]["time"]);
    let later = window.wait("five pictures of them", |status| counts(status).1 >= counts(&flows).1 + 5.0);
    assert!(time(&later) > time(&flows));
    window.point(600.0, 300.0);
    window.key("o");
    let gone = |status: &Value| status["scene"]["water"]["enabled"] == false && status["hint"].is_null();
    let stopped = window.settled("no sea, and nothing that tells of it", gone);
    sleep(Duration::from_secs(1));
    assert_eq!(counts(&stopped), counts(&window.status()), "a sea that is switched off costs no frame");
    window.close();
}

/// Waits until the viewer has come to rest, though it has something to draw, and sees that it stays so.
#[track_caller]
fn assert_rests(window: &mut Window, why: &str) -> Value {
    let before = window.settled(why, |_| true);
    sleep(Duration::from_secs(1));
    let after = window.status();
    assert_eq!(counts(&before), counts(&after), "{why}: nobody sees what is drawn, so nothing is");
    after
}

#[track_caller]
fn assert_goes_on(window: &mut Window, before: &Value, why: &str) {
    let start = counts(before).1;
    window.wait(why, |status| counts(status).1 >= start + 5.0);
}

/// A cube turns, and a key is held: with the window covered or minimised both cost nothing, and with it back they go on.
#[test]
fn a_window_that_nobody_sees_draws_nothing() {
    let mut window = Window::open("--size 640x480 --view over");
    for section in ["Terrain", "March"] {
        window.section(section, false);
    }
    window.section("Occluder", true);
    window.click("Enable occluder");
    window.settled("an occluder", |status| status["scene"]["occluder"]["enabled"] == true);
    window.fill_number("Spin value", "90");
    let spinning = window.wait("a spin", |status| status["scene"]["occluder"]["spin"] == 90.0);
    assert_goes_on(&mut window, &spinning, "a turning cube");
    let (display, number) = (window.display().to_owned(), window.number());

    let cover = Cover::new(&display, [1600, 1200]);
    let covered = assert_rests(&mut window, "a covered window");
    // The keyboard goes back to flying with a click on the picture, and stays with a covered window.
    window.xdo("windowfocus --sync WINDOW keydown e");
    let held = assert_rests(&mut window, "a covered window and a held key");
    assert_eq!(camera(&held), camera(&covered));
    window.xdo("keyup e");
    drop(cover);
    assert_goes_on(&mut window, &held, "a window in view again");

    let cover = Cover::new(&display, [300, 480]);
    let half = window.status();
    assert_goes_on(&mut window, &half, "a window half covered");
    drop(cover);

    minimise(&display, number, true);
    let minimised = assert_rests(&mut window, "a minimised window");
    minimise(&display, number, false);
    assert_goes_on(&mut window, &minimised, "a window brought back");
    window.xdo("windowfocus --sync WINDOW");
    window.fill_number("Spin value", "0");
    window.settled("a still occluder", |status| status["scene"]["occluder"]["spin"] == 0.0);
    window.close();
}
