//! The pictures of a camera path as files: a folder of PNGs, or one animated PNG. Written whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use image::RgbaImage;
use tempfile::{NamedTempFile, TempDir};

use crate::files;

/// Pictures per second that an animation may have.
pub const FRAMES_PER_SECOND: std::ops::RangeInclusive<u32> = 1..=240;

/// Why there is no animation. Nothing half-written is left behind.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    /// The ending says something else.
    #[error("{}: no such animation can be written\nAn animation is one file, an animated PNG (.png or .apng), or a folder of PNGs.\nName it {}, or leave the ending away.", .0.display(), .0.with_extension("png").display())]
    Ending(PathBuf),
    /// The folder is not empty.
    #[error("the folder {} is not empty\nThe pictures of an animation get a folder of their own, and nothing is overwritten.\nName a folder that does not exist yet.", .0.display())]
    NotEmpty(PathBuf),
    /// The system refuses.
    #[error("cannot write {}\nThe system says: {source}.\nName a folder that exists, that you may write to, and that has room.", path.display())]
    Io {
        /// What was to be written.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The encoder refuses.
    #[error("cannot encode the animation {}\nThe encoder says: {reason}.\nChoose a smaller size, or fewer pictures.", path.display())]
    Encode {
        /// What was to be written.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
}

/// What a path names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A folder with `frame-00001.png` and so on.
    Folder,
    /// One animated PNG, which plays for ever.
    Apng,
}

impl Kind {
    /// What `path` names by its ending: `.png` and `.apng` one file, none a folder.
    ///
    /// # Errors
    /// Another ending.
    pub fn of(path: &Path) -> Result<Self, AnimationError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            _ if path.is_dir() => Ok(Self::Folder),
            None => Ok(Self::Folder),
            Some("png" | "apng") => Ok(Self::Apng),
            Some(_) => Err(AnimationError::Ending(path.to_path_buf())),
        }
    }
}

/// Takes pictures one by one. Dropped before [`AnimationWriter::finish`], it leaves nothing.
pub struct AnimationWriter {
    path: PathBuf,
    size: [u32; 2],
    count: u32,
    written: u32,
    into: Into,
}

enum Into {
    Folder(TempDir),
    Apng(NamedTempFile, Box<png::Writer<BufWriter<File>>>),
}

impl AnimationWriter {
    /// An animation of `count` pictures of `size` pixels at `path`, `per_second` of them a second.
    ///
    /// # Errors
    /// [`AnimationError`]: `path` names neither, its folder cannot be written to, or it is a folder that is not empty.
    pub fn new(path: &Path, size: [u32; 2], count: u32, per_second: u32) -> Result<Self, AnimationError> {
        let io = |source| AnimationError::Io { path: path.to_path_buf(), source };
        let into = match Kind::of(path)? {
            Kind::Folder => {
                if fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some()) {
                    return Err(AnimationError::NotEmpty(path.to_path_buf()));
                }
                if path.is_file() {
                    return Err(io(io::ErrorKind::NotADirectory.into()));
                }
                Into::Folder(folder_beside(path).map_err(io)?)
            }
            Kind::Apng => {
                let file = files::temporary_beside(path).map_err(io)?;
                let writer = BufWriter::new(file.as_file().try_clone().map_err(io)?);
                let encoder = encoder(writer, size, count, per_second);
                let encode = |error: png::EncodingError| encoding(path, error);
                Into::Apng(file, Box::new(encoder.and_then(png::Encoder::write_header).map_err(encode)?))
            }
        };
        Ok(Self { path: path.to_path_buf(), size, count, written: 0, into })
    }

    /// Adds a picture; its alpha is ignored.
    ///
    /// # Errors
    /// It cannot be encoded or written, or has another size.
    pub fn push(&mut self, picture: &RgbaImage) -> Result<(), AnimationError> {
        let (width, height) = picture.dimensions();
        if [width, height] != self.size {
            let reason = format!("a picture has {width}×{height} pixels and not {}×{}", self.size[0], self.size[1]);
            return Err(AnimationError::Encode { path: self.path.clone(), reason });
        }
        let colours: Vec<u8> = picture.pixels().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        self.written += 1;
        let failed = |error| encoding(&self.path, error);
        match &mut self.into {
            Into::Folder(folder) => {
                let path = folder.path().join(format!("frame-{:05}.png", self.written));
                let io = |source| AnimationError::Io { path: self.path.clone(), source };
                let writer = BufWriter::new(File::create_new(&path).map_err(io)?);
                let mut encoder = plain(writer, self.size).write_header().map_err(failed)?;
                encoder.write_image_data(&colours).and_then(|()| encoder.finish()).map_err(failed)
            }
            Into::Apng(_, writer) => writer.write_image_data(&colours).map_err(failed),
        }
    }

    /// Puts the animation in its place.
    ///
    /// # Errors
    /// It cannot be written, or there are fewer pictures than were announced.
    pub fn finish(self) -> Result<PathBuf, AnimationError> {
        let io = |source| AnimationError::Io { path: self.path.clone(), source };
        if self.written != self.count {
            let reason = format!("{} pictures were announced, and {} came", self.count, self.written);
            return Err(AnimationError::Encode { path: self.path, reason });
        }
        match self.into {
            Into::Folder(folder) => {
                if self.path.is_dir() {
                    // Empty, or this fails and nothing is lost.
                    fs::remove_dir(&self.path).map_err(io)?;
                }
                fs::rename(folder.path(), &self.path).map_err(io)?;
                // What it would remove has moved away.
                let _ = folder.keep();
            }
            Into::Apng(file, writer) => {
                writer.finish().map_err(|error| encoding(&self.path, error))?;
                file.persist(&self.path).map_err(|failed| io(failed.error))?;
            }
        }
        Ok(self.path)
    }
}

