//! Cone maps: for every cell, how wide a cone stands on it that holds no ground, or none behind which a ray comes out
//! again.
//!
//! `Cone` follows Dummer 2006 ("Cone Step Mapping: An Iterative Ray-Heightfield Intersection Algorithm"), `Relaxed`
//! Policarpo and Oliveira 2007 (GPU Gems 3, chapter 18: "Relaxed Cone Stepping for Relief Mapping"). Both papers put a
//! cone on a texel and compare texels with texels, so that their cones are only safe on the samples: between them, where
//! the map is filtered, a cone may hold ground. Bán and Valasek 2024 make cones robust under bilinear filtering; what
//! follows does so for the surface of this project, whose samples stand on the corners of cells.
//!
//! # Definitions
//!
//! Lengths are in cells along the ground and in normalised heights above it, so that a map of cones serves every
//! proportion of the box. Let c be a cell, m its highest corner, q a point, h(q) the ground there, and d(q) the distance
//! of q from c along x plus that along z (that in the 1-norm: cones have a square base that stands on its corner). The
//! cone of c with the slope s is the set of points above m + s·d(q).
//!
//! # A cone without ground
//!
//! s is the largest (h(k) − m) / d(k) of all samples k that are no corner of c, or 0.
//!
//! *No ground is in the cone*, that is h(q) ≤ m + s·d(q) everywhere. On c itself d is 0 and h ≤ m, since a bilinear patch
//! nowhere exceeds its corners. On any other cell d is linear, because neither wall of c runs through it; so
//! g = h − m − s·d is bilinear there and nowhere exceeds the largest of its values at the corners. None of these is
//! positive: by the choice of s, or, at a corner of c, because d is 0 and h ≤ m. (The Euclidean distance is convex but not
//! linear on a cell: with it the samples alone would not decide.)
//!
//! A ray that is over c above m can therefore go on to where it leaves the cone.
//!
//! # A relaxed cone
//!
//! A ray may enter the ground inside such a cone, but not come out of it again: then it enters at most once, the point
//! where it leaves the cone tells whether it has, and halvings find where. s is the largest (h(k) − m) / d(k) of those
//! samples k, no corner of c, that are corners of a cell which a ray can come out of.
//!
//! *A ray that is over c above m and does not rise comes out of the ground nowhere inside the cone.* Let it come out at
//! q, and be over the cell e just before. (e is not c: over c the ray is above m while it is in the cone.) There it gains on
//! the ground, which therefore falls in its direction. That direction leads from a point of c to one of e; with i and j
//! columns and rows from c to e its components are in \[i − 1, i + 1\] and \[j − 1, j + 1\]. The derivatives of the patch over
//! e along x and z lie between those of its opposite edges. If no choice out of these four intervals gives a negative
//! derivative in the ray's direction, nothing comes out of e. Otherwise e counts, h ≤ m + s·d on its corners and, as above,
//! on all of e; so q is not in the cone.
//!
//! Such a cone is wider only where the ground rises all the way to a crest, for behind each crest there is a slope that
//! lets a level ray out: on rough maps by some hundredths. (Cones for rays that fall by at least so much are wider, too; but
//! more of them must be kept, they took up to ten times as long to find, and saved less than one step of a ray.)
//!
//! For a *rising* ray no such cone is wider than the one without ground: it can be laid through the ground right behind
//! the sample that gives s. A relaxed map therefore holds that slope, too, and rising rays take it. (The papers' rays come
//! down from the lid of the box; those that start at an eye in a valley rise.) Policarpo and Oliveira only follow rays that
//! start at the lid over the texel; the cone here holds for those that come to pass lower over it, too.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::{HeightField, MaxPyramid};

/// Nodes that the search for a relaxed cone looks at; those still waiting then count with their bounds, which only makes
/// the cone narrower.
const MOST_VISITS: u32 = 2000;

/// Relative error, with room to spare, of the quotient of a difference in f32; and of a difference.
const ROUNDING: f32 = 3e-7;

/// What a cone may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConeKind {
    /// No ground (Dummer 2006).
    Cone,
    /// Ground that a ray which does not rise enters at most once (Policarpo, Oliveira 2007).
    Relaxed,
}

