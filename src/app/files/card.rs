//! What the import card is about to change: a sidecar that counts once it is applied, and stays where it is kept.

use std::path::Path;

use crate::heightfield::import::{Format, ImportOptions, NoData};
use crate::heightfield::{Provenance, Sidecar};

/// The draft of a map's sidecar.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Card {
    /// As it is being changed.
    pub(crate) draft: Sidecar,
    /// As the map was opened.
    applied: Sidecar,
    /// The number that means no height, as it is typed; empty for what the file says.
    pub(crate) nodata: String,
    /// The file has no header, so its layout has to be said.
    pub(crate) is_raw: bool,
    /// The file is a picture whose colours may be heights.
    pub(crate) is_picture: bool,
    /// There is a file that can be read in another way.
    pub(crate) has_file: bool,
    /// Columns and rows of the file; 0 where they are not known.
    pub(crate) full: [u32; 2],
}

impl Card {
    /// That of a map that is open.
    pub(crate) fn of(provenance: &Provenance) -> Self {
        let stated = provenance.stated.clone();
        Self {
            nodata: nodata_text(&stated.import),
            draft: stated.clone(),
            applied: stated,
            is_raw: provenance.format == Format::Raw,
            is_picture: matches!(provenance.format, Format::Png | Format::WebP),
            has_file: provenance.path.is_some(),
            full: provenance.taken.full,
        }
    }

    /// That of a file that does not open until its layout is said; `stated` is what was said before.
    pub(crate) fn for_question(path: &Path, stated: Option<Sidecar>) -> Self {
        let mut warnings = Vec::new();
        let stated = stated.or_else(|| Sidecar::read_for(path, &mut warnings)).unwrap_or_default();
        Self {
            full: stated.import.raw_size.unwrap_or_default(),
            nodata: nodata_text(&stated.import),
            draft: stated.clone(),
            applied: stated,
            is_raw: true,
            has_file: true,
            ..Self::default()
        }
    }

    /// What is to count.
    pub(crate) fn stated(&self) -> Sidecar {
        let mut stated = self.draft.clone();
        stated.import.nodata = self.nodata.trim().parse().ok();
        stated
    }

    /// Why what was typed for no height is none.
    pub(crate) fn nodata_error(&self) -> Option<&'static str> {
        let text = self.nodata.trim();
        if text.is_empty() { None } else { text.parse::<NoData>().err() }
    }

    /// Whether something differs from how the map was opened.
    pub(crate) fn is_changed(&self) -> bool {
        self.stated() != self.applied
    }

    /// Forgets what was changed.
    pub(crate) fn revert(&mut self) {
        self.draft = self.applied.clone();
        self.nodata = nodata_text(&self.applied.import);
    }

    /// Makes this the distance between samples, in metres; the extent follows from it.
    pub(crate) fn set_step(&mut self, metres: f64) {
        self.draft.extent_metres = None;
        self.draft.metres_per_sample = (metres > 0.0).then_some(metres);
    }

    /// Makes the lowest and the highest sample stand for these heights.
    pub(crate) fn set_range(&mut self, [low, high]: [f64; 2]) {
        (self.draft.lowest_metre, self.draft.highest_metre) = (Some(low.min(high)), Some(high.max(low)));
    }
}

fn nodata_text(options: &ImportOptions) -> String {
    match options.nodata {
        None => String::new(),
        Some(NoData::Never) => "none".to_owned(),
        Some(NoData::Value(value)) => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heightfield::load;

    #[test]
    fn what_the_card_says_counts_like_a_sidecar() {
        let folder = tempfile::tempdir().unwrap();
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats/other/oblong.raw");
        let path = folder.path().join("oblong.raw");
        std::fs::copy(data, &path).unwrap();
        let mut card = Card::for_question(&path, None);
        assert!(card.is_raw && !card.is_changed());
        card.draft.import.raw_size = Some([21, 18]);
        card.draft.import.raw_type = Some(crate::heightfield::import::RawType::I16);
        card.draft.import.raw_endian = Some(crate::heightfield::import::Endian::Big);
        card.set_step(30.0);
        card.nodata = "soon".into();
        assert!(card.nodata_error().is_some() && card.is_changed());
        card.nodata = "-9000".into();
        assert_eq!(card.nodata_error(), None);
        let options = ImportOptions::default();
        let loaded =
            load::load_as(&path, card.stated(), &options, crate::heightfield::import::Listener::none()).unwrap();
        assert!(loaded.nodata_fraction > 0.0);
        assert_eq!(loaded.field.extent_metres(), Some([600.0, 510.0]));
        assert!(!Sidecar::path_of(&path).exists(), "nothing is written until it is asked for");

        let opened = Card::of(&Provenance::of(&loaded, Some(path.clone())));
        assert!(!opened.is_changed() && opened.nodata == "-9000" && opened.full == [21, 18]);
        crate::heightfield::companions::keep(&path, &opened.stated()).unwrap();
        let again = load::load(&path).unwrap();
        assert_eq!((again.field, again.stated), (loaded.field, loaded.stated));
        let mut reverted = opened.clone();
        reverted.set_range([5.0, 1.0]);
        assert_eq!(reverted.stated().range(), Some([1.0, 5.0]));
        reverted.revert();
        assert_eq!(reverted, opened);
    }
}
