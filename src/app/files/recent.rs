//! The files opened last, kept between runs in a small TOML file.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::folders;
use crate::files;

/// How many are kept.
const MOST: usize = 10;

/// The file's name in the folder for what is remembered.
const FILE: &str = "recent.toml";

/// The file's form. Another form has another number.
const VERSION: u32 = 1;

#[derive(Debug, Serialize, Deserialize)]
struct Stored {
    version: u32,
    files: Vec<PathBuf>,
}

/// The files, the last one first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Recent {
    files: Vec<PathBuf>,
    /// Where they are kept; absent where nothing can be kept.
    store: Option<PathBuf>,
}

impl Recent {
    /// Those of the last run.
    pub(crate) fn read() -> Self {
        folders::config().map(|folder| Self::read_from(folder.join(FILE))).unwrap_or_default()
    }

    fn read_from(store: PathBuf) -> Self {
        let mut recent = Self { files: Vec::new(), store: Some(store) };
        recent.read_again();
        recent
    }

    /// Another viewer may have opened files meanwhile. A file of another form, or none, is as good as an empty one.
    fn read_again(&mut self) {
        let Some(store) = &self.store else { return };
        let Ok(text) = std::fs::read_to_string(store) else { return };
        match toml::from_str::<Stored>(&text) {
            Ok(Stored { version: VERSION, files }) => self.files = files.into_iter().take(MOST).collect(),
            Ok(other) => log::debug!("{} has version {}, and is left out", store.display(), other.version),
            Err(error) => log::debug!("{} is left out: {error}", store.display()),
        }
    }

    /// The last one first.
    pub(crate) fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// A file was opened.
    pub(crate) fn opened(&mut self, path: &Path) {
        self.read_again();
        self.files.retain(|other| other != path);
        self.files.insert(0, path.to_path_buf());
        self.files.truncate(MOST);
        self.write();
    }

    /// A file is not there any more.
    pub(crate) fn gone(&mut self, path: &Path) {
        self.read_again();
        self.files.retain(|other| other != path);
        self.write();
    }

    /// None of them is to be remembered.
    pub(crate) fn forget(&mut self) {
        self.files.clear();
        self.write();
    }

    /// What cannot be remembered is no reason to stop anything.
    fn write(&self) {
        let Some(store) = &self.store else { return };
        let stored = Stored { version: VERSION, files: self.files.clone() };
        let written = toml::to_string(&stored).map_err(std::io::Error::other).and_then(|text| {
            if let Some(folder) = store.parent() {
                std::fs::create_dir_all(folder)?;
            }
            files::write_whole(store, text.as_bytes())
        });
        if let Err(error) = written {
            log::debug!("{} cannot be written: {error}", store.display());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_remembered_the_last_first_and_each_once() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("deep/recent.toml");
        let mut recent = Recent::read_from(store.clone());
        for name in ["/a", "/b", "/a"] {
            recent.opened(Path::new(name));
        }
        assert_eq!(recent.files(), [PathBuf::from("/a"), "/b".into()]);
        // Another viewer opens one, too.
        Recent::read_from(store.clone()).opened(Path::new("/c"));
        recent.opened(Path::new("/d"));
        let names: Vec<_> = recent.files().iter().map(|path| path.display().to_string()).collect();
        assert_eq!(names, ["/d", "/c", "/a", "/b"]);
        recent.gone(Path::new("/c"));
        assert_eq!(Recent::read_from(store.clone()).files().len(), 3);
        (0..20).for_each(|number| recent.opened(Path::new(&format!("/{number}"))));
        assert_eq!(recent.files().len(), MOST);
        recent.forget();
        assert!(Recent::read_from(store).files().is_empty());
    }

    #[test]
    fn a_file_of_another_form_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("recent.toml");
        for text in ["not toml", "version = 9\nfiles = [\"/a\"]\n", "files = 3\n"] {
            std::fs::write(&store, text).unwrap();
            assert!(Recent::read_from(store.clone()).files().is_empty(), "{text}");
        }
        assert_eq!(Recent::default(), Recent { files: Vec::new(), store: None }, "and nothing is written anywhere");
    }
}
