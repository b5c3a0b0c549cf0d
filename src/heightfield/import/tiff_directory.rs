//! A look at a TIFF's first directory before the decoder gets it: the decoder allocates for as many values as a tag says
//! it has, whatever the file's length.

use super::source::{Fault, Source};

/// Most tags that a directory may have.
const MOST_TAGS: u64 = 4096;

/// Refuses a directory with a tag of more bytes than the file has.
pub(super) fn check(source: &mut Source) -> Result<(), Fault> {
    let head = source.take(16.min(source.bytes as usize))?;
    let big_endian = head.starts_with(b"MM");
    let number = |bytes: &[u8]| {
        let join = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        if big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    };
    let field = |at: usize, count: usize| head.get(at..at + count).map(number).ok_or(Fault::Truncated);
    let wide = field(2, 2)? == 43;
    let (offset, size_of_count, size_of_entry) = if wide { (field(8, 8)?, 8, 20) } else { (field(4, 4)?, 2, 12) };
    if offset >= source.bytes {
        return Err(Fault::Truncated);
    }
    source.seek(offset)?;
    let tags = number(&source.take(size_of_count)?);
    if tags > MOST_TAGS {
        return Err(Fault::Damaged(format!("its directory has {tags} tags")));
    }
    for _ in 0..tags {
        let entry = source.take(size_of_entry)?;
        let count = number(if wide { &entry[4..12] } else { &entry[4..8] });
        let bytes = match number(&entry[2..4]) {
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16..=18 => 8,
            _ => 1,
        };
        if count.saturating_mul(bytes) > source.bytes {
            return Err(Fault::Damaged(format!(
                "the tag {} has more values than the file has bytes",
                number(&entry[..2])
            )));
        }
    }
    source.seek(0)
}
