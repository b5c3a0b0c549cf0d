//! The panel: one collapsible section per part of the scene, one file each, named alike.

mod air;
mod bookmarks;
mod camera;
mod clouds;
mod compare;
mod craters;
mod debug;
mod diffuse;
mod files;
mod frame;
mod generate;
pub(crate) mod import;
mod interface;
mod keys;
mod land;
mod ledger;
mod lighting;
mod march;
mod materials;
mod occluder;
mod path;
mod skybox;
mod sun;
mod terrain;
mod tradeoff;
mod water;
mod widgets;

use super::files::Files;
use super::settings::{Command, Facts, ViewSettings};
use super::tradeoff::Tradeoff;
use crate::scene::Scene;

/// Width of the panel in points.
const WIDTH: f32 = 340.0;

/// What the sections read and change.
pub(crate) struct Panel<'a> {
    /// What is drawn.
    pub(crate) scene: &'a mut Scene,
    /// The viewer's own settings.
    pub(crate) view: &'a mut ViewSettings,
    /// Base speed of the eye in map widths per second.
    pub(crate) speed: &'a mut f64,
    /// What cannot be changed.
    pub(crate) facts: &'a Facts,
    /// What was measured of the techniques.
    pub(crate) tradeoff: &'a Tradeoff,
    /// The open maps, and how they are read.
    pub(crate) files: &'a mut Files,
    /// What the sections ask of the viewer.
    pub(crate) commands: &'a mut Vec<Command>,
}

/// A section's title and what draws it.
type Section = (&'static str, fn(&mut egui::Ui, &mut Panel<'_>));

/// All sections from top to bottom.
const SECTIONS: [Section; 26] = [
    ("Files", files::show),
    ("Terrain", terrain::show),
    ("Import", import::show),
    ("Generate", generate::show),
    ("Camera", camera::show),
    ("Bookmarks", bookmarks::show),
    ("Camera path", path::show),
    ("March", march::show),
    ("Compare", compare::show),
    ("Diffuse", diffuse::show),
    ("Lighting", lighting::show),
    ("Land", land::show),
    ("Materials", materials::show),
    ("Skybox", skybox::show),
    ("Sun", sun::show),
    ("Air", air::show),
    ("Clouds", clouds::show),
    ("Occluder", occluder::show),
    ("Water", water::show),
    ("Craters", craters::show),
    ("Debug", debug::show),
    ("Tradeoff", tradeoff::show),
    ("Frame", frame::show),
    ("Interface", interface::show),
    ("Keys", keys::show),
    ("Ledger", ledger::show),
];

/// Draws the panel along the left side of `ui`.
pub(crate) fn show(ui: &mut egui::Ui, panel: &mut Panel<'_>) {
    egui::Panel::left("panel").resizable(false).exact_size(WIDTH).show(ui, |ui| {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (_, section) in SECTIONS {
                section(ui, panel);
            }
        });
    });
}

