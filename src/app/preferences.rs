//! What is kept between runs: settings, keys, the window, bookmarks. A versioned TOML file in the platform's config folder,
//! `relief/settings.toml`; `RELIEF_CONFIG_DIR` names another folder.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::controls::{DEFAULT_SPEED, SPEED_RANGE};
use super::files::folders::{self, VARIABLE};
use crate::camera::Camera;
use crate::files;
use crate::scene::Scene;
use crate::scene_file;

/// The file's version; a newer one is not read.
pub(crate) const VERSION: u32 = 1;

/// Maps whose bookmarks are kept, the last used first.
const MOST_MAPS: usize = 100;

/// Smallest and largest zoom of panel and text.
pub(crate) const ZOOMS: std::ops::RangeInclusive<f32> = 0.5..=3.0;

/// Dark or light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Theme {
    /// What the desktop has; dark where it does not say.
    #[default]
    System,
    Dark,
    Light,
}

/// Whether the eye glides and parts of the interface move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Motion {
    /// As the desktop asks, where it can be asked.
    #[default]
    System,
    Full,
    Reduced,
}

/// What drags and the wheel do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mode {
    /// The mouse looks around, the wheel changes the speed.
    #[default]
    Fly,
    /// The mouse turns around the middle of the picture, the wheel goes towards the cursor.
    Orbit,
}

/// The window, physical pixels.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct WindowPlace {
    /// The inside, as it was last without filling the screen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size: Option<[u32; 2]>,
    /// The outside's upper left corner; absent where the window system does not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) position: Option<[i32; 2]>,
    pub(crate) maximised: bool,
}

/// Looks of the interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Interface {
    pub(crate) theme: Theme,
    pub(crate) motion: Motion,
    /// Size of panel and text, [`ZOOMS`].
    pub(crate) zoom: f32,
    pub(crate) panel: bool,
    pub(crate) overlay: bool,
    pub(crate) log: bool,
    /// The words for who is here for the first time are still to be shown.
    pub(crate) welcome: bool,
}

impl Default for Interface {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            motion: Motion::default(),
            zoom: 1.0,
            panel: true,
            overlay: false,
            log: false,
            welcome: true,
        }
    }
}

/// How frames are paced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Pace {
    pub(crate) vsync: bool,
    pub(crate) frame_limit: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Self { vsync: true, frame_limit: 0 }
    }
}

/// How the eye moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Moving {
    pub(crate) mode: Mode,
    pub(crate) speed: f64,
}

impl Default for Moving {
    fn default() -> Self {
        Self { mode: Mode::default(), speed: DEFAULT_SPEED }
    }
}

/// The views of a map that 1 to 9 go to.
pub(crate) type Bookmarks = BTreeMap<String, Camera>;

/// What belongs to a map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct MapNotes {
    /// Its file, absolute; absent for the map that is built in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) file: Option<PathBuf>,
    pub(crate) bookmarks: Bookmarks,
}

/// Everything that is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Preferences {
    pub(crate) window: WindowPlace,
    pub(crate) interface: Interface,
    pub(crate) pace: Pace,
    pub(crate) moving: Moving,
    /// Keys that differ from the table's, by action; an empty text is none.
    pub(crate) keys: BTreeMap<String, String>,
    /// What the keyboard's layout prints on keys, as far as it differs.
    pub(crate) key_labels: BTreeMap<String, String>,
    pub(crate) maps: Vec<MapNotes>,
}

impl Preferences {
    /// The bookmarks of a map.
    pub(crate) fn bookmarks(&self, file: Option<&Path>) -> Bookmarks {
        self.maps
            .iter()
            .find(|notes| notes.file.as_deref() == file)
            .map(|notes| notes.bookmarks.clone())
            .unwrap_or_default()
    }

    /// Keeps the bookmarks of a map, which thereby is the last used.
    pub(crate) fn set_bookmarks(&mut self, file: Option<&Path>, bookmarks: Bookmarks) {
        if self.bookmarks(file) == bookmarks {
            return;
        }
        self.maps.retain(|notes| notes.file.as_deref() != file);
        if !bookmarks.is_empty() {
            self.maps.insert(0, MapNotes { file: file.map(Path::to_path_buf), bookmarks });
        }
        self.maps.truncate(MOST_MAPS);
    }

