//! The study's Table 1, remade: what each feature costs, as a ratio to one base frame.

use std::time::Instant;

use serde::Serialize;

use super::changes::{Base, Pictures, Variant, variants};
use super::rounds::{Times, has_turn, plan};
use super::studio::Studio;
use super::sweep::{ROUNDS, first_line};
use super::{Halt, Job};
use crate::render::RenderError;
use crate::scene::{Scene, Technique};

/// A feature that is switched against the base frame.
#[derive(Clone, Debug, Serialize)]
pub struct Feature {
    /// What differs from the base frame.
    pub name: String,
    /// Its cost in each view.
    pub views: Vec<FeatureCost>,
    /// The 2009 figure, where the study gives one, as a ratio of frame times.
    pub in_2009: Option<f64>,
}

/// What a feature costs in one view.
#[derive(Clone, Debug, Serialize)]
pub struct FeatureCost {
    /// The view.
    pub view: String,
    /// Times of the frame.
    pub times: Times,
    /// Their median over the base frame's.
    pub ratio: f64,
}

/// What is measured against a base frame.
pub(super) struct Features<'a> {
    pub(super) job: &'a Job,
    pub(super) scene: &'a Scene,
    pub(super) base: Base,
    /// The techniques that could be prepared.
    pub(super) able: &'a [Technique],
    pub(super) pictures: &'a Pictures,
    /// Seconds that a view may take.
    pub(super) budget_s: f64,
}

impl Features<'_> {
    /// Measures every feature in every view.
    pub(super) fn measure(
        &self,
        studio: &mut Studio,
        features: &mut Vec<Feature>,
        left_out: &mut Vec<String>,
        tell: &dyn Fn(f64) -> bool,
    ) -> Result<(), Halt> {
        let &Self { job, budget_s, .. } = self;
        let mut variants = variants(job, self.scene, self.base, self.able, self.pictures);
        let feature = |of: &Variant| Feature { name: of.name.clone(), views: Vec::new(), in_2009: of.in_2009 };
        *features = variants.iter().map(feature).collect();
        let (began, views) = (Instant::now(), job.views.len());
        for (index, (view, camera)) in job.views.iter().enumerate() {
            // Frames that are slow even when each is drawn as rarely as may be: better fewer views than fewer frames.
            if index > 0 && began.elapsed().as_secs_f64() > budget_s * views as f64 {
                let names: Vec<_> = job.views[index..].iter().map(|(name, _)| name.as_str()).collect();
                left_out.push(format!("{}, because it would take too long: {}", self.base.table(), names.join(", ")));
                break;
            }
            for Variant { scene, .. } in &mut variants {
                scene.camera = Some(*camera);
                if scene.flare.enabled {
                    scene.lighting.sun_azimuth = camera.yaw as f32;
                    scene.lighting.sun_elevation = (camera.pitch + 0.35 * camera.fov).clamp(1.0, 80.0) as f32;
                }
            }
            let share = |done: f64| (index as f64 + done) / views as f64;
            let times =
                view_times(studio, job, (self.base.table(), &variants), budget_s, left_out, &|done| tell(share(done)))?;
            let base = times.first().and_then(|times| Times::of(times));
            for (feature, times) in features.iter_mut().zip(&times) {
                if let Some((times, base)) = Times::of(times).zip(base) {
                    feature.views.push(FeatureCost { view: view.clone(), times, ratio: times.ms / base.ms });
                }
            }
        }
        features.retain(|feature| !feature.views.is_empty());
        Ok(())
    }
}

fn view_times(
    studio: &mut Studio,
    job: &Job,
    (table, variants): (&str, &[Variant]),
    budget_s: f64,
    left_out: &mut Vec<String>,
    tell: &dyn Fn(f64) -> bool,
) -> Result<Vec<Vec<f64>>, Halt> {
    let began = Instant::now();
    let mut able = Vec::new();
    for Variant { name, scene, .. } in variants {
        if tell(0.0) {
            return Err(Halt::Asked);
        }
        match studio.frame(scene) {
            Ok(_) => able.push(true),
            Err(error @ (RenderError::Unsupported { .. } | RenderError::Impossible { .. })) => {
                let note = format!("{table}, {name}: {}", first_line(&error));
                if !left_out.contains(&note) {
                    left_out.push(note);
                }
                able.push(false);
            }
            Err(error) => return Err(error.into()),
        }
    }
    // A frame after one of its like: the first pays for textures and bindings that the others had no use for.
    let mut turn = |scene: &Scene| studio.frame(scene).and_then(|_| studio.frame(scene));
    let (mut times, mut turn_ms) = (vec![Vec::new(); variants.len()], vec![0.0; variants.len()]);
    for (index, Variant { scene, .. }) in variants.iter().enumerate().filter(|(index, _)| able[*index]) {
        if tell(0.0) {
            return Err(Halt::Asked);
        }
        // What a turn takes is more than its frames: their textures are made before them.
        let begins = Instant::now();
        times[index].push(turn(scene)?);
        turn_ms[index] = begins.elapsed().as_secs_f64() * 1e3;
    }
    let rounds = ROUNDS[usize::from(job.quick)] - 1;
    let counts = plan(&turn_ms, rounds, (budget_s - began.elapsed().as_secs_f64()) * 1e3);
    for round in 0..rounds {
        for (index, Variant { scene, .. }) in variants.iter().enumerate() {
            if !able[index] || !has_turn(round, counts[index], rounds) {
                continue;
            }
            if tell(round as f64 / rounds as f64) {
                return Err(Halt::Asked);
            }
            times[index].push(turn(scene)?);
        }
    }
    Ok(times)
}
