//! Tests that a picture and its table are read correctly, and that files that do not belong
//! together are refused in one sentence.

use crate::formats::log_writer::LogToWrite;
use crate::formats::test_logs::says;
use crate::formats::{self, GrowingError, GrowingLog, OpenError};
use crate::support::progress::Progress;
use crate::survey::{
    ChannelKind, HeadingSettings, Projection, Side, SideScanState, Survey, navigate,
};
use bathyscope_test_support::Random;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use std::path::PathBuf;

/// Columns and rows of the small picture.
const WIDTH: usize = 9;
const ROWS: usize = 3;

/// Returns a level of the small picture.
fn level(row: usize, column: usize) -> u8 {
    (20 * row + 3 * column) as u8
}

fn levels() -> Vec<u8> {
    let rows = (0..ROWS).flat_map(|row| (0..WIDTH).map(move |column| level(row, column)));
    rows.collect()
}

fn png(colours: ExtendedColorType, [width, height]: [usize; 2], levels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new(&mut bytes);
    let written = encoder.write_image(levels, width as u32, height as u32, colours);
    written.expect("a PNG");
    bytes
}

fn small() -> Vec<u8> {
    png(ExtendedColorType::L8, [WIDTH, ROWS], &levels())
}

const TABLE: &str = "time,lon,lat,depth_m,range_m,min_range_m,heading_deg\n1634000000,11.5,48.1,2.5,20,0.5,90\n1634000000.5,11.6,48.2,3,20,,90\n1634000001,11.7,48.3,3.5,25.5,1,180\n";

fn pair(picture: Vec<u8>, table: &str) -> Vec<(PathBuf, Vec<u8>)> {
    vec![(PathBuf::from("logs/pond.png"), picture), (PathBuf::from("logs/pond.csv"), table.into())]
}

fn open(picture: Vec<u8>, table: &str) -> Result<Survey, OpenError> {
    formats::open_files(pair(picture, table), &Progress::new())
}

fn read(picture: Vec<u8>, table: &str) -> Survey {
    open(picture, table).unwrap_or_else(|error| panic!("{error}\n{table}"))
}

fn refusal(picture: Vec<u8>, table: &str) -> String {
    open(picture, table).expect_err(table).to_string()
}

fn outward(survey: &Survey, ping: usize, side: Side) -> Vec<u16> {
    let samples = survey.samples(ping, side).expect("samples");
    (0..samples.len()).map(|at| samples.wide(at)).collect()
}

/// Asserts that the pings are rows of the small picture.
fn assert_rows(survey: &Survey, rows: &[usize]) {
    assert_eq!(survey.side_scan.len(), rows.len());
    for (ping, row) in rows.iter().enumerate() {
        let port: Vec<u16> = (0..4).rev().map(|at| level(*row, at).into()).collect();
        let starboard: Vec<u16> = (5..9).map(|at| level(*row, at).into()).collect();
        assert_eq!(outward(survey, ping, Side::Port), port);
        assert_eq!(outward(survey, ping, Side::Starboard), starboard);
    }
}

#[test]
fn samples_places_ranges_and_depths_are_those_of_the_picture_and_the_table() {
    let survey = read(small(), TABLE);
    assert_rows(&survey, &[0, 1, 2]);
    let ranges = survey.side_scan.iter().map(|ping| {
        let [port, starboard] = [ping.port, ping.starboard].map(|side| side.expect("a side"));
        assert_eq!((port.near_m, port.far_m), (starboard.near_m, starboard.far_m));
        [port.near_m, port.far_m]
    });
    let expected = [[0.5, 20.0], [0.0, 20.0], [1.0, 25.5]];
    assert_eq!(ranges.collect::<Vec<_>>(), expected);
    let times: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
    assert_eq!(times, [0.0, 0.5, 1.0]);
    assert_eq!(survey.start_unix_s, Some(1_634_000_000.0));
    let depths = survey.side_scan.iter().map(|ping| ping.depth_m);
    assert_eq!(depths.collect::<Vec<_>>(), [2.5, 3.0, 3.5]);
    assert_eq!(survey.soundings.len(), 3);
    let last = survey.track.fixes[2];
    assert_eq!((last.position.lon_deg, last.position.lat_deg), (11.7, 48.3));
    assert!((last.compass_rad.to_degrees() - 180.0).abs() < 1e-4);
    let channels = survey.channels.iter();
    let counts: Vec<_> = channels.map(|channel| (channel.kind, channel.ping_count)).collect();
    let expected = [(ChannelKind::Primary, 3), (ChannelKind::Composite, 3)];
    assert_eq!(counts, expected);
    assert_eq!(survey.side_scan_state, SideScanState::Usable);
    assert_eq!(survey.source.recorder(), "picture with CSV");
    assert!(says(&survey, "water column in its middle"));
}

