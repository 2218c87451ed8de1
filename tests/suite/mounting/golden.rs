//! Lever arms against geodesics.

use bathyscope_log::support::geo::{LonLat, distance_m};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    Fix, HeadingSettings, HeadingSource, MountingSettings, PositionSettings, PositionShift,
    Projection, SidePing, Survey, Track, navigate_with,
};
use serde_json::Value;
use std::sync::Arc;

/// Reads the values that pyproj gives.
pub(super) fn golden() -> Value {
    serde_json::from_str(include_str!("golden.json")).expect("the goldens")
}

/// A boat at rest that heads somewhere by its compass.
fn resting(at: LonLat, heading_deg: f64) -> Survey {
    let fix = |index: i32| Fix {
        time_s: 0.1 * f64::from(index),
        position: at,
        cog_rad: f32::NAN,
        compass_rad: heading_deg.to_radians() as f32,
        speed_mps: 0.0,
    };
    Survey {
        side_scan: Arc::new(vec![SidePing {
            time_s: 1.0,
            depth_m: 3.0,
            depth_fault: None,
            port: None,
            starboard: None,
        }]),
        track: Track::new((0..20).map(fix).collect()),
        ..Survey::default()
    }
}

#[test]
fn a_transducer_lies_where_pyproj_has_it() {
    let golden = golden();
    let mut worst_m = 0.0_f64;
    for case in golden["arms"].as_array().expect("cases") {
        let number = |name: &str| case[name].as_f64().expect("a number");
        let at = |lon: &str, lat: &str| LonLat { lon_deg: number(lon), lat_deg: number(lat) };
        // A compass that is 30 degrees off, and the offset that puts it right.
        let survey = resting(at("lon", "lat"), number("heading_deg") - 30.0);
        let mounting = MountingSettings {
            forward_m: number("forward_m"),
            right_m: number("right_m"),
            heading_offset_deg: 30.0,
            ..MountingSettings::default()
        };
        let heading =
            HeadingSettings { source: HeadingSource::Compass, ..HeadingSettings::default() };
        for projection in [Projection::Enu, Projection::Mercator] {
            let positions = PositionSettings {
                heading: &heading,
                mounting: &mounting,
                shift: &PositionShift::default(),
                projection,
            };
            let made = navigate_with(&survey, positions, &Progress::new());
            let made = made.expect("nobody cancels");
            let [ping] = made.pings[..] else { panic!("one ping") };
            let found = made.to_lon_lat(&survey.track, ping.east_m, ping.north_m);
            let off_m = distance_m(found, at("to_lon", "to_lat"));
            worst_m = worst_m.max(off_m);
            assert!(off_m < 1e-4, "{projection:?} {case}: {found:?}");
            let [east_m, north_m] = made.antenna[0];
            let antenna = made.to_lon_lat(&survey.track, east_m, north_m);
            assert!(distance_m(antenna, at("lon", "lat")) < 1e-6);
        }
    }
    println!("transducers: {worst_m:.1e} m from pyproj's at most");
}
