//! What the terrain pass needs to know of the light: its part of the pipeline's key, and the uniform of `light.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3};

use crate::gpu::Gpu;
use crate::scene::light::Shadows;
use crate::scene::{DebugView, LightingSettings, Scene};

use super::cube::corner;
use super::frame::{uniform_buffer, uniform_entry, without_subnormals};
use super::land::LandKey;
use super::sky_model::Daylight;

/// Binding of the uniform.
pub(super) const LIGHT: u32 = 20;

/// Columns of the sun's disc that soft shadows look for.
const COLUMNS: usize = 5;

/// Directions in which ambient occlusion looks for the horizon.
const OCCLUSION_DIRECTIONS: u32 = 12;

/// Angular radius of the sun's disc, degrees: half of the mean 0.53°.
const SUN_RADIUS: f64 = 0.2665;

/// The highest sun that soft shadows are cast by, degrees. Around the zenith the disc has no upright columns; what would still
/// cast a shadow there is steeper than 99 to 1.
const HIGHEST_SUN: f64 = 89.42;

/// Tangents beyond this are as good as upright; squares of them fit single precision.
const STEEPEST: f64 = 1e15;

/// Constants of `shadow.wgsl`, so that no number is typed in two languages.
pub(super) fn wgsl() -> String {
    // For so many cells along its steeper axis a walk carries heights from patch to patch.
    format!(
        "#define_import_path relief::sun\nconst COLUMNS: u32 = {COLUMNS}u;\nconst CARRIED_CELLS: f32 = 6.0;\n\
         const OCCLUSION_DIRECTIONS: u32 = {OCCLUSION_DIRECTIONS}u;\n"
    )
}

/// What the light adds to the terrain's pipeline. All off by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct LightKey {
    pub(super) shadows: Shadows,
    /// The occluder casts one, too.
    pub(super) occluder: bool,
    /// The light is that of a physical sky.
    pub(super) sky: bool,
    /// Shadows are read from the light map.
    pub(super) baked: bool,
    /// The light map holds ambient occlusion.
    pub(super) occlusion: bool,
}

impl LightKey {
    /// What a picture of `scene` needs.
    pub(super) fn of(scene: &Scene) -> Self {
        if !scene.lighting.enabled || scene.debug.view != DebugView::None {
            return Self::default();
        }
        let shadows = if is_up(&scene.lighting) { scene.lighting.shadows } else { Shadows::Off };
        let occluder = shadows != Shadows::Off && scene.occluder.enabled;
        let baked = shadows != Shadows::Off && scene.lighting.baked;
        Self { shadows, occluder, sky: scene.skybox.physical().is_some(), baked, occlusion: scene.lighting.occlusion }
    }

    /// The same for the whole picture: shades of relief in place of the light leave the ground's light map out. Shadows stay,
    /// for the occluder.
    pub(super) fn of_picture(scene: &Scene) -> Self {
        let key = Self::of(scene);
        let mapless = LandKey::of(&scene.land).lights_ground();
        Self { baked: key.baked && !mapless, occlusion: key.occlusion && !mapless, ..key }
    }

    /// Whether the pass walks towards the sun.
    pub(super) fn casts_shadows(self) -> bool {
        self.shadows != Shadows::Off && !self.baked
    }

    /// Whether the pass reads the light map.
    pub(super) fn needs_map(self) -> bool {
        self.baked || self.occlusion
    }

    /// Whether the pass reads the uniform of the light.
    pub(super) fn needs_uniform(self) -> bool {
        self.casts_shadows() || self.sky
    }

