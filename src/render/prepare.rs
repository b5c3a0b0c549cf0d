//! From a scene to the draws of a frame: brings textures, pipelines and uniforms up to date.

use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4};

use crate::camera::{Camera, NamedView};
use crate::scene::{DebugView, Scene};
use crate::scene_file;

use super::air::AirKey;
use super::anchor::{self, Anchor, AnchorUniform};
use super::atmosphere::AirPasses;
use super::beam::{BeamPass, Beams, Tiles};
use super::cube::in_view;
use super::distances::ExactDistances;
use super::frame::FrameUniform;
use super::ground::Ground;
use super::light::LightKey;
use super::light_map::LightMapPass;
use super::materials::Materials;
use super::pipelines::{Built, PipelineKey};
use super::skybox::Skybox;
use super::split::{Area, Side, sides};
use super::surfaces::{check_surfaces, surfaces};
use super::terrain::TerrainKey;
use super::{RenderError, Renderer, terrain};

/// One draw of the scene's render pass.
pub(super) struct Draw {
    pub(super) name: &'static str,
    pub(super) built: Arc<Built>,
    pub(super) group: wgpu::BindGroup,
    pub(super) edges: bool,
    /// The part of the picture that it draws.
    pub(super) area: Area,
}

/// What a frame or a probe draws.
pub(super) struct Passes {
    /// Draw rows of the light map, where it is not that of the scene.
    pub(super) light_map: Vec<LightMapPass>,
    /// There where a technique starts from beams, with the part of the picture where rays do.
    pub(super) beams: Option<([BeamPass; 2], Area)>,
    /// Finds the exact distances, for the error view.
    pub(super) exact: Option<Draw>,
    /// Draws of the scene's pass, in their order.
    pub(super) draws: Vec<Draw>,
    /// What air, clouds and sun draw before and after.
    pub(super) air: AirPasses,
    /// What the rays of the exact technique count from, in a deep zoom; else empty.
    pub(super) anchors: Vec<Anchor>,
}

/// What a frame is drawn for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Aim<'a> {
    /// A picture.
    Picture,
    /// A picture whose terrain lies at the distances in this texture.
    Given(&'a wgpu::TextureView),
    /// Distances and steps.
    Probe,
    /// The same, with texel reads in place of steps.
    Reads,
}

impl Aim<'_> {
    /// Whether it is something else than a picture.
    pub(super) fn probes(self) -> bool {
        matches!(self, Self::Probe | Self::Reads)
    }
}

/// Where things are in a frame.
pub(super) struct View {
    pub(super) camera: Camera,
    pub(super) clip_from_world: DMat4,
    /// Size of the terrain's box.
    pub(super) extent: DVec3,
    /// Corners of the box that is drawn for it.
    pub(super) box_clip: [DVec4; 8],
    /// Whether its pixels are finer than f32 counts.
    pub(super) deep: bool,
    /// Of the picture, in pixels.
    pub(super) size: [u32; 2],
}

