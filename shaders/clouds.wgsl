// The clouds: flat layers between the eye and what it sees, or the sky, blended over the picture. Which of them are before
// the ground the picture's depth tells.

#import relief::constants::NEAR
#import relief::frame::{frame, pixel_ray}
#import relief::air
#import relief::air::air as constants
#import relief::cloud_constants::CLOUD_LAYERS
#import relief::cloud_layers::{clouds, cloud_at, Cloud}

@group(1) @binding(50) var depths: texture_depth_2d;

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle over all.
    return vec4f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0, 0.0, 1.0);
}

// How a cloud scatters forward, 1 towards the sun.
fn silver(to_sun: f32) -> f32 {
    let spread = 0.04 / (1.04 - to_sun);
    return spread * sqrt(spread) * 8.0;
}

// Light of a cloud, seen in a direction (unit length), from below or above.
fn cloud_light(cloud: Cloud, direction: vec3f) -> vec3f {
    let sun = constants.sun.xyz;
    let to_sun = dot(direction, sun);
    let solid = 1.0 - exp(-cloud.depth);
    // The side towards the sun is where the cloud grows thinner towards it.
    let along = sun.xz / max(length(sun.xz), 1e-6);
    let level = length(sun.xz);
    let facing = -dot(cloud.slope, along) * level;
    var lit: f32;
    var sky: f32;
    if direction.y > 0.0 {
        // What comes through from above: less through the thick, much at thin edges, most around the sun.
        let through = exp(-0.55 * cloud.depth);
        lit = 0.14 + 0.44 * through + 0.5 * facing + min(silver(to_sun), 1.0) * 0.8 * exp(-1.3 * cloud.depth);
        sky = 0.60 - 0.22 * solid;
    } else {
        lit = (0.50 + 0.28 * cloud.fullness) * (0.55 + 0.45 * sun.y) + 0.7 * facing;
        sky = 0.50;
    }
    return constants.sun_light.rgb * max(lit, 0.10) + constants.sky_light.rgb * sky;
}

@fragment
fn fs_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let ray = pixel_ray(position.xy);
    let long = length(ray.direction);
    let direction = ray.direction / long;
    let last = vec2i(textureDimensions(depths)) - 1;
    let written = textureLoad(depths, min(vec2i(position.xy), last), 0);
    let behind = select(1e30, NEAR / written, written > 0.0);
    let steep = abs(direction.y);
    // Near the horizon layers fade: there they would be seen on edge.
    let seen = smoothstep(0.012, 0.11, steep);
    var color = vec3f(0.0);
    var open = 1.0;
    var index = 0u;
    while index < CLOUD_LAYERS {
        // From the nearest on: upwards the lowest first.
        let number = select(index, CLOUD_LAYERS - 1u - index, direction.y < 0.0);
        index += 1u;
        let layer = clouds.layers[number];
        let along = (layer.shape.x - ray.origin.y) / select(ray.direction.y, 1e-20, ray.direction.y == 0.0);
        let depth = frame.ray_start + along;
        if f32(number) < clouds.count.x && depth > 0.0 && depth < behind && seen > 0.0 {
            let place = ray.origin.xz + ray.direction.xz * along;
            let footprint = frame.pixel_size * depth * exp2(-0.8 * log2(steep));
            let cloud = cloud_at(layer, place, footprint);
            // Softly into hills, and softly through a layer that the eye flies through.
            let hills = smoothstep(0.0, layer.shape.y, (behind - depth) * abs(ray.direction.y));
            let eye = smoothstep(0.0, 2.0 * layer.shape.y, abs(layer.shape.x - clouds.count.y));
            let slant = min(1.0 / steep, 3.0);
            let opacity = (1.0 - exp(-cloud.depth * slant)) * seen * hills * eye;
            var light = cloud_light(cloud, direction);
            light = select(light, 1.0 - exp(-1.6 * light), clouds.sun.z > 0.0);
#ifdef AIR
            let before = air::veil(ray.direction, depth, layer.shape.x);
            light = light * before.passes + before.light;
#endif
            color += open * opacity * light;
            open *= 1.0 - opacity;
        }
    }
    return vec4f(air::dithered(color, position.xy), 1.0 - open);
}
