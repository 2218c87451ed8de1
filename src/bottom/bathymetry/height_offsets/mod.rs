//! Computes the height offsets between the depths of logs from places where logs cross or overlap.
//!
//! In: depths of several logs where these cross or overlap. Out: a height for each log, with its
//! standard error.
//!
//! Drafts, water levels and the recorders' own constants differ from log to log, and each moves all
//! depths of its log by the same height. Where two logs measured the same place their depths differ
//! by the difference of these heights, so all overlaps together give the height of every log,
//! except for a height that all logs share: the datum. `network`
//! solves for the heights and, together with them, for the errors of position of each log, since
//! these change the depths on a slope. `depth_scales` finds logs whose depths differ by a share of
//! the depth instead.

mod depth_scales;
mod network;

pub use depth_scales::DepthScale;
pub use network::adjust;
pub(super) use network::{difference_sigma_m, groups, robust_shares};

use super::crosslines::{CrosslinePass, TrackDepth, crossings, velocity_mps};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{ends, median, median_of};
use depth_scales::depth_scales;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// Zero of the heights of the logs: the differences between logs do not determine a height that all
/// logs share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Datum {
    /// The mean of the offsets of connected logs is zero: no log is taken for better than another.
    #[default]
    Mean,
    /// The offset of this log is zero. Logs that are not connected with it have a mean of zero.
    Log(usize),
}

/// Kind of a place that two logs measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OverlapKind {
    /// The tracks of the logs cross.
    Crossing,
    /// The logs measured the same square metres without crossing, along the same line.
    Overlap,
}

/// A place that two logs measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogOverlap {
    /// Indices of the logs, the smaller first.
    pub logs: [usize; 2],
    /// Crossing or overlap.
    pub kind: OverlapKind,
    /// East and north, metres.
    pub place: [f64; 2],
    /// Depth there, the mean of both logs, metres; NaN where it is not known.
    pub depth_m: f64,
    /// Elevation by the second log minus that by the first, metres.
    pub difference_m: f64,
    /// Slope of the bottom, metres a metre, by which an error of position becomes one of depth. NaN
    /// where it is not known.
    pub slope: f64,
    /// Increase of the depth per metre to the east and to the north, metres; NaN where the
    /// direction of the slope is not known.
    pub gradient: [f64; 2],
    /// Time at which each log began the line on which it measured the place, whole seconds: the
    /// errors of overlaps on one line are alike. `None` where the lines are not known.
    pub lines: Option<[i64; 2]>,
}

impl LogOverlap {
    /// Creates an overlap whose depth, lines and direction of the slope are not known.
    pub fn new(
        logs: [usize; 2],
        kind: OverlapKind,
        place: [f64; 2],
        difference_m: f64,
        slope: f64,
    ) -> Self {
        Self {
            logs,
            kind,
            place,
            depth_m: f64::NAN,
            difference_m,
            slope,
            gradient: [f64::NAN; 2],
            lines: None,
        }
    }

    /// Returns true if the direction of the slope is known.
    fn has_gradient(&self) -> bool {
        self.gradient.iter().all(|slope| slope.is_finite())
    }
}

/// The height offset of a log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogOffset {
    /// Height to be added to every elevation of the log, metres, so that it agrees with the others;
    /// 0 for a log that crosses and overlaps no other, or whose overlaps do not determine it.
    pub offset_m: f64,
    /// Standard error of the offset against the datum, metres; NaN where the offset is not
    /// determined.
    pub standard_error_m: f64,
    /// Number of the group of the log. Overlaps connect the logs of a group; groups are numbered in
    /// the order of their first logs. Heights of different groups cannot be compared.
    pub group: usize,
    /// Number of crossings and overlaps of the log with others.
    #[serde(rename = "meetings")]
    pub log_overlaps: usize,
}

impl LogOffset {
    /// Returns true if overlaps determine the offset.
    pub fn is_determined(&self) -> bool {
        self.standard_error_m.is_finite()
    }

    /// Returns the offset as it is applied, metres: rounded to the tenth of a millimetre, since it
    /// is written to records and is not known any better.
    pub fn applied_m(&self) -> f64 {
        (self.offset_m * 1e4).round() / 1e4
    }
}

/// Difference in height between two logs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairDifference {
    /// Indices of the logs, the smaller first.
    pub logs: [usize; 2],
    /// Crossing or overlap.
    pub kind: OverlapKind,
    /// Number of places where the logs cross or overlap.
    pub n: usize,
    /// Median elevation by the second log minus that by the first, metres.
    pub difference_m: f64,
    /// Robust standard deviation (1.4826 MAD) of the differences, metres; NaN for fewer than two.
    pub spread_m: f64,
    /// Standard error of the median, metres.
    pub standard_error_m: f64,
    /// Remainder of the median once the offsets of both logs are applied, metres.
    pub residual_m: f64,
}

/// Least remaining difference between two logs that is worth a warning, metres and standard errors:
/// errors of a crossing are not quite independent, so fewer standard errors would warn of surveys
/// that are sound.
const CONTRADICTION_M: f64 = 0.05;
const CONTRADICTION_SIGMAS: f64 = 5.0;

impl PairDifference {
    /// Returns true if no offset of whole logs explains the difference: the logs measured other
    /// ground, the bottom moved, or a clock or water level is wrong.
    pub fn is_contradiction(&self) -> bool {
        let left_m = self.residual_m.abs();
        left_m > CONTRADICTION_M && left_m > CONTRADICTION_SIGMAS * self.standard_error_m
    }
}

