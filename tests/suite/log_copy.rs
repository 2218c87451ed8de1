//! A log that is copied into another format holds what the log holds, as far as the format can.

use crate::support::{demo_log, real_data};
use bathyscope::app::{App, Command, FileToWrite, Jobs};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::formats;
use bathyscope_log::formats::parquet_table::{Values, read_parquet};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Encoding, LEVEL_BITS, Side, SideSpan, Survey};
use bathyscope_products::export::{LogPartChoice, TimeBound, copy_log};
use bathyscope_products::pipeline::Settings;
use std::path::Path;

fn open(path: &Path) -> Survey {
    formats::open(path, &Progress::new()).unwrap_or_else(|error| panic!("{error}"))
}

/// Copies a part; returns its side-scan pings.
fn copy(survey: &Survey, choice: &LogPartChoice, path: &Path) -> usize {
    let settings = Settings::default();
    let positions = settings.position_settings();
    copy_log(path, survey, positions, choice, &Progress::new())
        .unwrap_or_else(|error| panic!("{error}"))
        .pings
}

/// The copy of a log in a format, as it is read.
fn copied(survey: &Survey, ending: &str) -> Survey {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("copy").with_extension(ending);
    copy(survey, &LogPartChoice::default(), &path);
    let mut read = open(&path);
    // The folder goes; the bytes stay mapped.
    read.source.files.clear();
    read
}

/// Samples of a side from the boat outward, as many bits as were stored.
fn samples(survey: &Survey, ping: usize, side: Side) -> Vec<u16> {
    let samples = survey.samples(ping, side);
    samples.map_or_else(Vec::new, |samples| {
        (0..samples.len()).map(|index| samples.wide(index)).collect()
    })
}

/// Checks that pings, samples, ranges, times, depths and fixes of a copy are those of the log.
/// Times count from the first ping of an XTF.
fn assert_same(log: &Survey, copy: &Survey, place_m: f64) {
    assert_eq!(log.side_scan.len(), copy.side_scan.len());
    assert_eq!(log.range_source, copy.range_source);
    let started = |survey: &Survey| survey.start_unix_s.unwrap_or_default();
    for (index, (ping, copied)) in log.side_scan.iter().zip(copy.side_scan.iter()).enumerate() {
        let [a, b] = [started(log) + ping.time_s, started(copy) + copied.time_s];
        let is_dated = log.start_unix_s.is_some() && copy.start_unix_s.is_some();
        assert!(!is_dated || (a - b).abs() < 0.000_6, "ping {index}: {a} {b}");
        let both_none = ping.depth_m.is_nan() && copied.depth_m.is_nan();
        assert!(both_none || (ping.depth_m - copied.depth_m).abs() < 1e-5, "ping {index}");
        for side in Side::BOTH {
            assert_eq!(samples(log, index, side), samples(copy, index, side), "ping {index}");
            let range = |survey: &Survey| survey.span(index, side).map(|span| span.far_m);
            let apart_m = range(log).zip(range(copy)).map_or(0.0, |(a, b)| (a - b).abs());
            assert!(apart_m < 1e-5, "ping {index}");
        }
    }
    let fix_at = |survey: &Survey, unix_s: f64| {
        let fixes = &survey.track.fixes;
        let after = fixes.partition_point(|fix| started(survey) + fix.time_s <= unix_s + 1e-3);
        fixes.get(after.saturating_sub(1)).copied()
    };
    for ping in log.side_scan.iter().step_by(7) {
        let unix_s = started(log) + ping.time_s;
        let (Some(fix), Some(copied)) = (fix_at(log, unix_s), fix_at(copy, unix_s)) else {
            continue;
        };
        let apart_m = bathyscope_log::support::geo::distance_m(fix.position, copied.position);
        assert!(apart_m <= place_m, "{unix_s}: {apart_m} m");
    }
}

