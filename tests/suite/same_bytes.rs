//! Window and command line write the same bytes of the same survey.

use crate::cli::run;
use crate::residuals::{pond, wait};
use crate::truth::KnownSurvey;
use bathyscope::app::{
    App, BottomStroke, Command, ExclusionEdit, FileToOpen, FileToWrite, Ink, Jobs, LogId, PIXEL_M,
};
use bathyscope_log::survey::{Identity, LogPart, Side};
use bathyscope_objects::review::{BoxId, Edit, Review};
use bathyscope_objects::{Detection, Mark, Raster};
use bathyscope_products::outputs::{OUTPUT_FILES, OutputFile, When};
use bathyscope_products::pipeline::Settings;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// Logs over one bed, each under more water than the first by so much, metres, a day after the one
/// before.
fn write_logs(folder: &Path, logs: &[(&str, f64)]) {
    for (day, (name, level_m)) in (0..).zip(logs) {
        let mut scene = pond(*level_m);
        scene.start_unix_s += 86_400 * day;
        let known = KnownSurvey::new(&scene, u64::from(day) + 1);
        std::fs::write(folder.join(name), known.truth.sl2_bytes()).expect("a log");
    }
}

fn report(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("report.json")).expect("a record of the run");
    serde_json::from_str(&text).expect("JSON")
}

fn names(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            let inner = self::names(&entry.path());
            names.extend(inner.iter().map(|file| format!("{name}/{file}")));
        } else {
            names.push(name)
        }
    }
    names.sort();
    names
}

/// Compares two folders with each other, byte for byte, and both with the rows that must be there.
fn assert_same(by_window: &Path, by_process: &Path, rows: impl Fn(&&OutputFile) -> bool) {
    assert_eq!(names(by_window), names(by_process));
    // Written where a setting asks for them.
    let asked_for = ["points/cloud.las", "depth/hardness.tif"];
    let always = |row: &&OutputFile| !asked_for.contains(&row.name);
    for row in OUTPUT_FILES.iter().filter(rows).filter(always) {
        assert!(by_window.join(row.name).is_file(), "{}", row.name);
    }
    let differing = names(by_window).into_iter().filter_map(|name| {
        let [one, other] =
            [by_window, by_process].map(|folder| std::fs::read(folder.join(&name)).unwrap());
        let lines = one.split(|byte| *byte == b'\n');
        let mut pairs = lines.zip(other.split(|byte| *byte == b'\n'));
        let first = pairs.find(|(one, other)| one != other);
        let first = first.map(|(one, other)| [one, other].map(String::from_utf8_lossy));
        (one != other).then(|| format!("{name}: {first:?}"))
    });
    // A file that differs changes the name of the run in all records.
    let differing: Vec<String> = differing.collect();
    assert!(differing.is_empty(), "these differ:\n{}", differing.join("\n"));
}

/// Boxes on both sides of the open log, one accepted, one rejected, one undecided, in a file as the
/// window keeps it.
fn decided_boxes(app: &App, path: &Path) {
    let log = &app.logs.shown;
    let survey = log.survey.as_ref().expect("a survey");
    let products = log.products.as_ref().expect("results");
    let raster = Raster::new(survey, &products.navigation, PIXEL_M);
    let classes = ["rock".to_owned()];
    let places = [(Side::Port, 20), (Side::Starboard, 60), (Side::Port, 100)];
    let boxes = places.map(|(side, ping)| Detection {
        class: 0,
        score: 0.7,
        mark: Mark { side, pings: ping..ping + 12, near_m: 4.0, far_m: 6.0 },
    });
    let empty = Review::new(Identity::of(survey), classes.to_vec());
    let proposed = empty.adopt("a model", &classes, &boxes, &raster, 0..usize::MAX);
    let ids: Vec<BoxId> = proposed.boxes().map(|review_box| review_box.id).collect();
    let accepted = proposed.apply(&Edit::Accept(ids[0]));
    let review = accepted.and_then(|review| review.apply(&Edit::Reject(ids[1])));
    let text = review.expect("decisions").to_json() + "\n";
    std::fs::write(path, text).expect("a review");
}

