//! The objects of one reviewed project in the window and in every file: the same numbers, and the
//! same in every column.

use crate::logs_window::{ids, settle};
use crate::objects_window::{object_of, proposed, proposed_of};
use crate::project_window::{open, save_as};
use crate::window::{Window, app, press};
use bathyscope::app::{Command, FileToWrite, LogBox, Object, ObjectState};
use bathyscope_objects::objects::OBJECT_COLUMNS;
use bathyscope_objects::review::{Edit, Queue};
use egui::{Key, Modifiers};
use rusqlite::Connection;
use rusqlite::types::ValueRef;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A box as a file names it, with its state and the number of its object.
type Row = (String, u32, String, Option<u32>);
/// Objects by number: the text of each column, empty for what is not known.
type Objects = BTreeMap<u32, BTreeMap<String, String>>;

/// The boxes of the window, of targets or all.
fn boxes_shown(window: &Window, only_targets: bool) -> BTreeSet<Row> {
    let mut rows = BTreeSet::new();
    for object in app(window).objects.all() {
        for key in &object.boxes {
            let state = app(window).logs.log_box(*key).expect("a box").state;
            if !only_targets || state.is_object() {
                let log = app(window).logs.get(key.log).expect("a log").name();
                rows.insert((log, key.id.0, state.name().to_owned(), Some(object.number)));
            }
        }
    }
    rows
}

fn of_boxes(path: &Path) -> BTreeSet<Row> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let rows = table.deserialize().map(|row| {
        let row: BTreeMap<String, String> = row.expect("a row");
        let number = row["object"].parse().ok();
        (row["log"].clone(), row["id"].parse().expect("a number"), row["state"].clone(), number)
    });
    rows.collect()
}

/// Numbers in one way of writing them.
fn alike(text: &str) -> String {
    text.parse::<f64>().map_or_else(|_| text.to_owned(), |number| number.to_string())
}

/// Objects by their number. Shapes are left out: the window fits that of the selected object.
fn by_number(rows: impl Iterator<Item = BTreeMap<String, String>>) -> Objects {
    let rows = rows.map(|mut row| {
        row.retain(|name, text| !name.starts_with("shape") && !text.is_empty());
        row.values_mut().for_each(|text| *text = alike(text));
        (row["number"].parse().expect("a number"), row)
    });
    rows.collect()
}

/// The objects of the window, targets or all.
fn shown(window: &Window, only_targets: bool) -> Objects {
    let is_shown = |object: &&Object| !only_targets || object.state == ObjectState::Accepted;
    let objects = app(window).objects.all().iter().filter(is_shown).map(|object| {
        let of = app(window).objects.listed_object(object);
        let columns = OBJECT_COLUMNS.iter();
        columns.map(|column| (column.name.to_owned(), column.text(&of))).collect()
    });
    by_number(objects)
}

fn of_csv(path: &Path) -> Objects {
    let mut table = csv::Reader::from_path(path).expect("a table");
    by_number(table.deserialize().map(|row| row.expect("a row")))
}

fn of_geojson(path: &Path) -> Objects {
    let text = std::fs::read_to_string(path).expect("a file");
    let read: Value = serde_json::from_str(&text).expect("JSON");
    let features = read["features"].as_array().expect("features").iter();
    by_number(features.map(|feature| {
        let properties = feature["properties"].as_object().expect("properties").iter();
        let text = |value: &Value| match value {
            Value::Null => String::new(),
            Value::String(words) => words.clone(),
            number => number.to_string(),
        };
        properties.map(|(name, value)| (name.clone(), text(value))).collect()
    }))
}

/// The rows of a layer, by SQLite itself.
fn of_geopackage(path: &Path) -> Objects {
    let file = Connection::open(path).expect("a GeoPackage");
    let mut query = file.prepare("SELECT * FROM targets").expect("a layer");
    let names: Vec<String> = query.column_names().map(str::to_owned).collect();
    let rows = query.query_map([], |row| {
        let mut read = BTreeMap::new();
        for (place, name) in names.iter().enumerate() {
            let text = match row.get_ref(place)? {
                ValueRef::Integer(count) => count.to_string(),
                ValueRef::Real(number) => number.to_string(),
                ValueRef::Text(words) => String::from_utf8_lossy(words).into_owned(),
                ValueRef::Null | ValueRef::Blob(_) => String::new(),
            };
            read.insert(name.clone(), text);
        }
        read.remove("fid");
        Ok(read)
    });
    by_number(rows.expect("rows").map(|row| row.expect("a row")))
}

