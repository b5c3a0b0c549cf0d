//! One frame: fly, run the panel, draw the scene if it changed, show the picture with egui over it.

use std::time::{Duration, Instant};

use winit::event_loop::ActiveEventLoop;

use super::graphics::{Graphics, Shown, Ui};
use super::measure::Subject;
use super::settings::Command;
use super::status::widgets;
use super::viewer::Viewer;
use super::visible::visible_part;
use super::{AppError, controls, legend, looks, overlay, panel, welcome};
use crate::heightfield::HeightField;
use crate::render::RenderError;
use crate::scene::Scene;

/// How often it is told how far the search for cones is.
const CONES_PAUSE: Duration = Duration::from_millis(200);

/// How long a light map may be under way before it is told.
const BAKE_PATIENCE: Duration = Duration::from_millis(400);

/// How long to wait for a surface that is not ready.
const SURFACE_PAUSE: Duration = Duration::from_millis(30);

/// How often it is looked whether the window is minimised still, while there is something to draw.
const MINIMISED_PAUSE: Duration = Duration::from_millis(250);

/// A spinning occluder jumps no further than this after a stall.
const LONGEST_SPIN: Duration = Duration::from_millis(250);

/// Why the viewer cannot go on as it is.
#[derive(Debug)]
pub(crate) enum FrameError {
    /// The device is lost; everything on it has to be made anew.
    Lost(String),
    /// There is no way on.
    Fatal(AppError),
}

impl Viewer {
    /// Draws what changed and shows it.
    pub(crate) fn frame(
        &mut self,
        graphics: &mut Graphics,
        event_loop: &ActiveEventLoop,
        now: Instant,
    ) -> Result<(), FrameError> {
        let size: [u32; 2] = self.window.inner_size().into();
        // Not every window system tells when a window is minimised (X11 does not), and none when it will not be any more.
        self.minimised_until = (self.window.is_minimized() == Some(true)).then(|| now + MINIMISED_PAUSE);
        if self.minimised_until.is_some() {
            self.redraw.invalidate();
            return Ok(());
        }
        self.redraw.begin_frame(now);
        if size.contains(&0) {
            return Ok(());
        }
        self.advance(graphics, now);
        if graphics.follow(size, self.view.vsync) {
            self.drawn = None;
        }
        self.facts.ledger = graphics.renderer.ledger().clone();
        let (ui, commands) = self.run_egui(graphics, event_loop, now);
        for command in commands {
            self.execute(graphics, command);
        }
        self.settle_eye(graphics);
        self.draw_scene(graphics, now)?;
        // Not with a part of a light map.
        if self.wants_screenshot && self.drawn.is_some() && self.baking.is_none() {
            self.wants_screenshot = false;
            self.screenshot(graphics)?;
        }
        self.show(graphics, ui, now)
    }

    /// Shows the kept picture and egui.
    fn show(&mut self, graphics: &mut Graphics, ui: Ui, now: Instant) -> Result<(), FrameError> {
        let shown = graphics.present(&self.window, ui, self.drawn.is_some()).map_err(|error| match error {
            RenderError::DeviceLost(lost) => FrameError::Lost(lost),
            error => FrameError::Fatal(error.into()),
        })?;
        match shown {
            Shown::Yes => {
                self.frames += 1;
                self.compiler.frame_was_shown();
                self.unreported();
            }
            Shown::Later => self.redraw.wake_at(now + SURFACE_PAUSE),
            // Drawn again once the window system says that it can be seen.
            Shown::Hidden => self.hidden = true,
            Shown::Lost(reason) => return Err(FrameError::Lost(reason)),
        }
        match graphics.gpu.lost() {
            Some(lost) => Err(FrameError::Lost(lost)),
            None => Ok(()),
        }
    }

