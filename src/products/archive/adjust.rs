//! Computes the offsets between the logs of an archive: in height, from crossings and overlaps of
//! their tracks within tiles; on request also in position and latency, from the crossings; and in
//! brightness of their echoes, from places that several parts of the mosaic show.

use super::log_mosaic::{in_words, open_part};
use super::log_record::LogRecord;
use super::offsets::{LevelFactor, OffsetRow, Offsets, as_written, solve};
use super::record::Archive;
use super::tile::TileId;
use super::{MOSAIC, PINGS, POINTS, ping_rows, point_rows};
use crate::Error;
use bathyscope_bottom::bathymetry::crosslines::{Crossing, TrackDepth, crossings};
use bathyscope_bottom::bathymetry::height_offsets::{
    FEW_CROSSINGS, HeightOffsets, LogOverlap, PairDifference, crossing_overlaps, overlaps,
};
use bathyscope_bottom::bathymetry::position_offsets::{
    CorrectedLog, FoundShift, Shift, Wanted, settled_offsets, shifted,
};
use bathyscope_bottom::bathymetry::{DepthPoint, Grid};
use bathyscope_bottom::mosaic::{Gain, LEVEL_CELL_M, level_differences, level_factor};
use bathyscope_log::formats::geotiff::RASTER_TILE;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Change in metres below which the known offset of a log is kept: a log that is added must not
/// make every map stale for a centimetre or two.
const KEPT_M: f64 = 0.02;
/// Change below which a known correction is kept, metres to the east or north, and seconds: a log
/// that is added must not make every map stale.
const KEPT_SHIFT_M: f64 = 0.1;
const KEPT_LATENCY_S: f64 = 0.05;

/// Result of an adjustment.
#[derive(Clone, Debug)]
pub struct Adjusted {
    /// The offsets, as written.
    pub offsets: Offsets,
    /// Groups of logs that are tied to each other.
    pub groups: usize,
    /// Pairs of logs whose difference no offset of whole logs explains: their names, and the
    /// difference that remains, metres.
    pub contradictions: Vec<([String; 2], f64)>,
}

/// Computes the height offsets of all logs of an archive, the factors on their levels and, as far
/// as `wanted`, the corrections of their positions, and writes the table of offsets. Known
/// corrections of positions are kept where new ones differ little. Logs that a person has pinned
/// keep their offsets, and the others are compared with them. Without a pinned log, the mean offset
/// of tied logs is zero when they first cross; from then on known logs keep their heights, and new
/// logs are compared with these.
///
/// # Errors
/// When the rows of a log or the table of offsets cannot be read or written, or the work was
/// cancelled.
pub fn adjust(archive: &Archive, wanted: Wanted, progress: &Progress) -> Result<Adjusted, Error> {
    let logs = archive.logs()?;
    let known = Offsets::read(archive)?;
    let levels = level_factors(archive, &logs, &known, progress)?;
    let pinned: Vec<Option<f64>> = logs
        .iter()
        .map(|log| known.row(&log.log).filter(|row| row.is_pinned).map(|row| row.offset_m))
        .collect();
    let shifts = shifts(archive, &logs, &known, &pinned, wanted, progress)?;
    let log_overlaps = log_overlaps(archive, &logs, &shifts, progress)?;
    let solved = solve(&log_overlaps, &pinned);
    let heights_m = kept_heights(&logs, &known, &solved, &pinned);
    // Counted here, because `solve` drops overlaps between two pinned logs.
    let mut ties = vec![0; logs.len()];
    for log in log_overlaps.iter().flat_map(|log_overlap| log_overlap.logs) {
        ties[log] += 1;
    }
    let rows = logs.iter().enumerate().map(|(index, log)| {
        let found = &solved.logs[index];
        let ties = ties[index];
        OffsetRow {
            name: log.name.clone(),
            log: log.log.clone(),
            offset_m: pinned[index].unwrap_or((heights_m[index] * 1e4).round() / 1e4),
            standard_error_m: match (pinned[index], ties) {
                (Some(_), _) => 0.0,
                (None, 0) => f64::NAN,
                (None, _) => found.standard_error_m,
            },
            ties,
            group: found.group,
            is_pinned: pinned[index].is_some(),
            found: shifts[index],
            level: levels[index],
        }
    });
    let offsets = Offsets::new(rows.collect());
    offsets.write(archive)?;
    let names = |pair: &PairDifference| {
        let names = pair.logs.map(|log| logs.get(log).map(|log| log.name.clone()));
        let [Some(one), Some(other)] = names else {
            return None;
        };
        Some(([one, other], pair.residual_m))
    };
    let contradictions = solved.pairs.iter().filter(|pair| pair.is_contradiction());
    Ok(Adjusted {
        groups: groups(&offsets),
        contradictions: contradictions.filter_map(names).collect(),
        offsets,
    })
}

