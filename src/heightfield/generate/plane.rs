//! The grid that a landscape is made on.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::MakeError;
use super::work::Work;

/// A grid of samples, row by row. A tileable landscape is made as one period, in which the last column stands beside the
/// first, and closed at the end: so its opposite borders are equal whatever made it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) height: usize,
    /// The grid is one period of a landscape that repeats.
    pub(super) wraps: bool,
}

impl Plane {
    /// The grid for a map of `width` × `height` samples, each at least 2.
    pub(super) fn of([width, height]: [u32; 2], tileable: bool) -> Self {
        let less = u32::from(tileable);
        Self { width: (width - less) as usize, height: (height - less) as usize, wraps: tileable }
    }

    /// Distances of samples along the longer side of the map.
    pub(super) fn longer_side(&self) -> f64 {
        let samples = self.width.max(self.height);
        (if self.wraps { samples } else { samples - 1 }) as f64
    }

    /// Fills a grid, rows apart on all cores: `fill` gets a row's number and its samples.
    pub(super) fn rows(&self, work: Work<'_>, fill: impl Fn(usize, &mut [f32]) + Sync) -> Result<Vec<f32>, MakeError> {
        let mut samples = vec![0.0; self.width * self.height];
        self.fill_rows(&mut samples, work, fill)?;
        Ok(samples)
    }

    /// Like [`Self::rows`], into samples that are there.
    pub(super) fn fill_rows(
        &self,
        samples: &mut [f32],
        work: Work<'_>,
        fill: impl Fn(usize, &mut [f32]) + Sync,
    ) -> Result<(), MakeError> {
        let done = AtomicUsize::new(0);
        samples.par_chunks_mut(self.width).enumerate().for_each(|(row, samples)| {
            if !work.is_cancelled() {
                fill(row, samples);
                work.tell((done.fetch_add(1, Ordering::Relaxed) + 1) as f32 / self.height as f32);
            }
        });
        work.check()
    }

    /// The numbers of the rows before and after `row`. At a border that does not wrap, the row itself: the landscape is
    /// continued as in a mirror.
    pub(super) fn beside(&self, row: usize) -> [usize; 2] {
        neighbours(row, self.height, self.wraps)
    }

    /// The map's samples: those of the grid and, where it wraps, the first column and row once more.
    pub(super) fn close(&self, samples: Vec<f32>) -> Vec<f32> {
        if !self.wraps {
            return samples;
        }
        let row = |row: &[f32]| row.iter().copied().chain(row.first().copied()).collect::<Vec<f32>>();
        let mut closed = Vec::with_capacity((self.width + 1) * (self.height + 1));
        samples.chunks_exact(self.width).for_each(|samples| closed.extend(row(samples)));
        samples.chunks_exact(self.width).take(1).for_each(|samples| closed.extend(row(samples)));
        closed
    }
}

/// The places before and after `place` among `count`.
pub(super) fn neighbours(place: usize, count: usize, wraps: bool) -> [usize; 2] {
    let last = count - 1;
    let before = if place > 0 {
        place - 1
    } else if wraps {
        last
    } else {
        place
    };
    let after = if place < last {
        place + 1
    } else if wraps {
        0
    } else {
        place
    };
    [before, after]
}
