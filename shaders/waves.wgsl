// What the still sea lacks: waves, foam along the shore, bubbles. All of it is a function of the place and of the scene's
// clock, so that a picture can be made again.
#define_import_path relief::waves

// Waves added up.
const WAVES: u32 = 12u;

struct Water {
    // From world space to that of the occluder, the unit cube.
    cube: array<vec4f, 3>,
    // Towards the sun in the occluder's space, as bright as it is there; light from everywhere.
    cube_sun: vec4f,
    // Of light in the water, per world unit, by channel; height of the sea in the box.
    absorption_and_level: vec4f,
    // Light that comes back from endless water; 1 where the eye is in the water, −1 where it is above its level, 0 beside it.
    deep_and_submerged: vec4f,
    // Sunlight as the sea mirrors it; flattening of the sky's box.
    sun_and_flattening: vec4f,
    // Light behind everything where there is no sky; depth up to which there is foam.
    background_and_foam: vec4f,
    // Light on foam; radius of the largest bubbles.
    foam_light_and_bubbles: vec4f,
    // Nothing; how far bubbles have risen, in cells of their grid; length of the foam's flakes; radians per world unit of the
    // longest wave.
    drift: vec4f,
    // Where the foam's pattern has drifted to, in flakes; nothing.
    foam_shift: vec4f,
    // Of each wave: radians per world unit along x and z, its slope, its phase now.
    waves: array<vec4f, 12>,
}

@group(1) @binding(40) var<storage, read> water: Water;

#ifdef WATER_WAVES
// The surface at a place: its mean slopes along x and z over a pixel, and the variance of the slope that a pixel is too large
// to show.
struct Chop {
    slope: vec2f,
    unseen: f32,
}

// Waves at the place `p` of the surface, seen along `direction` (unit length) in pixels that are `width` wide there. Each
// wave counts as far as a pixel can show it: what would shimmer makes the mirror rough instead (Bruneton, Neyret and
// Holzschuch 2010, section 4).
fn chop_at(p: vec2f, direction: vec3f, width: f32) -> Chop {
    let level = max(length(direction.xz), 1e-6);
    let away = direction.xz / level;
    let along = width / max(abs(direction.y), 1e-3);
    var slope = vec2f(0.0);
    var unseen = 0.0;
    var index = 0u;
    // Crests of straight waves would make a grid: these are bent by a slow swell, and rise and fall in gusts.
    let slow = p * (0.19 * water.drift.w);
    let swell = vec2f(sin(slow.y + 1.3 * sin(0.61 * slow.x)), sin(slow.x + 1.7 * sin(0.53 * slow.y + 2.0)));
    let place = p + swell * (2.6 / water.drift.w);
    let gust = 0.75 + 0.25 * sin(0.7 * slow.x + 0.9 * swell.y) * sin(0.45 * slow.y - 0.8 * swell.x);
    while index < WAVES {
        let wave = water.waves[index];
        index += 1u;
        let k = wave.xy;
        // Radians that a pixel covers.
        let covered = vec2f(dot(k, away) * along, (k.y * away.x - k.x * away.y) * width);
        let shown = exp(-0.125 * dot(covered, covered));
        slope += k * (inverseSqrt(dot(k, k)) * wave.z * shown * cos(dot(k, place) + wave.w));
        unseen += 0.5 * wave.z * wave.z * (1.0 - shown * shown);
    }
    return Chop(slope * gust, unseen * gust * gust);
}
#endif

// A number in 0..1 that looks random, from whole numbers.
fn hashed(cell: vec3f) -> f32 {
    var n = bitcast<vec3u>(vec3i(cell));
    n = n * 1664525u + 1013904223u;
    n.x += n.y * n.z;
    n.y += n.z * n.x;
    n.z += n.x * n.y;
    n = n ^ (n >> vec3u(16u));
    n.x += n.y * n.z;
    return f32(n.x >> 8u) / 16777216.0;
}

#ifdef WATER_FOAM
fn value_noise(p: vec2f, layer: f32) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let north = mix(hashed(vec3f(cell, layer)), hashed(vec3f(cell + vec2f(1.0, 0.0), layer)), s.x);
    let south = mix(hashed(vec3f(cell + vec2f(0.0, 1.0), layer)), hashed(vec3f(cell + 1.0, layer)), s.x);
    return mix(north, south, s.y);
}