impl ConeKind {
    /// Slopes kept for a cell: that of the cone without ground and, in a relaxed map, that of the relaxed one.
    pub fn channels(self) -> usize {
        match self {
            Self::Cone => 1,
            Self::Relaxed => 2,
        }
    }
}

/// A cone for every cell of a height map; the module's documentation defines it.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeMap {
    kind: ConeKind,
    cells: [u32; 2],
    slopes: Vec<f32>,
}

impl ConeMap {
    /// Finds the cones of `field` on all cores. `progress` hears the share that is done, 0 to 1, from any thread and in no
    /// strict order. The result depends on the samples alone: neither on the proportion of the box nor on the threads.
    pub fn build(field: &HeightField, kind: ConeKind, progress: &(dyn Fn(f32) + Sync)) -> Self {
        let go_on = |share| {
            progress(share);
            ControlFlow::Continue(())
        };
        let mut map = Self { kind, cells: field.cells(), slopes: Vec::new() };
        // Nobody breaks off, so nothing is missing.
        map.slopes = slopes(field, kind, &go_on).unwrap_or_default();
        map
    }

    /// Finds the cones of `field` like [`Self::build`], until `progress` breaks off: `None` then. It is asked once for each
    /// row of cells; the rows that other threads have begun are still finished.
    pub fn build_while(
        field: &HeightField,
        kind: ConeKind,
        progress: &(dyn Fn(f32) -> ControlFlow<()> + Sync),
    ) -> Option<Self> {
        slopes(field, kind, progress).map(|slopes| Self { kind, cells: field.cells(), slopes })
    }

    /// What the cones may hold.
    pub fn kind(&self) -> ConeKind {
        self.kind
    }

    /// Cells along x and z.
    pub fn cells(&self) -> [u32; 2] {
        self.cells
    }

    /// Slopes in normalised heights per cell, row by row, [`ConeKind::channels`] for each cell.
    pub fn slopes(&self) -> &[f32] {
        &self.slopes
    }
}

/// The slopes of all cells, as [`ConeMap::slopes`] has them; `None` where `progress` breaks off.
fn slopes(field: &HeightField, kind: ConeKind, progress: &(dyn Fn(f32) -> ControlFlow<()> + Sync)) -> Option<Vec<f32>> {
    let search = Search::new(field, kind);
    let (channels, cells) = (kind.channels(), field.cells());
    let row_length = cells[0] as usize * channels;
    let mut slopes = vec![0.0; row_length * cells[1] as usize];
    let (done, over) = (AtomicUsize::new(0), AtomicBool::new(false));
    slopes.par_chunks_mut(row_length).enumerate().for_each(|(row, slopes)| {
        if over.load(Ordering::Relaxed) {
            return;
        }
        search.row(row as u32, slopes);
        let rows = done.fetch_add(1, Ordering::Relaxed) + 1;
        if progress(rows as f32 / cells[1] as f32).is_break() {
            over.store(true, Ordering::Relaxed);
        }
    });
    (!over.into_inner()).then_some(slopes)
}

/// The cell that a cone stands on.
#[derive(Clone, Copy, Debug)]
struct Apex {
    column: u32,
    row: u32,
    /// Its highest corner.
    height: f32,
}

impl Apex {
    /// Distance in the 1-norm, in cells, from the samples `first` to `last`.
    fn distance(&self, first: [u32; 2], last: [u32; 2]) -> f32 {
        let along = |at: u32, first: u32, last: u32| first.saturating_sub(at + 1) + at.saturating_sub(last);
        (along(self.column, first[0], last[0]) + along(self.row, first[1], last[1])) as f32
    }

    /// The slope at which ground of this height so far away bounds the cone; infinite where it touches the cell.
    fn slope_to(&self, height: f32, distance: f32) -> f32 {
        if height <= self.height { 0.0 } else { (height - self.height) / distance }
    }
}

/// Range of the ground's derivatives along x and z, per cell.
#[derive(Clone, Copy, Debug)]
struct Gradients {
    x: [f32; 2],
    z: [f32; 2],
}

