//! A survey as a new user would work on it, from a folder of four logs to its products: a turn
//! excluded, a bottom corrected, heights compared and applied, objects of two logs reviewed; saved,
//! closed, opened again and written out. By mouse and keys wherever the system's own dialogs are
//! not in between.

use crate::bottom::draw;
use crate::exclusion_window::{click, on_map};
use crate::logs_window::{names, settle};
use crate::many_logs::{HIGHER_M, write_logs};
use crate::printing::name_file;
use crate::review::mouse::{at, drag};
use crate::window::{Window, app, drop_file, empty_window, open_section, open_step, press};
use bathyscope::app::{OpenLog, Tool, WorkStep};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{ExclusionReason, Identity, Side, turn_rates_deg_s};
use bathyscope_objects::review::{Review, State};
use bathyscope_objects::{Detection, Mark, Raster};
use bathyscope_products::pipeline::{self, Settings};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::fs;
use std::path::Path;

const LOGS: usize = 4;

fn log<'a>(window: &'a Window, name: &str) -> &'a OpenLog {
    let found = app(window).logs.all().find(|log| log.name() == name);
    found.expect("it is open")
}

fn show(window: &mut Window, name: &str) {
    window.get_by_label(&format!("Log {name}")).click();
    settle(window);
    press(window, Modifiers::NONE, Key::F);
    assert_eq!(app(window).logs.shown.name(), name);
}

/// A review file with what a model proposes in a log, as an earlier run of `detect` leaves it
/// beside the log.
fn propose(folder: &Path, name: &str) {
    let path = folder.join(format!("{name}.sl2"));
    let survey = formats::open(&path, &Progress::new()).expect("a log");
    let products = pipeline::run(&survey, &Settings::default(), None, &Progress::new(), |_| ())
        .expect("nobody cancels");
    let raster = Raster::new(&survey, &products.navigation, 0.04);
    let found = [60, 200].map(|ping| Detection {
        class: 0,
        score: 0.8,
        mark: Mark { side: Side::Starboard, pings: ping..ping + 14, near_m: 6.0, far_m: 8.0 },
    });
    let classes = vec!["object".to_owned()];
    let review = Review::new(Identity::of(&survey), classes.clone());
    let review = review.adopt("test model", &classes, &found, &raster, 0..usize::MAX);
    let kept = folder.join(format!("{name}.review.json"));
    fs::write(kept, review.to_json()).expect("a file");
}

/// First and last ping of the longest turn of a log.
fn turn_of(log: &OpenLog) -> [usize; 2] {
    let survey = log.survey.as_ref().expect("a log");
    let products = log.products.as_ref().expect("results");
    let times_s: Vec<f64> = survey.side_scan.iter().map(|ping| ping.time_s).collect();
    let rates = turn_rates_deg_s(&times_s, &products.navigation.pings);
    let mut longest = [0, 0];
    let mut start = 0;
    for same in rates.chunk_by(|one, other| (*one > 5.0) == (*other > 5.0)) {
        let turns = same[0] > 5.0;
        if turns && same.len() > longest[1] - longest[0] {
            longest = [start, start + same.len() - 1];
        }
        start += same.len();
    }
    assert!(longest[1] - longest[0] > 20, "{longest:?}");
    longest
}

fn kept_points(log: &OpenLog, [first, last]: [usize; 2]) -> usize {
    let products = log.products.as_ref().expect("results");
    let inside = |ping: u32| (first..=last).contains(&(ping as usize));
    (products.kept_points()).filter(|point| inside(point.ping)).count()
}

fn states(log: &OpenLog) -> Vec<State> {
    log.reviewing.review.boxes().map(|review_box| review_box.state).collect()
}

/// Returns the decisions about all logs, as far as they can be compared.
fn decisions(window: &Window) -> Vec<String> {
    let logs = app(window).logs.all().map(|log| {
        let settings = toml::to_string(&*log.settings).expect("settings are text");
        let exclusions = &log.exclusions().expect("a result").exclusions.stretches;
        let boxes: Vec<_> = log.reviewing.review.boxes().collect();
        format!("{} {} {settings} {exclusions:?} {boxes:?}", log.name(), log.is_visible)
    });
    logs.collect()
}

/// Rows of a table of several logs that are of one of them, with the columns that are asked for.
fn rows(table: &str, log: &str, columns: [&str; 2]) -> Vec<[String; 2]> {
    let header: Vec<&str> = table.lines().next().expect("a header").split(',').collect();
    let place = |name: &str| {
        let place = header.iter().position(|column| *column == name);
        place.unwrap_or_else(|| panic!("{name} in {header:?}"))
    };
    let [first, second] = columns.map(place);
    let own = place("log");
    let fields = table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let of_log = fields.filter(|fields| fields[own] == log);
    of_log.map(|fields| [fields[first].to_owned(), fields[second].to_owned()]).collect()
}

