//! Maxima over surfaces that lie elsewhere than the bilinear one: what lets a ray pass over whole nodes of them.

use rayon::prelude::*;

use super::fractal::Detail;
use super::{HeightField, MaxPyramid, NodeRect, SampleRect, smooth};

/// Which surfaces are bounded, besides the bilinear one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rule {
    /// The smooth one ([`super::smooth`]).
    pub smooth: bool,
    /// The one with invented detail ([`super::fractal`]).
    pub detail: Option<Detail>,
}

impl Rule {
    /// Whether there is any.
    pub fn is_any(&self) -> bool {
        self.smooth || self.detail.is_some()
    }

    /// A height for a sample such that nowhere in a cell the surfaces are higher than the highest of its four corners'.
    fn bound(&self, field: &HeightField, x: u32, y: u32) -> f64 {
        let smooth = if self.smooth { smooth::bound(field, x, y) } else { 0.0 };
        let detailed = self.detail.map_or(0.0, |detail| detail.bound(field, x, y));
        f64::from(field.sample(x, y)).max(smooth).max(detailed)
    }
}

/// The highest that the surfaces of a cell can be, as samples do it: their bounds are the pyramid over them.
#[derive(Clone, Debug)]
pub struct SurfaceBounds {
    rule: Rule,
    bounds: HeightField,
    pyramid: MaxPyramid,
}

impl SurfaceBounds {
    /// The bounds of the surfaces of `field`, which has no holes.
    pub fn new(field: &HeightField, rule: Rule) -> Self {
        let mut bounds = field.clone();
        let all = SampleRect { x: 0, y: 0, width: field.width(), height: field.height() };
        raise(&mut bounds, field, all, rule);
        let pyramid = MaxPyramid::build(&bounds);
        Self { rule, bounds, pyramid }
    }

    /// What they bound.
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// The bound of a sample.
    #[cfg(test)]
    pub(super) fn bound(&self, x: u32, y: u32) -> f32 {
        self.bounds.sample(x, y)
    }

    /// Brings the bounds up to date with the samples `dirty` of `field`; returns the nodes that may have changed.
    pub fn update(&mut self, field: &HeightField, dirty: SampleRect) -> Vec<NodeRect> {
        // Each surface depends on the samples around.
        let (x, y) = (dirty.x.saturating_sub(1), dirty.y.saturating_sub(1));
        let right = (dirty.x + dirty.width + 1).min(field.width());
        let bottom = (dirty.y + dirty.height + 1).min(field.height());
        let wider = SampleRect { x, y, width: right - x, height: bottom - y };
        raise(&mut self.bounds, field, wider, self.rule);
        self.pyramid.update(&self.bounds, wider)
    }

    /// Maxima over the cells; their layout is that of the samples' own pyramid.
    pub fn pyramid(&self) -> &MaxPyramid {
        &self.pyramid
    }
}

/// Writes the bounds of the samples `rect` of `field`. A bound is never rounded down.
fn raise(bounds: &mut HeightField, field: &HeightField, rect: SampleRect, rule: Rule) {
    let units = field.units().map(f64::from);
    let width = field.width() as usize;
    let rows = rect.y as usize * width..(rect.y + rect.height) as usize * width;
    bounds.samples_mut()[rows].par_chunks_mut(width).enumerate().for_each(|(offset, row)| {
        let y = rect.y + offset as u32;
        for x in rect.x..rect.x + rect.width {
            let bound = rule.bound(field, x, y).min(1.0);
            row[x as usize] = match units {
                Some(units) => ((bound * units - 1e-9).ceil() / units) as f32,
                None if f64::from(bound as f32) < bound => (bound as f32).next_up(),
                None => bound as f32,
            };
        }
    });
}
