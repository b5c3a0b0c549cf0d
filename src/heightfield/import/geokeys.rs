//! GeoTIFF's tags: where raster and ground meet, and in which reference system.
//! (OGC 19-008r4, "GeoTIFF Standard" 1.1.)

use super::geo::from_wkt;
use super::{Georeference, GroundUnit, PixelIs, VerticalUnit};

/// The tags as they stand in a file; those that are absent are empty.
#[derive(Debug, Default)]
pub(super) struct GeoTags {
    /// ModelPixelScale: x, y, z.
    pub(super) scale: Vec<f64>,
    /// ModelTiepoint: column, row, layer, x, y, z, and so on.
    pub(super) tie_points: Vec<f64>,
    /// ModelTransformation: 4×4, row by row.
    pub(super) transformation: Vec<f64>,
    /// GeoKeyDirectory.
    pub(super) keys: Vec<u16>,
    /// GeoDoubleParams.
    pub(super) doubles: Vec<f64>,
    /// GeoAsciiParams.
    pub(super) texts: String,
}

/// Stands for "it is described elsewhere".
const USER_DEFINED: u16 = 32767;

mod key {
    pub(super) const MODEL_TYPE: u16 = 1024;
    pub(super) const RASTER_TYPE: u16 = 1025;
    pub(super) const CITATION: u16 = 1026;
    pub(super) const GEOGRAPHIC: u16 = 2048;
    pub(super) const GEOGRAPHIC_CITATION: u16 = 2049;
    pub(super) const ANGULAR_UNIT: u16 = 2054;
    pub(super) const PROJECTED: u16 = 3072;
    pub(super) const PROJECTED_CITATION: u16 = 3073;
    pub(super) const LINEAR_UNIT: u16 = 3076;
    pub(super) const LINEAR_UNIT_SIZE: u16 = 3077;
    pub(super) const VERTICAL_UNIT: u16 = 4099;
}

impl GeoTags {
    /// A key's number.
    fn number(&self, key: u16) -> Option<u16> {
        let entry = self.entries().find(|entry| entry[0] == key && entry[1] == 0)?;
        Some(entry[3]).filter(|&value| value != 0)
    }

    fn double(&self, key: u16) -> Option<f64> {
        let entry = self.entries().find(|entry| entry[0] == key && entry[1] == 34736)?;
        self.doubles.get(usize::from(entry[3])).copied()
    }

    fn text(&self, key: u16) -> Option<&str> {
        let entry = self.entries().find(|entry| entry[0] == key && entry[1] == 34737)?;
        let (start, count) = (usize::from(entry[3]), usize::from(entry[2]));
        let text = self.texts.get(start..(start + count).min(self.texts.len()))?;
        Some(text.trim_end_matches(['|', '\0', ' '])).filter(|text| !text.is_empty())
    }

    fn entries(&self) -> impl Iterator<Item = &[u16]> {
        self.keys.chunks_exact(4).skip(1)
    }

    /// What heights are measured in.
    pub(super) fn vertical_unit(&self) -> Option<VerticalUnit> {
        match self.number(key::VERTICAL_UNIT)? {
            9001 => Some(VerticalUnit::Metre),
            9002 => Some(VerticalUnit::Foot),
            9003 => Some(VerticalUnit::UsFoot),
            _ => None,
        }
    }

    /// Where the map lies; what cannot be made sense of becomes a warning.
    pub(super) fn place(&self, size: [u32; 2], warnings: &mut Vec<String>) -> Option<Georeference> {
        let place = self.transform(warnings)?;
        // What programs write where there is no place: columns and rows themselves.
        if self.number(key::MODEL_TYPE).is_none() && (place.column, place.row) == ([1.0, 0.0], [0.0, 1.0]) {
            return None;
        }
        Some(self.with_system(place, size, warnings))
    }

    fn transform(&self, warnings: &mut Vec<String>) -> Option<Georeference> {
        let pixel = if self.number(key::RASTER_TYPE) == Some(2) { PixelIs::Point } else { PixelIs::Area };
        // A cell's middle is half a cell from its corner, where the transformation counts from.
        let half = if pixel == PixelIs::Area { 0.5 } else { 0.0 };
        let corner = if let [a, b, _, d, e, f, _, h, ..] = self.transformation[..] {
            Georeference { column: [a, e], row: [b, f], ..Georeference::new([d, h], [1.0, 1.0]) }
        } else if let ([sx, sy, ..], [i, j, _, x, y, ..]) = (&self.scale[..], &self.tie_points[..]) {
            Georeference::new([x - i * sx, y + j * sy], [*sx, -sy])
        } else {
            if self.tie_points.len() > 6 {
                warnings.push("it is placed by control points, which are not supported: its place is unknown".into());
            }
            return None;
        };
        Some(Georeference { origin: corner.at(half, half), pixel, ..corner })
    }

    fn with_system(&self, mut place: Georeference, size: [u32; 2], warnings: &mut Vec<String>) -> Georeference {
        let number = |key: u16| self.number(key).filter(|&number| number != USER_DEFINED);
        let citation = [key::PROJECTED_CITATION, key::CITATION, key::GEOGRAPHIC_CITATION];
        let name = || citation.into_iter().find_map(|key| self.text(key)).map(str::to_owned);
        let geographic = self.number(key::GEOGRAPHIC);
        let model = self.number(key::MODEL_TYPE);
        if model == Some(1) || (model.is_none() && self.number(key::PROJECTED).is_some()) {
            place.unit = Some(GroundUnit::Metres(self.linear_unit(warnings)));
            let Some(epsg) = number(key::PROJECTED) else {
                return self.with_citation(place, name());
            };
            return place.with_epsg(epsg.into());
        }
        if model == Some(2) || geographic.is_some() {
            place.unit = Some(GroundUnit::Degrees(self.angular_unit(warnings)));
            let unit = place.unit;
            return match number(key::GEOGRAPHIC) {
                Some(epsg) => Georeference { unit, ..place.with_epsg(epsg.into()) },
                None => Georeference { crs: name(), ..place },
            };
        }
        if model == Some(3) {
            warnings.push("its coordinates are geocentric: its place is unknown".into());
            return place;
        }
        place.with_projection_file(None, size, warnings)
    }

