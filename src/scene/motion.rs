//! What moves by clocks of its own in a film: water and clouds, at a moment that counts from the film's beginning.

use super::Scene;
use super::water::WATER_PERIOD;

/// Where the clocks of water and clouds stood when a film began.
///
/// Every picture's moment is counted from there: it is the same whichever pictures were drawn before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmClocks {
    water: f64,
    clouds: f64,
}

impl FilmClocks {
    /// As they stand in `scene`.
    pub fn of(scene: &Scene) -> Self {
        Self { water: scene.water.time, clouds: scene.clouds.time }
    }

    /// Sets those clocks of `scene` that run (`water.moving`, `clouds.moving`) to `seconds` after the beginning.
    pub fn set(self, scene: &mut Scene, seconds: f64) {
        if scene.water.moving {
            scene.water.time = (self.water + seconds).rem_euclid(WATER_PERIOD);
        }
        if scene.clouds.moving {
            scene.clouds.time = self.clouds;
            scene.clouds.run(seconds);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_is_as_far_as_the_film_and_what_stands_stays() {
        let mut scene = Scene::default();
        (scene.water.time, scene.clouds.time, scene.clouds.rate) = (3599.5, 100.0, -20.0);
        let clocks = FilmClocks::of(&scene);
        clocks.set(&mut scene, 2.0);
        assert_eq!((scene.water.time, scene.clouds.time), (3599.5, 100.0), "both stand");
        (scene.water.moving, scene.clouds.moving) = (true, true);
        for seconds in [7.0, 2.0] {
            clocks.set(&mut scene, seconds);
        }
        assert_eq!((scene.water.time, scene.clouds.time), (1.5, 60.0), "no trace of the picture before");
    }
}