/// Returns the number of groups of at least two tied logs.
fn groups(offsets: &Offsets) -> usize {
    let tied = offsets.rows().into_iter().filter(|row| row.ties > 0);
    tied.map(|row| row.group).collect::<BTreeSet<usize>>().len()
}

/// Returns the offsets to apply. A known log keeps its offset where the new one differs by less
/// than [`KEPT_M`], or by less than two standard errors. A group without a pinned log is first
/// moved as a whole to the height that most of its known logs have.
fn kept_heights(
    logs: &[LogRecord],
    known: &Offsets,
    solved: &HeightOffsets,
    pinned: &[Option<f64>],
) -> Vec<f64> {
    let held: Vec<Option<&OffsetRow>> = logs
        .iter()
        .map(|log| known.row(&log.log).filter(|row| row.ties > 0 && !row.is_pinned))
        .collect();
    let mut shifts_m: BTreeMap<usize, f64> = BTreeMap::new();
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (log, found) in solved.logs.iter().enumerate() {
        groups.entry(found.group).or_default().push(log);
    }
    for (group, members) in groups {
        if members.iter().any(|log| pinned[*log].is_some()) {
            continue;
        }
        let mut by_group: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for log in members {
            if let Some(row) = held[log] {
                let moved_m = row.offset_m - solved.logs[log].offset_m;
                by_group.entry(row.group).or_default().push(moved_m);
            }
        }
        let largest = by_group.into_values().reduce(|a, b| if b.len() > a.len() { b } else { a });
        shifts_m.insert(group, largest.map_or(0.0, |mut moved_m| median(&mut moved_m)));
    }
    let height_m = |log: usize| {
        let found = &solved.logs[log];
        let height_m = found.offset_m + shifts_m.get(&found.group).copied().unwrap_or(0.0);
        match held[log] {
            // `f64::max` ignores a standard error of NaN.
            Some(row)
                if (row.offset_m - height_m).abs() <= KEPT_M.max(2.0 * found.standard_error_m) =>
            {
                row.offset_m
            }
            _ => height_m,
        }
    };
    (0..logs.len()).map(height_m).collect()
}

/// Returns the corrections of the positions of the logs: those of the table and, as far as
/// `wanted`, those from crossings.
fn shifts(
    archive: &Archive,
    logs: &[LogRecord],
    known: &Offsets,
    pinned: &[Option<f64>],
    wanted: Wanted,
    progress: &Progress,
) -> Result<Vec<FoundShift>, Error> {
    let found_before =
        |log: &LogRecord| known.row(&log.log).map_or(FoundShift::NONE, |row| row.found);
    let before: Vec<FoundShift> = logs.iter().map(found_before).collect();
    if !wanted.is_anything() {
        return Ok(before);
    }
    let relabelled = |mut crossing: Crossing, inside: &[usize]| {
        for pass in &mut crossing.passes {
            pass.track = inside[pass.track];
        }
        crossing
    };
    let placed = before
        .iter()
        .zip(pinned)
        .map(|(before, pinned_m)| CorrectedLog { shift: before.shift, pinned_m: *pinned_m });
    let placed: Vec<CorrectedLog> = placed.collect();
    let found = settled_offsets(&placed, wanted, |placed| {
        let shifts = placed.iter().map(|placed| placed.shift).collect();
        let search = OverlapSearch::new(archive, logs, shifts, wanted.latencies, progress);
        let mut found = search.in_tiles(
            |_| true,
            |tracks, inside| {
                let found = crossings(tracks, &Progress::new())?.into_iter();
                Ok(found.map(|crossing| relabelled(crossing, inside)).collect())
            },
            |crossing: &Crossing| crossing.place,
        )?;
        found.sort_by_key(|crossing| crossing.passes.map(|pass| pass.track));
        Ok::<_, Error>(found)
    })?;
    let mut found = found.ok_or("the equations for the positions of the logs have no solution")?;
    for (found, before) in found.iter_mut().zip(&before) {
        found.shift = kept_shift(before, as_written(found.shift));
        found.keep_errors_of(before);
    }
    Ok(found)
}

/// Returns the known correction of positions if the new one differs little from it, otherwise the
/// new one.
fn kept_shift(known: &FoundShift, found: Shift) -> Shift {
    let is_known = !(known.shift_error_m.is_nan() && known.latency_error_s.is_nan());
    let [east_m, north_m, latency_s] = known.shift.values();
    let moved_m = (found.east_m - east_m).abs().max((found.north_m - north_m).abs());
    let is_near = moved_m <= KEPT_SHIFT_M && (found.latency_s - latency_s).abs() <= KEPT_LATENCY_S;
    if is_known && is_near { known.shift } else { found }
}

