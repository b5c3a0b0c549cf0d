//! Parsers of untrusted bytes under mutated files: height maps, sidecars, scene files. No panic, no more memory than a
//! file of that length can be worth, and a message that says what, why and what to do.
//!
//! The mutations come from a fixed seed. `RELIEF_FUZZ_CASES=100000 cargo test --test fuzz` runs longer, and
//! `RELIEF_FUZZ_SEED` changes the seed.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

#[path = "common/memory.rs"]
mod memory;

use std::cell::Cell;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
use relief::heightfield::load::{self, LoadError};
use relief::scene::Scene;
use relief::scene_file;

use memory::peak_of;

/// Deflate's best compression.
const BEST_COMPRESSION: u64 = 1032;

/// What a PNG's head promises.
struct Promise {
    samples: u64,
    /// Bytes of the compressed rows, each with the byte that names its filter.
    packed: u64,
    /// Most bytes of the decoded picture: palettes become colours, and any picture may have one colour that is transparent.
    decoded: u64,
}

impl Promise {
    fn of(png: &[u8]) -> Option<Self> {
        let head = png.get(16..26).filter(|_| png.starts_with(b"\x89PNG\r\n\x1a\n"))?;
        let [width, height] = [0, 4].map(|at| u32::from_be_bytes(head[at..at + 4].try_into().unwrap())).map(u64::from);
        let (depth, [channels, expanded]) = (
            u64::from(head[8]),
            match head[9] {
                0 => [1, 2],
                2 => [3, 4],
                3 => [1, 4],
                4 => [2, 2],
                _ => [4, 4],
            },
        );
        let samples = width * height;
        let packed = ((width * channels * depth).div_ceil(8) + 1).saturating_mul(height);
        Some(Self { samples, packed, decoded: samples.saturating_mul(expanded * depth.div_ceil(8)) })
    }
}

/// Most bytes of memory that opening these bytes twice, as a file and from memory, may take, keeping the first map.
///
/// A file is worth the picture that its head promises, as far as its length can hold that: nothing is taken for a promise of
/// more than [`BEST_COMPRESSION`] allows. Then each sample costs the decoded picture, its luminance (2 bytes) and the
/// heights of two maps (4 bytes each). Beside the picture, chunks are kept as long as they are in vectors that grow by
/// doubling, and a colour profile is decompressed, up to the limit that the loader sets.
fn worth(png: &[u8]) -> usize {
    let kept = |promise: &Promise| promise.packed <= BEST_COMPRESSION * png.len() as u64;
    let picture = Promise::of(png).filter(kept).map_or(0, |promise| promise.decoded + 10 * promise.samples);
    let profile = if png.windows(4).any(|name| name == b"iCCP") { PROFILE } else { 0 };
    READING + 3 * png.len() + profile + picture as usize
}

/// What is taken for any file: 256 KiB to read ahead, the tables of the decompressor, a message.
const READING: usize = 320 << 10;

/// The loader's limit for a colour profile, 4 MiB, in a vector that grows by doubling.
const PROFILE: usize = 8 << 20;

/// Most bytes of memory that reading a text may take: each byte may be a bracket or a key of its own, of which the parser
/// keeps some hundred bytes while its vectors grow.
fn worth_of_text(length: usize) -> usize {
    (16 << 10) + 128 * length
}

/// The largest share of what it is worth that anything has taken, in %.
static NEAREST: AtomicUsize = AtomicUsize::new(0);

/// Fails where more was taken than it is worth.
#[track_caller]
fn assert_worth(peak: usize, worth: usize, what: &str) {
    assert!(peak <= worth, "{what} took {peak} bytes of memory and is worth {worth}");
    NEAREST.fetch_max(100 * peak / worth, Relaxed);
}

/// xorshift64*.
struct Dice(Cell<u64>);

