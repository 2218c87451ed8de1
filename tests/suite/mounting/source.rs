//! `source.crs`: positions in metres of a system that the log does not name.
//! `source.frequency_khz`: which side-scan is shown.

use super::golden::golden;
use super::settings;
use crate::cli::{refusal, run, stderr_of};
use bathyscope_log::formats;
use bathyscope_log::support::geo::{LonLat, distance_m};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{self, Settings};
use bathyscope_test_support::handmade;

/// An XTF log of 20 pings, half a metre to the north each, that says that its positions are metres.
fn log(origin: (f64, f64)) -> Survey {
    let bytes = handmade::xtf(20, 1, 0, origin, 7.5);
    formats::open_bytes("line.xtf", bytes, &Progress::new()).expect("a log")
}

#[test]
fn metres_lie_where_pyproj_has_them() {
    let golden = golden();
    let mut worst_m = 0.0_f64;
    for case in golden["metres"].as_array().expect("cases") {
        let number = |name: &str| case[name].as_f64().expect("a number");
        let recorded = log((number("east_m"), number("north_m")));
        let named = settings(&[&format!("source.crs=EPSG:{}", case["epsg"])]);
        assert_eq!(named.check(), Ok(()), "{case}");
        let survey = pipeline::as_set(recorded, &named, None).expect("it fits");
        let place = LonLat { lon_deg: number("lon"), lat_deg: number("lat") };
        let off_m = distance_m(survey.track.fixes[0].position, place);
        worst_m = worst_m.max(off_m);
        assert!(off_m < 1e-3, "{case}: {off_m} m");
        // 19 steps of half a metre of the grid, which is no more than a thousandth off the ground's
        // (web Mercator apart).
        let length_m = distance_m(survey.track.fixes[19].position, place);
        if number("epsg") != 3857.0 {
            assert!((length_m - 9.5).abs() < 0.02, "{case}: {length_m} m");
        }
        let is_warned = survey.warnings.iter().any(|warning| warning.text.contains("source.crs"));
        assert!(!is_warned, "it is known now");
    }
    println!("first fixes: {worst_m:.1e} m from pyproj's at most");
}

#[test]
fn what_is_missing_or_wrong_is_said_in_a_sentence_that_names_the_setting() {
    let line = log((606_900.0, 4_732_000.0));
    let warnings: Vec<_> = line.warnings.iter().map(|warning| warning.text.as_str()).collect();
    assert!(
        warnings.iter().any(|text| text.contains("set source.crs to its EPSG number")),
        "{warnings:?}"
    );
    let refused = |value: &str| {
        let made = Settings::default().with_assignment(&format!("source.crs={value}"));
        let error = match made {
            Err(error) => error,
            Ok(settings) => match settings.check() {
                Err(error) => error,
                Ok(()) => {
                    let set = pipeline::as_set(line.clone(), &settings, None);
                    return set.expect_err(value).to_string();
                }
            },
        };
        error.to_string()
    };
    for (value, words) in [
        ("utm", "EPSG: and a number"),
        ("EPSG:99", "EPSG:99 is not known"),
        ("EPSG:4326", "has degrees"),
        ("EPSG:23032", "another datum"),
        ("EPSG:2263", "in metres"),
    ] {
        let said = refused(value);
        assert!(said.contains(words) && said.contains("source.crs"), "{value}: {said}");
        assert!(!said.contains('\n'), "{said}");
    }
    // Metres of web Mercator lie thousands of kilometres off the middle of any zone.
    let mercator = log((-8_203_600.0, 5_271_000.0));
    let made = pipeline::as_set(mercator, &settings(&["source.crs=EPSG:32618"]), None);
    let said = made.expect_err("no zone reaches so far").to_string();
    assert!(
        said.starts_with(
            "source.crs: the log's position -8203600 E 5271000 N lies outside of EPSG:32618"
        ),
        "{said}"
    );
    // Degrees need no system, and are not touched by one.
    let bytes = handmade::xtf(20, 1, 3, (-73.6, 42.7), 0.0);
    let degrees = formats::open_bytes("line.xtf", bytes, &Progress::new()).expect("a log");
    let named = settings(&["source.crs=EPSG:32618"]);
    let survey = pipeline::as_set(degrees.clone(), &named, None).expect("it fits");
    let places = |survey: &Survey| {
        let fixes = survey.track.fixes.iter();
        fixes.map(|fix| fix.position).collect::<Vec<_>>()
    };
    assert_eq!(places(&survey), places(&degrees));
}

#[test]
fn a_run_is_told_the_system_and_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let bytes = handmade::xtf(60, 1, 0, (606_900.0, 4_732_000.0), 7.5);
    std::fs::write(folder.join("line.xtf"), bytes).expect("a log");
    let info = run(folder, &["info", "line.xtf"]);
    assert!(info.contains("source.crs"), "{info}");
    let args = ["process", "line.xtf", "--no-objects"];
    let args = [&args[..], &["--products", "track", "-o", "out"]].concat();
    stderr_of(folder, &args);
    let first = |table: &str| -> [f64; 2] {
        let row = table.lines().nth(1).expect("a row");
        let fields: Vec<&str> = row.split(',').collect();
        [2, 3].map(|column| fields[column].parse().expect("degrees"))
    };
    let table = std::fs::read_to_string(folder.join("out/points/first_returns.csv")).unwrap();
    assert!(first(&table).iter().all(|degrees| degrees.abs() < 0.001), "{table}");
    run(folder, &[&args[..], &["--set", "source.crs=EPSG:32618"]].concat());
    let table = std::fs::read_to_string(folder.join("out/points/first_returns.csv")).unwrap();
    let [lon_deg, lat_deg] = first(&table);
    assert!((lon_deg + 73.694_126).abs() < 1e-4 && (lat_deg - 42.733_069).abs() < 1e-4);
    let report = std::fs::read_to_string(folder.join("out/report.json")).unwrap();
    assert!(report.contains("are taken for those of EPSG:32618"), "{report}");
    let bytes = handmade::xtf(60, 1, 0, (-8_203_600.0, 5_271_000.0), 7.5);
    std::fs::write(folder.join("line.xtf"), bytes).expect("a log");
    let wrong = [&args[..], &["--set", "source.crs=EPSG:32618"]].concat();
    let said = refusal(folder, &wrong, 1);
    assert!(said.contains("source.crs: the log's position") && said.contains("line.xtf"), "{said}");
}

#[test]
fn the_side_scan_of_a_frequency_is_shown_on_request() {
    let bytes = handmade::xtf_of_two_frequencies(60);
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::write(folder.join("line.xtf"), &bytes).expect("a log");
    let info = run(folder, &["info", "line.xtf"]);
    assert!(info.contains("set source.frequency_khz to show 400 kHz"), "{info}");
    let far_m = |set: &[&str]| {
        let recorded = formats::open_bytes("line.xtf", bytes.clone(), &Progress::new());
        let survey = pipeline::as_set(recorded.expect("a log"), &settings(set), None);
        survey.expect("it fits").side_scan[9].port.map(|span| span.far_m)
    };
    assert_eq!(far_m(&[]), Some(25.0));
    assert_eq!(far_m(&["source.frequency_khz=455"]), Some(12.5));
    assert_eq!(far_m(&["source.frequency_khz=83"]), Some(25.0));
    // The sides of the chosen pair are exchanged, not those of the other.
    let exchanged = ["source.frequency_khz=455", "mounting.swap_sides=true"];
    assert_eq!(far_m(&exchanged), Some(12.5));
    let made = Settings::default().with_assignment("source.frequency_khz=0");
    assert!(made.and_then(|made| made.check()).is_err());
}
