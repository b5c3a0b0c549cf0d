//! The materials' uniform: colours and thresholds. Mirrors `Materials` in `shaders/materials.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use crate::scene::{MaterialSettings, Scene};

use super::super::frame::without_subnormals;
use super::super::ground::Ground;

/// Mirror of `Materials`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct MaterialsUniform {
    /// Linear light at a tint of −1, and how much the height of the relief brightens it.
    pub(crate) dark: [[f32; 4]; 6],
    /// Linear light at a tint of 1, and how much broad variation shifts the tint.
    pub(crate) light: [[f32; 4]; 6],
    /// Snow line, tree line, sand line, sea level; world units over the floor.
    pub(crate) levels: [f32; 4],
    /// Slopes of scree, rock and snow in radians, and half the width of their transitions.
    pub(crate) slopes: [f32; 4],
    /// Repeats per world unit of the fine, middle and broad textures, and half the width of levels' transitions.
    pub(crate) repeats: [f32; 4],
    /// Strength of the relief, and how much strata show; then padding.
    pub(crate) relief: [f32; 4],
}

/// How much farther the middle and the broad texture repeat than the fine one.
const COARSER: [f64; 2] = [7.3, 53.0];
/// How much strata show in a moist and in a dry land.
const STRATA: [f32; 2] = [0.15, 1.0];
/// Half the usual width of a slope's transition, radians, and of a level's, as a share of the map's height.
const SLOPE_BLEND: f32 = 0.075;
const LEVEL_BLEND: f32 = 0.03;

/// A material's look: sRGB at both ends of its tint in a moist and in a dry land, contrast, and broad shift.
struct Look {
    moist: [Vec3; 2],
    dry: [Vec3; 2],
    contrast: f32,
    shift: f32,
}

const fn rgb(r: f32, g: f32, b: f32) -> Vec3 {
    Vec3::new(r, g, b)
}

/// In the order of [`crate::scene::Material`].
const LOOKS: [Look; 6] = [
    // Grass: from dark woods to dry meadow.
    Look {
        moist: [rgb(40.0, 50.0, 32.0), rgb(124.0, 119.0, 78.0)],
        dry: [rgb(112.0, 96.0, 68.0), rgb(196.0, 160.0, 116.0)],
        contrast: 0.5,
        shift: 0.9,
    },
    // Rock.
    Look {
        moist: [rgb(96.0, 92.0, 87.0), rgb(170.0, 164.0, 154.0)],
        dry: [rgb(126.0, 74.0, 52.0), rgb(214.0, 168.0, 128.0)],
        contrast: 0.62,
        shift: 0.5,
    },
    // Scree.
    Look {
        moist: [rgb(98.0, 92.0, 83.0), rgb(158.0, 150.0, 136.0)],
        dry: [rgb(142.0, 98.0, 72.0), rgb(200.0, 158.0, 120.0)],
        contrast: 0.55,
        shift: 0.6,
    },
    // Snow.
    Look {
        moist: [rgb(208.0, 219.0, 234.0), rgb(248.0, 248.0, 247.0)],
        dry: [rgb(208.0, 219.0, 234.0), rgb(248.0, 248.0, 247.0)],
        contrast: 0.10,
        shift: 0.3,
    },
    // Sand.
    Look {
        moist: [rgb(176.0, 158.0, 124.0), rgb(216.0, 200.0, 164.0)],
        dry: [rgb(196.0, 158.0, 112.0), rgb(228.0, 196.0, 150.0)],
        contrast: 0.22,
        shift: 0.5,
    },
    // Sea bed.
    Look {
        moist: [rgb(56.0, 66.0, 58.0), rgb(132.0, 128.0, 104.0)],
        dry: [rgb(66.0, 72.0, 62.0), rgb(148.0, 136.0, 108.0)],
        contrast: 0.35,
        shift: 0.6,
    },
];

impl MaterialsUniform {
    /// What `scene` asks for over `ground` in a box of the size `extent`; `None` where its levels are metres that the map
    /// does not know.
    pub(crate) fn new(scene: &Scene, ground: &Ground, extent: DVec3) -> Option<Self> {
        let field = ground.terrain().base();
        let range = field.metric_range();
        let settings = &scene.materials.for_map(range);
        let levels = settings.level_shares(range)?.map(|share| share * extent.y as f32);
        let cells = f64::from(field.cells()[0]) / extent.x;
        let fine = cells / f64::from(settings.scale);
        let radians = [settings.scree_slope, settings.rock_slope, settings.snow_slope].map(f32::to_radians);
        // A transition without any width would divide by 0.
        let softness = settings.softness.max(1e-3);
        let look = |index: usize| colours(&LOOKS[index], settings);
        Some(without_subnormals(Self {
            dark: std::array::from_fn(|index| look(index).0),
            light: std::array::from_fn(|index| look(index).1),
            levels,
            slopes: [radians[0], radians[1], radians[2], SLOPE_BLEND * softness],
            repeats: [
                fine as f32,
                (fine / COARSER[0]) as f32,
                (fine / COARSER[1]) as f32,
                (LEVEL_BLEND * softness * extent.y as f32).max(1e-9),
            ],
            relief: [settings.relief, STRATA[0] + (STRATA[1] - STRATA[0]) * settings.aridity, 0.0, 0.0],
        }))
    }
}

/// Both ends of a material's tint in linear light, with contrast and shift behind them.
fn colours(look: &Look, settings: &MaterialSettings) -> ([f32; 4], [f32; 4]) {
    let linear = |end: usize| {
        let srgb = look.moist[end].lerp(look.dry[end], settings.aridity) / 255.0;
        srgb.to_array().map(|c| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) })
    };
    let with = |[r, g, b]: [f32; 3], last: f32| [r, g, b, last];
    (with(linear(0), look.contrast), with(linear(1), look.shift))
}
