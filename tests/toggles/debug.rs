//! The wireframe and the views that replace the colours.

use relief::camera::NamedView;
use relief::render::{COVERS_SKY, SEE_THROUGH, SKY_BOTH, error_colour, heat_map_colour};
use relief::scene::{DebugView, Technique};

use crate::change::{Change, sampled, start};
use crate::common::pictures::{count, share};
use crate::common::{SIZE, canyon, picture, probe, renderer, scene_at};

#[test]
fn the_wireframe_adds_its_lines_only() {
    let scene = scene_at(NamedView::Over, &canyon());
    let change = Change::of(&scene, |scene| scene.debug.wireframe = true);
    change.assert_distances_kept();
    let lines = count(&change.changed);
    assert!(lines > 300 && lines < 4000, "{lines} pixels");
    let colours: Vec<_> =
        change.after.pixels().zip(&change.changed).filter_map(|(pixel, &changed)| changed.then_some(pixel)).collect();
    assert!(colours.iter().all(|&colour| colour == colours[0]), "all in the lines' colour");
}

#[test]
fn debug_views_replace_the_grounds_colours_only() {
    for view in [DebugView::Normals, DebugView::Distance] {
        let change = Change::of(&start(), |scene| scene.debug.view = view);
        change.assert_distances_kept();
        change.assert_ground_only(0.95);
    }
    let steps = Change::of(&start(), |scene| scene.debug.view = DebugView::Steps);
    steps.assert_distances_kept();
    let beside_the_box = steps.probe_before.steps.iter().zip(&steps.changed).filter(|&(&steps, _)| steps == 0);
    assert!(beside_the_box.clone().count() > 1000);
    assert!(beside_the_box.clone().all(|(_, &changed)| !changed), "the heat map covers cast rays only");
    let position = Change::of(&start(), |scene| scene.debug.view = DebugView::Position);
    position.assert_distances_kept();

    // The colours say what they should: near is bright, and more steps than the map's end are its last colour.
    let distance = Change::of(&start(), |scene| scene.debug.view = DebugView::Distance);
    let mut by_distance: Vec<(f32, u8)> = distance
        .probe_after
        .distance
        .iter()
        .copied()
        .zip(distance.after.pixels().map(|pixel| pixel.0[0]))
        .filter(|(distance, _)| distance.is_finite())
        .collect();
    by_distance.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The driver's conversion to sRGB may be off by one.
    assert!(by_distance.windows(2).all(|pair| pair[0].1.saturating_add(1) >= pair[1].1), "near is bright");
    assert!(by_distance[0].1 > by_distance[by_distance.len() - 1].1 + 20);
}

#[test]
fn the_heat_maps_range_is_a_colour_only() {
    let mut scene = start();
    scene.debug.view = DebugView::Steps;
    let change = Change::of(&scene, |scene| scene.debug.heat_map_max = 16);
    change.assert_distances_kept();
    assert_eq!(change.probe_before.steps, change.probe_after.steps);
    assert!(share(&change.changed) > 0.3);
}

/// Each pixel of the error view has the colour of its own error against the exact technique's distance.
#[test]
fn the_error_view_shows_each_pixels_own_error() {
    let map = canyon();
    let mut scene = sampled(Technique::LinearBinary);
    let mut renderer = renderer(&map);
    let technique = probe(&mut renderer, &scene).distance;
    scene.march.technique = Technique::MaxMipmap;
    let exact = probe(&mut renderer, &scene).distance;
    scene.march.technique = Technique::LinearBinary;
    scene.debug.view = DebugView::Error;
    let shown = picture(&mut renderer, &scene);
    renderer.set_reference(SIZE, Some(&exact)).unwrap();
    assert!(shown == picture(&mut renderer, &scene), "distances that were found and the same ones given");
    let cells_per_unit = f64::from(map.cells()[0].max(map.cells()[1]));
    let mut seen = [0; 4];
    for (pixel, (&found, &exact)) in shown.pixels().zip(technique.iter().zip(&exact)) {
        let (kind, wanted) = match (found.is_finite(), exact.is_finite()) {
            (false, false) => (0, SKY_BOTH),
            (false, true) => (1, SEE_THROUGH),
            (true, false) => (2, COVERS_SKY),
            (true, true) => (3, error_colour(f64::from(found - exact).abs() * cells_per_unit)),
        };
        seen[kind] += 1;
        // The difference of two distances has few digits left where it is small.
        let tolerance = if kind == 3 { 16 } else { 1 };
        let off = (0..3).map(|channel| pixel.0[channel].abs_diff(wanted[channel])).max().unwrap();
        assert!(off <= tolerance, "{pixel:?} and not {wanted:?}: {found} against {exact}");
    }
    println!("sky, see-through, covers sky, ground: {seen:?}");
    assert!(seen[0] > 1000 && seen[1] > 10 && seen[3] > 10_000, "{seen:?}");
    // The exact technique has no error against itself.
    scene.march.technique = Technique::MaxMipmap;
    renderer.set_reference(SIZE, None).unwrap();
    let black = picture(&mut renderer, &scene);
    let flat = [heat_map_colour(0.0), SKY_BOTH];
    assert!(black.pixels().all(|pixel| flat.iter().any(|colour| pixel.0[..3] == colour[..])), "an error of nothing");
}
