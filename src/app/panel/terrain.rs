//! The height map: what it is, its proportion, and opening another one.

use std::path::PathBuf;

use egui::Ui;

use super::Panel;
use super::widgets::{Number, button_unless, fact, section, text};
use crate::app::files::FilesCommand;
use crate::app::settings::Command;
use crate::heightfield::EXAGGERATIONS;
use crate::scene::TerrainSettings;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Gives the terrain its own proportion again. The map stays. Free.";
    section(ui, "Terrain", true, Some(reset), |ui, reset| {
        let Panel { scene, view, facts, commands, .. } = panel;
        if reset {
            let (file, recipe) = (scene.terrain.file.take(), scene.terrain.recipe.take());
            scene.terrain = TerrainSettings { file, recipe, ..TerrainSettings::default() };
        }
        fact(ui, "Map", facts.title.as_str());
        fact(ui, "Samples", format!("{} × {}", facts.samples[0], facts.samples[1]));
        let unit = if facts.map.has_metres() { " m" } else { "" };
        fact(ui, "Heights", format!("{:.1} to {:.1}{unit}", facts.range[0], facts.range[1]));
        if let Some([east, south]) = facts.extent_metres {
            fact(ui, "Extent", format!("{:.2} × {:.2} km", east / 1000.0, south / 1000.0));
        }
        let mut scale = scene.terrain.height_scale.unwrap_or(facts.true_height_scale);
        let tooltip = "Height of the terrain's box; its longer horizontal side is 1. \
                       Taller boxes have longer rays, which costs steps.";
        if Number::new("Height scale", tooltip).decimals(4).logarithmic().slider(ui, &mut scale, 0.0..=2.0) {
            scene.terrain.height_scale = Some(scale);
        }
        let own = facts.map.true_height_scale();
        let mut times = if own > 0.0 { scale / own } else { 1.0 };
        let tooltip = "Heights over their true proportion ([ and ]); the eye keeps its height above the ground. \
                       Taller boxes have longer rays, which costs steps.";
        let number = Number::new("Vertical exaggeration", tooltip).unit(" ×").logarithmic();
        if number.disabled_when(own <= 0.0, "the map has no heights").slider(ui, &mut times, EXAGGERATIONS) {
            commands.push(Command::Exaggerate(times));
        }
        let tooltip = format!("Sets the height scale to the map's own, {:.4}. Free.", facts.true_height_scale);
        let unknown = facts.extent_metres.is_none().then_some(
            "the map has no extent in metres, so its true proportion is not known; a sidecar can give it one",
        );
        if button_unless(ui, "True proportion", &tooltip, unknown) {
            scene.terrain.height_scale = None;
        }
        ui.separator();
        let tooltip = "A height map to open: type its path here, or drop the file onto the window. \
                       Loading and the pyramid of maxima take a moment; the old terrain stays until they are done.";
        let entered = text(ui, &mut view.paths.terrain, "Terrain file", "path of a height map", tooltip);
        let empty = view.paths.terrain.trim().is_empty().then_some("no path is given");
        if button_unless(ui, "Open terrain", "Opens the file named above.", empty) || entered && empty.is_none() {
            commands.push(Command::Files(FilesCommand::Open(vec![PathBuf::from(view.paths.terrain.trim())])));
        }
    });
}
