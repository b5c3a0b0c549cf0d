// How thick the clouds of a layer are at a place (`render/clouds.rs`).
#define_import_path relief::cloud_layers

#import relief::cloud_constants::{CLOUD_LAYERS, SIDE, SOFTNESS}

struct CloudLayer {
    // World height; half of what a layer is thick, world units; optical thickness where it is thickest; share left free.
    shape: vec4f,
    // Tiles of the pattern by place: rows of two matrices, and their offsets.
    first: vec4f,
    second: vec4f,
    offsets: vec4f,
}

struct Clouds {
    // From the lowest to the highest.
    layers: array<CloudLayer, 5>,
    // How many there are; the eye's world height; where their map of shadows begins.
    count: vec4f,
    // Sides of the map of shadows; way along x and z for a unit of height towards the sun.
    shadow: vec4f,
    // Their numbers from the farthest to the nearest to the eye.
    order: array<vec4f, 2>,
    // Sine of the sun's height over the horizon, at least; strength of shadows; whether light is exposed.
    sun: vec4f,
}

@group(1) @binding(47) var<storage, read> clouds: Clouds;
// Density, 0 to 1, every share of it on as large an area; how it differs ahead and behind along u and v.
@group(1) @binding(48) var pattern: texture_2d<f32>;
@group(1) @binding(49) var pattern_sampler: sampler;

struct Cloud {
    // Optical depth, seen from above.
    depth: f32,
    // How full it is, 0 to 1.
    fullness: f32,
    // Towards where it grows thicker, world space along x and z; about a unit vector at a steep edge.
    slope: vec2f,
}

// The clouds of a layer at a place of its plane, blurred over `footprint` world units. Half of the pattern is looked up so far
// aside as they are full: by −`lean` where they are, by `lean` where there are none; 0 sees them as flat as they are.
fn cloud_at(layer: CloudLayer, place: vec2f, footprint: f32, lean: vec2f) -> Cloud {
    let tiles = footprint * length(layer.first.xy);
    // Half of the way between two levels belongs to one of them alone: there a software rasteriser looks up one, not two.
    let exact = max(log2(tiles * SIDE), 0.0);
    let level = floor(exact) + clamp(2.0 * fract(exact) - 0.5, 0.0, 1.0);
    let first = vec2f(dot(layer.first.xy, place), dot(layer.first.zw, place)) + layer.offsets.xy;
    let a = textureSampleLevel(pattern, pattern_sampler, first, level).rgb;
    let ahead = place + (1.0 - 2.0 * a.r) * lean;
    let second = vec2f(dot(layer.second.xy, ahead), dot(layer.second.zw, ahead)) + layer.offsets.zw;
    let b = textureSampleLevel(pattern, pattern_sampler, second, level).rgb;
    // Of two even distributions the mean is that of a triangle; this makes it even again, so that the share that a
    // threshold leaves free is the share of the sky.
    let mean = 0.5 * (a.r + b.r);
    let other = 1.0 - mean;
    let density = select(1.0 - 2.0 * other * other, 2.0 * mean * mean, mean < 0.5);
    // What is blurred comes close to its mean: the edge is as soft as that.
    let soft = mix(SOFTNESS, 0.5, smoothstep(3.0, 8.0, level));
    let above = max(density - layer.shape.w + 0.5 * soft, 0.0);
    let fullness = min(above / (1.0 - layer.shape.w + 0.5 * soft), 1.0);
    let thick = fullness * min(above / soft, 1.0);
    let turned = (a.gb - 0.5) * mat2x2f(normalize(layer.first.xz), normalize(layer.first.yw))
        + (b.gb - 0.5) * mat2x2f(normalize(layer.second.xz), normalize(layer.second.yw));
    return Cloud(layer.shape.z * thick, fullness, 2.0 * turned);
}

// How a cloud scatters forward, 1 towards the sun.
fn silver(to_sun: f32) -> f32 {
    let spread = 0.04 / (1.04 - to_sun);
    return spread * sqrt(spread) * 8.0;
}

// What lights clouds.
struct CloudLights {
    // Towards the sun; above 0 where light is exposed.
    sun: vec4f,
    sun_light: vec3f,
    sky_light: vec3f,
}

// Light of a cloud, seen in a direction (unit length), from below or above.
fn cloud_colour(cloud: Cloud, direction: vec3f, lights: CloudLights) -> vec3f {
    let sun = lights.sun.xyz;
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
        // Tops that are turned to the sun, and shade behind them; thin edges let the light of the sun behind them through.
        let top = 0.30 + 0.45 * cloud.fullness;
        lit = top * (0.45 + 0.55 * sun.y) + (0.9 * facing) * (0.4 + 0.6 * solid);
        lit += min(silver(to_sun), 1.0) * 0.6 * exp(-1.5 * cloud.depth);
        sky = 0.34 + 0.16 * cloud.fullness;
    }
    let light = lights.sun_light * max(lit, 0.10) + lights.sky_light * sky;
    return select(light, 1.0 - exp(-1.6 * light), lights.sun.w > 0.0);
}