/// Returns the crossings of logs in all tiles and, for pairs of logs that hardly cross, the places
/// where their tracks overlap. The result is sorted by pair.
fn log_overlaps(
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
struct OverlapSearch<'a> {
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
    fn new(
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
    fn in_tiles<T: Send>(
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

/// Returns the factors of all logs. Known logs keep their factors, and new logs are matched to
/// them, so that an added log makes only the mosaics of its own tiles stale. All factors are 1
/// where the mosaic shows levels as recorded.
///
/// # Errors
/// When a part of the mosaic cannot be read, or the work was cancelled.
fn level_factors(
    archive: &Archive,
    logs: &[LogRecord],
    known: &Offsets,
    progress: &Progress,
) -> Result<Vec<LevelFactor>, Error> {
    if archive.record.settings()?.mosaic.gain == Gain::Recorded {
        return Ok(vec![LevelFactor::NONE; logs.len()]);
    }
    let held = |log: &LogRecord| {
        let row = known.row(&log.log)?;
        (row.is_pinned || row.level.ties > 0).then_some(row.level)
    };
    let held: Vec<Option<LevelFactor>> = logs.iter().map(held).collect();
    let mut tiles: BTreeMap<TileId, Vec<usize>> = BTreeMap::new();
    for (index, log) in logs.iter().enumerate() {
        for rows in log.tiles.iter().filter(|rows| rows.mosaic_cells > 0) {
            tiles.entry(rows.tile).or_default().push(index);
        }
    }
    tiles.retain(|_, inside| inside.len() > 1 && inside.iter().any(|log| held[*log].is_none()));
    let of_tile = |(tile, inside): (&TileId, &Vec<usize>)| {
        progress.check()?;
        let mut found = level_overlaps(archive, *tile, inside.iter().map(|log| &logs[*log]))?;
        for log_overlap in &mut found {
            log_overlap.logs = log_overlap.logs.map(|log| inside[log]);
        }
        Ok(found)
    };
    let found = tiles.par_iter().map(of_tile);
    let found: Vec<Vec<LogOverlap>> = found.collect::<Result<_, Error>>()?;
    let mut log_overlaps: Vec<LogOverlap> = found.into_iter().flatten().collect();
    log_overlaps.sort_by_key(|log_overlap| log_overlap.logs);
    let mut ties = vec![0; logs.len()];
    for log in log_overlaps.iter().flat_map(|log_overlap| log_overlap.logs) {
        ties[log] += 1;
    }
    let pinned: Vec<Option<f64>> =
        (held.iter()).map(|level| level.map(|level| level.factor.ln())).collect();
    let solved = solve(&log_overlaps, &pinned);
    let factor = |(log, held): (usize, &Option<LevelFactor>)| {
        held.unwrap_or_else(|| LevelFactor {
            factor: (1e3 * level_factor(solved.logs[log].offset_m)).round() / 1e3,
            ties: ties[log],
        })
    };
    Ok(held.iter().enumerate().map(factor).collect())
}

/// Returns the level differences where logs of a tile show the same place, in cells of about a
/// metre. The logs are named by their indices in `logs`.
fn level_overlaps<'a>(
    archive: &Archive,
    tile: TileId,
    logs: impl Iterator<Item = &'a LogRecord>,
) -> Result<Vec<LogOverlap>, Error> {
    let fine = archive.record.mosaic_grid(tile)?;
    let halvings = halvings(fine.cell_m, fine.columns);
    let cells = (0..halvings).fold(fine.columns, |cells, _| cells.div_ceil(2));
    let grid = Grid {
        cell_m: fine.cell_m * f64::from(1 << halvings),
        columns: cells,
        rows: cells,
        ..fine
    };
    let levels = logs.map(|log| {
        let (part, path) = open_part(archive, MOSAIC, tile, &log.log)?;
        let levels = part.overview(halvings);
        levels.map_err(|error| Error::from(in_words(&error, &path)))
    });
    let levels: Vec<Vec<u8>> = levels.collect::<Result<_, Error>>()?;
    Ok(level_differences(&levels, &grid))
}

/// Number of times that the raster is reduced to half its size so that its cells are about a metre;
/// at most the number of overviews that a raster of this many cells has.
fn halvings(cell_m: f64, cells: usize) -> usize {
    let wanted = (LEVEL_CELL_M / cell_m).log2().round().max(0.0) as usize;
    let there = (cells as f64 / RASTER_TILE as f64).log2().ceil().max(0.0) as usize;
    wanted.min(there)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_compared_in_cells_of_about_a_metre() {
        assert_eq!(
            [0.1, 0.125, 0.25, 0.5, 1.0, 2.0].map(|m| halvings(m, (512.0 / m) as usize)),
            [3, 3, 2, 1, 0, 0]
        );
    }
}
