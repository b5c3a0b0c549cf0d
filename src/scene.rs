//! What to draw, as plain data: everything a picture depends on besides the height map's samples.
//!
//! A [`Scene`] can be written to and read from TOML, so a picture can be made again. It knows neither GPU nor
//! window. Every field has a default; a scene file names only what differs.

pub mod air;
pub mod clouds;
mod detail;
pub mod flare;
pub mod land;
pub mod light;
mod materials;
pub mod motion;
pub mod ramp;
mod remarks;
mod saved;
pub mod sun;
pub(crate) mod water;

use std::path::PathBuf;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::camera::Camera;
use crate::heightfield::generate::Recipe;
use crate::heightfield::{ConeKind, Crater, HeightField};
use light::{Clock, Shadows, SkyModel};
use sun::SunPlace;

pub use air::AirSettings;
pub use clouds::{CloudLayer, CloudSettings, CloudSource};
pub use detail::DetailSettings;
pub use flare::FlareSettings;
pub use land::{GroundColour, Hillshade, LandSettings};
pub use ramp::Ramp;
pub use remarks::remarks;
pub use saved::SavedSettings;

pub use water::Water;

pub use materials::{ColourSource, LevelUnit, MOST_COVERAGE_MAPS, Material, MaterialSettings};

/// Everything that a frame shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// The terrain's proportion and how it enters the march.
    pub terrain: TerrainSettings,
    /// The eye. Absent: the start view of the terrain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// How rays meet the height field.
    pub march: MarchSettings,
    /// What the technique `fractal` invents.
    pub detail: DetailSettings,
    /// A second technique on the right of the picture.
    pub compare: CompareSettings,
    /// The ground's colour.
    pub diffuse: DiffuseSettings,
    /// Colours by height, contours, hillshade, placed imagery.
    pub land: LandSettings,
    /// What the ground is made of, where `diffuse.source` is `materials`.
    pub materials: MaterialSettings,
    /// The sun and the reflection model.
    pub lighting: LightingSettings,
    /// The skybox.
    pub skybox: SkyboxSettings,
    /// Aerial perspective and fog.
    pub air: AirSettings,
    /// Clouds and their shadows.
    pub clouds: CloudSettings,
    /// What the sun does in a lens.
    pub flare: FlareSettings,
    /// The cube that hides hills and is hidden by them.
    pub occluder: OccluderSettings,
    /// What to show instead of, or on top of, the shaded terrain.
    pub debug: DebugSettings,
    /// Craters, oldest first, and how they deform the ground.
    pub craters: CraterSettings,
    /// The sea.
    pub water: Water,
    /// What saved pictures get besides.
    pub saved: SavedSettings,
}

/// The height map and its proportion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TerrainSettings {
    /// The height map's file. Absent: the one given on the command line, or the Grand Canyon. A relative path in a
    /// scene file is relative to that file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Height of the box in world units (the longer horizontal side is 1), 0 (flat) to 1000. Absent: the map's own
    /// proportion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_scale: Option<f64>,
    /// What the height map is made from, where no file is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recipe: Option<Recipe>,
}

/// How a ray is tested against the height field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Technique {
    /// Uniform steps (the 2009 study, sections 3.3–3.4).
    Linear,
    /// Uniform steps, then halvings of the last one (Policarpo, Oliveira, Comba 2005).
    LinearBinary,
    /// Uniform steps, then the last one solved as a piecewise-linear curve (Tatarchuk 2006; Qu et al. 2003).
    Secant,
    /// Steps as long as a cone without ground allows, then halvings (Dummer 2006, made robust).
    Cone,
    /// Steps as long as a cone allows whose ground a ray enters only once, then halvings (Policarpo, Oliveira 2007, made
    /// robust).
    RelaxedCone,
    /// Exact: maximum mipmap traversal with bilinear leaves (Tevs, Ihrke, Seidel 2008, made exact).
    #[default]
    MaxMipmap,
    /// Another surface: the biquadratic B-spline of the samples, whose slope is continuous. The same walk, and in each cell
    /// the crossing to f32's precision. The map must have no holes.
    Smooth,
    /// Ground with invented detail: the bilinear surface, and near the eye fractal noise finer than the samples, as rough as
    /// the map. The same walk, and in each cell steps that cannot pass the ground, to a hundredth of a pixel. The map must have
    /// no holes.
    Fractal,
}