#[test]
fn the_demo_as_xtf_and_as_sl2_is_the_demo() {
    let log = open(&demo_log());
    let xtf = copied(&log, "xtf");
    assert_same(&log, &xtf, 1e-6);
    // Each depth is there once, though each ping of the file has one.
    assert_eq!(log.soundings.len(), xtf.soundings.len());
    // The heading of a log without a compass is that of the track, and no compass afterwards.
    let compass =
        |survey: &Survey| survey.track.fixes.iter().any(|fix| fix.compass_rad.is_finite());
    assert_eq!(compass(&log), compass(&xtf));
    let again = copied(&log, "sl2");
    assert_same(&log, &again, 1e-6);
    assert_eq!(log.soundings, again.soundings);
    assert_eq!(log.echograms.len(), again.echograms.len());
    let back = copied(&xtf, "sl2");
    assert_same(&log, &back, 1e-6);
}

#[test]
fn real_logs_are_copied_with_all_their_bits() {
    let Some(folder) = real_data() else { return };
    for file in [
        "humminbird-glen-canyon/Rec00001.DAT",
        "xtf/000_1236.xtf",
        "lowrance/glencanyon-transcoded.sl2",
    ] {
        let path = folder.join(file);
        if !path.exists() {
            continue;
        }
        let log = open(&path);
        assert_same(&log, &copied(&log, "xtf"), 1e-3);
    }
}

#[test]
fn levels_on_a_scale_of_their_ping_are_copied_times_256() {
    let step = 3 << (LEVEL_BITS - 2);
    let mut log = open(&demo_log());
    let span = |count: u32| SideSpan {
        encoding: Encoding::ScaledU16 { base: 0, step },
        ..SideSpan::of_bytes(count, [0.0, 30.0])
    };
    let mut pings = log.side_scan[..3].to_vec();
    for ping in &mut pings {
        (ping.port, ping.starboard) = (Some(span(20)), Some(span(30)));
    }
    log.side_scan = std::sync::Arc::new(pings);
    let copy = copied(&log, "xtf");
    let expected = log.samples(1, Side::Starboard).expect("samples");
    let found = samples(&copy, 1, Side::Starboard);
    assert_eq!(found.len(), 30);
    let eight_bits: Vec<u8> = found.iter().map(|wide| (wide >> 8) as u8).collect();
    let shown: Vec<u8> = (0..30).map(|index| expected.get(index)).collect();
    assert_eq!(eight_bits, shown);
}

#[test]
fn ranges_that_begin_off_the_boat_are_filled_up() {
    let mut log = open(&demo_log());
    let mut pings = log.side_scan[..2].to_vec();
    for ping in &mut pings {
        ping.port = Some(SideSpan {
            near_m: 5.0,
            far_m: 15.0,
            count: 100,
            ..SideSpan::of_bytes(100, [0.0; 2])
        });
    }
    log.side_scan = std::sync::Arc::new(pings);
    let copy = copied(&log, "xtf");
    let port = samples(&copy, 0, Side::Port);
    assert_eq!(port.len(), 150);
    assert!(port[..50].iter().all(|sample| *sample == 0));
    assert_eq!(port[50..], samples(&log, 0, Side::Port)[..]);
    let span = copy.span(0, Side::Port).expect("a span");
    assert_eq!((span.near_m, span.far_m), (0.0, 15.0));
}

