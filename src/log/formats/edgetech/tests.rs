//! Tests that generated JSF files, whole, damaged and growing, are read as they were written.

use crate::formats::test_logs::{
    assert_bounded, beginnings, check_growing, claiming, garbled, outward, places, says,
};
use crate::formats::{self, OpenError};
use crate::support::progress::Progress;
use crate::survey::{ChannelKind, RangeSource, Side, Survey};
use bathyscope_test_support::edgetech::{JsfOptions, START_S, jsf, message, put, value};

/// Name of the log.
const POND: &str = "pond.jsf";

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    formats::open_bytes(POND, bytes, &Progress::new())
}

fn read(options: &JsfOptions) -> Survey {
    open(jsf(options)).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the expected levels: values up to 999 take 10 bits, of which two are dropped.
fn expected(ping: usize, channel: u8, samples: usize) -> Vec<u8> {
    (0..samples).map(|sample| (value(ping, channel, sample) >> 2) as u8).collect()
}

#[test]
fn envelope_range_time_altitude_and_place_are_what_was_written() {
    let survey = read(&JsfOptions::default());
    assert_eq!(survey.side_scan.len(), 40);
    assert_eq!(survey.start_unix_s, Some(f64::from(START_S)));
    assert_eq!(survey.range_source, RangeSource::SurveyRecorder);
    assert_eq!(survey.source.format, "EdgeTech JSF");
    assert_eq!(survey.source.device, "sonar of type 17, vehicle 31337");
    for (index, ping) in survey.side_scan.iter().enumerate() {
        assert!((ping.time_s - index as f64 * 0.125).abs() < 1e-9);
        let far_m = 200.0 * 166e-6 * 1480.0 / 2.0;
        let span = ping.port.expect("a port side");
        assert_eq!(span.near_m, 0.0);
        assert!((f64::from(span.far_m) - far_m).abs() < 1e-5);
        assert_eq!(outward(&survey, index, Side::Port), expected(index, 0, 200));
        assert_eq!(outward(&survey, index, Side::Starboard), expected(index, 1, 200));
        assert!((ping.depth_m - (6.5 + 0.01 * index as f32)).abs() < 1e-5);
    }
    assert_eq!(survey.soundings.len(), 40);
    assert_eq!(survey.track.fixes.len(), 40);
    let fix = survey.track.fixes[39];
    assert!((fix.position.lon_deg - 11.5).abs() < 1e-9);
    assert!((fix.position.lat_deg - (48.1 + 39.0 * 3.0 / 600_000.0)).abs() < 1e-9);
    assert!((fix.compass_rad.to_degrees() - 12.89).abs() < 1e-4);
    assert!((fix.cog_rad.to_degrees() - 12.3).abs() < 1e-4);
    assert!((fix.speed_mps - 4.1 * 0.514_444).abs() < 1e-3);
    assert_eq!(survey.channels[0].frequency_khz, Some(120.0));
}

#[test]
fn every_weight_and_the_analytic_signal_show_the_same_picture() {
    for data_format in [0, 1] {
        for weights in [vec![3], vec![0, 1, 2, 3, 4, 5]] {
            let survey = read(&JsfOptions { data_format, weights, ..JsfOptions::default() });
            assert_eq!(survey.side_scan.len(), 40);
            for ping in 0..40 {
                let levels = outward(&survey, ping, Side::Starboard);
                for (level, expected) in levels.iter().zip(expected(ping, 1, 200)) {
                    let apart = level.abs_diff(expected);
                    // The real and imaginary parts are truncated to whole numbers.
                    assert!(apart <= data_format as u8, "{level} for {expected}");
                }
            }
        }
    }
}

#[test]
fn a_loud_ping_is_not_shown_brighter_than_it_was() {
    // Weight -2 means four volts a value. All pings share the range of 8 bits.
    let survey = read(&JsfOptions { weights: vec![-2, 2], ..JsfOptions::default() });
    let [coarse, fine] = [2, 3].map(|ping| outward(&survey, ping, Side::Port));
    assert_eq!(coarse[100], ((value(2, 0, 100) >> 2) << 2 >> 2) as u8);
    assert_eq!(fine[100], (value(3, 0, 100) >> 2) as u8);
}

#[test]
fn one_pair_of_several_subsystems_is_shown_and_the_others_are_named() {
    let survey = read(&JsfOptions { subsystems: vec![20, 21], ..JsfOptions::default() });
    assert_eq!(survey.side_scan.len(), 40);
    assert!(says(
        &survey,
        "high frequency (subsystem 21) is shown; set source.frequency_khz to show"
    ));
    let khz: Vec<_> = survey.channels.iter().map(|channel| channel.frequency_khz).collect();
    assert_eq!(khz.iter().filter(|khz| **khz == Some(410.0)).count(), 2);
    assert_eq!(survey.channels.len(), 4);
    // The two frequencies ping together: depths and fixes are not duplicated.
    assert_eq!([survey.soundings.len(), survey.track.fixes.len()], [40, 40]);
}

#[test]
fn metres_are_local_and_nmea_stands_in_for_positions() {
    for (units, step_m) in [(1, 0.5), (3, 0.5), (4, 0.5)] {
        let survey = read(&JsfOptions { units, ..JsfOptions::default() });
        assert!(says(&survey, "set source.crs to its EPSG number"), "{units}");
        let [_, north_m] = survey.track.frame.to_enu(survey.track.fixes[39].position);
        assert!((north_m - 39.0 * step_m).abs() < 0.01, "{units}: {north_m}");
    }
    let survey = read(&JsfOptions { units: 0, ..JsfOptions::default() });
    assert!(says(&survey, "those of the NMEA sentences are used"));
    assert_eq!(survey.track.fixes.len(), 40);
    let lat_deg = survey.track.fixes[10].position.lat_deg;
    assert!((lat_deg - (48.0 + 7.039 / 60.0)).abs() < 1e-9, "{lat_deg}");
}

#[test]
fn older_traces_are_read_with_the_sound_of_a_sensor() {
    let options = JsfOptions { old: true, ..JsfOptions::default() };
    let survey = read(&options);
    assert_eq!(survey.start_unix_s, Some(f64::from(START_S)));
    assert_eq!(survey.side_scan.len(), 40);
    assert_eq!(outward(&survey, 7, Side::Port), expected(7, 0, 200));
    assert!(says(&survey, "80 pings state no speed of sound; their ranges are for 1500 m/s"));
    let mut pressure = vec![0; 76];
    put(&mut pressure, 24, &(1_u32 << 4).to_le_bytes());
    put(&mut pressure, 32, &1_450_000_i32.to_le_bytes());
    let survey = open([message(2060, 101, 0, &pressure), jsf(&options)].concat()).expect("a log");
    let far_m = survey.side_scan[0].port.expect("a side").far_m;
    assert!((far_m - 200.0 * 166e-6 * 725.0).abs() < 1e-4, "{far_m}");
    assert!(!says(&survey, "state no speed of sound"));
}

#[test]
fn a_ping_may_have_more_samples_than_sixteen_bits_count() {
    let survey =
        read(&JsfOptions { samples: 70_000, interval_ns: 1000, pings: 3, ..JsfOptions::default() });
    assert_eq!(survey.side_scan.len(), 3);
    assert_eq!(outward(&survey, 2, Side::Port), expected(2, 0, 70_000));
}

#[test]
fn a_recording_without_side_scan_is_no_damage() {
    for subsystems in [vec![0], vec![]] {
        let error = open(jsf(&JsfOptions { subsystems, ..JsfOptions::default() }));
        let error = error.expect_err("no side-scan");
        assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains("40 messages of type 2002"), "{text}");
    }
    let survey = read(&JsfOptions { data_format: 2, ..JsfOptions::default() });
    assert!(survey.side_scan.is_empty());
    assert!(says(&survey, "80 pings hold samples of format 2"));
}

