//! `bathyscope archive`: everything of an archive that is out of date.

use super::adjust::{adjusted, summary, tell};
use super::make_maps;
use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{
    Archive, MapTilesState, TileId, TileState, contents, remove_left_over, tile_state, write_index,
    write_map_tiles,
};
use std::path::PathBuf;

/// `bathyscope archive DIR`.
#[derive(Debug, clap::Args)]
pub(crate) struct ArchiveArgs {
    /// Folder of the archive
    archive: PathBuf,
}

/// Finds the offsets, makes the maps that are stale or missing, and the index of all.
pub(crate) fn run(args: &ArchiveArgs) -> Result<(), Failure> {
    let archive = Archive::open(&args.archive)?;
    let logs = archive.logs()?;
    let adjusted = adjusted(&archive, Wanted::default())?;
    tell(&adjusted);
    output::results(summary(&adjusted))?;
    let all: Vec<TileId> = contents(&archive)?.into_keys().collect();
    let is_due = |tile: &TileId| {
        tile_state(&archive, *tile, &logs, &adjusted.offsets) != TileState::UpToDate
    };
    let due: Vec<TileId> = all.iter().copied().filter(is_due).collect();
    make_maps(&archive, &due, &logs, &adjusted.offsets)?;
    for tile in remove_left_over(&archive, &all)? {
        output::results(format_args!("removed {tile}: no log has rows in it any more"))?;
    }
    write_index(&archive, &logs, &all)?;
    let progress = Progress::new();
    let status = StatusLine::at("map tiles", &progress);
    let joined = write_map_tiles(&archive, &all, &progress)?;
    drop(status);
    if joined == MapTilesState::Made {
        output::results(
            "joined the maps in map_tiles/index.html, depth.mbtiles, depth.pmtiles, depth_values.pmtiles",
        )?;
    }
    output::results(format_args!(
        "{} of {} made, the others are up to date; the index is index/depth_*.vrt, index/mosaic_*.vrt and index/collection.json",
        due.len(),
        text::plural(all.len(), "map", "maps")
    ))
}
