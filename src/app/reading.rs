//! Reading the land in the window: what is under the cursor, the way between two clicks, and heights that are exaggerated
//! by key.

use std::time::Instant;

use egui::{Align2, Color32, Context, Id, Order, Pos2, Rect, Stroke, pos2, vec2};
use glam::{DVec2, DVec3};
use serde::Serialize;

use super::graphics::Graphics;
use super::overlay::boxed;
use super::viewer::Viewer;
use super::{controls, picking};
use crate::camera::{Camera, Ray};
use crate::heightfield::reference::Surface;
use crate::heightfield::survey::{Place, Profile, Survey};
use crate::heightfield::{Crater, EXAGGERATIONS, HEIGHT_SCALES, HeightField};
use crate::scene::land::number;

/// The exaggerations that the keys step through: round, and about equally far apart to the eye.
const STEPS: [f64; 19] =
    [0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 70.0, 100.0];

/// Pieces of a measured line on the picture.
const PIECES: usize = 96;

/// A piece of the line this close behind a hill still counts as seen, world units: the line lies on the ground itself.
const HIDDEN_BY: f64 = 2e-3;

/// What is being read off the land.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reading {
    /// What is under the cursor shows.
    pub(crate) probe: bool,
    /// Clicks on the ground measure.
    pub(crate) measure: bool,
    /// A click that has not been measured yet, physical pixels of the window.
    pub(crate) clicked: Option<DVec2>,
    /// The ends of the measured way, shares of the map west–east and north–south: none, one or two.
    ends: Vec<[f64; 2]>,
    /// The way between them.
    pub(crate) profile: Option<Profile>,
    /// What is under the cursor, or why nothing is.
    found: Option<Result<Place, String>>,
    /// Heights over their true proportion.
    pub(crate) exaggeration: f64,
    /// The measured line on the picture: window points, and whether the ground hides none of it.
    line: Vec<(Pos2, bool)>,
    line_of: Option<LineOf>,
}

/// What a line on the picture was found for.
#[derive(Clone, Debug, PartialEq)]
struct LineOf {
    camera: Camera,
    size: DVec3,
    picture: [u32; 2],
    scale: f64,
    ends: Vec<[f64; 2]>,
    craters: Vec<Crater>,
}

/// The same for automated tests and remote control.
#[derive(Debug, Serialize)]
pub(crate) struct ReadingStatus {
    /// Heights over their true proportion.
    exaggeration: f64,
    /// Clicks measure.
    measuring: bool,
    /// Ends that were clicked.
    ends: usize,
    /// Height under the cursor, metres or the map's numbers.
    height: Option<f64>,
    /// Degrees.
    slope: Option<f64>,
    /// In the map's reference system.
    coordinates: Option<[f64; 2]>,
    /// Degrees.
    longitude_latitude: Option<[f64; 2]>,
    /// Length of the measured way over the level, and along the ground.
    lengths: Option<[f64; 2]>,
    /// Its rise.
    rise: Option<f64>,
}

impl Reading {
    /// Whether a cursor that moves changes what is shown.
    pub(crate) fn follows_cursor(&self) -> bool {
        self.probe
    }

    /// Forgets what was read off a map.
    pub(crate) fn forget(&mut self) {
        (self.ends, self.profile, self.found, self.clicked) = (Vec::new(), None, None, None);
        (self.line, self.line_of) = (Vec::new(), None);
    }

    /// Starts or ends measuring.
    pub(crate) fn set_measure(&mut self, on: bool) {
        self.forget();
        self.measure = on;
    }

    pub(crate) fn status(&self) -> ReadingStatus {
        let found = self.found.as_ref().and_then(|found| found.as_ref().ok());
        ReadingStatus {
            exaggeration: self.exaggeration,
            measuring: self.measure,
            ends: self.ends.len(),
            height: found.map(|place| place.height),
            slope: found.map(|place| place.slope),
            coordinates: found.and_then(|place| place.coordinates),
            longitude_latitude: found.and_then(|place| place.longitude_latitude),
            lengths: self.profile.as_ref().map(|profile| [profile.level, profile.along_ground]),
            rise: self.profile.as_ref().map(|profile| profile.rise),
        }
    }

    /// Measures the way again, over ground that has changed.
    fn renew(&mut self, survey: &Survey<'_>) {
        if let [from, to] = self.ends[..] {
            self.profile = Some(survey.profile(from, to));
        }
    }

    /// Takes a click on the ground at shares of the map: the first end, the second, or the first of another way.
    fn take_end(&mut self, at: [f64; 2], survey: &Survey<'_>) {
        if self.ends.len() == 2 {
            (self.ends, self.profile) = (Vec::new(), None);
        }
        self.ends.push(at);
        self.renew(survey);
    }
}

