//! Pipelines that are built, images that are read and patterns that are found away from the frame, on another thread: no frame
//! waits for a compiler or a decoder.

use std::sync::Arc;

use crate::gpu::{Gpu, ShaderError, ShaderSources};
use crate::heightfield::HeightField;

use super::cloud_pattern::{self, MapPattern};
use super::frame::FrameBindings;
use super::images::{Decoded, ImageFile};
use super::materials;
use super::pipelines::{Built, PipelineKey, build};

/// Pipelines and images that a frame needs and that are not there: all that it takes to make them.
#[derive(Clone, Debug)]
pub(crate) struct Compilation {
    gpu: Arc<Gpu>,
    sources: Arc<ShaderSources>,
    frame: FrameBindings,
    keys: Vec<PipelineKey>,
    images: Vec<ImageFile>,
    /// The map that clouds are to be cut from.
    pattern: Option<Arc<HeightField>>,
}

/// The same pipelines of the same sources and the same images, on the same device.
impl PartialEq for Compilation {
    fn eq(&self, other: &Self) -> bool {
        let same_made_of = Arc::ptr_eq(&self.gpu, &other.gpu) && Arc::ptr_eq(&self.sources, &other.sources);
        let map = |own: &Self| own.pattern.as_ref().map(Arc::as_ptr);
        same_made_of && self.keys == other.keys && self.images == other.images && map(self) == map(other)
    }
}

impl Compilation {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        sources: &Arc<ShaderSources>,
        frame: &FrameBindings,
        keys: Vec<PipelineKey>,
        images: Vec<ImageFile>,
        pattern: Option<Arc<HeightField>>,
    ) -> Self {
        Self { gpu: Arc::clone(gpu), sources: Arc::clone(sources), frame: frame.clone(), keys, images, pattern }
    }

    /// Whether it only reads images and maps: nothing is compiled.
    pub(crate) fn is_only_images(&self) -> bool {
        self.keys.is_empty()
    }

    /// Composes the shaders and builds the pipelines, then reads the images, one after the other while `go_on` says so; what
    /// is made by then comes back. An image that cannot be read is the error of the frame that needs it.
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
            if matches!(key, PipelineKey::Clouds(_) | PipelineKey::CloudShadow) {
                cloud_pattern::of_noise();
            }
            let built = build(&self.gpu, &self.sources, &self.frame.layout, key.describe())?;
            Ok((key, Arc::new(built)))
        });
        let built = built.collect::<Result<_, ShaderError>>()?;
        let largest = self.gpu.capabilities.max_texture;
        let images = self.images.iter().take_while(|_| go_on()).map(|file| (file.clone(), file.read(largest)));
        let images = images.collect();
        let map = self.pattern.as_ref().filter(|_| go_on());
        Ok(Compiled { built, images, pattern: map.map(MapPattern::new), compilation: self.clone() })
    }
}

/// Pipelines and images for [`Renderer::set_compiled`](super::Renderer::set_compiled).
#[derive(Debug)]
pub(crate) struct Compiled {
    built: Vec<(PipelineKey, Arc<Built>)>,
    images: Vec<(ImageFile, Result<Decoded, String>)>,
    pattern: Option<MapPattern>,
    compilation: Compilation,
}

impl Compiled {
    /// The images, or what is wrong with them.
    pub(super) fn take_images(&mut self) -> Vec<(ImageFile, Result<Decoded, String>)> {
        std::mem::take(&mut self.images)
    }

