//! `relief convert`: an elevation file in another format.

use std::path::{Path, PathBuf};

use super::args::ConvertArgs;
use super::failure::{Exit, Failure};
use super::output::Output;
use super::progress::Progress;
use super::terrain::{cannot_open, listener};
use crate::heightfield::export::{self, ExportFormat};
use crate::heightfield::import::Elevation;
use crate::heightfield::{Holes, Sidecar, load};

pub(crate) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let Some(format) = ExportFormat::of(&args.output) else {
        return Err(Failure::usage(format!("{} has no ending that says a format", args.output.display()))
            .line(format!("Known are {}.", ExportFormat::ENDINGS))
            .line("Name the file with one of them."));
    };
    let output = Output::prepare(&args.output)?;
    let file = output.regular_file()?;
    if output.same_file(&args.file) {
        return Err(Failure::usage(format!("{} would replace the file it is made from", args.output.display()))
            .line("That would lose what the new format cannot hold.")
            .line("Give another name."));
    }
    spare_sidecar(file, &args.output)?;

    let options = args.open.options();
    let (elevation, sidecar) = {
        let progress = Progress::start("reading the elevations");
        let decoded = load::decode(&args.file, &options, listener(&|share| progress.set(share)));
        let (elevation, sidecar, warnings) = decoded.map_err(|error| cannot_open(&args.file, None, error))?;
        drop(progress);
        warnings.iter().for_each(|warning| super::warn(warning));
        (elevation, sidecar)
    };
    let policy = options.holes.or(sidecar.as_ref().and_then(|sidecar| sidecar.import.holes)).unwrap_or_default();
    let elevation = if elevation.holes.is_some() && policy != Holes::CutOut {
        without_holes(elevation, policy)?
    } else {
        elevation
    };
    let written = {
        let _progress = Progress::start("writing the elevations");
        export::write(&elevation, sidecar.as_ref(), format, file)?
    };
    for companion in &written.companions {
        super::tell(&format!("{} says what the file itself cannot", companion.display()));
    }
    if written.rounded_by > 0.0 {
        super::tell(&format!("16 bits hold its heights to within {:.3e}", written.rounded_by));
    }
    Ok(())
}

/// The heights as they are drawn, holes filled or floored.
fn without_holes(elevation: Elevation, policy: Holes) -> Result<Elevation, Failure> {
    let (place, unit, full) = (elevation.georeference.clone(), elevation.vertical_unit, elevation.taken);
    let field = elevation.into_field(policy).map_err(|error| Failure::new(Exit::BadInput, error.to_string()))?;
    let metres = unit.map(|_| crate::heightfield::import::VerticalUnit::Metre);
    Ok(Elevation { vertical_unit: metres, taken: full, ..Elevation::of_field(&field, place) })
}

/// A scene, or what says how another map is read, must not be replaced just because it has the same stem.
fn spare_sidecar(file: &Path, shown: &Path) -> Result<(), Failure> {
    let sidecar = Sidecar::path_of(file);
    let mut warnings = Vec::new();
    if sidecar.exists() && Sidecar::read_for(file, &mut warnings).is_none() {
        return Err(Failure::new(Exit::Failed, format!("cannot write {}", shown.display()))
            .line(format!("{} exists and is no sidecar; it would be replaced.", sidecar.display()))
            .line("Nothing was written. Give another name, or move that file."));
    }
    if let Some(other) = sidecar.exists().then(|| sibling(file)).flatten() {
        return Err(Failure::new(Exit::Failed, format!("cannot write {}", shown.display()))
            .line(format!(
                "{} says where {} lies and how it is read; it would be replaced, and that file shown wrong.",
                sidecar.display(),
                other.display()
            ))
            .line("Nothing was written. Give a name that differs in more than its ending."));
    }
    Ok(())
}

/// Another file that goes by the sidecar of `file`: of the same name but for the ending.
fn sibling(file: &Path) -> Option<PathBuf> {
    /// Endings of what stands beside a map without being one.
    const COMPANIONS: [&str; 3] = ["toml", "hdr", "prj"];
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let paths = std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.is_file() && path.file_stem() == file.file_stem()).find(|path| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        path.file_name() != file.file_name() && !COMPANIONS.contains(&ending.as_str())
    })
}
