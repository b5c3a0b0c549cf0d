//! What the viewer does for the errors of techniques: keeps the f64 reference that of the view, and measures error against
//! time.

use std::sync::Arc;
use std::time::Instant;

use super::frame::FrameError;
use super::graphics::Graphics;
use super::legend::Against;
use super::reference::Question;
use super::viewer::Viewer;
use super::visible::visible_part;
use super::window::UserEvent;
use crate::render::RenderError;
use crate::scene::{CraterMode, DebugView};

impl Viewer {
    /// Whether the next frame is one of the measurement of the techniques: the window draws one of its own in between,
    /// if anybody sees it. While cones are found nothing is measured: it would be slow, or wait for them.
    pub(super) fn may_measure_tradeoff(&self) -> bool {
        self.tradeoff.progress().is_some()
            && !self.cones.is_busy()
            && !self.compiler.is_busy()
            && (self.hidden || !self.redraw.is_wanted())
    }

    /// A frame of the measurement of the techniques.
    pub(super) fn measure_tradeoff(&mut self, graphics: &mut Graphics) -> Result<(), FrameError> {
        self.redraw.invalidate();
        let stepped = self.tradeoff.step(&mut graphics.renderer, &self.map);
        // It has waited for all frames.
        self.meter.nothing_in_flight();
        match stepped {
            Ok(()) => {
                if self.tradeoff.progress().is_none() {
                    self.restore_reference();
                }
                Ok(())
            }
            Err(RenderError::DeviceLost(lost)) => Err(FrameError::Lost(lost)),
            Err(error) => {
                self.forget_tradeoff();
                self.toasts.error(&format!("The techniques cannot be measured: {error}"));
                Ok(())
            }
        }
    }

    /// Forgets what was measured of the techniques, and ends what is under way.
    pub(super) fn forget_tradeoff(&mut self) {
        if self.tradeoff.progress().is_some() {
            self.restore_reference();
        }
        self.tradeoff.forget();
    }

    /// After a measurement: its frames have taken the reference of the picture away.
    fn restore_reference(&mut self) {
        if self.scene.debug.view == DebugView::Error {
            self.reference.forget();
            self.drawn = None;
        }
    }

    /// What the reference has to be of, for the picture on screen; nothing where no error shows. Craters in a layer of
    /// their own have a resolution of their own, which the reference does not know.
    fn question(&self, graphics: &Graphics) -> Option<Question> {
        let scene = self.drawn.as_ref()?;
        let craters = &scene.craters;
        let layered = craters.mode == CraterMode::Layered && !craters.list.is_empty();
        (scene.debug.view == DebugView::Error && !layered).then(|| Question {
            map: Arc::clone(&self.map),
            craters: craters.list.clone(),
            extent: self.map.box_size(scene.terrain.height_scale),
            camera: scene.camera.unwrap_or_else(|| self.camera()),
            size: graphics.target.size(),
        })
    }

    /// Whether the reference of the picture on screen is being waited for.
    pub(super) fn awaits_reference(&self) -> bool {
        self.reference.is_busy()
    }

    /// What the error view's errors are against.
    pub(super) fn errors_against(&self) -> Against {
        Against { reference: self.shows_reference, awaited: self.awaits_reference() }
    }

    /// Keeps the reference's distances those of the view on screen: found on other threads once it rests.
    pub(super) fn follow_reference(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        if self.drawn.is_none() {
            // About to be drawn anew, perhaps with the distances that have just arrived.
            return Ok(());
        }
        let Some(question) = self.question(graphics) else {
            self.reference.forget();
            return Ok(());
        };
        if !self.reference.is_about(&question) {
            self.reference.ask(question, now);
        }
        let proxy = self.proxy.clone();
        let done = move || {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Reference);
        };
        let result = match self.reference.poll(now, done) {
            Ok(None) => return Ok(()),
            Ok(Some((size, distances))) => {
                graphics.renderer.set_reference(size, Some(&distances)).map_err(|error| error.to_string())
            }
            Err(reason) => Err(reason),
        };
        if let Err(reason) = result {
            self.toasts.error(&format!("The errors stay those against max-mipmap: no f64 reference: {reason}"));
        }
        self.drawn = None;
        self.redraw.invalidate();
        Ok(())
    }

    /// Before a picture is drawn: a reference of another view is none.
    pub(super) fn drop_stale_reference(&mut self, graphics: &mut Graphics) {
        if !graphics.renderer.shows_reference() {
            return;
        }
        let drawn = self.drawn.replace(visible_part(&self.drawable(graphics)));
        let current = self.question(graphics).is_some_and(|question| self.reference.is_about(&question));
        self.drawn = drawn;
        if !current {
            self.reference.forget();
            // Taking a reference away cannot fail.
            let _ = graphics.renderer.set_reference([0, 0], None);
        }
    }
}
