//! Which key does what, and choosing other ones.

use egui::{Button, Grid, Ui};

use super::Panel;
use super::widgets::section;
use crate::app::actions::ACTIONS;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    section(ui, "Keys", false, Some("All keys as at a first start."), |ui, reset| {
        let view = &mut *panel.view;
        if reset {
            view.keys.reset();
            (view.rebinding, view.refused) = (None, None);
        }
        ui.label("Press a button, then the new key. Esc leaves the key as it is, Backspace takes it away.");
        if let Some((action, reason)) = &view.refused {
            ui.colored_label(ui.visuals().error_fg_color, format!("⚠ {}: {reason}", action.entry().does));
        }
        Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
            for entry in ACTIONS {
                let waits = view.rebinding == Some(entry.action);
                let text = if waits { "press a key …".to_owned() } else { view.keys.shown(entry.action) };
                let button = ui.add(Button::new(text).min_size(egui::vec2(96.0, 0.0)).selected(waits));
                let tooltip = format!("Chooses another key for: {}.", entry.does);
                if button.on_hover_text(tooltip).accessible_name(format!("Key for {}", entry.name)).clicked() {
                    view.rebinding = (!waits).then_some(entry.action);
                    view.refused = None;
                }
                ui.add(egui::Label::new(entry.does).wrap());
                ui.end_row();
            }
        });
    });
}
