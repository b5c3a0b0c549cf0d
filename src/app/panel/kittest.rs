//! The panel by its names, as a screen reader or a tester finds it: every control of every section is used, whoever added it.

use std::collections::BTreeSet;
use std::sync::Arc;

use egui::accesskit::{Action as Access, ActionData, ActionRequest, Role};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::*;
use crate::app::files::maps::Source;
use crate::camera::NamedView;
use crate::heightfield::HeightField;
use crate::heightfield::generate::{Kind, Recipe};
use crate::heightfield::import::ImportOptions;
use crate::scene::light::{Shadows, SkyModel};
use crate::scene::{ColourSource, CraterMode, DebugView, GroundColour, Hillshade, Technique};

/// What the panel works on.
struct State {
    scene: Scene,
    view: ViewSettings,
    speed: f64,
    facts: Facts,
    tradeoff: Tradeoff,
    files: Files,
    commands: Vec<Command>,
}

impl State {
    /// All that a control can change, as text.
    fn print(&self) -> String {
        format!("{:?} {:?} {} {:?} {:?}", self.scene, self.view, self.speed, self.files, self.commands)
    }

    /// A state in which as little as possible is greyed out.
    fn new() -> Self {
        let map = Arc::new(HeightField::from_raw(3, 3, &[0.0_f32, 0.5, 1.0, 0.2, 0.7, 0.1, 0.9, 0.4, 0.6]).unwrap());
        let mut scene = Scene { camera: Some(NamedView::Start.camera(&map, map.box_size(None))), ..Scene::default() };
        scene.march.technique = Technique::LinearBinary;
        scene.compare.enabled = true;
        scene.occluder.enabled = true;
        scene.craters.mode = CraterMode::Layered;
        scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
        scene.diffuse.file = Some("a.png".into());
        scene.skybox.faces = Some(["a", "b", "c", "d", "e", "f"].map(Into::into));
        scene.terrain.height_scale = Some(0.31);
        scene.debug.view = DebugView::Steps;
        let mut view = ViewSettings::default();
        view.bookmarks.extend((1..=9).map(|digit: u32| (digit.to_string(), scene.camera.unwrap())));
        for x in [0.0, 1.0, 2.0] {
            let mut camera = scene.camera.unwrap();
            camera.eye.x = x;
            view.path.path.push(camera);
        }
        view.paths.terrain = "b.png".into();
        view.paths.diffuse = "b.png".into();
        view.paths.faces = ["1", "2", "3", "4", "5", "6"].map(Into::into);
        let facts = tests::facts(&map);
        Self {
            scene,
            view,
            speed: 0.3,
            facts,
            tradeoff: Tradeoff::default(),
            files: Files::default(),
            commands: Vec::new(),
        }
    }
}

fn harness(section: Section) -> Harness<'static, State> {
    harness_in(section, STATES[0])
}

/// The section, opened, in a state that `change` has made of the usual one.
fn harness_in(section: Section, change: fn(&mut State)) -> Harness<'static, State> {
    let mut state = State::new();
    change(&mut state);
    let mut harness = Harness::builder().with_size(egui::vec2(700.0, 3000.0)).build_ui_state(
        move |ui, state: &mut State| {
            let State { scene, view, speed, facts, tradeoff, files, commands } = state;
            (section.1)(ui, &mut Panel { scene, view, speed, facts, tradeoff, files, commands });
        },
        state,
    );
    harness.run_steps(2);
    // A section that is closed is opened by its header, by name.
    let before = controls(&harness).len();
    for _ in 0..2 {
        if controls(&harness).len() > before {
            break;
        }
        harness.get_by_role_and_label(Role::DisclosureTriangle, section.0).click();
        harness.run_steps(30);
    }
    harness
}

/// What a screen reader asks of a control.
fn ask(harness: &mut Harness<'_, State>, (role, name): (Role, &str), action: Access, data: Option<ActionData>) {
    let (target_node, target_tree) = harness.get_by_role_and_label(role, name).accesskit_node().locate();
    harness.event(egui::Event::AccessKitActionRequest(ActionRequest { target_node, target_tree, action, data }));
}

/// The controls of a section: role, name, and whether it is greyed out.
fn controls(harness: &Harness<'_, State>) -> Vec<(Role, String, bool)> {
    let nodes = harness.root().children_recursive();
    let of = |role: Role| {
        matches!(
            role,
            Role::Button | Role::CheckBox | Role::ComboBox | Role::Slider | Role::SpinButton | Role::TextInput
        )
    };
    nodes
        .filter(|node| of(node.accesskit_node().role()))
        .map(|node| {
            let node = node.accesskit_node();
            (node.role(), node.label().unwrap_or_default(), node.is_disabled())
        })
        .collect()
}