/// Height offsets of all logs, and the differences that they come from.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HeightOffsets {
    /// Offset of each log.
    pub logs: Vec<LogOffset>,
    /// Every pair of logs that cross or overlap, in order.
    pub pairs: Vec<PairDifference>,
    /// Pairs of logs whose depths differ by a share of the depth.
    pub scales: Vec<DepthScale>,
}

/// Least difference of heights that is worth a warning, metres: drafts and water levels are not
/// known any better.
const LEVEL_M: f64 = 0.02;
/// Number of standard errors above which a difference of heights is not chance.
const LEVEL_SIGMAS: f64 = 3.0;

/// Two logs whose depths differ where they cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightDifference {
    /// Index of the log whose depths are deeper, and of the other.
    pub logs: [usize; 2],
    /// Size of the difference, metres.
    pub difference_m: f64,
    /// Standard error of the difference, metres.
    pub standard_error_m: f64,
}

impl HeightOffsets {
    /// Returns the two logs whose depths differ the most, beyond the error of the difference, once
    /// the offsets `in_force_m` (metres) are applied to them; `None` where all logs agree, or their
    /// overlaps do not determine the difference.
    pub fn unlevelled(&self, in_force_m: &[f64]) -> Option<HeightDifference> {
        let logs = self.logs.iter().zip(in_force_m).enumerate();
        let known: Vec<(usize, &LogOffset, f64)> = logs
            .filter(|(_, (log, _))| log.is_determined())
            .map(|(index, (log, in_force_m))| (index, log, log.offset_m - in_force_m))
            .collect();
        let ends = |group: usize| {
            let inside = || known.iter().filter(move |(_, log, _)| log.group == group);
            let deeper = inside().max_by(|a, b| a.2.total_cmp(&b.2))?;
            let other = inside().min_by(|a, b| a.2.total_cmp(&b.2))?;
            Some(HeightDifference {
                logs: [deeper.0, other.0],
                difference_m: deeper.2 - other.2,
                // Both offsets count from one datum, so that their errors may have opposite signs.
                standard_error_m: deeper.1.standard_error_m + other.1.standard_error_m,
            })
        };
        let differences = (0..self.groups()).filter_map(ends).filter(|found| {
            found.difference_m > LEVEL_M
                && found.difference_m > LEVEL_SIGMAS * found.standard_error_m
        });
        differences.max_by(|a, b| a.difference_m.total_cmp(&b.difference_m))
    }

    /// Adds a height in metres to the offsets of a log and of all logs that are connected with it.
    pub fn raise(&mut self, log: usize, by_m: f64) {
        let group = self.logs.get(log).map(|log| log.group);
        let connected = self.logs.iter_mut().filter(|log| Some(log.group) == group);
        connected.filter(|log| log.is_determined()).for_each(|log| log.offset_m += by_m);
    }

    /// Returns the number of groups of connected logs; heights can be compared within a group only.
    pub fn groups(&self) -> usize {
        self.logs.iter().map(|log| log.group + 1).max().unwrap_or(0)
    }
}

/// Finds where logs cross or overlap and solves for their heights. `tracks` holds the depths under
/// the boat of every log in time order, all in one plane, corrected for what is known.
///
/// # Errors
/// When the work was cancelled.
pub fn height_offsets(
    tracks: &[Vec<TrackDepth>],
    datum: Datum,
    progress: &Progress,
) -> Result<HeightOffsets, Cancelled> {
    let log_overlaps = log_overlaps(tracks, progress)?;
    let scales = depth_scales(&log_overlaps);
    Ok(HeightOffsets { scales, ..adjust(tracks.len(), &log_overlaps, datum) })
}

/// Number of crossings below which two logs are also compared where they run along each other.
pub const FEW_CROSSINGS: usize = 3;
/// Side of the squares in which the depths of two logs are compared, metres.
const SQUARE_M: f64 = 1.0;
/// Indices of two logs, and a block of squares.
type PairBlock = ([usize; 2], [i64; 2]);
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
    let mut blocks: BTreeMap<PairBlock, Vec<[f64; 2]>> = BTreeMap::new();
    for (square, logs) in &squares {
        let block = square.map(|index| index.div_euclid(BLOCK_SQUARES));
        for (rank, &(first, first_m)) in logs.iter().enumerate() {
            let others = logs[rank + 1..].iter();
            for &(second, second_m) in others.filter(|(second, _)| is_wanted(&[first, *second])) {
                blocks.entry(([first, second], block)).or_default().push([first_m, second_m]);
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

fn log_overlap(logs: [usize; 2], block: [i64; 2], shared: &[[f64; 2]]) -> LogOverlap {
    let side_m = BLOCK_SQUARES as f64 * SQUARE_M;
    let [least, most] = ends(shared.iter().map(|[first_m, _]| *first_m));
    LogOverlap::new(
        logs,
        OverlapKind::Overlap,
        block.map(|index| (index as f64 + 0.5) * side_m),
        median_of(shared.iter().map(|[first_m, second_m]| first_m - second_m)),
        (most - least) / side_m,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_logs_contradict_each_other_beyond_their_scatter_only() {
        let pair = |residual_m: f64, standard_error_m: f64| PairDifference {
            logs: [0, 1],
            kind: OverlapKind::Crossing,
            n: 9,
            difference_m: residual_m,
            spread_m: 3.0 * standard_error_m,
            standard_error_m,
            residual_m,
        };
        assert!(pair(-0.27, 0.03).is_contradiction());
        assert!(!pair(0.04, 0.001).is_contradiction(), "too little to matter");
        assert!(!pair(0.27, 0.06).is_contradiction(), "its overlaps scatter");
    }

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
