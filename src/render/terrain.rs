//! The terrain pass: its pipelines, where it is drawn, and what it reads. Its shader is `terrain.wgsl`.

use glam::{DMat4, DVec3, DVec4};

use crate::camera::Camera;
use crate::gpu::Gpu;
use crate::heightfield::fractal::Detail;

use super::anchor::{AnchorUniform, MOST_ANCHORS};
use super::atmosphere::Atmosphere;
use super::beam::{Beams, Tiles};
use super::cube::corner;
use super::drape::Drape;
use super::frame::{corner_sampler_entry, sampler_entry, storage_entry, texture_entry, uniform_buffer, uniform_entry};
use super::ground::Ground;
use super::land::Land;
use super::light::{self, LightBindings};
use super::light_map::{self, LightMap};
use super::materials::{self, Materials};
use super::pipelines::{Built, PassDescription};

pub(super) use super::terrain_key::{Output, TerrainKey};
pub(super) use super::terrain_uniform::TerrainUniform;

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
/// Binding of what deep zooms count from.
const ANCHOR: u32 = 14;
/// Binding of what invented detail is made of.
const DETAIL: u32 = 60;

/// What `ground.wgsl` may import, and itself. The composer wants a module that any def could import; what is not imported is
/// not composed.
pub(super) const GROUND_MODULES: [&str; 7] =
    ["air.wgsl", "pyramid.wgsl", "shadow.wgsl", "shading.wgsl", "land.wgsl", "materials.wgsl", "ground.wgsl"];

