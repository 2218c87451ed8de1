//! Tests which recordings saw a place: the rows of an archive against all pings of the logs
//! themselves.

use super::{CORNER_M, ZONE, three_logs};
use crate::cli::{refusal, run};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::archive::{Archive, CoverageQuery, PingCoverage, coverage_at};
use bathyscope_products::pipeline::{self, Products, Settings};
use bathyscope_test_support::Moments;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Places asked for.
const PLACES: usize = 1000;
/// The archive has the metres of the zone, the logs their own frames: over the reach of a ping they
/// differ by less.
const ROUNDING_M: f64 = 2e-3;

struct Log {
    survey: Survey,
    products: Products,
}

fn opened(folder: &Path, log: u32) -> Log {
    let path = folder.join(format!("log-{log}.sl2"));
    let survey = formats::open(&path, &Progress::new()).expect("a log");
    let products = pipeline::run(&survey, &Settings::default(), None, &Progress::new(), |_| ());
    Log { survey, products: products.expect("nobody cancels") }
}

impl Log {
    /// Distance from a place of the log's own plane to the ground that a side of a ping saw, and
    /// the slant range of the nearest.
    fn distance_m(&self, ping: usize, side: Side, place: [f64; 2]) -> Option<(f64, f64)> {
        let boats = &self.products.navigation.pings;
        let boat = boats[ping];
        let half = |other: Option<usize>| {
            let other = boats.get(other?)?;
            let step_m = (other.east_m - boat.east_m).hypot(other.north_m - boat.north_m);
            (step_m <= 3.0).then_some(0.5 * step_m)
        };
        let (behind, ahead) = (half(ping.checked_sub(1)), half(Some(ping + 1)));
        let behind_m = behind.or(ahead)?;
        let ahead_m = ahead.or(behind)?;
        let (sin, cos) = boat.heading_rad.sin_cos();
        let (x, y) = (place[0] - boat.east_m, place[1] - boat.north_m);
        let starboard_m = x * cos - y * sin;
        let forward_m = x * sin + y * cos;
        let out_m = match side {
            Side::Port => -starboard_m,
            Side::Starboard => starboard_m,
        };
        let altitude_m = f64::from(self.products.depths[ping].depth_m);
        let span = self.survey.span(ping, side)?;
        let reduction = self.products.reduction();
        let range_m = |sample: u32| reduction.range_m(span, f64::from(sample));
        let ground_m = |range_m: f64| (range_m.powi(2) - altitude_m.powi(2)).max(0.0).sqrt();
        let (near_m, far_m) = (ground_m(range_m(0)), ground_m(range_m(span.count)));
        let across_m = out_m.max(near_m).min(far_m);
        let along_m = forward_m.max(-behind_m).min(ahead_m);
        let off_m = (out_m - across_m).hypot(forward_m - along_m);
        Some((off_m, across_m.hypot(altitude_m)))
    }
}

#[test]
fn a_thousand_places_are_answered_as_all_pings_answer_them() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let logs: BTreeMap<String, Log> =
        (0..3).map(|log| (format!("log-{log}"), opened(folder, log))).collect();
    let mut moments = Moments(5);
    let (mut sightings, mut on_the_edge) = (0, 0);
    for index in 0..PLACES {
        let radius_m = [0.0, 0.0, 0.5, 4.0][index % 4];
        let at =
            ZONE.to_lon_lat([0, 1].map(|axis| CORNER_M[axis] + 90.0 * (moments.share() - 0.5)));
        let found = coverage_at(&archive, CoverageQuery::Around(at, radius_m), &Progress::new())
            .expect("an answer");
        let found: BTreeMap<(String, i32, Side), _> = found
            .into_iter()
            .map(|coverage| ((coverage.name.clone(), coverage.ping, coverage.side), coverage))
            .collect();
        sightings += found.len();
        for (name, log) in &logs {
            let place = log.survey.track.frame.to_enu(at);
            for ping in 0..log.survey.side_scan.len() {
                for side in Side::BOTH {
                    let Some((off_m, range_m)) = log.distance_m(ping, side, place) else {
                        continue;
                    };
                    let covered = found.get(&(name.clone(), ping as i32, side));
                    if (off_m - radius_m).abs() < ROUNDING_M && off_m > 0.0 {
                        on_the_edge += 1;
                        continue;
                    }
                    if radius_m == 0.0 && off_m == 0.0 && covered.is_none() {
                        // Within, but for less than the rounding.
                        on_the_edge += 1;
                        continue;
                    }
                    assert_eq!(
                        covered.is_some(),
                        off_m <= radius_m,
                        "{name} {ping} {side:?} {off_m}"
                    );
                    if let Some(covered) = covered {
                        assert!((covered.seen.range_m - range_m).abs() < ROUNDING_M);
                        let span = log.survey.span(ping, side).expect("a side");
                        let sample = log.products.reduction().sample_at(span, range_m);
                        assert!(
                            (sample - 0.5 - f64::from(covered.seen.samples[0])).abs() < 0.5 + 1.0
                        );
                    }
                }
            }
        }
    }
    eprintln!("{sightings} sightings, {on_the_edge} within {ROUNDING_M} m of an edge");
    assert!(sightings > 2 * PLACES, "{sightings}");
    assert!(on_the_edge < sightings / 20, "{on_the_edge} of {sightings}");
}