/// The open log of the first mission with points of the second beside it, a stroke over its bottom
/// and decided boxes; gives back the arguments that say the same to `process`.
fn everything_at_once(app: &mut App, folder: &Path) -> Vec<String> {
    // Metres that name no system: how they were taken is a note that belongs into the report.
    let process = "process second.sl2 --no-objects --products cloud -o second";
    run(folder, &process.split(' ').collect::<Vec<_>>());
    let reference = folder.join("second/points/cloud.ply");
    let stroke =
        BottomStroke { side: Side::Port, path: vec![[40.0, 4.0], [60.0, 3.5]], ink: Ink::Bottom };
    app.apply(Command::DrawBottom(stroke));
    wait(app);
    let review = folder.join("boxes.json");
    decided_boxes(app, &review);
    for command in [
        Command::OpenFile(FileToOpen::Review(review.clone())),
        Command::CompareWith(reference.clone()),
    ] {
        app.apply(command);
        wait(app);
    }
    let log = folder.join("first.sl2");
    let sidecar = log.with_extension("bottom.toml");
    let bottom = toml::Value::try_from(&app.logs.shown.settings.bottom).expect("edits");
    let bottom = toml::Table::from_iter([("bottom".to_owned(), bottom)]);
    std::fs::write(&sidecar, toml::to_string(&bottom).expect("text")).expect("a file");
    let files = [
        ("process", log.clone()),
        ("--reference", reference),
        ("--review", review),
        ("--settings", sidecar),
    ];
    let arguments =
        files.map(|(word, path)| [word.to_owned(), path.to_string_lossy().into_owned()]);
    arguments.concat()
}

#[test]
fn window_and_process_write_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    write_logs(folder, &[("first.sl2", 0.0), ("second.sl2", 0.20)]);
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    app.apply(Command::Open(folder.join("first.sl2")));
    wait(&mut app);
    let arguments = everything_at_once(&mut app, folder);
    let [by_window, by_process] = ["window", "process"].map(|name| folder.join(name));
    app.apply(Command::Write(FileToWrite::Products(by_window.clone())));
    wait(&mut app);
    let mut args: Vec<&str> = arguments.iter().map(String::as_str).collect();
    args.extend(["--no-objects", "-o", "process"]);
    run(folder, &args);

    // Every product but what a search finds, which the window does elsewhere.
    assert_same(&by_window, &by_process, |row| row.when != When::Searched);
    let report = report(&by_window);
    let warnings = report["warnings"].to_string();
    assert!(warnings.contains("first fix"), "{warnings}");
    assert!(report["settings"]["bottom"].is_object(), "no bottom edits");
    let page = std::fs::read_to_string(by_window.join("report.html")).unwrap();
    assert!(page.contains("1 accepted, 0 added, 1 rejected, 1 undecided"));
}

/// Waits until every log has the results of its settings.
fn settle(app: &mut App) {
    wait(app);
    while app.logs.visible().any(|log| log.is_behind()) {
        std::thread::sleep(std::time::Duration::from_millis(2));
        app.poll();
        wait(app);
    }
}

/// Gives the shown log settings.
fn set(app: &mut App, assignments: &[&str]) {
    let mut settings = Settings::clone(&app.logs.shown.settings);
    for assignment in assignments {
        settings = settings.with_assignment(assignment).expect("a setting");
    }
    app.apply(Command::Change { settings: Box::new(settings), label: "a test", live: false });
    settle(app);
}

/// Gives the shown log boxes, two of three decided.
fn decide(app: &mut App, path: &Path) {
    decided_boxes(app, path);
    app.apply(Command::OpenFile(FileToOpen::Review(path.to_owned())));
    settle(app);
}

/// A survey of two logs, each with settings and boxes of its own, kept as a project.
fn survey_of_two(folder: &Path) -> App {
    write_logs(folder, &[("first.sl2", 0.0), ("second.sl2", 0.20)]);
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    let logs = ["first.sl2", "second.sl2"].map(|name| folder.join(name));
    app.apply(Command::OpenAll(logs.to_vec()));
    settle(&mut app);
    app.apply(Command::Write(FileToWrite::Project(folder.join("survey.bathyscope"))));
    settle(&mut app);
    let ids: Vec<LogId> = app.logs.all().map(|log| log.id).collect();
    set(&mut app, &["first_return.threshold=0.33"]);
    app.apply(Command::DrawBottom(BottomStroke {
        side: Side::Port,
        path: vec![[40.0, 4.0], [60.0, 3.5]],
        ink: Ink::Bottom,
    }));
    settle(&mut app);
    decide(&mut app, &folder.join("first-boxes.json"));
    app.apply(Command::ShowLog(ids[1]));
    set(&mut app, &["draft_m=0.3"]);
    app.apply(Command::Exclude {
        log: ids[1],
        part: LogPart::Pings([100, 139]),
        edit: ExclusionEdit::Exclude,
    });
    decide(&mut app, &folder.join("second-boxes.json"));
    app.apply(Command::ShowLog(ids[0]));
    settle(&mut app);
    app
}

