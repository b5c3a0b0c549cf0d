//! Writing elevations: 16-bit PNG, GeoTIFF, ESRI ASCII and binary grids, raw samples; with all that is known of their
//! place, and whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use tiff::TiffError;
use tiff::encoder::{
    Compression, DeflateLevel, Predictor, TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard, colortype,
};
use tiff::tags::Tag;

use super::import::{
    self, Elevation, Endian, Georeference, GroundUnit, ImportOptions, NoData, PixelIs, RawType, Sample, Samples,
    UnitText, VerticalUnit, with_samples,
};
use super::save::{self, SaveError};
use super::{HeightField, Sidecar};
use crate::files;

/// What can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub enum ExportFormat {
    /// 16-bit greyscale PNG and a sidecar
    Png,
    /// GeoTIFF, with the samples as they are
    Tif,
    /// ESRI ASCII grid
    Asc,
    /// 32-bit floats with an ESRI header
    Flt,
    /// Raw 16-bit samples and a sidecar
    R16,
    /// Raw 32-bit floats and a sidecar
    R32,
}

impl ExportFormat {
    /// The format of a file with this name.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "tif" | "tiff" => Some(Self::Tif),
            "asc" => Some(Self::Asc),
            "flt" => Some(Self::Flt),
            "r16" => Some(Self::R16),
            "r32" => Some(Self::R32),
            _ => None,
        }
    }

    /// The endings that are known, for messages.
    pub const ENDINGS: &'static str = ".png, .tif, .asc, .flt, .r16, .r32";
}

/// What was written, besides the file itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// Companions: a sidecar, a header.
    pub companions: Vec<PathBuf>,
    /// How far a height can be from what it was, in its own unit; 0 where each is as it was.
    pub rounded_by: f64,
    /// Its header says a cell's size that means nothing, because nothing is known of the map's; the sidecar says so.
    pub no_lengths: bool,
}

impl Elevation {
    /// The elevation of a map, with craters and all: heights as they are drawn.
    pub fn of_field(field: &HeightField, georeference: Option<Georeference>) -> Self {
        let [low, high] = field.range();
        let span = high - low;
        let height = |&sample: &f32| match field.units() {
            // Whole numbers come back whole.
            Some(units) => low + (f64::from(sample) * f64::from(units)).round() * span / f64::from(units),
            None => low + f64::from(sample) * span,
        };
        let (width, rows) = (field.width(), field.height());
        Self {
            width,
            height: rows,
            samples: Samples::F32(field.samples().iter().map(|sample| height(sample) as f32).collect()),
            holes: field.holes().cloned(),
            scale: 1.0,
            offset: 0.0,
            vertical_unit: field.extent_metres().map(|_| VerticalUnit::Metre),
            metric: true,
            georeference,
            format: import::Format::Raw,
            compression: None,
            sample_type: "f32",
            taken: import::Taken { full: [width, rows], window: [0, 0, width, rows], factor: 1 },
            full_range: Some([low, high]),
            warnings: Vec::new(),
        }
    }

    /// The heights in the vertical unit, and a number for each hole.
    fn heights(&self, hole: f64) -> impl Iterator<Item = f64> + '_ {
        let holes = self.holes.as_ref();
        (0..self.samples.len()).map(move |index| {
            let is_hole = holes.is_some_and(|holes| holes.contains(index));
            if is_hole { hole } else { self.samples.get(index) * self.scale + self.offset }
        })
    }

    /// Lowest and highest height in the vertical unit.
    fn height_range(&self) -> [f64; 2] {
        self.heights(f64::NAN)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)])
    }
}

