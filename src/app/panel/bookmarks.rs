//! Views to come back to, kept with the map.

use egui::{Button, Ui};

use super::Panel;
use super::widgets::section;
use crate::app::settings::Command;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    section(ui, "Bookmarks", false, Some("Forgets the bookmarks of this map."), |ui, reset| {
        let Panel { view, commands, .. } = panel;
        if reset {
            view.bookmarks.clear();
        }
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.spacing_mut().button_padding.x = 6.0;
        ui.horizontal(|ui| {
            ui.add_sized([44.0, 18.0], egui::Label::new("Go to"));
            for digit in 1..=9_usize {
                let there = view.bookmarks.contains_key(&digit.to_string());
                let response = ui.add_enabled(there, Button::new(digit.to_string()));
                let response = response
                    .on_hover_text(format!("Goes to bookmark {digit} ({digit}). Free."))
                    .on_disabled_hover_text(format!("Not in use: bookmark {digit} is not set."));
                if response.accessible_name(format!("Go to bookmark {digit}")).clicked() {
                    commands.push(Command::GoToBookmark(digit));
                }
            }
        });
        ui.horizontal(|ui| {
            ui.add_sized([44.0, 18.0], egui::Label::new("Set"));
            for digit in 1..=9_usize {
                let tooltip =
                    format!("Sets bookmark {digit} to this view (Ctrl+{digit}); it is kept with the map. Free.");
                let response = ui.button(digit.to_string()).on_hover_text(tooltip);
                if response.accessible_name(format!("Set bookmark {digit}")).clicked() {
                    commands.push(Command::SetBookmark(digit));
                }
            }
        });
    });
}
