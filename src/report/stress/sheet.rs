//! The contact sheet: every case as the reference sees it, as the exact technique does, and where each technique is wrong.

use std::fmt::Write;

use glam::DVec3;

use super::{CaseReport, Stage, StressReport};
use crate::render::{COVERS_SKY, SEE_THROUGH, SKY_BOTH, error_colour, heat_map_colour};
use crate::report::plot::{PlotError, rasterise, text};
use crate::scene::Technique;

/// Width and height of a picture on the sheet, pixels.
const THUMB: [u32; 2] = [112, 70];
/// Space around it.
const GAP: u32 = 4;
/// Width of the names' column, height of the head.
const NAMES: u32 = 300;
const HEAD: u32 = 88;
const PAPER: [u8; 3] = [255; 3];
/// Marks of a case in which the exact technique is wrong: beyond its promise, or only inside the tangency band.
const BROKEN: &str = "#c00";
const BAND: &str = "#c77700";

/// A small picture; what is beside a narrow one is empty.
#[derive(Clone, Debug)]
struct Thumb(Vec<Option<[u8; 3]>>);

impl Thumb {
    /// Fills the picture with the colours of pixels, given by their index among those that were compared.
    fn of(size: [u32; 2], stride: usize, colour: impl Fn(usize) -> Option<[u8; 3]>) -> Self {
        let [width, height] = size.map(f64::from);
        let scale = (f64::from(THUMB[0]) / width).min(f64::from(THUMB[1]) / height);
        let shown = [width, height].map(|side| (side * scale).round().max(1.0) as u32);
        let first = [(THUMB[0] - shown[0].min(THUMB[0])) / 2, (THUMB[1] - shown[1].min(THUMB[1])) / 2];
        let pixel = |index: u32| {
            let (x, y) = ((index % THUMB[0]).checked_sub(first[0])?, (index / THUMB[0]).checked_sub(first[1])?);
            let source = |at: u32, shown: u32, side: u32| (u64::from(at) * u64::from(side) / u64::from(shown)) as usize;
            let inside = x < shown[0] && y < shown[1];
            let index = source(y, shown[1], size[1]) * size[0] as usize + source(x, shown[0], size[0]);
            colour(index / stride).filter(|_| inside)
        };
        Self((0..THUMB[0] * THUMB[1]).map(pixel).collect())
    }
}

/// The pictures of one case.
#[derive(Clone, Debug)]
pub struct Strip {
    name: String,
    stride: usize,
    reference: Thumb,
    techniques: Vec<(Technique, Thumb, Thumb)>,
}

impl Strip {
    /// The reference's picture of the case `name`.
    pub(super) fn new(name: &str, stage: &Stage<'_>, reference: &[f64]) -> Self {
        let pixels = stage.size.iter().map(|&side| side as usize).product::<usize>();
        let stride = pixels.div_ceil(reference.len().max(1)).max(1);
        let shade = |index: usize| Some(stage.shade(index * stride, *reference.get(index)?));
        Self { name: name.to_owned(), stride, reference: Thumb::of(stage.size, stride, shade), techniques: Vec::new() }
    }

    /// Adds a technique's picture, and its difference from the reference.
    pub(super) fn add(&mut self, technique: Technique, stage: &Stage<'_>, reference: &[f64], picture: &[f32]) {
        let shade = |index: usize| Some(stage.shade(index * self.stride, f64::from(*picture.get(index)?)));
        let difference = |index: usize| {
            let (expected, actual) = (*reference.get(index)?, f64::from(*picture.get(index)?));
            Some(match (expected.is_finite(), actual.is_finite()) {
                (true, true) => error_colour((actual - expected).abs() / stage.cell),
                (true, false) => SEE_THROUGH,
                (false, true) => COVERS_SKY,
                (false, false) => SKY_BOTH,
            })
        };
        let picture = Thumb::of(stage.size, self.stride, shade);
        self.techniques.push((technique, picture, Thumb::of(stage.size, self.stride, difference)));
    }

    /// The pictures from left to right.
    fn columns(&self) -> Vec<Option<&Thumb>> {
        let of = |technique: Technique| self.techniques.iter().find(|(known, ..)| *known == technique);
        let exact = of(Technique::MaxMipmap);
        let first = [Some(&self.reference), exact.map(|(_, picture, _)| picture), exact.map(|(.., differs)| differs)];
        let others = Technique::ALL.into_iter().filter(|&technique| technique != Technique::MaxMipmap);
        first.into_iter().chain(others.map(|technique| of(technique).map(|(.., differs)| differs))).collect()
    }
}

