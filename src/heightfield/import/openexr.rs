//! OpenEXR pictures: one channel of the first layer, 16- or 32-bit floats or 32-bit integers.

use std::io::Read;

use exr::image::FlatSamples;
use exr::meta::MetaData;
use exr::prelude::{Compression, Error, ReadChannels, ReadLayers, SampleType};

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source, one_line};
use super::{Elevation, Format, ImportOptions, Sample};

/// Names that heights go by.
const NAMES: [&str; 6] = ["Y", "Z", "height", "H", "elevation", "depth"];

/// Most bytes that a header may take.
const MOST_HEADER: u64 = 1 << 20;

fn fault(error: Error) -> Fault {
    match error {
        Error::NotSupported(what) => {
            Fault::Unsupported(one_line(&what), "save it with ZIP compression and without deep data")
        }
        Error::Io(error) => Fault::from(error),
        Error::Aborted => Fault::Damaged("its header has no end".into()),
        Error::Invalid(what) => Fault::Damaged(one_line(&what)),
    }
}

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let head = MetaData::read_from_buffered(source.reader.by_ref().take(MOST_HEADER), false).map_err(fault)?;
    let Some(layer) = head.headers.iter().find(|header| !header.deep) else {
        return Err(Fault::Unsupported("deep data".into(), "flatten it to one sample a pixel"));
    };
    let size = [layer.layer_size.width(), layer.layer_size.height()].map(|side| side as u64);
    let ratio: u64 = match layer.compression {
        Compression::Uncompressed => 1,
        Compression::RLE => 128,
        _ => 2048,
    };
    let bytes: u64 =
        layer.channels.list.iter().map(|channel| if channel.sample_type == SampleType::F16 { 2 } else { 4 }).sum();
    if size[0].saturating_mul(size[1]).saturating_mul(bytes) > source.bytes.saturating_mul(ratio) {
        return Err(Fault::Promises(size));
    }
    let names: Vec<String> = layer.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let compression = layer.compression.to_string();
    let plan = Plan::new(size[0], size[1], options)?;
    let mut warnings = Vec::new();
    let chosen = choose(&names, options.variable.as_deref(), &mut warnings)?.to_owned();

    source.seek(0)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(&mut source.reader)
        .map_err(fault)?;
    let channels = image.layer_data.channel_data.list;
    let Some(channel) = channels.into_iter().find(|channel| channel.name.to_string() == chosen) else {
        return Err(Fault::Damaged(format!("its channel {} is missing", one_line(&chosen))));
    };
    if channel.sampling.width() != 1 || channel.sampling.height() != 1 {
        return Err(Fault::Unsupported("a channel with fewer samples than pixels".into(), "save it with one a pixel"));
    }
    let mut elevation = match channel.sample_data {
        FlatSamples::F16(samples) => {
            let samples: Vec<f32> = samples.into_iter().map(exr::prelude::f16::to_f32).collect();
            gathered(&samples, plan, options).map(|elevation| Elevation { sample_type: "f16", ..elevation })
        }
        FlatSamples::F32(samples) => gathered(&samples, plan, options),
        FlatSamples::U32(samples) => gathered(&samples, plan, options),
    }?;
    elevation.compression = Some(compression);
    elevation.metric = false;
    elevation.warnings.extend(warnings);
    Ok(elevation)
}

fn gathered<T: Sample>(samples: &[T], plan: Plan, options: &ImportOptions) -> Result<Elevation, Fault> {
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<T>::new(plan, order, &nodata_values(options, &[]));
    gatherer.push(samples);
    gatherer.finish(Format::OpenExr)
}

/// The channel asked for, else one with a name of heights, else red, else the first.
fn choose<'a>(names: &'a [String], asked: Option<&str>, warnings: &mut Vec<String>) -> Result<&'a str, Fault> {
    let find = |wanted: &str| names.iter().find(|name| name.as_str() == wanted);
    let all = || names.iter().take(20).map(|name| one_line(name)).collect::<Vec<_>>().join(", ");
    if let Some(asked) = asked {
        return find(asked).map(String::as_str).ok_or_else(|| {
            Fault::Unclear(format!("it has no channel \"{asked}\""), format!("choose --variable among {}", all()))
        });
    }
    let known = NAMES.iter().find_map(|name| find(name)).or_else(|| find("R")).or(names.first());
    let chosen = known.ok_or_else(|| Fault::Damaged("it has no channel".into()))?;
    if names.len() > 1 {
        warnings.push(format!("the channel {} is taken; choose with --variable among {}", one_line(chosen), all()));
    }
    Ok(chosen)
}
