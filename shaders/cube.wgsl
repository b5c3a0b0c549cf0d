// The small cube that hides hills and is hidden by them, and the edges of the terrain's box: the same unit cube,
// transformed on the CPU.

#import relief::frame::{frame, pixel_ray, cube_corner}
#import relief::cube_faces::{face_normal, face_colour}
#ifdef ATMOSPHERE
#import relief::air
#endif
#ifdef SHADOWS
#import relief::heightfield::terrain
#import relief::light::light
#import relief::shadow
#endif

struct Cube {
    // Corners in clip space.
    clip: array<vec4f, 8>,
    // Towards the sun in the cube's own space; zero when lighting is off.
    sun: vec3f,
    ambient: f32,
}

#ifdef SHADOWS
@group(1) @binding(21) var<uniform> cube: Cube;
#else
@group(1) @binding(0) var<uniform> cube: Cube;
#endif

struct Varyings {
    @builtin(position) position: vec4f,
    // Position on the cube, 0 to 1.
    @location(0) corner: vec3f,
    // View depth: the interpolated depth has too few bits to be turned back into a distance far away.
    @location(1) view_depth: f32,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> Varyings {
    let clip = cube.clip[index];
    return Varyings(clip, cube_corner(index), clip.w);
}

#ifdef WIREFRAME
@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
    return vec4f(1.0, 0.8, 0.1, 1.0);
}
#else
@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
#ifdef PROBE
    let ray = pixel_ray(in.position.xy);
    return vec4f(in.view_depth * length(ray.direction), 0.0, 0.0, 2.0);
#else
    let normal = face_normal(in.corner);
    let color = face_colour(normal);
    var towards_sun = max(dot(normal, cube.sun), 0.0);
#ifdef SHADOWS
    if towards_sun > 0.0 {
        let first = light.cube[0].xyz;
        let place = first + in.corner.x * (light.cube[1].xyz - first) + in.corner.y * (light.cube[2].xyz - first)
            + in.corner.z * (light.cube[4].xyz - first);
        let on_grid = place.xz * terrain.cells_per_unit;
        let cell = floor(on_grid);
        towards_sun *= shadow::sunlight(shadow::Place(cell, on_grid - cell, place.y), true);
    }
#endif
#ifdef CLOUD_SHADOWS
    let lit_ray = pixel_ray(in.position.xy);
    towards_sun *= air::cloud_light(lit_ray.origin + lit_ray.direction * (in.view_depth - frame.ray_start));
#endif
    let lit = color * (cube.ambient + towards_sun);
#ifdef AIR
    let seen = pixel_ray(in.position.xy);
    let height = seen.origin.y + seen.direction.y * (in.view_depth - frame.ray_start);
    return vec4f(air::through(lit, seen.direction, in.view_depth, height, in.position.xy), 1.0);
#else
    return vec4f(lit, 1.0);
#endif
#endif
}
#endif
