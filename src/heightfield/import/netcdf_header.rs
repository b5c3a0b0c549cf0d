//! The header of a netCDF file of the classic formats: dimensions, attributes and variables.
//! ("NetCDF Classic Format Specification", CDF-1, CDF-2 with 64-bit offsets, CDF-5 with 64-bit sizes.)

use super::source::{Fault, Source};

/// Most of anything in a header: more is damage.
const MOST_ENTRIES: u64 = 4096;

/// Bytes that a header may take in all.
const MOST_BYTES: u64 = 16 << 20;

/// Types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    Char,
    I16,
    I32,
    F32,
    F64,
    U8,
    U16,
    U32,
    I64,
    U64,
}

impl Type {
    fn of(code: u64) -> Result<Self, Fault> {
        Ok(match code {
            1 => Self::I8,
            2 => Self::Char,
            3 => Self::I16,
            4 => Self::I32,
            5 => Self::F32,
            6 => Self::F64,
            7 => Self::U8,
            8 => Self::U16,
            9 => Self::U32,
            10 => Self::I64,
            11 => Self::U64,
            other => return Err(Fault::Damaged(format!("a value has the type {other}"))),
        })
    }

    pub(super) fn bytes(self) -> u64 {
        match self {
            Self::I8 | Self::Char | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::F32 | Self::U32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }

    /// The value in these bytes.
    pub(super) fn value(self, bytes: &[u8]) -> f64 {
        let mut eight = [0; 8];
        eight.iter_mut().zip(bytes).for_each(|(own, byte)| *own = *byte);
        let [a, b, c, d, ..] = eight;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 | Self::Char => f64::from(a),
            Self::I16 => f64::from(i16::from_be_bytes([a, b])),
            Self::U16 => f64::from(u16::from_be_bytes([a, b])),
            Self::I32 => f64::from(i32::from_be_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_be_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_be_bytes([a, b, c, d])),
            Self::F64 => f64::from_be_bytes(eight),
            Self::I64 => i64::from_be_bytes(eight) as f64,
            Self::U64 => u64::from_be_bytes(eight) as f64,
        }
    }
}

/// A note on a variable or the file.
#[derive(Debug)]
pub(super) struct Attribute {
    name: String,
    kind: Type,
    bytes: Vec<u8>,
}

/// A variable's description.
#[derive(Debug)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Indices into the dimensions.
    pub(super) dimensions: Vec<usize>,
    attributes: Vec<Attribute>,
    pub(super) kind: Type,
    /// Where its values begin.
    pub(super) begin: u64,
}

impl Variable {
    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// The first number of an attribute.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.attribute(name)
            .filter(|found| found.kind != Type::Char && found.bytes.len() as u64 >= found.kind.bytes())
            .map(|found| found.kind.value(&found.bytes))
    }

    /// The text of an attribute.
    pub(super) fn text(&self, name: &str) -> Option<String> {
        let found = self.attribute(name).filter(|found| found.kind == Type::Char)?;
        Some(String::from_utf8_lossy(&found.bytes).trim_matches(['\0', ' ', '\n']).to_owned())
    }
}

/// All that a file says before its values.
#[derive(Debug)]
pub(super) struct Header {
    /// Names and lengths; the record dimension has its number of records.
    pub(super) dimensions: Vec<(String, u64)>,
    /// Index of the dimension along which records are stored.
    pub(super) record_dimension: Option<usize>,
    pub(super) variables: Vec<Variable>,
    /// Bytes from one record to the next.
    pub(super) record_bytes: u64,
}

impl Header {
    pub(super) fn read(source: &mut Source) -> Result<Self, Fault> {
        let version = source.head.get(3).copied().unwrap_or_default();
        source.seek(4)?;
        let mut reader = HeaderReader { source, wide: version == 5, wide_offsets: version != 1, left: MOST_BYTES };
        let records = reader.size()?;
        let mut dimensions = Vec::new();
        for _ in 0..reader.list(10)? {
            dimensions.push((reader.name()?, reader.size()?));
        }
        let record_dimension = dimensions.iter().position(|(_, length)| *length == 0);
        reader.attributes()?;
        let mut variables = Vec::new();
        for _ in 0..reader.list(11)? {
            variables.push(reader.variable(dimensions.len())?);
        }
        // A stream that was cut off while it was written says −1.
        let streaming = records == u64::from(u32::MAX) || records == u64::MAX;
        let mut header = Self { dimensions, record_dimension, variables, record_bytes: 0 };
        if let Some(index) = record_dimension {
            header.dimensions[index].1 = if streaming { 1 } else { records };
            header.measure_records(index);
        }
        Ok(header)
    }

