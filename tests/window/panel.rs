//! Every widget of the panel is used once, from a table: what it is to change, and nothing else.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::harness::{Window, has, list, told, widget};

/// What is done to a widget.
enum Act {
    /// A click on a check box or a button.
    Click,
    /// A click on a slider's rail, at a share of its width.
    Slide(f64),
    /// A number typed into the field, and Enter.
    Number(&'static str),
    /// An entry of a drop-down list.
    Choose(&'static str),
}
use Act::{Choose, Click, Number, Slide};

/// What the ledger has to say afterwards.
enum Then {
    Nothing,
    Def(&'static str),
    NoDef(&'static str),
    Pass(&'static str),
    NoPass(&'static str),
    Pipeline(&'static str),
    Uploads,
}
use Then::{Def, NoDef, NoPass, Nothing, Pass, Pipeline, Uploads};

type Row = (&'static str, Act, &'static str, Then);

const TERRAIN: &[Row] = &[
    ("Height scale", Slide(0.7), "/scene/terrain/height_scale", Nothing),
    ("Height scale value", Number("0.2"), "/scene/terrain/height_scale", Nothing),
    ("True proportion", Click, "/scene/terrain/height_scale", Nothing),
    ("Height scale value", Number("0.1"), "/scene/terrain/height_scale", Nothing),
];

const CAMERA: &[Row] = &[
    ("Eye x", Number("0.5"), "/scene/camera/eye/0", Nothing),
    ("Eye y", Number("0.3"), "/scene/camera/eye/1", Nothing),
    ("Eye z", Number("0.9"), "/scene/camera/eye/2", Nothing),
    ("Yaw", Slide(0.9), "/scene/camera/yaw", Nothing),
    ("Yaw value", Number("10"), "/scene/camera/yaw", Nothing),
    ("Pitch", Slide(0.4), "/scene/camera/pitch", Nothing),
    ("Pitch value", Number("-20"), "/scene/camera/pitch", Nothing),
    ("Field of view", Slide(0.7), "/scene/camera/fov", Nothing),
    ("Field of view value", Number("50"), "/scene/camera/fov", Nothing),
    ("Speed", Slide(0.8), "/speed", Nothing),
    ("Speed value", Number("0.7"), "/speed", Nothing),
    ("Allow below ground", Click, "", Nothing),
    ("Movement", Choose("orbit"), "/mode", Nothing),
    ("Movement", Choose("fly"), "/mode", Nothing),
    ("Over view", Click, "/scene/camera", Nothing),
    ("Graze view", Click, "/scene/camera", Nothing),
    ("Valley view", Click, "/scene/camera", Nothing),
    ("Down view", Click, "/scene/camera", Nothing),
    ("Horizon view", Click, "/scene/camera", Nothing),
    ("Start view", Click, "/scene/camera", Nothing),
    ("Yaw value", Number("33"), "/scene/camera/yaw", Nothing),
];

const MARCH: &[Row] = &[
    ("Technique", Choose("linear"), "/scene/march/technique", Pipeline("terrain linear ")),
    ("Technique", Choose("max-mipmap"), "/scene/march/technique", Pipeline("terrain max-mipmap ")),
    ("Technique", Choose("secant"), "/scene/march/technique", Pipeline("terrain secant ")),
    ("Technique", Choose("cone"), "/scene/march/technique", Pipeline("terrain cone ")),
    ("Technique", Choose("relaxed-cone"), "/scene/march/technique", Pipeline("terrain relaxed-cone ")),
    ("Technique", Choose("linear-binary"), "/scene/march/technique", Pipeline("terrain linear-binary ")),
    ("Fewest samples", Slide(0.4), "/scene/march/samples_min", Nothing),
    ("Fewest samples value", Number("20"), "/scene/march/samples_min", Nothing),
    ("Most samples", Slide(0.5), "/scene/march/samples_max", Nothing),
    ("Most samples value", Number("90"), "/scene/march/samples_max", Nothing),
    ("Halvings", Slide(0.6), "/scene/march/binary_steps", Nothing),
    ("Halvings value", Number("3"), "/scene/march/binary_steps", Nothing),
    ("Height filter", Choose("hardware-linear"), "/scene/march/filter", Def("FILTER_HARDWARE_LINEAR")),
    ("Height filter", Choose("nearest"), "/scene/march/filter", Def("FILTER_NEAREST")),
    ("Height filter", Choose("exact"), "/scene/march/filter", NoDef("FILTER_NEAREST")),
    ("Steps by angle", Click, "/scene/march/steps_by_angle", NoDef("STEPS_BY_ANGLE")),
    ("Lower start", Click, "/scene/march/lower_start", NoDef("LOWER_START")),
    ("Discard misses", Click, "/scene/march/discard_misses", NoDef("DISCARD_MISSES")),
];

const COMPARE: &[Row] = &[
    ("Enable compare", Click, "/scene/compare/enabled", Pass("compare")),
    ("Compare with", Choose("linear"), "/scene/compare/technique", Pipeline("terrain linear ")),
    ("Split", Slide(0.7), "/scene/compare/share", Nothing),
    ("Split value", Number("0.6"), "/scene/compare/share", Nothing),
];

const DIFFUSE: &[Row] = &[
    ("Repeats", Slide(0.5), "/scene/diffuse/repeats", Nothing),
    ("Repeats value", Number("4"), "/scene/diffuse/repeats", Nothing),
    ("Apply diffuse image", Click, "/scene/diffuse/file", Uploads),
    ("Generated texture", Click, "/scene/diffuse/file", Uploads),
    ("Enable diffuse texture", Click, "/scene/diffuse/enabled", NoDef("DIFFUSE_TEXTURE")),
];

const LIGHTING: &[Row] = &[
    ("Sun azimuth", Slide(0.3), "/scene/lighting/sun_azimuth", Nothing),
    ("Sun azimuth value", Number("200"), "/scene/lighting/sun_azimuth", Nothing),
    ("Sun elevation", Slide(0.7), "/scene/lighting/sun_elevation", Nothing),
    ("Sun elevation value", Number("60"), "/scene/lighting/sun_elevation", Nothing),
    ("Ambient", Slide(0.5), "/scene/lighting/ambient", Nothing),
    ("Ambient value", Number("0.1"), "/scene/lighting/ambient", Nothing),
    ("Diffuse light", Slide(0.2), "/scene/lighting/diffuse", Nothing),
    ("Diffuse light value", Number("0.6"), "/scene/lighting/diffuse", Nothing),
    ("Specular", Slide(0.5), "/scene/lighting/specular", Nothing),
    ("Specular value", Number("0.4"), "/scene/lighting/specular", Nothing),
    ("Shininess", Slide(0.2), "/scene/lighting/shininess", Nothing),
    ("Shininess value", Number("50"), "/scene/lighting/shininess", Nothing),
    ("Enable lighting", Click, "/scene/lighting/enabled", NoDef("LIGHTING")),
];

const LAND: &[Row] = &[
    ("Contours", Click, "/scene/land/contours", Def("LAND_CONTOURS")),
    ("Contour interval", Slide(0.7), "/scene/land/contour_interval", Nothing),
    ("Contour interval value", Number("50"), "/scene/land/contour_interval", Nothing),
    ("Automatic interval", Click, "/scene/land/contour_interval", Nothing),
    ("Contour width", Slide(0.5), "/scene/land/contour_width", Nothing),
    ("Contour width value", Number("2"), "/scene/land/contour_width", Nothing),
    ("Ground colour", Choose("slope"), "/scene/land/colour", Def("LAND_SLOPE")),
    ("Steepest slope", Slide(0.3), "/scene/land/slope_max", Nothing),
    ("Steepest slope value", Number("40"), "/scene/land/slope_max", Nothing),
    ("Ground colour", Choose("aspect"), "/scene/land/colour", Def("LAND_ASPECT")),
    ("Ground colour", Choose("ramp"), "/scene/land/colour", Def("LAND_RAMP")),
    ("Ramp", Choose("batlow"), "/scene/land/ramp", Uploads),
    ("Ramp", Choose("viridis"), "/scene/land/ramp", Uploads),
    ("Ramp", Choose("cividis"), "/scene/land/ramp", Uploads),
    ("Ramp", Choose("hypsometric"), "/scene/land/ramp", Uploads),
    ("Ramp", Choose("riaboy-2003"), "/scene/land/ramp", Uploads),
    ("Ramp", Choose("grey"), "/scene/land/ramp", Uploads),
    ("Ramp", Choose("oleron"), "/scene/land/ramp", Uploads),
    ("Ramp low", Slide(0.2), "/scene/land/low", Nothing),
    ("Ramp low value", Number("600"), "/scene/land/low", Nothing),
    ("Ramp high", Slide(0.8), "/scene/land/high", Nothing),
    ("Ramp high value", Number("2000"), "/scene/land/high", Nothing),
    ("Whole range", Click, "/scene/land", Nothing),
    ("Hillshade", Choose("sun"), "/scene/land/hillshade", Def("HILLSHADE")),
    ("Hillshade", Choose("multidirectional"), "/scene/land/hillshade", Def("HILLSHADE_MULTIDIRECTIONAL")),
    ("Hillshade strength", Slide(0.5), "/scene/land/hillshade_strength", Nothing),
    ("Hillshade strength value", Number("0.4"), "/scene/land/hillshade_strength", Nothing),
    ("Hillshade", Choose("off"), "/scene/land/hillshade", NoDef("HILLSHADE")),
    ("Ground colour", Choose("texture"), "/scene/land/colour", NoDef("LAND_RAMP")),
    ("Probe", Click, "", Nothing),
    ("Measure", Click, "/reading/measuring", Nothing),
];

const SKYBOX: &[Row] = &[
    ("Flattening", Slide(0.5), "/scene/skybox/flattening", Nothing),
    ("Flattening value", Number("3"), "/scene/skybox/flattening", Nothing),
    ("Sky model", Choose("physical"), "/scene/skybox/model", Def("SKY_LIGHT")),
    ("Turbidity", Slide(0.5), "/scene/skybox/turbidity", Uploads),
    ("Turbidity value", Number("4"), "/scene/skybox/turbidity", Uploads),
    ("Apply sky faces", Click, "/scene/skybox/faces", Uploads),
    ("Procedural sky", Click, "/scene/skybox/faces", Uploads),
    ("Enable skybox", Click, "/scene/skybox/enabled", NoPass("skybox")),
];

const SUN: &[Row] = &[
    ("Shadows", Choose("soft"), "/scene/lighting/shadows", Def("SOFT_SHADOWS")),
    ("Follow the clock", Click, "/scene/lighting/clock/enabled", Uploads),
    ("Hour", Slide(0.8), "/scene/lighting/clock/hour", Uploads),
    ("Hour value", Number("19"), "/scene/lighting/clock/hour", Uploads),
    ("Month", Slide(0.2), "/scene/lighting/clock/month", Nothing),
    ("Month value", Number("4"), "/scene/lighting/clock/month", Nothing),
    ("Day", Slide(0.2), "/scene/lighting/clock/day", Nothing),
    ("Day value", Number("9"), "/scene/lighting/clock/day", Nothing),
    ("Year", Slide(0.2), "/scene/lighting/clock/year", Nothing),
    ("Year value", Number("1999"), "/scene/lighting/clock/year", Nothing),
    ("Latitude", Slide(0.7), "/scene/lighting/clock/latitude", Nothing),
    ("Latitude value", Number("40"), "/scene/lighting/clock/latitude", Nothing),
    ("Longitude", Slide(0.2), "/scene/lighting/clock/longitude", Nothing),
    ("Longitude value", Number("-100"), "/scene/lighting/clock/longitude", Nothing),
    // Last: the ledger is that of the last frame, and a light map takes some of them.
    ("Bake shadows", Click, "/scene/lighting/baked", Def("BAKED_SHADOWS")),
    ("Ambient occlusion", Click, "/scene/lighting/occlusion", Def("OCCLUSION")),
];

const OCCLUDER: &[Row] = &[
    ("Enable occluder", Click, "/scene/occluder/enabled", Pass("occluder")),
    ("Occluder x", Slide(0.6), "/scene/occluder/position", Nothing),
    ("Occluder x value", Number("0.4"), "/scene/occluder/position/0", Nothing),
    ("Occluder y", Slide(0.3), "/scene/occluder/position/1", Nothing),
    ("Occluder y value", Number("0.1"), "/scene/occluder/position/1", Nothing),
    ("Occluder z", Slide(0.6), "/scene/occluder/position/2", Nothing),
    ("Occluder z value", Number("0.4"), "/scene/occluder/position/2", Pass("occluder")),
    ("Occluder size", Slide(0.6), "/scene/occluder/size", Nothing),
    ("Occluder size value", Number("0.1"), "/scene/occluder/size", Nothing),
    ("Occluder yaw", Slide(0.5), "/scene/occluder/rotation/0", Nothing),
    ("Occluder yaw value", Number("45"), "/scene/occluder/rotation/0", Nothing),
    ("Occluder pitch", Slide(0.5), "/scene/occluder/rotation/1", Nothing),
    ("Occluder pitch value", Number("45"), "/scene/occluder/rotation/1", Nothing),
    ("Occluder roll", Slide(0.5), "/scene/occluder/rotation/2", Nothing),
    ("Occluder roll value", Number("45"), "/scene/occluder/rotation/2", Nothing),
];

const CRATERS: &[Row] = &[
    ("Undo crater", Click, "/scene/craters/list", Uploads),
    ("Clear all craters", Click, "/scene/craters/list", Uploads),
    ("Crater radius", Slide(0.6), "/scene/craters/radius", Nothing),
    ("Crater radius value", Number("0.1"), "/scene/craters/radius", Nothing),
    ("Crater depth", Slide(0.6), "/scene/craters/depth", Nothing),
    ("Crater depth value", Number("0.2"), "/scene/craters/depth", Nothing),
    ("Crater rim", Slide(0.6), "/scene/craters/rim", Nothing),
    ("Crater rim value", Number("0.2"), "/scene/craters/rim", Nothing),
    ("Crater mode", Choose("layered"), "/scene/craters/mode", Nothing),
    ("Layer resolution", Slide(0.4), "/scene/craters/layer_resolution", Nothing),
    ("Layer resolution value", Number("300"), "/scene/craters/layer_resolution", Nothing),
    ("Crater mode", Choose("baked"), "/scene/craters/mode", Nothing),
];

const DEBUG: &[Row] = &[
    ("Debug view", Choose("position"), "/scene/debug/view", Def("VIEW_POSITION")),
    ("Debug view", Choose("error"), "/scene/debug/view", Def("VIEW_ERROR")),
    ("Debug view", Choose("normals"), "/scene/debug/view", Def("VIEW_NORMALS")),
    ("Debug view", Choose("distance"), "/scene/debug/view", Def("VIEW_DISTANCE")),
    ("Debug view", Choose("none"), "/scene/debug/view", Def("SHADED")),
    ("Debug view", Choose("steps"), "/scene/debug/view", Def("VIEW_STEPS")),
    ("Heat map maximum", Slide(0.5), "/scene/debug/heat_map_max", Nothing),
    ("Heat map maximum value", Number("20"), "/scene/debug/heat_map_max", Nothing),
    ("Wireframe", Click, "/scene/debug/wireframe", Pass("wireframe")),
];

const FRAME: &[Row] = &[
    ("Vsync", Click, "", Nothing),
    ("Frame limit", Slide(0.5), "", Nothing),
    ("Frame limit value", Number("60"), "", Nothing),
    ("Show overlay", Click, "/overlay", Nothing),
    ("Measure steps", Click, "/steps", Nothing),
    ("Legend in pictures", Click, "/scene/saved/legend", Nothing),
];

/// Sections, their rows, what their reset button is called, and the part of the scene it restores.
const SECTIONS: [(&str, &[Row], &str, &str); 13] = [
    ("Terrain", TERRAIN, "Reset terrain", "/terrain"),
    ("Camera", CAMERA, "Reset camera", "/camera"),
    ("March", MARCH, "Reset march", "/march"),
    ("Compare", COMPARE, "Reset compare", "/compare"),
    ("Diffuse", DIFFUSE, "Reset diffuse", "/diffuse"),
    ("Lighting", LIGHTING, "Reset lighting", "/lighting"),
    ("Land", LAND, "Reset land", "/land"),
    ("Skybox", SKYBOX, "Reset skybox", "/skybox"),
    ("Sun", SUN, "Reset sun", "/lighting"),
    ("Occluder", OCCLUDER, "Reset occluder", "/occluder"),
    ("Craters", CRATERS, "Reset craters", "/craters"),
    ("Debug", DEBUG, "Reset debug", "/debug"),
    ("Frame", FRAME, "Reset frame", "/saved"),
];

/// Widgets that are used outside the table, and where.
const ELSEWHERE: &[(&str, &str)] = &[
    ("Materials", "used by the panel's own tests, by name, as is all in it"),
    ("Water", "the same; moved by the test of idling"),
    ("Air", "the kittest of the panel; its effect, in the toggles of the air"),
    ("Clouds", "the kittest of the panel; its effect, in the toggles of the air"),
    ("smooth", "the technique: drawn by tests/smooth.rs"),
    ("fractal", "the technique: drawn by tests/fractal.rs"),
    ("Detail strength", "in use with fractal alone: the panel's own tests, by name"),
    ("Detail strength value", "the same"),
    ("hard", "shadows: chosen by key, and by the panel's own tests"),
    ("painted", "the sky of every other test"),
    ("Target x", "typed in by the panel's own tests, by name"),
    ("Target y", "the same"),
    ("Target z", "the same"),
    ("Bookmarks", "used by the panel's own tests, and by keys in the test of moving"),
    ("Camera path", "the same"),
    ("Interface", "the same, and by the test of what is kept"),
    ("Keys", "the same"),
    ("Vertical exaggeration", "the test of reading the land types its number"),
    ("Vertical exaggeration value", "typed in by the test of reading the land"),
    ("Imagery file", "the canyon does not say where it lies: toggles/land.rs draws pictures where they belong"),
    ("Apply imagery", "the same"),
    ("Remove imagery", "the same"),
    ("Imagery opacity", "the same"),
    ("Imagery opacity value", "the same"),
    ("Export profile", "pressed by the test of reading the land"),
    ("End measuring", "Esc and the section's check box do the same"),
    ("Files", "used by the test of files, as is all in it"),
    ("Open files…", "pressed by the test of files"),
    ("Save edited map…", "pressed by the test of files"),
    ("Gallery", "opened by the test of files"),
    ("Generate", "used by the test of generating, and by the panel's own tests, by name"),
    ("Import", "used by the test of files, as is all in it"),
    ("Tradeoff", "opened by the test of comparing, and below"),
    ("Measure techniques", "pressed by the test of comparing"),
    ("Reset tradeoff", "pressed by the test of comparing"),
    ("Ledger", "a section without controls; opened below"),
    ("Terrain file", "typed in by the test of typing"),
    ("Open terrain", "pressed by the test of typing"),
    ("Diffuse image", "filled in below, before its button"),
    ("Spin", "the rail is not dragged: a turning cube never settles"),
    ("Spin value", "typed in by the test of idling, which spins and stops"),
    ("Clock speed", "the rail is not dragged: a running clock never settles"),
    ("Clock speed value", "typed in by the test of idling, which lets the clock run and stops it"),
    ("Show help", "used below: the help's window brings a widget of its own"),
    ("Close window", "the help's own, used below"),
];

/// The fields of the sky's faces, filled in below before their button.
const FACES: [&str; 6] = ["+x (east)", "−x (west)", "+y (up)", "−y (down)", "+z (south)", "−z (north)"];

/// The paths of all leaves in which two values differ.
fn differences(a: &Value, b: &Value, path: &str) -> Vec<String> {
    match (a, b) {
        (Value::Object(x), Value::Object(y)) => {
            let keys: BTreeSet<&String> = x.keys().chain(y.keys()).collect();
            keys.into_iter().flat_map(|key| differences(&a[key], &b[key], &format!("{path}/{key}"))).collect()
        }
        (Value::Array(x), Value::Array(y)) if x.len() == y.len() => {
            (0..x.len()).flat_map(|index| differences(&x[index], &y[index], &format!("{path}/{index}"))).collect()
        }
        _ if a == b => Vec::new(),
        _ => vec![path.to_owned()],
    }
}

/// A widget's own state.
fn state(status: &Value, label: &str) -> Option<(Value, Value)> {
    widget(status, label).map(|widget| (widget["toggled"].clone(), widget["value"].clone()))
}

#[track_caller]
fn use_widget(window: &mut Window, (label, act, path, then): &Row) {
    let before = window.settled("rest", |_| true);
    let acted = |status: &Value| {
        let got = status.pointer(path).and_then(Value::as_f64);
        match act {
            _ if path.is_empty() => state(status, label) != state(&before, label),
            // The number is read with every digit, so the first change is not the last.
            Number(typed) => got.is_some_and(|got| (got - typed.parse::<f64>().unwrap()).abs() < 1e-6),
            _ => status.pointer(path) != before.pointer(path),
        }
    };
    match act {
        Click => window.click(label),
        Slide(share) => window.slide(label, *share, acted),
        Number(number) => window.fill_number(label, number),
        Choose(entry) => {
            window.click(label);
            window.settled("an open list", |status| widget(status, entry).is_some());
            window.click(entry);
        }
    }
    let after = window.settled(&format!("{label} to have an effect"), acted);
    let changed = differences(&before["scene"], &after["scene"], "/scene");
    let wanted = if path.starts_with("/scene") { *path } else { "nothing" };
    assert!(changed.iter().all(|change| change.starts_with(wanted)), "{label} is to change {wanted}, not {changed:?}");
    let ledger = &after["ledger"];
    let fits = match then {
        Nothing => true,
        Def(def) => has(&ledger["shader_defs"], def),
        NoDef(def) => !has(&ledger["shader_defs"], def) && has(&before["ledger"]["shader_defs"], def),
        Pass(pass) => has(&ledger["passes"], pass),
        NoPass(pass) => !has(&ledger["passes"], pass) && has(&before["ledger"]["passes"], pass),
        Pipeline(name) => {
            list(&ledger["pipelines"]).iter().any(|pipeline| pipeline.as_str().unwrap().starts_with(name))
        }
        Uploads => ledger["uploaded_bytes"].as_u64() > Some(0),
    };
    assert!(fits, "{label}: the ledger was {}\nand is {ledger}", before["ledger"]);
}

#[test]
fn every_widget_changes_what_it_should_and_only_that() {
    let mut window = Window::open("--size 780x660");
    let start = window.settled("rest", |_| true);
    // A crater or two for the buttons that take them back.
    for x in [540.0, 640.0] {
        window.point(x, 420.0);
        window.key("c");
        window.settled("a crater", |status| !list(&status["scene"]["craters"]["list"]).is_empty());
    }
    window.settled("two craters", |status| list(&status["scene"]["craters"]["list"]).len() == 2);
    image::RgbImage::from_pixel(8, 8, image::Rgb([90, 140, 60])).save(window.path("green.png")).unwrap();
    let image = window.path("green.png").display().to_string();

    window.section("Terrain", false);
    window.section("March", false);
    let mut used: BTreeSet<String> = BTreeSet::new();
    for (section, rows, reset, part) in SECTIONS {
        window.section(section, true);
        match section {
            "Diffuse" => window.fill("Diffuse image", &image),
            "Skybox" => FACES.iter().for_each(|face| window.fill(&format!("Sky face {face}"), &image)),
            _ => {}
        }
        for row in rows {
            use_widget(&mut window, row);
            used.insert(row.0.into());
            if let Choose(entry) = row.1 {
                used.insert(entry.into());
            }
        }
        restore(&mut window, &start, reset, part);
        used.extend([section.to_owned(), reset.to_owned()]);
        if section == "Frame" {
            windows_and_files(&mut window);
            used.extend(["Take screenshot", "Full screen"].map(str::to_owned));
        }
        window.section(section, false);
    }
    window.section("Tradeoff", true);
    window.section("Ledger", true);

    used.extend(ELSEWHERE.iter().map(|(label, _)| (*label).to_owned()));
    used.extend(FACES.map(|face| format!("Sky face {face}")));
    let seen = window.labels();
    // The help's title bar, by which it is moved, is an unnamed part of egui's window and no widget.
    let missed: Vec<_> = seen.difference(&used).filter(|label| !label.starts_with("a nameless Unknown at")).collect();
    assert!(missed.is_empty(), "the table leaves out {missed:?}");
    let gone: Vec<_> = used.difference(&seen).collect();
    assert!(gone.is_empty(), "the table has what the panel has not: {gone:?}");
    window.close();
}

/// Presses a section's reset button and compares with the start.
#[track_caller]
fn restore(window: &mut Window, start: &Value, reset: &str, part: &str) {
    let was = |status: &Value| {
        let (now, before) = (status["scene"].pointer(part), start["scene"].pointer(part));
        // A number that went through the file may differ in its last digit.
        let close = |path: &String| {
            let at = |value: &Value| value.pointer(path).and_then(Value::as_f64);
            let whole = |value: Option<&Value>| value.cloned().unwrap_or_default();
            at(&whole(now)).zip(at(&whole(before))).is_some_and(|(a, b)| (a - b).abs() < 1e-9)
        };
        match (now, before) {
            (Some(now), Some(before)) => differences(now, before, "").iter().all(close),
            (now, before) => now == before,
        }
    };
    window.click(reset);
    window.settled(reset, |status| {
        was(status) && (!part.is_empty() || state(status, "Vsync") == Some((Value::Bool(true), Value::Null)))
    });
}

/// The buttons of the section Frame that reach beyond the panel.
fn windows_and_files(window: &mut Window) {
    window.click("Show help");
    window.settled("the help", |status| status["help"] == true);
    window.click("Close window");
    window.settled("no help", |status| status["help"] == false);
    window.click("Take screenshot");
    window.settled("a screenshot", |status| told(status, "relief-0001.png"));
    // Whether the window fills the screen is up to a window manager, and there is none.
    window.click("Full screen");
    window.settled("an answer", |_| true);
    window.click("Full screen");
    window.settled("the window again", |status| status["full_screen"] == false);
}
