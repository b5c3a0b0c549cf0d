//! Maps in and out: several on the command line, the dialogue, the gallery, the import card, saving, cancelling.

use std::fs;

use image::{ImageBuffer, Luma};
use relief::heightfield::load;

use crate::harness::{Window, camera, centre, list, text, told, widget};

/// Every widget of the part that shows now, so that none is forgotten here.
fn labels(window: &mut Window) -> Vec<String> {
    let status = window.settled("rest", |_| true);
    list(&status["widgets"]).iter().map(|widget| text(&widget["label"]).to_owned()).collect()
}

#[test]
fn several_maps_keep_where_you_were_and_what_you_dug() {
    let folder = tempfile::tempdir().unwrap();
    for (name, step) in [("one.png", 3), ("two.png", 40), ("three.png", 90)] {
        let shade = |x: u32, y: u32| Luma([((x * step + y * 7) * 11) as u16]);
        ImageBuffer::from_fn(48, 40, shade).save(folder.path().join(name)).unwrap();
    }
    let paths = ["one.png", "two.png", "three.png"].map(|name| folder.path().join(name).display().to_string());
    let mut window = Window::open(&format!("{} --size 900x640", paths.join(" ")));
    let first = window.settled("the first map", |_| true);
    assert!(window.title().contains("one.png"), "{}", window.title());
    assert!(widget(&first, "2: two.png").is_some(), "the others are listed");

    // Somewhere else, with a crater.
    window.point(620.0, 420.0);
    window.key("c");
    window.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == 1);
    window.key("Prior");
    window.xdo("keydown w");
    window.wait("a flight", |status| camera(status).eye != camera(&first).eye);
    window.xdo("keyup w");
    let left = window.settled("rest", |_| true);

    window.key("ctrl+Tab");
    let second =
        window.settled("the second map", |status| text(&status["scene"]["terrain"]["file"]).ends_with("two.png"));
    assert!(list(&second["scene"]["craters"]["list"]).is_empty(), "its own ground");
    assert_ne!(camera(&second), camera(&left), "its own eye");
    window.key("ctrl+shift+Tab");
    let back =
        window.settled("the first again", |status| text(&status["scene"]["terrain"]["file"]).ends_with("one.png"));
    assert_eq!(camera(&back), camera(&left));
    assert_eq!(back["scene"]["craters"], left["scene"]["craters"]);
    window.key("ctrl+shift+Tab");
    window.settled("around the end", |status| text(&status["scene"]["terrain"]["file"]).ends_with("three.png"));
    // One that is gone meanwhile: a message, and what was there stays.
    fs::remove_file(folder.path().join("two.png")).unwrap();
    window.key("ctrl+shift+Tab");
    let gone = window.settled("a message", |status| told(status, "no such file"));
    assert_eq!(gone["scene"]["terrain"]["file"], paths[2]);
    let recent = fs::read_to_string(window.path("settings/recent.toml")).unwrap();
    assert!(recent.contains("one.png") && recent.contains("three.png") && !recent.contains("two.png"), "{recent}");
    window.close();
}

#[test]
fn files_are_chosen_corrected_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats");
    fs::copy(data.join("special/nan.tif"), at("nan.tif")).unwrap();
    fs::copy(data.join("other/oblong.raw"), at("oblong.raw")).unwrap();
    let mut window = Window::open(&format!("{} --size 900x700", at("nan.tif").display()));
    window.settled("rest", |_| true);
    window.section("Terrain", false);
    window.section("March", false);

    import_card(&mut window, &at("nan.tif"));
    save(&mut window, folder.path());

    cancel(&mut window, folder.path());

    // Our own dialogue: a file without a header, which asks for its layout.
    window.section("Import", false);
    window.key("ctrl+o");
    window.settled("the dialogue", |status| widget(status, "oblong.raw").is_some());
    assert!(labels(&mut window).contains(&"nan.tif".to_owned()));
    window.click("oblong.raw");
    window.settled("a question", |status| widget(status, "Read the file").is_some());
    window.key("Escape");
    window.settled("no question", |status| widget(status, "Read the file").is_none());
    window.key("ctrl+o");
    window.settled("the dialogue", |status| widget(status, "oblong.raw").is_some());
    window.click("oblong.raw");
    window.settled("a question", |status| widget(status, "Read the file").is_some());
    // Too many for its bytes: it asks again, and keeps what was said.
    window.fill_number("Raw columns", "21");
    window.fill_number("Raw rows", "900");
    window.settled("an answer", |status| {
        widget(status, "Read the file").is_some_and(|button| button["disabled"] == false)
    });
    window.click("Read the file");
    window.settled("the question again", |status| {
        widget(status, "Raw rows").is_some_and(|field| field["value"] == "900")
    });
    window.fill_number("Raw rows", "18");
    window.settled("an answer", |status| {
        widget(status, "Read the file").is_some_and(|button| button["disabled"] == false)
    });
    window.click("Read the file");
    window.settled("the raw map", |status| text(&status["scene"]["terrain"]["file"]).ends_with("oblong.raw"));
    // Ctrl+O and Esc: nothing.
    window.click("Open files…");
    window.settled("the dialogue", |status| widget(status, "Do not open").is_some());
    window.key("Escape");
    window.settled("no dialogue", |status| widget(status, "Do not open").is_none());

    // The gallery, and back by the list of open maps.
    window.click("Gallery");
    window.settled("the gallery", |status| widget(status, "Grand Canyon").is_some());
    window.click("Grand Canyon");
    window.settled("the canyon", |status| status["scene"]["terrain"]["file"].is_null());
    assert!(window.title().contains("Grand Canyon"), "{}", window.title());
    window.click("1: nan");
    window.settled("the first map", |status| text(&status["scene"]["terrain"]["file"]).ends_with("nan.tif"));
    window.close();
}

