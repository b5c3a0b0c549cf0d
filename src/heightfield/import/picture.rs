//! Pictures: PNG with 8 or 16 bits, JPEG and WebP; shades as heights, or heights packed into colours.

use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, Limits};

use std::io::{self, SeekFrom};
use std::io::{Read, Seek};
use std::path::Path;

use super::super::load::MAX_SIDE;
use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source};
use super::{Elevation, Encoding, Format, Georeference, ImportOptions, Sample, VerticalUnit};

/// Most bytes that decoding may take: an 8-bit RGBA picture of the largest size.
pub(super) const MAX_DECODED_BYTES: u64 = 4 * (MAX_SIDE as u64) * (MAX_SIDE as u64);

/// Deflate's best compression; a file that promises more than this times its length cannot keep it.
pub(super) const MAX_DEFLATE_RATIO: u64 = 1032;

/// Pixels that a byte of a lossy picture can stand for, and of a lossless WebP: a block of one colour each.
const MAX_PIXELS_PER_BYTE: u64 = 4096;

/// Most bytes of what a picture's file holds beside it: colour profiles and texts.
const BESIDE_THE_PICTURE: u64 = 4 << 20;

pub(super) fn decode(format: Format, source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    if format == Format::Png {
        check_png_head(source)?;
    }
    if format == Format::Jpeg && options.encoding.is_some() {
        return Err(Fault::Unsupported(
            "heights packed into colours: its losses would tear them".into(),
            "use the PNG or WebP tiles, or leave --encoding out",
        ));
    }
    let complete = has_its_end(format, source)?;
    if format == Format::Jpeg && !complete {
        return Err(Fault::Truncated);
    }
    let (picture, plan) = decode_picture(format, source, options).map_err(|fault| match fault {
        Fault::Damaged(_) | Fault::Io(_) if !complete => Fault::Truncated,
        fault => fault,
    })?;
    let mut elevation = match options.encoding {
        Some(encoding) => unpack(&picture, encoding, plan, options, format)?,
        None => shades(picture, plan, options, format)?,
    };
    let size = elevation.taken.full;
    let world = ["pgw", "jgw", "wld"].into_iter().find_map(|ending| source.companion(ending));
    elevation.georeference = match world.as_deref().and_then(super::geo::from_world_file) {
        Some(place) => {
            let prj = source.companion("prj");
            Some(place.with_projection_file(prj.as_deref(), size, &mut elevation.warnings))
        }
        None if options.encoding.is_some() => tile_place(source.path, size),
        None => None,
    };
    let lossy = format != Format::Png && options.encoding.is_none();
    if lossy {
        elevation.warnings.push(format!(
            "a {} has only 256 heights, and losses: the ground has steps and noise; use a 16-bit PNG or a GeoTIFF",
            format.name()
        ));
    }
    Ok(elevation)
}

/// The picture and what is wanted of it. Its size is compared with the file's before anything is allocated.
fn decode_picture(format: Format, source: &mut Source, options: &ImportOptions) -> Result<(DynamicImage, Plan), Fault> {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(BESIDE_THE_PICTURE);
    let bytes = source.bytes;
    let reader = &mut source.reader;
    let fault = |error: ImageError| match error {
        ImageError::IoError(error) => Fault::from(error),
        ImageError::Limits(error) => Fault::Damaged(super::source::one_line(&error.to_string())),
        error => Fault::damaged(error),
    };
    match format {
        Format::Jpeg => check_and_decode(JpegDecoder::new(reader).map_err(fault)?, bytes, format, options),
        Format::WebP => check_and_decode(WebPDecoder::new(reader).map_err(fault)?, bytes, format, options),
        _ => {
            let mut decoder = PngDecoder::with_limits(reader, limits.clone()).map_err(fault)?;
            limits.max_alloc = Some(decoder.total_bytes().saturating_add(BESIDE_THE_PICTURE));
            decoder.set_limits(limits).map_err(fault)?;
            check_and_decode(decoder, bytes, format, options)
        }
    }
}

