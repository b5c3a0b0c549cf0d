//! What the report switches against a base frame, one change at a time, and the pictures that some of it needs.

use std::path::{Path, PathBuf};

use super::Job;
use super::settings::Setting;
use crate::heightfield::import::Georeference;
use crate::heightfield::{Crater, HeightField};
use crate::scene::light::{Shadows, SkyModel};
use crate::scene::{
    ColourSource, CraterMode, GroundColour, HeightFilter, Hillshade, LandSettings, MarchSettings, Scene, Technique,
    Water,
};

/// Craters took 40 % of the frames away, so that a frame took 1 / (1 − 0.4) times as long.
const CRATERS_IN_2009: f64 = 1.0 / 0.6;

/// The frame that changes are held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Base {
    /// The study's: `linear-binary` at its best.
    Study,
    /// The exact technique's, where all that is not a ray's walk weighs the more.
    Exact,
}

impl Base {
    /// What the table of this base frame is called.
    pub(super) fn table(self) -> &'static str {
        match self {
            Self::Study => "Table 1",
            Self::Exact => "Table 1 over the exact technique",
        }
    }
}

/// A frame to be timed.
pub(super) struct Variant {
    pub(super) name: String,
    pub(super) scene: Scene,
    /// The 2009 figure, where the study gives one, as a ratio of frame times.
    pub(super) in_2009: Option<f64>,
}

/// Ten craters in two rows, as a share of the box.
fn craters(job: &Job) -> Vec<Crater> {
    let extent = job.map.box_size(job.scene.terrain.height_scale);
    let place = |index: u32| (f64::from(index % 5) * 0.18 + 0.14, f64::from(index / 5) * 0.4 + 0.3);
    let crater = |(u, v): (f64, f64)| Crater { x: u * extent.x, z: v * extent.z, radius: 0.05, depth: 0.3, rim: 0.08 };
    (0..10).map(|index| crater(place(index))).collect()
}

/// The row of the flare.
const FLARE: &str = "lens flare, the sun in the picture's upper third";

/// The row of the craters that the study had.
const LAYERED: &str = "ten craters, layered (the study's way)";

/// A change's name and what it does to the base frame.
type Change<'a> = (&'static str, &'a dyn Fn(&mut Scene));

fn base_scene(scene: &Scene, base: Base) -> Scene {
    let mut scene = scene.clone();
    match base {
        Base::Study => Setting::BASE.apply(&mut scene.march),
        Base::Exact => scene.march = MarchSettings { technique: Technique::MaxMipmap, ..MarchSettings::default() },
    }
    scene.lighting.enabled = true;
    scene.lighting.shadows = Shadows::Off;
    (scene.lighting.baked, scene.lighting.occlusion) = (false, false);
    scene.skybox.model = SkyModel::Painted;
    scene.occluder.enabled = false;
    scene.materials.coverage.clear();
    scene.water = Water::default();
    (scene.air, scene.clouds, scene.flare) = Default::default();
    (scene.land, scene.diffuse.source) = (LandSettings::default(), ColourSource::Texture);
    scene
}

