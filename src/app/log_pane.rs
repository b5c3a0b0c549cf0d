//! The log: the last messages of the program at the bottom of the window, by level, to be searched and copied.

use std::time::SystemTime;

use egui::{Align, Color32, ComboBox, Context, Label, Layout, Panel, RichText, ScrollArea, TextEdit, Ui};
use log::Level;

use crate::logbook::{self, Entry};

/// Height of a new pane, points.
const HEIGHT: f32 = 190.0;

/// Levels that can be chosen, gravest first, with their names.
const LEVELS: [(Level, &str); 3] =
    [(Level::Error, "Errors"), (Level::Warn, "Errors and warnings"), (Level::Info, "All messages")];

/// The pane.
#[derive(Clone, Debug)]
pub(crate) struct LogPane {
    /// It shows.
    pub(crate) open: bool,
    level: Level,
    filter: String,
    /// The revision of the book that is on screen.
    shown: u64,
}

impl Default for LogPane {
    fn default() -> Self {
        Self { open: false, level: Level::Info, filter: String::new(), shown: 0 }
    }
}

impl LogPane {
    /// Whether there is something new to show.
    pub(crate) fn is_stale(&self) -> bool {
        self.open && self.shown != logbook::revision()
    }

    /// Draws the pane along the bottom of `ui`, where it is open.
    pub(crate) fn show(&mut self, ui: &mut Ui) {
        if !self.open {
            return;
        }
        let room = (ui.available_height() * 0.7).max(80.0);
        let panel = Panel::bottom("log").resizable(true).default_size(HEIGHT.min(room)).size_range(80.0..=room);
        panel.show(ui, |ui| {
            self.shown = logbook::revision();
            let entries: Vec<Entry> = logbook::entries().into_iter().filter(|entry| self.wants(entry)).collect();
            self.bar(ui, &entries);
            ui.separator();
            ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
                if entries.is_empty() {
                    ui.weak("No messages.");
                }
                entries.iter().for_each(|entry| row(ui, entry));
            });
        });
    }

    fn bar(&mut self, ui: &mut Ui, entries: &[Entry]) {
        ui.horizontal_wrapped(|ui| {
            ui.strong("Log");
            let chosen = LEVELS.iter().find(|(level, _)| *level == self.level).map_or("", |(_, name)| name);
            let list = ComboBox::from_id_salt("log level").selected_text(chosen).width(150.0).show_ui(ui, |ui| {
                for (level, name) in LEVELS {
                    ui.selectable_value(&mut self.level, level, name);
                }
            });
            list.response.on_hover_text("How grave a message has to be to show here.").accessible_name("Log level");
            let field = TextEdit::singleline(&mut self.filter).hint_text("find").desired_width(140.0);
            ui.add(field).on_hover_text("Only messages with this text.").accessible_name("Find in log");
            if ui.button("Copy log").on_hover_text("Copies the messages that show, a line each.").clicked() {
                ui.copy_text(entries.iter().map(|entry| line(entry) + "\n").collect());
            }
            if ui.button("Clear log").on_hover_text("Forgets all messages.").clicked() {
                logbook::clear();
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Close log").on_hover_text("Closes the log (F4).").clicked() {
                    self.open = false;
                }
            });
        });
    }

    fn wants(&self, entry: &Entry) -> bool {
        entry.level <= self.level && entry.text.to_lowercase().contains(&self.filter.trim().to_lowercase())
    }
}

/// A message's level as a word of always the same width: colour alone says nothing to some.
fn word(level: Level) -> &'static str {
    match level {
        Level::Error => "ERROR",
        Level::Warn => "warn ",
        _ => "info ",
    }
}

fn colour(ctx: &Context, level: Level) -> Color32 {
    let visuals = &ctx.global_style().visuals;
    match level {
        Level::Error => visuals.error_fg_color,
        Level::Warn => visuals.warn_fg_color,
        _ => visuals.text_color(),
    }
}

fn row(ui: &mut Ui, entry: &Entry) {
    let colour = colour(ui.ctx(), entry.level);
    ui.horizontal_top(|ui| {
        ui.label(RichText::new(clock(entry.time)).monospace().weak());
        ui.label(RichText::new(word(entry.level)).monospace().strong().color(colour));
        ui.add(Label::new(&entry.text).wrap());
    });
}

fn line(entry: &Entry) -> String {
    format!("{} {} {}: {}", clock(entry.time), word(entry.level), entry.source, entry.text)
}

/// The time of day, UTC: the local one would need a table of time zones.
fn clock(time: SystemTime) -> String {
    let seconds = time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |passed| passed.as_secs());
    let [hours, minutes, seconds] = [seconds / 3600 % 24, seconds / 60 % 60, seconds % 60];
    format!("{hours:02}:{minutes:02}:{seconds:02}Z")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn messages_are_filtered_by_level_and_text_and_written_in_a_line() {
        let entry = |level, text: &str| Entry {
            time: SystemTime::UNIX_EPOCH + Duration::from_secs(86_400 + 3_723),
            level,
            source: "relief".into(),
            text: text.into(),
        };
        let mut pane = LogPane { filter: " NO room ".into(), ..LogPane::default() };
        assert!(pane.wants(&entry(Level::Info, "there is no room left")));
        assert!(!pane.wants(&entry(Level::Error, "something else")));
        pane.level = Level::Warn;
        assert!(!pane.wants(&entry(Level::Info, "no room")) && pane.wants(&entry(Level::Error, "no room")));
        assert_eq!(line(&entry(Level::Error, "no room")), "01:02:03Z ERROR relief: no room");
    }
}
