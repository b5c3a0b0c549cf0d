//! A path of the eye: key frames, and the smooth way between them.
//!
//! Positions lie on a centripetal Catmull–Rom spline (Yuksel, Schaefer, Keyser: *Parameterization and applications of
//! Catmull–Rom curves*, 2011, section 2): it passes through every key frame and has neither cusps nor loops between two of
//! them. Directions and fields of view follow the same kind of curve over the same knots, as angles: the eye never rolls.
//! The way is travelled at constant speed by arc length; where the eye would have to turn faster than
//! `TURNS` times around within the whole path, it slows down.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::camera::{Camera, MAX_PITCH};
use crate::scene::Scene;
use crate::scene_file::{self, OutOfRange, SceneFileError};

/// How often the eye may turn around itself in the time of a path, at most.
const TURNS: f64 = 3.0;

/// Pieces of equal parameter that each segment's arc length is summed over.
const PIECES: usize = 64;

/// Most key frames of a path.
pub const MOST_FRAMES: usize = 10_000;

/// Shortest and longest time of a path, seconds.
pub const SECONDS: std::ops::RangeInclusive<f64> = 0.1..=3600.0;

/// Seconds that a new path takes for the way from one key frame to the next.
pub const SECONDS_PER_SEGMENT: f64 = 3.0;

/// Key frames and the time for all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPath {
    /// Time from the first key frame to the last, seconds.
    pub seconds: f64,
    /// The key frames, in order. The eye passes through each.
    #[serde(default)]
    pub frames: Vec<Camera>,
}

impl Default for CameraPath {
    fn default() -> Self {
        Self { seconds: SECONDS_PER_SEGMENT, frames: Vec::new() }
    }
}

/// Why a path file could not be used or written.
#[derive(Debug, thiserror::Error)]
pub enum PathFileError {
    /// The file could not be read.
    #[error("cannot read the camera path {}\nThe system says: {reason}.\nCheck the path, and that the file may be read.", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// A key that does not exist.
    #[error(transparent)]
    Key(SceneFileError),
    /// Not TOML, or a value of the wrong type.
    #[error("{}: it is no camera path: {reason}\nA path has `seconds` and a list [[frames]] with eye, yaw, pitch and fov.\nCorrect the file, or record a path in the viewer and save it.", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A number that no path can have.
    #[error("{}: {} cannot be {}\nIt must be {}.\nCorrect the value.", path.display(), reason.field, reason.value, reason.range)]
    Value {
        /// The file.
        path: PathBuf,
        /// The field, its value and its range.
        reason: OutOfRange,
    },
    /// The file could not be written.
    #[error("cannot write the camera path {}\nThe system says: {reason}.\nName a folder that exists, that you may write to, and that has room.", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// Nothing to travel along.
    #[error("{}: a path needs at least two different key frames, and this one has {found}\nBetween them lies the way.\nRecord another key frame in the viewer, or add one to the file.", path.display())]
    TooShort {
        /// The file.
        path: PathBuf,
        /// How many there are.
        found: usize,
    },
}

impl CameraPath {
    /// Adds a key frame, and the time for the way to it. False where the path has [`MOST_FRAMES`].
    pub fn push(&mut self, camera: Camera) -> bool {
        if self.frames.len() >= MOST_FRAMES {
            return false;
        }
        if self.frames.len() >= 2 {
            self.seconds = (self.seconds + SECONDS_PER_SEGMENT).min(*SECONDS.end());
        }
        self.frames.push(camera);
        true
    }

    /// Removes the last key frame, and the time for the way to it.
    pub fn pop(&mut self) -> Option<Camera> {
        let last = self.frames.pop();
        if self.frames.len() >= 2 {
            self.seconds = (self.seconds - SECONDS_PER_SEGMENT).max(SECONDS_PER_SEGMENT);
        }
        last
    }

    /// The way through the key frames; `None` with fewer than two different ones.
    pub fn track(&self) -> Option<Track> {
        Track::new(&self.frames, self.seconds)
    }

    /// The number of pictures of the whole way, its two ends included, at `per_second` of them.
    pub fn pictures(&self, per_second: u32) -> u32 {
        // In range: at most an hour, and a few hundred a second.
        (self.seconds * f64::from(per_second)).round().clamp(1.0, 1e6) as u32 + 1
    }

