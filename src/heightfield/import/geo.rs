//! Where a map lies, and how long its steps are on the ground.

use serde::{Deserialize, Serialize};

use super::transverse_mercator::from_utm;

/// WGS 84's equatorial radius, metres.
const RADIUS: f64 = 6_378_137.0;
/// WGS 84's first eccentricity, squared.
const ECCENTRICITY_2: f64 = 0.006_694_379_990_141_317;
/// Where Web Mercator's square ends, degrees.
const MERCATOR_END: f64 = 85.06;

/// How the warning begins that a unit was guessed.
pub(in crate::heightfield) const UNIT_GUESSED: &str = "it does not say in which unit its place is given";

/// What coordinates are counted in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GroundUnit {
    /// Longitude and latitude; of so many degrees each (1 for degrees).
    Degrees(f64),
    /// Of so many metres each (1 for metres).
    Metres(f64),
    /// Metres at the equator, stretched with the latitude.
    WebMercator,
}

/// [`GroundUnit`] as a sidecar has it: "degree", "web-mercator", "none", or metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(in crate::heightfield) enum UnitText {
    /// Of so many metres each.
    Metres(f64),
    /// One with a name.
    Named(UnitName),
}

/// The units that have names in a sidecar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(in crate::heightfield) enum UnitName {
    /// Longitude and latitude.
    Degree,
    /// Metres at the equator.
    WebMercator,
    /// No lengths on any ground.
    None,
}

impl UnitText {
    /// The coordinates are no lengths.
    pub(in crate::heightfield) const NONE: Self = Self::Named(UnitName::None);

    /// The same as text, where there is one.
    pub(in crate::heightfield) fn of(unit: GroundUnit) -> Option<Self> {
        match unit {
            GroundUnit::Metres(metres) => Some(Self::Metres(metres)),
            GroundUnit::WebMercator => Some(Self::Named(UnitName::WebMercator)),
            GroundUnit::Degrees(unit) => (unit == 1.0).then_some(Self::Named(UnitName::Degree)),
        }
    }

    /// The unit; `None` where coordinates are no lengths.
    pub(in crate::heightfield) fn unit(self) -> Option<GroundUnit> {
        match self {
            Self::Metres(metres) => Some(GroundUnit::Metres(metres)),
            Self::Named(UnitName::Degree) => Some(GroundUnit::Degrees(1.0)),
            Self::Named(UnitName::WebMercator) => Some(GroundUnit::WebMercator),
            Self::Named(UnitName::None) => None,
        }
    }
}

/// What a sample stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PixelIs {
    /// The mean of a cell around it.
    #[default]
    Area,
    /// The point at which it was measured.
    Point,
}

/// Where the samples lie. Coordinates are those of the sample itself: for [`PixelIs::Area`] of its cell's middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// The reference system as it is known: "EPSG:3857", or a name.
    pub crs: Option<String>,
    /// Its number in the EPSG's list.
    pub epsg: Option<u32>,
    /// What its coordinates are counted in; absent where that is not known.
    pub unit: Option<GroundUnit>,
    /// The first sample's x (east) and y (north).
    pub origin: [f64; 2],
    /// How x and y change from one column to the next.
    pub column: [f64; 2],
    /// How they change from one row to the next; its y is below 0 in a map whose first row is the northernmost.
    pub row: [f64; 2],
    /// What a sample stands for.
    pub pixel: PixelIs,
}

impl Georeference {
    /// A map along the axes, north up: the first sample at `origin`, `step` from sample to sample (y below 0).
    pub fn new(origin: [f64; 2], step: [f64; 2]) -> Self {
        Self {
            crs: None,
            epsg: None,
            unit: None,
            origin,
            column: [step[0], 0.0],
            row: [0.0, step[1]],
            pixel: PixelIs::Area,
        }
    }

    /// The reference system with this number; its unit follows from it where it does not stand in `unit` already.
    #[must_use]
    pub fn with_epsg(mut self, epsg: u32) -> Self {
        self.epsg = Some(epsg);
        self.crs = Some(format!("EPSG:{epsg}"));
        self.unit = match epsg {
            3857 | 3785 | 900_913 | 102_100 | 102_113 => Some(GroundUnit::WebMercator),
            4001..=4999 => Some(GroundUnit::Degrees(1.0)),
            _ => self.unit.or(Some(GroundUnit::Metres(1.0))),
        };
        self
    }

