//! What a landscape's statistics are, against theory.
//!
//! A fractional Brownian surface with Hurst exponent H has a power density that falls with the frequency to the power of
//! −(2H + 2), and E |h(p + d) − h(p)|² grows with |d|^2H (Voss, in "The science of fractal images", 1988). A sum of octaves
//! with the roughness r and the lacunarity l has H = −log r / log l, as has midpoint displacement with l = 2.

use relief::heightfield::HeightField;
use relief::heightfield::generate::{Kind, Recipe};

use super::make;

/// Samples of the period that is transformed: a power of two.
const PERIOD: usize = 512;

/// In-place transform of 2ⁿ complex numbers (Cooley and Tukey 1965).
fn transform(values: &mut [[f64; 2]]) {
    let count = values.len();
    let bits = count.trailing_zeros();
    for index in 0..count {
        let reversed = index.reverse_bits() >> (usize::BITS - bits);
        if index < reversed {
            values.swap(index, reversed);
        }
    }
    let mut half = 1;
    while half < count {
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (index, (low, high)) in low.iter_mut().zip(high).enumerate() {
                let (sin, cos) = (-std::f64::consts::PI * index as f64 / half as f64).sin_cos();
                let turned = [high[0] * cos - high[1] * sin, high[0] * sin + high[1] * cos];
                *high = [low[0] - turned[0], low[1] - turned[1]];
                *low = [low[0] + turned[0], low[1] + turned[1]];
            }
        }
        half *= 2;
    }
}

/// Mean power of the rings of frequencies from k − ½ to k + ½ periods along the map, for k from 0.
fn radial_power(heights: &[f64]) -> Vec<f64> {
    let transposed = |values: &[[f64; 2]]| -> Vec<[f64; 2]> {
        (0..PERIOD * PERIOD).map(|place| values[place % PERIOD * PERIOD + place / PERIOD]).collect()
    };
    let mut values: Vec<[f64; 2]> = heights.iter().map(|&height| [height, 0.0]).collect();
    for _ in 0..2 {
        values.chunks_exact_mut(PERIOD).for_each(transform);
        values = transposed(&values);
    }
    let frequency = |place: usize| place.min(PERIOD - place) as f64;
    let mut rings = vec![(0.0, 0.0); PERIOD];
    for (place, [re, im]) in values.into_iter().enumerate() {
        let radius = frequency(place % PERIOD).hypot(frequency(place / PERIOD)).round() as usize;
        rings[radius].0 += re * re + im * im;
        rings[radius].1 += 1.0;
    }
    rings.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { 0.0 }).collect()
}

/// The heights of one period.
fn period(field: &HeightField) -> Vec<f64> {
    let at = |place: usize| f64::from(field.sample((place % PERIOD) as u32, (place / PERIOD) as u32));
    (0..PERIOD * PERIOD).map(at).collect()
}

/// Slope of the line through points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let (up, down) =
        points.iter().fold((0.0, 0.0), |(up, down), (x, y)| (up + (x - mx) * (y - my), down + (x - mx).powi(2)));
    up / down
}

/// How much two numbers of each pair go together, −1 to 1.
pub(super) fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let swapped: Vec<_> = pairs.iter().map(|&(a, b)| (b, a)).collect();
    let (there, back) = (slope(pairs), slope(&swapped));
    (there * back).sqrt() * there.signum()
}

/// The exponent β of the power density's fall between `least` and `most` periods along the map, over some seeds.
/// Octaves make the spectrum wavy; the line goes through the means of half octaves, so that all count the same.
fn spectral_exponent(recipe: &Recipe, least: f64, most: f64) -> f64 {
    let mut power = vec![0.0; PERIOD];
    for seed in 1..=4 {
        let recipe = Recipe { seed, tileable: true, ..recipe.clone() };
        let field = make(&recipe, [PERIOD as u32 + 1; 2]);
        power.iter_mut().zip(radial_power(&period(&field))).for_each(|(sum, power)| *sum += power);
    }
    let mut points = Vec::new();
    let mut from = least;
    while from < most {
        let to = from * std::f64::consts::SQRT_2;
        let ring = from.ceil() as usize..(to.ceil() as usize).min(PERIOD / 2);
        let logs = ring.clone().map(|k| ((k as f64).ln(), power[k].ln()));
        let sum = logs.fold((0.0, 0.0), |sum, log| (sum.0 + log.0, sum.1 + log.1));
        points.push((sum.0 / ring.len() as f64, sum.1 / ring.len() as f64));
        from = to;
    }
    -slope(&points)
}

