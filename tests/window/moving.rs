//! Orbit, going there, bookmarks and the camera path.

use glam::DVec3;
use relief::camera::{Camera, NamedView};
use relief::heightfield::reference::Surface;

use crate::harness::{Window, camera, canyon, told};

const SIZE: [u32; 2] = [420, 300];

/// The ground at a pixel.
fn ground(eye: &Camera, [x, y]: [f64; 2]) -> DVec3 {
    let map = canyon();
    let size = map.box_size(None);
    Surface::new(&map, size).intersect(&eye.ray(x, y, SIZE)).unwrap().position
}

#[test]
fn the_eye_orbits_goes_there_and_travels() {
    let mut window = Window::open("--size 420x300 --view over");
    window.key("F2");
    let start = camera(&window.settled("no panel", |status| status["panel"] == false));
    orbit(&mut window, start);
    there_and_back(&mut window);
    path(&mut window);
    keyboard(&mut window);
    window.close();
}

fn orbit(window: &mut Window, start: Camera) {
    window.key("Tab");
    window.settled("orbit", |status| status["mode"] == "orbit" && status["typing"] == false);
    let middle = ground(&start, [210.0, 150.0]);
    window.point(150.0, 150.0);
    for button in [1, 3] {
        let before = camera(&window.settled("rest", |_| true));
        window.xdo(&format!("mousedown {button} mousemove_relative 40 0 mouseup {button}"));
        let after = camera(&window.settled("a turn", |status| camera(status).yaw != before.yaw));
        assert!((after.eye.distance(middle) - start.eye.distance(middle)).abs() < 1e-6, "{after:?}");
        assert!((ground(&after, [210.0, 150.0]) - middle).length() < 1e-3, "the middle stays in the middle");
    }
    window.point(260.0, 190.0);
    let before = camera(&window.settled("rest", |_| true));
    let point = ground(&before, [260.0, 190.0]);
    window.xdo("click 4");
    let near = camera(&window.settled("a step", |status| camera(status).eye != before.eye));
    assert!(near.eye.distance(point) < 0.9 * before.eye.distance(point), "the wheel goes there");
    assert!((ground(&near, [260.0, 190.0]) - point).length() < 1e-3, "what is under the cursor stays there");
    window.key("Tab");
    window.settled("flying", |status| status["mode"] == "fly");
}

fn there_and_back(window: &mut Window) {
    let before = camera(&window.settled("rest", |_| true));
    let point = ground(&before, [260.0, 190.0]);
    window.xdo("click --repeat 2 --delay 50 1");
    let there = camera(&window.settled("a glide", |status| camera(status).eye != before.eye));
    assert!(there.eye.distance(point) < 0.5 * before.eye.distance(point));
    assert!((ground(&there, [210.0, 150.0]) - point).length() < 1e-3, "it is in the middle");
    window.key("ctrl+2");
    window.key("Home");
    let home = window.settled("the start view", |status| camera(status).eye != there.eye);
    assert!(camera(&home).eye.distance(there.eye) > 0.1);
    window.key("2");
    window.settled("the bookmark", |status| camera(status) == there);
}

fn path(window: &mut Window) {
    let here = camera(&window.status());
    window.key("k");
    window.settled("a key frame", |status| status["key_frames"] == 1);
    window.key("Home");
    let map = canyon();
    let home = NamedView::Start.camera(&map, map.box_size(None));
    window.settled("the start view", |status| camera(status).eye.distance(home.eye) < 1e-9);
    window.key("k");
    window.settled("another", |status| status["key_frames"] == 2);
    window.key("space");
    window.wait("the way", |status| {
        let eye = camera(status).eye;
        status["under_way"] == true && eye.distance(here.eye) > 0.01 && eye.distance(home.eye) > 0.01
    });
    window.settled("its end", |status| status["under_way"] == false && camera(status).eye.distance(home.eye) < 1e-9);
    window.key("space");
    window.wait("the way again", |status| status["under_way"] == true);
    window.key("w");
    let stopped = window.settled("a stop", |status| status["under_way"] == false);
    assert!(camera(&stopped).eye.distance(home.eye) > 1e-6, "any key stops it");
}

/// The path as an animation, cancelled once and then whole. The panel is there.
fn film(window: &mut Window) {
    for closed in ["Terrain", "March"] {
        window.section(closed, false);
    }
    window.section("Camera path", true);
    let file = window.path("flight.png");
    window.fill("Animation file", &file.display().to_string());
    window.fill_number("Animation width", "64");
    window.fill_number("Animation height", "40");
    window.fill_number("Pictures per second", "240");
    window.click("Write animation");
    window.wait("work", |status| status["filming"] == true);
    window.point(400.0, 100.0);
    window.key("Escape");
    window.settled("its end", |status| status["filming"] == false && told(status, "cancelled"));
    assert!(!file.exists());
    window.fill_number("Pictures per second", "3");
    window.click("Write animation");
    window.settled("the animation", |status| told(status, "Saved the animation"));
    use image::AnimationDecoder;
    let reader = std::io::BufReader::new(std::fs::File::open(file).unwrap());
    let frames = image::codecs::png::PngDecoder::new(reader).unwrap().apng().unwrap().into_frames();
    assert_eq!(frames.map(|frame| frame.unwrap().buffer().dimensions()).collect::<Vec<_>>(), [(64, 40); 10]);
}

/// Tab belongs to the picture until the panel has the keyboard.
fn keyboard(window: &mut Window) {
    window.key("F6");
    window.settled("the panel's turn", |status| status["panel"] == true && status["typing"] == true);
    window.key("Tab");
    let walking = window.settled("a step", |_| true);
    assert_eq!((&walking["mode"], &walking["typing"]), (&"fly".into(), &true.into()));
    window.key("F6");
    window.settled("flying", |status| status["typing"] == false);
    window.key("Tab");
    window.settled("orbit", |status| status["mode"] == "orbit");
    film(window);
}
