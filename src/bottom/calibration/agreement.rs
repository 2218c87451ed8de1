//! Measures how well the first returns of a stretch agree with the bottom that the recorder
//! measured.

use super::scale::Usable;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::Side;
use std::ops::Range;

/// Largest departure of a range from its share of the depth that counts in full: a range that
/// departs by more is a wrong pick, whatever the amount.
const WRONG: f64 = 0.2;

/// Comparison of first returns with recorded depths, with running sums so that any stretch costs
/// the same.
pub(super) struct DepthAgreement {
    /// Sums over the picks of all pings before each index.
    sums: Vec<Sums>,
    /// Sides that have any pick in the log.
    sides: Vec<Side>,
    /// Median depth under the picks, metres.
    depth_m: f64,
}

#[derive(Clone, Copy, Default)]
struct Sums {
    /// Number of picks, port and starboard.
    counts: [f64; 2],
    /// Sum of the shares by which a pick's `r / d` exceeds the log's median.
    excess: f64,
    squares: f64,
}

impl DepthAgreement {
    /// Creates the sums of picks in ping order, over a log of `pings` pings.
    pub(super) fn new(picks: &[Usable], pings: usize) -> Self {
        let ratio = |pick: &Usable| pick.range_m / pick.depth_m;
        let typical = median(&mut picks.iter().map(ratio).collect::<Vec<_>>());
        let mut sums = Vec::with_capacity(pings + 1);
        let (mut so_far, mut rest) = (Sums::default(), picks);
        sums.push(so_far);
        for ping in 0..pings {
            let here = rest.iter().take_while(|pick| pick.ping == ping).count();
            for pick in &rest[..here] {
                so_far.add(pick.side, ratio(pick) / typical - 1.0);
            }
            rest = &rest[here..];
            sums.push(so_far);
        }
        let mut sides = Side::BOTH.to_vec();
        sides.retain(|&side| so_far.count(side) > 0.0);
        Self {
            sums,
            sides,
            depth_m: median(&mut picks.iter().map(|pick| pick.depth_m).collect::<Vec<_>>()),
        }
    }

    /// Returns the possible error of the scale of a stretch, metres at the log's median depth:
    /// twice the scatter of `r / d` over both sides together, which includes a slope across the
    /// track, plus the square of the share of pings without a pick on the poorer side. A few of
    /// these pings are fish and interference; where there are many, the picks that remain were
    /// selected: over boulders and weed, they are from the pings at which these end below the
    /// margin.
    ///
    /// Zero where the log has no picks at all: then nothing distinguishes one stretch from another.
    pub(super) fn doubt_m(&self, pings: &Range<usize>) -> f64 {
        let (before, after) = (self.sums[pings.start], self.sums[pings.end]);
        let count = |side: Side| after.count(side) - before.count(side);
        let missing = |&side: &Side| 1.0 - count(side) / pings.len() as f64;
        let Some(missing) = self.sides.iter().map(missing).reduce(f64::max) else {
            return 0.0;
        };
        let picks = (count(Side::Port) + count(Side::Starboard)).max(1.0);
        let mean = (after.excess - before.excess) / picks;
        let variance = (after.squares - before.squares) / picks - mean * mean;
        self.depth_m * (2.0 * variance.max(0.0).sqrt() + missing * missing)
    }
}

impl Sums {
    fn add(&mut self, side: Side, excess: f64) {
        self.counts[side as usize] += 1.0;
        let excess = excess.clamp(-WRONG, WRONG);
        self.excess += excess;
        self.squares += excess * excess;
    }

    fn count(&self, side: Side) -> f64 {
        self.counts[side as usize]
    }
}
