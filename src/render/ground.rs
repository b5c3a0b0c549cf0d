//! The terrain's textures: heights, pyramid, cones, crater layer. Each exists only while a frame needs it, and an edit
//! uploads only what it touched.

use std::sync::Arc;

use rayon::prelude::*;

use crate::gpu::Gpu;
use crate::heightfield::bounds::{Rule, SurfaceBounds};
use crate::heightfield::fractal::Detail;
use crate::heightfield::{
    ConeKind, ConeMap, Crater, CraterLayer, Edit, EditedTerrain, HeightField, MaxPyramid, NodeRect, SampleRect,
};
use crate::scene::{CraterMode, CraterSettings};

use super::cones::{ConeGround, Cones, layer_resolution};
use super::ledger::TextureEntry;
use super::pyramid_layout::{MOST_TOP_NODES, PyramidLayout};

/// Format of heights and maxima that need floats, and of displacements.
const FLOAT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
/// Format of heights and maxima that 16 bits hold.
const UNITS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Unorm;

/// What stands in the texture of heights where the map has a hole.
const HOLE: f32 = -1.0;

/// Bytes handed to the driver in one go, so that a large map needs no second copy of itself in staging memory.
const UPLOAD_BYTES: usize = 32 << 20;

/// A map on the CPU, with craters, and its copies on the GPU.
#[derive(Debug)]
pub(super) struct Ground {
    terrain: EditedTerrain,
    /// Textures hold heights as whole numbers of 1/`units`, in 16 bits; `None`: as floats.
    units: Option<u16>,
    heights: Texture,
    /// Whether the heights on the GPU are those with the craters (the same as those without, while there are none).
    heights_have_craters: bool,
    pyramid: Option<Texture>,
    /// What the pyramid holds where it bounds other surfaces, too: of the heights that are on the GPU.
    bounds: Option<SurfaceBounds>,
    /// The detail that goes on as the map leaves off, of strength 1.
    detail: Option<Detail>,
    cones: Cones,
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
        // Whole numbers have none to spare for a hole.
        let units = map.units().filter(|_| gpu.capabilities.unorm16 && map.holes().is_none());
        let format = if units.is_some() { UNITS_FORMAT } else { FLOAT_FORMAT };
        let heights = empty_texture(gpu, "heights", [map.width(), map.height()], format);
        let mut ground = Self {
            units,
            terrain,
            heights,
            heights_have_craters: true,
            pyramid: None,
            bounds: None,
            detail: None,
            cones: Cones::default(),
            layer: None,
            uploaded: 0,
            changed: None,
        };
        ground.upload_heights(gpu);
        ground
    }

    /// The detail of this strength that goes on as the map leaves off; measured once.
    pub(super) fn detail(&mut self, strength: f64) -> Detail {
        let base = self.terrain.base();
        let usual = *self.detail.get_or_insert_with(|| Detail::of(base, 1.0));
        Detail { amplitude: usual.amplitude * strength, ..usual }
    }

    /// The detail of the frame that was prepared last.
    pub(super) fn prepared_detail(&self) -> Option<Detail> {
        self.bounds.as_ref().and_then(|bounds| bounds.rule().detail)
    }

    /// Makes sure that there is room for the pyramid, too, which the first frame may need: were that the first to be
    /// refused, the terrain before would be gone already. Bytes of both.
    pub(super) fn try_room(&self, gpu: &Gpu) -> u64 {
        let format = self.heights.texture.format();
        let pyramid = empty_texture(gpu, "pyramid", self.pyramid_layout().size(), format);
        [&self.heights.texture, &pyramid.texture].map(|texture| TextureEntry::of("", texture).bytes).iter().sum()
    }

    /// The map on the CPU, with the craters of the last prepared frame.
    pub(super) fn terrain(&self) -> &EditedTerrain {
        &self.terrain
    }

    /// Brings the textures up to date with the scene's craters and drops what the frame does not need. The
    /// pyramid bounds the surfaces of `rule`, and the bilinear one in any case.
    pub(super) fn prepare(&mut self, gpu: &Gpu, craters: &CraterSettings, walks_pyramid: bool, rule: Rule) {
        if rule != self.bounds.as_ref().map(SurfaceBounds::rule).unwrap_or_default() {
            (self.bounds, self.pyramid) = (None, None);
        }
        let edit = self.terrain.set_craters(&craters.list);
        if let Some(edit) = &edit {
            self.changed = Some(self.changed.map_or(edit.samples, |rect| rect.union(edit.samples)));
        }
        let layered = craters.mode == CraterMode::Layered && !craters.list.is_empty();
        let wants_craters = !layered;
        if wants_craters != self.heights_have_craters && !craters.list.is_empty() {
            self.heights_have_craters = wants_craters;
            self.upload_heights(gpu);
            (self.bounds, self.pyramid) = (None, None);
        } else if let (true, Some(edit)) = (wants_craters, &edit) {
            self.heights_have_craters = true;
            self.upload_edit(gpu, edit);
        }
        if rule.is_any() && self.bounds.is_none() {
            self.bounds = Some(SurfaceBounds::new(self.resident(), rule));
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

    /// Brings the textures of the cones up to date with the ground of these craters, or drops them. Where the cones are not
    /// known this finds them, which can take seconds, and longer on a large map.
    pub(super) fn prepare_cones(
        &mut self,
        gpu: &Gpu,
        craters: &CraterSettings,
        needed: &[ConeKind],
        progress: &(dyn Fn(f32) + Sync),
    ) {
        if needed.is_empty() {
            self.cones.drop_textures();
            return;
        }
        let ground = self.cone_ground(gpu, craters);
        self.uploaded += self.cones.prepare(gpu, needed, &ground, progress);
    }

    /// What the cones stand on while the scene has these craters.
    pub(super) fn cone_ground(&self, gpu: &Gpu, craters: &CraterSettings) -> ConeGround {
        ConeGround::new(self.terrain.base(), craters, gpu.capabilities.max_texture)
    }

    /// The cone maps that are known.
    pub(super) fn known_cones(&self) -> &Cones {
        &self.cones
    }

    /// Takes a cone map that was found elsewhere.
    pub(super) fn set_cones(&mut self, ground: ConeGround, map: Arc<ConeMap>) {
        self.cones.keep(ground, map);
    }

    pub(super) fn cones(&self, kind: ConeKind) -> Option<&wgpu::TextureView> {
        self.cones.view(kind)
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

    /// Whether the map has holes. No edit makes or fills one.
    pub(super) fn has_holes(&self) -> bool {
        self.terrain.base().holes().is_some()
    }

    /// The coarsest level of the pyramid that the walk uses.
    fn top_level(&self) -> u32 {
        let levels = self.terrain.pyramid().levels();
        let enough = levels.iter().position(|level| level.width.max(level.height) <= MOST_TOP_NODES);
        enough.map_or(levels.len(), |index| index + 1) as u32
    }

    /// Textures hold heights as whole numbers of 1/`units`, in 16 bits; `None`: as floats.
    pub(super) fn units(&self) -> Option<u16> {
        self.units
    }

    /// The height, as a share of the box's, that the textures' 1 stands for.
    pub(super) fn height_unit(&self) -> f64 {
        self.units.map_or(1.0, |units| f64::from(u16::MAX) / f64::from(units))
    }

    /// Side in cells of a node of that level.
    pub(super) fn top_size(&self) -> f32 {
        (1u32 << self.top_level()) as f32
    }

    /// How the pyramid's levels lie in their texture.
    pub(super) fn pyramid_layout(&self) -> PyramidLayout {
        let finest = &self.terrain.pyramid().levels()[0];
        PyramidLayout::new([finest.width, finest.height], self.top_level())
    }

    /// The highest ground, normalised. With a layer it is not known without reading all of both, and
    /// invented detail is cut off by the box alone: so it is the lid.
    pub(super) fn highest(&self) -> f32 {
        let raised = self.bounds.as_ref().is_some_and(|bounds| bounds.rule().detail.is_some());
        if self.layer.is_some() || raised { 1.0 } else { self.terrain.pyramid().top() }
    }

    pub(super) fn list(&self, entries: &mut Vec<TextureEntry>) {
        entries.push(TextureEntry::of("heights", &self.heights.texture));
        entries.extend(self.pyramid.as_ref().map(|pyramid| TextureEntry::of("pyramid", &pyramid.texture)));
        entries.extend(self.cones.entries());
        entries.extend(self.layer.as_ref().map(|layer| TextureEntry::of("crater layer", &layer.texture.texture)));
    }

    /// The field that the GPU's heights are a copy of.
    fn resident(&self) -> &HeightField {
        if self.heights_have_craters { self.terrain.field() } else { self.terrain.base() }
    }

    fn upload_heights(&mut self, gpu: &Gpu) {
        let field = self.resident();
        let all = SampleRect { x: 0, y: 0, width: field.width(), height: field.height() };
        self.uploaded += self.upload_samples(gpu, field, all);
    }

    /// Copies the samples `rect` of `field` into the texture of heights.
    fn upload_samples(&self, gpu: &Gpu, field: &HeightField, rect: SampleRect) -> u64 {
        let Some(holes) = field.holes() else {
            return self.upload(gpu, &self.heights, [0, 0], field.samples(), field.width(), rect);
        };
        let mut bytes = 0;
        for piece in pieces(rect, size_of::<f32>()) {
            let mut marked = vec![0f32; rect.width as usize * piece.height as usize];
            marked.par_chunks_mut(rect.width as usize).enumerate().for_each(|(row, marked)| {
                let first = (piece.y as usize + row) * field.width() as usize + rect.x as usize;
                for ((offset, marked), &height) in marked.iter_mut().enumerate().zip(&field.samples()[first..]) {
                    *marked = if holes.contains(first + offset) { HOLE } else { height };
                }
            });
            let all = SampleRect { x: 0, y: 0, ..piece };
            bytes += upload(gpu, &self.heights.texture, [piece.x, piece.y], &marked, rect.width, all);
            if piece.y + piece.height < rect.y + rect.height {
                give_staging_back(gpu);
            }
        }
        bytes
    }

    /// Copies `rect` of a grid of heights into a texture of [`Self::units`]; see [`upload`].
    fn upload(
        &self,
        gpu: &Gpu,
        Texture { texture, .. }: &Texture,
        place: [u32; 2],
        heights: &[f32],
        stride: u32,
        rect: SampleRect,
    ) -> u64 {
        let Some(units) = self.units.map(f32::from) else {
            return upload(gpu, texture, place, heights, stride, rect);
        };
        let (end, mut bytes) = (rect.y + rect.height, 0);
        for SampleRect { y, height, .. } in pieces(rect, size_of::<u16>()) {
            let mut whole = vec![0u16; rect.width as usize * height as usize];
            whole.par_chunks_mut(rect.width as usize).enumerate().for_each(|(row, whole)| {
                let first = (y as usize + row) * stride as usize + rect.x as usize;
                // A height is nearest to the number it was made of; adding a half rounds to that.
                let to_units = |height: &f32| (height * units + 0.5) as u16;
                whole.iter_mut().zip(&heights[first..]).for_each(|(whole, height)| *whole = to_units(height));
            });
            let piece = SampleRect { x: 0, y: 0, width: rect.width, height };
            bytes += upload(gpu, texture, [place[0] + rect.x, place[1] + y], &whole, rect.width, piece);
            if y + height < end {
                give_staging_back(gpu);
            }
        }
        bytes
    }

    fn upload_edit(&mut self, gpu: &Gpu, edit: &Edit) {
        let field = self.terrain.field();
        let mut uploaded = self.upload_samples(gpu, field, edit.samples);
        let of_bounds = self.bounds.as_mut().map(|bounds| bounds.update(self.terrain.field(), edit.samples));
        if let Some(texture) = &self.pyramid {
            let pyramid = self.bounds.as_ref().map_or(self.terrain.pyramid(), SurfaceBounds::pyramid);
            let levels = pyramid.levels();
            for &NodeRect { level, x, y, width, height } in of_bounds.as_ref().unwrap_or(&edit.nodes) {
                if level <= self.top_level() {
                    let data = &levels[level as usize - 1];
                    let rect = SampleRect { x, y, width, height };
                    let place = self.pyramid_layout().place_of(level);
                    uploaded += self.upload(gpu, texture, place, &data.data, data.width, rect);
                }
            }
        }
        self.uploaded += uploaded;
    }

    fn upload_pyramid(&mut self, gpu: &Gpu) {
        let of_base;
        let pyramid = if let Some(bounds) = &self.bounds {
            bounds.pyramid()
        } else if self.heights_have_craters || self.terrain.craters().is_empty() {
            self.terrain.pyramid()
        } else {
            of_base = MaxPyramid::build(self.terrain.base());
            &of_base
        };
        let (levels, layout) = (self.top_level(), self.pyramid_layout());
        let texture = empty_texture(gpu, "pyramid", layout.size(), self.heights.texture.format());
        let mut uploaded = 0;
        for (number, level) in (1..=levels).zip(pyramid.levels()) {
            let all = SampleRect { x: 0, y: 0, width: level.width, height: level.height };
            let place = layout.place_of(number);
            uploaded += self.upload(gpu, &texture, place, &level.data, level.width, all);
        }
        self.uploaded += uploaded;
        self.pyramid = Some(texture);
    }

    fn prepare_layer(&mut self, gpu: &Gpu, craters: &CraterSettings) {
        let resolution = layer_resolution(craters.layer_resolution, gpu.capabilities.max_texture);
        if self.layer.as_ref().is_some_and(|layer| layer.resolution == resolution && layer.craters == craters.list) {
            return;
        }
        let layer = CraterLayer::rasterise(&craters.list, self.terrain.base(), resolution);
        let size = [layer.width, layer.height];
        let texture = match self.layer.take() {
            Some(old) if old.size == size => old.texture,
            _ => empty_texture(gpu, "crater layer", size, FLOAT_FORMAT),
        };
        let all = SampleRect { x: 0, y: 0, width: size[0], height: size[1] };
        self.uploaded += upload(gpu, &texture.texture, [0, 0], &layer.data, size[0], all);
        self.layer = Some(Layer { craters: craters.list.clone(), resolution, size, rise: layer.rise, texture });
    }
}

/// A texture that is filled by [`upload`].
pub(super) fn empty_texture(gpu: &Gpu, label: &str, size: [u32; 2], format: wgpu::TextureFormat) -> Texture {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Texture { texture, view }
}

/// Some rows at a time of `rect`, of so many bytes a sample, so that a large map needs no second copy of itself.
fn pieces(rect: SampleRect, sample_bytes: usize) -> impl Iterator<Item = SampleRect> {
    let rows_at_once = (UPLOAD_BYTES / (rect.width as usize * sample_bytes).max(1)).max(1) as u32;
    let end = rect.y + rect.height;
    let piece = move |y| SampleRect { y, height: rows_at_once.min(end - y), ..rect };
    (rect.y..end).step_by(rows_at_once as usize).map(piece)
}

/// Staging memory is only given back with a submission.
fn give_staging_back(gpu: &Gpu) {
    gpu.queue.submit([]);
}

/// Copies `rect` of a grid of texels, `stride` to a row, into `texture`, where the grid begins at `place`; returns the
/// bytes copied. `T` is what a texel's channels are.
pub(super) fn upload<T: bytemuck::Pod>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    place: [u32; 2],
    data: &[T],
    stride: u32,
    rect: SampleRect,
) -> u64 {
    let channels = usize::from(texture.format().components());
    let texel_bytes = channels * size_of::<T>();
    let row_bytes = stride as usize * texel_bytes;
    let rows_at_once = (UPLOAD_BYTES / row_bytes).max(1) as u32;
    let mut y = rect.y;
    while y < rect.y + rect.height {
        let height = rows_at_once.min(rect.y + rect.height - y);
        let first = y as usize * stride as usize * channels;
        let rows = &data[first..first + height as usize * stride as usize * channels];
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: place[0] + rect.x, y: place[1] + y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(rows),
            wgpu::TexelCopyBufferLayout {
                offset: u64::from(rect.x) * texel_bytes as u64,
                bytes_per_row: Some(row_bytes as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { width: rect.width, height, depth_or_array_layers: 1 },
        );
        y += height;
        if y < rect.y + rect.height {
            give_staging_back(gpu);
        }
    }
    u64::from(rect.width) * u64::from(rect.height) * texel_bytes as u64
}
