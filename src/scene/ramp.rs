//! Colour ramps: what colour a height, a slope or a direction has, and where each ramp comes from.
//!
//! Ramps are tables of 8-bit sRGB colours, linear between their entries. Those taken from elsewhere are thinned: no
//! channel is off the original by more than 11 of 255.

use serde::{Deserialize, Serialize};

/// A colour, 8-bit sRGB.
pub type Colour = [u8; 3];

/// Colours by height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Ramp {
    /// Blue depths and a green to white land; lightness is even on each side, and its break is sea level. Safe for
    /// colour-blind eyes (Crameri 2018, "oleron", MIT).
    #[default]
    Oleron,
    /// Dark blue over green to pink: perceptually even, safe for colour-blind eyes (Crameri 2018, "batlow", MIT).
    Batlow,
    /// Dark violet over green to yellow: perceptually even, safe for colour-blind eyes (van der Walt, Smith 2015, CC0).
    Viridis,
    /// Blue over grey to yellow: looks the same to most colour-blind eyes (Nuñez, Anderton, Renslow 2018, CC0).
    Cividis,
    /// The tints of school atlases: lowland green, yellow, brown, white; the sea in blues, paler where it is shallow.
    Hypsometric,
    /// The bands of a fractal landscape of 2003: deep and shallow water, sand, grass, forest, rock, snow, with hard edges
    /// (Riaboy 2003).
    #[value(name = "riaboy-2003")]
    #[serde(rename = "riaboy-2003")]
    Riaboy2003,
    /// Black to white, evenly light.
    Grey,
}

/// How a ramp's colours lie.
enum Table {
    /// From the lowest to the highest, evenly spaced.
    Even(&'static [Colour]),
    /// Below and above sea level, each evenly spaced.
    Marine(&'static [Colour], &'static [Colour]),
    /// Below and above sea level: bands that end at these shares.
    Bands(&'static [(f32, Colour)], &'static [(f32, Colour)]),
}

/// Texels of a side of sea level in [`Ramp::texels`].
pub(crate) const HALF: usize = 256;

impl Ramp {
    /// All ramps, in the order of the panel.
    pub const ALL: [Self; 7] =
        [Self::Oleron, Self::Batlow, Self::Viridis, Self::Cividis, Self::Hypsometric, Self::Riaboy2003, Self::Grey];

    /// The name used on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Oleron => "oleron",
            Self::Batlow => "batlow",
            Self::Viridis => "viridis",
            Self::Cividis => "cividis",
            Self::Hypsometric => "hypsometric",
            Self::Riaboy2003 => "riaboy-2003",
            Self::Grey => "grey",
        }
    }

    /// Whether the ramp's colours break at sea level.
    pub fn is_marine(self) -> bool {
        !matches!(self.table(), Table::Even(_))
    }

    /// The colour of a share of the way, 0 to 1. Of a ramp that breaks at sea level, the lower half is the sea's, and 0.5
    /// itself is land.
    pub fn colour(self, share: f32) -> Colour {
        let share = share.clamp(0.0, 1.0);
        if share < 0.5 { self.side(false, share * 2.0) } else { self.side(true, share * 2.0 - 1.0) }
    }

    /// The colour on one side of the middle, 0 to 1 from its lower end.
    fn side(self, upper: bool, share: f32) -> Colour {
        match self.table() {
            Table::Even(colours) => between(colours, (share + f32::from(u8::from(upper))) * 0.5),
            Table::Marine(sea, land) => between(if upper { land } else { sea }, share),
            Table::Bands(sea, land) => {
                let bands = if upper { land } else { sea };
                let band = bands.iter().find(|(end, _)| share < *end).or(bands.last());
                band.map_or([0; 3], |(_, colour)| *colour)
            }
        }
    }

    /// The colours of both sides of the middle, [`HALF`] each: a sampler that stays within a side never blends over the
    /// break.
    pub(crate) fn texels(self) -> Vec<Colour> {
        sides(|upper, share| self.side(upper, share))
    }

    fn table(self) -> Table {
        match self {
            Self::Oleron => Table::Marine(&OLERON_SEA, &OLERON_LAND),
            Self::Batlow => Table::Even(&BATLOW),
            Self::Viridis => Table::Even(&VIRIDIS),
            Self::Cividis => Table::Even(&CIVIDIS),
            Self::Hypsometric => Table::Marine(&ATLAS_SEA, &ATLAS_LAND),
            Self::Riaboy2003 => Table::Bands(&RIABOY_SEA, &RIABOY_LAND),
            Self::Grey => Table::Even(&GREY),
        }
    }
}