/// Half the distance between samples: applied, then kept.
fn import_card(window: &mut Window, map: &std::path::Path) {
    window.section("Import", true);
    let before = window.settled("rest", |_| true);
    assert_eq!(
        widget(&before, "Apply import").map(|button| &button["disabled"]),
        Some(&true.into()),
        "nothing to apply"
    );
    assert_eq!(widget(&before, "Metres per sample").and_then(|field| field["value"].as_str()), Some("30.0"));
    window.fill_number("Metres per sample", "15");
    window
        .settled("a change", |status| widget(status, "Apply import").is_some_and(|button| button["disabled"] == false));
    window.click("Apply import");
    let applied = window.settled("another proportion", |status| told(status, "Opened"));
    let ratio = camera(&applied).eye.y / camera(&before).eye.y;
    assert!((ratio - 2.0).abs() < 0.2, "the eye stays over the same ground: {ratio}");
    assert!(!map.with_extension("toml").exists(), "nothing is kept without being asked");
    window.click("Keep in a sidecar");
    window.settled("a message", |status| told(status, "Kept in"));
    let loaded = load::load(map).unwrap();
    assert_eq!(loaded.field.extent_metres(), Some([300.0, 255.0]));
}

/// A crater, and the map with it: asked before a file is replaced.
fn save(window: &mut Window, folder: &std::path::Path) {
    let out = folder.join("edited.tif");
    window.click("Save edited map…");
    window.settled("the window", |status| widget(status, "File to save to").is_some());
    window.fill("File to save to", &out.display().to_string());
    window.click("Save the map");
    window.settled("a message", |status| told(status, "Saved"));
    let first = fs::read(&out).unwrap();
    window.key("Home");
    window.settled("the start view", |_| true);
    window.point(560.0, 340.0);
    window.key("c");
    let dug = window.settled("a crater", |status| list(&status["scene"]["craters"]["list"]).len() == 1);
    window.key("ctrl+s");
    window.settled("the window", |status| widget(status, "File to save to").is_some());
    window.fill("File to save to", &out.display().to_string());
    window.click("Save the map");
    window.settled("a question", |status| widget(status, "Replace the file").is_some());
    assert_eq!(fs::read(&out).unwrap(), first, "nothing is replaced before it is allowed");
    window.click("Replace the file");
    window.settled("the new file", |_| fs::read(&out).unwrap() != first);
    let saved = load::load(&out).unwrap();
    assert_eq!(saved.field.extent_metres(), Some([300.0, 255.0]), "{:?}", dug["scene"]["craters"]);
    assert!(saved.field.holes().is_some() && saved.georeference.is_some());
}

/// A pipe that nobody writes to takes for ever to open: once by the button, once by Esc, it is ended.
fn cancel(window: &mut Window, folder: &std::path::Path) {
    let pipe = folder.join("slow.png");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    window.section("Terrain", true);
    let before = window.settled("rest", |_| true);
    for by_key in [false, true] {
        window.fill("Terrain file", &pipe.display().to_string());
        window.key("Return");
        let busy = window.wait("progress", |status| widget(status, "Cancel opening").is_some());
        assert!(busy["says"].as_str().is_some_and(|says| says.contains("slow.png")), "{}", busy["says"]);
        if by_key {
            window.key("Escape");
        } else {
            let [x, y] = centre(widget(&busy, "Cancel opening").unwrap());
            window.point(x, y);
            window.xdo("click 1");
        }
        let after = window.settled("an end", |status| widget(status, "Cancel opening").is_none());
        assert_eq!(after["scene"], before["scene"], "the old terrain stays");
    }
    window.section("Terrain", false);
}
