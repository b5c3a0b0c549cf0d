// Ground with invented detail: the bilinear surface, and on it octaves of gradient noise (Perlin 2002) finer than the map's
// samples. All of their lattices include the samples, where the noise is 0: what was measured stays as it is. How high the
// noise is follows from how much the ground bends from sample to sample nearby, and how it falls from octave to octave from
// the whole map (`heightfield/fractal.rs`).
//
// An octave whose cells are narrower than two pixels is left out, and one of four pixels is there in full: so there is no
// detail where a cell of the map is as small as that, and nothing that shimmers. `max-mipmap.wgsl` walks to the cells, over a
// pyramid that bounds the ground with its detail. In a cell the ray steps as far as it safely may (Hart 1996, "Sphere
// tracing"): octaves that were looked at change by their steepest slope, those that were not by their height.
#define_import_path relief::fractal

#import relief::frame::frame
#import relief::heightfield::{terrain, NO_HIT, bilinear}
#import relief::smooth::samples_around

// Octaves at most. The cells of the last one are 1/128 of the map's.
const OCTAVES: u32 = 8u;
// The most that the noise and its slope along any direction can be; unit vectors stand on its lattice.
const MOST_NOISE: f32 = 0.70711;
const MOST_SLOPE: f32 = 2.08;
// A ray so near to the ground has met it, in pixels.
const NEAR_ENOUGH: f32 = 0.01;
// The same as a share of the box's height: what rounding makes of a height.
const ROUNDING: f32 = 2e-7;
// No step is shorter than this share of a pixel: a ray that runs along the ground misses what is thinner.
const SHORTEST: f32 = 0.1;
// Most steps in a cell. One that takes half of them has run along the ground for long: it divides what is left of its way
// among the others.
const MOST_TURNS: u32 = 1024u;
const FAR: f32 = 1e30;

// Height of the coarsest octave over the ground's bend, and of each octave over the one before.
@group(1) @binding(60) var<storage, read> detail: vec4f;

// Width of a pixel where the ray's segment begins, and its growth along the ray. Cells.
var<private> pixel_at_entry: f32;
var<private> pixel_growth: f32;
// Width of a pixel at the place whose normal is asked for.
var<private> pixel_here: f32;

// Notes how wide pixels are along the ray: `depth` is where its segment begins, `length` that of its direction.
fn look_along(depth: f32, length: f32) {
    pixel_growth = length * frame.pixel_size * max(terrain.cells_per_unit.x, terrain.cells_per_unit.y);
    pixel_at_entry = depth * pixel_growth;
}

// Width of a pixel at the parameter `at` of the ray.
fn pixel_width(at: f32) -> f32 {
    return max(pixel_at_entry + at * pixel_growth, 1e-9);
}

// Whether the ground is the bilinear one from `at` on.
fn is_plain(at: f32) -> bool {
    return pixel_width(at) >= 0.5;
}

// Share of an octave with cells so wide that shows where a pixel is `pixel` wide.
fn shown(spacing: f32, pixel: f32) -> f32 {
    return clamp(0.5 * spacing / pixel - 1.0, 0.0, 1.0);
}

// How much the ground bends at the corners of a cell: a sample's distance from the middle between its neighbours, along that
// axis where it is less. A ridge or a rim, which bends along one, is no roughness. At the map's border nothing is known of it.
fn bends(cell: vec2f, samples: mat4x4f) -> vec4f {
    let inner_x = vec2f(f32(cell.x > 0.0), f32(cell.x + 1.0 < terrain.cells.x));
    let inner_z = vec2f(f32(cell.y > 0.0), f32(cell.y + 1.0 < terrain.cells.y));
    let north = samples[1].yz;
    let south = samples[2].yz;
    let north_x = inner_x * abs(north - 0.5 * (samples[1].xy + samples[1].zw));
    let south_x = inner_x * abs(south - 0.5 * (samples[2].xy + samples[2].zw));
    let north_z = inner_z.x * abs(north - 0.5 * (samples[0].yz + south));
    let south_z = inner_z.y * abs(south - 0.5 * (north + samples[3].yz));
    return vec4f(min(north_x, north_z), min(south_x, south_z));
}

