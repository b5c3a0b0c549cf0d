//! The eye goes by itself: to a point that was clicked twice, to a bookmark, along a camera path. Any input stops it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::DVec2;

use super::graphics::Graphics;
use super::orbit::{self, Glide, Ground};
use super::preferences::Mode;
use super::settings::PathCommand;
use super::viewer::Viewer;
use crate::camera::Camera;
use crate::camera_path::{CameraPath, Track};

/// Two clicks within this time and this distance in pixels are a double click.
const DOUBLE_CLICK: (Duration, f64) = (Duration::from_millis(450), 8.0);

/// Where the eye is going.
#[derive(Debug, Default)]
pub(super) struct Journey {
    glide: Option<Glide>,
    playing: Option<(Track, Instant)>,
    clicked: Option<(DVec2, Instant)>,
}

impl Journey {
    /// Whether the eye goes by itself.
    pub(super) fn is_under_way(&self) -> bool {
        self.glide.is_some() || self.playing.is_some()
    }

    /// Whether a path is being played.
    pub(super) fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Stays where it is. Says whether it was under way.
    pub(super) fn stop(&mut self) -> bool {
        self.glide.take().is_some() | self.playing.take().is_some()
    }

    /// The eye at a moment, while it goes by itself.
    pub(super) fn at(&mut self, now: Instant) -> Option<Camera> {
        if let Some((track, start)) = &self.playing {
            let passed = now.saturating_duration_since(*start).as_secs_f64();
            let camera = track.at(passed);
            if passed >= track.seconds() {
                self.playing = None;
            }
            return Some(camera);
        }
        let (camera, arrived) = self.glide?.at(now);
        if arrived {
            self.glide = None;
        }
        Some(camera)
    }

    /// Whether a click is the second of two.
    fn is_second(&mut self, cursor: DVec2, now: Instant) -> bool {
        let (time, distance) = DOUBLE_CLICK;
        let before = self.clicked.replace((cursor, now));
        let second = before
            .is_some_and(|(place, at)| now.saturating_duration_since(at) <= time && place.distance(cursor) <= distance);
        if second {
            self.clicked = None;
        }
        second
    }
}

impl Viewer {
    /// The ground as the eye's movements know it.
    pub(super) fn terrain<'a>(&'a self, graphics: &'a Graphics) -> Ground<'a> {
        Ground { map: self.ground(graphics), size: self.extent() }
    }

    /// Glides to a view, or is there at once where motion is reduced.
    pub(super) fn go_to(&mut self, camera: Camera, now: Instant) {
        self.journey.stop();
        self.pointer.orbiting = None;
        if self.reduces_motion() {
            self.scene.camera = Some(camera);
        } else {
            self.journey.glide = Some(Glide::new(self.camera(), camera, now));
        }
        self.redraw.invalidate();
    }

    /// A click on the picture; the second of two goes there.
    pub(super) fn clicked(&mut self, graphics: &Graphics, cursor: DVec2, now: Instant) {
        if !self.journey.is_second(cursor, now) {
            return;
        }
        let (camera, ground) = (self.camera(), self.terrain(graphics));
        match ground.hit(&camera, cursor, graphics.target.size()) {
            Some(point) => self.go_to(orbit::arrival(&camera, point, ground), now),
            None => self.refuse("Nowhere to go: there is only sky under the cursor. Point at the ground.".into(), now),
        }
    }

    /// Turns around the point that a drag began with.
    pub(super) fn turn_around(&mut self, graphics: &Graphics, moved: DVec2) {
        let Some(pivot) = self.pointer.orbiting else { return };
        let below = self.view.allow_below_ground;
        let turned = orbit::turn_around(&self.camera(), pivot, moved, self.terrain(graphics), below);
        self.scene.camera = Some(turned);
        self.redraw.invalidate();
    }

    /// Goes towards what is under the cursor by notches of the wheel.
    pub(super) fn approach(&mut self, graphics: &Graphics, notches: f64) {
        let (camera, ground, picture) = (self.camera(), self.terrain(graphics), graphics.target.size());
        let cursor = self.pointer.cursor.filter(|_| !self.pointer.captured);
        let point = cursor.and_then(|cursor| ground.hit(&camera, cursor, picture));
        let point = point.unwrap_or_else(|| ground.pivot(&camera, picture));
        self.scene.camera = Some(orbit::approach(&camera, point, notches, ground, self.view.allow_below_ground));
        self.redraw.invalidate();
    }

    /// Changes between flying and turning around.
    pub(super) fn toggle_mode(&mut self, now: Instant) {
        let (mode, says) = match self.view.mode {
            Mode::Fly => (Mode::Orbit, "Orbit: drag turns around the middle, the wheel goes towards the cursor"),
            Mode::Orbit => (Mode::Fly, "Fly: right drag looks around, the wheel changes the speed"),
        };
        self.view.mode = mode;
        self.pointer.orbiting = None;
        self.refuse(says.into(), now);
    }

    /// Sets bookmark `digit`, 1 to 9, to the view on screen.
    pub(super) fn set_bookmark(&mut self, digit: usize, now: Instant) {
        self.view.bookmarks.insert(digit.to_string(), self.camera());
        self.refuse(format!("Bookmark {digit} is set: {digit} comes back here"), now);
    }

