//! A procedural cube map: sky, the sun's disc in the light's direction, distant hills.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::scene::LightingSettings;
use crate::scene::sun::SunPlace;

use super::mips::{Image, encode};
use super::sky_model::{Daylight, SkyLight};

/// Texels along a face's edge.
pub(super) const FACE: u32 = 512;

/// Angular radius of the sun's disc in degrees: larger than the real one (0.27°), which would be two texels.
const SUN_RADIUS: f32 = 1.1;

/// What the map shows; a change of it makes a new map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sky {
    /// Towards the sun, unit length, world space.
    pub(super) sun: Vec3,
    /// Width over height of the box that the map is drawn on.
    pub(super) flattening: f32,
    /// Haze of the physical sky; absent: the painted one.
    pub(super) turbidity: Option<f64>,
}

/// The sun of a sky. By a clock that runs it moves in steps of half a texel: to make the map anew for less would show
/// nothing.
pub(super) fn sun_of(lighting: &LightingSettings) -> Vec3 {
    let mut lighting = lighting.clone();
    if lighting.clock.runs() {
        let SunPlace { azimuth, elevation } = lighting.sun_place();
        let stepped = |degrees: f64| (degrees / CLOCK_STEP).round() as f32 * CLOCK_STEP as f32;
        (lighting.sun_azimuth, lighting.sun_elevation) = (stepped(azimuth), stepped(elevation));
        lighting.clock.enabled = false;
    }
    lighting.sun_direction().as_vec3()
}

/// Degrees.
const CLOCK_STEP: f64 = 0.1;

/// The direction on the unit cube through the centre of texel (`x`, `y`) of face `face`: +x, −x, +y, −y, +z, −z. The outer
/// texels' centres lie on the edges: neighbouring faces share them, so that no seam shows.
fn texel_direction(face: usize, x: u32, y: u32) -> Vec3 {
    let s = 2.0 * x as f32 / (FACE - 1) as f32 - 1.0;
    let t = 2.0 * y as f32 / (FACE - 1) as f32 - 1.0;
    match face {
        0 => Vec3::new(1.0, -t, -s),
        1 => Vec3::new(-1.0, -t, s),
        2 => Vec3::new(s, 1.0, t),
        3 => Vec3::new(s, -1.0, -t),
        4 => Vec3::new(s, -t, 1.0),
        _ => Vec3::new(-s, -t, -1.0),
    }
}

/// The six faces.
pub(super) fn faces(sky: &Sky) -> Vec<Image> {
    let daylight = sky.turbidity.map(|turbidity| Physical::new(sky.sun, turbidity));
    (0..6)
        .map(|face| {
            let mut rgba = vec![255; (FACE * FACE * 4) as usize];
            rgba.par_chunks_mut(FACE as usize * 4).enumerate().for_each(|(y, row)| {
                for (x, texel) in row.chunks_exact_mut(4).enumerate() {
                    // The map is drawn on a flattened box: where a texel ends up in the world decides its colour.
                    let on_cube = texel_direction(face, x as u32, y as u32);
                    let direction = (on_cube * Vec3::new(1.0, 1.0 / sky.flattening, 1.0)).normalize();
                    let color = match &daylight {
                        Some(daylight) => daylight.colour(direction),
                        None => colour(sky, direction),
                    };
                    // Half a step of ordered noise: without it the gradient shows its 8 bits as rings.
                    let noise = (hash(x as i32, (y + face * FACE as usize) as i32) - 0.5) / 255.0;
                    for (byte, light) in texel.iter_mut().zip(color.to_array()) {
                        *byte = encode(light * (1.0 + noise));
                    }
                }
            });
            Image { width: FACE, height: FACE, rgba }
        })
        .collect()
}

/// Softness of the physical sun's edge: about a texel, in degrees.
const SUN_EDGE: f32 = 0.2;

/// A sky by `sky_model.rs`, as a picture shows it.
struct Physical {
    sky: Daylight,
    light: SkyLight,
    sun: Vec3,
    /// Light of the plain around the map.
    plain: Vec3,
}