impl Dice {
    fn new(stream: u64) -> Self {
        let seed = std::env::var("RELIEF_FUZZ_SEED").map_or(1, |seed| seed.parse::<u64>().unwrap());
        Self(Cell::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (stream + 1)))
    }

    fn next(&self) -> u64 {
        let mut bits = self.0.get();
        bits ^= bits >> 12;
        bits ^= bits << 25;
        bits ^= bits >> 27;
        self.0.set(bits);
        bits.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11
    }

    fn below(&self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

fn cases(usual: usize) -> usize {
    std::env::var("RELIEF_FUZZ_CASES").map_or(usual, |cases| cases.parse().unwrap())
}

/// Numbers that headers break on, as big-endian bytes.
const SIZES: [u32; 10] = [0, 1, 2, 0x7fff, 0x8000, 0x8001, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff];

/// One to four changes: bits, bytes, absurd sizes, cuts, repeats, pieces of another file.
fn mutated(dice: &Dice, file: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=dice.below(4) {
        let at = dice.below(bytes.len());
        match dice.below(8) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << dice.below(8),
            1 if !bytes.is_empty() => bytes[at] = dice.next() as u8,
            2 | 3 => {
                // Most headers stand in the first bytes.
                let at = if dice.below(2) == 0 { dice.below(bytes.len().min(48)) } else { at };
                let size = SIZES[dice.below(SIZES.len())].to_be_bytes();
                let end = bytes.len().min(at + 4);
                bytes.splice(at..end, size);
            }
            4 => bytes.truncate(at),
            5 => {
                let piece = bytes[at..bytes.len().min(at + 1 + dice.below(64))].to_vec();
                bytes.splice(at..at, piece);
            }
            6 => {
                let from = dice.below(other.len());
                let piece = &other[from..other.len().min(from + 1 + dice.below(128))];
                let end = bytes.len().min(at + piece.len());
                bytes.splice(at..end, piece.iter().copied());
            }
            _ => drop(bytes.drain(at..bytes.len().min(at + 1 + dice.below(16)))),
        }
    }
    bytes
}

/// Rewrites the checksum of each of a PNG's chunks: without that no mutation gets beyond them.
fn with_checksums(mut png: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while let Some(length) = png.get(at..at + 4) {
        let length = u32::from_be_bytes(length.try_into().unwrap()) as usize;
        let Some(end) = at.checked_add(8).and_then(|start| start.checked_add(length)) else { break };
        if png.len() < end.saturating_add(4) {
            break;
        }
        let sum = crc32(&png[at + 4..end]);
        png[end..end + 4].copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
    png
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 })
    })
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Small maps of every kind of sample.
fn maps() -> Vec<Vec<u8>> {
    let noise = |x: u32, y: u32| (x.wrapping_mul(40_503) ^ y.wrapping_mul(30_011)) as u16;
    let deep = ImageBuffer::from_fn(19, 13, |x, y| Luma([noise(x, y)]));
    let pictures = [
        DynamicImage::ImageLuma16(deep.clone()),
        DynamicImage::ImageLuma16(ImageBuffer::from_fn(300, 200, |x, y| Luma([(x * y) as u16]))),
        DynamicImage::ImageLuma8(ImageBuffer::from_fn(40, 40, |x, y| Luma([(x + y) as u8]))),
        DynamicImage::ImageLumaA8(ImageBuffer::from_fn(9, 9, |x, y| LumaA([x as u8, y as u8]))),
        DynamicImage::ImageRgb8(ImageBuffer::from_fn(16, 8, |x, y| Rgb([x as u8, y as u8, 7]))),
        DynamicImage::ImageRgba16(ImageBuffer::from_fn(5, 7, |x, y| Rgba([noise(x, y), 1, 2, 3]))),
        // Some 120 KB, of which a head could promise 120 MB.
        DynamicImage::ImageLuma16(ImageBuffer::from_fn(250, 240, |x, y| Luma([noise(x, y) ^ noise(y * y, x) >> 3]))),
    ];
    pictures.iter().map(|picture| encoded(picture, ImageFormat::Png)).collect()
}