#[test]
fn a_part_holds_its_pings_and_what_was_recorded_meanwhile() {
    let log = open(&demo_log());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("part.sl2");
    let choice = LogPartChoice {
        pings: Some(PingRange { start: 100, end: 180 }),
        ..LogPartChoice::default()
    };
    assert_eq!(copy(&log, &choice, &path), 80);
    let part = open(&path);
    assert_eq!(samples(&part, 0, Side::Port), samples(&log, 100, Side::Port));
    assert_eq!(samples(&part, 79, Side::Starboard), samples(&log, 179, Side::Starboard));
    let [from, to] = [100, 180].map(|ping| log.side_scan[ping].time_s);
    let meanwhile = log.soundings.iter().filter(|sounding| (from..to).contains(&sounding.time_s));
    assert_eq!(part.soundings.len(), meanwhile.count());
    let time = Some([TimeBound::Log(from), TimeBound::Log(to - 1e-3)]);
    let by_time = LogPartChoice { time, ..LogPartChoice::default() };
    let other = folder.path().join("time.sl2");
    copy(&log, &by_time, &other);
    assert!(std::fs::read(&path).expect("a file") == std::fs::read(&other).expect("a file"));
}

#[test]
fn tables_have_a_row_for_each_trace() {
    let log = open(&demo_log());
    let folder = tempfile::tempdir().expect("a folder");
    let [csv, parquet, gpx] =
        ["csv", "parquet", "gpx"].map(|ending| folder.path().join("log").with_extension(ending));
    for path in [&csv, &parquet, &gpx] {
        copy(&log, &LogPartChoice::default(), path);
    }
    let down: usize = log.echograms.iter().map(|echogram| echogram.pings.len()).sum();
    let count = 2 * log.side_scan.len() + down + log.soundings.len();
    let mut rows = csv::Reader::from_path(&csv).expect("a table");
    let header = rows.headers().expect("a header").clone();
    let column = |name: &str| header.iter().position(|heading| heading == name).expect("a column");
    let rows: Vec<csv::StringRecord> = rows.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), count);
    let starboard =
        rows.iter().find(|row| &row[0] == "starboard" && &row[1] == "70").expect("a row");
    let span = log.span(70, Side::Starboard).expect("a span");
    assert_eq!(starboard[column("offset")], span.offset.to_string());
    assert_eq!(starboard[column("samples")], span.count.to_string());
    let far_m: f32 = starboard[column("far_m")].parse().expect("a number");
    assert!((far_m - span.far_m).abs() < 1e-4);

    let table = read_parquet(&parquet, &["channel", "index", "samples", "echoes"]);
    let table = table.expect("a table");
    let [channels, indices, _, echoes] = table.as_slice() else { panic!("four columns") };
    let (Values::Bytes(echoes), Values::Whole(indices)) = (echoes, indices) else {
        panic!("bytes and whole numbers");
    };
    assert_eq!((channels.row_count(), echoes.len()), (count, count));
    let stored = samples(&log, 70, Side::Port);
    let row = (0..count).find(|row| {
        indices[*row] == Some(70) && !echoes[*row].is_empty() && echoes[*row].len() == stored.len()
    });
    let row = row.expect("a row of the ping");
    assert!(echoes[row].iter().map(|byte| u16::from(*byte)).eq(stored));
    let text = std::fs::read_to_string(&gpx).expect("a track");
    assert!(text.contains("<trkpt"));
}

#[test]
fn the_window_writes_the_log_and_its_visible_pings() {
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::OpenDemo);
    app.poll();
    let folder = tempfile::tempdir().expect("a folder");
    let [whole, part] = ["log.xtf", "part.xtf"].map(|name| folder.path().join(name));
    app.apply(Command::Write(FileToWrite::Log(whole.clone())));
    app.poll();
    app.apply(Command::Visible(40..90));
    app.apply(Command::Write(FileToWrite::Pings(part.clone())));
    app.poll();
    let log = open(&demo_log());
    assert_eq!(open(&whole).side_scan.len(), log.side_scan.len());
    assert_eq!(open(&part).side_scan.len(), 50);
    assert_eq!(samples(&open(&part), 0, Side::Port), samples(&log, 40, Side::Port));
    let other = folder.path().join("log.doc");
    app.apply(Command::Write(FileToWrite::Log(other.clone())));
    app.poll();
    let notice = app.notices.shown().last().expect("a notice");
    assert!(notice.text.contains(".parquet") && !other.exists(), "{}", notice.text);
}
