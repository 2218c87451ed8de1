//! Record of one log of an archive: `logs/SHA256.json`, written when all of its rows are in place.

use super::tile::TileId;
use super::{ArchiveError, LONGEST_RECORD};
use crate::pipeline::{
    Fingerprint, LogFiles, SettingValues, Settings, deserialize_values, in_hexadecimal,
    setting_values,
};
use bathyscope_bottom::swath::LearntLevels;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// The setting whose file the archive keeps a copy of.
pub(super) const AREA: &str = "isobaths.clip";

/// A log of an archive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogRecord {
    /// SHA-256 of the log: its name in the archive.
    pub log: String,
    /// Name for people: the name of its file.
    pub name: String,
    /// Inputs and settings of its rows.
    pub(super) made: Origin,
    /// Unix seconds of its time zero, where the recorder knew the time.
    pub start_unix_s: Option<f64>,
    /// Its points, those in halos not counted again.
    pub points: usize,
    /// Points that are soundings of its recorder and count for maps: crossings compare these.
    pub soundings: usize,
    /// Its side-scan pings that have a place.
    pub pings: usize,
    /// Meaning of its levels, where its echoes are kept and can be used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levels: Option<LearntLevels>,
    /// Its rows by tile, in order.
    pub tiles: Vec<TileRows>,
}

/// Inputs and settings of the rows of a log: the same origin gives the same rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Origin {
    /// The program.
    program: String,
    /// The log's files, the track of another receiver and the readings of the water level.
    files: Vec<Fingerprint>,
    /// All settings.
    #[serde(deserialize_with = "deserialize_values")]
    settings: SettingValues,
    /// SHA-256 of the bottom edits, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    bottom_edits: Option<String>,
}

/// The rows of a log in a tile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TileRows {
    /// The tile.
    #[serde(with = "as_text")]
    pub tile: TileId,
    /// Rows of points, those of the halo among them; 0 where there is no file of them.
    pub points: usize,
    /// Points in the tile itself.
    pub core_points: usize,
    /// Rows of pings that saw ground of the tile; 0 where there is no file of them.
    pub pings: usize,
    /// Cells of its part of the mosaic; 0 where there is none.
    pub mosaic_cells: usize,
    /// West, south, east and north of the ground that they saw, metres of the zone; empty without
    /// pings.
    pub seen_m: Vec<f64>,
    /// Unix seconds of the first and the last row; empty where the recorder did not know the time.
    pub unix_s: Vec<f64>,
    /// The files of its rows and of its part of the mosaic.
    pub files: Vec<Fingerprint>,
}

impl TileRows {
    /// SHA-256 of its file in a folder of the archive, such as `points`; empty without one.
    pub(super) fn sha256_of(&self, kind: &str) -> &str {
        let is_of_kind = |file: &&Fingerprint| file.file.split('/').next() == Some(kind);
        let found = self.files.iter().find(is_of_kind);
        found.map_or("", |file| file.sha256.as_str())
    }
}

/// A tile as its name.
mod as_text {
    use super::TileId;
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    pub(super) fn serialize<S: Serializer>(tile: &TileId, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(tile)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<TileId, D::Error> {
        String::deserialize(from)?.parse().map_err(D::Error::custom)
    }
}

/// All settings but the name of the area of the isobaths: no row depends on it, and the archive has
/// its own copy.
fn of_rows(settings: &Settings) -> SettingValues {
    let mut values = setting_values(settings);
    values.remove(AREA);
    values
}

impl LogRecord {
    /// Creates the record of a log that has no rows yet.
    pub(super) fn new(survey: &Survey, settings: &Settings, files: &LogFiles) -> Self {
        let bottom = serde_json::to_vec(&settings.bottom).unwrap_or_default();
        Self {
            log: files.sha256.clone(),
            name: survey.name(),
            made: Origin {
                program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
                files: files.files.clone(),
                settings: of_rows(settings),
                bottom_edits: (!settings.bottom.is_empty())
                    .then(|| in_hexadecimal(&Sha256::digest(&bottom))),
            },
            start_unix_s: survey.start_unix_s,
            points: 0,
            soundings: 0,
            pings: 0,
            levels: None,
            tiles: Vec::new(),
        }
    }

    /// Returns true if another record is of the same log, made with the same settings by the same
    /// program. The names of files do not matter.
    pub(super) fn is_made_alike(&self, other: &Self) -> bool {
        let hashes = |record: &Self| -> Vec<String> {
            let files = record.made.files.iter();
            files.map(|file| file.sha256.clone()).collect()
        };
        let of_names = |record: &Self| Origin { files: Vec::new(), ..record.made.clone() };
        self.log == other.log && hashes(self) == hashes(other) && of_names(self) == of_names(other)
    }

    /// Returns true if all of its files are there, as long as they were.
    pub(super) fn is_whole(&self, folder: &Path) -> bool {
        let mut files = self.tiles.iter().flat_map(|rows| &rows.files);
        files.all(|file| file.is_as_long_in(folder))
    }

    /// Its rows in a tile, if any.
    pub fn rows_in(&self, tile: TileId) -> Option<&TileRows> {
        self.tiles.iter().find(|rows| rows.tile == tile)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// A sentence where it cannot be used.
    pub(super) fn read(path: &Path) -> Result<Self, ArchiveError> {
        let fail = |error: String| {
            format!(
                "the record of a log cannot be used: {error}; remove it and process the log again: {}",
                path.display()
            )
        };
        let text = regular_file::read_text(path, LONGEST_RECORD)
            .map_err(|error| fail(error.to_string()))?;
        Ok(serde_json::from_str(&text).map_err(|error| fail(error.to_string()))?)
    }
}
