//! TIFF, GeoTIFF, BigTIFF and cloud-optimised GeoTIFF, through the `tiff` crate.

use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::{CompressionMethod, PlanarConfiguration, Tag};
use tiff::{TiffError, TiffFormatError};

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::geokeys::GeoTags;
use super::source::{Counting, Fault, Source, one_line};
use super::{Elevation, Format, ImportOptions, Sample, VerticalUnit};

/// GDAL's notes on scale, offset and unit, as XML.
const GDAL_METADATA: Tag = Tag::Unknown(42112);

/// The photometric interpretation of samples that are indices of colours.
const PALETTE: u16 = 3;

/// Most bytes of one strip or tile.
const MOST_CHUNK: u64 = 1 << 30;

/// Bytes of a map that one byte of a file can stand for, counting tiles that are left out.
const MOST_PER_BYTE: u64 = 1 << 16;

pub(super) type TiffReader<'r, 's> = Decoder<&'r mut std::io::BufReader<Counting<'s>>>;

fn fault(error: TiffError) -> Fault {
    match error {
        TiffError::IoError(error) => Fault::from(error),
        TiffError::UnsupportedError(error) => Fault::Unsupported(
            one_line(&error.to_string()),
            "write it again, with gdal_translate -co COMPRESS=DEFLATE for instance",
        ),
        TiffError::FormatError(TiffFormatError::CompressedDataCorrupt(message)) => Fault::damaged(message),
        error => Fault::damaged(error),
    }
}

/// What the tags say of the samples.
struct Layout {
    size: [u32; 2],
    chunk: [u32; 2],
    /// Chunks side by side.
    across: u32,
    /// Samples a pixel in one chunk.
    interleaved: usize,
    /// Which of them is taken.
    offset: usize,
    /// Index of the first chunk of the band.
    first_chunk: u32,
    /// Compressed length of every chunk.
    lengths: Vec<u64>,
    bits: u16,
    format: u16,
    compression: CompressionMethod,
}

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let world = ["tfw", "tifw", "wld"].into_iter().find_map(|ending| source.companion(ending));
    let prj = source.companion("prj");
    let bytes = source.bytes;
    super::tiff_directory::check(source)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_CHUNK as usize;
    limits.intermediate_buffer_size = MOST_CHUNK as usize;
    let mut decoder = Decoder::new(&mut source.reader).map_err(fault)?.with_limits(limits);
    let mut warnings = Vec::new();
    let layout = Layout::read(&mut decoder, options, &mut warnings)?;
    layout.check(bytes)?;
    let tags = geo_tags(&mut decoder);
    let place = tags.place(layout.size, &mut warnings).or_else(|| {
        let place = super::geo::from_world_file(&world?)?;
        Some(place.with_projection_file(prj.as_deref(), layout.size, &mut warnings))
    });
    let upright = place.as_ref().filter(|place| !place.is_rotated());
    let south_first = upright.is_some_and(|place| place.row[1] > 0.0);
    let east_first = upright.is_some_and(|place| place.column[0] < 0.0);
    if south_first {
        warnings.push(
            "its place says that its first row is the southernmost, and so it is shown; say --flip if that is wrong"
                .into(),
        );
    }
    let order = Order { south_first: south_first != (options.flip == Some(true)), east_first };
    let mut elevation = match (layout.format, layout.bits) {
        (1 | 4, 8) => read::<u8>(&mut decoder, &layout, options, order),
        (1 | 4, 16) => read::<u16>(&mut decoder, &layout, options, order),
        (1 | 4, 32) => read::<u32>(&mut decoder, &layout, options, order),
        (2, 8) => read::<i8>(&mut decoder, &layout, options, order),
        (2, 16) => read::<i16>(&mut decoder, &layout, options, order),
        (2, 32) => read::<i32>(&mut decoder, &layout, options, order),
        (3, 16 | 32) => read::<f32>(&mut decoder, &layout, options, order),
        (1..=3, 64) => read::<f64>(&mut decoder, &layout, options, order),
        (5 | 6, bits) => Err(unsupported(format!("complex numbers of {bits} bits"))),
        (_, bits) => Err(unsupported(format!("samples of {bits} bits"))),
    }?;
    elevation.sample_type = match (layout.format, layout.bits) {
        (3, 16) => "f16",
        (1, 64) => "u64",
        (2, 64) => "i64",
        _ => elevation.sample_type,
    };
    elevation.compression = Some(compression_name(layout.compression));
    elevation.warnings.append(&mut warnings);

    let metadata = decoder.find_tag(GDAL_METADATA).ok().flatten().and_then(|value| value.into_string().ok());
    let band = options.band.unwrap_or(1);
    let noted = |role: &str| metadata.as_deref().and_then(|text| gdal_item(text, role, band));
    let number = |role: &str| noted(role).and_then(|text| text.parse::<f64>().ok()).filter(|value| value.is_finite());
    elevation.scale = number("scale").filter(|&scale| scale != 0.0).unwrap_or(1.0);
    elevation.offset = number("offset").unwrap_or(0.0);
    elevation.vertical_unit = tags.vertical_unit().or_else(|| match noted("unittype")?.to_lowercase().as_str() {
        "ft" | "foot" | "feet" => Some(VerticalUnit::Foot),
        "us survey foot" | "us-ft" | "ftus" => Some(VerticalUnit::UsFoot),
        _ => None,
    });
    elevation.georeference = place.map(|place| place.turned(layout.size, south_first, east_first));
    elevation.metric = elevation.georeference.is_some() || layout.bits > 16 || layout.format != 1;
    if elevation.metric {
        elevation.vertical_unit = elevation.vertical_unit.or(Some(VerticalUnit::Metre));
    }
    Ok(elevation)
}

