// The number of uniform steps of a ray; shared by the techniques that sample.
#define_import_path relief::sampling

#import relief::heightfield::{terrain, Segment}

fn sample_count(ray: Segment) -> f32 {
#ifdef STEPS_BY_ANGLE
    // A grazing ray crosses more of the map: it gets the most steps, a vertical one the fewest.
    return max(round(mix(terrain.samples.y, terrain.samples.x, ray.verticality)), 1.0);
#else
    return max(terrain.samples.y, 1.0);
#endif
}
