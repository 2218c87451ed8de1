//! `bathyscope tiles`: what exists of an archive.

use crate::cli::{Failure, output};
use bathyscope_bottom::presentation::text;
use bathyscope_products::archive::{Archive, Offsets, TileState, contents, tile_state};
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
pub(crate) fn run(args: &TilesArgs) -> Result<(), Failure> {
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
    let line = |one: &Printed| {
        format!(
            "{}  {}, {} of {} in it, {}: map {}",
            one.tile,
            text::plural(one.logs, "log", "logs"),
            text::count(one.core_points),
            text::plural(one.points, "point", "points"),
            text::plural(one.pings, "ping", "pings"),
            one.map
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
