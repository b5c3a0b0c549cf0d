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
    /// None: it was lost, and is to be made anew.
    inner: Option<wgpu::Surface<'static>>,
    config: wgpu::SurfaceConfiguration,
    window: Arc<Window>,
    stale: bool,
    failures: u32,
}

/// What helps where the surface has no texture to draw to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Remedy {
    /// It comes by itself, soon.
    Wait,
    /// It comes once the window can be seen.
    Hide,
    /// The surface has to be configured anew.
    Configure,
    /// There has to be a new surface.
    Create,
    /// Nothing that can be done with this device.
    GiveUp(&'static str),
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
        Ok(Self { inner: Some(inner), config, window, stale: true, failures: 0 })
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

    /// Loses the surface as a window system may at any time: it is gone, and with it what it would have shown. For a key
    /// of debug builds.
    pub(crate) fn lose(&mut self) {
        self.inner = None;
    }

    /// The texture to draw to. An outdated surface is configured anew, a lost one is made anew.
    pub(crate) fn acquire(&mut self, gpu: &Gpu) -> Acquired {
        let answer = match &self.inner {
            None => CurrentSurfaceTexture::Lost,
            Some(inner) => {
                if std::mem::take(&mut self.stale) {
                    inner.configure(&gpu.device, &self.config);
                }
                inner.get_current_texture()
            }
        };
        let remedy = remedy(&answer, self.failures);
        match answer {
            CurrentSurfaceTexture::Success(frame) => {
                self.failures = 0;
                Acquired::Frame(frame)
            }
            CurrentSurfaceTexture::Suboptimal(frame) => {
                // Still good for this frame; configuring while it is alive is forbidden.
                (self.failures, self.stale) = (0, true);
                Acquired::Frame(frame)
            }
            _ => self.apply(remedy, gpu),
        }
    }

    fn apply(&mut self, remedy: Remedy, gpu: &Gpu) -> Acquired {
        match remedy {
            Remedy::Wait => return Acquired::Later,
            Remedy::Hide => return Acquired::Hidden,
            Remedy::GiveUp(reason) => return Acquired::Lost(reason.into()),
            Remedy::Configure => {}
            Remedy::Create => {
                log::info!("the window's surface was lost and is made anew");
                // The old one lets go of the window first: some drivers allow a window one surface.
                self.inner = None;
                match gpu.instance.create_surface(self.window.clone()) {
                    Ok(surface) => self.inner = Some(surface),
                    Err(error) => return Acquired::Lost(error.to_string()),
                }
            }
        }
        self.failures += 1;
        self.stale = true;
        Acquired::Later
    }
}

/// What to do about an answer that brings no texture, after so many failures in a row.
fn remedy(answer: &CurrentSurfaceTexture, failures: u32) -> Remedy {
    let patient = failures + 1 < PATIENCE;
    match answer {
        CurrentSurfaceTexture::Occluded => Remedy::Hide,
        CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation if patient => Remedy::Configure,
        CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation => Remedy::GiveUp("it stays outdated"),
        CurrentSurfaceTexture::Lost if patient => Remedy::Create,
        CurrentSurfaceTexture::Lost => Remedy::GiveUp("it is lost again and again"),
        CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Success(_) | CurrentSurfaceTexture::Suboptimal(_) => {
            Remedy::Wait
        }
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

    /// A surface that is lost or outdated comes back; one that never does is the device's fault; a hidden one costs
    /// nothing and is no fault at all.
    #[test]
    fn every_trouble_has_its_remedy() {
        use CurrentSurfaceTexture::{Lost, Occluded, Outdated, Timeout, Validation};
        for failures in 0..PATIENCE - 1 {
            assert_eq!(remedy(&Lost, failures), Remedy::Create);
            assert_eq!(remedy(&Outdated, failures), Remedy::Configure);
            assert_eq!(remedy(&Validation, failures), Remedy::Configure);
        }
        for trouble in [Lost, Outdated, Validation] {
            assert!(matches!(remedy(&trouble, PATIENCE - 1), Remedy::GiveUp(_)), "{trouble:?}");
        }
        for failures in [0, PATIENCE, u32::MAX - 1] {
            assert_eq!(remedy(&Timeout, failures), Remedy::Wait);
            assert_eq!(remedy(&Occluded, failures), Remedy::Hide);
        }
    }
}
