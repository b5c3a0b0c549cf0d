//! Elevation files of every format, one file per format, decoded to one type: [`Elevation`].
//!
//! A format is told by its first bytes, and only then by the file's ending. Before samples are allocated, the sizes in a
//! header are compared with the file's length; what is wrong becomes a [`LoadError`](super::LoadError), never a panic.

mod ascii_grid;
mod elevation;
mod gather;
mod geo;
mod geokeys;
mod hgt;
pub mod imagery;
mod netcdf;
mod netcdf_header;
mod openexr;
mod options;
mod picture;
mod raster;
mod raw;
pub(super) mod source;
mod terragen;
mod tiff;
mod tiff_directory;
mod transverse_mercator;
mod usgs_dem;

use std::io::Read;
use std::path::Path;

use self::source::{Fault, Source};
pub use elevation::{Elevation, Samples, Taken, VerticalUnit};
pub(crate) use elevation::{Sample, number, with_samples};
pub use geo::{Georeference, GroundUnit, PixelIs};
pub(super) use geo::{UNIT_GUESSED, UnitText};
pub(crate) use geokeys::tags_of;
pub use options::{Encoding, Endian, ImportOptions, Listener, NoData, RawType, TooLarge};

/// The formats that open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names are the formats")]
pub enum Format {
    Png,
    Jpeg,
    WebP,
    Tiff,
    Hgt,
    AsciiGrid,
    Raster,
    Raw,
    Terragen,
    OpenExr,
    NetCdf,
    UsgsDem,
}

impl Format {
    /// What messages call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Tiff => "TIFF",
            Self::Hgt => "SRTM tile",
            Self::AsciiGrid => "ESRI ASCII grid",
            Self::Raster => "ESRI raster with a header file",
            Self::Raw => "raw file",
            Self::Terragen => "Terragen terrain",
            Self::OpenExr => "OpenEXR picture",
            Self::NetCdf => "netCDF file",
            Self::UsgsDem => "USGS ASCII DEM",
        }
    }

    /// The format of a file that begins with `head`. `Err`: what it looks like instead, and what to do about it.
    pub(super) fn of(head: &[u8], path: &Path, options: &ImportOptions) -> Result<Self, Stranger> {
        const MAGIC: [(&[u8], Format); 12] = [
            (b"\x89PNG\r\n\x1a\n", Format::Png),
            (b"\xff\xd8\xff", Format::Jpeg),
            (b"II*\0", Format::Tiff),
            (b"MM\0*", Format::Tiff),
            (b"II+\0", Format::Tiff),
            (b"MM\0+", Format::Tiff),
            (b"\x76\x2f\x31\x01", Format::OpenExr),
            (b"TERRAGENTERRAIN ", Format::Terragen),
            (b"CDF\x01", Format::NetCdf),
            (b"CDF\x02", Format::NetCdf),
            (b"CDF\x05", Format::NetCdf),
            (b"SIMPLE  = ", Format::Raw),
        ];
        if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WEBP") {
            return Ok(Self::WebP);
        }
        let begins = |magic: &[u8]| head.starts_with(magic) || (!head.is_empty() && magic.starts_with(head));
        match MAGIC.into_iter().find(|(magic, _)| begins(magic)) {
            Some((_, Self::Raw)) => return Err(Stranger("a FITS file", CONVERT)),
            Some((_, format)) => return Ok(format),
            None if ascii_grid::begins(head) => return Ok(Self::AsciiGrid),
            None => {}
        }
        if let Some(known) = looks_like(head) {
            return Err(known);
        }
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref().unwrap_or_default() {
            "hgt" => Ok(Self::Hgt),
            "asc" | "agr" => Ok(Self::AsciiGrid),
            "bil" | "bip" | "bsq" | "flt" => Ok(Self::Raster),
            "r8" | "r16" | "r32" | "raw" => Ok(Self::Raw),
            "ter" => Ok(Self::Terragen),
            "dem" if is_text(head) => Ok(Self::UsgsDem),
            "hdr" => Err(Stranger("the header of another file", "open the .bil or .flt beside it")),
            _ if options.raw_size.is_some() || options.raw_type.is_some() => Ok(Self::Raw),
            _ if is_text(head) => Err(Stranger("a text file", CONVERT)),
            _ => Err(Stranger("no format known here", CONVERT)),
        }
    }
}

fn is_text(head: &[u8]) -> bool {
    head.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
}

/// A file that does not open: what it looks like, and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stranger(pub(super) &'static str, pub(super) &'static str);

/// What to do about any file that does not open.
const CONVERT: &str =
    "convert it to GeoTIFF or a 16-bit PNG, or say --raw-size and --raw-type if it holds nothing but samples";

/// What to do about a packed file.
const UNPACK: &str = "unpack it first (gunzip, unzip, bunzip2, unxz, 7z x), and open what was in it";

/// What to do about netCDF-4.
const OLDER_NETCDF: &str =
    "write it in the classic form, with nccopy -k classic IN OUT.nc, or as GeoTIFF, with gdal_translate IN OUT.tif";

