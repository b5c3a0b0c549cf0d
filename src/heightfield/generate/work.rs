//! Long work that tells how far it is and can be ended.

use std::sync::atomic::{AtomicBool, Ordering};

use super::MakeError;

/// A part of the work of making a landscape.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    progress: &'a (dyn Fn(f32) + Sync),
    cancel: &'a AtomicBool,
    /// The shares of the whole, 0..1, where this part begins and ends.
    span: [f32; 2],
}

impl<'a> Work<'a> {
    /// The whole. `progress` hears the share done, 0..1, from several threads and not always in order.
    pub(super) fn new(progress: &'a (dyn Fn(f32) + Sync), cancel: &'a AtomicBool) -> Self {
        Self { progress, cancel, span: [0.0, 1.0] }
    }

    /// As many parts as `weights`, one after the other, each as long as its weight says.
    pub(super) fn split<const N: usize>(self, weights: [f32; N]) -> [Self; N] {
        let [mut begin, end] = self.span;
        let unit = (end - begin) / weights.iter().sum::<f32>().max(f32::MIN_POSITIVE);
        weights.map(|weight| {
            let span = [begin, begin + unit * weight];
            begin = span[1];
            Self { span, ..self }
        })
    }

    /// Tells the share of this part that is done, 0..1.
    pub(super) fn tell(&self, share: f32) {
        let [begin, end] = self.span;
        (self.progress)((begin + (end - begin) * share).min(1.0));
    }

    /// Whether nobody wants the result any more. Rows and rounds ask, so that the work ends soon.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// An error once the work is cancelled.
    pub(super) fn check(&self) -> Result<(), MakeError> {
        if self.is_cancelled() { Err(MakeError::Cancelled) } else { Ok(()) }
    }
}
