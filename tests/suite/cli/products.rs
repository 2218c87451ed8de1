//! The maps of `bathyscope process`: which are made, and that they agree with each other.

use super::{refusal, run, simulated, stderr_of};
use crate::support::manifest;
use bathyscope_test_support::handmade;
use serde_json::Value;
use std::fs;
use std::path::Path;

const DEPTH: [&str; 8] = [
    "depth/depth.tif",
    "depth/depth.qml",
    "depth/uncertainty.tif",
    "depth/uncertainty.qml",
    "depth/shoalest.tif",
    "depth/shoalest.qml",
    "depth/distance.tif",
    "depth/distance.qml",
];
const ISOBATHS: [&str; 3] =
    ["isobaths/isobaths.geojson", "isobaths/depth_areas.geojson", "isobaths/storage.csv"];

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a product")).expect("JSON")
}

fn assert_made(folder: &Path, products: &[&str], made: bool) {
    for product in products {
        assert_eq!(folder.join(product).is_file(), made, "{product}");
    }
}

#[test]
fn only_the_products_that_are_named_are_made() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let process = ["process", "pond.sl2", "--no-objects", "-o"];
    run(folder, &[&process[..], &["some", "--products", "depth,residuals"]].concat());
    let some = folder.join("some");
    assert_made(&some, &DEPTH, true);
    assert_made(&some, &["quality/residuals.json", "points/cloud.csv", "report.json"], true);
    assert_made(&some, &ISOBATHS, false);
    assert_made(&some, &["mosaic/mosaic.tif", "depth/depth.xyz"], false);
    let wrong = [&process[..], &["other", "--products", "dept"]].concat();
    assert!(refusal(folder, &wrong, 2).contains("dept"));
    let wrong = [&process[..], &["other", "--set", "surface.max_gap_m=0"]].concat();
    assert!(refusal(folder, &wrong, 1).contains("surface.max_gap_m"));
}

#[test]
fn points_of_the_cloud_carry_the_level_of_their_echo() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let process = ["process", "pond.sl2", "--no-objects", "--products", "cloud"];
    run(folder, &[&process[..], &["-o", "out"]].concat());
    let mut reader =
        las::Reader::from_path(folder.join("out/points/cloud.copc.laz")).expect("a LAZ file");
    let points = reader.read_all().expect("points");
    // The user data are 0 for soundings.
    let points = points.user_data().zip(points.intensity());
    let (side_scan, soundings): (Vec<_>, Vec<_>) = points.partition(|(source, _)| *source > 0);
    assert!(side_scan.len() > 100 && soundings.len() > 100);
    let mut levels: Vec<u16> = side_scan.iter().map(|(_, intensity)| *intensity).collect();
    levels.sort_unstable();
    levels.dedup();
    assert!(levels[0] > 0 && levels.len() > 20, "{levels:?}");
    assert!(levels.iter().all(|level| level % 257 == 0));
    assert!(soundings.iter().all(|(_, intensity)| *intensity == 0));
}

#[test]
fn isobaths_areas_storage_and_residuals_agree() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let mut process = vec!["process", "pond.sl2", "--no-objects", "-o", "out"];
    process.extend(["--products", "isobaths,residuals", "--set", "surface.cell_m=0.2"]);
    process.extend(["--set", "isobaths.interval_m=0.1", "--set", "water_level_m=0.5"]);
    run(folder, &process);
    let out = folder.join("out");

    let lines = json(&out.join("isobaths/isobaths.geojson"));
    let lines = lines["features"].as_array().expect("features");
    assert!(!lines.is_empty());
    for line in lines {
        let depth_m = line["properties"]["depth_m"].as_f64().expect("a depth");
        assert!((depth_m * 10.0 - (depth_m * 10.0).round()).abs() < 1e-9, "{depth_m}");
    }

    // The areas cover what the storage table says is deeper than the shallowest place, but for the
    // cells at the edge.
    let areas = json(&out.join("isobaths/depth_areas.geojson"));
    let areas = areas["features"].as_array().expect("features");
    let covered: f64 =
        areas.iter().map(|area| area["properties"]["area_m2"].as_f64().unwrap()).sum();
    let table = fs::read_to_string(out.join("isobaths/storage.csv")).expect("a table");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|value| value.parse().expect("a number")).collect())
        .collect();
    assert!(covered > 0.5 * rows[0][1] && covered < rows[0][1], "{covered} of {}", rows[0][1]);
    assert!(rows.windows(2).all(|step| step[0][1] >= step[1][1] && step[0][2] >= step[1][2]));

    // Side-scan against down-scan is about what the report says of the same pings, the sign turned.
    let record = json(&out.join("quality/residuals.json"));
    let report = json(&out.join("report.json"));
    let by_surface = &record["comparisons"][0];
    assert_eq!(by_surface["source"], "side-scan");
    let median = |figures: &Value| figures["median_m"].as_f64().expect("a number");
    assert!((median(by_surface) + median(&report["residuals"])).abs() < 0.1, "{by_surface}");
    assert_eq!(record["settings"]["water_level_m"], 0.5);
}

