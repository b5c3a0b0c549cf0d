//! Hydraulic erosion by drops of water: each runs downhill, takes up soil where it is fast and drops it where it slows
//! (Beyer, "Implementation of a method for hydraulic erosion", 2015, after Kruger 1989 and Chiba 1998). Models that move
//! water from sample to sample (Benes and Forsbach 2001; Mei, Decaudin, Hu 2007) need hundreds of passes over the map for
//! gullies that a drop digs in its one run.
//!
//! A drop changes the ground that the next one runs over, so their order matters. To use all cores and yet give the same
//! bytes with any number of them, the map is cut into bands of [`BAND`] rows that do not touch: in a round each band runs
//! its drops one after the other, and a drop near the cut waits for the next round, which cuts elsewhere.

use rayon::prelude::*;

use super::plane::Plane;
use super::recipe::Hydraulic;
use super::work::Work;
use super::{MakeError, hash};
use band::{Band, Drop, Soil, Tools};

#[path = "hydraulic_band.rs"]
mod band;

/// Rows of a band: many times the reach of a drop's brush.
const BAND: usize = 64;

/// Rows that a round's cut lies below the one before. More than any brush reaches, also modulo [`BAND`], so that a drop
/// that waited runs in the next round.
const CUT_STEP: usize = 27;

/// Rounds that bring new drops.
const ROUNDS: usize = 64;

/// Tells the randomness of drops from that of heights.
const STREAM: u32 = 3000;

/// What became of the soil, in heights of one sample. What was taken up is `deposited` and `carried_off`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Account {
    /// Taken up.
    pub(super) eroded: f64,
    /// Dropped on the map.
    pub(super) deposited: f64,
    /// Taken over the map's border.
    pub(super) carried_off: f64,
}

impl Account {
    fn add(&mut self, other: &Self) {
        self.eroded += other.eroded;
        self.deposited += other.deposited;
        self.carried_off += other.carried_off;
    }
}

/// Lets drops run over `heights`, in distances of samples.
pub(super) fn erode(
    heights: &mut [f32],
    plane: &Plane,
    hydraulic: &Hydraulic,
    seed: u64,
    work: Work<'_>,
) -> Result<Account, MakeError> {
    let total = (hydraulic.drops * (plane.width * plane.height) as f64) as u64;
    let mut account = Account::default();
    if total == 0 {
        return Ok(account);
    }
    let tools = Tools::new(hydraulic);
    let mut waiting = Vec::new();
    let mut origin = 0;
    for round in 0.. {
        let ids = [round, round + 1].map(|round| total * (round as u64).min(ROUNDS as u64) / ROUNDS as u64);
        waiting.extend((ids[0]..ids[1]).map(|id| start(plane, seed, id)));
        if waiting.is_empty() && round >= ROUNDS {
            break;
        }
        work.check()?;
        let mut first = BAND - round * CUT_STEP % BAND;
        if plane.wraps {
            // The samples move below the cuts, so that the map's last row meets its first.
            let turn = CUT_STEP % plane.height;
            heights.rotate_left(turn * plane.width);
            origin = (origin + turn) % plane.height;
            first = BAND;
        }
        let bands = Bands::new(plane, first);
        let (drops, part) = bands.run(heights, plane, origin, std::mem::take(&mut waiting), &tools);
        waiting = drops;
        account.add(&part);
        work.tell(((round + 1) as f32 / ROUNDS as f32).min(1.0));
    }
    heights.rotate_right(origin * plane.width);
    Ok(account)
}

/// A new drop, anywhere.
fn start(plane: &Plane, seed: u64, id: u64) -> Drop {
    let random = hash(seed, STREAM, (id >> 32) as u32, id as u32);
    let place = |bits: u64, count: usize| {
        let last = if plane.wraps { count } else { count - 1 };
        (bits & 0xffff_ffff) as f64 / (1u64 << 32) as f64 * last as f64
    };
    Drop::new(place(random, plane.width), place(random >> 32, plane.height))
}

/// Where a round cuts the map.
struct Bands {
    /// Rows of the first band.
    first: usize,
    /// Rows of the map.
    rows: usize,
}

impl Bands {
    fn new(plane: &Plane, first: usize) -> Self {
        // A map of two bands would hardly be faster, and one that wraps has no place that is far from a cut.
        let first = if plane.height < 2 * BAND { plane.height } else { first };
        Self { first, rows: plane.height }
    }

    fn count(&self) -> usize {
        1 + (self.rows - self.first).div_ceil(BAND)
    }

    /// Runs `drops`. Returns those that wait, in the order of the bands, and what became of the soil. `origin` is the row of
    /// the map that is first in `heights`.
    fn run(
        &self,
        heights: &mut [f32],
        plane: &Plane,
        origin: usize,
        drops: Vec<Drop>,
        tools: &Tools,
    ) -> (Vec<Drop>, Account) {
        let mut by_band: Vec<Vec<Drop>> = (0..self.count()).map(|_| Vec::new()).collect();
        for drop in drops {
            let drop = drop.moved_up(origin, plane);
            if let Some(drops) = by_band.get_mut(self.of(drop.row())) {
                drops.push(drop);
            }
        }
        let (head, rest) = heights.split_at_mut(self.first * plane.width);
        let slices: Vec<&mut [f32]> = std::iter::once(head).chain(rest.chunks_mut(BAND * plane.width)).collect();
        let run = |(index, (samples, drops)): (usize, (&mut [f32], Vec<Drop>))| {
            let mut soil = Soil::new(samples, plane, Band::of(self, index, plane));
            let waiting: Vec<Drop> = drops.into_iter().filter_map(|drop| soil.run(drop, tools)).collect();
            (waiting, soil.account)
        };
        let done: Vec<_> = slices.into_par_iter().zip(by_band).enumerate().map(run).collect();
        let (mut waiting, mut account) = (Vec::new(), Account::default());
        for (drops, part) in done {
            account.add(&part);
            waiting.extend(drops.into_iter().map(|drop| drop.moved_down(origin, plane)));
        }
        (waiting, account)
    }

    /// The band that a row is in.
    fn of(&self, row: usize) -> usize {
        if row < self.first { 0 } else { 1 + (row - self.first) / BAND }
    }

    /// The rows of a band: its first, and the first of the next.
    fn rows_of(&self, band: usize) -> [usize; 2] {
        let begin = |band: usize| if band == 0 { 0 } else { self.first + (band - 1) * BAND };
        [begin(band), begin(band + 1).min(self.rows)]
    }
}

#[cfg(test)]
#[path = "hydraulic_tests.rs"]
mod tests;
