//! The smooth surface: the biquadratic B-spline whose control points are the map's samples.
//!
//! Its slope is continuous, where that of the bilinear patches breaks at each cell's border. It does not go through the
//! samples: along each axis it evens them out by 1/8, 3/4, 1/8. Between the middles of four cells it is one polynomial,
//! quadratic along each axis, of the 3×3 samples around; in a cell, which holds a quarter of four such squares, 4×4 samples
//! count. Beyond the border the nearest sample does.

use super::HeightField;

/// Weights of three samples at the place `u`, 0 to 1 around the middle one.
fn weights(u: f64) -> [f64; 3] {
    let (first, last) = (0.5 * (1.0 - u) * (1.0 - u), 0.5 * u * u);
    [first, 1.0 - first - last, last]
}

/// Height of the smooth surface of `field`, normalised, at a place in cells; clamped to the map.
pub fn height(field: &HeightField, x: f64, z: f64) -> f64 {
    let [columns, rows] = field.cells();
    let around = |at: f64, cells: u32| {
        let at = at.clamp(0.0, f64::from(cells));
        let middle = (at + 0.5).floor().min(f64::from(cells));
        (middle as u32, weights(at - middle + 0.5))
    };
    let ((i, across), (j, down)) = (around(x, columns), around(z, rows));
    let mut height = 0.0;
    for (row, weight_z) in (0..3).zip(down) {
        for (column, weight_x) in (0..3).zip(across) {
            height += weight_x * weight_z * f64::from(neighbour(field, i + column, j + row));
        }
    }
    height
}

/// The sample in a column and row that both count from −1; beyond the border, the nearest one.
fn neighbour(field: &HeightField, column: u32, row: u32) -> f32 {
    field.sample(column.saturating_sub(1), row.saturating_sub(1))
}

/// The first distance in `begin..=end` along the ray at which it is on or below the smooth surface, whose heights are
/// multiplied by `scale`, within a cell. `origin` and `direction` are in cells horizontally.
///
/// Between the middles of cells the ray's height over the surface is a polynomial of degree four. It is found by its values
/// at five places, and its first root between the roots of its derivative.
pub(super) fn first_meeting(
    field: &HeightField,
    scale: f64,
    origin: [f64; 3],
    direction: [f64; 3],
    [begin, end]: [f64; 2],
    cell: [u32; 2],
) -> Option<f64> {
    // Nowhere is the surface higher than the samples that it is made of.
    let lowest = (origin[1] + direction[1] * begin).min(origin[1] + direction[1] * end);
    let around = (0..4).flat_map(|row| (0..4).map(move |column| neighbour(field, cell[0] + column, cell[1] + row)));
    if lowest > scale * f64::from(around.fold(0.0, f32::max)) {
        return None;
    }
    let mut stops = vec![begin, end];
    for (axis, cell) in [(0, cell[0]), (2, cell[1])] {
        let middle = (f64::from(cell) + 0.5 - origin[axis]) / direction[axis];
        if middle > begin && middle < end {
            stops.push(middle);
        }
    }
    stops.sort_by(f64::total_cmp);
    stops.windows(2).find_map(|piece| {
        let (from, length) = (piece[0], piece[1] - piece[0]);
        let above = |share: f64| {
            let at = from + share * length;
            let place = [0, 1, 2].map(|axis| origin[axis] + direction[axis] * at);
            place[1] - scale * height_in(field, cell, [place[0], place[2]])
        };
        let values = [0.0, 0.25, 0.5, 0.75, 1.0].map(above);
        if values[0] <= 0.0 {
            return Some(from);
        }
        first_root(&through(values)).map(|share| from + share * length)
    })
}

/// [`height`] at a place that rounding may have put out of its cell.
fn height_in(field: &HeightField, cell: [u32; 2], place: [f64; 2]) -> f64 {
    let within = |at: f64, cell: u32| at.clamp(f64::from(cell), f64::from(cell) + 1.0);
    height(field, within(place[0], cell[0]), within(place[1], cell[1]))
}

/// Coefficients, constant first, of the polynomial of degree four with these values at 0, ¼, ½, ¾, 1.
fn through([a, b, c, d, e]: [f64; 5]) -> [f64; 5] {
    [
        a,
        (-25.0 * a + 48.0 * b - 36.0 * c + 16.0 * d - 3.0 * e) / 3.0,
        (70.0 * a - 208.0 * b + 228.0 * c - 112.0 * d + 22.0 * e) / 3.0,
        (-80.0 * a + 288.0 * b - 384.0 * c + 224.0 * d - 48.0 * e) / 3.0,
        (32.0 * a - 128.0 * b + 192.0 * c - 128.0 * d + 32.0 * e) / 3.0,
    ]
}

fn value(coefficients: &[f64], at: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * at + coefficient)
}

/// The places in 0..1 at which a polynomial changes its sign, in order.
fn roots(coefficients: &[f64]) -> Vec<f64> {
    if coefficients.len() < 2 {
        return Vec::new();
    }
    let derivative: Vec<f64> =
        coefficients.iter().enumerate().skip(1).map(|(power, coefficient)| power as f64 * coefficient).collect();
    let mut stops = vec![0.0];
    stops.extend(roots(&derivative));
    stops.push(1.0);
    let crossing = |piece: &[f64]| {
        let (mut low, mut high) = (piece[0], piece[1]);
        let sign = value(coefficients, low) > 0.0;
        if (value(coefficients, high) > 0.0) == sign {
            return None;
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if (value(coefficients, middle) > 0.0) == sign { low = middle } else { high = middle }
        }
        Some(high)
    };
    stops.windows(2).filter_map(crossing).collect()
}

