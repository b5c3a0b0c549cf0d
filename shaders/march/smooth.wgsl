// The smooth surface: the biquadratic B-spline whose control points are the map's samples, in place of bilinear patches.
// Its slope is continuous everywhere, and nowhere is it higher or lower than the samples around; it does not go through
// them, but evens them out by 1/8, 3/4, 1/8 along each axis. `max-mipmap.wgsl` walks to its cells, over a pyramid that
// bounds it (`heightfield/smooth.rs`).
//
// In each quarter of a cell the spline is one polynomial. Along a ray it is one of degree four in Bernstein form, whose
// coefficients bound it: parts in which all of them are above the ground are left out, the others halved, until there is one
// crossing to be found (Sederberg and Nishita 1990, "Curve intersection using Bézier clipping", section 2, for the bound).
#define_import_path relief::smooth

#import relief::heightfield::{terrain, NO_HIT, cell_corners}

// A part of a ray's way through a quarter of a cell as short as this is not halved any more: on it the ray and its bounds
// differ by less than 1e-7 of how much the ground bends within a cell. A ray so near to the ground has met it.
const FINEST: f32 = 0.000244140625;
// Most parts of a ray's way through a quarter of a cell: several for each halving down to the finest.
const MOST_PARTS: u32 = 80u;
// Most corrections of a crossing; each about doubles its digits.
const MOST_CORRECTIONS: u32 = 12u;

// Heights of the 4 × 4 samples around `cell`, by row.
fn samples_around(cell: vec2f) -> mat4x4f {
    let north_west = cell_corners(cell - 1.0);
    let north_east = cell_corners(cell + vec2f(1.0, -1.0));
    let south_west = cell_corners(cell + vec2f(-1.0, 1.0));
    let south_east = cell_corners(cell + 1.0);
    return mat4x4f(
        vec4f(north_west.xy, north_east.xy),
        vec4f(north_west.zw, north_east.zw),
        vec4f(south_west.xy, south_east.xy),
        vec4f(south_west.zw, south_east.zw),
    );
}

// The 3 × 3 of them, by row, that count in the quarter `second` of the cell: along each axis, whether it is the second half.
fn control_points(samples: mat4x4f, second: vec2<bool>) -> mat3x3f {
    let first_row = select(samples[0], samples[1], second.y);
    let middle_row = select(samples[1], samples[2], second.y);
    let last_row = select(samples[2], samples[3], second.y);
    return mat3x3f(
        select(first_row.xyz, first_row.yzw, second.x),
        select(middle_row.xyz, middle_row.yzw, second.x),
        select(last_row.xyz, last_row.yzw, second.x),
    );
}

// Weights of three control points in the polar form of the quadratic B-spline at (u, v), each 0 to 1 around the middle one.
fn polar_weights(u: f32, v: f32) -> vec3f {
    let first = 0.5 * (1.0 - u) * (1.0 - v);
    let last = 0.5 * u * v;
    return vec3f(first, 1.0 - first - last, last);
}

// Coefficients of a polynomial of degree four in Bernstein form.
struct Quartic {
    c: vec4f,
    last: f32,
}

// The same polynomial with [from, to] of its parameter as its new 0 to 1 (de Casteljau, twice).
fn part_of(q: Quartic, begin: f32, end: f32) -> Quartic {
    // Up to the end.
    let a1 = mix(q.c, vec4f(q.c.yzw, q.last), end);
    let a2 = mix(a1.xyz, a1.yzw, end);
    let a3 = mix(a2.xy, a2.yz, end);
    let left = Quartic(vec4f(q.c.x, a1.x, a2.x, a3.x), mix(a3.x, a3.y, end));
    // And from the beginning.
    let share = begin / end;
    let b1 = mix(left.c, vec4f(left.c.yzw, left.last), share);
    let b2 = mix(b1.xyz, b1.yzw, share);
    let b3 = mix(b2.xy, b2.yz, share);
    return Quartic(vec4f(mix(b3.x, b3.y, share), b3.y, b2.z, b1.w), left.last);
}

// Where a polynomial that falls from above 0 to 0 or below does so, 0 to 1: Newton's steps, and halvings where they lead
// out of what is known to hold the place.
fn crossing(q: Quartic) -> f32 {
    var low = 0.0;
    var high = 1.0;
    var at = clamp(q.c.x / (q.c.x - q.last), 0.0, 1.0);
    var moved = 1.0;
    for (var turn = 0u; (turn < MOST_CORRECTIONS) & (moved > 2e-7); turn += 1u) {
        let a1 = mix(q.c, vec4f(q.c.yzw, q.last), at);
        let a2 = mix(a1.xyz, a1.yzw, at);
        let a3 = mix(a2.xy, a2.yz, at);
        let value = mix(a3.x, a3.y, at);
        let above = value > 0.0;
        low = select(low, at, above);
        high = select(at, high, above);
        let newton = at - value / (4.0 * (a3.y - a3.x));
        let next = select(0.5 * (low + high), newton, newton >= low && newton <= high);
        moved = abs(next - at);
        at = next;
    }
    return at;
}

