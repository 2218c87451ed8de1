//! Finds the places that two logs measured.

use super::{LogOverlap, OverlapKind};
use crate::bathymetry::crosslines::{CrosslinePass, TrackDepth, crossings, velocity_mps};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{ends, median};
use std::collections::{BTreeMap, HashMap};

/// Number of crossings below which two logs are also compared where they run along each other.
pub const FEW_CROSSINGS: usize = 3;
/// Side of the squares in which the depths of two logs are compared, metres.
const SQUARE_M: f64 = 1.0;
/// Side of a block in squares, and the fewest squares of a block that both logs measured: the
/// errors of neighbouring squares are alike, so that a block gives one difference.
const BLOCK_SQUARES: i64 = 10;
const LEAST_SQUARES: usize = 3;

/// Change of course that ends a line and begins another, degrees from the course at the start of
/// the line.
const LINE_TURN_DEG: f64 = 45.0;

/// Returns the crossings between logs and, for pairs of logs with fewer than three crossings, the
/// blocks of 10 m in which both measured the same squares of 1 m. The places are sorted by pair.
///
/// # Errors
/// When the work was cancelled.
pub fn log_overlaps(
    tracks: &[Vec<TrackDepth>],
    progress: &Progress,
) -> Result<Vec<LogOverlap>, Cancelled> {
    let mut log_overlaps = crossing_overlaps(tracks, progress)?;
    let mut counts: HashMap<[usize; 2], usize> = HashMap::new();
    for log_overlap in &log_overlaps {
        *counts.entry(log_overlap.logs).or_default() += 1;
    }
    let few = |logs: &[usize; 2]| counts.get(logs).copied().unwrap_or(0) < FEW_CROSSINGS;
    log_overlaps.extend(overlaps(tracks, few, progress)?);
    log_overlaps.sort_by_key(|log_overlap| log_overlap.logs);
    Ok(log_overlaps)
}

/// Returns the crossings between logs, in the order of their first pass.
///
/// # Errors
/// When the work was cancelled.
pub fn crossing_overlaps(
    tracks: &[Vec<TrackDepth>],
    progress: &Progress,
) -> Result<Vec<LogOverlap>, Cancelled> {
    let found = crossings(tracks, progress)?;
    let between =
        found.iter().filter(|crossing| crossing.passes[0].track != crossing.passes[1].track);
    let lines: Vec<Vec<f64>> = tracks.iter().map(|track| line_starts_s(track)).collect();
    let line = |pass: CrosslinePass| {
        let before = tracks[pass.track].partition_point(|depth| depth.time_s <= pass.time_s);
        lines[pass.track][before.saturating_sub(1)].floor() as i64
    };
    let log_overlaps = between.map(|crossing| {
        let logs = crossing.passes.map(|pass| pass.track);
        let (place, difference_m) = (crossing.place, crossing.difference_m());
        LogOverlap {
            depth_m: 0.5 * (crossing.passes[0].depth_m + crossing.passes[1].depth_m),
            gradient: crossing.gradient,
            lines: Some(crossing.passes.map(line)),
            ..LogOverlap::new(logs, OverlapKind::Crossing, place, difference_m, crossing.slope())
        }
    });
    Ok(log_overlaps.collect())
}

/// Returns the time at which the line of each depth of a track began, seconds: a line is a stretch
/// of about one course, along which the errors of positions are alike.
fn line_starts_s(track: &[TrackDepth]) -> Vec<f64> {
    let mut line: Option<(f64, [f64; 2])> = None;
    let starts = track.iter().enumerate().map(|(index, depth)| {
        let now = velocity_mps(track, index);
        let turned = |course: [f64; 2]| {
            let sizes = course[0].hypot(course[1]) * now[0].hypot(now[1]);
            let cos = (course[0] * now[0] + course[1] * now[1]) / sizes;
            // NaN for a boat at rest.
            cos < LINE_TURN_DEG.to_radians().cos()
        };
        if line.is_none_or(|(_, course)| course == [0.0; 2] || turned(course)) {
            line = Some((depth.time_s, now));
        }
        line.map_or(depth.time_s, |(start_s, _)| start_s)
    });
    starts.collect()
}

/// Square that two logs measured: the depth by the first log, and the elevation by the second log
/// minus that by the first.
struct Shared {
    depth_m: f64,
    difference_m: f64,
}

