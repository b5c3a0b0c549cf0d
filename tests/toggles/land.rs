//! Reading the land: what a colour or line says is what the f64 reference measures there, and nothing else changes.

use std::sync::Arc;

use glam::DVec3;
use image::{Rgba, RgbaImage};
use relief::camera::{Camera, NamedView};
use relief::heightfield::HeightField;
use relief::heightfield::import::Georeference;
use relief::heightfield::survey::{LEVEL, Survey};
use relief::render::RenderError;
use relief::scene::ramp::{aspect_colour, slope_colour};
use relief::scene::{CraterMode, GroundColour, Hillshade, Ramp, Scene};

use crate::change::{Change, start};
use crate::common::{SIZE, canyon, gpu, picture, probe, renderer, scratch_file};

/// The canyon as if it lay half below the sea, in a place of its own.
fn sunken() -> Arc<HeightField> {
    let map = (*canyon()).clone().with_range([-900.0, 968.0]);
    let place = Georeference::new([400_000.0, 4_000_000.0], [60.0, -60.0]).with_epsg(32612);
    Arc::new(map.with_georeference(Some(place)))
}

/// Bare colours: no light, no sky.
fn bare(base: &Scene) -> Scene {
    let mut scene = base.clone();
    scene.lighting.enabled = false;
    scene.skybox.enabled = false;
    scene
}

/// Pixels that show the ground's surface, with the shares of the map where they do.
fn ground(map: &Arc<HeightField>, scene: &Scene) -> Vec<(u32, u32, [f64; 2])> {
    let extent = map.box_size(scene.terrain.height_scale);
    let camera = scene.camera.unwrap();
    let found = probe(&mut renderer(map), scene).distance;
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    let place = |((x, y), distance): ((u32, u32), f32)| {
        let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, SIZE);
        let at = ray.origin + ray.direction.normalize() * f64::from(distance);
        let shares = [at.x / extent.x, at.z / extent.z];
        let on_surface = (map.surface_height(shares[0], shares[1]) * extent.y - at.y).abs() < 2e-4;
        let inside = shares.iter().all(|share| (0.001..0.999).contains(share));
        (distance.is_finite() && on_surface && inside).then_some((x, y, shares))
    };
    pixels.zip(found).filter_map(place).collect()
}

/// How far a pixel is off a colour, in its worst channel.
fn off(pixel: &Rgba<u8>, colour: [u8; 3]) -> u8 {
    pixel.0.iter().zip(colour).map(|(a, b)| a.abs_diff(b)).max().unwrap()
}

/// The share of pixels whose colour is off the expected one by more than `most`.
fn wrong(
    picture: &RgbaImage,
    pixels: &[(u32, u32, [f64; 2])],
    most: u8,
    expected: impl Fn([f64; 2]) -> [u8; 3],
) -> f64 {
    let bad = pixels.iter().filter(|(x, y, at)| off(picture.get_pixel(*x, *y), expected(*at)) > most).count();
    bad as f64 / pixels.len() as f64
}

#[test]
fn a_ramps_colour_is_that_of_the_height_below_it() {
    let map = sunken();
    let base = bare(&start());
    let pixels = ground(&map, &base);
    assert!(pixels.len() > 30_000, "{}", pixels.len());
    let mut renderer = renderer(&map);
    for (ramp, ends) in
        [(Ramp::Oleron, None), (Ramp::Viridis, None), (Ramp::Riaboy2003, None), (Ramp::Batlow, Some([-300.0, 500.0]))]
    {
        let mut scene = base.clone();
        (scene.land.colour, scene.land.ramp) = (GroundColour::Ramp, ramp);
        (scene.land.low, scene.land.high) = (ends.map(|ends| ends[0]), ends.map(|ends| ends[1]));
        let scale = scene.land.scale(&map);
        let [low, high] = map.range();
        let expected = |[u, v]: [f64; 2]| {
            let height = low + map.surface_height(u, v) * (high - low);
            ramp.colour(scale.share(height) as f32)
        };
        let shown = picture(&mut renderer, &scene);
        // A texel on the edge of a band may be the neighbour's.
        let most = if ramp == Ramp::Riaboy2003 { 0.03 } else { 0.002 };
        let share = wrong(&shown, &pixels, 4, expected);
        assert!(share < most, "{}: {share} of the pixels have another colour", ramp.name());
        let defs = &renderer.ledger().shader_defs;
        assert!(!defs.iter().any(|def| def == "DIFFUSE_TEXTURE"), "the texture's place is taken: {defs:?}");
        assert!(renderer.ledger().textures.iter().all(|texture| texture.name != "diffuse"));
    }
    let change = Change::of(&start(), |scene| scene.land.colour = GroundColour::Ramp);
    change.assert_distances_kept();
    change.assert_ground_only(0.9);
}