impl Physical {
    fn new(sun: Vec3, turbidity: f64) -> Self {
        let sky = Daylight::new(sun.as_dvec3(), turbidity);
        let light = sky.light();
        let from_above = light.harmonics[0] + light.harmonics[1] - light.harmonics[6] - light.harmonics[8];
        let plain = (from_above + light.sun * f64::from(sun.y.max(0.0))).as_vec3() * PLAIN;
        Self { light, sky, sun, plain }
    }

    /// Linear light from `direction` (unit length), whatever the brightness below white.
    fn colour(&self, direction: Vec3) -> Vec3 {
        let level = DVec3::new(direction.x.into(), f64::from(direction.y).max(0.0), direction.z.into());
        let mut light = (self.sky.sky(level.normalize_or(DVec3::Y)) * self.light.exposure).as_vec3();
        // Below the horizon a plain, the farther the more of the haze before it: no edge where it meets the sky.
        let plain = self.plain.lerp(light, 0.12);
        light = light.lerp(plain, if direction.y < 0.0 { (PLAIN_HAZE / direction.y).exp() } else { 0.0 });
        let below = (-direction.y * 12.0).clamp(0.0, 1.0);
        // The true disc is three texels wide; its brightness spreads into what the model has around it.
        let angle = direction.dot(self.sun).clamp(-1.0, 1.0).acos().to_degrees();
        let disc = ((PHYSICAL_SUN + SUN_EDGE - angle) / (2.0 * SUN_EDGE)).clamp(0.0, 1.0) * (1.0 - below).floor();
        light += self.light.sun.as_vec3() * (20.0 * disc * disc);
        shown(light)
    }
}

/// Light as a picture shows it, 0 to 1. Each colour by a curve of its own would bleach the strong ones and keep the weak: the
/// orange around a low sun would turn to lemon. Most of the curve is therefore that of the strongest colour, which keeps the
/// hue; the rest lets the sun itself go white.
fn shown(light: Vec3) -> Vec3 {
    let light = light.max(Vec3::ZERO);
    let strongest = light.max_element().max(1e-6);
    let same_hue = light * ((1.0 - (-strongest).exp()) / strongest);
    same_hue.lerp(Vec3::ONE - (-light).exp(), BLEACHED)
}

/// Share of the curve that each colour has of its own.
const BLEACHED: f32 = 0.3;

/// Reflectance of the plain, greyed by the air over it.
const PLAIN: Vec3 = Vec3::new(0.20, 0.20, 0.19);

/// Sine of the angle below the horizon at which haze leaves 37 % of the plain's light.
const PLAIN_HAZE: f32 = 0.07;

/// Angular radius of the physical sun's disc in degrees; the true one is 0.27°.
const PHYSICAL_SUN: f32 = 0.4;

/// The painted sky's horizon away from the sun, how low the sun stands, 0 to 1, and how bright the day is.
fn painted(sun: Vec3) -> (Vec3, f32, f32) {
    let low_sun = 1.0 - sun.y.clamp(0.0, 0.5) * 2.0;
    let day = ((sun.y + 0.1) * 5.0).clamp(0.06, 1.0);
    let horizon = Vec3::new(0.62, 0.72, 0.82).lerp(Vec3::new(0.86, 0.62, 0.42), low_sun * low_sun * 0.7);
    (horizon, low_sun, day)
}

/// The painted sky without sun and hills, before the day dims it.
fn gradient(sun: Vec3, direction: Vec3) -> Vec3 {
    let (horizon, low_sun, _) = painted(sun);
    let zenith = Vec3::new(0.10, 0.27, 0.62);
    let height = direction.y.max(0.0);
    let light = horizon.lerp(zenith, 1.0 - (1.0 - height).powi(4));
    let towards_sun = direction.dot(sun);
    let glow = Vec3::new(1.0, 0.86, 0.62);
    light + glow * (0.35 * towards_sun.max(0.0).powi(24) + 0.12 * towards_sun.max(0.0).powi(4) * low_sun)
}

