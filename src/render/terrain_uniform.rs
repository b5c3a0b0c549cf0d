//! The terrain pass's uniform. Mirrors `Terrain` in `shaders/heightfield.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4, Vec3};

use crate::scene::Scene;

use super::drape::Drape;
use super::frame::without_subnormals;
use super::ground::Ground;
use super::light::direct_weights;

/// Mirror of `Terrain` in `heightfield.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct TerrainUniform {
    pub(super) box_clip: [[f32; 4]; 8],
    pub(super) size: Vec3,
    pub(super) highest: f32,
    pub(super) cells: [f32; 2],
    pub(super) cells_per_unit: [f32; 2],
    pub(super) texel_size: [f32; 2],
    pub(super) pyramid_stack: [f32; 2],
    pub(super) repeats_per_cell: [f32; 2],
    pub(super) pyramid_texel: [f32; 2],
    pub(super) layer_cells: [f32; 2],
    pub(super) samples: [f32; 2],
    pub(super) top_size: f32,
    pub(super) layer_rise: f32,
    pub(super) farthest: f32,
    pub(super) texel_density: f32,
    pub(super) binary_steps: u32,
    pub(super) step_cap: u32,
    pub(super) heat_map_max: f32,
    pub(super) repeats: f32,
    pub(super) diffuse: f32,
    pub(super) specular: f32,
    pub(super) shininess: f32,
    pub(super) height_unit: f32,
    pub(super) sun: Vec3,
    pub(super) ambient: f32,
}

impl TerrainUniform {
    pub(super) fn new(
        scene: &Scene,
        ground: &Ground,
        drape: Option<&Drape>,
        extent: DVec3,
        box_clip: &[DVec4; 8],
    ) -> Self {
        let field = ground.terrain().base();
        let cells = field.cells();
        let (layer_cells, rise) = ground.layer().map_or(([1, 1], 0.0), |(_, cells, rise)| (cells, rise));
        let (light, levels) = (&scene.lighting, ground.pyramid_layout());
        let [diffuse, specular] = direct_weights(light);
        let floats = without_subnormals(Self {
            box_clip: super::cube::as_f32(box_clip),
            size: extent.as_vec3(),
            highest: ground.highest() * extent.y as f32,
            cells: cells.map(|side| side as f32),
            cells_per_unit: [(f64::from(cells[0]) / extent.x) as f32, (f64::from(cells[1]) / extent.z) as f32],
            texel_size: cells.map(|side| (1.0 / f64::from(side + 1)) as f32),
            pyramid_stack: levels.stack.map(|side| side as f32),
            repeats_per_cell: cells.map(|side| scene.diffuse.repeats / side as f32),
            pyramid_texel: levels.size().map(|side| (1.0 / f64::from(side)) as f32),
            layer_cells: layer_cells.map(|side| side as f32),
            samples: [scene.march.samples_min as f32, scene.march.samples_max as f32],
            top_size: ground.top_size(),
            layer_rise: rise * extent.y as f32,
            farthest: box_clip.iter().map(|corner| corner.w).fold(0.0, f64::max) as f32,
            texel_density: drape.map_or(1.0, |drape| drape.texel_density([extent.x, extent.z]) as f32),
            binary_steps: 0,
            step_cap: 0,
            heat_map_max: scene.debug.heat_map_max.max(1) as f32,
            repeats: scene.diffuse.repeats,
            diffuse,
            specular,
            shininess: light.shininess,
            height_unit: (extent.y * ground.height_unit()) as f32,
            sun: light.sun_direction().as_vec3(),
            ambient: light.ambient,
        });
        Self { binary_steps: scene.march.binary_steps, step_cap: step_cap(cells), ..floats }
    }
}

/// Most steps of a walk over so many cells: every node that a ray can cross on every level, going down and up again,
/// twice over.
pub(super) fn step_cap(cells: [u32; 2]) -> u32 {
    8 * (cells[0] + cells[1]) + 256
}
