//! The window's surface. Whatever can happen to it comes out of [`Surface::acquire`] as a value.

use std::sync::Arc;

use wgpu::{CurrentSurfaceTexture, PresentMode, SurfaceTexture, TextureFormat};
use winit::window::Window;

use super::AppError;
use crate::gpu::Gpu;

/// So many times in a row a surface may fail before the device is blamed.
const PATIENCE: u32 = 4;

/// What became of the wish to draw.
pub(crate) enum Acquired {
    /// Draw here, then present it.
    Frame(SurfaceTexture),
    /// Nothing to draw to now; try again soon.
    Later,
    /// Nobody sees the window; the window system tells when that changes.
    Hidden,
    /// The surface cannot be had any more.
    Lost(String),
}

/// A surface, configured for a window.
pub(crate) struct Surface {
    inner: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    window: Arc<Window>,
    stale: bool,
    failures: u32,
}

impl Surface {
    /// Configures `inner`, which was made by the instance of `gpu` for `window`.
    pub(crate) fn new(
        gpu: &Gpu,
        inner: wgpu::Surface<'static>,
        window: Arc<Window>,
        vsync: bool,
    ) -> Result<Self, AppError> {
        let unusable = || AppError::Surface("the adapter cannot present to it".into());
        let adapter = gpu.adapter.as_ref().ok_or_else(unusable)?;
        let size = clamped(window.inner_size().into(), gpu.capabilities.max_texture);
        let mut config = inner.get_default_config(adapter, size[0], size[1]).ok_or_else(unusable)?;
        config.format = preferred(&inner.get_capabilities(adapter).formats).unwrap_or(config.format);
        config.present_mode = present_mode(vsync);
        Ok(Self { inner, config, window, stale: true, failures: 0 })
    }

    /// The format of its textures.
    pub(crate) fn format(&self) -> TextureFormat {
        self.config.format
    }

    /// Width and height in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Follows the window's size and the choice of vsync; both take effect with the next [`Surface::acquire`].
    pub(crate) fn follow(&mut self, size: [u32; 2], vsync: bool, limit: u32) {
        let [width, height] = clamped(size, limit);
        let mode = present_mode(vsync);
        if (width, height, mode) != (self.config.width, self.config.height, self.config.present_mode) {
            (self.config.width, self.config.height, self.config.present_mode) = (width, height, mode);
            self.stale = true;
        }
    }

    /// The texture to draw to. An outdated surface is configured anew, a lost one is made anew.
    pub(crate) fn acquire(&mut self, gpu: &Gpu) -> Acquired {
        if std::mem::take(&mut self.stale) {
            self.inner.configure(&gpu.device, &self.config);
        }
        match self.inner.get_current_texture() {
            CurrentSurfaceTexture::Success(frame) => {
                self.failures = 0;
                Acquired::Frame(frame)
            }
            CurrentSurfaceTexture::Suboptimal(frame) => {
                // Still good for this frame; configuring while it is alive is forbidden.
                (self.failures, self.stale) = (0, true);
                Acquired::Frame(frame)
            }
            CurrentSurfaceTexture::Occluded => Acquired::Hidden,
            CurrentSurfaceTexture::Timeout => Acquired::Later,
            CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation => self.retry("it stays outdated"),
            CurrentSurfaceTexture::Lost => match gpu.instance.create_surface(self.window.clone()) {
                Ok(surface) => {
                    self.inner = surface;
                    self.retry("it is lost again and again")
                }
                Err(error) => Acquired::Lost(error.to_string()),
            },
        }
    }

    fn retry(&mut self, reason: &str) -> Acquired {
        self.failures += 1;
        self.stale = true;
        if self.failures < PATIENCE { Acquired::Later } else { Acquired::Lost(reason.into()) }
    }
}

/// egui blends in gamma space, so a format that does not convert comes first.
fn preferred(formats: &[TextureFormat]) -> Option<TextureFormat> {
    [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm].into_iter().find(|format| formats.contains(format))
}

fn present_mode(vsync: bool) -> PresentMode {
    if vsync { PresentMode::Fifo } else { PresentMode::AutoNoVsync }
}

/// A size that the device can make textures of.
fn clamped(size: [u32; 2], limit: u32) -> [u32; 2] {
    size.map(|side| side.clamp(1, limit.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_formats_come_first_and_sizes_stay_drawable() {
        let both = [TextureFormat::Bgra8UnormSrgb, TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm];
        assert_eq!(preferred(&both), Some(TextureFormat::Bgra8Unorm));
        assert_eq!(preferred(&[TextureFormat::Bgra8UnormSrgb]), None);
        assert_eq!(clamped([0, 20_000], 8192), [1, 8192]);
    }
}
