//! The edges of the terrain's box. Its shader is `cube.wgsl`, as for the occluder.

use glam::DVec4;

use super::occluder::CubeUniform;
use super::pipelines::PassDescription;

pub(super) fn describe() -> PassDescription {
    PassDescription {
        defs: vec!["WIREFRAME"],
        modules: vec!["frame.wgsl", "cube_faces.wgsl"],
        bindings: super::occluder::bindings(),
        topology: wgpu::PrimitiveTopology::LineList,
        ..PassDescription::scene("wireframe", "cube.wgsl", false)
    }
}

/// The uniform for the box's corners.
pub(super) fn uniform(clip: &[DVec4; 8]) -> CubeUniform {
    CubeUniform { clip: super::cube::as_f32(clip), sun: glam::Vec3::ZERO, ambient: 1.0 }
}
