//! Layers of clouds: their pattern, their constants, and the map of their shadows. Their shaders are `cloud_layers.wgsl`,
//! `clouds.wgsl` and `cloud_shadow.wgsl`.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::swizzles::{Vec2Swizzles, Vec3Swizzles};
use glam::{DVec2, DVec3};

use crate::gpu::{COLOR_FORMAT, DEPTH_COMPARE, Gpu, sized_texture};
use crate::heightfield::HeightField;
use crate::scene::air::Kilometres;
use crate::scene::clouds::MOST_CLOUD_LAYERS;
use crate::scene::{CloudSettings, CloudSource, Scene};

use super::air::{self, AirKey, AirUniform};
use super::cloud_pattern::{self, MapPattern, Pattern};
use super::frame::{sampler_entry, storage_buffer, storage_entry, texture_entry, without_subnormals};
use super::ground::Texture;
use super::ledger::TextureEntry;
use super::pipelines::PassDescription;
use super::prepare::View;

/// Bindings.
const SHADOW: u32 = 45;
const SHADOW_SAMPLER: u32 = 46;
const LAYERS: u32 = 47;
const PATTERN: u32 = 48;
const PATTERN_SAMPLER: u32 = 49;
const DEPTHS: u32 = 50;

/// Texels along a side of the map of shadows.
const SHADOW_SIDE: u32 = 512;

/// What clouds let through.
const SHADOW_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// How much of a pattern's range the edge of a cloud takes.
const SOFTNESS: f64 = 0.22;

/// Half of what a layer counts as thick where it meets hills and the eye, in kilometres.
const HALF_DEPTH: f64 = 0.12;

/// The second pattern of a layer: so many times as large as the first, turned by so much (radians).
const SECOND: (f64, f64) = (1.618_033_988_75, 1.1);

/// Elevations of the sun, degrees, below which clouds cast no shadow, and from which on the whole.
const SHADOW_SUN: [f64; 2] = [2.0, 7.0];

/// Constants of the shaders, so that no number is typed in two languages.
pub(super) fn wgsl() -> String {
    format!(
        "#define_import_path relief::cloud_constants\nconst CLOUD_LAYERS: u32 = {MOST_CLOUD_LAYERS}u;\n\
         const SIDE: f32 = {}.0;\nconst SOFTNESS: f32 = {SOFTNESS:?};\nconst SHADOW_SIDE: f32 = {SHADOW_SIDE}.0;\n\
         const FADED: f32 = {FADED:?};\nconst WHOLE: f32 = {WHOLE:?};\n",
        cloud_pattern::SIDE
    )
}

/// Whether the sun is high enough for clouds to cast shadows.
pub(super) fn sun_reaches(scene: &Scene) -> bool {
    scene.lighting.sun_direction().y > SHADOW_SUN[0].to_radians().sin()
}

/// Entries of the layout of what reads the map of shadows.
pub(super) fn shadow_entries() -> [wgpu::BindGroupLayoutEntry; 2] {
    [texture_entry(SHADOW, true, false), sampler_entry(SHADOW_SAMPLER)]
}

/// The pass that draws the clouds over the picture; of the air only what veils counts.
pub(super) fn describe(air: AirKey) -> PassDescription {
    let depths = wgpu::BindGroupLayoutEntry {
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        ..texture_entry(DEPTHS, false, false)
    };
    let defs: Vec<_> = air.defs().collect();
    PassDescription {
        name: if defs.is_empty() { "clouds".into() } else { format!("clouds [{}]", defs.join(" ")) },
        modules: vec!["frame.wgsl", "air.wgsl", "cloud_layers.wgsl"],
        defs,
        bindings: [storage_entry::<AirUniform>(air::AIR), depths].into_iter().chain(layer_entries()).collect(),
        depth: Some((DEPTH_COMPARE, false)),
        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        format: COLOR_FORMAT,
        ..PassDescription::scene("clouds", "clouds.wgsl", false)
    }
}