#[test]
fn places_are_those_that_corrected_positions_show() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    let archive = Archive::open(&folder.join("archive")).expect("an archive");
    let middle = [CORNER_M[0] + 6.0, CORNER_M[1] + 3.0];
    let seen = |place: [f64; 2]| {
        let asked = CoverageQuery::Around(ZONE.to_lon_lat(place), 0.0);
        let mut found = coverage_at(&archive, asked, &Progress::new()).expect("an answer");
        found.retain(|coverage| coverage.name == "log-0");
        found
    };
    let recorded = seen(middle);
    assert!(recorded.len() > 2, "{recorded:?}");
    let table =
        format!("log,offset_m,pinned,east_m,north_m,latency_s\n{},0,0,4.5,-3,0\n", recorded[0].log);
    fs::write(folder.join("archive/offsets.csv"), table).expect("a table");
    assert_ne!(seen(middle), recorded);
    let moved = seen([middle[0] + 4.5, middle[1] - 3.0]);
    let same = |(a, b): (&PingCoverage, &PingCoverage)| {
        (a.ping, a.side) == (b.ping, b.side) && (a.seen.range_m - b.seen.range_m).abs() < 1e-3
    };
    assert_eq!(moved.len(), recorded.len());
    assert!(moved.iter().zip(&recorded).all(same), "{moved:?}");
}

#[test]
fn the_command_prints_passes_and_every_ping_as_json() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    let at = ZONE.to_lon_lat([CORNER_M[0] + 6.0, CORNER_M[1] + 3.0]);
    let place = format!("{},{},1", at.lon_deg, at.lat_deg);
    let text = run(folder, &["coverage", "archive", &place]);
    assert!(text.contains("log-0: ping ") && text.contains(" of 3 logs"), "{text}");
    let json: serde_json::Value =
        serde_json::from_str(&run(folder, &["coverage", "archive", &place, "--json"]))
            .expect("JSON");
    let all = json.as_array().expect("a list");
    assert!(all.len() > 20);
    for key in [
        "log",
        "name",
        "ping",
        "side",
        "sample",
        "last_sample",
        "range_m",
        "distance_m",
        "time",
        "excluded",
    ] {
        assert!(all[0].get(key).is_some(), "{key}");
    }
    let nobody = run(folder, &["coverage", "archive", "9,9"]);
    assert!(nobody.contains("no ping"), "{nobody}");
    assert!(refusal(folder, &["coverage", "none", "9,9"], 1).contains("no archive in this folder"));
    assert!(refusal(folder, &["coverage", "archive", "9"], 2).contains("longitude and latitude"));
}

#[test]
fn an_area_is_seen_by_those_that_see_a_circle_in_it_and_by_no_others_than_see_one_around_it() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    three_logs(folder);
    // Three metres from the middle to a side.
    let [x, y] = [CORNER_M[0] - 10.0, CORNER_M[1] + 8.0];
    let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0], [-3.0, -3.0]];
    let ring: Vec<[f64; 2]> = corners
        .iter()
        .map(|[east, north]| {
            let at = ZONE.to_lon_lat([x + east, y + north]);
            [at.lon_deg, at.lat_deg]
        })
        .collect();
    let area = serde_json::json!({"type": "Polygon", "coordinates": [ring]});
    fs::write(folder.join("cove.geojson"), area.to_string()).expect("a file");
    let sightings = |arguments: &[&str]| -> BTreeMap<(String, i64, String), [i64; 2]> {
        let all = [&["coverage", "archive", "--json"], arguments].concat();
        let found: serde_json::Value = serde_json::from_str(&run(folder, &all)).expect("JSON");
        let found = found.as_array().expect("a list").iter();
        found
            .map(|row| {
                let number = |key: &str| row[key].as_i64().expect("a number");
                let text = |key: &str| row[key].as_str().expect("a text").to_owned();
                let samples = [number("sample"), number("last_sample")];
                ((text("name"), number("ping"), text("side")), samples)
            })
            .collect()
    };
    let at = ZONE.to_lon_lat([x, y]);
    let around = |radius_m: f64| {
        let place = format!("{},{},{radius_m}", at.lon_deg, at.lat_deg);
        sightings(&[&place])
    };
    let in_area = sightings(&["--area", "cove.geojson"]);
    let (inner, outer) = (around(2.99), around(3.0 * 2.0_f64.sqrt() + 0.01));
    assert!(in_area.len() > 50, "{}", in_area.len());
    assert!(inner.len() < in_area.len() && in_area.len() < outer.len());
    for (sighting, [nearest, _]) in &inner {
        let [from, to] = in_area[sighting];
        assert!(from <= *nearest && nearest <= &to, "{sighting:?} {from} {to} {nearest}");
    }
    assert!(in_area.keys().all(|sighting| outer.contains_key(sighting)));
    let both = refusal(folder, &["coverage", "archive", "9,9", "--area", "cove.geojson"], 2);
    assert!(both.contains("cannot be used with"), "{both}");
    let none = refusal(folder, &["coverage", "archive", "--area", "nowhere.geojson"], 1);
    assert!(none.contains("nowhere.geojson"), "{none}");
}
