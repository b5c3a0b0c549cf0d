//! The light map: shadows and ambient occlusion of every place, drawn once for as long as neither ground nor sun changes.
//! Its shader is `light_map.wgsl`.
//!
//! Each of the two has a channel of its own, so that a sun that moves leaves the occlusion as it is. A channel is drawn by
//! rows: all of them in one frame, or no more than a budget allows, so that no frame waits for a large map.

use std::ops::Range;
use std::sync::{Arc, Weak};

use bytemuck::bytes_of;
use glam::DVec3;

use crate::gpu::{Gpu, sized_texture};
use crate::heightfield::HeightField;
use crate::scene::light::Shadows;
use crate::scene::{CraterSettings, Scene};

use super::frame::{FrameBindings, corner_sampler_entry, sampler_entry, texture_entry, uniform_entry};
use super::ground::Texture;
use super::ledger::TextureEntry;
use super::light::{self, LightBindings, LightKey, LightUniform};
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

/// Most texels along a side: all of them may be drawn in one pass, which must not take so long that a driver gives up.
const MOST_TEXELS: u32 = 2048;

/// What a channel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Share {
    /// Share of the sun's light, for shadows of this kind; with the occluder's, or without.
    Sun(Shadows, bool),
    /// Share of the sky's light.
    Sky,
}

impl Share {
    /// What a picture with this light reads.
    fn all_of(light: LightKey) -> impl Iterator<Item = Self> {
        let sun = light.baked.then_some(Self::Sun(light.shadows, light.occluder));
        sun.into_iter().chain(light.occlusion.then_some(Self::Sky))
    }

    /// Which of the map's channels it is.
    fn channel(self) -> usize {
        match self {
            Self::Sun(..) => 0,
            Self::Sky => 1,
        }
    }

    fn defs(self) -> Vec<&'static str> {
        match self {
            Self::Sky => vec!["OCCLUSION"],
            Self::Sun(shadows, occluder) => {
                [(true, "BAKED_SHADOWS"), (shadows == Shadows::Soft, "SOFT_SHADOWS"), (occluder, "OCCLUDER_SHADOW")]
                    .into_iter()
                    .filter_map(|(on, def)| on.then_some(def))
                    .collect()
            }
        }
    }
}

/// Which pipeline draws a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct LightMapKey {
    pub(super) share: Share,
    /// The map has holes.
    pub(super) holes: bool,
    /// There is a crater layer.
    pub(super) layered: bool,
}

impl LightMapKey {
    /// Those of all channels that a picture with this light reads.
    pub(super) fn all_of(light: LightKey, holes: bool, layered: bool) -> impl Iterator<Item = Self> {
        Share::all_of(light).map(move |share| Self { share, holes, layered })
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
        .chain(key.share.defs())
        .collect();
    PassDescription {
        name: format!("light map [{}]", defs.join(" ")),
        modules: vec!["frame.wgsl", "heightfield.wgsl", "pyramid.wgsl", "light.wgsl", "shadow.wgsl"],
        defs,
        bindings,
        depth: None,
        format: FORMAT,
        writes: [wgpu::ColorWrites::RED, wgpu::ColorWrites::GREEN][key.share.channel()],
        ..PassDescription::scene("light map", "light_map.wgsl", false)
    }
}

/// Entries of the terrain pass's layout that read it.
pub(super) fn layout_entries() -> [wgpu::BindGroupLayoutEntry; 2] {
    [texture_entry(LIGHT_MAP, true, false), sampler_entry(LIGHT_MAP_SAMPLER)]
}

/// All that a channel depends on, besides the height map itself.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    share: Share,
    extent: DVec3,
    craters: CraterSettings,
    /// The uniform of the light, as bytes; empty for the sky's share, which does not care for the sun.
    light: Vec<u8>,
}

impl Source {
    fn of(scene: &Scene, share: Share, uniform: &LightUniform, extent: DVec3) -> Self {
        let CraterSettings { radius, depth, rim, .. } = CraterSettings::default();
        // The brush of the next crater throws no shadow.
        let craters = CraterSettings { radius, depth, rim, ..scene.craters.clone() };
        let light = if share == Share::Sky { Vec::new() } else { bytes_of(uniform).to_vec() };
        Self { share, extent, craters, light }
    }

    /// Whether only the sun or the occluder has moved since.
    fn only_light_differs(&self, other: &Self) -> bool {
        self.light != other.light && *self == Self { light: self.light.clone(), ..other.clone() }
    }
}

