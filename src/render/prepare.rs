//! From a scene to the draws of a frame: brings textures, pipelines and uniforms up to date.

use std::rc::Rc;

use glam::{DMat4, DVec3, DVec4};

use crate::camera::{Camera, NamedView};
use crate::scene::Scene;

use super::beam::Beams;
use super::cube::{clip_corners, in_view};
use super::frame::FrameUniform;
use super::pipelines::{Built, PipelineKey};
use super::skybox::Skybox;
use super::terrain::{TerrainKey, TerrainUniform, Textures};
use super::{RenderError, Renderer, occluder, terrain, wireframe};

/// One draw of the scene's render pass.
pub(super) struct Draw {
    pub(super) name: &'static str,
    pub(super) built: Rc<Built>,
    pub(super) group: wgpu::BindGroup,
    pub(super) edges: bool,
}

/// What a frame or a probe draws.
pub(super) struct Passes {
    /// The beam pass's pipeline and bind group, where the terrain's technique starts from beams.
    pub(super) beam: Option<(Rc<Built>, wgpu::BindGroup)>,
    /// Draws of the scene's pass, in their order.
    pub(super) draws: Vec<Draw>,
}

/// Where things are in a frame.
pub(super) struct View {
    pub(super) camera: Camera,
    pub(super) clip_from_world: DMat4,
    /// Size of the terrain's box.
    pub(super) extent: DVec3,
}