    fn measure_records(&mut self, record: usize) {
        let in_records = || self.variables.iter().filter(|variable| variable.dimensions.first() == Some(&record));
        let bytes = |variable: &Variable| {
            let lengths = variable.dimensions.iter().skip(1).map(|&index| self.dimensions[index].1);
            lengths.fold(variable.kind.bytes(), u64::saturating_mul)
        };
        // Each is padded to four bytes, unless it is the only one.
        let single = in_records().count() == 1;
        let padded = |bytes: u64| if single { bytes } else { bytes.div_ceil(4).saturating_mul(4) };
        self.record_bytes = in_records().map(|variable| padded(bytes(variable))).fold(0, u64::saturating_add);
    }

    /// The length of each of a variable's dimensions.
    pub(super) fn lengths(&self, variable: &Variable) -> Vec<u64> {
        variable.dimensions.iter().map(|&index| self.dimensions[index].1).collect()
    }
}

struct HeaderReader<'a, 'b> {
    source: &'a mut Source<'b>,
    /// Sizes have 64 bits.
    wide: bool,
    /// Offsets have.
    wide_offsets: bool,
    /// Bytes that the header may still take.
    left: u64,
}

impl HeaderReader<'_, '_> {
    fn take(&mut self, count: u64) -> Result<Vec<u8>, Fault> {
        self.left = self.left.checked_sub(count).ok_or_else(|| Fault::Damaged("its header has no end".into()))?;
        self.source.take(count as usize)
    }

    fn narrow(&mut self) -> Result<u64, Fault> {
        Ok(Type::U32.value(&self.take(4)?) as u64)
    }

    fn wide(&mut self) -> Result<u64, Fault> {
        let bytes = self.take(8)?;
        Ok(bytes.iter().fold(0, |value, &byte| value << 8 | u64::from(byte)))
    }

    fn size(&mut self) -> Result<u64, Fault> {
        if self.wide { self.wide() } else { self.narrow() }
    }

    /// The length of a list with this tag; an absent list has none.
    fn list(&mut self, tag: u64) -> Result<u64, Fault> {
        let (found, count) = (self.narrow()?, self.size()?);
        if (found != tag && !(found == 0 && count == 0)) || count > MOST_ENTRIES {
            return Err(Fault::Damaged("a list of its header is none".into()));
        }
        Ok(count)
    }

    /// Bytes padded to four.
    fn padded(&mut self, count: u64) -> Result<Vec<u8>, Fault> {
        let mut bytes = self.take(count.div_ceil(4).saturating_mul(4))?;
        bytes.truncate(count as usize);
        Ok(bytes)
    }

    fn name(&mut self) -> Result<String, Fault> {
        let length = self.size()?;
        Ok(String::from_utf8_lossy(&self.padded(length)?).into_owned())
    }

    fn attributes(&mut self) -> Result<Vec<Attribute>, Fault> {
        (0..self.list(12)?)
            .map(|_| {
                let (name, kind) = (self.name()?, Type::of(self.narrow()?)?);
                let count = self.size()?;
                Ok(Attribute { name, kind, bytes: self.padded(count.saturating_mul(kind.bytes()))? })
            })
            .collect()
    }

    fn variable(&mut self, dimensions: usize) -> Result<Variable, Fault> {
        let name = self.name()?;
        let count = self.size()?;
        if count > MOST_ENTRIES {
            return Err(Fault::Damaged(format!("a variable has {count} dimensions")));
        }
        let indices: Result<Vec<usize>, Fault> = (0..count)
            .map(|_| match self.size()? {
                index if index < dimensions as u64 => Ok(index as usize),
                index => Err(Fault::Damaged(format!("a variable has the dimension {index}, which there is not"))),
            })
            .collect();
        let (dimensions, attributes) = (indices?, self.attributes()?);
        let kind = Type::of(self.narrow()?)?;
        self.size()?;
        let begin = if self.wide_offsets { self.wide()? } else { self.narrow()? };
        Ok(Variable { name, dimensions, attributes, kind, begin })
    }
}
