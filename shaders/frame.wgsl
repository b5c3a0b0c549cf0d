// What every pass of a frame shares: the eye's rays and matrix. Bind group 0.
#define_import_path relief::frame

struct Frame {
    // World to clip space; reversed depth, infinite far plane.
    clip_from_world: mat4x4f,
    // World position on the central ray at the view depth `ray_start`. The CPU chooses that depth in f64 so that the
    // origin lies near the terrain's box: from a million units away f32 would have no bits left for the ground.
    ray_origin: vec3f,
    ray_start: f32,
    // Change of the origin per pixel to the right and down.
    ray_origin_right: vec3f,
    // Width of a pixel at view depth 1.
    pixel_size: f32,
    ray_origin_down: vec3f,
    padding: f32,
    // Direction of the central ray, with a view depth of 1, and its change per pixel.
    ray_direction: vec3f,
    flattening: f32,
    ray_direction_right: vec3f,
    centre_x: f32,
    ray_direction_down: vec3f,
    centre_y: f32,
}

#ifdef FLAT_CONSTANTS
@group(0) @binding(0) var<uniform> frame_uniform: Frame;
var<private> frame: Frame;
#else
@group(0) @binding(0) var<uniform> frame: Frame;
#endif

// A ray in world space. A parameter s along it is a view depth less `frame.ray_start`.
struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// The ray through a fragment's centre, made from the pixel's coordinates and the camera's basis: interpolated cube
// positions and inverted matrices lose two to three digits against this.
fn pixel_ray(position: vec2f) -> Ray {
    let offset = position - vec2f(frame.centre_x, frame.centre_y);
    return Ray(
        frame.ray_origin + offset.x * frame.ray_origin_right + offset.y * frame.ray_origin_down,
        frame.ray_direction + offset.x * frame.ray_direction_right + offset.y * frame.ray_direction_down,
    );
}

// A ray that is parallel to two faces is between them this long, or never.
const FOR_EVER: f32 = 1e30;

// Parameters at which a ray enters and leaves the space between the two faces of a box on each axis.
struct Slabs {
    enter: vec3f,
    leave: vec3f,
}

fn slabs(ray: Ray, low: vec3f, high: vec3f) -> Slabs {
    let parallel = abs(ray.direction) < vec3f(1.0 / FOR_EVER);
    let divisor = select(ray.direction, vec3f(1.0), parallel);
    let first = (low - ray.origin) / divisor;
    let second = (high - ray.origin) / divisor;
    let between = select(vec3f(FOR_EVER), vec3f(-FOR_EVER), (ray.origin >= low) & (ray.origin <= high));
    return Slabs(
        select(min(first, second), between, parallel),
        select(max(first, second), -between, parallel),
    );
}

// Corner `index` (0..8) of the unit cube: bit 0 is x, bit 1 is y, bit 2 is z.
fn cube_corner(index: u32) -> vec3f {
    return vec3f(f32(index & 1u), f32((index >> 1u) & 1u), f32((index >> 2u) & 1u));
}
