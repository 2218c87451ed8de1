//! `bathyscope tile`: the map of some tiles.

use super::{make_maps, tell_of_missing};
use crate::products::lake::{Lake, LakeError, Offsets, TileId};
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
    let logs = lake.logs_of_maps(&args.tiles).map_err(in_words)?;
    let offsets = Offsets::read(&lake).map_err(in_words)?;
    tell_of_missing(&offsets, &logs);
    let mut tiles = args.tiles.clone();
    tiles.sort_unstable();
    tiles.dedup();
    make_maps(&lake, &tiles, &logs, &offsets)
}
