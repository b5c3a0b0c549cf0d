// The terrain pass: the back faces of the box are drawn, so that it works from inside and out, and each fragment casts
// its ray through the height field.

#import relief::frame::{frame, Ray, pixel_ray, slabs, cube_corner}
#ifdef DEEP_ZOOM
#import relief::anchor
#endif
#import relief::constants::NEAR
#ifdef BEAM
#import relief::beam::FINE_TILE
#endif
#import relief::srgb::from_srgb
#import relief::heightfield::{terrain, Segment, Hit, NO_HIT}
#ifdef HOLES
#import relief::heightfield::{cell_corners, has_ground, is_ground}
#endif
#ifdef FLAT_CONSTANTS
#import relief::heightfield::terrain_uniform
#endif
#import relief::varyings
#ifndef VIEW_POSITION
#ifndef GIVEN_DISTANCES
#import relief::march::march
#endif
#endif
#ifdef FRACTAL_SURFACE
#import relief::fractal
#endif
#ifndef VIEW_POSITION
#import relief::ground
#endif
#ifdef ATMOSPHERE
#import relief::air
#endif
#ifdef VIEW_STEPS
#import relief::heat_map::heat_map
#endif

#ifdef VIEW_ERROR
#import relief::heat_map::{error_colour, SEE_THROUGH, COVERS_SKY}
// Per pixel: the exact distance from the eye to the ground in world units, below zero where there is none.
@group(1) @binding(13) var exact_distances: texture_2d<f32>;
#endif

#ifdef BEAM
// Per tile of pixels: parameter where its rays may start, and the side in cells of the node to start in.
@group(1) @binding(8) var beams: texture_2d<f32>;
#endif

#ifdef DEEP_ZOOM
// Share of a beam's start that it is put back: more than its rounding on the way to the anchor's parameters.
const BEAM_SLACK: f32 = 1e-6;
#endif

#ifdef GIVEN_DISTANCES
// Per pixel: distance from the eye to the ground in world units, below zero where there is none.
@group(1) @binding(12) var given_distances: texture_2d<f32>;

// Rounding of a distance, as a share of it and of the box's size.
const ROUNDING: f32 = 1e-6;

// What a march would have found along a ray of the view depth `begin`, according to the given distances.
fn given_hit(pixel: vec2f, begin: f32, length_of_direction: f32) -> Hit {
    let last = vec2i(textureDimensions(given_distances)) - 1;
    let distance = textureLoad(given_distances, min(vec2i(pixel), last), 0).r;
    let depth = distance / length_of_direction;
    // A hit where the ray comes in is the box's side: it must stay one, whatever rounding did to its distance.
    let tolerance = ROUNDING * (depth + max(terrain.size.x, terrain.size.z));
    let at = depth - begin;
    return Hit(select(select(at, 0.0, at < tolerance), NO_HIT, distance < 0.0), 0u, 0u);
}
#endif

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> varyings::Varyings {
#ifdef FLAT_CONSTANTS
    return varyings::at(terrain_uniform.box_clip[index]);
#else
    var out = varyings::at(terrain.box_clip[index]);
#ifdef VIEW_POSITION
    out.corner = cube_corner(index);
#endif
    return out;
#endif
}

struct Fragment {
    // The picture, linear light; or, for a probe: distance, steps, capped (and twice the number of the anchor), view depth
    // beyond that from which the ray counts.
    @location(0) color: vec4f,
#ifndef VIEW_POSITION
    @builtin(frag_depth) depth: f32,
#endif
}

#ifdef VIEW_POSITION

// The study's fixed-function shader: no ray, only where on the cube the fragment lies.
@fragment
fn fs_main(in: varyings::Varyings) -> Fragment {
    return Fragment(vec4f(from_srgb(in.corner), 1.0));
}

#else

// The part of a ray inside the box, and the axis of the face it comes in through (3: it starts inside).
struct Span {
    begin: f32,
    end: f32,
    axis: u32,
    // Whether it ends on the floor.
    to_floor: bool,
}

fn clip_to_box(ray: Ray) -> Span {
#ifdef DEEP_ZOOM
    let faces = slabs(ray, anchor::anchor.low, anchor::anchor.high);
#else
#ifdef LOWER_START
    let top = terrain.highest;
#else
    let top = terrain.size.y;
#endif
    let faces = slabs(ray, vec3f(0.0), vec3f(terrain.size.x, top, terrain.size.z));
#endif
    let enter = faces.enter;
    let leave = faces.leave;
    let end = min(min(leave.x, leave.y), leave.z);
    let into = max(max(enter.x, enter.y), enter.z);
#ifdef DEEP_ZOOM
    let outside = into > -anchor::anchor.depth;
#else
    let outside = into > -frame.ray_start;
#endif
    let axis = select(select(2u, 1u, enter.y == into), 0u, enter.x == into);
#ifdef DEEP_ZOOM
    let begin = select(-anchor::anchor.depth, into, outside);
#else
    let begin = select(-frame.ray_start, into, outside);
#endif
    return Span(begin, end, select(3u, axis, outside), ray.direction.y < 0.0 && leave.y == end);
}

