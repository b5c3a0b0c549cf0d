//! The cube that hides hills and is hidden by them.

use egui::Ui;
use glam::DVec3;

use super::Panel;
use super::widgets::{Number, section, toggle};
use crate::scene::OccluderSettings;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Switches the cube off and puts it back over the middle of the terrain.";
    section(ui, "Occluder", false, Some(reset), |ui, reset| {
        let extent = panel.facts.map.box_size(panel.scene.terrain.height_scale);
        let occluder = &mut panel.scene.occluder;
        if reset {
            *occluder = OccluderSettings::default();
        }
        let tooltip =
            "Draws a cube that hides hills and is hidden by them, to the pixel. One draw; none while out of view.";
        toggle(ui, &mut occluder.enabled, "Enable occluder", tooltip);
        let off = !occluder.enabled;
        let why = "the occluder is off";
        let mut position = occluder.centre(&panel.facts.map, extent);
        let axes = [("Occluder x", "east"), ("Occluder y", "up"), ("Occluder z", "south")];
        let mut moved = false;
        for ((name, direction), value) in axes.into_iter().zip(position.as_mut()) {
            let tooltip = format!("Centre of the cube towards {direction}; the map's longer side is 1. Free.");
            let number = Number::new(name, &tooltip).decimals(4).disabled_when(off, why);
            moved |= number.slider(ui, value, -0.5..=1.5);
        }
        if moved {
            occluder.position = Some(position);
        }
        Number::new("Occluder size", "Length of the cube's edges; the map's longer side is 1. Free.")
            .decimals(3)
            .logarithmic()
            .disabled_when(off, why)
            .slider(ui, &mut occluder.size, 0.005..=1.0);
        let turns = ["Occluder yaw", "Occluder pitch", "Occluder roll"];
        let DVec3 { x, y, z } = &mut occluder.rotation;
        for (name, value) in turns.into_iter().zip([x, y, z]) {
            Number::new(name, "Turn of the cube in degrees: yaw, then pitch, then roll. Free.")
                .unit("°")
                .decimals(1)
                .disabled_when(off, why)
                .slider(ui, value, 0.0..=360.0);
        }
        let tooltip =
            "Degrees per second that the cube turns; 0 stands still. While it turns, frames are drawn all the time.";
        Number::new("Spin", tooltip).unit("°/s").decimals(1).disabled_when(off, why).slider(
            ui,
            &mut occluder.spin,
            -180.0..=180.0,
        );
    });
}
