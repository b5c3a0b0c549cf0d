//! What the viewer itself remembers besides the scene: which parts of the interface show, and how frames are paced.

use std::path::PathBuf;
use std::sync::Arc;

use crate::camera::NamedView;
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
    /// What stands in the panel's path fields.
    pub(crate) paths: PathFields,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            panel: true,
            overlay: true,
            help: false,
            measure_steps: false,
            allow_below_ground: false,
            vsync: true,
            frame_limit: 0,
            paths: PathFields::default(),
        }
    }
}

/// Text being typed in the panel; it counts once its button is pressed.
#[derive(Clone, Debug, Default)]
pub(crate) struct PathFields {
    /// The height map to open.
    pub(crate) terrain: String,
    /// The diffuse texture.
    pub(crate) diffuse: String,
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
            coverage: coverage.collect::<Vec<_>>().join("; "),
            faces: faces.unwrap_or_default(),
        }
    }
}

/// What the panel and the keys ask of the viewer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    /// Open this height map.
    Open(PathBuf),
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
            true_height_scale: own.y,
            map: Arc::clone(map),
            filterable_heights: gpu.capabilities.filters_heights(map.units().filter(|_| map.holes().is_none()), false),
            max_texture: gpu.capabilities.max_texture,
            adapter: gpu.adapter_name(),
            ledger: Ledger::default(),
        }
    }
}