/// The columns of waypoints or placemarks.
fn of_places(path: &Path) -> Objects {
    let text = std::fs::read_to_string(path).expect("a file");
    let (place, column) = if path.extension().is_some_and(|ending| ending == "gpx") {
        ("<wpt", "<bathyscope:")
    } else {
        ("<Placemark", "<Data name=\"")
    };
    by_number(text.split(place).skip(1).map(|part| {
        let columns = part.split(column).skip(1).map(|element| {
            let name: String = element
                .chars()
                .take_while(|letter| letter.is_alphanumeric() || *letter == '_')
                .collect();
            let value = element.replace("<value>", "");
            let value = value.split('>').nth(1).and_then(|rest| rest.split('<').next());
            (name, value.expect("a value").to_owned())
        });
        columns.collect()
    }))
}

/// The names of the waypoints or placemarks.
fn names(path: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(path).expect("a file");
    let tag =
        if path.extension().is_some_and(|ending| ending == "gpx") { "<wpt" } else { "<Placemark" };
    let parts = text.split(tag).skip(1).map(|part| {
        let after = part.split("<name>").nth(1).expect("a name");
        after.split("</name>").next().expect("a name").to_owned()
    });
    parts.collect()
}

/// Numbers in the first column of the page's table of objects.
fn listed(page: &str) -> BTreeSet<u32> {
    let section = page.split("<h2>Objects</h2>").nth(1).expect("a section");
    let table = section.split("</table>").next().expect("a table");
    let rows = table.split("<tr><td>").skip(1);
    let number = |row: &str| row.split('<').next().and_then(|text| text.parse().ok());
    rows.map(|row| number(row).expect("a number")).collect()
}

fn edit(window: &mut Window, key: LogBox, edit: Edit) {
    (window.state_mut().app).apply(Command::EditIn(key.log, edit));
    settle(window);
}

/// One object accepted and named, one rejected, one of which one box is accepted; the others are
/// undecided.
fn decide(window: &mut Window) {
    let [named, nothing, half] = [0, 1, 2].map(|index| object_of(window, index));
    for key in &named.boxes {
        edit(window, *key, Edit::Accept(key.id));
    }
    let first = named.boxes[0];
    edit(window, first, Edit::Rename(first.id, "Anna".to_owned()));
    for key in &nothing.boxes {
        edit(window, *key, Edit::Reject(key.id));
    }
    let accepted = half.boxes[0];
    edit(window, accepted, Edit::Accept(accepted.id));
    assert!(half.boxes.len() > 1, "its other boxes stay undecided");
}

/// Checks the files of a run against what the window shows.
fn check_run(folder: &Path, window: &Window, titles: &BTreeSet<String>) {
    let (all, targets) = (shown(window, false), shown(window, true));
    let objects = folder.join("objects");
    assert_eq!(of_csv(&objects.join("objects.csv")), all);
    assert_eq!(of_boxes(&objects.join("targets.csv")), boxes_shown(window, true));
    assert_eq!(of_geojson(&objects.join("targets.geojson")), targets);
    assert_eq!(of_places(&objects.join("targets.gpx")), targets);
    assert_eq!(of_places(&objects.join("targets.kml")), targets);
    assert_eq!(names(&objects.join("targets.gpx")), *titles);
    assert_eq!(names(&objects.join("targets.kml")), *titles);
    assert_eq!(of_geopackage(&folder.join("survey.gpkg")), targets);
    let page = std::fs::read_to_string(folder.join("report.html")).expect("a page");
    assert_eq!(listed(&page), targets.keys().copied().collect());
    for object in
        app(window).objects.all().iter().filter(|object| targets.contains_key(&object.number))
    {
        let row = page.split(&format!("<tr><td>{}</td>", object.number)).nth(1);
        let row = row.and_then(|row| row.split("</tr>").next()).expect("a row");
        let height = object.height;
        let height = format!("<td>{:.2} ± {:.2}</td>", height.mean_m, height.sigma_m);
        let size = format!("<td>{:.2}</td>", object.length_m);
        let class = format!(">{}</td>", object.class);
        for said in [height, size, class, ">accepted</td>".to_owned()] {
            assert!(row.contains(&said), "{said} of {row}");
        }
    }
}