/// The base frame first, then one change at a time: of how the study's rays walk, of everything else, and each of the
/// techniques `able`.
pub(super) fn variants(job: &Job, scene: &Scene, base: Base, able: &[Technique], pictures: &Pictures) -> Vec<Variant> {
    let base_scene = base_scene(scene, base);
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = base_scene.clone();
        change(&mut scene);
        scene
    };
    let variant = |name: &str, change: &dyn Fn(&mut Scene)| Variant {
        name: name.to_owned(),
        scene: changed(change),
        in_2009: (base == Base::Study && name == LAYERED).then_some(CRATERS_IN_2009),
    };
    let mut variants = vec![variant("base frame", &|_| {})];
    if base == Base::Study {
        variants.extend(WALKS.iter().map(|(name, change)| variant(name, change)));
    }
    let mut add = |changes: &[Change<'_>]| variants.extend(changes.iter().map(|(name, change)| variant(name, change)));
    let list = craters(job);
    add(&[
        (LAYERED, &|scene| {
            (scene.craters.mode, scene.craters.list) = (CraterMode::Layered, list.clone());
        }),
        ("ten craters, baked", &|scene| scene.craters.list.clone_from(&list)),
        ("colours by height (a ramp) instead of a texture", &|scene| scene.land.colour = GroundColour::Ramp),
        ("colours by slope", &|scene| scene.land.colour = GroundColour::Slope),
        ("colours by aspect", &|scene| scene.land.colour = GroundColour::Aspect),
        ("contour lines", &|scene| scene.land.contours = true),
        ("hillshade from four directions instead of lighting", &|scene| {
            scene.land.hillshade = Hillshade::Multidirectional;
        }),
        ("without lighting", &|scene| scene.lighting.enabled = false),
        ("hard shadows", &|scene| scene.lighting.shadows = Shadows::Hard),
        ("soft shadows", &|scene| scene.lighting.shadows = Shadows::Soft),
        ("soft shadows, baked", &|scene| {
            (scene.lighting.shadows, scene.lighting.baked) = (Shadows::Soft, true);
        }),
        ("ambient occlusion", &|scene| scene.lighting.occlusion = true),
        ("the occluder", &|scene| scene.occluder.enabled = true),
        ("the occluder, hard shadows of it and of hills", &|scene| {
            (scene.occluder.enabled, scene.lighting.shadows) = (true, Shadows::Hard);
        }),
        ("light of a physical sky", &|scene| {
            (scene.skybox.enabled, scene.skybox.model) = (true, SkyModel::Physical);
        }),
        ("aerial perspective", &|scene| scene.air.perspective = true),
        ("height fog", &|scene| {
            scene.air.fog = true;
            scene.air.fog_base = job.map.range()[0];
        }),
        ("clouds (five layers)", &|scene| scene.clouds.enabled = true),
        ("clouds (five layers) and their shadows", &|scene| {
            (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
        }),
        (FLARE, &|scene| (scene.flare.enabled, scene.skybox.enabled) = (true, true)),
        ("materials instead of a diffuse texture", &|scene| {
            (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials);
        }),
        ("materials without relief", &|scene| {
            (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials);
            scene.materials.relief = 0.0;
        }),
        ("a sea over a third of the height", &|scene| {
            (scene.water.enabled, scene.water.level) = (true, Some(1.0 / 3.0));
        }),
        ("`smooth`: another surface, without creases", &|scene| scene.march.technique = Technique::Smooth),
        ("`fractal`: ground with invented detail", &|scene| scene.march.technique = Technique::Fractal),
    ]);
    if let Some(coverage) = &pictures.coverage {
        add(&[("materials by a coverage map", &|scene| {
            (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials);
            scene.materials.coverage = vec![coverage.clone()];
        })]);
    }
    if let Some(imagery) = &pictures.imagery {
        add(&[("a placed picture over all the ground", &|scene| scene.land.imagery = Some(imagery.clone()))]);
    }
    let texture = if base_scene.diffuse.enabled { "without a diffuse texture" } else { "with a diffuse texture" };
    add(&[(texture, &|scene| scene.diffuse.enabled = !scene.diffuse.enabled)]);
    if base == Base::Study {
        let techniques = able.iter().copied().filter(|&technique| technique != Setting::BASE.technique);
        variants.extend(
            techniques.map(|technique| {
                variant(&format!("`{}`", technique.name()), &|scene| scene.march.technique = technique)
            }),
        );
    }
    variants
}

/// A change's name and what it does, of how the rays of the study walk.
type Walk = (&'static str, fn(&mut Scene));

/// How the rays of the study walk.
const WALKS: [Walk; 5] = [
    ("without halvings", |scene| scene.march.binary_steps = 0),
    ("fixed steps (512) instead of by angle", |scene| scene.march.steps_by_angle = false),
    ("hardware-linear heights instead of exact", |scene| scene.march.filter = HeightFilter::HardwareLinear),
    ("nearest heights instead of exact", |scene| scene.march.filter = HeightFilter::Nearest),
    ("start at the lid of the box", |scene| scene.march.lower_start = false),
];

/// Pictures for as long as they are measured.
pub(super) struct Pictures {
    /// Weights of the materials: stripes of grass, rock, scree and snow.
    coverage: Option<PathBuf>,
    /// A picture of all the ground, which lies where the map does.
    imagery: Option<PathBuf>,
    _folder: Option<tempfile::TempDir>,
}

impl Pictures {
    /// Side in pixels of the coverage map and of the picture of the ground.
    const SIDES: [u32; 2] = [512, 1024];

    /// Writes them. What could not be written is told.
    pub(super) fn write(map: &HeightField, left_out: &mut Vec<String>) -> Self {
        let mut told = |what: &str, error: std::io::Error| {
            left_out.push(format!("Table 1, {what}: its picture could not be written: {error}"));
        };
        let folder = tempfile::Builder::new().prefix("relief-report-").tempdir();
        let folder = folder.map_err(|error| told("materials by a coverage map and a placed picture", error)).ok();
        let path = folder.as_ref().map(tempfile::TempDir::path);
        let coverage = path.and_then(|path| {
            coverage_map(path, Self::SIDES[0]).map_err(|error| told("materials by a coverage map", error)).ok()
        });
        let imagery = path.zip(map.georeference()).and_then(|(path, place)| {
            placed_picture(path, Self::SIDES[1], map, place).map_err(|error| told("a placed picture", error)).ok()
        });
        if map.georeference().is_none() {
            left_out.push("Table 1, a placed picture: the map does not say where it lies".to_owned());
        }
        Self { coverage, imagery, _folder: folder }
    }
}

fn coverage_map(folder: &Path, side: u32) -> std::io::Result<PathBuf> {
    let path = folder.join("coverage.png");
    let picture = image::RgbaImage::from_fn(side, side, |x, y| {
        let mut weights = [0; 4];
        weights[((x + y) / 32 % 4) as usize] = u8::MAX;
        image::Rgba(weights)
    });
    picture.save(&path).map_err(std::io::Error::other)?;
    Ok(path)
}

/// A picture of fields in green and brown with the world file that lays it over the map.
fn placed_picture(folder: &Path, side: u32, map: &HeightField, place: &Georeference) -> std::io::Result<PathBuf> {
    let path = folder.join("ground.png");
    let picture = image::RgbImage::from_fn(side, side, |x, y| {
        let field = (x / 24 * 7 + y / 40 * 13) % 5;
        image::Rgb([90 + 20 * field as u8, 130 - 10 * field as u8, 60])
    });
    picture.save(&path).map_err(std::io::Error::other)?;
    let cells = map.cells().map(f64::from);
    // From the middle of the first pixel to that of the last lie all the map's cells but half a pixel on each side.
    let [across, down] = cells.map(|cells| cells / f64::from(side));
    let [x, y] = place.at(0.5 * across, 0.5 * down);
    let step = |axis: [f64; 2], cells: f64| axis.map(|part| part * cells);
    let ([a, d], [b, e]) = (step(place.column, across), step(place.row, down));
    std::fs::write(folder.join("ground.pgw"), format!("{a}\n{d}\n{b}\n{e}\n{x}\n{y}\n"))?;
    Ok(path)
}
