//! The command line's grammar. Its help is the reference, so every option says its unit and its default.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use glam::DVec3;

use super::generate::{self, GenerateArgs};
use super::land_args::LandArgs;
use super::parse;
use crate::camera::NamedView;
use crate::heightfield::Holes;
use crate::heightfield::import::{Encoding, Endian, ImportOptions, NoData, RawType, TooLarge, VerticalUnit};
use crate::scene::light::{Shadows, SkyModel};
use crate::scene::{CraterMode, DebugView, HeightFilter, Technique};

const EXAMPLES: &str = "\
Examples:
  relief                                        fly over the Grand Canyon
  relief map.tif                                fly over any elevation file: GeoTIFF, SRTM, ASCII grid, PNG ...
  relief render -o canyon.png --view valley     one picture, no window
  relief render map.png -o view.png --eye 0.5,0.6,1.4 --target 0.5,0,0.5 --size 1920x1080
  relief generate ridged --size 1024 --seed 7 -o ridged.png

Exit codes:
  0 done   1 failed   2 usage   3 bad input   4 no usable GPU adapter";

const CONVERT_EXAMPLES: &str = "\
Examples:
  relief convert etopo.cdf -o etopo.tif                     a GeoTIFF, with the samples and the place as they are
  relief convert dem.tif -o dem.png                         a 16-bit PNG, and what it cannot say in dem.toml
  relief convert big.tif -o part.asc --window 2000,1500,512,512
  relief convert 12/2148/1605.png -o tile.tif --encoding terrarium
  relief convert --scene relief-0001.toml -o edited.tif     the scene's map with its craters

OUT's ending says the format: .png, .tif, .asc, .flt, .r16, .r32. What the format itself cannot say stands in a sidecar, OUT.toml.";

const RENDER_EXAMPLES: &str = "\
Examples:
  relief render -o start.png                               the Grand Canyon's start view
  relief render -o far.png --view horizon --technique linear-binary --samples 128..512
  relief render -o out.png --depth out.exr --stats out.json --frames 20
  relief render map.png -o out.png --scene screenshot.toml --debug steps
  relief render -o split.png --technique max-mipmap --compare linear-binary@0.4 --samples 32
  relief render -o wrong.png --technique linear-binary --samples 64..256 --debug error
  relief render -o holes.png --crater 0.4,0.5 --crater 0.6,0.5,0.05,0.4,0.1
  relief render --path flight.toml --frames-per-second 30 -o flight.png      an animated PNG; -o flight a folder of PNGs

Defaults come first, then the scene file, then the options given here.";

const REPORT_EXAMPLES: &str = "\
Examples:
  relief report -o canyon                      the Grand Canyon, all settings, five views: five to ten minutes in software
  relief report map.png -o quick --quick       under a minute
  relief report -o mine --scene screenshot.toml --size 640x400

Ctrl-C, or SIGTERM, ends it and writes what was measured until then.";

const STRESS_EXAMPLES: &str = "\
Examples:
  relief stress -o stress                      all cases, and the bound over map sizes up to the adapter's limit: minutes
  relief stress -o quick --quick               seconds
  relief stress --list                         the names of the cases
  relief stress -o some --case needles --case fov-0.001

Exit code 1 means that max-mipmap broke its promise, and stress.md says where: ground missed or invented
outside the tangency band, an error above the bound, a distance that is no number, a walk that was cut
off, an error of the driver.

Ctrl-C ends it and writes what was measured until then.";

