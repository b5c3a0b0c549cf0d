//! The viewer's state, and what has happened meanwhile: loaded maps, saved shaders, other threads' events.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::keyboard::ModifiersState;
use winit::window::Window;

use super::compiling::Compiler;
use super::cones::ConeFinder;
use super::controls::{Fly, ground_below};
use super::files::Files;
use super::filming::Film;
use super::frame::FrameError;
use super::generating::Generator;
use super::graphics::Graphics;
use super::journey::Journey;
use super::keeping::Keeper;
use super::loading::Loader;
use super::measure::{Meter, Steps};
use super::redraw::{Next, Redraw};
use super::reference::ReferenceWorker;
use super::scale::Scale;
use super::settings::{Facts, PathFields, ViewSettings};
use super::status::{StatusFile, Widget};
use super::toasts::Toasts;
use super::tradeoff::Tradeoff;
use super::window::UserEvent;
use super::{ViewerOptions, desktop, watch};
use crate::camera::{Camera, NamedView};
use crate::heightfield::HeightField;
use crate::render::RenderError;
use crate::scene::Scene;

/// Saving a file makes several events; shaders are read once they have been quiet for so long.
const SHADER_PAUSE: Duration = Duration::from_millis(120);

/// How often new messages show in the log.
const LOG_PAUSE: Duration = Duration::from_millis(200);

/// What is known of mouse and keyboard beside the keys that fly.
#[derive(Debug, Default)]
pub(super) struct Pointer {
    /// Where the cursor is, physical pixels of the window.
    pub(super) cursor: Option<DVec2>,
    /// The right button is down and looks around.
    pub(super) dragging: bool,
    /// A button is down and turns the eye around this point.
    pub(super) orbiting: Option<DVec3>,
    /// The left button is down and drags the split line.
    pub(super) splitting: bool,
    /// The mouse is captured and looks around.
    pub(super) captured: bool,
    /// The cursor was over the panel or another part of egui.
    pub(super) over_egui: bool,
    /// Shift, Control, Alt.
    pub(super) modifiers: ModifiersState,
}

impl Pointer {
    /// Whether a button is held that the picture hears of, wherever the cursor goes.
    pub(super) fn is_dragging(&self) -> bool {
        self.dragging || self.splitting || self.orbiting.is_some()
    }
}

/// The viewer behind its window.
pub(crate) struct Viewer {
    pub(super) window: Arc<Window>,
    pub(super) egui: egui_winit::State,
    pub(super) scale: Scale,
    pub(super) map: Arc<HeightField>,
    pub(super) scene: Scene,
    pub(super) view: ViewSettings,
    pub(super) fly: Fly,
    pub(super) journey: Journey,
    /// The camera path's pictures are being written.
    pub(super) film: Option<Film>,
    pub(super) keeper: Keeper,
    #[cfg(feature = "gamepad")]
    pub(super) gamepads: super::gamepad::Gamepads,
    pub(super) facts: Facts,
    pub(super) pointer: Pointer,
    pub(super) toasts: Toasts,
    pub(super) loader: Loader,
    pub(super) generator: Generator,
    pub(super) files: Files,
    pub(super) redraw: Redraw,
    pub(super) meter: Meter,
    pub(super) reference: ReferenceWorker,
    pub(super) cones: ConeFinder,
    pub(super) compiler: Compiler,
    /// The picture on screen is compared with the f64 reference.
    pub(super) shows_reference: bool,
    /// How much of the light map is drawn, and since when it is under way; `None` when it is all there.
    pub(super) baking: Option<(f32, Instant)>,
    pub(super) tradeoff: Tradeoff,
    /// The line at the bottom of the last frame's picture.
    pub(super) says: Option<String>,
    /// A line of text over the picture until a moment.
    pub(super) hint: Option<(String, Instant)>,
    /// The part of the window that the panel leaves free, points.
    pub(super) free: egui::Rect,
    /// What the kept picture shows.
    pub(super) drawn: Option<Scene>,
    /// What the last picture of this terrain and this device showed, be it kept or not.
    pub(super) shown: Option<Scene>,
    /// The last scene that was drawn without an error.
    pub(super) last_good: Option<Scene>,
    /// "Preparing" has been on screen, so the first picture may take its time.
    pub(super) prepared: bool,
    /// The last picture had the occluder in it.
    pub(super) occluder_seen: bool,
    /// What of the last picture water's and clouds' clocks move.
    pub(super) motion: crate::render::Motion,
    /// When the water last moved.
    pub(super) flowed: Option<Instant>,
    /// The last time that the clock went on, while it runs.
    pub(super) ran: Option<Instant>,
    /// The last turn of the occluder, while it spins.
    pub(super) spun: Option<Instant>,
    /// The last time that clouds went on, while they move.
    pub(super) drifted: Option<Instant>,
    /// The window is covered, as the window system says.
    pub(super) covered: bool,
    /// The surface has nothing to draw to, because nobody would see it.
    pub(super) hidden: bool,
    /// The window is minimised; when to look again, where nobody tells.
    pub(super) minimised_until: Option<Instant>,
    pub(super) frames: u64,
    pub(super) wants_screenshot: bool,
    /// The user wants to leave.
    pub(super) quit: bool,
    pub(super) widgets: Vec<Widget>,
    pub(super) status: Option<StatusFile>,
    pub(super) proxy: EventLoopProxy<UserEvent>,
    pub(super) reload_at: Option<Instant>,
    /// A screenshot is being written.
    pub(super) saving: bool,
    /// Threads that write files: the program does not end before them.
    pub(super) writers: Vec<JoinHandle<()>>,
    pub(super) screenshots: PathBuf,
    /// When the device was lost last.
    pub(super) recovered: Option<Instant>,
    /// Whether the state differs from the status file's, and whether that said idle.
    pub(super) reported: (bool, bool),
    _watcher: Option<notify::RecommendedWatcher>,
}

