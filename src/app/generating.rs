//! Landscapes from the panel: small ones while a control is dragged, the whole one once it rests, each on a thread of its
//! own. What is on screen stays until the new ground is there.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::cones::CallOnDrop;
use super::files::maps::Source;
use super::files::{FilesEvent, absolute};
use super::frame::FrameError;
use super::graphics::Graphics;
use super::loading::{Opened, Request};
use super::redraw::Next;
use super::settings::Facts;
use super::viewer::Viewer;
use super::window::UserEvent;
use crate::heightfield::Loaded;
use crate::heightfield::generate::{Kind, MakeError, Recipe, saving};
use crate::heightfield::import::ImportOptions;

/// Samples along the longer side of what is made while a control is dragged.
pub(crate) const PREVIEW: u32 = 257;
/// Samples along each side of a landscape that nobody has chosen a size for.
const USUAL: u32 = 1025;
/// How long a control rests before the whole landscape is made.
const REST: Duration = Duration::from_millis(300);
/// A small landscape that takes longer is given up for a newer one; were each given up, a slow one would never show.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often it is told how far the whole one is.
const PROGRESS_PAUSE: Duration = Duration::from_millis(100);

/// What the panel's section and the keys ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MakeCommand {
    /// The recipe was changed: a small landscape now, the whole one when it rests.
    Changed,
    /// The whole landscape now.
    Make,
    /// The landscape of the next seed.
    NextSeed,
    /// End what is being made.
    Cancel,
    /// Write the landscape on screen to the file that is typed.
    Save,
}

/// The recipe in the panel, and what is done with it.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    /// The recipe.
    pub(crate) recipe: Recipe,
    /// Its schedule, as typed.
    pub(crate) schedule: String,
    /// The file to save to, as typed.
    pub(crate) file: String,
    /// The file that was saved to last, which may be replaced.
    saved: Option<PathBuf>,
    /// The share that is done of the whole landscape being made.
    pub(crate) share: Option<f32>,
}

impl Default for Draft {
    fn default() -> Self {
        let recipe = Recipe { size: [USUAL; 2], ..Recipe::new(Kind::Ridged, 1) };
        Self { recipe, schedule: String::new(), file: "relief-land.png".into(), saved: None, share: None }
    }
}

impl Draft {
    /// Goes on with the recipe of a map.
    pub(crate) fn take(&mut self, recipe: &Recipe) {
        if self.recipe.midpoint.schedule != recipe.midpoint.schedule {
            let numbers: Vec<_> = recipe.midpoint.schedule.iter().map(f64::to_string).collect();
            self.schedule = numbers.join(", ");
        }
        self.recipe = recipe.clone();
    }

    /// Whether what lies at `path` may be replaced: what was saved from here, and nothing else. Not while the first save to it
    /// is under way, which may still find another's map there.
    fn may_replace(&self, path: &Path) -> bool {
        self.saved.as_deref() == Some(path)
    }

    /// A save to `path` has ended, `well` or not.
    fn was_saved(&mut self, path: &Path, well: bool) {
        self.saved.take_if(|saved| saved == path);
        if well {
            self.saved = Some(path.to_owned());
        }
    }
}

/// A landscape that is wanted.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    recipe: Recipe,
    /// Columns and rows to be made of it now.
    size: [u32; 2],
}

impl Wanted {
    fn is_preview(&self) -> bool {
        self.size != self.recipe.size
    }
}

/// Columns and rows of the small landscape of `recipe`; `None` where it is small enough, or cannot be made so small.
fn preview_size(recipe: &Recipe) -> Option<[u32; 2]> {
    let longer = recipe.size[0].max(recipe.size[1]);
    let factor = f64::from(PREVIEW - 1) / f64::from(longer.max(2) - 1);
    let size = recipe.size.map(|side| ((f64::from(side.max(2) - 1) * factor).round() as u32).max(2) + 1);
    let small = Recipe { size, ..recipe.clone() };
    (factor < 1.0 && small.validate().is_ok()).then_some(size)
}

