//! Relief draws height maps without a mesh: it draws one unit cube, and a fragment shader casts one ray per pixel
//! through the height field inside it.
//!
//! # The map of the house
//!
//! | module | what it holds |
//! |---|---|
//! | [`heightfield`] | the map itself: loading, generating, the maximum pyramid, craters, the f64 reference |
//! | [`scene`], [`camera`] | what to draw and from where, as plain data that can be saved |
//! | [`scene_file`] | scenes as TOML files, with messages that help |
//! | [`camera_path`], [`animation`] | a way of the eye through key frames; its pictures as files |
//! | [`files`] | writing files whole or not at all |
//! | [`logbook`] | the last messages, for the viewer's log |
//! | [`gpu`] | the device and what it can do, targets and readback, timing, shader composition |
//! | [`render`] | the [`Renderer`](render::Renderer), one file per pass with the stem of its shader, the ledger |
//! | [`report`] | error against run time: the figures, the sweep, tables and plots; the stiff and extreme cases |
//! | [`app`] | the window: input, panel, overlays. Only here are winit and egui |
//! | [`cli`] | the commands |
//!
//! To read: [a tour of five minutes](guide::tour), [what each format can carry](guide::formats),
//! [how to add a technique](guide::technique).
//!
//! Imports run one way: `files`, `heightfield`, `scene`, `camera` ← `gpu` ← `render` ← `report`, `app` ← `cli`. The library renders
//! without a window. `shaders/` mirrors [`render`]: one WGSL file per pass, and one per technique under `shaders/march/`.
//!
//! # Example
//!
//! A height map to a picture:
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use std::{path::Path, sync::Arc};
//! use relief::{gpu::{Gpu, Target}, heightfield::load::load, render::Renderer, scene::Scene};
//!
//! let gpu = Gpu::headless()?;
//! let mut renderer = Renderer::new(Arc::clone(&gpu))?;
//! renderer.set_terrain(Arc::new(load(Path::new("assets/grand-canyon.png"))?.field))?;
//! let target = Target::new(&gpu, [320, 240]);
//! renderer.draw(&Scene::default(), &target)?;
//! let picture = target.read_color(&gpu)?;
//! picture.save(std::env::temp_dir().join("canyon.png"))?;
//! # assert!(picture.pixels().any(|pixel| pixel[0] > pixel[2]), "red rock");
//! # Ok(())
//! # }
//! ```
#![cfg_attr(test, expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test may fail loudly"))]

pub mod animation;
pub mod app;
pub mod camera;
pub mod camera_path;
pub mod cli;
pub mod files;
pub mod gpu;
pub mod guide;
pub mod heightfield;
pub mod logbook;
pub mod render;
pub mod report;
pub mod scene;
pub mod scene_file;
