// Cones on the map's cells, made in `heightfield/cone.rs`, where it is proven how far a ray may go on in one.
//
// They stand on the ground as it would be with holes as low as the floor. Less ground is there, so none of them is too wide;
// but a relaxed cone's promise, that a ray which enters its ground stays in it, may not hold where a hole ends the ground.
#define_import_path relief::cones

#import relief::constants::MOST_HALVINGS
#import relief::heightfield::{terrain, Segment, Hit, NO_HIT, cell_corners, bilinear}
#ifdef HOLES
#import relief::heightfield::has_ground
#endif
#import relief::sampling::sample_count

// Per cell the slope of its cone without ground and, for relaxed cones, that of its relaxed cone; normalised heights
// per cell.
@group(1) @binding(9) var cones: texture_2d<f32>;

// What a ray meets at a place.
struct Place {
    // Its height above the ground, world units.
    above: f32,
    // How far it may go on before it leaves the cone on the cell, as a parameter. 0: it is not in the cone.
    clear: f32,
}

// `channel` picks the slope.
fn place_at(ray: Segment, t: f32, channel: vec2f) -> Place {
    let p = ray.origin + ray.direction * t;
    let cell = clamp(floor(p.xz), vec2f(0.0), terrain.cells - 1.0);
    let corners = cell_corners(cell);
    let texel = clamp(vec2i(cell), vec2i(0), vec2i(terrain.cells) - 1);
    let slope = dot(textureLoad(cones, texel, 0).rg, channel) * terrain.size.y;
    let inside = p.xz - cell;
    // Height above the cell's highest corner.
    let over = p.y - max(max(corners.x, corners.y), max(corners.z, corners.w));
    // The cone's height over that corner, after a further parameter t, is the slope times what the ray has by then gone
    // beyond the cell along x plus along z: the greatest of 0, speed.x·t − to_wall.x, the same along z, and the sum of
    // both. The ray is in the cone until it meets the first of these four lines.
    let speed = abs(ray.direction.xz);
    let to_wall = max(select(inside, 1.0 - inside, ray.direction.xz >= vec2f(0.0)), vec2f(0.0));
    let closing = slope * vec4f(0.0, speed.x, speed.y, speed.x + speed.y) - ray.direction.y;
    let margin = over + slope * vec4f(0.0, to_wall.x, to_wall.y, to_wall.x + to_wall.y);
    let meets = select(vec4f(ray.end), margin / closing, closing > vec4f(0.0));
    let clear = min(min(meets.x, meets.y), min(meets.z, meets.w));
    let above = p.y - bilinear(corners, inside);
#ifdef HOLES
    // Without ground there is none to be above, and no corner to measure the cone from: a uniform step.
    let stands = has_ground(corners);
    return Place(select(1e30, above, stands), select(0.0, clear, stands && over > 0.0));
#else
    return Place(above, select(0.0, clear, over > 0.0));
#endif
}

// Halvings between a point above the ground and one below it; the last point below.
fn halved(ray: Segment, last_above: f32, first_below: f32) -> f32 {
    var above = last_above;
    var below = first_below;
    let halvings = min(terrain.binary_steps, MOST_HALVINGS);
    for (var k = 0u; k < halvings; k++) {
        let middle = 0.5 * (above + below);
        let p = ray.origin + ray.direction * middle;
        let cell = clamp(floor(p.xz), vec2f(0.0), terrain.cells - 1.0);
        let corners = cell_corners(cell);
        var is_below = p.y <= bilinear(corners, p.xz - cell);
#ifdef HOLES
        is_below = is_below && has_ground(corners);
#endif
        if is_below {
            below = middle;
        } else {
            above = middle;
        }
    }
    return below;
}

// From cone to cone, each step at least as long as a uniform one of the same number of samples, then halvings.
fn step_along(ray: Segment, channel: vec2f) -> Hit {
    let count = sample_count(ray);
    let step = ray.end / count;
    var above = 0.0;
    var t = 0.0;
    // Rounding may leave a last piece of the ray after `count` steps.
    var i = 1.0;
    for (; i <= count + 2.0; i += 1.0) {
        let place = place_at(ray, t, channel);
        if place.above <= 0.0 {
            break;
        }
        if t >= ray.end {
            return Hit(NO_HIT, u32(i), 0u);
        }
        above = t;
        t = min(t + max(place.clear, step), ray.end);
    }
    if i == 1.0 {
        return Hit(0.0, 1u, 0u);
    }
    // After the loop, not in it: rays that are drawn in step would all pay whenever one of them hits.
    return Hit(halved(ray, above, t), u32(i) + terrain.binary_steps, 0u);
}
