//! The light map: shadows and ambient occlusion of every place, drawn once for as long as neither ground nor sun changes.
//! Its shader is `light_map.wgsl`.

use std::sync::Arc;

use bytemuck::bytes_of;
use glam::DVec3;

use crate::gpu::{Gpu, sized_texture};
use crate::scene::{CraterSettings, Scene};

use super::frame::{FrameBindings, corner_sampler_entry, sampler_entry, texture_entry, uniform_entry};
use super::ground::{Ground, Texture};
use super::ledger::TextureEntry;
use super::light::{self, LightKey, LightUniform};
use super::pipelines::{Built, PassDescription, PipelineKey};
use super::prepare::View;
use super::terrain::{TerrainUniform, bind};
use super::{RenderError, Renderer, occluder};

/// Binding of the map.
pub(super) const LIGHT_MAP: u32 = 22;
/// Binding of the sampler that reads it.
pub(super) const LIGHT_MAP_SAMPLER: u32 = 23;

/// The shares of the sun and of the sky.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg8Unorm;

/// Most texels along a side: all of them are drawn in one pass, which must not take so long that a driver gives up.
const MOST_TEXELS: u32 = 2048;

/// Which pipeline draws it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct LightMapKey {
    pub(super) light: LightKey,
    /// The map has holes.
    pub(super) holes: bool,
    /// There is a crater layer.
    pub(super) layered: bool,
}

impl LightMapKey {
    pub(super) fn of(light: LightKey, ground: &Ground, layered: bool) -> Self {
        Self { light, holes: ground.has_holes(), layered }
    }
}

pub(super) fn describe(key: LightMapKey) -> PassDescription {
    let mut bindings = vec![
        uniform_entry::<TerrainUniform>(0),
        texture_entry(1, false, false),
        texture_entry(3, false, false),
        corner_sampler_entry(7),
        light::layout_entry(),
    ];
    bindings.extend(key.layered.then(|| texture_entry(4, false, false)));
    let defs: Vec<_> = [(key.holes, "HOLES"), (key.layered, "CRATERS_LAYERED")]
        .into_iter()
        .filter_map(|(on, def)| on.then_some(def))
        .chain(key.light.map_defs())
        .collect();
    PassDescription {
        name: format!("light map [{}]", defs.join(" ")),
        modules: vec!["frame.wgsl", "heightfield.wgsl", "pyramid.wgsl", "light.wgsl", "shadow.wgsl"],
        defs,
        bindings,
        depth: None,
        format: FORMAT,
        ..PassDescription::scene("light map", "light_map.wgsl", false)
    }
}

/// Entries of the terrain pass's layout that read it.
pub(super) fn layout_entries() -> [wgpu::BindGroupLayoutEntry; 2] {
    [texture_entry(LIGHT_MAP, true, false), sampler_entry(LIGHT_MAP_SAMPLER)]
}

/// All that a light map depends on, besides the height map itself.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LightMapSource {
    key: LightKey,
    /// The uniform of the light, as bytes.
    light: Vec<u8>,
    extent: DVec3,
    craters: CraterSettings,
}

impl LightMapSource {
    pub(super) fn of(scene: &Scene, key: LightKey, uniform: &LightUniform, extent: DVec3) -> Self {
        let CraterSettings { radius, depth, rim, .. } = CraterSettings::default();
        // The brush of the next crater throws no shadow.
        let craters = CraterSettings { radius, depth, rim, ..scene.craters.clone() };
        let light = if key.baked { bytes_of(uniform).to_vec() } else { Vec::new() };
        Self { key, light, extent, craters }
    }
}

/// The map on the GPU.
#[derive(Debug)]
pub(super) struct LightMap {
    /// What is drawn in it; absent before that.
    source: Option<LightMapSource>,
    texture: Texture,
    sampler: wgpu::Sampler,
}

