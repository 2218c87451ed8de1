//! Tests that generated NMEA logs, whole, damaged and growing, are read as they were written.

use crate::formats::test_logs::{beginnings, garbled, held, says};
use crate::formats::{self, OpenError, open_growing};
use crate::support::progress::Progress;
use crate::survey::{ChannelKind, SideScanState, Survey};
use bathyscope_test_support::nmea::{
    DepthIn, MIDNIGHT_S, NmeaOptions, Stamp, depth_m, minutes, nmea, sentence,
};

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    formats::open_bytes("pond.nmea", bytes, &Progress::new())
}

fn read(options: &NmeaOptions) -> Survey {
    open(nmea(options)).unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that the depths, and the positions one second apart, are those that were written.
fn assert_read(survey: &Survey, options: &NmeaOptions) {
    assert_eq!(survey.soundings.len(), options.seconds * options.depths);
    for (index, sounding) in survey.soundings.iter().enumerate() {
        let expected_m = depth_m(index);
        assert!((f64::from(sounding.depth_m) - expected_m).abs() < 2e-3, "{index}: {sounding:?}");
    }
    assert_eq!(survey.track.fixes.len(), options.seconds);
    for (second, fix) in survey.track.fixes.iter().enumerate() {
        assert!((fix.time_s - second as f64).abs() < 1e-6, "{second}: {fix:?}");
        let lat_deg = 48.0 + minutes(second) / 60.0;
        assert!((fix.position.lat_deg - lat_deg).abs() < 1e-6);
        assert!((fix.position.lon_deg + 11.0 + 31.0 / 60.0).abs() < 1e-9);
        assert!((fix.cog_rad.to_degrees() - 84.4).abs() < 1e-3);
        assert!((fix.speed_mps - 2.572).abs() < 1e-3);
    }
}

#[test]
fn depths_positions_and_times_are_what_was_written() {
    let options = NmeaOptions::default();
    let survey = read(&options);
    assert_read(&survey, &options);
    assert_eq!(survey.start_unix_s, Some(MIDNIGHT_S + 36_000.0));
    assert_eq!(survey.side_scan_state, SideScanState::Absent);
    assert_eq!(survey.source.recorder(), "NMEA 0183");
    assert_eq!(survey.channels.len(), 1);
    let channel = &survey.channels[0];
    assert_eq!((channel.kind, channel.ping_count), (ChannelKind::Primary, 40));
    assert_eq!(channel.recorder_name, "SDDPT");
    for (index, sounding) in survey.soundings.iter().enumerate() {
        // With two depths a second, their times are at a quarter and three quarters of it.
        let expected_s = index as f64 / 2.0 + 0.25;
        assert!((sounding.time_s - expected_s).abs() < 1e-6, "{index}: {}", sounding.time_s);
    }
    for depth_in in [DepthIn::Dbt, DepthIn::Feet] {
        let options = NmeaOptions { depth_in, ..options.clone() };
        assert_read(&read(&options), &options);
    }
}

#[test]
fn the_loggers_times_place_depths_between_positions() {
    for stamp in [Stamp::Tag, Stamp::Clock] {
        let options = NmeaOptions {
            depths: 4,
            // The logger's midnight is in the middle of the log.
            begins_s: 86_400.0 - 100.0,
            stamp,
            ..NmeaOptions::default()
        };
        let survey = read(&options);
        assert_read(&survey, &options);
        for (index, sounding) in survey.soundings.iter().enumerate() {
            let expected_s = (index as f64 + 0.25) / 4.0;
            assert!((sounding.time_s - expected_s).abs() < 2e-3, "{index}: {}", sounding.time_s);
        }
    }
}

#[test]
fn times_go_on_past_midnight() {
    for date in [Some("040326"), None] {
        let options = NmeaOptions { begins_s: 86_390.0, date, ..NmeaOptions::default() };
        let survey = read(&options);
        assert_read(&survey, &options);
        let begins_s = date.map(|_| MIDNIGHT_S + 86_390.0);
        assert_eq!(survey.start_unix_s, begins_s);
        assert_eq!(says(&survey, "no sentence tells the date"), date.is_none());
    }
}

#[test]
fn a_log_of_two_days_keeps_the_pause_and_a_restart_goes_on() {
    let first = nmea(&NmeaOptions::default());
    let next = nmea(&NmeaOptions { date: Some("060326"), ..NmeaOptions::default() });
    let survey = open([first.clone(), next].concat()).expect("a log");
    let last_s = survey.track.fixes.last().expect("a fix").time_s;
    assert!((last_s - 2.0 * 86_400.0 - 19.0).abs() < 1e-6, "{last_s}");
    // Depths that were written before the pause have times before it.
    assert!(
        survey
            .soundings
            .iter()
            .all(|sounding| sounding.time_s < 25.0 || sounding.time_s > 172_790.0)
    );
    let survey = open([first.clone(), first].concat()).expect("a log");
    assert!(says(&survey, "the recorder's clock was set back by 19.0 s"));
    assert_eq!(survey.soundings.len(), 80);
}

#[test]
fn headings_are_true_where_the_variation_is_known() {
    let heading = |heading, date| {
        let survey = read(&NmeaOptions { heading: Some(heading), date, ..NmeaOptions::default() });
        let last = survey.track.fixes.last().expect("a fix").compass_rad;
        (last.to_degrees().round(), says(&survey, "headings are magnetic"))
    };
    assert_eq!(heading((271.0, "HDT"), None), (271.0, false));
    // 1 degree of deviation to the east, 2 degrees of variation to the west.
    assert_eq!(heading((100.0, "HDG"), None), (99.0, false));
    assert_eq!(heading((1.0, "HDM"), Some("040326")), (358.0, false));
    assert_eq!(heading((100.0, "HDM"), None), (100.0, true));
}

#[test]
fn the_offset_of_the_transducer_is_said() {
    let offset = |offset_m| read(&NmeaOptions { offset_m, ..NmeaOptions::default() });
    assert!(says(&offset(0.35), "set draft_m to 0.35"));
    assert!(says(&offset(-0.6), "the keel lies 0.60 m below"));
    // Depths count from the transducer, with any offset.
    assert_eq!(offset(0.35).soundings[0].depth_m, 2.0);
}

#[test]
fn of_several_talkers_one_is_taken_and_the_others_are_named() {
    let mut text = String::new();
    for second in 0..10 {
        text += &sentence(&format!(
            "GPGGA,1000{second:02}.00,4807.0380,N,01131.0000,W,1,08,0.9,5.4,M,46.9,M,,"
        ));
        text += &sentence("SDDPT,5.00,0.00");
        text += &sentence("IIDBT,,f,9.00,M,,F");
        if second % 2 == 0 {
            text +=
                &sentence(&format!("IIRMC,1000{second:02},A,4807.1,N,01131.1,W,1.0,10.0,040326,,"));
        }
    }
    let survey = open(text.into_bytes()).expect("a log");
    assert!(survey.soundings.iter().all(|sounding| sounding.depth_m == 5.0));
    assert_eq!(survey.track.fixes.len(), 10);
    assert!(says(&survey, "10 of IIDBT"));
    assert!(says(&survey, "5 of IIRMC"));
    // The date is taken from any sentence that has it.
    assert_eq!(survey.start_unix_s, Some(MIDNIGHT_S + 36_000.0));
}

#[test]
fn damage_costs_the_sentence_that_it_touched_and_is_said_with_its_place() {
    let options = NmeaOptions::default();
    let whole = nmea(&options);
    let at = whole.windows(6).position(|six| six == b"$SDDPT").expect("a depth");
    for spoil in [
        |bytes: &mut Vec<u8>, at: usize| bytes[at + 7] ^= 1,
        // The checksum is cut off.
        |bytes: &mut Vec<u8>, at: usize| drop(bytes.drain(at + 15..at + 18)),
        // The rest of the line is lost.
        |bytes: &mut Vec<u8>, at: usize| drop(bytes.drain(at + 9..at + 20)),
    ] {
        let mut bytes = whole.clone();
        spoil(&mut bytes, at);
        let survey = open(bytes).expect("a log");
        assert_eq!(survey.soundings.len(), 39);
        let placed: Vec<_> = survey.warnings.iter().filter_map(|warning| warning.place).collect();
        assert_eq!(placed, [(0, at as u64)]);
    }
    // Old instruments write no checksums.
    let text = String::from_utf8(whole).expect("text");
    let lines = text.lines().map(|line| line.split('*').next().unwrap_or_default());
    let bare = lines.collect::<Vec<_>>().join("\n");
    assert_read(&open(bare.into_bytes()).expect("a log"), &options);
}

#[test]
fn a_damaged_time_costs_its_position_only() {
    let mut text = String::new();
    for second in 0..10 {
        let time = if second == 5 { 80_000 } else { 100_000 + second };
        text += &sentence(&format!("GPGGA,{time:06},4807.0{second},N,01131.0,W,1,08,,,,,,,"));
        text += &sentence("SDDPT,5.00,0.00");
    }
    let survey = open(text.into_bytes()).expect("a log");
    assert_eq!((survey.track.fixes.len(), survey.soundings.len()), (9, 10));
    assert!(says(&survey, "fits neither neighbour"));
    assert!(survey.soundings.iter().all(|sounding| (0.0..11.0).contains(&sounding.time_s)));
}

#[test]
fn without_a_receiver_depths_have_the_loggers_times_or_are_a_second_apart() {
    let log = |before: &dyn Fn(usize) -> String| {
        let line = |second| before(second) + &sentence("SDDPT,5.00,0.00");
        let text: String = (0..10).map(line).collect();
        open(text.into_bytes()).expect("a log")
    };
    let alone = log(&|_| String::new());
    assert!(says(&alone, "one second apart"));
    assert_eq!(alone.soundings[9].time_s, 9.0);
    let stamped = log(&|second| format!("{:.1},", MIDNIGHT_S + second as f64 / 2.0));
    assert_eq!(stamped.soundings[9].time_s, 4.5);
    assert_eq!(stamped.start_unix_s, Some(MIDNIGHT_S));
}

#[test]
fn a_log_without_depths_is_no_survey_and_other_texts_are_no_log() {
    let no_depths = nmea(&NmeaOptions { depths: 0, ..NmeaOptions::default() });
    let error = open(no_depths).expect_err("no depth");
    assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("20 positions"), "{error}");
    for text in ["$1,$2,$3\n", "price: $5, $6, $7, $8", "$GPGSV,1\n$GPGSV,1\n$GPGSV,1\n"] {
        let error = open(text.into()).expect_err(text);
        assert!(matches!(error, OpenError::NotRecognised { .. }), "{error}");
    }
}

