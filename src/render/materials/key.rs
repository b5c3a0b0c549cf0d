//! What of the materials is compiled into the terrain's pipeline.

use crate::scene::{ColourSource, Scene};

/// What of the materials is compiled into the terrain's pipeline. All off is the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct MaterialsKey {
    /// The ground's colour is that of materials.
    pub(crate) on: bool,
    /// Coverage maps say where they are.
    pub(crate) coverage: bool,
    /// Their relief bends the light.
    pub(crate) relief: bool,
}

impl MaterialsKey {
    /// What a shaded picture of `scene` needs.
    pub(crate) fn of(scene: &Scene) -> Self {
        let on = scene.diffuse.enabled && scene.diffuse.source == ColourSource::Materials;
        Self {
            on,
            coverage: on && !scene.materials.coverage.is_empty(),
            relief: on && scene.lighting.enabled && scene.materials.relief > 0.0,
        }
    }

    /// Every key but the one that is all off.
    #[cfg(test)]
    pub(crate) fn all() -> [Self; 4] {
        let key = |coverage, relief| Self { on: true, coverage, relief };
        [key(false, false), key(false, true), key(true, false), key(true, true)]
    }

    /// Shader defs.
    pub(crate) fn defs(self) -> impl Iterator<Item = &'static str> {
        let named = [(self.on, "MATERIALS"), (self.coverage, "MATERIALS_COVERAGE"), (self.relief, "MATERIALS_RELIEF")];
        named.into_iter().filter_map(|(on, def)| on.then_some(def))
    }
}
