//! The bytes that are decoded: a file or memory, with progress, cancel, and the faults that decoding can end in.

use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::Listener;

/// What keeps a file from being decoded. The file's name and format are added outside.
#[derive(Debug)]
pub(in crate::heightfield) enum Fault {
    /// It ends before its samples do.
    Truncated,
    /// It announces more samples than its length can hold.
    Promises([u64; 2]),
    /// Broken inside, in these words.
    Damaged(String),
    /// What it holds is known, but not supported; and what to do about it.
    Unsupported(String, &'static str),
    /// Something has to be said by hand: why, and what.
    Unclear(String, String),
    /// More samples than can be read at once.
    TooLarge([u64; 2]),
    /// More samples a side than the caller wants.
    Beyond([u32; 2]),
    /// No cell.
    TooSmall([u64; 2]),
    /// No sample holds a height.
    AllHoles([u32; 2]),
    /// The system's.
    Io(io::Error),
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Truncated } else { Self::Io(error) }
    }
}

impl Fault {
    /// Damaged in the words of a decoder, which may have several lines.
    pub(super) fn damaged(error: impl std::fmt::Display) -> Self {
        Self::Damaged(one_line(&error.to_string()))
    }
}

/// A decoder's message on one line, without control characters, and not endless.
pub(super) fn one_line(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.chars().filter(|c| !c.is_control()).take(300).collect()
}

/// What can be read and sought in.
pub(in crate::heightfield) trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

/// The bytes of one file.
pub(in crate::heightfield) struct Source<'a> {
    /// Reads from where the last read ended.
    pub(super) reader: BufReader<Counting<'a>>,
    /// How many bytes there are.
    pub(super) bytes: u64,
    /// The file's path, for companions and what its name says.
    pub(super) path: &'a Path,
    /// The first bytes, at most [`HEAD_BYTES`].
    pub(in crate::heightfield) head: Vec<u8>,
    /// Whether companions may lie beside it.
    pub(super) on_disk: bool,
}

/// How many of the first bytes are looked at to tell the format.
pub(super) const HEAD_BYTES: usize = 1024;

impl<'a> Source<'a> {
    /// The source over `inner`, which stands at its beginning.
    pub(in crate::heightfield) fn new(
        inner: Box<dyn ReadSeek + Send + 'a>,
        bytes: u64,
        path: &'a Path,
        on_disk: bool,
        listener: Listener<'a>,
    ) -> io::Result<Self> {
        let mut reader = BufReader::with_capacity(1 << 17, Counting { inner, read: 0, bytes, listener });
        let mut head = Vec::with_capacity(HEAD_BYTES);
        reader.by_ref().take(HEAD_BYTES as u64).read_to_end(&mut head)?;
        reader.rewind()?;
        Ok(Self { reader, bytes, path, head, on_disk })
    }

    /// Goes to a byte of the file.
    pub(super) fn seek(&mut self, to: u64) -> Result<(), Fault> {
        // Seeking relatively keeps what is already in the buffer.
        let here = self.reader.stream_position()?;
        match to.checked_sub(here).map(i64::try_from) {
            Some(Ok(by)) => self.reader.seek_relative(by)?,
            _ => {
                self.reader.seek(SeekFrom::Start(to))?;
            }
        }
        Ok(())
    }

    /// Reads exactly so many bytes, which the caller has checked to be fewer than the file's.
    pub(super) fn take(&mut self, count: usize) -> Result<Vec<u8>, Fault> {
        if count as u64 > self.bytes {
            return Err(Fault::Truncated);
        }
        let mut bytes = vec![0; count];
        self.reader.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// The text of a companion with this ending, in lower or upper case. At most 64 KiB: a longer one is none.
    pub(super) fn companion(&self, ending: &str) -> Option<String> {
        if !self.on_disk {
            return None;
        }
        [ending.to_lowercase(), ending.to_uppercase()].iter().find_map(|ending| {
            let path = self.path.with_extension(ending);
            let bytes = std::fs::metadata(&path).ok().filter(|found| found.is_file() && found.len() <= 1 << 16)?.len();
            let mut text = Vec::with_capacity(bytes as usize);
            std::fs::File::open(&path).ok()?.take(1 << 16).read_to_end(&mut text).ok()?;
            Some(String::from_utf8_lossy(&text).into_owned())
        })
    }
}

/// A file that tells how much of it has been read, and stops when that is no longer wanted.
pub(in crate::heightfield) struct Counting<'a> {
    inner: Box<dyn ReadSeek + Send + 'a>,
    read: u64,
    bytes: u64,
    listener: Listener<'a>,
}

impl Read for Counting<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.listener.is_cancelled() {
            return Err(io::Error::other("cancelled"));
        }
        let count = self.inner.read(buffer)?;
        self.read += count as u64;
        (self.listener.progress)((self.read as f64 / self.bytes.max(1) as f64).min(1.0) as f32);
        Ok(count)
    }
}

impl Seek for Counting<'_> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.inner.seek(position)
    }
}