impl Viewer {
    /// A viewer for a hidden window.
    pub(crate) fn new(
        options: ViewerOptions,
        window: Arc<Window>,
        graphics: &Graphics,
        event_loop: &ActiveEventLoop,
        proxy: EventLoopProxy<UserEvent>,
        keeper: Keeper,
    ) -> Self {
        let ctx = egui::Context::default();
        // The size of text is an action of ours, so that it has a key of the user's choice and is kept.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        if options.status.is_some() {
            ctx.enable_accesskit();
        }
        let limit = Some(graphics.gpu.capabilities.max_texture as usize);
        let scale = Some(window.scale_factor() as f32);
        let mut egui = egui_winit::State::new(ctx, egui::ViewportId::ROOT, &*window, scale, window.theme(), limit);
        egui.init_accesskit(event_loop, &window, proxy.clone());
        window.set_title(&format!("Relief: {}", options.title));

        let watch_proxy = proxy.clone();
        let watcher = watch::shaders(move || {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = watch_proxy.send_event(UserEvent::ShadersChanged);
        });
        let files = Files::new(
            options.provenance,
            (&options.title, options.scene.terrain.recipe.as_ref()),
            options.more,
            &options.import,
        );
        let mut viewer = Self {
            window,
            egui,
            scale: Scale::default(),
            facts: Facts::new(&options.map, options.title, &graphics.gpu),
            map: options.map,
            view: ViewSettings { paths: PathFields::of(&options.scene), ..ViewSettings::default() },
            scene: options.scene,
            fly: Fly::default(),
            journey: Journey::default(),
            film: None,
            keeper,
            #[cfg(feature = "gamepad")]
            gamepads: Default::default(),
            pointer: Pointer::default(),
            toasts: Toasts::default(),
            loader: Loader::default(),
            generator: Generator::default(),
            files,
            redraw: Redraw::default(),
            meter: Meter::default(),
            reference: ReferenceWorker::default(),
            cones: ConeFinder::default(),
            compiler: Compiler::default(),
            shows_reference: false,
            baking: None,
            tradeoff: Tradeoff::default(),
            says: None,
            hint: None,
            free: egui::Rect::EVERYTHING,
            drawn: None,
            shown: None,
            last_good: None,
            prepared: false,
            occluder_seen: false,
            motion: crate::render::Motion::default(),
            flowed: None,
            ran: None,
            spun: None,
            drifted: None,
            covered: false,
            hidden: false,
            minimised_until: None,
            frames: 0,
            wants_screenshot: false,
            quit: false,
            widgets: Vec::new(),
            status: options.status.map(StatusFile::new),
            proxy,
            reload_at: None,
            saving: false,
            writers: Vec::new(),
            screenshots: options.screenshots,
            recovered: None,
            reported: (true, false),
            _watcher: watcher,
        };
        if let Some(recipe) = &viewer.scene.terrain.recipe {
            viewer.view.generate.take(recipe);
        }
        let size = viewer.extent();
        let camera = *viewer.scene.camera.get_or_insert_with(|| NamedView::Start.camera(&viewer.map, size));
        // A scene that looks from below the ground means it.
        viewer.view.allow_below_ground = ground_below(&viewer.map, size, camera.eye).is_some_and(|y| camera.eye.y < y);
        let now = Instant::now();
        for warning in options.warnings {
            viewer.toasts.warning(&warning, now);
        }
        viewer.restore();
        let proxy = viewer.proxy.clone();
        desktop::ask(move |wishes| {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Wishes(wishes));
        });
        viewer.redraw.invalidate();
        viewer
    }

    /// Tells what went wrong before there was a window.
    pub(crate) fn tell(&mut self, messages: &[String]) {
        messages.iter().for_each(|message| self.toasts.error(message));
    }

    /// The window.
    pub(crate) fn window(&self) -> &Arc<Window> {
        &self.window
    }

    /// The terrain as it was loaded.
    pub(crate) fn map(&self) -> Arc<HeightField> {
        self.map.clone()
    }

    /// Whether the user has asked to leave, by key; the window system asks for itself.
    pub(crate) fn wants_to_quit(&self) -> bool {
        self.quit
    }

    /// Whether frames wait for the screen.
    pub(crate) fn vsync(&self) -> bool {
        self.view.vsync
    }

    /// Size of the terrain's box, world units.
    pub(super) fn extent(&self) -> DVec3 {
        self.map.box_size(self.scene.terrain.height_scale)
    }

    /// The eye; the scene of a running viewer always has one.
    pub(super) fn camera(&self) -> Camera {
        self.scene.camera.unwrap_or_else(|| NamedView::Start.camera(&self.map, self.extent()))
    }

    /// When the event loop has to come back.
    pub(crate) fn next(&self, now: Instant) -> Next {
        let size = self.window.inner_size();
        let frame = if self.is_unseen() || size.width == 0 || size.height == 0 {
            Next::Never
        } else {
            match (self.redraw.next(now, self.moves(), self.view.frame_limit), self.minimised_until) {
                (Next::Never, _) => Next::Never,
                (_, Some(until)) if until > now => Next::At(until),
                (next, _) => next,
            }
        };
        #[cfg(feature = "gamepad")]
        let frame = frame.or(self.gamepads.next(now));
        let reload = self.reload_at.map_or(Next::Never, Next::At);
        let tradeoff = if self.may_measure_tradeoff() { Next::At(now) } else { Next::Never };
        let film = self.film.as_ref().map_or(Next::Never, |film| film.next(now));
        frame
            .or(reload)
            .or(film)
            .or(self.keeper.next())
            .or(self.generator.next())
            .or(tradeoff)
            .or(self.reference.next())
            .or(self.meter.next(now, self.measures_steps()))
    }

    /// Whether nobody sees the window, as far as one is told: covered by others, or with no surface to draw to.
    pub(super) fn is_unseen(&self) -> bool {
        self.covered || self.hidden
    }

    /// Whether steps per ray are wanted, and there is a picture to measure them for. What is being compiled may be for them.
    pub(super) fn measures_steps(&self) -> bool {
        self.view.measure_steps && self.drawn.is_some() && !self.compiler.is_busy()
    }

    /// The last measurement of steps per ray, while they are measured.
    pub(super) fn steps(&self) -> Option<Steps> {
        self.meter.steps.filter(|_| self.view.measure_steps)
    }

    /// Looks for what has happened meanwhile: loaded maps, frame times, saved shaders.
    pub(crate) fn poll(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        if let Some(lost) = graphics.gpu.lost() {
            return Err(FrameError::Lost(lost));
        }
        if let Some(result) = self.loader.poll() {
            self.redraw.invalidate();
            match result {
                Ok(opened) => self.adopt(graphics, opened, now)?,
                Err(failure) => self.did_not_open(&failure),
            }
        }
        self.open_dropped();
        self.follow_generator(graphics, now)?;
        if self.reload_at.is_some_and(|at| at <= now) {
            self.reload_at = None;
            self.reload_shaders(graphics, now)?;
        }
        self.follow_cones(graphics);
        self.follow_compiler(graphics);
        if self.measures_steps() {
            self.measure_steps(graphics, now)?;
        }
        self.follow_reference(graphics, now)?;
        if self.may_measure_tradeoff() {
            self.measure_tradeoff(graphics)?;
        }
        #[cfg(feature = "gamepad")]
        if matches!(self.gamepads.next(now), Next::At(at) if at <= now) && self.gamepads.look(now) {
            self.journey.stop();
            self.redraw.invalidate();
        }
        self.follow_film(graphics, now)?;
        if self.view.log.is_stale() {
            self.redraw.wake_at(now + LOG_PAUSE);
        }
        self.keep(now);
        // The numbers on screen are of the frame before.
        if self.meter.collect_times(|| graphics.renderer.take_frame_time(), now)
            && (self.view.overlay || self.view.panel)
        {
            self.redraw.invalidate();
        }
        Ok(())
    }

    fn measure_steps(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        let scene = self.drawable(graphics);
        match self.meter.measure_steps(&mut graphics.renderer, &scene, graphics.target.size(), now) {
            Ok(false) => return Ok(()),
            Ok(true) => {}
            Err(RenderError::DeviceLost(lost)) => return Err(FrameError::Lost(lost)),
            Err(error) => {
                self.view.measure_steps = false;
                self.toasts.error(&format!("Steps per ray cannot be measured: {error}"));
            }
        }
        self.redraw.invalidate();
        Ok(())
    }

    fn reload_shaders(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        self.redraw.invalidate();
        match graphics.renderer.reload_shaders() {
            Ok(()) => {
                self.drawn = None;
                self.meter.forget_times();
                self.toasts.dismiss_errors();
                self.toasts.info("Shaders reloaded", now);
            }
            Err(RenderError::DeviceLost(lost)) => return Err(FrameError::Lost(lost)),
            Err(error) => self.toasts.error(&format!("The old shaders stay. {error}")),
        }
        Ok(())
    }

    /// Writes a file on a thread of its own, which the program's end waits for.
    pub(super) fn write(&mut self, name: &str, work: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        self.writers.retain(|writer| !writer.is_finished());
        self.writers.push(std::thread::Builder::new().name(name.into()).spawn(work)?);
        Ok(())
    }

    /// Waits for the files that are being written.
    pub(crate) fn finish_writing(&mut self) {
        for writer in self.writers.drain(..) {
            // A panic has been told on stderr.
            let _ = writer.join();
        }
    }

    /// What another thread told.
    pub(crate) fn user_event(&mut self, event: UserEvent, now: Instant) {
        use egui_winit::accesskit_winit::WindowEvent as Access;
        self.redraw.invalidate();
        match event {
            UserEvent::Accessibility(event) => match event.window_event {
                Access::InitialTreeRequested => self.egui.egui_ctx().enable_accesskit(),
                Access::ActionRequested(request) => self.egui.on_accesskit_action_request(request),
                Access::AccessibilityDeactivated if self.status.is_none() => self.egui.egui_ctx().disable_accesskit(),
                Access::AccessibilityDeactivated => {}
            },
            // The map itself is fetched by `poll`.
            UserEvent::Loaded => {}
            UserEvent::Files(event) => self.files_event(event, now),
            // So are the distances.
            UserEvent::Reference => {}
            // And the cones.
            UserEvent::Cones => {}
            // And the pipelines.
            UserEvent::Compiled => {}
            UserEvent::Wishes(wishes) => self.keeper.set_wishes(wishes),
            UserEvent::ShadersChanged => self.reload_at = Some(now + SHADER_PAUSE),
            UserEvent::Screenshot(result) => {
                self.saving = false;
                match result {
                    Ok(path) => self.toasts.info(&format!("Saved {} and its scene", path.display()), now),
                    Err(message) => self.toasts.error(&message),
                }
            }
        }
    }
}
