//! The import card: what is known of the map, and how every guess is corrected.

use egui::{Align2, Context, Id, Key, Rect, Ui};

use super::Panel;
use super::widgets::{Choice, Number, button, button_unless, choose, fact, section, text, toggle};
use crate::app::files::card::Card;
use crate::app::files::{FilesCommand, Question};
use crate::app::settings::{Command, Facts};
use crate::heightfield::import::{Encoding, Endian, RawType, TooLarge, VerticalUnit};
use crate::heightfield::{Holes, Provenance};

/// Most samples on a side that can be typed.
const MOST: u32 = 1 << 24;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    section(ui, "Import", false, None, |ui, _| {
        let Panel { facts, files, commands, .. } = panel;
        match &files.provenance {
            Some(provenance) => known(ui, provenance, facts),
            None => fact(ui, "Type", "made by a program"),
        }
        ui.separator();
        let card = &mut files.card;
        corrections(ui, card, Some(facts));
        let mut ask = |command| commands.push(Command::Files(command));
        let built_in = (!card.has_file).then_some("this map is no file that could be read in another way");
        let unchanged = (!card.is_changed()).then_some("nothing was changed");
        let reason = built_in.or(card.nodata_error()).or(unchanged);
        ui.horizontal_wrapped(|ui| {
            let tooltip = "Reads the file again in this way. The eye and the craters stay.";
            if button_unless(ui, "Apply import", tooltip, reason) {
                ask(FilesCommand::Apply);
            }
            if button_unless(ui, "Revert import", "Forgets what was changed here. Free.", unchanged) {
                card.revert();
            }
        });
        let tooltip = "Writes a TOML file beside the map that says all this, so that it opens like this again. Comments in \
                       one that is there are lost; what belongs to another map is never replaced.";
        if button_unless(ui, "Keep in a sidecar", tooltip, built_in.or(card.nodata_error())) {
            ask(FilesCommand::Keep);
        }
    });
}

/// What the file says.
fn known(ui: &mut Ui, provenance: &Provenance, facts: &Facts) {
    let packed = provenance.compression.as_deref().map(|packed| format!(", {packed}")).unwrap_or_default();
    fact(ui, "Type", format!("{}, {}{packed}", provenance.format.name(), provenance.sample_type));
    let [columns, rows] = facts.samples;
    let taken = &provenance.taken;
    let [full_columns, full_rows] = taken.full;
    let of = match taken {
        taken if taken.is_whole() => String::new(),
        taken if taken.factor > 1 => {
            format!(", means of {factor} × {factor} of {full_columns} × {full_rows}", factor = taken.factor)
        }
        _ => format!(", a part of {full_columns} × {full_rows}"),
    };
    fact(ui, "Size", format!("{columns} × {rows}{of}"));
    let unit = provenance.vertical_unit.map_or("", |_| " m");
    fact(ui, "Range", format!("{:.2} to {:.2}{unit}", facts.range[0], facts.range[1]));
    fact(ui, "Nodata", format!("{:.3} %", provenance.nodata_fraction * 100.0));
    fact(ui, "CRS", provenance.crs().unwrap_or("unknown"));
    let step = step_of(facts).map_or_else(|| "unknown".to_owned(), |step| format!("{step:.3}"));
    fact(ui, "Step in metres", step);
}

/// Metres from sample to sample; where columns and rows differ, the geometric mean.
fn step_of(facts: &Facts) -> Option<f64> {
    let [east, south] = facts.extent_metres?;
    let cells = facts.samples.map(|count| f64::from(count.max(2) - 1));
    Some((east * south / (cells[0] * cells[1])).sqrt())
}

