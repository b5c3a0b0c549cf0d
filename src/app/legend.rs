//! What the colours of the land and its lines mean, or those of a heat map: beside the picture, and in saved ones.

use egui::{Align2, Color32, Context, Mesh, Rect, Sense, Shape, Ui, pos2, vec2};

use super::overlay::{self, boxed};
use crate::heightfield::HeightField;
use crate::scene::land::{LandScale, number, round_interval};
use crate::scene::{DebugView, GroundColour, LandSettings, Scene, ramp};

/// Widest the scale is, points; a narrow window has less room.
const WIDEST: f32 = 360.0;

/// Distance from the borders, points.
const MARGIN: f32 = 10.0;

/// Colours in a scale.
const STOPS: u32 = 128;

/// What the errors of the error view are against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Against {
    /// The reference in f64, not the exact technique.
    pub(crate) reference: bool,
    /// The reference is being waited for.
    pub(crate) awaited: bool,
}

/// Whether the picture of `scene` has a legend.
pub(crate) fn exists(scene: &Scene) -> bool {
    match scene.debug.view {
        DebugView::Steps | DebugView::Error => true,
        DebugView::None => scene.land.has_legend(),
        _ => false,
    }
}

/// The legend of `scene` in the lower left corner of the part that the panel leaves free. Where its box is, if there is one.
pub(crate) fn show(ctx: &Context, free: Rect, scene: &Scene, map: &HeightField, errors: Against) -> Option<Rect> {
    exists(scene).then(|| match scene.debug.view {
        DebugView::Steps => overlay::legend(ctx, free, scene.debug.heat_map_max),
        DebugView::Error => overlay::error_legend(ctx, free, errors),
        _ => land_legend(ctx, free, &scene.land, map),
    })
}

fn land_legend(ctx: &Context, free: Rect, land: &LandSettings, map: &HeightField) -> Rect {
    let scale = land.scale(map);
    let corner = free.left_bottom() + vec2(MARGIN, -MARGIN);
    boxed(ctx, "land legend", (Align2::LEFT_BOTTOM, corner), |ui| {
        let width = (free.width() - 4.0 * MARGIN).clamp(120.0, WIDEST);
        match land.colour {
            GroundColour::Texture => {}
            GroundColour::Ramp => {
                ui.label(format!("Height{}, {}", if scale.metric { " in metres" } else { "" }, land.ramp.name()));
                let [first, last] = shown_part(&scale);
                bar(ui, width, |share| land.ramp.colour((first + f64::from(share) * (last - first)) as f32));
                let marks = height_marks(&scale);
                numbers(ui, width, &marks);
            }
            GroundColour::Slope => {
                let drawn = if map.extent_metres().is_some() { "" } else { ", as drawn" };
                ui.label(format!("Slope in degrees{drawn}"));
                bar(ui, width, ramp::slope_colour);
                let marks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (share, number(share * land.slope_max)));
                numbers(ui, width, &marks);
            }
            GroundColour::Aspect => {
                ui.label("Direction in which the ground falls; grey is level");
                bar(ui, width, ramp::aspect_colour);
                let names = ["N", "NE", "E", "SE", "S", "SW", "W", "NW", "N"];
                let marks: Vec<_> = (0u8..).zip(names).map(|(i, name)| (f64::from(i) / 8.0, name.to_owned())).collect();
                numbers(ui, width, &marks);
            }
        }
        if land.contours {
            let words = scale.contours_in_words();
            ui.label(words.replacen("contours", "Contours", 1));
        }
    })
}

/// The part of a ramp that heights have, as shares of it: where all land lies above the sea, none has the sea's half.
fn shown_part(scale: &LandScale) -> [f64; 2] {
    match (scale.low < scale.middle, scale.middle < scale.high) {
        (true, false) => [0.0, 0.5],
        (false, _) => [0.5, 1.0],
        (true, true) => [0.0, 1.0],
    }
}

