//! Which height map and which scene: the defaults, then the scene file, then the options.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{CommandFactory, ValueEnum};
use glam::DVec3;

use super::args::{Cli, SceneArgs};
use super::failure::{Exit, Failure};
use super::progress::Progress;
use crate::camera::{Camera, NamedView};
use crate::gpu::Gpu;
use crate::heightfield::generate::{Recipe, recipe_file};
use crate::heightfield::import::{ImportOptions, Listener};
use crate::heightfield::{HeightField, LoadError, Loaded, gallery, load};
use crate::scene::{self, ColourSource, GroundColour, Hillshade, Scene};
use crate::scene_file;

/// Samples on a side that every adapter this program meets can hold in a texture.
const SMALL: u32 = 8192;

/// Where the height map comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// A file.
    File {
        /// Where it is.
        path: PathBuf,
        /// The scene file that names it, where one does.
        scene: Option<PathBuf>,
    },
    /// Made from the recipe of a scene that names no file.
    Recipe(Box<Recipe>),
    /// The Grand Canyon.
    BuiltIn,
}

impl Source {
    /// The map that `scene` names.
    pub(crate) fn of(scene: &Scene) -> Self {
        match (&scene.terrain.file, &scene.terrain.recipe) {
            (Some(path), _) => Self::File { path: path.clone(), scene: None },
            (None, Some(recipe)) => Self::Recipe(Box::new(recipe.clone())),
            (None, None) => Self::BuiltIn,
        }
    }

    /// The same, named by the file `named_by` and not by the user: a message about it names both.
    pub(crate) fn named_by(self, named_by: Option<&Path>) -> Self {
        match self {
            Self::File { path, .. } => Self::File { path, scene: named_by.map(Path::to_path_buf) },
            Self::Recipe(_) | Self::BuiltIn => self,
        }
    }

    /// The map of a composed scene.
    pub(crate) fn chosen(args: &SceneArgs, scene: &Scene) -> Self {
        Self::of(scene).named_by(args.scene.as_deref().filter(|_| args.file.is_none()))
    }

    /// What to call the map when it has no title.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::File { path, .. } => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            Self::Recipe(recipe) => recipe.title(),
            Self::BuiltIn => gallery::CANYON_NAME.to_owned(),
        }
    }

    /// Loads the map and finds an adapter.
    ///
    /// A map that any adapter takes is loaded first, so that what is wrong with it is told on every machine. A larger
    /// one is made to fit the adapter.
    pub(crate) fn load_for_gpu(&self, options: &ImportOptions) -> Result<(Arc<Gpu>, Loaded), Failure> {
        let (gpu, loaded) = self.load_to_fit(options)?;
        let gpu = gpu.map_or_else(Gpu::headless, Ok)?;
        let (adapter, driver) = gpu.adapter_name();
        log::debug!("drawn by {adapter} ({driver}), textures up to {} a side", gpu.capabilities.max_texture);
        Ok((gpu, loaded))
    }

    /// Loads the map so that the adapter can hold it. The adapter is only asked for where it matters.
    pub(crate) fn load_to_fit(&self, options: &ImportOptions) -> Result<(Option<Arc<Gpu>>, Loaded), Failure> {
        let small = ImportOptions { limit: Some(SMALL), refuse_larger: true, ..options.clone() };
        match self.open(&small) {
            Err(LoadError::Beyond { .. }) => {
                let gpu = Gpu::headless()?;
                let limit = Some(gpu.capabilities.max_texture);
                let loaded = self.load(&ImportOptions { limit, ..options.clone() })?;
                Ok((Some(gpu), loaded))
            }
            result => Ok((None, self.told(result)?)),
        }
    }

    /// Loads the map. Warnings go to stderr.
    pub(crate) fn load(&self, options: &ImportOptions) -> Result<Loaded, Failure> {
        self.told(self.open(options))
    }

    fn told(&self, result: Result<Loaded, LoadError>) -> Result<Loaded, Failure> {
        let loaded = result.map_err(|error| match self {
            Self::File { path, scene } => cannot_open(path, scene.as_deref(), error),
            Self::Recipe(_) | Self::BuiltIn => error.into(),
        })?;
        for warning in &loaded.warnings {
            super::warn(warning);
        }
        let (field, taken) = (&loaded.field, &loaded.taken);
        log::debug!(
            "{}: {}, {}, {}×{}{}, heights {:?}, extent in metres {:?}, place {:?}",
            self.name(),
            loaded.format.name(),
            loaded.sample_type,
            field.width(),
            field.height(),
            if taken.is_whole() { String::new() } else { format!(" of {taken:?}") },
            field.range(),
            field.extent_metres(),
            loaded.georeference
        );
        Ok(loaded)
    }

    fn open(&self, options: &ImportOptions) -> Result<Loaded, LoadError> {
        let progress = Progress::start(match self {
            Self::Recipe(_) => "generating",
            _ => "reading the height map",
        });
        match self {
            Self::Recipe(recipe) => {
                let field = recipe.make(recipe.size, &|share| progress.set(share), &AtomicBool::new(false))?;
                Ok(Loaded::made(field, recipe))
            }
            Self::File { path, .. } => load::load_with(path, options, listener(&|share| progress.set(share))),
            Self::BuiltIn => gallery::grand_canyon(),
        }
    }
}

