//! One survey at several rates, in every format that can hold it: the same places, and the same
//! loss of the bottom.

use crate::truth::KnownSurvey;
use bathyscope_log::formats;
use bathyscope_log::support::geo::{LocalFrame, LonLat, distance_m};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    HeadingSettings, MountingSettings, PositionSettings, PositionShift, Projection, Survey,
    navigate,
};
use bathyscope_products::export::{LogPartChoice, copy_log};
use bathyscope_simulation::{Scene, TrackSettings};
use std::fmt::Write as _;
use std::path::Path;

const ORIGIN: LonLat = LonLat { lon_deg: 8.5, lat_deg: 47.5 };
const SPEED_MPS: f64 = 2.0;
const BEND_M: f64 = 800.0;
const DURATION_S: f64 = 300.0;
const LOST_S: [f64; 2] = [120.0, 200.0];
/// 2024-06-03T07:00:00Z.
const START_UNIX_S: f64 = 1_717_398_000.0;

/// Metres east and north of the boat, on a wide bend.
fn place(time_s: f64) -> [f64; 2] {
    let turned_rad = SPEED_MPS * time_s / BEND_M;
    [BEND_M * (1.0 - turned_rad.cos()), BEND_M * turned_rad.sin()]
}

/// The bottom lies 20 m deep, and for a while the recorder jumps off it and back.
fn depth_m(time_s: f64) -> f64 {
    let is_lost = (LOST_S[0]..LOST_S[1]).contains(&time_s);
    if is_lost && time_s % 4.0 < 2.0 { 1.8 } else { 20.0 + 0.3 * (0.02 * time_s).sin() }
}

/// Time, place and depth of each sounding.
fn soundings(rate_hz: f64) -> impl Iterator<Item = (f64, LonLat, f64)> {
    let frame = LocalFrame::new(ORIGIN);
    (0..(DURATION_S * rate_hz) as usize).map(move |index| {
        let time_s = index as f64 / rate_hz;
        let [east_m, north_m] = place(time_s);
        (time_s, frame.to_lon_lat(east_m, north_m), depth_m(time_s))
    })
}

fn csv(rate_hz: f64) -> String {
    let mut table = String::from("time,lat,lon,depth_m\n");
    for (time_s, at, depth_m) in soundings(rate_hz) {
        let unix_s = START_UNIX_S + time_s;
        writeln!(table, "{unix_s:.3},{:.9},{:.9},{depth_m:.2}", at.lat_deg, at.lon_deg).unwrap();
    }
    table
}

