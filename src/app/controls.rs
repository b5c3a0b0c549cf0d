//! The fly camera: which keys move the eye, how far, and where the eye may not go. Knows no window.

use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use winit::keyboard::KeyCode;

use crate::camera::{Camera, MAX_PITCH};
use crate::heightfield::HeightField;

/// Slowest and fastest base speed that the wheel reaches, in map widths per second.
pub(crate) const SPEED_RANGE: std::ops::RangeInclusive<f64> = 0.005..=20.0;

/// Base speed at the start, in map widths per second.
pub(crate) const DEFAULT_SPEED: f64 = 0.3;

/// The least distance between the eye and the ground below it, world units.
pub(crate) const CLEARANCE: f64 = 0.0015;

/// Height above ground at which the eye moves at exactly its base speed, world units.
const REFERENCE_HEIGHT: f64 = 0.25;

/// How far height above ground may slow the eye down or speed it up.
const HEIGHT_FACTORS: [f64; 2] = [0.08, 4.0];

/// One notch of the wheel multiplies the base speed by this.
const WHEEL_FACTOR: f64 = 1.2;

/// A look turns by this share of the vertical field of view per pixel of the mouse.
const TURN_PER_PIXEL: f64 = 0.0018;

/// A key held while the program was busy must not throw the eye across the map.
const LONGEST_STEP: Duration = Duration::from_millis(250);

/// What the help page lists: keys, and what they do.
pub(crate) const BINDINGS: [(&str, &str); 25] = [
    ("W A S D", "fly forward, left, back, right"),
    ("E / Q", "fly up / down"),
    ("Shift / Alt", "four times as fast / a quarter as fast"),
    ("Wheel", "base speed"),
    ("Right drag", "look around"),
    ("Drag the split line", "how much of the picture each of two compared techniques draws"),
    ("F", "capture the mouse to look around; Esc releases it"),
    ("Home", "frame the terrain (start view)"),
    ("C", "make a crater under the cursor, or under the crosshair while the mouse is captured"),
    ("Ctrl+Z", "take the last crater back"),
    ("Ctrl+Shift+Backspace", "take all craters back"),
    ("F1", "this help"),
    ("F2", "panel"),
    ("F3", "overlay: frame times, steps, ledger"),
    ("F11", "full screen"),
    ("F12", "screenshot: a PNG, and the scene beside it as TOML"),
    ("Esc", "release the mouse; close this help; end opening a map; dismiss messages"),
    ("Ctrl+O", "open maps"),
    ("Ctrl+Tab, Ctrl+Shift+Tab", "the next, the previous of the open maps"),
    ("Ctrl+S", "save the edited map: GeoTIFF, 16-bit PNG, raw and others"),
    ("Ctrl+Q", "quit"),
    ("Tab", "walk through the panel's controls"),
    ("Ctrl + / −", "larger or smaller panel"),
    ("Drop files", "open them; the first becomes the terrain"),
    ("Click the picture", "give the keys back to flying after typing in the panel"),
];

/// A direction the eye can be moved in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Forward,
    Back,
    Left,
    Right,
    Up,
    Down,
}

impl Direction {
    const COUNT: usize = 6;

    /// The direction of a physical key, whatever the keyboard's layout prints on it.
    pub(crate) fn from_key(key: KeyCode) -> Option<Self> {
        Some(match key {
            KeyCode::KeyW => Self::Forward,
            KeyCode::KeyS => Self::Back,
            KeyCode::KeyA => Self::Left,
            KeyCode::KeyD => Self::Right,
            KeyCode::KeyE => Self::Up,
            KeyCode::KeyQ => Self::Down,
            _ => return None,
        })
    }
}

/// What a key does once, when it goes down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shortcut {
    Capture,
    Escape,
    FrameTerrain,
    Crater,
    UndoCrater,
    ClearCraters,
    Help,
    Panel,
    Overlay,
    FullScreen,
    Screenshot,
    Open,
    SaveMap,
    NextMap,
    PreviousMap,
    Quit,
    /// Destroys the GPU device, to try what a driver's reset would do. Debug builds only.
    LoseDevice,
    /// Loses the window's surface, to try what a window system may do. Debug builds only.
    LoseSurface,
}

