//! One view: every setting against the reference, and its time.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::cones::{self, Search, Watcher};
use super::figures::{Figures, flip, nearest_rank};
use super::rounds::{FEWEST, Times, has_turn, plan};
use super::settings::Setting;
use super::studio::Studio;
use super::{Halt, Job, Monitor};
use crate::camera::{Camera, NamedView};
use crate::gpu::Target;
use crate::heightfield::reference::Surface;
use crate::render::{Probe, RenderError, Renderer};
use crate::scene::{Scene, Technique};

/// Frames of each setting in the full and in the quick report, where the time suffices.
pub(super) const ROUNDS: [usize; 2] = [20, 5];

/// One setting in one view.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Technique and setting.
    #[serde(flatten)]
    pub setting: Setting,
    /// How wrong it is.
    #[serde(flatten)]
    pub figures: Figures,
    /// Mean FLIP of its picture against the same shading fed with the reference's distances; absent where that could
    /// not be drawn.
    pub flip: Option<f64>,
    /// What it costs; absent where measuring ended before.
    pub times: Option<Times>,
    /// Its median over that of [`Setting::BASE`].
    pub ratio: Option<f64>,
    /// Steps per ray that was cast.
    pub steps_mean: f64,
    /// Most steps of a ray.
    pub steps_max: u32,
    /// Rays that the step cap ended.
    pub cap_hits: u32,
    /// From a new map to its first frame on the GPU, wall time in milliseconds.
    pub prepare_ms: f64,
    /// Textures that the technique reads or writes besides picture and depth: heights, pyramid, cones, beams.
    pub bytes: u64,
    /// No other setting of the view is faster and has no larger p99, nor as fast and a smaller one.
    pub on_p99_front: bool,
    /// The same with wrong pixels instead of p99.
    pub on_wrong_front: bool,
}

/// The table of a view.
#[derive(Clone, Debug, Serialize)]
pub struct ViewReport {
    /// What the view is called.
    pub name: String,
    /// Where it is seen from.
    pub camera: Camera,
    /// The settings.
    pub rows: Vec<Row>,
}

impl ViewReport {
    /// Computes ratios and fronts from the times.
    pub(super) fn rate(&mut self) {
        let base = self.rows.iter().find(|row| row.setting == Setting::BASE).and_then(|row| row.times);
        for row in &mut self.rows {
            row.ratio = row.times.zip(base).map(|(times, base)| times.ms / base.ms);
        }
        let points = |error: fn(&Row) -> f64| -> Vec<_> {
            self.rows.iter().map(|row| row.times.map(|times| [times.ms, error(row)])).collect()
        };
        let (p99, wrong) = (front(&points(|row| row.figures.p99)), front(&points(|row| row.figures.wrong)));
        for ((row, p99), wrong) in self.rows.iter_mut().zip(p99).zip(wrong) {
            (row.on_p99_front, row.on_wrong_front) = (p99, wrong);
        }
    }
}

/// Which points are on the Pareto front: no other is at most as large in both coordinates and smaller in one. A point
/// that is missing is not.
pub(super) fn front(points: &[Option<[f64; 2]>]) -> Vec<bool> {
    let beats = |[a, b]: [f64; 2], [x, y]: [f64; 2]| a <= x && b <= y && (a < x || b < y);
    points
        .iter()
        .map(|point| point.is_some_and(|point| !points.iter().flatten().any(|&other| beats(other, point))))
        .collect()
}

/// What a technique needs before its first frame.
///
/// The wall time of finding its cones, where it steps along any, and that from handing a renderer a new map, with these
/// cones, to the end of its first frame: the pyramid is built, everything is uploaded. Cones are found once for the whole
/// report; the rest is the median of up to three, or the only one where it takes longer than [`SLOW_S`]. The frame has
/// one pixel, and no light, colours or sky, which would need preparation of their own; but for slow ones the renderer has
/// drawn the same with the technique before, so no shader is compiled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepared {
    pub(super) technique: Technique,
    pub(super) ms: f64,
    /// Seconds of it that the cones took; 0 where it needs none.
    pub(super) finding_s: f64,
}

/// A preparation that takes longer, in seconds, is not done twice: compiling, some tenths of a second, hides in it.
const SLOW_S: f64 = 4.0;

/// Seconds that finding the cones of a technique may take, full and quick. The longer one is what a person would wait for
/// once; both techniques together then leave most of ten minutes, and of one, to the views.
const FINDING_SECONDS: [f64; 2] = [60.0, 6.0];

