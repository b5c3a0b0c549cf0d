//! Error against run time: how wrong each technique's picture is, and what it costs, on this map, view and adapter.
//!
//! [`measure`] fills a [`Report`]; [`tables`] and [`plot`] put it into words and pictures. Errors are the same to the
//! digit whenever they are measured with the same map, views, size and adapter; times are not. [`stress`] looks for where
//! techniques break.

mod changes;
pub mod comparison;
mod cones;
mod edit;
mod features;
pub mod figures;
pub mod growth;
pub mod plot;
mod rounds;
mod settings;
pub mod stress;
mod studio;
mod sweep;
pub mod tables;

use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

pub use edit::EditCost;
pub use features::{Feature, FeatureCost};
pub use figures::Figures;
pub use rounds::Times;
pub use settings::Setting;
pub use sweep::{Row, ViewReport};

use crate::camera::Camera;
use crate::gpu::Gpu;
use crate::heightfield::HeightField;
use crate::render::RenderError;
use crate::scene::{CraterMode, DebugSettings, Scene};

/// What to measure.
#[derive(Clone, Debug)]
pub struct Job {
    /// What to call the map.
    pub map_name: String,
    /// The map, with its craters if it has any.
    pub map: Arc<HeightField>,
    /// Proportion, light and colours; its camera, technique, craters and debug views are not used.
    pub scene: Scene,
    /// Where to look from, and what to call it.
    pub views: Vec<(String, Camera)>,
    /// Width and height of the pictures in pixels.
    pub size: [u32; 2],
    /// Fewer settings and rounds.
    pub quick: bool,
}

/// Who watches: is told what is being done, and may ask to stop.
pub trait Monitor: Sync {
    /// `what` is being done; `share` of the whole is behind, 0..1.
    fn tell(&self, what: &str, share: f64);
    /// Whether to stop and keep what there is.
    fn stop(&self) -> bool;
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Processor and its threads.
    pub machine: String,
    /// The adapter's name.
    pub adapter: String,
    /// The driver's name and version.
    pub driver: String,
    /// Frame times come from the GPU's clock; otherwise from the wall's.
    pub timestamps: bool,
    /// What the map is called.
    pub map: String,
    /// Columns and rows of the map.
    pub map_samples: [u32; 2],
    /// Size of the terrain's box in world units.
    pub map_box: [f64; 3],
    /// Side of a cell in world units: the unit of distance errors. The shorter where they differ.
    pub cell: f64,
    /// Width and height of the pictures in pixels.
    pub size: [u32; 2],
    /// Few settings and rounds.
    pub quick: bool,
    /// Why the measurement ended early; absent where all was measured.
    pub stopped: Option<String>,
    /// A table per view.
    pub views: Vec<ViewReport>,
    /// The study's Table 1, remade.
    pub features: Vec<Feature>,
    /// The same over a frame of the exact technique, less what only concerns the study's.
    pub exact_features: Vec<Feature>,
    /// What an edit costs and whether it is exact.
    pub edits: Vec<EditCost>,
    /// What was left out, and why.
    pub left_out: Vec<String>,
}

/// Why measuring ends before its end.
#[derive(Debug)]
enum Halt {
    /// The monitor asked for it.
    Asked,
    /// The GPU failed.
    Failed(RenderError),
}

impl From<RenderError> for Halt {
    fn from(error: RenderError) -> Self {
        Self::Failed(error)
    }
}

/// Shares of the whole work that the parts take, for the progress bar. The views have the rest.
const PREPARATION_SHARE: f64 = 0.05;
const FEATURES_SHARE: f64 = 0.35;
const EDITS_SHARE: f64 = 0.05;

/// Seconds that the parts may take, full and quick, which with loading the map and drawing the plots makes ten minutes and
/// one. The views share theirs; what preparations take is taken from them, down to [`LEAST_VIEWS_SECONDS`].
const VIEWS_SECONDS: [f64; 2] = [300.0, 22.0];
const LEAST_VIEWS_SECONDS: [f64; 2] = [250.0, 18.0];
/// For each of the two base frames.
const FEATURES_SECONDS: [f64; 2] = [100.0, 6.0];
/// Seconds that a technique may take after edits.
const EDIT_SECONDS: [f64; 2] = [25.0, 3.0];

/// Measures everything in `job`. What was measured before the monitor asks to stop, or before the GPU fails, is in the
/// report, which then says so.
///
/// # Errors
/// [`RenderError`] where not even the first picture could be drawn.
pub fn measure(gpu: &Arc<Gpu>, job: &Job, monitor: &dyn Monitor) -> Result<Report, RenderError> {
    let mut report = Report::begin(gpu, job);
    let halt = report.fill(gpu, job, monitor).err();
    let nothing = report.views.iter().all(|view| view.rows.is_empty());
    match halt {
        Some(Halt::Failed(error)) if nothing => return Err(error),
        Some(Halt::Failed(error)) => report.stopped = Some(error.to_string()),
        Some(Halt::Asked) => report.stopped = Some(String::from("it was asked to stop (Ctrl-C or SIGTERM)")),
        None => {}
    }
    report.views.retain(|view| !view.rows.is_empty());
    Ok(report)
}

