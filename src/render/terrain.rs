//! The terrain pass: which pipeline a scene needs, and its uniform. Mirrors `Terrain` in `shaders/heightfield.wgsl`; the
//! pass itself is `terrain.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, DVec4, Vec3};

use crate::camera::Camera;
use crate::gpu::Gpu;
use crate::heightfield::ConeKind;
use crate::scene::{CraterMode, DebugView, HeightFilter, Scene, Technique};

use super::beam::{Beams, Tiles};
use super::cube::corner;
use super::drape::Drape;
use super::frame::{
    corner_sampler_entry, sampler_entry, texture_entry, uniform_buffer, uniform_entry, without_subnormals,
};
use super::ground::Ground;
use super::pipelines::{Built, PassDescription};

/// The drawn box is larger than the terrain's by this share of its longest side, so that the rasteriser's rounding
/// cuts off no ray that still meets the terrain; rays beside the true box are dropped in the shader.
const INFLATION: f64 = 1e-3;

/// And by so many pixels: Vulkan lets a rasteriser keep corners to a sixteenth of one, which from afar is more than any
/// share of the box.
const INFLATION_PIXELS: f64 = 0.125;

/// Binding of the texture of distances that are given.
const GIVEN_DISTANCES: u32 = 12;
/// Binding of the texture of distances to compare with.
const EXACT_DISTANCES: u32 = 13;

/// What the pass writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Output {
    /// A picture.
    View(DebugView),
    /// Distance, steps, capped.
    Probe,
}

/// All that is compiled into the terrain's pipeline. What a technique or view does not use is normalised away, so that
/// flipping it builds nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TerrainKey {
    pub(super) technique: Technique,
    pub(super) filter: HeightFilter,
    pub(super) steps_by_angle: bool,
    pub(super) lower_start: bool,
    pub(super) discard_misses: bool,
    pub(super) lighting: bool,
    pub(super) diffuse: bool,
    pub(super) layered: bool,
    /// Hits are read from a texture of distances, and no ray is cast.
    pub(super) given: bool,
    pub(super) output: Output,
}

impl TerrainKey {
    /// The pipeline that `scene` needs for a picture, or for a probe of it.
    pub(super) fn of(scene: &Scene, probe: bool) -> Self {
        Self::of_technique(scene, scene.march.technique, probe)
    }

    /// The same with another technique than the scene's.
    pub(super) fn of_technique(scene: &Scene, technique: Technique, probe: bool) -> Self {
        let march = &scene.march;
        let output = if probe { Output::Probe } else { Output::View(scene.debug.view) };
        let shaded = output == Output::View(DebugView::None);
        let key = Self {
            technique,
            filter: if technique.samples_uniformly() { march.filter } else { HeightFilter::Exact },
            steps_by_angle: technique.counts_samples() && march.steps_by_angle,
            lower_start: march.lower_start,
            // A miss is an error to be shown, whatever a picture would show in its place.
            discard_misses: march.discard_misses || output == Output::View(DebugView::Error),
            lighting: shaded && scene.lighting.enabled,
            diffuse: shaded && scene.diffuse.enabled,
            layered: scene.craters.mode == CraterMode::Layered && !scene.craters.list.is_empty(),
            given: false,
            output,
        };
        if key.finds_ground() { key } else { Self::without_rays() }
    }

    /// What finds the exact distances of `scene`, for the error view.
    pub(super) fn of_exact_distances(scene: &Scene) -> Self {
        Self { discard_misses: true, ..Self::of_technique(scene, Technique::MaxMipmap, true) }
    }

    /// The same picture from given distances: how hits would be found does not matter then.
    pub(super) fn with_given_distances(self) -> Self {
        if !self.finds_ground() {
            return self;
        }
        let key = Self {
            technique: Technique::default(),
            filter: HeightFilter::Exact,
            steps_by_angle: false,
            lower_start: true,
            given: true,
            ..self
        };
        Self { layered: key.layered && key.reads_heights(), ..key }
    }

