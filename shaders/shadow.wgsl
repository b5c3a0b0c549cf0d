// How much of the sun's disc is seen from a place: a walk through the maximum pyramid towards the sun, exact for the
// bilinear ground.
//
// The ground has no overhangs, so that along one compass direction just what lies below its horizon is hidden. The walk
// finds that horizon: it begins with the ray to the lower edge of the sun and lifts it over whatever stands in its way.
// In a cell that is the greatest slope (ground − place) / way of the patch over the ray, which has a closed form; a node
// that lies below the ray is passed over. The walk ends where the ray has passed the sun's upper edge: all is hidden.
//
// A place on the ground cannot hide itself by a rounding: its own patch is a polynomial of the way whose constant is 0,
// not a difference of heights, and as far as CARRIED_CELLS each further patch begins with the height at which the one
// before it ended. No offset from the surface is needed. Farther away heights are those over the box's floor, whose
// rounding is less than SIZE_OF_BOX · 2^-23 and counts divided by the way.
#define_import_path relief::shadow

#import relief::constants::MOST_STEPS
#import relief::sun::{COLUMNS, CARRIED_CELLS}
#import relief::light::light
#import relief::heightfield::{terrain, cell_corners, bilinear}
#ifdef HOLES
#import relief::heightfield::has_ground
#endif
#import relief::pyramid::{
    RECIPROCAL_OF_ZERO, Course, Walk, course_along, start, node_of, node_height, moved_on, either,
}

// A place that light falls on.
struct Place {
    cell: vec2f,
    // Where in the cell.
    within: vec2f,
    // World units.
    height: f32,
}

// The steepest slope that is told from upright; its square is a finite number.
const STEEPEST: f32 = 1e15;

// The place of the ground at `within` of `cell`.
fn place_on_ground(cell: vec2f, within: vec2f) -> Place {
    return Place(cell, within, bilinear(cell_corners(cell), within));
}

// Parameters at which a ray from `place` reaches walls, whole numbers of cells, along the two axes.
fn reached_from(place: Place, course: Course, walls: vec2f) -> vec2f {
    let along = ((walls - course.sign * place.cell) - course.sign * place.within) * course.inverse;
    // A ray that is parallel to an axis never reaches a wall across it, even where it runs along one.
    return select(along, vec2f(RECIPROCAL_OF_ZERO), course.inverse == vec2f(RECIPROCAL_OF_ZERO));
}

// Ground along a ray: over the place it comes from, its slope there, and how that changes.
struct Profile {
    rise: f32,
    grade: f32,
    bend: f32,
}

// The patch over `corners`, `p` in its cell, along `direction`; `rise` is the ground there over the place.
fn profile(corners: vec4f, p: vec2f, direction: vec2f, rise: f32) -> Profile {
    let k = corners.x - corners.y - corners.z + corners.w;
    let along_x = corners.y - corners.x + k * p.y;
    let along_z = corners.z - corners.x + k * p.x;
    return Profile(rise, along_x * direction.x + along_z * direction.y, k * direction.x * direction.y);
}

fn rise_after(ground: Profile, way: f32) -> f32 {
    return ground.rise + way * (ground.grade + ground.bend * way);
}

// The greatest slope from the place to this ground, which begins at the way `begin` from it and ends at `end`, or
// `least`, if that is more.
fn steepest(ground: Profile, begin: f32, end: f32, least: f32) -> f32 {
    var slope = least;
    if begin > 0.0 {
        slope = max(slope, ground.rise / begin);
    } else {
        // On the ground its slope counts; a place above it sees nothing below itself, one below it nothing at all.
        slope = max(slope, select(select(-STEEPEST, STEEPEST, ground.rise > 0.0), ground.grade, ground.rise == 0.0));
    }
    if end > begin {
        slope = max(slope, rise_after(ground, end - begin) / end);
    }
    // The slope to the ground at the way t is constant/t + linear + bend·t: it has a summit where both others fall.
    let constant = ground.rise - begin * (ground.grade - ground.bend * begin);
    if constant < 0.0 && ground.bend < 0.0 {
        let summit = sqrt(constant / ground.bend);
        if summit > begin && summit < end {
            slope = max(slope, rise_after(ground, summit - begin) / summit);
        }
    }
    return slope;
}