#[test]
fn window_tables_maps_plotters_and_report_have_the_same_objects() {
    let (folder, mut window) = proposed();
    decide(&mut window);
    let project = folder.path().join("reviewed.bathyscope");
    save_as(&mut window, &project);
    let first = ids(&window)[0];
    (window.state_mut().app).apply(Command::ShowLog(first));
    settle(&mut window);
    let (all, targets) = (shown(&window, false), shown(&window, true));
    let states: BTreeSet<&String> = all.values().map(|object| &object["state"]).collect();
    assert_eq!(states.len(), ObjectState::ALL.len(), "{states:?}");
    let half = object_of(&window, 2).number;
    let titles = BTreeSet::from(["Anna".to_owned(), format!("block {half}")]);

    let boxes = folder.path().join("boxes");
    (window.state_mut().app).apply(Command::Write(FileToWrite::Boxes(boxes.clone())));
    settle(&mut window);
    assert_eq!(of_boxes(&boxes.join("detections.csv")), boxes_shown(&window, false));
    assert_eq!(of_csv(&boxes.join("objects.csv")), all);
    assert_eq!(of_geojson(&boxes.join("objects.geojson")), all);
    assert_eq!(of_geopackage(&boxes.join("objects.gpkg")), targets);
    assert_eq!(of_places(&boxes.join("objects.gpx")), targets);
    assert_eq!(of_places(&boxes.join("objects.kml")), targets);

    let products = folder.path().join("products");
    (window.state_mut().app).apply(Command::Write(FileToWrite::Products(products.clone())));
    settle(&mut window);
    check_run(&products, &window, &titles);

    // The project keeps the numbers, for the command line and for another day.
    let headless = folder.path().join("headless");
    let output = std::process::Command::new(crate::support::program())
        .args(["process".as_ref(), project.as_os_str(), "-o".as_ref()])
        .arg(&headless)
        .args(["--products", "targets,geopackage,report"])
        .output()
        .expect("the program runs");
    assert!(output.status.success(), "{output:?}");
    check_run(&headless, &window, &titles);
    // One window at a time has a project open.
    drop(window);
    let mut window = open(&project);
    assert_eq!(shown(&window, false), all);

    // Whatever is hidden, the rest stays as it is.
    for threshold in [0.0, 0.3, 0.6, 0.9, 1.0] {
        let queue = Queue { threshold, ..app(&window).logs.shown.reviewing.queue.clone() };
        (window.state_mut().app).apply(Command::LineUp(Box::new(queue)));
        settle(&mut window);
        let left = shown(&window, false);
        assert!(left.len() >= targets.len() && (threshold > 0.0 || left == all));
        for (number, object) in left {
            assert_eq!(object, all[&number], "{threshold}");
        }
    }
}

#[test]
fn thirty_decisions_by_keys_change_no_object_but_the_one_that_is_decided() {
    let (_folder, mut window) = proposed_of(3);
    press(&mut window, Modifiers::NONE, Key::Tab);
    settle(&mut window);
    for index in 0..30 {
        let here = app(&window).logs.shown.selected_box().expect("a selected box");
        let object = |window: &Window| app(window).objects.of_box(here).expect("an object").number;
        let (before, of) = (shown(&window, false), object(&window));
        let key = if index % 4 == 3 { Key::R } else { Key::A };
        press(&mut window, Modifiers::NONE, key);
        settle(&mut window);
        // A rejected box is no sighting of its object any more, but shows nothing by itself.
        let decided = [of, object(&window)];
        let (mut before, mut after) = (before, shown(&window, false));
        before.retain(|number, _| !decided.contains(number));
        after.retain(|number, _| !decided.contains(number));
        assert_eq!(before, after, "decision {index}");
    }
}