fn plain<W: io::Write>(writer: W, [width, height]: [u32; 2]) -> png::Encoder<'static, W> {
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
}

fn encoder<W: io::Write>(
    writer: W,
    size: [u32; 2],
    count: u32,
    per_second: u32,
) -> Result<png::Encoder<'static, W>, png::EncodingError> {
    let mut encoder = plain(writer, size);
    // For ever.
    encoder.set_animated(count, 0)?;
    let denominator = u16::try_from(per_second.clamp(*FRAMES_PER_SECOND.start(), *FRAMES_PER_SECOND.end()));
    encoder.set_frame_delay(1, denominator.unwrap_or(30))?;
    Ok(encoder)
}

fn encoding(path: &Path, error: png::EncodingError) -> AnimationError {
    match error {
        png::EncodingError::IoError(source) => AnimationError::Io { path: path.to_path_buf(), source },
        other => AnimationError::Encode { path: path.to_path_buf(), reason: other.to_string() },
    }
}

/// A new folder beside `path`, removed on drop, with the mode of any new folder.
fn folder_beside(path: &Path) -> io::Result<TempDir> {
    let parent = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relief-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent).map_err(|error| io::Error::new(error.kind(), error.kind().to_string()))
}

#[cfg(test)]
mod tests {
    use image::Rgba;

    use super::*;

    fn pictures(count: u8) -> Vec<RgbaImage> {
        (0..count).map(|level| RgbaImage::from_fn(7, 5, |x, y| Rgba([level * 60, x as u8 * 9, y as u8, 255]))).collect()
    }

    fn entries(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn write(path: &Path, pictures: &[RgbaImage]) -> Result<PathBuf, AnimationError> {
        let mut writer = AnimationWriter::new(path, [7, 5], pictures.len() as u32, 25)?;
        pictures.iter().try_for_each(|picture| writer.push(picture))?;
        writer.finish()
    }

    #[test]
    fn both_kinds_hold_every_picture_and_the_same_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let (frames, [sequence, first, second]) =
            (pictures(4), ["out", "a.png", "b.apng"].map(|name| folder.path().join(name)));
        for path in [&sequence, &first, &second] {
            write(path, &frames).unwrap();
        }
        assert_eq!(entries(&sequence), ["frame-00001.png", "frame-00002.png", "frame-00003.png", "frame-00004.png"]);
        for (name, frame) in entries(&sequence).iter().zip(&frames) {
            assert_eq!(image::open(sequence.join(name)).unwrap().to_rgba8(), *frame);
        }
        assert_eq!(fs::read(&first).unwrap(), fs::read(&second).unwrap());
        // A reader that is not our writer.
        use image::AnimationDecoder;
        let decoder = image::codecs::png::PngDecoder::new(io::BufReader::new(File::open(&first).unwrap())).unwrap();
        let read: Vec<_> = decoder.apng().unwrap().into_frames().map(|frame| frame.unwrap()).collect();
        assert_eq!(read.len(), 4);
        for (frame, wanted) in read.iter().zip(&frames) {
            assert_eq!((frame.buffer(), frame.delay().numer_denom_ms()), (wanted, (40, 1)));
        }
        assert_eq!(entries(folder.path()), ["a.png", "b.apng", "out"], "and nothing else");
    }

    #[test]
    fn what_is_given_up_or_refused_leaves_nothing_and_overwrites_no_folder() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["out", "a.png"] {
            let mut writer = AnimationWriter::new(&folder.path().join(name), [7, 5], 3, 25).unwrap();
            writer.push(&pictures(1)[0]).unwrap();
            assert!(writer.push(&RgbaImage::new(3, 3)).is_err(), "another size");
            drop(writer);
        }
        let mut early = AnimationWriter::new(&folder.path().join("a.png"), [7, 5], 3, 25).unwrap();
        early.push(&pictures(1)[0]).unwrap();
        assert!(early.finish().is_err(), "fewer than announced");
        assert!(entries(folder.path()).is_empty(), "{:?}", entries(folder.path()));
        let full = folder.path().join("full");
        fs::create_dir(&full).unwrap();
        write(&full, &pictures(1)).unwrap();
        assert!(matches!(write(&full, &pictures(2)), Err(AnimationError::NotEmpty(_))));
        assert_eq!(entries(&full).len(), 1);
        assert!(matches!(write(&folder.path().join("a.mp4"), &pictures(1)), Err(AnimationError::Ending(_))));
        assert!(write(&folder.path().join("none/a.png"), &pictures(1)).is_err());
    }
}
