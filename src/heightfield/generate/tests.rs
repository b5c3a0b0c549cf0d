use super::*;

/// Sums of the samples' bits; another sum means that saved scenes and golden images show another landscape.
#[test]
fn a_seed_gives_the_same_landscape_everywhere() {
    let fingerprint = |kind, seed| {
        let field = generate(kind, 65, seed);
        field.samples().iter().fold(0u32, |sum, h| sum.rotate_left(5) ^ h.to_bits())
    };
    let expected = [0x2777_f4c9, 0xae58_089a, 0xc939_6d3d, 0x2019_2992];
    assert_eq!(Kind::ALL.map(|kind| fingerprint(kind, 7)), expected);
    for kind in Kind::ALL {
        assert_ne!(fingerprint(kind, 7), fingerprint(kind, 8), "{kind:?}");
    }
}

#[test]
fn every_size_is_filled_and_uses_the_whole_range() {
    for kind in Kind::ALL {
        for size in [2, 3, 4, 5, 6, 17, 33, 50, 100] {
            let field = generate(kind, size, 1);
            assert_eq!((field.width(), field.height()), (size, size));
            let (low, high) = field.samples().iter().fold((1f32, 0f32), |(a, b), &h| (a.min(h), b.max(h)));
            assert_eq!((low, high), (0.0, 1.0), "{kind:?} {size}");
        }
    }
    assert_eq!(generate(Kind::Perlin, 0, 1).width(), 2);
}

/// A landscape is rough on all scales, but smooth from sample to sample compared with its whole relief.
#[test]
fn landscapes_are_fractal() {
    for kind in Kind::ALL {
        let field = generate(kind, 513, 3);
        let roughness = |step: u32| {
            let pairs = (0..512 - step).step_by(7).flat_map(|x| (0..513).step_by(5).map(move |y| (x, y)));
            let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), (x, y)| {
                (sum + (field.sample(x + step, y) - field.sample(x, y)).abs(), count + 1.0)
            });
            sum / count
        };
        let by_scale = [1, 4, 16, 64].map(roughness);
        assert!(by_scale[0] > 5e-4 && by_scale[0] < 0.02, "{kind:?} {by_scale:?}");
        for pair in by_scale.windows(2) {
            assert!((1.5..4.1).contains(&(pair[1] / pair[0])), "{kind:?} {by_scale:?}");
        }
    }
}

#[test]
fn progress_ends_at_one() {
    for kind in Kind::ALL {
        let last = std::sync::Mutex::new(0.0);
        Recipe::new(kind, 1).make([40, 40], &|share| *last.lock().unwrap() = share, &AtomicBool::new(false)).unwrap();
        assert_eq!(*last.lock().unwrap(), 1.0);
    }
}
