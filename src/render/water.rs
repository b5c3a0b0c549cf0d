//! The sea: its pass, which is drawn over the terrain. Its shaders are `water.wgsl` and `waves.wgsl`.
//!
//! It is a pass of its own and no part of the terrain's: every technique draws the ground that it finds, and the sea covers
//! what of it lies behind the water, so that no variant of the terrain's shader knows of it.

use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec3};

use crate::gpu::{Gpu, PROBE_FORMAT, Target, read_texture, sized_texture};
use crate::scene::water::WATER_PERIOD;
use crate::scene::{DebugView, Scene, Technique, Water};

use super::air::{self, AirUniform};
use super::cube::in_view;
use super::frame::{FrameUniform, sampler_entry, storage_entry, texture_entry, uniform_buffer, without_subnormals};
use super::ground::Ground;
use super::light::direct_weights;
use super::pipelines::{PassDescription, PipelineKey};
use super::prepare::{Draw, View};
use super::sky_model::Daylight;
use super::skybox::Skybox;
use super::split::Area;
use super::terrain::{TerrainUniform, Textures, bind};
use super::terrain_key::{Output, TerrainKey};
use super::{BACKGROUND, RenderError, Renderer, atmosphere, clouds, occluder, terrain};

/// Bindings in the terrain's group.
const WATER: u32 = 40;
const SKY: u32 = 41;
const SKY_SAMPLER: u32 = 42;
/// The binding of beams' starts, which the sea's walks do without.
const BEAMS: u32 = 8;

/// Waves added up.
const WAVES: usize = 12;
/// Each is so much shorter than the one before.
const SHORTER: f64 = 0.74;
/// Radians that their directions spread to either side of the wind's.
const SPREAD: f64 = 1.1;
/// Direction that the wind blows to, radians from east to south.
const WIND: f64 = 0.5;
/// Root mean square of the slope of the steepest waves: about that of a wind of 12 m/s (Cox and Munk 1954).
const STEEPEST: f64 = 0.25;
/// Lengths of itself that the longest wave moves in a second; shorter ones are slower by the root of their length, as in deep
/// water. Each has a whole number of periods in that of the clock.
const SPEED: f64 = 0.3;
/// Length of foam's flakes over that of the longest waves.
const FLAKES: f64 = 0.35;
/// Foam drifts around circles: flakes per second, and seconds for a circle, which are a whole part of the clock's period.
const DRIFT: f64 = 0.15;
const CIRCLE: f64 = 120.0;
/// Depth up to which there is foam at most, as a share of the map's height.
const FOAM_DEPTH: f64 = 1.0 / 30.0;
/// Radius of the largest bubbles over the length of the longest waves, and cells of their grid, eight radii high, that the slowest
/// would rise in a second times 1 / 0.6: `waves.wgsl` has columns rise by tenths of it, and repeats after 540 cells, so that
/// all are where they were after the clock's period.
const BUBBLES: f64 = 0.012;
const RISE: f64 = 1.5;

/// Absorption by channel over that of green light in a blue sea, and in a green lake.
const ABSORPTION: [Vec3; 2] = [Vec3::new(4.2, 1.0, 0.6), Vec3::new(3.0, 1.0, 1.6)];
/// Light that comes back from endless water under white light of 1, in both.
const DEEP: [Vec3; 2] = [Vec3::new(0.006, 0.055, 0.105), Vec3::new(0.018, 0.075, 0.055)];

/// What the sea's pipeline is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct WaterKey {
    /// How the ground that it shows is found and shaded.
    pub(super) ground: TerrainKey,
    pub(super) reflection: bool,
    pub(super) refraction: bool,
    pub(super) waves: bool,
    pub(super) foam: bool,
    pub(super) bubbles: bool,
    /// There is a sky to mirror.
    pub(super) sky: bool,
    /// The occluder is seen in it.
    pub(super) occluder: bool,
    /// Clouds are seen in it, or from below it.
    pub(super) clouds: bool,
}

impl WaterKey {
    /// What the sea of `scene` needs, on a map with holes or without: in a picture, or to find where its light goes (`probe`).
    /// `None` where no sea is to be seen.
    pub(super) fn of(scene: &Scene, holes: bool, probe: bool) -> Option<Self> {
        let Water { enabled, reflection, refraction, waves, foam, bubbles, .. } = scene.water;
        if !enabled || scene.debug.view != DebugView::None {
            return None;
        }
        // Whatever technique draws the terrain, light in the water meets the exact ground.
        let technique = match scene.march.technique {
            Technique::Smooth => Technique::Smooth,
            _ => Technique::MaxMipmap,
        };
        let ground =
            TerrainKey { lower_start: true, discard_misses: true, ..TerrainKey::of_technique(scene, technique, probe) };
        Some(Self {
            ground: ground.over_holes(holes),
            reflection,
            refraction,
            waves: waves > 0.0,
            foam: foam > 0.0 && !probe,
            bubbles: bubbles && !probe,
            sky: scene.skybox.enabled && !probe,
            occluder: scene.occluder.enabled,
            clouds: atmosphere::shows_clouds(scene) && !probe,
        })
    }

