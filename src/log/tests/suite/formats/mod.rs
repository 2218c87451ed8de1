//! Logs are read as they are: the real ones to the counts of their README, small handmade ones for
//! every trap of the formats, among them Humminbird recordings of every family with missing or
//! damaged files, and XTF files with both sample widths and both kinds of positions.

mod lowrance;
mod real;

use bathyscope_log::formats::{self, OpenError};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    ChannelKind, RangeSource, SampleOrder, Side, SideScanState, Survey, Warning,
};
use bathyscope_test_support::handmade::{self, Frame};
use std::path::{Path, PathBuf};

fn open(file: &str) -> Option<Survey> {
    let path = bathyscope_test_support::real_data()?.join(file);
    Some(formats::open(&path, &Progress::new()).unwrap_or_else(|error| panic!("{error}")))
}

fn read(bytes: Vec<u8>) -> Survey {
    formats::open_bytes("pond.sl2", bytes, &Progress::new())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn counts(survey: &Survey) -> Vec<(ChannelKind, usize)> {
    survey.channels.iter().map(|channel| (channel.kind, channel.ping_count)).collect()
}

fn says(survey: &Survey, words: &str) -> bool {
    survey.warnings.iter().any(|warning| warning.text.contains(words))
}

fn depth_span_m(survey: &Survey) -> (f32, f32) {
    survey.soundings.iter().fold((f32::MAX, f32::MIN), |(low, high), sounding| {
        (low.min(sounding.depth_m), high.max(sounding.depth_m))
    })
}

fn outward(survey: &Survey, ping: usize, side: Side) -> Vec<u8> {
    let mut samples = Vec::new();
    survey.samples(ping, side).expect("samples").copy_outward(&mut samples);
    samples
}

fn refuse(bytes: &[u8]) -> OpenError {
    formats::open_bytes("log.sl2", bytes.to_vec(), &Progress::new()).unwrap_err()
}

#[test]
fn not_a_log_broken_and_unsupported_are_different_sentences() {
    for text in
        [&b""[..], b"a", b"BND5 and some more", &[0; 5000], b"{\"type\": \"FeatureCollection\"}"]
    {
        let error = refuse(text);
        assert!(matches!(error, OpenError::NotRecognised { .. }), "{error}");
    }
    let broken = refuse(&handmade::sl2(&handmade::survey_frames(1))[..100]);
    assert!(matches!(broken, OpenError::Broken { .. }), "{broken}");
    let slg = refuse(&[1, 0, 0, 0, 0xB2, 7, 0, 0, 1, 2, 3, 4]);
    assert!(matches!(slg, OpenError::Broken { .. }), "{slg}");
    // A game's save file and a database carry the same suffixes.
    for known in [&b"BND4...."[..], b"SQLite format 3\0", b"PK\x03\x04"] {
        assert!(matches!(refuse(known), OpenError::Unsupported { .. }));
    }
}

#[test]
fn two_frames_in_another_file_are_chance() {
    let headless = |frames: i32| {
        let mut bytes = handmade::sl3(&handmade::survey_frames(frames), 168);
        bytes[..8].fill(0xEE);
        bytes.extend([7; 4000]);
        bytes
    };
    let error = refuse(&headless(1));
    assert!(matches!(error, OpenError::NotRecognised { .. }), "{error}");
    let survey = read(headless(2));
    assert!(says(&survey, "the file header is damaged"));
    // The third frame is damaged too.
    let mut bytes = headless(6);
    let frame = 168 + 400;
    bytes[8 + 2 * frame..8 + 2 * frame + 20].fill(0xEE);
    assert_eq!(read(bytes).side_scan.len(), 6);
}

#[test]
fn a_suffix_proves_nothing() {
    let bytes = handmade::sl3(&handmade::survey_frames(5), 168);
    let survey = formats::open_bytes("log.sl2", bytes, &Progress::new()).unwrap();
    assert!(survey.source.format.starts_with("Lowrance SL3"));
}

#[test]
fn a_missing_file_is_named() {
    let error = formats::open(Path::new("no-such.sl2"), &Progress::new()).unwrap_err();
    assert!(matches!(&error, OpenError::Io { .. }) && error.to_string().contains("no-such.sl2"));
}

#[test]
fn progress_ends_at_the_end() {
    let progress = Progress::new();
    let bytes = handmade::sl2(&handmade::survey_frames(50));
    formats::open_bytes("log.sl2", bytes, &progress).unwrap();
    assert_eq!(progress.fraction(), 1.0);
    formats::open_files(handmade::humminbird(40, false, false), &progress).unwrap();
    assert_eq!(progress.fraction(), 1.0);
    formats::open_bytes("log.xtf", handmade::xtf(9, 1, 3, (1.0, 2.0), 0.0), &progress).unwrap();
    assert_eq!(progress.fraction(), 1.0);
}

#[test]
fn cancel_stops_the_reading() {
    let progress = Progress::new();
    progress.cancel();
    let bytes = handmade::sl2(&handmade::survey_frames(5));
    let error = formats::open_bytes("log.sl2", bytes, &progress).unwrap_err();
    assert!(matches!(error, OpenError::Cancelled(_)));
}

fn read_files(files: Vec<(PathBuf, Vec<u8>)>) -> Survey {
    formats::open_files(files, &Progress::new()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_family_and_byte_order() {
    for (solix, little, format) in [
        (false, false, "Humminbird"),
        (true, false, "Humminbird Solix"),
        (true, true, "Humminbird Solix"),
    ] {
        let survey = read_files(handmade::humminbird(40, solix, little));
        assert_eq!(survey.source.format, format);
        assert_eq!(survey.side_scan.len(), 40);
        assert_eq!(survey.soundings.len(), 40);
        assert_eq!(survey.start_unix_s, Some(1.6e9));
        assert!((survey.side_scan[0].depth_m - 3.1).abs() < 1e-6);
        assert_eq!(survey.channels[1].sample_count, (300, 302));
        assert!((survey.track.fixes[0].cog_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
        assert_eq!(outward(&survey, 5, Side::Port)[..4], [0, 1, 2, 3]);
    }
}

#[test]
fn a_missing_or_damaged_dat_costs_the_start_time_only() {
    let mut files = handmade::humminbird(40, false, false);
    files[0].1.fill(0);
    let survey = read_files(files.clone());
    assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, None));
    assert!(says(&survey, "DAT file is damaged"));
    files.remove(0);
    let survey = read_files(files);
    assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, None));
    assert!(says(&survey, "DAT file is missing"));
}

#[test]
fn a_recording_copied_out_of_its_folder_opens_by_its_only_dat() {
    let mut files = handmade::humminbird(40, false, false);
    for (path, _) in &mut files {
        *path = PathBuf::from("copy").join(path.file_name().expect("a file"));
    }
    files[0].0 = PathBuf::from("copy/test.DAT");
    for first in 0..files.len() {
        let mut files = files.clone();
        files.swap(0, first);
        let survey = read_files(files);
        assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, Some(1.6e9)));
    }
}