// Slope of the horizon that the ground makes for `place` along the unit vector `toward`; `least` where it is lower.
// Beyond `most` it does not matter how high it is.
fn horizon(place: Place, toward: vec2f, least: f32, most: f32) -> f32 {
    let direction = toward * terrain.cells_per_unit;
    let course = course_along(vec2f(0.0), direction);
    let way_of_a_cell = 1.0 / max(abs(direction.x), abs(direction.y));
    let highest = terrain.highest - place.height;
    var slope = least;
    var carried = 0.0;
#ifdef FROM_OUTSIDE
    // A place beside the map, or above or below its ground.
    let north_west = reached_from(place, course, vec2f(0.0));
    let south_east = reached_from(place, course, course.sign * terrain.cells);
    let enter = max(max(min(north_west.x, south_east.x), min(north_west.y, south_east.y)), 0.0);
    if enter > min(max(north_west.x, south_east.x), max(north_west.y, south_east.y)) {
        return slope;
    }
    let at = place.cell + floor(place.within + direction * enter);
    var walk = start(course, clamp(at, vec2f(0.0), terrain.cells - 1.0), enter, 1.0);
    var is_carried = false;
#else
    var walk = start(course, place.cell, 0.0, 1.0);
    var is_carried = place.height == bilinear(cell_corners(place.cell), place.within);
#endif
    let most_steps = min(terrain.step_cap, MOST_STEPS);
    while walk.steps < most_steps {
        walk.steps += 1u;
        let walls = walk.wall * walk.size;
        let ahead = reached_from(place, course, walls);
        let through_x = ahead.x <= ahead.y;
        let leave = max(select(ahead.y, ahead.x, through_x), walk.t);
        let node = node_of(course, walk);
        var goes_down = false;
        if walk.size > 1.0 {
            goes_down = node_height(node, walk.size) - place.height > slope * walk.t;
            is_carried = false;
        } else {
            let corners = cell_corners(node);
            let p = clamp((place.cell - node) + place.within + direction * walk.t, vec2f(0.0), vec2f(1.0));
            let rise = select(bilinear(corners, p) - place.height, carried, is_carried);
            let ground = profile(corners, p, direction, rise);
            carried = rise_after(ground, leave - walk.t);
            is_carried = true;
#ifdef HOLES
            if has_ground(corners) {
                slope = steepest(ground, walk.t, leave, slope);
            } else {
                is_carried = false;
            }
#else
            slope = steepest(ground, walk.t, leave, slope);
#endif
        }
        let ends = select(walls.y >= course.border.y, walls.x >= course.border.x, through_x)
            || slope * leave >= highest || slope > most;
        if ends && !goes_down {
            break;
        }
        // The child that the ray is in; not one beyond the map's border.
        let middle = walls - 0.5 * walk.size;
        let first = (vec2f(walk.t) < reached_from(place, course, middle)) | (middle >= course.border);
        let within = Walk(walk.t, 0.5 * walk.size, 2.0 * walk.wall - vec2f(first), walk.steps);
        let top = select(terrain.top_size, 1.0, leave < CARRIED_CELLS * way_of_a_cell);
        walk = either(moved_on(walk, through_x, leave, top), within, goes_down);
    }
    return slope;
}

// Sine of the elevation whose tangent is `slope`.
fn sine(slope: f32) -> f32 {
    let finite = clamp(slope, -STEEPEST, STEEPEST);
    return finite * inverseSqrt(1.0 + finite * finite);
}

#ifdef OCCLUDER_SHADOW
// Slopes between which something is seen: none as long as the first is greater.
fn widened(slopes: vec2f, a: vec3f, b: vec3f) -> vec2f {
    // `x` is the way along the ground, `y` the height and `z` the distance from the upright plane, of both ends of an edge.
    let share = a.z / (a.z - b.z);
    let way = mix(a.x, b.x, share);
    let slope = clamp(mix(a.y, b.y, share) / max(way, 1.0 / STEEPEST), -STEEPEST, STEEPEST);
    // What lies behind hides nothing ahead.
    let crosses = (a.z < 0.0) != (b.z < 0.0) && way > 0.0;
    return select(slopes, vec2f(min(slopes.x, slope), max(slopes.y, slope)), crosses);
}

