// The sea: a block of water from the box's floor up to its level, less the ground. The far faces of the block are drawn, so
// that it works from inside and out, over a terrain that is drawn already: what of the water is nearer replaces it.
//
// A ray that comes in through the surface is split, exactly, in the one that is mirrored and the one that is bent; both are
// walked to the ground by the exact technique, and what they meet is shaded as the terrain is. A ray that begins under water,
// or comes in through a cut side of the block, goes straight to the ground or to the surface, where it is split likewise. Three
// legs at most: they take turns in one loop, so that the walk and the shading are compiled once.
//
// Light on its way through water is absorbed by channel (Beer and Lambert), and the water's own light comes in for it. Beyond
// the cut sides, and over a hole, the water goes on for ever.

#import relief::frame::{frame, Ray, pixel_ray, slabs}
#import relief::constants::NEAR
#import relief::heightfield::{terrain, Segment, NO_HIT, cell_corners, bilinear}
#ifdef HOLES
#import relief::heightfield::{is_ground, has_ground}
#endif
#ifdef FLAT_CONSTANTS
#import relief::heightfield::terrain_uniform
#endif
#import relief::varyings
#import relief::march::march
#ifdef SHADED
#import relief::ground
#import relief::shading
#endif
#ifdef ATMOSPHERE
#import relief::air
#endif
#ifdef WATER_CLOUDS
#import relief::air::air as air_constants
#import relief::cloud_constants::{CLOUD_LAYERS, FADED, WHOLE}
#import relief::cloud_layers::{clouds, cloud_at, cloud_colour, CloudLights}
#endif
#import relief::waves
#import relief::waves::water
#ifdef WATER_OCCLUDER
#import relief::cube_faces::{face_normal, face_colour}
#endif

#ifdef WATER_SKY
// The six faces of the sky, as the skybox has them.
@group(1) @binding(41) var sky: texture_2d_array<f32>;
@group(1) @binding(42) var sky_sampler: sampler;
#endif

// Refractive index of water.
const INDEX: f32 = 1.333;
// Light that counts for less than this is not followed.
const LEAST: f32 = 0.002;
// Rounding of where a ray comes in, as a share of its length and of the box's size.
const ROUNDING: f32 = 1e-6;
// Legs of a ray; where shadows are cast, one more towards the sun, whose glint is seen only where it ends nowhere.
const SUNWARD: u32 = 3u;
#ifdef SUNLIGHT
const LEGS: u32 = 4u;
#else
const LEGS: u32 = 3u;
#endif
// Farther than anything.
const ENDLESS: f32 = 1e30;

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> varyings::Varyings {
#ifdef FLAT_CONSTANTS
    return varyings::at(terrain_uniform.box_clip[index]);
#else
    return varyings::at(terrain.box_clip[index]);
#endif
}

struct Fragment {
    // The picture, linear light; or, for a probe, lengths in world units: from the eye to where the ray is split or ends, of the
    // leg through air, of the one through water (−1: it meets nothing, −2: there is none), and 1 for a ray that begins in water.
    @location(0) color: vec4f,
    @builtin(frag_depth) depth: f32,
}

fn level() -> f32 {
    return water.absorption_and_level.w;
}

// A way that light takes.
struct Leg {
    // World space; the direction has the length 1.
    ray: Ray,
    in_water: bool,
    // Where it is mirrored light.
    mirrored: bool,
    // What of its light gets to the eye.
    weight: vec3f,
    // How far from the eye it begins.
    way: f32,
}

// Share of light that a smooth surface mirrors (Fresnel, both polarisations), by the cosine of the angle to its normal on
// the side it comes from, and by the index of what lies behind over that in front.
fn mirrored_share(cosine: f32, index: f32) -> f32 {
    let c = clamp(cosine, 0.0, 1.0);
    let squared = index * index - 1.0 + c * c;
    if squared <= 0.0 {
        return 1.0;
    }
    let g = sqrt(squared);
    let a = (g - c) / (g + c);
    let b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    return 0.5 * a * a * (1.0 + b * b);
}

// Where a ray along `direction` meets the surface at `p`, from above or from below.
struct Split {
    mirrored: vec3f,
    through: vec3f,
    share: f32,
    // Slope of the waves there, and variance of what is not shown of them.
    slope: vec2f,
    unseen: f32,
}