/// The fields. `facts` are those of the map that is open.
fn corrections(ui: &mut Ui, card: &mut Card, facts: Option<&Facts>) {
    let found = facts.and_then(step_of);
    let mut step = card.draft.metres_per_sample.or(found).unwrap_or(0.0);
    let tooltip = "Metres on the ground from one sample of the file to the next; 0: not known. Counts against what the file says.";
    if Number::new("Metres per sample", tooltip).decimals(4).field(ui, &mut step, 0.0..=1e6, 0.1) {
        card.set_step(step);
    }
    if let Some(facts) = facts {
        let mut range = card.draft.range().unwrap_or(facts.range);
        let tooltip = "What the lowest sample of the file stands for, in metres.";
        let low = Number::new("Lowest metre", tooltip).field(ui, &mut range[0], -1e7..=1e7, 1.0);
        let tooltip = "What the highest sample of the file stands for, in metres.";
        let high = Number::new("Highest metre", tooltip).field(ui, &mut range[1], -1e7..=1e7, 1.0);
        if low || high {
            card.set_range(range);
        }
    }
    let options = &mut card.draft.import;
    let units = [
        (None, "as the file says", "What the file says, else metres."),
        (Some(VerticalUnit::Metre), "metres", "Heights are metres."),
        (Some(VerticalUnit::Foot), "feet", "International feet, 0.3048 m."),
        (Some(VerticalUnit::UsFoot), "US survey feet", "1200/3937 m."),
    ];
    pick(ui, &mut options.vertical_unit, &units, "Heights in", "What the file measures heights in.");
    let holes = [
        (None, "cut out (default)", "As the sidecar says, else cut out."),
        (Some(Holes::CutOut), "cut out", "The ground is missing there, and rays pass."),
        (Some(Holes::Fill), "filled", "A smooth surface spans them, from their border inward."),
        (Some(Holes::Floor), "floored", "They are as low as the lowest sample."),
    ];
    pick(ui, &mut options.holes, &holes, "Holes", "What becomes of samples without a height.");
    let tooltip = "The number that means no height, or the word none. Empty: what the file says.";
    text(ui, &mut card.nodata, "No height is", "no height: what the file says", tooltip);
    let mut flip = options.flip == Some(true);
    if toggle(ui, &mut flip, "Flip north and south", "The rows are stored the other way round than the format says.") {
        options.flip = Some(flip);
    }
    if card.is_picture {
        let encodings = [
            (None, "shades", "The brightness is the height."),
            (Some(Encoding::Terrarium), "Terrarium", "red × 256 + green + blue / 256 − 32768 metres."),
            (Some(Encoding::Mapbox), "Mapbox", "(red × 65536 + green × 256 + blue) / 10 − 10000 metres."),
        ];
        pick(ui, &mut options.encoding, &encodings, "Colours are", "Whether heights are packed into the colours.");
    }
    if card.is_raw {
        raw(ui, card);
    }
    part(ui, card);
}

/// The layout of a file without a header.
fn raw(ui: &mut Ui, card: &mut Card) {
    let options = &mut card.draft.import;
    let mut size = options.raw_size.unwrap_or(card.full);
    let columns = Number::new("Raw columns", "Samples in a row of the file.").field(ui, &mut size[0], 0..=MOST, 1.0);
    let rows = Number::new("Raw rows", "Rows of the file.").field(ui, &mut size[1], 0..=MOST, 1.0);
    if columns || rows {
        // A number for the other side is still to come: kept, and told as too few when it is applied.
        card.full = size;
        options.raw_size = size.iter().all(|&side| side > 0).then_some(size);
    }
    let types: Vec<_> = [(None, "guessed", "By its ending and its length.")]
        .into_iter()
        .chain(RawType::ALL.map(|kind| (Some(kind), kind.name(), "Unsigned, signed, or floating; with so many bits.")))
        .collect();
    pick(ui, &mut options.raw_type, &types, "Raw type", "The type of the file's samples.");
    let orders = [
        (None, "little (default)", "The least significant byte first, unless said otherwise."),
        (Some(Endian::Little), "little", "The least significant byte first, as on a PC."),
        (Some(Endian::Big), "big", "The most significant byte first."),
    ];
    pick(ui, &mut options.raw_endian, &orders, "Raw bytes", "The order of a sample's bytes.");
}

