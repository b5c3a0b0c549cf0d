use std::sync::Mutex;

use super::super::generate::{Kind, generate};
use super::super::testing::{Numbers, random_field};
use super::*;

const SIZES: [(u32, u32); 8] = [(2, 2), (2, 9), (3, 3), (5, 4), (17, 17), (33, 12), (24, 23), (31, 32)];

fn build(field: &HeightField, kind: ConeKind) -> ConeMap {
    ConeMap::build(field, kind, &|_| {})
}

/// White noise, hills, a single needle, a ramp to each side, and a cliff.
fn maps() -> Vec<HeightField> {
    let shaped = |width: u32, height: u32, shape: &dyn Fn(f64, f64) -> f64| {
        let raw: Vec<f64> = (0..width * height)
            .map(|index| {
                shape(f64::from(index % width) / f64::from(width), f64::from(index / width) / f64::from(height))
            })
            .collect();
        HeightField::from_raw(width, height, &raw).unwrap()
    };
    let mut maps: Vec<_> = SIZES.iter().map(|&(width, height)| random_field(width, height, 11)).collect();
    maps.push(generate(Kind::Ridged, 32, 3));
    maps.push(generate(Kind::DiamondSquare, 32, 4));
    maps.push(shaped(30, 20, &|x, z| (x * 7.0).sin() * (z * 5.0).cos()));
    maps.push(shaped(25, 25, &|x, z| if (x, z) == (0.48, 0.48) { 1.0 } else { 0.0 }));
    maps.push(shaped(20, 30, &|x, z| x + 0.3 * z));
    maps.push(shaped(20, 20, &|x, _| if x > 0.5 { 1.0 } else { 0.1 * x }));
    maps
}

