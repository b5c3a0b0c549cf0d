//! Another ground takes the place of the one on screen: what belonged to the old one goes with it.

use std::time::Instant;

use super::files::maps::{Place, Source};
use super::frame::FrameError;
use super::graphics::Graphics;
use super::loading::Opened;
use super::settings::{Facts, PathFields};
use super::viewer::Viewer;
use crate::camera::NamedView;
use crate::render::{PreparedTerrain, RenderError};
use crate::scene::{CraterMode, LevelUnit, MaterialSettings, Technique};

impl Viewer {
    /// Replaces the terrain. What belonged to the old one goes with it; when the new one cannot be used, all stays.
    pub(super) fn adopt(&mut self, graphics: &mut Graphics, opened: Opened, now: Instant) -> Result<(), FrameError> {
        let left = Place::of(&self.scene, self.map.box_size(None));
        if !self.take_ground(graphics, opened.terrain, &opened.about.source)? {
            return Ok(());
        }
        // The old map's bookmarks are written before they are those of the new one.
        self.keep_now();
        self.scene.terrain.recipe = opened.about.recipe_of(&opened.map);
        self.map = opened.map;
        if let Some(recipe) = opened.about.source.recipe() {
            self.view.generate.take(recipe);
        }
        self.scene.terrain.file.clone_from(&opened.about.path);
        self.scene.terrain.height_scale = None;
        // The old map's heights and place mean nothing here.
        (self.scene.land.low, self.scene.land.high, self.scene.land.contour_interval) = (None, None, None);
        self.scene.land.imagery = None;
        self.scene.materials.coverage.clear();
        self.scene.craters.list.clear();
        self.scene.occluder.position = None;
        (self.scene.lighting.clock.latitude, self.scene.lighting.clock.longitude) = (None, None);
        self.scene.lighting.clock.stand_on(opened.bounds);
        self.scene.camera = Some(NamedView::Start.camera(&self.map, self.extent()));
        self.arrive(&opened.about, left);
        self.leave_out_what_it_cannot_show(now);
        self.journey.stop();
        self.take_up_bookmarks();
        self.ground_is_new(graphics, opened.about.title, now);
        self.view.paths = PathFields::of(&self.scene);
        self.toasts.info(&format!("Opened {}", self.facts.title), now);
        for warning in opened.warnings {
            self.toasts.warning(&warning, now);
        }
        Ok(())
    }

    /// Gives the renderer another ground. False where it cannot be used, which has been told: the old one stays.
    pub(super) fn take_ground(
        &mut self,
        graphics: &mut Graphics,
        terrain: PreparedTerrain,
        source: &Source,
    ) -> Result<bool, FrameError> {
        match graphics.renderer.set_prepared_terrain(terrain) {
            Ok(()) => Ok(true),
            Err(RenderError::DeviceLost(lost)) => Err(FrameError::Lost(lost)),
            Err(error) => {
                self.toasts.error(&format!("The old terrain stays: {error}"));
                self.files.gave_up(source);
                Ok(false)
            }
        }
    }

    /// Forgets what was known of the ground before, and learns what is of this one.
    pub(super) fn ground_is_new(&mut self, graphics: &mut Graphics, title: String, now: Instant) {
        self.tradeoff.forget();
        self.view.reading.forget();
        self.meter.forget_times();
        (self.drawn, self.shown, self.last_good) = (None, None, None);
        if self.film.is_some() {
            self.cancel_export(now);
        }
        // Its picture may need other pipelines, as that of a first map with holes does: said before they are waited for.
        let size = graphics.target.size();
        self.prepared = graphics.renderer.missing_pipelines(&self.scene, size, false).is_none();
        self.facts = Facts::new(&self.map, title, &graphics.gpu);
        self.window.set_title(&format!("Relief: {}", self.facts.title));
    }

    /// Settings that are kept from map to map, and that this one cannot be drawn with.
    fn leave_out_what_it_cannot_show(&mut self, now: Instant) {
        let chosen = [&mut self.scene.march.technique, &mut self.scene.compare.technique];
        let whole = |technique: Technique| matches!(technique, Technique::Smooth | Technique::Fractal);
        if self.map.holes().is_some() {
            for technique in chosen.into_iter().filter(|technique| whole(**technique)) {
                let name = technique.name();
                *technique = Technique::MaxMipmap;
                self.toasts.info(&format!("The map has holes: max-mipmap draws it, not {name}."), now);
            }
        }
        let layered = self.scene.craters.mode == CraterMode::Layered && !self.scene.craters.list.is_empty();
        for technique in [&mut self.scene.march.technique, &mut self.scene.compare.technique] {
            if layered && *technique == Technique::Fractal {
                *technique = Technique::MaxMipmap;
                self.toasts.info("This map's craters are layered: max-mipmap draws it, not fractal.", now);
            }
        }
        let materials = &mut self.scene.materials;
        if self.map.extent_metres().is_none() && materials.levels == LevelUnit::Metres {
            *materials = MaterialSettings { coverage: std::mem::take(&mut materials.coverage), ..Default::default() };
            self.toasts.info("The map knows no metres: the materials' levels are shares of its height again.", now);
        }
        let water = &mut self.scene.water;
        if self.map.extent_metres().is_none() && water.levels == LevelUnit::Metres {
            (water.level, water.levels) = (None, LevelUnit::Share);
            self.toasts.info("The map knows no metres: the sea has its usual level again.", now);
        }
    }
}
