//! The real recordings, to the counts, spans and places of their README.

use super::*;

#[test]
fn river_survey() {
    let Some(survey) = open("humminbird-glen-canyon/Rec00001.DAT") else {
        return;
    };
    let kinds =
        [ChannelKind::Primary, ChannelKind::Secondary, ChannelKind::Port, ChannelKind::Starboard];
    assert_eq!(
        counts(&survey),
        kinds.into_iter().zip([1727, 1726, 3453, 3453]).collect::<Vec<_>>()
    );
    assert_eq!(survey.side_scan.len(), 3453);
    assert!(survey.side_scan.iter().all(|ping| ping.port.is_some() && ping.starboard.is_some()));
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
    for file in ["lowrance/glencanyon-transcoded.sl2", "lowrance/glencanyon-transcoded.sl3"] {
        let Some(survey) = open(file) else { return };
        let kinds = [ChannelKind::Primary, ChannelKind::DownScan, ChannelKind::Composite];
        assert_eq!(counts(&survey), kinds.into_iter().zip([1727, 1726, 3453]).collect::<Vec<_>>());
        assert_eq!(survey.start_unix_s, river.start_unix_s);
        for (ping, original) in survey.side_scan.iter().zip(river.side_scan.iter()) {
            assert_eq!(ping.time_s, original.time_s);
            assert!((ping.depth_m - original.depth_m).abs() < 0.001);
            for side in Side::BOTH {
                let (ours, theirs) = (ping.side(side).unwrap(), original.side(side).unwrap());
                assert!((ours.far_m - theirs.far_m).abs() < 0.002);
            }
        }
        for side in Side::BOTH {
            assert!(correlation(&survey, &river, 1000, side) > 0.9, "{file} {}", side.name());
        }
    }
}

/// Correlation of one side of a ping, resampled, so that sides swapped or reversed are noticed.
fn correlation(a: &Survey, b: &Survey, ping: usize, side: Side) -> f64 {
    let (a, b) = (outward(a, ping, side), outward(b, ping, side));
    let at = |samples: &[u8], index: usize| f64::from(samples[index * samples.len() / 1000]);
    let pairs: Vec<(f64, f64)> = (0..1000).map(|index| (at(&a, index), at(&b, index))).collect();
    let mean = |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(pick).sum::<f64>() / 1000.0;
    let (ma, mb) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let sum = |term: &dyn Fn(f64, f64) -> f64| {
        pairs.iter().map(|&(x, y)| term(x - ma, y - mb)).sum::<f64>()
    };
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

#[test]
fn down_scan_only() {
    let Some(survey) = open("lowrance/river-downscan-only.sl2") else {
        return;
    };
    let kinds = [ChannelKind::Primary, ChannelKind::Secondary, ChannelKind::DownScan];
    assert_eq!(counts(&survey), kinds.into_iter().zip([325, 330, 653]).collect::<Vec<_>>());
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
    let repeats =
        survey.track.fixes.windows(2).filter(|pair| pair[0].position == pair[1].position).count();
    assert!(repeats * 100 / survey.track.fixes.len() >= 85, "{repeats}");
}

#[test]
fn stray_bytes_and_noise() {
    let Some(survey) = open("lowrance/elite4-stray-bytes.sl2") else {
        return;
    };
    let kinds = [ChannelKind::Primary, ChannelKind::DownScan, ChannelKind::Composite];
    assert_eq!(counts(&survey), kinds.into_iter().zip([1, 3, 3]).collect::<Vec<_>>());
    // Two bytes are no frame that was lost: there is nothing to be done about them.
    assert!(survey.warnings.iter().all(|warning| warning.place.is_none()));
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
        assert!(matches!(survey.side_scan_state, SideScanState::Noise { .. }));
        // Depth is 0 in the side-scan frames: it comes from the primary channel.
        assert!(survey.side_scan.iter().all(|ping| (10.7..11.2).contains(&ping.depth_m)));
        assert!((survey.track.fixes[0].position.lat_deg + 42.886).abs() < 0.001);
        assert!(survey.track.fixes.iter().all(|fix| fix.compass_rad.is_nan()));
        assert!(survey.start_unix_s.is_some_and(|unix_s| (1.72e9..1.73e9).contains(&unix_s)));
    }
}

#[test]
fn xtf() {
    let Some(survey) = open("xtf/000_1236.xtf") else {
        return;
    };
    assert_eq!(counts(&survey), [(ChannelKind::Port, 1446), (ChannelKind::Starboard, 1446)]);
    assert_eq!(survey.side_scan.len(), 1446);
    assert_eq!(survey.side_scan_state, SideScanState::Usable);
    assert_eq!(survey.channels[0].sample_count, (512, 512));
    // `date -u -d "2009-11-08 12:36:34"` and the ping's 33 hundredths.
    assert_eq!(survey.start_unix_s, Some(1_257_683_794.33));
    assert!((survey.side_scan.last().unwrap().time_s - 244.3).abs() < 0.01);
    assert!(survey.soundings.is_empty() && says(&survey, "no depth"));
    let start = survey.track.fixes[0].position;
    assert!((start.lat_deg - 42.732_586).abs() < 1e-5 && (start.lon_deg + 73.694_206).abs() < 1e-5);
    let span = survey.side_scan[0].port.unwrap();
    assert_eq!((span.order, span.count), (SampleOrder::FarToNear, 512));
    assert!((span.far_m - 36.7425).abs() < 0.001);
}

/// Mean echo of the starboard side of a ping between two ranges.
fn mean_between(survey: &Survey, ping: usize, near_m: f64, far_m: f64) -> Option<f64> {
    let span = survey.span(ping, Side::Starboard)?;
    let samples = survey.samples(ping, Side::Starboard)?;
    let [from, to] = [near_m, far_m].map(|range_m| span.sample_at(range_m).max(0.0) as usize);
    let (from, to) = (from.min(samples.len()), to.min(samples.len()));
    let sum: f64 = (from..to).map(|sample| f64::from(samples.get(sample))).sum();
    (to > from + 4).then(|| sum / (to - from) as f64)
}

#[test]
fn what_looks_down_has_its_bottom_at_the_recorded_depth() {
    for name in [
        "humminbird-glen-canyon/Rec00001.DAT",
        "lowrance/glencanyon-transcoded.sl2",
        "lowrance/river-downscan-only.sl2",
    ] {
        let Some(survey) = open(name) else { continue };
        for echogram in &survey.echograms {
            let down = survey.looking_down(echogram.kind).expect("a channel");
            let counted = survey.channels.iter().find(|channel| channel.kind == echogram.kind);
            let counted = counted.expect("a counted channel").ping_count;
            assert!(echogram.pings.len() <= counted);
            let pings: Vec<usize> = (0..down.side_scan.len()).collect();
            let compared: Vec<bool> = pings
                .iter()
                .filter_map(|&ping| {
                    let depth_m = f64::from(down.good_depth_m(ping));
                    let above = mean_between(&down, ping, 0.55 * depth_m, 0.85 * depth_m)?;
                    let below = mean_between(&down, ping, depth_m, 1.15 * depth_m)?;
                    Some(below > 1.5 * above)
                })
                .collect();
            let share =
                compared.iter().filter(|is| **is).count() as f64 / compared.len().max(1) as f64;
            eprintln!(
                "{name} {:?}: {} of {counted} pings kept, bottom where it was recorded in {:.0} % of {}",
                echogram.kind,
                echogram.pings.len(),
                100.0 * share,
                compared.len()
            );
        }
    }
}
