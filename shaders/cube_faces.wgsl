// Colours of the occluder's faces, wherever it is seen.
#define_import_path relief::cube_faces

// Outward normal of the face that a point of the unit cube, 0 to 1, lies on: that of the axis on which it is at an end.
fn face_normal(corner: vec3f) -> vec3f {
    let centred = 2.0 * corner - 1.0;
    let size = abs(centred);
    let on_x = size.x >= size.y && size.x >= size.z;
    let on_y = !on_x && size.y >= size.z;
    return sign(centred) * vec3f(vec3<bool>(on_x, on_y, !on_x && !on_y));
}

// Six bright colours: warm on the positive side of an axis, cold on the negative one.
fn face_colour(normal: vec3f) -> vec3f {
    let warm = normal.x + normal.y + normal.z > 0.0;
    return select(vec3f(0.05, 0.25, 0.9), vec3f(1.0, 0.18, 0.05), warm) * abs(normal.x)
        + select(vec3f(0.6, 0.05, 0.75), vec3f(1.0, 0.75, 0.05), warm) * abs(normal.y)
        + select(vec3f(0.05, 0.75, 0.75), vec3f(0.2, 0.85, 0.15), warm) * abs(normal.z);
}
