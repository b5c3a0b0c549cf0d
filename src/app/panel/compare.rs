//! A second technique on the right of a line through the picture.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, choose, section, toggle};
use crate::scene::{CompareSettings, Technique};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "One technique for the whole picture; the line goes back to the middle. Free.";
    section(ui, "Compare", false, Some(reset), |ui, reset| {
        let compare = &mut panel.scene.compare;
        if reset {
            *compare = CompareSettings::default();
        }
        let tooltip = "Splits the picture: the technique of the march on the left, another one on the right, with the same \
                       samples and options. Drag the line with the left mouse button. One more draw; each pixel is \
                       still drawn once.";
        toggle(ui, &mut compare.enabled, "Enable compare", tooltip);
        let (off, why) = (!compare.enabled, "the picture is not split");
        let choices = Technique::CHOICES.map(|value| Choice {
            value,
            name: value.name(),
            off: None,
            tooltip: "Draws what is right of the line. Where it is the march's own there is no line. A technique whose \
                      cones are still being found is drawn by max-mipmap meanwhile.",
        });
        let tooltip = "The technique on the right. Its pipeline is built on first use.";
        choose(ui, &mut compare.technique, &choices, "Compare with", tooltip, off.then_some(why));
        Number::new("Split", "Where the line is, as a share of the picture's width from the left, 0 to 1. The picture is as wide as the window: \
                       its left is below the panel (F2 hides it). Free.")
            .decimals(3)
            .disabled_when(off, why)
            .slider(ui, &mut compare.share, 0.0..=1.0);
    });
}