/// Flies over height maps without a mesh: a fragment shader casts one ray per pixel through a unit cube.
#[derive(Debug, Parser)]
#[command(name = "relief", version, after_help = EXAMPLES, args_conflicts_with_subcommands = true, max_term_width = 110)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    /// Say more on stderr: what is opened and how, adapters, shaders. RUST_LOG chooses in detail
    // Without a heading of its own it would stand below the last one of each command.
    #[arg(short, long, global = true, help_heading = clap::builder::Resettable::Reset)]
    pub(crate) verbose: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Open the viewer (the same as no command)
    View(Box<ViewArgs>),
    /// Draw one picture without a window
    #[command(after_help = RENDER_EXAMPLES)]
    Render(Box<RenderArgs>),
    /// Measure every technique: how wrong it is and what it costs
    #[command(after_help = REPORT_EXAMPLES)]
    Report(ReportArgs),
    /// Show for every technique where it breaks, and that the exact one does not: stiff terrain, extreme views and edits
    #[command(after_help = STRESS_EXAMPLES)]
    Stress(StressArgs),
    /// Say what an elevation file holds
    Info(InfoArgs),
    /// Write an elevation file in another format
    #[command(after_help = CONVERT_EXAMPLES)]
    Convert(ConvertArgs),
    /// Make a height map
    #[command(after_help = generate::EXAMPLES)]
    Generate(Box<GenerateArgs>),
    /// Print a shell's completion script
    #[command(after_help = "Example:\n  relief completions bash > ~/.local/share/bash-completion/completions/relief")]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    #[command(hide = true)]
    Man {
        /// Write it and one for each command into this folder instead
        #[arg(long = "into", value_name = "DIR")]
        folder: Option<PathBuf>,
    },
}

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// More elevation files; Ctrl+Tab goes to the next
    #[arg(value_name = "MORE", value_parser = parse::input_file())]
    pub(crate) more: Vec<PathBuf>,
    /// Size of the window in pixels [default: 1280x800 points]
    #[arg(long, value_name = "WxH", value_parser = parse::size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Folder for screenshots (F12)
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub(crate) screenshots: PathBuf,
    /// Where the start view goes when there is no display
    #[arg(short, long, value_name = "FILE", default_value = "relief-view.png")]
    pub(crate) output: PathBuf,
    /// Start with the settings, keys, bookmarks and window of a first start; those of earlier runs are put aside
    #[arg(long)]
    pub(crate) reset_settings: bool,
    /// Writes the viewer's state as JSON after every frame, for automated tests
    #[arg(long, value_name = "FILE")]
    pub(crate) status: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The picture, a PNG. With --path an animated PNG (.png, .apng), or a folder for one PNG each
    #[arg(short, long, value_name = "OUT.png", help_heading = "Output")]
    pub(crate) output: PathBuf,
    /// Draw the pictures of a camera path (TOML), as the viewer records and saves it
    #[arg(long, value_name = "PATH.toml", value_parser = parse::input_file(), help_heading = "Output",
        conflicts_with_all = ["depth", "stats", "view", "eye", "target", "fov"])]
    pub(crate) path: Option<PathBuf>,
    /// Pictures of the path per second, 1 to 240
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=240), default_value_t = 30,
        requires = "path", help_heading = "Output")]
    pub(crate) frames_per_second: u32,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse::size, default_value = "1280x800", help_heading = "Output")]
    pub(crate) size: [u32; 2],
    /// Also write the distance from the eye, in world units, +inf for sky: an EXR with one 32-bit float channel, Y
    #[arg(long, value_name = "OUT.exr", help_heading = "Output")]
    pub(crate) depth: Option<PathBuf>,
    /// Also write adapter, frame times, steps per ray and the ledger of passes, pipelines and textures
    #[arg(long, value_name = "OUT.json", help_heading = "Output")]
    pub(crate) stats: Option<PathBuf>,
    /// Frames to time for --stats, after two to warm up
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), default_value_t = 1,
        requires = "stats", help_heading = "Output")]
    pub(crate) frames: u32,
}

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// The elevation file, of any format in README.md [default: the scene's, else the Grand Canyon, which is built in]
    #[arg(value_parser = parse::input_file())]
    pub(crate) file: Option<PathBuf>,
    /// The folder for report.md, report.csv, report.json, error-vs-time.svg and error-vs-time.png; made where it is missing
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Size of the measured pictures in pixels
    #[arg(long, value_name = "WxH", value_parser = parse::size, default_value = "320x200")]
    pub(crate) size: [u32; 2],
    /// A scene file (TOML) whose camera is a view to measure; repeatable. Light, colours and craters are those of the
    /// first [default: the views over, graze, valley, down and horizon]
    #[arg(long = "scene", value_name = "SCENE.toml", value_parser = parse::input_file())]
    pub(crate) scenes: Vec<PathBuf>,
    /// Height of the terrain in world units, 0 (flat) to 1000 [default: the scene's, else the map's own proportion]
    #[arg(long, value_name = "S", value_parser = parse::height_scale, allow_negative_numbers = true)]
    pub(crate) height_scale: Option<f64>,
    /// Few settings and rounds: under a minute instead of five to ten
    #[arg(long)]
    pub(crate) quick: bool,
    #[command(flatten)]
    pub(crate) open: OpenArgs,
}

