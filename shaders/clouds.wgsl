// The clouds: flat layers between the eye and what it sees, or the sky, blended over the picture, an instance for each from the
// farthest to the nearest. Which of them are before the ground the picture's depth tells.
//
// All that a layer's fragments need comes as varyings: a software rasteriser reads buffers lane by lane.

#import relief::constants::NEAR
#import relief::frame::{frame, pixel_ray}
#import relief::air
#import relief::air::air as constants
#import relief::cloud_constants::CLOUD_LAYERS
#import relief::cloud_layers::{clouds, cloud_at, Cloud, CloudLayer}

@group(1) @binding(50) var depths: texture_depth_2d;

struct Varyings {
    @builtin(position) position: vec4f,
    // The ray; w: view depth where it begins, and the width of a pixel at view depth 1.
    @location(0) origin: vec4f,
    @location(1) direction: vec4f,
    @location(2) @interpolate(flat) shape: vec4f,
    @location(3) @interpolate(flat) first: vec4f,
    @location(4) @interpolate(flat) second: vec4f,
    @location(5) @interpolate(flat) offsets: vec4f,
    // Towards the sun; whether light is exposed.
    @location(6) @interpolate(flat) sun: vec4f,
    // Light of the sun; how much of the layer shows to an eye so near to it.
    @location(7) @interpolate(flat) sun_light: vec4f,
    @location(8) @interpolate(flat) sky_light: vec4f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varyings {
    // One triangle over all.
    let corner = vec2f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0);
    let pixel = vec2f(frame.centre_x, frame.centre_y) * (1.0 + corner * vec2f(1.0, -1.0));
    let ray = pixel_ray(pixel);
    let number = u32(clouds.order[min(instance >> 2u, 1u)][instance & 3u]);
    let layer = clouds.layers[min(number, CLOUD_LAYERS - 1u)];
    // Softly through a layer that the eye flies through.
    let shows = smoothstep(0.0, 2.0 * layer.shape.y, abs(layer.shape.x - clouds.count.y));
    return Varyings(
        vec4f(corner, 0.0, 1.0),
        vec4f(ray.origin, frame.ray_start),
        vec4f(ray.direction, frame.pixel_size),
        layer.shape,
        layer.first,
        layer.second,
        layer.offsets,
        vec4f(constants.sun.xyz, clouds.sun.z),
        vec4f(constants.sun_light.rgb, shows),
        constants.sky_light,
    );
}

// How a cloud scatters forward, 1 towards the sun.
fn silver(to_sun: f32) -> f32 {
    let spread = 0.04 / (1.04 - to_sun);
    return spread * sqrt(spread) * 8.0;
}

// Light of a cloud, seen in a direction (unit length), from below or above.
fn cloud_light(cloud: Cloud, direction: vec3f, sun: vec3f, sun_light: vec3f, sky_light: vec3f) -> vec3f {
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
    return sun_light * max(lit, 0.10) + sky_light * sky;
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
    let ray = in.direction.xyz;
    let along = (in.shape.x - in.origin.y) / select(ray.y, 1e-20, ray.y == 0.0);
    let depth = in.origin.w + along;
    let direction = normalize(ray);
    let steep = abs(direction.y);
    // Near the horizon layers fade: there they would be seen on edge.
    let seen = smoothstep(0.012, 0.11, steep) * in.sun_light.w;
    if depth <= 0.0 || seen <= 0.0 {
        discard;
    }
    let last = vec2i(textureDimensions(depths)) - 1;
    let written = textureLoad(depths, min(vec2i(in.position.xy), last), 0);
    let behind = select(1e30, NEAR / written, written > 0.0);
    // Softly into hills.
    let hills = smoothstep(0.0, in.shape.y, (behind - depth) * abs(ray.y));
    if hills <= 0.0 {
        discard;
    }
    let place = in.origin.xz + ray.xz * along;
    let footprint = in.direction.w * depth * exp2(-0.8 * log2(steep));
    let layer = CloudLayer(in.shape, in.first, in.second, in.offsets);
    let cloud = cloud_at(layer, place, footprint);
    if cloud.depth <= 0.0 {
        discard;
    }
    let slant = min(1.0 / steep, 3.0);
    let opacity = (1.0 - exp(-cloud.depth * slant)) * seen * hills;
    var light = cloud_light(cloud, direction, in.sun.xyz, in.sun_light.rgb, in.sky_light.rgb);
    light = select(light, 1.0 - exp(-1.6 * light), in.sun.w > 0.0);
#ifdef AIR
    let before = air::veil(ray, depth, in.shape.x);
    light = light * before.passes + before.light;
#endif
    return vec4f(air::dithered(light, in.position.xy) * opacity, opacity);
}
