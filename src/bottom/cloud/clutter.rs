//! First returns that stay at their range while the bed falls away: clutter of the surface, or a
//! layer in the water that scatters.
//!
//! Boulders, banks and weed lie on the bed, and are farther from the boat where that is deeper.
//! What rises above the recorded depth by more than [`HIGHEST`] of it is none of them. Where such
//! returns are many over a bed that is deep enough, others above the bottom at the same range, over
//! a shallower bed nearby, are the same clutter, and so is what lies there where no depth was
//! recorded, unless more of the bottom lies at that range.

use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::quantile;
use bathyscope_log::survey::{Side, Survey};

/// Boulders, banks and scarps rise above the recorded depth by no more than this share of it.
pub(super) const HIGHEST: f64 = 0.4;
/// Way to both sides over which the ranges of clutter are compared, metres, and length of the
/// stretches that are counted together.
const AROUND_M: f64 = 300.0;
const STRETCH_M: f64 = 50.0;
/// Ranges within this share of each other are the same.
const SAME_RANGE: f64 = 0.08;
/// Nearer ranges, metres, are taken together, and so are those beyond this number of steps of
/// [`SAME_RANGE`].
const NEAREST_M: f64 = 0.3;
const RANGES: usize = 96;
/// Fewest returns that are too high for others at their range to count as clutter.
const FEWEST: u32 = 40;
/// Over a bed that is deep enough for it, clutter is the first return of this share of the pings.
const PREVALENT: f64 = 0.25;
/// Fewest returns that are clutter, and least share of them, that are worth a warning.
const WORTH_SAYING: usize = 100;
const WORTH_SAYING_SHARE: f64 = 0.03;

/// The kind of a first return by its height alone.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Height {
    /// None was found.
    Nothing,
    /// The first return lies at the recorded depth, or beyond it.
    Bottom,
    /// Above the bottom.
    Above,
    /// Too high for anything that lies on the bed.
    TooHigh,
    /// No depth was recorded.
    Unknown,
}

/// Clutter among the first returns of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutter {
    /// Pings of both sides, summed, whose first return is clutter.
    pub returns: usize,
    /// Pings of both sides, summed, with a first return.
    pub of: usize,
    /// The range that 5 % of it do not reach, and that 5 % exceed, metres.
    pub range_m: [f64; 2],
}

impl Clutter {
    /// A sentence about clutter that takes a part of the first returns; `None` where it is little.
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

/// First returns of a stretch at one range, and pings over a bed where that would be too high.
#[derive(Clone, Copy, Default)]
struct Counts {
    bottom: u32,
    too_high: u32,
    deep: u32,
}

/// Stretches of the track with the counts of all up to their ends, by range.
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

    /// The counts of about the same range within [`AROUND_M`] of a place on the way.
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

/// Finds the first returns that are clutter, one entry a ping and side, and sums them up, where
/// there are any.
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
        let of_ping = |(ping, one): (usize, (Height, f64))| {
            let is_clutter = is_clutter(ping, one);
            of += usize::from(one.0 != Height::Nothing);
            if is_clutter {
                ranges_m.push(one.1);
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

/// Height and slant range of the first return of each ping of a side, by the recorder's scale.
fn heights(
    survey: &Survey,
    returns: &FirstReturns,
    side: Side,
    pings: usize,
) -> Vec<(Height, f64)> {
    let picks = returns.side(side).iter().take(pings).enumerate();
    let of_pick = |(ping, pick): (usize, &crate::first_return::Pick)| {
        let span = survey.span(ping, side).filter(|_| pick.is_some());
        let range_m = span.map_or(f64::NAN, |span| span.range_m(f64::from(pick.sample)));
        let depth_m = f64::from(survey.good_depth_m(ping));
        let height = match () {
            () if range_m.is_nan() => Height::Nothing,
            () if returns.is_drawn(side, ping) => Height::Bottom,
            // A depth of 0 is none.
            () if depth_m.is_nan() || depth_m <= 0.0 => Height::Unknown,
            // What was accepted as bottom is not above it.
            () if !pick.above_bottom => Height::Bottom,
            () if depth_m - range_m > HIGHEST * depth_m => Height::TooHigh,
            () => Height::Above,
        };
        (height, range_m)
    };
    picks.map(of_pick).collect()
}

/// The step of [`SAME_RANGE`] that a range lies in; `None` of none.
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
