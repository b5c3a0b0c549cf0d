//! The sky: procedural, or six images.

use std::path::PathBuf;

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, button_unless, choose, fact, section, text, toggle};
use crate::scene::SkyboxSettings;
use crate::scene::light::SkyModel;

/// The faces in the order of the scene file.
const FACES: [&str; 6] = ["+x (east)", "−x (west)", "+y (up)", "−y (down)", "+z (south)", "−z (north)"];

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "The procedural sky with the default flattening.";
    section(ui, "Skybox", false, Some(reset), |ui, reset| {
        let (skybox, paths) = (&mut panel.scene.skybox, &mut panel.view.paths.faces);
        if reset {
            *skybox = SkyboxSettings::default();
            *paths = Default::default();
        }
        let tooltip =
            "Draws the sky where no terrain is. One texture read for each of those pixels; off, a flat colour.";
        toggle(ui, &mut skybox.enabled, "Enable skybox", tooltip);
        Number::new("Flattening", "Width of the sky's box over its height: higher pulls the horizon down. Free per frame; a procedural sky is made anew at each change.")
            .disabled_when(!skybox.enabled, "the skybox is off")
            .slider(ui, &mut skybox.flattening, 1.0..=16.0);
        let images = skybox.faces.is_some().then_some("the sky is of images");
        let choices = SkyModel::ALL.map(|value| Choice {
            value,
            name: value.name(),
            off: None,
            tooltip: match value {
                SkyModel::Painted => "A gradient with the sun and distant hills.",
                SkyModel::Physical => {
                    "The analytic daylight of Preetham, Shirley and Smits (1999). It lights the ground, too: a few \
                     operations per pixel."
                }
            },
        });
        let tooltip = "What makes the sky. The map is made anew at each change; another light is another pipeline.";
        choose(ui, &mut skybox.model, &choices, "Sky model", tooltip, images);
        let painted = skybox.model != SkyModel::Physical;
        Number::new(
            "Turbidity",
            "Haze of the physical sky, from mountain air to a hazy day. Free per frame; the sky is made anew.",
        )
        .decimals(1)
        .disabled_when(painted, "the sky is painted")
        .slider(ui, &mut skybox.turbidity, 1.7..=10.0);
        fact(ui, "Sky", if skybox.faces.is_some() { "six images" } else { "procedural" });
        for (path, face) in paths.iter_mut().zip(FACES) {
            let tooltip = format!("The square image that is seen towards {face}. Costs its size on the GPU.");
            text(ui, path, &format!("Sky face {face}"), face, &tooltip);
        }
        ui.horizontal(|ui| {
            let missing = paths.iter().any(|path| path.trim().is_empty()).then_some("all six images are needed");
            if button_unless(ui, "Apply sky faces", "Shows the six images named above.", missing) {
                skybox.faces = Some(paths.clone().map(|path| PathBuf::from(path.trim())));
            }
            let procedural = skybox.faces.is_none().then_some("the sky is the procedural one");
            if button_unless(
                ui,
                "Procedural sky",
                "A sky with the sun and distant hills instead of images.",
                procedural,
            ) {
                skybox.faces = None;
            }
        });
    });
}
