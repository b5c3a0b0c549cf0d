//! What lives on the GPU: device, renderer, the kept picture, egui's painter and the surface. Dropped and made anew as
//! a whole when the device is lost.

use std::sync::Arc;

use egui::epaint::ClippedPrimitive;
use egui::epaint::textures::TexturesDelta;
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use winit::window::Window;

use super::AppError;
use super::surface::{Acquired, Surface};
use crate::gpu::{Gpu, Target};
use crate::heightfield::HeightField;
use crate::render::{RenderError, Renderer};

/// Most texels of a light map that a frame of the viewer draws: a fraction of a second in software, and on a GPU.
const BAKED_IN_SOFTWARE: u32 = 1 << 15;
const BAKED_PER_FRAME: u32 = 1 << 19;

/// What egui wants on screen.
pub(crate) struct Ui {
    /// Textures to change before and to free after drawing.
    pub(crate) textures: TexturesDelta,
    /// What to draw.
    pub(crate) primitives: Vec<ClippedPrimitive>,
    /// Physical pixels per point.
    pub(crate) pixels_per_point: f32,
}

impl Drop for Ui {
    fn drop(&mut self) {
        // egui insists that changes are applied; after a lost device there is nothing to apply them to.
        self.textures.clear();
    }
}

/// What became of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    /// It is on screen.
    Yes,
    /// The surface was not ready; try again soon.
    Later,
    /// Nobody sees the window.
    Hidden,
    /// The surface is gone and does not come back with this device.
    Lost(String),
}

/// Everything on the GPU.
pub(crate) struct Graphics {
    /// Adapter and device.
    pub(crate) gpu: Arc<Gpu>,
    /// Draws scenes.
    pub(crate) renderer: Renderer,
    /// The kept picture.
    pub(crate) target: Target,
    painter: egui_wgpu::Renderer,
    surface: Surface,
}

impl Graphics {
    /// Device, surface and renderer for a window, with its terrain.
    pub(crate) fn new(window: &Arc<Window>, map: Arc<HeightField>, vsync: bool) -> Result<Self, AppError> {
        let instance = Gpu::instance();
        let surface = instance.create_surface(window.clone()).map_err(|error| AppError::Surface(error.to_string()))?;
        let gpu = Gpu::for_surface(instance, &surface)?;
        let surface = Surface::new(&gpu, surface, window.clone(), vsync)?;
        let painter = egui_wgpu::Renderer::new(&gpu.device, surface.format(), RendererOptions::default());
        let mut renderer = Renderer::new(gpu.clone())?;
        renderer.set_terrain(map)?;
        let target = Target::new(&gpu, surface.size());
        let mut graphics = Self { gpu, renderer, target, painter, surface };
        graphics.limit_baking();
        Ok(graphics)
    }

    /// Lets frames draw a light map by parts.
    pub(crate) fn limit_baking(&mut self) {
        let software = self.gpu.capabilities.software;
        self.renderer.set_bake_budget(Some(if software { BAKED_IN_SOFTWARE } else { BAKED_PER_FRAME }));
    }

    /// Follows the window's size and the choice of vsync. True when the kept picture is gone with its old size.
    pub(crate) fn follow(&mut self, size: [u32; 2], vsync: bool) -> bool {
        self.surface.follow(size, vsync, self.gpu.capabilities.max_texture);
        let resized = self.target.size() != self.surface.size();
        if resized {
            self.target = Target::new(&self.gpu, self.surface.size());
        }
        resized
    }

    /// Loses the surface, as a window system may: [`Surface::lose`].
    pub(crate) fn lose_surface(&mut self) {
        self.surface.lose();
    }

    /// Shows the kept picture, where there is one, and egui over it: one pass.
    pub(crate) fn present(&mut self, window: &Window, mut ui: Ui, picture: bool) -> Result<Shown, RenderError> {
        let Gpu { device, queue, .. } = &*self.gpu;
        for (id, deltas) in ui.textures.set.drain() {
            for delta in deltas {
                self.painter.update_texture(device, queue, id, &delta);
            }
        }
        let shown = self.paint(window, &ui, picture);
        for id in ui.textures.free.drain() {
            self.painter.free_texture(&id);
        }
        shown
    }

    fn paint(&mut self, window: &Window, ui: &Ui, picture: bool) -> Result<Shown, RenderError> {
        let frame = match self.surface.acquire(&self.gpu) {
            Acquired::Frame(frame) => frame,
            Acquired::Later => return Ok(Shown::Later),
            Acquired::Hidden => return Ok(Shown::Hidden),
            Acquired::Lost(reason) => return Ok(Shown::Lost(reason)),
        };
        let Gpu { device, queue, .. } = &*self.gpu;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("present") });
        let screen = ScreenDescriptor { size_in_pixels: self.surface.size(), pixels_per_point: ui.pixels_per_point };
        let mut commands = self.painter.update_buffers(device, queue, &mut encoder, &ui.primitives, &screen);
        let view = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("present"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            })
            .forget_lifetime();
        if picture {
            self.renderer.present(&mut pass, self.surface.format(), &self.target)?;
        }
        self.painter.render(&mut pass, &ui.primitives, &screen);
        drop(pass);
        self.renderer.note_pass("egui", u32::try_from(ui.primitives.len()).unwrap_or(u32::MAX));
        commands.push(encoder.finish());
        queue.submit(commands);
        window.pre_present_notify();
        queue.present(frame);
        Ok(Shown::Yes)
    }
}
