//! Which pipeline a scene needs for its terrain.

use super::air::AirKey;
use super::land::LandKey;
use crate::heightfield::ConeKind;
use crate::scene::{ColourSource, CraterMode, DebugView, HeightFilter, Scene, Technique};

use super::materials::MaterialsKey;

use super::light::LightKey;

/// What the pass writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Output {
    /// A picture.
    View(DebugView),
    /// Distance, steps, capped.
    Probe,
}

/// All that is compiled into the terrain's pipeline. What a technique or view does not use is normalised away, so that
/// flipping it builds nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TerrainKey {
    pub(super) technique: Technique,
    pub(super) filter: HeightFilter,
    pub(super) steps_by_angle: bool,
    pub(super) lower_start: bool,
    pub(super) discard_misses: bool,
    pub(super) lighting: bool,
    pub(super) diffuse: bool,
    pub(super) materials: MaterialsKey,
    pub(super) layered: bool,
    /// Hits are read from a texture of distances, and no ray is cast.
    pub(super) given: bool,
    /// The map has holes, and what the pass does may meet one.
    pub(super) holes: bool,
    /// Rays are counted from an anchor at the visible ground (`anchor.rs`).
    pub(super) deep: bool,
    /// A probe counts texel reads in place of steps.
    pub(super) counts: bool,
    /// The land is shown as on a map (`land.rs`).
    pub(super) land: LandKey,
    /// What the light adds.
    pub(super) light: LightKey,
    /// What the air adds.
    pub(super) air: AirKey,
    pub(super) output: Output,
}

impl TerrainKey {
    /// The pipeline that `scene` needs for a picture, or for a probe of it.
    pub(super) fn of(scene: &Scene, probe: bool) -> Self {
        Self::of_technique(scene, scene.march.technique, probe)
    }

    /// The same with another technique than the scene's.
    pub(super) fn of_technique(scene: &Scene, technique: Technique, probe: bool) -> Self {
        let march = &scene.march;
        let output = if probe { Output::Probe } else { Output::View(scene.debug.view) };
        let shaded = output == Output::View(DebugView::None);
        let land = if shaded { LandKey::of(&scene.land) } else { LandKey::default() };
        let key = Self {
            technique,
            filter: if technique.samples_uniformly() { march.filter } else { HeightFilter::Exact },
            steps_by_angle: technique.counts_samples() && march.steps_by_angle,
            lower_start: march.lower_start,
            // A miss is an error to be shown, whatever a picture would show in its place.
            discard_misses: march.discard_misses || output == Output::View(DebugView::Error),
            lighting: shaded && scene.lighting.enabled && !land.lights_ground(),
            diffuse: shaded
                && scene.diffuse.enabled
                && scene.diffuse.source == ColourSource::Texture
                && !land.colours_ground(),
            materials: if shaded && !land.colours_ground() {
                let key = MaterialsKey::of(scene);
                MaterialsKey { relief: key.relief && !land.lights_ground(), ..key }
            } else {
                MaterialsKey::default()
            },
            layered: scene.craters.mode == CraterMode::Layered && !scene.craters.list.is_empty(),
            given: false,
            holes: false,
            deep: false,
            counts: false,
            light: if shaded && !land.lights_ground() { LightKey::of(scene) } else { LightKey::default() },
            air: if !shaded {
                AirKey::default()
            } else if scene.lighting.enabled && !land.lights_ground() {
                AirKey::of(scene)
            } else {
                AirKey::of(scene).unlit()
            },
            land,
            output,
        };
        if key.finds_ground() { key } else { Self::without_rays() }
    }

    /// What finds the exact distances of `scene`, for the error view.
    pub(super) fn of_exact_distances(scene: &Scene) -> Self {
        Self { discard_misses: true, ..Self::of_technique(scene, Technique::MaxMipmap, true) }
    }

