//! The reference against brute force.

use super::super::HoleMask;
use super::super::testing::{Numbers, random_field};
use super::*;

/// Height of a ray's point above the surface; what lies beside the box is no ground.
fn above(field: &HeightField, size: DVec3, point: DVec3) -> f64 {
    let [columns, rows] = field.cells();
    let cell = |share: f64, cells: u32| ((share * f64::from(cells)).max(0.0) as u32).min(cells - 1);
    if !field.has_ground(cell(point.x / size.x, columns), cell(point.z / size.z, rows)) {
        return f64::INFINITY;
    }
    point.y - size.y * field.surface_height(point.x / size.x, point.z / size.z)
}

/// Dense steps through the box, then halvings of the first step that goes below.
fn march(field: &HeightField, size: DVec3, ray: &Ray) -> Option<f64> {
    const STEPS: u32 = 20_000;
    let slab = |axis: usize| {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        if d == 0.0 {
            let inside = (0.0..=size[axis]).contains(&o);
            return if inside { (0.0, f64::INFINITY) } else { (f64::INFINITY, 0.0) };
        }
        let (a, b) = (-o / d, (size[axis] - o) / d);
        (a.min(b), a.max(b))
    };
    let (enter, exit) =
        (0..3).map(slab).fold((0.0, f64::INFINITY), |(a, b): (f64, f64), (c, d): (f64, f64)| (a.max(c), b.min(d)));
    if enter > exit {
        return None;
    }
    let at = |t: f64| above(field, size, ray.origin + ray.direction * t);
    if at(enter) <= 0.0 {
        return Some(enter);
    }
    let step = (exit - enter) / f64::from(STEPS);
    let below = (1..=STEPS).map(|i| enter + f64::from(i) * step).find(|&t| at(t) <= 0.0)?;
    let (mut low, mut high) = (below - step, below);
    for _ in 0..60 {
        let middle = (low + high) * 0.5;
        if at(middle) <= 0.0 { high = middle } else { low = middle }
    }
    Some(high)
}

/// A random ray: from outside, from inside, from inside the ground, some parallel to one or two axes, some to a wall
/// between cells.
fn random_ray(numbers: &mut Numbers, field: &HeightField, size: DVec3) -> Ray {
    let mut point = |low: f64, high: f64| {
        DVec3::new(numbers.between(low, high), numbers.between(low, high), numbers.between(low, high)) * size
    };
    let (origin, target) = (point(-1.0, 2.0), point(0.0, 1.0));
    let inside = point(0.0, 1.0);
    let mut origin = if numbers.below(3) == 0 { inside } else { origin };
    let mut direction = target - origin;
    for axis in 0..3 {
        if numbers.below(5) == 0 {
            direction[axis] = 0.0;
            origin[axis] = target[axis];
            if axis == 0 && numbers.below(2) == 0 {
                let cells = field.cells()[0];
                origin.x = f64::from(numbers.below(cells + 1)) / f64::from(cells) * size.x;
            }
        }
    }
    if direction == DVec3::ZERO {
        direction.y = -1.0;
    }
    Ray { origin, direction }
}

#[test]
fn it_agrees_with_brute_force() {
    let mut numbers = Numbers::new(77);
    let (mut hits, mut walls, mut disputed) = (0, 0, 0);
    for (round, (width, height)) in [(2, 2), (2, 5), (7, 4), (12, 12)].into_iter().enumerate() {
        let field = random_field(width, height, round as u64);
        for scale in [0.02, 0.5, 30.0] {
            let size = field.box_size(Some(scale));
            for _ in 0..120 {
                let ray = random_ray(&mut numbers, &field, size);
                let (found, expected) = (Surface::new(&field, size).intersect(&ray), march(&field, size, &ray));
                match (found, expected) {
                    (Some(hit), Some(depth)) if (hit.depth - depth).abs() < 1e-9 => {
                        hits += 1;
                        walls += u32::from(hit.wall);
                        let expected = ray.origin + ray.direction * depth;
                        assert!((hit.position - expected).abs().max_element() < 1e-7 * scale.max(1.0));
                    }
                    (None, None) => {}
                    (Some(hit), _) => {
                        // Marching steps over thin crests; the reference must be on the surface there, and earlier.
                        disputed += 1;
                        assert!(expected.is_none_or(|depth| hit.depth < depth), "{hit:?} {expected:?} {ray:?}");
                        let height = above(&field, size, hit.position);
                        assert!(height.abs() < 1e-9 * scale.max(1.0), "{height}: {hit:?} {ray:?}");
                    }
                    (None, Some(depth)) => panic!("missed a hit at {depth} of {ray:?} over {width}×{height}"),
                }
            }
        }
    }
    assert!(hits > 700 && walls > 50 && disputed <= 5, "{hits} hits, {walls} walls, {disputed} disputed");
}