/// Uses a control in the way of its kind. False where that changed nothing.
fn use_control(harness: &mut Harness<'_, State>, role: Role, name: &str) -> bool {
    let before = harness.state().print();
    match role {
        Role::Slider | Role::SpinButton => {
            for access in [Access::Increment, Access::Decrement] {
                ask(harness, (role, name), access, None);
                harness.run_steps(3);
                if harness.state().print() != before {
                    return true;
                }
            }
        }
        Role::TextInput => {
            harness.get_by_role_and_label(role, name).focus();
            harness.run_steps(2);
            harness.get_by_role_and_label(role, name).type_text("x");
        }
        Role::ComboBox => {
            let closed: BTreeSet<String> = controls(harness).into_iter().map(|(_, name, _)| name).collect();
            harness.get_by_role_and_label(role, name).click();
            harness.run_steps(6);
            let choices: Vec<String> =
                controls(harness).into_iter().filter(|(_, _, off)| !off).map(|(_, name, _)| name).collect();
            for choice in choices.iter().filter(|choice| !closed.contains(*choice)) {
                if harness.state().print() != before {
                    return true;
                }
                // What was chosen already has closed the list.
                if harness.query_by_label(choice).is_none() {
                    harness.get_by_role_and_label(role, name).click();
                    harness.run_steps(6);
                }
                if let Some(node) = harness.query_by_label(choice) {
                    node.click();
                }
                harness.run_steps(6);
            }
        }
        _ => {
            let closed = controls(harness).len();
            harness.get_by_role_and_label(role, name).click();
            harness.run_steps(6);
            // A menu has opened.
            if controls(harness).len() > closed {
                return true;
            }
        }
    }
    harness.run_steps(6);
    harness.state().print() != before
}

/// What is greyed out in every state of the test, and why.
const OFF: [(&str, &str); 9] = [
    ("Apply imagery", "the test's map does not say where it lies; toggles/land.rs puts pictures in their places"),
    ("Levels in", "its entry metres only: the test's map knows none"),
    ("Water level in", "the same"),
    ("True proportion", "the test's map has no extent"),
    ("Height filter", "its entry hardware-linear only: the test's adapter filters nothing"),
    ("Cancel animation", "nothing is being written"),
    ("Apply import", "nothing of how the map was read is corrected; the window's test of files does"),
    ("Revert import", "the same"),
    ("Keep in a sidecar", "the test's map is no file; the window's test of files has one"),
];

/// States that differ in what they grey out.
const STATES: [fn(&mut State); 3] = [
    |state| state.view.generate.recipe = Recipe::new(Kind::DiamondSquare, 5),
    |state| {
        // A made landscape, whole and with rain, that is also being made.
        let mut recipe = Recipe { size: [3; 2], octaves: Some(6), ..Recipe::new(Kind::Ridged, 5) };
        (recipe.hydraulic.drops, recipe.thermal.iterations) = (0.5, 10);
        let made = Source::Made(Box::new(recipe.clone()));
        let index = state.files.maps.add(made, ImportOptions::default());
        state.files.maps.arrive(index, "made");
        (state.view.generate.recipe, state.view.generate.share) = (recipe, Some(0.5));
        let land = &mut state.scene.land;
        (land.colour, land.low, land.high) = (GroundColour::Ramp, Some(0.1), Some(0.8));
        (land.contours, land.contour_interval, land.hillshade) = (true, Some(0.1), Hillshade::Sun);
        land.imagery = Some("a.tif".into());
        state.view.paths.imagery = "b.tif".into();
        state.scene.lighting.clock.enabled = true;
        state.scene.skybox.faces = None;
        state.scene.skybox.model = SkyModel::Physical;
    },
    |state| {
        state.scene.march.technique = Technique::Fractal;
        state.view.generate.recipe = Recipe::new(Kind::Warped, 5);
        state.scene.land.colour = GroundColour::Slope;
        state.scene.diffuse.source = ColourSource::Materials;
        state.scene.materials.coverage = vec!["a.png".into()];
        state.view.paths.coverage = "b.png".into();
        state.scene.lighting.shadows = Shadows::Hard;
        (state.scene.water.enabled, state.scene.water.level) = (true, Some(0.6));
        (state.scene.air.perspective, state.scene.air.fog, state.scene.flare.enabled) = (true, true, true);
        (state.scene.clouds.enabled, state.scene.clouds.shadows) = (true, true);
        state.scene.clouds.layers.pop();
    },
];