    /// The reference system from a text: an EPSG number is understood, anything else is a name.
    #[must_use]
    pub fn with_crs(self, crs: &str) -> Self {
        let number = crs.trim().to_ascii_uppercase().strip_prefix("EPSG:").and_then(|text| text.trim().parse().ok());
        match number {
            Some(number) => self.with_epsg(number),
            None => Self { crs: Some(crs.trim().to_owned()), ..self },
        }
    }

    /// Whether all numbers can be those of a map.
    pub(in crate::heightfield) fn is_sound(&self) -> bool {
        let numbers = [self.origin, self.column, self.row].concat();
        let determinant = self.column[0] * self.row[1] - self.column[1] * self.row[0];
        numbers.iter().all(|number| number.is_finite()) && determinant != 0.0 && determinant.is_finite()
    }

    /// The coordinates at a column and row, which may lie between samples.
    pub fn at(&self, column: f64, row: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.origin[axis] + column * self.column[axis] + row * self.row[axis])
    }

    /// The same ground, for rows or columns counted from the other end.
    #[must_use]
    pub(super) fn turned(mut self, [width, height]: [u32; 2], rows: bool, columns: bool) -> Self {
        let last = [if columns { width.max(1) - 1 } else { 0 }, if rows { height.max(1) - 1 } else { 0 }];
        self.origin = self.at(f64::from(last[0]), f64::from(last[1]));
        if rows {
            self.row = self.row.map(|step| -step);
        }
        if columns {
            self.column = self.column.map(|step| -step);
        }
        self
    }

    /// The same ground, for a window of it whose samples are means of blocks.
    #[must_use]
    pub(in crate::heightfield) fn part(mut self, first: [u32; 2], factor: u32) -> Self {
        let middle = f64::from(factor - 1) * 0.5;
        self.origin = self.at(f64::from(first[0]) + middle, f64::from(first[1]) + middle);
        self.column = self.column.map(|step| step * f64::from(factor));
        self.row = self.row.map(|step| step * f64::from(factor));
        self
    }

    /// The column and row at which these coordinates lie.
    pub fn column_row(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        let ([a, d], [b, e]) = (self.column, self.row);
        let determinant = a * e - b * d;
        [(dx * e - dy * b) / determinant, (dy * a - dx * d) / determinant]
    }

    /// Why coordinates of the one are none of the other, as far as is known of both; `None` where nothing says so.
    pub fn differs_from(&self, other: &Self) -> Option<String> {
        let name = |place: &Self| place.crs.clone().unwrap_or_else(|| "a system without a name".into());
        let told = || Some(format!("{} against {}", name(self), name(other)));
        let mercator = |place: &Self| place.unit == Some(GroundUnit::WebMercator);
        if mercator(self) && mercator(other) {
            return None;
        }
        if let (Some(one), Some(two)) = (self.epsg, other.epsg) {
            return if one == two { None } else { told() };
        }
        let kind = |place: &Self| place.unit.map(|unit| std::mem::discriminant(&unit));
        if self.crs.is_some() && other.crs.is_some() && kind(self) != kind(other) { told() } else { None }
    }

    /// Whether the axes are not east and north.
    pub fn is_rotated(&self) -> bool {
        self.column[1].abs() > 1e-9 * self.column[0].abs() || self.row[0].abs() > 1e-9 * self.row[1].abs()
    }

    /// West, south, east, north of the outermost samples.
    pub fn bounds(&self, [width, height]: [u32; 2]) -> [f64; 4] {
        let (right, bottom) = (f64::from(width.max(1) - 1), f64::from(height.max(1) - 1));
        let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)].map(|(x, y)| self.at(x, y));
        let least = |axis: usize| corners.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
        let most = |axis: usize| corners.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
        [least(0), least(1), most(0), most(1)]
    }

    /// Longitude and latitude in degrees of coordinates of this system, where it is known how to find them: degrees,
    /// Web Mercator, and UTM on WGS 84, ETRS89 and NAD83.
    pub fn longitude_latitude(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        match self.unit? {
            GroundUnit::Degrees(unit) => Some([x * unit, y * unit]),
            GroundUnit::WebMercator => Some([(x / RADIUS).to_degrees(), (y / RADIUS).sinh().atan().to_degrees()]),
            GroundUnit::Metres(unit) => {
                let (zone, south) = utm_zone(self.epsg?)?;
                Some(from_utm(x * unit, y * unit, zone, south))
            }
        }
    }

    /// West, south, east, north in degrees of the corner samples, where [`Self::longitude_latitude`] knows.
    pub fn geographic_bounds(&self, [width, height]: [u32; 2]) -> Option<[f64; 4]> {
        let (right, bottom) = (f64::from(width.max(1) - 1), f64::from(height.max(1) - 1));
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for (column, row) in [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)] {
            let [longitude, latitude] = self.longitude_latitude(self.at(column, row))?;
            bounds =
                [bounds[0].min(longitude), bounds[1].min(latitude), bounds[2].max(longitude), bounds[3].max(latitude)];
        }
        bounds.iter().all(|bound| bound.is_finite()).then_some(bounds)
    }

    /// Metres on the ground from column to column and from row to row, at the map's middle; `None` where the unit is not
    /// known or the numbers are no map's.
    pub fn metres_per_sample(&self, [width, height]: [u32; 2]) -> Option<[f64; 2]> {
        self.metres_per_step(f64::from(width.max(1) - 1) * 0.5, f64::from(height.max(1) - 1) * 0.5)
    }

    /// The same at a column and row, which may lie between samples: degrees and Web Mercator's metres are not equally long
    /// everywhere.
    pub fn metres_per_step(&self, column: f64, row: f64) -> Option<[f64; 2]> {
        let middle = self.at(column, row);
        let per_unit = match self.unit? {
            GroundUnit::Metres(unit) => [unit, unit],
            GroundUnit::Degrees(unit) => {
                let latitude = middle[1] * unit;
                if latitude.abs() > 90.0 {
                    return None;
                }
                metres_per_radian(latitude).map(|metres| metres * unit.to_radians())
            }
            GroundUnit::WebMercator => {
                let latitude = (middle[1] / RADIUS).sinh().atan();
                if latitude.to_degrees().abs() > MERCATOR_END {
                    return None;
                }
                // A degree of longitude is as long as the radius makes it; one of latitude is stretched as much as it.
                let [east, north] = metres_per_radian(latitude.to_degrees());
                [east / RADIUS, north / RADIUS * latitude.cos()]
            }
        };
        let steps = [self.column, self.row].map(|step| (step[0] * per_unit[0]).hypot(step[1] * per_unit[1]));
        steps.iter().all(|step| step.is_finite() && *step > 0.0).then_some(steps)
    }
}

