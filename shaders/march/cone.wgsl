// Cone step mapping (Dummer 2006), with cones that are safe between the samples, too (proven in `heightfield/cone.rs`;
// Bán and Valasek 2024 treat the same weakness): from place to place the ray goes on to where it leaves the cone without
// ground that stands on the cell below it.
//
// Dummer's loop takes a fixed number of steps, and each ends short of the ground: what they do not reach is shown too
// near. Here a step is never shorter than the uniform step of the same number of samples, so the ray always gets to its
// end. A step that is longer than its cone ends in the ground or has jumped over something thin, as a uniform step may;
// that happens only near the ground, and the halvings that follow the first point below are those of such a step.
#define_import_path relief::march

#import relief::heightfield::{Segment, Hit}
#import relief::cones::step_along

fn march(ray: Segment) -> Hit {
    return step_along(ray, vec2f(1.0, 0.0));
}
