//! Options for reading the land, and what a picture of it is said to show.

use std::path::PathBuf;

use clap::Args;

use super::parse;
use crate::heightfield::{HEIGHT_SCALES, HeightField};
use crate::scene::land::{LandScale, number};
use crate::scene::{ColourSource, GroundColour, Hillshade, Ramp, Scene};

/// Contour lines as asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Contours {
    /// An interval by the map's range.
    Auto,
    /// An interval in metres, or in the map's own numbers.
    Every(f64),
}

/// What colours the ground: one option for what are two settings of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Colour {
    /// Its texture
    Texture,
    /// Grass, rock, scree, snow and sand by slope and height
    Materials,
    /// Its height, by a ramp
    Ramp,
    /// Its steepness in true degrees
    Slope,
    /// The direction in which it falls
    Aspect,
}

impl Colour {
    fn apply(self, scene: &mut Scene) {
        scene.land.colour = match self {
            Self::Texture | Self::Materials => GroundColour::Texture,
            Self::Ramp => GroundColour::Ramp,
            Self::Slope => GroundColour::Slope,
            Self::Aspect => GroundColour::Aspect,
        };
        match self {
            Self::Texture => scene.diffuse.source = ColourSource::Texture,
            Self::Materials => (scene.diffuse.enabled, scene.diffuse.source) = (true, ColourSource::Materials),
            Self::Ramp | Self::Slope | Self::Aspect => {}
        }
    }
}

/// How the land is shown as on a map.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Reading the land")]
pub(crate) struct LandArgs {
    /// Colour the ground by height
    #[arg(long, value_name = "NAME", value_enum)]
    pub(crate) ramp: Option<Ramp>,
    /// Heights of the ramp's ends, metres where the map knows them [default: the map's lowest..highest]
    #[arg(long, value_name = "LOW..HIGH", value_parser = range, allow_hyphen_values = true)]
    pub(crate) ramp_range: Option<[f64; 2]>,
    /// What colours the ground [default: texture]
    #[arg(long, value_name = "BY", value_enum)]
    pub(crate) colour: Option<Colour>,
    /// Contour lines every so many metres (the map's own numbers where it knows none); without a number by the map's range
    #[arg(long, value_name = "INTERVAL", value_parser = contours, num_args = 0..=1, default_missing_value = "auto",
        require_equals = true)]
    pub(crate) contours: Option<Contours>,
    /// Shades of relief in place of the lighting
    #[arg(long, value_name = "FROM", value_enum, num_args = 0..=1, default_missing_value = "sun", require_equals = true)]
    pub(crate) hillshade: Option<Hillshade>,
    /// A picture put where its GeoTIFF tags or its world file say; the ground beside it keeps its colour
    #[arg(long, value_name = "IMAGE", value_parser = parse::input_file())]
    pub(crate) imagery: Option<PathBuf>,
    /// Put a legend into saved pictures: what the ramp, the slopes, the contours or the heat map's colours stand for
    #[arg(long)]
    pub(crate) legend: bool,
    /// Heights as so many times their true proportion, 0.1 to 100 [default: the map's, else 1]
    #[arg(long, value_name = "TIMES", value_parser = exaggeration, conflicts_with = "height_scale")]
    pub(crate) exaggeration: Option<f64>,
}

impl LandArgs {
    /// Sets what was asked for.
    pub(crate) fn apply(&self, scene: &mut Scene) {
        if let Some(colour) = self.colour {
            colour.apply(scene);
        }
        let land = &mut scene.land;
        if let Some(ramp) = self.ramp {
            (land.colour, land.ramp) = (GroundColour::Ramp, ramp);
        }
        if let Some([low, high]) = self.ramp_range {
            (land.low, land.high) = (Some(low), Some(high));
            // A range without a ramp would show nothing.
            if self.colour.is_none() {
                land.colour = GroundColour::Ramp;
            }
        }
        land.hillshade = self.hillshade.unwrap_or(land.hillshade);
        match self.contours {
            Some(Contours::Every(interval)) => (land.contours, land.contour_interval) = (true, Some(interval)),
            Some(Contours::Auto) => (land.contours, land.contour_interval) = (true, None),
            None => {}
        }
        scene.saved.legend |= self.legend;
        if self.imagery.is_some() {
            land.imagery.clone_from(&self.imagery);
        }
    }

