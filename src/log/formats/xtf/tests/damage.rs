//! Tests that growing, damaged and hostile XTF files are read.

use super::places::raw_navigation;
use super::samples::two_frequencies;
use super::*;
use crate::formats::test_logs::{assert_bounded, beginnings, check_growing, places};
use bathyscope_test_support::Random;

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
            assert_eq!(places(grown), places(whole));
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
