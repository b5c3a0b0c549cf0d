//! What of a scene its picture shows.

use crate::scene::{CraterSettings, SavedSettings, Scene};

/// The part of a scene that its picture depends on: the brush of the next crater and the speed of the spin do not show.
pub(super) fn visible_part(scene: &Scene) -> Scene {
    let CraterSettings { radius, depth, rim, .. } = CraterSettings::default();
    let mut scene = scene.clone();
    (scene.craters.radius, scene.craters.depth, scene.craters.rim) = (radius, depth, rim);
    (scene.occluder.spin, scene.water.moving) = (0.0, false);
    // Nor do the clocks of the clouds: only the moment.
    (scene.clouds.moving, scene.clouds.rate) = (false, 0.0);
    // What is added to saved pictures alone.
    scene.saved = SavedSettings::default();
    // A clock that runs makes a coarser sky than one that stands.
    if !scene.lighting.clock.enabled {
        scene.lighting.clock.speed = 0.0;
    }
    scene
}

/// The scene whose picture shows `visible`: what does not show is that of `scene`.
pub(super) fn scene_of_picture(visible: &Scene, scene: &Scene) -> Scene {
    let mut shown = visible.clone();
    let CraterSettings { radius, depth, rim, .. } = scene.craters;
    (shown.craters.radius, shown.craters.depth, shown.craters.rim) = (radius, depth, rim);
    (shown.occluder.spin, shown.water.moving) = (scene.occluder.spin, scene.water.moving);
    shown.lighting.clock.speed = scene.lighting.clock.speed;
    (shown.clouds.moving, shown.clouds.rate) = (scene.clouds.moving, scene.clouds.rate);
    shown.saved = scene.saved;
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brush_is_no_part_of_the_picture() {
        let mut scene = Scene::default();
        scene.craters.radius = 0.2;
        (scene.occluder.spin, scene.water.moving) = (5.0, true);
        (scene.clouds.moving, scene.clouds.rate) = (true, 7.0);
        scene.saved.legend = true;
        assert_eq!(visible_part(&scene), visible_part(&Scene::default()));
        assert_eq!(scene_of_picture(&visible_part(&Scene::default()), &scene), scene);
        scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
        assert_ne!(visible_part(&scene), visible_part(&Scene::default()));
    }
}