    /// Reads a path.
    ///
    /// # Errors
    /// The file cannot be read, is no TOML, has an unknown key, or a number outside its range. Too few key frames are none:
    /// see [`CameraPath::track`].
    pub fn read(path: &Path) -> Result<Self, PathFileError> {
        let file = || path.to_path_buf();
        let text = std::fs::read_to_string(path).map_err(|reason| PathFileError::Read { path: file(), reason })?;
        let read: Self = toml::from_str(&text).map_err(|error| match scene_file::explain(path, &text, &error) {
            unknown @ SceneFileError::Unknown { .. } => PathFileError::Key(unknown),
            _ => PathFileError::Syntax { path: file(), reason: error.message().to_owned() },
        })?;
        read.validate().map_err(|reason| PathFileError::Value { path: file(), reason })?;
        Ok(read)
    }

    /// Writes the path, whole or not at all.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, path: &Path) -> Result<(), PathFileError> {
        let failed = |reason| PathFileError::Write { path: path.to_path_buf(), reason };
        let toml = toml::to_string_pretty(self).map_err(|error| failed(std::io::Error::other(error.to_string())))?;
        let text = format!("# A camera path: relief render --path FILE --frames-per-second 30 -o FOLDER\n\n{toml}");
        crate::files::write_whole(path, text.as_bytes()).map_err(failed)
    }

    fn validate(&self) -> Result<(), OutOfRange> {
        let outside = |field: &str, value: String, range: String| Err(OutOfRange { field: field.into(), value, range });
        if !SECONDS.contains(&self.seconds) {
            let range = format!("at least {} and at most {}", SECONDS.start(), SECONDS.end());
            return outside("seconds", self.seconds.to_string(), range);
        }
        if self.frames.len() > MOST_FRAMES {
            return outside("the number of frames", self.frames.len().to_string(), format!("at most {MOST_FRAMES}"));
        }
        for (index, camera) in self.frames.iter().enumerate() {
            scene_file::validate(&Scene { camera: Some(*camera), ..Scene::default() }).map_err(|reason| {
                OutOfRange { field: reason.field.replace("camera", &format!("frames[{index}]")), ..reason }
            })?;
        }
        Ok(())
    }
}

/// A point of the curves: position and angles.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pose {
    eye: DVec3,
    /// Yaw without jumps, pitch, field of view: degrees.
    angles: DVec3,
}

impl Pose {
    /// `(1 − share)·self + share·other`, also beyond both.
    fn mix(self, other: Self, share: f64) -> Self {
        let mix = |a: DVec3, b: DVec3| a * (1.0 - share) + b * share;
        Self { eye: mix(self.eye, other.eye), angles: mix(self.angles, other.angles) }
    }

    fn camera(self) -> Camera {
        Camera { eye: self.eye, yaw: self.angles.x.rem_euclid(360.0), pitch: self.angles.y, fov: self.angles.z }
    }
}

/// The angle between two directions of view, and between their fields of view, radians.
fn turn(a: &Camera, b: &Camera) -> f64 {
    a.basis().forward.angle_between(b.basis().forward) + (a.fov - b.fov).abs().to_radians()
}

/// The smooth way through key frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    poses: Vec<Pose>,
    knots: Vec<f64>,
    /// The way from the start to the end of each piece, the first entry being 0; a turn counts where it is longer.
    ways: Vec<f64>,
    seconds: f64,
    /// Angles that are never left: pitch and field of view.
    lowest: [f64; 2],
    highest: [f64; 2],
}

impl Track {
    fn new(frames: &[Camera], seconds: f64) -> Option<Self> {
        // Two equal frames in a row would have a knot in common.
        let mut cameras = frames.to_vec();
        cameras.dedup();
        if cameras.len() < 2 {
            return None;
        }
        let pairs = || cameras.iter().zip(cameras.iter().skip(1));
        let length: f64 = pairs().map(|(a, b)| a.eye.distance(b.eye)).sum();
        // The way that turning by one radian is worth.
        let radian = if length > 0.0 { length / (TURNS * TAU) } else { 1.0 };
        let mut knots = vec![0.0];
        for (a, b) in pairs() {
            let way = a.eye.distance(b.eye) + radian * turn(a, b);
            let last = knots.last().copied().unwrap_or_default();
            // Yaw alone differs by whole turns, or straight up: then there is no way.
            knots.push(last + way.max(1e-12 * (1.0 + length)).sqrt());
        }
        let mut poses: Vec<Pose> = Vec::with_capacity(cameras.len());
        for camera in &cameras {
            let before = poses.last().map_or(camera.yaw, |pose| pose.angles.x);
            let yaw = before + (camera.yaw - before + 180.0).rem_euclid(360.0) - 180.0;
            poses.push(Pose { eye: camera.eye, angles: DVec3::new(yaw, camera.pitch, camera.fov) });
        }
        let ends = |of: fn(&Camera) -> f64| {
            cameras.iter().map(of).fold([f64::MAX, f64::MIN], |[low, high], value| [low.min(value), high.max(value)])
        };
        let (pitch, fov) = (ends(|camera| camera.pitch), ends(|camera| camera.fov));
        let mut track = Self {
            poses,
            knots,
            ways: vec![0.0],
            seconds,
            lowest: [pitch[0].min(-MAX_PITCH), fov[0]],
            highest: [pitch[1].max(MAX_PITCH), fov[1]],
        };
        track.measure(radian);
        Some(track)
    }

