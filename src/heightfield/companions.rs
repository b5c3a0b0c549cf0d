//! Files beside a map: which ones stand in the way of a sidecar, and writing one without harm.
//!
//! A sidecar goes by the map's name with the ending `.toml`, and so do a scene file of that name and the sidecar of another
//! map. None of them is replaced.

use std::path::{Path, PathBuf};

use super::Sidecar;
use crate::files;

/// Endings of files that open as maps, in lower case.
pub const MAP_ENDINGS: [&str; 23] = [
    "tif", "tiff", "png", "jpg", "jpeg", "webp", "hgt", "asc", "agr", "bil", "bip", "bsq", "flt", "r8", "r16", "r32",
    "raw", "ter", "exr", "nc", "cdf", "grd", "dem",
];

/// Why a sidecar cannot be written: what, why and what to do, a line each.
#[derive(Debug, thiserror::Error)]
pub enum SidecarError {
    /// Something else has its name.
    #[error("cannot write {}\n  it exists and is no sidecar; it would be replaced\n  move that file, or give the map another name", path.display())]
    NoSidecar {
        /// What is in the way.
        path: PathBuf,
    },
    /// Another map would be read by it, too.
    #[error(
        "cannot write {}\n  it would also say where {} lies and how it is read, and that file would be shown wrong\n  give the map \
         a name that differs in more than its ending",
        path.display(),
        other.display()
    )]
    Shared {
        /// The sidecar.
        path: PathBuf,
        /// The other map.
        other: PathBuf,
    },
    /// The system refuses.
    #[error("cannot write {}\n  {reason}\n  check that its folder may be written to, and has room", path.display())]
    System {
        /// The sidecar.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
}

/// Checks that the sidecar of `map` can be written or replaced without harm to another file: there is none yet, or it is
/// this map's alone. With `new`, a sidecar that does not exist yet may not be written either where another map would go by
/// it.
///
/// # Errors
/// [`SidecarError`], but not its last.
pub fn check(map: &Path, new: bool) -> Result<(), SidecarError> {
    let path = Sidecar::path_of(map);
    let mut warnings = Vec::new();
    if path.exists() && Sidecar::read_for(map, &mut warnings).is_none() {
        return Err(SidecarError::NoSidecar { path });
    }
    match sibling(map).filter(|_| new || path.exists()) {
        Some(other) => Err(SidecarError::Shared { path, other }),
        None => Ok(()),
    }
}

/// Another map that goes by the sidecar of `map`: of the same name but for the ending.
pub fn sibling(map: &Path) -> Option<PathBuf> {
    let folder = map.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let paths = std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.is_file() && path.file_stem() == map.file_stem()).find(|path| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        path.file_name() != map.file_name() && MAP_ENDINGS.contains(&ending.as_str())
    })
}

/// Writes `stated` beside `map`. What the sidecar there says that is not known here, its recipe and other keys, is kept; its
/// comments are not. Returns where it is.
///
/// # Errors
/// [`SidecarError`]; nothing was written then.
pub fn keep(map: &Path, stated: &Sidecar) -> Result<PathBuf, SidecarError> {
    check(map, true)?;
    let path = Sidecar::path_of(map);
    let failed = |reason: String| SidecarError::System { path: path.clone(), reason };
    let mut table = match std::fs::read_to_string(&path) {
        Ok(text) => text.parse::<toml::Table>().unwrap_or_default(),
        Err(_) => toml::Table::new(),
    };
    table.retain(|key, _| key == "recipe" || !Sidecar::KEYS.contains(&key));
    let text = stated.to_toml().map_err(failed)?;
    let failed = |reason: String| SidecarError::System { path: path.clone(), reason };
    let said: toml::Table = text.parse().map_err(|error: toml::de::Error| failed(error.to_string()))?;
    table.extend(said);
    files::write_whole(&path, table.to_string().as_bytes()).map_err(|error| failed(error.to_string()))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    #[test]
    fn a_sidecar_keeps_what_it_does_not_know() {
        let recipe = "title = \"old\"\nholes = \"fill\"\n[recipe]\nseed = 3\n";
        let folder = folder_with(&[("a.png", ""), ("a.toml", recipe), ("a.tfw", ""), ("a.hdr", "")]);
        let stated = Sidecar { title: Some("new".into()), metres_per_sample: Some(30.0), ..Sidecar::default() };
        let path = keep(&folder.path().join("a.png"), &stated).unwrap();
        let table: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
        assert_eq!((table["title"].as_str(), table["metres_per_sample"].as_float()), (Some("new"), Some(30.0)));
        assert_eq!(table["recipe"]["seed"].as_integer(), Some(3));
        assert!(!table.contains_key("holes"), "what is not stated any more is gone: {table}");
    }

    #[test]
    fn what_belongs_to_another_file_is_left_alone() {
        let scene = "[camera]\nfov = 50.0\n";
        let folder = folder_with(&[
            ("a.png", ""),
            ("a.toml", scene),
            ("b.png", ""),
            ("b.r16", ""),
            ("c.PNG", ""),
            ("c.tif", ""),
        ]);
        let stated = Sidecar { title: Some("new".into()), ..Sidecar::default() };
        let refuse = |name: &str| keep(&folder.path().join(name), &stated).unwrap_err();
        assert!(matches!(refuse("a.png"), SidecarError::NoSidecar { .. }));
        assert_eq!(std::fs::read_to_string(folder.path().join("a.toml")).unwrap(), scene);
        for name in ["b.png", "b.r16", "c.tif"] {
            let error = refuse(name);
            assert!(matches!(error, SidecarError::Shared { .. }) && error.to_string().lines().count() == 3, "{error}");
        }
        assert!(!folder.path().join("b.toml").exists());
        assert!(check(&folder.path().join("b.png"), false).is_ok(), "there is no sidecar that could be replaced");
    }
}