#[derive(Debug, Args)]
pub(crate) struct StressArgs {
    /// The folder for stress.md, stress.csv, stress.json, contact-sheet.png, and stress-bound.svg and .png where the bound
    /// was measured; made where it is missing
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    pub(crate) output: Option<PathBuf>,
    /// Only the cases whose names contain this; repeatable [default: all, and the bound over map sizes]
    #[arg(long = "case", value_name = "NAME")]
    pub(crate) cases: Vec<String>,
    /// Print the names of the cases, and measure nothing
    #[arg(long)]
    pub(crate) list: bool,
    /// Size of the measured pictures in pixels; some cases have their own [default: 320x200, with --quick 64x40]
    #[arg(long, value_name = "WxH", value_parser = parse::size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Smaller maps and fewer views: seconds instead of minutes
    #[arg(long)]
    pub(crate) quick: bool,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The elevation file
    #[arg(value_parser = parse::input_file())]
    pub(crate) file: PathBuf,
    /// Print JSON: width, height, sample_type, min, max, nodata_fraction, crs, metres_per_sample, extent_metres, format,
    /// compression, file_size, vertical_unit, bounds, geographic_bounds, pixel_is, warnings
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) open: OpenArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// The elevation file [default with --scene: the scene's, else the Grand Canyon]
    #[arg(value_parser = parse::input_file(), required_unless_present = "scene")]
    pub(crate) file: Option<PathBuf>,
    /// A scene file (TOML) whose craters are dug into the map first
    #[arg(long, value_name = "SCENE.toml", value_parser = parse::input_file())]
    pub(crate) scene: Option<PathBuf>,
    /// Replace OUT where it exists
    #[arg(long)]
    pub(crate) force: bool,
    /// What to write; the ending says the format: .png, .tif, .asc, .flt, .r16, .r32
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) open: OpenArgs,
}

/// What an elevation file does not say itself, or says wrongly. Each can also stand in its sidecar.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Opening files")]
pub(crate) struct OpenArgs {
    /// Columns and rows of a file without a header (.raw, .r16, .r32) [default: the square root of its samples]
    #[arg(long, value_name = "WxH", value_parser = parse::size)]
    raw_size: Option<[u32; 2]>,
    /// Its samples [default: u16, of .r32 f32, of .r8 u8]
    #[arg(long, value_name = "TYPE", value_enum)]
    raw_type: Option<RawType>,
    /// Order of their bytes [default: little]
    #[arg(long, value_name = "ORDER", value_enum)]
    raw_endian: Option<Endian>,
    /// The first row is the southernmost, or where the format says so itself, the northernmost
    #[arg(long)]
    flip: bool,
    /// The colours of a PNG or WebP are heights
    #[arg(long, value_name = "ENCODING", value_enum)]
    encoding: Option<Encoding>,
    /// The number that means no height, or none [default: what the file says]
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    nodata: Option<NoData>,
    /// What heights are measured in [default: what the file says, else metres]
    #[arg(long, value_name = "UNIT", value_enum)]
    vertical_unit: Option<VerticalUnit>,
    /// The band to take of several, from 1 [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    band: Option<u32>,
    /// The variable of a netCDF or channel of an OpenEXR to take [default: the likeliest]
    #[arg(long, value_name = "NAME")]
    variable: Option<String>,
    /// What becomes of samples without a height [default: cut-out]
    #[arg(long, value_name = "HOW", value_enum)]
    holes: Option<Holes>,
    /// Make one sample of the mean of N by N [default: 1, or as many as the adapter needs]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    reduce: Option<u32>,
    /// Only a part: its first column and row from the north-west, its columns and rows
    #[arg(long, value_name = "X,Z,W,H", value_parser = parse::window)]
    window: Option<[u32; 4]>,
    /// What becomes of a map with more samples a side than the adapter's textures [default: reduce]
    #[arg(long, value_name = "HOW", value_enum)]
    too_large: Option<TooLarge>,
}

