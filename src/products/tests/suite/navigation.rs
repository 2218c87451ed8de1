//! Position and heading from coarse, repeated fixes.

use crate::truth::KnownSurvey;
use bathyscope_log::support::geo::{
    LocalFrame, LonLat, lowrance_mercator, lowrance_mercator_inverse,
};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    Fix, HeadingSettings, HeadingSource, Navigation, Projection, SidePing, SideScanState, Survey,
    Track, navigate,
};
use bathyscope_products::pipeline::{Preset, Settings};
use bathyscope_simulation::{Scene, TrackSettings};

const ORIGIN: LonLat = LonLat { lon_deg: -82.11, lat_deg: 29.41 };
const PING_RATE_HZ: f64 = 20.0;

/// A survey of `duration_s` seconds whose recorder takes a fix `fixes_hz` times a second, rounds it
/// to a Mercator metre and repeats it with every ping. `path` gives metres east and north at a
/// time; `None` is a lost fix: the last one is kept.
fn sailed(duration_s: f64, fixes_hz: f64, path: impl Fn(f64) -> Option<[f64; 2]>) -> Survey {
    let frame = LocalFrame::new(ORIGIN);
    let rounded = |[east_m, north_m]: [f64; 2]| {
        let [x, y] = lowrance_mercator(frame.to_lon_lat(east_m, north_m));
        lowrance_mercator_inverse(x.round(), y.round())
    };
    let mut position = rounded(path(0.0).expect("a first fix"));
    let (mut fixes, mut side_scan, mut last_tick) = (Vec::new(), Vec::new(), -1.0);
    for ping in 0..(duration_s * PING_RATE_HZ) as usize {
        let time_s = ping as f64 / PING_RATE_HZ;
        let tick = (time_s * fixes_hz + 1e-9).floor();
        if tick > last_tick {
            last_tick = tick;
            position = path(tick / fixes_hz).map_or(position, rounded);
        }
        fixes.push(Fix { time_s, position, cog_rad: 1.0, compass_rad: 2.0, speed_mps: f32::NAN });
        side_scan.push(SidePing::with_depth(time_s, 3.0));
    }
    Survey {
        side_scan_state: SideScanState::Usable,
        track: Track::new(fixes),
        ..Survey::of_pings(side_scan)
    }
}

fn navigated(survey: &Survey, source: HeadingSource) -> Navigation {
    let settings = HeadingSettings { source, ..HeadingSettings::default() };
    navigate(survey, &settings, Projection::Enu, &Progress::new()).expect("not cancelled")
}

/// A straight run at 2.68 m/s to the east-north-east.
fn straight(time_s: f64) -> Option<[f64; 2]> {
    Some([2.4 * time_s, 1.2 * time_s])
}