    /// Moves the eye and turns the occluder by the time that has passed.
    fn advance(&mut self, graphics: &Graphics, now: Instant) {
        #[cfg(feature = "gamepad")]
        self.advance_by_gamepad(graphics, now);
        if let Some(camera) = self.journey.at(now) {
            self.scene.camera = Some(camera);
            // Once more where it has arrived.
            self.redraw.invalidate();
        }
        if self.fly.is_moving() {
            let mut camera = self.camera();
            let height = controls::height_above_ground(self.ground(graphics), self.extent(), camera.eye);
            camera.eye += self.fly.step(&camera, height, now);
            self.scene.camera = Some(camera);
        }
        self.ran = if self.sun_moves() {
            let passed = now.saturating_duration_since(self.ran.unwrap_or(now)).min(LONGEST_SPIN);
            self.scene.lighting.clock.run(passed.as_secs_f64());
            Some(now)
        } else {
            None
        };
        self.drifted = if self.clouds_move() {
            let passed = now.saturating_duration_since(self.drifted.unwrap_or(now)).min(LONGEST_SPIN);
            self.scene.clouds.run(passed.as_secs_f64());
            Some(now)
        } else {
            None
        };
        self.spun = if self.spins() {
            let passed = now.saturating_duration_since(self.spun.unwrap_or(now)).min(LONGEST_SPIN);
            let occluder = &mut self.scene.occluder;
            occluder.rotation.x = (occluder.rotation.x + occluder.spin * passed.as_secs_f64()).rem_euclid(360.0);
            Some(now)
        } else {
            None
        };
        self.flowed = if self.flows() {
            let passed = now.saturating_duration_since(self.flowed.unwrap_or(now)).min(LONGEST_SPIN);
            self.scene.water.run(passed.as_secs_f64());
            Some(now)
        } else {
            None
        };
    }

    /// The terrain with the craters of the last picture.
    pub(super) fn ground<'a>(&'a self, graphics: &'a Graphics) -> &'a HeightField {
        graphics.renderer.terrain().map_or(&self.map, |terrain| terrain.field())
    }

    /// Lifts the eye out of the ground, unless it may be there.
    fn settle_eye(&mut self, graphics: &Graphics) {
        let mut camera = self.camera();
        let allowed = self.view.allow_below_ground;
        if !allowed && controls::keep_above_ground(&mut camera, self.ground(graphics), self.extent()) {
            self.scene.camera = Some(camera);
            self.redraw.invalidate();
        }
    }

    /// Runs the panel and the overlays.
    fn run_egui(&mut self, graphics: &Graphics, event_loop: &ActiveEventLoop, now: Instant) -> (Ui, Vec<Command>) {
        let window = self.window.clone();
        let ctx = self.egui.egui_ctx().clone();
        if let Some(factor) = self.scale.change_of_zoom(window.scale_factor()) {
            ctx.set_zoom_factor(ctx.zoom_factor() * factor);
        }
        self.follow_looks();
        (self.view.path.playing, self.view.path.writing) = (self.journey.is_playing(), self.film.is_some());
        self.view.generate.share = self.generator.progress();
        self.facts.extent = self.extent();
        let input = self.egui.take_egui_input(&window);
        let timestamps = graphics.gpu.capabilities.timestamps;
        self.hint = self.hint.take().filter(|(_, until)| *until > now);
        self.read_land(graphics, self.pixels_per_point());
        let mut commands = Vec::new();
        let drawable = self.drawable(graphics);
        let eye = self.scene.camera;
        let mut output = ctx.run_ui(input, |ui| self.interface(ui, &drawable, (&mut commands, timestamps), now));
        if self.scene.camera != eye {
            // Typed coordinates win over a path.
            self.journey.stop();
        }

        if self.pointer.captured {
            output.platform_output.cursor_icon = egui::CursorIcon::None;
        }
        if let (Some(update), true) = (&output.platform_output.accesskit_update, self.status.is_some()) {
            self.widgets = widgets(update);
        }
        self.egui.handle_platform_output_with_event_loop(&window, event_loop, output.platform_output);
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        match delay {
            Some(Duration::ZERO) => self.redraw.invalidate(),
            Some(delay) => {
                if let Some(at) = now.checked_add(delay) {
                    self.redraw.wake_at(at);
                }
            }
            None => {}
        }
        if let Some((_, until)) = &self.hint {
            self.redraw.wake_at(*until);
        }
        let ui = Ui {
            textures: output.textures_delta,
            primitives: ctx.tessellate(output.shapes, output.pixels_per_point),
            pixels_per_point: output.pixels_per_point,
        };
        (ui, commands)
    }

