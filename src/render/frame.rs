//! Bind group 0: what every pass of a frame shares. Mirrors `shaders/frame.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use crate::camera::Camera;
use crate::gpu::Gpu;

use super::cube::corner;
use super::pipelines::Built;

/// Mirror of `Frame` in `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct FrameUniform {
    pub(super) clip_from_world: [[f32; 4]; 4],
    pub(super) ray_origin: Vec3,
    pub(super) ray_start: f32,
    pub(super) ray_origin_right: Vec3,
    pub(super) pixel_size: f32,
    pub(super) ray_origin_down: Vec3,
    pub(super) padding: f32,
    pub(super) ray_direction: Vec3,
    pub(super) flattening: f32,
    pub(super) ray_direction_right: Vec3,
    pub(super) centre_x: f32,
    pub(super) ray_direction_down: Vec3,
    pub(super) centre_y: f32,
}

impl FrameUniform {
    /// The rays of `camera` through a picture of `size` pixels, begun near the terrain's box of the size `extent`.
    pub(super) fn new(camera: &Camera, size: [u32; 2], extent: DVec3, flattening: f32) -> Self {
        let basis = camera.basis();
        let pixel = camera.pixel_size(size[1]);
        let (right, down) = (basis.right * pixel, -basis.up * pixel);
        let start = ray_start(camera, extent);
        without_subnormals(Self {
            clip_from_world: camera.clip_from_world(size).as_mat4().to_cols_array_2d(),
            ray_origin: (camera.eye + basis.forward * start).as_vec3(),
            ray_start: start as f32,
            ray_origin_right: (right * start).as_vec3(),
            pixel_size: pixel as f32,
            ray_origin_down: (down * start).as_vec3(),
            padding: 0.0,
            ray_direction: basis.forward.as_vec3(),
            flattening,
            ray_direction_right: right.as_vec3(),
            centre_x: size[0] as f32 * 0.5,
            ray_direction_down: down.as_vec3(),
            centre_y: size[1] as f32 * 0.5,
        })
    }
}

/// A uniform, all of it floats, with 0 for subnormals and −0: what the one driver flushes and another does not, and a
/// sign that a division turns into −∞, are no part of any scene.
pub(super) fn without_subnormals<T: Pod>(mut uniform: T) -> T {
    for float in bytemuck::cast_slice_mut::<T, f32>(std::slice::from_mut(&mut uniform)) {
        if float.abs() < f32::MIN_POSITIVE {
            *float = 0.0;
        }
    }
    uniform
}

/// View depth from which rays count their parameter: that of the nearest corner of the box, if all of it lies ahead.
pub(crate) fn ray_start(camera: &Camera, extent: DVec3) -> f64 {
    let forward = camera.basis().forward;
    let depth = |index: usize| forward.dot(corner(index) * extent - camera.eye);
    (0..8).map(depth).fold(f64::INFINITY, f64::min).max(0.0)
}

/// The uniform buffer of bind group 0 and its layout.
#[derive(Clone, Debug)]
pub(super) struct FrameBindings {
    pub(super) layout: FrameLayouts,
    group: wgpu::BindGroup,
    flat_group: wgpu::BindGroup,
    buffer: wgpu::Buffer,
}

/// Layouts of the frame's bind group.
#[derive(Clone, Debug)]
pub(super) struct FrameLayouts {
    /// For passes whose vertices hand the constants on (`varyings.wgsl`): their fragments do not read it.
    pub(super) flat: wgpu::BindGroupLayout,
    /// For all others.
    pub(super) all: wgpu::BindGroupLayout,
}

impl FrameBindings {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let layout = |visibility| {
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("frame"),
                entries: &[wgpu::BindGroupLayoutEntry { visibility, ..uniform_entry::<FrameUniform>(0) }],
            })
        };
        let layout =
            FrameLayouts { flat: layout(wgpu::ShaderStages::VERTEX), all: layout(wgpu::ShaderStages::VERTEX_FRAGMENT) };
        let buffer = uniform_buffer::<FrameUniform>(gpu, "frame");
        let group = |layout| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
            })
        };
        let (group, flat_group) = (group(&layout.all), group(&layout.flat));
        Self { layout, group, flat_group, buffer }
    }

    /// The bind group as this pipeline wants it.
    pub(super) fn group(&self, built: &Built) -> &wgpu::BindGroup {
        if built.flat { &self.flat_group } else { &self.group }
    }

    pub(super) fn write(&self, gpu: &Gpu, frame: &FrameUniform) {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(frame));
    }
}

/// A uniform buffer for one `T`.
pub(super) fn uniform_buffer<T>(gpu: &Gpu, label: &str) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// The layout entry of a uniform buffer that holds a `T`.
pub(super) fn uniform_entry<T>(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: std::num::NonZeroU64::new(size_of::<T>() as u64),
        },
        count: None,
    }
}

/// A read-only storage buffer of so many bytes. Fragments of software rasterisers see few uniform buffers (`pipelines.rs`).
pub(super) fn storage_buffer(gpu: &Gpu, label: &str, bytes: usize) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes as u64,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// The layout entry of a read-only storage buffer that holds a `T`.
pub(super) fn storage_entry<T>(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: std::num::NonZeroU64::new(size_of::<T>() as u64),
        },
        ..uniform_entry::<T>(binding)
    }
}

/// The layout entry of a texture.
pub(super) fn texture_entry(binding: u32, filterable: bool, layers: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: if layers { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 },
            multisampled: false,
        },
        count: None,
    }
}

/// The layout entry of a filtering sampler.
pub(super) fn sampler_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

/// The layout entry of a sampler that gathers texels without filtering them.
pub(super) fn corner_sampler_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
        ..sampler_entry(binding)
    }
}
