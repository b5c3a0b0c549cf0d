//! Layers of clouds, their shadows, and the clock that moves them.

use serde::{Deserialize, Serialize};

use crate::scene_file::{OutOfRange, check};

/// Most layers.
pub const MOST_CLOUD_LAYERS: usize = 5;

/// What clouds are made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum CloudSource {
    /// Noise that has the look of heaps and veils.
    #[default]
    Noise,
    /// The map's own heights, mirrored at its borders (Riaboy 2003).
    Map,
}

impl CloudSource {
    /// All, in the order of the panel.
    pub const ALL: [Self; 2] = [Self::Noise, Self::Map];

    /// The name used in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Map => "map",
        }
    }
}

/// A flat layer of clouds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CloudLayer {
    /// Height in metres: above sea level where the map's heights are metres, else above its lowest place.
    pub height: f64,
    /// Share of the sky that it covers, 0 to 1; the cover of all layers shifts it.
    pub cover: f64,
    /// Optical thickness of its thickest clouds, 0 (nothing) to 50.
    pub thickness: f64,
    /// Kilometres after which its pattern begins anew; two patterns are mixed whose repeats do not fall together.
    pub scale: f64,
    /// Metres per second that it moves.
    pub speed: f64,
    /// Compass direction that it moves to, degrees.
    pub direction: f64,
}

impl Default for CloudLayer {
    fn default() -> Self {
        Self { height: 3000.0, cover: 0.5, thickness: 3.0, scale: 12.0, speed: 10.0, direction: 90.0 }
    }
}

/// Clouds in the sky.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CloudSettings {
    /// Whether they are drawn.
    pub enabled: bool,
    /// What they are made from.
    pub source: CloudSource,
    /// Cover of all layers, 0 (no cloud) to 1 (every layer closed): at 0.5 each has its own.
    pub cover: f64,
    /// Whether they keep the sun from the ground and the occluder.
    pub shadows: bool,
    /// How dark the shadows are, 0 to 1.
    pub shadow_strength: f64,
    /// The moment that is shown, in seconds since the layers were where they began; before that where it is negative.
    pub time: f64,
    /// Whether time passes in films and in the viewer. While it does there, frames are drawn all the time.
    pub moving: bool,
    /// Seconds that pass in the sky for each of the viewer's or the film's.
    pub rate: f64,
    /// The layers, at most five; a scene that names any names all. A layer shades what lies below it; of five, the fourth also
    /// what lies between it and the fifth.
    pub layers: Vec<CloudLayer>,
}

impl Default for CloudSettings {
    fn default() -> Self {
        let layer = |height, cover, thickness, scale, speed, direction| CloudLayer {
            height,
            cover,
            thickness,
            scale,
            speed,
            direction,
        };
        Self {
            enabled: false,
            source: CloudSource::default(),
            cover: 0.5,
            shadows: false,
            shadow_strength: 0.8,
            time: 0.0,
            moving: false,
            rate: 30.0,
            layers: vec![
                layer(3200.0, 0.2, 4.5, 9.0, 8.0, 75.0),
                layer(3900.0, 0.13, 3.0, 14.0, 11.0, 95.0),
                layer(5200.0, 0.15, 1.4, 22.0, 16.0, 110.0),
                layer(7000.0, 0.18, 0.7, 36.0, 24.0, 85.0),
                layer(9500.0, 0.26, 0.35, 60.0, 35.0, 100.0),
            ],
        }
    }
}

impl CloudSettings {
    /// Share of the sky that a layer covers, under the cover of all.
    pub fn cover_of(&self, layer: &CloudLayer) -> f64 {
        let own = layer.cover;
        // From nothing over the layer's own to all.
        let cover =
            if self.cover < 0.5 { own * self.cover * 2.0 } else { own + (1.0 - own) * (self.cover * 2.0 - 1.0) };
        cover.clamp(0.0, 1.0)
    }

    /// Layers that can be seen at all.
    pub fn shown(&self) -> impl Iterator<Item = &CloudLayer> {
        let seen = |layer: &&CloudLayer| self.enabled && layer.thickness > 0.0 && self.cover_of(layer) > 0.0;
        self.layers.iter().filter(seen)
    }

    /// Whether the picture changes with time.
    pub fn runs(&self) -> bool {
        let ends = (self.time >= MOST_SECONDS && self.rate > 0.0) || (self.time <= -MOST_SECONDS && self.rate < 0.0);
        self.moving && self.rate != 0.0 && !ends && self.shown().any(|layer| layer.speed != 0.0)
    }

