//! `bathyscope compare --change`: what changed between two depth maps, on a pond to which a known
//! mound was added.

use super::super::{refusal, run};
use bathyscope_log::formats::geotiff::{RasterValues, read_values};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

/// A mound of a Gaussian's shape: its volume is 2 pi times height and radius squared.
const HEIGHT_M: f64 = 0.6;
const RADIUS_M: f64 = 3.0;

const POND: &str = "longitude_deg = -82.11\nlatitude_deg = 29.41\nscattered_objects = 0\n\
    [track]\nlines = 9\nlength_m = 40.0\nspacing_m = 3.5\ncross_lines = 2\ncross_length_m = 26.0\nping_rate_hz = 12.0\n\
    [artefacts]\nweed_m = 0.0\n[bed]\nseed = 5\nmean_depth_m = 3.0\n";

/// Surveys the pond, with a mound or without, into a folder of that name.
fn survey(folder: &Path, name: &str, mound: bool, seed: &str) {
    let mound = if mound {
        format!(
            "mounds = [{{ east_m = 1.0, north_m = 0.5, radius_m = {RADIUS_M:?}, height_m = {HEIGHT_M:?} }}]\n"
        )
    } else {
        String::new()
    };
    fs::write(folder.join("scene.toml"), format!("{POND}{mound}")).expect("a scene");
    run(folder, &["simulate", "scene.toml", "-o", name, "--seed", seed]);
    let log = format!("{name}.sl2");
    let products = ["--no-objects", "--products", "depth", "--set", "surface.cell_m=0.5"];
    run(folder, &[&["process", &log, "-o", name][..], &products].concat());
}

fn change(folder: &Path, newer: &str, older: &str) -> Value {
    let args = ["compare", newer, older, "--change", "change", "--json"];
    serde_json::from_str(&run(folder, &args)).expect("JSON on stdout")
}

fn number(record: &Value, part: &str, key: &str) -> f64 {
    record[part][key].as_f64().expect("a number")
}

#[test]
fn a_mound_is_found_with_its_volume_and_nothing_where_nothing_changed() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    survey(folder, "before", false, "1");
    survey(folder, "after", true, "2");
    survey(folder, "again", false, "3");
    let truth_m3 = TAU * RADIUS_M * RADIUS_M * HEIGHT_M;

    let record = change(folder, "after", "before");
    let (fill_m3, within_m3) =
        (number(&record, "fill", "volume_m3"), number(&record, "fill", "within_95_m3"));
    // With its rim, also where that is lower than the level of detection.
    assert!((fill_m3 - truth_m3).abs() < 0.1 * truth_m3, "{record}");
    assert!((fill_m3 - truth_m3).abs() < within_m3 && within_m3 < 1.25 * truth_m3, "{record}");
    assert_eq!(record["fill"]["places"], 1);
    let all_m3 = number(&record, "all", "volume_m3");
    assert!((all_m3 - truth_m3).abs() < 0.1 * truth_m3, "{record}");
    assert!(number(&record, "cut", "volume_m3").abs() < 0.02 * truth_m3, "{record}");
    assert!(record["median_m"].as_f64().is_some_and(|metres| metres.abs() < 0.04), "{record}");
    assert_eq!(
        record,
        serde_json::from_str::<Value>(
            &fs::read_to_string(folder.join("change/change.json")).expect("a file")
        )
        .expect("JSON")
    );
    rasters_hold(&folder.join("change"), &record);
    let page = fs::read_to_string(folder.join("change/change.html")).expect("a page");
    assert!(page.contains("data:image/png") && !page.contains("http"));

    let turned = change(folder, "before", "after");
    assert!((number(&turned, "cut", "volume_m3") + fill_m3).abs() < 0.02 * truth_m3, "{turned}");
    let same = change(folder, "again", "before");
    let moved_m3 = number(&same, "fill", "volume_m3") - number(&same, "cut", "volume_m3");
    assert!(moved_m3 < 0.05 * truth_m3, "{same}");
}

/// The volume of all cells is that of the rasters, detected cells lie in the places, and the
/// uncertainty holds what the level is made of.
fn rasters_hold(folder: &Path, record: &Value) {
    let read = |name: &str| -> RasterValues { read_values(&folder.join(name)).expect("a raster") };
    let names = ["difference.tif", "detection_level.tif", "uncertainty.tif"];
    let [rise, level, uncertainty] = names.map(read);
    let known: Vec<usize> =
        (0..rise.values.len()).filter(|cell| !rise.values[*cell].is_nan()).collect();
    assert_eq!(known.len() as f64, number(record, "all", "cells"));
    // Half a metre of the zone is half a metre on the ground to a few parts in ten thousand.
    let rises = known.iter().map(|cell| f64::from(rise.values[*cell]));
    let volume_m3 = 0.25 * rises.sum::<f64>();
    assert!((volume_m3 - number(record, "all", "volume_m3")).abs() < 2e-3 * volume_m3.abs() + 1e-9);
    let is_detected = |cell: &&usize| rise.values[**cell].abs() > level.values[**cell];
    let detected = known.iter().filter(is_detected).count() as f64;
    assert!(detected > 20.0 && detected < number(record, "net", "cells"));
    let [mut widened, mut narrower] = [0; 2];
    for cell in &known {
        let own_m = level.values[*cell] / 1.96;
        widened += usize::from(uncertainty.values[*cell] > 1.01 * own_m);
        narrower += usize::from(uncertainty.values[*cell] < 0.999 * own_m);
    }
    assert!(widened > 0 && narrower == 0, "{widened} {narrower}");
    for name in ["difference.qml", "detection_level.qml", "uncertainty.qml"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
}

#[test]
fn what_is_no_map_or_lies_elsewhere_is_refused_in_a_sentence() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    fs::create_dir(folder.join("empty")).expect("a folder");
    fs::write(folder.join("text.tif"), "no raster").expect("a file");
    for (newer, says) in
        [("empty", "no depth map"), ("text.tif", "GeoTIFF"), ("missing", "cannot be read")]
    {
        let sentence = refusal(folder, &["compare", newer, newer, "--change", "change"], 1);
        assert!(sentence.contains(says), "{sentence}");
    }
    assert!(!folder.join("change").exists());
}
