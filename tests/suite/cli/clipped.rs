//! Isobaths, depth areas and spot soundings that end at an area of `isobaths.clip`.

use super::{refusal, run, stderr_of};
use crate::support::demo_log;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a product")).expect("JSON")
}

/// Longitudes and latitudes of a feature's line, or of the outlines of its polygons.
fn lines_of(feature: &Value) -> Vec<Vec<[f64; 2]>> {
    let coordinates = feature["geometry"]["coordinates"].clone();
    match feature["geometry"]["type"].as_str() {
        Some("LineString") => vec![serde_json::from_value(coordinates).expect("a line")],
        Some("MultiPolygon") => {
            let polygons: Vec<Vec<Vec<[f64; 2]>>> =
                serde_json::from_value(coordinates).expect("polygons");
            polygons.into_iter().flatten().collect()
        }
        _ => vec![vec![serde_json::from_value(coordinates).expect("a place")]],
    }
}

#[test]
fn isobaths_areas_and_spot_soundings_end_at_the_area_that_is_named() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    fs::copy(demo_log(), folder.join("demo.sl2")).unwrap();
    let process = ["process", "demo.sl2", "--no-objects", "--products", "isobaths,geopackage"];
    run(folder, &[&process[..], &["-o", "whole"]].concat());
    let features = |run: &str, name: &str| -> Vec<Value> {
        let path = folder.join(run).join("isobaths").join(name);
        json(&path)["features"].as_array().expect("features").clone()
    };
    let files = ["isobaths.geojson", "depth_areas.geojson", "spot_soundings.geojson"];
    let all: Vec<[f64; 2]> =
        (features("whole", "depth_areas.geojson").iter()).flat_map(lines_of).flatten().collect();
    let ends = |axis: usize| {
        let values = all.iter().map(|at| at[axis]);
        values
            .fold([f64::MAX, f64::MIN], |[least, most], value| [least.min(value), most.max(value)])
    };
    let ([west, east], [south, north]) = (ends(0), ends(1));
    let at = |across: f64, up: f64| [west + across * (east - west), south + up * (north - south)];
    // The western half without an island in its middle.
    let ring =
        |[a, b]: [f64; 2], [c, d]: [f64; 2]| vec![at(a, b), at(c, b), at(c, d), at(a, d), at(a, b)];
    let (shore, island) = (ring([-0.1, -0.1], [0.5, 1.1]), ring([0.2, 0.4], [0.3, 0.6]));
    let area = serde_json::json!({ "type": "Polygon", "coordinates": [shore, island] });
    fs::write(folder.join("shore.geojson"), area.to_string()).unwrap();
    let clip = ["--set", "isobaths.clip=shore.geojson", "-o", "half"];
    run(folder, &[&process[..], &clip].concat());

    let slack = 2e-8;
    let is_within = |[lon, lat]: [f64; 2], slack: f64| {
        let share = [(lon - west) / (east - west), (lat - south) / (north - south)];
        let on_island = (0.2 + slack..0.3 - slack).contains(&share[0])
            && (0.4 + slack..0.6 - slack).contains(&share[1]);
        share[0] <= 0.5 + slack && !on_island
    };
    // Coordinates have eight digits; the demo spans some 1e-3 degrees.
    let share = slack / (east - west).min(north - south);
    for name in files {
        let (before, after) = (features("whole", name), features("half", name));
        assert!(!after.is_empty(), "{name}");
        let places = |features: &[Value]| -> Vec<[f64; 2]> {
            features.iter().flat_map(lines_of).flatten().collect()
        };
        let out = places(&after).into_iter().filter(|at| !is_within(*at, share));
        assert_eq!(out.count(), 0, "{name}");
        let was_out = places(&before).into_iter().filter(|at| !is_within(*at, share));
        assert!(was_out.count() > 0, "{name}");
    }
    let report = json(&folder.join("half/report.json"));
    let inputs = report["inputs"].as_array().expect("inputs");
    assert!(inputs.iter().any(|input| input["file"] == "shore.geojson"));

    // What is no area, and that of another water, is said in a sentence.
    fs::write(folder.join("none.kml"), "<kml/>").unwrap();
    let clip = ["--set", "isobaths.clip=none.kml", "-o", "none"];
    let said = refusal(folder, &[&process[..], &clip].concat(), 1);
    assert!(said.contains("no polygon") && said.contains("none.kml"), "{said}");
    let far = r#"{"type":"Polygon","coordinates":[[[1,1],[2,1],[2,2],[1,1]]]}"#;
    fs::write(folder.join("far.geojson"), far).unwrap();
    let clip = ["--set", "isobaths.clip=far.geojson", "-o", "far"];
    let said = stderr_of(folder, &[&process[..], &clip].concat());
    assert!(said.contains("lies elsewhere than the depths"), "{said}");
    // The polygons are not written over.
    fs::create_dir_all(folder.join("out/isobaths")).unwrap();
    fs::copy(folder.join("shore.geojson"), folder.join("out/isobaths/depth_areas.geojson"))
        .unwrap();
    let clip = ["--set", "isobaths.clip=out/isobaths/depth_areas.geojson", "-o", "out"];
    let said = refusal(folder, &[&process[..], &clip].concat(), 1);
    assert!(said.contains("might be written over"), "{said}");
}