/// The pass that draws the map of shadows.
pub(super) fn describe_shadow() -> PassDescription {
    PassDescription {
        modules: vec!["cloud_layers.wgsl"],
        bindings: layer_entries().into(),
        depth: None,
        format: SHADOW_FORMAT,
        ..PassDescription::scene("cloud shadows", "cloud_shadow.wgsl", false)
    }
}

pub(super) fn layer_entries() -> [wgpu::BindGroupLayoutEntry; 3] {
    [storage_entry::<CloudsUniform>(LAYERS), texture_entry(PATTERN, true, false), sampler_entry(PATTERN_SAMPLER)]
}

/// Mirror of `CloudLayer` in `cloud_layers.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct LayerUniform {
    pub(super) shape: [f32; 4],
    pub(super) first: [f32; 4],
    pub(super) second: [f32; 4],
    pub(super) offsets: [f32; 4],
}

/// Mirror of `Clouds` in `cloud_layers.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct CloudsUniform {
    pub(super) layers: [LayerUniform; MOST_CLOUD_LAYERS],
    pub(super) count: [f32; 4],
    pub(super) shadow: [f32; 4],
    pub(super) order: [[f32; 4]; 2],
    pub(super) sun: [f32; 4],
}

/// A layer in the world.
#[derive(Clone, Copy, Debug)]
struct Layer {
    /// World height.
    height: f64,
    thickness: f64,
    /// Share that it leaves free.
    free: f64,
    /// Rows of the matrices from places to tiles, and offsets.
    first: [DVec2; 2],
    second: [DVec2; 2],
    offsets: [DVec2; 2],
}

impl Layer {
    fn new(clouds: &CloudSettings, index: usize, km: Kilometres) -> Option<Self> {
        let layer = clouds.layers.get(index)?;
        let matrix = |larger: f64, turn: f64| {
            // Layers are turned by the golden angle against each other, so that none lies over its like.
            let (sin, cos) = (turn + 2.4 * index as f64).sin_cos();
            let per_unit = km.along / (layer.scale * larger);
            [DVec2::new(cos, sin) * per_unit, DVec2::new(-sin, cos) * per_unit]
        };
        let (first, second) = (matrix(1.0, 0.0), matrix(SECOND.0, SECOND.1));
        let (sin, cos) = layer.direction.to_radians().sin_cos();
        // Against the direction: the pattern is looked up where it came from.
        let back = DVec2::new(-sin, cos) * (layer.speed * clouds.time / 1000.0 / km.along);
        let offset = |rows: [DVec2; 2], own: DVec2| {
            let moved = DVec2::new(rows[0].dot(back), rows[1].dot(back)) + own;
            moved - moved.floor()
        };
        let own = DVec2::new(0.37, 0.71) * (index as f64 + 1.0);
        Some(Self {
            height: km.height_of(layer.height),
            thickness: layer.thickness,
            free: 1.0 - clouds.cover_of(layer),
            first,
            second,
            offsets: [offset(first, own), offset(second, own.yx())],
        })
    }

    fn uniform(&self, km: Kilometres) -> LayerUniform {
        let rows = |[a, b]: [DVec2; 2]| [a.x as f32, a.y as f32, b.x as f32, b.y as f32];
        LayerUniform {
            shape: [self.height as f32, (HALF_DEPTH / km.up) as f32, self.thickness as f32, self.free as f32],
            first: rows(self.first),
            second: rows(self.second),
            offsets: rows(self.offsets),
        }
    }

    /// Optical depth at a place of its plane, as `cloud_at` in `cloud_layers.wgsl` has it where nothing is blurred.
    fn depth_at(&self, pattern: &Pattern, place: DVec2) -> f64 {
        let look = |rows: [DVec2; 2], offset: DVec2| {
            pattern.density(DVec2::new(rows[0].dot(place), rows[1].dot(place)) + offset)
        };
        let mean = 0.5 * (look(self.first, self.offsets[0]) + look(self.second, self.offsets[1]));
        let density = if mean < 0.5 { 2.0 * mean * mean } else { 1.0 - 2.0 * (1.0 - mean) * (1.0 - mean) };
        let above = (density - self.free + 0.5 * SOFTNESS).max(0.0);
        let fullness = (above / (1.0 - self.free + 0.5 * SOFTNESS)).min(1.0);
        self.thickness * fullness * (above / SOFTNESS).min(1.0)
    }
}

