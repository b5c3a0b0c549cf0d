//! Who watches a long measurement: the progress bar, and the signals that end it.

use std::sync::atomic::{AtomicBool, Ordering};

use super::failure::Exit;
use super::progress::Progress;
use crate::report::Monitor;

/// Set by Ctrl-C, and where a service or a batch system ends the program (SIGTERM, SIGHUP).
static STOP: AtomicBool = AtomicBool::new(false);

/// The progress bar of a long measurement, and Ctrl-C or its like: the first ends the measuring, the second the program.
pub(crate) struct Watch(Progress);

impl Watch {
    pub(crate) fn start() -> Self {
        let handler = || {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(Exit::Failed as i32);
            }
        };
        // Without a handler Ctrl-C ends the program at once, as it does elsewhere.
        if let Err(error) = ctrlc::set_handler(handler) {
            log::debug!("no handler for Ctrl-C: {error}");
        }
        Self(Progress::start("measuring").with_time_left())
    }
}

impl Monitor for Watch {
    fn tell(&self, what: &str, share: f64) {
        log::debug!("{:.1} %: {what}", share * 100.0);
        let stopping = if self.stop() { "stopping after: " } else { "" };
        self.0.say(&format!("{stopping}{what}"));
        self.0.set(share as f32);
    }

    fn stop(&self) -> bool {
        STOP.load(Ordering::Relaxed)
    }
}
