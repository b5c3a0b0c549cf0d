//! Keys, mouse and dropped files.

use std::time::{Duration, Instant};

use glam::DVec2;
use winit::dpi::PhysicalPosition;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};
use winit::window::CursorGrabMode;

use super::controls::{Direction, look};
use super::graphics::Graphics;
use super::keys::{self, Press};
use super::preferences::Mode;
use super::settings::Command;
use super::viewer::Viewer;
use super::{overlay, picking};

/// How long a hint stays.
const HINT_TIME: Duration = Duration::from_millis(1400);

/// How long it stays where it has to say why nothing happened.
const REFUSAL_TIME: Duration = Duration::from_secs(4);

/// Pixels of a touchpad that count as one notch of a wheel.
const PIXELS_PER_NOTCH: f64 = 40.0;

impl Viewer {
    /// Handles an event of the window, first by egui.
    pub(crate) fn window_event(&mut self, graphics: &mut Graphics, event: &WindowEvent, now: Instant) {
        let of_mouse = matches!(
            event,
            WindowEvent::CursorMoved { .. } | WindowEvent::MouseInput { .. } | WindowEvent::MouseWheel { .. }
        );
        let repaint = if (self.pointer.captured && of_mouse) || self.is_ours(event) {
            false
        } else {
            let window = self.window.clone();
            self.egui.on_window_event(&window, event).repaint
        };
        if !matches!(event, WindowEvent::CursorMoved { .. }) && repaint {
            self.redraw.invalidate();
        }
        match event {
            // What was drawn last may be lost meanwhile: it is shown again.
            WindowEvent::Occluded(false) => {
                (self.covered, self.hidden, self.minimised_until) = (false, false, None);
                self.redraw.invalidate();
            }
            WindowEvent::Occluded(true) => self.covered = true,
            WindowEvent::Resized(_) => {
                (self.hidden, self.minimised_until) = (false, None);
                self.keeper.window_moved();
            }
            WindowEvent::Moved(_) => self.keeper.window_moved(),
            WindowEvent::Focused(true) => self.minimised_until = None,
            WindowEvent::ScaleFactorChanged { scale_factor, inner_size_writer } => {
                self.hidden = false;
                if !self.scale.tell(*scale_factor, self.window.scale_factor()) {
                    // The window has its new size already. Fails only where the window system takes no wishes.
                    let _ = inner_size_writer.clone().request_inner_size(self.window.inner_size());
                }
            }
            WindowEvent::Focused(false) => {
                self.fly.release_all();
                (self.pointer.dragging, self.pointer.splitting, self.pointer.orbiting) = (false, false, None);
                self.capture(false);
            }
            WindowEvent::ModifiersChanged(modifiers) => {
                self.pointer.modifiers = modifiers.state();
                self.fly.set_modifiers(modifiers.state().shift_key(), modifiers.state().alt_key());
            }
            WindowEvent::KeyboardInput { event, is_synthetic, .. } => self.key(graphics, event, *is_synthetic, now),
            WindowEvent::CursorMoved { position, .. } => self.cursor_moved(graphics, *position),
            WindowEvent::CursorLeft { .. } if !self.pointer.is_dragging() => {
                (self.pointer.cursor, self.pointer.over_egui) = (None, false);
            }
            WindowEvent::MouseInput { state, button, .. } => self.mouse_button(graphics, *state, *button, now),
            WindowEvent::MouseWheel { delta, .. } if self.pointer.captured || self.cursor_is_free() => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / PIXELS_PER_NOTCH,
                };
                self.journey.stop();
                if self.view.mode == Mode::Orbit {
                    self.approach(graphics, notches);
                    return;
                }
                self.fly.scroll(notches);
                self.show_hint(format!("Speed {:.3} map widths per second", self.fly.speed), now);
            }
            event => {
                self.drag_event(event);
            }
        }
    }

    /// The mouse moved, wherever its cursor is.
    pub(crate) fn mouse_motion(&mut self, moved: DVec2) {
        if self.pointer.captured {
            self.turn(moved);
        }
    }

    /// Shows a line of text over the picture for a moment.
    pub(super) fn show_hint(&mut self, text: String, now: Instant) {
        self.hint = Some((text, now + HINT_TIME));
        self.redraw.invalidate();
    }

    /// Says why a key did nothing, or what it has done that takes a while to read.
    pub(super) fn refuse(&mut self, text: String, now: Instant) {
        self.hint = Some((text, now + REFUSAL_TIME));
        self.redraw.invalidate();
    }

    fn turn(&mut self, moved: DVec2) {
        let mut camera = self.camera();
        look(&mut camera, moved);
        self.scene.camera = Some(camera);
        self.redraw.invalidate();
    }

    fn cursor_moved(&mut self, graphics: &Graphics, position: PhysicalPosition<f64>) {
        if self.pointer.captured {
            return;
        }
        let cursor = DVec2::new(position.x, position.y);
        let before = self.pointer.cursor.replace(cursor);
        if self.pointer.orbiting.is_some() {
            self.turn_around(graphics, cursor - before.unwrap_or(cursor));
            return;
        }
        if self.pointer.dragging {
            self.turn(cursor - before.unwrap_or(cursor));
            return;
        }
        if self.pointer.splitting {
            let width = f64::from(self.window.inner_size().width).max(1.0);
            // Under the panel the line could not be seen, nor taken hold of again.
            let free = [self.free.left(), self.free.right()].map(|side| f64::from(side) * self.pixels_per_point());
            self.scene.compare.share = (cursor.x.max(free[0]).min(free[1]) / width).clamp(0.0, 1.0);
            self.redraw.invalidate();
            return;
        }
        // Over the picture nothing but the split line lights up under the cursor, so nothing else needs to be drawn.
        let over_egui = !self.cursor_is_free() || self.is_on_split_line(cursor);
        let follows = self.view.reading.follows_cursor();
        if follows || over_egui || std::mem::replace(&mut self.pointer.over_egui, over_egui) {
            self.redraw.invalidate();
        }
        self.pointer.over_egui = over_egui;
    }

    /// Whether the cursor is over the picture and not over the panel, a window of egui, or a drag that began there.
    pub(super) fn cursor_is_free(&self) -> bool {
        let Some(cursor) = self.pointer.cursor else { return false };
        let (ctx, scale) = (self.egui.egui_ctx(), self.pixels_per_point());
        let position = egui::pos2((cursor.x / scale) as f32, (cursor.y / scale) as f32);
        let covered = ctx.layer_id_at(position).is_some_and(|layer| layer.order != egui::Order::Background);
        self.free.contains(position) && !covered && !ctx.egui_is_using_pointer()
    }

    /// Whether a place of the window, physical pixels, is where the split line can be taken hold of.
    fn is_on_split_line(&self, cursor: DVec2) -> bool {
        let line = self.scene.compare.share * f64::from(self.window.inner_size().width);
        let reach = f64::from(overlay::SPLIT_REACH) * self.pixels_per_point();
        overlay::is_split(&self.scene) && (cursor.x - line).abs() <= reach
    }

    /// Physical pixels of the window per point of egui.
    pub(super) fn pixels_per_point(&self) -> f64 {
        f64::from(egui_winit::pixels_per_point(self.egui.egui_ctx(), &self.window))
    }

    fn mouse_button(&mut self, graphics: &Graphics, state: ElementState, button: MouseButton, now: Instant) {
        if state == ElementState::Released {
            self.pointer.dragging &= button != MouseButton::Right;
            self.pointer.splitting &= button != MouseButton::Left;
            if matches!(button, MouseButton::Left | MouseButton::Right) {
                self.pointer.orbiting = None;
            }
        } else if !self.pointer.captured && self.cursor_is_free() {
            self.journey.stop();
            let on_line = self.pointer.cursor.is_some_and(|cursor| self.is_on_split_line(cursor));
            let turns = button == MouseButton::Right || (button == MouseButton::Left && !on_line);
            self.pointer.splitting |= button == MouseButton::Left && on_line;
            if button == MouseButton::Left && !on_line && self.view.reading.measure {
                self.view.reading.clicked = self.pointer.cursor;
                self.redraw.invalidate();
            }
            match self.view.mode {
                Mode::Fly => self.pointer.dragging |= button == MouseButton::Right,
                Mode::Orbit if turns && !(button == MouseButton::Left && self.view.reading.measure) => {
                    let pivot = self.terrain(graphics).pivot(&self.camera(), graphics.target.size());
                    self.pointer.orbiting = Some(pivot);
                }
                Mode::Orbit => {}
            }
            // A click on the picture ends typing in the panel.
            self.egui.egui_ctx().memory_mut(|memory| {
                if let Some(id) = memory.focused() {
                    memory.surrender_focus(id);
                }
            });
            if let Some(cursor) =
                self.pointer.cursor.filter(|_| button == MouseButton::Left && !on_line && !self.view.reading.measure)
            {
                self.clicked(graphics, cursor, now);
            }
        }
    }

    /// A key with its modifiers.
    fn press(&self, event: &KeyEvent) -> Option<Press> {
        let PhysicalKey::Code(key) = event.physical_key else { return None };
        let letter = match &event.logical_key {
            Key::Character(text) => text.chars().next(),
            _ => None,
        };
        let modifiers = self.pointer.modifiers;
        let [ctrl, shift, alt] = [modifiers.control_key(), modifiers.shift_key(), modifiers.alt_key()];
        Some(Press { key, letter, ctrl, shift, alt })
    }

    /// Whether a key is ours alone: the one that is being chosen for an action, or one that would set egui's focus going
    /// while the keyboard flies.
    fn is_ours(&self, event: &WindowEvent) -> bool {
        let WindowEvent::KeyboardInput { event, .. } = event else { return false };
        let pressed = event.state == ElementState::Pressed;
        let typing = self.egui.egui_ctx().egui_wants_keyboard_input();
        let walks = event.logical_key == Key::Named(NamedKey::Tab) && !typing;
        let bound = self.press(event).is_some_and(|press| self.view.keys.action(press).is_some());
        pressed && (self.view.rebinding.is_some() || (walks && bound))
    }

    fn key(&mut self, graphics: &mut Graphics, event: &KeyEvent, synthetic: bool, now: Instant) {
        let Some(press) = self.press(event) else { return };
        if event.state == ElementState::Released {
            let held: Vec<Direction> = self.view.keys.held(press.key).filter_map(Direction::of).collect();
            held.into_iter().for_each(|direction| self.fly.release(direction, now));
            return;
        }
        if event.repeat || synthetic {
            return;
        }
        if self.view.keys.learn(press) {
            self.redraw.invalidate();
        }
        if self.view.rebinding.is_some() {
            self.rebind(press);
            return;
        }
        let typing = self.egui.egui_ctx().egui_wants_keyboard_input();
        if press.key == KeyCode::Escape {
            if !typing {
                self.escape(graphics, now);
            }
            return;
        }
        if let Some(digit) = keys::bookmark_of(press.chord().key).filter(|_| !typing) {
            let command = if press.ctrl { Command::SetBookmark(digit) } else { Command::GoToBookmark(digit) };
            self.execute(graphics, command);
            return;
        }
        if cfg!(debug_assertions) && press.ctrl && press.shift {
            match press.key {
                KeyCode::F9 => return self.lose_device(graphics),
                KeyCode::F10 => return graphics.lose_surface(),
                _ => {}
            }
        }
        let Some(action) = self.view.keys.action(press) else { return };
        let types_nothing = action.entry().while_typing && press.chord().types_nothing();
        if typing && !types_nothing {
            return;
        }
        match Direction::of(action) {
            Some(_) if self.pointer.modifiers.super_key() => {}
            Some(direction) => {
                self.journey.stop();
                self.fly.press(direction, now);
            }
            None => self.act(graphics, action, now),
        }
    }

    /// Makes a crater under the cursor, or under the crosshair while the mouse is captured.
    pub(super) fn crater(&mut self, graphics: &Graphics, now: Instant) {
        let picture = graphics.target.size();
        let centre = DVec2::new(f64::from(picture[0]), f64::from(picture[1])) * 0.5;
        let pixel = match self.pointer.cursor {
            _ if self.pointer.captured => centre,
            Some(cursor) if self.cursor_is_free() => cursor,
            _ => {
                self.refuse("No crater: the cursor is not over the picture. Point at the ground.".into(), now);
                return;
            }
        };
        let map = graphics.renderer.terrain().map_or(&*self.map, |terrain| terrain.field());
        match picking::ground_at(map, self.extent(), &self.camera(), pixel, picture) {
            Ok(position) => picking::add_crater(&mut self.scene.craters, position),
            Err(error) => self.refuse(error.to_string(), now),
        }
    }

    /// Captures the mouse to look around, or releases it.
    pub(super) fn capture(&mut self, on: bool) {
        if on == self.pointer.captured {
            return;
        }
        if on {
            // Not every window system can lock the cursor in place; all can keep it inside the window.
            let lock = |mode| self.window.set_cursor_grab(mode);
            let grabbed = lock(CursorGrabMode::Locked).or_else(|_| lock(CursorGrabMode::Confined));
            if let Err(error) = grabbed {
                self.toasts.error(&format!("The mouse cannot be captured: {error}. Look around by dragging instead."));
                return;
            }
            (self.pointer.dragging, self.pointer.orbiting) = (false, None);
            self.egui.egui_input_mut().events.push(egui::Event::PointerGone);
        } else {
            // Both fail only where capturing has failed before.
            let _ = self.window.set_cursor_grab(CursorGrabMode::None);
            let size = self.window.inner_size();
            let _ = self.window.set_cursor_position(PhysicalPosition::new(size.width / 2, size.height / 2));
        }
        self.window.set_cursor_visible(!on);
        self.pointer.captured = on;
        self.redraw.invalidate();
    }
}