/// What, why and what to do, a line each. An error from inside may have been quoted in several.
fn assert_helpful(message: &str) {
    let lines = message.lines().filter(|line| !line.trim().is_empty()).count();
    assert!(lines >= 3, "says not what, why and what to do: {message:?}");
    assert!(message.chars().all(|c| c == '\n' || !c.is_control()), "control characters in {message:?}");
    assert!(message.len() < 3000, "{} bytes of message: {}", message.len(), &message[..300]);
}

fn assert_map_holds(bytes: &[u8], path: &Path) -> bool {
    std::fs::write(path, bytes).unwrap();
    let (opened, peak) = peak_of(|| (load::load(path), load::load_bytes(path, bytes, None)));
    assert_worth(peak, worth(bytes), &format!("a file of {} bytes, kept as {},", bytes.len(), path.display()));
    for result in [&opened.0, &opened.1] {
        match result {
            Ok(loaded) => assert!(loaded.field.samples().iter().all(|height| (0.0..=1.0).contains(height))),
            Err(error) => assert_helpful(&error.to_string()),
        }
    }
    opened.0.is_ok()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// All in one test: the counters of memory are shared.
#[test]
fn mutated_files_end_in_a_map_a_scene_or_a_message() {
    height_maps();
    bombs();
    sidecars();
    scenes();
    println!("at most {} % of what a file is worth was taken", NEAREST.load(Relaxed));
}

fn height_maps() {
    let (dice, maps) = (Dice::new(0), maps());
    let path = file("fuzz-map.png");
    let (count, mut opened) = (cases(4000), 0);
    for case in 0..count {
        let (one, other) = (&maps[dice.below(maps.len())], &maps[dice.below(maps.len())]);
        let bytes = mutated(&dice, one, other);
        let bytes = if case % 4 == 0 { bytes } else { with_checksums(bytes) };
        opened += usize::from(assert_map_holds(&bytes, &path));
    }
    println!("{count} height maps, {opened} of them open");
    // A twelfth on every seed tried.
    assert!(opened > count / 25, "only {opened} of {count} got as far as the samples");
}

/// A PNG of these chunks, with right checksums.
fn png(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    for (name, data) in chunks {
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(*name);
        bytes.extend(*data);
        bytes.extend([0; 4]);
    }
    with_checksums(bytes)
}

fn header(width: u32, height: u32, depth: u8, colour: u8, interlaced: u8) -> Vec<u8> {
    [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, colour, 0, 0, interlaced]].concat()
}

/// Zeros as deflate compresses them best: about a thousand to one.
fn compressed_zeros(count: usize) -> Vec<u8> {
    // The data of an all-black picture, taken out of a PNG that holds one.
    let side = (count as f64).sqrt().ceil() as u32;
    let bytes = encoded(&DynamicImage::new_luma8(side, side), ImageFormat::Png);
    let mut data = Vec::new();
    let mut at = 8;
    while at + 8 <= bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        if &bytes[at + 4..at + 8] == b"IDAT" {
            data.extend(&bytes[at + 8..at + 8 + length]);
        }
        at += length + 12;
    }
    data
}

