// Relaxed cone stepping (Policarpo and Oliveira 2007, GPU Gems 3, chapter 18), robust between the samples: the ray goes on
// to where it leaves a cone whose ground it can enter only once; from the first point below the ground, halvings lead back
// to where it did. A rising ray takes the cones without ground.
//
// What is said of short steps in `cone.wgsl` holds here, too. The last step may be as long as a cone, so its error is that
// length over 2 to the number of halvings: more samples do not make it smaller, more halvings do.
#define_import_path relief::march

#import relief::heightfield::{terrain, Segment, Hit, NO_HIT}
#import relief::sampling::sample_count
#import relief::cones::{place_at, halved}

fn march(ray: Segment) -> Hit {
    let count = sample_count(ray);
    let step = ray.end / count;
    // Relaxed cones hold for rays that do not rise.
    let channel = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), ray.direction.y > 0.0);
    var above = 0.0;
    var t = 0.0;
    // Rounding may leave a last piece of the ray after `count` steps.
    var i = 1.0;
    for (; i <= count + 2.0; i += 1.0) {
        let place = place_at(ray, t, channel);
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
