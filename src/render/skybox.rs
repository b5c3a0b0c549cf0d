//! The skybox: the same cube around the eye, widened and flattened, with a cube map. Its shader is `skybox.wgsl`.

use std::path::PathBuf;

use crate::gpu::{DEPTH_CLEAR, Gpu};
use crate::scene::Scene;

use super::RenderError;
use super::air::AirKey;
use super::atmosphere::Atmosphere;
use super::frame::{sampler_entry, texture_entry};
use super::images::{Images, Purpose};
use super::ledger::TextureEntry;
use super::mips::{self, Image};
use super::pipelines::{Built, PassDescription};
use super::sky_map::{self, AirLight, Sky};
use super::terrain::bind;

/// With fog before it or without.
pub(super) fn describe(fog: bool) -> PassDescription {
    // Equal to the clear value: what anything covers is not shaded.
    const { assert!(DEPTH_CLEAR == 0.0, "skybox.wgsl places the box at depth 0") };
    let air = sky_key(fog);
    let plain = PassDescription {
        bindings: vec![texture_entry(0, true, true), sampler_entry(1)],
        cull: Some(wgpu::Face::Front),
        depth: Some((wgpu::CompareFunction::Equal, false)),
        ..PassDescription::scene("skybox", "skybox.wgsl", false)
    };
    if !fog {
        return plain;
    }
    PassDescription {
        name: "skybox [FOG]".into(),
        modules: plain.modules.into_iter().chain(air.modules()).collect(),
        defs: air.defs().collect(),
        bindings: plain.bindings.into_iter().chain(air.bindings()).collect(),
        ..plain
    }
}

/// What of the air lies before a sky.
fn sky_key(fog: bool) -> AirKey {
    AirKey { fog, ..AirKey::default() }
}

/// What a cube map was made from.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    Procedural(Sky),
    Files([PathBuf; 6]),
}

impl Source {
    fn of(scene: &Scene) -> Self {
        match &scene.skybox.faces {
            Some(files) => Self::Files(files.clone()),
            None => Self::Procedural(Sky {
                sun: sky_map::sun_of(&scene.lighting),
                flattening: scene.skybox.flattening,
                turbidity: scene.skybox.physical(),
            }),
        }
    }
}

/// The cube map on the GPU.
#[derive(Debug)]
pub(super) struct Skybox {
    source: Source,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    light: AirLight,
}

impl Skybox {
    /// Makes or reads the map; also returns the bytes uploaded.
    pub(super) fn new(gpu: &Gpu, scene: &Scene, images: &mut Images) -> Result<(Self, u64), RenderError> {
        let source = Source::of(scene);
        let faces = match &source {
            Source::Procedural(sky) => sky_map::faces(sky),
            Source::Files(files) => read_faces(files, gpu.capabilities.max_texture, images)?,
        };
        let light = match &source {
            Source::Procedural(sky) => AirLight::of(sky),
            Source::Files(_) => AirLight::of_images(&faces),
        };
        let side = faces.first().map_or(1, |face| face.width);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("sky"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 6 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: mips::ROOT_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let uploaded =
            faces.iter().zip(0..).map(|(face, layer)| mips::upload(gpu, &texture, 0, layer, face, face.all())).sum();
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("sky"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Ok((Self { source, texture, view, sampler, light }, uploaded))
    }

    /// Whether this is still the map that `scene` asks for.
    pub(super) fn matches(&self, scene: &Scene) -> bool {
        self.source == Source::of(scene)
    }

    /// The bind group of `built`, with fog before the sky or without.
    pub(super) fn group(&self, gpu: &Gpu, built: &Built, atmosphere: &Atmosphere, fog: bool) -> wgpu::BindGroup {
        let mut entries: Vec<_> = (0..).zip(self.entries()).collect();
        entries.extend(atmosphere.entries(sky_key(fog)).unwrap_or_default());
        bind(gpu, built, entries)
    }

    /// The map and its sampler, for any pass that looks at the sky.
    pub(super) fn entries(&self) -> [wgpu::BindingResource<'_>; 2] {
        [wgpu::BindingResource::TextureView(&self.view), wgpu::BindingResource::Sampler(&self.sampler)]
    }

    /// What it lights the air with.
    pub(super) fn light(&self) -> AirLight {
        self.light.clone()
    }

    pub(super) fn entry(&self) -> TextureEntry {
        TextureEntry::of("sky", &self.texture)
    }
}

fn read_faces(files: &[PathBuf; 6], largest: u32, images: &mut Images) -> Result<Vec<Image>, RenderError> {
    let mut faces: Vec<Image> = Vec::new();
    for path in files {
        let fail = |reason| RenderError::Image { path: path.clone(), reason };
        let face = images.take(path, Purpose::Face, largest)?.image;
        let side = faces.first().map_or(face.width, |first| first.width);
        if face.width != side || face.height != side {
            return Err(fail(format!(
                "it has {}×{} pixels, but the six faces of a skybox must be squares of one size (here {side}×{side})",
                face.width, face.height
            )));
        }
        faces.push(face);
    }
    Ok(faces)
}
