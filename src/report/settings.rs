//! The ladder of techniques and settings that a report climbs.

use serde::Serialize;

use crate::scene::{MarchSettings, Technique};

/// One technique with one setting. What a technique does not have is `None`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Setting {
    /// The technique.
    pub technique: Technique,
    /// Fewest and most uniform steps.
    pub samples: Option<[u32; 2]>,
    /// Whether the number of steps depends on the ray's angle.
    pub by_angle: Option<bool>,
    /// Halvings of the last step.
    pub halvings: Option<u32>,
}

/// Uniform steps of the full report: octaves.
const OCTAVES: [u32; 8] = [16, 32, 64, 128, 256, 512, 1024, 2048];
/// Uniform steps of the quick one. It has those of [`Setting::BASE`].
const QUICK: [u32; 3] = [32, 128, 512];

impl Setting {
    /// What times are compared with: the setting of the 2009 study.
    pub const BASE: Self =
        Self { technique: Technique::LinearBinary, samples: Some([128, 512]), by_angle: Some(true), halvings: Some(8) };

    /// All settings, the cheaper ones of a technique first, so that running out of time costs the dearest.
    ///
    /// Techniques that count samples: so many for every ray, and by the ray's angle between a quarter of them and all.
    /// Halvings 0 and 8 where there are any. The exact one has no setting.
    pub fn ladder(quick: bool) -> Vec<Self> {
        let octaves: &[u32] = if quick { &QUICK } else { &OCTAVES };
        let mut ladder = Vec::new();
        for technique in Technique::ALL {
            if !technique.counts_samples() {
                ladder.push(Self { technique, samples: None, by_angle: None, halvings: None });
                continue;
            }
            let halvings: &[Option<u32>] = if technique.halves() { &[Some(0), Some(8)] } else { &[None] };
            for &most in octaves {
                for by_angle in [true, false] {
                    let fewest = if by_angle { most / 4 } else { most };
                    ladder.extend(halvings.iter().map(|&halvings| Self {
                        technique,
                        samples: Some([fewest, most]),
                        by_angle: Some(by_angle),
                        halvings,
                    }));
                }
            }
        }
        ladder
    }

    /// `march` with this setting.
    pub fn apply(&self, march: &mut MarchSettings) {
        march.technique = self.technique;
        if let Some([fewest, most]) = self.samples {
            (march.samples_min, march.samples_max) = (fewest, most);
        }
        march.steps_by_angle = self.by_angle.unwrap_or(march.steps_by_angle);
        march.binary_steps = self.halvings.unwrap_or(march.binary_steps);
    }

    /// The setting in words, without the technique: `128–512 by angle, 8 halvings`.
    pub fn words(&self) -> String {
        let mut words = match (self.samples, self.by_angle) {
            (Some([fewest, most]), Some(true)) => format!("{fewest}–{most} by angle"),
            (Some([_, most]), _) => format!("{most}"),
            _ => String::new(),
        };
        if let Some(halvings) = self.halvings {
            words += &format!("{}{halvings} halvings", if words.is_empty() { "" } else { ", " });
        }
        if words.is_empty() { String::from("—") } else { words }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ladder_has_the_base_and_every_technique_and_repeats_nothing() {
        for quick in [false, true] {
            let ladder = Setting::ladder(quick);
            assert!(ladder.contains(&Setting::BASE));
            for technique in Technique::ALL {
                assert!(ladder.iter().any(|setting| setting.technique == technique), "{}", technique.name());
            }
            for (index, setting) in ladder.iter().enumerate() {
                assert!(!ladder[..index].contains(setting), "{setting:?} twice");
            }
        }
        assert_eq!(Setting::BASE.words(), "128–512 by angle, 8 halvings");
    }
}