/// Metres per radian of longitude and of latitude, on the ellipsoid.
fn metres_per_radian(latitude: f64) -> [f64; 2] {
    let (sine, cosine) = latitude.to_radians().sin_cos();
    let flat = 1.0 - ECCENTRICITY_2 * sine * sine;
    [RADIUS / flat.sqrt() * cosine.max(0.0), RADIUS * (1.0 - ECCENTRICITY_2) / (flat * flat.sqrt())]
}

/// The zone of a UTM system, and whether it is that of the southern half.
fn utm_zone(epsg: u32) -> Option<(u32, bool)> {
    match epsg {
        32601..=32660 => Some((epsg - 32600, false)),
        32701..=32760 => Some((epsg - 32700, true)),
        25828..=25838 => Some((epsg - 25800, false)),
        26901..=26923 => Some((epsg - 26900, false)),
        _ => None,
    }
}

/// The reference system in a text of the "well-known" kind (WKT 1, also Esri's), as far as a viewer needs it: its number
/// or name, and its unit.
pub(super) fn from_wkt(text: &str) -> Option<(String, Option<u32>, GroundUnit)> {
    let text = text.trim();
    let upper = text.to_ascii_uppercase();
    let projected = upper.starts_with("PROJCS") || upper.starts_with("PROJCRS");
    if !projected && !upper.starts_with("GEOGCS") && !upper.starts_with("GEOGCRS") {
        return None;
    }
    let name = text.split('"').nth(1).unwrap_or("unnamed").to_owned();
    // The last identifier and the last unit are those of the whole.
    let number_after = |tag: &str, quoted: usize| {
        let rest = upper.get(upper.rfind(tag)? + tag.len()..)?;
        let field = rest.split(',').nth(quoted)?.trim_matches(|c: char| !c.is_ascii_digit() && c != '.');
        field.parse::<f64>().ok()
    };
    let last = upper.rfind("AUTHORITY[\"EPSG\"").filter(|&at| upper[at..].matches(']').count() <= 2);
    let epsg = last.and_then(|_| number_after("AUTHORITY[\"EPSG\"", 1)).map(|number| number as u32);
    let unit = number_after("UNIT[", 1).filter(|unit| *unit > 0.0 && unit.is_finite());
    let is_mercator = name.to_ascii_uppercase().replace(['_', '-', '/'], " ").contains("PSEUDO MERCATOR")
        || upper.contains("MERCATOR_AUXILIARY_SPHERE");
    let unit = match (projected, is_mercator) {
        (true, true) => GroundUnit::WebMercator,
        (true, false) => GroundUnit::Metres(unit.unwrap_or(1.0)),
        (false, _) => GroundUnit::Degrees(unit.map_or(1.0, f64::to_degrees)),
    };
    Some((epsg.map_or(name, |number| format!("EPSG:{number}")), epsg, unit))
}

