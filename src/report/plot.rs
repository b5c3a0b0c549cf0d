//! The plot of error against time: one drawing as SVG, and the same drawing as PNG.

use std::fmt::Write;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::settings::Setting;
use super::sweep::front;
use super::{Report, ViewReport};
use crate::scene::Technique;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The drawing is not what the rasteriser reads.
    #[error("the plot is no drawing: {0}")]
    Drawing(#[from] resvg::usvg::Error),
    /// The encoder failed.
    #[error("the plot cannot be encoded: {0}")]
    Encoding(#[from] image::ImageError),
    /// No memory for the pixels.
    #[error("there is no memory for the plot's pixels")]
    Memory,
}

const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 612.0;
/// Pixels of the PNG per unit of the drawing.
const SCALE: f32 = 1.5;
/// Top and bottom of both panels, and their left edges and width.
const TOP: f64 = 92.0;
const BOTTOM: f64 = 530.0;
const LEFT: [f64; 2] = [84.0, 692.0];
const PANEL: f64 = 484.0;
/// Space between a panel's frame and its outermost points.
const MARGIN: f64 = 16.0;

/// Okabe and Ito's colours, which the colour-blind can tell apart; vermilion is kept for the exact technique.
const COLOURS: [&str; 6] = ["#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#0072B2", "#000000"];
pub(super) const EXACT: &str = "#D55E00";

/// A setting over all views.
struct Point {
    setting: Setting,
    /// Mean of the views' medians.
    ms: f64,
    /// Worst of the views: p99 in cells, wrong pixels in %.
    errors: [f64; 2],
}

/// The views in which times were taken: all, unless the measurement ended early.
fn timed(report: &Report) -> Vec<&ViewReport> {
    report.views.iter().filter(|view| view.rows.iter().any(|row| row.times.is_some())).collect()
}

/// The settings that were timed in each of these views.
fn points(views: &[&ViewReport]) -> Vec<Point> {
    let Some(first) = views.first() else { return Vec::new() };
    let point = |setting: Setting| {
        let (mut sum, mut errors) = (0.0, [0.0f64; 2]);
        for view in views {
            let row = view.rows.iter().find(|row| row.setting == setting)?;
            sum += row.times?.ms;
            errors = [errors[0].max(row.figures.p99), errors[1].max(row.figures.wrong)];
        }
        Some(Point { setting, ms: sum / views.len() as f64, errors })
    };
    first.rows.iter().filter_map(|row| point(row.setting)).collect()
}

/// The drawing. Views without times are not in it, nor settings that were not timed in all the others; a line below says
/// so.
pub fn svg(report: &Report) -> String {
    let mut out = String::new();
    let views = timed(report);
    // Writing to a string cannot fail.
    let _ = write_svg(&mut out, report, &views, &points(&views));
    out
}

/// What is not in the drawing and might be looked for there.
fn missing(report: &Report, points: &[Point]) -> String {
    let absent = |technique: &Technique| !points.iter().any(|point| point.setting.technique == *technique);
    let absent: Vec<_> = Technique::ALL.into_iter().filter(absent).map(Technique::name).collect();
    let mut words = String::new();
    if report.stopped.is_some() {
        words += "; the measurement ended early";
    }
    if !absent.is_empty() {
        words += &format!("; left out, and report.md says why: {}", absent.join(", "));
    }
    words
}

/// `svg`, a plot of [`svg`], as a PNG on white.
///
/// # Errors
/// [`PlotError`] where `svg` is not a drawing or memory is short.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let size = [WIDTH, HEIGHT].map(|side| (side as f32 * SCALE) as u32);
    rasterise(svg, size, SCALE, |_, _| [255; 3])
}

