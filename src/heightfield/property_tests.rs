//! Properties over random patches, rays, maps and edits. The seed is fixed; `PROPTEST_CASES` asks for more cases and
//! `PROPTEST_RNG_SEED` for others.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::reference::Surface;
use super::{Crater, EditedTerrain, HeightField, MaxPyramid, patch};
use crate::camera::Ray;

fn cases(cases: u32) -> ProptestConfig {
    let asked = std::env::var_os("PROPTEST_CASES").is_some();
    let seeded = std::env::var_os("PROPTEST_RNG_SEED").is_some();
    let default = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    ProptestConfig {
        cases: if asked { default.cases } else { cases },
        rng_seed: if seeded { default.rng_seed } else { RngSeed::Fixed(4) },
        ..default
    }
}

/// A height map's shape: noise, needles, plateaus, a checkerboard, a ramp with a wall, nearly flat.
fn height(kind: u32, x: u32, z: u32, noise: f64) -> f64 {
    match kind {
        0 => noise,
        1 => f64::from(u8::from(noise > 0.93)),
        2 => (noise * 3.0).floor(),
        3 => f64::from((x + z) % 2),
        4 => f64::from(x) * 0.1 + f64::from(u8::from(z == 1)),
        _ => 1.0 + noise * 1e-6 + f64::from(u8::from(x == 0 && z == 0)),
    }
}

prop_compose! {
    fn any_map()(
        (width, height) in (2u32..=33, 2u32..=33),
        kind in 0u32..6,
        seed in any::<u64>(),
    ) -> HeightField {
        let mut numbers = super::testing::Numbers::new(seed);
        let raw: Vec<f64> = (0..height)
            .flat_map(|z| (0..width).map(move |x| (x, z)))
            .map(|(x, z)| self::height(kind, x, z, numbers.unit()))
            .collect();
        HeightField::from_raw(width, height, &raw).unwrap()
    }
}

/// A coordinate or direction, with those that make trouble.
fn awkward() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -1.0f32..1.0,
        1 => Just(0.0f32),
        1 => Just(1.0f32),
        1 => Just(-1.0f32),
        1 => Just(0.5f32),
        1 => -1e-6f32..1e-6,
    ]
}

fn corner() -> impl Strategy<Value = f32> {
    prop_oneof![5 => 0.0f32..1.0, 1 => Just(0.0f32), 1 => Just(1.0f32), 1 => 0.5f32..0.500_001]
}

/// F and the sum of the magnitudes of its terms at `t`.
fn above(corners: [f64; 4], origin: [f64; 3], direction: [f64; 3], t: f64) -> (f64, f64) {
    let [h00, h10, h01, h11] = corners;
    let [x, z] = [0, 2].map(|axis| origin[axis] + direction[axis] * t);
    let k = h00 - h10 - h01 + h11;
    let height = h00 + (h10 - h00) * x + (h01 - h00) * z + k * x * z;
    let (slope_x, slope_z) = ((h10 - h00).abs(), (h01 - h00).abs());
    let reach = |axis: usize| origin[axis].abs() + (direction[axis] * t).abs();
    let terms = reach(1) + h00.abs() + slope_x * reach(0) + slope_z * reach(2) + k.abs() * reach(0) * reach(2);
    (origin[1] + direction[1] * t - height, terms)
}

/// Where a ray from inside the unit square leaves it.
fn leaves(origin: [f64; 3], direction: [f64; 3]) -> f64 {
    [0, 2].into_iter().fold(f64::INFINITY, |end: f64, axis| {
        let (o, d) = (origin[axis], direction[axis]);
        if d > 0.0 {
            end.min((1.0 - o) / d)
        } else if d < 0.0 {
            end.min(-o / d)
        } else {
            end
        }
    })
}