/// Headers that promise more than there is, and streams that hold more than they say.
fn bombs() {
    let path = file("fuzz-bomb.png");
    // Some 90 KB.
    let zeros = compressed_zeros(16 << 20);
    let end = (b"IEND", &[][..]);
    let mut count = 0;
    for (width, height) in SIZES.into_iter().flat_map(|width| SIZES.map(|height| (width, height))) {
        for (depth, colour) in [(1, 0), (8, 0), (16, 0), (8, 2), (16, 6), (8, 3), (16, 4), (77, 9)] {
            for interlaced in [0, 1] {
                let head = header(width, height, depth, colour, interlaced);
                let bytes = png(&[(b"IHDR", &head), (b"IDAT", &zeros[..64]), end]);
                let opened = assert_map_holds(&bytes, &path);
                // So much may be in there, and no more.
                let held = Promise::of(&bytes).unwrap().packed <= 64 * BEST_COMPRESSION;
                assert!(!opened || held, "{width}×{height}, {depth} bits, colour {colour}");
                count += 1;
            }
        }
    }
    // Sixteen megabytes behind a header of 2×2, and in chunks that are no picture: profiles and texts.
    let small = header(2, 2, 8, 0, 0);
    let hidden = [b"name\0\0".as_slice(), &zeros].concat();
    let text = [b"key\0\x01\0\0\0".as_slice(), &zeros].concat();
    let good = compressed_zeros(1);
    for chunks in [
        &[(b"IHDR", small.as_slice()), (b"IDAT", &zeros), end][..],
        &[(b"IHDR", small.as_slice()), (b"iCCP", &hidden), (b"IDAT", &good), end],
        &[(b"IHDR", small.as_slice()), (b"zTXt", &hidden), (b"IDAT", &good), end],
        &[(b"IHDR", small.as_slice()), (b"iTXt", &text), (b"IDAT", &good), end],
    ] {
        let bytes = png(chunks);
        assert_map_holds(&bytes, &path);
        count += 1;
    }
    println!("{count} bombs");
    let huge = png(&[(b"IHDR", &header(32768, 32768, 16, 6, 0)), (b"IDAT", &zeros[..64]), end]);
    let error = load::load_bytes(&path, &huge, None).unwrap_err();
    assert!(matches!(error, LoadError::Truncated { .. } | LoadError::TooLarge { .. }), "{error}");
}

const SIDECAR: &str = "title = \"Grand Canyon\"\nextent_metres = [31566.9, 31428.8]\nlowest_metre = 479.0\n\
    highest_metre = 2347.0\ncrs = \"EPSG:3857\"\nmetres_per_sample = 61.7\nvertical_exaggeration = 1.5\n\
    source = \"USGS\"\nlicence = \"public domain\"\n";

/// Words that numbers and tables break on.
const WORDS: [&str; 20] = [
    "nan",
    "-inf",
    "1e400",
    "-0.0",
    "1e-320",
    "9223372036854775808",
    "-1",
    "0",
    "\"",
    "[",
    "]",
    "{",
    "}",
    "=",
    "\n",
    "[[a]]",
    "a.b.c=",
    "'''",
    "\\u0000",
    "\u{fffd}",
];

/// Numbers of which some are out of any range.
const NUMBERS: [&str; 12] =
    ["0", "1", "2.5", "0.25", "-1", "-0.0", "1e-30", "1e10", "1e38", "1e400", "nan", "9223372036854775807"];

/// A mutated text: bytes as above, a word in place of another, or a number in place of one; the last leaves the text one of
/// its kind, so that what comes after the parser is tried, too.
fn mutated_text(dice: &Dice, text: &str, other: &str) -> Vec<u8> {
    let kind = dice.below(3);
    if kind == 0 {
        return mutated(dice, text.as_bytes(), other.as_bytes());
    }
    let mut words: Vec<String> = text.split_inclusive([' ', '\n', ',', '=']).map(str::to_owned).collect();
    let numbers: Vec<usize> = (0..words.len()).filter(|&at| number_in(&words[at]).is_some()).collect();
    for _ in 0..=dice.below(3) {
        if kind == 1 {
            let (at, word) = (dice.below(words.len()), WORDS[dice.below(WORDS.len())].to_owned());
            if dice.below(3) == 0 {
                words.insert(at, word);
            } else {
                words[at] = word;
            }
            continue;
        }
        let at = numbers[dice.below(numbers.len())];
        if let Some(old) = number_in(&words[at]).map(str::to_owned) {
            words[at] = words[at].replacen(&old, NUMBERS[dice.below(NUMBERS.len())], 1);
        }
    }
    words.concat().into_bytes()
}

