//! Error against time of the techniques, for the view on screen: measured a frame at a time, so that the window goes on
//! between them.

use std::time::Instant;

use super::visible::visible_part;
use crate::gpu::Target;
use crate::heightfield::{ConeKind, HeightField};
use crate::render::{Compilation, ConeGround, RenderError, Renderer};
use crate::scene::{DebugSettings, DebugView, MarchSettings, Scene, Technique};

/// Most samples of the settings of a technique that counts them, be it uniform ones or steps along cones; the fewest are a
/// quarter of them, as in the study.
const SAMPLES: [u32; 4] = [32, 128, 512, 2048];

/// Frames of each setting that are timed, after one that is not: a driver compiles shaders in the first.
const ROUNDS: usize = 5;

/// A technique with its samples, and what was measured of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setting {
    pub(crate) technique: Technique,
    /// Most samples, for a technique that counts them.
    pub(crate) samples: Option<u32>,
    /// Distance error against the exact technique that 99% of the pixels do not exceed, cells.
    pub(crate) error: Option<f64>,
    /// Times of its frames, milliseconds.
    times: Vec<f64>,
}

impl Setting {
    /// Median time of a frame, milliseconds.
    pub(crate) fn milliseconds(&self) -> Option<f64> {
        let mut sorted = self.times.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len().saturating_sub(1) / 2).copied()
    }

    /// The setting in words.
    fn words(&self) -> String {
        let name = self.technique.name();
        self.samples.map_or_else(|| name.to_owned(), |samples| format!("{name}, {samples} samples"))
    }

    fn apply(&self, scene: &mut Scene) {
        scene.march.technique = self.technique;
        if let Some(samples) = self.samples {
            (scene.march.samples_min, scene.march.samples_max) = ((samples / 4).max(1), samples);
        }
    }
}

/// A measurement under way.
#[derive(Debug)]
struct Run {
    target: Target,
    exact: Vec<f32>,
    done: usize,
    /// When each step ended; the first is the begin of the first step.
    ends: Vec<Instant>,
}

impl Run {
    /// Seconds that the other `steps` take, once every one of `settings` has had its turn or some have, to go by. Their
    /// order repeats, so the steps of the last round say what those of the next ones take.
    fn seconds_left(&self, steps: usize, settings: usize) -> Option<f64> {
        let lengths: Vec<f64> = self.ends.windows(2).map(|pair| (pair[1] - pair[0]).as_secs_f64()).collect();
        let round = lengths.len().min(settings);
        let mean = lengths.get(lengths.len() - round..)?.iter().sum::<f64>() / round as f64;
        (round >= SAMPLES.len()).then(|| mean * steps.saturating_sub(self.done) as f64)
    }
}

/// The measurement of a view: under way, or the last one.
#[derive(Debug, Default)]
pub(crate) struct Tradeoff {
    settings: Vec<Setting>,
    /// What was measured: the scene at the press of the button.
    scene: Scene,
    run: Option<Run>,
}

impl Tradeoff {
    /// Begins to measure `scene` at the size of `target`.
    pub(crate) fn start(&mut self, scene: &Scene, target: Target) {
        self.scene = scene.clone();
        // What every technique pays the same would only hide the differences, and the error view's second march more so.
        (self.scene.debug.view, self.scene.compare.enabled) = (DebugView::None, false);
        self.settings = settings();
        self.run = Some(Run { target, exact: Vec::new(), done: 0, ends: Vec::new() });
    }

    /// Gives up what is under way: its terrain or its device is gone.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The share that is done, 0 to 1, while a measurement is under way.
    pub(crate) fn progress(&self) -> Option<f32> {
        self.run.as_ref().map(|run| run.done as f32 / self.steps() as f32)
    }

    /// The number of steps of a measurement.
    fn steps(&self) -> usize {
        1 + self.settings.len() * (2 + ROUNDS)
    }

    /// What is measured next, and how long all the rest takes, roughly, in words; while a measurement is under way.
    pub(crate) fn progress_in_words(&self) -> Option<String> {
        let run = self.run.as_ref()?;
        let count = self.settings.len().max(1);
        let what = match run.done.checked_sub(1) {
            None => "The exact picture first".to_owned(),
            Some(step) => {
                let of = if step < count { "Error" } else { "Time" };
                format!("{of} of {}", self.settings.get(step % count).map(Setting::words).unwrap_or_default())
            }
        };
        Some(match run.seconds_left(self.steps(), self.settings.len()) {
            Some(seconds) if seconds < 90.0 => format!("{what}. About {:.0} s left.", seconds.max(1.0)),
            Some(seconds) => format!("{what}. About {:.0} min left.", seconds / 60.0),
            None => format!("{what} …"),
        })
    }

