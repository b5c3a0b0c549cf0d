//! Scene files: a [`Scene`] as TOML, read with messages that name the line, written so that a picture can be made again.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::heightfield::HEIGHT_SCALES;
use crate::heightfield::generate::{Recipe, RecipeError};
use crate::heightfield::load::MAX_SIDE;
use crate::scene::light::Clock;
use crate::scene::{Scene, land};

/// Why a scene file could not be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    /// The file could not be read.
    #[error("cannot read the scene file {}\nThe system says: {reason}.\nCheck the path, and that the file may be read.", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// A key or a name that does not exist.
    #[error(
        "{}:{line}: there is no {kind} `{found}`\n{}alid here: {}.\nCorrect the line, or remove it.",
        path.display(),
        nearest.as_ref().map_or_else(|| "V".to_owned(), |nearest| format!("The nearest valid {kind} is `{nearest}`; v")),
        valid.join(", ")
    )]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// "key" or "name".
        kind: &'static str,
        /// What the file says.
        found: String,
        /// What it may have meant, where anything valid is like it.
        nearest: Option<String>,
        /// Everything that is valid in this place.
        valid: Vec<String>,
    },
    /// A table without a key that it cannot do without.
    #[error("{}:{line}: the key `{key}` is missing\nThe table there cannot do without it.\nAdd the key, or remove the table.", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The line of the table, from 1.
        line: usize,
        /// The key.
        key: String,
    },
    /// Not TOML, or a value of the wrong type.
    #[error("{}:{line}: {reason}\nA scene file is TOML; the README shows one.\nCorrect the line, or remove it.", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// Why.
        reason: String,
    },
    /// A value that no picture can be made with.
    #[error(
        "{}: {} cannot be {}\nIt must be {}.\nCorrect the value, or remove {}.",
        path.display(), reason.field, reason.value, reason.range, reason.removable()
    )]
    Value {
        /// The file.
        path: PathBuf,
        /// The field, its value and its range.
        reason: OutOfRange,
    },
    /// The scene cannot be expressed as TOML.
    #[error("cannot write the scene as TOML\n{0}\nGive files names that are valid Unicode.")]
    Write(#[from] toml::ser::Error),
}

/// A field outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} is {value}, but must be {range}")]
pub struct OutOfRange {
    /// The field as a path of keys, such as `march.samples_min`.
    pub field: String,
    /// Its value.
    pub value: String,
    /// The values it may have, in words.
    pub range: String,
}

impl OutOfRange {
    /// The same error of a field in the table `table`.
    fn inside(mut self, table: &str) -> Self {
        self.field = format!("{table}.{}", self.field);
        self
    }

    /// What can be removed from a scene file instead of being corrected: not every key has a default.
    fn removable(&self) -> &'static str {
        match self.field.as_str() {
            "camera.eye" => "the whole table: without it the view is the start view",
            field if field.starts_with("craters.list[") => "that crater",
            _ => "the key: it has a default",
        }
    }
}

/// Reads a scene. Relative paths in it become relative to the file's folder.
///
/// # Errors
/// The file cannot be read, is no TOML, has an unknown key, or a value outside its range.
pub fn read(path: &Path) -> Result<Scene, SceneFileError> {
    let text =
        std::fs::read_to_string(path).map_err(|reason| SceneFileError::Read { path: path.to_path_buf(), reason })?;
    let mut scene: Scene = toml::from_str(&text).map_err(|error| explain(path, &text, &error))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for file in files_mut(&mut scene) {
        // Joining an absolute path gives that path.
        *file = folder.join(&*file);
    }
    validate(&scene).map_err(|reason| SceneFileError::Value { path: path.to_path_buf(), reason })?;
    Ok(scene)
}