/// `source, ping, z_m` of every point.
fn points(folder: &Path) -> Vec<(String, usize, f64)> {
    let text = fs::read_to_string(folder.join("points/cloud.csv")).expect("a cloud");
    let rows = text.lines().skip(1).map(|row| {
        let fields: Vec<&str> = row.split(',').collect();
        let [ping, z_m] = [fields[1], fields[6]];
        (fields[0].to_owned(), ping.parse().unwrap(), z_m.parse().unwrap())
    });
    rows.collect()
}

#[test]
fn water_and_transducer_correct_soundings_and_side_scan_alike() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let process = ["process", "pond.sl2", "--no-objects", "--products", "depth,residuals", "-o"];
    run(folder, &[&process[..], &["plain"]].concat());
    let start_s = json(&folder.join("plain/report.json"))["start_unix_s"].as_f64().expect("a time");
    // 10 m at the log's first second, a centimetre more a second.
    let gauge = format!("time,level_m\n{},9\n{},19\n", start_s - 100.0, start_s + 900.0);
    fs::write(folder.join("gauge.csv"), gauge).unwrap();
    let sets = [
        "--set",
        "draft_m=0.35",
        "--set",
        "water_level.file=gauge.csv",
        "--set",
        "sound_speed.temperature_c=20",
        "--set",
        "sound_speed.recorder_m_s=1463",
    ];
    run(folder, &[&process[..], &["corrected"], &sets].concat());

    let times = fs::read_to_string(folder.join("plain/points/first_returns.csv")).unwrap();
    let times: Vec<f64> =
        times.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let [plain, corrected] = ["plain", "corrected"].map(|name| points(&folder.join(name)));
    assert!(plain.len() > 100 && plain.len() == corrected.len());
    for ((source, ping, z_m), (_, _, found_m)) in plain.iter().zip(&corrected) {
        // The speed of sound in fresh water of 20 C is 1482.343 m/s.
        let expected_m = z_m * 1482.343 / 1463.0 - 0.35 + 10.0 + 0.01 * times[*ping];
        // A sounding bears the number of the side-scan ping nearest to it.
        let tolerance_m = if source == "downscan" { 2e-3 } else { 2e-4 };
        assert!(
            (found_m - expected_m).abs() < tolerance_m,
            "{source} {ping}: {found_m} {expected_m}"
        );
    }

    let report = json(&folder.join("corrected/report.json"));
    assert_eq!(report["inputs"].as_array().unwrap().len(), 2);
    for product in ["report.json", "quality/residuals.json"] {
        let statement = json(&folder.join("corrected").join(product))["statement"].to_string();
        for words in ["1482.3 m/s", "draft 0.35 m", "gauge.csv", "Not corrected: roll and pitch."] {
            assert!(statement.contains(words), "{product}: {statement}");
        }
    }
    let raster = fs::read(folder.join("corrected/depth/depth.tif")).unwrap();
    assert!(String::from_utf8_lossy(&raster).contains("draft 0.35 m added"));

    fs::write(
        folder.join("gauge.csv"),
        format!("time,level_m\n{start_s},9\n{},9\n", start_s + 1.0),
    )
    .unwrap();
    let refused = refusal(folder, &[&process[..], &["refused"], &sets].concat(), 1);
    assert!(
        refused.contains("readings that are missing") && refused.contains("gauge.csv"),
        "{refused}"
    );
}

