//! Where light goes in a still sea, in f64, on the CPU: the twin of `shaders/water.wgsl` without waves.
//!
//! The sea is the block of water between the box's floor and a level, less the ground. Light that meets its surface is split
//! in what is mirrored and what is bent (Snell); both go straight on to the ground, as far as the box reaches.

use glam::DVec3;

use super::reference::{Surface, clip};
use crate::camera::Ray;

/// Refractive index of water.
pub const INDEX: f64 = 1.333;

/// How a leg of light ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leg {
    /// There is no such leg.
    None,
    /// It meets no ground.
    Nothing,
    /// It meets the ground, or the first one of a path the surface, after so many world units.
    At(f64),
}

/// Where the light of a ray goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Whether the ray begins under water, or comes in through a cut side of it.
    pub begins_in_water: bool,
    /// From the ray's origin to where it is split or ends.
    pub first: Leg,
    /// From the surface through air.
    pub air: Leg,
    /// From the surface through water.
    pub water: Leg,
    /// Share of light that is mirrored where the ray is split, 0 where it is not.
    pub share: f64,
}

/// A sea over a surface in its box.
#[derive(Clone, Copy, Debug)]
pub struct Sea<'a> {
    surface: Surface<'a>,
    /// World units over the floor.
    level: f64,
}

impl<'a> Sea<'a> {
    /// A sea up to `level` world units over the floor of the box of `surface`.
    pub fn new(surface: Surface<'a>, level: f64) -> Self {
        Self { surface, level }
    }

    /// Where the light of `ray` goes; `None` where it meets no water, or ground before it at the very place where it comes in.
    /// Ground that hides the surface from the ray's origin is not looked for.
    pub fn path(&self, ray: &Ray) -> Option<Path> {
        let length = ray.direction.length();
        let ray = Ray { direction: ray.direction / length, ..*ray };
        let block = DVec3 { y: self.level, ..self.surface.size() };
        let span = clip(&ray, block)?;
        let submerged = ray.origin.cmpge(DVec3::ZERO).all() && ray.origin.cmple(block).all() && ray.origin.y < block.y;
        let mut entry = ray.origin + ray.direction * span.enter;
        if let Some((axis, bound)) = span.face {
            entry[axis] = bound;
        }
        if !submerged && span.face == Some((1, self.level)) {
            return (!self.is_dry(entry)).then(|| self.split(entry, ray.direction, span.enter, false));
        }
        let met = self.length(entry, ray.direction);
        if met == Leg::At(0.0) {
            return None;
        }
        let alone = |first| Path { begins_in_water: true, first, air: Leg::None, water: Leg::None, share: 0.0 };
        let to_surface = if ray.direction.y > 0.0 { (self.level - entry.y) / ray.direction.y } else { f64::INFINITY };
        if let Leg::At(length) = met
            && length <= to_surface
        {
            return Some(alone(Leg::At(span.enter + length)));
        }
        let mut place = entry + ray.direction * to_surface;
        place.y = self.level;
        let is_over_map = place.cmpge(DVec3::ZERO).all() && place.cmple(block).all();
        Some(match is_over_map {
            true => self.split(place, ray.direction, span.enter + to_surface, true),
            false => alone(Leg::Nothing),
        })
    }

    /// The path of light that meets the surface at `place`, which is `first` from the eye, from above or from below.
    fn split(&self, place: DVec3, direction: DVec3, first: f64, from_below: bool) -> Path {
        let index = if from_below { 1.0 / INDEX } else { INDEX };
        let mirrored = DVec3 { y: -direction.y, ..direction };
        // Sine and cosine on the other side (Snell).
        let level = DVec3 { y: 0.0, ..direction } / index;
        let cosine = 1.0 - level.length_squared();
        let through = (cosine > 0.0).then(|| level + DVec3::Y * cosine.sqrt().copysign(direction.y));
        let share = through.map_or(1.0, |through| {
            let (c, t) = (direction.y.abs(), through.y.abs());
            let (across, along) = ((c - index * t) / (c + index * t), (index * c - t) / (index * c + t));
            0.5 * (across * across + along * along)
        });
        let mirrored = self.length(place, mirrored);
        let through = through.map_or(Leg::None, |through| self.length(place, through));
        let (air, water) = if from_below { (through, mirrored) } else { (mirrored, through) };
        Path { begins_in_water: from_below, first: Leg::At(first), air, water, share }
    }

    fn length(&self, origin: DVec3, direction: DVec3) -> Leg {
        self.surface.intersect(&Ray { origin, direction }).map_or(Leg::Nothing, |hit| Leg::At(hit.depth))
    }

    /// Whether a place of the surface is in the ground.
    fn is_dry(&self, place: DVec3) -> bool {
        let (field, size) = (self.surface.field(), self.surface.size());
        let [u, v] = [place.x / size.x, place.z / size.z].map(|share| share.clamp(0.0, 1.0));
        let cell = |share: f64, cells: u32| ((share * f64::from(cells)) as u32).min(cells - 1);
        let [columns, rows] = field.cells();
        field.has_ground(cell(u, columns), cell(v, rows)) && field.surface_height(u, v) * size.y > self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::HeightField;

    /// A basin a unit wide and 0.4 deep, half full, and a ray that is bent by Snell's law on its way to the bed.
    #[test]
    fn light_is_bent_mirrored_and_kept_in() {
        let mut raw = vec![1.0f64; 25];
        (1..4).for_each(|z| raw[z * 5 + 1..z * 5 + 4].fill(0.0));
        let field = HeightField::from_raw(5, 5, &raw).unwrap();
        let sea = Sea::new(Surface::new(&field, DVec3::new(1.0, 0.4, 1.0)), 0.2);
        let down = sea.path(&Ray { origin: DVec3::new(0.5, 1.0, 0.5), direction: DVec3::NEG_Y }).unwrap();
        assert_eq!((down.begins_in_water, down.air), (false, Leg::Nothing));
        let Leg::At(depth) = down.water else { panic!("{down:?}") };
        assert!((depth - 0.2).abs() < 1e-12 && (down.share - 0.0204).abs() < 1e-4, "{down:?}");
        // 48.6° is the angle beyond which all light stays in the water.
        let up = |degrees: f64| {
            let direction = DVec3::new(degrees.to_radians().sin(), degrees.to_radians().cos(), 0.0);
            sea.path(&Ray { origin: DVec3::new(0.5, 0.1, 0.5), direction }).unwrap()
        };
        assert!(up(48.0).share < 0.8 && up(48.0).air != Leg::None);
        assert!(up(49.0).share == 1.0 && up(49.0).air == Leg::None);
        // On dry land there is no water.
        assert_eq!(sea.path(&Ray { origin: DVec3::new(0.01, 1.0, 0.5), direction: DVec3::NEG_Y }), None);
    }
}
