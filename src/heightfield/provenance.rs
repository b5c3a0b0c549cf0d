//! What is known of an opened map besides its samples.

use std::path::PathBuf;

use super::import::{Elevation, Format, Georeference, Taken, VerticalUnit};
use super::{HeightField, Loaded, Sidecar};

/// Where a map came from and how it was read: what an import card shows, and what goes along when it is saved.
#[derive(Clone, Debug)]
pub struct Provenance {
    /// The file; absent for what is built in.
    pub path: Option<PathBuf>,
    /// The file's format.
    pub format: Format,
    /// How its samples were packed, where the format has a choice.
    pub compression: Option<String>,
    /// The type of the file's samples: "u8", "i16", "f32" and so on.
    pub sample_type: &'static str,
    /// Share of the samples that hold no height, 0..1.
    pub nodata_fraction: f64,
    /// What heights are measured in, where it is known.
    pub vertical_unit: Option<VerticalUnit>,
    /// Where the map lies.
    pub georeference: Option<Georeference>,
    /// The part of the file that was taken.
    pub taken: Taken,
    /// The sidecar that was used; its extent is that of the part.
    pub sidecar: Option<Sidecar>,
    /// What would have to stand beside the file for it to open like this without any option.
    pub stated: Sidecar,
}

impl Provenance {
    /// That of a map that was just opened from `path`.
    pub fn of(loaded: &Loaded, path: Option<PathBuf>) -> Self {
        Self {
            path,
            format: loaded.format,
            compression: loaded.compression.clone(),
            sample_type: loaded.sample_type,
            nodata_fraction: loaded.nodata_fraction,
            vertical_unit: loaded.vertical_unit,
            georeference: loaded.georeference.clone(),
            taken: loaded.taken,
            sidecar: loaded.sidecar.clone(),
            stated: loaded.stated.clone(),
        }
    }

    /// The reference system, as the file or its sidecar names it.
    pub fn crs(&self) -> Option<&str> {
        let of_place = self.georeference.as_ref().and_then(|place| place.crs.as_deref());
        of_place.or(self.sidecar.as_ref().and_then(|sidecar| sidecar.crs.as_deref()))
    }

    /// `field`, which is the map of this origin, edited or not, as it can be written: at its place, its heights in metres
    /// where they are known to be.
    pub fn elevation(&self, field: &HeightField) -> Elevation {
        let elevation = Elevation::of_field(field, self.georeference.clone());
        Elevation {
            vertical_unit: elevation.vertical_unit.or(self.vertical_unit.map(|_| VerticalUnit::Metre)),
            ..elevation
        }
    }

    /// What goes along when the map is written: title, source, licence, the extent of the part. How the file was read does
    /// not: another file is written.
    pub fn sidecar_to_write(&self) -> Sidecar {
        let kept = self.sidecar.clone().unwrap_or_default();
        Sidecar { import: Default::default(), recipe: None, ..kept }
    }
}
