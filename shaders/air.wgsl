// The air between the eye and what it sees: aerial perspective, height fog, shadows of clouds (`render/air.rs`).
#define_import_path relief::air

#import relief::air_constants::{HORIZON, FORWARD}

struct Air {
    // Kilometres per world unit along the ground and up; height of the eye over the floor, in kilometres.
    kilometres: vec4f,
    // Extinction at the floor per kilometre, by colour; w: one over the scale height in kilometres.
    molecules: vec4f,
    haze: vec4f,
    // Extinction per kilometre up to the base height; one over the scale height; the base height over the floor.
    fog: vec4f,
    // Light of the fog from everywhere.
    fog_light: vec4f,
    // Towards the sun, world space.
    sun: vec4f,
    // Light of the sun; w: how much of it fog scatters forward.
    sun_light: vec4f,
    // Light of the sky from above.
    sky_light: vec4f,
    // Mean of the horizon's light.
    mean: vec4f,
    // Corner of the map of cloud shadows in the world, seen along the sun's rays; one over its sides.
    shadow_place: vec4f,
    // Way along x and z for a unit of height towards the sun; the height within which a layer's shadow ends; strength.
    shadow_shear: vec4f,
    // World heights above which the lowest layer, the two, three, four lowest cast no shadow.
    shadow_levels: vec4f,
    // Light of the sky at the horizon, by direction.
    horizon: array<vec4f, 128>,
}

@group(1) @binding(44) var<storage, read> air: Air;

// Least height that counts, kilometres.
const TINY: f32 = 1e-12;

// Longest way, kilometres.
const FAR: f32 = 1e6;

// Light of the sky at the horizon in a direction; looking up or down, that from all around.
fn horizon_light(direction: vec3f) -> vec3f {
    let along = direction.x / max(abs(direction.x) + abs(direction.z), 1e-30);
    let turn = select(1.0 - along, 3.0 + along, direction.z < 0.0) * (0.25 * f32(HORIZON));
    let index = min(u32(turn), HORIZON - 1u);
    let next = select(index + 1u, 0u, index == HORIZON - 1u);
    let light = mix(air.horizon[index].rgb, air.horizon[next].rgb, turn - f32(index));
    return mix(air.mean.rgb, light, length(direction.xz) / length(direction));
}

#ifdef FOG
// Light that fog scatters to the eye: half that of the horizon, half from all around, and the sun's, mostly forward (Henyey,
// Greenstein 1941, 1 towards the sun).
fn fog_light(direction: vec3f) -> vec3f {
    let to_sun = dot(direction, air.sun.xyz) / length(direction);
    let spread = (1.0 - FORWARD) * (1.0 - FORWARD) / (1.0 + FORWARD * FORWARD - 2.0 * FORWARD * to_sun);
    return 0.5 * (horizon_light(direction) + air.fog_light.rgb) + air.sun_light.w * spread * sqrt(spread) * air.sun_light.rgb;
}
#endif

// Mean over the heights from `low` to `high` of a density that is 1 up to `base` and falls by e with each scale height
// above: the integral of the exponential along a straight way, over the way's length (Preetham, Shirley, Smits 1999, section
// 5). All exponents are negative, and a level way is no special case.
fn mean_density(low: f32, high: f32, base: f32, per_scale: f32) -> f32 {
    let below = clamp((base - low) / max(high - low, TINY), 0.0, 1.0);
    let first = max(low, base);
    let x = max(high - first, 0.0) * per_scale;
    let fallen = select((1.0 - exp(-x)) / max(x, TINY), 1.0 - x * (0.5 - x / 6.0), x < 0.03);
    return mix(exp(-(first - base) * per_scale) * fallen, 1.0, below);
}

// Light from behind is let through and joined by other.
struct Veil {
    passes: vec3f,
    light: vec3f,
}

// The veil of optical depths with lights of their own, mixed alike along the way.
fn veil_of(aerial: vec3f, fogged: f32, direction: vec3f) -> Veil {
    let all = aerial + fogged;
    let passes = exp(-all);
    // (1 − e⁻ᵗ) / t
    let share = select((1.0 - passes) / max(all, vec3f(TINY)), 1.0 - all * (0.5 - all / 6.0), all < vec3f(0.03));
    var light = vec3f(0.0);
#ifdef AERIAL
    light += aerial * horizon_light(direction);
#endif
#ifdef FOG
    light += fogged * fog_light(direction);
#endif
    return Veil(passes, share * light);
}