    /// Lets `seconds` pass in the viewer.
    pub fn run(&mut self, seconds: f64) {
        // Layers have no common period at which a clock could begin anew without a jump: at the ends it stands.
        self.time = (self.time + self.rate * seconds).clamp(-MOST_SECONDS, MOST_SECONDS);
    }

    /// Checks that a picture can be made.
    ///
    /// # Errors
    /// The first field outside its range.
    pub(crate) fn validate(&self) -> Result<(), OutOfRange> {
        check("clouds.cover", self.cover, 0.0..=1.0)?;
        check("clouds.shadow_strength", self.shadow_strength, 0.0..=1.0)?;
        check("clouds.time", self.time, -MOST_SECONDS..=MOST_SECONDS)?;
        check("clouds.rate", self.rate, -10_000.0..=10_000.0)?;
        check("clouds.layers (their number)", self.layers.len() as f64, 0.0..=MOST_CLOUD_LAYERS as f64)?;
        for (index, layer) in self.layers.iter().enumerate() {
            let field = |name: &str| format!("clouds.layers[{index}].{name}");
            check(&field("height"), layer.height, -20_000.0..=200_000.0)?;
            check(&field("cover"), layer.cover, 0.0..=1.0)?;
            check(&field("thickness"), layer.thickness, 0.0..=50.0)?;
            check(&field("scale"), layer.scale, 0.01..=10_000.0)?;
            check(&field("speed"), layer.speed, -1000.0..=1000.0)?;
            check(&field("direction"), layer.direction, -360.0..=360.0)?;
        }
        Ok(())
    }
}

/// Three centuries: places of layers are then still known to a millimetre.
pub(crate) const MOST_SECONDS: f64 = 1e10;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cover_goes_from_nothing_over_each_layers_own_to_all() {
        let mut clouds = CloudSettings { enabled: true, ..CloudSettings::default() };
        let covers =
            |clouds: &CloudSettings| clouds.layers.iter().map(|layer| clouds.cover_of(layer)).collect::<Vec<_>>();
        assert_eq!(covers(&clouds), clouds.layers.iter().map(|layer| layer.cover).collect::<Vec<_>>());
        assert_eq!(clouds.shown().count(), MOST_CLOUD_LAYERS);
        clouds.cover = 0.0;
        assert_eq!(clouds.shown().count(), 0);
        clouds.moving = true;
        assert!(!clouds.runs(), "what cannot be seen does not move");
        clouds.cover = 1.0;
        assert!(covers(&clouds).iter().all(|&cover| cover == 1.0) && clouds.runs());
        clouds.run(2.0);
        assert_eq!(clouds.time, 60.0);
        // Back past the beginning, as smoothly as forth.
        clouds.rate = -30.0;
        (0..3).for_each(|_| clouds.run(1.0));
        assert_eq!(clouds.time, -30.0);
        assert_eq!(clouds.validate(), Ok(()));
        (clouds.time, clouds.rate) = (MOST_SECONDS - 1.0, 10_000.0);
        clouds.run(1.0);
        assert!(clouds.time == MOST_SECONDS && clouds.validate().is_ok(), "no way back to the beginning at once");
        assert!(!clouds.runs(), "where the clock stands, no frames are drawn for it");
        (clouds.time, clouds.rate) = (-MOST_SECONDS, -1.0);
        assert!(!clouds.runs());
        clouds.rate = 1.0;
        assert!(clouds.runs(), "it goes on the other way");
        clouds.enabled = false;
        assert!(!clouds.runs());
    }

    #[test]
    fn absurd_values_are_named() {
        let refused = |change: &dyn Fn(&mut CloudSettings)| {
            let mut clouds = CloudSettings::default();
            change(&mut clouds);
            clouds.validate().map_err(|error| error.field)
        };
        assert_eq!(refused(&|_| {}), Ok(()));
        assert_eq!(refused(&|clouds| clouds.cover = 1.5), Err("clouds.cover".into()));
        assert_eq!(refused(&|clouds| clouds.time = f64::INFINITY), Err("clouds.time".into()));
        assert_eq!(refused(&|clouds| clouds.layers[2].scale = 0.0), Err("clouds.layers[2].scale".into()));
        let many = |clouds: &mut CloudSettings| clouds.layers.push(CloudLayer::default());
        assert!(refused(&many).unwrap_err().starts_with("clouds.layers"));
    }
}
