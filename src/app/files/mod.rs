//! Maps in and out: several open at once, dropped files, the system's dialogue or one of ours, recent files, the gallery,
//! how a file is read, saving the edited map.
//!
//! | file | what it holds |
//! |---|---|
//! | `maps` | the maps that are open, and where the eye was in each |
//! | `drops` | files that are dragged over the window |
//! | `dialogue`, `browser` | the system's way to choose a file, and ours where there is none |
//! | `recent`, `folders` | the files opened last; where such things are kept |
//! | `card` | what the import card is about to change |
//! | `saving` | writing the edited map |
//! | `progress` | how far opening is, and a way to end it |

pub(crate) mod browser;
pub(crate) mod card;
mod dialogue;
pub(crate) mod drops;
pub(crate) mod folders;
pub(crate) mod maps;
mod progress;
pub(crate) mod recent;
pub(crate) mod saving;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::event::WindowEvent;

use self::browser::{Answer, Browser};
use self::card::Card;
use self::drops::Drops;
use self::maps::{Maps, Place, Source};
use self::recent::Recent;
use self::saving::SaveForm;
use super::loading::{About, LoadFailure, Request};
use super::panel;
use super::viewer::Viewer;
use super::window::UserEvent;
use crate::heightfield::gallery::Piece;
use crate::heightfield::generate::Recipe;
use crate::heightfield::import::ImportOptions;
use crate::heightfield::{Provenance, companions};

/// How often the progress of opening is drawn.
const PROGRESS_PAUSE: Duration = Duration::from_millis(100);

/// What the keys and the panel ask for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FilesCommand {
    /// Choose files in a dialogue.
    Choose,
    /// Open these files.
    Open(Vec<PathBuf>),
    /// Open what ships.
    OpenShipped(Source),
    /// Go to the map with this index.
    GoTo(usize),
    /// Go on by so many maps.
    Step(isize),
    /// End what is being opened.
    Cancel,
    /// Open the map again, as the card says.
    Apply,
    /// Write what the card says beside the map.
    Keep,
    /// Ask for the name of a file for the edited map.
    AskToSave,
    /// Write the edited map; whether a file may be replaced.
    Save(PathBuf, bool),
    /// Forget the files opened last.
    ForgetRecent,
}

/// What other threads tell.
#[derive(Debug)]
pub(crate) enum FilesEvent {
    /// The dialogue ended with these files, or none.
    Chosen(Vec<PathBuf>),
    /// There is no dialogue.
    NoDialogue,
    /// The edited map was written, or could not be.
    Saved(Result<String, String>),
    /// A made landscape was written to this file, or could not be.
    Made(PathBuf, Result<String, String>),
}

/// A file that nobody can open without being told more.
#[derive(Debug)]
pub(crate) struct Question {
    /// The file.
    pub(crate) path: PathBuf,
    /// What is to be said.
    pub(crate) card: Card,
    /// Why it does not open as it is.
    pub(crate) why: String,
}

/// All about files that the viewer remembers.
#[derive(Debug, Default)]
pub(crate) struct Files {
    /// The open maps.
    pub(crate) maps: Maps,
    /// Where the map on screen came from; absent for one that a program made.
    pub(crate) provenance: Option<Provenance>,
    /// The import card's draft.
    pub(crate) card: Card,
    /// The files opened last.
    pub(crate) recent: Recent,
    /// Files over the window.
    pub(crate) drops: Drops,
    /// Our own dialogue, while it is open.
    pub(crate) browser: Option<Browser>,
    /// A file that asks how it is to be read.
    pub(crate) question: Option<Question>,
    /// The edited map's file.
    pub(crate) save: SaveForm,
    /// Since when something is being opened.
    since: Option<Instant>,
    /// The system's dialogue is open.
    choosing: bool,
    /// The edited map is being written.
    saving: bool,
}

