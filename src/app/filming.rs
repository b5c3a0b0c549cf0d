//! Writes the pictures of the camera path: drawn one between two frames of the window, encoded on another thread.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use image::RgbaImage;

use super::frame::FrameError;
use super::graphics::Graphics;
use super::legend::{self, Against};
use super::redraw::Next;
use super::stamp::{Legend, Stamp};
use super::viewer::Viewer;
use crate::animation::AnimationWriter;
use crate::camera_path::Track;
use crate::gpu::{Gpu, ReadbackError, Target};
use crate::heightfield::HeightField;
use crate::render::{Baking, RenderError, Renderer};
use crate::scene::Scene;
use crate::scene::motion::FilmClocks;

/// Pictures that wait for the encoder at most.
const WAITING: usize = 2;

/// How long to wait for an encoder that is busy, and for its last words.
const PAUSE: Duration = Duration::from_millis(15);

/// How often it is told how far the work is.
const TELL: Duration = Duration::from_millis(150);

/// An animation under way.
pub(super) struct Film {
    scene: Scene,
    track: Track,
    /// Where water and clouds are when it begins; seconds from picture to picture.
    clocks: FilmClocks,
    step: f64,
    target: Target,
    /// The window's scene goes on meanwhile, with a sun of its own.
    baking: Baking,
    /// Draws the legend, where the scene asks for one.
    stamp: Option<Stamp>,
    count: u32,
    drawn: u32,
    /// Drawn, and not yet handed over.
    picture: Option<RgbaImage>,
    /// Gone once all are handed over: the encoder then ends.
    pictures: Option<SyncSender<RgbaImage>>,
    result: Receiver<Outcome>,
    encoder: Option<JoinHandle<()>>,
    wait: Option<Instant>,
    told: Option<Instant>,
}

impl Film {
    /// How far it is, in words.
    pub(super) fn in_words(&self) -> String {
        format!("Writing picture {} of {} … (Esc cancels)", self.drawn.min(self.count), self.count)
    }

    /// The picture that was drawn last, with its legend.
    fn read(&mut self, gpu: &Gpu, map: &HeightField) -> Result<RgbaImage, ReadbackError> {
        let Some(stamp) = &mut self.stamp else { return self.target.read_color(gpu) };
        let legend = Legend { scene: &self.scene, map, errors: Against::default(), pixels_per_point: None };
        stamp.picture(gpu, &self.target, &legend)
    }

    /// When it has to go on.
    pub(super) fn next(&self, now: Instant) -> Next {
        Next::At(self.wait.unwrap_or(now))
    }

    /// Draws the next picture as `render --path` does: with the whole light map of this very sun.
    fn draw(&mut self, renderer: &mut Renderer, map: &HeightField) -> Result<RgbaImage, RenderError> {
        let share = f64::from(self.drawn) / f64::from((self.count - 1).max(1));
        self.scene.camera = Some(self.track.at(self.track.seconds() * share));
        self.clocks.set(&mut self.scene, self.step * f64::from(self.drawn));
        renderer.swap_baking(&mut self.baking);
        let drawn = renderer.time(&self.scene, &self.target);
        renderer.swap_baking(&mut self.baking);
        drawn?;
        Ok(self.read(renderer.gpu(), map)?)
    }

    /// Hands a picture over. False while the encoder is busy; true also where it has ended early: its result says why.
    fn hand_over(&mut self) -> bool {
        let (Some(sender), Some(picture)) = (&self.pictures, self.picture.take()) else { return true };
        match sender.try_send(picture) {
            Ok(()) => true,
            Err(TrySendError::Full(picture)) => {
                self.picture = Some(picture);
                false
            }
            Err(TrySendError::Disconnected(_)) => {
                self.pictures = None;
                true
            }
        }
    }
}

impl Drop for Film {
    /// Waits for the encoder, which takes away what it has begun where pictures are missing.
    fn drop(&mut self) {
        self.pictures = None;
        if let Some(encoder) = self.encoder.take() {
            // A panic of it has been told on stderr.
            let _ = encoder.join();
        }
    }
}

/// What the encoder says in the end.
type Outcome = Result<PathBuf, String>;

/// Starts the encoder. It ends without a word and a trace where fewer than `count` pictures come.
fn encode(
    mut writer: AnimationWriter,
    count: u32,
) -> std::io::Result<(SyncSender<RgbaImage>, Receiver<Outcome>, JoinHandle<()>)> {
    let (pictures, receiver) = sync_channel::<RgbaImage>(WAITING);
    let (sender, result) = channel();
    let encoder = std::thread::Builder::new().name("animation".into()).spawn(move || {
        let mut pushed = 0;
        let pushing = receiver.iter().try_for_each(|picture| {
            pushed += 1;
            writer.push(&picture)
        });
        let outcome = match pushing {
            Ok(()) if pushed < count => return,
            Ok(()) => writer.finish(),
            Err(error) => Err(error),
        };
        // Nobody listens any more when the window was closed.
        let _ = sender.send(outcome.map_err(|error| error.to_string()));
    })?;
    Ok((pictures, result, encoder))
}

