//! The renderer and one file per pass, each with the stem of its shader.
//!
//! A frame draws the same unit cube for the terrain, its wireframe, the occluder and, last, the skybox. What is off or
//! out of view has no pass, no texture and no instruction; the [`Ledger`] tells.

mod air;
#[cfg(test)]
mod air_tests;
mod anchor;
mod atmosphere;
#[cfg(test)]
mod bad_numbers_tests;
mod beam;
#[cfg(test)]
mod beam_tests;
mod cloud_pattern;
mod clouds;
mod compile;
mod cones;
mod cube;
mod distances;
mod drape;
mod draws;
mod error;
mod flare;
mod frame;
mod ground;
mod heat_map;
mod images;
mod land;
#[cfg(test)]
mod layout_tests;
mod ledger;
mod light;
mod light_map;
#[cfg(test)]
mod loops_tests;
mod materials;
mod mips;
mod missing;
mod motion;
#[cfg(test)]
mod needs_tests;
mod occluder;
mod pipelines;
mod prepare;
mod present;
mod probe;
mod pyramid_layout;
mod sky_map;
mod sky_model;
mod skybox;
mod split;
mod surfaces;
mod terrain;
mod terrain_key;
mod terrain_uniform;
#[cfg(test)]
mod tests;
mod water;
mod wireframe;

use std::sync::Arc;

use crate::gpu::{DEPTH_CLEAR, FrameTimer, Gpu, Target};
use crate::heightfield::colour::Diffuse;
use crate::heightfield::{EditedTerrain, HeightField};
use crate::scene::{DebugView, Scene};

pub use cones::ConeGround;
pub use error::RenderError;
pub use heat_map::{COVERS_SKY, ERROR_DECADES, SEE_THROUGH, SKY_BOTH, error_colour, heat_map_colour};
pub use ledger::{Ledger, TextureEntry};
pub use light_map::Baking;
pub use motion::Motion;
pub use probe::Probe;
pub use water::{LegEnd, WaterPath};

pub(crate) use anchor::Anchor;
use atmosphere::Atmosphere;
use beam::{Beams, Tiles};
use clouds::Clouds;
pub(crate) use compile::{Compilation, Compiled};
use cube::Cube;
use distances::ExactDistances;
use drape::Drape;
use frame::FrameBindings;
pub(crate) use frame::ray_start;
use ground::Ground;
use images::Images;
use land::Land;
use light_map::LightMap;
use materials::Materials;
use occluder::CubeBindings;
use pipelines::{PipelineKey, Pipelines};
use prepare::{Aim, Draw, Passes};
use skybox::Skybox;
use terrain::TerrainBindings;
use water::WaterBindings;

/// Background where there is no skybox, linear light: a pale grey-blue.
const BACKGROUND: wgpu::Color = wgpu::Color { r: 0.35, g: 0.42, b: 0.5, a: 1.0 };

/// How long a renderer that goes away waits for its last frames: a lost device may never finish them.
const LAST_WAIT: std::time::Duration = std::time::Duration::from_secs(10);

/// Draws scenes into targets; never sees a window.
#[derive(Debug)]
pub struct Renderer {
    gpu: Arc<Gpu>,
    pipelines: Pipelines,
    frame: FrameBindings,
    cube: Cube,
    terrain: TerrainBindings,
    occluder: CubeBindings,
    wireframe: CubeBindings,
    ground: Option<Ground>,
    drape: Option<Drape>,
    land: Land,
    atmosphere: Atmosphere,
    materials: Option<Materials>,
    /// Read for the next picture.
    images: Images,
    skybox: Option<Skybox>,
    beams: Option<Beams>,
    baking: Baking,
    /// There since a sea was drawn.
    water: Option<WaterBindings>,
    /// Exact distances that a frame of the error view finds itself.
    exact: Option<ExactDistances>,
    /// Exact distances that were given to the error view.
    reference: Option<ExactDistances>,
    timer: FrameTimer,
    ledger: Ledger,
    /// Draws of the passes that were noted since the last scene frame, by name.
    shown: Vec<(String, u32)>,
    /// Bytes uploaded since the last scene frame.
    uploaded: u64,
    /// What clocks move of the last picture.
    motion: Motion,
    /// Walks every ray from where it enters the box, to compare.
    #[cfg(test)]
    whole_rays: bool,
}

/// A terrain whose slow parts are computed: the maximum pyramid and, with [`Self::with_colours`], the diffuse texture.
#[derive(Clone, Debug)]
pub struct PreparedTerrain {
    terrain: EditedTerrain,
    colours: Option<Diffuse>,
}

