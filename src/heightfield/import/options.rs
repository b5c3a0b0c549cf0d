//! What can be said about a file that it does not say itself, or says wrongly. Each can also stand in the sidecar.

use std::sync::atomic::{AtomicBool, Ordering};

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::super::Holes;
use super::VerticalUnit;

/// Types of samples in files without a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names are the types")]
pub enum RawType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl RawType {
    /// All of them.
    pub const ALL: [Self; 8] = [Self::U8, Self::I8, Self::U16, Self::I16, Self::U32, Self::I32, Self::F32, Self::F64];

    /// Bytes of one sample.
    pub fn bytes(self) -> u64 {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// As in "u16".
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// Order of a sample's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Endian {
    /// The least significant byte first
    Little,
    /// The most significant byte first
    Big,
}

/// Ways to hold heights in the colours of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// Height in metres is red × 256 + green + blue / 256 − 32768
    Terrarium,
    /// Height in metres is (red × 65536 + green × 256 + blue) / 10 − 10000
    Mapbox,
}

/// What becomes of a map with more samples a side than the limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum TooLarge {
    /// All of it, each sample the mean of as many as it takes
    #[default]
    Reduce,
    /// Its middle in full
    Window,
}

/// Which number stands for "no height".
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "NoDataText", into = "NoDataText")]
pub enum NoData {
    /// This one.
    Value(f64),
    /// None, whatever the file says: "none" in a sidecar.
    Never,
}

/// [`NoData`] as it is written.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged)]
enum NoDataText {
    Number(f64),
    Word(String),
}

impl TryFrom<NoDataText> for NoData {
    type Error = &'static str;

    fn try_from(text: NoDataText) -> Result<Self, Self::Error> {
        match text {
            NoDataText::Number(value) => Ok(Self::Value(value)),
            NoDataText::Word(word) => word.parse(),
        }
    }
}

impl From<NoData> for NoDataText {
    fn from(nodata: NoData) -> Self {
        match nodata {
            NoData::Value(value) => Self::Number(value),
            NoData::Never => Self::Word("none".into()),
        }
    }
}

impl std::str::FromStr for NoData {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.trim() {
            "none" => Ok(Self::Never),
            text => text.parse().map(Self::Value).map_err(|_| "expected a number, or none"),
        }
    }
}

/// How to open a file. What is `None` comes from the sidecar, then from the file, then from a guess that is told.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ImportOptions {
    /// Columns and rows of a file without a header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raw_size: Option<[u32; 2]>,
    /// Its samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raw_type: Option<RawType>,
    /// Their bytes' order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raw_endian: Option<Endian>,
    /// Rows are stored the other way round than the format says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip: Option<bool>,
    /// Colours are heights. Never guessed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// The number that means "no height".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodata: Option<NoData>,
    /// What heights are measured in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical_unit: Option<VerticalUnit>,
    /// Which band of several, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<u32>,
    /// Which variable or channel of several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variable: Option<String>,
    /// What becomes of samples without a height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holes: Option<Holes>,
    /// The mean of so many by so many samples becomes one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduce: Option<u32>,
    /// Only a part: first column and row, columns, rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<[u32; 4]>,
    /// What becomes of a map beyond the limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub too_large: Option<TooLarge>,
    /// Most samples a side; a larger map is treated as [`Self::too_large`] says, and that is told.
    #[serde(skip)]
    pub limit: Option<u32>,
    /// A map beyond the limit is refused instead, before it is decoded.
    #[serde(skip)]
    pub refuse_larger: bool,
    /// The sidecar gives the heights of the file's lowest and highest sample, so every sample has to be read.
    #[serde(skip)]
    pub needs_full_range: bool,
}

impl ImportOptions {
    /// The keys that a sidecar may have of these.
    pub const KEYS: [&'static str; 13] = [
        "raw_size",
        "raw_type",
        "raw_endian",
        "flip",
        "encoding",
        "nodata",
        "vertical_unit",
        "band",
        "variable",
        "holes",
        "reduce",
        "window",
        "too_large",
    ];

    /// These, completed by `other`.
    #[must_use]
    pub fn or(self, other: &Self) -> Self {
        Self {
            raw_size: self.raw_size.or(other.raw_size),
            raw_type: self.raw_type.or(other.raw_type),
            raw_endian: self.raw_endian.or(other.raw_endian),
            flip: self.flip.or(other.flip),
            encoding: self.encoding.or(other.encoding),
            nodata: self.nodata.or(other.nodata),
            vertical_unit: self.vertical_unit.or(other.vertical_unit),
            band: self.band.or(other.band),
            variable: self.variable.or_else(|| other.variable.clone()),
            holes: self.holes.or(other.holes),
            reduce: self.reduce.or(other.reduce),
            window: self.window.or(other.window),
            too_large: self.too_large.or(other.too_large),
            ..self
        }
    }
}

/// Hears how far the work is, and can end it.
#[derive(Clone, Copy)]
pub struct Listener<'a> {
    /// Hears the share of the file that has been read, 0..1, from the thread that reads.
    pub progress: &'a dyn Fn(f32),
    /// Once true, the work ends soon, with an error that says so.
    pub cancel: &'a AtomicBool,
}

impl Listener<'static> {
    /// Hears nothing and lets the work end by itself.
    pub fn none() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { progress: &|_| {}, cancel: &NEVER }
    }
}

impl Listener<'_> {
    /// Whether the work is to end.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl std::fmt::Debug for Listener<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Listener").field("cancel", self.cancel).finish_non_exhaustive()
    }
}
