//! What lies over the picture: frame times, steps and the ledger, the heat maps' legends, the split line, crosshair, help
//! and hints.

use egui::{
    Align2, Area, Color32, Context, Frame, Grid, Id, Mesh, Order, Pos2, Rangef, Rect, RichText, ScrollArea, Sense,
    Shape, Stroke, StrokeKind, TextWrapMode, Ui, Vec2, pos2, vec2,
};

use super::actions::{ACTIONS, FIXED};
use super::keys::KeyMap;
use super::legend::Against;
use super::measure::{FRAMES, FrameTimes, Steps};
use crate::render::{COVERS_SKY, ERROR_DECADES, Ledger, SEE_THROUGH, SKY_BOTH, heat_map_colour};
use crate::scene::{Scene, Technique};

/// Distance of the overlays from the borders, points.
const MARGIN: f32 = 10.0;

/// Distance of the hint from the bottom, so that the legend fits below it. Points.
const ABOVE_LEGEND: f32 = 84.0;

/// Distance of the compared techniques' names from the top, so that the statistics fit above them. Points.
const BELOW_STATISTICS: f32 = 144.0;

/// Room that the help needs for two columns, points.
const TWO_COLUMNS: f32 = 1000.0;

/// Widest a legend's scale is, points; a narrow window has less room.
const WIDEST_SCALE: f32 = 440.0;

/// Frame times, steps and the ledger in short, in the upper left corner of the picture beside the panel. Where the box is.
pub(crate) fn statistics(ui: &Ui, times: &FrameTimes, steps: Option<Steps>, ledger: &Ledger, timestamps: bool) -> Rect {
    let corner = ui.available_rect_before_wrap().left_top() + vec2(MARGIN, MARGIN);
    boxed(ui.ctx(), "statistics", (Align2::LEFT_TOP, corner), |ui| {
        let clock = if timestamps { "GPU" } else { "Frame" };
        let text = match (times.quantile(0.5), times.quantile(0.99)) {
            (Some(median), Some(p99)) => format!("{clock} {median:.2} ms median, {p99:.2} ms p99"),
            _ => format!("{clock} time: no frame yet"),
        };
        ui.monospace(text);
        graph(ui, times);
        if let Some((mean, max)) = steps {
            ui.monospace(format!("{mean:.1} steps per ray, at most {max}"));
        }
        ui.monospace(ledger.passes.join(" → "));
        let (textures, size) = (ledger.textures.len(), bytes(ledger.texture_bytes));
        ui.monospace(format!("{} draws, {textures} textures, {size}", ledger.draws));
    })
}

/// The times as bars, the newest on the right, scaled to the slowest.
fn graph(ui: &mut Ui, times: &FrameTimes) {
    let (response, painter) = ui.allocate_painter(vec2(2.0 * FRAMES as f32, 36.0), Sense::hover());
    let rect = response.rect;
    painter.rect_filled(rect, 2.0, Color32::from_black_alpha(90));
    let slowest = times.newest_first().fold(f64::MIN_POSITIVE, f64::max);
    for (age, ms) in times.newest_first().enumerate() {
        let x = rect.right() - 1.0 - 2.0 * age as f32;
        let height = (ms / slowest) as f32 * (rect.height() - 2.0);
        let bar = [pos2(x, rect.bottom() - 1.0), pos2(x, rect.bottom() - 1.0 - height)];
        painter.line_segment(bar, Stroke::new(1.5, Color32::from_rgb(120, 200, 140)));
    }
}

/// What the colours of the heat map mean, in the lower left corner beside the panel: messages use the right one. Where the
/// box is.
pub(crate) fn legend(ctx: &Context, free: Rect, maximum: u32) -> Rect {
    boxed(ctx, "legend", (Align2::LEFT_BOTTOM, free.left_bottom() + vec2(MARGIN, -MARGIN)), |ui| {
        ui.label("Steps per ray");
        let (response, painter) = ui.allocate_painter(vec2(320.0, 14.0), Sense::hover());
        painter.add(gradient(response.rect));
        ui.horizontal(|ui| {
            ui.set_width(320.0);
            ui.columns_const(|[left, middle, right]| {
                left.label("0");
                middle.vertical_centered(|ui| ui.label(legend_number(maximum, 0.5)));
                right.with_layout(egui::Layout::right_to_left(egui::Align::Min), |ui| {
                    ui.label(format!("{} or more", legend_number(maximum, 1.0)));
                });
            });
        });
    })
}

