//! Tests of projects on disk: opened, saved, after a killed program, open twice, changed by other
//! programs, in folders that cannot be written.

use super::changes::Change;
use crate::project::store::{StoreFault, read};
use crate::project::{self, LogFile, Project, ProjectLog, Store};
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::review::{BoxId, Edit};
use std::fs;
use std::path::{Path, PathBuf};

/// Version that this program writes; this folder has a file of each version.
const VERSION: u32 = 1;

/// Creates and saves a project of one log in a folder.
fn saved(folder: &Path) -> (Store, Project) {
    let log = folder.join("pond.sl2");
    fs::copy(bathyscope_test_support::demo_log(), &log).expect("a log");
    let survey = formats::open(&log, &Progress::new()).expect("a log");
    let file = LogFile::of(&survey, &Progress::new()).expect("a log");
    let project =
        Project::default().apply(&Change::Add(Box::new(ProjectLog::new(file)))).expect("a log");
    let store =
        Store::create(&folder.join("lake.bathyscope"), &project, Vec::new()).expect("a project");
    (store, project)
}

fn text(folder: &Path) -> String {
    fs::read_to_string(folder.join("lake.bathyscope")).expect("a project")
}

fn path(folder: &Path) -> PathBuf {
    folder.join("lake.bathyscope")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn renamed(project: &Project, name: &str) -> Project {
    let key = project.logs()[0].key.clone();
    project.apply(&Change::Rename(key, name.to_owned())).expect("a change")
}

fn name(project: &Project) -> &str {
    &project.logs()[0].name
}

#[test]
fn what_was_not_saved_is_taken_in_when_the_project_is_opened() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (mut store, project) = saved(folder);
    let text_before = text(folder);
    let first = renamed(&project, "first");
    store.record(&first, "rename pond").expect("a line");
    let second = renamed(&first, "second");
    store.record(&second, "rename first").expect("a line");
    assert!(store.is_unsaved(&second) && !store.is_unsaved(&project));
    // As after a killed program: nothing is cleaned up.
    let journal = folder.join("lake.bathyscope-journal");
    let left = fs::read(&journal).expect("a journal");
    drop(store);
    assert_eq!(fs::read(&journal).expect("a journal"), left);
    assert_eq!(text(folder), text_before);

    let opened = Store::open(&path(folder)).expect("a project");
    assert_eq!(name(&opened.project), "second");
    assert!(
        opened.notes.len() == 1 && opened.notes[0].starts_with("2 changes"),
        "{:?}",
        opened.notes
    );
    assert!(opened.notes[0].contains("rename first"), "{:?}", opened.notes);
    let mut store = opened.store;
    assert!(store.is_unsaved(&opened.project));
    // The changes stay unsaved, and survive another end of the program.
    drop(store);
    let opened = Store::open(&path(folder)).expect("a project");
    assert_eq!(name(&opened.project), "second");
    store = opened.store;
    store.save(&opened.project).expect("a save");
    assert!(!store.is_unsaved(&opened.project));
    drop(store);
    assert!(!journal.exists(), "{:?}", names(folder));
    let again = Store::open(&path(folder)).expect("a project");
    assert!(again.notes.is_empty() && name(&again.project) == "second");
    // Changes that are not to be kept are lost.
    let mut store = again.store;
    store.record(&renamed(&again.project, "third"), "rename").expect("a line");
    store.close(false);
    let kept = ["lake.bathyscope", "lake.bathyscope-history", "pond.sl2"];
    assert_eq!(names(folder), kept);
    assert_eq!(name(&read(&path(folder)).expect("a project")), "second");
}

#[test]
fn two_windows_do_not_have_one_project() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (store, project) = saved(folder);
    let error = Store::open(&path(folder)).expect_err("another window");
    assert!(matches!(error.what, StoreFault::Taken(_)), "{error}");
    let sentence = error.to_string();
    assert!(
        sentence.contains("open in another window") && sentence.contains("another name"),
        "{sentence}"
    );
    let over = Store::create(&path(folder), &project, Vec::new()).expect_err("another window");
    assert!(matches!(over.what, StoreFault::Taken(_)), "{over}");
    #[cfg(unix)]
    {
        // Through a link it is the same project.
        std::os::unix::fs::symlink(path(folder), folder.join("link.bathyscope")).expect("a link");
        let error = Store::open(&folder.join("link.bathyscope")).expect_err("another window");
        assert!(matches!(error.what, StoreFault::Taken(_)), "{error}");
    }
    // Reading needs no lock.
    assert_eq!(read(&path(folder)).expect("a project"), project);
    drop(store);
    Store::open(&path(folder)).expect("a project that nobody has");
}

