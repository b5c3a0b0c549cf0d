//! Looks of the interface: theme, size, motion, the log, the first words.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, choose, section, toggle};
use crate::app::preferences::{Motion, Theme, ZOOMS};

const THEMES: [Choice<'static, Theme>; 3] = [
    Choice {
        value: Theme::System,
        name: "system",
        tooltip: "What the desktop has; dark where it does not say.",
        off: None,
    },
    Choice { value: Theme::Dark, name: "dark", tooltip: "Light text on dark.", off: None },
    Choice { value: Theme::Light, name: "light", tooltip: "Dark text on light.", off: None },
];

const MOTIONS: [Choice<'static, Motion>; 3] = [
    Choice {
        value: Motion::System,
        name: "as the desktop",
        tooltip: "Reduced where the desktop asks for it.",
        off: None,
    },
    Choice { value: Motion::Full, name: "full", tooltip: "The eye glides to a bookmark or a point.", off: None },
    Choice {
        value: Motion::Reduced,
        name: "reduced",
        tooltip: "The eye is there at once, and nothing fades.",
        off: None,
    },
];

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Theme and motion as the desktop has them, text in its own size, no log.";
    section(ui, "Interface", false, Some(reset), |ui, reset| {
        let view = &mut *panel.view;
        if reset {
            (view.theme, view.motion, view.zoom) = (Theme::System, Motion::System, 1.0);
            view.log.open = false;
        }
        choose(ui, &mut view.theme, &THEMES, "Theme", "Dark or light. Kept between runs. Free.", None);
        let tooltip =
            "Whether the eye glides and parts of the interface fade. A path that is played is not changed by it. Free.";
        choose(ui, &mut view.motion, &MOTIONS, "Motion", tooltip, None);
        let tooltip = "Size of panel and text beside that of the monitor (Ctrl + and Ctrl −). Free.";
        let mut zoom = view.zoom;
        if Number::new("Text size", tooltip).unit("×").field(ui, &mut zoom, ZOOMS, 0.01) {
            view.zoom = zoom;
        }
        toggle(ui, &mut view.log.open, "Show log", "Shows the last messages at the bottom of the window (F4). Free.");
        toggle(ui, &mut view.welcome, "Show welcome", "Shows the words of the first start. Free.");
    });
}