/// A map of noise in which one sample in `one_in` is a hole.
fn with_holes(width: u32, height: u32, numbers: &mut Numbers, one_in: u32) -> HeightField {
    let raw: Vec<f64> = (0..width * height).map(|_| numbers.unit()).collect();
    let mut holes = HoleMask::new(width, height);
    (0..width * height).filter(|_| numbers.below(one_in) == 0).for_each(|index| holes.insert(index as usize));
    HeightField::from_raw_with_holes(width, height, &raw, Some(holes)).unwrap()
}

#[test]
fn cells_with_a_hole_let_rays_pass_as_in_brute_force() {
    let mut numbers = Numbers::new(78);
    let (mut hits, mut disputed, mut sky) = (0, 0, 0);
    for (width, height, one_in) in [(3, 3, 7), (7, 4, 9), (12, 12, 20), (12, 12, 60)] {
        let field = with_holes(width, height, &mut numbers, one_in);
        let size = field.box_size(Some(0.5));
        for _ in 0..300 {
            // Off the walls between cells: marching cannot tell which side of one it is on.
            let mut point = |low: f64, high: f64| DVec3::from_array([0; 3].map(|_| numbers.between(low, high))) * size;
            let (origin, target) = (point(-1.0, 2.0), point(0.0, 1.0));
            let ray = Ray { origin, direction: target - origin };
            match (Surface::new(&field, size).intersect(&ray), march(&field, size, &ray)) {
                (Some(hit), Some(depth)) if (hit.depth - depth).abs() < 1e-9 => hits += 1,
                (None, None) => sky += 1,
                (Some(hit), expected) => {
                    disputed += 1;
                    assert!(expected.is_none_or(|depth| hit.depth < depth), "{hit:?} {expected:?} {ray:?}");
                }
                (None, Some(depth)) => panic!("missed a hit at {depth} of {ray:?} over {width}×{height}"),
            }
        }
    }
    assert!(hits > 400 && sky > 100 && disputed <= 5, "{hits} hits, {sky} sky, {disputed} disputed");
}

#[test]
fn a_hole_has_neither_sides_nor_floor_and_the_ground_beside_it_is_solid() {
    let mut holes = HoleMask::new(4, 2);
    holes.insert(0);
    let field =
        HeightField::from_raw_with_holes(4, 2, &[f64::NAN, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0], Some(holes)).unwrap();
    let size = DVec3::new(3.0, 1.0, 1.0);
    let surface = Surface::new(&field, size);
    let shoot = |origin: DVec3, direction: DVec3| surface.intersect(&Ray { origin, direction });
    assert_eq!(shoot(DVec3::new(0.5, 5.0, 0.5), DVec3::NEG_Y), None, "through the floor");
    assert_eq!(shoot(DVec3::new(0.5, -5.0, 0.5), DVec3::Y), None, "from below");
    assert_eq!(shoot(DVec3::new(0.5, 0.5, -5.0), DVec3::Z), None, "through both sides");
    assert_eq!(shoot(DVec3::new(-1.0, 0.2, 0.5), DVec3::X).unwrap().depth, 2.0, "against the ground beside it");
    assert_eq!(shoot(DVec3::new(0.5, 0.5, 0.5), DVec3::NEG_Y), None, "an eye in the hole");
    let down = shoot(DVec3::new(1.5, 5.0, 0.5), DVec3::NEG_Y).unwrap();
    assert!((down.depth - 4.25).abs() < 1e-12, "{down:?}");
}

/// Rays along crests and through corners of the grid, where a crack would show.
#[test]
fn there_are_no_cracks_between_cells() {
    let field = random_field(9, 9, 3);
    let size = field.box_size(Some(0.3));
    let surface = Surface::new(&field, size);
    let mut numbers = Numbers::new(1);
    for _ in 0..20_000 {
        let corner = DVec3::new(f64::from(numbers.below(9)) / 8.0, 0.0, f64::from(numbers.below(9)) / 8.0);
        let on_wall = numbers.below(2) == 0;
        let target = if on_wall { corner + DVec3::Z * numbers.between(-0.125, 0.125) } else { corner };
        let origin = DVec3::new(numbers.between(-1.0, 2.0), numbers.between(0.3, 2.0), numbers.between(-1.0, 2.0));
        let target = target.clamp(DVec3::ZERO, size);
        let ray = Ray { origin, direction: target - origin };
        let hit = surface.intersect(&ray).expect("a ray to the floor cannot pass");
        assert!(hit.depth <= 1.0 + 1e-12, "{hit:?}");
        assert!(hit.wall || above(&field, size, hit.position).abs() < 1e-9, "{hit:?}");
    }
}

