//! Surveys of recorders that are mounted askew: with the right settings they are right, without
//! them they are off by as much.

use super::{off_m, processed, scene, settings};
use crate::cli::run;
use crate::many_logs::{rms, true_box};
use crate::truth::KnownSurvey;
use bathyscope_log::formats::TrackFile;
use bathyscope_log::survey::{HeadingSource, Identity, MountingSettings, Side, Survey};
use bathyscope_objects::review::{Edit, Review};
use bathyscope_products::pipeline::{ObjectLocator, Products};
use bathyscope_simulation::{BedSettings, Mound, Scene};
use std::path::Path;

/// Metres forward and to starboard, and their length.
const ARM_M: [f64; 2] = [2.5, -1.5];

/// Distances of the sightings of all objects from their true places, and of the sightings of one
/// object from each other, metres.
fn objects_m(known: &KnownSurvey, survey: &Survey, products: &Products) -> [Vec<f64>; 2] {
    let locator = ObjectLocator::new(survey, products);
    let mut found = [Vec::new(), Vec::new()];
    for object in &known.truth.objects {
        // The lines run east and west; what is seen in the turn between them is smeared.
        let on_a_line = |ping: usize| known.truth.pings[ping].heading_rad.sin().abs() > 0.999;
        let seen = object.sightings.iter();
        let seen = seen.filter(|seen| on_a_line(seen.first_ping) && on_a_line(seen.last_ping));
        let places: Vec<[f64; 2]> = seen
            .filter_map(|seen| locator.place(&true_box(survey, seen)?))
            .map(|target| [target.east_m, target.north_m])
            .collect();
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let truth = [object.east_m, object.north_m];
        found[0].extend(places.iter().map(|place| apart(*place, truth)));
        let [first, second] = places[..] else {
            panic!("each object is seen from both lines: {places:?}");
        };
        found[1].push(apart(first, second));
    }
    found
}

#[test]
fn a_lever_arm_puts_pings_objects_and_depths_where_they_are() {
    let mut askew = scene();
    [askew.mounting.forward_m, askew.mounting.right_m] = ARM_M;
    let known = KnownSurvey::new(&askew, 3);
    let arm_m = ARM_M[0].hypot(ARM_M[1]);
    let with = |assignments: &[&str]| {
        let (survey, products) = processed(&known, &settings(assignments), None);
        let [truth, apart] = objects_m(&known, &survey, &products).map(|metres| rms(&metres));
        let depths_m = rms(&known.depth_errors_m(&products));
        println!(
            "{assignments:?}: pings {:.2} m, objects {truth:.2} m, opposite lines {apart:.2} m, depths {depths_m:.3} m",
            off_m(&known, &products)
        );
        (off_m(&known, &products), truth, apart, depths_m)
    };
    let none = with(&[]);
    let right = with(&["mounting.forward_m=2.5", "mounting.right_m=-1.5"]);
    let mirrored = with(&["mounting.forward_m=2.5", "mounting.right_m=1.5"]);
    // A metre of rounding is in the fixes.
    assert!((none.0 - arm_m).abs() < 0.3 && right.0 < 0.6, "{none:?} {right:?}");
    assert!(none.1 > 0.8 * arm_m && right.1 < 0.8, "{none:?} {right:?}");
    // Opposite lines move an object both ways: only the right arm has them agree.
    assert!(none.2 > 1.6 * arm_m && right.2 < 1.0, "{none:?} {right:?}");
    assert!(mirrored.2 > 4.0, "{mirrored:?}");
    assert!(right.3 < none.3, "{none:?} {right:?}");
}

#[test]
fn the_arm_turns_with_the_fitted_track_where_headings_are_steps() {
    let mut askew = scene();
    [askew.mounting.forward_m, askew.mounting.right_m] = ARM_M;
    let known = KnownSurvey::new(&askew, 3);
    let arm = ["mounting.forward_m=2.5", "mounting.right_m=-1.5"];
    let steps = [&arm[..], &["heading.source=steps"]].concat();
    let (_, by_steps) = processed(&known, &settings(&steps), None);
    let stepped_m = off_m(&known, &by_steps);
    println!("steps: {stepped_m:.2} m");
    // Positions as recorded: rounded to a metre, and old by up to a tenth of a second.
    assert!(stepped_m < 0.8, "{stepped_m}");
    let mercator = [&arm[..], &["projection=mercator"]].concat();
    let (survey, stretched) = processed(&known, &settings(&mercator), None);
    let pairs = stretched.navigation.pings.iter().zip(&known.truth.pings);
    let off = pairs.skip(60).map(|(ping, truth)| {
        let (east_m, north_m) = (ping.east_m, ping.north_m);
        let at = stretched.navigation.to_lon_lat(&survey.track, east_m, north_m);
        bathyscope_log::support::geo::distance_m(at, truth.position)
    });
    let off: Vec<f64> = off.collect();
    let off_m = rms(&off[..off.len() - 60]);
    println!("mercator: {off_m:.2} m");
    assert!(off_m < 0.6, "{off_m}");
}