impl PreparedTerrain {
    /// Builds the pyramid of `map`; colours are painted when a frame first needs them.
    pub fn new(map: Arc<HeightField>) -> Self {
        Self { terrain: EditedTerrain::new(map), colours: None }
    }

    /// Paints the diffuse texture, too.
    #[must_use]
    pub fn with_colours(mut self) -> Self {
        self.colours = Some(drape::paint(self.terrain.field()));
        self
    }
}

impl Drop for Renderer {
    /// Waits for the frames in flight: where they are the program's last, a software driver would still be compiling
    /// shaders for them while the end of the program takes its compiler down.
    fn drop(&mut self) {
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(LAST_WAIT) };
        let _ = self.gpu.device.poll(wait);
    }
}

impl Renderer {
    /// A renderer without a terrain. Pipelines are built on first use.
    ///
    /// # Errors
    /// None today; a driver may refuse the first objects.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        Ok(Self {
            pipelines: Pipelines::new(),
            frame: FrameBindings::new(&gpu),
            cube: Cube::new(&gpu),
            terrain: TerrainBindings::new(&gpu),
            occluder: CubeBindings::new(&gpu, "occluder"),
            wireframe: CubeBindings::new(&gpu, "wireframe"),
            ground: None,
            drape: None,
            land: Land::new(&gpu),
            atmosphere: Atmosphere::new(&gpu),
            materials: None,
            images: Images::default(),
            skybox: None,
            beams: None,
            baking: Baking::default(),
            water: None,
            exact: None,
            reference: None,
            timer: FrameTimer::new(&gpu),
            ledger: Ledger::default(),
            shown: Vec::new(),
            uploaded: 0,
            motion: Motion::default(),
            #[cfg(test)]
            whole_rays: false,
            gpu,
        })
    }

    /// Replaces the terrain; on an error the old one stays.
    ///
    /// # Errors
    /// [`RenderError::TerrainTooLarge`] where a side exceeds the adapter's textures, [`RenderError::OutOfMemory`] where
    /// they cannot be allocated.
    pub fn set_terrain(&mut self, map: Arc<HeightField>) -> Result<(), RenderError> {
        self.set_prepared_terrain(PreparedTerrain::new(map))
    }

    /// Replaces the terrain by one whose slow parts were prepared elsewhere, on another thread for instance.
    ///
    /// # Errors
    /// As [`Self::set_terrain`].
    pub fn set_prepared_terrain(&mut self, prepared: PreparedTerrain) -> Result<(), RenderError> {
        let map = prepared.terrain.base();
        let (width, height, limit) = (map.width(), map.height(), self.gpu.capabilities.max_texture);
        if width > limit || height > limit {
            return Err(RenderError::TerrainTooLarge { width, height, limit });
        }
        // What is written to a texture that could not be made is not valid: an error that follows from the first.
        let follow_up = self.gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let scope = self.gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let ground = Ground::new(&self.gpu, prepared.terrain);
        let bytes = ground.try_room(&self.gpu);
        let refused = pollster::block_on(scope.pop()).map(|error| error.to_string());
        let invalid = pollster::block_on(follow_up.pop()).map(|error| error.to_string());
        if let Some(reason) = refused.or(invalid).or_else(|| pretended_refusal(bytes)) {
            return Err(RenderError::OutOfMemory { width, height, bytes, reason });
        }
        self.baking.map = None;
        self.ground = Some(ground);
        self.drape = Some(Drape::new(prepared.colours));
        self.land.forget_place();
        Ok(())
    }

    /// The terrain on the CPU, with the craters of the last frame baked into it, whichever way they are drawn.
    pub fn terrain(&self) -> Option<&EditedTerrain> {
        self.ground.as_ref().map(Ground::terrain)
    }

    /// The device that this renderer draws with.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// What the last frame cost.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Draws a frame of `scene` into `target`: encodes and submits, does not wait. Without a camera in the scene it is
    /// the start view.
    ///
    /// # Errors
    /// [`RenderError`]; nothing is drawn then, and the target keeps its picture.
    pub fn draw(&mut self, scene: &Scene, target: &Target) -> Result<(), RenderError> {
        self.draw_aimed(scene, target, Aim::Picture, None)
    }

    /// Draws like [`Self::draw`] and counts the pixels that the skybox shades (`ledger.sky_pixels`). Waits for the GPU.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn count_sky_pixels(&mut self, scene: &Scene, target: &Target) -> Result<u64, RenderError> {
        let gpu = Arc::clone(&self.gpu);
        let counter = probe::PixelCounter::new(&gpu);
        self.draw_aimed(scene, target, Aim::Picture, Some(&counter))?;
        let pixels = if self.ledger.passes.iter().any(|pass| pass == "skybox") { counter.read(&gpu)? } else { 0 };
        self.ledger.sky_pixels = Some(pixels);
        Ok(pixels)
    }

    fn draw_aimed(
        &mut self,
        scene: &Scene,
        target: &Target,
        aim: Aim<'_>,
        counter: Option<&probe::PixelCounter>,
    ) -> Result<(), RenderError> {
        self.check_device()?;
        let passes = self.prepare(scene, target.size(), aim)?;
        let over = self.air_draws(scene, passes.air, target)?;
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let bakes = !passes.light_map.is_empty();
        self.baking.encode(&mut encoder, &self.frame, &passes.light_map, self.timer.writes(true, false));
        // The first pass that is timed begins the frame.
        self.encode_cloud_shadow(&mut encoder, &over, self.timer.writes(!bakes, false));
        let begun = bakes || passes.air.shadow;
        self.encode_beams(&mut encoder, &passes, self.timer.writes(!begun, false));
        if let Some(draw) = &passes.exact {
            let first = passes.beams.is_none() && !begun;
            self.encode_exact(&mut encoder, draw, &target.depth_view, self.timer.writes(first, false));
        }
        let background = if scene.debug.view == DebugView::Error { heat_map::sky_both() } else { BACKGROUND };
        {
            let attachments = [Some(wgpu::RenderPassColorAttachment {
                view: &target.color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(background), store: wgpu::StoreOp::Store },
            })];
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("scene"),
                color_attachments: &attachments,
                depth_stencil_attachment: Some(clear_depth(&target.depth_view)),
                timestamp_writes: self
                    .timer
                    .writes(passes.beams.is_none() && passes.exact.is_none() && !begun, !passes.air.any_over()),
                occlusion_query_set: counter.map(probe::PixelCounter::queries),
                multiview_mask: None,
            });
            for draw in &passes.draws {
                let counted = draw.name == "skybox" && counter.is_some();
                if counted {
                    pass.begin_occlusion_query(0);
                }
                self.encode(&mut pass, draw);
                if counted {
                    pass.end_occlusion_query();
                }
            }
        }
        if passes.air.any_over() {
            self.encode_over(&mut encoder, &over, target, self.timer.writes(false, true));
        }
        if let Some(counter) = counter {
            counter.resolve(&mut encoder);
        }
        self.timer.submit(&self.gpu, encoder);
        if passes.air.shadow {
            self.atmosphere.shadow_was_drawn();
        }
        self.note_frame(&passes, target);
        self.check_device()
    }

    /// Copies the kept picture over all of an open pass on a window of `format`, and notes it in the ledger.
    ///
    /// # Errors
    /// [`RenderError::Shader`] where the pipeline for this format does not build.
    pub fn present(
        &mut self,
        pass: &mut wgpu::RenderPass<'_>,
        format: wgpu::TextureFormat,
        target: &Target,
    ) -> Result<(), RenderError> {
        let built = self.pipelines.get(&self.gpu, &self.frame.layout, PipelineKey::Present(format))?;
        present::draw(&self.gpu, &built, pass, format, target);
        self.note_pass("present", 1);
        Ok(())
    }

    /// Notes a pass of the caller's in the ledger. A pass noted again replaces its earlier self: a frame of the panel
    /// alone shows the kept picture anew.
    pub fn note_pass(&mut self, name: &str, draws: u32) {
        match self.shown.iter_mut().find(|(noted, _)| noted == name) {
            Some((_, noted)) => {
                self.ledger.draws = self.ledger.draws - *noted + draws;
                *noted = draws;
            }
            None => {
                self.shown.push((name.to_owned(), draws));
                self.ledger.passes.push(name.to_owned());
                self.ledger.draws += draws;
            }
        }
    }

    /// Milliseconds of the oldest frame whose time has arrived and was not handed out yet. Does not wait.
    pub fn take_frame_time(&mut self) -> Option<f64> {
        self.timer.take(&self.gpu)
    }

    /// Waits for the newest frame; its time in milliseconds.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`] where no time arrives.
    pub fn wait_frame_time(&mut self) -> Result<f64, RenderError> {
        let lost = || RenderError::DeviceLost(self.gpu.lost().unwrap_or_else(|| "a frame never ended".into()));
        self.timer.wait(&self.gpu).ok_or_else(lost)
    }

    /// Reads the shader folder again and rebuilds all pipelines; on an error the old ones stay.
    ///
    /// # Errors
    /// [`RenderError::Shader`] with the compiler's message.
    pub fn reload_shaders(&mut self) -> Result<(), RenderError> {
        Ok(self.pipelines.reload(&self.gpu, &self.frame.layout)?)
    }

    /// Takes pipelines that were compiled elsewhere, and images that were read there. Those of another device, or of shaders that were read again since, are
    /// of no use and not kept.
    pub(crate) fn set_compiled(&mut self, mut compiled: Compiled) {
        self.images.keep(compiled.take_images());
        if let Some(pattern) = compiled.take_pattern() {
            self.atmosphere.keep_pattern(pattern);
        }
        if let Some(built) = compiled.made_of(self.pipelines.sources()) {
            self.pipelines.add(built);
        }
    }

    /// Whether the device is still there and has not complained since the last call.
    fn check_device(&self) -> Result<(), RenderError> {
        if let Some(reason) = self.gpu.lost() {
            return Err(RenderError::DeviceLost(reason));
        }
        self.gpu.take_error().map_or(Ok(()), |reason| Err(RenderError::Driver(reason)))
    }

    fn encode_beams(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &Passes,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        if let (Some((pair, area)), Some(beams)) = (&passes.beams, &self.beams) {
            #[cfg(test)]
            if let (true, Some(ground)) = (self.whole_rays, &self.ground) {
                beams.clear(encoder, ground.top_size());
                return;
            }
            beams.encode(encoder, pair, &self.frame, *area, timestamps);
        }
    }

    fn encode(&self, pass: &mut wgpu::RenderPass<'_>, draw: &Draw) {
        pass.set_pipeline(&draw.built.pipeline);
        pass.set_bind_group(0, self.frame.group(&draw.built), &[]);
        pass.set_bind_group(1, &draw.group, &[]);
        draw.area.scissor(pass);
        if draw.edges {
            self.cube.draw_edges(pass);
        } else {
            self.cube.draw_faces(pass);
        }
    }

    fn note_frame(&mut self, passes: &Passes, target: &Target) {
        let mut textures = Vec::new();
        if let Some(ground) = &self.ground {
            ground.list(&mut textures);
        }
        textures.extend(self.drape.as_ref().and_then(Drape::entry));
        self.land.list(&mut textures);
        textures.extend(self.materials.iter().flat_map(Materials::list));
        textures.extend(self.skybox.as_ref().map(Skybox::entry));
        textures.extend(self.beams.iter().flat_map(Beams::entries));
        textures.extend(self.baking.map.as_ref().map(LightMap::entry));
        textures.extend(self.atmosphere.clouds.iter().flat_map(Clouds::list));
        textures.extend(self.exact.as_ref().or(self.reference.as_ref()).map(ExactDistances::entry));
        textures.push(TextureEntry::of("picture", &target.color));
        textures.push(TextureEntry::of("depth", &target.depth));
        let baked = (!passes.light_map.is_empty()).then_some("light map").into_iter();
        let baked = baked.chain(passes.air.shadow.then_some("cloud shadows"));
        let before = baked
            .chain(passes.beams.iter().flat_map(|_| Tiles::ALL.map(Tiles::name)))
            .chain(passes.exact.iter().map(|draw| draw.name));
        let before: Vec<_> = before.collect();
        let terrain = passes.draws.iter().find(|draw| matches!(draw.name, "terrain" | "compare"));
        self.shown.clear();
        self.ledger = Ledger {
            draws: (passes.draws.len() + before.len() + passes.air.over().count()) as u32,
            passes: before
                .into_iter()
                .chain(passes.draws.iter().map(|draw| draw.name))
                .chain(passes.air.over())
                .map(str::to_owned)
                .collect(),
            pipelines: self.pipelines.names(),
            texture_bytes: textures.iter().map(|texture| texture.bytes).sum(),
            textures,
            shader_defs: terrain
                .map_or_else(Vec::new, |draw| draw.built.defs.iter().map(|&def| def.to_owned()).collect()),
            uploaded_bytes: std::mem::take(&mut self.uploaded),
            scene_frames: self.ledger.scene_frames + 1,
            sky_pixels: None,
        };
    }
}

/// Environment variable that makes a debug build's GPU pretend to have no more than so many bytes for a terrain.
const MEMORY_VARIABLE: &str = "RELIEF_MEMORY_LIMIT";

/// Why a terrain of so many bytes does not fit, where a debug build was told to pretend so.
fn pretended_refusal(bytes: u64) -> Option<String> {
    let limit = std::env::var(MEMORY_VARIABLE).ok().filter(|_| cfg!(debug_assertions))?.parse().ok()?;
    (bytes > limit).then(|| format!("{MEMORY_VARIABLE} allows {limit} bytes"))
}

/// A depth attachment cleared to infinity.
fn clear_depth(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(DEPTH_CLEAR), store: wgpu::StoreOp::Store }),
        stencil_ops: None,
    }
}
