//! Finds first returns that stay at one range while the bed gets deeper: clutter of the surface, or
//! a layer in the water that scatters. They do not count as depths.
//!
//! Boulders, banks and weed lie on the bed, and are farther from the boat where the bed is deeper.
//! A return that rises above the recorded depth by more than [`HIGHEST`] of the depth is none of
//! them. Where such returns are many over a bed that is deep enough, returns above the bottom at
//! the same range over a shallower bed nearby are the same clutter. So are returns at this range
//! where no depth was recorded, unless more of the bottom lies at this range.

use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::quantile;
use bathyscope_log::survey::{Side, Survey};

/// Greatest height of boulders, banks and scarps above the recorded depth, as a share of the depth.
pub(super) const HIGHEST: f64 = 0.4;
/// Distance along the track, before and after a ping, over which the ranges of clutter are
/// compared, metres, and length of the stretches that are counted together.
const AROUND_M: f64 = 300.0;
const STRETCH_M: f64 = 50.0;
/// Share of a range within which other ranges count as the same.
const SAME_RANGE: f64 = 0.08;
/// Range below which all ranges are counted together, metres; and number of steps of [`SAME_RANGE`]
/// beyond which they are, too.
const NEAREST_M: f64 = 0.3;
const RANGES: usize = 96;
/// Fewest returns that are too high, with which other returns at their range count as clutter.
const FEWEST: u32 = 40;
/// Least share of the pings over a bed that is deep enough whose first return is the clutter.
const PREVALENT: f64 = 0.25;
/// Fewest first returns that are clutter, and least share of all first returns, that are worth a
/// warning.
const WORTH_SAYING: usize = 100;
const WORTH_SAYING_SHARE: f64 = 0.03;

/// Kind of a first return by its height alone.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Height {
    /// There is no first return.
    Nothing,
    /// The first return was drawn or accepted as bottom, or lies at the recorded depth or beyond.
    Bottom,
    /// The first return lies above the bottom.
    Above,
    /// The first return is too high for anything that lies on the bed.
    TooHigh,
    /// No depth was recorded.
    Unknown,
}

/// Clutter among the first returns of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutter {
    /// Number of first returns of both sides that are clutter.
    pub returns: usize,
    /// Number of first returns of both sides.
    pub of: usize,
    /// Ranges that 5 % of the clutter do not reach, and that 5 % exceed, metres.
    pub range_m: [f64; 2],
}

impl Clutter {
    /// Returns a warning if clutter is a large enough share of the first returns; `None` if it is
    /// not.
    pub fn warning(&self) -> Option<String> {
        let share = self.returns as f64 / self.of.max(1) as f64;
        let [near_m, far_m] = self.range_m;
        (self.returns >= WORTH_SAYING && share >= WORTH_SAYING_SHARE).then(|| {
            format!(
                "{:.0} % of the first returns lie far above the recorded depth, at {near_m:.1} to {far_m:.1} m however deep it is: waves at the surface, bubbles, or a layer in the water that scatters. They do not count, so that there the depth is that of the soundings alone",
                100.0 * share
            )
        })
    }
}

/// Numbers of first returns of a stretch at one range, and of pings over a bed where this range
/// would be too high.
#[derive(Clone, Copy, Default)]
struct Counts {
    bottom: u32,
    too_high: u32,
    deep: u32,
}

/// Stretches of the track, with the counts of all stretches up to the end of each, by range.
#[derive(Default)]
struct Stretches {
    starts_m: Vec<f64>,
    up_to: Vec<[Counts; RANGES]>,
}

