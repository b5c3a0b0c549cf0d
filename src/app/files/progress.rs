//! How far opening a map is, with a button that ends it.

use std::time::Duration;

use egui::{Align2, Area, Context, Frame, Id, Order, ProgressBar, Rect};

use crate::app::loading::Progress;

/// What is faster is not worth a window.
pub(super) const PATIENCE: Duration = Duration::from_millis(500);

/// Draws it; true when it is to end.
pub(super) fn show(ctx: &Context, free: Rect, progress: &Progress) -> bool {
    let area = Area::new(Id::unique("opening")).order(Order::Foreground).pivot(Align2::CENTER_CENTER);
    let shown = area.fixed_pos(free.center()).show(ctx, |ui| {
        Frame::popup(ui.style())
            .show(ui, |ui| {
                ui.set_width(300.0);
                ui.label(format!("Opening {}", progress.name));
                match progress.share {
                    // Reading is done, but the pyramid and the colours are still to be made.
                    share if share >= 1.0 => ui.add(ProgressBar::new(1.0).text("preparing")),
                    share => ui.add(ProgressBar::new(share).text(format!("{:.0} %", share * 100.0))),
                };
                ui.button("Cancel opening").on_hover_text("Keeps the terrain that is there (Esc).").clicked()
            })
            .inner
    });
    shown.inner
}