    /// Everything that egui draws; `drawable` is the scene as it is drawn.
    fn interface(
        &mut self,
        ui: &mut egui::Ui,
        drawable: &Scene,
        (commands, timestamps): (&mut Vec<Command>, bool),
        now: Instant,
    ) {
        if self.view.panel {
            let mut panel = panel::Panel {
                scene: &mut self.scene,
                view: &mut self.view,
                speed: &mut self.fly.speed,
                facts: &self.facts,
                tradeoff: &self.tradeoff,
                files: &mut self.files,
                commands,
            };
            panel::show(ui, &mut panel);
        }
        self.view.log.show(ui);
        self.free = ui.available_rect_before_wrap();
        let ctx = ui.ctx().clone();
        let mut boxes = Vec::new();
        if self.view.overlay {
            boxes.push(overlay::statistics(ui, &self.meter.times, self.steps(), &self.facts.ledger, timestamps));
        }
        boxes.extend(legend::show(&ctx, self.free, &self.scene, &self.map, self.errors_against()));
        boxes.extend(self.show_reading(&ctx));
        if self.view.reading.measure {
            self.show_profile(&ctx, commands, now);
        }
        if self.pointer.captured {
            overlay::crosshair(&ctx);
        }
        if self.view.help {
            overlay::help(&ctx, self.free, &self.view.keys, &mut self.view.help);
        }
        welcome::show(&ctx, self.free, &self.view.keys, &mut self.view.welcome);
        commands.extend(self.files_windows(&ctx, now).into_iter().map(Command::Files));
        boxes.extend(self.bottom_line(&ctx, drawable, now));
        let names = [drawable.march.technique, drawable.compare.technique];
        overlay::split(ui, &self.scene, names, self.pointer.splitting, &boxes);
        self.toasts.show(&ctx, now);
        looks::focus_ring(&ctx);
    }

    /// The line at the bottom of the picture, where there is something to say.
    fn bottom_line(&mut self, ctx: &egui::Context, drawable: &Scene, now: Instant) -> Option<egui::Rect> {
        self.says = None;
        let (text, working) = if let Some(text) = self.files.drops.hint() {
            (text, false)
        } else if let Some(progress) = self.loader.progress() {
            (format!("Opening {} … (Esc cancels)", progress.name), true)
        } else if let Some(text) = self.making_in_words(now) {
            (text, true)
        } else if let Some(film) = &self.film {
            (film.in_words(), true)
        } else if !self.prepared {
            ("Preparing the first picture …".to_owned(), true)
        } else if let Some(text) = self.compiling_in_words(drawable) {
            self.compiler.announce();
            (text, true)
        } else if let Some((text, _)) = &self.hint {
            (text.clone(), false)
        } else if let Some((share, _)) =
            self.baking.filter(|(_, since)| now >= *since + BAKE_PATIENCE && !self.sun_moves())
        {
            (format!("Baking the light map: {:.0} %", share * 100.0), true)
        } else {
            let text = self.cones_in_words(drawable)?;
            self.redraw.wake_at(now + CONES_PAUSE);
            (text, true)
        };
        self.says = Some(text.clone());
        Some(overlay::hint(ctx, self.free, &text, working))
    }

