//! Creates surveys and targets for the tests of this crate.

use super::targets::Target;
use super::{Mark, ObjectExtent};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{Bytes, Navigation, PingNav, Side, SidePing, SideSpan, Survey};

/// Creates a survey with side-scan on the port side only, and its navigation. The pings are a tenth
/// of a second and 0.2 m apart (2 m/s), with 100 samples over 10 m; sample `i` of ping `p` has the
/// level `level(p, i)`.
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

/// Creates a target without a height, seen to port at the survey's origin by a boat that heads
/// north.
pub(super) fn target() -> Target {
    Target {
        mark: Mark::new(Side::Port, 100..105, [1.0, 2.0]),
        extent: ObjectExtent::Found,
        measured_shadow: None,
        parts: None,
        slant_m: 5.0,
        ground_m: 4.0,
        altitude_m: 3.0,
        east_m: 0.0,
        north_m: 0.0,
        position: LonLat::new(0.0, 0.0),
        length_m: 0.6,
        width_m: 0.4,
        height_m: f64::NAN,
        shadow_m: [f64::NAN; 2],
        height_sigma_m: f64::NAN,
        depth_m: 3.0,
        sigma_m: 0.3,
        along_sigma_m: 0.3,
        across_sigma_m: 0.3,
        heading_rad: 0.0,
        sailed_m: 10.0,
    }
}