/// The next exaggeration up or down.
fn step(times: f64, up: bool) -> f64 {
    let next = if up {
        STEPS.into_iter().find(|&step| step > times * 1.001)
    } else {
        STEPS.into_iter().rev().find(|&step| step < times * 0.999)
    };
    next.unwrap_or(times).clamp(*EXAGGERATIONS.start(), *EXAGGERATIONS.end())
}

/// Heights over their true proportion, for a box of this height. 1 for a map without relief, which has none.
pub(crate) fn exaggeration(map: &HeightField, height_scale: f64) -> f64 {
    let own = map.true_height_scale();
    if own > 0.0 { height_scale / own } else { 1.0 }
}

/// The craters of the ground that was drawn last.
fn craters(graphics: &Graphics) -> &[Crater] {
    graphics.renderer.terrain().map_or(&[], |terrain| terrain.craters())
}

impl Viewer {
    /// Whether the measured way lies over ground that has changed since.
    pub(super) fn measured_before(&self, graphics: &Graphics) -> bool {
        let reading = &self.view.reading;
        reading.measure && reading.line_of.as_ref().is_some_and(|of| of.craters != craters(graphics))
    }

    /// Makes heights so many times their true proportion; the eye keeps its height above the ground.
    pub(super) fn exaggerate(&mut self, graphics: &Graphics, times: f64, now: Instant) {
        let own = self.map.true_height_scale();
        if own <= 0.0 {
            self.show_hint("This map has no heights to exaggerate".to_owned(), now);
            return;
        }
        let before = self.extent();
        let scale = (own * times).clamp(*HEIGHT_SCALES.start(), *HEIGHT_SCALES.end());
        let mut camera = self.camera();
        let map = self.ground(graphics);
        let below = |size: DVec3| controls::ground_below(map, size, camera.eye).unwrap_or(0.0);
        let raised = below(DVec3 { y: scale, ..before }) - below(before);
        camera.eye.y += raised;
        // Exactly the map's own proportion is what a scene says by saying nothing.
        let natural = self.map.natural_height_scale();
        self.scene.terrain.height_scale = if scale == natural { None } else { Some(scale) };
        self.scene.camera = Some(camera);
        self.show_hint(format!("Heights × {}", number(times)), now);
    }

    /// The next exaggeration by key.
    pub(super) fn step_exaggeration(&mut self, graphics: &Graphics, up: bool, now: Instant) {
        let times = exaggeration(&self.map, self.extent().y);
        self.exaggerate(graphics, step(times, up), now);
    }

    /// Finds out what is under the cursor and under a click, and where the measured line is in the picture.
    pub(super) fn read_land(&mut self, graphics: &Graphics, scale: f64) {
        let (size, camera, picture) = (self.extent(), self.camera(), graphics.target.size());
        self.view.reading.exaggeration = exaggeration(&self.map, size.y);
        let clicked = self.view.reading.clicked.take();
        if !self.view.reading.probe && !self.view.reading.measure {
            self.view.reading.found = None;
            return;
        }
        let centre = DVec2::new(f64::from(picture[0]), f64::from(picture[1])) * 0.5;
        let cursor = match self.pointer.cursor {
            _ if self.pointer.captured => Some(centre),
            Some(cursor) if self.cursor_is_free() => Some(cursor),
            _ => None,
        };
        let mut reading = std::mem::take(&mut self.view.reading);
        let map = self.ground(graphics);
        let survey = Survey::new(map, size.y);
        let shares = |pixel: DVec2| {
            let at = picking::ground_at(map, size, &camera, pixel, picture)?;
            Ok([at.x / size.x, at.z / size.z])
        };
        reading.found = if reading.probe {
            cursor.map(|cursor| shares(cursor).map(|[u, v]| survey.place(u, v)).map_err(in_words))
        } else {
            None
        };
        if let (Some(Ok(at)), true) = (clicked.map(shares), reading.measure) {
            reading.take_end(at, &survey);
        }
        let craters = craters(graphics).to_vec();
        let of = LineOf { camera, size, picture, scale, ends: reading.ends.clone(), craters };
        if reading.line_of.as_ref() != Some(&of) {
            if reading.line_of.as_ref().is_some_and(|before| before.craters != of.craters) {
                reading.renew(&survey);
            }
            reading.line = line(map, &of);
            reading.line_of = Some(of);
        }
        self.view.reading = reading;
    }