#[test]
fn damage_costs_the_message_that_it_touched() {
    let whole = jsf(&JsfOptions::default());
    let trace = 16 + 240 + 400;
    let ping = (whole.len() - 40) / 40;
    // A damaged length, a damaged marker, and bytes removed or added between two messages.
    let starboard = 40 + 11 * ping - trace;
    for spoil in [
        |bytes: &mut Vec<u8>, at: usize| put(bytes, at + 12, &i32::MAX.to_le_bytes()),
        |bytes: &mut Vec<u8>, at: usize| put(bytes, at + 12, &5000_i32.to_le_bytes()),
        |bytes: &mut Vec<u8>, at: usize| put(bytes, at, &[0; 2]),
        |bytes: &mut Vec<u8>, at: usize| drop(bytes.drain(at + 300..at + 400)),
    ] {
        let mut bytes = whole.clone();
        spoil(&mut bytes, starboard);
        let survey = open(bytes).expect("a log");
        assert_eq!(survey.side_scan.len(), 40);
        let halves = survey.side_scan.iter().filter(|ping| ping.starboard.is_some());
        assert_eq!(halves.count(), 39);
        let warning = survey.warnings.iter().find(|warning| warning.place.is_some());
        let (_, offset) = warning.and_then(|warning| warning.place).expect("a place");
        assert_eq!(offset, starboard as u64);
    }
}

