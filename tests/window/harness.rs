//! A virtual screen, the viewer on it, and hands: xdotool. The viewer tells its state in a JSON file, which is waited
//! on; nothing here sleeps and hopes.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use image::RgbaImage;
use relief::camera::Camera;
use relief::heightfield::HeightField;
use serde_json::Value;
use tempfile::TempDir;

use crate::desktop;

/// How long anything may take before it counts as never happening; a loaded machine draws slowly.
const PATIENCE: Duration = Duration::from_secs(120);

/// How often the status file is looked at.
const POLL: Duration = Duration::from_millis(15);

/// The settings that a viewer opens with.
const SETTINGS: &str = "version = 1\n[interface]\nwelcome = false\nmotion = \"full\"\ntheme = \"dark\"\n\
                        overlay = true\n";

/// Viewers at a time: while one waits for a key or a timer, another one draws.
const VIEWERS: usize = 2;

/// How many more viewers may open.
static TURNS: (Mutex<usize>, Condvar) = (Mutex::new(VIEWERS), Condvar::new());

/// A viewer's turn, until it goes.
struct Turn;

impl Turn {
    fn wait() -> Self {
        let left = TURNS.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut left = TURNS.1.wait_while(left, |left| *left == 0).unwrap_or_else(PoisonError::into_inner);
        *left -= 1;
        Self
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        *TURNS.0.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        TURNS.1.notify_one();
    }
}

/// Ends a program with its owner, also when a test panics.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only where the program has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The viewer on a screen of its own.
pub(crate) struct Window {
    // Dropped in this order: the viewer before its screen.
    viewer: Running,
    _screen: Running,
    display: String,
    id: String,
    folder: TempDir,
    labels: RefCell<BTreeSet<String>>,
    _turn: Turn,
}

/// `program` of the Debian package `package`.
fn command(program: &str, package: &str) -> Command {
    let found = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())
        .any(|folder| folder.join(program).is_file());
    assert!(found, "{program} is missing; it is in the package {package}: sudo apt-get install {package}");
    Command::new(program)
}

fn screen() -> (Running, String) {
    let mut xvfb = command("Xvfb", "xvfb");
    xvfb.args("-displayfd 1 -screen 0 1600x1200x24 -nolisten tcp".split(' '));
    let mut xvfb = Running(xvfb.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap());
    let mut number = String::new();
    BufReader::new(xvfb.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
    assert!(!number.trim().is_empty(), "Xvfb found no free display");
    (xvfb, format!(":{}", number.trim()))
}

/// `relief` with the software driver, unless another one is asked for.
pub(crate) fn relief() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_relief"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "WINIT_X11_SCALE_FACTOR", "RELIEF_SHADERS"] {
        command.env_remove(variable);
    }
    if std::env::var_os("RELIEF_ADAPTER").is_none() {
        command.env("RELIEF_ADAPTER", "cpu");
    }
    command
}

/// The height map that the viewer opens by default.
pub(crate) fn canyon() -> HeightField {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grand-canyon.png");
    relief::heightfield::load::load(&file).unwrap().field
}

impl Window {
    /// Opens the viewer with the words of `arguments`.
    pub(crate) fn open(arguments: &str) -> Self {
        Self::open_with(arguments, &[])
    }

    /// Opens the viewer with further environment variables.
    pub(crate) fn open_with(arguments: &str, environment: &[(&str, &str)]) -> Self {
        Self::open_on(arguments, environment, |_| ()).0
    }

