//! Finds the passes of the boat that covered a place, and counts those that saw an object there.

use super::place::heading_sigma_rad;
use bathyscope_log::survey::{Navigation, Side, Survey};
use std::ops::Range;

/// Distance ahead or astern up to which a place is abeam of a ping, metres; half the distance
/// between the slow pings of a fast boat.
const ABEAM_M: f64 = 0.75;
/// Number of standard deviations of the heading by which [`ABEAM_M`] is widened.
const ABEAM_SIGMAS: f64 = 2.0;
/// Number of pings without the place abeam that end a pass.
const GAP: usize = 20;
/// Limits within which passes of two logs over one place are the same pass: difference in time,
/// seconds, and distance between the places of the boat, metres. Such logs are of two recorders on
/// one boat, of one recording in two formats, or of a recording that continues in another file.
const SAME_TIME_S: f64 = 2.0;
const SAME_PLACE_M: f64 = 10.0;

/// Survey and navigation of a log whose passes are counted.
pub type PassLog<'a> = (&'a Survey, &'a Navigation);

/// Index of a log, and a range of its pings.
pub type LogPings = (usize, Range<usize>);

/// Numbers of passes that saw an object, and of passes that covered its place. An object counts
/// once for each pass, however many boxes, sides or logs show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassCount {
    /// Number of passes that saw the object.
    pub seen: usize,
    /// Number of passes that covered its place, including those that saw it.
    pub covered: usize,
}

