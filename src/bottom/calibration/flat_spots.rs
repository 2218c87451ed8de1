//! Finds stretches where the bottom is flat along the track, and both sides detect it.

use super::FlatSpot;
use super::scale::{Usable, header_factor, inside, pixels_per_metre, usable_picks};
use crate::first_return::FirstReturns;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{median, median_of};
use bathyscope_log::survey::{Navigation, Side, Survey};
use std::array::from_fn;
use std::ops::Range;

/// Length of a stretch, metres, where the track is long enough.
const LENGTH_M: f64 = 10.0;
/// Fewest pings in a stretch.
const MIN_PINGS: usize = 20;

/// Returns the stretches of the track that suit a calibration, ranked from the best: at most
/// `count`, which do not overlap.
///
/// A stretch suits when the recorded depth varies little over it, and when nearly every ping has a
/// first return that may calibrate on both sides, all of them in one proportion to the depth
/// ([`DepthAgreement`]). The same measure over three times the length counts by a quarter: many
/// stretches tie where the recorder rounds depths to 0.1 m, and the middle of a plain is the
/// safest.
///
/// # Errors
/// When the work was cancelled.
pub fn flat_spots(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
    count: usize,
    progress: &Progress,
) -> Result<Vec<FlatSpot>, Cancelled> {
    let profile = Profile::new(survey, navigation);
    let picks = usable_picks(survey, returns);
    let agreement = DepthAgreement::new(&picks, profile.len());
    let starts: Vec<usize> = (0..profile.len()).step_by(MIN_PINGS / 4).collect();
    progress.start(starts.len() as u64);
    let length_m = LENGTH_M.min(profile.length_m() / 6.0);
    let unevenness_m = |pings: &Range<usize>| profile.variation_m(pings) + agreement.doubt_m(pings);
    let mut ranked = Vec::new();
    for chunk in starts.chunks(4096) {
        progress.check()?;
        for &start in chunk {
            let Some(pings) = profile.stretch(start, length_m, MIN_PINGS) else {
                continue;
            };
            let wide = profile.around(&pings, length_m);
            ranked.push((unevenness_m(&pings) + unevenness_m(&wide) / 4.0, pings));
        }
        progress.advance(chunk.len() as u64);
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = apart(ranked.into_iter().map(|(_, pings)| pings), count);
    let spots = best.into_iter();
    Ok(spots.map(|pings| of_stretch(survey, &profile, &picks, pings)).collect())
}

/// Returns the first `count` stretches that share no ping with an earlier one.
fn apart(ranked: impl Iterator<Item = Range<usize>>, count: usize) -> Vec<Range<usize>> {
    let mut best: Vec<Range<usize>> = Vec::new();
    for pings in ranked {
        if best.len() == count {
            break;
        }
        let overlaps = |other: &Range<usize>| other.start < pings.end && pings.start < other.end;
        if !best.iter().any(overlaps) {
            best.push(pings);
        }
    }
    best
}

/// Returns a stretch around a ping that is as long as a ranked one; 20 pings where the boat is at
/// rest.
pub fn stretch_around(survey: &Survey, navigation: &Navigation, ping: usize) -> Range<usize> {
    let profile = Profile::new(survey, navigation);
    let last = profile.len().saturating_sub(1);
    let ping = ping.min(last);
    let margin_m = 0.5 * LENGTH_M.min(profile.length_m() / 6.0);
    let half = MIN_PINGS / 2;
    let least = ping.saturating_sub(half)..(ping + half).min(profile.len());
    match profile.len() {
        0 => 0..0,
        _ => {
            let wide = profile.around(&(ping..ping + 1), margin_m);
            wide.start.min(least.start)..wide.end.max(least.end)
        }
    }
}

/// Describes a stretch that the user chose, whether or not it suits a calibration.
pub fn stretch(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
    pings: Range<usize>,
) -> FlatSpot {
    let picks = usable_picks(survey, returns);
    describe(survey, navigation, &picks, pings)
}

/// Describes a stretch as [`stretch`] does, from the usable picks.
pub(super) fn describe(
    survey: &Survey,
    navigation: &Navigation,
    picks: &[Usable],
    pings: Range<usize>,
) -> FlatSpot {
    let profile = Profile::new(survey, navigation);
    let end = pings.end.min(profile.len());
    of_stretch(survey, &profile, picks, pings.start.min(end)..end)
}

fn of_stretch(
    survey: &Survey,
    profile: &Profile,
    picks: &[Usable],
    pings: Range<usize>,
) -> FlatSpot {
    let (slope, scatter_m) = profile.line(&pings);
    let recorded = survey.side_scan.get(pings.clone()).unwrap_or_default();
    let with_depth = || recorded.iter().filter(|ping| ping.depth_m > 0.0);
    let locked = with_depth().filter(|ping| ping.depth_fault.is_none()).count();
    // A false depth of a recorder that lost the bottom counts only where the stretch has no other.
    let depths = with_depth().filter(|ping| ping.depth_fault.is_none() || locked == 0);
    let mut depths_m: Vec<f64> = depths.map(|ping| f64::from(ping.depth_m)).collect();
    let least_m = depths_m.iter().copied().reduce(f64::min);
    let greatest_m = depths_m.iter().copied().reduce(f64::max);
    let spot_picks = inside(picks, &pings);
    let ppd = pixels_per_metre(spot_picks, pings.len());
    let [port, starboard] = Side::BOTH.map(|side| {
        let of_side = spot_picks.iter().filter(|pick| pick.side == side);
        median_of(of_side.map(Usable::of_depth))
    });
    FlatSpot {
        length_m: profile.way_m(&pings),
        depth_m: median(&mut depths_m),
        relief_m: greatest_m.zip(least_m).map_or(f64::NAN, |(most, least)| most - least),
        lost: with_depth().count() - locked,
        slope,
        scatter_m,
        picks: Side::BOTH.map(|side| spot_picks.iter().filter(|pick| pick.side == side).count()),
        factor: ppd.and_then(|_| header_factor(spot_picks)),
        ppd,
        tilt: (port - starboard).abs(),
        pings,
    }
}

/// Speed below which the boat is at rest, metres a second: its depth is flat whatever the bottom
/// is.
const MIN_SPEED_MPS: f64 = 0.2;
/// Shortest pause between two pings that ends a stretch, seconds.
const MAX_PAUSE_S: f64 = 2.0;

/// Recorded depth against distance along the track, with running sums so that any stretch costs the
/// same.
struct Profile {
    /// Distance sailed up to each ping, metres.
    along_m: Vec<f64>,
    /// Sums over the usable pings before each index: of 1, x, y, x², x y and y², of the distance x
    /// and the depth y, metres.
    sums: Vec<[f64; 6]>,
}

impl Profile {
    fn new(survey: &Survey, navigation: &Navigation) -> Self {
        let pings = &survey.side_scan;
        let mut along_m = Vec::with_capacity(pings.len());
        let mut distance_m = 0.0;
        let pause_s = |index: usize| pings[index].time_s - pings[index.saturating_sub(1)].time_s;
        for (index, place) in navigation.pings.iter().enumerate() {
            let pause_s = pause_s(index);
            if place.speed_mps.is_finite() && pause_s < MAX_PAUSE_S {
                distance_m += place.speed_mps * pause_s;
            }
            along_m.push(distance_m);
        }
        let usable = |index: usize| {
            pings[index].good_depth_m() > 0.0
                && pause_s(index) < MAX_PAUSE_S
                && navigation.pings[index].speed_mps >= MIN_SPEED_MPS
        };
        let mut sums = vec![[0.0_f64; 6]];
        for index in 0..along_m.len() {
            let (x, y) = (along_m[index], f64::from(pings[index].depth_m));
            let (last, added) = (sums[index], [1.0, x, y, x * x, x * y, y * y]);
            sums.push(if usable(index) { from_fn(|of| last[of] + added[of]) } else { last });
        }
        Self { along_m, sums }
    }

    fn len(&self) -> usize {
        self.along_m.len()
    }

    fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// Returns the shortest stretch from `start` that is at least `length_m` long and has at least
    /// `min_pings` pings; `None` where one of them has no usable depth, or the track ends before.
    fn stretch(&self, start: usize, length_m: f64, min_pings: usize) -> Option<Range<usize>> {
        let goal_m = self.along_m[start] + length_m;
        let end = self.along_m.partition_point(|&along_m| along_m < goal_m).max(start + min_pings);
        let complete = end < self.len() && self.sums(&(start..end))[0] == (end - start) as f64;
        complete.then_some(start..end)
    }

    /// Returns a stretch with `margin_m` more on either side.
    fn around(&self, pings: &Range<usize>, margin_m: f64) -> Range<usize> {
        let from_m = self.along_m[pings.start] - margin_m;
        let to_m = self.along_m[pings.end - 1] + margin_m;
        let place = |goal_m: f64| self.along_m.partition_point(|&along_m| along_m < goal_m);
        // Where the boat seems not to move, because a log gives one time to all pings, no distance
        // is below the goal.
        place(from_m).min(pings.start)..place(to_m).max(pings.end)
    }

    fn sums(&self, pings: &Range<usize>) -> [f64; 6] {
        let (a, b) = (self.sums[pings.start], self.sums[pings.end]);
        from_fn(|of| b[of] - a[of])
    }

    /// Returns the variation of the depth over a stretch, metres: the rise of its line plus twice
    /// the scatter about this line.
    fn variation_m(&self, pings: &Range<usize>) -> f64 {
        let (slope, scatter_m) = line_of(self.sums(pings));
        let length_m = self.along_m[pings.end - 1] - self.along_m[pings.start];
        slope.abs() * length_m + 2.0 * scatter_m
    }

    /// Returns the length of a stretch along the track, metres.
    fn way_m(&self, pings: &Range<usize>) -> f64 {
        let ends = self.along_m.get(pings.start..pings.end).unwrap_or_default();
        let ends = ends.first().zip(ends.last());
        ends.map_or(0.0, |(from_m, to_m)| to_m - from_m)
    }

    /// Returns the least-squares slope of the depth, metres a metre, and the standard deviation
    /// about its line, metres; NaN for no pings.
    fn line(&self, pings: &Range<usize>) -> (f64, f64) {
        if pings.is_empty() {
            return (f64::NAN, f64::NAN);
        }
        line_of(self.sums(pings))
    }
}

/// Returns the least-squares slope of the points that were summed, and the standard deviation about
/// the line.
fn line_of([usable, x, y, xx, xy, yy]: [f64; 6]) -> (f64, f64) {
    let n = usable.max(1.0);
    let xx = (xx - x * x / n).max(0.0);
    let xy = xy - x * y / n;
    let yy = (yy - y * y / n).max(0.0);
    let slope = if xx > 1e-6 * n { xy / xx } else { 0.0 };
    (slope, ((yy - slope * xy).max(0.0) / n).sqrt())
}

/// Largest departure of a range from its share of the depth that counts in full: a range that
/// departs by more is a wrong pick, whatever the amount.
const WRONG: f64 = 0.2;

/// Comparison of first returns with recorded depths, with running sums so that any stretch costs
/// the same.
struct DepthAgreement {
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
    fn new(picks: &[Usable], pings: usize) -> Self {
        let typical = median_of(picks.iter().map(Usable::of_depth));
        let mut sums = Vec::with_capacity(pings + 1);
        let (mut so_far, mut rest) = (Sums::default(), picks);
        sums.push(so_far);
        for ping in 0..pings {
            let here = rest.iter().take_while(|pick| pick.ping == ping).count();
            for pick in &rest[..here] {
                so_far.add(pick.side, pick.of_depth() / typical - 1.0);
            }
            rest = &rest[here..];
            sums.push(so_far);
        }
        let mut sides = Side::BOTH.to_vec();
        sides.retain(|&side| so_far.count(side) > 0.0);
        Self { sums, sides, depth_m: median_of(picks.iter().map(|pick| pick.depth_m)) }
    }

    /// Returns the possible error of the scale of a stretch, metres at the log's median depth:
    /// twice the scatter of `r / d` over both sides together, which includes a slope across the
    /// track, plus the square of the share of pings without a pick on the poorer side. A few of
    /// these pings are fish and interference; where there are many, the picks that remain were
    /// selected: over boulders and weed, they are from the pings at which these end below the
    /// margin.
    ///
    /// Zero where the log has no picks at all: then nothing distinguishes one stretch from another.
    fn doubt_m(&self, pings: &Range<usize>) -> f64 {
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
