//! Fractional Brownian motion of gradient noise (Perlin 1985, 2002; Musgrave 1993): rolling hills.
//!
//! With the roughness r and the lacunarity l, the Hurst exponent is H = −log r / log l: the radially averaged power density
//! falls with the frequency to the power of −β, β = 2 H + 2.

use super::MakeError;
use super::lattice::octaves;
use super::plane::Plane;
use super::recipe::Recipe;
use super::work::Work;

/// Heights of no particular range.
pub(super) fn make(recipe: &Recipe, plane: &Plane, work: Work<'_>) -> Result<Vec<f32>, MakeError> {
    let octaves = octaves(recipe, plane, 0);
    plane.rows(work, |row, samples| {
        let (mut noise, mut sum) = (vec![0.0; plane.width], vec![0.0; plane.width]);
        for octave in &octaves {
            octave.lattice.row(row, &mut noise);
            sum.iter_mut().zip(&noise).for_each(|(sum, noise)| *sum += octave.amplitude * noise);
        }
        samples.iter_mut().zip(&sum).for_each(|(sample, &sum)| *sample = sum as f32);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::generate::Kind;
    use std::sync::atomic::AtomicBool;

    /// Mean and variance of many cells.
    fn moments(recipe: &Recipe) -> (f64, f64) {
        let (cancel, progress) = (AtomicBool::new(false), |_| {});
        let plane = Plane::of([513; 2], false);
        let heights = make(recipe, &plane, Work::new(&progress, &cancel)).unwrap();
        let mean_of =
            |of: &dyn Fn(f64) -> f64| heights.iter().map(|&h| of(h.into())).sum::<f64>() / heights.len() as f64;
        let mean = mean_of(&|height| height);
        (mean, mean_of(&|height| (height - mean).powi(2)))
    }

    /// A corner at the distance d adds w² d² to the variance at a place: w is the corner's weight, its direction is any,
    /// and the noise is scaled by √2. Octaves have nothing in common, so their variances add.
    #[test]
    fn mean_and_variance_are_those_of_the_gradients() {
        let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let places = (0..200).flat_map(|y| (0..200).map(move |x| ((x as f64 + 0.5) / 200.0, (y as f64 + 0.5) / 200.0)));
        // All four corners add alike, by symmetry.
        let corner = |(x, y): (f64, f64)| ((1.0 - fade(x)) * (1.0 - fade(y))).powi(2) * (x * x + y * y);
        let noise = 4.0 * places.map(corner).sum::<f64>() / 40_000.0;
        for (octaves, roughness) in [(1, 0.5), (4, 0.5), (3, 0.7)] {
            let recipe = Recipe { octaves: Some(octaves), roughness, scale: 60.0, ..Recipe::new(Kind::Perlin, 3) };
            let expected: f64 = (0..octaves).map(|octave| noise * roughness.powi(2 * octave as i32)).sum();
            let (mean, variance) = moments(&recipe);
            assert!(mean.abs() < 0.02, "{octaves}: {mean}");
            assert!((variance / expected - 1.0).abs() < 0.05, "{octaves}: {variance}, not {expected}");
        }
    }
}
