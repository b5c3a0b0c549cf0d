//! Opens a height map on another thread. What is on screen stays until the new map is there.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use crate::heightfield::HeightField;
use crate::heightfield::import::{ImportOptions, Listener};
use crate::heightfield::load;
use crate::render::PreparedTerrain;

/// A map that was opened.
#[derive(Debug)]
pub(crate) struct Opened {
    /// Where it came from, absolute.
    pub(crate) path: PathBuf,
    /// What to call it.
    pub(crate) title: String,
    /// The map.
    pub(crate) map: Arc<HeightField>,
    /// The same with its pyramid and colours, which take too long to make between two frames.
    pub(crate) terrain: PreparedTerrain,
    /// West, south, east and north in degrees, where that is known.
    pub(crate) bounds: Option<[f64; 4]>,
    /// What the user should know about it.
    pub(crate) warnings: Vec<String>,
}

/// The map being opened, if any.
#[derive(Debug, Default)]
pub(crate) struct Loader {
    job: Option<Job>,
}

#[derive(Debug)]
struct Job {
    path: PathBuf,
    /// Ends the reading of a file that nobody waits for any more.
    cancel: Arc<AtomicBool>,
    result: Receiver<Result<Opened, String>>,
}

impl Loader {
    /// Starts to open `path`, of at most `limit` samples a side; a map that is still being opened is forgotten. `done` is
    /// called from the other thread once [`Loader::poll`] has something to say.
    pub(crate) fn start(
        &mut self,
        path: PathBuf,
        limit: u32,
        done: impl FnOnce() + Send + 'static,
    ) -> std::io::Result<()> {
        let (sender, result) = channel();
        let file = path.clone();
        let cancel = Arc::new(AtomicBool::new(false));
        let cancelled = Arc::clone(&cancel);
        std::thread::Builder::new().name("load".into()).spawn(move || {
            // Dropped last, also when loading panics: the window has to hear of that, too.
            let _done = CallOnDrop(Some(done));
            let sender = sender;
            // Nobody listens any more when another file was opened meanwhile, or the window was closed.
            let _ = sender.send(open(&file, limit, &cancelled));
        })?;
        self.job = Some(Job { path, cancel, result });
        Ok(())
    }

    /// The file being opened.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.job.as_ref().map(|job| job.path.as_path())
    }

    /// Gives up the map being opened. Says which it was.
    pub(crate) fn cancel(&mut self) -> Option<PathBuf> {
        self.job.take().map(|job| job.path.clone())
    }

    /// The map or the message, once, as soon as there is one.
    pub(crate) fn poll(&mut self) -> Option<Result<Opened, String>> {
        let job = self.job.as_ref()?;
        let result = match job.result.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(format!(
                "cannot open {}: the loader stopped unexpectedly. The old terrain stays.",
                job.path.display()
            )),
        };
        self.job = None;
        Some(result)
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

struct CallOnDrop<F: FnOnce()>(Option<F>);

impl<F: FnOnce()> Drop for CallOnDrop<F> {
    fn drop(&mut self) {
        if let Some(call) = self.0.take() {
            call();
        }
    }
}

fn open(path: &Path, limit: u32, cancel: &AtomicBool) -> Result<Opened, String> {
    let options = ImportOptions { limit: Some(limit), ..ImportOptions::default() };
    let listener = Listener { progress: &|_| {}, cancel };
    let loaded = load::load_with(path, &options, listener).map_err(|error| error.to_string())?;
    let stem =
        || path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned());
    let bounds = loaded.geographic_bounds();
    let map = Arc::new(loaded.field);
    Ok(Opened {
        path: std::path::absolute(path).unwrap_or_else(|_| path.into()),
        title: loaded.title.unwrap_or_else(stem),
        terrain: PreparedTerrain::new(Arc::clone(&map)).with_colours(),
        map,
        bounds,
        warnings: loaded.warnings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_does_not_exist_ends_in_a_message() {
        let (sender, done) = channel();
        let mut loader = Loader::default();
        assert!(loader.poll().is_none());
        let path = PathBuf::from("no such folder/no such map.png");
        loader.start(path.clone(), 8192, move || sender.send(()).expect("the test waits")).expect("a thread");
        assert_eq!(loader.path(), Some(path.as_path()));
        done.recv().expect("the window is woken");
        let result = loader.poll().expect("woken, so there is a result");
        assert!(!result.expect_err("there is no such file").is_empty());
        assert!(loader.poll().is_none() && loader.path().is_none());
    }
}
