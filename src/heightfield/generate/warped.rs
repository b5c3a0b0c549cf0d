//! Domain warping (Perlin 1985; Quílez, "Domain warping", 2002): a fractal read at places that two others displace, as if
//! rock had been folded.

use super::MakeError;
use super::lattice::{Octave, octaves};
use super::plane::Plane;
use super::recipe::Recipe;
use super::work::Work;

/// Streams of the fractals that displace, west–east and north–south; octaves count on from them.
const STREAMS: [u32; 2] = [1000, 2000];

/// Octaves that displace at most: finer ones only roughen, which the displaced fractal does by itself.
const FOLDS: usize = 4;

/// Heights of no particular range.
pub(super) fn make(recipe: &Recipe, plane: &Plane, work: Work<'_>) -> Result<Vec<f32>, MakeError> {
    let octaves_of_heights = octaves(recipe, plane, 0);
    let displacing = STREAMS.map(|stream| {
        let mut folds = octaves(recipe, plane, stream);
        folds.truncate(FOLDS);
        folds
    });
    // A strength of 1 displaces by about one cell of the coarsest octave.
    let cell = octaves_of_heights.first().map_or([0.0; 2], |octave| octave.lattice.cell_size());
    let reach = cell.map(|size| size * recipe.warp.strength);
    plane.rows(work, |row, samples| {
        let [east, south] = displacing.each_ref().map(|octaves| sum_along(octaves, row, plane.width));
        for ((column, sample), (east, south)) in samples.iter_mut().enumerate().zip(east.iter().zip(&south)) {
            let (x, y) = (column as f64 + reach[0] * east, row as f64 + reach[1] * south);
            let height = octaves_of_heights
                .iter()
                .fold(0.0, |sum, Octave { lattice, amplitude }| sum + amplitude * lattice.at(x, y));
            *sample = height as f32;
        }
    })
}

/// The fractal along a row.
fn sum_along(octaves: &[Octave], row: usize, width: usize) -> Vec<f64> {
    let (mut noise, mut sum) = (vec![0.0; width], vec![0.0; width]);
    for Octave { lattice, amplitude } in octaves {
        lattice.row(row, &mut noise);
        sum.iter_mut().zip(&noise).for_each(|(sum, noise)| *sum += amplitude * noise);
    }
    sum
}
