//! The ground measured: what is at a place, and the way from one place to another. In metres where the map knows them.
//!
//! Places are columns and rows, which may lie between samples. Lengths follow the map's extent; where its reference
//! system stretches them from place to place (degrees, Web Mercator), each step counts as long as it is there.

use super::HeightField;

/// Slopes gentler than this fall in no direction that means anything, degrees.
pub const LEVEL: f64 = 0.05;

/// What is at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Column and row.
    pub sample: [f64; 2],
    /// Height in the map's unit: metres where [`HeightField::has_metres`].
    pub height: f64,
    /// Coordinates in the map's reference system, east and north.
    pub coordinates: Option<[f64; 2]>,
    /// Longitude (−180 to 180) and latitude in degrees, where the system can be converted.
    pub longitude_latitude: Option<[f64; 2]>,
    /// Steepness in degrees: the true one where the extent is known, else that of the box as it is drawn.
    pub slope: f64,
    /// Compass direction in which the ground falls, degrees clockwise from north; absent where it is level.
    pub aspect: Option<f64>,
}

/// One point of a [`Profile`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Column and row.
    pub sample: [f64; 2],
    /// Distance from the start over the level, in [`Profile`]'s unit.
    pub distance: f64,
    /// Distance from the start along the ground.
    pub along_ground: f64,
    /// Height; absent over a hole.
    pub height: Option<f64>,
}

/// The way straight over the map from one place to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// From the start to the end: where the way begins and ends, crosses from cell to cell, and half-way between.
    pub points: Vec<Point>,
    /// Length over the level. Metres where the extent is known, else shares of the map's longer side.
    pub level: f64,
    /// Length of the straight line from the one ground to the other.
    pub straight: f64,
    /// Length along the ground.
    pub along_ground: f64,
    /// Height of the end over the start.
    pub rise: f64,
    /// All that is climbed on the way, and all that is descended.
    pub climb_and_descent: [f64; 2],
    /// The steepest of the way, degrees.
    pub steepest: f64,
    /// Lengths are metres.
    pub metric: bool,
}

/// A map with the measures of its ground.
#[derive(Clone, Copy, Debug)]
pub struct Survey<'a> {
    map: &'a HeightField,
    /// Length of a column's and a row's step in the middle.
    steps: [f64; 2],
    /// Length that a normalised height of 1 stands for, in the unit of lengths.
    relief: f64,
    metric: bool,
}

impl<'a> Survey<'a> {
    /// The ground of `map`, drawn in a box of the height `height_scale` where it does not know its own proportion.
    pub fn new(map: &'a HeightField, height_scale: f64) -> Self {
        let cells = map.cells().map(f64::from);
        let range = map.range();
        match map.extent_metres() {
            Some([x, z]) => {
                Self { map, steps: [x / cells[0], z / cells[1]], relief: range[1] - range[0], metric: true }
            }
            None => {
                let size = map.box_size(Some(height_scale));
                Self { map, steps: [size.x / cells[0], size.z / cells[1]], relief: height_scale, metric: false }
            }
        }
    }

    /// The place at shares `u` west–east and `v` north–south of the map, clamped to it.
    pub fn place(&self, u: f64, v: f64) -> Place {
        let cells = self.map.cells().map(f64::from);
        let sample = [u.clamp(0.0, 1.0) * cells[0], v.clamp(0.0, 1.0) * cells[1]];
        let coordinates = self.map.georeference().map(|place| place.at(sample[0], sample[1]));
        let converted = self.map.georeference().zip(coordinates).and_then(|(place, at)| place.longitude_latitude(at));
        let [east, south] = self.gradient(sample);
        let slope = east.hypot(south).atan().to_degrees();
        let aspect = (-east).atan2(south).to_degrees().rem_euclid(360.0);
        Place {
            sample,
            height: self.height(sample),
            coordinates,
            longitude_latitude: converted
                .filter(|at| at[1].abs() <= 90.0)
                .map(|[longitude, latitude]| [(longitude + 180.0).rem_euclid(360.0) - 180.0, latitude]),
            slope,
            aspect: (slope > LEVEL).then_some(aspect),
        }
    }

    /// Height in the map's unit.
    fn height(&self, [column, row]: [f64; 2]) -> f64 {
        let cells = self.map.cells().map(f64::from);
        let [low, high] = self.map.range();
        low + self.map.surface_height(column / cells[0], row / cells[1]) * (high - low)
    }

