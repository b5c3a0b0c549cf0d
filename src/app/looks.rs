//! Colours of the interface where egui's own are too faint to read.

use egui::{Color32, Context, Theme};

/// Gives text the contrast to what lies behind it that WCAG 2.2 asks for (1.4.3: 4.5 to 1), in both themes.
pub(crate) fn legible(ctx: &Context) {
    // Text, and text that stands back: the names of facts, hints in empty fields.
    for (theme, text, weak) in [(Theme::Dark, 185, 145), (Theme::Light, 60, 95)] {
        ctx.style_mut_of(theme, |style| {
            style.visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(text);
            style.visuals.weak_text_color = Some(Color32::from_gray(weak));
        });
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
            let texts = [visuals.text_color(), visuals.weak_text_color(), visuals.strong_text_color()];
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
}
