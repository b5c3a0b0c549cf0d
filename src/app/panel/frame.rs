//! How frames are paced, and what lies on top of the picture.

use egui::Ui;

use super::Panel;
use super::widgets::{Number, button, section, toggle};
use crate::app::settings::{Command, ViewSettings};
use crate::scene::SavedSettings;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Vsync on, no frame limit, overlay off, steps not measured, pictures without legends.";
    section(ui, "Frame", false, Some(reset), |ui, reset| {
        let Panel { scene, view, commands, .. } = panel;
        if reset {
            scene.saved = SavedSettings::default();
            let ViewSettings { vsync, frame_limit, overlay, measure_steps, .. } = ViewSettings::default();
            **view = ViewSettings { vsync, frame_limit, overlay, measure_steps, ..view.clone() };
        }
        let tooltip = "Frames wait for the screen, which avoids tearing; off, they come as fast as they can.";
        toggle(ui, &mut view.vsync, "Vsync", tooltip);
        let tooltip =
            "Most frames per second while something moves; 0 is no limit. When nothing changes, none is drawn.";
        Number::new("Frame limit", tooltip).unit(" fps").slider(ui, &mut view.frame_limit, 0..=240);
        let tooltip = "Shows frame times, steps and the ledger over the picture (F3). Costs a little drawing.";
        toggle(ui, &mut view.overlay, "Show overlay", tooltip);
        let tooltip = "Measures steps per ray for the overlay: draws a second, smaller picture and waits for it, at most \
                       twice a second.";
        toggle(ui, &mut view.measure_steps, "Measure steps", tooltip);
        toggle(ui, &mut view.help, "Show help", "Shows the keys (F1). Free.");
        let tooltip =
            "Puts the legend into screenshots and animations, where the colours or lines have one. Free per frame.";
        toggle(ui, &mut scene.saved.legend, "Legend in pictures", tooltip);
        ui.horizontal(|ui| {
            let tooltip = "Writes the picture as PNG, and the scene beside it as TOML (F12).";
            if button(ui, "Take screenshot", tooltip) {
                commands.push(Command::Screenshot);
            }
            if button(ui, "Full screen", "Enters or leaves full screen (F11).") {
                commands.push(Command::FullScreen);
            }
        });
    });
}