impl Technique {
    /// Everything that a scene can choose: [`Self::ALL`], `smooth` and `fractal`.
    pub const CHOICES: [Self; 8] = [
        Self::Linear,
        Self::LinearBinary,
        Self::Secant,
        Self::Cone,
        Self::RelaxedCone,
        Self::MaxMipmap,
        Self::Smooth,
        Self::Fractal,
    ];

    /// All techniques for the bilinear surface, in the order of the documentation. They are what is measured against each
    /// other.
    pub const ALL: [Self; 6] =
        [Self::Linear, Self::LinearBinary, Self::Secant, Self::Cone, Self::RelaxedCone, Self::MaxMipmap];

    /// The name used on the command line, in scene files and as the stem of the shader file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::LinearBinary => "linear-binary",
            Self::Secant => "secant",
            Self::Cone => "cone",
            Self::RelaxedCone => "relaxed-cone",
            Self::MaxMipmap => "max-mipmap",
            Self::Smooth => "smooth",
            Self::Fractal => "fractal",
        }
    }

    /// Whether the technique takes uniform samples of the heights, so that their filter matters.
    pub fn samples_uniformly(self) -> bool {
        matches!(self, Self::Linear | Self::LinearBinary | Self::Secant)
    }

    /// Whether sample counts matter: they are the uniform steps, or the most steps along cones.
    pub fn counts_samples(self) -> bool {
        !self.walks_pyramid()
    }

    /// Whether it walks a pyramid of maxima, and so finds its surface wherever it is.
    pub fn walks_pyramid(self) -> bool {
        matches!(self, Self::MaxMipmap | Self::Smooth | Self::Fractal)
    }

    /// Whether it ends with halvings, so that their number matters.
    pub fn halves(self) -> bool {
        matches!(self, Self::LinearBinary | Self::Cone | Self::RelaxedCone)
    }

    /// The cone map that the technique steps along; it is prepared for a terrain before its first frame.
    pub fn cones(self) -> Option<ConeKind> {
        match self {
            Self::Cone => Some(ConeKind::Cone),
            Self::RelaxedCone => Some(ConeKind::Relaxed),
            Self::Linear | Self::LinearBinary | Self::Secant | Self::MaxMipmap | Self::Smooth | Self::Fractal => None,
        }
    }
}

/// How a sampling technique reads a height between the samples of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum HeightFilter {
    /// The four corners, interpolated in f32: the surface itself.
    #[default]
    Exact,
    /// The sampler's bilinear filter; its weights have 8 fractional bits.
    HardwareLinear,
    /// The nearest sample: a field of boxes.
    Nearest,
}

/// How rays meet the height field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MarchSettings {
    /// The technique.
    pub technique: Technique,
    /// Fewest uniform steps, for a ray that looks straight down (`steps_by_angle`). Techniques along cones take this
    /// many steps at most.
    pub samples_min: u32,
    /// Most uniform steps, for a horizontal ray; the number for every ray without `steps_by_angle`. Techniques along
    /// cones take this many steps at most.
    pub samples_max: u32,
    /// Whether the number of steps depends on the ray's angle to the vertical (section 3.4 of the study).
    pub steps_by_angle: bool,
    /// Halvings after the first sample below the ground (`linear-binary`, `cone`, `relaxed-cone`); 0 is off.
    pub binary_steps: u32,
    /// How heights between samples are read by `linear`, `linear-binary` and `secant`.
    pub filter: HeightFilter,
    /// Start marching at the height of the highest terrain rather than at the lid of the box.
    pub lower_start: bool,
    /// Discard rays that meet nothing, which gives the terrain its silhouette; otherwise they show the ground's
    /// colour where they leave the box.
    pub discard_misses: bool,
}

impl Default for MarchSettings {
    fn default() -> Self {
        Self {
            technique: Technique::default(),
            samples_min: 128,
            samples_max: 512,
            steps_by_angle: true,
            binary_steps: 8,
            filter: HeightFilter::default(),
            lower_start: true,
            discard_misses: true,
        }
    }
}