// A direction of a view depth of 1 in kilometres.
fn in_kilometres(direction: vec3f) -> vec3f {
    return direction * air.kilometres.xyx;
}

// The veil before what lies at a view depth and a world height, in a direction of a view depth of 1.
fn veil(direction: vec3f, depth: f32, height: f32) -> Veil {
    return veil_between(direction, depth, air.kilometres.z, height * air.kilometres.y);
}

// The veil along `depth` times a direction, between two heights in kilometres.
fn veil_between(direction: vec3f, depth: f32, begin: f32, end: f32) -> Veil {
    let way = min(depth * length(in_kilometres(direction)), FAR);
    let low = min(begin, end);
    let high = max(begin, end);
    var aerial = vec3f(0.0);
    var fogged = 0.0;
#ifdef AERIAL
    aerial = way * (air.molecules.rgb * mean_density(low, high, 0.0, air.molecules.w)
        + air.haze.rgb * mean_density(low, high, 0.0, air.haze.w));
#endif
#ifdef FOG
    fogged = way * air.fog.x * mean_density(low, high, air.fog.z, air.fog.y);
#endif
    return veil_of(aerial, fogged, direction);
}

#ifdef FOG
// The veil of fog before the sky. Beside the map it lies on a plain as low as the map's lowest place.
fn veil_of_sky(direction: vec3f) -> Veil {
    return veil_of_sky_over(direction, air.kilometres.z);
}

// The same for an eye so many kilometres over the floor.
fn veil_of_sky_over(direction: vec3f, eye: f32) -> Veil {
    let way = in_kilometres(direction);
    let rise = way.y / length(way);
    let base = air.fog.z;
    // Upwards: what of the air column lies above the eye. Downwards: the way to the plain.
    let column = max(base - eye, 0.0) + exp(-max(eye - base, 0.0) * air.fog.y) / air.fog.y;
    let to_plain = max(eye, 0.0) * mean_density(0.0, max(eye, 0.0), base, air.fog.y);
    let fogged = min(select(column, to_plain, rise < 0.0) / max(abs(rise), 1e-6), FAR) * air.fog.x;
    let passes = exp(-fogged);
    // Fog that begins far below the eye is veiled by the air before it, up to what the sky shows there, whatever that is: a
    // plain of fog ends at the horizon without an edge.
    let far = max(eye - base, 0.0) / max(abs(rise), 1e-6);
    let clear = exp(-min(far, FAR) * (air.molecules.rgb + air.haze.rgb));
    let covered = (1.0 - passes) * clear;
    return Veil(1.0 - covered, covered * fog_light(direction));
}
#endif

// Half a step of eight bits up or down, by the pixel (Jimenez 2014): without it a veil shows its steps as bands. As square
// roots of light lie, so do the bytes on the screen.
fn dithered(color: vec3f, pixel: vec2f) -> vec3f {
    let noise = fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715)))) - 0.5;
    let root = max(sqrt(max(color, vec3f(0.0))) + noise / 255.0, vec3f(0.0));
    return root * root;
}

// What of a colour gets to the eye, and what joins it.
fn through(color: vec3f, direction: vec3f, depth: f32, height: f32, pixel: vec2f) -> vec3f {
    let before = veil(direction, depth, height);
    return dithered(color * before.passes + before.light, pixel);
}

#ifdef CLOUD_SHADOWS
// What clouds let through of the sun's light, by the place that a ray to the sun has at the floor: of all layers, and without
// the lowest ones.
@group(1) @binding(45) var cloud_shadow: texture_2d<f32>;
@group(1) @binding(46) var cloud_sampler: sampler;

// Share of the sun's light that clouds let through to a place, world space.
fn cloud_light(place: vec3f) -> f32 {
    let at = (place.xz - place.y * air.shadow_shear.xy - air.shadow_place.xy) * air.shadow_place.zw;
    let light = textureSampleLevel(cloud_shadow, cloud_sampler, at, 0.0);
    let above = clamp((place.y - air.shadow_levels) / air.shadow_shear.z + 0.5, vec4f(0.0), vec4f(1.0));
    return mix(mix(mix(mix(light.x, light.y, above.x), light.z, above.y), light.w, above.z), 1.0, above.w);
}
#endif
