//! Opening a height map's file: an 8- or 16-bit greyscale PNG and the sidecar beside it.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use image::codecs::png::PngDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, Limits};

use super::{HeightField, HeightFieldError, Sidecar};

/// Most samples on a side; textures end far below it.
pub const MAX_SIDE: u32 = 32768;

/// Most bytes that decoding may take: an 8-bit RGBA picture of the largest size.
const MAX_DECODED_BYTES: u64 = 4 * (MAX_SIDE as u64) * (MAX_SIDE as u64);

/// Deflate's best compression; a file that promises more than this times its length cannot keep it.
const MAX_DEFLATE_RATIO: u64 = 1032;

const PNG_MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Why a height map did not open: what, why and what to do, a line each.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Nothing there.
    #[error("cannot open {path}\n  there is no such file\n  check the path")]
    NotFound {
        /// What was to be opened.
        path: PathBuf,
    },
    /// A folder.
    #[error("cannot open {path}\n  it is a directory\n  name the height map's file in it")]
    Directory {
        /// What was to be opened.
        path: PathBuf,
    },
    /// The system refuses.
    #[error("cannot read {path}\n  permission denied\n  make the file readable for this user (chmod u+r)")]
    PermissionDenied {
        /// What was to be opened.
        path: PathBuf,
    },
    /// Any other failure to read.
    #[error("cannot read {path}\n  {source}\n  check the disk or copy the file elsewhere")]
    Io {
        /// What was to be opened.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Zero bytes.
    #[error("cannot open {path}\n  the file is empty\n  save or download it again")]
    Empty {
        /// What was to be opened.
        path: PathBuf,
    },
    /// Some other format.
    #[error(
        "cannot open {path}\n  it is not a PNG but looks like {looks_like}\n  convert it to an 8- or 16-bit greyscale PNG"
    )]
    NotPng {
        /// What was to be opened.
        path: PathBuf,
        /// What its first bytes say it is.
        looks_like: &'static str,
    },
    /// The file ends before its picture does.
    #[error("cannot open {path}\n  the PNG is truncated, it ends before its picture does\n  save or download it again")]
    Truncated {
        /// What was to be opened.
        path: PathBuf,
    },
    /// Broken inside.
    #[error("cannot open {path}\n  the PNG is damaged ({reason})\n  save or download it again")]
    Damaged {
        /// What was to be opened.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// More samples than anything can hold.
    #[error(
        "cannot open {path}\n  it says it has {width}×{height} samples, but at most {MAX_SIDE} on a side and \
         {} GiB of picture are read\n  scale it down or cut it into parts",
        MAX_DECODED_BYTES >> 30
    )]
    TooLarge {
        /// What was to be opened.
        path: PathBuf,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Decoded, but no height map.
    #[error("cannot open {path}\n  {source}")]
    NoSurface {
        /// What was to be opened.
        path: PathBuf,
        /// What is wrong with it.
        source: HeightFieldError,
    },
}

/// An opened height map.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The map.
    pub field: HeightField,
    /// What was not as expected but did not stop the map from opening; each a whole sentence that names its file.
    pub warnings: Vec<String>,
    /// Type of the file's samples: "u8" or "u16".
    pub sample_type: &'static str,
    /// The sidecar's title.
    pub title: Option<String>,
    /// The sidecar, if there is one that can be used.
    pub sidecar: Option<Sidecar>,
}

/// Opens the height map `path` and its sidecar.
pub fn load(path: &Path) -> Result<Loaded, LoadError> {
    load_with_progress(path, &|_| {})
}

/// Like [`load`]; `progress` hears the share of the file that has been read, 0..1, from this thread.
pub fn load_with_progress(path: &Path, progress: &dyn Fn(f32)) -> Result<Loaded, LoadError> {
    let mut warnings = Vec::new();
    let picture = decode(path, progress)?;
    let sidecar = Sidecar::read_for(path, &mut warnings);
    let loaded = interpret(picture, sidecar, path, warnings)?;
    progress(1.0);
    Ok(loaded)
}

/// Opens a PNG that is already in memory, with the text of its sidecar; `name` stands for its path in messages.
///
/// # Errors
/// As [`load`], as far as bytes can be wrong.
pub fn load_bytes(name: &Path, png: &[u8], sidecar: Option<&str>) -> Result<Loaded, LoadError> {
    let mut warnings = Vec::new();
    let bytes = png.len() as u64;
    check_head(&png[..png.len().min(HEAD_BYTES)], bytes, name)?;
    let picture = decode_png(io::Cursor::new(png)).map_err(|(error, [width, height])| match error {
        ImageError::Limits(_) if is_too_large(width, height) => {
            LoadError::TooLarge { path: name.into(), width, height }
        }
        error => LoadError::Damaged { path: name.into(), reason: one_line(&error) },
    })?;
    let sidecar = sidecar.and_then(|text| Sidecar::parse(text, &Sidecar::path_of(name), &mut warnings));
    interpret(picture, sidecar, name, warnings)
}

