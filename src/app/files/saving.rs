//! Writing the edited map: heights with their craters, at their place.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Align2, Button, Context, Id, Key, Rect, TextEdit};

use super::FilesCommand;
use super::maps::Source;
use crate::heightfield::companions;
use crate::heightfield::export::{self, ExportFormat};
use crate::heightfield::import::Elevation;
use crate::heightfield::{Crater, EditedTerrain, HeightField, Provenance};

/// The window that asks for the file's name.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SaveForm {
    /// It is open.
    pub(crate) open: bool,
    /// What stands in the field.
    typed: String,
    /// A file that exists, while it is asked whether it may be replaced.
    exists: Option<PathBuf>,
}

impl SaveForm {
    /// Opens it with a name beside the map, or in `folder` where the map is no file of the user's.
    pub(crate) fn ask(&mut self, source: Option<&Source>, folder: &Path) {
        if self.typed.is_empty() || !self.open {
            let (folder, stem) = match source {
                Some(Source::File(path)) => {
                    (path.parent().unwrap_or(folder), path.file_stem().map(|stem| stem.to_string_lossy().into_owned()))
                }
                Some(Source::Piece(piece)) => {
                    (folder, Path::new(piece.file_name()).file_stem().map(|stem| stem.to_string_lossy().into_owned()))
                }
                Some(Source::Made(recipe)) => (folder, Some(format!("{}-{}", recipe.kind.name(), recipe.seed))),
                Some(Source::Canyon) | None => (folder, Some("grand-canyon".to_owned())),
            };
            let stem = stem.unwrap_or_else(|| "map".to_owned());
            self.typed = folder.join(format!("{stem}-edited.tif")).display().to_string();
        }
        (self.open, self.exists) = (true, None);
    }

    /// What is wrong with what was typed, before anything is tried.
    fn reason(&self) -> Option<String> {
        let path = Path::new(self.typed.trim());
        if path.file_name().is_none() {
            return Some("no name is given".into());
        }
        ExportFormat::of(path).is_none().then(|| format!("the name has to end in one of {}", ExportFormat::ENDINGS))
    }

    /// What pressing the button does: saves, or asks first.
    fn press(&mut self, replace: bool) -> Option<FilesCommand> {
        let path = PathBuf::from(self.typed.trim());
        if path.exists() && !(replace && self.exists.as_ref() == Some(&path)) {
            self.exists = Some(path);
            return None;
        }
        (self.open, self.exists) = (false, None);
        Some(FilesCommand::Save(path, replace))
    }

    /// Draws it, while it is open.
    pub(crate) fn show(&mut self, ctx: &Context, free: Rect) -> Option<FilesCommand> {
        if !self.open {
            return None;
        }
        let (mut open, mut command) = (true, None);
        let window = egui::Window::new("Save the edited map").id(Id::unique("save")).open(&mut open).collapsible(false);
        let window = window.resizable(false).pivot(Align2::CENTER_CENTER).default_pos(free.center());
        window.show(ctx, |ui| {
            ui.set_width(420.0);
            ui.label("The heights with their craters, at the map's place.");
            let field = ui.add(TextEdit::singleline(&mut self.typed).desired_width(f32::INFINITY));
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let tooltip =
                "The ending says the format: .tif keeps everything; .png, .r16 have 16 bits; .asc, .flt, .r32.";
            field.on_hover_text(tooltip).accessible_name("File to save to");
            let reason = self.reason();
            match (&reason, self.format_note()) {
                (Some(reason), _) => drop(ui.label(format!("⚠ {reason}"))),
                (None, note) => drop(ui.weak(note)),
            }
            if self.exists.as_deref() == Some(Path::new(self.typed.trim())) {
                ui.label("⚠ This file exists.");
                if ui.button("Replace the file").on_hover_text("The old file is lost.").clicked() {
                    command = self.press(true);
                }
            }
            ui.horizontal(|ui| {
                let save = ui
                    .add_enabled(reason.is_none(), Button::new("Save the map"))
                    .on_hover_text("Written whole or not at all.");
                if save.clicked() || entered && reason.is_none() {
                    command = self.press(false);
                }
                if ui.button("Do not save").on_hover_text("Closes this window (Esc).").clicked() {
                    self.open = false;
                }
            });
        });
        self.open &= open && !ctx.input(|input| input.key_pressed(Key::Escape));
        command
    }

    fn format_note(&self) -> &'static str {
        match ExportFormat::of(Path::new(self.typed.trim())) {
            Some(ExportFormat::Tif) => "GeoTIFF: heights in metres, holes, place.",
            Some(ExportFormat::Png) => "16-bit PNG; its heights in metres and its place go into a sidecar.",
            Some(ExportFormat::Asc) => "ESRI ASCII grid; its reference system goes into a sidecar.",
            Some(ExportFormat::Flt) => "32-bit floats with an ESRI header.",
            Some(ExportFormat::R16) => "Raw 16-bit samples; all else goes into a sidecar.",
            Some(ExportFormat::R32) => "Raw 32-bit floats; all else goes into a sidecar.",
            None => "",
        }
    }
}

/// What is to be written.
pub(crate) struct Job {
    /// The file, absolute.
    pub(crate) path: PathBuf,
    /// It may be replaced.
    pub(crate) replace: bool,
    /// The map without craters.
    pub(crate) map: Arc<HeightField>,
    /// The craters, oldest first.
    pub(crate) craters: Vec<Crater>,
    /// Where the map came from.
    pub(crate) provenance: Option<Provenance>,
}

