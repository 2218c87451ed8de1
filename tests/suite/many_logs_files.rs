//! The files of a survey of several logs over one lake, written without a window, against the known
//! bed.

use crate::cli::{refusal, run};
use crate::many_logs::{HIGHER_M, OBJECTS, sailed, true_boxes, true_offsets_m, write_logs};
use crate::support::{manifest, manifest_entry};
use bathyscope_log::formats;
use bathyscope_log::support::geo::{LocalFrame, LonLat};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Identity;
use bathyscope_objects::review::{Edit, Review};
use bathyscope_products::outputs::{OUTPUT_FILES, Product, When};
use bathyscope_simulation::Scene;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Distance between the points of a known bed, metres.
const STEP_M: f64 = 0.5;

fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("a file that was written");
    serde_json::from_str(&text).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number: {value}"))
}

/// The bed below the transducer of the first log, as points of longitude, latitude and elevation
/// around a place.
fn write_bed(path: &Path, at: LonLat) {
    let frame = LocalFrame::new(at);
    let mut text = "lon,lat,z_m\n".to_owned();
    for (column, row) in (-100..=100).flat_map(|x| (-100..=100).map(move |y| (x, y))) {
        let [east_m, north_m] = [column, row].map(|step| STEP_M * f64::from(step));
        let place = frame.to_lon_lat(east_m, north_m);
        let z_m = -sailed(0).bed_depth_m(east_m, north_m);
        text += &format!("{:.9},{:.9},{z_m:.4}\n", place.lon_deg, place.lat_deg);
    }
    fs::write(path, text).expect("a bed");
}

/// The place that the local metres of a run count from.
fn origin(folder: &Path) -> LonLat {
    let record = manifest_entry(folder, "points/cloud.ply");
    let at = &record["crs"]["origin"];
    LonLat { lon_deg: number(&at["lon"]), lat_deg: number(&at["lat"]) }
}

#[test]
fn points_of_all_logs_are_compared_with_a_reference() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    write_logs(folder, 3);
    let logs = "process lake-0.sl2 lake-1.sl2 lake-2.sl2 --no-objects --products";
    let process = |rest: &str| {
        let args = format!("{logs} {rest}");
        run(folder, &args.split(' ').collect::<Vec<_>>());
    };
    process("cloud -o cloud");
    write_bed(&folder.join("bed.csv"), origin(&folder.join("cloud")));
    process("residuals --reference bed.csv:lon,lat,z_m -o raw");
    process("residuals --reference bed.csv:lon,lat,z_m --adjust -o adjusted");

    // Each log is off by the height that its transducer hangs higher over the bed, or with offsets
    // by the mean of all.
    let raw_m = [HIGHER_M[0], HIGHER_M[1], HIGHER_M[2]];
    let adjusted_m = [raw_m.iter().sum::<f64>() / 3.0; 3];
    for (out, higher_m) in [("raw", raw_m), ("adjusted", adjusted_m)] {
        let out = folder.join(out);
        let compared = json(&out.join("quality/comparison.json"));
        let each = compared["logs"].as_array().expect("logs");
        assert_eq!(each.len(), 3);
        for (log, higher_m) in each.iter().zip(higher_m) {
            let off_m = number(&log["median_m"]) + higher_m;
            eprintln!("{}: off by {off_m:+.4} m", log["log"]);
            assert!(off_m.abs() < 0.02, "{log}");
        }
        let counted: f64 = each.iter().map(|log| number(&log["n"])).sum();
        assert_eq!(counted, number(&compared["n"]));
        let all = &compared["sources"][0];
        assert_eq!((&all["source"], &all["n"]), (&"all points".into(), &compared["n"]));
        let table = fs::read_to_string(out.join("quality/comparison.csv")).expect("a table");
        assert!(table.starts_with("log,source,ping,"), "{}", &table[..40]);
        for log in each {
            let name = log["log"].as_str().expect("a name");
            let lines = table.matches(&format!("\n{name},")).count();
            assert_eq!(lines as f64, number(&log["n"]), "{name}");
        }
    }
    let logs = manifest(&folder.join("raw"));
    assert_eq!(logs["inputs"].as_array().map(Vec::len), Some(3), "{logs}");
    let record = manifest_entry(&folder.join("raw"), "quality/comparison.csv");
    let bed = record["more_inputs"].as_array().expect("inputs");
    assert_eq!(bed.len(), 1, "the bed: {record}");
}