/// The scene as TOML. Relative paths become absolute, so that the text means the same wherever it is stored.
///
/// # Errors
/// A path is not valid Unicode, which TOML cannot express.
pub fn to_toml(scene: &Scene) -> Result<String, SceneFileError> {
    let mut scene = scene.clone();
    for file in files_mut(&mut scene) {
        // Without a current folder a relative path cannot be made absolute; it is kept.
        if let Ok(absolute) = std::path::absolute(&*file) {
            *file = absolute;
        }
    }
    Ok(toml::to_string_pretty(&scene)?)
}

/// All files that a scene names.
pub(crate) fn files(scene: &Scene) -> impl Iterator<Item = &PathBuf> {
    let faces = scene.skybox.faces.iter().flatten();
    let images = scene.diffuse.file.iter().chain(&scene.land.imagery).chain(&scene.materials.coverage);
    scene.terrain.file.iter().chain(images).chain(faces)
}

/// The same, to be changed.
fn files_mut(scene: &mut Scene) -> impl Iterator<Item = &mut PathBuf> {
    let faces = scene.skybox.faces.iter_mut().flatten();
    let images =
        scene.diffuse.file.iter_mut().chain(scene.land.imagery.iter_mut()).chain(&mut scene.materials.coverage);
    scene.terrain.file.iter_mut().chain(images).chain(faces)
}

/// Turns the parser's error into one that names the line and, for an unknown word, the nearest valid one.
pub(crate) fn explain(path: &Path, text: &str, error: &toml::de::Error) -> SceneFileError {
    let path = path.to_path_buf();
    let start = error.span().map_or(0, |span| span.start);
    let line = 1 + text.bytes().take(start).filter(|&byte| byte == b'\n').count();
    let message = error.message();
    // serde: "unknown field `a`, expected `b` or `c`", "unknown variant `a`, expected one of `b`, `c`, `d`".
    let kind = if message.starts_with("unknown field") { Some("key") } else { None };
    let kind = kind.or(message.starts_with("unknown variant").then_some("name"));
    let mut quoted = message.split('`').skip(1).step_by(2).map(str::to_owned);
    if let (Some(kind), Some(found)) = (kind, quoted.next()) {
        let valid: Vec<String> = quoted.collect();
        if !valid.is_empty() {
            let nearest = nearest(&found, &valid);
            return SceneFileError::Unknown { path, line, kind, found, nearest, valid };
        }
    }
    if let Some(key) = message.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
        return SceneFileError::Missing { path, line, key: key.to_owned() };
    }
    SceneFileError::Syntax { path, line, reason: message.to_owned() }
}

/// The candidate most like `word`, where one is so like it that it may have been meant: at most one letter of three is
/// wrong.
fn nearest(word: &str, candidates: &[String]) -> Option<String> {
    let word = word.to_lowercase();
    let distance = |candidate: &String| strsim::damerau_levenshtein(&word, candidate);
    let meant = |candidate: &&String| 3 * distance(candidate) <= word.chars().count().max(candidate.chars().count());
    candidates.iter().filter(meant).min_by_key(|candidate| distance(candidate)).cloned()
}

