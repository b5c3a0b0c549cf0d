//! Craters: how they deform the ground, the brush of the next one, and taking them back.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, button_unless, choose, fact, section};
use crate::app::settings::Command;
use crate::scene::{CraterMode, CraterSettings};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Sets mode and brush back to their defaults. The craters stay.";
    section(ui, "Craters", false, Some(reset), |ui, reset| {
        let craters = &mut panel.scene.craters;
        if reset {
            *craters = CraterSettings { list: std::mem::take(&mut craters.list), ..CraterSettings::default() };
        }
        mode(ui, craters, panel.facts.max_texture);
        Number::new("Crater radius", "Radius of the next crater (key C); the map's longer side is 1. Free.")
            .decimals(4)
            .logarithmic()
            .slider(ui, &mut craters.radius, 0.001..=0.5);
        Number::new("Crater depth", "Depth of the next crater as a share of the terrain's height. Free.").slider(
            ui,
            &mut craters.depth,
            0.0..=1.0,
        );
        Number::new("Crater rim", "Height of the next crater's rim as a share of the terrain's height. Free.").slider(
            ui,
            &mut craters.rim,
            0.0..=1.0,
        );
        fact(ui, "Craters made", craters.list.len().to_string());
        let none = craters.list.is_empty().then_some("there is no crater");
        ui.horizontal(|ui| {
            let tooltip = "Takes the last crater back (Ctrl+Z). Rebuilds what it touched.";
            if button_unless(ui, "Undo crater", tooltip, none) {
                panel.commands.push(Command::UndoCrater);
            }
            let tooltip = "Takes all craters back (Ctrl+Shift+Backspace). Rebuilds what they touched.";
            if button_unless(ui, "Clear all craters", tooltip, none) {
                panel.commands.push(Command::ClearCraters);
            }
        });
    });
}

fn mode(ui: &mut Ui, craters: &mut CraterSettings, max_texture: u32) {
    let choices = [
        Choice {
            value: CraterMode::Baked,
            name: "baked",
            tooltip: "Written into the heights; only the touched part of the pyramid is rebuilt. Free per frame.",
            off: None,
        },
        Choice {
            value: CraterMode::Layered,
            name: "layered",
            tooltip: "A second texture of its own resolution, added at every step: a second read each time.",
            off: None,
        },
    ];
    choose(ui, &mut craters.mode, &choices, "Crater mode", "How craters deform the ground.", None);
    let tooltip = "Samples along the longer side of the craters' own texture. Finer craters for the techniques that sample, more bytes; max-mipmap reads it at the map's samples.";
    Number::new("Layer resolution", tooltip)
        .logarithmic()
        .disabled_when(craters.mode == CraterMode::Baked, "baked craters have the resolution of the map")
        .slider(ui, &mut craters.layer_resolution, 16..=max_texture.clamp(16, 8192));
}
