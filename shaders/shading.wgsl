// Colour of a point on the ground: diffuse texture, Sobel normal, sun.
#define_import_path relief::shading

#import relief::frame::frame
#import relief::heightfield::{terrain, cell_corners}
#ifdef HOLES
#import relief::heightfield::{bilinear, has_ground}
#endif

#ifdef SKY_LIGHT
#import relief::light
#endif

#ifdef DIFFUSE_TEXTURE
@group(1) @binding(5) var diffuse_texture: texture_2d<f32>;
@group(1) @binding(6) var diffuse_sampler: sampler;
#endif

#ifdef FRACTAL_SURFACE
#import relief::fractal
#endif

#ifdef SMOOTH_SURFACE
#import relief::smooth::smooth_normal

// Normal of the ground at the grid position `p`, world space: that of the smooth surface itself.
fn ground_normal(p: vec2f) -> vec3f {
    return smooth_normal(p);
}
#else
// Weights of the Sobel operator's difference along an axis, over the four samples around the cell `first`, at the
// fraction `f` of the way from its first to its second corner. At the map's border, samples 0 and `last`, the neighbour
// beyond is the sample itself and the difference spans one cell instead of two.
fn difference_weights(first: f32, last: f32, f: f32) -> vec4f {
    let a = (1.0 - f) * select(0.5, 1.0, first == 0.0);
    let b = f * select(0.5, 1.0, first + 1.0 == last);
    return vec4f(-a, -b, a, b);
}

// Weights of its smoothing across the axis: 1, 2, 1 at each corner.
fn smoothing_weights(f: f32) -> vec4f {
    return 0.25 * vec4f(1.0 - f, 2.0 - f, 1.0 + f, f);
}

#ifdef HOLES
// How near to a wall between cells a hit counts as on it, in cells: more than the rounding of a place on the largest map.
const AT_WALL: f32 = 0.01;
// How far below the ground, as a share of the box's height: more than what that rounding makes of a cliff.
const BELOW_GROUND: f32 = 0.01;

// Axis across the wall between two cells that a ray of this direction has hit at `p`, grid space, because there is ground
// behind it and none before: the cut side of the ground around a hole. 3: it has hit the ground's surface.
fn cut_axis(p: vec3f, direction: vec3f) -> u32 {
    let cell = clamp(floor(p.xz + AT_WALL * sign(direction.xz)), vec2f(0.0), terrain.cells - 1.0);
    let corners = cell_corners(cell);
    let ground = bilinear(corners, clamp(p.xz - cell, vec2f(0.0), vec2f(1.0)));
    let to_wall = abs(p.xz - round(p.xz));
    let is_cut = has_ground(corners) && ground - p.y > BELOW_GROUND * terrain.size.y
        && min(to_wall.x, to_wall.y) < AT_WALL;
    return select(3u, select(2u, 0u, to_wall.x < to_wall.y), is_cut);
}

// Corners of a cell, with those that hold no height as high as one that does, or as the floor.
fn without_holes(corners: vec4f, known: f32) -> vec4f {
    return select(corners, vec4f(max(known, 0.0)), corners < vec4f(0.0));
}
#endif

