//! Lines to sail next: where they may run, and what the command writes and refuses; `ponds` sails
//! them.

mod ponds;

use crate::cli::{refusal, run};
use crate::support::demo_log;
use bathyscope_bottom::planning::{
    Leg, PlanError, PlanSettings, SeenObject, SigmaLaw, SurveyCoverage, WaypointKind, plan,
};
use bathyscope_log::support::progress::Progress;
use serde_json::Value;
use std::fs;

/// Lines from west to east with soundings a metre apart.
fn known(lines: &[f64], length_m: f64) -> SurveyCoverage {
    let line = |north: f64| (0..=length_m as u32).map(move |step| [f64::from(step), north]);
    SurveyCoverage {
        soundings: lines.iter().copied().flat_map(line).collect(),
        sigma: SigmaLaw::new(None, 0.6),
        looks: Vec::new(),
        objects: Vec::new(),
        doubts: Vec::new(),
        depth_m: 3.0,
        range_m: 15.0,
        speed_mps: 2.0,
        max_gap_m: 20.0,
    }
}

fn asked(minutes: f64, turn_radius_m: f64) -> PlanSettings {
    PlanSettings { minutes, turn_radius_m, ..PlanSettings::default() }
}

/// Places along a way, some ten centimetres apart.
fn along(way: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let piece = |pair: &[[f64; 2]]| {
        let length_m = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        let steps = (length_m / 0.1).ceil().max(1.0);
        let (from, to) = (pair[0], pair[1]);
        (0..=steps as u32).map(move |step| {
            let share = f64::from(step) / steps;
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        })
    };
    way.windows(2).flat_map(piece).collect()
}

