//! Gradient noise on a lattice (Perlin, "Improving noise", 2002), and the octaves that a fractal sums.
//!
//! The crates were looked at first. `noise` 0.9 has a permutation table of 256 entries, so that the fine octaves of a large
//! map repeat a hundred times along its side; seeds of 32 bits; tiles by blending four copies, which flattens the middle
//! and bends the spectrum; amplitudes by `powi`, whose last bits differ between platforms; and evaluates one point at a
//! time, on one thread. Here an integer hash takes the table's place: no period but the one that is asked for, seeds of
//! 64 bits, exact tiles, and rows that keep their cell's gradients.

use super::hash;
use super::plane::Plane;
use super::recipe::Recipe;

/// Noise of one frequency over a plane; about −1 to 1, and 0 on the lattice.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    seed: u64,
    /// What tells the randomness of this lattice from that of another with the same seed.
    stream: u32,
    /// Cells from one sample to the next, along a row and along a column.
    step: [f64; 2],
    /// Displacement in cells, so that the lattices of the octaves do not lie on each other.
    shift: [f64; 2],
    /// Cells after which the lattice repeats.
    period: Option<[i64; 2]>,
}

/// An octave of a fractal: its noise, and what it is multiplied with.
pub(super) struct Octave {
    pub(super) lattice: Lattice,
    pub(super) amplitude: f64,
}

/// The octaves of `recipe` on `plane`, coarse to fine. Fractals with another `stream` have nothing in common.
pub(super) fn octaves(recipe: &Recipe, plane: &Plane, stream: u32) -> Vec<Octave> {
    let count = recipe.octave_count(plane.longer_side() as u32 + 1);
    let (mut frequency, mut amplitude) = (1.0, 1.0);
    let octave = |index: u32| {
        let lattice = Lattice::new(recipe, plane, frequency, [stream, index]);
        let octave = Octave { lattice, amplitude };
        frequency *= recipe.lacunarity;
        amplitude *= recipe.roughness;
        octave
    };
    (0..count).map(octave).collect()
}

impl Lattice {
    /// `frequency` counts in the coarsest octave's.
    fn new(recipe: &Recipe, plane: &Plane, frequency: f64, [stream, octave]: [u32; 2]) -> Self {
        let longer = plane.longer_side();
        let (seed, stream, shift) = (recipe.seed, stream + octave, [0.37, 0.61].map(|part| part * f64::from(octave)));
        if !plane.wraps {
            let step = recipe.scale / longer * frequency;
            return Self { seed, stream, step: [step; 2], shift, period: None };
        }
        // A whole number of cells each way, or the last would not join the first.
        let sides = [plane.width as f64, plane.height as f64];
        let cells = sides.map(|side| (recipe.scale * frequency * (side / longer)).round().max(1.0));
        let step = [cells[0] / sides[0], cells[1] / sides[1]];
        Self { seed, stream, step, shift, period: Some(cells.map(|count| count as i64)) }
    }

    /// Samples from one lattice point to the next, along a row and along a column.
    pub(super) fn cell_size(&self) -> [f64; 2] {
        self.step.map(|step| 1.0 / step)
    }

    /// Position in cells of a place in samples.
    fn position(&self, axis: usize, place: f64) -> f64 {
        const BESIDE_THE_LATTICE: [f64; 2] = [0.5, 0.25];
        place * self.step[axis] + self.shift[axis] + BESIDE_THE_LATTICE[axis]
    }

    /// The noise along a row: `noise[i]` is that of column i.
    pub(super) fn row(&self, row: usize, noise: &mut [f64]) {
        let (j, fy) = split(self.position(1, row as f64));
        let v = fade(fy);
        let mut cell = None;
        let (mut left, mut right) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        for (column, noise) in noise.iter_mut().enumerate() {
            let (i, fx) = split(self.position(0, column as f64));
            if cell != Some(i) {
                left = if cell == Some(i - 1) { right } else { self.gradients(i, j) };
                right = self.gradients(i + 1, j);
                cell = Some(i);
            }
            *noise = blend(left, right, [fx, fy], v);
        }
    }