fn check_and_decode(
    decoder: impl ImageDecoder,
    bytes: u64,
    format: Format,
    options: &ImportOptions,
) -> Result<(DynamicImage, Plan), Fault> {
    let (width, height) = decoder.dimensions();
    let size = [width.into(), height.into()];
    if width > MAX_SIDE || height > MAX_SIDE || decoder.total_bytes() > MAX_DECODED_BYTES {
        return Err(Fault::TooLarge(size));
    }
    if format != Format::Png && size[0] * size[1] > bytes.saturating_mul(MAX_PIXELS_PER_BYTE) {
        return Err(Fault::Promises(size));
    }
    let plan = Plan::new(size[0], size[1], options)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| match error {
        ImageError::IoError(error) => Fault::from(error),
        error => Fault::damaged(error),
    })?;
    Ok((picture, plan))
}

/// The luminance as height.
fn shades(picture: DynamicImage, plan: Plan, options: &ImportOptions, format: Format) -> Result<Elevation, Fault> {
    let colour = picture.color();
    let packed = looks_packed(&picture);
    let mut elevation = match colour {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            gathered::<u16>(picture.into_luma16().as_raw(), plan, options, format)
        }
        _ => gathered::<u8>(picture.into_luma8().as_raw(), plan, options, format),
    }?;
    elevation.metric = false;
    if colour.has_color() || colour.has_alpha() {
        let what = match (colour.has_color(), colour.has_alpha()) {
            (true, true) => "is coloured and has an alpha channel",
            (true, false) => "is coloured",
            _ => "has an alpha channel",
        };
        if let Some(encoding) = packed {
            elevation.warnings.push(format!(
                "it looks like a terrain-RGB tile, heights packed into colours, but is shown as a picture; say --encoding \
                 {encoding} if it is one"
            ));
            return Ok(elevation);
        }
        elevation.warnings.push(format!(
            "it {what}: its luminance is taken as the height; save it as greyscale to be sure of the heights, or say \
             --encoding where its colours are heights"
        ));
    }
    Ok(elevation)
}

/// The encoding of what may be heights in colours: a red that hardly changes, and is that of heights on Earth, below a
/// green that does. Only for a hint: a picture may look like this, too.
fn looks_packed(picture: &DynamicImage) -> Option<&'static str> {
    /// So many pixels tell enough.
    const LOOKED_AT: usize = 1 << 14;
    if !matches!(picture.color(), ColorType::Rgb8 | ColorType::Rgba8) {
        return None;
    }
    let channels = usize::from(picture.color().channel_count());
    let pixels = picture.as_bytes().chunks_exact(channels);
    let step = (pixels.len() / LOOKED_AT).max(1);
    let (mut red, mut green) = ([u8::MAX, 0], [u8::MAX, 0]);
    for pixel in pixels.step_by(step) {
        red = [red[0].min(pixel[0]), red[1].max(pixel[0])];
        green = [green[0].min(pixel[1]), green[1].max(pixel[1])];
    }
    let varied = green[1].saturating_sub(green[0]) >= 2 && green[1] > red[1].saturating_sub(red[0]);
    match red {
        [1..=2, 1..=2] if varied => Some("mapbox"),
        [85..=163, 125..=163] if varied && red[1] - red[0] <= 39 => Some("terrarium"),
        _ => None,
    }
}

fn gathered<T: Sample>(samples: &[T], plan: Plan, options: &ImportOptions, format: Format) -> Result<Elevation, Fault> {
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<T>::new(plan, order, &nodata_values(options, &[]));
    gatherer.push(samples);
    gatherer.finish(format)
}

