//! The study's Table 1, remade: what each feature costs, as a ratio to one base frame.

use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use super::rounds::{Times, has_turn, plan};
use super::settings::Setting;
use super::studio::Studio;
use super::sweep::{ROUNDS, first_line};
use super::{Halt, Job};
use crate::heightfield::Crater;
use crate::render::RenderError;
use crate::scene::light::{Shadows, SkyModel};
use crate::scene::{
    ColourSource, CraterMode, GroundColour, HeightFilter, Hillshade, LandSettings, Scene, Technique, Water,
};

/// A feature that is switched against the base frame.
#[derive(Clone, Debug, Serialize)]
pub struct Feature {
    /// What differs from the base frame.
    pub name: String,
    /// Its cost in each view.
    pub views: Vec<FeatureCost>,
    /// The 2009 figure, where the study gives one, as a ratio of frame times.
    pub in_2009: Option<f64>,
}

/// What a feature costs in one view.
#[derive(Clone, Debug, Serialize)]
pub struct FeatureCost {
    /// The view.
    pub view: String,
    /// Times of the frame.
    pub times: Times,
    /// Their median over the base frame's.
    pub ratio: f64,
}

/// Craters took 40 % of the frames away, so that a frame took 1 / (1 − 0.4) times as long.
const CRATERS_IN_2009: f64 = 1.0 / 0.6;

/// Ten craters in two rows, as a share of the box.
fn craters(job: &Job) -> Vec<Crater> {
    let extent = job.map.box_size(job.scene.terrain.height_scale);
    let place = |index: u32| (f64::from(index % 5) * 0.18 + 0.14, f64::from(index / 5) * 0.4 + 0.3);
    let crater = |(u, v): (f64, f64)| Crater { x: u * extent.x, z: v * extent.z, radius: 0.05, depth: 0.3, rim: 0.08 };
    (0..10).map(|index| crater(place(index))).collect()
}

/// The flare's row.
const FLARE: &str = "lens flare, the sun in the picture's upper third";

/// A feature's name, its figure of 2009, and what it changes in the base frame.
type Change<'a> = (&'static str, Option<f64>, &'a dyn Fn(&mut Scene));

