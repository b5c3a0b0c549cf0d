//! The command line as a user meets it: the binary is run, and its exit code, messages and files are looked at.
#![expect(clippy::unwrap_used, reason = "a test may fail loudly")]

#[path = "cli/bench.rs"]
mod bench;

#[path = "cli/adapters.rs"]
mod adapters;
#[path = "cli/files.rs"]
mod files;
#[path = "cli/maps.rs"]
mod maps;
#[path = "cli/others.rs"]
mod others;
#[path = "cli/outputs.rs"]
mod outputs;
#[path = "cli/path.rs"]
mod path;
#[path = "cli/readme.rs"]
mod readme;
#[path = "cli/render.rs"]
mod render;
#[path = "cli/scenes.rs"]
mod scenes;
#[path = "cli/usage.rs"]
mod usage;
