//! What frames cost: their times, which arrive some time after them, and steps per ray, measured now and then.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::redraw::Next;
use crate::render::{Ledger, RenderError, Renderer};
use crate::scene::Scene;

/// Frames that the graph and the numbers look back on.
pub(super) const FRAMES: usize = 120;

/// How often a frame's GPU time is looked for, and for how long: a software driver may take seconds for a frame, and those
/// are the ones to know about.
const TIME_POLL: Duration = Duration::from_millis(15);
const TIME_PATIENCE: Duration = Duration::from_secs(10);

/// Least time between two measurements of steps per ray.
const STEPS_PAUSE: Duration = Duration::from_millis(500);

/// Size of what steps are measured on, for a picture of `size` pixels: a quarter of it.
pub(crate) fn probed_size(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| (side / 4).max(1))
}

/// Steps per ray: mean and maximum.
pub(crate) type Steps = (f64, u32);

/// GPU times of the last frames.
#[derive(Debug, Default)]
pub(crate) struct FrameTimes {
    newest_last: VecDeque<f64>,
}

impl FrameTimes {
    /// Adds a frame's milliseconds.
    pub(crate) fn push(&mut self, ms: f64) {
        if self.newest_last.len() == FRAMES {
            self.newest_last.pop_front();
        }
        self.newest_last.push_back(ms);
    }

    /// Milliseconds of the last frames.
    pub(crate) fn newest_first(&self) -> impl Iterator<Item = f64> {
        self.newest_last.iter().rev().copied()
    }

    /// The smallest time that `share` of the frames did not exceed; `None` without frames.
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.newest_first().collect();
        sorted.sort_by(f64::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).copied()
    }
}

/// What a frame's time is the time of: all that it depends on but the eye and the cube's turning.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Subject {
    scene: Scene,
    passes: Vec<String>,
    defs: Vec<String>,
    size: [u32; 2],
}

impl Subject {
    /// Of a picture of `scene` of `size` pixels that was just drawn, with `ledger`.
    pub(crate) fn of(scene: &Scene, ledger: &Ledger, size: [u32; 2]) -> Self {
        let mut scene = scene.clone();
        scene.camera = None;
        scene.occluder.rotation = Default::default();
        // What shows the picture is not timed.
        let is_timed = |pass: &&String| !["present", "egui"].contains(&pass.as_str());
        let passes = ledger.passes.iter().filter(is_timed).cloned().collect();
        Self { scene, passes, defs: ledger.shader_defs.clone(), size }
    }
}

/// Gathers what frames cost.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    /// Times of the last frames, all of the same subject.
    pub(crate) times: FrameTimes,
    subject: Subject,
    /// Frames whose times have not arrived; the times of the first `foreign` of them are those of another subject.
    in_flight: usize,
    foreign: usize,
    /// Steps of the last measurement.
    pub(crate) steps: Option<Steps>,
    /// Since when a frame's time is awaited.
    awaited: Option<Instant>,
    /// A picture was drawn since steps were measured.
    steps_stale: bool,
    steps_measured: Option<Instant>,
}

impl Meter {
    /// Forgets the times there are, and those on their way.
    pub(crate) fn forget_times(&mut self) {
        self.times = FrameTimes::default();
        self.foreign = self.in_flight;
    }

    /// Notes that a picture of `subject` was drawn. The times of another are forgotten.
    pub(crate) fn scene_was_drawn(&mut self, subject: Subject, now: Instant) {
        if subject != self.subject {
            self.forget_times();
            self.subject = subject;
        }
        self.in_flight += 1;
        self.awaited = Some(now);
        self.steps_stale = true;
    }

    /// When to look again. `steps`: steps per ray are wanted.
    pub(crate) fn next(&self, now: Instant, steps: bool) -> Next {
        let times = self.awaited.map_or(Next::Never, |_| Next::At(now + TIME_POLL));
        times.or(self.steps_due(now, steps).map_or(Next::Never, |at| Next::At(at.max(now))))
    }

    /// When steps are to be measured, if they are.
    fn steps_due(&self, now: Instant, steps: bool) -> Option<Instant> {
        (steps && self.steps_stale).then(|| self.steps_measured.map_or(now, |measured| measured + STEPS_PAUSE))
    }