/// Writes `elevation` to `path`. `sidecar` is that of the file it came from: its title, source and licence go along.
/// Companions come before the file, so that no file is ever without them.
///
/// # Errors
/// [`SaveError`]: the system's words. Nothing half-written is left.
pub fn write(
    elevation: &Elevation,
    sidecar: Option<&Sidecar>,
    format: ExportFormat,
    path: &Path,
) -> Result<Written, SaveError> {
    let failed = |path: &Path, error: &io::Error| SaveError { path: path.into(), reason: error.to_string() };
    let mut written = Written::default();
    let mut companion = |path: PathBuf, text: &str| {
        files::write_whole(&path, text.as_bytes()).map_err(|error| failed(&path, &error))?;
        written.companions.push(path);
        Ok::<_, SaveError>(())
    };
    let text = sidecar_for(elevation, sidecar, format).to_toml();
    let text = text.map_err(|reason| SaveError { path: Sidecar::path_of(path), reason })?;
    let beside = Sidecar::path_of(path);
    if !text.trim().is_empty() {
        companion(beside, &text)?;
    } else if beside.exists() {
        // What another file of this name needed would be wrong for this one.
        companion(beside, "# The file itself says all.\n")?;
    }
    if format == ExportFormat::Flt {
        companion(path.with_extension("hdr"), &esri_header(elevation, "\r\n", ESRI_NODATA, "LSBFIRST"))?;
    }
    written.no_lengths = has_no_lengths(elevation, sidecar, format);
    let steps = Steps::of(elevation);
    let result = match format {
        ExportFormat::Png => {
            let (width, height) = (elevation.width, elevation.height);
            save::save_raw_png16(width, height, &steps.samples(elevation), path)?;
            Ok(())
        }
        ExportFormat::R16 => {
            let samples = steps.samples(elevation);
            files::write_with(path, |file| write_all(file, samples.into_iter().map(u16::to_le_bytes)))
        }
        ExportFormat::R32 => files::write_with(path, |file| {
            write_all(file, elevation.heights(f64::NAN).map(|height| (height as f32).to_le_bytes()))
        }),
        ExportFormat::Flt => files::write_with(path, |file| {
            write_all(file, elevation.heights(ESRI_NODATA).map(|height| (height as f32).to_le_bytes()))
        }),
        ExportFormat::Asc => files::write_with(path, |file| write_ascii(file, elevation)),
        ExportFormat::Tif => files::write_with(path, |file| write_tiff(file, elevation)),
    };
    result.map_err(|error| failed(path, &error))?;
    written.rounded_by = match format {
        ExportFormat::Png | ExportFormat::R16 => steps.rounded_by(),
        _ => 0.0,
    };
    Ok(written)
}

/// Means "no height" in ESRI's grids.
const ESRI_NODATA: f64 = f32::MIN as f64;

fn write_all<const N: usize>(file: &mut File, samples: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    for sample in samples {
        writer.write_all(&sample)?;
    }
    writer.flush()
}

/// How heights become 16-bit samples.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Steps {
    /// The file's own numbers.
    Own {
        /// Stands for holes; no height has it.
        hole: u16,
    },
    /// The lowest height becomes `first`, and so on in steps.
    Spread { low: f64, step: f64, first: u16, exact: bool },
}

impl Steps {
    fn of(elevation: &Elevation) -> Self {
        let has_holes = elevation.holes.is_some();
        let [low, high] = elevation.height_range();
        let whole = with_samples!(&elevation.samples, samples => {
            samples.iter().all(|&sample| import::number(sample).fract() == 0.0)
        });
        let most = f64::from(u16::MAX);
        if whole && elevation.scale == 1.0 && elevation.offset == 0.0 && low >= 0.0 && high <= most {
            // A number that no height has.
            let free = [0.0, most].into_iter().find(|code| low > *code || high < *code);
            if let Some(hole) = free.or((!has_holes).then_some(0.0)) {
                return Self::Own { hole: hole as u16 };
            }
        }
        let first = u16::from(has_holes);
        let most = f64::from(u16::MAX - first);
        // Whole steps of the file's own, where they fit.
        let own = elevation.scale.abs();
        if whole && ((high - low) / own).round() <= most {
            return Self::Spread { low, step: own, first, exact: true };
        }
        Self::Spread { low, step: (high - low) / most, first, exact: false }
    }