    /// Whether the pass finds out where the ground is.
    fn finds_ground(&self) -> bool {
        self.output != Output::View(DebugView::Position)
    }

    /// Whether rays are cast.
    pub(super) fn marches(&self) -> bool {
        self.finds_ground() && !self.given
    }

    /// Whether heights are read: by the rays, or for normals alone.
    fn reads_heights(&self) -> bool {
        self.marches() || self.needs_normals()
    }

    fn needs_normals(&self) -> bool {
        self.lighting || self.output == Output::View(DebugView::Normals)
    }

    /// Whether hits are compared with the exact distances.
    pub(super) fn needs_exact_distances(&self) -> bool {
        self.output == Output::View(DebugView::Error)
    }

    /// Whether the technique walks the maximum pyramid.
    pub(super) fn needs_pyramid(&self) -> bool {
        self.marches() && self.technique == Technique::MaxMipmap
    }

    /// The cone map that the technique steps along.
    pub(super) fn needs_cones(&self) -> Option<ConeKind> {
        self.technique.cones().filter(|_| self.marches())
    }

    /// Whether heights are read through the sampler's linear filter.
    pub(super) fn filters_heights(&self) -> bool {
        self.filter == HeightFilter::HardwareLinear
    }

    fn without_rays() -> Self {
        Self {
            technique: Technique::default(),
            filter: HeightFilter::Exact,
            steps_by_angle: false,
            lower_start: false,
            discard_misses: false,
            lighting: false,
            diffuse: false,
            layered: false,
            given: false,
            output: Output::View(DebugView::Position),
        }
    }

    /// Every key that a scene can lead to.
    #[cfg(test)]
    pub(super) fn all() -> Vec<Self> {
        let mut keys = std::collections::HashSet::new();
        for (technique, filter, view) in Technique::ALL.into_iter().flat_map(|technique| {
            [HeightFilter::Exact, HeightFilter::HardwareLinear, HeightFilter::Nearest]
                .into_iter()
                .flat_map(move |filter| DebugView::ALL.map(|view| (technique, filter, view)))
        }) {
            for bits in 0..128u32 {
                let bit = |index: u32| bits & (1 << index) != 0;
                let mut scene = Scene::default();
                scene.march.technique = technique;
                scene.march.filter = filter;
                scene.march.steps_by_angle = bit(0);
                scene.march.lower_start = bit(1);
                scene.march.discard_misses = bit(2);
                scene.lighting.enabled = bit(3);
                scene.diffuse.enabled = bit(4);
                scene.debug.view = view;
                if bit(5) {
                    scene.craters.mode = CraterMode::Layered;
                    scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
                }
                let key = Self::of(&scene, bit(6));
                keys.insert(key);
                keys.insert(Self::of_exact_distances(&scene));
                if !bit(6) {
                    keys.insert(key.with_given_distances());
                }
            }
        }
        keys.into_iter().collect()
    }

    fn defs(&self) -> Vec<&'static str> {
        let shaded = self.output == Output::View(DebugView::None);
        [
            (self.filter == HeightFilter::HardwareLinear, "FILTER_HARDWARE_LINEAR"),
            (self.filters_heights(), "HEIGHT_SAMPLER"),
            (self.filter == HeightFilter::Nearest, "FILTER_NEAREST"),
            (self.needs_pyramid(), "BEAM"),
            (self.steps_by_angle, "STEPS_BY_ANGLE"),
            (self.lower_start, "LOWER_START"),
            (self.discard_misses, "DISCARD_MISSES"),
            (self.layered, "CRATERS_LAYERED"),
            (shaded, "SHADED"),
            (self.lighting, "LIGHTING"),
            (self.diffuse, "DIFFUSE_TEXTURE"),
            (self.needs_normals(), "SURFACE_NORMAL"),
            (self.given, "GIVEN_DISTANCES"),
            (self.output == Output::Probe, "PROBE"),
            (self.output == Output::View(DebugView::Position), "VIEW_POSITION"),
            (self.output == Output::View(DebugView::Steps), "VIEW_STEPS"),
            (self.needs_exact_distances(), "VIEW_ERROR"),
            (self.output == Output::View(DebugView::Normals), "VIEW_NORMALS"),
            (self.output == Output::View(DebugView::Distance), "VIEW_DISTANCE"),
        ]
        .into_iter()
        .filter_map(|(on, def)| on.then_some(def))
        .collect()
    }

    fn march_file(&self) -> &'static str {
        match self.technique {
            Technique::Linear => "march/linear.wgsl",
            Technique::LinearBinary => "march/linear-binary.wgsl",
            Technique::Secant => "march/secant.wgsl",
            Technique::Cone => "march/cone.wgsl",
            Technique::RelaxedCone => "march/relaxed-cone.wgsl",
            Technique::MaxMipmap => "march/max-mipmap.wgsl",
        }
    }
}