/// A split picture: the scene's technique on the left of a vertical line, another one on the right. Samples and options
/// of the march are the same on both sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompareSettings {
    /// Whether the picture is split.
    pub enabled: bool,
    /// The technique on the right.
    pub technique: Technique,
    /// Where the line is, as a share of the width from the left.
    pub share: f64,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self { enabled: false, technique: Technique::LinearBinary, share: 0.5 }
    }
}

/// The ground's colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DiffuseSettings {
    /// Colour the ground; otherwise it is a uniform grey.
    pub enabled: bool,
    /// Where the colour comes from.
    pub source: ColourSource,
    /// An image to drape over the terrain. Absent: a texture generated from height and slope.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// How often the texture repeats along each horizontal side.
    pub repeats: f32,
}

impl Default for DiffuseSettings {
    fn default() -> Self {
        Self { enabled: true, source: ColourSource::default(), file: None, repeats: 1.0 }
    }
}

/// The sun and the reflection model (Blinn–Phong).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightingSettings {
    /// Whether the ground is lit; off, no normal is computed.
    pub enabled: bool,
    /// Compass direction of the sun in degrees, clockwise from north.
    pub sun_azimuth: f32,
    /// Height of the sun over the horizon in degrees.
    pub sun_elevation: f32,
    /// Weight of the light that comes from everywhere.
    pub ambient: f32,
    /// Weight of the Lambertian term.
    pub diffuse: f32,
    /// Weight of the highlight.
    pub specular: f32,
    /// Exponent of the highlight.
    pub shininess: f32,
    /// What hills and the occluder keep the sun from.
    pub shadows: Shadows,
    /// Shadows are drawn into a light map with a texel per cell, once for as long as nothing moves, instead of per frame.
    pub baked: bool,
    /// Light from everywhere is dimmed where hills stand around a place.
    pub occlusion: bool,
    /// Date, time and place that the sun follows in place of azimuth and elevation.
    pub clock: Clock,
}

impl Default for LightingSettings {
    fn default() -> Self {
        Self {
            enabled: true,
            sun_azimuth: 300.0,
            sun_elevation: 32.0,
            ambient: 0.28,
            diffuse: 1.0,
            specular: 0.08,
            shininess: 24.0,
            shadows: Shadows::Off,
            baked: false,
            occlusion: false,
            clock: Clock::default(),
        }
    }
}

impl LightingSettings {
    /// Where the sun stands: as set, or by the clock.
    pub fn sun_place(&self) -> SunPlace {
        if self.clock.enabled {
            return self.clock.sun();
        }
        SunPlace { azimuth: f64::from(self.sun_azimuth), elevation: f64::from(self.sun_elevation) }
    }

    /// Unit vector towards the sun, world space.
    pub fn sun_direction(&self) -> DVec3 {
        let SunPlace { azimuth, elevation } = self.sun_place();
        let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
        DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), -azimuth.cos() * elevation.cos())
    }
}

/// The skybox: the same cube, widened and flattened around the eye.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SkyboxSettings {
    /// Whether a skybox is drawn; otherwise the background is a flat colour.
    pub enabled: bool,
    /// Six images for +x, −x, +y, −y, +z, −z. Absent: a procedural sky with the sun and distant hills.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faces: Option<[PathBuf; 6]>,
    /// Width of the box over its height: above 1 it is flattened, which pulls the horizon down.
    pub flattening: f32,
    /// What the sky is made by, where it is not of images.
    pub model: SkyModel,
    /// Haze of the physical sky, 1.7 (mountain air) to 10 (haze).
    pub turbidity: f64,
}

impl Default for SkyboxSettings {
    fn default() -> Self {
        Self { enabled: true, faces: None, flattening: 2.0, model: SkyModel::Painted, turbidity: 3.0 }
    }
}

impl SkyboxSettings {
    /// Haze of the physical sky, where that is what is shown.
    pub fn physical(&self) -> Option<f64> {
        (self.enabled && self.faces.is_none() && self.model == SkyModel::Physical).then_some(self.turbidity)
    }
}