    /// The settings that are measured completely; none before the measurement is over.
    pub(crate) fn results(&self) -> &[Setting] {
        if self.run.is_some() { &[] } else { &self.settings }
    }

    /// The cones that the measurement under way needs and `renderer` does not know.
    pub(crate) fn missing_cones(&self, renderer: &Renderer) -> Option<(ConeGround, Vec<ConeKind>)> {
        self.run.as_ref()?;
        let techniques = Technique::ALL.into_iter().filter(|technique| technique.cones().is_some());
        techniques.into_iter().find_map(|technique| {
            let mut scene = self.scene.clone();
            scene.march.technique = technique;
            renderer.missing_cones(&scene)
        })
    }

    /// Pipelines that the measurement under way needs and that are not there: its steps are frames, and none of them is to
    /// wait for a compiler.
    pub(crate) fn missing_pipelines(&self, renderer: &Renderer) -> Option<Compilation> {
        let size = self.run.as_ref()?.target.size();
        Technique::ALL.into_iter().find_map(|technique| {
            let mut scene = self.scene.clone();
            scene.march.technique = technique;
            [true, false].into_iter().find_map(|probe| renderer.missing_pipelines(&scene, size, probe))
        })
    }

    /// What of `scene` is no longer as it was measured, in words. Technique and samples do not count: others were measured,
    /// too. Nor does the turning of the cube.
    pub(crate) fn outdated(&self, scene: &Scene) -> Option<String> {
        let (before, now) = (bare(&self.scene), bare(scene));
        let ground = before.terrain != now.terrain || before.craters != now.craters;
        let view = before.camera != now.camera;
        let others = Scene { terrain: now.terrain.clone(), craters: now.craters.clone(), camera: now.camera, ..before };
        let changed = [(ground, "the ground"), (view, "the view"), (others != now, "the picture's settings")];
        let words: Vec<&str> = changed.iter().filter(|(changed, _)| *changed).map(|(_, words)| *words).collect();
        (!words.is_empty()).then(|| format!("Measured before {} changed.", words.join(" and ")))
    }

    /// Does one step, a frame or a probe, of what is under way. `map` is the terrain, for the size of a cell.
    ///
    /// # Errors
    /// As [`Renderer::draw`]; the measurement is over then.
    pub(crate) fn step(&mut self, renderer: &mut Renderer, map: &HeightField) -> Result<(), RenderError> {
        let Some(mut run) = self.run.take() else { return Ok(()) };
        if run.ends.is_empty() {
            run.ends.push(Instant::now());
        }
        let (step, count) = (run.done, self.settings.len());
        let mut scene = self.scene.clone();
        if step == 0 {
            scene.march.technique = Technique::MaxMipmap;
            run.exact = renderer.probe(&scene, run.target.size())?.distance;
        } else if let Some(setting) = self.settings.get_mut((step - 1) % count.max(1)) {
            setting.apply(&mut scene);
            // First all errors, then round by round a frame of each, so that a busy moment hits all alike.
            match (step - 1) / count {
                0 => {
                    let found = renderer.probe(&scene, run.target.size())?.distance;
                    let extent = map.box_size(scene.terrain.height_scale);
                    let cells = map.cells().map(f64::from);
                    let cells_per_unit = (cells[0] / extent.x).max(cells[1] / extent.z);
                    setting.error = p99(&found, &run.exact).map(|error| error * cells_per_unit);
                }
                1 => {
                    renderer.time(&scene, &run.target)?;
                }
                _ => setting.times.push(renderer.time(&scene, &run.target)?),
            }
        }
        run.done += 1;
        run.ends.push(Instant::now());
        if run.done < self.steps() {
            self.run = Some(run);
        }
        Ok(())
    }
}

/// The part of a scene that a measurement depends on.
fn bare(scene: &Scene) -> Scene {
    let mut scene = visible_part(scene);
    (scene.debug, scene.compare) =
        (DebugSettings { wireframe: scene.debug.wireframe, ..Default::default() }, Default::default());
    let MarchSettings { technique, samples_min, samples_max, .. } = MarchSettings::default();
    scene.march = MarchSettings { technique, samples_min, samples_max, ..scene.march };
    scene.occluder.rotation = Default::default();
    scene
}

fn settings() -> Vec<Setting> {
    let of = |technique, samples| Setting { technique, samples, error: None, times: Vec::new() };
    Technique::ALL
        .into_iter()
        .flat_map(|technique| match technique.counts_samples() {
            true => SAMPLES.map(|samples| of(technique, Some(samples))).to_vec(),
            false => vec![of(technique, None)],
        })
        .collect()
}

