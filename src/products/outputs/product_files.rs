//! Lists the files of each product in words.

use super::order::When;
use super::product::Product;
use super::registry::{OUTPUT_FILES, OutputFile};
use clap::builder::PossibleValue;

impl Product {
    /// Its files: `track/track.gpx, .geojson; track/footprint.geojson`.
    pub fn files(self) -> String {
        let rows = OUTPUT_FILES.iter();
        files_in_words(rows.filter(|row| row.when == When::Chosen(self)))
    }
}

/// The names of some files: `track/track.gpx, .geojson; track/footprint.geojson`. What belongs to a
/// shapefile goes without saying.
pub fn files_in_words<'a>(rows: impl Iterator<Item = &'a OutputFile>) -> String {
    let with_colours = |row: &'a OutputFile| {
        let colours = row.companions.iter().filter(|name| name.ends_with(STYLE));
        std::iter::once(row.name).chain(colours.copied())
    };
    let (mut words, mut stem_before) = (String::new(), "");
    for name in rows.flat_map(with_colours) {
        let (stem, ending) = name.split_at(name.find('.').unwrap_or(name.len()));
        words += &match (words.is_empty(), stem == stem_before) {
            (true, _) => name.to_owned(),
            (false, true) => format!(", {ending}"),
            (false, false) => format!("; {name}"),
        };
        stem_before = stem;
    }
    if let Some(at) = words.rfind(STYLE) {
        words.insert_str(at + STYLE.len(), " (colours for QGIS)");
    }
    words
}

/// The ending of a style for QGIS.
const STYLE: &str = ".qml";

impl clap::ValueEnum for Product {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.files()))
    }
}
