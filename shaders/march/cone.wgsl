// Cone step mapping (Dummer 2006), robust between the samples as in Bán and Valasek 2024: from place to place the ray goes
// on to where it leaves the cone without ground that stands on the cell below it.
//
// Dummer's loop takes a fixed number of steps, and each ends short of the ground: what they do not reach is shown too
// near. Here a step is never shorter than the uniform step of the same number of samples, so the ray always gets to its
// end. A step that is longer than its cone ends in the ground or has jumped over something thin, as a uniform step may;
// that happens only near the ground, and the halvings that follow the first point below are those of such a step.
#define_import_path relief::march

#import relief::heightfield::{terrain, Segment, Hit, NO_HIT}
#import relief::sampling::sample_count
#import relief::cones::{place_at, halved}

fn march(ray: Segment) -> Hit {
    let count = sample_count(ray);
    let step = ray.end / count;
    var above = 0.0;
    var t = 0.0;
    // Rounding may leave a last piece of the ray after `count` steps.
    var i = 1.0;
    for (; i <= count + 2.0; i += 1.0) {
        let place = place_at(ray, t, vec2f(1.0, 0.0));
        if place.above <= 0.0 {
            break;
        }
        if t >= ray.end {
            return Hit(NO_HIT, u32(i), 0u);
        }
        above = t;
        t = min(t + max(place.clear, step), ray.end);
    }
    if i == 1.0 {
        return Hit(0.0, 1u, 0u);
    }
    // After the loop, not in it: rays that are drawn in step would all pay whenever one of them hits.
    return Hit(halved(ray, above, t), u32(i) + terrain.binary_steps, 0u);
}
