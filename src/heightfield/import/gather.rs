//! Takes the rows of a file as they are decoded and keeps what is wanted of them: a window, or means of blocks.

use super::elevation::{Sample, Taken};
use super::source::Fault;
use super::{Elevation, Format, ImportOptions, NoData, Samples, TooLarge};
use crate::heightfield::HoleMask;

/// Most samples on a side where the caller gives no limit.
pub(super) const MOST: u32 = super::super::load::MAX_SIDE;

/// Most samples on a side that a file may have, whatever is kept of it.
const MOST_IN_FILE: u64 = 1 << 24;

/// What to keep of a file's grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) taken: Taken,
    /// The limit that the factor or the window was chosen to stay within, and the columns and rows that were too many.
    to_fit: Option<(u32, [u32; 2])>,
}

impl Plan {
    /// The part of a file of `width` × `height` samples that is wanted. Nothing has been allocated for it yet.
    pub(super) fn new(width: u64, height: u64, options: &ImportOptions) -> Result<Self, Fault> {
        if width < 2 || height < 2 {
            return Err(Fault::TooSmall([width, height]));
        }
        if width.max(height) > MOST_IN_FILE {
            return Err(Fault::TooLarge([width, height]));
        }
        let full = [width as u32, height as u32];
        let mut window = options.window.unwrap_or([0, 0, full[0], full[1]]);
        let ends = [u64::from(window[0]) + u64::from(window[2]), u64::from(window[1]) + u64::from(window[3])];
        if window[2] < 2 || window[3] < 2 || ends[0] > width || ends[1] > height {
            return Err(Fault::Unclear(
                format!(
                    "the window {},{},{},{} is not inside its {width}×{height} samples",
                    window[0], window[1], window[2], window[3]
                ),
                String::from("choose X,Z,WIDTH,HEIGHT inside, at least 2×2"),
            ));
        }
        let limit = options.limit.unwrap_or(MOST).clamp(2, MOST);
        let asked = options.reduce.unwrap_or(1).max(1);
        let longer = window[2].max(window[3]);
        // The least whole number that divides the longer side to the limit or below.
        let factor = asked.max(longer / (limit + 1) + 1);
        if factor > asked && options.refuse_larger {
            return Err(Fault::Beyond([window[2] / asked, window[3] / asked]));
        }
        let wanted = [window[2], window[3]];
        let to_fit = (factor > asked).then_some((limit, wanted));
        let cut = to_fit.is_some() && options.too_large == Some(TooLarge::Window);
        let factor = if cut { asked } else { factor };
        if cut {
            for axis in [0, 1] {
                let most = window[2 + axis].min(limit.saturating_mul(asked));
                window[axis] += (window[2 + axis] - most) / 2;
                window[2 + axis] = most;
            }
        }
        if (window[2] / factor).min(window[3] / factor) < 2 {
            let (size, advice) =
                (format!("{}×{}", window[2], window[3]), "choose a --window of it, or a smaller --reduce");
            let why = if factor > asked {
                format!(
                    "its {size} samples are more than the {limit} a side that fit the adapter, and to reduce them by \
                     {factor} leaves less than 2×2"
                )
            } else {
                format!("means of {factor}×{factor} leave less than 2×2 of its {size} samples")
            };
            return Err(Fault::Unclear(why, advice.into()));
        }
        let taken = Taken { full, window, factor };
        Ok(Self { taken, to_fit })
    }

    /// What has to be told about it.
    fn warning(&self) -> Option<String> {
        let (taken, (limit, [columns, rows])) = (self.taken, self.to_fit?);
        let [width, height] = taken.size();
        let [x, z, ..] = taken.window;
        let too_many = format!("its {columns}×{rows} samples are more than the {limit} a side that fit here");
        Some(if taken.window[2..] == [columns, rows] {
            format!(
                "{too_many}: each sample is the mean of {factor}×{factor}, {width}×{height} in all; choose a part of it in \
                 full with --window X,Z,WIDTH,HEIGHT, or its middle with --too-large window",
                factor = taken.factor
            )
        } else {
            format!(
                "{too_many}: only its middle is shown, {width}×{height} from column {x} and row {z} on; choose another part \
                 with --window X,Z,WIDTH,HEIGHT, or means of all with --too-large reduce"
            )
        })
    }
}

