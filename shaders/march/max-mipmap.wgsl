// Exact: maximum mipmap traversal (Tevs, Ihrke, Seidel 2008) over integer nodes, with the bilinear patch solved at
// the cells.
#define_import_path relief::march

#import relief::heightfield::{terrain, Segment, Hit, NO_HIT, cell_corners, bilinear}
#import relief::pyramid::{RECIPROCAL_OF_ZERO, Walk, course_along, walls_ahead, node_behind, next_node, node_height}

// First parameter in [0, length] where the ray from `local` (coordinates in the cell, y in world units) meets the
// bilinear patch over `corners`, or NO_HIT.
//
// With h(x, z) = h00 + a·x + b·z + k·x·z the ray's height above the patch is quadratic·t² + linear·t + c. The first root
// is taken in the form that does not cancel, whichever sign `linear` has; nearly planar cells need no special case.
fn intersect_patch(corners: vec4f, local: vec3f, direction: vec3f, length: f32) -> f32 {
    let c = local.y - bilinear(corners, local.xz);
    let k = corners.x - corners.y - corners.z + corners.w;
    let a = corners.y - corners.x;
    let b = corners.z - corners.x;
    let quadratic = -k * direction.x * direction.z;
    let linear = direction.y - a * direction.x - b * direction.z
        - k * (local.x * direction.z + local.z * direction.x);
    let discriminant = linear * linear - 4.0 * quadratic * c;
    let root = sqrt(max(discriminant, 0.0));
    let t = select(-(linear + root) / (2.0 * quadratic), 2.0 * c / (root - linear), linear <= 0.0);
    let meets = discriminant >= 0.0 && t >= 0.0 && t <= length;
    return select(select(NO_HIT, t, meets), 0.0, c <= 0.0);
}

// Whether `node` of `level` is on the map.
fn on_map(node: vec2i, level: u32) -> bool {
    return all(node >= vec2i(0)) && all(node <= (terrain.cells - 1) >> vec2u(level));
}

fn march(ray: Segment) -> Hit {
    let course = course_along(ray.direction.xz);
    let direction = ray.direction.xz;
    // A ray along the map's eastern or southern border belongs to the last cells, not to the wall behind them.
    let parallel = abs(direction) < vec2f(1.0 / RECIPROCAL_OF_ZERO);
    let before_border = vec2f(terrain.cells) * (1.0 - 1.2e-7);
    let origin = select(ray.origin.xz, min(ray.origin.xz, before_border), parallel);
    if ray.begin > ray.end {
        // The beam reaches the end of the box, or passes it by.
        return Hit(NO_HIT, 1u, 0u);
    }
    let cell = clamp(vec2i(floor(origin + direction * ray.begin)), vec2i(0), terrain.cells - 1);
    var walk = Walk(ray.begin, ray.level, cell >> vec2u(ray.level), 0u);
    while walk.steps < terrain.step_cap {
        // Down and across through the pyramid, until the ray may meet a cell. A loop of its own: where many rays walk
        // in step, none of them pays for the cells of the others here.
        while walk.level > 0u {
            walk.steps += 1u;
            let walls = walls_ahead(walk, course, origin);
            // A wall that rounding puts behind the ray must not move it backwards.
            let leave = max(min(min(walls.x, walls.y), ray.end), walk.t);
            let lowest = ray.origin.y + min(ray.direction.y * walk.t, ray.direction.y * leave);
            let blocked = lowest <= node_height(walk.node, walk.level);
            let behind = node_behind(walk, course, walls);
            if !blocked && (leave >= ray.end || !on_map(behind, walk.level)) {
                return Hit(NO_HIT, walk.steps, 0u);
            }
            walk = next_node(walk, origin, direction, behind, leave, blocked, terrain.top_level);
            // A child of a node at the map's border may lie beyond it.
            walk.node = min(walk.node, (terrain.cells - 1) >> vec2u(walk.level));
        }
        walk.steps += 1u;
        let walls = walls_ahead(walk, course, origin);
        let leave = max(min(min(walls.x, walls.y), ray.end), walk.t);
        let corners = cell_corners(walk.node);
        let position = (origin - vec2f(walk.node)) + direction * walk.t;
        let local = vec3f(position.x, ray.origin.y + ray.direction.y * walk.t, position.y);
        let hit = intersect_patch(corners, local, ray.direction, leave - walk.t);
        if hit >= 0.0 {
            return Hit(walk.t + hit, walk.steps, 0u);
        }
        let behind = node_behind(walk, course, walls);
        if leave >= ray.end || !on_map(behind, 0u) {
            return Hit(NO_HIT, walk.steps, 0u);
        }
        // Near the ground a node of 2 × 2 cells would mostly lead straight back down: it is tried every four cells.
        let up = any((behind >> vec2u(2u)) != (walk.node >> vec2u(2u)));
        walk = Walk(leave, select(0u, 1u, up), select(behind, behind >> vec2u(1u), up), walk.steps);
    }
    return Hit(walk.t, terrain.step_cap, 1u);
}