impl Files {
    /// Of a viewer that opens with a map of this origin, and goes on to `more` files, opened with the same options.
    /// Without a file it is what `recipe` makes, or the Grand Canyon.
    pub(crate) fn new(
        provenance: Option<Provenance>,
        (title, recipe): (&str, Option<&Recipe>),
        more: Vec<PathBuf>,
        said: &ImportOptions,
    ) -> Self {
        let recent = Recent::read();
        let mut files = Self { recent, ..Self::default() };
        let path = provenance.as_ref().and_then(|provenance| provenance.path.clone());
        let built_in = || recipe.map_or(Source::Canyon, |recipe| Source::Made(Box::new(recipe.clone())));
        let first = path.map_or_else(built_in, |path| Source::File(absolute(&path)));
        let index = files.maps.add(first.clone(), said.clone());
        files.maps.arrive(index, title);
        for path in more {
            files.maps.add(Source::File(absolute(&path)), said.clone());
        }
        files.card = provenance.as_ref().map(Card::of).unwrap_or_default();
        files.provenance = provenance;
        if let Source::File(path) = first {
            files.recent.opened(&path);
        }
        files
    }

    /// Whether one of the windows about files is open, which Esc closes.
    pub(crate) fn asks(&self) -> bool {
        self.browser.is_some() || self.question.is_some() || self.save.open
    }

    /// A map that was read cannot be drawn.
    pub(crate) fn gave_up(&mut self, source: &Source) {
        self.since = None;
        self.maps.failed(source);
    }

    /// The made map on screen is another one now.
    pub(crate) fn renew(&mut self, about: &About) {
        if let Some(map) = self.maps.current_mut() {
            (map.source, map.title) = (about.source.clone(), Some(about.title.clone()));
        }
        self.card = Card::of(&about.provenance);
        self.provenance = Some(about.provenance.clone());
    }

    /// Whether anything is being done that changes what is on screen.
    pub(crate) fn is_busy(&self) -> bool {
        self.saving || self.drops.is_waiting()
    }
}

/// The same path, whatever folder the program goes to.
pub(crate) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

impl Viewer {
    /// Does what was asked for.
    pub(super) fn files_command(&mut self, command: FilesCommand) {
        match command {
            FilesCommand::Choose => self.choose_files(),
            FilesCommand::Open(paths) => self.open_files(paths),
            FilesCommand::OpenShipped(source) => {
                let index = self.files.maps.add(source, ImportOptions::default());
                self.go_to_map(index);
            }
            FilesCommand::GoTo(index) => self.go_to_map(index),
            FilesCommand::Step(by) => {
                if let Some(index) = self.files.maps.step(by) {
                    self.go_to_map(index);
                } else {
                    self.toasts
                        .info("Only one map is open. Drop another on the window, or press Ctrl+O.", Instant::now());
                }
            }
            FilesCommand::Cancel => self.cancel_opening(),
            FilesCommand::Apply => self.apply_card(),
            FilesCommand::Keep => self.keep_card(),
            FilesCommand::AskToSave => {
                let source = self.files.maps.current().map(|map| map.source.clone());
                self.files.save.ask(source.as_ref(), &self.screenshots);
            }
            FilesCommand::Save(path, replace) => self.save_map(&path, replace),
            FilesCommand::ForgetRecent => self.files.recent.forget(),
        }
    }

    /// Opens the first of these files; the others wait until they are gone to.
    fn open_files(&mut self, paths: Vec<PathBuf>) {
        let maps = &mut self.files.maps;
        let mut indices = Vec::new();
        for path in paths {
            indices.push(maps.add(Source::File(absolute(&path)), ImportOptions::default()));
        }
        if let Some(first) = indices.first() {
            self.go_to_map(*first);
        }
    }

    /// Starts to open the map with this index.
    fn go_to_map(&mut self, index: usize) {
        let Some(map) = self.files.maps.get(index) else { return };
        let request = Request {
            source: map.source.clone(),
            said: map.said.clone(),
            stated: map.stated.clone(),
            gallery: folders::gallery(),
            limit: self.facts.max_texture,
        };
        self.files.maps.target = Some(index);
        self.start_loading(request);
    }

