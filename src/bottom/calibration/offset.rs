//! Finds the constant between first-return ranges and recorded depths, and decides whether it may
//! be subtracted from the ranges.
//!
//! The differences that an instrument causes are small and the same at every depth: the length of
//! the pulse's leading edge, the receiver's filter, a draft or keel offset that went into the
//! depths only. A difference that is larger, grows with the depth or varies from one stretch of the
//! log to the next has another cause: soundings of another bottom, a scale that is off, wrong
//! picks.

use super::scale::Usable;
use bathyscope_log::support::statistics::{MEDIAN_ERROR, median, median_of, spread_about};
use bathyscope_log::survey::Side;

/// Number of pings that are evaluated together: long enough to quiet the noise of the recorded
/// depth, short against slopes.
const BLOCK_PINGS: usize = 24;
/// Fewest picks on each side of a block.
const MIN_PICKS: usize = 8;
/// Fewest blocks that an offset is based on.
const MIN_BLOCKS: usize = 4;

/// Largest offset that an instrument causes: a pulse of a few hundred microseconds or a draft,
/// metres, and the receiver's and the detector's filters, samples.
const MOST_M: f64 = 0.25;
const MOST_SAMPLES: f64 = 3.0;
/// Largest offset of an edge that its pulse and the filters alone cause, early and late, metres and
/// samples. A larger one could also be a share of the depth, so the log must show that it is not.
const EARLY_M: f64 = 0.10;
const EARLY_SAMPLES: f64 = 1.5;
const LATE_M: f64 = 0.01;
const LATE_SAMPLES: f64 = 0.5;
/// Largest error of an offset that is still better than none, metres.
pub(super) const TOLERANCE_M: f64 = 0.04;
/// Largest change of an offset over the depth of the log, where the offset is more than an edge
/// causes, and largest uncertainty of this change, metres: with these limits none of 240 simulated
/// logs gets a wrong offset, and the river of the tests, whose recorder rounds depths to 0.1 m,
/// keeps its offset.
const MOST_DRIFT_M: f64 = 0.07;
const MOST_UNCERTAIN_M: f64 = 0.10;
/// Largest change of the recorded depth from the first half of a block to the second, and largest
/// difference of its two sides, as shares of the depth, at which the ground is level: soundings
/// that are late, and those of a wide beam, are then off by less than this.
const LEVEL_ALONG: f64 = 0.01;
const LEVEL_ACROSS: f64 = 0.005;
/// Largest share of the deeper side's picks in a block that may be flagged as an above-bottom
/// return: where there are more, the first return is not the bottom. The picks of the other blocks
/// count, flagged or not: to leave flagged ones out would select the late ones.
const MOST_FLAGGED: f64 = 0.4;
/// Least share of the blocks that support an offset: with fewer, it is an accident which ones they
/// are.
const MIN_SHARE: f64 = 0.2;
/// Least scatter of blocks, metres, and the number of blocks that counts as a handful.
const LEAST_SCATTER_M: f64 = 0.01;
const HANDFUL: f64 = 4.0;

/// Constant between first-return ranges and recorded depths, as a log shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeOffset {
    /// Excess of ranges over recorded depths, metres; negative when first returns are found early.
    pub offset_m: f64,
    /// Error of the offset from the scatter of its blocks, metres (two standard errors).
    pub uncertainty_m: f64,
    /// Number of blocks of pings that the offset is based on.
    pub blocks: usize,
    /// Share of the blocks at recorded depths that the offset is based on, 0 to 1: the others are
    /// above-bottom returns.
    pub share: f64,
    /// Median recorded depth of the blocks, metres.
    pub depth_m: f64,
    /// Slope of range against depth over the same blocks; NaN where the depths do not vary.
    pub k: f64,
    /// Error of the slope from the scatter (two standard errors), and from late soundings; infinite
    /// where the depths do not vary.
    pub k_uncertainty: f64,
    /// Largest part of the slope that the noise of the recorded depths may take away.
    pub k_attenuation: f64,
}

