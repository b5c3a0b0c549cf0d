//! What the terrain pass needs to show the land as on a map: its key, its uniform, the ramp's colours and a placed picture.
//! Its shader is `land.wgsl`.

use std::path::{Path, PathBuf};

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use super::frame::{sampler_entry, texture_entry, uniform_buffer, uniform_entry, without_subnormals};
use super::ground::{Ground, Texture};
use super::images::{Decoded, Images, Purpose};
use super::ledger::TextureEntry;
use super::mips::{self, Image};
use super::{RenderError, Renderer};
use crate::gpu::Gpu;
use crate::heightfield::import::imagery;
use crate::heightfield::{HeightField, SampleRect};
use crate::scene::{GroundColour, Hillshade, LandSettings, Ramp, ramp};

/// Bindings of group 1.
const UNIFORM: u32 = 32;
const COLOURS: u32 = 33;
const SAMPLER: u32 = 34;
const IMAGERY: u32 = 35;

/// What of it is compiled into the terrain's pipeline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct LandKey {
    pub(super) colour: GroundColour,
    pub(super) hillshade: Hillshade,
    pub(super) contours: bool,
    pub(super) imagery: bool,
}

impl LandKey {
    /// What a shaded picture with these settings needs.
    pub(super) fn of(land: &LandSettings) -> Self {
        Self {
            colour: land.colour,
            hillshade: if land.hillshade_strength > 0.0 { land.hillshade } else { Hillshade::Off },
            contours: land.contours,
            imagery: land.imagery.is_some() && land.imagery_opacity > 0.0,
        }
    }

    /// Whether it takes the place of the ground's texture.
    pub(super) fn colours_ground(self) -> bool {
        self.colour != GroundColour::Texture
    }

    /// Whether it takes the place of the lighting.
    pub(super) fn lights_ground(self) -> bool {
        self.hillshade != Hillshade::Off
    }

    fn is_on(self) -> bool {
        self != Self::default()
    }

    /// Whether the ground's normal is needed.
    pub(super) fn needs_normals(self) -> bool {
        self.lights_ground() || matches!(self.colour, GroundColour::Slope | GroundColour::Aspect)
    }

    /// Whether heights are read, for normals or for themselves.
    pub(super) fn reads_heights(self) -> bool {
        self.needs_normals() || self.needs_height()
    }

    fn needs_height(self) -> bool {
        self.contours || self.colour == GroundColour::Ramp
    }

    pub(super) fn defs(self) -> impl Iterator<Item = &'static str> {
        let defs = [
            (self.is_on(), "LAND"),
            (self.needs_height(), "LAND_HEIGHT"),
            (self.needs_normals(), "LAND_NORMAL"),
            (self.colours_ground(), "LAND_COLOURS"),
            (self.needs_sampler(), "LAND_SAMPLER"),
            (self.colour == GroundColour::Ramp, "LAND_RAMP"),
            (self.colour == GroundColour::Slope, "LAND_SLOPE"),
            (self.colour == GroundColour::Aspect, "LAND_ASPECT"),
            (self.lights_ground(), "HILLSHADE"),
            (self.hillshade == Hillshade::Multidirectional, "HILLSHADE_MULTIDIRECTIONAL"),
            (self.contours, "LAND_CONTOURS"),
            (self.imagery, "IMAGERY"),
        ];
        defs.into_iter().filter_map(|(on, def)| on.then_some(def))
    }

    fn needs_sampler(self) -> bool {
        self.colours_ground() || self.imagery
    }

    /// The layout of what it binds.
    pub(super) fn bindings(self) -> Vec<wgpu::BindGroupLayoutEntry> {
        let mut entries = Vec::new();
        if self.is_on() {
            entries.push(uniform_entry::<LandUniform>(UNIFORM));
        }
        if self.colours_ground() {
            entries.push(texture_entry(COLOURS, true, false));
        }
        if self.needs_sampler() {
            entries.push(sampler_entry(SAMPLER));
        }
        if self.imagery {
            entries.push(texture_entry(IMAGERY, true, false));
        }
        entries
    }

    /// A few keys that use every def.
    #[cfg(test)]
    pub(super) fn some() -> Vec<Self> {
        let of = |colour, hillshade, contours, imagery| Self { colour, hillshade, contours, imagery };
        vec![
            of(GroundColour::Ramp, Hillshade::Off, false, false),
            of(GroundColour::Ramp, Hillshade::Sun, true, true),
            of(GroundColour::Slope, Hillshade::Off, true, false),
            of(GroundColour::Aspect, Hillshade::Multidirectional, false, true),
            of(GroundColour::Texture, Hillshade::Off, true, false),
            of(GroundColour::Texture, Hillshade::Multidirectional, false, false),
            of(GroundColour::Texture, Hillshade::Off, false, true),
        ]
    }
}

