//! Pipelines that are built away from the frame, on another thread: no frame waits for a compiler.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use crate::gpu::{DEPTH_CLEAR, DEPTH_FORMAT, Gpu, ShaderError, ShaderSources};

use super::frame::FrameBindings;
use super::materials;
use super::pipelines::{Built, PassDescription, PipelineKey, build};

/// How often it is looked whether a driver has done its part, and for how long.
const DRIVER_POLL: Duration = Duration::from_millis(4);
const DRIVER_PATIENCE: Duration = Duration::from_secs(60);

/// Bytes of a uniform buffer whose size a layout leaves open.
const SOME_UNIFORM: u64 = 256;

/// Pipelines that a frame needs and that are not there: all that it takes to build them.
#[derive(Clone, Debug)]
pub(crate) struct Compilation {
    gpu: Arc<Gpu>,
    sources: Arc<ShaderSources>,
    frame: FrameBindings,
    keys: Vec<PipelineKey>,
}

/// The same pipelines of the same sources, on the same device.
impl PartialEq for Compilation {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.gpu, &other.gpu) && Arc::ptr_eq(&self.sources, &other.sources) && self.keys == other.keys
    }
}

impl Compilation {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        sources: &Arc<ShaderSources>,
        frame: &FrameBindings,
        keys: Vec<PipelineKey>,
    ) -> Self {
        Self { gpu: Arc::clone(gpu), sources: Arc::clone(sources), frame: frame.clone(), keys }
    }

    /// Composes the shaders and builds the pipelines, one after the other while `go_on` says so; what is built by then
    /// comes back.
    ///
    /// # Errors
    /// The first shader that does not compile.
    pub(crate) fn build(&self, go_on: &dyn Fn() -> bool) -> Result<Compiled, ShaderError> {
        let wanted = self.keys.iter().take_while(|_| go_on());
        let built = wanted.map(|&key| {
            // Made here, so that the frame that first shows them does not.
            if matches!(key, PipelineKey::Terrain(key) if key.materials.on) {
                materials::make_ready();
            }
            let built = build(&self.gpu, &self.sources, &self.frame.layout, key.describe())?;
            Ok((key, Arc::new(built)))
        });
        Ok(Compiled { built: built.collect::<Result<_, ShaderError>>()?, compilation: self.clone() })
    }
}

/// Pipelines for [`Renderer::set_compiled`](super::Renderer::set_compiled).
#[derive(Debug)]
pub(crate) struct Compiled {
    built: Vec<(PipelineKey, Arc<Built>)>,
    compilation: Compilation,
}

impl Compiled {
    /// The pipelines, if they are made of `sources`.
    pub(super) fn made_of(self, sources: &Arc<ShaderSources>) -> Option<Vec<(PipelineKey, Arc<Built>)>> {
        Arc::ptr_eq(&self.compilation.sources, sources).then_some(self.built)
    }

    /// Draws nothing with each pipeline, while `go_on` says so: some drivers compile when a pipeline is first drawn with, and
    /// a frame would wait for them. Waits for the driver, and lets others submit meanwhile.
    ///
    /// # Errors
    /// What the device has to say against it. The pipelines are no worse for that.
    pub(crate) fn warm_up(&self, go_on: &dyn Fn() -> bool) -> Result<(), String> {
        let Compilation { gpu, frame, .. } = &self.compilation;
        for (key, built) in &self.built {
            if !go_on() {
                break;
            }
            let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
            draw_nothing(gpu, frame, &key.describe(), built);
            if let Some(error) = pollster::block_on(scope.pop()) {
                return Err(format!("{}: {error}", built.name));
            }
            wait(gpu, go_on);
        }
        Ok(())
    }
}

/// Waits until all that was submitted so far is done. Does not wait inside the device: other threads could submit nothing
/// until then.
fn wait(gpu: &Gpu, go_on: &dyn Fn() -> bool) {
    let (sender, done) = channel();
    gpu.queue.on_submitted_work_done(move || {
        // Fails only when nobody waits any more.
        let _ = sender.send(());
    });
    let start = Instant::now();
    while go_on() && start.elapsed() < DRIVER_PATIENCE {
        // A failed poll shows as work that is never done; the loss itself is reported by the device.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        if done.recv_timeout(DRIVER_POLL) != Err(RecvTimeoutError::Timeout) {
            return;
        }
    }
}

