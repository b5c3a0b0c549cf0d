// The light map: what light a place of the ground gets, whoever looks. Drawn when something that it depends on has
// changed, and read by the terrain pass.

#import relief::heightfield::terrain
#import relief::light::light
#import relief::sun::OCCLUSION_DIRECTIONS
#import relief::shadow::{STEEPEST, horizon, place_on_ground, sunlight}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle over all.
    return vec4f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0, 0.0, 1.0);
}

// Share of the light of an even sky that gets to a level surface: of each upright slice of the sky what stands over the
// horizon, weighted by the sine of its elevation.
#ifdef OCCLUSION
fn sky_share(cell: vec2f, within: vec2f) -> f32 {
    let place = place_on_ground(cell, within);
    var share = 0.0;
    var index = 0u;
    while index < OCCLUSION_DIRECTIONS {
        let turn = 6.2831853 * (f32(index) + 0.5) / f32(OCCLUSION_DIRECTIONS);
        index += 1u;
        let slope = min(horizon(place, vec2f(cos(turn), sin(turn)), 0.0, STEEPEST), STEEPEST);
        share += 1.0 / (1.0 + slope * slope);
    }
    return share / f32(OCCLUSION_DIRECTIONS);
}
#endif

@fragment
fn fs_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let p = position.xy * light.cells_per_texel.xy;
    let cell = clamp(floor(p), vec2f(0.0), terrain.cells - 1.0);
    var seen = vec2f(1.0);
#ifdef BAKED_SHADOWS
    seen.x = sunlight(place_on_ground(cell, p - cell), true);
#endif
#ifdef OCCLUSION
    seen.y = sky_share(cell, p - cell);
#endif
    return vec4f(seen, 0.0, 1.0);
}
