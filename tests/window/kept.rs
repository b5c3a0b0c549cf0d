//! What is kept from one run to the next, and how the interface looks.

use crate::harness::{Window, camera, list, told, widget};

#[test]
fn settings_keys_bookmarks_and_the_window_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let settings = [("RELIEF_CONFIG_DIR", folder.path().to_str().unwrap())];
    let mut window = Window::open_with("--size 760x560", &settings);
    let first = window.settled("the words of a first start", |status| widget(status, "Start").is_some());
    assert_eq!((&first["log"], &first["zoom"]), (&false.into(), &1.0.into()));
    assert_eq!(first["overlay"], false, "no figures over the first picture");
    window.key("Escape");
    window.settled("no words", |status| widget(status, "Start").is_none());
    window.section("Terrain", false);
    window.section("Interface", true);
    window.click("Theme");
    window.settled("an open list", |status| widget(status, "light").is_some());
    window.click("light");
    window.settled("light", |status| status["dark"] == false);
    window.section("Interface", false);
    keys(&mut window);
    window.key("F3");
    window.key("ctrl+equal");
    window.settled("larger", |status| status["zoom"].as_f64() > Some(1.05) && status["overlay"] == true);
    window.key("F4");
    window.settled("the log", |status| status["log"] == true && widget(status, "Copy log").is_some());
    window.key("ctrl+3");
    let marked = camera(&window.settled("a bookmark", |status| status["hint"].is_string()));
    window.close();

    let mut again = Window::open_with("--view down", &settings);
    let kept = again.settled("the same", |status| status["zoom"].as_f64() > Some(1.05));
    assert_ne!(kept["size"], serde_json::json!([760, 560]), "a size that was asked for is for one run");
    assert!(kept["dark"] == false && kept["overlay"] == true && kept["log"] == true, "{kept:#}");
    assert!(widget(&kept, "Start").is_none(), "the first words are for the first start");
    again.key("3");
    again.settled("the bookmark", |status| camera(status) == marked);
    again.xdo("windowsize WINDOW 700 520");
    again.settled("another size", |status| status["size"] == serde_json::json!([700, 520]));
    again.point(600.0, 300.0);
    again.key("x");
    again.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == 1);
    again.close();
    let mut third = Window::open_with("--view down", &settings);
    third.settled("the same size", |status| status["size"] == serde_json::json!([700, 520]));
    third.close();
}

/// X digs from now on, and a key that is taken is refused.
fn keys(window: &mut Window) {
    window.section("Keys", true);
    window.click("Key for crater");
    window.settled("a question", |status| status["choosing_key"] == true);
    window.key("F1");
    let refused = window.settled("a refusal", |status| told(status, "F1 already does this"));
    assert_eq!(refused["help"], false, "the key that was pressed does nothing else");
    window.click("Key for crater");
    window.settled("a question", |status| status["choosing_key"] == true);
    window.key("x");
    window.settled("an answer", |status| status["choosing_key"] == false);
    window.section("Keys", false);
    window.settled("rest", |_| true);
}
