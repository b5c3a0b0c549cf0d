//! The sea.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, button_unless, choose, section, toggle};
use crate::scene::{LevelUnit, Water};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "No sea, and everything about it as it was.";
    section(ui, "Water", false, Some(reset), |ui, reset| {
        let metres = panel.facts.extent_metres.is_some();
        let water = &mut panel.scene.water;
        if reset {
            *water = Water::default();
        }
        let tooltip = "A sea over the map. A draw of its own with up to two exact walks per pixel of water, about as much as the \
                       picture of the ground itself; while it is off, nothing. Not drawn in a deep zoom, whose pixels are \
                       finer than single precision counts, nor in debug views.";
        toggle(ui, &mut water.enabled, "Enable water", tooltip);
        let off = (!water.enabled).then_some("the water is off");
        level(ui, water, off, metres, panel.facts.range);
        ui.add_enabled_ui(off.is_none(), |ui| {
            let tooltip = "Hills and the occluder are mirrored: a walk per pixel of water. Off, the sky alone is.";
            toggle(ui, &mut water.reflection, "Mirror hills", tooltip);
            let tooltip = "Rays bend at the surface (index 1.333): the sea bed looks nearer, and from below the sky is a window \
                           with a mirror around it. Free.";
            toggle(ui, &mut water.refraction, "Bend rays", tooltip);
        });
        light(ui, water, off);
        motion(ui, water, off);
    });
}

/// A slider that is in use while the water is.
fn number<'a>(name: &'a str, tooltip: &'a str, off: Option<&'a str>) -> Number<'a> {
    Number::new(name, tooltip).disabled_when(off.is_some(), off.unwrap_or_default())
}

fn level(ui: &mut Ui, water: &mut Water, off: Option<&str>, metres: bool, range: [f64; 2]) {
    let choices = [
        Choice {
            value: LevelUnit::Share,
            name: "share",
            tooltip: "A share of the map's height: 0 is its lowest sample, 1 its highest.",
            off: None,
        },
        Choice {
            value: LevelUnit::Metres,
            name: "metres",
            tooltip: "Metres, as the map has them.",
            off: (!metres).then_some("the metres of this map are not known"),
        },
    ];
    let known = metres.then_some(range);
    let share = water.level_share(known).unwrap_or_default();
    let tooltip = "What the level of the sea counts in. It stays where it is. Free.";
    let changed = choose(ui, &mut water.levels, &choices, "Water level in", tooltip, off);
    let [low, high] = range;
    let tooltip = "Height of the sea. Free.";
    let (mut value, moved) = match water.levels {
        LevelUnit::Share => (share as f32, number("Water level", tooltip, off).decimals(3)),
        LevelUnit::Metres => {
            ((low + share * (high - low)) as f32, number("Water level", tooltip, off).unit(" m").decimals(0))
        }
    };
    let rail = match water.levels {
        LevelUnit::Share => 0.0..=1.2,
        LevelUnit::Metres => low as f32..=(low + 1.2 * (high - low)) as f32,
    };
    if moved.slider(ui, &mut value, rail) || (changed && water.level.is_some()) {
        water.level = Some(value);
    }
    let none = water.level.is_none().then_some("the level is the usual one already").or(off);
    let tooltip = "0 m where the map's heights include it and its metres are known; else a third of its height.";
    if button_unless(ui, "Usual water level", tooltip, none) {
        water.level = None;
    }
}

fn light(ui: &mut Ui, water: &mut Water, off: Option<&str>) {
    let tooltip = "How far green light gets through the water until 37 % of it are left; the map's longer side is 1. Red gets a \
                   quarter as far. Free.";
    number("Clarity", tooltip, off).decimals(3).logarithmic().slider(ui, &mut water.clarity, 0.002..=1.0);
    number("Water tint", "0: a blue sea; 1: a green lake. Free.", off).slider(ui, &mut water.tint, 0.0..=1.0);
    let tooltip = "Foam along the shore: at 1 as wide as the water is a thirtieth of the map's height deep; at 0 it is left out \
                   of the shader. Cheap.";
    number("Foam", tooltip, off).slider(ui, &mut water.foam, 0.0..=1.0);
}

fn motion(ui: &mut Ui, water: &mut Water, off: Option<&str>) {
    let tooltip = "Steepness of the waves: 0 is a mirror, and leaves them out of the shader; 1 a stiff breeze. Cheap.";
    number("Waves", tooltip, off).slider(ui, &mut water.waves, 0.0..=1.0);
    let still = off.or((water.waves == 0.0).then_some("the water is a mirror"));
    let tooltip = "Length of the longest waves; the map's longer side is 1. Free.";
    number("Wave length", tooltip, still).decimals(4).logarithmic().slider(ui, &mut water.wave_length, 0.0005..=0.2);
    ui.add_enabled_ui(off.is_none(), |ui| {
        toggle(ui, &mut water.bubbles, "Bubbles", "Bubbles rise around an eye under water. Cheap.");
        let tooltip = "Waves, foam and bubbles move. While water is in view frames are drawn all the time, unless less motion is \
                       wanted.";
        toggle(ui, &mut water.moving, "Moving water", tooltip);
    });
    let tooltip = "Where waves, foam and bubbles are: seconds of their clock. Free.";
    number("Water time", tooltip, off).unit(" s").slider(ui, &mut water.time, 0.0..=3600.0);
}
