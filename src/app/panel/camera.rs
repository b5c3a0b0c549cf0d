//! The eye: where it is, where it looks, how fast it flies.

use egui::Ui;
use glam::DVec3;

use super::Panel;
use super::widgets::{Choice, Number, button, choose, section, toggle};
use crate::app::controls::{DEFAULT_SPEED, SPEED_RANGE};
use crate::app::preferences::Mode;
use crate::app::settings::{Command, Facts};
use crate::camera::{Camera, MAX_PITCH, NamedView, Ray};
use crate::heightfield::reference::Surface;

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

/// Drags and the wheel.
const MODES: [Choice<'static, Mode>; 2] = [
    Choice {
        value: Mode::Fly,
        name: "fly",
        tooltip: "Right drag looks around, the wheel changes the speed.",
        off: None,
    },
    Choice {
        value: Mode::Orbit,
        name: "orbit",
        tooltip: "Drags turn around the middle of the picture, the wheel goes towards the cursor.",
        off: None,
    },
];

/// The point in the middle of the picture: the one that was typed, as long as the eye looks at it, else the ground there, or
/// where there is none, a point on the way.
fn aim(camera: &Camera, typed: Option<DVec3>, facts: &Facts) -> DVec3 {
    let forward = camera.basis().forward;
    let is_ahead = |target: &DVec3| {
        let way = *target - camera.eye;
        way.length() > 0.0 && way.normalize().distance(forward) < 1e-6
    };
    typed.filter(is_ahead).unwrap_or_else(|| {
        let ray = Ray { origin: camera.eye, direction: forward };
        let hit = Surface::new(&facts.map, facts.extent).intersect(&ray);
        hit.map_or(camera.eye + forward, |hit| hit.position)
    })
}

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Start view, default field of view and speed, eye above the ground. Free.";
    section(ui, "Camera", false, Some(reset), |ui, reset| {
        let Panel { scene, view, speed, commands, facts, .. } = panel;
        choose(ui, &mut view.mode, &MODES, "Movement", "What drags and the wheel do (Tab). Free.", None);
        if reset {
            commands.push(Command::View(NamedView::Start));
            **speed = DEFAULT_SPEED;
            view.allow_below_ground = false;
            view.mode = Mode::default();
        }
        if let Some(camera) = &mut scene.camera {
            let axes = [("Eye x", "east"), ("Eye y", "up"), ("Eye z", "south")];
            let values = [&mut camera.eye.x, &mut camera.eye.y, &mut camera.eye.z];
            for ((name, direction), value) in axes.into_iter().zip(values) {
                let tooltip = format!("Position of the eye towards {direction}; the map's longer side is 1. Free.");
                Number::new(name, &tooltip).decimals(4).field(ui, value, -100.0..=100.0, 0.002);
            }
            let mut target = aim(camera, view.target, facts);
            let axes = [("Target x", "east"), ("Target y", "up"), ("Target z", "south")];
            let values = [&mut target.x, &mut target.y, &mut target.z];
            let mut aimed = false;
            for ((name, direction), value) in axes.into_iter().zip(values) {
                let tooltip = format!(
                    "Position towards {direction} of the point in the middle of the picture; a new one is looked at. Free."
                );
                aimed |= Number::new(name, &tooltip).decimals(4).field(ui, value, -100.0..=100.0, 0.002);
            }
            if aimed && target != camera.eye {
                let Camera { yaw, pitch, .. } = Camera::look_at(camera.eye, target, camera.fov);
                (camera.yaw, camera.pitch) = (yaw.rem_euclid(360.0), pitch.clamp(-MAX_PITCH, MAX_PITCH));
                view.target = Some(target);
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
