//! The demo survey, written as a picture and a table as another program would, opens as the log
//! that it is.

use crate::truth::results;
use bathyscope_bottom::first_return::{Pick, detect};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey, navigate_with};
use bathyscope_products::pipeline::{Derived, ProcessedLog, Settings};
use bathyscope_test_support::demo_log;
use image::GrayImage;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Writes a row of pixels and a row of the table for each ping, both sides as long.
fn write_pair(log: &Survey, folder: &Path) {
    let positions = Settings::default();
    let navigation = navigate_with(log, positions.position_settings(), &Progress::new());
    let navigation = navigation.expect("a track");
    let start_s = log.start_unix_s.unwrap_or(1e9);
    let mut table = "time,lon,lat,depth_m,range_m\n".to_owned();
    let mut levels = Vec::new();
    for (index, (ping, place)) in log.side_scan.iter().zip(&*navigation.pings).enumerate() {
        let side = |side| log.samples(index, side).expect("samples");
        let [port, starboard] = Side::BOTH.map(side);
        levels.extend((0..port.len()).rev().map(|at| port.get(at)));
        levels.extend((0..starboard.len()).map(|at| starboard.get(at)));
        let at = log.track.frame.to_lon_lat(place.east_m, place.north_m);
        let far_m = log.span(index, Side::Port).expect("a span").far_m;
        let time_s = start_s + ping.time_s;
        let (lon, lat, depth_m) = (at.lon_deg, at.lat_deg, ping.depth_m);
        writeln!(table, "{time_s:.3},{lon:.9},{lat:.9},{depth_m},{far_m}").expect("a row");
    }
    let height = log.side_scan.len() as u32;
    let width = levels.len() as u32 / height;
    let picture = GrayImage::from_raw(width, height, levels).expect("sides as long");
    picture.save(folder.join("pond.png")).expect("a picture");
    std::fs::write(folder.join("pond.csv"), table).expect("a table");
}

/// The depth of the map below each ping, metres; `None` where it has none.
fn depths_m(survey: &Arc<Survey>) -> Vec<Option<f32>> {
    let products = results(survey, &Settings::default());
    let navigation = products.navigation.clone();
    let logs = [ProcessedLog { survey: survey.clone(), products }];
    let map = Derived::default().depth_map(&logs, &Progress::new());
    let map = map.expect("a run").expect("a surface");
    let depth = |east_m, north_m| map.surface.at(east_m, north_m).map(|(depth_m, _)| depth_m);
    let places = navigation.pings.iter().map(|ping| {
        let position = navigation.to_lon_lat(&survey.track, ping.east_m, ping.north_m);
        map.map.place(position)
    });
    places.map(|[east_m, north_m]| depth(east_m, north_m)).collect()
}

#[test]
fn the_demo_as_a_picture_with_a_table_is_the_demo() {
    let progress = Progress::new();
    let open =
        |path: &Path| formats::open(path, &progress).unwrap_or_else(|error| panic!("{error}"));
    let log = open(&demo_log());
    let folder = tempfile::tempdir().expect("a folder");
    write_pair(&log, folder.path());
    let picture = open(&folder.path().join("pond.png"));
    assert_eq!(log.side_scan.len(), picture.side_scan.len());
    let settings = Settings::default();
    let [expected, found] = [&log, &picture].map(|survey| {
        let returns = detect(survey, &settings.image, &settings.first_return, &progress);
        returns.expect("first returns")
    });
    for side in Side::BOTH {
        let pairs = expected.side(side).iter().zip(found.side(side));
        let is_apart = |(one, other): &(&Pick, &Pick)| {
            one.is_some() != other.is_some() || (one.sample - other.sample).abs() > 1.0
        };
        let count = pairs.filter(is_apart).count();
        assert!(50 * count < log.side_scan.len(), "{count} first returns differ");
    }
    let [expected, found] = [log, picture].map(|survey| depths_m(&Arc::new(survey)));
    let both = expected.iter().zip(&found);
    let mut apart_m: Vec<f32> =
        both.filter_map(|(a, b)| Some((a.as_ref()? - b.as_ref()?).abs())).collect();
    assert!(10 * apart_m.len() > 9 * expected.len(), "{}", apart_m.len());
    apart_m.sort_by(f32::total_cmp);
    let [middle_m, most_m] = [50, 95].map(|share| apart_m[apart_m.len() * share / 100]);
    assert!(middle_m < 0.05 && most_m < 0.25, "{middle_m} m, {most_m} m");
}
