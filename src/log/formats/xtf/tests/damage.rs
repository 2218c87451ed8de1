//! Tests that growing, damaged and hostile XTF files are read.

use super::pairs::two_frequencies;
use super::places::raw_navigation;
use super::*;
use crate::formats::{open_growing, open_tail};
use crate::survey::{Bytes, SurveyVersions};
use bathyscope_test_support::Random;
use std::path::PathBuf;
use std::sync::Arc;

fn held(bytes: &[u8]) -> Vec<(PathBuf, Bytes)> {
    let bytes = Bytes::Held(Arc::new(bytes.to_vec()));
    vec![(PathBuf::from("pond.xtf"), bytes)]
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
        let whole = open_growing(held(&bytes), &Progress::new()).expect("a log");
        for share in [0.6, 0.75, 0.9, 0.999] {
            let cut = (bytes.len() as f64 * share) as usize;
            let known = open_growing(held(&bytes[..cut]), &Progress::new()).expect("a log");
            assert!(!says(&known, "was cut"));
            let seam = known.seam().expect("a seam");
            assert!(seam.from[0] > 0, "{share}");
            let tail = open_tail(&known, &seam, held(&bytes), &Progress::new()).expect("a tail");
            let grown = known.extended(tail, &seam, &mut SurveyVersions::default());
            let grown = grown.expect("a tail that continues");
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
            assert_eq!(spans(&grown), spans(&whole));
            let before = outward(&known, 0, Side::Port);
            assert_eq!(outward(&grown, 0, Side::Port), before);
            let encodings = |ping: usize| grown.side_scan[ping].port.map(|span| span.encoding);
            assert_eq!(encodings(0), encodings(396));
            assert_eq!(grown.channels, whole.channels);
            assert_eq!(grown.start_unix_s, whole.start_unix_s);
            let places = |survey: &Survey| -> Vec<_> {
                let fixes = survey.track.fixes.iter();
                fixes.map(|fix| (fix.time_s, fix.position)).collect()
            };
            assert_eq!(places(&grown), places(&whole));
        }
    }
}

#[test]
fn hostile_bytes_neither_end_the_program_nor_make_up_pings() {
    let looked_at = |bytes: Vec<u8>| {
        let length = bytes.len();
        let Ok(survey) = open(bytes) else {
            return;
        };
        assert!(survey.side_scan.len() <= 8);
        for ping in 0..survey.side_scan.len() {
            for side in Side::BOTH {
                let samples = survey.samples(ping, side);
                assert!(samples.is_none_or(|samples| samples.len() <= length));
                if samples.is_some() {
                    outward(&survey, ping, side);
                }
            }
        }
    };
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
        for length in 0..small.len() {
            looked_at(small[..length].to_vec());
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
            looked_at(bytes);
        }
        for at in (0..640).chain(1024..1024 + 330) {
            for claimed in [i32::MAX as u32, 1 << 31, u32::MAX, 0xFF_FFF0] {
                let mut bytes = small.clone();
                bytes[at..at + 4].copy_from_slice(&claimed.to_le_bytes());
                looked_at(bytes);
            }
        }
    }
}
