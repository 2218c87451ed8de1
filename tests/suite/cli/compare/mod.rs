//! `bathyscope compare` against numpy and scipy (`make.py` shows how their figures were made).

mod change;

use super::{refusal, run};
use serde_json::Value;
use std::fs;
use std::path::Path;

const MEASURED: &str = "columns.csv:Easting,Northing,Predicted";
const REFERENCE: &str = "columns.csv:RefE,RefN,Elevation";

fn folder_with_columns() -> tempfile::TempDir {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    fs::write(temporary.path().join("columns.csv"), include_str!("columns.csv")).unwrap();
    temporary
}

fn compared(folder: &Path, reference: &str, options: &[&str]) -> Value {
    let mut args = vec!["compare", MEASURED, reference, "--water-level", "1.5", "--json"];
    args.extend(options);
    serde_json::from_str(&run(folder, &args)).expect("JSON on stdout")
}

fn assert_same(found: &Value, expected: &Value) {
    for key in ["n", "unmatched", "mean_m", "median_m", "sd_m", "rms_m", "mae_m", "p95_m"] {
        let [found, expected] = [found, expected].map(|record| record[key].as_f64().unwrap());
        assert!((found - expected).abs() < 1e-9, "{key}: {found} instead of {expected}");
    }
    let orders = found["orders"].as_array().unwrap();
    assert_eq!(orders.len(), 4);
    for order in orders {
        let share = expected["shares"][order["order"].as_str().unwrap()].as_f64().unwrap();
        assert!((order["share"].as_f64().unwrap() - share).abs() < 1e-9, "{order}");
    }
}

#[test]
fn two_column_sets_give_the_figures_of_numpy() {
    let temporary = folder_with_columns();
    let folder = temporary.path();
    let expected: Value = serde_json::from_str(include_str!("expected.json")).unwrap();
    let some = compared(folder, REFERENCE, &[]);
    assert_same(&some, &expected["some"]);
    assert!(some["unmatched"].as_u64().unwrap() > 20);
    assert_same(&compared(folder, REFERENCE, &["--radius", "500"]), &expected["all"]);
    let by_surface = ["--by", "surface", "--max-gap", "500"];
    assert_same(&compared(folder, REFERENCE, &by_surface), &expected["surface"]);
    // A column of depths, turned.
    assert_same(&compared(folder, "columns.csv:RefE,RefN,-Depth", &[]), &expected["some"]);
}