/// What a file that does not open looks like by its first bytes, where that can be told.
fn looks_like(head: &[u8]) -> Option<Stranger> {
    const KNOWN: [(&[u8], &str); 20] = [
        (b"GIF8", "a GIF"),
        (b"BM", "a BMP"),
        (b"\x89HDF", "a netCDF-4 or HDF5 file"),
        (b"\0\0\0\x0cjP", "a JPEG 2000"),
        (b"DDS ", "a DDS texture"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"BZh", "a bzip2 archive"),
        (b"\xfd7zXZ", "an xz archive"),
        (b"7z\xbc\xaf", "a 7-Zip archive"),
        (b"%PDF", "a PDF"),
        (b"P5", "a PGM"),
        (b"P2", "a PGM"),
        (b"DSAA", "a Surfer ASCII grid"),
        (b"DSBB", "a Surfer binary grid"),
        (b"DSRB", "a Surfer 7 grid"),
        (b"north:", "a GRASS ASCII grid"),
        (b"EHFA_HEADER_TAG", "an ERDAS Imagine file"),
        (b"GRIB", "a GRIB file"),
        (b"Lerc2 ", "a LERC file"),
    ];
    let (_, name) = KNOWN.iter().find(|(magic, _)| head.starts_with(magic))?;
    let advice = match *name {
        name if name.ends_with("archive") => UNPACK,
        "a netCDF-4 or HDF5 file" => OLDER_NETCDF,
        _ => "convert it to GeoTIFF, with gdal_translate IN OUT.tif for instance, or to a 16-bit PNG",
    };
    Some(Stranger(name, advice))
}

/// Decodes a file of this format. `said` is what the user said, and not the sidecar: what of it means nothing for the
/// format is told. A sidecar may say more than one file of its name needs.
pub(super) fn decode(
    format: Format,
    source: &mut Source,
    options: &ImportOptions,
    said: &ImportOptions,
) -> Result<Elevation, Fault> {
    let mut elevation = match format {
        Format::Png | Format::Jpeg | Format::WebP => picture::decode(format, source, options),
        Format::Tiff => tiff::decode(source, options),
        Format::Hgt => hgt::decode(source, options),
        Format::AsciiGrid => ascii_grid::decode(source, options),
        Format::Raster => raster::decode(source, options),
        Format::Raw => raw::decode(source, options),
        Format::Terragen => terragen::decode(source, options),
        Format::OpenExr => openexr::decode(source, options),
        Format::NetCdf => netcdf::decode(source, options),
        Format::UsgsDem => usgs_dem::decode(source, options),
    }?;
    let ignored = [
        ("--encoding", said.encoding.is_some(), matches!(format, Format::Png | Format::WebP | Format::Jpeg)),
        ("--band", said.band.is_some(), matches!(format, Format::Tiff | Format::Raster)),
        ("--variable", said.variable.is_some(), matches!(format, Format::NetCdf | Format::OpenExr)),
        ("--raw-size", said.raw_size.is_some(), format == Format::Raw),
        ("--raw-type", said.raw_type.is_some(), format == Format::Raw),
        ("--raw-endian", said.raw_endian.is_some(), format == Format::Raw),
    ];
    for (name, _, _) in ignored.into_iter().filter(|(_, given, used)| *given && !used) {
        elevation.warnings.push(format!("{name} means nothing for a {}, and was ignored", format.name()));
    }
    elevation.vertical_unit = options.vertical_unit.or(elevation.vertical_unit);
    if let Some(georeference) = elevation.georeference.take() {
        if georeference.is_rotated() {
            elevation.warnings.push("it is rotated against its coordinates: it is shown along its own rows".into());
        }
        let [x, y, _, _] = elevation.taken.window;
        let part = georeference.part([x, y], elevation.taken.factor);
        elevation.georeference = part.is_sound().then_some(part);
        if elevation.georeference.is_none() {
            elevation.warnings.push("the numbers of its place are none of a map, and were ignored".into());
        }
    }
    Ok(elevation)
}

/// Reads rows of plain samples, each `stride` bytes after the one before, and gathers them. `skip`: bytes before the
/// samples of a row.
struct Rows {
    width: usize,
    /// Bytes from sample to sample.
    step: usize,
    /// Bytes of a row, with what stands before and after its samples.
    stride: usize,
    /// Bytes before a row's first sample.
    skip: usize,
    big: bool,
}

impl Rows {
    /// Samples without anything between them.
    fn packed<T: Sample>(width: usize, big: bool) -> Self {
        Self { width, step: T::BYTES, stride: width * T::BYTES, skip: 0, big }
    }

    fn gather<T: Sample>(&self, source: &mut Source, gatherer: &mut gather::Gatherer<T>) -> Result<(), Fault> {
        let mut bytes = vec![0; self.stride];
        let mut row = Vec::with_capacity(self.width);
        while !gatherer.is_full() {
            // What follows the last sample of the last row may be missing.
            let mut filled = 0;
            while filled < bytes.len() {
                match source.reader.read(&mut bytes[filled..])? {
                    0 => break,
                    count => filled += count,
                }
            }
            if filled < self.skip + (self.width - 1) * self.step + T::BYTES {
                return Err(Fault::Truncated);
            }
            row.clear();
            let samples = bytes[self.skip..].chunks(self.step).take(self.width);
            row.extend(samples.map(|sample| T::from_bytes(sample, self.big)));
            gatherer.push(&row);
        }
        Ok(())
    }
}