    /// Whether the cell around a place has ground.
    fn has_ground(&self, [column, row]: [f64; 2]) -> bool {
        let cells = self.map.cells();
        self.map.has_ground((column.max(0.0) as u32).min(cells[0] - 1), (row.max(0.0) as u32).min(cells[1] - 1))
    }

    /// Lengths of a step along a row and along a column at a place.
    fn steps_at(&self, [column, row]: [f64; 2]) -> [f64; 2] {
        let local = || {
            let place = self.map.georeference()?;
            let middle = place.metres_per_sample([self.map.width(), self.map.height()])?;
            let here = place.metres_per_step(column, row)?;
            Some([0, 1].map(|axis| self.steps[axis] * here[axis] / middle[axis]))
        };
        if self.metric { local().unwrap_or(self.steps) } else { self.steps }
    }

    /// Rise of the ground towards the east and the south, as length over length: Horn's differences (1981) at the cell's
    /// corners, interpolated, as the shader's normals are.
    fn gradient(&self, sample: [f64; 2]) -> [f64; 2] {
        let cells = self.map.cells();
        let base = [0, 1].map(|axis| (sample[axis].max(0.0) as u32).min(cells[axis] - 1));
        let f = [0, 1].map(|axis| sample[axis] - f64::from(base[axis]));
        let corner = |x: u32, z: u32| self.horn(base[0] + x, base[1] + z);
        let corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
        let steps = self.steps_at(sample);
        [0, 1].map(|axis| {
            let [nw, ne, sw, se] = corners.map(|corner| corner[axis]);
            mix(mix(nw, ne, f[0]), mix(sw, se, f[0]), f[1]) * self.relief / steps[axis]
        })
    }

    /// Differences of the normalised heights around a sample, per step east and south. One-sided at the map's border.
    fn horn(&self, column: u32, row: u32) -> [f64; 2] {
        let own = f64::from(self.map.sample(column, row));
        let near = |x: i64, z: i64| {
            let at = |first: u32, by: i64| (i64::from(first) + by).max(0) as u32;
            let (x, z) = (at(column, x), at(row, z));
            if self.map.is_hole(x, z) { own } else { f64::from(self.map.sample(x, z)) }
        };
        let [columns, rows] = self.map.cells();
        let span = |at: u32, last: u32| if at == 0 || at == last { 1.0 } else { 2.0 };
        let across = |side: &dyn Fn(i64) -> f64| 0.25 * (side(-1) + 2.0 * side(0) + side(1));
        [
            across(&|z| near(1, z) - near(-1, z)) / span(column, columns),
            across(&|x| near(x, 1) - near(x, -1)) / span(row, rows),
        ]
    }

    /// The way from one place to another, each given as in [`Self::place`].
    pub fn profile(&self, from: [f64; 2], to: [f64; 2]) -> Profile {
        let cells = self.map.cells().map(f64::from);
        let sample = |at: [f64; 2]| [0, 1].map(|axis| at[axis].clamp(0.0, 1.0) * cells[axis]);
        let (from, to) = (sample(from), sample(to));
        let at = |t: f64| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * t);
        // Heights in the unit of lengths: the box's where no metres are known.
        let [low, high] = self.map.range();
        let per_height = if high > low { self.relief / (high - low) } else { 0.0 };
        let start = self.height(from);
        let mut profile = Profile {
            points: vec![Point {
                sample: from,
                distance: 0.0,
                along_ground: 0.0,
                height: self.has_ground(from).then_some(start),
            }],
            level: 0.0,
            straight: 0.0,
            along_ground: 0.0,
            rise: self.height(to) - start,
            climb_and_descent: [0.0; 2],
            steepest: 0.0,
            metric: self.metric,
        };
        let mut before = 0.0;
        for t in crossings(from, to) {
            for t in [(before + t) * 0.5, t] {
                // Whether there is ground is told by the cell that the way has just passed.
                let passed = at(t - (t - before) * 0.25);
                profile.step(
                    self.steps_at(at(t)),
                    at(t),
                    self.has_ground(passed).then(|| self.height(at(t))),
                    per_height,
                );
            }
            before = t;
        }
        profile.straight = profile.level.hypot(profile.rise * per_height);
        profile
    }
}