#[test]
fn either_file_opens_the_pair() {
    let by_picture = read(small(), TABLE);
    let mut files = pair(small(), TABLE);
    files.reverse();
    let by_table = formats::open_files(files, &Progress::new()).expect("a log");
    assert_eq!(by_table.source, by_picture.source);
    assert_eq!(by_table.side_scan, by_picture.side_scan);
    // The files are hashed and compared, not the pixels.
    let lengths = by_table.bytes.iter().map(|bytes| bytes.len());
    assert_eq!(lengths.collect::<Vec<_>>(), [small().len(), TABLE.len()]);
    assert!(by_table.seam().is_none());
}

#[test]
fn levels_of_any_colours_are_grey_ones() {
    let wide: Vec<u16> = levels().into_iter().map(|level| 100 * u16::from(level)).collect();
    let bytes: Vec<u8> = wide.iter().flat_map(|level| level.to_ne_bytes()).collect();
    let survey = read(png(ExtendedColorType::L16, [WIDTH, ROWS], &bytes), TABLE);
    assert_eq!(outward(&survey, 2, Side::Starboard), wide[23..27]);
    // 6400 has 13 bits, of which a level keeps eight.
    let samples = survey.samples(2, Side::Starboard).expect("samples");
    assert_eq!(samples.get(3), (wide[26] >> 5) as u8);
    let grey: Vec<u8> = levels().into_iter().flat_map(|level| [level; 3]).collect();
    assert_rows(&read(png(ExtendedColorType::Rgb8, [WIDTH, ROWS], &grey), TABLE), &[0, 1, 2]);
    let clear: Vec<u8> = levels().into_iter().flat_map(|level| [level, 7]).collect();
    assert_rows(&read(png(ExtendedColorType::La8, [WIDTH, ROWS], &clear), TABLE), &[0, 1, 2]);
    // Green gives the brightest level of equal colours, by ITU-R BT.709.
    let colours = [[100, 0, 0], [0, 100, 0], [0, 0, 100]].concat();
    let colours = colours.repeat(6);
    let survey = read(png(ExtendedColorType::Rgb8, [6, ROWS], &colours), TABLE);
    assert_eq!(outward(&survey, 0, Side::Starboard), [21, 72, 7]);
}

#[test]
fn the_copy_of_a_picture_in_another_format_has_all_its_bits() {
    let wide = levels().into_iter().flat_map(|level| (100 * u16::from(level)).to_ne_bytes());
    let wide: Vec<u8> = wide.collect();
    let table = "time,lon,lat,depth_m,range_m\n1634000000,11.5,48.1,2.5,20\n1634000001,11.50001,48.1,3,20\n1634000002,11.50002,48.1,3.5,25.5\n";
    let survey = read(png(ExtendedColorType::L16, [WIDTH, ROWS], &wide), table);
    let progress = Progress::new();
    let heading = HeadingSettings::default();
    let navigation = navigate(&survey, &heading, Projection::Enu, &progress);
    let log = LogToWrite { survey: &survey, navigation: &navigation.expect("a track") };
    let mut xtf = Vec::new();
    let writer = formats::writer_for("xtf".as_ref()).expect("a writer");
    let losses = writer.write(&log, &mut xtf, &progress);
    assert!(losses.is_ok(), "{losses:?}");
    let copy = formats::open_bytes("pond.xtf", xtf, &progress).expect("a log");
    assert_eq!(copy.side_scan.len(), ROWS);
    for (ping, recorded) in copy.side_scan.iter().enumerate() {
        for side in Side::BOTH {
            assert_eq!(outward(&copy, ping, side), outward(&survey, ping, side));
            let [copied, own] = [&copy, &survey].map(|log| log.span(ping, side).expect("a side"));
            assert_eq!(copied.far_m, own.far_m);
        }
        assert_eq!(recorded.depth_m, survey.side_scan[ping].depth_m);
    }
}

fn jpeg() -> Vec<u8> {
    let mut bytes = Vec::new();
    let levels: Vec<u8> = (0..64 * 48).map(|at| 40 + (at % 64) as u8).collect();
    let written = JpegEncoder::new_with_quality(&mut bytes, 100).write_image(
        &levels,
        64,
        48,
        ExtendedColorType::L8,
    );
    written.expect("a JPEG");
    bytes
}

fn rows(count: usize) -> String {
    let row = |index: usize| format!("{index},20,11.5,48.1\n");
    "row,range_m,lon,lat\n".to_owned() + &(0..count).map(row).collect::<String>()
}