/// A landscape on its way.
#[derive(Debug)]
struct Job {
    wanted: Wanted,
    since: Instant,
    cancel: Arc<AtomicBool>,
    /// Bits of the share that is made.
    share: Arc<AtomicU32>,
    result: Receiver<Result<Opened, MakeError>>,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// Makes one landscape at a time, the newest that was asked for.
#[derive(Debug, Default)]
pub(crate) struct Generator {
    job: Option<Job>,
    /// The small landscape to be made once the one under way is shown.
    waiting: Option<Wanted>,
    /// When the whole one is to be made, unless something changes before.
    rest: Option<Instant>,
    /// Held by the work under way: what is cancelled still finishes its row, and several at once would take the memory of
    /// all.
    turn: Arc<Mutex<()>>,
}

impl Generator {
    /// Whether something is being made, or will be.
    pub(crate) fn is_busy(&self) -> bool {
        self.job.is_some() || self.rest.is_some()
    }

    /// When to look again.
    pub(crate) fn next(&self) -> Next {
        self.rest.map_or(Next::Never, Next::At)
    }

    /// The share that is done of a whole landscape being made.
    pub(crate) fn progress(&self) -> Option<f32> {
        let job = self.job.as_ref().filter(|job| !job.wanted.is_preview())?;
        Some(f32::from_bits(job.share.load(Ordering::Relaxed)))
    }

    /// Nobody wants any of it any more. False where there was nothing.
    pub(crate) fn forget(&mut self) -> bool {
        let busy = self.is_busy();
        (self.job, self.waiting, self.rest) = (None, None, None);
        busy
    }

    /// Asks for a landscape in place of all that was asked for before. A small one that is nearly there is still shown.
    /// `done` is called on another thread when there is something to fetch.
    fn ask(&mut self, wanted: Wanted, done: impl FnOnce() + Send + 'static) -> Result<(), String> {
        self.waiting = None;
        let shows_soon = |job: &Job| job.wanted.is_preview() && job.since.elapsed() < PATIENCE;
        if wanted.is_preview() && self.job.as_ref().is_some_and(shows_soon) {
            self.waiting = Some(wanted);
            return Ok(());
        }
        self.job = None;
        self.job = Some(start(wanted, Arc::clone(&self.turn), done)?);
        Ok(())
    }

    /// What is to be asked for next: what waited for what was fetched.
    fn take_waiting(&mut self) -> Option<Wanted> {
        if self.job.is_some() { None } else { self.waiting.take() }
    }

    /// What was made, once.
    ///
    /// # Errors
    /// Why it was not.
    fn poll(&mut self) -> Option<Result<Opened, String>> {
        let job = self.job.as_ref()?;
        let result = match job.result.try_recv() {
            Ok(Ok(made)) => Ok(made),
            Ok(Err(error)) => Err(error.to_string()),
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("the thread that makes it ended early".into()),
        };
        self.job = None;
        Some(result)
    }
}

fn start(wanted: Wanted, turn: Arc<Mutex<()>>, done: impl FnOnce() + Send + 'static) -> Result<Job, String> {
    let (sender, result) = channel();
    let (cancel, share) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU32::new(0)));
    let (cancelled, heard, made) = (Arc::clone(&cancel), Arc::clone(&share), wanted.clone());
    let work = move || {
        // Dropped last, also where making it panics: the window has to hear of that, too.
        let _done = CallOnDrop(Some(done));
        let sender = sender;
        let _turn = turn.lock().unwrap_or_else(PoisonError::into_inner);
        // Nobody listens where something newer was asked for.
        let _ = sender.send(make(&made, &heard, &cancelled));
    };
    std::thread::Builder::new().name("generate".into()).spawn(work).map_err(|error| error.to_string())?;
    Ok(Job { wanted, since: Instant::now(), cancel, share, result })
}