impl Job {
    /// Writes it. The message to show; what is wrong comes with what to do.
    pub(crate) fn run(self) -> Result<String, String> {
        let path = &self.path;
        let shown = path.display();
        let Some(format) = ExportFormat::of(path) else {
            return Err(format!("cannot save {shown}\nno format has its ending\nend it in {}", ExportFormat::ENDINGS));
        };
        let source = self.provenance.as_ref().and_then(|provenance| provenance.path.as_deref());
        if source.is_some_and(|source| same_file(source, path)) {
            return Err(format!(
                "cannot save {shown}\nit is the map itself, and the ground without craters would be lost\ngive another name"
            ));
        }
        if path.exists() && !self.replace {
            return Err(format!(
                "cannot save {shown}\nit exists by now\nsave again and choose to replace it, or give another name"
            ));
        }
        companions::check(path, false).map_err(|error| error.to_string())?;
        let mut terrain = EditedTerrain::new(self.map);
        terrain.set_craters(&self.craters);
        let (elevation, sidecar) = match &self.provenance {
            Some(provenance) => (provenance.elevation(terrain.field()), Some(provenance.sidecar_to_write())),
            None => (Elevation::of_field(terrain.field(), None), None),
        };
        let written = export::write(&elevation, sidecar.as_ref(), format, path).map_err(|error| error.to_string())?;
        let beside = match written.companions.as_slice() {
            [] => String::new(),
            [one] => format!(", and {}", one.display()),
            several => format!(", and {} files beside it", several.len()),
        };
        let rounded = match written.rounded_by {
            0.0 => String::new(),
            by => format!(". 16 bits hold its heights to within {by:.2e}"),
        };
        Ok(format!("Saved {shown}{beside}{rounded}"))
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    let whole = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| super::absolute(path));
    whole(a) == whole(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::load;

    fn job(folder: &Path, name: &str, replace: bool) -> Job {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats/special/nan.tif");
        let loaded = load::load(&source).unwrap();
        let provenance = Some(Provenance::of(&loaded, Some(source)));
        let craters = vec![Crater { x: 0.4, z: 0.5, radius: 0.2, depth: 0.3, rim: 0.1 }];
        Job { path: folder.join(name), replace, map: Arc::new(loaded.field), craters, provenance }
    }

    /// Edit, export, open again: the same samples, the same place.
    #[test]
    fn an_edited_map_opens_again_as_it_was_saved() {
        let folder = tempfile::tempdir().unwrap();
        for (name, within) in
            [("a.tif", 1e-4), ("b.r32", 1e-4), ("c.flt", 1e-4), ("d.asc", 1e-4), ("e.png", 0.01), ("f.r16", 0.01)]
        {
            let job = job(folder.path(), name, false);
            let mut edited = EditedTerrain::new(Arc::clone(&job.map));
            edited.set_craters(&job.craters);
            let place = job.provenance.as_ref().and_then(|provenance| provenance.georeference.clone());
            let message = job.run().unwrap();
            assert!(message.contains(name), "{message}");
            let again = load::load(&folder.path().join(name)).unwrap();
            assert!(again.warnings.is_empty(), "{name}: {:?}", again.warnings);
            assert_eq!(again.georeference, place, "{name}");
            assert_eq!(again.field.holes(), edited.field().holes(), "{name}");
            assert_eq!(again.field.extent_metres(), edited.field().extent_metres(), "{name}");
            let height = |field: &HeightField, index: usize| {
                let [low, high] = field.range();
                low + f64::from(field.samples()[index]) * (high - low)
            };
            for index in (0..again.field.samples().len()).filter(|&index| !again.field.holes().unwrap().contains(index))
            {
                let off = (height(&again.field, index) - height(edited.field(), index)).abs();
                assert!(off <= within, "{name}, sample {index}: {off} m");
            }
        }
    }

    #[test]
    fn nothing_is_replaced_without_a_word() {
        let folder = tempfile::tempdir().unwrap();
        job(folder.path(), "a.tif", false).run().unwrap();
        assert!(job(folder.path(), "a.tif", false).run().unwrap_err().contains("exists"));
        job(folder.path(), "a.tif", true).run().unwrap();
        assert!(job(folder.path(), "a.jpg", false).run().unwrap_err().contains(".png"));
        let mut itself = job(folder.path(), "a.tif", true);
        itself.path = itself.provenance.as_ref().and_then(|provenance| provenance.path.clone()).unwrap();
        assert!(itself.run().unwrap_err().contains("the map itself"));
        std::fs::write(folder.path().join("s.toml"), "[camera]\nfov = 50.0\n").unwrap();
        assert!(job(folder.path(), "s.png", false).run().unwrap_err().contains("no sidecar"));
        assert!(!folder.path().join("s.png").exists());

        let mut form = SaveForm { open: true, typed: folder.path().join("a.tif").display().to_string(), exists: None };
        assert_eq!(form.press(false), None, "it asks first");
        assert!(form.open && form.exists.is_some());
        form.typed = folder.path().join("b.tif").display().to_string();
        std::fs::write(folder.path().join("b.tif"), "").unwrap();
        assert_eq!(form.press(true), None, "the yes was for another file");
        assert_eq!(form.press(true), Some(FilesCommand::Save(folder.path().join("b.tif"), true)));
    }

    #[test]
    fn a_name_without_a_format_is_told_while_it_is_typed() {
        let mut form = SaveForm::default();
        form.ask(Some(&Source::File("/maps/alps.tif".into())), Path::new("."));
        assert_eq!((form.open, form.typed.as_str(), form.reason()), (true, "/maps/alps-edited.tif", None));
        form.typed = "alps.jpg".into();
        assert!(form.reason().is_some_and(|reason| reason.contains(".tif")));
        form.typed = "  ".into();
        assert!(form.reason().is_some());
    }
}
