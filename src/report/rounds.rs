//! Timing several variants in turn, within a budget, so that whatever else the machine does falls on all of them.

use serde::Serialize;

use super::figures::nearest_rank;

/// Fewest frames that a variant gets when time runs short.
pub(super) const FEWEST: usize = 3;

/// Milliseconds per frame over some rounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Median (nearest rank).
    pub ms: f64,
    /// 95th percentile (nearest rank).
    pub ms_p95: f64,
    /// Frames that were timed.
    pub rounds: usize,
}

impl Times {
    /// The statistics of at least one time.
    pub(super) fn of(times: &[f64]) -> Option<Self> {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        Some(Self { ms: nearest_rank(&sorted, 50)?, ms_p95: nearest_rank(&sorted, 95)?, rounds: sorted.len() })
    }
}

/// How many frames each variant gets: `wanted`, or fewer for the slowest where all together would take longer than
/// `budget_ms`. No variant then gets more than a common share of time, but each gets [`FEWEST`].
pub(super) fn plan(frame_ms: &[f64], wanted: usize, budget_ms: f64) -> Vec<usize> {
    let frames = |share: f64| -> Vec<usize> {
        let most = |ms: &f64| (share / ms.max(1e-3)) as usize;
        frame_ms.iter().map(|ms| most(ms).clamp(FEWEST.min(wanted), wanted)).collect()
    };
    let cost = |plan: &[usize]| plan.iter().zip(frame_ms).map(|(&count, ms)| count as f64 * ms).sum::<f64>();
    let (mut low, mut high) = (0.0, frame_ms.iter().fold(0.0f64, |most, &ms| most.max(ms)) * (wanted + 1) as f64);
    if cost(&frames(high)) <= budget_ms {
        return frames(high);
    }
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if cost(&frames(middle)) <= budget_ms { low = middle } else { high = middle }
    }
    frames(low)
}

/// Whether a variant that gets `count` of `rounds` frames has one in `round`; they are spread evenly.
pub(super) fn has_turn(round: usize, count: usize, rounds: usize) -> bool {
    (round + 1) * count / rounds > round * count / rounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_time_is_taken_from_the_slowest() {
        assert_eq!(plan(&[1.0, 2.0, 3.0], 20, 1e9), [20, 20, 20]);
        let plan = plan(&[1.0, 1.0, 100.0, 1000.0], 20, 4000.0);
        assert_eq!(plan[..2], [20, 20]);
        assert_eq!((plan[2], plan[3]), (9, 3), "900 ms and no less than three frames");
        assert_eq!(super::plan(&[5.0], 2, 0.0), [2], "never more than wanted");
        assert!(super::plan(&[], 20, 1.0).is_empty());
    }

    #[test]
    fn every_frame_of_a_plan_gets_its_turn() {
        for count in 0..=20 {
            assert_eq!((0..20).filter(|&round| has_turn(round, count, 20)).count(), count);
        }
    }

    #[test]
    fn statistics_of_times_are_times_that_occurred() {
        let times: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(Times::of(&times), Some(Times { ms: 10.0, ms_p95: 19.0, rounds: 20 }));
        assert_eq!(Times::of(&[]), None);
    }
}
