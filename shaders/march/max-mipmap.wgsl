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

fn march(ray: Segment) -> Hit {
    let inverse = vec2f(reciprocal(ray.direction.x), reciprocal(ray.direction.z));
    // A ray without a direction along an axis counts as going up: its wall is then RECIPROCAL_OF_ZERO away, or at 0.
    let forward = vec2i(inverse >= vec2f(0.0));
    let step = 2 * forward - 1;
    let origin = ray.origin.xz;
    let direction = ray.direction.xz;
    var level = terrain.top_level;
    var t = 0.0;
    var node = clamp(vec2i(floor(origin)), vec2i(0), terrain.cells - 1) >> vec2u(level);
    for (var steps = 1u; steps <= terrain.step_cap; steps++) {
        // Where the ray leaves the node. A wall that rounding puts behind the ray must not move it backwards.
        let walls = vec2f((node + forward) << vec2u(level));
        let to_wall = (walls - origin) * inverse;
        let leave = max(min(min(to_wall.x, to_wall.y), ray.end), t);
        let lowest = ray.origin.y + min(ray.direction.y * t, ray.direction.y * leave);
        if level > 0u {
            let highest = textureLoad(pyramid, node, i32(level) - 1).r * terrain.size.y + terrain.layer_rise;
            if lowest <= highest {
                // Down. The child is found from the position and then clamped into its parent.
                level -= 1u;
                let child = vec2i(floor(origin + direction * t)) >> vec2u(level);
                let last = (terrain.cells - 1) >> vec2u(level);
                node = min(clamp(child, 2 * node, 2 * node + 1), last);
                continue;
            }
        } else {
            let corners = cell_corners(node);
            if lowest <= max(max(corners.x, corners.y), max(corners.z, corners.w)) {
                let position = (origin - vec2f(node)) + direction * t;
                let local = vec3f(position.x, ray.origin.y + ray.direction.y * t, position.y);
                let hit = intersect_patch(corners, local, ray.direction, leave - t);
                if hit >= 0.0 {
                    return Hit(t + hit, steps, 0u);
                }
            }
        }
        if leave >= ray.end {
            return Hit(NO_HIT, steps, 0u);
        }
        // Across the nearer wall. The node is stepped as an integer, never found again from the position.
        t = leave;
        let before = node;
        if to_wall.x <= to_wall.y {
            node.x += step.x;
        } else {
            node.y += step.y;
        }
        let last = (terrain.cells - 1) >> vec2u(level);
        if any(node < vec2i(0)) || any(node > last) {
            return Hit(NO_HIT, steps, 0u);
        }
        // A wall of the node that is also its parent's: go up.
        if level < terrain.top_level && any((node >> vec2u(1u)) != (before >> vec2u(1u))) {
            level += 1u;
            node = node >> vec2u(1u);
        }
    }
    return Hit(t, terrain.step_cap, 1u);
}
