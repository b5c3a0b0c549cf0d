//! Air, clouds and flare of a frame: brought up to date, and drawn over the scene's picture.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::gpu::{Gpu, Target};
use crate::heightfield::HeightField;
use crate::scene::air::Kilometres;
use crate::scene::clouds::MOST_CLOUD_LAYERS;
use crate::scene::{CloudSource, Scene};

use super::air::{self, AirBindings, AirKey, AirUniform};
use super::cloud_pattern::MapPattern;
use super::clouds::{self, Clouds, ShadowPlace};
use super::flare::{self, FlareBindings, SunLook};
use super::occluder;
use super::pipelines::{Built, PipelineKey};
use super::prepare::View;
use super::sky_map::AirLight;
use super::skybox::Skybox;
use super::terrain::bind;
use super::{BACKGROUND, RenderError, Renderer};

/// What it keeps on the GPU.
#[derive(Debug)]
pub(super) struct Atmosphere {
    pub(super) air: AirBindings,
    pub(super) clouds: Option<Clouds>,
    flare: Option<FlareBindings>,
    /// How much of the sun was seen when it was last looked for.
    pub(super) sun_look: Option<SunLook>,
    /// Found for clouds that are to be cut from a map.
    pattern: Option<MapPattern>,
}

impl Atmosphere {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { air: AirBindings::new(gpu), clouds: None, flare: None, sun_look: None, pattern: None }
    }

    /// Keeps what was found elsewhere until clouds are made of it.
    pub(super) fn keep_pattern(&mut self, pattern: MapPattern) {
        self.pattern = Some(pattern);
    }

    /// The frame that draws the map of cloud shadows is on its way.
    pub(super) fn shadow_was_drawn(&mut self) {
        if let Some(clouds) = &mut self.clouds {
            clouds.shadow_was_drawn();
        }
    }

    /// What a key binds; `None` where a texture is missing.
    pub(super) fn entries(&self, key: AirKey) -> Option<Vec<(u32, wgpu::BindingResource<'_>)>> {
        let mut entries = Vec::new();
        if key.is_on() {
            entries.push(self.air.entry());
        }
        if key.shadows {
            entries.extend(self.clouds.as_ref()?.shadow_entries()?);
        }
        Some(entries)
    }
}

/// What of the atmosphere a frame draws.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AirPasses {
    /// The map of cloud shadows is to be drawn.
    pub(super) shadow: bool,
    pub(super) clouds: bool,
    pub(super) flare: bool,
}

impl AirPasses {
    /// Names of the passes over the picture.
    pub(super) fn over(self) -> impl Iterator<Item = &'static str> {
        [(self.clouds, "clouds"), (self.flare, "flare")].into_iter().filter_map(|(on, name)| on.then_some(name))
    }

    /// Whether anything is drawn over the picture.
    pub(super) fn any_over(self) -> bool {
        self.clouds || self.flare
    }
}

/// Whether `scene` shows clouds.
pub(super) fn shows_clouds(scene: &Scene) -> bool {
    air::shows_air(scene) && scene.clouds.shown().next().is_some()
}

/// Whether `scene` has a flare where its sun is in view.
fn may_flare(scene: &Scene) -> bool {
    scene.flare.enabled && scene.flare.strength > 0.0 && scene.skybox.enabled && air::shows_air(scene)
}

/// The pipelines that the atmosphere of a picture of `scene` may need.
pub(super) fn pipelines_of(scene: &Scene) -> Vec<PipelineKey> {
    let key = AirKey::of(scene);
    let mut keys = Vec::new();
    if shows_clouds(scene) {
        keys.push(PipelineKey::Clouds(key.unlit()));
    }
    if key.shadows {
        keys.push(PipelineKey::CloudShadow);
    }
    if may_flare(scene) {
        keys.push(PipelineKey::Flare);
    }
    keys
}

