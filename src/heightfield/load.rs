//! Opening a height map's file of any format, and the sidecar beside it.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::generate::{MakeError, Recipe};
use super::import::source::{Fault, ReadSeek, Source};
use super::import::{self, Elevation, Format, Georeference, ImportOptions, Listener, Samples, Taken, VerticalUnit};
use super::{HeightField, HeightFieldError, Sidecar};

/// Most samples on a side; textures end far below it.
pub const MAX_SIDE: u32 = 32768;

/// Why a height map did not open: what, why and what to do, a line each.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// What was to be made from a recipe was not.
    #[error(transparent)]
    Make(#[from] MakeError),
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
    #[error("cannot open {path}\n  it is no elevation file that opens here: it looks like {looks_like}\n  {advice}")]
    Unrecognised {
        /// What was to be opened.
        path: PathBuf,
        /// What its first bytes say it is.
        looks_like: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// The file ends before its samples do.
    #[error(
        "cannot open {path}\n  the {format} is truncated, it ends before its samples do\n  save or download it again"
    )]
    Truncated {
        /// What was to be opened.
        path: PathBuf,
        /// What it is.
        format: &'static str,
    },
    /// Its header promises more than it can hold.
    #[error(
        "cannot open {path}\n  the {format} is truncated: its {bytes} bytes cannot hold the {width}×{height} samples \
         that it announces\n  save or download it again"
    )]
    Promises {
        /// What was to be opened.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// Its length.
        bytes: u64,
        /// Columns that it announces.
        width: u64,
        /// Rows that it announces.
        height: u64,
    },
    /// Broken inside.
    #[error("cannot open {path}\n  the {format} is damaged ({reason})\n  save or download it again")]
    Damaged {
        /// What was to be opened.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// Known, but not supported.
    #[error("cannot open {path}\n  the {format} has {feature}, which is not supported\n  {advice}")]
    Unsupported {
        /// What was to be opened.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// What of it is not supported.
        feature: String,
        /// What to do.
        advice: &'static str,
    },
    /// Something has to be said by hand.
    #[error("cannot open {path}\n  {why}\n  {advice}")]
    Unclear {
        /// What was to be opened.
        path: PathBuf,
        /// What is not known.
        why: String,
        /// What to say.
        advice: String,
    },
    /// More samples than anything can hold.
    #[error(
        "cannot open {path}\n  it says it has {width}×{height} samples, but a {format} is read with at most {MAX_SIDE} on a \
         side\n  scale it down or cut it into parts"
    )]
    TooLarge {
        /// What was to be opened.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// More samples than the caller's limit, where it asked for no reduction.
    #[error(
        "cannot open {path}\n  its {width}×{height} samples are more than fit here\n  reduce it with --reduce, or choose a \
         part of it with --window"
    )]
    Beyond {
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
    /// Ended by the user.
    #[error("{path} was not opened\n  it was cancelled\n  open it again")]
    Cancelled {
        /// What was to be opened.
        path: PathBuf,
    },
}

/// An opened height map.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The map.
    pub field: HeightField,
    /// What was not as expected but did not stop the map from opening; each a whole sentence that names its file.
    pub warnings: Vec<String>,
    /// Type of the file's samples: "u8", "u16", "i16", "f32" and so on.
    pub sample_type: &'static str,
    /// The sidecar's title.
    pub title: Option<String>,
    /// The sidecar, if there is one that can be used. Its extent is that of the part that was taken.
    pub sidecar: Option<Sidecar>,
    /// What would have to stand beside the file for it to open like this without any option: the sidecar as it was read,
    /// and the options.
    pub stated: Sidecar,
    /// The file's format.
    pub format: Format,
    /// How its samples were packed, where the format has a choice.
    pub compression: Option<String>,
    /// Where the map lies.
    pub georeference: Option<Georeference>,
    /// What heights are measured in, where it is known; [`HeightField::range`] is in metres then.
    pub vertical_unit: Option<VerticalUnit>,
    /// Share of the samples that hold no height, 0..1.
    pub nodata_fraction: f64,
    /// The part of the file that was taken.
    pub taken: Taken,
}

impl Loaded {
    /// What a landscape made from `recipe` would be if it had been saved and opened.
    pub fn made(field: HeightField, recipe: &Recipe) -> Self {
        let full = [field.width(), field.height()];
        Self {
            field,
            warnings: Vec::new(),
            sample_type: "u16",
            title: Some(recipe.title()),
            sidecar: None,
            stated: Sidecar::default(),
            format: Format::Png,
            compression: None,
            georeference: None,
            vertical_unit: None,
            nodata_fraction: 0.0,
            taken: Taken { full, window: [0, 0, full[0], full[1]], factor: 1 },
        }
    }

    /// West, south, east and north of the map in degrees, where its place is known.
    pub fn geographic_bounds(&self) -> Option<[f64; 4]> {
        let size = [self.field.width(), self.field.height()];
        self.georeference.as_ref().and_then(|place| place.geographic_bounds(size))
    }
}

