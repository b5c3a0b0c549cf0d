//! Stiff and extreme cases: where each technique breaks, and that the exact one does not.
//!
//! [`measure`] renders every case with every technique, compares it with the f64 reference, and
//! [judges](Judgement) the exact technique by the [bound] that is derived for it. [`tables`], [`sheet`] and
//! [`bound_plot`] put it into words and pictures.

pub mod bound;
pub mod bound_plot;
mod cases;
mod doors;
mod edits;
mod judge;
pub mod sheet;
mod study;
pub mod tables;
mod terrains;
mod views;

use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;

use self::cases::Case;
use self::judge::{Judge, Pixel};
use super::{Figures, Halt, Monitor, Setting, machine};
use crate::camera::Camera;
use crate::gpu::Gpu;
use crate::heightfield::reference::Surface;
use crate::heightfield::{EditedTerrain, HeightField};
use crate::render::{Probe, RenderError, Renderer};
use crate::scene::{Scene, Technique};

pub use edits::Check;
pub use judge::Judgement;
pub use study::Point;

/// What to measure.
#[derive(Clone, Debug)]
pub struct Job {
    /// Width and height of the pictures in pixels; some cases have their own.
    pub size: [u32; 2],
    /// Smaller maps, fewer views.
    pub quick: bool,
    /// Only the cases whose names contain one of these; empty: all, and the checks and the study of the bound.
    pub only: Vec<String>,
    /// Technique whose distances are judged as if they were the exact one's: [`Technique::MaxMipmap`], but for tests
    /// that a broken technique is found out.
    pub exact: Technique,
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct StressReport {
    /// Processor and its threads.
    pub machine: String,
    /// The adapter's name.
    pub adapter: String,
    /// The driver's name and version.
    pub driver: String,
    /// Width and height of the pictures in pixels, where a case has none of its own.
    pub size: [u32; 2],
    /// Smaller maps, fewer views.
    pub quick: bool,
    /// Why the measurement ended early; absent where all was measured.
    pub stopped: Option<String>,
    /// The cases.
    pub cases: Vec<CaseReport>,
    /// What must hold without a picture.
    pub checks: Vec<Check>,
    /// The bound over map sizes and eye distances.
    pub bound: Vec<Point>,
    /// What was left out, and why.
    pub left_out: Vec<String>,
    /// A picture of each case, in their order.
    #[serde(skip)]
    pub strips: Vec<sheet::Strip>,
}

/// A case and what every technique made of it.
#[derive(Clone, Debug, Serialize)]
pub struct CaseReport {
    /// The case's name.
    pub name: String,
    /// The view alone.
    pub view: String,
    /// Columns and rows of the map.
    pub map_samples: [u32; 2],
    /// Size of the terrain's box in world units.
    pub map_box: [f64; 3],
    /// Where it is seen from.
    pub camera: Camera,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Side of a cell in world units, the shorter one: the unit of distance errors.
    pub cell: f64,
    /// Every so many pixels one was compared.
    pub stride: usize,
    /// A row per technique.
    pub rows: Vec<StressRow>,
    /// The exact technique against the bound.
    pub judgement: Judgement,
    /// Pixels that the tangency band may excuse.
    pub excusable: u64,
    /// How the exact technique broke its promise; empty where it kept it.
    pub broken: Vec<String>,
}

/// One technique in one case.
#[derive(Clone, Debug, Serialize)]
pub struct StressRow {
    /// Technique and setting.
    #[serde(flatten)]
    pub setting: Setting,
    /// How wrong it is.
    #[serde(flatten)]
    pub figures: Figures,
    /// Steps per ray that was cast.
    pub steps_mean: f64,
    /// Most steps of a ray.
    pub steps_max: u32,
    /// Rays that the step cap ended.
    pub cap_hits: u32,
}

impl StressReport {
    /// Whether the exact technique kept its promise in all that was measured, and every check held.
    pub fn holds(&self) -> bool {
        self.cases.iter().all(|case| case.broken.is_empty())
            && self.checks.iter().all(|check| check.failure.is_none())
            && self.bound.iter().all(|point| point.broken.is_empty())
    }

