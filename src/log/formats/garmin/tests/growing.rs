//! Tests that reading the tail of a growing file gives the same survey as reading the whole file.

use super::{file, pings, with_second_pair};
use crate::formats::test_logs::{held, places};
use crate::formats::{open_growing, open_tail};
use crate::support::progress::Progress;
use crate::survey::{Encoding, Side, Survey, SurveyVersions};
use bathyscope_test_support::garmin::Ping;

/// Name of the log.
const LOG: &str = "log.rsd";

fn whole(bytes: &[u8]) -> Option<Survey> {
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
    let finished = whole(bytes).expect("a log");
    let mut by_tail = 0;
    for place in 1..places {
        let end = bytes.len() * place / places;
        let Some(known) = whole(&bytes[..end]) else {
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
    let known = whole(&bytes[..bytes.len() * 6 / 10]).expect("a log");
    let seam = known.seam().expect("a seam");
    let tail = open_tail(&known, &seam, held(LOG, &bytes), &Progress::new()).expect("a tail");
    let grown = known.extended(tail, &seam, &mut SurveyVersions::default()).expect("a log");
    let sides = grown.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]).flatten();
    let down =
        grown.echograms.iter().flat_map(|echogram| echogram.pings.iter().map(|ping| ping.span));
    let spans: Vec<_> = sides.chain(down).collect();
    assert_eq!(spans.len(), 4 * 300);
    assert!(spans.iter().all(|span| span.encoding == Encoding::U16 { shift: 0 }));
    let whole_log = whole(&bytes).expect("a log");
    assert_eq!(whole_log.echograms[0].pings[0].span.encoding, Encoding::U16 { shift: 4 });
}
