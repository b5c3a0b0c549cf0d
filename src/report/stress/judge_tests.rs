use super::super::terrains::Terrain;
use super::super::views::View;
use super::*;
use crate::camera::NamedView;
use crate::render::ray_start;

const SIZE: [u32; 2] = [48, 32];

/// Judges the reference's own distances, after `change` has had them.
fn judged(terrain: Terrain, view: View, change: &dyn Fn(usize, f64) -> f64) -> Judgement {
    let field = terrain.map(33).unwrap();
    let extent = field.box_size(None);
    let camera = view.camera(&field, extent);
    let start = ray_start(&camera, extent);
    let expected = Surface::new(&field, extent).distances(&camera, SIZE, &|_| {});
    let pixel = |(index, &expected): (usize, &f64)| {
        let distance = change(index, expected);
        let at = [index as u32 % SIZE[0], index as u32 / SIZE[0]].map(|at| f64::from(at) + 0.5);
        let length = camera.ray(at[0], at[1], SIZE).direction.length();
        Pixel { index, expected, distance: distance as f32, beyond_start: (distance / length - start) as f32, start }
    };
    let pixels: Vec<_> = expected.iter().enumerate().map(pixel).collect();
    Judge { field: &field, extent, camera: &camera, size: SIZE, cell: extent.x / 32.0, anchors: &[] }.judge(&pixels)
}

fn wrong(judgement: &Judgement) -> [u64; 4] {
    [judgement.missed, judgement.invented, judgement.astray, judgement.nan]
}

#[test]
fn the_reference_rounded_to_f32_is_exact_from_near_and_far() {
    for terrain in [Terrain::Noise, Terrain::Needles, Terrain::Saddle, Terrain::FlatLow] {
        for view in [View::Named(NamedView::Graze), View::Far(1e3), View::Far(1e6), View::Skim] {
            let judgement = judged(terrain, view, &|_, distance| distance);
            assert_eq!(wrong(&judgement), [0; 4], "{terrain:?} {view:?}: {judgement:?}");
            assert!(judgement.hits > 100 && judgement.ratio < 0.5, "{terrain:?} {view:?}: {judgement:?}");
        }
    }
}

/// A hundred-thousandth of the map is ten times the bound, from wherever it is seen.
#[test]
fn what_is_off_by_more_than_the_bound_is_found() {
    for view in [View::Named(NamedView::Down), View::Far(1e3), View::Far(1e6)] {
        for by in [-3e-5, 3e-5] {
            let judgement = judged(Terrain::Noise, view, &|_, distance| distance + by);
            assert!(judgement.astray * 10 > judgement.hits * 9, "{view:?} {by}: {judgement:?}");
            assert!(judgement.ratio > 1.0);
        }
    }
}

#[test]
fn holes_phantoms_and_numbers_that_are_none_are_counted() {
    let view = View::Named(NamedView::Graze);
    let whole = judged(Terrain::Terraces, view, &|_, distance| distance);
    let hole = |index: usize, distance: f64| if index == 24 + 48 * 20 { f64::INFINITY } else { distance };
    let phantom = |index: usize, distance: f64| if index == 24 { 0.5 } else { distance };
    let none = |index: usize, distance: f64| if index == 7 { f64::NAN } else { distance };
    assert_eq!(wrong(&judged(Terrain::Terraces, view, &hole)), [1, 0, 0, 0]);
    assert_eq!(wrong(&judged(Terrain::Terraces, view, &phantom)), [0, 1, 0, 0]);
    assert_eq!(wrong(&judged(Terrain::Terraces, view, &none)), [0, 0, 0, 1]);
    assert!(whole.hits > 500 && whole.pixels > whole.hits);
}

/// The ground behind a wall is on the ground, but the wall is in the way.
#[test]
fn a_wall_that_is_seen_through_onto_other_ground_is_found() {
    let view = View::Named(NamedView::Graze);
    let flat = Terrain::FlatLow.map(33).unwrap();
    let wall = Terrain::Wall.map(33).unwrap();
    let extent = wall.box_size(None);
    let camera = view.camera(&wall, extent);
    let behind = Surface::new(&flat, extent).distances(&camera, SIZE, &|_| {});
    let judgement = judged(Terrain::Wall, view, &|index, _| behind[index]);
    assert!(judgement.astray > 20, "{judgement:?}");
}
