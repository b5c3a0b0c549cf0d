//! `relief render`: one picture without a window, and what it cost.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use serde::Serialize;

use super::args::RenderArgs;
use super::failure::{Exit, Failure};
use super::land_args;
use super::output::Output;
use super::progress::Progress;
use super::terrain::{self, Source};
use crate::app::legend::{self, Against};
use crate::app::stamp::{Legend, Stamp};
use crate::gpu::{Gpu, Target};
use crate::heightfield::HeightField;
use crate::render::{ERROR_DECADES, Ledger, Probe, RenderError, Renderer};
use crate::scene::{DebugView, Scene};

/// Frames drawn before any is timed: a driver compiles shaders in the first.
const WARM_UP: u32 = 2;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    if let Some(path) = &args.path {
        return super::film::run(args, path);
    }
    let outputs = Outputs::prepare(args)?;
    let mut scene = terrain::compose(&args.scene)?;
    outputs.spare_the_inputs(&scene, args.scene.scene.as_deref())?;
    let (gpu, map) = Source::chosen(&args.scene, &scene).load_for_gpu(&args.scene.open.options())?;
    terrain::check_size(args.size, gpu.capabilities.max_texture)?;
    scene.lighting.clock.stand_on(map.geographic_bounds());
    let map = map.field;
    terrain::place_camera(&args.scene, &mut scene, &map)?;
    terrain::warn_of(&scene, &map);

    let words = land_args::legend(&scene, &map);
    let (scene_view, heat_map_max) = (scene.debug.view, scene.debug.heat_map_max);
    let compare = &scene.compare;
    let sides = compare.enabled.then(|| (scene.march.technique.name(), compare.technique.name(), compare.share));
    let mut easel = Easel::new(gpu, scene, map, args.size)?;
    let progress = Progress::start("drawing");
    let times = if args.stats.is_some() { easel.timed_frames(args.frames)? } else { easel.frame()? };
    let picture = easel.png()?;
    let ledger = easel.renderer.ledger().clone();
    // The position view casts no rays, so it takes no steps; its distances are still those of the scene.
    let casts_rays = scene_view != DebugView::Position;
    let probe = if outputs.depth.is_some() || (outputs.stats.is_some() && casts_rays) {
        Some(easel.renderer.probe(&easel.scene, args.size)?)
    } else {
        None
    };
    drop(progress);

    outputs.picture.write(&picture)?;
    if let Some((left, right, share)) = sides {
        eprintln!("relief: {left} left of {:.0} % of the width, {right} right of it", share * 100.0);
    }
    if let Some(words) = words.filter(|_| scene_view == DebugView::None) {
        eprintln!("relief: {words}");
    }
    if scene_view == DebugView::Steps {
        eprintln!("relief: steps per ray: black is 0, pale yellow {heat_map_max} or more");
    }
    if scene_view == DebugView::Error {
        let [low, high] = ERROR_DECADES.map(|decade| 10f64.powi(decade));
        eprintln!(
            "relief: distance error against max-mipmap: black is {low} cells or less, pale yellow {high} or more; \
             light blue sees through the ground, green covers the sky, dark grey is sky"
        );
    }
    if let (Some(output), Some(probe)) = (&outputs.depth, &probe) {
        output.write(&exr_of(probe)?)?;
    }
    if let Some(output) = &outputs.stats {
        let cast = probe.as_ref().filter(|_| casts_rays);
        output.write(&Stats::new(&easel.gpu, times, cast, &ledger).to_json()?)?;
    }
    Ok(())
}

/// Draws the view that `scene` opens with and writes it: what the viewer does without a display.
pub(crate) fn picture(
    gpu: Arc<Gpu>,
    scene: Scene,
    map: HeightField,
    size: [u32; 2],
    to: &Output,
) -> Result<(), Failure> {
    let mut easel = Easel::new(gpu, scene, map, size)?;
    let progress = Progress::start("drawing");
    easel.frame()?;
    let picture = easel.png()?;
    drop(progress);
    to.write(&picture)
}

/// The files of one call.
struct Outputs {
    picture: Output,
    depth: Option<Output>,
    stats: Option<Output>,
}

