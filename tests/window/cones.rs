//! Cone maps are found behind the picture: the window goes on meanwhile, and what is not wanted any more is given up.

use std::path::Path;

use serde_json::Value;

use crate::harness::{Window, camera, list, number, relief, widget};

/// A map whose cones take some seconds to find.
fn large_map(folder: &Path) -> String {
    let map = folder.join("large.png");
    let mut generate = relief();
    generate.args(["generate", "diamond-square", "--size", "2049", "--seed", "1", "-o"]).arg(&map);
    assert!(generate.status().unwrap().success());
    map.display().to_string()
}

/// Chooses from one of the panel's lists.
pub(crate) fn choose(window: &mut Window, what: &str, technique: &str) {
    window.click(what);
    window.wait("the list", |status| widget(status, technique).is_some());
    window.click(technique);
}

/// Found, or being found, but not yet there.
fn finding(status: &Value) -> bool {
    status["finding_cones"].is_number() && status["drawn_by"] == "max-mipmap"
}

#[test]
fn the_window_goes_on_while_cones_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&format!("{} --size 800x560 --view down", large_map(folder.path())));
    choose(&mut window, "Technique", "relaxed-cone");
    let begun =
        window.wait("a search", |status| finding(status) && status["scene"]["march"]["technique"] == "relaxed-cone");
    assert_eq!(begun["idle"], false, "something is being waited for");

    // The eye looks around, at pictures of its own.
    window.point(560.0, 200.0);
    window.xdo("mousedown 3 mousemove_relative 30 10");
    let turned = window.wait("another picture", |status| camera(status) != camera(&begun) && finding(status));
    window.xdo("mouseup 3");
    assert!(number(&turned["scene_frames"]) > number(&begun["scene_frames"]));

    // A crater moves cones everywhere: the search begins anew, and the crater shows at once.
    window.wait("progress", |status| status["finding_cones"].as_f64().is_some_and(|share| share > 0.02));
    window.point(560.0, 330.0);
    window.key("c");
    let dug = window.wait("a crater", |status| {
        list(&status["scene"]["craters"]["list"]).len() == 1
            && finding(status)
            && number(&status["scene_frames"]) > number(&turned["scene_frames"])
    });
    assert!(number(&dug["finding_cones"]) < 1.0);

    // Another technique needs none: the search is given up, and nothing is waited for.
    choose(&mut window, "Technique", "linear");
    let given_up = window.settled("no search", |status| status["drawn_by"] == "linear");
    assert_eq!(given_up["finding_cones"], Value::Null);
    window.close();
}

#[test]
fn a_technique_draws_once_its_cones_are_found() {
    let mut window = Window::open("--size 800x560 --view over --technique cone");
    let found = window.settled("cones", |status| status["drawn_by"] == "cone");
    let names =
        |status: &Value| list(&status["ledger"]["textures"]).iter().map(|entry| entry["name"].clone()).collect();
    let textures: Vec<Value> = names(&found);
    assert!(textures.contains(&Value::from("cones")), "{textures:?}");
    window.point(560.0, 330.0);
    window.key("c");
    let dug = window.settled("cones of the crater", |status| {
        list(&status["scene"]["craters"]["list"]).len() == 1 && status["drawn_by"] == "cone"
    });
    // The first picture with the crater was not that of the cones.
    assert!(number(&dug["scene_frames"]) >= number(&found["scene_frames"]) + 2.0, "{dug:#}");
    // The other side of a split picture waits for its own.
    for section in ["Terrain", "March"] {
        window.section(section, false);
    }
    window.section("Compare", true);
    window.click("Enable compare");
    window.settled("a split picture", |status| status["scene"]["compare"]["enabled"] == true);
    choose(&mut window, "Compare with", "relaxed-cone");
    let split = window.settled("both", |status| {
        list(&status["ledger"]["textures"]).iter().filter(|entry| entry["name"] == "cones").count() == 2
    });
    assert_eq!(split["drawn_by"], "cone");
    assert!(widget(&split, "Enable compare").is_some());
    window.close();
}
