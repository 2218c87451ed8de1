//! Finds stretches where the bottom is flat along the track, and both sides detect it.

use super::FlatSpot;
use super::agreement::DepthAgreement;
use super::profile::Profile;
use super::scale::{Usable, header_factor, inside, pixels_per_metre, usable_picks};
use crate::first_return::FirstReturns;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::{Navigation, Side, Survey};
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
        median(&mut of_side.map(|pick| pick.range_m / pick.depth_m).collect::<Vec<_>>())
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
