//! The binary in a folder of its own, and what a run left behind.

use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use image::{ImageBuffer, Luma};
use tempfile::TempDir;

/// What a run left behind.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    /// Fails unless the run ended with `code` and stderr has every one of `words`.
    #[track_caller]
    pub(crate) fn expect(&self, code: i32, words: &[&str]) -> &Self {
        assert_eq!(self.code, code, "stderr: {}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "`{word}` is missing in: {}", self.stderr);
        }
        self
    }

    /// Fails unless the message has its three parts: what, and below it, indented, why and what to do.
    #[track_caller]
    pub(crate) fn says_what_why_and_what_to_do(&self) {
        let mut lines = self.stderr.lines().skip_while(|line| !line.starts_with("relief: error: "));
        assert!(lines.next().is_some(), "no error: {}", self.stderr);
        let indented: Vec<&str> = lines.collect();
        assert!(indented.len() >= 2, "what, why and what to do: {}", self.stderr);
        assert!(indented.iter().all(|line| line.starts_with("  ") && line.len() > 6), "indented: {}", self.stderr);
    }
}

/// A folder of its own for each test.
pub(crate) struct Bench(TempDir);

impl Bench {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), bytes).unwrap();
    }

    /// A map with some relief.
    pub(crate) fn map(&self, name: &str, width: u32, height: u32) {
        let height_at = |x: u32, z: u32| Luma([(x * 977 + z * 3571 + (x * z) % 97 * 500) as u16]);
        ImageBuffer::from_fn(width, height, height_at).save(self.path(name)).unwrap();
    }

    /// The names of the files here, sorted; also those that begin with a dot.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub(crate) fn command<S: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relief"));
        command.current_dir(self.0.path()).args(arguments);
        for display in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(display);
        }
        if std::env::var_os("RELIEF_ADAPTER").is_none() {
            command.env("RELIEF_ADAPTER", "cpu");
        }
        // Without this folder, which a bare container lacks, the Wayland library that Mesa loads complains on stderr.
        if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
            command.env("XDG_RUNTIME_DIR", self.0.path());
        }
        command
    }

    /// Runs `relief` with the words of `line`.
    pub(crate) fn relief(&self, line: &str) -> Run {
        run(&mut self.command(line.split_whitespace()))
    }
}

pub(crate) fn run(command: &mut Command) -> Run {
    let output = command.output().unwrap();
    Run {
        code: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

pub(crate) fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

pub(crate) fn keys(value: &serde_json::Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}