/// The place in a world file (`.tfw`, `.pgw`): six numbers, a line each.
pub(super) fn from_world_file(text: &str) -> Option<Georeference> {
    let numbers: Vec<f64> = text.lines().map_while(|line| line.trim().parse().ok()).collect();
    let [a, d, b, e, x, y] = numbers[..] else { return None };
    let place = Georeference { column: [a, d], row: [b, e], ..Georeference::new([x, y], [1.0, 1.0]) };
    place.is_sound().then_some(place)
}

impl Georeference {
    /// With the reference system of a `.prj` file. Without one, degrees are assumed where the numbers can be nothing
    /// else, and metres otherwise; the assumption is told.
    #[must_use]
    pub(super) fn with_projection_file(
        mut self,
        text: Option<&str>,
        size: [u32; 2],
        warnings: &mut Vec<String>,
    ) -> Self {
        if let Some((crs, epsg, unit)) = text.and_then(from_wkt) {
            (self.crs, self.epsg, self.unit) = (Some(crs), epsg, Some(unit));
            return self;
        }
        if text.is_some() {
            warnings.push("the .prj beside it is in no form known here, and was ignored".into());
        }
        let [west, south, east, north] = self.bounds(size);
        let small = self.column[0].abs() < 0.2 && self.row[1].abs() < 0.2;
        let degrees = small && west >= -180.1 && east <= 360.1 && south >= -90.1 && north <= 90.1;
        self.unit = Some(if degrees { GroundUnit::Degrees(1.0) } else { GroundUnit::Metres(1.0) });
        let unit = if degrees { "degrees" } else { "metres" };
        warnings.push(format!(
            "{UNIT_GUESSED}: {unit} are assumed; say crs = \"EPSG:…\" in the sidecar \
             to be sure"
        ));
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_as_long_as_the_ground() {
        let size = [101, 101];
        let map = Georeference::new([-1.0, 60.5], [0.01, -0.01]).with_epsg(4326);
        let [east, north] = map.metres_per_sample(size).unwrap();
        // A degree at 60° is 55.80 km by 111.41 km.
        assert!((east - 558.0).abs() < 0.1 && (north - 1114.1).abs() < 0.1, "{east} {north}");
        assert_eq!(map.geographic_bounds(size), Some([-1.0, 59.5, 0.0, 60.5]));

        let utm = Georeference::new([500_000.0, 4_000_000.0], [30.0, -30.0]).with_epsg(32611);
        assert_eq!(utm.metres_per_sample(size), Some([30.0, 30.0]));
        let feet = Georeference { unit: Some(GroundUnit::Metres(0.3048)), ..utm.clone() }.with_epsg(2263);
        assert_eq!(feet.metres_per_sample(size), Some([30.0 * 0.3048; 2]), "a unit that is known stays");
        assert_eq!(Georeference::new([0.0, 0.0], [1.0, -1.0]).metres_per_sample(size), None);
        assert_eq!(Georeference::new([0.0, 900.0], [1.0, -1.0]).with_epsg(4326).metres_per_sample(size), None);
    }

    /// The stated distances of the shipped map were found with another program.
    #[test]
    fn web_mercator_is_corrected_by_the_latitude() {
        let step = 76.437_028_285_171_97;
        let north = 4_323_000.0;
        let map = Georeference::new([-12_500_000.0, north], [step, -step]).with_epsg(3857);
        let [east, south] = map.metres_per_sample([512, 512]).unwrap();
        let latitude = map.longitude_latitude(map.at(255.5, 255.5)).unwrap()[1];
        assert!((latitude - 36.1).abs() < 0.2, "{latitude}");
        assert!((east / south - 31566.9 / 31428.8).abs() < 1e-4, "{east} {south}");
    }

    /// Against PROJ: `cs2cs EPSG:32611 EPSG:4326`, and the same for 32719.
    #[test]
    fn utm_goes_back_to_degrees() {
        let there =
            |epsg, at| Georeference::new([0.0, 0.0], [1.0, -1.0]).with_epsg(epsg).longitude_latitude(at).unwrap();
        for (epsg, at, expected) in UTM {
            let got = there(epsg, at);
            assert!((got[0] - expected[0]).hypot(got[1] - expected[1]) < 1e-7, "{got:?} for {expected:?}");
        }
    }

    const UTM: [(u32, [f64; 2], [f64; 2]); 2] = [
        (32611, [250_000.0, 3_900_000.0], [-119.746_421_250_254_7, 35.211_910_798_187_034]),
        (32719, [700_000.0, 7_500_000.0], [-67.054_449_779_880_94, -22.595_067_595_103_338]),
    ];

    #[test]
    fn places_go_back_to_columns_and_systems_are_told_apart() {
        let turned =
            Georeference { row: [0.5, -3.0], column: [2.0, 0.25], ..Georeference::new([10.0, 20.0], [1.0, 1.0]) };
        let [column, row] = turned.column_row(turned.at(7.5, -2.0));
        assert!((column - 7.5).abs() < 1e-12 && (row + 2.0).abs() < 1e-12, "{column} {row}");
        let of = |epsg| Georeference::new([0.0, 0.0], [1.0, -1.0]).with_epsg(epsg);
        assert_eq!(of(32611).differs_from(&of(32612)).as_deref(), Some("EPSG:32611 against EPSG:32612"));
        assert_eq!(of(3857).differs_from(&of(900_913)), None, "one system by two numbers");
        assert_eq!(of(4326).differs_from(&Georeference::new([0.0, 0.0], [1.0, -1.0])), None, "nothing is known");
        // A degree of longitude is half as long at 60° as on the equator.
        let world = Georeference::new([-180.0, 90.0], [1.0, -1.0]).with_epsg(4326);
        let east = |row: f64| world.metres_per_step(100.0, row).unwrap()[0];
        assert!((east(30.0) / east(90.0) - 0.5).abs() < 2e-3);
    }

    #[test]
    fn the_other_end_and_a_part_are_the_same_ground() {
        let size = [10, 6];
        let map = Georeference::new([100.0, 50.0], [2.0, 3.0]);
        let turned = map.clone().turned(size, true, false);
        assert_eq!(turned.at(4.0, 0.0), map.at(4.0, 5.0));
        assert_eq!(turned.row, [0.0, -3.0]);
        let part = turned.clone().part([2, 1], 2);
        assert_eq!(part.at(0.0, 0.0), turned.at(2.5, 1.5));
        assert_eq!(part.at(1.0, 1.0), turned.at(4.5, 3.5));
    }

    #[test]
    fn projection_files_are_understood() {
        let utm = r#"PROJCS["WGS 84 / UTM zone 11N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],
            UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]],UNIT["metre",1,
            AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST],AXIS["Northing",NORTH],AUTHORITY["EPSG","32611"]]"#;
        assert_eq!(from_wkt(utm), Some(("EPSG:32611".into(), Some(32611), GroundUnit::Metres(1.0))));
        let esri = r#"GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;
        let (name, epsg, unit) = from_wkt(esri).unwrap();
        assert_eq!((name.as_str(), epsg), ("GCS_WGS_1984", None));
        assert!(matches!(unit, GroundUnit::Degrees(unit) if (unit - 1.0).abs() < 1e-9));
        let feet = r#"PROJCS["NAD_1983_StatePlane_New_York",GEOGCS["x",UNIT["Degree",0.017]],UNIT["Foot_US",0.3048006096012192]]"#;
        assert!(
            matches!(from_wkt(feet), Some((_, None, GroundUnit::Metres(unit))) if (unit - 0.304_800_609_6).abs() < 1e-9)
        );
        assert_eq!(from_wkt("hello"), None);
        assert_eq!(from_wkt("PROJCS["), Some(("unnamed".into(), None, GroundUnit::Metres(1.0))));
    }
}
