//! The camera path: key frames, playing, its file, and its pictures as an animation.

use egui::Ui;

use super::Panel;
use super::widgets::{Number, button, button_unless, fact, section, text};
use crate::app::settings::{Command, PathCommand, PathEditor};
use crate::camera_path::SECONDS;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    section(ui, "Camera path", false, Some("Removes all key frames. The file stays."), |ui, reset| {
        let Panel { view, commands, facts, .. } = panel;
        let mut ask = |command| commands.push(Command::Path(command));
        if reset {
            ask(PathCommand::Clear);
        }
        let edited = &mut view.path;
        let frames = edited.path.frames.len();
        fact(ui, "Key frames", frames.to_string());
        let none = (frames == 0).then_some("the path has no key frame");
        let no_way = (frames < 2).then_some("a path needs two key frames");
        ui.horizontal_wrapped(|ui| {
            if button(ui, "Add key frame", "Records the eye as the path's next key frame (K). Free.") {
                ask(PathCommand::Add);
            }
            if button_unless(ui, "Remove last key frame", "Removes the last key frame (Shift+K). Free.", none) {
                ask(PathCommand::RemoveLast);
            }
        });
        let tooltip =
            "Time from the first key frame to the last, at constant speed. Each key frame brings three seconds. Free.";
        Number::new("Path time", tooltip).unit(" s").decimals(1).field(ui, &mut edited.path.seconds, SECONDS, 0.05);
        let name = if edited.playing { "Stop path" } else { "Play path" };
        if button_unless(
            ui,
            name,
            "Flies along the path (Space); any key or click on the picture stops it. Draws a frame for every one of the screen.",
            no_way,
        ) {
            ask(PathCommand::Play);
        }
        ui.separator();
        file(ui, edited, none, &mut ask);
        ui.separator();
        animation(ui, edited, (no_way, facts.max_texture), &mut ask);
    });
}

fn file(ui: &mut Ui, edited: &mut PathEditor, none: Option<&str>, ask: &mut impl FnMut(PathCommand)) {
    let tooltip = "The path's file, a TOML; `relief render --path` takes it, too.";
    ui.weak("The path's file");
    text(ui, &mut edited.file, "Path file", "file of the path", tooltip);
    let unnamed = edited.file.trim().is_empty().then_some("no file is named");
    ui.horizontal_wrapped(|ui| {
        if button_unless(
            ui,
            "Save path",
            "Writes the path to the file named above, unless that is another's.",
            none.or(unnamed),
        ) {
            ask(PathCommand::Save);
        }
        if button_unless(ui, "Load path", "Reads the path from the file named above, in place of this one.", unnamed) {
            ask(PathCommand::Load);
        }
    });
}

fn animation(
    ui: &mut Ui,
    edited: &mut PathEditor,
    (no_way, largest): (Option<&str>, u32),
    ask: &mut impl FnMut(PathCommand),
) {
    let tooltip = "Where the path's pictures go: a name that ends in .png or .apng is one animated PNG, any other a new folder with \
                   one PNG each.";
    ui.weak("The animation's file, or folder");
    text(ui, &mut edited.output, "Animation file", "file.png, or a folder", tooltip);
    let [width, height] = &mut edited.size;
    for (name, side) in [("Animation width", width), ("Animation height", height)] {
        let tooltip = "Size of the animation's pictures, in pixels. Time and bytes grow with it.";
        Number::new(name, tooltip).unit(" px").field(ui, side, 16..=largest, 4.0);
    }
    let tooltip = "Pictures of the animation per second. Time and bytes grow with it.";
    Number::new("Pictures per second", tooltip).field(ui, &mut edited.per_second, 1..=240, 0.25);
    fact(ui, "Pictures", edited.path.pictures(edited.per_second).to_string());
    if edited.writing {
        if button(ui, "Cancel animation", "Gives the animation up (Esc); nothing of it is left.") {
            ask(PathCommand::CancelExport);
        }
        return;
    }
    let unnamed = edited.output.trim().is_empty().then_some("no file is named");
    if button_unless(
        ui,
        "Write animation",
        "Draws every picture of the path and writes them: takes a frame's time for each.",
        no_way.or(unnamed),
    ) {
        ask(PathCommand::Export);
    }
}
