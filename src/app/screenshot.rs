//! Screenshots: the picture as PNG, and beside it the scene as TOML, so that the picture can be made again.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ImageError, RgbaImage};

use crate::files;
use crate::scene::Scene;
use crate::scene_file::{self, SceneFileError};

/// Highest number in a file name before the search for a free one gives up.
const LAST_NUMBER: u32 = 9999;

/// Why there is no screenshot. Nothing half-written is left behind.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ScreenshotError {
    /// The folder cannot be made or written to.
    #[error(
        "cannot write a screenshot to {folder}: {source}. Free some space, or start in a folder that can be written to."
    )]
    Folder { folder: PathBuf, source: io::Error },
    /// All names are taken.
    #[error("cannot write a screenshot to {0}: it already has {LAST_NUMBER}. Move some of them away.")]
    Full(PathBuf),
    /// The picture was not encoded.
    #[error("cannot write the screenshot as PNG: {0}")]
    Png(#[from] ImageError),
    /// The scene was not encoded.
    #[error("cannot write the screenshot's scene: {0}")]
    Toml(#[from] SceneFileError),
}

/// Writes `picture` and `scene` to `folder` as `relief-0001.png` and `.toml`, or the next free number, and returns the
/// picture's path. Both files are written, or neither.
pub(crate) fn save(folder: &Path, picture: &RgbaImage, scene: &Scene) -> Result<PathBuf, ScreenshotError> {
    let failed = |source| ScreenshotError::Folder { folder: folder.into(), source };
    std::fs::create_dir_all(folder).map_err(failed)?;
    let (width, height) = picture.dimensions();
    let text = format!(
        "# Makes the picture beside it again: relief render --scene FILE --size {width}x{height} -o OUT.png\n\n{}",
        scene_file::to_toml(scene)?
    );
    let mut toml = files::temporary_beside(&folder.join("relief")).map_err(failed)?;
    toml.write_all(text.as_bytes()).map_err(failed)?;
    let mut png = files::temporary_beside(&folder.join("relief")).map_err(failed)?;
    {
        let mut writer = BufWriter::new(&mut png);
        picture.write_with_encoder(PngEncoder::new(&mut writer))?;
        writer.flush().map_err(failed)?;
    }
    for number in 1..=LAST_NUMBER {
        let [toml_path, png_path] = ["toml", "png"].map(|ending| folder.join(format!("relief-{number:04}.{ending}")));
        if png_path.exists() {
            continue;
        }
        match toml.persist_noclobber(&toml_path) {
            Ok(_) => {}
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {
                toml = error.file;
                continue;
            }
            Err(error) => return Err(failed(error.error)),
        }
        return match png.persist_noclobber(&png_path) {
            Ok(_) => Ok(png_path),
            Err(error) => {
                // The scene alone would be half a screenshot. What went wrong is already being told.
                let _ = std::fs::remove_file(&toml_path);
                Err(failed(error.error))
            }
        };
    }
    Err(ScreenshotError::Full(folder.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::heightfield::Crater;
    use crate::scene::{SkyboxSettings, Technique};

    #[test]
    fn the_scene_beside_the_picture_makes_it_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = Scene::default();
        scene.terrain.file = Some("maps/canyon.png".into());
        scene.terrain.height_scale = Some(0.1234567890123);
        scene.camera =
            Some(Camera { eye: glam::DVec3::new(0.1, 1.0 / 3.0, -2e-7), yaw: 12.5, pitch: -33.0, fov: 47.0 });
        scene.march.technique = Technique::LinearBinary;
        scene.craters.list.push(Crater { x: 0.1, z: 0.7, radius: 0.03, depth: 0.3, rim: 0.1 });
        scene.occluder.position = Some(glam::DVec3::new(0.5, 0.2, 0.5));
        scene.skybox = SkyboxSettings {
            faces: Some(["a", "b", "c", "d", "e", "f"].map(PathBuf::from)),
            ..SkyboxSettings::default()
        };
        let picture = RgbaImage::from_fn(5, 3, |x, y| image::Rgba([x as u8, y as u8, 7, 255]));

        let paths: Vec<PathBuf> = (0..2).map(|_| save(folder.path(), &picture, &scene).expect("saved")).collect();
        assert_eq!(paths[0].file_name().expect("a name"), "relief-0001.png");
        assert_eq!(paths[1].file_name().expect("a name"), "relief-0002.png", "nothing is overwritten");
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 4);

        assert_eq!(image::open(&paths[0]).expect("a picture").to_rgba8(), picture);
        let text = std::fs::read_to_string(paths[0].with_extension("toml")).expect("a scene");
        let read: Scene = toml::from_str(&text).expect("a valid scene");
        assert_eq!((read.camera, &read.march, &read.craters), (scene.camera, &scene.march, &scene.craters));
        assert!(read.terrain.file.is_some_and(|file| file.is_absolute()));
    }

    #[test]
    fn a_folder_that_cannot_be_written_leaves_nothing_and_says_so() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a file");
        std::fs::write(&file, "in the way").expect("written");
        let error = save(&file, &RgbaImage::new(1, 1), &Scene::default()).expect_err("a file is no folder");
        assert!(error.to_string().contains("a file"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }
}
