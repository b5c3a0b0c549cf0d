// Colour of a point on the ground: diffuse texture, Sobel normal, sun.
#define_import_path relief::shading

#import relief::frame::frame
#import relief::heightfield::{terrain, cell_corners}

#ifdef DIFFUSE_TEXTURE
@group(1) @binding(5) var diffuse_texture: texture_2d<f32>;
@group(1) @binding(6) var diffuse_sampler: sampler;
#endif

// Sobel operator at sample `texel` from its 3×3 neighbourhood `n` (rows from the north), as height per cell along x
// and z. At the map's border the neighbour is the sample itself and the difference spans one cell instead of two.
fn sobel(north: vec3f, middle: vec3f, south: vec3f, texel: vec2i) -> vec2f {
    let span = vec2f(min(texel + 1, terrain.cells) - max(texel - 1, vec2i(0)));
    let east_west = (north.z + 2.0 * middle.z + south.z) - (north.x + 2.0 * middle.x + south.x);
    let south_north = (south.x + 2.0 * south.y + south.z) - (north.x + 2.0 * north.y + north.z);
    return vec2f(east_west, south_north) / (4.0 * span);
}

// Normal of the ground at the grid position `p`, world space: the Sobel gradients of the four samples around it,
// interpolated, so that it is continuous although the patches have creases.
fn ground_normal(p: vec2f) -> vec3f {
    let cell = clamp(vec2i(floor(p)), vec2i(0), terrain.cells - 1);
    let f = p - vec2f(cell);
    // The 4×4 samples around the cell.
    let north_west = cell_corners(cell - 1);
    let north_east = cell_corners(cell + vec2i(1, -1));
    let south_west = cell_corners(cell + vec2i(-1, 1));
    let south_east = cell_corners(cell + 1);
    let rows = array<vec4f, 4>(
        vec4f(north_west.xy, north_east.xy),
        vec4f(north_west.zw, north_east.zw),
        vec4f(south_west.xy, south_east.xy),
        vec4f(south_west.zw, south_east.zw),
    );
    let north = mix(
        sobel(rows[0].xyz, rows[1].xyz, rows[2].xyz, cell),
        sobel(rows[0].yzw, rows[1].yzw, rows[2].yzw, cell + vec2i(1, 0)),
        f.x,
    );
    let south = mix(
        sobel(rows[1].xyz, rows[2].xyz, rows[3].xyz, cell + vec2i(0, 1)),
        sobel(rows[1].yzw, rows[2].yzw, rows[3].yzw, cell + vec2i(1, 1)),
        f.x,
    );
    let gradient = mix(north, south, f.y) * terrain.cells_per_unit;
    return normalize(vec3f(-gradient.x, 1.0, -gradient.y));
}

// Reflectance of the ground at the grid position `p`, seen at the view depth `depth`.
fn ground_albedo(p: vec2f, depth: f32) -> vec3f {
#ifdef DIFFUSE_TEXTURE
    let uv = p / vec2f(terrain.cells) * terrain.repeats;
    // Texels under the pixel choose the mip; there are no derivatives after a march.
    let texels = depth * frame.pixel_size * terrain.texel_density * terrain.repeats;
    return textureSampleLevel(diffuse_texture, diffuse_sampler, uv, log2(max(texels, 1.0))).rgb;
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

// Blinn–Phong: `to_eye` and `normal` are unit vectors.
fn lit(albedo: vec3f, normal: vec3f, to_eye: vec3f) -> vec3f {
    let towards_sun = max(dot(normal, terrain.sun), 0.0);
    var color = albedo * (terrain.ambient + terrain.diffuse * towards_sun);
    if towards_sun > 0.0 {
        let half_way = normalize(terrain.sun + to_eye);
        color += vec3f(terrain.specular * pow(max(dot(normal, half_way), 0.0), terrain.shininess));
    }
    return color;
}