/// Mirror of `Land` in `land.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct LandUniform {
    pub(super) ramp_low: f32,
    pub(super) ramp_middle: f32,
    pub(super) ramp_high: f32,
    pub(super) height_unit: f32,
    pub(super) contours_per_share: f32,
    pub(super) contour_offset: f32,
    pub(super) contour_width: f32,
    pub(super) slope_factor: f32,
    pub(super) slope_max: f32,
    pub(super) hillshade_strength: f32,
    pub(super) imagery_opacity: f32,
    pub(super) imagery_density: f32,
    pub(super) imagery_u: Vec3,
    pub(super) padding: f32,
    pub(super) imagery_v: Vec3,
    pub(super) imagery_texels: f32,
}

impl LandUniform {
    fn new(land: &LandSettings, ground: &Ground, extent: DVec3, placed: Option<&Placed>) -> Self {
        let map = ground.terrain().base();
        let scale = land.scale(map);
        let [lowest, highest] = map.range();
        let relief = (highest - lowest).max(f64::MIN_POSITIVE);
        // Beyond this f32 knows no thousandth of the map's relief, and the ramp has one colour there anyway.
        let share = |height: f64| ((height - lowest) / relief).clamp(-1e6, 1e6) as f32;
        // Counted from a heavy line below the lowest ground: small numbers, of which f32 keeps the fractions.
        let heavy = (lowest / (5.0 * scale.interval)).floor() * 5.0;
        let drawn = extent.y;
        let slope_factor = if map.extent_metres().is_some() { map.true_height_scale() / drawn.max(1e-12) } else { 1.0 };
        let (u, v) = placed.map_or((DVec3::ZERO, DVec3::ZERO), |placed| (placed.u, placed.v));
        let texels = placed.map_or([1.0; 2], Placed::texels);
        let [columns, rows] = map.cells().map(f64::from);
        let density = |per_cell: f64, texels: f64, cells_per_unit: f64| per_cell.abs() * texels * cells_per_unit;
        let along = [columns / extent.x, rows / extent.z];
        let density = density(u.x, texels[0], along[0])
            .hypot(density(v.x, texels[1], along[0]))
            .max(density(u.y, texels[0], along[1]).hypot(density(v.y, texels[1], along[1])));
        without_subnormals(Self {
            ramp_low: share(scale.low),
            ramp_middle: share(scale.middle),
            ramp_high: share(scale.high),
            height_unit: ground.height_unit() as f32,
            contours_per_share: (relief / scale.interval).min(1e7) as f32,
            contour_offset: (lowest / scale.interval - heavy) as f32,
            contour_width: land.contour_width as f32,
            slope_factor: slope_factor.min(1e9) as f32,
            slope_max: land.slope_max as f32,
            hillshade_strength: land.hillshade_strength as f32,
            imagery_opacity: land.imagery_opacity as f32,
            imagery_density: density.min(1e9) as f32,
            imagery_u: u.as_vec3(),
            padding: 0.0,
            imagery_v: v.as_vec3(),
            imagery_texels: texels[0].min(texels[1]) as f32,
        })
    }
}

/// What the ramp's texture holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Colours {
    Height(Ramp),
    Slope,
    Aspect,
}

impl Colours {
    fn of(land: &LandSettings) -> Option<Self> {
        match land.colour {
            GroundColour::Texture => None,
            GroundColour::Ramp => Some(Self::Height(land.ramp)),
            GroundColour::Slope => Some(Self::Slope),
            GroundColour::Aspect => Some(Self::Aspect),
        }
    }

    fn texels(self) -> Vec<ramp::Colour> {
        match self {
            Self::Height(ramp) => ramp.texels(),
            Self::Slope => ramp::slope_texels(),
            Self::Aspect => ramp::aspect_texels(),
        }
    }
}

/// A picture of the ground where it belongs.
#[derive(Debug)]
struct Placed {
    file: PathBuf,
    texture: Texture,
    /// From cells along x and z, and 1, to the picture's u and v.
    u: DVec3,
    v: DVec3,
    /// What is doubtful about its place.
    doubts: Vec<String>,
}