    fn measure(&mut self, radian: f64) {
        let pieces = (self.poses.len() - 1) * PIECES;
        let mut before = self.at_piece(0.0);
        let mut way = 0.0;
        for piece in 1..=pieces {
            let here = self.at_piece(piece as f64);
            way += before.eye.distance(here.eye).max(radian * turn(&before, &here));
            self.ways.push(way);
            before = here;
        }
    }

    /// Time from one end to the other, seconds.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The eye after `seconds`; before the start and after the end it rests.
    pub fn at(&self, seconds: f64) -> Camera {
        let whole = self.ways.last().copied().unwrap_or_default();
        let way = (seconds / self.seconds).clamp(0.0, 1.0) * whole;
        let last = self.ways.len() - 1;
        let piece = self.ways.partition_point(|reached| *reached <= way).clamp(1, last) - 1;
        let [start, end] = [piece, piece + 1].map(|piece| self.ways.get(piece).copied().unwrap_or(whole));
        let share = if end > start { ((way - start) / (end - start)).clamp(0.0, 1.0) } else { 1.0 };
        self.at_piece(piece as f64 + share)
    }

    /// The eye at a parameter that counts pieces.
    fn at_piece(&self, piece: f64) -> Camera {
        let segments = self.poses.len() - 1;
        let segment = ((piece / PIECES as f64) as usize).min(segments - 1);
        let share = piece / PIECES as f64 - segment as f64;
        let mut pose = self.in_segment(segment, share);
        pose.angles.y = pose.angles.y.clamp(self.lowest[0], self.highest[0]);
        pose.angles.z = pose.angles.z.clamp(self.lowest[1], self.highest[1]);
        pose.camera()
    }

    /// Barry and Goldman's pyramid over the four poses around a segment. Beyond the ends stand mirror images.
    fn in_segment(&self, segment: usize, share: f64) -> Pose {
        let [from, to] = [segment, segment + 1].map(|index| self.knotted(index));
        let Some(((t1, p1), (t2, p2))) = from.zip(to) else { return self.poses[0] };
        // At the ends themselves the key frames, to the last digit.
        if share <= 0.0 {
            return p1;
        }
        if share >= 1.0 {
            return p2;
        }
        let (t0, p0) =
            segment.checked_sub(1).and_then(|index| self.knotted(index)).unwrap_or((2.0 * t1 - t2, p2.mix(p1, 2.0)));
        let (t3, p3) = self.knotted(segment + 2).unwrap_or((2.0 * t2 - t1, p1.mix(p2, 2.0)));
        let t = t1 + share * (t2 - t1);
        let at = |a: Pose, b: Pose, start: f64, end: f64| a.mix(b, (t - start) / (end - start));
        let (a1, a2, a3) = (at(p0, p1, t0, t1), at(p1, p2, t1, t2), at(p2, p3, t2, t3));
        let (b1, b2) = (at(a1, a2, t0, t2), at(a2, a3, t1, t3));
        at(b1, b2, t1, t2)
    }

