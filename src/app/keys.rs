//! Which key does what: by its place on the keyboard, with the name that the layout prints on it, where that is known.
//!
//! With Ctrl held, keys go by the printed letter, because that is where every other program has Ctrl+Z.

use std::collections::BTreeMap;
use std::fmt;

use winit::keyboard::KeyCode;

use super::actions::{ACTIONS, Action};
pub(crate) use super::key_names::bookmark_of;
use super::key_names::{NAMES, name_of};

/// A key with the modifiers that are held with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Chord {
    pub(crate) key: KeyCode,
    pub(crate) ctrl: bool,
    pub(crate) shift: bool,
}

impl Chord {
    /// The chord of a name such as `Ctrl+Shift+Backspace`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (mut rest, mut ctrl, mut shift) = (text.trim(), false, false);
        loop {
            if let Some(after) = rest.strip_prefix("Ctrl+").filter(|after| !after.is_empty()) {
                (rest, ctrl) = (after, true);
            } else if let Some(after) = rest.strip_prefix("Shift+").filter(|after| !after.is_empty()) {
                (rest, shift) = (after, true);
            } else {
                break;
            }
        }
        let (key, _) = NAMES.iter().find(|(_, name)| name.eq_ignore_ascii_case(rest))?;
        Some(Self { key: *key, ctrl, shift })
    }

    /// Its name with the key called `key`.
    fn called(self, key: &str) -> String {
        format!("{}{}{key}", if self.ctrl { "Ctrl+" } else { "" }, if self.shift { "Shift+" } else { "" })
    }

    /// Whether it types nothing, so that it may work while a field has the keyboard.
    pub(crate) fn types_nothing(self) -> bool {
        let function = name_of(self.key).is_some_and(|name| name.len() > 1 && name.starts_with('F'));
        function || (self.ctrl && !matches!(self.key, KeyCode::KeyA | KeyCode::KeyC | KeyCode::KeyV | KeyCode::KeyX))
    }
}

impl fmt::Display for Chord {
    /// The name of the settings' file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.called(name_of(self.key).unwrap_or_default()))
    }
}

/// A key that goes down, as the window system tells it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Press {
    /// The place.
    pub(crate) key: KeyCode,
    /// What the layout makes of it, where it is one character.
    pub(crate) letter: Option<char>,
    pub(crate) ctrl: bool,
    pub(crate) shift: bool,
    pub(crate) alt: bool,
}

impl Press {
    /// The chord pressed; with Ctrl the key is that of the printed character, where there is one.
    pub(crate) fn chord(self) -> Chord {
        let Self { key, letter, ctrl, shift, .. } = self;
        let printed = letter.filter(|_| ctrl).and_then(|letter| match letter {
            // Plus is above equals, or elsewhere.
            '+' | '=' => Some((KeyCode::Equal, false)),
            '-' => Some((KeyCode::Minus, false)),
            letter if letter.is_ascii_alphanumeric() => {
                let name = letter.to_ascii_uppercase().to_string();
                NAMES.iter().find(|(_, known)| *known == name).map(|(key, _)| (*key, shift))
            }
            _ => None,
        });
        let (key, shift) = printed.unwrap_or((key, shift));
        Chord { key, ctrl, shift }
    }
}

/// Why a key cannot be bound. What was bound stays.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum BindError {
    /// Another action has it.
    #[error("{chord} already does this: {}. Give that another key first, or choose another one here.", .with.entry().does)]
    Taken {
        /// The chord.
        chord: String,
        /// Who has it.
        with: Action,
    },
    /// It is not for choosing.
    #[error("{0} cannot be chosen: 1 to 9 are bookmarks, and Esc cancels. Choose another key.")]
    Reserved(String),
    /// A key that has no name here.
    #[error("This key cannot be chosen: it has no name that would be the same on every system. Choose another key.")]
    Nameless,
}

/// Which key does what.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KeyMap {
    chords: [Option<Chord>; Action::COUNT],
    /// What the layout prints on keys, as far as they were pressed.
    labels: BTreeMap<&'static str, String>,
}

impl Default for KeyMap {
    fn default() -> Self {
        Self { chords: ACTIONS.map(|entry| Chord::parse(entry.default)), labels: BTreeMap::new() }
    }
}

impl KeyMap {
    /// The chord of an action.
    pub(crate) fn chord(&self, action: Action) -> Option<Chord> {
        self.chords[action as usize]
    }

    /// The chord of an action as people know it, or that it has none.
    pub(crate) fn shown(&self, action: Action) -> String {
        self.chord(action).map_or_else(|| "none".to_owned(), |chord| self.called(chord))
    }

    /// A chord as people know it.
    pub(crate) fn called(&self, chord: Chord) -> String {
        let name = name_of(chord.key).unwrap_or_default();
        // With Ctrl the key goes by the printed letter anyway.
        let label = self.labels.get(name).filter(|_| !chord.ctrl).map_or(name, String::as_str);
        chord.called(label)
    }