/// Returns the picks, which are in ping order, in blocks of pings.
pub(super) fn blocks(picks: &[Usable]) -> impl Iterator<Item = &[Usable]> {
    picks.chunk_by(|a, b| a.ping / BLOCK_PINGS == b.ping / BLOCK_PINGS)
}

impl RangeOffset {
    /// Returns the offset that the picks at recorded depths, flagged or not, show; `None` where no
    /// stretch has enough of them on both sides. `sample_m` is the range of one sample.
    ///
    /// The offset is that of all blocks, or of those over level ground alone in two cases:
    /// soundings are late, or there is an objection to the offset of all blocks and level ground at
    /// several depths shows one offset. Soundings that are late, or have a wide beam, are right
    /// over level ground.
    pub(super) fn of(picks: &[Usable], sample_m: f64, are_late: bool) -> Option<Self> {
        let all = Self::over(None, picks)?;
        if !are_late && all.objection(sample_m).is_none() {
            return Some(all);
        }
        let is_sure = |level: &Self| {
            let [_, uncertainty_m] = level.drift_m();
            level.objection(sample_m).is_none() && (are_late || uncertainty_m <= MOST_UNCERTAIN_M)
        };
        // Level ground lies between slopes, and late soundings contain a part of these.
        let off_share = if are_late { LEVEL_ALONG } else { 0.0 };
        Some(Self::over(Some(off_share), picks).filter(is_sure).unwrap_or(all))
    }

    /// Returns the offset over level ground, where recorded depths may all be off by the share
    /// `off_share` of the depth; over any ground for `None`.
    ///
    /// On a slope the nearest bottom on the upper side is nearer than the water is deep, so the
    /// deeper side of each block of pings is used: there, the nearest bottom is straight below.
    fn over(off_share: Option<f64>, picks: &[Usable]) -> Option<Self> {
        let counts = |block: &&[Usable]| off_share.is_none() || is_level(block);
        let all = blocks(picks).filter(counts).count();
        let blocks: Vec<(f64, f64)> =
            blocks(picks).filter(counts).filter_map(depth_and_excess).collect();
        let mut offsets: Vec<f64> = blocks.iter().map(|(_, excess_m)| *excess_m).collect();
        if blocks.is_empty() {
            return None;
        }
        let offset_m = median(&mut offsets);
        let depth_m = median_of(blocks.iter().map(|(depth_m, _)| *depth_m));
        let off_m = off_share.map_or(0.0, |off_share| off_share * depth_m);
        let (k, [k_uncertainty, k_attenuation]) = slope(&blocks, off_m);
        Some(Self {
            offset_m,
            uncertainty_m: 2.0 * MEDIAN_ERROR * spread_about(&mut offsets, offset_m)
                / (blocks.len() as f64).sqrt(),
            blocks: blocks.len(),
            share: blocks.len() as f64 / all as f64,
            depth_m,
            k,
            k_uncertainty,
            k_attenuation,
        })
    }

    /// Returns a sentence if the offset is larger than any instrument causes, otherwise `None`;
    /// `sample_m` is the range of one sample.
    pub(super) fn excess(&self, sample_m: f64) -> Option<String> {
        let most_m = MOST_M + MOST_SAMPLES * sample_m;
        let enough = self.blocks >= MIN_BLOCKS && self.offset_m.abs() > most_m;
        enough.then(|| format!(
            "The first returns lie {:.2} m {} the recorded depths, more than a pulse, a filter or a draft cause ({most_m:.2} m here): the ranges stay as recorded, for these depths seem to be those of something else.",
            self.offset_m.abs(),
            if self.offset_m > 0.0 { "beyond" } else { "short of" },
        ))
    }

    /// Returns the change of the offset over the depth of the log and two standard errors of it,
    /// metres: NaN and infinite where the depths do not vary.
    fn drift_m(&self) -> [f64; 2] {
        [((self.k - 1.0) * self.depth_m).abs(), self.k_uncertainty * self.depth_m]
    }

