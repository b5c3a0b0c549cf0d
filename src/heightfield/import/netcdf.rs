//! NetCDF files of the classic formats: the variable with two dimensions, its attributes and its coordinates.
//! (Climate and Forecast conventions: `_FillValue`, `missing_value`, `scale_factor`, `add_offset`, `units`, `positive`.)

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::geo::from_wkt;
use super::netcdf_header::{Header, Type, Variable};
use super::source::{Fault, Source, one_line};
use super::{Elevation, Format, Georeference, GroundUnit, ImportOptions, PixelIs, Rows, Sample, VerticalUnit};

/// Names that heights go by.
const NAMES: [&str; 12] = [
    "elevation",
    "elev",
    "topo",
    "topography",
    "height",
    "altitude",
    "bathymetry",
    "orog",
    "dem",
    "z",
    "band1",
    "rose",
];

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let header = Header::read(source)?;
    let mut warnings = Vec::new();
    let variable = choose(&header, options.variable.as_deref(), &mut warnings)?;
    match variable.kind {
        Type::I8 => read::<i8>(source, options, &header, variable, warnings),
        Type::U8 => read::<u8>(source, options, &header, variable, warnings),
        Type::I16 => read::<i16>(source, options, &header, variable, warnings),
        Type::U16 => read::<u16>(source, options, &header, variable, warnings),
        Type::I32 => read::<i32>(source, options, &header, variable, warnings),
        Type::U32 => read::<u32>(source, options, &header, variable, warnings),
        Type::F32 => read::<f32>(source, options, &header, variable, warnings),
        Type::F64 => read::<f64>(source, options, &header, variable, warnings),
        Type::Char | Type::I64 | Type::U64 => Err(Fault::Unsupported(
            format!("a variable of the type {:?}", variable.kind),
            "choose another with --variable, or convert it to f32",
        )),
    }
}

/// The variable to show: the one asked for, else the one whose name or unit says it is heights, else the first with two
/// dimensions.
fn choose<'a>(header: &'a Header, asked: Option<&str>, warnings: &mut Vec<String>) -> Result<&'a Variable, Fault> {
    let is_grid = |variable: &Variable| {
        let lengths = header.lengths(variable);
        lengths.len() >= 2 && lengths[lengths.len() - 2..].iter().all(|&length| length >= 2)
    };
    let is_bounds = |variable: &Variable| {
        let name = variable.name.to_lowercase();
        name.ends_with("_bnds") || name.ends_with("_bounds") || variable.kind == Type::Char
    };
    let grids: Vec<&Variable> =
        header.variables.iter().filter(|variable| is_grid(variable) && !is_bounds(variable)).collect();
    let names = || grids.iter().take(20).map(|grid| one_line(&grid.name)).collect::<Vec<_>>().join(", ");
    if let Some(asked) = asked {
        return grids.iter().copied().find(|grid| grid.name == asked).ok_or_else(|| {
            Fault::Unclear(
                format!("it has no variable \"{asked}\" with two dimensions"),
                format!("choose --variable among {}", names()),
            )
        });
    }
    let score = |grid: &Variable| {
        let name = grid.name.to_lowercase();
        let by_name = NAMES.iter().position(|known| name == *known).map_or(0, |at| 40 - at);
        let standard = grid.text("standard_name").unwrap_or_default();
        let by_standard = if ["altitude", "height", "surface_altitude"].contains(&standard.as_str()) { 50 } else { 0 };
        by_name
            + by_standard
            + usize::from(vertical_unit(grid).is_some()) * 20
            + usize::from(grid.dimensions.len() == 2)
    };
    let best = grids.iter().copied().rev().max_by_key(|grid| score(grid));
    let best = best.ok_or_else(|| {
        Fault::Unsupported(
            "no variable with two dimensions".into(),
            "convert the grid to GeoTIFF, or write it with two",
        )
    })?;
    if grids.len() > 1 {
        warnings.push(format!(
            "the variable \"{}\" is taken; choose with --variable among {}",
            one_line(&best.name),
            names()
        ));
    }
    Ok(best)
}

