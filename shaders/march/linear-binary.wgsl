// Uniform steps, then halvings between the last point above the ground and the first below it (Policarpo, Oliveira,
// Comba 2005, section 3; the 2009 study, section 3.3).
#define_import_path relief::march

#import relief::constants::MOST_HALVINGS
#import relief::heightfield::{terrain, Segment, Hit, NO_HIT, ground_height}
#import relief::sampling::sample_count

fn march(ray: Segment) -> Hit {
    let count = sample_count(ray);
    let step = ray.end / count;
    var i = 0.0;
    for (; i <= count; i += 1.0) {
        let p = ray.origin + ray.direction * (step * i);
        if p.y <= ground_height(p.xz) {
            break;
        }
    }
    if i > count {
        return Hit(NO_HIT, u32(count) + 1u, 0u);
    }
    var below = step * i;
    // The first sample is where the ray enters: below it there is nothing to halve.
    if i == 0.0 {
        return Hit(0.0, 1u, 0u);
    }
    // After the sampling loop, not in it: rays that are drawn in step would all pay whenever one of them hits.
    var above = step * (i - 1.0);
    let halvings = min(terrain.binary_steps, MOST_HALVINGS);
    for (var k = 0u; k < halvings; k++) {
        let middle = 0.5 * (above + below);
        let q = ray.origin + ray.direction * middle;
        if q.y <= ground_height(q.xz) {
            below = middle;
        } else {
            above = middle;
        }
    }
    return Hit(below, u32(i) + 1u + terrain.binary_steps, 0u);
}