    /// A line for each promise that was broken.
    pub fn failures(&self) -> Vec<String> {
        let cases = self.cases.iter().flat_map(|case| case.broken.iter().map(|why| format!("{}: {why}", case.name)));
        let points =
            self.bound.iter().flat_map(|point| point.broken.iter().map(|why| format!("{}: {why}", point.name())));
        let checks =
            self.checks.iter().filter_map(|check| Some(format!("{}: {}", check.name, check.failure.as_ref()?)));
        cases.chain(points).chain(checks).collect()
    }
}

/// Names of the cases that `job` asks for.
pub fn names(job: &Job) -> Vec<String> {
    chosen(job).into_iter().map(|case| case.name).collect()
}

fn chosen(job: &Job) -> Vec<Case> {
    let mut cases = cases::all(job.quick);
    cases.retain(|case| job.only.is_empty() || job.only.iter().any(|part| case.name.contains(part)));
    cases
}

/// Shares of the whole work that the parts take, for the progress bar. The cases have the rest.
const CHECKS_SHARE: f64 = 0.03;
const STUDY_SHARE: [f64; 2] = [0.4, 0.1];

/// Measures everything in `job`. What was measured before the monitor asks to stop, or before the GPU fails, is in the
/// report, which then says so. A case that fails on its own is a broken promise, and the next one follows.
///
/// # Errors
/// [`RenderError`] where not even the first picture could be drawn.
pub fn measure(gpu: &Arc<Gpu>, job: &Job, monitor: &dyn Monitor) -> Result<StressReport, RenderError> {
    let (adapter, driver) = gpu.adapter_name();
    let mut report = StressReport {
        machine: machine(),
        adapter,
        driver,
        size: job.size,
        quick: job.quick,
        stopped: None,
        cases: Vec::new(),
        checks: Vec::new(),
        bound: Vec::new(),
        left_out: Vec::new(),
        strips: Vec::new(),
    };
    let mut bench = Bench { gpu: Arc::clone(gpu), renderer: Renderer::new(Arc::clone(gpu))?, job: job.clone() };
    match report.fill(&mut bench, monitor) {
        Err(Halt::Failed(error)) if report.cases.is_empty() => return Err(error),
        Err(Halt::Failed(error)) => report.stopped = Some(error.to_string()),
        Err(Halt::Asked) => report.stopped = Some(String::from("it was asked to stop")),
        Ok(()) => {}
    }
    Ok(report)
}

impl StressReport {
    fn fill(&mut self, bench: &mut Bench, monitor: &dyn Monitor) -> Result<(), Halt> {
        let whole = bench.job.only.is_empty();
        let cases = chosen(&bench.job);
        let study = if whole { STUDY_SHARE[usize::from(bench.job.quick)] } else { 0.0 };
        let share = (1.0 - study - CHECKS_SHARE) / cases.len().max(1) as f64;
        let mut map: Option<(Case, Arc<HeightField>)> = None;
        for (index, case) in cases.iter().enumerate() {
            monitor.tell(&case.name, share * index as f64);
            if monitor.stop() {
                return Err(Halt::Asked);
            }
            let known = map.as_ref().filter(|(last, _)| (last.terrain, last.side) == (case.terrain, case.side));
            let field = match known {
                Some((_, field)) => Arc::clone(field),
                None => match case.terrain.map(case.side) {
                    Ok(field) => field,
                    Err(error) => {
                        self.left_out.push(format!("{}: {}", case.name, one_line(&error)));
                        continue;
                    }
                },
            };
            if known.is_none() {
                bench.renderer.set_terrain(Arc::clone(&field))?;
                map = Some((case.clone(), Arc::clone(&field)));
            }
            if let Some(limit) =
                case.size.filter(|size| size.iter().any(|&side| side > bench.gpu.capabilities.max_texture))
            {
                self.left_out.push(format!("{}: this adapter has no pictures of {}×{}", case.name, limit[0], limit[1]));
                continue;
            }
            let (measured, strip) = bench.case(case, &field, &mut self.left_out)?;
            self.cases.push(measured);
            self.strips.push(strip);
        }
        if !whole {
            return Ok(());
        }
        monitor.tell("edits and bad numbers", 1.0 - study - CHECKS_SHARE);
        self.checks.extend(doors::checks());
        match edits::checks(bench.job.quick) {
            Ok(checks) => self.checks.extend(checks),
            Err(error) => self.left_out.push(format!("edits: {}", one_line(&error))),
        }
        study::measure(bench, &mut self.bound, &mut self.left_out, &|what, done| {
            monitor.tell(what, 1.0 - study + study * done);
            monitor.stop()
        })
    }
}

/// What the pictures are drawn with.
struct Bench {
    gpu: Arc<Gpu>,
    renderer: Renderer,
    job: Job,
}

/// What the exact technique is measured with, and what the others are: each with the settings of the 2009 study.
fn setting(technique: Technique) -> Setting {
    if !technique.counts_samples() {
        return Setting { technique, samples: None, by_angle: None, halvings: None };
    }
    Setting { technique, halvings: technique.halves().then_some(8), ..Setting::BASE }
}

/// The map of a case, and where it is seen from.
struct Stage<'a> {
    field: &'a HeightField,
    extent: DVec3,
    camera: Camera,
    size: [u32; 2],
    cell: f64,
}

