//! Files that are dragged over the window. The window system tells of one file at a time, and not how many will come.

use std::path::PathBuf;

use winit::event::WindowEvent;

/// Files over the window, and those let go of that have not been opened yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Drops {
    hovering: Vec<PathBuf>,
    dropped: Vec<PathBuf>,
}

impl Drops {
    /// Notes an event. False for one that has nothing to do with files.
    pub(crate) fn event(&mut self, event: &WindowEvent) -> bool {
        match event {
            WindowEvent::HoveredFile(path) => {
                // Some systems tell again while the cursor moves.
                if !self.hovering.contains(path) {
                    self.hovering.push(path.clone());
                }
            }
            WindowEvent::HoveredFileCancelled => self.hovering.clear(),
            WindowEvent::DroppedFile(path) => {
                self.hovering.clear();
                if !self.dropped.contains(path) {
                    self.dropped.push(path.clone());
                }
            }
            _ => return false,
        }
        true
    }

    /// Whether something was dropped and not taken yet.
    pub(crate) fn is_waiting(&self) -> bool {
        !self.dropped.is_empty()
    }

    /// What was dropped, once.
    pub(crate) fn take(&mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.dropped)
    }

    /// What to say while files are over the window.
    pub(crate) fn hint(&self) -> Option<String> {
        let first = self.hovering.first()?;
        let name = first.file_name().unwrap_or(first.as_os_str()).to_string_lossy();
        Some(match self.hovering.len() {
            1 => format!("Let go to open {name}"),
            2 => format!("Let go to open {name}; Ctrl+Tab then goes to the other file"),
            count => format!("Let go to open {name}; Ctrl+Tab then goes to the {} others", count - 1),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_announced_and_a_drop_opens_all_of_it() {
        let mut drops = Drops::default();
        assert!(!drops.event(&WindowEvent::RedrawRequested) && drops.hint().is_none());
        for path in ["/a/one.tif", "/a/two.tif", "/a/one.tif"] {
            assert!(drops.event(&WindowEvent::HoveredFile(path.into())));
        }
        assert_eq!(drops.hint().as_deref(), Some("Let go to open one.tif; Ctrl+Tab then goes to the other file"));
        drops.event(&WindowEvent::HoveredFileCancelled);
        assert!(drops.hint().is_none() && drops.take().is_empty());

        drops.event(&WindowEvent::HoveredFile("/a/one.tif".into()));
        for path in ["/a/one.tif", "/a/two.tif"] {
            drops.event(&WindowEvent::DroppedFile(path.into()));
        }
        assert!(drops.hint().is_none() && drops.is_waiting());
        assert_eq!(drops.take(), [PathBuf::from("/a/one.tif"), "/a/two.tif".into()]);
        assert!(!drops.is_waiting() && drops.take().is_empty());
    }
}
