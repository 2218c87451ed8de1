use super::*;
use bathyscope_bottom::first_return::{BottomEdit, BottomSettings};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::Side;
use bathyscope_objects::Mark;
use bathyscope_objects::review::{BoxId, Certainty, Edit, Review};
use changes::Change;
use std::process::Command;

mod changes;
mod on_disk;

/// Creates a log of 500 pings that needs no file.
fn log(name: &str) -> ProjectLog {
    let sha256 = crate::pipeline::in_hexadecimal(&<sha2::Sha256 as sha2::Digest>::digest(name));
    ProjectLog::new(LogFile {
        path: PathBuf::from(format!("/lake/day 1/{name}.sl2")),
        sha256,
        byte_count: 1000,
        pings: 500,
    })
}

fn mark(from: usize) -> Mark {
    Mark { side: Side::Port, pings: from..from + 10, near_m: 4.25, far_m: 6.1 }
}

fn with_boxes(log: &ProjectLog, count: usize) -> Arc<Review> {
    let text = r#"{"version":1,"survey":{"file":"","byte_count":1000,"pings":500},"classes":["rock","tyre"],
        "searched":[{"model":"demo","pings":[0,400]}],"boxes":[BOXES]}"#;
    let boxes = (1..=count).map(|number| {
        let from = 7 * number % 480;
        format!(r#"{{"id":{number},"side":"port","pings":[{from},{}],"near_m":4.5,"far_m":6.25,"class":"rock","score":0.91,"state":"proposed","model":"demo"}}"#, from + 5)
    });
    let boxes: Vec<String> = boxes.collect();
    let read = Review::from_json(&text.replace("BOXES", &boxes.join(",")), &log.file.identity());
    Arc::new(read.expect("a review"))
}

fn line(side: Side, pings: [usize; 2]) -> BottomEdit {
    BottomEdit {
        side,
        pings,
        corners: vec![[pings[0] as f64, 4.2], [pings[1] as f64 + 1.0, 4.45]],
        accepted: false,
    }
}

fn bottom(lines: &[BottomEdit]) -> BottomSettings {
    let empty =
        BottomSettings { log_bytes: 1000, pings: 500, swapped_sides: false, lines: Vec::new() };
    lines.iter().fold(empty, |all, line| all.with(line.clone()))
}

/// Creates a project with content of every kind.
fn full() -> Project {
    let mut project = Project::default();
    project.settings.first_return.threshold = 0.41;
    project.settings.isobaths.interval_m = Some(0.5);
    let mut first = log("Chart 1");
    first.colour = Some([0xd9, 0x5f, 0x02]);
    first.settings.set("draft_m", Value::Float(0.3));
    first.settings.set("calibration.pings", Value::String("100..200".to_owned()));
    first.settings.set("track.file", Value::String("/lake/tracks/gps.csv".to_owned()));
    first.settings.bottom = bottom(&[line(Side::Port, [10, 20]), line(Side::Starboard, [3, 3])]);
    let stretches = r#"[{ pings = [30, 40], reason = "turn" }, { reason = "bad", time_s = [1.5, 2.0] }, { reason = "drawn", time_s = [1.5, 7.0] }]"#;
    let stretches = row::parse_value(stretches).expect("stretches");
    first.settings.set("excluded.stretches", stretches);
    let identity = Value::try_from(first.file.identity()).expect("an identity");
    first.settings.set("excluded.log", identity);
    first.review = with_boxes(&first, 12);
    let mut second = log("pond");
    second.is_visible = false;
    second.name = "the \"pond\"\nin June".to_owned();
    let logs = [first, second].into_iter();
    let mut project = logs.fold(project, |project, log| project.with_log(log).expect("a log"));
    project.files.insert("base_map".to_owned(), PathBuf::from("/maps/aerial.tif"));
    let at = |lon_deg, lat_deg| LonLat { lon_deg, lat_deg };
    let measurement = Measurement::new(MeasurementKind::Distance);
    let measurement = measurement.with(at(-111.5, 36.8), None).with(at(-111.25, 36.9), None);
    project.measurements.insert(1, measurement);
    project.origin = Some(LonLat { lon_deg: -82.110_223, lat_deg: 29.409_962 });
    project.set_view("map", &["depth", "track"]);
    project
}

