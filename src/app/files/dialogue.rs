//! The system's dialogue for choosing files.
//!
//! On Linux and the BSDs that is the desktop's portal, or zenity. Where there is neither, the dialogue ends at once as if it
//! had been cancelled, so an answer that comes faster than anybody can press a button means that there is none.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::window::Window;

use super::FilesEvent;
use crate::heightfield::companions::MAP_ENDINGS;

/// Nobody cancels a dialogue sooner than this.
const FASTEST_HAND: Duration = Duration::from_millis(400);

/// Opens it and returns; `answer` is called from another thread. False where there is none.
pub(super) fn start(window: &Arc<Window>, folder: &Path, answer: impl FnOnce(FilesEvent) + Send + 'static) -> bool {
    if !may_exist() {
        return false;
    }
    let dialogue = rfd::AsyncFileDialog::new()
        .set_title("Open maps")
        .set_directory(folder)
        .add_filter("Elevation files", &MAP_ENDINGS)
        .add_filter("All files", &["*"])
        .set_parent(window);
    let chosen = dialogue.pick_files();
    let wait = move || {
        let start = Instant::now();
        let event = match pollster::block_on(chosen) {
            Some(files) => FilesEvent::Chosen(files.iter().map(|file| file.path().to_path_buf()).collect()),
            None if start.elapsed() < FASTEST_HAND => FilesEvent::NoDialogue,
            None => FilesEvent::Chosen(Vec::new()),
        };
        answer(event);
    };
    std::thread::Builder::new().name("dialogue".into()).spawn(wait).is_ok()
}

/// Whether a portal may answer: without a session's bus there is none to ask. RELIEF_DIALOGUE=own does without.
fn may_exist() -> bool {
    if std::env::var_os("RELIEF_DIALOGUE").is_some_and(|value| value == "own") {
        return false;
    }
    if cfg!(any(target_os = "linux", target_os = "freebsd", target_os = "openbsd", target_os = "netbsd")) {
        let told = std::env::var_os("DBUS_SESSION_BUS_ADDRESS").is_some_and(|address| !address.is_empty());
        let usual = std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).join("bus").exists());
        told || usual
    } else {
        true
    }
}
