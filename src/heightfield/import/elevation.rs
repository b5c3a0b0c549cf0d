//! What every format is decoded to: samples of the file's own type, a mask of holes, and a place on the ground.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::{HeightField, HeightFieldError, HoleMask, Holes};
use super::{Format, Georeference};

/// Samples as the file holds them, row by row, north first.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are the types")]
pub enum Samples {
    U8(Vec<u8>),
    I8(Vec<i8>),
    U16(Vec<u16>),
    I16(Vec<i16>),
    U32(Vec<u32>),
    I32(Vec<i32>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Does the same with samples of every type.
macro_rules! with_samples {
    ($samples:expr, $name:ident => $body:expr) => {
        match $samples {
            $crate::heightfield::import::Samples::U8($name) => $body,
            $crate::heightfield::import::Samples::I8($name) => $body,
            $crate::heightfield::import::Samples::U16($name) => $body,
            $crate::heightfield::import::Samples::I16($name) => $body,
            $crate::heightfield::import::Samples::U32($name) => $body,
            $crate::heightfield::import::Samples::I32($name) => $body,
            $crate::heightfield::import::Samples::F32($name) => $body,
            $crate::heightfield::import::Samples::F64($name) => $body,
        }
    };
}
pub(crate) use with_samples;

impl Samples {
    /// The sample with this index as a number; NaN beyond the last.
    pub fn get(&self, index: usize) -> f64 {
        with_samples!(self, samples => samples.get(index).map_or(f64::NAN, |&sample| number(sample)))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        with_samples!(self, samples => samples.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The name of the type.
    pub fn type_name(&self) -> &'static str {
        fn name<T: Sample>(_: &[T]) -> &'static str {
            T::NAME
        }
        with_samples!(self, samples => name(samples))
    }
}

/// The types that samples come in.
pub(crate) trait Sample: Copy + Into<f64> + PartialEq + Send + Sync + 'static {
    /// As in "u16".
    const NAME: &'static str;
    /// Bytes of one.
    const BYTES: usize;
    /// Stands where there is no height.
    const ZERO: Self;
    /// No number, in types that have such.
    const NO_NUMBER: Option<Self>;
    /// The number as this type, where it is one of its values; a float takes the nearest.
    fn exactly(value: f64) -> Option<Self>;
    /// From the first bytes of `bytes`, which are at least [`Self::BYTES`].
    fn from_bytes(bytes: &[u8], big: bool) -> Self;
    /// The samples as such.
    fn wrap(samples: Vec<Self>) -> Samples;
}

macro_rules! sample {
    ($type:ty, $name:literal, $variant:ident, $nan:expr) => {
        impl Sample for $type {
            const NAME: &'static str = $name;
            const BYTES: usize = size_of::<$type>();
            const ZERO: Self = 0 as $type;
            const NO_NUMBER: Option<Self> = $nan;
            fn exactly(value: f64) -> Option<Self> {
                let own = value as $type;
                let is_float = Self::NO_NUMBER.is_some();
                (number(own) == value || is_float && !value.is_nan()).then_some(own)
            }
            fn from_bytes(bytes: &[u8], big: bool) -> Self {
                let mut own = [0; size_of::<$type>()];
                own.iter_mut().zip(bytes).for_each(|(own, byte)| *own = *byte);
                if big { Self::from_be_bytes(own) } else { Self::from_le_bytes(own) }
            }
            fn wrap(samples: Vec<Self>) -> Samples {
                Samples::$variant(samples)
            }
        }
    };
}

sample!(u8, "u8", U8, None);
sample!(i8, "i8", I8, None);
sample!(u16, "u16", U16, None);
sample!(i16, "i16", I16, None);
sample!(u32, "u32", U32, None);
sample!(i32, "i32", I32, None);
sample!(f32, "f32", F32, Some(f32::NAN));
sample!(f64, "f64", F64, Some(f64::NAN));

/// Any sample as a number.
pub(crate) fn number(sample: impl Into<f64>) -> f64 {
    sample.into()
}

/// What heights are measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum VerticalUnit {
    /// Metres
    Metre,
    /// International feet, 0.3048 m
    Foot,
    /// United States survey feet, 1200/3937 m
    UsFoot,
}

impl VerticalUnit {
    /// One of it in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Foot => 0.3048,
            Self::UsFoot => 1200.0 / 3937.0,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metre => "metre",
            Self::Foot => "foot",
            Self::UsFoot => "us-foot",
        }
    }
}

/// Which part of the file's grid was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Columns and rows of the file.
    pub full: [u32; 2],
    /// First column and row of the window, its columns and rows.
    pub window: [u32; 4],
    /// Each sample is the mean of so many by so many; 1: the file's own.
    pub factor: u32,
}

impl Taken {
    /// Columns and rows of what was taken.
    pub fn size(&self) -> [u32; 2] {
        [self.window[2] / self.factor, self.window[3] / self.factor]
    }