/// The error that 99% of the pixels where both see ground do not exceed (nearest rank), world units.
fn p99(found: &[f32], exact: &[f32]) -> Option<f64> {
    let both = found.iter().zip(exact).filter(|(found, exact)| found.is_finite() && exact.is_finite());
    let mut errors: Vec<f64> = both.map(|(&found, &exact)| (f64::from(found) - f64::from(exact)).abs()).collect();
    errors.sort_by(f64::total_cmp);
    errors.get((errors.len() * 99).div_ceil(100).saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::gpu::Gpu;
    use crate::heightfield::generate::{Kind, generate};

    #[test]
    fn the_99th_percentile_is_an_error_that_occurred() {
        let exact = vec![0.0_f32; 200];
        let found: Vec<f32> = (1..=200u8).map(f32::from).collect();
        assert_eq!(p99(&found, &exact), Some(198.0));
        assert_eq!(p99(&[1.0, f32::INFINITY], &[0.5, 2.0]), Some(0.5), "a wrong silhouette is no distance");
        assert_eq!(p99(&[f32::INFINITY], &[f32::INFINITY]), None);
    }

    /// Every technique ends with a time and an error, samples make it more exact, and the frame's ledger is left alone.
    #[test]
    fn a_measurement_takes_one_frame_at_a_time_and_ends() {
        let gpu = Gpu::headless().unwrap();
        let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
        let map = Arc::new(generate(Kind::Ridged, 129, 3));
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        let target = Target::new(&gpu, [64, 48]);
        let mut tradeoff = Tradeoff::default();
        assert_eq!((tradeoff.progress(), tradeoff.results().len()), (None, 0));
        tradeoff.start(&Scene::default(), Target::new(&gpu, [64, 48]));
        while let Some(missing) = tradeoff.missing_pipelines(&renderer) {
            renderer.set_compiled(missing.build(&|| true).unwrap());
        }
        renderer.draw(&Scene::default(), &target).unwrap();
        let ledger = renderer.ledger().clone();
        let (mut steps, mut words) = (0, Vec::new());
        while let Some(progress) = tradeoff.progress() {
            assert!((0.0..1.0).contains(&progress) && tradeoff.results().is_empty());
            words.push(tradeoff.progress_in_words().unwrap());
            tradeoff.step(&mut renderer, &map).unwrap();
            steps += 1;
        }
        assert_eq!(renderer.ledger(), &ledger);
        renderer.draw(&Scene::default(), &target).unwrap();
        assert_eq!(renderer.ledger().pipelines, ledger.pipelines, "no step had to compile anything");
        assert_eq!(words[2], "Error of linear, 128 samples …");
        let last = &words[steps - 1];
        assert!(last.starts_with("Time of max-mipmap. About ") && last.ends_with(" left."), "{last}");
        assert_eq!(tradeoff.progress_in_words(), None);
        let results = tradeoff.results();
        assert_eq!(steps, 1 + results.len() * (2 + ROUNDS));
        for setting in results {
            assert!(setting.milliseconds().is_some_and(|ms| ms > 0.0), "{setting:?}");
            assert_eq!(setting.times.len(), ROUNDS);
            assert!(setting.error.is_some(), "{setting:?}");
        }
        let error = |technique, samples| {
            results.iter().find(|s| s.technique == technique && s.samples == samples).and_then(|s| s.error).unwrap()
        };
        assert_eq!(error(Technique::MaxMipmap, None), 0.0);
        for technique in [Technique::Linear, Technique::Cone, Technique::RelaxedCone] {
            assert!(error(technique, Some(2048)) < error(technique, Some(32)), "{technique:?}");
        }
    }

    /// Nobody looks for a changed view who has made a crater.
    #[test]
    fn results_say_what_has_changed_since() {
        let tradeoff = Tradeoff::default();
        let after = |change: fn(&mut Scene)| {
            let mut scene = Scene::default();
            change(&mut scene);
            tradeoff.outdated(&scene)
        };
        let same = after(|scene| {
            (scene.march.technique, scene.march.samples_max) = (Technique::Cone, 99);
            (scene.debug.view, scene.compare.enabled) = (DebugView::Error, true);
            scene.craters.radius = 0.3;
            scene.occluder.rotation.x += 1.0;
        });
        assert_eq!(same, None);
        let crater = after(|scene| scene.craters.list.push(scene.craters.brush_at(0.5, 0.5)));
        assert_eq!(crater.as_deref(), Some("Measured before the ground changed."));
        let eye = crate::camera::Camera { eye: glam::DVec3::ONE, yaw: 1.0, pitch: 2.0, fov: 50.0 };
        let mut moved = Scene { camera: Some(eye), ..Scene::default() };
        assert_eq!(tradeoff.outdated(&moved).as_deref(), Some("Measured before the view changed."));
        moved.march.binary_steps = 0;
        let both = "Measured before the view and the picture's settings changed.";
        assert_eq!(tradeoff.outdated(&moved).as_deref(), Some(both));
    }
}
