//! Functions that the tests of several readers use: they harm the bytes of a log, read a log while
//! it grows, and look at what was read.

use super::{open_bytes, open_growing, open_tail};
use crate::support::geo::LonLat;
use crate::support::progress::Progress;
use crate::survey::{Bytes, Side, Survey, SurveyVersions};
use bathyscope_test_support::Random;
use std::path::PathBuf;
use std::sync::Arc;

/// Returns true if a warning about a log contains these words.
pub(super) fn says(survey: &Survey, words: &str) -> bool {
    survey.warnings.iter().any(|warning| warning.text.contains(words))
}

/// Returns the levels of a side of a ping, the nearest first.
pub(super) fn outward(survey: &Survey, ping: usize, side: Side) -> Vec<u8> {
    let mut levels = Vec::new();
    survey.samples(ping, side).expect("samples").copy_outward(&mut levels);
    levels
}

/// Returns the time and the position of each fix.
pub(super) fn places(survey: &Survey) -> Vec<(f64, LonLat)> {
    survey.track.fixes.iter().map(|fix| (fix.time_s, fix.position)).collect()
}

/// Returns a log of one file in memory.
pub(super) fn held(name: &str, bytes: &[u8]) -> Vec<(PathBuf, Bytes)> {
    vec![(PathBuf::from(name), Bytes::Held(Arc::new(bytes.to_vec())))]
}

/// Reads a log as a whole, and as a part to which its rest is added, for several lengths of the
/// part. Passes to `check` the log as known from the part, as extended, and as read as a whole.
pub(super) fn check_growing(name: &str, bytes: &[u8], check: impl Fn(&Survey, &Survey, &Survey)) {
    let open = |bytes: &[u8]| open_growing(held(name, bytes), &Progress::new()).expect("a log");
    let whole = open(bytes);
    assert!(!says(&whole, "was cut"));
    for share in [0.6, 0.75, 0.9, 0.999] {
        let known = open(&bytes[..(bytes.len() as f64 * share) as usize]);
        assert!(!says(&known, "was cut"));
        let seam = known.seam().expect("a seam");
        assert!(seam.from[0] > 0, "{share}");
        let tail = open_tail(&known, &seam, held(name, bytes), &Progress::new()).expect("a tail");
        let grown = known.extended(tail, &seam, &mut SurveyVersions::default());
        let grown = grown.expect("a tail that continues");
        assert_eq!(grown.channels, whole.channels);
        assert_eq!(grown.start_unix_s, whole.start_unix_s);
        check(&known, &grown, &whole);
    }
}

/// Returns the bytes cut short, at every length.
pub(super) fn beginnings(bytes: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    (0..bytes.len()).map(move |length| bytes[..length].to_vec())
}

/// Returns the bytes with one to four of them replaced, `count` times.
pub(super) fn garbled(bytes: &[u8], seed: u64, count: usize) -> impl Iterator<Item = Vec<u8>> {
    let mut random = Random(seed);
    let harm = move || {
        let mut bytes = bytes.to_vec();
        for _ in 0..=random.below(4) {
            let at = random.below(bytes.len());
            bytes[at] = random.below(256) as u8;
        }
        bytes
    };
    std::iter::repeat_with(harm).take(count)
}

/// Returns the bytes with each of these numbers at every place in turn.
pub(super) fn claiming(bytes: &[u8], claims: [u32; 4]) -> impl Iterator<Item = Vec<u8>> {
    let places = 0..bytes.len().saturating_sub(4);
    places.flat_map(move |at| {
        claims.map(|claimed| {
            let mut bytes = bytes.to_vec();
            bytes[at..at + 4].copy_from_slice(&claimed.to_le_bytes());
            bytes
        })
    })
}

/// Asserts that bytes make no more pings than `most`, whose samples lie in the bytes, and no
/// impossible position.
pub(super) fn assert_bounded(name: &str, bytes: Vec<u8>, most: usize) {
    let length = bytes.len();
    let Ok(survey) = open_bytes(name, bytes, &Progress::new()) else {
        return;
    };
    assert!(survey.side_scan.len() <= most);
    for ping in 0..survey.side_scan.len() {
        for side in Side::BOTH {
            if let Some(samples) = survey.samples(ping, side) {
                assert!(samples.len() <= length);
                samples.copy_outward(&mut Vec::new());
            }
        }
    }
    assert!(survey.track.fixes.iter().all(|fix| fix.position.is_on_earth()));
}
