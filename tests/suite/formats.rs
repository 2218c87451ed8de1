//! Logs are read as they are: the real ones to the counts of their README, small handmade ones for every trap of the
//! formats.

use crate::handmade::{self, Frame};
use crate::support;
use bathyscope::formats::{self, OpenError};
use bathyscope::progress::Progress;
use bathyscope::survey::{ChannelKind, Order, Side, SideScanState, Survey};
use std::path::{Path, PathBuf};

fn open(file: &str) -> Option<Survey> {
    let path = support::real_data()?.join(file);
    Some(formats::open(&path, &Progress::new()).unwrap_or_else(|error| panic!("{error}")))
}

fn read(bytes: Vec<u8>) -> Survey {
    formats::open_bytes("pond.sl2", bytes, &Progress::new())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn counts(survey: &Survey) -> Vec<(ChannelKind, usize)> {
    survey
        .channels
        .iter()
        .map(|channel| (channel.kind, channel.ping_count))
        .collect()
}

fn says(survey: &Survey, words: &str) -> bool {
    survey
        .warnings
        .iter()
        .any(|warning| warning.text.contains(words))
}

fn depth_span_m(survey: &Survey) -> (f32, f32) {
    survey
        .soundings
        .iter()
        .fold((f32::MAX, f32::MIN), |(low, high), sounding| {
            (low.min(sounding.depth_m), high.max(sounding.depth_m))
        })
}

fn outward(survey: &Survey, ping: usize, side: Side) -> Vec<u8> {
    let mut samples = Vec::new();
    survey
        .samples(ping, side)
        .expect("samples")
        .copy_outward(&mut samples);
    samples
}

mod real {
    use super::*;

    #[test]
    fn river_survey() {
        let Some(survey) = open("humminbird-glen-canyon/Rec00001.DAT") else {
            return;
        };
        let kinds = [
            ChannelKind::Primary,
            ChannelKind::Secondary,
            ChannelKind::Port,
            ChannelKind::Starboard,
        ];
        assert_eq!(
            counts(&survey),
            kinds
                .into_iter()
                .zip([1727, 1726, 3453, 3453])
                .collect::<Vec<_>>()
        );
        assert_eq!(survey.side_scan.len(), 3453);
        assert!(
            survey
                .side_scan
                .iter()
                .all(|ping| ping.port.is_some() && ping.starboard.is_some())
        );
        assert_eq!(survey.side_scan_state, SideScanState::Usable);
        assert_eq!(survey.start_unix_s, Some(1_382_657_324.0));
        for channel in &survey.channels {
            assert_eq!(channel.sample_count, (1479, 1550));
        }
        let (low, high) = depth_span_m(&survey);
        assert_eq!((low, high), (1.0, 6.6));
        let last = survey.side_scan.last().map(|ping| ping.time_s);
        assert_eq!(last, Some(150.617));
        let start = survey.track.fixes[0].position;
        assert!((start.lat_deg - 36.877).abs() < 0.003 && (start.lon_deg + 111.516).abs() < 0.003);
    }

    #[test]
    fn river_survey_by_folder_and_by_one_son() {
        for name in [
            "humminbird-glen-canyon/Rec00001",
            "humminbird-glen-canyon",
            "humminbird-glen-canyon/Rec00001/B002.SON",
        ] {
            let Some(survey) = open(name) else { return };
            assert_eq!(survey.side_scan.len(), 3453, "{name}");
            assert_eq!(survey.start_unix_s, Some(1_382_657_324.0), "{name}");
            assert_eq!(survey.soundings.len(), 1727, "{name}");
        }
    }

    #[test]
    fn transcoded_river_is_the_river() {
        let Some(river) = open("humminbird-glen-canyon/Rec00001.DAT") else {
            return;
        };
        for file in [
            "lowrance/glencanyon-transcoded.sl2",
            "lowrance/glencanyon-transcoded.sl3",
        ] {
            let Some(survey) = open(file) else { return };
            let kinds = [
                ChannelKind::Primary,
                ChannelKind::DownScan,
                ChannelKind::Composite,
            ];
            assert_eq!(
                counts(&survey),
                kinds
                    .into_iter()
                    .zip([1727, 1726, 3453])
                    .collect::<Vec<_>>()
            );
            assert_eq!(survey.start_unix_s, river.start_unix_s);
            for (ping, original) in survey.side_scan.iter().zip(&river.side_scan) {
                assert_eq!(ping.time_s, original.time_s);
                assert!((ping.depth_m - original.depth_m).abs() < 0.001);
                for side in Side::BOTH {
                    let (ours, theirs) = (ping.side(side).unwrap(), original.side(side).unwrap());
                    assert!((ours.far_m - theirs.far_m).abs() < 0.002);
                }
            }
            for side in Side::BOTH {
                assert!(
                    correlation(&survey, &river, 1000, side) > 0.9,
                    "{file} {}",
                    side.name()
                );
            }
        }
    }

    /// Correlation of one side of a ping, resampled, so that sides swapped or reversed are noticed.
    fn correlation(a: &Survey, b: &Survey, ping: usize, side: Side) -> f64 {
        let (a, b) = (outward(a, ping, side), outward(b, ping, side));
        let at = |samples: &[u8], index: usize| f64::from(samples[index * samples.len() / 1000]);
        let pairs: Vec<(f64, f64)> = (0..1000)
            .map(|index| (at(&a, index), at(&b, index)))
            .collect();
        let mean = |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(pick).sum::<f64>() / 1000.0;
        let (ma, mb) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let sum = |term: &dyn Fn(f64, f64) -> f64| {
            pairs
                .iter()
                .map(|&(x, y)| term(x - ma, y - mb))
                .sum::<f64>()
        };
        sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
    }

    #[test]
    fn down_scan_only() {
        let Some(survey) = open("lowrance/river-downscan-only.sl2") else {
            return;
        };
        let kinds = [
            ChannelKind::Primary,
            ChannelKind::Secondary,
            ChannelKind::DownScan,
        ];
        assert_eq!(
            counts(&survey),
            kinds.into_iter().zip([325, 330, 653]).collect::<Vec<_>>()
        );
        assert_eq!(survey.side_scan_state, SideScanState::Absent);
        assert!(says(&survey, "no side-scan"));
        // No Unix time in it: the first frame's clock is the unit's millisecond counter.
        assert_eq!(survey.start_unix_s, None);
        let keel_m = 0.1;
        let (low, high) = depth_span_m(&survey);
        assert!((low + keel_m - 0.71).abs() < 0.005 && (high + keel_m - 1.41).abs() < 0.005);
        let span = survey.channels[2].time_span_s.unwrap();
        assert!((span.1 - span.0 - 87.0).abs() < 0.5);
        let start = survey.track.fixes[0].position;
        assert!((start.lat_deg - 53.235).abs() < 0.001 && (start.lon_deg - 39.959).abs() < 0.001);
        let repeats = survey
            .track
            .fixes
            .windows(2)
            .filter(|pair| pair[0].position == pair[1].position)
            .count();
        assert!(repeats * 100 / survey.track.fixes.len() >= 85, "{repeats}");
    }

    #[test]
    fn stray_bytes_and_noise() {
        let Some(survey) = open("lowrance/elite4-stray-bytes.sl2") else {
            return;
        };
        let kinds = [
            ChannelKind::Primary,
            ChannelKind::DownScan,
            ChannelKind::Composite,
        ];
        assert_eq!(
            counts(&survey),
            kinds.into_iter().zip([1, 3, 3]).collect::<Vec<_>>()
        );
        assert!(
            survey
                .warnings
                .iter()
                .any(|warning| warning.place == Some((0, 16_688))
                    && warning.text.contains("2 bytes"))
        );
        assert!(
            matches!(survey.side_scan_state, SideScanState::Noise { range_m } if (range_m - 1.524).abs() < 1e-3)
        );
        assert!(says(&survey, "noise"));
        assert_eq!(survey.start_unix_s, None);
    }

    #[test]
    fn southern_sl3_with_short_headers_and_negative_time() {
        for (file, pings, first_s) in [
            ("lowrance/hobart-20m.sl3", 223, 0.328),
            ("lowrance/hobart-40m-negative-time.sl3", 113, -0.454),
        ] {
            let Some(survey) = open(file) else { return };
            let kinds = [
                ChannelKind::Primary,
                ChannelKind::DownScan,
                ChannelKind::Composite,
                ChannelKind::Other(7),
                ChannelKind::Other(8),
            ];
            assert_eq!(counts(&survey), kinds.map(|kind| (kind, pings)));
            assert_eq!(survey.channels[0].time_span_s.unwrap().0, first_s);
            assert_eq!(survey.channels[3].sample_count, (2000, 2000));
            assert_eq!(survey.channels[4].sample_count, (512, 512));
            assert!(matches!(
                survey.side_scan_state,
                SideScanState::Noise { .. }
            ));
            // Depth is 0 in the side-scan frames: it comes from the primary channel.
            assert!(
                survey
                    .side_scan
                    .iter()
                    .all(|ping| (10.7..11.2).contains(&ping.depth_m))
            );
            assert!((survey.track.fixes[0].position.lat_deg + 42.886).abs() < 0.001);
            assert!(
                survey
                    .track
                    .fixes
                    .iter()
                    .all(|fix| fix.compass_rad.is_nan())
            );
            assert!(
                survey
                    .start_unix_s
                    .is_some_and(|unix_s| (1.72e9..1.73e9).contains(&unix_s))
            );
        }
    }

    #[test]
    fn xtf() {
        let Some(survey) = open("xtf/000_1236.xtf") else {
            return;
        };
        assert_eq!(
            counts(&survey),
            [(ChannelKind::Port, 1446), (ChannelKind::Starboard, 1446)]
        );
        assert_eq!(survey.side_scan.len(), 1446);
        assert_eq!(survey.side_scan_state, SideScanState::Usable);
        assert_eq!(survey.channels[0].sample_count, (512, 512));
        // `date -u -d "2009-11-08 12:36:34"` and the ping's 33 hundredths.
        assert_eq!(survey.start_unix_s, Some(1_257_683_794.33));
        assert!((survey.side_scan.last().unwrap().time_s - 244.3).abs() < 0.01);
        assert!(survey.soundings.is_empty() && says(&survey, "no depth"));
        let start = survey.track.fixes[0].position;
        assert!(
            (start.lat_deg - 42.732_586).abs() < 1e-5 && (start.lon_deg + 73.694_206).abs() < 1e-5
        );
        let span = survey.side_scan[0].port.unwrap();
        assert_eq!((span.order, span.count), (Order::FarToNear, 512));
        assert!((span.far_m - 36.7425).abs() < 0.001);
    }
}

mod lowrance {
    use super::*;

    #[test]
    fn composite_frames_are_cut_in_the_middle() {
        let survey = read(handmade::sl2(&handmade::survey_frames(20)));
        assert_eq!(survey.side_scan.len(), 20);
        let data = Frame::new(5, 0).data;
        let port: Vec<u8> = data[..200].iter().rev().copied().collect();
        assert_eq!(outward(&survey, 3, Side::Port), port);
        assert_eq!(outward(&survey, 3, Side::Starboard), data[200..]);
        let span = survey.side_scan[3].port.unwrap();
        assert!((span.far_m - 60.0 * 0.3048).abs() < 1e-5 && span.near_m == 0.0);
    }

    #[test]
    fn sl3_data_begins_where_frame_size_less_packet_says() {
        for header in [168, 180] {
            let mut frames = handmade::survey_frames(10);
            frames.insert(4, Frame::new(8, 90));
            let survey = read(handmade::sl3(&frames, header));
            assert_eq!(survey.side_scan.len(), 10);
            assert_eq!(
                outward(&survey, 9, Side::Starboard),
                Frame::new(5, 0).data[200..]
            );
            assert_eq!(counts(&survey)[2], (ChannelKind::Other(8), 1));
        }
    }

    #[test]
    fn separate_sides_are_joined_by_time_not_by_number() {
        // Starboard began two pings later: frame numbers differ, times do not.
        let mut frames: Vec<Frame> = (0..50)
            .flat_map(|ping| {
                let port = Frame::new(3, ping * 50);
                let starboard = (ping >= 2).then(|| Frame::new(4, ping * 50 + 4));
                [Some(port), starboard].into_iter().flatten()
            })
            .collect();
        frames.remove(40);
        let survey = read(handmade::sl2(&frames));
        assert_eq!(survey.side_scan.len(), 50);
        let both = survey
            .side_scan
            .iter()
            .filter(|ping| ping.port.is_some() && ping.starboard.is_some())
            .count();
        assert_eq!(both, 47);
        assert_eq!(outward(&survey, 10, Side::Port), Frame::new(3, 0).data);
    }

    #[test]
    fn one_side_alone_is_a_survey_too() {
        let frames: Vec<Frame> = (0..9).map(|ping| Frame::new(4, ping * 50)).collect();
        let survey = read(handmade::sl2(&frames));
        assert_eq!(survey.side_scan.len(), 9);
        assert_eq!(survey.side_scan_state, SideScanState::Usable);
        assert!(
            survey
                .side_scan
                .iter()
                .all(|ping| ping.port.is_none() && ping.starboard.is_some())
        );
    }

    #[test]
    fn range_is_a_matter_of_each_ping() {
        let mut frames = handmade::survey_frames(4);
        frames[7].range_ft = (-100.0, 100.0);
        let survey = read(handmade::sl2(&frames));
        let far_m: Vec<f32> = survey
            .side_scan
            .iter()
            .map(|ping| ping.starboard.unwrap().far_m)
            .collect();
        assert!((far_m[2] - 18.288).abs() < 1e-4 && (far_m[3] - 30.48).abs() < 1e-4);
        assert_eq!(survey.channels[1].range_m, Some((0.0, 30.48)));
    }

    #[test]
    fn depth_comes_from_the_nearest_sounding_less_the_keel_offset() {
        let mut frames = handmade::survey_frames(100);
        for (index, frame) in frames.iter_mut().enumerate() {
            let is_primary = frame.channel == 0;
            frame.depth_ft = if is_primary { 10.0 + index as f32 } else { 0.0 };
            frame.keel_ft = 2.0;
        }
        let survey = read(handmade::sl2(&frames));
        assert_eq!(survey.soundings.len(), 100);
        let depth_m = survey.side_scan[30].depth_m;
        assert!(
            (depth_m - (10.0 + 60.0 - 2.0) * 0.3048).abs() < 1e-4,
            "{depth_m}"
        );
        assert!(says(&survey, "keel offset"));
    }

    #[test]
    fn unix_time_only_where_it_is_one() {
        for (clock, expected) in [
            (1_600_000_000, Some(1.6e9)),
            (u32::MAX, None),
            (1_317_703, None),
        ] {
            let mut frames = handmade::survey_frames(5);
            frames[0].clock = clock;
            assert_eq!(read(handmade::sl2(&frames)).start_unix_s, expected);
        }
    }

    #[test]
    fn a_lost_byte_costs_one_frame() {
        let mut bytes = handmade::sl2(&handmade::survey_frames(60));
        bytes.remove(8 + 544 * 51 + 300);
        let survey = read(bytes);
        assert_eq!(survey.side_scan.len(), 60 - 1);
        assert!(says(&survey, "the next begins after 543"));
    }

    #[test]
    fn a_frame_size_of_zero_costs_one_frame() {
        let mut bytes = handmade::sl2(&handmade::survey_frames(60));
        let frame = 8 + 544 * 51;
        bytes[frame + 28..frame + 30].fill(0);
        let survey = read(bytes);
        assert_eq!(survey.side_scan.len(), 60 - 1);
        assert!(
            survey
                .warnings
                .iter()
                .any(|warning| warning.place == Some((0, frame as u64)))
        );
    }

    #[test]
    fn many_gaps_become_few_warnings() {
        let mut bytes = handmade::sl2(&handmade::survey_frames(500));
        for frame in (0..500).map(|index| 8 + 1088 * index) {
            bytes[frame] ^= 0xFF;
        }
        let survey = read(bytes);
        assert_eq!(survey.side_scan.len(), 500);
        assert!(survey.warnings.len() < 40 && says(&survey, "480 more gaps"));
    }

    #[test]
    fn noise_is_named_even_with_a_good_header() {
        let mut frames = handmade::survey_frames(30);
        frames
            .iter_mut()
            .filter(|frame| frame.channel == 5)
            .for_each(|frame| frame.range_ft = (-5.0, 5.0));
        let survey = read(handmade::sl2(&frames));
        assert!(matches!(
            survey.side_scan_state,
            SideScanState::Noise { .. }
        ));
        assert!(!survey.has_side_scan());
    }

    #[test]
    fn a_fix_thrown_far_away_is_dropped() {
        let mut frames = handmade::survey_frames(30);
        frames[1].xy_m = (-9_000_000, 17);
        let survey = read(handmade::sl2(&frames));
        assert!(
            survey
                .track
                .fixes
                .iter()
                .all(|fix| fix.position.lat_deg > 20.0)
        );
        assert!(says(&survey, "kilometres"));
    }
}

mod humminbird {
    use super::*;

    fn read(files: Vec<(PathBuf, Vec<u8>)>) -> Survey {
        formats::open_files(files, &Progress::new()).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn every_family_and_byte_order() {
        for (solix, little, format) in [
            (false, false, "Humminbird"),
            (true, false, "Humminbird Solix"),
            (true, true, "Humminbird Solix"),
        ] {
            let survey = read(handmade::humminbird(40, solix, little));
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
        let survey = read(files.clone());
        assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, None));
        assert!(says(&survey, "DAT file is damaged"));
        files.remove(0);
        let survey = read(files);
        assert_eq!((survey.side_scan.len(), survey.start_unix_s), (40, None));
        assert!(says(&survey, "DAT file is missing"));
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
        let survey = read(files);
        assert_eq!(survey.side_scan.len(), 40);
        assert_eq!(
            survey
                .side_scan
                .iter()
                .filter(|ping| ping.port.is_none())
                .count(),
            1
        );
    }
}

mod xtf {
    use super::*;

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
        assert!(says(&survey, "unknown zone"));
        let [_, north_m] = survey.track.frame.to_enu(survey.track.fixes[19].position);
        assert!((north_m - 19.0 * 0.5).abs() < 0.01, "{north_m}");
        assert!((survey.side_scan[19].time_s - 1.9).abs() < 1e-6);
    }
}

