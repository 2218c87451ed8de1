//! Tests that generated RSD files, whole, growing and damaged, are read as they were written, and
//! hostile files as far as possible: without a panic, a hang, or memory by a stated size.

use crate::formats::test_logs::{held, outward, places, says};
use crate::formats::{OpenError, open_bytes, open_growing, open_tail};
use crate::support::progress::Progress;
use crate::survey::{ChannelKind, Encoding, Side, Survey, SurveyVersions};
use bathyscope_test_support::Random;
use bathyscope_test_support::garmin::{
    Band, GARMIN_S, HEADER, Ping, START_UNIX_S, TILT_DEG, header, record, structure,
};

/// Name of the log.
const LOG: &str = "log.rsd";

/// Channels of a traditional sonar, a down-scan and a pair of sides, with numbers that units use.
const BANDS: [Band; 4] =
    [(2, 150_000, 240_000), (4, 425_000, 485_000), (5, 425_000, 485_000), (6, 795_000, 805_000)];
/// Milliseconds between two pings of a channel.
const STEP_MS: u32 = 100;

/// Number, beam and tilt in degrees of each channel, the port side first.
const CHANNELS: [(u32, u32, Option<f32>); 4] =
    [(4, 2, Some(-TILT_DEG)), (5, 3, Some(TILT_DEG)), (2, 1, None), (6, 4, None)];

/// Returns a sample whose value depends on its channel, its ping and its place.
fn sample(channel: u32, ping: usize, place: usize) -> u16 {
    (channel as usize * 100 + ping * 3 + place * 16) as u16 % 4096
}

/// Returns the pings of the four channels, in the order in which they are written.
fn pings(count: usize) -> Vec<Ping> {
    let of = |ping: usize| {
        CHANNELS.iter().enumerate().map(move |(place, &(channel, beam, tilt_deg))| Ping {
            channel: Some(channel),
            beam: Some(beam),
            tilt_deg,
            sequence: ping as u32,
            time_ms: 500 + ping as u32 * STEP_MS + place as u32,
            bottom_mm: Some(8_000 + ping as i32),
            range_mm: Some(match beam {
                2 | 3 => [0, 40_000 + 10 * ping as i32],
                _ => [250, 15_000],
            }),
            place_deg: Some([43.125 + ping as f64 * 4e-6, -83.434 + ping as f64 * 2e-6]),
            samples: (0..120 + 2 * beam as usize).map(|at| sample(channel, ping, at)).collect(),
            ..Ping::default()
        })
    };
    (0..count).flat_map(of).collect()
}

/// Writes these pings into a file; each channel begins with a record without a body.
fn file(pings: &[Ping]) -> Vec<u8> {
    let mut bytes = header(GARMIN_S, &BANDS);
    for (channel, ..) in CHANNELS {
        let begins = Ping { channel: Some(channel), ..Ping::default() };
        bytes.extend(record(&begins, &[]));
    }
    bytes.extend(pings.iter().flat_map(Ping::record));
    bytes
}

fn open(bytes: Vec<u8>) -> Result<Survey, OpenError> {
    open_bytes(LOG, bytes, &Progress::new())
}

fn read(bytes: Vec<u8>) -> Survey {
    open(bytes).expect("a log")
}

fn kinds(survey: &Survey) -> Vec<(String, ChannelKind, usize)> {
    let of = |channel: &crate::survey::Channel| {
        (channel.recorder_name.clone(), channel.kind, channel.ping_count)
    };
    survey.channels.iter().map(of).collect()
}

