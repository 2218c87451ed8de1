//! Tests that generated XTF files, whole, damaged and growing, are read as they were written:
//! samples of every format, the range that they cover, and side-scan of two frequencies as two
//! pairs. `places` tests positions and the depths of a multibeam sonar.

mod places;

use super::raw::{ChannelInfo, FileHeader, PacketHeader, PacketTime, PingChannel, PingHeader};
use crate::formats::test_logs::{assert_bounded, beginnings, check_growing, outward, says};
use crate::formats::{self, OpenError, test_logs};
use crate::support::geo::LonLat;
use crate::support::progress::Progress;
use crate::survey::{Side, Survey};
use bathyscope_test_support::Random;
use bytemuck::{Zeroable as _, bytes_of};
use places::raw_navigation;

/// Number of samples of a side of a ping.
const SAMPLES: usize = 200;
/// Position of the first ping.
const START: LonLat = LonLat::new(11.5, 48.1);

/// Description of a file to write: pings of all channels, ten a second from noon on.
#[derive(Clone)]
struct Xtf {
    pings: usize,
    header: fn(&mut FileHeader),
    /// Kind and frequency (kHz) of each channel.
    channels: Vec<(u8, f32)>,
    /// Bytes of a sample, format, and true if samples are unsigned.
    stored: (u16, u8, bool),
    /// Bytes of a sample of a ping in the file.
    sample: fn(usize, usize) -> Vec<u8>,
    ping: fn(usize, &mut PingHeader),
    side: fn(usize, &mut PingChannel),
    /// Bytes of the packets before a ping.
    before: fn(usize) -> Vec<u8>,
}

/// Returns the value of a sample, which has 12 bits, so that four are dropped.
fn value(sample: usize) -> u32 {
    sample as u32 * 20
}

fn expected() -> Vec<u8> {
    (0..SAMPLES).map(|sample| (value(sample) >> 4) as u8).collect()
}

impl Default for Xtf {
    fn default() -> Self {
        Self {
            pings: 40,
            header: |_| (),
            channels: vec![(1, 0.0), (2, 0.0)],
            stored: (2, 0, true),
            sample: |_, sample| (value(sample) as u16).to_le_bytes().to_vec(),
            ping: |index, ping| {
                (ping.sensor_x, ping.sensor_y) = (START.lon_deg, latitude(index));
            },
            side: |_, side| side.slant_range_m = 25.0,
            before: |_| Vec::new(),
        }
    }
}

/// Returns the latitude of a ping: half a metre further north with each ping.
fn latitude(index: usize) -> f64 {
    START.lat_deg + index as f64 * 4.5e-6
}

/// Returns the packet header of a record of `size` bytes.
fn packet(kind: u8, size: usize) -> PacketHeader {
    PacketHeader { magic: 0xFACE, kind, size: size as u32, ..PacketHeader::zeroed() }
}

/// Returns the time of a ping, and the hundredths of its second.
fn time(index: usize) -> (PacketTime, u8) {
    let time = PacketTime {
        year: 2020,
        month: 6,
        day: 1,
        hour: 12,
        minute: (index / 600) as u8,
        second: (index / 10 % 60) as u8,
    };
    (time, (index % 10 * 10) as u8)
}

fn written(file: &Xtf) -> Vec<u8> {
    let mut header = FileHeader {
        file_format: 0x7B,
        nav_units: 3,
        sonar_channels: file.channels.len() as u16,
        ..FileHeader::zeroed()
    };
    (file.header)(&mut header);
    let mut bytes = bytes_of(&header).to_vec();
    let (width, format, is_unipolar) = file.stored;
    for (number, &(kind, frequency_khz)) in file.channels.iter().enumerate() {
        bytes.extend(bytes_of(&ChannelInfo {
            kind,
            number: number as u8,
            unipolar: is_unipolar.into(),
            bytes_per_sample: width,
            reserved: SAMPLES as u32,
            frequency_khz,
            sample_format: format,
            ..ChannelInfo::zeroed()
        }));
    }
    bytes.resize(1024, 0);
    for index in 0..file.pings {
        bytes.extend((file.before)(index));
        bytes.extend(ping(file, index));
    }
    bytes
}