#[test]
fn window_and_process_write_the_same_bytes_of_several_logs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let mut app = survey_of_two(folder);
    app.apply(Command::SaveProject);
    write_logs(folder, &[("reference.sl2", 0.10)]);
    let process = "process reference.sl2 --no-objects --products cloud -o reference";
    run(folder, &process.split(' ').collect::<Vec<_>>());
    let reference = folder.join("reference/points/cloud.ply");
    app.apply(Command::CompareWith(reference.clone()));
    settle(&mut app);
    let [by_window, by_process] = ["window", "process"].map(|name| folder.join(name));
    app.apply(Command::Write(FileToWrite::Products(by_window.clone())));
    settle(&mut app);
    let process = ["process", "survey.bathyscope", "--no-objects", "-o", "process"];
    let compared = ["--reference", &reference.to_string_lossy()];
    run(folder, &[&process[..], &compared].concat());
    assert_same(&by_window, &by_process, |row| row.when != When::Searched);
    let report = report(&by_window);
    let logs = report["logs"]["logs"].as_array().expect("logs");
    assert_eq!(logs.len(), 2);
    assert_eq!(logs[1]["counts"]["excluded_pings"], 40);
    let statement = |log: usize| logs[log]["statement"].to_string();
    assert!(statement(1).contains("0.3 m") && !statement(0).contains("0.3 m"));
    let own = logs[1]["own_settings"].as_object().expect("settings");
    let keys: Vec<&str> = own.keys().map(String::as_str).collect();
    assert_eq!(keys[..2], ["bottom", "draft_m"], "{own:?}");
    assert!(own["bottom"].is_null(), "only the first was drawn on");
    // A box of the second lies in the stretch that is excluded, and one of the others is rejected
    // in either.
    let page = std::fs::read_to_string(by_window.join("report.html")).unwrap();
    assert!(page.contains("2 accepted, 0 added, 2 rejected, 2 undecided"));
    let of_log = |name: &str| page.contains(&format!("<h3>{name}</h3>"));
    assert!(of_log("first") && of_log("second"));
}

#[test]
fn the_plane_stays_whatever_log_comes_first_or_is_hidden() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let mut app = survey_of_two(folder);
    let ids: Vec<LogId> = app.logs.all().map(|log| log.id).collect();
    // The log that was opened first, whose plane it is, is the second now and does not count in the
    // end.
    let changes = [
        ("moved", Command::MoveLog(ids[1], -1)),
        ("hidden", Command::SetLogVisible(ids[0], false)),
    ];
    for (name, change) in changes {
        app.apply(change);
        settle(&mut app);
        app.apply(Command::SaveProject);
        settle(&mut app);
        let [by_window, by_process] = ["window", "process"].map(|by| folder.join(by).join(name));
        app.apply(Command::Write(FileToWrite::Products(by_window.clone())));
        settle(&mut app);
        let into = by_process.to_string_lossy();
        run(folder, &["process", "survey.bathyscope", "--no-objects", "-o", &into]);
        let is_written = |row: &&OutputFile| matches!(row.when, When::Always | When::Chosen(_));
        assert_same(&by_window, &by_process, is_written);
        let project = std::fs::read_to_string(folder.join("survey.bathyscope")).unwrap();
        assert!(project.contains("\norigin = ["), "{project}");
    }
    // Opened again, the window has the same plane.
    let origin = app.logs.with_results()[0].log.survey.track.frame.origin();
    // Its own window keeps the project until then.
    drop(app);
    let mut again = App::new(Jobs::Threads(Arc::new(|| ())));
    again.apply(Command::Open(folder.join("survey.bathyscope")));
    settle(&mut again);
    assert_eq!(again.logs.with_results()[0].log.survey.track.frame.origin(), origin);
}
