//! Error against time of the techniques, for the view on screen: measured a frame at a time, so that the window goes on
//! between them.

use crate::gpu::Target;
use crate::heightfield::{ConeKind, HeightField};
use crate::render::{ConeGround, RenderError, Renderer};
use crate::scene::{DebugView, Scene, Technique};

/// Most uniform samples of the settings of a sampling technique; the fewest are a quarter of them, as in the study.
const SAMPLES: [u32; 4] = [32, 128, 512, 2048];

/// Frames of each setting that are timed, after one that is not: a driver compiles shaders in the first.
const ROUNDS: usize = 5;

/// A technique with its samples, and what was measured of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setting {
    pub(crate) technique: Technique,
    /// Most uniform samples, for a technique that takes them.
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
        self.run = Some(Run { target, exact: Vec::new(), done: 0 });
    }

    /// Gives up what is under way: its terrain or its device is gone.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The share that is done, 0 to 1, while a measurement is under way.
    pub(crate) fn progress(&self) -> Option<f32> {
        let steps = 1 + self.settings.len() * (2 + ROUNDS);
        self.run.as_ref().map(|run| run.done as f32 / steps as f32)
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

    /// Whether the results are of another view than that of `scene`.
    pub(crate) fn is_of_another_view(&self, scene: &Scene) -> bool {
        self.scene.camera != scene.camera || self.scene.terrain != scene.terrain || self.scene.craters != scene.craters
    }

    /// Does one step, a frame or a probe, of what is under way. `map` is the terrain, for the size of a cell.
    ///
    /// # Errors
    /// As [`Renderer::draw`]; the measurement is over then.
    pub(crate) fn step(&mut self, renderer: &mut Renderer, map: &HeightField) -> Result<(), RenderError> {
        let Some(mut run) = self.run.take() else { return Ok(()) };
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
        if run.done < 1 + count * (2 + ROUNDS) {
            self.run = Some(run);
        }
        Ok(())
    }
}

fn settings() -> Vec<Setting> {
    let of = |technique, samples| Setting { technique, samples, error: None, times: Vec::new() };
    Technique::ALL
        .into_iter()
        .flat_map(|technique| match technique.samples_uniformly() {
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
        renderer.draw(&Scene::default(), &Target::new(&gpu, [64, 48])).unwrap();
        let ledger = renderer.ledger().clone();
        let mut tradeoff = Tradeoff::default();
        assert_eq!((tradeoff.progress(), tradeoff.results().len()), (None, 0));
        tradeoff.start(&Scene::default(), Target::new(&gpu, [64, 48]));
        let mut steps = 0;
        while let Some(progress) = tradeoff.progress() {
            assert!((0.0..1.0).contains(&progress) && tradeoff.results().is_empty());
            tradeoff.step(&mut renderer, &map).unwrap();
            steps += 1;
        }
        assert_eq!(renderer.ledger(), &ledger);
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
        assert!(error(Technique::Linear, Some(2048)) < error(Technique::Linear, Some(32)));
        assert!(!tradeoff.is_of_another_view(&Scene::default()));
        let mut elsewhere = Scene::default();
        elsewhere.terrain.height_scale = Some(0.5);
        assert!(tradeoff.is_of_another_view(&elsewhere));
    }
}
