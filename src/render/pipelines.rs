//! Pipelines by key: described by the passes, built on first use, kept, and rebuilt together when a shader is saved.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Arc;

use crate::gpu::{COLOR_FORMAT, DEPTH_COMPARE, DEPTH_FORMAT, Gpu, PROBE_FORMAT, ShaderError, ShaderSources};

use super::air::AirKey;
use super::beam::Tiles;
use super::frame::FrameLayouts;
use super::light_map::LightMapKey;
use super::occluder::OccluderKey;
use super::terrain::TerrainKey;
use super::water::WaterKey;
use super::{
    air, beam, clouds, flare, heat_map, light, light_map, occluder, present, skybox, terrain, water, wireframe,
};

/// Which pipeline: everything that decides what is compiled into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PipelineKey {
    /// With whether it counts texel reads.
    Beam(Tiles, bool),
    Terrain(TerrainKey),
    Water(WaterKey),
    Wireframe,
    Occluder(OccluderKey),
    LightMap(LightMapKey),
    /// With whether fog lies before it.
    Skybox(bool),
    /// The clouds over the picture, with the air before them.
    Clouds(AirKey),
    CloudShadow,
    Flare,
    Present(wgpu::TextureFormat),
}

impl PipelineKey {
    pub(super) fn describe(self) -> PassDescription {
        match self {
            Self::Beam(tiles, counts) => beam::describe(tiles, counts),
            Self::Terrain(key) => terrain::describe(key),
            Self::Water(key) => water::describe(key),
            Self::Wireframe => wireframe::describe(),
            Self::Occluder(key) => occluder::describe(key),
            Self::LightMap(key) => light_map::describe(key),
            Self::Skybox(fog) => skybox::describe(fog),
            Self::Clouds(air) => clouds::describe(air),
            Self::CloudShadow => clouds::describe_shadow(),
            Self::Flare => flare::describe(),
            Self::Present(format) => present::describe(format),
        }
    }
}

/// All that a pass says of its pipeline.
#[derive(Clone, Debug)]
pub(super) struct PassDescription {
    /// Name in the ledger.
    pub(super) name: String,
    /// Shader file with the entry points `vs_main` and `fs_main`.
    pub(super) file: &'static str,
    /// Modules it may import, in the order in which they need each other.
    pub(super) modules: Vec<&'static str>,
    /// Shader defs.
    pub(super) defs: Vec<&'static str>,
    /// The pass's own bind group: group 1 after the frame's, or group 0 without it.
    pub(super) bindings: Vec<wgpu::BindGroupLayoutEntry>,
    /// Whether bind group 0 is the frame's.
    pub(super) frame: bool,
    /// Whether its fragments cast rays: their constants come the way that suits the adapter (`varyings.wgsl`).
    pub(super) casts_rays: bool,
    pub(super) topology: wgpu::PrimitiveTopology,
    /// Faces left out.
    pub(super) cull: Option<wgpu::Face>,
    /// Depth test, and whether depth is written; absent without a depth buffer.
    pub(super) depth: Option<(wgpu::CompareFunction, bool)>,
    /// How it is mixed with what is there; absent: it takes its place.
    pub(super) blend: Option<wgpu::BlendState>,
    pub(super) format: wgpu::TextureFormat,
    /// The channels it writes.
    pub(super) writes: wgpu::ColorWrites,
}

impl PassDescription {
    /// A pass over the scene's colour and depth (or a probe's) that draws the cube's faces.
    pub(super) fn scene(name: &str, file: &'static str, probe: bool) -> Self {
        Self {
            name: name.to_owned(),
            file,
            modules: vec!["frame.wgsl"],
            defs: Vec::new(),
            bindings: Vec::new(),
            frame: true,
            casts_rays: false,
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: None,
            depth: Some((DEPTH_COMPARE, true)),
            blend: None,
            format: if probe { PROBE_FORMAT } else { COLOR_FORMAT },
            writes: wgpu::ColorWrites::ALL,
        }
    }
}

/// A pipeline with the layout of its pass's bind group.
#[derive(Debug)]
pub(super) struct Built {
    pub(super) name: String,
    pub(super) pipeline: wgpu::RenderPipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) defs: Vec<&'static str>,
    /// Its vertices hand the constants on.
    pub(super) flat: bool,
}

/// The embedded shaders, with the modules that are made from Rust values.
pub(super) fn sources() -> ShaderSources {
    ShaderSources::embedded(vec![
        ("beam", beam::wgsl()),
        ("heat_map", heat_map::wgsl()),
        ("sun", light::wgsl()),
        ("air_constants", air::wgsl()),
        ("cloud_constants", clouds::wgsl()),
        ("flare_constants", flare::wgsl()),
    ])
}