#[test]
fn what_another_program_changed_is_not_written_over() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (mut store, project) = saved(folder);
    let theirs = text(folder).replace("name = \"pond\"", "name = \"theirs\"");
    fs::write(path(folder), &theirs).expect("a file");
    let ours = renamed(&project, "ours");
    store.record(&ours, "rename pond").expect("a line");
    let refused = store.save(&ours).expect_err("changed");
    assert!(matches!(refused.what, StoreFault::Changed), "{refused}");
    assert_eq!(text(folder), theirs);
    let other = folder.join("other.bathyscope");
    Store::create(&other, &ours, Vec::new()).expect("another file");
    assert_eq!(name(&read(&other).expect("a project")), "ours");
    drop(store);

    // The changes were made to another file: they are kept in a file of their own, not applied.
    let opened = Store::open(&path(folder)).expect("a project");
    assert_eq!(name(&opened.project), "theirs");
    assert!(opened.notes.len() == 1 && opened.notes[0].contains("-older"), "{:?}", opened.notes);
    assert!(names(folder).iter().any(|name| name.contains("-older")), "{:?}", names(folder));
}

#[test]
fn a_folder_that_cannot_be_written_is_told() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (store, project) = saved(folder);
    drop(store);
    // A folder is in place of the journal, since the root user of a container can write into any
    // folder.
    fs::create_dir(folder.join("lake.bathyscope-journal")).expect("a folder");
    let refused = Store::open(&path(folder)).expect_err("no journal");
    assert!(matches!(refused.what, StoreFault::NotWritable(_)), "{refused}");
    assert!(refused.to_string().contains("save it under another name"), "{refused}");
    assert_eq!(read(&path(folder)).expect("a project"), project);
}

#[test]
fn a_project_is_no_log_and_a_log_no_project() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (store, project) = saved(folder);
    let log = folder.join("pond.sl2");
    let before = fs::read(&log).expect("a log");
    let refused = Store::create(&log, &project, Vec::new()).expect_err("a log");
    assert!(matches!(refused.what, StoreFault::Name), "{refused}");
    #[cfg(unix)]
    {
        let linked = folder.join("pond.bathyscope");
        std::os::unix::fs::symlink(&log, &linked).expect("a link");
        let refused = Store::create(&linked, &project, Vec::new()).expect_err("a log");
        assert!(matches!(refused.what, StoreFault::Name), "{refused}");
        let refused = Store::open(&linked).expect_err("a log");
        assert!(matches!(refused.what, StoreFault::Text(_)), "{refused}");
    }
    drop(store);
    assert_eq!(fs::read(&log).expect("a log"), before);
    assert!(names(folder).iter().all(|name| !name.contains("journal")), "{:?}", names(folder));
    assert!(Store::open(&folder.join("none.bathyscope")).is_err());
}

/// Tests that a newer project is refused and stays unchanged, with the files beside it.
#[test]
fn a_newer_project_is_not_written_over() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let newer = format!("bathyscope = {}\n\nfuture = true\n", VERSION + 1);
    fs::write(path(folder), &newer).expect("a file");
    let refused = Store::open(&path(folder)).expect_err("a newer one").to_string();
    assert!(refused.contains("newer Bathyscope") && !refused.contains('\n'), "{refused}");
    assert_eq!(text(folder), newer);
    assert_eq!(names(folder), ["lake.bathyscope"]);
}

