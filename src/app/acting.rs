//! What keys make the viewer do: the actions of the table, Esc, and choosing another key.

use std::time::Instant;

use winit::keyboard::KeyCode;

use super::actions::Action;
use super::files::FilesCommand;
use super::generating::MakeCommand;
use super::graphics::Graphics;
use super::keys::Press;
use super::preferences::ZOOMS;
use super::settings::{Command, PathCommand};
use super::viewer::Viewer;
use crate::camera::NamedView;

impl Viewer {
    /// Gives the action that waits for it its new key.
    pub(super) fn rebind(&mut self, press: Press) {
        const MODIFIERS: [KeyCode; 8] = [
            KeyCode::ControlLeft,
            KeyCode::ControlRight,
            KeyCode::ShiftLeft,
            KeyCode::ShiftRight,
            KeyCode::AltLeft,
            KeyCode::AltRight,
            KeyCode::SuperLeft,
            KeyCode::SuperRight,
        ];
        let Some(action) = self.view.rebinding.filter(|_| !MODIFIERS.contains(&press.key)) else { return };
        self.redraw.invalidate();
        (self.view.rebinding, self.view.refused) = (None, None);
        if press.key == KeyCode::Escape {
            return;
        }
        let plain_backspace = press.key == KeyCode::Backspace && !press.ctrl && !press.shift;
        let chord = (!plain_backspace).then(|| press.chord());
        if let Err(error) = self.view.keys.bind(action, chord) {
            self.toasts.error(&error.to_string());
            self.view.refused = Some((action, error.to_string()));
        }
    }

    /// What Esc does: the first of these that there is something to do for.
    pub(super) fn escape(&mut self, graphics: &Graphics, now: Instant) {
        self.redraw.invalidate();
        if self.pointer.captured {
            self.capture(false);
        } else if self.files.asks() {
            // The window of files closes itself.
        } else if self.view.welcome {
            self.view.welcome = false;
        } else if self.view.reading.measure {
            self.view.reading.set_measure(false);
        } else if self.view.help {
            self.view.help = false;
        } else if self.journey.stop() {
            // It stays where it is.
        } else if self.film.is_some() {
            self.cancel_export(now);
        } else if self.loader.is_busy() {
            self.cancel_opening();
        } else if self.cancel_making(now) {
            // What is on screen stays.
        } else if self.tradeoff.progress().is_some() {
            self.forget_tradeoff();
        } else if self.give_up_cones(graphics) {
            // What has drawn meanwhile goes on.
        } else {
            self.toasts.dismiss_errors();
        }
    }

