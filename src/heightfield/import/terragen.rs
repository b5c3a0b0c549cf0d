//! Terragen terrains: chunks after a magic, the last one with 16-bit altitudes, southern row first.

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source};
use super::{Elevation, Format, Georeference, GroundUnit, ImportOptions, PixelIs, Rows, VerticalUnit};

/// Metres per terrain unit where the file does not say.
const USUAL_SCALE: f32 = 30.0;

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    source.seek(16)?;
    let (mut size, mut scale) = ([0u16; 2], [USUAL_SCALE; 3]);
    loop {
        let marker = source.take(4)?;
        let short = |bytes: &[u8], at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        match marker.as_slice() {
            b"SIZE" => {
                // The shorter side less one; sides of their own follow where the map is not square.
                let side = short(&source.take(4)?, 0).saturating_add(1);
                size = size.map(|known| if known == 0 { side } else { known });
            }
            b"XPTS" => size[0] = short(&source.take(4)?, 0),
            b"YPTS" => size[1] = short(&source.take(4)?, 0),
            b"SCAL" => {
                let bytes = source.take(12)?;
                let number = |at: usize| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
                scale = [number(0), number(4), number(8)];
            }
            b"CRAD" => drop(source.take(4)?),
            b"CRVM" => drop(source.take(4)?),
            b"ALTW" => break,
            b"EOF " => return Err(Fault::Damaged("it ends without altitudes".into())),
            other => {
                let name: String = other.iter().map(|&byte| char::from(byte)).filter(char::is_ascii_graphic).collect();
                return Err(Fault::Unsupported(
                    format!("a chunk called \"{name}\""),
                    "save it again with a terrain editor, or convert it to GeoTIFF",
                ));
            }
        }
    }
    let head = source.take(4)?;
    let (rise, base) = (i16::from_le_bytes([head[0], head[1]]), i16::from_le_bytes([head[2], head[3]]));
    let [width, height] = size.map(u64::from);
    if width * height * 2 > source.bytes {
        return Err(Fault::Promises([width, height]));
    }
    let plan = Plan::new(width, height, options)?;
    let order = Order { south_first: options.flip != Some(true), east_first: false };
    let mut gatherer = Gatherer::<i16>::new(plan, order, &nodata_values(options, &[]));
    Rows::packed::<i16>(width as usize, false).gather(source, &mut gatherer)?;
    let mut elevation = gatherer.finish(Format::Terragen)?;

    if scale.iter().all(|scale| scale.is_finite() && *scale > 0.0) {
        let [x, y, z] = scale.map(f64::from);
        elevation.scale = f64::from(rise) / 65536.0 * z;
        elevation.offset = f64::from(base) * z;
        elevation.georeference = Some(Georeference {
            unit: Some(GroundUnit::Metres(1.0)),
            pixel: PixelIs::Point,
            ..Georeference::new([0.0, y * (height - 1) as f64], [x, -y])
        });
        elevation.vertical_unit = Some(VerticalUnit::Metre);
    } else {
        (elevation.scale, elevation.offset) = (f64::from(rise) / 65536.0, f64::from(base));
        elevation.metric = false;
        elevation.warnings.push(format!("its scale {scale:?} is none, and was ignored"));
    }
    if rise == 0 {
        elevation.scale = 1.0 / 65536.0;
        elevation.warnings.push("its height scale is 0, which would make it flat: 1 is taken".into());
    }
    Ok(elevation)
}