/// Holds a root to the bound of `patch.rs`: the ray is on the patch there, and was not below it before.
fn check_root(
    corners: [f64; 4],
    origin: [f64; 3],
    direction: [f64; 3],
    found: Option<f64>,
    roundoff: f64,
) -> Result<(), TestCaseError> {
    if found == Some(0.0) {
        let (height, terms) = above(corners, origin, direction, 0.0);
        prop_assert!(height <= 16.0 * roundoff * terms, "met at once, {height:e} above the patch");
        return Ok(());
    }
    let end = leaves(origin, direction).min(4.0);
    let last = found.map_or(end, |t| t.min(end));
    const SAMPLES: u32 = 512;
    for index in 0..SAMPLES {
        let t = last * f64::from(index) / f64::from(SAMPLES);
        let (height, terms) = above(corners, origin, direction, t);
        prop_assert!(height >= -16.0 * roundoff * terms, "below by {height:e} at {t}, but met at {found:?}");
    }
    if let Some(t) = found.filter(|&t| t > 0.0 && t <= end) {
        let (height, terms) = above(corners, origin, direction, t);
        prop_assert!(
            height.abs() <= 16.0 * roundoff * terms,
            "{height:e} off the patch at {t}: {:e}",
            roundoff * terms
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(20_000))]

    /// The f32 twin against f64 and against dense sampling.
    #[test]
    fn the_root_is_within_its_bound_in_both_precisions(
        corners in [corner(), corner(), corner(), corner()],
        (x, z) in (0.0f32..=1.0, 0.0f32..=1.0),
        lift in prop_oneof![3 => 0.0f32..1.0, 1 => 0.0f32..1e-5],
        direction in [awkward(), awkward(), awkward()],
        scale in prop_oneof![4 => Just(1.0f32), 1 => Just(1e-6f32), 1 => Just(1e3f32)],
    ) {
        let corners = corners.map(|h| h * scale);
        let ground = above(corners.map(f64::from), [f64::from(x), 0.0, f64::from(z)], [0.0; 3], 0.0).0;
        let origin = [x, (-ground) as f32 + lift * scale, z];
        let direction = [direction[0], direction[1] * scale, direction[2]];
        let single = patch::first_meeting(corners, origin, direction);
        let (corners, origin, direction) = (corners.map(f64::from), origin.map(f64::from), direction.map(f64::from));
        let double = patch::first_meeting(corners, origin, direction);
        check_root(corners, origin, direction, single.map(f64::from), f64::from(f32::EPSILON) / 2.0)?;
        check_root(corners, origin, direction, double, f64::EPSILON / 2.0)?;
    }
}

/// The ray from `eye` to `target`, shares of the box.
fn ray(eye: [f64; 3], target: [f64; 3], size: DVec3) -> Ray {
    let (origin, target) = (DVec3::from(eye) * size, DVec3::from(target) * size);
    Ray { origin, direction: target - origin }
}

/// A share of the box, often at its border, on a grid point or outside.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![5 => -0.2f64..1.2, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5), 1 => -50.0f64..50.0]
}

proptest! {
    #![proptest_config(cases(3_000))]

    /// The walk meets the ground exactly where a thousand points along the ray and all cells say.
    #[test]
    fn the_reference_walk_is_what_brute_force_finds(
        map in any_map(),
        eye in [share(), share(), share()],
        target in [share(), share(), share()],
        scale in prop_oneof![3 => 0.01f64..2.0, 1 => Just(0.0), 1 => Just(1e3)],
    ) {
        let size = map.box_size(Some(scale));
        let ray = ray(eye, target, size);
        let surface = Surface::new(&map, size);
        let hit = surface.intersect(&ray);
        let height_at = |point: DVec3| map.surface_height(point.x / size.x, point.z / size.z) * size.y;
        let inside = |p: DVec3| p.cmpge(DVec3::ZERO).all() && p.cmple(size).all();
        // Only what a rounding of the ray explains is let pass.
        let slope = size.y * f64::from(map.width().max(map.height()));
        let tolerance = 1e-12 * (1.0 + ray.origin.abs().max_element()) * (1.0 + slope);
        let last = hit.map_or(4.0, |hit| hit.depth);
        // An eye in the ground meets it at once.
        let before = if last > 0.0 { 2000 } else { 0 };
        for index in 0..before {
            let point = ray.origin + ray.direction * (last * f64::from(index) / 2000.0);
            if inside(point) {
                let above = point.y - height_at(point);
                prop_assert!(above >= -tolerance, "{above:e} below the ground before {hit:?}");
            }
        }
        if let Some(hit) = hit {
            let gap = hit.position.y - height_at(hit.position);
            prop_assert!(gap <= tolerance, "{gap:e} above the ground at {hit:?}");
            prop_assert!(hit.wall || hit.depth == 0.0 || gap.abs() <= tolerance, "{gap:e} under the ground at {hit:?}");
        }
    }
}