    fn defs(self) -> Vec<&'static str> {
        let own = [
            (self.reflection, "WATER_REFLECTION"),
            (self.refraction, "WATER_REFRACTION"),
            (self.waves, "WATER_WAVES"),
            (self.foam, "WATER_FOAM"),
            (self.bubbles, "WATER_BUBBLES"),
            (self.sky, "WATER_SKY"),
            (self.occluder, "WATER_OCCLUDER"),
            (self.clouds, "WATER_CLOUDS"),
        ];
        self.ground.defs().into_iter().chain(own.into_iter().filter_map(|(on, def)| on.then_some(def))).collect()
    }

    /// Each switch with a few ways to find and to light the ground.
    #[cfg(test)]
    pub(super) fn some() -> Vec<Self> {
        use crate::scene::{ColourSource, CraterMode};

        let changes: &[&dyn Fn(&mut Scene)] = &[
            &|_| {},
            &|scene| scene.water.reflection = false,
            &|scene| scene.water.refraction = false,
            &|scene| (scene.water.waves, scene.water.foam, scene.water.bubbles) = (0.0, 0.0, false),
            &|scene| (scene.skybox.enabled, scene.lighting.enabled) = (false, false),
            &|scene| scene.march.technique = Technique::Smooth,
            &|scene| (scene.clouds.enabled, scene.air.fog) = (true, false),
            &|scene| (scene.clouds.enabled, scene.air.fog, scene.air.perspective) = (true, true, true),
            &|scene| {
                (scene.lighting.shadows, scene.occluder.enabled) = (crate::scene::light::Shadows::Soft, true);
                (scene.lighting.occlusion, scene.diffuse.source) = (true, ColourSource::Materials);
            },
            &|scene| {
                scene.craters.mode = CraterMode::Layered;
                scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
                (scene.land.colour, scene.land.contours) = (crate::scene::GroundColour::Ramp, true);
            },
        ];
        let all = changes.iter().flat_map(|change| {
            let mut scene = Scene::default();
            scene.water.enabled = true;
            change(&mut scene);
            [(false, false), (true, false), (false, true)].map(|(holes, probe)| Self::of(&scene, holes, probe))
        });
        all.flatten().collect()
    }
}

pub(super) fn describe(key: WaterKey) -> PassDescription {
    let ground = terrain::describe(key.ground);
    let mut bindings = ground.bindings;
    bindings.retain(|entry| entry.binding != BEAMS);
    bindings.push(wgpu::BindGroupLayoutEntry {
        binding: WATER,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: std::num::NonZeroU64::new(size_of::<WaterBuffer>() as u64),
        },
        count: None,
    });
    if key.sky {
        bindings.extend([texture_entry(SKY, true, true), sampler_entry(SKY_SAMPLER)]);
    }
    let mut modules = ground.modules;
    if key.clouds {
        if !key.ground.air.is_on() {
            // The lights of clouds are among its constants.
            bindings.push(storage_entry::<AirUniform>(air::AIR));
        }
        bindings.extend(clouds::layer_entries());
        // A module that comes twice takes those away that need it.
        let missing = ["air.wgsl", "cloud_layers.wgsl"].into_iter().filter(|name| !modules.contains(name));
        let missing: Vec<_> = missing.collect();
        modules.extend(missing);
    }
    modules.extend(["cube_faces.wgsl", "waves.wgsl"]);
    let defs = key.defs();
    let probe = key.ground.output == Output::Probe;
    PassDescription {
        name: format!("water [{}]", defs.join(" ")),
        modules,
        defs,
        bindings,
        casts_rays: true,
        // The far side of the block: it is there from inside, too.
        cull: Some(wgpu::Face::Front),
        ..PassDescription::scene("water", "water.wgsl", probe)
    }
}

