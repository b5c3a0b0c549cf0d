// The surface: bilinear interpolation of the map's samples. Bind group 1 of the terrain pass.
//
// Grid space: x and z count cells from the north-western sample, y is the height in world units. A hit is found in
// grid space; its parameter means the same in world space.
#define_import_path relief::heightfield

struct Terrain {
    // Corners of the box in clip space, a little inflated (see `render/terrain.rs`); transformed on the CPU in f64.
    box_clip: array<vec4f, 8>,
    // Size of the box, world units.
    size: vec3f,
    // Height of the highest terrain, world units.
    highest: f32,
    // Cells along x and z.
    cells: vec2f,
    // Cells per world unit along x and z.
    cells_per_unit: vec2f,
    // Share of the map that a sample takes up along x and z.
    texel_size: vec2f,
    // How far along the pyramid's texture and in which direction its levels reach, together twice as long as level 1. In
    // texels.
    pyramid_stack: vec2f,
    // Repeats of the diffuse texture per cell along x and z.
    repeats_per_cell: vec2f,
    // Share of the pyramid's texture that a node takes up along x and z.
    pyramid_texel: vec2f,
    // Samples of the crater layer along x and z, less one.
    layer_cells: vec2f,
    // Uniform steps: fewest and most.
    samples: vec2f,
    // Side in cells of a node of the coarsest level.
    top_size: f32,
    // Highest displacement of the crater layer, world units; 0 without one.
    layer_rise: f32,
    // View depth of the box's farthest corner.
    farthest: f32,
    // Texels of the diffuse texture per world unit (one repeat).
    texel_density: f32,
    // Halvings after the first sample below the ground.
    binary_steps: u32,
    // Guard against an endless walk.
    step_cap: u32,
    heat_map_max: f32,
    repeats: f32,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    // World units per unit of what the textures of heights and of the pyramid hold.
    height_unit: f32,
    // Towards the sun.
    sun: vec3f,
    ambient: f32,
}

#ifdef FLAT_CONSTANTS
@group(1) @binding(0) var<uniform> terrain_uniform: Terrain;
var<private> terrain: Terrain;
#else
@group(1) @binding(0) var<uniform> terrain: Terrain;
#endif
@group(1) @binding(1) var heights: texture_2d<f32>;
// Clamps to the edge and does not filter: one gather reads the four corners of a cell.
@group(1) @binding(7) var corner_sampler: sampler;

#ifdef HEIGHT_SAMPLER
@group(1) @binding(2) var height_sampler: sampler;
#endif

#ifdef CRATERS_LAYERED
// Displacements of the craters as shares of the box's height, at a resolution of their own.
@group(1) @binding(4) var crater_layer: texture_2d<f32>;

// Displacement at the grid position `p`, as a share of the box's height.
fn layer_displacement(p: vec2f) -> f32 {
    let q = p / terrain.cells * terrain.layer_cells;
#ifdef FILTER_HARDWARE_LINEAR
    return textureSampleLevel(crater_layer, height_sampler, (q + 0.5) / (terrain.layer_cells + 1.0), 0.0).r;
#else
    let base = clamp(floor(q), vec2f(0.0), terrain.layer_cells - 1.0);
    let f = q - base;
    let shared_corner = (base + 1.0) / (terrain.layer_cells + 1.0);
    return bilinear(textureGather(0, crater_layer, corner_sampler, shared_corner).wzxy, f);
#endif
}
#endif

#ifdef HOLES
// A sample without a height. The texture of heights holds a number below 0 there, which no height is.
const HOLE: f32 = -1.0;

// Whether the cell with these corners (`cell_corners`) has ground: all of them hold a height.
fn has_ground(corners: vec4f) -> bool {
    return min(min(corners.x, corners.y), min(corners.z, corners.w)) >= 0.0;
}

// Whether the cell at the grid position `p` has ground.
fn is_ground(p: vec2f) -> bool {
    return has_ground(cell_corners(clamp(floor(p), vec2f(0.0), terrain.cells - 1.0)));
}
#endif

// Heights of the samples at `cell` and south-east of it: north-west, north-east, south-west, south-east. World units.
// Beyond the map's border the nearest sample counts; one that holds no height is HOLE.
fn cell_corners(cell: vec2f) -> vec4f {
    // The corner that the four texels share. It lies half a texel from where the choice of texels would change.
    let shared_corner = (cell + 1.0) * terrain.texel_size;
    let corners = textureGather(0, heights, corner_sampler, shared_corner).wzxy;
#ifdef CRATERS_LAYERED
    let west_north = clamp(cell, vec2f(0.0), terrain.cells);
    let east_south = clamp(cell + 1.0, vec2f(0.0), terrain.cells);
    let displacement = vec4f(
        layer_displacement(west_north),
        layer_displacement(vec2f(east_south.x, west_north.y)),
        layer_displacement(vec2f(west_north.x, east_south.y)),
        layer_displacement(east_south),
    );
    let displaced = corners * terrain.height_unit + displacement * terrain.size.y;
    let ground = clamp(displaced, vec4f(0.0), vec4f(terrain.size.y));
#else
    let ground = corners * terrain.height_unit;
#endif
#ifdef HOLES
    return select(ground, vec4f(HOLE), corners < vec4f(0.0));
#else
    return ground;
#endif
}

fn bilinear(corners: vec4f, f: vec2f) -> f32 {
    return mix(mix(corners.x, corners.y, f.x), mix(corners.z, corners.w, f.x), f.y);
}

// Height of the ground at the grid position `p`, world units, read the way the scene chose; far below the floor in a cell
// without ground.
fn ground_height(p: vec2f) -> f32 {
#ifdef FILTER_HARDWARE_LINEAR
    var height = textureSampleLevel(heights, height_sampler, (p + 0.5) * terrain.texel_size, 0.0).r;
#else
#ifdef FILTER_NEAREST
    let texel = clamp(vec2i(floor(p + 0.5)), vec2i(0), vec2i(terrain.cells));
    var height = textureLoad(heights, texel, 0).r;
#else
    let cell = clamp(floor(p), vec2f(0.0), terrain.cells - 1.0);
    let f = p - cell;
    let shared_corner = (cell + 1.0) * terrain.texel_size;
    var height = bilinear(textureGather(0, heights, corner_sampler, shared_corner).wzxy, f);
#endif
#endif
    height *= terrain.height_unit;
#ifdef CRATERS_LAYERED
    height = clamp(height + layer_displacement(p) * terrain.size.y, 0.0, terrain.size.y);
#endif
#ifdef HOLES
    // Within a cell that has ground no filter blends in a hole.
    height = select(-1e30, height, is_ground(p));
#endif
    return height;
}

// A piece of a ray in grid space, beginning where the ray enters the box.
struct Segment {
    origin: vec3f,
    direction: vec3f,
    // Parameter where the ray leaves the box.
    end: f32,
    // |cosine| of the angle between the ray and the vertical, in world space.
    verticality: f32,
#ifdef BEAM
    // Parameter before which the ray meets nothing, and the side in cells of the node to begin in.
    begin: f32,
    size: f32,
#endif
}

// The parameter of a ray that meets nothing.
#ifdef DEEP_ZOOM
// Parameters count from the anchor there, and may be negative.
const NO_HIT: f32 = 1e30;
#else
const NO_HIT: f32 = -1.0;
#endif

struct Hit {
    // Parameter along the segment, or NO_HIT.
    at: f32,
    // Places where the height field was read or a node was visited.
    steps: u32,
    // 1 where the walk was cut off by `step_cap`.
    capped: u32,
}
