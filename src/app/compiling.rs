//! Pipelines, compiled on a thread of their own: until they are there the frame goes on with those last in use.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use super::frame::put_back;
use super::graphics::Graphics;
use super::viewer::Viewer;
use super::window::UserEvent;
use super::{cones, measure};
use crate::gpu::ShaderError;
use crate::render::{Compilation, Compiled, RenderError, Renderer};
use crate::scene::{CloudSource, Scene};

/// How long pipelines wait for the notice to be on screen: a hidden window never shows it.
const NOTICE_PATIENCE: Duration = Duration::from_millis(500);

/// Environment variable that makes a debug build's compiler take so many milliseconds longer.
const SLOW_VARIABLE: &str = "RELIEF_SLOW_COMPILE";

/// Pipelines on their way.
#[derive(Debug)]
struct Work {
    wanted: Compilation,
    cancelled: Arc<AtomicBool>,
    /// Told once when the notice is on screen.
    notice: Option<Sender<()>>,
    outcome: Receiver<Result<Compiled, ShaderError>>,
    thread: Option<JoinHandle<()>>,
}

/// Compiles what the scene needs, on one thread: what it is at is finished first, and then only what was wanted last begun.
#[derive(Debug, Default)]
pub(crate) struct Compiler {
    work: Option<Work>,
    /// What does not compile is not tried again.
    failed: Option<Compilation>,
    /// The frame under way says that something is being compiled.
    announced: bool,
}

impl Drop for Compiler {
    /// Waits for the driver's compiler, which the end of the program would take down under it.
    fn drop(&mut self) {
        self.give_up();
        if let Some(Work { thread: Some(thread), notice, .. }) = self.work.take() {
            drop(notice);
            // A panic has been told on stderr.
            let _ = thread.join();
        }
    }
}

impl Compiler {
    /// Whether something is being compiled.
    pub(crate) fn is_busy(&self) -> bool {
        self.work.is_some()
    }