fn make(wanted: &Wanted, share: &AtomicU32, cancel: &AtomicBool) -> Result<Opened, MakeError> {
    let hear = |done: f32| {
        // Of shares that are not negative the larger has the larger bits.
        share.fetch_max(done.to_bits(), Ordering::Relaxed);
    };
    let field = wanted.recipe.make(wanted.size, &hear, cancel)?;
    if cancel.load(Ordering::Relaxed) {
        return Err(MakeError::Cancelled);
    }
    let request = Request {
        source: Source::Made(Box::new(wanted.recipe.clone())),
        said: ImportOptions::default(),
        stated: None,
        gallery: PathBuf::new(),
        limit: u32::MAX,
    };
    Ok(Opened::of(request, Loaded::made(field, &wanted.recipe), None))
}

impl Viewer {
    /// Does what the section or a key asked for.
    pub(super) fn make_command(&mut self, command: MakeCommand, now: Instant) {
        match command {
            MakeCommand::Changed => self.recipe_changed(now),
            MakeCommand::Make => self.make(false),
            MakeCommand::NextSeed => {
                let shown = self.files.maps.current().and_then(|map| map.source.recipe());
                if shown.is_some() || self.generator.is_busy() {
                    let seed = &mut self.view.generate.recipe.seed;
                    *seed = seed.wrapping_add(1);
                }
                let title = self.view.generate.recipe.title();
                self.show_hint(title, now);
                self.recipe_changed(now);
            }
            MakeCommand::Cancel => {
                self.cancel_making(now);
            }
            MakeCommand::Save => self.save_made(),
        }
    }

    fn recipe_changed(&mut self, now: Instant) {
        if self.view.generate.recipe.validate().is_err() {
            // The section says why.
            self.generator.forget();
            return;
        }
        if preview_size(&self.view.generate.recipe).is_some() {
            self.make(true);
            self.generator.rest = Some(now + REST);
        } else {
            self.make(false);
        }
    }

    /// Begins to make the landscape, or with `preview` a small one.
    fn make(&mut self, preview: bool) {
        let recipe = self.view.generate.recipe.clone();
        let size = if preview { preview_size(&recipe).unwrap_or(recipe.size) } else { recipe.size };
        self.cancel_opening();
        self.generator.rest = None;
        self.ask_to_make(Wanted { recipe, size });
    }