impl Renderer {
    /// The map whose pattern the clouds of a picture of `scene` would have to find first.
    pub(super) fn missing_pattern(&self, scene: &Scene) -> Option<Arc<HeightField>> {
        let source = scene.clouds.source;
        let map = self.ground.as_ref()?.terrain().base();
        let is_there = self.atmosphere.clouds.as_ref().is_some_and(|clouds| clouds.matches(source, map))
            || self.atmosphere.pattern.as_ref().is_some_and(|known| known.of(map).is_some());
        (source == CloudSource::Map && shows_clouds(scene) && !is_there).then(|| Arc::clone(map))
    }

    /// Brings the atmosphere up to date with a picture of `scene`; the skybox and the ground are.
    pub(super) fn prepare_air(&mut self, scene: &Scene, view: &View, size: [u32; 2], probe: bool) -> AirPasses {
        let Some(ground) = self.ground.as_ref().filter(|_| !probe) else { return AirPasses::default() };
        let (key, cloudy) = (AirKey::of(scene), shows_clouds(scene));
        let (map, eye) = (ground.terrain().base(), view.camera.eye);
        let km = Kilometres::of(map, view.extent.y);
        let sky = self.skybox.as_ref().map_or_else(background, Skybox::light);
        let mut uniform = AirUniform::new(scene, km, eye.y, &sky);
        let mut passes = AirPasses { clouds: cloudy, ..AirPasses::default() };
        if cloudy {
            if !self.atmosphere.clouds.as_ref().is_some_and(|clouds| clouds.matches(scene.clouds.source, map)) {
                let (clouds, uploaded) =
                    Clouds::new(&self.gpu, scene.clouds.source, map, self.atmosphere.pattern.take());
                self.uploaded += uploaded;
                self.atmosphere.clouds = Some(clouds);
            }
            let (low, high) = lit_space(scene, map, view.extent);
            let place = ShadowPlace::new(scene, low, high);
            let layers = clouds::uniforms(scene, km, eye.y, sky.exposed, place, &mut uniform);
            if let Some(clouds) = &mut self.atmosphere.clouds {
                passes.shadow = clouds.prepare(&self.gpu, &layers, key.shadows);
            }
        } else {
            (self.atmosphere.clouds, self.atmosphere.pattern) = (None, None);
        }
        if key.is_on() || cloudy {
            self.atmosphere.air.write(&self.gpu, &uniform);
        }
        passes.flare = self.prepare_flare(scene, view, size, (km, &uniform));
        passes
    }

    /// Writes the flare of a sun that is seen; whether it is.
    fn prepare_flare(
        &mut self,
        scene: &Scene,
        view: &View,
        size: [u32; 2],
        (km, air): (Kilometres, &AirUniform),
    ) -> bool {
        let eye = view.camera.eye;
        let sun = scene.lighting.sun_direction();
        let place = flare::sun_in_picture(&view.camera, size, sun).filter(|_| may_flare(scene));
        let place = place.filter(|_| !self.is_under_water(scene, view));
        let (Some(place), Some(ground)) = (place, &self.ground) else {
            (self.atmosphere.flare, self.atmosphere.sun_look) = (None, None);
            return false;
        };
        let look = SunLook::of(scene, ground.terrain(), view.extent, eye, self.atmosphere.sun_look.take());
        let mut share = look.share();
        self.atmosphere.sun_look = Some(look);
        share *= air::fog_before_sky(scene, km, eye.y, sun);
        if let Some(clouds) = self.atmosphere.clouds.as_ref().filter(|_| share > 0.0) {
            share *= clouds::before_sky(&clouds.pattern, scene, km, eye, sun);
        }
        if share < 1e-3 {
            self.atmosphere.flare = None;
            return false;
        }
        let [r, g, b, _] = air.sun_light;
        let light = Vec3::new(r, g, b) * (share * scene.flare.strength) as f32;
        let bindings = self.atmosphere.flare.get_or_insert_with(|| FlareBindings::new(&self.gpu));
        bindings.write(&self.gpu, &flare::uniform(place, size, light));
        true
    }