fn folder() -> &'static Path {
    Path::new("/lake")
}

fn read(text: &str) -> Result<Project, ProjectError> {
    Project::from_text(text, folder())
}

/// Returns the lines that only one of two texts has, for each text; a line that occurs twice counts
/// twice.
fn lines_that_differ(one: &str, other: &str) -> [Vec<String>; 2] {
    let only = |one: &str, other: &str| {
        let mut there: Vec<&str> = other.lines().collect();
        let is_new = |line: &&str| match there.iter().position(|there| there == line) {
            Some(at) => {
                there.remove(at);
                false
            }
            None => true,
        };
        one.lines().filter(is_new).map(str::to_owned).collect()
    };
    [only(one, other), only(other, one)]
}

#[test]
fn a_project_comes_back_from_its_text() {
    let project = full();
    let text = project.to_text(folder());
    assert_eq!(read(&text).expect("a project"), project);
    // The whole text is valid TOML.
    let table: Table = text.parse().expect("TOML");
    let settings = project.settings_of(&project.logs()[0]).expect("settings");
    assert_eq!(settings.excluded.stretches.len(), 3);
    for line in [
        "pings.30 = { last = 40, reason = \"turn\" }",
        "time_s.\"1.5 2\" = { last = 7.0, reason = \"drawn\" }",
    ] {
        assert!(text.lines().any(|there| there == line), "{text}");
    }
    assert_eq!(table["settings"]["first_return"]["threshold"].as_float(), Some(0.41));
    let key = project.logs()[0].key.as_str();
    assert!(key.starts_with("chart_1-"), "{key}");
    let log = &table["log"][key];
    assert_eq!(log["file"].as_str(), Some("day 1/Chart 1.sl2"));
    assert_eq!(log["settings"]["track"]["file"].as_str(), Some("tracks/gps.csv"));
    assert_eq!(log["box"]["12"]["score"].as_float(), Some(0.91));
    assert_eq!(table["file"]["base_map"].as_str(), Some("../maps/aerial.tif"));
    // The text of a project that was moved with its logs has the same meaning in the new folder.
    let moved = Project::from_text(&text, Path::new("/else/where")).expect("a project");
    assert_eq!(moved.logs()[0].file.path, Path::new("/else/where/day 1/Chart 1.sl2"));
    assert_eq!(moved.to_text(Path::new("/else/where")), text);
}

/// Tests that the lines are those of the file's documentation: another form of writing would change
/// every project file.
#[test]
fn the_text_of_a_project_stays_as_it_is() {
    let mut project = full();
    project.settings = Settings::default();
    let text = project.to_text(folder());
    let (head, rest) = text.split_once("\n[settings]\n").expect("settings");
    assert_eq!(head.lines().nth(1), Some("bathyscope = 1"));
    let (_, rest) = rest.split_once("\n[file]\n").expect("files");
    let hash = &project.logs()[0].file.sha256;
    let key = project.logs()[0].key.as_str();
    let expected = format!(
        r##"
base_map = "../maps/aerial.tif"

[log.{key}]

bytes = 1000

classes = ["rock", "tyre"]

colour = "#d95f02"

file = "day 1/Chart 1.sl2"

name = "Chart 1"

order = 1.0

pings = 500

sha256 = "{hash}"

[log.{key}.bottom]

port.10 = {{ corners = [[10.0, 4.2], [21.0, 4.45]], last = 20 }}

starboard.3 = {{ corners = [[3.0, 4.2], [4.0, 4.45]], last = 3 }}

[log.{key}.box]

1 = {{ class = "rock", edited = false, far_m = 6.25, model = "demo", near_m = 4.5, pings = [7, 12], score = 0.91, side = "port", state = "proposed" }}
"##
    );
    assert!(rest.starts_with(&expected), "{rest}");
}