impl Bench {
    fn case(
        &mut self,
        case: &Case,
        field: &Arc<HeightField>,
        left_out: &mut Vec<String>,
    ) -> Result<(CaseReport, sheet::Strip), Halt> {
        let size = case.size.unwrap_or(self.job.size);
        let extent = field.box_size(case.height_scale);
        let camera = case.view.camera(field, extent);
        let mut scene = Scene { camera: Some(camera), ..Scene::default() };
        scene.terrain.height_scale = case.height_scale;
        scene.craters.list.clone_from(&case.craters);
        let mut edited = EditedTerrain::new(Arc::clone(field));
        edited.set_craters(&case.craters);
        let cells = field.cells();
        let cell = (extent.x / f64::from(cells[0])).min(extent.z / f64::from(cells[1]));
        let stage = Stage { field: edited.field(), extent, camera, size, cell };
        let reference = stage.reference(case.stride);
        let mut report = CaseReport {
            name: case.name.clone(),
            view: case.view.name(),
            map_samples: [field.width(), field.height()],
            map_box: extent.to_array(),
            camera,
            size,
            cell,
            stride: case.stride,
            rows: Vec::new(),
            judgement: Judgement::default(),
            excusable: case.excusable(size),
            broken: Vec::new(),
        };
        let mut strip = sheet::Strip::new(&case.name, &stage, &reference);
        for technique in Technique::ALL {
            let judged = technique == self.job.exact;
            // Only where the exact one is judged as itself the others are of interest.
            if !(judged || case.all_techniques && self.job.exact == Technique::MaxMipmap) {
                continue;
            }
            let setting = setting(technique);
            setting.apply(&mut scene.march);
            let probe = match self.renderer.probe(&scene, size) {
                Ok(probe) => probe,
                Err(error @ RenderError::DeviceLost(_)) => return Err(error.into()),
                Err(error @ RenderError::Unsupported { .. }) => {
                    let note = format!("`{}`: {}", technique.name(), one_line(&error));
                    if !left_out.contains(&note) {
                        left_out.push(note);
                    }
                    continue;
                }
                Err(error) => {
                    report.broken.push(format!("`{}`: {}", technique.name(), one_line(&error)));
                    continue;
                }
            };
            let picture: Vec<f32> = probe.distance.iter().copied().step_by(case.stride).collect();
            if judged {
                report.judgement = stage.judge(&reference, &probe, case.stride);
                report.broken.extend(complaints(&report.judgement, probe.cap_hits, report.excusable));
            }
            strip.add(technique, &stage, &reference, &picture);
            let (steps_mean, steps_max) = probe.step_stats();
            let of = if case.stride == 1 { size } else { [picture.len() as u32, 1] };
            let figures = Figures::of(&reference, &picture, of, cell);
            report.rows.push(StressRow { setting, figures, steps_mean, steps_max, cap_hits: probe.cap_hits });
        }
        Ok((report, strip))
    }
}

impl Stage<'_> {
    /// Distances of the reference for every `stride`-th pixel.
    fn reference(&self, stride: usize) -> Vec<f64> {
        use rayon::prelude::*;
        let surface = Surface::new(self.field, self.extent);
        if stride == 1 {
            return surface.distances(&self.camera, self.size, &|_| {});
        }
        let [width, height] = self.size.map(|side| side as usize);
        let distance = |index: usize| {
            let at = |pixel: usize| pixel as f64 + 0.5;
            let ray = self.camera.ray(at(index % width), at(index / width), self.size);
            surface.intersect(&ray).map_or(f64::INFINITY, |hit| hit.depth * ray.direction.length())
        };
        (0..width * height).into_par_iter().step_by(stride).map(distance).collect()
    }

    /// Judges every `stride`-th pixel of a probe.
    fn judge(&self, reference: &[f64], probe: &Probe, stride: usize) -> Judgement {
        let found = probe.distance.iter().zip(&probe.beyond_start).step_by(stride);
        let pixel = |(at, (&expected, (&distance, &beyond_start)))| Pixel {
            index: at * stride,
            expected,
            distance,
            beyond_start,
            start: probe.start(at * stride),
        };
        let pixels: Vec<_> = reference.iter().zip(found).enumerate().map(pixel).collect();
        let &Self { field, extent, ref camera, size, cell } = self;
        Judge { field, extent, camera, size, cell, anchors: &probe.anchors }.judge(&pixels)
    }
}

/// Judges a picture of the exact technique by the [bound]: the `probe` of `field` in a box of the size `extent`, seen by
/// `camera`.
pub fn judge(field: &HeightField, extent: DVec3, camera: &Camera, probe: &Probe) -> Judgement {
    let cells = field.cells();
    let cell = (extent.x / f64::from(cells[0])).min(extent.z / f64::from(cells[1]));
    let stage = Stage { field, extent, camera: *camera, size: probe.size, cell };
    stage.judge(&stage.reference(1), probe, 1)
}

/// How a judgement breaks the promise.
fn complaints(judgement: &Judgement, cap_hits: u32, excusable: u64) -> Vec<String> {
    let Judgement { missed, invented, astray, tangent, nan, ratio, .. } = *judgement;
    let mut broken = Vec::new();
    let mut count = |count: u64, what: &str| {
        if count > 0 {
            broken.push(format!("{count} {} {what}", if count == 1 { "pixel" } else { "pixels" }));
        }
    };
    count(missed, "missed");
    count(invented, "invented");
    count(astray, &format!("farther off than the bound (at most {ratio:.3} times)"));
    count(nan, "without a number");
    count(u64::from(cap_hits), "cut off by the step cap");
    if tangent > excusable {
        count(tangent, &format!("in the tangency band, which may excuse {excusable}"));
    }
    broken
}

/// An error's lines as one.
fn one_line(error: &dyn std::error::Error) -> String {
    error.to_string().lines().map(str::trim).collect::<Vec<_>>().join("; ")
}