/// Each control is found by its name, and does something in some state; one without a name, or that does nothing, or is always
/// greyed out, fails the test.
#[test]
fn every_control_of_every_section_has_a_name_and_does_something() {
    let mut all = Vec::new();
    for section in SECTIONS {
        let (mut seen, mut used) = (BTreeSet::new(), BTreeSet::new());
        for state in STATES {
            for (role, name, off) in controls(&harness_in(section, state)) {
                assert!(!name.trim().is_empty(), "a nameless {role:?} in {}", section.0);
                seen.insert(name.clone());
                if off || used.contains(&name) {
                    continue;
                }
                // A reset of what is as it should be already does nothing, and need not.
                if use_control(&mut harness_in(section, state), role, &name) || name.starts_with("Reset ") {
                    used.insert(name);
                }
            }
        }
        let idle = seen.difference(&used).filter(|name| OFF.iter().all(|(excused, _)| excused != name));
        all.extend(idle.map(|name| format!("{name} of {}", section.0)));
    }
    assert!(all.is_empty(), "these do nothing, or are greyed out in every state: {all:?}");
}

/// Whoever has no mouse gets to every control that is not greyed out: Tab walks through all of a section.
#[test]
fn tab_walks_through_every_control() {
    for section in SECTIONS {
        for state in STATES {
            let mut harness = harness_in(section, state);
            let wanted: BTreeSet<_> =
                controls(&harness).into_iter().filter(|(.., off)| !off).map(|(_, name, _)| name).collect();
            let mut reached = BTreeSet::new();
            // A slider is two stops, its bar and its number; the header is one.
            for _ in 0..2 * controls(&harness).len() + 2 {
                harness.key_press(egui::Key::Tab);
                harness.run_steps(1);
                let mut nodes = harness.root().children_recursive();
                let focused = nodes.find(|node| node.accesskit_node().is_focused());
                reached.extend(focused.and_then(|node| node.accesskit_node().label()));
            }
            let missed: Vec<_> = wanted.difference(&reached).collect();
            assert!(missed.is_empty(), "Tab does not get to {missed:?} in {}", section.0);
        }
    }
}

#[test]
fn a_key_is_chosen_by_name_and_a_taken_one_is_said_to_be() {
    let keys = *SECTIONS.iter().find(|section| section.0 == "Keys").unwrap();
    let mut harness = harness(keys);
    harness.get_by_label("Key for crater").click();
    harness.run_steps(3);
    assert_eq!(harness.state().view.rebinding, Some(crate::app::actions::Action::Crater));
    assert_eq!(harness.get_by_label("Key for crater").accesskit_node().role(), Role::Button);
    harness.state_mut().view.refused = Some((crate::app::actions::Action::Crater, "F1 already does this".into()));
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("F1 already does this").is_some(), "the reason is text, not colour alone");
}

#[test]
fn a_target_that_is_typed_is_looked_at_and_stays_what_was_typed() {
    let section = *SECTIONS.iter().find(|section| section.0 == "Camera").unwrap();
    let mut harness = harness(section);
    for (name, value) in [("Target x", 0.9), ("Target y", 0.6), ("Target z", 0.1)] {
        ask(&mut harness, (Role::SpinButton, name), Access::SetValue, Some(ActionData::NumericValue(value)));
        harness.run_steps(3);
    }
    let camera = harness.state().scene.camera.unwrap();
    let wanted = (glam::DVec3::new(0.9, 0.6, 0.1) - camera.eye).normalize();
    assert!(camera.basis().forward.distance(wanted) < 1e-6, "{camera:?}");
}

/// What the command line says of a picture is said beside its path, too: why one is not shown, and what is doubtful about the
/// one that is.
#[test]
fn doubts_about_images_stand_beside_their_paths() {
    let section = |name: &str| *SECTIONS.iter().find(|section| section.0 == name).unwrap();
    let says = |section: Section, words: &str, change: fn(&mut State)| {
        harness_in(section, change).query_by_label_contains(words).is_some()
    };
    let refuse: fn(&mut State) = |state| {
        state.view.paths.imagery = " photo.tif ".into();
        state.view.paths.diffuse = "photo.tif".into();
        state.facts.images.refused = Some(("photo.tif".into(), "its reference system is not the map's".into()));
    };
    let other: fn(&mut State) = |state| {
        state.view.paths.imagery = "another.tif".into();
        state.view.paths.diffuse = "another.tif".into();
        state.facts.images.refused = Some(("photo.tif".into(), "its reference system is not the map's".into()));
    };
    for name in ["Land", "Diffuse"] {
        assert!(says(section(name), "its reference system is not the map's", refuse), "{name}");
        assert!(!says(section(name), "its reference system is not the map's", other), "{name} says it of another one");
    }
    let doubt: fn(&mut State) = |state| {
        state.scene.land.imagery = Some("photo.tif".into());
        state.facts.images.doubts = vec!["it covers about 30 % of the map".into()];
    };
    let removed: fn(&mut State) = |state| state.facts.images.doubts = vec!["it covers about 30 % of the map".into()];
    assert!(says(section("Land"), "it covers about 30 % of the map", doubt));
    assert!(!says(section("Land"), "it covers about 30 % of the map", removed));
}