    fn samples(self, elevation: &Elevation) -> Vec<u16> {
        let code = |height: f64| match self {
            Self::Own { hole } if height.is_nan() => hole,
            Self::Own { .. } => height as u16,
            Self::Spread { .. } if height.is_nan() => 0,
            Self::Spread { low, step, first, .. } => {
                let steps = if step > 0.0 { ((height - low) / step).round() } else { 0.0 };
                (steps as u16).saturating_add(first)
            }
        };
        elevation.heights(f64::NAN).map(code).collect()
    }

    fn rounded_by(self) -> f64 {
        match self {
            Self::Spread { step, exact: false, .. } => step * 0.5,
            _ => 0.0,
        }
    }

    fn hole(self) -> f64 {
        match self {
            Self::Own { hole } => f64::from(hole),
            Self::Spread { .. } => 0.0,
        }
    }
}

/// Whether nothing says how long the map's steps are on the ground, and the format has to say it all the same.
fn has_no_lengths(elevation: &Elevation, sidecar: Option<&Sidecar>, format: ExportFormat) -> bool {
    let extent = sidecar.is_some_and(|sidecar| sidecar.extent_metres.is_some() || sidecar.metres_per_sample.is_some());
    let headed = matches!(format, ExportFormat::Asc | ExportFormat::Flt);
    headed && !extent && elevation.georeference.as_ref().is_none_or(|place| place.unit.is_none())
}

/// All that the file itself cannot say.
fn sidecar_for(elevation: &Elevation, from: Option<&Sidecar>, format: ExportFormat) -> Sidecar {
    let place = elevation.georeference.as_ref();
    let metres = elevation.vertical_unit.map_or(1.0, VerticalUnit::metres);
    let sixteen = matches!(format, ExportFormat::Png | ExportFormat::R16);
    let raw = matches!(format, ExportFormat::R16 | ExportFormat::R32);
    let headed = matches!(format, ExportFormat::Asc | ExportFormat::Flt | ExportFormat::Tif);
    let tif = format == ExportFormat::Tif;
    // The lowest and highest sample of the picture stand for these; of a picture whose own numbers stay nothing was said.
    let own = matches!(Steps::of(elevation), Steps::Own { .. });
    let known = elevation.metric || elevation.vertical_unit.is_some() || !own;
    let range = elevation.height_range().map(|height| height * metres);
    let range = Some(range).filter(|_| sixteen && known);
    // ESRI's headers have to say a cell's size. Without this word it would be taken for metres, and the map would lose its
    // proportion.
    let no_lengths = has_no_lengths(elevation, from, format);
    let mut kept = from.cloned().unwrap_or_default();
    kept.of_part(&elevation.taken);
    // What the place says already need not be said again; what corrects it has to be.
    let corrects =
        kept.extent_of([elevation.width, elevation.height].map(|count| count.max(2) - 1)).is_some_and(|said| {
            let close = |(said, own): (f64, f64)| (said / own - 1.0).abs() < 1e-4;
            elevation.extent_metres().is_none_or(|own| !said.into_iter().zip(own).all(close))
        });
    Sidecar {
        extent_metres: kept.extent_metres.filter(|_| corrects),
        metres_per_sample: kept.metres_per_sample.filter(|_| corrects),
        lowest_metre: range.map(|range| range[0]),
        highest_metre: range.map(|range| range[1]),
        crs: place.and_then(|place| place.crs.clone()).or(kept.crs).filter(|_| !tif || place.is_none()),
        // Its number says it, but for units of other lengths.
        crs_unit: place
            .filter(|place| {
                !tif && (place.epsg.is_none() || matches!(place.unit, Some(GroundUnit::Metres(m)) if m != 1.0))
            })
            .and_then(|place| UnitText::of(place.unit?))
            .or(no_lengths.then_some(UnitText::NONE)),
        origin: place.filter(|_| !headed).map(|place| place.origin),
        step: place.filter(|place| !headed && !place.is_rotated()).map(|place| [place.column[0], place.row[1]]),
        pixel_is: place.filter(|place| !headed && place.pixel == PixelIs::Point).map(|place| place.pixel),
        import: ImportOptions {
            raw_size: raw.then_some([elevation.width, elevation.height]),
            raw_type: raw.then_some(if format == ExportFormat::R16 { RawType::U16 } else { RawType::F32 }),
            raw_endian: raw.then_some(Endian::Little),
            nodata: (sixteen && elevation.holes.is_some()).then(|| NoData::Value(Steps::of(elevation).hole())),
            vertical_unit: elevation
                .vertical_unit
                .filter(|unit| !sixteen && !tif && (raw || *unit != VerticalUnit::Metre)),
            holes: kept.import.holes,
            ..ImportOptions::default()
        },
        ..kept
    }
}

