//! The plot of the largest displacement beside its bound.

use std::fmt::Write;

use super::study::DISTANCES;
use super::{Point, StressReport};
use crate::report::plot::{Axis, EXACT, PlotError, label, polyline, rasterise, text};

const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 480.0;
const SCALE: f32 = 1.5;
const TOP: f64 = 84.0;
const BOTTOM: f64 = 410.0;
const LEFT: f64 = 90.0;
const PANEL: f64 = 340.0;
const STEP: f64 = 366.0;
const MARGIN: f64 = 24.0;

/// The drawing: a panel per eye distance, the map's side to the right, the displacement up.
pub fn svg(report: &StressReport) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_svg(&mut out, report);
    out
}

/// `svg`, a drawing of [`svg`], as a PNG.
///
/// # Errors
/// [`PlotError`] where `svg` is not a drawing or memory is short.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    rasterise(svg, [WIDTH, HEIGHT].map(|side| (side as f32 * SCALE) as u32), SCALE, |_, _| [255; 3])
}

fn write_svg(out: &mut String, report: &StressReport) -> std::fmt::Result {
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"16\" fill=\"#111\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    )?;
    let title = format!("How far max-mipmap's hits lie off the ground, as a share of the map, on {}", report.adapter);
    text(out, LEFT, 26.0, "start", 19.0, &title)?;
    polyline(out, &[[LEFT, 47.0], [LEFT + 30.0, 47.0]], BOUND)?;
    text(out, LEFT + 38.0, 52.0, "start", 16.0, "bound, the largest of a pixel")?;
    mark(out, [LEFT + 290.0, 47.0])?;
    text(
        out,
        LEFT + 304.0,
        52.0,
        "start",
        16.0,
        "measured, the largest of a pixel; beside it the largest share of a pixel's bound",
    )?;
    let sides = Axis::new(report.bound.iter().map(|point| f64::from(point.side)), false);
    let shares = report.bound.iter().flat_map(|point| [point.judgement.displacement, point.judgement.bound]);
    let shares = Axis::new(shares, true);
    for (index, distance) in DISTANCES.into_iter().enumerate() {
        let points: Vec<_> = report.bound.iter().filter(|point| point.distance == distance).collect();
        let panel = Panel { left: LEFT + STEP * index as f64, x: sides, y: shares };
        panel.draw(out, distance, &points, index == 0)?;
    }
    writeln!(out, "</svg>")
}

const BOUND: &str = "stroke=\"#555\" stroke-width=\"2.5\" stroke-dasharray=\"7 4\"";

fn mark(out: &mut String, [x, y]: [f64; 2]) -> std::fmt::Result {
    writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\" fill=\"{EXACT}\"/>")
}

struct Panel {
    left: f64,
    x: Axis,
    y: Axis,
}

impl Panel {
    fn at(&self, side: f64, share: f64) -> [f64; 2] {
        let (width, height) = (PANEL - 2.0 * MARGIN, BOTTOM - TOP - 2.0 * MARGIN);
        [self.left + MARGIN + width * self.x.share(side), BOTTOM - MARGIN - height * self.y.share(share)]
    }

    fn draw(&self, out: &mut String, distance: f64, points: &[&Point], first: bool) -> std::fmt::Result {
        let (left, right) = (self.left, self.left + PANEL);
        let grid = "stroke=\"#e6e6e6\" stroke-width=\"1\"";
        for tick in self.y.ticks() {
            let [_, y] = self.at(1.0, tick);
            polyline(out, &[[left, y], [right, y]], grid)?;
            if first {
                text(out, left - 8.0, y + 5.0, "end", 15.0, &label(tick))?;
            }
        }
        let frame = [[left, TOP], [right, TOP], [right, BOTTOM], [left, BOTTOM], [left, TOP]];
        polyline(out, &frame, "stroke=\"#555\" stroke-width=\"1\"")?;
        let unit = if distance == 1.0 { "box length" } else { "box lengths" };
        text(out, left, TOP - 8.0, "start", 16.0, &format!("eye {distance} {unit} away"))?;
        text(out, 0.5 * (left + right), BOTTOM + 44.0, "middle", 16.0, "samples along a side of the map")?;
        let line = |of: fn(&Point) -> f64| -> Vec<_> {
            points.iter().map(|point| self.at(f64::from(point.side), of(point))).collect()
        };
        polyline(out, &line(|point| point.judgement.bound), BOUND)?;
        polyline(
            out,
            &line(|point| point.judgement.displacement),
            &format!("stroke=\"{EXACT}\" stroke-width=\"2.5\""),
        )?;
        for point in points {
            let [x, y] = self.at(f64::from(point.side), point.judgement.displacement);
            mark(out, [x, y])?;
            text(out, x, y + 24.0, "middle", 14.0, &format!("{:.2}", point.judgement.ratio))?;
            text(out, x, BOTTOM + 20.0, "middle", 15.0, &point.side.to_string())?;
        }
        Ok(())
    }
}