/// True degrees, however high the terrain is drawn; and a terrain without height keeps its heights' colours.
#[test]
fn slopes_are_true_degrees_at_any_exaggeration() {
    let map = canyon();
    let survey = Survey::new(&map, 1.0);
    let mut renderer = renderer(&map);
    for scale in [0.02, 0.6] {
        let mut base = bare(&start());
        base.terrain.height_scale = Some(scale);
        base.camera = Some(NamedView::Down.camera(&map, map.box_size(Some(scale))));
        let pixels = ground(&map, &base);
        let mut show = |colour| {
            let mut scene = base.clone();
            scene.land.colour = colour;
            picture(&mut renderer, &scene)
        };
        let slopes = show(GroundColour::Slope);
        let share = wrong(&slopes, &pixels, 8, |[u, v]| slope_colour((survey.place(u, v).slope / 60.0) as f32));
        assert!(share < 0.01, "height {scale}: {share} of the slopes are wrong");
        let aspects = show(GroundColour::Aspect);
        let steep: Vec<_> =
            pixels.into_iter().filter(|(_, _, [u, v])| survey.place(*u, *v).slope > 2.0 * LEVEL + 1.0).collect();
        let direction = |[u, v]: [f64; 2]| survey.place(u, v).aspect.unwrap_or(0.0);
        let share = wrong(&aspects, &steep, 8, |at| aspect_colour((direction(at) / 360.0) as f32));
        assert!(share < 0.02, "height {scale}: {share} of the directions are wrong");
    }
    let mut flat = bare(&start());
    flat.terrain.height_scale = Some(0.0);
    flat.camera = Some(NamedView::Down.camera(&map, map.box_size(Some(0.0))));
    flat.land.colour = GroundColour::Ramp;
    let shown = picture(&mut renderer, &flat);
    let colours: std::collections::HashSet<_> = shown.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 200, "a flat terrain shows {} colours", colours.len());
}

