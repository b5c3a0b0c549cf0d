//! Reading the land: colours by height, slope and direction, contour lines, hillshade, placed pictures, and the tools that
//! measure.

use std::path::PathBuf;

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, button_unless, choose, doubt, fact, section, text, toggle};
use crate::app::settings::{Command, Facts};
use crate::scene::land::{LandScale, number};
use crate::scene::{GroundColour, Hillshade, LandSettings, Ramp};

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "Takes the map's colours, lines and shades away. Free.";
    section(ui, "Land", false, Some(reset), |ui, reset| {
        let Panel { scene, view, facts, commands, .. } = panel;
        if reset {
            scene.land = LandSettings::default();
            view.paths.imagery.clear();
            view.reading.probe = false;
            view.reading.set_measure(false);
        }
        let land = &mut scene.land;
        let scale = land.scale(&facts.map);
        colours(ui, land, facts, &scale);
        shades(ui, land);
        contours(ui, land, facts, &scale);
        imagery(ui, land, &mut view.paths.imagery, facts);
        ui.separator();
        let tooltip =
            "Tells height, slope and place of the ground under the cursor (P). A ray on the CPU when the cursor moves.";
        toggle(ui, &mut view.reading.probe, "Probe", tooltip);
        let mut measure = view.reading.measure;
        let tooltip = "Two clicks on the ground measure the way between them and show its profile (M; Esc ends it). Free per \
                       frame while the eye rests.";
        if toggle(ui, &mut measure, "Measure", tooltip) {
            commands.push(Command::Measure(measure));
        }
    });
}

fn colours(ui: &mut Ui, land: &mut LandSettings, facts: &Facts, scale: &LandScale) {
    let sources = GroundColour::ALL.map(|value| Choice {
        value,
        name: value.name(),
        tooltip: match value {
            GroundColour::Texture => "The diffuse texture, or grey without one.",
            GroundColour::Ramp => {
                "By height. A gather of heights and a read per pixel; the diffuse texture is not there."
            }
            GroundColour::Slope => "By steepness, in true degrees. Four gathers of heights per pixel.",
            GroundColour::Aspect => "By the direction in which it falls. Four gathers of heights per pixel.",
        },
        off: None,
    });
    choose(ui, &mut land.colour, &sources, "Ground colour", "What the ground is coloured by.", None);
    let off = (land.colour != GroundColour::Ramp).then_some("the ground is not coloured by height");
    let ramps = Ramp::ALL.map(|value| Choice { value, name: value.name(), tooltip: about(value), off: None });
    choose(ui, &mut land.ramp, &ramps, "Ramp", "Colours by height.", off);
    let [lowest, highest] = facts.range;
    let (mut low, mut high) = (scale.low, scale.high);
    let unit = scale.unit();
    let tooltip = "Height of the ramp's lower end; what is lower has the same colour. Sea level stays at 0 m. Free.";
    let ends = lowest..=highest.max(lowest);
    if handle("Ramp low", tooltip, unit, off).slider(ui, &mut low, ends.clone()) {
        land.low = Some(low);
    }
    let tooltip = "Height of the ramp's upper end; what is higher has the same colour. Free.";
    if handle("Ramp high", tooltip, unit, off).slider(ui, &mut high, ends) {
        land.high = Some(high);
    }
    let whole = (land.low.is_none() && land.high.is_none()).then_some("the ramp reaches over all heights");
    if button_unless(ui, "Whole range", "From the map's lowest to its highest. Free.", whole) {
        (land.low, land.high) = (None, None);
    }
    Number::new("Steepest slope", "Degrees that the last colour of slopes stands for. Free.")
        .unit("°")
        .decimals(1)
        .disabled_when(land.colour != GroundColour::Slope, "the ground is not coloured by slope")
        .slider(ui, &mut land.slope_max, 1.0..=90.0);
}

fn handle<'a>(name: &'a str, tooltip: &'a str, unit: &'a str, off: Option<&'a str>) -> Number<'a> {
    Number::new(name, tooltip).unit(unit).disabled_when(off.is_some(), off.unwrap_or_default())
}

