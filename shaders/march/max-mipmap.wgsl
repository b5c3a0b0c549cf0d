// Exact: maximum mipmap traversal (Tevs, Ihrke, Seidel 2008) over integer nodes, with the bilinear patch solved at
// the cells.
//
// Level l of the pyramid has nodes of 2^l × 2^l cells. Level 0 is not stored: its maximum is that of the four corners,
// which the patch needs anyway. Mip m of the texture is level m + 1.
#define_import_path relief::march

#import relief::heightfield::{terrain, Segment, Hit, NO_HIT, cell_corners, bilinear}

@group(1) @binding(3) var pyramid: texture_2d<f32>;

// A ray that is parallel to an axis gets this reciprocal: large, but finite, so that 0 · RECIPROCAL_OF_ZERO is 0.
const RECIPROCAL_OF_ZERO: f32 = 1e30;

fn reciprocal(x: f32) -> f32 {
    if abs(x) < 1.0 / RECIPROCAL_OF_ZERO {
        return RECIPROCAL_OF_ZERO;
    }
    return 1.0 / x;
}

// First parameter in [0, length] where the ray from `local` (coordinates in the cell, y in world units) meets the
// bilinear patch over `corners`, or NO_HIT.
//
// With h(x, z) = h00 + a·x + b·z + k·x·z the ray's height above the patch is quadratic·t² + linear·t + c. The first root
// is taken in the form that does not cancel, whichever sign `linear` has; nearly planar cells need no special case.
fn intersect_patch(corners: vec4f, local: vec3f, direction: vec3f, length: f32) -> f32 {
    let c = local.y - bilinear(corners, local.xz);
    if c <= 0.0 {
        return 0.0;
    }
    let k = corners.x - corners.y - corners.z + corners.w;
    let a = corners.y - corners.x;
    let b = corners.z - corners.x;
    let quadratic = -k * direction.x * direction.z;
    let linear = direction.y - a * direction.x - b * direction.z
        - k * (local.x * direction.z + local.z * direction.x);
    let discriminant = linear * linear - 4.0 * quadratic * c;
    if discriminant < 0.0 {
        return NO_HIT;
    }
    let root = sqrt(discriminant);
    var t: f32;
    if linear <= 0.0 {
        t = 2.0 * c / (root - linear);
    } else {
        t = -(linear + root) / (2.0 * quadratic);
    }
    // Not a number, infinite and negative all fail this comparison.
    if t >= 0.0 && t <= length {
        return t;
    }
    return NO_HIT;
}

// Where a walk stands.
struct Walk {
    // Parameter at which the ray is in `node`.
    t: f32,
    level: u32,
    node: vec2i,
    steps: u32,
}

// What does not change along a walk.
struct Course {
    inverse: vec2f,
    // 1 along an axis where the ray goes up, 0 where it goes down.
    forward: vec2i,
}

// Parameters of the walls through which the ray leaves `walk.node`.
fn walls_ahead(walk: Walk, course: Course, origin: vec2f) -> vec2f {
    return (vec2f((walk.node + course.forward) << vec2u(walk.level)) - origin) * course.inverse;
}

// Steps across the nearer wall at `leave`; false where that leaves the map. The node is stepped as an integer, never
// found again from the position. A wall that is also the parent's leads up a level.
fn cross_wall(walk: ptr<function, Walk>, course: Course, walls: vec2f, leave: f32) -> bool {
    let before = (*walk).node;
    let step = 2 * course.forward - 1;
    let after = before + select(vec2i(0, step.y), vec2i(step.x, 0), walls.x <= walls.y);
    let last = (terrain.cells - 1) >> vec2u((*walk).level);
    (*walk).t = leave;
    (*walk).node = after;
    if (*walk).level < terrain.top_level && any((after >> vec2u(1u)) != (before >> vec2u(1u))) {
        (*walk).level += 1u;
        (*walk).node = after >> vec2u(1u);
    }
    return all(after >= vec2i(0)) && all(after <= last);
}

fn march(ray: Segment) -> Hit {
    let inverse = vec2f(reciprocal(ray.direction.x), reciprocal(ray.direction.z));
    // A ray without a direction along an axis counts as going up: its wall is then RECIPROCAL_OF_ZERO away, or at 0.
    let course = Course(inverse, vec2i(inverse >= vec2f(0.0)));
    let direction = ray.direction.xz;
    // A ray along the map's eastern or southern border belongs to the last cells, not to the wall behind them.
    let parallel = abs(direction) < vec2f(1.0 / RECIPROCAL_OF_ZERO);
    let before_border = vec2f(terrain.cells) * (1.0 - 1.2e-7);
    let origin = select(ray.origin.xz, min(ray.origin.xz, before_border), parallel);
    let cell = clamp(vec2i(floor(origin)), vec2i(0), terrain.cells - 1);
    var walk = Walk(0.0, terrain.top_level, cell >> vec2u(terrain.top_level), 0u);
    while walk.steps < terrain.step_cap {
        // Down and across through the pyramid, until the ray may meet a cell. A loop of its own: where many rays walk
        // in step, none of them pays for the cells of the others here.
        while walk.level > 0u && walk.steps < terrain.step_cap {
            walk.steps += 1u;
            let walls = walls_ahead(walk, course, origin);
            // A wall that rounding puts behind the ray must not move it backwards.
            let leave = max(min(min(walls.x, walls.y), ray.end), walk.t);
            let lowest = ray.origin.y + min(ray.direction.y * walk.t, ray.direction.y * leave);
            let highest = textureLoad(pyramid, walk.node, i32(walk.level) - 1).r * terrain.size.y + terrain.layer_rise;
            if lowest <= highest {
                // The child is found from the position and then clamped into its parent.
                walk.level -= 1u;
                let child = vec2i(floor(origin + direction * walk.t)) >> vec2u(walk.level);
                let last = (terrain.cells - 1) >> vec2u(walk.level);
                walk.node = min(clamp(child, 2 * walk.node, 2 * walk.node + 1), last);
            } else {
                if leave >= ray.end || !cross_wall(&walk, course, walls, leave) {
                    return Hit(NO_HIT, walk.steps, 0u);
                }
            }
        }
        if walk.level > 0u {
            // The cap ended the walk above the cells.
            break;
        }
        walk.steps += 1u;
        let walls = walls_ahead(walk, course, origin);
        let leave = max(min(min(walls.x, walls.y), ray.end), walk.t);
        let corners = cell_corners(walk.node);
        let lowest = ray.origin.y + min(ray.direction.y * walk.t, ray.direction.y * leave);
        if lowest <= max(max(corners.x, corners.y), max(corners.z, corners.w)) {
            let position = (origin - vec2f(walk.node)) + direction * walk.t;
            let local = vec3f(position.x, ray.origin.y + ray.direction.y * walk.t, position.y);
            let hit = intersect_patch(corners, local, ray.direction, leave - walk.t);
            if hit >= 0.0 {
                return Hit(walk.t + hit, walk.steps, 0u);
            }
        }
        if leave >= ray.end || !cross_wall(&walk, course, walls, leave) {
            return Hit(NO_HIT, walk.steps, 0u);
        }
    }
    return Hit(walk.t, terrain.step_cap, 1u);
}
