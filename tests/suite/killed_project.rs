//! The program as the window drives it, killed at any moment while it edits and saves a project of
//! two logs: the project opens, what it told of is there, and at most one gesture is there of which
//! it did not tell yet. The bytes of the logs stay.
//!
//! The program is this test itself: with [`FOLDER`] in its environment it edits until it is killed.
//! What should be there is found by an own run of the same gestures that nobody kills.

use bathyscope::app::{
    Action, App, BottomStroke, Command, ExclusionEdit, FileToWrite, Ink, Jobs, LogId, Measure,
};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::{LogPart, Side};
use bathyscope_objects::Mark;
use bathyscope_objects::review::{BoxId, Edit};
use bathyscope_products::pipeline::Settings;
use bathyscope_products::project::Store;
use bathyscope_test_support::Moments;
use bathyscope_test_support::handmade::{sl2, survey_frames};
use sha2::{Digest as _, Sha256};
use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Arc;
use std::time::Duration;

/// Kills of the test; `BATHYSCOPE_KILLS` asks for more.
const KILLS: usize = 6;
/// Environment variable of the folder in which the program that is killed works.
const FOLDER: &str = "BATHYSCOPE_KILLED_PROJECT";
/// Environment variable of the project that it opens, and the gesture that it begins with.
const BEGINS: &str = "BATHYSCOPE_KILLED_BEGINS";
/// The longest that a program edits, milliseconds.
const LONGEST_MS: f64 = 400.0;
/// Kinds of gestures.
const KINDS: usize = 28;
/// The logs.
const LOGS: [(&str, i32); 2] = [("pond.sl2", 60), ("lake.sl2", 75)];

fn change(app: &App, assignment: &str, label: &'static str) -> Command {
    let settings = Settings::clone(&app.logs.shown.settings);
    let settings = settings.with_assignment(assignment).expect("a setting");
    Command::Change { settings: Box::new(settings), label, live: false }
}

/// The gesture of a number, as the window would ask for it. The commands depend on the number and
/// on what is open only.
fn gesture(app: &App, number: usize, folder: &Path) -> Command {
    let round = number / KINDS;
    let from = (7 * number) % 40;
    let ids: Vec<LogId> = app.logs.all().map(|log| log.id).collect();
    let other = ids[round % ids.len()];
    let part = LogPart::Pings([from, from + 5]);
    let exclude = |edit| Command::Exclude { log: other, part, edit };
    let mark = Mark {
        side: Side::Port,
        pings: from..from + 3,
        near_m: 1.5,
        far_m: 2.5 + 0.01 * number as f64,
    };
    let last = app.logs.shown.reviewing.review.next_id().0.saturating_sub(1);
    let edit = |edit| Command::Edit { edit, live: false };
    let corner = LonLat { lon_deg: 0.01 * from as f64, lat_deg: 0.001 * number as f64 };
    match number % KINDS {
        0 => change(app, &format!("first_return.threshold=0.{}", 20 + from), "threshold"),
        1 => change(app, &format!("draft_m=0.{}", 10 + from), "draft"),
        2 | 13 => exclude(ExclusionEdit::Exclude),
        3 => Command::DrawBottom(BottomStroke {
            side: Side::Starboard,
            path: vec![[from as f64, 3.0], [from as f64 + 6.0, 3.5]],
            ink: Ink::Bottom,
        }),
        4 | 22 => edit(Edit::Add { mark, class: 0 }),
        5 => edit(Edit::Accept(BoxId(last))),
        // What all logs share, and then what one log has for itself.
        6 if round.is_multiple_of(2) => change(app, "calibration.mode=flat_spot", "scale"),
        6 => Command::Do(Action::KeepRecordedRange),
        7 => Command::MoveLog(ids[0], 1),
        8 => Command::SetLogVisible(other, !round.is_multiple_of(3)),
        9 | 10 | 18 | 27 => Command::Do(Action::Undo),
        26 if ids.len() > 1 => Command::CloseLog(other),
        26 => Command::Add(LOGS.map(|(name, _)| folder.join(name)).to_vec()),
        11 => Command::Do(Action::Redo),
        12 => Command::Do(Action::MeasureDistance),
        14 | 15 => Command::Measure(Measure::Corner(corner)),
        16 => Command::Do(Action::EndFigure),
        17 => exclude(ExclusionEdit::Include),
        19 | 24 => Command::SaveProject,
        20 => Command::ShowLog(other),
        21 => Command::GoToStep(from % 6),
        23 => exclude(ExclusionEdit::Reset),
        _ if round.is_multiple_of(4) => {
            let name = ["one.bathyscope", "two.bathyscope"][round / 4 % 2];
            Command::Write(FileToWrite::Project(folder.join(name)))
        }
        _ => Command::Do(Action::RemoveFigure),
    }
}

