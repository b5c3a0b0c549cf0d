//! USGS ASCII DEM: records of 1024 characters, Fortran's numbers in fixed columns, one profile per column of the map,
//! each from south to north and of its own length.
//! (U.S. Geological Survey: "Standards for Digital Elevation Models", part 2.)

use std::io::Read;

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source, one_line};
use super::{Elevation, Format, Georeference, GroundUnit, ImportOptions, PixelIs, VerticalUnit};

/// Bytes of a record.
const RECORD: usize = 1024;
/// Mean "no height".
const VOIDS: [f64; 2] = [-32767.0, -32768.0];
/// Stands where no profile reaches.
const NOTHING: f32 = f32::NAN;

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let head = Head::read(&record(source)?.ok_or(Fault::Truncated)?)?;
    // Each profile has a record of its own.
    if head.columns.saturating_mul(RECORD as u64 / 2) > source.bytes {
        return Err(Fault::Promises([head.columns, 0]));
    }
    let voids = nodata_values(options, &VOIDS);
    let mut profiles = Vec::with_capacity(head.columns as usize);
    for _ in 0..head.columns {
        let text = record(source)?.ok_or(Fault::Truncated)?;
        profiles.push(Profile::read(source, &head, text, &voids)?);
    }
    let of =
        |profile: &Profile| (profile.south, profile.south + head.step[1] * (profile.heights.len().max(1) - 1) as f64);
    let south = profiles.iter().map(|profile| of(profile).0).fold(f64::INFINITY, f64::min);
    let north = profiles.iter().map(|profile| of(profile).1).fold(f64::NEG_INFINITY, f64::max);
    let west = profiles.iter().map(|profile| profile.west).fold(f64::INFINITY, f64::min);
    let rows = ((north - south) / head.step[1]).round() + 1.0;
    // Six characters a height; at most five sixths of the grid are beside the profiles.
    if rows.is_nan() || rows * head.columns as f64 > source.bytes as f64 {
        return Err(Fault::Damaged("its profiles lie too far apart for a grid".into()));
    }
    let rows = rows as u64;
    let plan = Plan::new(head.columns, rows, options)?;
    let mut grid = vec![NOTHING; (rows * head.columns) as usize];
    for (column, profile) in profiles.iter().enumerate() {
        let first = ((profile.south - south) / head.step[1]).round() as u64;
        for (index, &height) in profile.heights.iter().enumerate() {
            if let Some(row) = (rows - 1).checked_sub(first + index as u64) {
                grid[(row * head.columns) as usize + column] = height;
            }
        }
    }
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<f32>::new(plan, order, &[]);
    gatherer.push(&grid);
    let mut elevation = gatherer.finish(Format::UsgsDem)?;
    elevation.vertical_unit = Some(head.vertical);
    if head.whole {
        elevation.sample_type = "i32";
    }
    let origin = [west, south + head.step[1] * (rows - 1) as f64];
    let place = Georeference::new(origin, [head.step[0], -head.step[1]]);
    let epsg = match (head.system, head.zone) {
        (1, zone @ 1..=60) => Some(26900 + zone).filter(|&epsg| epsg <= 26923),
        _ => None,
    };
    let unit = Some(head.ground);
    let place = Georeference { pixel: PixelIs::Point, unit, ..place };
    elevation.georeference = Some(match (epsg, head.ground) {
        (Some(epsg), GroundUnit::Metres(_)) => {
            elevation.warnings.push("its datum is taken as NAD83".into());
            place.with_epsg(epsg)
        }
        (_, GroundUnit::Degrees(unit)) => Georeference {
            crs: Some("longitude, latitude".into()),
            unit: Some(GroundUnit::Degrees(1.0)),
            origin: place.origin.map(|at| at * unit),
            column: place.column.map(|at| at * unit),
            row: place.row.map(|at| at * unit),
            ..place
        },
        _ => place,
    });
    Ok(elevation)
}