#[test]
fn what_this_version_does_not_know_is_kept() {
    let project = full();
    let key = project.logs()[0].key.clone();
    let text = project.to_text(folder());
    let with_more = text
        .replace("\n12 = { ", "\n12 = { depth_of_interest_m = 3.5, ")
        .replace("\norder = 1.0\n", "\norder = 1.0\n\nmood = \"calm\"\n")
        .replace("\n[file]\n", "\ntracker.colour = \"red\"\n\n[file]\n")
        + &format!(
            "\n[log.{key}.breeze]\n\n100 = 7.5\n\n[zones]\n\nharbour = {{ kind = \"shallow\" }}\n"
        );
    let read_back = read(&with_more).expect("a project");
    let written = read_back.to_text(folder());
    for line in [
        "mood = \"calm\"",
        "tracker.colour = \"red\"",
        "100 = 7.5",
        "harbour = { kind = \"shallow\" }",
    ] {
        assert!(written.lines().any(|there| there == line), "{line}: {written}");
    }
    assert!(written.contains("depth_of_interest_m = 3.5"));
    assert_eq!(read(&written).expect("a project"), read_back);
    // A change of another line does not change the unknown lines; a removed box or log removes its
    // own.
    let edit = Edit::Accept(BoxId(12));
    let decided = read_back.apply(&Change::Box { log: key.clone(), edit }).expect("a change");
    let differ = lines_that_differ(&written, &decided.to_text(folder()));
    assert!(
        differ[1].len() == 1 && differ[1][0].contains("depth_of_interest_m = 3.5"),
        "{differ:?}"
    );
    let less = read_back.apply(&Change::Remove(key)).expect("a change").to_text(folder());
    assert!(
        !less.contains("calm") && !less.contains("breeze") && less.contains("harbour"),
        "{less}"
    );
}

#[test]
fn what_is_wrong_is_said_in_a_sentence_with_its_line() {
    let text = full().to_text(folder());
    let number_of = |requested: &str, text: &str| {
        let at = text.lines().position(|line| line.contains(requested));
        at.map_or(0, |at| at + 1)
    };
    for (from, to, words) in [
        ("bathyscope = 1", "bathyscope = \"1\"", "no project"),
        ("order = 1.0", "order = ", "string values must be quoted"),
        ("order = 1.0", "order = inf", "is a number"),
        ("order = 1.0", "<<<<<<< ours", "git"),
        ("order = 1.0", "order", "write key = value"),
        ("order = 1.0", "[order", "no heading"),
        ("order = 1.0", "pings = 500", "stands here and in line"),
        ("order = 1.0", "colour = \"red\"", "stands here and in line"),
        ("colour = \"#d95f02\"", "colour = \"red\"", "is written"),
        ("pings = [7, 12]", "pings = [700, 712]", "box 1: its pings or ranges lie outside the log"),
        ("pings = [7, 12]", "pings = [7]", "invalid length"),
        (
            "port.10 = {",
            "port.10 = { x = [[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]], ",
            "lists within lists",
        ),
        ("last = 20", "last = 5", "pings of bottom.lines"),
        ("last = 40", "last = 4", "excluded.stretches"),
        ("last = 40, ", "", "has no `last`"),
        ("reason = \"turn\"", "reason = \"fun\"", "a reason is `turn`"),
        ("first_return.threshold = 0.41", "first_return.threshold = 4.1", "between 0 and 1"),
        (
            "first_return.threshold = 0.41",
            "first_return.threshold = \"high\"",
            "first_return.threshold",
        ),
        ("draft_m = 0.3", "draft_m = \"deep\"", "draft_m"),
        ("29.409962", "99.4", "the origin is no longitude"),
    ] {
        assert!(text.contains(from), "{from}");
        let broken = text.replacen(from, to, 1);
        let line = number_of(from, &text);
        let error = read(&broken).expect_err(to);
        let sentence = error.to_string();
        assert!(sentence.contains(words) || words.starts_with("string"), "{to}: {sentence}");
        let named_line = match error {
            ProjectError::Line { line, .. } => line,
            ProjectError::Newer { .. } => 0,
        };
        // The error about a colour that occurs twice names the second line.
        assert!(
            named_line == line || sentence.contains("stands here"),
            "{to}: {sentence}, expected line {line}"
        );
        assert!(!sentence.contains('\n'));
    }
    let missing =
        text.lines().filter(|line| !line.starts_with("sha256")).collect::<Vec<_>>().join("\n");
    let sentence = read(&missing).expect_err("no hash").to_string();
    assert!(sentence.contains("has no `sha256`"), "{sentence}");
}

