//! The sun and the reflection model.

use egui::Ui;

use super::Panel;
use super::widgets::{Number, section, toggle};
use crate::scene::LightingSettings;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Sets the sun and the weights back to their defaults. Free.";
    section(ui, "Lighting", false, Some(reset), |ui, reset| {
        let lighting = &mut panel.scene.lighting;
        if reset {
            let LightingSettings { shadows, baked, occlusion, clock, .. } = lighting.clone();
            *lighting = LightingSettings { shadows, baked, occlusion, clock, ..LightingSettings::default() };
        }
        let tooltip =
            "Lights the ground. Costs four gathers of heights per pixel for the normal; off, none is computed.";
        toggle(ui, &mut lighting.enabled, "Enable lighting", tooltip);
        let off = !lighting.enabled;
        let why = "lighting is off";
        // The sun also stands in the procedural sky, so its place matters even without lighting.
        Number::new("Sun azimuth", "Direction of the sun, clockwise from north, in degrees. Free per frame; a procedural sky is made anew at each change.")
            .unit("°")
            .decimals(1)
            .disabled_when(lighting.clock.enabled, "the sun follows the clock")
            .slider(ui, &mut lighting.sun_azimuth, 0.0..=360.0);
        Number::new("Sun elevation", "Height of the sun above the horizon, in degrees. Free per frame; a procedural sky is made anew at each change.")
            .unit("°")
            .decimals(1)
            .disabled_when(lighting.clock.enabled, "the sun follows the clock")
            .slider(ui, &mut lighting.sun_elevation, -10.0..=90.0);
        Number::new("Ambient", "Weight of the light that comes from everywhere. Free.").disabled_when(off, why).slider(
            ui,
            &mut lighting.ambient,
            0.0..=2.0,
        );
        Number::new("Diffuse light", "Weight of the light that a matt surface reflects. Free.")
            .disabled_when(off, why)
            .slider(ui, &mut lighting.diffuse, 0.0..=2.0);
        Number::new("Specular", "Weight of the highlight; 0 leaves it out of the picture.")
            .disabled_when(off, why)
            .slider(ui, &mut lighting.specular, 0.0..=2.0);
        Number::new("Shininess", "Exponent of the highlight: higher is smaller and sharper. Free.")
            .decimals(1)
            .logarithmic()
            .disabled_when(off, why)
            .slider(ui, &mut lighting.shininess, 1.0..=256.0);
    });
}