impl Viewer {
    /// Begins to write the pictures of the path.
    pub(super) fn export(&mut self, graphics: &Graphics, now: Instant) {
        if self.film.is_some() {
            return;
        }
        let edited = &self.view.path;
        let Some(track) = edited.path.track() else {
            self.refuse(self.no_way(), now);
            return;
        };
        if self.stands_in(graphics, &self.drawable(graphics)) || self.compiler.is_busy() {
            self.refuse(
                "Not yet: what the picture needs is still being prepared. Try again when it is there.".into(),
                now,
            );
            return;
        }
        if self.generator.is_busy() {
            // Another ground would end it.
            self.refuse("Not yet: another landscape is being made. Try again when it is there.".into(), now);
            return;
        }
        let size = edited.size.map(|side| side.clamp(16, self.facts.max_texture));
        let (count, path) = (edited.path.pictures(edited.per_second), PathBuf::from(edited.output.trim()));
        if path.is_file() {
            self.toasts.error(&format!(
                "No animation: {} exists already. Name a file or a folder that does not exist yet.",
                path.display()
            ));
            return;
        }
        let begun = AnimationWriter::new(&path, size, count, edited.per_second)
            .map_err(|error| error.to_string())
            .and_then(|writer| {
                encode(writer, count)
                    .map_err(|error| format!("No animation: no thread to write on: {error}. Close some programs."))
            });
        match begun {
            Ok((pictures, result, encoder)) => {
                self.journey.stop();
                let stamps = self.scene.saved.legend && legend::exists(&self.scene);
                self.film = Some(Film {
                    stamp: stamps.then(|| Stamp::new(&graphics.gpu)),
                    scene: self.scene.clone(),
                    track,
                    clocks: FilmClocks::of(&self.scene),
                    step: 1.0 / f64::from(self.view.path.per_second),
                    target: Target::new(&graphics.gpu, size),
                    baking: Baking::default(),
                    count,
                    drawn: 0,
                    picture: None,
                    pictures: Some(pictures),
                    result,
                    encoder: Some(encoder),
                    wait: None,
                    told: None,
                });
            }
            Err(message) => self.toasts.error(&message),
        }
    }

    /// Gives the animation up; nothing of it is left.
    pub(super) fn cancel_export(&mut self, now: Instant) {
        if self.film.take().is_some() {
            self.toasts.info("The animation is cancelled; nothing was written.", now);
        }
    }

    /// Does the next piece of the animation.
    pub(super) fn follow_film(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        let Some(film) = &mut self.film else { return Ok(()) };
        if film.wait.is_some_and(|until| until > now) {
            return Ok(());
        }
        film.wait = None;
        match film.result.try_recv() {
            Ok(outcome) => {
                self.film = None;
                self.redraw.invalidate();
                match outcome {
                    Ok(path) => self.toasts.info(&format!("Saved the animation as {}", path.display()), now),
                    Err(message) => self.toasts.error(&message),
                }
                return Ok(());
            }
            Err(TryRecvError::Disconnected) => {
                self.film = None;
                self.toasts.error("No animation: the thread that writes it ended early. Try again.");
                self.redraw.invalidate();
                return Ok(());
            }
            Err(TryRecvError::Empty) => {}
        }
        if !film.hand_over() || film.drawn >= film.count {
            // All are drawn: the encoder hears that by the end of its channel.
            if film.picture.is_none() {
                film.pictures = None;
            }
            film.wait = Some(now + PAUSE);
            return Ok(());
        }
        match film.draw(&mut graphics.renderer, &self.map) {
            Ok(picture) => {
                (film.picture, film.drawn) = (Some(picture), film.drawn + 1);
                film.hand_over();
            }
            Err(RenderError::DeviceLost(lost)) => {
                self.film = None;
                return Err(FrameError::Lost(lost));
            }
            Err(error) => {
                self.film = None;
                self.toasts.error(&format!("No animation: {error}"));
            }
        }
        if self.film.as_mut().is_none_or(|film| film.told.is_none_or(|told| now - told > TELL)) {
            self.redraw.invalidate();
            if let Some(film) = &mut self.film {
                film.told = Some(now);
            }
        }
        Ok(())
    }
}
