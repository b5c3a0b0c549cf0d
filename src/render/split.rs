//! The split picture: which technique draws which part.

use crate::scene::{Scene, Technique};

/// A rectangle of a picture, pixels from the upper left corner; never empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Area {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Area {
    /// All of a picture.
    pub(super) fn whole([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// The least area that holds both.
    pub(super) fn union(self, other: Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let right = (self.x + self.width).max(other.x + other.width);
        let bottom = (self.y + self.height).max(other.y + other.height);
        Self { x, y, width: right - x, height: bottom - y }
    }

    /// The tiles of the side `tile` that the area touches, counted in tiles.
    pub(super) fn in_tiles(self, tile: u32) -> Self {
        let (x, y) = (self.x / tile, self.y / tile);
        let (right, bottom) = ((self.x + self.width).div_ceil(tile), (self.y + self.height).div_ceil(tile));
        Self { x, y, width: right - x, height: bottom - y }
    }

    /// Lets the draws that follow touch nothing else.
    pub(super) fn scissor(self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_scissor_rect(self.x, self.y, self.width, self.height);
    }
}

/// A part of the picture and the technique that draws it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    /// Name of the draw in the ledger.
    pub(super) name: &'static str,
    pub(super) technique: Technique,
    pub(super) area: Area,
}

/// The parts of a picture of `size` pixels, from left to right: one, or two while the scene compares techniques.
pub(super) fn sides(scene: &Scene, size: [u32; 2]) -> Vec<Side> {
    let left = Side { name: "terrain", technique: scene.march.technique, area: Area::whole(size) };
    let compare = &scene.compare;
    if !compare.enabled || compare.technique == left.technique {
        return vec![left];
    }
    let [width, height] = size;
    let line = (compare.share * f64::from(width)).round().clamp(0.0, f64::from(width)) as u32;
    let part = |x, width| Area { x, y: 0, width, height };
    let right = Side { name: "compare", technique: compare.technique, area: part(line, width - line) };
    let sides = [Side { area: part(0, line), ..left }, right];
    sides.into_iter().filter(|side| side.area.width > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(share: f64) -> Vec<(&'static str, u32, u32)> {
        let mut scene = Scene::default();
        scene.compare.enabled = true;
        scene.compare.share = share;
        sides(&scene, [101, 50]).iter().map(|side| (side.name, side.area.x, side.area.width)).collect()
    }

    /// Between the sides there is neither a gap nor an overlap, and an empty side is not drawn.
    #[test]
    fn two_sides_fill_the_picture() {
        assert_eq!(split(0.5), [("terrain", 0, 51), ("compare", 51, 50)]);
        assert_eq!(split(0.0), [("compare", 0, 101)]);
        assert_eq!(split(1.0), [("terrain", 0, 101)]);
        assert_eq!(split(0.001), [("compare", 0, 101)]);
        assert_eq!(split(f64::NAN), [("compare", 0, 101)]);
    }

    #[test]
    fn a_technique_is_not_split_from_itself() {
        let mut scene = Scene::default();
        scene.compare.enabled = true;
        scene.compare.technique = scene.march.technique;
        assert_eq!(sides(&scene, [10, 10]).len(), 1);
    }

    #[test]
    fn tiles_reach_over_the_area() {
        let area = Area { x: 15, y: 0, width: 2, height: 17 };
        assert_eq!(area.in_tiles(8), Area { x: 1, y: 0, width: 2, height: 3 });
    }
}