    /// Returns the reason why the offset must not be subtracted from the ranges, in a sentence;
    /// `None` when it may be. `sample_m` is the range of one sample.
    pub(super) fn objection(&self, sample_m: f64) -> Option<String> {
        let Self { offset_m, blocks, .. } = *self;
        let [drift_m, drift_uncertainty_m] = self.drift_m();
        // False where the depths do not vary.
        let is_constant = drift_m <= MOST_DRIFT_M && drift_uncertainty_m <= MOST_UNCERTAIN_M;
        let is_edge = (-(EARLY_M + EARLY_SAMPLES * sample_m)..=LATE_M + LATE_SAMPLES * sample_m)
            .contains(&offset_m);
        if blocks < MIN_BLOCKS {
            Some(format!(
                "The offset of {offset_m:+.2} m between first returns and recorded depths is based on too few pings: it is not taken off the ranges."
            ))
        } else if let Some(excess) = self.excess(sample_m) {
            Some(excess)
        } else if drift_m > TOLERANCE_M + drift_uncertainty_m + self.k_attenuation * self.depth_m {
            Some(format!(
                "The first returns follow the recorded depths by a factor of {:.3} and not one to one: the offset of {offset_m:+.2} m is no constant and is not taken off the ranges.",
                self.k
            ))
        } else if self.uncertainty_m > TOLERANCE_M {
            Some(format!(
                "The offset of {offset_m:+.2} m between first returns and recorded depths is uncertain by {:.2} m: it is not taken off the ranges.",
                self.uncertainty_m
            ))
        } else if self.share < MIN_SHARE {
            Some(format!(
                "Over only {:.0} % of the log the ground is what was found first: the offset of {offset_m:+.2} m from recorded depths that it shows is not taken off the ranges.",
                100.0 * self.share
            ))
        } else if !is_edge && !is_constant {
            Some(format!(
                "The depths vary too little to decide whether the offset of {offset_m:+.2} m between first returns and recorded depths is a constant: it is not taken off the ranges."
            ))
        } else {
            None
        }
    }
}

/// Returns true if the ground under a block of pings is level along the track and across it.
fn is_level(block: &[Usable]) -> bool {
    let depth_m = |picks: &[Usable]| median_of(picks.iter().map(|pick| pick.depth_m));
    let (first, second) = block.split_at(block.len() / 2);
    let sides = Side::BOTH.map(|side| excess_m(block, side).map_or(f64::NAN, |(excess, _)| excess));
    let depth_of_all_m = depth_m(block);
    (depth_m(first) - depth_m(second)).abs() <= LEVEL_ALONG * depth_of_all_m
        && (sides[0] - sides[1]).abs() <= LEVEL_ACROSS * depth_of_all_m
}

/// Returns the median recorded depth of a block, and the median of range minus depth on its deeper
/// side, metres; `None` where a side has too few picks, or too many of them are flagged.
fn depth_and_excess(block: &[Usable]) -> Option<(f64, f64)> {
    let [port, starboard] = Side::BOTH.map(|side| excess_m(block, side));
    let (port, starboard) = (port?, starboard?);
    let (excess_m, flagged) = if port.0 > starboard.0 { port } else { starboard };
    let depth_m = || median_of(block.iter().map(|pick| pick.depth_m));
    (flagged <= MOST_FLAGGED).then(|| (depth_m(), excess_m))
}

/// Returns the median of range minus recorded depth on one side, metres, and the share of its picks
/// that is flagged; `None` with too few picks.
fn excess_m(block: &[Usable], side: Side) -> Option<(f64, f64)> {
    let picks = || block.iter().filter(|pick| pick.side == side);
    let flagged = picks().filter(|pick| pick.above_bottom).count();
    let mut excess: Vec<f64> = picks().map(|pick| pick.range_m - pick.depth_m).collect();
    let flagged = flagged as f64 / excess.len() as f64;
    (excess.len() >= MIN_PICKS).then(|| (median(&mut excess), flagged))
}

