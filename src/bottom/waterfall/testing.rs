//! Creates surveys for the tests of this module: pings over a buffer of bytes.

use bathyscope_log::survey::{Bytes, SidePing, SideScanState, SideSpan, Survey};

/// Creates a survey whose pings have the given spans of port and starboard.
pub(super) fn survey(bytes: Vec<u8>, spans: Vec<[Option<SideSpan>; 2]>) -> Survey {
    let side_scan = spans.into_iter().enumerate().map(|(ping, [port, starboard])| SidePing {
        port,
        starboard,
        ..SidePing::with_depth(ping as f64, f32::NAN)
    });
    Survey {
        side_scan_state: SideScanState::Usable,
        bytes: vec![Bytes::Held(bytes.into())],
        ..Survey::of_pings(side_scan)
    }
}

/// Creates a span of `count` samples from `offset`, near to far, over 0 to `far_m`.
pub(super) fn span(offset: usize, count: u32, far_m: f32) -> SideSpan {
    SideSpan { offset: offset as u64, ..SideSpan::of_bytes(count, [0.0, far_m]) }
}

/// Returns bytes that look random and are always the same (a linear congruential generator).
pub(super) fn noise(count: usize) -> Vec<u8> {
    let mut state = 12_345_u32;
    let next = |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..count).map(next).collect()
}

/// Creates a survey of `pings` pings with `count` noisy samples a side, all of one scale: 64
/// samples a metre, exact in binary.
pub(super) fn even(pings: usize, count: usize) -> Survey {
    let far_m = count as f32 / 64.0;
    let spans = (0..pings).map(|ping| {
        let side = |side: usize| Some(span((2 * ping + side) * count, count as u32, far_m));
        [side(0), side(1)]
    });
    survey(noise(2 * pings * count), spans.collect())
}
