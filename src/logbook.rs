//! The last messages of the program, kept for the viewer's log.
//!
//! A [`log::Log`] that keeps what passes through it and hands it on. Messages that were shown to the user elsewhere are
//! noted directly.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use log::{Level, LevelFilter, Log, Metadata, Record};

/// Most messages that are kept; older ones are forgotten.
pub const MOST: usize = 2000;

/// Most characters of one message.
const LONGEST: usize = 4000;

/// What passes through is kept up to this level, whatever the terminal shows: `info` of our own, warnings of others.
const KEPT: LevelFilter = LevelFilter::Info;

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// When it came.
    pub time: SystemTime,
    /// How grave it is.
    pub level: Level,
    /// Which part of the program it is from.
    pub source: String,
    /// What it says.
    pub text: String,
}

static BOOK: Mutex<VecDeque<Entry>> = Mutex::new(VecDeque::new());
static REVISION: AtomicU64 = AtomicU64::new(0);

/// Notes a message.
pub fn note(level: Level, source: &str, text: &str) {
    let text = text.chars().take(LONGEST).collect();
    let mut book = BOOK.lock().unwrap_or_else(PoisonError::into_inner);
    while book.len() >= MOST {
        book.pop_front();
    }
    book.push_back(Entry { time: SystemTime::now(), level, source: source.to_owned(), text });
    REVISION.fetch_add(1, Ordering::Relaxed);
}

/// A number that changes with every message.
pub fn revision() -> u64 {
    REVISION.load(Ordering::Relaxed)
}

/// All messages that are kept, oldest first.
pub fn entries() -> Vec<Entry> {
    BOOK.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
}

/// Forgets all messages.
pub fn clear() {
    BOOK.lock().unwrap_or_else(PoisonError::into_inner).clear();
    REVISION.fetch_add(1, Ordering::Relaxed);
}

/// Makes `terminal` the program's logger, with this book before it. `terminal_level` is the most that it lets pass.
///
/// Nothing happens where there is a logger already.
pub fn install(terminal: Box<dyn Log>, terminal_level: LevelFilter) {
    // Fails only where there is a logger already, which then goes on.
    if log::set_boxed_logger(Box::new(Tee { terminal })).is_ok() {
        log::set_max_level(terminal_level.max(KEPT));
    }
}

struct Tee {
    terminal: Box<dyn Log>,
}

/// Whether a message belongs into the book.
fn is_kept(metadata: &Metadata<'_>) -> bool {
    let ours = metadata.target() == "relief" || metadata.target().starts_with("relief::");
    metadata.level() <= if ours { Level::Info } else { Level::Warn }
}

impl Log for Tee {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        is_kept(metadata) || self.terminal.enabled(metadata)
    }

    fn log(&self, record: &Record<'_>) {
        if is_kept(record.metadata()) {
            note(record.level(), record.target(), &record.args().to_string());
        }
        self.terminal.log(record);
    }

    fn flush(&self) {
        self.terminal.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Silent;

    impl Log for Silent {
        fn enabled(&self, _: &Metadata<'_>) -> bool {
            false
        }
        fn log(&self, _: &Record<'_>) {}
        fn flush(&self) {}
    }

    /// One test for the one book: tests run side by side.
    #[test]
    fn the_book_keeps_our_words_and_the_warnings_of_others_and_no_more_than_it_should() {
        let tee = Tee { terminal: Box::new(Silent) };
        let say = |target: &str, level: Level, text: &str| {
            tee.log(&Record::builder().args(format_args!("{text}")).level(level).target(target).build());
        };
        let before = revision();
        say("relief::app", Level::Info, "logbook: ours");
        say("relief::app", Level::Debug, "logbook: too small");
        say("wgpu_core", Level::Info, "logbook: chatter");
        say("wgpu_core", Level::Warn, "logbook: a warning");
        note(Level::Error, "viewer", &"logbook: x".repeat(LONGEST));
        let ours = || entries().into_iter().filter(|entry| entry.text.starts_with("logbook:")).collect::<Vec<_>>();
        let texts: Vec<String> = ours().into_iter().map(|entry| entry.text.chars().take(20).collect()).collect();
        assert_eq!(texts[..2], ["logbook: ours", "logbook: a warning"]);
        assert_eq!((texts.len(), ours()[2].text.chars().count()), (3, LONGEST));
        assert!(revision() >= before + 3);
        for _ in 0..MOST + 5 {
            note(Level::Info, "test", "logbook: many");
        }
        assert_eq!(entries().len(), MOST);
        clear();
        assert!(ours().is_empty());
    }
}