/// The cells that brute force looks at, one by one, without a walk.
fn first_cell_hit(map: &HeightField, size: DVec3, ray: &Ray) -> Option<f64> {
    let [columns, rows] = map.cells();
    let mut first: Option<f64> = None;
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        let scale = DVec3::new(f64::from(columns) / size.x, 1.0, f64::from(rows) / size.z);
        let origin = ray.origin * scale - DVec3::new(f64::from(column), 0.0, f64::from(row));
        let direction = ray.direction * scale;
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        let mut entry_height = None;
        let slabs = [(origin.x, direction.x, 1.0), (origin.z, direction.z, 1.0), (origin.y, direction.y, size.y)];
        for (axis, (o, d, high)) in slabs.into_iter().enumerate() {
            if d == 0.0 {
                if !(0.0..=high).contains(&o) {
                    leave = -1.0;
                }
                continue;
            }
            let (a, b) = (-o / d, (high - o) / d);
            if a.min(b) >= enter {
                // Through the floor or the lid: exactly at its height.
                entry_height = (axis == 2).then_some(if d > 0.0 { 0.0 } else { high });
            }
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        if enter > leave {
            continue;
        }
        let at = |i: u32, j: u32| f64::from(map.sample(column + i, row + j)) * size.y;
        let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let local = origin + direction * enter;
        let height = entry_height.unwrap_or(local.y.clamp(0.0, size.y));
        let local = [local.x.clamp(0.0, 1.0), height, local.z.clamp(0.0, 1.0)];
        if let Some(t) = patch::first_meeting(corners, local, direction.to_array())
            && t <= leave - enter
            && first.is_none_or(|first| enter + t < first)
        {
            first = Some(enter + t);
        }
    }
    first
}

proptest! {
    #![proptest_config(cases(3_000))]

    #[test]
    fn the_reference_walk_misses_no_cell(
        map in any_map(),
        eye in [share(), share(), share()],
        target in [share(), share(), share()],
        scale in 0.05f64..2.0,
    ) {
        let size = map.box_size(Some(scale));
        let ray = ray(eye, target, size);
        prop_assume!(ray.direction != DVec3::ZERO);
        let walked = Surface::new(&map, size).intersect(&ray).map(|hit| hit.depth);
        let brute = first_cell_hit(&map, size, &ray);
        let height_over = |t: f64| {
            let point = ray.origin + ray.direction * t;
            point.y - map.surface_height(point.x / size.x, point.z / size.z) * size.y
        };
        match (walked, brute) {
            (Some(walked), Some(brute)) => {
                // At a tangent the two may rightly take different points of one near miss.
                let same = (walked - brute).abs() <= 1e-7 || height_over(walked.max(brute)).abs() < 1e-9;
                prop_assert!(same, "{walked}, but brute force {brute}");
            }
            (None, None) => {}
            // On its way out through the floor, where the ground is as low as that.
            (Some(walked), None) if height_over(walked).abs() < 1e-9 => {}
            (walked, brute) => {
                let t = walked.or(brute).unwrap();
                let inside = size.cmpge(ray.origin + ray.direction * t - 1e-9).all();
                // One of them sees the ground through a rounding at the tangent or on the box's own edge.
                let graze = [-1e-9, 1e-9].into_iter().any(|shift| {
                    let moved = Ray { origin: ray.origin + DVec3::splat(shift), ..ray };
                    Surface::new(&map, size).intersect(&moved).is_some() == brute.is_some()
                });
                prop_assert!(graze, "{walked:?}, but brute force {brute:?}, inside {inside}");
            }
        }
    }
}

fn any_crater() -> impl Strategy<Value = Crater> {
    let radius = prop_oneof![4 => 0.005f64..0.2, 1 => 1e-6f64..1e-3, 1 => 1.0f64..10.0, 1 => Just(1e300)];
    let depth = prop_oneof![4 => 0.0f64..0.6, 1 => 1.0f64..10.0, 1 => Just(Crater::MOST_SHARE)];
    (-0.2f64..1.2, -0.2f64..1.2, radius, depth, 0.0f64..0.3).prop_map(|(x, z, radius, depth, rim)| Crater {
        x,
        z,
        radius,
        depth,
        rim,
    })
}

/// Everything that a copy on the GPU is made of, bit for bit.
fn bits(terrain: &EditedTerrain) -> Vec<u32> {
    let levels = terrain.pyramid().levels().iter().flat_map(|level| &level.data);
    terrain.field().samples().iter().chain(levels).map(|height| height.to_bits()).collect()
}