impl Renderer {
    /// Brings textures and uniforms up to date with `scene`; returns what to draw. Where that fails nothing is drawn; the
    /// next frame brings up to date whatever then differs.
    pub(super) fn prepare(&mut self, scene: &Scene, size: [u32; 2], aim: Aim<'_>) -> Result<Passes, RenderError> {
        scene_file::validate(scene)?;
        let view = self.view(scene, size);
        let probe = aim.probes();
        let has_holes = self.ground.as_ref().is_some_and(Ground::has_holes);
        let over_holes = |key: TerrainKey| key.over_holes(has_holes);
        let terrains: Vec<_> =
            terrains(scene, size, aim, view.deep).into_iter().map(|(side, key)| (side, over_holes(key))).collect();
        check_surfaces(&terrains, has_holes)?;
        if !probe {
            self.prepare_drape(scene, terrains.iter().any(|(_, key)| key.diffuse))?;
            self.prepare_skybox(scene)?;
            let land = terrains.first().map(|(_, key)| key.land).unwrap_or_default();
            self.prepare_land(land, &scene.land, view.extent)?;
        }
        let exact = self.prepare_exact(scene, &view, size, probe).map(|key| over_holes(key.in_a_deep_zoom(view.deep)));
        let whole = Area::whole(size);
        let beamed = terrains.iter().map(|(side, key)| (side.area, *key)).chain(exact.map(|key| (whole, key)));
        let beamed = beamed.filter(|(_, key)| key.starts_from_beams()).map(|(area, _)| area).reduce(Area::union);
        let light = if probe { LightKey::default() } else { LightKey::of_picture(scene) };
        let bakes = self.prepare_light(scene, &view, light, probe);
        let water = if probe { None } else { self.water_key(scene, view.deep, false) };
        if let Some(ground) = &mut self.ground {
            let walked = terrains.iter().any(|(_, key)| key.needs_pyramid())
                || beamed.is_some()
                || bakes
                || water.is_some()
                || light.occluder
                // A probe drops nothing that the pictures before and after it need.
                || (probe && ground.pyramid().is_some());
            let rule = surfaces(ground, scene, &terrains);
            ground.prepare(&self.gpu, &scene.craters, walked, rule);
            let kinds: Vec<_> = terrains.iter().filter_map(|(_, key)| key.needs_cones()).collect();
            ground.prepare_cones(&self.gpu, &scene.craters, &kinds, &|_| {});
            if !probe && let Some(rect) = ground.take_changed() {
                let field = ground.terrain().field();
                self.uploaded += self.drape.as_mut().map_or(0, |drape| drape.update(&self.gpu, field, rect));
            }
            self.uploaded += ground.take_uploaded();
        }
        if !probe {
            self.prepare_materials(scene, &view, terrains.iter().any(|(_, key)| key.materials.on))?;
        }
        let frame = FrameUniform::new(&view.camera, size, view.extent, scene.skybox.flattening);
        self.frame.write(&self.gpu, &frame);
        let counts = matches!(aim, Aim::Reads);
        self.prepare_beams(&view, size, beamed.map(|_| counts));
        let anchored = terrains.iter().map(|(_, key)| key).chain(&exact).any(|key| key.deep);
        let anchors = if anchored { self.prepare_anchors(scene, &view, size) } else { Vec::new() };

        let air = self.prepare_air(scene, &view, size, probe);
        let light_map = if bakes { self.light_map_passes()? } else { Vec::new() };
        let mut draws = Vec::new();
        for (side, key) in terrains {
            draws.extend(self.terrain_draw(scene, &view, side, key, aim)?);
        }
        let exact = match exact {
            Some(key) => {
                let side = Side { name: "exact", technique: key.technique, area: whole };
                self.terrain_draw(scene, &view, side, key, Aim::Probe)?
            }
            None => None,
        };
        let beams = match beamed.filter(|_| !draws.is_empty()) {
            Some(area) => self.beam_passes(counts)?.map(|passes| (passes, area)),
            None => None,
        };
        if let Some(key) = water {
            draws.extend(self.water_draw(scene, &view, whole, key)?);
        }
        if scene.debug.wireframe && !probe {
            draws.extend(self.wireframe_draw(&view, whole)?);
        }
        if scene.occluder.enabled {
            draws.extend(self.occluder_draw(scene, &view, whole, probe)?);
        }
        if !probe && let Some(skybox) = &self.skybox {
            let fog = AirKey::of(scene).of_sky().fog;
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Skybox(fog))?;
            let group = skybox.group(&self.gpu, &built, &self.atmosphere, fog);
            draws.push(Draw { name: "skybox", built, group, edges: false, area: whole });
        }
        if !probe {
            self.motion = self.motion_of(scene, &view, &draws);
            self.images.age();
        }
        Ok(Passes { light_map, beams, exact, draws, air, anchors })
    }

    /// Finds what the rays of a deep zoom count from, and hands it to the terrain pass.
    fn prepare_anchors(&self, scene: &Scene, view: &View, size: [u32; 2]) -> Vec<Anchor> {
        let Some(ground) = &self.ground else { return Vec::new() };
        let anchors = Anchor::find(&view.camera, size, view.extent, ground.terrain().field());
        let lid = if scene.march.lower_start { f64::from(ground.highest()) } else { 1.0 };
        let uniforms = AnchorUniform::all(&anchors, &view.camera, size, view.extent, ground, lid);
        self.terrain.write_anchors(&self.gpu, &uniforms);
        anchors
    }

    /// Keeps the texture of exact distances while the error view needs one of its own; what has to be drawn into it.
    fn prepare_exact(&mut self, scene: &Scene, view: &View, size: [u32; 2], probe: bool) -> Option<TerrainKey> {
        if probe {
            return None;
        }
        if scene.debug.view != DebugView::Error {
            (self.exact, self.reference) = (None, None);
            return None;
        }
        self.reference.take_if(|reference| reference.size() != size);
        if self.reference.is_some() || !self.shows_terrain(view) {
            self.exact = None;
            return None;
        }
        if self.exact.as_ref().is_none_or(|exact| exact.size() != size) {
            self.exact = Some(ExactDistances::new(&self.gpu, size));
        }
        Some(TerrainKey::of_exact_distances(scene))
    }

    pub(super) fn view(&self, scene: &Scene, size: [u32; 2]) -> View {
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
        let box_clip = terrain::drawn_box(&camera, size, extent);
        let deep = self.ground.is_some() && anchor::is_deep_zoom(&camera, size, extent);
        View { camera, clip_from_world: camera.clip_from_world(size), extent, box_clip, deep, size }
    }

    fn prepare_drape(&mut self, scene: &Scene, shown: bool) -> Result<(), RenderError> {
        let Some(drape) = &mut self.drape else { return Ok(()) };
        if !shown {
            drape.drop_texture();
            return Ok(());
        }
        let Some(ground) = &mut self.ground else { return Ok(()) };
        // Painted by the slopes of the map without craters, whenever that is: colours far from a crater stay as they are.
        if drape.prepare(&self.gpu, &scene.diffuse, ground.terrain().base(), &mut self.images)? {
            ground.take_changed();
            if let Some(rect) = ground.terrain().displaced() {
                self.uploaded += drape.update(&self.gpu, ground.terrain().field(), rect);
            }
        }
        self.uploaded += drape.take_uploaded();
        Ok(())
    }

    /// Keeps the materials' textures while a frame shows them.
    fn prepare_materials(&mut self, scene: &Scene, view: &View, shown: bool) -> Result<(), RenderError> {
        let Some(ground) = self.ground.as_ref().filter(|_| shown) else {
            self.materials = None;
            return Ok(());
        };
        let materials = self.materials.get_or_insert_with(|| Materials::new(&self.gpu));
        let result = materials.prepare(&self.gpu, scene, ground, view.extent, &mut self.images);
        self.uploaded += materials.take_uploaded();
        result
    }

    fn prepare_skybox(&mut self, scene: &Scene) -> Result<(), RenderError> {
        // In the error view the sky is where nothing is wrong: it must not look like anything.
        if !scene.skybox.enabled || scene.debug.view == DebugView::Error {
            self.skybox = None;
        } else if !self.skybox.as_ref().is_some_and(|skybox| skybox.matches(scene)) {
            let (skybox, uploaded) = Skybox::new(&self.gpu, scene, &mut self.images)?;
            self.uploaded += uploaded;
            self.skybox = Some(skybox);
        }
        Ok(())
    }

    /// Keeps room for the starts of the picture's tiles while the terrain is in view and walked from them; `counts` says
    /// that it is, and whether texel reads are counted.
    fn prepare_beams(&mut self, view: &View, size: [u32; 2], counts: Option<bool>) {
        let Some(counts) = counts.filter(|_| self.shows_terrain(view)) else {
            self.beams = None;
            return;
        };
        if !self.beams.as_ref().is_some_and(|beams| beams.suit(size, counts)) {
            self.beams = Some(Beams::new(&self.gpu, size, counts));
        }
    }

    fn beam_passes(&mut self, counts: bool) -> Result<Option<[BeamPass; 2]>, RenderError> {
        let (Some(beams), Some(ground)) = (&self.beams, &self.ground) else { return Ok(None) };
        let mut pass = |tiles| -> Result<Option<BeamPass>, RenderError> {
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Beam(tiles, counts))?;
            let group = self.terrain.beam_group(&self.gpu, &built, ground, beams, tiles);
            Ok(group.map(|group| BeamPass { built, group }))
        };
        let (coarse, fine) = (pass(Tiles::Coarse)?, pass(Tiles::Fine)?);
        Ok(coarse.zip(fine).map(|(coarse, fine)| [coarse, fine]))
    }

    pub(super) fn shows_terrain(&self, view: &View) -> bool {
        self.ground.is_some() && in_view(&view.box_clip)
    }
}

/// The terrain's draws: the parts of the picture, and the pipeline of each.
pub(super) fn terrains(scene: &Scene, size: [u32; 2], aim: Aim<'_>, deep: bool) -> Vec<(Side, TerrainKey)> {
    let probe = aim.probes();
    if let Aim::Given(_) = aim {
        let side = Side { name: "terrain", technique: scene.march.technique, area: Area::whole(size) };
        return vec![(side, TerrainKey::of(scene, false).with_given_distances())];
    }
    let key = |side: Side| (side, TerrainKey::of_technique(scene, side.technique, probe).in_a_deep_zoom(deep));
    let key = |side: Side| {
        let (side, key) = key(side);
        (side, if matches!(aim, Aim::Reads) { key.counting_reads() } else { key })
    };
    sides(scene, size).into_iter().map(key).collect()
}