impl Gradients {
    const NONE: Self = Self { x: [f32::INFINITY, f32::NEG_INFINITY], z: [f32::INFINITY, f32::NEG_INFINITY] };

    fn of_cell([nw, ne, sw, se]: [f32; 4]) -> Self {
        let range = |a: f32, b: f32| {
            let (low, high) = (a.min(b), a.max(b));
            [low - low.abs() * ROUNDING, high + high.abs() * ROUNDING]
        };
        Self { x: range(ne - nw, se - sw), z: range(sw - nw, se - ne) }
    }

    fn union(self, other: Self) -> Self {
        let range = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { x: range(self.x, other.x), z: range(self.z, other.z) }
    }

    /// Whether a ray from `apex` that does not rise may come out of the ground over the cells `first` to `last`.
    fn let_out(&self, apex: &Apex, first: [u32; 2], last: [u32; 2]) -> bool {
        let least = |at: u32, first: u32, last: u32, slopes: [f32; 2]| {
            let reach = [f64::from(first) - f64::from(at) - 1.0, f64::from(last) - f64::from(at) + 1.0];
            let gains = reach.map(|way| slopes.map(|slope| way * f64::from(slope)));
            gains.iter().flatten().copied().fold(f64::INFINITY, f64::min)
        };
        least(apex.column, first[0], last[0], self.x) + least(apex.row, first[1], last[1], self.z) < 0.0
    }
}

/// A node that waits to be looked at, and the slope that it demands at most.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    bound: f32,
    /// 0 is a cell.
    level: u32,
    node: [u32; 2],
}

/// What all searches over a map share.
struct Search<'a> {
    field: &'a HeightField,
    kind: ConeKind,
    cells: [u32; 2],
    maxima: MaxPyramid,
    /// Gradients of the pyramid's nodes, level by level; empty where no relaxed cone is sought.
    gradients: Vec<Vec<Gradients>>,
}

impl<'a> Search<'a> {
    fn new(field: &'a HeightField, kind: ConeKind) -> Self {
        let mut search =
            Self { field, kind, cells: field.cells(), maxima: MaxPyramid::build(field), gradients: Vec::new() };
        if kind == ConeKind::Relaxed {
            for level in 1..=search.maxima.levels().len() {
                let gradients = search.gradients_of_level(level as u32);
                search.gradients.push(gradients);
            }
        }
        search
    }

    /// Finds the slopes of a row of cells.
    fn row(&self, row: u32, slopes: &mut [f32]) {
        let channels = self.kind.channels();
        let mut waiting = Vec::new();
        let mut near = vec![[0, row]; channels];
        for (column, slopes) in slopes.chunks_mut(channels).enumerate() {
            let apex = self.apex(column as u32, row);
            // What a cone may hold, a wider one's ray may meet, too; and what bounded it often bounds that, too.
            let (mut most, mut before) = (f32::INFINITY, [0, row]);
            for ((slope, near), relaxed) in slopes.iter_mut().zip(&mut near).zip([false, true]) {
                let (found, cell) = self.slope(&apex, relaxed, most, [*near, before], &mut waiting);
                // Upwards: rounding must not let ground in.
                *slope = found * (1.0 + ROUNDING);
                (*near, before, most) = (cell, cell, found);
            }
        }
    }

    fn gradients_of_level(&self, level: u32) -> Vec<Gradients> {
        let [width, height] = self.nodes(level);
        (0..width * height)
            .into_par_iter()
            .map(|index| {
                let children = self.children(level, [index % width, index / width]);
                children.map(|child| self.gradients(level - 1, child)).fold(Gradients::NONE, Gradients::union)
            })
            .collect()
    }

    /// Columns and rows of nodes.
    fn nodes(&self, level: u32) -> [u32; 2] {
        self.cells.map(|side| side.div_ceil(1 << level))
    }

