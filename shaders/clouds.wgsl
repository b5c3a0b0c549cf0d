// The clouds: flat layers between the eye and what it sees, or the sky, blended over the picture, an instance for each from the
// farthest to the nearest. Each is drawn over the rows in which it can be, on its side of the horizon, and at its own depth:
// where the ground is before it, no fragment runs.
//
// All that a layer's fragments need comes as varyings: a software rasteriser reads buffers lane by lane.

#import relief::constants::NEAR
#import relief::frame::{frame, pixel_ray}
#import relief::air
#import relief::air::air as constants
#import relief::cloud_constants::{CLOUD_LAYERS, FADED, WHOLE}
#import relief::cloud_layers::{clouds, cloud_at, cloud_colour, CloudLayer, CloudLights}

@group(1) @binding(50) var depths: texture_depth_2d;

struct Varyings {
    @builtin(position) position: vec4f,
    // The ray; w: view depth where it begins, and the width of a pixel at view depth 1.
    @location(0) origin: vec4f,
    @location(1) direction: vec4f,
    @location(2) @interpolate(flat) shape: vec4f,
    @location(3) @interpolate(flat) first: vec4f,
    @location(4) @interpolate(flat) second: vec4f,
    @location(5) @interpolate(flat) offsets: vec4f,
    // Towards the sun; whether light is exposed.
    @location(6) @interpolate(flat) sun: vec4f,
    // Light of the sun; how much of the layer shows to an eye so near to it.
    @location(7) @interpolate(flat) sun_light: vec4f,
    @location(8) @interpolate(flat) sky_light: vec4f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let number = u32(clouds.order[min(instance >> 2u, 1u)][instance & 3u]);
    let layer = clouds.layers[min(number, CLOUD_LAYERS - 1u)];
    // The row of the horizon: the camera does not roll. Rows count down, in which rays turn down, too.
    let above = layer.shape.x - clouds.count.y;
    let last = 2.0 * frame.centre_y;
    let turns = frame.ray_direction_down.y;
    let level = frame.centre_y - frame.ray_direction.y / select(turns, -1e-30, abs(turns) < 1e-30);
    let horizon = clamp(level, 0.0, last);
    // 0, 1, 2 and 2, 1, 3.
    let corner = select(index, select(index - 1u, select(1u, 3u, index == 5u), index > 3u), index > 2u);
    let upper = select(horizon, 0.0, above > 0.0);
    let lower = select(last, horizon, above > 0.0);
    let pixel = vec2f(select(0.0, 2.0 * frame.centre_x, (corner & 1u) != 0u), select(upper, lower, corner > 1u));
    let ray = pixel_ray(pixel);
    // Of a plane the depth that is tested, one over view depth, is as straight as the picture.
    let depth = NEAR * ray.direction.y / select(above, 1e-30, above == 0.0);
    // Softly through a layer that the eye flies through.
    let shows = smoothstep(0.0, 2.0 * layer.shape.y, abs(above));
    return Varyings(
        vec4f(pixel / vec2f(frame.centre_x, -frame.centre_y) + vec2f(-1.0, 1.0), clamp(depth, 0.0, 1.0), 1.0),
        vec4f(ray.origin, frame.ray_start),
        vec4f(ray.direction, frame.pixel_size),
        layer.shape,
        layer.first,
        layer.second,
        layer.offsets,
        vec4f(constants.sun.xyz, clouds.sun.z),
        vec4f(constants.sun_light.rgb, shows),
        constants.sky_light,
    );
}

@fragment
fn fs_main(in: Varyings) -> @location(0) vec4f {
    let ray = in.direction.xyz;
    let along = (in.shape.x - in.origin.y) / select(ray.y, 1e-20, ray.y == 0.0);
    let depth = in.origin.w + along;
    let direction = normalize(ray);
    let steep = abs(direction.y);
    // Near the horizon layers fade: there they would be seen on edge.
    let seen = smoothstep(FADED, WHOLE, steep) * in.sun_light.w;
    if depth <= 0.0 || seen <= 0.0 {
        discard;
    }
    let last = vec2i(textureDimensions(depths)) - 1;
    let written = textureLoad(depths, min(vec2i(in.position.xy), last), 0);
    let behind = select(1e30, NEAR / written, written > 0.0);
    // Softly into hills.
    let hills = smoothstep(0.0, in.shape.y, (behind - depth) * abs(ray.y));
    if hills <= 0.0 {
        discard;
    }
    let place = in.origin.xz + ray.xz * along;
    let footprint = in.direction.w * depth * exp2(-0.8 * log2(steep));
    let layer = CloudLayer(in.shape, in.first, in.second, in.offsets);
    // Tops are nearer to an eye above, bottoms to one below: half of the pattern is looked up as far ahead as they lean.
    let lean = ray.xz * (in.shape.y / max(abs(ray.y), 0.6 * length(ray)));
    let cloud = cloud_at(layer, place, footprint, lean);
    if cloud.depth <= 0.0 {
        discard;
    }
    let slant = min(1.0 / steep, 3.0);
    let opacity = (1.0 - exp(-cloud.depth * slant)) * seen * hills;
    var light = cloud_colour(cloud, direction, CloudLights(in.sun, in.sun_light.rgb, in.sky_light.rgb));
#ifdef AIR
    let before = air::veil(ray, depth, in.shape.x);
    light = light * before.passes + before.light;
#endif
    return vec4f(air::dithered(light, in.position.xy) * opacity, opacity);
}
