// What the ground is made of: grass, rock, scree, snow, sand and sea bed, chosen by slope and height or by coverage maps.
//
// A texture adds to a material's mean: slopes of a small relief, its height, and a tint between the material's two colours
// (`render/materials/synthesis.rs`). Three scales are mixed. Each is read in patches of random place (Heitz and Neyret
// 2018, "High-performance by-example noise using a histogram-preserving blending operator", section 3: three hexagons
// around a point, weighted so that the variance stays), so that no repeat shows from above; and from the sides, too, where
// the ground is steep, so that cliffs do not stretch. The footprint of the pixel's ray on the ground (Igehy 1999) is what
// the sampler filters over: a march leaves no derivatives.
#define_import_path relief::materials

#import relief::frame::frame
#import relief::heightfield::terrain

struct Materials {
    // Linear light at a tint of −1, and how much the height of the relief brightens it; by material.
    dark: array<vec4f, 6>,
    // Linear light at a tint of 1, and how much broad variation shifts the tint.
    light: array<vec4f, 6>,
    // Snow line, tree line, sand line, sea level; world units over the floor.
    levels: vec4f,
    // Slopes of scree, rock and snow in radians, and half the width of their transitions.
    slopes: vec4f,
    // Repeats per world unit of the fine, middle and broad textures, and half the width of levels' transitions.
    repeats: vec4f,
    // Strength of the relief, and how much strata show; then padding.
    relief: vec4f,
}

@group(1) @binding(16) var<uniform> materials: Materials;
@group(1) @binding(26) var material_textures: texture_2d_array<f32>;
@group(1) @binding(27) var material_sampler: sampler;
#ifdef MATERIALS_COVERAGE
@group(1) @binding(28) var coverage_maps: texture_2d_array<f32>;
@group(1) @binding(29) var coverage_sampler: sampler;
#endif

const GRASS: u32 = 0u;
const ROCK: u32 = 1u;
const SCREE: u32 = 2u;
const SNOW: u32 = 3u;
const SAND: u32 = 4u;
const SEA_BED: u32 = 5u;
const MATERIALS: u32 = 6u;
// Layers beside the materials' own: the strata of rock's sides, and broad variation of everything.
const CLIFF: i32 = 6;
const BROAD: i32 = 7;

// A share below this is not worth its textures' reads.
const NEGLIGIBLE: f32 = 0.06;

// Repeats under a pixel from which a texture shows nothing but its mean.
const BLURRED: f32 = 0.3;

// How often a patch of random place fits along a repeat.
const PATCHES: f32 = 2.0;

// The ground's colour, linear light, and its normal with the relief of what lies on it.
struct Ground {
    albedo: vec3f,
    normal: vec3f,
}

// Where a pixel's ray meets the ground, and how far from there its neighbours do; world units.
struct Footprint {
    at: vec3f,
    right: vec3f,
    down: vec3f,
    // The shorter of the two.
    width: f32,
}

// Two numbers from 0 to 1 for a patch (PCG2D: Jarzynski and Olano 2020, "Hash functions for GPU rendering").
fn place_of_patch(number: vec2f) -> vec2f {
    var v = bitcast<vec2u>(vec2i(number));
    v = v * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2u(16u);
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2u(16u);
    return vec2f(v & vec2u(0xffffu)) / 65536.0;
}

// A texture of a layer at `uv`, in repeats, in patches. `shift` says along which axes patches are displaced.
//
// Here and below, what is read is counted first and then read in a loop: a software rasteriser skips no branch that none
// of its lanes takes, but it does end a loop.
fn patched(layer: i32, uv: vec2f, right: vec2f, down: vec2f, shift: vec2f) -> vec4f {
    let skewed = vec2f(uv.x - 0.57735027 * uv.y, 1.15470054 * uv.y) * PATCHES;
    let base = floor(skewed);
    let f = skewed - base;
    let upper = f.x + f.y > 1.0;
    let shares = select(vec3f(1.0 - f.x - f.y, f.y, f.x), vec3f(f.x + f.y - 1.0, 1.0 - f.y, 1.0 - f.x), upper);
    // Narrow transitions keep what the texture shows, and most places read one patch or two.
    let above = max(shares - 0.22, vec3f(0.0));
    let sharp = above * above * above;
    let weights = sharp / (sharp.x + sharp.y + sharp.z);
    let corner = select(vec2f(0.0), vec2f(1.0), upper);
    let second = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), upper);
    let count = u32(weights.x > 0.0) + u32(weights.y > 0.0) + u32(weights.z > 0.0);
    var left = weights;
    var sum = vec4f(0.0);
    for (var read = 0u; read < min(count, 3u); read += 1u) {
        let most = max(left.x, max(left.y, left.z));
        let is_first = left.x == most;
        let is_second = !is_first && left.y == most;
        let number = base + select(select(1.0 - second, second, is_second), corner, is_first);
        left = select(left, vec3f(0.0), vec3<bool>(is_first, is_second, !is_first && !is_second));
        let place = uv + place_of_patch(number) * shift;
        sum += most * textureSampleGrad(material_textures, material_sampler, place, layer, right, down);
    }
    // Blending takes variance away; this gives it back. Means are 0.
    return sum * inverseSqrt(dot(weights, weights));
}