fn is_idle(app: &App) -> bool {
    app.is_idle() && app.logs.visible().all(|log| !log.is_behind())
}

/// A program with a project open, its results made.
fn opened(project: &Path, jobs: Jobs) -> App {
    let mut app = App::new(jobs);
    app.apply(Command::Open(project.to_owned()));
    while app.files.project_saving.path().is_none() || !is_idle(&app) {
        app.poll();
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(app.logs.count() > 0, "{:?}", app.notices.shown());
    app
}

/// Edits and saves, and tells of each gesture that it has done. Results are made behind it, as in
/// the window.
fn edit(folder: &Path, begins: &str) {
    let (name, first) = begins.split_once(' ').expect("a project and a number");
    let first: usize = first.parse().expect("a number");
    let mut app = opened(&folder.join(name), Jobs::Threads(Arc::new(|| ())));
    let mut out = std::io::stdout();
    for number in first.. {
        let command = gesture(&app, number, folder);
        let renames = matches!(command, Command::Write(FileToWrite::Project(_)));
        let adds = matches!(command, Command::Add(_));
        // What is found in a log is known once its results are there.
        let finds = matches!(command, Command::Exclude { edit: ExclusionEdit::Include, .. });
        while finds && !is_idle(&app) {
            app.poll();
        }
        app.apply(command);
        app.poll();
        // Until the other file is there, what is done is kept in the one before. Saving goes on
        // behind the next gestures.
        while renames && app.is_keeping() || adds && !is_idle(&app) {
            app.poll();
        }
        writeln!(out, "did {number}").expect("a pipe");
        out.flush().expect("a pipe");
    }
}

/// Starts a program that edits, kills it at a moment, and gives the last gesture that it told of.
fn killed(folder: &Path, begins: &str, moment: Duration) -> Option<usize> {
    let name = "killed_project::a_killed_program_loses_its_last_gesture_at_most";
    let mut child = std::process::Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", name, "--nocapture", "--test-threads=1"])
        .env(FOLDER, folder)
        .env(BEGINS, begins)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("this test again");
    let mut lines =
        BufReader::new(child.stdout.take().expect("a pipe")).lines().map_while(Result::ok);
    // From its first word on: starting takes longer than editing.
    let first = lines.find_map(|line| edits_done(&line));
    std::thread::sleep(moment);
    child.kill().expect("a program that edits");
    child.wait().expect("a program that was killed");
    // The last line may be cut; `did 12` of `did 123` would be taken for less than was told.
    lines.filter_map(|line| edits_done(&line)).last().or(first)
}

fn edits_done(line: &str) -> Option<usize> {
    // The harness of the tests writes before it on the same line.
    line.rsplit_once("did ")?.1.parse().ok()
}

/// A project after a gesture.
struct State {
    /// File name of the project.
    name: String,
    text: String,
}

/// Copies a project with its journal and its history: undo goes back into these.
fn copy_project(from: &Path, into: &Path, name: &str) {
    for ending in ["", "-journal", "-history"] {
        let file = format!("{name}{ending}");
        fs::remove_file(into.join(&file)).ok();
        if from.join(&file).is_file() {
            fs::copy(from.join(&file), into.join(&file)).expect("a copy");
        }
    }
}

/// The states that gestures make of a project that nobody kills: one for each number from `first`
/// to `last`.
fn states(folder: &Path, name: &str, first: usize, last: usize) -> Vec<State> {
    let mut app = opened(&folder.join(name), Jobs::Inline);
    let numbers = first..=last;
    numbers
        .map(|number| {
            let command = gesture(&app, number, folder);
            app.apply(command);
            app.poll();
            while !is_idle(&app) {
                app.poll();
            }
            app.apply(Command::SaveProject);
            app.poll();
            let path = app.files.project_saving.path().expect("a project").to_owned();
            State {
                text: without_numbers(&fs::read_to_string(&path).expect("a project")),
                name: path.file_name().expect("a name").to_string_lossy().into_owned(),
            }
        })
        .collect()
}

/// Two small logs, and a project of them.
fn written(folder: &Path) -> PathBuf {
    for (name, pings) in LOGS {
        fs::write(folder.join(name), sl2(&survey_frames(pings))).expect("a log");
    }
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::OpenAll(LOGS.map(|(name, _)| folder.join(name)).to_vec()));
    while !is_idle(&app) {
        app.poll();
    }
    let project = folder.join("one.bathyscope");
    app.apply(Command::Write(FileToWrite::Project(project.clone())));
    while app.is_keeping() {
        app.poll();
    }
    assert_eq!(
        app.files.project_saving.path(),
        Some(project.as_path()),
        "{:?}",
        app.notices.shown()
    );
    project
}