/// Checks that a picture can be made of `scene`: every number finite and inside its range. The renderer refuses a scene
/// that does not pass, so no NaN, infinity or number beyond single precision gets to a shader, wherever it came from.
///
/// Where 0 is in the range, −0 and numbers too small for single precision count as 0: that is what the uniforms hold.
///
/// # Errors
/// The first field that is not, with its range.
pub fn validate(scene: &Scene) -> Result<(), OutOfRange> {
    let Scene {
        terrain,
        camera,
        march,
        detail,
        compare,
        diffuse,
        land,
        materials,
        lighting,
        skybox,
        air,
        clouds,
        flare,
        occluder,
        debug,
        craters,
        water,
        // Nothing in it can be out of range.
        saved: _,
    } = scene;
    if let Some(scale) = terrain.height_scale {
        check("terrain.height_scale", scale, HEIGHT_SCALES)?;
    }
    if let Some(Err(RecipeError { field, value, instead, .. })) = terrain.recipe.as_ref().map(Recipe::validate) {
        return Err(OutOfRange { field: format!("terrain.recipe.{field}"), value, range: instead });
    }
    if let Some(camera) = camera {
        for value in camera.eye.to_array() {
            check("camera.eye", value, -FARTHEST..=FARTHEST)?;
        }
        check("camera.yaw", camera.yaw, -ANGLE..=ANGLE)?;
        check("camera.pitch", camera.pitch, -180.0..=180.0)?;
        check("camera.fov", camera.fov, FIELDS_OF_VIEW)?;
    }
    let steps = f64::from(MOST_SAMPLES);
    check("march.samples_min", march.samples_min, 1.0..=steps)?;
    // Without the angle the fewest steps are not used.
    let fewest = if march.steps_by_angle { f64::from(march.samples_min) } else { 1.0 };
    check("march.samples_max", march.samples_max, fewest..=steps)?;
    check("march.binary_steps", march.binary_steps, 0.0..=f64::from(MOST_HALVINGS))?;
    detail.validate()?;
    check("compare.share", compare.share, 0.0..=1.0)?;
    check("diffuse.repeats", diffuse.repeats, SMALLEST..=4096.0)?;
    land::validate(land)?;
    materials.validate()?;
    water.validate()?;
    check("lighting.sun_azimuth", lighting.sun_azimuth, -ANGLE..=ANGLE)?;
    check("lighting.sun_elevation", lighting.sun_elevation, -90.0..=90.0)?;
    check("lighting.ambient", lighting.ambient, 0.0..=100.0)?;
    check("lighting.diffuse", lighting.diffuse, 0.0..=100.0)?;
    check("lighting.specular", lighting.specular, 0.0..=100.0)?;
    check("lighting.shininess", lighting.shininess, SMALLEST..=10_000.0)?;
    check_clock(&lighting.clock)?;
    check("skybox.flattening", skybox.flattening, 0.01..=100.0)?;
    check("skybox.turbidity", skybox.turbidity, 1.7..=10.0)?;
    air.validate()?;
    clouds.validate()?;
    flare.validate()?;
    for value in occluder.position.iter().flat_map(DVec3::to_array) {
        check("occluder.position", value, -FARTHEST..=FARTHEST)?;
    }
    check("occluder.size", occluder.size, SMALLEST..=1000.0)?;
    for value in occluder.rotation.to_array() {
        check("occluder.rotation", value, -ANGLE..=ANGLE)?;
    }
    check("occluder.spin", occluder.spin, -ANGLE..=ANGLE)?;
    check("debug.heat_map_max", debug.heat_map_max, 1.0..=f64::from(u32::MAX))?;
    check("craters.layer_resolution", craters.layer_resolution, 2.0..=16384.0)?;
    check_crater(craters.radius, craters.depth, craters.rim).map_err(|reason| reason.inside("craters"))?;
    for (index, crater) in craters.list.iter().enumerate() {
        check("x", crater.x, -FARTHEST..=FARTHEST)
            .and_then(|()| check("z", crater.z, -FARTHEST..=FARTHEST))
            .and_then(|()| check_crater(crater.radius, crater.depth, crater.rim))
            .map_err(|reason| reason.inside(&format!("craters.list[{index}]")))?;
    }
    Ok(())
}

/// Farthest that anything may be from the origin, world units: there a double still tells micrometres of a box of one
/// metre apart, and no square of such a distance overflows single precision.
pub(crate) const FARTHEST: f64 = 1e10;
/// Vertical fields of view, degrees: from a box that fills the picture [`FARTHEST`] away to one whose corner rays are a
/// thousand times as long as the middle one.
pub(crate) const FIELDS_OF_VIEW: RangeInclusive<f64> = 1e-9..=179.9;
/// The least that a number which cannot be 0 may be: single precision holds it and a good share of it.
pub(crate) const SMALLEST: f64 = 1e-30;
/// Largest angle in degrees: many turns, yet exact to a thousandth of a degree.
const ANGLE: f64 = 1e9;
/// Most uniform samples per ray: as many as texels along the largest texture, several times over.
pub(crate) const MOST_SAMPLES: u32 = 65536;
/// Most halvings: the 24 bits of a single-precision distance cannot be halved more often.
pub(crate) const MOST_HALVINGS: u32 = 24;
/// Most steps of a walk over the pyramid: what the longest ray over the largest map that opens can take.
pub(crate) const MOST_STEPS: u32 = 16 * MAX_SIDE + 256;