    /// What a key does. Without Ctrl, Shift and Alt are the speed: where there is no chord of its own with Shift, that
    /// without it counts.
    pub(crate) fn action(&self, press: Press) -> Option<Action> {
        let chord = press.chord();
        let of =
            |wanted: Chord| ACTIONS.iter().map(|entry| entry.action).find(|action| self.chord(*action) == Some(wanted));
        of(chord).or_else(|| (!chord.ctrl).then(|| of(Chord { shift: false, ..chord })).flatten())
    }

    /// The action that a key holds up while it is down, whatever the modifiers have become since.
    pub(crate) fn held(&self, key: KeyCode) -> impl Iterator<Item = Action> {
        ACTIONS
            .iter()
            .map(|entry| entry.action)
            .filter(move |action| self.chord(*action).is_some_and(|chord| chord.key == key))
    }

    /// Gives an action a key, or none.
    ///
    /// # Errors
    /// Another action has it, or nobody can.
    pub(crate) fn bind(&mut self, action: Action, chord: Option<Chord>) -> Result<(), BindError> {
        if let Some(chord) = chord {
            if name_of(chord.key).is_none() {
                return Err(BindError::Nameless);
            }
            if bookmark_of(chord.key).is_some() {
                return Err(BindError::Reserved(self.called(chord)));
            }
            let other = ACTIONS
                .iter()
                .map(|entry| entry.action)
                .find(|other| *other != action && self.chord(*other) == Some(chord));
            if let Some(with) = other {
                return Err(BindError::Taken { chord: self.called(chord), with });
            }
        }
        self.chords[action as usize] = chord;
        Ok(())
    }

    /// All keys as at a first start.
    pub(crate) fn reset(&mut self) {
        self.chords = Self::default().chords;
    }

    /// Whether all keys are as at a first start.
    #[cfg(test)]
    pub(crate) fn is_default(&self) -> bool {
        self.chords == Self::default().chords
    }

    /// Learns what the layout prints on a key. True where that is news.
    pub(crate) fn learn(&mut self, press: Press) -> bool {
        let (Some(letter), Some(name)) = (press.letter, name_of(press.key)) else { return false };
        let plain = !press.ctrl && !press.alt && (letter.is_alphabetic() || !press.shift);
        if !plain || name.len() > 1 || letter.is_whitespace() || letter.is_control() {
            return false;
        }
        let label: String = letter.to_uppercase().collect();
        if label == *name {
            return self.labels.remove(name).is_some();
        }
        self.labels.insert(name, label.clone()).is_none_or(|before| before != label)
    }

    /// What differs from a first start, by the names of the settings' file; nothing is the key of nobody.
    pub(crate) fn changes(&self) -> BTreeMap<String, String> {
        let default = Self::default();
        let changed = ACTIONS.iter().filter(|entry| self.chord(entry.action) != default.chord(entry.action));
        changed
            .map(|entry| {
                (entry.name.to_owned(), self.chord(entry.action).map(|chord| chord.to_string()).unwrap_or_default())
            })
            .collect()
    }

    /// What was learned of the layout.
    pub(crate) fn labels(&self) -> BTreeMap<String, String> {
        self.labels.iter().map(|(name, label)| ((*name).to_owned(), label.clone())).collect()
    }

