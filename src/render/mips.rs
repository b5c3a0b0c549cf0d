//! Mip chains of sRGB images, averaged in linear light, and their textures.
//!
//! Textures hold square roots of linear light: a shader squares them in one instruction, where decoding sRGB texel by
//! texel is the dearest part of a lookup in software. The eight bits lie much as those of sRGB do; some dark bytes change
//! by one. Between texels the roots are interpolated, not the light: edges come out a little darker.

use std::sync::LazyLock;

use image::ImageDecoder;
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

/// The chain below an image whose opacity counts: what is transparent has no colour to mix in.
pub(super) fn translucent_chain(base: &Image) -> Vec<Image> {
    let mut levels = chain(base);
    for index in 0..levels.len() {
        let (finer, rest) = levels.split_at_mut(index);
        let (finer, level) = (finer.last().unwrap_or(base), &mut rest[0]);
        let width = level.width;
        level.rgba.par_chunks_exact_mut(4).enumerate().for_each(|(texel, rgba)| {
            if let Some(mixed) = mixed(finer, texel as u32 % width, texel as u32 / width) {
                rgba.copy_from_slice(&mixed);
            }
        });
    }
    levels
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

/// The mean of the 2×2 texels of which (`x`, `y`) is made, where one of them is not opaque.
fn mixed(finer: &Image, x: u32, y: u32) -> Option<[u8; 4]> {
    let texel = |index: u32| {
        let (column, line) = ((2 * x + index % 2).min(finer.width - 1), (2 * y + index / 2).min(finer.height - 1));
        let first = (line as usize * finer.width as usize + column as usize) * 4;
        <[u8; 4]>::try_from(finer.rgba.get(first..first + 4)?).ok()
    };
    let texels = [texel(0)?, texel(1)?, texel(2)?, texel(3)?];
    if texels.iter().all(|texel| texel[3] == 255) {
        return None;
    }
    let weight: f32 = texels.iter().map(|texel| f32::from(texel[3])).sum();
    let channel = |channel: usize| {
        let light = |texel: &[u8; 4]| LINEAR[usize::from(texel[channel])] * f32::from(texel[3]);
        encode(texels.iter().map(light).sum::<f32>() / weight.max(1.0))
    };
    Some([channel(0), channel(1), channel(2), (weight * 0.25).round() as u8])
}

/// Copies `rect` of `image` into a mip and layer of `texture`, of [`ROOT_FORMAT`]; returns the bytes copied.
pub(super) fn upload(gpu: &Gpu, texture: &wgpu::Texture, mip: u32, layer: u32, image: &Image, rect: SampleRect) -> u64 {
    let stride = image.width as usize * 4;
    let row_bytes = rect.width as usize * 4;
    let mut roots = vec![0; row_bytes * rect.height as usize];
    roots.par_chunks_mut(row_bytes).enumerate().with_min_len(16).for_each(|(row, roots)| {
        let texels = &image.rgba[(rect.y as usize + row) * stride + rect.x as usize * 4..][..row_bytes];
        roots.iter_mut().zip(texels).for_each(|(root, &byte)| *root = ROOT[usize::from(byte)]);
        // Opacity is no light.
        roots.iter_mut().zip(texels).skip(3).step_by(4).for_each(|(root, &byte)| *root = byte);
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

    /// Mean linear light of the texels within a sixteenth of the image around a place, `u` and `v` 0 to 1.
    pub(super) fn around(&self, u: f32, v: f32) -> glam::Vec3 {
        let range = |at: f32, side: u32| {
            let place = |at: f32| ((at * side as f32) as u32).min(side.saturating_sub(1));
            place((at - 0.0625).max(0.0))..=place(at + 0.0625)
        };
        let (mut sum, mut count) = (glam::Vec3::ZERO, 0.0);
        for y in range(v, self.height) {
            for x in range(u, self.width) {
                let first = (y as usize * self.width as usize + x as usize) * 4;
                if let Some(&[r, g, b]) = self.rgba.get(first..first + 3) {
                    sum += glam::Vec3::from([r, g, b].map(|byte| LINEAR[usize::from(byte)]));
                    count += 1.0;
                }
            }
        }
        sum / f32::max(count, 1.0)
    }

    /// Reads an image file whose channels are weights: one that the image does not have is 0. A grey image has one, red.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(super) fn read_weights(path: &std::path::Path, largest: u32) -> Result<Self, String> {
        let (mut image, colours) = Self::read_with_colours(path, largest)?;
        image.rgba.chunks_exact_mut(4).for_each(|texel| {
            if !colours.has_alpha() {
                texel[3] = 0;
            }
            if !colours.has_color() {
                (texel[1], texel[2]) = (0, 0);
            }
        });
        Ok(image)
    }

    /// Reads an image file of any format and depth that the `image` crate knows.
    ///
    /// # Errors
    /// What is wrong with the file, for people.
    pub(super) fn read(path: &std::path::Path, largest: u32) -> Result<Self, String> {
        Ok(Self::read_with_colours(path, largest)?.0)
    }

    fn read_with_colours(path: &std::path::Path, largest: u32) -> Result<(Self, image::ColorType), String> {
        // Before opening, because opening a pipe waits for its writer.
        if !std::fs::metadata(path).map_err(|error| error.to_string())?.is_file() {
            return Err("it is not a file".into());
        }
        let file = std::fs::File::open(path).map_err(|error| error.to_string())?;
        Self::decode(std::io::BufReader::new(file), largest)
    }

    /// Decodes an image of at most `largest` pixels a side. What its header announces is judged before memory is taken.
    fn decode(file: impl std::io::BufRead + std::io::Seek, largest: u32) -> Result<(Self, image::ColorType), String> {
        let mut reader = image::ImageReader::new(file).with_guessed_format().map_err(|error| error.to_string())?;
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(MOST_IMAGE_BYTES);
        reader.limits(limits.clone());
        let mut decoder = reader.into_decoder().map_err(|error| one_line(&error))?;
        let (width, height) = decoder.dimensions();
        if width > largest || height > largest {
            return Err(format!("it has {width}×{height} pixels, but this adapter's textures end at {largest}"));
        }
        let bytes = decoder.total_bytes().max(4 * u64::from(width) * u64::from(height));
        if bytes > MOST_IMAGE_BYTES {
            let most = MOST_IMAGE_BYTES >> 20;
            return Err(format!("its {width}×{height} pixels take {} MiB, but at most {most} are read", bytes >> 20));
        }
        decoder.set_limits(limits).map_err(|error| one_line(&error))?;
        let image = image::DynamicImage::from_decoder(decoder).map_err(|error| one_line(&error))?;
        let colours = image.color();
        let rgba = image.into_rgba8();
        Ok((Self { width: rgba.width(), height: rgba.height(), rgba: rgba.into_raw() }, colours))
    }
}

/// Most bytes that an image may take: 11585×11585 pixels of 4 bytes each.
const MOST_IMAGE_BYTES: u64 = 512 << 20;

/// A decoder's message, which may have several lines.
fn one_line(error: &image::ImageError) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_transparent_has_no_colour() {
        let rgba = [[200, 100, 50, 255], [0, 0, 0, 0], [0, 0, 0, 0], [200, 100, 50, 255]].concat();
        let base = Image { width: 2, height: 2, rgba };
        assert_eq!(translucent_chain(&base)[0].rgba, [200, 100, 50, 128]);
        let opaque = Image { width: 2, height: 2, rgba: vec![90; 12].into_iter().chain([255; 4]).collect() };
        let opaque = Image { rgba: opaque.rgba.chunks(4).flat_map(|t| [t[0], t[1], t[2], 255]).collect(), ..opaque };
        assert_eq!(translucent_chain(&opaque)[0].rgba, chain(&opaque)[0].rgba);
    }

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

    fn written(format: image::ImageFormat) -> Vec<u8> {
        let picture =
            image::RgbImage::from_fn(33, 21, |x, y| image::Rgb([(x * 7) as u8, (y * 11) as u8, (x ^ y) as u8]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::DynamicImage::ImageRgb8(picture).write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    /// Textures and faces of the sky come from anywhere.
    #[test]
    fn mutated_images_end_in_an_image_or_a_message() {
        use image::ImageFormat::{Jpeg, Png, WebP};
        let files = [Png, Jpeg, WebP].map(written);
        let mut seed = 1u64;
        let mut below = |end: usize| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed % end as u64) as usize
        };
        let cases = std::env::var("RELIEF_FUZZ_CASES").map_or(3000, |cases| cases.parse().unwrap());
        let mut decoded = 0;
        for case in 0..cases {
            let mut bytes = files[case % files.len()].clone();
            for _ in 0..=below(3) {
                let at = below(bytes.len());
                match below(4) {
                    0 => bytes[at] ^= 1 << below(8),
                    1 => bytes[at] = below(256) as u8,
                    2 => bytes.truncate(at.max(4)),
                    _ => {
                        let end = bytes.len().min(at + 2);
                        bytes[at..end].fill(0xff);
                    }
                }
            }
            match Image::decode(std::io::Cursor::new(&bytes), 4096) {
                Ok((image, _)) => {
                    decoded += 1;
                    assert!(image.width.max(image.height) <= 4096);
                    assert_eq!(image.rgba.len() as u64, 4 * u64::from(image.width) * u64::from(image.height));
                }
                Err(reason) => assert!(!reason.is_empty() && reason.lines().count() == 1, "{reason:?}"),
            }
        }
        println!("{cases} images, {decoded} of them decode");
        assert!(decoded > cases / 20, "only {decoded} of {cases}");
    }

    #[test]
    fn what_an_image_announces_is_judged_before_memory_is_taken() {
        let mut png = written(image::ImageFormat::Png);
        let announce = |png: &mut Vec<u8>, width: u32, height: u32| {
            png[16..20].copy_from_slice(&width.to_be_bytes());
            png[20..24].copy_from_slice(&height.to_be_bytes());
            // The header's checksum.
            let sum = !png[12..29].iter().fold(!0u32, |sum, &byte| {
                (0..8).fold(sum ^ u32::from(byte), |s, _| if s & 1 == 1 { s >> 1 ^ 0xedb8_8320 } else { s >> 1 })
            });
            png[29..33].copy_from_slice(&sum.to_be_bytes());
        };
        let refusal = |png: &[u8], largest| Image::decode(std::io::Cursor::new(png), largest).unwrap_err();
        announce(&mut png, 40_000, 2);
        assert!(refusal(&png, 8192).contains("40000×2 pixels, but this adapter's textures end at 8192"));
        announce(&mut png, 16_384, 16_384);
        let message = refusal(&png, 16_384);
        assert!(message.contains("1024 MiB") && message.contains("512"), "{message}");
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Image::read(folder.path(), 64).unwrap_err(), "it is not a file");
    }

    #[test]
    fn black_and_white_average_to_middle_grey_in_linear_light() {
        let texel = |v: u8| [v, v, v, 255];
        let base = Image { width: 2, height: 2, rgba: [texel(0), texel(255), texel(255), texel(0)].concat() };
        assert_eq!(chain(&base)[0].rgba, texel(188));
    }
}