#ifdef DEEP_ZOOM
// A point of anchored space in grid space, as finely as that can be.
fn anchored_point_in_grid(p: vec3f) -> vec3f {
    let place = anchor::place_at(p.xz, terrain.cells);
    let xz = place.cell + place.within;
    return vec3f(xz.x, (anchor::anchor.height + p.y) / anchor::anchor.shares_per_unit, xz.y);
}

// What is met by the piece of the ray that counts from the present anchor.
fn anchored_hit(ray: Ray, span: Span, beam: vec4f, verticality: f32) -> Hit {
    // The ground is nowhere below the floor: a ray that comes in through it is in the ground, whatever rounding says.
    var through_floor = span.axis == 1u && ray.direction.y > 0.0;
#ifdef HOLES
    let entry = anchor::place_at(ray.origin.xz + ray.direction.xz * span.begin, terrain.cells);
    through_floor = through_floor && has_ground(cell_corners(entry.cell));
#endif
    if through_floor {
        return Hit(span.begin, 1u, 0u);
    }
    let shift = anchor::anchor.beam_shift;
    let from_beam = beam.r - shift - BEAM_SLACK * (abs(beam.r) + abs(shift));
    let begin = max(max(from_beam, span.begin), anchor::anchor.begin);
    let end = min(span.end, anchor::anchor.end);
    return march(Segment(ray.origin, ray.direction, end, verticality, begin, beam.g));
}
#endif

// What a ray has met at `p`, in the space that its march counts in.
fn met_at(p: vec3f, at_entry: bool, axis: u32, depth: f32) -> ground::Met {
#ifdef DEEP_ZOOM
    let place = anchor::place_at(p.xz, terrain.cells);
    return ground::Met(anchored_point_in_grid(p), place.cell, place.within, at_entry, axis, depth);
#else
    let cell = clamp(floor(p.xz), vec2f(0.0), terrain.cells - 1.0);
    return ground::Met(p, cell, p.xz - cell, at_entry, axis, depth);
#endif
}

