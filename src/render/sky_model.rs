//! The light of a clear sky: Preetham, Shirley, Smits 1999, "A Practical Analytic Model for Daylight", and the colour of
//! the sun through the same air.
//!
//! The model ends at sunset. Below the horizon its last sky is dimmed, which is no model but looks like dusk. A picture
//! holds no such range of brightness as a day has; the exposure follows the light, as that of a camera would, though not
//! all the way, so that evenings stay darker than noons.

use glam::{DMat3, DVec3};

/// Coefficients of Perez's distribution, A to E: slope by turbidity and constant (Preetham, appendix A.2); of the
/// luminance Y and the chromaticities x and y.
const DISTRIBUTION: [[[f64; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];

/// Chromaticities at the zenith: rows for the turbidity's square, itself and 1, columns for the cube to the zeroth power of
/// the sun's angle from the zenith.
const ZENITH: [[[f64; 4]; 3]; 2] = [
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]],
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]],
];

/// Wavelengths that stand for red, green and blue, µm.
const WAVELENGTHS: [f64; 3] = [0.615, 0.545, 0.465];

/// Illuminance of the sun outside the atmosphere, klx.
const SUN: f64 = 128.0;

/// Reflectance of the ground around the map, which lights slopes from below.
const GROUND: DVec3 = DVec3::new(0.22, 0.19, 0.15);

/// How much of a change of light the exposure makes up for, as a power.
const ADAPTATION: f64 = 0.45;

/// Luminance that a picture shows as half of its white at noon, kcd/m², over the logarithm of 2.
const MIDDLE: f64 = 17.0;

/// Elevation at which the exposure is 1.
const NOON: f64 = 45.0;

/// Angle by which the sun has to sink below the horizon for a tenth of the light, degrees.
const DUSK: f64 = 2.6;

/// Steps of the sums over the sky, up and around.
const STEPS: [u32; 2] = [12, 36];

/// The sky over a sun at one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Daylight {
    sun: DVec3,
    turbidity: f64,
    /// Zenith over the distribution there: Y in kcd/m², x, y.
    zenith: [f64; 3],
    dusk: f64,
}

/// What a sky does to surfaces, in units in which a surface that lies flat at noon gets 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SkyLight {
    /// Coefficients of spherical harmonics up to order 2 of the light on a surface by its normal, with all constants in
    /// them (Ramamoorthi and Hanrahan 2001, equations 3, 10 and 12).
    pub(super) harmonics: [DVec3; 9],
    /// Light of the sun on a surface that faces it.
    pub(super) sun: DVec3,
    /// Factor on luminances of the sky.
    pub(super) exposure: f64,
}

impl Daylight {
    /// `sun` is a unit vector; `turbidity` 1.7 (mountain air) to 10 (haze).
    pub(super) fn new(sun: DVec3, turbidity: f64) -> Self {
        let angle = sun.y.clamp(0.0, 1.0).acos();
        let powers = [angle * angle * angle, angle * angle, angle, 1.0];
        let chroma = |rows: [[f64; 4]; 3]| -> f64 {
            let along = |row: [f64; 4]| row.iter().zip(powers).map(|(a, b)| a * b).sum::<f64>();
            turbidity * turbidity * along(rows[0]) + turbidity * along(rows[1]) + along(rows[2])
        };
        let chi = (4.0 / 9.0 - turbidity / 120.0) * (std::f64::consts::PI - 2.0 * angle);
        let luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
        let below = sun.y.clamp(-1.0, 0.0).asin().to_degrees();
        let at_zenith = [luminance.max(0.05), chroma(ZENITH[0]), chroma(ZENITH[1])];
        let mut sky = Self { sun, turbidity, zenith: at_zenith, dusk: 10f64.powf((below / DUSK).max(-5.0)) };
        sky.zenith = std::array::from_fn(|index| at_zenith[index] / sky.distribution(index, 1.0, sky.flat_sun().y));
        sky
    }

    /// Towards the sun, or where it has set.
    fn flat_sun(&self) -> DVec3 {
        if self.sun.y >= 0.0 { self.sun } else { DVec3::new(self.sun.x, 0.0, self.sun.z).normalize_or(DVec3::X) }
    }

    /// Perez's distribution by the cosines of the angles to the zenith and to the sun.
    fn distribution(&self, index: usize, up: f64, to_sun: f64) -> f64 {
        let [a, b, c, d, e] = DISTRIBUTION[index].map(|[slope, constant]| slope * self.turbidity + constant);
        let (up, angle) = (up.max(0.01), to_sun.clamp(-1.0, 1.0).acos());
        (1.0 + a * (b / up).exp()) * (1.0 + c * (d * angle).exp() + e * to_sun * to_sun)
    }