proptest! {
    #![proptest_config(cases(1_000))]

    /// Craters come and go in any order; the result is a fresh build, and without them the map's own bytes.
    #[test]
    fn craters_leave_no_trace(
        map in any_map(),
        craters in prop::collection::vec(any_crater(), 1..12),
        steps in prop::collection::vec(0usize..12, 1..8),
    ) {
        let map = Arc::new(map);
        let untouched = bits(&EditedTerrain::new(Arc::clone(&map)));
        let mut terrain = EditedTerrain::new(Arc::clone(&map));
        for count in steps {
            let list = &craters[..count.min(craters.len())];
            terrain.set_craters(list);
            let mut fresh = EditedTerrain::new(Arc::clone(&map));
            fresh.set_craters(list);
            prop_assert_eq!(bits(&terrain), bits(&fresh));
            prop_assert_eq!(terrain.pyramid(), &MaxPyramid::build(terrain.field()));
            let sound = |height: &f32| height.to_bits() == 0 || height.is_normal() && (0.0..=1.0).contains(height);
            prop_assert!(terrain.field().samples().iter().all(sound));
        }
        terrain.set_craters(&[]);
        prop_assert_eq!(bits(&terrain), untouched);
    }
}

#[test]
fn an_edit_at_a_border_of_any_level_leaves_a_fresh_pyramid() {
    let map = Arc::new(super::testing::random_field(71, 45, 9));
    let [columns, rows] = map.cells();
    let untouched = bits(&EditedTerrain::new(Arc::clone(&map)));
    let sides = map.box_size(None);
    let mut edits = 0;
    for level in 1..=7u32 {
        // A wall between nodes of the level, the samples beside it, and the map's own borders.
        let near = |cells: u32| {
            let wall = (1u32 << level).min(cells);
            [0, 1, wall - 1, wall, (wall + 1).min(cells), cells - 1, cells]
        };
        for (column, row) in near(columns).into_iter().flat_map(|column| near(rows).map(|row| (column, row))) {
            for depth in [0.0, 5.0] {
                // One sample, lowered to the floor or raised to the lid.
                let crater = Crater {
                    x: f64::from(column) / f64::from(columns) * sides.x,
                    z: f64::from(row) / f64::from(rows) * sides.z,
                    radius: if depth > 0.0 { 1e-9 } else { 0.6 / f64::from(columns) },
                    depth,
                    rim: 1.0 - depth.min(1.0),
                };
                let mut terrain = EditedTerrain::new(Arc::clone(&map));
                terrain.set_craters(&[crater]);
                assert_eq!(terrain.pyramid(), &MaxPyramid::build(terrain.field()), "level {level}: {column}, {row}");
                terrain.set_craters(&[]);
                assert_eq!(bits(&terrain), untouched);
                edits += 1;
            }
        }
    }
    assert_eq!(edits, 7 * 49 * 2);
}

#[test]
fn a_thousand_craters_are_taken_back_without_a_trace() {
    let map = Arc::new(super::testing::random_field(301, 257, 2));
    let untouched = bits(&EditedTerrain::new(Arc::clone(&map)));
    let mut numbers = super::testing::Numbers::new(7);
    let list: Vec<_> = (0..1000)
        .map(|index| Crater {
            x: numbers.between(-0.1, 1.1),
            z: numbers.between(-0.1, 1.0),
            radius: [0.02, 0.1, 1e-4, 3.0][index % 4],
            depth: numbers.between(0.0, 2.0),
            rim: numbers.between(0.0, 0.2),
        })
        .collect();
    let mut terrain = EditedTerrain::new(Arc::clone(&map));
    for count in 1..=list.len() {
        terrain.set_craters(&list[..count]);
    }
    assert_ne!(bits(&terrain), untouched);
    assert_eq!(terrain.pyramid(), &MaxPyramid::build(terrain.field()));
    // Taking one back computes its surroundings anew from all others: a hundred one by one, then the rest at once.
    for count in (900..list.len()).rev() {
        terrain.set_craters(&list[..count]);
    }
    let mut fresh = EditedTerrain::new(Arc::clone(&map));
    fresh.set_craters(&list[..900]);
    assert_eq!(bits(&terrain), bits(&fresh));
    terrain.set_craters(&[]);
    assert_eq!(bits(&terrain), untouched);
}