/// Returns the slope of range against depth over blocks of depth and excess, with two errors of it:
/// two standard errors, with what depths that are off by up to `off_m` add, and how much the noise
/// of the recorded depths may take away. Noise in a depth is in the excess too, with the other
/// sign, so that over a level bed, where depths vary by their noise alone, the slope comes out near
/// zero whatever it is (attenuation; W. A. Fuller, Measurement error models, 1987). The scatter of
/// a handful of blocks is often small by accident.
fn slope(blocks: &[(f64, f64)], off_m: f64) -> (f64, [f64; 2]) {
    let n = blocks.len() as f64;
    let mean_m = blocks.iter().map(|(depth_m, _)| depth_m).sum::<f64>() / n;
    let squares = blocks.iter().map(|(depth_m, _)| (depth_m - mean_m).powi(2));
    let width_m = squares.sum::<f64>().sqrt();
    match robust_line(blocks).filter(|_| blocks.len() > 2 && width_m > 0.0) {
        Some(line) => {
            let scatter_m = line.spread.max(LEAST_SCATTER_M) * (1.0 + HANDFUL / n);
            let attenuation = n * (scatter_m / width_m).powi(2);
            let off = off_m * n.sqrt() / width_m;
            (1.0 + line.slope, [2.0 * scatter_m / width_m + off, attenuation])
        }
        None => (f64::NAN, [f64::INFINITY; 2]),
    }
}

/// Straight line `y = slope x + offset` with the robust standard deviation about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FittedLine {
    pub slope: f64,
    pub offset: f64,
    pub spread: f64,
}

impl FittedLine {
    fn through(points: &[(f64, f64)], slope: f64, offset: f64) -> Self {
        let mut residuals: Vec<f64> = points.iter().map(|&(x, y)| y - slope * x - offset).collect();
        Self { slope, offset, spread: spread_about(&mut residuals, 0.0) }
    }
}

/// Largest number of points that the starting line is drawn through; the cost of the median of
/// their pairwise slopes grows with its square.
const START_POINTS: usize = 300;
/// Number of reweighting rounds; the weights settle after a handful.
const ROUNDS: usize = 12;
/// Distance from the line, in standard deviations, beyond which points have no weight (Tukey's
/// biweight).
const CUT_SIGMAS: f64 = 4.685;

/// Returns the robust line through `(x, y)`: Theil-Sen over an even subsample, then least squares
/// with Tukey's weights. `None` when `x` hardly varies.
pub(super) fn robust_line(points: &[(f64, f64)]) -> Option<FittedLine> {
    let mut line = theil_sen(points)?;
    for _ in 0..ROUNDS {
        let scale = CUT_SIGMAS * line.spread.max(1e-6);
        let weighted = points.iter().map(|&(x, y)| {
            let u = (y - line.slope * x - line.offset) / scale;
            (x, y, (1.0 - u * u).max(0.0).powi(2))
        });
        let (slope, offset) = weighted_line(weighted)?;
        line = FittedLine::through(points, slope, offset);
    }
    Some(line)
}

fn theil_sen(points: &[(f64, f64)]) -> Option<FittedLine> {
    let step = points.len().div_ceil(START_POINTS).max(1);
    let sample: Vec<(f64, f64)> = points.iter().copied().step_by(step).collect();
    let mut slopes = Vec::with_capacity(sample.len() * sample.len() / 2);
    for (index, a) in sample.iter().enumerate() {
        let later = sample[index + 1..].iter().filter(|b| (b.0 - a.0).abs() > 1e-9);
        slopes.extend(later.map(|b| (b.1 - a.1) / (b.0 - a.0)));
    }
    if slopes.is_empty() {
        return None;
    }
    let slope = median(&mut slopes);
    let offset = median_of(points.iter().map(|&(x, y)| y - slope * x));
    Some(FittedLine::through(points, slope, offset))
}