fn unsupported(what: String) -> Fault {
    Fault::Unsupported(what, "convert it to 32-bit floats, with gdal_translate -ot Float32 for instance")
}

impl Layout {
    fn read(decoder: &mut TiffReader, options: &ImportOptions, warnings: &mut Vec<String>) -> Result<Self, Fault> {
        let (width, height) = decoder.dimensions().map_err(fault)?;
        let first = |decoder: &mut TiffReader, tag: Tag, otherwise: u16| {
            let values = decoder.find_tag_unsigned_vec::<u16>(tag).map_err(fault)?;
            Ok::<_, Fault>(values.and_then(|values| values.first().copied()).unwrap_or(otherwise))
        };
        let bits = first(decoder, Tag::BitsPerSample, 1)?;
        let format = first(decoder, Tag::SampleFormat, 1)?;
        let bands = u32::from(first(decoder, Tag::SamplesPerPixel, 1)?);
        let compression = CompressionMethod::from_u16_exhaustive(first(decoder, Tag::Compression, 1)?);
        if first(decoder, Tag::PhotometricInterpretation, 1)? == PALETTE {
            return Err(Fault::Unsupported(
                "a palette: its samples are numbers of colours, not heights".into(),
                "open the file it was coloured from, or write shades with gdal_translate -expand gray",
            ));
        }
        if let Some(name) = unsupported_compression(compression) {
            return Err(Fault::Unsupported(
                format!("{name} compression"),
                "write it again with another, with gdal_translate -co COMPRESS=DEFLATE IN OUT.tif for instance",
            ));
        }
        let planar = first(decoder, Tag::PlanarConfiguration, 1)? == PlanarConfiguration::Planar.to_u16();
        let band = options.band.unwrap_or(1);
        if band == 0 || band > bands {
            return Err(Fault::Unclear(format!("it has no band {band}"), format!("choose --band 1 to {bands}")));
        }
        if bands > 1 && options.band.is_none() {
            warnings.push(format!("it has {bands} bands: the first is taken; choose another with --band"));
        }
        let (chunk_width, chunk_height) = decoder.chunk_dimensions();
        let tiled = decoder.get_chunk_type() == ChunkType::Tile;
        let tag = if tiled { Tag::TileByteCounts } else { Tag::StripByteCounts };
        let lengths = decoder.find_tag_unsigned_vec::<u64>(tag).map_err(fault)?.unwrap_or_default();
        let across = if tiled { width.div_ceil(chunk_width.max(1)) } else { 1 };
        let down = height.div_ceil(chunk_height.max(1));
        let (interleaved, offset, first_chunk) = if planar && bands > 1 {
            (1, 0, u64::from(band - 1) * u64::from(across) * u64::from(down))
        } else {
            (bands as usize, band as usize - 1, 0)
        };
        let first_chunk = u32::try_from(first_chunk).map_err(|_| Fault::Damaged("it has too many tiles".into()))?;
        let size = [width, height];
        let chunk = [chunk_width, chunk_height.min(height)];
        Ok(Self { size, chunk, across, interleaved, offset, first_chunk, lengths, bits, format, compression })
    }

