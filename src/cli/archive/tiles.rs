//! `bathyscope tiles`, `tile` and `archive`: list the tiles of an archive, make the maps of some
//! tiles, and bring the whole archive up to date.

use super::adjust::{adjusted, summary, tell};
use super::{make_maps, tell_of_missing};
use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{
    Archive, MapTilesState, Offsets, TileId, TileState, contents, remove_left_over, tile_state,
    write_index, write_map_tiles,
};
use serde::Serialize;
use std::path::PathBuf;

/// `bathyscope tiles DIR`.
#[derive(Debug, clap::Args)]
pub(crate) struct TilesArgs {
    /// Folder of the archive
    archive: PathBuf,
    /// List only tiles whose map is stale or missing
    #[arg(long)]
    stale: bool,
    /// Print JSON for scripts
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Printed {
    tile: String,
    logs: usize,
    points: usize,
    core_points: usize,
    pings: usize,
    map: &'static str,
}

/// Prints a line for each tile.
pub(crate) fn run_tiles(args: &TilesArgs) -> Result<(), Failure> {
    let archive = Archive::open(&args.archive)?;
    let logs = archive.logs()?;
    let offsets = Offsets::read(&archive)?;
    let tiles = contents(&archive)?;
    let all = tiles.len();
    let mut printed = Vec::new();
    for (tile, content) in tiles {
        let state = tile_state(&archive, tile, &logs, &offsets);
        if !args.stale || state != TileState::UpToDate {
            printed.push(Printed {
                tile: tile.to_string(),
                logs: content.logs,
                points: content.points,
                core_points: content.core_points,
                pings: content.pings,
                map: state.in_words(),
            });
        }
    }
    if args.json {
        return output::json(&printed);
    }
    let line = |row: &Printed| {
        format!(
            "{}  {}, {} of {} in it, {}: map {}",
            row.tile,
            text::plural(row.logs, "log", "logs"),
            text::count(row.core_points),
            text::plural(row.points, "point", "points"),
            text::plural(row.pings, "ping", "pings"),
            row.map
        )
    };
    let mut lines: Vec<String> = printed.iter().map(line).collect();
    lines.push(format!(
        "{} of {}, {} listed",
        text::plural(all, "tile", "tiles"),
        text::plural(logs.len(), "log", "logs"),
        printed.len()
    ));
    output::results(lines.join("\n"))
}

/// `bathyscope tile DIR TILE...`.
#[derive(Debug, clap::Args)]
pub(crate) struct TileArgs {
    /// Folder of the archive
    archive: PathBuf,
    /// The tiles, as `bathyscope tiles` names them
    #[arg(required = true)]
    tiles: Vec<TileId>,
}

/// Makes the maps of the tiles, even if they are up to date.
pub(crate) fn run_tile(args: &TileArgs) -> Result<(), Failure> {
    let archive = Archive::open(&args.archive)?;
    let logs = archive.logs_of_maps(&args.tiles)?;
    let offsets = Offsets::read(&archive)?;
    tell_of_missing(&offsets, &logs);
    let mut tiles = args.tiles.clone();
    tiles.sort_unstable();
    tiles.dedup();
    make_maps(&archive, &tiles, &logs, &offsets)
}

/// `bathyscope archive DIR`.
#[derive(Debug, clap::Args)]
pub(crate) struct ArchiveArgs {
    /// Folder of the archive
    archive: PathBuf,
}

/// Finds the offsets, makes the maps that are stale or missing, and writes the index of all tiles.
pub(crate) fn run_archive(args: &ArchiveArgs) -> Result<(), Failure> {
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
