//! The same scene again.

use relief::scene::Technique;

use crate::change::with_cube;
use crate::common::{canyon, craters, picture, probe, renderer};

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let map = canyon();
    let mut first = renderer(&map);
    for technique in Technique::ALL {
        let mut scene = with_cube();
        scene.march.technique = technique;
        scene.craters.list = craters(&map);
        let expected = picture(&mut first, &scene);
        assert!(picture(&mut first, &scene) == expected, "{technique:?}: twice in one renderer");
        assert!(picture(&mut renderer(&map), &scene) == expected, "{technique:?}: in a fresh one");
        let distances = probe(&mut first, &scene).distance;
        assert!(probe(&mut first, &scene).distance == distances);
        assert!(picture(&mut first, &scene) == expected, "{technique:?}: after a probe");
    }
}