/// The occluder: the same cube, small and turned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OccluderSettings {
    /// Whether the cube is drawn.
    pub enabled: bool,
    /// Centre in world units. Absent: above the middle of the terrain, half sunk into the hills.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<DVec3>,
    /// Length of its edges in world units.
    pub size: f64,
    /// Turns around y, x and z in degrees, applied in that order (yaw, pitch, roll).
    pub rotation: DVec3,
    /// Degrees per second that `rotation.x` (the yaw) grows in the viewer; 0 stands still.
    pub spin: f64,
}

impl Default for OccluderSettings {
    fn default() -> Self {
        Self { enabled: false, position: None, size: 0.08, rotation: DVec3::new(30.0, 20.0, 0.0), spin: 0.0 }
    }
}

impl OccluderSettings {
    /// The centre, world units, over `map` in a box of the size `extent`. Where none is set: the middle of the terrain,
    /// half sunk into the ground.
    pub fn centre(&self, map: &HeightField, extent: DVec3) -> DVec3 {
        self.position.unwrap_or_else(|| {
            let ground = map.surface_height(0.5, 0.5) * extent.y;
            DVec3::new(extent.x * 0.5, ground + self.size * 0.25, extent.z * 0.5)
        })
    }
}

/// What the terrain pass shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum DebugView {
    /// The shaded terrain.
    #[default]
    None,
    /// The position on the cube's back faces as a colour; no ray is cast (the study's fixed-function shader).
    Position,
    /// Steps per ray as a heat map; the legend says what the colours mean.
    Steps,
    /// How far each ray's distance is off that of the exact technique, in cells, as a heat map with a logarithmic scale;
    /// wrong silhouettes in two colours of their own.
    Error,
    /// The Sobel normal, mapped from [−1, 1] to a colour.
    Normals,
    /// Distance from the eye, grey: near is bright.
    Distance,
}

impl DebugView {
    /// All views, in the order of the panel.
    pub const ALL: [Self; 6] = [Self::None, Self::Position, Self::Steps, Self::Error, Self::Normals, Self::Distance];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Position => "position",
            Self::Steps => "steps",
            Self::Error => "error",
            Self::Normals => "normals",
            Self::Distance => "distance",
        }
    }
}

/// What to show instead of, or on top of, the shaded terrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DebugSettings {
    /// Replaces the shaded terrain.
    pub view: DebugView,
    /// Draws the twelve edges of the terrain's box, hidden by the ground where it hides them.
    pub wireframe: bool,
    /// Steps that the brightest colour of the heat map stands for.
    pub heat_map_max: u32,
}

impl Default for DebugSettings {
    fn default() -> Self {
        Self { view: DebugView::None, wireframe: false, heat_map_max: 64 }
    }
}

/// How craters deform the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum CraterMode {
    /// Written into the heights; only the touched part of the pyramid is rebuilt. Free per frame.
    #[default]
    Baked,
    /// A second texture of its own resolution, added at every step (the study's way). The exact technique and the
    /// normals read it at the map's samples, the others between them, too.
    Layered,
}

/// Craters, oldest first, and the brush for the next one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CraterSettings {
    /// How they deform the ground.
    pub mode: CraterMode,
    /// Samples along the longer side of the second texture (`layered` only).
    pub layer_resolution: u32,
    /// Radius of the next crater in world units.
    pub radius: f64,
    /// Depth of the next crater as a share of the terrain's height.
    pub depth: f64,
    /// Height of the next crater's rim as a share of the terrain's height.
    pub rim: f64,
    /// The craters, oldest first.
    pub list: Vec<Crater>,
}

impl Default for CraterSettings {
    fn default() -> Self {
        Self { mode: CraterMode::Baked, layer_resolution: 512, radius: 0.03, depth: 0.35, rim: 0.08, list: Vec::new() }
    }
}

impl CraterSettings {
    /// The crater that the brush makes at the world position (`x`, `z`).
    pub fn brush_at(&self, x: f64, z: f64) -> Crater {
        Crater { x, z, radius: self.radius, depth: self.depth, rim: self.rim }
    }
}
