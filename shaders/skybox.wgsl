// The skybox: the same cube around the eye, widened and flattened. Drawn last, at the depth of infinity, so that only
// pixels that nothing covers are shaded.

#import relief::frame::{frame, cube_corner}

@group(1) @binding(0) var sky: texture_cube<f32>;
@group(1) @binding(1) var sky_sampler: sampler;

struct Varyings {
    // Compared for equality with the cleared depth.
    @invariant @builtin(position) position: vec4f,
    // Direction on the unflattened cube, which is what the cube map was made for.
    @location(0) direction: vec3f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = 2.0 * cube_corner(index) - 1.0;
    let widened = corner * vec3f(1.0, 1.0 / frame.flattening, 1.0);
    let clip = frame.clip_from_world * vec4f(widened, 0.0);
    return Varyings(vec4f(clip.xy, 0.0, clip.w), corner);
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
    return vec4f(textureSampleLevel(sky, sky_sampler, in.direction, 0.0).rgb, 1.0);
}
