// The beam passes: one fragment per tile of pixels finds a depth before which none of the tile's rays meets the ground, so
// that they need not all walk there. First for coarse tiles; with REFINES for fine ones, which go on where the coarse one
// that holds them stopped.
//
// At the view depth z the rays of a tile lie within a parallelogram around the tile's central ray: along each axis
// within `footprint · z`. The walk follows the central ray, and takes at each node the maximum over all the nodes that
// a ray of the tile can be in.

#ifdef REFINES
#import relief::beam::{COARSE_TILE, FINE_TILE as TILE}
#else
#import relief::beam::COARSE_TILE as TILE
#endif
#import relief::constants::MOST_STEPS
#import relief::frame::{FOR_EVER, frame, pixel_ray, slabs}
#import relief::heightfield::terrain
#import relief::pyramid::{
    Walk, lesser, greater, course_along, start, node_of, height_of_four, reached, moved_on, either,
    reciprocal_of_power,
}
#import relief::varyings

#ifdef REFINES
// What this pass found for the coarse tiles.
@group(1) @binding(8) var coarse: texture_2d<f32>;
#endif

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> varyings::Varyings {
    // One triangle that covers the screen.
    return varyings::at(vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0));
}

// Share of the box's size that is added to the beam's width on each side, against rounding.
const MARGIN: f32 = 1e-5;

// Highest ground that the rays can be over while the central one is in `node` and they are within the node's own size
// of it: of the 2 × 2 nodes, one level up, around the node's nearest corner of that level. Nodes beyond the map count
// as those at its border.
fn height_around(node: vec2f, size: f32) -> f32 {
    let double = 2.0 * size;
    let last = floor((terrain.cells - 1.0) * reciprocal_of_power(double));
    return height_of_four(clamp(floor(0.5 * (node - 1.0)), vec2f(-1.0), last), double);
}

// Texels that a step looks at.
const READS_PER_STEP: f32 = 4.0;

// Parameter at which the tile's rays may start (FOR_EVER: none of them meets the ground), the side in cells of the node to
// start in, and, for who counts them, the tile's texel reads with its share of the coarse tile's.
@fragment
fn fs_main(in: varyings::Varyings) -> @location(0) vec4f {
    varyings::receive(in);
#ifdef REFINES
    let last_tile = vec2i(textureDimensions(coarse)) - 1;
    let before = textureLoad(coarse, min(vec2i(in.position.xy * (TILE / COARSE_TILE)), last_tile), 0);
#ifdef COUNT_READS
    let shared_reads = before.b * (TILE / COARSE_TILE) * (TILE / COARSE_TILE) + 1.0;
#else
    let shared_reads = 0.0;
#endif
    if before.r == FOR_EVER {
        return vec4f(FOR_EVER, 0.0, shared_reads, 0.0);
    }
#else
    let shared_reads = 0.0;
#endif
    let ray = pixel_ray(in.position.xy * TILE);
    // Half a tile reaches to the outer pixels' edges: half a pixel more than their rays need.
    let footprint = 0.5 * TILE * (abs(frame.ray_direction_right) + abs(frame.ray_direction_down));
    let margin = MARGIN * max(max(terrain.size.x, terrain.size.z), terrain.size.y);

    // The box, widened by the beam at the box's farthest corner: outside of it no ray of the tile
    // is in the box.
    let width = footprint * terrain.farthest + margin;
    let faces = slabs(ray, vec3f(-width), vec3f(terrain.size.x, terrain.highest, terrain.size.z) + width);
    let enter = faces.enter;
    let leave_box = faces.leave;
    let begin = max(max(max(enter.x, enter.y), enter.z), -frame.ray_start);
    let end = min(min(leave_box.x, leave_box.y), leave_box.z);
    if begin > end {
        return vec4f(FOR_EVER, 0.0, shared_reads, 0.0);
    }

    let scale = vec3f(terrain.cells_per_unit.x, 1.0, terrain.cells_per_unit.y);
    let origin = (ray.origin + ray.direction * begin) * scale;
    let direction = ray.direction * scale;
    let depth = frame.ray_start + begin;
    let course = course_along(origin.xz, direction.xz);
    let falling = direction.y < 0.0;
    let per_height = select(0.0, 1.0 / direction.y, falling);
    // A node of this walk reads those one level up.
    let top = 0.5 * terrain.top_size;
#ifdef REFINES
    let from_start = max(before.r - begin, 0.0);
    var walk = start(course, origin.xz + direction.xz * from_start, from_start, min(0.5 * before.g, top));
#else
    var walk = start(course, origin.xz, 0.0, top);
#endif
    let most_steps = min(terrain.step_cap, MOST_STEPS);
    while walk.steps < most_steps {
        walk.steps += 1u;
        let ahead = reached(course, walk.wall * walk.size);
        let through_x = ahead.x <= ahead.y;
        let leave = greater(lesser(select(ahead.y, ahead.x, through_x), end - begin), walk.t);
        let reach = (footprint * (depth + leave) + margin) * scale;
        let across = greater(reach.x, reach.z);
        if across > walk.size {
            break;
        }
        let lowest = origin.y + direction.y * select(walk.t, leave, falling) - reach.y;
        let height = height_around(node_of(course, walk), walk.size);
        let blocked = lowest <= height;
        // Falling rays meet nothing here before the lowest of them is as low as the highest ground.
        let low_enough = lesser(greater((height + reach.y - origin.y) * per_height, walk.t), leave);
        if blocked && (walk.size == 1.0 || 2.0 * across > walk.size) {
            walk.t = low_enough;
            break;
        }
        if !blocked && leave >= end - begin {
            return vec4f(FOR_EVER, 0.0, shared_reads + READS_PER_STEP * f32(walk.steps), 0.0);
        }
        let first = vec2f(low_enough) < reached(course, (walk.wall - 0.5) * walk.size);
        let within = Walk(low_enough, 0.5 * walk.size, 2.0 * walk.wall - vec2f(first), walk.steps);
        walk = either(moved_on(walk, through_x, leave, top), within, blocked);
    }
    return vec4f(begin + walk.t, 2.0 * walk.size, shared_reads + READS_PER_STEP * f32(walk.steps), 0.0);
}
