//! A made landscape as files: the 16-bit PNG, and its recipe in the sidecar. What `relief generate` writes, byte by byte.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::Recipe;
use super::recipe_file::{self, RecipeFileError};
use crate::files;
use crate::heightfield::save::{SaveError, save_png16};
use crate::heightfield::{HeightField, Sidecar};

/// Why a landscape was not saved: what, why and what to do, a line each.
#[derive(Debug, thiserror::Error)]
pub enum SaveMadeError {
    /// Another name is needed.
    #[error("cannot save {}\n  a made landscape is a 16-bit PNG\n  end its name in .png", path.display())]
    Ending {
        /// The file.
        path: PathBuf,
    },
    /// A file that holds something else.
    #[error("cannot save {}\n  it exists, and holds another map\n  give another name, or move the file away", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The recipe has no place.
    #[error(transparent)]
    Recipe(#[from] RecipeFileError),
    /// The PNG was not written.
    #[error(transparent)]
    Png(#[from] SaveError),
    /// The sidecar was not written.
    #[error("cannot write the recipe to {}\n  the system says: {reason}\n  free some space, or save elsewhere", path.display())]
    Sidecar {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
}

/// Writes `field`, which `recipe` has made, to `path`, and the recipe into the sidecar beside it, whose other keys stay. A
/// map that exists is replaced where its recipe makes the same, or with `replace`.
///
/// # Errors
/// [`SaveMadeError`]; what stood there before stays, except that a sidecar may fail after its map.
pub fn save(field: &HeightField, recipe: &Recipe, path: &Path, replace: bool) -> Result<(), SaveMadeError> {
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    if !is_png {
        return Err(SaveMadeError::Ending { path: path.to_path_buf() });
    }
    let beside = Sidecar::path_of(path);
    let known = recipe_file::read(&beside).ok();
    let same = known.as_ref() == Some(recipe);
    if !replace && !same && (path.exists() || known.is_some()) {
        return Err(SaveMadeError::Exists { path: path.to_path_buf() });
    }
    let existing = match std::fs::read_to_string(&beside) {
        Ok(text) => Some(text),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(_) => return Err(RecipeFileError::InTheWay { path: beside }.into()),
    };
    let text = recipe_file::sidecar_text(&beside, existing.as_deref(), recipe)?;
    save_png16(field, path)?;
    files::write_with(&beside, |file| file.write_all(text.as_bytes()).and_then(|()| file.sync_data()))
        .map_err(|reason| SaveMadeError::Sidecar { path: beside.clone(), reason })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::generate::{Kind, generate};

    #[test]
    fn a_saved_landscape_can_be_made_again_and_replaces_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let recipe = Recipe { size: [17, 17], ..Recipe::new(Kind::Ridged, 3) };
        let field = generate(Kind::Ridged, 17, 3);
        save(&field, &recipe, &path, false).unwrap();
        assert_eq!(recipe_file::read(&folder.path().join("a.toml")).unwrap(), recipe);
        let first = std::fs::read(&path).unwrap();
        save(&field, &recipe, &path, false).unwrap();
        let other = Recipe { seed: 4, ..recipe.clone() };
        let error = save(&generate(Kind::Ridged, 17, 4), &other, &path, false).unwrap_err();
        assert!(matches!(error, SaveMadeError::Exists { .. }) && error.to_string().lines().count() == 3, "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), first, "nothing was replaced");
        save(&generate(Kind::Ridged, 17, 4), &other, &path, true).unwrap();
        assert_ne!(std::fs::read(&path).unwrap(), first);
        // A scene's file is no sidecar.
        std::fs::write(folder.path().join("s.toml"), "[march]\ntechnique = \"linear\"\n").unwrap();
        let error = save(&field, &recipe, &folder.path().join("s.png"), true).unwrap_err();
        assert!(matches!(error, SaveMadeError::Recipe(_)), "{error}");
        assert!(!folder.path().join("s.png").exists());
        let error = save(&field, &recipe, &folder.path().join("s.tif"), false).unwrap_err();
        assert!(error.to_string().contains(".png"), "{error}");
    }
}
