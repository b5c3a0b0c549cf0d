//! How time and memory grow with the map: a plot with the fitted powers of the map's side.

use std::fmt::Write;

use serde::Serialize;

use super::plot::{Axis, PlotError, label, polyline, rasterise, text};

const WIDTH: f64 = 1560.0;
const HEIGHT: f64 = 560.0;
const SCALE: f32 = 1.5;
const TOP: f64 = 84.0;
const BOTTOM: f64 = 490.0;
const LEFT: f64 = 80.0;
const PANEL: f64 = 420.0;
const STEP: f64 = 770.0;
const MARGIN: f64 = 24.0;

/// Five colours that differ in hue and in lightness (Okabe & Ito 2008), for curves with a name each.
const COLOURS: [&str; 6] = ["#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];

/// One quantity over the side of the map.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// What it is.
    pub name: String,
    /// Samples along a side, and the quantity there; ascending.
    pub points: Vec<(u32, f64)>,
}

impl Curve {
    /// The power of the map's side that the quantity grows with: the slope of the line of least squares through the
    /// logarithms. Absent for fewer than two different sides.
    pub fn power(&self) -> Option<f64> {
        let logs: Vec<_> = self.points.iter().map(|&(side, value)| (f64::from(side).ln(), value.ln())).collect();
        let count = logs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|log| log.0), mean(|log| log.1));
        let spread: f64 = logs.iter().map(|log| (log.0 - x).powi(2)).sum();
        let together: f64 = logs.iter().map(|log| (log.0 - x) * (log.1 - y)).sum();
        (spread > 0.0 && together.is_finite()).then(|| together / spread)
    }
}

/// A panel of the plot: curves with a common unit.
#[derive(Clone, Debug, Serialize)]
pub struct Panel {
    /// What the panel shows, with its unit.
    pub title: String,
    /// Its curves, six at most.
    pub curves: Vec<Curve>,
}

/// The drawing: the panels side by side under `title`, two at most; both axes are logarithmic.
pub fn svg(title: &str, panels: &[Panel]) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_svg(&mut out, title, panels);
    out
}

/// `svg`, a drawing of [`svg`], as a PNG.
///
/// # Errors
/// [`PlotError`] where `svg` is not a drawing or memory is short.
pub fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    rasterise(svg, [WIDTH, HEIGHT].map(|side| (side as f32 * SCALE) as u32), SCALE, |_, _| [255; 3])
}

fn write_svg(out: &mut String, title: &str, panels: &[Panel]) -> std::fmt::Result {
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"16\" fill=\"#111\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    )?;
    text(out, LEFT, 28.0, "start", 19.0, title)?;
    for (index, panel) in panels.iter().enumerate() {
        draw(out, panel, LEFT + STEP * index as f64)?;
    }
    writeln!(out, "</svg>")
}

fn draw(out: &mut String, panel: &Panel, left: f64) -> std::fmt::Result {
    let points = panel.curves.iter().flat_map(|curve| &curve.points);
    let sides = Axis::new(points.clone().map(|&(side, _)| f64::from(side)), false);
    let values = Axis::new(points.clone().map(|&(_, value)| value), false);
    let right = left + PANEL;
    let at = |side: f64, value: f64| {
        let (width, height) = (PANEL - 2.0 * MARGIN, BOTTOM - TOP - 2.0 * MARGIN);
        [left + MARGIN + width * sides.share(side), BOTTOM - MARGIN - height * values.share(value)]
    };
    let grid = "stroke=\"#e6e6e6\" stroke-width=\"1\"";
    for tick in values.ticks() {
        let [_, y] = at(1.0, tick);
        polyline(out, &[[left, y], [right, y]], grid)?;
        text(out, left - 8.0, y + 5.0, "end", 15.0, &label(tick))?;
    }
    let mut shown: Vec<u32> = points.map(|&(side, _)| side).collect();
    shown.sort_unstable();
    shown.dedup();
    for side in shown {
        let [x, _] = at(f64::from(side), 1.0);
        polyline(out, &[[x, TOP], [x, BOTTOM]], grid)?;
        text(out, x, BOTTOM + 20.0, "middle", 15.0, &side.to_string())?;
    }
    let frame = [[left, TOP], [right, TOP], [right, BOTTOM], [left, BOTTOM], [left, TOP]];
    polyline(out, &frame, "stroke=\"#555\" stroke-width=\"1\"")?;
    text(out, left, TOP - 10.0, "start", 16.0, &panel.title)?;
    text(out, 0.5 * (left + right), BOTTOM + 44.0, "middle", 16.0, "samples along a side of the map")?;
    for (index, (curve, colour)) in panel.curves.iter().zip(COLOURS).enumerate() {
        let line: Vec<_> = curve.points.iter().map(|&(side, value)| at(f64::from(side), value)).collect();
        polyline(out, &line, &format!("stroke=\"{colour}\" stroke-width=\"2.5\""))?;
        for [x, y] in line {
            writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"/>")?;
        }
        let y = TOP + 22.0 + 24.0 * index as f64;
        polyline(
            out,
            &[[right + 8.0, y - 5.0], [right + 26.0, y - 5.0]],
            &format!("stroke=\"{colour}\" stroke-width=\"4\""),
        )?;
        let power = curve.power().map_or_else(String::new, |power| format!(", power {power:.2}"));
        text(out, right + 32.0, y, "start", 14.0, &format!("{}{power}", curve.name))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_of_a_power_law_is_its_exponent() {
        let points = [512u32, 1024, 4096].map(|side| (side, 3.0 * f64::from(side).powf(1.7))).to_vec();
        let power = Curve { name: String::new(), points }.power().unwrap();
        assert!((power - 1.7).abs() < 1e-12, "{power}");
        assert!(Curve { name: String::new(), points: vec![(512, 1.0)] }.power().is_none());
    }

    #[test]
    fn the_plot_is_a_picture_that_names_its_curves() {
        let curves = vec![Curve { name: "over & out".into(), points: vec![(512, 1.0), (1024, 1.5)] }];
        let svg = svg("growth", &[Panel { title: "ms".into(), curves }]);
        assert!(svg.contains("over &amp; out, power 0.58"), "{svg}");
        assert_eq!(&png(&svg).unwrap()[1..4], b"PNG");
    }
}
