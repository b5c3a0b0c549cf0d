//! What a map's numbers stand for: heights and extent in metres, its place, and the proportion of its box.

use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::DVec3;

use super::{Georeference, HeightField};

/// Height of the box over its longer horizontal side where a map does not say what it shows.
pub(in crate::heightfield) const PLAIN_HEIGHT_SCALE: f64 = 0.25;

/// Heights of the box over its longer horizontal side that can be drawn; 0 is flat.
pub(crate) const HEIGHT_SCALES: RangeInclusive<f64> = 0.0..=1000.0;

/// How many times their true proportion heights can be made by hand.
pub(crate) const EXAGGERATIONS: RangeInclusive<f64> = 0.1..=100.0;

/// West–east extent over north–south extent: far beyond any map, and within what single precision can march.
pub(in crate::heightfield) const EXTENT_RATIOS: RangeInclusive<f64> = 1e-5..=1e5;

impl HeightField {
    /// The map with the horizontal extent west–east and north–south, in metres between the outermost samples. One that
    /// no map has ([`Self::is_extent`]) counts as unknown.
    #[must_use]
    pub fn with_extent_metres(mut self, extent: Option<[f64; 2]>) -> Self {
        self.extent_metres = extent.filter(|&extent| Self::is_extent(extent));
        self
    }

    /// Whether a map can have this extent: both sides finite and above 0, and neither a hundred thousand times the other.
    pub fn is_extent([x, z]: [f64; 2]) -> bool {
        x > 0.0 && z > 0.0 && (x + z).is_finite() && EXTENT_RATIOS.contains(&(x / z))
    }

    /// The map with other meanings for the normalised heights 0 and 1. What is no range (not finite, or so far apart that
    /// its span is not) is not taken.
    #[must_use]
    pub fn with_range(mut self, range: [f64; 2]) -> Self {
        if (range[1] - range[0]).is_finite() {
            self.range = range;
        }
        self
    }

    /// The map with a factor on its natural height scale; 1 is the true proportion, and holds in place of a factor that
    /// is not finite or below 0.
    #[must_use]
    pub fn with_exaggeration(mut self, factor: f64) -> Self {
        self.exaggeration = if factor.is_finite() && factor >= 0.0 { factor } else { 1.0 };
        self
    }

    /// The map at a place in a reference system; a place that no map has ([`Georeference`]'s steps) counts as unknown.
    #[must_use]
    pub fn with_georeference(mut self, place: Option<Georeference>) -> Self {
        self.georeference = place.filter(Georeference::is_sound).map(Arc::new);
        self
    }

    /// The map with heights that are metres, or of a unit that is not known.
    #[must_use]
    pub fn with_metres(mut self, metric: bool) -> Self {
        self.metric = metric;
        self
    }

    /// Where the samples lie, where that is known.
    pub fn georeference(&self) -> Option<&Georeference> {
        self.georeference.as_deref()
    }

    /// Whether [`Self::range`] is in metres: said so, or because the extent is (they count as metres then).
    pub fn has_metres(&self) -> bool {
        self.metric || self.extent_metres.is_some()
    }

    /// What the normalised heights 0 and 1 stand for, in the source's own unit (metres, where it has one).
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// What the heights 0 and 1 stand for in metres, where the map's scale is known.
    pub fn metric_range(&self) -> Option<[f64; 2]> {
        self.extent_metres.map(|_| self.range)
    }

    /// Horizontal extent west–east and north–south in metres, where it is known.
    pub fn extent_metres(&self) -> Option<[f64; 2]> {
        self.extent_metres
    }

    /// Height of the box over its longer horizontal side: the true proportion times the map's exaggeration where the
    /// extent is known (the range then counts as metres), else 0.25. At most what can be drawn.
    pub fn natural_height_scale(&self) -> f64 {
        let scale = Self::proportion(self.extent_metres, self.range) * self.exaggeration;
        // 0 · ∞: a flat map stays flat, however much it is exaggerated.
        if scale.is_nan() { 0.0 } else { scale.clamp(*HEIGHT_SCALES.start(), *HEIGHT_SCALES.end()) }
    }

    /// Height of the box over its longer horizontal side with nothing exaggerated: the true proportion where the extent is
    /// known, else the one that such maps are given. What can be drawn.
    pub fn true_height_scale(&self) -> f64 {
        let scale = Self::proportion(self.extent_metres, self.range);
        if scale.is_nan() { 0.0 } else { scale.clamp(*HEIGHT_SCALES.start(), *HEIGHT_SCALES.end()) }
    }

    /// Height over longer side: true where the extent is known.
    pub(in crate::heightfield) fn proportion(extent_metres: Option<[f64; 2]>, range: [f64; 2]) -> f64 {
        extent_metres.map_or(PLAIN_HEIGHT_SCALE, |[x, z]| (range[1] - range[0]) / x.max(z))
    }

    /// Size of the box in world units: the longer horizontal side is 1. `height_scale` `None` is the natural one.
    pub fn box_size(&self, height_scale: Option<f64>) -> DVec3 {
        let [x, z] = self.extent_metres.unwrap_or(self.cells().map(f64::from));
        let longer = x.max(z);
        DVec3::new(x / longer, height_scale.unwrap_or_else(|| self.natural_height_scale()), z / longer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The box goes to the shader.
    #[test]
    fn whatever_a_map_is_said_to_show_its_box_can_be_drawn() {
        let numbers =
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, f64::from_bits(1), 1e38, 1e308, -1.0, 1.0];
        let field = HeightField::from_raw(3, 4, &(0..12).map(f64::from).collect::<Vec<_>>()).unwrap();
        for (a, b) in numbers.into_iter().flat_map(|a| numbers.map(|b| (a, b))) {
            for factor in numbers {
                let field = field.clone().with_extent_metres(Some([a, b])).with_range([b, a]).with_exaggeration(factor);
                let size = field.box_size(None);
                let sound = size.is_finite() && HEIGHT_SCALES.contains(&size.y) && size.x.min(size.z) >= 1e-5;
                assert!(sound && size.x.max(size.z) == 1.0, "{size} of {a}, {b}, {factor}");
            }
        }
    }

    #[test]
    fn the_box_keeps_the_proportions() {
        let field = HeightField::from_raw(5, 3, &(0..15).map(f64::from).collect::<Vec<_>>()).unwrap();
        assert_eq!(field.box_size(None), DVec3::new(1.0, 0.25, 0.5), "plain image: from the cells");
        let placed = field.with_range([100.0, 400.0]).with_extent_metres(Some([500.0, 1000.0]));
        assert_eq!(placed.box_size(None), DVec3::new(0.5, 0.3, 1.0), "placed on the ground: true proportion");
        assert_eq!(placed.box_size(Some(2.0)).y, 2.0);
        assert_eq!(placed.with_exaggeration(2.0).natural_height_scale(), 0.6);
    }
}
