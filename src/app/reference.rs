//! The f64 reference of the error view, computed on threads of its own while the eye rests.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;

use super::redraw::Next;
use crate::camera::Camera;
use crate::heightfield::reference::Surface;
use crate::heightfield::{Crater, EditedTerrain, HeightField};

/// The eye rests once a picture has been on screen for so long.
const REST: Duration = Duration::from_millis(250);

/// All that the reference's distances depend on.
#[derive(Clone, Debug)]
pub(crate) struct Question {
    pub(crate) map: Arc<HeightField>,
    pub(crate) craters: Vec<Crater>,
    /// Size of the terrain's box.
    pub(crate) extent: DVec3,
    pub(crate) camera: Camera,
    /// Size of the picture in pixels.
    pub(crate) size: [u32; 2],
}

impl PartialEq for Question {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.map, &other.map)
            && (&self.craters, self.extent, self.camera, self.size)
                == (&other.craters, other.extent, other.camera, other.size)
    }
}

/// Size of a picture in pixels, and its distances: world units, +inf for sky.
pub(crate) type Found = ([u32; 2], Vec<f32>);

/// Distances on their way.
#[derive(Debug)]
struct Work {
    cancelled: Arc<AtomicBool>,
    distances: Receiver<Vec<f32>>,
}

impl Drop for Work {
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// What is known of the question.
#[derive(Debug)]
enum State {
    /// The eye may be on its way still.
    Resting(Instant),
    Working(Work),
    /// The distances were handed out, or there is no thread to find them.
    Over,
}

/// Finds the reference's distances of the view that is on screen.
#[derive(Debug, Default)]
pub(crate) struct ReferenceWorker {
    current: Option<(Question, State)>,
}

impl ReferenceWorker {
    /// Nobody wants distances any more; what was begun is cancelled.
    pub(crate) fn forget(&mut self) {
        self.current = None;
    }

    /// Whether the distances of this very question were handed out, or are on their way.
    pub(crate) fn is_about(&self, question: &Question) -> bool {
        self.current.as_ref().is_some_and(|(current, _)| current == question)
    }

    /// The view on screen is this one since `now`: the distances of any other are not wanted any more.
    pub(crate) fn ask(&mut self, question: Question, now: Instant) {
        self.current = Some((question, State::Resting(now + REST)));
    }

    /// When to look again; `Never` where nothing is awaited, or where its end is told.
    pub(crate) fn next(&self) -> Next {
        match &self.current {
            Some((_, State::Resting(until))) => Next::At(*until),
            _ => Next::Never,
        }
    }

    /// Whether distances are awaited.
    pub(crate) fn is_busy(&self) -> bool {
        matches!(&self.current, Some((_, State::Resting(_) | State::Working(_))))
    }

    /// Starts what is due, and hands out distances that have arrived, once. `done` is called on another thread when
    /// there are some to be fetched.
    ///
    /// # Errors
    /// There are no threads to work on.
    pub(crate) fn poll(&mut self, now: Instant, done: impl FnOnce() + Send + 'static) -> Result<Option<Found>, String> {
        let Some((question, state)) = &mut self.current else { return Ok(None) };
        match state {
            State::Resting(until) if *until <= now => {
                let work = start(question.clone(), done);
                *state = State::Over;
                *state = State::Working(work?);
                Ok(None)
            }
            State::Working(work) => match work.distances.try_recv() {
                Ok(distances) => {
                    let size = question.size;
                    *state = State::Over;
                    Ok(Some((size, distances)))
                }
                Err(TryRecvError::Empty) => Ok(None),
                Err(TryRecvError::Disconnected) => {
                    *state = State::Over;
                    Err("the thread that computes it ended early".into())
                }
            },
            State::Resting(_) | State::Over => Ok(None),
        }
    }
}

/// Begins to find the distances of `question`, on all processors but one: that is for the window.
fn start(question: Question, done: impl FnOnce() + Send + 'static) -> Result<Work, String> {
    let processors = std::thread::available_parallelism().map_or(2, usize::from);
    let threads = rayon::ThreadPoolBuilder::new()
        .num_threads((processors - 1).max(1))
        .thread_name(|index| format!("reference {index}"))
        .build()
        .map_err(|error| error.to_string())?;
    let cancelled = Arc::new(AtomicBool::new(false));
    let (sender, distances) = channel();
    let stop = Arc::clone(&cancelled);
    threads.spawn(move || {
        if let Some(distances) = distances_of(&question, &stop) {
            // The receiver is gone only when nobody wants them any more.
            let _ = sender.send(distances);
            done();
        }
    });
    Ok(Work { cancelled, distances })
}

/// The distances, world units, +inf for sky; `None` where they were cancelled.
fn distances_of(question: &Question, stop: &AtomicBool) -> Option<Vec<f32>> {
    let edited = (!question.craters.is_empty()).then(|| {
        let mut terrain = EditedTerrain::new(Arc::clone(&question.map));
        terrain.set_craters(&question.craters);
        terrain
    });
    let field = edited.as_ref().map_or(&*question.map, EditedTerrain::field);
    let surface = Surface::new(field, question.extent);
    let (camera, size) = (question.camera, question.size);
    let [width, height] = size.map(|side| side as usize);
    let mut distances = vec![f32::INFINITY; width * height];
    distances.par_chunks_mut(width.max(1)).enumerate().for_each(|(row, pixels)| {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let ray = camera.ray(column as f64 + 0.5, row as f64 + 0.5, size);
            if let Some(hit) = surface.intersect(&ray) {
                *pixel = (hit.depth * ray.direction.length()) as f32;
            }
        }
    });
    (!stop.load(Ordering::Relaxed)).then_some(distances)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::NamedView;