/// Heights from a decoded picture, at the place that the sidecar gives them.
fn interpret(
    picture: DynamicImage,
    mut sidecar: Option<Sidecar>,
    path: &Path,
    mut warnings: Vec<String>,
) -> Result<Loaded, LoadError> {
    let (width, height) = (picture.width(), picture.height());
    let colour = picture.color();
    if colour.has_color() || colour.has_alpha() {
        let what = match (colour.has_color(), colour.has_alpha()) {
            (true, true) => "is coloured and has an alpha channel",
            (true, false) => "is coloured",
            _ => "has an alpha channel",
        };
        warnings.push(format!(
            "{} {what}: its luminance is taken as the height; save it as greyscale to be sure of the heights",
            path.display()
        ));
    }
    let (field, sample_type) = match colour {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            (HeightField::from_raw(width, height, picture.into_luma16().as_raw()), "u16")
        }
        _ => (HeightField::from_raw(width, height, picture.into_luma8().as_raw()), "u8"),
    };
    let field = field.map_err(|source| LoadError::NoSurface { path: path.into(), source })?;
    let field = match &mut sidecar {
        Some(sidecar) => place(field, sidecar, path, &mut warnings),
        None => field,
    };
    let title = sidecar.as_ref().and_then(|sidecar| sidecar.title.clone());
    Ok(Loaded { field, warnings, sample_type, title, sidecar })
}

/// Gives the map its place on the ground.
fn place(field: HeightField, sidecar: &mut Sidecar, path: &Path, warnings: &mut Vec<String>) -> HeightField {
    sidecar.drop_what_does_not_fit(&field, &Sidecar::path_of(path), warnings);
    let extent = sidecar.extent_of(field.cells());
    let range = sidecar.range();
    if extent.is_some() && range.is_none() {
        warnings.push(format!(
            "{} has an extent but not both lowest_metre and highest_metre: the samples themselves are taken as metres",
            Sidecar::path_of(path).display()
        ));
    }
    let range = range.unwrap_or(field.range());
    field.with_extent_metres(extent).with_range(range).with_exaggeration(sidecar.vertical_exaggeration.unwrap_or(1.0))
}

/// Columns and rows of the height map `path`, from its first bytes: cheap, for a look at a limit before [`load`] decodes
/// the picture.
///
/// # Errors
/// As [`load`], as far as the first bytes tell.
pub fn dimensions(path: &Path) -> Result<[u32; 2], LoadError> {
    let head = open(path)?.2;
    Ok([big_endian(&head, 16), big_endian(&head, 20)])
}

/// What kept `path` from being read.
fn unreadable(path: &Path, source: io::Error) -> LoadError {
    let path = path.to_path_buf();
    match source.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => LoadError::NotFound { path },
        io::ErrorKind::PermissionDenied => LoadError::PermissionDenied { path },
        io::ErrorKind::IsADirectory => LoadError::Directory { path },
        _ => LoadError::Io { path, source },
    }
}

/// The file, its length in bytes and its first [`HEAD_BYTES`], which have been checked.
fn open(path: &Path) -> Result<(File, u64, Vec<u8>), LoadError> {
    let io_error = |source| unreadable(path, source);
    // Before opening, because opening a pipe waits for its writer.
    let metadata = std::fs::metadata(path).map_err(io_error)?;
    if metadata.is_dir() {
        return Err(LoadError::Directory { path: path.into() });
    }
    let mut file = File::open(path).map_err(io_error)?;
    let mut head = Vec::with_capacity(HEAD_BYTES);
    file.by_ref().take(HEAD_BYTES as u64).read_to_end(&mut head).map_err(io_error)?;
    let bytes = metadata.len();
    check_head(&head, bytes, path)?;
    Ok((file, bytes, head))
}

/// Everything from the path to the decoded picture.
fn decode(path: &Path, progress: &dyn Fn(f32)) -> Result<DynamicImage, LoadError> {
    let io_error = |source| unreadable(path, source);
    let (mut file, bytes, _) = open(path)?;
    let complete = ends_with_iend(&mut file, bytes).map_err(io_error)?;
    file.rewind().map_err(io_error)?;

    let reader = BufReader::with_capacity(1 << 18, Counting { file, read: 0, bytes, progress });
    decode_png(reader).map_err(|(error, [width, height])| match error {
        ImageError::Limits(_) if is_too_large(width, height) => {
            LoadError::TooLarge { path: path.into(), width, height }
        }
        ImageError::IoError(source) if complete && source.kind() != io::ErrorKind::UnexpectedEof => io_error(source),
        _ if !complete => LoadError::Truncated { path: path.into() },
        error => LoadError::Damaged { path: path.into(), reason: one_line(&error) },
    })
}