// Slopes between which the occluder is seen from `spot`, world space, along the unit vector `toward`: a plane cuts it in
// a convex polygon, whose corners lie on its edges. Where the polygon reaches over or under `spot`, it reaches to
// upright.
fn occluder_between(spot: vec3f, toward: vec2f) -> vec2f {
    let along = vec3f(toward.x, 0.0, toward.y);
    let across = vec3f(-toward.y, 0.0, toward.x);
    let c0 = light.cube[0].xyz - spot;
    let c1 = light.cube[1].xyz - spot;
    let c2 = light.cube[2].xyz - spot;
    let c3 = light.cube[3].xyz - spot;
    let c4 = light.cube[4].xyz - spot;
    let c5 = light.cube[5].xyz - spot;
    let c6 = light.cube[6].xyz - spot;
    let c7 = light.cube[7].xyz - spot;
    let p0 = vec3f(dot(c0, along), c0.y, dot(c0, across));
    let p1 = vec3f(dot(c1, along), c1.y, dot(c1, across));
    let p2 = vec3f(dot(c2, along), c2.y, dot(c2, across));
    let p3 = vec3f(dot(c3, along), c3.y, dot(c3, across));
    let p4 = vec3f(dot(c4, along), c4.y, dot(c4, across));
    let p5 = vec3f(dot(c5, along), c5.y, dot(c5, across));
    let p6 = vec3f(dot(c6, along), c6.y, dot(c6, across));
    let p7 = vec3f(dot(c7, along), c7.y, dot(c7, across));
    var slopes = vec2f(STEEPEST, -STEEPEST);
    // All of it lies behind.
    if max(max(max(p0.x, p1.x), max(p2.x, p3.x)), max(max(p4.x, p5.x), max(p6.x, p7.x))) <= 0.0 {
        return slopes;
    }
    slopes = widened(slopes, p0, p1);
    slopes = widened(slopes, p2, p3);
    slopes = widened(slopes, p4, p5);
    slopes = widened(slopes, p6, p7);
    slopes = widened(slopes, p0, p2);
    slopes = widened(slopes, p1, p3);
    slopes = widened(slopes, p4, p6);
    slopes = widened(slopes, p5, p7);
    slopes = widened(slopes, p0, p4);
    slopes = widened(slopes, p1, p5);
    slopes = widened(slopes, p2, p6);
    slopes = widened(slopes, p3, p7);
    // The upright line through `spot` against the three slabs of the cube, whose edges are orthogonal and of one length.
    let edges = mat3x3f(c1 - c0, c2 - c0, c4 - c0);
    let rise = vec3f(edges[0].y, edges[1].y, edges[2].y);
    let divisor = select(rise, vec3f(1.0 / STEEPEST), abs(rise) < vec3f(1.0 / STEEPEST));
    let first = (c0 * edges) / divisor;
    let second = (c0 * edges + dot(edges[0], edges[0])) / divisor;
    let low = min(first, second);
    let high = max(first, second);
    let enter = max(max(low.x, low.y), low.z);
    let leave = min(min(high.x, high.y), high.z);
    if enter <= leave {
        slopes.x = select(slopes.x, -STEEPEST, enter < 0.0);
        slopes.y = select(slopes.y, STEEPEST, leave > 0.0);
    }
    return slopes;
}
#endif

// Share of a column of the sun's disc that is seen over the horizon `slope` from `spot`, world space.
fn seen_over(slope: f32, spot: vec3f, column: vec4f, share: vec4f) -> f32 {
#ifdef OCCLUDER_SHADOW
    let occluder = occluder_between(spot, column.xy);
#endif
#ifdef SOFT_SHADOWS
    let low = clamp(sine(slope), share.y, share.z);
    var seen = share.z - low;
#ifdef OCCLUDER_SHADOW
    let covered = clamp(vec2f(sine(occluder.x), sine(occluder.y)), vec2f(low), vec2f(share.z));
    seen -= max(covered.y - covered.x, 0.0);
#endif
    return seen / (share.z - share.y);
#else
    var seen = slope <= column.w;
#ifdef OCCLUDER_SHADOW
    seen = seen && (occluder.x > column.w || occluder.y < column.w);
#endif
    return select(0.0, 1.0, seen);
#endif
}

// Share of the sun's disc that is seen from `place`, 0 to 1. Where the ground hides nothing, only the occluder counts.
fn sunlight(place: Place, ground_hides: bool) -> f32 {
    let on_map = (place.cell + place.within) / terrain.cells_per_unit;
    let spot = vec3f(on_map.x, place.height, on_map.y);
    var seen = 0.0;
    var index = 0u;
    while index < COLUMNS {
        let column = light.columns[index];
        let share = light.shares[index];
        index += 1u;
        var slope = column.z;
        if ground_hides {
            slope = horizon(place, column.xy, column.z, column.w);
        }
        seen += share.x * seen_over(slope, spot, column, share);
#ifndef SOFT_SHADOWS
        break;
#endif
    }
    return clamp(seen, 0.0, 1.0);
}
