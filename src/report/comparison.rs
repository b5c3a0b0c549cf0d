//! A picture of distances against the reference, pixel by pixel: what is missed, what is invented, and which
//! disagreements a ray of finite precision may have.

use rayon::prelude::*;

use crate::camera::Camera;
use crate::heightfield::reference::Surface;

/// The tangency band: a pixel is in it when rays this many pixels beside its own do not all agree with it on what they
/// meet. The GPU's rays are f32: along a silhouette it may rightly decide otherwise. A thousandth of a pixel is far
/// below what a picture shows.
pub const BAND_PIXELS: f64 = 1e-3;

/// What an f32 distance can resolve, as a share of it.
pub const RESOLUTION: f64 = 2.4e-7;

/// One picture against the reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Pixels that were compared.
    pub pixels: usize,
    /// Pixels where the reference hits.
    pub hits: usize,
    /// The reference hits and the picture does not, outside the band.
    pub missed: usize,
    /// The reverse.
    pub invented: usize,
    /// Both hit, but more than a cell apart, outside the band.
    pub astray: usize,
    /// Disagreements inside the band.
    pub tangent: usize,
    /// Sorted distance errors of common hits, world units.
    pub errors: Vec<f64>,
    /// Side of a cell in world units.
    pub cell: f64,
}

impl Comparison {
    /// Compares `actual`, the distances of a probe of `size` pixels, with the first hits of `surface`; `cell` is the
    /// side of a cell in world units.
    pub fn of(surface: &Surface<'_>, camera: &Camera, size: [u32; 2], actual: &[f32], cell: f64) -> Self {
        let expected = surface.distances(camera, size, &|_| {});
        let mut result = Self {
            pixels: expected.len(),
            hits: expected.iter().filter(|distance| distance.is_finite()).count(),
            cell,
            ..Self::default()
        };
        let verdict = |(index, (&expected, &actual)): (usize, (&f64, &f32))| {
            let pixel = [index as u32 % size[0], index as u32 / size[0]];
            Verdict::of(surface, camera, pixel, size, expected, f64::from(actual), cell)
        };
        let verdicts: Vec<_> = expected.par_iter().zip(actual).enumerate().map(verdict).collect();
        for verdict in verdicts {
            match verdict {
                Verdict::Sky => {}
                Verdict::Hit(error) => result.errors.push(error),
                Verdict::Astray(error) => {
                    result.astray += 1;
                    result.errors.push(error);
                }
                Verdict::Tangent => result.tangent += 1,
                Verdict::Missed => result.missed += 1,
                Verdict::Invented => result.invented += 1,
            }
        }
        result.errors.sort_by(f64::total_cmp);
        result
    }

    /// Error that a share (0..1) of the common hits does not exceed, in cells; 0 where there is none.
    pub fn quantile(&self, share: f64) -> f64 {
        let last = self.errors.len().saturating_sub(1) as f64;
        self.errors.get((last * share).round() as usize).map_or(0.0, |error| error / self.cell)
    }
}

/// What a pixel is.
enum Verdict {
    /// Sky in both.
    Sky,
    /// Ground in both, so far apart in world units.
    Hit(f64),
    /// The same, but more than a cell apart.
    Astray(f64),
    /// A disagreement inside the band.
    Tangent,
    Missed,
    Invented,
}

impl Verdict {
    fn of(
        surface: &Surface<'_>,
        camera: &Camera,
        [x, y]: [u32; 2],
        size: [u32; 2],
        expected: f64,
        actual: f64,
        cell: f64,
    ) -> Self {
        let error = (actual - expected).abs();
        // A distance that is no number is no ground that anyone could stand on.
        let hits = actual.is_finite();
        let far = expected.is_finite() && (error > cell + RESOLUTION * expected || !hits);
        if far && jumps_within_band(surface, camera, [x, y], size, actual, cell) {
            return Self::Tangent;
        }
        match (expected.is_finite(), hits) {
            (true, true) if far => Self::Astray(error),
            (true, true) => Self::Hit(error),
            (false, false) => Self::Sky,
            _ if surface.is_tangent(camera, x, y, size, BAND_PIXELS) => Self::Tangent,
            (true, false) => Self::Missed,
            (false, true) => Self::Invented,
        }
    }
}

/// Whether a ray within the band beside the pixel's own meets the ground within a cell of `actual`: the ray passes a
/// silhouette, and whether it meets the hill or what is behind it may rightly be decided otherwise.
fn jumps_within_band(
    surface: &Surface<'_>,
    camera: &Camera,
    [x, y]: [u32; 2],
    size: [u32; 2],
    actual: f64,
    cell: f64,
) -> bool {
    let near = |dx: f64, dy: f64| {
        let ray = camera.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy, size);
        let distance = surface.intersect(&ray).map_or(f64::INFINITY, |hit| hit.position.distance(camera.eye));
        distance == actual || (distance - actual).abs() < cell
    };
    [(-BAND_PIXELS, 0.0), (BAND_PIXELS, 0.0), (0.0, -BAND_PIXELS), (0.0, BAND_PIXELS)]
        .into_iter()
        .any(|(dx, dy)| near(dx, dy))
}
