// A walk over the nodes of the maximum pyramid: level l has nodes of 2^l × 2^l cells. Level 0 is not stored: its
// maximum is that of the four corners, which the patch needs anyway. Mip m of the texture is level m + 1.
#define_import_path relief::pyramid

#import relief::heightfield::terrain

@group(1) @binding(3) var pyramid: texture_2d<f32>;

// A ray that is parallel to an axis gets this reciprocal: large, but finite, so that 0 · RECIPROCAL_OF_ZERO is 0.
const RECIPROCAL_OF_ZERO: f32 = 1e30;

fn reciprocal(x: f32) -> f32 {
    if abs(x) < 1.0 / RECIPROCAL_OF_ZERO {
        return RECIPROCAL_OF_ZERO;
    }
    return 1.0 / x;
}

// Highest ground of a node, world units; `level` is at least 1.
fn node_height(node: vec2i, level: u32) -> f32 {
    return textureLoad(pyramid, node, i32(level) - 1).r * terrain.size.y + terrain.layer_rise;
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

fn course_along(direction: vec2f) -> Course {
    let inverse = vec2f(reciprocal(direction.x), reciprocal(direction.y));
    // A ray without a direction along an axis counts as going up: its wall is then RECIPROCAL_OF_ZERO away, or at 0.
    return Course(inverse, vec2i(inverse >= vec2f(0.0)));
}

// Parameters of the walls through which the ray leaves `walk.node`.
fn walls_ahead(walk: Walk, course: Course, origin: vec2f) -> vec2f {
    return (vec2f((walk.node + course.forward) << vec2u(walk.level)) - origin) * course.inverse;
}

// The node behind the nearer wall. It is stepped as an integer, never found again from the position.
fn node_behind(walk: Walk, course: Course, walls: vec2f) -> vec2i {
    let step = 2 * course.forward - 1;
    return walk.node + select(vec2i(0, step.y), vec2i(step.x, 0), walls.x <= walls.y);
}

// The walk after a node: into the child that the ray is in where the node is `blocked`, else at `leave` into the node
// `behind`, and up a level, at most to `top`, where the wall between is also the parent's. Selections, not branches:
// where rays are drawn in step, a branch costs both its sides and the switching.
fn next_node(walk: Walk, origin: vec2f, direction: vec2f, behind: vec2i, leave: f32, blocked: bool, top: u32)
    -> Walk {
    // The child is found from the position and then clamped into its parent.
    let finer = max(walk.level, 1u) - 1u;
    let place = vec2i(floor(origin + direction * walk.t)) >> vec2u(finer);
    let child = clamp(place, 2 * walk.node, 2 * walk.node + 1);
    let parent = behind >> vec2u(1u);
    let up = walk.level < top && any(parent != (walk.node >> vec2u(1u)));
    return Walk(
        select(leave, walk.t, blocked),
        select(select(walk.level, walk.level + 1u, up), finer, blocked),
        select(select(behind, parent, up), child, blocked),
        walk.steps,
    );
}