/// The lines of a header; the numbers of a place only where there is one and it is not rotated.
fn esri_header(elevation: &Elevation, end: &str, nodata: f64, order: &str) -> String {
    let mut lines = vec![format!("ncols {}", elevation.width), format!("nrows {}", elevation.height)];
    let plain = Georeference::new([0.0, f64::from(elevation.height - 1)], [1.0, -1.0]);
    let place = elevation.georeference.as_ref().filter(|place| !place.is_rotated()).unwrap_or(&plain);
    let [dx, dy] = [place.column[0], -place.row[1]];
    let (half, word) = if place.pixel == PixelIs::Area { (0.5, "corner") } else { (0.0, "center") };
    let south = place.at(0.0, f64::from(elevation.height - 1))[1];
    lines.push(format!("xll{word} {}", place.origin[0] - dx * half));
    lines.push(format!("yll{word} {}", south - dy * half));
    if (dx - dy).abs() <= 1e-12 * dx.abs() {
        lines.push(format!("cellsize {dx}"));
    } else {
        lines.push(format!("dx {dx}"));
        lines.push(format!("dy {dy}"));
    }
    lines.push(format!("NODATA_value {nodata}"));
    if !order.is_empty() {
        lines.push(format!("byteorder {order}"));
    }
    lines.iter().flat_map(|line| [line.as_str(), end]).collect()
}

fn write_ascii(file: &mut File, elevation: &Elevation) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    let [low, _] = elevation.height_range();
    // A number below all heights.
    let hole = if low > -9999.0 { -9999.0 } else { low.floor() * 2.0 - 1.0 };
    writer.write_all(esri_header(elevation, "\n", hole, "").as_bytes())?;
    for (index, height) in elevation.heights(hole).enumerate() {
        let end = if (index + 1) % elevation.width as usize == 0 { '\n' } else { ' ' };
        match &elevation.samples {
            // The shortest digits that give the same 32 bits again.
            Samples::F32(_) if elevation.scale == 1.0 && elevation.offset == 0.0 && height != hole => {
                write!(writer, "{}{end}", height as f32)?;
            }
            _ => write!(writer, "{height}{end}")?,
        }
    }
    writer.flush()
}

fn write_tiff(file: &mut File, elevation: &Elevation) -> io::Result<()> {
    // What has a scale would lose it, so the heights themselves are written: in 32 bits where those hold them.
    if elevation.scale != 1.0 || elevation.offset != 0.0 {
        let fits = elevation.heights(0.0).all(|height| f64::from(height as f32) == height);
        let samples = if fits {
            Samples::F32(elevation.heights(0.0).map(|height| height as f32).collect())
        } else {
            Samples::F64(elevation.heights(0.0).collect())
        };
        return write_tiff(file, &Elevation { samples, scale: 1.0, offset: 0.0, ..elevation.clone() });
    }
    match &elevation.samples {
        Samples::U8(samples) => encode::<colortype::Gray8>(file, elevation, samples),
        Samples::I8(samples) => encode::<colortype::GrayI8>(file, elevation, samples),
        Samples::U16(samples) => encode::<colortype::Gray16>(file, elevation, samples),
        Samples::I16(samples) => encode::<colortype::GrayI16>(file, elevation, samples),
        Samples::U32(samples) => encode::<colortype::Gray32>(file, elevation, samples),
        Samples::I32(samples) => encode::<colortype::GrayI32>(file, elevation, samples),
        Samples::F32(samples) => encode::<colortype::Gray32Float>(file, elevation, samples),
        Samples::F64(samples) => encode::<colortype::Gray64Float>(file, elevation, samples),
    }
}