impl Outputs {
    /// Checks that each can be written and that they are different files.
    fn prepare(args: &RenderArgs) -> Result<Self, Failure> {
        let extension = args.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if image::ImageFormat::from_extension(extension).is_some_and(|format| format != image::ImageFormat::Png) {
            return Err(Failure::usage(format!("{} would be a PNG file", args.output.display()))
                .line(format!("Pictures are written as PNG, which nobody expects in a .{extension}."))
                .line(format!("Name it {}.", args.output.with_extension("png").display())));
        }
        let optional = |path: &Option<_>| path.as_deref().map(Output::prepare).transpose();
        let outputs = Self {
            picture: Output::prepare(&args.output)?,
            depth: optional(&args.depth)?,
            stats: optional(&args.stats)?,
        };
        let all: Vec<&Output> = outputs.all().collect();
        for (index, output) in all.iter().enumerate() {
            if let Some(twin) = all.iter().skip(index + 1).find(|other| output.same_file(other.path())) {
                return Err(Failure::usage(format!("two outputs have the name {}", twin.path().display()))
                    .line("The second would replace the first.")
                    .line("Give -o, --depth and --stats different names."));
            }
        }
        Ok(outputs)
    }

    fn all(&self) -> impl Iterator<Item = &Output> {
        [Some(&self.picture), self.depth.as_ref(), self.stats.as_ref()].into_iter().flatten()
    }

    /// Refuses to replace a file that the picture is made from.
    fn spare_the_inputs(&self, scene: &Scene, scene_file: Option<&Path>) -> Result<(), Failure> {
        let files = crate::scene_file::files(scene).map(PathBuf::as_path);
        for input in files.chain(scene_file) {
            if self.all().any(|output| output.same_file(input)) {
                return Err(Failure::usage(format!("{} is an input and an output", input.display()))
                    .line("It would be lost.")
                    .line("Give the output another name."));
            }
        }
        Ok(())
    }
}

/// A renderer with its scene and its canvas.
pub(super) struct Easel {
    gpu: Arc<Gpu>,
    renderer: Renderer,
    target: Target,
    map: Arc<HeightField>,
    /// Draws the legend, where the scene asks for one.
    stamp: Option<Stamp>,
    pub(super) scene: Scene,
}

impl Easel {
    pub(super) fn new(gpu: Arc<Gpu>, scene: Scene, map: HeightField, size: [u32; 2]) -> Result<Self, Failure> {
        let mut renderer = Renderer::new(Arc::clone(&gpu))?;
        let progress = Progress::start("preparing the terrain");
        let map = Arc::new(map);
        renderer.set_terrain(Arc::clone(&map))?;
        renderer.prepare_cones(&scene, &|share| progress.set(share));
        drop(progress);
        let target = Target::new(&gpu, size);
        let stamp = (scene.saved.legend && legend::exists(&scene)).then(|| Stamp::new(&gpu));
        if scene.saved.legend && stamp.is_none() {
            super::warn(
                "the picture gets no legend: nothing in it has one. Colour the ground by ramp, slope or aspect, draw \
                 contours, or show steps or errors.",
            );
        }
        Ok(Self { gpu, renderer, target, map, stamp, scene })
    }

    /// Draws one frame, untimed.
    pub(super) fn frame(&mut self) -> Result<Vec<f64>, Failure> {
        self.renderer.draw(&self.scene, &self.target)?;
        Ok(Vec::new())
    }

    /// Warms up, draws `count` frames and returns their times in milliseconds.
    fn timed_frames(&mut self, count: u32) -> Result<Vec<f64>, Failure> {
        for _ in 0..WARM_UP {
            self.frame()?;
            self.renderer.wait_frame_time()?;
        }
        let mut times = Vec::new();
        for _ in 0..count {
            self.frame()?;
            times.push(self.renderer.wait_frame_time()?);
        }
        Ok(times)
    }

    /// The picture, with its legend where the scene asks for one.
    pub(super) fn picture(&mut self) -> Result<image::RgbaImage, Failure> {
        let read = match &mut self.stamp {
            Some(stamp) => {
                let (scene, map) = (&self.scene, &self.map);
                let legend = Legend { scene, map, errors: Against::default(), pixels_per_point: None };
                stamp.picture(&self.gpu, &self.target, &legend)
            }
            None => self.target.read_color(&self.gpu),
        };
        Ok(read.map_err(RenderError::from)?)
    }