/// `svg` as a PNG of `size` pixels, `scale` of them per unit of the drawing, on a picture that is given by column and row.
pub(super) fn rasterise(
    svg: &str,
    size: [u32; 2],
    scale: f32,
    below: impl Fn(u32, u32) -> [u8; 3],
) -> Result<Vec<u8>, PlotError> {
    use resvg::tiny_skia::{Pixmap, Transform};
    let mut options = resvg::usvg::Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    // The same letters on every machine.
    let family = fonts.faces().next().and_then(|face| face.families.first()).map(|(name, _)| name.clone());
    if let Some(family) = family {
        fonts.set_sans_serif_family(family);
    }
    let tree = resvg::usvg::Tree::from_str(svg, &options)?;
    let mut pixels = Pixmap::new(size[0], size[1]).ok_or(PlotError::Memory)?;
    for (index, texel) in pixels.data_mut().chunks_exact_mut(4).enumerate() {
        let [red, green, blue] = below(index as u32 % size[0], index as u32 / size[0]);
        texel.copy_from_slice(&[red, green, blue, 255]);
    }
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive).write_image(
        pixels.data(),
        size[0],
        size[1],
        ExtendedColorType::Rgba8,
    )?;
    Ok(bytes)
}

fn write_svg(out: &mut String, report: &Report, views: &[&ViewReport], points: &[Point]) -> std::fmt::Result {
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"16\" fill=\"#111\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    )?;
    let views: Vec<_> = views.iter().map(|view| view.name.as_str()).collect();
    let title = format!(
        "{}, {}×{} samples, at {}×{} pixels on {}",
        report.map, report.map_samples[0], report.map_samples[1], report.size[0], report.size[1], report.adapter
    );
    text(out, LEFT[0], 26.0, "start", 19.0, &title)?;
    legend(out, points)?;
    let x_axis = Axis::new(points.iter().map(|point| point.ms), false);
    let labels = ["99th percentile of the distance error, cells", "wrong pixels, %"];
    for (index, label) in labels.into_iter().enumerate() {
        let errors: Vec<f64> = points.iter().map(|point| point.errors[index]).collect();
        let panel = Panel { left: LEFT[index], x: x_axis, y: Axis::new(errors.iter().copied(), true) };
        panel.frame(out, label)?;
        panel.curves(out, points, &errors)?;
    }
    let missing = missing(report, points);
    let note = format!("time: mean of the views' medians; error: the worst view ({}){missing}", views.join(", "));
    text(out, LEFT[0], HEIGHT - 10.0, "start", 14.0, &note)?;
    writeln!(out, "</svg>")
}

pub(super) fn text(out: &mut String, x: f64, y: f64, anchor: &str, size: f64, words: &str) -> std::fmt::Result {
    let words = words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\">{words}</text>")
}

fn colour(technique: Technique) -> &'static str {
    let index = Technique::ALL.iter().position(|&known| known == technique).unwrap_or_default();
    if technique == Technique::MaxMipmap { EXACT } else { COLOURS[index % COLOURS.len()] }
}

/// A marker around a point; no two techniques have the same shape.
fn marker(out: &mut String, technique: Technique, x: f64, y: f64, size: f64, opacity: f64) -> std::fmt::Result {
    let index = Technique::ALL.iter().position(|&known| known == technique).unwrap_or_default();
    let corners: &[[f64; 2]] = match index {
        _ if technique == Technique::MaxMipmap => &[
            [0.0, -1.7],
            [0.4, -0.55],
            [1.62, -0.53],
            [0.65, 0.21],
            [1.0, 1.38],
            [0.0, 0.68],
            [-1.0, 1.38],
            [-0.65, 0.21],
            [-1.62, -0.53],
            [-0.4, -0.55],
        ],
        0 => &[],
        1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        2 => &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
        3 => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
        _ => &[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]],
    };
    let paint = format!("fill=\"{}\" stroke=\"#fff\" stroke-width=\"0.8\" opacity=\"{opacity}\"", colour(technique));
    if corners.is_empty() {
        return writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{size}\" {paint}/>");
    }
    let corners: Vec<_> = corners.iter().map(|[dx, dy]| format!("{:.1},{:.1}", x + dx * size, y + dy * size)).collect();
    writeln!(out, "<polygon points=\"{}\" {paint}/>", corners.join(" "))
}

pub(super) fn polyline(out: &mut String, points: &[[f64; 2]], style: &str) -> std::fmt::Result {
    let points: Vec<_> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    writeln!(out, "<polyline points=\"{}\" fill=\"none\" stroke-linejoin=\"round\" {style}/>", points.join(" "))
}