/// The colour of a slope as a share of the steepest that is told apart, 0 to 1: pale on level ground (Crameri 2018,
/// "lajolla", MIT).
pub fn slope_colour(share: f32) -> Colour {
    between(&LAJOLLA, 1.0 - share)
}

/// The colour of the compass direction in which ground falls, as a share of the circle clockwise from north, 0 to 1: the
/// same at both ends (Crameri 2018, "romaO", MIT).
pub fn aspect_colour(share: f32) -> Colour {
    between(&ROMA_O, share)
}

/// [`slope_colour`] as [`Ramp::texels`].
pub(crate) fn slope_texels() -> Vec<Colour> {
    sides(|upper, share| slope_colour((share + f32::from(u8::from(upper))) * 0.5))
}

/// [`aspect_colour`] as [`Ramp::texels`].
pub(crate) fn aspect_texels() -> Vec<Colour> {
    sides(|upper, share| aspect_colour((share + f32::from(u8::from(upper))) * 0.5))
}

fn sides(side: impl Fn(bool, f32) -> Colour) -> Vec<Colour> {
    let last = (HALF - 1) as f32;
    [false, true]
        .into_iter()
        .flat_map(|upper| (0..HALF).map(move |i| (upper, i as f32 / last)))
        .map(|(upper, share)| side(upper, share))
        .collect()
}

/// Linear between the evenly spaced colours.
fn between(colours: &[Colour], share: f32) -> Colour {
    let place = share.clamp(0.0, 1.0) * colours.len().saturating_sub(1) as f32;
    let (first, part) = (place as usize, place.fract());
    let low = colours.get(first).copied().unwrap_or_default();
    let high = colours.get(first + 1).copied().unwrap_or(low);
    std::array::from_fn(|c| (f32::from(low[c]) + (f32::from(high[c]) - f32::from(low[c])) * part).round() as u8)
}

/// "viridis" of matplotlib (CC0).
const VIRIDIS: [Colour; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];
/// "cividis" of matplotlib (CC0).
const CIVIDIS: [Colour; 17] = [
    [0, 34, 78],
    [0, 46, 106],
    [26, 56, 111],
    [50, 67, 109],
    [67, 78, 108],
    [83, 90, 109],
    [97, 101, 111],
    [111, 112, 115],
    [125, 124, 120],
    [140, 136, 120],
    [155, 148, 118],
    [171, 160, 114],
    [188, 174, 108],
    [205, 187, 99],
    [222, 201, 88],
    [240, 216, 70],
    [254, 232, 56],
];
/// "batlow" of the Scientific colour maps 8 (MIT, Fabio Crameri, doi 10.5281/zenodo.1243862), as the three below.
const BATLOW: [Colour; 17] = [
    [1, 25, 89],
    [13, 49, 93],
    [17, 67, 96],
    [23, 82, 98],
    [34, 96, 97],
    [53, 106, 89],
    [77, 115, 77],
    [103, 123, 62],
    [130, 130, 49],
    [161, 138, 43],
    [192, 144, 54],
    [221, 149, 77],
    [242, 157, 109],
    [252, 169, 147],
    [253, 180, 182],
    [252, 192, 216],
    [250, 204, 250],
];
/// "oleron", below sea level.
const OLERON_SEA: [Colour; 9] = [
    [26, 38, 89],
    [49, 61, 112],
    [74, 87, 138],
    [101, 114, 165],
    [130, 142, 193],
    [159, 172, 222],
    [186, 199, 243],
    [208, 221, 250],
    [230, 242, 255],
];
/// "oleron", above it.
const OLERON_LAND: [Colour; 9] = [
    [26, 76, 0],
    [64, 87, 0],
    [99, 100, 10],
    [135, 121, 44],
    [170, 144, 80],
    [206, 172, 117],
    [237, 201, 157],
    [248, 228, 195],
    [253, 253, 230],
];
/// "lajolla".
const LAJOLLA: [Colour; 17] = [
    [25, 25, 0],
    [39, 30, 8],
    [55, 36, 17],
    [77, 43, 28],
    [103, 52, 42],
    [133, 62, 57],
    [166, 70, 68],
    [197, 79, 74],
    [217, 96, 78],
    [225, 117, 80],
    [229, 136, 81],
    [233, 155, 82],
    [237, 174, 84],
    [241, 194, 90],
    [247, 218, 116],
    [252, 240, 162],
    [255, 254, 203],
];
/// "romaO".
const ROMA_O: [Colour; 19] = [
    [115, 57, 87],
    [125, 57, 69],
    [135, 64, 55],
    [148, 80, 46],
    [162, 102, 44],
    [178, 131, 53],
    [195, 163, 75],
    [209, 194, 110],
    [214, 216, 147],
    [203, 225, 179],
    [180, 222, 198],
    [148, 208, 206],
    [116, 187, 205],
    [92, 162, 198],
    [79, 134, 184],
    [81, 107, 164],
    [92, 83, 139],
    [104, 66, 112],
    [114, 57, 89],
];

