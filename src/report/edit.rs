//! After an edit: is the next frame that of a freshly built scene, and how long does it take?

use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use super::rounds::Times;
use super::sweep::first_line;
use super::{Halt, Job};
use crate::gpu::{Gpu, Target};
use crate::heightfield::{Crater, HeightField};
use crate::render::{RenderError, Renderer};
use crate::scene::{Scene, Technique};

/// A technique's first frames after craters, one after the other, against a scene that was built with them.
#[derive(Clone, Debug, Serialize)]
pub struct EditCost {
    /// The technique, with its default setting.
    pub technique: Technique,
    /// Wall time of a first frame after a crater: the edit on the CPU, the upload, the frame.
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

/// Craters that are dug, one a frame.
const CRATERS: u32 = 5;
/// Frames between two of them.
const BETWEEN: usize = 2;

/// Measures every technique in the first view.
pub(super) fn measure(
    gpu: &Arc<Gpu>,
    job: &Job,
    scene: &Scene,
    costs: &mut Vec<EditCost>,
    left_out: &mut Vec<String>,
    tell: &dyn Fn(f64) -> bool,
) -> Result<(), Halt> {
    for (index, technique) in Technique::ALL.into_iter().enumerate() {
        if tell(index as f64 / Technique::ALL.len() as f64) {
            return Err(Halt::Asked);
        }
        let mut scene = Scene { camera: job.views.first().map(|(_, camera)| *camera), ..scene.clone() };
        scene.march.technique = technique;
        match cost(gpu, job, scene) {
            Ok(cost) => costs.extend(cost),
            Err(error @ RenderError::Unsupported { .. }) => {
                left_out.push(format!("after an edit, `{}`: {}", technique.name(), first_line(&error)));
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

fn renderer(gpu: &Arc<Gpu>, map: &Arc<HeightField>) -> Result<Renderer, RenderError> {
    let mut renderer = Renderer::new(Arc::clone(gpu))?;
    renderer.set_terrain(Arc::clone(map))?;
    Ok(renderer)
}

fn cost(gpu: &Arc<Gpu>, job: &Job, mut scene: Scene) -> Result<Option<EditCost>, RenderError> {
    let extent = job.map.box_size(scene.terrain.height_scale);
    let target = Target::new(gpu, job.size);
    let mut edited = renderer(gpu, &job.map)?;
    let wall = |renderer: &mut Renderer, scene: &Scene| -> Result<f64, RenderError> {
        let start = Instant::now();
        renderer.draw(scene, &target)?;
        renderer.wait_frame_time()?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    };
    wall(&mut edited, &scene)?;
    let (mut first, mut ordinary) = (Vec::new(), Vec::new());
    for index in 0..CRATERS {
        for _ in 0..BETWEEN {
            ordinary.push(wall(&mut edited, &scene)?);
        }
        let along = 0.3 + 0.1 * f64::from(index);
        let (x, z) = (extent.x * along, extent.z * (0.35 + 0.3 * f64::from(index % 2)));
        scene.craters.list.push(Crater { x, z, radius: 0.03, depth: 0.3, rim: 0.08 });
        first.push(wall(&mut edited, &scene)?);
    }
    // What is compared is the frame after the last crater, before any other.
    let picture = target.read_color(gpu)?;
    let distances = edited.probe(&scene, job.size)?.distance;
    let mut fresh = renderer(gpu, &job.map)?;
    fresh.draw(&scene, &target)?;
    let expected = target.read_color(gpu)?;
    let truth = fresh.probe(&scene, job.size)?.distance;
    let difference = |(&a, &b): (&f32, &f32)| if a == b { 0.0 } else { f64::from(a - b).abs() };
    let largest = distances.iter().zip(&truth).map(difference).fold(0.0, f64::max);
    let differing = picture.pixels().zip(expected.pixels()).filter(|(a, b)| a != b).count();
    Ok(Times::of(&first).zip(Times::of(&ordinary)).map(|(first_frame, ordinary_frame)| EditCost {
        technique: scene.march.technique,
        first_frame,
        ordinary_frame,
        ratio: first_frame.ms / ordinary_frame.ms,
        distance_difference: largest.is_finite().then_some(largest),
        differing_pixels: differing as u64,
    }))
}
