//! What passes need to know of the air: their part of a pipeline's key, and the constants of `air.wgsl`.
//!
//! Extinction is that of molecules and of haze, each exponential in height with the scale height of Preetham, Shirley and Smits
//! 1999 (section 4.1), together as much at the lowest ground as the visibility says (Koschmieder 1924: 3.912 / V at 550 nm).
//! The haze depends on the wavelength by Kruse's exponent in the form of Kim, McArthur and Korevaar 2001, the molecules as in
//! Preetham's sunlight. What a way takes out of the light comes back in the colour that the sky has at the horizon in
//! that direction: there the way is so long that nothing else is left.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use crate::gpu::Gpu;
use crate::scene::air::Kilometres;
use crate::scene::{AirSettings, DebugView, GroundColour, Scene};

use super::frame::{storage_buffer, storage_entry, without_subnormals};
use super::land::LandKey;
use super::sky_map::{AirLight, HORIZON};

/// Binding of the constants.
pub(super) const AIR: u32 = 44;

/// Scale heights in kilometres: of the molecules, of the haze (Preetham, table 3: exponents 0.1136 and 0.8333 per kilometre).
const MOLECULES_SCALE: f64 = 8.8;
const HAZE_SCALE: f64 = 1.2;

/// Wavelengths that stand for red, green and blue, µm, as in `sky_model.rs`.
const WAVELENGTHS: [f64; 3] = [0.615, 0.545, 0.465];

/// The wavelength that visibility is meant for, µm.
const VISIBLE: f64 = 0.55;

/// How much denser fog scatters forward (Henyey, Greenstein 1941).
const FORWARD: f64 = 0.65;

/// Constants of `air.wgsl`, so that no number is typed in two languages.
pub(super) fn wgsl() -> String {
    format!(
        "#define_import_path relief::air_constants\nconst HORIZON: u32 = {HORIZON}u;\nconst FORWARD: f32 = {FORWARD:?};\n"
    )
}

/// What the air adds to a pipeline. All off by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct AirKey {
    pub(super) perspective: bool,
    pub(super) fog: bool,
    /// Clouds keep the sun from what is lit.
    pub(super) shadows: bool,
}

impl AirKey {
    /// What a picture of `scene` needs. Colours that are to be read off, and pictures of something else than the ground, are
    /// shown without air.
    pub(super) fn of(scene: &Scene) -> Self {
        if !shows_air(scene) {
            return Self::default();
        }
        let casts = scene.clouds.shadows && scene.lighting.enabled && scene.clouds.shadow_strength > 0.0;
        Self {
            perspective: scene.air.perspective,
            fog: scene.air.fog && scene.air.fog_density > 0.0,
            shadows: casts && super::clouds::sun_reaches(scene) && scene.clouds.shown().next().is_some(),
        }
    }

    /// Whether light on its way to the eye is changed.
    pub(super) fn veils(self) -> bool {
        self.perspective || self.fog
    }

    /// Whether the constants are read.
    pub(super) fn is_on(self) -> bool {
        self != Self::default()
    }

    /// The same for what is not lit.
    pub(super) fn unlit(self) -> Self {
        Self { shadows: false, ..self }
    }

    /// The same for the sky, which has its own haze.
    pub(super) fn of_sky(self) -> Self {
        Self { perspective: false, shadows: false, ..self }
    }

    pub(super) fn defs(self) -> impl Iterator<Item = &'static str> {
        let defs = [
            (self.is_on(), "ATMOSPHERE"),
            (self.veils(), "AIR"),
            (self.perspective, "AERIAL"),
            (self.fog, "FOG"),
            (self.shadows, "CLOUD_SHADOWS"),
        ];
        defs.into_iter().filter_map(|(on, def)| on.then_some(def))
    }

    /// Shader modules that its parts may import.
    pub(super) fn modules(self) -> Vec<&'static str> {
        if self.is_on() { vec!["air.wgsl"] } else { Vec::new() }
    }

    /// What its parts bind.
    pub(super) fn bindings(self) -> Vec<wgpu::BindGroupLayoutEntry> {
        let mut entries = Vec::new();
        if self.is_on() {
            entries.push(storage_entry::<AirUniform>(AIR));
        }
        if self.shadows {
            entries.extend(super::clouds::shadow_entries());
        }
        entries
    }

    /// One of each kind.
    #[cfg(test)]
    pub(super) fn all() -> [Self; 4] {
        let (on, off) = (Self { perspective: true, fog: true, shadows: true }, Self::default());
        [on, Self { perspective: true, ..off }, Self { fog: true, ..off }, Self { shadows: true, ..off }]
    }
}

/// Whether air and clouds belong to what `scene` shows.
pub(crate) fn shows_air(scene: &Scene) -> bool {
    let is_analytic = matches!(scene.land.colour, GroundColour::Slope | GroundColour::Aspect)
        || LandKey::of(&scene.land).lights_ground();
    scene.debug.view == DebugView::None && !is_analytic
}