    /// Luminances of the sky in a direction (a unit vector, above the horizon): linear sRGB, kcd/m².
    pub(super) fn sky(&self, direction: DVec3) -> DVec3 {
        let to_sun = direction.dot(self.flat_sun());
        let [y, cx, cy] = [0, 1, 2].map(|index| self.zenith[index] * self.distribution(index, direction.y, to_sun));
        let cy = cy.max(1e-3);
        let xyz = DVec3::new(cx / cy, 1.0, (1.0 - cx - cy) / cy) * y.max(0.0);
        (from_xyz() * xyz).max(DVec3::ZERO) * self.dusk
    }

    /// Illuminance of a surface that faces the sun, by the sun alone: linear sRGB, klx. Absorbed by the air's molecules and
    /// by its aerosol (Preetham, appendix A.1, after Iqbal 1983), whose amount follows from the turbidity.
    pub(super) fn sun(&self) -> DVec3 {
        let elevation = self.sun.y.clamp(-1.0, 1.0).asin().to_degrees();
        let zenith = 90.0 - elevation.max(0.0);
        let mass = 1.0 / (zenith.to_radians().cos() + 0.15 * (93.885 - zenith).powf(-1.253));
        let aerosol = 0.046_08 * self.turbidity - 0.045_86;
        let passes = WAVELENGTHS
            .map(|length| (-mass * (0.008_735 * length.powf(-4.08) + aerosol.max(0.0) * length.powf(-1.3))).exp());
        // The upper half of the disc is seen for a moment longer.
        DVec3::from(passes) * SUN * (1.0 + elevation.min(0.0) / 0.2665).max(0.0)
    }

    /// What the sky and the sun do to surfaces.
    pub(super) fn light(&self) -> SkyLight {
        let harmonics = self.harmonics();
        let noon = Self::new(DVec3::new(NOON.to_radians().cos(), NOON.to_radians().sin(), 0.0), self.turbidity);
        let noon_harmonics = noon.harmonics();
        let all = |sky: &Self, harmonics: &[DVec3; 9]| {
            luminance(towards(harmonics, DVec3::Y)) * std::f64::consts::PI + luminance(sky.sun())
        };
        let exposure = (all(&noon, &noon_harmonics) / all(self, &harmonics)).powf(ADAPTATION);
        let ambient = exposure / luminance(towards(&noon_harmonics, DVec3::Y));
        SkyLight {
            harmonics: harmonics.map(|coefficient| coefficient * ambient),
            sun: self.sun() * exposure / luminance(noon.sun()),
            exposure: exposure / MIDDLE,
        }
    }

    /// Coefficients of the light that a surface gets from all sides, over π: that of a white one's radiance.
    fn harmonics(&self) -> [DVec3; 9] {
        let mut sum = [DVec3::ZERO; 9];
        let (mut flat, around) = (DVec3::ZERO, f64::from(STEPS[1]));
        let mut add = |direction: DVec3, light: DVec3| {
            for (sum, basis) in sum.iter_mut().zip(basis(direction)) {
                *sum += light * basis;
            }
        };
        // Bands of equal area: all directions weigh the same.
        let weight = std::f64::consts::TAU / f64::from(STEPS[0] * STEPS[1]);
        let directions = (0..STEPS[0] * STEPS[1]).map(|index| {
            let up = (f64::from(index / STEPS[1]) + 0.5) / f64::from(STEPS[0]);
            let (sin, cos) = (f64::from(index % STEPS[1]) / around * std::f64::consts::TAU).sin_cos();
            let out = (1.0 - up * up).sqrt();
            DVec3::new(out * sin, up, out * cos)
        });
        for direction in directions.clone() {
            let light = self.sky(direction) * weight;
            flat += light * direction.y;
            add(direction, light);
        }
        flat += self.sun() * self.sun.y.max(0.0);
        for direction in directions {
            add(-direction, flat * GROUND / std::f64::consts::PI * weight);
        }
        std::array::from_fn(|index| sum[index] * CONSTANTS[index])
    }
}

/// Polynomials of a direction, without their constants: as in `sky_light` of `light.wgsl`.
fn basis(n: DVec3) -> [f64; 9] {
    let DVec3 { x, y, z } = n;
    [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y]
}

/// Squares of the harmonics' constants, as both projecting and summing up have them, times the factors by which a matt
/// surface smooths the light over π: 1, 2/3 and 1/4.
const CONSTANTS: [f64; 9] = {
    let (flat, linear) = (0.282_095 * 0.282_095, 0.488_603 * 0.488_603 * 2.0 / 3.0);
    let product = 1.092_548 * 1.092_548 / 4.0;
    let (round, saddle) = (0.315_392 * 0.315_392 / 4.0, 0.546_274 * 0.546_274 / 4.0);
    [flat, linear, linear, linear, product, product, round, product, saddle]
};

