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
    // Strength of the relief; then padding.
    relief: vec4f,
}

@group(1) @binding(25) var<uniform> materials: Materials;
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

// A weight below this is not worth a texture's read.
const NEGLIGIBLE: f32 = 0.02;

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
fn patched(layer: i32, uv: vec2f, right: vec2f, down: vec2f, shift: vec2f) -> vec4f {
    let skewed = vec2f(uv.x - 0.57735027 * uv.y, 1.15470054 * uv.y) * PATCHES;
    let base = floor(skewed);
    let f = skewed - base;
    let upper = f.x + f.y > 1.0;
    let shares = select(vec3f(1.0 - f.x - f.y, f.y, f.x), vec3f(f.x + f.y - 1.0, 1.0 - f.y, 1.0 - f.x), upper);
    // Narrow transitions keep what the texture shows.
    let sharp = shares * shares * shares;
    let weights = sharp / (sharp.x + sharp.y + sharp.z);
    let corner = select(vec2f(0.0), vec2f(1.0), upper);
    let second = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), upper);
    var sum = vec4f(0.0);
    if weights.x > NEGLIGIBLE {
        let offset = place_of_patch(base + corner) * shift;
        sum += weights.x * textureSampleGrad(material_textures, material_sampler, uv + offset, layer, right, down);
    }
    if weights.y > NEGLIGIBLE {
        let offset = place_of_patch(base + second) * shift;
        sum += weights.y * textureSampleGrad(material_textures, material_sampler, uv + offset, layer, right, down);
    }
    if weights.z > NEGLIGIBLE {
        let offset = place_of_patch(base + 1.0 - second) * shift;
        sum += weights.z * textureSampleGrad(material_textures, material_sampler, uv + offset, layer, right, down);
    }
    // Blending takes variance away; this gives it back. Means are 0.
    return sum * inverseSqrt(dot(weights, weights));
}

// Middle and fine texture of a layer at a place of one of the three planes, world units.
fn two_scales(layer: i32, uv: vec2f, right: vec2f, down: vec2f, width: f32, shift: vec2f) -> vec4f {
    var sum = vec4f(0.0);
    let middle = materials.repeats.y;
    let middle_share = 1.0 - smoothstep(0.5 * BLURRED, BLURRED, width * middle);
    if middle_share > 0.0 {
        sum += middle_share * patched(layer, uv * middle, right * middle, down * middle, shift);
    }
    let fine = materials.repeats.x;
    let fine_share = 1.0 - smoothstep(0.5 * BLURRED, BLURRED, width * fine);
    if fine_share > 0.0 {
        // Turned against the middle one, so that what is large in the one does not lie on itself in the other. Strata stay
        // level.
        let turn = select(vec2f(0.8, 0.6), vec2f(1.0, 0.0), layer == CLIFF);
        let turned = mat2x2f(turn.x, turn.y, -turn.y, turn.x);
        let texel = patched(layer, turned * uv * fine, turned * right * fine, turned * down * fine, shift);
        sum += fine_share * vec4f(texel.xy * turned, texel.zw);
    }
    return sum;
}

// What a material's textures add at a place: a gradient of its relief in world space, its height and its tint.
struct Texel {
    gradient: vec3f,
    height: f32,
    tint: f32,
}

fn texel_of(material: u32, print: Footprint, planes: vec3f) -> Texel {
    var texel = Texel(vec3f(0.0), 0.0, 0.0);
    let layer = i32(material);
    if planes.y > NEGLIGIBLE {
        let one = planes.y * two_scales(layer, print.at.xz, print.right.xz, print.down.xz, print.width, vec2f(1.0));
        texel = Texel(vec3f(one.x, 0.0, one.y), one.z, one.w);
    }
    // Strata lie level: their patches are displaced along them only.
    let is_rock = material == ROCK;
    let side = select(layer, CLIFF, is_rock);
    let shift = select(vec2f(1.0), vec2f(1.0, 0.0), is_rock);
    if planes.x > NEGLIGIBLE {
        let one = planes.x * two_scales(side, print.at.zy, print.right.zy, print.down.zy, print.width, shift);
        texel = Texel(texel.gradient + vec3f(0.0, one.y, one.x), texel.height + one.z, texel.tint + one.w);
    }
    if planes.z > NEGLIGIBLE {
        let one = planes.z * two_scales(side, print.at.xy, print.right.xy, print.down.xy, print.width, shift);
        texel = Texel(texel.gradient + vec3f(one.x, one.y, 0.0), texel.height + one.z, texel.tint + one.w);
    }
    return texel;
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
    let far = patched(BROAD, at.zx * wider, right.zx * wider, down.zx * wider, vec2f(1.0));
    let broad = 0.75 * near + 0.6 * far;

    var shares = shares_by_slope(at.y, normal, broad);
#ifdef MATERIALS_COVERAGE
    let to_map = 1.0 / terrain.size.xz;
    shares = shares_by_maps(at.xz * to_map, right.xz * to_map, down.xz * to_map, shares);
#endif
    // From above where the ground is gentle; the sharper the turn, the less of it is a blur of two planes.
    let steep = max(abs(normal) - vec3f(0.3, 0.1, 0.3), vec3f(0.0));
    let cubes = steep * steep * steep;
    let planes = cubes / (cubes.x + cubes.y + cubes.z);

    var sum = 0.0;
    var albedo = vec3f(0.0);
    var gradient = vec3f(0.0);
    for (var material = 0u; material < MATERIALS; material += 1u) {
        let share = shares[material];
        if share > NEGLIGIBLE {
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