impl OpenArgs {
    /// The same for the library.
    pub(crate) fn options(&self) -> ImportOptions {
        ImportOptions {
            raw_size: self.raw_size,
            raw_type: self.raw_type,
            raw_endian: self.raw_endian,
            flip: self.flip.then_some(true),
            encoding: self.encoding,
            nodata: self.nodata,
            vertical_unit: self.vertical_unit,
            band: self.band,
            variable: self.variable.clone(),
            holes: self.holes,
            reduce: self.reduce,
            window: self.window,
            too_large: self.too_large,
            ..ImportOptions::default()
        }
    }
}

/// What to show. Everything left out comes from the scene file, and then from the defaults.
#[derive(Debug, Default, Args)]
pub(crate) struct SceneArgs {
    /// The elevation file, of any format in README.md [default: the scene's, else the Grand Canyon, which is built in]
    #[arg(value_parser = parse::input_file())]
    pub(crate) file: Option<PathBuf>,
    /// A scene file (TOML); relative paths in it are relative to its folder
    #[arg(long, value_name = "SCENE.toml", value_parser = parse::input_file(), help_heading = "Scene")]
    pub(crate) scene: Option<PathBuf>,
    /// Height of the terrain in world units, 0 (flat) to 1000; its longer side is 1 [default: the map's own proportion, else 0.25]
    #[arg(long, value_name = "S", value_parser = parse::height_scale, allow_negative_numbers = true, help_heading = "Scene")]
    pub(crate) height_scale: Option<f64>,

