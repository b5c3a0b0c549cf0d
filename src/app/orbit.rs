//! Turning around a point, going towards one, and gliding from one view to another. Knows no window.

use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};

use super::controls::{CLEARANCE, ground_below};
use crate::camera::{Camera, MAX_PITCH};
use crate::heightfield::HeightField;
use crate::heightfield::reference::Surface;

/// Degrees of a turn around the point per pixel of a drag.
const TURN_PER_PIXEL: f64 = 0.25;

/// One notch of the wheel leaves this share of the way to the point.
const ZOOM: f64 = 0.85;

/// Nearest and farthest that the wheel goes to the point, world units.
const DISTANCES: [f64; 2] = [2.0 * CLEARANCE, 50.0];

/// The share of the way to a point that is left after going there.
const ARRIVAL: f64 = 0.3;

/// Nearest and farthest from a point that one goes to it, world units.
const ARRIVALS: [f64; 2] = [0.03, 0.5];

/// A point is looked at from above, at least by this angle, degrees below the horizon.
const ARRIVAL_PITCH: f64 = -18.0;

/// How long a glide takes.
pub(crate) const GLIDE: Duration = Duration::from_millis(700);

/// The terrain and its box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    /// With its craters.
    pub(crate) map: &'a HeightField,
    /// The box, world units.
    pub(crate) size: DVec3,
}

impl Ground<'_> {
    /// Where the ray through a pixel meets the terrain, be it its surface or a side of its box.
    pub(crate) fn hit(&self, camera: &Camera, pixel: DVec2, picture: [u32; 2]) -> Option<DVec3> {
        let ray = camera.ray(pixel.x, pixel.y, picture);
        Surface::new(self.map, self.size).intersect(&ray).map(|hit| hit.position)
    }

    /// What a drag turns around: the terrain in the middle of the picture, or where that is sky, the point of the line of
    /// sight that is nearest to the middle of the terrain.
    pub(crate) fn pivot(&self, camera: &Camera, picture: [u32; 2]) -> DVec3 {
        let middle = DVec2::new(f64::from(picture[0]), f64::from(picture[1])) * 0.5;
        self.hit(camera, middle, picture).unwrap_or_else(|| {
            let forward = camera.basis().forward;
            let along = (self.size * 0.5 - camera.eye).dot(forward);
            camera.eye + forward * along.clamp(0.1, DISTANCES[1])
        })
    }

    /// Whether an eye may be at a point: above the ground, with [`CLEARANCE`].
    fn is_free(&self, eye: DVec3) -> bool {
        ground_below(self.map, self.size, eye).is_none_or(|ground| eye.y >= ground + CLEARANCE)
    }
}

/// Turns the eye around `pivot` by a drag in pixels; the distance stays, and so does the place of `pivot` in the picture. Where
/// that would go below the ground, it goes over it.
pub(crate) fn turn_around(camera: &Camera, pivot: DVec3, moved: DVec2, ground: Ground<'_>, below: bool) -> Camera {
    let basis = camera.basis();
    let offset = camera.eye - pivot;
    let seen = DVec3::new(offset.dot(basis.right), offset.dot(basis.up), offset.dot(basis.forward));
    let at = |pitch: f64| {
        let mut turned = Camera { yaw: (camera.yaw + moved.x * TURN_PER_PIXEL).rem_euclid(360.0), pitch, ..*camera };
        let basis = turned.basis();
        turned.eye = pivot + basis.right * seen.x + basis.up * seen.y + basis.forward * seen.z;
        turned
    };
    let wanted = at((camera.pitch - moved.y * TURN_PER_PIXEL).clamp(-MAX_PITCH, MAX_PITCH));
    if below || ground.is_free(wanted.eye) {
        return wanted;
    }
    // Steeper, until the eye is out of the ground; then back as far as it may.
    let mut free = wanted.pitch;
    while !ground.is_free(at(free).eye) {
        if free <= -MAX_PITCH {
            return *camera;
        }
        free = (free - 1.0).max(-MAX_PITCH);
    }
    let mut buried = (free + 1.0).min(wanted.pitch);
    for _ in 0..20 {
        let middle = 0.5 * (free + buried);
        if ground.is_free(at(middle).eye) {
            free = middle;
        } else {
            buried = middle;
        }
    }
    at(free)
}