fn nmea(rate_hz: f64) -> String {
    let sentence = |body: String| {
        let sum = body.bytes().fold(0, |sum: u8, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n")
    };
    let degrees = |value: f64, width: usize| {
        format!("{:0width$}{:010.7}", value.floor(), 60.0 * value.fract())
    };
    let mut log = String::new();
    for (time_s, at, depth_m) in soundings(rate_hz) {
        let seconds = time_s % 60.0;
        let clock = format!("07{:02}{seconds:05.2}", (time_s / 60.0) as usize);
        let (lat, lon) = (degrees(at.lat_deg, 2), degrees(at.lon_deg, 3));
        log += &sentence(format!("GPRMC,{clock},A,{lat},N,{lon},E,3.9,,030624,,"));
        log += &sentence(format!("SDDPT,{depth_m:.2},"));
    }
    log
}

/// The farthest that a sounding lies from where the boat was at its time, metres, and the first and
/// the last time at which the bottom is lost, seconds.
fn judged(survey: &Survey) -> (f64, [f64; 2]) {
    let found =
        navigate(survey, &HeadingSettings::default(), Projection::Enu, &Progress::new()).unwrap();
    let frame = LocalFrame::new(ORIGIN);
    let late_s = survey.start_unix_s.map_or(0.0, |start_s| start_s - START_UNIX_S);
    let mut farthest_m: f64 = 0.0;
    let mut lost_s = [f64::INFINITY, f64::NEG_INFINITY];
    for (at, sounding) in found.soundings.iter().zip(survey.soundings.iter()) {
        let time_s = sounding.time_s + late_s;
        let position = found.to_lon_lat(&survey.track, at.east_m, at.north_m);
        let [east_m, north_m] = frame.to_enu(position);
        let [x, y] = place(time_s);
        farthest_m = farthest_m.max((east_m - x).hypot(north_m - y));
        if !sounding.is_good() {
            lost_s = [lost_s[0].min(time_s), lost_s[1].max(time_s)];
        }
    }
    (farthest_m, lost_s)
}

fn copied(survey: &Survey, path: &Path) -> Survey {
    let (heading, mounting) = (HeadingSettings::default(), MountingSettings::default());
    let shift = PositionShift::default();
    let positions = PositionSettings {
        heading: &heading,
        mounting: &mounting,
        shift: &shift,
        projection: Projection::Enu,
    };
    copy_log(path, survey, positions, &LogPartChoice::default(), &Progress::new()).unwrap();
    formats::open(path, &Progress::new()).unwrap()
}

#[test]
fn places_and_lost_bottom_are_those_of_the_survey_at_any_rate_in_any_format() {
    let folder = tempfile::tempdir().unwrap();
    for rate_hz in [10.0, 1.0, 0.2] {
        let read = |name: &str, text: String| {
            formats::open_bytes(name, text.into_bytes(), &Progress::new()).unwrap()
        };
        let table = read("survey.csv", csv(rate_hz));
        let sentences = read("survey.nmea", nmea(rate_hz));
        let copy =
            |ending: &str| copied(&table, &folder.path().join(format!("copy{rate_hz}.{ending}")));
        let kinds = [("CSV", table.clone()), ("NMEA", sentences), ("CSV, copied", copy("csv"))];
        for (name, survey) in kinds {
            let (farthest_m, [from_s, to_s]) = judged(&survey);
            println!("{name} at {rate_hz} Hz: {farthest_m:.2} m, lost from {from_s} to {to_s} s");
            assert!(farthest_m < 0.1, "{name} at {rate_hz} Hz: {farthest_m} m");
            // To one of the recorder's jumps, 2 s apart, and to two soundings.
            let within_s = 2.0 + 2.0 / rate_hz;
            let ends = [from_s - LOST_S[0], to_s - LOST_S[1]];
            assert!(
                ends.iter().all(|off_s| off_s.abs() <= within_s),
                "{name} at {rate_hz} Hz: {ends:?}"
            );
        }
    }
}

/// Places of an SL2 are whole metres of Mercator's projection; its copies lie where it lies.
#[test]
fn copies_of_a_side_scan_log_lie_where_it_lies_at_any_rate() {
    let folder = tempfile::tempdir().unwrap();
    for rate_hz in [10.0, 1.0, 0.2] {
        let track = TrackSettings {
            lines: 1,
            cross_lines: 0,
            length_m: SPEED_MPS * 120.0,
            speed_mps: SPEED_MPS,
            ping_rate_hz: rate_hz,
            fix_rate_hz: rate_hz,
            ..TrackSettings::default()
        };
        let known = KnownSurvey::new(&Scene { track, ..Scene::default() }, 1);
        let settings = HeadingSettings::default();
        let placed = |survey: &Survey| {
            navigate(survey, &settings, Projection::Enu, &Progress::new()).unwrap()
        };
        let own = placed(&known.survey);
        for (at, truth) in own.pings.iter().zip(&known.truth.pings) {
            let position = own.to_lon_lat(&known.survey.track, at.east_m, at.north_m);
            let off_m = distance_m(position, truth.position);
            assert!(off_m < 0.8, "SL2 at {rate_hz} Hz: {off_m} m at {} s", truth.time_s);
        }
        for ending in ["sl2", "xtf"] {
            let path = folder.path().join(format!("copy{rate_hz}.{ending}"));
            let copy = copied(&known.survey, &path);
            let found = placed(&copy);
            assert_eq!(found.pings.len(), own.pings.len());
            let mut farthest_m: f64 = 0.0;
            for (a, b) in own.pings.iter().zip(found.pings.iter()) {
                let a = own.to_lon_lat(&known.survey.track, a.east_m, a.north_m);
                let b = found.to_lon_lat(&copy.track, b.east_m, b.north_m);
                farthest_m = farthest_m.max(distance_m(a, b));
            }
            println!("{ending} at {rate_hz} Hz: {farthest_m:.2} m from the log");
            let within_m = if ending == "sl2" { 0.8 } else { 0.1 };
            assert!(farthest_m < within_m, "{ending} at {rate_hz} Hz: {farthest_m} m");
        }
    }
}