fn ping(file: &Xtf, index: usize) -> Vec<u8> {
    let side_len = size_of::<PingChannel>() + SAMPLES * usize::from(file.stored.0);
    let size = size_of::<PingHeader>() + file.channels.len() * side_len;
    let (time, hundredths) = time(index);
    let mut header = PingHeader {
        packet: PacketHeader { channels: file.channels.len() as u16, ..packet(0, size) },
        time,
        hundredths,
        sensor_heading_deg: 90.0,
        ..PingHeader::zeroed()
    };
    (file.ping)(index, &mut header);
    let mut bytes = bytes_of(&header).to_vec();
    for (number, (kind, _)) in file.channels.iter().enumerate() {
        let mut side = PingChannel {
            channel: number as u16,
            samples: SAMPLES as u32,
            ..PingChannel::zeroed()
        };
        (file.side)(index, &mut side);
        bytes.extend(bytes_of(&side));
        for sample in 0..SAMPLES {
            // Port is stored from far to near.
            let sample = if *kind == 1 { SAMPLES - 1 - sample } else { sample };
            bytes.extend((file.sample)(index, sample));
        }
    }
    bytes
}

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    formats::open_bytes("pond.xtf", bytes, &Progress::new())
}

fn read(file: &Xtf) -> Survey {
    open(written(file)).unwrap_or_else(|error| panic!("{error}"))
}

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
fn two_frequencies() -> Xtf {
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

#[test]
fn a_growing_log_is_what_the_whole_one_is() {
    let weighted = Xtf {
        header: |header| header.sonar_type = 38,
        // Later samples are louder than those from which the scale was chosen.
        sample: |ping, sample| {
            let loud = value(sample) << (ping % 4) << (ping / 300);
            loud.min(65_535).to_le_bytes()[..2].to_vec()
        },
        side: |index, side| {
            side.slant_range_m = 25.0;
            side.weight = (index % 4) as i16;
        },
        ..Xtf::default()
    };
    let metres = Xtf {
        header: |header| header.nav_units = 0,
        ping: |index, ping| {
            (ping.ship_x, ping.ship_y) = (480_000.0, 5_300_000.0 + index as f64 * 0.5);
            ping.layback_m = 20.0;
        },
        ..Xtf::default()
    };
    let sent = Xtf { ping: |_, _| (), before: raw_navigation, ..Xtf::default() };
    let floating = Xtf {
        stored: (4, 5, true),
        sample: |ping, sample| ((ping * sample) as f32).to_le_bytes().to_vec(),
        ..Xtf::default()
    };
    for file in [two_frequencies(), weighted, metres, sent, floating] {
        let bytes = written(&Xtf { pings: 400, ..file });
        check_growing("pond.xtf", &bytes, |known, grown, whole| {
            // The scale remains that of the shorter log.
            let spans = |survey: &Survey| -> Vec<_> {
                let pings = survey.pairs.iter().map(|pair| &pair.side_scan);
                let pings = std::iter::once(&survey.side_scan).chain(pings);
                let sides = pings.flat_map(|pings| pings.iter());
                sides
                    .map(|ping| {
                        (ping.time_s, ping.depth_m.to_bits(), ping.port.map(|span| span.offset))
                    })
                    .collect()
            };
            assert_eq!(spans(grown), spans(whole));
            assert_eq!(outward(grown, 0, Side::Port), outward(known, 0, Side::Port));
            let encodings = |ping: usize| grown.side_scan[ping].port.map(|span| span.encoding);
            assert_eq!(encodings(0), encodings(396));
            assert_eq!(test_logs::places(grown), test_logs::places(whole));
        });
    }
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_pings() {
    for file in [
        two_frequencies(),
        Xtf {
            header: |header| header.sonar_type = 38,
            stored: (4, 5, false),
            sample: |_, sample| (value(sample) as f32).to_le_bytes().to_vec(),
            ping: |_, ping| {
                ping.layback_m = 5.0;
            },
            before: raw_navigation,
            ..Xtf::default()
        },
    ] {
        let small = written(&Xtf { pings: 2, ..file });
        for bytes in beginnings(&small) {
            assert_bounded("pond.xtf", bytes, 8);
        }
        let mut random = Random(20_210_605);
        // Only headers are damaged, not samples: headers are in the first bytes and at the
        // beginning of packets.
        let starts: Vec<usize> = (0..small.len() - 1)
            .filter(|&at| at < 512 || small[at..].starts_with(&[0xCE, 0xFA]))
            .collect();
        for _ in 0..4000 {
            let mut bytes = small.clone();
            for _ in 0..=random.below(4) {
                let at = starts[random.below(starts.len())] + random.below(330);
                let at = at.min(bytes.len() - 1);
                bytes[at] = random.below(256) as u8;
            }
            assert_bounded("pond.xtf", bytes, 8);
        }
        for at in (0..640).chain(1024..1024 + 330) {
            for claimed in [i32::MAX as u32, 1 << 31, u32::MAX, 0xFF_FFF0] {
                let mut bytes = small.clone();
                bytes[at..at + 4].copy_from_slice(&claimed.to_le_bytes());
                assert_bounded("pond.xtf", bytes, 8);
            }
        }
    }
}