/// The number that a word is, without the brackets and commas around it.
fn number_in(word: &str) -> Option<&str> {
    let number = word.trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '-');
    number.parse::<f64>().is_ok().then_some(number)
}

fn sidecars() {
    let dice = Dice::new(1);
    let map = &maps()[0];
    let path = file("fuzz-sidecar.png");
    std::fs::write(&path, map).unwrap();
    let (count, mut placed) = (cases(2000), 0);
    for _ in 0..count {
        let text = mutated_text(&dice, SIDECAR, "[terrain]\nheight_scale = 0.5\n");
        std::fs::write(path.with_extension("toml"), &text).unwrap();
        let (loaded, peak) = peak_of(|| load::load(&path));
        let loaded = loaded.unwrap_or_else(|error| panic!("a sidecar keeps its map from opening: {error}"));
        assert_worth(peak, worth(map) + worth_of_text(text.len()), "a sidecar");
        let size = loaded.field.box_size(None);
        let sound = size.is_finite() && (0.0..=1000.0).contains(&size.y) && size.x.min(size.z) >= 1e-5;
        assert!(sound, "{size} of {}", String::from_utf8_lossy(&text));
        for warning in &loaded.warnings {
            assert!(warning.contains("fuzz-sidecar") && warning.len() < 2000, "{warning}");
        }
        placed += usize::from(loaded.field.extent_metres().is_some());
    }
    // Nested as deep as a text can be.
    for deep in ["[".repeat(100_000), "a=".to_owned() + &"[".repeat(100_000), "a.".repeat(50_000), "{a=".repeat(30_000)]
    {
        std::fs::write(path.with_extension("toml"), &deep).unwrap();
        let (loaded, peak) = peak_of(|| load::load(&path));
        assert_worth(peak, worth(map) + worth_of_text(deep.len()), "a deep sidecar");
        assert!(!loaded.unwrap().warnings.is_empty());
    }
    println!("{count} sidecars, {placed} of them place their map");
    // A quarter on every seed tried.
    assert!(placed > count / 8, "only {placed} of {count} sidecars still place their map");
}

fn scenes() {
    let dice = Dice::new(2);
    let path = file("fuzz-scene.toml");
    let mut scene = Scene::default();
    scene.terrain.height_scale = Some(0.3);
    scene.craters.list = vec![scene.craters.brush_at(0.2, 0.3), scene.craters.brush_at(0.5, 0.6)];
    scene.camera = Some(relief::camera::Camera::look_at(glam::DVec3::ONE, glam::DVec3::ZERO, 60.0));
    let text = scene_file::to_toml(&scene).unwrap();
    let (count, mut read) = (cases(2000), 0);
    for _ in 0..count {
        let bytes = mutated_text(&dice, &text, SIDECAR);
        std::fs::write(&path, &bytes).unwrap();
        let (result, peak) = peak_of(|| scene_file::read(&path));
        assert_worth(peak, worth_of_text(bytes.len()), "a scene");
        match result {
            Ok(scene) => {
                read += 1;
                assert_eq!(scene_file::validate(&scene), Ok(()));
            }
            Err(error) => assert_helpful(&error.to_string()),
        }
    }
    for deep in ["[".repeat(100_000), "a=".to_owned() + &"[".repeat(100_000), "march.".repeat(50_000)] {
        std::fs::write(&path, &deep).unwrap();
        let (result, peak) = peak_of(|| scene_file::read(&path));
        assert_worth(peak, worth_of_text(deep.len()), "a deep scene");
        assert_helpful(&result.unwrap_err().to_string());
    }
    println!("{count} scenes, {read} of them are read");
    // A tenth on every seed tried; what is not read tries the parser alone.
    assert!(read > count / 20, "only {read} of {count} scenes are read");
}
