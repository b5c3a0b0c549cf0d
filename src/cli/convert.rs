//! `relief convert`: an elevation file in another format, or a scene's map with its craters.

use std::path::Path;
use std::sync::Arc;

use super::args::ConvertArgs;
use super::failure::{Exit, Failure};
use super::output::Output;
use super::progress::Progress;
use super::terrain::{Source, cannot_open, listener};
use crate::heightfield::companions::{self, SidecarError};
use crate::heightfield::export::{self, ExportFormat};
use crate::heightfield::import::{Elevation, ImportOptions};
use crate::heightfield::{EditedTerrain, Holes, Provenance, Sidecar, load};
use crate::scene_file;

pub(crate) fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let Some(format) = ExportFormat::of(&args.output) else {
        return Err(Failure::usage(format!("{} has no ending that says a format", args.output.display()))
            .line(format!("Known are {}.", ExportFormat::ENDINGS))
            .line("Name the file with one of them."));
    };
    let output = Output::prepare(&args.output)?;
    let file = output.regular_file()?;
    if args.file.as_deref().is_some_and(|input| output.same_file(input)) {
        return Err(Failure::usage(format!("{} would replace the file it is made from", args.output.display()))
            .line("That would lose what the new format cannot hold.")
            .line("Give another name."));
    }
    spare_sidecar(file, &args.output)?;
    spare_file(file, &args.output, args.force)?;

    let options = args.open.options();
    let (elevation, sidecar) = match (&args.scene, &args.file) {
        (Some(scene), file) => edited(scene, file.as_deref(), &output, &options)?,
        (None, Some(file)) => as_it_is(file, &options)?,
        (None, None) => return Err(Failure::usage("there is nothing to convert").line("Name an elevation file.")),
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
    if written.no_lengths {
        super::warn(&format!(
            "{} has to say a cell's size, but nothing says how large the map is: 1 stands there and means nothing; keep its \
             sidecar beside it, or other programs and this one will take it for 1 m",
            args.output.display()
        ));
    }
    Ok(())
}

/// The file's own samples.
fn as_it_is(file: &Path, options: &ImportOptions) -> Result<(Elevation, Option<Sidecar>), Failure> {
    let (elevation, sidecar) = {
        let progress = Progress::start("reading the elevations");
        let decoded = load::decode(file, options, listener(&|share| progress.set(share)));
        let (elevation, sidecar, warnings) = decoded.map_err(|error| cannot_open(file, None, error))?;
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
    Ok((elevation, sidecar))
}

/// The scene's map, or `file`, with the scene's craters in it.
fn edited(
    scene: &Path,
    file: Option<&Path>,
    output: &Output,
    options: &ImportOptions,
) -> Result<(Elevation, Option<Sidecar>), Failure> {
    let mut read = scene_file::read(scene)?;
    let named_by = file.is_none().then_some(scene);
    read.terrain.file = file.map(Path::to_path_buf).or(read.terrain.file);
    if read.terrain.file.as_deref().is_some_and(|input| output.same_file(input)) {
        return Err(Failure::usage(format!("{} would replace the map it is made from", output.path().display()))
            .line("The map without craters would be lost.")
            .line("Give another name."));
    }
    if read.craters.list.is_empty() {
        super::tell(&format!("{} has no craters: the map is written as it is", scene.display()));
    }
    let loaded = Source::of(&read).named_by(named_by).load(options)?;
    let provenance = Provenance::of(&loaded, read.terrain.file.clone());
    let mut terrain = EditedTerrain::new(Arc::new(loaded.field));
    terrain.set_craters(&read.craters.list);
    Ok((provenance.elevation(terrain.field()), Some(provenance.sidecar_to_write())))
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
    let failure = || Failure::new(Exit::Failed, format!("cannot write {}", shown.display()));
    companions::check(file, false).map_err(|error| match error {
        SidecarError::NoSidecar { path } => failure()
            .line(format!("{} exists and is no sidecar; it would be replaced.", path.display()))
            .line("Nothing was written. Give another name, or move that file."),
        SidecarError::Shared { path, other } => failure()
            .line(format!(
                "{} says where {} lies and how it is read; it would be replaced, and that file shown wrong.",
                path.display(),
                other.display()
            ))
            .line("Nothing was written. Give a name that differs in more than its ending."),
        error @ SidecarError::System { .. } => Failure::new(Exit::Failed, error.to_string()),
    })
}

/// What exists is replaced only by those who say so.
pub(super) fn spare_file(file: &Path, shown: &Path, force: bool) -> Result<(), Failure> {
    if force || !file.exists() {
        return Ok(());
    }
    Err(Failure::new(Exit::Failed, format!("cannot write {}", shown.display()))
        .line("It exists, and would be replaced.")
        .line("Nothing was written. Say --force to replace it, or give another name."))
}