#[test]
fn all_channels_are_read_with_depths_ranges_positions_and_times() {
    let survey = read(file(&pings(40)));
    assert_eq!(survey.warnings, [], "{:?}", survey.warnings);
    assert_eq!(survey.source.format, "Garmin RSD");
    assert_eq!(survey.source.device, "Garmin product 4040");
    assert_eq!(survey.start_unix_s, Some(START_UNIX_S));
    let expected = [
        ("2", ChannelKind::Primary),
        ("6", ChannelKind::DownScan),
        ("4", ChannelKind::Port),
        ("5", ChannelKind::Starboard),
    ];
    let expected = expected.map(|(name, kind)| (name.to_owned(), kind, 40));
    assert_eq!(kinds(&survey), expected);
    let khz: Vec<_> = survey.channels.iter().map(|channel| channel.frequency_khz).collect();
    assert_eq!(khz, [Some(195.0), Some(800.0), Some(455.0), Some(455.0)]);
    assert_eq!(survey.side_scan.len(), 40);
    let ping = &survey.side_scan[7];
    assert_eq!(ping.time_s, 1.2);
    // The depth is the sounding of the traditional sonar, two milliseconds later.
    assert_eq!(ping.depth_m, 8.007);
    for side in Side::BOTH {
        let span = ping.side(side).expect("a side");
        assert_eq!((span.near_m, span.far_m), (0.0, 40.07));
    }
    assert_eq!(survey.soundings.len(), 40);
    assert_eq!(survey.sounding_channel, Some(ChannelKind::Primary));
    let fix = survey.track.fixes.iter().find(|fix| fix.time_s == 1.2).expect("a fix");
    assert!((fix.position.lat_deg - 43.125_028).abs() < 1e-7);
    assert!((fix.position.lon_deg + 83.433_986).abs() < 1e-7);
    let downward: Vec<_> =
        survey.echograms.iter().map(|echogram| (echogram.kind, echogram.pings.len())).collect();
    assert_eq!(downward, [(ChannelKind::DownScan, 40), (ChannelKind::Primary, 40)]);
    let span = survey.echograms[1].pings[3].span;
    assert_eq!((span.near_m, span.far_m, span.count), (0.25, 15.0, 122));
}

#[test]
fn samples_run_outward_on_both_sides_at_both_widths() {
    let wide = read(file(&pings(40)));
    // The samples use twelve bits: four are dropped.
    for (side, channel, count) in [(Side::Port, 4, 124), (Side::Starboard, 5, 126)] {
        let expected: Vec<u8> =
            (0..count).map(|place| (sample(channel, 9, place) >> 4) as u8).collect();
        assert_eq!(outward(&wide, 9, side), expected);
    }
    let narrow = |ping: Ping| Ping {
        width: 1,
        samples: ping.samples.iter().map(|sample| sample >> 4).collect(),
        ..ping
    };
    let checked = |ping: Ping| Ping { has_checksum: true, ..ping };
    let shaded = |ping: Ping| Ping { has_shade: true, ..ping };
    let untrailed = |ping: Ping| Ping { has_trailer: false, ..ping };
    for change in [&narrow as &dyn Fn(Ping) -> Ping, &checked, &shaded, &untrailed] {
        let changed: Vec<Ping> = pings(40).into_iter().map(change).collect();
        let other = read(file(&changed));
        assert_eq!(other.warnings, []);
        for ping in 0..40 {
            for side in Side::BOTH {
                assert_eq!(outward(&other, ping, side), outward(&wide, ping, side));
            }
        }
    }
}

