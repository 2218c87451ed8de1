//! `bathyscope tile`: the map of some tiles.

use super::{make_maps, tell_of_missing};
use crate::cli::Failure;
use bathyscope_products::archive::{Archive, Offsets, TileId};
use std::path::PathBuf;

/// `bathyscope tile DIR TILE...`.
#[derive(Debug, clap::Args)]
pub(crate) struct TileArgs {
    /// Folder of the archive
    archive: PathBuf,
    /// The tiles, as `bathyscope tiles` names them
    #[arg(required = true)]
    tiles: Vec<TileId>,
}

/// Makes the maps of the tiles, whether they are stale or not.
pub(crate) fn run(args: &TileArgs) -> Result<(), Failure> {
    let archive = Archive::open(&args.archive)?;
    let logs = archive.logs_of_maps(&args.tiles)?;
    let offsets = Offsets::read(&archive)?;
    tell_of_missing(&offsets, &logs);
    let mut tiles = args.tiles.clone();
    tiles.sort_unstable();
    tiles.dedup();
    make_maps(&archive, &tiles, &logs, &offsets)
}