/// Tests that a project of every version can be opened; each new version adds a file of the one
/// before.
#[test]
fn every_version_opens() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("project/tests");
    for version in 1..=VERSION {
        let temporary = tempfile::tempdir().expect("a folder");
        let file = here.join(format!("version_{version}.bathyscope"));
        fs::copy(&file, path(temporary.path())).expect("a project of that version");
        let opened = Store::open(&path(temporary.path())).expect("a project");
        let project = &opened.project;
        assert_eq!(project.logs().len(), 2, "{version}");
        let log = &project.logs()[0];
        assert_eq!((log.name.as_str(), log.is_visible), ("Chart 1", true));
        let settings = project.settings_of(log).expect("settings");
        assert_eq!((settings.draft_m, settings.first_return.threshold), (0.3, 0.41));
        assert_eq!(settings.bottom.ping_count(), 12);
        let decided = log
            .review
            .get(BoxId(2))
            .map(|review_box| (review_box.state.name(), review_box.note.as_str()));
        assert_eq!(decided, Some(("accepted", "a \"wreck\"\nor so")));
        assert_eq!(project.measurements.len(), 1);
        // The saved project has this version, and the same content.
        let mut store = opened.store;
        store.save(project).expect("a save");
        let again = read(store.path()).expect("a project");
        assert_eq!(again.to_text(Path::new("/")), project.to_text(Path::new("/")));
    }
}

/// Tests journals that this program cannot have written, damaged in many ways.
#[test]
fn a_journal_of_nonsense_does_no_harm() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (mut store, project) = saved(folder);
    let edit = Edit::Add {
        mark: bathyscope_objects::Mark {
            side: bathyscope_log::survey::Side::Port,
            pings: 5..9,
            near_m: 1.0,
            far_m: 2.0,
        },
        class: 0,
    };
    let log = project.logs()[0].key.clone();
    let added = project.apply(&Change::Box { log, edit }).expect("a box");
    store.record(&added, "new box").expect("a line");
    let journal = folder.join("lake.bathyscope-journal");
    let good = fs::read(&journal).expect("a journal");
    store.close(true);
    let mut spoilt: Vec<Vec<u8>> =
        vec![Vec::new(), vec![0; 5000], vec![b'\n'; 5000], b"{}\n".to_vec()];
    for at in (0..good.len()).step_by(37) {
        let mut bytes = good.clone();
        bytes[at] = bytes[at].wrapping_add(1);
        spoilt.push(bytes);
    }
    for bytes in spoilt {
        fs::write(&journal, &bytes).expect("a file");
        let opened = Store::open(&path(folder)).expect("a project");
        let boxes = opened.project.logs()[0].review.boxes().len();
        assert!(boxes <= 1);
        opened.store.close(false);
    }
    fs::write(&journal, &good).expect("a file");
    let opened = Store::open(&path(folder)).expect("a project");
    assert_eq!(opened.project.logs()[0].review.boxes().len(), 1);
}

/// Tests that the inputs of a project are its visible logs, each with its own settings in place of
/// the shared ones.
#[test]
fn a_project_is_an_input_of_its_logs_wherever_they_lie() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = temporary.path();
    let (mut store, project) = saved(folder);
    let key = project.logs()[0].key.clone();
    let before = project.settings_of(&project.logs()[0]).expect("settings");
    let after = ["draft_m=0.4", "outliers.min_neighbors=7"];
    let after = after.iter().try_fold(before, |settings, text| settings.with_assignment(text));
    let change =
        Change::Settings { log: Some(key.clone()), after: Box::new(after.expect("settings")) };
    let project = project.apply(&change).expect("a change");
    store.save(&project).expect("a save");
    let day = folder.join("day 1");
    fs::create_dir(&day).expect("a folder");
    fs::rename(folder.join("pond.sl2"), day.join("pond.sl2")).expect("a log");
    let read = |folder: &Path| project::inputs(&path(folder), &Progress::new());
    let inputs = read(folder).expect("inputs");
    assert_eq!(inputs.len(), 1);
    let settings = &inputs[0].settings;
    assert_eq!((settings.draft_m, settings.outliers.min_neighbors), (0.4, 7));
    let log = &inputs[0].log.file.path;
    assert_eq!(*log, fs::canonicalize(day.join("pond.sl2")).expect("a log"));
    fs::remove_file(log).expect("a log");
    let sentence = read(folder).expect_err("no log").to_string();
    assert!(sentence.contains("`pond`") && sentence.contains("is not there"), "{sentence}");
    let hidden = project.apply(&Change::Show(key, false)).expect("a change");
    store.save(&hidden).expect("a save");
    let sentence = read(folder).expect_err("no log that is shown").to_string();
    assert!(sentence.contains("no log that is shown"), "{sentence}");
}