const FRONT_STYLE: &str = "stroke=\"#c9c9c9\" stroke-width=\"7\" stroke-linecap=\"round\"";

fn legend(out: &mut String, points: &[Point]) -> std::fmt::Result {
    let mut x = LEFT[0] + 8.0;
    let y = 58.0;
    for technique in Technique::ALL {
        if !points.iter().any(|point| point.setting.technique == technique) {
            continue;
        }
        let style = format!("stroke=\"{}\" stroke-width=\"2.5\"", colour(technique));
        polyline(out, &[[x - 8.0, y - 5.0], [x + 24.0, y - 5.0]], &style)?;
        marker(out, technique, x + 8.0, y - 5.0, 6.0, 1.0)?;
        text(out, x + 32.0, y, "start", 16.0, technique.name())?;
        x += 62.0 + 8.6 * technique.name().len() as f64;
    }
    polyline(out, &[[x, y - 5.0], [x + 26.0, y - 5.0]], FRONT_STYLE)?;
    text(out, x + 40.0, y, "start", 16.0, "Pareto front of all")
}

/// A logarithmic axis over what it has to show.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    /// Decimal logarithms of its ends.
    low: f64,
    high: f64,
    /// Where 0 stands, which has no logarithm; absent where there is none.
    pub(super) floor: Option<f64>,
}

impl Axis {
    /// `decades` widens it to whole powers of ten.
    pub(super) fn new(values: impl Iterator<Item = f64> + Clone, decades: bool) -> Self {
        let logs = values.clone().filter(|value| *value > 0.0).map(f64::log10);
        let (mut low, mut high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if decades {
            (low, high) = (low.floor(), high.ceil());
        }
        if high - low < 0.3 {
            (low, high) = (low - 0.3, high + 0.3);
        }
        let mut values = values;
        let floor = values.any(|value| value <= 0.0).then_some(low - 0.09 * (high - low));
        Self { low: floor.unwrap_or(low), high, floor }
    }

    /// Where a value stands, 0..1.
    pub(super) fn share(&self, value: f64) -> f64 {
        let log = if value > 0.0 { value.log10() } else { self.floor.unwrap_or(self.low) };
        (log - self.low) / (self.high - self.low)
    }

    /// Values with a label: 1, 2 and 5 in a decade where there are few decades, else powers of ten, at most ten.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let every = ((self.high - self.low) / 10.0).ceil().max(1.0) as i32;
        let steps: &[f64] = if self.high - self.low < 3.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let first = if self.floor.is_some() { self.low + 0.06 * (self.high - self.low) } else { self.low - 1e-9 };
        decades
            .filter(|decade| decade.rem_euclid(every) == 0)
            .flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)))
            .filter(|tick| (first..=self.high + 1e-9).contains(&tick.log10()))
            .collect()
    }
}

/// `0.01` and `100` as they are, what is smaller or larger with an exponent.
pub(super) fn label(value: f64) -> String {
    let power = value.log10().floor() as i32;
    if (-4..=4).contains(&power) { ((value * 1e6).round() / 1e6).to_string() } else { format!("{value:.0e}") }
}

/// One of the two plots.
struct Panel {
    left: f64,
    x: Axis,
    y: Axis,
}

impl Panel {
    fn at(&self, ms: f64, error: f64) -> [f64; 2] {
        let (width, height) = (PANEL - 2.0 * MARGIN, BOTTOM - TOP - 2.0 * MARGIN);
        [self.left + MARGIN + width * self.x.share(ms), BOTTOM - MARGIN - height * self.y.share(error)]
    }