impl Stage<'_> {
    /// The colour of ground at `distance` in a pixel, lit from the north-west; the sky's for none.
    fn shade(&self, pixel: usize, distance: f64) -> [u8; 3] {
        let width = self.size[0] as usize;
        let at = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
        if !distance.is_finite() {
            let down = at[1] / f64::from(self.size[1]);
            return [150.0 + 60.0 * down, 180.0 + 40.0 * down, 215.0 + 20.0 * down].map(|channel| channel as u8);
        }
        let ray = self.camera.ray(at[0], at[1], self.size);
        let point = ray.origin + ray.direction.normalize() * distance;
        let cells = self.field.cells();
        let side = [self.extent.x / f64::from(cells[0]), self.extent.z / f64::from(cells[1])];
        let height = |dx: f64, dz: f64| {
            self.field.surface_height((point.x + dx) / self.extent.x, (point.z + dz) / self.extent.z) * self.extent.y
        };
        let ground = height(0.0, 0.0);
        let [hx, hz] = side.map(|side| 0.25 * side);
        let slope =
            [(height(hx, 0.0) - height(-hx, 0.0)) / (2.0 * hx), (height(0.0, hz) - height(0.0, -hz)) / (2.0 * hz)];
        let near_side = [point.x, self.extent.x - point.x, point.z, self.extent.z - point.z];
        let inside = ground - point.y > 1e-3 * self.extent.y.max(1e-6);
        if inside && near_side.into_iter().fold(f64::INFINITY, f64::min) < 1e-3 {
            return [112, 92, 78];
        }
        let normal = DVec3::new(-slope[0], 1.0, -slope[1]).normalize();
        let light = 0.3 + 0.7 * normal.dot(DVec3::new(-0.5, 0.75, -0.43)).max(0.0);
        let share = if self.extent.y > 0.0 { (point.y / self.extent.y).clamp(0.0, 1.0) } else { 0.0 };
        [120.0 + 110.0 * share, 130.0 + 80.0 * share, 90.0 + 110.0 * share].map(|channel| (channel * light) as u8)
    }
}

/// The column of the exact technique's difference: [`Strip::columns`].
const DIFFERENCE: u32 = 2;
/// Width of the frame around it; the gap between pictures holds two.
const FRAME: u32 = 2;

/// Rows from which on the sheet has two blocks side by side.
const MANY: usize = 40;

/// Where things are on the sheet.
struct Layout {
    /// Columns of pictures in a block, and rows.
    columns: u32,
    rows: u32,
    blocks: u32,
}

impl Layout {
    const STEP: [u32; 2] = [THUMB[0] + GAP, THUMB[1] + GAP];

    fn of(strips: usize) -> Self {
        let blocks = if strips > MANY { 2 } else { 1 };
        let rows = strips.div_ceil(blocks).max(1) as u32;
        Self { columns: 2 + Technique::ALL.len() as u32, rows, blocks: blocks as u32 }
    }

    fn block_width(&self) -> u32 {
        NAMES + self.columns * Self::STEP[0] + GAP
    }

    fn size(&self) -> [u32; 2] {
        [self.blocks * self.block_width(), HEAD + self.rows * Self::STEP[1] + GAP]
    }

    /// The strip, the column of its pictures, and the place in the picture of a pixel of the sheet.
    fn picture(&self, x: u32, y: u32) -> Option<(usize, usize, [u32; 2])> {
        let (block, y) = (x / self.block_width(), y.checked_sub(HEAD)?);
        let x = (x % self.block_width()).checked_sub(NAMES)?;
        let place = [x % Self::STEP[0], y % Self::STEP[1]];
        let row = y / Self::STEP[1];
        let inside = place[0] < THUMB[0] && place[1] < THUMB[1] && row < self.rows;
        inside.then_some(((block * self.rows + row) as usize, (x / Self::STEP[0]) as usize, place))
    }

    /// Left and upper end of a strip.
    fn strip(&self, index: usize) -> [f64; 2] {
        let (block, row) = (index as u32 / self.rows, index as u32 % self.rows);
        [block * self.block_width(), HEAD + row * Self::STEP[1]].map(f64::from)
    }
}

/// The strips that are shown, with what was measured: all, but of a terrain's random views only the first and those that
/// were broken.
fn shown(report: &StressReport) -> Vec<(&Strip, &CaseReport)> {
    let mut last = "";
    let cases = report.strips.iter().zip(&report.cases);
    let chosen = cases.filter_map(|(strip, case)| {
        let (broken, random) = (!case.broken.is_empty(), case.view.starts_with("random"));
        let terrain = strip.name.split('/').next().unwrap_or_default();
        let first = !random || terrain != last;
        if random {
            last = terrain;
        }
        (first || broken).then_some((strip, case))
    });
    chosen.collect()
}