// The first place, 0 to 1, at which the polynomial is 0 or below, or NO_HIT.
fn first_root(whole: Quartic) -> f32 {
    if whole.c.x <= 0.0 {
        return 0.0;
    }
    var number = 0.0;
    var size = 1.0;
    var found = false;
    var part = whole;
    for (var turn = 0u; (turn < MOST_PARTS) & (size > 0.0) & !found; turn += 1u) {
        part = part_of(whole, number * size, (number + 1.0) * size);
        let inner = min(min(part.c.y, part.c.z), min(part.c.w, part.last));
        let is_above = min(inner, part.c.x) > 0.0;
        let falls = all(part.c.yzw <= part.c.xyz) && part.last <= part.c.w;
        found = !is_above && (falls || size <= FINEST || part.c.x <= 0.0);
        // On to the next part, twice as large where two of them begin there; none after the end.
        let next = number + 1.0;
        let half = 0.5 * next;
        let is_whole = half == floor(half);
        let onward = vec2f(select(next, half, is_whole), select(size, 2.0 * size, is_whole));
        let onward_size = select(onward.y, 0.0, next * size >= 1.0);
        let stays = found || !is_above;
        number = select(onward.x, select(2.0 * number, number, found), stays);
        size = select(onward_size, select(0.5 * size, size, found), stays);
    }
    if !found {
        // Cut off, it has come as near to the ground as rounding can tell.
        return select(number * size, NO_HIT, size == 0.0);
    }
    let crosses = part.c.x > 0.0 && part.last <= 0.0;
    let within = select(0.0, crossing(part), crosses);
    return (number + within) * size;
}

// First parameter in [0, length] where the ray from `local` (coordinates in the cell, y in world units) meets the smooth
// surface over `cell`, or NO_HIT.
fn meet_smooth(cell: vec2f, local: vec3f, direction: vec3f, length: f32) -> f32 {
    let samples = samples_around(cell);
    // Where the ray passes the middles of the cell, if it does on its way.
    let halves = (0.5 - local.xz) / select(direction.xz, vec2f(1e-30), abs(direction.xz) < vec2f(1e-30));
    let middles = clamp(halves, vec2f(0.0), vec2f(length));
    let stops = vec3f(min(middles.x, middles.y), max(middles.x, middles.y), length);
    var begin = 0.0;
    var hit = NO_HIT;
    for (var quarter = 0u; (quarter < 3u) & (hit == NO_HIT); quarter += 1u) {
        let end = stops[quarter];
        let way = local + direction * (0.5 * (begin + end));
        let second = way.xz >= vec2f(0.5);
        let points = control_points(samples, second);
        // Heights count from the middle control point: what is small is not lost in what is large.
        let reference = points[1].y;
        let from_middle = 0.5 - vec2f(f32(second.x), f32(second.y));
        let a = local + direction * begin;
        let b = local + direction * end;
        let u = a.xz + from_middle;
        let v = b.xz + from_middle;
        let first_x = polar_weights(u.x, u.x);
        let both_x = polar_weights(u.x, v.x);
        let last_x = polar_weights(v.x, v.x);
        let along_x = mat3x3f(
            (points[0] - reference) * mat3x3f(first_x, both_x, last_x),
            (points[1] - reference) * mat3x3f(first_x, both_x, last_x),
            (points[2] - reference) * mat3x3f(first_x, both_x, last_x),
        );
        let first = along_x * polar_weights(u.y, u.y);
        let both = along_x * polar_weights(u.y, v.y);
        let last = along_x * polar_weights(v.y, v.y);
        let ground = vec4f(
            first.x, 0.5 * (first.y + both.x), (first.z + 4.0 * both.y + last.x) / 6.0, 0.5 * (both.z + last.y),
        );
        let height = a.y - reference;
        let rise = b.y - a.y;
        let above = Quartic(vec4f(height) + rise * vec4f(0.0, 0.25, 0.5, 0.75) - ground, height + rise - last.z);
        // An empty quarter changes nothing: the next one begins where it does.
        let root = select(NO_HIT, first_root(above), end > begin || quarter == 2u);
        hit = select(hit, begin + root * (end - begin), root != NO_HIT);
        begin = end;
    }
    return hit;
}

// Normal of the smooth surface at the grid position `p`, world space.
fn smooth_normal(p: vec2f) -> vec3f {
    let cell = clamp(floor(p), vec2f(0.0), terrain.cells - 1.0);
    let f = p - cell;
    let second = f >= vec2f(0.5);
    let points = control_points(samples_around(cell), second);
    let u = f + 0.5 - vec2f(f32(second.x), f32(second.y));
    let slope_x = vec3f(u.x - 1.0, 1.0 - 2.0 * u.x, u.x);
    let slope_z = vec3f(u.y - 1.0, 1.0 - 2.0 * u.y, u.y);
    let gradient = vec2f(
        dot(slope_x * points, polar_weights(u.y, u.y)),
        dot(polar_weights(u.x, u.x) * points, slope_z),
    ) * terrain.cells_per_unit;
    return normalize(vec3f(-gradient.x, 1.0, -gradient.y));
}