/// Returns the blocks of 10 m in which two logs measured the same squares of 1 m, for the pairs of
/// logs for which `is_wanted` is true, in the order of the pairs.
///
/// # Errors
/// When the work was cancelled.
pub fn overlaps(
    tracks: &[Vec<TrackDepth>],
    is_wanted: impl Fn(&[usize; 2]) -> bool,
    progress: &Progress,
) -> Result<Vec<LogOverlap>, Cancelled> {
    let mut squares: BTreeMap<[i64; 2], Vec<(usize, f64)>> = BTreeMap::new();
    for (log, depths) in tracks.iter().enumerate() {
        progress.check()?;
        for (square, depth_m) in by_square(depths) {
            squares.entry(square).or_default().push((log, depth_m));
        }
    }
    let mut blocks: BTreeMap<([usize; 2], [i64; 2]), Vec<Shared>> = BTreeMap::new();
    for (square, logs) in &squares {
        let block = square.map(|index| index.div_euclid(BLOCK_SQUARES));
        for (rank, &(first, first_m)) in logs.iter().enumerate() {
            let others = logs[rank + 1..].iter();
            for &(second, second_m) in others.filter(|(second, _)| is_wanted(&[first, *second])) {
                let shared = Shared { depth_m: first_m, difference_m: first_m - second_m };
                blocks.entry(([first, second], block)).or_default().push(shared);
            }
        }
    }
    let enough = blocks.iter().filter(|(_, shared)| shared.len() >= LEAST_SQUARES);
    Ok(enough.map(|((logs, block), shared)| log_overlap(*logs, *block, shared)).collect())
}

/// Returns the median depth of each square of a log.
fn by_square(depths: &[TrackDepth]) -> BTreeMap<[i64; 2], f64> {
    let mut squares: BTreeMap<[i64; 2], Vec<f64>> = BTreeMap::new();
    for depth in depths {
        let square = [depth.east_m, depth.north_m].map(|metres| (metres / SQUARE_M).floor() as i64);
        squares.entry(square).or_default().push(depth.depth_m);
    }
    let medians = squares.into_iter();
    medians.map(|(square, mut depths)| (square, median(&mut depths))).collect()
}

fn log_overlap(logs: [usize; 2], block: [i64; 2], shared: &[Shared]) -> LogOverlap {
    let side_m = BLOCK_SQUARES as f64 * SQUARE_M;
    let mut differences: Vec<f64> = shared.iter().map(|square| square.difference_m).collect();
    let [least, most] = ends(shared.iter().map(|square| square.depth_m));
    LogOverlap::new(
        logs,
        OverlapKind::Overlap,
        block.map(|index| (index as f64 + 0.5) * side_m),
        median(&mut differences),
        (most - least) / side_m,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(north_m: f64, raised_m: f64) -> Vec<TrackDepth> {
        (0..600)
            .map(|index| {
                let way_m = 0.1 * f64::from(index);
                let depth_m = 3.0 + 0.02 * 0.1 * f64::from(index) - raised_m;
                TrackDepth::new(way_m, [way_m, north_m], depth_m)
            })
            .collect()
    }

    #[test]
    fn logs_along_the_same_line_meet_although_they_never_cross() {
        let tracks = [line(0.2, 0.0), line(0.7, 0.15), line(20.0, 0.5)];
        let found = log_overlaps(&tracks, &Progress::new()).unwrap();
        assert_eq!(found.len(), 6, "{found:?}");
        for log_overlap in found {
            assert_eq!(log_overlap.logs, [0, 1]);
            assert_eq!(log_overlap.kind, OverlapKind::Overlap);
            assert!((log_overlap.difference_m - 0.15).abs() < 1e-9, "{log_overlap:?}");
            assert!((log_overlap.slope - 0.02).abs() < 0.005, "{log_overlap:?}");
        }
    }

    #[test]
    fn a_line_ends_where_the_boat_turns() {
        // East for 60 s at a metre a second, then north.
        let track: Vec<TrackDepth> = (0..120)
            .map(|second| {
                let place = [second.min(60), (second - 60).max(0)].map(f64::from);
                TrackDepth::new(f64::from(second), place, 3.0)
            })
            .collect();
        let starts_s = line_starts_s(&track);
        assert_eq!([starts_s[0], starts_s[58]], [0.0; 2]);
        assert!((starts_s[119] - 61.0).abs() <= 1.0, "{starts_s:?}");
        assert_eq!(starts_s[62], starts_s[119]);
    }
}
