//! Small inputs that fooled the program, as far as only whole runs show what comes of them. Those
//! that are read rightly or wrongly are tested beside the readers.

use super::*;
use rusqlite::Connection;
use serde_json::Value;

/// Longitudes of the lines of a feature.
fn longitudes_deg(feature: &Value) -> Vec<Vec<f64>> {
    let parts = feature["geometry"]["coordinates"].as_array().expect("lines");
    let longitudes = |part: &Value| {
        let places = part.as_array().expect("places");
        places.iter().map(|place| place[0].as_f64().expect("a number")).collect()
    };
    parts.iter().map(longitudes).collect()
}

#[test]
fn a_survey_across_the_180th_meridian_is_cut_there_and_a_gap_between_readings_is_said() {
    let Some(data) = support::real_data() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["across_180_degrees.nmea", "water_levels_6h_gap.csv"] {
        fs::copy(data.join("cases").join(name), folder.path().join(name)).expect("a copy");
    }
    let args = ["process", "across_180_degrees.nmea", "-o", "out"];
    let level = ["--set", "water_level.file=water_levels_6h_gap.csv"];
    let words = stderr_of(folder.path(), &[&args[..], &level].concat());
    assert!(words.contains("no reading of the water level from 2025-09-11 11:50:00"), "{words}");

    let out = folder.path().join("out");
    let text = fs::read_to_string(out.join("track/track.geojson")).expect("a track");
    let track: Value = serde_json::from_str(&text).expect("JSON");
    let parts = longitudes_deg(&track["features"][0]);
    // It crosses the meridian three times.
    assert_eq!(parts.len(), 4);
    for part in parts {
        let on_one_side = part.iter().all(|lon_deg| lon_deg.signum() == part[0].signum());
        assert!(on_one_side && part.iter().all(|lon_deg| lon_deg.abs() > 179.99), "{part:?}");
    }
    let tiles = Connection::open(out.join("map_tiles/depth.mbtiles")).expect("a database");
    let of_finest = "SELECT count(*), min(tile_column), max(tile_column) FROM tiles
        WHERE zoom_level = (SELECT max(zoom_level) FROM tiles)";
    let [count, first, last]: [i64; 3] = tiles
        .query_row(of_finest, [], |row| Ok([row.get(0)?, row.get(1)?, row.get(2)?]))
        .expect("tiles");
    assert!(count < 10 && first == 0 && last > 0, "{count} tiles in columns {first} to {last}");
}
