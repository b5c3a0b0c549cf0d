//! The eye: where it is, where it looks, how fast it flies.

use egui::Ui;

use super::Panel;
use super::widgets::{Number, button, section, toggle};
use crate::app::controls::{DEFAULT_SPEED, SPEED_RANGE};
use crate::app::settings::Command;
use crate::camera::{MAX_PITCH, NamedView};

/// What the buttons of the named views say.
const VIEWS: [(NamedView, &str, &str); 6] = [
    (NamedView::Start, "Start view", "All of the terrain, from above its southern edge (Home). Free."),
    (NamedView::Over, "Over view", "From above a corner, down over the middle. Free."),
    (
        NamedView::Graze,
        "Graze view",
        "From outside and low, along the surface: the hardest for sampling techniques. Free.",
    ),
    (NamedView::Valley, "Valley view", "From just above the ground of the lowest place. Free."),
    (NamedView::Down, "Down view", "Straight down; hides most errors. Free."),
    (NamedView::Horizon, "Horizon view", "Level, from the rim. Free."),
];

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Start view, default field of view and speed, eye above the ground. Free.";
    section(ui, "Camera", false, Some(reset), |ui, reset| {
        let Panel { scene, view, speed, commands, .. } = panel;
        if reset {
            commands.push(Command::View(NamedView::Start));
            **speed = DEFAULT_SPEED;
            view.allow_below_ground = false;
        }
        if let Some(camera) = &mut scene.camera {
            let axes = [("Eye x", "east"), ("Eye y", "up"), ("Eye z", "south")];
            let values = [&mut camera.eye.x, &mut camera.eye.y, &mut camera.eye.z];
            for ((name, direction), value) in axes.into_iter().zip(values) {
                let tooltip = format!("Position of the eye towards {direction}; the map's longer side is 1. Free.");
                Number::new(name, &tooltip).decimals(4).field(ui, value, -100.0..=100.0, 0.002);
            }
            // Any angle is a direction; the rail shows the one within a turn.
            let mut yaw = camera.yaw.rem_euclid(360.0);
            let number = Number::new("Yaw", "Direction of view, clockwise from north, in degrees. Free.");
            if number.unit("°").decimals(1).slider(ui, &mut yaw, 0.0..=360.0) {
                camera.yaw = yaw;
            }
            Number::new("Pitch", "Direction of view above the horizon, in degrees. Free.")
                .unit("°")
                .decimals(1)
                .slider(ui, &mut camera.pitch, -MAX_PITCH..=MAX_PITCH);
            Number::new("Field of view", "From the bottom to the top of the picture, in degrees. Free.")
                .unit("°")
                .decimals(1)
                .slider(ui, &mut camera.fov, 10.0..=120.0);
        }
        let tooltip =
            "Base speed in map widths per second (mouse wheel). Low flight is slower, high flight faster. Free.";
        Number::new("Speed", tooltip).decimals(3).logarithmic().slider(ui, &mut **speed, SPEED_RANGE);
        let tooltip = "Lets the eye go below the ground and into it. Free.";
        toggle(ui, &mut view.allow_below_ground, "Allow below ground", tooltip);
        ui.horizontal_wrapped(|ui| {
            for (named, name, tooltip) in VIEWS {
                if button(ui, name, tooltip) {
                    commands.push(Command::View(named));
                }
            }
        });
    });
}