/// Mirror of `Water` in `waves.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct WaterBuffer {
    pub(super) cube: [[f32; 4]; 3],
    pub(super) cube_sun: [f32; 4],
    pub(super) absorption_and_level: [f32; 4],
    pub(super) deep_and_submerged: [f32; 4],
    pub(super) sun_and_flattening: [f32; 4],
    pub(super) background_and_foam: [f32; 4],
    pub(super) foam_light_and_bubbles: [f32; 4],
    pub(super) drift: [f32; 4],
    pub(super) foam_shift: [f32; 4],
    pub(super) waves: [[f32; 4]; WAVES],
}

/// The box of the water under a sea of this level (world units), where there is any.
fn block(scene: &Scene, ground: &Ground, extent: DVec3) -> Result<Option<DVec3>, RenderError> {
    let share = scene.water.level_share(ground.terrain().base().metric_range()).ok_or(RenderError::Impossible {
        what: "the level of the sea in metres",
        why: "the metres of this map are not known",
        instead: "give it as a share of its height (water.levels = \"share\"), or the map its metres in a sidecar",
    })?;
    let level = share * extent.y;
    Ok((level > 0.0).then_some(DVec3 { y: level, ..extent }))
}

/// Where an eye is, seen from the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EyePlace {
    Within,
    /// Above the surface, or on it.
    Above,
    /// As low as the water, beside it.
    Beside,
}

impl EyePlace {
    fn of(eye: DVec3, block: DVec3) -> Self {
        let inside = eye.cmpge(DVec3::ZERO).all() && eye.cmple(block).all();
        match eye.y < block.y {
            true if inside => Self::Within,
            true => Self::Beside,
            false => Self::Above,
        }
    }
}

impl WaterBuffer {
    fn new(scene: &Scene, view: &View, block: DVec3, world_from_cube: DMat4) -> Self {
        let Scene { water, lighting, .. } = scene;
        let eye = view.camera.eye;
        let place_of_eye = match EyePlace::of(eye, block) {
            EyePlace::Within => 1.0,
            EyePlace::Above => -1.0,
            EyePlace::Beside => 0.0,
        };
        let sun = lighting.sun_direction();
        let [diffuse, _] = direct_weights(lighting);
        // Light on a level surface, and the sun's own.
        let (mut sunlight, mut skylight) = (Vec3::splat(diffuse), Vec3::splat(lighting.ambient));
        if !lighting.enabled {
            (sunlight, skylight) = (Vec3::ZERO, Vec3::ONE);
        } else if let Some(turbidity) = scene.skybox.physical() {
            let light = Daylight::new(sun, turbidity).light();
            sunlight *= light.sun.as_vec3();
            // `sky_light` of light.wgsl for a normal that points up.
            skylight *= (light.harmonics[0] + light.harmonics[1] - light.harmonics[6] - light.harmonics[8]).as_vec3();
        }
        let level_light = skylight + sunlight * sun.y.max(0.0) as f32;
        let mix = |[sea, lake]: [Vec3; 2]| sea.lerp(lake, water.tint);
        let with = |xyz: Vec3, w: f64| xyz.extend(w as f32).to_array();
        let cube = if scene.occluder.enabled { world_from_cube.inverse() } else { DMat4::IDENTITY };
        let rows = cube.transpose();
        let cube_light = occluder::uniform(&[glam::DVec4::ZERO; 8], world_from_cube, lighting);
        let length = f64::from(water.wave_length);
        let background = [BACKGROUND.r, BACKGROUND.g, BACKGROUND.b].map(|light| light as f32);
        without_subnormals(Self {
            cube: [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.as_vec4().to_array()),
            cube_sun: with(cube_light.sun, f64::from(cube_light.ambient)),
            absorption_and_level: with(mix(ABSORPTION) / water.clarity, block.y),
            deep_and_submerged: with(mix(DEEP) * level_light, place_of_eye),
            sun_and_flattening: with(sunlight, f64::from(scene.skybox.flattening)),
            background_and_foam: with(background.into(), f64::from(water.foam) * FOAM_DEPTH * view.extent.y),
            foam_light_and_bubbles: with(level_light * 0.8, BUBBLES * length),
            drift: [0.0, (water.time * RISE) as f32, (FLAKES * length) as f32, (TAU / length) as f32],
            foam_shift: foam_shift(water.time),
            waves: waves(water),
        })
    }
}

/// Where foam's pattern has drifted to, in flakes.
fn foam_shift(time: f64) -> [f32; 4] {
    let (sin, cos) = (TAU * time / CIRCLE).sin_cos();
    let radius = DRIFT * CIRCLE / TAU;
    [(radius * cos) as f32, (radius * sin) as f32, 0.0, 0.0]
}