    /// The same picture from given distances: how hits would be found does not matter then.
    pub(super) fn with_given_distances(self) -> Self {
        if !self.finds_ground() {
            return self;
        }
        let key = Self {
            technique: Technique::default(),
            filter: HeightFilter::Exact,
            steps_by_angle: false,
            lower_start: true,
            given: true,
            ..self
        };
        Self { layered: key.layered && key.reads_heights(), ..key }
    }

    /// The same for a view that is a deep zoom, or none. Only the exact technique is precise enough to need more than f32
    /// has: the others are wrong by more than that, and what is given as an f32 distance has lost it already.
    pub(super) fn in_a_deep_zoom(self, deep: bool) -> Self {
        Self { deep: deep && self.starts_from_beams() && !self.is_another_surface(), ..self }
    }

    /// The same counting texel reads. Only the exact technique's differ from its steps by more than a factor.
    pub(super) fn counting_reads(self) -> Self {
        Self { counts: self.starts_from_beams() && !self.is_another_surface() && !self.deep, ..self }
    }

    /// The same over a map with holes, or without.
    pub(super) fn over_holes(self, holes: bool) -> Self {
        Self { holes: holes && self.reads_heights() && !self.is_another_surface(), ..self }
    }

    /// Whether the pass finds out where the ground is.
    pub(super) fn finds_ground(&self) -> bool {
        self.output != Output::View(DebugView::Position)
    }

    /// Whether rays are cast.
    pub(super) fn marches(&self) -> bool {
        self.finds_ground() && !self.given
    }

    /// Whether heights are read: by the rays, or for normals alone.
    pub(super) fn reads_heights(&self) -> bool {
        self.marches() || self.needs_normals() || self.land.reads_heights()
    }

    fn needs_normals(&self) -> bool {
        self.shading_normal() || self.land.needs_normals() || self.output == Output::View(DebugView::Normals)
    }

    /// Whether what is hit is shaded by its normal.
    fn shading_normal(&self) -> bool {
        self.lighting || self.materials.on
    }

    /// Whether hits are compared with the exact distances.
    pub(super) fn needs_exact_distances(&self) -> bool {
        self.output == Output::View(DebugView::Error)
    }

    /// Whether rays walk the maximum pyramid from where beams end.
    pub(super) fn starts_from_beams(&self) -> bool {
        self.marches() && self.technique.walks_pyramid()
    }

    /// Whether the ground is the smooth surface.
    pub(super) fn is_smooth(&self) -> bool {
        self.marches() && self.technique == Technique::Smooth
    }

    /// Whether the ground has invented detail.
    pub(super) fn is_fractal(&self) -> bool {
        self.marches() && self.technique == Technique::Fractal
    }

    /// Whether the ground is not the bilinear one.
    pub(super) fn is_another_surface(&self) -> bool {
        self.is_smooth() || self.is_fractal()
    }

    /// Whether the maximum pyramid is walked: by the technique, or towards the sun.
    pub(super) fn needs_pyramid(&self) -> bool {
        self.starts_from_beams() || self.light.casts_shadows()
    }

    /// The cone map that the technique steps along.
    pub(super) fn needs_cones(&self) -> Option<ConeKind> {
        self.technique.cones().filter(|_| self.marches())
    }

    /// Whether heights are read through the sampler's linear filter.
    pub(super) fn filters_heights(&self) -> bool {
        self.filter == HeightFilter::HardwareLinear
    }

    fn without_rays() -> Self {
        Self {
            technique: Technique::default(),
            filter: HeightFilter::Exact,
            steps_by_angle: false,
            lower_start: false,
            discard_misses: false,
            lighting: false,
            diffuse: false,
            materials: MaterialsKey::default(),
            layered: false,
            given: false,
            holes: false,
            deep: false,
            counts: false,
            land: LandKey::default(),
            light: LightKey::default(),
            air: AirKey::default(),
            output: Output::View(DebugView::Position),
        }
    }