    pub(super) fn defs(self) -> impl Iterator<Item = &'static str> {
        [
            (self.needs_uniform(), "LIGHT"),
            (self.casts_shadows(), "SHADOWS"),
            (self.shadows != Shadows::Off, "SUNLIGHT"),
            (self.casts_shadows() && self.shadows == Shadows::Soft, "SOFT_SHADOWS"),
            (self.casts_shadows() && self.occluder, "OCCLUDER_SHADOW"),
            (self.needs_map(), "LIGHT_MAP"),
            (self.baked, "BAKED_SHADOWS"),
            (self.occlusion, "OCCLUSION"),
            (self.sky, "SKY_LIGHT"),
        ]
        .into_iter()
        .filter_map(|(on, def)| on.then_some(def))
    }

    /// One of each kind.
    #[cfg(test)]
    pub(super) fn all() -> Vec<Self> {
        let with = |shadows, occluder, sky| Self { shadows, occluder, sky, ..Self::default() };
        vec![
            with(Shadows::Hard, false, false),
            with(Shadows::Off, false, true),
            with(Shadows::Soft, false, true),
            with(Shadows::Hard, true, true),
            with(Shadows::Soft, true, false),
            Self { baked: true, occlusion: true, ..with(Shadows::Soft, true, true) },
            Self { baked: true, ..with(Shadows::Hard, false, false) },
            Self { occlusion: true, ..with(Shadows::Hard, false, false) },
        ]
    }
}

/// Elevation of the sun's highest visible point over its centre.
fn half_height(shadows: Shadows) -> f64 {
    if shadows == Shadows::Soft { SUN_RADIUS } else { 0.0 }
}

/// Whether any of the sun that casts shadows is above the horizon.
fn is_up(lighting: &LightingSettings) -> bool {
    elevation(lighting) + half_height(lighting.shadows) > 0.0
}

fn elevation(lighting: &LightingSettings) -> f64 {
    lighting.sun_direction().y.clamp(-1.0, 1.0).asin().to_degrees()
}

/// Weights of the sun's matt and glossy reflection: none where shadows are cast and the sun has set, because the horizon
/// then is one, too.
pub(super) fn direct_weights(lighting: &LightingSettings) -> [f32; 2] {
    if lighting.shadows != Shadows::Off && !is_up(lighting) { [0.0; 2] } else { [lighting.diffuse, lighting.specular] }
}

/// Mirror of `Light` in `light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct LightUniform {
    pub(super) columns: [[f32; 4]; COLUMNS],
    pub(super) shares: [[f32; 4]; COLUMNS],
    pub(super) cube: [[f32; 4]; 8],
    pub(super) sky: [[f32; 4]; 9],
    pub(super) sun: [f32; 4],
    pub(super) cells_per_texel: [f32; 4],
}

/// A column of the sun's disc.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Column {
    /// Compass direction, radians.
    azimuth: f64,
    /// Elevations of its ends, radians.
    ends: [f64; 2],
    /// Of the disc.
    share: f64,
}

/// The disc of the sun of `radius` at `azimuth` and `elevation`, all in radians, in columns. Columns stand where the
/// quadrature of Gauss and Chebyshev (second kind) has its nodes: were the seen share of a column a polynomial of its place
/// of up to the ninth degree, their sum would be exact.
///
/// Along a column at the azimuth φ from the centre, a point at the elevation ε is sin e sin ε + cos e cos ε cos φ =
/// R cos(ε − μ) from it, so that the column's ends are μ ± acos(cos ρ / R). Areas on the sphere are differences of sines.
fn columns(azimuth: f64, elevation: f64, radius: f64) -> [Column; COLUMNS] {
    let (sin, cos) = elevation.sin_cos();
    let widest = (radius.sin() / cos).min(1.0).asin();
    let mut columns = std::array::from_fn(|index| {
        let angle = std::f64::consts::PI * (index + 1) as f64 / (COLUMNS + 1) as f64;
        let off = widest * angle.cos();
        let (east, north) = (sin, cos * off.cos());
        let middle = east.atan2(north);
        let half = (radius.cos() / east.hypot(north)).min(1.0).acos();
        let ends = [middle - half, middle + half];
        Column { azimuth: azimuth + off, ends, share: (ends[1].sin() - ends[0].sin()) * angle.sin() }
    });
    let all: f64 = columns.iter().map(|column| column.share).sum();
    columns.iter_mut().for_each(|column| column.share /= all);
    columns
}