    /// Opens the viewer on a screen that `prepare` has done something with; it is given the display's name.
    pub(crate) fn open_on<T>(
        arguments: &str,
        environment: &[(&str, &str)],
        prepare: impl FnOnce(&str) -> T,
    ) -> (Self, T) {
        let turn = Turn::wait();
        command("xdotool", "xdotool");
        let folder = tempfile::Builder::new().prefix("relief-window-").tempdir().unwrap();
        let (screen, display) = screen();
        let prepared = prepare(&display);
        let log = fs::File::create(folder.path().join("log")).unwrap();
        let mut viewer = relief();
        // Settings of its own, of somebody who is not here for the first time.
        let settings = folder.path().join("settings");
        fs::create_dir(&settings).unwrap();
        fs::write(settings.join("settings.toml"), SETTINGS).unwrap();
        viewer.env("RELIEF_CONFIG_DIR", &settings);
        // There is no desktop to ask for a dialogue.
        viewer.env("RELIEF_DIALOGUE", "own");
        viewer.env("DISPLAY", &display).envs(environment.iter().copied());
        viewer.arg("--status").arg(folder.path().join("status.json"));
        viewer.arg("--screenshots").arg(folder.path().join("shots"));
        viewer.args(arguments.split_whitespace()).stdout(Stdio::null()).stderr(log);
        let viewer = Running(viewer.spawn().unwrap());
        let labels = RefCell::default();
        let mut window = Self { viewer, _screen: screen, display, id: String::new(), folder, labels, _turn: turn };
        window.settled("the first picture", |status| number(&status["scene_frames"]) >= 1.0);
        let found = window.xdo("search --onlyvisible --name ^Relief");
        window.id = found.lines().next().expect("a window").trim().to_owned();
        // There is no window manager to give it the keyboard.
        window.xdo(&format!("windowfocus --sync {}", window.id));
        (window, prepared)
    }

    /// The window's number on its display.
    pub(crate) fn number(&self) -> u32 {
        self.id.parse().unwrap()
    }

    /// The name of its display.
    pub(crate) fn display(&self) -> &str {
        &self.display
    }

    /// What is on the screen inside the window, whoever drew it.
    pub(crate) fn screen(&self) -> RgbaImage {
        desktop::screen(&self.display, self.number())
    }

    /// Waits until the screen is as wanted: what the viewer has handed over need not be there yet.
    #[track_caller]
    pub(crate) fn screen_until(&self, what: &str, done: impl Fn(&RgbaImage) -> bool) -> RgbaImage {
        let start = Instant::now();
        loop {
            let screen = self.screen();
            if done(&screen) {
                return screen;
            }
            assert!(start.elapsed() < PATIENCE, "waited in vain for {what} on the screen; the log: {}", self.log());
            sleep(POLL);
        }
    }

