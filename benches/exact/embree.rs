//! The peer: Embree in a process of its own (`benches/peers/embree.cpp`), asked for a frame at a time.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use glam::DVec3;
use relief::camera::Camera;
use relief::heightfield::HeightField;

/// A running peer with its scene built.
pub(super) struct Embree {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    description: String,
}

impl Embree {
    /// Compiles the peer and lets it build its scene of `map`; or why that cannot be.
    pub(super) fn start(map: &HeightField) -> Result<Self, String> {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/embree.cpp");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let program = folder.join("embree-peer");
        let compiled = Command::new("c++")
            .args(["-O3", "-march=native"])
            .arg(source)
            .arg("-o")
            .arg(&program)
            .args(["-lembree3", "-lpthread"])
            .stderr(Stdio::null())
            .status();
        if !compiled.is_ok_and(|status| status.success()) {
            return Err("Embree 3 or a C++ compiler is missing (Debian: apt-get install g++ libembree-dev)".into());
        }
        let heights = folder.join("heights.r32");
        std::fs::write(&heights, bytemuck::cast_slice(map.samples())).map_err(|error| error.to_string())?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let mut child = Command::new(&program)
            .arg(&heights)
            .args([map.width().to_string(), map.height().to_string(), map.box_size(None).y.to_string()])
            .arg(threads.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| error.to_string())?;
        let input = child.stdin.take();
        let output = BufReader::new(child.stdout.take().ok_or("the peer has no output")?);
        let mut peer = Self { child, input, output, description: String::new() };
        let ready = peer.line();
        std::fs::remove_file(&heights).map_err(|error| error.to_string())?;
        let words: Vec<_> = ready.split_whitespace().collect();
        let ["ready", build, version] = words[..] else { return Err(format!("the peer said: {ready}")) };
        let build: f64 = build.parse().map_err(|_| ready.clone())?;
        peer.description = format!(
            "Embree {version}, one grid, robust, coherent packets of 16, {threads} threads, built in {build:.0} ms"
        );
        Ok(peer)
    }

    pub(super) fn description(&self) -> &str {
        &self.description
    }

    /// The rays of the next frames.
    pub(super) fn look(&mut self, camera: &Camera, size: [u32; 2]) {
        let corner = camera.ray(0.0, 0.0, size);
        let right = camera.ray(1.0, 0.0, size).direction - corner.direction;
        let down = camera.ray(0.0, 1.0, size).direction - corner.direction;
        let words = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
        let vectors = [corner.origin, right, down, corner.direction].map(words).join(" ");
        self.ask(&format!("view {vectors} {} {}", size[0], size[1]));
    }

    /// Casts all rays: milliseconds, and how many hit.
    pub(super) fn frame(&mut self) -> (f64, usize) {
        self.ask("frame");
        let answer = self.line();
        let mut words = answer.split_whitespace();
        let mut word = || words.next().unwrap();
        (word().parse().unwrap(), word().parse().unwrap())
    }

    fn ask(&mut self, line: &str) {
        writeln!(self.input.as_mut().unwrap(), "{line}").unwrap();
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        line
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // The end of its input ends it.
        self.input = None;
        let _ = self.child.wait();
    }
}