/// The layers of a scene in the world, the lowest first.
fn layers_of(clouds: &CloudSettings, km: Kilometres) -> Vec<Layer> {
    let is_shown = |index: &usize| {
        clouds.layers.get(*index).is_some_and(|layer| layer.thickness > 0.0 && clouds.cover_of(layer) > 0.0)
    };
    let indices = (0..clouds.layers.len().min(MOST_CLOUD_LAYERS)).filter(is_shown);
    let mut layers: Vec<_> = indices.filter_map(|index| Layer::new(clouds, index, km)).collect();
    layers.sort_by(|a, b| a.height.total_cmp(&b.height));
    layers
}

/// Where the map of shadows lies: the floor as seen along the sun's rays from all of the box, or from a larger one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShadowPlace {
    corner: DVec2,
    size: DVec2,
    /// Way along the ground towards the sun for a unit of height.
    shear: DVec2,
    strength: f64,
}

impl ShadowPlace {
    /// For places between `low` and `high`, world space.
    pub(super) fn new(scene: &Scene, low: DVec3, high: DVec3) -> Self {
        let sun = scene.lighting.sun_direction();
        let [none, all] = SHADOW_SUN.map(|degrees| degrees.to_radians().sin());
        let shear = DVec2::new(sun.x, sun.z) / sun.y.max(none);
        let share = ((sun.y - none) / (all - none)).clamp(0.0, 1.0);
        let at_floor = |y: f64| [low.xz() - y * shear, high.xz() - y * shear];
        let ends = [at_floor(low.y), at_floor(high.y)].concat();
        let corner = ends.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let far = ends.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let strength = scene.clouds.shadow_strength * share * share * (3.0 - 2.0 * share);
        Self { corner, size: (far - corner).max(DVec2::splat(1e-6)), shear, strength }
    }
}

/// The constants of `scene`'s clouds for an eye at a world height; also those of the air that tell where shadows are.
pub(super) fn uniforms(
    scene: &Scene,
    km: Kilometres,
    eye: f64,
    exposed: bool,
    place: ShadowPlace,
    air: &mut AirUniform,
) -> CloudsUniform {
    let layers = layers_of(&scene.clouds, km);
    let mut uniform = CloudsUniform::zeroed();
    for (uniform, layer) in uniform.layers.iter_mut().zip(&layers) {
        *uniform = layer.uniform(km);
    }
    // Above the eye the highest is the farthest, below it the lowest; no ray meets both.
    let mut order: Vec<usize> = (0..layers.len()).collect();
    order.sort_by(|&a, &b| (layers[b].height - eye).abs().total_cmp(&(layers[a].height - eye).abs()));
    for (entry, index) in uniform.order.as_flattened_mut().iter_mut().zip(order) {
        *entry = index as f32;
    }
    let pair = |a: DVec2, b: DVec2| [a.x as f32, a.y as f32, b.x as f32, b.y as f32];
    uniform.count = [layers.len() as f32, eye as f32, place.corner.x as f32, place.corner.y as f32];
    uniform.shadow = pair(place.size, place.shear);
    let height = scene.lighting.sun_direction().y.max(0.3);
    uniform.sun = [height as f32, place.strength as f32, f32::from(u8::from(exposed)), 0.0];
    air.shadow_place = pair(place.corner, DVec2::ONE / place.size);
    air.shadow_shear = pair(place.shear, DVec2::new(HALF_DEPTH / km.up, place.strength));
    // Of five layers the fourth casts its shadow up to the fifth.
    let level = |index: usize| layers.get(index).map_or(1e30, |layer| layer.height as f32);
    air.shadow_levels = [level(0), level(1), level(2), if layers.len() > 4 { level(4) } else { level(3) }];
    *air = without_subnormals(*air);
    without_subnormals(uniform)
}