pub(super) fn describe(key: TerrainKey) -> PassDescription {
    let filtered = key.filters_heights();
    let mut bindings = vec![uniform_entry::<TerrainUniform>(0)];
    let mut modules = vec!["frame.wgsl", "heightfield.wgsl", "varyings.wgsl"];
    let mut name = "terrain".to_owned();
    if key.reads_heights() {
        bindings.extend([texture_entry(1, filtered, false), corner_sampler_entry(7)]);
    }
    if key.marches() {
        if key.needs_pyramid() {
            modules.push("pyramid.wgsl");
        }
        modules.push("sampling.wgsl");
        if key.needs_cones().is_some() {
            modules.push("cones.wgsl");
        }
        modules.extend([key.march_file(), "shading.wgsl"]);
        name = format!("terrain {}", key.technique.name());
    } else if key.given {
        bindings.push(texture_entry(GIVEN_DISTANCES, false, false));
        modules.push("shading.wgsl");
        name = "terrain of given distances".to_owned();
    }
    if key.needs_exact_distances() {
        bindings.push(texture_entry(EXACT_DISTANCES, false, false));
    }
    if filtered {
        bindings.push(sampler_entry(2));
    }
    if key.needs_pyramid() {
        bindings.extend([texture_entry(3, false, false), texture_entry(8, false, false)]);
    }
    if key.needs_cones().is_some() {
        bindings.push(texture_entry(9, false, false));
    }
    if key.layered {
        bindings.push(texture_entry(4, filtered, false));
    }
    if key.diffuse {
        bindings.extend([texture_entry(5, true, false), sampler_entry(6)]);
    }
    let defs = key.defs();
    PassDescription {
        name: format!("{name} [{}]", defs.join(" ")),
        modules,
        defs,
        bindings,
        casts_rays: key.finds_ground(),
        // The far side of the box: it is there from inside the box, too.
        cull: Some(wgpu::Face::Front),
        ..PassDescription::scene("terrain", "terrain.wgsl", key.output == Output::Probe)
    }
}

/// Mirror of `Terrain` in `heightfield.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct TerrainUniform {
    pub(super) box_clip: [[f32; 4]; 8],
    pub(super) size: Vec3,
    pub(super) highest: f32,
    pub(super) cells: [f32; 2],
    pub(super) cells_per_unit: [f32; 2],
    pub(super) texel_size: [f32; 2],
    pub(super) pyramid_stack: [f32; 2],
    pub(super) repeats_per_cell: [f32; 2],
    pub(super) pyramid_texel: [f32; 2],
    pub(super) layer_cells: [f32; 2],
    pub(super) samples: [f32; 2],
    pub(super) top_size: f32,
    pub(super) layer_rise: f32,
    pub(super) farthest: f32,
    pub(super) texel_density: f32,
    pub(super) binary_steps: u32,
    pub(super) step_cap: u32,
    pub(super) heat_map_max: f32,
    pub(super) repeats: f32,
    pub(super) diffuse: f32,
    pub(super) specular: f32,
    pub(super) shininess: f32,
    pub(super) height_unit: f32,
    pub(super) sun: Vec3,
    pub(super) ambient: f32,
}

