//! What the panel and the keys ask for.

use std::time::Instant;

use winit::window::Fullscreen;

use super::frame::FrameError;
use super::graphics::Graphics;
use super::legend;
use super::screenshot;
use super::settings::Command;
use super::stamp::{Legend, Stamp};
use super::viewer::Viewer;
use super::visible::scene_of_picture;
use super::window::UserEvent;
use crate::gpu::Target;

impl Viewer {
    /// Does what the panel or a key asked for.
    pub(super) fn execute(&mut self, graphics: &Graphics, command: Command) {
        self.redraw.invalidate();
        match command {
            Command::GoToBookmark(digit) => self.go_to_bookmark(digit, Instant::now()),
            Command::SetBookmark(digit) => self.set_bookmark(digit, Instant::now()),
            Command::Path(command) => self.path_command(graphics, command, Instant::now()),
            Command::Make(command) => self.make_command(command, Instant::now()),
            Command::Files(command) => self.files_command(command),
            Command::View(view) => {
                self.journey.stop();
                self.scene.camera = Some(view.camera(&self.map, self.extent()));
            }
            Command::UndoCrater => {
                self.scene.craters.list.pop();
            }
            Command::ClearCraters => self.scene.craters.list.clear(),
            Command::MeasureTradeoff => {
                let target = Target::new(&graphics.gpu, graphics.target.size());
                self.tradeoff.start(&self.scene, target);
            }
            Command::ForgetTradeoff => self.forget_tradeoff(),
            Command::Exaggerate(times) => self.exaggerate(graphics, times, Instant::now()),
            Command::Measure(on) => self.view.reading.set_measure(on),
            Command::Screenshot => self.wants_screenshot = true,
            Command::FullScreen => {
                let full = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(full);
            }
        }
    }

    /// Reads the kept picture back and writes it with its scene, the writing on another thread.
    pub(super) fn screenshot(&mut self, graphics: &Graphics) -> Result<(), FrameError> {
        // What the picture shows: not what a key has changed since, nor a technique that still has to be compiled or whose
        // cones are being found.
        let scene =
            self.drawn.as_ref().map_or_else(|| self.scene.clone(), |drawn| scene_of_picture(drawn, &self.scene));
        let read = if scene.saved.legend && legend::exists(&scene) {
            let errors = self.errors_against();
            let pixels_per_point = Some(self.pixels_per_point() as f32);
            let legend = Legend { scene: &scene, map: &self.map, errors, pixels_per_point };
            Stamp::new(&graphics.gpu).picture(&graphics.gpu, &graphics.target, &legend)
        } else {
            graphics.target.read_color(&graphics.gpu)
        };
        let picture = match read {
            Ok(picture) => picture,
            Err(error) => {
                self.toasts.error(&format!("No screenshot: {error}"));
                return graphics.gpu.lost().map_or(Ok(()), |lost| Err(FrameError::Lost(lost)));
            }
        };
        let (folder, proxy) = (self.screenshots.clone(), self.proxy.clone());
        self.saving = true;
        let write = move || {
            let result = screenshot::save(&folder, &picture, &scene).map_err(|error| error.to_string());
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Screenshot(result));
        };
        if let Err(error) = self.write("screenshot", write) {
            self.saving = false;
            self.toasts.error(&format!("No screenshot: no thread to write on: {error}. Close some programs."));
        }
        Ok(())
    }
}