#[test]
fn another_receivers_track_takes_the_place_of_the_recorders() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    // The true way of the boat, a second late and written as an autopilot does.
    let truth = fs::read_to_string(folder.join("pond.truth.csv")).unwrap();
    let start_s = 1_634_000_000.0;
    let places: Vec<(f64, f64, f64)> = truth
        .lines()
        .skip(1)
        .map(|row| {
            let value = |column| row.split(',').nth(column).unwrap().parse().unwrap();
            (value(1), value(2), value(3))
        })
        .collect();
    let mut track = "timestamp,lat,lon\n".to_owned();
    for (time_s, lon, lat) in &places {
        track += &format!("{:.3},{lat:.9},{lon:.9}\n", start_s + time_s - 1.0);
    }
    fs::write(folder.join("rtk.csv"), track).unwrap();
    let process = ["process", "pond.sl2", "--no-objects", "--products", "depth", "-o"];
    let with = ["--track", "rtk.csv", "--set", "track.offset_s=1"];
    run(folder, &[&process[..], &["own"]].concat());
    run(folder, &[&process[..], &["rtk"], &with].concat());
    // How far each ping is from where the boat was, metres.
    let off_m = |name: &str| {
        let text = fs::read_to_string(folder.join(name).join("points/first_returns.csv")).unwrap();
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(1)
            .map(|row| {
                row.split(',').take(4).map(|value| value.parse().unwrap_or(f64::NAN)).collect()
            })
            .collect();
        let mut off: Vec<f64> = rows
            .iter()
            .zip(&places)
            .map(|(row, (_, lon, lat))| {
                let east_m = (row[2] - lon) * 111_320.0 * lat.to_radians().cos();
                east_m.hypot((row[3] - lat) * 110_900.0)
            })
            .collect();
        // The first and the last ping may lie a millisecond beyond the track.
        off.retain(|off_m| off_m.is_finite());
        assert!(off.len() + 2 >= places.len());
        off.sort_by(f64::total_cmp);
        off[off.len() * 9 / 10]
    };
    let [own, rtk] = ["own", "rtk"].map(off_m);
    // What is left is the smoothing of the track in its turn.
    assert!(rtk < 0.12 && own > 2.0 * rtk, "{own} {rtk}");
    let report = json(&folder.join("rtk/report.json"));
    assert!(report["statement"].to_string().contains("rtk.csv, 1 s later"));
    assert_eq!(report["inputs"].as_array().unwrap().len(), 2);
    // Beside its products it would be written over.
    fs::copy(folder.join("rtk.csv"), folder.join("rtk/track.csv")).unwrap();
    let over = ["rtk", "--track", "rtk/track.csv"];
    let refused = refusal(folder, &[&process[..], &over].concat(), 1);
    assert!(refused.contains("written over"), "{refused}");
    let late = ["late", "--track", "rtk.csv", "--set", "track.offset_s=9000"];
    assert!(refusal(folder, &[&process[..], &late].concat(), 1).contains("covers no ping"));
}

