//! Creates surveys for the tests of this crate.

use bathyscope_log::survey::{Bytes, Navigation, PingNav, SidePing, SideSpan, Survey};

/// Creates a survey of pings a tenth of a second apart at 2 m/s, which is 0.2 m for each ping, with
/// 100 samples over 10 m; sample i of ping p has the level `level(p, i)`.
pub(super) fn survey(pings: usize, level: impl Fn(usize, usize) -> u8) -> (Survey, Navigation) {
    let bytes: Vec<u8> = (0..pings)
        .flat_map(|ping| (0..100).map(move |sample| (ping, sample)))
        .map(|(ping, sample)| level(ping, sample))
        .collect();
    let side_scan = (0..pings).map(|ping| SidePing {
        port: Some(SideSpan { offset: ping as u64 * 100, ..SideSpan::of_bytes(100, [0.0, 10.0]) }),
        ..SidePing::with_depth(ping as f64 * 0.1, 2.0)
    });
    let survey = Survey { bytes: vec![Bytes::Held(bytes.into())], ..Survey::of_pings(side_scan) };
    (survey, navigation_of(pings))
}

/// Creates the navigation of a boat with a speed of 2 m/s that stays at the same place on the map,
/// for tests that use only the distance sailed.
pub(super) fn navigation_of(pings: usize) -> Navigation {
    Navigation::of_pings(vec![PingNav::northbound([0.0; 2], 2.0); pings])
}