    /// Compares what is promised with the file's length.
    fn check(&self, bytes: u64) -> Result<(), Fault> {
        let ratio: u64 = match self.compression {
            CompressionMethod::None => 1,
            CompressionMethod::PackBits => 64,
            CompressionMethod::LZW => 3072,
            CompressionMethod::Deflate | CompressionMethod::OldDeflate => 1032,
            CompressionMethod::ZSTD => 1 << 15,
            _ => 4096,
        };
        let pixel = u64::from(self.bits) * self.interleaved as u64;
        // The last strip may be shorter.
        let rows_of = |index: u64| {
            let first = index / u64::from(self.across) * u64::from(self.chunk[1]);
            u64::from(self.chunk[1]).min(u64::from(self.size[1]).saturating_sub(first).max(1))
        };
        let promises = Fault::Promises([self.size[0].into(), self.size[1].into()]);
        for (index, &length) in self.lengths.iter().enumerate().skip(self.first_chunk as usize) {
            let bits = u64::from(self.chunk[0]).saturating_mul(rows_of(index as u64)).saturating_mul(pixel);
            if length > bytes || (length > 0 && bits / 8 > length.saturating_mul(ratio)) {
                return Err(if length > bytes { Fault::Truncated } else { promises });
            }
            if bits / 8 > MOST_CHUNK {
                return Err(Fault::TooLarge([self.size[0].into(), self.size[1].into()]));
            }
        }
        if u64::from(self.size[0]) * u64::from(self.size[1]) > bytes.saturating_mul(MOST_PER_BYTE) {
            return Err(promises);
        }
        Ok(())
    }

    fn is_sparse(&self, chunk: u32) -> bool {
        self.lengths.get(chunk as usize).is_none_or(|&length| length == 0)
    }
}

/// The samples of one chunk as one type.
trait FromChunk: Sample {
    fn from_chunk(chunk: DecodingResult) -> Option<Vec<Self>>;
}

macro_rules! from_chunk {
    ($($type:ty: $pattern:pat => $samples:expr),* $(,)?) => {$(
        impl FromChunk for $type {
            fn from_chunk(chunk: DecodingResult) -> Option<Vec<Self>> {
                match chunk {
                    $pattern => Some($samples),
                    _ => None,
                }
            }
        }
    )*};
}

from_chunk! {
    u8: DecodingResult::U8(samples) => samples,
    i8: DecodingResult::I8(samples) => samples,
    u16: DecodingResult::U16(samples) => samples,
    i16: DecodingResult::I16(samples) => samples,
    u32: DecodingResult::U32(samples) => samples,
    i32: DecodingResult::I32(samples) => samples,
}

impl FromChunk for f32 {
    fn from_chunk(chunk: DecodingResult) -> Option<Vec<Self>> {
        match chunk {
            DecodingResult::F32(samples) => Some(samples),
            DecodingResult::F16(samples) => Some(samples.into_iter().map(exr::prelude::f16::to_f32).collect()),
            _ => None,
        }
    }
}

impl FromChunk for f64 {
    fn from_chunk(chunk: DecodingResult) -> Option<Vec<Self>> {
        match chunk {
            DecodingResult::F64(samples) => Some(samples),
            DecodingResult::U64(samples) => Some(samples.into_iter().map(|sample| sample as f64).collect()),
            DecodingResult::I64(samples) => Some(samples.into_iter().map(|sample| sample as f64).collect()),
            _ => None,
        }
    }
}