/// The difference of two angles, degrees.
fn off_deg(a: f64, b: f64) -> f64 {
    let difference = (a - b).to_degrees();
    (difference + 540.0).rem_euclid(360.0) - 180.0
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn a_fitted_track_is_good_to_a_degree_and_a_third_of_a_metre() {
    for fixes_hz in [10.0, 5.0, 1.0] {
        let survey = sailed(60.0, fixes_hz, straight);
        let navigation = navigated(&survey, HeadingSource::TrackFit);
        assert_eq!((navigation.zero_heading, navigation.moving), (0, 1200));
        // The survey's origin is the first, rounded fix.
        let (mut off_m, mut turned_deg) = (Vec::new(), Vec::new());
        let [x0, y0] = LocalFrame::new(ORIGIN).to_enu(survey.track.frame.origin());
        for (index, place) in navigation.pings.iter().enumerate().skip(60).take(1080) {
            let time_s = index as f64 / PING_RATE_HZ;
            let [east_m, north_m] = straight(time_s).expect("a place");
            off_m.push((place.east_m + x0 - east_m).hypot(place.north_m + y0 - north_m));
            turned_deg.push(off_deg(place.heading_rad, f64::atan2(2.4, 1.2)));
            assert!((place.speed_mps - 2.683).abs() < 0.3);
        }
        let (off_m, turned_deg) = (rms(&off_m), rms(&turned_deg));
        assert!(off_m < 0.2 && turned_deg < 1.6, "{fixes_hz} Hz: {off_m} m, {turned_deg} degrees");
    }
}

/// Root mean square error of the places along east and along north, metres, of straight runs that
/// begin at ten shares of a metre, and the largest standard deviation that is stated for them.
fn rounding_errors_m(velocity: [f64; 2], source: HeadingSource) -> ([f64; 2], f64) {
    let (mut errors_m, mut stated_m) = ([Vec::new(), Vec::new()], 0_f64);
    for start in 0..10 {
        let path = |time_s: f64| {
            let [east, north] = velocity.map(|mps| 0.1 * f64::from(start) + mps * time_s);
            Some([east, north])
        };
        let survey = sailed(60.0, 5.0, path);
        let navigation = navigated(&survey, source);
        stated_m = stated_m.max(navigation.rounding_m);
        let [x0, y0] = LocalFrame::new(ORIGIN).to_enu(survey.track.frame.origin());
        for (index, place) in navigation.pings.iter().enumerate().skip(100).take(1000) {
            let true_m = path(index as f64 / PING_RATE_HZ).expect("a place");
            errors_m[0].push(place.east_m + x0 - true_m[0]);
            errors_m[1].push(place.north_m + y0 - true_m[1]);
        }
    }
    (errors_m.map(|errors_m| rms(&errors_m)), stated_m)
}

#[test]
fn the_rounding_that_a_fit_leaves_is_stated() {
    // Along the lines that positions are rounded to, all are off by the same.
    let ([east_m, north_m], stated_m) = rounding_errors_m([0.0, 2.0], HeadingSource::TrackFit);
    assert!((0.8..1.4).contains(&(stated_m / east_m)), "{stated_m} for {east_m}");
    assert!(north_m < 0.5 * east_m, "{north_m}");
    // Across them the fit averages many.
    let (errors_m, across_m) = rounding_errors_m([1.4, 1.9], HeadingSource::TrackFit);
    let larger_m = errors_m[0].max(errors_m[1]);
    assert!((0.8..2.5).contains(&(across_m / larger_m)), "{across_m} for {larger_m}");
    assert!(across_m < 0.5 * stated_m);
    let (_, kept_m) = rounding_errors_m([1.4, 1.9], HeadingSource::Steps);
    assert!(kept_m > 2.0 * across_m, "positions as recorded are rounded in full: {kept_m}");
}

#[test]
fn consecutive_steps_give_few_headings_and_those_to_eight_directions() {
    let survey = sailed(60.0, 10.0, straight);
    let navigation = navigated(&survey, HeadingSource::Steps);
    let headings: Vec<f64> =
        navigation.pings.iter().map(|ping| ping.heading_rad).filter(|h| h.is_finite()).collect();
    assert_eq!(navigation.zero_heading + headings.len(), 1200);
    let share = headings.len() as f64 / 1200.0;
    assert!((0.08..0.25).contains(&share), "{share}");
    for heading in headings {
        let eighth = (heading.to_degrees() / 45.0).round() * 45.0;
        assert!((heading.to_degrees() - eighth).abs() < 0.5, "{}", heading.to_degrees());
    }
}

#[test]
fn a_boat_at_rest_has_no_heading_unless_it_has_a_compass() {
    // Half a metre of wander makes the rounded position toggle.
    let survey = sailed(120.0, 10.0, |time_s| {
        Some([0.5 * (time_s / 9.0).sin(), 0.5 * (time_s / 7.0).cos()])
    });
    for source in [HeadingSource::TrackFit, HeadingSource::Cog] {
        let navigation = navigated(&survey, source);
        // A rounded position that crosses the corner of four cells may look like a short move.
        assert!(navigation.moving <= 24, "{source:?}: {}", navigation.moving);
        assert_eq!(navigation.zero_heading, 2400 - navigation.moving, "{source:?}");
        assert!(
            navigation.pings.iter().all(|ping| ping.east_m.abs() < 1.5 && ping.north_m.abs() < 1.5)
        );
    }
    let compass = navigated(&survey, HeadingSource::Compass);
    assert_eq!(compass.zero_heading, 0);
    assert!((compass.pings[7].heading_rad - 2.0).abs() < 1e-6);
}

#[test]
fn recorded_headings_fit_the_plane_of_a_log_that_lies_far_away() {
    // A boat that goes north-east at 61 degrees north, 20 km east of the frame's origin, and says
    // so.
    let origin = LonLat { lon_deg: 20.0, lat_deg: 61.0 };
    let shared = LocalFrame::new(origin);
    let own = LocalFrame::new(shared.to_lon_lat(20_000.0, 0.0));
    let course_rad = f64::to_radians(45.0);
    let fixes = (0..600).map(|index| {
        let time_s = f64::from(index) / 10.0;
        let along_m = 2.0 * time_s;
        Fix {
            time_s,
            position: own.to_lon_lat(along_m * course_rad.sin(), along_m * course_rad.cos()),
            cog_rad: course_rad as f32,
            compass_rad: course_rad as f32,
            speed_mps: 2.0,
        }
    });
    let mut survey = sailed(60.0, 10.0, straight);
    survey.track = Track::new(fixes.collect());
    let survey = survey.in_frame(&shared);
    let fitted = navigated(&survey, HeadingSource::TrackFit).pings[600];
    // The meridians run together: 0.32 degrees in 20 km here.
    assert!((off_deg(fitted.heading_rad, course_rad).abs() - 0.32).abs() < 0.02);
    for source in [HeadingSource::Cog, HeadingSource::Compass] {
        let recorded = navigated(&survey, source).pings[600];
        let off = off_deg(recorded.heading_rad, fitted.heading_rad);
        assert!(off.abs() < 0.01, "{source:?}: {off}");
    }
}

#[test]
fn nothing_is_known_across_fixes_that_were_lost_for_long() {
    let lost = |time_s: f64| (20.0..40.0).contains(&time_s);
    let survey = sailed(60.0, 10.0, |time_s| if lost(time_s) { None } else { straight(time_s) });
    let navigation = navigated(&survey, HeadingSource::TrackFit);
    for (index, ping) in navigation.pings.iter().enumerate() {
        let time_s = index as f64 / PING_RATE_HZ;
        if (23.0..37.0).contains(&time_s) {
            assert!(ping.heading_rad.is_nan() && ping.east_m.is_nan(), "{time_s}");
        } else if !(17.0..43.0).contains(&time_s) {
            assert!(off_deg(ping.heading_rad, f64::atan2(2.4, 1.2)).abs() < 6.0, "{time_s}");
            assert!(ping.east_m.is_finite());
        }
    }
    let none =
        navigated(&Survey { track: Track::new(Vec::new()), ..survey }, HeadingSource::TrackFit);
    assert_eq!(none.zero_heading, 1200);
    assert!(none.pings[0].east_m.is_nan());
}

#[test]
fn the_published_plane_is_stretched() {
    let survey = sailed(60.0, 10.0, straight);
    let settings = HeadingSettings::default();
    let plane = |projection| {
        navigate(&survey, &settings, projection, &Progress::new()).expect("not cancelled")
    };
    let (enu, mercator) = (plane(Projection::Enu), plane(Projection::Mercator));
    for (ground, map) in enu.pings.iter().zip(mercator.pings.iter()).skip(600) {
        // kE and kN of EPSG:3857 at Citra.
        assert!((map.east_m / ground.east_m - 1.147010).abs() < 1e-4);
        assert!((map.north_m / ground.north_m - 1.152876).abs() < 1e-4);
        let [a, b] = [(&enu, ground), (&mercator, map)].map(|(navigation, place)| {
            navigation.to_lon_lat(&survey.track, place.east_m, place.north_m)
        });
        assert!((a.lon_deg - b.lon_deg).abs() < 1e-11 && (a.lat_deg - b.lat_deg).abs() < 1e-11);
    }
}

#[test]
fn moving_pings_of_simulated_surveys_have_a_heading() {
    let scene =
        Scene { track: TrackSettings { lines: 3, ..TrackSettings::default() }, ..Scene::gentle() };
    let pond = KnownSurvey::new(&scene, 5);
    let fitted = navigated(&pond.survey, HeadingSource::TrackFit);
    let share = 1.0 - fitted.zero_heading as f64 / fitted.moving as f64;
    assert!(fitted.moving > 1000 && share >= 0.99, "{share}");
    let settings = Settings::preset(Preset::Published).heading;
    let steps = navigate(&pond.survey, &settings, Projection::Mercator, &Progress::new())
        .expect("not cancelled");
    let share = 1.0 - steps.zero_heading as f64 / steps.pings.len() as f64;
    assert!((0.1..0.3).contains(&share), "{share}");
    let mut off: Vec<f64> = fitted
        .pings
        .iter()
        .zip(&pond.truth.pings)
        .map(|(found, truth)| off_deg(found.heading_rad, truth.heading_rad).abs())
        .collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 1.5, "median {} degrees", off[off.len() / 2]);
    assert!(
        off[off.len() * 95 / 100] < 12.0,
        "p95 {} degrees, turns included",
        off[off.len() * 95 / 100]
    );
}