    /// Draws on while a light map is under way.
    fn follow_baking(&mut self, graphics: &Graphics, now: Instant) {
        let before = self.baking;
        self.baking = graphics.renderer.baking().map(|share| (share, before.map_or(now, |(_, since)| since)));
        if self.baking.is_some() || before.is_some() {
            // Once more at the end, which takes the line away that tells of it.
            self.redraw.invalidate();
        }
    }

    /// Draws the scene, if the kept picture does not show it.
    fn draw_scene(&mut self, graphics: &mut Graphics, now: Instant) -> Result<(), FrameError> {
        if !self.prepared {
            // The first pipelines take a while on some drivers: say so first, draw in the next frame.
            self.prepared = true;
            self.redraw.invalidate();
            return Ok(());
        }
        // What the panel has just changed may need other pipelines and cones: no frame waits for them.
        let drawable = self.drawable(graphics);
        let visible = visible_part(&drawable);
        if self.drawn.as_ref() == Some(&visible) && self.baking.is_none() {
            return Ok(());
        }
        self.drop_stale_reference(graphics);
        // A screenshot can be made again from its scene: its light map is drawn to the end, whatever it takes.
        if self.wants_screenshot {
            graphics.renderer.set_bake_budget(None);
        }
        let result = graphics.renderer.draw(&drawable, &graphics.target);
        graphics.limit_baking();
        match result {
            Ok(()) => {
                let shows_reference = graphics.renderer.shows_reference();
                if std::mem::replace(&mut self.shows_reference, shows_reference) != shows_reference {
                    // The legend on screen says the other.
                    self.redraw.invalidate();
                }
                self.follow_baking(graphics, now);
                if !self.stands_in(graphics, &drawable) {
                    self.last_good = Some(self.scene.clone());
                }
                self.shown = Some(visible.clone());
                let shown = |name: &str| graphics.renderer.ledger().passes.iter().any(|pass| pass == name);
                (self.occluder_seen, self.motion) = (shown("occluder"), graphics.renderer.motion());
                let subject = Subject::of(&visible, graphics.renderer.ledger(), graphics.target.size());
                self.meter.scene_was_drawn(subject, now);
                self.drawn = Some(visible);
                if self.facts.images.doubts != graphics.renderer.imagery_doubts() {
                    self.facts.images.doubts = graphics.renderer.imagery_doubts().to_vec();
                    self.redraw.invalidate();
                }
                if self.facts.images.were_shown(&drawable) {
                    self.redraw.invalidate();
                }
                if self.measured_before(graphics) {
                    self.redraw.invalidate();
                }
                // A new crater's rim may have risen over the eye.
                self.settle_eye(graphics);
                Ok(())
            }
            Err(RenderError::DeviceLost(lost)) => Err(FrameError::Lost(lost)),
            Err(error) => {
                self.baking = None;
                self.toasts.error(&error.to_string());
                self.redraw.invalidate();
                if let RenderError::Image { path, reason } = &error {
                    self.facts.images.refused = Some((path.clone(), reason.clone()));
                }
                if put_back(&mut self.scene, self.last_good.as_ref(), &error) {
                    return Ok(());
                }
                if self.last_good.is_none() {
                    let plain = plainest(&self.scene);
                    if self.scene == plain || graphics.renderer.ledger().scene_frames == 0 {
                        return Err(FrameError::Fatal(error.into()));
                    }
                    // A new map that cannot be drawn with the settings of the last one is drawn without them.
                    self.scene = plain;
                    return Ok(());
                }
                // Nothing to put back: the picture stays until something changes.
                self.drawn = Some(visible);
                Ok(())
            }
        }
    }
}

/// What any map can be drawn with: all settings as they are in the beginning, but for the eye, the terrain and its craters.
fn plainest(scene: &Scene) -> Scene {
    let mut plain = Scene { camera: scene.camera, terrain: scene.terrain.clone(), ..Scene::default() };
    plain.craters.list.clone_from(&scene.craters.list);
    plain
}

