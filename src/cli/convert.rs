//! `relief convert`: an elevation file in another format.

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
    spare_scene(file, &args.output)?;

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

/// A scene must not be replaced by a sidecar, just because it has the same stem.
fn spare_scene(file: &std::path::Path, shown: &std::path::Path) -> Result<(), Failure> {
    let sidecar = Sidecar::path_of(file);
    let mut warnings = Vec::new();
    if sidecar.exists() && Sidecar::read_for(file, &mut warnings).is_none() {
        return Err(Failure::new(Exit::Failed, format!("cannot write {}", shown.display()))
            .line(format!("{} exists and is no sidecar; it would be replaced.", sidecar.display()))
            .line("Nothing was written. Give another name, or move that file."));
    }
    Ok(())
}
