//! The beam passes: where the rays of each tile of pixels may start, for the technique that walks the pyramid. Coarse tiles
//! first, then fine ones from where those stopped. Their shader is `beam.wgsl`.

use std::sync::Arc;

use crate::gpu::{Gpu, sized_texture};

use super::frame::{FrameBindings, texture_entry, uniform_entry};
use super::ground::Texture;
use super::ledger::TextureEntry;
use super::pipelines::{Built, PassDescription};
use super::split::Area;
use super::terrain::TerrainUniform;

/// The tiles of a beam pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Tiles {
    /// Large ones, which walk from where their rays enter the box.
    Coarse,
    /// Small ones, which walk on from there.
    Fine,
}

impl Tiles {
    /// In the order of the passes.
    pub(super) const ALL: [Self; 2] = [Self::Coarse, Self::Fine];

    /// Side of a tile in pixels.
    const fn side(self) -> u32 {
        match self {
            Self::Coarse => 16,
            Self::Fine => 4,
        }
    }

    /// The name of the pass and of its texture.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Coarse => "coarse beam",
            Self::Fine => "beam",
        }
    }
}

/// Start parameter, and side in cells of the node to start in.
const BEAM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// The same and texel reads, for who counts them.
const COUNTING_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

fn format(counts: bool) -> wgpu::TextureFormat {
    if counts { COUNTING_FORMAT } else { BEAM_FORMAT }
}

pub(super) fn describe(tiles: Tiles, counts: bool) -> PassDescription {
    let refines = tiles == Tiles::Fine;
    PassDescription {
        modules: vec!["frame.wgsl", "heightfield.wgsl", "varyings.wgsl", "pyramid.wgsl"],
        casts_rays: true,
        bindings: [
            uniform_entry::<TerrainUniform>(0),
            texture_entry(3, false, false),
            super::frame::corner_sampler_entry(7),
        ]
        .into_iter()
        .chain(refines.then(|| texture_entry(8, false, false)))
        .collect(),
        defs: refines.then_some("REFINES").into_iter().chain(counts.then_some("COUNT_READS")).collect(),
        depth: None,
        format: format(counts),
        ..PassDescription::scene(tiles.name(), "beam.wgsl", false)
    }
}

/// The shader module `relief::beam`: the sides of the tiles.
pub(super) fn wgsl() -> String {
    let [coarse, fine] = Tiles::ALL.map(Tiles::side);
    format!(
        "#define_import_path relief::beam\nconst COARSE_TILE: f32 = {coarse}.0;\nconst FINE_TILE: f32 = {fine}.0;\n"
    )
}

/// A beam pass: pipeline and bind group.
#[derive(Debug)]
pub(super) struct BeamPass {
    pub(super) built: Arc<Built>,
    pub(super) group: wgpu::BindGroup,
}

/// The start of every tile's rays, for pictures of one size.
#[derive(Debug)]
pub(super) struct Beams {
    /// Size of the picture in pixels.
    size: [u32; 2],
    /// Whether texel reads are counted.
    counts: bool,
    /// By [`Tiles::ALL`].
    starts: [Texture; 2],
}

impl Beams {
    /// Room for the tiles of a picture of `size` pixels, and for the counts of their texel reads.
    pub(super) fn new(gpu: &Gpu, size: [u32; 2], counts: bool) -> Self {
        let starts = Tiles::ALL.map(|tiles| {
            let in_tiles = size.map(|side| side.div_ceil(tiles.side()));
            let texture = sized_texture(gpu, tiles.name(), in_tiles, format(counts), &[]);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            Texture { texture, view }
        });
        Self { size, counts, starts }
    }

    /// Whether they are for pictures of `size` pixels, and count or not.
    pub(super) fn suit(&self, size: [u32; 2], counts: bool) -> bool {
        self.size == size && self.counts == counts
    }

    /// Where the rays of these tiles may start.
    pub(super) fn starts(&self, tiles: Tiles) -> &wgpu::TextureView {
        let [coarse, fine] = &self.starts;
        match tiles {
            Tiles::Coarse => &coarse.view,
            Tiles::Fine => &fine.view,
        }
    }

    pub(super) fn entries(&self) -> [TextureEntry; 2] {
        let [coarse, fine] = &self.starts;
        [(Tiles::Coarse, coarse), (Tiles::Fine, fine)]
            .map(|(tiles, starts)| TextureEntry::of(tiles.name(), &starts.texture))
    }

    /// Finds the starts of the tiles in `area` of the picture: two passes before the terrain's.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &[BeamPass; 2],
        frame: &FrameBindings,
        area: Area,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let mut timestamps = timestamps;
        for (tiles, BeamPass { built, group }) in Tiles::ALL.into_iter().zip(passes) {
            let attachments = [Some(wgpu::RenderPassColorAttachment {
                view: self.starts(tiles),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })];
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(tiles.name()),
                color_attachments: &attachments,
                depth_stencil_attachment: None,
                timestamp_writes: timestamps.take(),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            pass.set_pipeline(&built.pipeline);
            pass.set_bind_group(0, frame.group(built), &[]);
            pass.set_bind_group(1, group, &[]);
            area.in_tiles(tiles.side()).scissor(&mut pass);
            pass.draw(0..3, 0..1);
        }
    }

    /// Lets every ray start where it enters the box, in a node of `size` cells.
    #[cfg(test)]
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, size: f32) {
        let nowhere = wgpu::Color { r: f64::from(f32::MIN), g: f64::from(size), b: 0.0, a: 0.0 };
        let attachments = [Some(wgpu::RenderPassColorAttachment {
            view: self.starts(Tiles::Fine),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(nowhere), store: wgpu::StoreOp::Store },
        })];
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("no beam"),
            color_attachments: &attachments,
            ..Default::default()
        });
    }
}