    /// A file in the test's folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs xdotool with the words of `line`, in which `WINDOW` is the viewer's window.
    pub(crate) fn xdo(&self, line: &str) -> String {
        let line = line.replace("WINDOW", &self.id);
        self.xdo_words(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs a script of xdotool commands, a line each, in which `WINDOW` is the viewer's window.
    pub(crate) fn script(&self, lines: &str) {
        let file = self.path("script");
        fs::write(&file, lines.replace("WINDOW", &self.id)).unwrap();
        self.xdo_words(&[file.to_str().unwrap()]);
    }

    fn xdo_words(&self, words: &[&str]) -> String {
        let output = Command::new("xdotool").env("DISPLAY", &self.display).args(words).output().unwrap();
        assert!(output.status.success(), "xdotool {words:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Presses and releases a key, such as `ctrl+z`.
    pub(crate) fn key(&self, key: &str) {
        self.xdo(&format!("key {key}"));
    }

    /// Types into what has the keyboard.
    pub(crate) fn text(&self, text: &str) {
        self.xdo_words(&["type", "--delay", "15", "--", text]);
    }

    /// Puts the cursor on a pixel of the window.
    pub(crate) fn point(&self, x: f64, y: f64) {
        self.xdo(&format!("mousemove --window WINDOW {x:.0} {y:.0}"));
    }

    /// The state as it was last told.
    pub(crate) fn status(&mut self) -> Value {
        self.wait("a status", |_| true)
    }

    /// Waits until the state is as wanted.
    #[track_caller]
    pub(crate) fn wait(&mut self, what: &str, done: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        let mut last = Value::Null;
        loop {
            if let Some(end) = self.viewer.0.try_wait().unwrap() {
                panic!("the viewer ended ({end}) before {what}: {}", self.log());
            }
            if let Ok(status) = fs::read(self.folder.path().join("status.json")) {
                last = serde_json::from_slice(&status).expect("the status file is whole at any time");
                for widget in list(&last["widgets"]) {
                    let label = match text(&widget["label"]) {
                        "" => format!("a nameless {} at {}", text(&widget["role"]), widget["rect"]),
                        label => label.to_owned(),
                    };
                    self.labels.borrow_mut().insert(label);
                }
                if done(&last) {
                    return last;
                }
            }
            if start.elapsed() > PATIENCE {
                panic!("waited in vain for {what}; the last state: {last:#}; the log: {}", self.log());
            }
            sleep(POLL);
        }
    }

    /// Waits until the state is as wanted and nothing moves any more.
    #[track_caller]
    pub(crate) fn settled(&mut self, what: &str, done: impl Fn(&Value) -> bool) -> Value {
        self.wait(what, |status| status["idle"] == true && done(status))
    }

    /// Waits for an end that is no accident.
    pub(crate) fn close(mut self) {
        self.key("ctrl+q");
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(end) = self.viewer.0.try_wait().unwrap() {
                assert!(end.success(), "{end}: {}", self.log());
                assert!(!self.log().contains("panicked"), "{}", self.log());
                return;
            }
            sleep(POLL);
        }
        panic!("Ctrl+Q does not end the viewer");
    }

    /// What the viewer wrote to stderr.
    pub(crate) fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }

    /// The names of all widgets that have ever been seen.
    pub(crate) fn labels(&self) -> BTreeSet<String> {
        self.labels.borrow().clone()
    }

    /// The widget called `label`, scrolled into the window.
    #[track_caller]
    pub(crate) fn reveal(&mut self, label: &str) -> Value {
        for _ in 0..40 {
            let status = self.wait("a resting panel", calm);
            let found = widget(&status, label).unwrap_or_else(|| panic!("no {label:?} in {}", names(&status)));
            let (middle, height) = (centre(found)[1], number(&status["size"][1]));
            // A row that is only half in view cannot be trusted to take the click.
            if (8.0..height - 8.0).contains(&middle) {
                return found.clone();
            }
            let notch = if middle < 8.0 { 4 } else { 5 };
            self.point(40.0, height * 0.5);
            self.xdo(&format!("click {notch}"));
            let before = found["rect"].clone();
            self.wait("the panel to scroll", |status| widget(status, label).is_some_and(|now| now["rect"] != before));
        }
        panic!("{label:?} cannot be scrolled into view");
    }

    /// Clicks on the widget called `label`.
    #[track_caller]
    pub(crate) fn click(&mut self, label: &str) {
        let found = self.reveal(label);
        assert_eq!(found["disabled"], false, "{label:?} is disabled");
        let [left, right] = [number(&found["rect"][0]), number(&found["rect"][2])];
        self.point((left + right) * 0.5, centre(&found)[1]);
        self.xdo("click 1");
    }

    /// Holds the button down on a slider's rail, at a share of its width, until the state is as wanted. egui's sliders
    /// look at the button once a frame, so a click shorter than that would be missed.
    #[track_caller]
    pub(crate) fn slide(&mut self, label: &str, share: f64, done: impl Fn(&Value) -> bool) {
        let found = self.reveal(label);
        assert_eq!(found["disabled"], false, "{label:?} is disabled");
        let [left, right] = [number(&found["rect"][0]), number(&found["rect"][2])];
        self.point(left + share * (right - left), centre(&found)[1]);
        self.xdo("mousedown 1");
        self.wait(&format!("{label} to slide"), done);
        self.xdo("mouseup 1");
    }

    /// Opens or closes a section of the panel.
    #[track_caller]
    pub(crate) fn section(&mut self, name: &str, open: bool) {
        let header = self.reveal(name);
        if header["expanded"] != open {
            self.click(name);
            self.settled(name, |status| widget(status, name).is_some_and(|header| header["expanded"] == open));
        }
    }

    /// Replaces what stands in a field.
    #[track_caller]
    pub(crate) fn fill(&mut self, label: &str, content: &str) {
        self.click(label);
        self.key("ctrl+a");
        self.key("Delete");
        self.text(content);
        self.wait(content, |status| widget(status, label).is_some_and(|field| field["value"] == content));
    }

    /// Replaces the number in a field. A click on such a field opens it for typing.
    #[track_caller]
    pub(crate) fn fill_number(&mut self, label: &str, content: &str) {
        let before = number(&self.wait("rest", calm)["frame"]);
        self.click(label);
        self.wait("an open field", |status| number(&status["frame"]) >= before + 2.0);
        self.key("ctrl+a");
        self.text(content);
        self.key("Return");
    }

    /// The window's title.
    pub(crate) fn title(&self) -> String {
        self.xdo("getwindowname WINDOW")
    }

    /// Takes a screenshot with F12: the PNG's path and its pixels.
    #[track_caller]
    pub(crate) fn shot(&mut self) -> (PathBuf, RgbaImage) {
        let folder = self.path("shots");
        let pictures = || {
            let entries = fs::read_dir(&folder).into_iter().flatten().map(|entry| entry.unwrap().path());
            entries.filter(|path| path.extension().is_some_and(|ending| ending == "png")).collect::<BTreeSet<_>>()
        };
        let before = pictures();
        self.settled("a picture at rest", |_| true);
        self.key("F12");
        self.wait("a screenshot", |_| pictures().len() > before.len());
        let after = pictures();
        let path = after.difference(&before).next().unwrap().clone();
        assert!(path.with_extension("toml").exists(), "the scene is there before the picture");
        let picture = image::open(&path).unwrap().to_rgba8();
        self.settled("the message about the screenshot", |status| {
            list(&status["toasts"]).iter().any(|toast| text(toast).contains(&path.display().to_string()))
        });
        (path, picture)
    }
}

/// Whether the panel rests; the terrain may go on turning its cube or its sun, and the search for cones and the compiler may go
/// on behind it.
fn calm(status: &Value) -> bool {
    let clock = &status["scene"]["lighting"]["clock"];
    status["idle"] == true
        || status["scene"]["occluder"]["spin"] != 0.0
        || (clock["enabled"] == true && clock["speed"] != 0.0)
        || status["finding_cones"].is_number()
        || status["compiling"] == true
}

/// A number of the status.
#[track_caller]
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A text of the status.
#[track_caller]
pub(crate) fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no text"))
}

/// A list of the status; what is absent is empty.
pub(crate) fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// Whether a list of the status has a text.
pub(crate) fn has(value: &Value, wanted: &str) -> bool {
    list(value).iter().any(|entry| entry == wanted)
}

/// Whether a message was told.
pub(crate) fn told(status: &Value, words: &str) -> bool {
    list(&status["toasts"]).iter().any(|toast| text(toast).contains(words))
}

/// The eye of a status.
pub(crate) fn camera(status: &Value) -> Camera {
    serde_json::from_value(status["scene"]["camera"].clone()).unwrap()
}

/// A widget of a status.
pub(crate) fn widget<'a>(status: &'a Value, label: &str) -> Option<&'a Value> {
    list(&status["widgets"]).iter().find(|widget| widget["label"] == label)
}

fn names(status: &Value) -> String {
    list(&status["widgets"]).iter().map(|widget| text(&widget["label"])).collect::<Vec<_>>().join(", ")
}

/// The middle of a widget, physical pixels of the window.
pub(crate) fn centre(widget: &Value) -> [f64; 2] {
    [0, 1].map(|axis| (number(&widget["rect"][axis]) + number(&widget["rect"][axis + 2])) * 0.5)
}

/// How many pixels differ by more than `levels` in any channel.
pub(crate) fn differing(a: &RgbaImage, b: &RgbaImage, levels: u8) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    let differ =
        |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > levels);
    a.pixels().zip(b.pixels()).filter(|pair| differ(*pair)).count()
}