/// How far a channel is.
#[derive(Debug)]
struct Channel {
    /// What the last picture needed; absent where it needed nothing of this channel.
    wanted: Option<Source>,
    /// What is drawn in all of its rows.
    done: Option<Source>,
    /// What is being drawn, and how many rows of it are there.
    under_way: Option<(Source, u32)>,
    /// The light that it is drawn with, as it was when the drawing began.
    light: LightBindings,
}

impl Channel {
    fn new(gpu: &Gpu) -> Self {
        Self { wanted: None, done: None, under_way: None, light: LightBindings::new(gpu) }
    }

    /// Has `wanted` drawn next. What is under way goes on to its end where only the sun has moved meanwhile and frames draw
    /// `by_parts`: begun anew with every step of a running clock, it would never be ready.
    fn aim_at(&mut self, wanted: Source, by_parts: bool, gpu: &Gpu, uniform: &LightUniform) {
        let goes_on = match &self.under_way {
            Some((source, _)) => *source == wanted || (by_parts && source.only_light_differs(&wanted)),
            None => self.done.as_ref() == Some(&wanted),
        };
        if !goes_on {
            self.light.write(gpu, uniform);
            (self.done, self.under_way) = (None, Some((wanted.clone(), 0)));
        }
        self.wanted = Some(wanted);
    }

    /// No picture needs it.
    fn rest(&mut self) {
        (self.wanted, self.under_way) = (None, None);
    }

    /// How many of its rows are drawn; `None` where all are.
    fn progress(&self) -> Option<u32> {
        match &self.under_way {
            Some((_, rows)) => Some(*rows),
            // What was begun for another sun is drawn to its end; what is wanted begins in the next frame.
            None => (self.wanted.is_some() && self.done != self.wanted).then_some(0),
        }
    }
}

/// The map on the GPU.
#[derive(Debug)]
pub(super) struct LightMap {
    /// The height map that it is of.
    ground: Weak<HeightField>,
    channels: [Channel; 2],
    texture: Texture,
    sampler: wgpu::Sampler,
    /// Nothing was drawn into it yet.
    blank: bool,
}

/// Texels of the light map of a height map with so many cells.
fn size_of(cells: [u32; 2], largest: u32) -> [u32; 2] {
    cells.map(|side| side.clamp(1, MOST_TEXELS.min(largest)))
}

impl LightMap {
    fn new(gpu: &Gpu, ground: &Arc<HeightField>, size: [u32; 2]) -> Self {
        let texture = sized_texture(gpu, "light map", size, FORMAT, &[]);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("light map"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let channels = [Channel::new(gpu), Channel::new(gpu)];
        Self { ground: Arc::downgrade(ground), channels, texture: Texture { texture, view }, sampler, blank: true }
    }

    /// Whether it is of this height map, with so many texels.
    fn suits(&self, ground: &Arc<HeightField>, size: [u32; 2]) -> bool {
        self.ground.as_ptr() == Arc::as_ptr(ground) && self.size() == size
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

    /// Share of the rows to be drawn that are; `None` where all is there.
    pub(super) fn progress(&self) -> Option<f32> {
        let rows = self.size()[1];
        let under_way = self.channels.iter().filter_map(Channel::progress);
        let (drawn, all) = under_way.fold((0, 0), |(drawn, all), done| (drawn + done, all + rows));
        (all > 0).then(|| drawn as f32 / all as f32)
    }

    /// The rows that a frame of so many texels draws, by channel; at least one row, or it would never be ready.
    fn next_rows(&self, budget: Option<u32>) -> [Range<u32>; 2] {
        let [width, height] = self.size();
        let mut left = budget.map_or(2 * height, |texels| (texels / width).max(1));
        self.channels.each_ref().map(|channel| {
            let Some((_, done)) = channel.under_way else { return 0..0 };
            let end = height.min(done + left);
            left -= end - done;
            done..end
        })
    }

    /// Draws `passes`.
    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameBindings,
        passes: &[LightMapPass],
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let [width, height] = self.size();
        let load =
            if std::mem::take(&mut self.blank) { wgpu::LoadOp::Clear(wgpu::Color::WHITE) } else { wgpu::LoadOp::Load };
        let attachments = [Some(wgpu::RenderPassColorAttachment {
            view: &self.texture.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })];
        let mut draws = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light map"),
            color_attachments: &attachments,
            timestamp_writes: timestamps,
            ..Default::default()
        });
        for LightMapPass { built, group, channel, rows } in passes {
            draws.set_pipeline(&built.pipeline);
            draws.set_bind_group(0, frame.group(built), &[]);
            draws.set_bind_group(1, group, &[]);
            draws.set_scissor_rect(0, rows.start, width, rows.end - rows.start);
            draws.draw(0..3, 0..1);
            let channel = &mut self.channels[*channel];
            channel.under_way = channel.under_way.take().map(|(source, _)| (source, rows.end));
            if rows.end == height {
                channel.done = channel.under_way.take().map(|(source, _)| source);
            }
        }
    }
}

