//! `relief report`: error against run time, as tables and plots.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::ReportArgs;
use super::failure::{Exit, Failure};
use super::output::{Output, make_folder};
use super::terrain::{self, Source};
use super::watch::Watch;
use crate::camera::{Camera, NamedView};
use crate::heightfield::import::Georeference;
use crate::heightfield::{EditedTerrain, HeightField};
use crate::report::{self, Job, Report, plot, tables};
use crate::scene::Scene;
use crate::scene_file;

pub(crate) fn run(args: &ReportArgs) -> Result<(), Failure> {
    let (scene, cameras) = scenes(args)?;
    // Of several scenes the first one says what is measured.
    let source = Source::of(&scene).named_by(args.scenes.first().filter(|_| args.file.is_none()).map(PathBuf::as_path));
    let (gpu, loaded) = source.load_for_gpu(&args.open.options())?;
    terrain::check_size(args.size, gpu.capabilities.max_texture)?;
    // After all that may be refused: no empty folder is left then.
    let outputs = Outputs::prepare(&args.output)?;
    terrain::warn_of(&scene, &loaded.field);
    let map = with_craters(loaded.field, &scene);
    let views = if cameras.is_empty() {
        let extent = map.box_size(scene.terrain.height_scale);
        NamedView::MEASURED.map(|view| (view.name().to_owned(), view.camera(&map, extent))).to_vec()
    } else {
        cameras
    };
    if !gpu.capabilities.timestamps {
        super::warn(
            "there are no timestamps: the adapter has none, or RELIEF_TIMESTAMPS=0 turns them off\n  \
             times are wall times, from submitting a frame to its end",
        );
    }
    // What a picture on the ground costs is the same anywhere: a map that does not say where it lies is laid somewhere.
    let place = map.georeference().cloned().unwrap_or_else(|| Georeference::new([0.0; 2], [1.0, -1.0]));
    let map = map.with_georeference(Some(place));
    let job = Job { map_name: source.name(), map: Arc::new(map), scene, views, size: args.size, quick: args.quick };
    let report = {
        let watch = Watch::start();
        report::measure(&gpu, &job, &watch)?
    };
    if report.views.is_empty() {
        return Err(Failure::new(Exit::Failed, "nothing was measured")
            .line("It was stopped before the first picture was compared.")
            .line("No file was written; let it run longer, or use --quick."));
    }
    outputs.write(&report)?;
    match &report.stopped {
        None => {
            super::tell(&format!("the report is in {}; begin with report.md", args.output.display()));
            Ok(())
        }
        Some(reason) => Err(Failure::new(Exit::Failed, "the report is not finished")
            .line(reason.clone())
            .line(format!("What was measured until then is in {}.", args.output.display()))),
    }
}

/// The scene to measure and the cameras of the scene files; without any, the five views will be measured.
fn scenes(args: &ReportArgs) -> Result<(Scene, Vec<(String, Camera)>), Failure> {
    let mut first = None;
    let mut cameras: Vec<(String, Camera)> = Vec::new();
    for path in &args.scenes {
        let scene = scene_file::read(path)?;
        let Some(camera) = scene.camera else {
            return Err(Failure::new(Exit::BadInput, format!("{} has no camera", path.display()))
                .line("The report measures what the cameras of scene files see.")
                .line("Add a [camera] with eye, yaw and pitch, or leave --scene out for the five usual views."));
        };
        let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let twins = cameras.iter().filter(|(name, _)| *name == stem || name.starts_with(&format!("{stem} "))).count();
        cameras.push((if twins == 0 { stem } else { format!("{stem} {}", twins + 1) }, camera));
        first.get_or_insert(scene);
    }
    let mut scene = first.unwrap_or_default();
    if args.file.is_some() {
        scene.terrain.file.clone_from(&args.file);
    }
    if args.height_scale.is_some() {
        scene.terrain.height_scale = args.height_scale;
    }
    Ok((scene, cameras))
}

/// The map as the scene's craters leave it.
fn with_craters(map: HeightField, scene: &Scene) -> HeightField {
    if scene.craters.list.is_empty() {
        return map;
    }
    let mut edited = EditedTerrain::new(Arc::new(map));
    edited.set_craters(&scene.craters.list);
    edited.field().clone()
}

/// The files of a report.
struct Outputs {
    markdown: Output,
    csv: Output,
    json: Output,
    svg: Output,
    png: Output,
}

impl Outputs {
    /// Makes the folder and checks that every file can be written.
    fn prepare(folder: &Path) -> Result<Self, Failure> {
        make_folder(folder)?;
        let output = |name: &str| Output::prepare(&folder.join(name));
        Ok(Self {
            markdown: output("report.md")?,
            csv: output("report.csv")?,
            json: output("report.json")?,
            svg: output("error-vs-time.svg")?,
            png: output("error-vs-time.png")?,
        })
    }

    fn write(&self, report: &Report) -> Result<(), Failure> {
        let failed = |error: &dyn std::error::Error| {
            Failure::new(Exit::Failed, "cannot encode the report").line(error.to_string())
        };
        let svg = plot::svg(report);
        let png = plot::png(&svg).map_err(|error| failed(&error))?;
        let json = tables::json(report).map_err(|error| failed(&error))?;
        self.csv.write(tables::csv(report).as_bytes())?;
        self.json.write(&json)?;
        self.markdown.write(tables::markdown(report).as_bytes())?;
        self.svg.write(svg.as_bytes())?;
        self.png.write(&png)
    }
}