#[test]
fn a_jpeg_is_read_and_one_that_was_cut_is_not() {
    let files = |bytes: Vec<u8>| {
        let mut files = pair(bytes, &rows(48));
        files[0].0.set_extension("JPG");
        files
    };
    let survey = formats::open_files(files(jpeg()), &Progress::new()).expect("a log");
    for (at, sample) in outward(&survey, 47, Side::Starboard).into_iter().enumerate() {
        assert!((i32::from(sample) - 72 - at as i32).abs() <= 2, "{at}: {sample}");
    }
    let whole = jpeg();
    for length in [whole.len() - 1, whole.len() / 2, 30] {
        let error = formats::open_files(files(whole[..length].to_vec()), &Progress::new());
        let error = error.expect_err("cut").to_string();
        assert!(error.contains("the picture cannot be unpacked ("), "{error}");
    }
}

#[test]
fn a_table_may_name_the_rows_of_the_picture() {
    let table = |first: usize, second: usize| {
        format!(
            "line;range_ft;easting;northing\n{first};100;500000;5300000\n{second};100;500001,5;5300000\n"
        )
    };
    let survey = read(small(), &table(2, 0));
    assert_rows(&survey, &[2, 0]);
    let span = survey.span(0, Side::Port).expect("a span");
    assert!((span.far_m - 30.48).abs() < 1e-5);
    assert!(survey.track.projected.is_some());
    // Rows counted from 1.
    assert_rows(&read(small(), &table(1, 3)), &[0, 2]);
    let beyond = refusal(small(), &table(0, 3));
    assert!(
        beyond.contains("names row 3 of it (at byte 52), and the picture has 3 rows"),
        "{beyond}"
    );
    let twice = refusal(small(), &table(1, 1));
    assert!(twice.contains("names row 1 of it twice (at bytes 31 and 52)"), "{twice}");
}

#[test]
fn rows_that_do_not_match_are_counted() {
    let error = open(small(), &TABLE[..TABLE.len() - 40]).expect_err("two rows");
    assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("the picture has 3 rows and the table beside it 2; give"), "{text}");
    assert!(text.ends_with("logs/pond.png"), "{text}");
    let none = refusal(small(), "range_m,note\n0,x\n-3,\nnan,\n");
    assert!(none.contains("no row of the table"), "{none}");
}

#[test]
fn damaged_rows_cost_their_pings_only() {
    let survey = read(small(), "range_m,lon,lat,depth_m\n20,11.5,48.1,2\nfar,11.6,48.2,3\n20,,,\n");
    assert_rows(&survey, &[0, 2]);
    assert_eq!((survey.soundings.len(), survey.track.fixes.len()), (2, 2));
    let place = survey.warnings.iter().find_map(|warning| warning.place);
    assert_eq!(place, Some((1, 39)));
    // A range is the only column that is needed.
    let survey = read(small(), "range_m,note\n20,\n20,\n20,\n");
    assert_rows(&survey, &[0, 1, 2]);
    assert!(says(&survey, "no position") && says(&survey, "no depth"));
    assert!(says(&survey, "1.000 s apart") && !says(&survey, "names no unit"));
}

#[test]
fn pings_without_times_are_as_far_apart_as_a_boat_makes_them() {
    // The rows are 1.11 m apart.
    let survey = read(small(), "range_m,lon,lat\n20,11.5,0.0\n20,11.5,0.00001\n20,11.5,0.00002\n");
    let times: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
    let step_s = 1.106 / 1.5;
    for (index, time_s) in times.iter().enumerate() {
        assert!((time_s - step_s * index as f64).abs() < 0.002, "{times:?}");
    }
    let fixes: Vec<f64> = survey.track.fixes.iter().map(|fix| fix.time_s).collect();
    assert_eq!(fixes, times);
    assert!(says(&survey, "a boat of 1.5 m/s"));
}

#[test]
fn pings_of_one_second_are_spread_over_it() {
    let table =
        "row,time,range_m,lon,lat\n0,100,20,11.5,48.1\n1,100,20,11.51,48.1\n2,101,20,11.52,48.1\n";
    let survey = read(small(), table);
    let times: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
    assert_eq!(times, [0.0, 0.5, 1.0]);
    let fixes: Vec<f64> = survey.track.fixes.iter().map(|fix| fix.time_s).collect();
    assert_eq!(fixes, times);
    assert!(says(&survey, "evenly spread"));
    // A date without a time of day is no time.
    let table = table.replace(",101,", ",100,").replace(",100,", ",2021-10-12,");
    let survey = read(small(), &table);
    let times: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
    assert_eq!(times, [0.0, 1.0, 2.0]);
}