/// In which order rows and columns come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Order {
    /// The first row is the southernmost.
    pub(super) south_first: bool,
    /// The first column is the easternmost.
    pub(super) east_first: bool,
}

/// Collects rows.
pub(super) struct Gatherer<T> {
    plan: Plan,
    order: Order,
    nodata: Vec<T>,
    /// Rows pushed so far.
    pushed: u32,
    kept: Kept<T>,
    holes: Option<HoleMask>,
    range: [f64; 2],
    mirrored: (Vec<T>, Vec<bool>),
}

enum Kept<T> {
    /// The samples themselves, in the order of the finished map.
    Own(Vec<T>),
    /// Means, and of the row of blocks at hand the sums and counts.
    Means { means: Vec<f32>, sums: Vec<f64>, counts: Vec<u32> },
}

impl<T: Sample> Gatherer<T> {
    /// For a file of the plan's size. The caller has made sure that the file's length warrants its samples. `nodata`:
    /// numbers that mean "no height"; NaN and the infinities always do.
    pub(super) fn new(plan: Plan, order: Order, nodata: &[f64]) -> Self {
        let [width, height] = plan.taken.size().map(|side| side as usize);
        let kept = if plan.taken.factor == 1 {
            Kept::Own(vec![T::ZERO; width * height])
        } else {
            Kept::Means { means: vec![0.0; width * height], sums: vec![0.0; width], counts: vec![0; width] }
        };
        let nodata = nodata.iter().filter_map(|&value| T::exactly(value)).collect();
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Self { plan, order, nodata, pushed: 0, kept, holes: None, range, mirrored: Default::default() }
    }

    /// Whether no further row can matter.
    pub(super) fn is_full(&self) -> bool {
        self.pushed >= self.plan.taken.full[1]
    }

    /// Takes whole rows, in the file's order. What goes beyond the last is left out.
    pub(super) fn push(&mut self, rows: &[T]) {
        for row in rows.chunks_exact(self.plan.taken.full[0] as usize) {
            self.push_with_gaps(row, &[]);
        }
    }

    /// Leaves rows out of which none is wanted.
    pub(super) fn skip(&mut self, rows: u32) {
        self.pushed = self.pushed.saturating_add(rows).min(self.plan.taken.full[1]);
    }

    /// Whether some of the next `rows` rows are wanted.
    pub(super) fn wants(&self, rows: u32) -> bool {
        let Taken { full, window: [_, top, _, wanted], .. } = self.plan.taken;
        let end = (self.pushed + rows).min(full[1]);
        let rows = if self.order.south_first { full[1] - end..full[1] - self.pushed } else { self.pushed..end };
        rows.start < top + wanted && rows.end > top
    }

    /// Takes one row whose samples hold no height where `gaps` says so; without gaps, that is empty.
    pub(super) fn push_with_gaps(&mut self, row: &[T], gaps: &[bool]) {
        if self.is_full() {
            return;
        }
        if self.order.east_first {
            let (mut samples, mut missing) = std::mem::take(&mut self.mirrored);
            samples.clear();
            missing.clear();
            samples.extend(row.iter().rev());
            missing.extend(gaps.iter().rev());
            self.take_row(&samples, &missing);
            self.mirrored = (samples, missing);
        } else {
            self.take_row(row, gaps);
        }
        self.pushed += 1;
    }