    /// Collects times that have arrived. True when the numbers on screen are no longer the latest.
    pub(crate) fn collect_times(&mut self, mut take: impl FnMut() -> Option<f64>, now: Instant) -> bool {
        let Some(since) = self.awaited else { return false };
        let mut arrived = false;
        while let Some(ms) = take() {
            self.in_flight = self.in_flight.saturating_sub(1);
            if self.foreign > 0 {
                self.foreign -= 1;
            } else {
                self.times.push(ms);
                arrived = true;
            }
        }
        let given_up = now.saturating_duration_since(since) > TIME_PATIENCE;
        if self.in_flight == 0 || given_up {
            self.nothing_in_flight();
        }
        arrived || given_up
    }

    /// No time is on its way any more: somebody else has taken them, or they never come.
    pub(crate) fn nothing_in_flight(&mut self) {
        (self.awaited, self.in_flight, self.foreign) = (None, 0, 0);
    }

    /// Measures steps per ray of `scene` on a quarter of a picture of `size`, if they are due. True when they were.
    pub(crate) fn measure_steps(
        &mut self,
        renderer: &mut Renderer,
        scene: &Scene,
        size: [u32; 2],
        now: Instant,
    ) -> Result<bool, RenderError> {
        if self.steps_due(now, true).is_none_or(|at| at > now) {
            return Ok(false);
        }
        (self.steps_stale, self.steps_measured) = (false, Some(now));
        self.steps = Some(renderer.probe(scene, probed_size(size))?.step_stats());
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_look_back_on_the_last_frames_only() {
        let mut times = FrameTimes::default();
        assert_eq!(times.quantile(0.5), None);
        times.push(1e6);
        for ms in 1..=FRAMES {
            times.push(ms as f64);
        }
        assert_eq!(times.quantile(0.5), Some(60.0));
        assert_eq!(times.quantile(0.99), Some(119.0));
        assert_eq!(times.quantile(1.0), Some(120.0));
    }

    #[test]
    fn a_meter_looks_for_times_only_while_one_is_awaited() {
        let mut meter = Meter::default();
        let now = Instant::now();
        assert_eq!(meter.next(now, true), Next::Never);
        meter.scene_was_drawn(Subject::default(), now);
        meter.scene_was_drawn(Subject::default(), now);
        assert_eq!(meter.next(now, false), Next::At(now + TIME_POLL));
        assert!(!meter.collect_times(|| None, now), "not there yet");
        for ms in [3.0, 4.0] {
            assert_eq!(meter.next(now, false), Next::At(now + TIME_POLL));
            let mut arriving = Some(ms);
            assert!(meter.collect_times(|| arriving.take(), now));
        }
        assert_eq!(meter.times.newest_first().collect::<Vec<_>>(), [4.0, 3.0]);
        assert_eq!(meter.next(now, false), Next::Never);
        assert_eq!(meter.next(now, true), Next::At(now), "steps were not measured yet");
        meter.scene_was_drawn(Subject::default(), now);
        assert!(meter.collect_times(|| None, now + 2 * TIME_PATIENCE), "a time that never comes is given up");
        assert_eq!(meter.next(now, false), Next::Never);
    }

    /// The numbers are those of the picture on screen, and flying does not clear them.
    #[test]
    fn times_of_another_picture_are_forgotten_also_those_on_their_way() {
        let mut scene = Scene::default();
        let subject = |scene: &Scene| Subject::of(scene, &Ledger::default(), [64, 48]);
        let (mut meter, now) = (Meter::default(), Instant::now());
        meter.scene_was_drawn(subject(&scene), now);
        meter.collect_times(|| None, now);
        scene.march.technique = crate::scene::Technique::Linear;
        meter.scene_was_drawn(subject(&scene), now);
        let mut arriving = vec![5.0, 90.0];
        assert!(meter.collect_times(|| arriving.pop(), now));
        assert_eq!(meter.times.newest_first().collect::<Vec<_>>(), [5.0], "90 ms are the other technique's");
        scene.camera = Some(crate::camera::Camera { eye: glam::DVec3::ONE, yaw: 1.0, pitch: 2.0, fov: 50.0 });
        scene.occluder.rotation.x += 1.0;
        meter.scene_was_drawn(subject(&scene), now);
        assert_eq!(meter.times.quantile(0.5), Some(5.0));
        meter.scene_was_drawn(Subject::of(&scene, &Ledger::default(), [640, 480]), now);
        assert_eq!(meter.times.quantile(0.5), None, "a picture of another size");
    }
}
