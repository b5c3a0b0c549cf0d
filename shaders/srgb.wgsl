// Debug colours are meant as the bytes on the screen; the target encodes linear light.
#define_import_path relief::srgb

fn from_srgb(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}
