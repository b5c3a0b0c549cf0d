//! The beam pass: where the rays of each tile of pixels may start, for the technique that walks the pyramid. Its shader is
//! `beam.wgsl`.

use crate::gpu::{Gpu, sized_texture};

use super::frame::{texture_entry, uniform_entry};
use super::ground::Texture;
use super::ledger::TextureEntry;
use super::pipelines::{Built, PassDescription};
use super::split::Area;
use super::terrain::TerrainUniform;

/// Side of a tile in pixels.
const TILE: u32 = 8;

/// Start parameter, and side in cells of the node to start in.
const BEAM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

pub(super) fn describe() -> PassDescription {
    PassDescription {
        modules: vec!["frame.wgsl", "heightfield.wgsl", "varyings.wgsl", "pyramid.wgsl"],
        casts_rays: true,
        bindings: vec![
            uniform_entry::<TerrainUniform>(0),
            texture_entry(3, false, false),
            super::frame::corner_sampler_entry(7),
        ],
        depth: None,
        format: BEAM_FORMAT,
        ..PassDescription::scene("beam", "beam.wgsl", false)
    }
}

/// The shader module `relief::beam`: the tile's side.
pub(super) fn wgsl() -> String {
    format!("#define_import_path relief::beam\nconst BEAM_TILE: f32 = {TILE}.0;\n")
}

/// The start of every tile's rays, for pictures of one size.
#[derive(Debug)]
pub(super) struct Beams {
    /// Size of the picture in pixels.
    size: [u32; 2],
    starts: Texture,
}

impl Beams {
    /// Room for the tiles of a picture of `size` pixels.
    pub(super) fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let texture = sized_texture(gpu, "beam", size.map(|side| side.div_ceil(TILE)), BEAM_FORMAT, &[]);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { size, starts: Texture { texture, view } }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    pub(super) fn starts(&self) -> &wgpu::TextureView {
        &self.starts.view
    }

    pub(super) fn entry(&self) -> TextureEntry {
        TextureEntry::of("beam", &self.starts.texture)
    }

    /// Finds the starts of the tiles in `area` of the picture: a pass of its own, before the terrain's.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        built: &Built,
        frame: &wgpu::BindGroup,
        group: &wgpu::BindGroup,
        area: Area,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let attachments = [Some(wgpu::RenderPassColorAttachment {
            view: &self.starts.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("beam"),
            color_attachments: &attachments,
            depth_stencil_attachment: None,
            timestamp_writes: timestamps,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&built.pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, group, &[]);
        area.in_tiles(TILE).scissor(&mut pass);
        pass.draw(0..3, 0..1);
    }

    /// Lets every ray start where it enters the box, in a node of `size` cells.
    #[cfg(test)]
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, size: f32) {
        let nowhere = wgpu::Color { r: f64::from(f32::MIN), g: f64::from(size), b: 0.0, a: 0.0 };
        let attachments = [Some(wgpu::RenderPassColorAttachment {
            view: &self.starts.view,
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
