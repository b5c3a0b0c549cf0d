//! A gamepad's sticks as movements of the eye. The mapping knows no gamepad; only the feature `gamepad` brings one.

use glam::{DVec2, DVec3};

use crate::camera::{Camera, MAX_PITCH};

/// Sticks rest within this share of their way; nobody's stick rests at 0.
const DEAD: f64 = 0.15;

/// Degrees per second of a stick pushed all the way, at a field of view of 60°.
const TURN: f64 = 110.0;

/// What the sticks and triggers are at: −1 to 1, right and up positive; triggers 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sticks {
    /// The left stick moves.
    pub(crate) left: DVec2,
    /// The right stick looks.
    pub(crate) right: DVec2,
    /// The right trigger rises, the left one sinks.
    pub(crate) triggers: [f64; 2],
}

/// What they ask for: shares of the speed to the right, up and forward, and degrees per second to the right and up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Push {
    pub(crate) way: DVec3,
    pub(crate) turn: DVec2,
}

impl Push {
    /// Whether anything is asked for.
    pub(crate) fn is_any(&self) -> bool {
        *self != Self::default()
    }

    /// The camera after `seconds` of it, at `velocity` world units per second.
    pub(crate) fn apply(&self, camera: &Camera, velocity: f64, seconds: f64) -> Camera {
        let basis = camera.basis();
        let way = basis.right * self.way.x + DVec3::Y * self.way.y + basis.forward * self.way.z;
        let turn = self.turn * (seconds * camera.fov / Camera::DEFAULT_FOV);
        Camera {
            eye: camera.eye + way.clamp_length_max(1.0) * velocity * seconds,
            yaw: (camera.yaw + turn.x).rem_euclid(360.0),
            pitch: (camera.pitch + turn.y).clamp(-MAX_PITCH, MAX_PITCH),
            ..*camera
        }
    }
}

/// What sticks ask for: nothing within the dead zone, and from its border on ever more, finely at first.
pub(crate) fn push(sticks: Sticks) -> Push {
    let [left, right] = [sticks.left, sticks.right].map(|stick| shaped(stick.length()) * stick.normalize_or_zero());
    let rise = shaped(sticks.triggers[1]) - shaped(sticks.triggers[0]);
    Push { way: DVec3::new(left.x, rise, left.y), turn: right * TURN }
}

/// A push of 0 to 1 with the dead zone taken off, squared.
fn shaped(length: f64) -> f64 {
    let beyond = ((length - DEAD) / (1.0 - DEAD)).clamp(0.0, 1.0);
    if beyond.is_finite() { beyond * beyond } else { 0.0 }
}

#[cfg(feature = "gamepad")]
mod plugged {
    use std::time::{Duration, Instant};

    use gilrs::{Axis, Button, Gilrs};
    use glam::DVec2;

    use super::{Push, Sticks, push};
    use crate::app::controls;
    use crate::app::graphics::Graphics;
    use crate::app::redraw::Next;
    use crate::app::viewer::Viewer;

    /// How often sticks are looked at, and how often it is looked whether there are any.
    const PAUSES: [Duration; 2] = [Duration::from_millis(16), Duration::from_secs(1)];

    /// A stall must not throw the eye across the map.
    const LONGEST_STEP: Duration = Duration::from_millis(250);

    /// The gamepads that are plugged in.
    pub(crate) struct Gamepads {
        /// Absent where the system has no means for them.
        gilrs: Option<Gilrs>,
        push: Push,
        looked: Option<Instant>,
        moved: Option<Instant>,
    }

    impl Default for Gamepads {
        fn default() -> Self {
            let gilrs = Gilrs::new().map_err(|error| log::warn!("gamepads cannot be used: {error}")).ok();
            Self { gilrs, push: Push::default(), looked: None, moved: None }
        }
    }

