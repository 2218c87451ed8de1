//! Manages archives. An archive is a folder with the tiles of many logs over one water, and one map
//! of all these logs, which is kept up to date.
//!
//! In: results of logs, and the files of an archive. Out: rows, offsets, maps and mosaics by tile.
//!
//! ```text
//! log --add--> points, pings (Parquet) and mosaic (GeoTIFF) by tile --adjust--> height offsets --tile--> depth map and mosaic of a tile --index--> one map
//!                              '--coverage--> which pings cover a place
//! ```
//!
//! Each log is independent up to its rows in tiles; a tile needs only the rows in it and, where
//! depths come from echo levels, those in its neighbours. `tile` names the squares, `record` holds
//! what all logs of an archive share and lists its rows, `log_record` holds what is known of one
//! log. `add` writes a log's rows (`log_rows`): `point_rows`, `ping_rows` and `echo_rows`, and
//! `log_mosaic`, its part of the mosaic. A row of a ping has its footprint, the ground that it
//! insonified, from which `coverage` finds the logs that cover a place. `adjust` computes the
//! heights of logs against each other, the corrections of their positions and the levels of their
//! echoes, where logs cross or overlap; `offsets` is the table of all three. `tile_map` makes the
//! map of a tile, with its lines cut at the edges of the tile, and `tile_files` joins the parts of
//! its mosaic and writes both; `map_tiles` joins all maps to one web map: `tile_content` reads the
//! maps of tiles, and `map_parts` stores parts that were drawn before.
//! Files are written under a temporary name, then renamed, and a log's record is written last, so
//! that the remains of a killed program are no part of the archive.

mod add;
mod adjust;
mod coverage;
mod echo_rows;
mod index;
mod log_mosaic;
mod log_record;
mod log_rows;
mod map_parts;
mod map_tiles;
mod offsets;
mod ping_rows;
mod point_rows;
pub mod readers;
mod record;
mod tile;
mod tile_content;
mod tile_files;
mod tile_map;

pub use add::{Added, add};
pub use adjust::{Adjusted, adjust};
pub use coverage::{CoverageQuery, PingCoverage, coverage_at};
pub use index::write_index;
pub use log_record::LogRecord;
pub use map_tiles::{MapTilesState, write_map_tiles};
pub use offsets::{OffsetRow, Offsets};
pub use record::{Archive, contents};
pub use tile::{TILE_M, TileId};
pub use tile_files::{TileRecord, TileState, remove_left_over, tile_state, write_tile};
pub use tile_map::TileInputs;

use crate::Error;
use crate::pipeline::Fingerprint;
use bathyscope_log::support::progress::Progress;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The subfolder of the rows of points.
const POINTS: &str = "points";
/// The subfolder of the rows of pings.
const PINGS: &str = "pings";
/// The subfolder of the rows of echoes.
const ECHOES: &str = "echoes";
/// The subfolder of the levels of the mosaic.
const MOSAIC: &str = "mosaic";
/// The subfolder of the weights of the levels.
const WEIGHTS: &str = "mosaic_weights";
/// The folder of the records of logs.
const LOGS: &str = "logs";
/// The folders of the files that logs have in tiles, with the endings of these files.
const KINDS: [(&str, &str); 5] = [
    (POINTS, "parquet"),
    (PINGS, "parquet"),
    (ECHOES, "parquet"),
    (MOSAIC, "tif"),
    (WEIGHTS, "tif"),
];
/// Largest size of a record that is read, bytes.
const LONGEST_RECORD: u64 = 1 << 26;

/// Returns the names in a folder; none where there is no folder.
fn names_in(folder: &Path) -> Result<Vec<String>, Error> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let fail = |error| format!("cannot read the folder: {error}: {}", folder.display());
    let entries = fs::read_dir(folder).map_err(fail)?;
    let names = entries.map(|entry| {
        let name = entry.map_err(fail)?.file_name();
        Ok(name.to_string_lossy().into_owned())
    });
    names.collect()
}

/// Removes a file; a missing file is no error.
fn remove(path: &Path) -> Result<(), Error> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove the file: {error}: {}", path.display()).into())
        }
        _ => Ok(()),
    }
}

/// Computes the fingerprint of a file in a folder.
fn fingerprint(folder: &Path, name: &str, progress: &Progress) -> Result<Fingerprint, Error> {
    let fail = |error| format!("cannot read the file: {error}: {}", folder.join(name).display());
    Ok(Fingerprint::of(folder, name, progress).map_err(fail)?)
}
