//! The terrain's textures: heights, pyramid, crater layer. Each exists only while a frame needs it, and an edit uploads
//! only what it touched.

use crate::gpu::Gpu;
use crate::heightfield::{Crater, CraterLayer, Edit, EditedTerrain, HeightField, MaxPyramid, NodeRect, SampleRect};
use crate::scene::{CraterMode, CraterSettings};

use super::ledger::TextureEntry;

/// Format of heights, maxima and displacements.
const HEIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// The walk starts at the level whose longer side has at most this many nodes: higher levels save no step, and a
/// texture without them needs less padding.
const MOST_TOP_NODES: u32 = 16;

/// Bytes handed to the driver in one go, so that a large map needs no second copy of itself in staging memory.
const UPLOAD_BYTES: usize = 32 << 20;

/// A map on the CPU, with craters, and its copies on the GPU.
#[derive(Debug)]
pub(super) struct Ground {
    terrain: EditedTerrain,
    heights: Texture,
    /// Whether the heights on the GPU are those with the craters (the same as those without, while there are none).
    heights_have_craters: bool,
    pyramid: Option<Texture>,
    layer: Option<Layer>,
    uploaded: u64,
    changed: Option<SampleRect>,
}

/// A texture with its default view.
#[derive(Debug)]
pub(super) struct Texture {
    pub(super) texture: wgpu::Texture,
    pub(super) view: wgpu::TextureView,
}

/// The study's second texture, and what it was made from.
#[derive(Debug)]
struct Layer {
    craters: Vec<Crater>,
    resolution: u32,
    size: [u32; 2],
    rise: f32,
    texture: Texture,
}

impl Ground {
    pub(super) fn new(gpu: &Gpu, terrain: EditedTerrain) -> Self {
        let map = terrain.base();
        let heights = float_texture(gpu, "heights", [map.width(), map.height()], 1);
        let mut ground = Self {
            terrain,
            heights,
            heights_have_craters: true,
            pyramid: None,
            layer: None,
            uploaded: 0,
            changed: None,
        };
        ground.upload_heights(gpu);
        ground
    }

    /// The map on the CPU, with the craters of the last prepared frame.
    pub(super) fn terrain(&self) -> &EditedTerrain {
        &self.terrain
    }

    /// Brings the textures up to date with the scene's craters and drops what the frame does not need.
    pub(super) fn prepare(&mut self, gpu: &Gpu, craters: &CraterSettings, walks_pyramid: bool) {
        let edit = self.terrain.set_craters(&craters.list);
        if let Some(edit) = &edit {
            self.changed = Some(self.changed.map_or(edit.samples, |rect| rect.union(edit.samples)));
        }
        let layered = craters.mode == CraterMode::Layered && !craters.list.is_empty();
        let wants_craters = !layered;
        if wants_craters != self.heights_have_craters && !craters.list.is_empty() {
            self.heights_have_craters = wants_craters;
            self.upload_heights(gpu);
            self.pyramid = None;
        } else if let (true, Some(edit)) = (wants_craters, &edit) {
            self.heights_have_craters = true;
            self.upload_edit(gpu, edit);
        }
        match (walks_pyramid, self.pyramid.is_some()) {
            (true, false) => self.upload_pyramid(gpu),
            (false, true) => self.pyramid = None,
            _ => {}
        }
        if layered {
            self.prepare_layer(gpu, craters);
        } else {
            self.layer = None;
        }
    }

    /// The samples that craters have changed since the last call, on the CPU.
    pub(super) fn take_changed(&mut self) -> Option<SampleRect> {
        self.changed.take()
    }

    /// Bytes uploaded since the last call.
    pub(super) fn take_uploaded(&mut self) -> u64 {
        std::mem::take(&mut self.uploaded)
    }

    pub(super) fn heights(&self) -> &wgpu::TextureView {
        &self.heights.view
    }

    pub(super) fn pyramid(&self) -> Option<&wgpu::TextureView> {
        self.pyramid.as_ref().map(|pyramid| &pyramid.view)
    }

    /// The crater layer's view, cells along x and z, and highest displacement as a share of the box's height.
    pub(super) fn layer(&self) -> Option<(&wgpu::TextureView, [u32; 2], f32)> {
        self.layer.as_ref().map(|layer| (&layer.texture.view, layer.size.map(|side| side - 1), layer.rise))
    }

    /// The coarsest level of the pyramid that the walk uses.
    pub(super) fn top_level(&self) -> u32 {
        self.used_levels(self.terrain.pyramid())
    }

    /// The highest ground, normalised. With a layer it is not known without reading all of both, so it is the lid.
    pub(super) fn highest(&self) -> f32 {
        if self.layer.is_some() { 1.0 } else { self.terrain.pyramid().top() }
    }

    pub(super) fn list(&self, entries: &mut Vec<TextureEntry>) {
        entries.push(TextureEntry::of("heights", &self.heights.texture));
        entries.extend(self.pyramid.as_ref().map(|pyramid| TextureEntry::of("pyramid", &pyramid.texture)));
        entries.extend(self.layer.as_ref().map(|layer| TextureEntry::of("crater layer", &layer.texture.texture)));
    }

    /// The field that the GPU's heights are a copy of.
    fn resident(&self) -> &HeightField {
        if self.heights_have_craters { self.terrain.field() } else { self.terrain.base() }
    }

