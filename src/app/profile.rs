//! The profile between two clicks: its numbers, its plot, and the file it is exported to.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use egui::{Align2, Context, Id, Rect, Sense, vec2};
use egui_plot::{AxisHints, GridInput, Line, Plot, PlotPoints, uniform_grid_spacer};

use super::settings::Command;
use super::viewer::Viewer;
use crate::files;
use crate::heightfield::HeightField;
use crate::heightfield::survey::Profile;
use crate::scene::land::{number, round_interval};

/// Size of the plot, points.
const SIZE: [f32; 2] = [380.0, 150.0];

/// Highest number in a file name before the search for a free one gives up.
const LAST_NUMBER: u32 = 9999;

/// Most points of the plot's line: more than it has pixels across.
const MOST_POINTS: usize = 2000;

/// Numbers on an axis of the plot, about.
const MOST_STEPS: f64 = 4.0;

/// Distance from one of them to the next at which it is drawn, and drawn whole. Points.
const LABELS: egui::Rangef = egui::Rangef { min: 16.0, max: 17.0 };

/// What the profile's window asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    /// Write it as CSV.
    Export,
    /// End measuring.
    End,
}

/// Shows the profile in the lower right corner, from where it can be moved; without one, what to click. `free` is what the
/// panel leaves free.
pub(crate) fn show(ctx: &Context, free: Rect, profile: Option<&Profile>, map: &HeightField) -> Option<Asked> {
    let mut asked = None;
    let window = egui::Window::new("Profile").id(Id::unique("profile")).collapsible(false).resizable(false);
    let corner = free.right_bottom() - vec2(12.0, 12.0);
    window.pivot(Align2::RIGHT_BOTTOM).default_pos(corner).show(ctx, |ui| {
        match profile {
            None => {
                ui.label("Click two places on the ground.");
            }
            Some(profile) => {
                for line in in_lines(profile, map) {
                    ui.label(line);
                }
                plot(ui, profile, map);
            }
        }
        ui.horizontal(|ui| {
            let tooltip =
                "Writes distance, height and place of every point to a CSV file in the folder for screenshots.";
            let export = ui.add_enabled(profile.is_some(), egui::Button::new("Export profile")).on_hover_text(tooltip);
            if export.clicked() {
                asked = Some(Asked::Export);
            }
            if ui.button("End measuring").on_hover_text("Takes the line and the profile away (Esc). Free.").clicked() {
                asked = Some(Asked::End);
            }
        });
    });
    asked
}

impl Viewer {
    /// Shows the profile and does what its window asks for.
    pub(super) fn show_profile(&mut self, ctx: &Context, commands: &mut Vec<Command>, now: Instant) {
        let profile = self.view.reading.profile.as_ref();
        match show(ctx, self.free, profile, &self.map) {
            Some(Asked::End) => commands.push(Command::Measure(false)),
            Some(Asked::Export) => {
                let saved = profile.map(|profile| save(&self.screenshots, profile, &self.map));
                match saved {
                    Some(Ok(path)) => self.toasts.info(&format!("Saved {}", path.display()), now),
                    Some(Err(error)) => {
                        let folder = self.screenshots.display();
                        self.toasts.error(&format!(
                            "The profile was not written to {folder}: {error}. Free some space, or start in a folder that \
                             can be written to."
                        ));
                    }
                    None => {}
                }
            }
            None => {}
        }
    }
}

/// Lengths and heights in words.
fn in_lines(profile: &Profile, map: &HeightField) -> [String; 3] {
    let length = |value: f64| match profile.metric {
        true if value >= 10_000.0 => format!("{:.3} km", value / 1000.0),
        true => format!("{value:.1} m"),
        false => format!("{value:.4} map sides"),
    };
    let height = |value: f64| {
        if map.has_metres() { format!("{value:.1} m") } else { number(value) }
    };
    let [climb, descent] = profile.climb_and_descent;
    [
        format!(
            "Level {}, straight {}, along the ground {}",
            length(profile.level),
            length(profile.straight),
            length(profile.along_ground)
        ),
        format!("Rise {}, climb {}, descent {}", height(profile.rise), height(climb), height(descent)),
        format!("Steepest {:.1}°{}", profile.steepest, if profile.metric { "" } else { " as drawn" }),
    ]
}

