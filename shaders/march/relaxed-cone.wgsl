// Relaxed cone stepping (Policarpo and Oliveira 2007, GPU Gems 3, chapter 18), robust between the samples: the ray goes on
// to where it leaves a cone whose ground it can enter only once; from the first point below the ground, halvings lead back
// to where it did. A rising ray takes the cones without ground.
//
// What is said of short steps in `cone.wgsl` holds here, too. The last step may be as long as a cone, so its error is that
// length over 2 to the number of halvings: more samples do not make it smaller, more halvings do.
#define_import_path relief::march

#import relief::heightfield::{Segment, Hit}
#import relief::cones::step_along

fn march(ray: Segment) -> Hit {
    // Relaxed cones hold for rays that do not rise.
    return step_along(ray, select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), ray.direction.y > 0.0));
}