fn assert_bounded(bytes: Vec<u8>, most: usize) {
    if let Ok(survey) = open(bytes) {
        assert!(survey.soundings.len() <= most && survey.track.fixes.len() <= most);
        let times = survey.soundings.iter().map(|sounding| sounding.time_s);
        let times = times.chain(survey.track.fixes.iter().map(|fix| fix.time_s));
        assert!(times.into_iter().all(f64::is_finite));
        assert!(survey.soundings.iter().all(|sounding| sounding.depth_m > 0.0));
    }
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_depths() {
    let small = nmea(&NmeaOptions {
        seconds: 4,
        heading: Some((10.0, "HDG")),
        stamp: Stamp::Clock,
        ..NmeaOptions::default()
    });
    for bytes in beginnings(&small) {
        assert_bounded(bytes, 8);
    }
    // Implausible numbers, dates and signs, in the place of every field.
    let text = String::from_utf8(small).expect("text");
    let absurd = [
        "",
        "-",
        "1e308",
        "-1e308",
        "nan",
        "inf",
        "999999999999",
        "-000001",
        "9".repeat(300).leak(),
        "é",
    ];
    for (index, line) in text.lines().enumerate().filter(|(_, line)| line.contains('$')) {
        let (before, body) = line.split_once('$').expect("a sentence");
        let fields: Vec<&str> = body.split(['*', ',']).collect();
        for field in 1..fields.len() - 1 {
            for value in absurd {
                let mut fields = fields[..fields.len() - 1].to_vec();
                fields[field] = value;
                let changed = before.to_owned() + &sentence(&fields.join(","));
                let lines = text.lines().enumerate();
                let lines =
                    lines.map(|(at, line)| if at == index { changed.as_str() } else { line });
                assert_bounded(lines.collect::<Vec<_>>().join("\n").into_bytes(), 8);
            }
        }
    }
    for bytes in garbled(text.as_bytes(), 88_172_645_463_325_252, 3000) {
        assert_bounded(bytes, 9);
    }
    // The start of a sentence at every byte, and one line without an end.
    let head = text.into_bytes();
    assert_bounded([head.clone(), b"$".repeat(1 << 20)].concat(), 8);
    assert_bounded([head, vec![b','; 1 << 22]].concat(), 8);
}

#[test]
fn a_growing_log_is_read_to_its_last_whole_line() {
    let bytes = nmea(&NmeaOptions::default());
    for length in (bytes.len() / 2..bytes.len()).step_by(7) {
        let files = held("pond.nmea", &bytes[..length]);
        let survey = open_growing(files, &Progress::new()).expect("a log");
        assert!(!survey.warnings.iter().any(|warning| warning.place.is_some()), "{length}");
        // A longer log is read again as a whole: it has no pings at which a tail could begin.
        assert!(survey.seam().is_none());
    }
}