/// What the colours of the error view mean, and what the errors are against. Where the box is.
pub(crate) fn error_legend(ctx: &Context, free: Rect, Against { reference, awaited }: Against) -> Rect {
    boxed(ctx, "legend", (Align2::LEFT_BOTTOM, free.left_bottom() + vec2(MARGIN, -MARGIN)), |ui| {
        let against = match (reference, awaited) {
            (true, _) => "against the f64 reference",
            (false, true) => "against max-mipmap; the f64 reference follows …",
            (false, false) => "against max-mipmap",
        };
        ui.label(format!("Distance error in cells, {against}"));
        let width = (free.width() - 4.0 * MARGIN).clamp(160.0, WIDEST_SCALE);
        let (response, painter) = ui.allocate_painter(vec2(width, 14.0), Sense::hover());
        painter.add(gradient(response.rect));
        decades(ui, width);
        ui.horizontal(|ui| {
            for (colour, meaning) in [(SEE_THROUGH, "sees through"), (COVERS_SKY, "covers the sky"), (SKY_BOTH, "sky")]
            {
                let (response, painter) = ui.allocate_painter(vec2(12.0, 12.0), Sense::hover());
                let [red, green, blue] = colour;
                // Dark grey on a dark box shows by its outline.
                let outline = Stroke::new(1.0, Color32::from_gray(150));
                painter.rect(response.rect, 2.0, Color32::from_rgb(red, green, blue), outline, StrokeKind::Inside);
                ui.label(meaning);
            }
        });
    })
}

/// Numbers below the scale of errors: its ends, and the decades between as far as they do not crowd each other.
fn decades(ui: &mut Ui, width: f32) {
    let [low, high] = ERROR_DECADES;
    let (font, colour) = (egui::TextStyle::Body.resolve(ui.style()), ui.visuals().text_color());
    let (row, painter) = ui.allocate_painter(vec2(width, 18.0), Sense::hover());
    let mut taken: Vec<Rect> = Vec::new();
    for decade in [low, high].into_iter().chain(low + 1..high) {
        let share = (decade - low) as f32 / (high - low) as f32;
        let (align, more) = match decade {
            _ if decade == low => (Align2::LEFT_TOP, ""),
            _ if decade == high => (Align2::RIGHT_TOP, " or more"),
            _ => (Align2::CENTER_TOP, ""),
        };
        let text = painter.layout_no_wrap(format!("{}{more}", 10f64.powi(decade)), font.clone(), colour);
        let place = align.anchor_size(pos2(row.rect.left() + share * width, row.rect.top()), text.size());
        if taken.iter().all(|other| !other.expand2(vec2(10.0, 0.0)).intersects(place)) {
            taken.push(place);
            painter.galley(place.min, text, colour);
        }
    }
}

/// How far from the split line it can be taken hold of, points.
pub(crate) const SPLIT_REACH: f32 = 6.0;

/// Whether a line splits the picture: a technique is not compared with itself.
pub(crate) fn is_split(scene: &Scene) -> bool {
    scene.compare.enabled && scene.compare.technique != scene.march.technique
}

/// The line between two techniques, with the name of each that draws on its side. `ui` is what the panel leaves free; the picture
/// fills the window. The line leaves out `boxes`: they let what is below them shine through, and it would cross their text.
/// The mouse that drags the line is handled where it moves, because egui would miss a drag that leaves the line before
/// the next frame.
pub(crate) fn split(ui: &Ui, scene: &Scene, [left, right]: [Technique; 2], dragged: bool, boxes: &[Rect]) {
    if !is_split(scene) {
        return;
    }
    let (picture, free) = (ui.ctx().content_rect(), ui.available_rect_before_wrap());
    let x = picture.left() + scene.compare.share as f32 * picture.width();
    let reach = Rect::from_x_y_ranges(x - SPLIT_REACH..=x + SPLIT_REACH, free.y_range());
    if dragged || ui.rect_contains_pointer(reach.intersect(free)) {
        ui.set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
    }
    if !free.x_range().contains(x) {
        return;
    }
    let painter = ui.painter();
    for (width, colour) in [(3.0, Color32::from_black_alpha(140)), (1.0, Color32::WHITE)] {
        for piece in uncovered(x, free.y_range(), boxes) {
            painter.vline(x, piece, Stroke::new(width, colour));
        }
    }
    let names = [(left, Align2::RIGHT_TOP, -8.0), (right, Align2::LEFT_TOP, 8.0)];
    for (technique, align, beside) in names {
        let colour = Color32::from_gray(235);
        let text = painter.layout_no_wrap(technique.name().to_owned(), egui::FontId::proportional(15.0), colour);
        let place = align.anchor_size(pos2(x + beside, free.top() + BELOW_STATISTICS), text.size());
        painter.rect_filled(place.expand2(vec2(5.0, 3.0)), 3.0, Color32::from_black_alpha(170));
        painter.galley(place.min, text, colour);
    }
}

