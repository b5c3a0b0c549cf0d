// Reading the land: colours by height, slope or direction, contour lines, hillshade, pictures put in their place.
#define_import_path relief::land

#import relief::frame::{frame, Ray}
#import relief::heightfield::{terrain, heights, corner_sampler, cell_corners, bilinear}
#import relief::shading

// Heights here are shares of the box's height.
struct Land {
    // Heights of the ramp's lower end, middle and upper end.
    ramp_low: f32,
    ramp_middle: f32,
    ramp_high: f32,
    // Share per unit of what the texture of heights holds.
    height_unit: f32,
    // Contour lines lie where this much of a height, and the offset, make a whole number; every fifth is heavier.
    contours_per_share: f32,
    contour_offset: f32,
    // Pixels.
    contour_width: f32,
    // True steepness over that of the box.
    slope_factor: f32,
    // Degrees.
    slope_max: f32,
    hillshade_strength: f32,
    imagery_opacity: f32,
    // Texels of the picture per world unit.
    imagery_density: f32,
    // From cells along x and z, and 1, to the picture's u and v.
    imagery_u: vec3f,
    padding: f32,
    imagery_v: vec3f,
    // Texels of the picture along its longer side.
    imagery_texels: f32,
}

@group(1) @binding(32) var<uniform> land: Land;

#ifdef LAND_COLOURS
// Colours of both halves of the ramp, side by side; roots of linear light.
@group(1) @binding(33) var colours: texture_2d<f32>;
#endif
#ifdef LAND_SAMPLER
@group(1) @binding(34) var colour_sampler: sampler;
#endif
#ifdef IMAGERY
@group(1) @binding(35) var imagery_texture: texture_2d<f32>;
#endif

// A place on the ground: a cell, and how far across it.
struct Place {
    cell: vec2f,
    within: vec2f,
}

fn place_at(p: vec2f) -> Place {
    let cell = clamp(floor(p), vec2f(0.0), terrain.cells - 1.0);
    return Place(cell, p - cell);
}

#ifdef LAND_NORMAL
fn normal_at(place: Place) -> vec3f {
#ifdef DEEP_ZOOM
    return shading::normal_in_cell(place.cell, place.within);
#else
    return shading::ground_normal(place.cell + place.within);
#endif
}
#endif

#ifdef LAND_HEIGHT
// Heights of the cell's corners. The box's own height does not enter, so that a flat one has colours and lines, too.
fn corner_shares(cell: vec2f) -> vec4f {
#ifdef CRATERS_LAYERED
    return cell_corners(cell) / max(terrain.size.y, 1e-30);
#else
    let corners = textureGather(0, heights, corner_sampler, (cell + 1.0) * terrain.texel_size).wzxy;
#ifdef HOLES
    return max(corners, vec4f(0.0)) * land.height_unit;
#else
    return corners * land.height_unit;
#endif
#endif
}
#endif

#ifdef LAND_COLOURS
// Texels on each side of the middle.
const HALF: f32 = 256.0;

// The ramp's colour at 0 to 1. Its two halves do not blend: a coast is sharp.
fn ramp_colour(share: f32) -> vec3f {
    let upper = share >= 0.5;
    let within = clamp(select(share, share - 0.5, upper) * 2.0, 0.0, 1.0);
    let texel = select(0.0, HALF, upper) + 0.5 + within * (HALF - 1.0);
    let root = textureSampleLevel(colours, colour_sampler, vec2f(texel / (2.0 * HALF), 0.5), 0.0).rgb;
    return root * root;
}
#endif

#ifdef LAND_RAMP
fn colour_by_height(place: Place) -> vec3f {
    let height = bilinear(corner_shares(place.cell), place.within);
    let below = 0.5 * (height - land.ramp_low) / max(land.ramp_middle - land.ramp_low, 1e-9);
    let above = 0.5 + 0.5 * (height - land.ramp_middle) / max(land.ramp_high - land.ramp_middle, 1e-9);
    let share = select(clamp(above, 0.5, 1.0), clamp(below, 0.0, 0.4999999), height < land.ramp_middle);
    return ramp_colour(share);
}
#endif

