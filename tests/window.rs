//! The viewer as a user meets it: a real window on a virtual screen, keys and mouse by xdotool, and the state, the
//! ledger and the screenshots that come of it. Needs the packages xvfb and xdotool; without them these tests fail.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test may fail loudly")]

#[path = "window/desktop.rs"]
mod desktop;
#[path = "window/harness.rs"]
mod harness;

#[path = "window/compare.rs"]
mod compare;
#[cfg(debug_assertions)]
#[path = "window/compiling.rs"]
mod compiling;
#[path = "window/cones.rs"]
mod cones;
#[path = "window/craters.rs"]
mod craters;
#[path = "window/files.rs"]
mod files;
#[path = "window/flying.rs"]
mod flying;
#[path = "window/generate.rs"]
mod generate;
#[path = "window/idle.rs"]
mod idle;
#[path = "window/kept.rs"]
mod kept;
#[path = "window/keys.rs"]
mod keys;
#[path = "window/land.rs"]
mod land;
#[path = "window/moving.rs"]
mod moving;
#[path = "window/panel.rs"]
mod panel;
#[path = "window/scale.rs"]
mod scale;
#[cfg(debug_assertions)]
#[path = "window/shaders.rs"]
mod shaders;
#[path = "window/sizes.rs"]
mod sizes;
#[cfg(debug_assertions)]
#[path = "window/surface.rs"]
mod surface;
#[path = "window/typing.rs"]
mod typing;
#[path = "window/weather.rs"]
mod weather;
#[path = "window/without_display.rs"]
mod without_display;