/// Shares of the bar and the heights there: the ends and the middle first, then round ones as far as there is room.
fn height_marks(scale: &LandScale) -> Vec<(f64, String)> {
    let mut marks = vec![(0.0, number(rounded(scale.low, scale))), (1.0, number(rounded(scale.high, scale)))];
    let breaks = scale.low < scale.middle && scale.middle < scale.high;
    if breaks && (scale.share(scale.middle) - 0.5).abs() < 1e-9 && scale.middle == 0.0 {
        marks.push((0.5, "0".to_owned()));
    }
    let step = round_interval((scale.high - scale.low) / 10.0);
    let first = (scale.low / step).ceil();
    let round = (0..16).map(|index| (first + f64::from(index)) * step);
    let [from, to] = shown_part(scale);
    let place = |at: f64| (scale.share(at) - from) / (to - from);
    marks.extend(round.filter(|at| *at > scale.low && *at < scale.high).map(|at| (place(at), number(at))));
    marks
}

/// A height with no more digits than the range asks for.
fn rounded(height: f64, scale: &LandScale) -> f64 {
    let step = round_interval((scale.high - scale.low) / 2000.0).min(1.0);
    let to = (height / step).round() * step;
    // What a multiplication leaves behind.
    (to * 1e6).round() / 1e6
}

fn bar(ui: &mut Ui, width: f32, colour: impl Fn(f32) -> [u8; 3]) {
    let (response, painter) = ui.allocate_painter(vec2(width, 14.0), Sense::hover());
    let rect = response.rect;
    let mut mesh = Mesh::default();
    // Each piece has one colour: bands keep their edges.
    for stop in 0..STOPS {
        let [from, to] = [stop, stop + 1].map(|stop| rect.left() + stop as f32 / STOPS as f32 * rect.width());
        let [red, green, blue] = colour((stop as f32 + 0.5) / STOPS as f32);
        mesh.add_colored_rect(
            Rect::from_min_max(pos2(from, rect.top()), pos2(to, rect.bottom())),
            Color32::from_rgb(red, green, blue),
        );
    }
    painter.add(Shape::mesh(mesh));
}

/// Texts below the bar; those that come first win where two would touch.
fn numbers(ui: &mut Ui, width: f32, marks: &[(f64, String)]) {
    let (font, colour) = (egui::TextStyle::Body.resolve(ui.style()), ui.visuals().text_color());
    let (row, painter) = ui.allocate_painter(vec2(width, 18.0), Sense::hover());
    let mut taken: Vec<Rect> = Vec::new();
    for (share, text) in marks {
        let text = painter.layout_no_wrap(text.clone(), font.clone(), colour);
        let middle = row.rect.left() + *share as f32 * width;
        let left = (middle - text.size().x * 0.5).clamp(row.rect.left(), row.rect.right() - text.size().x);
        let place = Rect::from_min_size(pos2(left, row.rect.top()), text.size());
        if taken.iter().all(|other| !other.expand2(vec2(8.0, 0.0)).intersects(place)) {
            taken.push(place);
            painter.galley(place.min, text, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_names_its_ends_sea_level_and_round_heights_between() {
        let raw = [-4800.6f64, 1713.4, 0.0, 0.0];
        let map = HeightField::from_raw(2, 2, &raw).unwrap().with_metres(true);
        let marks = height_marks(&LandSettings::default().scale(&map));
        let named = |text: &str| marks.iter().find(|(_, name)| name == text).map(|(share, _)| *share);
        assert_eq!((named("-4801"), named("1713"), named("0")), (Some(0.0), Some(1.0), Some(0.5)));
        assert!((named("-2000").unwrap() - 0.5 * (1.0 - 2000.0 / 4800.6)).abs() < 1e-9, "{marks:?}");
        // Nothing lies below the sea: the bar has the land's colours alone, and heights where those are.
        let land = HeightField::from_raw(2, 2, &[500.0f64, 1500.0, 500.0, 500.0]).unwrap().with_metres(true);
        let scale = LandSettings::default().scale(&land);
        assert_eq!(shown_part(&scale), [0.5, 1.0]);
        let middle = height_marks(&scale).into_iter().find(|(_, name)| name == "1000").unwrap();
        assert!((middle.0 - 0.5).abs() < 1e-9, "{middle:?}");
        let flat = HeightField::from_raw(2, 2, &[7.0f64; 4]).unwrap();
        assert_eq!(height_marks(&LandSettings::default().scale(&flat)).len(), 2);
    }
}
