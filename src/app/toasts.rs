//! Messages over the picture. Those that only inform vanish by themselves; errors stay until they are dismissed.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use egui::accesskit::{Live, Role};
use egui::{Color32, Context, Id};
use egui_notify::{Anchor, Toast, ToastLevel, Toasts as Stack};

use crate::logbook;

/// How long a message that only informs stays.
const LIFETIME: Duration = Duration::from_secs(6);

/// Longest line of a message in characters.
const LINE: usize = 64;

/// How many messages the status file repeats.
const HISTORY: usize = 16;

/// All messages on screen.
///
/// Lifetimes are kept here and not by the stacks, because a stack that counts down draws a frame for every tick.
pub(crate) struct Toasts {
    passing: Stack,
    staying: Stack,
    expiries: VecDeque<Instant>,
    history: VecDeque<String>,
}

impl Default for Toasts {
    fn default() -> Self {
        Self {
            passing: Stack::new().with_anchor(Anchor::TopRight),
            staying: Stack::new().with_anchor(Anchor::BottomRight),
            expiries: VecDeque::new(),
            history: VecDeque::new(),
        }
    }
}

impl Toasts {
    /// Tells that something went well.
    pub(crate) fn info(&mut self, message: &str, now: Instant) {
        logbook::note(log::Level::Info, "viewer", message);
        self.add_passing(message, ToastLevel::Info, now);
    }

    /// Tells something that the user should know, and that changes nothing.
    pub(crate) fn warning(&mut self, message: &str, now: Instant) {
        log::warn!("{message}");
        self.add_passing(message, ToastLevel::Warning, now);
    }

    /// Tells that something failed. It stays on screen until it is dismissed, so the terminal need not repeat it.
    pub(crate) fn error(&mut self, message: &str) {
        log::debug!("{message}");
        logbook::note(log::Level::Error, "viewer", message);
        self.remember(message);
        let level = ToastLevel::Custom("⚠".into(), Color32::from_rgb(230, 90, 80));
        self.staying.add(toast(message, level));
    }

    /// Dismisses the errors. Says whether there were any.
    pub(crate) fn dismiss_errors(&mut self) -> bool {
        let any = !self.staying.is_empty();
        self.staying.dismiss_all_toasts();
        any
    }

    /// The last messages, oldest first.
    pub(crate) fn history(&self) -> impl Iterator<Item = &str> {
        self.history.iter().map(String::as_str)
    }

    /// Draws the messages and asks for the frame in which the next one vanishes.
    pub(crate) fn show(&mut self, ctx: &Context, now: Instant) {
        // A message closed by hand takes an expiry with it; one that still fades out delays the next by its fading.
        self.expiries.drain(..self.expiries.len().saturating_sub(self.passing.len()));
        if self.expiries.front().is_some_and(|expiry| *expiry <= now) && self.passing.len() == self.expiries.len() {
            self.expiries.pop_front();
            self.passing.dismiss_oldest_toast();
        }
        self.passing.show(ctx);
        self.staying.show(ctx);
        if let Some(expiry) = self.expiries.front() {
            ctx.request_repaint_after(expiry.saturating_duration_since(now));
        }
        if let Some(message) = self.history.back().filter(|_| !self.passing.is_empty() || !self.staying.is_empty()) {
            // The stacks only paint, so the newest message is announced here.
            ctx.accesskit_node_builder(Id::unique("newest message"), |node| {
                node.set_role(Role::Status);
                node.set_live(Live::Polite);
                node.set_label(message.as_str());
            });
        }
    }

    fn add_passing(&mut self, message: &str, level: ToastLevel, now: Instant) {
        self.remember(message);
        self.passing.add(toast(message, level));
        self.expiries.push_back(now + LIFETIME);
    }

    fn remember(&mut self, message: &str) {
        self.history.push_back(message.into());
        while self.history.len() > HISTORY {
            self.history.pop_front();
        }
    }
}

fn toast(message: &str, level: ToastLevel) -> Toast {
    let mut toast = Toast::custom(wrap(&plain(message), LINE), level);
    toast.duration(None).closable(true).show_progress_bar(false);
    toast
}