#[test]
fn rays_along_an_axis_are_exact() {
    let field = HeightField::from_raw(3, 3, &[0.0, 0.0, 4.0, 0.0, 2.0, 4.0, 0.0, 0.0, 4.0]).unwrap();
    let size = DVec3::new(1.0, 2.0, 1.0);
    let surface = Surface::new(&field, size);
    let shoot = |origin: DVec3, direction: DVec3| surface.intersect(&Ray { origin, direction });
    let down = shoot(DVec3::new(0.5, 5.0, 0.5), DVec3::NEG_Y).unwrap();
    assert_eq!((down.depth, down.wall), (4.0, false), "onto a sample");
    let east = shoot(DVec3::new(-1.0, 0.5, 0.5), DVec3::X).unwrap();
    assert_eq!((east.depth, east.wall), (1.25, false), "along a wall between cells");
    let west = shoot(DVec3::new(3.0, 0.5, 0.5), DVec3::NEG_X).unwrap();
    assert_eq!((west.depth, west.wall), (2.0, true), "into the solid eastern side");
    let up = shoot(DVec3::new(0.9, -1.0, 0.1), DVec3::Y).unwrap();
    assert_eq!((up.depth, up.wall), (1.0, true), "into the floor");
    let buried = shoot(DVec3::new(0.99, 0.1, 0.5), DVec3::Y).unwrap();
    assert_eq!((buried.depth, buried.wall), (0.0, false), "an eye inside the ground");
    assert_eq!(shoot(DVec3::new(-1.0, 2.0, 0.5), DVec3::X).map(|hit| hit.depth), Some(2.0), "level with the summit");
    assert_eq!(shoot(DVec3::new(0.5, 2.1, 0.5), DVec3::X), None);
    assert_eq!(shoot(DVec3::new(0.5, 5.0, 0.5), DVec3::Y), None);
    assert_eq!(shoot(DVec3::NAN, DVec3::Y), None);
    assert_eq!(shoot(DVec3::ONE, DVec3::ZERO), None);
    for origin in [DVec3::NEG_X, DVec3::new(0.5, 1.0, 0.5)] {
        assert_eq!(shoot(origin, DVec3::X * 1e-320), None, "the box is infinitely many steps long");
    }
}

#[test]
fn flat_and_towering_boxes_work() {
    let field = random_field(5, 5, 9);
    for scale in [0.0, 1e-12, 1e3] {
        let size = field.box_size(Some(scale));
        let surface = Surface::new(&field, size);
        let mut numbers = Numbers::new(2);
        for _ in 0..2000 {
            let target = DVec3::new(numbers.unit(), 0.0, numbers.unit());
            let from = DVec3::new(numbers.between(-3.0, 3.0), scale * 1.5 + 1.0, numbers.between(-3.0, 3.0));
            let hit = surface.intersect(&Ray { origin: from, direction: target - from }).expect("the floor is below");
            let off = above(&field, size, hit.position).abs();
            assert!(hit.wall || off < 1e-9 * scale.max(1.0), "{off} with {scale}: {hit:?}");
        }
    }
}

#[test]
fn a_far_eye_hits_the_same_place() {
    let field = random_field(33, 33, 9);
    let surface = Surface::new(&field, field.box_size(None));
    let target = DVec3::new(0.4, 0.0, 0.6);
    let towards = DVec3::new(0.3, 1.0, 0.5);
    let near = surface.intersect(&Ray { origin: target + towards, direction: -towards }).unwrap();
    let far = surface.intersect(&Ray { origin: target + towards * 1e6, direction: -towards }).unwrap();
    assert!((near.position - far.position).length() < 1e-8, "{near:?} {far:?}");
}

#[test]
fn a_picture_has_its_sky_above_and_its_tangents_on_the_horizon() {
    let field = random_field(17, 17, 5);
    let size = field.box_size(None);
    let surface = Surface::new(&field, size);
    let camera = Camera::look_at(DVec3::new(0.5, 0.3, 1.6), DVec3::new(0.5, 0.2, 0.5), 50.0);
    let picture = [64, 48];
    let last = std::sync::Mutex::new(0f32);
    let distances = surface.distances(&camera, picture, &|share| {
        let mut last = last.lock().unwrap();
        *last = last.max(share);
    });
    assert_eq!(*last.lock().unwrap(), 1.0);
    assert!(distances[..64].iter().all(|d| d.is_infinite()));
    let ray = camera.ray(32.5, 30.5, picture);
    let hit = surface.intersect(&ray).unwrap();
    assert!((distances[30 * 64 + 32] - (hit.position - camera.eye).length()).abs() < 1e-12);
    let edges = (0..48 * 64).filter(|i| surface.is_tangent(&camera, i % 64, i / 64, picture, 0.5)).count();
    let sky = (0..48).map(|y| distances[y * 64 + 32].is_infinite()).collect::<Vec<_>>();
    let first = sky.iter().position(|sky| !sky).unwrap() as u32;
    assert!(surface.is_tangent(&camera, 32, first, picture, 1.0) && !surface.is_tangent(&camera, 32, 0, picture, 1.0));
    assert!((40..600).contains(&edges), "{edges}");
}
