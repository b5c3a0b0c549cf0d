//! The cone map of the ground and its texture: found when a technique first needs it, kept while the ground stays as it
//! is.

use std::borrow::Cow;

use crate::gpu::Gpu;
use crate::heightfield::{ConeKind, ConeMap, HeightField, SampleRect};

use super::ground::{Texture, empty_texture, upload};
use super::ledger::TextureEntry;

/// Cone maps of one state of the ground, and the textures of those in use.
#[derive(Debug, Default)]
pub(super) struct Cones {
    /// On the CPU, so that going back to a technique only uploads.
    maps: Vec<ConeMap>,
    textures: Vec<(ConeKind, Texture)>,
}

impl Cones {
    /// Forgets everything: a crater can change the cones of cells everywhere.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    fn has(&self, kind: ConeKind) -> bool {
        self.maps.iter().any(|map| map.kind() == kind)
    }

    /// Brings the textures to what is needed, finding the cones of `field` where they are not known; `progress` hears how
    /// far that is. Returns the bytes uploaded.
    pub(super) fn prepare<'a>(
        &mut self,
        gpu: &Gpu,
        needed: &[ConeKind],
        field: impl Fn() -> Cow<'a, HeightField>,
        progress: &(dyn Fn(f32) + Sync),
    ) -> u64 {
        // Those not needed go first: there need not be room for all.
        self.textures.retain(|(resident, _)| needed.contains(resident));
        let mut uploaded = 0;
        for &kind in needed {
            if self.textures.iter().any(|(resident, _)| *resident == kind) {
                continue;
            }
            if !self.has(kind) {
                self.maps.push(ConeMap::build(&field(), kind, progress));
            }
            let Some(map) = self.maps.iter().find(|map| map.kind() == kind) else { continue };
            let [width, height] = map.cells();
            let format = match kind {
                ConeKind::Cone => wgpu::TextureFormat::R32Float,
                ConeKind::Relaxed => wgpu::TextureFormat::Rg32Float,
            };
            let texture = empty_texture(gpu, "cones", [width, height], format);
            let all = SampleRect { x: 0, y: 0, width, height };
            uploaded += upload(gpu, &texture.texture, [0, 0], map.slopes(), width, all);
            self.textures.push((kind, texture));
        }
        uploaded
    }

    pub(super) fn view(&self, kind: ConeKind) -> Option<&wgpu::TextureView> {
        self.textures.iter().find(|(resident, _)| *resident == kind).map(|(_, texture)| &texture.view)
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = TextureEntry> + '_ {
        self.textures.iter().map(|(_, texture)| TextureEntry::of("cones", &texture.texture))
    }
}