impl Shortcut {
    /// The shortcut of a physical key with the modifiers that are down. `letter` is what the layout prints on the key:
    /// undo and quit follow the printed letter where there is one, because that is where every other program has them.
    pub(crate) fn from_key(key: KeyCode, letter: Option<char>, ctrl: bool, shift: bool) -> Option<Self> {
        if ctrl {
            let is = |wanted: char, position: KeyCode| match letter.filter(char::is_ascii_alphabetic) {
                Some(letter) => letter.eq_ignore_ascii_case(&wanted),
                None => key == position,
            };
            return match key {
                _ if is('z', KeyCode::KeyZ) && !shift => Some(Self::UndoCrater),
                _ if is('q', KeyCode::KeyQ) && !shift => Some(Self::Quit),
                _ if is('o', KeyCode::KeyO) && !shift => Some(Self::Open),
                _ if is('s', KeyCode::KeyS) && !shift => Some(Self::SaveMap),
                KeyCode::Tab => Some(if shift { Self::PreviousMap } else { Self::NextMap }),
                KeyCode::Backspace if shift => Some(Self::ClearCraters),
                KeyCode::F9 if shift && cfg!(debug_assertions) => Some(Self::LoseDevice),
                KeyCode::F10 if shift && cfg!(debug_assertions) => Some(Self::LoseSurface),
                _ => None,
            };
        }
        Some(match key {
            KeyCode::KeyF => Self::Capture,
            KeyCode::Escape => Self::Escape,
            KeyCode::Home => Self::FrameTerrain,
            KeyCode::KeyC => Self::Crater,
            KeyCode::F1 => Self::Help,
            KeyCode::F2 => Self::Panel,
            KeyCode::F3 => Self::Overlay,
            KeyCode::F11 => Self::FullScreen,
            KeyCode::F12 => Self::Screenshot,
            _ => return None,
        })
    }

    /// Whether the key types nothing and edits nothing, so that it works while a field of the panel has the keyboard.
    pub(crate) fn works_while_typing(self) -> bool {
        matches!(self, Self::Help | Self::Panel | Self::Overlay | Self::FullScreen | Self::Screenshot | Self::Quit)
            || matches!(self, Self::Open | Self::SaveMap | Self::NextMap | Self::PreviousMap)
    }
}

/// Which keys are down, and for how long each has not yet been turned into movement.
///
/// Times come with the events, so a tap shorter than a frame moves the eye by exactly as much as it should.
#[derive(Debug)]
pub(crate) struct Fly {
    /// Base speed in map widths per second.
    pub(crate) speed: f64,
    fast: bool,
    slow: bool,
    since: [Option<Instant>; Direction::COUNT],
    unspent: [Duration; Direction::COUNT],
}

impl Default for Fly {
    fn default() -> Self {
        Self { speed: DEFAULT_SPEED, fast: false, slow: false, since: Default::default(), unspent: Default::default() }
    }
}

impl Fly {
    /// A movement key goes down. Repeats of a key that is down change nothing.
    pub(crate) fn press(&mut self, direction: Direction, now: Instant) {
        self.since[direction as usize].get_or_insert(now);
    }

    /// A movement key goes up.
    pub(crate) fn release(&mut self, direction: Direction, now: Instant) {
        let key = direction as usize;
        if let Some(since) = self.since[key].take() {
            self.unspent[key] += now.saturating_duration_since(since).min(LONGEST_STEP);
        }
    }

    /// All keys go up: the window lost the keyboard.
    pub(crate) fn release_all(&mut self) {
        self.since = Default::default();
        (self.fast, self.slow) = (false, false);
    }

    /// Shift and Alt.
    pub(crate) fn set_modifiers(&mut self, fast: bool, slow: bool) {
        (self.fast, self.slow) = (fast, slow);
    }

    /// Whether the next frame moves the eye.
    pub(crate) fn is_moving(&self) -> bool {
        self.since.iter().any(Option::is_some) || self.unspent.iter().any(|time| !time.is_zero())
    }

    /// Changes the base speed by notches of the wheel, up is faster.
    pub(crate) fn scroll(&mut self, notches: f64) {
        self.speed = (self.speed * WHEEL_FACTOR.powf(notches)).clamp(*SPEED_RANGE.start(), *SPEED_RANGE.end());
    }

