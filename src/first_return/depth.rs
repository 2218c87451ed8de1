//! The recorded depth where it can be believed.
//!
//! A recorder that loses the bottom goes on writing depths: on the real river the last third of the log jumps between one
//! and four times the depth within a second. Such depths must neither pull the tracker nor flag its picks as canopy.

use crate::survey::Survey;

/// Pings between depths that are compared: about half a second.
const STEP: usize = 10;

/// Pings to both sides over which the recorder must be steady.
const REACH: usize = 40;

/// Departure from the straight line between neighbours that is still steady, as a share of the depth and in metres.
const STEADY: (f32, f32) = (0.05, 0.1);

/// Departure from both neighbours that makes a single depth a glitch, metres.
const GLITCH_M: f32 = 0.5;

/// The recorded depth at a ping; NaN where none was recorded or the recorder jumps about there.
pub fn steady_depth_m(survey: &Survey, ping: usize) -> f32 {
    let depth_at = |ping: usize| {
        survey
            .side_scan
            .get(ping)
            .map_or(f32::NAN, |ping| ping.depth_m)
    };
    let depth_m = depth_at(ping);
    if !(depth_m.is_finite() && depth_m > 0.0) {
        return f32::NAN;
    }
    let last = survey.side_scan.len() - 1;
    let bend = |ping: usize| {
        // At the ends of the log, that of the nearest ping with two neighbours.
        let ping = ping.min(last.saturating_sub(STEP)).max(STEP.min(last));
        let neighbours = depth_at(ping.saturating_sub(STEP)) + depth_at((ping + STEP).min(last));
        (depth_at(ping) - 0.5 * neighbours).abs()
    };
    // Bends around the ping, at every fourth one, by rank: half of them must be small.
    let mut bends = [0.0; 2 * REACH / 4 + 1];
    for (index, value) in bends.iter_mut().enumerate() {
        *value = bend((ping + 4 * index).saturating_sub(REACH));
    }
    let middle = bends.len() / 2;
    let (_, typical, _) = bends.select_nth_unstable_by(middle, f32::total_cmp);
    let steady = *typical <= STEADY.0 * depth_m + STEADY.1;
    let off = |other: usize| (depth_m - depth_at(other)).abs() > GLITCH_M.max(STEADY.0 * depth_m);
    let glitch = off(ping.saturating_sub(STEP)) && off((ping + STEP).min(last));
    if steady && !glitch { depth_m } else { f32::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{SidePing, SideScanState, Source, Track};

    fn survey(depths: impl Iterator<Item = f32>) -> Survey {
        let ping = |depth_m| SidePing {
            time_s: 0.0,
            depth_m,
            port: None,
            starboard: None,
        };
        Survey {
            source: Source {
                files: Vec::new(),
                format: String::new(),
                byte_count: 0,
            },
            start_unix_s: None,
            channels: Vec::new(),
            side_scan: depths.map(ping).collect(),
            side_scan_state: SideScanState::Usable,
            soundings: Vec::new(),
            track: Track::new(Vec::new()),
            warnings: Vec::new(),
            bytes: Vec::new(),
        }
    }

    #[test]
    fn slopes_are_steady_and_jumps_are_not() {
        let slope = survey((0..200).map(|ping| 2.0 + 0.05 * ping as f32));
        assert!((0..200).all(|ping| steady_depth_m(&slope, ping) > 0.0));
        let lost = survey((0..200).map(|ping| [1.5, 5.0, 3.0, 1.5, 6.0][ping / 7 % 5]));
        assert!(
            (20..180)
                .filter(|&ping| steady_depth_m(&lost, ping) > 0.0)
                .count()
                < 16
        );
        let one = survey((0..200).map(|ping| if (100..104).contains(&ping) { 6.0 } else { 2.0 }));
        assert!(
            (0..200).all(|ping| steady_depth_m(&one, ping).is_nan() == (100..104).contains(&ping))
        );
        let none = survey([f32::NAN, 2.0, 0.0].into_iter());
        assert!(steady_depth_m(&none, 0).is_nan() && steady_depth_m(&none, 2).is_nan());
    }
}
