//! The panel's few kinds of widgets. Each has a name in the accessibility tree and a tooltip: what it does, its unit,
//! what it costs.

use std::ops::RangeInclusive;

use egui::emath::Numeric;
use egui::{Button, CollapsingHeader, ComboBox, DragValue, Response, Slider, TextEdit, Ui};

/// Width of the slider's rail, so that all rows of the panel line up. Points.
const RAIL_WIDTH: f32 = 110.0;

/// A collapsible section with the button that resets it. `reset` says what the button does.
pub(super) fn section(ui: &mut Ui, name: &str, open: bool, reset: Option<&str>, body: impl FnOnce(&mut Ui, bool)) {
    CollapsingHeader::new(name).default_open(open).show(ui, |ui| {
        ui.spacing_mut().slider_width = RAIL_WIDTH;
        let pressed = reset.is_some_and(|tooltip| button(ui, &format!("Reset {}", name.to_lowercase()), tooltip));
        body(ui, pressed);
    });
}

/// A check box.
pub(super) fn toggle(ui: &mut Ui, on: &mut bool, name: &str, tooltip: &str) -> bool {
    ui.checkbox(on, name).on_hover_text(tooltip).changed()
}

/// What is wrong with what stands above it, or doubtful about it. Told by a sign and not by a colour alone.
pub(super) fn doubt(ui: &mut Ui, words: &str) {
    ui.label(format!("⚠ {words}"));
}

/// A button; true when it was pressed.
pub(super) fn button(ui: &mut Ui, name: &str, tooltip: &str) -> bool {
    ui.button(name).on_hover_text(tooltip).clicked()
}

/// A button that can be pressed only when there is no reason against it.
pub(super) fn button_unless(ui: &mut Ui, name: &str, tooltip: &str, reason: Option<&str>) -> bool {
    let response = ui.add_enabled(reason.is_none(), Button::new(name));
    explain(response, tooltip, reason).clicked()
}

/// A number with a rail and a field to type in.
pub(super) struct Number<'a> {
    name: &'a str,
    tooltip: &'a str,
    unit: &'a str,
    decimals: usize,
    logarithmic: bool,
    off: Option<&'a str>,
}

impl<'a> Number<'a> {
    /// A number named `name`; whole numbers ignore the decimals.
    pub(super) fn new(name: &'a str, tooltip: &'a str) -> Self {
        Self { name, tooltip, unit: "", decimals: 2, logarithmic: false, off: None }
    }

    /// Written behind the number.
    pub(super) fn unit(mut self, unit: &'a str) -> Self {
        self.unit = unit;
        self
    }

    /// Digits behind the point.
    pub(super) fn decimals(mut self, decimals: usize) -> Self {
        self.decimals = decimals;
        self
    }

    /// The rail is logarithmic.
    pub(super) fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// Not in use, and why.
    pub(super) fn disabled_when(mut self, off: bool, reason: &'a str) -> Self {
        self.off = if off { Some(reason) } else { self.off };
        self
    }

    /// The widget: a rail (`name`), a field (`name` + " value") and the visible name. True when the number changed.
    pub(super) fn slider<T: Numeric>(self, ui: &mut Ui, value: &mut T, range: RangeInclusive<T>) -> bool {
        let decimals = if T::INTEGRAL { 0 } else { self.decimals };
        ui.add_enabled_ui(self.off.is_none(), |ui| {
            ui.horizontal(|ui| {
                let rail = Slider::new(value, range.clone())
                    .show_value(false)
                    .logarithmic(self.logarithmic)
                    .clamping(egui::SliderClamping::Edits);
                let rail = explain(ui.add(rail), self.tooltip, self.off).accessible_name(self.name);
                let speed = step::<T>((range.end().to_f64() - range.start().to_f64()) / 400.0, decimals);
                let field = DragValue::new(value).range(range).speed(speed).suffix(self.unit).max_decimals(decimals);
                let field = field.clamp_existing_to_range(false).update_while_editing(false).custom_parser(finite);
                let field = explain(ui.add(field), self.tooltip, self.off).accessible_name(field_name(self.name));
                explain(ui.label(self.name), self.tooltip, self.off);
                rail.changed() || field.changed()
            })
            .inner
        })
        .inner
    }

