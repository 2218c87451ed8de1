//! Turn rate of the boat, from its places a little before and a little after.

use super::PingNav;

/// Time to look back and ahead, seconds.
const LOOK_S: f64 = 2.0;
/// Shortest way that has a direction, metres.
const LEAST_WAY_M: f64 = 0.3;

/// Turn rate at every place, degrees a second; 0 where the boat hardly moves. Times rise, one for
/// each place.
pub fn turn_rates_deg_s(times_s: &[f64], places: &[PingNav]) -> Vec<f32> {
    let (mut before, mut after) = (0, 0);
    (0..times_s.len().min(places.len()))
        .map(|ping| {
            while times_s[before] < times_s[ping] - LOOK_S {
                before += 1;
            }
            while after + 1 < times_s.len() && times_s[after] < times_s[ping] + LOOK_S {
                after += 1;
            }
            let turn_rad = turn_rad(&places[before], &places[ping], &places[after]);
            // The mean directions of both ways are half the whole time apart.
            let apart_s = 0.5 * (times_s[after] - times_s[before]);
            (turn_rad.to_degrees() / apart_s.max(0.1)) as f32
        })
        .collect()
}

/// Angle between the way to a place and the way on from it, 0 to pi.
fn turn_rad(before: &PingNav, here: &PingNav, after: &PingNav) -> f64 {
    let way = |from: &PingNav, to: &PingNav| [to.east_m - from.east_m, to.north_m - from.north_m];
    let (come, go) = (way(before, here), way(here, after));
    let long = |way: [f64; 2]| way[0].hypot(way[1]) > LEAST_WAY_M;
    if !(long(come) && long(go)) {
        return 0.0;
    }
    let dot = come[0] * go[0] + come[1] * go[1];
    let cross = come[0] * go[1] - come[1] * go[0];
    cross.atan2(dot).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_turns_at_its_rate_and_a_line_does_not() {
        let times: Vec<f64> = (0..200).map(|ping| 0.1 * f64::from(ping)).collect();
        // Ten seconds straight at 1.5 m/s, then a circle at 9 degrees a second.
        let rate = 9_f64.to_radians();
        let place = |time_s: f64| {
            let turned = rate * (time_s - 10.0).max(0.0);
            let along = 1.5 * time_s.min(10.0) + 1.5 / rate * turned.sin();
            [1.5 / rate * (1.0 - turned.cos()), along]
        };
        let places = times.iter();
        let places = places.map(|&time_s| PingNav::northbound(place(time_s), 1.5));
        let places: Vec<PingNav> = places.collect();
        let rates = turn_rates_deg_s(&times, &places);
        assert!(rates[40] < 0.01, "{}", rates[40]);
        assert!((rates[150] - 9.0).abs() < 0.3, "{}", rates[150]);
    }
}