/// Hears of progress. Here the whole program is what is cancelled.
pub(crate) fn listener(progress: &dyn Fn(f32)) -> Listener<'_> {
    static NEVER: AtomicBool = AtomicBool::new(false);
    Listener { progress, cancel: &NEVER }
}

/// Why `path`, which `scene` may name, does not open; a word that looks like a mistyped command is answered with the
/// command.
pub(crate) fn cannot_open(path: &Path, scene: Option<&Path>, error: LoadError) -> Failure {
    let missing = matches!(error, LoadError::NotFound { .. });
    let failure = Failure::from(error);
    if let Some(scene) = scene {
        return failure.line(format!(
            "The scene {} names it: correct terrain.file there, or name a map on the command line.",
            scene.display()
        ));
    }
    if !missing && path.extension().is_some_and(|extension| extension == "toml") {
        if recipe_file::read(path).is_ok() {
            let map = path.with_extension("png");
            let made =
                if map.exists() { format!("It made {}: open that, or make ", map.display()) } else { "Make ".into() };
            return Failure::new(Exit::BadInput, format!("cannot open {}", path.display()))
                .line("It is no map but a recipe for one.")
                .line(format!("{made}another with relief generate --recipe {} -o map.png.", path.display()));
        }
        return failure.line(format!("Or is it a scene? Then write --scene {}.", path.display()));
    }
    if let Some(value) = path.to_str().filter(|_| missing).filter(|word| is_value(word)) {
        return failure.line(format!(
            "Is {value} the value of an option? --contours and --hillshade take theirs with =, as in --contours=100."
        ));
    }
    match path.to_str().filter(|_| missing).and_then(meant_command) {
        Some(hint) => failure.line(hint),
        None => failure,
    }
}

/// Whether a word that is no file may be meant for an option whose value can be left out.
fn is_value(word: &str) -> bool {
    word.parse::<f64>().is_ok() || Hillshade::from_str(word, true).is_ok()
}

/// What to say about a word that may be a mistyped command: which one it may be, and which there are.
pub(crate) fn meant_command(word: &str) -> Option<String> {
    if word.is_empty() || !word.chars().all(char::is_alphanumeric) {
        return None;
    }
    let cli = Cli::command();
    let names: Vec<&str> =
        cli.get_subcommands().filter(|command| !command.is_hide_set()).map(clap::Command::get_name).collect();
    if names.contains(&word) {
        return None;
    }
    let similarity = |name: &str| strsim::jaro_winkler(word, name);
    let nearest = names.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    let nearest = nearest.filter(|name| similarity(name) > 0.8);
    let which = nearest.map_or_else(String::new, |name| format!("Or was the command `relief {name}` meant? "));
    Some(format!("{which}The commands are {}.", names.join(", ")))
}