impl TerrainUniform {
    pub(super) fn new(
        scene: &Scene,
        ground: &Ground,
        drape: Option<&Drape>,
        extent: DVec3,
        box_clip: &[DVec4; 8],
    ) -> Self {
        let field = ground.terrain().base();
        let cells = field.cells();
        let (layer_cells, rise) = ground.layer().map_or(([1, 1], 0.0), |(_, cells, rise)| (cells, rise));
        let (light, levels) = (&scene.lighting, ground.pyramid_layout());
        let floats = without_subnormals(Self {
            box_clip: super::cube::as_f32(box_clip),
            size: extent.as_vec3(),
            highest: ground.highest() * extent.y as f32,
            cells: cells.map(|side| side as f32),
            cells_per_unit: [(f64::from(cells[0]) / extent.x) as f32, (f64::from(cells[1]) / extent.z) as f32],
            texel_size: cells.map(|side| (1.0 / f64::from(side + 1)) as f32),
            pyramid_stack: levels.stack.map(|side| side as f32),
            repeats_per_cell: cells.map(|side| scene.diffuse.repeats / side as f32),
            pyramid_texel: levels.size().map(|side| (1.0 / f64::from(side)) as f32),
            layer_cells: layer_cells.map(|side| side as f32),
            samples: [scene.march.samples_min as f32, scene.march.samples_max as f32],
            top_size: ground.top_size(),
            layer_rise: rise * extent.y as f32,
            farthest: box_clip.iter().map(|corner| corner.w).fold(0.0, f64::max) as f32,
            texel_density: drape.map_or(1.0, |drape| drape.texel_density([extent.x, extent.z]) as f32),
            binary_steps: 0,
            step_cap: 0,
            heat_map_max: scene.debug.heat_map_max.max(1) as f32,
            repeats: scene.diffuse.repeats,
            diffuse: light.diffuse,
            specular: light.specular,
            shininess: light.shininess,
            height_unit: (extent.y * ground.height_unit()) as f32,
            sun: light.sun_direction().as_vec3(),
            ambient: light.ambient,
        });
        Self { binary_steps: scene.march.binary_steps, step_cap: step_cap(cells), ..floats }
    }
}

/// Most steps of a walk over so many cells: every node that a ray can cross on every level, going down and up again,
/// twice over.
pub(super) fn step_cap(cells: [u32; 2]) -> u32 {
    8 * (cells[0] + cells[1]) + 256
}

/// From the unit cube to the terrain's box, a little inflated.
pub(super) fn world_from_box(extent: DVec3) -> DMat4 {
    let margin = DVec3::splat(INFLATION * extent.max_element());
    DMat4::from_translation(-margin) * DMat4::from_scale(extent + 2.0 * margin)
}

/// The corners of the drawn box, in clip space, in a picture of `size` pixels.
///
/// A box that grows by δ along each axis has its outline, seen from anywhere, at least δ farther out: between a face
/// turned towards the eye and one turned away both normals push the edge the same way. δ grows linearly with the view
/// depth, so along an edge it stays the same share of a pixel; behind the eye, where only the edge's other part is seen,
/// its magnitude counts.
pub(super) fn drawn_box(camera: &Camera, size: [u32; 2], extent: DVec3) -> [DVec4; 8] {
    let (clip_from_world, forward) = (camera.clip_from_world(size), camera.basis().forward);
    let pixel = camera.pixel_size(size[1]);
    std::array::from_fn(|index| {
        let corner = corner(index);
        let place = corner * extent;
        let depth = forward.dot(place - camera.eye).abs();
        let margin = INFLATION * extent.max_element() + INFLATION_PIXELS * pixel * depth;
        clip_from_world * (place + (corner * 2.0 - 1.0) * margin).extend(1.0)
    })
}

/// Owners of the textures that the pass may read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Textures<'a> {
    pub(super) ground: &'a Ground,
    pub(super) drape: Option<&'a Drape>,
    pub(super) beams: Option<&'a Beams>,
    /// Distances to read instead of casting rays.
    pub(super) given: Option<&'a wgpu::TextureView>,
    /// Distances to compare with.
    pub(super) exact: Option<&'a wgpu::TextureView>,
}