    /// Every key that a scene can lead to.
    #[cfg(test)]
    pub(super) fn all() -> Vec<Self> {
        let mut keys = std::collections::HashSet::new();
        for (technique, filter, view) in Technique::ALL.into_iter().flat_map(|technique| {
            [HeightFilter::Exact, HeightFilter::HardwareLinear, HeightFilter::Nearest]
                .into_iter()
                .flat_map(move |filter| DebugView::ALL.map(|view| (technique, filter, view)))
        }) {
            for bits in 0..128u32 {
                let bit = |index: u32| bits & (1 << index) != 0;
                let mut scene = Scene::default();
                scene.march.technique = technique;
                scene.march.filter = filter;
                scene.march.steps_by_angle = bit(0);
                scene.march.lower_start = bit(1);
                scene.march.discard_misses = bit(2);
                scene.lighting.enabled = bit(3);
                scene.diffuse.enabled = bit(4);
                scene.debug.view = view;
                if bit(5) {
                    scene.craters.mode = CraterMode::Layered;
                    scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
                }
                let key = Self::of(&scene, bit(6));
                let exact = Self::of_exact_distances(&scene);
                let mut found =
                    vec![key, exact, exact.counting_reads(), key.in_a_deep_zoom(true), exact.in_a_deep_zoom(true)];
                if !bit(6) {
                    found.push(key.with_given_distances());
                }
                keys.extend(found.into_iter().flat_map(|key| [key, key.over_holes(true)]));
            }
        }
        // Of the land, a few with each other and with what changes how heights are read: not every pair.
        let base = Self::of(&Scene::default(), false);
        let layered = Self { layered: true, ..base };
        for base in [base, layered, base.in_a_deep_zoom(true), base.with_given_distances()] {
            keys.extend(LandKey::some().into_iter().flat_map(|land| {
                let (lighting, diffuse) = (!land.lights_ground(), !land.colours_ground());
                let key = Self { land, lighting, diffuse, ..base };
                [key, key.over_holes(true)]
            }));
        }
        // Each kind of light with the exact technique and all else that it touches, one of them with the others.
        for technique in Technique::ALL {
            let base = Self::of_technique(&Scene::default(), technique, false);
            let lights = if technique == Technique::MaxMipmap { usize::MAX } else { 1 };
            for light in LightKey::all().into_iter().take(lights) {
                let lit = Self { light, ..base };
                let deep = lit.in_a_deep_zoom(true);
                let layered = Self { layered: true, diffuse: false, discard_misses: false, ..lit };
                let all = [lit, lit.over_holes(true), deep, deep.over_holes(true), layered, lit.with_given_distances()];
                keys.extend(all);
            }
        }
        keys.extend(Self::some_with_air());
        keys.extend(Self::some_with_materials());
        for technique in [Technique::Smooth, Technique::Fractal] {
            keys.extend(Self::some_of_another_surface(technique));
        }
        keys.into_iter().collect()
    }

    /// Each kind of air over a few grounds and lights.
    #[cfg(test)]
    fn some_with_air() -> impl Iterator<Item = Self> {
        let mut scene = Scene::default();
        let base = Self::of(&scene, false);
        scene.lighting.enabled = false;
        let unlit = Self::of(&scene, false);
        let full = Self { light: LightKey::all()[3], ..base };
        let bases = [base, base.in_a_deep_zoom(true), base.over_holes(true), base.with_given_distances(), full];
        let lit = bases.into_iter().flat_map(|base| AirKey::all().map(|air| Self { air, ..base }));
        lit.chain(AirKey::all().map(move |air| Self { air: air.unlit(), ..unlit }))
    }