/// Numbers that can stand for "no height", the usual ones first.
const NODATA: [f64; 11] =
    [-32768.0, -9999.0, -2_147_483_648.0, 65535.0, 255.0, 4_294_967_295.0, -128.0, 0.0, 127.0, 1.0, 254.0];

fn encode<C>(file: &mut File, elevation: &Elevation, samples: &[C::Inner]) -> io::Result<()>
where
    C: colortype::ColorType<Inner: Sample>,
    [C::Inner]: tiff::encoder::TiffValue,
{
    let Some(holes) = &elevation.holes else {
        return encode_with::<C>(file, elevation, samples, None);
    };
    let float = C::Inner::NAME.starts_with('f');
    let free = |value: &f64| {
        C::Inner::exactly(*value).is_some_and(|value| {
            !samples.iter().enumerate().any(|(index, sample)| *sample == value && !holes.contains(index))
        })
    };
    let code = if float { Some(f64::NAN) } else { NODATA.into_iter().find(free) };
    let Some(code) = code else {
        // Every number is a height: a larger type has others.
        let samples = samples.iter().map(|&sample| -> f64 { sample.into() }).collect();
        return write_tiff(file, &Elevation { samples: Samples::F64(samples), ..elevation.clone() });
    };
    let number = C::Inner::NO_NUMBER.or(C::Inner::exactly(code)).unwrap_or(C::Inner::ZERO);
    let mut samples = samples.to_vec();
    for index in holes.indices() {
        samples[index] = number;
    }
    let code = if float { "nan".to_owned() } else { code.to_string() };
    encode_with::<C>(file, elevation, &samples, Some(&code))
}

fn encode_with<C>(file: &mut File, elevation: &Elevation, samples: &[C::Inner], nodata: Option<&str>) -> io::Result<()>
where
    C: colortype::ColorType<Inner: Sample>,
    [C::Inner]: tiff::encoder::TiffValue,
{
    // Offsets of 32 bits end at 4 GiB; half of that leaves room for what does not compress.
    if samples.len() as u64 * C::Inner::BYTES as u64 > 1 << 31 {
        encode_as::<C, TiffKindBig>(file, elevation, samples, nodata)
    } else {
        encode_as::<C, TiffKindStandard>(file, elevation, samples, nodata)
    }
    .map_err(|error| match error {
        TiffError::IoError(error) => error,
        error => io::Error::other(error.to_string()),
    })
}

fn encode_as<C, K>(
    file: &mut File,
    elevation: &Elevation,
    samples: &[C::Inner],
    nodata: Option<&str>,
) -> Result<(), TiffError>
where
    C: colortype::ColorType<Inner: Sample>,
    [C::Inner]: tiff::encoder::TiffValue,
    K: TiffKind,
{
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    let predictor = if C::Inner::NAME.starts_with('f') { Predictor::None } else { Predictor::Horizontal };
    let mut encoder = TiffEncoder::<_, K>::new_generic(&mut writer)?
        .with_predictor(predictor)
        .with_compression(Compression::Deflate(DeflateLevel::Balanced));
    let mut image = encoder.new_image::<C>(elevation.width, elevation.height)?;
    let tags = image.encoder();
    if let Some(nodata) = nodata {
        tags.write_tag(Tag::GdalNodata, nodata)?;
    }
    if let Some(place) = &elevation.georeference {
        let (transformation, keys, texts) = import::tags_of(place, elevation.vertical_unit);
        tags.write_tag(Tag::ModelTransformationTag, &transformation[..])?;
        tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..])?;
        if !texts.is_empty() {
            tags.write_tag(Tag::GeoAsciiParamsTag, texts.as_str())?;
        }
    }
    image.write_data(samples)?;
    Ok(writer.flush()?)
}
