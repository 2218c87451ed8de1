//! Commands about an archive of many logs: `tiles`, `tile`, `coverage`, `adjust`, `archive`.
//!
//! In: arguments of these commands. Out: files of the archive, and lines of text.

pub(super) mod adjust;
pub(super) mod coverage;

use super::status_line::StatusLine;
use super::{Failure, output};
use adjust::{adjusted, summary, tell};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{
    Archive, LogRecord, MapTilesState, Offsets, TileId, TileRecord, TileState, contents,
    remove_left_over, tile_state, write_index, write_map_tiles, write_tile,
};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Most tiles or logs that are in memory at the same time, one for each worker thread. More would
/// only need more memory, since the work on one of them is parallel, too.
const MOST_AT_ONCE: usize = 4;

/// Prints a warning that names the logs missing from the table of offsets; no warning if the table
/// is empty.
fn tell_of_missing(offsets: &Offsets, logs: &[LogRecord]) {
    let missing = offsets.missing(logs);
    if !offsets.rows().is_empty() && !missing.is_empty() {
        let names: Vec<&str> = missing.iter().map(|log| log.name.as_str()).collect();
        output::notify(format_args!(
            "warning: offsets.csv does not have {} yet, which stay as they are; `bathyscope adjust` finds their offsets",
            names.join(", ")
        ));
    }
}

/// Makes the maps of some tiles and prints the result for each tile.
fn make_maps(
    archive: &Archive,
    tiles: &[TileId],
    logs: &[LogRecord],
    offsets: &Offsets,
) -> Result<(), Failure> {
    let done = each_in_parallel("maps", tiles, |tile| {
        write_tile(archive, *tile, logs, offsets, &Progress::new())
    });
    for (tile, made) in tiles.iter().zip(done) {
        let record = made?;
        output::results(format_args!("wrote {}", of_tile(*tile, &record)))?;
    }
    Ok(())
}

/// Describes the maps made of a tile: cells, depths, isobaths and mosaic.
fn of_tile(tile: TileId, record: &TileRecord) -> String {
    let depths = match record.depth_m.as_slice() {
        [least_m, most_m] => format!(
            "{}, {least_m:.2} to {most_m:.2} m deep, {}",
            text::plural(record.cells, "cell", "cells"),
            text::plural(record.isobaths, "isobath", "isobaths")
        ),
        _ => "no depth in the tile itself".to_owned(),
    };
    let mosaic = match record.mosaic_cells {
        0 => "no mosaic".to_owned(),
        cells => format!("mosaic of {}", text::plural(cells, "cell", "cells")),
    };
    format!("{tile}: {depths}, {mosaic}")
}

/// Calls `work` on each of many things, on as many threads as there are processors and at most
/// [`MOST_AT_ONCE`], and shows the progress in a step of this name; the results are in the order of
/// the things. The threads are not those of rayon: a rayon thread that waits for a part of its own
/// work would begin the next thing meanwhile. Here each thread has never more than one thing in
/// memory.
pub(super) fn each_in_parallel<T: Sync, R: Send>(
    name: &str,
    things: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let status = StatusLine::at(name);
    status.progress.start(things.len() as u64);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(things.len()));
    let worker = || {
        while let Some((index, thing)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            things.get(index).map(|thing| (index, thing))
        } {
            let result = work(thing);
            status.progress.advance(1);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    let processors = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        for _ in 0..processors.min(MOST_AT_ONCE).min(things.len()) {
            scope.spawn(worker);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_unstable_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

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
    let status = StatusLine::at("map tiles");
    let joined = write_map_tiles(&archive, &all, &status.progress)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_things() {
        let things: Vec<usize> = (0..500).collect();
        assert_eq!(each_in_parallel("doubling", &things, |thing| thing * 2)[77], 154);
        assert!(each_in_parallel("nothing", &[] as &[u8], |_| ()).is_empty());
    }
}
