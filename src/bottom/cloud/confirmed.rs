//! Soundings that stand out like glitches and are none: a rock or a pile under the boat is passed
//! in a few soundings, as a wrong depth is, but the side-scan sees it too.

use bathyscope_log::survey::{Sounding, Survey, nearest_in_time};

/// More soundings than this in a row with a fault are a loss of the bottom, in which the
/// depth may meet a first return by chance.
const LONGEST: usize = 4;
/// A first return is at the depth of a sounding within this, metres: a part of what a sounding
/// stands out by.
const WITHIN_M: f64 = 0.15;

/// Returns a flag for each sounding, true if it counts although it stands out from those around it:
/// the recorder had the bottom right before and after it, and a first return of the nearest ping,
/// or of the one before or behind that, lies at its depth. `ranges_m` are the ranges of port and
/// starboard, NaN without a first return, on the scale of `altitude_m`.
pub(super) fn confirmed(
    survey: &Survey,
    ranges_m: &[Vec<f64>; 2],
    altitude_m: impl Fn(f64) -> f64,
) -> Vec<bool> {
    let is_confirmed = |sounding: &Sounding| {
        let depth_m = altitude_m(f64::from(sounding.depth_m));
        let ping = nearest_in_time(&survey.side_scan, sounding.time_s, |one| one.time_s);
        let near = ping.map_or(0..0, |ping| ping.saturating_sub(1)..ping + 2);
        let ranges = ranges_m.iter().flat_map(|side| side.get(near.clone()));
        let mut ranges = ranges.flatten();
        ranges.any(|range_m| (range_m - depth_m).abs() <= WITHIN_M)
    };
    let mut confirmed = vec![false; survey.soundings.len()];
    let mut start = 0;
    for run in survey.soundings.chunk_by(|a, b| a.is_good() == b.is_good()) {
        let end = start + run.len();
        let is_between = start > 0 && end < survey.soundings.len();
        if !run[0].is_good() && is_between && run.len() <= LONGEST {
            for (sounding, confirmed) in run.iter().zip(&mut confirmed[start..end]) {
                *confirmed = is_confirmed(sounding);
            }
        }
        start = end;
    }
    confirmed
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, mark_faults};
    use std::sync::Arc;

    /// Soundings of 3 m but for a stretch of them, at every other of pings whose port sees `port_m`
    /// there and whose starboard sees the bed.
    fn confirmed_at(stretch: std::ops::Range<usize>, depth_m: f32, port_m: f64) -> Vec<usize> {
        let mut soundings: Vec<Sounding> = (0..60)
            .map(|index| {
                let depth_m = if stretch.contains(&index) { depth_m } else { 3.0 };
                Sounding::new(0.2 * index as f64, depth_m)
            })
            .collect();
        mark_faults(&mut soundings, &[], true);
        let ping = |ping: usize| SidePing::with_depth(0.1 * ping as f64, 3.0);
        let survey =
            Survey { soundings: Arc::new(soundings), ..Survey::of_pings((0..120).map(ping)) };
        let port = (0..120).map(|ping| if stretch.contains(&(ping / 2)) { port_m } else { 3.0 });
        let ranges_m = [port.collect(), vec![3.0; 120]];
        let all = confirmed(&survey, &ranges_m, |depth_m| depth_m);
        (0..60).filter(|index| all[*index]).collect()
    }

    #[test]
    fn a_rock_that_one_side_sees_counts_and_a_glitch_that_none_sees_does_not() {
        assert_eq!(confirmed_at(30..32, 2.4, 2.45), [30, 31]);
        assert!(confirmed_at(30..32, 2.4, 3.0).is_empty());
        assert!(confirmed_at(30..31, 9.0, 2.45).is_empty());
    }

    #[test]
    fn a_depth_that_keeps_its_lock_needs_no_first_return() {
        assert!(confirmed_at(30..45, 2.4, 2.45).is_empty());
    }
}