#[cfg(test)]
mod kittest;

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use std::sync::Arc;

    use crate::app::status::{Widget, widgets};
    use crate::camera::{Camera, NamedView};
    use crate::heightfield::HeightField;
    use crate::scene::{CraterMode, SkyboxSettings, Technique};

    pub(super) fn facts(map: &Arc<HeightField>) -> Facts {
        let own = map.box_size(None);
        Facts {
            title: "Test".into(),
            samples: [map.width(), map.height()],
            range: map.range(),
            extent_metres: None,
            extent: own,
            true_height_scale: own.y,
            map: Arc::clone(map),
            filterable_heights: false,
            max_texture: 8192,
            adapter: ("adapter".into(), "driver".into()),
            ledger: Default::default(),
            images: Default::default(),
        }
    }

    /// One section alone, opened, in a screen high enough that nothing is scrolled away.
    fn section_widgets(section: Section, scene: &mut Scene) -> Vec<Widget> {
        let map = Arc::new(HeightField::from_raw(2, 2, &[0.0_f32, 1.0, 0.0, 1.0]).unwrap());
        scene.camera.get_or_insert(NamedView::Start.camera(&map, map.box_size(None)));
        let ctx = egui::Context::default();
        ctx.enable_accesskit();
        let mut view = ViewSettings::default();
        let (facts, mut speed, mut commands) = (facts(&map), 0.3, Vec::new());
        let mut open = Files::default();
        let mut update = None;
        // A click on the header opens the section, later passes let its animation finish.
        for pass in 0..8 {
            let mut input = egui::RawInput {
                screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1200.0, 4000.0))),
                time: Some(f64::from(pass)),
                ..Default::default()
            };
            if pass == 1 {
                let tree = update.as_ref().expect("accesskit is on");
                let header = widgets(tree).into_iter().find(|widget| widget.role == "DisclosureTriangle");
                let header = header.expect("a section has a header");
                if header.expanded == Some(false) {
                    let pos = egui::pos2(
                        (header.rect[0] + header.rect[2]) as f32 * 0.5,
                        (header.rect[1] + header.rect[3]) as f32 * 0.5,
                    );
                    input.events.push(egui::Event::PointerMoved(pos));
                    for pressed in [true, false] {
                        let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
                        input.events.push(egui::Event::PointerButton { pos, button, pressed, modifiers });
                    }
                }
            }
            let mut output = ctx.run_ui(input, |ui| {
                let mut panel = Panel {
                    scene: &mut *scene,
                    view: &mut view,
                    speed: &mut speed,
                    facts: &facts,
                    tradeoff: &Tradeoff::default(),
                    files: &mut open,
                    commands: &mut commands,
                };
                (section.1)(ui, &mut panel);
            });
            update = output.platform_output.accesskit_update.take();
            output.drop_without_applying_deltas();
        }
        assert!(commands.is_empty(), "opening a section must ask for nothing: {commands:?}");
        widgets(&update.expect("accesskit is on"))
    }

    /// A screen reader, and the test that clicks every toggle, find a widget by its name.
    #[test]
    fn every_widget_has_a_name_of_its_own() {
        let mut all = HashSet::new();
        for section in SECTIONS {
            for technique in Technique::ALL {
                let mut scene = Scene::default();
                scene.march.technique = technique;
                let found = section_widgets(section, &mut scene);
                let headers: Vec<_> = found.iter().filter(|widget| widget.role == "DisclosureTriangle").collect();
                assert_eq!((headers.len(), headers[0].label.as_str()), (1, section.0));
                let mut names = HashSet::new();
                for widget in &found {
                    assert!(!widget.label.trim().is_empty(), "a nameless {} in {}", widget.role, section.0);
                    assert!(names.insert(widget.label.clone()), "two of {:?} in {}", widget.label, section.0);
                }
                if section.0 != "Ledger" {
                    assert!(found.len() > 2, "{} is open and shows its widgets: {found:?}", section.0);
                }
                if technique == Technique::default() {
                    for widget in found {
                        assert!(all.insert(widget.label.clone()), "{:?} names two widgets of the panel", widget.label);
                    }
                }
            }
        }
    }

    /// What a technique does not use is greyed out, and only that.
    #[test]
    fn controls_without_effect_are_disabled() {
        let march = *SECTIONS.iter().find(|section| section.0 == "March").expect("the section");
        let disabled_beside = |technique, other: Option<Technique>| {
            let mut scene = Scene::default();
            scene.march.technique = technique;
            scene.compare.enabled = other.is_some();
            scene.compare.technique = other.unwrap_or_default();
            let found = section_widgets(march, &mut scene);
            // What is invented has a strength with one technique alone, as the test of every control says.
            let other = |name: &String| !name.starts_with("Detail strength");
            let off = found.into_iter().filter(|widget| widget.disabled).map(|widget| widget.label).filter(other);
            let off: HashSet<String> = off.collect();
            off
        };
        let disabled = |technique| disabled_beside(technique, None);
        let linear = disabled(Technique::Linear);
        assert!(linear.contains("Halvings") && !linear.contains("Most samples"), "{linear:?}");
        assert!(disabled(Technique::LinearBinary).is_empty());
        assert_eq!(disabled(Technique::Secant), linear);
        for technique in [Technique::Cone, Technique::RelaxedCone] {
            let along_cones = disabled(technique);
            assert!(along_cones.contains("Height filter"), "{along_cones:?}");
            assert!(!along_cones.contains("Halvings") && !along_cones.contains("Most samples"), "{along_cones:?}");
        }
        let exact = disabled(Technique::MaxMipmap);
        assert!(
            ["Halvings", "Most samples", "Fewest samples", "Height filter"].iter().all(|name| exact.contains(*name))
        );
        assert!(!exact.contains("Technique"));
        // The other half of a split picture takes the same settings.
        assert_eq!(disabled_beside(Technique::MaxMipmap, Some(Technique::Linear)), linear);
        assert!(disabled_beside(Technique::Linear, Some(Technique::LinearBinary)).is_empty());
        assert_eq!(disabled_beside(Technique::MaxMipmap, Some(Technique::MaxMipmap)), exact);
    }

    #[test]
    fn showing_the_panel_changes_nothing() {
        for section in SECTIONS {
            let mut scene = Scene::default();
            // Values outside the ranges of the sliders, as a scene file may have them.
            scene.march.samples_max = 5000;
            scene.terrain.height_scale = Some(7.5);
            scene.craters.mode = CraterMode::Layered;
            scene.craters.layer_resolution = 777;
            scene.skybox = SkyboxSettings { flattening: 33.0, ..SkyboxSettings::default() };
            scene.lighting.shininess = 1000.0;
            scene.camera = Some(Camera { eye: glam::DVec3::splat(40.0), yaw: 359.9, pitch: -89.95, fov: 3.0 });
            let before = scene.clone();
            section_widgets(section, &mut scene);
            assert_eq!(scene, before, "{} changed the scene by itself", section.0);
        }
    }

    #[test]
    fn widget_roles_are_those_of_the_tree() {
        let mut scene = Scene::default();
        let lighting = *SECTIONS.iter().find(|section| section.0 == "Lighting").expect("the section");
        let found = section_widgets(lighting, &mut scene);
        let toggle = found.iter().find(|widget| widget.label == "Enable lighting").expect("the toggle is there");
        assert_eq!((toggle.role.as_str(), toggle.toggled), ("CheckBox", Some(true)));
    }
}
