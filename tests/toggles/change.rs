//! A scene before and after a switch is flipped, and the scenes that this is tried on.

use std::path::PathBuf;

use image::{Rgb, RgbImage, RgbaImage};
use relief::camera::NamedView;
use relief::heightfield::HeightField;
use relief::heightfield::reference::Surface;
use relief::render::{Probe, Renderer};
use relief::scene::{Scene, Technique};

use crate::common::pictures::{changed, count, sky};
use crate::common::{SIZE, canyon, picture, probe, renderer, scene_at, scratch_file};

/// A scene before and after a change: pictures, distances, and which pixels differ.
pub(crate) struct Change {
    pub(crate) renderer: Renderer,
    pub(crate) before: RgbaImage,
    pub(crate) after: RgbaImage,
    pub(crate) probe_before: Probe,
    pub(crate) probe_after: Probe,
    pub(crate) changed: Vec<bool>,
    pub(crate) sky: Vec<bool>,
}

impl Change {
    /// Both from one renderer, as when a switch is flipped.
    pub(crate) fn of(base: &Scene, change: impl FnOnce(&mut Scene)) -> Self {
        let mut scene = base.clone();
        change(&mut scene);
        let mut renderer = renderer(&canyon());
        let before = picture(&mut renderer, base);
        let probe_before = probe(&mut renderer, base);
        let after = picture(&mut renderer, &scene);
        let probe_after = probe(&mut renderer, &scene);
        let (changed, sky) = (changed(&before, &after), sky(&probe_before));
        Self { renderer, before, after, probe_before, probe_after, changed, sky }
    }

    pub(crate) fn assert_distances_kept(&self) {
        assert_eq!(self.probe_before.distance, self.probe_after.distance, "distances must not change");
    }

    /// Pixels of the ground change, at least this share of them, and no others.
    pub(crate) fn assert_ground_only(&self, least: f64) {
        let ground = count(&self.sky.iter().map(|sky| !sky).collect::<Vec<_>>());
        assert!(!self.changed.iter().zip(&self.sky).any(|(&changed, &sky)| changed && sky), "the sky changed");
        let share = count(&self.changed) as f64 / ground as f64;
        assert!(share >= least, "only {share} of the ground changed");
    }

    /// Pixels of the sky change, at least this share of them, and no others.
    pub(crate) fn assert_sky_only(&self, least: f64) {
        assert!(!self.changed.iter().zip(&self.sky).any(|(&changed, &sky)| changed && !sky), "the ground changed");
        let share = count(&self.changed) as f64 / count(&self.sky) as f64;
        assert!(share >= least, "only {share} of the sky changed");
    }
}

pub(crate) fn start() -> Scene {
    scene_at(NamedView::Start, &canyon())
}

/// The start view with an occluder in it.
pub(crate) fn with_cube() -> Scene {
    let mut scene = start();
    scene.occluder.enabled = true;
    scene.occluder.size = 0.2;
    scene
}

/// A sampling technique from the side, where its errors show.
pub(crate) fn sampled(technique: Technique) -> Scene {
    let mut scene = scene_at(NamedView::Graze, &canyon());
    scene.march.technique = technique;
    (scene.march.samples_min, scene.march.samples_max) = (24, 64);
    scene
}

/// Distance errors against the reference where both see ground, in cells, smallest first.
pub(crate) fn errors(probe: &Probe, scene: &Scene, field: &HeightField) -> Vec<f64> {
    let extent = field.box_size(scene.terrain.height_scale);
    let cell = extent.x / f64::from(field.cells()[0]);
    let expected = Surface::new(field, extent).distances(&scene.camera.unwrap(), SIZE, &|_| {});
    let pairs = probe.distance.iter().map(|&distance| f64::from(distance)).zip(expected);
    let both = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
    let mut errors: Vec<_> = both.map(|(a, b)| (a - b).abs() / cell).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// The mean of the errors, in cells.
pub(crate) fn error(probe: &Probe, scene: &Scene, field: &HeightField) -> f64 {
    let errors = errors(probe, scene, field);
    errors.iter().sum::<f64>() / errors.len() as f64
}

pub(crate) fn checker() -> PathBuf {
    let path = scratch_file("toggles-checker.png");
    let square = |x: u32, y: u32| Rgb(if (x / 8 + y / 8).is_multiple_of(2) { [230, 190, 60] } else { [40, 70, 140] });
    RgbImage::from_fn(64, 64, square).save(&path).unwrap();
    path
}
