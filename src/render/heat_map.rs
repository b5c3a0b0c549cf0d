//! The colours of the heat map: one list for the shader, the legend and the tests.

use std::fmt::Write;

/// Colour stops from 0 to 1 as sRGB bytes, evenly spaced: black, violet, orange, pale yellow. Lightness grows steadily,
/// so that the map reads in grey and to colour-blind eyes.
const STOPS: [[u8; 3]; 6] = [[0, 0, 4], [66, 10, 104], [147, 38, 103], [221, 81, 58], [252, 165, 10], [252, 255, 164]];

/// Powers of ten, in cells, that the ends of the heat map stand for in the error view.
pub const ERROR_DECADES: [i32; 2] = [-4, 1];

/// Error view: the ground is there, but the technique shows the sky.
pub const SEE_THROUGH: [u8; 3] = [86, 180, 233];

/// Error view: the technique shows ground where the sky is.
pub const COVERS_SKY: [u8; 3] = [0, 158, 115];

/// Error view: sky, and the technique shows it.
pub const SKY_BOTH: [u8; 3] = [30, 33, 40];

/// Colour of an error of so many `cells` in the error view, as sRGB bytes.
pub fn error_colour(cells: f64) -> [u8; 3] {
    let [low, high] = ERROR_DECADES.map(f64::from);
    heat_map_colour(((cells.max(f64::MIN_POSITIVE).log10() - low) / (high - low)) as f32)
}

/// Linear light of an sRGB byte.
fn linear(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// What an error view is cleared to.
pub(super) fn sky_both() -> wgpu::Color {
    let [r, g, b] = SKY_BOTH.map(linear);
    wgpu::Color { r, g, b, a: 1.0 }
}

/// Colour of `share` (clamped to 0..1) as sRGB bytes.
pub fn heat_map_colour(share: f32) -> [u8; 3] {
    let scaled = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32 };
    let below = (scaled as usize).min(STOPS.len() - 2);
    let fraction = scaled - below as f32;
    std::array::from_fn(|channel| {
        let (a, b) = (f32::from(STOPS[below][channel]), f32::from(STOPS[below + 1][channel]));
        (a + (b - a) * fraction).round() as u8
    })
}

/// The module `relief::heat_map`: the same functions and colours in WGSL, in linear light.
pub(super) fn wgsl() -> String {
    let count = STOPS.len();
    let mut text = String::from("#define_import_path relief::heat_map\n#import relief::srgb::from_srgb\n\n");
    let list: Vec<_> = STOPS.iter().map(|[r, g, b]| format!("vec3f({r}.0, {g}.0, {b}.0)")).collect();
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "fn heat_map(share: f32) -> vec3f {{
    var stops = array<vec3f, {count}>({});
    let scaled = clamp(share, 0.0, 1.0) * {}.0;
    let below = min(u32(scaled), {}u);
    return from_srgb(mix(stops[below], stops[below + 1u], scaled - f32(below)) / 255.0);
}}
",
        list.join(", "),
        count - 1,
        count - 2,
    );
    let [low, high] = ERROR_DECADES.map(f64::from);
    let colour = |bytes: [u8; 3]| {
        let [r, g, b] = bytes.map(linear);
        format!("vec3f({r:?}, {g:?}, {b:?})")
    };
    let _ = write!(
        text,
        "
const SEE_THROUGH = {};
const COVERS_SKY = {};

// Colour of an error of so many cells.
fn error_colour(cells: f32) -> vec3f {{
    return heat_map((log2(max(cells, 1e-30)) * {:?} - {low:?}) / {:?});
}}
",
        colour(SEE_THROUGH),
        colour(COVERS_SKY),
        std::f64::consts::LOG10_2,
        high - low,
    );
    text
}