#[test]
fn a_channel_without_a_beam_is_known_by_its_tilt_or_its_band() {
    let without = |change: fn(&mut Ping)| {
        let mut pings = pings(20);
        pings.iter_mut().for_each(change);
        read(file(&pings))
    };
    let usual = kinds(&read(file(&pings(20))));
    let tilted = without(|ping| ping.beam = ping.beam.filter(|beam| *beam == 1 || *beam == 4));
    assert_eq!(kinds(&tilted), usual);
    assert_eq!(tilted.warnings, []);
    let bare = without(|ping| (ping.beam, ping.tilt_deg) = (None, None));
    assert_eq!(kinds(&bare), usual);
    assert!(says(
        &bare,
        "channel 4, of 455 kHz, states neither its beam nor its side; it was taken for side-scan port"
    ));
    // No channel number at all, neither in the body nor in the header: the number of the beam is
    // used.
    let unnumbered = without(|ping| ping.channel = None);
    let named = ["beam 1", "beam 4", "beam 2", "beam 3"];
    let names: Vec<_> =
        unnumbered.channels.iter().map(|channel| channel.recorder_name.as_str()).collect();
    assert_eq!(names, named);
    assert_eq!(unnumbered.side_scan.len(), 20);
    // A file without the header's list of channels, frequencies and beams: the channels are
    // guessed.
    let mut bytes = file(&[]);
    let unlisted = header(GARMIN_S, &[]);
    bytes[..HEADER].copy_from_slice(&unlisted);
    let mut plain = pings(20);
    plain.retain(|ping| matches!(ping.beam, Some(1 | 4)));
    plain.iter_mut().for_each(|ping| ping.beam = None);
    bytes.extend(plain.iter().flat_map(Ping::record));
    let survey = read(bytes);
    let shown: Vec<_> =
        survey.echograms.iter().map(|echogram| (echogram.kind, echogram.pings.len())).collect();
    assert_eq!(shown, [(ChannelKind::Secondary, 20), (ChannelKind::Primary, 20)]);
}

/// Returns the pings, and their sides again as channels with numbers higher by ten, `later_ms`
/// later.
fn with_second_pair(count: usize, later_ms: u32) -> Vec<Ping> {
    let first = pings(count);
    let second = first.iter().filter(|ping| matches!(ping.beam, Some(2 | 3))).cloned();
    let second = second.map(|ping| Ping {
        channel: ping.channel.map(|channel| channel + 10),
        time_ms: ping.time_ms + later_ms,
        ..ping
    });
    let mut all: Vec<Ping> = first.iter().cloned().chain(second).collect();
    all.sort_by_key(|ping| ping.time_ms);
    all
}

#[test]
fn of_two_pairs_at_once_one_is_shown_and_of_two_in_turn_both() {
    let at_once = read(file(&with_second_pair(60, 4)));
    assert_eq!(at_once.side_scan.len(), 60);
    assert!(says(&at_once, "channel 14 (side-scan port) was recorded at the same time"));
    assert!(kinds(&at_once).contains(&("15".to_owned(), ChannelKind::Other(15), 60)));
    let in_turn = read(file(&with_second_pair(60, 60 * STEP_MS)));
    assert_eq!(in_turn.side_scan.len(), 120);
    // The boat of the second pair starts again where the first pair started.
    assert_eq!(in_turn.warnings.len(), 1, "{:?}", in_turn.warnings);
    assert!(says(&in_turn, "the positions jump once farther than the boat can go"));
    // Switched to the second pair after a moment: the pair with nearly all of the pings is shown.
    let mut switched = with_second_pair(300, 4);
    switched.retain(|ping| ping.channel > Some(10) || ping.time_ms < 3_500);
    let switched = read(file(&switched));
    assert!(kinds(&switched).contains(&("14".to_owned(), ChannelKind::Port, 300)));
    assert_eq!(switched.side_scan.len(), 300);
}

#[test]
fn depths_that_are_unsigned_are_told_from_signed_ones() {
    let mut some = pings(30);
    for ping in &mut some {
        ping.unsigned = true;
        ping.range_mm = ping.range_mm.map(|[near, far]| [near, far + 1]);
    }
    let survey = read(file(&some));
    assert_eq!(survey.side_scan[0].port.expect("a side").far_m, 40.001);
    assert_eq!(survey.soundings[0].depth_m, 8.0);
    assert!(says(&survey, "stored as unsigned integers"));
}