fn check_clock(clock: &Clock) -> Result<(), OutOfRange> {
    check("lighting.clock.year", clock.year, 1900.0..=2100.0)?;
    check("lighting.clock.month", clock.month, 1.0..=12.0)?;
    check("lighting.clock.day", clock.day, 1.0..=31.0)?;
    check("lighting.clock.hour", clock.hour, 0.0..=24.0)?;
    let [latitude, longitude] = clock.place();
    check("lighting.clock.latitude", latitude, -90.0..=90.0)?;
    check("lighting.clock.longitude", longitude, -180.0..=180.0)?;
    check("lighting.clock.speed", clock.speed, -1000.0..=1000.0)
}

fn check_crater(radius: f64, depth: f64, rim: f64) -> Result<(), OutOfRange> {
    check("radius", radius, SMALLEST..=10.0)?;
    check("depth", depth, 0.0..=10.0)?;
    check("rim", rim, 0.0..=10.0)
}

/// Checks one number; NaN is inside no range.
pub(crate) fn check(field: &str, value: impl Into<f64>, range: RangeInclusive<f64>) -> Result<(), OutOfRange> {
    let value = value.into();
    if range.contains(&value) {
        return Ok(());
    }
    let range = format!("at least {} and at most {}", readable(*range.start()), readable(*range.end()));
    Err(OutOfRange { field: field.to_owned(), value: readable(value), range })
}