    /// A view to start from [default: start]
    #[arg(long, value_name = "VIEW", value_enum, conflicts_with_all = ["eye", "target"], help_heading = "Camera")]
    pub(crate) view: Option<NamedView>,
    /// Where the eye is, world units: x east, y up, z south; the terrain's corner is at 0,0,0
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, help_heading = "Camera")]
    pub(crate) eye: Option<DVec3>,
    /// The point the eye looks at, world units [default with --eye: the middle of the terrain]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, help_heading = "Camera")]
    pub(crate) target: Option<DVec3>,
    /// Vertical field of view in degrees [default: 60]
    #[arg(long, value_name = "DEGREES", value_parser = parse::fov, allow_negative_numbers = true, help_heading = "Camera")]
    pub(crate) fov: Option<f64>,

    /// How rays meet the ground [default: max-mipmap]
    #[arg(long, value_name = "NAME", value_enum, help_heading = "Ray marching")]
    pub(crate) technique: Option<Technique>,
    /// Steps of every technique but max-mipmap, looking down..along the ground; one number: the same for all [default: 128..512]
    #[arg(long, value_name = "MIN..MAX", value_parser = parse::samples, allow_hyphen_values = true,
        help_heading = "Ray marching")]
    pub(crate) samples: Option<[u32; 2]>,
    /// Give every ray the most steps, whatever its angle
    #[arg(long, help_heading = "Ray marching")]
    pub(crate) fixed_steps: bool,
    /// Halvings of the last step of linear-binary, cone, relaxed-cone; 0 is off [default: 8]
    #[arg(long, value_name = "N", value_parser = parse::halvings(), help_heading = "Ray marching")]
    pub(crate) binary_steps: Option<u32>,
    /// How linear, linear-binary and secant read heights between samples [default: exact]
    #[arg(long, value_name = "FILTER", value_enum, help_heading = "Ray marching")]
    pub(crate) filter: Option<HeightFilter>,
    /// Start rays at the lid of the box, not at the height of the highest terrain
    #[arg(long, help_heading = "Ray marching")]
    pub(crate) no_lower_start: bool,
    /// Split the picture: TECHNIQUE draws what is right of a line at SHARE of the width, 0 to 1 [default: no split; share 0.5]
    #[arg(long, value_name = "TECHNIQUE[@SHARE]", value_parser = parse::compare, help_heading = "Ray marching")]
    pub(crate) compare: Option<parse::CompareSpec>,
    /// Show the ground's colour where rays miss: no silhouette
    #[arg(long, help_heading = "Ray marching")]
    pub(crate) no_discard: bool,

    /// Plain grey ground
    #[arg(long, conflicts_with_all = ["texture", "repeats", "coverage"], help_heading = "Looks")]
    pub(crate) no_texture: bool,
    /// An image whose red, green, blue and alpha say where grass, rock, scree and snow are, a second one sand and sea bed;
    /// repeatable; implies --colour materials
    #[arg(long = "coverage", value_name = "IMAGE", value_parser = parse::input_file(), help_heading = "Looks")]
    pub(crate) coverage: Vec<PathBuf>,
    /// An image to drape over the ground [default: colours made from height and slope]
    #[arg(long, value_name = "IMAGE", value_parser = parse::input_file(), help_heading = "Looks")]
    pub(crate) texture: Option<PathBuf>,
    /// How often the texture repeats along each side [default: 1]
    #[arg(long, value_name = "N", value_parser = parse::repeats, allow_negative_numbers = true, help_heading = "Looks")]
    pub(crate) repeats: Option<f32>,
    /// No lighting, and no normals computed for it
    #[arg(long, help_heading = "Looks")]
    pub(crate) no_lighting: bool,
    /// The sun's compass direction and height, degrees [default: 300,32]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = parse::sun, allow_hyphen_values = true,
        help_heading = "Looks")]
    pub(crate) sun: Option<[f32; 2]>,
    /// What hills and the occluder keep the sun from: hard, or with the sun's true half degree [default: off]
    #[arg(long, value_name = "KIND", value_enum, help_heading = "Looks")]
    pub(crate) shadows: Option<Shadows>,
    /// Shadows from a light map with a texel per cell of the height map
    #[arg(long, help_heading = "Looks")]
    pub(crate) bake_shadows: bool,
    /// Dim the light from everywhere where hills stand around
    #[arg(long, help_heading = "Looks")]
    pub(crate) occlusion: bool,
    /// The sun of a date and hour, UTC, over the map (over the Grand Canyon where its place is not known)
    #[arg(long, value_name = "YYYY-MM-DDTHH:MM", value_parser = parse::time, conflicts_with = "sun", help_heading = "Looks")]
    pub(crate) time: Option<parse::Time>,
    /// What the sky is made by, and with `physical` the light on the ground, too [default: painted]
    #[arg(long, value_name = "MODEL", value_enum, help_heading = "Looks")]
    pub(crate) sky: Option<SkyModel>,
    /// A flat background instead of the sky
    #[arg(long, help_heading = "Looks")]
    pub(crate) no_skybox: bool,
    /// A bright cube that hides hills and is hidden by them
    #[arg(long, help_heading = "Looks")]
    pub(crate) occluder: bool,
    /// The same cube with its centre here, world units
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, help_heading = "Looks")]
    pub(crate) occluder_at: Option<DVec3>,

    /// A sea up to LEVEL: a share of the map's height (0.3), metres (120m), or `auto`: 0 m where the map has it, else a third
    #[arg(long, value_name = "LEVEL", value_parser = parse::water, allow_hyphen_values = true, help_heading = "Looks")]
    pub(crate) water: Option<parse::WaterLevel>,

    /// A crater at x,z (world units) with radius (world units), depth and rim (shares of the terrain's height); repeatable
    #[arg(long = "crater", value_name = "X,Z[,RADIUS[,DEPTH[,RIM]]]", value_parser = parse::crater,
        allow_hyphen_values = true, help_heading = "Craters")]
    pub(crate) craters: Vec<parse::CraterSpec>,
    /// How craters deform the ground [default: baked]
    #[arg(long, value_name = "MODE", value_enum, help_heading = "Craters")]
    pub(crate) crater_mode: Option<CraterMode>,

    /// Show this instead of the shaded ground [default: none]
    #[arg(long, value_name = "VIEW", value_enum, help_heading = "Debugging")]
    pub(crate) debug: Option<DebugView>,
    /// Draw the edges of the terrain's box
    #[arg(long, help_heading = "Debugging")]
    pub(crate) wireframe: bool,
    #[command(flatten)]
    pub(crate) land: LandArgs,
    #[command(flatten)]
    pub(crate) open: OpenArgs,
}