#[test]
fn a_table_for_people_and_a_file_for_the_map() {
    let temporary = folder_with_columns();
    let folder = temporary.path();
    let table = run(folder, &["compare", MEASURED, REFERENCE, "-o", "residuals.csv"]);
    for words in ["up is positive", "without a reference", "median", "S-44 exclusive"] {
        assert!(table.contains(words), "{table}");
    }
    let text = fs::read_to_string(folder.join("residuals.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("x_m,y_m,z_m,reference_z_m,difference_m"));
    for line in lines {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
        assert!((values[2] - values[3] - values[4]).abs() < 1e-12);
    }
}

#[test]
fn degrees_become_metres_and_do_not_mix_with_them() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    // 50 m north and 50 m east of the first point, from the geodesic.
    fs::write(
        folder.join("a.csv"),
        "lon,lat,z_m\n-82.110000000,29.410451090,-2\n-82.109484812,29.409999999,-3\n",
    )
    .unwrap();
    fs::write(folder.join("b.csv"), "lon,lat,z_m\n-82.11,29.41,-2.5\n").unwrap();
    fs::write(folder.join("metres.csv"), "x,y,z\n0,0,-2.5\n").unwrap();
    let at = |radius: &str| {
        let args = ["compare", "a.csv", "b.csv", "--json", "--radius", radius];
        let found: Value = serde_json::from_str(&run(folder, &args)).unwrap();
        found["n"].as_u64().unwrap()
    };
    assert_eq!(at("50.001"), 2);
    let far = refusal(folder, &["compare", "a.csv", "b.csv", "--radius", "49.999"], 1);
    assert!(far.contains("larger distance"), "{far}");
    let mixed = refusal(folder, &["compare", "a.csv", "metres.csv"], 1);
    assert!(mixed.contains("degrees"), "{mixed}");
}

/// The plane of `rasters.py` at the middle of its cells, as x,y,z.
fn plane_csv(header: &str, [west, north]: [f64; 2], cell: f64) -> String {
    let mut text = format!("{header}\n");
    for (row, column) in
        (0..9).flat_map(|row| (0..12).map(move |column| (f64::from(row), f64::from(column))))
    {
        let (x, y) = (west + cell * (column + 0.5), north - cell * (row + 0.5));
        text += &format!("{x:.9},{y:.9},{}\n", -(2.0 + 0.01 * column + 0.003 * row));
    }
    text
}

#[test]
fn cells_of_gdals_rasters_and_points_of_geojson_are_elevations() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::write(folder.join("utm.csv"), plane_csv("x,y,z", [392_000.0, 3_254_000.0], 0.5)).unwrap();
    fs::write(folder.join("degrees.csv"), plane_csv("lon,lat,z", [-82.11, 29.41], 1e-5)).unwrap();
    for (name, bytes, reference) in [
        ("strips.tif", &include_bytes!("strips.tif")[..], "utm.csv"),
        ("tiles.tif", include_bytes!("tiles.tif"), "utm.csv"),
        ("degrees.tif", include_bytes!("degrees.tif"), "degrees.csv"),
    ] {
        fs::write(folder.join(name), bytes).unwrap();
        let args = ["compare", name, reference, "--radius", "0.01", "--json"];
        let found: Value = serde_json::from_str(&run(folder, &args)).unwrap();
        // One cell has no value.
        assert_eq!(found["n"], 107, "{name}");
        assert!(found["rms_m"].as_f64().unwrap() < 1e-6, "{name}: {found}");
        let turned = format!("{name}:x,y,-z");
        let args = ["compare", &turned, reference, "--radius", "0.01", "--json"];
        let found: Value = serde_json::from_str(&run(folder, &args)).unwrap();
        assert!(found["mean_m"].as_f64().unwrap() > 4.0);
    }
    // A raster of a zone and points in degrees meet: both are some metres from each other.
    let mixed = ["compare", "strips.tif", "degrees.tif", "--radius", "100000", "--json"];
    let found: Value = serde_json::from_str(&run(folder, &mixed)).unwrap();
    assert_eq!(found["n"], 107);

    let feature = |coordinates: &str, properties: &str| {
        format!(
            "{{\"type\":\"Feature\",\"geometry\":{{\"type\":\"Point\",\"coordinates\":[{coordinates}]}},\"properties\":{{{properties}}}}}"
        )
    };
    let features = [
        feature("-82.109995,29.409995,-2.1", ""),
        feature("-82.109985,29.409995", "\"depth_m\":2.21"),
        feature("-82.109985,29.409995", ""),
    ];
    let text = format!("{{\"type\":\"FeatureCollection\",\"features\":[{}]}}", features.join(","));
    fs::write(folder.join("points.geojson"), text).unwrap();
    let args = ["compare", "points.geojson", "degrees.csv", "--radius", "0.01", "--json"];
    let found: Value = serde_json::from_str(&run(folder, &args)).unwrap();
    assert_eq!(found["n"], 2);
    // 10 cm and 20 cm deeper than -2.00 and -2.01.
    assert!((found["mean_m"].as_f64().unwrap() + 0.15).abs() < 1e-9, "{found}");
    fs::write(folder.join("broken.tif"), &include_bytes!("strips.tif")[..200]).unwrap();
    let refused = refusal(folder, &["compare", "broken.tif", "utm.csv"], 1);
    assert!(refused.contains("GeoTIFF"), "{refused}");
}

#[test]
fn the_map_of_a_survey_is_held_against_its_own_cloud() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    super::simulated(folder);
    let process = ["process", "pond.sl2", "--no-objects", "--products", "depth", "-o", "out"];
    run(folder, &process);
    // Degrees against the UTM zone that the raster names; a depth against elevations.
    let args = ["compare", "out/depth/depth.tif", "out/points/cloud.csv", "--json"];
    let found: Value = serde_json::from_str(&run(folder, &args)).unwrap();
    assert!(found["n"].as_u64().unwrap() > 50, "{found}");
    assert!(found["median_m"].as_f64().unwrap().abs() < 0.02, "{found}");
    assert!(found["p95_m"].as_f64().unwrap() < 0.5, "{found}");
}
