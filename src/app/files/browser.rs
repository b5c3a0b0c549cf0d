//! A dialogue of our own for choosing a file, where the system has none.

use std::path::{Path, PathBuf};

use egui::{Align2, Button, Context, Id, Key, Rect, ScrollArea, TextEdit};

use crate::heightfield::companions::MAP_ENDINGS;

/// Most entries of a folder that are listed; what is beyond can be typed.
const MOST: usize = 2000;

/// What the user wants.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Answer {
    /// Open this file.
    Open(PathBuf),
    /// Nothing.
    Close,
}

/// The dialogue.
#[derive(Clone, Debug, Default)]
pub(crate) struct Browser {
    folder: PathBuf,
    /// What stands in the field: the folder, or a file being typed.
    typed: String,
    /// Files of every ending are listed.
    all: bool,
    folders: Vec<String>,
    files: Vec<String>,
    /// Why the folder cannot be listed, or that not all of it is.
    says: Option<String>,
}

impl Browser {
    /// A dialogue that shows `folder`.
    pub(crate) fn new(folder: PathBuf) -> Self {
        let mut browser = Self::default();
        browser.go(folder);
        browser
    }

    fn go(&mut self, folder: PathBuf) {
        self.typed = folder.display().to_string();
        self.folder = folder;
        self.list();
    }

    /// Reads the folder: sub-folders, and files that may be maps; what is hidden is left out.
    fn list(&mut self) {
        (self.folders, self.files, self.says) = (Vec::new(), Vec::new(), None);
        let entries = match std::fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            Err(error) => {
                self.says = Some(format!("This folder cannot be read: {error}. Choose another."));
                return;
            }
        };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with('.') {
                continue;
            }
            let path = entry.path();
            if path.is_dir() {
                self.folders.push(name);
            } else if self.all || is_map(&path) {
                self.files.push(name);
            }
            if self.folders.len() + self.files.len() >= MOST {
                self.says = Some(format!("Only {MOST} entries are listed. Type the name of what is missing."));
                break;
            }
        }
        let key = |name: &String| name.to_lowercase();
        self.folders.sort_by_key(key);
        self.files.sort_by_key(key);
    }

    /// Goes to what was typed, or opens it.
    fn enter(&mut self) -> Option<Answer> {
        let path = self.folder.join(self.typed.trim());
        if path.is_dir() {
            self.go(path);
            None
        } else if path.is_file() {
            Some(Answer::Open(path))
        } else {
            self.says = Some("There is no such file or folder. Check the path.".into());
            None
        }
    }

    /// Draws it in the middle of what the panel leaves free.
    pub(crate) fn show(&mut self, ctx: &Context, free: Rect) -> Option<Answer> {
        let (mut open, mut answer) = (true, None);
        let window = egui::Window::new("Open a map").id(Id::unique("browser")).open(&mut open).collapsible(false);
        let window = window.default_size([460.0, 380.0]).pivot(Align2::CENTER_CENTER).default_pos(free.center());
        window.show(ctx, |ui| {
            ui.horizontal(|ui| {
                let up = self.folder.parent().map(Path::to_path_buf);
                let button =
                    ui.add_enabled(up.is_some(), Button::new("⬆ Up")).on_hover_text("The folder around this one.");
                if let (true, Some(up)) = (button.clicked(), up) {
                    self.go(up);
                }
                let field = ui.add(TextEdit::singleline(&mut self.typed).desired_width(f32::INFINITY));
                let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                field.on_hover_text("A folder or a file; Enter goes there.").accessible_name("Path to open");
                if entered {
                    answer = self.enter();
                }
            });
            if let Some(says) = &self.says {
                ui.label(format!("⚠ {says}"));
            }
            let height = (ui.available_height() - 34.0).max(60.0);
            let mut into = None;
            ScrollArea::vertical().max_height(height).auto_shrink(false).show(ui, |ui| {
                for name in &self.folders {
                    if ui.add(Button::new(format!("📁 {name}")).frame(false)).clicked() {
                        into = Some(self.folder.join(name));
                    }
                }
                for name in &self.files {
                    if ui.add(Button::new(name).frame(false)).clicked() {
                        answer = Some(Answer::Open(self.folder.join(name)));
                    }
                }
                if self.folders.is_empty() && self.files.is_empty() && self.says.is_none() {
                    ui.weak("No maps here.");
                }
            });
            if let Some(folder) = into {
                self.go(folder);
            }
            ui.horizontal(|ui| {
                let tooltip = "Also files whose endings are none of a map: formats are told by their first bytes.";
                if ui.checkbox(&mut self.all, "All files").on_hover_text(tooltip).changed() {
                    self.list();
                }
                if ui.button("Do not open").on_hover_text("Closes this dialogue (Esc).").clicked() {
                    answer = Some(Answer::Close);
                }
            });
        });
        if !open || ctx.input(|input| input.key_pressed(Key::Escape)) {
            answer = answer.or(Some(Answer::Close));
        }
        answer
    }
}

/// Whether a file's ending is that of a map.
fn is_map(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| MAP_ENDINGS.contains(&ending.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_come_first_and_only_maps_are_listed_unless_all_are_wanted() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.TIF", "a.png", "notes.txt", ".hidden.png"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("tiles")).unwrap();
        let mut browser = Browser::new(folder.path().to_path_buf());
        assert_eq!(
            (browser.folders.as_slice(), browser.files.as_slice()),
            (&["tiles".to_owned()][..], &["a.png".to_owned(), "b.TIF".into()][..])
        );
        browser.all = true;
        browser.list();
        assert_eq!(browser.files, ["a.png", "b.TIF", "notes.txt"]);
        browser.typed = "tiles".into();
        assert_eq!(browser.enter(), None);
        assert_eq!(browser.folder, folder.path().join("tiles"));
        browser.typed = folder.path().join("a.png").display().to_string();
        assert_eq!(browser.enter(), Some(Answer::Open(folder.path().join("a.png"))));
        browser.typed = "none.png".into();
        assert!(browser.enter().is_none() && browser.says.is_some_and(|says| says.contains("no such file")));
        assert!(Browser::new(folder.path().join("none")).says.is_some());
    }
}