#ifdef LAND_SLOPE
fn colour_by_slope(normal: vec3f) -> vec3f {
    let slope = degrees(atan(length(normal.xz) / normal.y * land.slope_factor));
    return ramp_colour(slope / land.slope_max);
}
#endif

#ifdef LAND_ASPECT
// Ground gentler than this falls in no direction, and is grey: a gradient, some hundredths of a degree.
const LEVEL: f32 = 8.7e-4;
const GREY: vec3f = vec3f(0.45);

fn colour_by_aspect(normal: vec3f) -> vec3f {
    // The horizontal part of a normal points downhill: x is east, −z north.
    let turn = atan2(normal.x, -normal.z) / 6.283185307;
    let is_level = length(normal.xz) * land.slope_factor <= LEVEL * normal.y;
    return select(ramp_colour(fract(turn + 1.0)), GREY, is_level);
}
#endif

#ifdef HILLSHADE
// Sine of the sun's lowest elevation, 5.7°: at night there would be nothing to see, and at the horizon a division by nothing.
const LOWEST_SUN: f32 = 0.1;
// As bright as a slope may be against level ground.
const BRIGHTEST: f32 = 1.6;

// Light on a slope over that on level ground.
fn shade(normal: vec3f) -> f32 {
#ifdef HILLSHADE_MULTIDIRECTIONAL
    // Four lights 30° high in the south-west, west, north-west and north (Mark 1992): each counts as the square of the
    // sine between its direction and that of the slope, and all four together twice.
    let level = length(normal.xz);
    let downhill = select(vec2f(1.0, 0.0), normal.xz / max(level, 1e-20), level > 1e-12);
    let diagonal = 0.70710678;
    let east = vec4f(-diagonal, -1.0, -diagonal, 0.0);
    let south = vec4f(diagonal, 0.0, -diagonal, -1.0);
    let along = downhill.x * east + downhill.y * south;
    let weights = 1.0 - along * along;
    let light = max(0.8660254 * (normal.x * east + normal.z * south) + 0.5 * normal.y, vec4f(0.0));
    return min(dot(weights, light), BRIGHTEST);
#else
    let level = max(length(terrain.sun.xz), 1e-6);
    let lifted = vec3f(terrain.sun.xz * (sqrt(1.0 - LOWEST_SUN * LOWEST_SUN) / level), LOWEST_SUN);
    let sun = select(terrain.sun, lifted, terrain.sun.y < LOWEST_SUN);
    return min(max(dot(normal, sun), 0.0) / sun.y, BRIGHTEST);
#endif
}
#endif

#ifdef IMAGERY
// The picture over `colour`; beside it, and where it is transparent, the colour stays.
fn with_imagery(colour: vec3f, place: Place, depth: f32) -> vec3f {
    let at = vec3f(place.cell + place.within, 1.0);
    let uv = vec2f(dot(at, land.imagery_u), dot(at, land.imagery_v));
    let texels = depth * frame.pixel_size * land.imagery_density;
    let texel = textureSampleLevel(imagery_texture, colour_sampler, uv, log2(max(texels, 1.0)));
    // Pixels from the picture's edge, inwards: the edge is as smooth as a line.
    let inwards = min(min(uv.x, 1.0 - uv.x), min(uv.y, 1.0 - uv.y)) * land.imagery_texels / max(texels, 1e-6);
    let cover = clamp(inwards + 0.5, 0.0, 1.0) * texel.a * land.imagery_opacity;
    return mix(colour, texel.rgb * texel.rgb, cover);
}
#endif

// What the ground's reflectance `albedo` becomes at a place that is seen at the view depth `depth`.
fn albedo_of(albedo: vec3f, place: Place, depth: f32) -> vec3f {
    var colour = albedo;
#ifdef LAND_NORMAL
    let normal = normal_at(place);
#endif
#ifdef LAND_RAMP
    colour = colour_by_height(place);
#endif
#ifdef LAND_SLOPE
    colour = colour_by_slope(normal);
#endif
#ifdef LAND_ASPECT
    colour = colour_by_aspect(normal);
#endif
#ifdef IMAGERY
    colour = with_imagery(colour, place, depth);
#endif
#ifdef HILLSHADE
    colour *= mix(1.0, shade(normal), land.hillshade_strength);
#endif
    return colour;
}

