//! A sign of life on stderr for work that takes longer than half a second.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// How long work may take before it is announced.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time between two pictures of the spinner or the bar.
const TICK: Duration = Duration::from_millis(100);
/// The share that is the whole of the work.
const WHOLE: u64 = 1000;

/// Time between two lines where stderr is no terminal.
const PAUSE: Duration = Duration::from_secs(5);

/// A spinner, or once a share of the work is known a bar with a percentage. It appears when it is not dropped within
/// half a second. Where stderr is no terminal, a line every few seconds.
pub(crate) struct Progress {
    shown: Arc<Shown>,
    waiter: Option<(Sender<()>, JoinHandle<()>)>,
}

/// What the bar shows.
struct Shown {
    /// What is done, out of [`WHOLE`].
    done: AtomicU64,
    /// The work being done.
    what: Mutex<String>,
    /// Whether it says how long the work still takes.
    time_left: AtomicBool,
}

impl Progress {
    /// Begins to wait; `what` is the work being done.
    pub(crate) fn start(what: impl Into<String>) -> Self {
        let shown = Arc::new(Shown {
            done: AtomicU64::new(0),
            what: Mutex::new(what.into()),
            time_left: AtomicBool::new(false),
        });
        let to_show = Arc::clone(&shown);
        let (sender, end) = channel::<()>();
        let in_lines = !std::io::stderr().is_terminal();
        let waiter = std::thread::spawn(move || {
            if in_lines {
                tell(&to_show, &end, PAUSE, |line| eprintln!("relief: {line}"));
            } else if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                show(&to_show, &end);
            }
        });
        Self { shown, waiter: Some((sender, waiter)) }
    }

    /// Says how long the work still takes, too.
    pub(crate) fn with_time_left(self) -> Self {
        self.shown.time_left.store(true, Ordering::Relaxed);
        self
    }

    /// Tells what is being done now.
    pub(crate) fn say(&self, what: &str) {
        what.clone_into(&mut self.shown.what.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Tells the share that is done, 0..1. Several threads may, in any order: what is done stays done.
    pub(crate) fn set(&self, share: f32) {
        self.shown.done.fetch_max((share * WHOLE as f32) as u64, Ordering::Relaxed);
    }
}

/// Tells a line after every pause until `end` hears that the work is done.
fn tell(shown: &Shown, end: &Receiver<()>, pause: Duration, mut line: impl FnMut(&str)) {
    let start = Instant::now();
    while end.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
        let what = shown.what.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let share = match shown.done.load(Ordering::Relaxed) {
            0 => String::new(),
            done => format!(" {} %,", done * 100 / WHOLE),
        };
        line(&format!("{what} …{share} {} s", start.elapsed().as_secs()));
    }
}

/// Draws until `end` hears that the work is done.
fn show(shown: &Shown, end: &Receiver<()>) {
    let bar = ProgressBar::new(WHOLE);
    loop {
        let done = shown.done.load(Ordering::Relaxed);
        let template = match (done, shown.time_left.load(Ordering::Relaxed)) {
            (0, _) => "{spinner} {msg} ({elapsed})",
            (_, false) => "{spinner} {msg} [{bar:30}] {percent:>3} % ({elapsed})",
            (_, true) => "{spinner} [{bar:30}] {percent:>3} % {elapsed}, {eta} left: {wide_msg}",
        };
        bar.set_message(shown.what.lock().unwrap_or_else(PoisonError::into_inner).clone());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_gets_a_line_now_and_then() {
        let shown =
            Shown { done: AtomicU64::new(420), what: Mutex::new("raining".into()), time_left: AtomicBool::new(false) };
        let (sender, end) = channel::<()>();
        let mut sender = Some(sender);
        let mut lines = Vec::new();
        tell(&shown, &end, Duration::from_millis(1), |line| {
            lines.push(line.to_owned());
            if lines.len() == 2 {
                sender = None;
            }
        });
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("raining … 42 %, 0 s"), "{lines:?}");
    }
}