impl Profile {
    /// Adds a point at `sample`.
    fn step(&mut self, steps: [f64; 2], sample: [f64; 2], height: Option<f64>, per_height: f64) {
        let Some(last) = self.points.last().copied() else { return };
        let by = [0, 1].map(|axis| (sample[axis] - last.sample[axis]) * steps[axis]);
        let level = by[0].hypot(by[1]);
        self.level += level;
        let mut along = level;
        if let (Some(height), Some(before)) = (height, last.height) {
            let rise = height - before;
            along = level.hypot(rise * per_height);
            self.climb_and_descent[usize::from(rise < 0.0)] += rise.abs();
            if level > 0.0 {
                self.steepest = self.steepest.max((rise * per_height).abs().atan2(level).to_degrees());
            }
        }
        self.along_ground += along;
        self.points.push(Point { sample, distance: self.level, along_ground: self.along_ground, height });
    }

    /// The profile as comma-separated values with a line of names, over `map`.
    pub fn to_csv(&self, map: &HeightField) -> String {
        let (length, height) = (if self.metric { "_m" } else { "" }, if map.has_metres() { "_m" } else { "" });
        let mut text =
            format!("distance{length},along_ground{length},height{height},column,row,x,y,longitude,latitude\n");
        for point in &self.points {
            let coordinates = map.georeference().map(|place| place.at(point.sample[0], point.sample[1]));
            let converted = map
                .georeference()
                .zip(coordinates)
                .and_then(|(place, coordinates)| place.longitude_latitude(coordinates));
            let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            let fields = [
                Some(point.distance),
                Some(point.along_ground),
                point.height,
                Some(point.sample[0]),
                Some(point.sample[1]),
                coordinates.map(|at| at[0]),
                coordinates.map(|at| at[1]),
                converted.map(|at| at[0]),
                converted.map(|at| at[1]),
            ];
            text.push_str(&fields.map(optional).join(","));
            text.push('\n');
        }
        text
    }
}

/// Where the way from one sample to another crosses from cell to cell, as shares of it above 0, and its end, 1.
fn crossings(from: [f64; 2], to: [f64; 2]) -> Vec<f64> {
    let mut found = vec![1.0];
    for axis in [0, 1] {
        let (a, b) = (from[axis], to[axis]);
        let (low, high) = (a.min(b), a.max(b));
        let mut line = low.floor() + 1.0;
        while line < high {
            found.push((line - a) / (b - a));
            line += 1.0;
        }
    }
    found.retain(|&t| t > 0.0 && t <= 1.0);
    found.sort_by(f64::total_cmp);
    found.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    found
}

#[cfg(test)]
mod tests {
    use super::super::HoleMask;
    use super::super::import::Georeference;
    use super::*;