    /// The noise at any place, in samples.
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        let ((i, fx), (j, fy)) = (split(self.position(0, x)), split(self.position(1, y)));
        blend(self.gradients(i, j), self.gradients(i + 1, j), [fx, fy], fade(fy))
    }

    /// The gradients at (i, j) and (i, j + 1).
    fn gradients(&self, i: i64, j: i64) -> [[f64; 2]; 2] {
        [self.gradient(i, j), self.gradient(i, j + 1)]
    }

    /// One of 16 directions of length 1.
    fn gradient(&self, i: i64, j: i64) -> [f64; 2] {
        // Cosine and sine of 22.5° × 0, 1, 2 and 3, as constants: a library's sine may differ between platforms.
        const TURNS: [(f64, f64); 4] = [
            (1.0, 0.0),
            (0.923_879_532_511_286_7, 0.382_683_432_365_089_8),
            (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2),
            (0.382_683_432_365_089_8, 0.923_879_532_511_286_7),
        ];
        let [i, j] = self.period.map_or([i, j], |[across, down]| [i.rem_euclid(across), j.rem_euclid(down)]);
        let random = hash(self.seed, self.stream, i as u32, j as u32);
        let (cos, sin) = TURNS[(random & 3) as usize];
        match (random >> 2) & 3 {
            0 => [cos, sin],
            1 => [-sin, cos],
            2 => [-cos, -sin],
            _ => [sin, -cos],
        }
    }
}

/// The cell, and the place in it. A cast instead of `floor`, which is a call on processors without the instruction.
fn split(position: f64) -> (i64, f64) {
    let towards_zero = position as i64;
    let cell = if towards_zero as f64 > position { towards_zero - 1 } else { towards_zero };
    (cell, position - cell as f64)
}

/// Perlin's quintic: slope and curvature vanish on the lattice.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Blends what the gradients of the cell's left and right corners (each north, south) say of a place in it; `v` is its
/// faded second coordinate.
fn blend(left: [[f64; 2]; 2], right: [[f64; 2]; 2], [fx, fy]: [f64; 2], v: f64) -> f64 {
    let ramp = |gradient: [f64; 2], x: f64, y: f64| gradient[0] * x + gradient[1] * y;
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let u = fade(fx);
    let north = mix(ramp(left[0], fx, fy), ramp(right[0], fx - 1.0, fy), u);
    let south = mix(ramp(left[1], fx, fy - 1.0), ramp(right[1], fx - 1.0, fy - 1.0), u);
    mix(north, south, v) * std::f64::consts::SQRT_2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::generate::Kind;

    #[test]
    fn a_row_is_what_its_points_are() {
        for tileable in [false, true] {
            let recipe = Recipe { tileable, ..Recipe::new(Kind::Perlin, 5) };
            let plane = Plane::of([97, 65], tileable);
            for octave in octaves(&recipe, &plane, 0) {
                let mut row = vec![0.0; plane.width];
                octave.lattice.row(33, &mut row);
                for (column, &noise) in row.iter().enumerate() {
                    assert_eq!(noise, octave.lattice.at(column as f64, 33.0));
                }
            }
        }
    }

    #[test]
    fn a_lattice_is_split_below_zero_too() {
        assert_eq!(split(2.25), (2, 0.25));
        assert_eq!(split(-2.25), (-3, 0.75));
        assert_eq!((split(-2.0), split(0.0)), ((-2, 0.0), (0, 0.0)));
    }

    /// One period to the side, the noise is the same but for the rounding of the place.
    #[test]
    fn a_tileable_lattice_repeats() {
        let recipe = Recipe { tileable: true, scale: 5.0, ..Recipe::new(Kind::Perlin, 5) };
        let plane = Plane::of([101, 51], true);
        for octave in octaves(&recipe, &plane, 0).iter().take(6) {
            for (x, y) in [(3.3, 4.7), (0.0, 0.0), (99.9, 49.9), (-7.5, 20.0)] {
                let difference = octave.lattice.at(x, y) - octave.lattice.at(x + 100.0, y - 50.0);
                assert!(difference.abs() < 1e-9, "{difference}");
            }
        }
    }
}