/// The message with nothing in it that the interface's font cannot write: the frames that compilers draw around code.
pub(crate) fn plain(message: &str) -> String {
    let letter = |letter: char| match letter {
        '\t' => ' ',
        '│' | '┃' | '║' | '╎' | '┆' | '┊' => '|',
        '─' | '━' | '═' | '╌' | '┄' | '┈' => '-',
        '\u{2500}'..='\u{257f}' => '+',
        letter => letter,
    };
    message.chars().map(letter).collect()
}

/// Breaks a message into lines of at most `width` characters, at spaces where there are any: the stack does not wrap.
fn wrap(message: &str, width: usize) -> String {
    let mut lines: Vec<String> = Vec::new();
    for paragraph in message.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            for piece in pieces(word, width) {
                let used = line.chars().count();
                if used > 0 && used + 1 + piece.chars().count() > width {
                    lines.push(std::mem::take(&mut line));
                }
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(&piece);
            }
        }
        lines.push(line);
    }
    lines.join("\n")
}

/// A word, cut into pieces where it is longer than a line, as paths are.
fn pieces(word: &str, width: usize) -> impl Iterator<Item = String> {
    let letters: Vec<char> = word.chars().collect();
    let cut: Vec<String> = letters.chunks(width).map(|piece| piece.iter().collect()).collect();
    cut.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(ctx: &Context, toasts: &mut Toasts, time: f64, now: Instant) -> Duration {
        let input = egui::RawInput { time: Some(time), ..Default::default() };
        let mut output = ctx.run_ui(input, |ui| toasts.show(ui.ctx(), now));
        let delay = output.viewport_output.values().map(|viewport| viewport.repaint_delay).min();
        output.textures_delta.clear();
        delay.unwrap_or(Duration::MAX)
    }

    #[test]
    fn long_messages_and_long_words_are_wrapped() {
        let wrapped = wrap(&format!("cannot open {}: it is empty\nsecond line", "x".repeat(150)), 64);
        assert!(wrapped.lines().all(|line| line.chars().count() <= 64), "{wrapped}");
        assert_eq!(wrapped.matches('x').count(), 150);
        assert!(wrapped.ends_with("\nsecond line"));
        assert_eq!(wrap("größer als 8192", 64), "größer als 8192");
    }

    /// The compiler's messages come without the frames around code, which would be empty boxes.
    #[test]
    fn a_compilers_message_loses_its_frames() {
        let message = "error: expected `;`\n  ┌─ sky.wgsl:3:1\n  │\n3 │ \tfn\n  │ ^^ here\n  ╰─ note → more … ═ ┃";
        let said = plain(message);
        let framed = |text: &str| text.contains(|letter| ('\u{2500}'..='\u{257f}').contains(&letter) || letter == '\t');
        assert!(framed(message) && !framed(&said), "{said}");
        assert_eq!(said.lines().nth(3), Some("3 |  fn"));
    }

    #[test]
    fn messages_vanish_errors_stay_and_idle_frames_are_not_drawn() {
        let ctx = Context::default();
        let mut toasts = Toasts::default();
        let start = Instant::now();
        toasts.info("saved", start);
        toasts.error("broken");
        let mut time = 0.0;
        let mut run = |toasts: &mut Toasts, now: Instant| {
            // Long enough for every animation to end.
            for _ in 0..40 {
                time += 0.1;
                pass(&ctx, toasts, time, now);
            }
            time += 0.1;
            pass(&ctx, toasts, time, now)
        };
        let delay = run(&mut toasts, start);
        assert_eq!((toasts.passing.len(), toasts.staying.len()), (1, 1));
        assert!(delay > Duration::from_secs(5), "a message at rest asks for no frame, but for one after {delay:?}");
        run(&mut toasts, start + LIFETIME);
        assert_eq!((toasts.passing.len(), toasts.staying.len()), (0, 1));
        assert!(toasts.dismiss_errors());
        run(&mut toasts, start + LIFETIME);
        assert!(toasts.staying.is_empty() && !toasts.dismiss_errors());
        assert_eq!(toasts.history().collect::<Vec<_>>(), ["saved", "broken"]);
    }
}
