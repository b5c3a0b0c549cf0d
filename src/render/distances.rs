//! Distances as textures: what the error view compares with, and pictures of given distances: the shading of a scene over hits that were found elsewhere, so that two pictures differ
//! by the error of their distances alone.

use crate::gpu::{Gpu, PROBE_FORMAT, Target, sized_texture};
use crate::scene::Scene;

use super::ground::Texture;
use super::ledger::TextureEntry;
use super::prepare::{Aim, Draw};
use super::{RenderError, Renderer, clear_depth};

/// Distance of a pixel per texel.
const DISTANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What stands for no ground. Not infinity: a shader may take it that there is none.
const NO_GROUND: f32 = -1.0;

impl Renderer {
    /// Draws `scene` as [`Renderer::draw`] does, but with the ground where `distances` say: no ray is cast, and neither
    /// pyramid nor beams are read. Shading, occluder and sky are those of the scene.
    ///
    /// `distances` are world units from the eye to the ground for every pixel of `target`, row 0 at the top; +inf (or
    /// whatever is not finite and positive) is no ground. They are those of a
    /// [`probe`](Renderer::probe) of the scene without its occluder, or of
    /// [`Surface::distances`](crate::heightfield::reference::Surface::distances).
    ///
    /// # Errors
    /// [`RenderError::Distances`] where there is not one distance per pixel; else as [`Renderer::draw`].
    pub fn draw_with_distances(
        &mut self,
        scene: &Scene,
        target: &Target,
        distances: &[f32],
    ) -> Result<(), RenderError> {
        self.check_device()?;
        let texture = upload(&self.gpu, "given distances", target.size(), distances)?;
        self.draw_aimed(scene, target, Aim::Given(&texture.view), None)
    }
}

/// What the error view compares with.
#[derive(Debug)]
pub(super) struct ExactDistances {
    name: &'static str,
    size: [u32; 2],
    distances: Texture,
}

impl ExactDistances {
    /// Room for the distances that the exact technique finds in the same frame.
    pub(super) fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let texture = sized_texture(gpu, "exact", size, PROBE_FORMAT, &[]);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { name: "exact", size, distances: Texture { texture, view } }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    pub(super) fn view(&self) -> &wgpu::TextureView {
        &self.distances.view
    }

    pub(super) fn entry(&self) -> TextureEntry {
        TextureEntry::of(self.name, &self.distances.texture)
    }
}

impl Renderer {
    /// What the error view compares with from now on: the distances of the f64 reference
    /// ([`Surface::distances`](crate::heightfield::reference::Surface::distances)) for a picture of `size` pixels,
    /// +inf for the sky; `None`: those of the exact technique, found in the frame. They must be those of the scene that
    /// is drawn. They are dropped by a frame of another size or without the error view.
    ///
    /// # Errors
    /// [`RenderError::Distances`] where there is not one distance per pixel; the old ones are gone all the same.
    pub fn set_reference(&mut self, size: [u32; 2], distances: Option<&[f32]>) -> Result<(), RenderError> {
        self.reference = None;
        if let Some(distances) = distances {
            let distances = upload(&self.gpu, "reference", size, distances)?;
            self.reference = Some(ExactDistances { name: "reference", size, distances });
        }
        Ok(())
    }

    /// Whether the error view of the last frame was compared with the f64 reference.
    pub fn shows_reference(&self) -> bool {
        self.reference.is_some()
    }

    /// The pass that finds the exact distances. `depth` is the target's, which the scene clears again.
    pub(super) fn encode_exact(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draw: &Draw,
        depth: &wgpu::TextureView,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let Some(exact) = &self.exact else { return };
        let nothing = wgpu::Color { r: f64::from(NO_GROUND), g: 0.0, b: 0.0, a: 0.0 };
        let attachments = [Some(wgpu::RenderPassColorAttachment {
            view: exact.view(),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(nothing), store: wgpu::StoreOp::Store },
        })];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("exact"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(clear_depth(depth)),
            timestamp_writes: timestamps,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        self.encode(&mut pass, draw);
    }
}

/// A texture of `distances` for a picture of `size` pixels: below zero where there is no ground.
pub(super) fn upload(gpu: &Gpu, label: &str, size: [u32; 2], distances: &[f32]) -> Result<Texture, RenderError> {
    let [width, height] = size;
    if distances.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(RenderError::Distances { given: distances.len(), width, height });
    }
    let texels: Vec<f32> = distances
        .iter()
        .map(|&distance| if distance.is_finite() && distance >= 0.0 { distance } else { NO_GROUND })
        .collect();
    let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: DISTANCE_FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * size_of::<f32>() as u32),
            rows_per_image: None,
        },
        extent,
    );
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Ok(Texture { texture, view })
}
