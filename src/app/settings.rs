//! What the viewer itself remembers besides the scene: which parts of the interface show, and how frames are paced.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::actions::Action;
use super::files::FilesCommand;
use super::generating::{Draft, MakeCommand};
use super::keys::KeyMap;
use super::log_pane::LogPane;
use super::preferences::{Bookmarks, Mode, Motion, Theme};
use super::reading::Reading;
use crate::camera::NamedView;
use crate::camera_path::CameraPath;
use crate::heightfield::HeightField;
use crate::render::Ledger;
use crate::scene::Scene;

/// Settings that belong to the viewer and are not part of a picture.
#[derive(Clone, Debug)]
pub(crate) struct ViewSettings {
    /// The panel shows.
    pub(crate) panel: bool,
    /// The overlay shows.
    pub(crate) overlay: bool,
    /// The help shows.
    pub(crate) help: bool,
    /// Steps per ray are measured for the overlay.
    pub(crate) measure_steps: bool,
    /// The eye may go below the ground.
    pub(crate) allow_below_ground: bool,
    /// Frames wait for the screen.
    pub(crate) vsync: bool,
    /// Most frames per second, 0 for no limit.
    pub(crate) frame_limit: u32,
    /// What is being read off the land.
    pub(crate) reading: Reading,
    /// What stands in the panel's path fields.
    pub(crate) paths: PathFields,
    /// Dark or light.
    pub(crate) theme: Theme,
    /// Whether the eye glides.
    pub(crate) motion: Motion,
    /// Size of panel and text.
    pub(crate) zoom: f32,
    /// The words for who is here for the first time show.
    pub(crate) welcome: bool,
    /// The log, and whether it shows.
    pub(crate) log: LogPane,
    /// What drags and the wheel do.
    pub(crate) mode: Mode,
    /// Which key does what.
    pub(crate) keys: KeyMap,
    /// The action that waits for its new key.
    pub(crate) rebinding: Option<Action>,
    /// Why the last key that was chosen is not the action's.
    pub(crate) refused: Option<(Action, String)>,
    /// The views that 1 to 9 go to.
    pub(crate) bookmarks: Bookmarks,
    /// The camera path, and what is done with it.
    pub(crate) path: PathEditor,
    /// The recipe in the panel.
    pub(crate) generate: Draft,
    /// The point that was typed to be looked at; another one once the eye looks elsewhere.
    pub(crate) target: Option<DVec3>,
    /// The layer of clouds whose settings the panel shows.
    pub(crate) cloud_layer: usize,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            panel: true,
            overlay: false,
            help: false,
            measure_steps: false,
            allow_below_ground: false,
            vsync: true,
            frame_limit: 0,
            reading: Reading::default(),
            paths: PathFields::default(),
            theme: Theme::default(),
            motion: Motion::default(),
            zoom: 1.0,
            welcome: false,
            log: LogPane::default(),
            mode: Mode::default(),
            keys: KeyMap::default(),
            rebinding: None,
            refused: None,
            bookmarks: Bookmarks::default(),
            path: PathEditor::default(),
            generate: Draft::default(),
            target: None,
            cloud_layer: 0,
        }
    }
}

/// The camera path in the panel.
#[derive(Clone, Debug)]
pub(crate) struct PathEditor {
    pub(crate) path: CameraPath,
    /// Its file, as typed.
    pub(crate) file: String,
    /// The file that it was last written to or read from, which may be written again.
    pub(crate) saved: Option<PathBuf>,
    /// The animation's file or folder, as typed.
    pub(crate) output: String,
    /// The animation's pictures per second.
    pub(crate) per_second: u32,
    /// Their size in pixels.
    pub(crate) size: [u32; 2],
    /// It is being played.
    pub(crate) playing: bool,
    /// It is being written.
    pub(crate) writing: bool,
}

impl Default for PathEditor {
    fn default() -> Self {
        Self {
            path: CameraPath::default(),
            file: "relief-path.toml".into(),
            saved: None,
            output: "relief-path.png".into(),
            per_second: 30,
            size: [1280, 720],
            playing: false,
            writing: false,
        }
    }
}

impl PathEditor {
    /// Whether a file is the path's own, so that it may be written again.
    pub(crate) fn owns(&self, file: &Path) -> bool {
        self.saved.as_deref() == Some(file)
    }
}

/// What is done with the camera path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PathCommand {
    /// Record the eye.
    Add,
    /// Remove the last key frame.
    RemoveLast,
    /// Remove all.
    Clear,
    /// Play it, or stop.
    Play,
    /// Write it to the file that is typed.
    Save,
    /// Read it from there.
    Load,
    /// Write its pictures.
    Export,
    /// Stop that.
    CancelExport,
}

/// Text being typed in the panel; it counts once its button is pressed.
#[derive(Clone, Debug, Default)]
pub(crate) struct PathFields {
    /// The height map to open.
    pub(crate) terrain: String,
    /// The diffuse texture.
    pub(crate) diffuse: String,
    /// The placed picture.
    pub(crate) imagery: String,
    /// The coverage maps, with `;` between.
    pub(crate) coverage: String,
    /// The six faces of the sky.
    pub(crate) faces: [String; 6],
}

