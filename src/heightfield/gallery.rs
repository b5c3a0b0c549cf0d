//! What ships: the Grand Canyon, which is inside the binary, and recipes of terrain that is made when it is wanted.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use super::generate::recipe_file;
use super::generate::{Kind, MakeError, Recipe};
use super::save::{SaveError, save_png16};
use super::{LoadError, Loaded, Sidecar, load};
use crate::files;

/// The height map that opens when none is named, so that the binary needs no files beside it.
const GRAND_CANYON: &[u8] = include_bytes!("../../assets/grand-canyon.png");
/// Its extent, heights, source and licence.
const GRAND_CANYON_SIDECAR: &str = include_str!("../../assets/grand-canyon.toml");

/// Samples on a side of the gallery's made terrain.
const SIDE: u32 = 1024;

/// What to call the Grand Canyon.
pub const CANYON_NAME: &str = "Grand Canyon";

/// Opens the Grand Canyon.
///
/// # Errors
/// As [`load::load_bytes`]; none in a sound build.
pub fn grand_canyon() -> Result<Loaded, LoadError> {
    load::load_bytes(Path::new("grand-canyon.png"), GRAND_CANYON, Some(GRAND_CANYON_SIDECAR))
}

/// A terrain of the gallery that is made from a recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Crests that rain has cut.
    Mountains,
    /// Rolling hills.
    Hills,
    /// Folded land.
    Folds,
    /// Midpoint displacement, rough as it was first drawn.
    Crags,
}

/// Why a piece is not there.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// It was not made.
    #[error(transparent)]
    Make(#[from] MakeError),
    /// It was not written.
    #[error(transparent)]
    Save(#[from] SaveError),
}

impl Piece {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Mountains, Self::Hills, Self::Folds, Self::Crags];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mountains => "Mountains after rain",
            Self::Hills => "Rolling hills",
            Self::Folds => "Folded land",
            Self::Crags => "Crags",
        }
    }

    /// What it is, in a sentence.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Mountains => "A ridged multifractal with valleys that drops of rain have dug.",
            Self::Hills => "Octaves of gradient noise.",
            Self::Folds => "Gradient noise read at displaced places.",
            Self::Crags => "Midpoint displacement, then slopes that slide until they rest.",
        }
    }

    /// The name of its file.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Mountains => "mountains.png",
            Self::Hills => "hills.png",
            Self::Folds => "folds.png",
            Self::Crags => "crags.png",
        }
    }

    /// What it is made from.
    pub fn recipe(self) -> Recipe {
        let recipe = |kind, seed| Recipe { size: [SIDE; 2], ..Recipe::new(kind, seed) };
        match self {
            Self::Mountains => {
                let mut recipe = Recipe { scale: 2.2, ..recipe(Kind::Ridged, 7) };
                recipe.hydraulic.drops = 0.4;
                recipe
            }
            Self::Hills => Recipe { scale: 4.0, ..recipe(Kind::Perlin, 3) },
            Self::Folds => recipe(Kind::Warped, 5),
            Self::Crags => {
                let mut recipe = Recipe { roughness: 0.52, ..recipe(Kind::DiamondSquare, 11) };
                recipe.thermal.iterations = 12;
                recipe
            }
        }
    }

    /// The file in `folder`, made first where it is not there, or is not made from this recipe. A picture of it then has a
    /// file that its scene can name. `progress` hears the share that is done, 0..1; once `cancel` is set it ends soon.
    ///
    /// # Errors
    /// [`GalleryError`].
    pub fn file_in(
        self,
        folder: &Path,
        progress: &(dyn Fn(f32) + Sync),
        cancel: &AtomicBool,
    ) -> Result<PathBuf, GalleryError> {
        let (path, recipe) = (folder.join(self.file_name()), self.recipe());
        let beside = Sidecar::path_of(&path);
        if path.is_file() && recipe_file::read(&beside).is_ok_and(|made| made == recipe) {
            return Ok(path);
        }
        let failed = |path: &Path, reason: String| SaveError { path: path.into(), reason };
        std::fs::create_dir_all(folder).map_err(|error| failed(folder, error.to_string()))?;
        let field = recipe.make(recipe.size, progress, cancel)?;
        save_png16(&field, &path)?;
        let title = format!("title = \"{}\"\n", self.name());
        let text = recipe_file::sidecar_text(&beside, Some(&title), &recipe);
        let text = text.map_err(|error| failed(&beside, error.to_string()))?;
        files::write_whole(&beside, text.as_bytes()).map_err(|error| failed(&beside, error.to_string()))?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::*;

    #[test]
    fn a_piece_is_made_once_and_opens_without_a_word() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("made");
        let never = AtomicBool::new(false);
        let path = Piece::Hills.file_in(&folder, &|_| {}, &never).unwrap();
        let loaded = load::load(&path).unwrap();
        assert_eq!(
            (loaded.title.as_deref(), loaded.warnings.len()),
            (Some("Rolling hills"), 0),
            "{:?}",
            loaded.warnings
        );
        assert_eq!(loaded.field.width(), SIDE);
        let made_again = AtomicBool::new(false);
        Piece::Hills.file_in(&folder, &|_| made_again.store(true, Ordering::Relaxed), &never).unwrap();
        assert!(!made_again.into_inner());
        let cancelled = Piece::Folds.file_in(&folder, &|_| {}, &AtomicBool::new(true));
        assert!(matches!(cancelled, Err(GalleryError::Make(MakeError::Cancelled))));
        assert!(!folder.join("folds.png").exists());
    }

    #[test]
    fn every_recipe_is_valid() {
        for piece in Piece::ALL {
            assert_eq!(piece.recipe().validate(), Ok(()), "{}", piece.name());
        }
    }
}