/// What a sky lights the air and the clouds with, linear light as a picture shows it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AirLight {
    /// Of the sky at the horizon, by direction.
    pub(super) horizon: Vec<Vec3>,
    /// Of the sun, and of the sky from above.
    pub(super) sun: Vec3,
    pub(super) sky: Vec3,
    /// Light is to be exposed, as that of the physical sky is.
    pub(super) exposed: bool,
}

impl AirLight {
    /// That of one colour all around.
    pub(super) fn flat(colour: Vec3) -> Self {
        Self { horizon: vec![colour; HORIZON], sun: Vec3::new(0.95, 0.9, 0.8), sky: colour, exposed: false }
    }

    /// That of `sky`.
    pub(super) fn of(sky: &Sky) -> Self {
        let directions = (0..HORIZON).map(horizon_direction);
        if let Some(turbidity) = sky.turbidity {
            let physical = Physical::new(sky.sun, turbidity);
            let at_horizon = |direction: Vec3| {
                let light = physical.sky.sky(direction.as_dvec3()) * physical.light.exposure;
                shown(light.as_vec3())
            };
            let above = physical.sky.sky(DVec3::Y) * physical.light.exposure;
            return Self {
                horizon: directions.map(at_horizon).collect(),
                sun: physical.light.sun.as_vec3(),
                sky: above.as_vec3(),
                exposed: true,
            };
        }
        let (horizon, low_sun, day) = painted(sky.sun);
        let sun = Vec3::new(1.0, 0.95, 0.86).lerp(Vec3::new(1.0, 0.58, 0.30), low_sun.powi(4));
        Self {
            horizon: directions.map(|direction| gradient(sky.sun, direction) * day).collect(),
            sun: sun * ((sky.sun.y + 0.06) * 9.0).clamp(0.0, 1.0),
            sky: gradient(sky.sun, Vec3::Y).lerp(horizon, 0.55) * day,
            exposed: false,
        }
    }

    /// That of six images: their middle rows, which lie at the horizon.
    pub(super) fn of_images(faces: &[Image]) -> Self {
        let shown = |index| {
            let direction: Vec3 = horizon_direction(index);
            let (face, across) = match direction.x.abs() > direction.z.abs() {
                true if direction.x > 0.0 => (0, -direction.z / direction.x),
                true => (1, -direction.z / direction.x),
                false if direction.z > 0.0 => (4, direction.x / direction.z),
                false => (5, direction.x / direction.z),
            };
            faces.get(face).map_or(Vec3::ZERO, |face| face.around(0.5 + 0.5 * across, 0.5))
        };
        let horizon: Vec<Vec3> = (0..HORIZON).map(shown).collect();
        let mean = horizon.iter().sum::<Vec3>() / HORIZON as f32;
        Self { horizon, sky: mean, ..Self::flat(mean) }
    }
}

/// Directions in which the light of the horizon is known.
pub(super) const HORIZON: usize = 128;

/// The direction of an entry: evenly around a square that stands on a corner, so that a shader finds it without an angle.
fn horizon_direction(index: usize) -> Vec3 {
    let turn = 4.0 * index as f32 / HORIZON as f32;
    let (x, z) =
        if turn < 2.0 { (1.0 - turn, 1.0 - (1.0 - turn).abs()) } else { (turn - 3.0, (turn - 3.0).abs() - 1.0) };
    let length = x.hypot(z);
    Vec3::new(x / length, 0.0, z / length)
}

