//! The viewer in bad weather: storms of input and sizes, files that vanish, a GPU without memory.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use image::{GrayImage, ImageBuffer, Luma};

use crate::harness::{Window, differing, list, told};

/// Events of the storm.
const EVENTS: usize = 10_000;

/// Events in one script for xdotool.
const BATCH: usize = 500;

/// Keys that neither end the viewer nor open something of the system.
const KEYS: [&str; 39] = [
    "w",
    "a",
    "s",
    "d",
    "q",
    "e",
    "c",
    "c",
    "f",
    "x",
    "1",
    "5",
    "0",
    "period",
    "minus",
    "Tab",
    "Return",
    "space",
    "Escape",
    "Home",
    "End",
    "Left",
    "Right",
    "Up",
    "Down",
    "Prior",
    "Next",
    "BackSpace",
    "Delete",
    "F1",
    "F2",
    "F3",
    "F11",
    "ctrl+z",
    "ctrl+shift+BackSpace",
    "ctrl+a",
    "shift+Tab",
    "shift+w",
    "alt+Left",
];

/// xorshift64.
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}

/// A random event, or a press and a release, as lines for xdotool. A `click` of its own would wait in between.
fn event(dice: &mut Dice) -> String {
    let click = |button: usize| format!("mousedown {button}\nmouseup {button}");
    match dice.below(100) {
        0 if dice.below(10) == 0 => "key --delay 0 F12".to_owned(),
        0..30 => format!("key --delay 0 {}", KEYS[dice.below(KEYS.len())]),
        30..55 => format!("mousemove --window WINDOW {} {}", dice.below(760), dice.below(560)),
        55..67 => click(1 + dice.below(3)),
        67..75 => click(4 + dice.below(2)),
        75..81 => format!("mousedown {}", [1, 3][dice.below(2)]),
        81..90 => format!("mouseup {}", [1, 3][dice.below(2)]),
        90..94 => format!("keydown --delay 0 {}", ["w", "d", "shift"][dice.below(3)]),
        94..98 => format!("keyup --delay 0 {}", ["w", "d", "shift"][dice.below(3)]),
        _ => format!("windowsize WINDOW {} {}", 1 + dice.below(800), 1 + dice.below(600)),
    }
}

/// Nothing in the log but what a user should read.
fn assert_no_trouble(window: &Window) {
    let log = window.log();
    for trouble in ["panicked", "the GPU reported", "alidation", "RUST_BACKTRACE"] {
        assert!(!log.contains(trouble), "{trouble:?} in the log: {log}");
    }
}

/// A map so small that no technique takes long over it.
fn small_map(folder: &tempfile::TempDir) -> String {
    let map = GrayImage::from_fn(65, 49, |x, y| Luma([((x * 37) ^ (y * 91)) as u8]));
    let path = folder.path().join("small.png");
    map.save(&path).unwrap();
    path.display().to_string()
}

#[test]
fn ten_thousand_random_events_end_in_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!("{} --size 640x480", small_map(&folder));
    let mut window = Window::open_with(&arguments, &[("RUST_LOG", "relief=debug,wgpu=warn")]);
    let mut dice = Dice(4);
    let mut events = 0;
    while events < EVENTS {
        let mut script = String::new();
        let mut batch = 0;
        while batch < BATCH {
            let lines = event(&mut dice);
            batch += lines.lines().count();
            writeln!(script, "{lines}").unwrap();
        }
        window.script(&script);
        events += batch;
        // Alive, or this fails with the log.
        window.status();
        assert_no_trouble(&window);
    }
    window.script("keyup w\nkeyup d\nkeyup shift\nmouseup 1\nmouseup 3\nwindowsize WINDOW 640 480\nmousemove --window WINDOW 500 300\n");
    window.key("Escape");
    window.key("Home");
    window.wait("the size after the storm", |status| status["size"] == serde_json::json!([640, 480]));
    assert_no_trouble(&window);
    window.close();
}

#[test]
fn a_storm_of_sizes_ends_at_the_last() {
    let mut window = Window::open_with("--size 640x480", &[("RUST_LOG", "relief=debug,wgpu=warn")]);
    let mut dice = Dice(9);
    for round in 0..5 {
        let mut script = String::new();
        for index in 0..40 {
            // No window is smaller than a pixel; xdotool's 0 is the window system's error, not the viewer's.
            let side = |dice: &mut Dice, most: usize| if dice.below(5) == 0 { 1 } else { 1 + dice.below(most) };
            writeln!(script, "windowsize WINDOW {} {}", side(&mut dice, 1600), side(&mut dice, 1200)).unwrap();
            if index % 13 == 5 {
                writeln!(script, "windowunmap WINDOW\nwindowmap WINDOW").unwrap();
            }
        }
        let last = [320 + 16 * round, 240 + 8 * round];
        writeln!(script, "windowunmap WINDOW\nwindowmap --sync WINDOW\nwindowsize WINDOW {} {}", last[0], last[1])
            .unwrap();
        window.script(&script);
        window.wait("the last size", |status| status["size"] == serde_json::json!(last));
        assert_no_trouble(&window);
    }
    window.xdo("windowfocus --sync WINDOW");
    let (_, shot) = window.shot();
    assert_eq!(shot.dimensions(), (384, 272));
    window.close();
}

/// A file that is cut off, changed or deleted while it is being read.
#[test]
fn a_file_that_changes_while_it_is_read_ends_in_a_message_or_a_map() {
    let mut window = Window::open("--size 900x640");
    window.settled("rest", |_| true);
    let noise = |x: u32, y: u32| Luma([(x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)) as u16 >> 1]);
    let good = ImageBuffer::from_fn(1500, 1500, noise);
    let change = |path: &Path| match path.file_name().and_then(|name| name.to_str()) {
        Some("cut.png") => fs::OpenOptions::new().write(true).open(path).unwrap().set_len(1000).unwrap(),
        Some("gone.png") => fs::remove_file(path).unwrap(),
        _ => fs::write(path, "no picture any more").unwrap(),
    };
    for name in ["cut.png", "gone.png", "other.png"] {
        let path = window.path(name);
        good.save(&path).unwrap();
        window.fill("Terrain file", &path.display().to_string());
        window.key("Return");
        change(&path);
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let status =
            window.settled("an answer", |status| told(status, name) || told(status, &format!("Opened {stem}")));
        assert!(!list(&status["ledger"]["textures"]).is_empty(), "there is a picture still");
    }
    assert_no_trouble(&window);
    window.close();
}

/// Debug builds can pretend to have little memory on the GPU.
#[cfg(debug_assertions)]
#[test]
fn a_map_that_does_not_fit_on_the_gpu_leaves_the_old_one_there() {
    let mut window = Window::open_with("--size 900x640", &[("RELIEF_MEMORY_LIMIT", "3000000")]);
    let start = window.settled("rest", |_| true);
    let (_, before) = window.shot();
    let path = window.path("large.png");
    GrayImage::from_fn(1500, 1400, |x, y| Luma([(x ^ y) as u8])).save(&path).unwrap();
    window.fill("Terrain file", &path.display().to_string());
    window.key("Return");
    let refused = window.settled("a refusal", |status| told(status, "no memory"));
    assert!(told(&refused, "1500×1400") && told(&refused, "MiB") && told(&refused, "old terrain stays"), "{refused}");
    assert_eq!(refused["scene"], start["scene"]);
    let (_, after) = window.shot();
    assert_eq!(differing(&before, &after, 0), 0, "the old picture stays");
    assert_no_trouble(&window);
    window.close();
}