const ATLAS_SEA: [Colour; 6] =
    [[38, 84, 140], [66, 121, 176], [104, 157, 204], [142, 190, 224], [181, 217, 239], [216, 237, 249]];

const ATLAS_LAND: [Colour; 9] = [
    [104, 158, 97],
    [154, 187, 115],
    [203, 213, 142],
    [236, 226, 164],
    [224, 194, 131],
    [201, 157, 97],
    [171, 121, 75],
    [187, 160, 142],
    [250, 250, 250],
];

const RIABOY_SEA: [(f32, Colour); 2] = [(0.65, [16, 42, 112]), (1.0, [48, 110, 184])];

const RIABOY_LAND: [(f32, Colour); 5] = [
    (0.06, [222, 200, 140]),
    (0.32, [110, 160, 62]),
    (0.58, [44, 96, 46]),
    (0.80, [122, 112, 104]),
    (1.0, [246, 248, 252]),
];

/// Even in lightness (L* of CIELAB), from 10 to 98.
const GREY: [Colour; 9] = [
    [27, 27, 27],
    [50, 50, 50],
    [75, 75, 75],
    [101, 101, 101],
    [129, 129, 129],
    [158, 158, 158],
    [188, 188, 188],
    [218, 218, 218],
    [249, 249, 249],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// L* of CIELAB.
    fn lightness(colour: Colour) -> f64 {
        let linear = colour.map(|channel| {
            let c = f64::from(channel) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    /// What is even to the eye makes no edges where the ground has none, and reads in grey, too.
    #[test]
    fn the_even_ramps_are_even() {
        for ramp in [Ramp::Batlow, Ramp::Viridis, Ramp::Cividis, Ramp::Grey] {
            let steps: Vec<f64> = (0..=16).map(|i| lightness(ramp.colour(i as f32 / 16.0))).collect();
            let mean = (steps[16] - steps[0]) / 16.0;
            assert!(mean > 3.0, "{}: {steps:?}", ramp.name());
            let even = |pair: &[f64]| (0.4..1.8).contains(&((pair[1] - pair[0]) / mean));
            assert!(steps.windows(2).all(even), "{}: {steps:?}", ramp.name());
        }
        for side in [0.0f32, 0.5] {
            let steps: Vec<f64> = (0..8).map(|i| lightness(Ramp::Oleron.colour(side + i as f32 / 16.0))).collect();
            assert!(steps.windows(2).all(|pair| pair[1] > pair[0] + 3.0), "{steps:?}");
        }
    }

    #[test]
    fn marine_ramps_break_in_the_middle_and_the_others_do_not() {
        let jump = |ramp: Ramp| {
            let (below, above) = (ramp.colour(0.5 - 1e-6), ramp.colour(0.5));
            below.iter().zip(above).map(|(a, b)| a.abs_diff(b)).max().unwrap()
        };
        for ramp in Ramp::ALL {
            assert_eq!(jump(ramp) > 40, ramp.is_marine(), "{}", ramp.name());
            assert_eq!(ramp.texels().len(), 2 * HALF);
            assert_eq!((ramp.texels()[0], ramp.texels()[511]), (ramp.colour(0.0), ramp.colour(1.0)));
        }
        let [red, green, blue] = Ramp::Oleron.colour(0.3);
        assert!(blue > red && blue > green, "the sea is blue");
        assert_eq!(Ramp::Riaboy2003.colour(0.501), [222, 200, 140], "a beach");
        assert_eq!(Ramp::Riaboy2003.colour(1.0), [246, 248, 252], "snow");
    }

    #[test]
    fn a_circle_of_directions_closes() {
        let (first, last) = (aspect_colour(0.0), aspect_colour(1.0));
        assert!(first.iter().zip(last).all(|(a, b)| a.abs_diff(b) <= 3), "{first:?} {last:?}");
        assert!(lightness(slope_colour(0.0)) > lightness(slope_colour(1.0)) + 60.0);
    }
}