fn split_at(p: vec2f, direction: vec3f, from_above: bool, width: f32) -> Split {
    var slope = vec2f(0.0);
    var unseen = 0.0;
#ifdef WATER_WAVES
    let chop = waves::chop_at(p, direction, width);
    slope = chop.slope;
    unseen = chop.unseen;
#endif
    let up = normalize(vec3f(-slope.x, 1.0, -slope.y));
    var normal = select(-up, up, from_above);
#ifdef WATER_WAVES
    // A wave that is seen from behind would be hidden by the one before it.
    let facing = dot(normal, direction);
    normal = normalize(normal - direction * max(facing + 0.02, 0.0));
#endif
    let index = select(1.0 / INDEX, INDEX, from_above);
    let cosine = -dot(normal, direction);
    var mirrored = reflect(direction, normal);
    // Nothing is mirrored into the surface itself.
    mirrored.y = select(-max(abs(mirrored.y), 1e-4), max(abs(mirrored.y), 1e-4), from_above);
    var through = direction;
    var share = mirrored_share(cosine, INDEX);
#ifdef WATER_REFRACTION
    share = mirrored_share(cosine, index);
    let bent = refract(direction, normal, 1.0 / index);
    through = select(direction, bent, share < 1.0);
    through.y = select(max(through.y, 1e-4), min(through.y, -1e-4), from_above);
#endif
    return Split(normalize(mirrored), normalize(through), share, slope, unseen);
}

// Where a leg ends.
struct End {
    // Its length; NO_HIT where it meets nothing.
    at: f32,
    // What it has met, where that is not the ground.
    is_cube: bool,
    normal: vec3f,
}

#ifdef WATER_OCCLUDER
// Where `ray` meets the occluder, if it does before `most`.
fn meet_cube(ray: Ray, most: f32) -> End {
    let origin = vec4f(ray.origin, 1.0);
    let local = Ray(
        vec3f(dot(water.cube[0], origin), dot(water.cube[1], origin), dot(water.cube[2], origin)),
        vec3f(dot(water.cube[0].xyz, ray.direction), dot(water.cube[1].xyz, ray.direction), dot(water.cube[2].xyz, ray.direction)),
    );
    let faces = slabs(local, vec3f(0.0), vec3f(1.0));
    let enter = max(max(faces.enter.x, faces.enter.y), faces.enter.z);
    let leave = min(min(faces.leave.x, faces.leave.y), faces.leave.z);
    if enter > leave || enter < 0.0 || enter >= most {
        return End(NO_HIT, false, vec3f(0.0));
    }
    return End(enter, true, face_normal(local.origin + local.direction * enter));
}
#endif

// Where `ray`, which begins in the box or over it, meets the ground or the occluder within `most`.
fn follow(ray: Ray, most: f32) -> End {
    let faces = slabs(ray, vec3f(0.0), vec3f(terrain.size.x, terrain.highest, terrain.size.z));
    let begin = max(max(max(faces.enter.x, faces.enter.y), faces.enter.z), 0.0);
    let leave = min(min(faces.leave.x, faces.leave.y), faces.leave.z);
    let end = min(leave, most);
    var found = End(NO_HIT, false, vec3f(0.0));
    if begin <= end {
        let scale = vec3f(terrain.cells_per_unit.x, 1.0, terrain.cells_per_unit.y);
        var origin = (ray.origin + ray.direction * begin) * scale;
        origin = clamp(origin, vec3f(0.0), vec3f(terrain.cells.x, terrain.highest, terrain.cells.y));
        let direction = ray.direction * scale;
        let hit = march(Segment(origin, direction, end - begin, abs(ray.direction.y), 0.0, 1.0));
        var at = hit.at;
        // The floor is nowhere above the ground: only rounding brings a ray to it without a hit.
        var on_floor = at == NO_HIT && ray.direction.y < 0.0 && leave == faces.leave.y && end == leave;
#ifdef HOLES
        on_floor = on_floor && is_ground(origin.xz + direction.xz * (end - begin));
#endif
        at = select(at, end - begin, on_floor);
        found.at = select(begin + at, NO_HIT, at == NO_HIT);
    }
#ifdef WATER_OCCLUDER
    let cube = meet_cube(ray, select(found.at, most, found.at == NO_HIT));
    if cube.is_cube {
        return cube;
    }
#endif
    return found;
}

