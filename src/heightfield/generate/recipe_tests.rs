use super::*;

/// A recipe that is changed, and the setting that is wrong with it.
type Case = (fn(&mut Recipe), &'static str);

#[test]
fn absurd_values_are_refused_with_what_why_and_what_to_do() {
    let cases: [Case; 28] = [
        (|r| r.version = 0, "version"),
        (|r| r.size = [0, 0], "size"),
        (|r| r.size = [1, 100], "size"),
        (|r| r.size = [1_000_000_000; 2], "size"),
        (|r| r.size = [32768; 2], "size"),
        (|r| (r.size, r.tileable) = ([2, 2], true), "size"),
        (|r| r.roughness = f64::NAN, "roughness"),
        (|r| r.roughness = -0.1, "roughness"),
        (|r| r.roughness = 1.01, "roughness"),
        (|r| r.octaves = Some(0), "octaves"),
        (|r| r.octaves = Some(1000), "octaves"),
        (|r| (r.octaves, r.lacunarity) = (Some(32), 8.0), "octaves"),
        (|r| r.lacunarity = 1.0, "lacunarity"),
        (|r| r.lacunarity = f64::INFINITY, "lacunarity"),
        (|r| r.scale = 0.0, "scale"),
        (|r| r.scale = -3.0, "scale"),
        (|r| r.midpoint.schedule = vec![1.0, f64::NAN], "midpoint.schedule"),
        (|r| r.midpoint.schedule = vec![1.0; 33], "midpoint.schedule"),
        (|r| r.midpoint.smoothing = 65, "midpoint.smoothing"),
        (|r| r.ridges.offset = 0.0, "ridges.offset"),
        (|r| r.ridges.gain = f64::NAN, "ridges.gain"),
        (|r| r.warp.strength = -1.0, "warp.strength"),
        (|r| r.hydraulic.drops = 1e9, "hydraulic.drops"),
        (|r| r.hydraulic.radius = 0, "hydraulic.radius"),
        (|r| r.hydraulic.lifetime = 0, "hydraulic.lifetime"),
        (|r| r.thermal.iterations = 1_000_000, "thermal.iterations"),
        (|r| r.thermal.strength = 2.0, "thermal.strength"),
        (|r| r.thermal.talus = f64::NEG_INFINITY, "thermal.talus"),
    ];
    for (change, field) in cases {
        let mut recipe = Recipe::new(Kind::Perlin, 1);
        change(&mut recipe);
        let error = recipe.validate().unwrap_err();
        assert_eq!(error.field, field, "{error}");
        assert_eq!(error.to_string().lines().count(), 3, "{error}");
    }
}

#[test]
fn the_limits_themselves_are_possible() {
    for kind in Kind::ALL {
        for size in [[2, 2], [2, 32768], [16385, 16385]] {
            assert_eq!(Recipe { size, ..Recipe::new(kind, 0) }.validate(), Ok(()), "{kind:?} {size:?}");
        }
        let extreme = Recipe { scale: 1024.0, lacunarity: 8.0, roughness: 1.0, ..Recipe::new(kind, u64::MAX) };
        let error = extreme.validate().unwrap_err();
        assert_eq!(error.field, "octaves", "eight octaves of that are too many: {error}");
        assert_eq!(Recipe { octaves: Some(6), ..extreme }.validate(), Ok(()));
    }
}

#[test]
fn a_size_that_does_not_tile_is_answered_with_one_that_does() {
    for size in [[1024, 1024], [1000, 500], [3, 1000], [50, 50], [20_000, 300], [18, 18]] {
        let recipe = Recipe { size, tileable: true, ..Recipe::new(Kind::DiamondSquare, 1) };
        let error = recipe.validate().unwrap_err();
        let sides = error.instead.split(',').next().unwrap().split('×').map(|side| side.parse().unwrap());
        let nearest: Vec<u32> = sides.collect();
        let better = Recipe { size: [nearest[0], nearest[1]], ..recipe };
        assert_eq!(better.validate(), Ok(()), "{size:?}: {error}");
    }
    for size in [[1025, 1025], [1025, 513], [769, 1025], [17, 17], [3, 3]] {
        let recipe = Recipe { size, tileable: true, ..Recipe::new(Kind::DiamondSquare, 1) };
        assert_eq!(recipe.validate(), Ok(()), "{size:?}");
    }
}

#[test]
fn octaves_reach_down_to_the_samples() {
    let count = |scale, lacunarity, side| Recipe { scale, lacunarity, ..Recipe::default() }.octave_count(side);
    assert_eq!((count(3.0, 2.0, 1024), count(3.0, 2.0, 16385), count(3.0, 2.0, 65)), (10, 14, 8));
    assert_eq!((count(12.0, 2.0, 4097), count(3.0, 4.0, 1 << 20)), (10, 10));
    assert_eq!(count(3.0, 1.1, 16385), MOST_OCTAVES);
}
