// The number of uniform steps of a ray; shared by the techniques that sample.
#define_import_path relief::sampling

#import relief::constants::MOST_SAMPLES
#import relief::heightfield::{terrain, Segment}

// At most MOST_SAMPLES, whatever the uniform says: no loop over them can hang a GPU.
fn sample_count(ray: Segment) -> f32 {
#ifdef STEPS_BY_ANGLE
    // A grazing ray crosses more of the map: it gets the most steps, a vertical one the fewest.
    return clamp(round(mix(terrain.samples.y, terrain.samples.x, ray.verticality)), 1.0, MOST_SAMPLES);
#else
    return clamp(terrain.samples.y, 1.0, MOST_SAMPLES);
#endif
}
