// The skybox: the same cube around the eye, widened and flattened. Drawn last, at the depth of infinity, so that only
// pixels that nothing covers are shaded.

#import relief::frame::{frame, cube_corner}
#ifdef FOG
#import relief::frame::pixel_ray
#import relief::air
#endif

// The six faces of the cube map: +x, −x, +y, −y, +z, −z. Not a cube texture: to filter across the edges of one, a
// software rasteriser looks up each corner's face anew.
@group(1) @binding(0) var sky: texture_2d_array<f32>;
@group(1) @binding(1) var sky_sampler: sampler;

struct Varyings {
    // Compared for equality with the cleared depth.
    @invariant @builtin(position) position: vec4f,
    // Position on the unflattened cube, −1 to 1, which is what the cube map was made for.
    @location(0) direction: vec3f,
    // The face that begins with this corner: its layer, and how its texture runs over the cube.
    @location(1) @interpolate(flat) face: i32,
    @location(2) @interpolate(flat) across: vec3f,
    @location(3) @interpolate(flat) down: vec3f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = 2.0 * cube_corner(index) - 1.0;
    let widened = corner * vec3f(1.0, 1.0 / frame.flattening, 1.0);
    let clip = frame.clip_from_world * vec4f(widened, 0.0);
    var out = Varyings(vec4f(clip.xy, 0.0, clip.w), corner, 5, vec3f(-1.0, 0.0, 0.0), vec3f(0.0, -1.0, 0.0));
    switch index {
        case 3u: {
            out.face = 0;
            out.across = vec3f(0.0, 0.0, -1.0);
        }
        case 4u: {
            out.face = 1;
            out.across = vec3f(0.0, 0.0, 1.0);
        }
        case 6u: {
            out.face = 2;
            out.across = vec3f(1.0, 0.0, 0.0);
            out.down = vec3f(0.0, 0.0, 1.0);
        }
        case 1u: {
            out.face = 3;
            out.across = vec3f(1.0, 0.0, 0.0);
            out.down = vec3f(0.0, 0.0, -1.0);
        }
        case 5u: {
            out.face = 4;
            out.across = vec3f(1.0, 0.0, 0.0);
        }
        default: {}
    }
    // The outer texels' centres lie on the edges, where the generated faces share them. Images from files are stretched
    // by half a texel for it.
    let inner = 1.0 - 1.0 / vec2f(textureDimensions(sky));
    out.across *= 0.5 * inner.x;
    out.down *= 0.5 * inner.y;
    return out;
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
    let uv = 0.5 + vec2f(dot(in.direction, in.across), dot(in.direction, in.down));
    let root = textureSampleLevel(sky, sky_sampler, uv, in.face, 0.0).rgb;
#ifdef FOG
    let fog = air::veil_of_sky(pixel_ray(in.position.xy).direction);
    return vec4f(air::dithered(root * root * fog.passes + fog.light, in.position.xy), 1.0);
#else
    return vec4f(root * root, 1.0);
#endif
}
