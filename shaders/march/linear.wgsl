// Uniform steps between entering and leaving the box (the 2009 study, sections 3.3 and 3.4): the first sample at or
// below the ground is the hit. Whatever is thinner than a step can be stepped over.
#define_import_path relief::march

#import relief::heightfield::{Segment, Hit, NO_HIT, ground_height}
#import relief::sampling::sample_count

fn march(ray: Segment) -> Hit {
    let count = sample_count(ray);
    let step = ray.end / count;
    var t = 0.0;
    for (var i = 0.0; i <= count; i += 1.0) {
        t = step * i;
        let p = ray.origin + ray.direction * t;
        if p.y <= ground_height(p.xz) {
            return Hit(t, u32(i) + 1u, 0u);
        }
    }
    return Hit(NO_HIT, u32(count) + 1u, 0u);
}
