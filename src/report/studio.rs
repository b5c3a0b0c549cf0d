//! Renderers that stay warm: a change of technique in one renderer would drop and upload textures.

use std::sync::Arc;

use crate::gpu::{Gpu, Target};
use crate::heightfield::HeightField;
use crate::render::{RenderError, Renderer};
use crate::scene::{CraterMode, Scene, Technique};

/// Scenes of one kind need the same textures. Techniques that sample uniformly need only the heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    own: Option<Technique>,
    craters: Option<CraterMode>,
}

/// Renderers by the textures that their scenes need, and one target for all.
pub(super) struct Studio {
    pub(super) gpu: Arc<Gpu>,
    pub(super) map: Arc<HeightField>,
    pub(super) target: Target,
    renderers: Vec<(Kind, Renderer)>,
}

impl Studio {
    pub(super) fn new(gpu: &Arc<Gpu>, map: &Arc<HeightField>, size: [u32; 2]) -> Self {
        Self { gpu: Arc::clone(gpu), map: Arc::clone(map), target: Target::new(gpu, size), renderers: Vec::new() }
    }

    /// A renderer that no scene has used yet.
    pub(super) fn fresh(&self) -> Result<Renderer, RenderError> {
        let mut renderer = Renderer::new(Arc::clone(&self.gpu))?;
        renderer.set_terrain(Arc::clone(&self.map))?;
        Ok(renderer)
    }

    /// The renderer for scenes such as `scene`, and the target.
    pub(super) fn renderer(&mut self, scene: &Scene) -> Result<(&mut Renderer, &Target), RenderError> {
        let technique = scene.march.technique;
        let kind = Kind {
            own: (!technique.samples_uniformly()).then_some(technique),
            craters: (!scene.craters.list.is_empty()).then_some(scene.craters.mode),
        };
        let index = match self.renderers.iter().position(|(known, _)| *known == kind) {
            Some(index) => index,
            None => {
                self.renderers.push((kind, self.fresh()?));
                self.renderers.len() - 1
            }
        };
        Ok((&mut self.renderers[index].1, &self.target))
    }

    /// Draws a frame and waits for it; its time in milliseconds.
    pub(super) fn frame(&mut self, scene: &Scene) -> Result<f64, RenderError> {
        let (renderer, target) = self.renderer(scene)?;
        renderer.draw(scene, target)?;
        renderer.wait_frame_time()
    }

    /// The picture of the last frame.
    pub(super) fn picture(&self) -> Result<image::RgbImage, RenderError> {
        Ok(image::DynamicImage::ImageRgba8(self.target.read_color(&self.gpu)?).into_rgb8())
    }
}
