//! What to show instead of, or on top of, the shaded terrain.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, choose, section, toggle};
use crate::scene::{DebugSettings, DebugView};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "The shaded terrain without additions.";
    section(ui, "Debug", false, Some(reset), |ui, reset| {
        let debug = &mut panel.scene.debug;
        if reset {
            *debug = DebugSettings::default();
        }
        let choices = DebugView::ALL.map(|value| Choice {
            value,
            name: value.name(),
            off: None,
            tooltip: match value {
                DebugView::None => "The shaded terrain.",
                DebugView::Position => "Position on the cube's back faces as a colour; no ray is cast. The cheapest.",
                DebugView::Steps => "Steps of each ray as a heat map with a legend. Costs counting.",
                DebugView::Error => {
                    "Distance error of each ray against the exact technique, in cells, as a heat map with a legend; when \
                     the eye rests, against the f64 reference. Costs a second march per frame, and a processor at rest."
                }
                DebugView::Normals => "The normal of the ground as a colour.",
                DebugView::Distance => "Distance from the eye: near is bright.",
            },
        });
        let tooltip = "What the terrain shows. Each view is a pipeline of its own, built on first use.";
        choose(ui, &mut debug.view, &choices, "Debug view", tooltip, None);
        let tooltip = "Draws the edges of the terrain's box, hidden where the ground hides them. One draw.";
        toggle(ui, &mut debug.wireframe, "Wireframe", tooltip);
        Number::new("Heat map maximum", "Steps that the brightest colour of the heat map stands for. Free.")
            .logarithmic()
            .disabled_when(debug.view != DebugView::Steps, "the debug view is not steps")
            .slider(ui, &mut debug.heat_map_max, 1..=4096);
    });
}