fn weighted_line(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Option<(f64, f64)> {
    let sum = |value: fn(f64, f64, f64) -> f64| {
        points.clone().map(|(x, y, w)| value(x, y, w)).sum::<f64>()
    };
    let weight = sum(|_, _, w| w);
    let (x_mean, y_mean) = (sum(|x, _, w| w * x) / weight, sum(|_, y, w| w * y) / weight);
    let (xx, xy) = points.fold((0.0, 0.0), |(xx, xy), (x, y, w)| {
        (xx + w * (x - x_mean).powi(2), xy + w * (x - x_mean) * (y - y_mean))
    });
    let slope = xy / xx;
    slope.is_finite().then_some((slope, y_mean - slope * x_mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_wild_points_does_not_move_the_line() {
        let points: Vec<(f64, f64)> = (0..900)
            .map(|i| {
                let x = 1.0 + f64::from(i % 97) / 30.0;
                let wild = if i % 3 == 0 { f64::from(i % 11) } else { 0.0 };
                (x, 1.04 * x - 0.05 + wild)
            })
            .collect();
        let line = robust_line(&points).unwrap();
        assert!((line.slope - 1.04).abs() < 1e-3, "{line:?}");
        assert!((line.offset + 0.05).abs() < 3e-3, "{line:?}");
    }

    /// Picks over steps of 30 m at two depths with banks between them, 5 cm early; soundings are
    /// those of `late_pings` before.
    fn steps(late_pings: usize) -> Vec<Usable> {
        let depth_m = |ping: usize| match ping % 600 {
            0..200 => 3.0,
            at @ 200..300 => 3.0 + 0.03 * (at - 200) as f64,
            300..500 => 6.0,
            at => 6.0 - 0.03 * (at - 500) as f64,
        };
        let noise_m = |ping: usize| 0.01 * [0.0, 1.0, -1.0, 0.5, -0.5][ping % 5];
        let pick = |ping: usize| {
            Side::BOTH.map(|side| Usable {
                ping,
                side,
                sample: 100.0,
                range_m: depth_m(ping) - 0.05 + noise_m(ping),
                depth_m: depth_m(ping.saturating_sub(late_pings)),
                above_bottom: false,
            })
        };
        (0..2400).flat_map(pick).collect()
    }

    #[test]
    fn late_soundings_count_over_level_ground_only() {
        for (late_pings, are_late) in [(0, false), (30, true)] {
            let found = RangeOffset::of(&steps(late_pings), 0.01, are_late).unwrap();
            assert!((found.offset_m + 0.05).abs() < 0.005, "{late_pings}: {found:?}");
            assert_eq!(found.objection(0.01), None);
        }
        let blocks = |are_late| RangeOffset::of(&steps(30), 0.01, are_late).unwrap().blocks;
        assert!(blocks(true) < blocks(false) * 3 / 4);
    }

    #[test]
    fn late_soundings_over_two_similar_depths_show_no_factor() {
        // Level ground at 3.0 and 3.2 m, where the deeper soundings contain a part of the bank.
        let pick = |ping: usize| {
            let is_deep = ping / 240 % 2 == 1;
            let [range_m, depth_m] = if is_deep { [3.15, 3.19] } else { [2.95, 3.0] };
            let noise_m = 0.001 * [0.0, 1.0, -1.0, 0.5, -0.5][ping % 5];
            Side::BOTH.map(|side| Usable {
                ping,
                side,
                sample: 100.0,
                range_m: range_m + noise_m,
                depth_m,
                above_bottom: false,
            })
        };
        let picks: Vec<Usable> = (0..4800).flat_map(pick).collect();
        let objection = |are_late| RangeOffset::of(&picks, 0.01, are_late).unwrap().objection(0.01);
        assert!(objection(false).unwrap().contains("by a factor of 1.05"));
        assert_eq!(objection(true), None);
    }
}
