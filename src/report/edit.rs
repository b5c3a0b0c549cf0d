//! After an edit: is the next frame that of a freshly built scene, and how long does it take?

use std::time::Instant;

use serde::Serialize;

use super::cones::{self, Search, Watcher};
use super::rounds::Times;
use super::studio::Studio;
use super::sweep::{Prepared, first_line};
use super::{EDITS_SHARE, Halt, Job, Monitor};
use crate::gpu::Target;
use crate::heightfield::Crater;
use crate::render::{RenderError, Renderer};
use crate::scene::{Scene, Technique};

/// A technique's first frames after craters, one after the other, against a scene that was built with them.
#[derive(Clone, Debug, Serialize)]
pub struct EditCost {
    /// The technique, with its default setting.
    pub technique: Technique,
    /// Craters that were dug: fewer where the frames after them took long.
    pub craters: u32,
    /// Wall time of a first frame after a crater: the edit and the search for cones on the CPU, the upload, the frame.
    pub first_frame: Times,
    /// Wall time of the frames between.
    pub ordinary_frame: Times,
    /// Median of the first frames over that of the ordinary ones.
    pub ratio: f64,
    /// Largest difference of distances in world units after the last crater; `None` where one is sky and the other not.
    pub distance_difference: Option<f64>,
    /// Pixels whose colours differ after the last crater.
    pub differing_pixels: u64,
}

/// Craters that are dug, one a frame, where the time suffices.
pub(super) const CRATERS: u32 = 5;
/// Frames between two of them.
const BETWEEN: usize = 2;

/// What is dug into, and who watches.
pub(super) struct Digging<'a> {
    /// Has the cones of the map without craters; those with craters are other ones.
    pub(super) studio: &'a Studio,
    pub(super) job: &'a Job,
    /// Seconds for each technique.
    pub(super) budget_s: f64,
    pub(super) monitor: &'a dyn Monitor,
}

/// Tells how far a search for cones after a crater is.
struct Finding<'a> {
    monitor: &'a dyn Monitor,
    technique: Technique,
    /// Share of the whole report that is behind.
    share: f64,
}

impl Watcher for Finding<'_> {
    fn tell(&self, share: f32) {
        let what = format!("after an edit: finding cones for {}, {:.0} %", self.technique.name(), share * 100.0);
        self.monitor.tell(&what, self.share);
    }

    fn stop(&self) -> bool {
        self.monitor.stop()
    }
}

impl Digging<'_> {
    /// Measures every technique that could be prepared, in the first view.
    pub(super) fn measure(
        &self,
        scene: &Scene,
        prepared: &[Prepared],
        costs: &mut Vec<EditCost>,
        left_out: &mut Vec<String>,
    ) -> Result<(), Halt> {
        for (index, &Prepared { technique, finding_s, .. }) in prepared.iter().enumerate() {
            let share = 1.0 - EDITS_SHARE + EDITS_SHARE * index as f64 / prepared.len() as f64;
            self.monitor.tell(&format!("after an edit: {}", technique.name()), share);
            if self.monitor.stop() {
                return Err(Halt::Asked);
            }
            // After a crater, and in the scene that is built with it.
            if 2.0 * finding_s > self.budget_s {
                left_out.push(format!(
                    "after an edit, `{}`: finding all cones anew takes about {finding_s:.0} s each time, and this part may \
                     take {:.0} s",
                    technique.name(),
                    self.budget_s
                ));
                continue;
            }
            let mut scene = Scene { camera: self.job.views.first().map(|(_, camera)| *camera), ..scene.clone() };
            scene.march.technique = technique;
            match self.cost(scene, &Finding { monitor: self.monitor, technique, share }) {
                Ok(cost) => costs.extend(cost),
                Err(Halt::Failed(error @ RenderError::Unsupported { .. })) => {
                    left_out.push(format!("after an edit, `{}`: {}", technique.name(), first_line(&error)));
                }
                Err(halt) => return Err(halt),
            }
        }
        Ok(())
    }

    /// Draws a frame, and finds the cones that it needs; milliseconds of both.
    fn frame(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        target: &Target,
        finding: &Finding<'_>,
    ) -> Result<f64, Halt> {
        let start = Instant::now();
        if let Some((ground, kinds)) = renderer.missing_cones(scene) {
            let field = ground.field();
            for kind in kinds {
                // The budget has been looked at: what is begun is not given up.
                match cones::find(&field, kind, f64::INFINITY, finding) {
                    Search::Found(map, _) => renderer.set_cones(ground.clone(), map),
                    Search::TooLong(_) | Search::Stopped => return Err(Halt::Asked),
                }
            }
        }
        renderer.draw(scene, target)?;
        renderer.wait_frame_time()?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    fn cost(&self, mut scene: Scene, finding: &Finding<'_>) -> Result<Option<EditCost>, Halt> {
        let (job, began) = (self.job, Instant::now());
        let extent = job.map.box_size(scene.terrain.height_scale);
        let target = Target::new(&self.studio.gpu, job.size);
        let mut edited = self.studio.fresh()?;
        self.frame(&mut edited, &scene, &target, finding)?;
        let (mut first, mut ordinary) = (Vec::new(), Vec::new());
        let mut craters = 0;
        for index in 0..CRATERS {
            // The next crater costs about what the last did, and so does the scene that is built with all of them.
            let next_s = first.last().map_or(0.0, |ms| 2e-3 * ms);
            if self.monitor.stop() {
                return Err(Halt::Asked);
            }
            if began.elapsed().as_secs_f64() + next_s > self.budget_s && craters > 0 {
                break;
            }
            for _ in 0..BETWEEN {
                ordinary.push(self.frame(&mut edited, &scene, &target, finding)?);
            }
            let along = 0.3 + 0.1 * f64::from(index);
            let (x, z) = (extent.x * along, extent.z * (0.35 + 0.3 * f64::from(index % 2)));
            scene.craters.list.push(Crater { x, z, radius: 0.03, depth: 0.3, rim: 0.08 });
            first.push(self.frame(&mut edited, &scene, &target, finding)?);
            craters += 1;
        }
        // What is compared is the frame after the last crater, before any other.
        let picture = target.read_color(&self.studio.gpu).map_err(RenderError::from)?;
        let distances = edited.probe(&scene, job.size)?.distance;
        let mut fresh = self.studio.fresh()?;
        self.frame(&mut fresh, &scene, &target, finding)?;
        let expected = target.read_color(&self.studio.gpu).map_err(RenderError::from)?;
        let truth = fresh.probe(&scene, job.size)?.distance;
        let difference = |(&a, &b): (&f32, &f32)| if a == b { 0.0 } else { f64::from(a - b).abs() };
        let largest = distances.iter().zip(&truth).map(difference).fold(0.0, f64::max);
        let differing = picture.pixels().zip(expected.pixels()).filter(|(a, b)| a != b).count();
        Ok(Times::of(&first).zip(Times::of(&ordinary)).map(|(first_frame, ordinary_frame)| EditCost {
            technique: scene.march.technique,
            craters,
            first_frame,
            ordinary_frame,
            ratio: first_frame.ms / ordinary_frame.ms,
            distance_difference: largest.is_finite().then_some(largest),
            differing_pixels: differing as u64,
        }))
    }
}
