//! Recipes in TOML: the `[recipe]` table of a map's sidecar.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::recipe::{Recipe, RecipeError};
use crate::heightfield::Sidecar;

/// A file with no such table is no recipe; a sidecar's other keys do not matter.
#[derive(Serialize, Deserialize)]
struct RecipeFile {
    recipe: Option<Recipe>,
}

/// Why a recipe cannot be used: what, why and what to do, a line each.
#[derive(Debug, thiserror::Error)]
pub enum RecipeFileError {
    /// The file could not be read.
    #[error("cannot read the recipe {}\n  the system says: {reason}\n  check the path, and that the file may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong type.
    #[error(
        "{}:{line}: {reason}\n  a recipe is what `relief generate` writes beside its map\n  correct the line, or remove it: every key has a \
         default",
        path.display()
    )]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// Why.
        reason: String,
    },
    /// No `[recipe]`.
    #[error(
        "{} has no [recipe]\n  only a map that `relief generate` made has one in the TOML file beside it\n  name that file, or write a \
         table [recipe]",
        path.display()
    )]
    NoRecipe {
        /// The file.
        path: PathBuf,
    },
    /// A setting that no landscape can be made with.
    #[error("{}: recipe.{reason}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// The setting.
        reason: RecipeError,
    },
    /// A file that is no sidecar is where the recipe would go.
    #[error(
        "cannot write the recipe to {}\n  the file is there and is no map's sidecar\n  move it, or give the map another name",
        path.display()
    )]
    InTheWay {
        /// The file.
        path: PathBuf,
    },
}

/// Reads the recipe in the TOML file `path`.
///
/// # Errors
/// [`RecipeFileError`], but not its last.
pub fn read(path: &Path) -> Result<Recipe, RecipeFileError> {
    let text =
        std::fs::read_to_string(path).map_err(|reason| RecipeFileError::Read { path: path.to_path_buf(), reason })?;
    let path = || path.to_path_buf();
    let file: RecipeFile = toml::from_str(&text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        let line = 1 + text.bytes().take(start).filter(|&byte| byte == b'\n').count();
        RecipeFileError::Syntax { path: path(), line, reason: error.message().to_owned() }
    })?;
    let recipe = file.recipe.ok_or_else(|| RecipeFileError::NoRecipe { path: path() })?;
    recipe.validate().map_err(|reason| RecipeFileError::Value { path: path(), reason })?;
    Ok(recipe)
}

/// The text of the sidecar `path` with this recipe; `existing` is what it holds now. Its other keys are kept, comments
/// only where it has no recipe yet, and a sidecar that has this recipe stays as it is.
///
/// # Errors
/// [`RecipeFileError::InTheWay`].
pub fn sidecar_text(path: &Path, existing: Option<&str>, recipe: &Recipe) -> Result<String, RecipeFileError> {
    let existing = existing.unwrap_or_default();
    if toml::from_str::<RecipeFile>(existing).is_ok_and(|file| file.recipe.as_ref() == Some(recipe)) {
        return Ok(existing.to_owned());
    }
    let in_the_way = || RecipeFileError::InTheWay { path: path.to_path_buf() };
    let table: toml::Table = toml::from_str(existing).map_err(|_| in_the_way())?;
    if !table.keys().all(|key| Sidecar::KEYS.contains(&key.as_str())) {
        return Err(in_the_way());
    }
    let mut sidecar: Sidecar = toml::from_str(existing).map_err(|_| in_the_way())?;
    let kept = match sidecar.recipe.take() {
        None => existing.to_owned(),
        Some(_) => toml::to_string(&sidecar).map_err(|_| in_the_way())?,
    };
    let file = RecipeFile { recipe: Some(recipe.clone()) };
    let recipe = toml::to_string(&file).map_err(|_| in_the_way())?;
    let gap = if kept.trim().is_empty() { "" } else { "\n\n" };
    Ok(format!("{}{gap}{NOTE}\n{recipe}", kept.trim_end()))
}

/// Stands above the table.
const NOTE: &str = "# `relief generate --recipe` with this file makes the same bytes again.";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::generate::Kind;

    fn read_text(text: &str) -> Result<Recipe, RecipeFileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.toml");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn a_recipe_written_and_read_again_is_the_same() {
        let mut recipe = Recipe { seed: u64::MAX, octaves: Some(5), ..Recipe::new(Kind::Warped, 0) };
        recipe.midpoint.schedule = vec![1.0, 0.1, 1.0 / 3.0];
        for existing in [None, Some(""), Some("title = \"A\" # what it is\nmetres_per_sample = 3.0")] {
            let text = sidecar_text(Path::new("a.toml"), existing, &recipe).unwrap();
            assert_eq!(read_text(&text).unwrap(), recipe, "{text}");
            assert!(text.starts_with(existing.unwrap_or_default()), "what was there stays: {text}");
        }
    }

    #[test]
    fn a_sidecar_keeps_its_keys_and_gets_the_new_recipe() {
        let old = "title = \"A\"\n[recipe]\nkind = \"ridged\" # by hand\nseed = 3\n";
        let path = Path::new("a.toml");
        let same = Recipe::new(Kind::Ridged, 3);
        assert_eq!(sidecar_text(path, Some(old), &same).unwrap(), old, "nothing to change");
        let text = sidecar_text(path, Some(old), &Recipe::new(Kind::Ridged, 4)).unwrap();
        assert!(text.contains("title = \"A\"") && read_text(&text).unwrap().seed == 4, "{text}");
    }

    #[test]
    fn what_is_no_sidecar_is_not_overwritten() {
        for text in ["[march]\ntechnique = \"linear\"\n", "not toml", "[package]\nname = \"a\"\n"] {
            let error = sidecar_text(Path::new("a.toml"), Some(text), &Recipe::default()).unwrap_err();
            assert!(matches!(error, RecipeFileError::InTheWay { .. }), "{text}");
            assert_eq!(error.to_string().lines().count(), 3);
        }
    }

    #[test]
    fn a_bad_recipe_is_named_with_its_line() {
        for (text, words) in [
            ("[recipe]\nkind = \"ocean\"\n", "map.toml:2: unknown variant `ocean`"),
            ("title = \"a\"\n[recipe]\noctave = 3\n", "map.toml:3: unknown field `octave`"),
            ("[recipe]\n\n\nthermal.iterations = -5\n", "map.toml:4: "),
            ("[recipe]\nseed = -1\n", "map.toml:2: a seed is a whole number"),
            ("[recipe]\nroughness = nan\n", "map.toml: recipe.roughness is NaN"),
            ("[recipe]\noctaves = 1000\n", "map.toml: recipe.octaves is 1000"),
            ("[recipe]\nsize = [0, 5]\n", "map.toml: recipe.size is 0×5"),
            ("[recipe]\nversion = 2\n", "map.toml: recipe.version is 2"),
            ("title = \"a\"\n", "map.toml has no [recipe]"),
            ("[recipe\n", "map.toml:1: "),
        ] {
            let error = read_text(text).unwrap_err().to_string();
            assert!(error.contains(words) && error.lines().count() == 3, "{text}: {error}");
        }
        let missing = read(Path::new("none.toml")).unwrap_err().to_string();
        assert!(missing.contains("none.toml") && missing.lines().count() == 3, "{missing}");
    }
}