    /// The picture as a PNG without time stamps: the same picture gives the same bytes.
    fn png(&mut self) -> Result<Vec<u8>, Failure> {
        let picture = image::DynamicImage::ImageRgba8(self.picture()?).into_rgb8();
        let mut bytes = Vec::new();
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(&picture, picture.width(), picture.height(), image::ExtendedColorType::Rgb8)
            .map_err(|error| encoding_failed("the picture", &error))?;
        Ok(bytes)
    }
}

/// The distances as an EXR with the one channel `Y`, 32-bit float. Scan lines in increasing order: tiles would be
/// stored in the order in which threads finish them.
fn exr_of(probe: &Probe) -> Result<Vec<u8>, Failure> {
    use exr::prelude::{Encoding, Image, LayerAttributes, SpecificChannels, WritableImage};
    let [width, height] = probe.size.map(|side| side as usize);
    let distance =
        |at: exr::math::Vec2<usize>| (probe.distance.get(at.y() * width + at.x()).copied().unwrap_or(f32::INFINITY),);
    let channels = SpecificChannels::build().with_channel::<f32>("Y").with_pixel_fn(distance);
    let layer = exr::image::Layer::new((width, height), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| encoding_failed("the distances", &error))?;
    Ok(bytes.into_inner())
}

fn encoding_failed(what: &str, error: &dyn std::error::Error) -> Failure {
    Failure::new(Exit::Failed, format!("cannot encode {what}")).line(format!("The encoder says: {error}."))
}

/// What `--stats` writes; the names are a contract.
#[derive(Debug, Serialize)]
struct Stats<'a> {
    adapter: String,
    driver: String,
    frame_ms: FrameTimes,
    steps: Steps,
    cap_hits: u32,
    ledger: &'a Ledger,
}

/// Milliseconds per frame.
#[derive(Debug, PartialEq, Serialize)]
struct FrameTimes {
    median: f64,
    p95: f64,
}

/// Steps per ray that was cast.
#[derive(Debug, Serialize)]
struct Steps {
    mean: f64,
    max: u32,
}

impl<'a> Stats<'a> {
    /// `probe` is absent where no ray was cast.
    fn new(gpu: &Gpu, times: Vec<f64>, probe: Option<&Probe>, ledger: &'a Ledger) -> Self {
        let (adapter, driver) = gpu.adapter_name();
        let (mean, max) = probe.map_or((0.0, 0), Probe::step_stats);
        Self {
            adapter,
            driver,
            frame_ms: FrameTimes::of(times),
            steps: Steps { mean, max },
            cap_hits: probe.map_or(0, |probe| probe.cap_hits),
            ledger,
        }
    }

    fn to_json(&self) -> Result<Vec<u8>, Failure> {
        let mut json = serde_json::to_vec_pretty(self).map_err(|error| encoding_failed("the statistics", &error))?;
        json.push(b'\n');
        Ok(json)
    }
}

impl FrameTimes {
    /// The median and the 95th percentile (nearest rank) of at least one time.
    fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        // The smallest time that at least this percentage of the times does not exceed.
        let rank = |percent: usize| times.get((times.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Self { median: rank(50).unwrap_or_default(), p95: rank(95).unwrap_or_default() }
    }
}

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers};

    use super::*;

    #[test]
    fn percentiles_are_times_that_occurred() {
        assert_eq!(FrameTimes::of(vec![5.0]), FrameTimes { median: 5.0, p95: 5.0 });
        let times = (1..=100).rev().map(f64::from).collect();
        assert_eq!(FrameTimes::of(times), FrameTimes { median: 50.0, p95: 95.0 });
    }

    #[test]
    fn distances_survive_the_exr_with_sky_as_infinity() {
        let distance: Vec<f32> =
            (0..70 * 50u16).map(|i| if i % 3 == 0 { f32::INFINITY } else { f32::from(i) * 0.1 }).collect();
        let zeros = vec![0.0; distance.len()];
        let steps = vec![0; distance.len()];
        let probe = Probe {
            size: [70, 50],
            steps,
            distance,
            beyond_start: zeros,
            cap_hits: 0,
            starts: vec![0.0],
            counted_from: vec![],
            anchors: vec![],
        };
        let bytes = exr_of(&probe).unwrap();
        assert_eq!(bytes, exr_of(&probe).unwrap(), "the same bytes again");
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        let [channel] = image.layer_data.channel_data.list.as_slice() else { panic!("not one channel") };
        assert_eq!(channel.name.to_string(), "Y");
        assert_eq!(channel.sample_data, exr::prelude::FlatSamples::F32(probe.distance));
    }
}