impl Placed {
    fn texels(&self) -> [f64; 2] {
        [self.texture.texture.width(), self.texture.texture.height()].map(f64::from)
    }
}

/// The pass's own uniform, colours and picture. Each texture exists only while a frame needs it.
#[derive(Debug)]
pub(super) struct Land {
    buffer: wgpu::Buffer,
    sampler: wgpu::Sampler,
    colours: Option<(Colours, Texture)>,
    placed: Option<Placed>,
}

impl Land {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            buffer: uniform_buffer::<LandUniform>(gpu, "land"),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("land"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
            colours: None,
            placed: None,
        }
    }

    /// Forgets the picture: another map lies elsewhere.
    pub(super) fn forget_place(&mut self) {
        self.placed = None;
    }

    /// What the pipeline of `key` binds; `None` where a texture is missing.
    pub(super) fn entries(&self, key: LandKey) -> Option<Vec<(u32, wgpu::BindingResource<'_>)>> {
        let mut entries = Vec::new();
        if key.is_on() {
            entries.push((UNIFORM, self.buffer.as_entire_binding()));
        }
        if key.colours_ground() {
            entries.push((COLOURS, wgpu::BindingResource::TextureView(&self.colours.as_ref()?.1.view)));
        }
        if key.needs_sampler() {
            entries.push((SAMPLER, wgpu::BindingResource::Sampler(&self.sampler)));
        }
        if key.imagery {
            entries.push((IMAGERY, wgpu::BindingResource::TextureView(&self.placed.as_ref()?.texture.view)));
        }
        Some(entries)
    }

    /// Its textures, for the ledger.
    pub(super) fn list(&self, entries: &mut Vec<TextureEntry>) {
        entries.extend(self.colours.iter().map(|(_, texture)| TextureEntry::of("ramp", &texture.texture)));
        entries.extend(self.placed.iter().map(|placed| TextureEntry::of("imagery", &placed.texture.texture)));
    }

    /// Whether the picture of `file` is placed.
    pub(super) fn shows(&self, file: &Path) -> bool {
        self.placed.as_ref().is_some_and(|placed| placed.file == *file)
    }

    /// Brings the textures up to date with what `key` needs; returns the bytes uploaded.
    fn prepare(
        &mut self,
        gpu: &Gpu,
        key: LandKey,
        land: &LandSettings,
        map: &HeightField,
        images: &mut Images,
    ) -> Result<u64, RenderError> {
        let mut uploaded = 0;
        let wanted = Colours::of(land).filter(|_| key.colours_ground());
        if self.colours.as_ref().map(|(colours, _)| *colours) != wanted {
            self.colours = wanted.map(|colours| {
                let rgba = colours.texels().into_iter().flat_map(|[r, g, b]| [r, g, b, 255]).collect();
                let image = Image { width: 2 * ramp::HALF as u32, height: 1, rgba };
                let (texture, bytes) = upload(gpu, "ramp", &image, &[]);
                uploaded += bytes;
                (colours, texture)
            });
        }
        match land.imagery.as_ref().filter(|_| key.imagery) {
            None => self.placed = None,
            Some(file) if self.shows(file) => {}
            Some(file) => {
                let decoded = images.take(file, Purpose::Imagery, gpu.capabilities.max_texture)?;
                let failed = |reason| RenderError::Image { path: file.clone(), reason };
                let (placed, bytes) = place(gpu, file, &decoded, map).map_err(failed)?;
                uploaded += bytes;
                self.placed = Some(placed);
            }
        }
        Ok(uploaded)
    }
}

impl Renderer {
    /// What is doubtful about the place of the picture that lies on the ground: each a part of a sentence about it.
    pub fn imagery_doubts(&self) -> &[String] {
        self.land.placed.as_ref().map_or(&[], |placed| &placed.doubts)
    }

    /// Brings what the land's shader reads up to date with `scene`.
    pub(super) fn prepare_land(&mut self, key: LandKey, land: &LandSettings, extent: DVec3) -> Result<(), RenderError> {
        let Some(ground) = &self.ground else { return Ok(()) };
        self.uploaded += self.land.prepare(&self.gpu, key, land, ground.terrain().base(), &mut self.images)?;
        if key.is_on() {
            let uniform = LandUniform::new(land, ground, extent, self.land.placed.as_ref());
            self.gpu.queue.write_buffer(&self.land.buffer, 0, bytemuck::bytes_of(&uniform));
        }
        Ok(())
    }
}

