//! Nearly level rays that fall over an even crest by less than a rounding.
//!
//! Such a ray comes down to the crest's own height somewhere behind it. The walk goes there at once, and what it then
//! enters must be the cell behind the crest: the cell before it, whose ground rises to the crest, would rise on and
//! be met in mid-air. That is what the walk's `stop` is for.

use std::sync::Arc;

use relief::camera::Camera;
use relief::heightfield::HeightField;
use relief::scene::Scene;

use super::DVec3;
use super::common::renderer;

/// Size of the pictures.
const SIZE: [u32; 2] = [8, 16];

/// Heights of the columns of samples, each map from west to east with a crest of the height 0.5 not far from one end.
const MAPS: [&[f64]; 3] = [
    &[0.0, 0.5, 0.0, 1.0, 1.0, 0.0, 0.0],
    &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.0],
];

#[test]
fn a_ray_over_a_crest_meets_nothing_in_mid_air() {
    const ROWS: u32 = 5;
    for columns in MAPS {
        let raw: Vec<f64> = (0..ROWS).flat_map(|_| columns).copied().collect();
        let map = Arc::new(HeightField::from_raw(columns.len() as u32, ROWS, &raw).unwrap());
        let extent = map.box_size(Some(1.0));
        let slope = f64::from(map.cells()[0]);
        let mut renderer = renderer(&map);
        let (mut over, mut ended) = (0, 0);
        for (yaw, x) in [(90.0, -0.012), (270.0, extent.x + 0.012)] {
            for step in 0..80 {
                let eye = DVec3::new(x, 0.5 + 4e-8 * f64::from(step), 0.31 * extent.z);
                let pitch = -1e-5 * f64::from(step % 23);
                let camera = Camera { eye, yaw, pitch, fov: 0.0063 };
                let mut scene = Scene { camera: Some(camera), ..Scene::default() };
                scene.terrain.height_scale = Some(1.0);
                let probe = renderer.probe(&scene, SIZE).unwrap();
                for index in 0..SIZE[0] * SIZE[1] {
                    let at = [index % SIZE[0], index / SIZE[0]].map(|at| f64::from(at) + 0.5);
                    let ray = camera.ray(at[0], at[1], SIZE);
                    let Some(depth) = probe.view_depth(index as usize) else {
                        ended += 1;
                        continue;
                    };
                    let point = ray.origin + ray.direction * depth;
                    let ground = map.surface_height(point.x / extent.x, point.z / extent.z);
                    // By as much as the bound displaces the ray, across and up.
                    assert!(
                        (point.y - ground).abs() < 2e-6 * slope,
                        "{columns:?}, pixel {index} of {camera:?}: met {} above the ground at {point}",
                        point.y - ground
                    );
                    let from_crest = columns.iter().zip(0u32..).filter(|(height, _)| **height == 0.5);
                    let nearest = from_crest.map(|(_, column)| (point.x * slope - f64::from(column)).abs());
                    over += u32::from(nearest.fold(f64::INFINITY, f64::min) > 1.2);
                }
            }
        }
        assert!(over + ended > 1000, "the crest is not passed: {over} hits behind it, {ended} none");
    }
}