    fn ask_to_make(&mut self, wanted: Wanted) {
        let proxy = self.proxy.clone();
        let done = move || {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Loaded);
        };
        self.redraw.invalidate();
        if let Err(error) = self.generator.ask(wanted, done) {
            self.toasts.error(&format!("The old terrain stays: no thread to work on: {error}. Close some programs."));
        }
    }

    /// Ends what is being made. Says whether there was anything.
    pub(super) fn cancel_making(&mut self, now: Instant) -> bool {
        let ended = self.generator.forget();
        if ended {
            self.show_hint("No other terrain is made.".to_owned(), now);
        }
        ended
    }

    /// Shows what was made, and goes on: what waits, and the whole landscape once the recipe rests.
    pub(super) fn follow_generator(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        match self.generator.poll() {
            Some(Ok(made)) => {
                self.redraw.invalidate();
                self.adopt_made(graphics, made, now)?;
            }
            Some(Err(reason)) => {
                self.redraw.invalidate();
                self.toasts.error(&format!("The old terrain stays: {reason}"));
            }
            None => {}
        }
        if let Some(wanted) = self.generator.take_waiting() {
            self.ask_to_make(wanted);
        }
        if self.generator.rest.is_some_and(|at| at <= now) {
            if self.egui.egui_ctx().input(|input| input.pointer.any_down()) {
                self.generator.rest = Some(now + REST);
            } else {
                self.make(false);
            }
        }
        Ok(())
    }

    /// Shows a landscape that was made. It takes the place of the made one on screen, where the eye stays; one with craters
    /// is not lost but stays in the list, and so does every other map.
    fn adopt_made(&mut self, graphics: &mut Graphics, made: Opened, now: Instant) -> Result<(), FrameError> {
        let shown = self.files.maps.current().and_then(|map| map.source.recipe());
        let replaces = shown.is_some() && self.scene.craters.list.is_empty();
        if !replaces {
            let draft = self.view.generate.clone();
            self.adopt(graphics, made, now)?;
            self.view.generate = draft;
            return Ok(());
        }
        if !self.take_ground(graphics, made.terrain, &made.about.source)? {
            return Ok(());
        }
        self.scene.terrain.recipe = made.about.recipe_of(&made.map);
        self.map = made.map;
        self.files.renew(&made.about);
        self.ground_is_new(graphics, made.about.title, now);
        Ok(())
    }

    /// What is being waited for, in words, while a whole landscape is made.
    pub(super) fn making_in_words(&mut self, now: Instant) -> Option<String> {
        let share = self.generator.progress()?;
        self.redraw.wake_at(now + PROGRESS_PAUSE);
        let [width, height] = self.view.generate.recipe.size;
        Some(format!("Making {width} × {height} samples: {:.0} % (Esc cancels)", share * 100.0))
    }

    /// Writes the landscape on screen and its recipe, on another thread.
    fn save_made(&mut self) {
        let draft = &self.view.generate;
        let shown = self.files.maps.current().and_then(|map| map.source.recipe()).cloned();
        let Some(recipe) = shown.filter(|recipe| is_whole(recipe, &self.facts)) else {
            self.toasts.error("Not saved: the landscape on screen is not whole yet. Save again when it is made.");
            return;
        };
        let path = absolute(PathBuf::from(draft.file.trim()).as_path());
        let replace = draft.may_replace(&path);
        let (map, proxy) = (Arc::clone(&self.map), self.proxy.clone());
        let write = move || {
            let result = saving::save(&map, &recipe, &path, replace)
                .map(|()| format!("Saved {}, and its recipe beside it", path.display()))
                .map_err(|error| error.to_string());
            let _ = proxy.send_event(UserEvent::Files(FilesEvent::Made(path, result)));
        };
        if let Err(error) = self.write("save", write) {
            self.toasts.error(&format!("Nothing was saved: no thread to write on: {error}. Close some programs."));
        }
    }

    /// A landscape was saved, or not.
    pub(super) fn made_was_saved(&mut self, path: &Path, result: Result<String, String>, now: Instant) {
        self.view.generate.was_saved(path, result.is_ok());
        match result {
            Ok(message) => self.toasts.info(&message, now),
            Err(message) => self.toasts.error(&message),
        }
    }
}