    fn frame(&self, out: &mut String, name: &str) -> std::fmt::Result {
        let (left, right) = (self.left, self.left + PANEL);
        let grid = "stroke=\"#e6e6e6\" stroke-width=\"1\"";
        for tick in self.x.ticks() {
            let [x, _] = self.at(tick, 1.0);
            polyline(out, &[[x, TOP], [x, BOTTOM]], grid)?;
            text(out, x, BOTTOM + 20.0, "middle", 15.0, &label(tick))?;
        }
        for tick in self.y.ticks() {
            let [_, y] = self.at(1.0, tick);
            polyline(out, &[[left, y], [right, y]], grid)?;
            text(out, left - 8.0, y + 5.0, "end", 15.0, &label(tick))?;
        }
        if self.y.floor.is_some() {
            let [_, y] = self.at(1.0, 0.0);
            polyline(out, &[[left, y], [right, y]], "stroke=\"#999\" stroke-width=\"1\" stroke-dasharray=\"5 4\"")?;
            text(out, left - 8.0, y + 5.0, "end", 15.0, "0")?;
        }
        polyline(
            out,
            &[[left, TOP], [right, TOP], [right, BOTTOM], [left, BOTTOM], [left, TOP]],
            "stroke=\"#555\" stroke-width=\"1\"",
        )?;
        text(out, 0.5 * (left + right), BOTTOM + 42.0, "middle", 16.0, "time of a frame, ms")?;
        text(out, left, TOP - 10.0, "start", 16.0, name)
    }

    /// Every setting as a marker, each technique's best as a curve, and the front of all below them.
    fn curves(&self, out: &mut String, points: &[Point], errors: &[f64]) -> std::fmt::Result {
        let place = |index: usize| self.at(points[index].ms, errors[index]);
        let best = self.sorted_front(points, errors, |_| true);
        let mut stairs: Vec<[f64; 2]> = Vec::new();
        for &index in &best {
            let [x, y] = place(index);
            stairs.extend(stairs.last().map(|&[_, above]| [x, above]));
            stairs.push([x, y]);
        }
        if let Some(&[_, y]) = stairs.last() {
            stairs.push([self.left + PANEL - 6.0, y]);
        }
        polyline(out, &stairs, FRONT_STYLE)?;
        for technique in Technique::ALL {
            let curve = self.sorted_front(points, errors, |point| point.setting.technique == technique);
            let line: Vec<_> = curve.iter().map(|&index| place(index)).collect();
            polyline(out, &line, &format!("stroke=\"{}\" stroke-width=\"2.5\"", colour(technique)))?;
            let own = (0..points.len()).filter(|&index| points[index].setting.technique == technique);
            for (index, on_curve) in own.map(|index| (index, curve.contains(&index))) {
                let [x, y] = place(index);
                let size = if technique == Technique::MaxMipmap { 8.0 } else { 5.5 };
                let (size, opacity) = if on_curve { (size, 1.0) } else { (size * 0.7, 0.4) };
                marker(out, technique, x, y, size, opacity)?;
            }
        }
        Ok(())
    }

    /// Indices of the points that nothing among the chosen ones beats, fastest first.
    fn sorted_front(&self, points: &[Point], errors: &[f64], chosen: impl Fn(&Point) -> bool) -> Vec<usize> {
        let candidates: Vec<_> =
            points.iter().zip(errors).map(|(point, &error)| chosen(point).then_some([point.ms, error])).collect();
        let on = front(&candidates);
        let mut indices: Vec<usize> = (0..points.len()).filter(|&index| on[index]).collect();
        indices.sort_by(|&a, &b| points[a].ms.total_cmp(&points[b].ms));
        indices
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_a_place_on_a_logarithmic_axis() {
        let axis = Axis::new([0.0, 0.02, 30.0].into_iter(), true);
        assert_eq!((axis.share(0.0), axis.share(100.0)), (0.0, 1.0));
        assert!(axis.share(0.01) > 0.05, "the smallest number is clear of 0");
        assert_eq!(axis.ticks(), [0.01, 0.1, 1.0, 10.0, 100.0]);
        let empty = Axis::new(std::iter::empty(), true);
        assert!(empty.low < empty.high && empty.floor.is_none());
        let one = Axis::new([5.0, 5.0].into_iter(), false);
        assert!((0.0..=1.0).contains(&one.share(5.0)));
    }

    #[test]
    fn labels_are_numbers_that_people_write() {
        assert_eq!([0.001, 0.2, 1.0, 5000.0, 1e-7, 1e12].map(label), ["0.001", "0.2", "1", "5000", "1e-7", "1e12"]);
    }
}