impl Stretches {
    fn of(survey: &Survey, heights: &[Vec<(Height, f64)>; 2], way_m: &[f64]) -> Self {
        let mut all = Self::default();
        let mut sums = [Counts::default(); RANGES];
        for (ping, &at_m) in way_m.iter().enumerate() {
            if all.starts_m.last().is_none_or(|start_m| at_m - start_m > STRETCH_M) {
                all.starts_m.push(at_m);
                all.up_to.push(sums);
            }
            let deepest_m = (1.0 - HIGHEST) * f64::from(survey.good_depth_m(ping));
            for &(height, range_m) in heights.iter().filter_map(|side| side.get(ping)) {
                if let Some(range) = range_number(range_m) {
                    sums[range].bottom += u32::from(height == Height::Bottom);
                    sums[range].too_high += u32::from(height == Height::TooHigh);
                }
                if let Some(range) = range_number(deepest_m).filter(|_| height != Height::Nothing) {
                    sums[range].deep += 1;
                }
            }
            if let Some(last) = all.up_to.last_mut() {
                *last = sums;
            }
        }
        for counts in &mut all.up_to {
            let mut deep = 0;
            for count in counts.iter_mut().rev() {
                deep += count.deep;
                count.deep = deep;
            }
        }
        all
    }

    /// Returns the counts of about the same range within [`AROUND_M`] of a place on the way.
    fn around(&self, range_m: f64, at_m: f64) -> Counts {
        let Some(range) = range_number(range_m) else {
            return Counts::default();
        };
        let up_to = |way_m: f64| {
            let count = self.starts_m.partition_point(|start_m| *start_m <= way_m);
            count.checked_sub(1).map(|last| &self.up_to[last])
        };
        let (from, to) = (up_to(at_m - AROUND_M - STRETCH_M), up_to(at_m + AROUND_M));
        let between = |of: &dyn Fn(&[Counts; RANGES]) -> u32| {
            to.map_or(0, of).saturating_sub(from.map_or(0, of))
        };
        let same = range.saturating_sub(1)..(range + 2).min(RANGES);
        let sum = |of: fn(&Counts) -> u32| {
            between(&|counts| counts[same.clone()].iter().map(of).sum::<u32>())
        };
        Counts {
            bottom: sum(|counts| counts.bottom),
            too_high: sum(|counts| counts.too_high),
            deep: between(&|counts| counts[range].deep),
        }
    }
}

/// Returns a flag for the first return of each side and ping, true if it is clutter, and the sum of
/// the clutter, if there is any.
pub(super) fn clutter(
    survey: &Survey,
    returns: &FirstReturns,
    way_m: &[f64],
) -> ([Vec<bool>; 2], Option<Clutter>) {
    let heights = Side::BOTH.map(|side| heights(survey, returns, side, way_m.len()));
    let stretches = Stretches::of(survey, &heights, way_m);
    let is_clutter = |ping: usize, (height, range_m): (Height, f64)| match height {
        Height::Nothing | Height::Bottom => false,
        Height::TooHigh => true,
        Height::Above | Height::Unknown => {
            let Counts { bottom, too_high, deep } = stretches.around(range_m, way_m[ping]);
            too_high >= FEWEST
                && f64::from(too_high) >= PREVALENT * f64::from(deep)
                && (height == Height::Above || too_high >= bottom)
        }
    };
    let mut ranges_m = Vec::new();
    let mut of = 0;
    let flags = heights.map(|side| {
        let of_ping = |(ping, first_return): (usize, (Height, f64))| {
            let is_clutter = is_clutter(ping, first_return);
            of += usize::from(first_return.0 != Height::Nothing);
            if is_clutter {
                ranges_m.push(first_return.1);
            }
            is_clutter
        };
        side.into_iter().enumerate().map(of_ping).collect()
    });
    ranges_m.sort_unstable_by(f64::total_cmp);
    let found = (!ranges_m.is_empty()).then(|| Clutter {
        returns: ranges_m.len(),
        of,
        range_m: [0.05, 0.95].map(|share| quantile(&ranges_m, share)),
    });
    (flags, found)
}

