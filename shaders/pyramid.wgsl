// A walk over the nodes of the maximum pyramid: level l has nodes of 2^l × 2^l cells. Level 0 is not stored: its
// maximum is that of the four corners, which the patch needs anyway.
//
// Walls between nodes lie at whole numbers of cells and a node's side is a power of two, so f32 holds both exactly up
// to 2^24 and the walk steps as an integer walk would, without its conversions. Along each axis positions are negated
// where the ray goes down, so that every ray goes up: the wall ahead of it is always the larger one.
#define_import_path relief::pyramid

#import relief::heightfield::{terrain, corner_sampler}

// The levels follow one another along `pyramid_stack`, level 1 first.
@group(1) @binding(3) var pyramid: texture_2d<f32>;

// A ray that is parallel to an axis gets this reciprocal: large, but finite, so that 0 · RECIPROCAL_OF_ZERO is 0.
const RECIPROCAL_OF_ZERO: f32 = 1e30;

// Where both are numbers, `select` is one instruction less on each lane than `min`, which must not return a NaN.
fn lesser(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

fn greater(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

// Exactly 1 / `power`, a power of two: a division may be rounded, and where it is floored the last bit decides.
fn reciprocal_of_power(power: f32) -> f32 {
    return bitcast<f32>(0x7f000000u - bitcast<u32>(power));
}

// Where the level of nodes of `size` cells, at least 2, begins in the texture; in texels.
fn level_place(size: f32) -> vec2f {
    // Each level is half as long as the one before: together they fill a half of the stack, then a quarter, ….
    return terrain.pyramid_stack * (1.0 - 2.0 * reciprocal_of_power(size));
}

// Highest ground of the node held there, as the texture holds it.
fn stored_height(place: vec2f) -> f32 {
    // Sampled at a texel's centre: a sampler's address costs less than that of a load, which can have any mip.
    return textureSampleLevel(pyramid, corner_sampler, place, 0.0).r;
}

// Highest ground of the node (column and row) of `size` cells, at least 2; world units.
fn node_height(node: vec2f, size: f32) -> f32 {
    return stored_height((level_place(size) + node + 0.5) * terrain.pyramid_texel) * terrain.height_unit
        + terrain.layer_rise;
}

// Highest ground of the 2 × 2 nodes of `size` cells whose first (column and row) is `first`, from −1 to the last one;
// world units. In place of nodes beyond the level's border come some others, which can only raise the result.
fn height_of_four(first: vec2f, size: f32) -> f32 {
    let shared_corner = (level_place(size) + first + 1.0) * terrain.pyramid_texel;
    let four = textureGather(0, pyramid, corner_sampler, shared_corner);
    let highest = greater(greater(four.x, four.y), greater(four.z, four.w));
    return highest * terrain.height_unit + terrain.layer_rise;
}

// What does not change along a walk.
struct Course {
    origin: vec2f,
    // Reciprocals of the direction; positive.
    inverse: vec2f,
    // −1 along an axis that is negated, and what makes a node's number of its wall's.
    sign: vec2f,
    shift: vec2f,
    // Where the map ends.
    border: vec2f,
}

// Where a walk stands.
struct Walk {
    // Parameter at which the ray is in the node.
    t: f32,
    // Side of the node in cells.
    size: f32,
    // Number of the node's wall ahead of the ray along each axis: walls of this level lie `size` cells apart.
    wall: vec2f,
    steps: u32,
}

// The course of a ray from `origin` along `direction`, grid space.
fn course_along(origin: vec2f, direction: vec2f) -> Course {
    // A ray without a direction along an axis counts as going up: its wall is then RECIPROCAL_OF_ZERO away, or at 0.
    let parallel = abs(direction) < vec2f(1.0 / RECIPROCAL_OF_ZERO);
    let down = !parallel & (direction < vec2f(0.0));
    let sign = select(vec2f(1.0), vec2f(-1.0), down);
    return Course(
        origin * sign,
        select(abs(1.0 / direction), vec2f(RECIPROCAL_OF_ZERO), parallel),
        sign,
        select(vec2f(-1.0), vec2f(0.0), down),
        select(terrain.cells, vec2f(0.0), down),
    );
}

// The walk that starts at `t` in the node of `size` that holds the grid position `p`.
fn start(course: Course, p: vec2f, t: f32, size: f32) -> Walk {
    return Walk(t, size, course.sign * (floor(p * reciprocal_of_power(size)) - course.shift), 0u);
}

// Column and row of the walk's node among those of its level.
fn node_of(course: Course, walk: Walk) -> vec2f {
    return course.sign * walk.wall + course.shift;
}

// Parameters at which the ray reaches positions along the two axes.
fn reached(course: Course, position: vec2f) -> vec2f {
    return (position - course.origin) * course.inverse;
}

// Where in the pyramid's texture the nodes on a course are held: at `base`, and from there by `along` for each wall and
// back by `fold` over the node's size. A few operations less per node than by the level's place.
struct Places {
    base: vec2f,
    along: vec2f,
    fold: vec2f,
}

fn places_on(course: Course) -> Places {
    return Places(
        (course.shift + 0.5 + terrain.pyramid_stack) * terrain.pyramid_texel,
        course.sign * terrain.pyramid_texel,
        2.0 * terrain.pyramid_stack * terrain.pyramid_texel,
    );
}

// The place of the node of `size` cells, at least 2, with these walls ahead.
fn place_of(places: Places, wall: vec2f, size: f32) -> vec2f {
    return places.base + places.along * wall - places.fold * reciprocal_of_power(size);
}

// The walk in the node behind the nearer wall, at `leave`; `through_x` says which. Where that wall is one of the node's
// parent, too, the walk goes up a level, at most to nodes of `top` cells.
fn moved_on(walk: Walk, through_x: bool, leave: f32, top: f32) -> Walk {
    let parents = 0.5 * select(walk.wall.y, walk.wall.x, through_x);
    let up = walk.size < top && parents == floor(parents);
    let next = walk.wall + select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), through_x);
    return Walk(leave, select(walk.size, 2.0 * walk.size, up), select(next, ceil(0.5 * next), up), walk.steps);
}

// One of two walks of the same number of steps. Selections, not branches: where rays are drawn in step, a branch costs
// both its sides and the switching.
fn either(if_not: Walk, if_so: Walk, condition: bool) -> Walk {
    return Walk(
        select(if_not.t, if_so.t, condition),
        select(if_not.size, if_so.size, condition),
        select(if_not.wall, if_so.wall, condition),
        if_so.steps,
    );
}
