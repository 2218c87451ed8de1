use super::*;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::printable::xml;
use bathyscope_log::survey::{Navigation, Side, Survey};
use bathyscope_objects::Mark;
use bathyscope_objects::objects::{
    ListedObject, LogBox, LogId, OBJECT_COLUMNS, Object, ObjectBox, ObjectList, ObjectNumbers,
};
use bathyscope_objects::review::{BoxId, Reviewed, State};
use bathyscope_objects::targets::{FittedShape, PosedSolid, ShapeKind, Solid, Target};
use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;

fn mark() -> Mark {
    Mark { side: Side::Port, pings: 10..22, near_m: 4.0, far_m: 6.0 }
}

fn target(mark: &Mark) -> Target {
    Target {
        mark: mark.clone(),
        extent: bathyscope_objects::ObjectExtent::Found,
        measured_shadow: None,
        parts: None,
        slant_m: 4.5,
        ground_m: 4.0,
        altitude_m: 2.0,
        east_m: 12.5,
        north_m: -3.25,
        position: LonLat { lon_deg: -82.11, lat_deg: 29.41 },
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

/// A box with a place and a box without.
fn boxes() -> [ObjectBox; 2] {
    let note = "=cmd & \"two\", \u{1}see\nbelow".to_owned();
    let reviewed = Reviewed {
        score: Some(0.875),
        state: State::Accepted,
        note,
        ..Reviewed::drawn(BoxId(7), mark(), 0)
    };
    let lost = Reviewed { score: None, note: String::new(), ..reviewed.clone() };
    let boxed = |reviewed: Reviewed, id, target, object| ObjectBox {
        log: 0,
        key: LogBox { log: LogId(0), id: BoxId(id) },
        one: Arc::new(Reviewed { id: BoxId(id), ..reviewed }),
        class: "tyre <old>".to_owned(),
        target,
        object,
        is_hidden: false,
    };
    [boxed(reviewed, 7, Some(target(&mark())), Some(1)), boxed(lost, 8, None, None)]
}

/// Returns a changed copy of a box.
fn changed(of: &ObjectBox, change: impl FnOnce(&mut Reviewed)) -> ObjectBox {
    let mut of = of.clone();
    change(Arc::make_mut(&mut of.one));
    of
}

/// Two logs of one recording.
fn logs(survey: &Survey) -> [ObjectLog<'_>; 2] {
    ["first", "=second"].map(|name| ObjectLog { name, survey })
}

fn written<T>(
    write: impl FnOnce(&std::path::Path) -> Result<T, crate::export::ExportError>,
) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    write(&path).unwrap();
    fs::read_to_string(path).unwrap()
}

#[test]
fn the_table_has_a_line_a_box_and_empty_fields_for_what_is_not_known() {
    let (boxes, survey) = (boxes(), Survey::default());
    let text =
        written(|path| box_table(path, &logs(&survey)[..1], &boxes.each_ref(), &BTreeMap::new()));
    let mut table = csv::Reader::from_reader(text.as_bytes());
    assert_eq!(&table.headers().unwrap()[17], "depth_m");
    let lines: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let fields = ["7", "survey", "tyre <old>", "0.8750", "accepted", "port", "10", "22"];
    assert!(lines[0].iter().take(8).eq(fields));
    assert_eq!((&lines[0][10], &lines[0][13]), ("-82.11000000", "-3.250"));
    assert_eq!((&lines[0][16], &lines[0][17]), ("", "2.000"), "no shadow");
    assert!(lines[0][21].starts_with("'=cmd"));
    assert_eq!((&lines[1][3], &lines[1][10]), ("", ""));
}

/// Returns the object number 3, which some boxes show.
fn object(boxes: &[ObjectBox]) -> Object {
    let (survey, navigation) = (Survey::default(), Navigation::of_pings([]));
    let boxes = boxes.to_vec();
    let position = boxes[0].target.as_ref().expect("a place").position;
    let list = ObjectList::join(boxes, &[(&survey, &navigation)], &ObjectNumbers::default());
    let [object] = &list.objects[..] else { panic!("one object") };
    let mut object = object.clone();
    (object.number, object.sightings, object.position) = (3, 2, position);
    object
}

/// Returns the object as a row of tables.
fn listed<'a>(object: &'a Object, shape: Option<&'a FittedShape>) -> ListedObject<'a> {
    ListedObject { object, shape, outline: None, log_names: &[] }
}

#[test]
fn an_object_is_one_waypoint_with_name_class_and_remarks_of_all_its_boxes() {
    let [object_box, _] = boxes();
    let first = changed(&object_box, |review_box| review_box.note.clear());
    let mut second = changed(&object_box, |review_box| {
        review_box.name = "Anna".to_owned();
        review_box.score = Some(0.5);
    });
    second.target = Some(Target { height_m: 0.5, height_sigma_m: 0.25, ..target(&mark()) });
    let named = object(&[first, second]);
    let gpx = written(|path| objects_gpx(path, &[listed(&named, None), listed(&named, None)]));
    assert_eq!(gpx.matches("<wpt ").count(), 2);
    assert_eq!(gpx.matches("<name>Anna 3</name>").count(), 2, "told apart");
    let gpx = written(|path| objects_gpx(path, &[listed(&named, None)]));
    assert!(gpx.contains("<name>Anna</name><cmt>=cmd &amp;"), "{gpx}");
    assert!(gpx.contains("<type>tyre &lt;old&gt;</type>"));
    assert!(gpx.contains("height 0.50 ± 0.25 m"), "{gpx}");
    assert!(gpx.contains("score 0.88") && gpx.contains("seen on 2 passes"));
}

#[test]
fn markup_in_names_and_notes_is_escaped() {
    let [object_box, _] = boxes();
    let object = object(&[object_box]);
    let kml = written(|path| objects_kml(path, "a & b", &[listed(&object, None)]));
    let gpx = written(|path| objects_gpx(path, &[listed(&object, None)]));
    for text in [&kml, &gpx] {
        assert!(text.contains("<name>tyre &lt;old&gt; 3</name>"), "{text}");
        assert!(text.contains("=cmd &amp; &quot;two&quot;, see\nbelow"));
        assert!(!text.contains("height_m"), "it is not known");
        assert!(text.contains("score") && text.contains("0.8750"), "{text}");
    }
    assert!(kml.contains("<name>a &amp; b</name>"));
    assert!(kml.contains("<coordinates>-82.11000000,29.41000000</coordinates>"));
    assert!(gpx.contains("<wpt lat=\"29.41000000\" lon=\"-82.11000000\">"));
}

#[test]
fn boxes_of_several_logs_say_which() {
    let (mut boxes, survey) = (boxes(), Survey::default());
    let logs = logs(&survey);
    boxes[1] = ObjectBox { log: 1, ..boxes[0].clone() };
    let text = written(|path| box_table(path, &logs, &boxes.each_ref(), &BTreeMap::new()));
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let header = table.headers().unwrap().clone();
    assert_eq!((&header[0], &header[1]), ("log", "id"));
    let lines: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert_eq!((&lines[0][0], &lines[1][0]), ("first", "'=second"));
}

/// A block of 2 x 1 x 0.5 m that lies to the north-east, on a bottom 3 m deep.
fn block() -> FittedShape {
    FittedShape {
        posed: PosedSolid {
            solid: Solid {
                kind: ShapeKind::Block,
                length_m: 2.0,
                width_m: 1.0,
                height_m: 0.5,
                list: 0.0,
            },
            east_m: 10.0,
            north_m: 20.0,
            heading_rad: std::f64::consts::FRAC_PI_4,
        },
        bottom_z_m: -3.0,
        on_pings: Vec::new(),
        explained: 0.875,
        rivals: Vec::new(),
    }
}

#[test]
fn boxes_of_an_object_carry_its_shape_and_it_is_one_body() {
    let (mut boxes, survey, block) = (boxes(), Survey::default(), block());
    boxes[1].object = Some(1);
    let mut object = object(&boxes[..1]);
    object.number = 1;
    let shapes = BTreeMap::from([(1, block.clone())]);
    let text = written(|path| box_table(path, &logs(&survey)[..1], &boxes.each_ref(), &shapes));
    let mut table = csv::Reader::from_reader(text.as_bytes());
    for line in table.records().map(Result::unwrap) {
        let shape: Vec<&str> = line.iter().skip(24).collect();
        assert_eq!(shape, ["block", "2.00", "1.00", "0.50", "45", "0.88"]);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shapes.ply");
    let summary = shapes_ply(&path, &[listed(&object, Some(&block))]).unwrap();
    assert_eq!(summary.count, 1);
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|part| part == end);
    let (header, body) = bytes.split_at(at.expect("a header") + end.len());
    let header = String::from_utf8(header.to_vec()).unwrap();
    assert!(header.contains("comment object 1: block, 2.00 x 1.00 x 0.50 m\n"));
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element));
        line.expect("an element").trim().parse().expect("a number")
    };
    let (corners, squares) = (count("element vertex"), count("element face"));
    assert_eq!(body.len(), corners * 31 + squares * 17);
    let corner = |index: usize| {
        let value = |axis: usize| {
            let at = index * 31 + axis * 8;
            f64::from_le_bytes(body[at..at + 8].try_into().expect("eight bytes"))
        };
        [value(0), value(1), value(2)]
    };
    let highest = (0..corners).map(|index| corner(index)[2]).fold(f64::MIN, f64::max);
    assert!((highest + 2.5).abs() < 1e-9, "{highest}");
    // The area of a square with corners counter-clockwise from above is positive; all squares
    // together cover 2 x 1 m and the margin around.
    let mut area_m2 = 0.0;
    for square in 0..squares {
        let at = corners * 31 + square * 17;
        assert_eq!(body[at], 4);
        let places: Vec<[f64; 3]> = (0..4)
            .map(|nth| {
                let at = at + 1 + 4 * nth;
                let index = i32::from_le_bytes(body[at..at + 4].try_into().expect("four bytes"));
                corner(index as usize)
            })
            .collect();
        let cross = |a: [f64; 3], b: [f64; 3]| 0.5 * (a[0] * b[1] - a[1] * b[0]);
        let own: f64 = (0..4).map(|nth| cross(places[nth], places[(nth + 1) % 4])).sum();
        assert!(own > 0.0, "clockwise");
        area_m2 += own;
    }
    assert!((2.0..2.1).contains(&area_m2), "{area_m2}");
}

