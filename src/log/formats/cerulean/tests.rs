//! Tests that generated svlog files, whole, damaged and growing, are read as they were written.

use crate::formats::test_logs::{
    assert_bounded, beginnings, check_growing, claiming, garbled, outward, says,
};
use crate::formats::{self, OpenError};
use crate::support::progress::Progress;
use crate::survey::{RangeSource, Side, Survey};
use bathyscope_test_support::cerulean::{BEGAN_S, SvlogOptions, decibels, packet, svlog};

/// Name of the log.
const POND: &str = "pond.svlog";

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    formats::open_bytes(POND, bytes, &Progress::new())
}

fn read(options: &SvlogOptions) -> Survey {
    open(svlog(options)).unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts levels on a scale from -85 to -45 dB, which contains all samples.
fn assert_levels(survey: &Survey, ping: usize, side: Side) {
    for (sample, level) in outward(survey, ping, side).into_iter().enumerate() {
        let expected = (decibels(ping, side as usize, sample) + 85.0) / 40.0 * 255.0;
        let apart = (f64::from(level) - expected).abs();
        assert!(apart <= 1.05, "{ping} {sample}: {level} for {expected}");
    }
}

#[test]
fn levels_range_time_and_place_are_what_was_written() {
    let survey = read(&SvlogOptions::default());
    assert_eq!(survey.side_scan.len(), 40);
    assert_eq!(survey.start_unix_s, Some(BEGAN_S));
    assert_eq!(survey.range_source, RangeSource::SurveyRecorder);
    assert_eq!(survey.source.recorder(), "Cerulean svlog, Omniscan 450");
    for (index, ping) in survey.side_scan.iter().enumerate() {
        assert!((ping.time_s - index as f64 * 0.05).abs() < 1e-9);
        for side in Side::BOTH {
            let span = ping.side(side).expect("both sides");
            assert_eq!([span.near_m, span.far_m], [0.0, 30.0]);
            assert_levels(&survey, index, side);
        }
    }
    assert_eq!(survey.track.fixes.len(), 40);
    for (index, fix) in survey.track.fixes.iter().enumerate() {
        assert!((fix.time_s - index as f64 * 0.05).abs() < 1e-6);
        let lat_deg = 48.0 + (7.038 + index as f64 * 1e-4) / 60.0;
        assert!((fix.position.lat_deg - lat_deg).abs() < 1e-9);
        assert!((fix.compass_rad.to_degrees() - 271.5).abs() < 1e-3);
    }
    assert_eq!(survey.channels.len(), 2);
    assert_eq!(survey.channels[0].frequency_khz, Some(450.0));
}

#[test]
fn pings_with_a_scale_of_their_own_show_the_same_picture() {
    let survey = read(&SvlogOptions {
        powers_db: vec![[-90.0, -40.0], [-85.5, -44.25], [-140.0, 0.0]],
        ..SvlogOptions::default()
    });
    for ping in 0..40 {
        assert_levels(&survey, ping, Side::Port);
        assert_levels(&survey, ping, Side::Starboard);
    }
}

#[test]
fn sides_are_told_by_channel_or_by_where_the_transducer_looks() {
    for channels in [[0, 1], [255, 255]] {
        let survey = read(&SvlogOptions { channels, ..SvlogOptions::default() });
        assert_eq!(survey.side_scan.len(), 40);
        assert_levels(&survey, 3, Side::Port);
        assert_levels(&survey, 3, Side::Starboard);
    }
}

#[test]
fn packets_of_one_side_may_come_in_a_row() {
    for positions in [109, 150] {
        // Four seconds of one side, then of the other.
        let survey =
            read(&SvlogOptions { pings: 400, in_a_row: 80, positions, ..SvlogOptions::default() });
        assert_eq!(survey.side_scan.len(), 400);
        assert!(
            survey.side_scan.iter().all(|ping| ping.port.is_some() && ping.starboard.is_some())
        );
        assert_eq!(survey.track.fixes.len(), 5);
        for (index, fix) in survey.track.fixes.iter().enumerate() {
            assert!((fix.time_s - 4.0 * index as f64).abs() < 1e-6);
        }
    }
}

#[test]
fn positions_of_an_autopilot_are_read() {
    let survey = read(&SvlogOptions { positions: 150, start_mm: 500, ..SvlogOptions::default() });
    assert_eq!(survey.track.fixes.len(), 40);
    let fix = survey.track.fixes[20];
    assert!((fix.position.lat_deg - 48.117_34).abs() < 1e-9, "{fix:?}");
    assert!((fix.position.lon_deg - 11.516_666_7).abs() < 1e-9);
    assert!((fix.compass_rad.to_degrees() - 90.25).abs() < 1e-3);
    assert_eq!([fix.speed_mps, fix.cog_rad], [1.0, 0.0]);
    let span = survey.side_scan[0].port.expect("a side");
    assert_eq!([span.near_m, span.far_m], [0.5, 30.5]);
    let survey = read(&SvlogOptions { positions: 0, ..SvlogOptions::default() });
    assert!(says(&survey, "the log holds no position"));
}

#[test]
fn transducers_that_were_switched_on_one_after_the_other_are_named() {
    let options =
        |port_earlier_ms| SvlogOptions { in_a_row: 20, port_earlier_ms, ..SvlogOptions::default() };
    assert!(says(&read(&options(12_000)), "ahead of the starboard one's"));
    assert!(!says(&read(&options(0)), "ahead of the starboard one's"));
}

#[test]
fn after_a_restart_of_the_sonar_time_goes_on() {
    let part = svlog(&SvlogOptions { pings: 100, ..SvlogOptions::default() });
    let survey = open([part.clone(), part].concat()).expect("a log");
    assert!(says(&survey, "the recorder's clock was set back by 5.0 s"));
    assert_eq!(survey.side_scan.len(), 200);
    for ping in survey.side_scan.iter() {
        assert!(ping.port.is_some() && ping.starboard.is_some());
    }
    let last_s = survey.side_scan[199].time_s;
    assert!((last_s - 9.9).abs() < 1e-6, "{last_s}");
    assert_eq!(survey.start_unix_s, Some(BEGAN_S));
    let fix = survey.track.fixes[199];
    assert!((fix.time_s - 9.9).abs() < 0.06, "{}", fix.time_s);
}

#[test]
fn a_log_of_another_sonar_is_no_damage() {
    let bytes = [packet(10, 0, b"{}"), packet(1300, 1, &[0; 100]), packet(1300, 1, &[0; 100])];
    let error = open(bytes.concat()).expect_err("no profile");
    assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("2 packets with the id 1300"), "{text}");
    for bytes in [&b"BR"[..], b"BRIEF", b"BR\0\0BR\0\0BR\0\0\0\0\x01\0", &[0; 4000]] {
        assert!(!super::is_log(bytes), "{bytes:?}");
    }
    // Bytes before the first packet are skipped.
    let bytes = [b"BROKEN".to_vec(), svlog(&SvlogOptions::default())].concat();
    let survey = open(bytes).expect("a log");
    assert!(says(&survey, "the next begins after 6"));
    assert_eq!(survey.side_scan.len(), 40);
}

