//! What keys do: one table, from which the help (F1), the panel's keys and the README's table are made.

/// Something that a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Action {
    Forward,
    Back,
    Left,
    Right,
    Up,
    Down,
    Orbit,
    Capture,
    FrameTerrain,
    KeyFrame,
    RemoveKeyFrame,
    PlayPath,
    Shadows,
    Water,
    Air,
    Fog,
    Clouds,
    CloudsMove,
    Flare,
    ExaggerateLess,
    ExaggerateMore,
    Probe,
    Measure,
    Crater,
    UndoCrater,
    ClearCraters,
    Help,
    Panel,
    Overlay,
    Log,
    FocusPanel,
    ZoomIn,
    ZoomOut,
    ZoomReset,
    Open,
    SaveMap,
    NextMap,
    PreviousMap,
    NextSeed,
    FullScreen,
    Screenshot,
    Quit,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) action: Action,
    /// The name in the settings' file.
    pub(crate) name: &'static str,
    /// The key of a first start, as in the settings' file.
    pub(crate) default: &'static str,
    /// What it does.
    pub(crate) does: &'static str,
    /// Whether it makes sense while a field of the panel has the keyboard.
    pub(crate) while_typing: bool,
}

const fn row(action: Action, name: &'static str, default: &'static str, does: &'static str) -> Entry {
    Entry { action, name, default, does, while_typing: false }
}

/// A row whose action also makes sense while something is typed.
const fn always(action: Action, name: &'static str, default: &'static str, does: &'static str) -> Entry {
    Entry { action, name, default, does, while_typing: true }
}

/// All actions.
pub(crate) const ACTIONS: [Entry; 42] = [
    row(Action::Forward, "forward", "W", "fly forward"),
    row(Action::Back, "back", "S", "fly back"),
    row(Action::Left, "left", "A", "fly left"),
    row(Action::Right, "right", "D", "fly right"),
    row(Action::Up, "up", "E", "fly up"),
    row(Action::Down, "down", "Q", "fly down"),
    row(Action::Orbit, "orbit", "Tab", "fly or orbit: what drags and the wheel do"),
    row(Action::Capture, "capture-mouse", "F", "capture the mouse to look around"),
    row(Action::FrameTerrain, "frame-terrain", "Home", "frame the terrain (start view)"),
    row(Action::KeyFrame, "key-frame", "K", "key frame of the camera path: the eye as it is"),
    row(Action::RemoveKeyFrame, "remove-key-frame", "Shift+K", "remove the path's last key frame"),
    row(Action::PlayPath, "play-path", "Space", "play the camera path, or stop it"),
    row(Action::Shadows, "shadows", "L", "shadows: off, hard, soft"),
    row(Action::Water, "water", "O", "water: a sea, or none"),
    row(Action::Air, "air", "J", "aerial perspective"),
    row(Action::Fog, "fog", "Shift+J", "fog in the valleys"),
    row(Action::Clouds, "clouds", "N", "clouds: none, clouds, clouds and their shadows"),
    row(Action::CloudsMove, "clouds-move", "Shift+N", "clouds move, or stand still"),
    row(Action::Flare, "flare", "Shift+L", "lens flare"),
    row(Action::ExaggerateLess, "exaggerate-less", "[", "less vertical exaggeration, to a tenth of the true height"),
    row(Action::ExaggerateMore, "exaggerate-more", "]", "more of it, to a hundred times the true height"),
    row(Action::Probe, "probe", "P", "probe: height, slope and place of what is under the cursor"),
    row(Action::Measure, "measure", "M", "measure between two clicks on the ground; Esc ends it"),
    row(Action::Crater, "crater", "C", "crater under the cursor, or under the crosshair"),
    row(Action::UndoCrater, "undo-crater", "Ctrl+Z", "take the last crater back"),
    row(Action::ClearCraters, "clear-craters", "Ctrl+Shift+Backspace", "take all craters back"),
    always(Action::Help, "help", "F1", "this help"),
    always(Action::Panel, "panel", "F2", "panel"),
    always(Action::Overlay, "overlay", "F3", "overlay: frame times, steps, ledger"),
    always(Action::Log, "log", "F4", "log: the last messages"),
    always(Action::FocusPanel, "focus-panel", "F6", "keyboard to the panel, and back to flying"),
    always(Action::ZoomIn, "zoom-in", "Ctrl+=", "larger panel and text"),
    always(Action::ZoomOut, "zoom-out", "Ctrl+-", "smaller panel and text"),
    always(Action::ZoomReset, "zoom-reset", "Ctrl+0", "panel and text in their own size"),
    always(Action::Open, "open", "Ctrl+O", "open maps"),
    always(Action::SaveMap, "save-map", "Ctrl+S", "save the edited map as GeoTIFF, PNG, raw and others"),
    always(Action::NextMap, "next-map", "Ctrl+Tab", "the next of the open maps, where you left it"),
    always(Action::PreviousMap, "previous-map", "Ctrl+Shift+Tab", "the one before it"),
    row(Action::NextSeed, "next-seed", "G", "generate the terrain of the next seed, as the panel says"),
    always(Action::FullScreen, "full-screen", "F11", "full screen"),
    always(Action::Screenshot, "screenshot", "F12", "screenshot: a PNG, and its scene as TOML"),
    always(Action::Quit, "quit", "Ctrl+Q", "quit"),
];

