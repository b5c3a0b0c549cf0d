//! Pictures of the ground that say where they lie: GeoTIFF, or any picture with a world file (`.tfw`, `.pgw`, `.jgw`,
//! `.wld`) and a `.prj` beside it.

use std::path::Path;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{PlanarConfiguration, Tag};

use super::source::{Fault, ReadSeek, Source, one_line};
use super::tiff::geo_tags;
use super::{Georeference, Listener, geo, tiff_directory};

/// Most bytes of a decoded picture, as for every other image.
const MOST_BYTES: u64 = 512 << 20;

/// An 8-bit sRGB picture of a TIFF.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and opacity, row by row.
    pub rgba: Vec<u8>,
}

/// Whether a file begins as a TIFF does. A file that cannot be read is none.
pub fn is_tiff(path: &Path) -> bool {
    with_source(path, |source| Ok(begins_as_tiff(source))).unwrap_or(false)
}

fn begins_as_tiff(source: &Source<'_>) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| source.head.starts_with(*magic))
}

/// Where a picture of `size` pixels lies, by its own tags or by the files beside it. What is doubtful about it is told.
///
/// # Errors
/// What is missing, for people.
pub fn place(path: &Path, size: [u32; 2], doubts: &mut Vec<String>) -> Result<Georeference, String> {
    with_source(path, |source| {
        if begins_as_tiff(source) {
            tiff_directory::check(source)?;
            let mut decoder = Decoder::new(&mut source.reader).map_err(Fault::damaged)?;
            if let Some(place) = geo_tags(&mut decoder).place(size, doubts) {
                return Ok(Ok(place));
            }
        }
        let endings = ["tfw", "tifw", "pgw", "pngw", "jgw", "jpgw", "wpw", "wld"];
        let Some(text) = endings.into_iter().find_map(|ending| source.companion(ending)) else {
            return Ok(Err(
                "it does not say where it lies: it has no GeoTIFF tags, and there is no world file (.tfw, .pgw, \
                           .jgw, .wld) beside it; drape it as the diffuse texture, which covers the whole map"
                    .to_owned(),
            ));
        };
        let Some(place) = geo::from_world_file(&text) else {
            return Ok(Err("the world file beside it is no six numbers that place a picture".to_owned()));
        };
        // Without a .prj nothing is known but the numbers: they are taken for those of the map.
        let system = source.companion("prj").and_then(|text| geo::from_wkt(&text));
        Ok(Ok(match system {
            Some((crs, epsg, unit)) => Georeference { crs: Some(crs), epsg, unit: Some(unit), ..place },
            None => place,
        }))
    })?
}

/// Reads a TIFF of at most `largest` pixels a side.
///
/// # Errors
/// What is wrong with it, for people.
pub fn read_tiff(path: &Path, largest: u32) -> Result<Picture, String> {
    with_source(path, |source| {
        tiff_directory::check(source)?;
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MOST_BYTES as usize;
        limits.intermediate_buffer_size = MOST_BYTES as usize;
        let mut decoder = Decoder::new(&mut source.reader).map_err(Fault::damaged)?.with_limits(limits);
        let (width, height) = decoder.dimensions().map_err(Fault::damaged)?;
        if width > largest || height > largest || u64::from(width) * u64::from(height) * 4 > MOST_BYTES {
            return Ok(Err(format!(
                "it has {width}×{height} pixels, but at most {largest} a side and {} MiB are read; make it smaller, with \
                 gdal_translate -outsize for instance",
                MOST_BYTES >> 20
            )));
        }
        let planar = decoder.find_tag_unsigned_vec::<u16>(Tag::PlanarConfiguration).map_err(Fault::damaged)?;
        let planar = planar.is_some_and(|values| values.first() == Some(&PlanarConfiguration::Planar.to_u16()));
        let colours = decoder.colortype().map_err(Fault::damaged)?;
        let Some(channels) = channels(colours).filter(|_| !planar) else {
            return Ok(Err(format!(
                "its colours ({colours:?}{}) are not read; write it again, with gdal_translate -of PNG -co WORLDFILE=YES for \
                 instance",
                if planar { ", plane by plane" } else { "" }
            )));
        };
        let bytes = match decoder.read_image().map_err(Fault::damaged)? {
            DecodingResult::U8(bytes) => bytes,
            DecodingResult::U16(values) => values.into_iter().map(|value| (value >> 8) as u8).collect(),
            _ => return Ok(Err("its samples are no colours of 8 or 16 bits".to_owned())),
        };
        let rgba: Vec<u8> = bytes.chunks_exact(channels).flat_map(|pixel| colour(colours, pixel)).collect();
        if rgba.len() as u64 != u64::from(width) * u64::from(height) * 4 {
            return Err(Fault::Truncated);
        }
        Ok(Ok(Picture { width, height, rgba }))
    })?
}

/// Samples of a pixel, for the colours that are read.
fn channels(colours: ColorType) -> Option<usize> {
    match colours {
        ColorType::Gray(8 | 16) => Some(1),
        ColorType::GrayA(8 | 16) => Some(2),
        ColorType::RGB(8 | 16) => Some(3),
        ColorType::RGBA(8 | 16) => Some(4),
        ColorType::Multiband { bit_depth: 8 | 16, num_samples: samples @ 3.. } => Some(samples.into()),
        _ => None,
    }
}

