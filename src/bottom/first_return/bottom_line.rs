//! Chooses the bottom line, the bottom that the picture is laid out by: the first returns or the
//! recorded depths.
//!
//! Water column, ground range, gain normalisation and mosaic follow the bottom line. Points,
//! calibration and residuals always use the first returns: points at the recorded depth would be no
//! measurements, and would agree with that depth exactly.

use super::{FirstReturns, Pick};
use bathyscope_log::survey::{Side, SideSpan, Survey};
use serde::{Deserialize, Serialize};

/// Source of the bottom line. Bottom edits replace either source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BottomLine {
    /// The first return of each side.
    #[default]
    Search,
    /// The depth of the recorder's own sounding, the same on both sides; the first return where the
    /// recorder had lost the bottom.
    Recorded,
}

/// Returns the bottom line at the recorded depths. Manual picks stay; the first returns stay where
/// there is no depth to believe or the depth is beyond the recorded range. `sample_at` converts a
/// depth into a sample of a recorded side, with the calibration in use. A warning counts the places
/// without a recorded depth.
pub fn at_recorded_depth(
    survey: &Survey,
    returns: &FirstReturns,
    sample_at: impl Fn(&SideSpan, f64) -> f64,
) -> FirstReturns {
    let mut line = returns.clone();
    let (mut found, mut places) = (0, 0);
    for side in Side::BOTH {
        let drawn = drawn(returns, side);
        let recorded = line.side_mut(side).iter_mut().zip(drawn).enumerate();
        for (ping, (pick, is_drawn)) in recorded {
            let Some(span) = survey.span(ping, side).filter(|_| !is_drawn) else {
                continue;
            };
            places += 1;
            let depth_m = f64::from(survey.good_depth_m(ping));
            let sample = sample_at(span, depth_m);
            if (0.0..=f64::from(span.count)).contains(&sample) {
                *pick = Pick { sample: sample as f32, confidence: 1.0, above_bottom: false };
            } else {
                found += 1;
            }
        }
    }
    if found > 0 {
        line.warnings.push(format!(
            "the bottom line is the first return at {found} of {places} places, both sides counted: the recorder has no depth there"
        ));
    }
    line
}

/// Returns for each ping true if its pick on a side is a manual one.
fn drawn(returns: &FirstReturns, side: Side) -> Vec<bool> {
    let mut drawn = vec![false; returns.side(side).len()];
    for (_, [first, last]) in returns.drawn.iter().filter(|(of, _)| *of == side) {
        let end = drawn.len().min(last.saturating_add(1));
        if let Some(pings) = drawn.get_mut(*first..end) {
            pings.fill(true);
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, SoundingFault};
    use std::sync::Arc;

    #[test]
    fn edits_stay_and_what_was_not_recorded_is_searched_and_said() {
        let span = SideSpan::of_bytes(1000, [0.0, 20.0]);
        let ping = |depth_m: f32, depth_fault| SidePing {
            time_s: 0.0,
            depth_m,
            depth_fault,
            port: Some(span),
            starboard: None,
        };
        // A depth; one that was drawn over; one with a fault; none; one beyond the range.
        let side_scan = vec![
            ping(4.0, None),
            ping(4.0, None),
            ping(4.0, Some(SoundingFault::LostBottom)),
            ping(f32::NAN, None),
            ping(30.0, None),
        ];
        let survey = Survey::of_pings(side_scan);
        let pick = |sample| Pick { sample, confidence: 0.5, above_bottom: true };
        let returns = FirstReturns {
            port: Arc::new((0..5).map(|ping| pick(100.0 + ping as f32)).collect()),
            starboard: vec![Pick::NONE; 5].into(),
            drawn: vec![(Side::Port, [1, 1])],
            ..FirstReturns::default()
        };
        // Echoes lie 0.1 m farther out than by the recorder's scale.
        let line =
            at_recorded_depth(&survey, &returns, |span, depth_m| span.sample_at(depth_m + 0.1));
        let samples: Vec<f32> = line.port.iter().map(|pick| pick.sample).collect();
        assert_eq!(samples, [205.0, 101.0, 102.0, 103.0, 104.0]);
        assert!(!line.port[0].above_bottom && line.port[2].above_bottom);
        assert_eq!(line.drawn, returns.drawn);
        assert!(line.starboard.iter().all(|pick| !pick.is_some()));
        assert!(line.warnings[0].contains("at 3 of 4 places"), "{:?}", line.warnings);
    }
}