    fn knotted(&self, index: usize) -> Option<(f64, Pose)> {
        self.knots.get(index).copied().zip(self.poses.get(index).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: [f64; 3], yaw: f64, pitch: f64) -> Camera {
        Camera { eye: eye.into(), yaw, pitch, fov: 60.0 }
    }

    fn path() -> CameraPath {
        let frames = vec![
            camera([0.1, 0.3, 0.9], 10.0, -10.0),
            camera([0.3, 0.35, 0.5], 350.0, -20.0),
            camera([0.7, 0.3, 0.45], 300.0, -15.0),
            camera([0.9, 0.5, 0.8], 250.0, -40.0),
        ];
        CameraPath { seconds: 9.0, frames }
    }

    #[test]
    fn the_way_passes_every_key_frame_and_rests_at_its_ends() {
        let (path, close) = (path(), |a: Camera, b: Camera| {
            a.eye.distance(b.eye) + (a.yaw - b.yaw).abs() + (a.pitch - b.pitch).abs() < 0.02
        });
        let track = path.track().unwrap();
        assert_eq!((track.at(0.0), track.at(-5.0)), (path.frames[0], path.frames[0]));
        assert_eq!((track.at(9.0), track.at(99.0)), (path.frames[3], path.frames[3]));
        for frame in &path.frames {
            assert!((0..=9000).any(|ms| close(track.at(f64::from(ms) / 1000.0), *frame)), "{frame:?} is passed by");
        }
    }

    /// Speed is the same everywhere, and neither position nor direction jumps: not even through north.
    #[test]
    fn the_speed_is_constant_and_nothing_jumps() {
        let track = path().track().unwrap();
        let cameras: Vec<Camera> = (0..=900).map(|step| track.at(f64::from(step) / 100.0)).collect();
        let ways: Vec<f64> = cameras.windows(2).map(|pair| pair[0].eye.distance(pair[1].eye)).collect();
        let mean = ways.iter().sum::<f64>() / ways.len() as f64;
        assert!(ways.iter().all(|way| (way / mean - 1.0).abs() < 0.02), "{ways:?}");
        let turns: Vec<f64> = cameras.windows(2).map(|pair| turn(&pair[0], &pair[1]).to_degrees()).collect();
        assert!(turns.iter().all(|turn| *turn < 1.0), "{turns:?}");
    }

    /// A look around from one place takes its time, and a key frame recorded twice stops nothing.
    #[test]
    fn turning_on_the_spot_takes_time_and_equal_frames_are_one() {
        let here = [0.5, 0.5, 0.5];
        let turning = CameraPath { seconds: 4.0, frames: vec![camera(here, 0.0, 0.0), camera(here, 90.0, 0.0)] };
        let track = turning.track().unwrap();
        assert!((track.at(2.0).yaw - 45.0).abs() < 0.5, "{:?}", track.at(2.0));
        let mut twice = path();
        twice.frames.insert(2, twice.frames[1]);
        assert_eq!(twice.track(), path().track());
        let alone = CameraPath { seconds: 4.0, frames: vec![camera(here, 0.0, 0.0); 3] };
        assert_eq!(alone.track(), None);
        assert_eq!(CameraPath::default().track(), None);
    }

    #[test]
    fn a_turn_on_the_way_slows_the_eye_and_angles_stay_in_range() {
        let frames = vec![
            camera([0.0, 0.5, 0.5], 0.0, -89.9),
            camera([0.5, 0.5, 0.5], 0.0, 89.9),
            camera([0.501, 0.5, 0.5], 180.0, 89.9),
            camera([1.0, 0.5, 0.5], 180.0, -89.9),
        ];
        let track = CameraPath { seconds: 6.0, frames }.track().unwrap();
        for ms in 0..=6000 {
            let camera = track.at(f64::from(ms) / 1000.0);
            assert!(camera.eye.is_finite() && camera.pitch.abs() <= 89.9 && camera.fov == 60.0, "{camera:?}");
        }
    }

    #[test]
    fn a_path_written_and_read_again_is_the_same_and_mistakes_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.toml");
        path().write(&file).unwrap();
        assert_eq!(CameraPath::read(&file).unwrap(), path());
        for (text, words) in [
            ("second = 3\n", "nearest valid key is `seconds`"),
            ("seconds = 3\n[[frames]]\neye = [0, 0, 0]\nyow = 3\n", "nearest valid key is `yaw`"),
            ("seconds = 0.0\n", "seconds cannot be 0"),
            ("seconds = nan\n", "seconds cannot be NaN"),
            ("seconds = 3\n[[frames]]\neye = [0, inf, 0]\n", "frames[0].eye"),
            ("seconds = \n", "no camera path"),
        ] {
            std::fs::write(&file, text).unwrap();
            let error = CameraPath::read(&file).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
        assert!(CameraPath::read(&folder.path().join("none.toml")).is_err());
    }

    #[test]
    fn every_key_frame_brings_its_time() {
        let mut path = CameraPath::default();
        let seconds: Vec<f64> = (0..4)
            .map(|step| {
                path.push(camera([f64::from(step), 0.0, 0.0], 0.0, 0.0));
                path.seconds
            })
            .collect();
        assert_eq!(seconds, [3.0, 3.0, 6.0, 9.0]);
        path.pop();
        assert_eq!((path.seconds, path.frames.len(), path.pictures(10)), (6.0, 3, 61));
    }
}
