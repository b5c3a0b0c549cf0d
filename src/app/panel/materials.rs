//! What the ground is made of.

use std::path::PathBuf;

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, button_unless, choose, fact, section, text};
use crate::scene::{ColourSource, LevelUnit, MOST_COVERAGE_MAPS, MaterialSettings};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "The ground's usual texture, and the materials' thresholds as they were.";
    section(ui, "Materials", false, Some(reset), |ui, reset| {
        let metres = panel.facts.extent_metres.is_some();
        let path = &mut panel.view.paths.coverage;
        let (diffuse, settings) = (&mut panel.scene.diffuse, &mut panel.scene.materials);
        if reset {
            diffuse.source = ColourSource::default();
            *settings = MaterialSettings::default();
            path.clear();
        }
        source(ui, &mut diffuse.source, diffuse.enabled);
        let off = (diffuse.source != ColourSource::Materials || !diffuse.enabled)
            .then_some("the ground's colour is not that of materials");
        // What is shown is what counts; the first change takes it over from the map.
        let mut shown = settings.for_map(metres.then_some(panel.facts.range));
        let before = shown.clone();
        looks(ui, &mut shown, off);
        slopes(ui, &mut shown, off);
        levels(ui, &mut shown, off, metres, panel.facts.range);
        if shown != before {
            *settings = shown;
        }
        coverage(ui, settings, path);
    });
}

fn source(ui: &mut Ui, source: &mut ColourSource, enabled: bool) {
    let choices = ColourSource::ALL.map(|value| Choice {
        value,
        name: value.name(),
        off: None,
        tooltip: match value {
            ColourSource::Texture => "The texture of the section Diffuse: painted by height and slope, or an image.",
            ColourSource::Materials => "Grass, rock, scree, snow, sand and sea bed, each with textures of its own.",
        },
    });
    let tooltip = "What colours the ground. Materials read four to some twenty texels a pixel, and 11 MB of textures; each \
                   source is a pipeline of its own.";
    choose(ui, source, &choices, "Colour source", tooltip, (!enabled).then_some("the diffuse texture is off"));
}

/// A slider that is in use while the materials are.
fn number<'a>(name: &'a str, tooltip: &'a str, off: Option<&'a str>) -> Number<'a> {
    Number::new(name, tooltip).disabled_when(off.is_some(), off.unwrap_or_default())
}

fn looks(ui: &mut Ui, settings: &mut MaterialSettings, off: Option<&str>) {
    number("Material scale", "Cells of the map under one repeat of the finest texture. Free.", off)
        .logarithmic()
        .slider(ui, &mut settings.scale, 0.1..=50.0);
    let tooltip = "0: meadows and grey rock; 1: dry grass and banded red sandstone. Free.";
    number("Aridity", tooltip, off).slider(ui, &mut settings.aridity, 0.0..=1.0);
    let tooltip =
        "How strongly the textures' relief bends the light; at 0 it is left out of the shader. Needs lighting.";
    number("Material relief", tooltip, off).slider(ui, &mut settings.relief, 0.0..=4.0);
    let tooltip = "Width of the transitions between materials: 0 is a sharp edge, 1 the usual one. Free.";
    number("Softness", tooltip, off).slider(ui, &mut settings.softness, 0.0..=4.0);
}

fn slopes(ui: &mut Ui, settings: &mut MaterialSettings, off: Option<&str>) {
    for (name, tooltip, slope) in [
        ("Scree slope", "Slope from which the ground is scree, in degrees. Free.", &mut settings.scree_slope),
        ("Rock slope", "Slope from which the ground is rock, in degrees. Free.", &mut settings.rock_slope),
        ("Snow slope", "Slope from which no snow stays, in degrees. Free.", &mut settings.snow_slope),
    ] {
        number(name, tooltip, off).unit("°").decimals(1).slider(ui, slope, 0.0..=90.0);
    }
}

fn levels(ui: &mut Ui, settings: &mut MaterialSettings, off: Option<&str>, metres: bool, [low, high]: [f64; 2]) {
    let choices = [
        Choice {
            value: LevelUnit::Share,
            name: "share",
            tooltip: "Shares of the map's height: 0 is its lowest sample, 1 its highest.",
            off: None,
        },
        Choice {
            value: LevelUnit::Metres,
            name: "metres",
            tooltip: "Metres, as the map has them.",
            off: (!metres).then_some("the metres of this map are not known"),
        },
    ];
    let before = settings.levels;
    let tooltip = "What the four levels below count in. They stay where they are. Free.";
    let changed = choose(ui, &mut settings.levels, &choices, "Levels in", tooltip, off);
    let (low, relief) = (low as f32, ((high - low) as f32).max(f32::MIN_POSITIVE));
    let MaterialSettings { snow_line, tree_line, sand_line, sea_level, .. } = settings;
    let all = [
        ("Snow line", "Height from which snow lies. Free.", snow_line),
        ("Tree line", "Height from which nothing grows. Free.", tree_line),
        ("Sand line", "Height up to which flat ground is sand. Free.", sand_line),
        ("Sea bed level", "Height of the sea: the ground below is sea bed. Free.", sea_level),
    ];
    for (name, tooltip, level) in all {
        if changed {
            *level = if before == LevelUnit::Share { low + *level * relief } else { (*level - low) / relief };
        }
        match settings.levels {
            LevelUnit::Share => number(name, tooltip, off).decimals(3).slider(ui, level, -0.1..=1.5),
            LevelUnit::Metres => {
                let (from, to) = (low - 0.1 * relief, low + 1.5 * relief);
                number(name, tooltip, off).unit(" m").decimals(0).slider(ui, level, from..=to)
            }
        };
    }
}

fn coverage(ui: &mut Ui, settings: &mut MaterialSettings, path: &mut String) {
    let names: Vec<_> = settings.coverage.iter().map(|file| file.display().to_string()).collect();
    fact(ui, "Coverage", if names.is_empty() { "by slope and height".to_owned() } else { names.join("; ") });
    let tooltip = "Images whose red, green, blue and alpha weigh grass, rock, scree and snow; behind a ; a second one of the same \
                   size for sand and sea bed. Stretched over the map, north up. Cost their size on the GPU and two texels a pixel.";
    let entered = text(ui, path, "Coverage maps", "paths of images, with ; between", tooltip);
    let paths: Vec<PathBuf> =
        path.split(';').map(str::trim).filter(|path| !path.is_empty()).map(PathBuf::from).collect();
    ui.horizontal(|ui| {
        let unusable = match paths.len() {
            0 => Some("no path is given"),
            1..=MOST_COVERAGE_MAPS => None,
            _ => Some("a set has two images at most"),
        };
        let apply = button_unless(ui, "Apply coverage maps", "Puts the materials where the images say.", unusable);
        if apply || entered && unusable.is_none() {
            settings.coverage = paths;
        }
        let none = settings.coverage.is_empty().then_some("slope and height decide already");
        if button_unless(ui, "No coverage maps", "Slope and height decide again.", none) {
            settings.coverage.clear();
        }
    });
}
