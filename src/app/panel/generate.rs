//! Terrain from a recipe: the picture follows as its numbers are dragged.

use std::hash::{BuildHasher, RandomState};

use egui::{ProgressBar, Ui};

use super::Panel;
use super::widgets::{Choice, Number, button, button_unless, choose, section, text, toggle};
use crate::app::generating::{Draft, MakeCommand, is_whole};
use crate::app::settings::Command;
use crate::heightfield::generate::{Kind, Recipe};

/// Samples along each side that can be chosen.
const SIZES: [(u32, &str); 7] = [
    (257, "257 × 257"),
    (513, "513 × 513"),
    (1025, "1025 × 1025"),
    (2049, "2049 × 2049"),
    (4097, "4097 × 4097"),
    (8193, "8193 × 8193"),
    (16385, "16385 × 16385"),
];
/// Largest seed that the dice roll: short enough to be read out.
const MOST_ROLLED: u64 = 1_000_000;
/// Largest seed that the field takes: a double tells it from the next.
const MOST_SEED: u64 = 1 << 53;
/// Drops, steps and passes that the rails reach.
const MOST_DROPS: f64 = 4.0;
const MOST_SLIDES: u32 = 200;
const MOST_PASSES: u32 = 16;
/// How displacement falls in the fields, where it is to fall otherwise than by the roughness.
const SCHEDULE_HINT: &str = "such as 1, 0.7, 0.3; then the roughness goes on";

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "The recipe of a first start: crests of seed 1. What is on screen stays.";
    section(ui, "Generate", false, Some(reset), |ui, reset| {
        let Panel { view, commands, facts, files, scene, .. } = panel;
        let mut ask = |command| commands.push(Command::Make(command));
        let draft = &mut view.generate;
        if reset {
            draft.take(&Draft::default().recipe);
        }
        let shown = files.maps.current().and_then(|map| map.source.recipe()).cloned();
        let craters = scene.craters.list.len();
        if shown.is_some() && craters > 0 {
            ui.label(format!(
                "⚠ The next change makes another map: this one stays in the list with its craters ({craters}), Ctrl+Shift+Tab."
            ));
        }
        let before = draft.recipe.clone();
        kind_and_seed(ui, draft, facts.max_texture);
        shape(ui, draft);
        erosion(ui, &mut draft.recipe);
        let wrong = draft.recipe.validate().err();
        if let Some(error) = &wrong {
            ui.label(format!("⚠ {} cannot be {}: {}. Give {}.", error.field, error.value, error.why, error.instead));
        }
        if draft.recipe != before && !reset {
            ask(MakeCommand::Changed);
        }
        ui.separator();
        let whole = shown.as_ref() == Some(&draft.recipe) && is_whole(&draft.recipe, facts);
        make(ui, draft, (wrong.is_some(), whole), &mut ask);
        save(ui, draft, whole, &mut ask);
    });
}

fn kind_and_seed(ui: &mut Ui, draft: &mut Draft, max_texture: u32) {
    let recipe = &mut draft.recipe;
    let kinds = Kind::ALL.map(|value| Choice {
        value,
        name: value.name(),
        off: None,
        tooltip: match value {
            Kind::DiamondSquare => "Random midpoint displacement, as in the study of 2003.",
            Kind::Perlin => "Octaves of gradient noise (fBm): rolling hills.",
            Kind::Ridged => "A ridged multifractal: mountain crests over smooth valleys.",
            Kind::Warped => "Gradient noise at displaced places: folded land.",
        },
    });
    choose(
        ui,
        &mut recipe.kind,
        &kinds,
        "Kind of land",
        "What the terrain is made of. A change makes it at once.",
        None,
    );
    let tooltip = "The same seed makes the same land, on every machine. G goes to the next.";
    Number::new("Seed", tooltip).field(ui, &mut recipe.seed, 0..=MOST_SEED, 0.05);
    if button(ui, "🎲 Roll the seed", "A seed by chance.") {
        recipe.seed = RandomState::new().hash_one(recipe.seed) % MOST_ROLLED;
    }
    let too_large = format!("the textures of this adapter end at {max_texture}");
    let sizes = SIZES.map(|(side, name)| Choice {
        value: [side; 2],
        name,
        tooltip: "Samples along each side. Time and memory grow with their square; a drag shows 257 × 257 meanwhile.",
        off: (side > max_texture).then_some(too_large.as_str()),
    });
    choose(ui, &mut recipe.size, &sizes, "Land size", "Samples of the whole map, made once the controls rest.", None);
    let tooltip = "Opposite borders are equal, so that copies fit side by side.";
    toggle(ui, &mut recipe.tileable, "Tileable", tooltip);
}