/// All pipelines alive.
#[derive(Debug)]
pub(super) struct Pipelines {
    /// Shared with what is compiled elsewhere: what was made of others is of no use.
    sources: Arc<ShaderSources>,
    built: HashMap<PipelineKey, Arc<Built>>,
}

impl Pipelines {
    pub(super) fn new() -> Self {
        Self { sources: Arc::new(sources()), built: HashMap::new() }
    }

    /// The pipeline of `key`, built if it is not there yet.
    pub(super) fn get(&mut self, gpu: &Gpu, frame: &FrameLayouts, key: PipelineKey) -> Result<Arc<Built>, ShaderError> {
        if let Some(built) = self.built.get(&key) {
            return Ok(Arc::clone(built));
        }
        let built = Arc::new(build(gpu, &self.sources, frame, key.describe())?);
        self.built.insert(key, Arc::clone(&built));
        Ok(built)
    }

    /// Reads the shader folder again and rebuilds every pipeline; on an error all of the old ones stay.
    pub(super) fn reload(&mut self, gpu: &Gpu, frame: &FrameLayouts) -> Result<(), ShaderError> {
        let Some(folder) = ShaderSources::folder() else {
            return Err(ShaderError {
                file: "shaders".into(),
                message: "the folder this program was built from is gone".into(),
            });
        };
        let sources = self.sources.reload(&folder)?;
        let rebuilt = self
            .built
            .keys()
            .map(|&key| Ok((key, Arc::new(build(gpu, &sources, frame, key.describe())?))))
            .collect::<Result<_, ShaderError>>()?;
        (self.sources, self.built) = (Arc::new(sources), rebuilt);
        Ok(())
    }

    /// Whether the pipeline of `key` is there.
    pub(super) fn has(&self, key: PipelineKey) -> bool {
        self.built.contains_key(&key)
    }

    /// What pipelines are built of.
    pub(super) fn sources(&self) -> &Arc<ShaderSources> {
        &self.sources
    }

    /// Takes pipelines that were built elsewhere, of the sources in use now.
    pub(super) fn add(&mut self, built: Vec<(PipelineKey, Arc<Built>)>) {
        for (key, built) in built {
            self.built.entry(key).or_insert(built);
        }
    }

    /// Names of all pipelines alive, sorted.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = self.built.values().map(|built| built.name.clone()).collect();
        names.sort();
        names
    }
}

/// Composes and builds a pipeline.
pub(super) fn build(
    gpu: &Gpu,
    sources: &ShaderSources,
    frame: &FrameLayouts,
    mut pass: PassDescription,
) -> Result<Built, ShaderError> {
    let flat = pass.casts_rays && gpu.capabilities.software;
    if flat {
        pass.defs.push("FLAT_CONSTANTS");
        // Fragments read no uniform of the frame and the terrain then. That they cannot is more than thrift: lavapipe up to 22.3 writes beyond
        // an array when it looks for uniforms to compile in (`uni_offsets` of its lvp_inline_uniforms.c has room for four
        // buffers a stage, the push constants among them), and crashes.
        if let Some(terrain) = pass.bindings.iter_mut().find(|entry| entry.binding == 0) {
            terrain.visibility = wgpu::ShaderStages::VERTEX;
        }
    }
    let module = sources.compose(pass.file, &pass.modules, &pass.defs)?;
    #[cfg(test)]
    {
        super::loops_tests::examine_or_panic(&pass.name, &module);
        super::needs_tests::examine_or_panic(&pass, &module);
    }
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let shader = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(&pass.name),
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(&pass.name),
        entries: &pass.bindings,
    });
    let groups = if pass.frame {
        vec![Some(if flat { &frame.flat } else { &frame.all }), Some(&layout)]
    } else {
        vec![Some(&layout)]
    };
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&pass.name),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(&pass.name),
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("vs_main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology: pass.topology, cull_mode: pass.cull, ..Default::default() },
        depth_stencil: pass.depth.map(|(compare, write)| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(write),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: Some("fs_main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: pass.format,
                blend: pass.blend,
                write_mask: pass.writes,
            })],
        }),
        multiview_mask: None,
        cache: None,
    });
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(ShaderError { file: pass.file.to_owned(), message: error.to_string() });
    }
    Ok(Built { name: pass.name, pipeline, layout, defs: pass.defs, flat })
}