/// A line where neighbours lie on either side of a contour, and none where no contour is near.
#[test]
fn contours_lie_where_heights_cross_their_interval() {
    let map = canyon();
    let extent = map.box_size(None);
    let mut base = bare(&start());
    // Near enough that lines are apart.
    base.camera = Some(Camera { eye: DVec3::new(0.45, 0.3, 0.5), yaw: 0.0, pitch: -80.0, fov: 50.0 });
    base.diffuse.enabled = false;
    let pixels = ground(&map, &base);
    let mut scene = base.clone();
    (scene.land.contours, scene.land.contour_interval) = (true, Some(100.0));
    let mut renderer = renderer(&map);
    let (without, with) = (picture(&mut renderer, &base), picture(&mut renderer, &scene));
    let [low, high] = map.range();
    let mut level = vec![f64::NAN; (SIZE[0] * SIZE[1]) as usize];
    for (x, y, [u, v]) in &pixels {
        level[(y * SIZE[0] + x) as usize] = (low + map.surface_height(*u, *v) * (high - low)) / 100.0;
    }
    let at = |x: i64, y: i64| level[(y * i64::from(SIZE[0]) + x) as usize];
    let (mut crossings, mut unmarked, mut stray, mut marked) = (0, 0, 0, 0);
    for (x, y, _) in &pixels {
        let (x, y) = (i64::from(*x), i64::from(*y));
        if x < 3 || y < 3 || x + 3 >= i64::from(SIZE[0]) || y + 3 >= i64::from(SIZE[1]) {
            continue;
        }
        let near: Vec<f64> =
            (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))).map(|(i, j)| at(x + i, y + j)).collect();
        if near.iter().any(|level| level.is_nan()) {
            continue;
        }
        let (least, most) = near.iter().fold((f64::MAX, f64::MIN), |(a, b), &level| (a.min(level), b.max(level)));
        let change = off(with.get_pixel(x as u32, y as u32), {
            let [r, g, b, _] = without.get_pixel(x as u32, y as u32).0;
            [r, g, b]
        });
        marked += usize::from(change > 0);
        stray +=
            usize::from(change > 24 && least.floor() == most.floor() && most.fract() < 0.98 && least.fract() > 0.02);
        // Where lines are at least some ten pixels apart.
        if at(x, y).floor() != at(x + 1, y).floor() && most - least < 0.4 {
            let beside = off(with.get_pixel(x as u32 + 1, y as u32), {
                let [r, g, b, _] = without.get_pixel(x as u32 + 1, y as u32).0;
                [r, g, b]
            });
            crossings += 1;
            unmarked += usize::from(change.max(beside) < 12);
        }
    }
    assert!(crossings > 300 && marked > 1000, "{crossings} crossings, {marked} pixels of lines");
    assert!(stray * 200 < marked, "{stray} pixels are marked without a contour near, {marked} in all");
    assert!(unmarked * 50 < crossings, "{unmarked} of {crossings} crossings have no line");
    assert!(extent.y > 0.0);
    // From afar they would be a moiré: they are gone.
    let mut far = base.clone();
    far.camera = Some(Camera { eye: DVec3::new(0.5, 30.0, 0.5), yaw: 0.0, pitch: -90.0, fov: 2.0 });
    let mut lines = far.clone();
    (lines.land.contours, lines.land.contour_interval) = (true, Some(0.5));
    let (plain, lined) = (picture(&mut renderer, &far), picture(&mut renderer, &lines));
    let seen = plain.pixels().zip(lined.pixels()).filter(|(a, b)| a != b).count();
    assert!(seen < 150, "{seen} pixels of lines that are closer than pixels");
}

/// Every switch on its own, over craters in their own texture, too.
#[test]
fn switches_of_the_land_change_the_ground_only() {
    let hillshade = |hillshade| move |scene: &mut Scene| scene.land.hillshade = hillshade;
    let sun = Change::of(&start(), hillshade(Hillshade::Sun));
    sun.assert_distances_kept();
    sun.assert_ground_only(0.8);
    assert!(!sun.renderer.ledger().shader_defs.iter().any(|def| def == "LIGHTING"), "it takes the lighting's place");
    let many = Change::of(&start(), hillshade(Hillshade::Multidirectional));
    many.assert_ground_only(0.8);
    assert_ne!(many.after, sun.after);
    let lines = Change::of(&start(), |scene| scene.land.contours = true);
    lines.assert_distances_kept();
    lines.assert_ground_only(0.005);
    let mut layered = start();
    layered.craters.mode = CraterMode::Layered;
    layered.craters.list.push(layered.craters.brush_at(0.45, 0.5));
    let colours = Change::of(&layered, |scene| scene.land.colour = GroundColour::Ramp);
    colours.assert_ground_only(0.9);
    // What shows nothing is nothing: neither in the picture nor in the shader.
    let nothing = Change::of(&start(), |scene| {
        (scene.land.hillshade, scene.land.hillshade_strength) = (Hillshade::Sun, 0.0);
        (scene.land.ramp, scene.land.contour_interval) = (Ramp::Viridis, Some(3.0));
    });
    assert_eq!(nothing.before, nothing.after);
    assert!(!nothing.renderer.ledger().shader_defs.iter().any(|def| def.starts_with("LAND") || def == "HILLSHADE"));
}

/// A picture of half the map's width, in its middle.
fn photo(name: &str, world: Option<&str>) -> std::path::PathBuf {
    let path = scratch_file(name);
    let pixel =
        |x: u32, _| if x < 32 { Rgba([255, 0, 0, 255]) } else { Rgba([0, 0, 255, if x < 48 { 255 } else { 0 }]) };
    RgbaImage::from_fn(64, 64, pixel).save(&path).unwrap();
    let beside = path.with_extension("pgw");
    match world {
        Some(world) => std::fs::write(beside, world).unwrap(),
        None => drop(std::fs::remove_file(beside)),
    }
    path
}