/// Opens the height map `path` and its sidecar.
pub fn load(path: &Path) -> Result<Loaded, LoadError> {
    load_with(path, &ImportOptions::default(), Listener::none())
}

/// Like [`load`], with what is known of the file besides. What the options leave open comes from the sidecar, then from
/// the file, then from a guess, which is told as a warning.
pub fn load_with(path: &Path, options: &ImportOptions, listener: Listener<'_>) -> Result<Loaded, LoadError> {
    let mut warnings = Vec::new();
    let sidecar = Sidecar::read_for(path, &mut warnings);
    load_beside(path, sidecar, options, warnings, listener)
}

/// Like [`load_with`], as if `sidecar` stood beside the file instead of what does.
pub fn load_as(
    path: &Path,
    sidecar: Sidecar,
    options: &ImportOptions,
    listener: Listener<'_>,
) -> Result<Loaded, LoadError> {
    let (mut sidecar, mut warnings) = (sidecar, Vec::new());
    sidecar.drop_what_cannot_be(&Sidecar::path_of(path), &mut warnings);
    load_beside(path, Some(sidecar), options, warnings, listener)
}

fn load_beside(
    path: &Path,
    sidecar: Option<Sidecar>,
    options: &ImportOptions,
    warnings: Vec<String>,
    listener: Listener<'_>,
) -> Result<Loaded, LoadError> {
    let elevation = decode_bytes(path, open(path)?, true, options, sidecar.as_ref(), listener)?;
    let loaded = interpret(elevation, sidecar, options, path, warnings)?;
    (listener.progress)(1.0);
    Ok(loaded)
}

/// Opens a file that is already in memory, with the text of its sidecar; `name` stands for its path in messages.
///
/// # Errors
/// As [`load`], as far as bytes can be wrong.
pub fn load_bytes(name: &Path, bytes: &[u8], sidecar: Option<&str>) -> Result<Loaded, LoadError> {
    let options = ImportOptions::default();
    let mut warnings = Vec::new();
    let sidecar = sidecar.and_then(|text| Sidecar::parse(text, &Sidecar::path_of(name), &mut warnings));
    let bytes = (Box::new(io::Cursor::new(bytes)) as Box<dyn ReadSeek + Send>, bytes.len() as u64);
    let elevation = decode_bytes(name, bytes, false, &options, sidecar.as_ref(), Listener::none())?;
    interpret(elevation, sidecar, &options, name, warnings)
}

