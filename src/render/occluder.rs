//! The cube that hides hills and is hidden by them. Its shader is `cube.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DQuat, DVec3, DVec4, EulerRot, Vec3};

use crate::gpu::Gpu;
use crate::heightfield::HeightField;
use crate::scene::light::Shadows;
use crate::scene::{LightingSettings, OccluderSettings};

use super::air::AirKey;
use super::frame::{corner_sampler_entry, texture_entry, uniform_buffer, uniform_entry, without_subnormals};
use super::light;
use super::pipelines::{Built, PassDescription};
use super::terrain::{TerrainUniform, bind};

/// Mirror of `Cube` in `cube.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct CubeUniform {
    pub(super) clip: [[f32; 4]; 8],
    pub(super) sun: Vec3,
    pub(super) ambient: f32,
}

pub(super) fn bindings() -> Vec<wgpu::BindGroupLayoutEntry> {
    vec![uniform_entry::<CubeUniform>(0)]
}

/// Which pipeline the occluder needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct OccluderKey {
    pub(super) probe: bool,
    /// What the terrain casts on it.
    pub(super) shadows: Shadows,
    /// The map has holes.
    pub(super) holes: bool,
    /// There is a crater layer.
    pub(super) layered: bool,
    /// The air between it and the eye, and clouds.
    pub(super) air: AirKey,
}

impl OccluderKey {
    pub(super) fn casts_shadows(self) -> bool {
        self.shadows != Shadows::Off
    }

    /// Binding of the cube's uniform: the first is the terrain's where that is read, too.
    fn binding(self) -> u32 {
        if self.casts_shadows() { CUBE_BESIDE_TERRAIN } else { 0 }
    }
}

/// Binding of the cube's uniform beside the terrain's.
const CUBE_BESIDE_TERRAIN: u32 = 21;

pub(super) fn describe(key: OccluderKey) -> PassDescription {
    let plain = PassDescription {
        modules: vec!["frame.wgsl", "cube_faces.wgsl"],
        bindings: bindings(),
        cull: Some(wgpu::Face::Back),
        ..PassDescription::scene(if key.probe { "occluder (probe)" } else { "occluder" }, "cube.wgsl", key.probe)
    };
    if key.probe {
        return PassDescription { defs: vec!["PROBE"], ..plain };
    }
    if !key.casts_shadows() {
        if !key.air.is_on() {
            return plain;
        }
        let defs: Vec<_> = key.air.defs().collect();
        return PassDescription {
            name: format!("occluder [{}]", defs.join(" ")),
            modules: plain.modules.into_iter().chain(key.air.modules()).collect(),
            defs,
            bindings: plain.bindings.into_iter().chain(key.air.bindings()).collect(),
            ..plain
        };
    }
    let mut bindings = vec![
        uniform_entry::<CubeUniform>(key.binding()),
        uniform_entry::<TerrainUniform>(0),
        texture_entry(1, false, false),
        texture_entry(3, false, false),
        corner_sampler_entry(7),
        light::layout_entry(),
    ];
    bindings.extend(key.layered.then(|| texture_entry(4, false, false)));
    bindings.extend(key.air.bindings());
    let defs: Vec<_> = [
        (true, "SHADOWS"),
        (true, "FROM_OUTSIDE"),
        (key.shadows == Shadows::Soft, "SOFT_SHADOWS"),
        (key.holes, "HOLES"),
        (key.layered, "CRATERS_LAYERED"),
    ]
    .into_iter()
    .filter_map(|(on, def)| on.then_some(def))
    .chain(key.air.defs())
    .collect();
    let modules = ["frame.wgsl", "cube_faces.wgsl", "heightfield.wgsl", "pyramid.wgsl", "light.wgsl", "shadow.wgsl"];
    PassDescription {
        name: format!("occluder [{}]", defs.join(" ")),
        modules: modules.into_iter().chain(key.air.modules()).collect(),
        defs,
        bindings,
        ..plain
    }
}

/// Where the occluder stands: from the unit cube to the world.
pub(crate) fn world_from_cube(settings: &OccluderSettings, map: &HeightField, extent: DVec3) -> DMat4 {
    let position = settings.centre(map, extent);
    let turn = settings.rotation * (std::f64::consts::PI / 180.0);
    let rotation = DQuat::from_euler(EulerRot::YXZ, turn.x, turn.y, turn.z);
    DMat4::from_scale_rotation_translation(DVec3::splat(settings.size), rotation, position)
        * DMat4::from_translation(DVec3::splat(-0.5))
}

/// The uniform: corners on the screen, and the sun as the cube sees it.
pub(super) fn uniform(clip: &[DVec4; 8], world_from_cube: DMat4, lighting: &LightingSettings) -> CubeUniform {
    let sun = if lighting.enabled {
        // The rotation's transpose; the scale cancels in the normalisation.
        let world = lighting.sun_direction();
        let axes = [world_from_cube.x_axis, world_from_cube.y_axis, world_from_cube.z_axis];
        let [x, y, z] = axes.map(|axis| axis.truncate().normalize_or_zero().dot(world));
        DVec3::new(x, y, z).as_vec3() * light::direct_weights(lighting)[0] * 0.7
    } else {
        Vec3::ZERO
    };
    let ambient = if lighting.enabled { 0.45 } else { 1.0 };
    without_subnormals(CubeUniform { clip: super::cube::as_f32(clip), sun, ambient })
}

/// A cube's uniform buffer.
#[derive(Debug)]
pub(super) struct CubeBindings {
    buffer: wgpu::Buffer,
}

impl CubeBindings {
    pub(super) fn new(gpu: &Gpu, label: &str) -> Self {
        Self { buffer: uniform_buffer::<CubeUniform>(gpu, label) }
    }

    /// Writes the uniform and makes the bind group for `built`, with the entries of what else its shader reads.
    pub(super) fn prepare<'a>(
        &'a self,
        gpu: &Gpu,
        built: &Built,
        key: OccluderKey,
        uniform: &CubeUniform,
        mut entries: Vec<(u32, wgpu::BindingResource<'a>)>,
    ) -> wgpu::BindGroup {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
        entries.push((key.binding(), self.buffer.as_entire_binding()));
        bind(gpu, built, entries)
    }
}