impl LightUniform {
    /// `world_from_cube` is the occluder's.
    pub(super) fn new(scene: &Scene, key: LightKey, world_from_cube: DMat4, cells_per_texel: [f64; 2]) -> Self {
        let mut uniform = Self::zeroed();
        let lighting = &scene.lighting;
        let sun = lighting.sun_direction();
        // A sun overhead has no direction along the ground; any will do.
        let azimuth = sun.x.atan2(-sun.z);
        let elevation = elevation(lighting).to_radians();
        let columns = match key.shadows {
            Shadows::Soft => columns(azimuth, elevation.min(HIGHEST_SUN.to_radians()), SUN_RADIUS.to_radians()),
            Shadows::Hard | Shadows::Off => [Column { azimuth, ends: [elevation; 2], share: 1.0 }; COLUMNS],
        };
        for (index, column) in columns.into_iter().enumerate() {
            let [low, high] = column.ends;
            let tangent = |angle: f64| angle.tan().min(STEEPEST) as f32;
            let (sin, cos) = column.azimuth.sin_cos();
            uniform.columns[index] = [sin as f32, -cos as f32, tangent(low.max(0.0)), tangent(high)];
            uniform.shares[index] = [column.share as f32, low.sin() as f32, high.sin() as f32, 0.0];
        }
        if scene.occluder.enabled {
            uniform.cube = std::array::from_fn(|index| of(world_from_cube.transform_point3(corner(index))));
        }
        if let Some(turbidity) = scene.skybox.physical().filter(|_| key.sky) {
            let light = Daylight::new(sun, turbidity).light();
            (uniform.sky, uniform.sun) = (light.harmonics.map(of), of(light.sun));
        }
        let [x, z] = cells_per_texel.map(|cells| cells as f32);
        uniform.cells_per_texel = [x, z, 0.0, 0.0];
        without_subnormals(uniform)
    }
}

fn of(DVec3 { x, y, z }: DVec3) -> [f32; 4] {
    [x as f32, y as f32, z as f32, 1.0]
}

/// The uniform's buffer.
#[derive(Debug)]
pub(super) struct LightBindings {
    buffer: wgpu::Buffer,
}

impl LightBindings {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { buffer: uniform_buffer::<LightUniform>(gpu, "light") }
    }

    /// Writes the uniform.
    pub(super) fn write(&self, gpu: &Gpu, uniform: &LightUniform) {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
    }

    pub(super) fn entry(&self) -> (u32, wgpu::BindingResource<'_>) {
        (LIGHT, self.buffer.as_entire_binding())
    }
}

/// Its entry in a layout.
pub(super) fn layout_entry() -> wgpu::BindGroupLayoutEntry {
    uniform_entry::<LightUniform>(LIGHT)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of the disc above the height `over` of its centre, in radii.
    fn segment(over: f64) -> f64 {
        0.5 - (over * (1.0 - over * over).sqrt() + over.asin()) / std::f64::consts::PI
    }

    /// What is told of soft shadows in `Shadows::Soft`.
    #[test]
    fn columns_add_up_to_the_share_of_the_disc_over_a_level_or_sloping_horizon() {
        let radius = SUN_RADIUS.to_radians();
        let mut worst = [0.0f64; 2];
        for elevation in [0.0, 1.0, 10.0, 45.0, 80.0f64] {
            let columns = columns(1.0, elevation.to_radians(), radius);
            for step in -40..=40 {
                let over = f64::from(step) / 40.0;
                // Horizons that are level or rise to one side by 45°, as seen on the sky.
                for (kind, tilt) in [0.0, 1.0f64].into_iter().enumerate() {
                    let seen: f64 = columns
                        .iter()
                        .map(|column| {
                            let across = (column.azimuth - 1.0) * elevation.to_radians().cos() / radius;
                            let horizon = elevation.to_radians() + radius * (over * tilt.hypot(1.0) + tilt * across);
                            let [low, high] = column.ends;
                            column.share * ((high - horizon) / (high - low)).clamp(0.0, 1.0)
                        })
                        .sum();
                    worst[kind] = worst[kind].max((seen - segment(over)).abs());
                }
            }
        }
        println!("level {:.4}, at 45° {:.4}", worst[0], worst[1]);
        assert!(worst[0] < 0.02 && worst[1] < 0.04, "{worst:?}");
    }
}
