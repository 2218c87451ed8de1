//! Joins the port and the starboard half of a ping where a recorder writes them apart.

use super::collected::HalfPing;
use crate::support::statistics::upper_median;
use crate::survey::SidePing;

/// Two halves without any other measure of the ping rate belong together within this time, seconds.
const HALVES_TOGETHER_S: f64 = 0.1;

/// Joins port and starboard halves that were recorded at the same time (within half a ping); the
/// others stay alone.
pub(super) fn join_halves(port: &[HalfPing], starboard: &[HalfPing]) -> Vec<SidePing> {
    let within_s =
        interval_s(port).or(interval_s(starboard)).map_or(HALVES_TOGETHER_S, |s| s / 2.0);
    let mut pings = Vec::with_capacity(port.len().max(starboard.len()));
    let (mut p, mut s) = (0, 0);
    while let (Some(left), Some(right)) = (port.get(p), starboard.get(s)) {
        let apart_s = apart_s(left, right);
        // A half whose partner is damaged must not take the neighbour's: the closer pair wins.
        let left_is_alone = nearer(port.get(p + 1), right, apart_s);
        let right_is_alone = nearer(starboard.get(s + 1), left, apart_s);
        let too_far = apart_s > within_s;
        if left_is_alone || (too_far && left.time_s < right.time_s) {
            pings.push(ping(Some(left), None));
            p += 1;
        } else if right_is_alone || too_far {
            pings.push(ping(None, Some(right)));
            s += 1;
        } else {
            pings.push(ping(Some(left), Some(right)));
            p += 1;
            s += 1;
        }
    }
    pings.extend(port[p..].iter().map(|left| ping(Some(left), None)));
    pings.extend(starboard[s..].iter().map(|right| ping(None, Some(right))));
    pings
}

fn apart_s(a: &HalfPing, b: &HalfPing) -> f64 {
    (a.time_s - b.time_s).abs()
}

fn nearer(next: Option<&HalfPing>, other: &HalfPing, than_s: f64) -> bool {
    next.is_some_and(|next| apart_s(next, other) < than_s)
}

fn ping(port: Option<&HalfPing>, starboard: Option<&HalfPing>) -> SidePing {
    SidePing {
        time_s: port.or(starboard).map_or(f64::NAN, |half| half.time_s),
        depth_m: f32::NAN,
        depth_fault: None,
        port: port.map(|half| half.span),
        starboard: starboard.map(|half| half.span),
    }
}

/// The median time between pings; `None` below three pings.
fn interval_s(halves: &[HalfPing]) -> Option<f64> {
    let mut steps: Vec<f64> =
        halves.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    if steps.len() < 2 {
        return None;
    }
    upper_median(&mut steps, f64::total_cmp).filter(|median| *median > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{Encoding, SampleOrder, SideSpan};

    fn halves(times_s: &[f64]) -> Vec<HalfPing> {
        let span = SideSpan {
            file: 0,
            encoding: Encoding::U8,
            order: SampleOrder::NearToFar,
            offset: 0,
            count: 1,
            near_m: 0.0,
            far_m: 1.0,
        };
        times_s.iter().map(|&time_s| HalfPing { time_s, span }).collect()
    }

    /// `b` for both sides, `p` and `s` for one.
    fn joined(port_s: &[f64], starboard_s: &[f64]) -> String {
        let letter = |ping: &SidePing| match (ping.port, ping.starboard) {
            (Some(_), Some(_)) => 'b',
            (Some(_), None) => 'p',
            _ => 's',
        };
        join_halves(&halves(port_s), &halves(starboard_s)).iter().map(letter).collect()
    }

    #[test]
    fn halves_find_their_partners() {
        assert_eq!(joined(&[0.0, 0.1, 0.2], &[0.01, 0.11, 0.21]), "bbb");
        assert_eq!(joined(&[0.0, 0.1, 0.2, 0.3], &[0.01, 0.21, 0.31]), "bpbb");
        assert_eq!(joined(&[0.1, 0.2], &[0.0, 0.1, 0.2, 0.3]), "sbbs");
        assert_eq!(joined(&[0.0, 0.1, 0.2], &[]), "ppp");
        assert_eq!(joined(&[], &[5.0]), "s");
        // Interleaved, the later side 40 % of a ping behind: still the same ping.
        assert_eq!(joined(&[0.0, 1.0, 2.0], &[0.4, 1.4, 2.4]), "bbb");
    }
}
