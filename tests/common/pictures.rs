//! Comparing pictures.

use std::path::Path;

use image::{Rgba, RgbaImage};
use relief::render::Probe;

/// How different two pictures may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// Largest difference of a channel, 0..255, that does not count.
    pub(crate) channel: u8,
    /// Share of pixels, 0..1, that may differ by more.
    pub(crate) pixels: f64,
}

/// How different two pictures are.
#[derive(Clone, Debug)]
pub(crate) struct Difference {
    /// Pixels with a channel that differs by more than the tolerance.
    pub(crate) pixels: usize,
    /// Pixels compared.
    pub(crate) compared: usize,
    /// Largest difference of a channel.
    pub(crate) largest: u8,
    /// The differences, ten times as bright.
    pub(crate) picture: RgbaImage,
}

impl Difference {
    /// Compares channel by channel; an error where the sizes differ or there is nothing to compare.
    pub(crate) fn of(expected: &RgbaImage, actual: &RgbaImage, tolerance: Tolerance) -> Result<Self, String> {
        if expected.dimensions() != actual.dimensions() {
            return Err(format!("{:?} pixels, expected {:?}", actual.dimensions(), expected.dimensions()));
        }
        let compared = expected.pixels().len();
        if compared == 0 {
            return Err("nothing was compared".into());
        }
        let mut picture = RgbaImage::new(expected.width(), expected.height());
        let (mut pixels, mut largest) = (0, 0);
        for ((a, b), difference) in expected.pixels().zip(actual.pixels()).zip(picture.pixels_mut()) {
            let channels: [u8; 4] = std::array::from_fn(|channel| a.0[channel].abs_diff(b.0[channel]));
            let most = channels.into_iter().max().unwrap_or(0);
            pixels += usize::from(most > tolerance.channel);
            largest = largest.max(most);
            let [red, green, blue] = [0, 1, 2].map(|channel| channels[channel].saturating_mul(10));
            *difference = Rgba([red, green, blue, 255]);
        }
        Ok(Self { pixels, compared, largest, picture })
    }

    /// Whether few enough pixels differ.
    pub(crate) fn is_within(&self, tolerance: Tolerance) -> bool {
        self.pixels as f64 <= tolerance.pixels * self.compared as f64
    }
}

/// Compares `actual` with the picture in `folder`. Where they differ, or there is none, `NAME.actual.png` and
/// `NAME.diff.png` are left beside it; where they agree, none are.
pub(crate) fn compare_with_golden(
    folder: &Path,
    name: &str,
    actual: &RgbaImage,
    tolerance: Tolerance,
) -> Result<Difference, String> {
    let file = |suffix: &str| folder.join(format!("{name}{suffix}.png"));
    let (actual_file, difference_file) = (file(".actual"), file(".diff"));
    for stale in [&actual_file, &difference_file] {
        // There is none after a run that went well.
        let _ = std::fs::remove_file(stale);
    }
    let keep = |picture: &RgbaImage, path: &Path| {
        picture.save(path).unwrap_or_else(|error| panic!("{} cannot be written: {error}", path.display()));
    };
    let golden = match image::open(file("")) {
        Ok(golden) => golden.to_rgba8(),
        Err(error) => {
            keep(actual, &actual_file);
            return Err(format!("no golden image: {error}"));
        }
    };
    match Difference::of(&golden, actual, tolerance) {
        Ok(difference) if difference.is_within(tolerance) => Ok(difference),
        Ok(difference) => {
            keep(actual, &actual_file);
            keep(&difference.picture, &difference_file);
            Err(format!(
                "{} of {} pixels differ by more than {} (at most {})",
                difference.pixels, difference.compared, tolerance.channel, difference.largest
            ))
        }
        Err(reason) => {
            keep(actual, &actual_file);
            Err(reason)
        }
    }
}

/// For every pixel whether two pictures differ in it at all.
pub(crate) fn changed(a: &RgbaImage, b: &RgbaImage) -> Vec<bool> {
    assert_eq!(a.dimensions(), b.dimensions());
    a.pixels().zip(b.pixels()).map(|(a, b)| a != b).collect()
}

/// For every pixel whether it shows the sky.
pub(crate) fn sky(probe: &Probe) -> Vec<bool> {
    probe.distance.iter().map(|distance| distance.is_infinite()).collect()
}

/// How many are set.
pub(crate) fn count(mask: &[bool]) -> usize {
    mask.iter().filter(|&&set| set).count()
}

/// The share that is set, 0..1.
pub(crate) fn share(mask: &[bool]) -> f64 {
    count(mask) as f64 / mask.len() as f64
}