#[test]
fn four_logs_from_the_folder_to_the_products() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    write_logs(folder, LOGS);
    for name in ["lake-0", "lake-2"] {
        propose(folder, name);
    }
    let logs_before = crate::project_window::hashes(folder);

    // Opened: all of them are in the list and on the map, with the boxes that lay beside two of
    // them.
    let mut window = empty_window();
    drop_file(&mut window, folder.to_owned());
    settle(&mut window);
    assert_eq!(names(&window), ["lake-0", "lake-1", "lake-2", "lake-3"]);
    for name in names(&window) {
        window.get_by_label(&format!("Log {name}"));
    }
    assert_eq!(states(log(&window, "lake-2")), [State::Proposed; 2]);

    let turn = leave_a_turn_out(&mut window);
    correct_a_bottom(&mut window);
    let offsets = compare_heights(&mut window);
    review_two_logs(&mut window);

    // Kept: under a name that is asked for, then with one key.
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    let project = folder.join("lake.bathyscope");
    name_file(&mut window, "File to write, .bathyscope", &project, "Save");
    settle(&mut window);
    assert_eq!(app(&window).files.project_saving.path(), Some(project.as_path()));
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    settle(&mut window);
    assert!(app(&window).files.project_saving.is_unsaved());
    press(&mut window, Modifiers::COMMAND, Key::S);
    settle(&mut window);
    assert!(!app(&window).files.project_saving.is_unsaved());
    let text = fs::read_to_string(&project).expect("a project");
    for said in [
        format!("pings.{} = {{ last = {}, reason = \"drawn\" }}", turn[0], turn[1]),
        "height_offset_m = ".to_owned(),
        "port.".to_owned(),
        "state = \"accepted\"".to_owned(),
        "state = \"rejected\"".to_owned(),
        "state = \"added\"".to_owned(),
        "first_return.threshold = 0.31".to_owned(),
    ] {
        assert!(text.contains(&said), "{said}: {text}");
    }
    let left = decisions(&window);
    drop(window);

    // Opened again in another window: as it was left, and nothing beside the logs was needed.
    for name in ["lake-0", "lake-2"] {
        fs::remove_file(folder.join(format!("{name}.review.json"))).expect("no sidecar");
    }
    let mut window = empty_window();
    drop_file(&mut window, project);
    settle(&mut window);
    assert_eq!(decisions(&window), left);
    assert_eq!(app(&window).document.history.undo_label(), Some("threshold 0.31"));

    press(&mut window, Modifiers::COMMAND, Key::E);
    let out = folder.join("products");
    name_file(&mut window, "Folder to write into", &out, "Export");
    settle(&mut window);
    window.get_by_label_contains("Wrote ");
    check_products(&out, turn, &offsets);
    assert_eq!(crate::project_window::hashes(folder), logs_before);
}

/// Draws over the longest turn of a log that is not shown at first; what was excluded.
fn leave_a_turn_out(window: &mut Window) -> [usize; 2] {
    show(window, "lake-1");
    let [first, last] = turn_of(log(window, "lake-1"));
    assert!(kept_points(log(window, "lake-1"), [first, last]) > 0);
    press(window, Modifiers::NONE, Key::K);
    draw(window, Modifiers::NONE, (first as f64, 3.0), (last as f64, -3.0));
    settle(window);
    let found = log(window, "lake-1").exclusions().expect("found").clone();
    let [stretch] = found.exclusions.stretches[..] else {
        panic!("{:?}", found.exclusions.stretches)
    };
    assert_eq!(stretch.reason, ExclusionReason::Drawn);
    let turn = stretch.pings.expect("pings");
    assert!(turn[0].abs_diff(first) <= 3 && turn[1].abs_diff(last) <= 3);
    assert_eq!(kept_points(log(window, "lake-1"), turn), 0);
    // What the analyst sees of it: the list, the count, the waterfall.
    open_section(window, WorkStep::Correct, "Excluded");
    window.get_by_label(&format!("Stretch drawn {}..{}", turn[0], turn[1]));
    window.get_by_label_contains("1 drawn stretch: ");
    window.get_by_label_contains(", 1 stretch excluded, excluding stretches");
    open_step(window, WorkStep::Logs);

    // Another turn on the map, of a log that is not shown; a slip, taken back with a click.
    let id = log(window, "lake-3").id;
    let other = turn_of(log(window, "lake-3"));
    press(window, Modifiers::NONE, Key::Escape);
    let [from, to] = other.map(|ping| on_map(window, id, ping));
    press(window, Modifiers::NONE, Key::K);
    assert_eq!(app(window).logs.shown.reviewing.tool, Tool::Exclude);
    drag(window, from, to);
    settle(window);
    let slip = log(window, "lake-3").exclusions().expect("found").clone();
    assert_eq!(slip.exclusions.stretches.len(), 1);
    let [first, last] = slip.exclusions.stretches[0].pings.expect("pings");
    press(window, Modifiers::NONE, Key::Escape);
    let middle = on_map(window, id, usize::midpoint(first, last));
    press(window, Modifiers::NONE, Key::K);
    click(window, middle);
    settle(window);
    assert!(log(window, "lake-3").exclusions().expect("found").exclusions.is_empty());
    press(window, Modifiers::NONE, Key::Escape);
    turn
}