/// The pieces of a vertical line at `x` that lie in none of `boxes`, from top to bottom.
fn uncovered(x: f32, line: Rangef, boxes: &[Rect]) -> Vec<Rangef> {
    let mut covers: Vec<Rangef> = boxes.iter().filter(|cover| cover.x_range().contains(x)).map(Rect::y_range).collect();
    covers.sort_by(|a, b| a.min.total_cmp(&b.min));
    let mut pieces = Vec::new();
    let mut top = line.min;
    for cover in covers {
        pieces.push(Rangef::new(top, cover.min.min(line.max)));
        top = top.max(cover.max);
    }
    pieces.push(Rangef::new(top, line.max));
    pieces.retain(|piece| piece.min < piece.max);
    pieces
}

/// The steps at a place of the legend.
fn legend_number(maximum: u32, share: f64) -> String {
    let steps = f64::from(maximum) * share;
    if steps.fract() == 0.0 { format!("{steps:.0}") } else { format!("{steps:.1}") }
}

/// The heat map's colours from 0 to its maximum, as the shader draws them.
fn gradient(rect: Rect) -> Shape {
    const STOPS: u32 = 64;
    let mut mesh = Mesh::default();
    for stop in 0..=STOPS {
        let share = stop as f32 / STOPS as f32;
        let [red, green, blue] = heat_map_colour(share);
        let (x, colour) = (rect.left() + share * rect.width(), Color32::from_rgb(red, green, blue));
        mesh.colored_vertex(pos2(x, rect.top()), colour);
        mesh.colored_vertex(pos2(x, rect.bottom()), colour);
        if stop > 0 {
            let corner = 2 * stop;
            mesh.add_triangle(corner - 2, corner - 1, corner);
            mesh.add_triangle(corner - 1, corner, corner + 1);
        }
    }
    Shape::mesh(mesh)
}

/// Where C digs while the mouse is captured: the middle of the window.
pub(crate) fn crosshair(ctx: &Context) {
    let painter = ctx.layer_painter(egui::LayerId::new(Order::Middle, Id::unique("crosshair")));
    let centre = ctx.content_rect().center();
    for (width, colour) in [(3.0, Color32::from_black_alpha(160)), (1.0, Color32::WHITE)] {
        let stroke = Stroke::new(width, colour);
        painter.line_segment([centre - vec2(8.0, 0.0), centre + vec2(8.0, 0.0)], stroke);
        painter.line_segment([centre - vec2(0.0, 8.0), centre + vec2(0.0, 8.0)], stroke);
    }
}

/// A line at the bottom: the speed after a turn of the wheel, or what is being waited for. Where its box is.
pub(crate) fn hint(ctx: &Context, free: Rect, text: &str, working: bool) -> Rect {
    boxed(ctx, "hint", (Align2::CENTER_BOTTOM, free.center_bottom() - vec2(0.0, ABOVE_LEGEND)), |ui| {
        ui.horizontal(|ui| {
            if working {
                ui.spinner();
            }
            ui.label(RichText::new(text).size(16.0));
        });
    })
}

/// The keys, in the middle of the part that the panel leaves free.
pub(crate) fn help(ctx: &Context, free: Rect, keys: &KeyMap, open: &mut bool) {
    // Offered the whole screen at any time, it takes what its contents need: egui's own offer is 340 points wide, and
    // remembered when the screen grows. In a small one the rest is scrolled to.
    let screen = ctx.content_rect();
    let room = (screen.size() - vec2(40.0, 70.0)).max(Vec2::ZERO);
    let window = egui::Window::new("Help").id(Id::unique("help")).open(open).collapsible(false).auto_sized();
    let window = window.min_size(room).max_size(room).pivot(Align2::CENTER_CENTER).default_pos(free.center());
    // What is wider than the part beside the panel lies over the panel, too, and not at the screen's edge.
    window.constrain_to(screen.shrink(MARGIN.min(0.25 * screen.size().min_elem()))).show(ctx, |ui| {
        ScrollArea::both().max_width(room.x).max_height(room.y).show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
            let chosen = ACTIONS.iter().map(|entry| (keys.shown(entry.action), entry.does));
            let mut rows: Vec<_> = chosen.chain(FIXED.map(|(input, does)| (input.to_owned(), does))).collect();
            // Two columns of one height, so that all of it fits the window of a first start; one where two are too wide.
            let half = if room.x < TWO_COLUMNS { rows.len() } else { rows.len().div_ceil(2) };
            let right = rows.split_off(half);
            ui.horizontal_top(|ui| {
                bindings(ui, "left", rows);
                if !right.is_empty() {
                    ui.add_space(16.0);
                    bindings(ui, "right", right);
                }
            });
        });
    });
}