/// The waves: each equally steep, directions about the wind's by the golden ratio, so that none repeats another.
fn waves(water: &Water) -> [[f32; 4]; WAVES] {
    let slope = STEEPEST * f64::from(water.waves) * (2.0 / WAVES as f64).sqrt();
    std::array::from_fn(|index| {
        let turn = (index as f64 * 0.618_034).fract();
        let direction = WIND + SPREAD * (2.0 * turn - 1.0);
        let longest = TAU / f64::from(water.wave_length);
        let number = longest / SHORTER.powi(index as i32);
        let periods = (WATER_PERIOD * SPEED * (number / longest).sqrt()).round();
        let phase = (index as f64 * 2.399_963 - TAU * periods * (water.time / WATER_PERIOD)).rem_euclid(TAU);
        [number * direction.cos(), number * direction.sin(), slope, phase].map(|value| value as f32)
    })
}

/// The pass's buffers: the terrain's constants, for the box of the water, and its own.
#[derive(Debug)]
pub(super) struct WaterBindings {
    terrain: wgpu::Buffer,
    water: wgpu::Buffer,
}

impl WaterBindings {
    fn new(gpu: &Gpu) -> Self {
        let water = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("water"),
            size: size_of::<WaterBuffer>() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { terrain: uniform_buffer::<TerrainUniform>(gpu, "terrain under water"), water }
    }
}

impl Renderer {
    /// What the sea of `scene` needs, if one is to be seen over this map.
    pub(super) fn water_key(&self, scene: &Scene, deep: bool, probe: bool) -> Option<WaterKey> {
        let ground = self.ground.as_ref().filter(|_| !deep)?;
        WaterKey::of(scene, ground.has_holes(), probe)
    }

    /// Whether the eye is in the sea of `scene`.
    pub(super) fn is_under_water(&self, scene: &Scene, view: &View) -> bool {
        self.place_of_eye(scene, view) == Some(EyePlace::Within)
    }

    /// Where the eye is seen from the sea of `scene`; `None` where there is none.
    pub(super) fn place_of_eye(&self, scene: &Scene, view: &View) -> Option<EyePlace> {
        self.water_key(scene, view.deep, false)?;
        let block = block(scene, self.ground.as_ref()?, view.extent).ok().flatten()?;
        Some(EyePlace::of(view.camera.eye, block))
    }

    /// The draw of the sea; `None` where no water is in view.
    ///
    /// # Errors
    /// [`RenderError::Impossible`] where its level is in metres that the map does not know, [`RenderError::Shader`].
    pub(super) fn water_draw(
        &mut self,
        scene: &Scene,
        view: &View,
        area: Area,
        key: WaterKey,
    ) -> Result<Option<Draw>, RenderError> {
        let Some(ground) = &self.ground else { return Ok(None) };
        let Some(block) = block(scene, ground, view.extent)? else { return Ok(None) };
        let clip = terrain::drawn_box(&view.camera, view.size, block);
        if !in_view(&clip) {
            return Ok(None);
        }
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Water(key))?;
        let world_from_cube = occluder::world_from_cube(&scene.occluder, ground.terrain().base(), view.extent);
        let uniform = TerrainUniform::new(scene, ground, self.drape.as_ref(), view.extent, &clip);
        let buffer = WaterBuffer::new(scene, view, block, world_from_cube);
        let bindings = self.water.get_or_insert_with(|| WaterBindings::new(&self.gpu));
        self.gpu.queue.write_buffer(&bindings.terrain, 0, bytemuck::bytes_of(&uniform));
        self.gpu.queue.write_buffer(&bindings.water, 0, bytemuck::bytes_of(&buffer));
        let textures = Textures {
            ground,
            drape: self.drape.as_ref(),
            land: &self.land,
            materials: self.materials.as_ref(),
            atmosphere: &self.atmosphere,
            beams: None,
            light_map: self.baking.map.as_ref(),
            given: None,
            exact: None,
        };
        let bindings = &*bindings;
        let Some(mut entries) = self.terrain.entries(&bindings.terrain, key.ground, uniform.repeats, &textures) else {
            return Ok(None);
        };
        entries.push((WATER, bindings.water.as_entire_binding()));
        if key.clouds {
            if !key.ground.air.is_on() {
                entries.push(self.atmosphere.air.entry());
            }
            let Some(clouds) = &self.atmosphere.clouds else { return Ok(None) };
            entries.extend(clouds.layer_entries());
        }
        if key.sky {
            let Some(sky) = self.skybox.as_ref().map(Skybox::entries) else { return Ok(None) };
            entries.extend([SKY, SKY_SAMPLER].into_iter().zip(sky));
        }
        let group = bind(&self.gpu, &built, entries);
        Ok(Some(Draw { name: "water", built, group, edges: false, area }))
    }

    /// Where the light of every pixel goes that comes out of the sea of `scene`, whether or not hills hide it: see
    /// [`WaterPath`]. Row 0 at the top; `None` where a ray meets no water. Waits for the GPU; leaves the ledger as it is.
    ///
    /// # Errors
    /// As [`Renderer::draw`], and where nothing can be read back.
    pub fn probe_water(&mut self, scene: &Scene, size: [u32; 2]) -> Result<Vec<Option<WaterPath>>, RenderError> {
        self.check_device()?;
        crate::scene_file::validate(scene)?;
        let view = self.view(scene, size);
        let none = vec![None; size[0] as usize * size[1] as usize];
        let Some(key) = self.water_key(scene, view.deep, true) else { return Ok(none) };
        self.prepare_ground(scene, &view)?;
        self.frame.write(&self.gpu, &FrameUniform::new(&view.camera, size, view.extent, scene.skybox.flattening));
        let Some(draw) = self.water_draw(scene, &view, Area::whole(size), key)? else { return Ok(none) };
        let color = sized_texture(&self.gpu, "probe", size, PROBE_FORMAT, &[]);
        let target = Target::new(&self.gpu, size);
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("probe of water") });
        {
            let attachments = [Some(wgpu::RenderPassColorAttachment {
                view: &color.create_view(&wgpu::TextureViewDescriptor::default()),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r: 0.0, g: 0.0, b: 0.0, a: -1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })];
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("probe of water"),
                color_attachments: &attachments,
                depth_stencil_attachment: Some(super::clear_depth(&target.depth_view)),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            self.encode(&mut pass, &draw);
        }
        self.gpu.queue.submit([encoder.finish()]);
        let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&read_texture(&self.gpu, &color)?);
        Ok(texels.into_iter().map(WaterPath::of).collect())
    }
}