    impl Gamepads {
        fn pause(&self) -> Duration {
            let any = self.gilrs.as_ref().is_some_and(|gilrs| gilrs.gamepads().next().is_some());
            PAUSES[usize::from(!any)]
        }

        /// When they have to be looked at.
        pub(crate) fn next(&self, now: Instant) -> Next {
            match &self.gilrs {
                Some(_) => Next::At(self.looked.map_or(now, |looked| looked + self.pause())),
                None => Next::Never,
            }
        }

        /// Looks at all of them. Whether they ask for anything.
        pub(crate) fn look(&mut self, now: Instant) -> bool {
            self.looked = Some(now);
            let Some(gilrs) = &mut self.gilrs else { return false };
            while gilrs.next_event().is_some() {}
            self.push = gilrs.gamepads().fold(Push::default(), |sum, (_, pad)| {
                let stick = |x: Axis, y: Axis| DVec2::new(f64::from(pad.value(x)), f64::from(pad.value(y)));
                let trigger = |button: Button| pad.button_data(button).map_or(0.0, |data| f64::from(data.value()));
                let one = push(Sticks {
                    left: stick(Axis::LeftStickX, Axis::LeftStickY),
                    right: stick(Axis::RightStickX, Axis::RightStickY),
                    triggers: [trigger(Button::LeftTrigger2), trigger(Button::RightTrigger2)],
                });
                Push { way: sum.way + one.way, turn: sum.turn + one.turn }
            });
            if !self.push.is_any() {
                self.moved = None;
            }
            self.push.is_any()
        }
    }

    impl Viewer {
        /// Moves the eye by what the sticks ask for.
        pub(crate) fn advance_by_gamepad(&mut self, graphics: &Graphics, now: Instant) {
            if !self.gamepads.push.is_any() {
                return;
            }
            let since = self.gamepads.moved.replace(now).unwrap_or(now);
            let passed = now.saturating_duration_since(since).min(LONGEST_STEP);
            let camera = self.camera();
            let height = controls::height_above_ground(self.ground(graphics), self.extent(), camera.eye);
            let push = self.gamepads.push;
            self.scene.camera = Some(push.apply(&camera, self.fly.velocity(height), passed.as_secs_f64()));
        }
    }
}
#[cfg(feature = "gamepad")]
pub(crate) use plugged::Gamepads;

#[cfg(test)]
mod tests {
    use super::*;

    const NORTH: Camera = Camera { eye: DVec3::new(0.5, 1.0, 0.5), yaw: 0.0, pitch: 0.0, fov: 60.0 };

    #[test]
    fn resting_sticks_move_nothing_and_pushed_ones_go_where_they_point() {
        let resting = Sticks { left: DVec2::new(0.1, -0.1), right: DVec2::splat(f64::NAN), triggers: [0.05, f64::NAN] };
        assert!(!push(resting).is_any());
        let after = |sticks| push(sticks).apply(&NORTH, 0.3, 2.0);
        let forward = after(Sticks { left: DVec2::Y, ..Sticks::default() });
        assert!((forward.eye - DVec3::new(0.5, 1.0, -0.1)).length() < 1e-12, "{forward:?}");
        let diagonal = after(Sticks { left: DVec2::new(1.0, 1.0), triggers: [0.0, 1.0], ..Sticks::default() });
        assert!((diagonal.eye - NORTH.eye).length() < 0.6 + 1e-12, "no faster than straight on");
        let look = after(Sticks { right: DVec2::new(1.0, 0.0), ..Sticks::default() });
        assert!((look.yaw - 220.0).abs() < 1e-9 && look.eye == NORTH.eye);
        let sink = after(Sticks { triggers: [1.0, 0.0], ..Sticks::default() });
        assert!(sink.eye.y < 1.0 && after(Sticks { right: DVec2::Y * 9.0, ..Sticks::default() }).pitch == MAX_PITCH);
        assert!(shaped(0.5) < 0.25, "fine near the middle");
    }
}
