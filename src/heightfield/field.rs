//! The height map in memory: normalised samples and what they stand for.

mod meaning;

use std::sync::Arc;

use rayon::prelude::*;

use super::holes::{self, HoleMask, Holes};
use super::import::Georeference;
pub(crate) use meaning::{EXAGGERATIONS, HEIGHT_SCALES};
pub(super) use meaning::{EXTENT_RATIOS, PLAIN_HEIGHT_SCALE};

/// Why samples are not a height map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HeightFieldError {
    /// No cell: a surface needs two samples each way.
    #[error("a height map of {width}×{height} samples has no surface\n  it needs at least 2×2\n  use a larger one")]
    TooSmall {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Width times height is not the number of samples.
    #[error(
        "{width}×{height} samples were announced, but there are {count}\n  each place in the grid has one\n  give width × height of them"
    )]
    WrongCount {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Samples there are.
        count: usize,
    },
    /// A sample is NaN or infinite.
    #[error(
        "the sample in column {column}, row {row} is not a finite number\n  the surface has a height everywhere\n  fill gaps in the data first"
    )]
    NotFinite {
        /// Column of the first such sample.
        column: u32,
        /// Its row.
        row: u32,
    },
    /// Nothing but holes.
    #[error(
        "none of the {width}×{height} samples holds a height\n  all are nodata or no finite numbers\n  \
         check which number stands for nodata, or choose another part, band or file"
    )]
    AllHoles {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
}

/// A height map: `width` × `height` samples, row 0 in the north, normalised so that the lowest is 0 and the highest 1.
///
/// Samples stand on the corners of a grid of (width − 1) × (height − 1) cells; the surface between them is their
/// bilinear interpolation. A sample can be a hole, which holds no height; a cell with one at a corner has no ground.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// Columns, at least 2.
    width: u32,
    /// Rows, at least 2.
    height: u32,
    samples: Vec<f32>,
    /// Samples are whole multiples of 1/`units`; absent where they are not, or where 16 bits do not hold them.
    units: Option<u16>,
    /// What the normalised heights 0 and 1 stand for, in the source's own unit (metres, where it has one).
    range: [f64; 2],
    /// Horizontal extent west–east and north–south in metres, where it is known.
    extent_metres: Option<[f64; 2]>,
    /// Factor on the true proportion, 1 unless the map asks for another.
    exaggeration: f64,
    /// The samples that hold no height and are cut out; absent where all hold one.
    holes: Option<Arc<HoleMask>>,
    /// Where the samples lie in a reference system, where that is known.
    georeference: Option<Arc<Georeference>>,
    /// The range is known to be in metres, even where the extent is not.
    metric: bool,
}

impl HeightField {
    /// Normalises `raw` (row by row, north first) to 0..1. A flat map becomes all 0; its range keeps the one value. A
    /// height too little above the lowest for single precision is 0, too.
    ///
    /// # Errors
    /// [`HeightFieldError`] for a grid without a cell, a wrong number of samples, and one that is NaN or infinite.
    pub fn from_raw<T>(width: u32, height: u32, raw: &[T]) -> Result<Self, HeightFieldError>
    where
        T: Copy + Into<f64> + Sync,
    {
        Self::from_raw_with_holes(width, height, raw, None)
    }

