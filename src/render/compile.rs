//! Pipelines that are built away from the frame, on another thread: no frame waits for a compiler.

use std::sync::Arc;

use crate::gpu::{Gpu, ShaderError, ShaderSources};

use super::frame::FrameBindings;
use super::materials;
use super::pipelines::{Built, PipelineKey, build};

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
            let ground = match key {
                PipelineKey::Terrain(key) => Some(key),
                PipelineKey::Water(key) => Some(key.ground),
                _ => None,
            };
            if ground.is_some_and(|key| key.materials.on) {
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
            let compiled = std::thread::spawn(move || missing.build(&|| true).unwrap());
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
