//! Tests that the tail of a growing log gives the same survey as the whole file, wherever the file
//! was split.

use crate::support::real_data;
use bathyscope_log::formats::{open_growing, open_tail};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, Survey, SurveyVersions};
use bathyscope_test_support::handmade::{Frame, humminbird, sl2, sl3, survey_frames, xtf};
use std::path::PathBuf;
use std::sync::Arc;

type Files = Vec<(PathBuf, Vec<u8>)>;

fn held(files: &Files) -> Vec<(PathBuf, Bytes)> {
    let hold =
        |(path, bytes): &(PathBuf, Vec<u8>)| (path.clone(), Bytes::Held(Arc::new(bytes.clone())));
    files.iter().map(hold).collect()
}

/// The first share of every file; a description is written at once.
fn cut(files: &Files, share: f64) -> Files {
    let cut = |(path, bytes): &(PathBuf, Vec<u8>)| {
        let end = if path.extension().is_some_and(|ending| ending == "DAT") {
            bytes.len()
        } else {
            (bytes.len() as f64 * share) as usize
        };
        (path.clone(), bytes[..end].to_vec())
    };
    files.iter().map(cut).collect()
}

fn whole(files: &Files) -> Option<Survey> {
    open_growing(held(files), &Progress::new()).ok()
}

/// The log with what was added to it; read anew where the tail does not tell, and whether it was.
fn grown(known: &Survey, files: &Files) -> (Survey, bool) {
    let tail = known.seam().and_then(|seam| {
        let tail = open_tail(known, &seam, held(files), &Progress::new()).expect("a tail");
        known.extended(tail, &seam, &mut SurveyVersions::default())
    });
    match tail {
        Some(survey) => (survey, false),
        None => (whole(files).expect("a log"), true),
    }
}

fn assert_same(grown: &Survey, whole: &Survey, what: &str) {
    assert_eq!(grown.side_scan.len(), whole.side_scan.len(), "pings, {what}");
    for (a, b) in grown.side_scan.iter().zip(whole.side_scan.iter()) {
        let depths = [a, b].map(|ping| ping.depth_m.to_bits());
        assert_eq!(depths[0], depths[1], "depth of a ping, {what}");
        assert_eq!(
            (a.time_s, a.depth_fault, a.port, a.starboard),
            (b.time_s, b.depth_fault, b.port, b.starboard),
            "{what}"
        );
    }
    assert_eq!(grown.soundings.len(), whole.soundings.len(), "soundings, {what}");
    assert_eq!(grown.soundings, whole.soundings, "soundings, {what}");
    assert_eq!(grown.swath, whole.swath, "swath, {what}");
    assert_eq!(grown.channels, whole.channels, "channels, {what}");
    assert_eq!(grown.source, whole.source, "{what}");
    assert_eq!(grown.start_unix_s, whole.start_unix_s, "{what}");
    assert_eq!(grown.side_scan_state, whole.side_scan_state, "{what}");
    assert_eq!(grown.sounding_channel, whole.sounding_channel, "{what}");
    assert_eq!(grown.range_source, whole.range_source, "{what}");
    let same_fix = |(a, b): (&bathyscope_log::survey::Fix, &bathyscope_log::survey::Fix)| {
        a.time_s == b.time_s
            && a.position == b.position
            && a.cog_rad.to_bits() == b.cog_rad.to_bits()
    };
    assert_eq!(grown.track.fixes.len(), whole.track.fixes.len(), "fixes, {what}");
    assert!(grown.track.fixes.iter().zip(whole.track.fixes.iter()).all(same_fix), "fixes, {what}");
    assert_eq!(grown.track.frame.origin(), whole.track.frame.origin(), "{what}");
    assert_eq!(grown.echograms.len(), whole.echograms.len(), "{what}");
    for (a, b) in grown.echograms.iter().zip(&whole.echograms) {
        assert_eq!((a.kind, &a.pings), (b.kind, &b.pings), "{what}");
    }
    for ping in (0..whole.side_scan.len()).step_by(7) {
        let samples = |survey: &Survey| {
            let mut out = Vec::new();
            let samples = survey.samples(ping, bathyscope_log::survey::Side::Port);
            if let Some(samples) = samples {
                samples.copy_outward(&mut out);
            }
            out
        };
        assert_eq!(samples(grown), samples(whole), "samples of {ping}, {what}");
    }
}

/// Splits a log at many places, torn records among them, and lets it grow in one and in several
/// steps. Returns how often the tail was enough.
fn split_everywhere(files: &Files, places: usize, name: &str) -> [usize; 2] {
    let finished = whole(files).expect("a log");
    let mut counts = [0, 0];
    for place in 1..places {
        let share = place as f64 / places as f64;
        let Some(known) = whole(&cut(files, share)) else {
            continue;
        };
        let (survey, is_reopened) = grown(&known, files);
        counts[usize::from(is_reopened)] += 1;
        assert_same(&survey, &finished, &format!("{name} split at {share:.4}"));
        // In steps of a few records, each torn.
        let mut survey = known;
        let mut at = share;
        while at < 1.0 {
            at = (at + 0.037).min(1.0);
            survey = grown(&survey, &cut(files, at)).0;
        }
        assert_same(&survey, &finished, &format!("{name} from {share:.4} in steps"));
    }
    counts
}

fn single_file(name: &str, bytes: Vec<u8>) -> Files {
    vec![(PathBuf::from(name), bytes)]
}

