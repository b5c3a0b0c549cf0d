// What the rasteriser hands to the fragments that cast rays.
#define_import_path relief::varyings

#ifdef FLAT_CONSTANTS
#import relief::frame::{frame, frame_uniform}
#import relief::heightfield::{terrain, terrain_uniform}
#endif

// With FLAT_CONSTANTS the vertices hand the uniforms on as flat varyings. A software rasteriser reads a uniform of a
// fragment lane by lane, some thirty instructions for each scalar and again in each turn of a loop, but copies a flat
// varying into all lanes with one. A GPU reads uniforms for free and would keep varyings in registers.
struct Varyings {
    @builtin(position) position: vec4f,
#ifdef VIEW_POSITION
    // Position on the box, 0 to 1.
    @location(0) corner: vec3f,
#endif
#ifdef FLAT_CONSTANTS
    // Fifteen places are all that every adapter has.
    @location(0) @interpolate(flat) farthest_height_unit_and_repeats_per_cell: vec4f,
    @location(1) @interpolate(flat) origin_and_start: vec4f,
    @location(2) @interpolate(flat) origin_right_and_pixel_size: vec4f,
    @location(3) @interpolate(flat) origin_down_and_texel_density: vec4f,
    @location(4) @interpolate(flat) direction_and_heat_map_max: vec4f,
    @location(5) @interpolate(flat) direction_right_and_centre_x: vec4f,
    @location(6) @interpolate(flat) direction_down_and_centre_y: vec4f,
    @location(7) @interpolate(flat) size_and_highest: vec4f,
    @location(8) @interpolate(flat) cells_and_cells_per_unit: vec4f,
    @location(9) @interpolate(flat) texel_size_and_layer_cells: vec4f,
    @location(10) @interpolate(flat) pyramid_stack_and_texel: vec4f,
    @location(11) @interpolate(flat) samples_top_size_and_layer_rise: vec4f,
    @location(12) @interpolate(flat) binary_steps_and_step_cap: vec2u,
    @location(13) @interpolate(flat) sun_and_ambient: vec4f,
    @location(14) @interpolate(flat) light_and_repeats: vec4f,
#endif
}

// A vertex at `position` in clip space.
fn at(position: vec4f) -> Varyings {
    var out: Varyings;
    out.position = position;
#ifdef FLAT_CONSTANTS
    frame = frame_uniform;
    terrain = terrain_uniform;
    out.origin_and_start = vec4f(frame.ray_origin, frame.ray_start);
    out.origin_right_and_pixel_size = vec4f(frame.ray_origin_right, frame.pixel_size);
    out.origin_down_and_texel_density = vec4f(frame.ray_origin_down, terrain.texel_density);
    out.direction_and_heat_map_max = vec4f(frame.ray_direction, terrain.heat_map_max);
    out.direction_right_and_centre_x = vec4f(frame.ray_direction_right, frame.centre_x);
    out.direction_down_and_centre_y = vec4f(frame.ray_direction_down, frame.centre_y);
    out.size_and_highest = vec4f(terrain.size, terrain.highest);
    out.cells_and_cells_per_unit = vec4f(terrain.cells, terrain.cells_per_unit);
    out.texel_size_and_layer_cells = vec4f(terrain.texel_size, terrain.layer_cells);
    out.pyramid_stack_and_texel = vec4f(terrain.pyramid_stack, terrain.pyramid_texel);
    out.samples_top_size_and_layer_rise = vec4f(terrain.samples, terrain.top_size, terrain.layer_rise);
    out.farthest_height_unit_and_repeats_per_cell =
        vec4f(terrain.farthest, terrain.height_unit, terrain.repeats_per_cell);
    out.binary_steps_and_step_cap = vec2u(terrain.binary_steps, terrain.step_cap);
    out.sun_and_ambient = vec4f(terrain.sun, terrain.ambient);
    out.light_and_repeats = vec4f(terrain.diffuse, terrain.specular, terrain.shininess, terrain.repeats);
#endif
    return out;
}

// Makes the constants of `frame` and `terrain` known to a fragment; call it first.
fn receive(in: Varyings) {
#ifdef FLAT_CONSTANTS
    frame.ray_origin = in.origin_and_start.xyz;
    frame.ray_start = in.origin_and_start.w;
    frame.ray_origin_right = in.origin_right_and_pixel_size.xyz;
    frame.pixel_size = in.origin_right_and_pixel_size.w;
    frame.ray_origin_down = in.origin_down_and_texel_density.xyz;
    frame.ray_direction = in.direction_and_heat_map_max.xyz;
    frame.ray_direction_right = in.direction_right_and_centre_x.xyz;
    frame.centre_x = in.direction_right_and_centre_x.w;
    frame.ray_direction_down = in.direction_down_and_centre_y.xyz;
    frame.centre_y = in.direction_down_and_centre_y.w;
    terrain.size = in.size_and_highest.xyz;
    terrain.highest = in.size_and_highest.w;
    terrain.cells = in.cells_and_cells_per_unit.xy;
    terrain.cells_per_unit = in.cells_and_cells_per_unit.zw;
    terrain.texel_size = in.texel_size_and_layer_cells.xy;
    terrain.layer_cells = in.texel_size_and_layer_cells.zw;
    terrain.pyramid_stack = in.pyramid_stack_and_texel.xy;
    terrain.pyramid_texel = in.pyramid_stack_and_texel.zw;
    terrain.samples = in.samples_top_size_and_layer_rise.xy;
    terrain.top_size = in.samples_top_size_and_layer_rise.z;
    terrain.layer_rise = in.samples_top_size_and_layer_rise.w;
    terrain.farthest = in.farthest_height_unit_and_repeats_per_cell.x;
    terrain.height_unit = in.farthest_height_unit_and_repeats_per_cell.y;
    terrain.repeats_per_cell = in.farthest_height_unit_and_repeats_per_cell.zw;
    terrain.binary_steps = in.binary_steps_and_step_cap.x;
    terrain.step_cap = in.binary_steps_and_step_cap.y;
    terrain.sun = in.sun_and_ambient.xyz;
    terrain.ambient = in.sun_and_ambient.w;
    terrain.diffuse = in.light_and_repeats.x;
    terrain.specular = in.light_and_repeats.y;
    terrain.shininess = in.light_and_repeats.z;
    terrain.repeats = in.light_and_repeats.w;
    terrain.texel_density = in.origin_down_and_texel_density.w;
    terrain.heat_map_max = in.direction_and_heat_map_max.w;
#endif
}
