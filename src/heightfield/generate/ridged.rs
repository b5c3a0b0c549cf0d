//! The ridged multifractal of Musgrave ("Texturing and Modeling", 2nd edition 1998, chapter 14): crests over smooth
//! valleys.

use super::MakeError;
use super::lattice::octaves;
use super::plane::Plane;
use super::recipe::Recipe;
use super::work::Work;

/// Heights of no particular range.
pub(super) fn make(recipe: &Recipe, plane: &Plane, work: Work<'_>) -> Result<Vec<f32>, MakeError> {
    let octaves = octaves(recipe, plane, 0);
    let ridges = recipe.ridges;
    plane.rows(work, |row, samples| {
        let (mut noise, mut weights) = (vec![0.0; plane.width], vec![1.0; plane.width]);
        let mut sum = vec![0.0; plane.width];
        for octave in &octaves {
            octave.lattice.row(row, &mut noise);
            for ((noise, weight), sum) in noise.iter().zip(&mut weights).zip(&mut sum) {
                let crest: f64 = ridges.offset - f64::abs(*noise).min(1.0);
                // Detail gathers on the crests of the octave before, and valleys stay smooth.
                let signal = crest * crest * *weight;
                *weight = f64::min(signal * ridges.gain, 1.0);
                *sum += octave.amplitude * signal;
            }
        }
        samples.iter_mut().zip(&sum).for_each(|(sample, &sum)| *sample = sum as f32);
    })
}