    /// The way of the eye since the last call, world units. `height` is its height above the ground.
    pub(crate) fn step(&mut self, camera: &Camera, height: f64, now: Instant) -> DVec3 {
        let mut seconds = [0.0; Direction::COUNT];
        for (key, seconds) in seconds.iter_mut().enumerate() {
            if let Some(since) = &mut self.since[key] {
                self.unspent[key] += now.saturating_duration_since(*since).min(LONGEST_STEP);
                *since = now.max(*since);
            }
            *seconds = std::mem::take(&mut self.unspent[key]).as_secs_f64();
        }
        let along = |towards: Direction, away: Direction| seconds[towards as usize] - seconds[away as usize];
        let basis = camera.basis();
        let way = basis.forward * along(Direction::Forward, Direction::Back)
            + basis.right * along(Direction::Right, Direction::Left)
            + DVec3::Y * along(Direction::Up, Direction::Down);
        // Two keys at once are not faster than one.
        let longest = seconds.iter().copied().fold(0.0, f64::max);
        way.clamp_length_max(longest) * self.velocity(height)
    }

    /// World units per second at a height above the ground, with Shift and Alt.
    fn velocity(&self, height: f64) -> f64 {
        let by_height = (height / REFERENCE_HEIGHT).clamp(HEIGHT_FACTORS[0], HEIGHT_FACTORS[1]);
        let by_keys = if self.fast { 4.0 } else { 1.0 } * if self.slow { 0.25 } else { 1.0 };
        self.speed * by_height * by_keys
    }
}

/// Turns the camera by a movement of the mouse in pixels (x right, y down).
pub(crate) fn look(camera: &mut Camera, moved: DVec2) {
    let turn = camera.fov * TURN_PER_PIXEL;
    camera.yaw = (camera.yaw + moved.x * turn).rem_euclid(360.0);
    camera.pitch = (camera.pitch - moved.y * turn).clamp(-MAX_PITCH, MAX_PITCH);
}

/// World height of the ground under a point; `None` beside the map, where there is none. `size` is the box's.
pub(crate) fn ground_below(map: &HeightField, size: DVec3, point: DVec3) -> Option<f64> {
    let (u, v) = (point.x / size.x, point.z / size.z);
    ((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)).then(|| map.surface_height(u, v) * size.y)
}

/// Height of a point above the ground, or above the box's floor beside the map; never negative.
pub(crate) fn height_above_ground(map: &HeightField, size: DVec3, point: DVec3) -> f64 {
    (point.y - ground_below(map, size, point).unwrap_or(0.0)).max(0.0)
}

