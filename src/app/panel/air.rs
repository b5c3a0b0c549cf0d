//! Aerial perspective, fog, and the lens flare.

use egui::Ui;

use super::Panel;
use super::widgets::{Number, section, toggle};
use crate::scene::{AirSettings, FlareSettings};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Clear air without fog, and no flare. Free.";
    section(ui, "Air", false, Some(reset), |ui, reset| {
        let (air, flare) = (&mut panel.scene.air, &mut panel.scene.flare);
        if reset {
            (*air, *flare) = (AirSettings::default(), FlareSettings::default());
        }
        let tooltip = "Distance fades the ground into the sky at the horizon, in kilometres of the map: vertical \
                       exaggeration stretches the air with the ground. Where the map's scale is not known its longer side \
                       counts as 10 km. Not shown with slope or aspect colours and hillshades, whose colours are to be read. \
                       Some arithmetic per pixel.";
        toggle(ui, &mut air.perspective, "Aerial perspective", tooltip);
        Number::new(
            "Visibility",
            "How far one sees at the map's lowest ground: where a black object keeps 2 % of its contrast, in kilometres. Free.",
        )
        .unit(" km")
        .decimals(1)
        .logarithmic()
        .disabled_when(!air.perspective, "aerial perspective is off")
        .slider(ui, &mut air.visibility, 0.5..=320.0);
        let tooltip = "Fog that is dense up to a height and thins out above it, also before the sky. Metres are those of the \
                       map, whatever the vertical exaggeration; where its scale is not known its longer side counts as 10 km. \
                       Some arithmetic per pixel.";
        toggle(ui, &mut air.fog, "Height fog", tooltip);
        let number = |name, tooltip| Number::new(name, tooltip).disabled_when(!air.fog, "there is no fog");
        number("Fog density", "Extinction up to the base height, per kilometre; 3.9 is a visibility of 1 km. Free.")
            .unit("/km")
            .logarithmic()
            .slider(ui, &mut air.fog_density, 0.01..=50.0);
        let tooltip = "Height up to which fog is dense, in metres: above sea level, or the map's lowest place where its heights \
                       are no metres. Free.";
        Number::new("Fog base", tooltip).unit(" m").decimals(0).disabled_when(!air.fog, "there is no fog").slider(
            ui,
            &mut air.fog_base,
            -500.0..=6000.0,
        );
        Number::new("Fog scale height", "Metres above the base in which the density falls to 1/e. Free.")
            .unit(" m")
            .decimals(0)
            .logarithmic()
            .disabled_when(!air.fog, "there is no fog")
            .slider(ui, &mut air.fog_scale, 1.0..=5000.0);
        Number::new("Fog glow", "How much sunlight the fog scatters forward, so that it glows towards the sun. Free.")
            .disabled_when(!air.fog, "there is no fog")
            .slider(ui, &mut air.fog_glow, 0.0..=2.0);
        let tooltip = "Reflections of the sun in a lens, dimmed by what hills, clouds and fog hide of its disc. A pass of a few \
                       small squares, and only while the sun is seen in the picture.";
        toggle(ui, &mut flare.enabled, "Lens flare", tooltip);
        Number::new("Flare strength", "How bright the flare is. Free.")
            .disabled_when(!flare.enabled, "there is no flare")
            .slider(ui, &mut flare.strength, 0.0..=4.0);
    });
}
