//! Small inputs that instruments and programs wrote and that were read wrongly: each gives the
//! right value of the README beside them.

use super::*;
use bathyscope_log::formats::TrackFile;
use bathyscope_log::survey::{HeadingSettings, Navigation, Projection, navigate};

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
