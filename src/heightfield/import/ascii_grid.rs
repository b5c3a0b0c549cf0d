//! ESRI ASCII grids: a header of words and numbers, then one number per sample, north first.

use std::io::BufRead;

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source, one_line};
use super::{Elevation, Format, Georeference, ImportOptions, PixelIs, VerticalUnit};

/// What a header's lines begin with.
const KEYS: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

/// Longest word that can be a number or a key.
const MOST_WORD: usize = 512;

/// Whether a file begins like one of these: with a key and a space.
pub(super) fn begins(head: &[u8]) -> bool {
    let word: Vec<u8> = head.iter().skip_while(|byte| byte.is_ascii_whitespace()).take(14).copied().collect();
    let Some(end) = word.iter().position(u8::is_ascii_whitespace) else { return false };
    KEYS.iter().any(|key| word[..end].eq_ignore_ascii_case(key.as_bytes()))
}

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let prj = source.companion("prj");
    let bytes = source.bytes;
    let mut words = Words { reader: &mut source.reader, word: String::new() };
    let (header, first) = Header::read(&mut words)?;
    let (columns, rows) = (header.whole("ncols")?, header.whole("nrows")?);
    // A digit and a space each, but for the last.
    if columns.saturating_mul(rows).saturating_mul(2) > bytes + 1 {
        return Err(Fault::Promises([columns, rows]));
    }
    let plan = Plan::new(columns, rows, options)?;
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let nodata = header.number("nodata_value").unwrap_or(-9999.0);
    let mut gatherer = Gatherer::<f64>::new(plan, order, &nodata_values(options, &[nodata]));

    let mut whole = true;
    let mut row = Vec::with_capacity(columns as usize);
    let (mut next, mut row_index) = (Some(first), 0u64);
    while !gatherer.is_full() {
        let value = match next.take() {
            Some(first) => first,
            None => words
                .number()?
                .ok_or(Fault::Truncated)?
                .map_err(|word| Fault::Damaged(format!("\"{}\" in row {row_index} is no number", one_line(&word))))?,
        };
        whole &= value.fract() == 0.0 && value.abs() < 2_147_483_648.0;
        row.push(value);
        if row.len() as u64 == columns {
            gatherer.push(&row);
            row.clear();
            row_index += 1;
        }
    }
    let mut elevation = gatherer.finish(Format::AsciiGrid)?;
    elevation.sample_type = if whole { "i32" } else { "f64" };
    let size = [columns as u32, rows as u32];
    elevation.georeference =
        header.place(rows).map(|place| place.with_projection_file(prj.as_deref(), size, &mut elevation.warnings));
    elevation.vertical_unit = Some(VerticalUnit::Metre);
    Ok(elevation)
}

/// The header's words and numbers.
struct Header(Vec<(String, f64)>);

impl Header {
    /// Reads up to the first sample, which is returned, too.
    fn read(words: &mut Words<impl BufRead>) -> Result<(Self, f64), Fault> {
        let mut entries: Vec<(String, f64)> = Vec::new();
        loop {
            let word = words.next()?.ok_or(Fault::Truncated)?;
            if let Ok(value) = word.parse::<f64>() {
                return Ok((Self(entries), value));
            }
            let key = word.to_ascii_lowercase();
            if !KEYS.contains(&key.as_str()) || entries.len() >= 2 * KEYS.len() {
                return Err(Fault::Damaged(format!("its header has \"{}\"", one_line(word))));
            }
            let value = words.number()?.ok_or(Fault::Truncated)?;
            let value =
                value.map_err(|word| Fault::Damaged(format!("the {key} \"{}\" is no number", one_line(&word))))?;
            entries.push((key, value));
        }
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == key).map(|(_, value)| *value)
    }

    fn whole(&self, key: &str) -> Result<u64, Fault> {
        let value = self.number(key).ok_or_else(|| Fault::Damaged(format!("its header has no {key}")))?;
        if value.fract() == 0.0 && (0.0..1e15).contains(&value) {
            Ok(value as u64)
        } else {
            Err(Fault::Damaged(format!("its {key} is {value}")))
        }
    }

    /// The place of the first, north-western sample.
    fn place(&self, rows: u64) -> Option<Georeference> {
        let cell = self.number("cellsize");
        let [dx, dy] = [self.number("dx").or(cell)?, self.number("dy").or(cell)?];
        let along = |corner: &str, centre: &str, step: f64| {
            self.number(centre)
                .map(|at| (at, PixelIs::Point))
                .or(self.number(corner).map(|at| (at + step * 0.5, PixelIs::Area)))
        };
        let (west, pixel) = along("xllcorner", "xllcenter", dx)?;
        let (south, _) = along("yllcorner", "yllcenter", dy)?;
        let north = south + dy * (rows.max(1) - 1) as f64;
        Some(Georeference { pixel, ..Georeference::new([west, north], [dx, -dy]) })
    }
}

/// The words of a text.
struct Words<'a, R> {
    reader: &'a mut R,
    word: String,
}

impl<R: BufRead> Words<'_, R> {
    /// The next word, or the end.
    fn next(&mut self) -> Result<Option<&str>, Fault> {
        self.word.clear();
        loop {
            let buffer = self.reader.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            let begin = if self.word.is_empty() {
                buffer.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(buffer.len())
            } else {
                0
            };
            let length = buffer[begin..].iter().position(u8::is_ascii_whitespace);
            let end = length.map_or(buffer.len(), |length| begin + length);
            self.word.extend(buffer[begin..end].iter().map(|&byte| char::from(byte)));
            self.reader.consume(end);
            if self.word.len() > MOST_WORD {
                return Err(Fault::Damaged(format!("\"{}…\" is no number", one_line(&self.word[..20.min(MOST_WORD)]))));
            }
            if length.is_some() && !self.word.is_empty() {
                break;
            }
        }
        Ok((!self.word.is_empty()).then_some(self.word.as_str()))
    }

    /// The next word as a number, or as it stands; `None` at the end.
    fn number(&mut self) -> Result<Option<Result<f64, String>>, Fault> {
        Ok(self.next()?.map(|word| word.parse::<f64>().map_err(|_| word.to_owned())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_across_the_ends_of_the_buffer() {
        let text = "  ncols 12\r\n\t-3.5e2   nan";
        for capacity in 1..12 {
            let mut reader = std::io::BufReader::with_capacity(capacity, text.as_bytes());
            let mut words = Words { reader: &mut reader, word: String::new() };
            let mut found = Vec::new();
            while let Some(word) = words.next().unwrap() {
                found.push(word.to_owned());
            }
            assert_eq!(found, ["ncols", "12", "-3.5e2", "nan"], "{capacity}");
        }
    }

    #[test]
    fn only_a_key_begins_a_grid() {
        assert!(begins(b"ncols 5") && begins(b"  NROWS\t5") && begins(b"XLLCENTER 1"));
        assert!(!begins(b"ncols") && !begins(b"ncolumns 5") && !begins(b"") && !begins(b"hello world"));
    }
}
