//! The viewer's state as a JSON file, for automated tests and remote control: what is drawn, what it cost, and where
//! on the window every widget is.

use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::accesskit::{Action, Affine, Node, NodeId, Role, Toggled, TreeUpdate};
use serde::Serialize;

use super::graphics::Graphics;
use super::preferences::Mode;
use super::reading::ReadingStatus;
use super::redraw::Next;
use super::viewer::Viewer;
use crate::render::Ledger;
use crate::scene::{Scene, Technique};

/// Least time between two writes, unless the newer state is the last.
pub(crate) const INTERVAL: Duration = Duration::from_millis(50);

/// The file's content.
#[derive(Debug, Serialize)]
pub(crate) struct Status<'a> {
    /// Frames shown.
    pub(crate) frame: u64,
    /// Frames in which the scene was drawn anew.
    pub(crate) scene_frames: u64,
    /// Nothing changes and nothing is being waited for.
    pub(crate) idle: bool,
    /// Physical pixels per point of the window system.
    pub(crate) scale_factor: f64,
    /// The window's inside in physical pixels.
    pub(crate) size: [u32; 2],
    /// The mouse looks around and its cursor is hidden.
    pub(crate) mouse_captured: bool,
    /// The panel shows.
    pub(crate) panel: bool,
    /// The help shows.
    pub(crate) help: bool,
    /// The overlay shows.
    pub(crate) overlay: bool,
    /// The window fills the screen.
    pub(crate) full_screen: bool,
    /// Base speed in map widths per second.
    pub(crate) speed: f64,
    /// What drags and the wheel do.
    pub(crate) mode: Mode,
    /// The interface is dark.
    pub(crate) dark: bool,
    /// The user's zoom of panel and text.
    pub(crate) zoom: f32,
    /// The log shows.
    pub(crate) log: bool,
    /// Something of egui has the keyboard.
    pub(crate) typing: bool,
    /// An action waits for its new key.
    pub(crate) choosing_key: bool,
    /// The eye goes by itself.
    pub(crate) under_way: bool,
    /// Key frames of the camera path.
    pub(crate) key_frames: usize,
    /// Pictures of the path are being written.
    pub(crate) filming: bool,
    /// Everything the picture depends on, the camera included.
    pub(crate) scene: &'a Scene,
    /// What the last frame cost.
    pub(crate) ledger: &'a Ledger,
    /// GPU times of the last frames.
    pub(crate) frame_ms: Times,
    /// The error view is compared with the f64 reference, and not with the exact technique.
    pub(crate) reference: bool,
    /// The technique that drew the picture: not the scene's own while its cones are being found.
    pub(crate) drawn_by: Option<Technique>,
    /// What is read off the land.
    pub(crate) reading: ReadingStatus,
    /// The share of a map of cones that is found, 0 to 1, while one is being sought.
    pub(crate) finding_cones: Option<f32>,
    /// Pipelines are being compiled.
    pub(crate) compiling: bool,
    /// Error against time of the techniques: how many settings were measured.
    pub(crate) tradeoff: usize,
    /// Steps per ray: mean and maximum, where they are measured.
    pub(crate) steps: Option<(f64, u32)>,
    /// The line at the bottom of the last frame's picture: the hint, or what is being waited for.
    pub(crate) says: Option<&'a str>,
    /// The line of text over the picture, while it shows.
    pub(crate) hint: Option<&'a str>,
    /// The last messages, oldest first.
    pub(crate) toasts: Vec<&'a str>,
    /// The widgets on screen.
    pub(crate) widgets: &'a [Widget],
}

/// Milliseconds; absent before the first frame.
#[derive(Debug, Serialize)]
pub(crate) struct Times {
    pub(crate) median: Option<f64>,
    pub(crate) p99: Option<f64>,
}

/// A widget, as a screen reader finds it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Widget {
    /// Its name.
    pub(crate) label: String,
    /// Its role in AccessKit's words, such as `CheckBox`.
    pub(crate) role: String,
    /// Whether it is checked, for those that can be.
    pub(crate) toggled: Option<bool>,
    /// Whether its section is open, for those that have one.
    pub(crate) expanded: Option<bool>,
    /// Its value, as text.
    pub(crate) value: Option<String>,
    /// Left, top, right and bottom in physical pixels of the window. Outside the window where it is scrolled away.
    pub(crate) rect: [f64; 4],
    /// It reacts to nothing.
    pub(crate) disabled: bool,
}

