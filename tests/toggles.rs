//! Each toggle changes what it should, and only that.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

use std::path::PathBuf;

use common::pictures::{changed, count, share, sky};
use common::{SIZE, canyon, crater_on_the_summit, craters, picture, probe, renderer, scene_at, scratch_file};
use glam::DVec3;
use image::{Rgb, RgbImage, RgbaImage};
use relief::camera::NamedView;
use relief::heightfield::reference::Surface;
use relief::heightfield::{Crater, EditedTerrain, HeightField};
use relief::render::{COVERS_SKY, Probe, Renderer, SEE_THROUGH, SKY_BOTH, error_colour, heat_map_colour};
use relief::scene::{CraterMode, DebugView, HeightFilter, Scene, Technique};

/// A scene before and after a change: pictures, distances, and which pixels differ.
struct Change {
    renderer: Renderer,
    before: RgbaImage,
    after: RgbaImage,
    probe_before: Probe,
    probe_after: Probe,
    changed: Vec<bool>,
    sky: Vec<bool>,
}

impl Change {
    /// Both from one renderer, as when a switch is flipped.
    fn of(base: &Scene, change: impl FnOnce(&mut Scene)) -> Self {
        let mut scene = base.clone();
        change(&mut scene);
        let mut renderer = renderer(&canyon());
        let before = picture(&mut renderer, base);
        let probe_before = probe(&mut renderer, base);
        let after = picture(&mut renderer, &scene);
        let probe_after = probe(&mut renderer, &scene);
        let (changed, sky) = (changed(&before, &after), sky(&probe_before));
        Self { renderer, before, after, probe_before, probe_after, changed, sky }
    }

    fn assert_distances_kept(&self) {
        assert_eq!(self.probe_before.distance, self.probe_after.distance, "distances must not change");
    }

    /// Pixels of the ground change, at least this share of them, and no others.
    fn assert_ground_only(&self, least: f64) {
        let ground = count(&self.sky.iter().map(|sky| !sky).collect::<Vec<_>>());
        assert!(!self.changed.iter().zip(&self.sky).any(|(&changed, &sky)| changed && sky), "the sky changed");
        let share = count(&self.changed) as f64 / ground as f64;
        assert!(share >= least, "only {share} of the ground changed");
    }

    /// Pixels of the sky change, at least this share of them, and no others.
    fn assert_sky_only(&self, least: f64) {
        assert!(!self.changed.iter().zip(&self.sky).any(|(&changed, &sky)| changed && !sky), "the ground changed");
        let share = count(&self.changed) as f64 / count(&self.sky) as f64;
        assert!(share >= least, "only {share} of the sky changed");
    }
}

fn start() -> Scene {
    scene_at(NamedView::Start, &canyon())
}

/// The start view with an occluder in it.
fn with_cube() -> Scene {
    let mut scene = start();
    scene.occluder.enabled = true;
    scene.occluder.size = 0.2;
    scene
}

/// A sampling technique from the side, where its errors show.
fn sampled(technique: Technique) -> Scene {
    let mut scene = scene_at(NamedView::Graze, &canyon());
    scene.march.technique = technique;
    (scene.march.samples_min, scene.march.samples_max) = (24, 64);
    scene
}