/// The scene of the defaults, the scene file and the options. The camera follows once the map is known:
/// [`place_camera`].
pub(crate) fn compose(args: &SceneArgs) -> Result<Scene, Failure> {
    let mut scene = args.scene.as_deref().map(scene_file::read).transpose()?.unwrap_or_default();
    set_some(&mut scene.terrain.file, args.file.clone());
    set_some(&mut scene.terrain.height_scale, args.height_scale);

    let march = &mut scene.march;
    set(&mut march.technique, args.technique);
    set(&mut march.filter, args.filter);
    set(&mut march.binary_steps, args.binary_steps);
    if let Some([min, max]) = args.samples {
        (march.samples_min, march.samples_max) = (min, max);
    }
    march.steps_by_angle &= !args.fixed_steps;
    march.lower_start &= !args.no_lower_start;
    march.discard_misses &= !args.no_discard;

    if let Some(compare) = args.compare {
        compare.apply(&mut scene.compare);
    }

    scene.diffuse.enabled = (scene.diffuse.enabled || args.texture.is_some()) && !args.no_texture;
    set_some(&mut scene.diffuse.file, args.texture.clone());
    if !args.coverage.is_empty() {
        scene.materials.coverage.clone_from(&args.coverage);
        (scene.land.colour, scene.diffuse.source) = (GroundColour::Texture, ColourSource::Materials);
        scene.diffuse.enabled = true;
    }
    set(&mut scene.diffuse.repeats, args.repeats);
    args.land.apply(&mut scene);
    scene.lighting.enabled &= !args.no_lighting;
    if let Some([azimuth, elevation]) = args.sun {
        (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (azimuth, elevation);
    }
    if args.sun.is_some() {
        scene.lighting.clock.enabled = false;
    }
    if let Some(time) = args.time {
        time.set(&mut scene.lighting.clock);
    }
    set(&mut scene.lighting.shadows, args.shadows);
    scene.lighting.baked |= args.bake_shadows;
    scene.lighting.occlusion |= args.occlusion;
    set(&mut scene.skybox.model, args.sky);
    scene.skybox.enabled &= !args.no_skybox;
    scene.occluder.enabled |= args.occluder || args.occluder_at.is_some();
    set_some(&mut scene.occluder.position, args.occluder_at);

    if let Some(level) = args.water {
        level.set(&mut scene.water);
    }

    set(&mut scene.craters.mode, args.crater_mode);
    let craters: Vec<_> = args.craters.iter().map(|spec| spec.complete(&scene.craters)).collect();
    scene.craters.list.extend(craters);

    set(&mut scene.debug.view, args.debug);
    scene.debug.wireframe |= args.wireframe;
    Ok(scene)
}

/// Gives `scene` the camera that the options ask for, and checks the whole.
pub(crate) fn place_camera(args: &SceneArgs, scene: &mut Scene, map: &HeightField) -> Result<(), Failure> {
    args.land.exaggerate(scene, map);
    let extent = map.box_size(scene.terrain.height_scale);
    let before = scene.camera.unwrap_or_else(|| NamedView::Start.camera(map, extent));
    let mut camera = match args.view {
        Some(view) => Camera { fov: before.fov, ..view.camera(map, extent) },
        None if args.eye.is_some() || args.target.is_some() => {
            let (eye, target) = (args.eye.unwrap_or(before.eye), args.target.unwrap_or(extent * 0.5));
            aim(eye, target, before.fov)?
        }
        None => before,
    };
    set(&mut camera.fov, args.fov);
    if args.view.is_some() || camera != before {
        scene.camera = Some(camera);
    }
    scene_file::validate(scene).map_err(|reason| Failure::usage(reason.to_string()))
}

/// Tells of what in `scene` shows nothing.
pub(crate) fn warn_of(scene: &Scene, map: &HeightField) {
    for remark in scene::remarks(scene, map.box_size(scene.terrain.height_scale), map.metric_range()) {
        super::warn(&remark);
    }
}

fn aim(eye: DVec3, target: DVec3, fov: f64) -> Result<Camera, Failure> {
    if eye == target {
        let [x, y, z] = eye.to_array();
        return Err(Failure::usage(format!("the eye and its target are the same point, {x},{y},{z}"))
            .line("So there is no direction to look in.")
            .line("Move --eye or --target."));
    }
    Ok(Camera::look_at(eye, target, fov))
}

/// A picture's size that the adapter cannot draw.
pub(crate) fn check_size(size: [u32; 2], limit: u32) -> Result<(), Failure> {
    let [width, height] = size;
    if width.max(height) <= limit {
        return Ok(());
    }
    Err(Failure::new(Exit::Usage, format!("--size {width}x{height} is too large"))
        .line(format!("This adapter's pictures end at {limit} pixels a side."))
        .line(format!("Choose at most {limit}x{limit}.")))
}

fn set<T>(field: &mut T, given: Option<T>) {
    if let Some(given) = given {
        *field = given;
    }
}

fn set_some<T>(field: &mut Option<T>, given: Option<T>) {
    if given.is_some() {
        *field = given;
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::args::Command;
    use crate::scene::light::{Shadows, SkyModel};
    use crate::scene::{CraterMode, Technique};

    fn scene_args(arguments: &[&str]) -> SceneArgs {
        let all = ["relief", "render", "-o", "x.png"].iter().chain(arguments);
        match Cli::try_parse_from(all).unwrap().command {
            Some(Command::Render(render)) => render.scene,
            other => panic!("not render: {other:?}"),
        }
    }

    #[test]
    fn a_sea_has_a_level_in_shares_metres_or_its_usual_one() {
        use crate::scene::LevelUnit;

        let water = |level: &str| compose(&scene_args(&["--water", level])).unwrap().water;
        for (text, level, unit) in [
            ("auto", None, LevelUnit::Share),
            ("0.3", Some(0.3), LevelUnit::Share),
            ("-12.5m", Some(-12.5), LevelUnit::Metres),
        ] {
            let found = water(text);
            assert_eq!((found.enabled, found.level, found.levels), (true, level, unit), "{text}");
        }
        for text in ["", "deep", "nan", "1e9m"] {
            assert!(Cli::try_parse_from(["relief", "render", "-o", "x.png", "--water", text]).is_err(), "{text}");
        }
    }

    #[test]
    fn options_beat_the_scene_file_which_beats_the_defaults() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let text = "[march]\ntechnique = \"linear\"\nsamples_max = 300\n[lighting]\nambient = 0.5\n\
                    [craters]\nradius = 0.07\nlist = [{ x = 0.1, z = 0.2, radius = 0.1, depth = 0.1, rim = 0.1 }]\n";
        std::fs::write(&path, text).unwrap();
        let path = path.to_str().unwrap();
        let scene =
            compose(&scene_args(&["--scene", path, "--technique", "linear-binary", "--crater", "0.3,0.4"])).unwrap();
        assert_eq!(scene.march.technique, Technique::LinearBinary, "an option");
        assert_eq!((scene.march.samples_max, scene.lighting.ambient), (300, 0.5), "the file");
        assert_eq!(scene.march.samples_min, Scene::default().march.samples_min, "a default");
        let radii: Vec<f64> = scene.craters.list.iter().map(|crater| crater.radius).collect();
        assert_eq!(radii, [0.1, 0.07], "a crater of an option joins the file's and uses its brush");
    }

    #[test]
    fn every_flag_reaches_the_scene() {
        let flags = "--height-scale 0.5 --fixed-steps --samples 7..9 --binary-steps 0 --filter nearest \
            --compare linear@0.25 --no-lower-start --no-discard --no-texture --no-lighting --sun 10,20 --shadows soft --bake-shadows --occlusion --sky physical --no-skybox --occluder-at 1,2,3 \
            --crater-mode layered --debug normals --wireframe";
        let scene = compose(&scene_args(&flags.split_whitespace().collect::<Vec<_>>())).unwrap();
        let march = &scene.march;
        assert_eq!(scene.terrain.height_scale, Some(0.5));
        assert_eq!((march.samples_min, march.samples_max, march.binary_steps), (7, 9, 0));
        assert!(scene.compare.enabled && (scene.compare.technique, scene.compare.share) == (Technique::Linear, 0.25));
        assert!(!march.steps_by_angle && !march.lower_start && !march.discard_misses);
        assert!(!scene.diffuse.enabled && !scene.lighting.enabled && !scene.skybox.enabled);
        assert_eq!((scene.lighting.sun_azimuth, scene.lighting.sun_elevation), (10.0, 20.0));
        assert_eq!((scene.lighting.shadows, scene.skybox.model), (Shadows::Soft, SkyModel::Physical));
        assert!(scene.lighting.baked && scene.lighting.occlusion);
        let later = compose(&scene_args(&["--time", "2026-12-21T19:30"])).unwrap().lighting.clock;
        assert!(later.enabled && (later.year, later.month, later.day, later.hour) == (2026, 12, 21, 19.5));
        assert_eq!((scene.occluder.enabled, scene.occluder.position), (true, Some(DVec3::new(1.0, 2.0, 3.0))));
        assert_eq!(scene.craters.mode, CraterMode::Layered);
        assert!(scene.debug.wireframe && scene.debug.view == scene::DebugView::Normals);
    }

    #[test]
    fn the_file_of_the_scene_is_used_when_none_is_given() {
        let mut scene = Scene::default();
        assert_eq!(Source::of(&scene), Source::BuiltIn);
        scene.terrain.file = Some(PathBuf::from("a.png"));
        let Source::File { path, scene: None } = Source::of(&scene) else { panic!("not a file of no scene") };
        assert_eq!(path, PathBuf::from("a.png"));
    }

    #[test]
    fn a_mistyped_command_is_answered_with_the_command() {
        let source = |word: &str| Source::File { path: word.into(), scene: None };
        let answer = |word: &str| source(word).load(&ImportOptions::default()).unwrap_err().to_string();
        assert!(answer("rendr").contains("relief render"), "{}", answer("rendr"));
        assert!(answer("xyzzy").contains("The commands are view, render, report"), "{}", answer("xyzzy"));
        assert!(!answer("missing.png").contains("the command"));
    }

    #[test]
    fn the_eye_cannot_look_at_itself() {
        assert_eq!(aim(DVec3::ONE, DVec3::ONE, 60.0).unwrap_err().exit, Exit::Usage);
    }
}
