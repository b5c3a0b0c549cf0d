//! Terrain made in the panel: it is seen, it is a map of its own, it is saved as the command line writes it.

use std::fs;

use serde_json::Value;

use crate::harness::{Window, camera, differing, list, number, relief, text, told, widget};

/// The recipe on screen, or nothing.
fn recipe(status: &Value) -> &Value {
    &status["scene"]["terrain"]["recipe"]
}

fn samples(status: &Value) -> u64 {
    let heights = list(&status["ledger"]["textures"]).iter().find(|texture| texture["name"] == "heights");
    heights.map_or(0, |texture| texture["width"].as_u64().unwrap_or_default())
}

#[test]
fn terrain_is_made_in_the_panel_seen_and_saved() {
    let mut window = Window::open("--size 900x700");
    let canyon = window.settled("rest", |_| true);
    let before = window.screen();
    for section in ["Files", "Terrain", "March"] {
        window.section(section, false);
    }
    window.section("Generate", true);
    let opened = window.settled("rest", |_| true);
    assert_eq!(opened["scene"], canyon["scene"], "opening the section makes nothing");

    // Dragged: small ones meanwhile, the whole one once it rests.
    window.slide("Roughness", 0.35, |status| !recipe(status).is_null());
    let made = window.settled("the whole map", |status| samples(status) == 1025);
    assert_eq!(recipe(&made)["kind"], "ridged");
    let roughness = number(&recipe(&made)["roughness"]);
    assert!((roughness - 0.35).abs() < 0.1, "{roughness}");
    assert!(window.title().contains("ridged 1"), "{}", window.title());
    assert!(differing(&before, &window.screen(), 16) > 50_000, "another terrain is seen");

    // The next seed by key; the eye keeps its place.
    window.key("Prior");
    window.point(700.0, 300.0);
    window.key("g");
    let next = window.settled("the next seed", |status| recipe(status)["seed"] == 2 && samples(status) == 1025);
    assert_eq!(camera(&next), camera(&made), "the eye stays");
    let seen = window.screen();

    // What is saved is what the command line writes of the same recipe.
    let file = window.path("land.png");
    window.click("Land file");
    window.settled("a cursor in the field", |status| status["typing"] == true);
    window.fill("Land file", &file.display().to_string());
    window.click("Save as…");
    window.settled("a message", |status| told(status, "Saved"));
    let again = window.path("again.png");
    let mut command = relief();
    command.arg("generate").arg("--recipe").arg(file.with_extension("toml")).arg("-o").arg(&again);
    assert!(command.status().unwrap().success());
    assert!(fs::read(&file).unwrap() == fs::read(&again).unwrap(), "the same bytes");
    assert_eq!(
        fs::read_to_string(file.with_extension("toml")).unwrap(),
        fs::read_to_string(again.with_extension("toml")).unwrap()
    );

    // A crater is not lost: the next land is a map of its own.
    window.point(650.0, 500.0);
    window.key("c");
    window.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == 1);
    window.key("g");
    let third = window.settled("a third map", |status| recipe(status)["seed"] == 3 && samples(status) == 1025);
    assert!(list(&third["scene"]["craters"]["list"]).is_empty());
    window.key("ctrl+shift+Tab");
    let back = window.settled("the second", |status| recipe(status)["seed"] == 2 && samples(status) == 1025);
    assert_eq!(list(&back["scene"]["craters"]["list"]).len(), 1, "with its crater");
    window.key("ctrl+z");
    window.settled("no crater", |status| list(&status["scene"]["craters"]["list"]).is_empty());
    window.screen_until("the same ground as before", |screen| differing(screen, &seen, 16) < 40_000);
    window.key("ctrl+shift+Tab");
    window.settled("the canyon", |status| recipe(status).is_null() && text(&status["drawn_by"]) == "max-mipmap");

    // Esc ends what takes long, and the old terrain stays.
    window.click("Land size");
    window.settled("the sizes", |status| widget(status, "4097 × 4097").is_some());
    window.click("4097 × 4097");
    window.wait("progress", |status| status["says"].as_str().is_some_and(|says| says.starts_with("Making 4097")));
    window.key("Escape");
    let left = window.settled("an end", |status| widget(status, "Cancel making").is_none());
    assert_eq!(samples(&left), 257, "the small one is all that was made");
    window.close();
}
