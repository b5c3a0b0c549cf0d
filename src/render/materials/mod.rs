//! The ground's materials on the GPU: textures, coverage maps, uniform. Their shader is `shaders/materials.wgsl`.
//!
//! All of it exists only while a frame needs it. The textures are made once in a program ([`synthesis`]), where possible
//! beside the pipelines and so away from any frame.

mod coverage;
mod key;
pub(super) mod noise;
mod synthesis;
mod uniform;

use std::path::PathBuf;

use crate::gpu::Gpu;
use crate::scene::{MOST_COVERAGE_MAPS, Scene};

use super::RenderError;
use super::frame::{sampler_entry, texture_entry, uniform_buffer, uniform_entry};
use super::ground::{Ground, Texture};
use super::images::Images;
use super::ledger::TextureEntry;

use coverage::Coverage;
pub(super) use key::MaterialsKey;
pub(super) use uniform::MaterialsUniform;

/// Bindings in the terrain's group.
const UNIFORM: u32 = 16;
const TEXTURES: u32 = 26;
const SAMPLER: u32 = 27;
const COVERAGE: u32 = 28;
const COVERAGE_SAMPLER: u32 = 29;

/// Texels that a sampler reads along a stretched footprint. In software each costs as much as a texture of its own.
const ANISOTROPY: u16 = 8;

/// Makes the textures, unless they are made.
pub(super) fn make_ready() {
    synthesis::textures();
}

/// What the terrain's pipeline binds for a key.
pub(super) fn layout_entries(key: MaterialsKey) -> Vec<wgpu::BindGroupLayoutEntry> {
    let mut entries = Vec::new();
    if key.on {
        entries.extend([
            uniform_entry::<MaterialsUniform>(UNIFORM),
            texture_entry(TEXTURES, true, true),
            sampler_entry(SAMPLER),
        ]);
    }
    if key.coverage {
        entries.extend([texture_entry(COVERAGE, true, true), sampler_entry(COVERAGE_SAMPLER)]);
    }
    entries
}

/// Textures, samplers and uniform of a terrain's materials.
#[derive(Debug)]
pub(super) struct Materials {
    buffer: wgpu::Buffer,
    textures: Texture,
    sampler: wgpu::Sampler,
    coverage: Option<(Vec<PathBuf>, Texture)>,
    coverage_sampler: wgpu::Sampler,
    uploaded: u64,
}