fn shape(ui: &mut Ui, draft: &mut Draft) {
    let recipe = &mut draft.recipe;
    let tooltip = "Height of an octave, or of a level of halving, over the one before: 0 is smooth, 1 is noise.";
    Number::new("Roughness", tooltip).slider(ui, &mut recipe.roughness, 0.0..=1.0);
    let square = recipe.kind == Kind::DiamondSquare;
    let noise =
        |name, tooltip| Number::new(name, tooltip).disabled_when(square, "diamond-square always halves the whole map");
    noise("Hills", "Cells of the coarsest octave along the longer side.").decimals(1).logarithmic().slider(
        ui,
        &mut recipe.scale,
        0.1..=64.0,
    );
    let mut limited = recipe.octaves.is_some();
    ui.add_enabled_ui(!square, |ui| {
        let tooltip = "Fewer octaves than the size has room for, which are eight and more. Off: down to two samples.";
        if toggle(ui, &mut limited, "Limit octaves", tooltip) {
            recipe.octaves = limited.then_some(6);
        }
    });
    let mut octaves = recipe.octaves.unwrap_or(6);
    let number = noise("Octaves", "How many octaves of noise. Each takes as long as the first.");
    if number.disabled_when(recipe.octaves.is_none(), "the size decides").slider(ui, &mut octaves, 1..=16) {
        recipe.octaves = Some(octaves);
    }
    noise("Lacunarity", "Frequency of an octave over the one before.").slider(ui, &mut recipe.lacunarity, 1.1..=8.0);
    let not = |kind: Kind| recipe.kind != kind;
    let (no_square, no_ridges, no_warp) = (not(Kind::DiamondSquare), not(Kind::Ridged), not(Kind::Warped));
    ui.add_enabled_ui(!no_square, |ui| {
        let tooltip = "diamond-square: how far each halving displaces, coarse to fine, as the study of 2003 lets it fall. \
                       Empty: by the roughness alone.";
        let before = draft.schedule.clone();
        text(ui, &mut draft.schedule, "Schedule", SCHEDULE_HINT, tooltip);
        if draft.schedule != before
            && let Some(numbers) = schedule(&draft.schedule)
        {
            recipe.midpoint.schedule = numbers;
        }
    });
    let of = |name, tooltip, off: bool, kind| Number::new(name, tooltip).disabled_when(off, kind);
    of(
        "Smoothing",
        "Passes of smoothing at the end, as in the study of 2003.",
        no_square,
        "only diamond-square is smoothed",
    )
    .slider(ui, &mut recipe.midpoint.smoothing, 0..=MOST_PASSES);
    let ridged = "only ridged land has crests";
    of("Ridge offset", "What the noise is subtracted from: 1 makes the sharpest crests.", no_ridges, ridged).slider(
        ui,
        &mut recipe.ridges.offset,
        0.5..=2.0,
    );
    of("Ridge gain", "How much detail gathers on crests.", no_ridges, ridged).slider(
        ui,
        &mut recipe.ridges.gain,
        0.0..=16.0,
    );
    of("Warp", "How far places are displaced, in cells of the coarsest octave.", no_warp, "only warped land is folded")
        .slider(ui, &mut recipe.warp.strength, 0.0..=8.0);
}

/// The numbers of a schedule as typed; `None` while it is none.
fn schedule(typed: &str) -> Option<Vec<f64>> {
    let parts = typed.split(',').map(str::trim).filter(|part| !part.is_empty());
    let numbers: Option<Vec<f64>> = parts.map(|part| part.parse().ok()).collect();
    numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite() && *number >= 0.0))
}

