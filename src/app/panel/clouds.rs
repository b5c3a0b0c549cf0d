//! Layers of clouds, their shadows, and their clock.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, button_unless, choose, section, toggle};
use crate::scene::clouds::{MOST_CLOUD_LAYERS, MOST_SECONDS};
use crate::scene::{CloudLayer, CloudSettings, CloudSource};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "No clouds, and the five layers as they were. Free.";
    section(ui, "Clouds", false, Some(reset), |ui, reset| {
        let clouds = &mut panel.scene.clouds;
        if reset {
            *clouds = CloudSettings::default();
        }
        let tooltip = "Up to five flat layers, in the sky and between a high eye and the ground. Two texture reads for each \
                       layer and pixel that may show it. Not shown with slope or aspect colours and hillshades.";
        toggle(ui, &mut clouds.enabled, "Enable clouds", tooltip);
        let off = (!clouds.enabled).then_some("there are no clouds");
        let choices = CloudSource::ALL.map(|value| Choice {
            value,
            name: value.name(),
            off: None,
            tooltip: match value {
                CloudSource::Noise => "Noise that has the look of heaps and veils.",
                CloudSource::Map => "The map's own heights, as in the study of 2003.",
            },
        });
        choose(ui, &mut clouds.source, &choices, "Clouds from", "What the clouds are made from. Made once.", off);
        let number = |name, tooltip| Number::new(name, tooltip).disabled_when(off.is_some(), "there are no clouds");
        number("Cloud cover", "From no cloud at 0 over each layer's own cover at 0.5 to a closed sky at 1. Free.")
            .slider(ui, &mut clouds.cover, 0.0..=1.0);
        ui.add_enabled_ui(off.is_none(), |ui| {
            let tooltip = "Clouds keep the sun from the ground and the occluder, where the ground is lit and the sun stands 2° \
                           high or more. One texture read per pixel; the map of shadows is drawn when clouds or sun move.";
            toggle(ui, &mut clouds.shadows, "Cloud shadows", tooltip);
            let tooltip = "Clouds move. While they do, frames are drawn all the time, also under reduced motion: it is you who \
                           asks for it.";
            toggle(ui, &mut clouds.moving, "Move clouds", tooltip);
        });
        Number::new("Shadow strength", "How dark the shadows of clouds are. Free.")
            .disabled_when(!clouds.enabled || !clouds.shadows, "clouds cast no shadows")
            .slider(ui, &mut clouds.shadow_strength, 0.0..=1.0);
        number("Cloud clock", "Seconds that pass in the sky for each of yours. Free.").unit("×").decimals(0).slider(
            ui,
            &mut clouds.rate,
            -600.0..=600.0,
        );
        number("Cloud time", "The moment that is shown, in seconds since the layers were where they began. Free.")
            .unit(" s")
            .decimals(0)
            .field(ui, &mut clouds.time, -MOST_SECONDS..=MOST_SECONDS, 60.0);
        layers(ui, clouds, &mut panel.view.cloud_layer, off);
    });
}

/// One of the layers, and how many there are.
fn layers(ui: &mut Ui, clouds: &mut CloudSettings, chosen: &mut usize, off: Option<&str>) {
    ui.horizontal(|ui| {
        let full = (clouds.layers.len() >= MOST_CLOUD_LAYERS).then_some("there are five");
        if button_unless(ui, "Add layer", "Another layer of clouds, at 3000 m.", off.or(full)) {
            clouds.layers.push(CloudLayer::default());
            *chosen = clouds.layers.len() - 1;
        }
        let none = clouds.layers.is_empty().then_some("there is none");
        if button_unless(ui, "Remove layer", "Takes the layer below away.", off.or(none)) {
            clouds.layers.remove((*chosen).min(clouds.layers.len() - 1));
        }
    });
    let Some(last) = clouds.layers.len().checked_sub(1) else { return };
    let mut index = (*chosen).min(last);
    let names: Vec<String> =
        clouds.layers.iter().enumerate().map(|(i, l)| format!("{}: {} m", i + 1, l.height)).collect();
    let choices: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(value, name)| Choice { value, name, off: None, tooltip: "Shows this layer's settings below." })
        .collect();
    if choose(ui, &mut index, &choices, "Layer", "The layer whose settings are shown.", off) {
        *chosen = index;
    }
    let Some(layer) = clouds.layers.get_mut(index) else { return };
    let number = |name, tooltip| Number::new(name, tooltip).disabled_when(off.is_some(), "there are no clouds");
    number(
        "Layer height",
        "Metres above sea level, or above the lowest place where the map's heights are no metres. Free.",
    )
    .unit(" m")
    .decimals(0)
    .slider(ui, &mut layer.height, 0.0..=15_000.0);
    number("Layer cover", "Share of the sky that this layer covers. Free.").slider(ui, &mut layer.cover, 0.0..=1.0);
    number("Layer thickness", "Optical thickness of its thickest clouds: 1 lets a third of the light through. Free.")
        .slider(ui, &mut layer.thickness, 0.0..=10.0);
    number(
        "Layer scale",
        "Kilometres after which its pattern begins anew, mixed with a larger one that does not. Free.",
    )
    .unit(" km")
    .decimals(1)
    .logarithmic()
    .slider(ui, &mut layer.scale, 0.5..=200.0);
    number("Layer speed", "How fast it moves, in metres per second. Free.").unit(" m/s").decimals(1).slider(
        ui,
        &mut layer.speed,
        0.0..=60.0,
    );
    number("Layer direction", "Where it moves to, clockwise from north, in degrees. Free.")
        .unit("°")
        .decimals(0)
        .slider(ui, &mut layer.direction, 0.0..=360.0);
}