/// What has no key of its own to choose: the mouse, and keys that stay as they are.
pub(crate) const FIXED: [(&str, &str); 13] = [
    ("Right drag", "look around; in orbit as left"),
    ("Left drag", "in orbit around the middle"),
    ("Wheel", "speed; in orbit towards the cursor"),
    ("Double click", "go there"),
    ("Shift / Alt", "4 times as fast / a quarter"),
    ("1 – 9", "go to a bookmark"),
    ("Ctrl+1 – 9", "set a bookmark"),
    ("Esc", "release the mouse; cancel; close"),
    ("Drag the split line", "share of two techniques"),
    ("Drop files", "open them; the first becomes the terrain"),
    ("Click the picture", "keyboard back from the panel"),
    ("Tab, in the panel", "walk through its controls"),
    ("Gamepad", "fly and look (feature gamepad)"),
];

impl Action {
    /// How many there are.
    pub(crate) const COUNT: usize = ACTIONS.len();

    /// Its row of the table.
    pub(crate) fn entry(self) -> &'static Entry {
        // The test below holds the order of the enum to that of the table.
        &ACTIONS[self as usize]
    }

    /// The action with a name of the settings' file.
    pub(crate) fn named(name: &str) -> Option<Self> {
        ACTIONS.iter().find(|entry| entry.name == name).map(|entry| entry.action)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::keys::KeyMap;

    #[test]
    fn the_table_has_every_action_once_in_order() {
        for (index, entry) in ACTIONS.iter().enumerate() {
            assert_eq!(entry.action as usize, index, "{}", entry.name);
            assert_eq!(Action::named(entry.name), Some(entry.action), "{}", entry.name);
        }
    }

    /// The README's table is this one. On a difference: replace what stands between its marks by what the test prints.
    #[test]
    fn the_readme_has_this_table() {
        let keys = KeyMap::default();
        let rows = ACTIONS.iter().map(|entry| (keys.shown(entry.action), entry.does));
        let fixed = FIXED.iter().map(|(input, does)| ((*input).to_owned(), *does));
        let rows: String = rows.chain(fixed).map(|(input, does)| format!("| {input} | {does} |\n")).collect();
        let wanted = format!("| input | does |\n|---|---|\n{rows}");
        let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
        let found = readme.split("<!-- keys -->\n").nth(1).unwrap_or_default();
        assert!(found == wanted, "the README's keys are to be\n<!-- keys -->\n{wanted}<!-- keys -->");
    }
}