#[test]
fn residuals_are_those_of_all_logs_with_each_log_beside_them() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    write_logs(folder, 3);
    let process = |rest: &str| {
        let args = format!("process {rest} --no-objects --products residuals");
        run(folder, &args.split(' ').collect::<Vec<_>>());
    };
    process("lake-0.sl2 lake-1.sl2 lake-2.sl2 -o raw");
    process("lake-0.sl2 lake-1.sl2 lake-2.sl2 --adjust -o adjusted");
    process("lake-1.sl2 -o one");
    let record = |out: &str| json(&folder.join(out).join("quality/residuals.json"));
    let [raw, adjusted, alone] = ["raw", "adjusted", "one"].map(record);

    let spread = |record: &Value| number(&record["crossline_analysis"]["between_logs"]["sd_m"]);
    eprintln!("between logs: sd {:.3} m, with offsets {:.3} m", spread(&raw), spread(&adjusted));
    assert!(spread(&raw) > 0.2 && spread(&adjusted) < 0.1);
    let listed = raw["crossline_analysis"]["list"].as_array().expect("crossings");
    let is_between = |crossing: &&Value| crossing["logs"][0] != crossing["logs"][1];
    let between = &raw["crossline_analysis"]["between_logs"];
    let count = listed.iter().filter(is_between).count();
    assert_eq!(count as f64, number(&between["n"]));
    let of_two = |crossing: &&Value| crossing["logs"] == serde_json::json!(["lake-0", "lake-1"]);
    let of_two: Vec<f64> =
        (listed.iter().filter(of_two)).map(|crossing| number(&crossing["difference_m"])).collect();
    // The second hangs higher over the bed, so that its elevations are lower.
    let mean_m = of_two.iter().sum::<f64>() / of_two.len() as f64;
    assert!((mean_m - (HIGHER_M[0] - HIGHER_M[1])).abs() < 0.05, "{of_two:?}");

    // All logs together see what their heights differ by; each by itself is what it is alone.
    let p95 = |record: &Value| number(&record["comparisons"][0]["p95_m"]);
    assert!(p95(&raw) > 1.5 * p95(&adjusted), "{} {}", p95(&raw), p95(&adjusted));
    let of_log = &raw["logs"][1];
    assert_eq!(of_log["log"], "lake-1");
    for key in ["side_scan", "choices"] {
        assert_eq!(of_log[key].is_null(), alone[key].is_null(), "{key}");
    }
    let n = |record: &Value| number(&record["comparisons"][0]["n"]);
    assert_eq!(n(of_log), n(&alone));
    assert!((p95(of_log) - p95(&alone)).abs() < 1e-3);
    assert_eq!(of_log["crossline_analysis"]["n"], alone["crossline_analysis"]["n"]);
    let report = |out: &str| json(&folder.join(out).join("report.json"));
    let [all, single] = [report("raw"), report("one")].map(|report| report["residuals"].clone());
    let of_logs = report("raw")["logs"]["logs"].clone();
    let counted: f64 = (0..3).map(|log| number(&of_logs[log]["residuals"]["n"])).sum();
    assert_eq!(number(&all["n"]), counted);
    assert_eq!(of_logs[1]["residuals"]["n"], single["n"]);
    assert!(of_logs[1]["own_settings"].as_object().is_some_and(|own| own.is_empty()));
    let adjusted = report("adjusted")["logs"]["logs"].clone();
    let own = adjusted[1]["own_settings"]["height_offset_m"].clone();
    assert_eq!(own, adjusted[1]["height_offset_in_force_m"]);
}

#[test]
fn ten_logs_are_one_set_of_products_with_their_heights_to_a_centimetre() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::create_dir(folder.join("logs")).expect("a folder");
    write_logs(&folder.join("logs"), HIGHER_M.len());
    let process = "process logs --adjust --no-objects --set points.las=true --set surface.swath=always -o out";
    run(folder, &process.split(' ').collect::<Vec<_>>());
    let out = folder.join("out");
    // Nothing was searched, compared or reviewed.
    let others = [When::Searched, When::Listed, When::Compared, When::Chosen(Product::Targets)];
    let is_asked = |when| !others.contains(&when);
    for row in OUTPUT_FILES.iter().filter(|row| is_asked(row.when)) {
        assert!(out.join(row.name).is_file(), "{}", row.name);
    }
    assert_eq!(manifest(&out)["logs"], 10);
    let report = json(&out.join("report.json"));
    let logs = report["logs"]["logs"].as_array().expect("logs");
    assert_eq!(logs.len(), HIGHER_M.len());
    for (log, true_m) in logs.iter().zip(true_offsets_m(HIGHER_M.len())) {
        let off_m = number(&log["offset_m"]) - true_m;
        eprintln!("{}: off by {off_m:+.4} m", log["log"]);
        assert!(off_m.abs() < 0.01, "{log}");
        let in_force_m = number(&log["height_offset_in_force_m"]);
        assert!((in_force_m - number(&log["offset_m"])).abs() < 1e-4, "{log}");
    }
    let between = &report["logs"]["crosslines"]["between_logs"];
    assert!(number(&between["median_m"]).abs() < 0.01, "{between}");

    // The page has every log with its height.
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("lake-0 to lake-9 (10 logs)"));
    let table = page.split("<h2>The logs</h2>").nth(1).expect("a table");
    let table = table.split("</table>").next().expect("its end");
    for (index, log) in logs.iter().enumerate() {
        let row = format!("<td class=\"text\">lake-{index}</td>");
        let row = table.split(&row).nth(1).expect("a row");
        let offset = format!("{:+.3}", number(&log["offset_m"])).replace('-', "\u{2212}");
        assert!(row.split("</tr>").next().is_some_and(|row| row.contains(&offset)), "{offset}");
    }
    assert_eq!(page.matches("<h3>lake-").count(), 10);
    assert!(!page.contains(&folder.display().to_string()));
}

