//! Commands about an archive of many logs: `tiles`, `tile`, `coverage`, `adjust`, `archive`.
//!
//! In: arguments of these commands. Out: files of the archive, and lines of text.

mod adjust;
mod build;
mod coverage;
mod tile;
mod tiles;

pub(crate) use adjust::AdjustArgs;
pub(crate) use adjust::run as run_adjust;
pub(crate) use build::ArchiveArgs;
pub(crate) use build::run as run_archive;
pub(crate) use coverage::CoverageArgs;
pub(crate) use coverage::run as run_coverage;
pub(crate) use tile::TileArgs;
pub(crate) use tile::run as run_tile;
pub(crate) use tiles::TilesArgs;
pub(crate) use tiles::run as run_tiles;

use crate::cli::parallel::each_in_parallel;
use crate::cli::status_line::StatusLine;
use crate::cli::{Failure, output};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::archive::{Archive, LogRecord, Offsets, TileId, TileRecord, write_tile};

/// Tiles of which each worker has one in memory.
const MOST_AT_ONCE: usize = 4;

/// Names logs that the table of offsets does not have, where there is one.
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

/// Makes the maps of some tiles and says what became of each.
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
