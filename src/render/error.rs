//! Why no frame was drawn.

use std::path::PathBuf;

use crate::gpu::{ReadbackError, ShaderError};

/// Why no frame was drawn. Whatever was on the screen stays.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A shader did not compose or compile.
    #[error("a shader does not compile\n  {0}\n  correct it; a viewer that has drawn before keeps its last good one")]
    Shader(#[from] ShaderError),
    /// A number of the scene is outside its range.
    #[error("the scene cannot be drawn\n  {0}\n  correct the value")]
    Scene(#[from] crate::scene_file::OutOfRange),
    /// The map is larger than the adapter's textures.
    #[error(
        "the map has {width}×{height} samples, but this adapter's textures end at {limit}×{limit}\n  \
         reduce the map's resolution, or use an adapter with a higher limit"
    )]
    TerrainTooLarge {
        /// Columns of the map.
        width: u32,
        /// Rows of the map.
        height: u32,
        /// The adapter's limit.
        limit: u32,
    },
    /// The adapter has no memory for the map.
    #[error(
        "the adapter has no memory for the map's {width}×{height} samples: they take {} MiB\n  {reason}\n  \
         reduce the map's resolution, or close other programs that use the GPU",
        bytes.div_ceil(1 << 20)
    )]
    OutOfMemory {
        /// Columns of the map.
        width: u32,
        /// Rows of the map.
        height: u32,
        /// Bytes of the heights and their pyramid.
        bytes: u64,
        /// What the driver said.
        reason: String,
    },
    /// An image that the scene names (diffuse texture, skybox face) cannot be used.
    #[error("cannot use the image {}\n  {reason}\n  choose a PNG, JPEG or WebP file that fits", path.display())]
    Image {
        /// The image's file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The scene asks for something that this adapter lacks.
    #[error("{what} is not available: it needs {needs}, which this adapter has not\n  {instead}")]
    Unsupported {
        /// What was asked for.
        what: &'static str,
        /// What it requires.
        needs: &'static str,
        /// What to do instead.
        instead: &'static str,
    },
    /// The scene asks for something that this map cannot give.
    #[error("{what} cannot be drawn\n  {why}\n  {instead}")]
    Impossible {
        /// What was asked for.
        what: &'static str,
        /// Why it cannot be.
        why: &'static str,
        /// What to do instead.
        instead: &'static str,
    },
    /// The distances given for a picture are not one per pixel.
    #[error(
        "there are {given} distances for a picture of {width}×{height} pixels\n  \
         each pixel needs one, row 0 at the top: {} in all\n  \
         measure them at the size of the picture", u64::from(*width) * u64::from(*height)
    )]
    Distances {
        /// Distances that were given.
        given: usize,
        /// Width of the picture.
        width: u32,
        /// Height of the picture.
        height: u32,
    },
    /// The driver refused an allocation or a command.
    #[error(
        "the GPU's driver refused to work\n  {0}\n  try a smaller window or picture, or another adapter (RELIEF_ADAPTER=NAME)"
    )]
    Driver(String),
    /// The device was lost.
    #[error(
        "the GPU device was lost: {0}\n  the driver reset or removed it; start again, and update the driver if it happens often"
    )]
    DeviceLost(String),
    /// Nothing could be read back.
    #[error(transparent)]
    Readback(#[from] ReadbackError),
}
