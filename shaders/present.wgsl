// Copies the kept picture to the window, texel by texel.

@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle that covers the screen.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let last = vec2i(textureDimensions(picture)) - 1;
    return vec4f(textureLoad(picture, min(vec2i(position.xy), last), 0).rgb, 1.0);
}
