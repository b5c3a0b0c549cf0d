//! The function keys.

use std::process::Command;

use serde_json::Value;

use crate::harness::{Window, differing, list, relief, widget};

/// Makes the screenshot again without a window and compares.
#[track_caller]
pub(crate) fn assert_reproduced(window: &mut Window) {
    let (path, picture) = window.shot();
    let again = window.path("again.png");
    let mut render: Command = relief();
    render.arg("render").arg("--scene").arg(path.with_extension("toml"));
    render.arg("--size").arg(format!("{}x{}", picture.width(), picture.height())).arg("-o").arg(&again);
    let output = render.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let again = image::open(again).unwrap().to_rgba8();
    assert_eq!(differing(&picture, &again, 0), 0, "the scene beside the screenshot makes the same picture");
}

/// A debug build can destroy its device on demand: what a driver's reset does to a user.
#[cfg(debug_assertions)]
#[test]
fn a_lost_device_is_set_up_again_and_nothing_is_lost() {
    let mut window = Window::open("--size 700x500");
    window.point(450.0, 300.0);
    window.key("c");
    window.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == 1);
    let (_, before) = window.shot();
    window.key("ctrl+shift+F9");
    let message =
        |status: &Value| list(&status["toasts"]).iter().any(|toast| toast.to_string().contains("set up again"));
    let after = window.settled("a new device", message);
    assert_eq!(list(&after["scene"]["craters"]["list"]).len(), 1);
    let (_, again) = window.shot();
    assert_eq!(differing(&before, &again, 0), 0, "the picture is the same on the new device");
    // The panel came back with it.
    assert!(widget(&after, "Technique").is_some());
    window.close();
}

#[test]
fn function_keys_do_what_the_help_says() {
    let mut window = Window::open("--size 700x500");
    assert_reproduced(&mut window);

    window.key("F1");
    let help = window.settled("the help", |status| status["help"] == true);
    assert!(widget(&help, "Close window").is_some(), "the help can be closed by mouse, too");
    window.key("Escape");
    window.settled("no help", |status| status["help"] == false);

    window.key("F2");
    let bare = window.settled("no panel", |status| status["panel"] == false);
    assert!(list(&bare["widgets"]).is_empty(), "{}", bare["widgets"]);
    window.key("F2");
    window.settled("the panel", |status| widget(status, "Technique").is_some());

    window.point(600.0, 300.0);
    window.key("c");
    window.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == 1);
    window.xdo("click 4 keydown e");
    window.wait("a flight", |status| status["idle"] == false);
    window.xdo("keyup e");
    assert_reproduced(&mut window);

    // Without a window manager nobody makes the window larger, but the wish is known and taken back.
    window.key("F11");
    let full = window.settled("an answer to F11", |_| true);
    assert_eq!(list(&full["toasts"]).iter().filter(|toast| toast.as_str().unwrap().contains("annot")).count(), 0);
    window.key("F11");
    window.settled("the window again", |status| status["full_screen"] == false);
    window.close();
}
