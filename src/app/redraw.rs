//! When the next frame is due. Nothing changed: never. Knows no window and no clock but the one it is given.

use std::time::{Duration, Instant};

/// When the event loop has to come back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// A frame is due.
    Now,
    /// Nothing before this moment.
    At(Instant),
    /// Nothing before the next event.
    Never,
}

impl Next {
    /// The earlier of two.
    pub(crate) fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Now, _) | (_, Self::Now) => Self::Now,
            (Self::At(a), Self::At(b)) => Self::At(a.min(b)),
            (Self::At(at), Self::Never) | (Self::Never, Self::At(at)) => Self::At(at),
            (Self::Never, Self::Never) => Self::Never,
        }
    }
}

/// What has asked for a frame.
#[derive(Debug, Default)]
pub(crate) struct Redraw {
    dirty: bool,
    wake: Option<Instant>,
    last: Option<Instant>,
}

impl Redraw {
    /// Something changed.
    pub(crate) fn invalidate(&mut self) {
        self.dirty = true;
    }

    /// Something will have changed at `at`. Only the earliest moment is kept: whoever draws in a frame asks again in it.
    pub(crate) fn wake_at(&mut self, at: Instant) {
        self.wake = Some(self.wake.map_or(at, |wake| wake.min(at)));
    }

    /// Whether a frame is wanted, be it due or not.
    pub(crate) fn is_wanted(&self) -> bool {
        self.dirty
    }

    /// A frame begins: all that was asked for so far is about to be drawn.
    pub(crate) fn begin_frame(&mut self, now: Instant) {
        self.dirty = false;
        self.wake = self.wake.filter(|wake| *wake > now);
        self.last = Some(now);
    }

    /// When the next frame is due. `continuous`: something moves. `limit`: most frames per second, 0 for no limit.
    pub(crate) fn next(&self, now: Instant, continuous: bool, limit: u32) -> Next {
        let wanted = if self.dirty || continuous { Some(now) } else { self.wake };
        let Some(wanted) = wanted else { return Next::Never };
        let earliest = match (self.last, limit) {
            (Some(last), 1..) => wanted.max(last + Duration::from_secs(1) / limit),
            _ => wanted,
        };
        if earliest <= now { Next::Now } else { Next::At(earliest) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn nothing_changed_means_no_frame_ever() {
        let mut redraw = Redraw::default();
        let now = Instant::now();
        assert_eq!(redraw.next(now, false, 0), Next::Never);
        redraw.invalidate();
        assert_eq!(redraw.next(now, false, 0), Next::Now);
        redraw.begin_frame(now);
        assert_eq!(redraw.next(now, false, 0), Next::Never);
    }

    #[test]
    fn movement_draws_without_pause_and_stops_with_it() {
        let mut redraw = Redraw::default();
        let now = Instant::now();
        redraw.begin_frame(now);
        assert_eq!(redraw.next(now, true, 0), Next::Now);
        assert_eq!(redraw.next(now, false, 0), Next::Never);
    }

    #[test]
    fn the_limit_delays_frames_and_loses_none() {
        let mut redraw = Redraw::default();
        let now = Instant::now();
        redraw.begin_frame(now);
        redraw.invalidate();
        let due = now + Duration::from_secs(1) / 20;
        assert_eq!(redraw.next(now + MS, false, 20), Next::At(due));
        assert_eq!(redraw.next(due, false, 20), Next::Now);
        assert_eq!(redraw.next(now + MS, true, 20), Next::At(due));
    }

    #[test]
    fn the_earliest_wake_wins_and_is_spent_by_its_frame() {
        let mut redraw = Redraw::default();
        let now = Instant::now();
        redraw.wake_at(now + 50 * MS);
        redraw.wake_at(now + 10 * MS);
        redraw.wake_at(now + 30 * MS);
        assert_eq!(redraw.next(now, false, 0), Next::At(now + 10 * MS));
        assert_eq!(redraw.next(now + 10 * MS, false, 0), Next::Now);
        redraw.begin_frame(now + 10 * MS);
        assert_eq!(redraw.next(now + 10 * MS, false, 0), Next::Never);
    }

    #[test]
    fn the_earlier_of_two_reasons_counts() {
        let now = Instant::now();
        assert_eq!(Next::At(now).or(Next::At(now + MS)), Next::At(now));
        assert_eq!(Next::Never.or(Next::At(now)), Next::At(now));
        assert_eq!(Next::Never.or(Next::Now), Next::Now);
    }
}