#[test]
fn what_is_missing_is_missing_and_the_sound_is_read() {
    let mut some = pings(10);
    for ping in &mut some {
        (ping.place_deg, ping.bottom_mm) = (Some([0.0, 0.0]), None);
    }
    some[4].range_mm = None;
    some[9].stated_samples = Some(u32::MAX);
    let mut bytes = file(&some);
    bytes[..HEADER].copy_from_slice(&header(0, &BANDS));
    let survey = read(bytes);
    assert_eq!((survey.start_unix_s, survey.track.fixes.len()), (None, 0));
    assert_eq!((survey.side_scan.len(), survey.soundings.len()), (10, 0));
    assert!(survey.side_scan[1].port.is_none() && survey.side_scan[2].starboard.is_none());
    assert!(says(&survey, "has 124 samples over no range that can be"));
    assert!(says(&survey, "says that it has 4294967295 samples, which do not lie in its record"));
    let lost = [i32::MIN as f64 * 360.0 / 4_294_967_296.0; 2];
    let mut some = pings(10);
    some.iter_mut().for_each(|ping| ping.place_deg = Some(lost));
    assert_eq!(read(file(&some)).track.fixes.len(), 0);
}

#[test]
fn damage_is_named_with_its_place_and_the_rest_is_read() {
    let some = pings(20);
    let whole = file(&some);
    let records: Vec<Vec<u8>> = some.iter().map(Ping::record).collect();
    let start = whole.len() - records.iter().map(Vec::len).sum::<usize>();
    let at = |record: usize| start + records[..record].iter().map(Vec::len).sum::<usize>();
    let places = |survey: &Survey| -> Vec<_> {
        survey.warnings.iter().filter_map(|warning| warning.place).collect()
    };

    let mut torn = whole.clone();
    torn.splice(at(8)..at(8), [0x55; 33]);
    let torn = read(torn);
    assert_eq!(places(&torn), [(0, at(8) as u64)]);
    assert!(says(&torn, "33 bytes belong to no record"));
    assert_eq!(torn.side_scan.len(), 20);

    // The size of the body is field 4 with two bytes, before the header's field 5, the checksum and
    // the body.
    let mut grown = whole.clone();
    let size_at = at(9) + records[9].len() - 12 - some[9].body().len() - 4 - 5 - 2;
    assert_eq!(grown[size_at - 1], 4 << 3 | 2);
    grown[size_at + 1] = 0xFF;
    let grown = read(grown);
    assert_eq!(places(&grown), [(0, at(9) as u64)]);
    assert!(says(&grown, "but the next begins after"));
    let sides = grown.side_scan.iter().map(|ping| [ping.port, ping.starboard]);
    assert_eq!(sides.flatten().flatten().count(), 39);

    let cut = read(whole[..whole.len() - 30].to_vec());
    assert_eq!(places(&cut), [(0, at(79) as u64)]);
    assert!(says(&cut, "cut inside its last record"));
    assert_eq!(cut.side_scan.len(), 20);

    let mut damaged_header = whole.clone();
    damaged_header[..8].fill(0xEE);
    let found = read(damaged_header);
    assert!(says(&found, "the file header is damaged"));
    assert_eq!((found.side_scan.len(), found.start_unix_s), (20, None));
}

#[test]
fn a_file_without_a_ping_is_broken() {
    for bytes in [file(&[]), header(GARMIN_S, &BANDS)] {
        let error = open(bytes).expect_err("no ping");
        assert!(matches!(error, OpenError::Broken { .. }), "{error}");
        assert!(error.to_string().contains("no ping in its"), "{error}");
    }
}

/// Reads a file that is still being written.
fn growing(bytes: &[u8]) -> Option<Survey> {
    open_growing(held(LOG, bytes), &Progress::new()).ok()
}