#ifdef SHADED
// The sky's light in a direction, linear, without fog and clouds.
fn bare_sky(direction: vec3f) -> vec3f {
#ifdef WATER_SKY
    let on_box = direction * vec3f(1.0, water.sun_and_flattening.w, 1.0);
    let size = abs(on_box);
    var face = select(5, 4, on_box.z > 0.0);
    var across = vec3f(sign(on_box.z), 0.0, 0.0);
    var down = vec3f(0.0, -1.0, 0.0);
    if size.x >= size.y && size.x >= size.z {
        face = select(1, 0, on_box.x > 0.0);
        across = vec3f(0.0, 0.0, -sign(on_box.x));
    } else if size.y >= size.z {
        face = select(3, 2, on_box.y > 0.0);
        across = vec3f(1.0, 0.0, 0.0);
        down = vec3f(0.0, 0.0, sign(on_box.y));
    }
    let corner = on_box / max(max(size.x, size.y), size.z);
    let inner = 1.0 - 1.0 / vec2f(textureDimensions(sky));
    let uv = 0.5 + 0.5 * inner * vec2f(dot(corner, across), dot(corner, down));
    let root = textureSampleLevel(sky, sky_sampler, uv, face, 0.0).rgb;
    return root * root;
#else
    return water.background_and_foam.xyz;
#endif
}

// The sky as a leg through air sees it that meets nothing: with the fog and the clouds before it.
fn sky_before(leg: Leg, pixel_size: f32) -> vec3f {
    let direction = leg.ray.direction;
    var light = bare_sky(direction);
#ifdef FOG
    let begin = leg.ray.origin.y * air::air.kilometres.y;
    let fog = air::veil_of_sky_over(direction, begin);
    light = light * fog.passes + fog.light;
#endif
#ifdef WATER_CLOUDS
    // From the nearest, which is the lowest, up, until nothing behind shows.
    var passes = 1.0;
    var gathered = vec3f(0.0);
    let steep = max(direction.y, 0.0);
    let seen = smoothstep(FADED, WHOLE, steep);
    let sun = vec4f(air_constants.sun.xyz, clouds.sun.z);
    let lights = CloudLights(sun, air_constants.sun_light.rgb, air_constants.sky_light.rgb);
    let count = select(0u, u32(clouds.count.x), seen > 0.0);
    var index = 0u;
    while index < CLOUD_LAYERS {
        if index >= count || passes < 0.03 {
            break;
        }
        let layer = clouds.layers[index];
        index += 1u;
        let over = layer.shape.x - leg.ray.origin.y;
        let along = over / max(steep, 1e-6);
        let place = leg.ray.origin.xz + direction.xz * along;
        let footprint = pixel_size * (leg.way + along) * pow(max(steep, 1e-3), -0.8);
        let cloud = cloud_at(layer, place, footprint, vec2f(0.0));
        let opacity = select(0.0, (1.0 - exp(-cloud.depth * min(1.0 / max(steep, 1e-3), 3.0))) * seen, over > 0.0);
        var shown = cloud_colour(cloud, direction, lights);
#ifdef AIR
        let up = air_constants.kilometres.y;
        let veil = air::veil_between(direction, along, leg.ray.origin.y * up, layer.shape.x * up);
        shown = shown * veil.passes + veil.light;
#endif
        gathered += passes * opacity * shown;
        passes *= 1.0 - opacity;
    }
    light = gathered + passes * light;
#endif
    return light;
}

// What light comes back along a leg from where it ends.
fn light_from(end: End, leg: Leg) -> vec3f {
    if end.is_cube {
#ifdef WATER_OCCLUDER
        let lit = water.cube_sun.w + max(dot(end.normal, water.cube_sun.xyz), 0.0);
        return face_colour(end.normal) * lit;
#endif
    }
    let p = (leg.ray.origin + leg.ray.direction * end.at) * vec3f(terrain.cells_per_unit.x, 1.0, terrain.cells_per_unit.y);
    let point = clamp(p, vec3f(0.0), vec3f(terrain.cells.x, terrain.size.y, terrain.cells.y));
    let cell = clamp(floor(point.xz), vec2f(0.0), terrain.cells - 1.0);
    return ground::colour(ground::Met(point, cell, point.xz - cell, false, 3u, leg.way + end.at), leg.ray);
}

// Sunlight that the waves of a split mirror to the eye along −`direction`: facets about the mean slope, as many as a normal
// distribution has (Ross, Dion and Potvin 2005, without shadowing).
fn glint(split: Split, direction: vec3f) -> vec3f {
    let half_way = normalize(terrain.sun - direction);
    // The sun is no point, and no water a perfect mirror.
    let variance = split.unseen + 2e-4;
    let off = vec2f(-half_way.x, -half_way.z) / max(half_way.y, 1e-3) - split.slope;
    let facets = exp(-0.5 * dot(off, off) / variance) / (6.2831853 * variance * pow(max(half_way.y, 1e-3), 4.0));
    let share = mirrored_share(dot(half_way, terrain.sun), INDEX);
    let seen = select(0.0, 1.0, terrain.sun.y > 0.0);
    return water.sun_and_flattening.xyz * (seen * min(share * facets / (4.0 * max(-direction.y, 0.05)), 4.0));
}
#endif