/// Without a pyramid: every cell asks every cell.
fn brute_force(field: &HeightField, kind: ConeKind) -> Vec<f32> {
    let search = Search::new(field, kind);
    let [columns, rows] = field.cells();
    let cells = || (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    let mut slopes = Vec::new();
    for [column, row] in cells() {
        let apex = search.apex(column, row);
        for &relaxed in &[false, true][..kind.channels()] {
            let slope = cells().map(|cell| search.demand(&apex, cell, relaxed)).fold(0.0, f32::max);
            slopes.push(slope * (1.0 + ROUNDING));
        }
    }
    slopes
}

/// The ground at a place in cells.
fn ground(field: &HeightField, x: f64, z: f64) -> f64 {
    let [columns, rows] = field.cells().map(f64::from);
    field.surface_height(x / columns, z / rows)
}

/// Distance in the 1-norm from a cell to a place.
fn distance(cell: [u32; 2], x: f64, z: f64) -> f64 {
    let along = |cell: u32, at: f64| (f64::from(cell) - at).max(at - f64::from(cell) - 1.0).max(0.0);
    along(cell[0], x) + along(cell[1], z)
}

#[test]
fn the_search_through_the_pyramid_finds_what_asking_every_cell_finds() {
    for field in maps() {
        for kind in [ConeKind::Cone, ConeKind::Relaxed] {
            let map = build(&field, kind);
            assert_eq!((map.kind(), map.cells()), (kind, field.cells()));
            assert!(map.slopes() == brute_force(&field, kind), "{}×{}, {kind:?}", field.width(), field.height());
        }
    }
}

#[test]
fn no_cone_holds_ground() {
    for field in maps() {
        let map = build(&field, ConeKind::Cone);
        let [columns, rows] = field.cells();
        let search = Search::new(&field, ConeKind::Cone);
        for (index, &slope) in map.slopes().iter().enumerate() {
            let cell = [index as u32 % columns, index as u32 / columns];
            let lowest = f64::from(search.apex(cell[0], cell[1]).height);
            // Fifths of a cell: corners, edges and what lies between them.
            for (i, j) in (0..=5 * rows).flat_map(|j| (0..=5 * columns).map(move |i| (i, j))) {
                let (x, z) = (f64::from(i) / 5.0, f64::from(j) / 5.0);
                let cone = lowest + f64::from(slope) * distance(cell, x, z);
                let height = ground(&field, x, z);
                assert!(height <= cone + 1e-12, "cell {cell:?}: ground {height} at {x}, {z} in the cone, {cone}");
            }
        }
    }
}

/// And each is the widest: a little wider, it would hold a sample.
#[test]
fn cones_touch_the_ground_that_bounds_them() {
    let field = random_field(20, 20, 5);
    let search = Search::new(&field, ConeKind::Cone);
    for (index, &slope) in build(&field, ConeKind::Cone).slopes().iter().enumerate() {
        let cell = [index as u32 % 19, index as u32 / 19];
        let lowest = f64::from(search.apex(cell[0], cell[1]).height);
        let inside = |x: u32, z: u32| {
            let reach = distance(cell, f64::from(x), f64::from(z));
            f64::from(field.sample(x, z)) > lowest + 0.999 * f64::from(slope) * reach
        };
        let touched = (0..20).flat_map(|z| (0..20).map(move |x| (x, z))).any(|(x, z)| inside(x, z));
        assert!(touched || slope == 0.0, "cell {cell:?}");
    }
}

/// Whether a ray, while it is in the cone, is in the ground and then out of it.
fn comes_out(field: &HeightField, cell: [u32; 2], lowest: f64, slope: f64, from: [f64; 3], along: [f64; 3]) -> bool {
    let [columns, rows] = field.cells().map(f64::from);
    let mut was_below = false;
    for step in 0..4000 {
        let t = f64::from(step) * 0.01;
        let [x, y, z] = [0, 1, 2].map(|axis| from[axis] + t * along[axis]);
        let inside = (0.0..=columns).contains(&x) && (0.0..=rows).contains(&z);
        if !inside || y <= lowest + slope * distance(cell, x, z) {
            return false;
        }
        let below = y < ground(field, x, z) - 1e-9;
        if was_below && !below {
            return true;
        }
        was_below = below;
    }
    false
}

#[test]
fn a_ray_that_does_not_rise_comes_out_of_no_relaxed_cones_ground() {
    let mut numbers = Numbers::new(9);
    let (mut come_out, mut wider) = (0, 0);
    for field in maps() {
        let map = build(&field, ConeKind::Relaxed);
        let search = Search::new(&field, ConeKind::Relaxed);
        let [columns, rows] = field.cells();
        for _ in 0..4000 {
            let cell = [numbers.below(columns), numbers.below(rows)];
            let slopes = &map.slopes()[2 * (cell[1] * columns + cell[0]) as usize..];
            assert!(slopes[1] <= slopes[0]);
            wider += u32::from(slopes[1] < 0.8 * slopes[0]);
            let lowest = f64::from(search.apex(cell[0], cell[1]).height);
            let from = [
                f64::from(cell[0]) + numbers.unit(),
                lowest + (1.0 - lowest) * numbers.unit().powi(2),
                f64::from(cell[1]) + numbers.unit(),
            ];
            let angle = numbers.between(0.0, std::f64::consts::TAU);
            let fall = if numbers.below(8) == 0 { 0.0 } else { -0.2 * numbers.unit().powi(3) };
            let along = [angle.cos(), fall, angle.sin()];
            assert!(
                !comes_out(&field, cell, lowest, f64::from(slopes[1]), from, along),
                "{cell:?}, {from:?}, {along:?}"
            );
            // Out of the widest of all many would.
            come_out += u32::from(comes_out(&field, cell, lowest, 0.0, from, along));
        }
    }
    println!("{wider} cones are at least a quarter wider; {come_out} rays come out of the widest of all");
    assert!(come_out > 100 && wider > 1000, "the rays or the cones prove nothing");
}

#[test]
fn a_ramp_relaxes_to_its_crest() {
    // Rising from the west to a plateau: nothing lets a ray out, so nothing bounds the relaxed cones there.
    let raw: Vec<f64> = (0..21 * 5).map(|index| f64::from((index % 21).min(10))).collect();
    let field = HeightField::from_raw(21, 5, &raw).unwrap();
    let map = build(&field, ConeKind::Relaxed);
    let at = |column: usize| &map.slopes()[2 * (20 + column)..][..2];
    assert!((at(0)[0] - 0.1).abs() < 1e-6, "as steep as the ramp: {:?}", at(0));
    assert_eq!(at(0)[1], 0.0);
    assert_eq!(at(15)[0], 0.0, "on the plateau");
}

#[test]
fn a_search_that_is_cut_off_errs_towards_narrow_cones() {
    // A rippled bowl: its far side rises nearly all the way, and every cell of it waits to be looked at.
    let side = 300u32;
    let raw: Vec<f64> = (0..side * side)
        .map(|index| {
            let [x, z] = [index % side, index / side].map(|place| f64::from(place) / 150.0 - 1.0);
            x * x + z * z + 0.02 * (9.0 * x).sin() * (11.0 * z).cos()
        })
        .collect();
    let field = HeightField::from_raw(side, side, &raw).unwrap();
    let map = build(&field, ConeKind::Relaxed);
    let search = Search::new(&field, ConeKind::Relaxed);
    for index in (0..map.slopes().len() / 2).step_by(9973) {
        let cells = side - 1;
        let apex = search.apex(index as u32 % cells, index as u32 / cells);
        for (channel, relaxed) in [(0, false), (1, true)] {
            let places = (0..cells).flat_map(|row| (0..cells).map(move |column| [column, row]));
            let needed = places.map(|cell| search.demand(&apex, cell, relaxed)).fold(0.0, f32::max);
            let kept = map.slopes()[2 * index + channel];
            assert!(kept >= needed, "{apex:?}: {kept} is less than {needed}");
            assert!(kept <= map.slopes()[2 * index]);
        }
    }
}

#[test]
fn progress_ends_at_the_whole() {
    let heard = Mutex::new(Vec::new());
    ConeMap::build(&random_field(40, 33, 1), ConeKind::Cone, &|share| heard.lock().unwrap().push(share));
    let heard = heard.into_inner().unwrap();
    assert_eq!(heard.len(), 32);
    assert!(heard.iter().all(|share| (0.0..=1.0).contains(share)) && heard.contains(&1.0));
}