#[test]
fn damage_costs_the_packet_that_it_touched() {
    let whole = svlog(&SvlogOptions::default());
    let profile = 8 + 52 + 400 + 2;
    let at = |id: u16, nth: usize| {
        let id = id.to_le_bytes();
        let mut starts = whole.windows(6).enumerate();
        let mut starts = starts.by_ref().filter(|(_, w)| w.starts_with(b"BR") && w.ends_with(&id));
        starts.nth(nth).expect("a packet").0
    };
    let starboard = at(2198, 21);
    assert_eq!(at(2198, 20) + profile, starboard);
    for spoil in [
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 2..at + 4].fill(0xFF),
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 2] ^= 0x10,
        |bytes: &mut Vec<u8>, at: usize| bytes[at] = 0,
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 200] ^= 0x55,
        |bytes: &mut Vec<u8>, at: usize| drop(bytes.drain(at + 100..at + 200)),
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

/// Corrects the checksums of the packets, so that their content is read.
fn mended(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut at = 0;
    while let Some(header) = bytes.get(at..at + 8) {
        let end = at + 8 + usize::from(u16::from_le_bytes([header[2], header[3]]));
        if !header.starts_with(b"BR") || end + 2 > bytes.len() {
            break;
        }
        let sum = bytes[at..end].iter().fold(0_u16, |sum, byte| sum.wrapping_add(u16::from(*byte)));
        bytes[end..end + 2].copy_from_slice(&sum.to_le_bytes());
        at = end + 2;
    }
    bytes
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_pings() {
    for positions in [109, 150] {
        let small =
            svlog(&SvlogOptions { pings: 3, samples: 20, positions, ..SvlogOptions::default() });
        let harmed: Vec<Vec<u8>> = garbled(&small, 20_260_304, 3000).collect();
        // Every number in turn is set to 2^31, to the largest values, or to infinity.
        let claims = [1 << 31, i32::MAX as u32, u32::MAX, f32::INFINITY.to_bits()];
        let claiming = claiming(&small, claims).map(mended);
        let corrected = harmed.clone().into_iter().map(mended).chain(claiming);
        for bytes in beginnings(&small).chain(harmed).chain(corrected) {
            assert_bounded(POND, bytes, 6);
        }
    }
    // A marker at every other byte.
    assert_bounded(POND, b"BR".repeat(1 << 18), 6);
}

#[test]
fn a_growing_log_is_what_the_whole_one_is() {
    for options in [
        SvlogOptions {
            powers_db: vec![[-90.0, -30.0], [-85.5, -34.25], [-140.0, 0.0]],
            louder_db: 0.01,
            ..SvlogOptions::default()
        },
        SvlogOptions { positions: 150, in_a_row: 5, ..SvlogOptions::default() },
    ] {
        let bytes = svlog(&SvlogOptions { pings: 600, ..options });
        check_growing(POND, &bytes, |_, grown, whole| {
            assert_eq!(grown.side_scan.len(), whole.side_scan.len());
            for first in 0..3 {
                // Added pings are on the scale of the pings before, though they are louder.
                let pings = grown.side_scan.iter().skip(first).step_by(3);
                let sides = pings.flat_map(|ping| [ping.port, ping.starboard]).flatten();
                let scales: Vec<_> = sides.map(|span| span.encoding).collect();
                assert!(scales.iter().all(|scale| *scale == scales[0]));
            }
            for (a, b) in grown.side_scan.iter().zip(whole.side_scan.iter()) {
                let places = [a, b].map(|ping| {
                    let sides = [ping.port, ping.starboard];
                    (ping.time_s, sides.map(|span| span.map(|span| (span.offset, span.far_m))))
                });
                assert_eq!(places[0], places[1]);
            }
            assert_eq!(grown.source, whole.source);
            assert_eq!(grown.track.fixes.len(), whole.track.fixes.len());
            for (a, b) in grown.track.fixes.iter().zip(whole.track.fixes.iter()) {
                assert!((a.time_s - b.time_s).abs() < 1e-6 && a.position == b.position);
            }
        });
    }
}
