//! What opening a map costs: start-up to the first picture, and the time to load a million samples of each format.
//!
//! `cargo bench --bench load` makes one map of 1024 × 1024 heights in every format, loads all in turn, and prints the medians;
//! `-- --quick` takes few rounds of a smaller one. Files are read from the system's cache.
#![expect(clippy::unwrap_used, reason = "a benchmark may fail loudly")]

use std::fs;
use std::hint::black_box;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use image::{DynamicImage, ImageBuffer, Luma, Rgb};
use relief::heightfield::export::{self, ExportFormat};
use relief::heightfield::generate::{Kind, generate};
use relief::heightfield::import::{Elevation, Encoding, ImportOptions, Listener};
use relief::heightfield::load;
use relief::render::PreparedTerrain;

/// How long a viewer may take for its first frame.
const PATIENCE: Duration = Duration::from_secs(60);

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let (side, rounds) = if quick { (512, 3) } else { (1024, 9) };
    let folder = tempfile::tempdir().unwrap();
    let maps = Maps::make(side, folder.path());
    start_up(&maps.folder.join("map.png"), side, if quick { 2 } else { 5 });

    println!("\nloading {side} × {side} samples, median of {rounds} interleaved rounds");
    println!("{:42} {:>10} {:>9} {:>16}", "", "MB", "ms", "ms per million");
    let mut times = vec![Vec::new(); maps.files.len()];
    let mut samples = vec![0.0; maps.files.len()];
    for _ in 0..rounds {
        for (((_, path, options), times), samples) in maps.files.iter().zip(&mut times).zip(&mut samples) {
            let start = Instant::now();
            let loaded = black_box(load::load_with(path, options, Listener::none()).unwrap());
            times.push(ms(start));
            *samples = f64::from(loaded.field.width()) * f64::from(loaded.field.height());
        }
    }
    for (((name, path, _), times), samples) in maps.files.iter().zip(&mut times).zip(samples) {
        let megabytes = fs::metadata(path).unwrap().len() as f64 / 1e6;
        row(name, &format!("{megabytes:.2}"), median(times), samples);
    }
    // What follows before the map is on screen, whatever its format.
    let field = Arc::new(load::load(&maps.files[0].1).unwrap().field);
    let mut times: Vec<f64> = (0..rounds)
        .map(|_| {
            let start = Instant::now();
            black_box(PreparedTerrain::new(Arc::clone(&field)).with_colours());
            ms(start)
        })
        .collect();
    row("then the pyramid and the colours", "", median(&mut times), f64::from(side) * f64::from(side));
}

fn row(name: &str, megabytes: &str, ms: f64, samples: f64) {
    println!("{name:42} {megabytes:>10} {ms:9.1} {:16.1}", ms / (samples / 1e6));
}