fn plot(ui: &mut egui::Ui, profile: &Profile, map: &HeightField) {
    let (unit, scale) = match profile.metric {
        true if profile.level >= 10_000.0 => ("km", 1e-3),
        true => ("m", 1.0),
        false => ("map sides", 1.0),
    };
    let heights = if map.has_metres() { " m" } else { "" };
    let plot = Plot::new("profile").width(SIZE[0]).height(SIZE[1]).sense(Sense::hover());
    let plot = plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false);
    // A few round numbers on either axis: egui_plot's own lie too close together in so small a plot, and are left out.
    let round = |input: GridInput| {
        let step = round_interval((input.bounds.1 - input.bounds.0) / MOST_STEPS);
        [step, 10.0 * step, 100.0 * step]
    };
    let plot = plot.x_grid_spacer(uniform_grid_spacer(round)).y_grid_spacer(uniform_grid_spacer(round));
    let height = if heights.is_empty() { "height" } else { "height, m" };
    let axes = [AxisHints::new_x().label(format!("distance, {unit}")), AxisHints::new_y().label(height)];
    let [x, y] = axes.map(|axis| axis.label_spacing(LABELS));
    let plot = plot.custom_x_axes(vec![x]).custom_y_axes(vec![y]);
    // As clear on white as on black.
    let colour = if ui.visuals().dark_mode { [230, 159, 0] } else { [165, 90, 0] };
    let colour = egui::Color32::from_rgb(colour[0], colour[1], colour[2]);
    plot.show(ui, |ui| {
        for piece in pieces(profile) {
            let points: PlotPoints<'_> =
                piece.into_iter().map(|[distance, height]| [distance * scale, height]).collect();
            ui.line(Line::new("ground", points).color(colour).width(2.0));
        }
    });
}

/// Distances and heights without a hole between, thinned to what can be seen.
fn pieces(profile: &Profile) -> Vec<Vec<[f64; 2]>> {
    let every = profile.points.len().div_ceil(MOST_POINTS).max(1);
    let last = profile.points.len().saturating_sub(1);
    let shown = profile.points.iter().enumerate().filter(|(index, _)| index % every == 0 || *index == last);
    let mut pieces = vec![Vec::new()];
    for (_, point) in shown {
        match (point.height, pieces.last_mut()) {
            (Some(height), Some(piece)) => piece.push([point.distance, height]),
            _ => pieces.push(Vec::new()),
        }
    }
    pieces.retain(|piece: &Vec<_>| !piece.is_empty());
    pieces
}

/// Writes the profile to `folder` as `relief-profile-0001.csv`, or the next free number, and returns the file's path.
///
/// # Errors
/// What the system says; nothing is left behind then.
pub(crate) fn save(folder: &Path, profile: &Profile, map: &HeightField) -> io::Result<PathBuf> {
    std::fs::create_dir_all(folder)?;
    let free = (1..=LAST_NUMBER).map(|number| folder.join(format!("relief-profile-{number:04}.csv")));
    let path = free.into_iter().find(|path| !path.exists());
    let path =
        path.ok_or_else(|| io::Error::new(io::ErrorKind::AlreadyExists, "all names are taken; move some files away"))?;
    files::write_whole(&path, profile.to_csv(map).as_bytes())?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::survey::{Point, Survey};

    fn map() -> HeightField {
        let raw: Vec<f64> = (0..25).map(|index| 100.0 - 50.0 * f64::from((index % 5i32 - 2).abs())).collect();
        HeightField::from_raw(5, 5, &raw).unwrap().with_extent_metres(Some([200.0, 200.0]))
    }

    #[test]
    fn lengths_are_told_in_metres_where_they_are_known() {
        let over = Survey::new(&map(), 1.0).profile([0.0, 0.5], [1.0, 0.5]);
        let lines = in_lines(&over, &map());
        assert_eq!(lines[0], "Level 200.0 m, straight 200.0 m, along the ground 282.8 m");
        assert_eq!(lines[1], "Rise 0.0 m, climb 100.0 m, descent 100.0 m");
        assert_eq!(lines[2], "Steepest 45.0°");
    }

    #[test]
    fn files_are_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let way = Survey::new(&map(), 1.0).profile([0.0, 0.5], [1.0, 0.5]);
        let names = [0, 1].map(|_| save(folder.path(), &way, &map()).unwrap());
        assert!(names[0].ends_with("relief-profile-0001.csv") && names[1].ends_with("relief-profile-0002.csv"));
        assert!(std::fs::read_to_string(&names[0]).unwrap().starts_with("distance_m,"));
        std::fs::write(folder.path().join("file"), "").unwrap();
        assert!(save(&folder.path().join("file"), &way, &map()).is_err());
    }

    #[test]
    fn a_hole_breaks_the_line() {
        let mut way = Survey::new(&map(), 1.0).profile([0.0, 0.5], [1.0, 0.5]);
        assert_eq!(pieces(&way).len(), 1);
        way.points[3] = Point { height: None, ..way.points[3] };
        assert_eq!(pieces(&way).len(), 2);
    }
}
