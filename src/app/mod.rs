//! The viewer: a window over the terrain, the keys and the mouse, the panel and the overlays.
//!
//! Only this part of the house knows winit and egui. [`run`] opens the window; everything else is private:
//!
//! A window that nobody sees draws nothing, as far as one is told: X11 (without a compositor), macOS and iOS tell that a
//! window is covered, X11 with a window manager, Windows and macOS that it is minimised. Wayland tells neither, but asks an
//! unseen window for no frames; what lies under a compositor's windows on X11, or under others on Windows, is drawn.
//!
//! | file | what it holds |
//! |---|---|
//! | `window` | the event loop: what the window system sends, and when it is asked to come back |
//! | `viewer` | the state of the viewer, loading, shader reload, lost devices |
//! | `commands`, `input` | what the panel asks for; keys, mouse and dropped files |
//! | `actions`, `acting` | the table of what keys do; doing it |
//! | `keys`, `key_names` | which key does what; what keys are called |
//! | `preferences`, `keeping`, `desktop` | what is kept between runs; taking it up and writing it; what the desktop asks for |
//! | `orbit`, `journey`, `filming` | turning around a point; bookmarks and camera paths; a path as an animation |
//! | `frame` | one frame: fly, run the panel, draw the scene if it changed, present |
//! | `graphics`, `surface`, `scale` | what lives on the GPU; the surface's life; the monitor's scale |
//! | `controls`, `picking`, `redraw` | the fly camera, the crater under the cursor, when a frame is due: no window needed |
//! | `settings`, `panel`, `overlay`, `toasts`, `log_pane`, `welcome`, `looks` | what egui draws |
//! | `gamepad` | sticks; only with the feature of that name |
//! | `reading`, `profile`, `legend` | the land under the cursor and between two clicks; what its colours mean |
//! | `stamp` | the legend in saved pictures, with or without a window |
//! | `measure`, `tradeoff` | frame times and steps per ray; error against time of the techniques |
//! | `errors` | what the viewer does with those of techniques |
//! | `reference`, `cones` | the f64 reference of the error view, and cone maps, on threads of their own |
//! | `generating` | landscapes made from the panel's recipe, on a thread of their own |
//! | `compiling` | pipelines, on a thread of their own, and what draws meanwhile |
//! | `files` | maps in and out: several at once, drops, dialogues, recent files, the import card, saving |
//! | `loading`, `screenshot`, `status`, `watch` | files: maps, pictures, state for automated tests, shaders |

mod acting;
mod actions;
mod adopting;
mod commands;
mod compiling;
mod cones;
mod controls;
mod desktop;
mod errors;
mod files;
mod filming;
mod frame;
#[cfg(any(test, feature = "gamepad"))]
mod gamepad;
mod generating;
mod graphics;
mod input;
mod journey;
mod keeping;
mod key_names;
mod keys;
pub(crate) mod legend;
mod loading;
mod log_pane;
mod looks;
mod measure;
mod motion;
mod orbit;
mod overlay;
mod panel;
mod picking;
mod preferences;
mod profile;
mod reading;
mod recovering;
mod redraw;
mod reference;
mod scale;
mod screenshot;
mod settings;
pub(crate) mod stamp;
mod status;
mod surface;
mod toasts;
mod tradeoff;
mod viewer;
mod visible;
mod watch;
mod welcome;
mod window;

use std::path::PathBuf;
use std::sync::Arc;

use winit::event_loop::EventLoop;

use crate::gpu::GpuError;
use crate::heightfield::import::ImportOptions;
use crate::heightfield::{HeightField, Provenance};
use crate::render::RenderError;
use crate::scene::Scene;

/// What the viewer opens with.
#[derive(Clone, Debug)]
pub struct ViewerOptions {
    /// The terrain.
    pub map: Arc<HeightField>,
    /// What to call it in the window's title and in the panel.
    pub title: String,
    /// What loading it had to say; shown as messages.
    pub warnings: Vec<String>,
    /// Where the map came from and how it was read, for the import card and for saving it.
    pub provenance: Option<Provenance>,
    /// More maps, which are opened when they are gone to (Ctrl+Tab).
    pub more: Vec<PathBuf>,
    /// How those, and the first when it is gone back to, are opened.
    pub import: ImportOptions,
    /// What to draw. `scene.terrain.file` names the file that `map` came from, so that a screenshot's scene finds it.
    pub scene: Scene,
    /// Size of the window's inside in physical pixels; `None` is 1280×800 points.
    pub size: Option<[u32; 2]>,
    /// A JSON file that is kept up to date with the viewer's state, for automated tests and remote control.
    pub status: Option<PathBuf>,
    /// The folder that screenshots are written to.
    pub screenshots: PathBuf,
    /// Forget the settings of earlier runs; their file is put aside.
    pub reset_settings: bool,
}

impl ViewerOptions {
    /// Opens `map`, called `title`, with a default scene; screenshots go to the current folder.
    pub fn new(map: Arc<HeightField>, title: impl Into<String>) -> Self {
        Self {
            map,
            title: title.into(),
            warnings: Vec::new(),
            provenance: None,
            more: Vec::new(),
            import: ImportOptions::default(),
            scene: Scene::default(),
            size: None,
            status: None,
            screenshots: PathBuf::from("."),
            reset_settings: false,
        }
    }
}

/// Why the viewer did not start, or had to end.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// There is no window system, or it gave no window.
    #[error(
        "cannot open a window\n  {0}\n  start on a desktop, or draw without a window: relief render -o picture.png"
    )]
    Window(String),
    /// The window cannot be drawn to.
    #[error(
        "cannot draw to the window\n  {0}\n  \
         update the GPU driver, or draw without a window: relief render -o picture.png"
    )]
    Surface(String),
    /// There is no device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The first frame could not be drawn, or the terrain does not fit.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The device was lost and could not be set up again.
    #[error("the GPU device was lost: {lost}\n  it could not be set up again: {again}\n  start the viewer again")]
    Lost {
        /// Why it was lost.
        lost: String,
        /// Why there is no new one.
        again: String,
    },
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// [`AppError`], when there is no window, no usable GPU, or the device is lost for good. What goes wrong later (a file
/// that cannot be opened, a shader that does not compile) is told in the window, and what was there before stays.
pub fn run(options: ViewerOptions) -> Result<(), AppError> {
    let no_window = |error: winit::error::EventLoopError| AppError::Window(error.to_string());
    let event_loop = EventLoop::<window::UserEvent>::with_user_event().build().map_err(no_window)?;
    let mut app = window::App::new(options, event_loop.create_proxy());
    event_loop.run_app(&mut app).map_err(no_window)?;
    app.into_result()
}
