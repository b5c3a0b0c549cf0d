//! What a scene may say but does not show over the terrain at hand.

use glam::DVec3;

use super::Scene;
use crate::heightfield::Crater;
use crate::scene_file::readable;

/// What is valid in `scene` but shows nothing over a terrain whose box has the size `extent`: craters that lie off the
/// map, a sea below it or over all of it. `range` is the map's in metres, where they are known. Each a sentence.
pub fn remarks(scene: &Scene, extent: DVec3, range: Option<[f64; 2]>) -> Vec<String> {
    let reaches = |crater: &&Crater| {
        let beside = |at: f64, side: f64| (at - at.clamp(0.0, side)).abs();
        beside(crater.x, extent.x).hypot(beside(crater.z, extent.z)) < crater.radius * Crater::REACH
    };
    let side = |side: f64| readable((side * 1e4).round() / 1e4);
    let off: Vec<&Crater> = scene.craters.list.iter().filter(|crater| !reaches(crater)).collect();
    let told = off.iter().take(REMARKS).map(|crater| {
        format!(
            "the crater at x {}, z {} with a radius of {} lies off the map and digs nothing: the map reaches from 0 to {} \
             in x and to {} in z",
            readable(crater.x),
            readable(crater.z),
            readable(crater.radius),
            side(extent.x),
            side(extent.z)
        )
    });
    let more = (off.len() > REMARKS).then(|| format!("{} more craters lie off the map", off.len() - REMARKS));
    let sea = scene.water.level_share(range).filter(|_| scene.water.enabled).and_then(|share| {
        if share <= 0.0 {
            Some("the sea lies below the lowest place of the map: no water shows".to_owned())
        } else if share >= 1.0 {
            Some(
                "the sea lies above the highest place of the map and covers all of it; a level is a share of the map's \
                 height, 0 to 1, or in metres, as in --water 120m"
                    .to_owned(),
            )
        } else {
            None
        }
    });
    told.chain(more).chain(sea).collect()
}

/// Remarks of one kind that are made one by one.
const REMARKS: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LevelUnit::{Metres, Share};

    #[test]
    fn craters_off_the_map_are_remarked_upon() {
        let (mut scene, extent) = (Scene::default(), DVec3::new(1.0, 0.2, 0.5));
        scene.craters.radius = 0.1;
        let mut remarks_on = |places: &[(f64, f64)]| {
            scene.craters.list = places.iter().map(|&(x, z)| scene.craters.brush_at(x, z)).collect();
            remarks(&scene, extent, None)
        };
        // On the map, and beside it with a rim that reaches in.
        assert!(remarks_on(&[(0.0, 0.0), (1.0, 0.5), (1.15, 0.2), (-0.11, -0.11), (0.5, 0.65)]).is_empty());
        let said = remarks_on(&[(0.5, 0.25), (0.5, 0.75)]);
        assert_eq!(said.len(), 1);
        assert!(said[0].contains("x 0.5, z 0.75") && said[0].contains("to 1 in x and to 0.5 in z"), "{said:?}");
        // A corner is farther off than either side.
        assert_eq!(remarks_on(&[(1.12, 0.62)]).len(), 1);
        let many = remarks_on(&[(9.0, 9.0); 1000]);
        assert_eq!((many.len(), many[3].as_str()), (4, "997 more craters lie off the map"));
    }

    /// `--water 120`, the m forgotten, drowns the map.
    #[test]
    fn a_sea_that_hides_or_misses_the_map_is_remarked_upon() {
        let (mut scene, range) = (Scene::default(), Some([500.0, 2000.0]));
        let mut said = |level, levels, enabled| {
            (scene.water.enabled, scene.water.level, scene.water.levels) = (enabled, Some(level), levels);
            remarks(&scene, DVec3::ONE, range).pop().unwrap_or_default()
        };
        assert!(said(120.0, Share, true).contains("covers all of it") && said(2000.0, Metres, true).contains("120m"));
        assert!(said(-5.0, Metres, true).contains("no water shows") && said(0.0, Share, true).contains("below"));
        assert_eq!((said(120.0, Share, false), said(0.5, Share, true)), (String::new(), String::new()));
        assert_eq!(said(501.0, Metres, true), "");
    }
}