// Share of the surface at `p` that foam covers, over ground `depth` below that is `slope` steep, in pixels `width` wide, and so
// much longer along the shore as the eye looks flatly at it: `away`.
fn foam_at(p: vec2f, depth: f32, slope: f32, width: f32, away: f32) -> f32 {
    // As deep as the ground is under a pixel's length. A fringe that is narrower than a pixel is as wide as one, and as much
    // fainter: no line of dashes along far shores.
    let deepest = water.background_and_foam.w;
    let covered = deepest + 1.5 * slope * width * away;
    let near = clamp(1.0 - depth / covered, 0.0, 1.0);
    if near <= 0.0 {
        return 0.0;
    }
    let q = p / water.drift.z;
    let broad = value_noise(q + water.foam_shift.xy, 1.0);
    let fine = value_noise(q * 2.7 - water.foam_shift.yx, 2.0);
    let pattern = 0.6 * broad + 0.4 * fine;
    // Not all of a shore lies in the swell.
    let swell = smoothstep(0.25, 0.7, 0.65 * value_noise(q * 0.11, 5.0) + 0.35 * value_noise(q * 0.31, 6.0));
    let faint = deepest / covered * (0.25 + 0.75 * swell) * 0.85;
    // The nearer the shore, the denser. Where flakes are smaller than pixels, their mean.
    let flakes = smoothstep(0.0, 0.25, near - pattern * 0.9);
    let blur = smoothstep(0.3, 1.0, width / water.drift.z);
    return faint * mix(flakes, near * near * 0.7, blur);
}
#endif

#ifdef WATER_BUBBLES
// Places along a ray where bubbles are looked for.
const BUBBLE_PLACES: u32 = 10u;

// How much light bubbles between `origin` and what lies `reach` from it along `direction` (unit length) add: one rises in some
// cells of a grid, and the ray looks into the cells at places ever farther apart.
fn bubbles_along(origin: vec3f, direction: vec3f, reach: f32) -> f32 {
    let radius = water.foam_light_and_bubbles.w;
    let side = 8.0 * radius;
    var light = 0.0;
    var way = 16.0 * radius;
    var index = 0u;
    while index < BUBBLE_PLACES {
        index += 1u;
        let p = origin + direction * way;
        // Columns of bubbles do not rise in step.
        let column = floor(p.xz / side);
        let lift = hashed(vec3f(column, 3.0));
        let tenths = 6.0 + floor(8.0 * lift);
        let height = p.y / side - water.drift.y * (0.1 * tenths) + lift;
        let row = floor(height);
        // Begins anew after so many cells that the clock may (`render/water.rs`).
        let chance = hashed(vec3f(column.x + 17.0, row - 540.0 * floor(row / 540.0), column.y + 5.0));
        let aside = 0.5 + 0.25 * vec2f(cos(chance * 97.0), sin(chance * 97.0));
        let centre = vec3f(column.x + aside.x, row + 0.5, column.y + aside.y);
        let from_centre = vec3f(p.x / side, height, p.z / side) - centre;
        // Nearest that the ray comes to the centre, in radii; a bubble is bright at its rim, and where it mirrors the sun.
        let past = from_centre - direction * dot(from_centre, direction);
        let size = (0.3 + 0.7 * chance) * 0.125;
        let off = length(past) / size;
        let rim = smoothstep(0.55, 0.9, off) * (1.0 - smoothstep(0.9, 1.0, off));
        let spot = 1.0 - smoothstep(0.0, 0.25, length(past / size - vec3f(-0.35, 0.4, 0.0)));
        let fades = 1.0 - f32(index) / f32(BUBBLE_PLACES + 1u);
        let is_there = select(0.0, 1.0, chance > 0.75 && way < reach);
        light = max(light, is_there * (0.5 * rim + 0.9 * spot + 0.06 * (1.0 - smoothstep(0.8, 1.0, off))) * fades);
        way *= 1.3;
    }
    return min(light, 1.0);
}
#endif