// A well mixed hash of the four corners of a lattice cell (`lowbias32`, Wellons 2018).
fn hashes(lattice: vec2<u32>, octave: u32) -> vec4<u32> {
    let x = vec4<u32>(0u, 1u, 0u, 1u) + lattice.x;
    let z = vec4<u32>(0u, 0u, 1u, 1u) + lattice.y;
    var v = x * 0x9e3779b1u + z * 0x85ebca77u + octave * 0xc2b2ae3du;
    v = (v ^ (v >> vec4<u32>(16u))) * 0x7feb352du;
    v = (v ^ (v >> vec4<u32>(15u))) * 0x846ca68bu;
    return v ^ (v >> vec4<u32>(16u));
}

// Value of an octave, and its slopes along x and z in lattice cells. `place` is within the map's cell.
fn octave_at(cell: vec2f, place: vec2f, octave: u32) -> vec3f {
    let side = f32(1u << octave);
    let scaled = place * side;
    let base = clamp(floor(scaled), vec2f(0.0), vec2f(side - 1.0));
    let f = scaled - base;
    let v = hashes((vec2<u32>(cell) << vec2<u32>(octave)) + vec2<u32>(base), octave);
    // A point of a diamond's sides, drawn out to the unit circle.
    let a = vec4f(v & vec4<u32>(0xffffu)) / 32768.0 - 1.0;
    let b = (1.0 - abs(a)) * select(vec4f(-1.0), vec4f(1.0), (v & vec4<u32>(0x10000u)) != vec4<u32>(0u));
    let unit = inverseSqrt(a * a + b * b);
    let gradient_x = a * unit;
    let gradient_z = b * unit;
    let ramps = gradient_x * (vec4f(f.x) - vec4f(0.0, 1.0, 0.0, 1.0)) + gradient_z * (vec4f(f.y) - vec4f(0.0, 0.0, 1.0, 1.0));
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let steep = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    let weights = vec4f((1.0 - fade.x) * (1.0 - fade.y), fade.x * (1.0 - fade.y), (1.0 - fade.x) * fade.y, fade.x * fade.y);
    let rise_x = mix(ramps.y - ramps.x, ramps.w - ramps.z, fade.y);
    let rise_z = mix(ramps.z - ramps.x, ramps.w - ramps.y, fade.x);
    return vec3f(
        dot(weights, ramps),
        dot(weights, gradient_x) + steep.x * rise_x,
        dot(weights, gradient_z) + steep.y * rise_z,
    );
}

// How far a ray may go that is `gap` above what it nears at this rate.
fn safe_step(gap: f32, rate: f32) -> f32 {
    return select(gap / max(rate, 1e-30), select(0.0, FAR, gap > 0.0), rate <= 0.0);
}