/// Decodes a PNG whose head has been checked; an error comes with the size that the head announces. A profile or text
/// beside the picture cannot take more memory than [`BESIDE_THE_PICTURE`], however much is compressed into it.
fn decode_png(reader: impl io::BufRead + Seek) -> Result<DynamicImage, (ImageError, [u32; 2])> {
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(BESIDE_THE_PICTURE);
    let mut size = [0, 0];
    let decoded = PngDecoder::with_limits(reader, limits.clone()).and_then(|mut decoder| {
        size = decoder.dimensions().into();
        limits.max_alloc = Some(MAX_DECODED_BYTES);
        limits.clone().reserve(decoder.total_bytes())?;
        limits.max_alloc = Some(decoder.total_bytes() + BESIDE_THE_PICTURE);
        decoder.set_limits(limits)?;
        DynamicImage::from_decoder(decoder)
    });
    decoded.map_err(|error| (error, size))
}

/// Most bytes of what a PNG holds beside its picture: colour profiles and texts.
const BESIDE_THE_PICTURE: u64 = 4 << 20;

/// Whether a picture can be too large for [`MAX_DECODED_BYTES`], with up to 8 bytes a pixel.
fn is_too_large(width: u32, height: u32) -> bool {
    8 * u64::from(width) * u64::from(height) > MAX_DECODED_BYTES
}

/// A decoder's message, which may have several lines.
fn one_line(error: &ImageError) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The signature, and the first chunk with the picture's size, depth and colour.
const HEAD_BYTES: usize = 33;

/// Refuses what the first bytes already show to be no height map.
fn check_head(head: &[u8], bytes: u64, path: &Path) -> Result<(), LoadError> {
    let path = || path.to_path_buf();
    if head.is_empty() {
        return Err(LoadError::Empty { path: path() });
    }
    if !head.starts_with(&PNG_MAGIC) && !PNG_MAGIC.starts_with(head) {
        return Err(LoadError::NotPng { path: path(), looks_like: looks_like(head) });
    }
    if head.len() < HEAD_BYTES {
        return Err(LoadError::Truncated { path: path() });
    }
    if head[12..16] != *b"IHDR" {
        return Err(LoadError::Damaged { path: path(), reason: "its first chunk is not IHDR".into() });
    }
    let (width, height) = (big_endian(head, 16), big_endian(head, 20));
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(LoadError::TooLarge { path: path(), width, height });
    }
    if width < 2 || height < 2 {
        return Err(LoadError::NoSurface { path: path(), source: HeightFieldError::TooSmall { width, height } });
    }
    let channels = match head[25] {
        2 => 3,
        4 => 2,
        6 => 4,
        _ => 1,
    };
    let row_bytes = (u64::from(width) * channels * u64::from(head[24])).div_ceil(8) + 1;
    if row_bytes * u64::from(height) > bytes.saturating_mul(MAX_DEFLATE_RATIO) {
        return Err(LoadError::Truncated { path: path() });
    }
    Ok(())
}

/// The number that begins at byte `at`, which is inside.
fn big_endian(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Whether the last chunk is where it belongs, which tells a truncated file from a damaged one.
fn ends_with_iend(file: &mut File, bytes: u64) -> io::Result<bool> {
    let mut tail = Vec::new();
    file.seek(SeekFrom::Start(bytes.saturating_sub(12)))?;
    file.take(12).read_to_end(&mut tail)?;
    Ok(tail.get(4..8) == Some(b"IEND"))
}

/// What a file that is no PNG looks like, by its first bytes.
fn looks_like(head: &[u8]) -> &'static str {
    const KNOWN: [(&[u8], &str); 17] = [
        (b"\xff\xd8\xff", "a JPEG"),
        (b"II*\0", "a TIFF"),
        (b"MM\0*", "a TIFF"),
        (b"II+\0", "a BigTIFF"),
        (b"MM\0+", "a BigTIFF"),
        (b"GIF8", "a GIF"),
        (b"BM", "a BMP"),
        (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
        (b"\x89HDF", "an HDF5 or netCDF-4 file"),
        (b"CDF", "a netCDF file"),
        (b"\0\0\0\x0cjP", "a JPEG 2000"),
        (b"DDS ", "a DDS texture"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"%PDF", "a PDF"),
        (b"P5", "a PGM"),
        (b"ncols", "an ESRI ASCII grid"),
    ];
    if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WEBP") {
        return "a WebP";
    }
    let known = KNOWN.iter().find(|(magic, _)| head.starts_with(magic));
    let is_text = || head.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace());
    known.map_or_else(|| if is_text() { "a text file" } else { "no format known here" }, |(_, name)| name)
}

/// A file that tells how far it has been read.
struct Counting<'a> {
    file: File,
    read: u64,
    bytes: u64,
    progress: &'a dyn Fn(f32),
}

impl Read for Counting<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.read += count as u64;
        (self.progress)((self.read as f64 / self.bytes.max(1) as f64).min(1.0) as f32);
        Ok(count)
    }
}

impl Seek for Counting<'_> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.file.seek(position)
    }
}

#[cfg(test)]
#[path = "load_tests.rs"]
mod tests;
