//! Offsets between the logs of an archive: in height, from crossings and overlaps of their tracks
//! within tiles; on request also in position and latency; and, by `level_factors`, in brightness of
//! their echoes.

use super::ArchiveError;
use super::level_factors::level_factors;
use super::log_overlaps::log_overlaps;
use super::log_record::LogRecord;
use super::offsets::{OffsetRow, Offsets, solve};
use super::positions::shifts;
use super::record::Archive;
use bathyscope_bottom::bathymetry::height_offsets::{HeightOffsets, PairDifference};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::statistics::median;
use std::collections::{BTreeMap, BTreeSet};

/// An offset that new logs move by less than this stays as it is, metres: a log that is added must
/// not make every map stale for a centimetre or two.
const KEPT_M: f64 = 0.02;

/// Result of an adjustment.
#[derive(Clone, Debug)]
pub struct Adjusted {
    /// The offsets, as written.
    pub offsets: Offsets,
    /// Groups of logs that are tied to each other.
    pub groups: usize,
    /// Pairs of logs whose difference no offset of whole logs explains: their names, and what is
    /// left of it, metres.
    pub contradictions: Vec<([String; 2], f64)>,
}

/// Finds the height offsets of all logs of an archive, the factors on their levels and, as far as
/// `wanted`, how their positions are to be corrected, and writes its table. Positions that are
/// corrected already stay so. Logs that a person has pinned keep theirs and are what the others are
/// compared against. Without any, the mean offset of tied logs is zero when they first cross; from
/// then on the logs that are known keep their heights, and new ones are compared with these.
///
/// # Errors
/// When rows or the table cannot be used, or the work was cancelled.
pub fn adjust(
    archive: &Archive,
    wanted: Wanted,
    progress: &Progress,
) -> Result<Adjusted, ArchiveError> {
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
    // Not those that were solved with: of pinned logs among each other there are none.
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
            shift: shifts[index].shift,
            shift_error_m: shifts[index].shift_error_m,
            latency_error_s: shifts[index].latency_error_s,
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

/// Groups of at least two logs.
fn groups(offsets: &Offsets) -> usize {
    let tied = offsets.rows().into_iter().filter(|row| row.ties > 0);
    tied.map(|row| row.group).collect::<BTreeSet<usize>>().len()
}

/// The offsets to apply: those of logs that are known already where they move by less than
/// [`KEPT_M`], or than two standard errors. A group that no pinned log holds is moved as a whole to
/// where the most of its known logs are.
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
            // NaN is no maximum.
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
