//! Puts the legend into pictures that are saved, with or without a window: the one that the viewer shows over its picture,
//! drawn by the same code.

use egui::{Context, RawInput, Rect, ViewportId, vec2};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use image::RgbaImage;

use super::legend;
use crate::gpu::{COLOR_BYTES_FORMAT, Gpu, ReadbackError, Target, read_texture};
use crate::heightfield::HeightField;
use crate::scene::Scene;

/// A picture of this size has a legend of the size that it has in a window, larger pictures a larger one.
const PLAIN: [f32; 2] = [1280.0, 800.0];

/// egui knows how large a box is once it has drawn it, and fades it in from the next pass on.
const PASSES: usize = 3;

/// Draws legends into pictures. Its pipeline and font stay from picture to picture.
pub(crate) struct Stamp {
    ctx: Context,
    painter: egui_wgpu::Renderer,
    /// egui's clock: what it animates has come to rest by the next pass.
    seconds: f64,
}

impl Stamp {
    /// On the device of `gpu`.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let ctx = Context::default();
        // The boxes are dark over any picture.
        ctx.set_theme(egui::Theme::Dark);
        // Whole in its first picture: a box fades in.
        ctx.all_styles_mut(|style| style.animation_time = 0.0);
        let painter = egui_wgpu::Renderer::new(&gpu.device, COLOR_BYTES_FORMAT, RendererOptions::default());
        Self { ctx, painter, seconds: 0.0 }
    }

    /// The picture in `target` as it is saved, 8-bit sRGB: with what `legend` says. `target` stays as it is.
    ///
    /// # Errors
    /// [`ReadbackError`] where the device is lost or out of memory.
    pub(crate) fn picture(
        &mut self,
        gpu: &Gpu,
        target: &Target,
        legend: &Legend<'_>,
    ) -> Result<RgbaImage, ReadbackError> {
        let size = target.size();
        let scale = legend.pixels_per_point.unwrap_or_else(|| pixels_per_point(size));
        let primitives = self.paint(gpu, size, scale, legend);
        // egui blends in gamma space: the same bytes, unconverted.
        let copy = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture with its legend"),
            size: target.color.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: COLOR_BYTES_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("legend") });
        encoder.copy_texture_to_texture(target.color.as_image_copy(), copy.as_image_copy(), target.color.size());
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point: scale };
        let mut commands = self.painter.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &primitives, &screen);
        let view = copy.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("legend"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.painter.render(&mut pass.forget_lifetime(), &primitives, &screen);
        commands.push(encoder.finish());
        gpu.queue.submit(commands);
        RgbaImage::from_raw(size[0], size[1], read_texture(gpu, &copy)?).ok_or(ReadbackError::Short)
    }

    /// What egui draws of the legend in a picture of `size` pixels, its font on the device.
    fn paint(&mut self, gpu: &Gpu, size: [u32; 2], scale: f32, legend: &Legend<'_>) -> Vec<egui::ClippedPrimitive> {
        let screen = Rect::from_min_size(egui::Pos2::ZERO, vec2(size[0] as f32, size[1] as f32) / scale);
        let mut shapes = Vec::new();
        for _ in 0..PASSES {
            self.seconds += 1.0;
            let time = Some(self.seconds);
            let mut input = RawInput { screen_rect: Some(screen), time, ..RawInput::default() };
            input.viewports.entry(ViewportId::ROOT).or_default().native_pixels_per_point = Some(scale);
            let mut output = self.ctx.run_ui(input, |ui| {
                legend::show(ui.ctx(), screen, legend.scene, legend.map, legend.errors);
            });
            for (id, deltas) in output.textures_delta.set.drain() {
                for delta in deltas {
                    self.painter.update_texture(&gpu.device, &gpu.queue, id, &delta);
                }
            }
            for id in output.textures_delta.free.drain() {
                self.painter.free_texture(&id);
            }
            shapes = output.shapes;
        }
        self.ctx.tessellate(shapes, scale)
    }
}

/// What a legend is about.
pub(crate) struct Legend<'a> {
    /// The scene of the picture.
    pub(crate) scene: &'a Scene,
    /// Its map, without craters.
    pub(crate) map: &'a HeightField,
    /// What the errors of the error view are against.
    pub(crate) errors: legend::Against,
    /// Physical pixels per point. Absent: by the picture's size.
    pub(crate) pixels_per_point: Option<f32>,
}

/// So that a legend is as large in every picture as in a window, for who sees the whole picture.
fn pixels_per_point(size: [u32; 2]) -> f32 {
    (size[0] as f32 / PLAIN[0]).min(size[1] as f32 / PLAIN[1]).max(1.0)
}
