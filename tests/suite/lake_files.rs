//! The files of a survey of several logs, written without a window, against what is known of the lake.

use crate::cli::run;
use crate::many_logs::{HIGHER_M, sailed, write_logs};
use bathyscope::geo::{LocalFrame, LonLat};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Distance between the points of a known bed, metres.
const STEP_M: f64 = 0.5;

fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("a file that was written");
    serde_json::from_str(&text).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number: {value}"))
}

/// The bed below the transducer of the first log, as points of longitude, latitude and elevation around a place.
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
    let record = json(&folder.join("cloud.ply.json"));
    let at = &record["crs"]["origin"];
    LonLat {
        lon_deg: number(&at["lon"]),
        lat_deg: number(&at["lat"]),
    }
}

#[test]
fn points_of_all_logs_are_held_against_a_reference() {
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

    // Each log is off by the height that its transducer hangs higher over the bed, or with offsets by the mean of all.
    let raw_m = [HIGHER_M[0], HIGHER_M[1], HIGHER_M[2]];
    let adjusted_m = [raw_m.iter().sum::<f64>() / 3.0; 3];
    for (out, higher_m) in [("raw", raw_m), ("adjusted", adjusted_m)] {
        let out = folder.join(out);
        let compared = json(&out.join("comparison.json"));
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
        assert_eq!(
            (&all["source"], &all["n"]),
            (&"all points".into(), &compared["n"])
        );
        let table = fs::read_to_string(out.join("comparison.csv")).expect("a table");
        assert!(table.starts_with("log,source,ping,"), "{}", &table[..40]);
        for log in each {
            let name = log["log"].as_str().expect("a name");
            let lines = table.matches(&format!("\n{name},")).count();
            assert_eq!(lines as f64, number(&log["n"]), "{name}");
        }
    }
    let record = json(&folder.join("raw/comparison.csv.json"));
    let inputs = record["inputs"].as_array().expect("inputs");
    assert_eq!(inputs.len(), 4, "three logs and the bed: {record}");
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
    let record = |out: &str| json(&folder.join(out).join("residuals.json"));
    let [raw, adjusted, alone] = ["raw", "adjusted", "one"].map(record);

    let spread = |record: &Value| number(&record["crossline_analysis"]["between_logs"]["sd_m"]);
    eprintln!(
        "between logs: sd {:.3} m, with offsets {:.3} m",
        spread(&raw),
        spread(&adjusted)
    );
    assert!(spread(&raw) > 0.2 && spread(&adjusted) < 0.1);
    let listed = raw["crossline_analysis"]["list"]
        .as_array()
        .expect("crossings");
    let is_between = |one: &&Value| one["logs"][0] != one["logs"][1];
    let between = &raw["crossline_analysis"]["between_logs"];
    let count = listed.iter().filter(is_between).count();
    assert_eq!(count as f64, number(&between["n"]));
    let of_two = |one: &&Value| one["logs"] == serde_json::json!(["lake-0", "lake-1"]);
    let of_two: Vec<f64> = (listed.iter().filter(of_two))
        .map(|one| number(&one["difference_m"]))
        .collect();
    // The second hangs higher over the bed, so that its elevations are lower.
    let mean_m = of_two.iter().sum::<f64>() / of_two.len() as f64;
    assert!(
        (mean_m - (HIGHER_M[0] - HIGHER_M[1])).abs() < 0.05,
        "{of_two:?}"
    );

    // All logs together see what their heights differ by; each by itself is what it is alone.
    let p95 = |record: &Value| number(&record["comparisons"][0]["p95_m"]);
    assert!(
        p95(&raw) > 1.5 * p95(&adjusted),
        "{} {}",
        p95(&raw),
        p95(&adjusted)
    );
    let of_log = &raw["logs"][1];
    assert_eq!(of_log["log"], "lake-1");
    for key in ["side_scan", "choices"] {
        assert_eq!(of_log[key].is_null(), alone[key].is_null(), "{key}");
    }
    let n = |record: &Value| number(&record["comparisons"][0]["n"]);
    assert_eq!(n(of_log), n(&alone));
    assert!((p95(of_log) - p95(&alone)).abs() < 1e-3);
    assert_eq!(
        of_log["crossline_analysis"]["n"],
        alone["crossline_analysis"]["n"]
    );
    let report = |out: &str| json(&folder.join(out).join("report.json"));
    let [all, one] = [report("raw"), report("one")].map(|report| report["residuals"].clone());
    let of_logs = report("raw")["logs"]["logs"].clone();
    let counted: f64 = (0..3)
        .map(|log| number(&of_logs[log]["residuals"]["n"]))
        .sum();
    assert_eq!(number(&all["n"]), counted);
    assert_eq!(of_logs[1]["residuals"]["n"], one["n"]);
    assert!(
        of_logs[1]["own_settings"]
            .as_object()
            .is_some_and(|own| own.is_empty())
    );
    let adjusted = report("adjusted")["logs"]["logs"].clone();
    let own = adjusted[1]["own_settings"]["height_offset_m"].clone();
    assert_eq!(own, adjusted[1]["height_offset_in_force_m"]);
}
