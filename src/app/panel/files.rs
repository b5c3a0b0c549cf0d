//! Files: the open maps, opening and saving, the files opened last, the gallery of what ships.

use std::path::Path;

use egui::{Button, Ui};

use super::Panel;
use super::widgets::{button, section};
use crate::app::files::maps::Source;
use crate::app::files::{Files, FilesCommand};
use crate::app::settings::Command;
use crate::app::viewer::Viewer;

/// Longest name of a recent file, characters: so much fits the panel.
const LONGEST: usize = 44;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    section(ui, "Files", true, None, |ui, _| {
        let Panel { files, commands, .. } = panel;
        let mut ask = |command| commands.push(Command::Files(command));
        ui.horizontal_wrapped(|ui| {
            let tooltip = "Chooses maps in a dialogue (Ctrl+O). Files can be dropped on the window, too.";
            if button(ui, "Open files…", tooltip) {
                ask(FilesCommand::Choose);
            }
            let tooltip = "Writes the heights with their craters to a file (Ctrl+S): GeoTIFF, PNG, raw and others.";
            if button(ui, "Save edited map…", tooltip) {
                ask(FilesCommand::AskToSave);
            }
        });
        if files.maps.len() > 1 {
            ui.weak("Open maps");
            for (index, map) in files.maps.iter().enumerate() {
                let label = format!("{}: {}", index + 1, map.name());
                let shown = index == files.maps.index();
                let tooltip = "Goes to this map, where you left it (Ctrl+Tab goes to the next). It is read again.";
                let item = ui.add(Button::selectable(shown, short(&label))).on_hover_text(tooltip);
                if item.clicked() && !shown {
                    ask(FilesCommand::GoTo(index));
                }
            }
        }
        ui.horizontal(|ui| menus(ui, files, &mut ask));
    });
}

/// The gallery and the files opened last, as menus.
fn menus(ui: &mut Ui, files: &Files, ask: &mut impl FnMut(FilesCommand)) {
    ui.menu_button("Gallery", |ui| {
        for source in Viewer::shipped() {
            let tooltip = match &source {
                Source::Piece(piece) => format!("{} Made when it is first opened.", piece.describe()),
                _ => "The map that is inside the program.".to_owned(),
            };
            if button(ui, &source.name(), &tooltip) {
                ask(FilesCommand::OpenShipped(source));
            }
        }
    });
    if !files.recent.files().is_empty() {
        ui.menu_button("Recent files", |ui| {
            for path in files.recent.files() {
                let item = ui.add(Button::new(short(&path.display().to_string())).frame(false));
                if item.on_hover_text(format!("Opens {}.", path.display())).clicked() {
                    ask(FilesCommand::Open(vec![path.clone()]));
                }
            }
            if button(ui, "Forget recent files", "Empties this list. The files stay.") {
                ask(FilesCommand::ForgetRecent);
            }
        });
    }
}

/// The end of a long name: that is where paths differ.
fn short(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    if letters.len() <= LONGEST {
        return text.to_owned();
    }
    let name = Path::new(text).file_name().map_or(0, |name| name.to_string_lossy().chars().count());
    let kept = LONGEST.max(name.min(2 * LONGEST)) - 1;
    format!("…{}", letters[letters.len().saturating_sub(kept)..].iter().collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_path_keeps_its_end() {
        assert_eq!(short("/maps/a.tif"), "/maps/a.tif");
        let long = format!("/{}/alps.tif", "deep/".repeat(20));
        assert!(short(&long).ends_with("/deep//alps.tif") && short(&long).starts_with('…'));
        assert_eq!(short(&long).chars().count(), LONGEST);
    }
}