impl Report {
    fn begin(gpu: &Gpu, job: &Job) -> Self {
        let (adapter, driver) = gpu.adapter_name();
        let extent = job.map.box_size(job.scene.terrain.height_scale);
        let cells = job.map.cells();
        Self {
            machine: machine(),
            adapter,
            driver,
            timestamps: gpu.capabilities.timestamps,
            map: job.map_name.clone(),
            map_samples: [job.map.width(), job.map.height()],
            map_box: extent.to_array(),
            cell: (extent.x / f64::from(cells[0])).min(extent.z / f64::from(cells[1])),
            size: job.size,
            quick: job.quick,
            stopped: None,
            views: Vec::new(),
            features: Vec::new(),
            exact_features: Vec::new(),
            edits: Vec::new(),
            left_out: Vec::new(),
        }
    }

    fn fill(&mut self, gpu: &Arc<Gpu>, job: &Job, monitor: &dyn Monitor) -> Result<(), Halt> {
        let scene = neutral(&job.scene);
        let pace = usize::from(job.quick);
        let mut studio = studio::Studio::new(gpu, &job.map, job.size, &scene);
        let began = Instant::now();
        let prepared = sweep::preparations(&mut studio, job, &scene, monitor, &mut self.left_out)?;
        let views = job.views.len().max(1) as f64;
        monitor.tell("painting the ground", PREPARATION_SHARE);
        studio.terrain();
        let views_s = (VIEWS_SECONDS[pace] - began.elapsed().as_secs_f64()).max(LEAST_VIEWS_SECONDS[pace]);
        let share = (1.0 - PREPARATION_SHARE - FEATURES_SHARE - EDITS_SHARE) / views;
        for (index, (name, camera)) in job.views.iter().enumerate() {
            let begin = PREPARATION_SHARE + share * index as f64;
            self.views.push(ViewReport { name: name.clone(), camera: *camera, rows: Vec::new() });
            let view = sweep::Sweep {
                job,
                scene: Scene { camera: Some(*camera), ..scene.clone() },
                camera: *camera,
                cell: self.cell,
                prepared: &prepared,
                budget_s: views_s / views,
                tell: &|what, done| monitor.tell(&format!("{name}: {what}"), begin + share * done),
                monitor,
            };
            let Some(report) = self.views.last_mut() else { continue };
            let measured = view.run(&mut studio, report, &mut self.left_out);
            report.rate();
            measured?;
        }
        let begin = 1.0 - FEATURES_SHARE - EDITS_SHARE;
        self.left_out.push(String::from(
            "Table 1, depth output: rays write their own depth, or nothing could be hidden by hills; it cannot be switched off",
        ));
        let able: Vec<_> = prepared.iter().map(|known| known.technique).collect();
        let pictures = changes::Pictures::write(&job.map, &mut self.left_out);
        let bases = [(changes::Base::Study, &mut self.features), (changes::Base::Exact, &mut self.exact_features)];
        for (half, (base, features)) in [0.0, 0.5].into_iter().zip(bases) {
            let budget_s = FEATURES_SECONDS[pace] / views;
            let wanted = features::Features { job, scene: &scene, base, able: &able, pictures: &pictures, budget_s };
            wanted.measure(&mut studio, features, &mut self.left_out, &|done| {
                monitor.tell("the cost of each feature", begin + FEATURES_SHARE * (half + 0.5 * done));
                monitor.stop()
            })?;
            // The next frames are of other techniques: their renderers need the memory.
            studio.clear();
        }
        let digging = edit::Digging { studio: &studio, job, budget_s: EDIT_SECONDS[pace], monitor };
        digging.measure(&scene, &prepared, &mut self.edits, &mut self.left_out)
    }
}

/// `scene` without what would come between a ray and the ground or stand for it.
fn neutral(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera = None;
    scene.occluder.enabled = false;
    scene.debug = DebugSettings::default();
    scene.craters.list.clear();
    scene.craters.mode = CraterMode::Baked;
    scene.march = crate::scene::MarchSettings::default();
    scene
}

/// The processor's name and its threads.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let named = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        line.split_once(':').map(|(_, name)| name.trim().to_owned())
    });
    let name = named.unwrap_or_else(|| format!("{} ({})", std::env::consts::ARCH, std::env::consts::OS));
    format!("{name}, {threads} {}", if threads == 1 { "thread" } else { "threads" })
}
