//! Which pipelines a scene needs, before it is drawn.

use crate::scene::light::Shadows;
use crate::scene::{CraterMode, DebugView, Scene};
use crate::scene_file;

use super::air::AirKey;
use super::beam::Tiles;
use super::compile::Compilation;
use super::ground::Ground;
use super::light::LightKey;
use super::light_map::LightMapKey;
use super::occluder::OccluderKey;
use super::pipelines::PipelineKey;
use super::prepare::{Aim, terrains};
use super::terrain::TerrainKey;
use super::{Renderer, atmosphere};

impl Renderer {
    /// What a frame of `scene` of `size` pixels, or a probe of it, would have to compile or read first; `None` where all is there,
    /// and where there is no such frame. That is said by who draws it.
    pub(crate) fn missing_pipelines(&self, scene: &Scene, size: [u32; 2], probe: bool) -> Option<Compilation> {
        scene_file::validate(scene).ok()?;
        let mut keys = self.pipelines_of(scene, size, probe)?;
        let terrains: Vec<_> =
            keys.iter().filter_map(|key| if let PipelineKey::Terrain(key) = key { Some(*key) } else { None }).collect();
        let images = if probe { Vec::new() } else { self.missing_images(scene, &terrains) };
        let pattern = self.missing_pattern(scene).filter(|_| !probe);
        keys.retain(|&key| !self.pipelines.has(key));
        let missing = !(keys.is_empty() && images.is_empty() && pattern.is_none());
        missing.then(|| Compilation::new(&self.gpu, self.pipelines.sources(), &self.frame, keys, images, pattern))
    }

    /// The pipelines of a frame, also of what is out of view: it may come into view any moment.
    fn pipelines_of(&self, scene: &Scene, size: [u32; 2], probe: bool) -> Option<Vec<PipelineKey>> {
        let mut keys = Vec::new();
        if let Some(ground) = &self.ground {
            let deep = self.view(scene, size).deep;
            let aim = if probe { Aim::Probe } else { Aim::Picture };
            let mut terrain: Vec<_> = terrains(scene, size, aim, deep).into_iter().map(|(_, key)| key).collect();
            if scene.debug.view == DebugView::Error && !probe {
                terrain.push(TerrainKey::of_exact_distances(scene).in_a_deep_zoom(deep));
            }
            for key in &mut terrain {
                *key = key.over_holes(ground.has_holes());
            }
            if terrain.iter().any(|key| !self.reads(ground, key)) {
                return None;
            }
            if !probe {
                keys.extend(self.water_key(scene, deep, false).map(PipelineKey::Water));
            }
            if terrain.iter().any(TerrainKey::starts_from_beams) {
                keys.extend(Tiles::ALL.map(|tiles| PipelineKey::Beam(tiles, false)));
            }
            let light = if probe { LightKey::default() } else { LightKey::of_picture(scene) };
            let maps = LightMapKey::all_of(light, ground.has_holes(), is_layered(scene));
            keys.extend(maps.map(PipelineKey::LightMap));
            keys.extend(terrain.into_iter().map(PipelineKey::Terrain));
            if scene.debug.wireframe && !probe {
                keys.push(PipelineKey::Wireframe);
            }
            if scene.occluder.enabled {
                keys.push(PipelineKey::Occluder(occluder_key(scene, ground, probe)));
            }
        }
        if scene.skybox.enabled && scene.debug.view != DebugView::Error && !probe {
            keys.push(PipelineKey::Skybox(AirKey::of(scene).fog));
        }
        if !probe && self.ground.is_some() {
            keys.extend(atmosphere::pipelines_of(scene));
        }
        Some(keys)
    }

    /// Whether the adapter can read the heights of `ground` the way that the pipeline does.
    pub(super) fn reads(&self, ground: &Ground, key: &TerrainKey) -> bool {
        let units = ground.units();
        !key.filters_heights() || self.gpu.capabilities.filters_heights(units, key.layered)
    }
}

/// What the occluder's picture needs of the light: hills hide the sun from it.
pub(super) fn occluder_key(scene: &Scene, ground: &Ground, probe: bool) -> OccluderKey {
    let light = if probe { LightKey::default() } else { LightKey::of(scene) };
    let casts = light.shadows != Shadows::Off;
    let layered = casts && is_layered(scene);
    let air = if probe { AirKey::default() } else { AirKey::of(scene) };
    OccluderKey { probe, shadows: light.shadows, holes: casts && ground.has_holes(), layered, air }
}

fn is_layered(scene: &Scene) -> bool {
    scene.craters.mode == CraterMode::Layered && !scene.craters.list.is_empty()
}