    fn take_row(&mut self, row: &[T], gaps: &[bool]) {
        let nodata = std::mem::take(&mut self.nodata);
        let is_height = |sample: T, column: usize| {
            sample.into().is_finite() && !nodata.contains(&sample) && !gaps.get(column).is_some_and(|gap| *gap)
        };
        for (column, &sample) in row.iter().enumerate() {
            if is_height(sample, column) {
                let value = sample.into();
                self.range = [self.range[0].min(value), self.range[1].max(value)];
            }
        }
        let Taken { full, window: [left, top, _, _], factor } = self.plan.taken;
        let [width, height] = self.plan.taken.size();
        let row_index = if self.order.south_first { full[1] - 1 - self.pushed } else { self.pushed };
        // In the window, in whole blocks.
        if let Some(inner) = row_index.checked_sub(top).filter(|&inner| inner < height * factor) {
            let left = left as usize;
            let columns = row.get(left..left + (width * factor) as usize).unwrap_or_default();
            if let Kept::Own(_) = self.kept {
                self.keep(inner, columns, |sample, column| is_height(sample, left + column));
            } else {
                self.average(inner, columns, |sample, column| is_height(sample, left + column));
            }
        }
        self.nodata = nodata;
    }

    fn keep(&mut self, row: u32, columns: &[T], is_height: impl Fn(T, usize) -> bool) {
        let [width, height] = self.plan.taken.size();
        let start = row as usize * width as usize;
        let Kept::Own(kept) = &mut self.kept else { return };
        for ((column, &sample), place) in columns.iter().enumerate().zip(&mut kept[start..]) {
            if is_height(sample, column) {
                *place = sample;
            } else {
                self.holes.get_or_insert_with(|| HoleMask::new(width, height)).insert(start + column);
            }
        }
    }

    fn average(&mut self, row: u32, columns: &[T], is_height: impl Fn(T, usize) -> bool) {
        let factor = self.plan.taken.factor;
        let [width, height] = self.plan.taken.size();
        let Kept::Means { means, sums, counts } = &mut self.kept else { return };
        for (column, &sample) in columns.iter().enumerate() {
            if is_height(sample, column) {
                sums[column / factor as usize] += sample.into();
                counts[column / factor as usize] += 1;
            }
        }
        let last = if self.order.south_first { 0 } else { factor - 1 };
        if row % factor == last {
            let start = (row / factor) as usize * width as usize;
            for (offset, (sum, count)) in sums.iter_mut().zip(counts).enumerate() {
                if *count == 0 {
                    self.holes.get_or_insert_with(|| HoleMask::new(width, height)).insert(start + offset);
                } else {
                    means[start + offset] = (*sum / f64::from(*count)) as f32;
                }
                (*sum, *count) = (0.0, 0);
            }
        }
    }

    /// The map, once all rows are there. A format adds what else it knows.
    pub(super) fn finish(self, format: Format) -> Result<Elevation, Fault> {
        if !self.is_full() {
            return Err(Fault::Truncated);
        }
        let [width, height] = self.plan.taken.size();
        if self.holes.as_ref().is_some_and(|holes| holes.count() == u64::from(width) * u64::from(height)) {
            return Err(Fault::AllHoles([width, height]));
        }
        let samples = match self.kept {
            Kept::Own(samples) => T::wrap(samples),
            Kept::Means { means, .. } => Samples::F32(means),
        };
        Ok(Elevation {
            width,
            height,
            samples,
            holes: self.holes,
            scale: 1.0,
            offset: 0.0,
            vertical_unit: None,
            metric: true,
            georeference: None,
            format,
            compression: None,
            sample_type: T::NAME,
            taken: self.plan.taken,
            full_range: (self.range[0] <= self.range[1]).then_some(self.range),
            warnings: self.plan.warning().into_iter().collect(),
        })
    }
}