    /// A field without a rail, for numbers without natural ends.
    pub(super) fn field<T: Numeric>(self, ui: &mut Ui, value: &mut T, range: RangeInclusive<T>, speed: f64) -> bool {
        let decimals = if T::INTEGRAL { 0 } else { self.decimals };
        let field = DragValue::new(value)
            .range(range)
            .speed(step::<T>(speed, decimals))
            .suffix(self.unit)
            .max_decimals(decimals)
            .clamp_existing_to_range(false)
            // Half a number, such as the 0 of 0.3 for the height of the eye, must not be put right while typing goes on.
            .update_while_editing(false)
            .custom_parser(finite);
        ui.add_enabled_ui(self.off.is_none(), |ui| {
            ui.horizontal(|ui| {
                let field = explain(ui.add(field), self.tooltip, self.off).accessible_name(self.name);
                explain(ui.label(self.name), self.tooltip, self.off);
                field.changed()
            })
            .inner
        })
        .inner
    }
}

/// What an arrow key adds to a number, and the mouse for a point: `speed`, but no less than the last digit that shows, or the
/// key would do nothing.
fn step<T: Numeric>(speed: f64, decimals: usize) -> f64 {
    // Few digits.
    let last_digit = if T::INTEGRAL { 1.0 } else { 10f64.powi(-(decimals as i32)) };
    speed.max(last_digit)
}

/// The number in a text that was typed. What is none leaves the field as it was, and so do `nan` and `inf`, which egui
/// would take for the end of the range.
fn finite(text: &str) -> Option<f64> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).map(|c| if c == '−' { '-' } else { c }).collect();
    plain.parse().ok().filter(|number: &f64| number.is_finite())
}

/// The accessible name of the field beside a slider's rail.
pub(super) fn field_name(name: &str) -> String {
    format!("{name} value")
}

/// A choice of a drop-down list.
pub(super) struct Choice<'a, T> {
    /// What it stands for.
    pub(super) value: T,
    /// What the list says.
    pub(super) name: &'a str,
    /// What it does.
    pub(super) tooltip: &'a str,
    /// Why it cannot be chosen.
    pub(super) off: Option<&'a str>,
}

/// A drop-down list; `off` says why nothing can be chosen.
pub(super) fn choose<T: Copy + PartialEq>(
    ui: &mut Ui,
    current: &mut T,
    choices: &[Choice<'_, T>],
    name: &str,
    tooltip: &str,
    off: Option<&str>,
) -> bool {
    let before = *current;
    let selected = choices.iter().find(|choice| choice.value == *current).map_or("", |choice| choice.name);
    ui.add_enabled_ui(off.is_none(), |ui| {
        ui.horizontal(|ui| {
            let list =
                ComboBox::from_id_salt(name).selected_text(selected).width(RAIL_WIDTH + 40.0).show_ui(ui, |ui| {
                    for choice in choices {
                        ui.add_enabled_ui(choice.off.is_none(), |ui| {
                            let item = ui.selectable_value(current, choice.value, choice.name);
                            explain(item, choice.tooltip, choice.off);
                        });
                    }
                });
            explain(list.response, tooltip, off).accessible_name(name);
            explain(ui.label(name), tooltip, off);
        });
    });
    before != *current
}

/// A one-line text field as wide as the panel; true when Enter was pressed in it.
pub(super) fn text(ui: &mut Ui, value: &mut String, name: &str, hint: &str, tooltip: &str) -> bool {
    let field = ui.add(TextEdit::singleline(value).hint_text(hint).desired_width(f32::INFINITY));
    let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
    field.on_hover_text(tooltip).accessible_name(name);
    entered
}

/// A fact: its name, and what it is.
pub(super) fn fact(ui: &mut Ui, name: &str, value: impl Into<String>) {
    ui.horizontal_wrapped(|ui| {
        ui.weak(name);
        ui.label(value.into());
    });
}

/// The tooltip of a widget, and why it is disabled where it is.
fn explain(response: Response, tooltip: &str, off: Option<&str>) -> Response {
    match off {
        None => response.on_hover_text(tooltip),
        Some(reason) => response.on_disabled_hover_text(format!("{tooltip}\n\nNot in use: {reason}")),
    }
}
