//! A few words for who is here for the first time: shown once.

use egui::{Align2, Context, Grid, Id, Rect, Window, vec2};

use super::actions::Action;
use super::keys::KeyMap;

/// Draws the words in the middle of the free part of the window, until they are closed.
pub(crate) fn show(ctx: &Context, free: Rect, keys: &KeyMap, open: &mut bool) {
    if !*open {
        return;
    }
    let moves = [Action::Forward, Action::Left, Action::Back, Action::Right].map(|action| keys.shown(action)).join(" ");
    let key = |action| keys.shown(action);
    let rows = [
        (format!("{moves}, right drag"), "fly and look around"),
        (key(Action::Orbit), "orbit: turn around what is in the middle"),
        ("Double click".to_owned(), "go there"),
        (key(Action::FrameTerrain), "back to the start view"),
        (key(Action::Help), "all keys"),
        ("Drop a file".to_owned(), "open any elevation file"),
    ];
    let mut done = false;
    let window = Window::new("Welcome to Relief")
        .id(Id::unique("welcome"))
        .open(open)
        .collapsible(false)
        .resizable(false)
        .frame(egui::Frame::window(&ctx.global_style()).inner_margin(14));
    window.pivot(Align2::CENTER_CENTER).fixed_pos(free.center()).show(ctx, |ui| {
        ui.add_space(4.0);
        Grid::new("welcome").num_columns(2).spacing(vec2(20.0, 8.0)).show(ui, |ui| {
            for (input, does) in rows {
                ui.strong(input);
                ui.label(does);
                ui.end_row();
            }
        });
        ui.add_space(8.0);
        let button = ui.vertical_centered(|ui| ui.button("Start")).inner;
        done = button.on_hover_text("Closes these words; Esc does, too.").clicked();
    });
    *open &= !done;
}
