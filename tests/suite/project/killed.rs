//! A program that edits and saves a project, killed at any moment: the project opens, what it told of is there, and at most one gesture
//! is there of which it did not tell yet. The log's bytes stay.
//!
//! The program is this test itself: with [`FOLDER`] in its environment it edits until it is killed.

use super::{path, renamed, saved};
use crate::support::Moments;
use bathyscope::detection::Mark;
use bathyscope::detection::review::{BoxId, Edit};
use bathyscope::project::{Change, Project, Store};
use bathyscope::survey::Side;
use sha2::{Digest as _, Sha256};
use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Kills of the test; `BATHYSCOPE_KILLS` asks for more.
const KILLS: usize = 6;
/// Where the program that is killed works.
const FOLDER: &str = "BATHYSCOPE_KILLED_PROJECT";
/// Saves after so many gestures.
const SAVE_EVERY: usize = 5;
/// The longest that a program edits, milliseconds.
const LONGEST_MS: f64 = 120.0;

/// The gesture of a number. The log's name holds the number, so that every state says how far it came.
fn gesture(project: &Project, number: usize) -> Project {
    let project = renamed(project, &number.to_string());
    let log = project.logs()[0].key.clone();
    let from = number % 200;
    let mark = Mark {
        side: Side::Port,
        pings: from..from + 3,
        near_m: 1.5,
        far_m: 2.5 + number as f64,
    };
    let last = project.logs()[0].review.next_id().0.saturating_sub(1);
    let edit = match number % 3 {
        0 => Edit::Reject(BoxId(last)),
        _ if number > 40 => Edit::Reshape(BoxId(1 + (number % 9) as u32), mark),
        _ => Edit::Add { mark, class: 0 },
    };
    let change = Change::Box { log, edit };
    project.apply(&change).unwrap_or(project)
}

fn number_of(project: &Project) -> usize {
    project.logs()[0].name.parse().unwrap_or(0)
}

/// The project that the gestures up to a number make of one.
fn after(project: &Project, number: usize) -> Project {
    let missing = number_of(project) + 1..=number;
    missing.fold(project.clone(), |project, number| gesture(&project, number))
}

/// Edits and saves, and tells of each gesture that it has written.
fn edit(folder: &Path) {
    let mut opened = Store::open(&path(folder)).expect("a project");
    let mut out = std::io::stdout();
    for number in number_of(&opened.project) + 1.. {
        opened.project = gesture(&opened.project, number);
        opened
            .store
            .record(&opened.project, "gesture")
            .expect("a line");
        writeln!(out, "did {number}").expect("a pipe");
        out.flush().expect("a pipe");
        if number % SAVE_EVERY == 0 {
            opened.store.save(&opened.project).expect("a save");
        }
    }
}

/// Starts a program that edits, kills it at a moment, and gives the last gesture that it told of.
fn killed(folder: &Path, moment: Duration) -> Option<usize> {
    let name = "project::killed::a_killed_program_loses_its_last_gesture_at_most";
    let mut child = Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", name, "--nocapture", "--test-threads=1"])
        .env(FOLDER, folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("this test again");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe"))
        .lines()
        .map_while(Result::ok);
    // From its first word on: starting takes longer than editing.
    let first = lines.find_map(|line| told(&line));
    std::thread::sleep(moment);
    child.kill().expect("a program that edits");
    child.wait().expect("a program that was killed");
    // The last line may be cut; `did 12` of `did 123` would be taken for less than was told.
    lines.filter_map(|line| told(&line)).last().or(first)
}

fn told(line: &str) -> Option<usize> {
    // The harness of the tests writes before it on the same line.
    line.rsplit_once("did ")?.1.parse().ok()
}

#[test]
fn a_killed_program_loses_its_last_gesture_at_most() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        return edit(Path::new(&folder));
    }
    let asked = std::env::var("BATHYSCOPE_KILLS").ok();
    let kills = asked.and_then(|text| text.parse().ok()).unwrap_or(KILLS);
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (store, mut last) = saved(folder);
    drop(store);
    let log = fs::read(folder.join("pond.sl2")).expect("a log");
    let hash = Sha256::digest(&log);
    let mut moments = Moments(15);
    let (mut unsaved, mut ahead) = (0, 0);
    for kill in 0..kills {
        let moment = Duration::from_secs_f64(LONGEST_MS * 0.001 * moments.share());
        let reported =
            killed(folder, moment).unwrap_or_else(|| panic!("kill {kill}: it did nothing"));
        let in_file =
            number_of(&bathyscope::project::read(&path(folder)).expect("a whole project"));
        let opened = Store::open(&path(folder)).expect("a project");
        let there = number_of(&opened.project);
        // Of the last gesture it may not have reported yet.
        assert!(
            (reported..=reported + 1).contains(&there),
            "kill {kill}: it reported {reported}, {there} is there"
        );
        unsaved += usize::from(in_file < there);
        ahead += usize::from(there > reported);
        last = after(&last, there);
        assert_eq!(
            opened.project.to_text(folder),
            last.to_text(folder),
            "kill {kill}"
        );
        assert_eq!(
            Sha256::digest(fs::read(folder.join("pond.sl2")).expect("a log")),
            hash
        );
        let store = opened.store;
        // As it was found: what is not saved stays in the journal.
        drop(store);
    }
    println!(
        "{kills} kills: {unsaved} with gestures that were not saved, {ahead} before it could tell"
    );
    // Each program that saves takes away what those before it left half written; of the last one it may be there.
    let left = super::names(folder);
    let is_part = |name: &&String| name.ends_with(".bathyscope-part");
    assert!(left.iter().filter(is_part).count() <= 1, "{left:?}");
}