#[test]
fn a_heading_offset_is_that_of_the_compass_alone() {
    let mut askew = scene();
    askew.recorder.compass = true;
    askew.mounting.heading_offset_deg = 12.0;
    let known = KnownSurvey::new(&askew, 3);
    let mean_deg = |assignments: &[&str]| {
        let (_, products) = processed(&known, &settings(assignments), None);
        let pairs = products.navigation.pings.iter().zip(&known.truth.pings);
        let errors: Vec<f64> = pairs
            .map(|(ping, truth)| ping.heading_rad - truth.heading_rad)
            .filter(|error| error.is_finite())
            .map(|error| (error.to_degrees() + 180.0).rem_euclid(360.0) - 180.0)
            .collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let compass = "heading.source=compass";
    let offset = "mounting.heading_offset_deg=12";
    let [off, right] = [mean_deg(&[compass]), mean_deg(&[compass, offset])];
    println!("compass: {off:.2} degrees, with its offset {right:.2}");
    assert!((off + 12.0).abs() < 0.5 && right.abs() < 0.5, "{off} {right}");
    for source in [HeadingSource::TrackFit, HeadingSource::Cog, HeadingSource::Steps] {
        let mut plain = settings(&[]);
        plain.heading.source = source;
        let mut with = plain.clone();
        with.mounting.heading_offset_deg = 12.0;
        let [one, other] =
            [plain, with].map(|settings| processed(&known, &settings, None).1.navigation);
        let bits = |heading_rad: f64| heading_rad.to_bits();
        let mut pairs = one.pings.iter().zip(other.pings.iter());
        assert!(pairs.all(|(a, b)| bits(a.heading_rad) == bits(b.heading_rad)), "{source:?}");
    }
}

#[test]
fn a_clock_that_is_behind_finds_its_place_on_another_receivers_track() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut askew = scene();
    askew.mounting.clock_offset_s = 7.0;
    let known = KnownSurvey::new(&askew, 3);
    // The receiver's clock is right.
    let path = folder.path().join("rtk.csv");
    let row = |ping: &bathyscope_simulation::PingTruth| {
        let time_s = f64::from(askew.start_unix_s) + ping.time_s;
        let at = ping.position;
        format!("{time_s:.3},{:.9},{:.9}\n", at.lon_deg, at.lat_deg)
    };
    let rows: String = known.truth.pings.iter().map(row).collect();
    std::fs::write(&path, format!("time,lon,lat\n{rows}")).expect("a track");
    let track = TrackFile::read(&path).expect("a track");
    let with = |assignments: &[&str]| {
        let (survey, products) = processed(&known, &settings(assignments), Some(&track));
        let places = products.navigation.pings.iter().map(|ping| {
            let (east_m, north_m) = (ping.east_m, ping.north_m);
            products.navigation.to_lon_lat(&survey.track, east_m, north_m)
        });
        let off = places
            .zip(&known.truth.pings)
            .map(|(place, truth)| bathyscope_log::support::geo::distance_m(place, truth.position));
        let off: Vec<f64> = off.filter(|metres| metres.is_finite()).collect();
        (rms(&off[60..off.len() - 60]), survey.start_unix_s)
    };
    let (wrong_m, recorded_s) = with(&[]);
    let (right_m, start_s) = with(&["mounting.clock_offset_s=7"]);
    println!("clock: {wrong_m:.2} m without, {right_m:.3} m with its offset");
    assert!(wrong_m > 5.0 && right_m < 0.1, "{wrong_m} {right_m}");
    assert_eq!(recorded_s, Some(f64::from(askew.start_unix_s) - 7.0));
    assert_eq!(start_s, Some(f64::from(askew.start_unix_s)));
}

