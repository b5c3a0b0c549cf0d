//! Files that are written whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::failure::{Failure, cannot_write};
use crate::files;

/// A file to be written later. Making one checks that it can be written, before any long work.
#[derive(Debug)]
pub(crate) struct Output {
    /// As the user wrote it, for messages.
    shown: PathBuf,
    /// Where the bytes go: links are followed, so that a link is kept and its file replaced.
    target: PathBuf,
    /// A pipe or a device: bytes go straight into it, for it must not be replaced by a file.
    special: bool,
}

impl Output {
    /// Checks that `path` can be written: its folder exists and takes a file, and it is no folder itself.
    pub(crate) fn prepare(path: &Path) -> Result<Self, Failure> {
        let failed = |error: &io::Error| cannot_write(path, error);
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let special = match fs::metadata(&target) {
            Ok(found) if found.is_dir() => return Err(failed(&io::Error::from(io::ErrorKind::IsADirectory))),
            Ok(found) => !found.is_file(),
            Err(_) => false,
        };
        if target.file_name().is_none() {
            return Err(failed(&io::Error::from(io::ErrorKind::InvalidFilename)));
        }
        let output = Self { shown: path.to_path_buf(), target, special };
        if !special {
            files::temporary_beside(&output.target).map_err(|error| failed(&error))?;
        }
        Ok(output)
    }

    /// The path as the user wrote it.
    pub(crate) fn path(&self) -> &Path {
        &self.shown
    }

    /// Whether both would be written to the same file.
    pub(crate) fn same_file(&self, other: &Path) -> bool {
        let other = fs::canonicalize(other).unwrap_or_else(|_| other.to_path_buf());
        !self.special && absolute(&self.target) == absolute(&other)
    }

    /// Where a writer that replaces files by itself may write; a device or a pipe must not be replaced.
    pub(crate) fn regular_file(&self) -> Result<&Path, Failure> {
        if self.special {
            return Err(cannot_write(&self.shown, &io::Error::other("it is a device or a pipe, not a file")));
        }
        Ok(&self.target)
    }

    /// Writes all of `bytes`.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        let written = if self.special {
            File::options().write(true).open(&self.target).and_then(|mut file| file.write_all(bytes))
        } else {
            // On the disk before the name points to it, lest a crash leave neither the old file nor the new one.
            files::write_with(&self.target, |file| file.write_all(bytes).and_then(|()| file.sync_data()))
        };
        written.map_err(|error| cannot_write(&self.shown, &error))
    }
}

/// Makes a folder for several files, with those it lies in.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| {
        // What stands in the way is a file; the system's words for it differ.
        let file = folder.is_file();
        cannot_write(folder, &if file { io::ErrorKind::NotADirectory.into() } else { error })
    })
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_prepared_file_does_not_exist_until_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let output = Output::prepare(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        output.write(b"abc").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"abc");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_folder_that_vanished_meanwhile_is_a_message() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).unwrap();
        let output = Output::prepare(&inner.join("a.png")).unwrap();
        fs::remove_dir(&inner).unwrap();
        assert!(output.write(b"abc").unwrap_err().to_string().contains("a.png"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_kept_and_a_device_is_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        Output::prepare(&link).unwrap().write(b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());

        let null = Path::new("/dev/null");
        Output::prepare(null).unwrap().write(b"gone").unwrap();
        assert!(fs::metadata(null).unwrap().file_type().is_char_device());
    }
}
