//! Computes the height offsets between the depths of logs from places where logs cross or overlap.
//!
//! In: depths of several logs where these cross or overlap. Out: a height for each log, with its
//! standard error.
//!
//! Drafts, water levels and the recorders' own constants differ from log to log, and each moves all
//! depths of its log by the same height. Where two logs measured the same place their depths differ
//! by the difference of these heights, so all overlaps together give the height of every log,
//! except for a height that all logs share: the datum. `log_overlaps` finds the places. `network`
//! solves for the heights and, together with them, for the errors of position of each log, since
//! these change the depths on a slope. `depth_scales` finds logs whose depths differ by a share of
//! the depth instead.

mod depth_scales;
mod log_overlaps;
mod network;

pub use depth_scales::DepthScale;
pub use log_overlaps::{FEW_CROSSINGS, crossing_overlaps, log_overlaps, overlaps};
pub use network::adjust;
pub(super) use network::{difference_sigma_m, groups, robust_shares};

use super::crosslines::TrackDepth;
use bathyscope_log::support::progress::{Cancelled, Progress};
use depth_scales::depth_scales;
use serde::Serialize;

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
}
