//! Distances and steps of every pixel, and the number of pixels that a draw shades: for tables, tests and `--depth`.

use crate::gpu::{DEPTH_FORMAT, Gpu, PROBE_FORMAT, ReadbackError, Target, map_and_wait, read_texture, sized_texture};
use crate::scene::Scene;

use super::prepare::{Aim, View};
use super::{Anchor, RenderError, Renderer, clear_depth, ray_start};

/// Distances and steps of every pixel of a view.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Distance from the eye to the first hit (terrain or occluder) in world units, +inf for sky; row 0 at the top.
    pub distance: Vec<f32>,
    /// Where a pixel shows terrain, the view depth of its hit less that from which its ray counts (`starts`): from a
    /// million box lengths away an f32 distance says little about where on the map a hit is, this does.
    pub(crate) beyond_start: Vec<f32>,
    /// View depths from which the terrain's rays count, known in f64.
    pub(crate) starts: Vec<f64>,
    /// Which of them a pixel's ray counts from; empty where there is only one.
    pub(crate) counted_from: Vec<u8>,
    /// What is at those depths, where the view is a deep zoom.
    pub(crate) anchors: Vec<Anchor>,
    /// Steps of each ray; 0 where no ray was cast or the occluder hides it.
    pub steps: Vec<u32>,
    /// Rays that the step cap ended.
    pub cap_hits: u32,
}

impl Probe {
    /// View depth of the terrain's hit in the pixel with this number, counted row by row; `None` where it shows sky, an
    /// occluder or nothing. It is as exact as the ray was cast: [`Self::distance`], an f32, cannot tell the pixels of a deep
    /// zoom apart.
    pub fn view_depth(&self, pixel: usize) -> Option<f64> {
        let beyond = self.beyond_start.get(pixel).filter(|_| self.steps.get(pixel).is_some_and(|&steps| steps > 0))?;
        self.distance.get(pixel)?.is_finite().then(|| self.start(pixel) + f64::from(*beyond))
    }

    /// View depth from which the ray of a pixel counts.
    pub(crate) fn start(&self, pixel: usize) -> f64 {
        let number = self.counted_from.get(pixel).copied().unwrap_or(0);
        self.starts.get(usize::from(number)).copied().unwrap_or(0.0)
    }

    /// Mean and maximum of the steps over the rays that were cast.
    pub fn step_stats(&self) -> (f64, u32) {
        let cast = self.steps.iter().filter(|&&steps| steps > 0);
        let (sum, count) = cast.fold((0u64, 0u64), |(sum, count), &steps| (sum + u64::from(steps), count + 1));
        let mean = if count == 0 { 0.0 } else { sum as f64 / count as f64 };
        (mean, self.steps.iter().copied().max().unwrap_or(0))
    }
}

impl Renderer {
    /// Distances and steps of `scene` at `size` pixels. Waits for the GPU; leaves the ledger as it is.
    ///
    /// # Errors
    /// As [`Renderer::draw`], and where nothing can be read back.
    pub fn probe(&mut self, scene: &Scene, size: [u32; 2]) -> Result<Probe, RenderError> {
        self.probe_aimed(scene, size, Aim::Probe)
    }

    /// Texels that each pixel of `scene` reads to find the ground with the exact technique: a node's, a cell's four corners,
    /// and its share of what the beams read for it, rounded down; 0 where no ray is cast. In a deep zoom, and with another
    /// technique, it is the steps. Waits for the GPU; leaves the ledger as it is.
    ///
    /// # Errors
    /// As [`Self::probe`].
    pub fn texel_reads(&mut self, scene: &Scene, size: [u32; 2]) -> Result<Vec<u32>, RenderError> {
        Ok(self.probe_aimed(scene, size, Aim::Reads)?.steps)
    }

    fn probe_aimed(&mut self, scene: &Scene, size: [u32; 2], aim: Aim<'_>) -> Result<Probe, RenderError> {
        self.check_device()?;
        let size = size.map(|side| side.clamp(1, self.gpu.capabilities.max_texture));
        let passes = self.prepare(scene, size, aim)?;
        let View { camera, extent, .. } = self.view(scene, size);
        let color = sized_texture(&self.gpu, "probe", size, PROBE_FORMAT, &[]);
        let depth = sized_texture(&self.gpu, "probe depth", size, DEPTH_FORMAT, &[]);
        let view = color.create_view(&wgpu::TextureViewDescriptor::default());
        let depth_view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("probe") });
        self.encode_beams(&mut encoder, &passes, None);
        {
            let attachments = [Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                // No hit, no steps.
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r: -1.0, g: 0.0, b: 0.0, a: 0.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })];
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("probe"),
                color_attachments: &attachments,
                depth_stencil_attachment: Some(clear_depth(&depth_view)),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            for draw in &passes.draws {
                self.encode(&mut pass, draw);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&read_texture(&self.gpu, &color)?);
        let anchors = passes.anchors;
        Ok(Probe {
            size,
            distance: texels.iter().map(|texel| if texel[0] < 0.0 { f32::INFINITY } else { texel[0] }).collect(),
            beyond_start: texels.iter().map(|texel| texel[3]).collect(),
            starts: if anchors.is_empty() {
                vec![ray_start(&camera, extent)]
            } else {
                anchors.iter().map(|anchor| anchor.depth).collect()
            },
            counted_from: if anchors.len() > 1 {
                texels.iter().map(|texel| texel[2] as u8 >> 1).collect()
            } else {
                Vec::new()
            },
            anchors,
            steps: texels.iter().map(|texel| texel[1] as u32).collect(),
            cap_hits: texels.iter().filter(|texel| texel[2] as u8 & 1 == 1).count() as u32,
        })
    }
}

impl Renderer {
    /// Draws a frame of `scene` into `target` and waits for it: its time in milliseconds. Leaves the ledger as it is.
    ///
    /// # Errors
    /// As [`Renderer::draw`] and [`Renderer::wait_frame_time`].
    pub fn time(&mut self, scene: &Scene, target: &Target) -> Result<f64, RenderError> {
        let (ledger, shown) = (self.ledger.clone(), self.shown.clone());
        let drawn = self.draw(scene, target);
        (self.ledger, self.shown) = (ledger, shown);
        drawn?;
        self.wait_frame_time()
    }
}

/// Counts the fragments of a draw that pass the depth test.
#[derive(Debug)]
pub(super) struct PixelCounter {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
}

const COUNT_BYTES: u64 = size_of::<u64>() as u64;

impl PixelCounter {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pixel count"),
                size: COUNT_BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pixel count"),
                ty: wgpu::QueryType::Occlusion,
                count: 1,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
        }
    }

    pub(super) fn queries(&self) -> &wgpu::QuerySet {
        &self.queries
    }

    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..1, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, COUNT_BYTES);
    }

    pub(super) fn read(&self, gpu: &Gpu) -> Result<u64, ReadbackError> {
        let bytes = map_and_wait(gpu, &self.readable)?;
        Ok(bytemuck::pod_read_unaligned(&bytes))
    }
}
