//! Computes the offsets between the logs of an archive: in height, from crossings and overlaps of
//! their tracks within tiles; on request also in position and latency; and, by `level_factors`, in
//! brightness of their echoes.

use super::level_factors::level_factors;
use super::log_overlaps::log_overlaps;
use super::log_record::LogRecord;
use super::offsets::{OffsetRow, Offsets, solve};
use super::positions::shifts;
use super::record::Archive;
use crate::Error;
use bathyscope_bottom::bathymetry::height_offsets::{HeightOffsets, PairDifference};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::support::statistics::median;
use std::collections::{BTreeMap, BTreeSet};

/// Change in metres below which the known offset of a log is kept: a log that is added must not
/// make every map stale for a centimetre or two.
const KEPT_M: f64 = 0.02;

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
