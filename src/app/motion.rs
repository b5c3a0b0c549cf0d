//! What moves by itself: then every frame shows another picture than the last, and else none is drawn.

use super::viewer::Viewer;
use crate::scene::{Hillshade, Scene};

impl Viewer {
    /// Whether every frame shows another picture than the last.
    pub(super) fn moves(&self) -> bool {
        self.fly.is_moving()
            || self.journey.is_under_way()
            || self.spins()
            || self.sun_moves()
            || self.flows()
            || self.clouds_move()
    }

    /// Whether the clock runs where something of the picture follows the sun.
    pub(super) fn sun_moves(&self) -> bool {
        let Scene { lighting, skybox, land, .. } = &self.scene;
        lighting.clock.runs() && (lighting.enabled || skybox.enabled || land.hillshade == Hillshade::Sun)
    }

    /// Whether clouds move where the picture shows them, or their shadows; they rest for who wants less motion.
    pub(super) fn clouds_move(&self) -> bool {
        self.scene.clouds.runs() && self.motion.clouds && !self.reduces_motion()
    }

    /// Whether the occluder turns. It rests while it is out of view: nobody would see it, and no frame is drawn.
    pub(super) fn spins(&self) -> bool {
        self.scene.occluder.enabled && self.scene.occluder.spin != 0.0 && self.occluder_seen
    }

    /// Whether the water moves: it rests while it is out of view, and for who wants less motion.
    pub(super) fn flows(&self) -> bool {
        self.scene.water.runs() && self.motion.water && !self.reduces_motion()
    }
}
