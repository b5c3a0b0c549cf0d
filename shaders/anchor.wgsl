// Deep zooms: the rays of a view whose pixels are finer than f32 resolves the box, counted from an anchor at the ground
// that is seen (`render/anchor.rs`). Where some of it lies far behind other there are several of them, and a ray is cast
// piece by piece, each counted from the nearest.
//
// Anchored space counts cells along x and z and shares of the box's height up, all from the anchor; a parameter along a
// ray is a view depth less the anchor's. Near the anchor all of them are small, and f32 resolves them finely.
#define_import_path relief::anchor

#import relief::frame::{frame, Ray}

struct Anchor {
    // Where the central ray is at the anchor's depth, and its change per pixel to the right and down.
    origin: vec3f,
    // View depth of the anchor.
    depth: f32,
    origin_right: vec3f,
    // The anchor's parameter along the rays of `frame`.
    beam_shift: f32,
    origin_down: vec3f,
    // Parameters between which rays count from this anchor.
    begin: f32,
    // Direction of the central ray, and its change per pixel.
    direction: vec3f,
    // The anchor's height over the floor.
    height: f32,
    direction_right: vec3f,
    // The heights' texture holds whole numbers of 1/units in 16 bits; 0: shares of the box's height.
    units: f32,
    direction_down: vec3f,
    // Height of the box: 1, but for the lowest boxes.
    relief: f32,
    // The box.
    low: vec3f,
    // Units of height per world unit.
    shares_per_unit: f32,
    high: vec3f,
    end: f32,
    // The anchor's cell, and where in it the anchor is.
    cell: vec2f,
    fraction: vec2f,
    // Height over the anchor of the patch of its own cell, in the middle, and of those beside it, continued to its place:
    // the cells of a row in a vector.
    grounds: array<vec4f, 3>,
}

// The anchors along the view, the nearest first. Those that are not needed have no parameters between begin and end.
const MOST_ANCHORS: u32 = 4u;
@group(1) @binding(14) var<uniform> anchors: array<Anchor, 4>;

// The anchor that a fragment's ray counts from. A copy: a software rasteriser reads a uniform lane by lane, again in each
// turn of a loop.
var<private> anchor: Anchor;

// Makes the anchor with this number known to a fragment; call it first.
fn receive(index: u32) {
    anchor = anchors[min(index, MOST_ANCHORS - 1u)];
}

// Whether rays count from the anchor with this number, too.
fn is_needed(index: u32) -> bool {
    let last = min(index, MOST_ANCHORS - 1u);
    return anchors[last].begin <= anchors[last].end;
}

// The ray through a fragment's centre, in anchored space.
fn anchored_ray(position: vec2f) -> Ray {
    let offset = position - vec2f(frame.centre_x, frame.centre_y);
    return Ray(
        anchor.origin + (offset.x * anchor.origin_right + offset.y * anchor.origin_down),
        anchor.direction + (offset.x * anchor.direction_right + offset.y * anchor.direction_down),
    );
}

// The cell that a place is in, and the place's coordinates there.
struct Place {
    cell: vec2f,
    within: vec2f,
}

// The cell at `p`, anchored space, of a map of so many cells.
fn place_at(p: vec2f, cells: vec2f) -> Place {
    let from_cell = anchor.fraction + p;
    let cell = clamp(anchor.cell + floor(from_cell), vec2f(0.0), cells - 1.0);
    return Place(cell, (anchor.cell - cell) + from_cell);
}

// Height over the anchor of a patch, continued to the anchor's place: that of the cell which the anchor's is `from_cell`
// away from, at most one along each axis.
fn ground_beside_anchor(from_cell: vec2f) -> f32 {
    let index = vec2u(vec2i(1 - vec2i(from_cell)));
    return anchor.grounds[min(index.y, 2u)][min(index.x, 2u)];
}