    /// Goes to bookmark `digit`.
    pub(super) fn go_to_bookmark(&mut self, digit: usize, now: Instant) {
        match self.view.bookmarks.get(&digit.to_string()) {
            Some(camera) => self.go_to(*camera, now),
            None => self.refuse(format!("There is no bookmark {digit}. Ctrl+{digit} sets it to this view."), now),
        }
    }

    /// Does what the path's section or a key asks for.
    pub(super) fn path_command(&mut self, graphics: &Graphics, command: PathCommand, now: Instant) {
        self.redraw.invalidate();
        let edited = &mut self.view.path;
        match command {
            PathCommand::Add => {
                let camera = self.scene.camera.unwrap_or_else(|| self.camera());
                let says = if self.view.path.path.push(camera) {
                    format!("Key frame {} is recorded", self.view.path.path.frames.len())
                } else {
                    "The path has as many key frames as it can. Save it, and begin another.".to_owned()
                };
                self.refuse(says, now);
            }
            PathCommand::RemoveLast => {
                let says = match edited.path.pop() {
                    Some(_) => format!("Key frame {} is removed", edited.path.frames.len() + 1),
                    None => "The path has no key frame.".to_owned(),
                };
                self.refuse(says, now);
            }
            PathCommand::Clear => edited.path = CameraPath::default(),
            PathCommand::Play if self.journey.is_playing() => {
                self.journey.stop();
            }
            PathCommand::Play => match edited.path.track() {
                Some(track) => {
                    self.journey.stop();
                    self.journey.playing = Some((track, now));
                }
                None => self.refuse(self.no_way(), now),
            },
            PathCommand::Save => self.save_path(now),
            PathCommand::Load => self.load_path(now),
            PathCommand::Export => self.export(graphics, now),
            PathCommand::CancelExport => self.cancel_export(now),
        }
    }

    /// Why there is no way to travel, and what to do.
    pub(super) fn no_way(&self) -> String {
        let key = self.view.keys.shown(super::actions::Action::KeyFrame);
        let missing = 2usize.saturating_sub(self.view.path.path.frames.len()).max(1);
        format!("A path needs two different key frames: record {missing} more with {key}.")
    }

    fn save_path(&mut self, now: Instant) {
        let file = with_ending(&self.view.path.file);
        if file.exists() && !self.view.path.owns(&file) {
            self.toasts.error(&format!(
                "The camera path is not saved: {} exists already. Name a file that does not exist yet.",
                file.display()
            ));
            return;
        }
        match self.view.path.path.write(&file) {
            Ok(()) => {
                self.view.path.saved = Some(file.clone());
                self.toasts.info(&format!("Saved the camera path as {}", file.display()), now);
            }
            Err(error) => self.toasts.error(&error.to_string()),
        }
    }

    fn load_path(&mut self, now: Instant) {
        let file = with_ending(&self.view.path.file);
        match CameraPath::read(&file) {
            Ok(path) => {
                self.toasts.info(
                    &format!("Opened the camera path {} with {} key frames", file.display(), path.frames.len()),
                    now,
                );
                (self.view.path.path, self.view.path.saved) = (path, Some(file));
            }
            Err(error) => self.toasts.error(&format!("The path stays as it is. {error}")),
        }
    }
}

/// The file that a field names; without an ending it is a TOML.
fn with_ending(text: &str) -> PathBuf {
    let path = Path::new(text.trim());
    if path.extension().is_some() { path.to_path_buf() } else { path.with_extension("toml") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_quick_clicks_at_a_place_are_a_double_click_and_three_are_one() {
        let mut journey = Journey::default();
        let (start, here) = (Instant::now(), DVec2::new(100.0, 80.0));
        let ms = |ms: u64| start + Duration::from_millis(ms);
        assert!(!journey.is_second(here, start) && journey.is_second(here + DVec2::X * 3.0, ms(200)));
        assert!(!journey.is_second(here, ms(300)), "the third begins anew");
        assert!(!journey.is_second(here, ms(1000)) && !journey.is_second(here + DVec2::X * 30.0, ms(1100)));
    }

    #[test]
    fn a_path_plays_to_its_end_and_stops_when_asked() {
        let camera = |x: f64| Camera { eye: glam::DVec3::new(x, 1.0, 1.0), yaw: 0.0, pitch: 0.0, fov: 60.0 };
        let path = CameraPath { seconds: 2.0, frames: vec![camera(0.0), camera(1.0)] };
        let start = Instant::now();
        let mut journey = Journey { playing: path.track().map(|track| (track, start)), ..Journey::default() };
        assert!((journey.at(start + Duration::from_secs(1)).unwrap().eye.x - 0.5).abs() < 1e-6 && journey.is_playing());
        assert_eq!(journey.at(start + Duration::from_secs(3)), Some(camera(1.0)));
        assert!(!journey.is_under_way() && journey.at(start + Duration::from_secs(4)).is_none());
        journey.playing = path.track().map(|track| (track, start));
        assert!(journey.stop() && !journey.stop());
    }

    #[test]
    fn a_path_is_a_toml() {
        assert_eq!(with_ending(" a "), Path::new("a.toml"));
        assert_eq!(with_ending("a/b.toml"), Path::new("a/b.toml"));
    }
}
