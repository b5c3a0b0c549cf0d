//! The techniques that sample, against the same sampling in f64.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use relief::camera::{Camera, NamedView};
use relief::heightfield::{EditedTerrain, HeightField};
use relief::scene::{HeightFilter, MarchSettings, Technique};

use super::common::{self, canyon, crater_on_the_summit, renderer, scene_at};

/// The uniform sampling of the three classic techniques, as their papers describe it, in f64.
struct Sampling<'a> {
    field: &'a HeightField,
    extent: DVec3,
    /// The highest ground, normalised.
    highest: f32,
    march: &'a MarchSettings,
}

/// What sampling finds along one ray.
struct Sampled {
    /// Distance to the hit in world units.
    distance: Option<f64>,
    /// Distance between two samples, world units.
    step: f64,
    count: u32,
}

impl Sampling<'_> {
    fn height(&self, position: DVec3) -> f64 {
        let (u, v) = (position.x / self.extent.x, position.z / self.extent.z);
        let height = match self.march.filter {
            HeightFilter::Nearest => {
                let [columns, rows] = self.field.cells().map(f64::from);
                let nearest = |t: f64, cells: f64| (t.clamp(0.0, 1.0) * cells + 0.5).floor() as u32;
                f64::from(self.field.sample(nearest(u, columns), nearest(v, rows)))
            }
            HeightFilter::Exact | HeightFilter::HardwareLinear => self.field.surface_height(u, v),
        };
        height * self.extent.y
    }

    /// Where the ray is inside the box whose lid is at `top`.
    fn span(&self, origin: DVec3, direction: DVec3, top: f64) -> Option<DVec2> {
        let high = DVec3::new(self.extent.x, top, self.extent.z);
        let (a, b) = (-origin / direction, (high - origin) / direction);
        let (begin, end) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (begin <= end).then_some(DVec2::new(begin, end))
    }

    fn cast(&self, camera: &Camera, x: u32, y: u32, size: [u32; 2]) -> Option<Sampled> {
        let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, size);
        let direction = ray.direction.normalize();
        let top = if self.march.lower_start { f64::from(self.highest) } else { 1.0 } * self.extent.y;
        let span = self.span(ray.origin, direction, top)?;
        let [fewest, most] = [self.march.samples_min, self.march.samples_max].map(f64::from);
        let count = if self.march.steps_by_angle {
            (most + (fewest - most) * direction.y.abs()).round().max(1.0) as u32
        } else {
            self.march.samples_max.max(1)
        };
        let step = (span.y - span.x) / f64::from(count);
        let height_at = |distance: f64| {
            let position = ray.origin + direction * distance;
            position.y - self.height(position)
        };
        let below = |distance: f64| height_at(distance) <= 0.0;
        let first = (0..=count).find(|&index| below(span.x + step * f64::from(index)));
        let distance = first.map(|index| {
            let mut under = span.x + step * f64::from(index);
            let mut over = under - step;
            let halvings = if self.march.technique == Technique::LinearBinary { self.march.binary_steps } else { 0 };
            for _ in 0..if index > 0 { halvings } else { 0 } {
                let middle = 0.5 * (over + under);
                if below(middle) {
                    under = middle;
                } else {
                    over = middle;
                }
            }
            if self.march.technique == Technique::Secant && index > 0 {
                let (above, here) = (height_at(over), height_at(under));
                return over + step * above / (above - here);
            }
            under
        });
        Some(Sampled { distance, step, count })
    }
}

#[test]
fn the_sampling_techniques_sample_as_described() {
    let map = canyon();
    let extent = map.box_size(None);
    let mut renderer = renderer(&map);
    let [linear, binary, secant] = [Technique::Linear, Technique::LinearBinary, Technique::Secant]
        .map(|technique| MarchSettings { technique, ..MarchSettings::default() });
    // Without its summit the map does not fill its box, and the lowered start shows.
    let summit = crater_on_the_summit(&map);
    let mut edited = EditedTerrain::new(Arc::clone(&map));
    edited.set_craters(&[summit]);
    let highest = edited.field().samples().iter().copied().fold(0.0, f32::max);
    assert!(highest < 0.98, "the crater must lower the highest ground, not to {highest}");
    let cases = [
        ("linear", linear.clone()),
        ("linear-binary", binary.clone()),
        ("linear, few", MarchSettings { samples_min: 8, samples_max: 24, ..linear.clone() }),
        ("linear, fixed", MarchSettings { steps_by_angle: false, ..linear.clone() }),
        ("linear, from the lid", MarchSettings { lower_start: false, ..linear.clone() }),
        ("linear, nearest", MarchSettings { filter: HeightFilter::Nearest, ..linear.clone() }),
        ("linear, hardware", MarchSettings { filter: HeightFilter::HardwareLinear, ..linear }),
        ("linear-binary, 3 halvings", MarchSettings { binary_steps: 3, ..binary.clone() }),
        ("linear-binary, nearest", MarchSettings { filter: HeightFilter::Nearest, ..binary.clone() }),
        ("linear-binary, hardware", MarchSettings { filter: HeightFilter::HardwareLinear, ..binary }),
        ("secant", secant.clone()),
        ("secant, few", MarchSettings { samples_min: 8, samples_max: 24, ..secant.clone() }),
        ("secant, fixed", MarchSettings { steps_by_angle: false, ..secant.clone() }),
        ("secant, nearest", MarchSettings { filter: HeightFilter::Nearest, ..secant }),
    ];
    for (name, march) in cases {
        // The sampler's weights have 8 bits: near the surface it may decide for the sample before or after.
        let agreeing = if march.filter == HeightFilter::HardwareLinear { 0.98 } else { 0.998 };
        for view in [NamedView::Over, NamedView::Horizon] {
            let mut scene = scene_at(view, &map);
            scene.march = march.clone();
            scene.craters.list = vec![summit];
            let probe = renderer.probe(&scene, common::SIZE).unwrap();
            let sampling = Sampling { field: edited.field(), extent, highest, march: &scene.march };
            let camera = scene.camera.unwrap();
            let agrees = |index: usize| {
                let (x, y) = (index as u32 % common::SIZE[0], index as u32 / common::SIZE[0]);
                let actual = f64::from(probe.distance[index]);
                let Some(cast) = sampling.cast(&camera, x, y, common::SIZE) else {
                    return actual.is_infinite() && probe.steps[index] <= 1;
                };
                // Half a step apart would be another sample.
                match cast.distance {
                    Some(expected) => (actual - expected).abs() < 0.02 * cast.step + 2e-6,
                    None => actual.is_infinite() && probe.steps[index].abs_diff(cast.count + 1) <= 1,
                }
            };
            let pixels = probe.distance.len();
            let same = (0..pixels).into_par_iter().filter(|&index| agrees(index)).count();
            println!(
                "{name:26} {:8} {:.4} % of pixels as on the CPU",
                view.name(),
                100.0 * same as f64 / pixels as f64
            );
            assert!(same as f64 >= agreeing * pixels as f64, "{name} {}: only {same} of {pixels}", view.name());
        }
    }
}