#[test]
fn a_newer_project_is_refused_whatever_is_in_it() {
    let text = "# later\n\nbathyscope = 2\n\n{{{ something else entirely\n";
    let error = read(text).expect_err("a newer one");
    assert_eq!(error, ProjectError::Newer { version: 2 });
    assert!(error.to_string().contains("newer Bathyscope"), "{error}");
    for text in ["", "# nothing\n", "bathyscope = 0\n", "bathyscope = -1\n", "<html>\n", "a = 1\n"]
    {
        assert!(matches!(read(text), Err(ProjectError::Line { .. })), "{text}");
    }
}

/// Tests that git merges the different decisions of two people into one file that contains both.
#[test]
fn git_merges_what_two_people_decided() {
    if Command::new("git").arg("--version").output().is_err() {
        eprintln!("git is not there: skipped");
        return;
    }
    let base = full();
    let [first, second] = [0, 1].map(|index| base.logs()[index].key.clone());
    let decide = |edit| Change::Box { log: first.clone(), edit };
    let settings = |key: &str, value: f64| {
        let text = format!("{key}={value}");
        let after = base.settings.with_assignment(&text).expect("a setting");
        Change::Settings { log: None, after: Box::new(after) }
    };
    // Neighbouring lines, and additions at different places.
    let ours = [
        decide(Edit::Accept(BoxId(5))),
        decide(Edit::Reject(BoxId(7))),
        settings("mosaic.cell_m", 0.5),
        Change::Rename(first.clone(), "ours".to_owned()),
        Change::Show(second.clone(), true),
    ];
    let theirs = [
        decide(Edit::Reject(BoxId(6))),
        decide(Edit::Note(BoxId(8), "theirs".to_owned())),
        decide(Edit::Add { mark: mark(50), class: 1 }),
        settings("mosaic.nadir_gap_deg", 7.0),
        Change::Rename(second, "theirs".to_owned()),
        Change::Colour(first.clone(), None),
    ];
    let apply = |project: Project, change: &Change| match change {
        // Only the one changed setting is applied to the current settings.
        Change::Settings { after, .. } => {
            let mut project = project;
            if after.mosaic.cell_m == base.settings.mosaic.cell_m {
                project.settings.mosaic.nadir_gap_deg = after.mosaic.nadir_gap_deg;
            } else {
                project.settings.mosaic.cell_m = after.mosaic.cell_m;
            }
            project
        }
        change => project.apply(change).expect("a change"),
    };
    let made = |changes: &[Change]| changes.iter().fold(base.clone(), apply);
    let folder_of_files = tempfile::tempdir().expect("a folder");
    let file = |name: &str, project: &Project| {
        let path = folder_of_files.path().join(name);
        std::fs::write(&path, project.to_text(folder())).expect("a file");
        path
    };
    let paths = [file("ours", &made(&ours)), file("base", &base), file("theirs", &made(&theirs))];
    let merged = Command::new("git").args(["merge-file", "-p"]).args(&paths).output().expect("git");
    let text = String::from_utf8(merged.stdout).expect("text");
    assert!(merged.status.success(), "{text}");
    let both = ours.iter().chain(&theirs).fold(base.clone(), apply);
    assert_eq!(text, both.to_text(folder()));
    assert_eq!(read(&text).expect("a project").to_text(folder()), text);
}

