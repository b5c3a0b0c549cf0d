//! Error against time of the techniques, for the view on screen.

use std::ops::RangeInclusive;

use egui::{Color32, ProgressBar, Sense, Ui, vec2};
use egui_plot::{GridMark, HoverPosition, Line, MarkerShape, Plot, Points};

use super::Panel;
use super::widgets::{button, button_unless, section};
use crate::app::settings::Command;
use crate::app::tradeoff::Setting;
use crate::scene::Technique;

/// Height of the plot, points.
const HEIGHT: f32 = 240.0;

/// Error in cells below which a point is drawn on the plot's lower edge: a logarithm has no zero.
const LEAST_ERROR: f64 = 1e-6;

/// Colours and shapes of the techniques, in their order: told apart by colour-blind eyes (Okabe, Ito 2008), too. The
/// report's plot has the same colours.
const LOOKS: [(Color32, MarkerShape); 6] = [
    (Color32::from_rgb(230, 159, 0), MarkerShape::Circle),
    (Color32::from_rgb(86, 180, 233), MarkerShape::Square),
    (Color32::from_rgb(0, 158, 115), MarkerShape::Up),
    (Color32::from_rgb(204, 121, 167), MarkerShape::Diamond),
    (Color32::from_rgb(0, 114, 178), MarkerShape::Down),
    (Color32::from_rgb(213, 94, 0), MarkerShape::Asterisk),
];

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Takes the plot away, and ends a measurement that is under way. Free.";
    section(ui, "Tradeoff", false, Some(reset), |ui, reset| {
        if reset {
            panel.commands.push(Command::ForgetTradeoff);
        }
        let progress = panel.tradeoff.progress();
        let tooltip = "Measures the view on screen with each technique, and a few sample counts of those that count samples: \
                       milliseconds per frame, and the distance error against max-mipmap in cells. Takes some hundred \
                       frames, one between two of the window's own, once the cones are found that are needed.";
        let busy = progress.map(|_| "a measurement is under way");
        if button_unless(ui, "Measure techniques", tooltip, busy) {
            panel.commands.push(Command::MeasureTradeoff);
        }
        // Remembered from frame to frame, so that the plot is scrolled to once: when it comes.
        let awaited = ui.scope_id().with("awaited");
        if let Some(progress) = progress {
            ui.data_mut(|data| data.insert_temp(awaited, true));
            ui.add(ProgressBar::new(progress).show_percentage());
            ui.label(panel.tradeoff.progress_in_words().unwrap_or_default());
            if button(ui, "Cancel measurement", "Ends the measurement; what it has found so far is lost. Free.") {
                panel.commands.push(Command::ForgetTradeoff);
            }
        }
        let results = panel.tradeoff.results();
        if results.is_empty() {
            return;
        }
        let shown = ui.scope(|ui| {
            if let Some(words) = panel.tradeoff.outdated(panel.scene) {
                ui.weak(words);
            }
            curves(ui, results);
        });
        if ui.data_mut(|data| data.remove_temp::<bool>(awaited)).is_some() {
            shown.response.scroll_to_me(None);
        }
    });
}

/// The plot with its legend.
fn curves(ui: &mut Ui, results: &[Setting]) {
    ui.label("Error in cells (99% of the pixels) over ms per frame");
    plot(ui, results);
    // The legend: in the plot, it would cover curves.
    ui.horizontal_wrapped(|ui| {
        for (technique, (colour, _)) in looks() {
            ui.colored_label(colour, format!("● {}", technique.name()));
        }
    });
    ui.weak(format!("Left and low is better. On the lower edge: {LEAST_ERROR:e} cells or less."));
}

/// The results, both axes logarithmic: a curve for each technique.
fn plot(ui: &mut Ui, results: &[Setting]) {
    let describe = |position: &HoverPosition<'_>| match position {
        HoverPosition::NearDataPoint { plot_name, position, .. } if !plot_name.is_empty() => {
            let (ms, cells) = (number(position.x), number(position.y));
            Some(format!("{plot_name}\n{ms} ms per frame, median\n{cells} cells, 99% of the pixels"))
        }
        _ => None,
    };
    let plot = Plot::new("tradeoff").height(HEIGHT).sense(Sense::hover());
    let plot = plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false);
    let plot = plot
        .x_grid_spacer(|input| decades(input.bounds))
        .y_grid_spacer(|input| decades(input.bounds))
        .set_margin_fraction(vec2(0.1, 0.1));
    let plot = plot.x_axis_formatter(axis_number).y_axis_formatter(axis_number).label_formatter(describe);
    plot.show(ui, |ui| {
        for (technique, (colour, shape)) in looks() {
            let of_technique = results.iter().filter(|setting| setting.technique == technique);
            let places: Vec<[f64; 2]> = of_technique.filter_map(place).collect();
            ui.line(Line::new(technique.name(), places.clone()).color(colour).allow_hover(false));
            ui.points(Points::new(technique.name(), places).color(colour).shape(shape).radius(4.5));
        }
    });
}

/// Every technique with its colour and marker.
fn looks() -> impl Iterator<Item = (Technique, (Color32, MarkerShape))> {
    Technique::ALL.into_iter().zip(LOOKS.into_iter().cycle())
}

/// Where a setting stands: powers of ten of milliseconds and cells.
fn place(setting: &Setting) -> Option<[f64; 2]> {
    let (ms, error) = (setting.milliseconds()?, setting.error?);
    (ms > 0.0).then(|| [ms.log10(), error.max(LEAST_ERROR).log10()])
}

/// A grid line for 1, 2 and 5 of each power of ten; the powers are the strong ones.
fn decades((low, high): (f64, f64)) -> Vec<GridMark> {
    let powers = low.floor() as i64..=high.ceil() as i64;
    let marks = powers.flat_map(|power| {
        [(1.0_f64, 1.0), (2.0, 0.3), (5.0, 0.3)]
            .map(|(digit, step_size)| GridMark { value: power as f64 + digit.log10(), step_size })
    });
    marks.filter(|mark| (low..=high).contains(&mark.value)).collect()
}

fn axis_number(mark: GridMark, _: &RangeInclusive<f64>) -> String {
    number(mark.value)
}

/// Ten to a power, for people.
fn number(power: f64) -> String {
    let value = 10f64.powf(power);
    if value >= 100.0 {
        format!("{value:.0}")
    } else if value >= 0.01 {
        let text = format!("{value:.2}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_labelled_with_numbers_and_not_with_powers() {
        assert_eq!([2.0, 0.0, -1.0, -5.0].map(number), ["100", "1", "0.1", "1e-5"]);
        assert_eq!(number(50f64.log10()), "50");
        let marks = decades((-0.5, 1.1));
        let values: Vec<String> = marks.iter().map(|mark| number(mark.value)).collect();
        assert_eq!(values, ["0.5", "1", "2", "5", "10"]);
    }
}
