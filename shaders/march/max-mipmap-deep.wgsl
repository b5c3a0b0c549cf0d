// Exact, in a deep zoom: the walk of `max-mipmap.wgsl` in coordinates that count from the anchor (`anchor.wgsl`).
//
// Parameters may be negative. Nodes and walls have the same whole numbers as in the ordinary walk; only where a ray is
// among them counts from the anchor. A ray goes down the pyramid where it is, without looking how far it still falls:
// that costs some steps, and the walk has no place that rounding could put into the wrong node.
#define_import_path relief::march

#import relief::anchor::{anchor, ground_beside_anchor, place_at}
#import relief::constants::MOST_STEPS
#import relief::heightfield::{terrain, heights, corner_sampler, Segment, Hit, NO_HIT, cell_corners, bilinear}
#import relief::pyramid::{
    RECIPROCAL_OF_ZERO, Course, Walk, lesser, greater, course_along, start, node_of, node_height, moved_on,
    either,
}

// A node's highest ground is raised by this share: more than its rounding.
const RAISE: f32 = 2e-6;

// Parameters at which the ray reaches walls, whole numbers of cells, along the two axes.
fn reached_from_anchor(course: Course, walls: vec2f) -> vec2f {
    let ahead = ((walls - course.sign * anchor.cell) - course.sign * anchor.fraction) - course.origin;
    return ahead * course.inverse;
}

// Shares that whole numbers of 1/units are, rounded to f32 as the map's are: a division of its own, because that of a GPU
// may be off by some last bits, which are pixels here.
fn shares_of_units(texels: vec4f) -> vec4f {
    let units = vec4u(u32(anchor.units));
    let whole = vec4u(texels * 65535.0 + 0.5);
    // Doubled until it is units or more, so that the first digit of the quotient is 1. Both fit 16 bits.
    let digits = countLeadingZeros(max(whole, vec4u(1u))) - countLeadingZeros(units);
    let aligned = whole << digits;
    let doublings = digits + select(vec4u(0u), vec4u(1u), aligned < units);
    let rest = (whole << doublings) - units;
    let next = (rest << vec4u(16u)) / units;
    let last = ((rest << vec4u(16u)) % units) << vec4u(7u);
    let quotient = vec4u(1u << 23u) + (next << vec4u(7u)) + last / units;
    let remainder = 2u * (last % units);
    let up = (remainder > units) | ((remainder == units) & ((quotient & vec4u(1u)) == vec4u(1u)));
    let rounded = vec4f(quotient + select(vec4u(0u), vec4u(1u), up));
    return select(ldexp(rounded, -vec4i(doublings) - 23), vec4f(0.0), whole == vec4u(0u));
}

#ifdef HOLES
// What stands for the height of a corner that holds none: below any other over any anchor.
const NO_CORNER: f32 = -1e30;
#endif

// Heights of the corners of `cell` over the anchor's.
fn corners_over_anchor(cell: vec2f) -> vec4f {
#ifdef CRATERS_LAYERED
    let corners = cell_corners(cell);
    let over_anchor = corners * anchor.shares_per_unit - anchor.height;
#ifdef HOLES
    return select(over_anchor, vec4f(NO_CORNER), corners < vec4f(0.0));
#else
    return over_anchor;
#endif
#else
    let shared_corner = (cell + 1.0) * terrain.texel_size;
    var shares = textureGather(0, heights, corner_sampler, shared_corner).wzxy;
    if anchor.units > 0.0 {
        shares = shares_of_units(shares);
    }
    let over_anchor = shares * anchor.relief - anchor.height;
#ifdef HOLES
    return select(over_anchor, vec4f(NO_CORNER), shares < vec4f(0.0));
#else
    return over_anchor;
#endif
#endif
}

