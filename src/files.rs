//! Files that are written whole or not at all: into a temporary file in the same folder, which is then renamed.
//!
//! No reader ever sees half of a file, and a failure leaves what was there. A link is replaced by the file, so resolve it
//! first where it is to be kept; a pipe or a device is for other means. Errors are the system's own and do not name the
//! temporary file: the path that the user knows goes into the message where they are shown.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use tempfile::NamedTempFile;

/// Writes all of `bytes` to `path`.
///
/// # Errors
/// What the system says: the folder does not exist or may not be written to, `path` is a folder, there is no room.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// Writes to `path` what `write` puts into the file, once it has succeeded. For what is too large to be kept in memory,
/// or is to reach the disk first ([`File::sync_data`]).
///
/// # Errors
/// As [`write_whole`], and those of `write`.
pub fn write_with(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut file = temporary_beside(path)?;
    write(file.as_file_mut())?;
    file.persist(path).map_err(|failed| failed.error)?;
    Ok(())
}

/// A new file in the folder of `path`, removed on drop. Its mode is that of any new file (less the umask), while
/// temporary files are private by default.
///
/// # Errors
/// The folder does not exist, may not be written to, or has no room.
pub fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Opened here and not by `tempfile_in`, whose errors name the temporary file.
    tempfile::Builder::new()
        .prefix(".relief-")
        .suffix(".part")
        .make_in(folder, |path| File::options().read(true).write(true).create_new(true).open(path))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_failure_leaves_what_was_there_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_whole(&path, b"old").unwrap();
        let failed = write_with(&path, |file| {
            file.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn an_error_does_not_name_the_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().join("none/a.json"), folder.path().to_path_buf()] {
            let error = write_whole(&path, b"").unwrap_err().to_string();
            assert!(!error.contains(".part") && !error.contains(".relief"), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_mode_is_that_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
        write_whole(&folder.path().join("ours"), b"").unwrap();
        File::create(folder.path().join("plain")).unwrap();
        assert_eq!(mode("ours"), mode("plain"));
    }
}