#ifdef LAND_CONTOURS
// Lines that are closer than so many pixels are gone, and whole from so many on.
const CROWDED: f32 = 3.0;
const APART: f32 = 8.0;
// The least of an interval that a pixel counts as, so that level ground on a line is no blot.
const LEAST_RISE: f32 = 2e-4;
// By so much of an interval lines lie above their height: level ground, often at a round height, is not on one.
const LIFT: f32 = 2e-3;

// Height at the grid position `p`.
fn share_at(p: vec2f) -> f32 {
    let place = place_at(clamp(p, vec2f(0.0), terrain.cells));
    return bilinear(corner_shares(place.cell), place.within);
}

// How much of a pixel a line covers that is `pixels` off.
fn covered(pixels: f32, width: f32) -> f32 {
    return clamp(0.5 * width + 0.5 - pixels, 0.0, 1.0) * min(width, 1.0);
}

// `colour` with contour lines, at a place that `ray` meets at the view depth `depth`; `albedo` is what the ground itself
// looks like there.
//
// A line's distance in pixels is its distance in height over the height that the ground gains from pixel to pixel. That
// gain is the one over the plane that touches the ground: known at one pixel alone, so no silhouette disturbs it. Where
// cells are smaller than pixels one cell says little, and what the ground really is a pixel farther on counts, too.
fn with_contours(colour: vec3f, albedo: vec3f, place: Place, ray: Ray, depth: f32) -> vec3f {
    let corners = corner_shares(place.cell);
    let f = place.within;
    // Rise of the ground per cell, then per world unit.
    let per_cell = vec2f(mix(corners.y - corners.x, corners.w - corners.z, f.y), mix(corners.z - corners.x, corners.w - corners.y, f.x));
    let rise = per_cell * terrain.cells_per_unit;
    let upright = vec3f(-rise.x * terrain.size.y, 1.0, -rise.y * terrain.size.y);
    let facing = dot(upright, ray.direction);
    let grazing = 1e-4 * length(upright) * length(ray.direction);
    let against = select(facing, select(-grazing, grazing, facing > 0.0), abs(facing) < grazing);
    let right = frame.ray_direction_right - ray.direction * (dot(upright, frame.ray_direction_right) / against);
    let down = frame.ray_direction_down - ray.direction * (dot(upright, frame.ray_direction_down) / against);
    let touching = depth * length(vec2f(dot(rise, right.xz), dot(rise, down.xz)));
    let here = bilinear(corners, f);
    let p = place.cell + f;
    let to_right = right.xz * terrain.cells_per_unit * depth;
    let to_down = down.xz * terrain.cells_per_unit * depth;
    let beside = vec4f(share_at(p + to_right), share_at(p - to_right), share_at(p + to_down), share_at(p - to_down));
    let change = abs(beside - here);
    let most = max(touching, max(max(change.x, change.y), max(change.z, change.w))) * land.contours_per_share;
    // Within a cell the plane is the ground, and a line as wide as it should be.
    let cells = max(max(abs(to_right.x), abs(to_right.y)), max(abs(to_down.x), abs(to_down.y)));
    let gain = mix(touching * land.contours_per_share, most, smoothstep(1.0, 2.0, cells));

    let at = here * land.contours_per_share + land.contour_offset - LIFT;
    let per_pixel = max(gain, LEAST_RISE);
    let fifth = at / 5.0;
    let thin = covered(abs(at - round(at)) / per_pixel, land.contour_width);
    let heavy = covered(abs(fifth - round(fifth)) * 5.0 / per_pixel, land.contour_width * 2.0);
    let apart = 1.0 / max(most, 1e-9);
    let cover = max(
        0.55 * thin * smoothstep(CROWDED, APART, apart),
        0.85 * heavy * smoothstep(CROWDED, APART, apart * 5.0),
    );
    // Dark on what is bright, and pale on what is dark.
    let brightness = dot(albedo, vec3f(0.2126, 0.7152, 0.0722));
    let line = mix(vec3f(0.75, 0.72, 0.65), vec3f(0.05, 0.028, 0.015), smoothstep(0.015, 0.035, brightness));
    return mix(colour, line, cover);
}
#endif