/// The interactive widgets of an accessibility tree, from top to bottom.
pub(crate) fn widgets(update: &TreeUpdate) -> Vec<Widget> {
    let find = |id: NodeId| update.nodes.iter().find(|(other, _)| *other == id).map(|(_, node)| node);
    let root = update.tree.as_ref().and_then(|tree| find(tree.root));
    let to_pixels = root.and_then(Node::transform).copied().unwrap_or(Affine::IDENTITY);
    let describe = |node: &Node| {
        let bounds = to_pixels.transform_rect_bbox(node.bounds()?);
        let named_by = || {
            let names = node
                .labelled_by()
                .iter()
                .filter_map(|id| find(*id))
                .filter_map(|label| label.value().or(label.label()));
            names.collect::<Vec<_>>().join(" ")
        };
        Some(Widget {
            label: node.label().map_or_else(named_by, str::to_owned),
            role: format!("{:?}", node.role()),
            toggled: node.toggled().map(|toggled| toggled == Toggled::True),
            expanded: node.is_expanded(),
            value: node.value().map(str::to_owned).or_else(|| node.numeric_value().map(|value| value.to_string())),
            rect: [bounds.x0, bounds.y0, bounds.x1, bounds.y1],
            disabled: node.is_disabled(),
        })
    };
    let interactive = update.nodes.iter().filter(|(_, node)| is_interactive(node));
    let mut widgets: Vec<Widget> = interactive.filter_map(|(_, node)| describe(node)).collect();
    widgets.sort_by(|a, b| a.rect[1].total_cmp(&b.rect[1]).then(a.rect[0].total_cmp(&b.rect[0])));
    widgets
}

/// Whether a user can do something with the node itself.
fn is_interactive(node: &Node) -> bool {
    let by_role = matches!(
        node.role(),
        Role::Button
            | Role::CheckBox
            | Role::ComboBox
            | Role::DisclosureTriangle
            | Role::RadioButton
            | Role::Slider
            | Role::SpinButton
            | Role::TextInput
    );
    by_role || (node.supports_action(Action::Click) && node.supports_action(Action::Focus))
}

/// Writes states to a file, not too often.
#[derive(Debug)]
pub(crate) struct StatusFile {
    path: PathBuf,
    written: Option<Instant>,
}

impl StatusFile {
    /// A file that is written with the first state.
    pub(crate) fn new(path: PathBuf) -> Self {
        Self { path, written: None }
    }

    /// The earliest moment for the next write.
    pub(crate) fn due(&self, now: Instant) -> Instant {
        self.written.map_or(now, |written| written + INTERVAL).max(now)
    }

    /// Writes a state; whoever reads the file meanwhile sees the old one or the new one, never a part.
    pub(crate) fn write(&mut self, status: &Status<'_>, now: Instant) -> io::Result<()> {
        self.written = Some(now);
        crate::files::write_whole(&self.path, &serde_json::to_vec(status)?)
    }
}

impl Viewer {
    /// Notes that the status file is out of date.
    pub(super) fn unreported(&mut self) {
        self.reported.0 = true;
    }

    /// Writes the status file where it is out of date. Says when it has to be written if it is too early now.
    pub(crate) fn report(&mut self, graphics: &Graphics, now: Instant) -> Option<Instant> {
        let (stale, said_idle) = self.reported;
        let due = self.status.as_ref()?.due(now);
        let idle = self.is_idle(now);
        if !stale && idle == said_idle {
            return None;
        }
        if due > now {
            return Some(due);
        }
        let mut file = self.status.take()?;
        let status = Status {
            frame: self.frames,
            scene_frames: graphics.renderer.ledger().scene_frames,
            idle,
            scale_factor: self.scale.of(self.window.scale_factor()),
            size: self.window.inner_size().into(),
            mouse_captured: self.pointer.captured,
            panel: self.view.panel,
            help: self.view.help,
            overlay: self.view.overlay,
            full_screen: self.window.fullscreen().is_some(),
            speed: self.fly.speed,
            mode: self.view.mode,
            dark: self.egui.egui_ctx().global_style().visuals.dark_mode,
            zoom: self.view.zoom,
            log: self.view.log.open,
            typing: self.egui.egui_ctx().egui_wants_keyboard_input(),
            choosing_key: self.view.rebinding.is_some(),
            under_way: self.journey.is_under_way(),
            key_frames: self.view.path.path.frames.len(),
            filming: self.film.is_some(),
            scene: &self.scene,
            ledger: graphics.renderer.ledger(),
            frame_ms: Times { median: self.meter.times.quantile(0.5), p99: self.meter.times.quantile(0.99) },
            reference: self.shows_reference,
            drawn_by: self.drawn.as_ref().map(|drawn| drawn.march.technique),
            reading: self.view.reading.status(),
            finding_cones: self.cones.progress(),
            compiling: self.compiler.is_busy(),
            tradeoff: self.tradeoff.results().len(),
            steps: self.steps(),
            says: self.says.as_deref(),
            hint: self.hint.as_ref().map(|(text, _)| text.as_str()),
            toasts: self.toasts.history().collect(),
            widgets: &self.widgets,
        };
        let result = file.write(&status, now);
        self.reported = (false, idle);
        match result {
            Ok(()) => self.status = Some(file),
            Err(error) => {
                self.toasts.error(&format!("The status file cannot be written and is given up: {error}"));
                self.redraw.invalidate();
            }
        }
        None
    }