impl PassCount {
    /// Counts the passes for an object that was seen on some pings, at a place in the plane of the
    /// logs. This reads the navigation of all pings.
    pub fn new(seen: &[LogPings], place: [f64; 2], logs: &[PassLog<'_>]) -> Self {
        let mut passes = distinct_passes(seen, logs);
        let seen = passes.len();
        for (index, (survey, navigation)) in logs.iter().enumerate() {
            for pass in passes_over(survey, navigation, place) {
                let pings = (index, pass);
                if !(passes.iter().flatten()).any(|known| is_same_pass(known, &pings, logs)) {
                    passes.push(vec![pings]);
                }
            }
        }
        Self { seen, covered: passes.len() }
    }
}

/// Groups pings that show an object by the pass that they belong to.
pub(crate) fn distinct_passes(seen: &[LogPings], logs: &[PassLog<'_>]) -> Vec<Vec<LogPings>> {
    let mut passes: Vec<Vec<LogPings>> = Vec::new();
    for pings in seen {
        let is_same = |pass: &Vec<LogPings>| {
            let mut known = pass.iter();
            known.any(|known| is_same_pass(known, pings, logs))
        };
        // Pings between two parts of a pass join the parts.
        let (same, others): (Vec<_>, Vec<_>) = passes.into_iter().partition(is_same);
        passes = others;
        passes.push(same.into_iter().flatten().chain([pings.clone()]).collect());
    }
    passes
}

/// Returns true if two ranges of pings that show one place are of the same pass.
fn is_same_pass(one: &LogPings, other: &LogPings, logs: &[PassLog<'_>]) -> bool {
    let ((log, a), (other_log, b)) = (one, other);
    if log == other_log {
        return a.start < b.end + GAP && b.start < a.end + GAP;
    }
    let both = moment(one, logs).zip(moment(other, logs));
    let Some((([a_from_s, a_to_s], a), ([b_from_s, b_to_s], b))) = both else {
        return false;
    };
    let at_once = a_from_s <= b_to_s + SAME_TIME_S && b_from_s <= a_to_s + SAME_TIME_S;
    at_once && f64::hypot(a[0] - b[0], a[1] - b[1]) < SAME_PLACE_M
}

/// Returns the first and the last time of some pings, Unix seconds, and the place of the boat on
/// the middle one, metres east and north; `None` if the log does not hold the time or the place.
fn moment((log, pings): &LogPings, logs: &[PassLog<'_>]) -> Option<([f64; 2], [f64; 2])> {
    let (survey, navigation) = logs.get(*log)?;
    let start_s = survey.start_unix_s?;
    let last = pings.end.checked_sub(1)?.max(pings.start);
    let unix_s = |ping: usize| Some(start_s + survey.side_scan.get(ping)?.time_s);
    let boat = navigation.pings.get(usize::midpoint(pings.start, last))?;
    Some(([unix_s(pings.start)?, unix_s(last)?], boat.place()))
}

/// Returns the pings of every pass in which the side-scan could insonify a place (metres in the
/// survey's plane): from the first to the last ping at which the place may be abeam, given the
/// uncertainty of the heading. In a turn about the place, there are many such pings. If both sides
/// see the place, under the boat, it is still one pass.
pub fn passes_over(survey: &Survey, navigation: &Navigation, place: [f64; 2]) -> Vec<Range<usize>> {
    let mut passes: Vec<Range<usize>> = Vec::new();
    for ping in 0..navigation.pings.len() {
        if !is_abeam(survey, navigation, ping, place).unwrap_or(false) {
            continue;
        }
        match passes.last_mut() {
            Some(pass) if ping - pass.end < GAP => pass.end = ping + 1,
            _ => passes.push(ping..ping + 1),
        }
    }
    passes
}

/// Returns true if a place is abeam at a ping and within the range, false if it is ahead, astern or
/// beyond the range; `None` if the heading is not known, or the side was not recorded.
fn is_abeam(
    survey: &Survey,
    navigation: &Navigation,
    ping: usize,
    [east_m, north_m]: [f64; 2],
) -> Option<bool> {
    let boat = navigation.pings.get(ping)?;
    let [x, y] = boat.starboard()?;
    let [dx, dy] = [east_m - boat.east_m, north_m - boat.north_m];
    let (across_m, along_m) = (dx * x + dy * y, (dy * x - dx * y).abs());
    let side = if across_m < 0.0 { Side::Port } else { Side::Starboard };
    let depth_m = f64::from(survey.good_depth_m(ping));
    let slant_m = across_m.hypot(if depth_m > 0.0 { depth_m } else { 0.0 });
    let is_in_range = slant_m < f64::from(survey.span(ping, side)?.far_m);
    let askew_m = ABEAM_SIGMAS * heading_sigma_rad(navigation, &(ping..ping + 1)) * across_m.abs();
    // With a distance of NaN, the place is not abeam.
    Some(along_m < ABEAM_M.hypot(askew_m) && is_in_range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{PingNav, SidePing, SideSpan};

    /// Creates a log of a boat that heads north at 2 m/s for 20 s, 10 pings a second, passing the
    /// origin halfway. The log starts at `start_unix_s`.
    fn log(start_unix_s: Option<f64>, place_m: impl Fn(usize) -> [f64; 2]) -> (Survey, Navigation) {
        let span = SideSpan::of_bytes(100, [0.0, 10.0]);
        let side_scan = (0..200).map(|ping| SidePing {
            port: Some(span),
            starboard: Some(span),
            ..SidePing::with_depth(0.1 * f64::from(ping), 2.0)
        });
        let pings = (0..200).map(|ping| PingNav::northbound(place_m(ping), 2.0));
        let survey = Survey { start_unix_s, ..Survey::of_pings(side_scan) };
        (survey, Navigation::of_pings(pings))
    }

    fn north(ping: usize) -> f64 {
        0.2 * ping as f64 - 20.0
    }

    fn count(seen: &[LogPings], logs: &[(Survey, Navigation)]) -> PassCount {
        let logs: Vec<PassLog<'_>> = logs.iter().map(|(survey, at)| (survey, at)).collect();
        PassCount::new(seen, [0.0, 0.0], &logs)
    }

    #[test]
    fn both_sides_of_one_pass_are_one_sighting() {
        // The boat sails a wavy line over the place: the place is to port and to starboard in
        // turns.
        let over = log(None, |ping| [0.3 * (ping as f64 * 0.8).sin(), north(ping)]);
        let both = [(0, 99..100), (0, 100..101)];
        let once = PassCount { seen: 1, covered: 1 };
        assert_eq!(count(&both, &[over]), once);
    }

    #[test]
    fn one_pass_in_two_logs_is_one_and_another_time_is_another() {
        let line = |start_s| log(start_s, |ping| [4.0, north(ping)]);
        let seen = [(0, 98..103)];
        let two = |start_s| [line(Some(1000.0)), line(start_s)];
        let covered = |start_s| count(&seen, &two(start_s)).covered;
        assert_eq!(covered(Some(1000.4)), 1, "the same recording");
        assert_eq!(covered(Some(4000.0)), 2, "the line sailed again");
        assert_eq!(covered(None), 2, "nobody knows when");
        let both = [(0, 98..103), (1, 97..104)];
        assert_eq!(count(&both, &two(Some(1000.4))).seen, 1);
        assert_eq!(count(&both, &two(Some(4000.0))).seen, 2);
        // Another boat at the same time, 15 m away.
        let other = log(Some(1000.0), |ping| [-11.0, north(ping)]);
        assert_eq!(count(&both, &[line(Some(1000.0)), other]).seen, 2);
    }

    #[test]
    fn a_pass_that_did_not_see_the_object_is_covered_only() {
        // The boat goes there and back: it passes the place at pings 50 and 150.
        let turned = log(None, |ping| [4.0, 0.2 * (ping as f64 - 100.0).abs() - 10.0]);
        let seen = [(0, 48..53)];
        let found = count(&seen, &[turned]);
        assert_eq!([found.seen, found.covered], [1, 2]);
    }
}