/// Of a layer: two triangles over the rows of the picture in which it can be.
pub(super) const VERTICES: u32 = 6;

/// Sines of the elevation, up or down: up to the first layers have faded away, from the second on they are seen whole.
const FADED: f64 = 0.012;
const WHOLE: f64 = 0.11;

/// Whether a layer that moves is in view.
pub(super) fn any_moving_in_view(scene: &Scene, km: Kilometres, view: &View) -> bool {
    let [width, height] = view.size.map(f64::from);
    // The camera does not roll: along a row the sine of the elevation is largest in the middle, and least at the ends.
    let points = [0.0, 0.5, 1.0].map(|x| [0.0, 1.0].map(|y| DVec2::new(x * width, y * height)));
    let sines = points.as_flattened().iter().map(|at| view.camera.ray(at.x, at.y, view.size).direction.normalize().y);
    let (lowest, highest) = sines.fold((1.0f64, -1.0f64), |(low, high), sine| (low.min(sine), high.max(sine)));
    scene.clouds.shown().filter(|layer| layer.speed != 0.0).any(|layer| {
        let above = km.height_of(layer.height) > view.camera.eye.y;
        if above { highest > FADED } else { lowest < -FADED }
    })
}

/// Share of the light along a ray (a unit vector) that gets through the clouds before the sky.
pub(super) fn before_sky(pattern: &Pattern, scene: &Scene, km: Kilometres, eye: DVec3, direction: DVec3) -> f64 {
    let depth: f64 = layers_of(&scene.clouds, km)
        .iter()
        .map(|layer| {
            let along = (layer.height - eye.y) / direction.y;
            let is_before = along > 0.0 && along.is_finite();
            let place = (eye + direction * along).xz();
            if is_before { layer.depth_at(pattern, place) / direction.y.abs().max(1.0 / 3.0) } else { 0.0 }
        })
        .sum();
    (-depth).exp()
}

/// Pattern, constants and map of shadows on the GPU.
#[derive(Debug)]
pub(super) struct Clouds {
    /// The map that the pattern is made from; absent for noise.
    map: Option<Arc<HeightField>>,
    pub(super) pattern: Arc<Pattern>,
    texture: Texture,
    sampler: wgpu::Sampler,
    shadow_sampler: wgpu::Sampler,
    buffer: wgpu::Buffer,
    shadow: Option<Texture>,
    /// What the map of shadows was drawn of, and what the frame under way draws it of.
    shadow_of: Option<CloudsUniform>,
    shadow_wanted: Option<CloudsUniform>,
}