#[test]
fn a_picture_without_such_a_table_is_refused_and_a_table_without_a_picture_is_what_it_was() {
    let alone = formats::open_bytes("pond.png", small(), &Progress::new()).expect_err("no table");
    assert!(matches!(alone, OpenError::Unsupported { .. }), "{alone}");
    assert!(alone.to_string().contains("range_m"), "{alone}");
    let without = refusal(small(), "lon,lat,depth_m\n11.5,48.1,2\n11.6,48.2,3\n11.7,48.3,3\n");
    assert!(without.contains("range_m"), "{without}");
    let soundings = formats::open_bytes("pond.csv", TABLE.into(), &Progress::new()).expect("a log");
    assert_eq!(soundings.source.format, "CSV of soundings");
    assert_eq!(soundings.side_scan_state, SideScanState::Absent);
    let no_depths = formats::open_bytes("pond.csv", rows(3).into(), &Progress::new());
    let error = no_depths.expect_err("no depths");
    assert!(matches!(error, OpenError::NotRecognised { .. }), "{error}");
}

/// Returns the checksum at the end of a part of a PNG.
fn sum(bytes: &[u8]) -> [u8; 4] {
    let step = |sum: u32, byte: &u8| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| match sum & 1 {
            0 => sum >> 1,
            _ => (sum >> 1) ^ 0xEDB8_8320,
        })
    };
    (!bytes.iter().fold(u32::MAX, step)).to_be_bytes()
}

#[test]
fn what_a_header_states_is_believed_within_bounds() {
    let stating = |width: u32, height: u32| {
        let mut bytes = small();
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let sum = sum(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&sum);
        bytes
    };
    assert_rows(&read(stating(9, 3), TABLE), &[0, 1, 2]);
    let large = open(stating(60_000, 60_000), TABLE).expect_err("3.6 GB");
    assert!(matches!(large, OpenError::Unsupported { .. }), "{large}");
    let text = large.to_string();
    assert!(text.contains("its 60000 by 60000 pixels take more than 1024 MiB"), "{text}");
    // Sizes below the limit, but larger than the bytes can contain.
    for (width, height) in [(300_000_000, 3), (9, 4), (1, 3), (u32::MAX, 3)] {
        let error = refusal(stating(width, height), TABLE);
        assert!(error.contains("picture") && !error.contains('\n'), "{error}");
    }
    // Only its last parts, which contain no pixels, may be missing.
    for length in 0..small().len() - 24 {
        let error = refusal(small()[..length].to_vec(), TABLE);
        assert!(!error.is_empty() && !error.contains('\n'), "{error}");
    }
}

#[test]
fn a_folder_lists_pairs_once_and_no_other_pictures() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    };
    let pond = write("pond.png", &small());
    let table = write("pond.csv", TABLE.as_bytes());
    write("holiday.png", &small());
    write("chart.jpg", &jpeg());
    write("chart.csv", b"lon,lat,depth_m\n11.5,48.1,2.5\n");
    write("lone.csv", TABLE.as_bytes());
    assert_eq!(formats::logs_in(folder.path()), std::slice::from_ref(&pond));
    assert!(formats::unusable_in(folder.path()).is_empty());
    let survey = formats::open(&table, &Progress::new()).expect("a log");
    assert_eq!(survey.source.files, [pond, table.clone()]);
    assert!(survey.check_files().is_ok());
    let followed = GrowingLog::start(&survey, &Progress::new());
    assert!(matches!(followed, Err(GrowingError::Packed)));
}

#[test]
fn hostile_bytes_do_not_end_the_program() {
    let mut random = Random(88_172_645_463_325_252);
    for round in 0..3000 {
        let (mut picture, mut table) = match round % 2 {
            0 => (small(), TABLE.as_bytes().to_vec()),
            _ => (jpeg(), rows(48).into_bytes()),
        };
        let harmed = match round % 3 {
            0 => &mut picture,
            _ => &mut table,
        };
        for _ in 0..=random.below(4) {
            let at = random.below(harmed.len());
            harmed[at] = random.below(256) as u8;
        }
        let files = vec![(PathBuf::from("pond.png"), picture), (PathBuf::from("pond.csv"), table)];
        if let Ok(survey) = formats::open_files(files, &Progress::new()) {
            for ping in 0..survey.side_scan.len() {
                for side in Side::BOTH {
                    assert!(!outward(&survey, ping, side).is_empty());
                }
            }
            assert!(survey.side_scan.iter().all(|ping| ping.time_s.is_finite()));
        }
    }
}