/// A draw of no pixel into a target of one, with bindings that hold nothing.
fn draw_nothing(gpu: &Gpu, frame: &FrameBindings, pass: &PassDescription, built: &Built) {
    let group = empty_group(gpu, pass, built);
    let colour = texture(gpu, pass.format, 1, wgpu::TextureUsages::RENDER_ATTACHMENT);
    let depth = pass.depth.map(|_| texture(gpu, DEPTH_FORMAT, 1, wgpu::TextureUsages::RENDER_ATTACHMENT));
    let [colour, depth] = [Some(colour), depth]
        .map(|texture| texture.map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default())));
    let attachment = colour.as_ref().map(|view| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
    });
    let mut encoder =
        gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("first use of a pipeline") });
    {
        let mut draws = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("first use of a pipeline"),
            color_attachments: &[attachment],
            depth_stencil_attachment: depth.as_ref().map(|view| wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(DEPTH_CLEAR),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        draws.set_pipeline(&built.pipeline);
        if pass.frame {
            draws.set_bind_group(0, &frame.group, &[]);
        }
        draws.set_bind_group(u32::from(pass.frame), &group, &[]);
        draws.set_scissor_rect(0, 0, 0, 0);
        draws.draw(0..3, 0..1);
    }
    gpu.queue.submit([encoder.finish()]);
}

/// The pass's own bind group over resources made for it.
fn empty_group(gpu: &Gpu, pass: &PassDescription, built: &Built) -> wgpu::BindGroup {
    enum Resource {
        Buffer(wgpu::Buffer),
        View(wgpu::TextureView),
        Sampler(wgpu::Sampler),
    }
    let resource = |ty: wgpu::BindingType| match ty {
        wgpu::BindingType::Texture { sample_type, view_dimension, .. } => {
            let filtered = sample_type == wgpu::TextureSampleType::Float { filterable: true };
            let format = if filtered { wgpu::TextureFormat::Rgba8Unorm } else { wgpu::TextureFormat::R32Float };
            let layers = if view_dimension == wgpu::TextureViewDimension::D2Array { 6 } else { 1 };
            let texture = texture(gpu, format, layers, wgpu::TextureUsages::TEXTURE_BINDING);
            let dimension = Some(view_dimension);
            Resource::View(texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() }))
        }
        wgpu::BindingType::Sampler(kind) => {
            let filter = match kind {
                wgpu::SamplerBindingType::Filtering => wgpu::FilterMode::Linear,
                _ => wgpu::FilterMode::Nearest,
            };
            Resource::Sampler(gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: filter,
                min_filter: filter,
                ..Default::default()
            }))
        }
        wgpu::BindingType::Buffer { min_binding_size, .. } => {
            Resource::Buffer(gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: min_binding_size.map_or(SOME_UNIFORM, std::num::NonZero::get),
                usage: wgpu::BufferUsages::UNIFORM,
                mapped_at_creation: false,
            }))
        }
        // No pass has any.
        _ => Resource::Sampler(gpu.device.create_sampler(&wgpu::SamplerDescriptor::default())),
    };
    let resources: Vec<_> = pass.bindings.iter().map(|entry| (entry.binding, resource(entry.ty))).collect();
    let entries: Vec<_> = resources
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: match resource {
                Resource::Buffer(buffer) => buffer.as_entire_binding(),
                Resource::View(view) => wgpu::BindingResource::TextureView(view),
                Resource::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
            },
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("first use of a pipeline"),
        layout: &built.layout,
        entries: &entries,
    })
}