fn hashes(folder: &Path) -> Vec<Vec<u8>> {
    let bytes = LOGS.map(|(name, _)| fs::read(folder.join(name)).expect("a log"));
    bytes.iter().map(|bytes| Sha256::digest(bytes).to_vec()).collect()
}

/// A project's text without the numbers of objects: they follow from the decisions, and are noted
/// with the gesture after they were made, whenever that was.
fn without_numbers(text: &str) -> String {
    let mut parts = text.split(" object = ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let rest = part.trim_start_matches(|letter: char| letter.is_ascii_digit());
        text + rest.strip_prefix(',').unwrap_or(rest)
    })
}

/// The project's text with what is in its journal; it must open.
fn found(folder: &Path, name: &str) -> (String, bool) {
    let path = folder.join(name);
    let in_file = bathyscope_products::project::read(&path).expect("a whole project");
    let opened = Store::open(&path).expect("a project");
    let text = opened.project.to_text(folder);
    // As it was found: what is not saved stays in the journal.
    let is_unsaved = text != in_file.to_text(folder);
    (without_numbers(&text), is_unsaved)
}

#[test]
fn a_killed_program_loses_its_last_gesture_at_most() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        let begins = std::env::var(BEGINS).expect("where it begins");
        return edit(Path::new(&folder), &begins);
    }
    let asked = std::env::var("BATHYSCOPE_KILLS").ok();
    let kills = asked.and_then(|text| text.parse().ok()).unwrap_or(KILLS);
    let [temporary, own] = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
    let [folder, own] = [temporary.path(), own.path()];
    written(folder);
    written(own);
    let hash = hashes(folder);
    let mut at =
        State { name: "one.bathyscope".to_owned(), text: found(folder, "one.bathyscope").0 };
    let mut next = 0;
    let mut moments = Moments(15);
    let (mut gestures, mut unsaved, mut ahead) = (0, 0, 0);
    for kill in 0..kills {
        let moment = Duration::from_secs_f64(LONGEST_MS * 0.001 * moments.share());
        let begins = format!("{} {next}", at.name);
        copy_project(folder, own, &at.name);
        let reported = killed(folder, &begins, moment)
            .unwrap_or_else(|| panic!("kill {kill}: it did nothing"));
        let states = states(own, &at.name, next, reported + 1);
        // Of the last gesture it may not have told yet.
        let there = [reported + 1, reported].into_iter().find(|number| {
            let state = &states[number - next];
            folder.join(&state.name).is_file() && found(folder, &state.name).0 == state.text
        });
        let Some(there) = there else {
            let state = &states[reported - next];
            assert_eq!(found(folder, &state.name).0, state.text, "kill {kill}, {reported}");
            panic!("kill {kill}: it told of {reported}, which is not there");
        };
        gestures += there + 1 - next;
        ahead += usize::from(there > reported);
        at = states.into_iter().nth(there - next).expect("a state");
        unsaved += usize::from(found(folder, &at.name).1);
        next = there + 1;
        assert_eq!(hashes(folder), hash, "kill {kill}");
    }
    println!(
        "{kills} kills over {gestures} gestures: {unsaved} with gestures that were not saved, {ahead} before it could tell"
    );
    assert!(gestures > kills, "it did nothing");
    // Each program that saves takes away what those before it left half written; of the last one it
    // may be there.
    let left = names(folder);
    let parts = left.iter().filter(|name| name.ends_with(".bathyscope-part"));
    // `.NAME.PROCESS.bathyscope-part`: it may have been saving one project as another.
    let programs: std::collections::BTreeSet<_> =
        parts.map(|name| name.rsplit('.').nth(1)).collect();
    assert!(programs.len() <= 1, "{left:?}");
}

/// The names of the files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
