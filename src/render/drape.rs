//! The diffuse texture that is draped over the terrain: generated from height and slope, or any image.

use std::path::{Path, PathBuf};

use crate::gpu::Gpu;
use crate::heightfield::colour::{self, Diffuse};
use crate::heightfield::{HeightField, SampleRect};
use crate::scene::DiffuseSettings;

use super::RenderError;
use super::ground::Texture;
use super::images::{Decoded, Images, Purpose};
use super::ledger::TextureEntry;
use super::mips::{self, Image};

/// Longest side of a generated texture.
const MOST_GENERATED: u32 = 4096;

/// Paints a map by height and slope. Colours follow the map's own slopes, not the exaggeration of the moment.
pub(super) fn paint(field: &HeightField) -> Diffuse {
    colour::diffuse(field, field.box_size(None), MOST_GENERATED)
}

/// The colours of one terrain. The texture exists only while a frame needs it; generated colours are kept on the CPU,
/// where they took long to paint.
#[derive(Debug)]
pub(super) struct Drape {
    generated: Option<Diffuse>,
    /// Mips below `generated`.
    levels: Vec<Image>,
    /// The texture and the file it came from; `None` as a file stands for the generated colours.
    texture: Option<(Option<PathBuf>, Texture)>,
    uploaded: u64,
}

impl Drape {
    /// Colours that were painted before, or are painted when they are first needed.
    pub(super) fn new(generated: Option<Diffuse>) -> Self {
        Self { generated, levels: Vec::new(), texture: None, uploaded: 0 }
    }

    /// Gives the texture back.
    pub(super) fn drop_texture(&mut self) {
        self.texture = None;
    }

    /// Whether the texture is that of `file`, or of the generated colours.
    pub(super) fn shows(&self, file: Option<&Path>) -> bool {
        self.texture.as_ref().is_some_and(|(shown, _)| shown.as_deref() == file)
    }

    /// Makes the texture that `settings` ask for, if it is not there. True when the colours of `field` were painted anew.
    ///
    /// # Errors
    /// [`RenderError::Image`] where the settings name a file that cannot be used; the old texture stays.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        settings: &DiffuseSettings,
        field: &HeightField,
        images: &mut Images,
    ) -> Result<bool, RenderError> {
        if self.shows(settings.file.as_deref()) {
            return Ok(false);
        }
        if let Some(path) = &settings.file {
            let Decoded { image, levels } = images.take(path, Purpose::Colours, gpu.capabilities.max_texture)?;
            self.texture = Some((settings.file.clone(), self.upload(gpu, &image, &levels)));
            return Ok(false);
        }
        let painted = self.generated.is_none();
        let mut diffuse = self.generated.take().unwrap_or_else(|| paint(field));
        let base = image_of(&mut diffuse);
        if self.levels.is_empty() {
            self.levels = mips::chain(&base);
        }
        let levels = std::mem::take(&mut self.levels);
        self.texture = Some((None, self.upload(gpu, &base, &levels)));
        self.levels = levels;
        diffuse.rgba = base.rgba;
        self.generated = Some(diffuse);
        Ok(painted)
    }

    /// Recolours the generated texture where the samples `rect` of `field` have changed; returns the bytes uploaded.
    pub(super) fn update(&mut self, gpu: &Gpu, field: &HeightField, rect: SampleRect) -> u64 {
        let Some(diffuse) = &mut self.generated else { return 0 };
        let Some(texels) = diffuse.update(field, rect) else { return 0 };
        let base = image_of(diffuse);
        let rects = mips::update(&base, &mut self.levels, texels);
        let mut uploaded = 0;
        if let Some((None, texture)) = &self.texture {
            uploaded = mips::upload(gpu, &texture.texture, 0, 0, &base, texels);
            for ((level, rect), mip) in self.levels.iter().zip(rects).zip(1..) {
                uploaded += mips::upload(gpu, &texture.texture, mip, 0, level, rect);
            }
        }
        diffuse.rgba = base.rgba;
        uploaded
    }

    /// Bytes uploaded since the last call by [`Self::prepare`].
    pub(super) fn take_uploaded(&mut self) -> u64 {
        std::mem::take(&mut self.uploaded)
    }

    pub(super) fn view(&self) -> Option<&wgpu::TextureView> {
        self.texture.as_ref().map(|(_, texture)| &texture.view)
    }

    /// Texels per world unit where they are densest, over a ground of these sides.
    pub(super) fn texel_density(&self, sides: [f64; 2]) -> f64 {
        self.texture.as_ref().map_or(1.0, |(_, Texture { texture, .. })| {
            (f64::from(texture.width()) / sides[0]).max(f64::from(texture.height()) / sides[1])
        })
    }

    pub(super) fn entry(&self) -> Option<TextureEntry> {
        self.texture.as_ref().map(|(_, texture)| TextureEntry::of("diffuse", &texture.texture))
    }

    fn upload(&mut self, gpu: &Gpu, base: &Image, levels: &[Image]) -> Texture {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("diffuse"),
            size: wgpu::Extent3d { width: base.width, height: base.height, depth_or_array_layers: 1 },
            mip_level_count: 1 + levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: mips::ROOT_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let images = std::iter::once(base).chain(levels).zip(0..);
        self.uploaded +=
            images.map(|(image, mip)| mips::upload(gpu, &texture, mip, 0, image, image.all())).sum::<u64>();
        Texture { texture, view }
    }
}

/// Takes the texels out of `diffuse` for a while; they are not copied.
fn image_of(diffuse: &mut Diffuse) -> Image {
    Image { width: diffuse.width, height: diffuse.height, rgba: std::mem::take(&mut diffuse.rgba) }
}
