//! What a frame costs, as data: what is off or out of view is not in it.

use serde::Serialize;

/// What the last frame cost and what is alive.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Ledger {
    /// Passes in their order: `light map` when it is drawn, `coarse beam`, `beam`, `exact`, `terrain`, `compare`, `wireframe`, `occluder`, `skybox` of the last scene frame, then `present` and
    /// `egui` of the last time it was shown. A frame of the panel alone runs only those two again.
    pub passes: Vec<String>,
    /// The renderer's pipelines alive, by name.
    pub pipelines: Vec<String>,
    /// Draw calls of those passes.
    pub draws: u32,
    /// The renderer's textures alive, the target's included; those of the panel are egui's.
    pub textures: Vec<TextureEntry>,
    /// Their bytes.
    pub texture_bytes: u64,
    /// Shader defs of the terrain's pipeline; empty where no terrain was drawn, those of the left one
    /// where two techniques are compared.
    pub shader_defs: Vec<String>,
    /// Bytes uploaded to textures since the scene frame before the last.
    pub uploaded_bytes: u64,
    /// Scene frames drawn since the renderer was made; a change of the panel alone draws none.
    pub scene_frames: u64,
    /// Pixels that the skybox shaded; counted by [`Renderer::count_sky_pixels`](super::Renderer::count_sky_pixels) only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sky_pixels: Option<u64>,
}

/// A texture of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureEntry {
    /// What it is for: `heights`, `pyramid`, `cones`, `crater layer`, `diffuse`, `sky`, `light map`, `coarse beam`, `beam`, `exact`, `reference`,
    /// `picture`, `depth`.
    pub name: String,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Array layers (6 for a cube map).
    pub layers: u32,
    /// Mip levels.
    pub mips: u32,
    /// Format, as wgpu names it.
    pub format: String,
    /// Bytes of all mips and layers.
    pub bytes: u64,
}

impl TextureEntry {
    pub(super) fn of(name: &str, texture: &wgpu::Texture) -> Self {
        let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(4));
        let layers = texture.depth_or_array_layers();
        let mips = texture.mip_level_count();
        let texels =
            |mip: u32| u64::from((texture.width() >> mip).max(1)) * u64::from((texture.height() >> mip).max(1));
        Self {
            name: name.to_owned(),
            width: texture.width(),
            height: texture.height(),
            layers,
            mips,
            format: format!("{:?}", texture.format()),
            bytes: (0..mips).map(texels).sum::<u64>() * texel * u64::from(layers),
        }
    }
}
