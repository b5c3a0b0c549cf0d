//! Renderers that stay warm: a change of technique in one renderer would drop and upload textures.

use std::cell::OnceCell;
use std::sync::Arc;

use crate::gpu::{Gpu, Target};
use crate::heightfield::{ConeMap, HeightField};
use crate::render::{ConeGround, PreparedTerrain, RenderError, Renderer};
use crate::scene::{CraterMode, CraterSettings, Scene, Technique};

/// Scenes of one kind need the same textures. Techniques that sample uniformly need only the heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    own: Option<Technique>,
    craters: Option<CraterMode>,
    /// Whether light is kept in a map, which another scene would drop.
    baked: bool,
}

/// Renderers by the textures that their scenes need, and one target for all.
pub(super) struct Studio {
    pub(super) gpu: Arc<Gpu>,
    pub(super) map: Arc<HeightField>,
    pub(super) target: Target,
    renderers: Vec<(Kind, Renderer)>,
    /// The cones of the map, each kind found once for all renderers.
    cones: Vec<Arc<ConeMap>>,
    terrain: OnceCell<PreparedTerrain>,
    coloured: bool,
}

impl Studio {
    /// `scene` tells whether the pictures will need the map's own colours.
    pub(super) fn new(gpu: &Arc<Gpu>, map: &Arc<HeightField>, size: [u32; 2], scene: &Scene) -> Self {
        let target = Target::new(gpu, size);
        Self {
            gpu: Arc::clone(gpu),
            map: Arc::clone(map),
            target,
            renderers: Vec::new(),
            cones: Vec::new(),
            terrain: OnceCell::new(),
            coloured: scene.diffuse.enabled && scene.diffuse.file.is_none(),
        }
    }

    /// The map with its pyramid and, where its pictures need them, its colours: made once for all renderers.
    pub(super) fn terrain(&self) -> &PreparedTerrain {
        self.terrain.get_or_init(|| {
            let terrain = PreparedTerrain::new(Arc::clone(&self.map));
            if self.coloured { terrain.with_colours() } else { terrain }
        })
    }

    /// A renderer that no scene has used yet.
    pub(super) fn fresh(&self) -> Result<Renderer, RenderError> {
        let mut renderer = Renderer::new(Arc::clone(&self.gpu))?;
        renderer.set_prepared_terrain(self.terrain().clone())?;
        self.hand_over_cones(&mut renderer);
        Ok(renderer)
    }

    /// Gives a renderer of the map the cones that are known.
    pub(super) fn hand_over_cones(&self, renderer: &mut Renderer) {
        let most_texture = self.gpu.capabilities.max_texture;
        let ground = ConeGround::new(&self.map, &CraterSettings::default(), most_texture);
        for cones in &self.cones {
            renderer.set_cones(ground.clone(), Arc::clone(cones));
        }
    }

    /// Gives up the renderers that have been used, and their memory.
    pub(super) fn clear(&mut self) {
        self.renderers.clear();
    }

    /// Keeps cones of the map for all renderers to come.
    pub(super) fn keep(&mut self, cones: Arc<ConeMap>) {
        self.cones.push(cones);
    }

    /// The renderer for scenes such as `scene`, and the target.
    pub(super) fn renderer(&mut self, scene: &Scene) -> Result<(&mut Renderer, &Target), RenderError> {
        let technique = scene.march.technique;
        let kind = Kind {
            own: (!technique.samples_uniformly()).then_some(technique),
            craters: (!scene.craters.list.is_empty()).then_some(scene.craters.mode),
            baked: scene.lighting.baked,
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
