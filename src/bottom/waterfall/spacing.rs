//! Distance that the boat moves from one ping to the next.

use bathyscope_log::survey::{Fix, Survey};

/// Stretches of the track whose lengths are compared, at most.
const STRETCHES: usize = 400;
/// Length of a stretch, seconds: fixes repeat, and their scatter adds to the way of a shorter one.
const STRETCH_S: f64 = 10.0;
/// A boat that moves less than this in a stretch lies still, metres.
const STILL_M: f64 = 1.0;
/// Bounds of what is believed, metres a ping.
const BELIEVED_M: [f64; 2] = [1e-3, 50.0];

/// Median over the moving stretches of a track of the metres that the boat moved for each ping;
/// `None` where it does not say.
pub(super) fn ping_spacing_m(survey: &Survey) -> Option<f64> {
    let (first, last) = (survey.side_scan.first()?, survey.side_scan.last()?);
    let span_s = last.time_s - first.time_s;
    let interval_s = span_s / (survey.side_scan.len().checked_sub(1)? as f64);
    let fixes = &survey.track.fixes;
    let count = ((span_s / STRETCH_S) as usize).clamp(1, STRETCHES);
    let long_s = STRETCH_S.min(span_s);
    let mut speeds_mps: Vec<f64> = (0..count)
        .filter_map(|stretch| {
            let share = (stretch as f64 + 0.5) / count as f64;
            let middle_s = first.time_s + share * span_s;
            let [from, to] = [-0.5, 0.5].map(|half| at(fixes, middle_s + half * long_s));
            let (from, to) = (from?, to?);
            let seconds = to.time_s - from.time_s;
            let frame = &survey.track.frame;
            let [a, b] = [from, to].map(|fix| frame.to_enu(fix.position));
            let metres = (b[0] - a[0]).hypot(b[1] - a[1]);
            (seconds > 0.0 && metres > STILL_M).then(|| metres / seconds)
        })
        .collect();
    let metres = bathyscope_log::support::statistics::median(&mut speeds_mps) * interval_s;
    (BELIEVED_M[0]..=BELIEVED_M[1]).contains(&metres).then_some(metres)
}

/// The last fix up to a time, or the first.
fn at(fixes: &[Fix], time_s: f64) -> Option<&Fix> {
    let after = fixes.partition_point(|fix| fix.time_s <= time_s);
    fixes.get(after.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::{LocalFrame, LonLat};
    use bathyscope_log::survey::{SidePing, Track};

    /// A boat at 2 m/s that lies still for a third of the time; ten pings and one fix a second.
    #[test]
    fn stops_do_not_shorten_the_spacing() {
        let origin = LonLat::new(-111.5, 36.8);
        let frame = LocalFrame::new(origin);
        let fixes = (0..300).map(|second| {
            Fix::at(f64::from(second), frame.to_lon_lat(2.0 * f64::from(second.min(200)), 0.0))
        });
        let ping = |index: i32| SidePing::with_depth(f64::from(index) / 10.0, f32::NAN);
        let survey =
            Survey { track: Track::new(fixes.collect()), ..Survey::of_pings((0..3000).map(ping)) };
        let metres = ping_spacing_m(&survey).expect("a spacing");
        assert!((metres - 0.2).abs() < 0.005, "{metres}");
        assert_eq!(ping_spacing_m(&Survey::default()), None);
    }
}
