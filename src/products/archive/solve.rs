//! Offsets of logs from where they overlap, some of them pinned.

use bathyscope_bottom::bathymetry::height_offsets as solver;
use bathyscope_bottom::bathymetry::height_offsets::{Datum, HeightOffsets, LogOverlap};

/// The offsets that the overlaps give. Logs that are pinned are taken together as one more log,
/// whose offset is zero: an overlap with one of them is one with that, its difference corrected by
/// the offset that is pinned.
pub(super) fn solve(log_overlaps: &[LogOverlap], pinned: &[Option<f64>]) -> HeightOffsets {
    let count = pinned.len();
    if pinned.iter().all(Option::is_none) {
        return solver::adjust(count, log_overlaps, Datum::Mean);
    }
    let of = |log: usize| pinned.get(log).copied().flatten();
    let held = log_overlaps.iter().filter_map(|log_overlap| {
        let [first, second] = log_overlap.logs;
        let (logs, difference_m, lines) = match (of(first), of(second)) {
            (None, None) => (log_overlap.logs, log_overlap.difference_m, log_overlap.lines),
            (None, Some(offset_m)) => {
                ([first, count], log_overlap.difference_m + offset_m, log_overlap.lines)
            }
            (Some(offset_m), None) => (
                [second, count],
                offset_m - log_overlap.difference_m,
                log_overlap.lines.map(|[first, second]| [second, first]),
            ),
            (Some(_), Some(_)) => return None,
        };
        Some(LogOverlap { logs, difference_m, lines, ..*log_overlap })
    });
    let mut held: Vec<LogOverlap> = held.collect();
    held.sort_by_key(|log_overlap| log_overlap.logs);
    let mut solved = solver::adjust(count + 1, &held, Datum::Log(count));
    let benchmark = solved.logs.pop().map_or(0, |log| log.group);
    for (log, offset) in solved.logs.iter_mut().enumerate() {
        if of(log).is_some() {
            offset.group = benchmark;
        }
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::bathymetry::height_offsets::OverlapKind;

    fn log_overlap(logs: [usize; 2], heights_m: [f64; 2]) -> LogOverlap {
        let difference_m = heights_m[0] - heights_m[1];
        LogOverlap::new(logs, OverlapKind::Crossing, [0.0; 2], difference_m, 0.0)
    }

    #[test]
    fn pinned_logs_hold_the_others_and_each_other() {
        // True offsets of five logs, of which the first and the last are pinned 10 cm away from
        // where the overlaps have them, and the fourth crosses nobody.
        let true_m = [0.3, -0.2, 0.5, 0.0, 0.1];
        let pairs = [[0, 1], [1, 2], [2, 4], [0, 4]];
        let log_overlaps: Vec<LogOverlap> = pairs
            .iter()
            .flat_map(|[a, b]| [log_overlap([*a, *b], [true_m[*a], true_m[*b]]); 5])
            .collect();
        let pinned = [Some(0.4), None, None, None, Some(0.2)];
        let solved = solve(&log_overlaps, &pinned);
        for (log, offset_m) in [(1, -0.1), (2, 0.6)] {
            assert!((solved.logs[log].offset_m - offset_m).abs() < 1e-9, "{solved:?}");
            assert_eq!(solved.logs[log].group, solved.logs[0].group);
        }
        assert_eq!(solved.logs[4].group, solved.logs[0].group);
        assert_ne!(solved.logs[3].group, solved.logs[0].group);
        assert_eq!(solved.logs.len(), 5);
    }
}