/// The next record, which may be cut short at the end of the file and is then padded; `None` at the end.
fn record(source: &mut Source) -> Result<Option<Vec<u8>>, Fault> {
    let mut text = Vec::with_capacity(RECORD);
    source.reader.by_ref().take(RECORD as u64).read_to_end(&mut text)?;
    if text.is_empty() {
        return Ok(None);
    }
    text.resize(RECORD, b' ');
    Ok(Some(text))
}

/// The number in some columns, counted from 0; Fortran writes `D` for the exponent. Blank is 0.
fn number(record: &[u8], at: usize, width: usize) -> Result<f64, Fault> {
    let field = record.get(at..at + width).unwrap_or_default();
    let text: String =
        field.iter().map(|&byte| if matches!(byte, b'D' | b'd') { 'e' } else { char::from(byte) }).collect();
    match text.trim() {
        "" => Ok(0.0),
        text => match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(Fault::Damaged(format!("\"{}\" is no number", one_line(text)))),
        },
    }
}

/// What the first record says.
struct Head {
    columns: u64,
    /// Between columns and rows.
    step: [f64; 2],
    /// Of a height.
    resolution: f64,
    whole: bool,
    ground: GroundUnit,
    vertical: VerticalUnit,
    /// 0 geographic, 1 UTM, 2 State Plane.
    system: u32,
    zone: u32,
}

impl Head {
    fn read(record: &[u8]) -> Result<Self, Fault> {
        let ground = match number(record, 528, 6)? as i64 {
            0 => GroundUnit::Degrees(1f64.to_degrees()),
            1 => GroundUnit::Metres(0.3048),
            2 => GroundUnit::Metres(1.0),
            3 => GroundUnit::Degrees(1.0 / 3600.0),
            other => return Err(Fault::Damaged(format!("its ground unit has the number {other}"))),
        };
        let vertical = match number(record, 534, 6)? as i64 {
            1 => VerticalUnit::Foot,
            2 => VerticalUnit::Metre,
            other => return Err(Fault::Damaged(format!("its unit of height has the number {other}"))),
        };
        let step = [number(record, 816, 12)?, number(record, 828, 12)?];
        let resolution = number(record, 840, 12)?;
        let columns = number(record, 858, 6)?;
        if step.iter().any(|&step| step <= 0.0) || resolution <= 0.0 {
            return Err(Fault::Damaged("its spatial resolution is not above 0".into()));
        }
        if !(2.0..1e6).contains(&columns) {
            return Err(Fault::TooSmall([columns.max(0.0) as u64, 0]));
        }
        Ok(Self {
            columns: columns as u64,
            step,
            resolution,
            whole: resolution == 1.0,
            ground,
            vertical,
            system: number(record, 156, 6)?.clamp(0.0, 9.0) as u32,
            zone: number(record, 162, 6)?.clamp(0.0, 99.0) as u32,
        })
    }
}

/// One column of the map.
struct Profile {
    /// Of its first, southernmost height.
    west: f64,
    south: f64,
    heights: Vec<f32>,
}

impl Profile {
    /// Reads the profile whose first record is `text`.
    fn read(source: &mut Source, head: &Head, text: Vec<u8>, voids: &[f64]) -> Result<Self, Fault> {
        let (rows, columns) = (number(&text, 12, 6)?, number(&text, 18, 6)?);
        if columns != 1.0 || !(0.0..=source.bytes as f64).contains(&rows) {
            return Err(Fault::Damaged(format!("a profile says it has {rows} by {columns} heights")));
        }
        let (west, south, datum) = (number(&text, 24, 24)?, number(&text, 48, 24)?, number(&text, 72, 24)?);
        let mut heights = Vec::new();
        let (mut text, mut at) = (text, 144);
        for _ in 0..rows as u64 {
            // 146 heights in a profile's first record, 170 in each that follows.
            if at + 6 > RECORD - 4 {
                text = record(source)?.ok_or(Fault::Truncated)?;
                at = 0;
            }
            let value = number(&text, at, 6)?;
            at += 6;
            let height = (value * head.resolution + datum) as f32;
            heights.push(if voids.contains(&value) { NOTHING } else { height });
        }
        Ok(Self { west, south, heights })
    }
}
