//! Where the cursor meets the ground, and the crater that C makes there.

use glam::{DVec2, DVec3};

use crate::camera::Camera;
use crate::heightfield::HeightField;
use crate::heightfield::reference::Surface;
use crate::scene::CraterSettings;

/// Why there is no crater at the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum PickError {
    /// The ray meets nothing.
    #[error("No crater: there is only sky under the cursor. Point at the ground.")]
    Sky,
    /// The ray meets a side of the box.
    #[error("No crater: the cursor is on the cut side of the terrain. Point at its surface.")]
    Wall,
}

/// The world position of the ground at `pixel` (from the picture's upper left corner) in a picture of `picture` pixels.
/// `size` is the terrain's box. The f64 reference is asked, so every technique digs at the same place.
pub(crate) fn ground_at(
    map: &HeightField,
    size: DVec3,
    camera: &Camera,
    pixel: DVec2,
    picture: [u32; 2],
) -> Result<DVec3, PickError> {
    let ray = camera.ray(pixel.x, pixel.y, picture);
    let hit = Surface::new(map, size).intersect(&ray).ok_or(PickError::Sky)?;
    if hit.wall { Err(PickError::Wall) } else { Ok(hit.position) }
}

/// Adds the brush's crater at a world position.
pub(crate) fn add_crater(craters: &mut CraterSettings, position: DVec3) {
    craters.list.push(craters.brush_at(position.x, position.z));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crater_lands_under_the_cursor() {
        let map = HeightField::from_raw(3, 3, &[0.0_f32, 0.5, 1.0, 0.0, 0.5, 1.0, 0.0, 0.5, 1.0]).unwrap();
        let size = map.box_size(Some(0.25));
        let picture = [640, 400];
        let camera = Camera { eye: DVec3::new(0.5, 1.5, 0.5), yaw: 20.0, pitch: -80.0, fov: 50.0 };
        let pixel = DVec2::new(300.5, 150.5);
        let position = ground_at(&map, size, &camera, pixel, picture).unwrap();
        let seen = camera.clip_from_world(picture) * position.extend(1.0);
        let back = DVec2::new((seen.x / seen.w + 1.0) * 320.0, (1.0 - seen.y / seen.w) * 200.0);
        assert!((back - pixel).length() < 1e-6, "{back} is not {pixel}");

        let mut craters = CraterSettings { radius: 0.07, ..CraterSettings::default() };
        add_crater(&mut craters, position);
        let crater = craters.list[0];
        assert_eq!((crater.x, crater.z, crater.radius), (position.x, position.z, 0.07));
    }

    #[test]
    fn the_sky_takes_no_crater() {
        let map = HeightField::from_raw(2, 2, &[0.0_f32, 1.0, 0.0, 1.0]).unwrap();
        let camera = Camera { eye: DVec3::new(0.5, 1.0, 0.5), yaw: 0.0, pitch: 45.0, fov: 50.0 };
        let picked = ground_at(&map, map.box_size(None), &camera, DVec2::new(50.0, 50.0), [100, 100]);
        assert_eq!(picked, Err(PickError::Sky));
    }
}
