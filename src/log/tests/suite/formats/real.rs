//! The real recordings, to the counts, spans and places of their README; and small inputs that
//! instruments and programs wrote and that were read wrongly, to the values of the README beside
//! them.

use super::*;
use bathyscope_log::formats::TrackFile;
use bathyscope_log::survey::{HeadingSettings, Navigation, Projection, navigate};

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

fn case(file: &str) -> Option<Survey> {
    open(&format!("cases/{file}"))
}

fn navigated(survey: &Survey) -> Navigation {
    navigate(survey, &HeadingSettings::default(), Projection::Enu, &Progress::new())
        .expect("not cancelled")
}

/// Metres north of the first fix.
fn north_m(survey: &Survey) -> Vec<f64> {
    navigated(survey).soundings.iter().map(|place| place.north_m).collect()
}

fn assert_along(survey: &Survey, within_m: f64) {
    for (place_m, sounding) in north_m(survey).into_iter().zip(survey.soundings.iter()) {
        let expected_m = 2.0 * sounding.time_s;
        assert!((place_m - expected_m).abs() < within_m, "{sounding:?}: {place_m}");
    }
}

#[test]
fn depths_lie_at_the_places_of_their_own_rows() {
    let Some(survey) = case("rows_with_own_places_1s.csv") else { return };
    assert_eq!(survey.soundings.len(), 240);
    assert_along(&survey, 0.1);
}

#[test]
fn rows_of_a_slow_recorder_keep_their_places_in_a_turn() {
    for interval_s in [1.0, 2.0, 5.0] {
        // Half a minute straight, then a circle of 15 m, at 2 m/s.
        let place_m = |time_s: f64| {
            let turned_rad = 2.0 * (time_s - 30.0).max(0.0) / 15.0;
            let along_m = 2.0 * time_s.min(30.0) + 15.0 * turned_rad.sin();
            [15.0 * (1.0 - turned_rad.cos()), along_m]
        };
        let times_s: Vec<f64> = (0..60).map(|row| f64::from(row) * interval_s).collect();
        let row = |time_s: &f64| {
            let [east_m, north_m] = place_m(*time_s);
            let (lon, lat) = (8.5 + east_m / 75_340.0, 47.5 + north_m / 111_180.0);
            format!("{:.3},{lat:.9},{lon:.9},5.00\n", 1_757_592_000.0 + time_s)
        };
        let text: String = times_s.iter().map(row).collect();
        let survey = read(format!("time,lat,lon,depth_m\n{text}").into_bytes());
        let places = navigated(&survey).soundings;
        assert_eq!(places.len(), 60);
        for (place, fix) in places.iter().zip(survey.track.fixes.iter()) {
            let [east_m, north_m] = survey.track.frame.to_enu(fix.position);
            let off_m = (place.east_m - east_m).hypot(place.north_m - north_m);
            assert!(off_m < 0.1, "{interval_s} s, {}: {off_m}", fix.time_s);
        }
    }
}

#[test]
fn soundings_lie_where_the_other_receiver_was_at_their_times() {
    let Some(mut survey) = case("soundings_5hz_for_track.csv") else { return };
    let Some(data) = bathyscope_test_support::real_data() else { return };
    let track = TrackFile::read(&data.join("cases/track_rtk_1hz.csv")).expect("a track");
    track.apply(&mut survey, 0.0).expect("the same hour");
    assert_along(&survey, 0.1);
}

#[test]
fn the_bottom_is_lost_in_the_same_stretch_at_one_and_at_five_soundings_a_second() {
    let mut stretches = Vec::new();
    for file in ["bottom_lost_1hz.nmea", "bottom_lost_5hz.nmea"] {
        let Some(survey) = case(file) else { return };
        let lost = || {
            survey
                .soundings
                .iter()
                .filter(|sounding| !sounding.is_good())
                .map(|sounding| sounding.time_s)
        };
        stretches.push([lost().next().expect("lost"), lost().next_back().expect("lost")]);
        let counted = survey.soundings.iter().filter(|sounding| sounding.is_good());
        assert!(counted.clone().all(|sounding| (19.0..21.0).contains(&sounding.depth_m)), "{file}");
        assert!(counted.count() > survey.soundings.len() / 2);
    }
    let [slow, fast] = stretches[..] else { panic!("two files") };
    assert!((slow[0] - fast[0]).abs() < 6.0 && (slow[1] - fast[1]).abs() < 6.0, "{stretches:?}");
}

#[test]
fn a_position_off_the_line_is_left_out() {
    let Some(survey) = case("gps_spike_100m.nmea") else { return };
    assert_eq!(survey.track.fixes.len(), 118);
    assert!(says(&survey, "farther than the boat can go"), "{:?}", survey.warnings);
    let far_m = |place: &bathyscope_log::survey::PingNav| place.east_m.abs();
    assert!(navigated(&survey).soundings.iter().map(far_m).fold(0.0, f64::max) < 1.0);
}