    /// Puts what no viewer could use within its range: the file can be edited by hand.
    fn mend(mut self) -> Self {
        let Self { window, interface, moving, pace, maps, .. } = &mut self;
        interface.zoom =
            if interface.zoom.is_finite() { interface.zoom.clamp(*ZOOMS.start(), *ZOOMS.end()) } else { 1.0 };
        moving.speed = if moving.speed.is_finite() {
            moving.speed.clamp(*SPEED_RANGE.start(), *SPEED_RANGE.end())
        } else {
            DEFAULT_SPEED
        };
        pace.frame_limit = pace.frame_limit.min(1000);
        window.size = window.size.filter(|size| size.iter().all(|side| (64..=16384).contains(side)));
        window.position = window.position.filter(|place| place.iter().all(|at| at.abs() < 100_000));
        let usable =
            |camera: &Camera| scene_file::validate(&Scene { camera: Some(*camera), ..Scene::default() }).is_ok();
        for notes in maps.iter_mut() {
            notes.bookmarks.retain(|digit, camera| matches!(digit.as_bytes(), [b'1'..=b'9']) && usable(camera));
        }
        maps.truncate(MOST_MAPS);
        self
    }
}

/// The file.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Versioned {
    #[serde(default)]
    version: u32,
    #[serde(flatten)]
    preferences: Preferences,
}

/// Where the settings are kept.
#[derive(Debug)]
pub(crate) struct Store {
    /// Absent where the system has no folder for them.
    path: Option<PathBuf>,
    /// What the file holds, as far as is known.
    written: Preferences,
}

impl Store {
    /// The settings of the last run, where to keep them, and what has to be told about them. With `reset` the file is put
    /// aside first.
    pub(crate) fn open(reset: bool) -> (Self, Preferences, Vec<String>) {
        Self::at(folders::config().map(|folder| folder.join("settings.toml")), reset)
    }

    fn at(path: Option<PathBuf>, reset: bool) -> (Self, Preferences, Vec<String>) {
        let Some(path) = path else {
            let told = format!("Settings are not kept: the system names no folder for them. Set {VARIABLE} to one.");
            return (Self { path: None, written: Preferences::default() }, Preferences::default(), vec![told]);
        };
        let (preferences, told) = match read(&path) {
            Ok(None) => (Preferences::default(), None),
            Ok(Some(_)) if reset => {
                (Preferences::default(), Some(put_aside(&path, "The settings are those of a first start.")))
            }
            Ok(Some(read)) => (read, None),
            Err(reason) => {
                (Preferences::default(), Some(put_aside(&path, &format!("The settings could not be used: {reason}"))))
            }
        };
        (Self { path: Some(path), written: preferences.clone() }, preferences, told.into_iter().collect())
    }

    /// Whether the file holds something else.
    pub(crate) fn differs(&self, preferences: &Preferences) -> bool {
        self.path.is_some() && self.written != *preferences
    }

    /// Writes the settings, whole or not at all. After a failure nothing is written any more: it is told once.
    ///
    /// # Errors
    /// What the system says, with what to do.
    pub(crate) fn write(&mut self, preferences: &Preferences) -> Result<(), String> {
        let Some(path) = self.path.clone().filter(|_| self.differs(preferences)) else { return Ok(()) };
        self.written = preferences.clone();
        write(&path, preferences).map_err(|error| {
            self.path = None;
            format!(
                "The settings cannot be kept in {}: {error}. Make room there, or set {VARIABLE} to another folder.",
                path.display()
            )
        })
    }
}

fn write(path: &Path, preferences: &Preferences) -> io::Result<()> {
    let versioned = Versioned { version: VERSION, preferences: preferences.clone() };
    let toml = toml::to_string_pretty(&versioned).map_err(|error| io::Error::other(error.to_string()))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    files::write_whole(path, format!("# Relief's settings. They are written anew while it runs.\n\n{toml}").as_bytes())
}

/// The settings of a file, where there is one; or why not, in words.
fn read(path: &Path) -> Result<Option<Preferences>, String> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(format!("{error}.")),
    };
    // First the version alone: a newer file may mean something else by any other key.
    let table: toml::Table = toml::from_str(&text).map_err(|error| format!("{}.", error.message()))?;
    match table.get("version").and_then(toml::Value::as_integer) {
        Some(version) if version == i64::from(VERSION) => {}
        Some(version) if version > i64::from(VERSION) => {
            return Err(format!("a newer Relief wrote them (version {version})."));
        }
        _ => return Err("they do not say their version.".into()),
    }
    let versioned: Versioned = toml::from_str(&text).map_err(|error| format!("{}.", error.message()))?;
    Ok(Some(versioned.preferences.mend()))
}