/// The light that coefficients give to a surface with this normal.
fn towards(harmonics: &[DVec3; 9], normal: DVec3) -> DVec3 {
    harmonics.iter().zip(basis(normal)).map(|(&coefficient, basis)| coefficient * basis).sum()
}

fn luminance(colour: DVec3) -> f64 {
    colour.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Linear sRGB of a colour in CIE XYZ (IEC 61966-2-1).
fn from_xyz() -> DMat3 {
    DMat3::from_cols_array(&[
        3.2406, -0.9689, 0.0557, //
        -1.5372, 1.8758, -0.2040, //
        -0.4986, 0.0415, 1.0570,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(elevation: f64) -> Daylight {
        let (sin, cos) = elevation.to_radians().sin_cos();
        Daylight::new(DVec3::new(cos, sin, 0.0), 3.0)
    }

    /// The zenith is what the model says it is, in its own formulas, and the light is that of daytime.
    #[test]
    fn the_zenith_has_the_models_luminance() {
        let sky = at(45.0);
        let zenith = luminance(sky.sky(DVec3::Y));
        let chi = (4.0 / 9.0 - 3.0 / 120.0) * std::f64::consts::FRAC_PI_2;
        assert!(
            (zenith / ((4.0453 * 3.0 - 4.9710) * chi.tan() - 0.2155 * 3.0 + 2.4192) - 1.0).abs() < 0.01,
            "{zenith}"
        );
        let blue = sky.sky(DVec3::new(-0.6, 0.8, 0.0));
        assert!(blue.z > 1.5 * blue.x, "{blue}");
        // Some 100 klx at noon of a clear day (IESNA Lighting Handbook).
        let all = sky.sun().element_sum() / 3.0 * sky.sun.y;
        assert!((50.0..110.0).contains(&all), "{all}");
    }

    /// The sun reddens as it sinks, sky and sun grow darker all the way, and nothing is negative.
    #[test]
    fn the_evening_is_red_and_darker_than_noon() {
        let lights: Vec<SkyLight> = [45.0, 20.0, 5.0, 1.0, -3.0, -12.0].map(|elevation| at(elevation).light()).to_vec();
        for pair in lights.windows(2) {
            assert!(luminance(pair[1].sun) <= luminance(pair[0].sun));
            assert!(pair[1].exposure > pair[0].exposure);
            let up = |light: &SkyLight| luminance(towards(&light.harmonics, DVec3::Y));
            assert!(up(&pair[1]) + luminance(pair[1].sun) < up(&pair[0]) + luminance(pair[0].sun));
        }
        assert!(lights[3].sun.x > 3.0 * lights[3].sun.z && lights[0].sun.x < 1.6 * lights[0].sun.z, "{lights:?}");
        for light in lights {
            for index in 0..200 {
                let up = f64::from(index) / 100.0 - 1.0;
                let turn = f64::from(index) * 2.4;
                let out = (1.0 - up * up).sqrt();
                let got = towards(&light.harmonics, DVec3::new(out * turn.cos(), up, out * turn.sin()));
                assert!(got.min_element() > -0.05 * got.max_element().max(0.1), "{got}");
            }
        }
    }

    /// Against the integral that the harmonics stand for, which they miss by a few percent (Ramamoorthi and Hanrahan).
    #[test]
    fn harmonics_give_the_light_of_the_whole_sky() {
        let sky = at(30.0);
        let harmonics = sky.harmonics();
        for normal in [DVec3::Y, DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.5, 0.7, 0.5).normalize()] {
            let (mut sum, mut count) = (DVec3::ZERO, 0);
            for i in 0..40 {
                for j in 0..80 {
                    let (up, turn) = ((f64::from(i) + 0.5) / 40.0, f64::from(j) / 80.0 * std::f64::consts::TAU);
                    let out = (1.0 - up * up).sqrt();
                    let direction = DVec3::new(out * turn.cos(), up, out * turn.sin());
                    sum += sky.sky(direction) * direction.dot(normal).max(0.0);
                    count += 1;
                }
            }
            let sky_only = sum * 2.0 / f64::from(count);
            let got = towards(&harmonics, normal);
            // The ground adds to surfaces that are not level.
            assert!(luminance(got) > 0.9 * luminance(sky_only), "{normal}: {got} of {sky_only}");
            assert!(luminance(got) < 1.1 * luminance(sky_only) + 1.5, "{normal}: {got} of {sky_only}");
        }
    }
}
