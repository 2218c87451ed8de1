//! `bathyscope tile`: the map of some tiles.

use super::{make_maps, tell_of_missing};
use crate::products::archive::{Archive, ArchiveError, Offsets, TileId};
use std::path::PathBuf;

/// `bathyscope tile DIR TILE...`.
#[derive(Debug, clap::Args)]
pub struct TileArgs {
    /// Folder of the archive
    archive: PathBuf,
    /// The tiles, as `bathyscope tiles` names them
    #[arg(required = true)]
    tiles: Vec<TileId>,
}

/// Makes the maps of the tiles, whether they are stale or not.
pub fn run(args: &TileArgs) -> Result<(), String> {
    let in_words = |error: ArchiveError| error.to_string();
    let archive = Archive::open(&args.archive).map_err(in_words)?;
    let logs = archive.logs_of_maps(&args.tiles).map_err(in_words)?;
    let offsets = Offsets::read(&archive).map_err(in_words)?;
    tell_of_missing(&offsets, &logs);
    let mut tiles = args.tiles.clone();
    tiles.sort_unstable();
    tiles.dedup();
    make_maps(&archive, &tiles, &logs, &offsets)
}