#[test]
fn a_picture_lies_where_its_world_file_says() {
    let map = sunken();
    // The map is 511 × 60 m a side; the picture 64 × 240 m, from a quarter of it on.
    let (step, first) = (240.0, 0.25 * 511.0 * 60.0);
    let world = format!("{step}\n0\n0\n-{step}\n{}\n{}\n", 400_000.0 + first + 120.0, 4_000_000.0 - first - 120.0);
    let file = photo("toggles-placed.png", Some(&world));
    let base = bare(&start());
    let mut scene = base.clone();
    scene.land.imagery = Some(file.clone());
    let mut renderer = renderer(&map);
    let (before, after) = (picture(&mut renderer, &base), picture(&mut renderer, &scene));
    assert!(renderer.ledger().textures.iter().any(|texture| texture.name == "imagery"));
    let doubts = renderer.imagery_doubts();
    assert!(doubts.len() == 1 && doubts[0].contains("covers about 25 % of the map"), "{doubts:?}");
    let side = 64.0 * step / (511.0 * 60.0);
    let (mut inside, mut beside) = (0, 0);
    for (x, y, [u, v]) in ground(&map, &base) {
        let (pu, pv) = ((u - 0.25) / side, (v - 0.25) / side);
        let pixel = after.get_pixel(x, y);
        let well = |range: std::ops::Range<f64>| range.contains(&pu) && (0.04..0.96).contains(&pv);
        if well(0.04..0.46) {
            assert!(off(pixel, [255, 0, 0]) < 4, "{pu} {pv}: {pixel:?}");
            inside += 1;
        } else if well(0.54..0.7) {
            assert!(off(pixel, [0, 0, 255]) < 4, "{pu} {pv}: {pixel:?}");
            inside += 1;
        } else if well(0.8..0.96) || [pu, pv].iter().any(|at| !(-0.05..=1.05).contains(at)) {
            assert_eq!(pixel, before.get_pixel(x, y), "beside it, or where it is transparent: {pu} {pv}");
            beside += 1;
        }
    }
    assert!(inside > 2000 && beside > 10_000, "{inside} {beside}");

    scene.land.imagery_opacity = 0.0;
    assert_eq!(picture(&mut renderer, &scene), before, "nothing of it");
    assert!(renderer.ledger().textures.iter().all(|texture| texture.name != "imagery"));
    assert!(renderer.imagery_doubts().is_empty(), "nothing to doubt in a picture that does not show");
}

#[test]
fn a_picture_that_cannot_be_placed_is_refused_with_what_to_do() {
    let world = "240\n0\n0\n-240\n405000\n3995000\n";
    let target = relief::gpu::Target::new(&gpu(), SIZE);
    let refused = |map: &Arc<HeightField>, file: &std::path::Path| {
        let mut scene = start();
        scene.land.imagery = Some(file.to_owned());
        match renderer(map).draw(&scene, &target) {
            Err(RenderError::Image { reason, .. }) => reason,
            other => panic!("not refused: {other:?}"),
        }
    };
    let placed = photo("toggles-placeless.png", Some(world));
    assert!(refused(&canyon(), &placed).contains("the map does not"), "a map without a place");
    let unplaced = photo("toggles-unplaced.png", None);
    assert!(refused(&sunken(), &unplaced).contains("no world file"));
    let far = photo("toggles-far.png", Some("240\n0\n0\n-240\n905000\n3995000\n"));
    assert!(refused(&sunken(), &far).contains("beside the map"));
    let other = photo("toggles-other.png", Some(world));
    std::fs::write(other.with_extension("prj"), r#"PROJCS["x",UNIT["metre",1],AUTHORITY["EPSG","32611"]]"#).unwrap();
    let reason = refused(&sunken(), &other);
    assert!(reason.contains("EPSG:32611 against EPSG:32612") && reason.contains("gdalwarp"), "{reason}");
}
