//! Mip chains of sRGB images, averaged in linear light, and their textures.
//!
//! Textures hold square roots of linear light: a shader squares them in one instruction, where decoding sRGB texel by
//! texel is the dearest part of a lookup in software. The eight bits lie much as those of sRGB do; some dark bytes change
//! by one. Between texels the roots are interpolated, not the light: edges come out a little darker.

use std::sync::LazyLock;

use rayon::prelude::*;

use crate::gpu::Gpu;
use crate::heightfield::SampleRect;

/// An 8-bit sRGB RGBA image.
#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) rgba: Vec<u8>,
}

/// Linear light of each sRGB byte.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let c = byte as f32 / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
});

/// Format of a texture of square roots.
pub(super) const ROOT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Square root of the linear light of each sRGB byte, of 255.
static ROOT: LazyLock<[u8; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| (LINEAR[byte].sqrt() * 255.0).round() as u8));

/// sRGB byte of linear light in 0..1, by a table fine enough for 8 bits.
static ENCODED: LazyLock<Vec<u8>> =
    LazyLock::new(|| (0..=ENCODED_STEPS).map(|i| encode(i as f32 / ENCODED_STEPS as f32)).collect());
const ENCODED_STEPS: usize = 1 << 14;

/// sRGB byte of linear light.
pub(super) fn encode(c: f32) -> u8 {
    let c = c.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// The chain below `base` down to one texel: each level halves, rounding down, and averages 2×2 texels.
pub(super) fn chain(base: &Image) -> Vec<Image> {
    let mut levels: Vec<Image> = Vec::new();
    loop {
        let finer = levels.last().unwrap_or(base);
        if finer.width == 1 && finer.height == 1 {
            return levels;
        }
        let (width, height) = ((finer.width / 2).max(1), (finer.height / 2).max(1));
        let mut level = Image { width, height, rgba: vec![0; width as usize * height as usize * 4] };
        average(finer, &mut level, SampleRect { x: 0, y: 0, width, height });
        levels.push(level);
    }
}

/// Recomputes the texels of `levels` above `rect` of `base`; returns the rectangle of each level.
pub(super) fn update(base: &Image, levels: &mut [Image], rect: SampleRect) -> Vec<SampleRect> {
    let mut rect = rect;
    let mut rects = Vec::new();
    for index in 0..levels.len() {
        let (finer, rest) = levels.split_at_mut(index);
        let level = &mut rest[0];
        let (right, bottom) = (rect.x + rect.width, rect.y + rect.height);
        let (x, y) = ((rect.x / 2).min(level.width - 1), (rect.y / 2).min(level.height - 1));
        rect = SampleRect {
            x,
            y,
            width: right.div_ceil(2).clamp(x + 1, level.width) - x,
            height: bottom.div_ceil(2).clamp(y + 1, level.height) - y,
        };
        average(finer.last().unwrap_or(base), level, rect);
        rects.push(rect);
    }
    rects
}

fn average(finer: &Image, level: &mut Image, rect: SampleRect) {
    let width = level.width as usize * 4;
    let rows = rect.y as usize * width..(rect.y + rect.height) as usize * width;
    level.rgba[rows].par_chunks_mut(width).enumerate().for_each(|(offset, row)| {
        let y = rect.y + offset as u32;
        for x in rect.x..rect.x + rect.width {
            for channel in 0..3 {
                let texel = |i: u32, j: u32| {
                    let (column, line) = ((2 * x + i).min(finer.width - 1), (2 * y + j).min(finer.height - 1));
                    LINEAR[usize::from(
                        finer.rgba[(line as usize * finer.width as usize + column as usize) * 4 + channel],
                    )]
                };
                let mean = 0.25 * (texel(0, 0) + texel(1, 0) + texel(0, 1) + texel(1, 1));
                row[x as usize * 4 + channel] = ENCODED[(mean * ENCODED_STEPS as f32).round() as usize];
            }
            row[x as usize * 4 + 3] = 255;
        }
    });
}

/// Copies `rect` of `image` into a mip and layer of `texture`, of [`ROOT_FORMAT`]; returns the bytes copied.
pub(super) fn upload(gpu: &Gpu, texture: &wgpu::Texture, mip: u32, layer: u32, image: &Image, rect: SampleRect) -> u64 {
    let stride = image.width as usize * 4;
    let row_bytes = rect.width as usize * 4;
    let mut roots = vec![0; row_bytes * rect.height as usize];
    roots.par_chunks_mut(row_bytes).enumerate().with_min_len(16).for_each(|(row, roots)| {
        let texels = &image.rgba[(rect.y as usize + row) * stride + rect.x as usize * 4..][..row_bytes];
        roots.iter_mut().zip(texels).for_each(|(root, &byte)| *root = ROOT[usize::from(byte)]);
    });
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: mip,
            origin: wgpu::Origin3d { x: rect.x, y: rect.y, z: layer },
            aspect: wgpu::TextureAspect::All,
        },
        &roots,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes as u32), rows_per_image: None },
        wgpu::Extent3d { width: rect.width, height: rect.height, depth_or_array_layers: 1 },
    );
    u64::from(rect.width) * u64::from(rect.height) * 4
}

impl Image {
    /// The rectangle of all texels.
    pub(super) fn all(&self) -> SampleRect {
        SampleRect { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Reads an image file of any format and depth that the `image` crate knows.
    ///
    /// # Errors
    /// What is wrong with the file, for people.
    pub(super) fn read(path: &std::path::Path, largest: u32) -> Result<Self, String> {
        let reader = image::ImageReader::open(path).map_err(|error| error.to_string())?;
        let reader = reader.with_guessed_format().map_err(|error| error.to_string())?;
        let image = reader.decode().map_err(|error| error.to_string())?;
        if image.width() > largest || image.height() > largest {
            return Err(format!(
                "it has {}×{} pixels, but this adapter's textures end at {largest}",
                image.width(),
                image.height()
            ));
        }
        let rgba = image.into_rgba8();
        Ok(Self { width: rgba.width(), height: rgba.height(), rgba: rgba.into_raw() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_update_equals_a_fresh_chain() {
        let mut base = Image { width: 37, height: 21, rgba: (0..37 * 21 * 4).map(|i| (i * 31 % 251) as u8).collect() };
        base.rgba.chunks_exact_mut(4).for_each(|texel| texel[3] = 255);
        let mut levels = chain(&base);
        for rect in [(0, 0, 3, 3), (30, 15, 7, 6), (36, 20, 1, 1), (11, 4, 9, 8)] {
            let rect = SampleRect { x: rect.0, y: rect.1, width: rect.2, height: rect.3 };
            for y in rect.y..rect.y + rect.height {
                for x in rect.x..rect.x + rect.width {
                    base.rgba[((y * 37 + x) * 4) as usize] ^= 0x5a;
                }
            }
            update(&base, &mut levels, rect);
            for (updated, fresh) in levels.iter().zip(chain(&base)) {
                assert_eq!(updated.rgba, fresh.rgba, "{rect:?}, level {}×{}", fresh.width, fresh.height);
            }
        }
    }

    #[test]
    fn black_and_white_average_to_middle_grey_in_linear_light() {
        let texel = |v: u8| [v, v, v, 255];
        let base = Image { width: 2, height: 2, rgba: [texel(0), texel(255), texel(255), texel(0)].concat() };
        assert_eq!(chain(&base)[0].rgba, texel(188));
    }
}