#[test]
fn residuals_show_the_choices_the_crosslines_and_what_they_depend_on() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::write(folder.join("scene.toml"), "[track]\nlength_m = 25.0\ncross_length_m = 25.0\n")
        .unwrap();
    run(folder, &["simulate", "scene.toml", "-o", "pond", "--seed", "4"]);
    run(folder, &["process", "pond.sl2", "--no-objects", "--products", "residuals", "-o", "out"]);
    let record = json(&folder.join("out/quality/residuals.json"));
    let number = |value: &Value| value.as_f64().expect("a number");
    // Every geometry with every calibration, and the one in force gives the figures of the
    // comparison itself.
    let choices = record["choices"].as_array().unwrap();
    assert_eq!(choices.len(), 16);
    let in_force: Vec<&Value> =
        choices.iter().filter(|choice| choice["in_force"] == true).collect();
    assert_eq!(in_force.len(), 1);
    assert_eq!(in_force[0]["geometry"], "slope");
    let of_all = &record["comparisons"][0];
    for (key, tolerance) in [("n", 3.5), ("mean_m", 2e-3), ("sd_m", 2e-3), ("p95_m", 2e-3)] {
        let off = number(&in_force[0][key]) - number(&of_all[key]);
        assert!(off.abs() < tolerance, "{key}: {off}");
    }
    // The published geometry is too shallow by 1 - cos 16 degrees of its own depth.
    let median = |geometry: &str| {
        let is = |choice: &&Value| {
            choice["geometry"] == geometry && choice["calibration"] == "flat_spot, factor"
        };
        number(&choices.iter().find(is).unwrap()["median_m"])
    };
    let shallow_m = median("published") - median("nadir");
    assert!((0.06..0.14).contains(&shallow_m), "{shallow_m}");
    // Each table and the histogram hold every difference once.
    let n = number(&of_all["n"]);
    let tables = &record["side_scan"];
    for table in ["by_depth_m", "by_across_m", "by_heading_deg"] {
        let bins = tables[table].as_array().unwrap();
        let sum: f64 = bins.iter().map(|bin| number(&bin["n"])).sum();
        assert!(bins.len() > 1 && (sum - n).abs() < 0.5, "{table}: {sum} of {n}");
    }
    let histogram = &tables["histogram"];
    let counts: f64 = histogram["counts"].as_array().unwrap().iter().map(number).sum();
    assert!((counts + number(&histogram["below"]) + number(&histogram["above"]) - n).abs() < 0.5);
    // Two lines and two across.
    let crosslines = &record["crossline_analysis"];
    assert!((4.0..=6.0).contains(&number(&crosslines["n"])), "{crosslines}");
    assert!(number(&crosslines["rms_m"]) < 0.08);
    let first = &crosslines["list"][0];
    assert!(number(&first["time_s"][0]) < number(&first["time_s"][1]));
    assert!((number(&first["lon"]) + 82.11).abs() < 1e-3);
}

/// Two missions over one bed: the lines of the second lie between those of the first, its boat
/// hangs 30 cm higher over the ground, and it sails a day later.
fn simulate_two(folder: &Path) {
    for (name, seed, spacing_m, depth_m, start_s) in
        [("a", "1", 8.0, 2.6, 0), ("b", "2", 5.0, 2.9, 86_400)]
    {
        let scene = format!(
            "start_unix_s = {}\n[bed]\nseed = 9\nmean_depth_m = {depth_m}\n[track]\nlength_m = 25.0\ncross_length_m = 20.0\nspacing_m = {spacing_m:.1}\n",
            1_634_000_000 + start_s
        );
        // The level area is as deep in both unless it is moved too.
        let scene = format!(
            "{scene}[bed.terrace]\neast_m = 8.0\nnorth_m = 0.0\nlength_m = 10.0\nwidth_m = 20.0\ndepth_m = {:.1}\nedge_m = 6.0\n",
            depth_m - 0.1
        );
        fs::write(folder.join("scene.toml"), scene).unwrap();
        let simulate = ["simulate", "scene.toml", "-o", name, "--seed", seed];
        run(folder, &simulate);
    }
}