    /// Sets the height that was asked for, once the map is known.
    pub(crate) fn exaggerate(&self, scene: &mut Scene, map: &HeightField) {
        if let Some(times) = self.exaggeration {
            let scale = (map.true_height_scale() * times).clamp(*HEIGHT_SCALES.start(), *HEIGHT_SCALES.end());
            scene.terrain.height_scale = Some(scale);
        }
    }
}

/// What the colours and lines of a picture mean, where they mean something: the legend in words.
pub(crate) fn legend(scene: &Scene, map: &HeightField) -> Option<String> {
    let land = &scene.land;
    let scale = land.scale(map);
    let colours = match land.colour {
        GroundColour::Texture => None,
        GroundColour::Ramp => Some(ramp_in_words(land.ramp, &scale)),
        GroundColour::Slope => Some(format!("slope: pale is level, black is {}° or more", number(land.slope_max))),
        GroundColour::Aspect => Some("the colour is the direction in which the ground falls; grey is level".to_owned()),
    };
    let lines = land.contours.then(|| scale.contours_in_words());
    let words: Vec<String> = colours.into_iter().chain(lines).collect();
    (!words.is_empty()).then(|| words.join("; "))
}

fn ramp_in_words(ramp: Ramp, scale: &LandScale) -> String {
    let unit = scale.unit();
    let sea = if ramp.is_marine() && scale.low < scale.middle && scale.middle < scale.high {
        format!(", its break at {}{unit}", number(scale.middle))
    } else {
        String::new()
    };
    format!("heights by {}: {}{unit} to {}{unit}{sea}", ramp.name(), number(scale.low), number(scale.high))
}

fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| format!("{text:?} is no number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{text:?} is no finite number")) }
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let (low, high) = text.split_once("..").ok_or("it must be LOW..HIGH, such as -4000..3000")?;
    let (low, high) = (finite(low)?, finite(high)?);
    if low < high { Ok([low, high]) } else { Err(format!("{low} is not below {high}")) }
}

fn contours(text: &str) -> Result<Contours, String> {
    if text == "auto" {
        return Ok(Contours::Auto);
    }
    let interval = finite(text)?;
    let valid = crate::scene::land::INTERVALS;
    if valid.contains(&interval) {
        Ok(Contours::Every(interval))
    } else {
        Err("it must be above 0, or auto".to_owned())
    }
}

fn exaggeration(text: &str) -> Result<f64, String> {
    let times = finite(text)?;
    let valid = crate::heightfield::EXAGGERATIONS;
    if valid.contains(&times) { Ok(times) } else { Err(format!("it must be {} to {}", valid.start(), valid.end())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_checked_where_they_are_given() {
        assert_eq!(range("-4000..3000"), Ok([-4000.0, 3000.0]));
        assert!(range("3..1").is_err() && range("nan..1").is_err() && range("5").is_err());
        assert_eq!((contours("auto"), contours("12.5")), (Ok(Contours::Auto), Ok(Contours::Every(12.5))));
        assert!(contours("0").is_err() && contours("-5").is_err() && contours("inf").is_err());
        assert_eq!(exaggeration("2.5"), Ok(2.5));
        assert!(exaggeration("0.01").is_err() && exaggeration("101").is_err());
    }

    #[test]
    fn the_legend_says_what_colours_and_lines_mean() {
        let raw: [f64; 4] = [-200.0, 100.0, 0.0, 50.0];
        let map = HeightField::from_raw(2, 2, &raw).unwrap().with_metres(true);
        let mut scene = Scene::default();
        assert_eq!(legend(&scene, &map), None);
        LandArgs { ramp: Some(Ramp::Oleron), contours: Some(Contours::Every(25.0)), ..LandArgs::default() }
            .apply(&mut scene);
        let words = legend(&scene, &map).unwrap();
        assert_eq!(
            words,
            "heights by oleron: -200 m to 100 m, its break at 0 m; contours every 25 m, heavier every 125 m"
        );
        LandArgs { exaggeration: Some(3.0), ..LandArgs::default() }.exaggerate(&mut scene, &map);
        assert_eq!(scene.terrain.height_scale, Some(0.75), "a plain map's own is 0.25");
    }
}