/// Renames a file that is not to be lost, and says `why` and where it is now.
fn put_aside(path: &Path, why: &str) -> String {
    let free =
        (1..10_000).map(|number| path.with_file_name(format!("settings-{number}.toml"))).find(|path| !path.exists());
    match free.map(|aside| std::fs::rename(path, &aside).map(|()| aside)) {
        Some(Ok(aside)) => format!("{why} The old file is kept as {}.", aside.display()),
        Some(Err(error)) => {
            format!("{why} The old file could not be put aside ({error}) and will be overwritten: {}.", path.display())
        }
        None => {
            format!("{why} The old file will be overwritten: {}. Move some of those beside it away.", path.display())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Preferences {
        let window = WindowPlace { size: Some([900, 700]), position: Some([-20, 40]), maximised: true };
        let mut preferences = Preferences { window, ..Preferences::default() };
        preferences.interface.theme = Theme::Light;
        preferences.interface.zoom = 1.3;
        preferences.moving = Moving { mode: Mode::Orbit, speed: 0.123456789 };
        preferences.keys.insert("crater".into(), "Ctrl+Shift+X".into());
        preferences.key_labels.insert(";".into(), "Ö".into());
        let camera = Camera { eye: glam::DVec3::new(0.1, 1.0 / 3.0, 2.0), yaw: 10.0, pitch: -3.0, fov: 60.0 };
        preferences.set_bookmarks(Some(Path::new("/maps/a.tif")), Bookmarks::from([("3".into(), camera)]));
        preferences.set_bookmarks(None, Bookmarks::from([("9".into(), camera)]));
        preferences
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_was_written_is_read_again_and_a_reset_puts_it_aside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/down/settings.toml");
        let open = |reset| Store::at(Some(path.clone()), reset);
        let (mut store, first, told) = open(false);
        assert_eq!((first, told), (Preferences::default(), Vec::new()));
        assert!(!store.differs(&Preferences::default()), "a first start writes nothing by itself");
        store.write(&some()).unwrap();
        let (_, again, told) = open(false);
        assert_eq!((again, told), (some(), Vec::new()));
        let (store, reset, told) = open(true);
        assert_eq!(reset, Preferences::default());
        assert!(told[0].contains("settings-1.toml") && store.differs(&some()), "{told:?}");
        assert_eq!(names(path.parent().unwrap()), ["settings-1.toml"]);
    }

    #[test]
    fn an_unreadable_or_newer_file_is_kept_aside_and_told() {
        for (text, words) in [
            ("version = 2\ninterface = 7\n", "newer"),
            ("not toml at all", "could not be used"),
            ("version = 1\n[interface]\ntheme = \"pink\"\n", "pink"),
            ("[interface]\n", "version"),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("settings.toml");
            std::fs::write(&path, text).unwrap();
            let (mut store, preferences, told) = Store::at(Some(path.clone()), false);
            assert_eq!(preferences, Preferences::default());
            assert!(told.len() == 1 && told[0].contains(words), "{told:?}");
            assert_eq!(std::fs::read_to_string(folder.path().join("settings-1.toml")).unwrap(), text);
            store.write(&some()).unwrap();
            assert_eq!(names(folder.path()), ["settings-1.toml", "settings.toml"]);
        }
    }

    #[test]
    fn absurd_values_are_mended_and_a_folder_in_the_way_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let text = "version = 1\nunknown = 3\n[interface]\nzoom = 1e9\n[moving]\nspeed = nan\n[window]\nsize = [1, 900000]\n\
                    [[maps]]\n[maps.bookmarks.x]\neye = [0, 0, 0]\n[maps.bookmarks.2]\neye = [0, inf, 0]\n";
        std::fs::write(&path, text).unwrap();
        let (_, read, told) = Store::at(Some(path), false);
        assert!(told.is_empty(), "{told:?}");
        assert_eq!((read.interface.zoom, read.moving.speed, read.window.size), (3.0, DEFAULT_SPEED, None));
        assert!(read.maps[0].bookmarks.is_empty());

        std::fs::write(folder.path().join("file"), "").unwrap();
        let (mut store, _, _) = Store::at(Some(folder.path().join("file/settings.toml")), false);
        assert!(store.write(&some()).is_err_and(|told| told.contains(VARIABLE)));
        assert!(store.write(&Preferences { keys: BTreeMap::new(), ..some() }).is_ok(), "told once");
    }
}