// Normal of the ground at the grid position `p`, world space: the Sobel gradients of the four samples around it,
// interpolated, so that it is continuous although the patches have creases. The operator is separable, and so is the
// interpolation: both together are one weight for each row and column of the 4×4 samples around the cell.
#ifdef DEEP_ZOOM
// Here at the fraction `f` of the way across `cell`.
fn normal_in_cell(cell: vec2f, f: vec2f) -> vec3f {
#else
fn ground_normal(p: vec2f) -> vec3f {
    let cell = clamp(floor(p), vec2f(0.0), terrain.cells - 1.0);
    let f = p - cell;
#endif
    var north_west = cell_corners(cell - 1.0);
    var north_east = cell_corners(cell + vec2f(1.0, -1.0));
    var south_west = cell_corners(cell + vec2f(-1.0, 1.0));
    var south_east = cell_corners(cell + 1.0);
#ifdef HOLES
    // A neighbour that holds no height counts as high as the corner of the own cell beside it.
    north_west = without_holes(north_west, north_west.w);
    north_east = without_holes(north_east, north_east.z);
    south_west = without_holes(south_west, south_west.y);
    south_east = without_holes(south_east, south_east.x);
#endif
    let rows = mat4x4f(
        vec4f(north_west.xy, north_east.xy),
        vec4f(north_west.zw, north_east.zw),
        vec4f(south_west.xy, south_east.xy),
        vec4f(south_west.zw, south_east.zw),
    );
    let along_x = difference_weights(cell.x, terrain.cells.x, f.x) * rows;
    let along_z = smoothing_weights(f.x) * rows;
    var slopes = vec2f(
        dot(along_x, smoothing_weights(f.y)),
        dot(along_z, difference_weights(cell.y, terrain.cells.y, f.y)),
    );
#ifdef FRACTAL_SURFACE
    slopes += fractal::detail_slopes(cell, f, rows);
#endif
    let gradient = slopes * terrain.cells_per_unit;
    return normalize(vec3f(-gradient.x, 1.0, -gradient.y));
}
#endif

#ifdef DIFFUSE_TEXTURE
// Level of detail where `texels` of the finest level lie along a pixel's side: their logarithm, by parts linear as a
// float's bits hold it (0.09 of a level off at most). Half of the way between two levels belongs to one of them alone,
// so that there a software rasteriser, and many a GPU, looks up one level and not two.
fn level_of_detail(texels: f32) -> f32 {
    let logarithm = f32(bitcast<u32>(max(texels, 1.0)) - bitcast<u32>(1.0)) * exp2(-23.0);
    let level = floor(logarithm);
    return level + clamp(2.0 * (logarithm - level) - 0.5, 0.0, 1.0);
}
#endif

// Reflectance of the ground at the grid position `p`, seen at the view depth `depth`.
fn ground_albedo(p: vec2f, depth: f32) -> vec3f {
#ifdef DIFFUSE_TEXTURE
    let uv = p * terrain.repeats_per_cell;
    // Texels under the pixel choose the mip; there are no derivatives after a march.
    let texels = depth * frame.pixel_size * terrain.texel_density * terrain.repeats;
    let root = textureSampleLevel(diffuse_texture, diffuse_sampler, uv, level_of_detail(texels)).rgb;
    return root * root;
#else
    return vec3f(0.5);
#endif
}

// Rock of the box's cut sides: bands by height, so that a section through the terrain reads as one.
fn wall_albedo(height: f32) -> vec3f {
    let share = height / max(terrain.size.y, 1e-6);
    let band = 0.5 + 0.5 * sin(40.0 * share) * sin(17.0 * share + 1.0);
    return mix(vec3f(0.17, 0.10, 0.07), vec3f(0.30, 0.20, 0.13), band);
}

// Share of the sun's light on a surface with this unit normal.
fn facing_sun(normal: vec3f) -> f32 {
    return max(dot(normal, terrain.sun), 0.0);
}

#ifdef SUNLIGHT
// Share of the sun's disc that is seen from what is lit.
var<private> sunlight: f32;
#endif

#ifdef OCCLUSION
// Share of the sky's light that gets to what is lit.
var<private> sky_share: f32;
#endif

#ifdef CLOUD_SHADOWS
// Share of the sun's light that clouds let through.
var<private> cloud_light: f32;
#endif

#ifdef LIGHT_MAP
// The shares of the sun and of the sky by the place on the map.
@group(1) @binding(22) var light_map: texture_2d<f32>;
@group(1) @binding(23) var light_map_sampler: sampler;

// Reads both for the place `p`, grid space.
fn read_light_map(p: vec2f) {
    let shares = textureSampleLevel(light_map, light_map_sampler, p / terrain.cells, 0.0).rg;
#ifdef BAKED_SHADOWS
    sunlight = shares.x;
#endif
#ifdef OCCLUSION
    sky_share = shares.y;
#endif
}
#endif

// Blinn–Phong: `to_eye` and `normal` are unit vectors.
fn lit(albedo: vec3f, normal: vec3f, to_eye: vec3f) -> vec3f {
#ifdef SUNLIGHT
    var towards_sun = sunlight * facing_sun(normal);
#else
    var towards_sun = facing_sun(normal);
#endif
#ifdef CLOUD_SHADOWS
    towards_sun *= cloud_light;
#endif
#ifdef OCCLUSION
    let ambient = terrain.ambient * sky_share;
#else
    let ambient = terrain.ambient;
#endif
#ifdef SKY_LIGHT
    var color = albedo * (ambient * light::sky_light(normal) + terrain.diffuse * towards_sun * light::light.sun.rgb);
#else
    var color = albedo * (ambient + terrain.diffuse * towards_sun);
#endif
    if towards_sun > 0.0 {
        let half_way = normalize(terrain.sun + to_eye);
        var highlight = vec3f(terrain.specular * pow(max(dot(normal, half_way), 0.0), terrain.shininess));
#ifdef SUNLIGHT
        highlight *= sunlight;
#endif
#ifdef CLOUD_SHADOWS
        highlight *= cloud_light;
#endif
#ifdef SKY_LIGHT
        highlight *= light::light.sun.rgb;
#endif
        color += highlight;
    }
    return color;
}