// First parameter in [0, length] where the ray from `local` (coordinates in the cell, y in world units), which is at `begin`
// of its segment there, meets the ground with its detail, or NO_HIT.
fn meet(cell: vec2f, local: vec3f, direction: vec3f, length: f32, begin: f32) -> f32 {
    let samples = samples_around(cell);
    let corners = vec4f(samples[1].yz, samples[2].yz);
    let heights = detail.x * bends(cell, samples);
    let most = max(max(heights.x, heights.y), max(heights.z, heights.w));
    let nearest = pixel_width(begin);
    // Heights of all octaves together, over that of the coarsest.
    var total = 0.0;
    var first_gain = 1.0;
    var first_spacing = 1.0;
    for (var octave = 0u; octave < OCTAVES; octave += 1u) {
        total += first_gain * shown(first_spacing, nearest);
        first_gain *= detail.y;
        first_spacing *= 0.5;
    }
    let reach = MOST_NOISE * most;
    let lowest = min(local.y, local.y + direction.y * length);
    if lowest > max(max(corners.x, corners.y), max(corners.z, corners.w)) + reach * total {
        return NO_HIT;
    }
    // Along the ray the bilinear ground, and the height of the detail, are quadratic: their slopes are greatest at its ends.
    let k = corners.x - corners.y - corners.z + corners.w;
    let turning = -2.0 * k * direction.x * direction.z;
    let slope = direction.y - (corners.y - corners.x) * direction.x - (corners.z - corners.x) * direction.z
        - k * (local.x * direction.z + local.z * direction.x);
    let heights_k = heights.x - heights.y - heights.z + heights.w;
    let heights_slope = (heights.y - heights.x) * direction.x + (heights.z - heights.x) * direction.z
        + heights_k * (local.x * direction.z + local.z * direction.x);
    let heights_rate =
        max(abs(heights_slope), abs(heights_slope + 2.0 * heights_k * direction.x * direction.z * length));
    let across = sqrt(dot(direction.xz, direction.xz));
    // Cells along the ray per parameter.
    let along = max(pixel_growth / frame.pixel_size, across);
    let per_pixel = NEAR_ENOUGH / max(terrain.cells_per_unit.x, terrain.cells_per_unit.y);
    var t = 0.0;
    for (var turn = 0u; turn < MOST_TURNS; turn += 1u) {
        let place = clamp(local.xz + direction.xz * t, vec2f(0.0), vec2f(1.0));
        let pixel = nearest + t * pixel_growth;
        let height = bilinear(heights, place);
        var above = local.y + direction.y * t - bilinear(corners, place);
        var rate = max(-(slope + turning * t), -(slope + turning * length));
        var rest = reach * total;
        var step = safe_step(above - rest, rate);
        var gain = 1.0;
        var spacing = 1.0;
        var whole = true;
        for (var octave = 0u; octave < OCTAVES; octave += 1u) {
            let most_shown = shown(spacing, nearest);
            if most_shown <= 0.0 {
                break;
            }
            // What is farther than half a cell of the next octave needs none of it.
            if step * across > 0.5 * spacing {
                whole = false;
                break;
            }
            above -= height * gain * shown(spacing, pixel) * octave_at(cell, place, octave).x;
            rest = max(rest - reach * gain * most_shown, 0.0);
            let full = max(nearest, 0.25 * spacing);
            let fading = MOST_NOISE * 0.5 * spacing * pixel_growth / (full * full);
            rate += gain * most_shown * (most * (MOST_SLOPE * across / spacing + fading) + MOST_NOISE * heights_rate);
            step = max(step, safe_step(above - rest, rate));
            gain *= detail.y;
            spacing *= 0.5;
        }
        if whole && above <= max(per_pixel * pixel, ROUNDING * terrain.size.y) {
            return t;
        }
        let hurry = select(0.0, (length - t) / f32(MOST_TURNS - turn), 2u * turn > MOST_TURNS);
        t += max(max(step, SHORTEST * pixel / along), hurry);
        if t > length {
            return NO_HIT;
        }
    }
    return NO_HIT;
}

// Slopes of the detail along x and z, world units per cell, at `f` within `cell`, with the samples around it.
fn detail_slopes(cell: vec2f, f: vec2f, samples: mat4x4f) -> vec2f {
    let heights = detail.x * bends(cell, samples);
    let height = bilinear(heights, f);
    let change = vec2f(
        mix(heights.y - heights.x, heights.w - heights.z, f.y),
        mix(heights.z - heights.x, heights.w - heights.y, f.x),
    );
    var slopes = vec2f(0.0);
    var gain = 1.0;
    var spacing = 1.0;
    for (var octave = 0u; octave < OCTAVES; octave += 1u) {
        let share = gain * shown(spacing, pixel_here);
        if share <= 0.0 {
            break;
        }
        let noise = octave_at(cell, f, octave);
        slopes += share * (height / spacing * noise.yz + change * noise.x);
        gain *= detail.y;
        spacing *= 0.5;
    }
    return slopes;
}