mod refused {
    use super::*;

    fn refuse(bytes: &[u8]) -> OpenError {
        formats::open_bytes("log.sl2", bytes.to_vec(), &Progress::new()).unwrap_err()
    }

    #[test]
    fn not_a_log_broken_and_unsupported_are_different_sentences() {
        for text in [
            &b""[..],
            b"a",
            b"BND5 and some more",
            &[0; 5000],
            b"{\"type\": \"FeatureCollection\"}",
        ] {
            let error = refuse(text);
            assert!(matches!(error, OpenError::NotRecognised { .. }), "{error}");
        }
        let broken = refuse(&handmade::sl2(&handmade::survey_frames(1))[..100]);
        assert!(matches!(broken, OpenError::Broken { .. }), "{broken}");
        let slg = refuse(&[1, 0, 0, 0, 0xB2, 7, 0, 0, 1, 2, 3, 4]);
        assert!(matches!(slg, OpenError::Unsupported { .. }), "{slg}");
        assert!(slg.to_string().contains("record sl2 or sl3"), "{slg}");
        // A game's save file and a database carry the same suffixes.
        for known in [&b"BND4...."[..], b"SQLite format 3\0", b"PK\x03\x04"] {
            assert!(matches!(refuse(known), OpenError::Unsupported { .. }));
        }
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
        assert!(
            matches!(&error, OpenError::Io { .. }) && error.to_string().contains("no-such.sl2")
        );
    }

    #[test]
    fn cancel_is_heard() {
        let progress = Progress::new();
        progress.cancel();
        let bytes = handmade::sl2(&handmade::survey_frames(5));
        let error = formats::open_bytes("log.sl2", bytes, &progress).unwrap_err();
        assert!(matches!(error, OpenError::Cancelled(_)));
    }
}