/// Returns the height and slant range of the first return of each ping of a side, by the recorder's
/// scale.
fn heights(
    survey: &Survey,
    returns: &FirstReturns,
    side: Side,
    pings: usize,
) -> Vec<(Height, f64)> {
    let picks = returns.side(side).iter().take(pings).enumerate();
    let of_pick = |(ping, pick): (usize, &crate::first_return::Pick)| {
        let range_m = returns.range_m(survey, ping, side);
        let depth_m = f64::from(survey.good_depth_m(ping));
        let height = match () {
            () if range_m.is_nan() => Height::Nothing,
            () if returns.is_drawn(side, ping) => Height::Bottom,
            // A depth of 0 means that none was recorded.
            () if depth_m.is_nan() || depth_m <= 0.0 => Height::Unknown,
            // A first return that was accepted as bottom is not above it.
            () if !pick.above_bottom => Height::Bottom,
            () if depth_m - range_m > HIGHEST * depth_m => Height::TooHigh,
            () => Height::Above,
        };
        (height, range_m)
    };
    picks.map(of_pick).collect()
}

/// Returns the number of the step of [`SAME_RANGE`] that a range lies in; `None` without a range.
fn range_number(range_m: f64) -> Option<usize> {
    let steps = (range_m / NEAREST_M).max(1.0).ln() / SAME_RANGE;
    (range_m > 0.0).then(|| (steps as usize).min(RANGES - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_return::Pick;
    use bathyscope_log::survey::{SidePing, SideSpan};
    use std::sync::Arc;

    /// Both sides of pings 0.1 m apart at slant ranges over recorded depths, metres.
    fn found(pings: &[(f64, f64)]) -> (Vec<bool>, Option<Clutter>) {
        let span = SideSpan::of_bytes(1000, [0.0, 20.0]);
        let ping = |(index, (depth_m, _)): (usize, &(f64, f64))| SidePing {
            port: Some(span),
            starboard: Some(span),
            ..SidePing::with_depth(0.05 * index as f64, *depth_m as f32)
        };
        let pick = |(depth_m, range_m): &(f64, f64)| Pick {
            sample: span.sample_at(*range_m) as f32,
            confidence: 1.0,
            above_bottom: range_m + 0.15 < *depth_m,
        };
        let survey = Survey::of_pings(pings.iter().enumerate().map(ping));
        let picks: Arc<Vec<Pick>> = Arc::new(pings.iter().map(pick).collect());
        let returns =
            FirstReturns { port: Arc::clone(&picks), starboard: picks, ..FirstReturns::default() };
        let way_m: Vec<f64> = (0..pings.len()).map(|ping| 0.1 * ping as f64).collect();
        let ([port, starboard], all) = clutter(&survey, &returns, &way_m);
        assert_eq!(port, starboard);
        (port, all)
    }

    #[test]
    fn a_layer_stays_at_its_range_over_a_shallower_bed_too() {
        // From 3.2 to 8 m deep, and a layer at 3 m.
        let pings: Vec<(f64, f64)> =
            (0..1000).map(|ping| (3.2 + 0.0048 * f64::from(ping), 3.0)).collect();
        let (is_clutter, all) = found(&pings);
        assert!(is_clutter[100..].iter().all(|is| *is));
        let all = all.unwrap();
        assert!(all.returns >= 1800 && all.range_m == [3.0, 3.0], "{all:?}");
        assert!(all.warning().unwrap().contains("at 3.0 to 3.0 m"));
    }

    #[test]
    fn boulders_follow_the_bed_and_are_none() {
        let pings: Vec<(f64, f64)> = (0..1000)
            .map(|ping| (3.2 + 0.0048 * f64::from(ping), 0.75 * (3.2 + 0.0048 * f64::from(ping))))
            .collect();
        assert_eq!(found(&pings), (vec![false; 1000], None));
    }

    #[test]
    fn without_a_recorded_depth_the_range_of_clutter_is_clutter_and_that_of_the_bottom_is_not() {
        let mut pings = vec![(8.0, 3.0); 300];
        pings.extend([(f64::NAN, 3.0); 20]);
        pings.extend([(8.0, 8.0); 300]);
        pings.extend([(f64::NAN, 8.0); 20]);
        let (is_clutter, _) = found(&pings);
        assert!(is_clutter[..320].iter().all(|is| *is) && !is_clutter[320..].iter().any(|is| *is));
    }
}
