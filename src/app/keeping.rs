//! Settings, keys, bookmarks and the window between runs: taken up at the start, kept soon after they change, and at the end.

use std::path::Path;
use std::time::{Duration, Instant};

use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event_loop::ActiveEventLoop;
use winit::window::WindowAttributes;

use super::desktop::Wishes;
use super::keys::KeyMap;
use super::looks;
use super::preferences::{Interface, Motion, Moving, Pace, Preferences, Store, Theme, WindowPlace};
use super::redraw::Next;
use super::viewer::Viewer;

/// How long settings rest before they are written: a slider is dragged through many.
const PAUSE: Duration = Duration::from_secs(1);

/// Least part of a window that has to be on a monitor for its place to be used again, physical pixels.
const VISIBLE: i32 = 64;

/// What is kept, and when it is written.
#[derive(Debug)]
pub(super) struct Keeper {
    store: Store,
    /// The bookmarks of all maps, and the window's place as it was last looked at.
    kept: Preferences,
    /// The window was moved or has another size since.
    moved: bool,
    due: Option<Instant>,
    /// What the looks were made for.
    looks: Option<(Theme, bool, Option<bool>)>,
    /// The part of egui's zoom that is the user's.
    zoom: f32,
    wishes: Wishes,
    /// The size that the command line asked for, which is for this run.
    asked: Option<[u32; 2]>,
}

impl Keeper {
    /// A keeper of what was read; a window of the size `asked` is not remembered.
    pub(super) fn new(store: Store, kept: Preferences, asked: Option<[u32; 2]>) -> Self {
        Self { store, kept, moved: true, due: None, looks: None, zoom: 1.0, wishes: Wishes::default(), asked }
    }

    /// The window was moved or has another size.
    pub(super) fn window_moved(&mut self) {
        self.moved = true;
    }

    /// What the desktop asks for.
    pub(super) fn set_wishes(&mut self, wishes: Wishes) {
        self.wishes = wishes;
    }

    /// When settings are to be written.
    pub(super) fn next(&self) -> Next {
        self.due.map_or(Next::Never, Next::At)
    }
}

/// Gives a window the place of the last run, as far as it is on a monitor.
pub(super) fn placed(
    attributes: WindowAttributes,
    place: &WindowPlace,
    event_loop: &ActiveEventLoop,
) -> WindowAttributes {
    let mut attributes = attributes.with_maximized(place.maximised);
    let Some([width, height]) = place.size else { return attributes };
    attributes = attributes.with_inner_size(PhysicalSize::new(width, height));
    let on_screen = |&[x, y]: &[i32; 2]| {
        event_loop.available_monitors().any(|monitor| {
            let (corner, size) = (monitor.position(), monitor.size());
            let reaches = |at: i32, length: u32, start: i32, side: u32| {
                at.saturating_add_unsigned(length) >= start.saturating_add(VISIBLE)
                    && at <= start.saturating_add_unsigned(side).saturating_sub(VISIBLE)
            };
            reaches(x, width, corner.x, size.width)
                && reaches(y, height, corner.y, size.height)
                && y >= corner.y - VISIBLE
        })
    };
    match place.position.filter(on_screen) {
        Some([x, y]) => attributes.with_position(PhysicalPosition::new(x, y)),
        None => attributes,
    }
}

impl Viewer {
    /// Takes up what was kept, before the first frame.
    pub(super) fn restore(&mut self) {
        let Preferences { interface, pace, moving, keys, key_labels, .. } = self.keeper.kept.clone();
        let Interface { theme, motion, zoom, panel, overlay, log, welcome } = interface;
        let view = &mut self.view;
        (view.theme, view.motion, view.zoom) = (theme, motion, zoom);
        (view.panel, view.overlay, view.log.open, view.welcome) = (panel, overlay, log, welcome);
        (view.vsync, view.frame_limit, view.mode) = (pace.vsync, pace.frame_limit, moving.mode);
        self.fly.speed = moving.speed;
        let (map, problems) = KeyMap::restore(&keys, &key_labels);
        view.keys = map;
        for problem in problems {
            self.toasts.error(&format!("A key of the settings cannot be used: {problem}"));
        }
        self.take_up_bookmarks();
    }

