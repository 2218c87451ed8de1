//! Tests that samples of every format and the range that they cover are read, and side-scan of two
//! frequencies as two pairs.

use super::*;

/// Returns a number in IBM's format; whole numbers below 2^24 have an exponent of 6 hexadecimal
/// digits.
fn ibm(value: u32) -> Vec<u8> {
    (0x4600_0000 | value).to_le_bytes().to_vec()
}

#[test]
fn every_format_of_samples_shows_the_same_picture() {
    type Sample = fn(usize, usize) -> Vec<u8>;
    let cases: [((u16, u8, bool), Sample); 8] = [
        ((1, 0, true), |_, sample| vec![(value(sample) >> 4) as u8]),
        ((2, 0, false), |_, sample| (value(sample) as u16).to_le_bytes().to_vec()),
        ((2, 3, false), |_, sample| {
            let value = value(sample) as i16;
            let signed = if sample.is_multiple_of(2) { value } else { -value };
            signed.to_le_bytes().to_vec()
        }),
        ((4, 0, true), |_, sample| (value(sample) << 9).to_le_bytes().to_vec()),
        ((4, 2, false), |_, sample| {
            let value = (value(sample) << 9) as i32;
            let signed = if sample.is_multiple_of(2) { value } else { -value };
            signed.to_le_bytes().to_vec()
        }),
        ((4, 5, false), |_, sample| {
            let value = value(sample) as f32 / 4096.0;
            let signed = if sample.is_multiple_of(2) { value } else { -value };
            signed.to_le_bytes().to_vec()
        }),
        ((4, 0, true), |_, sample| (value(sample) as f32 * 0.01).to_le_bytes().to_vec()),
        ((4, 1, true), |_, sample| ibm(value(sample))),
    ];
    for (stored, sample) in cases {
        let survey = read(&Xtf { stored, sample, ..Xtf::default() });
        let shown = [Side::Port, Side::Starboard].map(|side| outward(&survey, 7, side));
        let expected = match stored {
            // The highest value, 39.8, takes 6 bits.
            (4, 0, _) if shown[0][100] != 125 => {
                let level = |sample| (value(sample) as f32 * 0.01 * 4.0) as u8;
                (0..SAMPLES).map(level).collect()
            }
            _ => expected(),
        };
        assert_eq!(shown, [expected.clone(), expected], "{stored:?}");
    }
}

#[test]
fn samples_that_are_no_numbers_or_not_read_end_nothing() {
    let survey = read(&Xtf {
        stored: (4, 5, false),
        sample: |ping, sample| {
            let value = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0][(ping + sample) % 4];
            value.to_le_bytes().to_vec()
        },
        ..Xtf::default()
    });
    assert_eq!(outward(&survey, 0, Side::Starboard)[..4], [0, 255, 255, 128]);
    let survey = read(&Xtf { stored: (8, 0, true), sample: |_, _| vec![0; 8], ..Xtf::default() });
    assert!(says(&survey, "80 pings hold samples of 8 bytes (format 0)"));
    assert!(survey.side_scan.is_empty());
}

#[test]
fn the_weights_of_edgetech_put_all_pings_on_one_scale() {
    let file = Xtf {
        header: |header| header.sonar_type = 38,
        sample: |ping, sample| ((value(sample) << (ping % 4)) as u16).to_le_bytes().to_vec(),
        side: |index, side| {
            side.slant_range_m = 25.0;
            side.weight = (index % 4) as i16;
        },
        ..Xtf::default()
    };
    let survey = read(&file);
    for ping in 0..8 {
        assert_eq!(outward(&survey, ping, Side::Port), expected(), "{ping}");
    }
    // The samples of other sonars have no weights.
    let survey = read(&Xtf { header: |_| (), ..file });
    assert_ne!(outward(&survey, 0, Side::Port), outward(&survey, 1, Side::Port));
}

#[test]
fn a_range_that_is_not_stated_comes_from_time_and_speed_of_sound() {
    let without_range: fn(usize, &mut PingChannel) = |_, side| side.time_duration_s = 0.04;
    type Ping = fn(usize, &mut PingHeader);
    let cases: [(Ping, f32, bool); 4] = [
        (|_, ping| ping.sound_velocity_mps = 740.0, 29.6, false),
        (|_, ping| ping.sound_velocity_mps = 1480.0, 29.6, false),
        (|_, ping| ping.computed_sound_velocity_mps = 1490.0, 29.8, false),
        (|_, ping| ping.sound_velocity_mps = f32::NAN, 30.0, true),
    ];
    for (ping, far_m, is_assumed) in cases {
        let survey = read(&Xtf { ping, side: without_range, ..Xtf::default() });
        let span = survey.side_scan[3].port.expect("a side");
        assert!((span.far_m - far_m).abs() < 1e-4, "{}", span.far_m);
        assert_eq!(says(&survey, "neither a range nor a speed of sound"), is_assumed);
    }
    let survey = read(&Xtf {
        ping: |_, ping| ping.sound_velocity_mps = 750.0,
        side: |_, side| (side.time_delay_s, side.time_duration_s) = (0.004, 0.04),
        ..Xtf::default()
    });
    let span = survey.side_scan[3].starboard.expect("a side");
    assert!((span.near_m - 3.0).abs() < 1e-4 && (span.far_m - 33.0).abs() < 1e-4);
}

#[test]
fn old_pings_have_the_samples_of_the_file_header() {
    let survey = read(&Xtf {
        side: |_, side| (side.slant_range_m, side.samples) = (25.0, 0),
        ..Xtf::default()
    });
    assert_eq!(outward(&survey, 3, Side::Port), expected());
}

/// Returns a file of two frequencies, which have different ranges.
pub(super) fn two_frequencies() -> Xtf {
    Xtf {
        channels: vec![(1, 100.0), (2, 100.0), (1, 400.0), (2, 400.0)],
        side: |_, side| side.slant_range_m = if side.channel < 2 { 100.0 } else { 50.0 },
        ping: |index, ping| {
            (ping.sensor_x, ping.sensor_y) = (START.lon_deg, latitude(index));
            ping.sensor_altitude_m = 7.5;
        },
        ..Xtf::default()
    }
}

#[test]
fn one_of_two_frequencies_is_shown_and_the_other_can_be_chosen() {
    let survey = read(&two_frequencies());
    let far_m = |survey: &Survey| survey.side_scan[9].starboard.map(|span| span.far_m);
    assert_eq!(far_m(&survey), Some(100.0));
    assert_eq!(survey.channels.len(), 4);
    let summary = "100 kHz, 0 is shown; set source.frequency_khz to show 400 kHz, 2";
    assert!(says(&survey, summary), "{:?}", survey.warnings);
    let high = survey.clone().with_frequency(380.0);
    assert_eq!(far_m(&high), Some(50.0));
    assert_eq!(high.side_scan[9].depth_m, 7.5);
    assert!(says(&high, "400 kHz, 2 is shown; set source.frequency_khz to show 100 kHz, 0"));
    assert_eq!(survey.clone().with_frequency(120.0).side_scan, survey.side_scan);
    // A file with one pair has nothing to choose from.
    let single = read(&Xtf::default());
    assert!(single.pairs.is_empty() && !says(&single, "source.frequency_khz"));
    assert_eq!(far_m(&single.with_frequency(400.0)), Some(25.0));
}
