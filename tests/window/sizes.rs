//! Windows of all sizes.

use crate::harness::{Window, number, widget};

#[test]
fn the_picture_follows_the_window() {
    let mut window = Window::open("--size 800x600");
    for size in [[1000, 420], [1, 1], [2, 2], [300, 700], [640, 480]] {
        window.xdo(&format!("windowsize WINDOW {} {}", size[0], size[1]));
        let status = window.settled("the new size", |status| status["size"] == serde_json::json!(size));
        let textures = crate::harness::list(&status["ledger"]["textures"]).to_vec();
        let picture = textures.iter().find(|texture| texture["name"] == "picture").unwrap().clone();
        let drawn = [number(&picture["width"]) as u32, number(&picture["height"]) as u32];
        // The ledger is of the last picture, which a tiny window may still owe.
        if size[0] > 2 {
            let (_, shot) = window.shot();
            assert_eq!(([shot.width(), shot.height()], drawn), (size, size));
        }
    }
    // Minimised and back.
    window.xdo("windowunmap --sync WINDOW");
    window.xdo("windowmap --sync WINDOW");
    window.xdo("windowfocus --sync WINDOW");
    window.key("F1");
    window.settled("an answer after the pause", |status| status["help"] == true);
    window.close();
}

#[test]
fn a_screen_of_twice_the_density_is_clicked_where_it_shows() {
    let mut window = Window::open_with("--size 1280x900", &[("WINIT_X11_SCALE_FACTOR", "2")]);
    let status = window.settled("rest", |status| status["scale_factor"] == 2.0);
    assert_eq!(status["size"], serde_json::json!([1280, 900]), "the size is in physical pixels");
    let header = widget(&status, "Terrain").unwrap();
    let height = number(&header["rect"][3]) - number(&header["rect"][1]);
    assert!(height > 30.0, "twice as large as usual: {height}");
    let before = number(&status["scene_frames"]);
    window.click("Discard misses");
    let clicked = window.settled("the toggle", |status| status["scene"]["march"]["discard_misses"] == false);
    assert!(number(&clicked["scene_frames"]) > before);
    window.section("Terrain", false);
    window.section("March", false);
    // The last section is below the window's lower edge now, or close to it.
    window.section("Debug", true);
    window.click("Wireframe");
    window.settled("the edges", |status| status["scene"]["debug"]["wireframe"] == true);
    let (_, shot) = window.shot();
    assert_eq!(shot.dimensions(), (1280, 900), "all physical pixels");
    window.close();
}