/// Linear light from `direction` (unit length).
fn colour(sky: &Sky, direction: Vec3) -> Vec3 {
    let (horizon, _, day) = painted(sky.sun);
    let mut light = gradient(sky.sun, direction);
    let towards_sun = direction.dot(sky.sun);
    let edge = SUN_RADIUS.to_radians().cos();
    let soft = (1.35 * SUN_RADIUS).to_radians().cos();
    let disc = ((towards_sun - soft) / (edge - soft)).clamp(0.0, 1.0);
    light = light.lerp(Vec3::new(1.6, 1.45, 1.15), disc);

    // Two ridges of hills, the nearer one darker; haze blends both into the horizon.
    for (scale, lowest, highest, rock) in
        [(5.0, 0.012, 0.062, Vec3::new(0.36, 0.44, 0.55)), (9.0, -0.004, 0.036, Vec3::new(0.23, 0.27, 0.30))]
    {
        let ridge = lowest + (highest - lowest) * ridge_line(direction, scale);
        let haze = ((direction.y + 0.12) / 0.2).clamp(0.0, 1.0);
        light = light.lerp(rock.lerp(horizon, 0.35 * haze + 0.1), below(direction.y, ridge));
    }
    // Below the horizon a plain, the farther the more of the haze at the hills' feet before it: no edge where they meet.
    let depth = ((-direction.y - 0.02) * 4.0).clamp(0.0, 1.0);
    let plain = Vec3::new(0.50, 0.46, 0.41).lerp(Vec3::new(0.30, 0.25, 0.20), depth);
    let clear = (PAINTED_HAZE / direction.y.min(-1e-3)).exp();
    light.lerp(plain, clear * below(direction.y, -0.02)) * day
}

/// Sine of the angle below the painted horizon at which haze leaves 37 % of the plain's light.
const PAINTED_HAZE: f32 = 0.09;

/// How much of a texel at the height `y` lies below `edge`: edges are as soft as a texel is large, or they show as
/// stairs.
fn below(y: f32, edge: f32) -> f32 {
    const TEXEL: f32 = 2.0 / FACE as f32;
    ((edge - y) / TEXEL + 0.5).clamp(0.0, 1.0)
}

/// Height of a ridge, 0 to 1, in the compass direction of `direction`: value noise on a circle, so that it closes.
fn ridge_line(direction: Vec3, scale: f32) -> f32 {
    let flat = DVec3::new(f64::from(direction.x), 0.0, f64::from(direction.z)).normalize_or_zero().as_vec3();
    let mut sum = 0.0;
    let (mut weight, mut frequency) = (0.5, scale);
    for octave in 0..6 {
        sum +=
            weight * value_noise(flat.x * frequency + 17.3 * octave as f32, flat.z * frequency - 9.1 * octave as f32);
        weight *= 0.5;
        frequency *= 2.1;
    }
    sum
}

fn value_noise(x: f32, y: f32) -> f32 {
    let (ix, iy) = (x.floor(), y.floor());
    let smooth = |f: f32| f * f * (3.0 - 2.0 * f);
    let (fx, fy) = (smooth(x - ix), smooth(y - iy));
    let at = |i: i32, j: i32| hash(ix as i32 + i, iy as i32 + j);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    mix(mix(at(0, 0), at(1, 0), fx), mix(at(0, 1), at(1, 1), fx), fy)
}

/// A number in 0..1 that looks random, from a lattice point.
fn hash(x: i32, y: i32) -> f32 {
    let mut n = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    n = (n ^ (n >> 15)).wrapping_mul(0x2c1b_3c6d);
    n = (n ^ (n >> 12)).wrapping_mul(0x297a_2d39);
    (n ^ (n >> 15)) as f32 / u32::MAX as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sun in the picture must stand where the light comes from, whatever the flattening.
    #[test]
    fn the_brightest_texel_lies_towards_the_sun() {
        for (flattening, turbidity) in [(1.0, None), (2.5, None), (2.0, Some(3.0))] {
            let sun = Vec3::new(0.4, 0.35, -0.8).normalize();
            let faces = faces(&Sky { sun, flattening, turbidity });
            let (mut brightest, mut best) = (0, Vec3::ZERO);
            for (index, face) in faces.iter().enumerate() {
                for (i, texel) in face.rgba.chunks_exact(4).enumerate() {
                    let sum: u32 = texel[..3].iter().map(|&byte| u32::from(byte)).sum();
                    if sum > brightest {
                        brightest = sum;
                        best = texel_direction(index, i as u32 % FACE, i as u32 / FACE);
                    }
                }
            }
            let direction = (best * Vec3::new(1.0, 1.0 / flattening, 1.0)).normalize();
            let angle = direction.dot(sun).min(1.0).acos().to_degrees();
            assert!(angle < 2.0, "{angle}° off at flattening {flattening}");
        }
    }
}
