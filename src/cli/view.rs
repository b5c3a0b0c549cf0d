//! `relief` and `relief view`: the viewer, or where there is no display, its start view as a picture.

use std::path::Path;
use std::sync::Arc;

use super::args::ViewArgs;
use super::failure::Failure;
use super::output::Output;
use super::render;
use super::terrain::{self, Source};
use crate::app::{self, AppError, ViewerOptions};
use crate::heightfield::Provenance;
use crate::scene;

/// Size of the picture that stands in for a window, pixels.
const PICTURE_SIZE: [u32; 2] = [1280, 800];

pub(crate) fn run(args: &ViewArgs) -> Result<(), Failure> {
    if !has_display() {
        return without_display(args);
    }
    let mut scene = terrain::compose(&args.scene)?;
    let source = Source::chosen(&args.scene, &scene);
    let map = source.load_to_fit(&args.scene.open.options())?.1;
    scene.lighting.clock.stand_on(map.geographic_bounds());
    terrain::place_camera(&args.scene, &mut scene, &map.field)?;
    // The window repeats on stderr what it warns of.
    let remarks = scene::remarks(&scene, map.field.box_size(scene.terrain.height_scale), map.field.metric_range());
    let path = match &source {
        Source::File { path, .. } => Some(std::path::absolute(path).unwrap_or_else(|_| path.clone())),
        Source::Recipe(_) | Source::BuiltIn => None,
    };
    // Bookmarks go by the whole path.
    scene.terrain.file.clone_from(&path);
    if path.is_some() {
        scene.terrain.recipe = None;
    }
    let options = ViewerOptions {
        provenance: Some(Provenance::of(&map, path)),
        more: args.more.clone(),
        import: args.scene.open.options(),
        title: map.title.unwrap_or_else(|| source.name()),
        warnings: map.warnings.into_iter().chain(remarks).collect(),
        map: Arc::new(map.field),
        scene,
        size: args.size,
        status: args.status.clone(),
        screenshots: args.screenshots.clone(),
        reset_settings: args.reset_settings,
    };
    match app::run(options) {
        Err(AppError::Window(reason)) => {
            log::info!("no window could be opened: {reason}");
            without_display(args)
        }
        other => Ok(other?),
    }
}

/// Draws what the window would open with.
fn without_display(args: &ViewArgs) -> Result<(), Failure> {
    if let [first, ..] = args.more.as_slice() {
        super::warn(&format!(
            "without a display only the first map is drawn, and {} and what follows are not",
            first.display()
        ));
    }
    let output = Output::prepare(&args.output)?;
    let mut scene = terrain::compose(&args.scene)?;
    let (gpu, map) = Source::chosen(&args.scene, &scene).load_for_gpu(&args.scene.open.options())?;
    scene.lighting.clock.stand_on(map.geographic_bounds());
    let size = args.size.unwrap_or(PICTURE_SIZE);
    terrain::check_size(size, gpu.capabilities.max_texture)?;
    terrain::place_camera(&args.scene, &mut scene, &map.field)?;
    terrain::warn_of(&scene, &map.field);
    render::picture(gpu, scene, map.field, size, &output)?;
    announce(output.path());
    Ok(())
}

fn announce(path: &Path) {
    eprintln!("relief: no display: rendered the start view to {}; open it, or run on a desktop", path.display());
}

/// Whether a window system may answer. Only X11 and Wayland are announced by the environment.
fn has_display() -> bool {
    if cfg!(any(target_os = "linux", target_os = "freebsd", target_os = "openbsd", target_os = "netbsd")) {
        ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"]
            .iter()
            .any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
    } else {
        true
    }
}
