//! The ground's colour.

use std::path::PathBuf;

use egui::Ui;

use super::Panel;
use super::widgets::{Number, button_unless, doubt, fact, section, text, toggle};
use crate::scene::DiffuseSettings;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "The generated texture, once over the terrain.";
    section(ui, "Diffuse", false, Some(reset), |ui, reset| {
        let (diffuse, path) = (&mut panel.scene.diffuse, &mut panel.view.paths.diffuse);
        if reset {
            *diffuse = DiffuseSettings::default();
            path.clear();
        }
        let tooltip = "Colours the ground with a texture; otherwise it is grey. One texture read per pixel.";
        toggle(ui, &mut diffuse.enabled, "Enable diffuse texture", tooltip);
        let shown =
            diffuse.file.as_ref().map_or("generated from height and slope".into(), |file| file.display().to_string());
        fact(ui, "Texture", shown);
        let tooltip = "An image (PNG, JPEG, WebP) to drape over the terrain, north up. Costs its size on the GPU.";
        let entered = text(ui, path, "Diffuse image", "path of an image", tooltip);
        if let Some(reason) = panel.facts.images.refusal(path) {
            doubt(ui, &format!("This image is not shown: {reason}."));
        }
        ui.horizontal(|ui| {
            let empty = path.trim().is_empty().then_some("no path is given");
            if button_unless(ui, "Apply diffuse image", "Drapes the image named above.", empty)
                || entered && empty.is_none()
            {
                diffuse.file = Some(PathBuf::from(path.trim()));
            }
            let generated = diffuse.file.is_none().then_some("the texture is the generated one");
            if button_unless(ui, "Generated texture", "Colours by height and slope instead of an image.", generated) {
                diffuse.file = None;
            }
        });
        Number::new("Repeats", "How often the texture repeats along each side. Free.")
            .disabled_when(!diffuse.enabled, "the diffuse texture is off")
            .slider(ui, &mut diffuse.repeats, 1.0..=64.0);
    });
}