    /// A system that is only described. Esri puts its well-known text into the citation.
    fn with_citation(&self, mut place: Georeference, name: Option<String>) -> Georeference {
        let name = name.map(|name| name.split("ESRI PE String = ").last().unwrap_or_default().to_owned());
        if let Some((crs, epsg, unit)) = name.as_deref().and_then(from_wkt) {
            (place.crs, place.epsg, place.unit) = (Some(crs), epsg, Some(unit));
            return place;
        }
        let upper = name.as_deref().unwrap_or_default().to_ascii_uppercase().replace(['_', '-'], " ");
        if upper.contains("PSEUDO MERCATOR")
            || upper.contains("WEB MERCATOR")
            || upper.contains("POPULAR VISUALISATION")
        {
            place.unit = Some(GroundUnit::WebMercator);
        }
        Georeference { crs: name, ..place }
    }

    fn linear_unit(&self, warnings: &mut Vec<String>) -> f64 {
        match self.number(key::LINEAR_UNIT) {
            None | Some(9001) => 1.0,
            Some(9002) => 0.3048,
            Some(9003) => 1200.0 / 3937.0,
            Some(9036) => 1000.0,
            Some(other) => {
                let size = self.double(key::LINEAR_UNIT_SIZE).filter(|size| size.is_finite() && *size > 0.0);
                size.unwrap_or_else(|| {
                    warnings.push(format!("its unit of length has the number {other}: metres are assumed"));
                    1.0
                })
            }
        }
    }

    fn angular_unit(&self, warnings: &mut Vec<String>) -> f64 {
        match self.number(key::ANGULAR_UNIT) {
            None | Some(9102 | 9122) => 1.0,
            Some(9101) => 1f64.to_degrees(),
            Some(9103) => 1.0 / 60.0,
            Some(9104) => 1.0 / 3600.0,
            Some(9105 | 9106) => 0.9,
            Some(other) => {
                warnings.push(format!("its unit of angles has the number {other}: degrees are assumed"));
                1.0
            }
        }
    }
}

/// The tags that say of a written map what is known of its place.
pub(crate) fn tags_of(place: &Georeference, vertical: Option<VerticalUnit>) -> (Vec<f64>, Vec<u16>, String) {
    let half = if place.pixel == PixelIs::Area { -0.5 } else { 0.0 };
    let [x, y] = place.at(half, half);
    let ([a, e], [b, f]) = (place.column, place.row);
    let transformation = vec![a, b, 0.0, x, e, f, 0.0, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

    let raster = if place.pixel == PixelIs::Area { 1 } else { 2 };
    let mut entries: Vec<[u16; 4]> = vec![[key::RASTER_TYPE, 0, 1, raster]];
    let mut texts = String::new();
    let epsg = place.epsg.and_then(|epsg| u16::try_from(epsg).ok());
    let mut cite = |key: u16, text: &str| {
        let start = texts.len() as u16;
        texts.push_str(&text.chars().filter(|c| c.is_ascii() && *c != '|').take(1000).collect::<String>());
        texts.push('|');
        [key, 34737, texts.len() as u16 - start, start]
    };
    match place.unit {
        Some(GroundUnit::Degrees(unit)) => {
            entries.push([key::MODEL_TYPE, 0, 1, 2]);
            entries.push([key::GEOGRAPHIC, 0, 1, epsg.unwrap_or(USER_DEFINED)]);
            let code = if unit == 1f64.to_degrees() { 9101 } else { 9102 };
            entries.push([key::ANGULAR_UNIT, 0, 1, code]);
            if let (None, Some(crs)) = (epsg, &place.crs) {
                entries.push(cite(key::GEOGRAPHIC_CITATION, crs));
            }
        }
        Some(GroundUnit::Metres(unit)) => {
            entries.push([key::MODEL_TYPE, 0, 1, 1]);
            entries.push([key::PROJECTED, 0, 1, epsg.unwrap_or(USER_DEFINED)]);
            let code = [(0.3048, 9002), (1200.0 / 3937.0, 9003), (1000.0, 9036)];
            let code = code.into_iter().find(|(metres, _)| (metres - unit).abs() < 1e-9);
            entries.push([key::LINEAR_UNIT, 0, 1, code.map_or(9001, |(_, code)| code)]);
            if let (None, Some(crs)) = (epsg, &place.crs) {
                entries.push(cite(key::PROJECTED_CITATION, crs));
            }
        }
        Some(GroundUnit::WebMercator) => {
            entries.push([key::MODEL_TYPE, 0, 1, 1]);
            entries.push([key::PROJECTED, 0, 1, 3857]);
        }
        None => {}
    }
    if let Some(vertical) = vertical {
        let code = match vertical {
            VerticalUnit::Metre => 9001,
            VerticalUnit::Foot => 9002,
            VerticalUnit::UsFoot => 9003,
        };
        entries.push([key::VERTICAL_UNIT, 0, 1, code]);
    }
    entries.sort_unstable();
    let mut keys = vec![1, 1, 0, entries.len() as u16];
    keys.extend(entries.concat());
    (transformation, keys, texts)
}