/// A number in as few characters as it takes: 1e38 has 39 digits.
pub(crate) fn readable(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) || !value.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::scene::Technique;

    fn read_text(text: &str) -> Result<Scene, SceneFileError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_nearest_valid_one() {
        let error = read_text("[march]\ntechnique = \"linear\"\nsample_max = 3\n").unwrap_err().to_string();
        assert!(error.contains("scene.toml:3: there is no key `sample_max`"), "{error}");
        assert!(error.contains("nearest valid key is `samples_max`"), "{error}");
        let error = read_text("[lightning]\nambient = 1\n").unwrap_err().to_string();
        assert!(error.contains("scene.toml:1:") && error.contains("`lighting`"), "{error}");
    }

    #[test]
    fn an_unknown_technique_is_named_with_the_nearest_one() {
        let error = read_text("\n[march]\ntechnique = \"max-mipmaps\"\n").unwrap_err().to_string();
        assert!(error.contains(":3: there is no name `max-mipmaps`"), "{error}");
        assert!(error.contains("nearest valid name is `max-mipmap`"), "{error}");
    }

    /// A suggestion that has nothing to do with the word sends people the wrong way.
    #[test]
    fn a_word_like_nothing_valid_gets_the_list_and_no_suggestion() {
        for (text, listed) in [
            ("[air]\naerial = true\n", "perspective"),
            ("[air]\nenabled = true\n", "fog_scale"),
            ("[march]\ntechnique = \"voxels\"\n", "max-mipmap"),
        ] {
            let error = read_text(text).unwrap_err().to_string();
            assert!(!error.contains("nearest") && error.contains("\nValid here: "), "{error}");
            assert!(error.contains(listed), "{error}");
        }
        for (text, meant) in [
            ("[air]\nfog_densty = 1\n", "`fog_density`"),
            ("[air]\nVisibility = 1\n", "`visibility`"),
            ("[march]\nbinary_step = 1\n", "`binary_steps`"),
        ] {
            let error = read_text(text).unwrap_err().to_string();
            assert!(error.contains(&format!("is {meant}; valid here: ")), "{error}");
        }
    }

    /// The advice of an error is not to lead to the next one.
    #[test]
    fn only_what_has_a_default_is_to_be_removed() {
        for (text, advice) in [
            ("[camera]\neye = [0.0, inf, 0.0]", "remove the whole table"),
            ("[camera]\neye = [0.0, 0.0, 0.0]\nfov = 180.0", "remove the key: it has a default"),
            ("[craters]\nlist = [{ x = 0.5, z = 0.5, radius = 0.0, depth = 0.1, rim = 0.0 }]", "remove that crater"),
        ] {
            let error = read_text(text).unwrap_err().to_string();
            assert!(error.contains(advice), "{error}");
        }
        let error = read_text("[march]\n[camera]\nyaw = 3.0\n").unwrap_err().to_string();
        assert!(
            error.contains("scene.toml:2: the key `eye` is missing") && error.contains("remove the table"),
            "{error}"
        );
    }

    #[test]
    fn broken_toml_names_the_line() {
        let error = read_text("[march]\nsamples_max = \n").unwrap_err().to_string();
        assert!(error.contains("scene.toml:2:"), "{error}");
        let error = read_text("[march]\nsamples_max = \"many\"\n").unwrap_err().to_string();
        assert!(error.contains("scene.toml:2:"), "{error}");
    }

    #[test]
    fn values_outside_their_range_are_named() {
        for (text, field) in [
            ("[terrain]\nheight_scale = -1.0", "terrain.height_scale"),
            ("[terrain]\nheight_scale = nan", "terrain.height_scale"),
            ("[camera]\neye = [0.0, inf, 0.0]", "camera.eye"),
            ("[camera]\neye = [0.0, 0.0, 0.0]\nfov = 180.0", "camera.fov"),
            ("[lighting.clock]\nmonth = 13", "lighting.clock.month"),
            ("[lighting.clock]\nlatitude = 91.0", "lighting.clock.latitude"),
            ("[skybox]\nturbidity = 1.0", "skybox.turbidity"),
            ("[march]\nsamples_min = 0", "march.samples_min"),
            ("[march]\nsamples_min = 9\nsamples_max = 8", "march.samples_max"),
            (
                "[craters]\nlist = [{ x = 0.5, z = 0.5, radius = 0.0, depth = 0.1, rim = 0.0 }]",
                "craters.list[0].radius",
            ),
        ] {
            let error = read_text(text).unwrap_err().to_string();
            assert!(error.contains(field) && error.contains("It must be"), "{text}: {error}");
        }
    }

    #[test]
    fn a_scene_written_and_read_again_is_the_same() {
        let mut scene = Scene { camera: Some(Camera::look_at(DVec3::ONE, DVec3::ZERO, 50.0)), ..Scene::default() };
        scene.march.technique = Technique::Linear;
        scene.occluder.position = Some(DVec3::new(0.1, 0.2, 0.3));
        let brush = scene.craters.brush_at(0.25, 0.75);
        scene.craters.list.push(brush);
        assert_eq!(read_text(&to_toml(&scene).unwrap()).unwrap(), scene);
    }

    #[test]
    fn paths_are_relative_to_the_scene_file_and_written_absolute() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, "terrain.file = \"maps/a.png\"\n").unwrap();
        let scene = read(&path).unwrap();
        assert_eq!(scene.terrain.file, Some(folder.path().join("maps/a.png")));

        let mut scene = Scene::default();
        scene.diffuse.file = Some(PathBuf::from("rock.png"));
        let again: Scene = toml::from_str(&to_toml(&scene).unwrap()).unwrap();
        assert_eq!(again.diffuse.file, Some(std::env::current_dir().unwrap().join("rock.png")));
    }

    #[test]
    fn the_default_scene_is_valid() {
        assert_eq!(validate(&Scene::default()), Ok(()));
    }

    #[test]
    fn a_flat_terrain_is_valid() {
        assert_eq!(read_text("terrain.height_scale = 0").unwrap().terrain.height_scale, Some(0.0));
        assert!(read_text("terrain.height_scale = 1000.1").is_err());
    }
}