    /// Shows what was read: a box for the cursor, the line on the ground. Where the box is.
    pub(super) fn show_reading(&self, ctx: &Context) -> Option<Rect> {
        let reading = &self.view.reading;
        if reading.measure {
            paint(ctx, self.free, &reading.line);
        }
        if !reading.probe {
            return None;
        }
        let lines = match &reading.found {
            Some(Ok(place)) => in_lines(place, &self.map, reading.exaggeration),
            Some(Err(why)) => vec![why.clone()],
            None => vec!["Point at the ground".to_owned()],
        };
        let corner = self.free.right_top() + vec2(-10.0, 10.0);
        Some(boxed(ctx, "probe", (Align2::RIGHT_TOP, corner), |ui| {
            for line in lines {
                ui.monospace(line);
            }
        }))
    }
}

fn in_words(error: picking::PickError) -> String {
    match error {
        picking::PickError::Sky => "Sky".to_owned(),
        picking::PickError::Wall => "The cut side of the terrain".to_owned(),
    }
}

/// What is at a place, for people.
fn in_lines(place: &Place, map: &HeightField, exaggeration: f64) -> Vec<String> {
    let unit = if map.has_metres() { " m" } else { "" };
    let mut lines = vec![format!("height {:.2}{unit}", place.height)];
    let drawn = if map.extent_metres().is_some() { "" } else { " as drawn" };
    let aspect =
        place.aspect.map_or_else(String::new, |aspect| format!(", falls to {} ({aspect:.0}°)", compass(aspect)));
    lines.push(format!("slope {:.1}°{drawn}{aspect}", place.slope));
    if let (Some([x, y]), Some(system)) = (place.coordinates, map.georeference()) {
        // Degrees need more digits than metres.
        let digits = if x.abs() <= 360.0 && y.abs() <= 360.0 { 6 } else { 2 };
        let name = system.crs.as_deref().unwrap_or("its own system");
        lines.push(format!("x {x:.digits$}, y {y:.digits$} ({name})"));
    } else {
        lines.push(format!("column {:.2}, row {:.2}", place.sample[0], place.sample[1]));
    }
    if let Some([longitude, latitude]) = place.longitude_latitude {
        let (north, east) = (if latitude < 0.0 { "S" } else { "N" }, if longitude < 0.0 { "W" } else { "E" });
        lines.push(format!("{:.6}° {north}, {:.6}° {east}", latitude.abs(), longitude.abs()));
    }
    if (exaggeration - 1.0).abs() > 1e-9 {
        lines.push(format!("drawn with heights × {}", number(exaggeration)));
    }
    lines
}

/// The nearest of eight directions.
fn compass(degrees: f64) -> &'static str {
    const NAMES: [&str; 8] = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
    NAMES[((degrees / 45.0).round() as usize) % NAMES.len()]
}

/// The measured way on the picture: one point for one end.
fn line(map: &HeightField, of: &LineOf) -> Vec<(Pos2, bool)> {
    let (size, camera) = (of.size, &of.camera);
    let clip_from_world = camera.clip_from_world(of.picture);
    let seen = |u: f64, v: f64| {
        let at = DVec3::new(u * size.x, map.surface_height(u, v) * size.y, v * size.z);
        let clip = clip_from_world * at.extend(1.0);
        if clip.w <= 0.0 {
            return None;
        }
        let [width, height] = of.picture.map(f64::from);
        let pixel =
            DVec2::new((clip.x / clip.w + 1.0) * 0.5 * width, (1.0 - clip.y / clip.w) * 0.5 * height) / of.scale;
        let ray = Ray { origin: camera.eye, direction: at - camera.eye };
        let before = Surface::new(map, size).intersect(&ray).map_or(1.0, |hit| hit.depth);
        let is_seen = (1.0 - before) * ray.direction.length() <= HIDDEN_BY;
        Some((pos2(pixel.x as f32, pixel.y as f32), is_seen))
    };
    match of.ends[..] {
        [[u, v]] => seen(u, v).into_iter().collect(),
        [from, to] => {
            let at = |index: usize| {
                let t = index as f64 / PIECES as f64;
                [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * t)
            };
            (0..=PIECES).filter_map(|index| seen(at(index)[0], at(index)[1])).collect()
        }
        _ => Vec::new(),
    }
}

