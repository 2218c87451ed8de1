//! The objects of one reviewed project in the window and in every file: the same members, numbers
//! and states.

use crate::logs_window::{ids, settle};
use crate::objects_window::{object_of, proposed};
use crate::project_window::{open, save_as};
use crate::window::{Window, app};
use bathyscope::app::{Command, FileToWrite, LogBox};
use bathyscope_objects::review::{Edit, State};
use rusqlite::Connection;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A box as a file names it, with its state and the number of its object.
type Row = (String, u32, String, Option<u32>);

/// The boxes of the window, of targets or all.
fn shown(window: &Window, only_targets: bool) -> BTreeSet<Row> {
    let mut rows = BTreeSet::new();
    for object in app(window).objects() {
        for key in &object.boxes {
            let state = app(window).log_box(*key).expect("a box").state;
            if !only_targets || state.is_object() {
                let log = app(window).open_log(key.log).expect("a log").name();
                rows.insert((log, key.id.0, state.name().to_owned(), Some(object.number)));
            }
        }
    }
    rows
}

fn of_csv(path: &Path) -> BTreeSet<Row> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let rows = table.deserialize().map(|row| {
        let row: BTreeMap<String, String> = row.expect("a row");
        let number = row["object"].parse().ok();
        (row["log"].clone(), row["id"].parse().expect("a number"), row["state"].clone(), number)
    });
    rows.collect()
}

fn of_geojson(path: &Path) -> BTreeSet<Row> {
    let text = std::fs::read_to_string(path).expect("a file");
    let read: Value = serde_json::from_str(&text).expect("JSON");
    let features = read["features"].as_array().expect("features").iter();
    let rows = features.map(|feature| {
        let id = feature["id"].as_str().expect("log and box");
        let (log, id) = id.rsplit_once(' ').expect("log and box");
        let said = &feature["properties"];
        (
            log.to_owned(),
            id.parse().expect("a number"),
            said["state"].as_str().expect("a word").to_owned(),
            said["object"].as_u64().map(|number| number as u32),
        )
    });
    rows.collect()
}

/// The rows of a layer, by SQLite itself.
fn of_geopackage(path: &Path) -> BTreeSet<Row> {
    let file = Connection::open(path).expect("a GeoPackage");
    let mut query = file.prepare("SELECT log, box, state, object FROM targets").expect("a layer");
    let rows = query.query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?)));
    let rows = rows.expect("rows");
    rows.collect::<Result<_, _>>().expect("a row")
}

/// The names of the waypoints or placemarks.
fn names(path: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(path).expect("a file");
    let tag = match path.extension().is_some_and(|ending| ending == "gpx") {
        true => "<wpt",
        false => "<Placemark",
    };
    let parts = text.split(tag).skip(1).map(|part| {
        let after = part.split("<name>").nth(1).expect("a name");
        after.split("</name>").next().expect("a name").to_owned()
    });
    parts.collect()
}

/// Numbers in the first column of the page's table of objects.
fn listed(path: &Path) -> BTreeSet<u32> {
    let text = std::fs::read_to_string(path).expect("a page");
    let section = text.split("<h2>Objects</h2>").nth(1).expect("a section");
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
    let one = half.boxes[0];
    edit(window, one, Edit::Accept(one.id));
    assert!(half.boxes.len() > 1, "its other boxes stay undecided");
}

/// Checks the files of a run against what the window shows.
fn check_run(folder: &Path, targets: &BTreeSet<Row>, titles: &BTreeSet<String>) {
    let objects = folder.join("objects");
    assert_eq!(of_csv(&objects.join("targets.csv")), *targets);
    assert_eq!(of_geojson(&objects.join("targets.geojson")), *targets);
    assert_eq!(names(&objects.join("targets.gpx")), *titles);
    assert_eq!(names(&objects.join("targets.kml")), *titles);
    assert_eq!(of_geopackage(&folder.join("survey.gpkg")), *targets);
    let numbers: BTreeSet<u32> = targets.iter().filter_map(|row| row.3).collect();
    assert_eq!(listed(&folder.join("report.html")), numbers);
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
    let of_state = |state: State| all.iter().filter(move |row| row.2 == state.name());
    assert!(State::ALL[..3].iter().all(|state| of_state(*state).count() > 0));
    let half = object_of(&window, 2).number;
    let titles = BTreeSet::from(["Anna".to_owned(), format!("block {half}")]);

    let boxes = folder.path().join("boxes");
    (window.state_mut().app).apply(Command::Write(FileToWrite::Boxes(boxes.clone())));
    settle(&mut window);
    assert_eq!(of_csv(&boxes.join("objects.csv")), all);
    assert_eq!(of_geojson(&boxes.join("objects.geojson")), all);
    assert_eq!(of_geopackage(&boxes.join("objects.gpkg")), targets);
    assert_eq!(names(&boxes.join("objects.gpx")), titles);
    assert_eq!(names(&boxes.join("objects.kml")), titles);

    let products = folder.path().join("products");
    (window.state_mut().app).apply(Command::Write(FileToWrite::Products(products.clone())));
    settle(&mut window);
    check_run(&products, &targets, &titles);

    // The project keeps the numbers, for the command line and for another day.
    let headless = folder.path().join("headless");
    let output = std::process::Command::new(crate::support::program())
        .args(["process".as_ref(), project.as_os_str(), "-o".as_ref()])
        .arg(&headless)
        .args(["--products", "targets,geopackage,report"])
        .output()
        .expect("the program runs");
    assert!(output.status.success(), "{output:?}");
    check_run(&headless, &targets, &titles);
    // One window at a time has a project open.
    drop(window);
    let window = open(&project);
    assert_eq!(shown(&window, false), all);
}