#[test]
fn a_time_that_cannot_be_is_left_out() {
    let mut bytes = jsf(&JsfOptions::default());
    let at = bytes.len() / 2;
    let trace = bytes[at..].windows(6).position(|window| window == [1, 0x16, 12, 0, 80, 0]);
    let trace = at + trace.expect("a trace");
    put(&mut bytes, trace + 16, &7_i32.to_le_bytes());
    let survey = open(bytes).expect("a log");
    assert!(says(&survey, "fits neither neighbour"));
    assert_eq!(survey.side_scan.len(), 40);
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_pings() {
    for options in
        [JsfOptions::default(), JsfOptions { old: true, data_format: 1, ..JsfOptions::default() }]
    {
        let small = jsf(&JsfOptions { pings: 3, samples: 20, ..options });
        for bytes in beginnings(&small) {
            assert_bounded(POND, bytes, 3);
        }
        // Every length and count in turn is set to 2^31 or to other very large numbers.
        let harmed = garbled(&small, 20_210_605, 3000)
            .chain(claiming(&small, [i32::MAX as u32, 1 << 31, u32::MAX, 0xFF_FFF0]));
        for bytes in harmed {
            assert_bounded(POND, bytes, 6);
        }
    }
}

#[test]
fn a_growing_log_is_what_the_whole_one_is() {
    for options in [
        JsfOptions { weights: vec![0, 1, 2], subsystems: vec![20, 21], ..JsfOptions::default() },
        JsfOptions { units: 1, ..JsfOptions::default() },
    ] {
        let bytes = jsf(&JsfOptions { pings: 200, ..options });
        check_growing(POND, &bytes, |_, grown, whole| {
            assert_eq!(grown.side_scan, whole.side_scan);
            assert_eq!(grown.soundings, whole.soundings);
            assert_eq!(grown.source, whole.source);
            assert_eq!(places(grown), places(whole));
        });
    }
}

#[test]
fn a_log_that_is_no_jsf_is_not_taken_for_one() {
    for bytes in [&b"\x01\x16"[..], b"\x01\x16\x0c\x00", &[0; 4000], &[1; 4000]] {
        assert_eq!(super::sniff(bytes), None);
    }
    let bytes = jsf(&JsfOptions::default());
    assert_eq!(super::sniff(&bytes), Some(0));
    let kinds = open(bytes).expect("a log").channels;
    let kinds: Vec<ChannelKind> = kinds.iter().map(|channel| channel.kind).collect();
    assert_eq!(kinds, [ChannelKind::Port, ChannelKind::Starboard]);
}