/// How much of the file is taken.
fn part(ui: &mut Ui, card: &mut Card) {
    let options = &mut card.draft.import;
    let larger = [
        (None, "reduce (default)", "As the sidecar says, else reduced."),
        (Some(TooLarge::Reduce), "reduce", "All of it, each sample the mean of as many as it takes."),
        (Some(TooLarge::Window), "middle in full", "Its middle, with every sample."),
    ];
    let tooltip = "What becomes of a map with more samples a side than the adapter's textures.";
    pick(ui, &mut options.too_large, &larger, "Too large", tooltip);
    let mut reduce = options.reduce.unwrap_or(1);
    if Number::new("Reduce", "The mean of so many by so many samples becomes one. Fewer samples, less memory.").field(
        ui,
        &mut reduce,
        1..=1024,
        0.1,
    ) {
        options.reduce = (reduce > 1).then_some(reduce);
    }
    let mut on = options.window.is_some();
    if toggle(ui, &mut on, "Only a part", "Takes a rectangle of the file, with every sample of it.") {
        options.window = on.then_some([0, 0, card.full[0], card.full[1]]);
    }
    if let Some(window) = &mut options.window {
        let names = [
            ("Part from column", "First column, from the west."),
            ("Part from row", "First row, from the north."),
            ("Part columns", "Columns of the part, at least 2."),
            ("Part rows", "Rows of the part, at least 2."),
        ];
        for ((name, tooltip), value) in names.into_iter().zip(window) {
            Number::new(name, tooltip).field(ui, value, 0..=MOST, 1.0);
        }
    }
}

/// A choice among values that may be left open.
fn pick<T: Copy + PartialEq>(
    ui: &mut Ui,
    value: &mut T,
    choices: &[(T, &str, &str)],
    name: &str,
    tooltip: &str,
) -> bool {
    let choices: Vec<_> =
        choices.iter().map(|&(value, name, tooltip)| Choice { value, name, tooltip, off: None }).collect();
    choose(ui, value, &choices, name, tooltip, None)
}

/// Asks how a file is to be read that does not say it. `Some(true)`: open it so; `Some(false)`: do not.
pub(crate) fn ask(ctx: &Context, free: Rect, question: &mut Question) -> Option<bool> {
    let (mut open, mut answer) = (true, None);
    let name = question.path.file_name().unwrap_or(question.path.as_os_str()).to_string_lossy().into_owned();
    let window = egui::Window::new("How is this file to be read?").id(Id::unique("question")).open(&mut open);
    let window = window.collapsible(false).resizable(false).pivot(Align2::CENTER_CENTER).default_pos(free.center());
    window.show(ctx, |ui| {
        ui.set_width(320.0);
        let bytes = std::fs::metadata(&question.path).map_or(0, |found| found.len());
        ui.label(format!("{name}: {}.", question.why));
        let card = &mut question.card;
        ui.push_id("question", |ui| raw(ui, card));
        let size = card.draft.import.raw_size.map_or(0, |[width, height]| u64::from(width) * u64::from(height));
        let each = if size > 0 { bytes as f64 / size as f64 } else { 0.0 };
        let says =
            if size == 0 { "Say columns and rows.".to_owned() } else { format!("That is {each:.3} bytes a sample.") };
        ui.weak(says);
        let reason = (size == 0).then_some("columns and rows are not said");
        ui.horizontal(|ui| {
            if button_unless(ui, "Read the file", "Opens it with this layout.", reason) {
                answer = Some(true);
            }
            if button(ui, "Leave the file", "Does not open it (Esc).") {
                answer = Some(false);
            }
        });
    });
    if !open || ctx.input(|input| input.key_pressed(Key::Escape)) {
        answer = answer.or(Some(false));
    }
    answer
}