impl PathFields {
    /// The fields of a scene that was just loaded.
    pub(crate) fn of(scene: &Scene) -> Self {
        let text = |path: &Option<PathBuf>| path.as_ref().map(|path| path.display().to_string()).unwrap_or_default();
        let faces = scene.skybox.faces.clone().map(|faces| faces.map(|path| path.display().to_string()));
        let coverage = scene.materials.coverage.iter().map(|path| path.display().to_string());
        Self {
            terrain: text(&scene.terrain.file),
            diffuse: text(&scene.diffuse.file),
            imagery: text(&scene.land.imagery),
            coverage: coverage.collect::<Vec<_>>().join("; "),
            faces: faces.unwrap_or_default(),
        }
    }
}

/// What the panel and the keys ask of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    /// Open, switch or save maps.
    Files(FilesCommand),
    /// Make a landscape.
    Make(MakeCommand),
    /// Move the eye to a named view.
    View(NamedView),
    /// Take the last crater back.
    UndoCrater,
    /// Take all craters back.
    ClearCraters,
    /// Write the picture and its scene.
    Screenshot,
    /// Enter or leave full screen.
    FullScreen,
    /// Measure error and time of the techniques in this view.
    MeasureTradeoff,
    /// Forget what was measured.
    ForgetTradeoff,
    /// Go to a bookmark, 1 to 9.
    GoToBookmark(usize),
    /// Set a bookmark, 1 to 9.
    SetBookmark(usize),
    /// Something about the camera path.
    Path(PathCommand),
    /// Make heights so many times their true proportion.
    Exaggerate(f64),
    /// Start or end measuring.
    Measure(bool),
}

/// What the panel shows but cannot change.
#[derive(Clone, Debug)]
pub(crate) struct Facts {
    /// The terrain's name.
    pub(crate) title: String,
    /// Columns and rows of the map.
    pub(crate) samples: [u32; 2],
    /// What the lowest and the highest sample stand for.
    pub(crate) range: [f64; 2],
    /// Horizontal extent in metres, where it is known.
    pub(crate) extent_metres: Option<[f64; 2]>,
    /// The box as it is drawn, world units.
    pub(crate) extent: DVec3,
    /// Height of the box at the map's own proportion, world units.
    pub(crate) true_height_scale: f64,
    /// The map itself, without craters.
    pub(crate) map: Arc<HeightField>,
    /// The adapter can filter the map's heights.
    pub(crate) filterable_heights: bool,
    /// Largest side of a texture.
    pub(crate) max_texture: u32,
    /// The adapter's and the driver's name.
    pub(crate) adapter: (String, String),
    /// What the last frame cost.
    pub(crate) ledger: Ledger,
    /// What is to be said about images.
    pub(crate) images: ImageNotes,
}

/// What is to be said about the images of a scene, beside their paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ImageNotes {
    /// What is doubtful about the place of the picture on the ground.
    pub(crate) doubts: Vec<String>,
    /// The last image that could not be used, and why.
    pub(crate) refused: Option<(PathBuf, String)>,
}

impl ImageNotes {
    /// Why the image whose path is typed as `typed` could not be used.
    pub(crate) fn refusal(&self, typed: &str) -> Option<&str> {
        let (_, reason) = self.refused.as_ref().filter(|(path, _)| path == Path::new(typed.trim()))?;
        Some(reason)
    }

    /// A picture of `scene` was drawn: an image that it shows is not refused any more. Whether one was.
    pub(crate) fn were_shown(&mut self, scene: &Scene) -> bool {
        let shows = |path: &PathBuf| {
            scene.diffuse.file.as_ref() == Some(path)
                || scene.land.imagery.as_ref() == Some(path)
                || scene.materials.coverage.contains(path)
                || scene.skybox.faces.as_ref().is_some_and(|faces| faces.contains(path))
        };
        self.refused.take_if(|(path, _)| shows(path)).is_some()
    }
}

impl Facts {
    /// What is known of a map, for an adapter with the given capabilities.
    pub(crate) fn new(map: &Arc<HeightField>, title: String, gpu: &crate::gpu::Gpu) -> Self {
        let own = map.box_size(None);
        Self {
            title,
            samples: [map.width(), map.height()],
            range: map.range(),
            extent_metres: map.extent_metres(),
            extent: own,
            true_height_scale: own.y,
            map: Arc::clone(map),
            filterable_heights: gpu.capabilities.filters_heights(map.units().filter(|_| map.holes().is_none()), false),
            max_texture: gpu.capabilities.max_texture,
            adapter: gpu.adapter_name(),
            ledger: Ledger::default(),
            images: ImageNotes::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that was mended is not said to be broken.
    #[test]
    fn an_image_that_is_shown_is_refused_no_more() {
        let mut notes =
            ImageNotes { refused: Some(("photo.png".into(), "it is cut off".into())), ..Default::default() };
        let mut scene = Scene::default();
        assert!(!notes.were_shown(&scene));
        scene.diffuse.file = Some("other.png".into());
        assert!(!notes.were_shown(&scene) && notes.refusal(" photo.png") == Some("it is cut off"));
        let uses: [fn(&mut Scene); 4] = [
            |scene| scene.diffuse.file = Some("photo.png".into()),
            |scene| scene.land.imagery = Some("photo.png".into()),
            |scene| scene.materials.coverage = vec!["photo.png".into()],
            |scene| scene.skybox.faces = Some(std::array::from_fn(|_| "photo.png".into())),
        ];
        for uses in uses {
            let (mut notes, mut scene) = (notes.clone(), Scene::default());
            uses(&mut scene);
            assert!(notes.were_shown(&scene) && notes.refusal("photo.png").is_none() && !notes.were_shown(&scene));
        }
    }
}
