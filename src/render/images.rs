//! Images that a scene names: read by the frame that first needs them, or away from it, beside the pipelines
//! ([`Compilation`](super::compile::Compilation)), so that no frame waits for a decoder.

use std::collections::HashMap;
use std::path::PathBuf;

use crate::heightfield::import::imagery;
use crate::scene::{DebugView, Scene};

use super::mips::{self, Image};
use super::terrain::TerrainKey;
use super::{RenderError, Renderer};

/// What an image is read for, which decides how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Purpose {
    /// Colours of the ground, repeated over it.
    Colours,
    /// A picture of the land, placed on it: a GeoTIFF, too.
    Imagery,
    /// A coverage map, whose channels are weights.
    Weights,
    /// A face of the sky.
    Face,
}

/// An image that a scene needs.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct ImageFile {
    pub(super) path: PathBuf,
    pub(super) purpose: Purpose,
}

/// An image with its smaller copies, where its purpose has such.
#[derive(Debug)]
pub(super) struct Decoded {
    pub(super) image: Image,
    pub(super) levels: Vec<Image>,
}

impl ImageFile {
    fn new(path: &std::path::Path, purpose: Purpose) -> Self {
        Self { path: path.to_owned(), purpose }
    }

    /// Reads it; textures end at `largest` texels a side.
    ///
    /// # Errors
    /// What is wrong with the file, for people.
    pub(super) fn read(&self, largest: u32) -> Result<Decoded, String> {
        let path = &self.path;
        let (image, levels) = match self.purpose {
            Purpose::Weights => (Image::read_weights(path, largest)?, Vec::new()),
            Purpose::Face => (Image::read(path, largest)?, Vec::new()),
            Purpose::Colours => {
                let image = Image::read(path, largest)?;
                let levels = mips::chain(&image);
                (image, levels)
            }
            Purpose::Imagery => {
                let image = if imagery::is_tiff(path) {
                    let picture = imagery::read_tiff(path, largest)?;
                    Image { width: picture.width, height: picture.height, rgba: picture.rgba }
                } else {
                    Image::read(path, largest)?
                };
                let levels = mips::translucent_chain(&image);
                (image, levels)
            }
        };
        Ok(Decoded { image, levels })
    }
}

/// Images that were read before the frame that needs them, or what is wrong with them.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// With how many pictures were drawn since.
    ready: HashMap<ImageFile, (Result<Decoded, String>, u32)>,
}

/// Pictures after which an image that none of them has taken is dropped. Not the first: a film and a measurement draw pictures
/// of their own in between.
const PATIENCE: u32 = 32;

impl Images {
    /// Takes an image, or reads it where nobody has.
    ///
    /// # Errors
    /// [`RenderError::Image`].
    pub(super) fn take(
        &mut self,
        path: &std::path::Path,
        purpose: Purpose,
        largest: u32,
    ) -> Result<Decoded, RenderError> {
        let file = ImageFile::new(path, purpose);
        let read = self.ready.remove(&file).map_or_else(|| file.read(largest), |(read, _)| read);
        read.map_err(|reason| RenderError::Image { path: file.path, reason })
    }

    /// Keeps what was read elsewhere.
    pub(super) fn keep(&mut self, read: impl IntoIterator<Item = (ImageFile, Result<Decoded, String>)>) {
        self.ready.extend(read.into_iter().map(|(file, image)| (file, (image, 0))));
    }

    /// A picture is drawn: drops what none has taken for long.
    pub(super) fn age(&mut self) {
        self.ready.retain(|_, (_, pictures)| {
            *pictures += 1;
            *pictures < PATIENCE
        });
    }
}

impl Renderer {
    /// The images that a picture of `scene` with these terrains needs, and that are neither on the GPU nor read.
    pub(super) fn missing_images(&self, scene: &Scene, terrains: &[TerrainKey]) -> Vec<ImageFile> {
        let mut files = Vec::new();
        let any = |reads: &dyn Fn(&TerrainKey) -> bool| terrains.iter().any(reads);
        if let Some(path) = &scene.diffuse.file
            && any(&|key| key.diffuse)
            && self.drape.as_ref().is_some_and(|drape| !drape.shows(Some(path)))
        {
            files.push(ImageFile::new(path, Purpose::Colours));
        }
        if let Some(path) = &scene.land.imagery
            && any(&|key| key.land.imagery)
            && !self.land.shows(path)
        {
            files.push(ImageFile::new(path, Purpose::Imagery));
        }
        if any(&|key| key.materials.on)
            && self.materials.as_ref().is_none_or(|materials| !materials.covers(&scene.materials.coverage))
        {
            files.extend(scene.materials.coverage.iter().map(|path| ImageFile::new(path, Purpose::Weights)));
        }
        if let Some(faces) = &scene.skybox.faces
            && scene.skybox.enabled
            && scene.debug.view != DebugView::Error
            && !self.skybox.as_ref().is_some_and(|skybox| skybox.matches(scene))
        {
            files.extend(faces.iter().map(|path| ImageFile::new(path, Purpose::Face)));
        }
        files.retain(|file| !self.images.ready.contains_key(file));
        files
    }
}