fn assert_same(grown: &Survey, whole: &Survey) {
    assert_eq!(grown.side_scan.len(), whole.side_scan.len());
    for (a, b) in grown.side_scan.iter().zip(whole.side_scan.iter()) {
        assert_eq!((a.time_s, a.port, a.starboard), (b.time_s, b.port, b.starboard));
        assert_eq!(a.depth_m.to_bits(), b.depth_m.to_bits());
    }
    assert_eq!(grown.soundings, whole.soundings);
    assert_eq!(grown.channels, whole.channels);
    assert_eq!(grown.source, whole.source);
    assert_eq!(grown.start_unix_s, whole.start_unix_s);
    assert!(grown.echograms == whole.echograms, "echograms");
    assert_eq!(places(grown), places(whole));
    for (ping, side) in (0..whole.side_scan.len()).zip(Side::BOTH.into_iter().cycle()) {
        let levels = |survey: &Survey| {
            let mut levels = Vec::new();
            if let Some(samples) = survey.samples(ping, side) {
                samples.copy_outward(&mut levels);
            }
            levels
        };
        assert_eq!(levels(grown), levels(whole), "ping {ping}");
    }
}

/// Splits a file at many places, also within records; returns how often reading the tail was
/// enough.
fn split(bytes: &[u8], places: usize) -> usize {
    let finished = growing(bytes).expect("a log");
    let mut by_tail = 0;
    for place in 1..places {
        let end = bytes.len() * place / places;
        let Some(known) = growing(&bytes[..end]) else {
            continue;
        };
        // In a log that is so short, the channel of the soundings may still change.
        if known.sounding_channel != finished.sounding_channel {
            continue;
        }
        assert!(
            known.warnings.iter().all(|warning| warning.place.is_none()),
            "a record that is cut is no damage"
        );
        let Some(seam) = known.seam() else { continue };
        let tail = open_tail(&known, &seam, held(LOG, bytes), &Progress::new()).expect("a tail");
        let grown = known.extended(tail, &seam, &mut SurveyVersions::default());
        if let Some(grown) = grown {
            assert_same(&grown, &finished);
            by_tail += usize::from(seam.from[0] > 0);
        }
    }
    by_tail
}

/// Returns pings whose samples use the same bits from the first to the last.
fn even(mut pings: Vec<Ping>) -> Vec<Ping> {
    for ping in &mut pings {
        ping.samples = (0..40).map(|place| place * 100).collect();
    }
    pings
}

#[test]
fn tails_make_the_survey_of_the_whole_file() {
    assert!(split(&file(&even(pings(400))), 61) > 20);
    assert!(split(&file(&even(with_second_pair(200, 4))), 47) > 15);
    assert!(split(&file(&even(with_second_pair(200, 20_000))), 47) > 15);
}

#[test]
fn the_levels_of_a_log_stay_when_louder_pings_come() {
    let mut some = even(pings(300));
    let quiet = some.iter_mut().take(4 * 200);
    quiet.for_each(|ping| ping.samples.iter_mut().for_each(|sample| *sample /= 16));
    let bytes = file(&some);
    let known = growing(&bytes[..bytes.len() * 6 / 10]).expect("a log");
    let seam = known.seam().expect("a seam");
    let tail = open_tail(&known, &seam, held(LOG, &bytes), &Progress::new()).expect("a tail");
    let grown = known.extended(tail, &seam, &mut SurveyVersions::default()).expect("a log");
    let sides = grown.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]).flatten();
    let down =
        grown.echograms.iter().flat_map(|echogram| echogram.pings.iter().map(|ping| ping.span));
    let spans: Vec<_> = sides.chain(down).collect();
    assert_eq!(spans.len(), 4 * 300);
    assert!(spans.iter().all(|span| span.encoding == Encoding::U16 { shift: 0 }));
    let whole_log = growing(&bytes).expect("a log");
    assert_eq!(whole_log.echograms[0].pings[0].span.encoding, Encoding::U16 { shift: 4 });
}

/// Returns a file with two pings of each channel and few samples.
fn small() -> Vec<u8> {
    let mut some = pings(2);
    some.iter_mut().for_each(|ping| ping.samples.truncate(9));
    file(&some)
}