/// Keeps the boxes that a labeller draws next to a log.
fn draw_boxes(folder: &Path, index: usize) -> usize {
    let bytes = sailed(index).sl2_bytes();
    let survey = formats::open_bytes("lake.sl2", bytes, &Progress::new()).expect("a log");
    let mut review = Review::new(Identity::of(&survey), vec!["block".to_owned()]);
    let marks = true_boxes(index, &survey);
    for mark in &marks {
        let edit = Edit::Add { mark: mark.clone(), class: 0 };
        review = review.apply(&edit).expect("a box");
    }
    let path = folder.join(format!("lake-{index}.review.json"));
    fs::write(path, review.to_json() + "\n").expect("a review");
    marks.len()
}

#[test]
fn objects_that_several_logs_saw_are_one_in_the_files() {
    const LOGS: usize = 6;
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let logs = folder.join("logs");
    fs::create_dir(&logs).expect("a folder");
    write_logs(&logs, LOGS);
    let boxes: usize = (0..LOGS).map(|index| draw_boxes(&logs, index)).sum();
    let said = run(folder, &["review", "logs", "-o", "out"]);
    assert!(said.contains(&format!("Wrote {boxes} boxes")), "{said}");
    // The lake's middle, which places of objects count from.
    let lake = Scene::default();
    let frame = LocalFrame::new(LonLat { lon_deg: lake.longitude_deg, lat_deg: lake.latitude_deg });
    let mut table = csv::Reader::from_path(folder.join("out/detections.csv")).expect("a table");
    let rows = table.deserialize::<BTreeMap<String, String>>();
    let rows: Vec<_> = rows.map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), boxes);
    // By true object: how often each number was given, and by how many logs.
    let mut given: [BTreeMap<u64, Vec<String>>; 4] = Default::default();
    for row in &rows {
        let degrees = |name: &str| row[name].parse().expect("all of them have a place");
        let position = LonLat { lon_deg: degrees("lon"), lat_deg: degrees("lat") };
        let [east_m, north_m] = frame.to_enu(position);
        let away_m = |place: &[f64; 2]| (place[0] - east_m).hypot(place[1] - north_m);
        let nearest =
            (0..OBJECTS.len()).min_by(|a, b| away_m(&OBJECTS[*a]).total_cmp(&away_m(&OBJECTS[*b])));
        let nearest = nearest.expect("four objects");
        assert!(away_m(&OBJECTS[nearest]) < 3.0, "{row:?}");
        let number = row["object"].parse().expect("a number");
        given[nearest].entry(number).or_default().push(row["log"].clone());
    }
    let mut numbers = Vec::new();
    for (object, given) in given.iter().enumerate() {
        let all: usize = given.values().map(Vec::len).sum();
        let (number, logs) = given.iter().max_by_key(|(_, logs)| logs.len()).expect("seen");
        let mut of_logs = logs.clone();
        of_logs.dedup();
        eprintln!("object {object}: {} of {all} sightings, {} logs", logs.len(), of_logs.len());
        assert!(of_logs.len() >= 4 && 10 * logs.len() >= 9 * all, "{given:?}");
        numbers.push(*number);
    }
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), OBJECTS.len(), "no two objects are one");
    // Each log has its own review and pictures; another run reads them.
    for index in 0..LOGS {
        let out = folder.join("out");
        assert!(out.join(format!("lake-{index}.review.json")).is_file());
        assert!(out.join(format!("dataset/lake-{index}/train.json")).is_file());
    }
    let page = ["process", "logs", "--no-objects", "--products", "report", "-o", "page"];
    let files: Vec<String> =
        (0..LOGS).map(|index| format!("out/lake-{index}.review.json")).collect();
    let reviews = files.iter().flat_map(|file| ["--review", file.as_str()]);
    let args: Vec<&str> = page.into_iter().chain(reviews).collect();
    run(folder, &args);
    let page = fs::read_to_string(folder.join("page/report.html")).expect("a page");
    assert!(page.contains(&format!("0 accepted, {boxes} added")));
    assert!(page.contains(&format!("{boxes} boxes on ")) && page.contains(" passes</td>"));
    assert!(page.contains("lake-0; lake-1; lake-2"), "the logs that saw an object");
    let strange = ["process", "logs/lake-0.sl2", "--review", "out/lake-1.review.json", "-o", "no"];
    assert!(refusal(folder, &strange, 1).contains("another log"));
}

