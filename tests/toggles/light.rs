//! Light, sky and colours: the picture changes, the ground does not.

use image::RgbaImage;
use relief::scene::Scene;

use crate::change::{Change, checker, start, with_cube};
use crate::common::SIZE;

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