#[test]
fn several_logs_are_one_survey() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulate_two(folder);
    let process = ["process", "a.sl2", "b.sl2", "--adjust", "--no-objects"];
    let some = ["--products", "cloud,track,depth,isobaths,mosaic", "-o", "out"];
    let said = run(folder, &[&process[..], &some].concat());
    let offset = said.split("a: height offset ").nth(1).expect(&said);
    let offset_m: f64 = offset.split(" +-").next().expect(&said).parse().expect(&said);
    assert!((offset_m + 0.15).abs() < 0.005, "{said}");
    let out = folder.join("out");
    assert_made(&out, &DEPTH, true);
    assert_made(&out, &ISOBATHS, true);
    let others = [
        "points/cloud.copc.laz",
        "points/cloud.xyz",
        "track/track.gpx",
        "track/footprint.kmz",
        "mosaic/mosaic.tif",
    ];
    assert_made(&out, &others, true);
    let record = json(&out.join("report.json"));
    let logs = record["logs"]["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 2);
    for (log, (name, true_m)) in logs.iter().zip([("a", -0.15), ("b", 0.15)]) {
        assert_eq!(log["log"], name);
        assert_eq!(log["inputs"][0]["file"], format!("{name}.sl2"));
        // A few crossings with 3 cm of noise and fixes rounded to a metre.
        assert!((log["offset_m"].as_f64().unwrap() - true_m).abs() < 0.03, "{log}");
        assert!((log["height_offset_in_force_m"].as_f64().unwrap() - true_m).abs() < 0.03);
        assert!(log["statement"].as_str().unwrap().contains("height offset"));
        let found = &log["against_the_others"];
        assert!(found["n"].as_u64().unwrap() > 500, "{found}");
        assert!(found["median_m"].as_f64().unwrap().abs() < 0.05, "{found}");
        assert!(found["p95_m"].as_f64().unwrap() < 0.3, "{found}");
    }
    let between = &record["logs"]["crosslines"]["between_logs"];
    assert!(between["n"].as_u64().unwrap() >= 4, "{between}");
    assert!(between["rms_m"].as_f64().unwrap() < 0.1, "{between}");
    // Every table says which log.
    for (table, least) in [("points/cloud.csv", 2000), ("points/first_returns.csv", 1000)] {
        let text = fs::read_to_string(out.join(table)).unwrap();
        assert!(text.starts_with("log,"), "{table}");
        for log in ["\na,", "\nb,"] {
            assert!(text.matches(log).count() > least / 2, "{table} {log}");
        }
    }
    let counted = |log: &Value| log["counts"]["pings"].as_u64().unwrap();
    assert_eq!(counted(&record), logs.iter().map(counted).sum::<u64>());
    assert_eq!(manifest(&out)["inputs"].as_array().unwrap().len(), 2);
    // The map of both lies on that of each but for half of their difference, and reaches farther.
    run(
        folder,
        &[
            "process",
            "a.sl2",
            "b.sl2",
            "--each",
            "--no-objects",
            "--products",
            "depth",
            "-o",
            "each",
        ],
    );
    for (map, half_m) in [("each/a/depth/depth.tif", 0.15), ("each/b/depth/depth.tif", -0.15)] {
        let args = ["compare", "out/depth/depth.tif", map, "--json", "--radius", "0.4"];
        let found: Value = serde_json::from_str(&run(folder, &args)).expect("JSON");
        // Measured minus reference elevation: the first log's map is the shallower one.
        assert!((found["median_m"].as_f64().unwrap() + half_m).abs() < 0.04, "{found}");
        assert!(found["unmatched"].as_u64().unwrap() > 0, "{found}");
    }
}

#[test]
fn the_same_bytes_under_another_name_are_taken_once() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    run(folder, &["simulate", "-o", "pond"]);
    fs::copy(folder.join("pond.sl2"), folder.join("copy.sl2")).unwrap();
    let options = ["--no-objects", "--products", "cloud,depth", "-o"];
    let warned = stderr_of(
        folder,
        &[&["process", "pond.sl2", "copy.sl2"], &options[..], &["both"]].concat(),
    );
    assert!(warned.contains("same bytes as pond") && warned.contains("copy.sl2"), "{warned}");
    run(folder, &[&["process", "pond.sl2"], &options[..], &["one"]].concat());
    // What is left is one log, and its files are those of one log to the byte.
    for file in [
        "points/cloud.csv",
        "points/first_returns.csv",
        "points/cloud.copc.laz",
        "depth/depth.tif",
        "report.json",
    ] {
        let [both, single] =
            ["both", "one"].map(|out| fs::read(folder.join(out).join(file)).unwrap());
        assert!(both == single, "{file}");
    }
}

#[test]
fn a_log_without_a_point_says_so_and_writes_no_cloud() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let mut frames = handmade::survey_frames(40);
    for frame in &mut frames {
        // It lies still, and the sounder finds no bottom.
        (frame.xy_m, frame.depth_ft) = ((-9_000_000, 3_400_000), 0.0);
    }
    fs::write(folder.join("still.sl2"), handmade::sl2(&frames)).unwrap();
    let process = ["process", "still.sl2", "--no-objects", "-o", "out"];
    let warned = stderr_of(folder, &process);
    assert!(warned.contains("no cloud: there is no point"), "{warned}");
    let out = folder.join("out");
    assert_made(&out, &["points/cloud.csv", "report.json", "report.html"], true);
    for cloud in ["points/cloud.copc.laz", "points/cloud.ply", "points/cloud.xyz"] {
        assert!(!out.join(cloud).exists(), "{cloud}");
    }
    let warnings = json(&out.join("report.json"))["warnings"].to_string();
    assert!(warnings.contains("no cloud"), "{warnings}");
}