/// Mirror of `Air` in `air.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct AirUniform {
    pub(super) kilometres: [f32; 4],
    pub(super) molecules: [f32; 4],
    pub(super) haze: [f32; 4],
    pub(super) fog: [f32; 4],
    pub(super) fog_light: [f32; 4],
    pub(super) sun: [f32; 4],
    pub(super) sun_light: [f32; 4],
    pub(super) sky_light: [f32; 4],
    pub(super) mean: [f32; 4],
    pub(super) shadow_place: [f32; 4],
    pub(super) shadow_shear: [f32; 4],
    pub(super) shadow_levels: [f32; 4],
    pub(super) horizon: [[f32; 4]; HORIZON],
}

/// Extinction of molecules and of haze at the lowest ground, per kilometre, for red, green and blue.
pub(super) fn extinction(visibility: f64) -> [[f64; 3]; 2] {
    let molecules = |length: f64| 0.008_735 * length.powf(-4.08) / 8.4;
    let haze = (3.912 / visibility - molecules(VISIBLE)).max(0.0);
    let exponent = match visibility {
        ..0.5 => 0.0,
        0.5..1.0 => visibility - 0.5,
        1.0..6.0 => 0.16 * visibility + 0.34,
        _ => 1.3,
    };
    [WAVELENGTHS.map(molecules), WAVELENGTHS.map(|length| haze * (VISIBLE / length).powf(exponent))]
}

impl AirUniform {
    /// The constants of `scene` for an eye at a world height; `light` is that of its sky.
    pub(super) fn new(scene: &Scene, km: Kilometres, eye: f64, light: &AirLight) -> Self {
        let AirSettings { visibility, fog_density, fog_base, fog_scale, fog_glow, .. } = scene.air;
        let [molecules, haze] = extinction(visibility);
        let of = |[r, g, b]: [f64; 3], w: f64| [r as f32, g as f32, b as f32, w as f32];
        let from = |light: Vec3, w: f32| [light.x, light.y, light.z, w];
        let mean = light.horizon.iter().sum::<Vec3>() / light.horizon.len().max(1) as f32;
        // Drops are large: they scatter all colours alike.
        let grey = mean.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let sun = scene.lighting.sun_direction();
        let sunlight = exposed(light, light.sun);
        let mut horizon = [[0.0; 4]; HORIZON];
        for (entry, &light) in horizon.iter_mut().zip(&light.horizon) {
            *entry = from(light, 0.0);
        }
        without_subnormals(Self {
            kilometres: [km.along as f32, km.up as f32, (eye * km.up) as f32, 0.0],
            molecules: of(molecules, 1.0 / MOLECULES_SCALE),
            haze: of(haze, 1.0 / HAZE_SCALE),
            fog: of([fog_density, 1000.0 / fog_scale, fog_base / 1000.0 - km.floor], 0.0),
            fog_light: from(mean.lerp(Vec3::splat(grey), 0.7), 0.0),
            sun: from(sun.as_vec3(), 0.0),
            sun_light: from(sunlight, fog_glow as f32 * 0.9),
            sky_light: from(exposed(light, light.sky), 0.0),
            mean: from(mean, 0.0),
            shadow_place: [0.0; 4],
            shadow_shear: [0.0; 4],
            shadow_levels: [0.0; 4],
            horizon,
        })
    }
}

/// Light as a picture of this sky shows it.
fn exposed(light: &AirLight, colour: Vec3) -> Vec3 {
    if light.exposed { Vec3::ONE - (-1.6 * colour).exp() } else { colour }
}

/// Share of light from the sky in a direction that gets through the fog to an eye at a world height.
pub(super) fn fog_before_sky(scene: &Scene, km: Kilometres, eye: f64, direction: DVec3) -> f64 {
    if !AirKey::of(scene).fog {
        return 1.0;
    }
    let way = DVec3::new(direction.x * km.along, direction.y * km.up, direction.z * km.along);
    let (rise, over) = (way.y / way.length(), eye * km.up - (scene.air.fog_base / 1000.0 - km.floor));
    let scale = scene.air.fog_scale / 1000.0;
    let column = (-over).max(0.0) + scale * (-over.max(0.0) / scale).exp();
    if rise <= 0.0 { 0.0 } else { (-scene.air.fog_density * column / rise).exp() }
}

/// The constants' buffer.
#[derive(Debug)]
pub(super) struct AirBindings {
    buffer: wgpu::Buffer,
}

impl AirBindings {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self { buffer: storage_buffer(gpu, "air", size_of::<AirUniform>()) }
    }

    pub(super) fn write(&self, gpu: &Gpu, uniform: &AirUniform) {
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(uniform));
    }

    pub(super) fn entry(&self) -> (u32, wgpu::BindingResource<'_>) {
        (AIR, self.buffer.as_entire_binding())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A black object at the visibility keeps 2 % of its contrast, whatever the haze; blue light is scattered most.
    #[test]
    fn visibility_is_koschmieders() {
        for visibility in [0.1, 0.7, 3.0, 20.0, 60.0, 300.0] {
            let [molecules, haze] = extinction(visibility);
            let all: Vec<f64> = molecules.iter().zip(haze).map(|(a, b)| a + b).collect();
            let contrast = (-all[1] * visibility).exp();
            // Green stands for 545 nm, visibility for 550 nm.
            assert!((0.017..0.0205).contains(&contrast), "{visibility} km: {contrast}");
            assert!(all[0] <= all[1] && all[1] <= all[2] && haze.iter().all(|&haze| haze >= 0.0), "{all:?}");
        }
    }
}