/// Takes back what made a scene impossible to draw: the image that cannot be used, or else everything but the camera
/// since the last good picture. False when that changes nothing.
pub(super) fn put_back(scene: &mut Scene, good: Option<&Scene>, error: &RenderError) -> bool {
    let before = scene.clone();
    if let RenderError::Image { path, .. } = error {
        let is_diffuse = scene.diffuse.file.as_ref() == Some(path);
        let is_sky = scene.skybox.faces.as_ref().is_some_and(|faces| faces.contains(path));
        let is_imagery = scene.land.imagery.as_ref() == Some(path);
        let is_coverage = scene.materials.coverage.contains(path);
        let unknown = !is_diffuse && !is_sky && !is_imagery && !is_coverage;
        if is_imagery {
            let file = good.and_then(|good| good.land.imagery.clone());
            scene.land.imagery = file.filter(|file| Some(file) != before.land.imagery.as_ref());
        }
        if is_diffuse || unknown {
            let file = good.and_then(|good| good.diffuse.file.clone());
            scene.diffuse.file = file.filter(|file| Some(file) != before.diffuse.file.as_ref());
        }
        if is_coverage || unknown {
            let maps = good.map(|good| good.materials.coverage.clone()).unwrap_or_default();
            scene.materials.coverage = if maps == before.materials.coverage { Vec::new() } else { maps };
        }
        if is_sky || unknown {
            let faces = good.and_then(|good| good.skybox.faces.clone());
            scene.skybox.faces = faces.filter(|faces| Some(faces) != before.skybox.faces.as_ref());
        }
    } else if let Some(good) = good {
        *scene = Scene { camera: scene.camera, ..good.clone() };
    }
    *scene != before
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::scene::Technique;

    fn image_error(path: &str) -> RenderError {
        RenderError::Image { path: path.into(), reason: "it is not an image".into() }
    }

    /// A wrong path must cost the user nothing but that path.
    #[test]
    fn an_unusable_image_is_put_back_and_nothing_else() {
        let mut good = Scene::default();
        good.diffuse.file = Some("good.png".into());
        let mut scene = good.clone();
        scene.diffuse.file = Some("bad.png".into());
        scene.march.technique = Technique::Linear;
        scene.skybox.faces = Some(["a", "b", "c", "d", "e", "f"].map(PathBuf::from));
        assert!(put_back(&mut scene, Some(&good), &image_error("bad.png")));
        assert_eq!(scene.diffuse, good.diffuse);
        assert!(scene.skybox.faces.is_some() && scene.march.technique == Technique::Linear);
        assert!(put_back(&mut scene, Some(&good), &image_error("c")));
        assert_eq!(scene.skybox.faces, None);
        scene.materials.coverage = vec!["a.png".into(), "b.png".into()];
        assert!(put_back(&mut scene, Some(&good), &image_error("b.png")));
        assert_eq!((scene.materials.coverage.len(), &scene.diffuse), (0, &good.diffuse));
        // The good image has been deleted meanwhile: the generated texture is left, and no endless loop.
        assert!(put_back(&mut scene, Some(&good), &image_error("good.png")));
        assert_eq!(scene.diffuse.file, None);
    }

    #[test]
    fn other_failures_return_to_the_last_good_scene_and_keep_the_eye() {
        let good = Scene::default();
        let mut scene = good.clone();
        scene.march.technique = Technique::Linear;
        let eye = crate::camera::Camera { eye: glam::DVec3::ONE, yaw: 1.0, pitch: 2.0, fov: 50.0 };
        scene.camera = Some(eye);
        let error = RenderError::TerrainTooLarge { width: 9, height: 9, limit: 8 };
        assert!(put_back(&mut scene, Some(&good), &error));
        assert_eq!((scene.march.technique, scene.camera), (Technique::default(), Some(eye)));
        assert!(!put_back(&mut scene, Some(&good), &error), "there is nothing more to put back");
        assert!(!put_back(&mut Scene::default(), None, &error));
    }
}