/// Whether the map on screen is all that `recipe` makes, and not a small one of it.
pub(crate) fn is_whole(recipe: &Recipe, facts: &Facts) -> bool {
    facts.samples == recipe.size
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(size: u32, seed: u64) -> Wanted {
        let recipe = Recipe { size: [size; 2], ..Recipe::new(Kind::Ridged, seed) };
        Wanted { size: [size; 2], recipe }
    }

    fn preview(seed: u64) -> Wanted {
        Wanted { size: [65; 2], ..wanted(1025, seed) }
    }

    fn seed(made: &Opened) -> u64 {
        made.about.source.recipe().unwrap().seed
    }

    #[test]
    fn the_newest_wins_and_what_it_replaces_is_never_heard_of() {
        let mut generator = Generator::default();
        let (sender, done) = channel();
        generator.ask(wanted(4097, 1), || ()).unwrap();
        assert!(generator.progress().is_some_and(|share| (0.0..1.0).contains(&share)) && generator.is_busy());
        let told = sender.clone();
        generator.ask(wanted(33, 2), move || told.send(()).unwrap()).unwrap();
        done.recv_timeout(Duration::from_secs(60)).unwrap();
        let made = generator.poll().unwrap().unwrap();
        assert_eq!((seed(&made), made.map.width()), (2, 33));
        assert!(generator.poll().is_none() && !generator.is_busy(), "handed out once");
        assert_eq!(
            made.map.samples(),
            wanted(33, 2).recipe.make([33; 2], &|_| {}, &AtomicBool::new(false)).unwrap().samples()
        );
    }

    /// Someone presses the button twice over another's file: the second press finds out as the first does.
    #[test]
    fn only_what_was_saved_is_replaced() {
        let (mut draft, path) = (Draft::default(), Path::new("/land.png"));
        assert!(!draft.may_replace(path));
        assert!(!draft.may_replace(path), "the first save is not back yet");
        draft.was_saved(path, false);
        assert!(!draft.may_replace(path));
        draft.was_saved(path, true);
        assert!(draft.may_replace(path) && !draft.may_replace(Path::new("/other.png")));
        draft.was_saved(Path::new("/other.png"), false);
        assert!(draft.may_replace(path), "it is still there");
        draft.was_saved(path, false);
        assert!(!draft.may_replace(path));
    }

    /// A screenshot may be taken while a control is dragged; its scene has to make its picture again.
    #[test]
    fn the_recipe_of_a_small_landscape_makes_that_one_again() {
        for mut wanted in [preview(6), wanted(65, 6)] {
            wanted.recipe.hydraulic.drops = 0.1;
            let (share, cancel) = (AtomicU32::new(0), AtomicBool::new(false));
            let made = make(&wanted, &share, &cancel).unwrap();
            let recipe = made.about.recipe_of(&made.map).unwrap();
            assert!(made.map.samples() == recipe.make(recipe.size, &|_| {}, &cancel).unwrap().samples());
            assert_eq!(
                made.about.source.recipe(),
                Some(&wanted.recipe),
                "what is to be made and saved is the whole one"
            );
        }
    }

    /// Were each small landscape given up for the next, a drag would show none of them.
    #[test]
    fn a_drag_shows_small_landscapes_and_always_the_last() {
        let mut generator = Generator::default();
        let (sender, done) = channel();
        for number in 1..=3 {
            let sender = sender.clone();
            generator.ask(preview(number), move || sender.send(number).unwrap()).unwrap();
        }
        assert!(generator.progress().is_none(), "a small one is not worth a word");
        assert_eq!(done.recv_timeout(Duration::from_secs(60)).unwrap(), 1, "the first goes on");
        assert_eq!(seed(&generator.poll().unwrap().unwrap()), 1);
        assert_eq!(generator.take_waiting(), Some(preview(3)), "the second was replaced while it waited");
        assert_eq!(generator.take_waiting(), None);
        // The whole one waits for nobody.
        generator.ask(preview(4), || ()).unwrap();
        let told = sender.clone();
        generator.ask(wanted(129, 5), move || told.send(5).unwrap()).unwrap();
        assert_eq!(done.recv_timeout(Duration::from_secs(60)).unwrap(), 5);
        assert_eq!(seed(&generator.poll().unwrap().unwrap()), 5);
    }

    #[test]
    fn what_is_cancelled_ends_and_leaves_nothing() {
        let mut generator = Generator::default();
        let (sender, done) = channel();
        let mut slow = wanted(2049, 1);
        slow.recipe.thermal.iterations = 10_000;
        generator.ask(slow, move || sender.send(()).unwrap()).unwrap();
        assert!(generator.forget() && !generator.forget());
        // Long before its ten thousand rounds are over.
        done.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(generator.poll().is_none() && !generator.is_busy());
    }

    #[test]
    fn small_landscapes_have_the_proportions_of_whole_ones() {
        let size = |size, tileable, kind| preview_size(&Recipe { size, tileable, ..Recipe::new(kind, 1) });
        assert_eq!(size([1025; 2], false, Kind::Ridged), Some([257; 2]));
        assert_eq!(size([4097, 2049], true, Kind::DiamondSquare), Some([257, 129]));
        assert_eq!(size([257; 2], false, Kind::Ridged), None);
        assert_eq!(size([100, 50], false, Kind::Ridged), None);
        assert_eq!(size([32768, 2], false, Kind::Perlin), Some([257, 3]));
    }
}