/// Files of a run without its records, which name the log and its settings.
fn products(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() {
            let inner = products(&path).into_iter();
            all.extend(inner.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            all.push((name, std::fs::read(path).expect("a file")))
        }
    }
    all.sort();
    all
}

/// Boxes around all objects, of a log with these sides, as a file.
fn review(known: &KnownSurvey, swapped_sides: bool) -> String {
    let identity = Identity { swapped_sides, ..Identity::of(&known.survey) };
    let mut review = Review::new(identity, vec!["rock".to_owned()]);
    for seen in known.truth.objects.iter().flat_map(|object| &object.sightings) {
        let mark = true_box(&known.survey, seen).expect("more than a glimpse");
        let added = review.apply(&Edit::Add { mark, class: 0 });
        review = added.expect("a box");
    }
    review.to_json() + "\n"
}

#[test]
fn a_mirrored_recorder_with_its_sides_exchanged_gives_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let process = |name: &str, mirrored: bool, set: &[&str]| {
        let mut scene = scene();
        scene.mounting.swap_sides = mirrored;
        let (inside, known) = (folder.join(name), KnownSurvey::new(&scene, 3));
        std::fs::create_dir(&inside).expect("a folder");
        std::fs::write(inside.join("pond.sl2"), known.truth.sl2_bytes()).expect("a log");
        let boxes = review(&known, !set.is_empty());
        std::fs::write(inside.join("boxes.json"), boxes).expect("boxes");
        let args = "process pond.sl2 --no-objects --review boxes.json -o out";
        let args: Vec<&str> = args.split(' ').chain(set.iter().copied()).collect();
        run(&inside, &args);
        products(&inside.join("out"))
    };
    let plain = process("plain", false, &[]);
    let wrong = process("wrong", true, &[]);
    let exchanged = process("exchanged", true, &["--set", "mounting.swap_sides=true"]);
    // These hold the settings, and the name of the run that follows from them.
    let records = ["manifest.json", "report.json", "report.html", "quality/residuals.json"];
    let named = |all: &[(String, Vec<u8>)], name: &str| {
        let file = all.iter().find(|(file, _)| file == name);
        file.unwrap_or_else(|| panic!("{name}")).1.clone()
    };
    let files: Vec<_> =
        (plain.iter()).filter(|(name, _)| !records.contains(&name.as_str())).collect();
    for (name, bytes) in &files {
        assert!(named(&exchanged, name) == *bytes, "{name} differs");
    }
    println!("{} files are the same bytes", files.len());
    assert_eq!(exchanged.len(), plain.len());
    let count = files.len();
    assert!(count > 20, "{count}");
    let differs = |name: &&&(String, Vec<u8>)| named(&wrong, &name.0) != name.1;
    let differ = files.iter().filter(differs).count();
    println!("{differ} of them differ while the sides are wrong");
    assert!(3 * differ > count, "{differ}");
    let report = String::from_utf8(named(&exchanged, "report.json")).expect("text");
    assert!(report.contains("Port and starboard are exchanged"), "{report}");
}

#[test]
fn every_side_of_a_mirrored_log_is_that_of_the_boat() {
    let [plain, mirrored] = [false, true].map(|swap_sides| {
        let mut scene = scene();
        scene.mounting.swap_sides = swap_sides;
        KnownSurvey::new(&scene, 3)
    });
    let (_, right) = processed(&plain, &settings(&[]), None);
    let (survey, exchanged) = processed(&mirrored, &settings(&["mounting.swap_sides=true"]), None);
    let (_, wrong) = processed(&mirrored, &settings(&[]), None);
    assert!(survey.swapped_sides);
    assert_eq!(exchanged.returns.port, right.returns.port);
    assert_eq!(wrong.returns.port, right.returns.starboard);
    // A sounding has no sample, which is no number and equals nothing.
    let [exchanged, right] = [&exchanged, &right].map(|made| format!("{:?}", made.cloud));
    assert!(exchanged == right, "the clouds differ");
    let outward = |survey: &Survey, side| -> Vec<u8> {
        let samples = survey.samples(40, side).expect("samples");
        (0..samples.len()).map(|sample| samples.get(sample)).collect()
    };
    for side in Side::BOTH {
        assert_eq!(outward(&survey, side), outward(&plain.survey, side));
        assert_eq!(outward(&mirrored.survey, side), outward(&plain.survey, side.other()));
    }
}

