//! A survey for the tests of this room.

use crate::survey::{
    Bytes, Encoding, Navigation, Order, PingNav, Projection, SidePing, SideSpan, Survey,
};
use std::sync::Arc;

/// Pings a tenth of a second apart at 2 m/s: 0.2 m each, 100 samples over 10 m, sample i of ping p holding `level`.
pub(super) fn survey(pings: usize, level: impl Fn(usize, usize) -> u8) -> (Survey, Navigation) {
    let bytes: Vec<u8> = (0..pings)
        .flat_map(|ping| (0..100).map(move |sample| (ping, sample)))
        .map(|(ping, sample)| level(ping, sample))
        .collect();
    let side_scan = (0..pings).map(|ping| SidePing {
        time_s: ping as f64 * 0.1,
        depth_m: 2.0,
        depth_locked: true,
        port: Some(SideSpan {
            file: 0,
            encoding: Encoding::U8,
            order: Order::NearToFar,
            offset: ping as u64 * 100,
            count: 100,
            near_m: 0.0,
            far_m: 10.0,
        }),
        starboard: None,
    });
    let survey = Survey {
        side_scan: Arc::new(side_scan.collect()),
        bytes: vec![Bytes::Held(bytes.into())],
        ..Survey::default()
    };
    (survey, navigation_of(pings))
}

/// A boat at 2 m/s, always at the same place of the map: what only counts its way does not mind.
pub(super) fn navigation_of(pings: usize) -> Navigation {
    let place = PingNav {
        east_m: 0.0,
        north_m: 0.0,
        heading_rad: 0.0,
        speed_mps: 2.0,
    };
    Navigation {
        antenna: Arc::default(),
        pings: vec![place; pings].into(),
        soundings: Arc::default(),
        projection: Projection::Enu,
        zero_heading: 0,
        moving: pings,
    }
}
