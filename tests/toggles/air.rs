//! Air, clouds, their shadows, the flare: each changes what it should, and off it is as if it had never been.

use glam::DVec3;
use image::RgbaImage;
use relief::camera::Camera;
use relief::scene::{CloudSource, GroundColour, Hillshade, Scene};

use crate::change::{Change, start, with_cube};
use crate::common::pictures::{changed, count, share};
use crate::common::{canyon, picture, renderer};

/// Sets a part of a scene.
type Set = fn(&mut Scene);

fn fog(scene: &mut Scene) {
    scene.air.fog = true;
    (scene.air.fog_density, scene.air.fog_base, scene.air.fog_scale) = (2.0, 1200.0, 300.0);
}

fn clouds(scene: &mut Scene) {
    (scene.clouds.enabled, scene.clouds.shadows) = (true, true);
}

/// A camera that has the sun over the hills in its picture.
fn towards_sun(scene: &mut Scene) {
    scene.flare.enabled = true;
    (scene.lighting.sun_azimuth, scene.lighting.sun_elevation) = (10.0, 15.0);
    let camera = scene.camera.as_mut().unwrap();
    (camera.yaw, camera.pitch) = (0.0, 0.0);
}

#[test]
fn perspective_changes_ground_and_cube_and_fog_the_sky_too() {
    let change = Change::of(&with_cube(), |scene| scene.air.perspective = true);
    change.assert_distances_kept();
    change.assert_ground_only(0.95);
    let change = Change::of(&with_cube(), fog);
    change.assert_distances_kept();
    let sky =
        |on: bool| change.changed.iter().zip(&change.sky).filter(|&(&changed, &sky)| changed && sky == on).count();
    assert!(
        sky(true) > 0 && sky(false) > count(&change.sky) / 4,
        "{} of the sky, {} of the ground",
        sky(true),
        sky(false)
    );
    // Far hills lose more than near ones: what is left of a difference between two pictures of the ground.
    let depth = |scene: &Scene| picture(&mut renderer(&canyon()), scene);
    let difference = |set: Set, row: u32| {
        let mut pair = [start(), start()];
        pair[1].lighting.ambient += 0.3;
        pair.iter_mut().for_each(set);
        let [a, b] = pair.map(|scene| depth(&scene));
        let rows =
            |picture: &RgbaImage| picture.rows().nth(row as usize).unwrap().map(|p| f64::from(p.0[1])).sum::<f64>();
        rows(&b) - rows(&a)
    };
    let hazy: Set = |scene| (scene.air.perspective, scene.air.visibility) = (true, 30.0);
    let [near, far] = [230, 110].map(|row| difference(hazy, row) / difference(|_| {}, row));
    assert!(far < 0.8 * near, "{far} of the contrast far away, {near} near");
}

/// Flipped on and off again, picture and ledger are what they were.
#[test]
fn what_is_off_leaves_nothing_behind() {
    let mut renderer = renderer(&canyon());
    let plain = with_cube();
    let before = picture(&mut renderer, &plain);
    let ledger = renderer.ledger().clone();
    let mut all = plain.clone();
    for set in [fog as Set, clouds, |scene| scene.air.perspective = true, towards_sun] {
        set(&mut all);
    }
    let lively = picture(&mut renderer, &all);
    assert!(share(&changed(&before, &lively)) > 0.5);
    let full = renderer.ledger();
    for pass in ["clouds", "flare", "cloud shadows"] {
        assert!(full.passes.iter().any(|own| own == pass), "{pass}: {:?}", full.passes);
    }
    for texture in ["clouds", "cloud shadows"] {
        assert!(full.textures.iter().any(|own| own.name == texture), "{texture}: {:?}", full.textures);
    }
    assert!(picture(&mut renderer, &all) == lively, "the same scene at the same time gives the same bytes");
    assert!(
        !renderer.ledger().passes.iter().any(|pass| pass == "cloud shadows"),
        "nothing moved: they are as they were"
    );
    assert!(picture(&mut renderer, &plain) == before);
    let back = renderer.ledger();
    assert_eq!(
        (&back.textures, &back.shader_defs, &back.passes),
        (&ledger.textures, &ledger.shader_defs, &ledger.passes)
    );
    assert_eq!(back.draws, ledger.draws);
}

