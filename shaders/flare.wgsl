// A lens flare: a glow around the sun, a halo, and ghosts along the line through the picture's middle, added to the picture.
// Each is a square of two triangles.

#import relief::flare_constants::GHOSTS

struct Ghost {
    // Centre and half sides in clip space.
    place: vec4f,
    // Light; w: 0 a disc, 1 a halo, 2 a glow.
    light: vec4f,
}

struct Flare {
    ghosts: array<Ghost, 8>,
}

@group(0) @binding(0) var<storage, read> flare: Flare;

struct Varyings {
    @builtin(position) position: vec4f,
    // From the centre, −1 to 1.
    @location(0) at: vec2f,
    @location(1) @interpolate(flat) light: vec4f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let ghost = flare.ghosts[min(instance, GHOSTS - 1u)];
    // 0, 1, 2 and 2, 1, 3.
    let corner = select(index, select(index - 1u, select(1u, 3u, index == 5u), index > 3u), index > 2u);
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    return Varyings(vec4f(ghost.place.xy + at * ghost.place.zw, 0.0, 1.0), at, ghost.light);
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
    let from_centre = length(in.at);
    // Blue is bent more than red.
    let spread = from_centre * vec3f(1.0, 1.025, 1.05);
    var share: vec3f;
    if in.light.w == 0.0 {
        share = (vec3f(0.45) + 0.55 * spread * spread) * smoothstep(vec3f(1.0), vec3f(0.88), spread);
    } else if in.light.w == 1.0 {
        let ring = (spread - 0.88) / vec3f(0.055);
        share = exp(-ring * ring);
    } else {
        let fallen = max(1.0 - from_centre, 0.0);
        share = vec3f(fallen * fallen * fallen);
    }
    return vec4f(share * in.light.rgb, 0.0);
}