fn first_root(coefficients: &[f64; 5]) -> Option<f64> {
    roots(coefficients).into_iter().next()
}

/// A height for a sample such that nowhere in a cell the smooth surface is higher than the highest of its four corners'.
///
/// In a quarter of a cell the surface lies below its Bézier points. Along one axis those are, with the samples a, b, c
/// around the middle one, (a + 6b + c) / 8 at the sample and means of b and c beside it: so the highest of a cell is at most
/// that of its four corners, where a corner counts as the highest of its own height and of what it is evened out to along
/// either axis and along both.
pub(super) fn bound(field: &HeightField, x: u32, y: u32) -> f64 {
    let at = |column: u32, row: u32| f64::from(neighbour(field, x + column, y + row));
    let even = |a: f64, b: f64, c: f64| 0.125 * (a + c) + 0.75 * b;
    let evened = |row: u32| even(at(0, row), at(1, row), at(2, row));
    let down = even(at(1, 0), at(1, 1), at(1, 2));
    let both = even(evened(0), evened(1), evened(2));
    at(1, 1).max(evened(1)).max(down).max(both)
}

#[cfg(test)]
mod tests {
    use super::super::SampleRect;
    use super::super::bounds::{Rule, SurfaceBounds};
    use super::super::testing::{Numbers, random_field};
    use super::*;

    const SMOOTH: Rule = Rule { smooth: true, detail: None };

    #[test]
    fn the_surface_and_its_slope_are_continuous() {
        let field = random_field(9, 7, 3);
        let mut numbers = Numbers::new(4);
        let step = 1e-6;
        for _ in 0..500 {
            // Across the borders of its polynomials, and those of cells.
            let x = 0.5 * f64::from(1 + numbers.below(15));
            let z = numbers.between(0.3, 5.7);
            let at = |dx: f64| height(&field, x + dx, z);
            assert!((at(step) - at(-step)).abs() < 4.0 * step);
            let (before, after) = ((at(0.0) - at(-step)) / step, (at(step) - at(0.0)) / step);
            assert!((before - after).abs() < 1e-4, "the slope breaks at {x}, {z}: {before}, {after}");
        }
        // Along a row without change it is the samples' own blend.
        let flat = HeightField::from_raw(3, 3, &[0.0f32, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        assert_eq!([0.0, 0.5, 1.0, 1.5].map(|x| height(&flat, x, 1.0)), [0.125, 0.5, 0.75, 0.5]);
    }

    #[test]
    fn bounds_lie_above_the_surface_and_not_far() {
        let mut numbers = Numbers::new(8);
        for field in [random_field(17, 12, 5), random_field(17, 12, 6).rounded_to_16_bits()] {
            let bounds = SurfaceBounds::new(&field, SMOOTH);
            let (mut above, mut samples) = (0.0, 0.0);
            for _ in 0..20_000 {
                let (x, z) = (numbers.between(0.0, 16.0), numbers.between(0.0, 11.0));
                let (i, j) = ((x as u32).min(15), (z as u32).min(10));
                let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
                let bound = corners.map(|(i, j)| bounds.bound(i, j)).into_iter().fold(0.0, f32::max);
                let surface = height(&field, x, z);
                assert!(surface <= f64::from(bound) + 1e-12, "{surface} at {x}, {z} above {bound}");
                above += f64::from(bound) - surface;
                samples +=
                    f64::from(corners.map(|(i, j)| field.sample(i, j)).into_iter().fold(0.0, f32::max)) - surface;
            }
            assert!(above < 1.1 * samples, "the bounds are little higher than the samples: {above}, {samples}");
        }
    }

    #[test]
    fn updated_bounds_are_those_of_a_fresh_build() {
        let mut numbers = Numbers::new(2);
        let mut field = random_field(41, 23, 7);
        let mut bounds = SurfaceBounds::new(&field, SMOOTH);
        for _ in 0..40 {
            let (x, y) = (numbers.below(41), numbers.below(23));
            let rect = SampleRect { x, y, width: 1 + numbers.below(41 - x), height: 1 + numbers.below(23 - y) };
            for (row, column) in
                (y..y + rect.height).flat_map(|row| (x..x + rect.width).map(move |column| (row, column)))
            {
                field.samples_mut()[(row * 41 + column) as usize] = numbers.unit() as f32;
            }
            bounds.update(&field, rect);
            let fresh = SurfaceBounds::new(&field, SMOOTH);
            assert_eq!(bounds.pyramid(), fresh.pyramid(), "{rect:?}");
        }
    }

    #[test]
    fn polynomials_are_found_by_their_values() {
        let known = [0.3, -1.2, 0.7, 2.0, -1.9];
        let found = through([0.0, 0.25, 0.5, 0.75, 1.0].map(|at| value(&known, at)));
        known.iter().zip(found).for_each(|(known, found)| assert!((known - found).abs() < 1e-12));
        // (x − 0.2)(x − 0.5)(x − 0.9)(x + 1)
        let found = roots(&[-0.09, 0.64, -0.87, -0.6, 1.0]);
        assert_eq!(found.len(), 3);
        [0.2, 0.5, 0.9].into_iter().zip(found).for_each(|(known, found)| assert!((known - found).abs() < 1e-9));
    }
}