/// The base frame first, then one change at a time, and each of the techniques `able`.
fn variants(job: &Job, scene: &Scene, able: &[Technique], coverage: &[PathBuf]) -> Vec<(String, Scene, Option<f64>)> {
    let mut base = scene.clone();
    Setting::BASE.apply(&mut base.march);
    base.lighting.enabled = true;
    base.lighting.shadows = Shadows::Off;
    (base.lighting.baked, base.lighting.occlusion) = (false, false);
    base.skybox.model = SkyModel::Painted;
    base.occluder.enabled = false;
    base.materials.coverage.clear();
    base.water = Water::default();
    (base.air, base.clouds, base.flare) = Default::default();
    (base.land, base.diffuse.source) = (LandSettings::default(), ColourSource::Texture);
    let list = craters(job);
    let changes: [Change<'_>; 33] = [
        ("base frame", None, &|_| {}),
        ("without halvings", None, &|scene| scene.march.binary_steps = 0),
        ("fixed steps (512) instead of by angle", None, &|scene| scene.march.steps_by_angle = false),
        ("hardware-linear heights instead of exact", None, &|scene| scene.march.filter = HeightFilter::HardwareLinear),
        ("nearest heights instead of exact", None, &|scene| scene.march.filter = HeightFilter::Nearest),
        ("start at the lid of the box", None, &|scene| scene.march.lower_start = false),
        ("ten craters, layered (the study's way)", Some(CRATERS_IN_2009), &|scene| {
            (scene.craters.mode, scene.craters.list) = (CraterMode::Layered, list.clone());
        }),
        ("ten craters, baked", None, &|scene| scene.craters.list.clone_from(&list)),
        ("colours by height (a ramp) instead of a texture", None, &|scene| scene.land.colour = GroundColour::Ramp),
        ("colours by slope", None, &|scene| scene.land.colour = GroundColour::Slope),
        ("colours by aspect", None, &|scene| scene.land.colour = GroundColour::Aspect),
        ("contour lines", None, &|scene| scene.land.contours = true),
        ("hillshade from four directions instead of lighting", None, &|scene| {
            scene.land.hillshade = Hillshade::Multidirectional;
        }),
        ("without lighting", None, &|scene| scene.lighting.enabled = false),
        ("hard shadows", None, &|scene| scene.lighting.shadows = Shadows::Hard),
        ("soft shadows", None, &|scene| scene.lighting.shadows = Shadows::Soft),
        ("soft shadows, baked", None, &|scene| {
            (scene.lighting.shadows, scene.lighting.baked) = (Shadows::Soft, true);
        }),
        ("ambient occlusion", None, &|scene| scene.lighting.occlusion = true),
        ("the occluder", None, &|scene| scene.occluder.enabled = true),
        ("the occluder, hard shadows of it and of hills", None, &|scene| {
            (scene.occluder.enabled, scene.lighting.shadows) = (true, Shadows::Hard);
        }),
        ("light of a physical sky", None, &|scene| {
            (scene.skybox.enabled, scene.skybox.model) = (true, SkyModel::Physical);
        }),
        ("aerial perspective", None, &|scene| scene.air.perspective = true),
        ("height fog", None, &|scene| {
            scene.air.fog = true;
            scene.air.fog_base = job.map.range()[0];
        }),
        ("clouds (five layers)", None, &|scene| scene.clouds.enabled = true),
        ("clouds (five layers) and their shadows", None, &|scene| {
            (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
        }),
        (FLARE, None, &|scene| (scene.flare.enabled, scene.skybox.enabled) = (true, true)),
        ("materials instead of a diffuse texture", None, &|scene| {
            (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials);
        }),
        ("materials without relief", None, &|scene| {
            (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials);
            scene.materials.relief = 0.0;
        }),
        ("materials by a coverage map", None, &|scene| {
            (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials);
            scene.materials.coverage = coverage.to_vec();
        }),
        ("a sea over a third of the height", None, &|scene| {
            (scene.water.enabled, scene.water.level) = (true, Some(1.0 / 3.0));
        }),
        ("`smooth`: another surface, without creases", None, &|scene| scene.march.technique = Technique::Smooth),
        ("`fractal`: ground with invented detail", None, &|scene| scene.march.technique = Technique::Fractal),
        ("without a diffuse texture", None, &|scene| scene.diffuse.enabled = !scene.diffuse.enabled),
    ];
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = base.clone();
        change(&mut scene);
        scene
    };
    let features = changes.into_iter().map(|(name, known, change)| {
        let name =
            if name.ends_with("diffuse texture") && !base.diffuse.enabled { "with a diffuse texture" } else { name };
        (name.to_owned(), changed(change), known)
    });
    let techniques = able.iter().copied().filter(|&technique| technique != Setting::BASE.technique);
    let techniques = techniques.map(|technique| {
        (format!("`{}`", technique.name()), changed(&|scene| scene.march.technique = technique), None)
    });
    features.chain(techniques).collect()
}

/// Samples along each side of the coverage map that is measured.
const COVERAGE: u32 = 512;

/// A coverage map for as long as it is measured: stripes of grass, rock, scree and snow.
fn coverage_map() -> std::io::Result<tempfile::TempPath> {
    let file = tempfile::Builder::new().prefix("relief-coverage-").suffix(".png").tempfile()?;
    let picture = image::RgbaImage::from_fn(COVERAGE, COVERAGE, |x, y| {
        let mut weights = [0; 4];
        weights[((x + y) / 32 % 4) as usize] = u8::MAX;
        image::Rgba(weights)
    });
    picture.save_with_format(file.path(), image::ImageFormat::Png).map_err(std::io::Error::other)?;
    Ok(file.into_temp_path())
}