/// Tests that every format of objects has the same value in every column.
#[test]
fn all_formats_have_all_columns() {
    let [object_box, _] = boxes();
    let mut first = changed(&object_box, |review_box| review_box.note = "a < b".to_owned());
    first.target = Some(Target { height_m: 0.5, height_sigma_m: 0.25, ..target(&mark()) });
    let (object, block) = (object(&[first]), block());
    let listed = listed(&object, Some(&block));
    let folder = tempfile::tempdir().unwrap();
    let path = |ending: &str| folder.path().join(format!("objects.{ending}"));
    object_table(&path("csv"), &[listed]).unwrap();
    objects_geojson(&path("geojson"), &[listed]).unwrap();
    objects_gpkg(&path("gpkg"), &[listed], 0.0).unwrap();
    objects_kml(&path("kml"), "pond", &[listed]).unwrap();
    objects_gpx(&path("gpx"), &[listed]).unwrap();

    let mut csv = csv::Reader::from_path(path("csv")).unwrap();
    let header = csv.headers().unwrap().clone();
    let line = csv.records().next().unwrap().unwrap();
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(path("geojson")).unwrap()).unwrap();
    let properties = &json["features"][0]["properties"];
    let database = rusqlite::Connection::open(path("gpkg")).unwrap();
    let [kml, gpx] = ["kml", "gpx"].map(|ending| fs::read_to_string(path(ending)).unwrap());
    let mut unknown = 0;
    for (place, column) in OBJECT_COLUMNS.iter().enumerate() {
        let (name, text) = (column.name, column.text(&listed));
        assert_eq!((&header[place], &line[place]), (name, text.as_str()));
        let in_database: rusqlite::types::Value = database
            .query_row(&format!("SELECT {name} FROM targets"), [], |row| row.get(0))
            .unwrap();
        let said = xml(&text);
        if text.is_empty() {
            unknown += 1;
            assert_eq!(properties[name], serde_json::Value::Null, "{name}");
            assert_eq!(in_database, rusqlite::types::Value::Null, "{name}");
            assert!(!kml.contains(&format!("\"{name}\"")) && !gpx.contains(&format!(":{name}>")));
            continue;
        }
        assert!(kml.contains(&format!("<Data name=\"{name}\"><value>{said}</value>")), "{kml}");
        assert!(gpx.contains(&format!("<bathyscope:{name}>{said}</")), "{gpx}");
        match (&properties[name], in_database) {
            (serde_json::Value::String(one), rusqlite::types::Value::Text(other)) => {
                assert_eq!((one, &other), (&text, &text));
            }
            (serde_json::Value::Number(one), other) => {
                let known: f64 = text.parse().unwrap();
                let other = match other {
                    rusqlite::types::Value::Integer(count) => count as f64,
                    rusqlite::types::Value::Real(number) => number,
                    other => panic!("{name}: {other:?}"),
                };
                assert!(one.as_f64() == Some(known) && other == known, "{name}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    assert!((1..6).contains(&unknown), "{unknown} of the columns are not known");
}
