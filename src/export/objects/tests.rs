use super::*;
use crate::geo::LonLat;
use crate::survey::{Side, Survey};
use std::fs;

fn mark() -> Mark {
    Mark {
        side: Side::Port,
        pings: 10..22,
        near_m: 4.0,
        far_m: 6.0,
    }
}

fn target(mark: &Mark) -> Target {
    Target {
        mark: mark.clone(),
        extent: crate::detection::ObjectExtent::Found,
        measured_shadow: None,
        parts: None,
        slant_m: 4.5,
        ground_m: 4.0,
        altitude_m: 2.0,
        east_m: 12.5,
        north_m: -3.25,
        position: LonLat {
            lon_deg: -82.11,
            lat_deg: 29.41,
        },
        length_m: 0.8,
        width_m: 0.6,
        height_m: f64::NAN,
        shadow_m: [f64::NAN; 2],
        height_sigma_m: f64::NAN,
        depth_m: 2.0,
        sigma_m: 0.3,
        along_sigma_m: 0.3,
        across_sigma_m: 0.2,
        heading_rad: 0.0,
        sailed_m: 100.0,
    }
}

/// One box with a place, one without.
fn rows(mark: &Mark) -> Vec<ObjectRow<'_>> {
    let one = ObjectRow {
        log: 0,
        id: 7,
        class: "tyre <old>",
        score: Some(0.875),
        state: "accepted",
        mark,
        target: Some(target(mark)),
        outline: None,
        object: Some(1),
        note: "=cmd & \"two\", \u{1}see\nbelow",
        name: "",
        confidence: "",
    };
    let lost = ObjectRow {
        id: 8,
        score: None,
        target: None,
        object: None,
        note: "",
        ..one.clone()
    };
    vec![one, lost]
}

/// Two logs of one recording.
fn logs(survey: &Survey) -> [ObjectLog<'_>; 2] {
    ["first", "=second"].map(|name| ObjectLog { name, survey })
}

fn written(
    write: impl FnOnce(&std::path::Path) -> Result<(), crate::export::ExportError>,
) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    write(&path).unwrap();
    fs::read_to_string(path).unwrap()
}

#[test]
fn the_table_has_a_line_a_box_and_empty_fields_for_what_is_not_known() {
    let (mark, survey) = (mark(), Survey::default());
    let text = written(|path| objects_csv(path, &logs(&survey)[..1], &rows(&mark)));
    let mut table = csv::Reader::from_reader(text.as_bytes());
    assert_eq!(&table.headers().unwrap()[17], "depth_m");
    let lines: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let fields = [
        "7",
        "survey",
        "tyre <old>",
        "0.8750",
        "accepted",
        "port",
        "10",
        "22",
    ];
    assert!(lines[0].iter().take(8).eq(fields));
    assert_eq!((&lines[0][10], &lines[0][13]), ("-82.11000000", "-3.250"));
    assert_eq!((&lines[0][16], &lines[0][17]), ("", "2.000"), "no shadow");
    assert!(lines[0][21].starts_with("'=cmd"));
    assert_eq!((&lines[1][3], &lines[1][10]), ("", ""));
}

#[test]
fn geojson_has_a_point_for_each_box_with_a_place() {
    let (mark, survey) = (mark(), Survey::default());
    let text = written(|path| objects_geojson(path, &logs(&survey)[..1], &rows(&mark)));
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    let features = read["features"].as_array().unwrap();
    assert_eq!(features.len(), 1);
    let coordinates = &features[0]["geometry"]["coordinates"];
    assert_eq!(*coordinates, serde_json::json!([-82.11, 29.41]));
    assert!(features[0]["properties"]["height_m"].is_null());
    assert_eq!(features[0]["properties"]["score"], 0.875);
}

#[test]
fn markup_in_names_and_notes_is_escaped() {
    let (mark, survey) = (mark(), Survey::default());
    let logs = &logs(&survey)[..1];
    let kml = written(|path| objects_kml(path, "a & b", logs, &rows(&mark)));
    let gpx = written(|path| objects_gpx(path, logs, &rows(&mark)));
    for text in [&kml, &gpx] {
        assert!(text.contains("<name>tyre &lt;old&gt; 7</name>"), "{text}");
        assert!(text.contains("=cmd &amp; &quot;two&quot;, see\nbelow"));
        assert!(!text.contains("height"), "it is not known");
    }
    assert!(kml.contains("<name>a &amp; b</name>"));
    assert!(kml.contains("<coordinates>-82.11000000,29.41000000</coordinates>"));
    assert!(gpx.contains("<wpt lat=\"29.41000000\" lon=\"-82.11000000\">"));
}

#[test]
fn boxes_of_several_logs_say_which() {
    let (mark, survey) = (mark(), Survey::default());
    let logs = logs(&survey);
    let mut rows = rows(&mark);
    rows[1] = ObjectRow {
        log: 1,
        ..rows[0].clone()
    };
    let text = written(|path| objects_csv(path, &logs, &rows));
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let header = table.headers().unwrap().clone();
    assert_eq!((&header[0], &header[1]), ("log", "id"));
    let lines: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert_eq!((&lines[0][0], &lines[1][0]), ("first", "'=second"));
    let text = written(|path| objects_geojson(path, &logs, &rows));
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    let second = &read["features"][1];
    assert_eq!(second["properties"]["log"], "=second");
    assert_ne!(read["features"][0]["id"], second["id"]);
    let gpx = written(|path| objects_gpx(path, &logs, &rows));
    assert!(gpx.contains("<name>tyre &lt;old&gt; 7, =second</name>"));
}
