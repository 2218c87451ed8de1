//! Reads and writes the record of one log of an archive: `logs/SHA256.json`, written when all rows
//! of the log are in place.

use super::LONGEST_RECORD;
use super::tile::TileId;
use crate::pipeline::{
    Fingerprint, LogFiles, SettingValues, Settings, deserialize_values, in_hexadecimal,
    setting_values,
};
use crate::{Error, PROGRAM};
use bathyscope_bottom::swath::LearntLevels;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// The setting that names a file of which the archive keeps a copy.
pub(super) const AREA: &str = "isobaths.clip";

/// A log of an archive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogRecord {
    /// SHA-256 of the log, which names it in the archive.
    pub log: String,
    /// Name of the log for people: the name of its file.
    pub name: String,
    /// Inputs and settings from which the rows of the log were made.
    pub(super) made: Origin,
    /// Unix seconds of the log's time zero; `None` where the time is not known.
    pub start_unix_s: Option<f64>,
    /// Number of points of the log, without their copies in halos.
    pub points: usize,
    /// Number of points that are soundings of the recorder and count for maps; crossings compare
    /// these.
    pub soundings: usize,
    /// Number of side-scan pings of the log that have a place and a heading.
    pub pings: usize,
    /// Meaning of the log's echo levels; `None` where its echoes are not kept or cannot be used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levels: Option<LearntLevels>,
    /// Rows of the log by tile, in order.
    pub tiles: Vec<TileRows>,
}

/// Inputs and settings of the rows of a log: the same origin gives the same rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Origin {
    /// Name and version of the program.
    program: String,
    /// Files of the log, of the track of another receiver and of the readings of the water level.
    files: Vec<Fingerprint>,
    /// All settings.
    #[serde(deserialize_with = "deserialize_values")]
    settings: SettingValues,
    /// SHA-256 of the bottom edits; `None` without edits.
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
    /// Number of rows of points, with those of the halo; 0 where there is no file of points.
    pub points: usize,
    /// Number of points in the tile itself.
    pub core_points: usize,
    /// Number of rows of pings that insonified ground of the tile; 0 where there is no file of
    /// pings.
    pub pings: usize,
    /// Number of cells with a level in the log's part of the mosaic; 0 where there is no such part.
    pub mosaic_cells: usize,
    /// West, south, east and north edge of the ground that the pings insonified, metres of the
    /// zone; empty without pings.
    pub seen_m: Vec<f64>,
    /// Unix seconds of the first and the last row; empty where the time is not known.
    pub unix_s: Vec<f64>,
    /// Files of the rows of the log and of its part of the mosaic.
    pub files: Vec<Fingerprint>,
}

impl TileRows {
    /// Returns the SHA-256 of the file in a folder of the archive, such as `points`; empty without
    /// one.
    pub(super) fn sha256_of(&self, kind: &str) -> &str {
        let is_of_kind = |file: &&Fingerprint| file.file.split('/').next() == Some(kind);
        let found = self.files.iter().find(is_of_kind);
        found.map_or("", |file| file.sha256.as_str())
    }
}

/// Serializes a tile as its name.
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

/// Returns all settings but the name of the area of the isobaths: no row depends on this name, and
/// the archive has its own copy of the area.
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
                program: PROGRAM.to_owned(),
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

    /// Returns true if all files of the log are there and have the recorded lengths.
    pub(super) fn is_whole(&self, folder: &Path) -> bool {
        let mut files = self.tiles.iter().flat_map(|rows| &rows.files);
        files.all(|file| file.is_as_long_in(folder))
    }

    /// Returns the rows of the log in a tile, if any.
    pub fn rows_in(&self, tile: TileId) -> Option<&TileRows> {
        self.tiles.iter().find(|rows| rows.tile == tile)
    }

    /// Reads a record.
    ///
    /// # Errors
    /// When the file cannot be read or is no such record.
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
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
