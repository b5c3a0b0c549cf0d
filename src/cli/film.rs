//! `relief render --path`: the pictures of a camera path.

use std::path::Path;

use super::args::RenderArgs;
use super::failure::{Exit, Failure};
use super::progress::Progress;
use super::render::Easel;
use super::terrain::{self, Source};
use crate::animation::{AnimationWriter, Kind};
use crate::camera_path::{CameraPath, PathFileError};
use crate::scene::motion::FilmClocks;
use crate::scene_file;

/// Draws the way of `path` into the folder or the file that `args` names.
pub(super) fn run(args: &RenderArgs, path: &Path) -> Result<(), Failure> {
    let way = CameraPath::read(path)?;
    let Some(track) = way.track() else {
        return Err(PathFileError::TooShort { path: path.to_path_buf(), found: way.frames.len() }.into());
    };
    let count = way.pictures(args.frames_per_second);
    // Refused before any long work.
    let mut writer = AnimationWriter::new(&args.output, args.size, count, args.frames_per_second)?;
    let mut scene = terrain::compose(&args.scene)?;
    let inputs = scene_file::files(&scene).map(AsRef::as_ref).chain(args.scene.scene.as_deref()).chain([path]);
    spare(&args.output, inputs)?;
    let (gpu, map) = Source::chosen(&args.scene, &scene).load_for_gpu(&args.scene.open.options())?;
    terrain::check_size(args.size, gpu.capabilities.max_texture)?;
    scene.lighting.clock.stand_on(map.geographic_bounds());
    scene.camera = Some(track.at(0.0));
    terrain::place_camera(&args.scene, &mut scene, &map.field)?;
    terrain::warn_of(&scene, &map.field);
    let mut easel = Easel::new(gpu, scene, map.field, args.size)?;
    let progress = Progress::start("drawing the path").with_time_left();
    let clocks = FilmClocks::of(&easel.scene);
    for picture in 0..count {
        let share = f64::from(picture) / f64::from(count - 1);
        easel.scene.camera = Some(track.at(track.seconds() * share));
        clocks.set(&mut easel.scene, f64::from(picture) / f64::from(args.frames_per_second));
        easel.frame()?;
        writer.push(&easel.picture()?)?;
        progress.set(share as f32);
    }
    drop(progress);
    let path = writer.finish()?;
    let what = if Kind::of(&path).is_ok_and(|kind| kind == Kind::Folder) { "as PNGs in" } else { "as" };
    super::tell(&format!("{count} pictures {what} {}", path.display()));
    Ok(())
}

/// Refuses to replace a file that the pictures are made from.
fn spare<'a>(output: &Path, mut inputs: impl Iterator<Item = &'a Path>) -> Result<(), Failure> {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    match inputs.find(|input| real(input).is_some_and(|input| real(output) == Some(input))) {
        None => Ok(()),
        Some(input) => Err(Failure::new(Exit::Usage, format!("{} is an input and the output", input.display()))
            .line("It would be lost.")
            .line("Give the output another name.")),
    }
}