    fn start_loading(&mut self, request: Request) {
        let proxy = self.proxy.clone();
        let done = move || {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Loaded);
        };
        self.files.since = Some(Instant::now());
        // Were it to come later, it would take the new map's place.
        self.generator.forget();
        self.redraw.invalidate();
        if let Err(error) = self.loader.start(request, done) {
            self.files.maps.target = None;
            self.toasts.error(&format!("The old terrain stays: no thread to load on: {error}. Close some programs."));
        }
    }

    /// Ends what is being opened. Says whether there was anything.
    pub(super) fn cancel_opening(&mut self) {
        if let Some(source) = self.loader.cancel() {
            self.files.maps.failed(&source);
            self.show_hint(format!("{} was not opened. The old terrain stays.", source.name()), Instant::now());
        }
    }

    /// Opens the map on screen again, as the card says, or the file that asked.
    fn apply_card(&mut self) {
        let limit = self.facts.max_texture;
        let again = |source: Source, card: &Card| Request {
            source,
            said: ImportOptions::default(),
            stated: Some(card.stated()),
            gallery: folders::gallery(),
            limit,
        };
        let request = match self.files.question.take() {
            Some(question) => {
                let source = Source::File(question.path);
                self.files.maps.target = Some(self.files.maps.add(source.clone(), ImportOptions::default()));
                again(source, &question.card)
            }
            None => match self.files.maps.current() {
                Some(map) => again(map.source.clone(), &self.files.card),
                None => return,
            },
        };
        self.start_loading(request);
    }

    /// Writes what the card says into the sidecar of the map on screen.
    fn keep_card(&mut self) {
        let path = self.files.provenance.as_ref().and_then(|provenance| provenance.path.clone());
        let Some(path) = path else {
            self.toasts.error("Nothing was kept: this map is no file, so nothing can stand beside it.");
            return;
        };
        match companions::keep(&path, &self.files.card.stated()) {
            Ok(sidecar) => {
                self.toasts.info(&format!("Kept in {}", sidecar.display()), Instant::now());
                // From now on the file beside the map says it.
                if let Some(map) = self.files.maps.current_mut() {
                    (map.said, map.stated) = (ImportOptions::default(), None);
                }
            }
            Err(error) => self.toasts.error(&error.to_string()),
        }
    }

    /// The map that comes now: what was on screen is remembered before, what belongs to the new one is restored. To be
    /// called when the new map is drawn already, with the scene as a new map has it; `left` is where the eye was.
    pub(super) fn arrive(&mut self, opened: &About, left: Place) {
        self.files.since = None;
        let files = &mut self.files;
        files.maps.leave(left);
        let index = files.maps.add(opened.source.clone(), opened.said.clone());
        files.maps.arrive(index, &opened.title);
        let extent = self.map.box_size(None);
        if let Some(map) = files.maps.current_mut() {
            (map.said, map.stated) = (opened.said.clone(), opened.stated.clone());
            if let Some(place) = map.place.take() {
                place.restore(&mut self.scene, extent);
            }
        }
        files.card = Card::of(&opened.provenance);
        files.provenance = Some(opened.provenance.clone());
        if let Source::File(path) = &opened.source {
            files.recent.opened(path);
        }
    }

    /// Tells of a map that did not open. What only asks for its layout gets a window to say it in.
    pub(super) fn did_not_open(&mut self, failure: &LoadFailure) {
        self.files.since = None;
        self.files.maps.failed(&failure.source);
        match &failure.source {
            Source::File(path) if failure.unclear => {
                let card = Card::for_question(path, failure.stated.as_deref().cloned());
                let why = failure.message.lines().nth(1).unwrap_or_default().trim().to_owned();
                self.files.question = Some(Question { path: path.clone(), card, why });
            }
            _ => self.toasts.error(&failure.message),
        }
        if let (Source::File(path), true) = (&failure.source, failure.missing) {
            self.files.recent.gone(path);
        }
    }

    /// Files over the window, and files let go of. True for an event that is one of these.
    pub(super) fn drag_event(&mut self, event: &WindowEvent) -> bool {
        let taken = self.files.drops.event(event);
        if taken {
            self.redraw.invalidate();
        }
        taken
    }

    /// Opens what was dropped since the last look: the window system tells of one file at a time.
    pub(super) fn open_dropped(&mut self) {
        let dropped = self.files.drops.take();
        if !dropped.is_empty() {
            self.open_files(dropped);
        }
    }

    /// What another thread told of files.
    pub(super) fn files_event(&mut self, event: FilesEvent, now: Instant) {
        match event {
            FilesEvent::Chosen(paths) => {
                self.files.choosing = false;
                self.open_files(paths);
            }
            FilesEvent::NoDialogue => {
                self.files.choosing = false;
                self.files.browser = Some(Browser::new(self.start_folder()));
            }
            FilesEvent::Made(path, result) => self.made_was_saved(&path, result, now),
            FilesEvent::Saved(result) => {
                self.files.saving = false;
                match result {
                    Ok(message) => self.toasts.info(&message, now),
                    Err(message) => self.toasts.error(&message),
                }
            }
        }
    }

    /// Where a dialogue begins: beside the map on screen.
    fn start_folder(&self) -> PathBuf {
        let beside = |path: &Path| path.parent().map(Path::to_path_buf);
        let of_map = match self.files.maps.current().map(|map| &map.source) {
            Some(Source::File(path)) => beside(path),
            _ => self.files.recent.files().first().and_then(|path| beside(path)),
        };
        of_map.filter(|folder| folder.is_dir()).or_else(|| std::env::current_dir().ok()).unwrap_or_default()
    }

    fn choose_files(&mut self) {
        if self.files.choosing || self.files.browser.is_some() {
            return;
        }
        let folder = self.start_folder();
        let proxy = self.proxy.clone();
        let answer = move |event| {
            let _ = proxy.send_event(UserEvent::Files(event));
        };
        self.files.choosing = dialogue::start(&self.window, &folder, answer);
        if !self.files.choosing {
            self.files.browser = Some(Browser::new(folder));
        }
    }

    /// Writes the map with its craters, on another thread.
    fn save_map(&mut self, path: &Path, replace: bool) {
        if self.files.saving {
            self.toasts.error("Not saved: the map is being written already. Save again when that is done.");
            return;
        }
        let job = saving::Job {
            path: absolute(path),
            replace,
            map: Arc::clone(&self.map),
            craters: self.scene.craters.list.clone(),
            provenance: self.files.provenance.clone(),
        };
        let proxy = self.proxy.clone();
        let write = move || {
            let _ = proxy.send_event(UserEvent::Files(FilesEvent::Saved(job.run())));
        };
        self.files.saving = true;
        if let Err(error) = self.write("save", write) {
            self.files.saving = false;
            self.toasts.error(&format!("Nothing was saved: no thread to write on: {error}. Close some programs."));
        }
    }

    /// The windows about files, and the progress of opening.
    pub(super) fn files_windows(&mut self, ctx: &egui::Context, now: Instant) -> Vec<FilesCommand> {
        let mut commands = Vec::new();
        if let Some(browser) = &mut self.files.browser {
            match browser.show(ctx, self.free) {
                Some(Answer::Open(path)) => {
                    self.files.browser = None;
                    commands.push(FilesCommand::Open(vec![path]));
                }
                Some(Answer::Close) => self.files.browser = None,
                None => {}
            }
        }
        if let Some(question) = &mut self.files.question {
            match panel::import::ask(ctx, self.free, question) {
                Some(true) => commands.push(FilesCommand::Apply),
                Some(false) => self.files.question = None,
                None => {}
            }
        }
        commands.extend(self.files.save.show(ctx, self.free));
        if let (Some(progress), Some(since)) = (self.loader.progress(), self.files.since) {
            let late = now.saturating_duration_since(since) >= progress::PATIENCE;
            if late && progress::show(ctx, self.free, &progress) {
                commands.push(FilesCommand::Cancel);
            }
            self.redraw.wake_at(now + PROGRESS_PAUSE);
        }
        commands
    }

    /// The pieces of the gallery, and what they are called.
    pub(super) fn shipped() -> impl Iterator<Item = Source> {
        [Source::Canyon].into_iter().chain(Piece::ALL.map(Source::Piece))
    }
}
