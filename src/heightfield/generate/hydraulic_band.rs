//! A drop's run over the rows of one band.

use super::super::plane::Plane;
use super::super::recipe::Hydraulic;
use super::{Account, Bands};

/// How much of its direction a drop keeps; the rest is the slope's.
const INERTIA: f64 = 0.05;
/// Soil that a drop of water and speed 1 holds on a slope of 1, in heights of one sample.
const CAPACITY: f64 = 4.0;
/// The slope that the capacity counts with at least, so that soil moves on over plains.
const LEAST_SLOPE: f64 = 0.01;
/// Of the soil above the capacity, what settles in a step.
const SETTLING: f64 = 0.3;
/// Speed squared that a fall by one sample's distance adds.
const GRAVITY: f64 = 0.1;
/// Share of the water that a step leaves.
const REMAINING: f64 = 0.98;

/// What all drops share.
pub(super) struct Tools {
    /// Columns and rows from a drop's sample, and the share of the soil that is taken there.
    brush: Vec<(isize, isize, f64)>,
    /// Rows that a drop touches above and below its own.
    reach: usize,
    /// Of the room for soil, what is filled in a step.
    strength: f64,
    lifetime: u32,
}

impl Tools {
    pub(super) fn new(hydraulic: &Hydraulic) -> Self {
        let radius = hydraulic.radius as isize;
        let places = (-radius..=radius).flat_map(|y| (-radius..=radius).map(move |x| (x, y)));
        let weighted = places.map(|(x, y)| (x, y, radius as f64 - ((x * x + y * y) as f64).sqrt()));
        let mut brush: Vec<_> = weighted.filter(|&(_, _, weight)| weight > 0.0).collect();
        let sum: f64 = brush.iter().map(|&(_, _, weight)| weight).sum();
        brush.iter_mut().for_each(|(_, _, weight)| *weight /= sum);
        // The bilinear surface below a drop, and where it goes next, need two more rows.
        Self { brush, reach: radius as usize + 1, strength: hydraulic.strength, lifetime: hydraulic.lifetime }
    }
}

/// A drop of water. Places are in samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drop {
    x: f64,
    y: f64,
    direction: [f64; 2],
    speed_squared: f64,
    water: f64,
    soil: f64,
    age: u32,
}

impl Drop {
    pub(super) fn new(x: f64, y: f64) -> Self {
        Self { x, y, direction: [0.0; 2], speed_squared: 1.0, water: 1.0, soil: 0.0, age: 0 }
    }

    pub(super) fn row(&self) -> usize {
        self.y as usize
    }

    /// The drop as seen from `rows` further down, on a map that wraps.
    pub(super) fn moved_up(self, rows: usize, plane: &Plane) -> Self {
        if rows == 0 {
            return self;
        }
        let y = self.y - rows as f64;
        Self { y: wrapped(if y < 0.0 { y + plane.height as f64 } else { y }, plane.height), ..self }
    }

    /// Takes [`Self::moved_up`] back.
    pub(super) fn moved_down(self, rows: usize, plane: &Plane) -> Self {
        self.moved_up((plane.height - rows) % plane.height, plane)
    }
}

/// A place that is at most one period out, on the map.
fn wrapped(place: f64, count: usize) -> f64 {
    let period = count as f64;
    let place = if place < 0.0 { place + period } else { place };
    // A place just below 0 rounds to the period.
    if place >= period { place - period } else { place }
}

/// Rows that a drop may be in.
pub(super) struct Band {
    /// The map's row that is the band's first.
    begin: usize,
    /// Rows of the band.
    rows: usize,
    /// Above, or below, the band is another one.
    cut: [bool; 2],
    /// The band is the whole of a map that wraps.
    whole: bool,
}

impl Band {
    pub(super) fn of(bands: &Bands, index: usize, plane: &Plane) -> Self {
        let [begin, end] = bands.rows_of(index);
        let whole = plane.wraps && bands.count() == 1;
        let cut = [begin > 0 || plane.wraps, end < bands.rows || plane.wraps].map(|cut| cut && !whole);
        Self { begin, rows: end - begin, cut, whole }
    }
}

/// The ground of a band.
pub(super) struct Soil<'a> {
    samples: &'a mut [f32],
    width: usize,
    wraps: bool,
    band: Band,
    pub(super) account: Account,
}

/// The cell that a drop is in: its four samples, and the place among them.
struct Cell {
    indices: [usize; 4],
    fx: f64,
    fy: f64,
}

impl Cell {
    fn weights(&self) -> [f64; 4] {
        let (gx, gy) = (1.0 - self.fx, 1.0 - self.fy);
        [gx * gy, self.fx * gy, gx * self.fy, self.fx * self.fy]
    }
}

impl<'a> Soil<'a> {
    pub(super) fn new(samples: &'a mut [f32], plane: &Plane, band: Band) -> Self {
        Self { samples, width: plane.width, wraps: plane.wraps, band, account: Account::default() }
    }

    /// Runs a drop to its end, or until it comes near a cut and has to wait.
    pub(super) fn run(&mut self, mut drop: Drop, tools: &Tools) -> Option<Drop> {
        // From here on rows count from the band's first.
        drop.y -= self.band.begin as f64;
        let waits = self.run_within(&mut drop, tools);
        drop.y += self.band.begin as f64;
        waits.then_some(drop)
    }

