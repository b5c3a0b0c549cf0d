//! Opens a height map on another thread. What is on screen stays until the new map is there.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::cones::CallOnDrop;
use super::files::maps::Source;
use crate::heightfield::gallery::{self, GalleryError};
use crate::heightfield::generate::Recipe;
use crate::heightfield::import::{ImportOptions, Listener};
use crate::heightfield::{HeightField, LoadError, Loaded, Provenance, Sidecar, load};
use crate::render::PreparedTerrain;

/// What is to be opened.
#[derive(Clone, Debug)]
pub(crate) struct Request {
    /// Where it comes from.
    pub(crate) source: Source,
    /// What is known of it besides.
    pub(crate) said: ImportOptions,
    /// What counts instead of its sidecar.
    pub(crate) stated: Option<Sidecar>,
    /// The folder for terrain that is made first.
    pub(crate) gallery: PathBuf,
    /// Most samples on a side.
    pub(crate) limit: u32,
}

/// A map that was opened.
#[derive(Debug)]
pub(crate) struct Opened {
    /// The map.
    pub(crate) map: Arc<HeightField>,
    /// The same with its pyramid and colours, which take too long to make between two frames.
    pub(crate) terrain: PreparedTerrain,
    /// West, south, east and north in degrees, where that is known.
    pub(crate) bounds: Option<[f64; 4]>,
    /// What the user should know about it.
    pub(crate) warnings: Vec<String>,
    /// All else that is known of it.
    pub(crate) about: About,
}

/// Which map was opened, and how.
#[derive(Clone, Debug)]
pub(crate) struct About {
    /// Where it came from.
    pub(crate) source: Source,
    /// The options it was opened with.
    pub(crate) said: ImportOptions,
    /// What counted instead of its sidecar.
    pub(crate) stated: Option<Sidecar>,
    /// Its file, absolute; absent for what is built in.
    pub(crate) path: Option<PathBuf>,
    /// What to call it.
    pub(crate) title: String,
    /// What the import card shows.
    pub(crate) provenance: Provenance,
}

/// Why a map was not opened.
#[derive(Debug)]
pub(crate) struct LoadFailure {
    /// What was to be opened.
    pub(crate) source: Source,
    /// What, why and what to do.
    pub(crate) message: String,
    /// The file would open if its layout were said, and not as this says.
    pub(crate) unclear: bool,
    /// What counted instead of its sidecar.
    pub(crate) stated: Option<Box<Sidecar>>,
    /// There is no such file.
    pub(crate) missing: bool,
}

/// How far opening is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Progress {
    /// What is being opened.
    pub(crate) name: String,
    /// The share of the file that was read, 0..1.
    pub(crate) share: f32,
}

/// The map being opened, if any.
#[derive(Debug, Default)]
pub(crate) struct Loader {
    job: Option<Job>,
}

#[derive(Debug)]
struct Job {
    source: Source,
    /// Ends the reading of a file that nobody waits for any more.
    cancel: Arc<AtomicBool>,
    /// The bits of the share that was read.
    share: Arc<AtomicU32>,
    result: Receiver<Result<Opened, LoadFailure>>,
}

impl Loader {
    /// Starts to open a map; one that is still being opened is forgotten. `done` is called from the other thread once
    /// [`Loader::poll`] has something to say.
    pub(crate) fn start(&mut self, request: Request, done: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        let (sender, result) = channel();
        let source = request.source.clone();
        let (cancel, share) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU32::new(0)));
        let (cancelled, heard) = (Arc::clone(&cancel), Arc::clone(&share));
        std::thread::Builder::new().name("load".into()).spawn(move || {
            // Dropped last, also when loading panics: the window has to hear of that, too.
            let _done = CallOnDrop(Some(done));
            let sender = sender;
            // Nobody listens any more when another file was opened meanwhile, or the window was closed.
            let _ = sender.send(open(request, &heard, &cancelled));
        })?;
        self.job = Some(Job { source, cancel, share, result });
        Ok(())
    }

    /// Whether a map is being opened.
    pub(crate) fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// How far it is, while something is being opened.
    pub(crate) fn progress(&self) -> Option<Progress> {
        let job = self.job.as_ref()?;
        Some(Progress { name: job.source.name(), share: f32::from_bits(job.share.load(Ordering::Relaxed)) })
    }

    /// Ends what is being opened. What that was.
    pub(crate) fn cancel(&mut self) -> Option<Source> {
        Some(self.job.take()?.source.clone())
    }

    /// The map or the message, once, as soon as there is one.
    pub(crate) fn poll(&mut self) -> Option<Result<Opened, LoadFailure>> {
        let job = self.job.as_ref()?;
        let result = match job.result.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(LoadFailure {
                source: job.source.clone(),
                message: format!(
                    "cannot open {}: the loader stopped unexpectedly. The old terrain stays.",
                    job.source.name()
                ),
                unclear: false,
                stated: None,
                missing: false,
            }),
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

fn open(request: Request, share: &AtomicU32, cancel: &AtomicBool) -> Result<Opened, LoadFailure> {
    let hear = |done: f32| share.store(done.to_bits(), Ordering::Relaxed);
    let (loaded, path) = read(&request, &hear, cancel).map_err(|error| LoadFailure {
        source: request.source.clone(),
        message: error.to_string(),
        unclear: matches!(&error, OpenError::Load(LoadError::Unclear { .. })) && is_raw(&request.source),
        stated: request.stated.clone().map(Box::new),
        missing: matches!(&error, OpenError::Load(LoadError::NotFound { .. })),
    })?;
    hear(1.0);
    Ok(Opened::of(request, loaded, path))
}

impl Opened {
    /// A map that was read or made, with all that takes too long between two frames.
    pub(crate) fn of(request: Request, loaded: Loaded, path: Option<PathBuf>) -> Self {
        let provenance = Provenance::of(&loaded, path.clone());
        let stem = path.as_deref().and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
        let bounds = loaded.geographic_bounds();
        let map = Arc::new(loaded.field);
        let about = About {
            title: loaded.title.or(stem).unwrap_or_else(|| request.source.name()),
            source: request.source,
            said: request.said,
            stated: request.stated,
            path,
            provenance,
        };
        let terrain = PreparedTerrain::new(Arc::clone(&map)).with_colours();
        Self { terrain, map, bounds, warnings: loaded.warnings, about }
    }
}

impl About {
    /// What makes this very map again: of a small one that stands in for a whole one while a control is dragged, the recipe
    /// with its own size. A scene that is saved meanwhile then shows what was on screen.
    pub(super) fn recipe_of(&self, map: &HeightField) -> Option<Recipe> {
        let size = [map.width(), map.height()];
        self.source.recipe().map(|recipe| Recipe { size, ..recipe.clone() })
    }
}

/// A file without a header, by its name.
fn is_raw(source: &Source) -> bool {
    let Source::File(path) = source else { return false };
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| ["raw", "r8", "r16", "r32"].contains(&ending.as_str()))
}