    /// Each way to paint materials, under a few of the ways to find and light the ground.
    #[cfg(test)]
    fn some_with_materials() -> impl Iterator<Item = Self> {
        let mut scene = Scene::default();
        scene.diffuse.enabled = false;
        let base = Self::of(&scene, false);
        let bases = [
            base,
            base.in_a_deep_zoom(true),
            base.over_holes(true),
            base.in_a_deep_zoom(true).over_holes(true),
            base.with_given_distances(),
            Self { technique: Technique::Linear, ..base },
        ];
        bases.into_iter().flat_map(|base| {
            let unlit = |key: MaterialsKey| Self { lighting: base.lighting && key.relief, materials: key, ..base };
            MaterialsKey::all().map(unlit)
        })
    }

    /// A surface that is not the bilinear one in each view, lit and not, and as a probe.
    #[cfg(test)]
    fn some_of_another_surface(technique: Technique) -> impl Iterator<Item = Self> {
        let mut scene = Scene::default();
        scene.march.technique = technique;
        let mut keys = vec![Self::of(&scene, true)];
        for view in DebugView::ALL {
            scene.debug.view = view;
            keys.push(Self::of(&scene, false));
        }
        scene.debug.view = DebugView::None;
        scene.lighting.enabled = false;
        keys.push(Self::of(&scene, false));
        scene.lighting.enabled = true;
        scene.march.lower_start = false;
        scene.craters.mode = CraterMode::Layered;
        scene.craters.list.push(scene.craters.brush_at(0.5, 0.5));
        scene.diffuse.source = ColourSource::Materials;
        keys.push(Self::of(&scene, false));
        keys.into_iter()
    }

    pub(super) fn defs(&self) -> Vec<&'static str> {
        let shaded = self.output == Output::View(DebugView::None);
        let own = [
            (self.filter == HeightFilter::HardwareLinear, "FILTER_HARDWARE_LINEAR"),
            (self.filters_heights(), "HEIGHT_SAMPLER"),
            (self.filter == HeightFilter::Nearest, "FILTER_NEAREST"),
            (self.starts_from_beams(), "BEAM"),
            (self.is_smooth(), "SMOOTH_SURFACE"),
            (self.is_fractal(), "FRACTAL_SURFACE"),
            (self.shading_normal(), "SHADING_NORMAL"),
            (self.deep, "DEEP_ZOOM"),
            (self.counts, "COUNT_READS"),
            (self.holes, "HOLES"),
            (self.steps_by_angle, "STEPS_BY_ANGLE"),
            (self.lower_start, "LOWER_START"),
            (self.discard_misses, "DISCARD_MISSES"),
            (self.layered, "CRATERS_LAYERED"),
            (shaded, "SHADED"),
            (self.lighting, "LIGHTING"),
            (self.diffuse, "DIFFUSE_TEXTURE"),
            (self.needs_normals(), "SURFACE_NORMAL"),
            (self.given, "GIVEN_DISTANCES"),
            (self.output == Output::Probe, "PROBE"),
            (self.output == Output::View(DebugView::Position), "VIEW_POSITION"),
            (self.output == Output::View(DebugView::Steps), "VIEW_STEPS"),
            (self.needs_exact_distances(), "VIEW_ERROR"),
            (self.output == Output::View(DebugView::Normals), "VIEW_NORMALS"),
            (self.output == Output::View(DebugView::Distance), "VIEW_DISTANCE"),
        ];
        let own = own.into_iter().filter_map(|(on, def)| on.then_some(def));
        own.chain(self.air.defs())
            .chain(self.land.defs())
            .chain(self.light.defs())
            .chain(self.materials.defs())
            .collect()
    }

    pub(super) fn march_file(&self) -> &'static str {
        match self.technique {
            Technique::Linear => "march/linear.wgsl",
            Technique::LinearBinary => "march/linear-binary.wgsl",
            Technique::Secant => "march/secant.wgsl",
            Technique::Cone => "march/cone.wgsl",
            Technique::RelaxedCone => "march/relaxed-cone.wgsl",
            Technique::MaxMipmap if self.deep => "march/max-mipmap-deep.wgsl",
            Technique::MaxMipmap | Technique::Smooth | Technique::Fractal => "march/max-mipmap.wgsl",
        }
    }
}
