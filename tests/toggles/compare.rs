//! Two techniques in one picture.

use relief::scene::Technique;

use crate::change::{Change, sampled};
use crate::common::pictures::count;
use crate::common::{SIZE, canyon, picture, probe, renderer};

/// On the left of the line is the one technique and on the right the other, to the pixel and wherever the line is.
#[test]
fn a_comparison_changes_the_right_part_only() {
    for (share, left, right) in [
        (0.4, Technique::MaxMipmap, Technique::Linear),
        (0.63, Technique::Linear, Technique::MaxMipmap),
        (0.013, Technique::LinearBinary, Technique::MaxMipmap),
    ] {
        let change = Change::of(&sampled(left), |scene| {
            scene.compare.enabled = true;
            scene.compare.technique = right;
            scene.compare.share = share;
        });
        let line = (share * f64::from(SIZE[0])).round() as usize;
        let width = SIZE[0] as usize;
        let on_the_right = |index: usize| index % width >= line;
        assert!(
            (0..change.changed.len()).all(|index| on_the_right(index) || !change.changed[index]),
            "the left changed"
        );
        assert!(
            count(&change.changed) as f64 / change.changed.len() as f64 > 0.05,
            "{left:?} and {right:?} look alike"
        );
        let mut renderer = renderer(&canyon());
        let (alone, probed) = (picture(&mut renderer, &sampled(right)), probe(&mut renderer, &sampled(right)));
        for (index, (after, alone)) in change.after.pixels().zip(alone.pixels()).enumerate() {
            assert!(!on_the_right(index) || after == alone, "pixel {index} is not that of {right:?}");
            let distances = (change.probe_after.distance[index], probed.distance[index]);
            assert!(!on_the_right(index) || distances.0 == distances.1, "a probe shows both sides, too");
        }
    }
}