/// Puts the picture of `file` where it belongs on the map.
fn place(gpu: &Gpu, file: &Path, picture: &Decoded, map: &HeightField) -> Result<(Placed, u64), String> {
    let Decoded { image, levels } = picture;
    let mut doubts = Vec::new();
    let [u, v] = transform(file, image, map, &mut doubts)?;
    for doubt in &doubts {
        log::warn!("{}: {doubt}", file.display());
    }
    let (texture, bytes) = upload(gpu, "imagery", image, levels);
    Ok((Placed { file: file.to_owned(), texture, u, v, doubts }, bytes))
}

/// From cells along x and z, and 1, to the picture's u and to its v. What is doubtful about its place is told.
fn transform(file: &Path, image: &Image, map: &HeightField, doubts: &mut Vec<String>) -> Result<[DVec3; 2], String> {
    let place = imagery::place(file, [image.width, image.height], doubts)?;
    let Some(ground) = map.georeference() else {
        return Err(
            "it says where it lies, but the map does not; give the map's sidecar crs, origin and step, or drape the \
                    picture as the diffuse texture, which covers the whole map"
                .to_owned(),
        );
    };
    if let Some(systems) = place.differs_from(ground) {
        return Err(format!(
            "its reference system is not the map's ({systems}); bring it into the map's, with gdalwarp -t_srs {} for instance",
            ground.crs.as_deref().unwrap_or("SYSTEM")
        ));
    }
    // A pixel's middle is half a pixel from the picture's edge.
    let uv = |column: f64, row: f64| {
        let [x, y] = place.column_row(ground.at(column, row));
        [(x + 0.5) / f64::from(image.width), (y + 0.5) / f64::from(image.height)]
    };
    let (origin, east, south) = (uv(0.0, 0.0), uv(1.0, 0.0), uv(0.0, 1.0));
    let [u, v] = [0, 1].map(|axis| DVec3::new(east[axis] - origin[axis], south[axis] - origin[axis], origin[axis]));
    let [columns, rows] = map.cells().map(f64::from);
    let corners = [(0.0, 0.0), (columns, 0.0), (0.0, rows), (columns, rows)];
    let beside = |axis: DVec3| {
        let at = corners.map(|(x, z)| axis.dot(DVec3::new(x, z, 1.0)));
        at.iter().all(|&at| at < 0.0) || at.iter().all(|&at| at > 1.0)
    };
    if !(u.is_finite() && v.is_finite()) || beside(u) || beside(v) {
        return Err("it lies beside the map and would not show; check which of the two is placed wrongly".to_owned());
    }
    doubts.extend(part_covered([u, v], [columns, rows]));
    Ok([u, v])
}

/// What to say of a picture that covers a part of the map only.
fn part_covered([u, v]: [DVec3; 2], [columns, rows]: [f64; 2]) -> Option<String> {
    const PLACES: u32 = 64;
    let share = |index: u32| (f64::from(index) + 0.5) / f64::from(PLACES);
    let inside = |axis: DVec3, at: DVec3| (0.0..=1.0).contains(&axis.dot(at));
    let places = (0..PLACES).flat_map(|row| (0..PLACES).map(move |column| (column, row)));
    let at = |(column, row): (u32, u32)| DVec3::new(share(column) * columns, share(row) * rows, 1.0);
    let covered = places.filter(|&place| inside(u, at(place)) && inside(v, at(place))).count();
    let percent = 100.0 * covered as f64 / f64::from(PLACES * PLACES);
    if percent > 99.5 {
        return None;
    }
    let how_much = if percent < 1.0 { "less than 1 %".to_owned() } else { format!("about {percent:.0} %") };
    Some(format!("it covers {how_much} of the map; the ground beside it keeps its colour"))
}

/// A texture of an image and its smaller copies, and its bytes.
fn upload(gpu: &Gpu, label: &'static str, base: &Image, levels: &[Image]) -> (Texture, u64) {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: base.width, height: base.height, depth_or_array_layers: 1 },
        mip_level_count: 1 + levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: mips::ROOT_FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let images = std::iter::once(base).chain(levels).zip(0..);
    let all = |image: &Image| SampleRect { x: 0, y: 0, width: image.width, height: image.height };
    let bytes = images.map(|(image, mip)| mips::upload(gpu, &texture, mip, 0, image, all(image))).sum();
    (Texture { texture, view }, bytes)
}