fn correct_a_bottom(window: &mut Window) {
    show(window, "lake-2");
    press(window, Modifiers::NONE, Key::Num1);
    press(window, Modifiers::NONE, Key::M);
    draw(window, Modifiers::NONE, (30.0, -5.0), (70.0, -5.5));
    settle(window);
    let edits = &log(window, "lake-2").settings.bottom;
    assert!((36..=46).contains(&edits.ping_count()), "{}", edits.ping_count());
    assert_eq!(app(window).document.history.undo_label(), Some("bottom of lake-2"));
    open_step(window, WorkStep::Bottom);
    window.get_by_label_contains("pings edited");
    open_step(window, WorkStep::Logs);
    let products = log(window, "lake-2").products.as_ref().expect("results");
    let survey = log(window, "lake-2").survey.as_ref().expect("a log");
    let pick = products.returns.port[50];
    let range_m = survey.span(50, Side::Port).expect("a side").range_m(f64::from(pick.sample));
    assert!((range_m - 5.25).abs() < 0.15, "{range_m}");
    press(window, Modifiers::NONE, Key::Escape);
}

/// The height offsets that were applied, in the order of the logs.
fn compare_heights(window: &mut Window) -> Vec<f64> {
    window.get_by_label("offset");
    window.get_all_by_label("Apply heights").next().expect("a button").click();
    settle(window);
    assert_eq!(app(window).document.history.undo_label(), Some("height offsets of 4 logs"));
    let offsets: Vec<f64> =
        app(window).logs.all().map(|log| log.settings.height_offset_m).collect();
    let mean_m = HIGHER_M[..LOGS].iter().sum::<f64>() / LOGS as f64;
    for (offset_m, higher_m) in offsets.iter().zip(HIGHER_M) {
        assert!((offset_m - (higher_m - mean_m)).abs() < 0.012, "{offsets:?}");
    }
    offsets
}

/// Accepts and rejects by key the boxes of two logs, one after the other, and draws a box in each.
fn review_two_logs(window: &mut Window) {
    const REVIEWED: [&str; 2] = ["lake-0", "lake-2"];
    show(window, "lake-2");
    press(window, Modifiers::NONE, Key::Tab);
    for key in [Key::A, Key::R, Key::A, Key::R] {
        press(window, Modifiers::NONE, key);
        settle(window);
    }
    let decided = REVIEWED.map(|name| states(log(window, name))).concat();
    let count = |state| decided.iter().filter(|decision| **decision == state).count();
    assert_eq!([State::Accepted, State::Rejected].map(count), [2, 2], "{decided:?}");
    for name in REVIEWED {
        show(window, name);
        press(window, Modifiers::NONE, Key::Escape);
        press(window, Modifiers::NONE, Key::F);
        press(window, Modifiers::NONE, Key::N);
        let (from, to) = (at(window, 120.0, -7.0), at(window, 150.0, -5.0));
        drag(window, from, to);
        settle(window);
        assert_eq!(states(log(window, name))[2..], [State::Added], "{name}");
        let label = format!("new box 3 of {name}");
        assert_eq!(app(window).document.history.undo_label(), Some(&*label));
    }
    assert!(states(log(window, "lake-1")).is_empty());
}

fn check_products(out: &Path, turn: [usize; 2], offsets: &[f64]) {
    let table = fs::read_to_string(out.join("points/first_returns.csv")).expect("a table");
    let exclusions = rows(&table, "lake-1", ["ping", "excluded"]);
    let drawn = exclusions.iter().filter(|[_, reason]| reason == "drawn");
    let drawn: Vec<usize> = drawn.map(|[ping, _]| ping.parse().expect("a ping")).collect();
    assert_eq!(drawn, (turn[0]..=turn[1]).collect::<Vec<_>>());
    for other in ["lake-0", "lake-2", "lake-3"] {
        let reasons = rows(&table, other, ["ping", "excluded"]);
        assert!(!reasons.is_empty() && reasons.iter().all(|[_, reason]| reason.is_empty()));
    }
    // The ranges are those of the calibration; edits are certain.
    let edited = rows(&table, "lake-2", ["ping", "port_confidence"]);
    let certain = |ping: usize| edited[ping][1].parse::<f64>().expect("a number");
    assert_eq!(certain(50), 1.0);
    assert!((0..25).any(|ping| certain(ping) < 1.0));

    let report = fs::read_to_string(out.join("report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("a report");
    let logs = report["logs"]["logs"].as_array().expect("a report of each log");
    for (log, offset_m) in logs.iter().zip(offsets) {
        let in_force_m = log["height_offset_in_force_m"].as_f64().expect("a number");
        assert!((in_force_m - offset_m).abs() < 1e-9, "{}: {in_force_m}", log["log"]);
    }
    assert_eq!(logs[1]["excluded"][0]["pings"], serde_json::json!(turn));
    assert_eq!(report["counts"]["excluded_pings"], turn[1] + 1 - turn[0]);
    for name in [
        "depth/depth.tif",
        "points/cloud.copc.laz",
        "isobaths/isobaths.geojson",
        "mosaic/mosaic.tif",
    ] {
        let size = fs::metadata(out.join(name)).map_or(0, |file| file.len());
        assert!(size > 100, "{name}");
    }
}
