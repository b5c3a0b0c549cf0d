//! The colours of the heat map: one list for the shader, the legend and the tests.

use std::fmt::Write;

/// Colour stops from 0 to 1 as sRGB bytes, evenly spaced: black, violet, orange, pale yellow. Lightness grows steadily,
/// so that the map reads in grey and to colour-blind eyes.
const STOPS: [[u8; 3]; 6] = [[0, 0, 4], [66, 10, 104], [147, 38, 103], [221, 81, 58], [252, 165, 10], [252, 255, 164]];

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

/// The module `relief::heat_map`: the same function in WGSL, in linear light.
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
    text
}
