//! A sign of life on stderr for work that takes longer than half a second.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// How long work may take before it is announced.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time between two pictures of the spinner or the bar.
const TICK: Duration = Duration::from_millis(100);
/// The share that is the whole of the work.
const WHOLE: u64 = 1000;

/// A spinner, or once a share of the work is known a bar with a percentage. It appears when it is not dropped within
/// half a second; none where stderr is no terminal.
pub(crate) struct Progress {
    /// What is done, out of [`WHOLE`].
    done: Arc<AtomicU64>,
    waiter: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Begins to wait; `what` is the work being done.
    pub(crate) fn start(what: impl Into<String>) -> Self {
        let done = Arc::new(AtomicU64::new(0));
        if !std::io::stderr().is_terminal() {
            return Self { done, waiter: None };
        }
        let (what, shown) = (what.into(), Arc::clone(&done));
        let (sender, end) = channel::<()>();
        let waiter = std::thread::spawn(move || {
            if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                show(what, &shown, &end);
            }
        });
        Self { done, waiter: Some((sender, waiter)) }
    }

    /// Tells the share that is done, 0..1. Several threads may, in any order: what is done stays done.
    pub(crate) fn set(&self, share: f32) {
        self.done.fetch_max((share * WHOLE as f32) as u64, Ordering::Relaxed);
    }
}

/// Draws until `end` hears that the work is done.
fn show(what: String, done: &AtomicU64, end: &Receiver<()>) {
    let bar = ProgressBar::new(WHOLE).with_message(what);
    loop {
        let done = done.load(Ordering::Relaxed);
        let template = match done {
            0 => "{spinner} {msg} ({elapsed})",
            _ => "{spinner} {msg} [{bar:30}] {percent:>3} % ({elapsed})",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_position(done);
        bar.tick();
        if end.recv_timeout(TICK) != Err(RecvTimeoutError::Timeout) {
            break;
        }
    }
    bar.finish_and_clear();
}

impl Drop for Progress {
    /// Clears the spinner before anything else is printed.
    fn drop(&mut self) {
        if let Some((sender, waiter)) = self.waiter.take() {
            drop(sender);
            // A spinner that panicked has nothing left to clear.
            let _ = waiter.join();
        }
    }
}