    /// Whether it is all of the file as it is.
    pub fn is_whole(&self) -> bool {
        self.factor == 1 && self.window == [0, 0, self.full[0], self.full[1]]
    }
}

/// A decoded elevation file.
#[derive(Clone, Debug)]
pub struct Elevation {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// As in the file; zero in holes.
    pub samples: Samples,
    /// The samples that hold no height; absent where all do.
    pub holes: Option<HoleMask>,
    /// Height is sample × scale + offset, in [`Self::vertical_unit`].
    pub scale: f64,
    /// See [`Self::scale`].
    pub offset: f64,
    /// What heights are measured in; absent where the file does not say.
    pub vertical_unit: Option<VerticalUnit>,
    /// Whether the numbers are heights, rather than shades of a picture.
    pub metric: bool,
    /// Where the map lies.
    pub georeference: Option<Georeference>,
    /// The format it came from.
    pub format: Format,
    /// How the samples were packed, where the format has a choice.
    pub compression: Option<String>,
    /// The type of the file's samples: "u8", "i16", "f32" and so on.
    pub sample_type: &'static str,
    /// The part of the file that was taken.
    pub taken: Taken,
    /// Lowest and highest sample of all that was read, in the file's own numbers; also of what was not taken.
    pub full_range: Option<[f64; 2]>,
    /// What was guessed or is not as expected; each a whole sentence without the file's name.
    pub warnings: Vec<String>,
}

impl Elevation {
    /// The height of a sample in [`Self::vertical_unit`]; `None` in a hole and beyond the map.
    pub fn height_at(&self, column: u32, row: u32) -> Option<f64> {
        if column >= self.width || row >= self.height {
            return None;
        }
        let index = row as usize * self.width as usize + column as usize;
        let hole = self.holes.as_ref().is_some_and(|holes| holes.contains(index));
        (!hole).then(|| self.samples.get(index) * self.scale + self.offset)
    }

    /// Share of the samples that hold no height, 0..1.
    pub fn hole_fraction(&self) -> f64 {
        let count = self.holes.as_ref().map_or(0, HoleMask::count);
        count as f64 / (f64::from(self.width) * f64::from(self.height)).max(1.0)
    }

    /// Metres between the outermost samples west–east and north–south, where the place is known.
    pub fn extent_metres(&self) -> Option<[f64; 2]> {
        let step = self.georeference.as_ref()?.metres_per_sample([self.width, self.height])?;
        Some([step[0] * f64::from(self.width.max(1) - 1), step[1] * f64::from(self.height.max(1) - 1)])
    }

    /// Makes the lowest and highest sample of the file stand for these heights.
    pub(crate) fn set_range(&mut self, [low, high]: [f64; 2]) {
        if let Some([least, most]) = self.full_range {
            self.scale = if most > least { (high - low) / (most - least) } else { 1.0 };
            self.offset = low - least * self.scale;
            self.vertical_unit = Some(VerticalUnit::Metre);
        }
    }

    /// What the heights of the map, from `range[0]` to `range[1]`, are if the lowest and highest sample of the whole file
    /// stand for those of `stated`.
    pub(crate) fn stated_range(&self, range: [f64; 2], stated: [f64; 2]) -> [f64; 2] {
        let metres = self.vertical_unit.map_or(1.0, VerticalUnit::metres);
        let Some(full) = self.full_range else { return stated };
        let mut full = full.map(|raw| (raw * self.scale + self.offset) * metres);
        full.sort_by(f64::total_cmp);
        let [low, high] = full;
        range.map(|height| {
            // To the digit where it is that sample.
            if height <= low {
                stated[0]
            } else if height >= high {
                stated[1]
            } else {
                stated[0] + (height - low) / (high - low) * (stated[1] - stated[0])
            }
        })
    }

    /// The map of these samples. Its range is in metres where the vertical unit is known.
    ///
    /// # Errors
    /// [`HeightFieldError`]: no surface, or no height at all.
    pub fn into_field(self, policy: Holes) -> Result<HeightField, HeightFieldError> {
        let (width, height) = (self.width, self.height);
        let (scale, offset) = (self.scale, self.offset);
        let samples = if scale > 0.0 { self.samples } else { turned(&self.samples) };
        let scale = scale.abs();
        let field = with_samples!(samples, samples => {
            HeightField::from_raw_with_holes(width, height, &samples, self.holes)
        })?;
        let metres = self.vertical_unit.map_or(1.0, VerticalUnit::metres);
        let range = field.range().map(|raw| (raw * scale + offset) * metres);
        Ok(field.with_range(range).with_hole_policy(policy))
    }
}

/// Samples of a file whose scale is negative: the highest sample is the lowest height.
fn turned(samples: &Samples) -> Samples {
    with_samples!(samples, samples => {
        Samples::F64(samples.par_iter().map(|&sample| -number(sample)).collect())
    })
}