    /// The file that the bookmarks of the map on screen go by. Made maps have one set of them: with the next seed the eye
    /// stays, too.
    fn notes_file(&self) -> Option<&Path> {
        let terrain = &self.scene.terrain;
        terrain.file.as_deref().or(terrain.recipe.as_ref().map(|_| Path::new("(generated)")))
    }

    /// The bookmarks of the map on screen.
    pub(super) fn take_up_bookmarks(&mut self) {
        self.view.bookmarks = self.keeper.kept.bookmarks(self.notes_file());
    }

    /// What is to be kept, as it is now.
    fn preferences(&self) -> Preferences {
        let view = &self.view;
        let mut kept = Preferences {
            window: self.keeper.kept.window.clone(),
            interface: Interface {
                theme: view.theme,
                motion: view.motion,
                zoom: view.zoom,
                panel: view.panel,
                overlay: view.overlay,
                log: view.log.open,
                welcome: view.welcome,
            },
            pace: Pace { vsync: view.vsync, frame_limit: view.frame_limit },
            moving: Moving { mode: view.mode, speed: self.fly.speed },
            keys: view.keys.changes(),
            key_labels: view.keys.labels(),
            maps: self.keeper.kept.maps.clone(),
        };
        kept.set_bookmarks(self.notes_file(), view.bookmarks.clone());
        kept
    }

    /// Writes settings that have changed and come to rest.
    pub(super) fn keep(&mut self, now: Instant) {
        let differs = self.keeper.moved || self.keeper.store.differs(&self.preferences());
        match self.keeper.due {
            _ if !differs => self.keeper.due = None,
            None => self.keeper.due = Some(now + PAUSE),
            Some(due) if due <= now => self.keep_now(),
            Some(_) => {}
        }
    }

    /// Writes settings that have changed.
    pub(super) fn keep_now(&mut self) {
        self.keeper.due = None;
        if std::mem::take(&mut self.keeper.moved) {
            self.note_place();
        }
        self.keeper.kept = self.preferences();
        if let Err(message) = self.keeper.store.write(&self.keeper.kept) {
            self.toasts.error(&message);
            self.redraw.invalidate();
        }
    }

    fn note_place(&mut self) {
        if self.window.fullscreen().is_some() || self.window.is_minimized() == Some(true) {
            return;
        }
        let place = &mut self.keeper.kept.window;
        place.maximised = self.window.is_maximized();
        if !place.maximised {
            let size: [u32; 2] = self.window.inner_size().into();
            if !size.contains(&0) && self.keeper.asked != Some(size) {
                place.size = Some(size);
            }
            place.position = self.window.outer_position().ok().map(Into::into);
        }
    }

    /// Whether the eye jumps where it would glide, and nothing of the interface moves.
    pub(super) fn reduces_motion(&self) -> bool {
        match self.view.motion {
            Motion::System => self.keeper.wishes.reduced_motion == Some(true),
            Motion::Full => false,
            Motion::Reduced => true,
        }
    }

    /// Makes egui look as the settings say.
    pub(super) fn follow_looks(&mut self) {
        let ctx = self.egui.egui_ctx();
        let wished = self.keeper.wishes.light.filter(|_| self.window.theme().is_none());
        let looks = (self.view.theme, self.reduces_motion(), wished);
        if self.keeper.looks != Some(looks) {
            self.keeper.looks = Some(looks);
            let theme = match (self.view.theme, wished) {
                (Theme::Dark, _) | (Theme::System, Some(false)) => egui::ThemePreference::Dark,
                (Theme::Light, _) | (Theme::System, Some(true)) => egui::ThemePreference::Light,
                (Theme::System, None) => egui::ThemePreference::System,
            };
            ctx.set_theme(theme);
            looks::legible(ctx);
            let usual = egui::Style::default().animation_time;
            ctx.all_styles_mut(|style| style.animation_time = if looks.1 { 0.0 } else { usual });
        }
        if self.keeper.zoom != self.view.zoom {
            ctx.set_zoom_factor(ctx.zoom_factor() * self.view.zoom / self.keeper.zoom);
            self.keeper.zoom = self.view.zoom;
        }
    }
}
