//! Arguments that make no sense: exit 2.

use crate::bench::Bench;

#[test]
fn arguments_that_make_no_sense() {
    let bench = Bench::new();
    for (arguments, words) in [
        ("--size 0x100", "--size"),
        ("--size 100", "--size"),
        ("--size 4000000x8", "--size"),
        ("--samples 9..8", "--samples"),
        ("--samples 0..8", "--samples"),
        ("--binary-steps 99", "--binary-steps"),
        ("--eye 0,nan,0", "not finite"),
        ("--eye 0,0", "three numbers"),
        ("--eye 1,1,1 --target 1,1,1", "same point"),
        ("--view over --eye 1,1,1", "cannot be used with"),
        ("--view sideways", "valley"),
        ("--fov 180", "--fov"),
        ("--fov 0", "--fov"),
        ("--height-scale -0.1", "--height-scale"),
        ("--height-scale 1000.1", "--height-scale"),
        ("--height-scale inf", "not finite"),
        ("--technique maxmipmap", "max-mipmap"),
        ("--crater 0.5", "--crater"),
        ("--crater 0.5,0.5,-1", "radius"),
        ("--frames 0 --stats out.json", "--frames"),
        ("--frames 9", "--stats"),
        ("--repeats 0", "--repeats"),
        ("-", "standard input"),
        ("--no-such-option", "--no-such-option"),
    ] {
        let run = bench.relief(&format!("render -o out.png {arguments}"));
        run.expect(2, &["relief: error: ", words]);
        assert!(bench.names().is_empty(), "{arguments} left {:?}", bench.names());
    }
    bench.relief("render").expect(2, &["--output"]);
    bench.relief("generate ocean -o a.png").expect(2, &["diamond-square"]);
    bench.relief("generate perlin --size 1 -o a.png").expect(2, &["--size"]);
}