fn colour(colours: ColorType, pixel: &[u8]) -> [u8; 4] {
    match (colours, pixel) {
        (ColorType::GrayA(_), [grey, opacity, ..]) => [*grey, *grey, *grey, *opacity],
        (ColorType::RGBA(_), [red, green, blue, opacity, ..]) => [*red, *green, *blue, *opacity],
        (_, [red, green, blue, ..]) => [*red, *green, *blue, 255],
        (_, [grey, ..]) => [*grey, *grey, *grey, 255],
        (_, []) => [0; 4],
    }
}

/// Opens `path` and asks `ask` about it; what goes wrong is told in words.
fn with_source<T>(path: &Path, ask: impl FnOnce(&mut Source<'_>) -> Result<T, Fault>) -> Result<T, String> {
    let in_words = |fault: Fault| match fault {
        Fault::Io(error) => error.to_string(),
        Fault::Truncated => "it ends before its pixels do; save or download it again".to_owned(),
        Fault::Damaged(reason) => format!("it is damaged ({reason}); save or download it again"),
        fault => one_line(&format!("{fault:?}")),
    };
    // Before opening, because opening a pipe waits for its writer.
    let found = std::fs::metadata(path).map_err(|error| error.to_string())?;
    if !found.is_file() {
        return Err("it is not a file".to_owned());
    }
    let file = std::fs::File::open(path).map_err(|error| error.to_string())?;
    let reader: Box<dyn ReadSeek + Send> = Box::new(file);
    let source = Source::new(reader, found.len(), path, true, Listener::none());
    let mut source = source.map_err(|error| error.to_string())?;
    ask(&mut source).map_err(in_words)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_world_file_places_a_picture_and_a_projection_names_its_system() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("photo.jpg");
        fs::write(&path, b"\xff\xd8\xff").unwrap();
        let mut doubts = Vec::new();
        let error = place(&path, [4, 4], &mut doubts).unwrap_err();
        assert!(error.contains(".jgw"), "{error}");
        fs::write(path.with_extension("jgw"), "10\n0\n0\n-10\n500005\n3999995\n").unwrap();
        let placed = place(&path, [4, 4], &mut doubts).unwrap();
        assert_eq!((placed.at(1.0, 1.0), placed.epsg), ([500_015.0, 3_999_985.0], None));
        fs::write(path.with_extension("prj"), r#"PROJCS["x",UNIT["metre",1],AUTHORITY["EPSG","32611"]]"#).unwrap();
        assert_eq!(place(&path, [4, 4], &mut doubts).unwrap().epsg, Some(32611));
        fs::write(path.with_extension("jgw"), "not numbers").unwrap();
        assert!(place(&path, [4, 4], &mut doubts).unwrap_err().contains("six numbers"));
        assert!(place(&folder.path().join("none.png"), [1, 1], &mut doubts).is_err());
    }

    #[test]
    fn a_geotiff_says_itself_where_it_lies() {
        use tiff::encoder::{TiffEncoder, colortype};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("placed.tif");
        let mut encoder = TiffEncoder::new(fs::File::create(&path).unwrap()).unwrap();
        let mut image = encoder.new_image::<colortype::RGB8>(2, 2).unwrap();
        let tags = image.encoder();
        tags.write_tag(Tag::ModelPixelScaleTag, &[10.0, 10.0, 0.0][..]).unwrap();
        tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 500_000.0, 4_000_000.0, 0.0][..]).unwrap();
        let keys: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32611];
        tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
        image.write_data(&[9; 12]).unwrap();
        // A world file beside it says something else, and is not asked.
        fs::write(path.with_extension("tfw"), "1\n0\n0\n-1\n0\n0\n").unwrap();
        let placed = place(&path, [2, 2], &mut Vec::new()).unwrap();
        assert_eq!((placed.epsg, placed.at(0.0, 0.0)), (Some(32611), [500_005.0, 3_999_995.0]), "the pixel's middle");
        assert_eq!(read_tiff(&path, 64).unwrap().rgba, [9, 9, 9, 255].repeat(4));
    }

    #[test]
    fn a_tiff_is_read_with_its_opacity_and_a_broken_one_refused() {
        use tiff::encoder::{TiffEncoder, colortype};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("photo.tif");
        let pixels = [10u8, 20, 30, 255, 40, 50, 60, 0];
        let file = fs::File::create(&path).unwrap();
        TiffEncoder::new(file).unwrap().write_image::<colortype::RGBA8>(2, 1, &pixels).unwrap();
        assert!(is_tiff(&path));
        assert_eq!(read_tiff(&path, 64).unwrap(), Picture { width: 2, height: 1, rgba: pixels.to_vec() });
        assert!(read_tiff(&path, 1).unwrap_err().contains("2×1"), "larger than the adapter's textures");
        let bytes = fs::read(&path).unwrap();
        for end in [3, 8, 12, bytes.len() / 2] {
            fs::write(&path, &bytes[..end]).unwrap();
            assert!(read_tiff(&path, 64).is_err(), "cut at {end}");
        }
        let grey = folder.path().join("grey.tif");
        let file = fs::File::create(&grey).unwrap();
        TiffEncoder::new(file).unwrap().write_image::<colortype::Gray16>(1, 1, &[0x8000]).unwrap();
        assert_eq!(read_tiff(&grey, 64).unwrap().rgba, [128, 128, 128, 255]);
    }
}
