//! Cone maps, found on threads of their own: until one is there the exact technique draws in place of the one that steps
//! along it.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};

use super::graphics::Graphics;
use super::viewer::Viewer;
use super::window::UserEvent;
use crate::heightfield::{ConeKind, ConeMap};
use crate::render::{ConeGround, Renderer};
use crate::scene::{Scene, Technique};

/// What draws in place of a technique whose cones are being found.
pub(crate) const STAND_IN: Technique = Technique::MaxMipmap;

/// A map of cones that is wanted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(crate) ground: ConeGround,
    pub(crate) kind: ConeKind,
}

/// Cones on their way.
#[derive(Debug)]
struct Work {
    cancelled: Arc<AtomicBool>,
    /// Bits of the share that is found, 0..1.
    share: Arc<AtomicU32>,
    cones: Receiver<Arc<ConeMap>>,
}

impl Drop for Work {
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// Finds one map of cones at a time.
#[derive(Debug, Default)]
pub(crate) struct ConeFinder {
    /// What was asked for last; its work is absent where there were no threads for it, which is not tried again.
    current: Option<(Wanted, Option<Work>)>,
    /// Held by the search under way: one that is cancelled still finishes what it is at, and where craters follow one
    /// another quickly, the memory of several would be taken at once.
    turn: Arc<Mutex<()>>,
}

impl ConeFinder {
    /// Nobody wants cones any more; what was begun is cancelled.
    pub(crate) fn forget(&mut self) {
        self.current = None;
    }

    /// Whether cones are being found.
    pub(crate) fn is_busy(&self) -> bool {
        matches!(&self.current, Some((_, Some(_))))
    }

    /// The share of the cones that is found, 0 to 1, while some are.
    pub(crate) fn progress(&self) -> Option<f32> {
        let (_, work) = self.current.as_ref()?;
        work.as_ref().map(|work| f32::from_bits(work.share.load(Ordering::Relaxed)))
    }

    /// Asks for cones: any other that are being found are cancelled. `done` is called on another thread when they can be
    /// fetched. False where these have been asked for before.
    ///
    /// # Errors
    /// There are no threads to work on.
    pub(crate) fn ask(&mut self, wanted: &Wanted, done: impl FnOnce() + Send + 'static) -> Result<bool, String> {
        if self.current.as_ref().is_some_and(|(current, _)| current == wanted) {
            return Ok(false);
        }
        // What was begun gives its threads back first.
        self.current = Some((wanted.clone(), None));
        let work = start(wanted.clone(), Arc::clone(&self.turn), done)?;
        self.current = Some((wanted.clone(), Some(work)));
        Ok(true)
    }