fn read<T: Sample>(
    source: &mut Source,
    options: &ImportOptions,
    header: &Header,
    variable: &Variable,
    mut warnings: Vec<String>,
) -> Result<Elevation, Fault> {
    let lengths = header.lengths(variable);
    let [.., rows, columns] = lengths[..] else { return Err(Fault::Damaged("a grid without two sides".into())) };
    let in_records =
        variable.dimensions.first().copied() == header.record_dimension && header.record_dimension.is_some();
    let packed = columns.saturating_mul(T::BYTES as u64);
    let stride = if in_records && lengths.len() == 2 { header.record_bytes.max(packed) } else { packed };
    let end = rows.saturating_sub(1).saturating_mul(stride).saturating_add(packed).saturating_add(variable.begin);
    if end > source.bytes {
        return Err(Fault::Promises([columns, rows]));
    }
    if lengths[..lengths.len() - 2].iter().any(|&length| length > 1) {
        warnings
            .push(format!("\"{}\" has more than two dimensions: its first layer is taken", one_line(&variable.name)));
    }
    let plan = Plan::new(columns, rows, options)?;
    let size = [columns as u32, rows as u32];
    let place = place(source, header, variable, size, &mut warnings)?;
    let (south_first, east_first) =
        place.as_ref().map_or((false, false), |place| (place.row[1] > 0.0, place.column[0] < 0.0));
    let order = Order { south_first: south_first != (options.flip == Some(true)), east_first };
    let missing = ["_FillValue", "missing_value"].into_iter().filter_map(|name| variable.number(name));
    let mut gatherer = Gatherer::<T>::new(plan, order, &nodata_values(options, &missing.collect::<Vec<_>>()));
    source.seek(variable.begin)?;
    let rows = Rows { stride: stride as usize, ..Rows::packed::<T>(columns as usize, true) };
    rows.gather(source, &mut gatherer)?;

    let mut elevation = gatherer.finish(Format::NetCdf)?;
    elevation.warnings.extend(warnings);
    let down = variable.text("positive").is_some_and(|positive| positive.eq_ignore_ascii_case("down"));
    let sound = |value: f64| value.is_finite() && value != 0.0;
    elevation.scale = variable.number("scale_factor").filter(|&value| sound(value)).unwrap_or(1.0);
    elevation.offset = variable.number("add_offset").filter(|value| value.is_finite()).unwrap_or(0.0);
    if down {
        (elevation.scale, elevation.offset) = (-elevation.scale, -elevation.offset);
        elevation.warnings.push("its numbers are depths, positive downwards: they were turned into heights".into());
    }
    elevation.vertical_unit = vertical_unit(variable).or(Some(VerticalUnit::Metre));
    elevation.georeference = place.map(|place| place.turned(size, south_first, east_first));
    Ok(elevation)
}

fn vertical_unit(variable: &Variable) -> Option<VerticalUnit> {
    match variable.text("units")?.to_lowercase().as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => Some(VerticalUnit::Metre),
        "ft" | "foot" | "feet" => Some(VerticalUnit::Foot),
        "us_survey_foot" | "us_survey_feet" => Some(VerticalUnit::UsFoot),
        _ => None,
    }
}

/// The place of the grid from its coordinate variables: first value and mean step of each.
fn place(
    source: &mut Source,
    header: &Header,
    variable: &Variable,
    size: [u32; 2],
    warnings: &mut Vec<String>,
) -> Result<Option<Georeference>, Fault> {
    let [.., row, column] = variable.dimensions[..] else { return Ok(None) };
    let of = |dimension: usize| {
        let name = &header.dimensions[dimension].0;
        header.variables.iter().find(|axis| &axis.name == name && axis.dimensions == [dimension])
    };
    let (Some(x), Some(y)) = (of(column), of(row)) else { return Ok(None) };
    let units = |axis: &Variable| axis.text("units").unwrap_or_default().to_lowercase();
    if units(x).contains("north") && units(y).contains("east") {
        return Err(Fault::Unsupported(
            "a grid whose rows run from south to north".into(),
            "swap its dimensions, with ncpdq for instance, or convert it to GeoTIFF",
        ));
    }
    let (Some([west, dx]), Some([first, dy])) = (steps(source, header, x)?, steps(source, header, y)?) else {
        return Ok(None);
    };
    let mut place = Georeference { pixel: PixelIs::Point, ..Georeference::new([west, first], [dx, dy]) };
    let mapping = variable.text("grid_mapping");
    let mapping = header.variables.iter().find(|found| Some(&found.name) == mapping.as_ref());
    let wkt = mapping.and_then(|found| found.text("crs_wkt").or(found.text("spatial_ref")));
    if let Some((crs, epsg, unit)) = wkt.as_deref().and_then(from_wkt) {
        (place.crs, place.epsg, place.unit) = (Some(crs), epsg, Some(unit));
        return Ok(Some(place));
    }
    match units(x).as_str() {
        unit if unit.starts_with("degree") => place.unit = Some(GroundUnit::Degrees(1.0)),
        "m" | "meter" | "meters" | "metre" | "metres" => place.unit = Some(GroundUnit::Metres(1.0)),
        "km" => place.unit = Some(GroundUnit::Metres(1000.0)),
        _ => place = place.with_projection_file(None, size, warnings),
    }
    Ok(Some(place))
}

/// First value and mean step of a coordinate.
fn steps(source: &mut Source, header: &Header, axis: &Variable) -> Result<Option<[f64; 2]>, Fault> {
    let count = header.lengths(axis).first().copied().unwrap_or_default();
    let in_records = header.record_dimension.is_some() && axis.dimensions.first().copied() == header.record_dimension;
    let stride = if in_records { header.record_bytes } else { axis.kind.bytes() };
    let last = axis.begin.saturating_add(count.saturating_sub(1).saturating_mul(stride));
    if count < 2 || last.saturating_add(axis.kind.bytes()) > source.bytes {
        return Ok(None);
    }
    let mut value_at = |at: u64| {
        source.seek(at)?;
        Ok::<_, Fault>(axis.kind.value(&source.take(axis.kind.bytes() as usize)?))
    };
    let (first, last) = (value_at(axis.begin)?, value_at(last)?);
    let step = (last - first) / (count - 1) as f64;
    Ok((step.is_finite() && step != 0.0).then_some([first, step]))
}
