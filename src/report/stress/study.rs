//! The bound over map sizes and eye distances.

use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;

use super::judge::Judgement;
use super::{Bench, Halt, Stage, complaints, one_line, setting};
use crate::camera::Camera;
use crate::heightfield::HeightField;
use crate::heightfield::generate::{Kind, generate};
use crate::render::RenderError;
use crate::scene::Scene;

/// One map size and eye distance.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Samples along a side of the map.
    pub side: u32,
    /// Distance of the eye from the middle of the map, box lengths.
    pub distance: f64,
    /// What was found, the worst of the views.
    pub judgement: Judgement,
    /// How the promise was broken.
    pub broken: Vec<String>,
}

impl Point {
    /// What messages call it.
    pub(super) fn name(&self) -> String {
        format!("{0}×{0} from {1:e}", self.side, self.distance)
    }
}

/// Eye distances in box lengths.
pub(super) const DISTANCES: [f64; 3] = [1.0, 1e3, 1e6];
const SIDES: [u32; 5] = [256, 1024, 4096, 8192, 16384];
const QUICK_SIDES: [u32; 2] = [64, 256];
/// Bytes of memory for each sample of a map: heights as they are made and as they are kept, pyramid, textures, and the
/// way there.
const BYTES_PER_SAMPLE: u64 = 40;
/// Directions from the middle of the map to the eye.
const FROM: [DVec3; 2] = [DVec3::new(0.3, 0.4, 1.0), DVec3::new(-1.0, 0.09, 0.37)];

/// Measures every size and distance.
pub(super) fn measure(
    bench: &mut Bench,
    points: &mut Vec<Point>,
    left_out: &mut Vec<String>,
    tell: &dyn Fn(&str, f64) -> bool,
) -> Result<(), Halt> {
    let sides: &[u32] = if bench.job.quick { &QUICK_SIDES } else { &SIDES };
    let work: f64 = sides.iter().map(|&side| f64::from(side).powi(2)).sum();
    let mut done = 0.0;
    for &side in sides {
        if tell(&format!("the bound on {side}×{side}"), done / work) {
            return Err(Halt::Asked);
        }
        done += f64::from(side).powi(2);
        if let Some(why) = impossible(side, bench.gpu.capabilities.max_texture) {
            left_out.push(format!("the bound on {side}×{side}: {why}"));
            continue;
        }
        let map = Arc::new(generate(Kind::DiamondSquare, side, 1));
        match bench.renderer.set_terrain(Arc::clone(&map)) {
            Ok(()) => {}
            Err(error @ (RenderError::OutOfMemory { .. } | RenderError::TerrainTooLarge { .. })) => {
                left_out.push(format!("the bound on {side}×{side}: {}", one_line(&error)));
                continue;
            }
            Err(error) => return Err(error.into()),
        }
        for distance in DISTANCES {
            if tell(&format!("the bound on {side}×{side} from {distance:e}"), done / work) {
                return Err(Halt::Asked);
            }
            match bench.point(&map, distance) {
                Ok(point) => points.push(point),
                Err(error @ RenderError::OutOfMemory { .. }) => {
                    left_out.push(format!("the bound on {side}×{side}: {}", one_line(&error)));
                }
                Err(error) => return Err(error.into()),
            }
        }
    }
    Ok(())
}

/// Why a map of this size cannot be measured here.
fn impossible(side: u32, limit: u32) -> Option<String> {
    if side > limit {
        return Some(format!("this adapter's textures end at {limit}×{limit}"));
    }
    let needed = u64::from(side).pow(2) * BYTES_PER_SAMPLE;
    let free = free_memory()?;
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    (needed > free).then(|| format!("it takes {:.1} GiB of memory, and {:.1} are free", gib(needed), gib(free)))
}

/// Bytes of memory that are free, where the system tells.
fn free_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

impl Bench {
    fn point(&mut self, map: &HeightField, distance: f64) -> Result<Point, RenderError> {
        let extent = map.box_size(None);
        let middle = extent * 0.5;
        let size = self.job.size;
        let cells = map.cells();
        let mut point = Point { side: map.width(), distance, judgement: Judgement::default(), broken: Vec::new() };
        for from in FROM {
            let fov = 2.0 * (0.55 * extent.length() / distance).atan().to_degrees();
            let camera = Camera::look_at(middle + from.normalize() * distance, middle, fov);
            let mut scene = Scene { camera: Some(camera), ..Scene::default() };
            setting(self.job.exact).apply(&mut scene.march);
            let probe = self.renderer.probe(&scene, size)?;
            let stage = Stage { field: map, extent, camera, size, cell: extent.x / f64::from(cells[0]) };
            let judged = stage.judge(&stage.reference(1), &probe, 1);
            let few = 2 + u64::from(size[0]) * u64::from(size[1]) / 1000;
            point.broken.extend(complaints(&judged, probe.cap_hits, few));
            point.judgement = point.judgement.merge(judged);
        }
        Ok(point)
    }
}