#[test]
fn a_search_goes_over_all_logs_and_says_which() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    write_logs(folder, 2);
    let search = "--set detector.score=0.05 --products track -o";
    let process = |logs: &str, out: &str| {
        let args = format!("process {logs} {search} {out}");
        run(folder, &args.split(' ').collect::<Vec<_>>())
    };
    let said = process("lake-0.sl2 lake-1.sl2", "both");
    assert!(said.contains("proposed by the detector: "), "{said}");
    process("lake-1.sl2", "second");
    let rows = |out: &str| -> Vec<csv::StringRecord> {
        let path = folder.join(out).join("objects/detections.csv");
        let mut table = csv::Reader::from_path(path).expect("a table");
        table.records().map(|row| row.expect("a row")).collect()
    };
    let (both, second) = (rows("both"), rows("second"));
    let of = |name: &'static str| both.iter().filter(move |row| &row[0] == name);
    assert!(of("lake-0").count() > 0 && !second.is_empty());
    // Side and pings of a box, which stand one column later.
    let joint: Vec<Vec<&str>> =
        of("lake-1").map(|row| row.iter().skip(3).take(6).collect()).collect();
    let alone: Vec<Vec<&str>> =
        second.iter().map(|row| row.iter().skip(2).take(6).collect()).collect();
    assert_eq!(joint, alone, "each log is searched as it is alone");
    let ids: Vec<usize> = both.iter().map(|row| row[1].parse().expect("a number")).collect();
    assert_eq!(ids, (1..=both.len()).collect::<Vec<_>>());
    let chips = fs::read_dir(folder.join("both/objects/chips")).expect("chips").count();
    assert_eq!(chips, both.len());
    assert_eq!(manifest(&folder.join("both"))["logs"], 2);
}

#[test]
fn groups_of_logs_are_compared_with_each_other() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    for (group, logs) in [("monday", [0, 1]), ("tuesday", [5, 6])] {
        fs::create_dir(folder.join(group)).expect("a folder");
        for index in logs {
            let path = folder.join(group).join(format!("lake-{index}.sl2"));
            fs::write(path, sailed(index).sl2_bytes()).expect("a log");
        }
    }
    let compare = ["compare", "monday", "tuesday", "--by", "surface", "--json"];
    let found = run(folder, &[&compare[..], &["-o", "points.csv"]].concat());
    let found: Value = serde_json::from_str(&found).expect("JSON");
    assert_eq!(found["reference"]["inputs"].as_array().map(Vec::len), Some(2));
    let medians_m: Vec<f64> = (found["logs"].as_array().expect("logs").iter())
        .map(|log| number(&log["median_m"]))
        .collect();
    // Both are compared with the same surface, so the second is lower by what it hangs higher over
    // the bed.
    let lower_m = medians_m[0] - medians_m[1];
    eprintln!("apart by {lower_m:.3} m");
    assert!((lower_m - (HIGHER_M[1] - HIGHER_M[0])).abs() < 0.05, "{found}");
    let table = fs::read_to_string(folder.join("points.csv")).expect("a table");
    assert!(table.starts_with("log,source,") && table.contains("\nlake-1,"));
    let said = run(folder, &compare[..5]);
    assert!(said.contains("\nlake-0: n ") && said.contains("\nlake-1: n "), "{said}");

    let process = "process monday --reference tuesday --no-objects --products residuals -o out";
    run(folder, &process.split(' ').collect::<Vec<_>>());
    let written = json(&folder.join("out/quality/comparison.json"));
    assert_eq!((&written["n"], &written["mean_m"]), (&found["n"], &found["mean_m"]));
}