/// A texture of one texel in each layer.
fn texture(gpu: &Gpu, format: wgpu::TextureFormat, layers: u32, usage: wgpu::TextureUsages) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("first use of a pipeline"),
        size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Target;
    use crate::heightfield::generate::{Kind, generate};
    use crate::heightfield::{HeightField, HoleMask};
    use crate::render::Renderer;
    use crate::scene::{CraterMode, DebugView, Scene, Technique};

    /// Scenes of which each needs other pipelines.
    fn scenes() -> Vec<Scene> {
        let changes: &[&dyn Fn(&mut Scene)] = &[
            &|_| {},
            &|scene| scene.march.technique = Technique::RelaxedCone,
            &|scene| {
                scene.compare.enabled = true;
                scene.compare.technique = Technique::Secant;
                scene.occluder.enabled = true;
            },
            &|scene| {
                scene.march.technique = Technique::Linear;
                scene.debug.view = DebugView::Error;
            },
            &|scene| {
                scene.craters.mode = CraterMode::Layered;
                scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
                scene.debug.wireframe = true;
            },
            &|scene| scene.debug.view = DebugView::Position,
        ];
        let scene = |change: &&dyn Fn(&mut Scene)| {
            let mut scene = Scene::default();
            change(&mut scene);
            scene
        };
        changes.iter().map(scene).collect()
    }

    fn renderer(gpu: &Arc<Gpu>) -> Renderer {
        let mut renderer = Renderer::new(Arc::clone(gpu)).unwrap();
        renderer.set_terrain(Arc::new(generate(Kind::Ridged, 33, 3))).unwrap();
        renderer
    }

    /// What a frame builds by itself it waits for: nothing may be left to it.
    #[test]
    fn a_frame_builds_nothing_that_was_compiled_before_it() {
        let gpu = Gpu::headless().unwrap();
        let mut renderer = renderer(&gpu);
        let target = Target::new(&gpu, [40, 30]);
        for scene in scenes() {
            let missing = renderer.missing_pipelines(&scene, target.size(), false).expect("not built yet");
            let compiled = std::thread::spawn(move || {
                let compiled = missing.build(&|| true).unwrap();
                compiled.warm_up(&|| true).unwrap();
                compiled
            });
            renderer.set_compiled(compiled.join().unwrap());
            assert!(renderer.missing_pipelines(&scene, target.size(), false).is_none());
            let before = renderer.pipelines.names();
            renderer.draw(&scene, &target).unwrap();
            assert_eq!(renderer.pipelines.names(), before, "{scene:?}");
        }
        // A map with holes has pipelines of its own.
        let mut holes = HoleMask::new(5, 5);
        holes.insert(12);
        let map = HeightField::from_raw_with_holes(5, 5, &[0.0f64; 25], Some(holes)).unwrap();
        renderer.set_terrain(Arc::new(map)).unwrap();
        let missing = renderer.missing_pipelines(&Scene::default(), target.size(), false).expect("others than without");
        renderer.set_compiled(missing.build(&|| true).unwrap());
        let before = renderer.pipelines.names();
        renderer.draw(&Scene::default(), &target).unwrap();
        assert_eq!(renderer.pipelines.names(), before);
        let mut probed = Scene::default();
        probed.march.technique = Technique::Secant;
        let missing = renderer.missing_pipelines(&probed, [20, 15], true).expect("a probe has its own");
        renderer.set_compiled(missing.build(&|| true).unwrap());
        let before = renderer.pipelines.names();
        renderer.probe(&probed, [20, 15]).unwrap();
        assert_eq!(renderer.pipelines.names(), before);
    }

    /// A shader that is saved while others are compiled wins over them.
    #[test]
    fn pipelines_of_other_shaders_or_another_device_are_not_kept() {
        let gpu = Gpu::noop();
        let mut renderer = renderer(&gpu);
        let missing = renderer.missing_pipelines(&Scene::default(), [8, 8], false).unwrap();
        let early = missing.build(&|| true).unwrap();
        let other = self::renderer(&gpu).missing_pipelines(&Scene::default(), [8, 8], false).unwrap();
        assert!(other != missing);
        renderer.set_compiled(other.build(&|| true).unwrap());
        assert!(renderer.pipelines.names().is_empty());
        renderer.reload_shaders().unwrap();
        renderer.set_compiled(early);
        assert!(renderer.pipelines.names().is_empty());
        let again = renderer.missing_pipelines(&Scene::default(), [8, 8], false).unwrap();
        assert!(again != missing, "they are wanted anew");
        renderer.set_compiled(again.build(&|| false).unwrap());
        assert!(renderer.missing_pipelines(&Scene::default(), [8, 8], false) == Some(again), "given up at once");
    }
}
