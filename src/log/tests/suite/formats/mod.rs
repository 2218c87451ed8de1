//! Logs are read as they are: the real ones to the counts of their README, small handmade ones for
//! every trap of the formats.

mod cases;
mod humminbird;
mod lowrance;
mod real;
mod xtf;

use bathyscope_log::formats::{self, OpenError};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{ChannelKind, SampleOrder, Side, SideScanState, Survey, Warning};
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
