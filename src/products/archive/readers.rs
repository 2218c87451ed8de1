//! Exposes the readers of the files of an archive to the fuzzer (`tests/fuzz`).

use super::log_record::LogRecord;
use super::record::ArchiveRecord;
use super::tile_files::TileRecord;
use super::{echo_rows, offsets, ping_rows, point_rows};
use crate::Error;
use crate::pipeline::{LogFiles, Settings};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use std::path::Path;

/// Reads a file as rows of points, of pings and of echoes; returns the errors of the readers that
/// fail.
pub fn rows(path: &Path) -> Vec<Error> {
    let points = point_rows::read(path).map(drop);
    let pings = ping_rows::read(path).map(drop);
    let echoes = echo_rows::read(path).map(drop);
    [points, pings, echoes].into_iter().filter_map(Result::err).collect()
}

/// Reads a file as the record of an archive, of a log and of a tile, and as a table of offsets;
/// returns the errors of the readers that fail.
pub fn records(path: &Path) -> Vec<Error> {
    let text = regular_file::read_text(path, u64::MAX).unwrap_or_default();
    let refused = |error: serde_json::Error| Error::from(error.to_string());
    let archive = serde_json::from_str::<ArchiveRecord>(&text).map_err(refused);
    let archive = archive.and_then(|record| record.settings());
    let tile = serde_json::from_str::<TileRecord>(&text).map_err(refused);
    let log = LogRecord::read(path).map(drop);
    let offsets = offsets::rows_of(path).map(drop);
    let all = [archive.map(drop), tile.map(drop), log, offsets];
    all.into_iter().filter_map(Result::err).collect()
}

/// Returns the record of an archive and the record of a log without rows, as seeds for the fuzzer.
pub fn record_seeds(settings: &Settings) -> Vec<String> {
    let files = LogFiles { sha256: "0a1b".to_owned(), files: Vec::new() };
    let log = LogRecord::new(&Survey::default(), settings, &files);
    let archive = ArchiveRecord::new(settings).ok();
    let archive = archive.and_then(|record| serde_json::to_string(&record).ok());
    archive.into_iter().chain(serde_json::to_string(&log).ok()).collect()
}