    /// Whether nothing changes and nothing is being waited for.
    fn is_idle(&self, now: Instant) -> bool {
        let seen = !self.is_unseen() && self.minimised_until.is_none();
        let drawing = seen && (self.redraw.is_wanted() || self.moves());
        let measuring = self.meter.next(now, self.measures_steps()) != Next::Never
            || self.reference.is_busy()
            || self.cones.is_busy()
            || self.compiler.is_busy()
            || self.tradeoff.progress().is_some();
        let working = self.film.is_some() || self.saving || self.wants_screenshot || self.reload_at.is_some();
        let working = working || self.loader.is_busy() || self.generator.is_busy() || self.files.is_busy();
        !(drawing || measuring || working)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(pixels_per_point: f32, on: &mut bool) -> TreeUpdate {
        let ctx = egui::Context::default();
        ctx.enable_accesskit();
        let mut update = None;
        for _ in 0..2 {
            let mut input = egui::RawInput {
                screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(400.0, 300.0))),
                ..Default::default()
            };
            input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(pixels_per_point);
            let mut output = ctx.run_ui(input, |ui| {
                ui.put(
                    egui::Rect::from_min_size(egui::pos2(40.0, 30.0), egui::vec2(100.0, 20.0)),
                    egui::Checkbox::new(on, "Sky"),
                );
                ui.label("a label is no widget");
                ui.add_enabled(false, egui::Button::new("Off"));
            });
            update = output.platform_output.accesskit_update.take();
            output.drop_without_applying_deltas();
        }
        update.expect("accesskit is on")
    }

    /// A test clicks where this says, so on a HiDPI screen it has to be in physical pixels.
    #[test]
    fn widgets_are_placed_in_physical_pixels() {
        for pixels_per_point in [1.0, 2.5] {
            let found = widgets(&tree(pixels_per_point, &mut true));
            assert_eq!(found.len(), 2, "{found:?}");
            let sky = found.iter().find(|widget| widget.label == "Sky").expect("the check box");
            assert_eq!((sky.role.as_str(), sky.toggled, sky.disabled), ("CheckBox", Some(true), false));
            let centre = [(sky.rect[0] + sky.rect[2]) * 0.5, (sky.rect[1] + sky.rect[3]) * 0.5];
            let inside = [40.0..140.0, 30.0..50.0];
            for (at, range) in centre.iter().zip(inside) {
                let points = at / f64::from(pixels_per_point);
                assert!(range.contains(&points), "{points} is not in {range:?} at {pixels_per_point}");
            }
            let off = found.iter().find(|widget| widget.label == "Off").expect("the button");
            assert!(off.disabled);
        }
        let found = widgets(&tree(1.0, &mut false));
        assert!(found.iter().any(|widget| widget.label == "Sky" && widget.toggled == Some(false)));
    }

    #[test]
    fn the_file_is_json_and_replaced_as_a_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("status.json");
        let mut file = StatusFile::new(path.clone());
        let (scene, ledger, start) = (Scene::default(), Ledger::default(), Instant::now());
        assert_eq!(file.due(start), start);
        for frame in [1, 2] {
            let status = Status {
                frame,
                scene_frames: 1,
                idle: true,
                scale_factor: 1.0,
                size: [640, 400],
                mouse_captured: false,
                panel: true,
                help: false,
                overlay: true,
                full_screen: false,
                speed: 0.3,
                mode: Mode::Fly,
                dark: true,
                zoom: 1.0,
                log: false,
                typing: false,
                choosing_key: false,
                under_way: false,
                key_frames: 0,
                filming: false,
                scene: &scene,
                ledger: &ledger,
                frame_ms: Times { median: None, p99: None },
                reference: false,
                drawn_by: Some(Technique::MaxMipmap),
                reading: super::super::reading::Reading::default().status(),
                finding_cones: None,
                compiling: false,
                tradeoff: 0,
                steps: None,
                says: None,
                hint: None,
                toasts: vec!["hello"],
                widgets: &[],
            };
            file.write(&status, start).expect("written");
            let read: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).expect("read")).expect("JSON");
            assert_eq!(read["frame"], frame);
            assert_eq!(read["scene"]["march"]["technique"], "max-mipmap");
            assert_eq!(read["toasts"][0], "hello");
        }
        assert_eq!(file.due(start), start + INTERVAL);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1, "no temporary file is left");
    }
}
