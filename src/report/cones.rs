//! Cone maps within a budget: each is found once for a report, and given up where it would take too long.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use crate::heightfield::{ConeKind, ConeMap, HeightField};

/// A search is judged by its own pace after this share of its budget, but no later than after so many seconds.
const JUDGED_AFTER: f64 = 0.1;
const JUDGED_AFTER_S: f64 = 3.0;

/// What became of a search for cones.
#[derive(Debug)]
pub(super) enum Search {
    /// The cones, and the seconds that it took to find them.
    Found(Arc<ConeMap>, f64),
    /// It would have taken about so many seconds, by the pace of what was found.
    TooLong(f64),
    /// It was asked to stop.
    Stopped,
}

/// Who watches a search.
pub(super) trait Watcher: Sync {
    /// The share of the cones that is found, 0..1.
    fn tell(&self, share: f32);
    /// Whether to stop.
    fn stop(&self) -> bool;
}

/// Finds the cones of `field` on all cores, unless that takes longer than `budget_s` seconds.
pub(super) fn find(field: &HeightField, kind: ConeKind, budget_s: f64, watcher: &dyn Watcher) -> Search {
    let began = Instant::now();
    let given_up = Mutex::new(None);
    let judged_s = (JUDGED_AFTER * budget_s).min(JUDGED_AFTER_S);
    let map = ConeMap::build_while(field, kind, &|share| {
        watcher.tell(share);
        let elapsed = began.elapsed().as_secs_f64();
        let whole = elapsed / f64::from(share.max(f32::MIN_POSITIVE));
        // What is found is not thrown away for being late.
        if share < 1.0 && elapsed > judged_s && whole > budget_s {
            given_up.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(whole);
            return ControlFlow::Break(());
        }
        if watcher.stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    match (map, given_up.into_inner().unwrap_or_else(PoisonError::into_inner)) {
        (Some(map), _) => Search::Found(Arc::new(map), began.elapsed().as_secs_f64()),
        (None, Some(whole)) => Search::TooLong(whole),
        (None, None) => Search::Stopped,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::generate::{Kind, generate};

    struct Calm(bool);

    impl Watcher for Calm {
        fn tell(&self, _: f32) {}

        fn stop(&self) -> bool {
            self.0
        }
    }

    #[test]
    fn a_search_is_found_or_given_up_or_stopped() {
        let field = generate(Kind::Ridged, 65, 2);
        for kind in [ConeKind::Cone, ConeKind::Relaxed] {
            let Search::Found(map, seconds) = find(&field, kind, 1e9, &Calm(false)) else { panic!("found") };
            assert!(*map == ConeMap::build(&field, kind, &|_| {}) && seconds > 0.0);
            let Search::TooLong(seconds) = find(&field, kind, 1e-9, &Calm(false)) else { panic!("too long") };
            assert!(seconds > 1e-9 && seconds.is_finite());
            assert!(matches!(find(&field, kind, 1e9, &Calm(true)), Search::Stopped));
        }
    }
}
