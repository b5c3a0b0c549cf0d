//! The materials' textures, made of noise: once in a program, on all cores, away from any frame.
//!
//! A texel holds what a shader adds to a material's mean, each from −1 to 1 and 0 on average: the slope of its relief along
//! the two axes, the relief's height, and a tint between the material's two colours. All of it is linear, so a mip's
//! average is what the eye sees of the texels under it, and far away nothing but the mean is left.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::noise::{cells, fractal, gradient, ridged};

/// Texels along a side.
pub(super) const SIDE: usize = 512;

/// Layers: one for each material, the strata of rock's steep sides, and broad variation of everything.
pub(super) const LAYERS: usize = 8;

/// Levels of a layer, down to one texel.
pub(super) const LEVELS: usize = SIDE.ilog2() as usize + 1;

/// Relief and tint at a place of the unit torus.
type Recipe = fn([f32; 2]) -> [f32; 2];

/// A layer's recipe, the spread (standard deviation) of its height and tint, and that of its slopes.
const RECIPES: [(Recipe, [f32; 2], f32); LAYERS] = [
    (grass, [0.26, 0.34], 0.20),
    (rock, [0.30, 0.30], 0.30),
    (scree, [0.30, 0.32], 0.30),
    (snow, [0.22, 0.25], 0.07),
    (sand, [0.24, 0.26], 0.11),
    (sea_bed, [0.26, 0.30], 0.14),
    (cliff, [0.30, 0.34], 0.30),
    (broad, [0.34, 0.34], 0.30),
];

/// Every layer's mips, finest first; signed bytes, four to a texel.
pub(super) fn textures() -> &'static [Vec<Vec<i8>>] {
    static TEXTURES: OnceLock<Vec<Vec<Vec<i8>>>> = OnceLock::new();
    TEXTURES.get_or_init(|| RECIPES.par_iter().map(|&(recipe, spreads, slope)| layer(recipe, spreads, slope)).collect())
}

fn layer(recipe: Recipe, spreads: [f32; 2], slope: f32) -> Vec<Vec<i8>> {
    let side = SIDE;
    let mut places = vec![[0.0f32; 2]; side * side];
    places.par_chunks_mut(side).enumerate().for_each(|(row, places)| {
        let v = (row as f32 + 0.5) / side as f32;
        for (column, place) in places.iter_mut().enumerate() {
            *place = recipe([(column as f32 + 0.5) / side as f32, v]);
        }
    });
    for (channel, spread) in spreads.into_iter().enumerate() {
        normalise(&mut places, channel, spread);
    }
    let height = |column: usize, row: usize| places[(row % side) * side + column % side][0];
    let mut texels: Vec<[f32; 4]> = (0..side * side)
        .map(|index| {
            let (column, row) = (index % side, index / side);
            let along = height(column + 1, row) - height(column + side - 1, row);
            let down = height(column, row + 1) - height(column, row + side - 1);
            [along, down, places[index][0], places[index][1]]
        })
        .collect();
    let slopes: f32 = texels.iter().map(|texel| texel[0] * texel[0] + texel[1] * texel[1]).sum();
    let factor = slope / (0.5 * slopes / texels.len() as f32).sqrt().max(1e-9);
    texels.iter_mut().for_each(|texel| {
        texel[0] *= factor;
        texel[1] *= factor;
    });
    let mut levels = Vec::with_capacity(LEVELS);
    let mut width = side;
    loop {
        levels.push(texels.iter().flatten().map(|&value| (value.clamp(-1.0, 1.0) * 127.0).round() as i8).collect());
        if width == 1 {
            return levels;
        }
        texels = halved(&texels, width);
        width /= 2;
    }
}

/// Shifts and scales a channel to a mean of 0 and the given standard deviation.
fn normalise(places: &mut [[f32; 2]], channel: usize, spread: f32) {
    let count = places.len() as f32;
    let mean = places.iter().map(|place| f64::from(place[channel])).sum::<f64>() as f32 / count;
    let variance = places.iter().map(|place| f64::from(place[channel] - mean).powi(2)).sum::<f64>() as f32 / count;
    let factor = spread / variance.sqrt().max(1e-9);
    places.iter_mut().for_each(|place| place[channel] = ((place[channel] - mean) * factor).clamp(-1.0, 1.0));
}

/// Means of 2×2 texels.
fn halved(texels: &[[f32; 4]], width: usize) -> Vec<[f32; 4]> {
    let half = width / 2;
    (0..half * half)
        .map(|index| {
            let first = 2 * (index / half) * width + 2 * (index % half);
            let four = [first, first + 1, first + width, first + width + 1];
            std::array::from_fn(|channel| 0.25 * four.iter().map(|&texel| texels[texel][channel]).sum::<f32>())
        })
        .collect()
}