    /// Hands out cones that have arrived, once.
    ///
    /// # Errors
    /// The thread that finds them is gone.
    pub(crate) fn poll(&mut self) -> Result<Option<(Wanted, Arc<ConeMap>)>, String> {
        let Some((wanted, work_left)) = &mut self.current else { return Ok(None) };
        let Some(work) = work_left else { return Ok(None) };
        match work.cones.try_recv() {
            Ok(cones) => {
                let wanted = wanted.clone();
                self.current = None;
                Ok(Some((wanted, cones)))
            }
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => {
                *work_left = None;
                Err("the thread that finds them ended early".into())
            }
        }
    }
}

/// Calls when it goes, also where the work before it panics: the window has to hear of that, too.
pub(crate) struct CallOnDrop<F: FnOnce()>(pub(crate) Option<F>);

impl<F: FnOnce()> Drop for CallOnDrop<F> {
    fn drop(&mut self) {
        if let Some(call) = self.0.take() {
            call();
        }
    }
}

/// Begins to find cones, on all processors but one, which is for the window,
/// as soon as it is this search's `turn`.
fn start(wanted: Wanted, turn: Arc<Mutex<()>>, done: impl FnOnce() + Send + 'static) -> Result<Work, String> {
    let processors = std::thread::available_parallelism().map_or(2, usize::from);
    let threads = rayon::ThreadPoolBuilder::new()
        .num_threads((processors - 1).max(1))
        .thread_name(|index| format!("cones {index}"))
        // A panic has been told on stderr, and the finder notices that nothing will come; the window goes on.
        .panic_handler(|_| {})
        .build()
        .map_err(|error| error.to_string())?;
    let (cancelled, share) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU32::new(0)));
    let (sender, cones) = channel();
    let (stop, found) = (Arc::clone(&cancelled), Arc::clone(&share));
    threads.spawn(move || {
        let _done = CallOnDrop(Some(done));
        let sender = sender;
        // Each search has threads of its own, so none of those that wait here is needed by the one before it.
        let _turn = turn.lock().unwrap_or_else(PoisonError::into_inner);
        if stop.load(Ordering::Relaxed) {
            return;
        }
        let field = wanted.ground.field();
        if stop.load(Ordering::Relaxed) {
            return;
        }
        let map = ConeMap::build_while(&field, wanted.kind, &|share| {
            // Of shares that are not negative the larger has the larger bits.
            found.fetch_max(share.to_bits(), Ordering::Relaxed);
            if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if let Some(map) = map {
            // The receiver is gone only when nobody wants them any more.
            let _ = sender.send(Arc::new(map));
        }
    });
    Ok(Work { cancelled, share, cones })
}

/// `scene` as it can be drawn at once: [`STAND_IN`] in place of techniques whose cones `renderer` does not know.
pub(crate) fn drawable(scene: &Scene, renderer: &Renderer) -> Scene {
    let mut scene = scene.clone();
    let Some((_, missing)) = renderer.missing_cones(&scene) else { return scene };
    let must_wait = |technique: Technique| technique.cones().is_some_and(|kind| missing.contains(&kind));
    if must_wait(scene.march.technique) {
        scene.march.technique = STAND_IN;
    }
    if scene.compare.enabled && must_wait(scene.compare.technique) {
        scene.compare.technique = STAND_IN;
    }
    scene
}

impl Viewer {
    /// Finds the cones that the scene needs, and then those of the techniques to be measured; hands the renderer what was
    /// found. Whatever is not wanted any more is cancelled.
    pub(super) fn follow_cones(&mut self, graphics: &mut Graphics) {
        match self.cones.poll() {
            Ok(None) => {}
            Ok(Some((Wanted { ground, .. }, cones))) => {
                graphics.renderer.set_cones(ground, cones);
                self.redraw.invalidate();
            }
            Err(reason) => self.no_cones(&reason),
        }
        let missing = graphics.renderer.missing_cones(&self.scene);
        let missing = missing.or_else(|| self.tradeoff.missing_cones(&graphics.renderer));
        let wanted = missing.and_then(|(ground, kinds)| Some(Wanted { ground, kind: *kinds.first()? }));
        let Some(wanted) = wanted else {
            if self.cones.is_busy() {
                self.redraw.invalidate();
            }
            self.cones.forget();
            return;
        };
        let proxy = self.proxy.clone();
        let done = move || {
            // Fails only when the event loop is gone, and with it whoever could be told.
            let _ = proxy.send_event(UserEvent::Cones);
        };
        match self.cones.ask(&wanted, done) {
            Ok(false) => {}
            // It is said in the next frame.
            Ok(true) => self.redraw.invalidate(),
            Err(reason) => self.no_cones(&reason),
        }
    }

    fn no_cones(&mut self, reason: &str) {
        self.tradeoff.forget();
        self.redraw.invalidate();
        self.toasts
            .error(&format!("{} stays: no cones could be found: {reason}. Close some programs.", STAND_IN.name()));
    }

    /// What is being waited for, in words, while cones are found.
    pub(super) fn cones_in_words(&self, drawable: &Scene) -> Option<String> {
        let share = self.cones.progress()?;
        let waits = drawable.march.technique != self.scene.march.technique
            || drawable.compare.technique != self.scene.compare.technique;
        let meanwhile =
            if waits { format!("{} draws meanwhile", STAND_IN.name()) } else { "for the measurement".into() };
        Some(format!("Finding cones: {:.0} %, {meanwhile} (Esc cancels)", share * 100.0))
    }

    /// Gives up the search for cones: what draws meanwhile is chosen from now on. False where none are being found.
    pub(super) fn give_up_cones(&mut self, graphics: &Graphics) -> bool {
        if !self.cones.is_busy() {
            return false;
        }
        let drawn = drawable(&self.scene, &graphics.renderer);
        self.scene.march.technique = drawn.march.technique;
        self.scene.compare.technique = drawn.compare.technique;
        self.cones.forget();
        true
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::gpu::Gpu;
    use crate::heightfield::generate::{Kind, generate};
    use crate::scene::CraterSettings;

    fn wanted(size: u32, kind: ConeKind) -> Wanted {
        let map = Arc::new(generate(Kind::Ridged, size, 3));
        Wanted { ground: ConeGround::new(&map, &CraterSettings::default(), 8192), kind }
    }

    fn wait(finder: &mut ConeFinder, wanted: &Wanted) -> (Wanted, Arc<ConeMap>) {
        let (sender, receiver) = channel();
        finder.ask(wanted, move || sender.send(()).unwrap()).unwrap();
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        finder.poll().unwrap().unwrap()
    }

    #[test]
    fn the_cones_asked_for_last_come_and_no_others() {
        let mut finder = ConeFinder::default();
        let (first, second) = (wanted(257, ConeKind::Relaxed), wanted(65, ConeKind::Cone));
        finder.ask(&first, || {}).unwrap();
        assert!(finder.is_busy() && finder.progress().is_some_and(|share| (0.0..=1.0).contains(&share)));
        let (found, cones) = wait(&mut finder, &second);
        assert_eq!(found, second);
        assert!(*cones == ConeMap::build(second.ground.map(), ConeKind::Cone, &|_| {}));
        assert!(!finder.is_busy() && finder.poll().unwrap().is_none(), "handed out once");
    }

    /// A search that nobody waits for must not hold the processors.
    #[test]
    fn a_cancelled_search_ends_without_a_map() {
        let mut finder = ConeFinder::default();
        let (sender, receiver) = channel();
        finder.ask(&wanted(513, ConeKind::Relaxed), move || sender.send(()).unwrap()).unwrap();
        finder.forget();
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(!finder.is_busy() && finder.poll().unwrap().is_none());
    }

    /// Craters that follow one another quickly would else hold the memory of many searches at once.
    #[test]
    fn a_search_waits_until_the_one_before_has_ended() {
        let mut finder = ConeFinder::default();
        let turn = Arc::clone(&finder.turn);
        let before = turn.lock().unwrap();
        let (wanted, (sender, receiver)) = (wanted(17, ConeKind::Cone), channel());
        finder.ask(&wanted, move || sender.send(()).unwrap()).unwrap();
        assert!(receiver.recv_timeout(Duration::from_millis(100)).is_err());
        assert!(finder.poll().unwrap().is_none() && finder.is_busy());
        drop(before);
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        assert_eq!(finder.poll().unwrap().unwrap().0, wanted);
    }

    /// No frame may stop to find cones, and the technique that was chosen draws as soon as they are there.
    #[test]
    fn the_exact_technique_stands_in_until_the_cones_are_known() {
        let gpu = Gpu::headless().unwrap();
        let mut renderer = Renderer::new(Arc::clone(&gpu)).unwrap();
        let map = Arc::new(generate(Kind::Ridged, 65, 3));
        renderer.set_terrain(Arc::clone(&map)).unwrap();
        let mut scene = Scene::default();
        scene.march.technique = Technique::Cone;
        scene.compare.technique = Technique::RelaxedCone;
        let techniques = |scene: &Scene| (scene.march.technique, scene.compare.technique);
        let now = drawable(&scene, &renderer);
        assert_eq!(techniques(&now), (STAND_IN, Technique::RelaxedCone), "what is not compared is left alone");
        scene.compare.enabled = true;
        assert_eq!(techniques(&drawable(&scene, &renderer)), (STAND_IN, STAND_IN));
        for (kind, expected) in [
            (ConeKind::Cone, (Technique::Cone, STAND_IN)),
            (ConeKind::Relaxed, (Technique::Cone, Technique::RelaxedCone)),
        ] {
            let (ground, kinds) = renderer.missing_cones(&scene).unwrap();
            assert_eq!(kinds.first(), Some(&kind));
            let cones = Arc::new(ConeMap::build(&ground.field(), kind, &|_| {}));
            renderer.set_cones(ground, cones);
            assert_eq!(techniques(&drawable(&scene, &renderer)), expected);
        }
        assert!(renderer.missing_cones(&scene).is_none());
        scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
        assert_eq!(techniques(&drawable(&scene, &renderer)), (STAND_IN, STAND_IN), "a crater moves cones everywhere");
        scene.craters.list.clear();
        assert!(renderer.missing_cones(&scene).is_none(), "and what was known before it still is");
    }
}