/// Colours that are to be read off a map are shown without air, and so are debug views.
#[test]
fn maps_are_read_in_clear_air() {
    let mut renderer = renderer(&canyon());
    let views: [Set; 3] = [
        |scene| scene.land.colour = GroundColour::Slope,
        |scene| scene.land.hillshade = Hillshade::Sun,
        |scene| scene.debug.view = relief::scene::DebugView::Normals,
    ];
    for view in views {
        let mut scene = start();
        view(&mut scene);
        let clear = picture(&mut renderer, &scene);
        fog(&mut scene);
        clouds(&mut scene);
        scene.air.perspective = true;
        assert!(picture(&mut renderer, &scene) == clear);
    }
    let mut ramp = start();
    ramp.land.colour = GroundColour::Ramp;
    let clear = picture(&mut renderer, &ramp);
    fog(&mut ramp);
    assert!(picture(&mut renderer, &ramp) != clear, "a ramp may be a landscape, too");
}

#[test]
fn clouds_cover_the_sky_cast_shadows_and_move_with_their_time() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    let camera = scene.camera.as_mut().unwrap();
    *camera = Camera::look_at(DVec3::new(0.5, 0.09, 0.8), DVec3::new(0.5, 0.4, 0.0), 70.0);
    let clear = picture(&mut renderer, &scene);
    scene.clouds.enabled = true;
    let mut covered = |cover: f64| {
        scene.clouds.cover = cover;
        share(&changed(&clear, &picture(&mut renderer, &scene)))
    };
    let shares = [0.0, 0.2, 0.5, 0.8].map(&mut covered);
    assert!(shares[0] == 0.0 && shares.windows(2).all(|pair| pair[0] < pair[1]), "{shares:?}");
    scene.clouds.cover = 0.5;
    let before = picture(&mut renderer, &scene);
    scene.clouds.source = CloudSource::Map;
    assert!(share(&changed(&before, &picture(&mut renderer, &scene))) > 0.2, "of the map's heights they are others");
    scene.clouds.source = CloudSource::Noise;
    scene.clouds.time = 60.0;
    let later = picture(&mut renderer, &scene);
    assert!(share(&changed(&before, &later)) > 0.1);
    scene.clouds.time = 0.0;
    assert!(picture(&mut renderer, &scene) == before);

    // Seen from below the clouds, their shadows are all that changes on the ground.
    let mut under = start();
    clouds(&mut under);
    under.clouds.layers.iter_mut().for_each(|layer| layer.height += 60_000.0);
    let shaded = picture(&mut renderer, &under);
    under.clouds.shadows = false;
    let sunny = picture(&mut renderer, &under);
    let differs = changed(&sunny, &shaded);
    assert!(share(&differs) > 0.05, "{}", share(&differs));
    let darker = sunny.pixels().zip(shaded.pixels()).all(|(a, b)| (0..3).all(|c| b.0[c] <= a.0[c]));
    assert!(darker, "a shadow lightens nothing");
    under.clouds.shadows = true;
    under.clouds.shadow_strength = 0.0;
    assert!(picture(&mut renderer, &under) == sunny);
    under.clouds.shadow_strength = 0.8;
    under.lighting.enabled = false;
    let unlit = picture(&mut renderer, &under);
    under.clouds.shadows = false;
    assert!(picture(&mut renderer, &under) == unlit, "without light there is no shadow");
}

#[test]
fn a_flare_needs_a_sun_that_is_seen() {
    let mut renderer = renderer(&canyon());
    let mut scene = start();
    towards_sun(&mut scene);
    let mut flares = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        let with = picture(&mut renderer, &scene);
        let drawn = renderer.ledger().passes.iter().any(|pass| pass == "flare");
        scene.flare.enabled = false;
        let without = picture(&mut renderer, &scene);
        let brighter = with.pixels().zip(without.pixels()).all(|(a, b)| (0..3).all(|c| a.0[c] >= b.0[c]));
        assert!(brighter && drawn == (with != without));
        drawn
    };
    assert!(flares(&|_| {}));
    assert!(!flares(&|scene| scene.lighting.sun_azimuth = 100.0), "beside the picture");
    assert!(!flares(&|scene| scene.lighting.sun_elevation = -1.0), "below the horizon");
    assert!(!flares(&|scene| scene.skybox.enabled = false), "no sun in no sky");
    assert!(!flares(&|scene| scene.flare.strength = 0.0));
    let hidden = |scene: &mut Scene| {
        let (eye, sun) = (scene.camera.unwrap().eye, scene.lighting.sun_direction());
        (scene.occluder.enabled, scene.occluder.position) = (true, Some(eye + 0.5 * sun));
    };
    assert!(!flares(&hidden), "behind the cube");
    assert!(
        !flares(&|scene| (scene.air.fog, scene.air.fog_base, scene.air.fog_density) = (true, 90_000.0, 1.0)),
        "in fog"
    );
}