@fragment
fn fs_main(in: varyings::Varyings) -> Fragment {
    varyings::receive(in);
    let eye_ray = pixel_ray(in.position.xy);
    let length_of_direction = length(eye_ray.direction);
    let submerged = water.deep_and_submerged.w > 0.0;
    let faces = slabs(eye_ray, vec3f(0.0), vec3f(terrain.size.x, level(), terrain.size.z));
    let into = max(max(faces.enter.x, faces.enter.y), faces.enter.z);
    let end = min(min(faces.leave.x, faces.leave.y), faces.leave.z);
    // Whether the eye is in the water, or above its level, is known in f64: rounding decides for no pixel alone.
    let is_above = water.deep_and_submerged.w < 0.0;
    let begin = select(max(into, -frame.ray_start), -frame.ray_start, submerged);
    let direction = eye_ray.direction / length_of_direction;
    // Nothing of the water is seen there. Discarded at the end: a software rasteriser goes on after a `discard`, and would walk.
    var hidden = (begin > end && !submerged) || (is_above && direction.y >= 0.0);
    let origin = eye_ray.origin + eye_ray.direction * begin;
    // Where single precision puts an eye above the surface into the water, the ray comes in through the surface.
    let from_above = is_above && (faces.enter.y == into || into <= -frame.ray_start);
    let view_depth = frame.ray_start + begin;
    let written = select(min(NEAR / max(view_depth, NEAR), 1.0), 1.0, submerged);
    var leg = Leg(Ray(origin, direction), true, false, vec3f(1.0), view_depth * length_of_direction);
    // The other half of a ray that is split.
    var other = leg;
    var turn = select(0u, LEGS, hidden);
#ifdef PROBE
    var lengths = vec4f(leg.way, -2.0, -2.0, select(1.0, 0.0, from_above));
#endif
#ifdef SHADED
    var color = vec3f(0.0);
    // Sunlight that the waves mirror.
    var glinting = vec3f(0.0);
#endif
#ifdef SUNLIGHT
    // Of no weight where the eye's ray does not come in through the surface: there is no glint to be seen, or hidden.
    var sunward = Leg(leg.ray, false, false, vec3f(0.0), leg.way);
#endif
#ifdef WATER_FOAM
    var foam = 0.0;
#endif
    if from_above && !hidden {
        let on_map = clamp(origin.xz * terrain.cells_per_unit, vec2f(0.0), terrain.cells);
        let cell = min(floor(on_map), terrain.cells - 1.0);
        let corners = cell_corners(cell);
        let over_ground = level() - bilinear(corners, on_map - cell);
#ifdef HOLES
        let is_dry = has_ground(corners) && over_ground < 0.0;
#else
        let is_dry = over_ground < 0.0;
#endif
        // In the ground, which hides it.
        hidden = is_dry;
        let width = frame.pixel_size * view_depth;
        let split = split_at(origin.xz, direction, true, width);
        let start = vec3f(origin.x, level(), origin.z);
        leg = Leg(Ray(start, split.mirrored), false, true, vec3f(split.share), leg.way);
        other = Leg(Ray(start, split.through), true, false, vec3f(1.0 - split.share), leg.way);
        turn = select(1u, LEGS, is_dry);
#ifdef SHADED
        // Where little light is mirrored, most of the mirrored light is the sun's.
        glinting = glint(split, direction) * (split.share / max(split.share, 0.02));
#endif
#ifdef WATER_FOAM
        // How steep the ground under it is.
        let across = vec2f(corners.y + corners.w - corners.x - corners.z, corners.z + corners.w - corners.x - corners.y);
        let slope = 0.5 * length(across * terrain.cells_per_unit);
        foam = waves::foam_at(origin.xz, over_ground, slope, width, 1.0 / max(-direction.y, 0.05));
#ifdef HOLES
        foam = select(0.0, foam, has_ground(corners));
#endif
        leg.weight *= 1.0 - foam;
        other.weight *= 1.0 - foam;
        glinting *= 1.0 - foam;
#endif
#ifdef CLOUD_SHADOWS
        glinting *= air::cloud_light(start);
#endif
#ifdef SUNLIGHT
        sunward = Leg(Ray(start, terrain.sun), false, false, glinting, leg.way);
#endif
    }
    while turn < LEGS {
        let index = turn;
        turn += 1u;
        if index == 2u {
            leg = other;
        }
#ifdef SUNLIGHT
        if index == SUNWARD {
            leg = sunward;
        }
#endif
        if max(max(leg.weight.x, leg.weight.y), leg.weight.z) >= LEAST {
            // A leg through water that rises ends at the surface.
            let to_surface = (level() - leg.ray.origin.y) / max(leg.ray.direction.y, 1.0 / ENDLESS);
            let rises = leg.in_water && leg.ray.direction.y > 0.0;
            let most = select(ENDLESS, max(to_surface, 0.0), rises);
            var met = End(NO_HIT, false, vec3f(0.0));
#ifdef WATER_REFLECTION
            met = follow(leg.ray, most);
#else
            // A mirror of the sky alone.
            if !leg.mirrored {
                met = follow(leg.ray, most);
            }
#endif
            let rounding = ROUNDING * (leg.way + max(terrain.size.x, terrain.size.z));
            if index == 0u && met.at != NO_HIT && met.at <= rounding {
                // The ground's own cut side, or an eye in the ground.
                hidden = true;
                break;
            }
            let side = leg.ray.origin + leg.ray.direction * most;
            let surfaces = rises && met.at == NO_HIT && all(side.xz >= vec2f(0.0)) && all(side.xz <= terrain.size.xz);
            let way = select(met.at, most, surfaces);
            let ends = met.at != NO_HIT || surfaces;
#ifdef PROBE
            let length_of_leg = select(-1.0, way, ends);
            if index == 0u {
                lengths.x = select(-1.0, leg.way + way, ends);
            } else if leg.in_water {
                lengths.z = length_of_leg;
            } else {
                lengths.y = length_of_leg;
            }
#endif
#ifdef SHADED
            if leg.in_water {
                let left = select(vec3f(0.0), exp(-water.absorption_and_level.xyz * max(way, 0.0)), ends);
                color += leg.weight * water.deep_and_submerged.xyz * (1.0 - left);
#ifdef WATER_BUBBLES
                if submerged && index == 0u {
                    let bubbles = waves::bubbles_along(leg.ray.origin, leg.ray.direction, select(ENDLESS, way, ends));
                    color += bubbles * (0.15 * water.foam_light_and_bubbles.xyz + water.deep_and_submerged.xyz);
                    leg.weight *= 1.0 - 0.5 * bubbles;
                }
#endif
                leg.weight *= left;
            }
            if met.at != NO_HIT {
                if leg.in_water {
                    // The sunlight has come through the water above, too.
                    let below = level() - (leg.ray.origin.y + leg.ray.direction.y * met.at);
                    leg.weight *= exp(-water.absorption_and_level.xyz * max(below, 0.0));
                }
                if index != SUNWARD {
                    var light = light_from(met, leg);
#ifdef AIR
                    if !leg.in_water {
                        let end = leg.ray.origin.y + leg.ray.direction.y * met.at;
                        let begin = leg.ray.origin.y * air::air.kilometres.y;
                        let veil = air::veil_between(leg.ray.direction, met.at, begin, end * air::air.kilometres.y);
                        light = light * veil.passes + veil.light;
                    }
#endif
                    color += leg.weight * light;
                }
            } else if !leg.in_water {
#ifdef SUNLIGHT
                let seen = select(sky_before(leg, frame.pixel_size), vec3f(1.0), index == SUNWARD);
                color += leg.weight * seen;
#else
                color += leg.weight * sky_before(leg, frame.pixel_size);
                if leg.mirrored && index == 1u {
                    // Without shadows only what is seen in the mirror hides the sun's glint.
                    color += glinting;
                }
#endif
            }
#endif
            if surfaces {
                let start = vec3f(side.x, level(), side.z);
                let arrived = leg.way + most;
                let split = split_at(start.xz, leg.ray.direction, false, frame.pixel_size * arrived / length_of_direction);
                other = Leg(Ray(start, split.mirrored), true, true, leg.weight * split.share, arrived);
                leg = Leg(Ray(start, split.through), false, false, leg.weight * (1.0 - split.share), arrived);
            } else if index == 0u {
                break;
            }
        }
    }
    if hidden {
        discard;
    }
#ifdef PROBE
    return Fragment(lengths, written);
#else
#ifdef WATER_FOAM
    color += foam * water.foam_light_and_bubbles.xyz;
#endif
#ifdef AIR
    if !submerged {
        color = air::through(color, eye_ray.direction, view_depth, origin.y, in.position.xy);
    }
#endif
    return Fragment(vec4f(color, 1.0), written);
#endif
}