/// A table of inputs and what they do.
fn bindings(ui: &mut Ui, name: &str, rows: Vec<(String, &'static str)>) {
    Grid::new(name).num_columns(2).striped(true).show(ui, |ui| {
        for (input, does) in rows {
            ui.strong(input);
            ui.label(does);
            ui.end_row();
        }
    });
}

/// A dark box over the picture that takes no clicks. `corner` of the box lies at the position, in points. Where it is.
pub(crate) fn boxed(
    ctx: &Context,
    name: &str,
    (corner, position): (Align2, Pos2),
    contents: impl FnOnce(&mut Ui),
) -> Rect {
    let area = Area::new(Id::unique(name)).interactable(false).order(Order::Middle);
    let shown = area.pivot(corner).fixed_pos(position).show(ctx, |ui| {
        let frame = Frame::popup(ui.style()).fill(Color32::from_black_alpha(170));
        frame.show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
            ui.visuals_mut().override_text_color = Some(Color32::from_gray(225));
            contents(ui);
        });
    });
    shown.response.rect
}

/// A number of bytes for people.
pub(crate) fn bytes(count: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB"];
    let mut value = count as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{count} B") } else { format!("{value:.1} {}", units[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_has_the_shaders_colours_at_its_ends() {
        let Shape::Mesh(mesh) = gradient(Rect::from_min_size(pos2(0.0, 0.0), vec2(100.0, 10.0))) else {
            panic!("a mesh");
        };
        let ends = [mesh.vertices.first(), mesh.vertices.last()].map(|vertex| vertex.expect("vertices").color);
        let expected = [0.0, 1.0].map(|share| {
            let [red, green, blue] = heat_map_colour(share);
            Color32::from_rgb(red, green, blue)
        });
        assert_eq!(ends, expected);
        assert_eq!(legend_number(64, 0.5), "32");
        assert_eq!(legend_number(7, 0.5), "3.5");
    }

    /// Statistics stay readable with the line behind them.
    #[test]
    fn the_split_line_leaves_out_the_boxes_in_its_way() {
        let at = |left: f32, top: f32, bottom: f32| Rect::from_min_max(pos2(left, top), pos2(left + 50.0, bottom));
        let boxes = [at(80.0, 60.0, 90.0), at(60.0, -5.0, 20.0), at(200.0, 30.0, 40.0), at(90.0, 70.0, 80.0)];
        let pieces = uncovered(100.0, Rangef::new(0.0, 100.0), &boxes);
        assert_eq!(pieces, [Rangef::new(20.0, 60.0), Rangef::new(90.0, 100.0)]);
        assert_eq!(uncovered(0.0, Rangef::new(0.0, 100.0), &boxes), [Rangef::new(0.0, 100.0)]);
    }

    /// The help's rectangle after it has been open in screens of these sizes, one after the other.
    fn help_in(screens: &[[f32; 2]]) -> Rect {
        let ctx = Context::default();
        let mut open = true;
        for pass in 0..10 * screens.len() {
            let [width, height] = screens[pass / 10];
            let screen = Rect::from_min_size(Pos2::ZERO, vec2(width, height));
            let time = Some(pass as f64);
            let input = egui::RawInput { screen_rect: Some(screen), time, ..Default::default() };
            ctx.run_ui(input, |ui| help(ui.ctx(), screen, &KeyMap::default(), &mut open))
                .drop_without_applying_deltas();
        }
        ctx.memory(|memory| memory.area_rect(Id::unique("help"))).expect("the help is open")
    }

    #[test]
    fn the_help_is_whole_where_there_is_room_and_scrolls_where_there_is_none() {
        let whole = help_in(&[[4000.0, 3000.0]]);
        assert!(whole.width() > 500.0 && whole.height() > 400.0, "{whole}");
        let usual = help_in(&[[1280.0, 800.0]]);
        assert_eq!(usual.size(), whole.size());
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 800.0));
        assert!(screen.shrink(9.0).contains_rect(usual), "not at the screen's edge: {usual}");
        // One column where two have no room: nothing is to be scrolled to the side.
        let narrow = help_in(&[[800.0, 500.0]]);
        assert!(narrow.width() < 700.0 && narrow.height() < 500.0, "{narrow}");
        assert_eq!(help_in(&[[420.0, 300.0], [1280.0, 800.0]]).size(), whole.size(), "it follows a growing window");
        for screens in [&[[420.0, 300.0]][..], &[[1280.0, 800.0], [420.0, 300.0]]] {
            let small = help_in(screens);
            assert!(Rect::from_min_size(Pos2::ZERO, vec2(420.0, 300.0)).contains_rect(small), "{small}");
        }
    }

    #[test]
    fn bytes_are_readable() {
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(bytes(5 << 30), "5.0 GiB");
    }
}
