//! The pattern that layers of clouds are cut from: density with an even distribution, and how it changes around a place.

use std::sync::{Arc, LazyLock};

use glam::DVec2;
use rayon::prelude::*;

use crate::gpu::Gpu;
use crate::heightfield::HeightField;

use super::ground::Texture;
use super::materials::noise;

/// Texels along a side.
pub(super) const SIDE: usize = 512;

/// Texels ahead and behind whose densities are compared.
const STRIDE: usize = 5;

/// Levels of detail of four bytes to a texel: density, its differences along u and v, nothing.
#[derive(Debug)]
pub(super) struct Pattern {
    levels: Vec<Vec<[u8; 4]>>,
}

/// Noise that has the look of heaps: octaves whose creases are turned down, bent by others. Made once in a program.
pub(super) fn of_noise() -> Arc<Pattern> {
    static NOISE: LazyLock<Arc<Pattern>> = LazyLock::new(|| {
        let at = |x: usize, y: usize| {
            let place = [x, y].map(|at| at as f32 / SIDE as f32);
            let bent = [7, 13].map(|seed| 0.035 * noise::fractal(seed, [3, 3], 4, 0.5, place));
            let bent = [place[0] + bent[0], place[1] + bent[1]];
            let heaps = -noise::ridged(31, [5, 5], 6, 0.6, bent);
            noise::fractal(3, [3, 3], 7, 0.55, bent) + 0.55 * heaps
        };
        Arc::new(Pattern::new(&at))
    });
    Arc::clone(&NOISE)
}

/// The pattern of a map.
#[derive(Clone, Debug)]
pub(super) struct MapPattern {
    map: Arc<HeightField>,
    pattern: Arc<Pattern>,
}

impl MapPattern {
    /// Finds it, which takes some hundredths of a second: no frame should.
    pub(super) fn new(map: &Arc<HeightField>) -> Self {
        Self { map: Arc::clone(map), pattern: Arc::new(of_map(map)) }
    }

    /// The pattern, if it is that of `map`.
    pub(super) fn of(&self, map: &Arc<HeightField>) -> Option<Arc<Pattern>> {
        Arc::ptr_eq(&self.map, map).then(|| Arc::clone(&self.pattern))
    }
}

/// The heights of `map`, mirrored, so that the pattern closes at its borders.
fn of_map(map: &HeightField) -> Pattern {
    let half = (SIDE / 2) as f64;
    let mirrored = |at: usize| 1.0 - (at as f64 / half - 1.0).abs();
    Pattern::new(&|x, y| map.surface_height(mirrored(x), mirrored(y)) as f32)
}

impl Pattern {
    fn new(at: &(dyn Fn(usize, usize) -> f32 + Sync)) -> Self {
        let raw: Vec<f32> = (0..SIDE * SIDE).into_par_iter().map(|index| at(index % SIDE, index / SIDE)).collect();
        let even = evened(&raw);
        let wrapped = |x: usize, y: usize| even[(y % SIDE) * SIDE + x % SIDE];
        let base: Vec<[u8; 4]> = (0..SIDE * SIDE)
            .into_par_iter()
            .map(|index| {
                let (x, y) = (index % SIDE, index / SIDE);
                let along = wrapped(x + STRIDE, y) - wrapped(x + SIDE - STRIDE, y);
                let down = wrapped(x, y + STRIDE) - wrapped(x, y + SIDE - STRIDE);
                let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
                [byte(even[index]), byte(0.5 + 0.5 * along), byte(0.5 + 0.5 * down), 0]
            })
            .collect();
        let mut levels = vec![base];
        let mut side = SIDE;
        while side > 1 {
            let finer = levels.last().map_or(&[][..], Vec::as_slice);
            let mean = |index| -> [u8; 4] {
                let (x, y) = (index % (side / 2) * 2, index / (side / 2) * 2);
                let texels: [[u8; 4]; 4] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| finer[(y + j) * side + x + i]);
                std::array::from_fn(|c| ((texels.iter().map(|texel| u32::from(texel[c])).sum::<u32>() + 2) / 4) as u8)
            };
            let level = (0..side * side / 4).map(mean).collect();
            levels.push(level);
            side /= 2;
        }
        Self { levels }
    }

    /// Density at a place of the plane of tiles, interpolated as a sampler does.
    pub(super) fn density(&self, place: DVec2) -> f64 {
        let at = (place - place.floor()) * SIDE as f64 - 0.5;
        let (first, part) = (at.floor(), at - at.floor());
        let texel = |i: i64, j: i64| {
            let index = |at: f64, step: i64| (at as i64 + step).rem_euclid(SIDE as i64) as usize;
            let base = self.levels.first().map_or(&[][..], Vec::as_slice);
            base.get(index(first.y, j) * SIDE + index(first.x, i)).map_or(0.0, |texel| f64::from(texel[0]) / 255.0)
        };
        let row = |j| texel(0, j) * (1.0 - part.x) + texel(1, j) * part.x;
        row(0) * (1.0 - part.y) + row(1) * part.y
    }

    /// The texture, and the bytes uploaded.
    pub(super) fn upload(&self, gpu: &Gpu) -> (Texture, u64) {
        let side = SIDE as u32;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("clouds"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            mip_level_count: self.levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let mut bytes = 0;
        for (level, mip) in self.levels.iter().zip(0..) {
            let side = side >> mip;
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: mip,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(level),
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side * 4), rows_per_image: None },
                wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            );
            bytes += level.len() as u64 * 4;
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        (Texture { texture, view }, bytes)
    }
}

/// Each value's rank, 0 to 1: of a threshold in it, the share above is known.
fn evened(raw: &[f32]) -> Vec<f32> {
    let mut order: Vec<u32> = (0..raw.len() as u32).collect();
    order.par_sort_by(|&a, &b| raw[a as usize].total_cmp(&raw[b as usize]).then(a.cmp(&b)));
    let mut even = vec![0.0; raw.len()];
    let most = raw.len().saturating_sub(1).max(1) as f32;
    // Equal ones share the middle of their ranks.
    let mut first = 0;
    for run in order.chunk_by(|&a, &b| raw[a as usize] == raw[b as usize]) {
        let middle = (first as f32 + 0.5 * (run.len() - 1) as f32) / most;
        run.iter().for_each(|&index| even[index as usize] = middle);
        first += run.len();
    }
    even
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of the sky above a threshold is what a layer's cover says.
    #[test]
    fn densities_are_even_and_close_at_the_borders() {
        let pattern = of_noise();
        for free in [0.1, 0.5, 0.8] {
            let above = pattern.levels[0].iter().filter(|texel| f64::from(texel[0]) / 255.0 > free).count();
            let share = above as f64 / (SIDE * SIDE) as f64;
            assert!((share - (1.0 - free)).abs() < 0.01, "{share} above {free}");
        }
        let far = (0..SIDE).map(|y| {
            let row = &pattern.levels[0][y * SIDE..(y + 1) * SIDE];
            (i32::from(row[0][0]) - i32::from(row[SIDE - 1][0])).abs()
        });
        assert!(far.max().unwrap() < 40, "a seam");
        assert_eq!(pattern.levels.last().map(Vec::len), Some(1));
        let place = DVec2::new(3.5 / SIDE as f64, 7.5 / SIDE as f64);
        assert!((pattern.density(place + 2.0) - f64::from(pattern.levels[0][7 * SIDE + 3][0]) / 255.0).abs() < 1e-9);
    }
}