fn is_inside(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = ring.iter().cycle().skip(1);
    let crosses = |&(&[x0, y0], &[x1, y1]): &(&[f64; 2], &[f64; 2])| {
        (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    };
    ring.iter().zip(next).filter(crosses).count() % 2 == 1
}

#[test]
fn lines_and_turns_stay_in_the_polygon_and_off_the_island_and_turn_no_sharper_than_the_boat() {
    // A lake with a bay, and an island.
    let shore = vec![
        [-30.0, -30.0],
        [150.0, -20.0],
        [160.0, 60.0],
        [90.0, 70.0],
        [85.0, 130.0],
        [-20.0, 120.0],
    ];
    let island = vec![[40.0, 30.0], [60.0, 32.0], [58.0, 50.0], [42.0, 48.0]];
    let known = known(&[-10.0, 0.0, 10.0], 120.0);
    for radius_m in [3.0, 6.0] {
        let rings = [shore.clone(), island.clone()];
        let made = plan(&known, Some(&rings), &asked(12.0, radius_m), &Progress::new());
        let made = made.expect("a plan");
        assert!(made.lines.len() > 4 && made.minutes() <= 12.0 && made.minutes() > 10.5);
        assert_eq!(made.turns_outside, 0);
        let way: Vec<[f64; 2]> = made.way.iter().map(|waypoint| waypoint.place).collect();
        for place in along(&way) {
            assert!(is_inside(&shore, place) && !is_inside(&island, place), "{place:?}");
        }
        for corner in way.windows(3) {
            let side = |i: usize, j: usize| {
                (corner[i][0] - corner[j][0]).hypot(corner[i][1] - corner[j][1])
            };
            let doubled = (corner[1][0] - corner[0][0]) * (corner[2][1] - corner[0][1])
                - (corner[1][1] - corner[0][1]) * (corner[2][0] - corner[0][0]);
            // The circle through three places of the way.
            let circle_m = side(0, 1) * side(1, 2) * side(0, 2) / (2.0 * doubled.abs()).max(1e-9);
            assert!(circle_m > 0.99 * radius_m, "{circle_m} {corner:?}");
        }
        let length_m: f64 = way
            .windows(2)
            .map(|pair| (pair[0][0] - pair[1][0]).hypot(pair[0][1] - pair[1][1]))
            .sum();
        assert!((length_m / made.length_m - 1.0).abs() < 0.01, "{length_m} {}", made.length_m);
        let starts =
            made.way.iter().filter(|waypoint| matches!(waypoint.station, WaypointKind::Start(_)));
        assert_eq!(starts.count(), made.lines.len());
        assert!(made.after.mean_sigma_m < 0.75 * made.before.mean_sigma_m);
    }
}

#[test]
fn a_missing_strip_is_sailed_along_and_a_spacing_is_kept() {
    let known = known(&[0.0, 10.0, 20.0, 60.0, 70.0, 80.0], 150.0);
    let made = plan(&known, None, &asked(4.0, 4.0), &Progress::new()).expect("a plan");
    let is_in_strip =
        |leg: &Leg| [leg.from, leg.to].iter().all(|end| (20.0..60.0).contains(&end[1]));
    let in_strip: f64 = made.lines.iter().filter(|leg| is_in_strip(leg)).map(Leg::length_m).sum();
    assert!(in_strip > 0.85 * made.lines_m, "{:?}", made.lines);
    let again = plan(&known, None, &asked(4.0, 4.0), &Progress::new()).expect("a plan");
    assert_eq!(again.way, made.way, "the same again");
    // Lines 10 m apart are close enough for 20 m: all that is left is the strip, which one line in
    // its middle mends.
    let close = PlanSettings { spacing_m: Some(20.0), ..asked(60.0, 4.0) };
    let mut known = known;
    known.range_m = 0.0;
    let made = plan(&known, None, &close, &Progress::new()).expect("a plan");
    assert!(made.minutes() < 10.0, "{}", made.minutes());
}

#[test]
fn an_object_seen_from_one_side_is_passed_at_right_angles_and_not_under_the_boat() {
    let mut known = known(&[0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0], 60.0);
    known
        .objects
        .push(SeenObject { place: [30.0, 20.0], headings_rad: vec![std::f64::consts::FRAC_PI_2] });
    let made = plan(&known, None, &asked(0.5, 3.0), &Progress::new()).expect("a plan");
    assert_eq!((made.before.one_sided, made.after.one_sided), (1, 0));
    let passes = made.lines.iter().any(|leg| {
        let angle = leg.heading_rad().cos().abs();
        let ends = [leg.from, leg.to].map(|end| end[1]);
        let beside_m = (0.5 * (leg.from[0] + leg.to[0]) - 30.0).abs();
        angle > 0.8
            && ends[0].min(ends[1]) < 16.0
            && ends[0].max(ends[1]) > 24.0
            && (2.0..13.0).contains(&beside_m)
    });
    assert!(passes, "{:?}", made.lines);
}

#[test]
fn what_cannot_be_planned_is_said_in_a_sentence() {
    let some = known(&[0.0, 10.0, 40.0], 100.0);
    let square = |east: f64, half_m: f64| {
        vec![vec![
            [east - half_m, -half_m],
            [east + half_m, -half_m],
            [east + half_m, half_m],
            [east - half_m, half_m],
        ]]
    };
    let of = |known: &SurveyCoverage, area: Option<&[Vec<[f64; 2]>]>, settings: &PlanSettings| {
        plan(known, area, settings, &Progress::new()).expect_err("no plan")
    };
    let usual = asked(10.0, 4.0);
    assert_eq!(of(&known(&[], 0.0), None, &usual), PlanError::NoDepths);
    assert_eq!(of(&some, Some(&square(5000.0, 50.0)), &usual), PlanError::AreaElsewhere);
    assert_eq!(of(&some, Some(&square(50.0, 0.4)), &usual), PlanError::NoArea);
    assert_eq!(of(&some, Some(&square(50.0, 10.0)), &asked(10.0, 9.0)), PlanError::NoRoom);
    assert_eq!(of(&some, None, &asked(0.1, 20.0)), PlanError::NoTime);
    assert!(matches!(of(&some, None, &asked(0.0, 4.0)), PlanError::Settings(_)));
    assert!(matches!(of(&some, None, &asked(f64::NAN, 4.0)), PlanError::Settings(_)));
    let dense: Vec<f64> = (0..30).map(f64::from).collect();
    let mut dense = known(&dense, 60.0);
    dense.range_m = 0.0;
    let close = PlanSettings { spacing_m: Some(4.0), ..usual };
    assert_eq!(of(&dense, None, &close), PlanError::NothingToMend);
    let cancelled = Progress::new();
    cancelled.cancel();
    assert!(matches!(plan(&some, None, &usual, &cancelled), Err(PlanError::Cancelled(_))));
}

#[test]
fn a_large_survey_is_planned_whole() {
    // Two square kilometres, lines 40 m apart, half a million soundings.
    let lines: Vec<f64> = (0..36).map(|line| 40.0 * f64::from(line)).collect();
    let mut large = known(&lines, 1400.0);
    large.soundings = large
        .soundings
        .iter()
        .flat_map(|[x, y]| (0..10).map(move |part| [x + 0.1 * f64::from(part), *y]))
        .collect();
    large.range_m = 40.0;
    let made = plan(&large, None, &asked(120.0, 8.0), &Progress::new()).expect("a plan");
    println!(
        "{} soundings, {:.0} ha, {} lines; sigma {:.3} to {:.3}",
        large.soundings.len(),
        1e-4 * made.area_m2,
        made.lines.len(),
        made.before.mean_sigma_m,
        made.after.mean_sigma_m
    );
    assert!(made.minutes() <= 120.0 && made.lines.len() > 5);
    assert!(made.after.mean_sigma_m < made.before.mean_sigma_m);
}

#[test]
fn other_lines_give_another_plan_and_a_turn_that_leaves_the_water_is_counted() {
    let known = known(&[0.0, 10.0, 50.0, 60.0], 120.0);
    let made = plan(&known, None, &asked(5.0, 4.0), &Progress::new()).expect("a plan");
    let fewer = made.with_lines(made.lines[1..].to_vec());
    assert!(fewer.length_m < made.length_m && fewer.after.mean_sigma_m > made.after.mean_sigma_m);
    let whole = fewer.with_lines(made.lines.clone());
    assert_eq!((&whole.way, whole.after.mean_sigma_m), (&made.way, made.after.mean_sigma_m));
    let out = |north: f64| Leg { from: [40.0, north], to: [119.9, north] };
    let drawn = made.with_lines(vec![out(5.0), out(12.0)]);
    assert_eq!(drawn.turns_outside, 1);
    assert!(made.with_lines(Vec::new()).way.is_empty());
}

#[test]
fn the_command_writes_four_formats_with_the_same_places() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::copy(demo_log(), folder.join("demo.sl2")).expect("a log");
    let mut counts = Vec::new();
    for ending in ["gpx", "kml", "plan", "waypoints"] {
        let name = format!("lines.{ending}");
        let args =
            ["plan", "demo.sl2", "-o", &name, "--minutes", "2", "--turn-radius", "3", "--json"];
        let printed: Value = serde_json::from_str(&run(folder, &args)).expect("JSON");
        assert!(printed["minutes"].as_f64().expect("a number") <= 2.0);
        assert!(
            printed["after"]["mean_sigma_m"].as_f64() < printed["before"]["mean_sigma_m"].as_f64()
        );
        let text = fs::read_to_string(folder.join(&name)).expect("a file");
        counts.push(match ending {
            "gpx" => text.matches("<rtept ").count(),
            "kml" => text.rsplit("<coordinates>").next().expect("the way").matches(',').count(),
            "plan" => {
                let plan: Value = serde_json::from_str(&text).expect("JSON");
                plan["mission"]["items"].as_array().expect("items").len()
            }
            _ => text.lines().count() - 2,
        });
    }
    assert!(counts[0] > 3 && counts.iter().all(|count| *count == counts[0]), "{counts:?}");
    let said = run(folder, &["plan", "demo.sl2", "-o", "lines.gpx", "--minutes", "2"]);
    for words in ["min at", "mean sigma", "after (predicted)", "wrote lines.gpx"] {
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn the_command_refuses_in_one_sentence_and_writes_nothing() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::copy(demo_log(), folder.join("demo.sl2")).expect("a log");
    fs::copy(demo_log(), folder.join("demo.gpx")).expect("a log of another name");
    let elsewhere = r#"{"type":"Polygon","coordinates":[[[8,47],[8.01,47],[8.01,47.01],[8,47]]]}"#;
    fs::write(folder.join("elsewhere.geojson"), elsewhere).expect("an area");
    fs::write(folder.join("none.geojson"), "{}").expect("no area");
    for (args, words) in [
        (vec!["demo.sl2", "-o", "lines.txt"], ".waypoints (Mission Planner)"),
        (vec!["demo.sl2", "-o", "lines.gpx", "--minutes", "0"], "0.1 to 1440 minutes"),
        (vec!["demo.sl2", "-o", "lines.gpx", "--speed", "0"], "metres a second"),
        (
            vec!["demo.sl2", "-o", "lines.gpx", "--area", "elsewhere.geojson"],
            "away from the survey",
        ),
        (vec!["demo.sl2", "-o", "lines.gpx", "--area", "none.geojson"], "no polygon"),
        (vec!["demo.gpx", "-o", "demo.gpx"], "written over"),
        (vec!["nothing.sl2", "-o", "lines.gpx"], "nothing.sl2"),
    ] {
        let said = refusal(folder, &[&["plan"], args.as_slice()].concat(), 1);
        let sentence = said.lines().last().unwrap_or_default();
        assert!(
            sentence.starts_with("bathyscope: ") && sentence.contains(words),
            "{args:?}: {said}"
        );
    }
    assert!(!folder.join("lines.gpx").exists() && !folder.join("lines.txt").exists());
}
