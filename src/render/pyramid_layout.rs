//! Where the levels of the maximum pyramid lie in its texture.

/// The walk starts at the level whose longer side has at most this many nodes: higher levels save no step, and a
/// texture without them needs less padding.
pub(super) const MOST_TOP_NODES: u32 = 16;

/// Where the levels of a pyramid lie in one texture: one after the other along its longer side, level 1 first.
#[derive(Clone, Copy, Debug)]
pub(super) struct PyramidLayout {
    /// Twice the longer side of level 1, padded so that it can be halved for each level; 0 along the shorter side. What
    /// the levels reach together comes near to it.
    pub(super) stack: [u32; 2],
    finest: [u32; 2],
}

impl PyramidLayout {
    /// The layout of so many levels, the finest of which has the size `finest`.
    pub(super) fn new(finest: [u32; 2], levels: u32) -> Self {
        let [width, height] = finest;
        let padded = |side: u32| 2 * side.next_multiple_of(1 << (levels - 1));
        let stack = if height >= width { [0, padded(height)] } else { [padded(width), 0] };
        Self { stack, finest }
    }

    /// Where the level with this number begins.
    pub(super) fn place_of(&self, level: u32) -> [u32; 2] {
        self.stack.map(|reach| reach - (reach >> (level - 1)))
    }

    /// Size of the texture.
    pub(super) fn size(&self) -> [u32; 2] {
        std::array::from_fn(|axis| self.stack[axis].max(self.finest[axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two levels over one another would let rays through the ground; and the texture is to be little larger than them.
    #[test]
    fn every_level_has_its_own_place() {
        for finest in
            [[1, 1], [2, 1], [1, 9], [9, 1], [17, 40], [256, 256], [511, 300], [1500, 2], [1, 8192], [8192, 8192]]
        {
            let most = (1..).find(|level| finest[0].max(finest[1]) >> (level - 1) <= MOST_TOP_NODES).unwrap_or(1);
            for levels in 1..=most {
                let layout = PyramidLayout::new(finest, levels);
                let rect = |level: u32| (layout.place_of(level), finest.map(|side| side.div_ceil(1 << (level - 1))));
                let whole = layout.size();
                for level in 1..=levels {
                    let ([x, y], [width, height]) = rect(level);
                    assert!(x + width <= whole[0] && y + height <= whole[1], "{finest:?}, level {level} of {levels}");
                    for other in 1..level {
                        let ([left, top], [across, down]) = rect(other);
                        let apart = left + across <= x || x + width <= left || top + down <= y || y + height <= top;
                        assert!(apart, "{finest:?}: levels {other} and {level} of {levels} overlap");
                    }
                }
                let texels = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
                assert!(texels(whole) <= 9 * texels(finest) / 4 + 64, "{finest:?}, {levels} levels: {whole:?}");
            }
        }
    }
}