fn assert_bounded(bytes: Vec<u8>) {
    let length = bytes.len();
    if let Ok(survey) = open(bytes) {
        let records = survey.side_scan.len() + survey.track.fixes.len() + survey.soundings.len();
        assert!(records < length, "{records} of {length} bytes");
        let spans = survey.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]);
        for span in spans.flatten() {
            assert!(span.offset + u64::from(span.count) <= length as u64);
            assert!(span.far_m.is_finite() && span.near_m >= 0.0);
        }
        for fix in survey.track.fixes.iter() {
            assert!(fix.position.lat_deg.abs() < 90.0 && fix.time_s.is_finite());
        }
    }
}

#[test]
fn a_file_may_be_cut_anywhere() {
    let bytes = small();
    // All places within the padding of the header are alike.
    let header = (0..HEADER).filter(|end| *end < 400 || end % 997 == 0);
    for end in header.chain(HEADER..bytes.len()) {
        assert_bounded(bytes[..end].to_vec());
    }
    let some = open(bytes[..bytes.len() - 200].to_vec()).expect("what is left");
    assert!(!some.side_scan.is_empty());
}

#[test]
fn any_bytes_may_be_wrong() {
    let bytes = small();
    let mut random = Random(7);
    for _ in 0..4_000 {
        let mut harmed = bytes.clone();
        for _ in 0..=random.below(12) {
            // Damages the header's fields, or the records.
            let (from, to) = match random.below(4) {
                0 => (0, 300),
                _ => (HEADER, harmed.len()),
            };
            let at = from + random.below(to - from);
            harmed[at] = [0, 0x7F, 0x80, 0xFF, random.below(256) as u8][random.below(5)];
        }
        assert_bounded(harmed);
    }
}

#[test]
fn stated_sizes_of_four_gigabytes_are_not_believed() {
    let mut bytes = small();
    let long = Ping { has_trailer: false, ..pings(1).remove(0) };
    let magic_field = (0, 0xB7E9_DA86_u32.to_le_bytes().to_vec());
    // Huge sizes of bodies, and a state with a huge count of fields.
    for fields in [
        [(4, vec![0xFF; 4]), (5, vec![0; 4])],
        [(4, vec![0xFF, 0xFF, 0xFF, 0x7F]), (1, vec![0xFF; 5])],
    ] {
        let mut all = vec![magic_field.clone()];
        all.extend(fields);
        bytes.extend(structure(&all));
        bytes.extend([1; 40]);
    }
    // Headers with a field, and with a count of fields, of this size.
    bytes.extend([6, 4, 0x86, 0xDA, 0xE9, 0xB7, 0x0F, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
    bytes.extend([0xFF, 4, 0x86, 0xDA, 0xE9, 0xB7, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
    // Huge numbers of samples, and of fields in a body.
    let stated = Ping { stated_samples: Some(u32::MAX), ..long.clone() };
    bytes.extend(stated.record());
    let mut body = long.body();
    body[0] = 0x7F;
    bytes.extend(record(&long, &body));
    bytes.extend(long.record());
    let survey = open(bytes.clone()).expect("the sound records");
    assert_eq!(survey.side_scan.len(), 3);
    assert_bounded(bytes);
    // Only magic numbers, and only records with a body of two bytes or a huge stated size.
    let magic = [6, 4, 0x86, 0xDA, 0xE9, 0xB7];
    assert_bounded(magic.iter().copied().cycle().take(1 << 20).collect());
    let tiny = [&[2][..], &magic[1..], &[4 << 3 | 1, 2, 0, 0, 0, 0, 0, 0]].concat();
    assert_bounded(tiny.iter().copied().cycle().take(1 << 20).collect());
    let lying = [&[2][..], &magic[1..], &[4 << 3 | 4, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0]].concat();
    assert_bounded(lying.iter().copied().cycle().take(1 << 20).collect());
}