// First parameter in [begin, end] at which the ray is on or below the ground of `cell`, or NO_HIT.
//
// The ray's height above the patch is quadratic·s² + linear·s + c, with s counted from a point on the ray: in the
// anchor's cell and those beside it the anchor's own parameter, so that the patch's slopes are multiplied by nothing
// larger than what is seen; elsewhere the entry into the cell. The ray may be at the ground before that point, and c below 0.
// Of the two roots it comes from above at (−linear − √discriminant) / (2·quadratic), which is taken in the form that does
// not cancel.
fn meet_ground(cell: vec2f, ray: Segment, begin: f32, end: f32) -> f32 {
    let corners = corners_over_anchor(cell);
#ifdef HOLES
    if any(corners == vec4f(NO_CORNER)) {
        return NO_HIT;
    }
#endif
    let k = corners.x - corners.y - corners.z + corners.w;
    let from_cell = anchor.cell - cell;
    let anchor_within = from_cell + anchor.fraction;
    let is_near = all(abs(from_cell) <= vec2f(1.0));
    let reference = select(begin, 0.0, is_near);
    let here = ray.origin + ray.direction * begin;
    let within = select(clamp(anchor_within + here.xz, vec2f(0.0), vec2f(1.0)), anchor_within, is_near);
    let offset = select(vec3f(0.0, here.y, 0.0), ray.origin, is_near);
    var ground = bilinear(corners, within);
#ifndef CRATERS_LAYERED
    if is_near {
        ground = ground_beside_anchor(from_cell);
    }
#endif
    let slope = vec2f(corners.y - corners.x, corners.z - corners.x) + k * within.yx;
    let c = (offset.y - ground) - dot(slope, offset.xz) - k * offset.x * offset.z;
    let linear = (ray.direction.y - dot(slope, ray.direction.xz))
        - k * (offset.x * ray.direction.z + offset.z * ray.direction.x);
    let quadratic = -k * ray.direction.x * ray.direction.z;
    let first = begin - reference;
    let last = end - reference;
    if (quadratic * first + linear) * first + c <= 0.0 {
        return begin;
    }
    let discriminant = linear * linear - 4.0 * quadratic * c;
    let root = sqrt(max(discriminant, 0.0));
    let s = select(-(linear + root) / (2.0 * quadratic), 2.0 * c / (root - linear), linear <= 0.0);
    // A ray that is in the ground at the end has met it on the way, even where rounding puts the root outside of the cell.
    let meets = (quadratic * last + linear) * last + c <= 0.0 || discriminant >= 0.0 && s >= first && s <= last;
    return select(NO_HIT, reference + clamp(s, first, last), meets);
}

fn march(ray: Segment) -> Hit {
    if ray.begin > ray.end {
        return Hit(NO_HIT, 1u, 0u);
    }
    let direction = ray.direction.xz;
    let course = course_along(ray.origin.xz, direction);
    let falling = ray.direction.y < 0.0;
    let first_cell = place_at(ray.origin.xz + direction * ray.begin, terrain.cells).cell;
    var walk = start(course, first_cell, ray.begin, ray.size);
    let most_steps = min(terrain.step_cap, MOST_STEPS);
    while walk.steps < most_steps {
        walk.steps += 1u;
        let walls = walk.wall * walk.size;
        let along = reached_from_anchor(course, walls);
        // A ray that is parallel to an axis never reaches a wall across it, even where it runs along one.
        let ahead = select(along, vec2f(RECIPROCAL_OF_ZERO), course.inverse == vec2f(RECIPROCAL_OF_ZERO));
        let through_x = ahead.x <= ahead.y;
        let leave = greater(lesser(select(ahead.y, ahead.x, through_x), ray.end), walk.t);
        let node = node_of(course, walk);
        var goes_down = false;
        if walk.size > 1.0 {
            let highest = node_height(node, walk.size) * anchor.shares_per_unit * (1.0 + RAISE) - anchor.height;
            let lowest = ray.origin.y + ray.direction.y * select(walk.t, leave, falling);
            goes_down = lowest <= highest;
        } else {
            let hit = meet_ground(node, ray, walk.t, leave);
            if hit != NO_HIT {
                return Hit(hit, walk.steps, 0u);
            }
        }
        let ends = leave >= ray.end || select(walls.y >= course.border.y, walls.x >= course.border.x, through_x);
        if ends && !goes_down {
            return Hit(NO_HIT, walk.steps, 0u);
        }
        // The child that the ray is in; not one beyond the map's border.
        let middle = walls - 0.5 * walk.size;
        let first = (vec2f(walk.t) < reached_from_anchor(course, middle)) | (middle >= course.border);
        let within = Walk(walk.t, 0.5 * walk.size, 2.0 * walk.wall - vec2f(first), walk.steps);
        walk = either(moved_on(walk, through_x, leave, terrain.top_size), within, goes_down);
    }
    return Hit(walk.t, most_steps, 1u);
}
