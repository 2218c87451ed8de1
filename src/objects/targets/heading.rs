//! Uncertainty of the heading.

use bathyscope_log::survey::Navigation;
use std::ops::Range;

/// Standard deviation of a heading from the fitted track, radians (2 degrees), and what a turn
/// adds: a share of the change of heading over so many pings before and behind.
const HEADING_SIGMA_RAD: f64 = 0.035;
const TURN_SIGMA: f64 = 0.08;
const TURN_PINGS: usize = 20;

/// Standard deviation of the heading over some pings, radians: in a turn the line that is fitted to
/// the fixes lags behind.
pub(super) fn heading_sigma_rad(navigation: &Navigation, pings: &Range<usize>) -> f64 {
    HEADING_SIGMA_RAD.hypot(TURN_SIGMA * turn_rad(navigation, pings))
}

/// Change of the heading around some pings, 0 to pi; 0 where it is not known.
fn turn_rad(navigation: &Navigation, pings: &Range<usize>) -> f64 {
    let heading = |ping: usize| navigation.pings.get(ping).map(|place| place.heading_rad);
    let last = navigation.pings.len().saturating_sub(1);
    let from = heading(pings.start.saturating_sub(TURN_PINGS));
    let to = heading((pings.end + TURN_PINGS).min(last));
    let change = from.zip(to).map_or(0.0, |(from, to)| (to - from).cos());
    if change.is_finite() { change.clamp(-1.0, 1.0).acos() } else { 0.0 }
}
