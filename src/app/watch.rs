//! Debug builds: tells when a shader was saved.

use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};

use crate::gpu::ShaderSources;

/// Watches the shader folder and calls `changed` from another thread for every change in it. `None` in release builds
/// and where the folder does not exist; watching ends when the result is dropped.
pub(crate) fn shaders(changed: impl Fn() + Send + 'static) -> Option<RecommendedWatcher> {
    let folder = ShaderSources::folder().filter(|_| cfg!(debug_assertions))?;
    let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
        let written = |kind: EventKind| kind.is_modify() || kind.is_create() || kind.is_remove();
        if event.is_ok_and(|event| written(event.kind)) {
            changed();
        }
    });
    match watcher.and_then(|mut watcher| watcher.watch(&folder, RecursiveMode::Recursive).map(|()| watcher)) {
        Ok(watcher) => Some(watcher),
        Err(error) => {
            log::warn!(
                "shaders are not reloaded when they are saved, because {} cannot be watched: {error}",
                folder.display()
            );
            None
        }
    }
}
