//! The diffuse texture that is draped over the terrain: generated from height and slope, or any image.

use std::path::PathBuf;

use crate::gpu::Gpu;
use crate::heightfield::{HeightField, SampleRect, colour};
use crate::scene::DiffuseSettings;

use super::RenderError;
use super::ground::Texture;
use super::ledger::TextureEntry;
use super::mips::{self, Image};

/// Longest side of a generated texture.
const MOST_GENERATED: u32 = 4096;

/// The texture on the GPU, and where it came from.
#[derive(Debug)]
pub(super) struct Drape {
    file: Option<PathBuf>,
    texture: Texture,
    /// Kept for generated textures, so that a crater recolours only what it touched.
    generated: Option<(colour::Diffuse, Vec<Image>)>,
}

impl Drape {
    /// Reads or generates the texture; also returns the bytes uploaded.
    pub(super) fn new(gpu: &Gpu, settings: &DiffuseSettings, field: &HeightField) -> Result<(Self, u64), RenderError> {
        let limit = gpu.capabilities.max_texture;
        let (base, generated) = if let Some(path) = &settings.file {
            let image = Image::read(path, limit).map_err(|reason| RenderError::Image { path: path.clone(), reason })?;
            (image, None)
        } else {
            // Colours follow the map's own slopes, not the exaggeration of the moment.
            let diffuse = colour::diffuse(field, field.box_size(None), MOST_GENERATED.min(limit));
            (Image { width: diffuse.width, height: diffuse.height, rgba: diffuse.rgba.clone() }, Some(diffuse))
        };
        let levels = mips::chain(&base);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("diffuse"),
            size: wgpu::Extent3d { width: base.width, height: base.height, depth_or_array_layers: 1 },
            mip_level_count: 1 + levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let uploaded = std::iter::once(&base)
            .chain(&levels)
            .zip(0..)
            .map(|(image, mip)| mips::upload(gpu, &texture, mip, 0, image, image.all()))
            .sum();
        let generated = generated.map(|diffuse| (diffuse, levels));
        Ok((Self { file: settings.file.clone(), texture: Texture { texture, view }, generated }, uploaded))
    }

    /// Whether this is still the texture that the settings ask for.
    pub(super) fn matches(&self, settings: &DiffuseSettings) -> bool {
        self.file == settings.file
    }

    /// Recolours a generated texture where the samples `rect` of `field` have changed; returns the bytes uploaded.
    pub(super) fn update(&mut self, gpu: &Gpu, field: &HeightField, rect: SampleRect) -> u64 {
        let Some((diffuse, levels)) = &mut self.generated else { return 0 };
        let Some(texels) = diffuse.update(field, rect) else { return 0 };
        let base = Image { width: diffuse.width, height: diffuse.height, rgba: std::mem::take(&mut diffuse.rgba) };
        let rects = mips::update(&base, levels, texels);
        let texture = &self.texture.texture;
        let mut uploaded = mips::upload(gpu, texture, 0, 0, &base, texels);
        for ((level, rect), mip) in levels.iter().zip(rects).zip(1..) {
            uploaded += mips::upload(gpu, texture, mip, 0, level, rect);
        }
        diffuse.rgba = base.rgba;
        uploaded
    }

    pub(super) fn view(&self) -> &wgpu::TextureView {
        &self.texture.view
    }

    /// Texels along x.
    pub(super) fn texels_across(&self) -> u32 {
        self.texture.texture.width()
    }

    pub(super) fn entry(&self) -> TextureEntry {
        TextureEntry::of("diffuse", &self.texture.texture)
    }
}
