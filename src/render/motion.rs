//! What of the last picture water's and clouds' clocks move: what nobody sees asks for no frames.

use crate::scene::Scene;
use crate::scene::air::Kilometres;

use super::air::AirKey;
use super::clouds;
use super::prepare::{Draw, View};
use super::water::EyePlace;
use super::{Renderer, atmosphere};

/// What a picture shows that other moments of the scene's clocks would show elsewhere, whether or not those clocks run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// Waves, foam, or bubbles.
    pub water: bool,
    /// Clouds, their shadows, or either in the water.
    pub clouds: bool,
}

impl Renderer {
    /// That of the last picture. What is in view counts, whether or not hills hide it.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// That of a picture of `scene` that consists of `draws`.
    pub(super) fn motion_of(&self, scene: &Scene, view: &View, draws: &[Draw]) -> Motion {
        let shows = |name: &str| draws.iter().any(|draw| draw.name == name);
        let sea = shows("water");
        let water = &scene.water;
        // Foam is seen from above alone, bubbles from within.
        let moves = self.place_of_eye(scene, view).is_some_and(|place| {
            water.waves > 0.0
                || (water.foam > 0.0 && place == EyePlace::Above)
                || (water.bubbles && place == EyePlace::Within)
        });
        Motion { water: sea && moves, clouds: self.clouds_move(scene, view, sea, shows("occluder")) }
    }

    fn clouds_move(&self, scene: &Scene, view: &View, sea: bool, occluder: bool) -> bool {
        let Some(ground) = self.ground.as_ref().filter(|_| atmosphere::shows_clouds(scene)) else { return false };
        if !scene.clouds.shown().any(|layer| layer.speed != 0.0) {
            return false;
        }
        let on_ground = AirKey::of(scene).shadows && (self.shows_terrain(view) || occluder || sea);
        let km = Kilometres::of(ground.terrain().base(), view.extent.y);
        on_ground || sea || clouds::any_moving_in_view(scene, km, view)
    }
}
