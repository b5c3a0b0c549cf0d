//! Shaders are compiled behind the picture: no frame waits for them, and what draws meanwhile goes by its own name. A debug
//! build can be told to take its time over it.

use serde_json::Value;

use crate::cones::choose;
use crate::harness::{Window, camera, list, number, text};
use crate::keys::assert_reproduced;

/// Being compiled for the technique that was chosen, which nothing draws with yet.
fn compiling(status: &Value, chosen: &str, drawn: &str) -> bool {
    let built =
        list(&status["ledger"]["pipelines"]).iter().any(|name| text(name).contains(&format!("terrain {chosen} ")));
    status["compiling"] == true
        && status["scene"]["march"]["technique"] == chosen
        && status["drawn_by"] == drawn
        && !built
}

#[test]
fn the_window_flies_on_while_a_technique_is_compiled() {
    let environment = [("RELIEF_SLOW_COMPILE", "6000")];
    let mut window = Window::open_with("--size 640x480 --view over --technique linear", &environment);
    choose(&mut window, "Technique", "secant");
    let begun = window.wait("a compiler at work", |status| compiling(status, "secant", "linear"));
    assert_eq!(begun["idle"], false, "something is being waited for");
    let two_frames_on = number(&begun["frame"]) + 2.0;
    let says = |status: &Value| status["says"].as_str().unwrap_or_default().to_owned();
    let notice = window.wait("two frames", |status| number(&status["frame"]) >= two_frames_on);
    assert!(says(&notice).contains("Compiling secant"), "{}", notice["says"]);
    assert!(says(&notice).contains("linear draws meanwhile"), "{}", notice["says"]);

    // The eye flies on, and all that it sees meanwhile is drawn by the technique that was in use.
    window.point(560.0, 200.0);
    window.xdo("click 1 keydown e");
    let flown = window.wait("twelve pictures of a flight", |status| {
        let pictures = number(&status["scene_frames"]) - number(&begun["scene_frames"]);
        assert!(status["drawn_by"] == "linear" || pictures >= 12.0, "{status:#}");
        pictures >= 12.0
    });
    assert!(compiling(&flown, "secant", "linear"), "they came while it was being compiled: {flown:#}");
    assert!(camera(&flown).eye != camera(&begun).eye);
    window.xdo("keyup e");

    // Back, and to a third one: what is not wanted any more draws nothing, and the end is that of a fresh start.
    choose(&mut window, "Technique", "linear");
    let back = window.settled("the old technique", |status| status["scene"]["march"]["technique"] == "linear");
    assert_eq!((&back["drawn_by"], &back["compiling"]), (&Value::from("linear"), &Value::from(false)));
    choose(&mut window, "Technique", "secant");
    choose(&mut window, "Technique", "linear-binary");
    let third = window.settled("the third technique", |status| status["drawn_by"] == "linear-binary");
    assert_eq!(third["says"], Value::Null);
    assert!(list(&third["toasts"]).is_empty(), "{}", third["toasts"]);
    assert_reproduced(&mut window);
    window.close();
}
