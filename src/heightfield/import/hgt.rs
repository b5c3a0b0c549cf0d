//! SRTM tiles: 16-bit integers, most significant byte first, no header. The size tells the grid, the name the place.

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source};
use super::{Elevation, Format, Georeference, GroundUnit, ImportOptions, PixelIs, Rows, VerticalUnit};

/// Means "no height".
const VOID: f64 = -32768.0;

/// The grids there are: columns and rows over one degree.
const GRIDS: [[u32; 2]; 5] = [[1201, 1201], [3601, 3601], [1801, 3601], [601, 1201], [7201, 7201]];

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let holds = |&[width, height]: &[u32; 2]| u64::from(width) * u64::from(height) * 2 == source.bytes;
    let Some(size) = GRIDS.into_iter().find(holds) else {
        return Err(Fault::Damaged(format!(
            "{} bytes are no tile of 1201×1201 or 3601×3601 samples, which has 2,884,802 or 25,934,402",
            source.bytes
        )));
    };
    let plan = Plan::new(u64::from(size[0]), u64::from(size[1]), options)?;
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<i16>::new(plan, order, &nodata_values(options, &[VOID]));
    Rows::packed::<i16>(size[0] as usize, true).gather(source, &mut gatherer)?;
    let mut elevation = gatherer.finish(Format::Hgt)?;
    elevation.vertical_unit = Some(VerticalUnit::Metre);

    let step = size.map(|side| 1.0 / f64::from(side - 1));
    let name = source.path.file_stem().map(|stem| stem.to_string_lossy().to_ascii_uppercase()).unwrap_or_default();
    let mut place = match corner(&name) {
        Some([west, south]) => Georeference::new([west, south + 1.0], [step[0], -step[1]]).with_epsg(4326),
        None => {
            elevation.warnings.push(
                "its name does not say where it lies, as N36W113.hgt does: its step is taken as that at the equator"
                    .into(),
            );
            let unit = Some(GroundUnit::Degrees(1.0));
            Georeference { unit, ..Georeference::new([-0.5, 0.5], [step[0], -step[1]]) }
        }
    };
    place.pixel = PixelIs::Point;
    elevation.georeference = Some(place);
    Ok(elevation)
}

/// West and south of the tile with this name, as in N36W113.
fn corner(name: &str) -> Option<[f64; 2]> {
    let (latitude, rest) = name.split_at_checked(3)?;
    let degrees = |text: &str, positive: char, negative: char, most: f64| {
        let sign = match text.chars().next()? {
            c if c == positive => 1.0,
            c if c == negative => -1.0,
            _ => return None,
        };
        let value = text.get(1..)?.parse::<u32>().ok()?;
        Some(sign * f64::from(value)).filter(|value| value.abs() <= most)
    };
    let longitude = rest.get(..4)?;
    Some([degrees(longitude, 'E', 'W', 180.0)?, degrees(latitude, 'N', 'S', 90.0)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_tells_the_south_western_corner() {
        assert_eq!(corner("N36W113"), Some([-113.0, 36.0]));
        assert_eq!(corner("S07E009.SRTMGL1"), Some([9.0, -7.0]));
        for wrong in ["", "N36", "X36W113", "N3", "N36W11", "N99W113", "N36W999", "ÄÖÜ", "N36é13"] {
            assert_eq!(corner(wrong), None, "{wrong}");
        }
    }
}