/// A pass that draws rows of a channel: pipeline and bind group.
#[derive(Debug)]
pub(super) struct LightMapPass {
    built: Arc<Built>,
    group: wgpu::BindGroup,
    channel: usize,
    rows: Range<u32>,
}

/// The light map of one series of pictures, and how it is drawn. A renderer has one; a second series with a sun of its own,
/// as a film that is written while the window goes on, brings its own along ([`Renderer::swap_baking`]): sharing one, each
/// picture of the one would draw anew what the other has just drawn over.
#[derive(Debug, Default)]
pub struct Baking {
    pub(super) map: Option<LightMap>,
    /// Most texels of the map that a frame draws.
    budget: Option<u32>,
    /// How much of it was drawn after the last picture, where not all was.
    progress: Option<f32>,
}

impl Baking {
    /// Draws what is next of the map.
    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameBindings,
        passes: &[LightMapPass],
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        self.progress = None;
        if let (false, Some(map)) = (passes.is_empty(), &mut self.map) {
            map.encode(encoder, frame, passes, timestamps);
            self.progress = map.progress();
        }
    }
}

impl Renderer {
    /// Lets a frame draw no more than about so many texels of a light map; `None`, as in the beginning: all of them. With a
    /// budget, pictures show the part that is drawn until [`Self::baking`] says that all is.
    pub fn set_bake_budget(&mut self, texels: Option<u32>) {
        self.baking.budget = texels;
    }

    /// How much of the light map that the last picture needed is drawn, 0 to 1; `None`: all of it.
    pub fn baking(&self) -> Option<f32> {
        self.baking.progress
    }

    /// Draws what follows with this light map and its budget, which must be of the same device or new: call it again to go
    /// back to those from before.
    pub fn swap_baking(&mut self, other: &mut Baking) {
        std::mem::swap(&mut self.baking, other);
    }

    /// Writes what passes read of the light, and drops the light map that no pass reads. Whether it has to be drawn.
    pub(super) fn prepare_light(&mut self, scene: &Scene, view: &View, light: LightKey, probe: bool) -> bool {
        if probe {
            return false;
        }
        if !light.needs_map() {
            self.baking.map = None;
        }
        let Some(ground) = self.ground.as_ref().filter(|_| light != LightKey::default()) else { return false };
        let map = ground.terrain().base();
        let cube = occluder::world_from_cube(&scene.occluder, map, view.extent);
        let (cells, texels) = (map.cells(), size_of(map.cells(), self.gpu.capabilities.max_texture));
        let cells_per_texel = std::array::from_fn(|axis| f64::from(cells[axis]) / f64::from(texels[axis]));
        let uniform = LightUniform::new(scene, light, cube, cells_per_texel);
        self.terrain.light.write(&self.gpu, &uniform);
        if !light.needs_map() || !self.shows_terrain(view) {
            return false;
        }
        self.baking.map.take_if(|known| !known.suits(map, texels));
        let (gpu, by_parts) = (&self.gpu, self.baking.budget.is_some());
        let known = self.baking.map.get_or_insert_with(|| LightMap::new(gpu, map, texels));
        for share in Share::all_of(light) {
            let source = Source::of(scene, share, &uniform, view.extent);
            known.channels[share.channel()].aim_at(source, by_parts, gpu, &uniform);
        }
        for (channel, needed) in known.channels.iter_mut().zip([light.baked, light.occlusion]) {
            if !needed {
                channel.rest();
            }
        }
        known.progress().is_some()
    }

    /// The passes that draw what is next of the light map; the ground's textures are up to date.
    pub(super) fn light_map_passes(&mut self) -> Result<Vec<LightMapPass>, RenderError> {
        let (Some(ground), Some(map)) = (&self.ground, &self.baking.map) else { return Ok(Vec::new()) };
        let (holes, layered) = (ground.has_holes(), ground.layer().is_some());
        let mut passes = Vec::new();
        for (channel, rows) in map.next_rows(self.baking.budget).into_iter().enumerate() {
            let Some((source, _)) = map.channels[channel].under_way.as_ref().filter(|_| !rows.is_empty()) else {
                continue;
            };
            let key = LightMapKey { share: source.share, holes, layered };
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::LightMap(key))?;
            let light = &map.channels[channel].light;
            let Some(entries) = self.terrain.shadow_entries(ground, light) else { return Ok(Vec::new()) };
            let group = bind(&self.gpu, &built, entries);
            passes.push(LightMapPass { built, group, channel, rows });
        }
        Ok(passes)
    }
}