/// Tells how far the cones of a technique are.
struct Finding<'a> {
    monitor: &'a dyn Monitor,
    technique: Technique,
    begin: f64,
    share: f64,
}

impl Watcher for Finding<'_> {
    fn tell(&self, share: f32) {
        let what = format!("preparing {}: finding cones, {:.0} %", self.technique.name(), share * 100.0);
        self.monitor.tell(&what, self.begin + self.share * f64::from(share));
    }

    fn stop(&self) -> bool {
        self.monitor.stop()
    }
}

/// Measures the preparation of every technique. One that takes too long is left out of the report.
pub(super) fn preparations(
    studio: &mut Studio,
    job: &Job,
    scene: &Scene,
    monitor: &dyn Monitor,
    left_out: &mut Vec<String>,
) -> Result<Vec<Prepared>, Halt> {
    let mut bare = scene.clone();
    (bare.lighting.enabled, bare.diffuse.enabled, bare.skybox.enabled) = (false, false, false);
    bare.camera = Some(NamedView::Down.camera(&job.map, job.map.box_size(scene.terrain.height_scale)));
    let share = super::PREPARATION_SHARE / Technique::ALL.len() as f64;
    let mut prepared = Vec::new();
    for (index, technique) in Technique::ALL.into_iter().enumerate() {
        let begin = share * index as f64;
        monitor.tell(&format!("preparing {}", technique.name()), begin);
        let mut finding_s = 0.0;
        if let Some(kind) = technique.cones() {
            let budget_s = FINDING_SECONDS[usize::from(job.quick)];
            match cones::find(&job.map, kind, budget_s, &Finding { monitor, technique, begin, share }) {
                Search::Found(map, seconds) => {
                    studio.keep(map);
                    finding_s = seconds;
                }
                Search::TooLong(seconds) => {
                    left_out.push(format!(
                        "`{}`: finding its cones would take about {seconds:.0} s on this map and machine, and a technique \
                         may be prepared for {budget_s:.0} s",
                        technique.name()
                    ));
                    continue;
                }
                Search::Stopped => return Err(Halt::Asked),
            }
        }
        bare.march.technique = technique;
        match first_frame_ms(studio, &bare, monitor)? {
            Ok(ms) => prepared.push(Prepared { technique, ms: ms + finding_s * 1e3, finding_s }),
            Err(error) => left_out.push(format!("`{}`: {}", technique.name(), first_line(&error))),
        }
    }
    Ok(prepared)
}

/// Milliseconds from a new map to the end of the first frame of `scene`; or why this adapter cannot draw it.
fn first_frame_ms(studio: &Studio, scene: &Scene, monitor: &dyn Monitor) -> Result<Result<f64, RenderError>, Halt> {
    let target = Target::new(&studio.gpu, [1, 1]);
    let mut renderer = Renderer::new(Arc::clone(&studio.gpu))?;
    let mut times: Vec<f64> = Vec::new();
    let began = Instant::now();
    // The first is the warm-up.
    while times.len() < 2 || (times.len() < 4 && began.elapsed().as_secs_f64() < 2.0) {
        if monitor.stop() {
            return Err(Halt::Asked);
        }
        let start = Instant::now();
        renderer.set_terrain(Arc::clone(&studio.map))?;
        studio.hand_over_cones(&mut renderer);
        match renderer.draw(scene, &target).and_then(|()| renderer.wait_frame_time()) {
            Ok(_) => times.push(start.elapsed().as_secs_f64() * 1e3),
            Err(error @ RenderError::Unsupported { .. }) => return Ok(Err(error)),
            Err(error) => return Err(error.into()),
        }
        if let [only] = times[..]
            && only > SLOW_S * 1e3
        {
            return Ok(Ok(only));
        }
    }
    let mut sorted = times.split_off(1);
    sorted.sort_by(f64::total_cmp);
    Ok(Ok(nearest_rank(&sorted, 50).unwrap_or_default()))
}

pub(super) fn first_line(error: &RenderError) -> String {
    error.to_string().lines().next().unwrap_or_default().to_owned()
}

/// What to measure in one view, and with what.
pub(super) struct Sweep<'a> {
    pub(super) job: &'a Job,
    pub(super) scene: Scene,
    pub(super) camera: Camera,
    pub(super) cell: f64,
    pub(super) prepared: &'a [Prepared],
    pub(super) budget_s: f64,
    pub(super) tell: &'a (dyn Fn(&str, f64) + Sync),
    pub(super) monitor: &'a dyn Monitor,
}

