//! Shadows, and the clock that moves the sun.

use egui::Ui;

use super::Panel;
use super::widgets::{Choice, Number, choose, fact, section, toggle};
use crate::scene::light::{Clock, Shadows};
use crate::scene::sun::days_in_month;

pub(super) fn show(ui: &mut Ui, panel: &mut Panel<'_>) {
    let reset = "No shadows, and a sun that stands where the lighting says. Free.";
    section(ui, "Sun", false, Some(reset), |ui, reset| {
        let lighting = &mut panel.scene.lighting;
        if reset {
            (lighting.shadows, lighting.clock) = (Shadows::Off, Clock::default());
            (lighting.baked, lighting.occlusion) = (false, false);
        }
        let off = (!lighting.enabled).then_some("lighting is off");
        let choices = Shadows::ALL.map(|value| Choice {
            value,
            name: value.name(),
            off: None,
            tooltip: match value {
                Shadows::Off => "Hills hide no sun. Costs nothing.",
                Shadows::Hard => {
                    "One exact walk to the sun per pixel that faces it: about as much as the picture itself."
                }
                Shadows::Soft => "The sun's true half degree, by five exact walks: up to five times as much.",
            },
        });
        let tooltip = "What hills and the occluder keep the sun from. Each kind is a pipeline of its own.";
        choose(ui, &mut lighting.shadows, &choices, "Shadows", tooltip, off);

        ui.add_enabled_ui(off.is_none(), |ui| {
            let tooltip = "Draws the shadows into a light map with a texel per cell, anew when sun, ground or occluder change. \
                           One texture read per pixel, and as many walks to the sun as the map has cells at each change.";
            toggle(ui, &mut lighting.baked, "Bake shadows", tooltip);
            let tooltip = "Dims the light from everywhere where hills stand around a place. One texture read per pixel, and \
                           twelve walks for each of the map's cells when the ground changes.";
            toggle(ui, &mut lighting.occlusion, "Ambient occlusion", tooltip);
        });

        let place = lighting.sun_place();
        let clock = &mut lighting.clock;
        let tooltip = "Moves the sun by date, time and place, in place of azimuth and elevation. Free.";
        toggle(ui, &mut clock.enabled, "Follow the clock", tooltip);
        let (still, why) = (!clock.enabled, "the sun does not follow the clock");
        let number = |name, tooltip| Number::new(name, tooltip).disabled_when(still, why);
        number("Hour", "Hours UTC since the day began. Free per frame; the sky is made anew.").unit(" h").slider(
            ui,
            &mut clock.hour,
            0.0..=24.0,
        );
        number("Month", "Month of the year. Free per frame.").slider(ui, &mut clock.month, 1..=12);
        // A scene may count on into the next month; showing the panel changes nothing.
        let days = days_in_month(clock.year, clock.month).max(clock.day);
        number("Day", "Day of the month. Free per frame.").slider(ui, &mut clock.day, 1..=days);
        number("Year", "The sun's place is good to 0.01° from 1900 to 2100. Free per frame.").slider(
            ui,
            &mut clock.year,
            1900..=2100,
        );
        let [mut latitude, mut longitude] = clock.place();
        let moved = number("Latitude", "Degrees north of the equator. Free per frame.").unit("°").decimals(3).slider(
            ui,
            &mut latitude,
            -90.0..=90.0,
        );
        clock.latitude = if moved { Some(latitude) } else { clock.latitude };
        let moved = number("Longitude", "Degrees east of Greenwich. Free per frame.").unit("°").decimals(3).slider(
            ui,
            &mut longitude,
            -180.0..=180.0,
        );
        clock.longitude = if moved { Some(longitude) } else { clock.longitude };
        let tooltip = "Hours of the clock per minute; 0 stands still. While it runs, frames are drawn all the time.";
        number("Clock speed", tooltip).unit(" h/min").decimals(1).slider(ui, &mut clock.speed, -60.0..=60.0);
        fact(ui, "Sun", format!("{:.2}° from north, {:.2}° high", place.azimuth, place.elevation));
    });
}
