// The map of cloud shadows: what all layers let through of the sun's light, by the place that a ray to the sun has at the
// floor. Drawn when clouds, sun or map have changed, and read by what is lit.

#import relief::cloud_constants::{CLOUD_LAYERS, SHADOW_SIDE}
#import relief::cloud_layers::{clouds, cloud_at}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle over all.
    return vec4f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0, 0.0, 1.0);
}

@fragment
fn fs_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at_floor = clouds.count.zw + position.xy / SHADOW_SIDE * clouds.shadow.xy;
    let footprint = max(clouds.shadow.x, clouds.shadow.y) / SHADOW_SIDE;
    // Of all layers, and without the one, two and three lowest.
    var light = vec4f(1.0);
    var index = 0u;
    while index < CLOUD_LAYERS {
        let layer = clouds.layers[index];
        let cloud = cloud_at(layer, at_floor + layer.shape.x * clouds.shadow.zw, footprint, vec2f(0.0));
        let through = mix(1.0, exp(-cloud.depth / clouds.sun.x), clouds.sun.y);
        let passes = select(1.0, through, f32(index) < clouds.count.x);
        light *= select(vec4f(1.0), vec4f(passes), vec4u(0u, 1u, 2u, 3u) <= vec4u(index));
        index += 1u;
    }
    return light;
}