/// Lifts an eye that is below the ground, or closer to it than [`CLEARANCE`]. Says whether it had to.
pub(crate) fn keep_above_ground(camera: &mut Camera, map: &HeightField, size: DVec3) -> bool {
    let lowest = ground_below(map, size, camera.eye).map(|ground| ground + CLEARANCE);
    let lift = lowest.filter(|lowest| camera.eye.y < *lowest);
    camera.eye.y = lift.unwrap_or(camera.eye.y);
    lift.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORTH: Camera = Camera { eye: DVec3::new(0.5, 2.0, 0.5), yaw: 0.0, pitch: 0.0, fov: 60.0 };

    fn after(start: Instant, ms: u64) -> Instant {
        start + Duration::from_millis(ms)
    }

    /// The way of the same flight must not depend on how many frames it was drawn in.
    #[test]
    fn the_way_depends_on_time_and_not_on_frames() {
        let start = Instant::now();
        let fly = |frames: &[u64]| {
            let mut fly = Fly::default();
            fly.press(Direction::Forward, start);
            let mut way: DVec3 = frames.iter().map(|ms| fly.step(&NORTH, 0.25, after(start, *ms))).sum();
            fly.release(Direction::Forward, after(start, 200));
            way += fly.step(&NORTH, 0.25, after(start, 500));
            assert!(!fly.is_moving());
            way
        };
        let expected = DVec3::NEG_Z * DEFAULT_SPEED * 0.2;
        for frames in [&[][..], &[16, 33, 50, 190], &[200]] {
            assert!((fly(frames) - expected).length() < 1e-12, "{frames:?}");
        }
    }

    #[test]
    fn modifiers_height_and_diagonals_scale_the_speed_as_documented() {
        let start = Instant::now();
        let fly = |directions: &[Direction], fast, slow, height| {
            let mut fly = Fly::default();
            fly.set_modifiers(fast, slow);
            directions.iter().for_each(|direction| fly.press(*direction, start));
            fly.step(&NORTH, height, after(start, 100)).length() / (DEFAULT_SPEED * 0.1)
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
        close(fly(&[Direction::Right], true, false, 0.25), 4.0);
        close(fly(&[Direction::Right], false, true, 0.25), 0.25);
        close(fly(&[Direction::Right, Direction::Forward, Direction::Up], false, false, 0.25), 1.0);
        close(fly(&[Direction::Right, Direction::Left], false, false, 0.25), 0.0);
        close(fly(&[Direction::Up], false, false, 0.0), HEIGHT_FACTORS[0]);
        close(fly(&[Direction::Up], false, false, 100.0), HEIGHT_FACTORS[1]);
    }

    #[test]
    fn lost_focus_stops_the_flight_and_a_stall_does_not_throw_the_eye() {
        let start = Instant::now();
        let mut fly = Fly::default();
        fly.press(Direction::Forward, start);
        let way = fly.step(&NORTH, 0.25, after(start, 60_000));
        assert!(way.length() <= DEFAULT_SPEED * LONGEST_STEP.as_secs_f64() + 1e-12);
        fly.release_all();
        assert!(!fly.is_moving());
        assert_eq!(fly.step(&NORTH, 0.25, after(start, 61_000)), DVec3::ZERO);
    }

    #[test]
    fn the_wheel_stays_within_its_range() {
        let mut fly = Fly::default();
        fly.scroll(1.0);
        assert!(fly.speed > DEFAULT_SPEED);
        fly.scroll(1e4);
        assert_eq!(fly.speed, *SPEED_RANGE.end());
        fly.scroll(-1e5);
        assert_eq!(fly.speed, *SPEED_RANGE.start());
    }

    #[test]
    fn the_mouse_looks_right_and_down_and_never_tips_over() {
        let mut camera = NORTH;
        look(&mut camera, DVec2::new(10.0, 10.0));
        assert!(camera.yaw > 0.0 && camera.yaw < 90.0 && camera.pitch < 0.0);
        look(&mut camera, DVec2::new(-20.0, 1e6));
        assert!(camera.yaw > 270.0 && camera.pitch == -MAX_PITCH);
    }

    #[test]
    fn undo_follows_the_printed_letter_and_movement_the_position() {
        assert_eq!(Shortcut::from_key(KeyCode::KeyY, Some('z'), true, false), Some(Shortcut::UndoCrater), "QWERTZ");
        assert_eq!(Shortcut::from_key(KeyCode::KeyZ, Some('y'), true, false), None, "QWERTZ");
        assert_eq!(Shortcut::from_key(KeyCode::KeyZ, Some('я'), true, false), Some(Shortcut::UndoCrater), "Cyrillic");
        assert_eq!(Shortcut::from_key(KeyCode::KeyC, Some('c'), true, false), None, "Ctrl+C copies, it digs nothing");
        assert_eq!(Shortcut::from_key(KeyCode::KeyC, Some('c'), false, false), Some(Shortcut::Crater));
        assert_eq!(Shortcut::from_key(KeyCode::KeyA, Some('q'), true, false), Some(Shortcut::Quit), "AZERTY");
        assert_eq!(Shortcut::from_key(KeyCode::KeyQ, Some('q'), false, false), None, "Q alone flies down");
        assert_eq!(Direction::from_key(KeyCode::KeyW), Some(Direction::Forward));
    }

    #[test]
    fn an_eye_below_the_ground_is_lifted_and_one_beside_the_map_is_not() {
        let map = HeightField::from_raw(2, 2, &[0.0_f32, 1.0, 0.0, 1.0]).unwrap();
        let size = map.box_size(Some(0.5));
        let mut camera = Camera { eye: DVec3::new(0.5, -1.0, 0.5), ..NORTH };
        assert!(keep_above_ground(&mut camera, &map, size));
        assert!((camera.eye.y - (map.surface_height(0.5, 0.5) * 0.5 + CLEARANCE)).abs() < 1e-12);
        assert!(!keep_above_ground(&mut camera, &map, size), "lifted once is enough");
        let mut beside = Camera { eye: DVec3::new(-0.1, -1.0, 0.5), ..NORTH };
        assert!(!keep_above_ground(&mut beside, &map, size));
    }
}