impl Renderer {
    /// Brings textures and uniforms up to date with `scene`; returns what to draw. Where that fails nothing is drawn; the
    /// next frame brings up to date whatever then differs.
    pub(super) fn prepare(&mut self, scene: &Scene, size: [u32; 2], probe: bool) -> Result<Passes, RenderError> {
        let view = self.view(scene, size);
        let key = TerrainKey::of(scene, probe);
        if !probe {
            self.prepare_drape(scene, key)?;
            self.prepare_skybox(scene)?;
        }
        if let Some(ground) = &mut self.ground {
            ground.prepare(&self.gpu, &scene.craters, key.needs_pyramid());
            if !probe && let Some(rect) = ground.take_changed() {
                let field = ground.terrain().field();
                self.uploaded += self.drape.as_mut().map_or(0, |drape| drape.update(&self.gpu, field, rect));
            }
            self.uploaded += ground.take_uploaded();
        }
        let frame = FrameUniform::new(&view.camera, size, view.extent, scene.skybox.flattening);
        self.frame.write(&self.gpu, &frame);

        let mut draws = Vec::new();
        self.prepare_beams(&view, size, key);
        draws.extend(self.terrain_draw(scene, &view, key)?);
        let beam = if draws.is_empty() { None } else { self.beam_pass()? };
        if scene.debug.wireframe && !probe {
            draws.extend(self.wireframe_draw(&view)?);
        }
        if scene.occluder.enabled {
            draws.extend(self.occluder_draw(scene, &view, probe)?);
        }
        if !probe && let Some(skybox) = &self.skybox {
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Skybox)?;
            let group = skybox.group(&self.gpu, &built);
            draws.push(Draw { name: "skybox", built, group, edges: false });
        }
        Ok(Passes { beam, draws })
    }

    fn view(&self, scene: &Scene, size: [u32; 2]) -> View {
        let (camera, extent) = match &self.ground {
            Some(ground) => {
                let map = ground.terrain().base();
                let extent = map.box_size(scene.terrain.height_scale);
                (scene.camera.unwrap_or_else(|| NamedView::Start.camera(map, extent)), extent)
            }
            None => {
                let camera = Camera { eye: DVec3::ZERO, yaw: 0.0, pitch: 0.0, fov: Camera::DEFAULT_FOV };
                (scene.camera.unwrap_or(camera), DVec3::ZERO)
            }
        };
        View { camera, clip_from_world: camera.clip_from_world(size), extent }
    }

    fn prepare_drape(&mut self, scene: &Scene, key: TerrainKey) -> Result<(), RenderError> {
        let Some(drape) = &mut self.drape else { return Ok(()) };
        if !key.diffuse {
            drape.drop_texture();
            return Ok(());
        }
        let Some(ground) = &mut self.ground else { return Ok(()) };
        let field = ground.terrain().field();
        if drape.prepare(&self.gpu, &scene.diffuse, field)? {
            // A texture painted now shows all craters of the last frame already.
            ground.take_changed();
        }
        self.uploaded += drape.take_uploaded();
        Ok(())
    }

    fn prepare_skybox(&mut self, scene: &Scene) -> Result<(), RenderError> {
        if !scene.skybox.enabled {
            self.skybox = None;
        } else if !self.skybox.as_ref().is_some_and(|skybox| skybox.matches(scene)) {
            let (skybox, uploaded) = Skybox::new(&self.gpu, scene)?;
            self.uploaded += uploaded;
            self.skybox = Some(skybox);
        }
        Ok(())
    }

    /// Keeps room for the starts of the picture's tiles while the terrain is in view and walked from them.
    fn prepare_beams(&mut self, view: &View, size: [u32; 2], key: TerrainKey) {
        if !key.needs_pyramid() || !self.shows_terrain(view) {
            self.beams = None;
        } else if self.beams.as_ref().is_none_or(|beams| beams.size() != size) {
            self.beams = Some(Beams::new(&self.gpu, size));
        }
    }

    pub(super) fn beam_pass(&mut self) -> Result<Option<(Rc<Built>, wgpu::BindGroup)>, RenderError> {
        let (Some(_), Some(ground)) = (&self.beams, &self.ground) else { return Ok(None) };
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Beam)?;
        let group = self.terrain.beam_group(&self.gpu, &built, ground);
        Ok(group.map(|group| (built, group)))
    }

    fn shows_terrain(&self, view: &View) -> bool {
        self.ground.is_some() && in_view(&clip_corners(view.clip_from_world, terrain::world_from_box(view.extent)))
    }

    fn terrain_draw(&mut self, scene: &Scene, view: &View, key: TerrainKey) -> Result<Option<Draw>, RenderError> {
        let Some(ground) = &self.ground else { return Ok(None) };
        let box_clip = clip_corners(view.clip_from_world, terrain::world_from_box(view.extent));
        if !in_view(&box_clip) {
            return Ok(None);
        }
        if key.filters_heights() && !self.gpu.capabilities.filterable_float32 {
            return Err(RenderError::Unsupported {
                what: "hardware-linear filtering of heights",
                needs: "the feature float32-filterable",
                instead: "choose the filter `exact`, which is also more precise",
            });
        }
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Terrain(key))?;
        let uniform = TerrainUniform::new(scene, ground, self.drape.as_ref(), view.extent, &box_clip);
        let textures = Textures { ground, drape: self.drape.as_ref(), beams: self.beams.as_ref() };
        let group = self.terrain.prepare(&self.gpu, &built, key, &uniform, &textures);
        Ok(group.map(|group| Draw { name: "terrain", built, group, edges: false }))
    }

    fn wireframe_draw(&mut self, view: &View) -> Result<Option<Draw>, RenderError> {
        // A little outside the box, so that its own walls do not cut the edges into dashes.
        let clip: [DVec4; 8] = clip_corners(view.clip_from_world, terrain::world_from_box(view.extent));
        if self.ground.is_none() || !in_view(&clip) {
            return Ok(None);
        }
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Wireframe)?;
        let group = self.wireframe.prepare(&self.gpu, &built, &wireframe::uniform(&clip));
        Ok(Some(Draw { name: "wireframe", built, group, edges: true }))
    }

    fn occluder_draw(&mut self, scene: &Scene, view: &View, probe: bool) -> Result<Option<Draw>, RenderError> {
        let Some(ground) = &self.ground else { return Ok(None) };
        let world_from_cube = occluder::world_from_cube(&scene.occluder, ground.terrain().base(), view.extent);
        let clip = clip_corners(view.clip_from_world, world_from_cube);
        if !in_view(&clip) {
            return Ok(None);
        }
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Occluder { probe })?;
        let group =
            self.occluder.prepare(&self.gpu, &built, &occluder::uniform(&clip, world_from_cube, &scene.lighting));
        Ok(Some(Draw { name: "occluder", built, group, edges: false }))
    }
}