/// Paints the line where the panel leaves room: whole where it is seen, dotted where a hill hides it.
fn paint(ctx: &Context, free: Rect, line: &[(Pos2, bool)]) {
    let layer = egui::LayerId::new(Order::Background, Id::unique("measured line"));
    let painter = ctx.layer_painter(layer).with_clip_rect(free);
    for (width, colour) in [(4.0, Color32::from_black_alpha(150)), (2.0, Color32::from_rgb(255, 214, 60))] {
        for (index, pair) in line.windows(2).enumerate() {
            let [(from, one), (to, other)] = [pair[0], pair[1]];
            if (one && other) || index % 2 == 0 {
                let colour = if one && other { colour } else { colour.gamma_multiply(0.5) };
                painter.line_segment([from, to], Stroke::new(width, colour));
            }
        }
    }
    for (end, _) in line.first().into_iter().chain(line.last()) {
        painter.circle(*end, 5.0, Color32::from_rgb(255, 214, 60), Stroke::new(2.0, Color32::from_black_alpha(200)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::import::Georeference;

    #[test]
    fn keys_step_through_round_numbers_to_the_ends() {
        let mut times = 1.0;
        let mut up = Vec::new();
        while times < 100.0 {
            times = step(times, true);
            up.push(times);
        }
        assert_eq!((up[0], up.len(), step(100.0, true)), (1.5, 12, 100.0));
        assert_eq!((step(1.0, false), step(0.1, false), step(0.82, true), step(500.0, false)), (0.7, 0.1, 1.0, 100.0));
    }

    #[test]
    fn what_is_under_the_cursor_is_told_in_metres_and_degrees() {
        let raw: Vec<f64> = (0..121).map(|index| 100.0 + f64::from(index % 11) * 10.0).collect();
        let place = Georeference::new([500_000.0, 4_000_000.0], [30.0, -30.0]).with_epsg(32611);
        let map = HeightField::from_raw(11, 11, &raw).unwrap().with_extent_metres(Some([300.0, 300.0]));
        let map = map.with_georeference(Some(place));
        let lines = in_lines(&Survey::new(&map, 5.0).place(0.5, 0.5), &map, 15.0);
        assert_eq!(lines[0], "height 150.00 m");
        assert_eq!(lines[1], "slope 18.4°, falls to W (270°)");
        assert_eq!(lines[2], "x 500150.00, y 3999850.00 (EPSG:32611)");
        assert_eq!(lines[3], "36.143366° N, 116.998333° W");
        assert_eq!(lines[4], "drawn with heights × 15");
        let plain = HeightField::from_raw(2, 2, &[0.0, 7.0, 0.0, 7.0]).unwrap();
        let lines = in_lines(&Survey::new(&plain, 0.25).place(0.5, 0.5), &plain, 1.0);
        assert_eq!(lines, ["height 3.50", "slope 14.0° as drawn, falls to W (270°)", "column 0.50, row 0.50"]);
        assert_eq!([0.0, 22.0, 23.0, 359.0].map(compass), ["N", "N", "NE", "N"]);
    }

    #[test]
    fn two_clicks_make_a_way_and_a_third_begins_another() {
        let map = HeightField::from_raw(2, 2, &[0.0, 1.0, 0.0, 1.0]).unwrap();
        let survey = Survey::new(&map, 0.25);
        let mut reading = Reading::default();
        reading.set_measure(true);
        reading.take_end([0.0, 0.0], &survey);
        assert!(reading.profile.is_none());
        reading.take_end([1.0, 0.0], &survey);
        assert_eq!((reading.profile.as_ref().unwrap().level, reading.status().rise), (1.0, Some(1.0)));
        reading.take_end([0.0, 1.0], &survey);
        assert_eq!((reading.status().ends, reading.profile.is_none()), (1, true));
        reading.set_measure(false);
        assert_eq!(reading.status().ends, 0);
    }

    /// The line lies where the picture shows the ground, and what a hill hides is known.
    #[test]
    fn the_line_lies_on_the_picture() {
        // A wall across the middle.
        let raw: Vec<f32> = (0..81).map(|index| if index / 9 == 4 { 1.0 } else { 0.0 }).collect();
        let map = HeightField::from_raw(9, 9, &raw).unwrap();
        let size = map.box_size(Some(0.25));
        let camera = Camera { eye: DVec3::new(0.5, 0.1, 1.5), yaw: 0.0, pitch: 0.0, fov: 60.0 };
        let ends = vec![[0.5, 1.0], [0.5, 0.0]];
        let of = LineOf { camera, size, picture: [640, 400], scale: 2.0, ends, craters: Vec::new() };
        let line = line(&map, &of);
        assert_eq!(line.len(), PIECES + 1);
        // 0.5 ahead and 0.1 below the eye, of 0.577 a half picture: 69 of 200 pixels down, at two pixels a point.
        assert!((line[0].0 - pos2(160.0, (200.0 + 69.28) / 2.0)).length() < 0.1, "{:?}", line[0]);
        assert!(line[0].1 && !line[PIECES].1, "the wall hides the far end");
    }
}
