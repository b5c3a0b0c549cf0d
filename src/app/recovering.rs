//! A GPU device that is lost, and what goes on with the next one.

use std::time::{Duration, Instant};

use super::graphics::Graphics;
use super::measure::Meter;
use super::settings::Facts;
use super::viewer::Viewer;

/// A device lost again within this time is not worth another try.
const RECOVERY_PAUSE: Duration = Duration::from_secs(5);

impl Viewer {
    /// Whether a lost device is worth another try.
    pub(crate) fn may_recover(&mut self, now: Instant) -> bool {
        let recently = self.recovered.is_some_and(|at| now.saturating_duration_since(at) < RECOVERY_PAUSE);
        self.recovered = Some(now);
        !recently
    }

    /// Goes on with a new device.
    pub(crate) fn recovered(&mut self, graphics: &Graphics, lost: &str) {
        let title = std::mem::take(&mut self.facts.title);
        self.facts = Facts::new(&self.map, title, &graphics.gpu);
        (self.drawn, self.shown, self.meter) = (None, None, Meter::default());
        // The pipelines are gone with the device.
        self.prepared = false;
        self.compiler.forget();
        self.reference.forget();
        self.cones.forget();
        self.tradeoff.forget();
        self.film = None;
        send_textures_again(self.egui.egui_ctx());
        let message = format!("The GPU device was lost ({lost}) and has been set up again.");
        self.toasts.warning(&message, Instant::now());
        self.redraw.invalidate();
    }
}

/// Makes egui send its textures whole: a new device has none of them. New fonts are the only way to ask for that, so
/// a font family that nobody uses is added.
fn send_textures_again(ctx: &egui::Context) {
    let mut fonts = egui::FontDefinitions::default();
    let unused = egui::FontFamily::Name(format!("device {}", ctx.cumulative_pass_nr()).into());
    let same = fonts.families.get(&egui::FontFamily::Proportional).cloned().unwrap_or_default();
    fonts.families.insert(unused, same);
    ctx.set_fonts(fonts);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After a lost device the panel would be blank if egui only sent what changed.
    #[test]
    fn a_new_device_gets_the_font_texture_whole() {
        let ctx = egui::Context::default();
        let textures = |ctx: &egui::Context| {
            let mut output = ctx.run_ui(egui::RawInput::default(), |ui| {
                ui.label("text");
            });
            let whole = output.textures_delta.set.values().flatten().any(egui::epaint::ImageDelta::is_whole);
            output.textures_delta.clear();
            whole
        };
        assert!(textures(&ctx));
        assert!(!textures(&ctx));
        for _ in 0..2 {
            send_textures_again(&ctx);
            assert!(textures(&ctx));
            assert!(!textures(&ctx));
        }
    }
}