    /// Pipelines and bind groups of what is drawn over the picture, and of the map of shadows.
    pub(super) fn air_draws(
        &mut self,
        scene: &Scene,
        passes: AirPasses,
        target: &Target,
    ) -> Result<AirDraws, RenderError> {
        let mut draws = AirDraws::default();
        if passes.shadow {
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::CloudShadow)?;
            if let Some(clouds) = &self.atmosphere.clouds {
                let group = bind(&self.gpu, &built, clouds.layer_entries());
                draws.shadow = Some((built, group));
            }
        }
        if passes.clouds {
            let layers = scene.clouds.shown().count().min(MOST_CLOUD_LAYERS);
            let key = PipelineKey::Clouds(AirKey::of(scene).unlit());
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, key)?;
            if let Some(clouds) = &self.atmosphere.clouds {
                let mut entries = clouds.layer_entries();
                entries.extend([self.atmosphere.air.entry(), Clouds::depth_entry(&target.depth_view)]);
                let group = bind(&self.gpu, &built, entries);
                draws.over.push(Over {
                    built,
                    group,
                    vertices: clouds::VERTICES,
                    instances: layers as u32,
                    frame: true,
                });
            }
        }
        if passes.flare {
            let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Flare)?;
            if let Some(flare) = &self.atmosphere.flare {
                let group = bind(&self.gpu, &built, vec![flare.entry()]);
                let (vertices, instances) = flare::DRAWN;
                draws.over.push(Over { built, group, vertices, instances, frame: false });
            }
        }
        Ok(draws)
    }

    /// Draws the map of cloud shadows, where it is to be.
    pub(super) fn encode_cloud_shadow(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draws: &AirDraws,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let (Some((built, group)), Some(view)) =
            (&draws.shadow, self.atmosphere.clouds.as_ref().and_then(Clouds::shadow_view))
        else {
            return;
        };
        let load = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
        let mut pass = over_pass(encoder, "cloud shadows", (view, None), load, timestamps);
        pass.set_pipeline(&built.pipeline);
        pass.set_bind_group(0, self.frame.group(built), &[]);
        pass.set_bind_group(1, group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Draws what lies over the picture.
    pub(super) fn encode_over(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draws: &AirDraws,
        target: &Target,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        // Clouds are tested against the picture's depth, and read it, too: nobody writes.
        let depth =
            wgpu::RenderPassDepthStencilAttachment { view: &target.depth_view, depth_ops: None, stencil_ops: None };
        let (view, load) = (&target.color_view, wgpu::LoadOp::Load);
        let mut pass = over_pass(encoder, "over the picture", (view, Some(depth)), load, timestamps);
        for draw in &draws.over {
            pass.set_pipeline(&draw.built.pipeline);
            if draw.frame {
                pass.set_bind_group(0, self.frame.group(&draw.built), &[]);
            }
            pass.set_bind_group(u32::from(draw.frame), &draw.group, &[]);
            pass.draw(0..draw.vertices, 0..draw.instances);
        }
    }
}

fn over_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    (view, depth_stencil_attachment): (&wgpu::TextureView, Option<wgpu::RenderPassDepthStencilAttachment<'_>>),
    load: wgpu::LoadOp<wgpu::Color>,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment,
        timestamp_writes,
        ..Default::default()
    })
}

/// What a frame without a sky has in its place.
fn background() -> AirLight {
    let wgpu::Color { r, g, b, .. } = BACKGROUND;
    AirLight::flat(Vec3::new(r as f32, g as f32, b as f32))
}

/// Ends of the space in which clouds may shade something: the box, and the occluder.
fn lit_space(scene: &Scene, map: &HeightField, extent: DVec3) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::ZERO, extent);
    if scene.occluder.enabled {
        let cube = occluder::world_from_cube(&scene.occluder, map, extent);
        for index in 0..8 {
            let corner = cube.transform_point3(super::cube::corner(index));
            (low, high) = (low.min(corner), high.max(corner));
        }
    }
    (low, high)
}

/// Pipelines and bind groups of the passes.
#[derive(Debug, Default)]
pub(super) struct AirDraws {
    shadow: Option<(Arc<Built>, wgpu::BindGroup)>,
    over: Vec<Over>,
}

/// A draw over the picture.
#[derive(Debug)]
struct Over {
    built: Arc<Built>,
    group: wgpu::BindGroup,
    vertices: u32,
    instances: u32,
    /// Bind group 0 is the frame's.
    frame: bool,
}