fn erosion(ui: &mut Ui, recipe: &mut Recipe) {
    let tooltip = "Hydraulic erosion: drops of rain for each sample. 0 is none, 0.5 digs valleys. Takes some microseconds a drop.";
    Number::new("Rain", tooltip).unit(" drops").slider(ui, &mut recipe.hydraulic.drops, 0.0..=MOST_DROPS);
    let dry = recipe.hydraulic.drops <= 0.0;
    let rain = |name, tooltip| Number::new(name, tooltip).disabled_when(dry, "it does not rain");
    rain("Rain strength", "How fast drops take up soil.").slider(ui, &mut recipe.hydraulic.strength, 0.0..=1.0);
    rain("Rain radius", "Samples around a drop that soil is taken from.").slider(
        ui,
        &mut recipe.hydraulic.radius,
        1..=8,
    );
    let tooltip = "Steps of a drop at most, of one sample's distance each.";
    rain("Drop lifetime", tooltip).logarithmic().slider(ui, &mut recipe.hydraulic.lifetime, 1..=1000);
    let tooltip = "Thermal erosion: steps in which slopes that are too steep slide. 0 is none, 20 make screes.";
    Number::new("Sliding", tooltip).unit(" steps").slider(ui, &mut recipe.thermal.iterations, 0..=MOST_SLIDES);
    let rests = recipe.thermal.iterations == 0;
    let slide = |name, tooltip| Number::new(name, tooltip).disabled_when(rests, "nothing slides");
    slide("Sliding share", "Share of what can slide in a step that does.").slider(
        ui,
        &mut recipe.thermal.strength,
        0.0..=1.0,
    );
    slide("Resting slope", "Rise over run at which material rests; 0.7 is 35°.").slider(
        ui,
        &mut recipe.thermal.talus,
        0.0..=2.0,
    );
}

fn make(ui: &mut Ui, draft: &Draft, (wrong, whole): (bool, bool), ask: &mut impl FnMut(MakeCommand)) {
    let reason = if wrong { Some("this recipe makes nothing") } else { whole.then_some("it is on screen") };
    ui.horizontal(|ui| {
        let tooltip =
            "Makes the whole map of this recipe. It joins the open maps, or takes the place of a made one on screen.";
        if button_unless(ui, "Make the land", tooltip, reason) {
            ask(MakeCommand::Make);
        }
        if button_unless(
            ui,
            "Next seed",
            "The land of the next seed (G).",
            wrong.then_some("this recipe makes nothing"),
        ) {
            ask(MakeCommand::NextSeed);
        }
    });
    if let Some(share) = draft.share {
        ui.add(ProgressBar::new(share).text(format!("{:.0} %", share * 100.0)));
        if button(ui, "Cancel making", "Keeps the terrain that is there (Esc).") {
            ask(MakeCommand::Cancel);
        }
    }
}

fn save(ui: &mut Ui, draft: &mut Draft, whole: bool, ask: &mut impl FnMut(MakeCommand)) {
    let tooltip = "The file of the map, a 16-bit PNG. The recipe goes into the TOML file beside it.";
    text(ui, &mut draft.file, "Land file", "map.png", tooltip);
    let unnamed = draft.file.trim().is_empty().then_some("no file is named");
    let reason = (!whole).then_some("the whole land of this recipe is not on screen").or(unnamed);
    let tooltip = "Writes what `relief generate --recipe` writes, byte by byte. Another map's file is not replaced.";
    if button_unless(ui, "Save as…", tooltip, reason) {
        ask(MakeCommand::Save);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schedule_counts_once_it_is_one() {
        assert_eq!(schedule("1, 0.7,0.3"), Some(vec![1.0, 0.7, 0.3]));
        assert_eq!(schedule(" "), Some(Vec::new()));
        assert_eq!(schedule("1, 0.5,"), Some(vec![1.0, 0.5]), "the next number is still to come");
        for typed in ["1, x", "-1", "nan", "inf"] {
            assert_eq!(schedule(typed), None, "{typed}");
        }
    }
}
