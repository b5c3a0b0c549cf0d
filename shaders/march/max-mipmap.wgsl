// Exact: maximum mipmap traversal (Tevs, Ihrke, Seidel 2008) over whole nodes, with the bilinear patch solved at the
// cells.
#define_import_path relief::march

#import relief::constants::MOST_STEPS
#import relief::heightfield::{terrain, Segment, Hit, NO_HIT, cell_corners, bilinear}
#ifdef HOLES
#import relief::heightfield::has_ground
#endif
#ifdef SMOOTH_SURFACE
#import relief::smooth::meet_smooth
#endif
#ifdef FRACTAL_SURFACE
#import relief::fractal
#endif
#import relief::pyramid::{
    RECIPROCAL_OF_ZERO, Walk, lesser, greater, course_along, start, node_of, places_on, place_of, stored_height, reached, moved_on, either,
}

// A falling ray is stopped short of the height at which it may first meet the ground of a node by this share of its
// fall: more than the rounding of that place.
const SHORT: f32 = 1e-6;

#ifndef SMOOTH_SURFACE
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
    let approaching = linear <= 0.0;
    let t = select(-(linear + root), 2.0 * c, approaching) / select(2.0 * quadratic, root - linear, approaching);
    let meets = discriminant >= 0.0 && t >= 0.0 && t <= length;
    let first = select(select(NO_HIT, t, meets), 0.0, c <= 0.0);
#ifdef HOLES
    return select(NO_HIT, first, has_ground(corners));
#else
    return first;
#endif
}
#endif

