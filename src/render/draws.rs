//! The draws of the cubes: terrain, wireframe, occluder.

use crate::scene::Scene;

use super::cube::{as_f32, clip_corners, in_view};
use super::distances::ExactDistances;
use super::missing::occluder_key;
use super::occluder::OccluderKey;
use super::pipelines::PipelineKey;
use super::prepare::{Aim, Draw, View};
use super::split::{Area, Side};
use super::terrain::{TerrainKey, TerrainUniform, Textures};
use super::{RenderError, Renderer, occluder, terrain, wireframe};

impl Renderer {
    pub(super) fn terrain_draw(
        &mut self,
        scene: &Scene,
        view: &View,
        side: Side,
        key: TerrainKey,
        aim: Aim<'_>,
    ) -> Result<Option<Draw>, RenderError> {
        let Some(ground) = &self.ground else { return Ok(None) };
        if !in_view(&view.box_clip) {
            return Ok(None);
        }
        if !self.reads(ground, &key) {
            return Err(RenderError::Unsupported {
                what: "hardware-linear filtering of these heights",
                needs: "the feature float32-filterable",
                instead: "choose the filter `exact`, which is also more precise",
            });
        }
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Terrain(key))?;
        let mut uniform = TerrainUniform::new(scene, ground, self.drape.as_ref(), view.extent, &view.box_clip);
        if view.deep && key.finds_ground() {
            uniform.box_clip = as_f32(&terrain::whole_picture());
        }
        let textures = Textures {
            ground,
            drape: self.drape.as_ref(),
            land: &self.land,
            materials: self.materials.as_ref(),
            atmosphere: &self.atmosphere,
            beams: self.beams.as_ref(),
            light_map: self.baking.map.as_ref(),
            given: if let Aim::Given(distances) = aim { Some(distances) } else { None },
            exact: self.reference.as_ref().or(self.exact.as_ref()).map(ExactDistances::view),
        };
        let group = self.terrain.prepare(&self.gpu, &built, key, &uniform, &textures);
        Ok(group.map(|group| Draw { name: side.name, built, group, edges: false, area: side.area }))
    }

    pub(super) fn wireframe_draw(&mut self, view: &View, area: Area) -> Result<Option<Draw>, RenderError> {
        // A little outside the box, so that its own walls do not cut the edges into dashes.
        let clip = clip_corners(view.clip_from_world, terrain::world_from_box(view.extent));
        if self.ground.is_none() || !in_view(&clip) {
            return Ok(None);
        }
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Wireframe)?;
        let group =
            self.wireframe.prepare(&self.gpu, &built, OccluderKey::default(), &wireframe::uniform(&clip), Vec::new());
        Ok(Some(Draw { name: "wireframe", built, group, edges: true, area }))
    }

    pub(super) fn occluder_draw(
        &mut self,
        scene: &Scene,
        view: &View,
        area: Area,
        probe: bool,
    ) -> Result<Option<Draw>, RenderError> {
        let Some(ground) = &self.ground else { return Ok(None) };
        let world_from_cube = occluder::world_from_cube(&scene.occluder, ground.terrain().base(), view.extent);
        let clip = clip_corners(view.clip_from_world, world_from_cube);
        if !in_view(&clip) {
            return Ok(None);
        }
        let key = occluder_key(scene, ground, probe);
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Occluder(key))?;
        let uniform = occluder::uniform(&clip, world_from_cube, &scene.lighting);
        let mut entries = Vec::new();
        if key.casts_shadows() {
            if !in_view(&view.box_clip) {
                // The terrain's own pass has not written it.
                let uniform = TerrainUniform::new(scene, ground, self.drape.as_ref(), view.extent, &view.box_clip);
                self.terrain.write(&self.gpu, &uniform);
            }
            let Some(shadow) = self.terrain.shadow_entries(ground, &self.terrain.light) else { return Ok(None) };
            entries = shadow;
        }
        let Some(air) = self.atmosphere.entries(key.air) else { return Ok(None) };
        entries.extend(air);
        let group = self.occluder.prepare(&self.gpu, &built, key, &uniform, entries);
        Ok(Some(Draw { name: "occluder", built, group, edges: false, area }))
    }
}
