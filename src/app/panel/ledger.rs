//! What the last frame cost. What is off or out of view is not in it.

use egui::Ui;

use super::Panel;
use super::widgets::{fact, section};
use crate::app::overlay::bytes;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    section(ui, "Ledger", false, None, |ui, _| {
        let (ledger, (adapter, driver)) = (&panel.facts.ledger, &panel.facts.adapter);
        fact(ui, "Adapter", adapter.as_str());
        fact(ui, "Driver", driver.as_str());
        fact(ui, "Scene frames", ledger.scene_frames.to_string());
        fact(ui, "Passes", ledger.passes.join(", "));
        fact(ui, "Draws", ledger.draws.to_string());
        fact(ui, "Shader defs", ledger.shader_defs.join(", "));
        fact(ui, "Pipelines", ledger.pipelines.join(", "));
        fact(ui, "Uploaded", bytes(ledger.uploaded_bytes));
        fact(ui, "Textures", bytes(ledger.texture_bytes));
        egui::Grid::new("textures").num_columns(4).striped(true).show(ui, |ui| {
            for texture in &ledger.textures {
                ui.label(&texture.name).on_hover_text("Name of the texture.");
                ui.label(format!("{}×{}×{}", texture.width, texture.height, texture.layers));
                ui.label(&texture.format);
                ui.label(bytes(texture.bytes));
                ui.end_row();
            }
        });
    });
}