@fragment
fn fs_main(in: varyings::Varyings) -> Fragment {
    varyings::receive(in);
    let ray = pixel_ray(in.position.xy);
#ifdef DEEP_ZOOM
    anchor::receive(0u);
    var anchored = anchor::anchored_ray(in.position.xy);
    var span = clip_to_box(anchored);
#else
    let span = clip_to_box(ray);
#endif
    if span.begin > span.end {
        discard;
    }
    let length_of_direction = length(ray.direction);
#ifndef DEEP_ZOOM
    let scale = vec3f(terrain.cells_per_unit.x, 1.0, terrain.cells_per_unit.y);
    let inside = terrain.cells;
    var origin = (ray.origin + ray.direction * span.begin) * scale;
    // Through the floor a ray comes in at its very height: rounded to a little above, it would miss ground that lies on it.
    let height = select(origin.y, 0.0, span.axis == 1u && ray.direction.y > 0.0);
    origin = vec3f(clamp(origin.x, 0.0, inside.x), height, clamp(origin.z, 0.0, inside.y));
    let direction = ray.direction * scale;
#endif
    let verticality = abs(ray.direction.y) / length_of_direction;
#ifdef BEAM
    let last_tile = vec2i(textureDimensions(beams)) - 1;
    let beam = textureLoad(beams, min(vec2i(in.position.xy) / i32(FINE_TILE), last_tile), 0);
#ifndef DEEP_ZOOM
    let begin = max(beam.r - span.begin, 0.0);
    let segment = Segment(origin, direction, span.end - span.begin, verticality, begin, beam.g);
#endif
#else
    let segment = Segment(origin, direction, span.end - span.begin, verticality);
#endif
#ifdef GIVEN_DISTANCES
    let hit = given_hit(in.position.xy, frame.ray_start + span.begin, length_of_direction);
    var at = hit.at;
#else
#ifdef DEEP_ZOOM
    var hit = Hit(NO_HIT, 0u, 0u);
    var turn = 0u;
    var counted_from = 0u;
    while turn < anchor::MOST_ANCHORS {
        let index = turn;
        turn += 1u;
        if hit.at != NO_HIT || hit.capped != 0u || !anchor::is_needed(index) {
            break;
        }
        counted_from = index;
        anchor::receive(index);
        anchored = anchor::anchored_ray(in.position.xy);
        span = clip_to_box(anchored);
        let steps = hit.steps;
        hit = anchored_hit(anchored, span, beam, verticality);
        hit.steps += steps;
    }
    let origin = anchored.origin;
    let direction = anchored.direction;
#else
#ifdef FRACTAL_SURFACE
    fractal::look_along(frame.ray_start + span.begin, length_of_direction);
#endif
    let hit = march(segment);
#endif
    var at = hit.at;
    // The floor is nowhere above the ground: only rounding brings a ray to it without a hit.
    var on_floor = at == NO_HIT && span.to_floor;
#ifdef HOLES
#ifdef DEEP_ZOOM
    let last_cell = anchor::place_at(origin.xz + direction.xz * span.end, terrain.cells).cell;
    on_floor = on_floor && has_ground(cell_corners(last_cell));
#else
    on_floor = on_floor && is_ground(origin.xz + direction.xz * segment.end);
#endif
#endif
    if on_floor {
#ifdef DEEP_ZOOM
        at = span.end;
#else
        at = segment.end;
#endif
    }
#endif
    let missed = at == NO_HIT;
#ifdef PROBE
    var counted = f32(hit.steps);
#ifdef COUNT_READS
    // The beam's texel, and the pixel's share of those that the beam has read.
    counted += 1.0 + beam.b / (FINE_TILE * FINE_TILE);
#endif
#endif
#ifdef VIEW_ERROR
    let last_pixel = vec2i(textureDimensions(exact_distances)) - 1;
    let exact = textureLoad(exact_distances, min(vec2i(in.position.xy), last_pixel), 0).r;
#endif
    if missed {
#ifdef DISCARD_MISSES
#ifdef PROBE
        // Steps of a ray that meets nothing count, too; its depth is that of the sky.
        return Fragment(vec4f(-1.0, counted, f32(hit.capped), 1.0), 0.0);
#else
#ifdef VIEW_STEPS
        return Fragment(vec4f(heat_map(f32(hit.steps) / terrain.heat_map_max), 1.0), NEAR / 1e30);
#else
#ifdef VIEW_ERROR
        if exact < 0.0 {
            discard;
        }
        return Fragment(vec4f(SEE_THROUGH, 1.0), min(NEAR / max(exact / length_of_direction, NEAR), 1.0));
#else
        discard;
#endif
#endif
#endif
#else
#ifdef DEEP_ZOOM
        at = span.end;
#else
        at = segment.end;
#endif
#endif
    }
#ifdef DEEP_ZOOM
    let depth = anchor::anchor.depth + at;
    let at_entry = at == span.begin;
#else
    let depth = frame.ray_start + span.begin + at;
#endif
#ifdef FRACTAL_SURFACE
    fractal::pixel_here = fractal::pixel_width(at);
#endif
    let written = min(NEAR / max(depth, NEAR), 1.0);

#ifdef PROBE
#ifdef DEEP_ZOOM
    return Fragment(vec4f(depth * length_of_direction, counted, f32(hit.capped + 2u * counted_from), at), written);
#else
    return Fragment(vec4f(depth * length_of_direction, counted, f32(hit.capped), span.begin + at), written);
#endif
#endif
#ifdef VIEW_STEPS
    return Fragment(vec4f(heat_map(f32(hit.steps) / terrain.heat_map_max), 1.0), written);
#endif
#ifdef VIEW_ERROR
    if exact < 0.0 {
        return Fragment(vec4f(COVERS_SKY, 1.0), written);
    }
    let error = abs(depth * length_of_direction - exact);
    let cells = error * max(terrain.cells_per_unit.x, terrain.cells_per_unit.y);
    return Fragment(vec4f(error_colour(cells), 1.0), written);
#endif
#ifdef VIEW_DISTANCE
    let nearness = 1.0 / (1.0 + depth * length_of_direction);
    return Fragment(vec4f(from_srgb(vec3f(nearness)), 1.0), written);
#endif
#ifdef VIEW_NORMALS
#ifdef DEEP_ZOOM
    let met = met_at(origin + direction * at, at_entry, span.axis, depth);
#else
    let met = met_at(origin + direction * at, at == 0.0, span.axis, depth);
#endif
    var normal = ground::normal_of(met, ray.direction);
#ifdef HOLES
    let cut = ground::cut_of(met, ray.direction);
    normal = select(normal, ground::normal_across(cut, ray.direction), cut != 3u);
#endif
    return Fragment(vec4f(from_srgb(0.5 * normal + 0.5), 1.0), written);
#endif
#ifdef SHADED
#ifdef DEEP_ZOOM
    let met = met_at(origin + direction * at, at_entry, span.axis, depth);
#else
    let met = met_at(origin + direction * at, at == 0.0, span.axis, depth);
#endif
    var color = ground::colour(met, ray);
#ifdef AIR
    color = air::through(color, ray.direction, depth, met.point.y, in.position.xy);
#endif
    return Fragment(vec4f(color, 1.0), written);
#endif
}

#endif