#[test]
fn depths_without_a_fix_have_no_place() {
    let Some(survey) = case("fix_lost_at_the_end.nmea") else { return };
    let places = north_m(&survey);
    assert_eq!(places.len(), 300);
    assert!(places[..240].iter().all(|place_m| place_m.is_finite()));
    assert!(places[244..].iter().all(|place_m| place_m.is_nan()));
    assert!(says(&survey, "no fix was recorded around then"), "{:?}", survey.warnings);
}

#[test]
fn positions_of_sentences_that_take_turns_are_all_used() {
    let Some(survey) = case("positions_alternate_rmc_gll_gga.nmea") else { return };
    assert_eq!(survey.track.fixes.len(), 60);
    assert!(!says(&survey, "tell the same"), "{:?}", survey.warnings);
}

#[test]
fn depths_below_the_surface_are_read() {
    let Some(survey) = case("depths_dbs_only.nmea") else { return };
    assert_eq!(survey.soundings[1].depth_m, 3.02);
    assert!(says(&survey, "count from the water's surface"), "{:?}", survey.warnings);
}

#[test]
fn tables_of_other_programs_are_read() {
    let Some(survey) = case("deeper_bathymetry_as_exported.csv") else { return };
    assert_eq!(survey.source.recorder(), "CSV of soundings, Deeper");
    assert!(survey.start_unix_s.is_some() && !survey.soundings.is_empty());
    assert!(says(&survey, "rows have no position"), "{:?}", survey.warnings);
    for (file, first_m, words) in [
        ("depth_in_feet.csv", 3.048, "one second apart"),
        ("elevation_bottom.csv", 2.0, "negative in most rows"),
        ("lat_lon_depth_without_header.csv", 2.0, "no line names the columns"),
    ] {
        let Some(survey) = case(file) else { return };
        assert!((survey.soundings[0].depth_m - first_m).abs() < 1e-5, "{file}");
        assert!((survey.track.fixes[0].position.lat_deg - 47.0).abs() < 1e-9, "{file}");
        assert!(says(&survey, words), "{file}: {:?}", survey.warnings);
    }
    let Some(survey) = case("date_us_time.csv") else { return };
    assert!(!says(&survey, "month/day/year"), "the 26th tells the order: {:?}", survey.warnings);
    assert_eq!(survey.start_unix_s, Some(1_629_970_740.0));
    assert_eq!(survey.soundings[1].time_s, 3.0);
}

#[test]
fn the_heading_of_a_transducer_tells_its_side() {
    let Some(single) = case("omniscan_starboard_only_channel0.svlog") else { return };
    assert!(single.side_scan.iter().all(|ping| ping.port.is_none() && ping.starboard.is_some()));
    let Some(both) = case("omniscan_both_on_channel0.svlog") else { return };
    let sides = |side: Side| both.side_scan.iter().filter(|ping| ping.side(side).is_some()).count();
    assert_eq!((sides(Side::Port), sides(Side::Starboard)), (120, 120));
    assert!(says(&both, "the heading is believed"), "{:?}", both.warnings);
}

/// Without times a row is a second, and a fix that is repeated for 24 rows is no loss of positions:
/// the boat went on. Where rows are missing between far fixes, nobody knows where it was.
#[test]
fn fixes_that_rows_without_times_repeat_are_joined_unless_rows_are_missing() {
    let mut table = String::from("lat,lon,depth_m\n");
    let lat_deg = |along_m: f64| 47.5 + along_m / 111_180.0;
    let mut add = |along_m: f64, rows: usize| {
        let row = format!("{:.7},8.5,{:.2}\n", lat_deg(along_m), 10.0 + 0.01 * along_m);
        table += &row.repeat(rows);
    };
    // Half a metre a row: fixes each 4 rows, and now and then after 24.
    let mut along_m = 0.0;
    for index in 0..60 {
        let rows = if index % 10 == 9 { 24 } else { 4 };
        add(along_m, rows);
        along_m += 0.5 * rows as f64;
    }
    let before_gap = 60 * 4 + 6 * 20;
    add(along_m, 24);
    add(along_m + 300.0, 4);
    add(along_m + 302.0, 4);
    let survey = formats::open_bytes("soundings.csv", table.into_bytes(), &Progress::new());
    let survey = survey.expect("a table of soundings");
    let places = north_m(&survey);
    for (row, place_m) in places[..before_gap].iter().enumerate() {
        let expected_m = 0.5 * row as f64;
        assert!((place_m - expected_m).abs() < 1.0, "row {row}: {place_m} m");
    }
    let unknown = places.iter().filter(|place_m| place_m.is_nan()).count();
    // Of 24 rows those within a usual interval of a fix have a place.
    assert!((12..20).contains(&unknown), "{unknown} of {} rows", places.len());
    let between = |place_m: &&f64| (along_m + 5.0..along_m + 295.0).contains(*place_m);
    assert_eq!(places.iter().filter(between).count(), 0);
}
