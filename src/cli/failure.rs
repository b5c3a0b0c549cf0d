//! What ends a command early: the message's three parts and the exit code.

use std::fmt;
use std::path::Path;

use crate::animation::AnimationError;
use crate::app::AppError;
use crate::camera_path::PathFileError;
use crate::gpu::GpuError;
use crate::heightfield::LoadError;
use crate::heightfield::save::SaveError;
use crate::render::RenderError;
use crate::scene_file::SceneFileError;

/// The exit codes of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// The work could not be finished.
    Failed = 1,
    /// The arguments make no sense.
    Usage = 2,
    /// An input file cannot be used.
    BadInput = 3,
    /// There is no usable GPU adapter.
    NoAdapter = 4,
}

/// A message in three parts (what, why, what to do), printed as three lines, and the exit code that goes with it.
#[derive(Debug, thiserror::Error)]
pub(crate) struct Failure {
    /// The exit code.
    pub(crate) exit: Exit,
    what: String,
    details: Vec<String>,
}

impl Failure {
    /// A failure that says `what` went wrong.
    pub(crate) fn new(exit: Exit, what: impl Into<String>) -> Self {
        Self { exit, what: what.into(), details: Vec::new() }
    }

    /// Adds a line: the reason, or what to do.
    #[must_use]
    pub(crate) fn line(mut self, line: impl Into<String>) -> Self {
        self.details.push(line.into());
        self
    }

    /// An argument that makes no sense.
    pub(crate) fn usage(what: impl Into<String>) -> Self {
        Self::new(Exit::Usage, what)
    }
}

impl fmt::Display for Failure {
    /// The first line stands alone; every further line, also within a part, is indented by two spaces.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = self.what.lines().chain(self.details.iter().flat_map(|part| part.lines()));
        f.write_str(lines.next().unwrap_or_default().trim())?;
        lines.try_for_each(|line| write!(f, "\n  {}", line.trim()))
    }
}

impl From<GpuError> for Failure {
    fn from(error: GpuError) -> Self {
        Self::new(Exit::NoAdapter, error.to_string())
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        let exit = match error {
            RenderError::TerrainTooLarge { .. } | RenderError::Image { .. } => Exit::BadInput,
            _ => Exit::Failed,
        };
        Self::new(exit, error.to_string())
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        let exit = if matches!(error, LoadError::Cancelled { .. }) { Exit::Failed } else { Exit::BadInput };
        Self::new(exit, error.to_string())
    }
}

impl From<SaveError> for Failure {
    fn from(error: SaveError) -> Self {
        Self::new(Exit::Failed, error.to_string())
    }
}

impl From<SceneFileError> for Failure {
    fn from(error: SceneFileError) -> Self {
        Self::new(Exit::BadInput, error.to_string())
    }
}

impl From<PathFileError> for Failure {
    fn from(error: PathFileError) -> Self {
        let exit = if matches!(error, PathFileError::Write { .. }) { Exit::Failed } else { Exit::BadInput };
        Self::new(exit, error.to_string())
    }
}

impl From<AnimationError> for Failure {
    fn from(error: AnimationError) -> Self {
        let exit = match error {
            AnimationError::Ending(_) | AnimationError::NotEmpty(_) => Exit::Usage,
            AnimationError::Io { .. } | AnimationError::Encode { .. } => Exit::Failed,
        };
        Self::new(exit, error.to_string())
    }
}

impl From<AppError> for Failure {
    fn from(error: AppError) -> Self {
        match error {
            AppError::Gpu(error) => error.into(),
            AppError::Render(error) => error.into(),
            other => Self::new(Exit::Failed, other.to_string()),
        }
    }
}

/// The failure to write `path` for the reason `error`.
pub(crate) fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Failed, format!("cannot write {}", path.display()))
        .line(format!("The system says: {error}."))
        .line("Nothing was written. Name a folder that exists, that you may write to, and that has room.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_after_the_first_is_indented() {
        let failure = Failure::usage("what\nmore").line("why").line("do this\nor that");
        assert_eq!(failure.to_string(), "what\n  more\n  why\n  do this\n  or that");
    }

    #[test]
    fn the_loaders_message_has_three_lines_whatever_the_name() {
        let failure = Failure::from(LoadError::Empty { path: "a: c; d.png".into() });
        assert_eq!(failure.exit, Exit::BadInput);
        assert_eq!(failure.to_string().lines().count(), 3, "{failure}");
        assert!(failure.to_string().starts_with("cannot open a: c; d.png\n  the file is empty\n"), "{failure}");
    }
}
