//! Measures pixels per metre at a flat spot, and reads the scale that the log's headers imply.

use super::Scale;
use crate::first_return::{FirstReturns, Pick};
use bathyscope_log::support::statistics::{median, median_of, spread_about};
use bathyscope_log::survey::{Side, Survey};
use std::ops::Range;

/// Largest factor by which the r / d of a pick may differ from the log's median: a pick beyond it
/// is no bottom, since the search ran into its limit, or stopped at the edge of the dead zone.
const RATIO_LIMIT: f64 = 1.6;

/// Fewest picks that a scale is based on, as a share of what the stretch could give: fewer are
/// accidents of the search.
const MIN_SHARE: f64 = 0.05;

/// Pick at a recorded depth, for calibration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Usable {
    pub(super) ping: usize,
    pub(super) side: Side,
    /// First return in u8 samples.
    pub(super) sample: f64,
    /// First return by the header's scale, metres.
    pub(super) range_m: f64,
    /// Recorded depth, metres.
    pub(super) depth_m: f64,
    /// True if flagged as an above-bottom return: such a pick must not calibrate.
    pub(super) above_bottom: bool,
}

impl Usable {
    fn px_per_m(&self) -> f64 {
        self.sample / self.depth_m
    }

    /// Returns the range as a multiple of the depth.
    pub(super) fn of_depth(&self) -> f64 {
        self.range_m / self.depth_m
    }
}

/// First return at a ping where the recorder had the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeAtDepth {
    /// Index of the side-scan ping.
    pub ping: usize,
    /// Recorded depth, metres.
    pub depth_m: f64,
    /// Slant range of the first return by the recorder's scale, metres.
    pub range_m: f64,
}

/// Returns the first returns of the log that may calibrate, in ping order.
pub fn ranges_at_depths(survey: &Survey, returns: &FirstReturns) -> Vec<RangeAtDepth> {
    let picks = usable_picks(survey, returns).into_iter();
    let of = |pick: Usable| RangeAtDepth {
        ping: pick.ping,
        depth_m: pick.depth_m,
        range_m: pick.range_m,
    };
    picks.map(of).collect()
}

/// Returns the picks of the log that may calibrate, in ping order: no above-bottom return, not at
/// the search limit, not at the dead zone, and not where the recorder had lost the bottom.
pub(super) fn usable_picks(survey: &Survey, returns: &FirstReturns) -> Vec<Usable> {
    let mut picks = picks_at_depths(survey, returns);
    picks.retain(|pick| !pick.above_bottom);
    let typical = median_of(picks.iter().map(Usable::of_depth));
    picks.retain(|pick| (1.0 / RATIO_LIMIT..=RATIO_LIMIT).contains(&(pick.of_depth() / typical)));
    picks
}

/// Returns the picks of [`usable_picks`] and also those that are flagged and those whose range
/// differs much from the usual share of the depth.
pub(super) fn picks_at_depths(survey: &Survey, returns: &FirstReturns) -> Vec<Usable> {
    (0..survey.side_scan.len())
        .flat_map(|ping| Side::BOTH.map(|side| (ping, side)))
        .filter_map(|(ping, side)| pick_at_depth(survey, ping, side, returns.side(side).get(ping)?))
        .collect()
}

fn pick_at_depth(survey: &Survey, ping: usize, side: Side, pick: &Pick) -> Option<Usable> {
    let recorded = survey.side_scan.get(ping)?;
    let span = recorded.side(side)?;
    let (sample, depth_m) = (f64::from(pick.sample), f64::from(recorded.good_depth_m()));
    let inside = sample > 0.0 && sample < f64::from(span.count) - 1.0;
    (inside && depth_m > 0.0).then(|| Usable {
        ping,
        side,
        sample,
        range_m: span.range_m(sample),
        depth_m,
        above_bottom: pick.above_bottom,
    })
}

/// Returns the picks of a stretch; `picks` are in ping order.
pub(super) fn inside<'a>(picks: &'a [Usable], pings: &Range<usize>) -> &'a [Usable] {
    let place = |ping: usize| picks.partition_point(|pick| pick.ping < ping);
    &picks[place(pings.start)..place(pings.end).max(place(pings.start))]
}

/// Returns `PPD = p / d`: the median over the usable picks of both sides, of a stretch of `pings`
/// pings; `None` when there are too few picks.
pub(super) fn pixels_per_metre(picks: &[Usable], pings: usize) -> Option<Scale> {
    let enough = picks.len() as f64 >= MIN_SHARE * (2 * pings) as f64;
    let values = || picks.iter().map(Usable::px_per_m).collect();
    enough.then(values).and_then(scale_of)
}

/// Returns the recorded depth over the header's slant range: the median over picks of a flat spot;
/// `None` without any.
pub(super) fn header_factor(picks: &[Usable]) -> Option<f64> {
    let factor = 1.0 / median_of(picks.iter().map(Usable::of_depth));
    (factor.is_finite() && factor > 0.0).then_some(factor)
}

/// Returns the scale that the headers state: the median over all pings, by the port side where it
/// was recorded. `None` where no header states one.
pub fn header_scale(survey: &Survey) -> Option<Scale> {
    scale_of(header_scales(survey).collect())
}

/// Returns the number of times that the recorded scale changes by more than 1 % from one ping to
/// the next.
pub(super) fn range_changes(survey: &Survey) -> usize {
    let scales: Vec<f64> = header_scales(survey).collect();
    scales.windows(2).filter(|pair| (pair[1] / pair[0] - 1.0).abs() > 0.01).count()
}

fn header_scales(survey: &Survey) -> impl Iterator<Item = f64> + '_ {
    let sides = |ping: &bathyscope_log::survey::SidePing| ping.port.or(ping.starboard);
    survey
        .side_scan
        .iter()
        .filter_map(sides)
        .map(|span| 1.0 / span.metres_per_sample())
        .filter(|scale| scale.is_finite() && *scale > 0.0)
}

fn scale_of(mut values: Vec<f64>) -> Option<Scale> {
    let px_per_m = median(&mut values);
    px_per_m.is_finite().then(|| Scale {
        px_per_m,
        picks: values.len(),
        spread_px_per_m: spread_about(&mut values, px_per_m),
    })
}
