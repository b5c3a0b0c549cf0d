//! Where the viewer keeps what it remembers.

use std::path::PathBuf;

use etcetera::BaseStrategy;

/// The environment variable that names another folder, for tests and for those who want several.
pub(crate) const VARIABLE: &str = "RELIEF_CONFIG_DIR";

fn chosen() -> Option<PathBuf> {
    std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()).map(PathBuf::from)
}

/// The folder for what is to be remembered: the platform's. `None` where there is no home.
pub(crate) fn config() -> Option<PathBuf> {
    chosen().or_else(|| Some(etcetera::base_strategy::choose_native_strategy().ok()?.config_dir().join("relief")))
}

/// The folder for the gallery's made terrain, which can be made again at any time.
pub(crate) fn gallery() -> PathBuf {
    let cache = || Some(etcetera::base_strategy::choose_native_strategy().ok()?.cache_dir().join("relief"));
    chosen().or_else(cache).unwrap_or_else(|| std::env::temp_dir().join("relief")).join("gallery")
}
