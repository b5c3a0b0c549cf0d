//! Writing height maps: 16-bit greyscale PNG, whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::HeightField;
use crate::files;

/// Why a height map was not written. No part of it is left behind.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}\n  {reason}\n  check that its folder exists, may be written to, and has room")]
pub struct SaveError {
    /// What was to be written.
    pub path: PathBuf,
    /// What the system or the encoder says.
    pub reason: String,
}

/// Writes the map as 16-bit greyscale PNG: normalised height 0 becomes 0 and 1 becomes 65535.
pub fn save_png16(field: &HeightField, path: &Path) -> Result<(), SaveError> {
    let raw: Vec<u16> = field.samples().iter().map(|&height| (height * 65535.0).round() as u16).collect();
    save_raw_png16(field.width(), field.height(), &raw, path)
}

/// Writes `width` × `height` raw samples, row by row, as 16-bit greyscale PNG.
pub fn save_raw_png16(width: u32, height: u32, raw: &[u16], path: &Path) -> Result<(), SaveError> {
    let error = |reason: String| SaveError { path: path.into(), reason };
    if raw.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(error(format!("{} samples are not {width}×{height}", raw.len())));
    }
    // The encoder takes samples in the machine's own byte order.
    let bytes: Vec<u8> = raw.iter().flat_map(|sample| sample.to_ne_bytes()).collect();
    let encode = |file: &mut File| {
        let mut writer = BufWriter::new(file);
        PngEncoder::new(&mut writer)
            .write_image(&bytes, width, height, ExtendedColorType::L16)
            .map_err(io::Error::other)?;
        writer.flush()
    };
    files::write_with(path, encode).map_err(|reason| error(reason.to_string()))
}
