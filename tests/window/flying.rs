//! Keys and mouse move the eye.

use std::thread::sleep;
use std::time::Duration;

use glam::DVec3;
use relief::camera::{Camera, NamedView};

use crate::harness::{Window, camera, canyon, number};

/// High above the ground, where height no longer changes the speed; small, so that frames come fast.
const HIGH: &str = "--size 420x300 --eye 0.5,1.6,0.7 --target 0.5,0,0.3";

/// Holds keys down for about `time`, and returns the eye before and after.
fn hold(window: &mut Window, keys: &[&str], time: Duration) -> (Camera, Camera) {
    let before = camera(&window.settled("an eye at rest", |_| true));
    let all = |what: &str| keys.iter().map(|key| format!("{what} {key} ")).collect::<String>();
    window.xdo(&all("keydown"));
    sleep(time);
    window.xdo(&all("keyup"));
    let after = window.settled("the flight", |status| camera(status).eye != before.eye);
    (before, camera(&after))
}

#[test]
fn keys_fly_and_the_mouse_looks() {
    let mut window = Window::open(HIGH);
    window.key("F2");
    window.settled("no panel", |status| status["panel"] == false);
    directions(&mut window);
    speeds(&mut window);
    looking(&mut window);
    ground(&mut window);
    window.close();
}

fn directions(window: &mut Window) {
    let basis = camera(&window.status()).basis();
    let keys = [
        ("w", basis.forward),
        ("s", -basis.forward),
        ("a", -basis.right),
        ("d", basis.right),
        ("e", DVec3::Y),
        ("q", DVec3::NEG_Y),
    ];
    for (key, direction) in keys {
        let (before, after) = hold(window, &[key], Duration::from_millis(150));
        let way = after.eye - before.eye;
        assert!(way.normalize().dot(direction) > 0.9999, "{key} flies along {way} and not along {direction}");
        assert_eq!((before.yaw, before.pitch), (after.yaw, after.pitch), "{key} does not turn the eye");
    }
    let (before, after) = hold(window, &["w", "d"], Duration::from_millis(150));
    let way = (after.eye - before.eye).normalize();
    assert!(way.dot(basis.forward) > 0.3 && way.dot(basis.right) > 0.3, "two keys fly diagonally: {way}");
}

fn speeds(window: &mut Window) {
    let time = Duration::from_millis(500);
    let mut way = |keys: &[&str], back: &[&str]| {
        let (before, after) = hold(window, keys, time);
        hold(window, back, time);
        (after.eye - before.eye).length()
    };
    let plain = way(&["d"], &["a"]);
    let fast = way(&["shift", "d"], &["shift", "a"]);
    let slow = way(&["alt", "d"], &["alt", "a"]);
    assert!(fast > 1.5 * plain, "Shift is faster: {fast} and {plain}");
    assert!(plain > 1.5 * slow, "Alt is slower: {slow} and {plain}");

    window.point(210.0, 150.0);
    let speed = number(&window.status()["speed"]);
    for _ in 0..4 {
        window.xdo("click 4");
    }
    let faster = number(&window.settled("more speed", |status| number(&status["speed"]) > 1.9 * speed)["speed"]);
    let (before, after) = hold(window, &["d"], time);
    hold(window, &["a"], time);
    assert!((after.eye - before.eye).length() > 1.3 * plain, "the wheel's speed is flown");
    for _ in 0..4 {
        window.xdo("click 5");
    }
    let back = window.settled("less speed", |status| number(&status["speed"]) < 0.6 * faster);
    assert!((number(&back["speed"]) - speed).abs() < 1e-9, "as many notches down as up");
}

fn looking(window: &mut Window) {
    let before = camera(&window.settled("an eye at rest", |_| true));
    window.point(200.0, 150.0);
    window.xdo("mousedown 3 mousemove_relative 40 20 mouseup 3");
    let after = camera(&window.settled("a turn", |status| camera(status).yaw != before.yaw));
    assert!(turn(before.yaw, after.yaw) > 0.0 && after.pitch < before.pitch, "to the right and down: {after:?}");
    assert_eq!(after.eye, before.eye, "looking does not move");

    // Without a button the mouse does not look ...
    window.point(100.0, 100.0);
    window.point(250.0, 180.0);
    window.key("F3");
    let still = window.settled("no overlay", |status| status["overlay"] == false);
    assert_eq!(camera(&still), after);
    // ... and with the mouse captured it does.
    window.key("f");
    window.settled("a captured mouse", |status| status["mouse_captured"] == true);
    window.xdo("mousemove_relative -- -30 -20");
    let looked = camera(&window.settled("a look", |status| camera(status).yaw != after.yaw));
    assert!(turn(after.yaw, looked.yaw) < 0.0 && looked.pitch > after.pitch, "to the left and up: {looked:?}");
    window.key("Escape");
    window.settled("a free mouse", |status| status["mouse_captured"] == false);
    window.point(120.0, 90.0);
    window.key("F3");
    let free = window.settled("the overlay", |status| status["overlay"] == true);
    assert_eq!(camera(&free), looked, "a free mouse does not look");
}

/// The way from one yaw to another, degrees, to the right.
fn turn(from: f64, to: f64) -> f64 {
    (to - from + 180.0).rem_euclid(360.0) - 180.0
}

fn ground(window: &mut Window) {
    let map = canyon();
    let size = map.box_size(None);
    window.key("Home");
    let start = NamedView::Start.camera(&map, size);
    let home = camera(&window.settled("the start view", |status| (camera(status).eye - start.eye).length() < 1e-12));
    assert!((home.yaw - start.yaw).abs() < 1e-9 && (home.pitch - start.pitch).abs() < 1e-9, "{home:?}");

    let above = |status: &serde_json::Value| {
        let eye = camera(status).eye;
        eye.y - map.surface_height(eye.x / size.x, eye.z / size.z) * size.y
    };
    // Off the southern edge there is no ground; over the map there is.
    hold(window, &["w"], Duration::from_millis(700));
    assert!(above(&window.settled("a place over the map", |_| true)) > 0.01);
    window.xdo("keydown shift keydown q");
    let lowest = window.wait("the ground", |status| above(status) < 0.002);
    assert!(above(&lowest) > 0.0, "the eye stays above the ground");
    let frame = number(&lowest["frame"]);
    let later = window.wait("more frames", |status| number(&status["frame"]) > frame + 5.0);
    window.xdo("keyup q keyup shift");
    assert!(above(&later) > 0.0, "the eye stays above the ground however long Q is held");

    window.key("F2");
    window.settled("the panel", |status| status["panel"] == true);
    window.section("Terrain", false);
    window.section("March", false);
    window.section("Camera", true);
    window.click("Allow below ground");
    window.settled("permission", |status| {
        crate::harness::widget(status, "Allow below ground").unwrap()["toggled"] == true
    });
    // The keyboard goes back to flying with a click on the picture.
    window.point(400.0, 150.0);
    window.xdo("click 1 keydown shift keydown q");
    window.wait("a place below the ground", |status| above(status) < -0.002);
    window.xdo("keyup q keyup shift");
    window.settled("rest", |_| true);
}