    /// Whether the drop has to wait.
    fn run_within(&mut self, drop: &mut Drop, tools: &Tools) -> bool {
        while drop.age < tools.lifetime {
            if self.is_near_a_cut(drop.y as usize, tools.reach) {
                return true;
            }
            let cell = self.cell(drop.x, drop.y);
            let (height, slope) = self.surface(&cell);
            let aim = [0, 1].map(|axis| drop.direction[axis] * INERTIA - slope[axis] * (1.0 - INERTIA));
            let length = (aim[0] * aim[0] + aim[1] * aim[1]).sqrt();
            if length < 1e-9 {
                break;
            }
            drop.direction = aim.map(|part| part / length);
            let (x, y) = (drop.x + drop.direction[0], drop.y + drop.direction[1]);
            let Some((x, y)) = self.on_the_map(x, y) else {
                self.account.carried_off += drop.soil;
                return false;
            };
            let ahead = self.surface(&self.cell(x, y)).0;
            let rise = ahead - height;
            self.trade(drop, &cell, [height, ahead], tools);
            (drop.x, drop.y) = (x, y);
            drop.speed_squared = (drop.speed_squared - rise * GRAVITY).max(0.0);
            drop.water *= REMAINING;
            drop.age += 1;
        }
        let cell = self.cell(drop.x, drop.y);
        self.settle(drop, &cell, drop.soil);
        false
    }

    /// Takes soil from the ground below a drop, or leaves some there. The heights are the drop's and that of where it goes.
    fn trade(&mut self, drop: &mut Drop, cell: &Cell, [height, ahead]: [f64; 2], tools: &Tools) {
        let rise = ahead - height;
        let capacity = (-rise).max(LEAST_SLOPE) * drop.speed_squared.sqrt() * drop.water * CAPACITY;
        if rise > 0.0 {
            // Fills the hollow that it came through.
            self.settle(drop, cell, rise.min(drop.soil));
        } else if drop.soil > capacity {
            self.settle(drop, cell, (drop.soil - capacity) * SETTLING);
        } else {
            // No deeper than where the drop goes, or it would dig a hole.
            let amount = ((capacity - drop.soil) * tools.strength).min(-rise);
            self.dig(drop, amount, ahead, tools);
        }
    }

    fn settle(&mut self, drop: &mut Drop, cell: &Cell, amount: f64) {
        for (&index, weight) in cell.indices.iter().zip(cell.weights()) {
            self.samples[index] = (f64::from(self.samples[index]) + amount * weight) as f32;
        }
        drop.soil -= amount;
        self.account.deposited += amount;
    }

    /// Takes soil from around a drop, but none below `floor`: or drops that leave over the border would undermine it without
    /// end, as none settles there.
    fn dig(&mut self, drop: &mut Drop, amount: f64, floor: f64, tools: &Tools) {
        let (column, row) = (drop.x as isize, drop.y as isize);
        let mut taken = 0.0;
        for &(x, y, weight) in &tools.brush {
            // Beyond the map's border there is nothing to take.
            let Some(index) = self.index(column + x, row + y) else { continue };
            let height = f64::from(self.samples[index]);
            let part = (amount * weight).min(height - floor).max(0.0);
            self.samples[index] = (height - part) as f32;
            taken += part;
        }
        drop.soil += taken;
        self.account.eroded += taken;
    }

    fn is_near_a_cut(&self, row: usize, reach: usize) -> bool {
        let [above, below] = self.band.cut;
        (above && row < reach) || (below && row + reach + 1 >= self.band.rows)
    }

    /// The place on the map that a step leads to, unless it leads over the border.
    fn on_the_map(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        if self.wraps {
            return Some((wrapped(x, self.width), if self.band.whole { wrapped(y, self.band.rows) } else { y }));
        }
        // A drop has stopped long before it gets over a cut.
        let is_north_of_border = self.band.cut[1] || y < (self.band.rows - 1) as f64;
        (x >= 0.0 && x < (self.width - 1) as f64 && y >= 0.0 && is_north_of_border).then_some((x, y))
    }

    /// The index of a sample, if the map has it.
    fn index(&self, column: isize, row: isize) -> Option<usize> {
        let fold = |place: isize, count: usize, wraps: bool| {
            let count = count as isize;
            let place = if wraps { place.rem_euclid(count) } else { place };
            (0..count).contains(&place).then_some(place as usize)
        };
        let (column, row) = (fold(column, self.width, self.wraps)?, fold(row, self.band.rows, self.band.whole)?);
        Some(row * self.width + column)
    }

    /// The cell around a place on the map.
    fn cell(&self, x: f64, y: f64) -> Cell {
        let next = |place: usize, count: usize, wraps: bool| {
            if place + 1 < count {
                place + 1
            } else if wraps {
                0
            } else {
                place
            }
        };
        let (column, row) = ((x as usize).min(self.width - 1), (y as usize).min(self.band.rows - 1));
        let right = next(column, self.width, self.wraps);
        let below = next(row, self.band.rows, self.band.whole);
        let (top, bottom) = (row * self.width, below * self.width);
        let indices = [top + column, top + right, bottom + column, bottom + right];
        Cell { indices, fx: x - column as f64, fy: y - row as f64 }
    }

    /// Height and slope of the bilinear surface.
    fn surface(&self, cell: &Cell) -> (f64, [f64; 2]) {
        let [a, b, c, d] = cell.indices.map(|index| f64::from(self.samples[index]));
        let (fx, fy) = (cell.fx, cell.fy);
        let slope = [(b - a) * (1.0 - fy) + (d - c) * fy, (c - a) * (1.0 - fx) + (d - b) * fx];
        let [wa, wb, wc, wd] = cell.weights();
        (a * wa + b * wb + c * wc + d * wd, slope)
    }
}