    /// The nodes of the next finer level under a node.
    fn children(&self, level: u32, [x, y]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [width, height] = self.nodes(level - 1);
        let places = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| [2 * x + right, 2 * y + down]);
        places.into_iter().filter(move |place| place[0] < width && place[1] < height)
    }

    fn corners(&self, [x, y]: [u32; 2]) -> [f32; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| self.field.sample(x + right, y + down))
    }

    fn apex(&self, column: u32, row: u32) -> Apex {
        Apex { column, row, height: self.highest(0, [column, row]) }
    }

    fn highest(&self, level: u32, node: [u32; 2]) -> f32 {
        match level.checked_sub(1).and_then(|index| self.maxima.levels().get(index as usize)) {
            Some(level) => level.node(node[0], node[1]),
            None => self.corners(node).into_iter().fold(0.0, f32::max),
        }
    }

    fn gradients(&self, level: u32, node: [u32; 2]) -> Gradients {
        let width = self.nodes(level)[0];
        match level.checked_sub(1).and_then(|index| self.gradients.get(index as usize)) {
            Some(level) => level[(node[1] * width + node[0]) as usize],
            None => Gradients::of_cell(self.corners(node)),
        }
    }

    /// First and last cell under a node.
    fn span(&self, level: u32, node: [u32; 2]) -> ([u32; 2], [u32; 2]) {
        let first = node.map(|place| place << level);
        let last = |axis: usize| ((node[axis] + 1) << level).min(self.cells[axis]) - 1;
        (first, [last(0), last(1)])
    }

    /// The slope at most that what is under a node demands of the cone on `apex`.
    fn bound(&self, apex: &Apex, level: u32, node: [u32; 2], relaxed: bool) -> f32 {
        let (first, last) = self.span(level, node);
        let bound = apex.slope_to(self.highest(level, node), apex.distance(first, last.map(|cell| cell + 1)));
        let counts = bound > 0.0 && (!relaxed || self.gradients(level, node).let_out(apex, first, last));
        if counts { bound } else { 0.0 }
    }

    /// The slope that the corners of a cell demand.
    fn demand(&self, apex: &Apex, cell: [u32; 2], relaxed: bool) -> f32 {
        let corners = self.corners(cell);
        if relaxed && !Gradients::of_cell(corners).let_out(apex, cell, cell) {
            return 0.0;
        }
        let places = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| [cell[0] + right, cell[1] + down]);
        let demands =
            places.into_iter().zip(corners).map(|(place, height)| apex.slope_to(height, apex.distance(place, place)));
        demands.fold(0.0, f32::max)
    }

    /// The slope of the cone on `apex`, `most` at most, and a cell that demands it. `near` are cells that bound like
    /// cones: they often demand much here, too, and then few nodes are looked at.
    fn slope(
        &self,
        apex: &Apex,
        relaxed: bool,
        most: f32,
        near: [[u32; 2]; 2],
        waiting: &mut Vec<Waiting>,
    ) -> (f32, [u32; 2]) {
        let [(first, here), (second, there)] = near.map(|cell| (self.demand(apex, cell, relaxed), cell));
        let (mut slope, mut from) = if first >= second { (first, here) } else { (second, there) };
        let top = self.maxima.levels().len() as u32;
        waiting.clear();
        waiting.push(Waiting { bound: self.bound(apex, top, [0, 0], relaxed), level: top, node: [0, 0] });
        let mut visits = 0;
        while slope < most
            && let Some(Waiting { bound, level, node }) = waiting.pop()
        {
            if bound <= slope {
                continue;
            }
            visits += 1;
            if level == 0 {
                let demand = self.demand(apex, node, relaxed);
                if demand > slope {
                    (slope, from) = (demand, node);
                }
            } else if relaxed && visits > MOST_VISITS {
                slope = bound;
            } else {
                let before = waiting.len();
                for node in self.children(level, node) {
                    let bound = self.bound(apex, level - 1, node, relaxed);
                    if bound > slope {
                        waiting.push(Waiting { bound, level: level - 1, node });
                    }
                }
                // The one that may demand most is looked at first: it rules out most of the others.
                waiting[before..].sort_unstable_by(|a, b| a.bound.total_cmp(&b.bound));
            }
        }
        (slope.min(most), from)
    }
}

#[cfg(test)]
#[path = "cone_tests.rs"]
mod tests;