// Middle and fine texture of a layer at a place of one of the three planes, world units.
fn two_scales(layer: i32, uv: vec2f, right: vec2f, down: vec2f, width: f32, shift: vec2f) -> vec4f {
    let repeats = materials.repeats.yx;
    let shown = 1.0 - smoothstep(vec2f(0.5 * BLURRED), vec2f(BLURRED), width * repeats);
    let count = u32(shown.x > 0.0) + u32(shown.y > 0.0);
    var sum = vec4f(0.0);
    for (var scale = 0u; scale < min(count, 2u); scale += 1u) {
        let is_fine = scale == 1u;
        let repeat = select(repeats.x, repeats.y, is_fine);
        // The fine one is turned against the middle one, so that what is large in the one does not lie on itself in the
        // other. Strata stay level.
        let turn = select(vec2f(1.0, 0.0), vec2f(0.8, 0.6), is_fine && layer != CLIFF) * repeat;
        let turned = mat2x2f(turn.x, turn.y, -turn.y, turn.x);
        let texel = patched(layer, turned * uv, turned * right, turned * down, shift);
        sum += select(shown.x, shown.y, is_fine) * vec4f(texel.xy * turned / repeat, texel.zw);
    }
    return sum;
}

// What a material's textures add at a place: a gradient of its relief in world space, its height and its tint.
struct Texel {
    gradient: vec3f,
    height: f32,
    tint: f32,
}

// The planes across the axes are weighed by `planes`, of which one or two are above 0.
fn texel_of(material: u32, print: Footprint, planes: vec3f) -> Texel {
    let is_rock = material == ROCK;
    let count = u32(planes.x > 0.0) + u32(planes.y > 0.0) + u32(planes.z > 0.0);
    var left = planes;
    var texel = Texel(vec3f(0.0), 0.0, 0.0);
    for (var plane = 0u; plane < min(count, 2u); plane += 1u) {
        let most = max(left.x, max(left.y, left.z));
        let across_y = left.y == most;
        let across_x = !across_y && left.x == most;
        left = select(left, vec3f(0.0), vec3<bool>(across_x, across_y, !across_x && !across_y));
        let at = on_plane(print.at, across_x, across_y);
        let right = on_plane(print.right, across_x, across_y);
        let down = on_plane(print.down, across_x, across_y);
        // Strata lie level: their patches are displaced along them only.
        let is_cliff = is_rock && !across_y;
        let layer = select(i32(material), CLIFF, is_cliff);
        let shown = most * select(vec4f(1.0), vec4f(vec3f(0.4 + 0.6 * materials.relief.y), materials.relief.y), is_cliff);
        let one = shown * two_scales(layer, at, right, down, print.width, vec2f(1.0, f32(!is_cliff)));
        let across = select(vec3f(one.xy, 0.0), vec3f(0.0, one.yx), across_x);
        texel.gradient += select(across, vec3f(one.x, 0.0, one.y), across_y);
        texel.height += one.z;
        texel.tint += one.w;
    }
    return texel;
}

// The two coordinates of a plane across one of the axes; z where it is neither of the others.
fn on_plane(p: vec3f, across_x: bool, across_y: bool) -> vec2f {
    return select(select(p.xy, p.zy, across_x), p.xz, across_y);
}

fn rises(from_level: f32, half_width: f32, value: f32) -> f32 {
    return smoothstep(from_level - half_width, from_level + half_width, value);
}

// Shares of the materials by slope and height; `broad` makes their borders wander.
fn shares_by_slope(height: f32, normal: vec3f, broad: vec4f) -> array<f32, 6> {
    let blend = materials.slopes.w;
    let level = materials.repeats.w;
    let slope = acos(clamp(normal.y, 0.0, 1.0)) + 0.9 * blend * broad.z;
    // The sun melts the snow of southern slopes.
    let wandering = height + 2.2 * level * broad.w;
    let cold = wandering - level * 2.0 * normal.z;
    let sea = 1.0 - rises(materials.levels.w, 0.1 * level, height);
    let stays = 1.0 - rises(materials.slopes.z, 2.0 * blend, slope);
    let snow = rises(materials.levels.x, 1.5 * level, cold - 2.0 * level * (slope - 0.5)) * stays * (1.0 - sea);
    var rest = 1.0 - snow;
    let rock = rest * rises(materials.slopes.y, blend, slope);
    rest -= rock;
    let sea_bed = rest * sea;
    rest -= sea_bed;
    // Where nothing grows there are stones.
    let bare = rises(materials.levels.y, 2.0 * level, wandering + 2.0 * level * broad.z);
    let scree = rest * max(rises(materials.slopes.x, blend, slope), bare);
    rest -= scree;
    let sand = rest * (1.0 - rises(materials.levels.z, 0.3 * level, height + 0.5 * level * broad.w));
    return array<f32, 6>(rest - sand, rock, scree, snow, sand, sea_bed);
}