/// Where a ramp comes from and what it is good for.
fn about(ramp: Ramp) -> &'static str {
    match ramp {
        Ramp::Oleron => "Sea and land, breaks at sea level. Even, safe for colour-blind eyes (Crameri 2018, MIT).",
        Ramp::Batlow => "Even, safe for colour-blind eyes (Crameri 2018, MIT).",
        Ramp::Viridis => "Even, safe for colour-blind eyes (van der Walt, Smith 2015, CC0).",
        Ramp::Cividis => "Looks the same to most colour-blind eyes (Nuñez et al. 2018, CC0).",
        Ramp::Hypsometric => "The tints of school atlases, break at sea level.",
        Ramp::Riaboy2003 => "The bands of a fractal landscape of 2003, break at sea level.",
        Ramp::Grey => "Black to white, evenly light.",
    }
}

fn shades(ui: &mut Ui, land: &mut LandSettings) {
    let choices = Hillshade::ALL.map(|value| Choice {
        value,
        name: value.name(),
        tooltip: match value {
            Hillshade::Off => "Lit as the lighting says.",
            Hillshade::Sun => {
                "From the sun's direction, never lower than 5.7°, in place of the lighting. Four gathers of heights per pixel."
            },
            Hillshade::Multidirectional => {
                "From four directions, so that no valley lies in the dark (Mark 1992). Four gathers of heights per pixel."
            }
        },
        off: None,
    });
    choose(ui, &mut land.hillshade, &choices, "Hillshade", "Shades of relief in place of the lighting.", None);
    Number::new("Hillshade strength", "How much of the shades shows; 0 compiles none. Free.")
        .disabled_when(land.hillshade == Hillshade::Off, "there is no hillshade")
        .slider(ui, &mut land.hillshade_strength, 0.0..=1.0);
}

fn contours(ui: &mut Ui, land: &mut LandSettings, facts: &Facts, scale: &LandScale) {
    let tooltip = "Lines of equal height, every fifth heavier; they fade out where they would crowd. Five gathers of heights per \
                   pixel.";
    toggle(ui, &mut land.contours, "Contours", tooltip);
    let off = !land.contours;
    let why = "there are no contours";
    let mut interval = scale.interval;
    let relief = (facts.range[1] - facts.range[0]).max(1e-6);
    let number_of = Number::new("Contour interval", "Height from line to line. Free.");
    let field = number_of.unit(scale.unit()).decimals(4).logarithmic().disabled_when(off, why);
    if field.slider(ui, &mut interval, relief / 1000.0..=relief) {
        land.contour_interval = Some(interval);
    }
    let auto = land.contour_interval.is_none().then_some("the interval is the one of the map's range");
    if button_unless(ui, "Automatic interval", "A round interval by the map's range. Free.", auto) {
        land.contour_interval = None;
    }
    Number::new("Contour width", "Width of a line in pixels; heavier ones are twice as wide. Free.")
        .unit(" px")
        .decimals(1)
        .disabled_when(off, why)
        .slider(ui, &mut land.contour_width, 0.5..=6.0);
    if land.contours {
        fact(ui, "Heavier every", format!("{}{}", number(scale.interval * 5.0), scale.unit()));
    }
}

fn imagery(ui: &mut Ui, land: &mut LandSettings, path: &mut String, facts: &Facts) {
    let tooltip = "A picture (GeoTIFF, or PNG, JPEG, WebP with a world file) that is put where it lies. Beside it the ground \
                   keeps its colour. Costs its size on the GPU and a read per pixel.";
    let entered = text(ui, path, "Imagery file", "path of a georeferenced picture", tooltip);
    if let Some(reason) = facts.images.refusal(path) {
        doubt(ui, &format!("This picture is not shown: {reason}."));
    }
    if land.imagery.is_some() {
        for words in &facts.images.doubts {
            doubt(ui, &format!("About the picture's place: {words}."));
        }
    }
    let unplaced = facts.map.georeference().is_none().then_some("the map does not say where it lies");
    let reason = unplaced.or(path.trim().is_empty().then_some("no path is given"));
    ui.horizontal(|ui| {
        let apply = button_unless(ui, "Apply imagery", "Puts the picture named above in its place.", reason);
        if apply || entered && reason.is_none() {
            land.imagery = Some(PathBuf::from(path.trim()));
        }
        let none = land.imagery.is_none().then_some("there is no imagery");
        if button_unless(ui, "Remove imagery", "Takes the picture away. Free.", none) {
            land.imagery = None;
        }
    });
    Number::new("Imagery opacity", "How much of the picture shows; 0 compiles none. Free.")
        .disabled_when(land.imagery.is_none(), "there is no imagery")
        .slider(ui, &mut land.imagery_opacity, 0.0..=1.0);
}
