//! The cube that hides hills and is hidden by them. Its shader is `cube.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DQuat, DVec3, DVec4, EulerRot, Vec3};

use crate::gpu::Gpu;
use crate::heightfield::HeightField;
use crate::scene::{LightingSettings, OccluderSettings};

use super::frame::{uniform_buffer, uniform_entry, without_subnormals};
use super::pipelines::{Built, PassDescription};

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

pub(super) fn describe(probe: bool) -> PassDescription {
    PassDescription {
        defs: if probe { vec!["PROBE"] } else { Vec::new() },
        bindings: bindings(),
        cull: Some(wgpu::Face::Back),
        ..PassDescription::scene(if probe { "occluder (probe)" } else { "occluder" }, "cube.wgsl", probe)
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
        DVec3::new(x, y, z).as_vec3() * lighting.diffuse * 0.7
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

    /// Writes the uniform and makes the bind group for `built`.
    pub(super) fn prepare(&self, gpu: &Gpu, built: &Built, uniform: &CubeUniform) -> wgpu::BindGroup {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&built.name),
            layout: &built.layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: self.buffer.as_entire_binding() }],
        })
    }
}