fn ms(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// From the start of the program to its first picture: without a window, and with one where there is a display.
fn start_up(map: &Path, side: u32, rounds: usize) {
    println!("start-up to the first picture of 640 × 400, median of {rounds}");
    println!("{:42} {:>10} {:>9}", "", "", "ms");
    let folder = map.parent().unwrap();
    let runs: [(&str, Vec<&str>); 2] =
        [("render, the Grand Canyon", vec![]), ("render, a map", vec![map.to_str().unwrap()])];
    for (name, arguments) in runs {
        let run = |_| {
            let start = Instant::now();
            let output = folder.join("picture.png");
            let done = Command::new(env!("CARGO_BIN_EXE_relief"))
                .arg("render")
                .args(&arguments)
                .args(["--size", "640x400", "-o"])
                .arg(output)
                .stderr(Stdio::null())
                .status()
                .unwrap();
            assert!(done.success(), "{name} failed");
            ms(start)
        };
        let mut times: Vec<f64> = (0..rounds).map(run).collect();
        println!(
            "{:42} {:>10} {:9.0}",
            format!("{name} of {side}²").replace("Canyon of 512²", "Canyon"),
            "",
            median(&mut times)
        );
    }
    if ["DISPLAY", "WAYLAND_DISPLAY"].iter().all(|name| std::env::var_os(name).is_none_or(|value| value.is_empty())) {
        println!("no display: the window's first frame is not timed");
        return;
    }
    let mut times: Vec<f64> =
        (0..rounds).map(|round| first_frame(map, &folder.join(format!("status-{round}.json")))).collect();
    println!("{:42} {:>10} {:9.0}", "the window's first frame, the same map", "", median(&mut times));
}

/// Ends the viewer also when something fails.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only where it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Milliseconds until the viewer says that it has drawn the scene.
fn first_frame(map: &Path, status: &Path) -> f64 {
    let start = Instant::now();
    let mut viewer = Command::new(env!("CARGO_BIN_EXE_relief"));
    viewer.arg(map).args(["--size", "640x400", "--status"]).arg(status);
    viewer.env("RELIEF_CONFIG_DIR", status.parent().unwrap().join("config")).stderr(Stdio::null());
    let _viewer = Running(viewer.spawn().unwrap());
    while start.elapsed() < PATIENCE {
        let told = fs::read(status).ok().and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
        if told.is_some_and(|told| told["scene_frames"].as_u64() > Some(0)) {
            return ms(start);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    f64::INFINITY
}

/// One map in every format.
struct Maps {
    folder: PathBuf,
    files: Vec<(String, PathBuf, ImportOptions)>,
}

impl Maps {
    fn make(side: u32, folder: &Path) -> Self {
        let mut maps = Self { folder: folder.into(), files: Vec::new() };
        let field = generate(Kind::Ridged, side, 7).with_range([0.0, 2500.0]);
        let step = [30.0 * f64::from(side - 1); 2];
        let elevation = Elevation::of_field(&field.with_extent_metres(Some(step)), None);
        for format in ["png", "tif", "asc", "flt", "r16", "r32"] {
            let path = folder.join(format!("map.{format}"));
            export::write(&elevation, None, ExportFormat::of(&path).unwrap(), &path).unwrap();
            let note = match format {
                "png" => "PNG, 16 bits",
                "tif" => "GeoTIFF, f32, Deflate",
                "asc" => "ESRI ASCII grid",
                "flt" => "ESRI binary grid, f32",
                "r16" => "raw, u16",
                _ => "raw, f32",
            };
            maps.add(note, path);
            // The next one has the same name but for its ending, and its own sidecar.
            let (from, to) = (folder.join("map.toml"), folder.join(format!("{format}.toml")));
            if from.exists() {
                fs::rename(from, &to).unwrap();
            }
        }
        maps.with_own_sidecars();
        let whole: Vec<i16> = (0..side * side)
            .map(|index| elevation.height_at(index % side, index / side).unwrap().round() as i16)
            .collect();
        maps.pictures(side, &whole);
        maps.plain(side, &whole);
        maps.dem(side, &whole);
        maps
    }

    fn add(&mut self, name: &str, path: PathBuf) {
        self.files.push((name.to_owned(), path, ImportOptions::default()));
    }

    /// Gives every map so far a name of its own, so that its sidecar is its own, too.
    fn with_own_sidecars(&mut self) {
        for (_, path, _) in &mut self.files {
            let ending = path.extension().unwrap().to_str().unwrap().to_owned();
            let (stem, sidecar) = (format!("{ending}-map"), self.folder.join(format!("{ending}.toml")));
            let own = self.folder.join(format!("{stem}.{ending}"));
            fs::copy(&path, &own).unwrap();
            if sidecar.exists() {
                fs::rename(sidecar, own.with_extension("toml")).unwrap();
            }
            let header = path.with_extension("hdr");
            if ending == "flt" && header.exists() {
                fs::rename(header, own.with_extension("hdr")).unwrap();
            }
            *path = own;
        }
    }

    fn pictures(&mut self, side: u32, whole: &[i16]) {
        let at = |x: u32, y: u32| whole[(y * side + x) as usize];
        let grey = ImageBuffer::from_fn(side, side, |x, y| Luma([(at(x, y) / 10) as u8]));
        for (name, file) in [("PNG, 8 bits", "grey.png"), ("JPEG", "grey.jpg"), ("WebP", "grey.webp")] {
            let path = self.folder.join(file);
            // The encoder of WebP takes colours only.
            let picture = DynamicImage::ImageLuma8(grey.clone());
            if file.ends_with("webp") { picture.to_rgb8().save(&path) } else { picture.save(&path) }.unwrap();
            self.add(name, path);
        }
        let packed = ImageBuffer::from_fn(side, side, |x, y| {
            let [high, low] = (i32::from(at(x, y)) + 32768).to_be_bytes()[2..] else { unreachable!("two bytes") };
            Rgb([high, low, 0])
        });
        let path = self.folder.join("tile.png");
        packed.save(&path).unwrap();
        let options = ImportOptions { encoding: Some(Encoding::Terrarium), ..ImportOptions::default() };
        self.files.push(("PNG, Terrarium".to_owned(), path, options));
        let path = self.folder.join("map.exr");
        exr::prelude::write_rgb_file(&path, side as usize, side as usize, |x, y| {
            let height = f32::from(at(x as u32, y as u32));
            (height, height, height)
        })
        .unwrap();
        let options = ImportOptions { variable: Some("R".into()), ..ImportOptions::default() };
        self.files.push(("OpenEXR, f32, one channel of three".to_owned(), path, options));
    }

    /// Formats that are little more than their samples.
    fn plain(&mut self, side: u32, whole: &[i16]) {
        let big: Vec<u8> = whole.iter().flat_map(|height| height.to_be_bytes()).collect();
        let little: Vec<u8> = whole.iter().flat_map(|height| height.to_le_bytes()).collect();
        let tiles = 1201usize;
        let tile =
            |index: usize| whole[(index / tiles % side as usize) * side as usize + index % tiles % side as usize];
        let hgt: Vec<u8> = (0..tiles * tiles).flat_map(|index| tile(index).to_be_bytes()).collect();
        let header = format!("ncols {side}\nnrows {side}\nnbits 16\npixeltype signedint\nbyteorder I\nlayout bil\n");
        let side16 = side as u16;
        let terragen = [
            b"TERRAGENTERRAIN SIZE".as_slice(),
            &(side16 - 1).to_le_bytes(),
            &[0; 2],
            b"ALTW",
            &16384u16.to_le_bytes(),
            &[0; 2],
            &little,
            b"EOF ",
        ]
        .concat();
        for (name, file, bytes) in [
            ("SRTM tile, 1201² samples", "N36W113.hgt", &hgt),
            ("ESRI .bil, i16", "map.bil", &little),
            ("Terragen", "map.ter", &terragen),
            ("netCDF classic, i16", "map.nc", &netcdf(side, &big)),
        ] {
            let path = self.folder.join(file);
            fs::write(&path, bytes).unwrap();
            self.add(name, path);
        }
        fs::write(self.folder.join("map.hdr"), header).unwrap();
    }

    /// One profile to a column, from south to north.
    fn dem(&mut self, side: u32, whole: &[i16]) {
        let mut head = vec![b' '; 1024];
        let mut put = |at: usize, text: &str| head[at..at + text.len()].copy_from_slice(text.as_bytes());
        put(156, &format!("{:6}{:6}", 1, 11));
        put(528, &format!("{:6}{:6}", 2, 2));
        put(816, &format!("{:>12}{:>12}{:>12}{:6}{:6}", "30.0", "30.0", "1.0", 1, side));
        let path = self.folder.join("profiles.dem");
        let mut file = fs::File::create(&path).unwrap();
        file.write_all(&head).unwrap();
        for column in 0..side {
            let heights: Vec<String> =
                (0..side).rev().map(|row| format!("{:6}", whole[(row * side + column) as usize])).collect();
            let west = 400_000.0 + 30.0 * f64::from(column);
            let start = format!(
                "{:6}{:6}{side:6}{:6}{west:24.1}{:24.1}{:24.1}{:24.1}{:24.1}",
                1,
                column + 1,
                1,
                4e6,
                0.0,
                0.0,
                0.0
            );
            let (first, rest) = heights.split_at(heights.len().min(146));
            file.write_all(format!("{:1024}", start + &first.concat()).as_bytes()).unwrap();
            for block in rest.chunks(170) {
                file.write_all(format!("{:1024}", block.concat()).as_bytes()).unwrap();
            }
        }
        self.add("USGS ASCII DEM", path);
    }
}

/// A netCDF-1 file with one variable, `z(y, x)` of 16-bit numbers.
fn netcdf(side: u32, samples: &[u8]) -> Vec<u8> {
    let mut bytes = b"CDF\x01".to_vec();
    let number = |bytes: &mut Vec<u8>, value: u32| bytes.extend(value.to_be_bytes());
    let name = |bytes: &mut Vec<u8>, name: &str| {
        bytes.extend((name.len() as u32).to_be_bytes());
        bytes.extend(name.as_bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    };
    number(&mut bytes, 0);
    [10, 2].iter().for_each(|&value| number(&mut bytes, value));
    for dimension in ["y", "x"] {
        name(&mut bytes, dimension);
        number(&mut bytes, side);
    }
    [0, 0, 11, 1].iter().for_each(|&value| number(&mut bytes, value));
    name(&mut bytes, "z");
    // Two dimensions, no attributes, shorts, their length and where they begin.
    [2, 0, 1, 0, 0, 3, samples.len() as u32].iter().for_each(|&value| number(&mut bytes, value));
    let begin = bytes.len() as u32 + 4;
    number(&mut bytes, begin);
    bytes.extend(samples);
    bytes
}