/// A place moved by noise of so many cells and such a height.
fn warped(seed: u32, periods: [u32; 2], by: f32, [u, v]: [f32; 2]) -> [f32; 2] {
    let at = [u, v];
    [u + by * fractal(seed, periods, 3, 0.5, at), v + by * fractal(seed + 50, periods, 3, 0.5, at)]
}

fn smooth(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Tufts and clumps, bare spots between them.
fn grass(at: [f32; 2]) -> [f32; 2] {
    let clumps = fractal(11, [6, 6], 4, 0.6, at);
    let moved = warped(12, [16, 16], 0.012, at);
    let bushes = cells(13, [30, 30], moved);
    let bush = smooth(0.62, 0.1, bushes.nearest) * smooth(0.25, 0.5, bushes.own + 0.35 * clumps);
    let tufts = 1.0 - cells(14, [110, 110], warped(15, [40, 40], 0.004, at)).nearest;
    let blades = fractal(16, [64, 64], 3, 0.8, at);
    [0.45 * clumps + 0.9 * bush + 0.5 * tufts + 0.35 * blades, 0.9 * clumps - 1.3 * bush + 0.25 * blades + 0.3 * tufts]
}

/// Crags: creases and slanting faces, split by a few clefts.
fn rock(at: [f32; 2]) -> [f32; 2] {
    let moved = warped(21, [4, 4], 0.09, at);
    let torn = warped(24, [9, 9], 0.045, moved);
    let (large, small) = (cells(22, [5, 8], moved), cells(23, [19, 27], torn));
    let cleft = smooth(0.0, 0.07, large.second - large.nearest);
    let faces = 0.45 * large.tilt + 0.3 * large.own + 0.4 * small.tilt + 0.3 * small.own;
    let crest = ridged(25, [3, 4], 7, 0.66, moved);
    let slabs = ridged(29, [7, 3], 5, 0.6, torn);
    let grain = fractal(26, [40, 40], 4, 0.75, at);
    let height = faces + 0.22 * cleft + 1.25 * crest + 0.6 * slabs + 0.2 * grain;
    let lichen = smooth(0.1, 0.8, fractal(27, [9, 9], 5, 0.65, at));
    let tint = 0.25 * large.own + 0.25 * small.own + 0.8 * fractal(28, [3, 3], 6, 0.62, torn) + 0.4 * crest;
    [height, tint + 0.2 * grain - 0.4 * lichen]
}

/// Stones of three sizes, heaped.
fn scree(at: [f32; 2]) -> [f32; 2] {
    let heaps = fractal(31, [4, 4], 4, 0.55, at);
    let (mut height, mut tint): (f32, f32) = (-1.0, 0.0);
    for (seed, period, size) in [(32, 88, 0.35), (33, 44, 0.6), (34, 19, 1.0)] {
        let stones =
            cells(seed, [period, period], warped(seed + 5, [period / 2, period / 2], 0.25 / period as f32, at));
        // The larger stones lie here and there on the smaller ones.
        let there = size < 0.5 || stones.own + 0.25 * heaps > 1.0 - 0.75 / (1.0 + 2.0 * size);
        let round = 1.0 - (stones.nearest / (0.5 * (stones.nearest + stones.second)).max(1e-3)).powi(3);
        let top = size * (0.9 * round.max(0.0).sqrt() + 0.4 * stones.tilt + 0.3 * stones.own);
        if there && top > height {
            (height, tint) = (top, 2.0 * (stones.own * 13.0).fract() - 1.0);
        }
    }
    let grain = fractal(35, [64, 64], 3, 0.7, at);
    [height + 0.35 * heaps + 0.1 * grain, 0.6 * tint + 0.5 * heaps + 0.2 * grain + 0.3 * height]
}

/// Drifts, and the fine ridges that wind cuts into them.
fn snow(at: [f32; 2]) -> [f32; 2] {
    let drifts = fractal(41, [3, 4], 4, 0.5, at);
    let [u, v] = warped(42, [4, 4], 0.04, at);
    let ridges = ridged(43, [10, 26], 3, 0.55, [u, v]);
    let grain = gradient(44, [96, 96], at);
    [drifts + 0.45 * ridges * smooth(-0.6, 0.8, drifts) + 0.08 * grain, 0.8 * drifts + 0.3 * ridges + 0.1 * grain]
}

/// Ripples of the wind, and grains.
fn sand(at: [f32; 2]) -> [f32; 2] {
    let dunes = fractal(51, [3, 3], 4, 0.5, at);
    let [u, v] = warped(52, [4, 5], 0.035, at);
    let phase = (3.0 * u + 24.0 * v) * std::f32::consts::TAU;
    // A gentle side up the wind, a steep one down.
    let ripple = phase.sin() + 0.3 * (2.0 * phase + 0.6).sin();
    let grain = fractal(53, [90, 90], 2, 0.9, at);
    [dunes + 0.33 * ripple * smooth(-0.7, 0.6, dunes) + 0.22 * grain, 0.9 * dunes + 0.12 * ripple + 0.4 * grain]
}

/// Mud and pebbles, darker where weed grows.
fn sea_bed(at: [f32; 2]) -> [f32; 2] {
    let mounds = fractal(61, [4, 4], 5, 0.55, at);
    let pebbles = cells(62, [40, 40], warped(63, [20, 20], 0.008, at));
    let pebble = smooth(0.5, 0.15, pebbles.nearest) * smooth(0.55, 0.7, pebbles.own + 0.3 * mounds);
    let weed = smooth(0.1, 0.8, fractal(64, [5, 5], 5, 0.65, at));
    let grain = fractal(65, [80, 80], 2, 0.8, at);
    [mounds + 0.8 * pebble + 0.3 * grain + 0.5 * weed, 0.6 * mounds + 0.5 * pebble - 1.2 * weed + 0.2 * grain]
}

/// Beds of hard and soft rock, weathered into ledges and cut by joints.
fn cliff(at: [f32; 2]) -> [f32; 2] {
    let [u, v] = warped(71, [3, 4], 0.018, at);
    let bed = |seed: u32, period: u32| gradient(seed, [1, period], [0.37, v]);
    let thick = bed(72, 9);
    let beds = 1.1 * thick + 0.8 * bed(73, 22) + 0.55 * bed(74, 47) + 0.35 * bed(75, 101);
    // Hard beds stand out as ledges.
    let ledges = smooth(-0.7, 0.5, beds) + 0.4 * beds;
    let joints = cells(76, [16, 5], warped(77, [8, 8], 0.02, [u, v]));
    let joint = smooth(0.0, 0.2, joints.second - joints.nearest);
    let gullies = ridged(78, [9, 2], 4, 0.6, warped(79, [6, 3], 0.03, at));
    let grain = fractal(80, [32, 32], 4, 0.7, at);
    let height = 1.2 * ledges + 0.35 * joint + 0.45 * joints.tilt - 0.8 * gullies + 0.3 * grain;
    [height, 1.0 * thick + 0.8 * bed(81, 31) + 0.5 * bed(82, 67) + 0.25 * grain - 0.35 * gullies]
}

/// Two unrelated fields from broad to fine.
fn broad(at: [f32; 2]) -> [f32; 2] {
    [fractal(91, [4, 4], 7, 0.62, at), fractal(101, [5, 5], 7, 0.62, warped(111, [4, 4], 0.06, at))]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The colour of a material far away is its own: what a texture adds must vanish in its last mip.
    #[test]
    fn textures_add_nothing_on_average_and_something_everywhere() {
        let layers = textures();
        assert_eq!(layers.len(), LAYERS);
        for (number, levels) in layers.iter().enumerate() {
            assert_eq!(levels.len(), LEVELS);
            let last = levels.last().unwrap();
            assert!(last.iter().all(|value| value.abs() <= 6), "layer {number} ends with {last:?}");
            for channel in 0..4 {
                let values = || levels[0].chunks_exact(4).map(|texel| f64::from(texel[channel]) / 127.0);
                let spread = (values().map(|value| value * value).sum::<f64>() / (SIDE * SIDE) as f64).sqrt();
                assert!((0.03..0.5).contains(&spread), "layer {number}, channel {channel}: {spread}");
                let cut = values().filter(|value| value.abs() > 0.999).count();
                assert!(cut < SIDE * SIDE / 25, "layer {number}, channel {channel}: {cut} texels are cut off");
            }
        }
    }

    /// A tile's border must not show: across it texels differ no more than elsewhere.
    #[test]
    fn textures_tile() {
        for (number, levels) in textures().iter().enumerate() {
            let texel = |column: usize, row: usize, channel: usize| {
                f64::from(levels[0][((row % SIDE) * SIDE + column % SIDE) * 4 + channel])
            };
            let difference = |column: usize, channel: usize| -> f64 {
                (0..SIDE)
                    .map(|t| {
                        (texel(column, t, channel) - texel(column + 1, t, channel)).abs()
                            + (texel(t, column, channel) - texel(t, column + 1, channel)).abs()
                    })
                    .sum()
            };
            for channel in 0..4 {
                let inside: f64 = (0..16).map(|i| difference(i * 31 + 7, channel)).sum::<f64>() / 16.0;
                let border = difference(SIDE - 1, channel);
                assert!(border < 2.0 * inside, "layer {number}, channel {channel}: {border} against {inside}");
            }
        }
    }
}