/// Frames of all kinds: primary, down-scan, side-scan as both in one or as two, a bottom that is
/// lost for a while.
fn frames(pings: i32, halves: bool) -> Vec<Frame> {
    let each = (0..pings).flat_map(|ping| {
        let depth_ft = match ping {
            200..260 => [8.0, 20.0, 11.0, 25.0][(ping / 7 % 4) as usize],
            _ => 10.0 + 0.01 * ping as f32,
        };
        let frame =
            |channel, late_ms| Frame { depth_ft, ..Frame::new(channel, ping * 60 + late_ms) };
        let mut all = vec![frame(0, 0), frame(2, 4)];
        if !halves {
            all.push(frame(5, 9))
        } else {
            all.extend([frame(3, 9), frame(4, 11)])
        }
        all
    });
    each.collect()
}

#[test]
fn a_lowrance_log_grows_to_what_the_whole_file_is() {
    let composite = sl2(&frames(500, false));
    let counts = split_everywhere(&single_file("a.sl2", composite), 61, "sl2");
    assert!(counts[0] > 3 * counts[1], "{counts:?}");
    let halves = sl3(&frames(400, true), 168);
    split_everywhere(&single_file("b.sl3", halves), 37, "sl3");
    let with_swath = (0..400).flat_map(|ping| {
        let pairs = [[1.0 + 0.01 * ping as f32, 12.0]; 3];
        let swath = Frame::of_swath(60 * ping + 12, [&pairs, &pairs[..1], &[]]);
        [Frame::new(0, 60 * ping), swath]
    });
    let with_swath = sl3(&with_swath.collect::<Vec<_>>(), 168);
    let counts = split_everywhere(&single_file("d.sl3", with_swath), 37, "swath");
    assert!(counts[0] > 3 * counts[1], "{counts:?}");
    split_everywhere(&single_file("c.sl2", sl2(&survey_frames(300))), 23, "plain sl2");
}

#[test]
fn an_xtf_file_grows_to_what_the_whole_file_is() {
    let degrees = xtf(400, 1, 3, (-71.0, 42.0), 5.0);
    let counts = split_everywhere(&single_file("a.xtf", degrees), 43, "xtf");
    assert!(counts[0] > counts[1], "{counts:?}");
    // Metres of an unknown zone count from the first ping; 16-bit samples have a scale of their
    // own.
    let metres = xtf(400, 2, 0, (480_000.0, 4_600_000.0), 5.0);
    split_everywhere(&single_file("b.xtf", metres), 43, "xtf in metres");
}

#[test]
fn a_humminbird_recording_grows_to_what_the_whole_one_is() {
    let counts = split_everywhere(&humminbird(700, false, false), 43, "humminbird");
    assert!(counts[0] > counts[1], "{counts:?}");
}

#[test]
fn a_clock_that_is_set_back_goes_on_in_the_tail() {
    let mut all = frames(250, false);
    let mut after = frames(250, false);
    after.iter_mut().for_each(|frame| frame.time_ms += 500);
    all.iter_mut().for_each(|frame| frame.time_ms += 100_000);
    all.extend(after);
    let files = single_file("set back.sl2", sl2(&all));
    let finished = whole(&files).expect("a log");
    for share in [0.7, 0.83, 0.95] {
        let known = whole(&cut(&files, share)).expect("a log");
        let (survey, _) = grown(&known, &files);
        assert_eq!(survey.side_scan.len(), finished.side_scan.len());
        let pairs = survey.side_scan.iter().zip(finished.side_scan.iter());
        let worst_s = pairs.map(|(a, b)| (a.time_s - b.time_s).abs()).fold(0.0, f64::max);
        assert!(worst_s < 1e-6, "{worst_s} s at {share}");
    }
}

#[test]
fn what_another_log_adds_is_not_taken() {
    let known = whole(&single_file("a.sl2", sl2(&frames(300, false)))).expect("a log");
    let seam = known.seam().expect("a seam");
    // As long as it may be, the pings of the seam do not lie in it.
    let mut other = frames(400, false);
    other.iter_mut().for_each(|frame| frame.data = vec![9; 333]);
    let files = single_file("a.sl2", sl2(&other));
    let tail = open_tail(&known, &seam, held(&files), &Progress::new()).expect("a log");
    assert!(known.extended(tail, &seam, &mut SurveyVersions::default()).is_none());
}

#[test]
fn real_recordings_grow_to_what_the_whole_files_are() {
    let Some(data) = real_data() else {
        return;
    };
    let mut logs: Vec<PathBuf> = ["lowrance", "xtf"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(data.join(folder)).into_iter().flatten().flatten())
        .map(|entry| entry.path())
        .filter(|path| {
            path.metadata().is_ok_and(|found| (1_000_000..40_000_000).contains(&found.len()))
        })
        .collect();
    logs.sort();
    let mut looked_at = 0;
    for path in logs {
        let bytes = std::fs::read(&path).expect("a file");
        let files = vec![(path.clone(), bytes)];
        let Some(finished) = whole(&files) else {
            continue;
        };
        for share in [0.31, 0.5, 0.77, 0.93] {
            let Some(known) = whole(&cut(&files, share)) else {
                continue;
            };
            let (survey, is_reopened) = grown(&known, &files);
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            eprintln!(
                "{name} split at {share}: {} pings, read anew: {is_reopened}",
                survey.side_scan.len()
            );
            assert_eq!(survey.side_scan.len(), finished.side_scan.len(), "{name}");
            assert_same(&survey, &finished, &name);
        }
        looked_at += 1;
    }
    assert!(looked_at > 0);
}
