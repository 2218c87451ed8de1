//! The record beside each product of `bathyscope process`, and the systems that products are written in.

use super::{refusal, run, simulated};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a product")).expect("JSON")
}

/// The files that should have a record: not the report, not records, not what belongs to a shapefile.
fn products(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let names: BTreeSet<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let is_record = |name: &String| {
        let product = name.strip_suffix(".json");
        product.is_some_and(|product| names.contains(product))
    };
    let belongs = |name: &String| {
        let others = [".shx", ".dbf", ".prj", ".cpg", ".qml"];
        name.starts_with("report.") || others.iter().any(|other| name.ends_with(other))
    };
    let products = names
        .iter()
        .filter(|name| !is_record(name) && !belongs(name));
    products.cloned().collect()
}

#[test]
fn every_product_has_a_record_of_its_own() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let mercator = [
        "--set",
        "crs=web_mercator",
        "--set",
        "isobaths.interval_m=0.2",
    ];
    let process = ["process", "pond.sl2", "--no-objects", "-o", "out"];
    run(folder, &[&process[..], &mercator].concat());
    let out = folder.join("out");
    let report = json(&out.join("report.json"));
    let made = products(&out);
    for name in &made {
        let record = json(&out.join(format!("{name}.json")));
        assert_eq!(record["product"], name.as_str());
        assert_eq!(record["inputs"], report["inputs"], "{name}");
        assert_eq!(record["statement"], report["statement"], "{name}");
        assert!(record["settings"]["detector"].is_null(), "{name}");
        let epsg = match name.rsplit_once('.').map(|(_, kind)| kind) {
            Some("tif" | "laz" | "xyz" | "shp") => Some(3857),
            Some("geojson" | "kmz" | "gpx") => Some(4326),
            _ => continue,
        };
        assert_eq!(record["crs"]["epsg"].as_u64(), epsg, "{name}");
        assert!(record["extent"]["west"].is_number(), "{name}");
    }
    for expected in [
        "cloud.laz",
        "cloud.xyz",
        "depth.tif",
        "footprint.kmz",
        "isobaths.shp",
        "mosaic.tif",
        "track.gpx",
    ] {
        assert!(made.iter().any(|name| name == expected), "{expected}");
    }
}

#[test]
fn a_system_that_does_not_fit_is_refused_before_the_work() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    for (system, why) in [
        ("EPSG:27700", "another datum"),
        ("EPSG:32733", "outside"),
        ("mars", "utm, wgs84, web_mercator"),
    ] {
        let set = format!("crs={system}");
        let process = ["process", "pond.sl2", "-o", "out", "--set", &set];
        let sentence = refusal(folder, &process, 1);
        assert!(sentence.contains(why), "{sentence}");
        assert!(!folder.join("out/report.json").exists());
    }
}
