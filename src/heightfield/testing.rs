//! Random maps for the unit tests of this folder.

use super::HeightField;
use super::generate::hash;

/// A reproducible sequence of numbers.
pub(super) struct Numbers {
    seed: u64,
    count: u32,
}

impl Numbers {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, count: 0 }
    }

    /// 0 to below 1.
    pub(super) fn unit(&mut self) -> f64 {
        self.count += 1;
        hash(self.seed, 0, self.count, 0) as f64 / 2f64.powi(64)
    }

    /// Between two numbers.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// 0 to below `end`.
    pub(super) fn below(&mut self, end: u32) -> u32 {
        (self.unit() * f64::from(end)) as u32
    }
}

/// A map of white noise.
pub(super) fn random_field(width: u32, height: u32, seed: u64) -> HeightField {
    let mut numbers = Numbers::new(seed);
    let raw: Vec<f64> = (0..width * height).map(|_| numbers.unit()).collect();
    HeightField::from_raw(width, height, &raw).unwrap()
}