/// Measures every feature in every view, `budget_s` seconds each. `able` are the techniques that could be prepared.
pub(super) fn measure(
    studio: &mut Studio,
    job: &Job,
    (scene, able): (&Scene, &[Technique]),
    budget_s: f64,
    features: &mut Vec<Feature>,
    left_out: &mut Vec<String>,
    tell: &dyn Fn(f64) -> bool,
) -> Result<(), Halt> {
    left_out.push(String::from(
        "Table 1, depth output: rays write their own depth, or nothing could be hidden by hills; it cannot be switched off",
    ));
    let imagery = "Table 1, placed imagery: it needs a picture that says where it lies, and a map that does";
    left_out.push(imagery.to_owned());
    let coverage = coverage_map();
    let files: Vec<_> = coverage.iter().map(|file| file.to_path_buf()).collect();
    let mut variants = variants(job, scene, able, &files);
    if let Err(error) = &coverage {
        left_out.push(format!("Table 1, materials by a coverage map: none could be written: {error}"));
        variants.retain(|(name, ..)| name != "materials by a coverage map");
    }
    *features = variants
        .iter()
        .map(|(name, _, known)| Feature { name: name.clone(), views: Vec::new(), in_2009: *known })
        .collect();
    let (began, views) = (Instant::now(), job.views.len());
    for (index, (view, camera)) in job.views.iter().enumerate() {
        // Frames that are slow even when each is drawn as rarely as may be: better fewer views than fewer frames.
        if index > 0 && began.elapsed().as_secs_f64() > budget_s * views as f64 {
            let names: Vec<_> = job.views[index..].iter().map(|(name, _)| name.as_str()).collect();
            left_out.push(format!("Table 1, because it would take too long: {}", names.join(", ")));
            break;
        }
        for (_, scene, _) in &mut variants {
            scene.camera = Some(*camera);
            if scene.flare.enabled {
                scene.lighting.sun_azimuth = camera.yaw as f32;
                scene.lighting.sun_elevation = (camera.pitch + 0.35 * camera.fov).clamp(1.0, 80.0) as f32;
            }
        }
        let share = |done: f64| (index as f64 + done) / views as f64;
        let times = view_times(studio, job, &variants, budget_s, left_out, &|done| tell(share(done)))?;
        let base = times.first().and_then(|times| Times::of(times));
        for (feature, times) in features.iter_mut().zip(&times) {
            if let Some((times, base)) = Times::of(times).zip(base) {
                feature.views.push(FeatureCost { view: view.clone(), times, ratio: times.ms / base.ms });
            }
        }
    }
    features.retain(|feature| !feature.views.is_empty());
    Ok(())
}

fn view_times(
    studio: &mut Studio,
    job: &Job,
    variants: &[(String, Scene, Option<f64>)],
    budget_s: f64,
    left_out: &mut Vec<String>,
    tell: &dyn Fn(f64) -> bool,
) -> Result<Vec<Vec<f64>>, Halt> {
    let began = Instant::now();
    let mut first = Vec::new();
    for (name, scene, _) in variants {
        if tell(0.0) {
            return Err(Halt::Asked);
        }
        match studio.frame(scene).and_then(|_| studio.frame(scene)) {
            Ok(ms) => first.push(Some(ms)),
            Err(error @ (RenderError::Unsupported { .. } | RenderError::Impossible { .. })) => {
                let note = format!("Table 1, {name}: {}", first_line(&error));
                if !left_out.contains(&note) {
                    left_out.push(note);
                }
                first.push(None);
            }
            Err(error) => return Err(error.into()),
        }
    }
    let rounds = ROUNDS[usize::from(job.quick)];
    let frame_ms: Vec<f64> = first.iter().map(|ms| ms.unwrap_or(0.0)).collect();
    let counts = plan(&frame_ms, rounds, (budget_s - began.elapsed().as_secs_f64()) * 1e3);
    let mut times = vec![Vec::new(); variants.len()];
    for round in 0..rounds {
        for (index, (_, scene, _)) in variants.iter().enumerate() {
            if first[index].is_none() || !has_turn(round, counts[index], rounds) {
                continue;
            }
            if tell(round as f64 / rounds as f64) {
                return Err(Halt::Asked);
            }
            times[index].push(studio.frame(scene)?);
        }
    }
    Ok(times)
}