#[test]
fn a_log_is_in_a_project_once_and_moves_in_the_list() {
    let project = full();
    let again =
        LogFile { path: PathBuf::from("/copy/other name.sl2"), ..project.logs()[0].file.clone() };
    assert!(project.apply(&Change::Add(Box::new(ProjectLog::new(again)))).is_none());
    let mut project = project.apply(&Change::Add(Box::new(log("bay")))).expect("a log");
    let names = |project: &Project| -> Vec<String> {
        project.logs().iter().map(|log| log.name.chars().take(3).collect()).collect()
    };
    assert_eq!(names(&project), ["Cha", "the", "bay"]);
    // Moved again and again between the same two logs: after some fifty halvings there is no number
    // between, and all logs are numbered.
    for turn in 0..200 {
        let log = project.logs()[2].key.clone();
        let before = names(&project);
        project = project.apply(&Change::Move { log, to: 1 }).expect("a move");
        let expected = [0, 2, 1].map(|index: usize| before[index].clone());
        assert_eq!(names(&project), expected, "{turn}");
        let orders: Vec<f64> = project.logs().iter().map(|log| log.order).collect();
        assert!(orders.windows(2).all(|pair| pair[0] < pair[1]), "{orders:?}");
    }
}

/// Asserts that each change of the full project removes and adds this many lines, and that the
/// written text is read back unchanged.
fn assert_lines_changed<const N: usize>(changes: [(Change, [usize; 2]); N]) {
    let project = full();
    for (change, lines) in changes {
        let after = project.apply(&change).expect("a change");
        let differ = lines_that_differ(&project.to_text(folder()), &after.to_text(folder()));
        // Blank lines and headings are not counted.
        let count =
            differ.each_ref().map(|lines| lines.iter().filter(|line| line.contains(" = ")).count());
        assert_eq!(count, lines, "{change:?}: {differ:#?}");
        let back = read(&after.to_text(folder())).expect("a project");
        assert_eq!(back.to_text(folder()), after.to_text(folder()), "{change:?}");
    }
}

#[test]
fn one_decision_about_a_box_changes_one_line() {
    let key = full().logs()[0].key.clone();
    let id = BoxId(7);
    let add = Edit::Add { mark: mark(50), class: 1 };
    let set_edges = Edit::SetEdges { id, mark: mark(50), border_m: mark(50).near_m + 0.25 };
    let add_point = Edit::AddPoint { side: Side::Port, ping: 77, range_m: 6.5, class: 1 };
    let edits = [
        (Edit::Accept(id), [1, 1]),
        (Edit::Note(id, "a \"wreck\"\nor so".to_owned()), [1, 1]),
        (add, [0, 1]),
        (Edit::Rename(id, "Anna".to_owned()), [1, 1]),
        (Edit::Rate(id, Some(Certainty::Probable)), [1, 1]),
        (set_edges, [1, 1]),
        (add_point, [0, 1]),
        // The log has the new class from then on.
        (Edit::Classify(id, "steam tug".to_owned()), [2, 2]),
    ];
    let log = || key.clone();
    assert_lines_changed(edits.map(|(edit, lines)| (Change::Box { log: log(), edit }, lines)));
}

#[test]
fn one_decision_about_a_log_changes_one_line() {
    let key = full().logs()[0].key.clone();
    let move_down = Change::Move { log: key.clone(), to: 1 };
    let own = Change::Own { log: key.clone(), key: "outliers.min_neighbors".to_owned(), own: true };
    let draw = Change::Bottom { log: key.clone(), after: bottom(&[line(Side::Port, [10, 20])]) };
    assert_lines_changed([
        (Change::Rename(key.clone(), "Chart 2".to_owned()), [1, 1]),
        (Change::Show(key, false), [0, 1]),
        (move_down, [1, 1]),
        (own, [0, 1]),
        (draw, [1, 0]),
    ]);
}

#[test]
fn one_decision_about_the_survey_changes_one_line() {
    let project = full();
    let mut settings = project.settings.clone();
    settings.outliers.min_neighbors = 9;
    let set = Change::Settings { log: None, after: Box::new(settings) };
    let base_map = Some(PathBuf::from("/lake/b.tif"));
    assert_lines_changed([
        (Change::Measure(None, project.measurements[&1].clone()), [0, 1]),
        (Change::Forget(1), [1, 0]),
        (set, [1, 1]),
        (Change::File("base_map".to_owned(), base_map), [1, 1]),
    ]);
}