/// A boat to and fro over mounds and hollows, whose positions are recorded 0.8 s late.
fn late() -> Scene {
    let scene = crate::archive::zigzag(0, [0.0, 0.0], 0.0);
    let places = (-4..=4).flat_map(|column| (-4..=4).map(move |row| (column, row)));
    let mounds = places.map(|(column, row)| Mound {
        east_m: 8.0 * f64::from(column),
        north_m: 8.0 * f64::from(row),
        radius_m: 2.5,
        height_m: if (column + row) % 2 == 0 { 0.7 } else { -0.5 },
    });
    let mut scene =
        Scene { bed: BedSettings { mounds: mounds.collect(), ..scene.bed.clone() }, ..scene };
    scene.mounting.latency_s = 0.8;
    scene
}

#[test]
fn late_positions_are_put_right_and_crossings_show_how_late_they_are() {
    let known = KnownSurvey::new(&late(), 3);
    let off = |assignments: &[&str]| {
        let (_, products) = processed(&known, &settings(assignments), None);
        off_m(&known, &products)
    };
    let [late_m, right_m] = [off(&[]), off(&["mounting.latency_s=0.8"])];
    println!("positions: {late_m:.2} m off, with their latency {right_m:.2} m");
    assert!(right_m < 0.6 && late_m > 2.0 * right_m, "{late_m} {right_m}");

    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    std::fs::write(folder.join("late.sl2"), known.truth.sl2_bytes()).expect("a log");
    let found = |name: &str, more: &[&str]| {
        let process = ["process", "late.sl2", "-o", name, "--no-objects"];
        let products = ["--products", "residuals,report"];
        run(folder, &[&process[..], &products, more].concat());
        let text = std::fs::read_to_string(folder.join(name).join("quality/residuals.json"));
        let record: serde_json::Value =
            serde_json::from_str(&text.expect("a record")).expect("JSON");
        let latency = &record["crossline_analysis"]["latencies"][0];
        let number = |key: &str| latency[key].as_f64().expect("a number");
        let page = std::fs::read_to_string(folder.join(name).join("report.html")).expect("a page");
        let advice = page.contains("set <code>mounting.latency_s</code>");
        ([number("latency_s"), number("standard_error_s"), number("in_force_s")], advice)
    };
    let (free, advised) = found("free", &[]);
    let (held, advised_again) = found("held", &["--set", "mounting.latency_s=0.8"]);
    println!("latency: {free:?} as recorded, {held:?} with it in force");
    assert!((free[0] - 0.8).abs() < 0.25 && free[1] < 0.2 && free[2] == 0.0, "{free:?}");
    assert!((held[0] - 0.8).abs() < 0.25 && held[2] == 0.8, "{held:?}");
    assert!(advised && !advised_again);
}

#[test]
fn soundings_that_are_late_are_found_by_first_returns_and_taken_earlier() {
    let mut scene = late();
    scene.mounting = MountingSettings { sounding_lag_s: 1.2, ..MountingSettings::default() };
    let known = KnownSurvey::new(&scene, 3);
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    std::fs::write(folder.join("late.sl2"), known.truth.sl2_bytes()).expect("a log");
    let report = |name: &str, more: &[&str]| -> serde_json::Value {
        let process = ["process", "late.sl2", "-o", name, "--no-objects", "--products", "report"];
        run(folder, &[&process[..], more].concat());
        let text = std::fs::read_to_string(folder.join(name).join("report.json"));
        serde_json::from_str(&text.expect("a report")).expect("JSON")
    };
    let words = |report: &serde_json::Value| report["warnings"].to_string();
    let as_recorded = report("recorded", &[]);
    assert!(words(&as_recorded).contains("mounting.sounding_lag_s"), "{}", as_recorded["warnings"]);
    assert!(!words(&as_recorded).contains("mounting.latency_s"), "{}", as_recorded["warnings"]);
    let corrected = report("corrected", &["--latency"]);
    let found = &corrected["corrections"][0];
    let lag_s = found["sounding_lag_s"].as_f64().expect("a lag");
    println!("lag of soundings: {lag_s:.2} s for 1.2");
    assert!((lag_s - 1.2).abs() < 0.1, "{found}");
    assert!(!words(&corrected).contains("mounting."), "{}", corrected["warnings"]);
    let in_force = &corrected["settings"]["mounting"]["sounding_lag_s"];
    assert!((in_force.as_f64().expect("a setting") - lag_s).abs() < 0.006, "{in_force}");
}
