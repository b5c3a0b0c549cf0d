//! Coverage maps: images whose channels weigh the materials.

use std::path::{Path, PathBuf};

use super::super::RenderError;
use super::super::images::{Images, Purpose};
use super::super::mips::Image;

/// A set of coverage maps of one size, without the sRGB curve: their bytes are weights.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    pub(super) size: [u32; 2],
    /// Each map's mips, finest first; four bytes to a texel.
    pub(super) layers: Vec<Vec<Vec<u8>>>,
}

impl Coverage {
    /// Reads the images of a set. A channel that an image does not have weighs nothing.
    ///
    /// # Errors
    /// [`RenderError::Image`] for the first file that is missing or no image, and for one whose size differs from the
    /// first one's.
    pub(super) fn read(paths: &[PathBuf], largest: u32, images: &mut Images) -> Result<Self, RenderError> {
        let fail = |path: &Path, reason: String| RenderError::Image { path: path.to_path_buf(), reason };
        let (mut size, mut layers) = ([1, 1], Vec::new());
        for (index, path) in paths.iter().enumerate() {
            let image = images.take(path, Purpose::Weights, largest)?.image;
            let own = [image.width, image.height];
            if index == 0 {
                size = own;
            } else if own != size {
                let [[w, h], [first_w, first_h]] = [own, size];
                return Err(fail(
                    path,
                    format!(
                        "it has {w}×{h} pixels, but the first coverage map of the set, {}, has {first_w}×{first_h}; all of a \
                         set have the same size",
                        paths.first().map_or_else(String::new, |first| first.display().to_string())
                    ),
                ));
            }
            layers.push(chain(image));
        }
        Ok(Self { size, layers })
    }

    /// Levels of each layer.
    pub(super) fn levels(&self) -> u32 {
        self.layers.first().map_or(1, |levels| levels.len() as u32)
    }
}

/// An image's bytes and those of its mips, each the mean of 2×2 texels; sides are halved and rounded down.
fn chain(image: Image) -> Vec<Vec<u8>> {
    let (mut width, mut height) = (image.width as usize, image.height as usize);
    let mut levels = vec![image.rgba];
    while width > 1 || height > 1 {
        let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
        let finer = levels.last().map_or(&[][..], Vec::as_slice);
        let mut level = vec![0u8; half_width * half_height * 4];
        for (index, texel) in level.chunks_exact_mut(4).enumerate() {
            let (x, y) = (2 * (index % half_width), 2 * (index / half_width));
            let at = |i: usize, j: usize| ((y + j).min(height - 1) * width + (x + i).min(width - 1)) * 4;
            for (channel, value) in texel.iter_mut().enumerate() {
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)].map(|first| u32::from(finer[first + channel]));
                *value = ((four.iter().sum::<u32>() + 2) / 4) as u8;
            }
        }
        levels.push(level);
        (width, height) = (half_width, half_height);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mips_of_weights_are_their_means() {
        let rgba = [[0, 255, 10, 0], [100, 255, 10, 0], [50, 255, 10, 4], [50, 255, 10, 0]].concat();
        let levels = chain(Image { width: 2, height: 2, rgba });
        assert_eq!(levels[1], [50, 255, 10, 1]);
        let odd = chain(Image { width: 5, height: 3, rgba: vec![7; 60] });
        assert_eq!(odd.iter().map(|level| level.len() / 4).collect::<Vec<_>>(), [15, 2, 1]);
        assert!(odd.iter().flatten().all(|&value| value == 7));
    }

    #[test]
    fn what_is_wrong_with_a_set_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str, size: u32| {
            let path = folder.path().join(name);
            image::RgbaImage::from_pixel(size, size, image::Rgba([1, 2, 3, 4])).save(&path).unwrap();
            path
        };
        let (first, second) = (save("a.png", 8), save("b.png", 9));
        let message = |paths: &[PathBuf]| Coverage::read(paths, 64, &mut Images::default()).unwrap_err().to_string();
        let missing = message(&[folder.path().join("none.png")]);
        assert!(missing.contains("none.png") && missing.contains("No such file"), "{missing}");
        let differs = message(&[first.clone(), second]);
        assert!(differs.contains("b.png") && differs.contains("9×9") && differs.contains("8×8"), "{differs}");
        assert_eq!(Coverage::read(&[first.clone(), first], 64, &mut Images::default()).unwrap().layers.len(), 2);
        let opaque = folder.path().join("rgb.png");
        image::RgbImage::from_pixel(2, 2, image::Rgb([9, 8, 7])).save(&opaque).unwrap();
        let coverage = Coverage::read(&[opaque], 64, &mut Images::default()).unwrap();
        assert_eq!(coverage.layers[0][0][..4], [9, 8, 7, 0], "no alpha is no snow");
    }
}