pub(super) fn describe(key: TerrainKey) -> PassDescription {
    let filtered = key.filters_heights();
    let mut bindings = vec![uniform_entry::<TerrainUniform>(0)];
    let mut modules = vec![
        "frame.wgsl",
        "heightfield.wgsl",
        "varyings.wgsl",
        "light.wgsl",
        "march/smooth.wgsl",
        "march/fractal.wgsl",
    ];
    if key.deep {
        modules.push("anchor.wgsl");
    }
    let mut name = "terrain".to_owned();
    if key.reads_heights() {
        bindings.extend([texture_entry(1, filtered, false), corner_sampler_entry(7)]);
    }
    if key.light.needs_uniform() {
        bindings.push(light::layout_entry());
    }
    if key.light.needs_map() {
        bindings.extend(light_map::layout_entries());
    }
    modules.extend(GROUND_MODULES);
    if key.marches() {
        modules.push("sampling.wgsl");
        if key.needs_cones().is_some() {
            modules.push("cones.wgsl");
        }
        modules.push(key.march_file());
        name = format!("terrain {}", key.technique.name());
    } else if key.given {
        bindings.push(texture_entry(GIVEN_DISTANCES, false, false));
        name = "terrain of given distances".to_owned();
    }
    if key.needs_exact_distances() {
        bindings.push(texture_entry(EXACT_DISTANCES, false, false));
    }
    if key.deep {
        bindings.push(uniform_entry::<[AnchorUniform; MOST_ANCHORS]>(ANCHOR));
    }
    if filtered {
        bindings.push(sampler_entry(2));
    }
    if key.needs_pyramid() {
        bindings.push(texture_entry(3, false, false));
    }
    if key.is_fractal() {
        bindings.push(storage_entry::<[f32; 4]>(DETAIL));
    }
    if key.starts_from_beams() {
        bindings.push(texture_entry(8, false, false));
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
    bindings.extend(key.air.bindings());
    bindings.extend(key.land.bindings());
    if key.materials.on {
        bindings.extend(materials::layout_entries(key.materials));
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

/// Corners of a cube, in clip space, whose only face that is turned away covers the whole picture.
///
/// In a deep zoom the corners of the terrain's box lie millions of pictures beside the view, and a rasteriser that clips in
/// single precision would lose the box's outline by many pixels. There every pixel casts its ray, and the exact clipping
/// of the ray to the box decides.
pub(super) fn whole_picture() -> [DVec4; 8] {
    // A camera that looks north has x to its right, and the corners of the larger z are the nearer ones.
    std::array::from_fn(|index| {
        let corner = corner(index) * 2.0 - 1.0;
        DVec4::new(2.0 * corner.x, 2.0 * corner.y, 0.5 + 0.25 * corner.z, 1.0)
    })
}

/// Owners of the textures that the pass may read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Textures<'a> {
    pub(super) ground: &'a Ground,
    pub(super) drape: Option<&'a Drape>,
    pub(super) land: &'a Land,
    pub(super) materials: Option<&'a Materials>,
    pub(super) atmosphere: &'a Atmosphere,
    pub(super) beams: Option<&'a Beams>,
    pub(super) light_map: Option<&'a LightMap>,
    /// Distances to read instead of casting rays.
    pub(super) given: Option<&'a wgpu::TextureView>,
    /// Distances to compare with.
    pub(super) exact: Option<&'a wgpu::TextureView>,
}

/// The pass's uniform buffer and samplers.
#[derive(Debug)]
pub(super) struct TerrainBindings {
    buffer: wgpu::Buffer,
    anchors: wgpu::Buffer,
    detail: wgpu::Buffer,
    pub(super) light: LightBindings,
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
            anchors: uniform_buffer::<[AnchorUniform; MOST_ANCHORS]>(gpu, "anchors"),
            detail: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("detail"),
                size: size_of::<[f32; 4]>() as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            light: LightBindings::new(gpu),
            corner_sampler: gpu
                .device
                .create_sampler(&wgpu::SamplerDescriptor { label: Some("corners of cells"), ..Default::default() }),
            height_sampler: sampler("heights", wgpu::AddressMode::ClampToEdge),
            clamped: sampler("diffuse", wgpu::AddressMode::ClampToEdge),
            repeated: sampler("diffuse, repeated", wgpu::AddressMode::Repeat),
        }
    }

    /// Writes what deep zooms count from.
    pub(super) fn write_anchors(&self, gpu: &Gpu, anchors: &[AnchorUniform; MOST_ANCHORS]) {
        gpu.queue.write_buffer(&self.anchors, 0, bytemuck::bytes_of(anchors));
    }

    /// Writes the uniform alone, for another pass that reads it.
    pub(super) fn write(&self, gpu: &Gpu, uniform: &TerrainUniform) {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
    }

    /// What a walk over the ground towards the sun reads; `None` without a pyramid.
    pub(super) fn shadow_entries<'a>(
        &'a self,
        ground: &'a Ground,
        light: &'a LightBindings,
    ) -> Option<Vec<(u32, wgpu::BindingResource<'a>)>> {
        let view = wgpu::BindingResource::TextureView;
        let mut entries = vec![
            (0, self.buffer.as_entire_binding()),
            (1, view(ground.heights())),
            (3, view(ground.pyramid()?)),
            (7, wgpu::BindingResource::Sampler(&self.corner_sampler)),
            light.entry(),
        ];
        entries.extend(ground.layer().map(|(layer, ..)| (4, view(layer))));
        Some(entries)
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
        self.write(gpu, uniform);
        if key.is_fractal() {
            let Detail { amplitude, gain } = textures.ground.prepared_detail()?;
            let numbers = [amplitude as f32, gain as f32, 0.0, 0.0];
            gpu.queue.write_buffer(&self.detail, 0, bytemuck::bytes_of(&numbers));
        }
        let mut entries = self.entries(&self.buffer, key, uniform.repeats, textures)?;
        if key.starts_from_beams() {
            entries.push((8, wgpu::BindingResource::TextureView(textures.beams?.starts(Tiles::Fine))));
        }
        Some(bind(gpu, built, entries))
    }

    /// What a pass that finds and shades the ground by `key` reads, but for starts of beams: `uniform` holds its
    /// [`TerrainUniform`], in which the diffuse texture repeats so often. `None` where a texture is missing.
    pub(super) fn entries<'a>(
        &'a self,
        uniform: &'a wgpu::Buffer,
        key: TerrainKey,
        repeats: f32,
        textures: &Textures<'a>,
    ) -> Option<Vec<(u32, wgpu::BindingResource<'a>)>> {
        let &Textures { ground, drape, land, materials, atmosphere, light_map, given, exact, .. } = textures;
        let view = wgpu::BindingResource::TextureView;
        let mut entries = vec![(0, uniform.as_entire_binding())];
        if key.given {
            entries.push((GIVEN_DISTANCES, view(given?)));
        }
        if key.needs_exact_distances() {
            entries.push((EXACT_DISTANCES, view(exact?)));
        }
        if key.deep {
            entries.push((ANCHOR, self.anchors.as_entire_binding()));
        }
        if key.reads_heights() {
            entries.extend([(1, view(ground.heights())), (7, wgpu::BindingResource::Sampler(&self.corner_sampler))]);
        }
        if key.filters_heights() {
            entries.push((2, wgpu::BindingResource::Sampler(&self.height_sampler)));
        }
        if key.needs_pyramid() {
            entries.push((3, view(ground.pyramid()?)));
        }
        if key.is_fractal() {
            entries.push((DETAIL, self.detail.as_entire_binding()));
        }
        if key.light.needs_map() {
            entries.extend(light_map?.entries());
        }
        if key.light.needs_uniform() {
            entries.push(self.light.entry());
        }
        if let Some(kind) = key.needs_cones() {
            entries.push((9, view(ground.cones(kind)?)));
        }
        if key.layered {
            entries.push((4, view(ground.layer()?.0)));
        }
        if key.diffuse {
            let sampler = if repeats > 1.0 { &self.repeated } else { &self.clamped };
            entries.extend([(5, view(drape?.view()?)), (6, wgpu::BindingResource::Sampler(sampler))]);
        }
        entries.extend(atmosphere.entries(key.air)?);
        entries.extend(land.entries(key.land)?);
        if key.materials.on {
            entries.extend(materials?.entries(key.materials)?);
        }
        Some(entries)
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

pub(super) fn bind(gpu: &Gpu, built: &Built, entries: Vec<(u32, wgpu::BindingResource<'_>)>) -> wgpu::BindGroup {
    let entries: Vec<_> =
        entries.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(&built.name),
        layout: &built.layout,
        entries: &entries,
    })
}
