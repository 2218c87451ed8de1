//! Surveys made up for the waterfall: an even bottom, and a pond with a target and a change of
//! range.

use bathyscope_bottom::first_return::{FirstReturns, Pick};
use bathyscope_log::survey::{
    Bytes, Encoding, SampleOrder, Side, SidePing, SideScanState, SideSpan, Survey,
};
use std::sync::Arc;

pub(super) fn survey_of(
    bytes: Vec<u8>,
    spans: impl Iterator<Item = [Option<SideSpan>; 2]>,
) -> Survey {
    let side_scan = spans.enumerate().map(|(ping, [port, starboard])| SidePing {
        time_s: ping as f64 * 0.05,
        depth_m: 4.0,
        depth_fault: None,
        port,
        starboard,
    });
    Survey {
        side_scan: Arc::new(side_scan.collect()),
        side_scan_state: SideScanState::Usable,
        bytes: vec![Bytes::Held(bytes.into())],
        ..Survey::default()
    }
}

pub(super) fn span(offset: usize, count: u32, far_m: f32) -> SideSpan {
    SideSpan {
        file: 0,
        encoding: Encoding::U8,
        order: SampleOrder::NearToFar,
        offset: offset as u64,
        count,
        near_m: 0.0,
        far_m,
    }
}

/// 20 m to each side in 400 samples; a bottom at 4 m under dark water, brighter to starboard, every
/// ping the same.
pub(super) fn even_bottom(pings: usize) -> Survey {
    let side = |gain: usize| {
        (0..400_usize).map(move |sample| match sample {
            0..80 => 8,
            _ => (gain * (480 - sample) / 400) as u8,
        })
    };
    let bytes = side(120).chain(side(220)).collect();
    let spans = [Some(span(0, 400, 20.0)), Some(span(400, 400, 20.0))];
    survey_of(bytes, std::iter::repeat_n(spans, pings))
}

/// A bed that rises and falls, with ripples, a target with its shadow to starboard, and a range
/// that is halved for the last third of the pings.
pub(super) fn pond() -> Survey {
    let (mut bytes, mut spans) = (Vec::new(), Vec::new());
    for ping in 0..600_usize {
        let far_m = if ping < 400 { 20.0 } else { 10.0 };
        let bed_m = bed_m(ping);
        let mut sides = [None, None];
        for side in Side::BOTH {
            sides[side as usize] = Some(span(bytes.len(), 400, far_m));
            for sample in 0..400 {
                let range_m = (sample as f32 + 0.5) / 400.0 * far_m;
                let target = side == Side::Starboard && (200..206).contains(&ping);
                bytes.push(match range_m {
                    range_m if range_m < 0.3 => 230,
                    range_m if range_m < bed_m => 12,
                    range_m if target && (9.0..9.6).contains(&range_m) => 255,
                    range_m if target && (9.6..12.0).contains(&range_m) => 5,
                    _ => {
                        let ripples = (range_m * 2.0 + ping as f32 * 0.05).sin() * 14.0;
                        (150.0 * (bed_m / range_m).sqrt() + ripples) as u8
                    }
                });
            }
        }
        spans.push(sides);
    }
    survey_of(bytes, spans.into_iter())
}

pub(super) fn bed_m(ping: usize) -> f32 {
    4.0 + 1.5 * (ping as f32 * 0.015).sin()
}

/// First returns on the bed of [`pond`]: a gap on port, above-bottom returns on starboard.
pub(super) fn pond_returns(survey: &Survey) -> FirstReturns {
    let picks = |side: Side| -> Vec<Pick> {
        let pick = |(ping, recorded): (usize, &SidePing)| {
            let span = recorded.side(side).expect("both sides are recorded");
            let pick = Pick {
                sample: span.sample_at(f64::from(bed_m(ping))) as f32,
                confidence: 0.9,
                above_bottom: side == Side::Starboard && (80..180).contains(&ping),
            };
            if side == Side::Port && (250..300).contains(&ping) { Pick::NONE } else { pick }
        };
        survey.side_scan.iter().enumerate().map(pick).collect()
    };
    FirstReturns {
        port: Arc::new(picks(Side::Port)),
        starboard: Arc::new(picks(Side::Starboard)),
        ..FirstReturns::default()
    }
}