#[test]
fn a_dat_alone_says_what_is_missing() {
    let files = vec![(PathBuf::from("Rec00007.DAT"), handmade::dat(false))];
    let error = formats::open_files(files, &Progress::new()).unwrap_err();
    assert!(matches!(&error, OpenError::Broken { .. }), "{error}");
    assert!(error.to_string().contains("B00n.SON"), "{error}");
}

#[test]
fn a_lost_port_ping_leaves_its_starboard_half() {
    let mut files = handmade::humminbird(40, false, false);
    let ping = files[2].1.len() / 40;
    files[2].1.drain(ping * 7..ping * 8);
    let survey = read_files(files);
    assert_eq!(survey.side_scan.len(), 40);
    assert_eq!(survey.side_scan.iter().filter(|ping| ping.port.is_none()).count(), 1);
}

#[test]
fn a_folder_of_recordings_opens_the_first_and_names_the_rest() {
    let mut files: Vec<(PathBuf, Vec<u8>)> = handmade::humminbird(20, false, false)
        .into_iter()
        .map(|(path, bytes)| (Path::new("RECORD").join(path), bytes))
        .collect();
    files.push((PathBuf::from("RECORD/Rec00008.DAT"), handmade::dat(false)));
    let folder = tempfile::tempdir().expect("a folder");
    for (path, bytes) in &files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }
    let survey = formats::open(&folder.path().join("RECORD"), &Progress::new()).unwrap();
    assert_eq!(survey.side_scan.len(), 20);
    assert!(says(&survey, "other recordings (1)"));
}

#[test]
fn eight_and_sixteen_bits_show_the_same_picture() {
    let narrow = read(handmade::xtf(20, 1, 3, (-73.6, 42.7), 0.0));
    assert_eq!(outward(&narrow, 4, Side::Starboard)[..3], [0, 1, 2]);
    assert_eq!(outward(&narrow, 4, Side::Port)[..3], [199, 198, 197]);
    // 12 bits are in use (199 * 20 = 3980): four are dropped.
    let wide = read(handmade::xtf(20, 2, 3, (-73.6, 42.7), 0.0));
    let expected: Vec<u8> = (0..200).map(|sample| (sample * 20 / 16) as u8).collect();
    assert_eq!(outward(&wide, 4, Side::Starboard), expected);
}

#[test]
fn altitude_is_depth_and_metres_are_local() {
    let survey = read(handmade::xtf(20, 1, 0, (412_000.0, 4_730_000.0), 7.5));
    assert_eq!(survey.soundings.len(), 20);
    assert_eq!(survey.side_scan[3].depth_m, 7.5);
    assert_eq!(survey.range_source, RangeSource::SurveyRecorder);
    assert!(says(&survey, "set source.crs to its EPSG number"));
    let [_, north_m] = survey.track.frame.to_enu(survey.track.fixes[19].position);
    assert!((north_m - 19.0 * 0.5).abs() < 0.01, "{north_m}");
    assert!((survey.side_scan[19].time_s - 1.9).abs() < 1e-6);
}

#[test]
fn a_recording_from_before_2000_has_its_date() {
    let mut bytes = handmade::xtf(20, 1, 3, (-73.6, 42.7), 0.0);
    let step = (bytes.len() - 1024) / 20;
    // In full, and as recorders with two digits wrote it.
    for year in [1997_u16, 97] {
        for ping in 0..20 {
            let at = 1024 + ping * step + 14;
            bytes[at..at + 2].copy_from_slice(&year.to_le_bytes());
        }
        let survey = read(bytes.clone());
        // `date -u -d "1997-06-01 12:00:00" +%s`
        assert_eq!(survey.start_unix_s, Some(865_166_400.0));
        assert_eq!(survey.side_scan.len(), 20);
    }
}

#[test]
fn bathymetry_without_side_scan_is_no_damage() {
    let bytes = handmade::xtf_bathymetry(40);
    let error = formats::open_bytes("lines.xtf", bytes, &Progress::new()).unwrap_err();
    assert!(matches!(error, OpenError::Unsupported { .. }), "{error}");
    let text = error.to_string();
    for words in [
        "40 bathymetry (type 2) and 20 attitude (type 3) packets",
        "no side-scan in it",
        "open the file that the side-scan was recorded into",
        "lines.xtf",
    ] {
        assert!(text.contains(words), "{text}");
    }
    assert!(!text.contains("damaged"), "{text}");
}