fn march(ray: Segment) -> Hit {
    if ray.begin > ray.end {
        // The beam reaches the end of the box, or passes it by.
#ifdef COUNT_READS
        return Hit(NO_HIT, 0u, 0u);
#else
        return Hit(NO_HIT, 1u, 0u);
#endif
    }
    let direction = ray.direction.xz;
    // A ray along the map's eastern or southern border belongs to the last cells, not to the wall behind them.
    let parallel = abs(direction) < vec2f(1.0 / RECIPROCAL_OF_ZERO);
    let before_border = terrain.cells * (1.0 - 1.2e-7);
    let origin = select(ray.origin.xz, min(ray.origin.xz, before_border), parallel);
    let course = course_along(origin, direction);
    let falling = ray.direction.y < 0.0;
    // Parameter per height; 0 for a ray that does not fall.
    let per_height = select(0.0, (1.0 - SHORT) / ray.direction.y, falling);
    // Heights on the ray as the pyramid's texture holds them, and less than they are by more than their rounding: a ray so
    // little above a node's highest ground counts as having met it.
    // A box without height has no unit. Any number does: all its ground is met where the rays come in.
    let per_unit = 1.0 / max(terrain.height_unit, 1.0 / RECIPROCAL_OF_ZERO);
    let slack = SHORT * (2.0 * abs(ray.origin.y) + terrain.size.y);
    let origin_stored = (ray.origin.y - slack - terrain.layer_rise) * per_unit;
    let slope_stored = ray.direction.y * per_unit;
    // The same for a ray that falls; one that does not is below any ground when it has passed a middle.
    let origin_fallen = select(-RECIPROCAL_OF_ZERO, origin_stored, falling);
    let slope_fallen = select(0.0, slope_stored, falling);
    let places = places_on(course);
    let first_cell = clamp(floor(origin + direction * ray.begin), vec2f(0.0), terrain.cells - 1.0);
    var walk = start(course, first_cell, ray.begin, ray.size);
    let most_steps = min(terrain.step_cap, MOST_STEPS);
    while walk.steps < most_steps {
        // Down and across through the pyramid, until the ray may meet a cell. A loop of its own: where many rays walk
        // in step, none of them pays for the cells of the others here. Each turn waits for the height of one node;
        // all that does not need it is prepared meanwhile, and what the next turn's node needs is a comparison with it.
        var place = place_of(places, walk.wall, walk.size);
        while (walk.size > 1.0) & (walk.steps < most_steps) {
            walk.steps += 1u;
            let stored = stored_height(place);
            let walls = walk.wall * walk.size;
            let ahead = reached(course, walls);
            let through_x = ahead.x <= ahead.y;
            // A wall that rounding puts behind the ray must not move it backwards.
            let leave = greater(lesser(select(ahead.y, ahead.x, through_x), ray.end), walk.t);
            let lowest = origin_stored + slope_stored * select(walk.t, leave, falling);
            var onward = moved_on(walk, through_x, leave, terrain.top_size);
            let onward_place = place_of(places, onward.wall, onward.size);
            if leave >= ray.end || select(walls.y >= course.border.y, walls.x >= course.border.x, through_x) {
                onward.size = 0.0;
            }
            // The child that the ray is in at `walk.t`, or when it has fallen to the node's highest ground: the first one
            // along an axis if the ray has its middle ahead and the ground is higher than the ray is there. One beyond the
            // map's border, where rounding can put the end of a ray, is not entered.
            let half = 0.5 * walk.size;
            let middle = walls - half;
            let middle_at = reached(course, middle);
            let at_middle = vec2f(origin_fallen) + slope_fallen * middle_at;
            let first_above = select(
                select(vec2f(RECIPROCAL_OF_ZERO), at_middle, vec2f(walk.t) < middle_at),
                vec2f(-RECIPROCAL_OF_ZERO),
                middle >= course.border,
            );
            let last_wall = 2.0 * walk.wall;
            let last_place = place_of(places, last_wall, half);
            let first_place = last_place - places.along;
            // Only this waits for the texture.
            let first = vec2f(stored) > first_above;
            let blocked = stored >= lowest;
            place = select(onward_place, select(last_place, first_place, first), vec2<bool>(blocked));
            // It does not pass the middle in a child that ends there, or the patch would be met beyond its cell.
            let stop = select(vec2f(leave), middle_at, first);
            let height = stored * terrain.height_unit + terrain.layer_rise;
            let fallen = lesser((height - ray.origin.y) * per_height, lesser(lesser(stop.x, stop.y), leave));
            let low_enough = greater(fallen, walk.t);
            let within = Walk(low_enough, half, select(last_wall, last_wall - 1.0, first), walk.steps);
            walk = either(onward, within, blocked);
        }
        if walk.size != 1.0 {
            // The ray has left the map, or was cut off on its way to a cell.
            return Hit(select(walk.t, NO_HIT, walk.size == 0.0), walk.steps, u32(walk.size != 0.0));
        }
#ifdef COUNT_READS
        // The four corners; a node is one texel, and one step.
        walk.steps += 4u;
#else
        walk.steps += 1u;
#endif
        let ahead = reached(course, walk.wall);
        let through_x = ahead.x <= ahead.y;
        let leave = greater(lesser(select(ahead.y, ahead.x, through_x), ray.end), walk.t);
        let cell = node_of(course, walk);
        let position = (origin - cell) + direction * walk.t;
        let local = vec3f(position.x, ray.origin.y + ray.direction.y * walk.t, position.y);
#ifdef SMOOTH_SURFACE
        let hit = meet_smooth(cell, local, ray.direction, leave - walk.t);
#else
#ifdef FRACTAL_SURFACE
        var hit: f32;
        if fractal::is_plain(walk.t) {
            hit = intersect_patch(cell_corners(cell), local, ray.direction, leave - walk.t);
        } else {
            hit = fractal::meet(cell, local, ray.direction, leave - walk.t, walk.t);
        }
#else
        let hit = intersect_patch(cell_corners(cell), local, ray.direction, leave - walk.t);
#endif
#endif
        if hit >= 0.0 {
            return Hit(walk.t + hit, walk.steps, 0u);
        }
        let wall = select(walk.wall.y, walk.wall.x, through_x);
        if leave >= ray.end || wall >= select(course.border.y, course.border.x, through_x) {
            return Hit(NO_HIT, walk.steps, 0u);
        }
        // Near the ground a node of 2 × 2 cells would mostly lead straight back down: it is tried every eight cells.
        let eight = 0.125 * wall;
        walk = moved_on(walk, through_x, leave, select(1.0, 2.0, eight == floor(eight)));
    }
    return Hit(walk.t, most_steps, 1u);
}