impl Materials {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let sampler = |label, address, anisotropy_clamp| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: address,
                address_mode_v: address,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                anisotropy_clamp,
                ..Default::default()
            })
        };
        let layers = synthesis::textures();
        let size = [synthesis::SIDE as u32; 2];
        let shape =
            Shape { label: "materials", size, levels: synthesis::LEVELS as u32, layers: synthesis::LAYERS as u32 };
        let textures = shape.texture(gpu, wgpu::TextureFormat::Rgba8Snorm);
        let bytes = layers.iter().map(|levels| levels.iter().map(|level| bytemuck::cast_slice(level)));
        let uploaded = shape.fill(gpu, &textures, bytes);
        let anisotropy = if gpu.capabilities.software { 1 } else { ANISOTROPY };
        Self {
            buffer: uniform_buffer::<MaterialsUniform>(gpu, "materials"),
            textures,
            sampler: sampler("materials", wgpu::AddressMode::Repeat, anisotropy),
            coverage: None,
            coverage_sampler: sampler("coverage", wgpu::AddressMode::ClampToEdge, 1),
            uploaded,
        }
    }

    /// Whether the coverage maps are those of `paths`.
    pub(super) fn covers(&self, paths: &[PathBuf]) -> bool {
        self.coverage.as_ref().map_or(&[][..], |(known, _)| known) == paths
    }

    /// Brings uniform and coverage maps up to date with `scene`.
    ///
    /// # Errors
    /// [`RenderError::Image`] for a coverage map that cannot be used, [`RenderError::Unsupported`] where the levels are metres
    /// and the map has none.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        ground: &Ground,
        extent: glam::DVec3,
        images: &mut Images,
    ) -> Result<(), RenderError> {
        let uniform = MaterialsUniform::new(scene, ground, extent).ok_or(RenderError::Impossible {
            what: "levels of materials in metres",
            why: "the metres of this map are not known",
            instead: "give them as shares of its height (materials.levels = \"share\"), or the map its metres in a sidecar",
        })?;
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&uniform));
        let paths = &scene.materials.coverage;
        if paths.is_empty() {
            self.coverage = None;
        } else if !self.covers(paths) {
            let coverage = Coverage::read(paths, gpu.capabilities.max_texture, images)?;
            // Always two layers: one of a single layer would be another kind of texture to some drivers.
            let shape = Shape {
                label: "coverage",
                size: coverage.size,
                levels: coverage.levels(),
                layers: MOST_COVERAGE_MAPS as u32,
            };
            let texture = shape.texture(gpu, wgpu::TextureFormat::Rgba8Unorm);
            let bytes = coverage.layers.iter().map(|levels| levels.iter().map(Vec::as_slice));
            self.uploaded += shape.fill(gpu, &texture, bytes);
            self.coverage = Some((paths.clone(), texture));
        }
        Ok(())
    }

    /// What the terrain's bind group gets for a key; `None` where a texture it needs is missing.
    pub(super) fn entries(&self, key: MaterialsKey) -> Option<Vec<(u32, wgpu::BindingResource<'_>)>> {
        let mut entries = vec![
            (UNIFORM, self.buffer.as_entire_binding()),
            (TEXTURES, wgpu::BindingResource::TextureView(&self.textures.view)),
            (SAMPLER, wgpu::BindingResource::Sampler(&self.sampler)),
        ];
        if key.coverage {
            let (_, texture) = self.coverage.as_ref()?;
            entries.extend([
                (COVERAGE, wgpu::BindingResource::TextureView(&texture.view)),
                (COVERAGE_SAMPLER, wgpu::BindingResource::Sampler(&self.coverage_sampler)),
            ]);
        }
        Some(entries)
    }

    /// Bytes uploaded since the last call.
    pub(super) fn take_uploaded(&mut self) -> u64 {
        std::mem::take(&mut self.uploaded)
    }

    /// For the ledger.
    pub(super) fn list(&self) -> impl Iterator<Item = TextureEntry> {
        let coverage = self.coverage.as_ref().map(|(_, texture)| TextureEntry::of("coverage", &texture.texture));
        std::iter::once(TextureEntry::of("materials", &self.textures.texture)).chain(coverage)
    }
}

/// Size of an array texture of four bytes to a texel.
#[derive(Clone, Copy, Debug)]
struct Shape {
    label: &'static str,
    size: [u32; 2],
    levels: u32,
    layers: u32,
}

impl Shape {
    fn texture(self, gpu: &Gpu, format: wgpu::TextureFormat) -> Texture {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(self.label),
            size: wgpu::Extent3d { width: self.size[0], height: self.size[1], depth_or_array_layers: self.layers },
            mip_level_count: self.levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Texture { texture, view }
    }

    /// Copies each layer's levels; returns the bytes copied.
    fn fill<'a>(self, gpu: &Gpu, to: &Texture, layers: impl Iterator<Item = impl Iterator<Item = &'a [u8]>>) -> u64 {
        let mut bytes = 0;
        for (levels, layer) in layers.zip(0..) {
            for (level, mip) in levels.zip(0..) {
                let [width, height] = self.size.map(|side| (side >> mip).max(1));
                gpu.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &to.texture,
                        mip_level: mip,
                        origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
                        aspect: wgpu::TextureAspect::All,
                    },
                    level,
                    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: None },
                    wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                );
                bytes += level.len() as u64;
            }
        }
        bytes
    }
}