    pub(super) fn act(&mut self, graphics: &mut Graphics, action: Action, now: Instant) {
        self.redraw.invalidate();
        if action != Action::PlayPath {
            self.journey.stop();
        }
        let zoomed = |zoom: f32, by: f32| ((zoom + by) * 10.0).round() / 10.0;
        match action {
            Action::Capture => self.capture(!self.pointer.captured),
            Action::FrameTerrain => self.execute(graphics, Command::View(NamedView::Start)),
            Action::Orbit => self.toggle_mode(now),
            Action::KeyFrame => self.path_command(graphics, PathCommand::Add, now),
            Action::RemoveKeyFrame => self.path_command(graphics, PathCommand::RemoveLast, now),
            Action::PlayPath => self.path_command(graphics, PathCommand::Play, now),
            Action::Shadows => {
                let lighting = &mut self.scene.lighting;
                lighting.shadows = lighting.shadows.next();
                let name = lighting.shadows.name();
                self.show_hint(format!("Shadows: {name}"), now);
            }
            Action::Water => {
                let water = &mut self.scene.water;
                water.enabled = !water.enabled;
                let state = if water.enabled { "on" } else { "off" };
                self.show_hint(format!("Water: {state}"), now);
            }
            Action::Air | Action::Fog | Action::Clouds | Action::CloudsMove | Action::Flare => {
                self.act_on_air(action, now);
            }
            Action::ExaggerateLess => self.step_exaggeration(graphics, false, now),
            Action::ExaggerateMore => self.step_exaggeration(graphics, true, now),
            Action::Probe => self.view.reading.probe = !self.view.reading.probe,
            Action::Measure => self.execute(graphics, Command::Measure(!self.view.reading.measure)),
            Action::Crater => self.crater(graphics, now),
            Action::UndoCrater => self.execute(graphics, Command::UndoCrater),
            Action::ClearCraters => self.execute(graphics, Command::ClearCraters),
            Action::Help => self.view.help = !self.view.help,
            Action::Panel => self.view.panel = !self.view.panel,
            Action::Overlay => self.view.overlay = !self.view.overlay,
            Action::Log => self.view.log.open = !self.view.log.open,
            Action::FocusPanel => self.focus_panel(),
            Action::ZoomIn => self.zoom_to(zoomed(self.view.zoom, 0.1), now),
            Action::ZoomOut => self.zoom_to(zoomed(self.view.zoom, -0.1), now),
            Action::ZoomReset => self.zoom_to(1.0, now),
            Action::Open => self.files_command(FilesCommand::Choose),
            Action::SaveMap => self.files_command(FilesCommand::AskToSave),
            Action::NextMap => self.files_command(FilesCommand::Step(1)),
            Action::PreviousMap => self.files_command(FilesCommand::Step(-1)),
            Action::NextSeed => self.make_command(MakeCommand::NextSeed, now),
            Action::FullScreen => self.execute(graphics, Command::FullScreen),
            Action::Screenshot => self.execute(graphics, Command::Screenshot),
            Action::Quit => self.quit = true,
            // These are held: `key` has seen to them.
            Action::Forward | Action::Back | Action::Left | Action::Right | Action::Up | Action::Down => {}
        }
    }

    /// Flips a part of the air, and says what is now.
    fn act_on_air(&mut self, action: Action, now: Instant) {
        let (air, clouds) = (&mut self.scene.air, &mut self.scene.clouds);
        let word = |on: bool| if on { "on" } else { "off" };
        let says = match action {
            Action::Air => {
                air.perspective = !air.perspective;
                format!("Aerial perspective: {}", word(air.perspective))
            }
            Action::Fog => {
                air.fog = !air.fog;
                format!("Fog: {}", word(air.fog))
            }
            Action::Clouds => {
                (clouds.enabled, clouds.shadows) = match (clouds.enabled, clouds.shadows) {
                    (false, _) => (true, false),
                    (true, false) => (true, true),
                    (true, true) => (false, false),
                };
                let shadows = if clouds.shadows { " with shadows" } else { "" };
                format!("Clouds: {}{shadows}", word(clouds.enabled))
            }
            Action::CloudsMove => {
                clouds.moving = !clouds.moving;
                format!("Clouds {}", if clouds.moving { "move" } else { "stand still" })
            }
            _ => {
                let flare = &mut self.scene.flare;
                flare.enabled = !flare.enabled;
                format!("Lens flare: {}", word(flare.enabled))
            }
        };
        self.show_hint(says, now);
    }

    fn zoom_to(&mut self, zoom: f32, now: Instant) {
        self.view.zoom = zoom.clamp(*ZOOMS.start(), *ZOOMS.end());
        self.show_hint(format!("Panel and text at {:.0} %", self.view.zoom * 100.0), now);
    }

    /// Gives the keyboard to the panel's first control, or back to flying.
    fn focus_panel(&mut self) {
        let focused = self.egui.egui_ctx().memory(egui::Memory::focused);
        if let Some(id) = focused {
            self.egui.egui_ctx().memory_mut(|memory| memory.surrender_focus(id));
            return;
        }
        self.view.panel = true;
        self.fly.release_all();
        let events = &mut self.egui.egui_input_mut().events;
        for pressed in [true, false] {
            let (key, modifiers) = (egui::Key::Tab, egui::Modifiers::NONE);
            events.push(egui::Event::Key { key, physical_key: None, pressed, repeat: false, modifiers });
        }
    }

    /// Destroys the GPU device, to try what a driver's reset would do. Debug builds only.
    pub(super) fn lose_device(&mut self, graphics: &Graphics) {
        self.drawn = None;
        self.redraw.invalidate();
        graphics.gpu.device.destroy();
    }
}
