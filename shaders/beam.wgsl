// The beam pass: one fragment per tile of pixels finds a depth before which none of the tile's rays meets the ground, so
// that they need not all walk there.
//
// At the view depth z the rays of a tile lie within a parallelogram around the tile's central ray: along each axis
// within `footprint · z`. The walk follows the central ray, and takes at each node the maximum over all the nodes that
// a ray of the tile can be in.

#import relief::beam::BEAM_TILE
#import relief::frame::{frame, pixel_ray}
#import relief::heightfield::terrain
#import relief::pyramid::{Walk, course_along, walls_ahead, node_behind, next_node, node_height}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle that covers the screen.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Share of the box's size that is added to the beam's width on each side, against rounding.
const MARGIN: f32 = 1e-5;
// No ray of the tile meets the ground.
const NEVER: f32 = 1e30;

// Highest ground that the rays can be over while the central one is in `node` and they are within the node's own size
// of it: of the 2 × 2 nodes, one level up, around the node's nearest corner of that level. Nodes beyond the map count
// as those at its border.
fn height_around(node: vec2i, level: u32) -> f32 {
    let first = (node - 1) >> vec2u(1u);
    let last = (terrain.cells - 1) >> vec2u(level + 1u);
    let low = clamp(first, vec2i(0), last);
    let high = clamp(first + 1, vec2i(0), last);
    return max(
        max(node_height(low, level + 1u), node_height(vec2i(high.x, low.y), level + 1u)),
        max(node_height(vec2i(low.x, high.y), level + 1u), node_height(high, level + 1u)),
    );
}

// Parameter at which the tile's rays may start, and the level of the pyramid to start at.
@fragment
fn fs_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let ray = pixel_ray(position.xy * BEAM_TILE);
    // Half a tile reaches to the outer pixels' edges: half a pixel more than their rays need.
    let footprint = 0.5 * BEAM_TILE * (abs(frame.ray_direction_right) + abs(frame.ray_direction_down));
    let margin = MARGIN * max(max(terrain.size.x, terrain.size.z), terrain.size.y);

    // The box, widened by the beam at the box's farthest corner (w is its view depth): outside of it no ray of the tile
    // is in the box.
    var farthest = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        farthest = max(farthest, terrain.box_clip[corner].w);
    }
    let width = footprint * farthest + margin;
    let low = -width;
    let high = vec3f(terrain.size.x, terrain.highest, terrain.size.z) + width;
    let parallel = abs(ray.direction) < vec3f(1.0 / NEVER);
    let divisor = select(ray.direction, vec3f(1.0), parallel);
    let first = (low - ray.origin) / divisor;
    let second = (high - ray.origin) / divisor;
    let between = select(vec3f(NEVER), vec3f(-NEVER), (ray.origin >= low) & (ray.origin <= high));
    let enter = select(min(first, second), between, parallel);
    let leave_box = select(max(first, second), -between, parallel);
    let begin = max(max(max(enter.x, enter.y), enter.z), -frame.ray_start);
    let end = min(min(leave_box.x, leave_box.y), leave_box.z);
    if begin > end {
        return vec4f(NEVER, 0.0, 0.0, 0.0);
    }

    let scale = vec3f(terrain.cells_per_unit.x, 1.0, terrain.cells_per_unit.y);
    let origin = (ray.origin + ray.direction * begin) * scale;
    let direction = ray.direction * scale;
    let depth = frame.ray_start + begin;
    let course = course_along(direction.xz);
    // Level l of this walk reads level l + 1.
    let top = terrain.top_level - 1u;
    var walk = Walk(0.0, top, vec2i(floor(origin.xz)) >> vec2u(top), 0u);
    while walk.steps < terrain.step_cap {
        walk.steps += 1u;
        let walls = walls_ahead(walk, course, origin.xz);
        let leave = max(min(min(walls.x, walls.y), end - begin), walk.t);
        let reach = (footprint * (depth + leave) + margin) * scale;
        let across = max(reach.x, reach.z);
        let size = f32(1u << walk.level);
        if across > size {
            break;
        }
        let lowest = origin.y + min(direction.y * walk.t, direction.y * leave) - reach.y;
        let blocked = lowest <= height_around(walk.node, walk.level);
        if blocked && (walk.level == 0u || 2.0 * across > size) {
            break;
        }
        if !blocked && leave >= end - begin {
            return vec4f(NEVER, 0.0, 0.0, 0.0);
        }
        let behind = node_behind(walk, course, walls);
        walk = next_node(walk, origin.xz, direction.xz, behind, leave, blocked, top);
    }
    return vec4f(begin + walk.t, f32(walk.level + 1u), 0.0, 0.0);
}
