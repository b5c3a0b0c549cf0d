//! Each toggle changes what it should, and only that.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail loudly")]

mod common;

#[path = "toggles/change.rs"]
mod change;

#[path = "toggles/air.rs"]
mod air;
#[path = "toggles/compare.rs"]
mod compare;
#[path = "toggles/craters.rs"]
mod craters;
#[path = "toggles/debug.rs"]
mod debug;
#[path = "toggles/filter.rs"]
mod filter;
#[path = "toggles/land.rs"]
mod land;
#[path = "toggles/light.rs"]
mod light;
#[path = "toggles/march.rs"]
mod march;
#[path = "toggles/occluder.rs"]
mod occluder;
#[path = "toggles/repeat.rs"]
mod repeat;
