//! Samples without a header: `.r8`, `.r16`, `.r32`, `.raw`.

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source};
use super::{Elevation, Endian, Format, ImportOptions, RawType, Rows, Sample};

const ADVICE: &str = "say --raw-size WIDTHxHEIGHT, and --raw-type, --raw-endian and --flip where they differ from \
                      little-endian u16 (.r16, .raw), f32 (.r32) or u8 (.r8), the northern row first";

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let mut warnings = Vec::new();
    let (kind, [width, height]) = layout(source, options, &mut warnings)?;
    let needed = (u64::from(width) * u64::from(height)).saturating_mul(kind.bytes());
    let Some(left) = source.bytes.checked_sub(needed) else {
        return Err(Fault::Unclear(
            format!(
                "its {} bytes are too few for {width}×{height} samples of {}, which take {needed}",
                source.bytes,
                kind.name()
            ),
            "correct --raw-size WxH and --raw-type, here or as raw_size and raw_type in its sidecar; if they are right, the \
             file is truncated: save or download it again"
                .into(),
        ));
    };
    if left > 0 {
        warnings.push(format!("{left} bytes after its {width}×{height} samples of {} were left out", kind.name()));
    }
    let mut elevation = match kind {
        RawType::U8 => read::<u8>(source, options, [width, height]),
        RawType::I8 => read::<i8>(source, options, [width, height]),
        RawType::U16 => read::<u16>(source, options, [width, height]),
        RawType::I16 => read::<i16>(source, options, [width, height]),
        RawType::U32 => read::<u32>(source, options, [width, height]),
        RawType::I32 => read::<i32>(source, options, [width, height]),
        RawType::F32 => read::<f32>(source, options, [width, height]),
        RawType::F64 => read::<f64>(source, options, [width, height]),
    }?;
    elevation.warnings.extend(warnings);
    // Integers are shades, floats are usually heights; neither has a place.
    elevation.metric = false;
    Ok(elevation)
}

fn read<T: Sample>(
    source: &mut Source,
    options: &ImportOptions,
    [width, height]: [u32; 2],
) -> Result<Elevation, Fault> {
    let plan = Plan::new(width.into(), height.into(), options)?;
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<T>::new(plan, order, &nodata_values(options, &[]));
    Rows::packed::<T>(width as usize, options.raw_endian == Some(Endian::Big)).gather(source, &mut gatherer)?;
    gatherer.finish(Format::Raw)
}

/// The type and the size: as said, else by the ending and the length.
fn layout(source: &Source, options: &ImportOptions, warnings: &mut Vec<String>) -> Result<(RawType, [u32; 2]), Fault> {
    let extension = source.path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let by_name = match extension.as_deref() {
        Some("r8") => Some(RawType::U8),
        Some("r16") => Some(RawType::U16),
        Some("r32") => Some(RawType::F32),
        _ => None,
    };
    let square = |kind: RawType| {
        let count = source.bytes / kind.bytes();
        let side = count.isqrt();
        (side >= 2 && side * side * kind.bytes() == source.bytes).then_some(side as u32)
    };
    match (options.raw_type.or(by_name), options.raw_size) {
        (Some(kind), Some(size)) => Ok((kind, size)),
        (Some(kind), None) => match square(kind) {
            Some(side) => Ok((kind, [side; 2])),
            None => Err(Fault::Unclear(
                format!(
                    "its {} bytes are no square of {} samples, and nothing in it says its size",
                    source.bytes,
                    kind.name()
                ),
                ADVICE.into(),
            )),
        },
        (None, Some(size)) => {
            let count = u64::from(size[0]) * u64::from(size[1]);
            let fitting = [RawType::U16, RawType::U8, RawType::F32, RawType::F64]
                .into_iter()
                .find(|kind| count.checked_mul(kind.bytes()) == Some(source.bytes));
            let kind = fitting.unwrap_or(RawType::U16);
            warnings.push(format!("nothing in it says the type of its samples: {} is assumed", kind.name()));
            Ok((kind, size))
        }
        (None, None) => {
            let found = [RawType::U16, RawType::U8].into_iter().find_map(|kind| Some((kind, square(kind)?)));
            let Some((kind, side)) = found else {
                return Err(Fault::Unclear(
                    format!("its {} bytes are no square of samples, and nothing in it says its size", source.bytes),
                    ADVICE.into(),
                ));
            };
            warnings.push(format!(
                "nothing in it says its size and type: {side}×{side} samples of {} are assumed; say --raw-size and \
                 --raw-type to be sure",
                kind.name()
            ));
            Ok((kind, [side; 2]))
        }
    }
}