/// How a leg of light ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LegEnd {
    /// There is no such leg, or too little light takes it to be followed.
    None,
    /// It meets neither ground nor occluder.
    Nothing,
    /// It meets one of them after so many world units.
    At(f32),
}

impl LegEnd {
    fn of(length: f32) -> Self {
        match length {
            length if length >= 0.0 => Self::At(length),
            length if length > -1.5 => Self::Nothing,
            _ => Self::None,
        }
    }
}

/// Where the light of a pixel goes, from the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaterPath {
    /// Whether the ray begins under water, or comes in through a cut side of it.
    pub begins_in_water: bool,
    /// To the surface; or, for a ray that begins in water, to what it meets there first, surface or ground.
    pub first: LegEnd,
    /// From the surface through air.
    pub air: LegEnd,
    /// From the surface through water.
    pub water: LegEnd,
}

impl WaterPath {
    fn of([first, air, water, kind]: [f32; 4]) -> Option<Self> {
        let [first, air, water] = [first, air, water].map(LegEnd::of);
        (kind >= 0.0).then_some(Self { begins_in_water: kind > 0.5, first, air, water })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the clock begins anew, waves and foam are where they were: by an hour's end nothing has jumped.
    #[test]
    fn what_moves_is_where_it_was_after_the_clocks_period() {
        let at = |time: f64| Water { waves: 1.0, time, ..Water::default() };
        let apart = |a: f32, b: f32| f64::from((a - b).abs()).min(TAU - f64::from((a - b).abs()));
        let step = 0.01;
        let ends = [0.0, WATER_PERIOD - step, WATER_PERIOD].map(|time| (waves(&at(time)), foam_shift(time)));
        let [first, before, last] = &ends;
        for index in 0..WAVES {
            assert!(apart(first.0[index][3], last.0[index][3]) < 1e-3, "wave {index}");
            // At its own pace: the shortest one turns by less than an eighth of a radian in a hundredth of a second.
            let turned = apart(before.0[index][3], last.0[index][3]);
            assert!((1e-3..0.125).contains(&turned), "wave {index} turns by {turned}");
        }
        assert!((0..2).all(|axis| (first.1[axis] - last.1[axis]).abs() < 1e-4), "{ends:?}");
        let mut water = at(WATER_PERIOD - step);
        water.run(step);
        assert!(water.time < 1e-9, "{}", water.time);
        // Columns of bubbles rise by whole rounds of the 540 cells after which `waves.wgsl` repeats.
        for tenths in 6..14 {
            assert!((WATER_PERIOD * RISE * f64::from(tenths) / 10.0).rem_euclid(540.0) < 1e-6);
        }
    }
}
