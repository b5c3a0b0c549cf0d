//! What a frame is drawn into, and the constants that all passes must agree on.

use super::{Gpu, ReadbackError, read_texture};

/// Format of the picture: shaders write linear light, the bytes are sRGB.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// The same bytes without the conversion, for copying them to a window.
pub(crate) const COLOR_BYTES_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of a probe: distance, steps, capped, kind.
pub const PROBE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Format of the depth buffer: reversed (near 1, far 0) with an infinite far plane.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// The depth of infinity.
pub const DEPTH_CLEAR: f32 = 0.0;
/// Nearer wins; equal wins too, so that edges on a face show.
pub const DEPTH_COMPARE: wgpu::CompareFunction = wgpu::CompareFunction::GreaterEqual;

/// Colour and depth of one size. Both are kept between frames, so that a change of the panel alone redraws only the
/// panel over the kept picture.
#[derive(Debug)]
pub struct Target {
    size: [u32; 2],
    pub(crate) color: wgpu::Texture,
    pub(crate) color_view: wgpu::TextureView,
    /// The picture's bytes, unconverted.
    pub(crate) bytes_view: wgpu::TextureView,
    pub(crate) depth: wgpu::Texture,
    pub(crate) depth_view: wgpu::TextureView,
}

impl Target {
    /// A target of `size` (width, height) pixels; zero is raised to 1.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let size = size.map(|side| side.clamp(1, gpu.capabilities.max_texture));
        let color = sized_texture(gpu, "picture", size, COLOR_FORMAT, &[COLOR_BYTES_FORMAT]);
        let depth = sized_texture(gpu, "depth", size, DEPTH_FORMAT, &[]);
        let color_view = color.create_view(&wgpu::TextureViewDescriptor::default());
        let bytes_view = color.create_view(&wgpu::TextureViewDescriptor {
            format: Some(COLOR_BYTES_FORMAT),
            usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
            ..Default::default()
        });
        let depth_view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        Self { size, color, color_view, bytes_view, depth, depth_view }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Reads the picture back: 8-bit sRGB with an opaque alpha, row 0 at the top. Waits for the GPU.
    ///
    /// # Errors
    /// [`ReadbackError`] where the device is lost or out of memory.
    pub fn read_color(&self, gpu: &Gpu) -> Result<image::RgbaImage, ReadbackError> {
        let bytes = read_texture(gpu, &self.color)?;
        image::RgbaImage::from_raw(self.size[0], self.size[1], bytes).ok_or(ReadbackError::Short)
    }
}

/// A texture that is drawn into, read by shaders and copied out.
pub(crate) fn sized_texture(
    gpu: &Gpu,
    label: &str,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    view_formats: &[wgpu::TextureFormat],
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats,
    })
}
