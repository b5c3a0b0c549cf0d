//! The monitor's scale while the window is open.
//!
//! On X11 winit tells of a new scale by an event, but [`winit::window::Window::scale_factor`] goes on giving the old one
//! until a window manager reports the window's place, and then the event comes a second time, with a wish for twice the
//! size. egui asks the window. So the event is believed, egui's zoom makes up for the difference, and what is told twice
//! is done once.

/// What is known of the scale: physical pixels per point of the window system.
#[derive(Debug)]
pub(super) struct Scale {
    /// What an event told last, and what the window said then.
    told: Option<[f64; 2]>,
    /// The part of egui's zoom that is ours.
    zoom: f64,
}

impl Default for Scale {
    fn default() -> Self {
        Self { told: None, zoom: 1.0 }
    }
}

impl Scale {
    /// An event tells that the scale is `scale`, while the window says `window`. False where that was known.
    pub(super) fn tell(&mut self, scale: f64, window: f64) -> bool {
        let news = self.told.is_none_or(|[known, _]| known != scale);
        self.told = Some([scale, window]);
        news
    }

    /// The scale, where the window says it is `window`: it is believed once it says anything new.
    pub(super) fn of(&self, window: f64) -> f64 {
        self.told.filter(|[_, then]| *then == window).map_or(window, |[told, _]| told)
    }

    /// What egui's zoom has to be multiplied by now, if anything, so that it draws at [`Scale::of`].
    pub(super) fn change_of_zoom(&mut self, window: f64) -> Option<f32> {
        let zoom = self.of(window) / window;
        let before = std::mem::replace(&mut self.zoom, zoom);
        (zoom != before).then_some((zoom / before) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_that_lags_behind_is_made_up_for_until_it_catches_up() {
        let mut scale = Scale::default();
        assert_eq!((scale.of(1.0), scale.change_of_zoom(1.0)), (1.0, None));
        assert!(scale.tell(2.0, 1.0), "news");
        assert_eq!((scale.of(1.0), scale.change_of_zoom(1.0)), (2.0, Some(2.0)));
        assert_eq!(scale.change_of_zoom(1.0), None, "once");
        // The window manager speaks up: the window knows, and the event comes again.
        assert!(!scale.tell(2.0, 2.0), "known");
        assert_eq!((scale.of(2.0), scale.change_of_zoom(2.0)), (2.0, Some(0.5)));
        assert!(scale.tell(1.0, 2.0));
        assert_eq!((scale.of(2.0), scale.change_of_zoom(2.0)), (1.0, Some(0.5)));
    }

    #[test]
    fn a_window_that_knows_is_believed() {
        let mut scale = Scale::default();
        assert!(scale.tell(1.5, 1.5));
        assert_eq!((scale.of(1.5), scale.change_of_zoom(1.5)), (1.5, None));
        // A scale that no event told of.
        assert_eq!((scale.of(3.0), scale.change_of_zoom(3.0)), (3.0, None));
    }
}