/// Texels of the light map of a height map with so many cells.
fn size_of(cells: [u32; 2], largest: u32) -> [u32; 2] {
    cells.map(|side| side.clamp(1, MOST_TEXELS.min(largest)))
}

impl LightMap {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let texture = sized_texture(gpu, "light map", size, FORMAT, &[]);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("light map"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { source: None, texture: Texture { texture, view }, sampler }
    }

    fn size(&self) -> [u32; 2] {
        [self.texture.texture.width(), self.texture.texture.height()]
    }

    pub(super) fn entries(&self) -> [(u32, wgpu::BindingResource<'_>); 2] {
        [
            (LIGHT_MAP, wgpu::BindingResource::TextureView(&self.texture.view)),
            (LIGHT_MAP_SAMPLER, wgpu::BindingResource::Sampler(&self.sampler)),
        ]
    }

    pub(super) fn entry(&self) -> TextureEntry {
        TextureEntry::of("light map", &self.texture.texture)
    }

    /// Draws it.
    pub(super) fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &FrameBindings, pass: &LightMapPass) {
        let attachments = [Some(wgpu::RenderPassColorAttachment {
            view: &self.texture.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Store },
        })];
        let mut draws = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light map"),
            color_attachments: &attachments,
            ..Default::default()
        });
        draws.set_pipeline(&pass.built.pipeline);
        draws.set_bind_group(0, frame.group(&pass.built), &[]);
        draws.set_bind_group(1, &pass.group, &[]);
        draws.draw(0..3, 0..1);
        drop(draws);
        self.source = Some(pass.source.clone());
    }
}

/// The pass that draws it: pipeline and bind group.
#[derive(Debug)]
pub(super) struct LightMapPass {
    pub(super) built: Arc<Built>,
    pub(super) group: wgpu::BindGroup,
    source: LightMapSource,
}

impl Renderer {
    /// Writes what passes read of the light, and drops the light map that no pass reads. What it has to be drawn of, where it
    /// is needed and holds something else.
    pub(super) fn prepare_light(
        &mut self,
        scene: &Scene,
        view: &View,
        light: LightKey,
        probe: bool,
    ) -> Option<LightMapSource> {
        if probe {
            return None;
        }
        if !light.needs_map() {
            self.light_map = None;
        }
        let ground = self.ground.as_ref()?;
        if light == LightKey::default() {
            return None;
        }
        let map = ground.terrain().base();
        let cube = occluder::world_from_cube(&scene.occluder, map, view.extent);
        let (cells, texels) = (map.cells(), size_of(map.cells(), self.gpu.capabilities.max_texture));
        let cells_per_texel = std::array::from_fn(|axis| f64::from(cells[axis]) / f64::from(texels[axis]));
        let uniform = LightUniform::new(scene, light, cube, cells_per_texel);
        self.terrain.light.write(&self.gpu, &uniform);
        if !light.needs_map() || !self.shows_terrain(view) {
            return None;
        }
        let source = LightMapSource::of(scene, light, &uniform, view.extent);
        if self.light_map.as_ref().is_none_or(|known| known.size() != texels) {
            self.light_map = Some(LightMap::new(&self.gpu, texels));
        }
        let is_known = self.light_map.as_ref().is_some_and(|known| known.source.as_ref() == Some(&source));
        (!is_known).then_some(source)
    }

    /// The pass that draws the light map of `source`; the ground's textures are up to date.
    pub(super) fn light_map_pass(
        &mut self,
        light: LightKey,
        source: LightMapSource,
    ) -> Result<Option<LightMapPass>, RenderError> {
        let Some(ground) = &self.ground else { return Ok(None) };
        let key = LightMapKey::of(light, ground, ground.layer().is_some());
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::LightMap(key))?;
        let Some(entries) = self.terrain.shadow_entries(ground) else { return Ok(None) };
        let group = bind(&self.gpu, &built, entries);
        Ok(Some(LightMapPass { built, group, source }))
    }
}
