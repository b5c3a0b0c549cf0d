//! The one unit cube: terrain, wireframe, occluder and skybox are all drawn with it.

use glam::{DMat4, DVec3, DVec4};
use wgpu::util::DeviceExt;

use crate::camera::NEAR;
use crate::gpu::Gpu;

/// Triangles, counter-clockwise seen from outside. Corner `i` has bit 0 for x, bit 1 for y, bit 2 for z. Both triangles
/// of a face begin with the same corner, and each face with another one: a flat varying tells the faces apart.
#[rustfmt::skip]
const TRIANGLES: [u16; 36] = [
    4, 6, 2, 4, 2, 0,
    3, 7, 5, 3, 5, 1,
    1, 5, 4, 1, 4, 0,
    6, 7, 3, 6, 3, 2,
    2, 3, 1, 2, 1, 0,
    5, 7, 6, 5, 6, 4,
];

/// The twelve edges, as lines.
#[rustfmt::skip]
const EDGES: [u16; 24] = [
    0, 1, 2, 3, 4, 5, 6, 7,
    0, 2, 1, 3, 4, 6, 5, 7,
    0, 4, 1, 5, 2, 6, 3, 7,
];

/// The cube's index buffer. There is no vertex buffer: a corner's position is the bits of its index.
#[derive(Debug)]
pub(crate) struct Cube {
    triangles: wgpu::Buffer,
    edges: wgpu::Buffer,
}

impl Cube {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let buffer = |label, indices: &[u16]| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents: bytemuck::cast_slice(indices),
                usage: wgpu::BufferUsages::INDEX,
            })
        };
        Self { triangles: buffer("cube triangles", &TRIANGLES), edges: buffer("cube edges", &EDGES) }
    }

    pub(crate) fn draw_faces(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint16);
        pass.draw_indexed(0..TRIANGLES.len() as u32, 0, 0..1);
    }

    pub(crate) fn draw_edges(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_index_buffer(self.edges.slice(..), wgpu::IndexFormat::Uint16);
        pass.draw_indexed(0..EDGES.len() as u32, 0, 0..1);
    }
}

/// Corner `index` of the unit cube.
pub(crate) fn corner(index: usize) -> DVec3 {
    DVec3::new((index & 1) as f64, ((index >> 1) & 1) as f64, ((index >> 2) & 1) as f64)
}

/// The cube's corners in clip space. In f64: from far away the f32 product of matrix and corner has no bits left.
pub(crate) fn clip_corners(clip_from_world: DMat4, world_from_cube: DMat4) -> [DVec4; 8] {
    let clip_from_cube = clip_from_world * world_from_cube;
    std::array::from_fn(|index| clip_from_cube * corner(index).extend(1.0))
}

/// Whether any part of the cube may be in view: not all corners lie outside the same plane of the view.
pub(crate) fn in_view(clip: &[DVec4; 8]) -> bool {
    let outside = |beyond: fn(&DVec4) -> bool| clip.iter().all(beyond);
    !(outside(|c| c.x > c.w)
        || outside(|c| c.x < -c.w)
        || outside(|c| c.y > c.w)
        || outside(|c| c.y < -c.w)
        || outside(|c| c.w < NEAR))
}

/// For a uniform buffer.
pub(crate) fn as_f32(clip: &[DVec4; 8]) -> [[f32; 4]; 8] {
    clip.map(|corner| corner.as_vec4().to_array())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    #[test]
    fn every_triangle_faces_outwards() {
        for triangle in TRIANGLES.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| corner(usize::from(triangle[i])));
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a + b + c - 3.0 * DVec3::splat(0.5)) > 0.0, "{triangle:?}");
        }
    }

    #[test]
    fn a_cube_behind_or_beside_the_eye_is_out_of_view() {
        let camera = Camera { eye: DVec3::new(0.5, 0.5, 3.0), yaw: 0.0, pitch: 0.0, fov: 60.0 };
        let visible = |yaw| {
            let camera = Camera { yaw, ..camera };
            in_view(&clip_corners(camera.clip_from_world([640, 400]), DMat4::IDENTITY))
        };
        assert!(visible(0.0));
        assert!(!visible(180.0));
        assert!(!visible(90.0));
        let inside = Camera { eye: DVec3::splat(0.5), ..camera };
        assert!(in_view(&clip_corners(inside.clip_from_world([640, 400]), DMat4::IDENTITY)));
    }
}
