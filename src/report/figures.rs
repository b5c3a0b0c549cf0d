//! How wrong a picture's distances are: every figure of the report, with its formula.
//!
//! A picture is a slice of distances from the eye along each pixel's ray, in world units, row 0 at the top, `+inf` for
//! sky. What is measured is compared with the reference pixel by pixel. All shares are percentages of all pixels.

use serde::Serialize;

/// A pixel is out of line with its neighbours when its distance differs from their median by more than this share of
/// the median. Smooth ground is in line at any slope: of a ramp's 3×3 pixels, the one in the middle is the median.
pub const INCOHERENT_SHARE: f64 = 0.01;

/// A hit that is farther than this many cells from the reference's is a wrong pixel.
pub const WRONG_CELLS: f64 = 1.0;

/// The figures of one picture against the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// 100 · |{reference hits, picture is sky}| / |pixels|.
    pub see_through: f64,
    /// 100 · |{reference is sky, picture hits}| / |pixels|.
    pub covers_sky: f64,
    /// Median of |d − d_ref| / cell over the pixels where both hit; 0 where there is none. See [`nearest_rank`].
    pub p50: f64,
    /// The same, 95th percentile.
    pub p95: f64,
    /// The same, 99th percentile.
    pub p99: f64,
    /// The same, largest.
    pub max: f64,
    /// Pixels that are out of line with their neighbours where the reference is not; see [`incoherent`].
    pub incoherent: f64,
    /// Wrong pixels: see-through, covered sky, and hits off by more than [`WRONG_CELLS`], 100 · count / |pixels|.
    pub wrong: f64,
}

impl Figures {
    /// Compares `picture` with `reference`; `cell` is the side of a cell in world units. Pictures of different sizes
    /// are compared as far as both go.
    pub fn of<T: Copy + Into<f64>>(reference: &[f64], picture: &[T], size: [u32; 2], cell: f64) -> Self {
        let picture: Vec<f64> = picture.iter().map(|&distance| distance.into()).collect();
        let (mut see_through, mut covers_sky, mut off) = (0usize, 0usize, 0usize);
        let mut errors = Vec::with_capacity(reference.len());
        for (&expected, &actual) in reference.iter().zip(&picture) {
            match (expected.is_finite(), actual.is_finite()) {
                (true, true) => {
                    let error = (actual - expected).abs() / cell;
                    off += usize::from(error > WRONG_CELLS);
                    errors.push(error);
                }
                (true, false) => see_through += 1,
                (false, true) => covers_sky += 1,
                (false, false) => {}
            }
        }
        errors.sort_by(f64::total_cmp);
        let percent = |count: usize| 100.0 * count as f64 / reference.len().max(1) as f64;
        let rank = |percent| nearest_rank(&errors, percent).unwrap_or(0.0);
        Self {
            see_through: percent(see_through),
            covers_sky: percent(covers_sky),
            p50: rank(50),
            p95: rank(95),
            p99: rank(99),
            max: rank(100),
            incoherent: incoherent(reference, &picture, size),
            wrong: percent(see_through + covers_sky + off),
        }
    }
}

/// The percentile of sorted values by nearest rank: the smallest value that at least `percent` of the values do not
/// exceed. With n values it is number ⌈n · percent / 100⌉, counted from 1, and so always a value that occurred.
pub fn nearest_rank(sorted: &[f64], percent: usize) -> Option<f64> {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.saturating_sub(1)).copied()
}

/// Percentage of pixels that are out of line in `picture` but not in `reference`.
///
/// A pixel is out of line when its distance d and the median m of its 3×3 neighbourhood (itself included, fewer at the
/// border, the lower median of an even number; sky counts as +inf) do not agree: one is sky and the other not, or
/// |d − m| > [`INCOHERENT_SHARE`] · m. That is a speck: ridges thinner than a pixel are specks of the reference, too, so
/// only those count that the reference has not in the same place. A wrong picture whose pixels agree with each other,
/// such as one seen from elsewhere, has none.
pub fn incoherent(reference: &[f64], picture: &[f64], size: [u32; 2]) -> f64 {
    let pixels = reference.len().min(picture.len());
    let specks = (0..pixels).filter(|&at| is_speck(picture, at, size) && !is_speck(reference, at, size));
    100.0 * specks.count() as f64 / pixels.max(1) as f64
}

fn is_speck(picture: &[f64], at: usize, [width, height]: [u32; 2]) -> bool {
    let (width, height) = (width.max(1) as usize, height as usize);
    let (x, y) = (at % width, at / width);
    let mut around = [f64::INFINITY; 9];
    let mut count = 0;
    for row in y.saturating_sub(1)..(y + 2).min(height) {
        for column in x.saturating_sub(1)..(x + 2).min(width) {
            if let (Some(&distance), Some(slot)) = (picture.get(row * width + column), around.get_mut(count)) {
                *slot = distance;
                count += 1;
            }
        }
    }
    let around = &mut around[..count];
    around.sort_by(f64::total_cmp);
    let (Some(&own), Some(&median)) = (picture.get(at), around.get(count.saturating_sub(1) / 2)) else { return false };
    match (own.is_finite(), median.is_finite()) {
        (true, true) => (own - median).abs() > INCOHERENT_SHARE * median,
        (own, median) => own != median,
    }
}

/// Mean FLIP (Andersson et al. 2020) of two pictures of three bytes a pixel (sRGB), 0 for the same to 1 for the
/// greatest difference that there is, seen from where a degree of the eye is 67 pixels wide (a 4K screen of 0.7 m from
/// 0.7 m away). `None` where the sizes do not fit.
pub fn flip(reference: &image::RgbImage, picture: &image::RgbImage) -> Option<f64> {
    if reference.dimensions() != picture.dimensions() || reference.is_empty() {
        return None;
    }
    let (width, height) = reference.dimensions();
    let of = |image: &image::RgbImage| nv_flip::FlipImageRgb8::with_data(width, height, image.as_raw());
    let map = nv_flip::flip(of(reference), of(picture), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec();
    Some(map.iter().map(|&error| f64::from(error)).sum::<f64>() / map.len().max(1) as f64)
}

#[cfg(test)]
#[path = "figures_tests.rs"]
mod tests;