/// The numbers that mean "no height": what the options say, else what the file says.
pub(super) fn nodata_values(options: &ImportOptions, of_file: &[f64]) -> Vec<f64> {
    match options.nodata {
        Some(NoData::Value(value)) => vec![value],
        Some(NoData::Never) => Vec::new(),
        None => of_file.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gathered(order: Order, options: &ImportOptions) -> Elevation {
        let plan = Plan::new(7, 5, options).unwrap();
        let mut gatherer = Gatherer::<i16>::new(plan, order, &[-1.0]);
        // Pushed in two parts: columns count ones, rows tens.
        let rows: Vec<i16> = (0..35).map(|i| if i == 16 { -1 } else { i % 7 + 10 * (i / 7) }).collect();
        gatherer.push(&rows[..14]);
        gatherer.push(&rows[14..]);
        gatherer.finish(Format::Raw).unwrap()
    }

    fn heights(elevation: &Elevation) -> Vec<f64> {
        let (width, height) = (elevation.width, elevation.height);
        let cells = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        cells.map(|(column, row)| elevation.height_at(column, row).unwrap_or(f64::INFINITY)).collect()
    }

    const HOLE: f64 = f64::INFINITY;

    #[test]
    fn a_window_is_a_part_as_it_is() {
        let options = ImportOptions { window: Some([1, 2, 3, 2]), ..Default::default() };
        assert_eq!(heights(&gathered(Order::default(), &options)), [21.0, HOLE, 23.0, 31.0, 32.0, 33.0]);
        let turned = Order { south_first: true, east_first: true };
        // The hole is in the third row and, from the east, in column 4.
        assert_eq!(heights(&gathered(turned, &options)), [25.0, 24.0, 23.0, 15.0, 14.0, 13.0]);
        assert_eq!(gathered(turned, &options).full_range, Some([0.0, 46.0]), "of the whole file");
    }

    #[test]
    fn means_leave_holes_out() {
        let options = ImportOptions { reduce: Some(2), ..Default::default() };
        let expected = [5.5, 7.5, 9.5, 25.5, (23.0 + 32.0 + 33.0) / 3.0f32 as f64, 29.5];
        let got = heights(&gathered(Order::default(), &options));
        assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{got:?}");
        let from_the_south = gathered(Order { south_first: true, east_first: false }, &options);
        // Blocks are counted from the north-western corner, which is now that of the last row.
        assert_eq!(heights(&from_the_south)[..3], [35.5, 37.5, 39.5]);
        assert!(from_the_south.holes.is_none(), "a block with one height has a mean");
    }

    #[test]
    fn the_factor_is_the_least_that_fits() {
        let factor = |width: u64, limit: u32| {
            Plan::new(width, 40, &ImportOptions { limit: Some(limit), ..Default::default() }).unwrap().taken
        };
        for (width, limit, expected) in [(40, 40, 1), (41, 40, 2), (81, 40, 2), (82, 40, 3), (122, 40, 3), (123, 40, 4)]
        {
            let taken = factor(width, limit);
            assert!(taken.size()[0] <= limit, "{taken:?}");
            assert_eq!(taken.factor, expected, "{width} within {limit}");
        }
        let middle = |size: [u64; 2], options: ImportOptions| {
            let options = ImportOptions { limit: Some(40), too_large: Some(TooLarge::Window), ..options };
            let plan = Plan::new(size[0], size[1], &options).unwrap();
            assert!(plan.taken.size().iter().all(|&side| side <= 40), "{plan:?}");
            (plan.taken.window, plan.taken.factor, plan.warning().is_some())
        };
        assert_eq!(middle([101, 30], ImportOptions::default()), ([30, 0, 40, 30], 1, true));
        assert_eq!(middle([40, 30], ImportOptions::default()), ([0, 0, 40, 30], 1, false), "it fits");
        let window = ImportOptions { window: Some([10, 5, 100, 90]), reduce: Some(2), ..Default::default() };
        assert_eq!(
            middle([200, 200], window),
            ([20, 10, 80, 80], 2, true),
            "the middle of the part, in the means asked for"
        );
        let refused = ImportOptions { limit: Some(40), refuse_larger: true, ..Default::default() };
        assert!(matches!(Plan::new(41, 41, &refused), Err(Fault::Beyond([41, 41]))));
        assert!(matches!(Plan::new(1, 41, &refused), Err(Fault::TooSmall(_))));
        assert!(matches!(Plan::new(1 << 40, 41, &refused), Err(Fault::TooLarge(_))));
        for window in [[0, 0, 42, 2], [41, 0, 2, 2], [0, 0, 1, 2], [u32::MAX, 0, u32::MAX, 2]] {
            let options = ImportOptions { window: Some(window), ..Default::default() };
            assert!(matches!(Plan::new(41, 41, &options), Err(Fault::Unclear(..))), "{window:?}");
        }
    }
}