/// Decodes `path` without making a map of it: for what keeps the file's own samples. The sidecar's place and heights hold
/// already; the warnings come with the file's name.
///
/// # Errors
/// As [`load`].
pub fn decode(
    path: &Path,
    options: &ImportOptions,
    listener: Listener<'_>,
) -> Result<(Elevation, Option<Sidecar>, Vec<String>), LoadError> {
    let mut warnings = Vec::new();
    let sidecar = Sidecar::read_for(path, &mut warnings);
    let mut elevation = decode_bytes(path, open(path)?, true, options, sidecar.as_ref(), listener)?;
    warnings.extend(elevation.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    if let Some(range) = sidecar.as_ref().and_then(Sidecar::range) {
        elevation.set_range(range);
    }
    Ok((elevation, sidecar, warnings))
}

/// The file and its length.
fn open(path: &Path) -> Result<(Box<dyn ReadSeek + Send>, u64), LoadError> {
    let io_error = |source| unreadable(path, source);
    // Before opening, because opening a pipe waits for its writer.
    let metadata = std::fs::metadata(path).map_err(io_error)?;
    if metadata.is_dir() {
        return Err(LoadError::Directory { path: path.into() });
    }
    Ok((Box::new(File::open(path).map_err(io_error)?), metadata.len()))
}

fn decode_bytes<'a>(
    path: &'a Path,
    (inner, bytes): (Box<dyn ReadSeek + Send + 'a>, u64),
    on_disk: bool,
    said: &ImportOptions,
    sidecar: Option<&Sidecar>,
    listener: Listener<'a>,
) -> Result<Elevation, LoadError> {
    let mut options = match sidecar {
        Some(sidecar) => said.clone().or(&sidecar.import),
        None => said.clone(),
    };
    options.needs_full_range = sidecar.is_some_and(|sidecar| sidecar.range().is_some());
    let mut source = Source::new(inner, bytes, path, on_disk, listener).map_err(|source| unreadable(path, source))?;
    if source.head.is_empty() {
        return Err(LoadError::Empty { path: path.into() });
    }
    let format = Format::of(&source.head, path, &options).map_err(|import::Stranger(looks_like, advice)| {
        LoadError::Unrecognised { path: path.into(), looks_like, advice }
    })?;
    let decoded = import::decode(format, &mut source, &options, said);
    // Whatever it ended with: reading was refused from then on.
    if listener.is_cancelled() {
        return Err(LoadError::Cancelled { path: path.into() });
    }
    let mut elevation = decoded.map_err(|fault| error_of(fault, path, format, bytes))?;
    if let Some(sidecar) = sidecar {
        apply(sidecar, &mut elevation);
    }
    Ok(elevation)
}

/// What the sidecar says holds against what the file says.
fn apply(sidecar: &Sidecar, elevation: &mut Elevation) {
    let [x, y, _, _] = elevation.taken.window;
    if let Some(place) = sidecar.georeference() {
        elevation.georeference = Some(place.part([x, y], elevation.taken.factor));
    } else {
        elevation.georeference = elevation.georeference.take().map(|place| sidecar.with_system(place));
    }
    if sidecar.crs.is_some() || sidecar.crs_unit.is_some() {
        elevation.warnings.retain(|warning| !warning.starts_with(import::UNIT_GUESSED));
    }
}

/// The map of what was decoded, at the place that the sidecar gives it.
fn interpret(
    mut elevation: Elevation,
    mut sidecar: Option<Sidecar>,
    options: &ImportOptions,
    path: &Path,
    mut warnings: Vec<String>,
) -> Result<Loaded, LoadError> {
    warnings.extend(elevation.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    let mut stated = sidecar.clone().unwrap_or_default();
    stated.import = ImportOptions { limit: None, refuse_larger: false, ..options.clone() }.or(&stated.import);
    let policy = stated.import.holes.unwrap_or_default();
    // What is known besides the samples, which the map takes.
    let samples = std::mem::replace(&mut elevation.samples, Samples::U8(Vec::new()));
    let facts = elevation.clone();
    let extent = facts.extent_metres();
    let field = Elevation { samples, ..elevation }.into_field(policy);
    let field = field.map_err(|source| LoadError::NoSurface { path: path.into(), source })?.with_extent_metres(extent);
    let field = match &mut sidecar {
        Some(sidecar) => {
            sidecar.of_part(&facts.taken);
            place(field, sidecar, &facts, path, &mut warnings)
        }
        None => field,
    };
    // The sidecar's heights are metres, whatever the file's are.
    let has_range = sidecar.as_ref().is_some_and(|sidecar| sidecar.range().is_some());
    let metres = has_range || facts.vertical_unit.is_some();
    let field = field.with_georeference(facts.georeference.clone()).with_metres(metres);
    Ok(Loaded {
        field,
        warnings,
        sample_type: facts.sample_type,
        title: sidecar.as_ref().and_then(|sidecar| sidecar.title.clone()),
        sidecar,
        stated,
        format: facts.format,
        nodata_fraction: facts.hole_fraction(),
        compression: facts.compression,
        georeference: facts.georeference,
        vertical_unit: has_range.then_some(VerticalUnit::Metre).or(facts.vertical_unit),
        taken: facts.taken,
    })
}

/// Gives the map the place that its sidecar says.
fn place(
    field: HeightField,
    sidecar: &mut Sidecar,
    facts: &Elevation,
    path: &Path,
    warnings: &mut Vec<String>,
) -> HeightField {
    sidecar.drop_what_does_not_fit(&field, facts.extent_metres(), &Sidecar::path_of(path), warnings);
    let extent = sidecar.extent_of(field.cells());
    if extent.is_some() && sidecar.range().is_none() && !facts.metric && facts.vertical_unit.is_none() {
        warnings.push(format!(
            "{} has an extent but not both lowest_metre and highest_metre: the samples themselves are taken as metres",
            Sidecar::path_of(path).display()
        ));
    }
    let range = sidecar.range().map_or(field.range(), |stated| facts.stated_range(field.range(), stated));
    let extent = extent.or(field.extent_metres());
    field.with_extent_metres(extent).with_range(range).with_exaggeration(sidecar.vertical_exaggeration.unwrap_or(1.0))
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

/// The fault with the file's name and format.
fn error_of(fault: Fault, path: &Path, format: Format, bytes: u64) -> LoadError {
    let (path, format) = (path.to_path_buf(), format.name());
    match fault {
        Fault::Truncated => LoadError::Truncated { path, format },
        Fault::Promises([width, height]) => LoadError::Promises { path, format, bytes, width, height },
        Fault::Damaged(reason) => LoadError::Damaged { path, format, reason },
        Fault::Unsupported(feature, advice) => LoadError::Unsupported { path, format, feature, advice },
        Fault::Unclear(why, advice) => LoadError::Unclear { path, why, advice },
        Fault::TooLarge([width, height]) => LoadError::TooLarge { path, format, width, height },
        Fault::Beyond([width, height]) => LoadError::Beyond { path, width, height },
        Fault::TooSmall(size) => {
            let [width, height] = size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
            LoadError::NoSurface { path, source: HeightFieldError::TooSmall { width, height } }
        }
        Fault::AllHoles([width, height]) => {
            LoadError::NoSurface { path, source: HeightFieldError::AllHoles { width, height } }
        }
        Fault::Io(source) => unreadable(&path, source),
    }
}

#[cfg(test)]
#[path = "load_tests.rs"]
mod tests;
