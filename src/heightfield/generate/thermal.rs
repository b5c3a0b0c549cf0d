//! Thermal erosion: what is steeper than the talus angle slides down to its neighbours (Musgrave, Kolb, Mace 1989; Olsen,
//! "Realtime procedural terrain generation", 2004, §3.1).
//!
//! Each sample trades with its eight neighbours what their slope exceeds the talus by, all at once: what one gives the
//! other takes, to the bit, so material is kept. The shares are small enough for the step to be monotone (a higher
//! landscape stays higher everywhere), and a monotone step that looks the same at every place lets no slope between
//! neighbours grow steeper than the steepest was. Borders mirror, or wrap, so that this holds at them, too.

use super::MakeError;
use super::plane::Plane;
use super::recipe::Thermal;
use super::work::Work;

/// Weight of a diagonal neighbour: its slope is that of a way √2 long, and so is its share of the circle.
const DIAGONAL: f32 = 0.5;

/// All weights of the neighbours of a sample.
const WEIGHTS: f32 = 4.0 + 4.0 * DIAGONAL;

/// Lets `heights`, in distances of samples, slide.
pub(super) fn erode(heights: &mut Vec<f32>, plane: &Plane, thermal: &Thermal, work: Work<'_>) -> Result<(), MakeError> {
    if thermal.iterations == 0 {
        return Ok(());
    }
    let slide = Slide {
        share: thermal.strength as f32 / WEIGHTS,
        talus: thermal.talus as f32,
        diagonal_talus: (thermal.talus * std::f64::consts::SQRT_2) as f32,
    };
    let mut after = vec![0.0; heights.len()];
    for iteration in 0..thermal.iterations {
        work.check()?;
        let [_, this, _] = work.split([iteration as f32, 1.0, (thermal.iterations - iteration - 1) as f32]);
        plane.fill_rows(&mut after, this, |y, row| {
            let line = |y: usize| &heights[y * plane.width..][..plane.width];
            let [above, below] = plane.beside(y).map(line);
            slide.row([above, line(y), below], plane.wraps, row);
        })?;
        std::mem::swap(heights, &mut after);
    }
    Ok(())
}

/// What slides in one step.
struct Slide {
    /// Of an excess that goes to one neighbour.
    share: f32,
    /// Rise over run at which material rests.
    talus: f32,
    /// The same over the distance to a diagonal neighbour.
    diagonal_talus: f32,
}

impl Slide {
    /// A row from itself and its neighbours.
    fn row(&self, lines: [&[f32]; 3], wraps: bool, row: &mut [f32]) {
        let width = row.len();
        for end in [0, width - 1] {
            let [left, right] = super::plane::neighbours(end, width, wraps);
            row[end] = self.sample(lines.map(|line| [line[left], line[end], line[right]]));
        }
        let [above, middle, below] = lines.map(|line| line.windows(3));
        let inner = row.iter_mut().skip(1).zip(above.zip(middle.zip(below)));
        for (height, (above, (middle, below))) in inner {
            *height = self.sample([above, middle, below].map(|line| [line[0], line[1], line[2]]));
        }
    }

    /// The middle one of 3×3 samples after the step.
    fn sample(&self, [above, middle, below]: [[f32; 3]; 3]) -> f32 {
        let height = middle[1];
        let excess = |neighbour: f32, talus: f32| {
            let rise = neighbour - height;
            // What is left of the rise when the talus is taken off it: odd, so both sides name the same amount.
            rise - rise.clamp(-talus, talus)
        };
        let straight = [above[1], middle[0], middle[2], below[1]];
        let diagonal = [above[0], above[2], below[0], below[2]];
        let sum = |neighbours: [f32; 4], talus: f32| neighbours.into_iter().map(|n| excess(n, talus)).sum::<f32>();
        height + self.share * (sum(straight, self.talus) + DIAGONAL * sum(diagonal, self.diagonal_talus))
    }
}

#[cfg(test)]
#[path = "thermal_tests.rs"]
mod tests;