/// Reads the band, one row of tiles or one strip at a time. A chunk of length 0 holds nothing, and must not be decoded:
/// the decoder would read whatever stands at its offset.
fn read<T: FromChunk>(
    decoder: &mut TiffReader,
    layout: &Layout,
    options: &ImportOptions,
    order: Order,
) -> Result<Elevation, Fault> {
    let plan = Plan::new(layout.size[0].into(), layout.size[1].into(), options)?;
    let stated = decoder.find_tag(Tag::GdalNodata).ok().flatten().and_then(|value| value.into_string().ok());
    let stated = stated.and_then(|text| text.trim_matches([' ', '\0']).parse::<f64>().ok());
    // Without a word on holes, these are what programs have always put there.
    let usual: &[f64] = match T::NAME {
        "i16" => &[-32768.0],
        "f32" => &[f32::MIN as f64],
        _ => &[],
    };
    let of_file = stated.map_or_else(|| usual.to_vec(), |value| vec![value]);
    let mut gatherer = Gatherer::<T>::new(plan, order, &nodata_values(options, &of_file));
    let [width, chunk_height] = [layout.size[0] as usize, layout.chunk[1] as usize];
    let mut band = vec![T::ZERO; width * chunk_height];
    let mut gaps: Vec<bool> = Vec::new();
    for strip in 0..layout.size[1].div_ceil(layout.chunk[1]) {
        let first_row = strip * layout.chunk[1];
        let rows = layout.chunk[1].min(layout.size[1] - first_row);
        // A row of tiles outside the window need not be read, unless the whole range is wanted.
        if !gatherer.wants(rows) && !options.needs_full_range {
            gatherer.skip(rows);
            continue;
        }
        gaps.clear();
        for tile in 0..layout.across {
            let chunk = layout.first_chunk + strip * layout.across + tile;
            let left = (tile * layout.chunk[0]) as usize;
            let columns = (layout.chunk[0] as usize).min(width - left);
            if layout.is_sparse(chunk) {
                gaps.resize(width * chunk_height, false);
                (0..rows as usize).for_each(|row| gaps[row * width + left..][..columns].fill(true));
                continue;
            }
            // Rows as long as those in the file: what hangs over the edge is not skipped, because LZW's decoder loses
            // the end of a tile that is not read in one go.
            let stride = layout.chunk[0] as usize * layout.interleaved;
            let mut samples = DecodingResult::U8(Vec::new());
            let bytes = stride * usize::from(layout.bits / 8);
            decoder.read_chunk_to_buffer(&mut samples, chunk, bytes).map_err(fault)?;
            let samples =
                T::from_chunk(samples).ok_or_else(|| Fault::Damaged("a tile has another type than the rest".into()))?;
            for (row, samples) in samples.chunks_exact(stride.max(1)).take(rows as usize).enumerate() {
                let picked = samples.iter().skip(layout.offset).step_by(layout.interleaved);
                band[row * width + left..][..columns]
                    .iter_mut()
                    .zip(picked)
                    .for_each(|(place, sample)| *place = *sample);
            }
        }
        for row in 0..rows as usize {
            let gaps = gaps.get(row * width..(row + 1) * width).unwrap_or_default();
            gatherer.push_with_gaps(&band[row * width..][..width], gaps);
        }
    }
    let mut elevation = gatherer.finish(Format::Tiff)?;
    if stated.is_none() && options.nodata.is_none() && elevation.holes.is_some() && !usual.is_empty() {
        elevation.warnings.push(format!(
            "samples of {} are taken as holes, although the file does not say so; say nodata = \"none\" to keep them",
            usual[0]
        ));
    }
    Ok(elevation)
}

/// The tags of the place; one that cannot be read is as good as none.
pub(super) fn geo_tags(decoder: &mut TiffReader) -> GeoTags {
    let doubles = |decoder: &mut TiffReader, tag: Tag| {
        decoder.find_tag(tag).ok().flatten().and_then(|value| value.into_f64_vec().ok()).unwrap_or_default()
    };
    GeoTags {
        scale: doubles(decoder, Tag::ModelPixelScaleTag),
        tie_points: doubles(decoder, Tag::ModelTiepointTag),
        transformation: doubles(decoder, Tag::ModelTransformationTag),
        doubles: doubles(decoder, Tag::GeoDoubleParamsTag),
        keys: decoder.find_tag_unsigned_vec(Tag::GeoKeyDirectoryTag).ok().flatten().unwrap_or_default(),
        texts: decoder
            .find_tag(Tag::GeoAsciiParamsTag)
            .ok()
            .flatten()
            .and_then(|value| value.into_string().ok())
            .unwrap_or_default(),
    }
}

/// The name of a way to pack samples that does not open here.
fn unsupported_compression(method: CompressionMethod) -> Option<&'static str> {
    match method.to_u16() {
        2..=4 => Some("fax (CCITT)"),
        34661 => Some("JBIG"),
        33003..=33005 | 34712 => Some("JPEG 2000"),
        34887 => Some("LERC"),
        34925 => Some("LZMA"),
        50001 => Some("WebP"),
        50002 | 52546 => Some("JPEG XL"),
        _ => None,
    }
}

fn compression_name(method: CompressionMethod) -> String {
    match method {
        CompressionMethod::None => "none".into(),
        CompressionMethod::LZW => "LZW".into(),
        CompressionMethod::Deflate | CompressionMethod::OldDeflate => "Deflate".into(),
        CompressionMethod::PackBits => "PackBits".into(),
        CompressionMethod::ZSTD => "ZSTD".into(),
        CompressionMethod::ModernJPEG | CompressionMethod::JPEG => "JPEG".into(),
        other => format!("{other:?}"),
    }
}

/// The text of GDAL's note on a band with this role: `<Item name="SCALE" sample="0" role="scale">0.1</Item>`.
fn gdal_item(xml: &str, role: &str, band: u32) -> Option<String> {
    let (role, sample) = (format!("role=\"{role}\""), format!("sample=\"{}\"", band.checked_sub(1)?));
    let item = xml.split("<Item").find(|item| {
        let head = item.split('>').next().unwrap_or_default();
        head.contains(&role) && head.contains(&sample)
    })?;
    let text = item.split_once('>')?.1.split("</Item").next()?;
    Some(text.trim().chars().take(64).collect())
}