/// A setting's distances and picture, before they are compared.
struct Shot {
    setting: Setting,
    probe: Probe,
    picture: image::RgbImage,
    frame_ms: f64,
    bytes: u64,
}

/// Settings are only left out when a view would take this many times its budget: before, they get fewer rounds.
const PATIENCE: f64 = 1.4;

/// Shares of a view's work.
const REFERENCE: f64 = 0.03;
const SHOTS: f64 = 0.25;

impl Sweep<'_> {
    /// Fills `report`; what is there stays when measuring ends early.
    pub(super) fn run(
        &self,
        studio: &mut Studio,
        report: &mut ViewReport,
        left_out: &mut Vec<String>,
    ) -> Result<(), Halt> {
        let began = Instant::now();
        (self.tell)("the reference", 0.0);
        let surface = Surface::new(&self.job.map, self.job.map.box_size(self.scene.terrain.height_scale));
        let reference = surface.distances(&self.camera, self.job.size, &|share| {
            (self.tell)("the reference", REFERENCE * f64::from(share));
        });
        let ideal = self.ideal_picture(studio, &reference, left_out)?;
        let (shots, halt) = self.shots(studio, began, &report.name, left_out);
        (self.tell)("comparing with the reference", REFERENCE + SHOTS);
        report.rows = shots.par_iter().map(|shot| self.row(shot, &reference, ideal.as_ref())).collect();
        halt.map_or(Ok(()), Err)?;
        let frame_ms: Vec<f64> = shots.iter().map(|shot| shot.frame_ms).collect();
        drop(shots);
        self.times(studio, report, &frame_ms, self.budget_s - began.elapsed().as_secs_f64())
    }

    fn scene(&self, setting: &Setting) -> Scene {
        let mut scene = self.scene.clone();
        setting.apply(&mut scene.march);
        scene
    }

    /// The picture that the reference's distances give.
    fn ideal_picture(
        &self,
        studio: &mut Studio,
        reference: &[f64],
        left_out: &mut Vec<String>,
    ) -> Result<Option<image::RgbImage>, Halt> {
        let distances: Vec<f32> = reference.iter().map(|&distance| distance as f32).collect();
        let scene = self.scene(&Setting::BASE);
        let (renderer, target) = studio.renderer(&scene)?;
        match renderer.draw_with_distances(&scene, target, &distances) {
            Ok(()) => {}
            Err(error @ RenderError::Unsupported { .. }) => {
                let note = format!("FLIP: {}", first_line(&error));
                if !left_out.contains(&note) {
                    left_out.push(note);
                }
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        }
        Ok(Some(studio.picture()?))
    }

    /// Distances, steps, a picture and a first time of every setting; those that would take too long are left out.
    fn shots(
        &self,
        studio: &mut Studio,
        began: Instant,
        view: &str,
        left_out: &mut Vec<String>,
    ) -> (Vec<Shot>, Option<Halt>) {
        let known = |setting: &Setting| self.prepared.iter().any(|known| known.technique == setting.technique);
        let mut ladder = Setting::ladder(self.job.quick);
        ladder.retain(known);
        // What the others are compared with comes first, and the dearest of every technique last.
        let steps = |setting: &Setting| setting.samples.filter(|_| *setting != Setting::BASE).map(|samples| samples[1]);
        let mut order: Vec<usize> = (0..ladder.len()).collect();
        order.sort_by_key(|&index| steps(&ladder[index]));
        let mut shots: Vec<(usize, Shot)> = Vec::new();
        let (mut skipped, mut halt) = (Vec::new(), None);
        for (done, &index) in order.iter().enumerate() {
            if self.monitor.stop() {
                halt = Some(Halt::Asked);
                break;
            }
            let setting = ladder[index];
            let name = format!("`{}` {}", setting.technique.name(), setting.words());
            (self.tell)(&name.replace('`', ""), REFERENCE + SHOTS * done as f64 / ladder.len() as f64);
            if steps(&setting).is_some() && self.would_take_too_long(&setting, &shots, began) {
                skipped.push((index, name));
                continue;
            }
            match self.shot(studio, setting) {
                Ok(shot) => shots.push((index, shot)),
                Err(error) => {
                    halt = Some(error.into());
                    break;
                }
            }
        }
        skipped.sort();
        let names: Vec<_> = skipped.into_iter().map(|(_, name)| name).collect();
        if !names.is_empty() {
            left_out.push(format!("{view}, because it would take too long: {}", names.join("; ")));
        }
        shots.sort_by_key(|(index, _)| *index);
        (shots.into_iter().map(|(_, shot)| shot).collect(), halt)
    }

    /// Whether measuring one more setting, and so many frames of all as there have to be, would go beyond the time.
    fn would_take_too_long(&self, setting: &Setting, shots: &[(usize, Shot)], began: Instant) -> bool {
        // Twice the steps take twice the time, and so do those of every ray instead of some.
        let last = shots
            .iter()
            .rev()
            .find(|(_, shot)| shot.setting.technique == setting.technique && shot.setting != Setting::BASE);
        let frame_s = last.map_or(0.0, |(_, shot)| shot.frame_ms * 2e-3);
        // Its own frames and its probe; and the fewest rounds of all.
        let all_s = shots.iter().map(|(_, shot)| shot.frame_ms * 1e-3).sum::<f64>() + frame_s;
        let expected_s = began.elapsed().as_secs_f64() + 4.0 * frame_s + FEWEST as f64 * all_s;
        expected_s > PATIENCE * self.budget_s
    }

    fn shot(&self, studio: &mut Studio, setting: Setting) -> Result<Shot, RenderError> {
        let scene = self.scene(&setting);
        // The first frame compiles and uploads.
        studio.frame(&scene)?;
        let frame_ms = studio.frame(&scene)?;
        let picture = studio.picture()?;
        let (renderer, _) = studio.renderer(&scene)?;
        let others = ["picture", "depth", "sky", "diffuse"];
        let textures = renderer.ledger().textures.iter().filter(|texture| !others.contains(&texture.name.as_str()));
        let bytes = textures.map(|texture| texture.bytes).sum();
        let probe = renderer.probe(&scene, self.job.size)?;
        Ok(Shot { setting, probe, picture, frame_ms, bytes })
    }

    fn row(&self, shot: &Shot, reference: &[f64], ideal: Option<&image::RgbImage>) -> Row {
        let (steps_mean, steps_max) = shot.probe.step_stats();
        let prepared = self.prepared.iter().find(|known| known.technique == shot.setting.technique);
        Row {
            setting: shot.setting,
            figures: Figures::of(reference, &shot.probe.distance, self.job.size, self.cell),
            flip: ideal.and_then(|ideal| flip(ideal, &shot.picture)),
            times: None,
            ratio: None,
            steps_mean,
            steps_max,
            cap_hits: shot.probe.cap_hits,
            prepare_ms: prepared.map_or(0.0, |known| known.ms),
            bytes: shot.bytes,
            on_p99_front: false,
            on_wrong_front: false,
        }
    }

    /// One frame of each setting in turn.
    fn times(&self, studio: &mut Studio, report: &mut ViewReport, frame_ms: &[f64], budget_s: f64) -> Result<(), Halt> {
        let rounds = ROUNDS[usize::from(self.job.quick)];
        let counts = plan(frame_ms, rounds, budget_s * 1e3);
        let scenes: Vec<Scene> = report.rows.iter().map(|row| self.scene(&row.setting)).collect();
        let mut times = vec![Vec::new(); scenes.len()];
        let mut halt = Ok(());
        'rounds: for round in 0..rounds {
            let done = REFERENCE + SHOTS + (1.0 - REFERENCE - SHOTS) * round as f64 / rounds as f64;
            (self.tell)(&format!("timing, round {} of {rounds}", round + 1), done);
            for ((scene, &count), times) in scenes.iter().zip(&counts).zip(&mut times) {
                if !has_turn(round, count, rounds) {
                    continue;
                }
                if self.monitor.stop() {
                    halt = Err(Halt::Asked);
                    break 'rounds;
                }
                match studio.frame(scene) {
                    Ok(ms) => times.push(ms),
                    Err(error) => {
                        halt = Err(error.into());
                        break 'rounds;
                    }
                }
            }
        }
        for (row, times) in report.rows.iter_mut().zip(&times) {
            row.times = Times::of(times);
        }
        halt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_what_nothing_else_beats() {
        let points = [
            Some([1.0, 9.0]),
            Some([2.0, 5.0]),
            Some([2.0, 6.0]),
            Some([3.0, 5.0]),
            None,
            Some([4.0, 0.0]),
            Some([4.0, 0.0]),
            Some([5.0, 0.0]),
        ];
        assert_eq!(front(&points), [true, true, false, false, false, true, true, false]);
        assert_eq!(front(&[Some([1.0, 0.0]), Some([1.0, 2.0])]), [true, false], "alone at its time");
    }
}
