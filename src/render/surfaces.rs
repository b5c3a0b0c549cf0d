//! What techniques have to know of the ground besides its heights: bounds of other surfaces, and cones.

use std::sync::Arc;

use crate::heightfield::bounds::Rule;
use crate::heightfield::{ConeKind, ConeMap};
use crate::scene::Scene;

use super::cones::ConeGround;
use super::ground::Ground;
use super::prepare::{Aim, View, terrains};
use super::split::Side;
use super::terrain::TerrainKey;
use super::{RenderError, Renderer};

impl Renderer {
    /// The ground as a picture of `scene` has it, for a probe between pictures that walks its pyramid: what bounds another
    /// surface besides is not taken down for that.
    ///
    /// # Errors
    /// [`RenderError::Impossible`] where there is no such picture.
    pub(super) fn prepare_ground(&mut self, scene: &Scene, view: &View) -> Result<(), RenderError> {
        let Some(ground) = &mut self.ground else { return Ok(()) };
        let terrains = terrains(scene, view.size, Aim::Picture, view.deep);
        check_surfaces(&terrains, ground.has_holes())?;
        let rule = surfaces(ground, scene, &terrains);
        ground.prepare(&self.gpu, &scene.craters, true, rule);
        self.uploaded += ground.take_uploaded();
        Ok(())
    }

    /// Finds what the technique of `scene` needs to know of the terrain, so that the next frame need not: its cone map,
    /// where it steps along cones. `progress` hears the share that is done, 0 to 1, from any thread. A map of cones is
    /// of this ground alone, and kept; on another ground, and without this call, a frame finds it by itself.
    pub fn prepare_cones(&mut self, scene: &Scene, progress: &(dyn Fn(f32) + Sync)) {
        let key = TerrainKey::of(scene, false);
        let (Some(ground), Some(kind)) = (&mut self.ground, key.needs_cones()) else { return };
        // All else is left to the frame: what its cones stand on is not what is on the GPU.
        ground.prepare_cones(&self.gpu, &scene.craters, &[kind], progress);
        self.uploaded += ground.take_uploaded();
    }

    /// The ground of `scene` and the kinds of cones on it that its next frame would have to find, because a technique of
    /// the scene steps along them and they are not known; `None` where there is nothing to find.
    ///
    /// [`ConeMap::build_while`] finds them on [`ConeGround::field`], on another thread for instance;
    /// [`Self::set_cones`] takes them.
    pub fn missing_cones(&self, scene: &Scene) -> Option<(ConeGround, Vec<ConeKind>)> {
        let ground = self.ground.as_ref()?;
        let compared = scene.compare.enabled.then_some(scene.compare.technique);
        let techniques = [Some(scene.march.technique), compared];
        let keys = techniques.into_iter().flatten().map(|technique| TerrainKey::of_technique(scene, technique, false));
        let mut kinds: Vec<_> = keys.filter_map(|key| key.needs_cones()).collect();
        kinds.dedup();
        if kinds.is_empty() {
            return None;
        }
        let stand = ground.cone_ground(&self.gpu, &scene.craters);
        kinds.retain(|&kind| ground.known_cones().find(&stand, kind).is_none());
        (!kinds.is_empty()).then_some((stand, kinds))
    }

    /// Gives the renderer a map of cones for `ground`, so that no frame has to find it. It may serve several renderers. One
    /// for a height map that is not the renderer's is of no use and not kept, nor is one with other cells.
    pub fn set_cones(&mut self, ground: ConeGround, cones: Arc<ConeMap>) {
        if let Some(own) = &mut self.ground
            && Arc::ptr_eq(own.terrain().base(), ground.map())
            && cones.cells() == ground.map().cells()
        {
            own.set_cones(ground, cones);
        }
    }
}

/// Refuses surfaces that this ground cannot have.
pub(super) fn check_surfaces(terrains: &[(Side, TerrainKey)], has_holes: bool) -> Result<(), RenderError> {
    for (_, key) in terrains {
        if has_holes && key.is_fractal() {
            return Err(RenderError::Impossible {
                what: "invented detail on a map with holes",
                why: "how rough it is follows from the samples around",
                instead: "fill the holes (--holes fill), or choose another technique",
            });
        }
        if key.is_fractal() && key.layered {
            return Err(RenderError::Impossible {
                what: "invented detail on layered craters",
                why: "its bounds are those of the heights that the craters are baked into",
                instead: "bake the craters (craters.mode = \"baked\"), or choose another technique",
            });
        }
        if has_holes && key.is_smooth() {
            return Err(RenderError::Impossible {
                what: "the smooth surface of a map with holes",
                why: "it needs a height at every sample",
                instead: "fill the holes (--holes fill), or choose another technique",
            });
        }
    }
    Ok(())
}

/// Which surfaces the pyramid has to bound for these draws.
pub(super) fn surfaces(ground: &mut Ground, scene: &Scene, terrains: &[(Side, TerrainKey)]) -> Rule {
    let fractal = terrains.iter().any(|(_, key)| key.is_fractal());
    Rule {
        smooth: terrains.iter().any(|(_, key)| key.is_smooth()),
        detail: fractal.then(|| ground.detail(scene.detail.strength)),
    }
}