/// The sheet as a PNG: one row per case with its name.
///
/// # Errors
/// [`PlotError`] where memory is short.
pub fn png(report: &StressReport) -> Result<Vec<u8>, PlotError> {
    let shown = shown(report);
    let layout = Layout::of(shown.len());
    let strips: Vec<_> = shown.iter().map(|(strip, _)| strip.columns()).collect();
    let below = |x: u32, y: u32| {
        let pixel = || {
            let (strip, column, [x, y]) = layout.picture(x, y)?;
            let thumb = (*strips.get(strip)?.get(column)?)?;
            *thumb.0.get((y * THUMB[0] + x) as usize)?
        };
        pixel().unwrap_or(PAPER)
    };
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = labels(&mut svg, &shown, &layout);
    rasterise(&svg, layout.size(), 1.0, below)
}

fn labels(out: &mut String, shown: &[(&Strip, &CaseReport)], layout: &Layout) -> std::fmt::Result {
    let [width, height] = layout.size();
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" fill=\"#111\">"
    )?;
    let others = Technique::ALL.into_iter().filter(|&technique| technique != Technique::MaxMipmap);
    let names = ["reference", "max-mipmap", "max-mipmap, off"].map(str::to_owned);
    let names: Vec<_> = names.into_iter().chain(others.map(|technique| format!("{}, off", technique.name()))).collect();
    for (block, (column, name)) in
        (0..layout.blocks).flat_map(|block| names.iter().enumerate().map(move |n| (block, n)))
    {
        let x = block * layout.block_width() + NAMES + column as u32 * Layout::STEP[0];
        text(out, f64::from(x), f64::from(HEAD) - 8.0, "start", 13.0, name)?;
    }
    legend(out)?;
    for (index, (strip, case)) in shown.iter().enumerate() {
        let [x, y] = layout.strip(index);
        // A name has up to three parts, each on its own line.
        for (line, part) in strip.name.split('/').enumerate() {
            text(out, x + 8.0, y + 20.0 + 18.0 * line as f64, "start", 15.0, part)?;
        }
        mark(out, case, [x, y])?;
    }
    writeln!(out, "</svg>")
}

/// Marks the exact technique's difference in the strip at `x`, `y` where it shows wrong pixels: a frame around it, and the
/// reason in the column of names.
fn mark(out: &mut String, case: &CaseReport, [x, y]: [f64; 2]) -> std::fmt::Result {
    let (colour, words) = match (case.broken.is_empty(), case.judgement.tangent) {
        (false, _) => (BROKEN, String::from("broken")),
        (true, 0) => return Ok(()),
        (true, pixels) => (BAND, format!("{pixels} in band")),
    };
    writeln!(out, "<g fill=\"{colour}\">")?;
    text(out, x + f64::from(NAMES) - 12.0, y + 20.0, "end", 15.0, &words)?;
    writeln!(out, "</g>")?;
    let left = x + f64::from(NAMES) + f64::from(DIFFERENCE * Layout::STEP[0]);
    frame(out, [left, y], THUMB.map(f64::from), colour)
}

/// A frame just outside a rectangle.
fn frame(out: &mut String, [x, y]: [f64; 2], [width, height]: [f64; 2], colour: &str) -> std::fmt::Result {
    let half = f64::from(FRAME) * 0.5;
    writeln!(
        out,
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{FRAME}\"/>",
        x - half,
        y - half,
        width + 2.0 * half,
        height + 2.0 * half
    )
}

/// What the colours of the differences mean.
fn legend(out: &mut String) -> std::fmt::Result {
    let box_at = |out: &mut String, x: f64, [red, green, blue]: [u8; 3]| {
        writeln!(out, "<rect x=\"{x}\" y=\"10\" width=\"14\" height=\"14\" fill=\"rgb({red},{green},{blue})\"/>")
    };
    let mut x = 8.0;
    for (colour, words) in [(SEE_THROUGH, "seen through"), (COVERS_SKY, "covers sky"), (SKY_BOTH, "sky in both")] {
        box_at(out, x, colour)?;
        text(out, x + 20.0, 22.0, "start", 14.0, words)?;
        x += 130.0;
    }
    let [low, high] = crate::render::ERROR_DECADES;
    for step in 0..=20 {
        box_at(out, x + 8.0 * f64::from(step), heat_map_colour(step as f32 / 20.0))?;
    }
    text(out, x + 190.0, 22.0, "start", 14.0, &format!("off by 1e{low} to 1e{high} cells or more"))?;
    for (x, colour, words) in [
        (8.0, BAND, "max-mipmap is wrong inside the tangency band only, where either is right: so many pixels"),
        (658.0, BROKEN, "max-mipmap breaks its promise"),
    ] {
        frame(out, [x + 1.0, 37.0], [12.0, 12.0], colour)?;
        text(out, x + 20.0, 48.0, "start", 14.0, words)?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "sheet_tests.rs"]
mod tests;