/// 2H from how the mean squared difference grows with the distance, along rows and columns.
fn structure_exponent(recipe: &Recipe, distances: &[usize]) -> f64 {
    let mut sums = vec![0.0; distances.len()];
    for seed in 1..=4 {
        let recipe = Recipe { seed, tileable: true, ..recipe.clone() };
        let heights = period(&make(&recipe, [PERIOD as u32 + 1; 2]));
        for (sum, &distance) in sums.iter_mut().zip(distances) {
            for place in 0..PERIOD * PERIOD {
                let (x, y) = (place % PERIOD, place / PERIOD);
                let right = heights[y * PERIOD + (x + distance) % PERIOD];
                let below = heights[(y + distance) % PERIOD * PERIOD + x];
                *sum += (right - heights[place]).powi(2) + (below - heights[place]).powi(2);
            }
        }
    }
    let points: Vec<_> =
        distances.iter().zip(sums).map(|(&distance, sum)| ((distance as f64).ln(), sum.ln())).collect();
    slope(&points)
}

/// Mean, standard deviation and skewness of all heights over some seeds.
fn moments(recipe: &Recipe) -> [f64; 3] {
    let seeds = 1..=6;
    let heights: Vec<f64> =
        seeds.flat_map(|seed| period(&make(&Recipe { seed, ..recipe.clone() }, [513; 2]))).collect();
    let moment = |power: i32, centre: f64| {
        heights.iter().map(|height| (height - centre).powi(power)).sum::<f64>() / heights.len() as f64
    };
    let mean = moment(1, 0.0);
    let deviation = moment(2, mean).sqrt();
    [mean, deviation, moment(3, mean) / deviation.powi(3)]
}

#[test]
fn the_transform_finds_a_wave() {
    let wave = |place: usize| (std::f64::consts::TAU * (5 * (place % PERIOD)) as f64 / PERIOD as f64).cos();
    let power = radial_power(&(0..PERIOD * PERIOD).map(wave).collect::<Vec<_>>());
    let rest: f64 = power.iter().enumerate().filter(|&(k, _)| k != 5).map(|(_, power)| power).sum();
    assert!(power[5] > 1e6 && rest < 1e-9 * power[5], "{} {rest}", power[5]);
}

/// 8 to 128 periods along the map, within 0.15: above the coarsest octave's 4 cells, below what 16 bits and the samples
/// blur.
#[test]
fn the_spectrum_of_noise_falls_as_its_roughness_says() {
    for (roughness, lacunarity) in [(0.5, 2.0), (0.6, 2.0), (0.7, 2.0), (0.5, 1.7)] {
        let recipe = Recipe { roughness, lacunarity, scale: 4.0, ..Recipe::new(Kind::Perlin, 0) };
        let expected = 2.0 - 2.0 * f64::log(roughness, lacunarity);
        let found = spectral_exponent(&recipe, 8.0, 128.0);
        assert!(
            (found - expected).abs() < 0.15,
            "roughness {roughness}, lacunarity {lacunarity}: {found}, not {expected}"
        );
    }
}

/// Within 0.25: the creases along the coarse grids' lines (Miller 1986) add high frequencies.
#[test]
fn the_spectrum_of_midpoint_displacement_falls_as_its_roughness_says() {
    for roughness in [0.5, 0.6, 0.7] {
        let recipe = Recipe { roughness, ..Recipe::new(Kind::DiamondSquare, 0) };
        let expected = 2.0 - 2.0 * f64::log2(roughness);
        let found = spectral_exponent(&recipe, 8.0, 128.0);
        assert!((found - expected).abs() < 0.25, "roughness {roughness}: {found}, not {expected}");
    }
}

/// Over 2 to 32 samples, within 0.12: the octaves have ends, which flattens the largest differences.
#[test]
fn heights_differ_over_distances_as_the_hurst_exponent_says() {
    for kind in [Kind::Perlin, Kind::DiamondSquare] {
        for roughness in [0.6, 0.7, 0.8] {
            let recipe = Recipe { roughness, octaves: Some(12), ..Recipe::new(kind, 0) };
            let found = structure_exponent(&recipe, &[2, 4, 8, 16, 32]) / 2.0;
            let expected = -f64::log2(roughness);
            assert!((found - expected).abs() < 0.12, "{kind:?}, roughness {roughness}: {found}, not {expected}");
        }
    }
}

/// Sums of symmetric noise are symmetric about the middle. Where |noise| is small, and that is where it mostly is, crests
/// stand: heights pile up towards the top and leave a tail of valleys.
#[test]
fn heights_are_distributed_as_their_kind_says() {
    for kind in Kind::ALL {
        let [mean, deviation, skew] = moments(&Recipe { scale: 12.0, ..Recipe::new(kind, 0) });
        let is_expected = match kind {
            Kind::Perlin | Kind::Warped => skew.abs() < 0.15 && (mean - 0.5).abs() < 0.05,
            // Its coarsest heights are few.
            Kind::DiamondSquare => skew.abs() < 0.5 && (mean - 0.5).abs() < 0.15,
            Kind::Ridged => skew < -0.3 && mean > 0.5,
        };
        assert!(is_expected && (0.1..0.3).contains(&deviation), "{kind:?}: {mean} ± {deviation}, skew {skew}");
    }
}