    /// Whether nothing but images is being made ready.
    fn only_reads(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.wanted.is_only_images())
    }

    /// Nobody waits any more: no other pipeline is begun.
    fn give_up(&self) {
        if let Some(work) = &self.work {
            work.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// All that is wanted is there. What failed may be tried again when it is wanted again, and is told again.
    pub(crate) fn rest(&mut self) {
        self.give_up();
        self.failed = None;
    }

    /// What is being compiled is for a device that is gone: its thread is left to itself.
    pub(crate) fn forget(&mut self) {
        self.give_up();
        (self.work, self.failed) = (None, None);
    }

    /// The frame under way says that something is being compiled.
    pub(crate) fn announce(&mut self) {
        self.announced = true;
    }

    /// The frame under way is on screen. With the notice on it, the first frame with new pipelines may take its time.
    pub(crate) fn frame_was_shown(&mut self) {
        if std::mem::take(&mut self.announced)
            && let Some(notice) = self.work.as_mut().and_then(|work| work.notice.take())
        {
            // Fails only where the work has ended already.
            let _ = notice.send(());
        }
    }

    /// Asks for pipelines. `done` is called on another thread when they can be fetched. False where nothing new is begun:
    /// these are being compiled, do not compile, or have to wait for what is under way.
    ///
    /// # Errors
    /// There is no thread to work on.
    pub(crate) fn ask(&mut self, wanted: Compilation, done: impl FnOnce() + Send + 'static) -> io::Result<bool> {
        if let Some(work) = &self.work {
            // The very same may have been given up, and been wanted again since.
            work.cancelled.store(work.wanted != wanted, Ordering::Relaxed);
            return Ok(false);
        }
        if self.failed.as_ref() == Some(&wanted) {
            return Ok(false);
        }
        match start(wanted.clone(), done) {
            Ok(work) => {
                self.work = Some(work);
                Ok(true)
            }
            Err(error) => {
                self.failed = Some(wanted);
                Err(error)
            }
        }
    }

    /// Hands out what was compiled, once; also what was given up.
    ///
    /// # Errors
    /// A shader that is wanted still and does not compile.
    pub(crate) fn poll(&mut self) -> Result<Option<Compiled>, RenderError> {
        let Some(work) = &self.work else { return Ok(None) };
        let outcome = match work.outcome.try_recv() {
            Ok(outcome) => outcome.map_err(RenderError::from),
            Err(TryRecvError::Empty) => return Ok(None),
            Err(TryRecvError::Disconnected) => Err(no_compiler("the thread that compiles them ended early")),
        };
        let Some(work) = self.work.take() else { return Ok(None) };
        match outcome {
            Ok(compiled) => Ok(Some(compiled)),
            Err(_) if work.cancelled.load(Ordering::Relaxed) => Ok(None),
            Err(error) => {
                self.failed = Some(work.wanted);
                Err(error)
            }
        }
    }
}

/// Begins to compile. The thread builds the pipelines beside the frames, and hands them over once the notice is on screen:
/// some drivers compile in the first frame that draws with a pipeline, for the very textures and samplers of that frame,
/// and have one queue, so that nothing else is drawn meanwhile. (A draw of nothing beforehand was measured: lavapipe
/// compiled for its textures, and again in the frame.)
fn start(wanted: Compilation, done: impl FnOnce() + Send + 'static) -> io::Result<Work> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let ((notice, shown), (sender, outcome)) = (channel(), channel());
    let (stop, compilation) = (Arc::clone(&cancelled), wanted.clone());
    let compile = move || {
        let _done = cones::CallOnDrop(Some(done));
        let sender = sender;
        let go_on = || !stop.load(Ordering::Relaxed);
        pretend_to_work(&go_on);
        let outcome = compilation.build(&go_on);
        if outcome.is_ok() && go_on() {
            // Without a notice in time the window is hidden, and nobody sees the frame that takes long.
            let _ = shown.recv_timeout(NOTICE_PATIENCE);
        }
        // The receiver is gone only when nobody wants them any more.
        let _ = sender.send(outcome);
    };
    let thread = std::thread::Builder::new().name("compiler".into()).spawn(compile)?;
    Ok(Work { wanted, cancelled, notice: Some(notice), outcome, thread: Some(thread) })
}

/// Takes its time where a debug build was told to.
fn pretend_to_work(go_on: &dyn Fn() -> bool) {
    const STEP: u64 = 10;
    let asked = std::env::var(SLOW_VARIABLE).ok().filter(|_| cfg!(debug_assertions));
    let milliseconds: u64 = asked.and_then(|asked| asked.parse().ok()).unwrap_or(0);
    for _ in 0..milliseconds / STEP {
        if go_on() {
            std::thread::sleep(Duration::from_millis(STEP));
        }
    }
}

/// An error of no shader in particular.
fn no_compiler(reason: &str) -> RenderError {
    ShaderError { file: "shaders".into(), message: reason.into() }.into()
}

/// Scenes that `shown`'s pipelines can draw in place of `wanted`, the nearest to it first. The eye is always where it is
/// wanted.
fn stand_ins(wanted: &Scene, shown: &Scene) -> [Scene; 4] {
    let mut near = wanted.clone();
    (near.march, near.debug) = (shown.march.clone(), shown.debug.clone());
    (near.compare.enabled, near.compare.technique) = (shown.compare.enabled, shown.compare.technique);
    (near.lighting.enabled, near.lighting.shadows) = (shown.lighting.enabled, shown.lighting.shadows);
    near.skybox.model = shown.skybox.model;
    (near.lighting.baked, near.lighting.occlusion) = (shown.lighting.baked, shown.lighting.occlusion);
    (near.diffuse.enabled, near.diffuse.source) = (shown.diffuse.enabled, shown.diffuse.source);
    near.materials.clone_from(&shown.materials);
    (near.air.perspective, near.air.fog) = (shown.air.perspective, shown.air.fog);
    (near.clouds.enabled, near.clouds.shadows) = (shown.clouds.enabled, shown.clouds.shadows);
    near.flare.enabled = shown.flare.enabled;
    near.land.clone_from(&shown.land);
    near.water.clone_from(&shown.water);
    near.skybox.enabled = shown.skybox.enabled;
    near.skybox.faces.clone_from(&shown.skybox.faces);
    near.diffuse.file.clone_from(&shown.diffuse.file);
    near.occluder.enabled = shown.occluder.enabled;
    // Clouds of a map whose pattern is still being found.
    let mut noisy = near.clone();
    noisy.clouds.source = CloudSource::Noise;
    // Where the craters need pipelines, too, the old ones stay.
    let far = Scene { craters: shown.craters.clone(), ..near.clone() };
    // A sun that has just set needs other pipelines, too, and whatever is forgotten here: only the eye is new.
    let farthest = Scene { camera: wanted.camera, ..shown.clone() };
    [near, noisy, far, farthest]
}

/// `scene` as it can be drawn at once in a picture of `size` pixels: with the settings of `shown`, the scene drawn last, while
/// pipelines for its own are compiled. `None` where not even that can be drawn.
fn drawable(scene: &Scene, shown: Option<&Scene>, renderer: &Renderer, size: [u32; 2]) -> Option<Scene> {
    let is_ready = |scene: &Scene| renderer.missing_pipelines(scene, size, false).is_none();
    let wanted = cones::drawable(scene, renderer);
    if is_ready(&wanted) {
        return Some(wanted);
    }
    let stand_ins = shown.map(|shown| stand_ins(scene, shown)).into_iter().flatten();
    stand_ins.map(|scene| cones::drawable(&scene, renderer)).find(is_ready)
}

impl Viewer {
    /// The scene as the next frame draws it: that of the kept picture where it has to stay, and the scene itself where there
    /// is no picture yet and the frame has to wait.
    pub(super) fn drawable(&self, graphics: &Graphics) -> Scene {
        let (renderer, size) = (&graphics.renderer, graphics.target.size());
        drawable(&self.scene, self.shown.as_ref(), renderer, size)
            .or_else(|| self.drawn.clone())
            .unwrap_or_else(|| cones::drawable(&self.scene, renderer))
    }

    /// Whether the next frame draws something else than the scene because pipelines are being compiled.
    pub(super) fn stands_in(&self, graphics: &Graphics, drawable: &Scene) -> bool {
        *drawable != cones::drawable(&self.scene, &graphics.renderer)
    }

    /// Compiles what the scene needs, and then what measuring its steps does; hands the renderer what was compiled.
    pub(super) fn follow_compiler(&mut self, graphics: &mut Graphics) {
        match self.compiler.poll() {
            Ok(None) => {}
            Ok(Some(compiled)) => {
                graphics.renderer.set_compiled(compiled);
                self.redraw.invalidate();
            }
            Err(error) => self.not_compiled(&error),
        }
        // The first picture has to wait for its pipelines anyway.
        if self.shown.is_none() {
            return;
        }
        let (renderer, size) = (&graphics.renderer, graphics.target.size());
        let at_once = cones::drawable(&self.scene, renderer);
        let probed = self.view.measure_steps.then(|| measure::probed_size(size));
        // Then what is drawn once its cones are found, and what a measurement draws.
        let missing = renderer
            .missing_pipelines(&at_once, size, false)
            .or_else(|| renderer.missing_pipelines(&at_once, probed?, true))
            .or_else(|| renderer.missing_pipelines(&self.scene, size, false))
            .or_else(|| self.tradeoff.missing_pipelines(renderer));
        let Some(wanted) = missing else {
            self.compiler.rest();
            return;
        };
        let proxy = self.proxy.clone();
        let done = move || {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Compiled);
        };
        match self.compiler.ask(wanted, done) {
            Ok(false) => {}
            // It is said in the next frame.
            Ok(true) => self.redraw.invalidate(),
            Err(error) => {
                self.not_compiled(&no_compiler(&format!("no thread to compile on: {error}; close some programs")));
            }
        }
    }

    /// Tells why, and takes back what needed it.
    fn not_compiled(&mut self, error: &RenderError) {
        self.toasts.error(&error.to_string());
        put_back(&mut self.scene, self.last_good.as_ref(), error);
        self.redraw.invalidate();
    }

    /// What is being waited for, in words, while pipelines are compiled.
    pub(super) fn compiling_in_words(&self, drawable: &Scene) -> Option<String> {
        let (wanted, drawn) = (self.scene.march.technique, drawable.march.technique);
        self.compiler.is_busy().then(|| {
            if self.compiler.only_reads() {
                "Reading an image …".to_owned()
            } else if wanted == drawn {
                "Compiling shaders …".to_owned()
            } else {
                format!("Compiling {} …, {} draws meanwhile", wanted.name(), drawn.name())
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Gpu;
    use crate::heightfield::generate::{Kind, generate};
    use crate::scene::{CraterMode, Technique};

    const SIZE: [u32; 2] = [24, 16];

    fn renderer() -> Renderer {
        let mut renderer = Renderer::new(Gpu::noop()).unwrap();
        renderer.set_terrain(Arc::new(generate(Kind::Ridged, 33, 3))).unwrap();
        renderer
    }

    fn build(renderer: &mut Renderer, scene: &Scene) {
        if let Some(missing) = renderer.missing_pipelines(scene, SIZE, false) {
            let compiled = missing.build(&|| true).unwrap();
            renderer.set_compiled(compiled);
        }
    }

    fn of(technique: Technique) -> Scene {
        let mut scene = Scene::default();
        scene.march.technique = technique;
        scene
    }

    #[test]
    fn the_pipelines_last_in_use_draw_what_they_can_of_the_scene() {
        let mut renderer = renderer();
        let shown = of(Technique::Linear);
        let mut scene = of(Technique::Secant);
        assert!(drawable(&scene, Some(&shown), &renderer, SIZE).is_none(), "there are none");
        build(&mut renderer, &shown);
        assert!(drawable(&scene, None, &renderer, SIZE).is_none(), "and before the first picture they are no use");
        let eye = crate::camera::Camera { eye: glam::DVec3::ONE, yaw: 1.0, pitch: 2.0, fov: 50.0 };
        scene.camera = Some(eye);
        scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
        scene.lighting.ambient = 0.3;
        let stand_in = drawable(&scene, Some(&shown), &renderer, SIZE).unwrap();
        assert_eq!(stand_in, Scene { march: shown.march.clone(), ..scene.clone() }, "eye, crater and light are new");
        scene.craters.mode = CraterMode::Layered;
        let stand_in = drawable(&scene, Some(&shown), &renderer, SIZE).unwrap();
        assert_eq!((stand_in.camera, &stand_in.craters), (Some(eye), &shown.craters), "a layer has its own pipeline");
        build(&mut renderer, &scene);
        assert_eq!(drawable(&scene, Some(&shown), &renderer, SIZE), Some(scene));
    }

    /// Switching back and forth must not pile up threads, and what was given up half-way is no loss.
    #[test]
    fn one_thing_is_compiled_at_a_time_and_what_is_given_up_is_no_error() {
        let mut renderer = renderer();
        let mut compiler = Compiler::default();
        let missing = |renderer: &Renderer, scene: &Scene| renderer.missing_pipelines(scene, SIZE, false).unwrap();
        let (first, second) = (of(Technique::Linear), of(Technique::Secant));
        let (sender, receiver) = channel();
        let begun = compiler.ask(missing(&renderer, &first), move || sender.send(()).unwrap()).unwrap();
        assert!(begun && compiler.is_busy());
        let never = || panic!("this is not begun");
        for _ in 0..20 {
            assert!(!compiler.ask(missing(&renderer, &second), never).unwrap());
            assert!(!compiler.ask(missing(&renderer, &first), never).unwrap());
        }
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        renderer.set_compiled(compiler.poll().unwrap().unwrap());
        assert!(!compiler.is_busy() && compiler.poll().unwrap().is_none(), "handed out once");
        assert!(renderer.missing_pipelines(&first, SIZE, false).is_none(), "asked for last, it was not given up");
        let (sender, receiver) = channel();
        assert!(compiler.ask(missing(&renderer, &second), move || sender.send(()).unwrap()).unwrap());
        compiler.give_up();
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(compiler.poll().unwrap().is_some());
    }
}