    fn question(craters: Vec<Crater>) -> Question {
        let raw: Vec<f32> = (0..33 * 33).map(|index| (index * 37 % 101) as f32).collect();
        let map = Arc::new(HeightField::from_raw(33, 33, &raw).unwrap());
        let extent = map.box_size(None);
        let camera = NamedView::Over.camera(&map, extent);
        Question { map, craters, extent, camera, size: [40, 30] }
    }

    fn wait(worker: &mut ReferenceWorker) -> Found {
        let (sender, receiver) = channel();
        let done = move || sender.send(()).unwrap();
        assert_eq!(worker.poll(Instant::now() + REST, done).unwrap(), None, "it has just begun");
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        worker.poll(Instant::now(), || ()).unwrap().unwrap()
    }

    /// The view is compared with the very reference that the tables use, craters included.
    #[test]
    fn the_distances_are_those_of_the_reference() {
        let crater = Crater { x: 0.5, z: 0.5, radius: 0.3, depth: 0.5, rim: 0.1 };
        for craters in [Vec::new(), vec![crater]] {
            let question = question(craters);
            let mut worker = ReferenceWorker::default();
            worker.ask(question.clone(), Instant::now());
            let (size, distances) = wait(&mut worker);
            let mut terrain = EditedTerrain::new(Arc::clone(&question.map));
            terrain.set_craters(&question.craters);
            let surface = Surface::new(terrain.field(), question.extent);
            let expected = surface.distances(&question.camera, question.size, &|_| ());
            assert_eq!(size, question.size);
            assert!(distances.iter().zip(&expected).all(|(a, b)| *a == *b as f32));
            assert!(distances.iter().any(|distance| distance.is_finite()));
            assert!(!worker.is_busy() && worker.is_about(&question), "handed out once");
            assert_eq!(worker.poll(Instant::now(), || ()).unwrap(), None);
        }
    }

    #[test]
    fn an_eye_that_moves_starts_nothing_and_a_new_view_cancels_the_old() {
        let mut worker = ReferenceWorker::default();
        let now = Instant::now();
        let first = question(Vec::new());
        worker.ask(first.clone(), now);
        assert_eq!(worker.next(), Next::At(now + REST));
        assert_eq!(worker.poll(now, || panic!("too early")).unwrap(), None);
        worker.poll(now + REST, || ()).unwrap();
        assert!(worker.is_busy() && worker.next() == Next::Never);
        let second = Question { size: [7, 5], ..first.clone() };
        worker.ask(second, now);
        assert!(!worker.is_about(&first));
        assert_eq!(wait(&mut worker).0, [7, 5], "the old view's distances never come");
        worker.forget();
        assert!(!worker.is_busy());
        let stop = AtomicBool::new(true);
        assert_eq!(distances_of(&first, &stop), None);
    }
}