    /// Like [`Self::from_raw`], for a map with holes: what stands there is not looked at, and does not count for the
    /// range. They are cut out ([`Self::with_hole_policy`] does otherwise), and as low as the lowest sample in
    /// [`Self::samples`].
    ///
    /// # Errors
    /// As [`Self::from_raw`]; [`HeightFieldError::AllHoles`] where nothing is left, and
    /// [`HeightFieldError::WrongCount`] for a mask of another size.
    pub fn from_raw_with_holes<T>(
        width: u32,
        height: u32,
        raw: &[T],
        holes: Option<HoleMask>,
    ) -> Result<Self, HeightFieldError>
    where
        T: Copy + Into<f64> + Sync,
    {
        if width < 2 || height < 2 {
            return Err(HeightFieldError::TooSmall { width, height });
        }
        if raw.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(HeightFieldError::WrongCount { width, height, count: raw.len() });
        }
        let holes = holes.filter(|holes| holes.count() > 0);
        if let Some(holes) = &holes {
            if [holes.width(), holes.height()] != [width, height] {
                return Err(HeightFieldError::WrongCount { width, height, count: raw.len() });
            }
            if holes.count() == raw.len() as u64 {
                return Err(HeightFieldError::AllHoles { width, height });
            }
        }
        let is_hole = |index: usize| holes.as_ref().is_some_and(|holes| holes.contains(index));
        let bad = |(index, value): (usize, &T)| !(*value).into().is_finite() && !is_hole(index);
        if let Some(index) = raw.par_iter().enumerate().position_first(bad) {
            let (column, row) = (index % width as usize, index / width as usize);
            return Err(HeightFieldError::NotFinite { column: column as u32, row: row as u32 });
        }
        let nothing = (f64::INFINITY, f64::NEG_INFINITY, true);
        let (low, high, whole) = raw
            .par_iter()
            .enumerate()
            .map(|(index, &value)| {
                let value: f64 = value.into();
                if is_hole(index) { nothing } else { (value, value, value.fract() == 0.0) }
            })
            .reduce(|| nothing, |a, b| (a.0.min(b.0), a.1.max(b.1), a.2 && b.2));
        // Halved, because the span of two finite numbers need not be finite.
        let half_span = high * 0.5 - low * 0.5;
        let normalise = |(index, &value): (usize, &T)| {
            let above = value.into() * 0.5 - low * 0.5;
            if half_span > 0.0 && !is_hole(index) { normalised(above / half_span) } else { 0.0 }
        };
        let samples = raw.par_iter().enumerate().map(normalise).collect();
        let units = if whole { units_for(high - low) } else { None };
        let holes = holes.map(Arc::new);
        Ok(Self {
            width,
            height,
            samples,
            units,
            range: [low, high],
            extent_metres: None,
            exaggeration: 1.0,
            holes,
            georeference: None,
            metric: false,
        })
    }

    /// The map with its holes treated so; only those that are still cut out can be. Filled ones are heights like any
    /// other afterwards.
    #[must_use]
    pub fn with_hole_policy(mut self, policy: Holes) -> Self {
        match policy {
            Holes::CutOut => return self,
            // They are as low as that already.
            Holes::Floor => {}
            Holes::Fill => {
                if let Some(mask) = &self.holes {
                    holes::fill(&mut self.samples, mask);
                    for index in mask.indices() {
                        self.samples[index] = Self::nearest_height(self.units, f64::from(self.samples[index]));
                    }
                }
            }
        }
        self.holes = None;
        self
    }

    /// The samples that hold no height; `None` where all do.
    pub fn holes(&self) -> Option<&HoleMask> {
        self.holes.as_deref()
    }

    /// Whether the sample in a column and row holds no height; beyond the border, the nearest one.
    pub fn is_hole(&self, column: u32, row: u32) -> bool {
        let (column, row) = (column.min(self.width - 1), row.min(self.height - 1));
        self.holes.as_ref().is_some_and(|holes| holes.contains(row as usize * self.width as usize + column as usize))
    }

    /// Whether the cell in a column and row of cells has ground: none of its corners is a hole.
    pub fn has_ground(&self, column: u32, row: u32) -> bool {
        self.holes.is_none()
            || ![(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().any(|(x, y)| self.is_hole(column + x, row + y))
    }

    /// The map with samples that 16 bits hold: each rounded to a multiple of 1/65535, unless they already are such.
    #[must_use]
    pub fn rounded_to_16_bits(mut self) -> Self {
        if self.units.is_none() {
            self.units = Some(u16::MAX);
            self.samples.par_iter_mut().for_each(|sample| *sample = rounded(f64::from(*sample), u16::MAX));
        }
        self
    }

    /// The map as one whose samples can be any height.
    pub(super) fn without_units(self) -> Self {
        Self { units: None, ..self }
    }

    /// Columns, at least 2.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows, at least 2.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Columns and rows of cells: one fewer each than of samples.
    pub fn cells(&self) -> [u32; 2] {
        [self.width - 1, self.height - 1]
    }

    /// All samples, row by row, north first.
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// The samples are whole multiples of 1/`units`, so that 16 bits hold each without loss. `None` where the source's
    /// numbers are no integers, or span more than 65535: they need floats.
    ///
    /// Between two integers of the source there is room for more where they span less; edits make use of it.
    pub fn units(&self) -> Option<u16> {
        self.units
    }

    /// The height in 0..1 that this map can hold and that is nearest to `height`.
    pub(super) fn nearest_height(units: Option<u16>, height: f64) -> f32 {
        units.map_or_else(|| normalised(height), |units| rounded(height, units))
    }

    /// For edits that keep every sample finite, in 0..1 and, where there are [`Self::units`], a multiple of one.
    pub(super) fn samples_mut(&mut self) -> &mut [f32] {
        &mut self.samples
    }

    /// The sample in a column and row; beyond the border, the nearest one.
    pub fn sample(&self, column: u32, row: u32) -> f32 {
        let (column, row) = (column.min(self.width - 1), row.min(self.height - 1));
        self.samples[row as usize * self.width as usize + column as usize]
    }

    /// Normalised height of the surface at `u` west–east and `v` north–south, each 0..1 over the map and clamped to it.
    pub fn surface_height(&self, u: f64, v: f64) -> f64 {
        bilinear(&self.samples, self.width, self.height, u, v)
    }

    /// `u` and `v` of the lowest sample of the inner half of the map (a quarter of each side away from its border);
    /// the middle where no sample is that far inside.
    pub fn lowest_interior(&self) -> (f64, f64) {
        let inner = |count: u32| {
            let cells = count - 1;
            cells.div_ceil(4)..=(u64::from(cells) * 3 / 4) as u32
        };
        let lowest = inner(self.height)
            .flat_map(|row| inner(self.width).map(move |column| (column, row)))
            .filter(|&(column, row)| !self.is_hole(column, row))
            .min_by(|&(a, b), &(c, d)| self.sample(a, b).total_cmp(&self.sample(c, d)));
        let [columns, rows] = self.cells().map(f64::from);
        lowest.map_or((0.5, 0.5), |(column, row)| (f64::from(column) / columns, f64::from(row) / rows))
    }
}

/// Units for integers that span so much: a multiple of the span, as fine as 16 bits allow.
fn units_for(span: f64) -> Option<u16> {
    let most = f64::from(u16::MAX);
    let span = span.max(1.0);
    (span <= most).then(|| (span * (most / span).floor()) as u16)
}

/// `height`, 0..1, as a multiple of 1/`units`.
fn rounded(height: f64, units: u16) -> f32 {
    normalised((height * f64::from(units)).round() / f64::from(units))
}

/// A normalised height as a sample: within 0..1, and never a subnormal or −0, which drivers treat as they like.
pub(super) fn normalised(height: f64) -> f32 {
    let height = height.clamp(0.0, 1.0) as f32;
    if height < f32::MIN_POSITIVE { 0.0 } else { height }
}

/// Bilinear interpolation in f64 of a grid whose samples stand on the corners; `u` and `v` are clamped to 0..1.
pub(super) fn bilinear(samples: &[f32], width: u32, height: u32, u: f64, v: f64) -> f64 {
    let split = |t: f64, count: u32| {
        let position = t.clamp(0.0, 1.0) * f64::from(count - 1);
        let cell = (position as u32).min(count - 2);
        (cell as usize, position - f64::from(cell))
    };
    let ((x, fx), (y, fy)) = (split(u, width), split(v, height));
    let at = |x: usize, y: usize| f64::from(samples[y * width as usize + x]);
    let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
    mix(mix(at(x, y), at(x + 1, y), fx), mix(at(x, y + 1), at(x + 1, y + 1), fx), fy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_normalised_and_the_range_is_kept() {
        let field = HeightField::from_raw(3, 2, &[10.0, 20.0, 30.0, 15.0, 25.0, 10.0]).unwrap();
        assert_eq!(field.samples(), [0.0, 0.5, 1.0, 0.25, 0.75, 0.0]);
        assert_eq!(field.range(), [10.0, 30.0]);
        assert_eq!(field.sample(9, 9), 0.0, "clamped to the last sample");
        let huge = HeightField::from_raw(2, 2, &[f64::MIN, 0.0, f64::MAX, 0.0]).unwrap();
        assert_eq!(huge.samples(), [0.0, 0.5, 1.0, 0.5], "a span beyond f64 does not overflow");
    }

    #[test]
    fn sixteen_bits_hold_integers_and_nothing_finer() {
        let units = |raw: &[f64]| HeightField::from_raw(2, 2, raw).unwrap().units();
        assert_eq!(units(&[0.0, 65535.0, 7.0, 8.0]), Some(65535));
        assert_eq!(units(&[-3.0, 252.0, 7.0, 8.0]), Some(65535), "eight bits: 257 units to a step");
        assert_eq!(units(&[479.0, 2347.0, 480.0, 481.0]), Some(65380), "1868 metres: 35 units each");
        assert_eq!(units(&[5.0; 4]), Some(65535), "flat");
        assert_eq!(units(&[0.0, 65536.0, 7.0, 8.0]), None, "too far apart");
        assert_eq!(units(&[0.0, 2.0, 0.5, 1.0]), None, "not whole");
        let field = HeightField::from_raw(2, 2, &[0.0, 1.0, 0.3, 0.75]).unwrap();
        assert_eq!(field.units(), None);
        let rounded = field.rounded_to_16_bits();
        assert_eq!(rounded.units(), Some(65535));
        let expected = [0.0, 1.0, 19661.0 / 65535.0, 49151.0 / 65535.0].map(|height: f64| height as f32);
        assert_eq!(rounded.samples(), expected, "to the nearest");
    }

    #[test]
    fn holes_are_not_looked_at() {
        let mut holes = HoleMask::new(3, 3);
        [0, 4].into_iter().for_each(|index| holes.insert(index));
        let raw = [f64::NAN, 10.0, 20.0, 10.0, -9999.0, 12.0, 14.0, 30.0, 11.0];
        let field = HeightField::from_raw_with_holes(3, 3, &raw, Some(holes.clone())).unwrap();
        assert_eq!((field.range(), field.units().is_some()), ([10.0, 30.0], true));
        assert_eq!((field.sample(0, 0), field.sample(1, 1), field.sample(2, 0)), (0.0, 0.0, 0.5));
        assert!(field.is_hole(1, 1) && field.is_hole(0, 0) && !field.is_hole(1, 0) && !field.is_hole(9, 9));
        assert!((0..2).all(|row| (0..2).all(|column| !field.has_ground(column, row))), "the middle is in all four");
        let floor = field.clone().with_hole_policy(Holes::Floor);
        assert!(floor.holes().is_none() && floor.has_ground(0, 0) && floor.samples() == field.samples());
        let filled = field.clone().with_hole_policy(Holes::Fill);
        assert!(filled.holes().is_none() && (0.1..0.9).contains(&filled.sample(1, 1)), "{}", filled.sample(1, 1));
        let unit = f32::from(filled.units().unwrap());
        assert!(filled.samples().iter().all(|s| (s * unit - (s * unit).round()).abs() < 0.01), "16 bits still hold it");

        (0..9).for_each(|index| holes.insert(index));
        let all = HeightField::from_raw_with_holes(3, 3, &raw, Some(holes));
        assert_eq!(all, Err(HeightFieldError::AllHoles { width: 3, height: 3 }));
        let none = HeightField::from_raw_with_holes(2, 2, &[1.0; 4], Some(HoleMask::new(2, 2))).unwrap();
        assert!(none.holes().is_none());
        let other = HeightField::from_raw_with_holes(
            3,
            3,
            &raw,
            Some({
                let mut holes = HoleMask::new(2, 2);
                holes.insert(0);
                holes
            }),
        );
        assert!(matches!(other, Err(HeightFieldError::WrongCount { .. })));
    }

    #[test]
    fn a_flat_map_is_all_zero() {
        let field = HeightField::from_raw(2, 2, &[7u16; 4]).unwrap();
        assert_eq!(field.samples(), [0.0; 4]);
        assert_eq!(field.range(), [7.0, 7.0]);
        assert_eq!(field.with_extent_metres(Some([5.0, 5.0])).natural_height_scale(), 0.0);
    }

    #[test]
    fn what_is_no_height_map_is_refused() {
        let small = HeightField::from_raw(1, 4, &[0.0; 4]);
        assert_eq!(small, Err(HeightFieldError::TooSmall { width: 1, height: 4 }));
        let count = HeightField::from_raw(2, 2, &[0.0; 5]);
        assert_eq!(count, Err(HeightFieldError::WrongCount { width: 2, height: 2, count: 5 }));
        let nan = HeightField::from_raw(2, 2, &[0.0, 1.0, f64::NAN, 2.0]);
        assert_eq!(nan, Err(HeightFieldError::NotFinite { column: 0, row: 1 }));
    }

    #[test]
    fn no_sample_is_a_bad_number() {
        let bad = [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for (index, value) in (0..6).flat_map(|index| bad.map(|value| (index, value))) {
            let mut raw = [0.5; 6];
            raw[index as usize] = value;
            let error = HeightField::from_raw(3, 2, &raw).unwrap_err();
            assert_eq!(error, HeightFieldError::NotFinite { column: index % 3, row: index / 3 });
            assert_eq!(error.to_string().lines().count(), 3, "what, why, what to do: {error}");
        }
        let tiny = f64::from_bits(1);
        for raw in [
            [-0.0, 0.0, 1.0, -0.0],
            [0.0, tiny, 1e-310, -tiny],
            [0.0, 1e-40, 1.0, 1e-39],
            [1e38, -1e38, 0.0, -0.0],
            [f64::MAX, f64::MIN, f64::MIN_POSITIVE, -0.0],
            [1e300, 1.0 + f64::EPSILON, 1.0, 1e-300],
        ] {
            let field = HeightField::from_raw(2, 2, &raw).unwrap();
            for &sample in field.samples() {
                let sound = (sample.is_normal() && (0.0..=1.0).contains(&sample)) || sample.to_bits() == 0;
                assert!(sound, "{sample:e} of {raw:?}");
            }
        }
        let singles = HeightField::from_raw(2, 2, &[f32::from_bits(1), -0.0f32, 1.0, f32::MIN_POSITIVE]).unwrap();
        assert_eq!(
            singles.samples().iter().map(|h| h.to_bits()).collect::<Vec<_>>(),
            [0, 0, 1f32.to_bits(), f32::MIN_POSITIVE.to_bits()]
        );
    }

    #[test]
    fn the_surface_is_bilinear_and_clamped() {
        let field = HeightField::from_raw(3, 2, &[0.0, 4.0, 0.0, 2.0, 2.0, 2.0]).unwrap();
        assert_eq!(field.surface_height(0.5, 0.0), 1.0);
        assert_eq!(field.surface_height(0.25, 0.5), 0.5);
        assert_eq!(field.surface_height(-3.0, 7.0), 0.5);
        assert_eq!(field.surface_height(1.0, 1.0), 0.5);
    }

    #[test]
    fn the_lowest_place_is_sought_inside() {
        let mut raw = vec![5.0; 81];
        raw[0] = 0.0;
        raw[3 * 9 + 6] = 1.0;
        assert_eq!(HeightField::from_raw(9, 9, &raw).unwrap().lowest_interior(), (0.75, 0.375));
        assert_eq!(HeightField::from_raw(2, 2, &[0.0; 4]).unwrap().lowest_interior(), (0.5, 0.5));
    }
}