/// Distance errors against the reference where both see ground, in cells, smallest first.
fn errors(probe: &Probe, scene: &Scene, field: &HeightField) -> Vec<f64> {
    let extent = field.box_size(scene.terrain.height_scale);
    let cell = extent.x / f64::from(field.cells()[0]);
    let expected = Surface::new(field, extent).distances(&scene.camera.unwrap(), SIZE, &|_| {});
    let pairs = probe.distance.iter().map(|&distance| f64::from(distance)).zip(expected);
    let both = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
    let mut errors: Vec<_> = both.map(|(a, b)| (a - b).abs() / cell).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// The mean of the errors, in cells.
fn error(probe: &Probe, scene: &Scene, field: &HeightField) -> f64 {
    let errors = errors(probe, scene, field);
    errors.iter().sum::<f64>() / errors.len() as f64
}

fn checker() -> PathBuf {
    let path = scratch_file("toggles-checker.png");
    let square = |x: u32, y: u32| Rgb(if (x / 8 + y / 8).is_multiple_of(2) { [230, 190, 60] } else { [40, 70, 140] });
    RgbImage::from_fn(64, 64, square).save(&path).unwrap();
    path
}

#[test]
fn lighting_changes_the_ground_and_nothing_in_it() {
    let change = Change::of(&start(), |scene| scene.lighting.enabled = false);
    change.assert_distances_kept();
    change.assert_ground_only(0.9);
}

/// Sets one number of a scene.
type Set = fn(&mut Scene);

#[test]
fn each_term_of_the_light_brightens_the_ground_only() {
    let brightness = |picture: &RgbaImage| -> u64 {
        picture.pixels().map(|pixel| pixel.0[..3].iter().map(|&channel| u64::from(channel)).sum::<u64>()).sum()
    };
    let terms: [(&str, Set); 3] = [
        ("ambient", |scene| scene.lighting.ambient = 0.5),
        ("diffuse", |scene| scene.lighting.diffuse = 1.4),
        ("specular", |scene| scene.lighting.specular = 0.8),
    ];
    for (name, set) in terms {
        let change = Change::of(&start(), set);
        change.assert_distances_kept();
        // A hillside without sun has neither of the last two.
        change.assert_ground_only(if name == "ambient" { 0.9 } else { 0.3 });
        assert!(brightness(&change.after) > brightness(&change.before), "{name}");
    }
    let mut glossy = start();
    glossy.lighting.specular = 0.8;
    let change = Change::of(&glossy, |scene| scene.lighting.shininess = 200.0);
    change.assert_ground_only(0.2);
    assert!(brightness(&change.after) < brightness(&change.before), "a narrower highlight");
}

/// The sky's sun moves with the light.
#[test]
fn the_suns_direction_moves_shading_and_sun_disc_but_no_ground() {
    let mut scene = start();
    scene.skybox.enabled = false;
    let change = Change::of(&scene, |scene| scene.lighting.sun_azimuth += 120.0);
    change.assert_distances_kept();
    change.assert_ground_only(0.8);

    // Looking where the new sun stands.
    let mut towards = start();
    towards.lighting.sun_elevation = 12.0;
    let azimuth = towards.camera.unwrap().yaw as f32;
    let mut camera = towards.camera.unwrap();
    camera.pitch = 12.0;
    towards.camera = Some(camera);
    let change = Change::of(&towards, |scene| scene.lighting.sun_azimuth = azimuth);
    let at_centre = change.after.get_pixel(SIZE[0] / 2, SIZE[1] / 2).0;
    assert!(at_centre[..3].iter().all(|&channel| channel > 230), "the sun's disc, not {at_centre:?}");
}

#[test]
fn the_skybox_changes_the_sky_only() {
    let off = Change::of(&with_cube(), |scene| scene.skybox.enabled = false);
    off.assert_distances_kept();
    off.assert_sky_only(0.95);
    let background = off.after.pixels().zip(&off.sky).find(|&(_, &sky)| sky).unwrap().0;
    assert!(off.after.pixels().zip(&off.sky).all(|(pixel, &sky)| !sky || pixel == background), "one flat colour");

    let flat = Change::of(&with_cube(), |scene| scene.skybox.flattening = 4.0);
    flat.assert_sky_only(0.05);

    let face = checker();
    let images = Change::of(&with_cube(), |scene| scene.skybox.faces = Some(std::array::from_fn(|_| face.clone())));
    images.assert_sky_only(0.95);
}

#[test]
fn diffuse_settings_change_colours_only() {
    let file = checker();
    let mut with_image = start();
    with_image.diffuse.file = Some(file.clone());
    let changes = [
        Change::of(&start(), |scene| scene.diffuse.enabled = false),
        Change::of(&start(), |scene| scene.diffuse.file = Some(file)),
        Change::of(&with_image, |scene| scene.diffuse.repeats = 3.0),
    ];
    for change in changes {
        change.assert_distances_kept();
        change.assert_ground_only(0.3);
    }
}

#[test]
fn the_occluder_changes_its_own_pixels_only() {
    let change = Change::of(&start(), |scene| {
        scene.occluder.enabled = true;
        scene.occluder.size = 0.2;
    });
    let cube: Vec<bool> =
        change.probe_before.distance.iter().zip(&change.probe_after.distance).map(|(a, b)| b < a).collect();
    assert!(count(&cube) > 500);
    assert_eq!(change.changed, cube, "just the pixels where the cube is nearer than what was there");
    let elsewhere = change.probe_before.distance.iter().zip(&change.probe_after.distance).zip(&cube);
    assert!(elsewhere.clone().all(|((a, b), &cube)| cube || a == b));
    let moved = Change::of(&with_cube(), |scene| scene.occluder.rotation = DVec3::new(75.0, 10.0, 20.0));
    assert!(count(&moved.changed) > 200 && share(&moved.changed) < 0.3);
}

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

/// Halvings find the place within the step that uniform samples found.
#[test]
fn halvings_make_the_hit_exact_and_lose_none() {
    let map = canyon();
    let scene = sampled(Technique::LinearBinary);
    let without = Change::of(&scene, |scene| scene.march.binary_steps = 0);
    let exact = error(&without.probe_before, &scene, &map);
    let coarse = error(&without.probe_after, &scene, &map);
    println!("mean error in cells: 8 halvings {exact:.4}, none {coarse:.4}");
    assert!(exact < 0.5 * coarse, "{exact} against {coarse}");
    assert_eq!(sky(&without.probe_before), sky(&without.probe_after), "the same rays hit");
    assert!(
        without.probe_before.distance.iter().zip(&without.probe_after.distance).all(|(fine, coarse)| fine <= coarse)
    );
    let mut renderer = without.renderer;
    let linear = picture(&mut renderer, &sampled(Technique::Linear));
    assert!(linear == without.after, "without halvings `linear-binary` is `linear`, byte for byte");
}

#[test]
fn more_samples_are_more_exact() {
    let scene = sampled(Technique::Linear);
    let change = Change::of(&scene, |scene| scene.march.samples_max = 512);
    let (few, many) = (error(&change.probe_before, &scene, &canyon()), error(&change.probe_after, &scene, &canyon()));
    println!("linear, mean error in cells: 64 samples {few:.3}, 512 samples {many:.3}");
    assert!(many < 0.5 * few, "{many} against {few}");
    assert!(change.probe_after.step_stats().0 > 2.0 * change.probe_before.step_stats().0);
}

/// With steps by angle a steep ray takes fewer; fixed, all rays that meet nothing take as many.
#[test]
fn steps_by_angle_spare_steep_rays() {
    let mut scene = scene_at(NamedView::Down, &canyon());
    scene.march.technique = Technique::Linear;
    (scene.march.samples_min, scene.march.samples_max) = (32, 256);
    let fixed = Change::of(&scene, |scene| scene.march.steps_by_angle = false);
    let (by_angle, all) = (fixed.probe_before.step_stats(), fixed.probe_after.step_stats());
    assert!(by_angle.0 < 0.6 * all.0, "{by_angle:?} against {all:?}");
    assert!(all.1 <= 257 && by_angle.1 < all.1);
    let coarse = error(&fixed.probe_before, &scene, &canyon());
    let fine = error(&fixed.probe_after, &scene, &canyon());
    assert!(fine < coarse, "more steps, less error: {fine} against {coarse}");
    let minimum = Change::of(&scene, |scene| scene.march.samples_min = 200);
    assert!(minimum.probe_after.step_stats().0 > 1.5 * by_angle.0);
}

#[test]
fn the_nearest_filter_makes_a_field_of_boxes() {
    let mut scene = scene_at(NamedView::Down, &canyon());
    scene.march.technique = Technique::LinearBinary;
    scene.march.binary_steps = 16;
    let change = Change::of(&scene, |scene| scene.march.filter = HeightFilter::Nearest);
    // Looking straight down from far, a hit's height is that of the sample below it.
    let (map, camera) = (canyon(), scene.camera.unwrap());
    let extent = map.box_size(None);
    let [columns, rows] = map.cells().map(f64::from);
    let (mut on_a_top, mut hits) = (0, 0);
    for (index, &distance) in
        change.probe_after.distance.iter().enumerate().filter(|(_, distance)| distance.is_finite())
    {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
        let hit = ray.origin + ray.direction.normalize() * f64::from(distance);
        let nearest = |share: f64, cells: f64| (share.clamp(0.0, 1.0) * cells + 0.5).floor() as u32;
        let sample = map.sample(nearest(hit.x / extent.x, columns), nearest(hit.z / extent.z, rows));
        on_a_top += usize::from((f64::from(sample) * extent.y - hit.y).abs() < 1e-5);
        hits += 1;
    }
    assert!(on_a_top as f64 > 0.85 * f64::from(hits), "{on_a_top} of {hits} hits lie on a box's top");
    let (smooth, stepped) = (error(&change.probe_before, &scene, &map), error(&change.probe_after, &scene, &map));
    assert!(stepped > 10.0 * smooth, "{stepped} against {smooth}");
}

#[test]
fn the_hardware_filter_is_close_to_exact_but_not_exact() {
    // Near the ground a step of a 256th of a cell is wide.
    let mut scene = scene_at(NamedView::Valley, &canyon());
    scene.march.technique = Technique::LinearBinary;
    (scene.march.samples_max, scene.march.binary_steps) = (512, 20);
    let change = Change::of(&scene, |scene| scene.march.filter = HeightFilter::HardwareLinear);
    let differ = change
        .probe_before
        .distance
        .iter()
        .zip(&change.probe_after.distance)
        .filter(|(exact, by_hardware)| exact != by_hardware);
    assert!(differ.count() > 1000, "the sampler rounds its own way");
    let [exact, by_hardware] = [&change.probe_before, &change.probe_after]
        .map(|probe| errors(probe, &scene, &canyon()))
        .map(|errors| errors[errors.len() / 2]);
    println!("median error in cells: exact {exact:.2e}, hardware {by_hardware:.2e}");
    // Weights of 8 bits, as GPUs have them, cost up to some hundredths of a cell; a software driver's cost nothing.
    assert!(by_hardware < exact + 0.05, "{by_hardware} against {exact}");
}

#[test]
fn the_filter_is_nothing_to_the_exact_technique() {
    let change = Change::of(&start(), |scene| scene.march.filter = HeightFilter::Nearest);
    change.assert_distances_kept();
    assert_eq!(count(&change.changed), 0);
}

#[test]
fn kept_misses_fill_the_box_and_leave_the_ground() {
    for technique in Technique::ALL {
        let mut scene = start();
        scene.march.technique = technique;
        let change = Change::of(&scene, |scene| scene.march.discard_misses = false);
        let sky_after = sky(&change.probe_after);
        assert!(count(&sky_after) < count(&change.sky), "some of the sky becomes ground");
        for (index, &was_sky) in change.sky.iter().enumerate() {
            if !was_sky {
                assert!(!change.changed[index] && !sky_after[index], "ground stays as it is");
            } else if sky_after[index] {
                assert!(!change.changed[index], "sky beside the box stays sky");
            }
        }
    }
}

/// After the summit is gone the lowered start spends no sample above the highest ground.
#[test]
fn the_lowered_start_spends_its_samples_where_the_ground_is() {
    let map = canyon();
    let mut scene = scene_at(NamedView::Over, &map);
    scene.march.technique = Technique::Linear;
    scene.march.samples_max = 128;
    scene.march.steps_by_angle = false;
    scene.craters.list = vec![crater_on_the_summit(&map)];
    let mut cut = EditedTerrain::new(canyon());
    cut.set_craters(&scene.craters.list);
    let change = Change::of(&scene, |scene| scene.march.lower_start = false);
    let lowered = error(&change.probe_before, &scene, cut.field());
    let full = error(&change.probe_after, &scene, cut.field());
    println!("mean error in cells: lowered {lowered:.3}, from the lid {full:.3}");
    assert!(lowered < 0.98 * full, "{lowered} against {full}");
    // The exact technique sees the same from either start.
    scene.march.technique = Technique::MaxMipmap;
    let exact = Change::of(&scene, |scene| scene.march.lower_start = false);
    assert_eq!(sky(&exact.probe_before), sky(&exact.probe_after));
    let steps = |probe: &Probe| probe.steps.iter().map(|&steps| u64::from(steps)).sum::<u64>();
    assert!(steps(&exact.probe_before) <= steps(&exact.probe_after));
}

#[test]
fn the_height_scale_flattens_the_silhouette() {
    let mut scene = scene_at(NamedView::Graze, &canyon());
    let natural = canyon().natural_height_scale();
    scene.skybox.enabled = false;
    let change = Change::of(&scene, |scene| scene.terrain.height_scale = Some(0.5 * natural));
    let after = sky(&change.probe_after);
    assert!(count(&after) > count(&change.sky) + 500, "more sky over lower ground");
    let filled = change.sky.iter().zip(&after).filter(|&(&before, &after)| before && !after).count();
    assert!(filled * 100 < count(&change.sky), "{filled} pixels of sky became ground");
    assert!(share(&change.changed) > 0.3);
}

/// Whether the rays that see differently meet the ground within the reach of a crater, before or after.
fn assert_changes_within_reach(change: &Change, scene: &Scene, list: &[Crater]) {
    let camera = scene.camera.unwrap();
    for (index, _) in change.changed.iter().enumerate().filter(|&(_, &changed)| changed) {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let direction = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE).direction.normalize();
        let near_one = |probe: &Probe| {
            let distance = f64::from(probe.distance[index]);
            let hit = camera.eye + direction * distance;
            // The normals and the generated colours look at neighbouring samples, and mips spread a colour further.
            let margin = 0.02;
            distance.is_finite()
                && list.iter().any(|c| (hit.x - c.x).hypot(hit.z - c.z) <= c.radius * Crater::REACH + margin)
        };
        assert!(near_one(&change.probe_before) || near_one(&change.probe_after), "pixel {x}, {y} changed");
    }
}