/// The pass's uniform buffer and samplers.
#[derive(Debug)]
pub(super) struct TerrainBindings {
    buffer: wgpu::Buffer,
    corner_sampler: wgpu::Sampler,
    height_sampler: wgpu::Sampler,
    /// For a texture that covers the terrain once: its last texels must not mix with the first.
    clamped: wgpu::Sampler,
    repeated: wgpu::Sampler,
}

impl TerrainBindings {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let sampler = |label, address| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: address,
                address_mode_v: address,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            })
        };
        Self {
            buffer: uniform_buffer::<TerrainUniform>(gpu, "terrain"),
            corner_sampler: gpu
                .device
                .create_sampler(&wgpu::SamplerDescriptor { label: Some("corners of cells"), ..Default::default() }),
            height_sampler: sampler("heights", wgpu::AddressMode::ClampToEdge),
            clamped: sampler("diffuse", wgpu::AddressMode::ClampToEdge),
            repeated: sampler("diffuse, repeated", wgpu::AddressMode::Repeat),
        }
    }

    /// Writes the uniform and makes the bind group of `built`; `None` where a texture it needs is missing.
    pub(super) fn prepare(
        &self,
        gpu: &Gpu,
        built: &Built,
        key: TerrainKey,
        uniform: &TerrainUniform,
        textures: &Textures<'_>,
    ) -> Option<wgpu::BindGroup> {
        let &Textures { ground, drape, beams, given, exact } = textures;
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
        let view = wgpu::BindingResource::TextureView;
        let mut entries = vec![(0, self.buffer.as_entire_binding())];
        if key.given {
            entries.push((GIVEN_DISTANCES, view(given?)));
        }
        if key.needs_exact_distances() {
            entries.push((EXACT_DISTANCES, view(exact?)));
        }
        if key.reads_heights() {
            entries.extend([(1, view(ground.heights())), (7, wgpu::BindingResource::Sampler(&self.corner_sampler))]);
        }
        if key.filters_heights() {
            entries.push((2, wgpu::BindingResource::Sampler(&self.height_sampler)));
        }
        if key.needs_pyramid() {
            entries.extend([(3, view(ground.pyramid()?)), (8, view(beams?.starts(Tiles::Fine)))]);
        }
        if let Some(kind) = key.needs_cones() {
            entries.push((9, view(ground.cones(kind)?)));
        }
        if key.layered {
            entries.push((4, view(ground.layer()?.0)));
        }
        if key.diffuse {
            let sampler = if uniform.repeats > 1.0 { &self.repeated } else { &self.clamped };
            entries.extend([(5, view(drape?.view()?)), (6, wgpu::BindingResource::Sampler(sampler))]);
        }
        Some(bind(gpu, built, entries))
    }

    /// The bind group of a beam pass, `built` for these tiles, which shares the uniform; `None` without a pyramid.
    pub(super) fn beam_group(
        &self,
        gpu: &Gpu,
        built: &Built,
        ground: &Ground,
        beams: &Beams,
        tiles: Tiles,
    ) -> Option<wgpu::BindGroup> {
        let mut entries = vec![
            (0, self.buffer.as_entire_binding()),
            (3, wgpu::BindingResource::TextureView(ground.pyramid()?)),
            (7, wgpu::BindingResource::Sampler(&self.corner_sampler)),
        ];
        if tiles == Tiles::Fine {
            entries.push((8, wgpu::BindingResource::TextureView(beams.starts(Tiles::Coarse))));
        }
        Some(bind(gpu, built, entries))
    }
}

fn bind(gpu: &Gpu, built: &Built, entries: Vec<(u32, wgpu::BindingResource<'_>)>) -> wgpu::BindGroup {
    let entries: Vec<_> =
        entries.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(&built.name),
        layout: &built.layout,
        entries: &entries,
    })
}
