//! An archive: a folder with the tiles of many logs over one water, and one map of all of them,
//! which is kept up to date.
//!
//! In: results of logs, and the files of an archive. Out: rows, offsets, maps and mosaics by tile.
//!
//! ```text
//! log --add--> points, pings (Parquet) and mosaic (GeoTIFF) by tile --adjust--> height offsets --tile--> depth map and mosaic of a tile --index--> one map
//!                              '--coverage--> which pings cover a place
//! ```
//!
//! Each log is independent up to its rows in tiles; a tile needs the rows that lie in it and no
//! other, and those of its neighbours where depths are that come from echo levels. `tile` names the
//! squares, `record` holds what all logs of an archive share, `log_record` what is known of one,
//! `folders` the names of its folders and files, `add` writes a log's rows (`log_rows`):
//! `point_rows`, `ping_rows` and `echo_rows`, laid out by `spread`, and `log_mosaic`, its part of
//! the mosaic. `footprint` is the ground that a ping insonified, from which `coverage` says which
//! logs cover a place. `adjust` finds the heights of logs against each other from their `overlaps`
//! (`solve`), how their `positions` are corrected and, by `level_factors`, the levels of their
//! echoes; `offsets` is the table of all three. `tile_map` makes the map of a tile, its lines cut
//! at its edges, of `tile_points`, with `levels_map` where they come from echo levels, which has a
//! greater `reach`, `tile_mosaic` joins the parts of its mosaic, and `tile_files` writes both;
//! `map_tiles` joins all maps to one of the web, which it reads back by `tile_content` and whose
//! parts are kept by `map_parts`; `list` says what there is. Files are written aside, then renamed,
//! and a log's record last, so that what a killed program leaves is no part of the archive.

mod add;
mod adjust;
mod area;
mod coverage;
mod echo_rows;
mod error;
mod folders;
mod footprint;
mod index;
mod level_factors;
mod levels_map;
mod list;
mod log_mosaic;
mod log_overlaps;
mod log_record;
mod log_rows;
mod map_parts;
mod map_tiles;
mod offsets;
mod ping_rows;
mod point_rows;
mod positions;
mod reach;
pub mod readers;
mod record;
mod solve;
mod spread;
mod tile;
mod tile_content;
mod tile_files;
mod tile_map;
mod tile_mosaic;
mod tile_points;

pub use add::{Added, add};
pub use adjust::{Adjusted, adjust};
pub use coverage::{CoverageQuery, PingCoverage, coverage_at};
pub use error::ArchiveError;
pub use index::write_index;
pub use list::contents;
pub use log_record::LogRecord;
pub use map_tiles::{MapTilesState, write_map_tiles};
pub use offsets::{OffsetRow, Offsets};
pub use record::Archive;
pub use tile::TILE_M;
pub use tile::TileId;
pub use tile_files::{TileRecord, TileState, remove_left_over, tile_state, write_tile};
pub use tile_map::tile_map;
pub use tile_map::tile_surface;
