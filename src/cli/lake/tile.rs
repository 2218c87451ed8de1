//! `bathyscope tile`: the map of some tiles.

use super::{MOST_AT_ONCE, of_tile, tell_of_missing};
use crate::cli::output;
use crate::cli::parallel::each_in_parallel;
use crate::cli::status_line::StatusLine;
use crate::lake::{Lake, LakeError, Offsets, TileId, write_tile};
use crate::progress::Progress;
use std::path::PathBuf;

/// `bathyscope tile DIR TILE...`.
#[derive(Debug, clap::Args)]
pub struct TileArgs {
    /// Folder of the lake
    lake: PathBuf,
    /// The tiles, as `bathyscope tiles` names them
    #[arg(required = true)]
    tiles: Vec<TileId>,
}

/// Makes the maps of the tiles, whether they are stale or not.
pub fn run(args: &TileArgs) -> Result<(), String> {
    let in_words = |error: LakeError| error.to_string();
    let lake = Lake::open(&args.lake).map_err(in_words)?;
    let logs = lake.logs_in(args.tiles.iter().copied()).map_err(in_words)?;
    let offsets = Offsets::read(&lake).map_err(in_words)?;
    tell_of_missing(&offsets, &logs);
    let mut tiles = args.tiles.clone();
    tiles.sort_unstable();
    tiles.dedup();
    let progress = Progress::new();
    let status = StatusLine::new(&progress);
    status.step("maps");
    progress.start(tiles.len() as u64);
    let done = each_in_parallel(&tiles, MOST_AT_ONCE, |tile| {
        let made = write_tile(&lake, *tile, &logs, &offsets, &Progress::new());
        progress.advance(1);
        made
    });
    drop(status);
    for (tile, made) in tiles.iter().zip(done) {
        output::results(format_args!(
            "wrote {}",
            of_tile(*tile, &made.map_err(in_words)?)
        ))?;
    }
    Ok(())
}