impl Clouds {
    /// For clouds over `map`, whose pattern may be `known`; also the bytes uploaded.
    pub(super) fn new(
        gpu: &Gpu,
        source: CloudSource,
        map: &Arc<HeightField>,
        known: Option<MapPattern>,
    ) -> (Self, u64) {
        let (map, pattern) = match source {
            CloudSource::Noise => (None, cloud_pattern::of_noise()),
            CloudSource::Map => {
                let known = known.and_then(|known| known.of(map));
                let found = || MapPattern::new(map).of(map);
                (Some(Arc::clone(map)), known.or_else(found).unwrap_or_else(cloud_pattern::of_noise))
            }
        };
        let (texture, uploaded) = pattern.upload(gpu);
        let sampler = |label, address| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: address,
                address_mode_v: address,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                // In software the other level of detail costs as much again, and two patterns blur the step between them.
                mipmap_filter: if gpu.capabilities.software {
                    wgpu::MipmapFilterMode::Nearest
                } else {
                    wgpu::MipmapFilterMode::Linear
                },
                ..Default::default()
            })
        };
        let clouds = Self {
            map,
            pattern,
            texture,
            sampler: sampler("clouds", wgpu::AddressMode::Repeat),
            shadow_sampler: sampler("cloud shadows", wgpu::AddressMode::ClampToEdge),
            buffer: storage_buffer(gpu, "clouds", size_of::<CloudsUniform>()),
            shadow: None,
            shadow_of: None,
            shadow_wanted: None,
        };
        (clouds, uploaded)
    }

    /// Whether this is still what `source` over `map` asks for.
    pub(super) fn matches(&self, source: CloudSource, map: &Arc<HeightField>) -> bool {
        match (&self.map, source) {
            (None, CloudSource::Noise) => true,
            (Some(own), CloudSource::Map) => Arc::ptr_eq(own, map),
            _ => false,
        }
    }

    /// Writes the constants, and keeps room for a map of shadows while one is wanted. Whether that has to be drawn.
    pub(super) fn prepare(&mut self, gpu: &Gpu, uniform: &CloudsUniform, casts: bool) -> bool {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
        if !casts {
            (self.shadow, self.shadow_of, self.shadow_wanted) = (None, None, None);
            return false;
        }
        if self.shadow.is_none() {
            let texture = sized_texture(gpu, "cloud shadows", [SHADOW_SIDE; 2], SHADOW_FORMAT, &[]);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            self.shadow = Some(Texture { texture, view });
        }
        // The eye's height is no part of it.
        let mut wanted = *uniform;
        (wanted.count[1], wanted.order) = (0.0, [[0.0; 4]; 2]);
        self.shadow_wanted = Some(wanted);
        self.shadow_of != self.shadow_wanted
    }

    /// The frame that draws the map of shadows is on its way. One that fails before leaves it to be drawn by the next.
    pub(super) fn shadow_was_drawn(&mut self) {
        self.shadow_of = self.shadow_wanted;
    }

    /// What the passes of clouds and shadows bind of the layers.
    pub(super) fn layer_entries(&self) -> Vec<(u32, wgpu::BindingResource<'_>)> {
        vec![
            (LAYERS, self.buffer.as_entire_binding()),
            (PATTERN, wgpu::BindingResource::TextureView(&self.texture.view)),
            (PATTERN_SAMPLER, wgpu::BindingResource::Sampler(&self.sampler)),
        ]
    }

    /// What the picture's depth is bound as.
    pub(super) fn depth_entry(depth: &wgpu::TextureView) -> (u32, wgpu::BindingResource<'_>) {
        (DEPTHS, wgpu::BindingResource::TextureView(depth))
    }

    /// What is lit binds of the shadows; `None` without a map of them.
    pub(super) fn shadow_entries(&self) -> Option<[(u32, wgpu::BindingResource<'_>); 2]> {
        let view = &self.shadow.as_ref()?.view;
        Some([
            (SHADOW, wgpu::BindingResource::TextureView(view)),
            (SHADOW_SAMPLER, wgpu::BindingResource::Sampler(&self.shadow_sampler)),
        ])
    }

    /// The map of shadows, to be drawn into.
    pub(super) fn shadow_view(&self) -> Option<&wgpu::TextureView> {
        self.shadow.as_ref().map(|shadow| &shadow.view)
    }

    /// For the ledger.
    pub(super) fn list(&self) -> impl Iterator<Item = TextureEntry> {
        let shadow = self.shadow.as_ref().map(|shadow| TextureEntry::of("cloud shadows", &shadow.texture));
        std::iter::once(TextureEntry::of("clouds", &self.texture.texture)).chain(shadow)
    }
}

/// Optical depth over a place of the floor along the sun's rays, of all layers, and what shadows make of it. For tests, in f64.
#[cfg(test)]
pub(super) fn shadow_twin(pattern: &Pattern, scene: &Scene, km: Kilometres, place: DVec3, bounds: ShadowPlace) -> f64 {
    let sun = scene.lighting.sun_direction();
    layers_of(&scene.clouds, km)
        .iter()
        .filter(|layer| layer.height > place.y)
        .map(|layer| {
            let at = (place + sun * ((layer.height - place.y) / sun.y)).xz();
            1.0 + bounds.strength * ((-layer.depth_at(pattern, at) / sun.y.max(0.3)).exp() - 1.0)
        })
        .product()
}