    /// The keys of a settings' file, and what of it could not be used.
    pub(crate) fn restore(
        changes: &BTreeMap<String, String>,
        labels: &BTreeMap<String, String>,
    ) -> (Self, Vec<String>) {
        let mut map = Self::default();
        let mut problems = Vec::new();
        let mut wanted = Vec::new();
        for (name, text) in changes {
            let chord = if text.is_empty() { Some(None) } else { Chord::parse(text).map(Some) };
            match (Action::named(name), chord) {
                (Some(action), Some(chord)) => wanted.push((action, chord)),
                (None, _) => problems.push(format!("there is no action `{name}`")),
                (_, None) => problems.push(format!("`{text}` is no key (for {name})")),
            }
        }
        // All let go of theirs first, so that two can have exchanged their keys.
        wanted.iter().for_each(|(action, _)| map.chords[*action as usize] = None);
        for (action, chord) in wanted {
            if let Err(error) = map.bind(action, chord) {
                problems.push(format!("{}: {error}", action.entry().name));
                // Its own key, unless that is what the other has taken.
                let _ = map.bind(action, Chord::parse(action.entry().default));
            }
        }
        for (name, label) in labels {
            if let Some((_, name)) = NAMES.iter().find(|(_, known)| known == name) {
                map.labels.insert(name, label.chars().take(3).collect());
            }
        }
        (map, problems)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(key: KeyCode, letter: Option<char>, ctrl: bool, shift: bool) -> Press {
        Press { key, letter, ctrl, shift, alt: false }
    }

    fn action(key: KeyCode, letter: Option<char>, ctrl: bool, shift: bool) -> Option<Action> {
        KeyMap::default().action(press(key, letter, ctrl, shift))
    }

    #[test]
    fn undo_follows_the_printed_letter_and_movement_the_position() {
        assert_eq!(action(KeyCode::KeyY, Some('z'), true, false), Some(Action::UndoCrater), "QWERTZ");
        assert_eq!(action(KeyCode::KeyZ, Some('y'), true, false), None, "QWERTZ");
        assert_eq!(action(KeyCode::KeyZ, Some('я'), true, false), Some(Action::UndoCrater), "Cyrillic");
        assert_eq!(action(KeyCode::KeyC, Some('c'), true, false), None, "Ctrl+C copies, it digs nothing");
        assert_eq!(action(KeyCode::KeyC, Some('c'), false, false), Some(Action::Crater));
        assert_eq!(action(KeyCode::KeyA, Some('q'), true, false), Some(Action::Quit), "AZERTY");
        assert_eq!(action(KeyCode::KeyQ, Some('a'), false, false), Some(Action::Down), "Q's place flies down");
        assert_eq!(action(KeyCode::KeyW, Some('W'), false, true), Some(Action::Forward), "fast");
        assert_eq!(action(KeyCode::KeyK, Some('K'), false, true), Some(Action::RemoveKeyFrame));
        assert_eq!(action(KeyCode::Backspace, None, true, false), None, "all craters are two keys away");
        for (key, letter, shift) in
            [(KeyCode::Equal, '+', true), (KeyCode::BracketRight, '+', false), (KeyCode::NumpadAdd, '+', false)]
        {
            assert_eq!(action(key, Some(letter), true, shift), Some(Action::ZoomIn), "{key:?}");
        }
    }

    #[test]
    fn every_default_key_is_free_and_has_a_name_that_reads_back() {
        let map = KeyMap::default();
        for entry in ACTIONS {
            let chord = map.chord(entry.action).unwrap_or_else(|| panic!("{} has no key", entry.name));
            assert_eq!((chord.to_string().as_str(), Chord::parse(entry.default)), (entry.default, Some(chord)));
            assert_eq!(map.clone().bind(entry.action, Some(chord)), Ok(()), "{} is alone", entry.name);
        }
        assert!(map.is_default() && map.changes().is_empty());
    }

    #[test]
    fn conflicts_and_reserved_keys_are_refused_and_change_nothing() {
        let mut map = KeyMap::default();
        let taken = map.bind(Action::Crater, Chord::parse("F1")).unwrap_err().to_string();
        assert!(taken.contains("F1") && taken.contains("this help"), "{taken}");
        assert!(map.bind(Action::Crater, Chord::parse("Ctrl+4")).unwrap_err().to_string().contains("bookmarks"));
        let nameless = Chord { key: KeyCode::Fn, ctrl: false, shift: false };
        assert_eq!(map.bind(Action::Crater, Some(nameless)), Err(BindError::Nameless));
        assert!(map.is_default());
        map.bind(Action::Crater, Chord::parse("X")).unwrap();
        assert_eq!(map.action(press(KeyCode::KeyX, Some('x'), false, false)), Some(Action::Crater));
        assert_eq!(map.action(press(KeyCode::KeyC, Some('c'), false, false)), None);
        map.bind(Action::Crater, None).unwrap();
        assert_eq!(map.shown(Action::Crater), "none");
    }

    #[test]
    fn keys_are_kept_and_what_cannot_be_used_is_told() {
        let mut map = KeyMap::default();
        // Exchanged.
        map.bind(Action::Crater, None).unwrap();
        map.bind(Action::Capture, Chord::parse("C")).unwrap();
        map.bind(Action::Crater, Chord::parse("F")).unwrap();
        map.bind(Action::PlayPath, None).unwrap();
        assert!(
            map.learn(press(KeyCode::KeyZ, Some('y'), false, false))
                && !map.learn(press(KeyCode::KeyZ, Some('Y'), false, true))
        );
        assert!(!map.learn(press(KeyCode::Digit4, Some('$'), false, true)), "what Shift makes of it is not on the key");
        let (again, problems) = KeyMap::restore(&map.changes(), &map.labels());
        assert_eq!((&again, problems), (&map, Vec::new()));
        assert_eq!(again.called(Chord::parse("Z").unwrap()), "Y", "a German keyboard");
        let bad = [("crater", "Hyper+C"), ("dig", "X"), ("help", "F2")].map(|(a, b)| (a.to_owned(), b.to_owned()));
        let (rest, problems) = KeyMap::restore(&BTreeMap::from(bad), &BTreeMap::new());
        assert_eq!(problems.len(), 3, "{problems:?}");
        assert_eq!(rest.chord(Action::Crater), Chord::parse("C"));
    }

    #[test]
    fn what_types_does_not_work_while_typing() {
        let types_nothing = |text: &str| Chord::parse(text).unwrap().types_nothing();
        assert!(types_nothing("F4") && types_nothing("Ctrl+Q") && types_nothing("Ctrl+="));
        assert!(
            !types_nothing("F") && !types_nothing("Space") && !types_nothing("Ctrl+C") && !types_nothing("Shift+H")
        );
        assert_eq!(
            (bookmark_of(KeyCode::Digit4), bookmark_of(KeyCode::Digit0), bookmark_of(KeyCode::Numpad4)),
            (Some(4), None, None)
        );
    }
}
