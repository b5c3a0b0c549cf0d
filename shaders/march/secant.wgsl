// Uniform steps, then the last one solved as a piecewise-linear curve: between the last point above the ground and the
// first below it, the ray's height above the ground is taken to change evenly (Tatarchuk 2006, "Dynamic Parallax
// Occlusion Mapping with Approximate Soft Shadows"; Qu et al. 2003, "Ray Tracing Height Fields"). One division in place
// of halvings: as good where the ground is straight within a step, and no better than it where the ground is rough.
#define_import_path relief::march

#import relief::heightfield::{Segment, Hit, NO_HIT, ground_height}
#import relief::sampling::sample_count

fn march(ray: Segment) -> Hit {
    let count = sample_count(ray);
    let step = ray.end / count;
    // Heights of the ray above the ground at the last point above it, and at the point looked at.
    var above = 0.0;
    var here = 0.0;
    var i = 0.0;
    for (; i <= count; i += 1.0) {
        let p = ray.origin + ray.direction * (step * i);
        here = p.y - ground_height(p.xz);
        if here <= 0.0 {
            break;
        }
        above = here;
    }
    if i > count {
        return Hit(NO_HIT, u32(count) + 1u, 0u);
    }
    // The first sample is where the ray enters: below it there is nothing to solve, and `above` is 0. Both heights can be
    // so small that their difference is 0, too.
    let fall = above - here;
    let share = select(1.0, above / max(fall, 1e-37), fall > 0.0);
    return Hit(select(step * (i - 1.0 + share), 0.0, i == 0.0), u32(i) + 1u, 0u);
}
