//! Bad elevation files of every format: cut short at ten places, with flipped bits in the header, with absurd sizes, and
//! mutated at random. Each ends in a map or in a message that says what, why and what to do, and takes no more memory
//! than a file of that length can be worth.
//!
//! `RELIEF_FUZZ_CASES=20000 cargo test --test formats_bad` runs longer.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

#[path = "common/memory.rs"]
mod memory;

use std::path::{Path, PathBuf};

use relief::heightfield::import::{Encoding, ImportOptions, Listener};
use relief::heightfield::load;

/// Most bytes of memory for a file of `length` bytes. What is packed best, by ZSTD and in tiles that are left out, stands
/// for 32,768 to 65,536 times its length; the rest is for decoders and messages.
fn allowance(length: usize, packed: bool) -> usize {
    if packed { (1 << 17) * length + (24 << 20) } else { 64 * length + (24 << 20) }
}

/// xorshift64*.
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as usize % end.max(1)
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats")
}

/// One file of each kind, and the companion without which it does not open.
const FILES: [(&str, Option<&str>); 22] = [
    ("tiff/int16-none-p1-strips.tif", None),
    ("tiff/float32-lzw-p3-tiles.tif", None),
    ("tiff/uint16-deflate-p2-strips.tif", None),
    ("tiff/uint8-packbits-p1-tiles.tif", None),
    ("tiff/float64-zstd-p3-strips.tif", None),
    ("special/bigtiff.tif", None),
    ("special/cog.tif", None),
    ("special/sparse.tif", None),
    ("special/planes.tif", None),
    ("special/jpeg.tif", None),
    ("other/grid.asc", None),
    ("other/grid.bil", Some("other/grid.hdr")),
    ("other/floats.flt", Some("other/floats.hdr")),
    ("other/terrain.ter", None),
    ("other/profile.dem", None),
    ("other/classic.nc", None),
    ("other/packed.nc", None),
    ("other/cdf5.nc", None),
    ("other/single.exr", None),
    ("other/half.exr", None),
    ("other/grey.jpg", None),
    ("other/grey.webp", None),
];

struct Case {
    name: &'static str,
    bytes: Vec<u8>,
    path: PathBuf,
}

impl Case {
    fn all() -> Vec<Self> {
        let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("formats-bad");
        std::fs::create_dir_all(&scratch).unwrap();
        let case = |(name, companion): (&'static str, Option<&str>)| {
            let path = scratch.join(name.replace('/', "-"));
            if let Some(companion) = companion {
                std::fs::copy(folder().join(companion), path.with_extension("hdr")).unwrap();
            }
            Self { name, bytes: std::fs::read(folder().join(name)).unwrap(), path }
        };
        FILES.into_iter().map(case).collect()
    }

    /// Whether these bytes open; if not, the message must help, and either way the memory must be within bounds.
    fn opens(&self, bytes: &[u8], what: &str) -> bool {
        std::fs::write(&self.path, bytes).unwrap();
        let options = ImportOptions {
            encoding: self.name.ends_with("webp").then_some(Encoding::Terrarium),
            ..ImportOptions::default()
        };
        let (result, peak) = memory::peak_of(|| load::load_with(&self.path, &options, Listener::none()));
        let packed = [".tif", ".exr", ".jpg", ".webp"].iter().any(|ending| self.name.ends_with(ending));
        assert!(peak <= allowance(bytes.len(), packed), "{} {what}: {peak} bytes for {}", self.name, bytes.len());
        match result {
            Ok(loaded) => {
                assert!(
                    loaded.field.samples().iter().all(|height| (0.0..=1.0).contains(height)),
                    "{} {what}",
                    self.name
                );
                let size = loaded.field.box_size(None);
                assert!(size.is_finite() && (0.0..=1000.0).contains(&size.y), "{} {what}: {size}", self.name);
                true
            }
            Err(error) => {
                let message = error.to_string();
                assert!(message.lines().count() >= 3, "{} {what}: {message}", self.name);
                assert!(message.chars().all(|c| c == '\n' || !c.is_control()), "{} {what}: {message:?}", self.name);
                assert!(message.len() < 3000, "{} {what}: {message}", self.name);
                false
            }
        }
    }
}

/// All in one test: the counters of memory are shared.
#[test]
fn bad_files_end_in_a_map_or_a_message() {
    let cases = Case::all();
    for case in &cases {
        assert!(case.opens(&case.bytes, "as it is"), "{}", case.name);
        truncated(case);
        flipped(case);
        absurd(case);
    }
    mutated(&cases);
}

fn truncated(case: &Case) {
    let length = case.bytes.len();
    let mut opened = 0;
    for tenth in 0..10 {
        opened += usize::from(case.opens(&case.bytes[..length * tenth / 10], &format!("cut at {tenth} tenths")));
    }
    // The end of a file may hold nothing that matters: an overview, padding, a picture that is read as far as it goes.
    assert!(opened <= 5, "{} opens {opened} times of ten although it is cut short", case.name);
}

fn flipped(case: &Case) {
    for at in 0..case.bytes.len().min(256) {
        let mut bytes = case.bytes.clone();
        for mask in [0x01, 0x80, 0xff] {
            bytes[at] = case.bytes[at] ^ mask;
            case.opens(&bytes, &format!("with byte {at} changed by {mask:#x}"));
        }
    }
}

/// Numbers that headers break on, in both orders of bytes, and as text.
fn absurd(case: &Case) {
    const NUMBERS: [u32; 6] = [0, 1, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff];
    for at in (0..case.bytes.len().saturating_sub(4).min(400)).step_by(2) {
        for number in NUMBERS {
            for order in [number.to_le_bytes(), number.to_be_bytes()] {
                let mut bytes = case.bytes.clone();
                bytes[at..at + 4].copy_from_slice(&order);
                case.opens(&bytes, &format!("with {number:#x} at byte {at}"));
            }
        }
    }
    if case.name.ends_with(".asc") {
        let text = String::from_utf8(case.bytes.clone()).unwrap();
        for number in ["999999999", "1e300", "-5", "nan", "0", "4294967296", "18446744073709551616"] {
            let huge = text.replacen("21", number, 1).replacen("18", number, 1);
            assert!(!case.opens(huge.as_bytes(), &format!("with {number} columns and rows")));
        }
    }
}

fn mutated(cases: &[Case]) {
    let count = std::env::var("RELIEF_FUZZ_CASES").map_or(3000, |count| count.parse().unwrap());
    let mut dice = Dice(0x9e37_79b9_7f4a_7c15);
    let mut opened = 0;
    for _ in 0..count {
        let case = &cases[dice.below(cases.len())];
        let mut bytes = case.bytes.clone();
        for _ in 0..=dice.below(4) {
            let at = dice.below(bytes.len());
            match dice.below(5) {
                0 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
                1 if at < bytes.len() => bytes[at] = dice.below(256) as u8,
                2 => bytes.truncate(at.max(1)),
                3 => drop(bytes.drain(at..bytes.len().min(at + 1 + dice.below(16)))),
                _ => {
                    let piece = bytes[at..bytes.len().min(at + 1 + dice.below(64))].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
        }
        opened += usize::from(case.opens(&bytes, "mutated"));
    }
    println!("{count} mutated files, {opened} of them open");
    assert!(opened > count / 50, "only {opened} of {count} got as far as the samples");
}
