// What lights the scene: the sun's disc in upright columns, the occluder that hides it, the light of the sky.
#define_import_path relief::light

struct Light {
    // Columns of the sun's disc: the way towards it along the ground, world space, of the length 1; tangents of the
    // elevations between which it lies, the lower one not below the horizon. Hard shadows have one, without a width.
    columns: array<vec4f, 5>,
    // Of each: its share of the disc, sines of the elevations between which it lies.
    shares: array<vec4f, 5>,
    // Corners of the occluder, world space.
    cube: array<vec4f, 8>,
    // Light of the sky on a surface by its normal: coefficients of spherical harmonics up to order 2.
    sky: array<vec4f, 9>,
    // Colour of the sun's light.
    sun: vec4f,
    // Cells along x and z for a texel of the light map.
    cells_per_texel: vec4f,
}

@group(1) @binding(20) var<uniform> light: Light;

#ifdef SKY_LIGHT
// Light of the sky on a surface with this normal, a unit vector (Ramamoorthi and Hanrahan 2001, equation 13; the
// constants are in the coefficients).
fn sky_light(n: vec3f) -> vec3f {
    let band0 = light.sky[0].rgb;
    let band1 = light.sky[1].rgb * n.y + light.sky[2].rgb * n.z + light.sky[3].rgb * n.x;
    let band2 = light.sky[4].rgb * (n.x * n.y) + light.sky[5].rgb * (n.y * n.z)
        + light.sky[6].rgb * (3.0 * n.z * n.z - 1.0) + light.sky[7].rgb * (n.x * n.z)
        + light.sky[8].rgb * (n.x * n.x - n.y * n.y);
    return max(band0 + band1 + band2, vec3f(0.0));
}
#endif
