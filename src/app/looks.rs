//! What egui's own looks leave too faint: text, and where the keyboard is.

use egui::{Color32, Context, Stroke, StrokeKind, Theme};

/// Gives text the contrast to what lies behind it that WCAG 2.2 asks for (1.4.3: 4.5 to 1), in both themes.
pub(crate) fn legible(ctx: &Context) {
    // Text, and text that stands back: the names of facts, hints in empty fields.
    for (theme, text, weak) in [(Theme::Dark, 185, 145), (Theme::Light, 60, 95)] {
        ctx.style_mut_of(theme, |style| {
            style.visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(text);
            style.visuals.weak_text_color = Some(Color32::from_gray(weak));
            let [warning, error] = match theme {
                Theme::Dark => [[255, 143, 0], [255, 100, 90]],
                Theme::Light => [[160, 75, 0], [200, 0, 0]],
            };
            style.visuals.warn_fg_color = Color32::from_rgb(warning[0], warning[1], warning[2]);
            style.visuals.error_fg_color = Color32::from_rgb(error[0], error[1], error[2]);
        });
    }
}

/// Draws a line around the control that has the keyboard: a header's brighter text, or a slider's thicker handle, is easily
/// missed. To be called once all is drawn.
pub(crate) fn focus_ring(ctx: &Context) {
    let focused = ctx.memory(egui::Memory::focused);
    let Some(response) = focused.and_then(|id| ctx.read_response(id)) else { return };
    // What is scrolled out of view has none.
    if response.interact_rect.is_positive() {
        let stroke = Stroke::new(1.5, ctx.global_style().visuals.selection.stroke.color);
        let around = response.interact_rect.expand(1.0);
        ctx.layer_painter(response.layer_id).rect_stroke(around, 3.0, stroke, StrokeKind::Outside);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of an opaque colour (WCAG 2.2).
    fn luminance(colour: Color32) -> f64 {
        let linear = |byte: u8| {
            let share = f64::from(byte) / 255.0;
            if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    }

    fn contrast(a: Color32, b: Color32) -> f64 {
        let [a, b] = [luminance(a), luminance(b)].map(|luminance| luminance + 0.05);
        a.max(b) / a.min(b)
    }

    #[test]
    fn text_stands_out_from_what_lies_behind_it() {
        let ctx = Context::default();
        legible(&ctx);
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = &ctx.style_of(theme).visuals;
            let grounds = [
                visuals.panel_fill,
                visuals.window_fill,
                visuals.extreme_bg_color,
                visuals.panel_fill.blend(visuals.faint_bg_color),
            ];
            let texts = [
                visuals.text_color(),
                visuals.weak_text_color(),
                visuals.strong_text_color(),
                visuals.warn_fg_color,
                visuals.error_fg_color,
            ];
            for (ground, text) in grounds.iter().flat_map(|ground| texts.map(|text| (*ground, text))) {
                let found = contrast(ground.blend(Color32::TRANSPARENT), text);
                assert!(found >= 4.5, "{theme:?}: {text:?} on {ground:?} has {found:.2}");
            }
            for state in
                [visuals.widgets.inactive, visuals.widgets.hovered, visuals.widgets.active, visuals.widgets.open]
            {
                let found = contrast(state.weak_bg_fill, state.fg_stroke.color);
                assert!(found >= 4.5, "{theme:?}: a button has {found:.2}");
            }
        }
    }

    /// Someone without a mouse sees where the keyboard is: at a header, a slider and a check box.
    #[test]
    fn the_control_with_the_keyboard_has_a_line_around_it() {
        let ctx = Context::default();
        let (mut value, mut on, mut rects) = (0.5, false, Vec::new());
        let mut rings = |focused: Option<usize>| {
            let output = ctx.run_ui(egui::RawInput::default(), |ui| {
                let header = ui.collapsing("section", |_| ()).header_response;
                let controls = [
                    header,
                    ui.add(egui::Slider::new(&mut value, 0.0..=1.0).show_value(false)),
                    ui.checkbox(&mut on, "box"),
                ];
                match focused {
                    Some(index) => controls[index].request_focus(),
                    None => ui.memory_mut(egui::Memory::stop_text_input),
                }
                rects = controls.iter().map(|control| control.interact_rect).collect();
                focus_ring(ui.ctx());
            });
            let colour = ctx.global_style().visuals.selection.stroke.color;
            let ring = |shape: &egui::epaint::ClippedShape| match &shape.shape {
                egui::Shape::Rect(rect) if rect.stroke.color == colour && rect.stroke.width == 1.5 => Some(rect.rect),
                _ => None,
            };
            let found: Vec<_> = output.shapes.iter().filter_map(ring).collect();
            output.drop_without_applying_deltas();
            (found, rects.clone())
        };
        assert!(rings(None).0.is_empty());
        for index in 0..3 {
            rings(Some(index));
            let (found, rects) = rings(Some(index));
            assert_eq!(found, [rects[index].expand(1.0)], "control {index}");
        }
    }
}