#[test]
fn craters_change_only_what_sees_them() {
    let extent = canyon().box_size(None);
    let crater = |u: f64, v: f64| Crater { x: u * extent.x, z: v * extent.z, radius: 0.06, depth: 0.4, rim: 0.1 };
    let list = [crater(0.5, 0.6), crater(0.3, 0.4)];
    for mode in [CraterMode::Baked, CraterMode::Layered] {
        let mut scene = start();
        scene.craters.mode = mode;
        let change = Change::of(&scene, |scene| scene.craters.list = list.to_vec());
        assert!(count(&change.changed) > 500, "{mode:?}");
        assert_changes_within_reach(&change, &scene, &list);
    }
}

#[test]
fn an_edit_is_a_fresh_build_byte_for_byte_and_can_be_taken_back() {
    let map = canyon();
    for technique in [Technique::MaxMipmap, Technique::LinearBinary] {
        let mut scene = start();
        scene.march.technique = technique;
        let mut edited = renderer(&map);
        let untouched = picture(&mut edited, &scene);
        let list = craters(&map);
        let mut with = Vec::new();
        for count in 1..=list.len() {
            scene.craters.list = list[..count].to_vec();
            with.push(picture(&mut edited, &scene));
        }
        assert!(picture(&mut renderer(&map), &scene) == with[list.len() - 1], "{technique:?}: not as freshly built");
        // Colours that are first painted when the craters are there already are the same, too.
        let mut late = renderer(&map);
        let mut plain = scene.clone();
        plain.diffuse.enabled = false;
        picture(&mut late, &plain);
        assert!(picture(&mut late, &scene) == with[list.len() - 1], "{technique:?}: painted late");
        for count in (1..list.len()).rev() {
            scene.craters.list.pop();
            assert!(picture(&mut edited, &scene) == with[count - 1], "{technique:?}: undo to {count}");
        }
        scene.craters.list = list;
        picture(&mut edited, &scene);
        scene.craters.list.clear();
        assert!(picture(&mut edited, &scene) == untouched, "{technique:?}: clear all");
    }
}