    fn upload_heights(&mut self, gpu: &Gpu) {
        let field = self.resident();
        let all = SampleRect { x: 0, y: 0, width: field.width(), height: field.height() };
        self.uploaded += upload(gpu, &self.heights.texture, 0, field.samples(), field.width(), all);
    }

    fn upload_edit(&mut self, gpu: &Gpu, edit: &Edit) {
        let field = self.terrain.field();
        self.uploaded += upload(gpu, &self.heights.texture, 0, field.samples(), field.width(), edit.samples);
        let Some(pyramid) = &self.pyramid else { return };
        let levels = self.terrain.pyramid().levels();
        for &NodeRect { level, x, y, width, height } in &edit.nodes {
            if level <= pyramid.texture.mip_level_count() {
                let data = &levels[level as usize - 1];
                let rect = SampleRect { x, y, width, height };
                self.uploaded += upload(gpu, &pyramid.texture, level - 1, &data.data, data.width, rect);
            }
        }
    }

    fn upload_pyramid(&mut self, gpu: &Gpu) {
        let of_base;
        let pyramid = if self.heights_have_craters || self.terrain.craters().is_empty() {
            self.terrain.pyramid()
        } else {
            of_base = MaxPyramid::build(self.terrain.base());
            &of_base
        };
        let levels = self.used_levels(pyramid);
        let finest = &pyramid.levels()[0];
        let size = [padded(finest.width, levels), padded(finest.height, levels)];
        let texture = float_texture(gpu, "pyramid", size, levels);
        for (mip, level) in (0..levels).zip(pyramid.levels()) {
            let all = SampleRect { x: 0, y: 0, width: level.width, height: level.height };
            self.uploaded += upload(gpu, &texture.texture, mip, &level.data, level.width, all);
        }
        self.pyramid = Some(texture);
    }

    fn used_levels(&self, pyramid: &MaxPyramid) -> u32 {
        let enough = pyramid.levels().iter().position(|level| level.width.max(level.height) <= MOST_TOP_NODES);
        enough.map_or(pyramid.levels().len(), |index| index + 1) as u32
    }

    fn prepare_layer(&mut self, gpu: &Gpu, craters: &CraterSettings) {
        let resolution = craters.layer_resolution.clamp(2, gpu.capabilities.max_texture);
        if self.layer.as_ref().is_some_and(|layer| layer.resolution == resolution && layer.craters == craters.list) {
            return;
        }
        let layer = CraterLayer::rasterise(&craters.list, self.terrain.base(), resolution);
        let size = [layer.width, layer.height];
        let texture = match self.layer.take() {
            Some(old) if old.size == size => old.texture,
            _ => float_texture(gpu, "crater layer", size, 1),
        };
        let all = SampleRect { x: 0, y: 0, width: size[0], height: size[1] };
        self.uploaded += upload(gpu, &texture.texture, 0, &layer.data, size[0], all);
        self.layer = Some(Layer { craters: craters.list.clone(), resolution, size, rise: layer.rise, texture });
    }
}

/// The side of mip 0 that makes every mip of a chain of `levels` large enough for a pyramid that rounds up: mips halve
/// rounding down, so the side must be divisible by two often enough, or be a power of two.
fn padded(side: u32, levels: u32) -> u32 {
    side.next_multiple_of(1 << (levels - 1)).min(side.next_power_of_two())
}

fn float_texture(gpu: &Gpu, label: &str, size: [u32; 2], mips: u32) -> Texture {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: mips,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: HEIGHT_FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Texture { texture, view }
}

/// Copies `rect` of a grid of floats, `stride` to a row, into a mip of `texture`; returns the bytes copied.
fn upload(gpu: &Gpu, texture: &wgpu::Texture, mip: u32, data: &[f32], stride: u32, rect: SampleRect) -> u64 {
    let row_bytes = stride as usize * size_of::<f32>();
    let rows_at_once = (UPLOAD_BYTES / row_bytes).max(1) as u32;
    let mut y = rect.y;
    while y < rect.y + rect.height {
        let height = rows_at_once.min(rect.y + rect.height - y);
        let first = y as usize * stride as usize;
        let rows = &data[first..first + height as usize * stride as usize];
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: mip,
                origin: wgpu::Origin3d { x: rect.x, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(rows),
            wgpu::TexelCopyBufferLayout {
                offset: u64::from(rect.x) * size_of::<f32>() as u64,
                bytes_per_row: Some(row_bytes as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { width: rect.width, height, depth_or_array_layers: 1 },
        );
        y += height;
        if y < rect.y + rect.height {
            // Staging memory is only given back with a submission.
            gpu.queue.submit([]);
        }
    }
    u64::from(rect.width) * u64::from(rect.height) * size_of::<f32>() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mip_holds_its_level() {
        for side in 1..=3000 {
            for levels in 1..=12 {
                let padded = padded(side, levels);
                assert!(padded <= 2 * side, "{side} grows to {padded}");
                for mip in 0..levels {
                    assert!(
                        (padded >> mip).max(1) >= side.div_ceil(1 << mip),
                        "side {side}, {levels} levels, mip {mip}"
                    );
                }
            }
        }
    }
}
