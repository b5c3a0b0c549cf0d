//! Cone maps of the ground and their textures. A map is found when a technique first needs it, or elsewhere and given to
//! the renderer, and kept for as long as it may be of use; a texture exists only while a frame needs it.

use std::borrow::Cow;
use std::sync::Arc;

use crate::gpu::Gpu;
use crate::heightfield::{ConeKind, ConeMap, Crater, CraterLayer, EditedTerrain, HeightField, SampleRect};
use crate::scene::{CraterMode, CraterSettings};

use super::ground::{Texture, empty_texture, upload};
use super::ledger::TextureEntry;

/// Cone maps that are kept on the CPU: two kinds for the ground on screen, and as many for that of a measurement or of the
/// last crater, which may be taken back.
const MOST_MAPS: usize = 4;

/// The ground that a map of cones stands on: a height map and the craters in it, the way they are drawn.
///
/// Two are equal where they have the same height map, by its identity, and the same craters.
#[derive(Clone, Debug)]
pub struct ConeGround {
    map: Arc<HeightField>,
    craters: Vec<Crater>,
    /// Samples along the longer side of the layer that holds the craters; `None` where they are baked into the heights.
    layer: Option<u32>,
}

impl PartialEq for ConeGround {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.map, &other.map) && (&self.craters, self.layer) == (&other.craters, other.layer)
    }
}

impl ConeGround {
    /// `map` with craters, for an adapter whose textures have at most `most_texture` texels a side.
    pub fn new(map: &Arc<HeightField>, craters: &CraterSettings, most_texture: u32) -> Self {
        // One that is not valid displaces nothing; and where it is not a number it would not even be like itself.
        let list: Vec<_> = craters.list.iter().filter(|crater| crater.is_valid()).copied().collect();
        let layered = craters.mode == CraterMode::Layered && !list.is_empty();
        Self {
            map: Arc::clone(map),
            craters: list,
            layer: layered.then(|| layer_resolution(craters.layer_resolution, most_texture)),
        }
    }

    /// The height map without craters.
    pub fn map(&self) -> &Arc<HeightField> {
        &self.map
    }

    /// The heights at the map's samples, with the craters. Those of a large map take a moment.
    pub fn field(&self) -> Cow<'_, HeightField> {
        match self.layer {
            _ if self.craters.is_empty() => Cow::Borrowed(&self.map),
            Some(resolution) => {
                Cow::Owned(CraterLayer::rasterise(&self.craters, &self.map, resolution).apply_to(&self.map))
            }
            None => {
                let mut edited = EditedTerrain::new(Arc::clone(&self.map));
                edited.set_craters(&self.craters);
                Cow::Owned(edited.field().clone())
            }
        }
    }
}

/// Samples along the longer side of a crater layer, for textures of at most `most_texture` texels a side.
pub(super) fn layer_resolution(wanted: u32, most_texture: u32) -> u32 {
    wanted.clamp(2, most_texture)
}

/// Cone maps, and the textures of those in use.
#[derive(Debug, Default)]
pub(super) struct Cones {
    /// The newest last.
    maps: Vec<(ConeGround, Arc<ConeMap>)>,
    textures: Vec<(Arc<ConeMap>, Texture)>,
}

impl Cones {
    /// The map of this kind for this ground, where it is known.
    pub(super) fn find(&self, ground: &ConeGround, kind: ConeKind) -> Option<&Arc<ConeMap>> {
        self.maps.iter().find(|(of, map)| map.kind() == kind && of == ground).map(|(_, map)| map)
    }

    /// Keeps a map, in place of the oldest where there are enough.
    pub(super) fn keep(&mut self, ground: ConeGround, map: Arc<ConeMap>) {
        self.maps.retain(|(of, other)| other.kind() != map.kind() || *of != ground);
        self.maps.push((ground, map));
        self.maps.drain(..self.maps.len().saturating_sub(MOST_MAPS));
    }

    /// Gives the textures back; the maps stay.
    pub(super) fn drop_textures(&mut self) {
        self.textures.clear();
    }

    /// Brings the textures to what is needed on `ground`, finding cones where they are not known; `progress` hears how far
    /// that is. Returns the bytes uploaded.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        needed: &[ConeKind],
        ground: &ConeGround,
        progress: &(dyn Fn(f32) + Sync),
    ) -> u64 {
        let mut maps = Vec::new();
        for &kind in needed {
            let map = match self.find(ground, kind) {
                Some(map) => Arc::clone(map),
                None => {
                    let map = Arc::new(ConeMap::build(&ground.field(), kind, progress));
                    self.keep(ground.clone(), Arc::clone(&map));
                    map
                }
            };
            maps.push(map);
        }
        // Those not needed go first: there need not be room for all.
        self.textures.retain(|(resident, _)| maps.iter().any(|map| Arc::ptr_eq(map, resident)));
        let mut uploaded = 0;
        for map in maps {
            if self.textures.iter().any(|(resident, _)| Arc::ptr_eq(resident, &map)) {
                continue;
            }
            let [width, height] = map.cells();
            let format = match map.kind() {
                ConeKind::Cone => wgpu::TextureFormat::R32Float,
                ConeKind::Relaxed => wgpu::TextureFormat::Rg32Float,
            };
            let texture = empty_texture(gpu, "cones", [width, height], format);
            let all = SampleRect { x: 0, y: 0, width, height };
            uploaded += upload(gpu, &texture.texture, [0, 0], map.slopes(), width, all);
            self.textures.push((map, texture));
        }
        uploaded
    }

    pub(super) fn view(&self, kind: ConeKind) -> Option<&wgpu::TextureView> {
        self.textures.iter().find(|(resident, _)| resident.kind() == kind).map(|(_, texture)| &texture.view)
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = TextureEntry> + '_ {
        self.textures.iter().map(|(_, texture)| TextureEntry::of("cones", &texture.texture))
    }
}