/// Why nothing was read.
#[derive(Debug, thiserror::Error)]
enum OpenError {
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Gallery(#[from] GalleryError),
}

fn read(
    request: &Request,
    hear: &(dyn Fn(f32) + Sync),
    cancel: &AtomicBool,
) -> Result<(Loaded, Option<PathBuf>), OpenError> {
    let path = match &request.source {
        Source::Made(recipe) => {
            let field = recipe.make(recipe.size, hear, cancel).map_err(LoadError::from)?;
            return Ok((Loaded::made(field, recipe), None));
        }
        Source::Canyon => return Ok((gallery::grand_canyon()?, None)),
        // Reading it again is nothing beside making it.
        Source::Piece(piece) => piece.file_in(&request.gallery, hear, cancel)?,
        Source::File(path) => path.clone(),
    };
    let options = ImportOptions { limit: Some(request.limit), ..request.said.clone() };
    let listener = Listener { progress: &|share| hear(share), cancel };
    let loaded = match &request.stated {
        Some(stated) => load::load_as(&path, stated.clone(), &options, listener)?,
        None => load::load_with(&path, &options, listener)?,
    };
    Ok((loaded, Some(std::path::absolute(&path).unwrap_or(path))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(path: &Path) -> Request {
        Request {
            source: Source::File(path.into()),
            said: ImportOptions::default(),
            stated: None,
            gallery: PathBuf::new(),
            limit: 8192,
        }
    }

    /// Opens it and waits.
    fn opened(request: Request) -> Result<Opened, LoadFailure> {
        let (sender, done) = channel();
        let mut loader = Loader::default();
        loader.start(request, move || sender.send(()).expect("the test waits")).expect("a thread");
        done.recv().expect("the window is woken");
        loader.poll().expect("woken, so there is a result")
    }

    #[test]
    fn a_file_that_does_not_exist_ends_in_a_message() {
        let (sender, done) = channel();
        let mut loader = Loader::default();
        assert!(loader.poll().is_none());
        let path = PathBuf::from("no such folder/no such map.png");
        loader.start(request(&path), move || sender.send(()).expect("the test waits")).expect("a thread");
        assert_eq!(loader.progress().map(|progress| progress.name).as_deref(), Some("no such map.png"));
        done.recv().expect("the window is woken");
        let failure = loader.poll().expect("woken, so there is a result").expect_err("there is no such file");
        assert!(!failure.message.is_empty() && failure.missing && !failure.unclear);
        assert!(loader.poll().is_none() && !loader.is_busy() && loader.cancel().is_none());
    }

    #[test]
    fn a_raw_file_that_is_no_square_asks_for_its_layout() {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats/other");
        let failure = opened(request(&data.join("oblong.raw"))).expect_err("nobody said its size");
        assert!(failure.unclear && failure.message.contains("raw-size"), "{}", failure.message);
    }

    #[test]
    fn a_map_beyond_the_limit_is_reduced_or_cut_by_choice() {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
        let with = |too_large| {
            let said = ImportOptions { too_large, ..ImportOptions::default() };
            let opened = opened(Request { limit: 100, said, ..request(&data) }).expect("it opens");
            assert_eq!(opened.warnings.len(), 1, "it is told: {:?}", opened.warnings);
            let taken = opened.about.provenance.taken;
            (opened.map.width(), taken.factor, taken.window)
        };
        use crate::heightfield::import::TooLarge;
        assert_eq!(with(None), (85, 6, [0, 0, 512, 512]));
        assert_eq!(with(Some(TooLarge::Window)), (100, 1, [206, 206, 100, 100]));
    }

    #[test]
    fn a_cancelled_map_is_never_heard_of_again() {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
        let mut loader = Loader::default();
        loader.start(request(&data), || ()).expect("a thread");
        assert_eq!(loader.cancel(), Some(Source::File(data)));
        assert!(loader.poll().is_none() && !loader.is_busy() && loader.progress().is_none());
    }
}