#[test]
fn layered_craters_look_like_baked_ones() {
    let map = canyon();
    let mut scene = start();
    let extent = map.box_size(None);
    scene.craters.layer_resolution = map.width();
    scene.craters.list = vec![Crater { x: 0.5 * extent.x, z: 0.6 * extent.z, radius: 0.1, depth: 0.4, rim: 0.1 }];
    let change = Change::of(&scene, |scene| scene.craters.mode = CraterMode::Layered);
    let far = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-3 || a.is_finite() != b.is_finite();
    let apart = change.probe_before.distance.iter().zip(&change.probe_after.distance).filter(|&pair| far(pair)).count();
    assert!(apart < 80, "{apart} distances differ by more than 0.001");
    // And back: the baked heights are all there again.
    let mut renderer = change.renderer;
    assert!(picture(&mut renderer, &scene) == change.before);
    // A coarser layer is a coarser crater.
    scene.craters.mode = CraterMode::Layered;
    let coarse = Change::of(&scene, |scene| scene.craters.layer_resolution = 24);
    assert!(count(&coarse.changed) > 500);
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let map = canyon();
    let mut first = renderer(&map);
    for technique in Technique::ALL {
        let mut scene = with_cube();
        scene.march.technique = technique;
        scene.craters.list = craters(&map);
        let expected = picture(&mut first, &scene);
        assert!(picture(&mut first, &scene) == expected, "{technique:?}: twice in one renderer");
        assert!(picture(&mut renderer(&map), &scene) == expected, "{technique:?}: in a fresh one");
        let distances = probe(&mut first, &scene).distance;
        assert!(probe(&mut first, &scene).distance == distances);
        assert!(picture(&mut first, &scene) == expected, "{technique:?}: after a probe");
    }
}

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
