//! Finds where the tracks of the logs of an archive cross or overlap, tile by tile.

use super::log_record::LogRecord;
use super::record::Archive;
use super::tile::TileId;
use super::{PINGS, POINTS, ping_rows, point_rows};
use crate::Error;
use bathyscope_bottom::bathymetry::DepthPoint;
use bathyscope_bottom::bathymetry::crosslines::TrackDepth;
use bathyscope_bottom::bathymetry::height_offsets::{
    FEW_CROSSINGS, LogOverlap, crossing_overlaps, overlaps,
};
use bathyscope_bottom::bathymetry::position_offsets::{FoundShift, Shift, shifted};
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// Returns the crossings of logs in all tiles and, for pairs of logs that hardly cross, the places
/// where their tracks overlap. The result is sorted by pair.
pub(super) fn log_overlaps(
    archive: &Archive,
    logs: &[LogRecord],
    shifts: &[FoundShift],
    progress: &Progress,
) -> Result<Vec<LogOverlap>, Error> {
    let shifts = shifts.iter().map(|found| found.shift).collect();
    let search = OverlapSearch::new(archive, logs, shifts, false, progress);
    let relabelled = |found: Vec<LogOverlap>, inside: &[usize]| -> Vec<LogOverlap> {
        let logs = |overlap: LogOverlap| LogOverlap {
            logs: overlap.logs.map(|track| inside[track]),
            ..overlap
        };
        found.into_iter().map(logs).collect()
    };
    let mut all = search.in_tiles(
        |_| true,
        |tracks, inside| {
            let found = crossing_overlaps(tracks, &Progress::new())?;
            Ok(relabelled(found, inside))
        },
        |overlap: &LogOverlap| overlap.place,
    )?;
    let mut counts: HashMap<[usize; 2], usize> = HashMap::new();
    for log_overlap in &all {
        *counts.entry(log_overlap.logs).or_default() += 1;
    }
    let is_few = |pair: [usize; 2]| counts.get(&pair).copied().unwrap_or(0) < FEW_CROSSINGS;
    let has_few = |inside: &[usize]| {
        let pairs = inside
            .iter()
            .enumerate()
            .flat_map(|(rank, first)| inside[rank + 1..].iter().map(|second| [*first, *second]));
        pairs.into_iter().any(is_few)
    };
    all.extend(search.in_tiles(
        has_few,
        |tracks, inside| {
            let is_wanted = |pair: &[usize; 2]| is_few(pair.map(|track| inside[track]));
            let found = overlaps(tracks, is_wanted, &Progress::new())?;
            Ok(relabelled(found, inside))
        },
        |overlap: &LogOverlap| overlap.place,
    )?);
    all.sort_by_key(|log_overlap| log_overlap.logs);
    Ok(all)
}

/// A search through the tiles that logs have rows in.
pub(super) struct OverlapSearch<'a> {
    archive: &'a Archive,
    logs: &'a [LogRecord],
    /// Correction of the positions of each log before the logs are compared.
    shifts: Vec<Shift>,
    /// The logs of each tile.
    tiles: BTreeMap<TileId, Vec<usize>>,
    progress: &'a Progress,
}

impl<'a> OverlapSearch<'a> {
    /// Creates a search through the tiles that have rows of several logs; with `with_alone` also
    /// through the tiles of a single log, which may cross itself.
    pub(super) fn new(
        archive: &'a Archive,
        logs: &'a [LogRecord],
        shifts: Vec<Shift>,
        with_alone: bool,
        progress: &'a Progress,
    ) -> Self {
        let mut tiles: BTreeMap<TileId, Vec<usize>> = BTreeMap::new();
        for (index, log) in logs.iter().enumerate() {
            for rows in &log.tiles {
                tiles.entry(rows.tile).or_default().push(index);
            }
        }
        tiles.retain(|_, inside| with_alone || inside.len() > 1);
        progress.start(2 * tiles.len() as u64);
        Self { archive, logs, shifts, tiles, progress }
    }

    /// Calls `find` with the tracks of the logs of every tile and the indices of these logs, and
    /// returns all results. Results in the halo of a tile are dropped, because the neighbouring
    /// tile finds them too.
    pub(super) fn in_tiles<T: Send>(
        &self,
        is_wanted: impl Fn(&[usize]) -> bool + Sync,
        find: impl Fn(&[Vec<TrackDepth>], &[usize]) -> Result<Vec<T>, Cancelled> + Sync,
        place: impl Fn(&T) -> [f64; 2] + Sync,
    ) -> Result<Vec<T>, Error> {
        let of_tile = |(tile, inside): (&TileId, &Vec<usize>)| {
            self.progress.check()?;
            self.progress.advance(1);
            if !is_wanted(inside) {
                return Ok(Vec::new());
            }
            let tracks = inside.iter().map(|log| {
                let track = track(self.archive, *tile, &self.logs[*log])?;
                let shift = self.shifts[*log];
                Ok(if shift == Shift::default() { track } else { shifted(&track, &shift) })
            });
            let tracks: Vec<Vec<TrackDepth>> = tracks.collect::<Result<_, Error>>()?;
            let mut found = find(&tracks, inside)?;
            found.retain(|item| tile.holds(place(item), 0.0));
            Ok(found)
        };
        let found = self.tiles.par_iter().map(of_tile);
        let found: Vec<Vec<T>> = found.collect::<Result<_, Error>>()?;
        Ok(found.into_iter().flatten().collect())
    }
}

/// Returns the depths under the boat of a log in a tile and its halo, by time: its soundings or, if
/// the log has none, the depths at its first returns.
fn track(archive: &Archive, tile: TileId, log: &LogRecord) -> Result<Vec<TrackDepth>, Error> {
    let Some(rows) = log.rows_in(tile) else {
        return Ok(Vec::new());
    };
    let path = |kind: &str| archive.rows_path(kind, tile, &log.log);
    if log.soundings > 0 && rows.points > 0 {
        let points = point_rows::read(&path(POINTS))?.into_iter();
        let soundings = points.filter(|row| row.is_under_boat);
        let depths = soundings.map(|row| {
            let DepthPoint { east_m, north_m, depth_m, .. } = row.depth;
            TrackDepth::new(row.time_s, [east_m, north_m], depth_m)
        });
        return Ok(depths.collect());
    }
    if log.soundings > 0 || rows.pings == 0 {
        return Ok(Vec::new());
    }
    let pings = ping_rows::read(&path(PINGS))?.into_iter();
    let near = pings.filter(|row| {
        tile.holds(row.footprint.place, archive.record.halo_m) && row.depth_m.is_finite()
    });
    Ok(near.map(|row| TrackDepth::new(row.time_s, row.footprint.place, row.depth_m)).collect())
}