/// Goes towards `point` by notches of the wheel, or away from it; the point stays where it is in the picture. Never below
/// the ground: where the way leads there, it ends before.
pub(crate) fn approach(camera: &Camera, point: DVec3, notches: f64, ground: Ground<'_>, below: bool) -> Camera {
    let offset = camera.eye - point;
    let distance = offset.length();
    if distance <= 0.0 || !distance.is_finite() {
        return *camera;
    }
    // Who is nearer or farther already is not thrown back.
    let wanted = (distance * ZOOM.powf(notches)).clamp(DISTANCES[0].min(distance), DISTANCES[1].max(distance));
    let at = |distance: f64| point + offset.normalize() * distance;
    let mut eye = at(wanted);
    if !below && !ground.is_free(eye) {
        let [mut free, mut buried] = [distance, wanted];
        for _ in 0..30 {
            let middle = 0.5 * (free + buried);
            if ground.is_free(at(middle)) {
                free = middle;
            } else {
                buried = middle;
            }
        }
        eye = at(free);
    }
    Camera { eye, ..*camera }
}

/// The view to go to for a closer look at a point of the ground.
pub(crate) fn arrival(camera: &Camera, point: DVec3, ground: Ground<'_>) -> Camera {
    let looking = Camera::look_at(camera.eye, point, camera.fov);
    let distance = (camera.eye.distance(point) * ARRIVAL).clamp(ARRIVALS[0], ARRIVALS[1]);
    let mut pitch = looking.pitch.clamp(-MAX_PITCH, ARRIVAL_PITCH);
    loop {
        let view = Camera { pitch, ..looking };
        let view = Camera { eye: point - view.basis().forward * distance, ..view };
        if ground.is_free(view.eye) || pitch <= -MAX_PITCH {
            return view;
        }
        pitch = (pitch - 2.0).max(-MAX_PITCH);
    }
}

/// A smooth way from one view to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glide {
    from: Camera,
    to: Camera,
    start: Instant,
}

impl Glide {
    /// A glide that begins now.
    pub(crate) fn new(from: Camera, to: Camera, now: Instant) -> Self {
        Self { from, to, start: now }
    }

