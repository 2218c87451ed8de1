//! Tests that generated SDF files, whole, damaged and growing, are read as they were written.

use crate::formats::test_logs::{
    assert_bounded, beginnings, check_growing, claiming, garbled, outward, places, says,
};
use crate::formats::{self, OpenError};
use crate::support::progress::Progress;
use crate::survey::{RangeSource, Side, Survey};
use bathyscope_test_support::klein::{BEGAN_S, RANGE_M, SdfOptions, sdf, stored};

/// Name of the log.
const LINE: &str = "line.sdf";

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    formats::open_bytes(LINE, bytes, &Progress::new())
}

fn read(options: &SdfOptions) -> Survey {
    open(sdf(options)).unwrap_or_else(|error| panic!("{error}"))
}

fn assert_samples(survey: &Survey, options: &SdfOptions, ping: usize, page: usize) {
    for side in Side::BOTH {
        let expected =
            (0..options.samples).map(|sample| stored(options, page, side as usize, sample));
        let expected: Vec<u8> = expected.map(|value| value.min(255) as u8).collect();
        assert_eq!(outward(survey, ping, side), expected, "{ping}");
    }
}

#[test]
fn samples_range_time_and_place_are_what_was_written() {
    for versions in [vec![3000], vec![3001], vec![3501], vec![3502]] {
        let options = SdfOptions { versions, ..SdfOptions::default() };
        let survey = read(&options);
        assert_eq!((survey.side_scan.len(), survey.soundings.len()), (40, 40));
        assert_eq!(survey.start_unix_s, Some(BEGAN_S));
        assert_eq!(survey.range_source, RangeSource::SurveyRecorder);
        for (page, ping) in survey.side_scan.iter().enumerate() {
            assert!((ping.time_s - page as f64 / 10.0).abs() < 1e-9);
            assert!((ping.depth_m - (8.0 + (page / 10) as f32 / 10.0)).abs() < 1e-6);
            assert_eq!(ping.port.map(|span| span.far_m), Some(50.0));
            assert_samples(&survey, &options, page, page);
        }
        let fix = survey.track.fixes[39];
        assert!((fix.position.lat_deg - 48.000_039).abs() < 1e-9);
        assert!((fix.position.lon_deg - 11.5).abs() < 1e-9);
        assert!((fix.compass_rad.to_degrees() - 271.5).abs() < 1e-3);
        assert_eq!(fix.speed_mps, 2.0);
    }
    let vehicle = read(&SdfOptions { versions: vec![3502], ..SdfOptions::default() });
    assert_eq!(vehicle.source.recorder(), "Klein SDF, 3500 series");
    assert_eq!(vehicle.channels[0].frequency_khz, Some(900.0));
}

#[test]
fn the_range_is_that_of_the_samples_where_it_agrees_with_the_one_that_was_set() {
    let far_m = |samples, rate_hz| {
        let survey = read(&SdfOptions { samples, rate_hz, ..SdfOptions::default() });
        survey.side_scan[0].port.expect("a side").far_m
    };
    assert_eq!(far_m(153, 2250), 51.0);
    assert_eq!(far_m(150, 22_500), RANGE_M as f32);
    assert_eq!(far_m(150, 0), RANGE_M as f32);
}

#[test]
fn of_two_frequencies_the_high_one_is_shown() {
    for versions in [vec![3001], vec![3501, 3502]] {
        let options =
            SdfOptions { has_low: true, versions: versions.clone(), ..SdfOptions::default() };
        let survey = read(&options);
        assert_eq!(survey.channels.len(), 4);
        assert!(says(&survey, "pings of the low frequency"));
        let each = versions.len();
        assert_eq!(survey.side_scan.len(), 40 / each);
        assert_samples(&survey, &options, 3, 3 * each + each - 1);
    }
}

#[test]
fn wide_samples_are_shown_by_the_bits_that_hold_them() {
    for (version, louder) in [(3001, 30_000), (3502, 2_000_000_000)] {
        let survey = read(&SdfOptions { versions: vec![version], louder, ..SdfOptions::default() });
        let level = survey.samples(0, Side::Port).expect("a side").get(0);
        assert!((100..=255).contains(&level), "{version}: {level}");
    }
}

#[test]
fn sonars_whose_channels_nobody_describes_are_refused_in_words() {
    for (version, name) in [(5001, "System 5000"), (7001, "System 7000")] {
        let options = SdfOptions { versions: vec![version], ..SdfOptions::default() };
        let error = open(sdf(&options)).expect_err("no side-scan");
        assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains(name), "{error}");
        assert!(error.to_string().contains("export XTF"), "{error}");
    }
    let mixed = read(&SdfOptions { versions: vec![3001, 5001], ..SdfOptions::default() });
    assert!(says(&mixed, "20 pages of a System 5000 were skipped"));
    assert_eq!(mixed.side_scan.len(), 20);
    for bytes in [vec![0xFF; 4000], b"\xFF\xFF\xFF\xFF\0\x02\0\0".to_vec(), vec![0; 4000]] {
        assert!(matches!(open(bytes), Err(OpenError::NotRecognised { .. })));
    }
}

#[test]
fn damage_costs_the_page_that_it_touched() {
    let whole = sdf(&SdfOptions::default());
    let size = whole.len() / 40;
    let at = 20 * size;
    for spoil in [
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 6] = 0xFF,
        |bytes: &mut Vec<u8>, at: usize| bytes[at] = 0,
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 4 + 72] = 99,
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 4 + 68..at + 4 + 69].fill(0xFF),
        |bytes: &mut Vec<u8>, at: usize| drop(bytes.drain(at + 600..at + 700)),
    ] {
        let mut bytes = whole.clone();
        spoil(&mut bytes, at);
        let survey = open(bytes).expect("a log");
        assert_eq!(survey.side_scan.len(), 39);
        let warning = survey.warnings.iter().find_map(|warning| warning.place);
        assert_eq!(warning, Some((0, at as u64)));
    }
    let cut = open(whole[..whole.len() - 100].to_vec()).expect("a log");
    assert!(says(&cut, "the file was cut inside its last page"));
    assert_eq!(cut.side_scan.len(), 39);
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_pings() {
    for version in [3000, 3001, 3502] {
        let small = sdf(&SdfOptions {
            pages: 3,
            samples: 20,
            versions: vec![version],
            has_low: true,
            ..SdfOptions::default()
        });
        // Every number in turn is set to 2^31, the largest value, infinity, or 0.
        let harmed = beginnings(&small)
            .chain(garbled(&small, 88_172_645_463_325_252, 2000))
            .chain(claiming(&small, [1 << 31, u32::MAX, f32::INFINITY.to_bits(), 0]));
        for bytes in harmed {
            assert_bounded(LINE, bytes, 6);
        }
    }
    assert_bounded(LINE, b"\xFF\xFF\xFF\xFF\0\x01\0\0\xB9\x0B\0\0".repeat(1 << 15), 6);
}

#[test]
fn a_growing_log_is_what_the_whole_one_is() {
    for versions in [vec![3001], vec![3501, 3502]] {
        let options = SdfOptions {
            pages: 600,
            samples: 20,
            has_low: true,
            louder: 300,
            versions,
            ..SdfOptions::default()
        };
        check_growing(LINE, &sdf(&options), |_, grown, whole| {
            assert!(grown.side_scan == whole.side_scan);
            assert!(grown.soundings == whole.soundings);
            assert_eq!(places(grown), places(whole));
        });
    }
}
