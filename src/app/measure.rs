//! What frames cost: their times, which arrive some time after them, and steps per ray, measured now and then.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::redraw::Next;
use crate::render::{RenderError, Renderer};
use crate::scene::Scene;

/// Frames that the graph and the numbers look back on.
pub(super) const FRAMES: usize = 120;

/// How often a frame's GPU time is looked for, and for how long: a software driver may take seconds for a frame, and those
/// are the ones to know about.
const TIME_POLL: Duration = Duration::from_millis(15);
const TIME_PATIENCE: Duration = Duration::from_secs(10);

/// Least time between two measurements of steps per ray.
const STEPS_PAUSE: Duration = Duration::from_millis(500);

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

/// Gathers what frames cost.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    /// Times of the last frames.
    pub(crate) times: FrameTimes,
    /// Steps of the last measurement.
    pub(crate) steps: Option<Steps>,
    /// Since when a frame's time is awaited.
    awaited: Option<Instant>,
    /// A picture was drawn since steps were measured.
    steps_stale: bool,
    steps_measured: Option<Instant>,
}

impl Meter {
    /// Notes that a picture was drawn.
    pub(crate) fn scene_was_drawn(&mut self, now: Instant) {
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
            self.times.push(ms);
            arrived = true;
        }
        let over = arrived || now.saturating_duration_since(since) > TIME_PATIENCE;
        self.awaited = self.awaited.filter(|_| !over);
        over
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
        self.steps = Some(renderer.probe(scene, size.map(|side| (side / 4).max(1)))?.step_stats());
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
        meter.scene_was_drawn(now);
        assert_eq!(meter.next(now, false), Next::At(now + TIME_POLL));
        assert!(!meter.collect_times(|| None, now), "not there yet");
        let mut arriving = vec![4.0, 3.0];
        assert!(meter.collect_times(|| arriving.pop(), now));
        assert_eq!(meter.times.newest_first().collect::<Vec<_>>(), [4.0, 3.0]);
        assert_eq!(meter.next(now, false), Next::Never);
        assert_eq!(meter.next(now, true), Next::At(now), "steps were not measured yet");
        meter.scene_was_drawn(now);
        assert!(meter.collect_times(|| None, now + 2 * TIME_PATIENCE), "a time that never comes is given up");
        assert_eq!(meter.next(now, false), Next::Never);
    }
}