    /// The pattern for clouds.
    pub(super) fn take_pattern(&mut self) -> Option<MapPattern> {
        self.pattern.take()
    }

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
    use crate::render::RenderError;
    use crate::render::Renderer;
    use crate::scene::light::{Shadows, SkyModel};
    use crate::scene::{CloudSource, ColourSource, CraterMode, DebugView, GroundColour, Hillshade, Scene, Technique};

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
            &|scene| {
                (scene.lighting.shadows, scene.skybox.model) = (Shadows::Soft, SkyModel::Physical);
                scene.occluder.enabled = true;
            },
            &|scene| {
                scene.lighting.shadows = Shadows::Hard;
                (scene.lighting.baked, scene.lighting.occlusion) = (true, true);
            },
            &|scene| scene.diffuse.source = ColourSource::Materials,
            &|scene| scene.march.technique = Technique::Fractal,
            &|scene| scene.water.enabled = true,
            &|scene| {
                (scene.air.perspective, scene.air.fog, scene.flare.enabled) = (true, true, true);
                (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
                (scene.water.enabled, scene.occluder.enabled) = (true, true);
            },
            &|scene| {
                (scene.clouds.enabled, scene.clouds.source) = (true, CloudSource::Map);
                scene.water.enabled = true;
            },
            &|scene| {
                (scene.land.hillshade, scene.land.contours) = (Hillshade::Multidirectional, true);
                scene.land.colour = GroundColour::Slope;
            },
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

    /// What a scene names is read beside the pipelines, and once: the frame does not even need the files any more.
    #[test]
    fn a_frame_reads_no_image_that_was_read_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, side: u32| {
            let path = folder.path().join(name);
            let picture = image::RgbImage::from_fn(side, side, |x, y| image::Rgb([200, (9 * x) as u8, (9 * y) as u8]));
            picture.save(&path).unwrap();
            path
        };
        let (colours, weights) = (file("colours.png", 16), file("weights.png", 8));
        let faces: [_; 6] = std::array::from_fn(|face| file(&format!("face{face}.png"), 8));
        let mut scenes = [Scene::default(), Scene::default()];
        scenes[0].diffuse.file = Some(colours);
        scenes[0].skybox.faces = Some(faces);
        scenes[1].diffuse.source = ColourSource::Materials;
        scenes[1].materials.coverage = vec![weights];
        let gpu = Gpu::headless().unwrap();
        let target = Target::new(&gpu, [40, 30]);
        let draw = |renderer: &mut Renderer, scene: &Scene| {
            renderer.draw(scene, &target).map(|()| target.read_color(&gpu).unwrap())
        };
        let mut renderer = renderer(&gpu);
        let plain = draw(&mut renderer, &Scene::default()).unwrap();
        let expected: Vec<_> = scenes.iter().map(|scene| draw(&mut self::renderer(&gpu), scene).unwrap()).collect();
        let read: Vec<_> = scenes
            .iter()
            .map(|scene| renderer.missing_pipelines(scene, target.size(), false).unwrap().build(&|| true).unwrap())
            .collect();
        folder.close().unwrap();
        for ((scene, read), expected) in scenes.iter().zip(read).zip(&expected) {
            renderer.set_compiled(read);
            assert!(renderer.missing_pipelines(scene, target.size(), false).is_none());
            let drawn = draw(&mut renderer, scene).unwrap();
            assert!(drawn == *expected && drawn != plain, "{scene:?}");
            // On the GPU nothing is missing; dropped from there, the frame has to read it itself again.
            assert!(renderer.missing_pipelines(scene, target.size(), false).is_none());
            draw(&mut renderer, &Scene::default()).unwrap();
            assert!(renderer.missing_pipelines(scene, target.size(), false).is_some());
            let error = draw(&mut renderer, scene).unwrap_err();
            assert!(matches!(error, RenderError::Image { .. }), "{error}");
            draw(&mut renderer, &Scene::default()).unwrap();
        }
        // One that cannot be read is the error of the frame that needs it.
        let mut scene = Scene::default();
        scene.land.imagery = Some("gone.tif".into());
        let read = renderer.missing_pipelines(&scene, target.size(), false).unwrap().build(&|| true).unwrap();
        renderer.set_compiled(read);
        assert!(renderer.missing_pipelines(&scene, target.size(), false).is_none());
        assert!(matches!(draw(&mut renderer, &scene), Err(RenderError::Image { .. })));
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
