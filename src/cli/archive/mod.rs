//! Commands about an archive of many logs: `tiles`, `tile`, `coverage`, `adjust`, `archive`.
//!
//! In: arguments of these commands. Out: files of the archive, and lines of text.

mod adjust;
mod coverage;
mod tiles;

pub(crate) use adjust::AdjustArgs;
pub(crate) use adjust::run as run_adjust;
pub(crate) use coverage::CoverageArgs;
pub(crate) use coverage::run as run_coverage;
pub(crate) use tiles::{ArchiveArgs, TileArgs, TilesArgs, run_archive, run_tile, run_tiles};

use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Archive, LogRecord, Offsets, TileId, TileRecord, write_tile};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Most tiles that are in memory at the same time, one for each worker thread.
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
    let progress = Progress::new();
    let status = StatusLine::at("maps", &progress);
    progress.start(tiles.len() as u64);
    let done = each_in_parallel(tiles, MOST_AT_ONCE, |tile| {
        let made = write_tile(archive, *tile, logs, offsets, &Progress::new());
        progress.advance(1);
        made
    });
    drop(status);
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
/// `most`; the results are in the order of the things. The threads are not those of rayon: a rayon
/// thread that waits for a part of its own work would begin the next thing meanwhile. Here each
/// thread has never more than one thing in memory.
pub(super) fn each_in_parallel<T: Sync, R: Send>(
    things: &[T],
    most: usize,
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(things.len()));
    let worker = || {
        while let Some((index, thing)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            things.get(index).map(|thing| (index, thing))
        } {
            let result = work(thing);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    let processors = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        for _ in 0..processors.min(most).min(things.len()) {
            scope.spawn(worker);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_unstable_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_things() {
        let things: Vec<usize> = (0..500).collect();
        assert_eq!(each_in_parallel(&things, 4, |thing| thing * 2)[77], 154);
        assert!(each_in_parallel(&[] as &[u8], 4, |_| ()).is_empty());
    }
}