#ifdef MATERIALS_COVERAGE
// Shares of the materials by the coverage maps at a place of the map, each 0 to 1; `otherwise` where they say nothing.
fn shares_by_maps(place: vec2f, right: vec2f, down: vec2f, otherwise: array<f32, 6>) -> array<f32, 6> {
    let first = textureSampleGrad(coverage_maps, coverage_sampler, place, 0, right, down);
    let second = textureSampleGrad(coverage_maps, coverage_sampler, place, 1, right, down).xy;
    let sum = dot(first, vec4f(1.0)) + second.x + second.y;
    if sum < 1.0 / 255.0 {
        return otherwise;
    }
    let a = first / sum;
    let b = second / sum;
    return array<f32, 6>(a.x, a.y, a.z, a.w, b.x, b.y);
}
#endif

// The ground at `point` (grid space), seen at the view depth `depth` along `direction`; `normal` is that of the ground.
fn ground(point: vec3f, normal: vec3f, depth: f32, direction: vec3f) -> Ground {
    let at = point / vec3f(terrain.cells_per_unit.x, 1.0, terrain.cells_per_unit.y);
    // How far a ray beside this one goes on before it meets the ground's plane. Along the ground that is without end.
    let facing = min(dot(normal, direction), -0.04 * length(direction));
    let right = depth * (frame.ray_direction_right - direction * (dot(normal, frame.ray_direction_right) / facing));
    let down = depth * (frame.ray_direction_down - direction * (dot(normal, frame.ray_direction_down) / facing));
    let print = Footprint(at, right, down, depth * frame.pixel_size);

    let wide = materials.repeats.z;
    let near = patched(BROAD, at.xz * wide, right.xz * wide, down.xz * wide, vec2f(1.0));
    let wider = 0.21 * wide;
    // Turned, and repeated too seldom for its repeats to be seen.
    let far = textureSampleGrad(
        material_textures, material_sampler, at.zx * wider + 0.37, BROAD, right.zx * wider, down.zx * wider,
    );
    let broad = 0.75 * near + 0.6 * far;

    var shares = shares_by_slope(at.y, normal, broad);
#ifdef MATERIALS_COVERAGE
    let to_map = 1.0 / terrain.size.xz;
    shares = shares_by_maps(at.xz * to_map, right.xz * to_map, down.xz * to_map, shares);
#endif
    // From above where the ground is gentle, else along two of the axes (Quilez 2020, "Biplanar mapping").
    let away = abs(normal) - vec3f(0.1, 0.0, 0.1);
    let least = min(away.x, min(away.y, away.z));
    let steep = max(away - max(least, 0.6 * max(away.x, max(away.y, away.z))), vec3f(0.0));
    let cubes = steep * steep * steep;
    let planes = cubes / (cubes.x + cubes.y + cubes.z);

    var count = 0u;
    for (var material = 0u; material < MATERIALS; material += 1u) {
        shares[material] -= NEGLIGIBLE;
        count += u32(shares[material] > 0.0);
    }
    var sum = 0.0;
    var albedo = vec3f(0.0);
    var gradient = vec3f(0.0);
    for (var part = 0u; part < min(count, MATERIALS); part += 1u) {
        // The one with the largest share that is left.
        var material = 0u;
        var share = shares[0];
        for (var other = 1u; other < MATERIALS; other += 1u) {
            let larger = shares[other] > share;
            material = select(material, other, larger);
            share = select(share, shares[other], larger);
        }
        shares[material] = 0.0;
        let texel = texel_of(material, print, planes);
        let dark = materials.dark[material];
        let light = materials.light[material];
        let tint = clamp(0.5 + 0.5 * (texel.tint + light.w * broad.w), 0.0, 1.0);
        let colour = mix(dark.rgb, light.rgb, tint) * max(1.0 + dark.w * texel.height, 0.15);
        // What stands out of one material shows first through the other.
        let weight = share * share * exp2(4.0 * texel.height);
        sum += weight;
        albedo += weight * colour;
        gradient += weight * texel.gradient;
    }
    albedo /= sum;
#ifdef MATERIALS_RELIEF
    let slope = gradient * (RELIEF * materials.relief.x / sum);
    return Ground(albedo, normalize(normal - slope + normal * dot(slope, normal)));
#else
    return Ground(albedo, normal);
#endif
}

#ifdef MATERIALS_RELIEF
// Slope that a texture's 1 stands for.
const RELIEF: f32 = 1.6;
#endif
