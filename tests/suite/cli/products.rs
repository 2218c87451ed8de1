//! The maps of `bathyscope process`: which are made, and that they agree with each other.

use super::{refusal, run, simulated};
use serde_json::Value;
use std::fs;
use std::path::Path;

const DEPTH: [&str; 3] = ["depth.tif", "uncertainty.tif", "distance.tif"];
const ISOBATHS: [&str; 3] = ["isobaths.geojson", "depth_areas.geojson", "storage.csv"];

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
    run(
        folder,
        &[&process[..], &["some", "--products", "depth,residuals"]].concat(),
    );
    let some = folder.join("some");
    assert_made(&some, &DEPTH, true);
    assert_made(&some, &["residuals.json", "cloud.csv", "report.json"], true);
    assert_made(&some, &ISOBATHS, false);
    assert_made(&some, &["mosaic.tif"], false);
    let wrong = [&process[..], &["other", "--products", "dept"]].concat();
    assert!(refusal(folder, &wrong, 2).contains("dept"));
    let wrong = [&process[..], &["other", "--set", "surface.max_gap_m=0"]].concat();
    assert!(refusal(folder, &wrong, 1).contains("surface.max_gap_m"));
}

#[test]
fn isobaths_areas_storage_and_residuals_agree() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let mut process = vec!["process", "pond.sl2", "--no-objects", "-o", "out"];
    process.extend([
        "--products",
        "isobaths,residuals",
        "--set",
        "surface.cell_m=0.2",
    ]);
    process.extend([
        "--set",
        "isobaths.interval_m=0.1",
        "--set",
        "water_level_m=0.5",
    ]);
    run(folder, &process);
    let out = folder.join("out");

    let lines = json(&out.join("isobaths.geojson"));
    let lines = lines["features"].as_array().expect("features");
    assert!(!lines.is_empty());
    for line in lines {
        let depth_m = line["properties"]["depth_m"].as_f64().expect("a depth");
        assert!(
            (depth_m * 10.0 - (depth_m * 10.0).round()).abs() < 1e-9,
            "{depth_m}"
        );
    }

    // The areas cover what the storage table says is deeper than the shallowest place, but for the cells at the edge.
    let areas = json(&out.join("depth_areas.geojson"));
    let areas = areas["features"].as_array().expect("features");
    let covered: f64 = areas
        .iter()
        .map(|area| area["properties"]["area_m2"].as_f64().unwrap())
        .sum();
    let table = fs::read_to_string(out.join("storage.csv")).expect("a table");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| {
            row.split(',')
                .map(|value| value.parse().expect("a number"))
                .collect()
        })
        .collect();
    assert!(
        covered > 0.5 * rows[0][1] && covered < rows[0][1],
        "{covered} of {}",
        rows[0][1]
    );
    assert!(
        rows.windows(2)
            .all(|step| step[0][1] >= step[1][1] && step[0][2] >= step[1][2])
    );

    // Side-scan against down-scan is about what the report says of the same pings, the sign turned.
    let record = json(&out.join("residuals.json"));
    let report = json(&out.join("report.json"));
    let by_surface = &record["comparisons"][0];
    assert_eq!(by_surface["source"], "side-scan");
    let median = |one: &Value| one["median_m"].as_f64().expect("a number");
    assert!(
        (median(by_surface) + median(&report["residuals"])).abs() < 0.1,
        "{by_surface}"
    );
    assert_eq!(record["settings"]["water_level_m"], 0.5);
}
