// Colour of what a ray has met: the ground, a cut side of the box, its floor. Shared by all passes whose rays meet it.
#define_import_path relief::ground

#import relief::frame::Ray
#import relief::heightfield::terrain
#import relief::shading
#ifdef MATERIALS
#import relief::materials
#endif
#ifdef LAND
#import relief::land
#endif
#ifdef SHADOWS
#import relief::shadow
#endif
#ifdef CLOUD_SHADOWS
#import relief::air
#endif

// Where a ray has met the ground.
struct Met {
    // Grid space.
    point: vec3f,
    // The cell there, and where in it: finer than `point` in a deep zoom.
    cell: vec2f,
    within: vec2f,
    // Whether it is where the ray comes into the box, and the axis of the face it comes in through (3: it starts inside).
    at_entry: bool,
    axis: u32,
    // View depth, or as far as light has come: what chooses mips.
    depth: f32,
}

#ifdef SURFACE_NORMAL
// Normal of a side across `axis`, 0 to 2, that a ray of this direction meets.
fn normal_across(axis: u32, direction: vec3f) -> vec3f {
    var normal = vec3f(0.0);
    normal[min(axis, 2u)] = -sign(direction[min(axis, 2u)]);
    return normal;
}

// Normal of what was met: the face for a hit at the box's side or floor, the ground's otherwise.
fn normal_of(met: Met, direction: vec3f) -> vec3f {
    if met.at_entry && met.axis == 3u {
        // The eye is in the ground.
        return -normalize(direction);
    }
    if met.at_entry && (met.axis != 1u || direction.y > 0.0) {
        return normal_across(met.axis, direction);
    }
#ifdef DEEP_ZOOM
    return shading::normal_in_cell(met.cell, met.within);
#else
    return shading::ground_normal(met.point.xz);
#endif
}
#endif

#ifdef HOLES
// Axis across the side of a hole that was met; 3: it is the ground's surface, or where the ray comes in.
fn cut_of(met: Met, direction: vec3f) -> u32 {
    return select(shading::cut_axis(met.point, direction), 3u, met.at_entry);
}
#endif

#ifdef SHADED
// Linear light that comes back along `ray`, world space, from what it has met.
fn colour(met: Met, ray: Ray) -> vec3f {
    // A hit where the ray comes in is the cut side of the box, unless it came in through the lid.
    var wall = met.at_entry && (met.axis != 1u || ray.direction.y > 0.0);
#ifdef HOLES
    // Where a ray comes in it meets the box's side or floor, whatever is near.
    let cut = cut_of(met, ray.direction);
    wall = wall || cut != 3u;
#endif
    var albedo: vec3f;
#ifdef MATERIALS
    albedo = shading::wall_albedo(met.point.y);
#else
    // For colours, which a sampler's filter blends in 256 steps, f32 is fine enough from the map's corner, too.
    if wall {
        albedo = shading::wall_albedo(met.point.y);
    } else {
        albedo = shading::ground_albedo(met.point.xz, met.depth);
    }
#endif
#ifdef SHADING_NORMAL
    var normal = normal_of(met, ray.direction);
#ifdef HOLES
    normal = select(normal, normal_across(cut, ray.direction), cut != 3u);
#endif
#endif
#ifdef MATERIALS
    if !wall {
        let ground = materials::ground(met.point, normal, met.depth, ray.direction);
        albedo = ground.albedo;
        normal = ground.normal;
    }
#endif
#ifdef LAND
    let land_place = land::Place(met.cell, met.within);
    if !wall {
        albedo = land::albedo_of(albedo, land_place, met.depth);
    }
    let unlit = albedo;
#endif
#ifdef LIGHTING
#ifdef LIGHT_MAP
    shading::read_light_map(met.point.xz);
    if wall {
        // The map is that of the ground. Beside the box there is nothing.
#ifdef BAKED_SHADOWS
        shading::sunlight = 1.0;
#endif
#ifdef OCCLUSION
        shading::sky_share = 1.0;
#endif
    }
#endif
#ifdef SHADOWS
    // What is turned away from the sun needs no walk to it.
    shading::sunlight = 0.0;
    if shading::facing_sun(normal) > 0.0 {
        var lit_place = shadow::Place(met.cell, met.within, met.point.y);
#ifdef HOLES
        let cut_wall = cut != 3u;
        if cut_wall {
            // The light comes over the hole, not through the ground behind the wall.
            let open = clamp(floor(met.point.xz + 0.5 * normal.xz), vec2f(0.0), terrain.cells - 1.0);
            lit_place = shadow::Place(open, met.point.xz - open, met.point.y);
        }
#else
        let cut_wall = false;
#endif
        if !wall {
            lit_place = shadow::place_on_ground(lit_place.cell, lit_place.within);
        }
        // Beside the box's own sides there is nothing.
        shading::sunlight = shadow::sunlight(lit_place, !wall || cut_wall);
    }
#endif
#ifdef CLOUD_SHADOWS
    shading::cloud_light = air::cloud_light(met.point / vec3f(terrain.cells_per_unit, 1.0).xzy);
#endif
    albedo = shading::lit(albedo, normal, ray.direction * (-1.0 / length(ray.direction)));
#endif
#ifdef LAND_CONTOURS
    if !wall {
        albedo = land::with_contours(albedo, unlit, land_place, ray, met.depth);
    }
#endif
    return albedo;
}
#endif
