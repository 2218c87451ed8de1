//! Tests the description of each file in the manifest of `bathyscope process`, and the systems that
//! products are written in.

use super::{refusal, run, simulated};
use crate::support::manifest;
use bathyscope_products::outputs::row_of;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a product")).expect("JSON")
}

#[test]
fn the_manifest_describes_every_file() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let mercator = ["--set", "crs=web_mercator", "--set", "isobaths.interval_m=0.2"];
    let process = ["process", "pond.sl2", "--no-objects", "-o", "out"];
    run(folder, &[&process[..], &mercator].concat());
    let out = folder.join("out");
    let (report, manifest) = (json(&out.join("report.json")), manifest(&out));
    for same in ["program", "run", "inputs", "statement", "settings", "preset"] {
        assert_eq!(manifest[same], report[same], "{same}");
        assert!(!manifest[same].is_null(), "{same}");
    }
    assert!(report["files"].is_null(), "the manifest alone lists the files");
    let mut described = 0;
    for file in manifest["files"].as_array().expect("files") {
        let name = file["file"].as_str().expect("a name");
        let row = row_of(name).expect("a row");
        if name != row.name {
            assert_eq!(file["belongs_to"], row.name, "{name}");
            continue;
        }
        let Some(is) = row.described else {
            assert_eq!(file["what"], row.brief, "{name}");
            continue;
        };
        described += 1;
        assert!(file["what"].as_str().expect("words").starts_with(is.what), "{name}");
        assert!(file["count"][is.counted].is_number(), "{name}");
        let regardless = serde_json::json!(row.regardless_of);
        assert_eq!(file["regardless_of"], regardless, "{name}");
        let epsg = match name.rsplit_once('.').map(|(_, kind)| kind) {
            Some("tif" | "laz" | "xyz" | "shp" | "gpkg") => Some(3857),
            Some("geojson" | "kmz" | "gpx") => Some(4326),
            _ => continue,
        };
        assert_eq!(file["crs"]["epsg"].as_u64(), epsg, "{name}");
        assert!(file["extent"]["west"].is_number(), "{name}");
    }
    assert_eq!(described, 31, "all but those of a comparison and a search");
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
