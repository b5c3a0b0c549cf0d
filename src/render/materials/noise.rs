//! Noise on the unit torus, for textures that tile: gradient noise (Perlin 2002) and cells (Worley 1996).

use std::f32::consts::TAU;

/// 32 mixed bits of a lattice point (the finaliser of MurmurHash3).
fn hash(seed: u32, x: u32, y: u32) -> u32 {
    let mut bits = seed.wrapping_mul(0x9e37_79b9) ^ x.wrapping_mul(0x85eb_ca6b) ^ y.wrapping_mul(0xc2b2_ae35);
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ (bits >> 13)).wrapping_mul(0xc2b2_ae35);
    bits ^ (bits >> 16)
}

/// 0 to 1, from 16 bits.
fn unit(bits: u32) -> f32 {
    (bits & 0xffff) as f32 / 65536.0
}

/// The cell of a coordinate, within a period, the next one, and the place in it.
fn split(at: f32, period: u32) -> (u32, u32, f32) {
    let cell = at.floor();
    let index = (cell as i64).rem_euclid(i64::from(period)) as u32;
    (index, (index + 1) % period, at - cell)
}

fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Gradient noise, about −1 to 1, at a place of the unit torus that is divided into so many cells each way.
pub(super) fn gradient(seed: u32, periods: [u32; 2], [u, v]: [f32; 2]) -> f32 {
    let (i, i1, x) = split(u * periods[0] as f32, periods[0]);
    let (j, j1, y) = split(v * periods[1] as f32, periods[1]);
    let ramp = |i: u32, j: u32, x: f32, y: f32| {
        // One of eight directions: (±1, ±½) and (±½, ±1).
        let bits = hash(seed, i, j);
        let (long, short) = if bits & 1 == 0 { (x, y) } else { (y, x) };
        let signed = |value: f32, bit: u32| if bits & bit == 0 { value } else { -value };
        signed(long, 2) + signed(0.5 * short, 4)
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let across = fade(x);
    let north = mix(ramp(i, j, x, y), ramp(i1, j, x - 1.0, y), across);
    let south = mix(ramp(i, j1, x, y - 1.0), ramp(i1, j1, x - 1.0, y - 1.0), across);
    1.3 * mix(north, south, fade(y))
}

/// Octaves of gradient noise, each twice as fine and `gain` as high as the one before; about −1 to 1.
pub(in crate::render) fn fractal(seed: u32, periods: [u32; 2], octaves: u32, gain: f32, at: [f32; 2]) -> f32 {
    let (mut sum, mut amplitude, mut most) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        sum += amplitude * gradient(seed + octave, periods.map(|period| period << octave), at);
        most += amplitude * amplitude;
        amplitude *= gain;
    }
    sum / most.sqrt()
}

/// Octaves with their creases turned up (Musgrave 1994); about −1 to 1.
pub(in crate::render) fn ridged(seed: u32, periods: [u32; 2], octaves: u32, gain: f32, at: [f32; 2]) -> f32 {
    let (mut sum, mut amplitude, mut most) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let crease = 1.0 - 2.0 * gradient(seed + octave, periods.map(|period| period << octave), at).abs();
        sum += amplitude * crease;
        most += amplitude;
        amplitude *= gain;
    }
    sum / most
}

/// What a place has to do with points that are strewn one to a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// Distance to the nearest point, in cells.
    pub(super) nearest: f32,
    /// Distance to the second nearest.
    pub(super) second: f32,
    /// A number of the nearest point's own, 0 to 1.
    pub(super) own: f32,
    /// Direction in which the nearest point's stone is tilted: unit vector times offset, in cells.
    pub(super) tilt: f32,
}

/// The strewn points around a place of the unit torus with so many cells each way.
pub(super) fn cells(seed: u32, periods: [u32; 2], [u, v]: [f32; 2]) -> Cells {
    let (i, _, x) = split(u * periods[0] as f32, periods[0]);
    let (j, _, y) = split(v * periods[1] as f32, periods[1]);
    let mut found = Cells { nearest: 9.0, second: 9.0, own: 0.0, tilt: 0.0 };
    for dy in -1i32..=1 {
        for dx in -1i32..=1 {
            let wrapped = |index: u32, step: i32, period: u32| (index + period).wrapping_add_signed(step) % period;
            let bits = hash(seed, wrapped(i, dx, periods[0]), wrapped(j, dy, periods[1]));
            let (px, py) = (dx as f32 + unit(bits) - x, dy as f32 + unit(bits >> 16) - y);
            let distance = px.hypot(py);
            if distance < found.nearest {
                let own = unit(bits.wrapping_mul(0x2c1b_3c6d) >> 9);
                let (sin, cos) = (own * 7.0 * TAU).sin_cos();
                found = Cells { nearest: distance, second: found.nearest, own, tilt: -(px * cos + py * sin) };
            } else if distance < found.second {
                found.second = distance;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What does not continue at the border of a tile shows as a line on the ground.
    #[test]
    fn noise_continues_across_the_borders_of_the_torus() {
        for step in 0..40 {
            let t = step as f32 / 40.0;
            let both = |at: [f32; 2]| {
                [
                    fractal(3, [4, 4], 5, 0.5, at),
                    ridged(5, [3, 5], 4, 0.6, at),
                    cells(7, [6, 9], at).nearest,
                    cells(7, [6, 9], at).second,
                ]
            };
            for (here, there) in [([0.0, t], [1.0, t]), ([t, 0.0], [t, 1.0])] {
                for (one, other) in both(here).into_iter().zip(both(there)) {
                    assert!((one - other).abs() < 1e-4, "{here:?}: {one}, {other}");
                }
            }
        }
    }
}