    /// The eye at a moment, and whether it has arrived.
    pub(crate) fn at(&self, now: Instant) -> (Camera, bool) {
        let share = now.saturating_duration_since(self.start).as_secs_f64() / GLIDE.as_secs_f64();
        if share >= 1.0 {
            return (self.to, true);
        }
        // Starts and ends at rest.
        let share = share * share * (3.0 - 2.0 * share);
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let turn = (self.to.yaw - self.from.yaw + 180.0).rem_euclid(360.0) - 180.0;
        let camera = Camera {
            eye: self.from.eye.lerp(self.to.eye, share),
            yaw: (self.from.yaw + turn * share).rem_euclid(360.0),
            pitch: mix(self.from.pitch, self.to.pitch),
            fov: mix(self.from.fov, self.to.fov),
        };
        (camera, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::generate::{Kind, generate};

    const PICTURE: [u32; 2] = [640, 400];

    fn hills() -> HeightField {
        generate(Kind::Ridged, 129, 3)
    }

    fn pixel_of(camera: &Camera, point: DVec3) -> DVec2 {
        let seen = camera.clip_from_world(PICTURE) * point.extend(1.0);
        DVec2::new((seen.x / seen.w + 1.0) * 320.0, (1.0 - seen.y / seen.w) * 200.0)
    }

    #[test]
    fn a_drag_turns_around_the_middle_and_keeps_distance_and_place() {
        let map = hills();
        let ground = Ground { map: &map, size: map.box_size(Some(0.25)) };
        let camera = Camera::look_at(DVec3::new(0.2, 0.8, 1.2), DVec3::new(0.5, 0.1, 0.5), 60.0);
        let pivot = ground.pivot(&camera, PICTURE);
        assert!(ground.is_free(pivot + DVec3::Y * 0.01));
        let turned = turn_around(&camera, pivot, DVec2::new(120.0, -40.0), ground, false);
        assert!((turned.yaw - camera.yaw - 30.0).abs() < 1e-9 && (turned.pitch - camera.pitch - 10.0).abs() < 1e-9);
        assert!((turned.eye.distance(pivot) - camera.eye.distance(pivot)).abs() < 1e-9);
        assert!((pixel_of(&turned, pivot) - DVec2::new(320.0, 200.0)).length() < 1e-6);
    }

    /// However far it is dragged down, the eye goes over the hills and not through them.
    #[test]
    fn neither_turning_nor_the_wheel_leads_below_the_ground() {
        let map = hills();
        let ground = Ground { map: &map, size: map.box_size(Some(0.4)) };
        let mut camera = Camera::look_at(DVec3::new(0.5, 0.6, 0.8), DVec3::new(0.5, 0.2, 0.5), 60.0);
        let pivot = ground.pivot(&camera, PICTURE);
        for step in 0..300 {
            camera = turn_around(&camera, pivot, DVec2::new(7.0, -9.0), ground, false);
            assert!(ground.is_free(camera.eye), "step {step}: {camera:?}");
        }
        let down = Camera { eye: DVec3::new(0.5, 0.9, 0.5), yaw: 0.0, pitch: -90.0, fov: 60.0 };
        let mut near = down;
        for notch in 0..200 {
            let pixel = DVec2::new(f64::from(notch % 600), 150.0);
            let point = ground.hit(&near, pixel, PICTURE).unwrap_or_else(|| ground.pivot(&near, PICTURE));
            near = approach(&near, point, 1.0, ground, false);
            assert!(ground.is_free(near.eye), "notch {notch}: {near:?}");
        }
        let buried = Camera { eye: DVec3::new(0.5, -0.1, 0.5), ..down };
        let through = approach(&buried, DVec3::new(0.5, -0.5, 0.5), 3.0, ground, true);
        assert!(through.eye.y < buried.eye.y, "where it is allowed, it goes on");
    }

    #[test]
    fn the_wheel_goes_towards_the_cursor_and_back() {
        let map = hills();
        let ground = Ground { map: &map, size: map.box_size(Some(0.25)) };
        let camera = Camera::look_at(DVec3::new(0.2, 0.8, 1.2), DVec3::new(0.5, 0.1, 0.5), 60.0);
        let cursor = DVec2::new(150.0, 260.0);
        let point = ground.hit(&camera, cursor, PICTURE).unwrap();
        let near = approach(&camera, point, 3.0, ground, false);
        assert!((near.eye.distance(point) / camera.eye.distance(point) - ZOOM.powi(3)).abs() < 1e-9);
        assert!((pixel_of(&near, point) - cursor).length() < 1e-6, "what is under the cursor stays there");
        let back = approach(&near, point, -3.0, ground, false);
        assert!(back.eye.distance(camera.eye) < 1e-9);
        assert!(approach(&camera, point, 1e9, ground, false).eye.is_finite());
        assert!(approach(&camera, point, -1e9, ground, false).eye.distance(point) <= DISTANCES[1] + 1e-9);
    }

    #[test]
    fn going_there_ends_near_the_point_above_ground_and_looks_at_it() {
        let map = hills();
        let ground = Ground { map: &map, size: map.box_size(Some(0.25)) };
        let camera = Camera::look_at(DVec3::new(0.2, 0.3, 1.2), DVec3::new(0.5, 0.1, 0.5), 60.0);
        let point = ground.pivot(&camera, PICTURE);
        let there = arrival(&camera, point, ground);
        assert!(ground.is_free(there.eye) && there.eye.distance(point) < 0.5 * camera.eye.distance(point));
        assert!((pixel_of(&there, point) - DVec2::new(320.0, 200.0)).length() < 1e-6);
        let start = Instant::now();
        let glide = Glide::new(Camera { yaw: 350.0, ..camera }, Camera { yaw: 10.0, ..there }, start);
        let (middle, arrived) = glide.at(start + GLIDE / 2);
        assert!(!arrived && (middle.yaw < 1e-9 || middle.yaw > 360.0 - 1e-9), "through north: {middle:?}");
        assert_eq!(glide.at(start + GLIDE), (Camera { yaw: 10.0, ..there }, true));
    }
}