/// Heights that colours stand for; transparent pixels hold none.
fn unpack(
    picture: &DynamicImage,
    encoding: Encoding,
    plan: Plan,
    options: &ImportOptions,
    format: Format,
) -> Result<Elevation, Fault> {
    if !picture.color().has_color() {
        return Err(Fault::Unclear(
            "it has no colours that could be heights".into(),
            "leave --encoding out: its shades are the heights".into(),
        ));
    }
    /// No colour has so large a number.
    const TRANSPARENT: u32 = u32::MAX;
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<u32>::new(plan, order, &[f64::from(TRANSPARENT)]);
    let picture = picture.to_rgba8();
    let mut row = Vec::with_capacity(picture.width() as usize);
    for pixels in picture.rows() {
        row.clear();
        row.extend(pixels.map(|pixel| match pixel.0 {
            [_, _, _, 0] => TRANSPARENT,
            [red, green, blue, _] => u32::from_be_bytes([0, red, green, blue]),
        }));
        gatherer.push(&row);
    }
    let mut elevation = gatherer.finish(format)?;
    (elevation.scale, elevation.offset) = match encoding {
        Encoding::Terrarium => (1.0 / 256.0, -32768.0),
        Encoding::Mapbox => (0.1, -10000.0),
    };
    elevation.vertical_unit = Some(VerticalUnit::Metre);
    Ok(elevation)
}

/// The place of a tile of a map of the world, from a path that ends in ZOOM/COLUMN/ROW.
fn tile_place(path: &Path, [width, height]: [u32; 2]) -> Option<Georeference> {
    let number = |part: Option<&std::ffi::OsStr>| part?.to_str()?.parse::<u32>().ok();
    let row = number(path.file_stem())?;
    let column = number(path.parent()?.file_name())?;
    let zoom = number(path.parent()?.parent()?.file_name())?;
    let tiles = 1u32.checked_shl(zoom).filter(|&tiles| zoom <= 24 && column < tiles && row < tiles)?;
    let world = 2.0 * std::f64::consts::PI * 6_378_137.0;
    let side = world / f64::from(tiles);
    let step = [side / f64::from(width), side / f64::from(height)];
    let west = f64::from(column) * side - world * 0.5 + step[0] * 0.5;
    let north = world * 0.5 - f64::from(row) * side - step[1] * 0.5;
    Some(Georeference::new([west, north], [step[0], -step[1]]).with_epsg(3857))
}

/// The signature, and the first chunk with the picture's size, depth and colour.
const PNG_HEAD_BYTES: usize = 33;

/// Refuses what a PNG's first bytes already show to be no height map.
fn check_png_head(source: &Source) -> Result<(), Fault> {
    let Some(head) = source.head.get(..PNG_HEAD_BYTES) else { return Err(Fault::Truncated) };
    if head[12..16] != *b"IHDR" {
        return Err(Fault::Damaged("its first chunk is not IHDR".into()));
    }
    let number = |at: usize| u64::from(u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
    let (width, height) = (number(16), number(20));
    if width.max(height) > u64::from(MAX_SIDE) {
        return Err(Fault::TooLarge([width, height]));
    }
    if width < 2 || height < 2 {
        return Err(Fault::TooSmall([width, height]));
    }
    let channels = match head[25] {
        2 => 3,
        4 => 2,
        6 => 4,
        _ => 1,
    };
    let row_bytes = (width * channels * u64::from(head[24])).div_ceil(8) + 1;
    if row_bytes * height > source.bytes.saturating_mul(MAX_DEFLATE_RATIO) {
        return Err(Fault::Truncated);
    }
    Ok(())
}

/// Whether the mark of the end is where it belongs, which tells a truncated file from a damaged one. A JPEG's decoder
/// would make up the rest.
fn has_its_end(format: Format, source: &mut Source) -> io::Result<bool> {
    let tail_bytes = match format {
        Format::Png => 12,
        // Programs add notes of their own after it.
        Format::Jpeg => 1 << 16,
        _ => return Ok(true),
    };
    let mut tail = Vec::new();
    source.reader.seek(SeekFrom::Start(source.bytes.saturating_sub(tail_bytes)))?;
    source.reader.by_ref().take(tail_bytes).read_to_end(&mut tail)?;
    source.reader.rewind()?;
    Ok(match format {
        Format::Png => tail.get(4..8) == Some(b"IEND"),
        _ => tail.windows(2).any(|mark| mark == [0xff, 0xd9]),
    })
}