    /// 11×11 samples 30 m apart that rise by 10 m a column to the east, from 100 m: a slope of atan(1/3).
    fn ramp() -> HeightField {
        let raw: Vec<f64> = (0..121).map(|index| 100.0 + f64::from(index % 11) * 10.0).collect();
        let place = Georeference::new([500_000.0, 4_000_000.0], [30.0, -30.0]).with_epsg(32611);
        let map = HeightField::from_raw(11, 11, &raw).unwrap();
        map.with_extent_metres(Some([300.0, 300.0])).with_georeference(Some(place))
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-4 * (1.0 + b.abs()), "{a} is not {b}");
    }

    #[test]
    fn a_place_has_the_height_slope_and_coordinates_that_a_hand_finds() {
        let map = ramp();
        for scale in [0.01, 30.0] {
            let place = Survey::new(&map, scale).place(0.25, 0.5);
            close(place.height, 125.0);
            close(place.slope, 18.434_948_8);
            close(place.aspect.unwrap(), 270.0);
            assert_eq!(place.coordinates, Some([500_075.0, 3_999_850.0]));
            let [longitude, latitude] = place.longitude_latitude.unwrap();
            // By PROJ.
            let off = (longitude + 116.999_166_335_155_36).abs().max((latitude - 36.143_365_736_855_49).abs());
            assert!(off < 1e-9, "{longitude} {latitude}");
        }
        // Towards the south-east and down: 10 m a sample each way.
        let raw: Vec<f64> = (0..121).map(|index| 300.0 - f64::from(index % 11 + index / 11) * 10.0).collect();
        let diagonal = HeightField::from_raw(11, 11, &raw).unwrap().with_extent_metres(Some([300.0, 300.0]));
        let place = Survey::new(&diagonal, 1.0).place(0.0, 1.0);
        close(place.aspect.unwrap(), 135.0);
        close(place.slope, (2f64.sqrt() / 3.0).atan().to_degrees());
        assert_eq!((place.coordinates, place.longitude_latitude), (None, None));
    }

    #[test]
    fn level_ground_falls_nowhere_and_a_plain_map_is_measured_as_drawn() {
        let flat = HeightField::from_raw(3, 3, &[5.0; 9]).unwrap();
        let place = Survey::new(&flat, 0.25).place(0.3, 0.3);
        assert_eq!((place.height, place.slope, place.aspect), (5.0, 0.0, None));
        let plain = HeightField::from_raw(3, 2, &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0]).unwrap();
        close(Survey::new(&plain, 0.5).place(0.5, 0.5).slope, 0.5f64.atan().to_degrees());
        close(Survey::new(&plain, 1.0).place(0.5, 0.5).slope, 45.0);
    }

    #[test]
    fn the_way_up_a_ramp_is_a_hypotenuse() {
        let map = ramp();
        let way = Survey::new(&map, 1.0).profile([0.1, 0.5], [0.8, 0.5]);
        close(way.level, 210.0);
        close(way.rise, 70.0);
        close(way.straight, 210f64.hypot(70.0));
        close(way.along_ground, way.straight);
        close(way.steepest, 18.434_948_8);
        close(way.climb_and_descent[0], 70.0);
        assert!(way.climb_and_descent[1] < 1e-9 && way.metric);
        let back = Survey::new(&map, 1.0).profile([0.8, 0.5], [0.1, 0.5]);
        close(back.rise, -70.0);
        close(back.climb_and_descent[1], 70.0);
        let csv = way.to_csv(&map);
        assert!(csv.starts_with("distance_m,along_ground_m,height_m,column,row,x,y,longitude,latitude\n0,0,110"));
        assert_eq!(csv.lines().count(), way.points.len() + 1);
        assert!(csv.lines().all(|line| line.matches(',').count() == 8), "{csv}");
    }

    /// Over a roof: up 100 m on 100 m, and down again. And along its ridge.
    #[test]
    fn the_way_over_a_roof_is_longer_than_the_straight_one() {
        let raw: Vec<f64> = (0..25).map(|index| 100.0 - 50.0 * f64::from((index % 5i32 - 2).abs())).collect();
        let map = HeightField::from_raw(5, 5, &raw).unwrap().with_extent_metres(Some([200.0, 200.0]));
        let survey = Survey::new(&map, 1.0);
        let over = survey.profile([0.0, 0.5], [1.0, 0.5]);
        close(over.straight, 200.0);
        close(over.along_ground, 200.0 * 2f64.sqrt());
        close(over.steepest, 45.0);
        assert_eq!((over.rise, over.climb_and_descent), (0.0, [100.0, 100.0]));
        let ridge = survey.profile([0.5, 0.0], [0.5, 1.0]);
        close(ridge.along_ground, 200.0);
        assert_eq!(ridge.steepest, 0.0);
        let nowhere = survey.profile([0.5, 0.5], [0.5, 0.5]);
        assert_eq!((nowhere.level, nowhere.along_ground, nowhere.steepest), (0.0, 0.0, 0.0));
    }

    #[test]
    fn holes_have_no_height_and_break_the_ground() {
        let mut holes = HoleMask::new(5, 3);
        holes.insert(7);
        let map = HeightField::from_raw_with_holes(5, 3, &[1.0; 15], Some(holes)).unwrap();
        let way = Survey::new(&map, 1.0).profile([0.0, 0.25], [1.0, 0.25]);
        let known: Vec<bool> = way.points.iter().map(|point| point.height.is_some()).collect();
        assert_eq!(known, [true, true, true, false, false, false, false, true, true]);
        close(way.along_ground, way.level);
    }

    /// On the equator and at 60° north a degree of longitude is not equally long.
    #[test]
    fn degrees_are_as_long_as_they_are_there() {
        let place = Georeference::new([0.0, 60.0], [1.0, -1.0]).with_epsg(4326);
        let size = [11, 121];
        let steps = place.metres_per_sample(size).unwrap();
        let raw: Vec<f64> = vec![0.0; 11 * 121];
        let map = HeightField::from_raw(11, 121, &raw).unwrap();
        let map = map.with_extent_metres(Some([steps[0] * 10.0, steps[1] * 120.0])).with_georeference(Some(place));
        let survey = Survey::new(&map, 1.0);
        // WGS 84: 111 319.49 m and 55 800.0 m.
        close(survey.profile([0.0, 0.5], [1.0, 0.5]).level, 1_113_194.9);
        close(survey.profile([0.0, 0.0], [1.0, 0.0]).level, 558_000.0);
        // From 60° north to 60° south along a meridian.
        let half = survey.profile([0.5, 0.0], [0.5, 1.0]).level;
        assert!((half - 2.0 * 6_654_072.8).abs() < 2000.0, "{half}");
    }
}
